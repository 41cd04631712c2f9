//! The observers of the Cuk converter: the exact error equations, and the run of the paper.
//!
//! Error equations are checked as algebraic identities at random states, not by integration: the error dynamics follow
//! from the right-hand sides of observer and plant. The run uses the controller and the set-points of the paper.

use std::sync::OnceLock;

use luenberger_design::kkl::KklSettings;
use luenberger_design::{Certified, KklCandidate, KklDesign, KklError, Region};
use luenberger_observers::Observer;
use luenberger_observers::diagnosis::{Diagnose, Diagnosis};
use luenberger_observers::immersion_invariance::{Immersion, ImmersionInvarianceObserver};
use luenberger_observers::kkl::KklMap;
use luenberger_observers::pebo::Regression;
use luenberger_plants::{Column, CukConverter, Plant, state_jacobian};
use luenberger_proof::certificate::Rejection;
use luenberger_reproduce::kkl::cuk::{self, Embedding, Tuning};
use luenberger_sim::{Integrand, Scenario, Signal, Trajectory};
use nalgebra::{Matrix2, Matrix4, RealField, U1, U2, U4, Vector1, Vector2, Vector4, Vector6, convert};
use proptest::prelude::*;

use crate::generators::vector2;

/// States of the converter of the size it has in operation, and beyond.
fn state() -> impl Strategy<Value = Vector4<f64>> {
    (-3.0..3.0f64, -50.0..50.0f64, -3.0..3.0f64, -50.0..50.0f64)
        .prop_map(|(i1, v2, i3, v4)| Vector4::new(i1, v2, i3, v4))
}

fn duty() -> impl Strategy<Value = Vector1<f64>> {
    (0.05..0.95f64).prop_map(Vector1::new)
}

/// The unmeasured states of the converter.
fn unmeasured(x: &Vector4<f64>) -> Vector2<f64> {
    Vector2::new(x[0], x[3])
}

/// `d xhat/dt` of an observer whose estimate is affine in its state and the output, with the input at rest: one
/// difference with a step of 1 is exact.
fn estimate_rate<O>(
    observer: &O,
    state: &O::State,
    u: Vector1<f64>,
    y: &Vector2<f64>,
    y_rate: &Vector2<f64>,
) -> Vector2<f64>
where
    O: Observer<f64, Input = Vector1<f64>, Output = Vector2<f64>, Estimate = Vector2<f64>>,
{
    let slope = observer.derivative(0.0, state, &u, y);
    let moved: Vec<f64> = state.as_slice().iter().zip(slope.as_slice()).map(|(z, rate)| z + rate).collect();
    let moved = O::State::from_slice(&moved);
    observer.estimate(0.0, &moved, &u, &(y + y_rate)) - observer.estimate(0.0, state, &u, y)
}

/// Rounding of the largest terms of the converter's equations: 100 V over 10 mH, a few A over 22 uF, and products of
/// these with 1/C4.
const RATE: f64 = 1e7;
const ROUNDING: f64 = 64.0 * f64::EPSILON * RATE;

