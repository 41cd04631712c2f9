//! Interpolation of a map on a grid by cubic splines.
//!
//! The axes are treated one after the other: on each, the coefficients follow from the values by `(c_j + 4 c_(j+1) +
//! c_(j+2)) / 6 = v_j` and the two conditions that the third derivative does not jump at the first and the last inner
//! point (not-a-knot), so that cubics are reproduced exactly.
//!
//! Source: C. de Boor, A Practical Guide to Splines, rev. ed., Springer 2001, ch. IV (not-a-knot) and XVII (tensor
//! products).

use luenberger_observers::numerical_kkl::TensorSpline;
use nalgebra::{DMatrix, SVector};

use crate::check::within;
use crate::numerical_kkl::error::NumericalKklError;

/// Largest number of coefficients, each of n_z numbers, of all tables of a design.
pub(crate) const MOST_POINTS: usize = 1 << 22;

/// Checks that `tables` tables of `numbers` numbers on this grid can be made.
///
/// # Errors
/// [`NumericalKklError::GridTooLarge`]; [`DesignError::Setting`](crate::DesignError::Setting) for an axis.
pub fn check_grid(points: &[usize], tables: usize, numbers: usize) -> Result<(), NumericalKklError> {
    check_axes(points)?;
    let product = tables as f64 * points.iter().map(|&count| (count + 2) as f64).product::<f64>();
    if product > MOST_POINTS as f64 {
        return Err(NumericalKklError::GridTooLarge {
            points: product,
            most: MOST_POINTS,
            megabytes: product * (numbers * size_of::<f64>()) as f64 / 1e6,
            per_axis: (2..=1024).take_while(|count| holds(*count, points.len(), tables)).last().unwrap_or(0),
        });
    }
    Ok(())
}

/// Checks the number of grid points on each axis.
pub(super) fn check_axes(points: &[usize]) -> Result<(), NumericalKklError> {
    for &count in points {
        // Not-a-knot at both ends takes four points.
        within("the number of grid points on an axis", count as f64, 4.0, 1024.0)?;
    }
    Ok(())
}

/// Whether a grid of so many points on each axis is small enough.
fn holds(points: usize, axes: usize, tables: usize) -> bool {
    tables as f64 * ((points + 2) as f64).powf(axes as f64) <= MOST_POINTS as f64
}

/// The spline through `values`: Z numbers for each grid point, the last axis running fastest.
///
/// # Errors
/// Those of [`TensorSpline::new`].
pub fn interpolate<const N: usize, const Z: usize>(
    lower: SVector<f64, N>,
    upper: SVector<f64, N>,
    points: [usize; N],
    values: Vec<f64>,
) -> Result<TensorSpline<f64, Vec<f64>, N, Z>, NumericalKklError> {
    let mut table = values;
    for axis in 0..N {
        let count = points[axis];
        // Axes before have count + 2 rows already.
        let outer: usize = points[..axis].iter().map(|count| count + 2).product();
        let inner: usize = points[axis + 1..].iter().product::<usize>() * Z;
        table = along_axis(&table, (outer, count, inner));
    }
    Ok(TensorSpline::new(lower, upper, points, table)?)
}

/// The coefficients along the middle one of three axes, of which the last runs fastest.
pub(super) fn along_axis(values: &[f64], (outer, count, inner): (usize, usize, usize)) -> Vec<f64> {
    let inverse = collocation_inverse(count);
    let mut coefficients = vec![0.0; outer * (count + 2) * inner];
    for o in 0..outer {
        for row in 0..count + 2 {
            let target = &mut coefficients[(o * (count + 2) + row) * inner..][..inner];
            for k in 0..count {
                let weight = inverse[(row, k)];
                let source = &values[(o * count + k) * inner..][..inner];
                for (sum, value) in target.iter_mut().zip(source) {
                    *sum += weight * value;
                }
            }
        }
    }
    coefficients
}

/// From `count` values to `count + 2` coefficients.
fn collocation_inverse(count: usize) -> DMatrix<f64> {
    let mut matrix = DMatrix::zeros(count + 2, count + 2);
    for (j, entry) in [1.0, -4.0, 6.0, -4.0, 1.0].into_iter().enumerate() {
        matrix[(0, j)] = entry;
        matrix[(count + 1, count - 3 + j)] = entry;
    }
    for j in 0..count {
        for (k, entry) in [1.0 / 6.0, 4.0 / 6.0, 1.0 / 6.0].into_iter().enumerate() {
            matrix[(j + 1, j + k)] = entry;
        }
    }
    // Unisolvent: de Boor, ch. IV. A zero matrix would be noticed by the tests of reproduction.
    let inverse = matrix.try_inverse().unwrap_or_else(|| DMatrix::zeros(count + 2, count + 2));
    inverse.columns(1, count).into_owned()
}
