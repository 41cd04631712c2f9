//! The kernels: the loops of the observers as C, in the files beside this one.
//!
//! A kernel is C99 over macros: `NUMBER` for the type of the numbers, `STATES`, `INPUTS` and `OUTPUTS`, `REAL(0.5)` for
//! a literal, `ROOT`, `MAGNITUDE` and `LARGEST` for the format, further numbers, and options that are 1 or 0. With
//! `typical.h` it compiles on its own, which a test does in both formats and with every option.
//!
//! An export has the text of its kernels with values in place of the macros and without the parts of other options, so
//! that its reader sees plain C. Names that begin with `observer_` begin with the name of the export instead.

use std::collections::BTreeMap;

use super::scalar;
use crate::scalar::Scalar;
use crate::{Export, number};

pub(super) const ANGLES: &str = include_str!("angles.c");
pub(super) const BETWEEN: &str = include_str!("between.c");
pub(super) const CLASSICAL: &str = include_str!("classical.c");
pub(super) const COLUMNS: &str = include_str!("columns.c");
pub(super) const CONSTANT_GAIN_STEP: &str = include_str!("constant_gain_step.c");
pub(super) const FEEDBACK: &str = include_str!("feedback.c");
pub(super) const FILTER_HALVES: &str = include_str!("filter_halves.c");
pub(super) const FILTER_STEP: &str = include_str!("filter_step.c");
pub(super) const FIXED_POINT: &str = include_str!("fixed_point.c");
pub(super) const GAUSS_NEWTON: &str = include_str!("gauss_newton.c");
pub(super) const HORNER: &str = include_str!("horner.c");
pub(super) const HORNER_NEXT: &str = include_str!("horner_next.c");
pub(super) const INNOVATION: &str = include_str!("innovation.c");
pub(super) const INTERIOR_POINT: &str = include_str!("interior_point.c");
pub(super) const KALMAN: &str = include_str!("kalman.c");
pub(super) const KKL: &str = include_str!("kkl.c");
pub(super) const KKL_SLOPE: &str = include_str!("kkl_slope.c");
pub(super) const KKL_STEP: &str = include_str!("kkl_step.c");
pub(super) const MOVING_HORIZON: &str = include_str!("moving_horizon.c");
pub(super) const NEAREST: &str = include_str!("nearest.c");
pub(super) const NOISE: &str = include_str!("noise.c");
pub(crate) const OUTPUT_ERROR: &str = include_str!("output_error.c");
pub(super) const POLYNOMIAL_TREE: &str = include_str!("polynomial_tree.c");
pub(super) const RECORDED_FLOW: &str = include_str!("recorded_flow.c");
pub(super) const RECORDED_SLOPE: &str = include_str!("recorded_slope.c");
pub(super) const RECORDED_START: &str = include_str!("recorded_start.c");
pub(super) const RECORDED_STEP: &str = include_str!("recorded_step.c");
pub(super) const RESET: &str = include_str!("reset.c");
pub(super) const RUNGE_KUTTA: &str = include_str!("runge_kutta.c");
pub(super) const SPLINE_TABLE: &str = include_str!("spline_table.c");
pub(super) const START: &str = include_str!("start.c");
pub(super) const STATIONARY_STEP: &str = include_str!("stationary_step.c");
pub(super) const SYMMETRIC: &str = include_str!("symmetric.c");
pub(super) const TRANSITION: &str = include_str!("transition.c");
pub(super) const UNIT_VECTORS: &str = include_str!("unit_vectors.c");
pub(super) const UNSCENTED: &str = include_str!("unscented.c");
pub(super) const VARYING: &str = include_str!("varying.c");

/// What the macros of the kernels stand for in an export.
pub(crate) struct Macros {
    values: BTreeMap<&'static str, String>,
    scalar: Scalar,
    /// Whether the step of the observer is a part of the step of a block with feedback.
    is_part: bool,
}

