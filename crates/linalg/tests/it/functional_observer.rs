//! The observer's equations hold, its poles are where they were asked for, and it follows the plant.

use luenberger_linalg::{
    FunctionalObserver, LinalgError, eigenvalues, functional_observer, least_functional_observer, place_observer,
    reduced_order_observer,
};
use nalgebra::{Complex, DMatrix, DVector, dmatrix};
use proptest::prelude::*;

fn real(poles: &[f64]) -> Vec<Complex<f64>> {
    poles.iter().map(|x| Complex::from(*x)).collect()
}

/// `T A - F T = G C`, `H = T B`, `M T + N C = K`, beside the size of the terms that are added up.
fn assert_observer(
    a: &DMatrix<f64>,
    b: &DMatrix<f64>,
    c: &DMatrix<f64>,
    k: &DMatrix<f64>,
    o: &FunctionalObserver,
    tolerance: f64,
) {
    let size = |x: &DMatrix<f64>, y: &DMatrix<f64>| x.abs() * y.abs();
    let check = |defect: DMatrix<f64>, terms: DMatrix<f64>, what: &str| {
        assert!(defect.norm() <= tolerance * terms.norm(), "{what}: {defect} of {terms}\n{o:?}");
    };
    check(&o.t * a - &o.f * &o.t - &o.g * c, size(&o.t, a) + size(&o.f, &o.t) + size(&o.g, c), "motion");
    check(&o.m * &o.t + &o.n * c - k, size(&o.m, &o.t) + size(&o.n, c) + k.abs(), "function");
    assert_eq!(o.h, &o.t * b);
    assert!(o.residual <= tolerance, "{:e}", o.residual);
}

fn assert_poles(f: &DMatrix<f64>, requested: &[Complex<f64>], tolerance: f64) {
    let found = eigenvalues(f).unwrap();
    assert_eq!(found.len(), requested.len());
    for pole in requested {
        let off = found.iter().map(|x| (x - pole).norm()).fold(f64::INFINITY, f64::min);
        assert!(off <= tolerance, "{pole} is missed by {off:e} in {found:?}");
    }
}

/// By hand: chain of three integrators, position measured; the observer of the other two is that of the chain of two
/// with the gain (3, 2) for -1, -2, thus `w' = [-3 1; -2 0] w + ..`.
#[test]
fn the_chain_of_three() {
    let a = dmatrix![0.0, 1.0, 0.0; 0.0, 0.0, 1.0; 0.0, 0.0, 0.0];
    let (b, c) = (dmatrix![0.0; 0.0; 1.0], dmatrix![1.0, 0.0, 0.0]);
    let o = reduced_order_observer(&a, &b, &c, &real(&[-1.0, -2.0])).unwrap();
    assert_observer(&a, &b, &c, &DMatrix::identity(3, 3), &o, 1e-14);
    assert!((o.f.trace() + 3.0).abs() < 1e-14 && (o.f.determinant() - 2.0).abs() < 1e-14);
    // In whatever coordinates of w, the transfer from y to the estimate of x2 is ((3 s^2 + 2 s) / (s^2 + 3 s + 2)).
    let s = Complex::new(0.7, 1.3);
    let inner = (DMatrix::identity(2, 2) * s - o.f.map(Complex::from)).lu().solve(&o.g.map(Complex::from)).unwrap();
    let x2 = (o.m.map(Complex::from) * inner + o.n.map(Complex::from))[(1, 0)];
    let expected = (s * s * 3.0 + s * 2.0) / (s * s + s * 3.0 + 2.0);
    assert!((x2 - expected).norm() < 1e-13, "{x2} {expected}");
}

/// Simulated without an integrator: in discrete time the error of the estimate shrinks exactly like the powers of F.
#[test]
fn the_error_follows_f() {
    let a = dmatrix![0.9, 0.3, 0.0; -0.2, 0.8, 0.4; 0.1, 0.0, 1.1];
    let (b, c) = (dmatrix![0.1; 0.5; 1.0], dmatrix![1.0, 0.0, 0.5]);
    let o = reduced_order_observer(&a, &b, &c, &real(&[0.2, 0.3])).unwrap();
    let (mut x, mut w) = (DVector::from_vec(vec![1.0, -2.0, 0.5]), DVector::from_vec(vec![3.0, 4.0]));
    let first = &w - &o.t * &x;
    for k in 0..10 {
        let u = DVector::from_element(1, f64::from(k).sin());
        let y = &c * &x;
        w = &o.f * &w + &o.g * &y + &o.h * &u;
        x = &a * &x + &b * &u;
    }
    let expected = o.f.pow(10) * first;
    assert!(((&w - &o.t * &x) - expected).norm() < 1e-12);
    let estimate = &o.m * &w + &o.n * (&c * &x);
    assert!((estimate - &x).norm() < 1e-3);
}

