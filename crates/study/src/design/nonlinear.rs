//! Designs of the observers of nonlinear plants.

use luenberger_design::enclosure::enclose;
use luenberger_design::lpv::Polytope;
use luenberger_design::{
    DesignError, GainOptions, LipschitzDesign, LipschitzPlant, LpvDesign, LpvError, MeanValueDesign, Region, Sector,
};
use luenberger_export::extension::RecordedObserver;
use luenberger_observers::{ExtendedKalmanFilter, HighGainObserver, Integral, NoiseModel, Observer};
use luenberger_plants::Plant;
use luenberger_proof::certificate::{ProvedSentence, Reading, Represented};
use luenberger_proof::wording::significant;
use nalgebra::{DMatrix, DVector};

use super::explain::Misfit;
use super::noise_gain::NoiseGain;
use super::{Designed, certified, lower_bound, matrix, number, uncertified, upper_bound};
use crate::maps::{HighGainMaps, high_gain};
use crate::model::Model;
use crate::results::{DesignReport, Statement};
use crate::runnable::{Chains, Runnable};
use crate::study::{ObserverSpec, RateSpec, Study};

pub(super) fn lpv(study: &Study, region: &Region, rate: &RateSpec, options: &GainOptions) -> Result<Designed, Misfit> {
    let model = &study.plant.model;
    let design = match rate {
        RateSpec::Rate(rate) => LpvDesign::new_with(model.clone(), region, *rate, options),
        // The rate is determined to one hundredth of the ceiling, which is enough for a design.
        RateSpec::Fastest(ceiling) => {
            LpvDesign::max_rate_with(model.clone(), region, *ceiling, 0.01 * ceiling, options)
        }
        RateSpec::Gain(gain, _) => LpvDesign::certify_with(model.clone(), region, gain, &options.settings),
    };
    let design = match design {
        Err(LpvError::TooManyVertices { .. }) => return beyond_vertices(study, region, rate, options),
        design => design?,
    };
    let evidence =
        design.stopped.as_ref().map(|(rate, why)| format!("rate {} is not certified: {why}", significant(*rate, 5)));
    let pairs = design.polytope.vertices.iter().map(|vertex| (&vertex.a, &vertex.c));
    let l = design.l();
    let noise = NoiseGain::of(study, pairs, l, None);
    let mut numbers = vec![
        lower_bound("rate", design.rate),
        upper_bound("overshoot", design.overshoot),
        number("vertices", design.polytope.vertices.len() as f64),
    ];
    numbers.extend(noise.numbers());
    let report = DesignReport {
        statement: Statement::of_proved(design.sentence()),
        matrices: vec![matrix("L", l), matrix("P", &design.p)],
        numbers,
        evidence,
        noise_deviation: noise.deviation,
        ..certified(&design.certificate, &design.vertex_names())
    };
    let runnable = Runnable::NonlinearLuenberger(Box::new(design.observer.clone()));
    Ok(Designed::new(runnable, report, Some(design.certificate.clone())))
}

/// Where the vertices are too many: the norm-bounded form, with a sector for each entry that varies and one inequality
/// in place of one for each vertex. It is sufficient only.
fn beyond_vertices(study: &Study, region: &Region, rate: &RateSpec, options: &GainOptions) -> Result<Designed, Misfit> {
    let enclosure = enclose(&study.plant.model, region)?;
    let plant = LipschitzPlant::over(&enclosure)?;
    let count = plant.sectors().len();
    let at = |rate| LipschitzDesign::new_with(&plant, None, rate, options);
    let design = match rate {
        RateSpec::Rate(rate) => at(*rate)?,
        RateSpec::Gain(gain, rate) => LipschitzDesign::new_with(&plant, Some(gain), *rate, options)?,
        RateSpec::Fastest(ceiling) => fastest(at, *ceiling)?,
    };
    let whose = format!(
        "{count} entries of the Jacobians vary, too many for a polytope with 2^{count} vertices: the norm-bounded form is used, which is more conservative."
    );
    by_sectors(study, &design, enclosure.sentence(&design.certificate, region, ("xhat", "t")), &whose)
}

