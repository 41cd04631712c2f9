//! Riccati equations with a cross term, a descriptor matrix, a singular R or an indefinite Q: solutions known by
//! construction, and those of scipy.

use luenberger_linalg::{LinalgError, Riccati, care, dare, generalized_care, generalized_dare};
use nalgebra::{DMatrix, dmatrix};
use proptest::prelude::*;

#[derive(Debug, Clone)]
struct Problem {
    a: DMatrix<f64>,
    b: DMatrix<f64>,
    q: DMatrix<f64>,
    r: DMatrix<f64>,
    s: DMatrix<f64>,
    e: DMatrix<f64>,
}

impl Problem {
    fn solve(&self, discrete: bool) -> Result<Riccati, LinalgError> {
        let solve = |f: fn(&Self) -> Result<Riccati, LinalgError>| f(self);
        if discrete {
            solve(|p| generalized_dare(&p.a, &p.b, &p.q, &p.r, &p.s, &p.e))
        } else {
            solve(|p| generalized_care(&p.a, &p.b, &p.q, &p.r, &p.s, &p.e))
        }
    }
}

/// Small integers, so that products of five are exact.
fn integers(n: usize, m: usize, size: i32) -> impl Strategy<Value = DMatrix<f64>> {
    prop::collection::vec((-size..=size).prop_map(f64::from), n * m)
        .prop_map(move |data| DMatrix::from_row_slice(n, m, &data))
}

/// A continuous equation and a symmetric X, in general indefinite, that solves it exactly: Q is what X leaves.
fn with_solution() -> impl Strategy<Value = (Problem, DMatrix<f64>)> {
    (1..=5_usize, 1..=2_usize)
        .prop_flat_map(|(n, m)| {
            let unit = integers(n, n, 2).prop_map(move |e| e.lower_triangle() + DMatrix::identity(n, n) * 3.0);
            let weights = prop::collection::vec((0..3_i32).prop_map(|p| 2.0_f64.powi(p)), m);
            (integers(n, n, 4), integers(n, m, 3), weights, integers(n, m, 2), unit, integers(n, n, 3))
        })
        .prop_map(|(a, b, weights, s, e, x)| {
            let r = DMatrix::from_diagonal(&weights.into());
            let x = &x + x.transpose();
            let cross = b.tr_mul(&x) * &e + s.transpose();
            let half = a.tr_mul(&x) * &e;
            let inverse = r.map(|w| if w == 0.0 { 0.0 } else { 1.0 / w });
            let q = cross.tr_mul(&(inverse * &cross)) - &half - half.transpose();
            (Problem { a, b, q, r, s, e }, x)
        })
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 200, max_global_rejects: 20_000, ..ProptestConfig::default() })]

    /// The solution that stabilizes is found, and no further away than its forward error says.
    #[test]
    fn a_known_solution_is_within_the_forward_error((p, x) in with_solution()) {
        let gain = p.r.clone().try_inverse().unwrap() * (p.b.tr_mul(&x) * &p.e + p.s.transpose());
        let closed = (&p.a - &p.b * gain) * p.e.clone().try_inverse().unwrap();
        let slowest = luenberger_linalg::spectral_abscissa(&closed).unwrap();
        prop_assume!(slowest < -1e-3 && p.q.amax() < 1e6);
        let found = p.solve(false).unwrap();
        let error = (&found.x - &x).norm() / x.norm().max(f64::MIN_POSITIVE);
        prop_assert!(x.norm() == 0.0 || error <= found.forward_error, "{error:e} {:e}", found.forward_error);
        prop_assert!(x.norm() == 0.0 || found.forward_error <= 1e-4, "{:e}", found.forward_error);
        prop_assert!(found.poles.iter().all(|l| l.re < 0.0));
    }

    /// Without E and S, the equation of `care` and `dare`, to within both forward errors.
    #[test]
    fn the_standard_equation_is_a_case(a in integers(3, 3, 2), b in integers(3, 2, 2), q in integers(3, 3, 2)) {
        let q = &q * q.transpose() + DMatrix::identity(3, 3);
        let (r, s, e) = (DMatrix::identity(2, 2), DMatrix::zeros(3, 2), DMatrix::identity(3, 3));
        let p = Problem { a, b, q, r, s, e };
        for (discrete, plain) in [(false, care(&p.a, &p.b, &p.q, &p.r)), (true, dare(&p.a, &p.b, &p.q, &p.r))] {
            let Ok(plain) = plain else { continue };
            let found = p.solve(discrete).unwrap();
            let apart = (&found.x - &plain.x).norm() / plain.x.norm();
            prop_assert!(apart <= found.forward_error + plain.forward_error, "{apart:e}");
            prop_assert!((&found.k - &plain.k).amax() <= 1e-6 * (1.0 + plain.k.amax()));
        }
    }
}

