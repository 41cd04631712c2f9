//! Riccati equations: residuals, stability and optimality of the gains, published examples, and plants without an
//! answer.

use luenberger_linalg::{
    Kalman, LinalgError, Riccati, care, dare, discrete_kalman_gain, dlqr, kalman_gain, lambda_min, lqr, lyapunov,
    spectral_abscissa, spectral_radius, stein,
};
use nalgebra::{Complex, DMatrix, dmatrix};
use proptest::prelude::*;

/// A few matrix products and one Newton step from the solution: a small multiple of `n eps`.
fn bound(n: usize) -> f64 {
    50.0 * n.max(1) as f64 * f64::EPSILON
}

/// A solver of dynamic matrices, as a value.
type Solver<T> = fn(&DMatrix<f64>, &DMatrix<f64>, &DMatrix<f64>, &DMatrix<f64>) -> Result<T, LinalgError>;

const REGULATORS: [Solver<Riccati>; 2] = [|a, b, q, r| lqr(a, b, q, r), |a, b, q, r| dlqr(a, b, q, r)];
const FILTERS: [Solver<Kalman>; 2] =
    [|a, c, w, v| kalman_gain(a, c, w, v), |a, c, w, v| discrete_kalman_gain(a, c, w, v)];

fn identity(n: usize) -> DMatrix<f64> {
    DMatrix::identity(n, n)
}

fn entries(n: usize, m: usize) -> impl Strategy<Value = DMatrix<f64>> {
    prop::collection::vec(-1.0..1.0_f64, n * m).prop_map(move |data| DMatrix::from_row_slice(n, m, &data))
}

#[derive(Debug, Clone)]
struct Regulator {
    a: DMatrix<f64>,
    b: DMatrix<f64>,
    q: DMatrix<f64>,
    r: DMatrix<f64>,
    /// A gain that stabilizes, by construction.
    k: DMatrix<f64>,
}

