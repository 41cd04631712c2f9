//! Designs for plants in discrete time, `x+ = f(x, u)`.

use std::time::Instant;

use luenberger_design::{
    CubicGain, DesignError, DiscreteDesign, DiscreteLpvDesign, GainOptions, Region, SampledCubicDesign,
};
use luenberger_observers::Prediction;
use luenberger_observers::kalman::{ExtendedKalmanFilter, NoiseModel};
use luenberger_plants::StateSpace;
use luenberger_proof::statement::Format;
use luenberger_proof::wording::{shortest, significant};
use nalgebra::DMatrix;

use super::alternative::{Advice, another_gain, other_kinds};
use super::explain::{self, Misfit};
use super::interval::{self, Sampling};
use super::{
    Designed, NoDesign, asymptotic_factor, certified, lower_bound, matrix, number, poles, proved_of, upper_bound,
};
use crate::deployment::SampledDesign;
use crate::designed::Origin;
use crate::operation;
use crate::results::Proposal;
use crate::results::{DesignReport, FailureReport, STATIONARY_COVARIANCES, Statement};
use crate::runnable::Runnable;
use crate::study::{GainSpec, LinearSpec, ObserverKind, ObserverSpec, RateSpec, Study};

pub(super) fn design(
    study: &Study,
    requested: &ObserverSpec,
    dt: f64,
    end: Option<Instant>,
) -> Result<Designed, NoDesign> {
    let kind = requested.kind.name();
    let linear = || study.plant.model.linear().ok_or_else(|| explain::not_linear(study, requested));
    let explained = |misfit| explain::misfit(study, requested, &misfit);
    let same = |period: f64| {
        if (period - dt).abs() <= 1e-9 * dt {
            return Ok(());
        }
        let hypothesis = format!("period = {period}, and the plant is in discrete time with dt = {dt}");
        let same = Proposal::keys([format!("period = {}", shortest(dt))], &["period"], "that of the plant");
        Err(explain::failure(requested, hypothesis, Advice::of([same])))
    };
    Ok(match &requested.kind {
        ObserverKind::Luenberger(gain) | ObserverKind::Kalman(gain) => {
            let plant = linear()?;
            in_loop(study, requested, &plant, self::linear(study, &plant, (gain, dt), requested)?.map_err(explained)?)
        }
        ObserverKind::NormFilter(spec) => {
            let options = requested.limits.options(study.solver, end);
            let plant = linear()?;
            let designed = super::norm_filter::norm_filter(study, &plant, spec, Some(dt), &options);
            in_loop(study, requested, &plant, designed.map_err(explained)?)
        }
        ObserverKind::SampledCubic { linear: gain, theta, correction, period, varying } => {
            if varying.is_some() {
                let hypothesis = "`jitter` and `misses` are for plants in continuous time".to_owned();
                let hint = Advice::hint("the plant in continuous time, whose motion over every period is known");
                let constant = Proposal::keys([], &["jitter", "misses"], "at constant periods");
                return Err(explain::failure(requested, hypothesis, Advice::of([constant]).and(hint)).into());
            }
            same(*period)?;
            let gain = gain_of(study, &linear()?, (gain, dt), requested)?.map_err(explained)?;
            cubic(study, &gain, (theta, correction), dt).map_err(explained)?
        }
        ObserverKind::Interval(spec) => {
            let plant = linear()?;
            if plant.d.is_some() {
                let hypothesis = "the kind interval has no step for outputs with feedthrough D".to_owned();
                return Err(explain::failure(requested, hypothesis, Advice::hint("y - D u as the output")).into());
            }
            let gain = match &spec.gain {
                Some(gain) => {
                    Some(gain_of(study, &plant, (gain, dt), requested)?.map_err(explained)?.observer.l().clone())
                }
                None => None,
            };
            let sampling = Sampling {
                plant: &plant,
                gain,
                period: dt,
                held: false,
                operation: operation::largest(study, requested),
                format: Format::Binary64,
            };
            let reading = study.plant.reading();
            interval::discrete((&plant, &reading), &sampling, spec, requested.bounds.as_ref()).map_err(explained)?
        }
        ObserverKind::ExtendedKalman { w, v, p0, period, gate, .. } => {
            same(*period)?;
            extended(study, (w, v, p0), dt, *gate).map_err(explained)?
        }
        ObserverKind::Unscented(spec) => {
            same(spec.period)?;
            super::unscented::design(&study.plant.model, spec, Prediction::Discrete).map_err(explained)?
        }
        ObserverKind::MovingHorizon(spec) => {
            same(spec.period)?;
            super::moving_horizon::design(&study.plant.model, spec, Prediction::Discrete).map_err(explained)?
        }
        ObserverKind::Lpv { region, rate } => {
            let options = requested.limits.options(study.solver, end);
            lpv(study, region, rate, dt, &options).map_err(explained)?
        }
        _ => {
            let hypothesis = format!("the kind {kind} is for plants in continuous time, and this one has dt = {dt}");
            return Err(explain::failure(requested, hypothesis, other_kinds(study, requested)).into());
        }
    })
}

/// With what is proved of the loop, where the estimate fed back is the prediction.
fn in_loop(study: &Study, requested: &ObserverSpec, plant: &StateSpace, designed: Designed) -> Designed {
    match &designed.runnable {
        Runnable::DiscreteLinear(observer) => {
            let l = observer.l().clone();
            super::feedback::linear(study, requested, plant, &l, designed)
        }
        _ => designed,
    }
}

