//! Every solver on every kind of bad input: no panic, no endless loop, and either an answer in which all numbers are
//! finite or an error that carries them.

use luenberger_linalg::{
    DiscreteSylvesterEquation, LinalgError, LyapunovEquation, SteinEquation, SylvesterEquation, care, dare,
    discrete_kalman_gain, discrete_sylvester, generalized_lyapunov, generalized_stein, kalman_gain, lyapunov,
    lyapunov_factor, stein, stein_factor, sylvester,
};
use luenberger_random::Random;
use nalgebra::{DMatrix, dmatrix};
use proptest::prelude::*;

fn identity(n: usize) -> DMatrix<f64> {
    DMatrix::identity(n, n)
}

/// What rounding, underflow and overflow like least.
fn nasty() -> impl Strategy<Value = f64> {
    prop_oneof![
        4 => Just(0.0),
        4 => -2.0..2.0_f64,
        2 => Just(1.0),
        2 => Just(-1.0),
        1 => (-300..300_i32).prop_map(|k| -(10.0_f64.powi(k))),
        1 => (-300..300_i32).prop_map(|k| 10.0_f64.powi(k)),
        1 => prop::sample::select(vec![5e-324, 1e-308, -0.0, f64::MAX, f64::MIN, f64::EPSILON]),
    ]
}

fn finite_or_not() -> impl Strategy<Value = f64> {
    prop_oneof![60 => nasty(), 1 => prop::sample::select(vec![f64::NAN, f64::INFINITY, f64::NEG_INFINITY])]
}

fn matrix(n: usize, m: usize) -> impl Strategy<Value = DMatrix<f64>> {
    prop::collection::vec(finite_or_not(), n * m).prop_map(move |data| DMatrix::from_vec(n, m, data))
}

fn mirrored(m: &DMatrix<f64>) -> DMatrix<f64> {
    DMatrix::from_fn(m.nrows(), m.ncols(), |i, j| m[(i.max(j), i.min(j))])
}

fn all_finite(m: &DMatrix<f64>) -> bool {
    m.iter().all(|x| x.is_finite())
}

/// An error says something, and what it says can be printed.
fn says(error: &LinalgError) -> bool {
    !error.to_string().is_empty()
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 400, failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn nothing_panics_and_answers_are_finite(
        (a, q, b, e) in (0..=5_usize, 0..=3_usize).prop_flat_map(|(n, m)| (matrix(n, n), matrix(n, n), matrix(n, m), matrix(n, n))),
    ) {
        let (n, m) = b.shape();
        let q = mirrored(&q);
        match lyapunov(&a, &q) {
            Ok(x) => prop_assert!(all_finite(&x.p) && x.residual <= 1e-12 && x.separation >= 0.0 && !x.forward_error().is_nan(), "{x:?}"),
            Err(error) => prop_assert!(says(&error)),
        }
        match stein(&a, &q) {
            Ok(x) => prop_assert!(all_finite(&x.p) && x.residual <= 1e-12 && x.separation >= 0.0 && !x.forward_error().is_nan(), "{x:?}"),
            Err(error) => prop_assert!(says(&error)),
        }
        match sylvester(&a, &e, &q) {
            Ok(x) => prop_assert!(all_finite(&x.x) && x.residual <= 1e-12 && !x.forward_error().is_nan(), "{x:?}"),
            Err(error) => prop_assert!(says(&error)),
        }
        match discrete_sylvester(&a, &e, &q) {
            Ok(x) => prop_assert!(all_finite(&x.x) && x.residual <= 1e-12 && x.separation > 0.0 && !x.forward_error().is_nan(), "{x:?}"),
            Err(error) => prop_assert!(says(&error)),
        }
        match generalized_stein(&a, &e, &q) {
            Ok(x) => prop_assert!(all_finite(&x.p) && !x.residual.is_nan() && !x.forward_error().is_nan(), "{x:?}"),
            Err(error) => prop_assert!(says(&error)),
        }
        match generalized_lyapunov(&a, &e, &q) {
            Ok(x) => prop_assert!(all_finite(&x.p) && !x.residual.is_nan() && !x.forward_error().is_nan(), "{x:?}"),
            Err(error) => prop_assert!(says(&error)),
        }
        for found in [lyapunov_factor(&a, &b.transpose()), stein_factor(&a, &b.transpose())] {
            match found {
                Ok(x) => prop_assert!(all_finite(&x.u) && x.residual <= 1e-10, "{x:?}"),
                Err(error) => prop_assert!(says(&error)),
            }
        }
        // Semidefinite weights, so that something beyond the check of them is reached.
        let weight = b.map(|x| x.clamp(-1e100, 1e100));
        let weight = mirrored(&(&weight * weight.transpose()));
        for found in [care(&a, &b, &weight, &identity(m)), dare(&a, &b, &weight, &identity(m))] {
            match found {
                Ok(x) => {
                    prop_assert!(all_finite(&x.x) && all_finite(&x.k) && x.residual <= 1e-7, "{x:?}");
                    prop_assert!(!x.condition.is_nan() && !x.forward_error.is_nan(), "{x:?}");
                }
                Err(error) => prop_assert!(says(&error)),
            }
        }
        for found in [kalman_gain(&a, &b.transpose(), &identity(n), &identity(m)), discrete_kalman_gain(&a, &b.transpose(), &identity(n), &identity(m))] {
            match found {
                Ok(x) => {
                    prop_assert!(all_finite(&x.p) && all_finite(&x.l) && x.residual <= 1e-7, "{x:?}");
                }
                Err(error) => prop_assert!(says(&error)),
            }
        }
    }
}

