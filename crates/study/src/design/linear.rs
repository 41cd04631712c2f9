//! Designs of the observers of linear plants.

use luenberger_design::{
    CubicDesign, CubicGain, DesignError, ErrorBound, GainOptions, LinearDesign, SampledCubicDesign, UncertainBound,
};
use luenberger_plants::StateSpace;
use luenberger_proof::certificate::Reading;
use luenberger_proof::wording::significant;
use nalgebra::DMatrix;

use super::error_bound::{acting, bounded};
use super::explain::Misfit;
use super::noise_gain::NoiseGain;
use super::{Designed, asymptotic_rate, certified, feedback, matrix, number, poles, proved_of};
use crate::deployment::SampledDesign;
use crate::designed::Origin;
use crate::results::{DesignReport, STATIONARY_COVARIANCES};
use crate::runnable::Runnable;
use crate::study::{ActingBounds, GainSpec, LinearSpec, Study};

pub(super) fn of(
    plant: &StateSpace,
    requested: &LinearSpec,
    options: &GainOptions,
) -> Result<LinearDesign, DesignError> {
    let weight = || requested.weight.clone().unwrap_or_default();
    match &requested.gain {
        GainSpec::Poles(poles) => LinearDesign::with_poles_and_weight(plant, poles, weight()),
        GainSpec::Kalman { w, v } => LinearDesign::kalman_with_weight(plant, w, v, weight()),
        GainSpec::Given(l) => LinearDesign::with_gain_and_weight(plant, l, weight()),
        _ if requested.weight.is_some() => Err(DesignError::LyapunovMatrixGiven),
        GainSpec::DecayRate(rate) => LinearDesign::lmi_with(plant, *rate, options),
        GainSpec::Lmi => LinearDesign::lmi_with(plant, 0.0, options),
    }
}

/// What the observers measure, which is what a certificate calls y.
pub(super) fn measurement(plant: &StateSpace) -> &'static str {
    if plant.d.is_some() { "The output depends on the input: the observer uses y - D u = C x." } else { "" }
}

pub(super) fn luenberger(
    study: &Study,
    plant: &StateSpace,
    requested: &LinearSpec,
    (options, bounds): (&GainOptions, Option<&ActingBounds>),
) -> Result<Designed, Misfit> {
    linear_report(study, plant, &of(plant, requested, options)?, bounds)
}

/// A linear observer in numbers and words, with the bound of its error if that is asked for.
pub(super) fn linear_report(
    study: &Study,
    plant: &StateSpace,
    design: &LinearDesign,
    bounds: Option<&ActingBounds>,
) -> Result<Designed, Misfit> {
    let rate = -design.spectral_abscissa();
    let noise = NoiseGain::of(study, [(&plant.a, &plant.c)], design.l(), Some(&design.poles));
    let mut numbers = vec![number("decay rate", rate)];
    numbers.extend(noise.numbers());
    let l = matrix("L", design.l());
    // P of a Kalman filter is the covariance of its error.
    let matrices = match design.covariance() {
        Some(covariance) => vec![
            l,
            matrix(STATIONARY_COVARIANCES[2], covariance),
            matrix("Lyapunov matrix", &design.p),
            matrix("Lyapunov right-hand side", &design.q),
        ],
        None => vec![l, matrix("P", &design.p), matrix("Q", &design.q)],
    };
    let report = DesignReport {
        statement: proved_of(&design.certificate, &study.plant.reading())
            .remark(measurement(plant))
            .remark(asymptotic_rate(rate)),
        matrices,
        poles: poles(&design.poles),
        numbers,
        noise_deviation: noise.deviation,
        ..certified(&design.certificate, &[])
    };
    let designed =
        Designed::new(Runnable::Linear(Box::new(design.observer.clone())), report, Some(design.certificate.clone()))
            .with_continuous(design, None);
    match bounds {
        Some(bounds) => {
            let acting = acting(bounds);
            let bound = match &bounds.uncertain {
                Some((states, deviation)) => {
                    UncertainBound::linear(design, deviation, states, Some(&acting))?.bound.clone()
                }
                None => ErrorBound::linear(&design.observer, &acting)?,
            };
            Ok(bounded(designed, &bound, &study.plant.reading(), bounds))
        }
        None => Ok(designed),
    }
}

