//! Observability of the plant, or of its linearisations along a trajectory.

use luenberger_figures::{Cell, Grid, Section};
use luenberger_proof::wording::counted;

use super::{MODES, eigenvalue, maybe, number, short};
use crate::results::{ModeReport, ObservabilityAt, ObservabilityReport, UnseenModes};

pub(crate) fn section(report: &ObservabilityReport) -> Section {
    let linear = report.points.iter().all(|point| point.t.is_none());
    let mut section = Section::new("Observability").prose(match (linear, report.rank == report.order) {
        (true, true) => format!("The plant is observable: rank {0} of {0}.", report.order),
        (true, false) if report.is_decided() => {
            format!("The plant is not observable: rank {} of {}.", report.rank, report.order)
        }
        (true, false) => format!("The plant has the rank {} of {} to working precision.", report.rank, report.order),
        (false, true) => format!("The linearisations along the trajectory are observable at every point: rank {0} of {0}.", report.order),
        (false, false) => format!(
            "The linearisations along the trajectory have rank {} of {} at the worst point. A nonlinear plant can be observable nevertheless.",
            report.rank, report.order
        ),
    });
    section = section.note(
        "The margin of a mode is sigma_min([A - lambda I; C]) relative to the norm of [A; C]: 0 for an unobservable mode.",
    );
    section = if linear { report.points.iter().fold(section, of_linear) } else { along(section, report) };
    match &report.nonlinear {
        Some(nonlinear) => {
            section = section.verbatim(&nonlinear.words);
            // The eigenvalues are sorted, the largest first.
            match nonlinear.gramian.last() {
                Some(least) => section.prose(format!("Empirical Gramian: least eigenvalue {}.", short(*least))),
                None => section,
            }
        }
        None => section,
    }
}

/// `x`, or 0 where it is at the level of rounding errors of numbers as large as `largest`.
fn beside(x: f64, largest: f64) -> f64 {
    if x.abs() <= 8.0 * f64::EPSILON * largest { 0.0 } else { x }
}

/// The modes with the smallest margins.
fn modes(point: &ObservabilityAt, modes: &[ModeReport]) -> Grid {
    let all = point.modes.iter().chain(&point.hidden);
    let largest = all.map(|mode| mode.eigenvalue[0].hypot(mode.eigenvalue[1])).fold(0.0, f64::max);
    let value = |mode: &ModeReport| match point.unseen {
        // A small eigenvalue of a mode that is decided to decay is no rounding.
        UnseenModes::Decay => eigenvalue(mode.eigenvalue),
        _ => eigenvalue(mode.eigenvalue.map(|part| beside(part, largest))),
    };
    let mut sorted: Vec<&ModeReport> = modes.iter().collect();
    sorted.sort_by(|x, y| x.margin.total_cmp(&y.margin));
    let grid =
        sorted.iter().take(MODES).fold(Grid::new(&["mode", "margin", "least observable direction"]), |grid, mode| {
            grid.row([Cell::number(value(mode)), number(beside(mode.margin, 1.0)), Cell::from(leading(&mode.words))])
        });
    match sorted.len().saturating_sub(MODES) {
        0 => grid,
        more => grid.row([Cell::from(format!("and {more} more")), Cell::from(""), Cell::from("")]),
    }
}

/// Every mode of a linear plant.
fn of_linear(section: Section, point: &ObservabilityAt) -> Section {
    if point.hidden.is_empty() {
        return section.grid(modes(point, &point.modes));
    }
    section
        .prose(point.unseen_in_words("These modes"))
        .grid(modes(point, &point.hidden).caption("Unobservable."))
        .grid(modes(point, &point.modes).caption("All, the smallest margins first."))
}

/// The points of a trajectory, one row each, with the least observable mode there.
fn along(section: Section, report: &ObservabilityReport) -> Section {
    let lie = |t: Option<f64>| {
        let ranks = &report.nonlinear.as_ref()?.lie;
        ranks.iter().find(|at| Some(at.t) == t).map(|at| at.rank)
    };
    let head = [
        "t",
        "rank linearised",
        "rank of the Lie derivatives",
        "least observable mode",
        "margin",
        "direction",
        "unobservable",
    ];
    let grid = report.points.iter().fold(Grid::new(&head), |grid, point| {
        let least = point.modes.iter().min_by(|a, b| a.margin.total_cmp(&b.margin));
        let hidden = match point.hidden.len() {
            0 => "none".to_owned(),
            count => counted(count, "mode"),
        };
        grid.row([
            maybe(point.t),
            Cell::number(point.rank.to_string()),
            lie(point.t).map_or_else(|| Cell::number("–"), Cell::from),
            least.map_or_else(|| Cell::number("–"), |mode| Cell::number(eigenvalue(mode.eigenvalue))),
            maybe(least.map(|mode| beside(mode.margin, 1.0))),
            Cell::from(least.map(|mode| leading(&mode.words)).unwrap_or_default()),
            Cell::from(hidden),
        ])
    });
    section.grid(grid).note("Of the linearisation at each time, to working precision, and of the plant itself by its Lie derivatives; `study.json` has every mode.")
}

/// The largest terms of a direction, and the number of the others; `study.json` has all.
pub fn leading(words: &str) -> String {
    const SHOWN: usize = 6;
    let mut signs: Vec<usize> =
        [" + ", " - "].iter().flat_map(|sign| words.match_indices(sign)).map(|(at, _)| at).collect();
    signs.sort_unstable();
    match signs.get(SHOWN - 1) {
        Some(end) => format!("{} and {} smaller terms", &words[..*end], signs.len() + 1 - SHOWN),
        None => words.to_owned(),
    }
}
