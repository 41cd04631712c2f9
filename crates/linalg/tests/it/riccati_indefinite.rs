//! Riccati equations with an indefinite weight of the input: known solutions, published forms, and equations without a
//! stabilizing solution.

use luenberger_linalg::{
    LinalgError, Riccati, care, dare, dlqr, generalized_care, generalized_dare, lqr, spectral_abscissa, spectral_radius,
};
use nalgebra::{DMatrix, dmatrix};
use proptest::prelude::*;

fn entries(n: usize, m: usize) -> impl Strategy<Value = DMatrix<f64>> {
    prop::collection::vec(-1.0..1.0_f64, n * m).prop_map(move |data| DMatrix::from_row_slice(n, m, &data))
}

/// An equation with its stabilizing solution.
#[derive(Debug, Clone)]
struct Known {
    a: DMatrix<f64>,
    b: DMatrix<f64>,
    q: DMatrix<f64>,
    r: DMatrix<f64>,
    s: DMatrix<f64>,
    e: DMatrix<f64>,
    x: DMatrix<f64>,
    /// Sum of the norms of the terms of Q over the norm of Q: what its rounding is.
    cancelled: f64,
}

/// From X, R of both signs and a stable closed loop F: with `K = R^-1 (B'X E + S')`, in discrete time
/// `R^-1 (B'X F E + S')`, `A = F E + B K` has the closed loop F, and Q follows.
fn known(discrete: bool, general: bool) -> impl Strategy<Value = Known> {
    (1..=6_usize, 2..=4_usize)
        .prop_flat_map(|(n, m)| {
            let square = || entries(n, n);
            (square(), square(), square(), entries(n, m), entries(n, m), entries(m, m), 0.2..0.8_f64, 1..m)
        })
        .prop_map(move |(f, x, e, b, s, turn, margin, positive)| {
            let (n, m) = b.shape();
            let identity = DMatrix::<f64>::identity(n, n);
            let f = if discrete { &f * (margin / f.norm()) } else { &f - &identity * (f.norm() + margin) };
            let x = &x + x.transpose();
            let turn = turn.qr().q();
            let signs = DMatrix::from_fn(m, m, |i, j| {
                let size = 1.0 + i as f64;
                if i != j {
                    0.0
                } else if i < positive {
                    size
                } else {
                    -size
                }
            });
            let r = &turn * signs * turn.transpose();
            let r = (&r + r.transpose()) * 0.5;
            let (e, s) =
                if general { (e * 0.3 + &identity * 2.0, s) } else { (identity.clone(), DMatrix::zeros(n, m)) };
            let fe = &f * &e;
            let seen = if discrete { &fe } else { &e };
            let k = r.clone().lu().solve(&(b.transpose() * &x * seen + s.transpose())).unwrap();
            let a = &fe + &b * &k;
            let cross = if discrete { a.transpose() * &x * &b } else { e.transpose() * &x * &b } + &s;
            let (linear, size) = if discrete {
                let (held, moved) = (e.transpose() * &x * &e, a.transpose() * &x * &a);
                let size = held.norm() + moved.norm();
                (held - moved, size)
            } else {
                let half = a.transpose() * &x * &e;
                (-&half - half.transpose(), 2.0 * half.norm())
            };
            let quadratic = cross * &k;
            let q = linear + &quadratic;
            let q = (&q + q.transpose()) * 0.5;
            let cancelled = (size + quadratic.norm()) / q.norm();
            Known { a, b, q, r, s, e, x, cancelled }
        })
}

