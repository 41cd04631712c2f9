//! The high-gain observer: a copy of a plant in triangular form, or given maps, with the gains `alpha_i / r^i` along
//! chains of integrators that begin at the outputs.

use luenberger_export::extension::RecordedObserver;
use luenberger_expression::{Expression, ParameterError, Recorded, Recording, Scope};
use luenberger_observers::high_gain::{ChainPosition, HighGainMap};
use luenberger_observers::{HighGainObserver, Observer, ObserverDimensions, ObserverError};
use luenberger_plants::{Plant, state_jacobian};
use luenberger_proof::wording::{counted, shortest};
use nalgebra::{DMatrix, DVector, Dyn, convert};

use super::declaration::{Declaration, Information, Rule, Tuning};
use super::{Kind, as_kind};
use crate::designed::{NonlinearStep, Running, StepOf};
use crate::steps::recorded::recorded;
use crate::study::{ObserverKind, ObserverSpec, PlantClass, Specification, Study, Time};
use crate::synthesis::{Designed, Plan, matrix, number, other_kinds, uncertified};
use crate::tuning::{Context, Keys, Value, chain_settling, compositions, short};

use crate::keys::{Range, Type, optional, required};
use crate::maps::high_gain::place;
use crate::maps::{HighGainMaps, MapNames};
use crate::model::{Model, PlantModel};
use crate::reader::maps::list;
use crate::reader::tree::Node;
use crate::reader::{Given, Reader, check};
use crate::results::{DesignReport, NoObserver, Statement};
use crate::synthesis::explain::no_chains;

/// The kind.
pub(super) static DECLARATION: Declaration = Declaration {
    name: "high-gain",
    about: "Copy of a plant in triangular form, or given maps, with the gains alpha_i / r^i along chains of integrators that begin at the outputs.",
    source: "Yi, Ortega and Zhang 2018, Table I; Khalil and Praly 2014",
    plant: PlantClass::Nonlinear(Time::OF_STATE),
    keys: &[&[
        required("r", Type::Number(Range::Positive), "High-gain parameter: a small positive number."),
        optional(
            "chains",
            Type::Numbers(Range::Positive),
            "Length of the chain of each output; they add to n, or to the number of rows of `drift` (default with one output: all).",
        ),
        optional(
            "alpha",
            Type::Numbers(Range::Positive),
            "Coefficients alpha_i, one number for each state of the chains (default: those of (s + 1)^length for each chain).",
        ),
        optional(
            "drift",
            Type::Expressions,
            "Right-hand side without corrections, one expression of xi1, .., inputs and outputs for each state of the chains (default: the plant at the estimate).",
        ),
        optional(
            "shape",
            Type::Expressions,
            "With `drift`: factors of the corrections, expressions of inputs and outputs (default 1).",
        ),
        optional(
            "estimate",
            Type::Expressions,
            "With `drift`: the estimate, one expression of xi1, .., inputs and outputs for each state of the plant (default: xi).",
        ),
        optional(
            "start",
            Type::Expressions,
            "With `drift`: xi at the start, expressions of the states at the first estimate and the outputs (default: the first estimate).",
        ),
    ]],
    kind: as_kind::<HighGain>,
    read,
    takes_long: false,
    tuning: Tuning::Rules(&[Rule {
        name: "high-gain",
        turn: 16,
        tuning: "the r with which chains of integrators, with all poles at -1/r, settle in the settling time",
        source: "Khalil and Praly 2014",
        character: "its gain grows as r^-i along the chain, without regard to the noise",
        information: &[Information::Settling],
        keys: tuned,
    }]),
};

