//! The plant of a study, from matrices, expressions or the library: one type over every scalar, so that all designs
//! accept it.

use std::collections::BTreeMap;

use luenberger_design::Names;
use luenberger_design::TimeDomain;
use luenberger_expression::{AffinePlant, Expression, ExpressionPlant, Parameters, Row, Tables};
use luenberger_plants::{
    Chaotic, Column, CukConverter, Differentiable, Dimensions, Dual64, ExponentialCascade, FlexibleJoint, Plant,
    ReverseDuffing, Shape, StateSpace, VanDerPol, double_integrator, flexible_joint, jacobian, third_order, wrap,
};
use luenberger_proof::certificate::{Reading, Represented};
use luenberger_proof::wording::significant;
use nalgebra::{DMatrix, DVector, Dyn, RealField, convert};

/// A plant with the names of its columns.
#[derive(Debug, Clone)]
pub struct PlantModel {
    /// The plant.
    pub model: Model,
    /// Names of the states.
    pub states: Vec<String>,
    /// Names of the inputs.
    pub inputs: Vec<String>,
    /// Names of the outputs.
    pub outputs: Vec<String>,
    /// Units of states, inputs, outputs and parameters, by their names, as far as the study gives them.
    pub units: BTreeMap<String, String>,
    /// The full turns, in their units, of the states and outputs that are angles, by their names.
    pub turns: BTreeMap<String, f64>,
    /// How late each output is measured: what is read at t was true at t less the delay; empty if none is late.
    pub delays: Vec<f64>,
    /// The parameters that expressions use by name.
    pub parameters: Parameters,
    /// The lookup tables that expressions use as functions.
    pub tables: Tables,
    /// Unit of the time, if the study names one.
    pub time_unit: Option<String>,
    /// The period of a plant in discrete time, `x+ = f(x, u)`; none in continuous time.
    pub dt: Option<f64>,
}

impl PlantModel {
    /// Whether the plant is in continuous or in discrete time.
    pub(crate) fn time(&self) -> TimeDomain {
        if self.dt.is_some() { TimeDomain::Discrete } else { TimeDomain::Continuous }
    }

    /// The unit of a state, an input, an output or a parameter, if the study gives it.
    pub fn unit(&self, name: &str) -> Option<&String> {
        self.units.get(name)
    }

    /// The units of columns, an empty text for one without; empty if none of them has a unit.
    pub fn units_of(&self, names: &[String]) -> Vec<String> {
        let units: Vec<String> = names.iter().map(|name| self.unit(name).cloned().unwrap_or_default()).collect();
        if units.iter().all(String::is_empty) { Vec::new() } else { units }
    }

    /// The full turns of columns, 0 for what is no angle; none if none of them is an angle.
    pub fn turns_of(&self, names: &[String]) -> Option<Vec<f64>> {
        let turn = |name: &String| self.turns.get(name).copied().unwrap_or_default();
        let turns: Vec<f64> = names.iter().map(turn).collect();
        turns.iter().any(|turn| *turn > 0.0).then_some(turns)
    }

    /// A time with its unit.
    pub(crate) fn time_in_words(&self, time: f64) -> String {
        let unit = self.time_unit.as_ref().map(|unit| format!(" {unit}")).unwrap_or_default();
        format!("{time}{unit}")
    }

    /// The outputs that are measured late, with their delays, in words; empty if there are none.
    pub(crate) fn late_outputs(&self) -> String {
        let late = self.outputs.iter().zip(&self.delays).filter(|(_, delay)| **delay > 0.0);
        late.map(|(name, delay)| format!("{name} by {}", self.time_in_words(*delay))).collect::<Vec<_>>().join(", ")
    }

    /// The error `x - xhat` of state i, of an angle within half a turn.
    pub fn error(&self, i: usize, x: f64, xhat: f64) -> f64 {
        let turn = self.states.get(i).and_then(|name| self.turns.get(name));
        turn.map_or(x - xhat, |turn| wrap(x - xhat, *turn))
    }

