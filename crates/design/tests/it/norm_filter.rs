//! H-infinity and H2 filters against Riccati equations and norms of other tools.
//!
//! The plant `x' = [0 1 0; -2 -0.5 1; 0 0 -1] x + [0 0 1]'w1`, `y = x1 + 0.2 w2`. Numbers of scipy 1.17.1
//! (`solve_continuous_are`,
//! `solve_discrete_are`; the least gamma by bisection of the H-infinity Riccati equation) and of python-control 0.10.2
//! with slycot 0.7.1 (`hinfsyn`, `linfnorm`).

use luenberger_design::{
    DesignError, GainOptions, GeneralizedPlant, NormFilterDesign, NormTarget, SystemNorm, TimeDomain,
};
use luenberger_linalg::{LinalgError, discrete_h_infinity_norm, expm, h_infinity_norm};
use luenberger_plants::StateSpace;
use nalgebra::{DMatrix, dmatrix};

fn plant() -> StateSpace {
    StateSpace::new(
        dmatrix![0.0, 1.0, 0.0; -2.0, -0.5, 1.0; 0.0, 0.0, -1.0],
        DMatrix::zeros(3, 0),
        dmatrix![1.0, 0.0, 0.0],
    )
    .unwrap()
}

fn performance() -> GeneralizedPlant {
    GeneralizedPlant { e: dmatrix![0.0, 0.0; 0.0, 0.0; 1.0, 0.0], d: dmatrix![0.0, 0.2], h: DMatrix::identity(3, 3) }
}

/// The plant every 0.1 s, with `0.1 w1` added to x3.
fn sampled() -> (StateSpace, GeneralizedPlant) {
    let plant = plant();
    let a = expm(&(&plant.a * 0.1)).unwrap();
    let e = dmatrix![0.0, 0.0; 0.0, 0.0; 0.1, 0.0];
    (StateSpace::new(a, plant.b, plant.c).unwrap(), GeneralizedPlant { e, ..performance() })
}

fn design(
    time: TimeDomain,
    norm: SystemNorm,
    of: &GeneralizedPlant,
    goal: &NormTarget,
) -> Result<NormFilterDesign, DesignError> {
    let plant = if time == TimeDomain::Discrete { sampled().0 } else { plant() };
    NormFilterDesign::new(&plant, time, norm, of, goal, &GainOptions::default())
}

fn close(found: f64, expected: f64, digits: f64) {
    assert!((found / expected - 1.0).abs() < digits, "{found} and {expected}");
}

#[test]
fn the_least_h2_norm_is_that_of_the_kalman_filter() {
    let found = design(TimeDomain::Continuous, SystemNorm::H2, &performance(), &NormTarget::Least).unwrap();
    close(found.norm, 0.789_713_301_716_867_6, 1e-5);
    assert!(
        (&found.l - dmatrix![1.415_930_308_594_014_7; 1.002_429_319_397_570_6; 1.674_770_333_439_932_9]).norm() < 1e-2
    );
    assert!(found.certificate.is_proved() && found.gamma < 0.7899, "{}", found.certificate);
    // Of the second state alone: the optimum has the same gain.
    let second = GeneralizedPlant { h: dmatrix![0.0, 1.0, 0.0], ..performance() };
    let found = design(TimeDomain::Continuous, SystemNorm::H2, &second, &NormTarget::Least).unwrap();
    close(found.norm, 0.350_866_071_258_259_4, 1e-5);
    let (_, of) = sampled();
    let found = design(TimeDomain::Discrete, SystemNorm::H2, &of, &NormTarget::Least).unwrap();
    close(found.norm, 0.262_106_431_759_265_1, 1e-5);
    assert!(found.certificate.is_proved(), "{}", found.certificate);
}

#[test]
fn the_least_h_infinity_norm_is_that_of_the_riccati_equation() {
    let found = design(TimeDomain::Continuous, SystemNorm::HInfinity, &performance(), &NormTarget::Least).unwrap();
    let least = 0.565_957_153_875_344_5;
    close(found.found.unwrap(), least, 1e-5);
    close(found.gamma, 1.01 * least, 1e-5);
    assert!(found.norm < found.gamma && found.norm >= least, "{}", found.norm);
    assert!(found.certificate.is_proved(), "{}", found.certificate);
    let second = GeneralizedPlant { h: dmatrix![0.0, 1.0, 0.0], ..performance() };
    let found = design(TimeDomain::Continuous, SystemNorm::HInfinity, &second, &NormTarget::Least).unwrap();
    close(found.found.unwrap(), 0.318_757_260_946_132_27, 1e-5);
}