fn read(given: &Given<'_>, reader: &mut Reader) -> Option<ObserverKind> {
    let (node, plant, size) = (given.node, given.plant, given.size());
    let p = size.outputs;
    let drift = node.get("drift").map(|drift| drift.list().map_or(0, <[Node]>::len));
    if drift.is_none()
        && let Some(entry) = ["shape", "estimate", "start"].iter().find_map(|key| node.entry(key))
    {
        let message = format!("`{}` is given, and `drift` is not", entry.key);
        return reader.refuse(entry.span.clone(), message, "expected `drift`, the right-hand side without corrections");
    }
    let (n, whose) = match drift {
        Some(order) => (order, format!("`drift` has {}", counted(order, "row"))),
        None => (size.states, format!("the plant has {}", counted(size.states, "state"))),
    };
    let chains = match node.entry("chains") {
        Some(entry) => {
            let lengths = reader.numbers(&entry.node, "chains", p, "output")?;
            if lengths.iter().any(|length| length.fract() != 0.0) || lengths.iter().sum::<f64>() != n as f64 {
                let message = format!("`chains` is {}, and {whose}", listed(&lengths));
                return reader.refuse(
                    entry.node.span.clone(),
                    message,
                    format!("expected whole numbers that add to {n}"),
                );
            }
            lengths.into_iter().map(|length| length as usize).collect()
        }
        None if p == 1 => vec![n],
        None => {
            let message =
                format!("the plant has {}, and `chains` does not assign the states to them", counted(p, "output"));
            reader.absent(check::head(node), message, format!("expected `chains`, {p} lengths that add to {n}"));
            return None;
        }
    };
    let alpha = match node.get("alpha") {
        Some(alpha) if drift.is_some() => {
            let alpha_i = alpha.numbers()?;
            if alpha_i.len() != n {
                let message = format!("`alpha` has length {}, and {whose}", alpha_i.len());
                return reader.refuse(alpha.span.clone(), message, format!("expected length {n}"));
            }
            alpha_i
        }
        Some(alpha) => reader.numbers(alpha, "alpha", n, "state")?,
        None => chains.iter().flat_map(|length| binomials(*length)).collect(),
    };
    let maps = match drift {
        Some(_) => Some(given_maps(node, plant, &chains, reader)?),
        None => None,
    };
    Some(HighGain { r: node.get("r")?.number()?, chains, alpha, maps }.into())
}

/// `[1, 2.5]`.
fn listed(numbers: &[f64]) -> String {
    format!("[{}]", numbers.iter().map(f64::to_string).collect::<Vec<_>>().join(", "))
}

/// The coefficients of `(s + 1)^length` after the first.
fn binomials(length: usize) -> Vec<f64> {
    let next = |last: &f64, k: usize| last * (length - k) as f64 / (k + 1) as f64;
    let mut row = vec![1.0];
    for k in 0..length {
        row.push(next(&row[k], k));
    }
    row.split_off(1)
}

/// The maps of a high-gain observer with chains of these lengths.
fn given_maps(node: &Node, plant: &PlantModel, chains: &[usize], reader: &mut Reader) -> Option<HighGainMaps> {
    let size = plant.model.size();
    let order = chains.iter().sum();
    let names = MapNames::new(plant, order);
    let of_drift = format!("`drift` has {}", counted(order, "row"));
    let of_states = format!("the plant has {}", counted(size.states, "state"));
    if order != size.states
        && let Some(key) = ["estimate", "start"].iter().find(|key| node.get(key).is_none())
    {
        let message = format!("{of_drift}, {of_states}, and `{key}` is not given");
        return reader.refuse(node.get("drift")?.span.clone(), message, format!("expected `{key}`"));
    }
    // By default xi are the states.
    let numbered = |letters: &str, count: usize, scope: Result<Scope, ParameterError>| -> Option<Vec<Expression>> {
        let scope = scope.ok()?;
        (1..=count).map(|k| Expression::parse(&format!("{letters}{k}"), &scope).ok()).collect()
    };
    let ones =
        || -> Option<Vec<Expression>> { (0..order).map(|_| Expression::parse("1", &Scope::constant()).ok()).collect() };
    let drift = list(node, "drift", (order, &of_drift), names.injection(), reader);
    let shape = match node.get("shape") {
        Some(_) => list(node, "shape", (order, &of_drift), names.dynamics(), reader),
        None => ones(),
    };
    let estimate = match node.get("estimate") {
        Some(_) => list(node, "estimate", (size.states, &of_states), names.injection(), reader),
        None => numbered("xi", order, names.injection()),
    };
    let start = match node.get("start") {
        Some(_) => list(node, "start", (order, &of_drift), names.image(), reader),
        None => numbered("x", order, names.image()),
    };
    let lengths = chains.to_vec();
    Some(HighGainMaps { plant: size, lengths, drift: drift?, shape: shape?, estimate: estimate?, start: start? })
}

