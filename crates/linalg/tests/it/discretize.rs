//! The exponential against closed forms, and discretisation against what it means.

use luenberger_linalg::{LinalgError, expm, zero_order_hold, zero_order_hold_observer};
use nalgebra::{DMatrix, DVector, dmatrix};
use proptest::prelude::*;

fn relative(x: &DMatrix<f64>, y: &DMatrix<f64>) -> f64 {
    (x - y).norm() / y.norm()
}

#[test]
fn a_nilpotent_matrix_gives_its_polynomial() {
    let a = dmatrix![0.0, 1e3, -7.0; 0.0, 0.0, 2e3; 0.0, 0.0, 0.0];
    let exact = DMatrix::identity(3, 3) + &a + &a * &a / 2.0;
    assert!(relative(&expm(&a).unwrap(), &exact) < 1e-15);
}

/// No power of a nilpotent matrix grows: a method that looks at the norm alone would square 20 times and lose six
/// digits of the ones.
#[test]
fn nonnormality_costs_no_squarings() {
    let e = expm(&dmatrix![1.0, 1e6; 0.0, -1.0]).unwrap();
    let exact = dmatrix![1f64.exp(), 1e6 * 1f64.sinh(); 0.0, (-1f64).exp()];
    for i in 0..4 {
        assert!((e[i] - exact[i]).abs() <= 4e-15 * exact[i].abs(), "entry {i}: {} for {}", e[i], exact[i]);
    }
}

#[test]
fn a_jordan_block() {
    let lambda = -0.3;
    let a = DMatrix::from_fn(5, 5, |i, j| {
        if i == j {
            lambda
        } else if j == i + 1 {
            1.0
        } else {
            0.0
        }
    });
    let factorials = [1.0, 1.0, 2.0, 6.0, 24.0];
    let exact = DMatrix::from_fn(5, 5, |i, j| if j >= i { f64::exp(lambda) / factorials[j - i] } else { 0.0 });
    assert!(relative(&expm(&a).unwrap(), &exact) < 1e-15);
}

/// The condition of the exponential of a skew matrix is its norm: eps times that is all that is lost.
#[test]
fn a_rotation_at_every_rate() {
    for rate in [1e-12_f64, 1e-3, 0.1, 1.0, 2.0, 5.0, 30.0, 1e3, 1e6] {
        let e = expm(&dmatrix![0.0, -rate; rate, 0.0]).unwrap();
        let exact = dmatrix![rate.cos(), -rate.sin(); rate.sin(), rate.cos()];
        assert!(relative(&e, &exact) < 10.0 * f64::EPSILON * rate.max(1.0), "rate {rate}: {:e}", relative(&e, &exact));
    }
}

#[test]
fn one_by_one_and_empty_and_zero() {
    for x in [-745.0_f64, -1e6, -1.0, 1e-300, 0.5, 700.0] {
        let e = expm(&dmatrix![x]).unwrap()[0];
        assert!(
            (e - x.exp()).abs() <= 200.0 * f64::EPSILON * x.abs().max(1.0) * x.exp(),
            "{x}: {e:e} for {:e}",
            x.exp()
        );
    }
    assert_eq!(expm(&DMatrix::zeros(0, 0)).unwrap(), DMatrix::zeros(0, 0));
    assert_eq!(expm(&DMatrix::zeros(3, 3)).unwrap(), DMatrix::identity(3, 3));
}

/// Moler and Van Loan, SIAM Review 20, 1978, section 3: eigenvalues -1 and -17, and a Taylor series that fails.
#[test]
fn the_example_of_moler_and_van_loan() {
    let e = expm(&dmatrix![-49.0, 24.0; -64.0, 31.0]).unwrap();
    // V diag(e^-1, e^-17) V^-1 with V = [1 3; 2 4].
    let (slow, fast) = ((-1f64).exp(), (-17f64).exp());
    let exact = dmatrix![-2.0 * slow + 3.0 * fast, 1.5 * (slow - fast); -4.0 * (slow - fast), 3.0 * slow - 2.0 * fast];
    assert!(relative(&e, &exact) < 1e-13, "{:e}", relative(&e, &exact));
}

