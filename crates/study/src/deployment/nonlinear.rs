//! Observers of nonlinear plants with a step for each sample.

use luenberger_design::Certificate;
use luenberger_export::ExportableObserver;
use luenberger_export::extension::RecordedObserver;
use luenberger_export::moving_horizon::MovingHorizon;
use luenberger_expression::ExpressionPlant;
use luenberger_observers::high_gain::HighGainMap;
use luenberger_observers::{
    CovarianceFilter, DiscreteNonlinearObserver, ExtendedKalmanFilter, InterSampleObserver, NoiseModel, Observer,
    ObserverError, Prediction, Regression, SampledNonlinearObserver, SampledObserver, UnscentedKalmanFilter,
};
use luenberger_plants::{Differentiable, Plant};
use luenberger_proof::statement::Format;
use luenberger_proof::wording::{counted, significant};
use nalgebra::{DMatrix, DVector, Dyn};

use super::fixed_steps::{self, MOST_SUBSTEPS};
use super::{Evidence, Refusal, of_statement};
use crate::design::{Designed, PrintedMean, Runnable};
use crate::results::{DesignVerdict, Statement};
use crate::study::{ObserverKind, ObserverSpec, Study};

/// A step of the Runge-Kutta method is at most this share of the time constant of the fastest mode of the error: its
/// own error is then below 1e-5 of the change.
const SHARE: f64 = 0.25;

/// An observer of a nonlinear plant with a step for each sample.
#[derive(Debug, Clone)]
pub struct NonlinearStep {
    /// The observer.
    pub observer: ExportableObserver,
    /// The first estimate, where it is not that of the study.
    pub initial: Option<Vec<f64>>,
    /// The certificate of the statement, if the statement is proved: of the step as designed in discrete time, of the
    /// observer in continuous time otherwise.
    pub certificate: Option<Certificate>,
    /// What the design says of the error.
    pub statement: Statement,
    /// What else is to be known of the step.
    pub remark: &'static str,
    /// The error of its fixed steps, measured; empty where there are none.
    pub step_error: String,
}

impl NonlinearStep {
    fn uncertified(observer: ExportableObserver, statement: &str) -> Self {
        let statement = Statement::of(statement);
        Self { observer, initial: None, certificate: None, statement, remark: "", step_error: String::new() }
    }

    /// The step of a design: its statement and its certificate are those of the design, and a certificate of a part of
    /// what the statement needs proves nothing of the step.
    fn of(designed: &Designed, observer: ExportableObserver) -> Self {
        let Designed { report, certificate, .. } = designed;
        let measured = if report.verdict == DesignVerdict::MEASURED { "Measured, not proved:" } else { "" };
        let statement = Statement::default().remark(measured).and(&report.statement);
        let certificate = certificate.clone().filter(|_| designed.is_proved());
        Self { observer, initial: None, certificate, statement, remark: "", step_error: String::new() }
    }

    /// What is proved of the step in this format.
    pub(super) fn evidence(&self, title: &str, format: Format) -> Evidence {
        let steps = counted(self.observer.substeps().unwrap_or(1), "step");
        let (of_what, rest) = match &self.observer {
            ExportableObserver::Discrete(_) => {
                (", with the gains as designed", format!("Rounding to {format} on the target is not covered."))
            }
            ExportableObserver::Step(_) => {
                // The design says of the sampled observer what the theorem does not.
                let alone = Statement::of_proved(self.statement.proved_sentences().cloned());
                let rest = format!(
                    "The step in this code solves the implicit equation at each sample; rounding to {format} is not covered."
                );
                let of_what = ", for the observer in continuous time";
                return of_statement(title, self.certificate.as_ref(), of_what, &alone, &rest);
            }
            ExportableObserver::SampledNonlinear(_) | ExportableObserver::Extension(_) => (
                ", for the observer in continuous time",
                format!(
                    "What this code computes, {steps} of the Runge-Kutta method per period and an output predicted between samples, approaches that as the period goes to 0; the proof does not cover it, nor rounding to {format}."
                ),
            ),
            ExportableObserver::Kkl(kkl) => {
                let inverse = if kkl.is_interpolated() {
                    "the interpolated one, a search in a table of splines"
                } else {
                    "the embedded one, a tree of polynomials"
                };
                let statement = self.statement.clone().remark(format!(
                    "The left inverse is {inverse}; between samples a copy of the plant predicts the output."
                ));
                let mut evidence = of_statement(title, None, "", &statement, "");
                evidence.sentences.extend(self.measured());
                return evidence;
            }
            filter => {
                let mut sentences = vec![format!("No stability certificate: {}", &*self.statement)];
                sentences.extend(self.measured());
                if matches!(filter, ExportableObserver::MovingHorizon(estimator) if estimator.bounds().is_some()) {
                    sentences.push(
                        "The bounds hold for the estimates after a measurement; the exported estimate is the prediction for the next sample, which may violate them.".to_owned(),
                    );
                }
                return Evidence { sentences, file: None };
            }
        };
        let mut evidence = of_statement(title, self.certificate.as_ref(), of_what, &self.statement, &rest);
        evidence.sentences.extend((!self.remark.is_empty()).then(|| self.remark.to_owned()));
        evidence.sentences.extend(self.measured());
        evidence
    }

