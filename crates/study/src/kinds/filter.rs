//! What the filters with a covariance share, those that are updated at samples.

use luenberger_expression::Expression;
use luenberger_observers::NoiseModel;
use luenberger_observers::correlated::check_joint_covariance;
use luenberger_proof::wording::counted;
use nalgebra::{DMatrix, DVector, Dyn};

use super::keys::PERIOD;
use crate::designed::{Along, Intensity, ProcessNoise};
use crate::keys::{Key, Type, optional, required};
use crate::maps::MapNames;
use crate::model::PlantModel;
use crate::reader::region::bounds;
use crate::reader::tree::Node;
use crate::reader::{Given, Reader, maps, rows_of};
use crate::results::{NamedMatrix, NoObserver};
use crate::study::Estimated;
use crate::synthesis::matrix;

crate::keys! { |size|
    /// The noises and the period of a filter with a covariance.
    #[derive(Debug, Clone, PartialEq)]
    pub struct Filter {
        /// W, n x n; the identity where it is an expression.
        w: DMatrix<f64> as &PROCESS_NOISE => process_noise,
        /// V, p x p; the identity where it is an expression.
        v: DMatrix<f64> as &MEASUREMENT_NOISE => measurement_noise,
        /// The noises that are expressions.
        along: Along as [&[ENTERING]] => along,
        /// Covariance of the initial error, n x n (default: the identity).
        p0: DMatrix<f64>[n, n] as Weight = DMatrix::identity(size.states, size.states),
        /// The sampling period.
        period: f64 as &PERIOD,
        /// Runge-Kutta steps per sampling period in exported code (default: as many as their error needs). Elsewhere
        /// the prediction controls its error.
        substeps: Option<usize> as Count(1),
    }
}

const PROCESS_NOISE: Key = required(
    "w",
    Type::Covariance,
    "Intensity W of the process noise, n x n, per unit of time: numbers, or a diagonal with expressions of t, states and inputs, taken at the estimate before each prediction.",
);
const MEASUREMENT_NOISE: Key = required(
    "v",
    Type::Covariance,
    "Covariance V of a measurement, p x p: numbers, or a diagonal with expressions of t, states and inputs, taken at the prediction for each sample.",
);
const ENTERING: Key = optional(
    "g",
    Type::ExpressionRows,
    "G, n x q, of process noise that enters as x' = f(t, x, u) + G w, with numbers or expressions as those of `w`; W is then q x q (default: the identity).",
);
pub(super) const CROSS_COVARIANCE: Key = optional(
    "s",
    Type::Rows,
    "Cross-covariance S = E w v' of the noise of a measurement and that of the step which follows it, n x p, with `g` q x p, of a plant in discrete time (default: 0).",
);
pub(super) const STATE_BOUNDS: Key = optional(
    "state_bounds",
    Type::Bounds,
    "Bounds of the states, n pairs [lower, upper]; they may be inf or -inf (default: none). After each measurement the estimate is the nearest within them, by its covariance.",
);

/// Whether a list has expressions.
fn has_text(node: &Node) -> bool {
    let is_text =
        |entry: &Node| entry.text().is_some() || entry.list().is_some_and(|row| row.iter().any(|x| x.text().is_some()));
    node.list().is_some_and(|list| list.iter().any(is_text))
}

/// A weight; the identity where it has expressions.
fn constant(node: &Node, name: &str, order: usize, why: &str, reader: &mut Reader) -> Option<DMatrix<f64>> {
    if has_text(node) { Some(DMatrix::identity(order, order)) } else { reader.weight(node, name, order, why) }
}

/// Columns of G, and what is said of the order of W.
fn order(given: &Given<'_>) -> (usize, String) {
    let n = given.size().states;
    let Some(g) = given.node.get("g").and_then(Node::list) else {
        return (n, format!("the plant has {}", counted(n, "state")));
    };
    let columns = g.first().and_then(Node::list).map_or(g.len(), <[Node]>::len);
    (columns, format!("`g` has {}", counted(columns, "column")))
}

