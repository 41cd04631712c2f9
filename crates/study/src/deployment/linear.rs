//! What is proved of an observer of a linear plant with its numbers as stored, and of its steps as the target computes
//! them.

use luenberger_design::{Certificate, NormTarget, deployed_linear};
use luenberger_proof::certificate::{CertificateFile, DeployedObserver, Theorem};
use luenberger_proof::statement::{Deployed, Format, Formats, Operation, Running, Step};
use luenberger_proof::wording::{at_most, if_at_most, rounded};
use luenberger_sim::Trajectory;
use nalgebra::DMatrix;

use super::feedback::magnitudes;
use super::{Evidence, SampledDesign, stored};
use crate::model::PlantModel;
use crate::operation::MARGIN;
use crate::study::{ObserverKind, ObserverSpec, Study};
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
        Some(operation) => deployed(&observer.name, design, formats, operation),
        None => None,
    };
    let mut sentences = Vec::new();
    // The forcing of a plant whose matrices are rounded keeps its error from 0.
    let is_rounded =
        design.matrices().is_none_or(|m| [m.a, m.b, m.c].iter().any(|m| stored(m, formats.stored).as_ref() != Some(m)));
    let of_stored = format!(
        "Proved (certificate.json): with the gains as stored in {0}, in exact arithmetic, the estimation error of a plant x+ = A x + B u, y = C x with the stored A, B and C tends to 0 exponentially from every initial error.{1}",
        formats.stored,
        if is_rounded {
            format!(" {} rounds those of the sampled plant: its own error need not tend to 0.", formats.stored)
        } else {
            " They are those of the sampled plant.".to_owned()
        }
    );
    let not_covered = || format!("Rounding to {running} on the target is not covered.");
    let file = match (on_target, operation) {
        (Some((found, file)), Some(operation)) => {
            sentences.push(of_stored);
            sentences.extend(rounding(study, &found, &operation, running));
            if is_fixed(running) && operation.noise.iter().any(|bound| *bound > 0.0) {
                let noiseless = Operation { noise: vec![0.0; operation.noise.len()], ..operation };
                sentences.extend(
                    deployed(&observer.name, design, formats, &noiseless)
                        .and_then(|(found, _)| found.ball().map(|ball| without_noise(study, &ball.entries))),
                );
            }
            Some(file)
        }
        // Coarse gains may not stabilise: of them the designed ones say nothing.
        _ if is_fixed(running) => of_stored_numbers(&observer.name, design, formats).inspect(|_| {
            sentences.push(of_stored);
            sentences.push(not_covered());
        }),
        _ => certificate.file(&observer.name).ok().inspect(|_| {
            sentences.push(
                "Proved (certificate.json): with the gains as designed, in exact arithmetic, the estimation error of the sampled plant x+ = A x + B u, y = C x tends to 0 exponentially from every initial error."
                    .to_owned(),
            );
            sentences.push(not_covered());
        }),
    };
    if design.update_gain(observer).is_some() {
        sentences.push(
            "The estimate is that of the filter form, xhat(k|k) = xhat(k|k-1) + K (y(k) - C xhat(k|k-1)); what is proved is about the error of the prediction xhat(k|k-1)."
                .to_owned(),
        );
    }
    if let ObserverKind::NormFilter(spec) = &observer.kind
        && study.plant.dt.is_none()
        && !matches!(spec.goal, NormTarget::OfGain(_))
    {
        sentences.push(format!(
            "The gain is that of the {} filter of the sampled plant, disturbances and noise held over the period. The bound of the norm is not in the certificate.",
            spec.norm.name()
        ));
    }
    if let (ObserverKind::ProportionalIntegral { chain, .. }, true) = (&observer.kind, file.is_some()) {
        let rate = match chain.unwrap_or(1) {
            1 => "constant disturbances".to_owned(),
            chain => format!("disturbances whose derivative of order {chain} is 0"),
        };
        sentences.push(format!("The plant of the certificate is that of the study with {rate} among its states."));
    }
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

/// The observer in the arithmetic of the target, with its certificate file; none if that is not proved.
fn deployed(
    title: &str,
    design: &SampledDesign,
    formats: Formats,
    operation: &Operation,
) -> Option<(Deployed, CertificateFile)> {
    match design {
        SampledDesign::Linear(design) => {
            let (plant, l) = (design.observer.plant(), design.l());
            let step = if is_fixed(formats.running) { Step::Accumulated } else { Step::Innovation };
            let found = deployed_linear(plant, l, step, formats, operation).ok()?;
            let file = found.certificate.file(title).ok()?;
            Some((found.deployed.clone(), file))
        }
        SampledDesign::Cubic(design) => {
            let file = design.deployed_certificate_file(title, formats, operation).ok()?;
            Some((design.deployed(formats, operation).ok()?, file))
        }
        _ => None,
    }
}

