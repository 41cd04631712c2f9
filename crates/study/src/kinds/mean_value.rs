//! The mean-value-theorem observer, with output injection or as printed.

use luenberger_design::enclosure::enclose;
use luenberger_design::lpv::Polytope;
use luenberger_design::{GainOptions, LeastSquares, MeanValueDesign, Region};
use luenberger_export::extension::RecordedObserver;
use luenberger_expression::{Recorded, Recording};
use luenberger_observers::mean_value::{Mean, MeanJacobian};
use luenberger_observers::{Beta, Integral, MeanValueObserver, ObserverError};
use luenberger_plants::Dimensions;
use nalgebra::{DVector, Dyn, convert};

use super::declaration::{Declaration, Information, Rule, Tuning};
use super::keys::{MAX_GAIN, NOISE, REGION};
use super::{Kind, as_kind};
use crate::designed::{NonlinearStep, Running, StepOf};
use crate::model::Model;
use crate::reader::Reader;
use crate::reader::tree::Node;
use crate::results::{DesignReport, NoObserver, Quantity, Statement};
use crate::steps::extension;
use crate::steps::recorded::recorded;
use crate::structure::Structure;
use crate::study::{ObserverKind, ObserverSpec, PlantClass, Specification, Study, Time};
use crate::synthesis::explain::measured_in_place_of;
use crate::synthesis::noise_gain::NoiseGain;
use crate::synthesis::{
    Designed, Plan, certified, lower_bound, matrix, number, other_kinds, proof_matrix, uncertified, upper_bound,
};
use crate::tuning::over_region;

/// The kind.
pub(super) static DECLARATION: Declaration = Declaration {
    name: "mean-value",
    about: "Mean-value-theorem observer, with output injection or as printed, for plants whose outputs are the first states.",
    source: "Ben Messaoud and Hajji 2018, eq. (3)",
    plant: PlantClass::Nonlinear(Time::OF_STATE),
    keys: &[MeanValue::KEYS],
    kind: as_kind::<MeanValue>,
    read: |given, reader| Some(MeanValue::read(given, reader)?.checked(given.node, reader)?.into()),
    takes_long: false,
    tuning: Tuning::Rules(&[Rule {
        name: "mean-value",
        turn: 15,
        tuning: "the decay rate, or half of it as often as needed, for the mean Jacobians over the region; eta = 1",
        source: "docs/theory-mvt.md",
        character: "an internal model of the error corrects the estimate",
        information: &[Information::Settling, Information::Region, Information::Noise],
        keys: |context| over_region(context, "decay_rate"),
    }]),
};

crate::keys! { |size|
    /// A mean-value-theorem observer.
    #[derive(Debug, Clone, PartialEq)]
    pub struct MeanValue {
        /// The box.
        region: Region as &REGION = Region::everywhere(size.states),
        /// Decay rate to be certified (default 0).
        decay_rate: f64 as Number(NotNegative) = 0.0,
        /// Gain eta of the internal error (default 1).
        eta: f64 as Number(Positive) = 1.0,
        /// Initial internal error, an estimate of x(0) - xhat(0), n numbers (default 0).
        internal_error: Vec<f64>[n] as Numbers(Any) = vec![0.0; size.states],
        /// The observer as printed, with the mean Jacobian computed this way. It has no certificate, because its
        /// theorem is false (default: the observer with output injection).
        as_printed: Option<PrintedMean> as Choice,
        ..[&[MAX_GAIN, NOISE]]
    }
}

crate::words! { PrintedMean {
    /// beta by bounded nonlinear least squares, as the paper computes it.
    LeastSquares = "least-squares",
    /// beta by bracketing the root of each row.
    Root = "root",
    /// The integral of the Jacobian along the segment.
    Integral = "integral",
} }

impl MeanValue {
    /// The observer as printed has no gain to be designed.
    fn checked(self, node: &Node, reader: &mut Reader) -> Option<Self> {
        let of_design = ["decay_rate", "region", "max_gain", "noise"].iter().find_map(|key| node.entry(key));
        let Some(given) = of_design.filter(|_| self.as_printed.is_some()) else { return Some(self) };
        let message = format!("`{}` has no effect: the observer as printed has no gain to be designed", given.key);
        reader.refuse(given.span.clone(), message, "expected it without `as_printed`")
    }
}