fn example() -> Problem {
    Problem {
        a: dmatrix![0.0, 1.0, 0.0; 0.0, 0.0, 1.0; -1.0, -2.0, 0.5],
        b: dmatrix![0.0, 1.0; 1.0, 0.0; 0.0, 2.0],
        q: dmatrix![2.0, 0.0, 0.5; 0.0, -0.1, 0.0; 0.5, 0.0, 1.0],
        r: dmatrix![2.0, 0.5; 0.5, 1.0],
        s: dmatrix![0.1, 0.0; 0.2, -0.1; 0.0, 0.3],
        e: dmatrix![2.0, 0.0, 0.0; 1.0, 1.0, 0.0; 0.0, -0.5, 4.0],
    }
}

#[test]
fn scipy_agrees() {
    // scipy 1.17.1: solve_continuous_are(a, b, q, r, e=e, s=s) and solve_discrete_are; Q is indefinite.
    let p = example();
    let continuous = dmatrix![
        0.285_442_092_783_817_2, 0.271_058_489_451_123_3, 0.052_046_961_411_417_3;
        0.271_058_489_451_123_3, 0.673_272_451_791_547_9, 0.059_627_307_140_730_54;
        0.052_046_961_411_417_3, 0.059_627_307_140_730_54, 0.103_508_651_503_711_73];
    let discrete = dmatrix![
        0.551_410_923_635_229, -0.165_968_642_254_925_66, 0.063_503_416_145_484_44;
        -0.165_968_642_254_925_66, 0.511_016_236_512_860_3, -0.010_817_624_644_918_84;
        0.063_503_416_145_484_44, -0.010_817_624_644_918_84, 0.087_928_936_832_814_5];
    for (is_discrete, expected) in [(false, continuous), (true, discrete)] {
        let found = p.solve(is_discrete).unwrap();
        assert!((&found.x - &expected).norm() <= 1e-13 * expected.norm(), "{}", found.x);
        assert!(found.forward_error <= 1e-11 && found.residual <= 1e-15, "{found:?}");
        assert!((1.0..1e3).contains(&found.condition), "{}", found.condition);
    }
}

#[test]
fn a_singular_weight_of_the_input() {
    // scipy 1.17.1: solve_discrete_are with r = [[1, 1], [1, 1]].
    let p = example();
    let (q, r) = (DMatrix::identity(3, 3), dmatrix![1.0, 1.0; 1.0, 1.0]);
    let expected = dmatrix![
        1.354_732_597_811_523_9, 1.159_169_222_820_768_8, -0.437_127_467_331_089_76;
        1.159_169_222_820_768_8, 5.342_266_424_288_375_5, -0.873_995_078_405_088_2;
        -0.437_127_467_331_089_76, -0.873_995_078_405_088_2, 2.093_078_524_584_818_5];
    let found = dare(&p.a, &p.b, &q, &r).unwrap();
    assert!((&found.x - &expected).norm() <= 1e-13 * expected.norm(), "{}", found.x);
    assert!(found.poles.iter().all(|l| l.norm() < 1.0));
    // An input with neither weight nor effect.
    let found = dare(&p.a, &DMatrix::zeros(3, 2), &q, &r);
    assert!(matches!(found, Err(LinalgError::NotPositiveDefinite { what: "R", .. })), "{found:?}");
    // In continuous time there is no solution without a weight.
    let found = care(&p.a, &p.b, &q, &r);
    assert!(matches!(found, Err(LinalgError::NotPositiveDefinite { what: "R", .. })), "{found:?}");
    // A negative weight, for which X^2 - 1.375 X + 0.5 = 0 has no real root.
    let found = dare(&dmatrix![0.5], &dmatrix![1.0], &dmatrix![1.0], &dmatrix![-0.5]);
    assert!(matches!(found, Err(LinalgError::NotStabilizing { .. })), "{found:?}");
}

#[test]
fn no_stabilizing_solution_is_said() {
    // x^2 + 1 = 0.
    let one = |x: f64| DMatrix::from_element(1, 1, x);
    let found = care(&one(0.0), &one(1.0), &one(-1.0), &one(1.0));
    assert!(matches!(found, Err(LinalgError::NotStabilizing { .. })), "{found:?}");
    // A bounded-real equation just below and at its gain, H = 1/(s + 1): X^2/g^2 - 2 X + 1 = 0.
    let bounded = |gain: f64| care(&one(-1.0), &one(1.0), &one(-1.0), &one(gain * gain));
    let found = bounded(1.01).unwrap();
    let expected = -(1.01_f64 * 1.01) * (1.0 - (1.0 - 1.0 / (1.01_f64 * 1.01)).sqrt());
    assert!((found.x[(0, 0)] - expected).abs() <= 1e-12, "{} {expected}", found.x);
    assert!(matches!(bounded(0.99), Err(LinalgError::NotStabilizing { .. })));
}

