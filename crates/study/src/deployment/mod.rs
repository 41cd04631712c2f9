//! Observers of a study as they run on a target: the sampled design of an observer, and what is proved of its stored
//! numbers in the arithmetic of the target.
//!
//! | file | subject |
//! |---|---|
//! | `linear` | what is proved of an observer of a linear plant on its target |
//! | `nonlinear` | observers of nonlinear plants with a step for each sample, and what is proved of them |
//! | `export` | an observer as a folder of files |
//! | `exported` | the program that an export prints, under the names of the study |
//! | `kkl` | the numerical KKL observer |
//! | `interval` | the interval observer |
//! | `expressions` | the plant as expressions, which can be printed as source code |
//! | `recorded` | observers as programs |
//! | `record` | the run of the study at the samples: what the exported step is compared with |

mod export;
mod exported;
mod expressions;
pub(crate) mod feedback;
mod fixed_steps;
mod interval;
mod kkl;
mod linear;
mod nonlinear;
mod record;
pub(crate) mod recorded;

pub(crate) use export::prepared;
pub use export::{ExportOptions, ExportRefusal, ExportedObserver, Language, Precision, export, program};
pub use exported::exported;
pub use interval::IntervalDeployment;
pub use nonlinear::NonlinearStep;
pub use record::{Difference, Record, record};

use std::borrow::Cow;
use std::sync::atomic::AtomicBool;
use std::time::Instant;

use luenberger_design::{
    Certificate, CubicDesign, CubicGain, DesignError, DiscreteDesign, GainOptions, LinearDesign, OperatingPoint,
    SampledCubicDesign, VaryingPeriodDesign,
};
use luenberger_export::ExportableObserver;
use luenberger_linalg::spectral_radius;
use luenberger_observers::{DiscreteNonlinearObserver, SampledObserver};
use luenberger_plants::StateSpace;
use luenberger_proof::certificate::{CertificateFile, ProvedSentence, Reading};
use luenberger_proof::statement::{Format, Formats};
use luenberger_proof::wording::at_least;
use nalgebra::{DMatrix, DVector};

use crate::design::{self, Designed, NoDesign, Runnable, attempt};
use crate::designed::Origin;
use crate::results::{FailureReport, Statement};
use crate::study::{GainSpec, LinearSpec, ObserverKind, ObserverSpec, Study};

/// Why there is no step, and what would have one.
type Refusal = (String, Vec<String>);

/// A sampled design with its certificate.
#[derive(Debug, Clone)]
pub enum SampledDesign {
    /// Linear.
    Linear(Box<DiscreteDesign>),
    /// Cubic.
    Cubic(Box<SampledCubicDesign>),
    /// Cubic, at varying periods.
    Varying(Box<VaryingPeriodDesign>),
    /// Of a nonlinear plant.
    Nonlinear(Box<NonlinearStep>),
    /// The interval observer.
    Interval(Box<IntervalDeployment>),
}

/// A sampled design, and the design of the study itself where it was needed.
#[derive(Debug, Clone)]
pub struct Sampled {
    /// The sampled design.
    pub design: SampledDesign,
    /// The sampling period.
    pub period: f64,
    of_the_study: Option<Designed>,
}

impl SampledDesign {
    /// The first estimate.
    pub fn initial(&self, observer: &ObserverSpec) -> Vec<f64> {
        let own = if let Self::Nonlinear(step) = self { step.initial.as_ref() } else { None };
        let mut initial = own.unwrap_or(&observer.initial).clone();
        // Disturbances are estimated to be 0 at the start.
        initial.extend(std::iter::repeat_n(0.0, observer.kind.estimated_disturbances().len()));
        initial
    }

    /// Runge-Kutta steps per period, where there are any.
    pub fn substeps(&self) -> Option<usize> {
        if let Self::Nonlinear(step) = self { step.observer.substeps() } else { None }
    }

    /// The gain K of the measurement update, of a Kalman filter in filter form.
    pub fn update_gain(&self, observer: &ObserverSpec) -> Option<&DMatrix<f64>> {
        match (self, &observer.kind) {
            (Self::Linear(design), ObserverKind::Kalman(spec)) if spec.is_filter => design.update_gain(),
            _ => None,
        }
    }

