//! The results as sections of a document, from which the report, the text of the command and Markdown follow.

mod frequency;
mod log;
mod observability;
mod observers;
mod prediction;

pub(crate) use frequency::section as frequency;
pub use log::data as log_data;
pub use observability::leading;
pub(crate) use prediction::Columns;

use luenberger_figures::{Cell, Grid, Report, Section};
use luenberger_proof::wording::{complex, counted, significant};

use super::{
    ABOUT_ZERO, ABOUT_ZERO_MEANS, LogSweepReport, NamedMatrix, OperatingPointReport, Results, ScoreCell, ScoreTable,
    SweepReport, is_about_zero,
};
pub(crate) use observability::section as observability;
pub(crate) use observers::{badge, section as observers, verdicts};

impl Results {
    /// All sections, in the order of the steps; with `designs` the observers have gains and proofs, else their verdicts
    /// alone.
    fn sections(&self, designs: bool) -> Vec<Section> {
        let mut sections: Vec<Section> =
            self.operating_point.iter().map(|point| operating_point(self, point)).collect();
        sections.extend(self.observability.as_ref().map(observability));
        if !self.observers.is_empty() {
            sections.push(if designs { observers(&self.observers) } else { verdicts(&self.observers) });
        }
        if designs {
            sections.extend(self.frequency.as_ref().map(|report| frequency(report, &self.plant)));
        }
        if self.simulation.is_some() || self.log.is_some() {
            sections.push(comparison(self, true));
        }
        sections.extend(self.sweep.as_ref().map(|report| sweep(self, report)));
        sections.extend(self.sweep_on_log.as_ref().map(|report| sweep_on_log(self, report)));
        sections
    }

    /// The results as text, with `designs` as in [`markdown`](Self::markdown).
    pub fn text(&self, designs: bool) -> String {
        self.text_of(designs, Section::text)
    }

    /// The same with verdicts in colours, for a terminal.
    pub fn coloured_text(&self, designs: bool) -> String {
        self.text_of(designs, Section::coloured_text)
    }

    fn text_of(&self, designs: bool, of: fn(&Section) -> String) -> String {
        let head = self.plant.headline(&self.title);
        self.sections(designs).iter().fold(head, |text, section| text + &of(section))
    }

    /// The results as Markdown; with `designs` the observers have gains and proofs, else their verdicts alone.
    pub fn markdown(&self, designs: bool) -> String {
        let lists = [("Warnings", &self.warnings), ("Failures", &self.failures())]
            .map(|(title, all)| (!all.is_empty()).then(|| Section::new(title).list(all.iter().cloned())));
        let report = Report::new(&self.title).lead(&self.about);
        self.sections(designs).into_iter().chain(lists.into_iter().flatten()).fold(report, Report::section).markdown()
    }
}

/// A number with six significant digits.
pub(crate) fn short(x: f64) -> String {
    significant(x, 6)
}

pub(crate) fn number(x: f64) -> Cell {
    Cell::number(short(x))
}

fn maybe(x: Option<f64>) -> Cell {
    x.map_or_else(|| Cell::number("–"), number)
}

/// A name with its unit, if there is one: `position (m)`.
pub(crate) fn with_unit(name: &str, unit: Option<&String>) -> String {
    unit.map_or_else(|| name.to_owned(), |unit| format!("{name} ({unit})"))
}

pub(crate) fn eigenvalue(z: [f64; 2]) -> String {
    complex(z, 6)
}

/// Maximal number of modes and of poles that are shown; `study.json` has all.
const MODES: usize = 12;

/// A list of poles; those after the first ones of many are counted.
fn poles(all: &[[f64; 2]]) -> String {
    let shown = all.iter().take(MODES).map(|pole| eigenvalue(*pole)).collect::<Vec<_>>().join(", ");
    match all.len().saturating_sub(MODES) {
        0 => shown,
        more => format!("{shown} and {more} more"),
    }
}

