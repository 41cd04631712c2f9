//! Regression by polynomials on the cells of a tree.

use luenberger_design::internals::{Budget, Samples, fit};
use nalgebra::SVector;

fn grid(count: usize) -> Vec<[f64; 2]> {
    let at = |k: usize| 2.0 * k as f64 / (count - 1) as f64 - 1.0;
    (0..count * count).map(|k| [at(k / count), 3.0 * at(k % count)]).collect()
}

#[test]
fn a_polynomial_of_the_degree_takes_one_leaf() {
    let points = grid(20);
    let f = |x: f64, y: f64| 1.0 + x - 2.0 * x * y + y * y * x;
    let values: Vec<[f64; 1]> = points.iter().map(|p| [f(p[0], p[1])]).collect();
    let samples = Samples { points: &points, values: &values, scale: [1.0] };
    let tree = fit(samples, Budget { degree: 3, leaves: 1, ridge: 1e-15 }, &mut |_| Ok(())).unwrap();
    assert_eq!((tree.leaf_count(), tree.depth()), (1, 0));
    for p in [[0.3, -2.0], [-0.9, 1.1]] {
        // Condition of the normal equations of ten monomials on a square: below 1e4; values below 30.
        assert!((tree.at(&SVector::from(p))[0] - f(p[0], p[1])).abs() < 1e4 * 30.0 * f64::EPSILON);
    }
}

#[test]
fn a_cube_root_is_refined_where_it_bends() {
    let points: Vec<[f64; 1]> = (0..4001).map(|k| [f64::from(k) / 2000.0 - 1.0]).collect();
    let values: Vec<[f64; 1]> = points.iter().map(|p| [p[0].cbrt()]).collect();
    let samples = Samples { points: &points, values: &values, scale: [1.0] };
    let rms = |leaves: usize| {
        let tree = fit(samples, Budget { degree: 3, leaves, ridge: 1e-12 }, &mut |_| Ok(())).unwrap();
        let sum: f64 = points.iter().zip(&values).map(|(p, v)| (tree.at(&SVector::from(*p))[0] - v[0]).powi(2)).sum();
        (sum / points.len() as f64).sqrt()
    };
    let (one, many) = (rms(1), rms(16));
    assert!(many < one / 30.0, "{one:e} {many:e}");
}

#[test]
fn a_coordinate_that_does_not_vary_does_no_harm() {
    let points: Vec<[f64; 2]> = (0..100).map(|k| [f64::from(k), 7.0]).collect();
    let values: Vec<[f64; 1]> = points.iter().map(|p| [2.0 * p[0]]).collect();
    let samples = Samples { points: &points, values: &values, scale: [1.0] };
    let tree = fit(samples, Budget { degree: 2, leaves: 4, ridge: 1e-12 }, &mut |_| Ok(())).unwrap();
    // The ridge, 1e-12, shrinks the slope by its own size.
    assert!((tree.at(&SVector::from([30.5, 1e9]))[0] - 61.0).abs() < 1e-8);
}
