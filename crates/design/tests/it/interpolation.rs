//! Cubic splines through the values on a grid.

use luenberger_design::NumericalKklError;
use luenberger_design::internals::{check_grid, interpolate};
use nalgebra::SVector;

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
