//! The theorems of sampled observers beyond the closed form, as properties of random systems. Statements and proofs:
//! docs/theory-cubic.md.

use luenberger_design::{
    CubicDesign, CubicGain, DesignError, Periods, SampledCubicDesign, VaryingPeriodDesign, at_varying_periods,
};
use luenberger_observers::{Observer, SampledCubicGains, SampledCubicObserver, SampledObserver, VaryingPeriodObserver};
use luenberger_proof::certificate::Theorem;
use luenberger_sim::{SampleTimes, Scenario, Signal};
use nalgebra::{DMatrix, DVector};
use proptest::prelude::*;

use crate::generators::{accretive, linear, matrix, observable_plant};

/// Columns of D of `theta = D D'`, of any rank from 1.
fn theta(p: usize, entries: &DMatrix<f64>, rank: usize) -> DMatrix<f64> {
    let d = DMatrix::from_fn(p, rank.min(p), |i, j| if i == j { 1.0 } else { entries[(i, j)] });
    &d * d.transpose()
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 24, ..ProptestConfig::default() })]

    /// Theorem E: for every S with S + S' > 0, every theta and every period the semi-implicit observer is proved, its
    /// step is the one stated, and V falls from errors of every size.
    #[test]
    fn the_semi_implicit_observer_decreases_v_at_every_period(
        plant in observable_plant(1..=5), d in matrix(5, 5), k in matrix(5, 5), weights in matrix(5, 5), rank in 1..=5_usize,
        e0 in matrix(5, 1), exponent in -2..12, period in 1e-3..0.3, strength in 0.01..100.0,
    ) {
        let (n, p) = (plant.a.nrows(), plant.c.nrows());
        let theta = theta(p, &weights, rank);
        let s: DMatrix<f64> = accretive(p, &d, &k) * strength;
        let correction = CubicGain::General(s.clone());
        let design =
            SampledCubicDesign::with_cubic_gain(&linear(&plant, 1.0), &theta, &correction, period).unwrap();
        prop_assert!(design.certificate.is_proved(), "{}", design.certificate);
        let theorem = design.certificate.theorems()[0].theorem();
        prop_assert!(matches!(theorem, Theorem::SemiImplicitCubicConvergence(_)), "{}", theorem.name());
        let o = &design.observer;
        // N = -P^-1 C'S with S itself, not S'.
        let residual = &design.p * o.n() + o.c().transpose() * &s;
        prop_assert!(residual.norm() <= 64.0 * n as f64 * f64::EPSILON * design.p.norm() * o.n().norm(), "{residual}");
        // A plant at rest: the error is minus the estimate.
        let (u, y) = (DVector::zeros(1), DVector::zeros(p));
        let mut xhat = DVector::from_fn(n, |i, _| e0[(i, 0)] * 10.0_f64.powi(exponent));
        let mut v = xhat.dot(&(&design.p * &xhat));
        for step in 0..30 {
            let innovation = -(o.c() * &xhat);
            let share = period * innovation.dot(&(&theta * &innovation));
            let system = DMatrix::identity(p, p) - o.c() * o.n() * share;
            let left = system.clone().lu().solve(&innovation).unwrap();
            let between = &xhat - o.n() * &left * share;
            let expected = o.ad() * &between + o.ld() * &left;
            o.step(f64::from(step) * period, &mut xhat, &u, &y);
            let condition = system.clone().svd(false, false);
            let condition = condition.singular_values.max() / condition.singular_values.min();
            // The step bounds s where the innovation is left with rounding only.
            if condition < 1e8 {
                let size = between.norm() + share * o.n().norm() * left.norm() + o.ld().norm() * left.norm();
                let bound = 256.0 * n as f64 * f64::EPSILON * condition * size * (1.0 + o.ad().norm());
                prop_assert!((&xhat - &expected).norm() <= bound, "step {step}: {xhat} and {expected}");
            }
            let next = xhat.dot(&(&design.p * &xhat));
            prop_assert!(next <= v * (1.0 + 1e-11), "V grew from {v} to {next}");
            v = next;
        }
    }

    /// As the period goes to 0 the observer is the one in continuous time: with the same P and gains the error of one
    /// step is of second order in h.
    #[test]
    fn the_semi_implicit_step_approaches_the_flow(
        plant in observable_plant(1..=4), d in matrix(4, 4), k in matrix(4, 4), weights in matrix(4, 4), e0 in matrix(4, 1),
    ) {
        let (n, p) = (plant.a.nrows(), plant.c.nrows());
        let (theta, linear) = (theta(p, &weights, p), linear(&plant, 1.0));
        let continuous =
            CubicDesign::new(&linear, &theta, &CubicGain::General(accretive(p, &d, &k))).unwrap().observer.clone();
        let (u, y) = (DVector::zeros(1), DVector::zeros(p));
        let start = DVector::from_fn(n, |i, _| e0[(i, 0)]);
        let slope = continuous.derivative(0.0, &start, &u, &y);
        let miss = |h: f64| {
            let held = luenberger_linalg::zero_order_hold(&continuous.a, &continuous.b, h).unwrap();
            let gains = luenberger_observers::SampledCubicGains {
                ad: held.ad, bd: held.bd, c: continuous.c.clone(), ld: &continuous.l * h, n: continuous.n.clone(),
                theta: theta.clone(), w: 0.0, period: h,
            };
            let coupling = luenberger_observers::semi_implicit::coupling(&gains.c, &gains.n);
            let observer = luenberger_observers::SampledCubicObserver::semi_implicit(gains, coupling).unwrap();
            let mut xhat = start.clone();
            observer.step(0.0, &mut xhat, &u, &y);
            ((xhat - &start) / h - &slope).norm()
        };
        // The scale of the second derivative along the flow.
        let o = &continuous;
        let rate = o.a.norm() + o.l.norm() * o.c.norm()
            + 3.0 * o.n.norm() * theta.norm() * o.c.norm().powi(3) * start.norm_squared();
        let h = 1e-3 / rate;
        prop_assert!(miss(h) <= 10.0 * h * rate * rate * start.norm() + 1e-9 * slope.norm(), "{}", miss(h));
    }
}

