//! Designs of linear observers in discrete time.

use luenberger_design::{DesignError, DiscreteDesign, ErrorBound};
use luenberger_observers::StationaryKalmanFilter;
use luenberger_plants::StateSpace;
use luenberger_proof::certificate::Reading;
use nalgebra::Dyn;

use super::Plan;
use super::alternative::another_gain;
use super::error_bound::{acting, bounded};
use super::explain;
use super::linear::measurement;
use super::noise_gain;
use super::{Designed, asymptotic_factor, certified, deviations, matrix, number, poles, proof_matrix, proved_of};
use crate::designed::{Origin, Runnable, SampledDesign};
use crate::operation::half_ranges;
use crate::results::{Advice, DesignReport, NoObserver, Quantity};
use crate::study::{GainSpec, LinearSpec};

/// The design of a linear observer.
pub(crate) fn design(plan: &Plan<'_>, spec: &LinearSpec, dt: f64) -> Result<Designed, NoObserver> {
    let plant = plan.linear()?;
    let design = gain_of(plan, plant, (spec, dt))?;
    Ok(plan.in_loop(plant, linear(plan, plant, &design, (spec, dt))?))
}

/// The gain of a step, whose refusal has no advice.
pub(crate) fn gain_of_step(
    plan: &Plan<'_>,
    plant: &StateSpace,
    spec: &LinearSpec,
    dt: f64,
) -> Result<DiscreteDesign, NoObserver> {
    gain_of(plan, plant, (spec, dt)).map_err(|none| {
        let explained = explain::explained(plan, none, None);
        NoObserver { hypothesis: explained.hypothesis, cause: explained.cause, ..NoObserver::new("") }
    })
}

/// The gain; a refusal for a specification that is of continuous time.
pub(crate) fn gain_of(
    plan: &Plan<'_>,
    plant: &StateSpace,
    (spec, dt): (&LinearSpec, f64),
) -> Result<DiscreteDesign, NoObserver> {
    Ok(decided(plan, plant, (spec, dt))??)
}

/// The same, the error of the design by itself.
pub(crate) fn decided(
    plan: &Plan<'_>,
    plant: &StateSpace,
    (spec, dt): (&LinearSpec, f64),
) -> Result<Result<DiscreteDesign, DesignError>, NoObserver> {
    let refused = |hypothesis: &str| {
        let hint = "`poles` inside the unit circle, `decay_rate`, `w` and `v` per sample, or `gain`";
        NoObserver::new(hypothesis).advise(another_gain(plan.requested).and(Advice::hint(hint)))
    };
    if spec.weight.is_some() {
        return Err(refused("`rho` and `q` are for plants in continuous time"));
    }
    Ok(match &spec.gain {
        GainSpec::Poles(poles) => DiscreteDesign::with_poles(plant, dt, poles),
        GainSpec::Kalman(noise) => DiscreteDesign::kalman_of(plant, dt, noise),
        GainSpec::Given(l) => DiscreteDesign::with_gain(plant, dt, l),
        GainSpec::DecayRate(rate) => DiscreteDesign::lmi_with(plant, dt, *rate, &plan.options()),
        GainSpec::Lmi => DiscreteDesign::lmi_with(plant, dt, 0.0, &plan.options()),
    })
}

/// The name of the gain of the measurement update.
fn update_of(spec: &LinearSpec) -> &'static str {
    match &spec.gain {
        GainSpec::Kalman(noise) if noise.s.is_some() => "K (gain of the measurement update)",
        _ => "K (gain of the measurement update, L = A K)",
    }
}

/// A linear observer in numbers and words, with the bound of its error if that is asked for.
fn linear(
    plan: &Plan<'_>,
    plant: &StateSpace,
    design: &DiscreteDesign,
    of: (&LinearSpec, f64),
) -> Result<Designed, NoObserver> {
    let reading = plan.reading();
    let (report, filter) = described(&reading, plant, design, of);
    let runnable = filter.map_or_else(|| Runnable::from(design.observer.clone()), Runnable::from);
    let designed = designed(runnable, report, design);
    let Some(bounds) = &plan.requested.bounds else { return Ok(designed) };
    let bound = ErrorBound::discrete(&design.observer, &acting(bounds))?;
    Ok(bounded(designed, &bound, &Reading { scales: &half_ranges(plan.study), ..reading }, bounds))
}

/// An observer that runs, with the design that it is made of.
pub(crate) fn designed(runnable: Runnable, report: DesignReport, design: &DiscreteDesign) -> Designed {
    let origin = Origin::Sampled(SampledDesign::Linear(Box::new(design.clone())));
    Designed { runnable, report, certificate: Some(design.certificate.clone()), origin }
}

/// A linear design in numbers and words, and its filter where the estimate is that of the filter form.
pub(crate) fn described(
    reading: &Reading<'_>,
    plant: &StateSpace,
    design: &DiscreteDesign,
    (spec, dt): (&LinearSpec, f64),
) -> (DesignReport, Option<StationaryKalmanFilter<f64, Dyn, Dyn, Dyn>>) {
    let filter = design.filter().filter(|_| spec.is_filter);
    let radius = design.spectral_radius();
    let mut matrices = vec![matrix("L", design.l())];
    let mut stationary_deviation = design.covariance().map(deviations);
    match design.covariance() {
        Some(covariance) => {
            matrices.push(matrix("P (stationary covariance of the prediction error)", covariance));
            matrices.push(proof_matrix("Lyapunov matrix", &design.p));
        }
        None => matrices.push(proof_matrix("P", &design.p)),
    }
    if let (Some(filter), Some(covariance)) = (&filter, design.filter_covariance()) {
        matrices.insert(1, matrix(update_of(spec), filter.k()));
        let name = "(I - K C) P (stationary covariance of the estimation error)";
        matrices.insert(2, matrix(name, &covariance));
        stationary_deviation = Some(deviations(&covariance));
    }
    let mut numbers = vec![number(Quantity::Period, dt), number(Quantity::LargestPole, radius)];
    if spec.poses_inequality() {
        let of = design.observer.plant();
        numbers.extend(noise_gain::at_samples(&(&of.a - design.l() * &of.c), design.l()));
    }
    let form = match &filter {
        Some(_) => {
            "The estimate is xhat(k|k) = xhat(k|k-1) + K (y(k) - C xhat(k|k-1)); e is the error of the prediction xhat(k|k-1)."
        }
        None => "",
    };
    let report = DesignReport {
        statement: proved_of(&design.certificate, reading)
            .remark(form)
            .remark(measurement(plant))
            .remark(asymptotic_factor(radius)),
        matrices,
        poles: poles(&design.poles),
        numbers,
        stationary_deviation,
        ..certified(&design.certificate, &[])
    };
    (report, filter)
}