/// `A = F + B K` with `F` stable: stabilizable by construction; `Q, R > 0`.
fn regulator(discrete: bool) -> impl Strategy<Value = Regulator> {
    (1..=8_usize, 1..=3_usize)
        .prop_flat_map(|(n, m)| {
            (entries(n, n), entries(n, m), entries(n, n), entries(m, m), entries(m, n), 0.1..0.9_f64)
        })
        .prop_map(move |(f, b, q, r, k, margin)| {
            let (n, m) = b.shape();
            let f = if discrete { &f * (margin / f.norm()) } else { &f - identity(n) * (f.norm() + margin) };
            Regulator {
                a: f + &b * &k,
                q: &q * q.transpose() + identity(n) * 0.1,
                r: &r * r.transpose() + identity(m) * 0.1,
                b,
                k,
            }
        })
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(48))]

    /// The stabilizing solution exists, is positive definite with Q, and no stabilizing gain costs less.
    #[test]
    fn the_continuous_regulator_is_optimal(p in regulator(false), decades in (-60..60_i32, -60..60_i32)) {
        let n = p.a.nrows();
        let found = care(&p.a, &p.b, &p.q, &p.r).unwrap();
        prop_assert!(found.residual <= bound(n), "{:e}", found.residual);
        prop_assert_eq!(&found.x, &found.x.transpose());
        prop_assert!(found.poles.iter().all(|l| l.re < 0.0));
        prop_assert!(lambda_min(&found.x).unwrap() > 0.0);
        prop_assert_eq!(&lqr(&p.a, &p.b, &p.q, &p.r).unwrap().k, &found.k);
        // The cost of the other gain, by the Lyapunov equation of its closed loop.
        let cost = lyapunov(&(&p.a - &p.b * &p.k), &(&p.q + p.k.transpose() * &p.r * &p.k)).unwrap();
        let slack = bound(n) * cost.condition * cost.p.norm();
        prop_assert!(lambda_min(&(cost.p - &found.x)).unwrap() >= -slack);
        // In other units of cost and input, the same closed loop.
        let (cost, input) = (10.0_f64.powi(decades.0), 10.0_f64.powi(decades.1));
        let scaled = care(&p.a, &(&p.b * input), &(&p.q * cost), &(&p.r * (cost * input * input))).unwrap();
        prop_assert!(scaled.residual <= bound(n), "{:e}", scaled.residual);
        let tolerance = 1e3 * bound(n) * p.a.norm().max(1.0) * found.x.norm() / lambda_min(&found.x).unwrap();
        prop_assert!((scaled.x / cost - &found.x).norm() <= tolerance * found.x.norm());
    }

    #[test]
    fn the_discrete_regulator_is_optimal(p in regulator(true), singular in any::<bool>()) {
        let n = p.a.nrows();
        // A - B K keeps its stability when the first state forgets itself: its column is taken out of A and K alike.
        let (mut a, mut k) = (p.a.clone(), p.k.clone());
        if singular {
            a.column_mut(0).fill(0.0);
            k.column_mut(0).fill(0.0);
        }
        let found = dare(&a, &p.b, &p.q, &p.r).unwrap();
        prop_assert!(found.residual <= bound(n), "{:e}", found.residual);
        prop_assert_eq!(&found.x, &found.x.transpose());
        prop_assert!(found.poles.iter().all(|l| l.norm() < 1.0));
        prop_assert!(lambda_min(&(&found.x - &p.q)).unwrap() >= -bound(n) * found.x.norm());
        prop_assert_eq!(&dlqr(&a, &p.b, &p.q, &p.r).unwrap().k, &found.k);
        let cost = stein(&(&a - &p.b * &k), &(&p.q + k.transpose() * &p.r * &k)).unwrap();
        let slack = bound(n) * cost.condition * cost.p.norm();
        prop_assert!(lambda_min(&(cost.p - &found.x)).unwrap() >= -slack);
    }

    /// Duality, and the covariance as the fixed point of the filter with its own gain (Joseph's form).
    #[test]
    fn kalman_gains_are_the_dual_regulators(p in regulator(false), d in regulator(true)) {
        let n = p.a.nrows();
        let (a, c) = (p.a.transpose(), p.b.transpose());
        let found = kalman_gain(&a, &c, &p.q, &p.r).unwrap();
        prop_assert!(found.residual <= bound(n));
        let f = &a - &found.l * &c;
        prop_assert!(spectral_abscissa(&f).unwrap() < 0.0);
        let fixed = lyapunov(&f.transpose(), &(&p.q + &found.l * &p.r * found.l.transpose())).unwrap();
        let slack = 1e2 * bound(n) * fixed.condition * (1.0 + (f.norm() + a.norm()) / f.norm());
        prop_assert!((fixed.p - &found.p).norm() <= slack * found.p.norm());

        let n = d.a.nrows();
        let (a, c) = (d.a.transpose(), d.b.transpose());
        let found = discrete_kalman_gain(&a, &c, &d.q, &d.r).unwrap();
        let gain = &a * &found.p * c.transpose() * (&d.r + &c * &found.p * c.transpose()).try_inverse().unwrap();
        prop_assert!((&gain - &found.l).norm() <= 1e3 * bound(n) * (1.0 + gain.norm()));
        prop_assert!(spectral_radius(&(&a - &found.l * &c)).unwrap() < 1.0);
    }
}

#[test]
fn slicot_sb02md() {
    // Example program data and results of SLICOT routine SB02MD: continuous, G = B R^-1 B'.
    let found = care(&dmatrix![0.0, 1.0; 0.0, 0.0], &dmatrix![0.0; 1.0], &dmatrix![1.0, 0.0; 0.0, 2.0], &dmatrix![1.0])
        .unwrap();
    assert!((found.x - dmatrix![2.0, 1.0; 1.0, 2.0]).amax() <= 100.0 * f64::EPSILON);
    assert!((found.k - dmatrix![1.0, 2.0]).amax() <= 100.0 * f64::EPSILON);
}