    fn measured(&self) -> Option<String> {
        (!self.step_error.is_empty()).then(|| self.step_error.clone())
    }
}

/// The step of a filter: as it is in discrete time, with the exact discretisation of an affine motion, or with a fixed
/// number of steps. `made` is the filter of a plant in discrete time, with another W if one is given.
#[allow(clippy::type_complexity, reason = "what differs between the filters")]
fn filter_step<F>(
    (study, observer): (&Study, &ObserverSpec),
    plant: &ExpressionPlant,
    (prediction, w, substeps): (Prediction, &DMatrix<f64>, Option<usize>),
    (made, with, of): (
        impl Fn(ExpressionPlant, Option<DMatrix<f64>>) -> Result<F, Refusal>,
        impl Fn(&F, Prediction) -> Result<F, ObserverError>,
        impl Fn(F) -> NonlinearStep,
    ),
) -> Result<NonlinearStep, Refusal>
where
    F: CovarianceFilter<f64, Input = DVector<f64>, Output = DVector<f64>, Estimate = DVector<f64>>,
    F::State: Clone,
{
    let filter = made(plant.clone(), None)?;
    if prediction == Prediction::Discrete {
        return Ok(of(filter));
    }
    if let Some((sampled, w)) = fixed_steps::discretised(plant, w, filter.period()) {
        return Ok(NonlinearStep { step_error: EXACT.to_owned(), ..of(made(sampled, Some(w))?) });
    }
    let given = substeps.or(observer.kind.substeps());
    let steps = fixed_steps::of_filter((study, observer), plant, &filter, with, given)?;
    Ok(NonlinearStep { step_error: steps.sentence, ..of(steps.filter) })
}

/// The gate of a filter.
fn designed_gate(runnable: &Runnable) -> Option<f64> {
    match runnable {
        Runnable::ExtendedKalman(filter) => filter.gate(),
        Runnable::Unscented(filter) => filter.gate(),
        _ => None,
    }
}

/// The step of a filter of a plant with an affine motion.
const EXACT: &str = "Between samples the plant is linear: the prediction is its exact discretisation, with the input held over the period.";

/// The sampled form of an observer with given maps.
fn extension(
    study: &Study,
    observer: &ObserverSpec,
    designed: &Designed,
    plant: &ExpressionPlant,
    (period, substeps): (f64, Option<usize>),
) -> Result<NonlinearStep, Refusal> {
    let written = super::recorded::observer(observer, &designed.runnable, (plant, period))?;
    let substeps = match substeps {
        Some(substeps) => substeps,
        None => substeps_of(study, observer, &written, plant, period)?,
    };
    let sampled = |substeps| {
        let made = InterSampleObserver::new(plant.clone(), written.clone(), period, substeps);
        made.map_err(|error| (error.to_string(), Vec::new()))
    };
    let (coarse, fine) = (sampled(substeps)?, sampled(2 * substeps)?);
    let step_error = fixed_steps::sentence((study, observer), plant, (&coarse, &fine), (substeps, &observer.initial));
    let exported = ExportableObserver::Extension(coarse);
    Ok(NonlinearStep { remark: remark(&designed.runnable), step_error, ..NonlinearStep::of(designed, exported) })
}

