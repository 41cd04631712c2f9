//! Observers on a log, and the consistency of filters, as text.

use super::columns::table;
use crate::numbers::{number, size};
use luenberger_proof::wording::significant;
use luenberger_study::Results;
use luenberger_study::results::{ConsistencyReport, FilterReport, InnovationReport, LogReport, PlantSummary, log_data};
use std::fmt::Write;

fn test(report: Option<&ConsistencyReport>) -> String {
    report.map_or_else(|| "-".to_owned(), ConsistencyReport::in_words)
}

fn header(names: &[&str]) -> Vec<Vec<String>> {
    vec![names.iter().map(|name| (*name).to_owned()).collect()]
}

/// The interval observers of a simulation.
pub(super) fn intervals(text: &mut String, results: &Results) {
    _ = writeln!(text, "\nbounds of interval observers");
    let mut rows = header(&["observer", "enclosed", "state", "mean width", "width at the end"]);
    for report in &results.intervals {
        for ((state, mean), end) in results.plant.states.iter().zip(&report.mean_width).zip(&report.final_width) {
            let numbers = [significant(*mean, 4), significant(*end, 4)];
            let names = [report.observer.clone(), report.coverage_in_words(), results.plant.labelled(state)];
            rows.push(names.into_iter().chain(numbers).collect());
        }
    }
    table(text, &rows);
}

/// The filters of a simulation.
pub(super) fn filters(text: &mut String, filters: &[FilterReport]) {
    _ = writeln!(text, "\nconsistency of the filters, mean with its 95 % acceptance region");
    consistency(text, filters.iter().map(|filter| (filter.observer.as_str(), &filter.nis, &filter.nees)));
}

fn consistency<'a>(
    text: &mut String,
    filters: impl Iterator<Item = (&'a str, &'a Option<ConsistencyReport>, &'a Option<ConsistencyReport>)>,
) {
    let mut rows = header(&["filter", "NIS (innovations)", "NEES (errors)"]);
    rows.extend(filters.map(|(name, nis, nees)| vec![name.to_owned(), test(nis.as_ref()), test(nees.as_ref())]));
    table(text, &rows);
}

/// The observers on a log.
pub(super) fn log(text: &mut String, report: &LogReport, plant: &PlantSummary) {
    _ = writeln!(text, "\n{}", log_data(report, plant.time_unit.as_deref()));
    _ = writeln!(text, "\ninnovations over the second half of the log");
    let mut rows =
        header(&["observer", "output", "samples", "mean", "rms", "peak", "whiteness test p-value (Ljung-Box)"]);
    for row in &report.rows {
        if let Some(failure) = &row.failure {
            rows.push(vec![row.observer.clone(), failure.clone()]);
            continue;
        }
        for of in &row.outputs {
            rows.push(vec![
                row.observer.clone(),
                plant.labelled(&of.output),
                of.samples_in_words(),
                size(of.mean),
                size(of.rms),
                size(of.peak),
                of.whiteness_in_words().unwrap_or_else(|| "-".to_owned()),
            ]);
        }
    }
    table(text, &rows);
    for sampling in report.rows.iter().filter_map(|row| row.sampling.as_ref()) {
        _ = writeln!(text, "{}", sampling.words);
    }
    let filters: Vec<_> = report.rows.iter().flat_map(InnovationReport::tests_of_estimates).collect();
    if !filters.is_empty() {
        _ = writeln!(
            text,
            "\nconsistency of the filters over the second half of the log, mean with its 95 % acceptance region"
        );
        consistency(text, filters.iter().map(|row| (row.observer.as_str(), &row.nis, &row.nees)));
    }
    if report.rows.iter().any(|row| !row.errors.is_empty()) {
        _ = writeln!(text, "\nerrors over the whole log, where it has the true state; {}", report.estimates_in_words());
        let mut rows = header(&["observer", "state", "samples", "RMSE", "peak", "last"]);
        for (name, error) in report.rows.iter().flat_map(InnovationReport::errors_of_estimates) {
            rows.push(vec![
                name,
                plant.labelled(&error.state),
                error.samples.to_string(),
                number(error.rmse),
                number(error.peak),
                size(error.last),
            ]);
        }
        table(text, &rows);
    }
    if report.rows.iter().any(|row| row.smoothed.is_some()) {
        _ = writeln!(text, "\nstandard deviations that the filters compute, root mean square over the log");
        let mut rows = header(&["observer", "state", "filtered", "smoothed"]);
        for row in &report.rows {
            for of in row.smoothed.iter().flat_map(|smoothed| &smoothed.deviations) {
                rows.push(vec![row.observer.clone(), plant.labelled(&of.state), size(of.filtered), size(of.smoothed)]);
            }
        }
        table(text, &rows);
    }
}
