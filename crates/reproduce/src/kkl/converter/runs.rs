//! The run of section V.C: the converter with the ideal state feedback, and its observers in open loop.
//!
//! All observers share one integration of the plant. Their dynamic extensions start at 0, except the filters W, which
//! start at the output; the initial estimate follows from this state.

use std::sync::Arc;

use crate::kkl::cuk::{self, Tuning};
use luenberger_observers::Observer;
use luenberger_plants::{Column, CukConverter, Plant};
use luenberger_sim::{Integrator, Noise, Purpose, Scenario, Settings, Signal, Trajectory};
use nalgebra::{Vector1, Vector2, Vector4};

use super::printed;
use crate::claim::CheckError;
use crate::context::Context;

/// |Vd|, in V, on successive intervals of [`DWELL`].
pub(super) const SET_POINTS: [f64; 6] = [15.0, 25.0, 10.0, 20.0, 10.0, 15.0];
/// For how long a set-point is kept, in s.
pub(super) const DWELL: f64 = 0.2;
/// The set-point in whose equilibrium the converter starts, in V.
const START: f64 = 5.0;
pub(super) const LAMBDA: f64 = 0.2;
/// Which states of the plant are estimated: i1 and v4.
pub(super) const ESTIMATED: [usize; 2] = [0, 3];

/// The observers of Table I in its order, then the exact high-gain observer: name in the data, name in the figures.
pub const OBSERVERS: [(&str, &str); 7] = [
    ("kklo", "KKLO"),
    ("pebo", "PEBO"),
    ("kkl_peb", "[KKL+PEB]O"),
    ("iandi", "I&IO"),
    ("hgo_varying", "HGO, time-varying"),
    ("hgo_linear", "HGO, linear"),
    ("hgo_exact", "HGO, exact"),
];
/// How many of them are the paper's.
pub(super) const PRINTED: usize = 6;

/// Details of the run that the paper does not specify.
pub(super) const RUN: &[&str] = &[
    "L3 = 10 mH, λ = 0.2",
    "|Vd| = 15, 25, 10, 20, 10, 15 V for 0.2 s each, from the equilibrium for 5 V",
    "dynamic extensions from 0, filters W from y(0)",
];

/// The set-point at the time `t`.
pub(super) fn set_point(t: f64) -> f64 {
    SET_POINTS[((t / DWELL) as usize).min(SET_POINTS.len() - 1)]
}

/// When the set-point jumps.
pub(super) fn jumps() -> [f64; 5] {
    // Decimals, so that a sample asked for at 0.6 s is one at the jump.
    [0.2, 0.4, 0.6, 0.8, 1.0]
}

/// Every millisecond of the horizon, as the nearest double of the decimal.
pub(super) fn milliseconds() -> Vec<f64> {
    (0..=1200).map(|k| f64::from(k) / 1000.0).collect()
}

/// The converter and its controller, without observers.
pub fn converter() -> Scenario<'static> {
    let plant = CukConverter::default();
    Scenario::new(plant)
        .initial_state(plant.equilibrium(START).as_slice())
        .input(Signal::law(move |view, u| {
            u[0] = plant.control(&Vector4::from_column_slice(view.x), set_point(view.t), LAMBDA);
        }))
        .breakpoints(&jumps())
}

/// The converter whose controller has the estimates of one observer, named "loop", in the place of i1 and v4.
pub(super) fn output_feedback(observer: impl CukObserver + Send + Sync + 'static) -> Result<Trajectory, CheckError> {
    let plant = CukConverter::default();
    let law = Signal::law(move |view, u| {
        let estimated = view.estimate("loop").map_or([f64::NAN; 2], |estimate| [estimate[0], estimate[1]]);
        let x = Vector4::new(estimated[0], view.y[0], view.y[1], estimated[1]);
        u[0] = plant.control(&x, set_point(view.t), LAMBDA);
    });
    Ok(with(converter().input(law), "loop", observer, None).tolerances(1e-9, 1e-10).times(&milliseconds()).run()?)
}

/// The noise of section V.C.
pub fn noise(seed: u64) -> Noise {
    Noise::uniform(&[0.02, 2e-4], 1e-4, seed)
}

/// Type of an observer of the converter.
pub(super) trait CukObserver:
    Observer<f64, Input = Vector1<f64>, Output = Vector2<f64>, Estimate = Vector2<f64>>
{
}

impl<O: Observer<f64, Input = Vector1<f64>, Output = Vector2<f64>, Estimate = Vector2<f64>>> CukObserver for O {}