pub(super) fn lipschitz(
    study: &Study,
    split: Option<&(DMatrix<f64>, Vec<Sector>)>,
    region: &Region,
    rate: f64,
    gain: Option<&DMatrix<f64>>,
    options: &GainOptions,
) -> Result<Designed, Misfit> {
    let enclosure = enclose(&study.plant.model, region)?;
    let read = LipschitzPlant::over(&enclosure)?;
    let plant = match split {
        Some((a, sectors)) => read.with_sectors(a.clone(), sectors.clone())?,
        None => read,
    };
    let design = LipschitzDesign::new_with(&plant, gain, rate, options)?;
    if let Some(sentence) = enclosure.sentence(&design.certificate, region, ("xhat", "t")) {
        return by_sectors(study, &design, Some(sentence), "The sectors enclose the Jacobian over the region.");
    }
    let hypothesis = enclosure.hypothesis(region, "xhat", "t");
    let reading = Reading { plant: Represented::InSectors { hypothesis: &hypothesis }, ..study.plant.reading() };
    let given = design.certificate.sentences(&reading).into_iter().next();
    by_sectors(study, &design, given, "The sectors are those of the study; they are not checked.")
}

/// The design of the greatest rate up to the ceiling, to one hundredth of it.
fn fastest(
    at: impl Fn(f64) -> Result<LipschitzDesign, DesignError>,
    ceiling: f64,
) -> Result<LipschitzDesign, DesignError> {
    let proved = |rate| at(rate).ok().filter(|design| design.certificate.is_proved());
    if let Some(design) = proved(ceiling) {
        return Ok(design);
    }
    let (mut best, mut low, mut high) = (at(0.0)?, 0.0, ceiling);
    while high - low > 0.01 * ceiling {
        let middle = f64::midpoint(low, high);
        match proved(middle) {
            Some(design) => (best, low) = (design, middle),
            None => high = middle,
        }
    }
    Ok(best)
}

/// The report of a design by sectors, with what it proves; `whose` says where they come from.
fn by_sectors(
    study: &Study,
    design: &LipschitzDesign,
    sentence: Option<ProvedSentence>,
    whose: &str,
) -> Result<Designed, Misfit> {
    let count = design.plant.sectors().len();
    let centre = design.plant.centre();
    let noise = NoiseGain::of(study, [(&centre, design.plant.c())], &design.l, None);
    let mut numbers = vec![lower_bound("rate", design.rate), number("sectors", count as f64)];
    numbers.extend(noise.numbers());
    let report = DesignReport {
        statement: Statement::of_proved(sentence).remark(whose),
        matrices: vec![matrix("L", &design.l), matrix("P", &design.p)],
        numbers,
        noise_deviation: noise.deviation,
        ..certified(&design.certificate, &[])
    };
    let observer = design.observer(study.plant.model.clone())?;
    Ok(Designed::new(Runnable::NonlinearLuenberger(Box::new(observer)), report, Some(design.certificate.clone())))
}

pub(super) fn mean_value(
    study: &Study,
    region: &Region,
    rate: f64,
    eta: f64,
    internal_error: &[f64],
    options: &GainOptions,
) -> Result<Designed, Misfit> {
    let model = &study.plant.model;
    let polytope = Polytope::new(enclose(model, region)?)?;
    let design = MeanValueDesign::over(&polytope, rate, options)?;
    let names: Vec<String> = polytope.vertices.iter().map(ToString::to_string).collect();
    let observer = design.observer(model.clone(), eta, Integral, DVector::from_column_slice(internal_error))?;
    let noise = NoiseGain::of(study, polytope.vertices.iter().map(|vertex| (&vertex.a, &vertex.c)), &design.l, None);
    let mut numbers = vec![
        lower_bound("rate", design.rate),
        upper_bound("overshoot", design.overshoot),
        number("eta", eta),
        number("vertices", polytope.vertices.len() as f64),
    ];
    numbers.extend(noise.numbers());
    let report = DesignReport {
        statement: Statement::of_proved(polytope.enclosure.sentence(&design.certificate, region, ("z", "t")))
            .remark("z is xhat + e, with the internal error e."),
        matrices: vec![matrix("L", &design.l), matrix("P", &design.p)],
        numbers,
        noise_deviation: noise.deviation,
        ..certified(&design.certificate, &names)
    };
    let runnable = Runnable::MeanValue(Box::new(observer));
    Ok(Designed::new(runnable, report, Some(design.certificate.clone())))
}