    /// What a reading of output j is beyond its expected value, of an angle within half a turn.
    pub fn innovation(&self, j: usize, reading: f64, expected: f64) -> f64 {
        let turn = self.outputs.get(j).and_then(|name| self.turns.get(name));
        turn.map_or(reading - expected, |turn| wrap(reading - expected, *turn))
    }

    /// A row in terms of the names of the study: `speed'`, or the output.
    pub(crate) fn row(&self, row: Row) -> String {
        match row {
            Row::Derivative(i) => format!("{}'", self.states[i]),
            Row::Output(k) => self.outputs[k].clone(),
        }
    }

    /// A number with the unit of `name`, `0.5 m`.
    pub(crate) fn measured(&self, name: &str, number: String) -> String {
        match self.unit(name) {
            Some(unit) => format!("{number} {unit}"),
            None => number,
        }
    }

    /// A state by the names of its entries: `position = 1, velocity = 0`.
    pub(crate) fn at_state(&self, point: &[f64]) -> String {
        let entries = self.states.iter().zip(point);
        entries.map(|(name, x)| format!("{name} = {}", significant(*x, 4))).collect::<Vec<_>>().join(", ")
    }

    /// A direction in terms of the names of the states: `position - 0.5 velocity`.
    pub(crate) fn direction_in_words(&self, direction: &[f64]) -> String {
        let names: Vec<&str> = self.states.iter().map(String::as_str).collect();
        luenberger_design::nonlinear_observability::direction_in_words(direction, &names)
    }

    /// What a theorem of the plant itself says in a report, or of the linearisation of a nonlinear one.
    pub(crate) fn reading(&self) -> Reading<'_> {
        let Self { states, inputs, outputs, units, .. } = self;
        let is_linearised = self.model.linear().is_none();
        Reading { states, inputs, outputs, units, plant: Represented::Itself, is_linearised, scales: &[] }
    }

    /// The names for messages.
    pub fn names(&self) -> Names {
        Names { states: self.states.clone(), inputs: self.inputs.clone(), outputs: self.outputs.clone() }
    }
}

/// The full turn in a unit of angles.
pub(crate) fn full_turn(unit: &str) -> Option<f64> {
    Some(match unit {
        "" | "1" | "rad" => core::f64::consts::TAU,
        "mrad" => 1e3 * core::f64::consts::TAU,
        "deg" | "degree" | "degrees" | "°" => 360.0,
        "gon" | "grad" => 400.0,
        "rev" | "turn" | "turns" => 1.0,
        _ => return None,
    })
}

/// A plant.
#[derive(Debug, Clone)]
pub enum Model {
    /// `x' = A x + B u`, `y = C x + D u`.
    Linear(StateSpace),
    /// From expressions; with its matrices, if they are syntactically linear.
    Expressions(ExpressionPlant, Option<Box<StateSpace>>),
    /// A plant of the library.
    Builtin(Builtin),
}

impl From<ExpressionPlant> for Model {
    fn from(plant: ExpressionPlant) -> Self {
        let linear = plant.affine().ok().filter(AffinePlant::is_linear).map(|affine| Box::new(affine.linear));
        Self::Expressions(plant, linear)
    }
}

/// The plants of the library.
#[derive(Debug, Clone)]
pub enum Builtin {
    /// The flexible joint, classical.
    FlexibleJoint(FlexibleJoint<2>),
    /// The flexible joint as printed.
    FlexibleJointPrinted(FlexibleJoint<3>),
    /// The chaotic flow.
    Chaotic(Chaotic),
    /// The Cuk converter.
    Cuk(CukConverter),
    /// The reverse Duffing oscillator.
    ReverseDuffing(ReverseDuffing),
    /// Van der Pol's oscillator.
    VanDerPol(VanDerPol),
    /// The plant of Proposition 6.
    ExponentialCascade(ExponentialCascade),
    /// The double integrator.
    DoubleIntegrator(StateSpace),
    /// The plant of Example 3 of the cubic paper.
    ThirdOrder(StateSpace),
}

