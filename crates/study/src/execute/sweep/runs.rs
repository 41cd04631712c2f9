//! The scores of a run as a row of numbers, and as a line of comma-separated values.

use luenberger_proof::wording::shortest;

use super::block::Block;
use crate::results::MeritsReport;

/// Scores of the norm.
pub(super) const NORM: [&str; 5] = ["settling", "peak", "rms", "last", "steady_rms"];

/// Scores of a state.
pub(super) const STATE: [&str; 8] =
    ["initial", "rmse", "peak", "overshoot", "settling_5", "settling_2", "last", "steady_rmse"];

/// The names of the scores: those of the norm, if there is one, and of each state.
pub(super) fn names(states: &[String], has_norm: bool) -> Vec<String> {
    let norm = NORM.iter().filter(|_| has_norm).map(|score| format!("norm_{score}"));
    norm.chain(states.iter().flat_map(|state| STATE.map(|score| format!("{state}_{score}")))).collect()
}

/// The scores of a run in this order. A run that does not settle has the settling time infinity.
pub(super) fn scores(merits: &MeritsReport) -> Vec<f64> {
    let time = |time: Option<f64>| time.unwrap_or(f64::INFINITY);
    let norm = merits.norm.iter();
    let norm = norm.flat_map(|norm| [time(norm.settling_last), norm.peak, norm.rms, norm.last, norm.steady_rms]);
    let states = merits.states.iter().flat_map(|state| {
        let (five, two) = (time(state.settling_5), time(state.settling_2));
        [state.initial, state.rmse, state.peak, state.overshoot, five, two, state.last, state.steady_rmse]
    });
    norm.chain(states).collect()
}

/// The first line of the table of runs.
pub(super) fn head(parameter: &str, names: &[String]) -> String {
    let first = ["observer", parameter, "run"].map(str::to_owned);
    line(first.iter().chain(names).map(String::as_str).chain(["failure"]))
}

/// The runs of a block, a line each: the scores, or why a run ended. What does not exist is empty.
pub(super) fn lines(block: &Block, names: &[String]) -> String {
    let header = &block.header;
    let value = shortest(header.value);
    let mut text = String::new();
    for index in 0..header.count as usize {
        let ended = block.ended(index);
        let mut cells = vec![header.observer.clone(), value.clone(), (header.first + index as u64).to_string()];
        for (name, values) in names.iter().zip(&block.scores) {
            let is_missing = ended.is_some() || values[index] == f64::INFINITY && is_time(name);
            cells.push(if is_missing { String::new() } else { shortest(values[index]) });
        }
        cells.push(ended.unwrap_or_default().to_owned());
        text += &line(cells.iter().map(String::as_str));
    }
    text
}

/// Whether a score is a settling time.
fn is_time(name: &str) -> bool {
    ["settling", "settling_5", "settling_2"].iter().any(|end| name.ends_with(end))
}

/// A line of comma-separated values.
fn line<'a>(cells: impl Iterator<Item = &'a str>) -> String {
    let mut line = String::new();
    for (k, cell) in cells.enumerate() {
        if k > 0 {
            line.push(',');
        }
        if cell.contains([',', '"', '\n', '\r']) {
            line.extend(["\"", &cell.replace('"', "\"\""), "\""]);
        } else {
            line.push_str(cell);
        }
    }
    line + "\n"
}