/// The same scenario with one more observer, from rest; `noise` is that of the scenario.
pub(super) fn with<'a>(
    scenario: Scenario<'a>,
    name: &str,
    observer: impl CukObserver + Send + Sync + 'a,
    noise: Option<&Noise>,
) -> Scenario<'a> {
    let estimate = estimate_at_rest(&observer, noise);
    scenario.partial_observer(name, observer, estimate.as_slice(), &ESTIMATED)
}

/// The initial estimate of the observer when its state is 0.
pub(super) fn estimate_at_rest(observer: &(impl CukObserver + Sync), noise: Option<&Noise>) -> Vector2<f64> {
    let plant = CukConverter::default();
    let x = plant.equilibrium(START);
    let u = Vector1::new(plant.control(&x, set_point(0.0), LAMBDA));
    let seen = plant.output(0.0, &x, &u)
        + noise.map_or_else(Vector2::zeros, |n| Vector2::from_column_slice(&n.sample(Purpose::MeasurementNoise, 0)));
    observer.estimate(0.0, &rest(observer), &u, &seen)
}

/// The state 0.
fn rest<O: CukObserver>(observer: &O) -> O::State {
    O::State::from_slice(&vec![0.0; observer.dimensions().state])
}

/// The same scenario with the seven observers; `noise` is that of the scenario.
/// # Errors
/// Those of the observers' constructors; there are none for these numbers.
pub fn with_all(mut scenario: Scenario<'static>, noise: Option<&Noise>) -> Result<Scenario<'static>, CheckError> {
    let (plant, tuning, zero) = (CukConverter::default(), Tuning::default(), Vector4::zeros());
    let mut names = OBSERVERS.iter().map(|(name, _)| *name);
    let mut name = || names.next().unwrap_or_default();
    scenario = with(scenario, name(), cuk::kklo(plant)?, noise);
    scenario = with(scenario, name(), cuk::pebo(plant, &tuning)?, noise);
    scenario = with(scenario, name(), cuk::kkl_pebo(plant, &tuning)?, noise);
    scenario = with(scenario, name(), cuk::immersion_invariance(plant, &tuning)?, noise);
    for high_gain in [cuk::high_gain_time_varying, cuk::high_gain_differentiator, cuk::high_gain_exact] {
        scenario = with(scenario, name(), high_gain(plant, &tuning)?.starting_at(zero)?, noise);
    }
    Ok(scenario)
}

/// How the noise-free run is integrated. Explicit, and stopped at every millisecond: the samples are then values of
/// steps, not of the polynomials between them.
pub fn settings() -> Settings {
    Settings { integrator: Integrator::Explicit, rtol: 1e-12, atol: 1e-13, ..Settings::default() }
}

/// The noise-free run, sampled at every millisecond.
/// # Errors
/// Where the integrator does not reach the end with these settings.
pub fn noise_free(settings: Settings) -> Result<Trajectory, CheckError> {
    let times = milliseconds();
    Ok(with_all(converter(), None)?.breakpoints(&times[1..]).settings(settings).times(&times).run()?)
}

/// The noise-free run, once.
pub(super) fn corrected(context: &Context) -> Result<Arc<Trajectory>, CheckError> {
    context.once("kkl.cuk.corrected", || noise_free(settings()))
}

/// The observers as Table I prints them, without noise: the PEBO, and the others. The printed PEBO has an eigenvalue of
/// Γ2/L3² = 10⁶/s from the start, which an implicit method takes in its stride; the others have none.
pub(super) fn as_printed(context: &Context) -> Result<Arc<(Trajectory, Trajectory)>, CheckError> {
    context.once("kkl.cuk.as-printed", || {
        let (plant, tuning) = (CukConverter::default(), Tuning::default());
        let stiff = with(converter(), "pebo", printed::Pebo::new(plant, tuning), None);
        let mut others = with(converter(), "kklo", cuk::kklo(plant)?, None);
        others = with(others, "kkl_peb", printed::KklPeb::new(plant, tuning), None);
        others = with(others, "iandi", printed::ImmersionInvariance::new(plant, tuning), None);
        others = with(others, "hgo_varying", printed::HighGain::time_varying(plant, tuning), None);
        others = with(others, "hgo_linear", printed::HighGain::linear(plant, tuning), None);
        let stiff = stiff.integrator(Integrator::Implicit).tolerances(1e-8, 1e-9).times(&milliseconds()).run()?;
        let others = others.integrator(Integrator::Explicit).tolerances(1e-10, 1e-11).times(&milliseconds()).run()?;
        Ok((stiff, others))
    })
}