/// A solution that is normalised for its error has to solve the equation to half of the digits too.
#[test]
fn a_normalised_solution_with_a_large_residual_is_refused() {
    let a = DMatrix::from_column_slice(3, 3, &[0.0, -0.8165451480877692, -1e7, 0.0, 0.0, 0.0, -0.01, 0.0, 0.0]);
    let b = [-0.9621296277868304, 0.0, 5e-324, 0.6789082344145999, 0.0, -1.3304367751013668];
    let b = DMatrix::from_column_slice(3, 2, &b);
    let weight = mirrored(&(&b * b.transpose()));
    let error = dare(&a, &b, &weight, &identity(2)).unwrap_err();
    assert!(matches!(error, LinalgError::NotConverged { remaining, .. } if remaining > 1e-7), "{error}");
}

/// Solutions beyond the range of binary64, or on the way to which numbers leave it, are no answers: P of the first is
/// `diag(p, 1.6e308 p)` or so with `p = 7e15`.
#[test]
fn what_leaves_the_range_of_numbers_is_refused() {
    let a = dmatrix![5e-324, -1.1277891668046065; 1.7976931348623157e308, -1e-16];
    let found = lyapunov(&a, &dmatrix![0.0, 0.0; 0.0, 1.4196036499916698]);
    assert!(matches!(found, Err(LinalgError::Overflow { .. } | LinalgError::UndecidedEquation { .. })), "{found:?}");
    // The norm of the defect overflows where it is computed by squares.
    let a = DMatrix::from_column_slice(
        4,
        4,
        &[
            0.0,
            0.0,
            0.36744635634804335,
            -1e16,
            0.0,
            0.0,
            0.0,
            0.0,
            0.0,
            1.0000000000000001e49,
            0.0,
            0.0,
            1e-49,
            -0.5107135851427008,
            0.5105218033496592,
            1.3798738207231909,
        ],
    );
    let c = DMatrix::from_row_slice(1, 4, &[-1.1208141438540722, -0.2545641392048162, -1.1731863811697305, 100.0]);
    for found in [lyapunov_factor(&a, &c), stein_factor(&a, &c)] {
        assert!(found.as_ref().map_or_else(says, |found| found.residual <= 1e-10), "{found:?}");
    }
    // Newton's iteration ends far from the solution.
    let a = DMatrix::from_column_slice(2, 2, &[-1.0, -1.3152945782779162, 1.0, 1.0]);
    let b = dmatrix![1.0000000000000001e58, 0.0; -0.21869573775935164, 0.0];
    let found = dare(&a, &b, &mirrored(&(&b * b.transpose())), &identity(2));
    assert!(found.as_ref().is_err() || found.as_ref().is_ok_and(|found| found.residual <= 1e-7), "{found:?}");
}