pub(super) fn high_gain(chains: Chains, alpha: &[f64], r: f64) -> Result<Designed, Misfit> {
    let column = |entries: &DVector<f64>| DMatrix::from_column_slice(entries.len(), 1, entries.as_slice());
    let constant = chains.have_constant_coefficients();
    let has_factors = !constant || chains.factors().iter().any(|factor| *factor != 1.0);
    let factors = has_factors.then(|| column(chains.factors()));
    let observer = HighGainObserver::new(chains, DVector::from_column_slice(alpha), r)?;
    let mut matrices = vec![matrix("alpha_i / r^i", &column(observer.gain()))];
    let mut gains = "the gains alpha_i / r^i".to_owned();
    if let Some(factors) = factors {
        gains.push_str(" times factors (the inverse products of the chain's coefficients at the first estimate)");
        matrices.push(matrix("factors", &factors));
    }
    let (theorem, why) = if constant {
        (
            "If the right-hand side is Lipschitz and r is small enough, the error decays like exp(-c t / r).",
            "the theorem holds for all r below a bound that is not computed; check this r by simulation",
        )
    } else {
        (
            "The coefficients of the chain vary, and the gains are those of the first estimate.",
            "the theorem is for coefficients that are constant; check this r by simulation",
        )
    };
    let report = DesignReport {
        statement: Statement::of(format!("A copy of the plant with {gains}, r = {r}. {theorem}")),
        matrices,
        numbers: vec![number("r", r)],
        ..uncertified(why)
    };
    Ok(Designed::new(Runnable::HighGain(Box::new(observer)), report, None))
}

/// A high-gain observer with given maps; the poles are those at the first estimate.
pub(super) fn high_gain_maps(
    study: &Study,
    requested: &ObserverSpec,
    maps: &HighGainMaps,
    alpha: &[f64],
    r: f64,
) -> Result<Designed, Misfit> {
    let observer = HighGainObserver::new(maps.clone(), DVector::from_column_slice(alpha), r)?;
    let gain = observer.gain();
    let plant = study.plant.model.expressions().ok();
    let poles = plant
        .and_then(|plant| {
            plant.record(|recording| RecordedObserver::new(recording, &high_gain::recorded(&observer).ok()?).ok())
        })
        .and_then(|written| {
            let mut u = DVector::zeros(study.plant.inputs.len());
            if let Some(program) = study.input.program() {
                program.at(0.0, u.as_mut_slice());
            }
            let x = DVector::from_column_slice(&requested.initial);
            let y: DVector<f64> = study.plant.model.output(0.0, &x, &u);
            let z = Observer::initial(&observer, 0.0, &x, &u, &y);
            let jacobian = written.jacobian(0.0, &z, &u, &y);
            let finite = jacobian.iter().all(|entry| entry.is_finite());
            finite.then(|| super::poles(jacobian.complex_eigenvalues().as_slice()))
        })
        .unwrap_or_default();
    let report = DesignReport {
        statement: Statement::of(format!(
            "xi' = drift + shape (alpha_i / r^i) (y - head) with the head of each chain, r = {r}. The poles are those of the observer at the first estimate."
        )),
        matrices: vec![matrix("alpha_i / r^i", &DMatrix::from_column_slice(gain.len(), 1, gain.as_slice()))],
        poles,
        numbers: vec![number("r", r)],
        ..uncertified("the maps are not checked; look at the error in a simulation")
    };
    Ok(Designed::new(Runnable::HighGainMaps(Box::new(observer)), report, None))
}

pub(super) fn extended_kalman(
    model: &Model,
    (w, v, p0): (&DMatrix<f64>, &DMatrix<f64>, &DMatrix<f64>),
    period: f64,
    gate: Option<f64>,
) -> Result<Designed, Misfit> {
    let noises = NoiseModel { w: w.clone(), v: v.clone(), p0: p0.clone() };
    extended_report(ExtendedKalmanFilter::error_controlled(model.clone(), noises, period)?, (w, v, p0), period, gate)
}

/// An extended Kalman filter with its gate, in numbers and words.
pub(super) fn extended_report(
    mut filter: ExtendedKalmanFilter<Model, f64, nalgebra::Dyn, nalgebra::Dyn, nalgebra::Dyn>,
    (w, v, p0): (&DMatrix<f64>, &DMatrix<f64>, &DMatrix<f64>),
    period: f64,
    gate: Option<f64>,
) -> Result<Designed, Misfit> {
    let gated =
        gate.map_or_else(String::new, |gate| format!(" Innovations beyond {gate} standard deviations are rejected."));
    if let Some(gate) = gate {
        filter = filter.with_gate(gate)?;
    }
    let report = DesignReport {
        statement: Statement::of(format!(
            "One measurement every {period}; the gain is computed from the covariance along the estimate.{gated}"
        )),
        matrices: vec![matrix("W", w), matrix("V", v), matrix("P(0)", p0)],
        numbers: vec![number("period", period)],
        ..uncertified("local convergence only")
    };
    Ok(Designed::new(Runnable::ExtendedKalman(Box::new(filter)), report, None))
}