/// States in units 24 decades apart: each entry is as accurate as in reasonable units.
#[test]
fn extreme_units_of_the_states() {
    let a = dmatrix![-1.0, 2.0, 0.5; -1.5, -0.3, 1.0; 0.7, -0.2, -2.0];
    let e = expm(&a).unwrap();
    let d = [1e12, 1.0, 1e-12];
    let scaled = expm(&DMatrix::from_fn(3, 3, |i, j| a[(i, j)] * d[i] / d[j])).unwrap();
    for i in 0..3 {
        for j in 0..3 {
            let expected = e[(i, j)] * d[i] / d[j];
            let error = (scaled[(i, j)] - expected).abs() / expected.abs();
            assert!(error < 1e-12, "[{i}, {j}]: {error:e}");
        }
    }
}

#[test]
fn what_does_not_fit_a_double_is_an_error() {
    assert_eq!(expm(&dmatrix![710.0]).unwrap_err(), LinalgError::Overflow { what: "e^A" });
    assert_eq!(expm(&dmatrix![1e200, 1e200; 0.0, 3.0]).unwrap_err(), LinalgError::Overflow { what: "e^A" });
    assert_eq!(
        zero_order_hold(&dmatrix![1000.0], &dmatrix![1.0], 1.0).unwrap_err(),
        LinalgError::Overflow { what: "e^{Ah}" }
    );
    assert_eq!(expm(&dmatrix![-1e300]).unwrap(), dmatrix![0.0]);
}

#[test]
fn bad_input_is_named() {
    let (a, b) = (dmatrix![0.0, 1.0; 0.0, 0.0], dmatrix![0.0; 1.0]);
    for h in [0.0, -0.1, f64::INFINITY] {
        assert_eq!(zero_order_hold(&a, &b, h).unwrap_err(), LinalgError::InvalidPeriod { h });
    }
    assert!(matches!(zero_order_hold(&a, &b, f64::NAN), Err(LinalgError::InvalidPeriod { .. })));
    assert!(matches!(expm(&dmatrix![f64::NAN]), Err(LinalgError::NotFinite { what: "A", row: 0, col: 0, .. })));
    assert!(matches!(expm(&DMatrix::zeros(2, 3)), Err(LinalgError::NotSquare { what: "A", rows: 2, cols: 3 })));
    let wide = zero_order_hold(&a, &dmatrix![1.0, 2.0], 0.1).unwrap_err();
    assert_eq!(wide, LinalgError::DimensionMismatch { what: "B", expected: (2, 2), found: (1, 2) });
    let l = dmatrix![1.0, 1.0; 1.0, 1.0];
    let injected = zero_order_hold_observer(&a, &b, &l, &dmatrix![1.0, 0.0], 0.1).unwrap_err();
    assert_eq!(injected, LinalgError::DimensionMismatch { what: "L", expected: (2, 1), found: (2, 2) });
}

/// Inputs in units 12 decades off do not touch the accuracy of `Ad`.
#[test]
fn the_size_of_b_does_not_matter() {
    let a = dmatrix![-1.0, 2.0; -3.0, -4.0];
    for size in [1e-12, 1.0, 1e12] {
        let sampled = zero_order_hold(&a, &(dmatrix![1.0; 2.0] * size), 0.1).unwrap();
        let unit = zero_order_hold(&a, &dmatrix![1.0; 2.0], 0.1).unwrap();
        assert!(relative(&sampled.ad, &unit.ad) < 1e-15 && relative(&sampled.bd, &(unit.bd * size)) < 1e-15);
    }
}

#[test]
fn a_plant_without_inputs_is_only_advanced() {
    let sampled = zero_order_hold(&dmatrix![-1.0], &DMatrix::zeros(1, 0), 0.5).unwrap();
    assert_eq!(sampled.bd.shape(), (1, 0));
    assert!((sampled.ad[0] - (-0.5f64).exp()).abs() < f64::EPSILON);
}

fn matrix(rows: usize, columns: usize, size: f64) -> impl Strategy<Value = DMatrix<f64>> {
    prop::collection::vec(-size..size, rows * columns).prop_map(move |x| DMatrix::from_vec(rows, columns, x))
}

