//! Observers on a log, and the consistency of filters, as tables.

use std::fmt::Write as _;

use luenberger_figures::{Cell, Grid, Section};
use luenberger_proof::wording::{counted, significant};

use super::{SCORED, number};
use crate::results::{
    ConsistencyReport, CoverageReport, FilterReport, InnovationReport, IntervalReport, LogReport, ModelReport,
    PlantSummary,
};

/// What the regions of NIS and NEES are.
const REGION: &str = "Means of the normalised squares; the region is chi-squared, two-sided. Above it a filter is overconfident, below it conservative. Errors of successive samples are correlated: NEES of one run leaves its region more often.";

/// A size of errors, with three digits.
fn size(x: f64) -> Cell {
    Cell::number(significant(x, 3))
}

fn test(report: Option<&ConsistencyReport>) -> Cell {
    Cell::from(report.map_or_else(|| "-".to_owned(), ConsistencyReport::in_words).as_str())
}

/// The filters of a simulation.
pub(super) fn filters(section: Section, filters: &[FilterReport]) -> Section {
    let is_any = |stationary: bool| filters.iter().any(|filter| filter.stationary == stationary);
    let over = match (is_any(false), is_any(true)) {
        (true, false) => "over all their samples",
        (false, _) => "over the samples of the second half of the run, with their stationary covariances",
        (true, true) => {
            "over all their samples, of stationary ones, with their stationary covariances, of the second half of the run"
        }
    };
    consistency(section, filters, over)
}

/// The interval observers of a simulation.
pub(super) fn intervals(section: Section, intervals: &[IntervalReport], plant: &PlantSummary) -> Section {
    let mut grid = Grid::new(&["observer", "enclosed", "state", "mean width", "width at the end"])
        .caption("Bounds of interval observers.");
    for report in intervals {
        for ((state, mean), end) in plant.states.iter().zip(&report.mean_width).zip(&report.final_width) {
            grid = grid.row([
                Cell::from(report.observer.as_str()),
                Cell::from(report.coverage_in_words().as_str()),
                Cell::from(plant.labelled(state).as_str()),
                number(*mean),
                number(*end),
            ]);
        }
    }
    section.grid(grid).note("Enclosed: share of the samples at which all states were within their bounds. Below 100 % noise, disturbances or the first state were beyond `bounds` and `initial_bounds`.")
}

/// The probabilities of the models of filters.
pub(super) fn models(section: Section, reports: &[ModelReport]) -> Section {
    let caption = "Probabilities of the models between which filters decide, over the rows of the run.";
    let grid = Grid::new(&["filter", "model", "mean", "most probable", "at the end"]).caption(caption);
    section.grid(reports.iter().fold(grid, |grid, of| {
        grid.row([
            Cell::from(of.observer.as_str()),
            Cell::from(of.model.as_str()),
            size(of.mean),
            Cell::number(format!("{} %", significant(100.0 * of.most_probable, 3))),
            size(of.last),
        ])
    }))
}

/// How often errors were within the bands of the figures.
pub(super) fn coverage(section: Section, reports: &[CoverageReport], plant: &PlantSummary) -> Section {
    let expected = significant(100.0 * CoverageReport::EXPECTED, 3);
    let caption =
        "Share of the errors x - xhat within two standard deviations of the filter, the bands of the figures.";
    let mut note = format!(
        "{expected} % if its model of the noise is right and the errors are Gaussian. Above it a filter is conservative, \
         below it overconfident; errors of successive samples are correlated, so that one run is only near it."
    );
    if reports.iter().any(|report| report.on_log) {
        note.push_str(" On a log over its second half.");
    }
    if reports.iter().any(|report| report.stationary) {
        note.push_str(" The band of a stationary filter does not include the initial error.");
    }
    let grid = Grid::new(&["filter", "state", "samples", "within ± 2 sigma"]).caption(caption);
    let rows = reports.iter().flat_map(|report| report.states.iter().map(move |state| (report, state)));
    let grid = rows.fold(grid, |grid, (report, of)| {
        let name = if report.on_log { format!("{}, on the log", report.observer) } else { report.observer.clone() };
        grid.row([
            Cell::from(name.as_str()),
            Cell::from(plant.labelled(&of.state).as_str()),
            Cell::number(of.samples.to_string()),
            Cell::number(format!("{} %", significant(100.0 * of.within, 3))),
        ])
    });
    section.grid(grid).note(note)
}

fn consistency(section: Section, filters: &[FilterReport], over: &str) -> Section {
    let caption = format!("Consistency of the filters {over}: means with their 95 % acceptance regions.");
    let grid = Grid::new(&["filter", "NIS (innovations)", "NEES (errors)"]).caption(&caption);
    let row = |grid: Grid, filter: &FilterReport| {
        grid.row([Cell::from(filter.observer.as_str()), test(filter.nis.as_ref()), test(filter.nees.as_ref())])
    };
    section.grid(filters.iter().fold(grid, row)).note(REGION)
}

