//! Designs of the observers of linear plants.

use luenberger_design::{DesignError, ErrorBound, GainOptions, LinearDesign, UncertainBound};
use luenberger_plants::StateSpace;
use luenberger_proof::certificate::Reading;

use super::Plan;
use super::error_bound::{acting, bounded};
use super::noise_gain::NoiseGain;
use super::{Designed, asymptotic_rate, certified, deviations, matrix, number, poles, proof_matrix, proved_of};
use crate::operation::half_ranges;
use crate::results::{DesignReport, NoObserver, Quantity};
use crate::study::{ActingBounds, GainSpec, LinearSpec, Study};

/// The design of an observer that is linear, of this gain.
pub(crate) fn design(plan: &Plan<'_>, requested: &LinearSpec) -> Result<Designed, NoObserver> {
    let plant = plan.linear()?;
    let linear = linear_design(plant, requested, &plan.options())?;
    let designed = linear_report(plan.study, plant, &linear, plan.requested.bounds.as_ref())?;
    plan.at_point(plan.in_loop(plant, designed))
}

/// The linear design of a specification.
pub(crate) fn linear_design(
    plant: &StateSpace,
    requested: &LinearSpec,
    options: &GainOptions,
) -> Result<LinearDesign, DesignError> {
    let weight = || requested.weight.clone().unwrap_or_default();
    match &requested.gain {
        GainSpec::Poles(poles) => LinearDesign::with_poles_and_weight(plant, poles, weight()),
        GainSpec::Kalman(noise) => LinearDesign::kalman_of(plant, noise, weight()),
        GainSpec::Given(l) => LinearDesign::with_gain_and_weight(plant, l, weight()),
        _ if requested.weight.is_some() => Err(DesignError::LyapunovMatrixGiven),
        GainSpec::DecayRate(rate) => LinearDesign::lmi_with(plant, *rate, options),
        GainSpec::Lmi => LinearDesign::lmi_with(plant, 0.0, options),
    }
}

/// What the observers measure, which is what a certificate calls y.
pub(crate) fn measurement(plant: &StateSpace) -> &'static str {
    if plant.d.is_some() { "The output depends on the input: the observer uses y - D u = C x." } else { "" }
}

/// A linear observer in numbers and words, with the bound of its error if that is asked for.
pub(crate) fn linear_report(
    study: &Study,
    plant: &StateSpace,
    design: &LinearDesign,
    bounds: Option<&ActingBounds>,
) -> Result<Designed, NoObserver> {
    let rate = -design.spectral_abscissa();
    let noise = NoiseGain::of(study, [(&plant.a, &plant.c)], design.l(), Some(&design.poles));
    let mut numbers = vec![number(Quantity::DecayRate, rate)];
    numbers.extend(noise.numbers());
    let l = matrix("L", design.l());
    // P of a Kalman filter is the covariance of its error.
    let matrices = match design.covariance() {
        Some(covariance) => vec![
            l,
            matrix("P (stationary error covariance)", covariance),
            proof_matrix("Lyapunov matrix", &design.p),
            proof_matrix("Lyapunov right-hand side", &design.q),
        ],
        None => vec![l, proof_matrix("P", &design.p), proof_matrix("Q", &design.q)],
    };
    let report = DesignReport {
        statement: proved_of(&design.certificate, &study.plant.reading())
            .remark(measurement(plant))
            .remark(asymptotic_rate(rate)),
        matrices,
        poles: poles(&design.poles),
        numbers,
        noise_deviation: noise.deviation,
        stationary_deviation: design.covariance().map(deviations),
        ..certified(&design.certificate, &[])
    };
    let designed = Designed::new(design.observer.clone().into(), report, Some(design.certificate.clone()))
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
            let reading = Reading { scales: &half_ranges(study), ..study.plant.reading() };
            Ok(bounded(designed, &bound, &reading, bounds))
        }
        None => Ok(designed),
    }
}
