//! Zeros stay zeros, poles come where there is freedom enough, and what is not reached is said.

use luenberger_linalg::{
    LinalgError, StructuredPlacement, eigenvalues, place, place_observer, place_observer_structured, place_structured,
};
use nalgebra::{Complex, DMatrix, dmatrix};
use proptest::prelude::*;

fn c(re: f64, im: f64) -> Complex<f64> {
    Complex::new(re, im)
}

fn real(poles: &[f64]) -> Vec<Complex<f64>> {
    poles.iter().map(|x| Complex::from(*x)).collect()
}

/// The zeros are exact, and the poles reported are those of this gain.
fn assert_honest(a: &DMatrix<f64>, outputs: &DMatrix<f64>, free: &DMatrix<bool>, found: &StructuredPlacement) {
    let l = &found.placement.gain;
    for (x, free) in l.iter().zip(free.iter()) {
        assert!(*free || *x == 0.0);
    }
    assert_eq!(found.free, free.iter().filter(|x| **x).count());
    let closed = a - l * outputs;
    let again = eigenvalues(&closed).unwrap();
    let n = a.nrows() as f64;
    let terms = a.norm() + l.norm() * outputs.norm();
    for (pole, sensitivity) in found.placement.poles.iter().zip(&found.placement.sensitivities) {
        let off = again.iter().map(|x| (x - pole).norm()).fold(f64::INFINITY, f64::min);
        // First-order bound; a pole of multiplicity n moves like the n-th root of the change instead.
        let rounding = 20.0 * n * f64::EPSILON;
        let bound = (rounding * sensitivity).min(rounding.powf(1.0 / n)) * terms;
        assert!(off <= bound, "{pole}: {off:e} > {bound:e}");
    }
}

/// No zero asked for, one output: the only gain there is.
#[test]
fn a_full_pattern_gives_the_unconstrained_gain() {
    let a = dmatrix![-0.1, -0.2, 0.0; 0.3, 0.0, 0.0; 0.1, 0.2, -3.0];
    let outputs = dmatrix![1.0, 1.0, 2.0];
    let requested = real(&[-30.0, -10.0, -5.0]);
    let free = DMatrix::from_element(3, 1, true);
    let (plain, found) = (
        place_observer(&a, &outputs, &requested).unwrap(),
        place_observer_structured(&a, &outputs, &requested, &free).unwrap(),
    );
    assert!(found.is_placed && found.rank == 3);
    assert!((&found.placement.gain - &plain.gain).norm() < 1e-9 * plain.gain.norm());
    assert_honest(&a, &outputs, &free, &found);
}

/// SLICOT SB01BD's plant, decentralised: the first input sees the first two states, the second the other two. By hand
/// the characteristic polynomial with K = [k1 k2 0 0; 0 0 k3 k4] has four free coefficients; the derivative has rank
/// four.
#[test]
fn the_plant_of_slicot_sb01bd_decentralised() {
    let a = dmatrix![-6.8, 0.0, -207.0, 0.0; 1.0, 0.0, 0.0, 0.0; 43.2, 0.0, 0.0, -4.2; 0.0, 0.0, 1.0, 0.0];
    let b = dmatrix![5.64, 0.0; 0.0, 0.0; 0.0, 1.18; 0.0, 0.0];
    let free = dmatrix![true, true, false, false; false, false, true, true];
    let requested = [c(-3.0, 94.0), c(-3.0, -94.0), c(-0.5, 0.15), c(-0.5, -0.15)];
    let found = place_structured(&a, &b, &requested, &free).unwrap();
    assert!(found.is_placed && found.rank == 4 && found.placement.deviation < 1e-10, "{found:?}");
    assert_honest(
        &a.transpose(),
        &b.transpose(),
        &free.transpose(),
        &StructuredPlacement {
            placement: luenberger_linalg::Placement {
                gain: found.placement.gain.transpose(),
                ..found.placement.clone()
            },
            ..found.clone()
        },
    );
}

