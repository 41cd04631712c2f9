//! What is refused is refuted, and what is refuted is false: designs in unsuitable units.

use luenberger_design::{
    CubicDesign, CubicGain, DesignError, DiscreteDesign, DisturbanceBounds, GainOptions, GeneralizedPlant,
    LinearDesign, LyapunovWeight, NormFilterDesign, NormTarget, ReducedOrderDesign, SystemNorm, TimeDomain,
    UnseenModes, least_width_gain,
};
use luenberger_plants::StateSpace;
use nalgebra::{DMatrix, dmatrix};
use proptest::prelude::*;

fn plant(a: DMatrix<f64>, c: DMatrix<f64>) -> StateSpace {
    let n = a.nrows();
    StateSpace::new(a, DMatrix::zeros(n, 0), c).unwrap()
}

/// `[0 1e10; 0 0]`: in the units given the P of `Q = I` has eigenvalues 20 decades apart.
#[test]
fn a_gain_in_unsuitable_units_is_proved() {
    let of = plant(dmatrix![0.0, 1e10; 0.0, 0.0], dmatrix![1.0, 0.0]);
    let design = LinearDesign::with_poles(&of, &[-1.0, -2.0]).unwrap();
    assert!(design.certificate.is_proved(), "{}", design.certificate);
    let f = design.error_matrix();
    let residual = f.transpose() * &design.p + &design.p * &f + &design.q;
    assert!(residual.norm() <= 1e-12 * (design.p.norm() * f.norm()));
    // A matrix that is given keeps its P, and proves nothing here; a factor of the identity does not.
    let weighted = |weight| LinearDesign::with_poles_and_weight(&of, &[-1.0, -2.0], weight).unwrap();
    let identity = DMatrix::identity(2, 2);
    let given = weighted(LyapunovWeight::Matrix(identity.clone()));
    assert!(given.q == identity && !given.certificate.is_proved());
    let factor = weighted(LyapunovWeight::Identity(1.0));
    assert!(factor.q != identity && factor.certificate.is_proved());
    assert!(ReducedOrderDesign::with_poles(&of, &[-1.0]).unwrap().certificate.is_proved());
}

/// Exact arithmetic proves the P of `Q = I` here, whose correlations are 1 to rounding: no cubic gain could be computed
/// with it. Found among random units: x3 is in units of 2^-38.
#[test]
fn a_matrix_that_binary64_cannot_invert_is_not_chosen() {
    let a = dmatrix![0.0, 1.0, 0.0; 0.0, -0.5, 5.4569682106375694e-12; 0.0, -2.06158430208e11, -2.0];
    let linear = LinearDesign::with_poles(&plant(a, dmatrix![1.0, 0.0, 0.0]), &[-2.0, -2.75, -3.5]).unwrap();
    assert!(linear.certificate.is_proved());
    let cubic = CubicDesign::new(&linear, &dmatrix![1.0], &CubicGain::Gamma(1.0)).unwrap();
    assert!(cubic.certificate.is_proved(), "{}", cubic.certificate);
}

/// With the plain units `Q = I` is kept.
#[test]
fn a_gain_in_suitable_units_keeps_the_identity() {
    let design = LinearDesign::with_poles(&plant(dmatrix![0.0, 1.0; 0.0, 0.0], dmatrix![1.0, 0.0]), &[-1.0, -2.0]);
    assert_eq!(design.unwrap().q, DMatrix::identity(2, 2));
}

