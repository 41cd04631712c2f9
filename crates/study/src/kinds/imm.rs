//! The interacting multiple model filter.

use std::sync::Arc;

use luenberger_export::extension::RecordedObserver;
use luenberger_expression::Recording;
use luenberger_observers::{ExtendedKalmanFilter, InteractingMultipleModel, NoiseModel, Prediction};
use luenberger_proof::wording::counted;
use luenberger_sim::Replay;
use nalgebra::{DMatrix, DVector, Dyn};

use super::declaration::{Declaration, Tuning};
use super::filter::STAGES;
use super::keys::{PERIOD, V, W};
use super::{Kind, as_kind};
use crate::designed::{self, Running, StepOf};
use crate::keys::{Key, Table, Type, optional, required};
use crate::model::{Model, PlantModel};
use crate::reader::tree::Node;
use crate::reader::{Given, Reader};
use crate::results::{DesignReport, NoObserver, Quantity, Statement};
use crate::study::{OtherPlant, PlantClass, Specification, Time};
use crate::synthesis::{Designed, Plan, matrix, number, without_certificate};

/// The kind.
pub(super) static DECLARATION: Declaration = Declaration {
    name: "imm",
    about: "Interacting multiple model filter: extended Kalman filters of several models, of which one holds at a time and which change into each other at random, for a plant in continuous time with sampled measurements, or in discrete time.",
    source: "Blom and Bar-Shalom 1988; Bar-Shalom, Li and Kirubarajan 2001, section 11.6.6",
    plant: PlantClass::Nonlinear(Time::ANY),
    keys: &[InteractingModels::KEYS],
    kind: as_kind::<InteractingModels>,
    read: |given, reader| Some(InteractingModels::read(given, reader)?.into()),
    takes_long: false,
    tuning: Tuning::OfStudy(
        "which models may hold is known of the plant and not derived, and the study specifies no such observer",
    ),
};

crate::keys! { |size|
    /// An interacting multiple model filter.
    #[derive(Debug, Clone, PartialEq)]
    pub struct InteractingModels {
        /// W, n x n, of the models without one of their own.
        w: DMatrix<f64>[n, n] as &W,
        /// V, p x p, likewise.
        v: DMatrix<f64>[p, p] as &V,
        /// Covariance of the initial error, n x n (default: the identity).
        p0: DMatrix<f64>[n, n] as Weight = DMatrix::identity(size.states, size.states),
        /// The sampling period.
        period: f64 as &PERIOD,
        /// The models.
        models: Vec<ModeSpec> as &MODELS => models,
        /// Transition probabilities, r x r.
        transitions: DMatrix<f64> as &TRANSITIONS => transitions,
        /// Mode probabilities at the start, r numbers.
        probabilities: Vec<f64> as &PROBABILITIES => probabilities,
    }
}

/// One of the models.
#[derive(Debug, Clone)]
pub struct ModeSpec {
    /// Its name.
    pub name: String,
    /// Its W.
    pub w: DMatrix<f64>,
    /// Its V.
    pub v: DMatrix<f64>,
    /// Its plant, where it is not that of the study.
    pub plant: Option<Arc<OtherPlant>>,
}

/// A plant of its own is equal to itself alone: equations are not compared.
impl PartialEq for ModeSpec {
    fn eq(&self, other: &Self) -> bool {
        let same_plant = match (&self.plant, &other.plant) {
            (None, None) => true,
            (Some(one), Some(other)) => Arc::ptr_eq(one, other),
            _ => false,
        };
        same_plant && (&self.name, &self.w, &self.v) == (&other.name, &other.w, &other.v)
    }
}

const MODELS: Key = required(
    "models",
    Type::Tables(&MODEL),
    "The models, two or more: each is the plant, with what its table says of it in other words, and the noises of the filter unless it has its own.",
);
const TRANSITIONS: Key = required(
    "transitions",
    Type::Rows,
    "Transition probabilities, r x r for r models: in row i that of each model at the next sample where model i holds at this one. Rows sum to 1.",
);
const PROBABILITIES: Key = optional(
    "probabilities",
    Type::Numbers(crate::keys::Range::NotNegative),
    "Probabilities of the models at the start, r numbers that sum to 1 (default: all the same).",
);