/// One free entry for two poles: with l2 = 0 the loop of the double integrator is `s^2 + l1 s`, so one pole is 0
/// whatever l1. Asked for -1, -1 the nearest is `l1 = 1`, at the distance 1; but 0 is a fixed mode, and is named.
#[test]
fn a_fixed_mode_is_named() {
    let (a, outputs) = (dmatrix![0.0, 1.0; 0.0, 0.0], dmatrix![1.0, 0.0]);
    let free = dmatrix![true; false];
    let why = place_observer_structured(&a, &outputs, &real(&[-1.0, -1.0]), &free).unwrap_err();
    let LinalgError::FixedMode { eigenvalue, distance } = why else { panic!("{why}") };
    assert!(eigenvalue.norm() < 1e-12 && (distance - 1.0).abs() < 1e-12);
    // Asked for, it may stay.
    let found = place_observer_structured(&a, &outputs, &real(&[-1.0, 0.0]), &free).unwrap();
    assert!(found.is_placed && (found.placement.gain[0] - 1.0).abs() < 1e-12 && found.rank == 1);
    // No entry free: what the plant has, or an error.
    let none = DMatrix::from_element(2, 1, false);
    let plant = dmatrix![-1.0, 1.0; 0.0, -3.0];
    assert!(matches!(
        place_observer_structured(&plant, &outputs, &real(&[-1.0, -2.0]), &none),
        Err(LinalgError::FixedMode { .. })
    ));
    let kept = place_observer_structured(&plant, &outputs, &real(&[-1.0, -3.0]), &none).unwrap();
    assert!(kept.is_placed && kept.free == 0 && kept.placement.gain.norm() == 0.0);
    // A hidden mode is fixed too.
    let hidden = dmatrix![-1.0, 0.0; 1.0, -2.0];
    let all = DMatrix::from_element(2, 1, true);
    assert!(matches!(
        place_observer_structured(&hidden, &outputs, &real(&[-4.0, -5.0]), &all),
        Err(LinalgError::FixedMode { eigenvalue, .. }) if (eigenvalue + 2.0).norm() < 1e-12
    ));
    assert!(place_observer_structured(&hidden, &outputs, &real(&[-4.0, -2.0]), &all).unwrap().is_placed);
}

/// Freedom one short and no fixed mode: `s^2 + l s + 1` with only l free. Asked for -1, -4 (product 4, not 1): with the
/// poles p and 1/p, `(p + 4)^2 + (1/p + 1)^2` is least where `(p + 4) p^3 = p + 1`..., found here by a scan of p. The
/// answer says that it is not placed, and how near it is.
#[test]
fn the_nearest_is_found_and_said_to_be_no_more() {
    let (a, outputs) = (dmatrix![0.0, 1.0; -1.0, 0.0], dmatrix![0.0, 1.0]);
    let free = dmatrix![false; true];
    let found = place_observer_structured(&a, &outputs, &real(&[-1.0, -4.0]), &free).unwrap();
    assert!(!found.is_placed && found.rank == 1);
    assert_honest(&a, &outputs, &free, &found);
    let miss = |p: f64| (p + 4.0).powi(2) + (1.0 / p + 1.0).powi(2);
    let least = (100..1000).map(|k| miss(-0.01 * f64::from(k))).fold(f64::INFINITY, f64::min);
    let reached: f64 = found.placement.errors.iter().map(|x| x * x).sum();
    assert!(reached <= least && reached > least - 1e-3, "{reached} for {least}");
}

#[test]
fn repeated_and_complex_poles() {
    let mut a = DMatrix::zeros(4, 4);
    (a[(0, 1)], a[(2, 3)], a[(3, 0)]) = (1.0, 1.0, 0.5);
    let mut outputs = DMatrix::zeros(2, 4);
    (outputs[(0, 0)], outputs[(1, 2)]) = (1.0, 1.0);
    // Each output corrects its own cart.
    let free = dmatrix![true, false; true, false; false, true; false, true];
    for requested in [
        vec![c(-1.0, 1.0), c(-1.0, -1.0), c(-2.0, 1.0), c(-2.0, -1.0)],
        real(&[-1.0, -2.0, -3.0, -4.0]),
        real(&[-1.0, -2.0, -1.0, -2.0]),
        real(&[-2.0; 4]),
    ] {
        let found = place_observer_structured(&a, &outputs, &requested, &free).unwrap();
        // A quadruple pole is known to the fourth root of the rounding.
        let bound = if requested[0] == requested[3] { 3e-3 } else { 1e-6 };
        assert!(found.placement.deviation < bound, "{requested:?}: {:?}", found.placement);
        assert_honest(&a, &outputs, &free, &found);
    }
}

#[test]
fn one_state_and_units() {
    let one = place_structured(&dmatrix![3.0], &dmatrix![2.0], &real(&[-1.0]), &dmatrix![true]).unwrap();
    assert!((one.placement.gain[0] - 2.0).abs() < 1e-14 && one.is_placed);
    // The second example of the documentation with states 12 decades apart and time in microseconds.
    let (a, outputs) = (dmatrix![0.0, 1e18; -4e-6, -0.4e6], dmatrix![1.0, 0.0; 0.0, 1.0]);
    let free = dmatrix![true, true; false, true];
    let found = place_observer_structured(&a, &outputs, &real(&[-5e6, -6e6]), &free).unwrap();
    assert!(found.is_placed && found.placement.deviation < 1e-11 && found.placement.gain[(1, 0)] == 0.0, "{found:?}");
}