#[test]
fn slicot_bb01ad_example_1_3() {
    // Example 1.3 of SLICOT's BB01AD (CAREX 3: lateral dynamics of an L-1011 aircraft), R = I; data file BB01103.
    let a =
        dmatrix![0.0, 1.0, 0.0, 0.0; 0.0, -1.89, 0.39, -5.53; 0.0, -0.034, -2.98, 2.43; 0.034, -0.0011, -0.99, -0.21];
    let b = dmatrix![0.0, 0.0; 0.36, -1.6; -0.95, -0.032; 0.03, 0.0];
    let q = dmatrix![2.313, 2.727, 0.688, 0.023; 2.727, 4.271, 1.148, 0.323; 0.688, 1.148, 0.313, 0.102; 0.023, 0.323, 0.102, 0.083];
    // The weight is printed to three decimals, and these make it indefinite.
    let found = lqr(&a, &b, &q, &identity(2));
    let Err(LinalgError::NotPositiveSemidefinite { what: "Q", lambda_min }) = found else { panic!("{found:?}") };
    assert!((-5.2e-4..-5.1e-4).contains(&lambda_min));
    let indefinite = care(&a, &b, &q, &identity(2)).unwrap();
    // scipy 1.17.1, solve_continuous_are.
    assert!((indefinite.x[(0, 0)] - 1.323_859_571_818_397_9).abs() <= 1e-11, "{}", indefinite.x[(0, 0)]);
    let found = lqr(&a, &b, &(q - identity(4) * lambda_min), &identity(2)).unwrap();
    assert!(found.residual <= bound(4));
    assert!(found.poles.iter().all(|l| l.re < 0.0));
}

#[test]
fn scalar_equations_in_closed_form() {
    // 2 a x - x^2 b^2/r + q = 0.
    for (a, b, q, r) in
        [(1.0_f64, 1.0_f64, 1.0_f64, 1.0_f64), (-3.0, 2.0, 0.0, 5.0), (3.0, 2.0, 0.0, 5.0), (1e6, 1.0, 1e-6, 1.0)]
    {
        let one = |x| DMatrix::from_element(1, 1, x);
        let found = care(&one(a), &one(b), &one(q), &one(r)).unwrap();
        let exact = if a < 0.0 {
            q / (-a + (a * a + q * b * b / r).sqrt())
        } else {
            (a + (a * a + q * b * b / r).sqrt()) * r / (b * b)
        };
        assert!((found.x[(0, 0)] - exact).abs() <= 20.0 * f64::EPSILON * exact, "{} {exact}", found.x[(0, 0)]);
    }
    // An unstable plant without a weight: the cheapest gain mirrors the pole at the unit circle.
    let found = dare(&dmatrix![2.0], &dmatrix![1.0], &dmatrix![0.0], &dmatrix![1.0]).unwrap();
    assert!((found.x[(0, 0)] - 3.0).abs() <= 100.0 * f64::EPSILON);
    assert!((found.poles[0].re - 0.5).abs() <= 100.0 * f64::EPSILON);
    // One step to rest: A = 0 gives X = Q.
    let q = dmatrix![2.0, 1.0; 1.0, 3.0];
    assert_eq!(dare(&DMatrix::zeros(2, 2), &identity(2), &q, &identity(2)).unwrap().x, q);
}

/// `-x^2 + 1 = 0` is solved exactly. What may be left of the defect is its rounding c: `2 EPSILON` of q = 1 and twice
/// of the product that is subtracted from it, 1. With `H0 = 1/2` the bound `2 c H0` is `6 EPSILON`.
#[test]
fn the_bound_of_a_scalar_in_closed_form() {
    let one = DMatrix::from_element(1, 1, 1.0);
    let found = care(&DMatrix::zeros(1, 1), &one, &one, &one).unwrap();
    assert_eq!((found.x[(0, 0)], found.k[(0, 0)], found.residual), (1.0, 1.0, 0.0));
    assert!((found.forward_error / f64::EPSILON - 6.0).abs() <= 1e-9, "{:e}", found.forward_error / f64::EPSILON);
}

