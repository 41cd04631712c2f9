//! Observers of a study as they run on a target: the sampled design of an observer, and what is proved of its stored
//! numbers in the arithmetic of the target.
//!
//! | file | subject |
//! |---|---|
//! | `linear` | what is proved of an observer of a linear plant on its target |
//! | `export` | an observer as a folder of files |
//! | `exported` | the program that an export prints, under the names of the study |
//! | `record` | the run of the study at the samples: what the exported step is compared with |

pub mod closed_loop;
mod export;
mod exported;
pub(crate) mod feedback;
mod linear;
mod record;

pub use export::{ExportOptions, ExportRefusal, ExportedObserver, Language, Libm, Precision, export, program};
pub(crate) use export::{Prepared, chosen, prepared};
pub use exported::exported;
pub use record::{Compared, Difference, Record, record};

use luenberger_clock::{Instant, stop_flag};
use luenberger_design::DesignError;
use luenberger_proof::statement::Formats;

use crate::design::{self, attempt};
use crate::designed::{Designed, StepOf};
pub use crate::designed::{IntervalDeployment, NonlinearStep, SampledDesign};
use crate::kinds;
use crate::results::{Cause, NoObserver, Statement};
pub use crate::steps::Evidence;
pub(crate) use crate::steps::{Matrices, stored};
use crate::steps::{extension, of_statement, proved_line};
use crate::study::{ObserverSpec, Study};
use crate::synthesis::{Plan, Sampling};

/// A sampled design, and the design of the study itself where it was needed.
#[derive(Debug, Clone)]
pub struct Sampled {
    /// The sampled design.
    pub design: SampledDesign,
    /// The sampling period.
    pub period: f64,
    of_the_study: Option<Designed>,
}

/// The step of an observer for each sample.
///
/// An observer of a linear plant gets the plant with its input held over the period, and a gain for that: observers in
/// continuous time keep their poles, `exp(h s)`; a Kalman filter becomes the stationary predictor for the sampled
/// noises; an H-infinity or H2 filter becomes that of the sampled plant; a cubic observer keeps theta and the strength
/// of its cubic term. An observer of a nonlinear plant keeps its gain and gets Runge-Kutta steps, `substeps` of them or
/// as many as its error needs; an extended Kalman filter stays as it is. A mean-value observer is exported as
/// `z = xhat + e`, with the constant gain L; its certificate is about z.
///
/// `period` is required for observers in continuous time, and that of a sampled observer cannot be changed.
///
/// # Errors
/// [`NoObserver`]: a kind without a step, a period that is missing, not positive or conflicts, and the errors of the
/// design.
pub fn sampled(
    study: &Study,
    observer: &ObserverSpec,
    period: Option<f64>,
    substeps: Option<usize>,
) -> Result<Sampled, NoObserver> {
    sampled_of((study, observer, None), period, substeps, None)
}

/// As [`sampled`], of an observer that has been designed for its study, if `designed` is given. No iteration of a
/// design starts after the instant `end`, if there is one; what is not designed then is an error.
pub(crate) fn sampled_of(
    (study, observer, designed): (&Study, &ObserverSpec, Option<&Designed>),
    period: Option<f64>,
    substeps: Option<usize>,
    end: Option<Instant>,
) -> Result<Sampled, NoObserver> {
    let failure = |hypothesis: String| NoObserver::new(hypothesis).at(observer.place.line);
    let own = observer.kind.period().or(study.plant.dt);
    let period = match (own, period) {
        (Some(own), Some(period)) if own != period => {
            return Err(failure(format!("{} has the period {own} in the study, not {period}", observer.name)));
        }
        (Some(period), _) | (None, Some(period)) => period,
        (None, None) => {
            let hypothesis = format!("{} is an observer in continuous time, and no period is given", observer.name);
            return Err(failure(hypothesis).hint("--period, or simulation.hold in the study"));
        }
    };
    let flag = stop_flag().unwrap_or_default();
    let cancel = &*flag;
    let plan = Plan { study, requested: observer, cancel, end };
    // The run of the study needs its design, which the sampled one then takes over.
    let of_the_study = match designed {
        Some(designed) => Some(designed.clone()),
        None if study.plant.model.linear().is_some() && study.simulation.is_some() => {
            attempt(study, observer, cancel, end).ok()
        }
        None => None,
    };
    let kind = kinds::kind_of(&observer.kind);
    let of_step = |none: NoObserver| {
        let is_lost =
            own.is_none() && matches!(none.cause.as_deref(), Some(Cause::Design(DesignError::NotSchur { .. })));
        let none = none.of_step().at(observer.place.line);
        if is_lost {
            none.hint("rounding spoils the gain of the step: another period, a longer one too, a Kalman filter, or poles that are nearer to each other")
        } else {
            none
        }
    };
    let sampling = Sampling { plan, period, designed: of_the_study.as_ref() };
    let sampled = study.plant.names().with(|| kind.map_or(Ok(None), |kind| kind.sampled(&sampling)));
    if let Some(design) = sampled.map_err(of_step)? {
        return Ok(Sampled { design, period, of_the_study });
    }
    let designed = match of_the_study {
        Some(designed) => designed,
        None => design::design(study, observer, cancel)?,
    };
    let step = || {
        if let (Some(kind), Some(point), None) = (kind, &study.operating_point, study.plant.model.linear())
            && let Some(design) = kind.sampled_at_point(&Sampling { plan, period, designed: Some(&designed) }, point)?
        {
            return Ok(design);
        }
        let plant = study.plant.model.expressions()?;
        let of = StepOf { study, observer, designed: &designed, plant: &plant, period, substeps };
        let step = match designed.runnable.step(&of)? {
            Some(step) => step,
            None => extension(&*designed.runnable, &of)?,
        };
        Ok(SampledDesign::Nonlinear(Box::new(step)))
    };
    let design = study.plant.names().with(step).map_err(of_step)?;
    Ok(Sampled { design, period, of_the_study: Some(designed) })
}

/// What is proved of a sampled design whose numbers are stored, and whose steps are computed, in `formats`: with the
/// bounds that states, inputs and noise have in the simulation of the study, the ball to which the error shrinks, all
/// rounding counted; without a simulation, the convergence for the gains as designed, or in fixed point as stored.
///
/// Fixed point is for linear designs, run by `luenberger_observers::FixedPointObserver`.
pub fn evidence(study: &Study, observer: &ObserverSpec, design: &SampledDesign, formats: Formats) -> Evidence {
    let (title, format) = (&observer.name, formats.running);
    match design {
        SampledDesign::Linear(found) => linear::evidence(study, observer, design, &found.certificate, formats),
        SampledDesign::Cubic(cubic) => linear::evidence(study, observer, design, &cubic.certificate, formats),
        SampledDesign::Varying(varying) => {
            let rest = format!(
                "The step predicts with the inputs of its call, held over the time dt; rounding to {format} on the target is not covered."
            );
            let statement = Statement::default().proved(varying.certificate.sentences(&study.plant.reading()));
            of_statement(title, Some(&varying.certificate), ", with the gains as designed", &statement, &rest)
        }
        SampledDesign::Nonlinear(step) => step.evidence(title, format),
        SampledDesign::Interval(interval) => interval.evidence(study, observer, format),
    }
}
