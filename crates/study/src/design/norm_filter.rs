//! Designs of H-infinity and H2 filters, for the plant and for its sampled form.

use luenberger_design::{
    DesignError, DiscreteDesign, GainOptions, GeneralizedPlant, LinearDesign, NormFilterDesign, NormTarget, SystemNorm,
    TimeDomain,
};
use luenberger_linalg::zero_order_hold;
use luenberger_plants::StateSpace;

use super::explain::Misfit;
use super::linear::measurement;
use super::noise_gain::NoiseGain;
use super::{Designed, asymptotic_factor, asymptotic_rate, certified, matrix, number, poles, proved_of, upper_bound};
use crate::results::DesignReport;
use crate::runnable::Runnable;
use crate::study::{NormFilterSpec, Study};

/// The filter of a plant in continuous time, or in discrete time with this period.
pub(super) fn norm_filter(
    study: &Study,
    plant: &StateSpace,
    spec: &NormFilterSpec,
    dt: Option<f64>,
    options: &GainOptions,
) -> Result<Designed, Misfit> {
    let time = if dt.is_some() { TimeDomain::Discrete } else { TimeDomain::Continuous };
    let design = NormFilterDesign::new(plant, time, spec.norm, &spec.performance, &spec.goal, options)?;
    let name = spec.norm.name();
    let largest = |f: fn(f64, f64) -> f64| {
        let each = design.poles.iter().map(|pole| f(pole.re, pole.im));
        each.fold(f64::NEG_INFINITY, f64::max)
    };
    let (runnable, decay, speed) = match dt {
        None => {
            let rate = -largest(|re, _| re);
            (Runnable::Linear(Box::new(design.observer()?)), asymptotic_rate(rate), number("decay rate", rate))
        }
        Some(dt) => {
            let radius = largest(f64::hypot);
            let runnable = Runnable::DiscreteLinear(Box::new(design.discrete_observer(dt)?));
            (runnable, asymptotic_factor(radius), number("largest modulus of a pole", radius))
        }
    };
    let mut numbers = vec![speed, upper_bound("gamma", design.gamma), number(&format!("{name} norm"), design.norm)];
    numbers.extend(design.least.map(|least| number(&format!("least {name} norm"), least)));
    numbers.extend(design.found.map(|found| number(&format!("least {name} norm found"), found)));
    numbers.extend(design.frequency.map(|frequency| number("frequency of the peak", frequency)));
    let mut noise = NoiseGain::default();
    if dt.is_none() {
        noise = NoiseGain::of(study, [(&plant.a, &plant.c)], &design.l, Some(&design.poles));
        numbers.extend(noise.numbers());
    }
    let report = DesignReport {
        statement: proved_of(&design.certificate, &study.plant.reading()).remark(measurement(plant)).remark(decay),
        matrices: vec![matrix("L", &design.l), matrix("P", &design.p)],
        poles: poles(&design.poles),
        numbers,
        noise_deviation: noise.deviation,
        ..certified(&design.certificate, &[])
    };
    Ok(Designed::new(runnable, report, Some(design.certificate.clone())))
}

/// The filter of the sampled plant, its input and w held over the period h. For H2, w has the covariance `I/h`, which
/// approaches white noise of unit intensity. A given gain keeps its poles, `exp(h s)`.
pub(crate) fn sampled(
    plant: &StateSpace,
    spec: &NormFilterSpec,
    h: f64,
    options: &GainOptions,
) -> Result<DiscreteDesign, DesignError> {
    if let NormTarget::OfGain(l) = &spec.goal {
        return DiscreteDesign::sampled(&LinearDesign::with_gain(plant, l)?, h);
    }
    let of = &spec.performance;
    let input = zero_order_hold(&plant.a, &plant.b, h)?;
    let acting = zero_order_hold(&plant.a, &of.e, h)?;
    let mut held = StateSpace::new(input.ad, input.bd, plant.c.clone())?;
    if let Some(d) = &plant.d {
        held = held.with_feedthrough(d.clone())?;
    }
    let size = match spec.norm {
        SystemNorm::HInfinity => 1.0,
        SystemNorm::H2 => 1.0 / h.sqrt(),
    };
    let of = GeneralizedPlant { e: acting.bd * size, d: &of.d * size, h: of.h.clone() };
    let design = NormFilterDesign::new(&held, TimeDomain::Discrete, spec.norm, &of, &spec.goal, options)?;
    DiscreteDesign::with_gain(&held, h, &design.l)
}

/// The filter of a plant in discrete time, as the exported observer.
pub(crate) fn discrete(
    plant: &StateSpace,
    spec: &NormFilterSpec,
    dt: f64,
    options: &GainOptions,
) -> Result<DiscreteDesign, DesignError> {
    let design = NormFilterDesign::new(plant, TimeDomain::Discrete, spec.norm, &spec.performance, &spec.goal, options)?;
    DiscreteDesign::with_gain(plant, dt, &design.l)
}