pub(crate) fn operating_point(results: &Results, point: &OperatingPointReport) -> Section {
    let plant = &results.plant;
    let named = |names: &[String], values: &[f64]| plant.listed(names, values.iter().map(|value| short(*value)));
    let mut facts = vec![("states", named(&plant.states, &point.x))];
    if !point.u.is_empty() {
        facts.push(("inputs", named(&plant.inputs, &point.u)));
    }
    facts.extend([
        ("outputs", named(&plant.outputs, &point.y)),
        ("largest |f(x, u)|", significant(point.residual, 2)),
        ("Newton steps", point.steps.to_string()),
        ("eigenvalues of A", poles(&point.poles)),
        (
            "the linearisation is",
            if point.observable { "observable" } else { "not observable to working precision" }.to_owned(),
        ),
    ]);
    let section = Section::new("Operating point")
        .note("The plant rests at this state under this constant input. A, B, C and D are its linearisation there, of deviations from the point.")
        .facts(facts);
    matrices(section, point.matrices.iter())
}

/// The maximal number of rows and columns of a matrix shown entry by entry.
const LARGEST: usize = 12;

/// The entries of a matrix with six digits, [`ABOUT_ZERO`] for one that is [`is_about_zero`].
fn entries(rows: &[Vec<f64>]) -> Vec<Vec<String>> {
    let text = |(x, about): (&f64, bool)| if about { ABOUT_ZERO.to_owned() } else { short(*x) };
    rows.iter().zip(is_about_zero(rows)).map(|(row, about)| row.iter().zip(about).map(text).collect()).collect()
}

/// Small matrices entry by entry; larger ones by their sizes.
pub(crate) fn matrices<'a>(section: Section, matrices: impl Iterator<Item = &'a NamedMatrix>) -> Section {
    let (mut shown, mut large) = (Vec::new(), Vec::new());
    for matrix in matrices {
        let (rows, columns) = (matrix.rows.len(), matrix.rows.first().map_or(0, Vec::len));
        if rows.max(columns) > LARGEST {
            large.push(format!("{} is {rows} x {columns}: see `study.json`.", matrix.name));
        } else {
            shown.push((matrix.name.clone(), entries(&matrix.rows)));
        }
    }
    let about = shown.iter().flat_map(|(_, rows)| rows).flatten().any(|entry| entry == ABOUT_ZERO);
    let section = if shown.is_empty() { section } else { section.matrices(shown) };
    let section = if about {
        section.prose(format!("{ABOUT_ZERO}: {ABOUT_ZERO_MEANS}; `study.json` has the digits."))
    } else {
        section
    };
    if large.is_empty() { section } else { section.prose(large.join(" ")) }
}

/// The maximal number of states of which the scores are shown.
const SCORED: usize = 12;

pub(crate) fn score(cell: &ScoreCell) -> Cell {
    match (cell.best, cell.number) {
        (true, _) => Cell::best(cell.text.as_str()),
        (false, true) => Cell::number(cell.text.as_str()),
        (false, false) => Cell::from(cell.text.as_str()),
    }
}

/// The caption of the scores of the norm of the error of so many observers.
pub(crate) fn norm_caption(observers: usize, same_start: bool) -> &'static str {
    match (observers, same_start) {
        (0 | 1, _) => "Norm of the error.",
        (_, true) => "Norm of the error; the best values are marked.",
        (_, false) => "Norm of the error. The observers start from different estimates: none is marked as best.",
    }
}

fn scores(section: Section, table: &ScoreTable, caption: &str) -> Section {
    let head: Vec<&str> = table.head.iter().map(String::as_str).collect();
    let grid = table.rows.iter().fold(Grid::new(&head), |grid, row| grid.row(row.iter().map(score)));
    let section = section.grid(grid.caption(caption));
    match table.omitted {
        0 => section,
        omitted => section.prose(format!("`study.json` has the other {}.", counted(omitted, "state"))),
    }
}