#[test]
fn outputs_enough_for_everything() {
    let a = dmatrix![0.0, 1.0; -1.0, 0.0];
    let (b, c) = (dmatrix![0.0; 1.0], dmatrix![1.0, 1.0; 0.0, 2.0; 1.0, -1.0]);
    let o = reduced_order_observer(&a, &b, &c, &real(&[])).unwrap();
    assert_eq!((o.f.shape(), o.m.shape(), o.n.shape(), o.placement.poles.len()), ((0, 0), (2, 0), (2, 3), 0));
    assert_observer(&a, &b, &c, &DMatrix::identity(2, 2), &o, 1e-14);
    assert_eq!(
        reduced_order_observer(&a, &b, &c, &real(&[-1.0])).unwrap_err(),
        LinalgError::PoleCount { order: 0, found: 1 }
    );
    // Dependent outputs count once: order 1 is left, and takes one pole.
    let c = dmatrix![1.0, 2.0; -2.0, -4.0];
    let o = reduced_order_observer(&a, &b, &c, &real(&[-3.0])).unwrap();
    assert_observer(&a, &b, &c, &DMatrix::identity(2, 2), &o, 1e-13);
    assert_poles(&o.f, &real(&[-3.0]), 1e-13);
    // One state, not measured by anything: no observer; measured: nothing to estimate.
    let one = reduced_order_observer(&dmatrix![2.0], &dmatrix![1.0], &dmatrix![1e-12], &real(&[])).unwrap();
    assert!((one.n[0] - 1e12).abs() < 1.0);
    assert!(matches!(
        reduced_order_observer(&dmatrix![2.0], &dmatrix![1.0], &dmatrix![0.0], &real(&[-1.0])),
        Err(LinalgError::Unobservable { .. })
    ));
}

#[test]
fn the_condition_that_fails_is_named() {
    let a = dmatrix![0.0, 1.0, 0.0; 0.0, 0.0, 1.0; 0.0, 0.0, 0.0];
    let (b, c) = (dmatrix![0.0; 0.0; 1.0], dmatrix![1.0, 0.0, 0.0]);
    // x2 alone: its rate x3 does not follow from x1, x2 and x1' = x2.
    let why = functional_observer(&a, &b, &c, &dmatrix![0.0, 1.0, 0.0], &real(&[-1.0])).unwrap_err();
    assert!(
        matches!(why, LinalgError::NotFunctional { row: 0, residual, .. } if (residual - 1.0).abs() < 1e-12),
        "{why}"
    );
    // x2 and x3 together: the reduced-order observer again.
    let k = dmatrix![0.0, 1.0, 0.0; 0.0, 0.0, 1.0];
    let o = functional_observer(&a, &b, &c, &k, &real(&[-1.0, -2.0])).unwrap();
    assert_observer(&a, &b, &c, &k, &o, 1e-13);
    assert_poles(&o.f, &real(&[-1.0, -2.0]), 1e-13);
    // z has a motion of its own that no output sees, with the eigenvalue -4.
    let apart = dmatrix![-1.0, 0.0; 0.0, -4.0];
    let why =
        functional_observer(&apart, &dmatrix![1.0; 1.0], &dmatrix![1.0, 0.0], &dmatrix![0.0, 1.0], &real(&[-2.0]))
            .unwrap_err();
    let LinalgError::FixedObserverMode { eigenvalue, margin } = why else { panic!("{why}") };
    assert!((eigenvalue + 4.0).norm() < 1e-13 && margin < 1e-14);
    // What is measured needs no rate: K in the rows of C.
    let o = functional_observer(&apart, &dmatrix![1.0; 1.0], &dmatrix![1.0, 0.0], &dmatrix![2.0, 0.0], &real(&[-7.0]))
        .unwrap();
    assert_observer(&apart, &dmatrix![1.0; 1.0], &dmatrix![1.0, 0.0], &dmatrix![2.0, 0.0], &o, 1e-13);
}