/// An eigenvalue that is stable by less than its own rounding: there is nothing to divide by.
#[test]
fn no_factor_without_damping() {
    let c = dmatrix![0.0, -1.2940691140429188];
    for damping in [5e-324, 1e-300, 1e-17] {
        let rotation = dmatrix![-damping, -1.0; 1.0, -damping];
        for found in [lyapunov_factor(&rotation, &c), stein_factor(&(rotation.clone() * (1.0 - 1e-17)), &c)] {
            assert!(matches!(found, Err(LinalgError::NotStable { .. })), "{damping:e} {found:?}");
        }
    }
    // Little is enough.
    let found = lyapunov_factor(&dmatrix![-1e-14, -1.0; 1.0, -1e-14], &c).unwrap();
    assert!(found.residual <= 10.0 * 2.0 * f64::EPSILON, "{}", found.residual);
}

#[test]
fn the_offending_entry_is_named_in_every_argument() {
    let good = -identity(2);
    for value in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY] {
        let bad = dmatrix![-1.0, 0.0; value, -1.0];
        let names = |found: Result<f64, LinalgError>, name: &str| {
            let Err(LinalgError::NotFinite { what, row: 1, col: 0, value: v }) = found else { panic!("{found:?}") };
            assert!(what == name && (v == value || v.is_nan() && value.is_nan()), "{what} {v}");
        };
        names(lyapunov(&bad, &good).map(|x| x.residual), "A");
        names(lyapunov(&good, &bad).map(|x| x.residual), "Q");
        names(stein(&bad, &good).map(|x| x.residual), "A");
        names(stein(&good, &bad).map(|x| x.residual), "Q");
        names(sylvester(&good, &bad, &good).map(|x| x.residual), "B");
        names(discrete_sylvester(&bad, &good, &good).map(|x| x.residual), "A");
        names(discrete_sylvester(&good, &good, &bad).map(|x| x.residual), "C");
        names(generalized_lyapunov(&good, &bad, &good).map(|x| x.residual), "E");
        names(generalized_stein(&bad, &good, &good).map(|x| x.residual), "A");
        names(lyapunov_factor(&good, &bad).map(|x| x.residual), "C");
        names(care(&good, &bad, &identity(2), &identity(2)).map(|x| x.residual), "B");
        names(care(&good, &good, &identity(2), &bad).map(|x| x.residual), "R");
        names(kalman_gain(&good, &identity(2), &bad, &identity(2)).map(|x| x.residual), "W");
        names(LyapunovEquation::new(&good).unwrap().refine(&identity(2), &mut bad.clone()), "P");
        names(SteinEquation::new(&(&good * 0.5)).unwrap().refine(&bad, &mut identity(2)), "Q");
        names(SylvesterEquation::new(&good, &good).unwrap().refine(&identity(2), &mut bad.clone()), "X");
        let half = &good * 0.5;
        names(DiscreteSylvesterEquation::new(&half, &half).unwrap().refine(&bad, &mut identity(2)), "C");
    }
    let found = LyapunovEquation::new(&good).unwrap().refine(&identity(2), &mut identity(3));
    assert_eq!(found, Err(LinalgError::DimensionMismatch { what: "P", expected: (2, 2), found: (3, 3) }));
    let skew = dmatrix![1.0, 2.0; -2.0, 1.0];
    let found = LyapunovEquation::new(&good).unwrap().refine(&identity(2), &mut skew.clone());
    assert!(matches!(found, Err(LinalgError::NotSymmetric { what: "P", asymmetry: 4.0, .. })), "{found:?}");
    let found = generalized_lyapunov(&good, &identity(2), &skew);
    assert!(matches!(found, Err(LinalgError::NotSymmetric { what: "Q", asymmetry: 4.0, .. })), "{found:?}");
}