proptest! {
    /// Table I, KKLO: `e_i1' = -(w/L1) e_i1`, `e_v4' = -(G/C4) e_v4`, whatever the plant does.
    #[test]
    fn the_error_of_the_kklo_obeys_lambda(x in state(), xi in vector2(50.0), u in duty()) {
        let plant = CukConverter::default();
        let observer = cuk::kklo(plant).unwrap();
        let (y, x_rate) = (plant.output(0.0, &x, &u), plant.derivative(0.0, &x, &u));
        let e = observer.estimate(0.0, &xi, &u, &y) - unmeasured(&x);
        let e_rate = estimate_rate(&observer, &xi, u, &y, &plant.output(0.0, &x_rate, &u)) - unmeasured(&x_rate);
        let poles = Vector2::new(-(1.0 - u[0]) / plant.l1, -plant.g / plant.c4);
        // xhat1 is xi2/L1: 100 times larger.
        let claimed = e.component_mul(&poles);
        prop_assert!((e_rate - claimed).amax() <= 100.0 * ROUNDING, "{} {}", e_rate, claimed);
        // The same in the coordinates of Proposition 1: xi - phi(x), and Lambda itself.
        let phi = observer.map().image(0.0, &unmeasured(&x), &y);
        let phi_rate = observer.map().image(0.0, &unmeasured(&x_rate), &plant.output(0.0, &x_rate, &u));
        let slope = observer.derivative(0.0, &xi, &u, &y) - phi_rate;
        prop_assert!((slope - observer.map().lambda(0.0, &u, &y) * (xi - phi)).amax() <= ROUNDING);
    }

    /// Table I, I&IO: `e_i1' = -g1 w e_i1`, `e_v4' = -(G/C4 + g2) e_v4`.
    #[test]
    fn the_error_of_the_iio_has_the_poles_of_its_gains(
        x in state(), chi in vector2(50.0), u in duty(), g1 in 1.0..200.0f64, g2 in -500.0..500.0f64,
    ) {
        let plant = CukConverter::default();
        let observer = cuk::immersion_invariance(plant, &Tuning { g1, g2, ..Tuning::default() }).unwrap();
        let (y, x_rate) = (plant.output(0.0, &x, &u), plant.derivative(0.0, &x, &u));
        let e = observer.estimate(0.0, &chi, &u, &y) - unmeasured(&x);
        let e_rate = estimate_rate(&observer, &chi, u, &y, &plant.output(0.0, &x_rate, &u)) - unmeasured(&x_rate);
        let claimed = e.component_mul(&Vector2::new(-g1 * (1.0 - u[0]), -(plant.g / plant.c4 + g2)));
        prop_assert!((e_rate - claimed).amax() <= ROUNDING, "{} {}", e_rate, claimed);
    }

    /// "KKLO is linear, I&IO is nonlinear" is false here: with g1 = 1/L1 and g2 = 0 they are one observer.
    #[test]
    fn the_iio_contains_the_kklo(x in state(), estimate in vector2(50.0), u in duty()) {
        let plant = CukConverter::default();
        let linear = cuk::kklo(plant).unwrap();
        let immersed = cuk::immersion_invariance(plant, &Tuning { g1: 1.0 / plant.l1, g2: 0.0, ..Tuning::default() }).unwrap();
        let y = plant.output(0.0, &x, &u);
        let y_rate = plant.output(0.0, &plant.derivative(0.0, &x, &u), &u);
        let rates = [
            estimate_rate(&linear, &linear.initial(0.0, &estimate, &u, &y), u, &y, &y_rate),
            estimate_rate(&immersed, &immersed.initial(0.0, &estimate, &u, &y), u, &y, &y_rate),
        ];
        prop_assert!((rates[0] - rates[1]).amax() <= 100.0 * ROUNDING, "{} {}", rates[0], rates[1]);
    }

    /// The high-gain observers with the plant in them: both chains of the error are linear, with the polynomials that
    /// the documentation claims.
    #[test]
    fn the_errors_of_the_high_gain_observers_are_linear(x in state(), e in state(), u in duty()) {
        let (plant, tuning, w) = (CukConverter::default(), Tuning::<f64>::default(), 1.0 - u[0]);
        let (y, x_rate) = (plant.output(0.0, &x, &u), plant.derivative(0.0, &x, &u));
        // The order of the chains: (v2, i1, i3, v4).
        let chains = |x: &Vector4<f64>| Vector4::new(x[1], x[0], x[2], x[3]);
        let [a1, a2, a3, a4] = tuning.coefficients;
        let exact = cuk::high_gain_exact(plant, &tuning).unwrap();
        let varying = cuk::high_gain_time_varying(plant, &tuning).unwrap();
        let damping = plant.g / plant.c4;
        let cases = [(varying, tuning.r1, 1.0, -1.0), (exact, tuning.r2, plant.c2 / w, -plant.l3)];
        for (observer, r, s2, s4) in cases {
            let first = Matrix2::new(-a1 / r, w / plant.c2, -s2 * a2 / (r * r), 0.0);
            let second = Matrix2::new(-a3 / r, -1.0 / plant.l3, -s4 * a4 / (r * r), -damping);
            let mut matrix = Matrix4::zeros();
            matrix.fixed_view_mut::<2, 2>(0, 0).copy_from(&first);
            matrix.fixed_view_mut::<2, 2>(2, 2).copy_from(&second);
            let slope = observer.derivative(0.0, &(chains(&x) + e), &u, &y) - chains(&x_rate);
            // Gains up to a4/r^2 = 40000 in front of 100 V.
            prop_assert!((slope - matrix * e).amax() <= 64.0 * f64::EPSILON * 5e7, "{} {}", slope, matrix * e);
            // The polynomials of the table in `cuk`.
            let close = |a: f64, b: f64| (a - b).abs() <= 8.0 * f64::EPSILON * b.abs();
            prop_assert!(close(-first.trace(), a1 / r) && close(first.determinant(), w * s2 * a2 / (r * r * plant.c2)));
            prop_assert!(close(-second.trace(), a3 / r + damping));
            let constant = a3 * plant.g / (r * plant.c4) - s4 * a4 / (r * r * plant.l3);
            prop_assert!(close(second.determinant(), constant));
        }
    }

    /// The differentiator knows no plant: in an equilibrium its error obeys `s^2 + (a1/r) s + a2/r^2` in both chains.
    #[test]
    fn the_differentiator_has_the_poles_of_its_coefficients(vd in 1.0..30.0f64, e in state()) {
        let (plant, tuning) = (CukConverter::default(), Tuning::<f64>::default());
        let observer = cuk::high_gain_differentiator(plant, &tuning).unwrap();
        let (x, u) = (plant.equilibrium(vd), Vector1::new(plant.equilibrium_input(vd)));
        let y = plant.output(0.0, &x, &u);
        let (a1, a2) = (tuning.coefficients[0] / tuning.r2, tuning.coefficients[1] / (tuning.r2 * tuning.r2));
        let slope = observer.derivative(0.0, &(Vector4::new(y[0], 0.0, y[1], 0.0) + e), &u, &y);
        let claimed = Vector4::new(e[1] - a1 * e[0], -a2 * e[0], e[3] - a1 * e[2], -a2 * e[2]);
        prop_assert!((slope - claimed).amax() <= 64.0 * f64::EPSILON * a2 * 100.0);
        // And there it estimates rightly when e is zero.
        let estimate = observer.estimate(0.0, &Vector4::new(y[0], 0.0, y[1], 0.0), &u, &y);
        prop_assert!((estimate - unmeasured(&x)).amax() <= 16.0 * f64::EPSILON * 50.0);
    }

    /// What makes a PEBO: `d s(y)/dt = g + m theta` with `theta = phi(x) - xi`, a constant. For the converter's two.
    #[test]
    fn the_regressions_of_the_converter_are_exact(x in state(), xi in vector2(50.0), u in duty()) {
        let (plant, tuning) = (CukConverter::default(), Tuning::<f64>::default());
        let (y, x_rate) = (plant.output(0.0, &x, &u), plant.derivative(0.0, &x, &u));
        let y_rate = plant.output(0.0, &x_rate, &u);

        let pebo = cuk::pebo(plant, &tuning).unwrap();
        let map = pebo.map();
        let theta = map.image(0.0, &unmeasured(&x), &y) - xi;
        let theta_rate = map.image(0.0, &unmeasured(&x_rate), &y_rate) - map.slope(0.0, &xi, &u, &y);
        // phi' and B both contain G L3/C4 y2', which is 20 y2'.
        prop_assert!(theta_rate.amax() <= 20.0 * ROUNDING, "{}", theta_rate);
        let claimed = map.known(0.0, &xi, &u, &y) + map.regressor(0.0, &xi, &u, &y) * theta;
        prop_assert!((y_rate - claimed).amax() <= 20.0 * ROUNDING, "{} {}", y_rate, claimed);

        // The [KKL+PEB]O: theta is what is missing in i1; its error in v4 decays by itself.
        let both = cuk::kkl_pebo(plant, &tuning).unwrap();
        let map = both.map();
        let theta = x[0] - xi[0];
        let slope = map.slope(0.0, &xi, &u, &y);
        prop_assert!((slope[0] - x_rate[0]).abs() <= ROUNDING);
        prop_assert!((slope[1] - x_rate[3] + plant.g / plant.c4 * (xi[1] - x[3])).abs() <= ROUNDING);
        let claimed = map.known(0.0, &xi, &u, &y)[0] + map.regressor(0.0, &xi, &u, &y)[0] * theta;
        prop_assert!((y_rate[0] - claimed).abs() <= ROUNDING);
    }
}