    /// The matrices of an observer of a linear plant.
    pub(crate) fn matrices(&self) -> Option<Matrices<'_>> {
        Some(match self {
            Self::Linear(design) => {
                let (plant, l) = (design.observer.plant(), design.l());
                let StateSpace { a, b, c, d } = plant;
                Matrices { a, b, c, d: d.as_ref(), l, period: design.observer.period(), is_cubic: false }
            }
            Self::Cubic(design) => {
                let o = &design.observer;
                let (a, b, c, d, l) = (o.ad(), o.bd(), o.c(), o.d(), o.ld());
                Matrices { a, b, c, d, l, period: o.period(), is_cubic: true }
            }
            _ => return None,
        })
    }

    /// Checks that the gain, as stored in `format`, still makes the observer stable.
    ///
    /// # Errors
    /// [`FailureReport`] with the spectral radius of `A - L C`; none for a number that the format cannot store, which
    /// is an error of the export.
    pub fn stored_in(&self, observer: &ObserverSpec, format: Format) -> Result<(), FailureReport> {
        let Some(m) = self.matrices() else { return Ok(()) };
        let (Some(a), Some(c), Some(l)) = (stored(m.a, format), stored(m.c, format), stored(m.l, format)) else {
            return Ok(());
        };
        match spectral_radius(&(a - l * c)) {
            Ok(radius) if radius >= 1.0 => {
                let hypothesis = format!(
                    "rounded to {format}, A - L C has the spectral radius {}, which is not below 1",
                    at_least(radius, 6)
                );
                Err(FailureReport::new(hypothesis, observer.place.line)
                    .hint("--format f64, or a shorter settling time in relation to the period"))
            }
            _ => Ok(()),
        }
    }

    /// One step of an observer of a linear plant.
    pub(crate) fn step(&self, xhat: &mut DVector<f64>, u: &DVector<f64>, y: &DVector<f64>) {
        match self {
            Self::Linear(design) => design.observer.step(0.0, xhat, u, y),
            Self::Cubic(design) => design.observer.step(0.0, xhat, u, y),
            _ => {}
        }
    }
}

/// The matrices of an observer of a sampled linear plant.
pub(crate) struct Matrices<'a> {
    pub(crate) a: &'a DMatrix<f64>,
    pub(crate) b: &'a DMatrix<f64>,
    pub(crate) c: &'a DMatrix<f64>,
    pub(crate) d: Option<&'a DMatrix<f64>>,
    pub(crate) l: &'a DMatrix<f64>,
    pub(crate) period: f64,
    pub(crate) is_cubic: bool,
}