#[test]
fn unstable_modes_without_a_weight_are_mirrored() {
    let a = dmatrix![1.0, 1.0, 0.0; 0.0, 1.0, 1.0; 0.0, 0.0, -2.0];
    let b = dmatrix![0.0; 1.0; 1.0];
    let found = care(&a, &b, &DMatrix::zeros(3, 3), &dmatrix![1.0]).unwrap();
    assert!(found.residual <= bound(3));
    // The double eigenvalue 1 becomes -1: defective, so known to the square root of rounding.
    for l in &found.poles {
        let expected = if l.re < -1.5 { -2.0 } else { -1.0 };
        assert!((l - Complex::new(expected, 0.0)).norm() <= 100.0 * f64::EPSILON.sqrt(), "{l}");
    }
    let a = dmatrix![1.5, 1.0, 0.0; 0.0, -2.0, 1.0; 0.0, 0.0, 0.1];
    let found = dare(&a, &b, &DMatrix::zeros(3, 3), &dmatrix![1.0]).unwrap();
    assert!(found.residual <= bound(3));
    let mut moduli: Vec<_> = found.poles.iter().map(|l| l.norm()).collect();
    moduli.sort_by(f64::total_cmp);
    for (modulus, expected) in moduli.iter().zip([0.1, 0.5, 1.0 / 1.5]) {
        assert!((modulus - expected).abs() <= 1e4 * f64::EPSILON, "{moduli:?}");
    }
}

#[test]
fn units_of_any_size() {
    let a = dmatrix![0.0, 1.0; 2.0, -1.0];
    let b = dmatrix![0.0; 1.0];
    for (ua, ub, uq, ur) in [
        (1e150, 1.0, 1.0, 1.0),
        (1e150, 1e150, 1.0, 1.0),
        (1e-150, 1e-150, 1.0, 1.0),
        (1.0, 1e-140, 1.0, 1e-280),
        (1.0, 1.0, 1e200, 1e200),
        (1e8, 1.0, 1.0, 1.0),
        (1e-4, 1.0, 1.0, 1.0),
    ] {
        let found = care(&(&a * ua), &(&b * ub), &(identity(2) * uq), &dmatrix![ur]).unwrap();
        assert!(found.residual <= bound(2), "{ua:e} {ub:e} {uq:e} {ur:e}: {:e}", found.residual);
        assert!(found.poles.iter().all(|l| l.re < 0.0));
    }
    // Closed-loop poles near -1e-9 and -1e21: beyond double precision, which is an error that blames no eigenvalue of
    // the plant.
    let found = care(&(&a * 1e-9), &(&b * 1e12), &(identity(2) * 1e6), &dmatrix![1e-12]);
    assert!(matches!(found, Err(LinalgError::NotStabilizing { .. } | LinalgError::NotConverged { .. })), "{found:?}");
    for (ub, uq, ur) in [(1e-140, 1.0, 1e-280), (1.0, 1e200, 1e200), (1e6, 1e-3, 1e-6)] {
        let found = dare(&a, &(&b * ub), &(identity(2) * uq), &dmatrix![ur]).unwrap();
        assert!(found.residual <= bound(2), "{ub:e} {uq:e} {ur:e}: {:e}", found.residual);
    }
}

/// A plant in units of the state that are 24 decades apart: the gain in those units, and nothing else, changes.
#[test]
fn units_of_the_state_do_not_matter() {
    let a = dmatrix![1.0, 2.0, 0.5; -1.0, 0.5, 2.0; 1.0, 0.0, -1.0];
    let b = dmatrix![1.0; 0.0; 2.0];
    let d = DMatrix::from_diagonal(&nalgebra::dvector![1e-12, 1.0, 1e12]);
    let inverse = DMatrix::from_diagonal(&nalgebra::dvector![1e12, 1.0, 1e-12]);
    for solve in REGULATORS {
        let reference = solve(&a, &b, &identity(3), &dmatrix![1.0]).unwrap();
        let found = solve(&(&inverse * &a * &d), &(&inverse * &b), &(&d * &d), &dmatrix![1.0]).unwrap();
        assert!(found.residual <= bound(3));
        assert!((found.k * &inverse - &reference.k).norm() <= 1e3 * bound(3) * reference.k.norm());
        assert!((&inverse * found.x * &inverse - &reference.x).norm() <= 1e3 * bound(3) * reference.x.norm());
    }
}

