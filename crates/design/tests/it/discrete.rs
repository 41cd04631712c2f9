//! Plants in discrete time: gains by a decay rate, estimated disturbances, bounds of the error.

use luenberger_design::{
    DesignError, DiscreteDesign, DisturbanceBounds, ErrorBound, GainOptions, LinearDesign, SampledCubicDesign,
    disturbances_with_sampled_rate, with_sampled_disturbance_chain,
};
use luenberger_linalg::spectral_radius;
use luenberger_plants::StateSpace;
use nalgebra::{Complex, DMatrix, dmatrix, dvector};
use proptest::prelude::*;

/// Observable by construction: a chain whose first state is measured.
fn plant(largest: usize) -> impl Strategy<Value = StateSpace> {
    (1..=largest, prop::collection::vec(-1.0..1.0f64, largest * largest)).prop_map(|(n, entries)| {
        let a = DMatrix::from_fn(n, n, |i, j| match entries[i * n + j] {
            free if j == i + 1 => free.signum() * (0.5 + free.abs()),
            _ if j > i + 1 => 0.0,
            free => free,
        });
        let c = DMatrix::from_fn(1, n, |_, j| if j == 0 { 1.0 } else { 0.0 });
        StateSpace::new(a, DMatrix::zeros(n, 0), c).unwrap()
    })
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(24))]

    /// With P, L and the factor q of a rate: `F'P F < q^2 P`, so that no eigenvalue of F is beyond q.
    #[test]
    fn a_rate_is_kept(plant in plant(4), rate in 0.2..3.0f64) {
        let design = DiscreteDesign::with_decay_rate(&plant, 0.25, rate).unwrap();
        prop_assert!(design.certificate.is_proved(), "{:?}", design.certificate);
        prop_assert_eq!(design.factor, (-0.25 * rate).exp());
        let f = &plant.a - design.l() * &plant.c;
        prop_assert!(spectral_radius(&f).unwrap() < design.factor);
        let fall = &design.p * design.factor.powi(2) - f.transpose() * &design.p * &f;
        prop_assert!(fall.symmetric_eigenvalues().min() > 0.0);
    }

    /// `limsup |e_i|` is at least what noise and disturbances with the worst signs sum up to, `sum_k |F^k G|_i W`.
    #[test]
    fn no_disturbance_exceeds_the_bound(
        plant in plant(4),
        poles in prop::collection::vec(-0.8..0.8f64, 4),
        w in 0.1..2.0f64,
        v in 0.0..1.0f64,
    ) {
        let n = plant.a.nrows();
        let design = DiscreteDesign::with_poles(&plant, 1.0, &poles[..n]).unwrap();
        let e = DMatrix::from_fn(n, 1, |i, _| 1.0 - 0.5 * i as f64);
        let acting = DisturbanceBounds::of_states_and_outputs(&e, &[w], &[v]);
        let bound = ErrorBound::discrete(&design.observer, &acting).unwrap();
        prop_assert!(bound.certificate.is_proved(), "{:?}", bound.certificate);
        let f = &plant.a - design.l() * &plant.c;
        let mut at = DMatrix::from_fn(n, 2, |i, j| if j == 0 { e[i] * w } else { -design.l()[i] * v });
        let mut peak = vec![0.0; n];
        for _ in 0..400 {
            peak.iter_mut().enumerate().for_each(|(i, sum): (usize, &mut f64)| *sum += at.row(i).abs().sum());
            at = &f * at;
        }
        for (limit, peak) in bound.limsup.iter().zip(&peak) {
            prop_assert!(*limit >= peak * (1.0 - 1e-9), "{:?} {peak}", bound.limsup);
        }
        if n == 1 {
            prop_assert!(bound.limsup[0] < 1.01 * peak[0], "{:?} {peak:?}", bound.limsup);
        }
    }
}