/// A high-gain observer.
#[derive(Debug, Clone, PartialEq)]
pub struct HighGain {
    /// r.
    pub r: f64,
    /// The lengths of the chains.
    pub chains: Vec<usize>,
    /// The coefficients.
    pub alpha: Vec<f64>,
    /// Given maps; none for the copy of a plant in triangular form.
    pub maps: Option<HighGainMaps>,
}

impl Specification for HighGain {
    declared!();

    fn free_keys(&self) -> &'static [&'static str] {
        &["r", "alpha"]
    }

    fn faster(&self, factor: f64, _dt: Option<f64>) -> Option<ObserverKind> {
        Some(Self { r: self.r / factor, ..self.clone() }.into())
    }
}

impl Kind for HighGain {
    fn design(&self, plan: &Plan<'_>) -> Result<Designed, NoObserver> {
        let Self { r, chains: lengths, alpha, maps } = self;
        match maps {
            Some(maps) => high_gain_maps(plan.study, plan.requested, maps, alpha, *r),
            None => high_gain(chains(plan.study, plan.requested, lengths)?, alpha, *r),
        }
    }
}

/// A plant in triangular form: chain k has `lengths[k]` consecutive states, the first of which is output k.
///
/// In a pure chain of integrators each state is the derivative of the one before it. Here it enters with the
/// coefficient `c_i = df_i/dx_(i+1)`, taken at the first estimate and the first input; the correction of a state is
/// divided by the product of the coefficients before it, so that the error has the poles of a pure chain there.
#[derive(Debug, Clone)]
pub struct Chains {
    pub(crate) model: Model,
    pub(crate) lengths: Vec<usize>,
    /// `1 / (c_1 ... c_(i-1))` within each chain.
    shape: DVector<f64>,
    /// Whether every c_i is a constant.
    constant: bool,
}

impl Chains {
    /// The chains with the coefficients at `estimate` and `input`.
    ///
    /// # Errors
    /// The state (from 0) whose coefficient is 0 or not finite there, with the coefficient.
    pub(crate) fn at(
        model: &Model,
        lengths: &[usize],
        estimate: &[f64],
        input: &DVector<f64>,
    ) -> Result<Self, (usize, f64)> {
        let x = DVector::from_column_slice(estimate);
        let jacobian = state_jacobian(model, 0.0, &x, input);
        let structure = model.structure();
        let mut shape = DVector::repeat(x.len(), 1.0);
        let mut constant = true;
        let mut head = 0;
        for length in lengths {
            for i in head..(head + length).saturating_sub(1) {
                let coefficient = jacobian[(i, i + 1)];
                let next = shape[i] / coefficient;
                if next == 0.0 || !next.is_finite() {
                    return Err((i, coefficient));
                }
                shape[i + 1] = next;
                constant &= structure.has_constant_factor(i, i + 1);
            }
            head += length;
        }
        Ok(Self { model: model.clone(), lengths: lengths.to_vec(), shape, constant })
    }

    /// Whether no coefficient depends on the state, the input or the time: then the factors are right everywhere.
    pub(crate) fn have_constant_coefficients(&self) -> bool {
        self.constant
    }

    /// The factors of the corrections.
    pub(crate) fn factors(&self) -> &DVector<f64> {
        &self.shape
    }
}

