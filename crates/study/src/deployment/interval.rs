//! The interval observer on a target: its state is the estimate with the half-widths of its bounds, and rho.

use luenberger_design::SampledIntervalDesign;
use luenberger_export::step::RecordedStep;
use luenberger_export::{ExportError, Scalar};
use luenberger_plants::StateSpace;
use luenberger_proof::statement::Format;
use nalgebra::DMatrix;

use super::{Evidence, proved_line};
use crate::design::{Sampling, sampled_interval};
use crate::operation;
use crate::study::{IntervalSpec, ObserverSpec, Study};

/// The designs for both formats: the entries that cover rounding depend on it.
#[derive(Debug, Clone)]
pub struct IntervalDeployment {
    binary32: Result<SampledIntervalDesign, String>,
    binary64: Result<SampledIntervalDesign, String>,
}

impl IntervalDeployment {
    /// The design of the study for binary64, and one with its gain for binary32.
    pub(super) fn of_discrete(
        study: &Study,
        observer: &ObserverSpec,
        spec: &IntervalSpec,
        (plant, designed): (&StateSpace, &SampledIntervalDesign),
        period: f64,
    ) -> Self {
        let gain = Some(designed.observer.gains().l.clone());
        let operation = operation::largest(study, observer);
        let sampling = Sampling { plant, gain, period, held: false, operation, format: Format::Binary32 };
        let binary32 = sampled_interval(&sampling, spec, observer.bounds.as_ref()).map_err(|error| error.to_string());
        Self { binary32, binary64: Ok(designed.clone()) }
    }

    /// The designs of a specification with the gain for samples; none for that of the least width.
    ///
    /// # Errors
    /// Why there is none in binary64.
    pub(super) fn new(
        study: &Study,
        observer: &ObserverSpec,
        spec: &IntervalSpec,
        (plant, gain): (&StateSpace, Option<DMatrix<f64>>),
        period: f64,
    ) -> Result<Self, String> {
        if plant.d.is_some() {
            return Err("the kind interval has no step for outputs with feedthrough D".to_owned());
        }
        let operation = operation::largest(study, observer);
        let of = |format| {
            let sampling = Sampling {
                plant,
                gain: gain.clone(),
                period,
                held: study.plant.dt.is_none(),
                operation: operation.clone(),
                format,
            };
            sampled_interval(&sampling, spec, observer.bounds.as_ref()).map_err(|error| error.to_string())
        };
        let binary64 = Ok(of(Format::Binary64)?);
        Ok(Self { binary32: of(Format::Binary32), binary64 })
    }

    fn of(&self, format: Format) -> Result<&SampledIntervalDesign, &str> {
        let found = if format == Format::Binary32 { &self.binary32 } else { &self.binary64 };
        found.as_ref().map_err(String::as_str)
    }

    /// The step of a format.
    pub(super) fn program(&self, scalar: Scalar) -> Result<RecordedStep<f64>, ExportError> {
        let refused = |why: String| ExportError::NoStep { why, format: scalar.name() };
        let design = self.of(format(scalar)).map_err(|why| refused(why.to_owned()))?;
        super::recorded::interval(&design.observer).map_err(refused)
    }

    /// The state of the step for a first estimate: the estimate, the half-widths and rho.
    pub(super) fn start(&self, scalar: Scalar, xhat: &[f64]) -> Vec<f64> {
        let Ok(design) = self.of(format(scalar)) else { return xhat.to_vec() };
        let gains = design.observer.gains();
        let state: Vec<f64> = xhat.iter().chain(gains.start.iter()).copied().collect();
        let widths = design.observer.half_widths(&state);
        xhat.iter().chain(widths.iter()).chain(gains.start.iter()).copied().collect()
    }

    /// The names of the states of the step beside the plant's.
    pub(super) fn names(&self, states: &[String]) -> Vec<String> {
        let blocks = self.binary64.as_ref().map_or(0, |design| design.blocks.len());
        let widths = states.iter().map(|state| format!("{state}_half_width"));
        widths.chain((1..=blocks).map(|k| format!("rho{k}"))).collect()
    }

    pub(super) fn evidence(&self, study: &Study, observer: &ObserverSpec, format: Format) -> Evidence {
        let design = match self.of(format) {
            Ok(design) => design,
            Err(why) => return Evidence { sentences: vec![format!("No stability certificate: {why}.")], file: None },
        };
        let layout = "State of the step: the estimate, then the half-widths r of its bounds, then rho. Start from xhat with r and rho of the first state, as written here.".to_owned();
        match design.certificate.file(&observer.name) {
            Ok(file) => Evidence {
                sentences: [
                    proved_line(", for the step as it runs", &design.certificate.sentences(&study.plant.reading())),
                    Some(layout),
                ]
                .into_iter()
                .flatten()
                .collect(),
                file: Some(file),
            },
            Err(error) => {
                Evidence { sentences: vec![format!("No stability certificate: {error}."), layout], file: None }
            }
        }
    }
}

fn format(scalar: Scalar) -> Format {
    match scalar {
        Scalar::Binary32 => Format::Binary32,
        Scalar::Binary64 => Format::Binary64,
    }
}
