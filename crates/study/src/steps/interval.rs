//! The interval observer on a target: its state is the estimate with the half-widths of its bounds, and rho.

use luenberger_design::{
    DisturbanceBounds, ErrorCoordinates, IntervalRequirements, SampledIntervalDesign, TimeDomain, least_width_gain,
};
use luenberger_export::step::RecordedStep;
use luenberger_export::{ExportError, Scalar};
use luenberger_expression::{Recorded, record};
use luenberger_observers::{ObserverDimensions, SampledIntervalObserver, SampledObserver};
use luenberger_plants::StateSpace;
use luenberger_proof::statement::Format;
use nalgebra::{DMatrix, DVector, Dyn};

use super::{Evidence, proved_line};
use crate::designed::IntervalDeployment;
use crate::operation;
use crate::results::NoObserver;
use crate::study::{ActingBounds, ObserverSpec, Study};

impl IntervalDeployment {
    /// The design of the study for binary64, and one with its gain for binary32.
    pub(crate) fn of_discrete(
        study: &Study,
        observer: &ObserverSpec,
        coordinates: (ErrorCoordinates, &[f64]),
        (plant, designed): (&StateSpace, &SampledIntervalDesign),
        period: f64,
    ) -> Self {
        let gain = Some(designed.observer.gains().l.clone());
        let operation = operation::largest(study, observer);
        let sampling = SampledPlant { plant, gain, period, held: false, operation, format: Format::Binary32 };
        let found = sampled_design(&sampling, coordinates, observer.bounds.as_ref());
        Self { binary32: found.map_err(NoObserver::from), binary64: designed.clone() }
    }

    /// The designs of a specification with the gain for samples; none for that of the least width.
    ///
    /// # Errors
    /// Why there is none in binary64.
    pub(crate) fn new(
        study: &Study,
        observer: &ObserverSpec,
        (coordinates, first): (ErrorCoordinates, &[f64]),
        (plant, gain): (&StateSpace, Option<DMatrix<f64>>),
        period: f64,
    ) -> Result<Self, NoObserver> {
        if plant.d.is_some() {
            return Err(NoObserver::new(WITH_FEEDTHROUGH));
        }
        let operation = operation::largest(study, observer);
        let of = |format| {
            let sampling = SampledPlant {
                plant,
                gain: gain.clone(),
                period,
                held: study.plant.dt.is_none(),
                operation: operation.clone(),
                format,
            };
            sampled_design(&sampling, (coordinates, first), observer.bounds.as_ref()).map_err(NoObserver::from)
        };
        let binary64 = of(Format::Binary64)?;
        Ok(Self { binary32: of(Format::Binary32), binary64 })
    }

    fn of(&self, format: Format) -> Result<&SampledIntervalDesign, &NoObserver> {
        if format == Format::Binary32 { self.binary32.as_ref() } else { Ok(&self.binary64) }
    }

    /// The step of a format.
    pub(crate) fn program(&self, scalar: Scalar) -> Result<RecordedStep<f64>, ExportError> {
        let refused = |why: String| ExportError::NoStep { why, format: scalar.name() };
        let design = self.of(format(scalar)).map_err(|why| refused(why.to_string()))?;
        program(&design.observer).map_err(refused)
    }

    /// The state of the step for a first estimate: the estimate, the half-widths and rho.
    pub(crate) fn start(&self, scalar: Scalar, xhat: &[f64]) -> Vec<f64> {
        let Ok(design) = self.of(format(scalar)) else { return xhat.to_vec() };
        let gains = design.observer.gains();
        let state: Vec<f64> = xhat.iter().chain(gains.start.iter()).copied().collect();
        let widths = design.observer.half_widths(&state);
        xhat.iter().chain(widths.iter()).chain(gains.start.iter()).copied().collect()
    }

    /// The names of the states of the step beside the plant's.
    pub(crate) fn names(&self, states: &[String]) -> Vec<String> {
        let blocks = self.binary64.blocks.len();
        let widths = states.iter().map(|state| format!("{state}_half_width"));
        widths.chain((1..=blocks).map(|k| format!("rho{k}"))).collect()
    }