/// What the sampled form of an observer has in addition.
fn remark(runnable: &Runnable) -> &'static str {
    match runnable {
        Runnable::UnknownInput(_) | Runnable::UnknownInputCubic(_) => {
            "Between two samples the disturbance is not seen: it adds an error of the order of the period times the disturbance."
        }
        _ => "",
    }
}

/// Runge-Kutta steps per period that resolve the fastest mode of the observer at its start. A regressor is filtered
/// from zero; what it tends to at the start counts.
fn substeps_of(
    study: &Study,
    observer: &ObserverSpec,
    written: &RecordedObserver,
    plant: &ExpressionPlant,
    period: f64,
) -> Result<usize, Refusal> {
    let mut u = DVector::zeros(study.plant.inputs.len());
    if let Some(program) = study.input.program() {
        program.at(0.0, u.as_mut_slice());
    }
    let x = DVector::from_column_slice(&observer.initial);
    let y: DVector<f64> = plant.output(0.0, &x, &u);
    let mut z = Observer::initial(written, 0.0, &x, &u, &y);
    if let ObserverKind::Pebo(spec) | ObserverKind::KklPeb(spec) = &observer.kind {
        let maps = &spec.maps;
        let order = maps.kkl.order();
        let m = maps.regressor(0.0, &z.rows(0, order).into_owned(), &u, &y);
        z.rows_mut(order + 2 * m.nrows(), m.len()).copy_from_slice(m.as_slice());
    }
    let jacobian = written.jacobian(0.0, &z, &u, &y);
    if jacobian.iter().any(|entry| !entry.is_finite()) {
        return Err((
            "the Jacobian of the observer is not finite at the first estimate".to_owned(),
            vec!["--substeps sets the number of Runge-Kutta steps per period".to_owned()],
        ));
    }
    let fastest = jacobian.complex_eigenvalues().iter().map(|pole| pole.norm()).fold(0.0, f64::max);
    steps_for(period, fastest)
}

/// Whether the mean of the Jacobian is the integral.
fn is_integral(observer: &ObserverSpec) -> bool {
    matches!(observer.kind, ObserverKind::MeanValue { printed: Some(PrintedMean::Integral), .. })
}

