//! An observer with given maps as one set of expressions, which can be printed as source code: its right-hand side and
//! its estimate in the state z and in (u, y), and the start of z.
//!
//! The right-hand side is that of `luenberger_observers::{kkl, kkl_peb}` written out; that both agree is tested. What
//! differs: an entry that overflows is not held.

use super::names::MapNames;
use crate::model::PlantModel;
use luenberger_expression::{ExpressionPlant, Scope};
use luenberger_observers::{Observer, ObserverDimensions};
use luenberger_plants::{Plant, Shape};
use nalgebra::{DVector, RealField};

/// The rows without one of them and without one column.
pub(super) fn without(entries: &[Vec<String>], row: usize, column: usize) -> Vec<Vec<String>> {
    let kept = |row: &Vec<String>| (0..row.len()).filter(|j| *j != column).map(|j| row[j].clone()).collect();
    entries.iter().enumerate().filter(|(i, _)| *i != row).map(|(_, row)| kept(row)).collect()
}

pub(super) fn determinant(entries: &[Vec<String>]) -> String {
    let Some(first) = entries.first() else { return "1".to_owned() };
    let term = |j: usize| {
        let minor = determinant(&without(entries, 0, j));
        format!("{}{}*({minor})", if j.is_multiple_of(2) { "+" } else { "-" }, first[j])
    };
    let terms: Vec<String> = (0..first.len()).map(term).collect();
    terms.join(" ").trim_start_matches('+').to_owned()
}

/// A number as an operand.
pub(super) fn operand(x: f64) -> String {
    format!("({x:?})")
}

/// The text with some of its names replaced.
pub(super) fn renamed(text: &str, name: impl Fn(&str) -> Option<String>) -> String {
    let is_part = |c: char| c.is_alphanumeric() || c == '_' || c == '.';
    let mut result = String::new();
    let mut rest = text;
    while let Some(first) = rest.chars().next() {
        let length = if is_part(first) { rest.find(|c| !is_part(c)).unwrap_or(rest.len()) } else { first.len_utf8() };
        let (word, after) = rest.split_at(length);
        match name(word) {
            Some(other) => result.push_str(&other),
            None => result.push_str(word),
        }
        rest = after;
    }
    result
}

/// An observer of expressions.
#[derive(Debug)]
pub(crate) struct Written {
    pub(super) flow: ExpressionPlant,
    pub(super) start: ExpressionPlant,
    pub(super) inputs: usize,
    pub(super) outputs: usize,
}

impl<T: RealField + Copy> Observer<T> for Written {
    type State = DVector<T>;
    type Input = DVector<T>;
    type Output = DVector<T>;
    type Estimate = DVector<T>;

    fn dimensions(&self) -> ObserverDimensions {
        let size = self.flow.dimensions();
        let (inputs, outputs) = (self.inputs, self.outputs);
        ObserverDimensions { state: size.states, inputs, outputs, estimate: size.outputs }
    }

    fn derivative(&self, t: T, z: &DVector<T>, u: &DVector<T>, y: &DVector<T>) -> DVector<T> {
        self.flow.derivative(t, z, &joined(u, y))
    }

    fn estimate(&self, t: T, z: &DVector<T>, u: &DVector<T>, y: &DVector<T>) -> DVector<T> {
        self.flow.output(t, z, &joined(u, y))
    }

    fn initial(&self, t: T, estimate: &DVector<T>, _u: &DVector<T>, y: &DVector<T>) -> DVector<T> {
        self.start.output(t, estimate, y)
    }
}

fn joined<T: RealField + Copy>(u: &DVector<T>, y: &DVector<T>) -> DVector<T> {
    DVector::from_iterator(u.len() + y.len(), u.iter().chain(y.iter()).copied())
}

/// The observer of these rows: its right-hand side, its estimate and its start.
pub(super) fn built(
    plant: &PlantModel,
    order: usize,
    (rate, estimate, start): (&[String], &[String], &[String]),
) -> Result<Written, String> {
    let names = MapNames::new(plant, order);
    let words = |error: &dyn std::fmt::Display| error.to_string();
    let within = |f: &[String], h: &[String], scope: Result<Scope, luenberger_expression::ParameterError>| {
        let scope = scope.map_err(|error| words(&error))?;
        ExpressionPlant::within(f, h, &scope).map_err(|error| words(&error))
    };
    let still: Vec<String> = plant.states.iter().map(|_| "0".to_owned()).collect();
    let flow = within(rate, estimate, names.whole(rate.len()))?;
    let start = within(&still, start, names.start())?;
    Ok(Written { flow, start, inputs: plant.inputs.len(), outputs: plant.outputs.len() })
}
