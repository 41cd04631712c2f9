//! The interval observer: bounds that enclose the state, in continuous time and for samples.

use luenberger_design::{
    DisturbanceBounds, ErrorCoordinates, GainOptions, IntervalDesign, IntervalRequirements, SampledIntervalDesign,
    TimeDomain, least_width_gain,
};
use luenberger_plants::StateSpace;
use luenberger_proof::certificate::Reading;
use luenberger_proof::statement::Format;
use nalgebra::DMatrix;

use super::error_bound::acting;
use super::explain::Misfit;
use super::linear::{measurement, of};
use super::{Designed, certified, lower_bound, matrix, poles, proved_of, upper_bound};
use crate::designed::Origin;
use crate::results::{DesignReport, NamedNumber};
use crate::runnable::Runnable;
use crate::study::{ActingBounds, IntervalSpec};

/// The bounds of a specification; the reader asks for them.
fn bounds(given: Option<&ActingBounds>, plant: &StateSpace) -> ActingBounds {
    given.cloned().unwrap_or_else(|| ActingBounds {
        noise: vec![0.0; plant.c.nrows()],
        disturbance: Vec::new(),
        e: DMatrix::zeros(plant.a.nrows(), 0),
        uncertain: None,
    })
}

fn numbers(names: &[String], widths: &[f64]) -> Vec<NamedNumber> {
    names
        .iter()
        .zip(widths)
        .map(|(name, width)| upper_bound(&format!("half-width of {name} in the end"), *width))
        .collect()
}

pub(super) fn continuous(
    (plant, reading): (&StateSpace, &Reading<'_>),
    spec: &IntervalSpec,
    given: Option<&ActingBounds>,
    options: &GainOptions,
) -> Result<Designed, Misfit> {
    let acting: DisturbanceBounds = acting(&bounds(given, plant));
    let design = match &spec.gain {
        Some(gain) => {
            let linear = of(plant, gain, options)?;
            IntervalDesign::new(&linear.observer, &acting, spec.coordinates, &spec.first)?
        }
        None => IntervalDesign::least_width(plant, &acting, &spec.first)?,
    };
    let inner = design.observer.inner();
    let flow = &inner.a - &inner.l * &inner.c;
    let comparison = design.observer.comparison();
    let is_metzler = (0..flow.nrows()).all(|i| (0..flow.nrows()).all(|j| i == j || flow[(i, j)] >= 0.0));
    let metzler = match spec.coordinates {
        ErrorCoordinates::Plant if is_metzler => "A - L C is Metzler.",
        ErrorCoordinates::Plant => "A - L C is not Metzler: K is the Metzler matrix above it.",
        ErrorCoordinates::Modal => "",
    };
    let report = DesignReport {
        statement: proved_of(&design.certificate, reading).remark(metzler).remark(measurement(plant)),
        matrices: vec![
            matrix("L", &inner.l),
            matrix("T", &design.t),
            matrix("K", &comparison.k),
            matrix("g", &DMatrix::from_column_slice(comparison.g.len(), 1, comparison.g.as_slice())),
            matrix("H", &comparison.h),
        ],
        poles: poles(&luenberger_linalg::eigenvalues(&flow).map_err(luenberger_design::DesignError::from)?),
        numbers: std::iter::once(lower_bound("rate of the width", design.rate))
            .chain(numbers(reading.states, &design.widths))
            .collect(),
        ..certified(&design.certificate, &[])
    };
    let runnable = Runnable::Interval(Box::new(design.observer.clone()));
    Ok(Designed::new(runnable, report, Some(design.certificate.clone())))
}

/// What the sampled observer is designed for: a plant in discrete time, or one in continuous time whose input is held.
pub(crate) struct Sampling<'a> {
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
    sampling: &Sampling<'_>,
    spec: &IntervalSpec,
    given: Option<&ActingBounds>,
) -> Result<SampledIntervalDesign, luenberger_design::DesignError> {
    let Sampling { plant, gain, period, held, operation, format } = sampling;
    let bounds = bounds(given, plant);
    let kept = IntervalRequirements {
        initial_error: spec.first.clone(),
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
        SampledIntervalDesign::sampled(plant, *period, &gain, &acting, spec.coordinates, &kept)
    } else {
        SampledIntervalDesign::of_discrete(plant, *period, &gain, &acting, spec.coordinates, &kept)
    }
}

pub(super) fn discrete(
    (plant, reading): (&StateSpace, &Reading<'_>),
    sampling: &Sampling<'_>,
    spec: &IntervalSpec,
    given: Option<&ActingBounds>,
) -> Result<Designed, Misfit> {
    let design = sampled_design(sampling, spec, given)?;
    let gains = design.observer.gains();
    let flow = &gains.f - &gains.l * &gains.c;
    let report = DesignReport {
        statement: proved_of(&design.certificate, reading).remark(measurement(plant)),
        matrices: vec![
            matrix("L", &gains.l),
            matrix("T", &design.t),
            matrix("N", &gains.blocks),
            matrix("g", &DMatrix::from_column_slice(gains.constant.len(), 1, gains.constant.as_slice())),
            matrix("H", &gains.h),
        ],
        poles: poles(&luenberger_linalg::eigenvalues(&flow).map_err(luenberger_design::DesignError::from)?),
        numbers: std::iter::once(upper_bound("factor of the width", design.factor))
            .chain(numbers(reading.states, &design.widths))
            .collect(),
        ..certified(&design.certificate, &[])
    };
    Ok(Designed {
        runnable: Runnable::SampledInterval(Box::new(design.observer.clone())),
        report,
        certificate: Some(design.certificate.clone()),
        origin: Origin::Interval(Box::new(design)),
    })
}