#[test]
fn the_norm_of_a_gain_is_that_of_slycot() {
    let l = dmatrix![1.415_930_308_594_014_7; 1.002_429_319_397_570_6; 1.674_770_333_439_932_9];
    let found =
        design(TimeDomain::Continuous, SystemNorm::HInfinity, &performance(), &NormTarget::OfGain(l.clone())).unwrap();
    close(found.norm, 0.778_756_672_700_167_4, 1e-9);
    close(found.frequency.unwrap(), 1.565_817_536_084_412_9, 1e-4);
    assert!(found.certificate.is_proved() && found.gamma < 0.7789, "{}", found.certificate);
    assert_eq!(found.l, l);
    let l = dmatrix![0.140_530_577_679_346_4; 0.076_503_943_371_376_81; 0.141_014_821_815_728_4];
    let (_, of) = sampled();
    let found = design(TimeDomain::Discrete, SystemNorm::HInfinity, &of, &NormTarget::OfGain(l.clone())).unwrap();
    close(found.norm, 0.833_548_554_443_239_7, 1e-9);
    assert!(found.certificate.is_proved(), "{}", found.certificate);
    let least = design(TimeDomain::Discrete, SystemNorm::HInfinity, &of, &NormTarget::Least).unwrap();
    assert!(least.certificate.is_proved() && least.gamma < found.gamma, "{}", least.certificate);
    assert!(design(TimeDomain::Discrete, SystemNorm::H2, &of, &NormTarget::OfGain(l)).unwrap().certificate.is_proved());
}

#[test]
fn bounds_are_kept_and_those_below_the_least_named() {
    for (norm, least) in [(SystemNorm::HInfinity, 0.565_957), (SystemNorm::H2, 0.789_713)] {
        for factor in [1.001, 1.2, 3.0] {
            let gamma = factor * least;
            let found = design(TimeDomain::Continuous, norm, &performance(), &NormTarget::Below(gamma)).unwrap();
            assert!(found.certificate.is_proved() && found.norm < gamma && found.gamma == gamma, "{}", found.norm);
        }
        match design(TimeDomain::Continuous, norm, &performance(), &NormTarget::Below(0.9 * least)) {
            Err(DesignError::NormTooSmall { best: Some(best), .. }) => close(best, least, 1e-4),
            other => panic!("{other:?}"),
        }
    }
    // Within a bound of the gain the least norm is larger.
    let options = GainOptions::default().max_gain(1.0);
    let new = |goal| {
        NormFilterDesign::new(&plant(), TimeDomain::Continuous, SystemNorm::HInfinity, &performance(), &goal, &options)
    };
    let bounded = new(NormTarget::Least).unwrap();
    assert!(bounded.l.norm() < 1.0 && bounded.found.unwrap() > 0.57 && bounded.certificate.is_proved());
    let message = new(NormTarget::Below(0.5)).unwrap_err().to_string();
    assert!(message.starts_with("no gain makes the H-infinity norm of the error less than 0.5 (the best"), "{message}");
}

/// With `E = 0` the error of a stable plant needs no correction: `T(s) = -H (sI - A + LC)^-1 L D` is 0 for L = 0. One of
/// the plant x' = x has the least norms sqrt(2) and 1: `L = 2` from `2 P - P^2 = 0`, and `L/|s + L - 1| -> 1` for large L.
/// Of x' = 0 the H2 norm is `sqrt(L/2)`, which has no least value.
#[test]
fn nothing_disturbs_the_states() {
    let of = GeneralizedPlant { e: dmatrix![0.0], d: dmatrix![1.0], h: dmatrix![1.0] };
    let with = |a: f64, time, norm, goal: &NormTarget, options: &GainOptions| {
        let plant = StateSpace::new(dmatrix![a], DMatrix::zeros(1, 0), dmatrix![1.0]).unwrap();
        NormFilterDesign::new(&plant, time, norm, &of, goal, options)
    };
    let plain = GainOptions::default();
    for norm in [SystemNorm::H2, SystemNorm::HInfinity] {
        for (a, time) in [(-1.0, TimeDomain::Continuous), (0.5, TimeDomain::Discrete)] {
            for options in [&plain, &GainOptions::default().max_gain(2.0)] {
                let refused = with(a, time, norm, &NormTarget::Least, options).unwrap_err();
                let expected =
                    format!("E = 0 and A is stable: the least {} norm is 0, that of the gain L = 0,", norm.name());
                assert!(refused.to_string().starts_with(&expected), "{refused}");
            }
            let found = with(a, time, norm, &NormTarget::Below(1e-3), &plain).unwrap();
            assert!(found.certificate.is_proved() && found.norm < 1e-3 && found.gamma == 1e-3, "{found:?}");
        }
        let unstable = with(1.0, TimeDomain::Continuous, norm, &NormTarget::Least, &plain).unwrap();
        let least = if norm == SystemNorm::H2 { 2f64.sqrt() } else { 1.0 };
        close(unstable.least.or(unstable.found).unwrap(), least, 1e-5);
    }
    let slow = with(0.0, TimeDomain::Continuous, SystemNorm::H2, &NormTarget::Least, &plain).unwrap_err();
    assert!(matches!(slow, DesignError::Linalg(LinalgError::NotExcited { .. })), "{slow}");
}

