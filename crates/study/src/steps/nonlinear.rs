//! Observers of nonlinear plants with a step for each sample.

use luenberger_export::ExportableObserver;
use luenberger_export::extension::RecordedObserver;
use luenberger_expression::ExpressionPlant;
use luenberger_observers::{
    CovarianceFilter, InterSampleObserver, Observer, ObserverError, Prediction, SampledNonlinearObserver,
};
use luenberger_plants::{Differentiable, Plant};
use luenberger_proof::statement::Format;
use luenberger_proof::wording::{counted, significant};
use nalgebra::{DMatrix, DVector};

use super::fixed_steps::{self, MOST_SUBSTEPS};
use super::{Evidence, of_statement};
use crate::designed::{Designed, NonlinearStep, Running, StepOf};
use crate::results::{DesignVerdict, NoObserver, Statement};

/// A step of the Runge-Kutta method is at most this share of the time constant of the fastest mode of the error: its
/// own error is then below 1e-5 of the change.
const SHARE: f64 = 0.25;

impl NonlinearStep {
    pub(crate) fn uncertified(observer: ExportableObserver, statement: &str) -> Self {
        let statement = Statement::of(statement);
        Self {
            observer,
            initial: None,
            names: None,
            certificate: None,
            statement,
            remark: "",
            step_error: String::new(),
        }
    }

    /// The step of a design: its statement and its certificate are those of the design, and a certificate of a part of
    /// what the statement needs proves nothing of the step.
    pub(crate) fn of(designed: &Designed, observer: ExportableObserver) -> Self {
        let Designed { report, certificate, .. } = designed;
        let measured = if report.verdict == DesignVerdict::MEASURED { "Measured, not proved:" } else { "" };
        let statement = Statement::default().remark(measured).and(&report.statement);
        let certificate = certificate.clone().filter(|_| designed.is_proved());
        Self { observer, initial: None, names: None, certificate, statement, remark: "", step_error: String::new() }
    }