/// The set-point |Vd| at the time t: 15, 25, 10, 20, 10, 15 on successive 0.2 s.
fn set_point(t: f64) -> f64 {
    const SEQUENCE: [f64; 6] = [15.0, 25.0, 10.0, 20.0, 10.0, 15.0];
    SEQUENCE[((t / 0.2) as usize).min(5)]
}

/// The estimate of an observer whose dynamic extension is zero: where the paper starts.
fn at_rest<O>(observer: &O) -> Vec<f64>
where
    O: Observer<f64, Input = Vector1<f64>, Output = Vector2<f64>>,
{
    let plant = CukConverter::default();
    let x = plant.equilibrium(5.0);
    let u = Vector1::new(plant.control(&x, set_point(0.0), 0.2));
    let zero = O::State::from_slice(&vec![0.0; observer.dimensions().state]);
    observer.estimate(0.0, &zero, &u, &plant.output(0.0, &x, &u)).as_slice().to_vec()
}

const OBSERVERS: [&str; 7] = ["KKLO", "PEBO", "[KKL+PEB]O", "I&IO", "HGO, time-varying", "HGO, linear", "HGO, exact"];

/// The run of section V.C with the seven observers.
fn paper_run(tuning: &Tuning<f64>) -> Trajectory {
    let plant = CukConverter::default();
    let kklo = cuk::kklo(plant).unwrap();
    let pebo = cuk::pebo(plant, tuning).unwrap();
    let both = cuk::kkl_pebo(plant, tuning).unwrap();
    let iio = cuk::immersion_invariance(plant, tuning).unwrap();
    let zero = Vector4::zeros();
    let varying = cuk::high_gain_time_varying(plant, tuning).unwrap().starting_at(zero).unwrap();
    let differentiator = cuk::high_gain_differentiator(plant, tuning).unwrap().starting_at(zero).unwrap();
    let exact = cuk::high_gain_exact(plant, tuning).unwrap().starting_at(zero).unwrap();
    let starts = [
        at_rest(&kklo),
        at_rest(&pebo),
        at_rest(&both),
        at_rest(&iio),
        at_rest(&varying),
        at_rest(&differentiator),
        at_rest(&exact),
    ];
    let unmeasured = [0, 3];
    Scenario::new(plant)
        .initial_state(plant.equilibrium(5.0).as_slice())
        .input(Signal::law(move |view, u| {
            u[0] = plant.control(&Vector4::from_column_slice(view.x), set_point(view.t), 0.2);
        }))
        .breakpoints(&[0.2, 0.4, 0.6, 0.8, 1.0])
        .partial_observer("KKLO", kklo, &starts[0], &unmeasured)
        .partial_observer("PEBO", pebo, &starts[1], &unmeasured)
        .partial_observer("[KKL+PEB]O", both, &starts[2], &unmeasured)
        .partial_observer("I&IO", iio, &starts[3], &unmeasured)
        .partial_observer("HGO, time-varying", varying, &starts[4], &unmeasured)
        .partial_observer("HGO, linear", differentiator, &starts[5], &unmeasured)
        .partial_observer("HGO, exact", exact, &starts[6], &unmeasured)
        .integral("int w", Integrand::custom(|view| 1.0 - view.u[0]))
        .tolerances(1e-8, 1e-9)
        .until(1.2, 1201)
        .run()
        .unwrap()
}