/// One output: the step leaves `1/(1 + s g)` of the innovation and the flow `1/sqrt(1 + 2 s g)`, g = -C N, which is all
/// that the two differ by.
#[test]
fn for_one_output_the_step_is_the_closed_form_with_another_fraction() {
    let plant = luenberger_plants::double_integrator().to_dynamic();
    let linear = linear(&plant, 1.0);
    let theta = DMatrix::identity(1, 1);
    for h in [1e-5, 1e-3, 0.1, 2.0] {
        let closed = SampledCubicDesign::new(&linear, &theta, 3.0, h).unwrap();
        let s = CubicGain::General(closed.s.clone());
        let semi = SampledCubicDesign::with_cubic_gain(&linear, &theta, &s, h).unwrap();
        assert!(semi.observer.coupling().is_some() && closed.observer.coupling().is_none());
        let (u, y) = (DVector::zeros(1), DVector::from_element(1, 2.0));
        let (mut one, mut other) = (DVector::zeros(2), DVector::zeros(2));
        closed.observer.step(0.0, &mut one, &u, &y);
        semi.observer.step(0.0, &mut other, &u, &y);
        let o = &closed.observer;
        let share = 3.0 * h * 4.0;
        let expected = (o.ad() * o.n() / 3.0 + o.ld()) * (2.0 / (1.0 + 2.0 * share).sqrt() - 2.0 / (1.0 + share));
        let size = one.norm() + other.norm() + o.n().norm();
        assert!((&one - &other - &expected).norm() <= 1e-13 * size, "{h}: {} and {expected}", &one - &other);
    }
}