/// In discrete time, from an X so negative that `R + B'X B <= -2`, R positive definite or zero, and an A, with S, so
/// small that `A - B K`, `K = (R + B'X B)^-1 (B'X A + S')`, is stable.
fn turned(general: bool) -> impl Strategy<Value = Known> {
    (1..=5_usize, 1..=2_usize)
        .prop_flat_map(|(n, m)| {
            let (square, m) = (|| entries(n, n), m.min(n));
            (square(), square(), square(), entries(n, m), entries(n, m), entries(m, m), 0.2..0.8_f64, any::<bool>())
        })
        .prop_map(move |(a, x, e, b, s, r, margin, is_weighted)| {
            let (n, m) = b.shape();
            let identity = DMatrix::<f64>::identity(n, n);
            let b = DMatrix::from_fn(n, m, |i, j| if i == j { b[(i, j)] + 3.0 } else { b[(i, j)] });
            let x = -(&x * x.transpose() + &identity * 6.0);
            let r = if is_weighted { &r * r.transpose() + DMatrix::identity(m, m) } else { DMatrix::zeros(m, m) };
            let (e, s) =
                if general { (e * 0.3 + &identity * 2.0, s) } else { (identity.clone(), DMatrix::zeros(n, m)) };
            let weight = (&r + b.transpose() * &x * &b).lu();
            let gain =
                |a: &DMatrix<f64>, s: &DMatrix<f64>| weight.solve(&(b.transpose() * &x * a + s.transpose())).unwrap();
            let closed = (&a - &b * gain(&a, &s)) * e.clone().try_inverse().unwrap();
            let small = margin / closed.norm().max(0.1);
            let (a, s) = (a * small, s * small);
            let k = gain(&a, &s);
            let (held, moved) = (e.transpose() * &x * &e, a.transpose() * &x * &a);
            let quadratic = (a.transpose() * &x * &b + &s) * k;
            let q = &held - &moved + &quadratic;
            let q = (&q + q.transpose()) * 0.5;
            let cancelled = (held.norm() + moved.norm() + quadratic.norm()) / q.norm();
            Known { a, b, q, r, s, e, x, cancelled }
        })
}

impl Known {
    fn solve(&self, discrete: bool, general: bool) -> Result<Riccati, LinalgError> {
        let Self { a, b, q, r, s, e, .. } = self;
        match (discrete, general) {
            (false, false) => care(a, b, q, r),
            (true, false) => dare(a, b, q, r),
            (false, true) => generalized_care(a, b, q, r, s, e),
            (true, true) => generalized_dare(a, b, q, r, s, e),
        }
    }

    fn is_found(&self, discrete: bool, general: bool) -> Result<(), TestCaseError> {
        let n = self.a.nrows();
        let found = match self.solve(discrete, general) {
            Ok(found) => found,
            Err(error) => return Err(TestCaseError::fail(error.to_string())),
        };
        prop_assert_eq!(&found.x, &found.x.transpose());
        prop_assert!(found.residual <= 50.0 * (n + 3) as f64 * f64::EPSILON * 10.0, "{:e}", found.residual);
        let closed = (&self.a - &self.b * &found.k) * self.e.clone().try_inverse().unwrap();
        let is_stable =
            if discrete { spectral_radius(&closed).unwrap() < 1.0 } else { spectral_abscissa(&closed).unwrap() < 0.0 };
        prop_assert!(is_stable, "{closed}");
        // The bound holds for Q as rounded, which moves the solution by its condition.
        let rounding = 20.0 * n as f64 * f64::EPSILON * self.cancelled.max(1.0) * found.condition;
        let error = (&found.x - &self.x).norm() / self.x.norm();
        prop_assert!(error <= found.forward_error + rounding, "{error:e} {:e} {rounding:e}", found.forward_error);
        Ok(())
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(96))]

    /// The solution by construction, of either sign, is found within its bound.
    #[test]
    fn the_solution_is_found(p in known(false, false)) {
        p.is_found(false, false)?;
    }

    #[test]
    fn the_discrete_solution_is_found(p in known(true, false)) {
        p.is_found(true, false)?;
    }

    /// R is no worse than indefinite: the solution with `R + B'X B < 0`.
    #[test]
    fn a_solution_that_turns_the_weight_is_found(p in turned(false)) {
        p.is_found(true, false)?;
    }

    #[test]
    fn a_generalized_solution_that_turns_the_weight_is_found(p in turned(true)) {
        p.is_found(true, true)?;
    }

    #[test]
    fn the_generalized_solution_is_found(p in known(false, true)) {
        p.is_found(false, true)?;
    }

    #[test]
    fn the_generalized_discrete_solution_is_found(p in known(true, true)) {
        p.is_found(true, true)?;
    }
}