#[test]
fn bad_input_is_named() {
    let (a, b, c) = (dmatrix![0.0, 1.0; 0.0, 0.0], dmatrix![0.0; 1.0], dmatrix![1.0, 0.0]);
    let p = real(&[-1.0]);
    assert!(matches!(reduced_order_observer(&c, &b, &c, &p), Err(LinalgError::NotSquare { what: "A", .. })));
    assert!(matches!(reduced_order_observer(&a, &c, &c, &p), Err(LinalgError::DimensionMismatch { what: "B", .. })));
    assert_eq!(
        reduced_order_observer(&a, &b, &c, &real(&[-1.0, -2.0])).unwrap_err(),
        LinalgError::PoleCount { order: 1, found: 2 }
    );
    assert!(matches!(reduced_order_observer(&a, &b, &c, &real(&[f64::NAN])), Err(LinalgError::PoleNotFinite { .. })));
    assert!(matches!(
        functional_observer(&a, &b, &c, &dmatrix![1.0], &p),
        Err(LinalgError::DimensionMismatch { what: "K", .. })
    ));
    assert!(matches!(
        functional_observer(&a, &b, &c, &DMatrix::zeros(0, 2), &real(&[])),
        Err(LinalgError::Empty { what: "K" })
    ));
    assert!(matches!(
        functional_observer(&a, &b, &c, &dmatrix![f64::NAN, 0.0], &p),
        Err(LinalgError::NotFinite { what: "K", .. })
    ));
    let empty = DMatrix::zeros(0, 0);
    assert!(matches!(
        reduced_order_observer(&empty, &DMatrix::zeros(0, 1), &DMatrix::zeros(1, 0), &real(&[])),
        Err(LinalgError::Empty { what: "A" })
    ));
}

#[derive(Debug, Clone)]
struct Plant {
    a: DMatrix<f64>,
    b: DMatrix<f64>,
    c: DMatrix<f64>,
    units: Vec<i32>,
}

/// Observable by construction: each state drives the one before it, the first output sees the first; in mixed
/// coordinates. Fewer outputs than states.
fn plant() -> impl Strategy<Value = Plant> {
    (2..=6_usize).prop_flat_map(|n| (Just(n), 1..n.min(4))).prop_flat_map(|(n, p)| {
        let entries = |k: usize| prop::collection::vec(-1.0..1.0_f64, k);
        (entries(n * n), entries(p * n), entries(n), entries(n), prop::collection::vec(-40..=40_i32, n)).prop_map(
            move |(x, y, b, v, units)| {
                let a = DMatrix::from_fn(n, n, |i, j| match x[i * n + j] {
                    free if j == i + 1 => free.signum() * (1.0 + free.abs()),
                    _ if j > i + 1 => 0.0,
                    free => free,
                });
                let c = DMatrix::from_fn(p, n, |i, j| match (i, j) {
                    (0, 0) => 1.0,
                    (0, _) => 0.0,
                    _ => y[i * n + j] + if i == j { 2.0 } else { 0.0 },
                });
                let v = DVector::from_fn(n, |i, _| v[i] + if i == 0 { 1.5 } else { 0.0 });
                let q = DMatrix::identity(n, n) - &v * v.transpose() * (2.0 / v.norm_squared());
                Plant { a: &q * a * &q, b: DMatrix::from_vec(n, 1, b), c: c * &q, units }
            },
        )
    })
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(48))]

    /// Luenberger 1964: an observable plant has an observer of order n - p with any poles, in any units of its states.
    #[test]
    fn every_observable_plant_has_one_of_order_n_minus_p(plant in plant()) {
        let (p, n) = plant.c.shape();
        let requested: Vec<Complex<f64>> = real(&(0..n - p).map(|k| -1.0 - k as f64).collect::<Vec<_>>());
        let o = reduced_order_observer(&plant.a, &plant.b, &plant.c, &requested).unwrap();
        assert_observer(&plant.a, &plant.b, &plant.c, &DMatrix::identity(n, n), &o, 1e-12);
        assert_poles(&o.f, &o.placement.poles, 1e-12 * (o.f.norm() + 1.0) * o.placement.condition.min(1e6));
        prop_assert!(o.placement.deviation < 1e-8, "{:?}", o.placement);
        let d = |k: usize| 2f64.powi(plant.units[k]);
        let a = DMatrix::from_fn(n, n, |i, j| plant.a[(i, j)] * d(j) / d(i));
        let b = DMatrix::from_fn(n, 1, |i, _| plant.b[i] / d(i));
        let c = DMatrix::from_fn(p, n, |i, j| plant.c[(i, j)] * d(j));
        let scaled = reduced_order_observer(&a, &b, &c, &requested).unwrap();
        prop_assert!(scaled.residual < 1e-12 && scaled.placement.deviation < 1e-8, "{scaled:?}");
    }

    /// With K the whole of what C leaves, the functional observer is of the same order, and takes any poles.
    #[test]
    fn the_unmeasured_states_are_a_function(plant in plant()) {
        let (p, n) = plant.c.shape();
        let svd = nalgebra::SVD::new(plant.c.transpose() * &plant.c, true, false);
        let k = svd.u.unwrap().columns(p, n - p).transpose();
        let requested: Vec<Complex<f64>> = real(&(0..n - p).map(|k| -1.0 - k as f64).collect::<Vec<_>>());
        let o = functional_observer(&plant.a, &plant.b, &plant.c, &k, &requested).unwrap();
        prop_assert!(o.residual < 1e-12, "{:e}", o.residual);
        prop_assert!(o.placement.deviation < 1e-8, "{:?}", o.placement);
    }

    /// K = I with every state a function: the full-order observer, as `place_observer` has it with T = I - E C.
    #[test]
    fn the_whole_state_is_a_function(plant in plant()) {
        let n = plant.a.nrows();
        let requested: Vec<Complex<f64>> = real(&(0..n).map(|k| -1.0 - k as f64).collect::<Vec<_>>());
        let o = functional_observer(&plant.a, &plant.b, &plant.c, &DMatrix::identity(n, n), &requested).unwrap();
        prop_assert!(o.residual < 1e-12 && o.placement.deviation < 1e-7, "{:e} {:e}", o.residual, o.placement.deviation);
        prop_assert!(place_observer(&plant.a, &plant.c, &requested).is_ok());
    }
}

