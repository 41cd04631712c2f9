//! The plant of a study, read from its text by this module alone.

use std::collections::HashMap;

use super::document::{Table, Value};
use super::expression::Expression;
use nalgebra::DMatrix;

/// A plant.
#[derive(Debug, Clone)]
pub(super) struct Plant {
    pub(super) states: Vec<String>,
    pub(super) inputs: Vec<String>,
    pub(super) outputs: Vec<String>,
    /// The period of a plant in discrete time.
    pub(super) dt: Option<f64>,
    pub(super) law: Law,
    /// The names and values of parameters.
    pub(super) parameters: HashMap<String, f64>,
}

#[derive(Debug, Clone)]
pub(super) enum Law {
    Linear { a: DMatrix<f64>, b: DMatrix<f64>, c: DMatrix<f64>, d: Option<DMatrix<f64>> },
    Rows { f: Vec<Expression>, h: Vec<Expression> },
}

pub(super) fn matrix(value: &Value) -> Option<DMatrix<f64>> {
    let rows = value.rows()?;
    let columns = rows.first().map_or(0, Vec::len);
    rows.iter().all(|row| row.len() == columns).then(|| DMatrix::from_fn(rows.len(), columns, |i, j| rows[i][j]))
}

fn names(table: &Table, key: &str, letter: char, count: usize) -> Vec<String> {
    let given = table.get(key).and_then(Value::texts);
    given.unwrap_or_else(|| (1..=count).map(|k| format!("{letter}{k}")).collect())
}

impl Plant {
    /// The plant of a document.
    ///
    /// # Errors
    /// What this reader does not know: library plants, lookup tables.
    pub(super) fn read(study: &Table) -> Result<Self, String> {
        let plant = study.get("plant").and_then(Value::table).ok_or("no [plant]")?;
        let dt = plant.get("dt").and_then(Value::number);
        if let Some(a) = plant.get("a").and_then(matrix) {
            let n = a.nrows();
            let b = plant.get("b").and_then(matrix).unwrap_or_else(|| DMatrix::zeros(n, 0));
            let c = plant.get("c").and_then(matrix).ok_or("no c")?;
            let d = plant.get("d").and_then(matrix);
            return Ok(Self {
                states: names(plant, "states", 'x', n),
                inputs: names(plant, "inputs", 'u', b.ncols()),
                outputs: names(plant, "outputs", 'y', c.nrows()),
                dt,
                law: Law::Linear { a, b, c, d },
                parameters: HashMap::new(),
            });
        }
        let f = plant.get("f").and_then(Value::texts).ok_or("a plant of the library")?;
        let h = plant.get("h").and_then(Value::texts).ok_or("no h")?;
        let states = names(plant, "states", 'x', f.len());
        let used = |k: usize| f.iter().chain(&h).any(|row| contains_word(row, &format!("u{k}")));
        let count = (1..=9).filter(|k| used(*k)).max().unwrap_or(0);
        let inputs = names(plant, "inputs", 'u', count);
        let mut parameters = HashMap::new();
        for (name, value) in plant.get("parameters").and_then(Value::table).into_iter().flat_map(|table| &table.0) {
            parameters.insert(name.clone(), value.number().ok_or("a parameter that depends on others")?);
        }
        let mut variables = vec!["t".to_owned()];
        variables.extend(states.iter().chain(&inputs).cloned());
        let read = |rows: &[String]| -> Result<Vec<Expression>, String> {
            rows.iter().map(|row| Expression::read(row, &variables, &parameters)).collect()
        };
        Ok(Self {
            outputs: names(plant, "outputs", 'y', h.len()),
            law: Law::Rows { f: read(&f)?, h: read(&h)? },
            states,
            inputs,
            dt,
            parameters,
        })
    }

    /// x' or x+.
    pub(super) fn motion(&self, t: f64, x: &[f64], u: &[f64], into: &mut [f64]) {
        self.evaluate(true, t, x, u, into);
    }

    pub(super) fn output(&self, t: f64, x: &[f64], u: &[f64], into: &mut [f64]) {
        self.evaluate(false, t, x, u, into);
    }

    fn evaluate(&self, is_motion: bool, t: f64, x: &[f64], u: &[f64], into: &mut [f64]) {
        match &self.law {
            Law::Linear { a, b, c, d } => {
                let (on_x, on_u) = if is_motion { (a, Some(b)) } else { (c, d.as_ref()) };
                for (i, entry) in into.iter_mut().enumerate() {
                    let of_x: f64 = x.iter().enumerate().map(|(j, x)| on_x[(i, j)] * x).sum();
                    *entry = of_x + on_u.map_or(0.0, |m| u.iter().enumerate().map(|(j, u)| m[(i, j)] * u).sum());
                }
            }
            Law::Rows { f, h } => {
                let mut values = Vec::with_capacity(1 + x.len() + u.len());
                values.push(t);
                values.extend_from_slice(x);
                values.extend_from_slice(u);
                let rows = if is_motion { f } else { h };
                into.iter_mut().zip(rows).for_each(|(entry, row)| *entry = row.at(&values));
            }
        }
    }

    /// A, B, C and D, of a plant given by matrices.
    pub(super) fn matrices(&self) -> Option<Matrices<'_>> {
        match &self.law {
            Law::Linear { a, b, c, d } => Some((a, b, c, d.as_ref())),
            Law::Rows { .. } => None,
        }
    }

    /// The derivatives of f by x at a point, by differences.
    pub(super) fn jacobian(&self, t: f64, x: &[f64], u: &[f64]) -> DMatrix<f64> {
        let n = x.len();
        let mut found = DMatrix::zeros(n, n);
        let (mut low, mut high, mut moved) = (vec![0.0; n], vec![0.0; n], x.to_vec());
        for j in 0..n {
            let delta = 1e-6 * x[j].abs().max(1e-3);
            moved[j] = x[j] + delta;
            self.motion(t, &moved, u, &mut high);
            moved[j] = x[j] - delta;
            self.motion(t, &moved, u, &mut low);
            moved[j] = x[j];
            for i in 0..n {
                found[(i, j)] = (high[i] - low[i]) / (2.0 * delta);
            }
        }
        found
    }

    /// The numbers in its expressions.
    pub(super) fn numbers(&self) -> Vec<f64> {
        let mut all = Vec::new();
        if let Law::Rows { f, h } = &self.law {
            f.iter().chain(h).for_each(|row| row.numbers(&mut all));
        }
        all
    }
}

/// A, B, C and D.
type Matrices<'a> = (&'a DMatrix<f64>, &'a DMatrix<f64>, &'a DMatrix<f64>, Option<&'a DMatrix<f64>>);

/// Whether a name occurs in a text as a word.
pub(super) fn contains_word(text: &str, word: &str) -> bool {
    let is_part = |c: char| c.is_alphanumeric() || c == '_';
    text.match_indices(word).any(|(at, _)| {
        !text[..at].chars().next_back().is_some_and(is_part)
            && !text[at + word.len()..].chars().next().is_some_and(is_part)
    })
}