impl HighGainMap<f64> for Chains {
    type Xi = Dyn;
    type Inputs = Dyn;
    type Outputs = Dyn;
    type Estimate = Dyn;

    fn dimensions(&self) -> ObserverDimensions {
        let size = self.model.size();
        ObserverDimensions { state: size.states, inputs: size.inputs, outputs: size.outputs, estimate: size.states }
    }

    fn place(&self, i: usize) -> ChainPosition {
        place(&self.lengths, i)
    }

    fn drift(&self, t: f64, xi: &DVector<f64>, u: &DVector<f64>, _y: &DVector<f64>) -> DVector<f64> {
        self.model.derivative(t, xi, u)
    }

    fn shape(&self, _t: f64, _u: &DVector<f64>, _y: &DVector<f64>) -> DVector<f64> {
        self.shape.clone()
    }

    fn estimate(&self, _t: f64, xi: &DVector<f64>, _u: &DVector<f64>, _y: &DVector<f64>) -> DVector<f64> {
        xi.clone()
    }

    fn start(&self, _t: f64, estimate: &DVector<f64>, _u: &DVector<f64>, _y: &DVector<f64>) -> DVector<f64> {
        estimate.clone()
    }
}

impl Running for HighGainObserver<Chains, f64, Dyn> {
    runs!(continuous);

    fn step(&self, of: &StepOf<'_>) -> Result<Option<NonlinearStep>, NoObserver> {
        let (map, gain) = (self.map(), self.gain());
        let mut l = DMatrix::zeros(gain.len(), of.study.plant.outputs.len());
        for i in 0..gain.len() {
            l[(i, map.place(i).output)] = map.factors()[i] * gain[i];
        }
        of.with_gain(&l, of.observer.initial.clone(), "").map(Some)
    }
}

impl Running for HighGainObserver<HighGainMaps, f64, Dyn> {
    runs!(continuous);

    fn record(&self, _of: &StepOf<'_>, recording: &mut Recording) -> Result<RecordedObserver, NoObserver> {
        recorded(recording, &over_recorded(self)?)
    }
}

/// A high-gain observer with given maps, over the scalar that records.
fn over_recorded(
    given: &HighGainObserver<HighGainMaps, f64, Dyn>,
) -> Result<HighGainObserver<HighGainMaps, Recorded, Dyn>, ObserverError> {
    HighGainObserver::new(given.map().clone(), given.gain().map(convert), convert(1.0))
}

/// The chains of a high-gain observer, whose coefficients of the next states are not 0 at the first estimate.
fn chains(study: &Study, requested: &ObserverSpec, lengths: &[usize]) -> Result<Chains, NoObserver> {
    let (model, size) = (&study.plant.model, study.plant.model.size());
    let (states, kind) = (&study.plant.states, requested.kind.name());
    if let Some(hypothesis) = no_chains(study, &model.structure(), kind, lengths) {
        return Err(NoObserver::new(hypothesis).advise(other_kinds(study, requested)));
    }
    let mut input = DVector::zeros(size.inputs);
    if let Some(program) = study.input.program() {
        program.at(0.0, input.as_mut_slice());
    }
    Chains::at(model, lengths, &requested.initial, &input).map_err(|(i, coefficient)| {
        let hypothesis = format!(
            "the kind {kind} divides by the derivative of {}' by {}, which is {} at the first estimate",
            states[i],
            states[i + 1],
            shortest(coefficient)
        );
        let remedy = "`initial` at a state where this derivative is finite and not 0, such as the operating point";
        NoObserver::new(hypothesis).hint(remedy)
    })
}