/// Chains of integrators `x1' = x2, ..`, the first state of each measured.
fn chains(lengths: &[usize]) -> (DMatrix<f64>, DMatrix<f64>) {
    let n = lengths.iter().sum();
    let (mut a, mut c) = (DMatrix::zeros(n, n), DMatrix::zeros(lengths.len(), n));
    let mut head = 0;
    for (k, length) in lengths.iter().enumerate() {
        c[(k, head)] = 1.0;
        for i in head + 1..head + length {
            a[(i - 1, i)] = 1.0;
        }
        head += length;
    }
    (a, c)
}

/// Luenberger 1966: one function needs nu - 1 states, nu the observability index, which is the length of the longest
/// chain; and fewer where `K p(A)` is in the rows of C, .., C A^q.
#[test]
fn one_function_needs_as_many_states_as_the_longest_chain_less_one() {
    for (lengths, k, order) in [
        (vec![3], vec![0.0, 1.0, 2.0], 2),
        (vec![2, 2, 2], vec![0.0, 1.0, 0.0, 2.0, 0.0, -1.0], 1),
        (vec![3, 3], vec![0.5, 1.0, 2.0, 0.0, -1.0, 1.0], 2),
        (vec![4, 2], vec![0.0, 1.0, 1.0, 3.0, 0.0, 1.0], 3),
        // x3 is no part of it.
        (vec![2, 3], vec![1.0, 4.0, 2.0, 0.0, 0.0], 1),
        (vec![4], vec![0.0, 0.0, 0.0, 1.0], 3),
    ] {
        let (a, c) = chains(&lengths);
        let (n, b) = (a.nrows(), DMatrix::from_element(a.nrows(), 1, 1.0));
        let k = DMatrix::from_row_slice(1, n, &k);
        let poles = real(&[-1.0, -1.5, -2.0, -2.5, -3.0, -3.5][..n]);
        let found = least_functional_observer(&a, &b, &c, &k, &poles).unwrap();
        assert_eq!((found.functions.nrows(), found.is_least), (order, true), "{lengths:?} {k}");
        assert_eq!(found.functions.rows(0, 1), k);
        assert_observer(&a, &b, &c, &found.functions, &found.observer, 1e-11);
        assert_poles(&found.observer.f, &poles[..order], 1e-9);
    }
}