/// Floating point finds the abscissa -1e-17 or so; exact arithmetic an eigenvalue of at least 0.
#[test]
fn a_gain_that_does_not_stabilise_is_never_proved() {
    let third = 1.0 / 3.0;
    // The determinant of A - LC is 3 third - 1 = -2^-54 exactly: a positive eigenvalue of that size.
    let of = plant(dmatrix![-3.0, 1.0; 1.0, -third], dmatrix![1.0, 0.0]);
    assert!(matches!(LinearDesign::with_gain(&of, &dmatrix![0.0; 0.0]), Err(DesignError::NotHurwitz { .. })));
    let of = plant(dmatrix![0.5, 0.5; 0.5, 0.5], dmatrix![1.0, 0.0]);
    assert!(matches!(
        DiscreteDesign::with_gain(&of, 0.1, &dmatrix![0.0; 0.0]),
        Err(DesignError::NotSchur { radius, .. }) if (radius - 1.0).abs() < 1e-12
    ));
}

/// `x' = -x + 1e-4 w1`, `y = x + 1e-4 w2`: `L = sqrt(2) - 1` has the least H2 norm `1e-4 sqrt(sqrt(2) - 1)`.
#[test]
fn the_least_h2_norm_does_not_depend_on_units() {
    let least = |scale: f64, of: &GeneralizedPlant, goal: &NormTarget| {
        let of_plant = plant(dmatrix![-1.0], dmatrix![scale]);
        NormFilterDesign::new(&of_plant, TimeDomain::Continuous, SystemNorm::H2, of, goal, &GainOptions::default())
    };
    for (noise, output) in [(1e-4, 1.0), (1e-12, 1e6), (1e9, 1e-5)] {
        let of =
            GeneralizedPlant { e: dmatrix![noise, 0.0], d: dmatrix![0.0, noise * output], h: DMatrix::identity(1, 1) };
        let expected = noise * (2f64.sqrt() - 1.0).sqrt();
        let found = least(output, &of, &NormTarget::Least).unwrap();
        assert!((found.least.unwrap() / expected - 1.0).abs() < 1e-12 && found.found.is_none());
        assert!((found.l[(0, 0)] * output - (2f64.sqrt() - 1.0)).abs() < 1e-12, "{}", found.l);
        assert!(found.certificate.is_proved());
        let below = least(output, &of, &NormTarget::Below(1.001 * expected)).unwrap();
        assert!(below.certificate.is_proved() && below.norm < 1.001 * expected);
        match least(output, &of, &NormTarget::Below(0.9 * expected)) {
            Err(DesignError::NormTooSmall { best: Some(best), .. }) => assert!((best / expected - 1.0).abs() < 1e-6),
            other => panic!("{other:?}"),
        }
    }
}

/// Noise of the states that the outputs show, `E D' != 0`: `x' = x + w`, `y = x + w`. With `L = 1` both w and the
/// unstable pole cancel in `A - LC = 0`; the optimum is the stable mirror image, F = -1 with L = 2: `L - 1 = 1` of w is
/// left, of the variance `1/2`.
#[test]
fn noise_common_to_states_and_outputs_is_used() {
    let of = GeneralizedPlant { e: dmatrix![1.0], d: dmatrix![1.0], h: DMatrix::identity(1, 1) };
    // Decorrelated, A - S V^-1 C = 0 is an unexcited mode on the axis: the least norm, 0, is not attained.
    let of_plant = plant(dmatrix![1.0], dmatrix![1.0]);
    let new = |of_plant: &StateSpace, goal: &NormTarget| {
        NormFilterDesign::new(of_plant, TimeDomain::Continuous, SystemNorm::H2, &of, goal, &GainOptions::default())
    };
    let found = new(&of_plant, &NormTarget::Below(0.1)).unwrap();
    assert!(found.certificate.is_proved() && found.norm < 0.1);
    // A = 2: A - S V^-1 C = 1, whose mirror image is -1: L0 = 2, L = 3, G = 1 - 3 = -2, the norm |G|/sqrt(2).
    let found = new(&plant(dmatrix![2.0], dmatrix![1.0]), &NormTarget::Least).unwrap();
    assert!((found.l[(0, 0)] - 3.0).abs() < 1e-12 && (found.least.unwrap() - 2f64.sqrt()).abs() < 1e-12);
}