/// A plant in free motion from `x` for the time t.
fn moved(a: &DMatrix<f64>, x: &DVector<f64>, t: f64) -> DVector<f64> {
    luenberger_linalg::expm(&(a * t)).unwrap() * x
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 12, ..ProptestConfig::default() })]

    /// Theorem F: where convergence at varying periods is proved, V falls by the factor from correction to correction,
    /// for the sequences of periods and misses of an adversary, who takes the period that leaves V largest, and for
    /// random ones; with the observer that runs, linear, radial and semi-implicit.
    #[test]
    fn v_falls_by_the_factor_for_every_sequence_of_periods_and_misses(
        plant in observable_plant(1..=3), d in matrix(3, 3), k in matrix(3, 3), e0 in matrix(3, 1), exponent in -1..6,
        h in 0.02..0.2, shorter in 0.75..1.0, longer in 1.0..1.3, misses in 0..3_usize, is_radial: bool,
        draws in prop::collection::vec(0.0..1.0, 120),
    ) {
        let (n, p) = (plant.a.nrows(), plant.c.nrows());
        let correction =
            if is_radial { CubicGain::Radial(2.0) } else { CubicGain::General(accretive(p, &d, &k)) };
        let periods = Periods { shortest: shorter * h, longest: longer * h, misses };
        let linear = linear(&plant, 1.0);
        let design = match VaryingPeriodDesign::new(&linear, &DMatrix::identity(p, p), &correction, h, &periods) {
            Ok(design) => design,
            // Periods beyond what the gain serves: the message has to say something true.
            Err(DesignError::VaryingPeriods { witness, .. }) => {
                prop_assert!(witness.is_none_or(|witness| witness.radius > 1.0));
                return Err(TestCaseError::reject("periods that are not proved"));
            }
            Err(other) => panic!("{other}"),
        };
        prop_assert!(design.certificate.is_proved(), "{}", design.certificate);
        let a = &linear.observer.a;
        let most = (misses + 1) as f64 * periods.longest;
        let observer =
            VaryingPeriodObserver::new(design.nominal.observer.clone(), a.clone(), plant.b.clone(), design.k.clone(), most)
                .unwrap();
        let v = |e: &DVector<f64>| e.dot(&(&design.nominal.p * e));
        let square = design.factor * design.factor;
        let factor = if is_radial { square } else { 2.0 * square / (1.0 + square) };
        // A plant at rest: the error is minus the estimate.
        let (u, y) = (DVector::zeros(1), DVector::zeros(p));
        let mut xhat = DVector::from_fn(n, |i, _| e0[(i, 0)] * 10.0_f64.powi(exponent));
        for pair in draws.chunks(2) {
            let before = v(&xhat);
            observer.correct(&mut xhat, &u, &y, h);
            let times = (1..=misses + 1).flat_map(|count| {
                [periods.shortest, 0.5 * (periods.shortest + periods.longest), periods.longest].map(|t| t * count as f64)
            });
            let worst = times.max_by(|s, t| v(&moved(a, &xhat, *s)).total_cmp(&v(&moved(a, &xhat, *t)))).unwrap();
            let count = 1 + (pair[0] * (misses + 1) as f64) as usize;
            let random = count as f64 * (periods.shortest + pair[1] * (periods.longest - periods.shortest));
            let elapsed = if pair[0] < 0.5 { worst } else { random };
            let expected = moved(a, &xhat, elapsed);
            // A missed sample is a prediction and no more: two predictions in a row.
            observer.predict(&mut xhat, &u, 0.25 * elapsed);
            observer.predict(&mut xhat, &u, 0.75 * elapsed);
            let scale = 1e-13 * (1.0 + a.norm() * elapsed) * expected.norm() + 1e-13 * before.sqrt();
            prop_assert!((&xhat - &expected).norm() <= scale.max(1e-250), "{xhat} and {expected}");
            prop_assert!(v(&xhat) <= factor * before * (1.0 + 1e-10), "V from {before} to {}", v(&xhat));
        }
    }
}

