//! Profile likelihoods: for each value of one parameter, the largest likelihood over the others.

use super::coordinate::Coordinate;
use super::maximise::{Interrupted, minimised};
use super::report::Profile;

/// Half of the 95 % quantile of chi-squared with one degree of freedom.
pub(super) const DROP: f64 = 1.920_729_410_347_063;

/// A profile goes to so many standard errors, or to the vague deviation.
const ERRORS: f64 = 3.0;

/// The radii of a search that begins at the neighbouring point.
const PASS: [(f64, f64); 1] = [(0.1, 1e-3)];

/// The profile of parameter i: `count` points to either side of the least cost.
pub(super) fn profile(
    cost: &(dyn Fn(&[f64]) -> Result<f64, Interrupted> + Sync),
    (x, least): (&[f64], f64),
    (i, count): (usize, usize),
    (coordinates, deviation): (&[Coordinate], Option<f64>),
) -> Result<Profile, Interrupted> {
    let own = coordinates[i];
    let step = deviation.map_or_else(|| own.vague(), |deviation| ERRORS * deviation) / count as f64;
    let others: Vec<usize> = (0..x.len()).filter(|k| *k != i).collect();
    let bounds: Vec<Coordinate> = others.iter().map(|k| coordinates[*k]).collect();
    let mut points = vec![(x[i], 0.0)];
    for sign in [-1.0, 1.0] {
        let mut last = x.to_vec();
        for k in 1..=count {
            let to = x[i] + sign * step * k as f64;
            if to < own.low || to > own.high {
                break;
            }
            last[i] = to;
            let whole = |part: &[f64]| {
                let mut whole = last.clone();
                others.iter().zip(part).for_each(|(k, x)| whole[*k] = *x);
                whole
            };
            let start: Vec<f64> = others.iter().map(|k| last[*k]).collect();
            let found = if others.is_empty() {
                cost(&last)?
            } else {
                let (part, found) = minimised(|part| cost(&whole(part)), &bounds, &start, &PASS)?;
                last = whole(&part);
                found
            };
            points.push((to, least - found));
        }
    }
    points.sort_by(|one, other| one.0.total_cmp(&other.0));
    let parabola = |x0: f64| deviation.map(|deviation| -0.5 * ((x0 - x[i]) / deviation).powi(2));
    Ok(Profile {
        name: String::new(),
        values: points.iter().map(|(x, _)| own.value(*x)).collect(),
        log_likelihood: points.iter().map(|(_, drop)| *drop).collect(),
        parabola: points.iter().filter_map(|(x, _)| parabola(*x)).collect(),
        is_log: own.is_log(),
    })
}

/// Where the profile falls by [`DROP`], to either side of its largest value, by parabolas through its points: the
/// square root of the drop is nearly straight.
pub(super) fn interval(profile: &Profile, own: &Coordinate) -> [Option<f64>; 2] {
    let x: Vec<f64> = profile.values.iter().map(|value| own.of(*value)).collect();
    let root: Vec<f64> = profile.log_likelihood.iter().map(|drop| (-drop).max(0.0).sqrt()).collect();
    let top = root.iter().enumerate().min_by(|one, other| one.1.total_cmp(other.1)).map_or(0, |(k, _)| k);
    let edge = DROP.sqrt();
    let cross = |a: usize, b: usize| x[a] + (x[b] - x[a]) * (edge - root[a]) / (root[b] - root[a]);
    let low = (0..top).rev().find(|&k| root[k] >= edge).map(|k| own.value(cross(k + 1, k)));
    let high = (top + 1..x.len()).find(|&k| root[k] >= edge).map(|k| own.value(cross(k - 1, k)));
    [low, high]
}
