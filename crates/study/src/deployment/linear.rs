//! What is proved of an observer of a linear plant with its numbers as stored, and of its steps as the target computes
//! them.

use luenberger_design::{Certificate, deployed_linear};
use luenberger_proof::certificate::{DeployedObserver, Reading, Theorem, is_useful};
use luenberger_proof::statement::{Deployed, Format, Formats, NoErrorBallReason, Operation, Running, Step};
use luenberger_proof::wording::{at_most, if_at_most, rounded};
use luenberger_sim::Trajectory;
use nalgebra::DMatrix;

use super::feedback::magnitudes;
use super::{Evidence, SampledDesign, proved_line};
use crate::operation::{MARGIN, half_ranges};
use crate::study::{ObserverSpec, Study};
use crate::synthesis::error_bound::no_useful_bound;
use crate::trajectory;

pub(super) fn evidence(
    study: &Study,
    observer: &ObserverSpec,
    design: &SampledDesign,
    certificate: &Certificate,
    formats: Formats,
) -> Evidence {
    let running = formats.running;
    // The subtraction of D u is not among the operations that the certificate bounds.
    let fed = study.plant.model.linear().is_some_and(|plant| plant.d.is_some());
    let operation = operation(study, observer, design).filter(|_| !fed);
    let on_target = match &operation {
        Some(operation) => deployed(design, formats, operation),
        None => None,
    };
    // Disturbances that are estimated are states of this plant.
    let mut states = study.plant.states.clone();
    states.extend(observer.kind.estimated_disturbances());
    // With feedback the range of the loop is not known, but its magnitudes.
    let scales = match (&operation, half_ranges(study)) {
        (Some(operation), none) if none.is_empty() => operation.state.clone(),
        (_, ranges) => ranges,
    };
    let reading = Reading { states: &states, scales: &scales, ..study.plant.reading() };
    let title = &observer.name;
    let proved = |found: &Certificate, of_what: &str| proved_line(of_what, &found.sentences(&reading));
    let not_covered = || format!("Rounding to {running} on the target is not covered.");
    let largest = operation.iter().flat_map(|of| of.state.iter().chain(&of.input)).copied().fold(0.0, f64::max);
    let mut sentences = Vec::new();
    let file = match (on_target, operation) {
        (Some((found, own)), Some(operation)) => own.file(title).ok().inspect(|_| {
            sentences.extend(proved(&own, ""));
            sentences.extend(own.running_sentence(&reading).map(|sentence| sentence.to_string()));
            sentences.extend(without_useful_bound(design, formats, (&operation, &found), &reading));
            if is_fixed(running) && operation.noise.iter().any(|bound| *bound > 0.0) {
                let noiseless = Operation { noise: vec![0.0; operation.noise.len()], ..operation };
                let own = deployed(design, formats, &noiseless).map(|(_, own)| own);
                sentences.extend(own.and_then(|own| Some(own.noiseless_sentence(&reading)?.to_string())));
            }
            sentences.push(rounding(&found, running, largest));
        }),
        // Coarse gains may not stabilise: of them the designed ones say nothing.
        _ if is_fixed(running) => of_stored_numbers(design, formats).and_then(|own| {
            sentences.extend(proved(&own, ""));
            sentences.push(not_covered());
            own.file(title).ok()
        }),
        _ => certificate.file(title).ok().inspect(|_| {
            sentences
                .extend(proved(certificate, ", of the sampled plant, with the gains as designed, in exact arithmetic"));
            sentences.push(not_covered());
        }),
    };
    if design.update_gain(observer).is_some() {
        sentences.push(
            "The estimate is that of the filter form, xhat(k|k) = xhat(k|k-1) + K (y(k) - C xhat(k|k-1)); what is proved is about the error of the prediction xhat(k|k-1)."
                .to_owned(),
        );
    }
    sentences.extend(observer.kind.remark_of_export(study, file.is_some()));
    if file.is_none() {
        sentences.push("No stability certificate.".to_owned());
    } else if fed {
        sentences.push("In the certificate y is the measured output minus D u.".to_owned());
    }
    Evidence { sentences, file }
}

/// Digits of bounds in sentences.
const DIGITS: usize = 3;