/// W, or `G W G'`.
fn process_noise(key: &Key, given: &Given<'_>, reader: &mut Reader) -> Option<DMatrix<f64>> {
    let (n, (order, why)) = (given.size().states, order(given));
    let w = constant(given.node.get(key.name)?, key.name, order, &why, reader)?;
    let Some(g) = given.node.get("g") else { return Some(w) };
    if has_text(g) || has_text(given.node.get(key.name)?) {
        return Some(DMatrix::identity(n, n));
    }
    // A wrong size is a mistake of `g`.
    let g = entering(g)?;
    (g.nrows() == n).then(|| &g * w * g.transpose())
}

fn measurement_noise(key: &Key, given: &Given<'_>, reader: &mut Reader) -> Option<DMatrix<f64>> {
    let p = given.size().outputs;
    constant(given.node.get(key.name)?, key.name, p, &format!("the plant has {}", counted(p, "output")), reader)
}

/// The noises that are expressions.
fn along(given: &Given<'_>, reader: &mut Reader) -> Option<Along> {
    let names = MapNames::new(given.plant, 0);
    let (n, p, (q, why)) = (given.size().states, given.size().outputs, order(given));
    let node = |key: &str| given.node.get(key);
    let of_states = format!("the plant has {}", counted(n, "state"));
    let size = (n, q, of_states.as_str());
    let g = given.node.given("g", |_| maps::matrix(given.node, "g", size, names.plant(), reader))?;
    let mut diagonal = |key: &str, length: (usize, &str)| match node(key).filter(|node| has_text(node)) {
        None => Some(None),
        Some(_) => maps::list(given.node, key, length, names.plant(), reader).map(Some),
    };
    let of_outputs = format!("the plant has {}", counted(p, "output"));
    let (w, v) = (diagonal("w", (q, &why)), diagonal("v", (p, &of_outputs)));
    let (w, measurement) = (w?, v?);
    let varies = w.is_some() || node("g").is_some_and(has_text);
    let intensity = |w: Option<Vec<Expression>>, reader: &mut Reader| match w {
        Some(rows) => Some(Intensity::Diagonal(rows)),
        None => Some(Intensity::Constant(reader.weight(node("w")?, "w", q, &why)?)),
    };
    let process = if varies { Some(ProcessNoise { q: intensity(w, reader)?, g }) } else { None };
    Some(Along { process, measurement })
}

/// S, n x p, which fits W and V.
#[expect(clippy::option_option, reason = "wrong, absent, or given")]
pub(super) fn cross_covariance(key: &Key, given: &Given<'_>, reader: &mut Reader) -> Option<Option<DMatrix<f64>>> {
    let node = |key: &str| given.node.get(key);
    let Some(entry) = given.node.entry(key.name) else { return Some(None) };
    if reader.dt.is_none() {
        let message =
            "`s` in continuous time: the noise of a sample has no covariance with that of the process, which is white";
        return reader.refuse(entry.span.clone(), message, "expected a plant in discrete time, or no `s`");
    }
    if let Some(varying) = ["w", "v", "g"].into_iter().find(|key| node(key).is_some_and(has_text)) {
        let message = format!("`s` with expressions in `{varying}`: S has to fit W and V");
        return reader.refuse(entry.span.clone(), message, "expected numbers, or no `s`");
    }
    if !given.plant.delays.is_empty() {
        let message = "`s` with outputs that are measured late (`delays` of [plant])";
        return reader.refuse(entry.span.clone(), message, "expected no `delays`, or no `s`");
    }
    let (p, (q, why)) = (given.size().outputs, order(given));
    let of_outputs = format!("the plant has {}", counted(p, "output"));
    let s = reader.matrix(&entry.node, key.name, (Some(q), Some(p)), &format!("{why} and {of_outputs}"))?;
    let (w, v) = (reader.weight(node("w")?, "w", q, &why)?, reader.weight(node("v")?, "v", p, &of_outputs)?);
    if let Err(error) = check_joint_covariance(&w, &v, &s) {
        // What is wrong with W or V alone is said of them.
        if check_joint_covariance(&w, &v, &DMatrix::zeros(q, p)).is_ok() {
            let expected = "expected S with [W S; S' V] positive semidefinite: |S_ij| <= sqrt(W_ii V_jj) at least";
            let message = format!("`s` does not fit `w` and `v`: {error}");
            return reader.refuse(entry.node.span.clone(), message, expected);
        }
    }
    match node("g") {
        None => Some(Some(s)),
        // A wrong size is a mistake of `g`.
        Some(g) => entering(g).filter(|g| g.ncols() == s.nrows()).map(|g| Some(g * s)),
    }
}