    /// What is proved of the step in this format.
    pub(crate) fn evidence(&self, title: &str, format: Format) -> Evidence {
        let steps = counted(self.observer.substeps().unwrap_or(1), "step");
        let (of_what, rest) = match &self.observer {
            ExportableObserver::Discrete(_) => {
                (", with the gains as designed", format!("Rounding to {format} on the target is not covered."))
            }
            ExportableObserver::Step(step) if step.is_of_sample() => {
                let rest = format!(
                    "State of the step: the estimate at the sample, then the state of the observer for the next one. Rounding to {format} on the target is not covered."
                );
                if self.certificate.is_none() {
                    return Evidence { sentences: vec![self.statement.to_string(), rest], file: None };
                }
                (", with the gains as designed", rest)
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
pub(crate) fn filter_step<F>(
    of: &StepOf<'_>,
    (prediction, w): (Prediction, &DMatrix<f64>),
    (made, with, step): (
        impl Fn(ExpressionPlant, Option<DMatrix<f64>>) -> Result<F, ObserverError>,
        impl Fn(&F, Prediction) -> Result<F, ObserverError>,
        impl Fn(F) -> NonlinearStep,
    ),
) -> Result<NonlinearStep, NoObserver>
where
    F: CovarianceFilter<f64, Input = DVector<f64>, Output = DVector<f64>, Estimate = DVector<f64>>,
    F::State: Clone,
{
    let filter = made(of.plant.clone(), None)?;
    if prediction == Prediction::Discrete {
        return Ok(step(filter));
    }
    if let Some((sampled, w)) = fixed_steps::discretised(of.plant, w, filter.period()) {
        return Ok(NonlinearStep { step_error: EXACT.to_owned(), ..step(made(sampled, Some(w))?) });
    }
    let given = of.substeps.or(of.observer.kind.substeps());
    let steps = fixed_steps::of_filter((of.study, of.observer), of.plant, &filter, with, given)?;
    Ok(NonlinearStep { step_error: steps.sentence, ..step(steps.filter) })
}

/// The step of a filter of a plant with an affine motion.
const EXACT: &str = "Between samples the plant is linear: the prediction is its exact discretisation, with the input held over the period.";

/// The step of a recorded observer in continuous time.
pub(crate) fn extension<O: Running + ?Sized>(observer: &O, of: &StepOf<'_>) -> Result<NonlinearStep, NoObserver> {
    let written = of.plant.record(|recording| observer.record(of, recording))?;
    let substeps = match of.substeps {
        Some(substeps) => substeps,
        None => substeps_of(observer, of, &written)?,
    };
    let sampled = |substeps| InterSampleObserver::new(of.plant.clone(), written.clone(), of.period, substeps);
    let (coarse, fine) = (sampled(substeps)?, sampled(2 * substeps)?);
    let of_run = (substeps, of.observer.initial.as_slice());
    let step_error = fixed_steps::sentence((of.study, of.observer), of.plant, (&coarse, &fine), of_run);
    let step = NonlinearStep::of(of.designed, ExportableObserver::Extension(coarse));
    Ok(NonlinearStep { remark: observer.remark_of_step(), step_error, ..step })
}

/// Runge-Kutta steps per period that resolve the fastest mode of the observer at its start.
fn substeps_of<O: Running + ?Sized>(
    observer: &O,
    of: &StepOf<'_>,
    written: &RecordedObserver,
) -> Result<usize, NoObserver> {
    let u = of.first_input();
    let x = DVector::from_column_slice(&of.observer.initial);
    let y: DVector<f64> = of.plant.output(0.0, &x, &u);
    let z = observer.settled(of, Observer::initial(written, 0.0, &x, &u, &y), &u, &y);
    let jacobian = written.jacobian(0.0, &z, &u, &y);
    if jacobian.iter().any(|entry| !entry.is_finite()) {
        return Err(not_finite("observer"));
    }
    steps_for(of.period, fastest(&jacobian))
}

fn not_finite(whose: &str) -> NoObserver {
    NoObserver::new(format!("the Jacobian of the {whose} is not finite at the first estimate"))
        .hint("--substeps sets the number of Runge-Kutta steps per period")
}

fn fastest(jacobian: &DMatrix<f64>) -> f64 {
    jacobian.complex_eigenvalues().iter().map(|pole| pole.norm()).fold(0.0, f64::max)
}

impl StepOf<'_> {
    /// The input at the start.
    fn first_input(&self) -> DVector<f64> {
        let mut u = DVector::zeros(self.study.plant.inputs.len());
        if let Some(program) = self.study.input.program() {
            program.at(0.0, u.as_mut_slice());
        }
        u
    }

    /// The step of a copy of the plant with this gain, from this estimate on.
    pub(crate) fn with_gain(
        &self,
        l: &DMatrix<f64>,
        initial: Vec<f64>,
        remark: &'static str,
    ) -> Result<NonlinearStep, NoObserver> {
        let substeps = match self.substeps {
            Some(substeps) => substeps,
            None => self.substeps_for(l, &initial)?,
        };
        let copy = |substeps| SampledNonlinearObserver::new(self.plant.clone(), l.clone(), self.period, substeps);
        let (coarse, fine) = (copy(substeps)?, copy(2 * substeps)?);
        let of_run = (substeps, initial.as_slice());
        let step_error = fixed_steps::sentence((self.study, self.observer), self.plant, (&coarse, &fine), of_run);
        let step = NonlinearStep::of(self.designed, ExportableObserver::SampledNonlinear(coarse));
        Ok(NonlinearStep { initial: Some(initial), remark, step_error, ..step })
    }

    /// Runge-Kutta steps per period that resolve the fastest mode of the error at the first estimate.
    fn substeps_for(&self, l: &DMatrix<f64>, initial: &[f64]) -> Result<usize, NoObserver> {
        let (u, x) = (self.first_input(), DVector::from_column_slice(initial));
        let a: DMatrix<f64> = self.plant.state_jacobian(0.0, &x, &u) - l * self.plant.output_jacobian(0.0, &x, &u);
        if a.iter().any(|entry| !entry.is_finite()) {
            return Err(not_finite("plant"));
        }
        steps_for(self.period, fastest(&a))
    }
}

/// Runge-Kutta steps per period for a mode of this magnitude.
pub(crate) fn steps_for(period: f64, fastest: f64) -> Result<usize, NoObserver> {
    let wanted = (period * fastest / SHARE).ceil().max(1.0);
    if wanted <= MOST_SUBSTEPS as f64 {
        return Ok(wanted as usize);
    }
    let hypothesis = format!(
        "the period {period} is long for the fastest mode of the error, with the time constant {}: {} Runge-Kutta steps per period would be needed",
        significant(1.0 / fastest, 3),
        significant(wanted, 3)
    );
    Err(NoObserver::new(hypothesis)
        .hint(format!("--period {} or shorter", significant(SHARE * MOST_SUBSTEPS as f64 / fastest, 2)))
        .hint("--substeps to take fewer steps, or more than 100")
        .hint("a slower observer"))
}
