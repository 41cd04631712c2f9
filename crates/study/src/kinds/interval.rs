//! The interval observer: bounds that enclose the state, in continuous time and for samples.

use luenberger_design::{DesignError, DisturbanceBounds, ErrorCoordinates, GainOptions, IntervalDesign};
use luenberger_live as live;
use luenberger_observers::{ComparisonSystem, IntervalObserver, LinearObserver, SampledIntervalObserver};
use luenberger_plants::StateSpace;
use luenberger_proof::certificate::Reading;
use luenberger_proof::statement::Format;
use nalgebra::{DMatrix, DVector, Dyn};

use super::declaration::{Declaration, Information, Rule, Tuning};
use super::keys::{ERROR_BOUNDS, GAINS, OF_GAIN};
use super::{Kind, as_kind};
use crate::designed::{IntervalDeployment, Origin, Running, SampledDesign, rows};
use crate::keys::{Key, Type, optional};
use crate::operation;
use crate::reader::tree::Node;
use crate::reader::{Given, Reader, gain};
use crate::results::{Advice, Cause, DesignReport, NamedNumber, NoObserver, Proposal};
use crate::steps::{self, SampledPlant, WITH_FEEDTHROUGH, bounds, sampled_design};
use crate::study::{ActingBounds, LinearSpec, ObserverKind, PlantClass, Specification, Study, Time};
use crate::synthesis::error_bound::acting;
use crate::synthesis::linear::{self, measurement};
use crate::synthesis::{
    Designed, Plan, Sampling, certified, discrete, lower_bound, matrix, poles, proved_of, upper_bound,
};
use crate::tuning::{Context, Keys, Value, poles as tuned_poles};

/// An observer of upper and lower bounds.
type Enclosing = IntervalObserver<LinearObserver<f64, Dyn, Dyn, Dyn>, f64, Dyn, Dyn, Dyn>;

/// The kind.
pub(super) static DECLARATION: Declaration = Declaration {
    name: "interval",
    about: "Interval observer, for linear plants: a lower and an upper bound of each state under bounded noise and disturbances, proved to enclose it.",
    source: "Gouze, Rapaport and Hadj-Sadok 2000; Mazenc and Bernard 2011; the least width after Briat 2013",
    plant: PlantClass::Linear(Time::ANY),
    keys: &[IntervalSpec::KEYS],
    kind: as_kind::<IntervalSpec>,
    read: |given, reader| Some(IntervalSpec::read(given, reader)?.into()),
    takes_long: false,
    tuning: Tuning::Rules(&[Rule {
        name: "interval",
        turn: 9,
        tuning: "the poles of luenberger; its bounds are for noise up to its amplitude, or to four standard deviations if it is Gaussian, and for x(0) anywhere in the region",
        source: "docs/disturbances.md",
        character: "its estimate is that of its gain alone, and the bounds that enclose the state come with it",
        information: &[Information::Settling, Information::Noise, Information::Region, Information::Bounds],
        keys: tuned,
    }]),
};

crate::keys! {
    /// An interval observer.
    #[derive(Debug, Clone, PartialEq)]
    pub struct IntervalSpec {
        /// Bounds of |x(0) - initial|, n numbers: the box in which the first state lies.
        initial_bounds: Vec<f64>[n] as Numbers(NotNegative),
        /// The gain; none for the one of the least width.
        gain: Option<LinearSpec> as [GAINS, &[LEAST_WIDTH], OF_GAIN] => gain_or_least_width,
        /// Coordinates in which the error is bounded (default modal; with least_width plant).
        coordinates: ErrorCoordinates as Choice =
            if matches!(gain, Some(None)) { ErrorCoordinates::Plant } else { ErrorCoordinates::Modal },
        ..[&[BOUNDS]]
    }
}

const BOUNDS: Key = Key {
    required: true,
    about: "Bounds of noise and disturbances, which are all that is known of them: bounds = { noise = [0.1] }, with one number per output, and with `disturbance` and `e` where disturbances act.",
    ..ERROR_BOUNDS
};

crate::words! { ErrorCoordinates {
    /// Those of the eigenvectors of A - L C; the poles have to be distinct.
    Modal = "modal",
    /// The states themselves: for A - L C that are Metzler, or nearly so.
    Plant = "plant",
} }

const LEAST_WIDTH: Key = optional(
    "least_width",
    Type::Switch,
    "true: the gain for which the sum of the half-widths in the end is least, in the coordinates of the plant, by a linear program (a sum up to one per cent larger is allowed for a smaller gain).",
);