/// G of numbers.
fn entering(g: &Node) -> Option<DMatrix<f64>> {
    match g.numbers() {
        Some(diagonal) => Some(DMatrix::from_diagonal(&diagonal.into())),
        None => rows_of(g),
    }
}

/// S with rows of zeros for these parameters, which are independent of the measurement.
pub(super) fn cross_with(s: Option<&DMatrix<f64>>, parameters: &[Estimated]) -> Option<DMatrix<f64>> {
    s.map(|s| s.clone().resize_vertically(s.nrows() + parameters.len(), 0.0))
}

/// What is said of a cross-covariance.
pub(super) const CORRELATED: &str =
    " The noise of a measurement and that of the step after it have the cross-covariance S.";

/// Bounds with a lower end below the upper one.
#[expect(clippy::option_option, reason = "wrong, absent, or given")]
pub(super) fn state_bounds(key: &Key, given: &Given<'_>, reader: &mut Reader) -> Option<Option<Vec<(f64, f64)>>> {
    let Some(node) = given.node.get(key.name) else { return Some(None) };
    let bounds = bounds(node, key.name, given.size().states, "state", reader)?;
    match bounds.iter().position(|(low, high)| low >= high) {
        Some(k) => {
            let message = format!("pair {} of `{}` is from {} to {}", k + 1, key.name, bounds[k].0, bounds[k].1);
            reader.refuse(node.span.clone(), message, "expected the lower bound below the upper one")
        }
        None => Some(Some(bounds)),
    }
}

/// The bounds of `n` states with those of parameters behind them; none if nothing is bounded.
pub(super) fn bounds_with(own: Option<&[(f64, f64)]>, n: usize, parameters: &[Estimated]) -> Option<Vec<(f64, f64)>> {
    let free = (f64::NEG_INFINITY, f64::INFINITY);
    if own.is_none() && parameters.iter().all(|one| one.bounds == free) {
        return None;
    }
    let own = own.map_or_else(|| vec![free; n], <[_]>::to_vec);
    Some(own.into_iter().chain(parameters.iter().map(|one| one.bounds)).collect())
}

/// What is said of bounds.
pub(super) const BOUNDED: &str = " The estimates at the samples stay within the bounds of the states.";

/// What is said of outputs that are measured late.
///
/// # Errors
/// [`NoObserver`] where estimates are smoothed.
pub(super) fn late(plant: &PlantModel, smooths: bool) -> Result<String, NoObserver> {
    let late = plant.late_outputs();
    if late.is_empty() {
        return Ok(late);
    }
    if smooths {
        return Err(NoObserver::new(format!("`smooth` with outputs that are measured late ({late})"))
            .hint("no `smooth`, or a log in which the late columns stand at their times, without `delays`"));
    }
    Ok(format!(" Measurements are late ({late}), and each is taken at its time: what followed is computed again."))
}