/// A matrix as the format stores it; none with an entry beyond its range.
pub(crate) fn stored(matrix: &DMatrix<f64>, format: Format) -> Option<DMatrix<f64>> {
    let entries: Option<Vec<f64>> = matrix.iter().map(|x| format.round(*x)).collect();
    Some(DMatrix::from_vec(matrix.nrows(), matrix.ncols(), entries?))
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
/// [`FailureReport`]: a kind without a step, a period that is missing, not positive or conflicts, and the errors of the
/// design.
pub fn sampled(
    study: &Study,
    observer: &ObserverSpec,
    period: Option<f64>,
    substeps: Option<usize>,
) -> Result<Sampled, FailureReport> {
    sampled_of((study, observer, None), period, substeps, None)
}

/// As [`sampled`], of an observer that has been designed for its study, if `designed` is given. No iteration of a
/// design starts after the instant `end`, if there is one; what is not designed then is an error.
pub(crate) fn sampled_of(
    (study, observer, designed): (&Study, &ObserverSpec, Option<&Designed>),
    period: Option<f64>,
    substeps: Option<usize>,
    end: Option<Instant>,
) -> Result<Sampled, FailureReport> {
    let failure = |hypothesis: String| FailureReport::new(hypothesis, observer.place.line);
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
    let linear = study.plant.model.linear();
    let names = study.plant.names();
    let options = observer.limits.options(study.solver, end);
    // The run of the study needs its design, which the sampled one then takes over.
    let of_the_study = match designed {
        Some(designed) => Some(designed.clone()),
        None if linear.is_some() && study.simulation.is_some() => {
            attempt(study, observer, &AtomicBool::new(false), end).ok()
        }
        None => None,
    };
    let origin = of_the_study.as_ref().map_or(&Origin::Runnable, |designed| &designed.origin);
    if let (
        ObserverKind::Luenberger(gain)
        | ObserverKind::Kalman(gain)
        | ObserverKind::Cubic { linear: gain, .. }
        | ObserverKind::SampledCubic { linear: gain, .. },
        Some(plant),
    ) = (&observer.kind, &linear)
    {
        let design = match (origin, study.plant.dt) {
            (Origin::Sampled(design), _) => Ok(design.clone()),
            (_, Some(dt)) => names.with(|| in_discrete_time(study, observer, plant, gain, dt)),
            (origin, None) => names.with(|| {
                let found = held(observer, (plant, gain), origin, period, &options);
                found.map_err(|error| error.to_string())
            }),
        };
        return Ok(Sampled { design: design.map_err(&failure)?, period, of_the_study });
    }
    if let (ObserverKind::ProportionalIntegral { e, chain, linear: gain, .. }, Some(plant)) = (&observer.kind, &linear)
    {
        let design = names.with(|| {
            let both = luenberger_design::with_disturbance_chain(plant, e, chain.unwrap_or(1))?;
            held(observer, (&both, gain), origin, period, &options)
        });
        let design = design.map_err(|error| failure(error.to_string()))?;
        return Ok(Sampled { design, period, of_the_study });
    }
    if let (ObserverKind::Interval(spec), Some(plant)) = (&observer.kind, &linear) {
        let design = names.with(|| {
            if let Origin::Interval(designed) = origin {
                return Ok(IntervalDeployment::of_discrete(study, observer, spec, (plant, designed), period));
            }
            let gain = match (&spec.gain, study.plant.dt) {
                (None, _) => None,
                (Some(gain), Some(dt)) => {
                    Some(design::discrete_design(study, plant, gain, dt, observer)?.observer.l().clone())
                }
                (Some(gain), None) => {
                    let found = design::linear_design(plant, gain, &options)
                        .and_then(|linear| sampled_linear(&linear, gain, period))
                        .map_err(|error| error.to_string())?;
                    Some(found.l().clone())
                }
            };
            IntervalDeployment::new(study, observer, spec, (plant, gain), period)
        });
        let design = design.map_err(&failure)?;
        return Ok(Sampled { design: SampledDesign::Interval(Box::new(design)), period, of_the_study });
    }
    if let (ObserverKind::OptimalCubic(problem), Some(plant)) = (&observer.kind, &linear) {
        let sampled = |linear: &LinearDesign, cubic: Option<&CubicDesign>| match cubic {
            Some(cubic) => {
                let design = SampledCubicDesign::from_cubic_with_weight(linear, cubic, period)?;
                Ok(SampledDesign::Cubic(Box::new(design)))
            }
            None => Ok(SampledDesign::Linear(Box::new(DiscreteDesign::sampled(linear, period)?))),
        };
        let design = names.with(|| {
            if let Origin::Continuous { linear, cubic } = origin {
                return sampled(linear, cubic.as_deref());
            }
            let found = luenberger_design::OptimalCubicDesign::new(plant, problem, end)?;
            sampled(&found.linear, found.cubic.as_ref())
        });
        let design = design.map_err(|error: DesignError| failure(error.to_string()))?;
        return Ok(Sampled { design, period, of_the_study });
    }
    if let ObserverKind::NormFilter(spec) = &observer.kind {
        let design = names.with(|| match (&linear, study.plant.dt, &study.operating_point) {
            (Some(plant), Some(dt), _) => {
                let design = match of_the_study.as_ref().map(|designed| &designed.runnable) {
                    Some(Runnable::DiscreteLinear(filter)) => DiscreteDesign::with_gain(plant, dt, filter.l()),
                    _ => design::norm_filter::discrete(plant, spec, dt, &options),
                };
                design.map(|design| SampledDesign::Linear(Box::new(design))).map_err(|error| error.to_string())
            }
            (Some(plant), None, _) => {
                let design = design::norm_filter::sampled(plant, spec, period, &options);
                design.map(|design| SampledDesign::Linear(Box::new(design))).map_err(|error| error.to_string())
            }
            (None, None, Some(point)) => {
                let reading = study.plant.reading();
                around(design::norm_filter::sampled(&point.linear, spec, period, &options), point, (period, &reading))
            }
            (None, ..) => Err(format!("the kind {} needs a linear plant", observer.kind.name())),
        });
        return Ok(Sampled { design: design.map_err(&failure)?, period, of_the_study });
    }
    let in_words = |(hypothesis, hints): Refusal| hints.into_iter().fold(failure(hypothesis), FailureReport::hint);
    let designed = match of_the_study {
        Some(designed) => designed,
        None => design::design(study, observer, &AtomicBool::new(false)).map_err(|none| match none {
            NoDesign::Misfit(failure) => failure,
            NoDesign::Interrupted => failure("interrupted".to_owned()),
        })?,
    };
    if let (ObserverKind::Luenberger(gain) | ObserverKind::Kalman(gain), Runnable::LinearAt(_), Some(point)) =
        (&observer.kind, &designed.runnable, &study.operating_point)
    {
        if gain.is_filter {
            let hypothesis = format!("{} is in filter form, which has no export at an operating point", observer.name);
            return Err(failure(hypothesis).hint("form = \"predictor\""));
        }
        let reading = study.plant.reading();
        let design = names.with(|| at_point(gain, point, &designed.origin, (period, &reading), &options));
        let design = design.map_err(&failure)?;
        return Ok(Sampled { design, period, of_the_study: Some(designed) });
    }
    let step = names.with(|| nonlinear::sampled(study, observer, &designed, period, substeps)).map_err(in_words)?;
    Ok(Sampled { design: SampledDesign::Nonlinear(Box::new(step)), period, of_the_study: Some(designed) })
}

/// The sampled linear design at an operating point.
fn at_point(
    gain: &LinearSpec,
    point: &OperatingPoint,
    origin: &Origin,
    (period, reading): (f64, &Reading<'_>),
    options: &GainOptions,
) -> Result<SampledDesign, String> {
    let linear = continuous(&point.linear, gain, origin, options);
    around(linear.and_then(|linear| sampled_linear(&linear, gain, period)), point, (period, reading))
}

/// A sampled linear design in deviations from an operating point.
fn around(
    sampled: Result<DiscreteDesign, DesignError>,
    point: &OperatingPoint,
    (period, reading): (f64, &Reading<'_>),
) -> Result<SampledDesign, String> {
    let words = |error: &dyn std::fmt::Display| error.to_string();
    let sampled = sampled.map_err(|error| words(&error))?;
    let plant = expressions::around(sampled.observer.plant(), point).map_err(|error| words(&error))?;
    let statement = Statement::of("The linearisation at the operating point is sampled with the input held.")
        .proved(sampled.certificate.sentences(reading))
        .remark("Nothing is proved of the nonlinear plant.");
    let with_gain = DiscreteNonlinearObserver::new(plant, sampled.l().clone(), period);
    Ok(SampledDesign::Nonlinear(Box::new(NonlinearStep {
        observer: ExportableObserver::Discrete(with_gain.map_err(|error| words(&error))?),
        initial: None,
        certificate: Some(sampled.certificate.clone()),
        statement,
        remark: "",
        step_error: String::new(),
    })))
}

/// The design of the study itself, of a plant in discrete time.
fn in_discrete_time(
    study: &Study,
    observer: &ObserverSpec,
    plant: &StateSpace,
    gain: &LinearSpec,
    dt: f64,
) -> Result<SampledDesign, String> {
    let linear = design::discrete_design(study, plant, gain, dt, observer)?;
    match &observer.kind {
        ObserverKind::SampledCubic { theta, correction, .. } => {
            let design = SampledCubicDesign::of_discrete_with_cubic_gain(&linear, theta, correction);
            Ok(SampledDesign::Cubic(Box::new(design.map_err(|error| error.to_string())?)))
        }
        ObserverKind::Cubic { .. } => Err("the kind cubic is for plants in continuous time".to_owned()),
        _ => Ok(SampledDesign::Linear(Box::new(linear))),
    }
}

/// The design for a plant whose input is held over the period.
fn held(
    observer: &ObserverSpec,
    (plant, gain): (&StateSpace, &LinearSpec),
    origin: &Origin,
    period: f64,
    options: &GainOptions,
) -> Result<SampledDesign, DesignError> {
    let linear = continuous(plant, gain, origin, options)?;
    let cubic = |design| SampledDesign::Cubic(Box::new(design));
    let of_cubic = |theta: &DMatrix<f64>, correction: &CubicGain| {
        let continuous = match origin {
            Origin::Continuous { cubic: Some(cubic), .. } => Cow::Borrowed(&**cubic),
            _ => Cow::Owned(CubicDesign::new(&linear, theta, correction)?),
        };
        SampledCubicDesign::from_cubic(&linear, &continuous, period).map(cubic)
    };
    match &observer.kind {
        ObserverKind::Cubic { theta, correction, .. } => of_cubic(theta, correction),
        ObserverKind::SampledCubic { theta, correction, varying: Some(periods), .. } => {
            let varying = VaryingPeriodDesign::new(&linear, theta, correction, period, periods)?;
            Ok(SampledDesign::Varying(Box::new(varying)))
        }
        ObserverKind::SampledCubic { theta, correction, .. } => {
            SampledCubicDesign::with_cubic_gain(&linear, theta, correction, period).map(cubic)
        }
        ObserverKind::ProportionalIntegral { cubic: Some((theta, gamma)), .. } => {
            of_cubic(theta, &CubicGain::Gamma(*gamma))
        }
        _ => sampled_linear(&linear, gain, period).map(|design| SampledDesign::Linear(Box::new(design))),
    }
}

/// The linear design in continuous time, that of the study if it is there.
fn continuous<'a>(
    plant: &StateSpace,
    gain: &LinearSpec,
    origin: &'a Origin,
    options: &GainOptions,
) -> Result<Cow<'a, LinearDesign>, DesignError> {
    match origin {
        Origin::Continuous { linear, .. } => Ok(Cow::Borrowed(linear)),
        _ => design::linear_design(plant, gain, options).map(Cow::Owned),
    }
}

fn sampled_linear(linear: &LinearDesign, gain: &LinearSpec, period: f64) -> Result<DiscreteDesign, DesignError> {
    match &gain.gain {
        GainSpec::Kalman { w, v } => DiscreteDesign::sampled_kalman(&linear.observer.plant(), period, w, v),
        _ => DiscreteDesign::sampled(linear, period),
    }
}

/// What is proved of an observer on its target.
#[derive(Debug, Clone)]
pub struct Evidence {
    /// Sentences.
    pub sentences: Vec<String>,
    /// The certificate file; none if nothing is proved.
    pub file: Option<CertificateFile>,
}

impl Evidence {
    /// Whether something is proved.
    pub fn is_proved(&self) -> bool {
        self.file.is_some()
    }
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

/// The statement of a design, with what it leaves open.
fn of_statement(
    title: &str,
    certificate: Option<&Certificate>,
    of_what: &str,
    statement: &Statement,
    rest: &str,
) -> Evidence {
    let proved: Vec<ProvedSentence> = statement.proved_sentences().cloned().collect();
    let remarks = statement.remarks().collect::<Vec<_>>().join(" ");
    match (proved_line(of_what, &proved), certificate.and_then(|certificate| certificate.file(title).ok())) {
        (Some(line), Some(file)) => {
            let sentences = [line, remarks, rest.to_owned()].into_iter().filter(|sentence| !sentence.is_empty());
            Evidence { sentences: sentences.collect(), file: Some(file) }
        }
        _ => Evidence {
            sentences: vec![format!("No stability certificate. {remarks}").trim_end().to_owned()],
            file: None,
        },
    }
}

/// The line of a header on what the certificate proves of something; none if that is nothing.
fn proved_line(of_what: &str, sentences: &[ProvedSentence]) -> Option<String> {
    let all: Vec<&str> = sentences.iter().map(ProvedSentence::as_str).collect();
    (!all.is_empty()).then(|| format!("Proved (certificate.json){of_what}: {}", all.join(" ")))
}