/// One run for all the tests that look at it.
fn shared_run() -> &'static Trajectory {
    static RUN: OnceLock<Trajectory> = OnceLock::new();
    RUN.get_or_init(|| paper_run(&Tuning::default()))
}

/// What one step of the run may be wrong by: rtol = 1e-8 of the 50 V there are. All errors decay, those of earlier
/// steps too.
const INTEGRATION: f64 = 1e-8 * 50.0;

#[test]
fn all_seven_observers_of_the_converter_converge() {
    let run = shared_run();
    for name in OBSERVERS {
        let error = &run.observer(name).unwrap().error;
        for state in 0..2 {
            let start = error[(0, state)].abs();
            assert!(start > 0.05, "{name} starts right, and nothing is tested");
            // The slowest error is that of the time-varying HGO, exp(-20 t), then the I&IO's, exp(-g1 int w) with w >=
            // 0.3: exp(-18) and less.
            assert!(error[(1200, state)].abs() <= 1e-6, "{name}: {}", error[(1200, state)]);
        }
    }
    // At every change of the set-point but the first: exp(-20 * 0.4) times the peak of about 1 A.
    for (name, jump) in OBSERVERS.into_iter().flat_map(|name| [400, 600, 800, 1000].map(|jump| (name, jump))) {
        let e = run.observer(name).unwrap().error.row(jump - 1).amax();
        assert!(e <= 2e-3, "{name} at {jump} ms: {e}");
    }
}

