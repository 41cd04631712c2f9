//! The observed information: second derivatives of the cost at its least value, what they say of the errors, and which
//! combinations the data do not determine.

use nalgebra::DMatrix;
use rayon::prelude::*;

use super::coordinate::Coordinate;

/// The second difference that a step is to make: large against rounding and steps of predictions, small enough for a
/// parabola.
const RISE: f64 = 0.1;

/// The second derivatives, and what is derived from them.
pub(super) struct Information {
    /// The standard deviation of each coordinate; none where the data do not determine it.
    pub(super) deviation: Vec<Option<f64>>,
    /// Directions that the data do not determine, in units of the vague deviations, the largest entry 1.
    pub(super) flat: Vec<Vec<f64>>,
    /// The largest difference of the second derivatives by two steps, relative to their diagonal.
    pub(super) discrepancy: f64,
}

/// A step to either side of the least cost along one coordinate, and the second difference there.
fn step(cost: &(dyn Fn(&[f64]) -> f64 + Sync), (x, least): (&[f64], f64), i: usize, of: &Coordinate) -> f64 {
    let room = (x[i] - of.low).min(of.high - x[i]).max(1e-6);
    let mut h = 0.1f64.min(room);
    for _ in 0..6 {
        let at = |sign: f64| {
            let mut point = x.to_vec();
            point[i] += sign * h;
            cost(&point)
        };
        let rise = at(1.0) + at(-1.0) - 2.0 * least;
        if (0.3 * RISE..3.0 * RISE).contains(&rise) {
            break;
        }
        let wider = if rise > 0.0 { (RISE / rise).sqrt().clamp(0.1, 10.0) } else { 10.0 };
        let next = (h * wider).min(of.vague()).min(room);
        if next == h {
            break;
        }
        h = next;
    }
    h
}

/// Second derivatives by central differences with these steps.
fn hessian(cost: &(dyn Fn(&[f64]) -> f64 + Sync), (x, least): (&[f64], f64), h: &[f64]) -> DMatrix<f64> {
    let d = x.len();
    let pairs: Vec<(usize, usize)> = (0..d).flat_map(|i| (i..d).map(move |j| (i, j))).collect();
    let one = |&(i, j): &(usize, usize)| {
        let at = |a: f64, b: f64| {
            let mut point = x.to_vec();
            point[i] += a * h[i];
            point[j] += b * h[j];
            cost(&point)
        };
        if i == j {
            (at(1.0, 0.0) + at(-1.0, 0.0) - 2.0 * least) / (h[i] * h[i])
        } else {
            (at(1.0, 1.0) - at(1.0, -1.0) - at(-1.0, 1.0) + at(-1.0, -1.0)) / (4.0 * h[i] * h[j])
        }
    };
    let entries: Vec<f64> = pairs.par_iter().map(one).collect();
    let mut matrix = DMatrix::zeros(d, d);
    for ((i, j), entry) in pairs.into_iter().zip(entries) {
        matrix[(i, j)] = entry;
        matrix[(j, i)] = entry;
    }
    matrix
}

impl Information {
    /// The information at the least cost. The second derivatives are those of two steps, extrapolated.
    pub(super) fn new(
        cost: &(dyn Fn(&[f64]) -> f64 + Sync),
        (x, least): (&[f64], f64),
        coordinates: &[Coordinate],
    ) -> Self {
        if x.is_empty() {
            // Every parameter is at a bound.
            return Self { deviation: Vec::new(), flat: Vec::new(), discrepancy: 0.0 };
        }
        let indices: Vec<usize> = (0..x.len()).collect();
        let h: Vec<f64> = indices.par_iter().map(|&i| step(cost, (x, least), i, &coordinates[i])).collect();
        let half: Vec<f64> = h.iter().map(|h| 0.5 * h).collect();
        let (coarse, fine) = (hessian(cost, (x, least), &h), hessian(cost, (x, least), &half));
        let size = |i: usize| fine[(i, i)].abs().max(f64::MIN_POSITIVE).sqrt();
        let difference = |i: usize, j: usize| (fine[(i, j)] - coarse[(i, j)]).abs() / (size(i) * size(j));
        let discrepancy = indices.iter().flat_map(|&i| indices.iter().map(move |&j| (i, j)));
        // Along a coordinate that is hardly determined differences mean nothing.
        let is_known = |i: usize| fine[(i, i)].sqrt() * coordinates[i].vague() > 1.0;
        let discrepancy = discrepancy
            .filter(|(i, j)| is_known(*i) && is_known(*j))
            .map(|(i, j)| difference(i, j))
            .fold(0.0, f64::max);
        let second = (4.0 * &fine - coarse) / 3.0;
        Self { discrepancy, ..Self::of(&second, coordinates) }
    }

    fn of(second: &DMatrix<f64>, coordinates: &[Coordinate]) -> Self {
        let d = coordinates.len();
        let vague: Vec<f64> = coordinates.iter().map(Coordinate::vague).collect();
        let scaled = DMatrix::from_fn(d, d, |i, j| second[(i, j)] * vague[i] * vague[j]);
        let eigen = scaled.symmetric_eigen();
        let mut order: Vec<usize> = (0..d).collect();
        order.sort_by(|a, b| eigen.eigenvalues[*a].total_cmp(&eigen.eigenvalues[*b]));
        let flat: Vec<usize> = order.into_iter().filter(|&k| eigen.eigenvalues[k] < 1.0).collect();
        let deviation = |i: usize| {
            // A direction that is not determined counts as ten vague deviations long: what has a part of it is vague.
            let entry = |k: usize| eigen.eigenvectors[(i, k)].powi(2) / eigen.eigenvalues[k].max(0.01);
            let variance: f64 = (0..d).map(entry).sum();
            (variance < 1.0).then(|| vague[i] * variance.sqrt())
        };
        let direction = |&k: &usize| {
            let column = eigen.eigenvectors.column(k);
            let largest =
                column.iter().copied().fold(0.0f64, |largest, x| if x.abs() > largest.abs() { x } else { largest });
            column.iter().map(|x| x / largest).collect()
        };
        Self {
            deviation: (0..d).map(deviation).collect(),
            flat: flat.iter().map(direction).collect(),
            discrepancy: 0.0,
        }
    }
}