/// D = 0: every norm above 0 is attained by a gain that is large enough.
#[test]
fn a_gain_for_outputs_without_noise_is_found() {
    let of = GeneralizedPlant { e: dmatrix![1.0, 0.0], d: dmatrix![0.0, 0.0], h: DMatrix::identity(1, 1) };
    let of_plant = plant(dmatrix![-1.0], dmatrix![1.0]);
    for (norm, gamma) in [(SystemNorm::HInfinity, 1e-9), (SystemNorm::H2, 1e-3)] {
        let goal = NormTarget::Below(gamma);
        let time = TimeDomain::Continuous;
        let found = NormFilterDesign::new(&of_plant, time, norm, &of, &goal, &GainOptions::default()).unwrap();
        assert!(found.certificate.is_proved() && found.norm < gamma, "{}", found.norm);
    }
}

/// The bound of the gain is a sufficient condition: where only it fails, no gain is excluded.
#[test]
fn a_bound_of_the_gain_excludes_nothing() {
    let of = GeneralizedPlant { e: dmatrix![1.0, 0.0], d: dmatrix![0.0, 1.0], h: DMatrix::identity(1, 1) };
    let of_plant = plant(dmatrix![-1.0], dmatrix![1.0]);
    let options = GainOptions::default().max_gain(0.01);
    let (time, goal) = (TimeDomain::Continuous, NormTarget::Below(0.8));
    let refused = NormFilterDesign::new(&of_plant, time, SystemNorm::HInfinity, &of, &goal, &options).unwrap_err();
    assert!(matches!(refused, DesignError::NormNotFound { is_limited: true, why: None, .. }), "{refused}");
    assert!(refused.to_string().starts_with("not found: a gain within `max_gain`"), "{refused}");
    let why = "that there is none is not proved, because the inequality for `max_gain` is sufficient but not necessary";
    assert!(refused.to_string().ends_with(why), "{refused}");
}

/// A linear program that is not solved refutes no gain; one that has multipliers does.
#[test]
fn no_gain_of_least_width_needs_multipliers() {
    let acting = DisturbanceBounds::of_states_and_outputs(&dmatrix![1.0; 1.0], &[1.0], &[1.0]);
    let a = dmatrix![-3073.172593148491, 1.715448395432328e19; 1.3004253222139086e-13, -2450.637983320863];
    // A is Hurwitz, and its comparison matrix is A itself: L = 0 is a gain.
    assert!(a.trace() < 0.0 && a.determinant() > 0.0);
    match least_width_gain(&a, &dmatrix![1e6, 0.0], &acting, TimeDomain::Continuous) {
        Ok(_) | Err(DesignError::Undecided { .. }) => {}
        Err(other) => panic!("{other}"),
    }
    let none = least_width_gain(&dmatrix![0.0, 1.0; 0.0, 0.0], &dmatrix![1.0, 0.0], &acting, TimeDomain::Continuous);
    assert!(matches!(none, Err(DesignError::NoLeastWidth { .. })), "{none:?}");
}