/// The runs beside the closed forms: KKLO and I&IO with the integral of w, the PEBO's second parameter with
/// `F[1] = 1 - exp(-alpha t)`.
#[test]
fn the_runs_follow_their_closed_forms() {
    let (run, tuning, plant) = (shared_run(), Tuning::<f64>::default(), CukConverter::default());
    let complement = run.integral("int w").unwrap();
    let kklo = &run.observer("KKLO").unwrap().error;
    let iio = &run.observer("I&IO").unwrap().error;
    let pebo = run.observer("PEBO").unwrap();
    // theta~2 of the PEBO: the error in v4 has it and nothing else.
    let gain = tuning.gains[1] / (plant.l3 * plant.l3);
    for k in 0..=1200 {
        let (t, w) = (run.t[k], complement[k]);
        let claimed = kklo[(0, 0)] * (-w / plant.l1).exp();
        assert!((kklo[(k, 0)] - claimed).abs() <= INTEGRATION, "KKLO at {t}: {} {claimed}", kklo[(k, 0)]);
        let claimed = iio[(0, 0)] * (-tuning.g1 * w).exp();
        assert!((iio[(k, 0)] - claimed).abs() <= INTEGRATION, "I&IO at {t}: {} {claimed}", iio[(k, 0)]);
        let decay = |p: f64| (1.0 - (-p * tuning.alpha * t).exp()) / (p * tuning.alpha);
        // int (1 - exp(-alpha s))^2 = t - 2 decay(1) + decay(2).
        let excitation = t - 2.0 * decay(1.0) + decay(2.0);
        let claimed = pebo.error[(0, 1)] * (-gain * excitation).exp();
        assert!((pebo.error[(k, 1)] - claimed).abs() <= INTEGRATION, "PEBO at {t}: {} {claimed}", pebo.error[(k, 1)]);
    }
}

/// With alpha = 0.5 as printed the two estimators take about as long as the others, although the filters are slow:
/// their error in i1 is `exp(-gamma int F[w]^2/C2^2)`, about `exp(-(t/31 ms)^3)`, where the KKLO has exp(-t/22 ms). And
/// it never grows.
#[test]
fn the_printed_filters_are_fast_enough() {
    let run = shared_run();
    for name in ["PEBO", "[KKL+PEB]O"] {
        let error = run.observer(name).unwrap().error.column(0).map(f64::abs);
        for k in 0..1200 {
            assert!(error[k + 1] <= error[k] + INTEGRATION, "{name} at {k} ms: {} {}", error[k], error[k + 1]);
        }
        // w = 12/27 while |Vd| = 15, reached within 20 ms and 0.4 to 0.5 before that.
        let ratio = |k: usize| error[k] / error[0];
        assert!(ratio(20) > 0.6 && ratio(31) > 0.25 && ratio(31) < 0.5 && ratio(60) < 2e-3, "{name}");
    }
}