#[expect(clippy::option_option, reason = "wrong, of the least width, or given")]
fn gain_or_least_width(given: &Given<'_>, reader: &mut Reader) -> Option<Option<LinearSpec>> {
    let node = given.node;
    let Some(entry) = node.entry(LEAST_WIDTH.name).filter(|entry| entry.node.truth() == Some(true)) else {
        return gain::linear(given, reader).map(Some);
    };
    if let Some(gain) = GAINS.iter().find_map(|key| node.entry(key.name)) {
        let message = format!("`{}` conflicts with `least_width`", gain.key);
        return reader.refuse(gain.span.clone(), message, "expected one of them");
    }
    if node.get("coordinates").and_then(Node::text) == Some("modal") {
        let message = "`least_width` is the gain for the coordinates of the plant, and `coordinates` is \"modal\"";
        let expected = "expected coordinates = \"plant\", or another specification of the gain";
        return reader.refuse(entry.span.clone(), message, expected);
    }
    Some(None)
}

impl Specification for IntervalSpec {
    declared!();

    fn gain(&self) -> Option<&LinearSpec> {
        self.gain.as_ref()
    }

    fn poses_inequality(&self) -> bool {
        self.gain.as_ref().is_none_or(LinearSpec::poses_inequality)
    }

    fn first_bounds(&self) -> Option<&[f64]> {
        Some(&self.initial_bounds)
    }

    fn faster(&self, factor: f64, dt: Option<f64>) -> Option<ObserverKind> {
        Some(Self { gain: self.gain.as_ref().map(|gain| gain.faster(factor, dt)), ..self.clone() }.into())
    }
}

impl Kind for IntervalSpec {
    fn design(&self, plan: &Plan<'_>) -> Result<Designed, NoObserver> {
        let plant = plan.linear()?;
        let bounds = plan.requested.bounds.as_ref();
        continuous_design((plant, &plan.reading()), self, bounds, &plan.options())
    }

    fn design_in_discrete_time(&self, plan: &Plan<'_>, dt: f64) -> Result<Designed, NoObserver> {
        let plant = plan.linear()?;
        if plant.d.is_some() {
            return Err(NoObserver::new(WITH_FEEDTHROUGH).hint("y - D u as the output"));
        }
        let gain = match &self.gain {
            Some(gain) => Some(discrete::gain_of(plan, plant, (gain, dt))?.observer.l().clone()),
            None => None,
        };
        let sampled = SampledPlant {
            plant,
            gain,
            period: dt,
            held: false,
            operation: operation::largest(plan.study, plan.requested),
            format: Format::Binary64,
        };
        let bounds = plan.requested.bounds.as_ref();
        discrete_design((plant, &plan.reading()), &sampled, self, bounds)
    }

    fn advice(&self, _plan: &Plan<'_>, cause: &Cause) -> Option<Advice> {
        let Cause::Design(error) = cause else { return None };
        Some(match error {
            DesignError::Undecided { .. } | DesignError::NoLeastWidth { .. } => {
                Advice::hint("`poles`, with modal coordinates")
            }
            DesignError::NoModalCoordinates { .. } | DesignError::DependentModes { .. } => {
                Advice::of([in_coordinates("plant")]).and(Advice::hint("distinct `poles`"))
            }
            DesignError::WidthGrows { plant: true, .. } => Advice::of([
                in_coordinates("modal"),
                Proposal::keys(
                    ["least_width = true".to_owned()],
                    &["poles", "decay_rate", "lmi", "kalman", "gain", "coordinates"],
                    "a gain with a stable width",
                ),
            ]),
            DesignError::WidthGrows { plant: false, .. } | DesignError::ComparisonUndecided => {
                Advice::hint("faster or more separate `poles`")
            }
            DesignError::QuietOutput { .. } => {
                Advice::hint("`noise` in `bounds` with a bound above 0 for each output, or `poles`")
            }
            _ => return None,
        })
    }

    fn sampled(&self, of: &Sampling<'_>) -> Result<Option<SampledDesign>, NoObserver> {
        let Some(plant) = of.plant() else { return Ok(None) };
        let (plan, coordinates) = (&of.plan, (self.coordinates, self.initial_bounds.as_slice()));
        let deployed = if let Some(Origin::Interval(designed)) = of.designed.map(|designed| &designed.origin) {
            let found = (plant, designed.as_ref());
            IntervalDeployment::of_discrete(plan.study, plan.requested, coordinates, found, of.period)
        } else {
            let gain = match (&self.gain, plan.study.plant.dt) {
                (None, _) => None,
                (Some(gain), Some(dt)) => Some(discrete::gain_of_step(plan, plant, gain, dt)?.observer.l().clone()),
                (Some(gain), None) => {
                    let linear = linear::linear_design(plant, gain, &plan.options())?;
                    Some(steps::sampled_linear(&linear, gain, of.period)?.l().clone())
                }
            };
            IntervalDeployment::new(plan.study, plan.requested, coordinates, (plant, gain), of.period)?
        };
        Ok(Some(SampledDesign::Interval(Box::new(deployed))))
    }
}