    pub(crate) fn evidence(&self, study: &Study, observer: &ObserverSpec, format: Format) -> Evidence {
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

/// Why there is no step for outputs with D.
pub(crate) const WITH_FEEDTHROUGH: &str = "the kind interval has no step for outputs with feedthrough D";

/// The bounds of a specification; the reader asks for them.
pub(crate) fn bounds(given: Option<&ActingBounds>, plant: &StateSpace) -> ActingBounds {
    given.cloned().unwrap_or_else(|| ActingBounds {
        noise: vec![0.0; plant.c.nrows()],
        disturbance: Vec::new(),
        e: DMatrix::zeros(plant.a.nrows(), 0),
        uncertain: None,
    })
}

/// What the sampled observer is designed for: a plant in discrete time, or one in continuous time whose input is held.
pub(crate) struct SampledPlant<'a> {
    /// The plant as it is given.
    pub(crate) plant: &'a StateSpace,
    /// The gain for samples; none for the one of the least width.
    pub(crate) gain: Option<DMatrix<f64>>,
    pub(crate) period: f64,
    /// Whether the plant is in continuous time.
    pub(crate) held: bool,
    /// Bounds of |x| and |u| in operation.
    pub(crate) operation: (Vec<f64>, Vec<f64>),
    pub(crate) format: Format,
}

pub(crate) fn sampled_design(
    sampling: &SampledPlant<'_>,
    (coordinates, first): (ErrorCoordinates, &[f64]),
    given: Option<&ActingBounds>,
) -> Result<SampledIntervalDesign, luenberger_design::DesignError> {
    let SampledPlant { plant, gain, period, held, operation, format } = sampling;
    let bounds = bounds(given, plant);
    let kept = IntervalRequirements {
        initial_error: first.to_vec(),
        estimates: operation.0.clone(),
        inputs: operation.1.clone(),
        format: *format,
    };
    let gain = if let Some(gain) = gain {
        gain.clone()
    } else {
        // Of the plant between samples, its disturbance held as well.
        let (a, e) = if *held {
            let sampled = luenberger_linalg::zero_order_hold(&plant.a, &bounds.e, *period)?;
            (sampled.ad, sampled.bd)
        } else {
            (plant.a.clone(), bounds.e.clone())
        };
        let acting = DisturbanceBounds::of_states_and_outputs(&e, &bounds.disturbance, &bounds.noise);
        least_width_gain(&a, &plant.c, &acting, TimeDomain::Discrete)?
    };
    let acting = DisturbanceBounds::of_states_and_outputs(&bounds.e, &bounds.disturbance, &bounds.noise);
    if *held {
        SampledIntervalDesign::sampled(plant, *period, &gain, &acting, coordinates, &kept)
    } else {
        SampledIntervalDesign::of_discrete(plant, *period, &gain, &acting, coordinates, &kept)
    }
}

/// The step of a sampled interval observer, whose state is the estimate, the half-widths of its bounds and rho.
///
/// # Errors
/// None is expected of an observer that was made.
pub(crate) fn program(
    observer: &SampledIntervalObserver<f64, Dyn, Dyn, Dyn, Dyn, Dyn>,
) -> Result<RecordedStep<f64>, String> {
    record(|recording| {
        let same = observer.cast::<Recorded>().map_err(|error| error.to_string())?;
        let c = &same.gains().c;
        let n = c.ncols();
        let size = same.dimensions();
        let size = ObserverDimensions { state: size.state + n, estimate: size.state + n, ..size };
        let step = |t, z: &[Recorded], u: &[Recorded], y: &[Recorded]| {
            let (xhat, rho) = (z.iter().take(n), z.iter().skip(2 * n));
            let mut state = DVector::from_vec(xhat.chain(rho).copied().collect());
            same.step(t, &mut state, &DVector::from_column_slice(u), &DVector::from_column_slice(y));
            let widths = same.half_widths(state.as_slice());
            let (xhat, rho) = (state.iter().take(n), state.iter().skip(n));
            xhat.chain(widths.iter()).chain(rho).copied().collect()
        };
        let output = |_, z: &[Recorded]| (c * DVector::from_iterator(n, z.iter().take(n).copied())).as_slice().to_vec();
        RecordedStep::new(recording, size, observer.period(), step, output).map_err(|error| error.to_string())
    })
}
