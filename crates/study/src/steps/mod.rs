//! The steps of observers for samples, of which exports are made: what the kinds share.
//!
//! | file | subject |
//! |---|---|
//! | `nonlinear` | observers of nonlinear plants with a step for each sample, and what is proved of them |
//! | `fixed_steps` | how many Runge-Kutta steps a period needs, and their error |
//! | `interval` | the interval observer |
//! | `expressions` | the plant as expressions, which can be printed as source code |
//! | `recorded` | observers as programs |

mod expressions;
mod fixed_steps;
mod interval;
mod nonlinear;
pub(crate) mod recorded;

pub(crate) use interval::{SampledPlant, WITH_FEEDTHROUGH, bounds, sampled_design};
pub(crate) use nonlinear::{extension, filter_step, steps_for};

use luenberger_design::{Certificate, DesignError, DiscreteDesign, LinearDesign, OperatingPoint};
use luenberger_export::ExportableObserver;
use luenberger_linalg::spectral_radius;
use luenberger_observers::{DiscreteNonlinearObserver, SampledObserver};
use luenberger_plants::StateSpace;
use luenberger_proof::certificate::{CertificateFile, ProvedSentence, Reading};
use luenberger_proof::statement::Format;
use luenberger_proof::wording::at_least;
use nalgebra::{DMatrix, DVector};

use crate::designed::{Designed, NonlinearStep, SampledDesign};
use crate::results::{NoObserver, Statement};
use crate::study::{GainSpec, LinearSpec, ObserverSpec};
use crate::synthesis::{Sampling, discrete};

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

    /// The gain K of the measurement update, of an observer in filter form.
    pub fn update_gain(&self, observer: &ObserverSpec) -> Option<&DMatrix<f64>> {
        match self {
            Self::Linear(design) if observer.kind.updates(Some(design.observer.period())) => design.update_gain(),
            _ => None,
        }
    }

    /// Whether the estimate after a step is that of its sample.
    pub(crate) fn is_of_sample(&self, observer: &ObserverSpec) -> bool {
        let program = if let Self::Nonlinear(step) = self { Some(&step.observer) } else { None };
        self.update_gain(observer).is_some()
            || matches!(program, Some(ExportableObserver::Step(step)) if step.is_of_sample())
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
    /// [`NoObserver`] with the spectral radius of `A - L C`; none for a number that the format cannot store, which
    /// is an error of the export.
    pub fn stored_in(&self, observer: &ObserverSpec, format: Format) -> Result<(), NoObserver> {
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
                Err(NoObserver::new(hypothesis)
                    .at(observer.place.line)
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

/// The sampled design of an observer of a linear plant that its gain alone determines.
pub(crate) fn of_gain(of: &Sampling<'_>, gain: &LinearSpec) -> Result<Option<SampledDesign>, NoObserver> {
    let Some(plant) = of.plant() else { return Ok(None) };
    if let Some(design) = of.designed.and_then(Designed::sampled) {
        return Ok(Some(design.clone()));
    }
    let design = if let Some(dt) = of.plan.study.plant.dt {
        discrete::gain_of_step(&of.plan, plant, gain, dt)?
    } else {
        let linear = of.linear(plant, gain)?;
        sampled_linear(&linear, gain, of.period)?
    };
    Ok(Some(SampledDesign::Linear(Box::new(design))))
}

/// The same of an observer of the linearisation at an operating point.
pub(crate) fn of_gain_at_point(
    of: &Sampling<'_>,
    gain: &LinearSpec,
    point: &OperatingPoint,
) -> Result<SampledDesign, NoObserver> {
    if gain.is_filter {
        let name = &of.plan.requested.name;
        let hypothesis = format!("{name} is in filter form, which has no export at an operating point");
        return Err(NoObserver::new(hypothesis).hint("form = \"predictor\""));
    }
    let linear = of.linear(&point.linear, gain)?;
    around(&sampled_linear(&linear, gain, of.period)?, point, (of.period, &of.plan.reading()))
}

/// A sampled linear design in deviations from an operating point.
pub(crate) fn around(
    sampled: &DiscreteDesign,
    point: &OperatingPoint,
    (period, reading): (f64, &Reading<'_>),
) -> Result<SampledDesign, NoObserver> {
    let plant = expressions::around(sampled.observer.plant(), point)?;
    let statement = Statement::of("The linearisation at the operating point is sampled with the input held.")
        .proved(sampled.certificate.sentences(reading))
        .remark("Nothing is proved of the nonlinear plant.");
    Ok(SampledDesign::Nonlinear(Box::new(NonlinearStep {
        observer: ExportableObserver::Discrete(DiscreteNonlinearObserver::new(plant, sampled.l().clone(), period)?),
        initial: None,
        names: None,
        certificate: Some(sampled.certificate.clone()),
        statement,
        remark: "",
        step_error: String::new(),
    })))
}

/// The linear design for samples.
pub(crate) fn sampled_linear(
    linear: &LinearDesign,
    gain: &LinearSpec,
    period: f64,
) -> Result<DiscreteDesign, DesignError> {
    match &gain.gain {
        GainSpec::Kalman(noise) => DiscreteDesign::sampled_kalman_of(&linear.observer.plant(), period, noise),
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

/// The statement of a design, with what it leaves open.
pub(crate) fn of_statement(
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
pub(crate) fn proved_line(of_what: &str, sentences: &[ProvedSentence]) -> Option<String> {
    let all: Vec<&str> = sentences.iter().map(ProvedSentence::as_str).collect();
    (!all.is_empty()).then(|| format!("Proved (certificate.json){of_what}: {}", all.join(" ")))
}
