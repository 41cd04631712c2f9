//! The structure of a plant: which outputs are states, which equations make a chain, what depends on what, and on time.
//!
//! It is read from the right-hand sides as they are written, never from values: what is said here holds for all states,
//! inputs and times. Matrices are read by their entries, expressions as sums of terms (`luenberger_expression::Terms`),
//! and a plant of the library as the expressions that state it ([`Model::expressions`]). What cannot be shown in this
//! way counts as not so: an output is not a state, and an equation depends on every variable that occurs in it.

use luenberger_expression::{Expression, Row, Terms, Variable};
use luenberger_plants::StateSpace;
use nalgebra::DMatrix;

use crate::model::Model;

/// The right-hand sides of a plant as sums of terms. States, inputs and outputs are counted from 0.
#[derive(Debug, Clone, PartialEq)]
pub struct Structure {
    f: Vec<Terms>,
    h: Vec<Terms>,
}

impl Model {
    /// Which outputs are states, and what depends on what.
    pub fn structure(&self) -> Structure {
        Structure::of(self)
    }
}

impl Structure {
    /// That of a plant.
    fn of(model: &Model) -> Self {
        if let Model::Linear(plant) = model {
            return Self::of_matrices(plant);
        }
        let rows = |list: &[Expression]| list.iter().map(Expression::terms).collect();
        // Without expressions there are no rows, and nothing is shown.
        model
            .expressions()
            .map_or(Self { f: Vec::new(), h: Vec::new() }, |plant| Self { f: rows(plant.f()), h: rows(plant.h()) })
    }

    fn of_matrices(plant: &StateSpace) -> Self {
        let no_inputs = DMatrix::zeros(plant.c.nrows(), 0);
        let rows = |states: &DMatrix<f64>, inputs: &DMatrix<f64>| -> Vec<Terms> {
            let of = |matrix: &DMatrix<f64>, i: usize, variable: fn(usize) -> Variable| -> Vec<(Variable, f64)> {
                matrix.row(i).iter().enumerate().map(|(j, factor)| (variable(j), *factor)).collect()
            };
            (0..states.nrows())
                .map(|i| of(states, i, Variable::State).into_iter().chain(of(inputs, i, Variable::Input)).collect())
                .collect()
        };
        Self { f: rows(&plant.a, &plant.b), h: rows(&plant.c, plant.d.as_ref().unwrap_or(&no_inputs)) }
    }

    /// The state that output k is, if it is shown to be one.
    pub fn output_state(&self, k: usize) -> Option<usize> {
        state(self.h.get(k)?)
    }

    /// Whether the derivative of state i is shown to be the next state: `x_i' = x_(i+1)`.
    pub fn is_next_state(&self, i: usize) -> bool {
        self.f.get(i).and_then(state) == Some(i + 1)
    }

    /// Whether the derivative of state i may depend on state j.
    pub fn depends_on(&self, i: usize, j: usize) -> bool {
        self.f.get(i).is_none_or(|row| row.depends_on(Variable::State(j)))
    }

    /// Whether state j enters the derivative of state i with a constant factor, or not at all.
    pub fn has_constant_factor(&self, i: usize, j: usize) -> bool {
        self.f.get(i).is_some_and(|row| row.is_linear_in(Variable::State(j)))
    }

    /// Whether a row is certainly not state j: it does not depend on it, or is another sum of multiples.
    pub fn differs(&self, row: Row, j: usize) -> bool {
        let row = match row {
            Row::Derivative(i) => self.f.get(i),
            Row::Output(k) => self.h.get(k),
        };
        row.is_some_and(|row| state(row) != Some(j) && (row.is_affine() || !row.depends_on(Variable::State(j))))
    }

    /// Whether all outputs are linear in the states, with constant factors.
    pub fn has_linear_outputs(&self) -> bool {
        let is_linear = |row: &Terms| row.variables().all(|x| matches!(x, Variable::Input(_)) || row.is_linear_in(x));
        !self.h.is_empty() && self.h.iter().all(is_linear)
    }

    /// The first row that may depend on the time, f before h.
    pub fn explicit_time(&self) -> Option<Row> {
        let first = self.f.iter().position(Terms::uses_time).map(Row::Derivative);
        first.or_else(|| self.timed_output().map(Row::Output))
    }

    /// The first output that may depend on the time.
    pub fn timed_output(&self) -> Option<usize> {
        self.h.iter().position(Terms::uses_time)
    }

    /// The first output that may depend on an input at once.
    pub fn feedthrough(&self) -> Option<usize> {
        self.h.iter().position(reads_inputs)
    }
}

/// The state that a row is.
fn state(row: &Terms) -> Option<usize> {
    match row.variable()? {
        Variable::State(i) => Some(i),
        Variable::Input(_) => None,
    }
}

fn reads_inputs(row: &Terms) -> bool {
    row.variables().any(|variable| matches!(variable, Variable::Input(_)))
}