/// `[C' H']` and `diag(1, -gamma^2)` of the H-infinity filter of an oscillator that measures its position.
fn filter(gamma: f64) -> [DMatrix<f64>; 4] {
    let (square, zero) = (-gamma * gamma, 0.0);
    [
        dmatrix![0.0, -2.0; 1.0, -0.3],
        dmatrix![1.0, 1.0, 0.0; 0.0, 0.0, 1.0],
        dmatrix![0.0, 0.0; 0.0, 1.0],
        dmatrix![1.0, zero, zero; zero, square, zero; zero, zero, square],
    ]
}

#[test]
fn values_of_scipy() {
    // scipy 1.17.1, solve_continuous_are and solve_discrete_are; with E and S for balanced = False, since its balancing
    // leaves a residual of 0.2 here.
    let [a, b, q, r] = filter(10.0);
    let close = |found: &Riccati, expected: &DMatrix<f64>| {
        let error = (&found.x - expected).norm() / expected.norm();
        assert!(error <= 1e-13, "{error:e} {}", found.x);
    };
    close(
        &care(&a, &b, &q, &r).unwrap(),
        &dmatrix![0.454_430_618_090_504_2, 0.102_168_865_010_880_02; 0.102_168_865_010_880_02, 0.984_470_447_273_659_8],
    );
    let (b, q) = (dmatrix![1.0, 0.0; 0.0, 1.0; 1.0, 1.0], dmatrix![1.0, 0.0, 0.0; 0.0, -0.5, 0.0; 0.0, 0.0, 0.2]);
    let r = dmatrix![2.0, 0.5; 0.5, -100.0];
    let a = dmatrix![0.9, 0.2, 0.0; -0.1, 0.7, 0.3; 0.0, 0.2, 0.5];
    // X has eigenvalues of both signs.
    close(
        &dare(&a, &b, &q, &r).unwrap(),
        &dmatrix![
            1.590_038_628_803_611_5, 0.438_414_939_133_994_3, 0.162_692_943_304_167_9;
            0.438_414_939_133_994_3, -0.846_522_047_446_451, -0.250_480_828_479_843;
            0.162_692_943_304_167_9, -0.250_480_828_479_843, 0.058_364_460_014_955_45],
    );
    let a = dmatrix![0.0, 1.0, 0.0; 0.0, 0.0, 1.0; -6.0, -11.0, -6.0];
    let (s, e) = (dmatrix![0.1, 0.0; 0.0, 0.2; 0.1, -0.1], dmatrix![1.0, 0.2, 0.0; 0.0, 2.0, 0.0; 0.3, 0.0, 1.0]);
    close(
        &generalized_care(&a, &b, &q, &r, &s, &e).unwrap(),
        &dmatrix![
            1.051_151_617_303_311, 0.339_922_320_520_406_5, 0.019_480_303_783_093;
            0.339_922_320_520_406_5, 0.207_969_188_014_099_2, 0.017_398_493_963_256_7;
            0.019_480_303_783_093, 0.017_398_493_963_256_7, 0.018_777_999_171_247_6],
    );
}

/// X^2 (3/4) - X (3/4) - 1 = 0 for `R = diag(1, -4)` and `B = [1 1]`.
#[test]
fn a_discrete_equation_in_closed_form() {
    let one = dmatrix![1.0];
    let found = dare(&one, &dmatrix![1.0, 1.0], &one, &dmatrix![1.0, 0.0; 0.0, -4.0]).unwrap();
    let expected = (0.75 + 3.5625_f64.sqrt()) / 1.5;
    assert!((found.x[(0, 0)] - expected).abs() <= found.forward_error * expected && found.forward_error < 1e-13);
    assert!((expected - 1.758_306).abs() < 1e-6);
}