#[test]
fn larger_orders_keep_the_residual_small() {
    for n in [20, 50] {
        let entry = |i: usize, j: usize| ((1 + 31 * i + 17 * j * j + i * i * j) as f64).sin();
        let a = DMatrix::from_fn(n, n, entry);
        let b = DMatrix::from_fn(n, 3, |i, j| entry(i + 7, j + 3));
        let found = care(&a, &b, &identity(n), &identity(3)).unwrap();
        assert!(found.residual <= bound(n), "{:e}", found.residual);
        let found = dare(&(&a * (1.5 / a.norm() * (n as f64).sqrt())), &b, &identity(n), &identity(3)).unwrap();
        assert!(found.residual <= bound(n), "{:e}", found.residual);
    }
}

/// An orthogonal similarity that hides the structure of a plant.
fn hidden(a: &DMatrix<f64>, b: &DMatrix<f64>) -> (DMatrix<f64>, DMatrix<f64>) {
    let n = a.nrows();
    let w = DMatrix::from_fn(n, n, |i, j| f64::from(u8::from(i == j)) - 2.0 / n as f64);
    (&w * a * &w, &w * b)
}

#[test]
fn an_eigenvalue_that_no_input_moves_is_named() {
    let plain = (dmatrix![2.0, 0.0, 0.0; 0.0, -1.0, 1.0; 0.0, 3.0, 0.5], dmatrix![0.0; 1.0; 2.0]);
    for (a, b) in [plain.clone(), hidden(&plain.0, &plain.1)] {
        for found in [care(&a, &b, &identity(3), &dmatrix![1.0]), dare(&a, &b, &identity(3), &dmatrix![1.0])] {
            let Err(LinalgError::NotStabilizable { eigenvalue, margin }) = found else { panic!("{found:?}") };
            assert!((eigenvalue - Complex::new(2.0, 0.0)).norm() <= bound(3) * 10.0);
            assert!(margin <= bound(3) * 10.0);
        }
        // The same plant transposed, seen from the filter.
        let (a, c) = (a.transpose(), b.transpose());
        for found in [
            kalman_gain(&a, &c, &identity(3), &dmatrix![1.0]),
            discrete_kalman_gain(&a, &c, &identity(3), &dmatrix![1.0]),
        ] {
            assert!(
                matches!(found, Err(LinalgError::NotDetectable { eigenvalue, .. }) if (eigenvalue.re - 2.0).abs() <= 1e-9),
                "{found:?}"
            );
        }
    }
}