#[test]
fn what_is_wrong_is_named() {
    let with = |of: &GeneralizedPlant, goal: &NormTarget| {
        design(TimeDomain::Continuous, SystemNorm::H2, of, goal).unwrap_err()
    };
    let silent = GeneralizedPlant { d: dmatrix![0.0, 0.0], ..performance() };
    assert!(matches!(with(&silent, &NormTarget::Least), DesignError::NoiselessOutput { outputs: 1, sigma_min: 0.0 }));
    let long = GeneralizedPlant { d: dmatrix![0.0, 0.0, 1.0], ..performance() };
    assert!(with(&long, &NormTarget::Least).to_string().contains('D'));
    let wrong = NormTarget::OfGain(dmatrix![-9.0; 0.0; 0.0]);
    assert!(matches!(with(&performance(), &wrong), DesignError::NotHurwitz { .. }));
    assert!(matches!(with(&performance(), &NormTarget::Below(-1.0)), DesignError::NotPositive { what: "gamma", .. }));
    let hidden = StateSpace::new(dmatrix![0.0, 1.0; 0.0, 0.0], DMatrix::zeros(2, 0), dmatrix![0.0, 1.0]).unwrap();
    let of = GeneralizedPlant { e: dmatrix![0.0, 0.0; 1.0, 0.0], d: dmatrix![0.0, 1.0], h: DMatrix::identity(2, 2) };
    for time in [TimeDomain::Continuous, TimeDomain::Discrete] {
        let found = NormFilterDesign::new(
            &hidden,
            time,
            SystemNorm::HInfinity,
            &of,
            &NormTarget::Least,
            &GainOptions::default(),
        );
        match (time, found) {
            (TimeDomain::Continuous, Err(DesignError::NotDetectable { .. })) => {}
            // In discrete time the mode 0 is stable.
            (TimeDomain::Discrete, Ok(found)) => assert!(found.certificate.is_proved()),
            (_, other) => panic!("{other:?}"),
        }
    }
}

/// Closed forms: a band pass 2 zeta s/(s^2 + 2 zeta s + 1) has the peak 1 at 1, with a feedthrough 1 - that it is a
/// notch of norm 1; `1/(z - a)` has the norm `1/(1 - |a|)`.
#[test]
fn norms_of_closed_form() {
    let zeta = 1e-3;
    let (a, b, c) = (dmatrix![0.0, 1.0; -1.0, -2.0 * zeta], dmatrix![0.0; 1.0], dmatrix![0.0, 2.0 * zeta]);
    let found = h_infinity_norm(&a, &b, &c, &dmatrix![0.0]).unwrap();
    close(found.norm, 1.0, 1e-9);
    close(found.frequency, 1.0, 1e-4);
    let notch = h_infinity_norm(&a, &b, &(-c), &dmatrix![1.0]).unwrap();
    close(notch.norm, 1.0, 1e-9);
    for (pole, angle) in [(0.9, 0.0), (-0.9, std::f64::consts::PI), (-0.999_99, std::f64::consts::PI)] {
        let found = discrete_h_infinity_norm(&dmatrix![pole], &dmatrix![1.0], &dmatrix![1.0], &dmatrix![0.0]).unwrap();
        close(found.norm, 1.0 / (1.0 - f64::abs(pole)), 1e-8);
        assert!((found.frequency - angle).abs() < 1e-3, "{}", found.frequency);
    }
    let none = h_infinity_norm(&dmatrix![-1.0], &dmatrix![0.0], &dmatrix![1.0], &dmatrix![0.0]).unwrap();
    assert!(none.norm.abs() < f64::MIN_POSITIVE);
}