/// z = x2 + x3 - 2 x4 of a chain of four: `K (A + 1)(A + 2)` has the entry `k2 + 3 k3 + 2 k4 = 0` at x4, so that an
/// observer of order 2 has the poles -1 and -2 and no others. It is found for those, where it exists.
#[test]
fn an_order_that_has_these_poles_alone_is_not_taken_for_others() {
    let (a, c) = chains(&[4]);
    let (b, k) = (DMatrix::zeros(4, 0), dmatrix![0.0, 1.0, 1.0, -2.0]);
    let found = least_functional_observer(&a, &b, &c, &k, &real(&[-3.0, -4.0, -5.0])).unwrap();
    assert_eq!((found.functions.nrows(), found.is_least), (3, true));
    let found = least_functional_observer(&a, &b, &c, &k, &real(&[-1.0, -2.0, -5.0])).unwrap();
    assert_eq!((found.functions.nrows(), found.is_least), (2, true));
    assert_observer(&a, &b, &c, &found.functions, &found.observer, 1e-13);
    assert_poles(&found.observer.f, &real(&[-1.0, -2.0]), 1e-13);
}

#[test]
fn several_functions_share_their_states() {
    let (a, c) = chains(&[3, 3]);
    let b = DMatrix::zeros(6, 0);
    let poles = real(&[-1.0, -2.0, -3.0, -4.0, -5.0, -6.0]);
    // x2 and x3, whose rates are x3 and 0: nothing is missing.
    let k = dmatrix![0.0, 1.0, 0.0, 0.0, 0.0, 0.0; 0.0, 0.0, 1.0, 0.0, 0.0, 0.0];
    let found = least_functional_observer(&a, &b, &c, &k, &poles).unwrap();
    assert!(found.functions == k && found.is_least);
    // x2 alone misses x3; x2 and x5 miss two, and n - p = 4 is the end.
    for (k, order) in [
        (dmatrix![0.0, 1.0, 0.0, 0.0, 0.0, 0.0], 2),
        (dmatrix![0.0, 1.0, 0.0, 0.0, 0.0, 0.0; 0.0, 0.0, 0.0, 0.0, 1.0, 0.0], 4),
    ] {
        let found = least_functional_observer(&a, &b, &c, &k, &poles).unwrap();
        assert_eq!(found.functions.nrows(), order);
        assert_observer(&a, &b, &c, &found.functions, &found.observer, 1e-11);
    }
    // Complex poles stay together: of an order that would separate them there is none.
    let pair = [Complex::new(-1.0, 2.0), Complex::new(-1.0, -2.0), Complex::new(-3.0, 0.0)];
    let found = least_functional_observer(&a, &b, &c, &dmatrix![0.0, 0.0, 1.0, 0.0, 0.0, 0.0], &pair).unwrap();
    assert_eq!(found.functions.nrows(), 2);
    assert_poles(&found.observer.f, &pair[..2], 1e-10);
}

#[test]
fn what_no_order_gives_is_the_refusal_of_the_first() {
    // A hidden mode in z.
    let a = dmatrix![-1.0, 1.0, 0.0; 0.0, -2.0, 0.0; 0.0, 0.0, -4.0];
    let (b, c) = (DMatrix::zeros(3, 0), dmatrix![1.0, 0.0, 0.0]);
    let why = least_functional_observer(&a, &b, &c, &dmatrix![0.0, 1.0, 1.0], &real(&[-3.0, -5.0, -6.0]));
    assert!(matches!(why, Err(LinalgError::NotFunctional { .. } | LinalgError::FixedObserverMode { .. })), "{why:?}");
    let (a, c) = chains(&[3]);
    let b = DMatrix::zeros(3, 0);
    let k = dmatrix![0.0, 1.0, 0.0; 0.0, 0.0, 1.0];
    let few = least_functional_observer(&a, &b, &c, &k, &real(&[-1.0]));
    assert_eq!(few.unwrap_err(), LinalgError::PoleCount { order: 2, found: 1 });
    let not_a_pole = least_functional_observer(&a, &b, &c, &k, &real(&[-1.0, f64::NAN]));
    assert!(matches!(not_a_pole, Err(LinalgError::PoleNotFinite { index: 1, .. })));
    assert!(matches!(
        least_functional_observer(&a, &b, &c, &dmatrix![f64::NAN, 0.0, 0.0], &real(&[-1.0])),
        Err(LinalgError::NotFinite { .. })
    ));
    assert!(matches!(
        least_functional_observer(&a, &b, &c, &DMatrix::zeros(0, 3), &real(&[])),
        Err(LinalgError::Empty { what: "K" })
    ));
    let one = dmatrix![2.0];
    let found = least_functional_observer(&one, &DMatrix::zeros(1, 0), &one, &one, &real(&[-1.0])).unwrap();
    assert_eq!(found.functions, one);
}
