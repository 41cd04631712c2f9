//! A model as a study file, to be run and edited.

use super::Model;
use luenberger_linalg::eigenvalues;
use luenberger_proof::wording::significant;
use nalgebra::DMatrix;
use std::fmt::Write;

impl Model {
    /// The study file (TOML) of this plant: its matrices with all digits, a simulation from the initial state of all
    /// ones, and a Kalman filter; comments explain what to change. `title` may be any text.
    pub fn study(&self, title: &str) -> String {
        let n = self.a.nrows();
        let mut text = format!("title = {}\n", quoted(title));
        if !self.ignored.is_empty() {
            let names: Vec<String> = self.ignored.iter().map(|name| quoted(name)).collect();
            _ = writeln!(text, "# Not used of the file: {}.", names.join(", "));
        }
        text.push_str("\n[plant]\n");
        if let Some(condition) = self.descriptor {
            let condition = significant(condition, 2);
            _ = writeln!(text, "# E^-1 A and E^-1 B of the file; condition number of E, balanced: {condition}.");
        }
        matrix(&mut text, "a", &self.a);
        if self.b.ncols() > 0 {
            matrix(&mut text, "b", &self.b);
        }
        matrix(&mut text, "c", &self.c);
        if let Some(d) = &self.d {
            matrix(&mut text, "d", d);
        }
        for (key, names) in [("states", &self.states), ("inputs", &self.inputs), ("outputs", &self.outputs)] {
            if let Some(names) = names {
                let names: Vec<String> = names.iter().map(|name| quoted(name)).collect();
                _ = writeln!(text, "{key} = [{}]", names.join(", "));
            }
        }
        if let Some(dt) = self.dt {
            text.push_str("# In discrete time, x+ = A x + B u.\n");
            _ = writeln!(text, "dt = {dt:?}");
        }
        text.push_str("\n[simulation]\n# The state at t = 0; each observer begins with zeros.\n");
        list(&mut text, "x0", &vec![1.0; n]);
        text.push_str("# In the unit of time of A.\n");
        _ = writeln!(text, "duration = {:?}", self.duration());
        text.push_str("\n[[observer]]\nname = \"kalman\"\nkind = \"kalman\"\n");
        let noise = if self.dt.is_some() { "Covariances per sample" } else { "Intensities" };
        _ = writeln!(
            text,
            "# {noise} of the noise on the state and on the outputs: what matters is their ratio.\nw = 1.0\nv = 1.0"
        );
        text
    }

    /// A power of ten, about ten times the slowest nonzero time constant.
    fn duration(&self) -> f64 {
        let rate = |lambda: &nalgebra::Complex<f64>| match self.dt {
            Some(dt) => lambda.ln().norm() / dt,
            None => lambda.norm(),
        };
        let poles = eigenvalues(&self.a).unwrap_or_default();
        // A pole at 0 in discrete time is gone after one sample.
        let rates: Vec<f64> = poles.iter().map(rate).filter(|rate| rate.is_finite()).collect();
        // Eigenvalues six decades below the fastest count as zero, since the simulation would take too long.
        let rest = 1e-6 * rates.iter().copied().fold(0.0, f64::max);
        let slowest = rates.into_iter().filter(|&rate| rate > rest).fold(f64::INFINITY, f64::min);
        if slowest.is_finite() { 10.0_f64.powi((-slowest.log10()).round().clamp(-12.0, 12.0) as i32 + 1) } else { 10.0 }
    }
}

/// `name = [` and one row on each line.
fn matrix(text: &mut String, name: &str, m: &DMatrix<f64>) {
    _ = writeln!(text, "{name} = [");
    for row in m.row_iter() {
        let row: Vec<String> = row.iter().map(|x| format!("{x:?}")).collect();
        _ = writeln!(text, "  [{}],", row.join(", "));
    }
    text.push_str("]\n");
}

fn list(text: &mut String, name: &str, values: &[f64]) {
    let values: Vec<String> = values.iter().map(|x| format!("{x:?}")).collect();
    _ = writeln!(text, "{name} = [{}]", values.join(", "));
}

/// A basic string of TOML.
fn quoted(text: &str) -> String {
    let mut quoted = String::from('"');
    for c in text.chars() {
        match c {
            '"' | '\\' => quoted.extend(['\\', c]),
            c if c.is_control() => _ = write!(quoted, "\\u{:04X}", c as u32),
            c => quoted.push(c),
        }
    }
    quoted.push('"');
    quoted
}