#[test]
fn an_eigenvalue_on_the_boundary_without_a_weight_is_named() {
    // An integrator, and an oscillator, that cost nothing.
    let found = care(&dmatrix![0.0], &dmatrix![1.0], &dmatrix![0.0], &dmatrix![1.0]);
    assert!(matches!(found, Err(LinalgError::NotWeighted { eigenvalue, .. }) if eigenvalue.norm() == 0.0), "{found:?}");
    let found = dare(&dmatrix![1.0], &dmatrix![1.0], &dmatrix![0.0], &dmatrix![1.0]);
    assert!(matches!(found, Err(LinalgError::NotWeighted { eigenvalue, .. }) if eigenvalue.re == 1.0), "{found:?}");
    let plain = (dmatrix![0.0, 3.0, 0.0; -3.0, 0.0, 0.0; 0.0, 0.0, -1.0], dmatrix![1.0; 0.5; 1.0]);
    let q = dmatrix![0.0, 0.0, 0.0; 0.0, 0.0, 0.0; 0.0, 0.0, 1.0];
    let (a, b) = hidden(&plain.0, &plain.1);
    let (_, half) = hidden(&plain.0, &q);
    let (_, q) = hidden(&plain.0, &half.transpose());
    let found = care(&a, &b, &q, &dmatrix![1.0]);
    assert!(
        matches!(found, Err(LinalgError::NotWeighted { eigenvalue, .. }) if (eigenvalue.im.abs() - 3.0).abs() <= 1e-9),
        "{found:?}"
    );
    // The same, seen from the filter: nothing drives the oscillator. It has no B that the message could name.
    let oscillator = dmatrix![0.0, 3.0; -3.0, 0.0];
    let found = kalman_gain(&oscillator, &dmatrix![1.0, 0.0], &DMatrix::zeros(2, 2), &dmatrix![1.0]).unwrap_err();
    assert!(matches!(found, LinalgError::NotExcited { margin, .. } if margin <= bound(2)), "{found:?}");
    let text = found.to_string();
    assert!(text.contains("(A, W)") && text.contains("eigenvalue 3i") && !text.contains("(A, B)"), "{text}");
    // Without any input, an unstable plant stays unstable, and a stable one needs none.
    let none = DMatrix::zeros(1, 0);
    let weightless = DMatrix::zeros(0, 0);
    let found = care(&dmatrix![1.0], &none, &dmatrix![1.0], &weightless);
    assert!(matches!(found, Err(LinalgError::NotStabilizable { .. })), "{found:?}");
    let found = care(&dmatrix![-1.0], &none, &dmatrix![1.0], &weightless).unwrap();
    assert!((found.x[(0, 0)] - 0.5).abs() <= 4.0 * f64::EPSILON && found.k.shape() == (0, 1));
    let empty = DMatrix::zeros(0, 0);
    assert_eq!(care(&empty, &empty, &empty, &empty).unwrap().poles, vec![]);
    assert_eq!(dare(&empty, &empty, &empty, &empty).unwrap().poles, vec![]);
    // There is nothing to observe, as for the placement of an observer.
    for gain in [kalman_gain, discrete_kalman_gain] {
        assert_eq!(gain(&empty, &empty, &empty, &empty), Err(LinalgError::Empty { what: "A" }));
    }
}

#[test]
fn a_defective_eigenvalue_on_the_boundary_is_not_stabilized_by_rounding() {
    // (1, 0, 1) is a left eigenvector of A for the eigenvalue 1, which is double and defective, and B does not see it.
    let a = dmatrix![1.0, -1.0, 1.0; -2.0, -2.0, 1.0; 0.0, 1.0, 0.0];
    let b = dmatrix![2.0, -2.0; 1.0, 0.0; -2.0, 2.0];
    let q = dmatrix![13.0, -2.0, 0.0; -2.0, 2.0, 0.0; 0.0, 0.0, 3.0];
    assert!(dare(&a, &b, &q, &identity(2)).is_err());
}

#[test]
fn bad_input_is_named() {
    let (a, b, q, r) = (dmatrix![0.0, 1.0; 0.0, 0.0], dmatrix![0.0; 1.0], identity(2), dmatrix![1.0]);
    for solve in REGULATORS {
        assert_eq!(solve(&b, &b, &q, &r), Err(LinalgError::NotSquare { what: "A", rows: 2, cols: 1 }));
        let mismatch = |what, expected, found| Err(LinalgError::DimensionMismatch { what, expected, found });
        assert_eq!(solve(&a, &b.transpose(), &q, &r), mismatch("B", (2, 2), (1, 2)));
        assert_eq!(solve(&a, &b, &r, &r), mismatch("Q", (2, 2), (1, 1)));
        assert_eq!(solve(&a, &b, &q, &q), mismatch("R", (1, 1), (2, 2)));
        let found = solve(&a, &b, &q, &dmatrix![-2.0]);
        assert!(
            matches!(found, Err(LinalgError::NotPositiveDefinite { what: "R", lambda_min }) if (lambda_min + 2.0).abs() <= 1e-14)
        );
        let found = solve(&a, &b, &q, &dmatrix![0.0]);
        assert!(matches!(found, Err(LinalgError::NotPositiveDefinite { what: "R", .. })));
        let found = solve(&a, &b, &dmatrix![1.0, 0.0; 0.0, -3.0], &r);
        assert!(
            matches!(found, Err(LinalgError::NotPositiveSemidefinite { what: "Q", lambda_min }) if (lambda_min + 3.0).abs() <= 1e-14)
        );
        let found = solve(&a, &b, &dmatrix![1.0, 0.5; 0.0, 1.0], &r);
        assert!(matches!(found, Err(LinalgError::NotSymmetric { what: "Q", asymmetry: 0.5, .. })));
        let found = solve(&a, &dmatrix![0.0; f64::NAN], &q, &r);
        assert!(matches!(found, Err(LinalgError::NotFinite { what: "B", row: 1, col: 0, .. })));
    }
    let c = dmatrix![1.0, 0.0];
    for solve in FILTERS {
        let found = solve(&a, &b, &q, &r);
        assert_eq!(found, Err(LinalgError::DimensionMismatch { what: "C", expected: (2, 2), found: (2, 1) }));
        let found = solve(&a, &c, &q, &dmatrix![-1.0]);
        assert!(matches!(found, Err(LinalgError::NotPositiveDefinite { what: "V", .. })));
        let found = solve(&a, &c, &dmatrix![1.0, 0.5; 0.0, 1.0], &r);
        assert!(matches!(found, Err(LinalgError::NotSymmetric { what: "W", .. })));
        let found = solve(&a, &c, &-identity(2), &r);
        assert!(matches!(found, Err(LinalgError::NotPositiveSemidefinite { what: "W", .. })));
        let found = solve(&a, &dmatrix![f64::INFINITY, 0.0], &q, &r);
        assert!(matches!(found, Err(LinalgError::NotFinite { what: "C", .. })));
    }
}