fn is_fixed(format: Format) -> bool {
    matches!(format, Format::Fixed { .. })
}

/// The observer in the arithmetic of the target, with its certificate; none if that is not proved.
fn deployed(design: &SampledDesign, formats: Formats, operation: &Operation) -> Option<(Deployed, Certificate)> {
    let (found, certificate) = match design {
        SampledDesign::Linear(design) => {
            let (plant, l) = (design.observer.plant(), design.l());
            let step = if is_fixed(formats.running) { Step::Accumulated } else { Step::Innovation };
            let found = deployed_linear(plant, l, step, formats, operation).ok()?;
            (found.deployed.clone(), found.certificate.clone())
        }
        SampledDesign::Cubic(design) => {
            (design.deployed(formats, operation).ok()?, design.deployed_certificate(formats, operation).ok()?)
        }
        _ => return None,
    };
    certificate.is_proved().then_some((found, certificate))
}

/// The certificate of the stored numbers in exact arithmetic; none if that is not proved.
fn of_stored_numbers(design: &SampledDesign, formats: Formats) -> Option<Certificate> {
    let m = design.matrices()?;
    let (n, m, p) = (m.a.nrows(), m.b.ncols(), m.c.nrows());
    let nothing = Operation {
        state: vec![0.0; n],
        input: vec![0.0; m],
        noise: vec![0.0; p],
        error: vec![0.0; n],
        deviation: None,
    };
    let (_, certificate) = deployed(design, formats, &nothing)?;
    let Theorem::DeployedObserver(theorem) = certificate.theorems().first()?.theorem().clone() else { return None };
    Certificate::of([DeployedObserver { ball: None, ..theorem }]).ok().filter(Certificate::is_proved)
}

/// Which bounds of the error of a deployed observer are not useful, what makes them so large, and what may give better
/// ones: found by the bounds without noise, and without the rounding of the format.
fn without_useful_bound(
    design: &SampledDesign,
    formats: Formats,
    (operation, found): (&Operation, &Deployed),
    reading: &Reading<'_>,
) -> Option<String> {
    let not_useful = |found: &Deployed| -> Option<Vec<&str>> {
        let Running::Within(ball) = &found.running else { return None };
        let pairs = reading.states.iter().zip(ball.entries.iter().zip(reading.scales));
        Some(pairs.filter(|(_, (bound, scale))| !is_useful(**bound, **scale)).map(|(name, _)| name.as_str()).collect())
    };
    let names = not_useful(found).filter(|names| !names.is_empty())?;
    let quiet = Operation { noise: vec![0.0; operation.noise.len()], ..operation.clone() };
    let exact = Operation { deviation: None, ..operation.clone() };
    let helps = |formats, operation: &Operation| {
        let found = deployed(design, formats, operation);
        found.and_then(|(found, _)| not_useful(&found)).is_some_and(|names| names.is_empty())
    };
    let (running, wide) = (formats.running, Formats::from(Format::Binary64));
    let bits = if is_fixed(running) { "a format with more bits after the point" } else { "--format f64" };
    let slower = "a slower gain, which amplifies the noise less";
    let (reason, remedy) = if helps(formats, &quiet) {
        ("the measurement noise, at its bound in every sample".to_owned(), slower.to_owned())
    } else if running != Format::Binary64 && helps(wide, operation) {
        (format!("the rounding to {running}"), bits.to_owned())
    } else if operation.deviation.is_some() && helps(formats, &exact) {
        ("the deviations of A within `bounds`".to_owned(), "smaller `deviations`".to_owned())
    } else if running != Format::Binary64 && helps(wide, &quiet) {
        (format!("the measurement noise and the rounding to {running}"), format!("{slower}, and {bits}"))
    } else if operation.deviation.is_some() && helps(wide, &Operation { deviation: None, ..quiet }) {
        (
            "noise, rounding and the deviations of A within `bounds` together".to_owned(),
            format!("smaller `deviations`, {slower}, and {bits}"),
        )
    } else {
        (
            "the decrease of V in a step, which is so small that noise and rounding add up over many of them"
                .to_owned(),
            "faster poles, poles that are nearer to each other, or a longer period".to_owned(),
        )
    };
    Some(format!("{} It comes from {reason}. What may give one: {remedy}.", no_useful_bound(&names)))
}