/// How the mean of the Jacobian over the segment from xhat to xhat + e is computed.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum PrintedMean {
    /// beta by bounded nonlinear least squares, as in the paper.
    LeastSquares,
    /// beta by bracketing.
    Root,
    /// The integral.
    Integral,
}

impl Specification for MeanValue {
    declared!();

    fn free_keys(&self) -> &'static [&'static str] {
        &["decay_rate", "eta"]
    }

    fn decay_rate(&self) -> Option<f64> {
        Some(self.decay_rate)
    }

    fn poses_inequality(&self) -> bool {
        true
    }

    fn region_of_design(&self) -> Option<Region> {
        Some(self.region.clone())
    }

    fn takes_region(&self) -> bool {
        true
    }

    fn faster(&self, factor: f64, _dt: Option<f64>) -> Option<ObserverKind> {
        Some(Self { decay_rate: self.decay_rate * factor, ..self.clone() }.into())
    }
}

impl Kind for MeanValue {
    fn design(&self, plan: &Plan<'_>) -> Result<Designed, NoObserver> {
        first_states_measured(plan.study, plan.requested)?;
        let Self { region, decay_rate, eta, internal_error, as_printed } = self;
        match as_printed {
            Some(mean) => with_printed_mean(&plan.study.plant.model, *mean, *eta, internal_error),
            None => mean_value(plan.study, region, *decay_rate, *eta, internal_error, &plan.options()),
        }
    }
}

impl Running for MeanValueObserver<Model, Integral, f64, Dyn, Dyn, Dyn> {
    runs!(continuous);

    // z = xhat + e has the constant gain L, and the certificate is about z.
    fn step(&self, of: &StepOf<'_>) -> Result<Option<NonlinearStep>, NoObserver> {
        let l = self.l().ok_or_else(|| NoObserver::new("the observer as printed has no constant gain"))?;
        let first = of.observer.initial.iter().zip(self.internal_error().iter()).map(|(xhat, e)| xhat + e);
        of.with_gain(l, first.collect(), "The exported estimate is z.").map(Some)
    }
}

impl Running for MeanValueObserver<Model, PrintedMean, f64, Dyn, Dyn, Dyn> {
    runs!(continuous);

    fn record(&self, of: &StepOf<'_>, recording: &mut Recording) -> Result<RecordedObserver, NoObserver> {
        let Some(MeanValue { eta, internal_error, .. }) = of.observer.kind.of() else {
            return Err(NoObserver::new("the observer has another kind"));
        };
        let start = DVector::from_column_slice(internal_error).map(convert);
        let observer =
            MeanValueObserver::<_, _, Recorded, _, _, _>::new(of.plant.clone(), convert(*eta), Integral, start);
        recorded(recording, &observer?)
    }

    fn step(&self, of: &StepOf<'_>) -> Result<Option<NonlinearStep>, NoObserver> {
        let printed = of.observer.kind.of::<MeanValue>().and_then(|spec| spec.as_printed);
        if printed == Some(PrintedMean::Integral) {
            return extension(self, of).map(Some);
        }
        let hypothesis = "the mean-value observer as printed has no export with beta by an iteration: its number of steps depends on the data";
        Err(NoObserver::new(hypothesis)
            .hint("as_printed = \"integral\", the mean of the Jacobian without an iteration")
            .hint("kind = \"mean-value\" without `as_printed`, the observer with output injection"))
    }
}

/// The first output that is not shown to be the state of its number.
fn not_measured_first(structure: &Structure, size: Dimensions) -> Option<usize> {
    (0..size.outputs.min(size.states)).find(|&k| structure.output_state(k) != Some(k))
}

fn first_states_measured(study: &Study, requested: &ObserverSpec) -> Result<(), NoObserver> {
    let size = study.plant.model.size();
    let kind = requested.kind.name();
    if size.outputs >= size.states {
        let hypothesis =
            format!("the kind {kind} needs unmeasured states; this plant measures {} of {}", size.outputs, size.states);
        return Err(NoObserver::new(hypothesis).advise(other_kinds(study, requested)));
    }
    let structure = study.plant.model.structure();
    let Some(k) = not_measured_first(&structure, size) else { return Ok(()) };
    let why = measured_in_place_of(study, &structure, k, k);
    let hypothesis = format!("the kind {kind} needs outputs that are the first states, y = (x1, .., xp): {why}");
    Err(NoObserver::new(hypothesis).advise(other_kinds(study, requested)))
}