/// That no angle is bounded that f may wrap.
pub(super) fn bounds_no_angle(plant: &PlantModel, bounds: &[(f64, f64)]) -> Result<(), NoObserver> {
    let is_bounded = |(_, (lower, upper)): &(&String, &(f64, f64))| lower.is_finite() || upper.is_finite();
    let mut bounded = plant.states.iter().zip(bounds).filter(is_bounded);
    match bounded.find(|(name, _)| plant.dt.is_some() && plant.turns.contains_key(*name)) {
        Some((name, _)) => Err(NoObserver::new(format!(
            "`state_bounds` bounds {name}, an angle of a plant in discrete time, whose f may wrap it"
        ))
        .hint("no bounds of angles")),
        None => Ok(()),
    }
}

/// W, V, S and P(0), as far as they are constant.
pub(super) fn matrices(filter: &Filter, s: Option<&DMatrix<f64>>) -> Vec<NamedMatrix> {
    let Filter { w, v, p0, along, .. } = filter;
    let w = along.process.is_none().then(|| matrix("W", w));
    let v = along.measurement.is_none().then(|| matrix("V", v));
    w.into_iter().chain(v).chain(s.map(|s| matrix("S", s))).chain([matrix("P(0)", p0)]).collect()
}

impl Filter {
    /// Noise of intensity W and covariance V, with P(0) = I.
    pub fn new(w: DMatrix<f64>, v: DMatrix<f64>, period: f64) -> Self {
        Self { p0: DMatrix::identity(w.nrows(), w.nrows()), w, v, along: Along::default(), period, substeps: None }
    }

    /// The same with these parameters as further states, whose errors and random walks are independent of the others.
    pub(super) fn with_parameters(&self, parameters: &[Estimated]) -> Self {
        let [w, p0] = extended([&self.w, &self.p0], parameters);
        Self { w, p0, ..self.clone() }
    }

    /// W and V, if they are constant.
    pub(super) fn constant(&self) -> Option<[&DMatrix<f64>; 2]> {
        self.along.is_constant().then_some([&self.w, &self.v])
    }

    /// W, V and P(0).
    pub(super) fn noises(&self) -> NoiseModel<f64, Dyn, Dyn> {
        NoiseModel { w: self.w.clone(), v: self.v.clone(), p0: self.p0.clone() }
    }
}

/// W and P(0) with these parameters as further states.
pub(super) fn extended(matrices: [&DMatrix<f64>; 2], parameters: &[Estimated]) -> [DMatrix<f64>; 2] {
    let n = matrices[0].nrows();
    let with = |matrix: &DMatrix<f64>, of: fn(&Estimated) -> f64| {
        DMatrix::from_fn(n + parameters.len(), n + parameters.len(), |i, j| match (i.checked_sub(n), j) {
            (None, j) if j < n => matrix[(i, j)],
            (Some(k), j) if i == j => of(&parameters[k]),
            _ => 0.0,
        })
    };
    [with(matrices[0], |one| one.w), with(matrices[1], |one| one.p0)]
}

/// The outputs whose innovations are wrapped, as a sentence.
pub(super) fn wrapped(plant: &PlantModel) -> String {
    let angles: Vec<&str> =
        plant.outputs.iter().filter(|name| plant.turns.contains_key(*name)).map(String::as_str).collect();
    if angles.is_empty() {
        return String::new();
    }
    format!(" Innovations of {} are angles, within half a turn.", angles.join(", "))
}

/// The full turns of outputs and states, if some of them are angles. In continuous time a state goes on beyond a turn,
/// and its images need no turn.
pub(super) fn turns(plant: &PlantModel) -> Option<(DVector<f64>, DVector<f64>)> {
    let states = plant.turns_of(&plant.states).filter(|_| plant.dt.is_some());
    let outputs = plant.turns_of(&plant.outputs);
    let column = |turns: Option<Vec<f64>>, names: &[String]| {
        turns.map_or_else(|| DVector::zeros(names.len()), DVector::from_vec)
    };
    (states.is_some() || outputs.is_some()).then(|| (column(outputs, &plant.outputs), column(states, &plant.states)))
}

/// Evaluations of a prediction, about, of a plant that is not stiff.
pub(super) const STAGES: f64 = 16.0;
