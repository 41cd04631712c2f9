//! An observer as source code for the target.

use std::fmt::Display;

use luenberger_export::fmu::Version;
use luenberger_study::deployment::{Difference, ExportOptions, ExportRefusal, ExportedObserver, Libm, Precision};
use luenberger_study::results::Cause;
use pyo3::prelude::*;
use pyo3::types::{PyBytes, PyDict, PyTuple};

use crate::array::list;
use crate::error::{self, dictionary};
use crate::run::in_python;

/// The options of an export in words and numbers, as Python has them.
#[derive(FromPyObject)]
#[pyo3(from_item_all)]
pub(crate) struct Request {
    #[pyo3(default = "c".to_owned())]
    to: String,
    #[pyo3(default)]
    fmi: Option<u8>,
    #[pyo3(default)]
    layout: Option<String>,
    #[pyo3(default)]
    libm: Option<String>,
    #[pyo3(default)]
    feedback: bool,
    format: String,
    #[pyo3(default)]
    gains: Option<String>,
    period: Option<f64>,
    substeps: Option<usize>,
    #[pyo3(default)]
    test_steps: Option<usize>,
    #[pyo3(default)]
    unproved: bool,
}

impl Request {
    pub(crate) fn options(&self, py: Python<'_>) -> PyResult<ExportOptions<'static>> {
        let invalid = |what: &str, found: &dyn Display, why: &str| {
            error::plain(py, "InvalidArgument", format!("{what} is {found}: {why}"))
        };
        let default = ExportOptions::default();
        let fmi = match self.fmi {
            None => None,
            Some(2) => Some(Version::Two),
            Some(3) => Some(Version::Three),
            Some(other) => return Err(invalid("fmi", &other, "2 or 3 is expected")),
        };
        let format = |word: &String| word.parse().map_err(|why: String| invalid("format", word, &why));
        let layout = |word: &String| word.parse().map_err(|why: String| invalid("layout", word, &why));
        let gains = |word: &String| Precision::fixed_point(word).map_err(|why| invalid("gains", word, &why));
        Ok(ExportOptions {
            to: self.to.parse().map_err(|why: String| invalid("to", &self.to, &why))?,
            fmi,
            layout: self.layout.as_ref().map(layout).transpose()?,
            libm: match self.libm.as_deref() {
                None | Some("own") => Libm::Own,
                Some("target") => Libm::Target,
                Some(other) => return Err(invalid("libm", &other, "own or target is expected")),
            },
            feedback: self.feedback,
            format: format(&self.format)?,
            gains: self.gains.as_ref().map(gains).transpose()?,
            period: self.period,
            substeps: self.substeps,
            test_steps: self.test_steps.unwrap_or(default.test_steps),
            unproved: self.unproved,
            ..default
        })
    }
}

/// The exception of a refusal.
pub(crate) fn refused(py: Python<'_>, why: &ExportRefusal) -> PyErr {
    let message = in_python(&why.to_string());
    match why {
        ExportRefusal::Design { why, .. } if matches!(why.cause.as_deref(), Some(Cause::Design(_))) => {
            error::design(py, why)
        }
        ExportRefusal::Options(_) => error::plain(py, "InvalidArgument", message),
        ExportRefusal::Design { why, .. } => {
            let alternatives: Vec<String> = why.advice().iter().map(|advice| in_python(advice)).collect();
            let alternatives = PyTuple::new(py, alternatives);
            let numbers = alternatives.and_then(|alternatives| Ok(dictionary!(py; alternatives)));
            numbers.map_or_else(|error| error, |numbers| error::raise(py, "ExportRefused", message, &numbers))
        }
        _ => error::plain(py, "ExportRefused", message),
    }
}

/// What is exported, for `luenberger.Export`.
pub(crate) fn files<'py>(py: Python<'py>, exported: &ExportedObserver) -> PyResult<Bound<'py, PyDict>> {
    let files = PyDict::new(py);
    for (name, content) in &exported.files {
        files.set_item(name, PyBytes::new(py, content))?;
    }
    let difference = match &exported.difference {
        Some(Difference { largest, late, own }) => {
            let (second_half, own_error_in_second_half) = (list(py, late), list(py, own));
            Some(dictionary!(py; largest = list(py, largest), second_half, own_error_in_second_half))
        }
        None => None,
    };
    let ExportedObserver { binaries, notes, statement, proved, period, .. } = exported;
    let ExportedObserver { operations, operations_within_bounds, bytes, substeps, digest, .. } = exported;
    Ok(dictionary!(py; files, binaries, notes, statement, proved, period, operations, operations_within_bounds, bytes,
        substeps, difference, digest))
}