/// The central filter of `x' = -x + w1`, `y = x + w2`, `z = x` for gamma = 1: `-2 P + 1 = 0`, L = P = 1/2; for another
/// gamma the stabilizing root of `(1 - 1/gamma^2) P^2 + 2 P - 1 = 0`.
#[test]
fn an_unlimited_gain_is_that_of_the_central_filter() {
    let plant = StateSpace::new(dmatrix![-1.0], DMatrix::zeros(1, 0), dmatrix![1.0]).unwrap();
    let of = GeneralizedPlant { e: dmatrix![1.0, 0.0], d: dmatrix![0.0, 1.0], h: dmatrix![1.0] };
    let below = |gamma: f64| {
        let target = NormTarget::Below(gamma);
        let options = GainOptions::default();
        NormFilterDesign::new(&plant, TimeDomain::Continuous, SystemNorm::HInfinity, &of, &target, &options).unwrap()
    };
    for (gamma, gain) in
        [(1.0, 0.5), (2.0, (1.75_f64.sqrt() - 1.0) / 0.75), (0.75, 9.0 / 7.0 - (18.0_f64).sqrt() / 7.0)]
    {
        let found = below(gamma);
        assert!((found.l[(0, 0)] - gain).abs() < 1e-12, "{} {gain}", found.l);
        // The norm is the greater of those at zero and infinite frequency of sqrt(1 + L^2)/(s + 1 + L).
        close(found.norm, (1.0 + gain * gain).sqrt() / (1.0 + gain), 1e-9);
        assert!(found.certificate.is_proved() && found.norm < gamma);
    }
}

/// The same in discrete time, `x+ = x/2 + w1`: with `1/Pt = 1/P - 1/gamma^2`, `P = Pt/4/(1 + Pt) + 1` and
/// `L = Pt/2/(1 + Pt)`. scipy 1.17.1, `solve_discrete_are(0.5, [1, 1], 1, diag(1, -9))`.
#[test]
fn a_discrete_filter_is_central_too() {
    let plant = StateSpace::new(dmatrix![0.5], DMatrix::zeros(1, 0), dmatrix![1.0]).unwrap();
    let of = GeneralizedPlant { e: dmatrix![1.0, 0.0], d: dmatrix![0.0, 1.0], h: dmatrix![1.0] };
    let target = NormTarget::Below(3.0);
    let options = GainOptions::default();
    let found =
        NormFilterDesign::new(&plant, TimeDomain::Discrete, SystemNorm::HInfinity, &of, &target, &options).unwrap();
    close(found.l[(0, 0)], 0.28331700940520443, 1e-12);
    assert!(found.certificate.is_proved() && found.norm < 3.0);
}

/// The fastest pole of this plant is at -1.94; a gain of the inequality of the bound can have much faster ones.
#[test]
fn poles_of_the_least_norm_stay_near_those_of_the_plant() {
    let n = 8;
    let plant = StateSpace::new(
        DMatrix::from_fn(n, n, |i, j| match (i, j) {
            _ if i == j => -1.0,
            _ if i == j + 1 || j == i + 1 => 0.5,
            _ => 0.0,
        }),
        DMatrix::zeros(n, 0),
        DMatrix::from_fn(1, n, |_, j| if j == 0 { 1.0 } else { 0.0 }),
    )
    .unwrap();
    let mut e = DMatrix::zeros(n, n + 1);
    e.view_mut((0, 0), (n, n)).fill_with_identity();
    let d = DMatrix::from_fn(1, n + 1, |_, j| if j == n { 0.1 } else { 0.0 });
    let of = GeneralizedPlant { e, d, h: DMatrix::identity(n, n) };
    let options = GainOptions::default();
    let (time, norm) = (TimeDomain::Continuous, SystemNorm::HInfinity);
    let found = NormFilterDesign::new(&plant, time, norm, &of, &NormTarget::Least, &options).unwrap();
    let fastest = found.poles.iter().map(|pole| pole.norm()).fold(0.0, f64::max);
    assert!(found.certificate.is_proved() && fastest < 19.4, "{fastest}");
}