pub(crate) fn sweep(results: &Results, sweep: &SweepReport) -> Section {
    let mut section = Section::new("Sweep").list(sweep.scoring.words.iter().cloned());
    if let Some(table) = sweep.table(&results.plant, SCORED) {
        let caption = match sweep.ensemble {
            1 => "One run at each value.",
            _ => "Medians over the ensemble; in brackets the 5th and the 95th percentile.",
        };
        section = scores(section, &table, caption);
    }
    let ended = sweep.ended();
    if ended.is_empty() { section } else { section.prose("Without a run, or ended early:").list(ended) }
}

/// The sweep on a log.
pub(crate) fn sweep_on_log(results: &Results, sweep: &LogSweepReport) -> Section {
    let columns = Columns::of(sweep.rows.iter().filter_map(|row| row.on_log.as_ref()));
    let names = [sweep.parameter.clone(), "observer".to_owned()];
    let head: Vec<String> = names.into_iter().chain(columns.head(&results.plant)).collect();
    let head: Vec<&str> = head.iter().map(String::as_str).collect();
    let number = |x: Option<f64>| Cell::number(x.map_or_else(|| "-".to_owned(), |x| significant(x, 4)));
    let judged = sweep.rows.iter().filter(|row| row.on_log.is_some());
    let grid = judged.fold(Grid::new(&head), |grid, row| {
        let names = [number(Some(row.value)), Cell::from(row.observer.as_str())];
        let scores = columns.scores(row.on_log.as_ref()).into_iter().map(|score| number(score.value));
        grid.row(names.into_iter().chain(scores))
    });
    let words = std::iter::once(sweep.held_out.clone()).chain(columns.words());
    let section = Section::new("Sweep on the log").list(words).grid(grid).list(sweep.best());
    let ended = sweep.rows.iter().filter_map(|row| {
        let value = significant(row.value, 6);
        Some(format!("{} with {} = {value}: {}", row.observer, sweep.parameter, row.failure.as_ref()?))
    });
    let ended: Vec<String> = ended.collect();
    if ended.is_empty() { section } else { section.prose("Without a run, or ended early:").list(ended) }
}

/// The scores of the observers, with those of the `norm` of the error unless they stand elsewhere.
pub(crate) fn comparison(results: &Results, norm: bool) -> Section {
    let mut section = Section::new("Comparison");
    if let Some(simulation) = &results.simulation {
        let unit = results.plant.time_unit.as_ref().map(|unit| format!(" {unit}")).unwrap_or_default();
        let duration = format!("Simulation to t = {}{unit}.", short(simulation.duration));
        let sampling = simulation.sampling.iter().map(|sampling| &sampling.words);
        let words = simulation.truth.iter().chain(&simulation.measurements).chain(sampling);
        let words = std::iter::once(&duration).chain(words).chain(&simulation.scoring.words);
        section = section.list(words.cloned());
        if let Some(table) = simulation.norm_table(&results.plant).filter(|_| norm) {
            section = scores(section, &table, norm_caption(table.rows.len(), simulation.same_start()));
        }
        section = match simulation.state_table(&results.plant, SCORED) {
            Some(table) => scores(section, &table, "Error of each state, in its unit.").note(
                "Settling: the error stays within 5 % or 2 % of its initial value; overshoot: the largest error after \
                 its first change of sign.",
            ),
            None => section.prose("No observer finished its run."),
        };
        if let Some(seed) = simulation.seed {
            section = section.note(format!("The noise has the seed {seed}, the same for all."));
        }
        let ended: Vec<String> = simulation.ended().into_iter().chain(results.not_run()).collect();
        if !ended.is_empty() {
            section = section.prose("Ended early, or not run:").list(ended);
        }
    }
    if !results.intervals.is_empty() {
        section = log::intervals(section, &results.intervals, &results.plant);
    }
    if !results.filters.is_empty() {
        section = log::filters(section, &results.filters);
    }
    if !results.models.is_empty() {
        section = log::models(section, &results.models);
    }
    if let Some(log) = &results.log {
        section = log::log(section, log, &results.plant);
    }
    if !results.coverage.is_empty() {
        section = log::coverage(section, &results.coverage, &results.plant);
    }
    section
}