/// a = 1/2, b = r = 1, q = -27/8: `x^2 + 33/8 x + 27/8 = 0` has the roots -9/8, with the pole -4, and -3, with -1/4. For
/// r = 0 it is `x = q`, with the pole 0. scipy.linalg.solve_discrete_are returns the same.
#[test]
fn a_solution_with_a_negative_input_weight() {
    let (a, one) = (dmatrix![0.5], dmatrix![1.0]);
    let found = dare(&a, &one, &dmatrix![-3.375], &one).unwrap();
    assert!((found.x[0] + 3.0).abs() <= 3.0 * found.forward_error && found.forward_error < 1e-13, "{found:?}");
    assert!((found.k[0] - 0.75).abs() < 1e-14 && (found.poles[0].re + 0.25).abs() < 1e-14, "{found:?}");
    let found = dare(&a, &one, &dmatrix![-1.0], &dmatrix![0.0]).unwrap();
    assert!((found.x[0] + 1.0).abs() < 1e-14 && (found.k[0] - 0.5).abs() < 1e-14, "{found:?}");
    // No solution at all, as before.
    assert!(dare(&a, &one, &dmatrix![-0.26], &one).is_err());
    // A regulator's weights are a cost.
    assert!(matches!(dlqr(&a, &one, &dmatrix![-3.375], &one), Err(LinalgError::NotPositiveSemidefinite { .. })));
}

/// The H-infinity filter of `x' = -x + w1`, `y = x + w2`, `z = x`: `-2 P - (1 - 1/gamma^2) P^2 + 1 = 0`, with a double
/// root at the least norm, `gamma^2 = 1/2`, and none below.
#[test]
fn near_the_boundary_an_error_is_within_its_bound_or_named() {
    let is_named =
        |error: &LinalgError| matches!(error, LinalgError::NotStabilizing { .. } | LinalgError::NoStabilizingSolution);
    let one = dmatrix![1.0];
    let solve = |square: f64| care(&-&one, &dmatrix![1.0, 1.0], &one, &dmatrix![1.0, 0.0; 0.0, -square]);
    let mut found_near = 0;
    for k in 1..=52 {
        let delta = 0.5_f64.powi(k);
        let square = 0.5 * (1.0 + delta);
        // 1 - 1/square = -(1 - delta)/(1 + delta).
        let g = -(1.0 - delta) / (1.0 + delta);
        // (sqrt(1 + g) - 1)/g, 1 + g = 2 delta/(1 + delta).
        let expected = ((2.0 * delta / (1.0 + delta)).sqrt() - 1.0) / g;
        match solve(square) {
            Ok(found) => {
                let error = (found.x[(0, 0)] - expected).abs() / expected;
                assert!(error <= found.forward_error + 4.0 * f64::EPSILON, "{k}: {error:e} {:e}", found.forward_error);
                assert!(found.forward_error < 1.0);
                found_near = k;
            }
            Err(error) => assert!(is_named(&error), "{k}: {error}"),
        }
        let below = solve(0.5 * (1.0 - delta));
        assert!(below.as_ref().is_err_and(is_named), "{k}: {below:?}");
    }
    assert!(found_near >= 40, "{found_near}");
    assert!(solve(0.5).as_ref().is_err_and(is_named));
}

/// Of the same equation: only where the linear term dominates the quadratic one, `4 c ||H0|| tr(H0 |G|) <= 1`, does the
/// bound 2 c H0 of the error hold, and there is a solution. `H0 = 1/(2 |F|)` with the pole F of the closed loop, `|G| =
/// 1/gamma^2 - 1`, and c follows from the bound.
#[test]
fn a_bound_is_given_only_where_the_linear_term_dominates() {
    let one = dmatrix![1.0];
    let mut largest: f64 = 0.0;
    for k in 190..=260 {
        let square = 0.5 * (1.0 + 2.0_f64.powf(-0.2 * f64::from(k)));
        let Ok(found) = care(&-&one, &dmatrix![1.0, 1.0], &one, &dmatrix![1.0, 0.0; 0.0, -square]) else { continue };
        let h0 = -0.5 / found.poles[0].re;
        let defect = found.forward_error * found.x[(0, 0)] / (2.0 * h0);
        let quadratic = 4.0 * defect * h0 * h0 * (1.0 / square - 1.0);
        assert!(quadratic <= 1.0 + 1e-6, "{k}: {quadratic:e}");
        largest = largest.max(quadratic);
    }
    // The examples come close to the limit.
    assert!(largest > 0.5, "{largest:e}");
}