fn high_gain(chains: Chains, alpha: &[f64], r: f64) -> Result<Designed, NoObserver> {
    let column = |entries: &DVector<f64>| DMatrix::from_column_slice(entries.len(), 1, entries.as_slice());
    let constant = chains.have_constant_coefficients();
    let has_factors = !constant || chains.factors().iter().any(|factor| *factor != 1.0);
    let factors = has_factors.then(|| column(chains.factors()));
    let observer = HighGainObserver::new(chains, DVector::from_column_slice(alpha), r)?;
    let mut matrices = vec![matrix("alpha_i / r^i", &column(observer.gain()))];
    let mut gains = "the gains alpha_i / r^i".to_owned();
    if let Some(factors) = factors {
        gains.push_str(" times factors (the inverse products of the chain's coefficients at the first estimate)");
        matrices.push(matrix("factors", &factors));
    }
    let (theorem, why) = if constant {
        (
            "If the right-hand side is Lipschitz and r is small enough, the error decays like exp(-c t / r).",
            "the theorem holds for all r below a bound that is not computed; check this r by simulation",
        )
    } else {
        (
            "The coefficients of the chain vary, and the gains are those of the first estimate.",
            "the theorem is for coefficients that are constant; check this r by simulation",
        )
    };
    let report = DesignReport {
        statement: Statement::of(format!("A copy of the plant with {gains}, r = {r}. {theorem}")),
        matrices,
        numbers: vec![number("r", r)],
        ..uncertified(why)
    };
    Ok(Designed::new(observer.into(), report, None))
}

/// A high-gain observer with given maps; the poles are those at the first estimate.
fn high_gain_maps(
    study: &Study,
    requested: &ObserverSpec,
    maps: &HighGainMaps,
    alpha: &[f64],
    r: f64,
) -> Result<Designed, NoObserver> {
    let observer = HighGainObserver::new(maps.clone(), DVector::from_column_slice(alpha), r)?;
    let gain = observer.gain();
    let plant = study.plant.model.expressions().ok();
    let poles = plant
        .and_then(|plant| {
            plant.record(|recording| RecordedObserver::new(recording, &over_recorded(&observer).ok()?).ok())
        })
        .and_then(|written| {
            let mut u = DVector::zeros(study.plant.inputs.len());
            if let Some(program) = study.input.program() {
                program.at(0.0, u.as_mut_slice());
            }
            let x = DVector::from_column_slice(&requested.initial);
            let y: DVector<f64> = study.plant.model.output(0.0, &x, &u);
            let z = Observer::initial(&observer, 0.0, &x, &u, &y);
            let jacobian = written.jacobian(0.0, &z, &u, &y);
            let finite = jacobian.iter().all(|entry| entry.is_finite());
            finite.then(|| crate::synthesis::poles(jacobian.complex_eigenvalues().as_slice()))
        })
        .unwrap_or_default();
    let report = DesignReport {
        statement: Statement::of(format!(
            "xi' = drift + shape (alpha_i / r^i) (y - head) with the head of each chain, r = {r}. The poles are those of the observer at the first estimate."
        )),
        matrices: vec![matrix("alpha_i / r^i", &DMatrix::from_column_slice(gain.len(), 1, gain.as_slice()))],
        poles,
        numbers: vec![number("r", r)],
        ..uncertified("the maps are not checked; look at the error in a simulation")
    };
    Ok(Designed::new(observer.into(), report, None))
}

/// r for each way to cut the states into as many chains as there are outputs.
fn tuned(context: &Context<'_>) -> Result<Vec<Keys>, String> {
    let (n, p) = (context.study.plant.states.len(), context.study.plant.outputs.len());
    if p > n {
        return Err(format!("each chain begins at an output: {} for {}", counted(p, "output"), counted(n, "state")));
    }
    let of = |chains: &Vec<usize>| {
        let longest = chains.iter().copied().max().unwrap_or(1);
        let time = chain_settling(longest, context.information.band);
        let mut keys = vec![("r", Value::Number(short(context.information.settling / time)))];
        if p > 1 {
            keys.push(("chains", Value::numbers(chains.iter().map(|length| *length as f64))));
        }
        keys
    };
    Ok(compositions(n, p).iter().map(of).collect())
}