/// A slow mode that no output sees decays: it has no part in the gain, and its covariance is `w / (2 |lambda|)`. Also
/// in other coordinates, where its covariance with the fast mode of `A = diag(-s, -1)` is `w12 / (s + 1 + l)`, l the
/// gain.
#[test]
fn hidden_slow_modes_decay() {
    let one = dmatrix![1.0];
    let root = 2f64.sqrt() - 1.0;
    for slow in [1e-3, 1e-6, 1e-8, 1e-10] {
        let a = dmatrix![-slow, 0.0; 0.0, -1.0];
        let c = dmatrix![0.0, 1.0];
        let found = kalman_gain(&a, &c, &DMatrix::identity(2, 2), &one).unwrap();
        assert!((found.p[(0, 0)] * 2.0 * slow - 1.0).abs() <= 1e-14, "{found}");
        assert!((found.p[(1, 1)] - root).abs() <= 1e-15 && found.l[(0, 0)] == 0.0, "{found}");
        // Seen, but without noise: the filter leaves it alone.
        let found = kalman_gain(&a, &dmatrix![1.0, 1.0], &dmatrix![0.0, 0.0; 0.0, 1.0], &one).unwrap();
        assert!((found.p - dmatrix![0.0, 0.0; 0.0, root]).amax() <= 1e-14, "{slow}");
        // x = T z.
        let (t, inverse) = (dmatrix![2.0, 1.0; 1.0, 1.0], dmatrix![1.0, -1.0; -1.0, 2.0]);
        let (turned, w) = (&t * &a * &inverse, &t * t.transpose());
        let found = kalman_gain(&turned, &(&c * &inverse), &w, &one).unwrap();
        let p = &inverse * found.p * inverse.transpose();
        // The data are rounded: the slow eigenvalue is known to 1e-16.
        let known = 1e-14 + 1e-15 / slow;
        assert!((p[(0, 0)] * 2.0 * slow - 1.0).abs() <= known, "{slow}: {p}");
        let discrete = dmatrix![1.0 - slow, 0.0; 0.0, 0.5];
        let found = discrete_kalman_gain(&discrete, &c, &DMatrix::identity(2, 2), &one).unwrap();
        assert!((found.p[(0, 0)] * slow * (2.0 - slow) - 1.0).abs() <= 1e-15 / slow, "{found}");
    }
}