/// `lambda_i + lambda_j` from 1 down to 0: solved within its bound as long as the gap is not zero as stored (below
/// 2^-52), and then refused, naming the pair.
#[test]
fn eigenvalues_that_approach_each_other() {
    let mut refused = 0;
    for k in 0..=60 {
        let gap = 2.0_f64.powi(-k);
        let a = dmatrix![1.0, 1.0, 0.0; 0.0, -1.0 - gap, 1.0; 0.0, 0.0, -5.0];
        let p = dmatrix![1.0, 1.0, 2.0; 1.0, 3.0, 0.0; 2.0, 0.0, 1.0];
        // The gap enters Q alone with the entry -gap, exact as long as `1 + gap` is.
        let q = -(a.transpose() * &p + &p * &a);
        match lyapunov(&a, &q) {
            Ok(found) => {
                let error = (&found.p - &p).norm() / p.norm();
                assert!(error <= found.forward_error(), "2^-{k}: {error:e} > {:e}", found.forward_error());
                assert!(found.separation <= 3.0 * 9.0 * gap, "{:e}", found.separation);
                assert_eq!(refused, 0, "2^-{k}: solved, though a larger gap was refused");
            }
            Err(LinalgError::SingularEquation { equation: "Lyapunov", first, second, gap: found }) => {
                assert!((first.re.abs() - 1.0).abs() <= 1e-10 && (second.re.abs() - 1.0).abs() <= 1e-10);
                assert!(found <= 1e-10 && k >= 53, "2^-{k}: {found:e}");
                refused += 1;
            }
            Err(other) => panic!("{other}"),
        }
    }
    assert!(refused >= 8, "a gap below the rounding of the eigenvalues is none");
}

/// `1 - lambda_i mu_j` from 1 down to 0, the coefficients not symmetric to each other: as
/// [`eigenvalues_that_approach_each_other`].
#[test]
fn products_that_approach_one() {
    let mut refused = 0;
    for k in 0..=60 {
        let gap = 2.0_f64.powi(-k);
        let a = dmatrix![2.0, 1.0, 0.0; 0.0, 0.25, 1.0; 0.0, 0.0, -0.5];
        let b = dmatrix![0.5 * (1.0 - gap), 1.0; 0.0, 0.125];
        let x = dmatrix![1.0, 0.0; 0.0, 3.0; 0.0, 1.0];
        // The gap enters C in the corner alone, exact as long as `1 - gap` is.
        let c = &x - &a * &x * &b;
        match discrete_sylvester(&a, &b, &c) {
            Ok(found) => {
                let error = (&found.x - &x).norm() / x.norm();
                assert!(error <= found.forward_error(), "2^-{k}: {error:e} > {:e}", found.forward_error());
                assert!(found.separation <= 3.0 * 6.0 * gap, "{:e}", found.separation);
                assert_eq!(refused, 0, "2^-{k}: solved, though a larger gap was refused");
            }
            Err(LinalgError::SingularEquation { equation: "discrete Sylvester", first, second, gap: found }) => {
                assert!((first.re - 2.0).abs() <= 1e-10 && (second.re - 0.5).abs() <= 1e-10);
                assert!(found <= 1e-10 && k >= 53, "2^-{k}: {found:e}");
                refused += 1;
            }
            Err(other) => panic!("{other}"),
        }
    }
    // From 2^-54 on, `1 - gap` is one as stored.
    assert_eq!(refused, 7);
}