impl Builtin {
    /// The plant of that name.
    pub fn named(name: &str) -> Option<Self> {
        Some(match name {
            "double-integrator" => Self::DoubleIntegrator(double_integrator().to_dynamic()),
            "third-order" => Self::ThirdOrder(third_order::example3().to_dynamic()),
            "flexible-joint" => Self::FlexibleJoint(flexible_joint::classical()),
            "flexible-joint-printed" => Self::FlexibleJointPrinted(flexible_joint::printed()),
            "chaotic" => Self::Chaotic(Chaotic),
            "cuk" => Self::Cuk(CukConverter::default()),
            "reverse-duffing" => Self::ReverseDuffing(ReverseDuffing),
            "van-der-pol" => Self::VanDerPol(VanDerPol::default()),
            "exponential-cascade" => Self::ExponentialCascade(ExponentialCascade),
            _ => return None,
        })
    }

    /// Its name.
    pub fn name(&self) -> &'static str {
        match self {
            Self::DoubleIntegrator(_) => "double-integrator",
            Self::ThirdOrder(_) => "third-order",
            Self::FlexibleJoint(_) => "flexible-joint",
            Self::FlexibleJointPrinted(_) => "flexible-joint-printed",
            Self::Chaotic(_) => "chaotic",
            Self::Cuk(_) => "cuk",
            Self::ReverseDuffing(_) => "reverse-duffing",
            Self::VanDerPol(_) => "van-der-pol",
            Self::ExponentialCascade(_) => "exponential-cascade",
        }
    }
}

impl Model {
    /// Numbers of states, inputs and outputs.
    pub fn size(&self) -> Dimensions {
        self.dimensions()
    }

    /// The plant as a linear one, if it is linear: given by matrices, or by expressions that are syntactically linear.
    pub fn linear(&self) -> Option<&StateSpace> {
        match self {
            Self::Linear(plant) | Self::Builtin(Builtin::DoubleIntegrator(plant) | Builtin::ThirdOrder(plant)) => {
                Some(plant)
            }
            Self::Expressions(_, linear) => linear.as_deref(),
            Self::Builtin(_) => None,
        }
    }

    /// The states, from 0, whose right-hand side or output is not affine, with the expression; empty if unknown.
    pub fn nonlinearities(&self) -> Vec<String> {
        match self {
            Self::Expressions(plant, _) => {
                let named = |(name, list): (&str, &[Expression])| {
                    list.iter()
                        .enumerate()
                        .filter_map(|(i, e)| Some(format!("`{}` in {name}{}", e.affine().err()?, i + 1)))
                        .collect::<Vec<_>>()
                };
                [("f", plant.f()), ("h", plant.h())].into_iter().flat_map(named).collect()
            }
            _ => Vec::new(),
        }
    }
}

/// `M x`, with binary64 entries of M.
fn product<T: RealField + Copy>(m: &DMatrix<f64>, x: &DVector<T>) -> DVector<T> {
    DVector::from_fn(m.nrows(), |i, _| row_times(m, i, x.as_slice()))
}

/// Entry `i` of `M x`.
fn row_times<T: RealField + Copy>(m: &DMatrix<f64>, i: usize, x: &[T]) -> T {
    // Zero entries are skipped, so that 0 times an infinite bound does not occur.
    let terms = x.iter().enumerate().filter(|(j, _)| m[(i, *j)] != 0.0);
    terms.fold(T::zero(), |sum, (j, x)| sum + convert::<f64, T>(m[(i, j)]) * *x)
}