/// A refusal has times for which the error grows, and the bounds that it calls proved are: unstable between samples,
/// with a gain that overcorrects for long periods.
#[test]
fn periods_that_are_too_long_are_refuted_by_a_product() {
    let plant = luenberger_plants::StateSpace::new(
        nalgebra::dmatrix![0.0, 1.0; -25.0, 1.0],
        DMatrix::zeros(2, 0),
        nalgebra::dmatrix![1.0, 0.0],
    )
    .unwrap();
    let linear = luenberger_design::LinearDesign::with_poles(&plant, &[-4.0, -5.0]).unwrap();
    let requested = Periods { shortest: 0.05, longest: 0.9, misses: 1 };
    let design = |periods: &Periods| {
        VaryingPeriodDesign::new(&linear, &DMatrix::identity(1, 1), &CubicGain::Radial(1.0), 0.1, periods)
    };
    let Err(DesignError::VaryingPeriods { witness: Some(witness), largest: Some(largest), .. }) = design(&requested)
    else {
        panic!("{:?}", design(&requested))
    };
    let proved = design(&largest).unwrap();
    assert!(proved.certificate.is_proved(), "{}", proved.certificate);
    // The product, with the correction that the design has.
    let after = DMatrix::identity(2, 2) - &proved.k * &plant.c;
    let mut product = DMatrix::identity(2, 2);
    for t in &witness.times {
        product = luenberger_linalg::expm(&(&plant.a * *t)).unwrap() * &after * product;
    }
    let radius = luenberger_linalg::spectral_radius(&product).unwrap();
    assert!((radius - witness.radius).abs() <= 1e-9 * radius && radius > 1.0, "{radius} {witness}");
}