/// "The dynamics are bounded by the controller": u stays within lambda/2 of its equilibrium value, and all states stay
/// of the size of their equilibria.
#[test]
fn the_controller_keeps_to_its_bounds() {
    let (run, plant) = (shared_run(), CukConverter::default());
    for k in 0..1200 {
        let (low, high) = plant.input_bounds(set_point(run.t[k]), 0.2).unwrap();
        assert!((low..=high).contains(&run.u[(k, 0)]), "{} ms: {}", k, run.u[(k, 0)]);
    }
    // Settled before each change: what the observers that need it rely on.
    for (k, vd) in [(199, 15.0), (399, 25.0), (599, 10.0), (799, 20.0), (999, 10.0), (1200, 15.0)] {
        let settled = Vector4::from_fn(|i, _| run.x[(k, i)]) - plant.equilibrium(vd);
        assert!(settled.amax() <= INTEGRATION, "{k} ms: {settled}");
    }
}

proptest! {
    /// The power balance of the converter: what is stored changes by what comes in less what the load takes, whatever
    /// the duty cycle.
    #[test]
    fn the_converter_conserves_power(x in state(), u in duty()) {
        let plant = CukConverter::default();
        let weights = Vector4::new(plant.l1, plant.c2, plant.l3, plant.c4);
        let stored = plant.derivative(0.0, &x, &u).component_mul(&weights).dot(&x);
        let balance = plant.e * x[0] - plant.g * x[3] * x[3];
        prop_assert!((stored - balance).abs() <= 32.0 * f64::EPSILON * 150.0 * 4.0);
    }

    /// The controller is off its equilibrium value by lambda/2 at most, and not by less than q = 1 makes it.
    #[test]
    fn the_duty_cycle_keeps_its_distance(x in state(), vd in 0.0..100.0f64) {
        let plant = CukConverter::default();
        let distance = plant.control(&x, vd, 0.2) - plant.equilibrium_input(vd);
        prop_assert!(distance.abs() <= 0.1 + 4.0 * f64::EPSILON);
        let q = plant.g * vd * x[1] + plant.e * (x[2] - x[0]);
        prop_assert!((distance - 0.2 * q / (1.0 + q * q)).abs() <= 4.0 * f64::EPSILON);
        prop_assert!(plant.control(&(x * 1e300), vd, 0.2).is_finite());
    }
}

proptest! {
    /// Proposition 5. As printed, (18) makes beta move as phi(xhat) does, and the error of i1, which is that of a
    /// parameter, stays as it is: refuted. With rho = (0, d theta_hat/dt) the I&IO is the [KKL+PEB]O, state by state.
    #[test]
    fn proposition_5_needs_the_rate_of_the_parameter(
        x in state(), xi in vector2(5.0), filters in prop::array::uniform3(-10.0..10.0f64), theta in -3.0..3.0f64, u in duty(),
    ) {
        let (plant, tuning) = (CukConverter::default(), Tuning::<f64>::default());
        let (y, x_rate) = (plant.output(0.0, &x, &u), plant.derivative(0.0, &x, &u));
        // f_m = F[w]/C2 of its own size, and Y = M theta for theta = i1 - xi1, which w solves.
        let m = 0.1 * filters[2] / plant.c2;
        let w = y[0] - (filters[1] + m * (x[0] - xi[0])) / tuning.alpha;
        let chi = Vector6::new(xi[0], xi[1], w, filters[1], m, theta);
        let original = cuk::kkl_pebo(plant, &tuning).unwrap().derivative(0.0, &chi, &u, &y);
        let immersed =
            |embedding| cuk::kkl_pebo_immersed(plant, &tuning, embedding).unwrap().derivative(0.0, &chi, &u, &y);
        // 0.001 M^2 theta~, with M up to 5e4: rates of 1e7.
        let rounding = 16.0 * ROUNDING * (1.0 + m.abs() / 1e4);
        prop_assert!((immersed(Embedding::Equivalent) - original).amax() <= rounding);
        for embedding in [Embedding::Printed, Embedding::Free] {
            let slope = immersed(embedding);
            prop_assert!((slope[0] + slope[5] - x_rate[0]).abs() <= rounding, "{}", slope[0] + slope[5] - x_rate[0]);
        }
    }
}

/// beta without full rank: flagged with the numbers, the lost direction stands still, nothing is NaN.
#[derive(Clone, Copy, Debug)]
struct Degenerate;

