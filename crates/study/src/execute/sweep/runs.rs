//! The runs of a sweep as comma-separated values, one line each.

use luenberger_proof::wording::shortest;

use crate::results::{MeritsReport, ScoringReport};
use crate::study::Study;

/// The names of the columns.
pub(super) fn head(study: &Study, parameter: &str, scoring: &ScoringReport) -> Vec<String> {
    let mut names: Vec<String> = ["observer", parameter, "run"].map(str::to_owned).to_vec();
    if scoring.scale.is_some() {
        names.extend(["norm_settling", "norm_peak", "norm_rms", "norm_last", "norm_steady_rms"].map(str::to_owned));
    }
    for state in &study.plant.states {
        let scores = ["initial", "rmse", "peak", "overshoot", "settling_5", "settling_2", "last", "steady_rmse"];
        names.extend(scores.map(|score| format!("{state}_{score}")));
    }
    names.push("failure".to_owned());
    names
}

/// One run: its scores, or why it ended. What does not exist is empty.
pub(super) fn cells(
    (observer, value, number): (&str, f64, usize),
    outcome: Result<&MeritsReport, &str>,
    columns: usize,
) -> Vec<String> {
    let mut cells = vec![observer.to_owned(), shortest(value), number.to_string()];
    let time = |time: Option<f64>| time.map_or_else(String::new, shortest);
    if let Ok(merits) = outcome {
        if let Some(norm) = &merits.norm {
            cells.push(time(norm.settling_last));
            cells.extend([norm.peak, norm.rms, norm.last, norm.steady_rms].map(shortest));
        }
        for state in &merits.states {
            cells.extend([state.initial, state.rmse, state.peak, state.overshoot].map(shortest));
            cells.extend([time(state.settling_5), time(state.settling_2)]);
            cells.extend([state.last, state.steady_rmse].map(shortest));
        }
    }
    cells.resize(columns - 1, String::new());
    cells.push(outcome.err().unwrap_or_default().to_owned());
    cells
}

/// A line of comma-separated values.
pub(super) fn line(cells: &[String]) -> String {
    let quoted = |cell: &String| {
        if cell.contains([',', '"', '\n', '\r']) { format!("\"{}\"", cell.replace('"', "\"\"")) } else { cell.clone() }
    };
    cells.iter().map(quoted).collect::<Vec<_>>().join(",") + "\n"
}