impl Macros {
    /// Type, functions of the format, sizes, and the time.
    pub(crate) fn of(export: &Export) -> Self {
        let mut all = Self { values: BTreeMap::new(), scalar: export.scalar, is_part: export.feedback.is_some() };
        let (name, upper) = (&export.identifier, export.identifier.to_uppercase());
        all.set("NUMBER", scalar(export));
        let [root, magnitude, floor, largest] = match export.scalar {
            Scalar::Binary32 => ["sqrtf", "fabsf", "floorf", "FLT_MAX"],
            Scalar::Binary64 => ["sqrt", "fabs", "floor", "DBL_MAX"],
        };
        all.set("ROOT", root);
        all.set("MAGNITUDE", magnitude);
        all.set("FLOOR", floor);
        all.set("LARGEST", largest);
        for size in ["STATES", "INPUTS", "OUTPUTS", "WINDOW"] {
            all.set(size, format!("{upper}_{size}"));
        }
        all.set("observer_", format!("{name}_"));
        all.option("HAS_INPUTS", !export.names.inputs.is_empty());
        all.option("HAS_FEEDTHROUGH", export.observer.feedthrough().is_some() && !export.names.inputs.is_empty());
        all.option("FILTER_FORM", export.is_filter());
        all.option("TIMED", export.observer.uses_time());
        all.number("PERIOD", export.observer.period());
        all.set("MOTION", "motion");
        all.set("SLOPE", "slope");
        let [tau, half, sixth] = export.observer.increments(export.scalar);
        let steps = [("TAU", tau), ("HALF_TAU", half), ("QUARTER_TAU", 0.5 * half), ("SIXTH_TAU", sixth)];
        for (name, x) in steps.into_iter().chain([("THIRD", 1.0 / 3.0)]) {
            all.number(name, x);
        }
        let steps = [("T_STEP", "t + (TAU * (NUMBER)step)"), ("T_MIDDLE", "t + HALF_TAU"), ("T_END", "t + TAU")];
        for (name, time) in steps {
            all.set(name, if export.observer.uses_time() { all.replaced(time) } else { "t".to_owned() });
        }
        let substeps = export.observer.substeps();
        all.option("DISCRETE", substeps.is_none());
        all.option("SEVERAL_STEPS", substeps.is_some_and(|count| count > 1));
        all.integer("SUBSTEPS", substeps.unwrap_or_default());
        all.option("ANGLES", export.observer.turns().is_some());
        let vectors = export.observer.unit_vectors();
        all.option("HAS_UNIT_VECTORS", vectors.is_some());
        all.integer("VECTORS", vectors.map_or(0, |vectors| vectors.max() as usize));
        let gate = export.scalars().into_iter().find(|(name, _)| *name == "GATE");
        all.option("GATED", gate.is_some());
        all.option("PARTIAL", gate.is_some() || export.names.outputs.len() > 1);
        all.number("GATE_SQUARED", gate.map_or(0.0, |(_, gate)| export.scalar.multiply(gate, gate)));
        all
    }

    pub(crate) fn set(&mut self, name: &'static str, value: impl Into<String>) {
        self.values.insert(name, value.into());
    }

    /// A part that is there or not.
    pub(crate) fn option(&mut self, name: &'static str, is_there: bool) {
        self.set(name, if is_there { "1" } else { "0" });
    }

    pub(crate) fn integer(&mut self, name: &'static str, x: usize) {
        self.set(name, x.to_string());
    }

    /// A number, rounded to the format.
    pub(crate) fn number(&mut self, name: &'static str, x: f64) {
        let literal = number::c(x, self.scalar);
        self.set(name, if literal.starts_with('-') { format!("({literal})") } else { literal });
    }

    /// Writes a kernel: what follows its head, which ends with the last line about files to include.
    pub(crate) fn write(&self, text: &mut String, kernel: &str) {
        let head = kernel.rfind("\n#include \"").map_or(0, |at| at + 1);
        let body = kernel[head..].find("\n\n").map_or("", |end| &kernel[head + end + 1..]);
        let head = "(observer_state *state, const NUMBER *u, const NUMBER *y, NUMBER *xhat)";
        let part = body.replace(&format!("void observer_step{head}"), &format!("static void observe{head}"));
        let body = if self.is_part { &part } else { body };
        // Whether the lines are there, for each condition around them.
        let mut conditions: Vec<bool> = Vec::new();
        for line in body.lines() {
            if let Some(condition) = line.strip_prefix("#if ") {
                conditions.push(self.is_true(condition));
            } else if line == "#else" {
                conditions.last_mut().iter_mut().for_each(|is_there| **is_there = !**is_there);
            } else if line == "#endif" {
                conditions.pop();
            } else if conditions.iter().all(|is_there| *is_there) {
                text.push_str(&self.replaced(line));
                text.push('\n');
            }
        }
    }

    /// `OPTION` or `!OPTION`.
    fn is_true(&self, condition: &str) -> bool {
        let name = condition.trim_start_matches('!');
        let value = self.values.get(name).is_some_and(|value| value != "0");
        value != condition.starts_with('!')
    }

    /// A line with the values of its macros.
    fn replaced(&self, line: &str) -> String {
        let is_letter = |letter: char| letter.is_ascii_alphanumeric() || letter == '_';
        let mut text = String::new();
        let mut rest = line;
        while let Some(first) = rest.chars().next() {
            let end = rest.find(|letter| is_letter(letter) != is_letter(first)).unwrap_or(rest.len());
            let (word, after) = rest.split_at(end);
            rest = after;
            if let (Some(literal), "REAL") = (after.strip_prefix('('), word) {
                let (digits, after) = literal.split_once(')').unwrap_or((literal, ""));
                let suffix = if self.scalar == Scalar::Binary32 { "f" } else { "" };
                text.extend([digits, suffix]);
                rest = after;
            } else if let Some(value) = self.values.get(word) {
                text.push_str(value);
            } else if let (Some(part), Some(name)) = (word.strip_prefix("observer_"), self.values.get("observer_")) {
                text.extend([name, part]);
            } else {
                text.push_str(word);
            }
        }
        text
    }
}