/// The least variance without process noise: the unstable mode is reflected, 2 to 1/2, by `L = 3/2`, and the stable one
/// is left alone, `X = L^2/(1 - 1/4) = 3` (scipy's `minimize` finds (1.5, 0) and 3 too). V does not change L. With |L|
/// < 3/5 no pole beyond 1 is moved within: `(z - 2)(z - 1/4) + l1 (z - 1/4) + l2 (z - 2)` is not positive at z = 1.
#[test]
fn the_least_noise_reflects_what_is_unstable() {
    let plant = StateSpace::new(dmatrix![2.0, 0.0; 0.0, 0.25], DMatrix::zeros(2, 0), dmatrix![1.0, 1.0]).unwrap();
    for v in [1.0, 1e-12, 1e6] {
        let quiet = GainOptions::default().noise(dmatrix![v]);
        let design = DiscreteDesign::lmi_with(&plant, 1.0, 0.0, &quiet).unwrap();
        assert!(design.certificate.is_proved() && design.factor == 1.0);
        let l = design.l();
        let f = &plant.a - l * &plant.c;
        let variance = luenberger_linalg::stein(&f.transpose(), &(l * l.transpose())).unwrap().p.trace();
        assert!((variance - 3.0).abs() < 3e-2, "{variance} {l}");
    }
    let small = GainOptions::default().max_gain(0.5);
    assert!(matches!(DiscreteDesign::lmi_with(&plant, 1.0, 0.0, &small), Err(DesignError::Infeasible { .. })));
}

/// The derivatives of a ramp with |d''| <= r over a period h: |d'| moves by r h, and d by r h^2/2 beside h d'.
#[test]
fn what_a_rate_adds_in_a_period() {
    let none = DisturbanceBounds::of_outputs(1, &[0.5]);
    let acting = disturbances_with_sampled_rate(&none, &[3.0], 2, 0.1);
    assert_eq!((acting.e.shape(), acting.d.shape(), acting.bounds.len()), ((3, 3), (1, 3), 3));
    for (found, expected) in acting.bounds.iter().zip([0.5, 3.0 * 0.005, 3.0 * 0.1]) {
        assert!((found - expected).abs() < 1e-15, "{:?}", acting.bounds);
    }
    assert_eq!(acting.e, dmatrix![0.0, 0.0, 0.0; 0.0, 1.0, 0.0; 0.0, 0.0, 1.0]);
}

#[test]
fn bad_input_is_named() {
    let plant = StateSpace::new(dmatrix![0.5], dmatrix![1.0], dmatrix![1.0]).unwrap();
    let rate = |period, rate| DiscreteDesign::with_decay_rate(&plant, period, rate).unwrap_err();
    assert!(matches!(rate(0.1, -1.0), DesignError::NotPositive { .. }));
    assert!(matches!(rate(0.1, f64::NAN), DesignError::NotPositive { .. }));
    assert!(matches!(rate(0.1, 301.0), DesignError::Setting { .. }));
    assert!(matches!(rate(0.0, 1.0), DesignError::NotPositive { .. }));
    let chain = |e: DMatrix<f64>, order, period| with_sampled_disturbance_chain(&plant, &e, order, period).unwrap_err();
    assert!(matches!(chain(dmatrix![1.0; 1.0], 1, 0.1), DesignError::Matrix(_)));
    assert!(matches!(chain(dmatrix![f64::NAN], 1, 0.1), DesignError::Matrix(_)));
    assert!(matches!(chain(dmatrix![1.0], 0, 0.1), DesignError::Setting { .. }));
    assert!(matches!(chain(dmatrix![1.0], 17, 0.1), DesignError::Setting { .. }));
    assert!(matches!(chain(dmatrix![1.0], 1, -0.1), DesignError::NotPositive { .. }));
    assert!(matches!(chain(dmatrix![0.0], 1, 0.1), DesignError::UnseenDisturbance { is_discrete: true, .. }));
    let design = DiscreteDesign::with_poles(&plant, 0.1, &[0.25]).unwrap();
    let bound = |bounds: &[f64]| ErrorBound::discrete(&design.observer, &DisturbanceBounds::of_outputs(1, bounds));
    assert!(matches!(bound(&[0.0]), Err(DesignError::NotPositive { .. })));
    assert!(matches!(bound(&[-1.0]), Err(DesignError::Negative { .. })));
    assert!(matches!(bound(&[1.0, 1.0]), Err(DesignError::Matrix(_))));
    // L = A: nothing that enters the output reaches the error. A deadbeat observer has no slowest mode.
    let at_once = DiscreteDesign::with_poles(&plant, 0.1, &[0.0]).unwrap();
    let found = ErrorBound::discrete(&at_once.observer, &DisturbanceBounds::of_outputs(1, &[1.0])).unwrap();
    assert!(found.certificate.is_proved() && (0.5..0.502).contains(&found.limsup[0]), "{:?}", found.limsup);
}