/// A plant of fixed size, called with slices of run-time length.
fn slope_of<T: RealField + Copy, P: Plant<T>>(plant: &P, t: T, x: &DVector<T>, u: &DVector<T>) -> DVector<T> {
    match (P::State::try_from_slice(x.as_slice()), P::Input::try_from_slice(u.as_slice())) {
        (Some(state), Some(input)) => DVector::from_column_slice(plant.derivative(t, &state, &input).as_slice()),
        // The lengths are checked where the vectors are created.
        _ => DVector::zeros(0),
    }
}

fn output_of<T: RealField + Copy, P: Plant<T>>(plant: &P, t: T, x: &DVector<T>, u: &DVector<T>) -> DVector<T> {
    match (P::State::try_from_slice(x.as_slice()), P::Input::try_from_slice(u.as_slice())) {
        (Some(state), Some(input)) => DVector::from_column_slice(plant.output(t, &state, &input).as_slice()),
        _ => DVector::zeros(0),
    }
}

/// The same expression for each library plant of fixed size.
macro_rules! each {
    ($model:expr, $plant:ident => $call:expr, $linear:ident => $other:expr) => {
        match $model {
            Model::Linear($linear)
            | Model::Builtin(Builtin::DoubleIntegrator($linear) | Builtin::ThirdOrder($linear)) => $other,
            Model::Expressions($plant, _) => $call,
            Model::Builtin(Builtin::FlexibleJoint($plant)) => $call,
            Model::Builtin(Builtin::FlexibleJointPrinted($plant)) => $call,
            Model::Builtin(Builtin::Chaotic($plant)) => $call,
            Model::Builtin(Builtin::Cuk($plant)) => $call,
            Model::Builtin(Builtin::ReverseDuffing($plant)) => $call,
            Model::Builtin(Builtin::VanDerPol($plant)) => $call,
            Model::Builtin(Builtin::ExponentialCascade($plant)) => $call,
        }
    };
}

/// Derivatives of expressions are those of their graph; of linear plants the matrices; of library plants dual numbers.
impl Differentiable<f64, Dyn, Dyn, Dyn> for Model {
    fn directional(
        &self,
        t: f64,
        x: &DVector<f64>,
        u: &DVector<f64>,
        v: &DVector<f64>,
    ) -> (DVector<f64>, DVector<f64>) {
        match self {
            Self::Expressions(plant, _) => plant.directional(t, x, u, v),
            _ => jacobian::apart(&self.derivative(Dual64::from_re(t), &jacobian::along(x, v), &u.map(Dual64::from_re))),
        }
    }

    fn output_directional(
        &self,
        t: f64,
        x: &DVector<f64>,
        u: &DVector<f64>,
        v: &DVector<f64>,
    ) -> (DVector<f64>, DVector<f64>) {
        match self {
            Self::Expressions(plant, _) => plant.output_directional(t, x, u, v),
            _ => jacobian::apart(&self.output(Dual64::from_re(t), &jacobian::along(x, v), &u.map(Dual64::from_re))),
        }
    }

    fn state_jacobian(&self, t: f64, x: &DVector<f64>, u: &DVector<f64>) -> DMatrix<f64> {
        match self {
            Self::Expressions(plant, _) => plant.state_jacobian(t, x, u),
            _ => columns(x.len(), x.len(), |v| self.directional(t, x, u, v).1),
        }
    }

    fn output_jacobian(&self, t: f64, x: &DVector<f64>, u: &DVector<f64>) -> DMatrix<f64> {
        match self {
            Self::Expressions(plant, _) => plant.output_jacobian(t, x, u),
            _ => columns(self.size().outputs, x.len(), |v| self.output_directional(t, x, u, v).1),
        }
    }

    fn is_linear_between_samples(&self) -> bool {
        match self {
            Self::Expressions(plant, _) => Differentiable::<f64, Dyn, Dyn, Dyn>::is_linear_between_samples(plant),
            // With the duty cycle held.
            Self::Builtin(Builtin::Cuk(_)) => true,
            _ => Plant::<f64>::is_affine(self),
        }
    }