/// The sampled form of a design for a nonlinear plant.
pub(super) fn sampled(
    study: &Study,
    observer: &ObserverSpec,
    designed: &Designed,
    period: f64,
    substeps: Option<usize>,
) -> Result<NonlinearStep, Refusal> {
    let plain = |why: String| (why, Vec::new());
    let plant = study.plant.model.expressions().map_err(|error| plain(error.to_string()))?;
    let Designed { runnable, report, certificate, .. } = designed;
    let of_design = |observer: ExportableObserver| NonlinearStep::of(designed, observer);
    let with_gain = |l: DMatrix<f64>, initial: Vec<f64>, remark: &'static str| {
        let substeps = match substeps {
            Some(substeps) => substeps,
            None => substeps_for(study, &plant, &l, &initial, period)?,
        };
        let copy = |substeps| {
            SampledNonlinearObserver::new(plant.clone(), l.clone(), period, substeps)
                .map_err(|error| plain(error.to_string()))
        };
        let (coarse, fine) = (copy(substeps)?, copy(2 * substeps)?);
        let step_error = fixed_steps::sentence((study, observer), &plant, (&coarse, &fine), (substeps, &initial));
        let step = of_design(ExportableObserver::SampledNonlinear(coarse));
        Ok(NonlinearStep { initial: Some(initial), remark, step_error, ..step })
    };
    match runnable {
        Runnable::NonlinearLuenberger(designed) => with_gain(designed.l().clone(), observer.initial.clone(), ""),
        Runnable::MeanValue(injected) => {
            // z = xhat + e has the constant gain L, and the certificate is about z.
            let l = injected
                .l()
                .cloned()
                .ok_or_else(|| plain("the observer as printed has no constant gain".to_owned()))?;
            let first = observer.initial.iter().zip(injected.internal_error().iter()).map(|(xhat, e)| xhat + e);
            with_gain(l, first.collect(), "The exported estimate is z.")
        }
        Runnable::HighGain(chains) => {
            let (map, gain) = (chains.map(), chains.gain());
            let mut l = DMatrix::zeros(gain.len(), study.plant.outputs.len());
            for i in 0..gain.len() {
                l[(i, map.place(i).output)] = map.factors()[i] * gain[i];
            }
            with_gain(l, observer.initial.clone(), "")
        }
        Runnable::ExtendedKalman(filter) => {
            let (noises, period) = (filter.noise_model().clone(), filter.period());
            let gated = |filter: ExtendedKalmanFilter<ExpressionPlant, f64, Dyn, Dyn, Dyn>| match designed_gate(runnable) {
                Some(gate) => filter.with_gate(gate),
                None => Ok(filter),
            };
            let made = |plant, sampled: Option<DMatrix<f64>>| {
                let w = sampled.unwrap_or_else(|| noises.w.clone());
                let noises = NoiseModel { w, ..noises.clone() };
                ExtendedKalmanFilter::discrete(plant, noises, period)
                    .and_then(gated)
                    .map_err(|error| plain(error.to_string()))
            };
            let statement = "no theorem certifies an extended Kalman filter here.";
            let of = |filter| NonlinearStep::uncertified(ExportableObserver::Kalman(filter), statement);
            let with = |filter: &ExtendedKalmanFilter<_, f64, Dyn, Dyn, Dyn>, prediction| {
                filter.clone().with_prediction(prediction)
            };
            filter_step((study, observer), &plant, (filter.prediction(), &noises.w, substeps), (made, with, of))
        }
        Runnable::Unscented(filter) => {
            let (factors, sigma, period) = (filter.factors().clone(), filter.sigma_points(), filter.period());
            let gated = |filter: UnscentedKalmanFilter<ExpressionPlant, f64, Dyn, Dyn, Dyn>| match designed_gate(runnable) {
                Some(gate) => filter.with_gate(gate),
                None => Ok(filter),
            };
            let covariance = |factor: &DMatrix<f64>| factor * factor.transpose();
            let made = |plant, sampled: Option<DMatrix<f64>>| {
                let same = match sampled {
                    Some(w) => {
                        let noises = NoiseModel { w, v: covariance(&factors.v), p0: covariance(&factors.p0) };
                        UnscentedKalmanFilter::discrete(plant, noises, sigma, period)
                    }
                    // Without a change of the factors.
                    None => UnscentedKalmanFilter::from_factors(
                        plant,
                        factors.clone(),
                        sigma,
                        period,
                        Prediction::Discrete,
                    ),
                };
                same.and_then(gated).map_err(|error| plain(error.to_string()))
            };
            let statement = "there is no theorem for an unscented Kalman filter.";
            let of = |filter| NonlinearStep::uncertified(ExportableObserver::Unscented(filter), statement);
            let with = |filter: &UnscentedKalmanFilter<_, f64, Dyn, Dyn, Dyn>, prediction| {
                filter.clone().with_prediction(prediction)
            };
            let w = covariance(&factors.w);
            filter_step((study, observer), &plant, (filter.prediction(), &w, substeps), (made, with, of))
        }
        Runnable::MovingHorizon(estimator) => {
            let (noises, horizon, period) =
                (estimator.noise_model().clone(), estimator.horizon(), estimator.period());
            let made = |plant, sampled: Option<DMatrix<f64>>| {
                let w = sampled.unwrap_or_else(|| noises.w.clone());
                let noises = NoiseModel { w, ..noises.clone() };
                let same = MovingHorizon::discrete(plant, noises, horizon, period);
                let same = same.and_then(|same| match estimator.bounds() {
                    Some((lower, upper)) => same.with_bounds(lower.clone(), upper.clone()),
                    None => Ok(same),
                });
                same.map_err(|error| plain(error.to_string()))
            };
            let statement = "there is no theorem for this moving-horizon estimator.";
            let of = |estimator| NonlinearStep::uncertified(ExportableObserver::MovingHorizon(estimator), statement);
            let with = |estimator: &MovingHorizon<f64>, prediction| estimator.clone().with_prediction(prediction);
            filter_step((study, observer), &plant, (estimator.prediction(), &noises.w, substeps), (made, with, of))
        }
        Runnable::DiscreteNonlinear(designed) => {
            let observer = DiscreteNonlinearObserver::new(plant, designed.l().clone(), period);
            let observer = observer.map_err(|error| plain(error.to_string()))?;
            if certificate.is_none() {
                return Err(plain("the design has no certificate to refer to".to_owned()));
            }
            Ok(of_design(ExportableObserver::Discrete(observer)))
        }
        Runnable::Kkl(kkl) => {
            // The filter is slower than the plant has to be resolved: the poles of D are those of the cut-off.
            let fastest = report.poles.iter().map(|[re, im]| re.hypot(*im)).fold(0.0, f64::max);
            let step = (period, substeps.map_or_else(|| steps_for(period, fastest), Ok)?);
            Ok(of_design(ExportableObserver::Kkl(super::kkl::step((study, observer), kkl, &plant, step)?)))
        }
        Runnable::SlidingMode(found) => {
            Ok(of_design(ExportableObserver::Step(super::recorded::sliding_mode(found, &plant)?)))
        }
        Runnable::PrintedMeanValue(_) if !is_integral(observer) => Err((
            "the mean-value observer as printed has no export with beta by an iteration: its number of steps depends on the data"
                .to_owned(),
            vec![
                "as_printed = \"integral\", the mean of the Jacobian without an iteration".to_owned(),
                "kind = \"mean-value\" without `as_printed`, the observer with output injection".to_owned(),
            ],
        )),
        Runnable::Functional(..) => Err((
            "a functional observer has no export: it estimates z = K x alone, and has no prediction of the output between two samples"
                .to_owned(),
            vec!["reduced-order, or luenberger, with K times its estimate".to_owned()],
        )),
        Runnable::ReducedOrder(_)
        | Runnable::KklMaps(_)
        | Runnable::Peb(_)
        | Runnable::PrintedMeanValue(_)
        | Runnable::Immersion(_)
        | Runnable::HighGainMaps(_)
        | Runnable::UnknownInput(_)
        | Runnable::UnknownInputCubic(_) => extension(study, observer, designed, &plant, (period, substeps)),
        Runnable::CubicAt(_) | Runnable::SampledCubicAt(_) | Runnable::VaryingPeriods(_) => Err((
            "a cubic observer in deviations from an operating point has no export".to_owned(),
            vec!["kind = \"luenberger\" at the same operating point has one".to_owned()],
        )),
        Runnable::Linear(_)
        | Runnable::Cubic(_)
        | Runnable::ProportionalIntegral(_)
        | Runnable::ProportionalIntegralCubic(_)
        | Runnable::Interval(_)
        | Runnable::SampledInterval(_)
        | Runnable::SampledCubic(_)
        | Runnable::DiscreteLinear(_)
        | Runnable::StationaryKalman(_)
        | Runnable::LinearAt(_) => Err(plain("the plant is not nonlinear".to_owned())),
    }
}