/// `R = diag(1, -1)` and `B = [1 1]` cancel: `2 X + Q = 0` for a = 1, whose closed loop is unstable; the stable
/// eigenvector of the Hamiltonian matrix is `[0; 1]`.
#[test]
fn a_subspace_without_a_solution_is_named() {
    let (one, b, r) = (dmatrix![1.0], dmatrix![1.0, 1.0], dmatrix![1.0, 0.0; 0.0, -1.0]);
    let found = care(&one, &b, &one, &r);
    assert!(matches!(found, Err(LinalgError::NotGraph { sigma_min }) if sigma_min < 1e-14), "{found:?}");
    let found = dare(&dmatrix![2.0], &b, &one, &r);
    assert!(matches!(found, Err(LinalgError::NotGraph { sigma_min }) if sigma_min < 1e-14), "{found:?}");
    // Near it the solution is large, (1 + sqrt(1 + g))/g, and known to few digits.
    for k in 1..=50 {
        let g = 0.5_f64.powi(k);
        match care(&one, &b, &one, &dmatrix![1.0, 0.0; 0.0, -1.0 / (1.0 - g)]) {
            Ok(found) => {
                let expected = (1.0 + (1.0 + g).sqrt()) / g;
                let error = (found.x[(0, 0)] - expected).abs() / expected;
                // R is rounded: g by eps/g.
                assert!(
                    error <= found.forward_error + 2.0 * f64::EPSILON / g,
                    "{k}: {error:e} {:e}",
                    found.forward_error
                );
            }
            Err(error) => {
                let named = matches!(error, LinalgError::NotGraph { .. } | LinalgError::NotStabilizing { .. });
                assert!(named && k > 20, "{k}: {error}");
            }
        }
    }
}

#[test]
fn an_indefinite_weight_is_regular_and_no_cost() {
    let one = dmatrix![1.0];
    let b = dmatrix![1.0, 1.0];
    for r in [dmatrix![-1.0, 1.0; 1.0, -1.0], dmatrix![-1.0, 0.0; 0.0, 0.0]] {
        for solve in [care, dare] {
            let found = solve(&one, &b, &one, &r);
            assert!(matches!(found, Err(LinalgError::Singular { what: "R", .. })), "{r} {found:?}");
        }
    }
    let r = dmatrix![1.0, 0.0; 0.0, -4.0];
    for solve in [lqr, dlqr] {
        let found = solve(&one, &b, &one, &r);
        assert!(matches!(found, Err(LinalgError::NotPositiveDefinite { what: "R", lambda_min }) if lambda_min == -4.0));
    }
}

/// `R = [1 1; 1 1 - d]` with the condition `4/d` and `B = [1 0]`: `g = 1 - 1/d`, `g X^2 + 2 X + 1 = 0` for a = q = -1.
#[test]
fn an_ill_conditioned_weight_is_within_the_bound() {
    for k in 1..=48 {
        let d = 0.5_f64.powi(k);
        let g = 1.0 - 1.0 / d;
        let expected = ((1.0 - g).sqrt() - 1.0) / g;
        let (a, r) = (dmatrix![-1.0], dmatrix![1.0, 1.0; 1.0, 1.0 - d]);
        match care(&a, &dmatrix![1.0, 0.0], &a, &r) {
            Ok(found) => {
                let error = (found.x[(0, 0)] / expected - 1.0).abs();
                assert!(error <= found.forward_error + 4.0 * f64::EPSILON, "{k}: {error:e} {:e}", found.forward_error);
            }
            Err(error) => assert!(k > 20, "{k}: {error}"),
        }
    }
}