    fn motion_into(&self, t: f64, x: &[f64], u: &[f64], f: &mut [f64], df: &mut [f64]) -> bool {
        if let Self::Expressions(plant, _) = self {
            return plant.motion_into(t, x, u, f, df);
        }
        let (state, input) = (DVector::from_column_slice(x), DVector::from_column_slice(u));
        self.derivative_into(t, x, u, f) && copy_into(&self.state_jacobian(t, &state, &input), df)
    }

    fn measurement_into(&self, t: f64, x: &[f64], u: &[f64], h: &mut [f64], dh: &mut [f64]) -> bool {
        if let Self::Expressions(plant, _) = self {
            return plant.measurement_into(t, x, u, h, dh);
        }
        let (state, input) = (DVector::from_column_slice(x), DVector::from_column_slice(u));
        self.output_into(t, x, u, h) && copy_into(&self.output_jacobian(t, &state, &input), dh)
    }
}

/// Copies a matrix out by columns; whether its size fits.
fn copy_into(matrix: &DMatrix<f64>, target: &mut [f64]) -> bool {
    let fits = matrix.len() == target.len();
    if fits {
        target.copy_from_slice(matrix.as_slice());
    }
    fits
}

/// The matrix of a linear map of n entries to `rows`.
fn columns(rows: usize, n: usize, map: impl Fn(&DVector<f64>) -> DVector<f64>) -> DMatrix<f64> {
    let mut matrix = DMatrix::zeros(rows, n);
    let mut direction = DVector::zeros(n);
    for j in 0..n {
        direction[j] = 1.0;
        matrix.set_column(j, &map(&direction));
        direction[j] = 0.0;
    }
    matrix
}

impl Shape for Model {
    fn dimensions(&self) -> Dimensions {
        each!(self, plant => plant.dimensions(), linear => linear.dimensions())
    }
}

impl<T: RealField + Copy> Plant<T> for Model {
    type State = DVector<T>;
    type Input = DVector<T>;
    type Output = DVector<T>;

    fn derivative(&self, t: T, x: &DVector<T>, u: &DVector<T>) -> DVector<T> {
        each!(self, plant => slope_of(plant, t, x, u), linear => product(&linear.a, x) + product(&linear.b, u))
    }

    fn output(&self, t: T, x: &DVector<T>, u: &DVector<T>) -> DVector<T> {
        each!(self, plant => output_of(plant, t, x, u), linear => match &linear.d {
            Some(d) => product(&linear.c, x) + product(d, u),
            None => product(&linear.c, x),
        })
    }

    fn is_affine(&self) -> bool {
        each!(self, plant => Plant::<T>::is_affine(plant), _linear => true)
    }

    fn derivative_into(&self, t: T, x: &[T], u: &[T], slope: &mut [T]) -> bool {
        each!(self, plant => Plant::<T>::derivative_into(plant, t, x, u, slope), linear => {
            let fits = (x.len(), u.len(), slope.len()) == (linear.a.ncols(), linear.b.ncols(), linear.a.nrows());
            if fits {
                for (i, slope) in slope.iter_mut().enumerate() {
                    *slope = row_times(&linear.a, i, x) + row_times(&linear.b, i, u);
                }
            }
            fits
        })
    }

    fn output_into(&self, t: T, x: &[T], u: &[T], y: &mut [T]) -> bool {
        each!(self, plant => Plant::<T>::output_into(plant, t, x, u, y), linear => {
            let fits = (x.len(), u.len(), y.len()) == (linear.c.ncols(), linear.b.ncols(), linear.c.nrows());
            if fits {
                for (i, y) in y.iter_mut().enumerate() {
                    let output = row_times(&linear.c, i, x);
                    *y = linear.d.as_ref().map_or(output, |d| output + row_times(d, i, u));
                }
            }
            fits
        })
    }
}