/// The gain; a failure for a specification that is of continuous time.
pub(super) fn gain_of(
    study: &Study,
    plant: &StateSpace,
    (spec, dt): (&LinearSpec, f64),
    requested: &ObserverSpec,
) -> Result<Result<DiscreteDesign, Misfit>, FailureReport> {
    let instead = || {
        let hint = "`poles` inside the unit circle, `w` and `v` per sample, or `gain`";
        another_gain(study, requested).and(Advice::hint(hint))
    };
    if spec.weight.is_some() {
        let hypothesis = "`rho` and `q` are for plants in continuous time".to_owned();
        return Err(explain::failure(requested, hypothesis, instead()));
    }
    let design = match &spec.gain {
        GainSpec::Poles(poles) => DiscreteDesign::with_poles(plant, dt, poles),
        GainSpec::Kalman { w, v } => DiscreteDesign::kalman(plant, dt, w, v),
        GainSpec::Given(l) => DiscreteDesign::with_gain(plant, dt, l),
        GainSpec::DecayRate(_) | GainSpec::Lmi => {
            let hypothesis = "`decay_rate` and `lmi` are for plants in continuous time".to_owned();
            return Err(explain::failure(requested, hypothesis, instead()));
        }
    };
    Ok(design.map_err(Misfit::from))
}

fn linear(
    study: &Study,
    plant: &StateSpace,
    (spec, dt): (&LinearSpec, f64),
    requested: &ObserverSpec,
) -> Result<Result<Designed, Misfit>, FailureReport> {
    Ok(gain_of(study, plant, (spec, dt), requested)?.map(|design| {
        let filter = design.filter().filter(|_| spec.is_filter);
        let radius = design.spectral_radius();
        let mut matrices = vec![matrix("L", design.l())];
        match design.covariance() {
            Some(covariance) => {
                matrices.push(matrix(STATIONARY_COVARIANCES[1], covariance));
                matrices.push(matrix("Lyapunov matrix", &design.p));
            }
            None => matrices.push(matrix("P", &design.p)),
        }
        if let (Some(filter), Some(covariance)) = (&filter, design.filter_covariance()) {
            matrices.insert(1, matrix("K (gain of the measurement update, L = A K)", filter.k()));
            matrices.insert(2, matrix(STATIONARY_COVARIANCES[0], &covariance));
        }
        let form = match &filter {
            Some(_) => "The estimate is xhat(k|k) = xhat(k|k-1) + K (y(k) - C xhat(k|k-1)); e is the error of the prediction xhat(k|k-1).",
            None => "",
        };
        let report = DesignReport {
            statement: proved_of(&design.certificate, &study.plant.reading())
                .remark(form)
                .remark(super::linear::measurement(plant))
                .remark(asymptotic_factor(radius)),
            matrices,
            poles: poles(&design.poles),
            numbers: vec![number("period", dt), number("largest modulus of a pole", radius)],
            ..certified(&design.certificate, &[])
        };
        let runnable = match filter {
            Some(filter) => Runnable::StationaryKalman(Box::new(filter)),
            None => Runnable::DiscreteLinear(Box::new(design.observer.clone())),
        };
        let certificate = Some(design.certificate.clone());
        Designed { runnable, report, certificate, origin: Origin::Sampled(SampledDesign::Linear(Box::new(design))) }
    }))
}

fn cubic(
    study: &Study,
    linear: &DiscreteDesign,
    (theta, correction): (&DMatrix<f64>, &CubicGain),
    dt: f64,
) -> Result<Designed, Misfit> {
    let design = SampledCubicDesign::of_discrete_with_cubic_gain(linear, theta, correction)?;
    let plant = (linear.observer.plant(), &study.plant.reading());
    Ok(super::linear::sampled_report(&design, plant, dt))
}

fn lpv(study: &Study, region: &Region, rate: &RateSpec, dt: f64, options: &GainOptions) -> Result<Designed, Misfit> {
    let model = study.plant.model.clone();
    let design = match rate {
        RateSpec::Rate(rate) => DiscreteLpvDesign::new(model, dt, region, *rate, options)?,
        // The rate is determined to one hundredth of the ceiling, which is enough for a design.
        RateSpec::Fastest(ceiling) => {
            DiscreteLpvDesign::max_rate(model, dt, region, (*ceiling, 0.01 * ceiling), options)?
        }
        RateSpec::Gain(gain, _) => DiscreteLpvDesign::certify(model, dt, region, gain, &options.settings)?,
    };
    let evidence =
        design.stopped.as_ref().map(|(rate, why)| format!("rate {} is not certified: {why}", significant(*rate, 5)));
    let l = design.l();
    let report = DesignReport {
        statement: Statement::of_proved(design.sentence()),
        matrices: vec![matrix("L", l), matrix("P", &design.p)],
        numbers: vec![
            lower_bound("rate", design.rate),
            upper_bound("factor of a step", design.factor),
            upper_bound("overshoot", design.overshoot),
            number("vertices", design.polytope.vertices.len() as f64),
            number("norm of L", l.clone().svd(false, false).singular_values.max()),
        ],
        evidence,
        ..certified(&design.certificate, &design.vertex_names())
    };
    let runnable = Runnable::DiscreteNonlinear(Box::new(design.observer.clone()));
    Ok(Designed::new(runnable, report, Some(design.certificate.clone())))
}

fn extended(
    study: &Study,
    (w, v, p0): (&DMatrix<f64>, &DMatrix<f64>, &DMatrix<f64>),
    dt: f64,
    gate: Option<f64>,
) -> Result<Designed, Misfit> {
    let noises = NoiseModel { w: w.clone(), v: v.clone(), p0: p0.clone() };
    let filter = ExtendedKalmanFilter::discrete(study.plant.model.clone(), noises, dt).map_err(DesignError::from)?;
    super::nonlinear::extended_report(filter, (w, v, p0), dt, gate)
}