/// Noise of outputs in volts and nanometres: P and L are those in one unit (x2 in nm is seen by y2 with 1e-9 m). The
/// gain of the second output is what python-control's `lqe` gives for `C = diag(1, 1e9), V = I`, scaled back.
#[test]
fn the_unit_of_an_output_is_not_its_definiteness() {
    let (a, w) = (dmatrix![0.0, 1.0; -1.0, -1.0], DMatrix::identity(2, 2));
    for power in [0, 20, 30, 60, 300] {
        let unit = 2f64.powi(power);
        let v = dmatrix![1.0, 0.0; 0.0, 1.0 / unit / unit];
        let found = kalman_gain(&a, &dmatrix![1.0, 0.0; 0.0, 1.0 / unit], &w, &v).unwrap();
        let plain = kalman_gain(&a, &DMatrix::identity(2, 2), &w, &DMatrix::identity(2, 2)).unwrap();
        assert_eq!(found.p, plain.p, "2^{power}");
        assert_eq!(found.l, plain.l * dmatrix![1.0, 0.0; 0.0, unit], "2^{power}");
    }
    // y = x with V = diag(1, 1e-18): the error of x2 goes to zero with the noise of y2, p22 = 1e-9.
    let found = kalman_gain(&a, &DMatrix::identity(2, 2), &w, &dmatrix![1.0, 0.0; 0.0, 1e-18]).unwrap();
    assert!((found.p[(1, 1)] - 1e-9).abs() <= 2e-18, "{found}");
    let refused = kalman_gain(&a, &dmatrix![1.0, 0.0], &dmatrix![1e6, 0.0; 0.0, -1e-10], &dmatrix![1.0]);
    assert!(
        matches!(refused, Err(LinalgError::NotPositiveSemidefinite { what: "W", lambda_min }) if lambda_min == -1e-10)
    );
    let correlated = dmatrix![1.0, 2e-9; 2e-9, 1e-18];
    let refused = kalman_gain(&a, &DMatrix::identity(2, 2), &w, &correlated);
    assert!(matches!(refused, Err(LinalgError::NotPositiveDefinite { what: "V", lambda_min }) if lambda_min < 0.0));
}

/// Without measurement noise, `xhat+ = A y`: python-control 0.10.2, `dlqe`, gives L = 0.9 and P = 1.
#[test]
fn a_filter_without_measurement_noise() {
    let (a, one) = (dmatrix![0.9], dmatrix![1.0]);
    let found = discrete_kalman_gain(&a, &one, &one, &dmatrix![0.0]).unwrap();
    assert!((found.l[(0, 0)] - 0.9).abs() <= f64::EPSILON && (found.p[(0, 0)] - 1.0).abs() <= f64::EPSILON, "{found}");
    assert!(matches!(
        discrete_kalman_gain(&a, &dmatrix![0.0], &one, &dmatrix![0.0]),
        Err(LinalgError::NotPositiveDefinite { what: "V", .. })
    ));
}

/// By hand: `X^2 + 2 k X + k^2 = 0` has the double root -k, with which the closed loop is 0.
#[test]
fn a_double_root_of_an_indefinite_weight_is_no_solution() {
    for k in [0.1, 1.0, 2.0, 3.0, 7.0, 100.0] {
        let found = care(&dmatrix![-k], &dmatrix![1.0], &dmatrix![-k * k], &dmatrix![1.0]);
        assert!(found.is_err(), "{k}: {found:?}");
    }
}

/// By hand in units of one: `P = [4/9 4/3; 4/3 4]`, with the poles -1 and -2. Nothing excites the unstable mode; that
/// is no mode on the boundary, in any unit of the first state.
#[test]
fn an_unstable_mode_that_nothing_excites_is_stabilised_in_any_units() {
    for power in [0, 10, 27, 40] {
        let s = 2f64.powi(power);
        let found = kalman_gain(
            &dmatrix![-1.0, s; 0.0, 2.0],
            &dmatrix![0.0, 1.0],
            &dmatrix![1.0, 0.0; 0.0, 0.0],
            &dmatrix![1.0],
        )
        .unwrap();
        // x1 is driven by w of unit intensity besides, which adds 1/2.
        assert!(
            (found.p[(1, 1)] - 4.0).abs() <= 1e-9 && (found.p[(0, 1)] / s - 4.0 / 3.0).abs() <= 1e-9,
            "{power}: {found}"
        );
    }
}