/// The same bounds in other coordinates.
fn in_coordinates(coordinates: &str) -> Proposal {
    Proposal::keys([format!("coordinates = \"{coordinates}\"")], &["coordinates"], "the error bounded in these")
}

fn numbers(names: &[String], widths: &[f64]) -> Vec<NamedNumber> {
    names
        .iter()
        .zip(widths)
        .map(|(name, width)| upper_bound(&format!("half-width of {name} in the end"), *width))
        .collect()
}

fn continuous_design(
    (plant, reading): (&StateSpace, &Reading<'_>),
    spec: &IntervalSpec,
    given: Option<&ActingBounds>,
    options: &GainOptions,
) -> Result<Designed, NoObserver> {
    let acting: DisturbanceBounds = acting(&bounds(given, plant));
    let design = match &spec.gain {
        Some(gain) => {
            let linear = linear::linear_design(plant, gain, options)?;
            IntervalDesign::new(&linear.observer, &acting, spec.coordinates, &spec.initial_bounds)?
        }
        None => IntervalDesign::least_width(plant, &acting, &spec.initial_bounds)?,
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
        poles: poles(&luenberger_linalg::eigenvalues(&flow).map_err(DesignError::from)?),
        numbers: std::iter::once(lower_bound("rate of the width", design.rate))
            .chain(numbers(reading.states, &design.widths))
            .collect(),
        ..certified(&design.certificate, &[])
    };
    let runnable = design.observer.clone();
    Ok(Designed::new(runnable.into(), report, Some(design.certificate.clone())))
}

fn discrete_design(
    (plant, reading): (&StateSpace, &Reading<'_>),
    sampling: &SampledPlant<'_>,
    spec: &IntervalSpec,
    given: Option<&ActingBounds>,
) -> Result<Designed, NoObserver> {
    let design = sampled_design(sampling, (spec.coordinates, &spec.initial_bounds), given)?;
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
        poles: poles(&luenberger_linalg::eigenvalues(&flow).map_err(DesignError::from)?),
        numbers: std::iter::once(upper_bound("factor of the width", design.factor))
            .chain(numbers(reading.states, &design.widths))
            .collect(),
        ..certified(&design.certificate, &[])
    };
    let runnable = design.observer.clone().into();
    let certificate = Some(design.certificate.clone());
    Ok(Designed { runnable, report, certificate, origin: Origin::Interval(Box::new(design)) })
}

impl Running for Enclosing {
    runs!(continuous);

    fn half_widths_of(&self, state: &[f64]) -> Option<DVector<f64>> {
        Some(self.half_widths(state))
    }

    fn live(&self, _study: &Study) -> Option<(live::ObserverKind, Option<live::OperatingPoint>)> {
        let ComparisonSystem { k, g, h, start } = self.comparison();
        let (k, h) = (rows(k), rows(h));
        let [g, start] = [g, start].map(|entries| entries.as_slice().to_vec());
        Some((live::ObserverKind::Interval { observer: Box::new(self.inner().clone()), k, g, h, start }, None))
    }

    fn first_widths(&self) -> Option<&[f64]> {
        Some(self.comparison().start.as_slice())
    }
}

impl Running for SampledIntervalObserver<f64, Dyn, Dyn, Dyn, Dyn, Dyn> {
    runs!(sampled);

    fn half_widths_of(&self, state: &[f64]) -> Option<DVector<f64>> {
        Some(self.half_widths(state))
    }
}

fn tuned(context: &Context<'_>) -> Result<Vec<Keys>, String> {
    let mut keys = tuned_poles(context, 0)?;
    let information = context.information;
    let first = information
        .initial
        .iter()
        .zip(information.region.states())
        .map(|(x, (low, high))| (high - x).max(x - low).max(0.0));
    let mut bounds = vec![("noise", Value::numbers(information.largest.iter().copied()))];
    if let Some((disturbance, e)) = &information.acting {
        bounds.push(("disturbance", Value::numbers(disturbance.iter().copied())));
        bounds.push(("e", Value::rows(e)));
    }
    keys.push(("initial_bounds", Value::numbers(first)));
    keys.push(("bounds", Value::Table(bounds)));
    Ok(vec![keys])
}