/// The prediction with an input is the zero-order hold.
#[test]
fn the_prediction_is_the_zero_order_hold() {
    let plant = luenberger_plants::third_order::example3().to_dynamic();
    let linear = linear(&plant, 1.0);
    let design = SampledCubicDesign::new(&linear, &DMatrix::identity(1, 1), 1.0, 0.1).unwrap();
    let k = design.observer.ad().clone().lu().solve(design.observer.ld()).unwrap();
    let (a, b) = (plant.a.clone(), plant.b.clone());
    let observer = VaryingPeriodObserver::new(design.observer.clone(), a, b, k, 3.0).unwrap();
    let u = DVector::from_element(plant.b.ncols(), 0.7);
    for t in [1e-3, 0.1, 1.0, 3.0] {
        let held = luenberger_linalg::zero_order_hold(&plant.a, &plant.b, t).unwrap();
        let mut xhat = DVector::from_element(3, 1.0);
        let expected = &held.ad * &xhat + &held.bd * &u;
        observer.predict(&mut xhat, &u, t);
        assert!((&xhat - &expected).norm() <= 1e-12 * expected.norm(), "{t}: {xhat} {expected}");
    }
    // Correction and prediction over the period are the step.
    let (y, mut one) = (DVector::from_element(1, 2.5), DVector::from_element(3, 1.0));
    let mut other = one.clone();
    design.observer.step(0.0, &mut one, &u, &y);
    observer.correct(&mut other, &u, &y, 0.1);
    observer.predict(&mut other, &u, 0.1);
    assert!((&one - &other).norm() <= 1e-13 * one.norm(), "{one} {other}");
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 12, ..ProptestConfig::default() })]

    /// Theorem F in simulations, the plant in motion under an input: at the samples that are drawn, of which some are
    /// missed, V falls from correction to correction by the factor that is proved; for the linear correction, radial
    /// and semi-implicit.
    #[test]
    fn v_falls_by_the_factor_at_the_samples_of_a_simulation(
        plant in observable_plant(1..=3), d in matrix(3, 3), k in matrix(3, 3), e0 in matrix(3, 1), x0 in matrix(3, 1),
        exponent in -1..3, h in 0.02..0.2, shorter in 0.75..1.0, longer in 1.0..1.3, misses in 0..3_usize, kind in 0..3,
        seed: u64,
    ) {
        let (n, p) = (plant.a.nrows(), plant.c.nrows());
        let correction = if kind == 2 { CubicGain::General(accretive(p, &d, &k)) } else { CubicGain::Radial(2.0) };
        let periods = Periods { shortest: shorter * h, longest: longer * h, misses };
        let linear = linear(&plant, 1.0);
        let Ok(design) = VaryingPeriodDesign::new(&linear, &DMatrix::identity(p, p), &correction, h, &periods) else {
            return Err(TestCaseError::reject("periods that are not proved"));
        };
        prop_assert!(design.certificate.is_proved(), "{}", design.certificate);
        let square = design.factor * design.factor;
        let (observer, lyapunov, factor) = match kind {
            0 => {
                // The linear correction has a P of its own.
                let theorem = at_varying_periods(&plant, &design.k, &periods).unwrap();
                let o = &design.nominal.observer;
                let gains = SampledCubicGains {
                    ad: o.ad().clone(), bd: o.bd().clone(), c: o.c().clone(), ld: o.ld().clone(),
                    n: DMatrix::zeros(n, p), theta: o.theta().clone(), w: 0.0, period: h,
                };
                let nominal = SampledCubicObserver::new(gains).unwrap();
                let (a, b, most) = (plant.a.clone(), plant.b.clone(), (misses + 1) as f64 * periods.longest);
                let observer = VaryingPeriodObserver::new(nominal, a, b, design.k.clone(), most).unwrap();
                let lyapunov = DMatrix::from_fn(n, n, |i, j| theorem.p[(i, j)]);
                (observer, lyapunov, theorem.factor * theorem.factor)
            }
            1 => (design.observer.clone(), design.nominal.p.clone(), square),
            _ => (design.observer.clone(), design.nominal.p.clone(), 2.0 * square / (1.0 + square)),
        };
        let times = SampleTimes { shortest: periods.shortest, longest: periods.longest, misses, seed };
        let x0: Vec<f64> = (0..n).map(|i| x0[(i, 0)]).collect();
        let initial: Vec<f64> = (0..n).map(|i| x0[i] + e0[(i, 0)] * 10.0_f64.powi(exponent)).collect();
        let run = |rows: &[f64]| {
            Scenario::new(plant.clone())
                .initial_state(&x0)
                .input(Signal::constant(&vec![0.5; plant.b.ncols()]))
                .continuous_discrete_observer("jitter", observer.clone(), times, &initial)
                .times(rows)
                .run()
                .unwrap()
        };
        let end = 30.0 * h;
        // Just before the samples that correct: by a time in which nothing moves.
        let before = |t: f64| t - 1e-9 * h;
        let samples = run(&[0.0, end]).observers[0].samples.clone();
        let mut rows: Vec<f64> = samples.iter().filter(|sample| sample.arrives).map(|sample| before(sample.time)).collect();
        rows.push(end + h);
        let trajectory = run(&rows);
        let (error, size) = (&trajectory.observers[0].error, trajectory.x.amax().max(1.0));
        let v = |row: usize| {
            let e = error.row(row).transpose();
            e.dot(&(&lyapunov * &e))
        };
        // What the integration of x and xhat leaves of their difference.
        let rounding = lyapunov.norm() * (1e-8 * size).powi(2);
        for row in 1..rows.len() - 1 {
            prop_assert!(
                v(row).sqrt() <= (factor * v(row - 1)).sqrt() * (1.0 + 1e-6) + rounding.sqrt(),
                "V from {} to {} at sample {row}, factor {factor}", v(row - 1), v(row)
            );
        }
        prop_assert!(rows.len() > 5);
    }
}