/// The observers on a log.
pub(super) fn log(mut section: Section, log: &LogReport, plant: &PlantSummary) -> Section {
    section = section.prose(data(log, plant.time_unit.as_deref()));
    let head = ["observer", "output", "samples", "mean", "rms", "largest", "whiteness test p-value (Ljung-Box)"];
    let mut grid = Grid::new(&head).caption("Innovations y - h(xhat) over the second half of the log.");
    let mut ended = Vec::new();
    for row in &log.rows {
        for output in &row.outputs {
            // No measurement, no mean.
            let size = |x: f64| if output.samples == 0 { Cell::number("-") } else { size(x) };
            grid = grid.row([
                Cell::from(row.observer.as_str()),
                Cell::from(plant.labelled(&output.output).as_str()),
                Cell::from(output.samples_in_words().as_str()),
                size(output.mean),
                size(output.rms),
                size(output.peak),
                Cell::from(output.whiteness_in_words().unwrap_or_else(|| "-".to_owned()).as_str()),
            ]);
        }
        ended.extend(row.failure.as_ref().map(|why| format!("{}: {why}", row.observer)));
    }
    section = section.grid(grid);
    let sampled: Vec<String> = log.rows.iter().filter_map(|row| Some(row.sampling.as_ref()?.words.clone())).collect();
    if !sampled.is_empty() {
        section = section.list(sampled);
    }
    let filters: Vec<FilterReport> = log.rows.iter().flat_map(InnovationReport::tests_of_estimates).collect();
    if !filters.is_empty() {
        section = self::consistency(section, &filters, "over the second half of the log");
    }
    if log.rows.iter().any(|row| !row.errors.is_empty()) {
        let head = ["observer", "state", "samples", "RMSE", "peak", "last"];
        let caption =
            format!("Errors x - xhat over the whole log, where it has the true state; {}.", log.estimates_in_words());
        let mut grid = Grid::new(&head).caption(caption);
        for (name, error) in log.rows.iter().flat_map(InnovationReport::errors_of_estimates) {
            grid = grid.row([
                Cell::from(name.as_str()),
                Cell::from(plant.labelled(&error.state).as_str()),
                Cell::from(error.samples.to_string().as_str()),
                number(error.rmse),
                number(error.peak),
                size(error.last),
            ]);
        }
        section = section.grid(grid);
    }
    section = last_estimates(section, log, plant);
    if log.rows.iter().any(|row| row.smoothed.is_some()) {
        let head = ["observer", "state", "filtered", "smoothed"];
        let mut grid = Grid::new(&head)
            .caption("Standard deviations that the filters compute for their errors, root mean square over the log.");
        for row in &log.rows {
            for of in row.smoothed.iter().flat_map(|smoothed| &smoothed.deviations) {
                grid = grid.row([
                    Cell::from(row.observer.as_str()),
                    Cell::from(plant.labelled(&of.state).as_str()),
                    size(of.filtered),
                    size(of.smoothed),
                ]);
            }
        }
        section =
            section.grid(grid).note("Filtered: from the measurements up to each time; smoothed: from the whole log.");
    }
    if !ended.is_empty() {
        section = section.prose("Ended early:").list(ended);
    }
    section
}

/// The estimates at the end of the log, of the states without a true value: estimated parameters are among them.
fn last_estimates(section: Section, log: &LogReport, plant: &PlantSummary) -> Section {
    let mut grid = Grid::new(&["observer", "state", "last estimate", "± 2 sigma"])
        .caption("Estimates at the end of the log, of the states of which it has no true value.");
    let (mut count, mut omitted) = (0, 0);
    for row in log.rows.iter().filter(|row| row.estimate.len() == plant.states.len()) {
        let is_unknown = |state: &String| row.errors.iter().all(|error| error.state != *state);
        let unknown = plant.states.iter().enumerate().filter(|(_, state)| is_unknown(state));
        omitted = unknown.clone().count().saturating_sub(SCORED).max(omitted);
        for (i, state) in unknown.take(SCORED) {
            count += 1;
            grid = grid.row([
                Cell::from(row.observer.as_str()),
                Cell::from(plant.labelled(state).as_str()),
                number(row.estimate[i]),
                row.deviation.get(i).map_or_else(|| Cell::from("-"), |sigma| size(2.0 * sigma)),
            ]);
        }
    }
    match (count, omitted) {
        (0, _) => section,
        (_, 0) => section.grid(grid),
        _ => section.grid(grid).prose(format!("`study.json` has the other {}.", counted(omitted, "state"))),
    }
}

/// What a log consists of, in sentences: rows, periods, outputs that are not always measured, interpolation.
pub fn data(log: &LogReport, unit: Option<&str>) -> String {
    let unit = unit.map(|unit| format!(" {unit}")).unwrap_or_default();
    let time = |t: f64| significant(t, 6);
    let mut text = format!(
        "Log of {} from t = {} to {}{unit}, median Ts {}{unit}.",
        counted(log.samples, "row"),
        time(log.start),
        time(log.end),
        time(log.median_period)
    );
    for column in &log.columns {
        let period = time(column.median_period);
        let rows = counted(column.samples, "row");
        _ = write!(text, " {} is measured in {rows} (median Ts {period}{unit}).", column.output);
    }
    text.push_str(match log.interpolation {
        "linear" => {
            " Between the rows outputs are interpolated linearly, as asked for; not across gaps and blank cells."
        }
        "held" => {
            " Only measurements correct the estimates. Observers in continuous time hold them between the rows, as asked for."
        }
        _ => " Only measurements correct the estimates; between them the observers predict.",
    });
    text
}