impl luenberger_plants::ByDual for Degenerate {}

impl<T: RealField + Copy> Immersion<T> for Degenerate {
    type States = U4;
    type Inputs = U1;
    type Outputs = U2;
    type Manifold = U2;
    type Extension = U2;
    type Estimate = U2;

    // The second row is y2 chi2^2/2: of no rank where y2 or chi2 is 0.
    fn beta(&self, y: &Vector2<T>, chi: &Vector2<T>) -> Vector2<T> {
        Vector2::new(chi[0], y[1] * chi[1] * chi[1] * convert(0.5))
    }
    fn phi(&self, x: &Vector4<T>) -> Vector2<T> {
        Vector2::new(x[0], x[3])
    }
    fn left_inverse(&self, z: &Vector2<T>, y: &Vector2<T>) -> Vector4<T> {
        Vector4::new(z[0], y[0], y[1], z[1])
    }
    fn estimate(&self, xhat: &Vector4<T>) -> Vector2<T> {
        Vector2::new(xhat[0], xhat[3])
    }
    fn start(&self, _estimate: &Vector2<T>, _y: &Vector2<T>) -> Vector2<T> {
        Vector2::repeat(T::one())
    }
}

#[test]
fn a_singular_jacobian_is_flagged() {
    let observer = ImmersionInvarianceObserver::new(CukConverter::default(), Degenerate);
    let (u, y) = (Vector1::new(0.5), Vector2::new(17.0, 2.0));
    assert_eq!(observer.diagnose(0.0, &Vector2::new(0.1, 1.5), &u, &y), Diagnosis::Sound);
    let lost = Vector2::new(0.1, 0.0);
    assert_eq!(
        observer.diagnose(0.0, &lost, &u, &y),
        Diagnosis::RankDeficient { rank: 1, needed: 2, smallest: 0.0, largest: 1.0 }
    );
    let slope: Vector2<f64> = observer.derivative(0.0, &lost, &u, &y);
    assert!(slope[1] == 0.0 && slope[0].is_finite() && slope[0] != 0.0);
}

/// A duty cycle of 1 divides by w = 0 in two of the high-gain observers.
#[test]
fn a_duty_cycle_of_one_is_reported() {
    let (plant, tuning) = (CukConverter::default(), Tuning::<f64>::default());
    let (y, xi) = (Vector2::new(20.0, 1.0), Vector4::new(19.0, 0.5, 0.9, -5.0));
    for observer in [cuk::high_gain_exact(plant, &tuning), cuk::high_gain_differentiator(plant, &tuning)] {
        let observer = observer.unwrap();
        for u in [1.0, 1.5] {
            let u = Vector1::new(u);
            assert!(
                matches!(observer.diagnose(0.0, &xi, &u, &y), Diagnosis::Division { divisor, bound } if divisor <= bound)
            );
            assert!(observer.derivative(0.0, &xi, &u, &y).iter().all(|entry| entry.is_finite()));
            assert!(observer.estimate(0.0, &xi, &u, &y).iter().all(|entry| entry.is_finite()));
        }
        assert_eq!(observer.diagnose(0.0, &xi, &Vector1::new(0.5), &y), Diagnosis::Sound);
    }
}