fn plant() -> impl Strategy<Value = (DMatrix<f64>, DMatrix<f64>, DMatrix<f64>, DMatrix<f64>)> {
    (1usize..=6, 1usize..=3, 1usize..=3)
        .prop_flat_map(|(n, m, p)| (matrix(n, n, 2.0), matrix(n, m, 2.0), matrix(n, p, 2.0), matrix(p, n, 2.0)))
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(64))]

    /// `e^A` solves `X' = A X`: the Taylor series, summed where it converges at once, squared back up.
    #[test]
    fn the_exponential_agrees_with_its_series((a, ..) in plant()) {
        let small = &a / 64.0;
        let mut term = DMatrix::identity(a.nrows(), a.nrows());
        let mut sum = term.clone();
        for k in 1..30 {
            term = &small * term / f64::from(k);
            sum += &term;
        }
        for _ in 0..6 {
            sum = &sum * &sum;
        }
        let bound = 64.0 * 20.0 * f64::EPSILON * a.norm().exp();
        let difference = (expm(&a).unwrap() - &sum).norm();
        prop_assert!(difference <= bound, "{difference:e} > {bound:e}");
    }

    /// `e^{A} e^{-A} = I`.
    #[test]
    fn the_inverse_is_the_exponential_of_minus_a((a, ..) in plant()) {
        let (e, inverse) = (expm(&a).unwrap(), expm(&-&a).unwrap());
        let residual = (&e * &inverse - DMatrix::identity(a.nrows(), a.nrows())).norm();
        prop_assert!(residual <= 100.0 * f64::EPSILON * (1.0 + a.norm()) * e.norm() * inverse.norm(), "{residual:e}");
    }

    /// Two periods are one of twice the length: `Ad(2h) = Ad^2`, `Bd(2h) = Ad Bd + Bd`.
    #[test]
    fn two_periods_make_one((a, b, ..) in plant(), h in 0.001f64..0.5) {
        let (one, two) = (zero_order_hold(&a, &b, h).unwrap(), zero_order_hold(&a, &b, 2.0 * h).unwrap());
        let bound = 100.0 * f64::EPSILON * (2.0 * h * a.norm()).exp() * (1.0 + b.norm());
        prop_assert!((&two.ad - &one.ad * &one.ad).norm() <= bound);
        prop_assert!((&two.bd - (&one.ad * &one.bd + &one.bd)).norm() <= bound);
    }

    /// `A Bd = (Ad - I) B`: the integral of `e^{As} A`.
    #[test]
    fn the_integral_of_the_exponential((a, b, ..) in plant(), h in 0.001f64..1.0) {
        let sampled = zero_order_hold(&a, &b, h).unwrap();
        let residual = (&a * &sampled.bd - (&sampled.ad - DMatrix::identity(a.nrows(), a.nrows())) * &b).norm();
        let bound = 100.0 * f64::EPSILON * (h * a.norm()).exp() * (1.0 + a.norm()) * b.norm();
        prop_assert!(residual <= bound, "{residual:e} > {bound:e}");
    }

    /// The sampled observer follows its differential equation with u and y held: 400 Runge-Kutta steps.
    #[test]
    fn the_sampled_observer_follows_its_equation((a, b, l, c) in plant(), h in 0.01f64..0.2) {
        let sampled = zero_order_hold_observer(&a, &b, &l, &c, h).unwrap();
        let n = a.nrows();
        let start = DVector::from_fn(n, |i, _| 1.0 - 0.4 * i as f64);
        let (u, y) = (DVector::from_element(b.ncols(), 0.7), DVector::from_element(c.nrows(), -1.3));
        let derivative = |x: &DVector<f64>| &a * x + &b * &u + &l * (&y - &c * x);
        let (mut x, step) = (start.clone(), h / 400.0);
        for _ in 0..400 {
            let k1 = derivative(&x);
            let k2 = derivative(&(&x + &k1 * (step / 2.0)));
            let k3 = derivative(&(&x + &k2 * (step / 2.0)));
            let k4 = derivative(&(&x + &k3 * step));
            x += (k1 + k2 * 2.0 + k3 * 2.0 + k4) * (step / 6.0);
        }
        let once = &sampled.fd * start + &sampled.bd * u + &sampled.ld * y;
        let growth = (h * (a.norm() + l.norm() * c.norm())).exp();
        prop_assert!((&once - &x).norm() <= 1e-8 * growth * (1.0 + x.norm()), "{once} against {x}");
    }
}