#[test]
fn what_is_not_stable_is_refused_where_a_definite_solution_is_promised() {
    let c = dmatrix![1.0, 1.0];
    for lambda in [0.0, 1e-300, 2.5] {
        let a = dmatrix![lambda, 1.0; 0.0, -1.0];
        let Err(LinalgError::NotStable { equation: "Lyapunov", eigenvalue }) = lyapunov_factor(&a, &c) else {
            panic!("{lambda:e} is not stable")
        };
        assert_eq!((eigenvalue.re, eigenvalue.im), (lambda, 0.0));
    }
    for radius in [1.0, 1.0 + 1e-15, 4.0] {
        let a = dmatrix![0.0, -radius; radius, 0.0];
        let Err(LinalgError::NotStable { equation: "Stein", eigenvalue }) = stein_factor(&a, &c) else {
            panic!("{radius} is not inside")
        };
        assert!((eigenvalue.norm() - radius).abs() <= 4.0 * f64::EPSILON * radius);
    }
}

/// Entries from 1e-150 to 1e150: by the units of the state, which a balance undoes, and by time constants, which
/// nothing does.
#[test]
fn graded_matrices() {
    let entry = |i: usize, j: usize| ((1 + 5 * i + 3 * j * j + i * j) as f64).sin();
    for n in [2_usize, 5, 9] {
        let m = DMatrix::from_fn(n, n, |i, j| entry(i, j) - if i == j { n as f64 + 1.0 } else { 0.0 });
        let exponent = |i: usize| (-75.0 + 150.0 * i as f64 / (n - 1) as f64).round() as i32 * 3;
        let unit = |i: usize| 2.0_f64.powi(exponent(i));
        let a = DMatrix::from_fn(n, n, |i, j| m[(i, j)] * unit(j) / unit(i));
        let q = DMatrix::from_fn(n, n, |i, j| if i == j { unit(i) * unit(i) } else { 0.0 });
        let (found, plain) = (lyapunov(&a, &q).unwrap(), lyapunov(&m, &identity(n)).unwrap());
        let back = DMatrix::from_fn(n, n, |i, j| found.p[(i, j)] / unit(i) / unit(j));
        let allowed = (found.forward_error() + plain.forward_error()) * plain.p.norm();
        assert!((back - &plain.p).norm() <= allowed && allowed <= 1e-9 * plain.p.norm(), "n = {n}");
        // Rates from 1e-150 to 1e150: sums of rates below the rounding of the largest are zero for all that its Schur
        // form can tell, and it says so.
        let rate = |i: usize| 10.0_f64.powf(-75.0 + 150.0 * i as f64 / (n - 1) as f64);
        let a = DMatrix::from_fn(n, n, |i, j| m[(i, j)] * rate(i) * rate(j));
        match lyapunov(&a, &identity(n)) {
            Ok(found) => assert!(all_finite(&found.p) && found.residual <= 1e-13),
            Err(LinalgError::UndecidedEquation { separation, .. }) => {
                assert!(separation <= n as f64 * f64::EPSILON * a.norm(), "{separation:e}");
            }
            Err(other) => panic!("{other}"),
        }
    }
}

/// One run at a size where blocks, products and scratch space matter.
#[test]
fn three_hundred_states() {
    let n = 300;
    let mut random = Random(7);
    let m = random.matrix(n, n);
    let q = mirrored(&random.matrix(n, n));
    // The spectral radius of such a matrix is about sqrt(n/3).
    let a = &m / (n as f64 / 3.0).sqrt() - identity(n) * 1.5;
    let mut equation = LyapunovEquation::new(&a).unwrap();
    assert!(equation.is_stable());
    let found = equation.solve(&q).unwrap();
    assert!(found.residual <= 30.0 * n as f64 * f64::EPSILON);
    let mut better = found.p.clone();
    let moved = equation.refine(&q, &mut better).unwrap();
    assert!(moved > 0.0 && moved <= found.forward_error() && found.forward_error() <= 1e-6, "{moved:e}");
    // What is left is the rounding of P.
    assert!(equation.refine(&q, &mut better).unwrap() <= 2.0 * f64::EPSILON);
    let found = stein(&(&m * (0.9 / (n as f64 / 3.0).sqrt())), &q).unwrap();
    assert!(found.residual <= 30.0 * n as f64 * f64::EPSILON);
}