const MODEL: Table = Table {
    name: "models",
    about: "A model of the plant.",
    variants: None,
    keys: &[
        optional("name", Type::Name, "Its name in figures and tables (default: model 1, model 2, ...)."),
        optional("w", Type::Weight, "Its W, n x n (default: that of the filter)."),
        optional("v", Type::Weight, "Its V, p x p (default: that of the filter)."),
        optional("parameters", Type::Named, "Its values of parameters of the plant (default: those of the plant)."),
        optional("a", Type::Rows, "Its A, of a plant of matrices (default: that of the plant)."),
        optional("b", Type::Rows, "Its B, likewise."),
        optional("c", Type::Rows, "Its C, likewise."),
        optional("d", Type::Rows, "Its D, likewise."),
        optional("f", Type::Texts, "Its right-hand sides, of a plant of expressions (default: those of the plant)."),
        optional("h", Type::Texts, "Its outputs, likewise."),
    ],
};

/// The number of models that the table has.
fn count(given: &Given<'_>) -> Option<usize> {
    Some(given.node.get(MODELS.name)?.list()?.len())
}

fn models(key: &Key, given: &Given<'_>, reader: &mut Reader) -> Option<Vec<ModeSpec>> {
    let node = given.node.get(key.name)?;
    let list = node.list()?;
    if list.len() < 2 {
        let message = format!("`models` has {}", counted(list.len(), "model"));
        return reader.refuse(node.span.clone(), message, "expected two or more: one alone is `extended-kalman`");
    }
    let size = given.size();
    let of_states = format!("the plant has {}", counted(size.states, "state"));
    let of_outputs = format!("the plant has {}", counted(size.outputs, "output"));
    // Mistakes of the filter's own noises are those of their keys.
    let mut quiet = reader.inner();
    let mut common = |key: &str, order: usize| quiet.weight(given.node.get(key)?, key, order, "");
    let (w, v) = (common("w", size.states), common("v", size.outputs));
    let one = |(k, node): (usize, &Node)| {
        let mut own = |key: &str, order: usize, why: &str, other: Option<&DMatrix<f64>>| match node.get(key) {
            Some(node) => reader.weight(node, key, order, why),
            None => other.cloned(),
        };
        let w = own("w", size.states, &of_states, w.as_ref());
        let v = own("v", size.outputs, &of_outputs, v.as_ref());
        let plant = given.model_of(node, reader).ok()?.map(Arc::new);
        let name = node.get("name").and_then(Node::text).map_or_else(|| format!("model {}", k + 1), str::to_owned);
        Some(ModeSpec { name, w: w?, v: v?, plant })
    };
    let read: Vec<Option<ModeSpec>> = list.iter().enumerate().map(one).collect();
    let models: Vec<ModeSpec> = read.into_iter().collect::<Option<_>>()?;
    let repeated = models.iter().enumerate().find(|(k, one)| models[..*k].iter().any(|other| other.name == one.name));
    if let Some((k, one)) = repeated {
        let message = format!("two models are named {:?}", one.name);
        return reader.refuse(list[k].span.clone(), message, "expected different names");
    }
    Some(models)
}

/// Whether these are probabilities that sum to one, up to the rounding of decimals.
fn is_distribution<'a>(entries: impl Iterator<Item = &'a f64> + Clone) -> bool {
    entries.clone().all(|x| *x >= 0.0) && (entries.sum::<f64>() - 1.0).abs() <= 1e-9
}

/// Probabilities that sum to one but for the rounding of decimals, divided by their sum.
fn normalised(entries: &mut [f64]) {
    let sum: f64 = entries.iter().sum();
    for x in entries {
        *x /= sum;
    }
}

fn transitions(key: &Key, given: &Given<'_>, reader: &mut Reader) -> Option<DMatrix<f64>> {
    let (node, r) = (given.node.get(key.name)?, count(given)?);
    let mut found =
        reader.matrix(node, key.name, (Some(r), Some(r)), &format!("`models` has {}", counted(r, "model")))?;
    if let Some(row) = found.row_iter().position(|row| !is_distribution(row.iter())) {
        let message = format!("row {} of `transitions` does not consist of probabilities that sum to 1", row + 1);
        return reader.refuse(node.span.clone(), message, "expected numbers from 0 to 1 that sum to 1 in each row");
    }
    for mut row in found.row_iter_mut() {
        let mut entries: Vec<f64> = row.iter().copied().collect();
        normalised(&mut entries);
        for (x, entry) in row.iter_mut().zip(entries) {
            *x = entry;
        }
    }
    Some(found)
}