/// What the gain for samples says of several outputs: its error has the eigenvalues of `exp((A - L C) h)`, and `Ld/h`
/// tends to L in proportion to h, in any units of states and outputs.
#[test]
fn a_gain_for_samples_tends_to_the_one_in_continuous_time() {
    let a = dmatrix![0.0, 1.0, 0.0; -2.0, -0.5, 1.0; 0.0, -1.0, -0.3];
    let (b, c) = (dmatrix![0.0; 1.0; 0.5], dmatrix![1.0, 0.0, 0.0; 0.0, 0.0, 1.0]);
    let l = dmatrix![4.0, 0.0; 6.0, 1.0; 0.5, 3.0];
    for unit in [1.0, 1e-7, 1e7] {
        // The third state, which is the second output, in another unit.
        let t = DMatrix::from_diagonal(&dvector![1.0, 1.0, unit]);
        let back = DMatrix::from_diagonal(&dvector![1.0, 1.0, 1.0 / unit]);
        let measured = DMatrix::from_diagonal(&dvector![1.0, 1.0 / unit]);
        let plant = StateSpace::new(&t * &a * &back, &t * &b, c.clone()).unwrap();
        let linear = LinearDesign::with_gain(&plant, &(&t * &l * &measured)).unwrap();
        let distance = |h: f64| {
            let design = DiscreteDesign::sampled(&linear, h).unwrap();
            assert!(design.certificate.is_proved());
            let expected: Vec<Complex<f64>> = linear.poles.iter().map(|s| (s * h).exp()).collect();
            for pole in &design.poles {
                let nearest = expected.iter().map(|z| (z - pole).norm()).fold(f64::INFINITY, f64::min);
                assert!(nearest < 1e-8, "{pole} is {nearest} from {expected:?}");
            }
            let rate = &back * design.l() / h * measured.clone().try_inverse().unwrap();
            (rate - &l).abs().max()
        };
        let (far, near) = (distance(1e-2), distance(1e-3));
        assert!(far < 0.5 && (8.0..12.0).contains(&(far / near)), "unit {unit}: {far}, {near}");
        // The sampled cubic observer has the same gain.
        let cubic = SampledCubicDesign::new(&linear, &DMatrix::identity(2, 2), 1.0, 1e-2).unwrap();
        assert_eq!(cubic.l(), DiscreteDesign::sampled(&linear, 1e-2).unwrap().l());
    }
}

/// A mode that no output sees and that decays by itself leaves a gain for samples: that of the observer whose
/// measurement is held. One that grows leaves none.
#[test]
fn a_mode_that_decays_unseen_leaves_a_gain_for_samples() {
    let plant = StateSpace::new(dmatrix![-1.0, 0.0; 0.0, -2.0], dmatrix![1.0; 1.0], dmatrix![1.0, 0.0]).unwrap();
    let linear = LinearDesign::with_gain(&plant, &dmatrix![3.0; 0.0]).unwrap();
    let design = DiscreteDesign::sampled(&linear, 0.1).unwrap();
    // int_0^h e^(-4 s) ds 3.
    let expected = 3.0 * (1.0 - (-0.4f64).exp()) / 4.0;
    assert!((design.l()[(0, 0)] - expected).abs() < 1e-14 && design.l()[(1, 0)] == 0.0, "{}", design.l());
    assert!(design.certificate.is_proved());
    // At a period of half of its oscillation a plant hides a mode, and the measurement is held for too long.
    let oscillator = StateSpace::new(dmatrix![0.0, 1.0; -1.0, 0.0], dmatrix![0.0; 1.0], dmatrix![1.0, 0.0]).unwrap();
    let linear = LinearDesign::with_poles(&oscillator, &[-5.0, -6.0]).unwrap();
    let error = DiscreteDesign::sampled(&linear, std::f64::consts::PI).unwrap_err();
    assert!(error.to_string().contains("sampled"), "{error}");
}
