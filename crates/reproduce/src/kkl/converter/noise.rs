//! Monte Carlo runs with measurement noise: ranking of the observers, and its dependence on their gains.

use std::sync::Arc;

use crate::kkl::cuk::{self, Tuning};
use luenberger_plants::CukConverter;
use luenberger_sim::{Integrator, Purpose, Settings, Trajectory};

use super::runs::{self, OBSERVERS};
use crate::claim::CheckError;
use crate::context::Context;
use crate::threads;

/// The seeds are 1, 2, ..., and the run with the first is the one in the figures.
pub(super) const SEEDS: u64 = 20;
/// The transients of the start are over after two set-points: the slowest is that of the time-varying high-gain
/// observer, exp(-20 t).
pub(super) const SETTLED: f64 = 0.4;
/// For how long a value of the noise is held, in s.
const PERIOD: f64 = 1e-4;

/// Errors of integration stay a thousand times below the effect of the noise, 1e-3 A and 1e-2 V.
pub(super) fn settings() -> Settings {
    Settings { integrator: Integrator::Explicit, rtol: 1e-7, atol: 1e-7, ..Settings::default() }
}

/// The run with the seven observers and noise from this seed.
fn run(seed: u64, times: &[f64]) -> Result<Trajectory, CheckError> {
    let noise = runs::noise(seed);
    let scenario = runs::with_all(runs::converter(), Some(&noise))?;
    Ok(scenario.noise(noise).settings(settings()).times(times).run()?)
}

/// When the noise takes a new value, to the end of the six set-points that the figures show.
pub(super) fn holds() -> Vec<f64> {
    (0..=12_000).map(|k| f64::from(k) / 10_000.0).collect()
}

/// The root mean squares of the errors in i1 and v4, of one observer in one run.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct RmsErrors {
    /// From [`SETTLED`] on, with the jumps of the set-point at 0.4, 0.6, 0.8 and 1 s.
    pub(super) switching: [f64; 2],
    /// In the second half of each set-point from there on.
    pub(super) quiet: [f64; 2],
}

impl RmsErrors {
    pub(super) fn of(run: &Trajectory, observer: &str) -> Result<Self, CheckError> {
        let error = &run.observer(observer)?.error;
        let mean = |entry: usize, counts: &dyn Fn(f64) -> bool| {
            let squares = run.t.iter().enumerate().filter(|(_, t)| counts(**t)).map(|(k, _)| error[(k, entry)].powi(2));
            let (sum, count) = squares.fold((0.0, 0.0), |(sum, count), square| (sum + square, count + 1.0));
            f64::sqrt(sum / count)
        };
        let settled = |t: f64| t >= SETTLED;
        // In periods of the noise, whose multiples are whole numbers: 0.6 is less than three times 0.2 in binary.
        let periods = |t: f64| (t / PERIOD).round() as u32;
        let quiet = |t: f64| settled(t) && periods(t) % periods(runs::DWELL) >= periods(runs::DWELL) / 2;
        Ok(Self { switching: [mean(0, &settled), mean(1, &settled)], quiet: [mean(0, &quiet), mean(1, &quiet)] })
    }
}

/// One row for each seed, one entry for each observer.
pub(super) type Ensemble = Vec<[RmsErrors; OBSERVERS.len()]>;

/// The spreads of all seeds, each a run of its own.
pub(super) fn ensemble(context: &Context) -> Result<Arc<Ensemble>, CheckError> {
    context.once("kkl.cuk.ensemble", || threads::map(SEEDS as usize, |k| one(k as u64 + 1)).into_iter().collect())
}

fn one(seed: u64) -> Result<[RmsErrors; OBSERVERS.len()], CheckError> {
    let run = run(seed, &holds())?;
    let mut spreads = [RmsErrors { switching: [0.0; 2], quiet: [0.0; 2] }; OBSERVERS.len()];
    for (spread, (name, _)) in spreads.iter_mut().zip(OBSERVERS) {
        *spread = RmsErrors::of(&run, name)?;
    }
    Ok(spreads)
}

/// The run with noise of the figures.
pub(super) fn shown(context: &Context) -> Result<Arc<Trajectory>, CheckError> {
    context.once("kkl.cuk.noise", || run(1, &runs::milliseconds()))
}

