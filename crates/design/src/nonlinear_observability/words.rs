//! Directions of the state space as text.

use crate::names::state;

/// Entries below this fraction of the largest are omitted.
const SHARE: f64 = 0.005;

/// A direction as a sum of states, its largest entry one: `x3`, `x1 - x2`, `x1 + 0.5 x3`.
///
/// `names` are those of the states; `x1`, `x2`, .. stand in for those that are missing. Entries below half a percent of
/// the largest are left out; `0` if there is no other.
///
/// ```
/// use luenberger_design::nonlinear_observability::direction_in_words;
/// assert_eq!(direction_in_words(&[0.7, -0.7, 1e-17], &[]), "x1 - x2");
/// assert_eq!(direction_in_words(&[0.0, -0.2, -0.4], &["p", "q", "w"]), "w + 0.5 q");
/// ```
pub fn direction_in_words(direction: &[f64], names: &[&str]) -> String {
    let size = direction.iter().fold(0.0f64, |size, entry| size.max(entry.abs()));
    if !(size > 0.0 && size.is_finite()) {
        return "0".to_owned();
    }
    let mut order: Vec<usize> = (0..direction.len()).filter(|&j| direction[j].abs() >= SHARE * size).collect();
    // The largest first; those that differ by rounding stay in the order of the states.
    let rank = |j: usize| -(direction[j].abs() / size * 1e6).round();
    order.sort_by(|&i, &j| rank(i).total_cmp(&rank(j)));
    let sign = direction[order[0]].signum();
    let mut words = String::new();
    for &j in &order {
        let share = sign * direction[j] / size;
        let number = format!("{:.2}", share.abs());
        let number = number.trim_end_matches('0').trim_end_matches('.');
        words += match (words.is_empty(), share < 0.0) {
            (true, _) => "",
            (false, false) => " + ",
            (false, true) => " - ",
        };
        if number != "1" {
            words += number;
            words += " ";
        }
        words += &names.get(j).map_or_else(|| state(j), |&name| name.to_owned());
    }
    words
}