fn mean_value(
    study: &Study,
    region: &Region,
    rate: f64,
    eta: f64,
    internal_error: &[f64],
    options: &GainOptions,
) -> Result<Designed, NoObserver> {
    let model = &study.plant.model;
    let polytope = Polytope::new(enclose(model, region)?)?;
    let design = MeanValueDesign::over(&polytope, rate, options)?;
    let names: Vec<String> = polytope.vertices.iter().map(ToString::to_string).collect();
    let observer = design.observer(model.clone(), eta, Integral, DVector::from_column_slice(internal_error))?;
    let noise = NoiseGain::of(study, polytope.vertices.iter().map(|vertex| (&vertex.a, &vertex.c)), &design.l, None);
    let mut numbers = vec![
        lower_bound(Quantity::Rate, design.rate),
        upper_bound(Quantity::Overshoot, design.overshoot),
        number("eta", eta),
        number(Quantity::Vertices, polytope.vertices.len() as f64),
    ];
    numbers.extend(noise.numbers());
    let report = DesignReport {
        statement: Statement::of_proved(polytope.enclosure.sentence(&design.certificate, region, ("z", "t")))
            .remark("z is xhat + e, with the internal error e."),
        matrices: vec![matrix("L", &design.l), proof_matrix("P", &design.p)],
        numbers,
        noise_deviation: noise.deviation,
        ..certified(&design.certificate, &names)
    };
    let runnable = observer.into();
    Ok(Designed::new(runnable, report, Some(design.certificate.clone())))
}

impl PrintedMean {
    fn words(self) -> &'static str {
        match self {
            Self::LeastSquares => "beta by bounded nonlinear least squares",
            Self::Root => "beta as the bracketed root of each row",
            Self::Integral => "the integral of the Jacobian",
        }
    }
}

/// The same expression for each mean.
macro_rules! each {
    ($mean:expr, $one:ident => $call:expr) => {
        match $mean {
            PrintedMean::LeastSquares => {
                let $one = LeastSquares::new();
                $call
            }
            PrintedMean::Root => {
                let $one = Beta;
                $call
            }
            PrintedMean::Integral => {
                let $one = Integral;
                $call
            }
        }
    };
}

type Column = DVector<f64>;

impl Mean<Model, f64, Dyn, Dyn, Dyn> for PrintedMean {
    fn mean(&self, plant: &Model, t: f64, xhat: &Column, u: &Column, e: &Column) -> MeanJacobian<f64, Dyn> {
        each!(self, one => Mean::<Model, f64, Dyn, Dyn, Dyn>::mean(&one, plant, t, xhat, u, e))
    }

    fn examine(&self, plant: &Model, t: f64, xhat: &Column, u: &Column, e: &Column) -> Result<(), ObserverError> {
        each!(self, one => Mean::<Model, f64, Dyn, Dyn, Dyn>::examine(&one, plant, t, xhat, u, e))
    }
}

/// The observer; nothing is proved of it.
fn with_printed_mean(
    model: &Model,
    mean: PrintedMean,
    eta: f64,
    internal_error: &[f64],
) -> Result<Designed, NoObserver> {
    let start = DVector::from_column_slice(internal_error);
    let observer = MeanValueObserver::new(model.clone(), eta, mean, start)?;
    let report = DesignReport {
        statement: Statement::of(format!(
            "Eq. (3) as printed, with {}. The internal error e never grows, as eta > 1/2; x - xhat tends to 0 with it where e(0) = x(0) - xhat(0).",
            mean.words()
        )),
        numbers: vec![number("eta", eta)],
        ..uncertified(
            "the theorem as printed is false, the estimation error need not tend to 0 from another e(0); without `as_printed` the observer with output injection is designed",
        )
    };
    Ok(Designed::new(observer.into(), report, None))
}
