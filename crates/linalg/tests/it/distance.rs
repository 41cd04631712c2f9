//! The two bounds hold, are near each other, and the perturbation does what it says.

use approx::assert_abs_diff_eq;
use luenberger_linalg::{LinalgError, UnobservabilityDistance, distance_to_unobservability};
use nalgebra::{Complex, DMatrix, dmatrix};
use proptest::prelude::*;
use std::cmp::Ordering;

fn sigma_min(a: &DMatrix<f64>, c: &DMatrix<f64>, lambda: Complex<f64>) -> f64 {
    let (n, p) = (a.nrows(), c.nrows());
    let pencil = DMatrix::from_fn(n + p, n, |i, j| {
        if i >= n {
            Complex::from(c[(i - n, j)])
        } else {
            Complex::from(a[(i, j)]) - if i == j { lambda } else { Complex::from(0.0) }
        }
    });
    pencil.svd(false, false).singular_values.min()
}

fn assert_perturbation(a: &DMatrix<f64>, c: &DMatrix<f64>, d: &UnobservabilityDistance) {
    let n = a.nrows();
    let full = |m: &DMatrix<f64>| m.map(Complex::from);
    let v = &d.direction;
    let motion = (full(a) + d.perturbation.rows(0, n)) * v - v * d.at;
    let trace = (full(c) + d.perturbation.rows(n, c.nrows())) * v;
    let bound = 20.0 * (n + c.nrows()) as f64 * f64::EPSILON * a.norm().hypot(c.norm());
    assert!(motion.norm().hypot(trace.norm()) <= bound, "{:e} > {bound:e}", motion.norm().hypot(trace.norm()));
    assert!((d.perturbation.norm() - d.upper).abs() <= bound);
    assert!((v.norm() - 1.0).abs() < 1e-14 && d.lower <= d.upper);
}

/// `A = [a]`: the distance is |c|, at lambda = a.
#[test]
fn one_state() {
    let d = distance_to_unobservability(&dmatrix![5.0], &dmatrix![0.25]).unwrap();
    assert!((d.upper - 0.25).abs() < 1e-15 && (d.at - 5.0).norm() < 1e-7);
    assert!(d.lower > 0.2 && d.lower <= 0.25);
}

/// Two real modes 2h apart, seen alike: `sigma^2` of `[diag(h, -h) - i y; 1 1]`'s columns at the midpoint. The 2 x 2
/// normal matrix is `[h^2+1 1; 1 h^2+1]`, so sigma = h at lambda = 0, which is the minimum by symmetry; at the
/// eigenvalues sigma is larger.
#[test]
fn the_minimum_may_lie_between_the_eigenvalues() {
    let h = 0.01;
    let (a, c) = (dmatrix![h, 0.0; 0.0, -h], dmatrix![1.0, 1.0]);
    let d = distance_to_unobservability(&a, &c).unwrap();
    assert_abs_diff_eq!(d.upper, h, epsilon = 1e-12);
    assert!(d.at.norm() < 1e-6 && d.lower >= 0.9 * h - 1e-14, "{} {:e}", d.at, d.lower);
    assert!(sigma_min(&a, &c, Complex::from(h)) > 1.2 * h);
    assert_perturbation(&a, &c, &d);
}

/// Far from normal: Kahan's triangle with its corner entry seen. Both bounds agree with a grid over the plane, which is
/// far below the margins at the eigenvalues.
#[test]
fn a_matrix_far_from_normal() {
    let n = 6;
    let a = DMatrix::from_fn(n, n, |i, j| match i.cmp(&j) {
        Ordering::Equal => 0.3_f64.powf(i as f64),
        Ordering::Less => -1.0,
        Ordering::Greater => 0.0,
    });
    let c = DMatrix::from_fn(1, n, |_, j| if j == n - 1 { 0.0 } else { 0.1 });
    let d = distance_to_unobservability(&a, &c).unwrap();
    assert_perturbation(&a, &c, &d);
    let mut least = f64::INFINITY;
    for i in 0..=120 {
        for k in 0..=40 {
            least = least.min(sigma_min(&a, &c, Complex::new(-3.0 + 0.05 * f64::from(i), 0.05 * f64::from(k))));
        }
    }
    // The grid is 0.05 sqrt(1/2) from any point at most, and sigma is 1-Lipschitz.
    assert!(d.upper <= least * (1.0 + 1e-12) && d.upper >= least - 0.0354, "{:e} {least:e}", d.upper);
    assert!(d.lower > 0.0, "{d:?}");
}

