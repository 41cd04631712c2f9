//! Warnings that qualify the results.

use luenberger_design::{KalmanNoise, recovery_obstacle};
use luenberger_proof::wording::{shortest, significant};

use crate::results::eigenvalue;
use crate::results::{DesignReport, Quantity, Results};
use crate::signal::Input;
use crate::study::{GainSpec, ObserverSpec, Simulation, Study};

/// Modes with a margin below this are weakly observable.
const HARDLY: f64 = 1e-6;

pub(super) fn of_designs(study: &Study, results: &Results) -> Vec<String> {
    let mut warnings = Vec::new();
    for point in results.observability.iter().flat_map(|report| &report.points) {
        // The modes with the smallest margins are those that are unobservable, of which another sentence speaks.
        let mut modes: Vec<_> = point.modes.iter().collect();
        modes.sort_by(|x, y| x.margin.total_cmp(&y.margin));
        for mode in modes.into_iter().skip(point.hidden.len()).filter(|mode| mode.margin < HARDLY) {
            warnings.push(format!(
                "weakly observable mode {} along {}: margin {}; a small change of the plant makes it unobservable",
                eigenvalue(mode.eigenvalue),
                mode.words,
                significant(mode.margin, 2)
            ));
        }
    }
    // Modes that are the same to the digits printed.
    warnings.dedup();
    for observer in &results.observers {
        let Some(design) = &observer.design else { continue };
        warnings.extend(amplification(study, &observer.name, design));
    }
    warnings.extend(unrecovered(study));
    warnings.extend(study.simulation.iter().flat_map(|simulation| unused(study, simulation)));
    warnings.extend(study.simulation.iter().flat_map(|simulation| other_noise(study, simulation)));
    warnings.extend(study.simulation.iter().flat_map(|simulation| beyond_bounds(study, simulation)));
    let driven = !matches!(study.input, Input::Zero);
    if let (Some(simulation), true) = (&study.simulation, driven) {
        for requested in &study.observers {
            let Some(period) = requested.kind.fixed_period() else { continue };
            if simulation.hold != Some(period) {
                let hold = simulation.hold.map_or_else(|| "not set".to_owned(), |hold| hold.to_string());
                let name = &requested.name;
                warnings.push(format!(
                    "{name} assumes a zero-order hold of the input: set simulation.hold = {period} (it is {hold})"
                ));
            }
        }
    }
    warnings
}

/// By which factor V of a stationary Kalman filter may differ from the noise of the simulation without a word.
const DIFFERENT: f64 = 3.0;

/// Stationary Kalman filters whose V is not that of the noise in the simulation: in continuous time an intensity, the
/// variance of a value that is held for a period, times that period.
fn other_noise(study: &Study, simulation: &Simulation) -> Vec<String> {
    let mut warnings = Vec::new();
    for requested in &study.observers {
        let Some(GainSpec::Kalman(KalmanNoise { v, .. })) = requested.kind.whole_gain().map(|spec| &spec.gain) else {
            continue;
        };
        for (output, name) in study.plant.outputs.iter().enumerate() {
            let Some(noise) = simulation.noise_of(output) else { continue };
            let (variance, given) = (noise.variance(), v[(output, output)]);
            let (expected, what, how) = if study.plant.dt.is_some() {
                (variance, "variance", String::new())
            } else {
                let how = format!(", variance times period: {} x {}", significant(variance, 3), shortest(noise.period));
                (variance * noise.period, "intensity", how)
            };
            if expected > 0.0 && !(1.0 / DIFFERENT..=DIFFERENT).contains(&(given / expected)) {
                warnings.push(format!(
                    "{}: v of {name} is {}, and the noise of the simulation has the {what} {}{how}",
                    requested.name,
                    significant(given, 3),
                    significant(expected, 3)
                ));
            }
        }
    }
    warnings
}

/// Observers with `bounds` that the noise or the first error of the simulation does not keep: what is proved of their
/// errors then says nothing of this simulation, even where every sample of it is within the bounds.
fn beyond_bounds(study: &Study, simulation: &Simulation) -> Vec<String> {
    let mut warnings = Vec::new();
    for requested in &study.observers {
        let Some(bounds) = &requested.bounds else { continue };
        for (output, (name, bound)) in study.plant.outputs.iter().zip(&bounds.noise).enumerate() {
            let found = match simulation.noise_of(output) {
                Some(noise) if noise.gaussian => "is Gaussian, which has no bound".to_owned(),
                Some(noise) if noise.amplitude > *bound => format!("is up to {}", shortest(noise.amplitude)),
                _ => continue,
            };
            warnings.push(format!(
                "{}: its bounds are proved for noise of {name} of at most {}, and the noise of the simulation {found}: they \
                 are not proved of this simulation",
                requested.name,
                shortest(*bound)
            ));
        }
        let Some(first) = requested.kind.first_bounds() else { continue };
        let errors = simulation.x0.iter().zip(&requested.initial).map(|(x, xhat)| (x - xhat).abs());
        for ((name, error), bound) in study.plant.states.iter().zip(errors).zip(first) {
            // By more than the rounding of the difference.
            if error > *bound * (1.0 + 4.0 * f64::EPSILON) {
                warnings.push(format!(
                    "{}: its bounds are proved for a first error of {name} of at most {}, and that of the simulation is \
                     {}: they are not proved of this simulation",
                    requested.name,
                    shortest(*bound),
                    significant(error, 4)
                ));
            }
        }
    }
    warnings
}