/// The format with the bits before the point that a number of this size needs, and those after it that then have room.
fn roomier(format: Format, (size, limit): (f64, f64)) -> Option<Format> {
    let Format::Fixed { integer_bits, fraction_bits } = format else { return None };
    let missing = (size / limit).log2().ceil().max(1.0);
    let integer_bits = integer_bits + (missing <= 32.0).then_some(missing as u32)?;
    let left = 32_u32.checked_sub(integer_bits)?;
    Some(Format::Fixed { integer_bits, fraction_bits: fraction_bits.min(left) })
}

/// What is to be said beside the bound of the error with all rounding counted; `largest` is the largest state or input.
fn rounding(deployed: &Deployed, format: Format, largest: f64) -> String {
    match &deployed.running {
        Running::Within(_) => {
            "The bounds are 1.2 times the magnitudes in the study's simulation, rounded up, with four standard deviations for Gaussian noise."
                .to_owned()
        }
        Running::Unproved(why) if is_fixed(format) => {
            let remedy = match why {
                NoErrorBallReason::Range { size, limit, .. } => match roomier(format, (size.max(largest), *limit)) {
                    Some(roomier) => format!("; {roomier} has the bits before the point"),
                    None => "; no format of 32 bits has so many before the point: scale the signals".to_owned(),
                },
                NoErrorBallReason::RoundingDominates { .. } => "; more bits after the point may help".to_owned(),
                _ => String::new(),
            };
            format!("Rounding to {format} on the target: no bound is proved, and saturation is not excluded ({why}{remedy}).")
        }
        Running::Unproved(_) => format!("Rounding to {format} on the target: no bound is proved."),
    }
}

/// The bounds of the study's simulation; none without a simulation, with feedback of another observer, or if the plant
/// cannot be simulated.
fn operation(study: &Study, observer: &ObserverSpec, design: &SampledDesign) -> Option<Operation> {
    let simulation = study.simulation.as_ref()?;
    let (state, input) = if let Some(found) = magnitudes(study, simulation, observer, design) {
        found
    } else {
        let run: Trajectory = trajectory::of_plant(study, simulation)?;
        let largest = |m: &DMatrix<f64>| m.column_iter().map(|column| MARGIN * column.amax()).collect();
        (largest(&run.x), largest(&run.u))
    };
    let noise = (0..study.plant.outputs.len()).map(|output| {
        let noise = simulation.noise_of(output);
        noise.map_or(0.0, |noise| MARGIN * if noise.gaussian { 4.0 } else { 1.0 } * noise.amplitude)
    });
    let noise = noise.collect();
    // The plant of the study may be uncertain: then its states are bounded by what it says of them as well.
    let uncertain = observer.bounds.as_ref().and_then(|bounds| bounds.uncertain.as_ref());
    let deviation = match (uncertain, study.plant.model.linear(), design.matrices()) {
        (Some((_, uncertainty)), Some(plant), Some(m)) => Some(uncertainty.sampled(plant, m.period).ok()?),
        _ => None,
    };
    let state = match uncertain {
        Some((bounds, _)) => state.iter().zip(bounds).map(|(run, bound): (&f64, &f64)| run.max(*bound)).collect(),
        None => state,
    };
    let error = simulation.x0.iter().zip(&observer.initial).map(|(x, xhat)| MARGIN * (x - xhat).abs()).collect();
    let [state, input, noise, error] = [state, input, noise, error].map(|bounds: Vec<f64>| {
        let decimals = bounds.into_iter().map(decimal_bound);
        decimals.collect()
    });
    Some(Operation { state, input, noise, error, deviation })
}

/// The least bound from `x` on, up to the rounding of x, that is written with [`DIGITS`] digits: the certificate is for
/// the decimal that is printed, or the number of binary64 above it.
fn decimal_bound(x: f64) -> f64 {
    let near = rounded(x, DIGITS);
    let is_above = near >= x * (1.0 - 4.0 * f64::EPSILON);
    let decimal = if is_above { near } else { at_most(x, DIGITS).parse().unwrap_or(x) };
    if if_at_most(decimal, DIGITS).parse() == Ok(decimal) { decimal } else { decimal.next_up() }
}