/// One definition for f32 as well: the right-hand sides of all observers, single beside double precision.
#[test]
fn the_observers_run_in_single_precision() {
    fn rates<T: RealField + Copy>() -> Vec<T> {
        let number = |value: f64| convert::<f64, T>(value);
        let (plant, tuning) = (CukConverter::default(), Tuning::<T>::default());
        let (u, y) = (Vector1::new(number(0.5)), Vector2::new(number(20.0), number(-0.25)));
        let estimate = Vector2::new(number(0.5), number(-8.0));
        let (t, mut all) = (T::zero(), Vec::new());
        let kklo = cuk::kklo(plant).unwrap();
        all.extend(kklo.derivative(t, &kklo.initial(t, &estimate, &u, &y), &u, &y).iter().copied());
        let iio = cuk::immersion_invariance(plant, &tuning).unwrap();
        let chi = Immersion::<T>::start(iio.map(), &estimate, &y);
        all.extend(Immersion::<T>::beta(iio.map(), &y, &chi).iter().copied());
        let pebo = cuk::pebo(plant, &tuning).unwrap();
        all.extend(pebo.derivative(t, &pebo.initial(t, &estimate, &u, &y), &u, &y).iter().copied());
        let both = cuk::kkl_pebo(plant, &tuning).unwrap();
        all.extend(both.derivative(t, &both.initial(t, &estimate, &u, &y), &u, &y).iter().copied());
        let exact = cuk::high_gain_exact(plant, &tuning).unwrap();
        all.extend(exact.derivative(t, &exact.initial(t, &estimate, &u, &y), &u, &y).iter().copied());
        all
    }
    let (single, double) = (rates::<f32>(), rates::<f64>());
    for (single, double) in single.iter().zip(&double) {
        // Terms of up to 20 V/C4 cancel to what is seen.
        assert!((f64::from(*single) - double).abs() <= 16.0 * f64::from(f32::EPSILON) * 1e6, "{single} {double}");
    }
}

proptest! {
    /// The Jacobian of the converter by dual numbers: it is linear in the state, `A(u)`.
    #[test]
    fn the_converter_is_bilinear(x in state(), u in duty()) {
        let (plant, w) = (CukConverter::default(), 1.0 - u[0]);
        let claimed = Matrix4::new(
            0.0, -w / plant.l1, 0.0, 0.0, //
            w / plant.c2, 0.0, u[0] / plant.c2, 0.0, //
            0.0, -u[0] / plant.l3, 0.0, -1.0 / plant.l3, //
            0.0, 0.0, 1.0 / plant.c4, -plant.g / plant.c4,
        );
        let jacobian = state_jacobian(&plant, 0.0, &x, &u);
        // A few operations per entry, of the entry's own size.
        prop_assert!((jacobian - claimed).abs().iter().zip(claimed.abs().iter()).all(|(d, entry)| *d <= 8.0 * f64::EPSILON * entry));
    }
}

/// The converter's KKLO: Lambda = diag(-G/C4, -w/L1) is stable where u < 1 and only there.
#[test]
fn the_converters_kklo_is_proved_where_it_is_stable() {
    let plant = CukConverter::default();
    let observer = cuk::kklo(plant).unwrap();
    let region = |low: f64, high: f64| {
        Region::new(&[(-2.0, 2.0), (0.0, 50.0), (-2.0, 2.0), (-40.0, 0.0)]).inputs(&[(low, high)])
    };
    let candidate = KklCandidate::new(&plant, observer.map(), &[0, 3]).unwrap();
    let report = candidate.check(&region(0.1, 0.9), &KklSettings::default()).unwrap();
    assert!(report.is_proved(), "{report}");
    // A rounding or two of every coefficient: some tens of them against the terms.
    for (bound, scale) in report.residual.bounds.iter().zip(&report.residual.scales) {
        assert!(*bound <= 50.0 * f64::EPSILON * scale, "{bound:e} of {scale:e}");
    }
    assert!(report.left_inverse.as_ref().unwrap().0 < 1e-12);
    let diagonal = report.stability.diagonal.as_ref().unwrap();
    // -G/C4 and -w/L1 with w from 0.1 to 0.9.
    assert!((diagonal[1].hi() + 0.1 / plant.l1).abs() < 1e-9 / plant.l1 && diagonal[0].hi() < 0.0);
    let report = candidate.check(&region(0.5, 1.5), &KklSettings::default()).unwrap();
    assert!(report.residual.verdict.is_proved() && !report.stability.is_proved());
    assert!(report.stability.diagonal.as_ref().unwrap()[1].hi() > 0.0);
    let refused = report.stability.certificate_file("it grows at 1.5");
    assert!(matches!(refused, Err(Rejection::NotProved { .. } | Rejection::Nothing)), "{refused:?}");
    let refused = KklDesign::new(&plant, *observer.map(), &[0, 3], &region(0.5, 1.5), &KklSettings::default());
    assert!(matches!(refused, Err(KklError::HurwitzUndecided { .. } | KklError::NotHurwitz { .. })));
}