/// The certificate file of the stored numbers in exact arithmetic; none if that is not proved.
fn of_stored_numbers(title: &str, design: &SampledDesign, formats: Formats) -> Option<CertificateFile> {
    let m = design.matrices()?;
    let (n, m, p) = (m.a.nrows(), m.b.ncols(), m.c.nrows());
    let nothing = Operation {
        state: vec![0.0; n],
        input: vec![0.0; m],
        noise: vec![0.0; p],
        error: vec![0.0; n],
        deviation: None,
    };
    let (_, file) = deployed(title, design, formats, &nothing)?;
    let Theorem::DeployedObserver(theorem) = file.theorem().clone() else { return None };
    CertificateFile::prove(title, DeployedObserver { ball: None, ..theorem }).ok()
}

/// How much of the bound is due to rounding.
fn without_noise(study: &Study, entries: &[f64]) -> String {
    let plant = &study.plant;
    format!("Without measurement noise it is at most {}.", listed(plant, &plant.states, entries))
}

/// `position 0.1 m, velocity 0.2 m/s`: bounds of a conclusion, each rounded upwards.
pub(super) fn listed(plant: &PlantModel, names: &[String], values: &[f64]) -> String {
    written(plant, names, values, at_most)
}

/// The same for the bounds of a hypothesis, each rounded downwards.
fn supposed(plant: &PlantModel, names: &[String], values: &[f64]) -> String {
    written(plant, names, values, if_at_most)
}

fn written(plant: &PlantModel, names: &[String], values: &[f64], round: fn(f64, usize) -> String) -> String {
    let one = |(name, value): (&String, &f64)| format!("{name} {}", plant.measured(name, round(*value, DIGITS)));
    names.iter().zip(values).map(one).collect::<Vec<_>>().join(", ")
}

/// The bound of the error with all rounding counted, under its bounds of operation.
fn rounding(study: &Study, deployed: &Deployed, operation: &Operation, format: Format) -> Vec<String> {
    let ball = match &deployed.running {
        Running::Within(ball) => ball,
        Running::Unproved(why) if is_fixed(format) => {
            return vec![format!(
                "Rounding to {format} on the target: no bound is proved, and saturation is not excluded ({why})."
            )];
        }
        Running::Unproved(_) => return vec![format!("Rounding to {format} on the target: no bound is proved.")],
    };
    let plant = &study.plant;
    let mut bounds = vec![("states", supposed(plant, &plant.states, &operation.state))];
    if !plant.inputs.is_empty() {
        bounds.push(("inputs", supposed(plant, &plant.inputs, &operation.input)));
    }
    bounds.push(("measurement noise", supposed(plant, &plant.outputs, &operation.noise)));
    bounds.push(("first error", supposed(plant, &plant.states, &operation.error)));
    let bounds: Vec<String> = bounds.into_iter().map(|(what, list)| format!("{what} ({list})")).collect();
    vec![
        format!(
            "Rounding and noise{}: while the magnitudes of {} stay within these bounds, the error in the end is at most {}, and no operation leaves the range of {format}{}.",
            if operation.deviation.is_some() { ", and every deviation of A within `bounds`" } else { "" },
            bounds.join(", "),
            listed(plant, &plant.states, &ball.entries),
            if is_fixed(format) { ": nothing saturates" } else { "" }
        ),
        "The bounds are 1.2 times the magnitudes in the study's simulation, rounded up, with four standard deviations for Gaussian noise."
            .to_owned(),
    ]
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
        (Some((_, uncertainty)), Some(plant), Some(m)) => Some(uncertainty.sampled(&plant, m.period).ok()?),
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

/// The least bound from `x` on, up to the rounding of x, that is written with [`DIGITS`] digits: what is proved is proved
/// for the decimal that is printed, of which binary64 may have the number above only.
fn decimal_bound(x: f64) -> f64 {
    let near = rounded(x, DIGITS);
    let is_above = near >= x * (1.0 - 4.0 * f64::EPSILON);
    let decimal = if is_above { near } else { at_most(x, DIGITS).parse().unwrap_or(x) };
    if if_at_most(decimal, DIGITS).parse() == Ok(decimal) { decimal } else { decimal.next_up() }
}