/// The gains g1 of the sweep: 12 from 10 to 10000, equally spaced on a logarithmic scale.
pub(super) fn gains() -> [f64; 12] {
    std::array::from_fn(|k| 10.0 * 1000f64.powf(k as f64 / 11.0))
}

/// The root mean square of the error of i1 from [`SETTLED`] on for each gain, then for the KKLO, which has the gain
/// 1/L1; one row for each of the seeds 1 to [`SWEEP_SEEDS`].
///
/// With noise n on y that is held, and `eta = chi1 + C2 g1 y1 - i1`, (i1hat - i1) = eta + C2 g1 n1 and
/// `eta' = -g1 w eta - w (C2 g1^2 + 1/L1) n1 - g1 u n2`: the plant does not see the noise, so that one run of it serves
/// all seeds and gains. Each period is integrated with the u in its middle. The first seed is compared with the
/// simulated observers.
pub(super) fn sweep(context: &Context) -> Result<Arc<Vec<Vec<f64>>>, CheckError> {
    context.once("kkl.cuk.sweep", || {
        let middles: Vec<f64> = (0..12_000).map(|k| (f64::from(k) + 0.5) * PERIOD).collect();
        let times: Vec<f64> = std::iter::once(0.0).chain(middles).collect();
        let run = runs::converter().settings(settings()).times(&times).run()?;
        let duty: Vec<f64> = run.u.column(0).iter().skip(1).copied().collect();
        let start = [run.x[(0, 1)], run.x[(0, 0)]];
        let rows: Vec<Vec<f64>> = (1..=SWEEP_SEEDS).map(|seed| sweep_once(seed, &duty, start)).collect();
        let simulated = ensemble(context)?;
        let kklo = simulated[0][0].switching[0];
        let found = rows[0][gains().len()];
        if (found / kklo - 1.0).abs() > 0.01 {
            return Err(
                format!("the reduced equation gives {found} A for the KKLO, and its simulation {kklo} A").into()
            );
        }
        Ok(rows)
    })
}

/// Over how many seeds the sweep of the gain is taken.
pub(super) const SWEEP_SEEDS: u64 = 60;

fn sweep_once(seed: u64, duty: &[f64], [y1, i1]: [f64; 2]) -> Vec<f64> {
    let (CukConverter { l1, c2, .. }, noise) = (CukConverter::default(), runs::noise(seed));
    let held: Vec<Vec<f64>> = (0..duty.len()).map(|k| noise.sample(Purpose::MeasurementNoise, k as u64)).collect();
    let of = |g1: f64| {
        let (mut eta, mut sum, mut count) = (c2 * g1 * y1 - i1, 0.0, 0.0);
        for (k, (u, n)) in duty.iter().zip(&held).enumerate() {
            if k as f64 * PERIOD >= SETTLED - 0.5 * PERIOD {
                sum += (eta + c2 * g1 * n[0]).powi(2);
                count += 1.0;
            }
            let w = 1.0 - u;
            let rest = -(w * (c2 * g1 * g1 + 1.0 / l1) * n[0] + g1 * u * n[1]) / (g1 * w);
            eta = rest + (eta - rest) * (-g1 * w * PERIOD).exp();
        }
        f64::sqrt(sum / count)
    };
    gains().into_iter().chain([1.0 / l1]).map(of).collect()
}

/// The largest difference between the estimates of the KKLO and of the I&IO with `g1 = 1/L1`, `g2 = 0`, in i1 and in
/// v4, over a run with noise.
pub(super) fn kklo_less_iandi() -> Result<[f64; 2], CheckError> {
    let (plant, noise) = (CukConverter::default(), runs::noise(1));
    let tuning = Tuning { g1: 1.0 / plant.l1, g2: 0.0, ..Tuning::default() };
    let scenario = runs::with(runs::converter(), "kklo", cuk::kklo(plant)?, Some(&noise));
    // Both start from the same estimate.
    let start = runs::estimate_at_rest(&cuk::kklo(plant)?, Some(&noise));
    let scenario = scenario.partial_observer(
        "iandi",
        cuk::immersion_invariance(plant, &tuning)?,
        start.as_slice(),
        &runs::ESTIMATED,
    );
    let run = scenario.noise(noise).tolerances(1e-11, 1e-12).integrator(Integrator::Explicit).until(0.4, 401).run()?;
    let difference = &run.observer("kklo")?.estimate - &run.observer("iandi")?.estimate;
    Ok([difference.column(0).amax(), difference.column(1).amax()])
}