/// Only a mode that remains is an error; a nearly unobservable one is decided by the numbers as stored.
#[test]
fn detectability_is_decided_exactly() {
    let of = |a, c| UnseenModes::of(&a, &c, TimeDomain::Continuous);
    assert_eq!(of(dmatrix![-1e-9, 0.0; 0.0, -1e8], dmatrix![0.0, 1.0]), UnseenModes::Decay);
    assert_eq!(of(dmatrix![1e-9, 0.0; 0.0, -1e8], dmatrix![0.0, 1.0]), UnseenModes::Remain);
    assert_eq!(of(dmatrix![1.0, 0.0; 0.0, -1.0], dmatrix![1e-300, 1.0]), UnseenModes::None);
    assert_eq!(of(DMatrix::identity(60, 60), DMatrix::zeros(1, 60)), UnseenModes::Undecided);
    assert_eq!(UnseenModes::Undecided.is_detectable(), None);
    // In discrete time: a rotation by 90 degrees, of the radius 1 and a little less.
    for (radius, expected) in [(1.0, UnseenModes::Remain), (1.0 - f64::EPSILON, UnseenModes::Decay)] {
        let a = dmatrix![0.0, -radius, 0.0; 1.0, 0.0, 0.0; 0.0, 0.0, 2.0];
        assert_eq!(UnseenModes::of(&a, &dmatrix![0.0, 0.0, 1.0], TimeDomain::Discrete), expected);
    }
    // A bias of 1 - 1e-15 decays: the filter is not refused.
    let slow = plant(dmatrix![1.0 - 1e-15, 0.0; 0.0, 0.5], dmatrix![0.0, 1.0]);
    let of = GeneralizedPlant { e: dmatrix![0.0, 0.0; 1.0, 0.0], d: dmatrix![0.0, 1.0], h: dmatrix![0.0, 1.0] };
    let new = |of_plant: &StateSpace| {
        let goal = NormTarget::Below(2.0);
        NormFilterDesign::new(of_plant, TimeDomain::Discrete, SystemNorm::H2, &of, &goal, &GainOptions::default())
    };
    assert!(!matches!(new(&slow), Err(DesignError::NotDetectable { .. } | DesignError::NormTooSmall { .. })));
    let kept = plant(dmatrix![1.0, 0.0; 0.0, 0.5], dmatrix![0.0, 1.0]);
    assert!(matches!(new(&kept), Err(DesignError::NotDetectable { .. })));
}

/// A matrix with these real eigenvalues, `T diag(s) T^-1` with T near the identity, in units `10^k`.
fn in_units(poles: &[f64], mix: &[f64], powers: &[i32]) -> DMatrix<f64> {
    let n = poles.len();
    let t = DMatrix::from_fn(n, n, |i, j| if i == j { 1.0 } else { 0.3 / n as f64 * mix[i * n + j] });
    let a = &t * DMatrix::from_diagonal(&nalgebra::DVector::from_column_slice(poles)) * t.try_inverse().unwrap();
    DMatrix::from_fn(n, n, |i, j| a[(i, j)] * 10f64.powi(powers[i] - powers[j]))
}

fn units(n: usize) -> impl Strategy<Value = (Vec<f64>, Vec<f64>, Vec<i32>)> {
    (prop::collection::vec(0.1..10.0, n), prop::collection::vec(-1.0..1.0, n * n), prop::collection::vec(-6..=6, n))
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 64, ..ProptestConfig::default() })]

    /// Every stable `A - LC` in units twelve decades apart is proved, and none with an eigenvalue of the wrong sign.
    #[test]
    fn units_do_not_decide((sizes, mix, powers) in (1usize..=5).prop_flat_map(units)) {
        let n = sizes.len();
        let none = (DMatrix::zeros(1, n), DMatrix::zeros(n, 1));
        let stable: Vec<f64> = sizes.iter().map(|s| -s).collect();
        let design = LinearDesign::with_gain(&plant(in_units(&stable, &mix, &powers), none.0.clone()), &none.1);
        prop_assert!(design.as_ref().is_ok_and(|design| design.certificate.is_proved()), "{design:?}");
        let slow: Vec<f64> = sizes.iter().map(|s| 1.0 / (1.0 + s)).collect();
        let of = plant(in_units(&slow, &mix, &powers), none.0.clone());
        let design = DiscreteDesign::with_gain(&of, 0.1, &none.1);
        prop_assert!(design.as_ref().is_ok_and(|design| design.certificate.is_proved()), "{design:?}");
        let mut unstable = stable;
        unstable[n - 1] = 1e-3;
        let design = LinearDesign::with_gain(&plant(in_units(&unstable, &mix, &powers), none.0), &none.1);
        prop_assert!(matches!(design, Err(DesignError::NotHurwitz { .. })), "{design:?}");
    }
}