pub(super) fn cubic(
    (study, name): (&Study, &str),
    plant: &StateSpace,
    requested: &LinearSpec,
    theta: &DMatrix<f64>,
    correction: &CubicGain,
    (options, bounds): (&GainOptions, Option<&ActingBounds>),
) -> Result<Designed, Misfit> {
    let linear = of(plant, requested, options)?;
    let design = CubicDesign::new(&linear, theta, correction)?;
    let designed = cubic_report(study, plant, (&linear, &design), bounds)?;
    Ok(feedback::cubic(study, name, plant, &design, designed))
}

/// A cubic observer in numbers and words, with the bound of its error if that is asked for.
pub(super) fn cubic_report(
    study: &Study,
    plant: &StateSpace,
    (linear, design): (&LinearDesign, &CubicDesign),
    bounds: Option<&ActingBounds>,
) -> Result<Designed, Misfit> {
    let noise = NoiseGain::of(study, [(&plant.a, &plant.c)], design.l(), Some(&linear.poles));
    let mut numbers = vec![number("decay rate of small errors", -linear.spectral_abscissa())];
    numbers.extend(noise.numbers());
    let report = DesignReport {
        statement: proved_of(&design.certificate, &study.plant.reading()).remark(measurement(plant)),
        matrices: vec![
            matrix("L", design.l()),
            matrix("N", &design.observer.n),
            matrix("theta", &design.observer.theta),
            matrix("P", &design.p),
            matrix("Q", &design.q),
            matrix("S", &design.s),
        ],
        poles: poles(&linear.poles),
        numbers,
        noise_deviation: noise.deviation,
        ..certified(&design.certificate, &[])
    };
    let designed =
        Designed::new(Runnable::Cubic(Box::new(design.observer.clone())), report, Some(design.certificate.clone()))
            .with_continuous(linear, Some(design));
    match bounds {
        Some(bounds) => {
            let acting = acting(bounds);
            let bound = match &bounds.uncertain {
                Some((states, deviation)) => {
                    UncertainBound::cubic(design, deviation, states, Some(&acting))?.bound.clone()
                }
                None => ErrorBound::cubic(design, &acting)?,
            };
            Ok(bounded(designed, &bound, &study.plant.reading(), bounds))
        }
        None => Ok(designed),
    }
}

pub(super) fn sampled(
    (plant, reading): (&StateSpace, &Reading<'_>),
    requested: &LinearSpec,
    theta: &DMatrix<f64>,
    (correction, period): (&CubicGain, f64),
    options: &GainOptions,
) -> Result<Designed, Misfit> {
    let linear = of(plant, requested, options)?;
    let design = SampledCubicDesign::with_cubic_gain(&linear, theta, correction, period)?;
    Ok(sampled_report(&design, (plant, reading), period))
}

/// A sampled cubic observer in numbers and words.
pub(super) fn sampled_report(
    design: &SampledCubicDesign,
    (plant, reading): (&StateSpace, &Reading<'_>),
    period: f64,
) -> Designed {
    let slowest = design.poles.iter().map(|pole| pole.norm()).fold(0.0, f64::max);
    let report = DesignReport {
        statement: proved_of(&design.certificate, reading)
            .remark(measurement(plant))
            .remark(format!("Computed: asymptotic factor of V {} per sample.", significant(slowest * slowest, 4))),
        matrices: vec![matrix("P", &design.p), matrix("S", &design.s)],
        poles: poles(&design.poles),
        numbers: vec![number("period", period), number("largest modulus of a pole", slowest)],
        ..certified(&design.certificate, &[])
    };
    let runnable = Runnable::SampledCubic(Box::new(design.observer.clone()));
    let origin = Origin::Sampled(SampledDesign::Cubic(Box::new(design.clone())));
    Designed { runnable, report, certificate: Some(design.certificate.clone()), origin }
}