#[test]
fn hidden_modes_are_at_distance_zero() {
    let a = dmatrix![0.0, 1.0, 0.0; -1.0, 0.0, 0.0; 0.5, 0.0, -2.0];
    let c = dmatrix![1.0, 1.0, 0.0];
    let d = distance_to_unobservability(&a, &c).unwrap();
    assert!(d.upper < 1e-15 && d.lower == 0.0 && (d.at + 2.0).norm() < 1e-12);
    let none = distance_to_unobservability(&a, &DMatrix::zeros(0, 3)).unwrap();
    assert!(none.upper < 1e-15 && none.lower == 0.0);
    let zero = distance_to_unobservability(&DMatrix::zeros(2, 2), &DMatrix::zeros(1, 2)).unwrap();
    assert_eq!((zero.lower, zero.upper), (0.0, 0.0));
}

/// In units 12 decades off, everything scales.
#[test]
fn the_distance_scales_with_the_data() {
    let (a, c) = (dmatrix![-1.0, 1.0; 0.0, -1.5], dmatrix![0.5, 0.1]);
    let one = distance_to_unobservability(&a, &c).unwrap();
    for scale in [2f64.powi(40), 2f64.powi(-40), 2f64.powi(900)] {
        let d = distance_to_unobservability(&(&a * scale), &(&c * scale)).unwrap();
        assert_eq!((d.lower / scale, d.upper / scale, d.at / scale), (one.lower, one.upper, one.at));
    }
}

#[test]
fn bad_input_is_named() {
    let (a, c) = (dmatrix![0.0, 1.0; 0.0, 0.0], dmatrix![1.0, 0.0]);
    assert!(matches!(distance_to_unobservability(&c, &c), Err(LinalgError::NotSquare { what: "A", .. })));
    assert!(matches!(
        distance_to_unobservability(&a, &dmatrix![1.0]),
        Err(LinalgError::DimensionMismatch { what: "C", .. })
    ));
    assert!(matches!(
        distance_to_unobservability(&a, &dmatrix![f64::INFINITY, 0.0]),
        Err(LinalgError::NotFinite { .. })
    ));
    let empty = distance_to_unobservability(&DMatrix::zeros(0, 0), &DMatrix::zeros(1, 0));
    assert_eq!(empty.unwrap_err(), LinalgError::Empty { what: "A" });
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(24))]

    /// `d(A, C) = min sigma_min`: no point of the plane is below the lower bound, the perturbation is admissible and of
    /// the size of the upper one, and perturbations smaller than the lower bound leave every lambda observable.
    #[test]
    fn the_bounds_hold(
        (n, p, entries) in (1..=5_usize, 1..=2_usize).prop_flat_map(|(n, p)| (Just(n), Just(p), prop::collection::vec(-1.0..1.0_f64, (n + p) * n))),
        points in prop::collection::vec((-3.0..3.0_f64, 0.0..3.0_f64), 40),
    ) {
        let all = DMatrix::from_vec(n + p, n, entries);
        let (a, c) = (all.rows(0, n).into_owned(), all.rows(n, p).into_owned());
        let d = distance_to_unobservability(&a, &c).unwrap();
        assert_perturbation(&a, &c, &d);
        prop_assert!(d.lower >= 0.9 * d.upper - 1e-13 || d.evaluations >= 4000, "{d:?}");
        for (x, y) in points {
            let sigma = sigma_min(&a, &c, Complex::new(x, y));
            prop_assert!(sigma >= d.lower, "{sigma:e} at {x} + {y}i below {:e}", d.lower);
        }
        for at in [d.at, d.at + 1e-3, d.at + Complex::i() * 1e-3] {
            prop_assert!(sigma_min(&a, &c, at) >= d.lower);
        }
    }
}