fn probabilities(key: &Key, given: &Given<'_>, reader: &mut Reader) -> Option<Vec<f64>> {
    let r = count(given)?;
    let Some(node) = given.node.get(key.name) else { return Some(vec![1.0 / r as f64; r]) };
    let mut found = node.numbers()?;
    if found.len() != r {
        let message = format!("`probabilities` has length {}, and `models` has {}", found.len(), counted(r, "model"));
        return reader.refuse(node.span.clone(), message, format!("expected length {r}"));
    }
    if !is_distribution(found.iter()) {
        let message = "`probabilities` do not sum to 1";
        return reader.refuse(node.span.clone(), message, "expected numbers from 0 to 1 that sum to 1");
    }
    normalised(&mut found);
    Some(found)
}

impl Specification for InteractingModels {
    declared!();

    fn period(&self) -> Option<f64> {
        Some(self.period)
    }

    fn noises(&self) -> Option<[&DMatrix<f64>; 2]> {
        // Models have noises of their own.
        None
    }

    fn updates(&self, _dt: Option<f64>) -> bool {
        true
    }

    fn modes(&self) -> Vec<String> {
        self.models.iter().map(|one| one.name.clone()).collect()
    }

    fn seconds_of_steps(&self, duration: f64) -> f64 {
        let (n, r) = (self.w.nrows() as f64, self.models.len() as f64);
        duration / self.period * r * (STAGES + r) * n * n * n * 4e-9
    }
}

impl Kind for InteractingModels {
    fn design(&self, plan: &Plan<'_>) -> Result<Designed, NoObserver> {
        self.designed(&plan.study.plant, Prediction::ErrorControlled)
    }

    fn design_in_discrete_time(&self, plan: &Plan<'_>, dt: f64) -> Result<Designed, NoObserver> {
        plan.has_period_of_plant(self.period, dt)?;
        self.designed(&plan.study.plant, Prediction::Discrete)
    }
}

impl InteractingModels {
    /// The filter of a plant in continuous or in discrete time.
    fn designed(&self, plant: &PlantModel, prediction: Prediction) -> Result<Designed, NoObserver> {
        let Self { p0, period, models, transitions, probabilities, .. } = self;
        let mut filters: Vec<ExtendedKalmanFilter<Model, f64, Dyn, Dyn, Dyn>> = Vec::new();
        for one in models {
            let model = one.plant.as_ref().map_or_else(|| plant.model.clone(), |other| other.model.clone());
            let noises = NoiseModel { w: one.w.clone(), v: one.v.clone(), p0: p0.clone() };
            filters.push(ExtendedKalmanFilter::discrete(model, noises, *period)?.with_prediction(prediction)?);
        }
        let start = DVector::from_column_slice(probabilities);
        let filter = InteractingMultipleModel::new(filters, transitions.clone(), start)?;
        let mut matrices = vec![matrix("transition probabilities", transitions)];
        for one in models {
            matrices.push(matrix(&format!("W of {}", one.name), &one.w));
            matrices.push(matrix(&format!("V of {}", one.name), &one.v));
        }
        matrices.push(matrix("P(0)", p0));
        let names: Vec<&str> = models.iter().map(|one| one.name.as_str()).collect();
        let report = DesignReport {
            statement: Statement::of(format!(
                "One measurement every {}; the filters of {} ({}), mixed by the probabilities of the models.",
                plant.time_in_words(*period),
                counted(models.len(), "model"),
                names.join(", ")
            )),
            matrices,
            numbers: vec![number(Quantity::Period, *period), number("models", models.len() as f64)],
            ..without_certificate(plant, "no theorem of stability")
        };
        Ok(Designed::new(filter.into(), report, None))
    }
}

impl Running for InteractingMultipleModel<Model> {
    runs!(sampled);

    // As a filter it also records its covariance.
    fn replay<'a>(&'a self, replay: Replay<'a>, name: &str, initial: &[f64]) -> Replay<'a> {
        replay.filter(name, self.clone(), initial)
    }

    fn filter(&self) -> Option<&dyn designed::Filter> {
        Some(self)
    }

    fn mode_probabilities(&self, state: &[f64]) -> Option<DVector<f64>> {
        self.probabilities(&DVector::from_column_slice(state))
    }

    fn record(&self, _of: &StepOf<'_>, _recording: &mut Recording) -> Result<RecordedObserver, NoObserver> {
        Err(NoObserver::new("an interacting multiple model filter is not exported: its steps have no kernel in C"))
    }
}