/// `1 - g |1/(z - a)|^2` has a zero on the unit circle iff `g >= (1 - a)^2`; below that X is a root of
/// `X^2 + (1 - a^2 + g) X + g`. Beyond it by 1e-12 the symplectic pencil has eigenvalues 1e-6 apart on the circle.
#[test]
fn a_discrete_equation_without_stabilizing_solution_has_no_answer() {
    let critical = 0.25;
    let states = |g: f64, n: usize| {
        let (mut a, mut q) = (DMatrix::identity(n, n) * 0.2, DMatrix::identity(n, n));
        (a[(0, 0)], q[(0, 0)]) = (0.5, -g);
        (a, DMatrix::identity(n, n), q)
    };
    let mut wrong = Vec::new();
    for n in [1, 2, 4] {
        let (zero, one) = (DMatrix::zeros(n, n), DMatrix::identity(n, n));
        for beyond in [0.0, 1e-13, 1e-12, 1e-9, 1e-6, 1e-3, 0.1, 1.0, 3.0, 7.9] {
            let (a, b, q) = states(critical * (1.0 + beyond), n);
            for found in [dare(&a, &b, &q, &one), generalized_dare(&a, &b, &q, &one, &zero, &one)] {
                if !matches!(
                    found,
                    Err(LinalgError::NotStabilizing { .. }
                        | LinalgError::NoStabilizingSolution
                        | LinalgError::NotConverged { .. })
                ) {
                    wrong.push(format!("{n} {beyond:e}: {found:?}"));
                }
            }
        }
        for below in [1e-6, 1e-3, 0.5] {
            let g: f64 = critical * (1.0 - below);
            let (a, b, q) = states(g, n);
            let half = 0.5 * (1.0 - 0.25 + g);
            let x = -half + (half * half - g).sqrt();
            for found in [dare(&a, &b, &q, &one).unwrap(), generalized_dare(&a, &b, &q, &one, &zero, &one).unwrap()] {
                // The derivative of a nearly double root.
                assert!((found.x[(0, 0)] - x).abs() <= 1e-15 / below.sqrt(), "{below:e}: {} {x}", found.x);
            }
        }
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}

/// From `g = (1 + a)^2`, nine times the critical one, the other root `x = -half - sqrt(half^2 - g)` is a solution: with
/// `1 + x < -a`, so that `a/(1 + x)` is stable, although no cost is a minimum.
#[test]
fn beyond_a_second_weight_the_solution_is_no_minimum() {
    let (a, one, zero) = (dmatrix![0.5], dmatrix![1.0], dmatrix![0.0]);
    for g in [2.26, 3.0, 25.25] {
        let half: f64 = 0.5 * (0.75 + g);
        let x = -half - (half * half - g).sqrt();
        let q = dmatrix![-g];
        for found in [dare(&a, &one, &q, &one), generalized_dare(&a, &one, &q, &one, &zero, &one)] {
            let found = found.unwrap();
            assert!((found.x[0] / x - 1.0).abs() <= 1e-13, "{g}: {found:?} {x}");
            assert!((found.poles[0].re - 0.5 / (1.0 + x)).abs() <= 1e-13, "{g}: {found:?}");
        }
    }
}

#[test]
fn bad_input_is_named() {
    let p = example();
    let singular = Problem { e: dmatrix![1.0, 2.0, 0.0; 2.0, 4.0, 0.0; 0.0, 0.0, 1.0], ..p.clone() };
    let shape = Problem { s: DMatrix::zeros(2, 3), ..p.clone() };
    let nan = Problem { e: DMatrix::from_element(3, 3, f64::NAN), ..p.clone() };
    let hidden = Problem { b: DMatrix::zeros(3, 2), s: DMatrix::zeros(3, 2), a: p.e.clone() * 2.0, ..p.clone() };
    for discrete in [false, true] {
        assert!(matches!(singular.solve(discrete), Err(LinalgError::Singular { what: "E", .. })));
        let found = shape.solve(discrete);
        assert_eq!(found, Err(LinalgError::DimensionMismatch { what: "S", expected: (3, 2), found: (2, 3) }));
        assert!(matches!(nan.solve(discrete), Err(LinalgError::NotFinite { what: "E", .. })));
        let found = hidden.solve(discrete);
        assert!(
            matches!(found, Err(LinalgError::NotStabilizable { eigenvalue, .. }) if (eigenvalue.re - 2.0).abs() < 1e-9),
            "{found:?}"
        );
        let empty = DMatrix::zeros(0, 0);
        let nothing = Problem {
            a: empty.clone(),
            b: empty.clone(),
            q: empty.clone(),
            r: empty.clone(),
            s: empty.clone(),
            e: empty,
        };
        assert_eq!(nothing.solve(discrete).unwrap().poles, vec![]);
    }
}

/// Without a weight of the input, the zeros of the weighted output would be poles of the closed loop; one of them is at
/// -1, and at 1: there is no stabilizing solution, and Newton's iteration ends near the boundary.
#[test]
fn a_pole_on_the_boundary_is_no_solution() {
    let none = DMatrix::zeros(2, 1);
    for (a, b) in
        [(dmatrix![1.0, 0.1; 0.0, 1.0], dmatrix![0.005; 0.1]), (dmatrix![2.0, 0.0; 0.0, 1.0], dmatrix![1.0; 1.0])]
    {
        let found =
            generalized_dare(&a, &b, &dmatrix![1.0, 0.0; 0.0, 0.0], &dmatrix![0.0], &none, &DMatrix::identity(2, 2));
        assert!(matches!(found, Err(LinalgError::NotStabilizing { .. })), "{found:?}");
    }
}