/// Runge-Kutta steps per period that resolve the fastest mode of the error at the first estimate.
fn substeps_for(
    study: &Study,
    plant: &ExpressionPlant,
    l: &DMatrix<f64>,
    initial: &[f64],
    period: f64,
) -> Result<usize, Refusal> {
    let mut u = DVector::zeros(study.plant.inputs.len());
    if let Some(program) = study.input.program() {
        program.at(0.0, u.as_mut_slice());
    }
    let x = DVector::from_column_slice(initial);
    let a: DMatrix<f64> = plant.state_jacobian(0.0, &x, &u) - l * plant.output_jacobian(0.0, &x, &u);
    if a.iter().any(|entry| !entry.is_finite()) {
        return Err((
            "the Jacobian of the plant is not finite at the first estimate".to_owned(),
            vec!["--substeps sets the number of Runge-Kutta steps per period".to_owned()],
        ));
    }
    let fastest = a.complex_eigenvalues().iter().map(|pole| pole.norm()).fold(0.0, f64::max);
    steps_for(period, fastest)
}

/// Runge-Kutta steps per period for a mode of this magnitude.
fn steps_for(period: f64, fastest: f64) -> Result<usize, Refusal> {
    let wanted = (period * fastest / SHARE).ceil().max(1.0);
    if wanted <= MOST_SUBSTEPS as f64 {
        return Ok(wanted as usize);
    }
    Err((
        format!(
            "the period {period} is long for the fastest mode of the error, with the time constant {}: {} Runge-Kutta steps per period would be needed",
            significant(1.0 / fastest, 3),
            significant(wanted, 3)
        ),
        vec![
            format!("--period {} or shorter", significant(SHARE * MOST_SUBSTEPS as f64 / fastest, 2)),
            "--substeps to take fewer steps, or more than 100".to_owned(),
            "a slower observer".to_owned(),
        ],
    ))
}
