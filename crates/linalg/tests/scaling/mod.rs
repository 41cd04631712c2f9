//! The property that units do not matter: *states, inputs, outputs, disturbances and time are multiplied by powers of
//! two between 2^-40 and 2^40; the verdict, the gain and every number in its units stay the same.*
//!
//! A plant is a list of matrices, each with its [`Unit`]; a routine is a function from a plant to an [`Answer`], a
//! verdict and matrices with their units. [`unchanged`] asks it for the plant and for the same plant in other units,
//! takes the second answer back, and compares. Used by the tests of this crate and, by its path, by those of others.

#![allow(unreachable_pub, dead_code, reason = "shared by path; no crate uses all of it")]

use nalgebra::{Complex, DMatrix};

/// What an index of a matrix counts.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Axis {
    State,
    Input,
    Output,
    Disturbance,
    /// The equations of a descriptor plant `E x' = A x`.
    Equation,
    /// Numbers without a unit, as the states of an observer of lower order.
    One,
}

/// The unit of an entry: that of its row times that of its column, each to a power, times a power of the unit of time,
/// and of cost.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Unit {
    pub row: (Axis, i32),
    pub column: (Axis, i32),
    pub time: i32,
    pub cost: i32,
}

pub const fn unit(row: (Axis, i32), column: (Axis, i32), time: i32) -> Unit {
    Unit { row, column, time, cost: 0 }
}

impl Unit {
    pub const fn cost(self, cost: i32) -> Self {
        Self { cost, ..self }
    }
}

/// The units in which a plant is written, as powers of two: a number x of the state j becomes `2^state[j] x`, and so
/// on.
#[derive(Debug, Clone)]
pub struct Units {
    pub state: Vec<i32>,
    pub input: Vec<i32>,
    pub output: Vec<i32>,
    pub disturbance: Vec<i32>,
    pub equation: Vec<i32>,
    pub time: i32,
    pub cost: i32,
}

/// The largest power.
pub const LARGEST: i32 = 40;

impl Units {
    /// From numbers between -1 and 1, as many as are needed, at most 30.
    pub fn drawn(numbers: &[f64]) -> Self {
        let mut numbers = numbers.iter().map(|x| (x * f64::from(LARGEST)).round() as i32).cycle();
        let mut next = |count: usize| (0..count).map(|_| numbers.next().unwrap()).collect::<Vec<_>>();
        Self {
            state: next(6),
            input: next(3),
            output: next(3),
            disturbance: next(3),
            equation: next(6),
            time: next(1)[0],
            cost: next(1)[0],
        }
    }

    /// As these, with a unit common to all outputs and one common to all inputs: for norms.
    pub fn common(mut self) -> Self {
        let (input, output) = (self.input[0], self.output[0]);
        self.input.fill(input);
        self.output.fill(output);
        self
    }

    /// As these, without a unit of time: in discrete time it is the step.
    pub fn discrete(self) -> Self {
        Self { time: 0, ..self }
    }

    fn of(&self, (axis, power): (Axis, i32), index: usize) -> i32 {
        power
            * match axis {
                Axis::State => self.state[index],
                Axis::Input => self.input[index],
                Axis::Output => self.output[index],
                Axis::Disturbance => self.disturbance[index],
                Axis::Equation => self.equation[index],
                Axis::One => 0,
            }
    }

    /// The numbers of `m`, which has this unit, in these units; with `sign` -1 back.
    pub fn apply(&self, m: &DMatrix<f64>, unit: Unit, sign: i32) -> DMatrix<f64> {
        DMatrix::from_fn(m.nrows(), m.ncols(), |i, j| {
            let common = unit.time * self.time + unit.cost * self.cost;
            let power = sign * (self.of(unit.row, i) + self.of(unit.column, j) + common);
            // In two steps: 2^power may be out of range where the product is not.
            m[(i, j)] * 2f64.powi(power / 2) * 2f64.powi(power - power / 2)
        })
    }

    /// A frequency in these units; with `sign` -1 back.
    pub fn frequency(&self, z: Complex<f64>, sign: i32) -> Complex<f64> {
        z * 2f64.powi(-sign * self.time)
    }

    /// A duration in these units.
    pub fn duration(&self, t: f64) -> f64 {
        t * 2f64.powi(self.time)
    }
}

/// A result: of one routine, always the same number of values.
#[derive(Debug, Default)]
pub struct Answer {
    /// A verdict in words, or the name of an error.
    pub verdict: String,
    /// Matrices with their units, and their relative accuracy in the Frobenius norm of the plant's first units.
    pub values: Vec<(DMatrix<f64>, Unit, f64)>,
    /// Sets of frequencies, with their accuracy relative to the largest.
    pub spectra: Vec<(Vec<Complex<f64>>, f64)>,
}

impl Answer {
    pub fn verdict(words: impl Into<String>) -> Self {
        Self { verdict: words.into(), ..Self::default() }
    }

    /// The name of an error: the numbers in it have units.
    pub fn refused(error: &impl std::fmt::Debug) -> Self {
        let text = format!("{error:?}");
        let end = text.find(|c: char| !(c.is_alphanumeric() || c == '_')).unwrap_or(text.len());
        Self::verdict(&text[..end])
    }

    pub fn value(mut self, m: &DMatrix<f64>, unit: Unit, accuracy: f64) -> Self {
        self.values.push((m.clone(), unit, accuracy));
        self
    }

    pub fn spectrum(mut self, poles: &[Complex<f64>], accuracy: f64) -> Self {
        self.spectra.push((poles.to_vec(), accuracy));
        self
    }
}

/// Why two answers differ; `other` is the one in `units`.
pub fn difference(first: &Answer, other: &Answer, units: &Units) -> Option<String> {
    if first.verdict != other.verdict {
        return Some(format!("{} and {}", first.verdict, other.verdict));
    }
    for (at, ((x, unit, accuracy), (y, ..))) in first.values.iter().zip(&other.values).enumerate() {
        let back = units.apply(y, *unit, -1);
        let error = (&back - x).norm();
        if error.is_nan() || error > *accuracy * x.norm() {
            return Some(format!("value {at} differs by {:e}, allowed {accuracy:e}:{x}{back}", error / x.norm()));
        }
    }
    for ((x, accuracy), (y, other)) in first.spectra.iter().zip(&other.spectra) {
        let size = x.iter().map(|z| z.norm()).fold(0.0, f64::max);
        let accuracy = accuracy.max(*other);
        let mut left: Vec<Complex<f64>> = y.iter().map(|z| units.frequency(*z, -1)).collect();
        if x.len() != left.len() {
            return Some(format!("{x:?} and {left:?}"));
        }
        for z in x {
            let distance = |k: &usize| (left[*k] - z).norm();
            let Some(nearest) = (0..left.len()).min_by(|i, j| distance(i).total_cmp(&distance(j))) else { continue };
            if distance(&nearest) > accuracy * size {
                return Some(format!("{z} has no partner in {left:?}"));
            }
            left.swap_remove(nearest);
        }
    }
    None
}
