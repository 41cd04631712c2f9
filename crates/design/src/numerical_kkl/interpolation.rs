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
pub(crate) fn check_grid(points: &[usize], tables: usize, numbers: usize) -> Result<(), NumericalKklError> {
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
pub(crate) fn interpolate<const N: usize, const Z: usize>(
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn cubics_are_reproduced_with_their_gradients() {
        let f = |x: f64, y: f64| x.powi(3) * y - 2.0 * y.powi(3) + x * x * y * y - 1.0;
        let (lower, upper) = (SVector::from([-1.0, 0.0]), SVector::from([2.0, 1.0]));
        let points = [4, 7];
        let mut values = Vec::new();
        for i in 0..points[0] {
            for j in 0..points[1] {
                let (x, y) = (-1.0 + 3.0 * i as f64 / 3.0, j as f64 / 6.0);
                values.extend([f(x, y), -f(x, y)]);
            }
        }
        let spline = interpolate::<2, 2>(lower, upper, points, values).unwrap();
        for k in 0..50 {
            let (x, y) = (-1.0 + 3.0 * f64::from(k) / 49.0, (0.37 * f64::from(k)).fract());
            let (value, slope) = spline.with_gradient(&SVector::from([x, y]));
            let scale = 20.0;
            // Values below 20; the inverse of a collocation matrix of this size has a norm below 100.
            assert!((value[0] - f(x, y)).abs() < 100.0 * scale * f64::EPSILON && value[0] == -value[1], "{x} {y}");
            let fx = 3.0 * x * x * y + 2.0 * x * y * y;
            let fy = x.powi(3) - 6.0 * y * y + 2.0 * x * x * y;
            // Derivatives divide by the spacing, 1/6.
            assert!((slope[(0, 0)] - fx).abs() < 1e3 * scale * f64::EPSILON, "{x} {y}");
            assert!((slope[(0, 1)] - fy).abs() < 1e3 * scale * f64::EPSILON, "{x} {y}");
        }
        // Outside: the value at the border.
        assert_eq!(spline.at(&SVector::from([5.0, 0.5])), spline.at(&SVector::from([2.0, 0.5])));
    }

    #[test]
    fn grids_that_cannot_be_are_named() {
        assert!(check_grid(&[3, 8], 1, 3).is_err() && check_grid(&[8, 2000], 1, 3).is_err());
        assert!(matches!(check_grid(&[1000, 1000, 1000], 1, 4), Err(NumericalKklError::GridTooLarge { .. })));
        // 45^4 = 4100625 is below 2^22 = 4194304, 46^4 is not; five numbers of eight bytes each.
        assert!(check_grid(&[43; 4], 1, 5).is_ok());
        let too_large = NumericalKklError::GridTooLarge {
            points: 46.0f64.powi(4),
            most: 1 << 22,
            megabytes: 46.0f64.powi(4) * 40.0 / 1e6,
            per_axis: 43,
        };
        assert_eq!(check_grid(&[44; 4], 1, 5), Err(too_large));
        assert!(check_grid(&[43; 4], 2, 5).is_err());
    }
}