/// Kalman filters with `recovery` of plants of which the loop is not recovered.
fn unrecovered(study: &Study) -> Vec<String> {
    let point = study.operating_point.as_ref().map(|point| &point.linear);
    let Some(plant) = study.plant.model.linear().or(point) else { return Vec::new() };
    let recovers = |requested: &&ObserverSpec| {
        let gain = requested.kind.whole_gain().map(|spec| &spec.gain);
        matches!(gain, Some(GainSpec::Kalman(noise)) if noise.recovery > 0.0)
    };
    let Ok(Some(obstacle)) = recovery_obstacle(plant) else { return Vec::new() };
    let warning = |requested: &ObserverSpec| {
        format!("{}: `recovery` does not bring the loop to that of state feedback: {obstacle}", requested.name)
    };
    study.observers.iter().filter(recovers).map(warning).collect()
}

/// Measurements that lie between the samples of an observer.
fn unused(study: &Study, simulation: &Simulation) -> Vec<String> {
    let mut warnings = Vec::new();
    let unit = study.plant.time_unit.as_ref().map(|unit| format!(" {unit}")).unwrap_or_default();
    for (requested, period) in study
        .observers
        .iter()
        .filter_map(|requested| Some((requested, requested.kind.fixed_period().or(study.plant.dt)?)))
    {
        for sensor in &simulation.sensors {
            let (used, all) = sensor.sensor(1.0).on_samples(period, simulation.duration);
            if used < all {
                warnings.push(format!(
                    "{}: Only {used} of {all} measurements of {} (every {}{unit}) lie on the observer's samples (every {period}{unit}); the others are not used",
                    requested.name, study.plant.outputs[sensor.output], sensor.period
                ));
            }
        }
    }
    warnings
}

/// A verified transient beyond this factor is of no use.
const OVERSHOOT: f64 = 100.0;

/// Poles beyond this multiple of the plant's fastest mode are seldom intended.
const SPEED: f64 = 1e3;

/// Gains that are verified and of no use: an overshoot bound that says nothing, poles far beyond the plant, and noise
/// that leaves a larger error than the first one.
fn amplification(study: &Study, name: &str, design: &DesignReport) -> Vec<String> {
    const REMEDY: &str = "set `max_gain` or `noise`, or choose a smaller rate";
    let mut warnings = Vec::new();
    if let Some(overshoot) = design.quantity(Quantity::Overshoot).filter(|overshoot| *overshoot > OVERSHOOT) {
        warnings.push(format!(
            "{name}: overshoot bound {}: the error may grow to this multiple of its initial value before it decays; {REMEDY}",
            significant(overshoot, 4)
        ));
    }
    if let Some(ratio) = design.quantity(Quantity::SpeedRatio).filter(|ratio| *ratio > SPEED) {
        warnings.push(format!(
            "{name}: its fastest pole is {} times as fast as the plant's fastest mode (norm of L {}): it amplifies measurement noise and unmodelled dynamics; {REMEDY}",
            significant(ratio, 2),
            significant(design.quantity(Quantity::GainNorm).unwrap_or(f64::NAN), 3)
        ));
    }
    let (Some(simulation), Some(observer)) = (&study.simulation, study.observer(name)) else { return warnings };
    let first = simulation.x0.iter().zip(&observer.initial).map(|(x, xhat)| (x - xhat).abs());
    let worst = design
        .noise_deviation
        .iter()
        .zip(first)
        .enumerate()
        .filter(|(_, (deviation, first))| *first > 0.0 && *deviation > first);
    if let Some((i, (deviation, first))) = worst.max_by(|x, y| (x.1.0 / x.1.1).total_cmp(&(y.1.0 / y.1.1))) {
        warnings.push(format!(
            "{name}: the measurement noise alone leaves an error of standard deviation {} in {}, more than the initial error {}; {REMEDY}",
            significant(*deviation, 3),
            study.plant.states[i],
            significant(first, 3)
        ));
    }
    warnings
}