#[test]
fn bad_input_is_named() {
    let (a, b) = (dmatrix![0.0, 1.0; 0.0, 0.0], dmatrix![0.0; 1.0]);
    let all = DMatrix::from_element(1, 2, true);
    let requested = real(&[-1.0, -2.0]);
    assert!(matches!(
        place_structured(&a, &b, &requested, &DMatrix::from_element(2, 1, true)),
        Err(LinalgError::DimensionMismatch { what: "the pattern of K", expected: (1, 2), found: (2, 1) })
    ));
    assert!(matches!(
        place_observer_structured(&a, &dmatrix![1.0, 0.0], &requested, &all),
        Err(LinalgError::DimensionMismatch { what: "the pattern of L", expected: (2, 1), found: (1, 2) })
    ));
    assert!(matches!(place_structured(&b, &b, &requested, &all), Err(LinalgError::NotSquare { what: "A", .. })));
    assert!(matches!(
        place_structured(&a, &(b * f64::NAN), &requested, &all),
        Err(LinalgError::NotFinite { what: "B", .. })
    ));
    assert!(matches!(
        place_structured(&a, &dmatrix![0.0; 1.0], &real(&[-1.0]), &all),
        Err(LinalgError::PoleCount { .. })
    ));
    let none = place_structured(&a, &DMatrix::zeros(2, 0), &requested, &DMatrix::from_element(0, 2, true));
    assert!(matches!(none, Err(LinalgError::FixedMode { .. })));
    let empty =
        place_structured(&DMatrix::zeros(0, 0), &DMatrix::zeros(0, 1), &real(&[]), &DMatrix::from_element(1, 0, true));
    assert!(matches!(empty, Err(LinalgError::Empty { what: "A" })));
}

#[derive(Debug, Clone)]
struct Reachable {
    a: DMatrix<f64>,
    c: DMatrix<f64>,
    free: DMatrix<bool>,
    poles: Vec<Complex<f64>>,
}

/// Poles that some gain of the pattern fulfils by construction: the poles of `A - L0 C` for an L0 of the pattern.
fn reachable() -> impl Strategy<Value = Reachable> {
    (2..=5_usize).prop_flat_map(|n| {
        let p = 2_usize;
        (
            prop::collection::vec(-1.0..1.0_f64, n * n),
            prop::collection::vec(-1.0..1.0_f64, p * n),
            prop::collection::vec(-2.0..2.0_f64, p * n),
            Just((0..n * p).collect::<Vec<_>>()).prop_shuffle(),
            0..=n,
        )
            .prop_map(move |(a, c, l, order, zeros)| {
                let mut free = DMatrix::from_element(n, p, true);
                // Up to n p - n zeros: n entries are left at least.
                for k in order.into_iter().take(zeros.min(n * p - n)) {
                    free[k] = false;
                }
                let (a, c) = (DMatrix::from_vec(n, n, a), DMatrix::from_vec(p, n, c));
                let l = DMatrix::from_fn(n, p, |i, k| if free[(i, k)] { l[k * n + i] } else { 0.0 });
                let poles = eigenvalues(&(&a - l * &c)).unwrap();
                Reachable { a, c, free, poles }
            })
    })
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(48))]

    /// Where a gain of the pattern exists, the poles are found: to six digits of the plant's size, for poles that may
    /// be anything but far from defective.
    #[test]
    fn what_is_reachable_is_reached(r in reachable()) {
        let found = place_observer_structured(&r.a, &r.c, &r.poles, &r.free).unwrap();
        assert_honest(&r.a, &r.c, &r.free, &found);
        prop_assert!(found.placement.deviation < 1e-5, "{:e} with {} free: {:?}", found.placement.deviation, found.free, found.placement.errors);
    }

    /// Bauer and Fike, one pole at a time: `1 <= sensitivity <= cond(X)` for X with columns of norm one.
    #[test]
    fn no_pole_is_more_sensitive_than_all_together(r in reachable()) {
        let found = place_observer_structured(&r.a, &r.c, &r.poles, &r.free).unwrap().placement;
        for s in &found.sensitivities {
            prop_assert!(*s >= 1.0 - 1e-12 && *s <= found.condition * (1.0 + 1e-6), "{s} {}", found.condition);
        }
        let plain = place(&r.a, &r.c.transpose(), &r.poles);
        if let Ok(plain) = plain {
            prop_assert_eq!(plain.errors.len(), plain.sensitivities.len());
            prop_assert!(plain.sensitivities.iter().all(|s| *s >= 1.0 - 1e-12));
        }
    }
}
