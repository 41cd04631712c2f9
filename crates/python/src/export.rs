//! An observer as source code for the target.

use std::fmt::Display;

use luenberger_export::fmu::Version;
use luenberger_study::deployment::{Difference, ExportOptions, ExportRefusal, ExportedObserver, Libm, Precision};
use luenberger_study::results::Cause;
use pyo3::prelude::*;
use pyo3::types::{PyBytes, PyDict, PyTuple};

use crate::argument::{COUNT, TEXT, item};
use crate::array::list;
use crate::error::{self, dictionary};
use crate::words::{OF_CALL, Words};

/// The options of an export in words and numbers, as Python has them.
pub(crate) struct Request {
    to: String,
    fmi: Option<u8>,
    layout: Option<String>,
    libm: Option<String>,
    feedback: bool,
    format: String,
    gains: Option<String>,
    period: Option<f64>,
    substeps: Option<usize>,
    test_steps: Option<usize>,
    unproved: bool,
}

impl Request {
    /// The options in a dictionary.
    pub(crate) fn read(of: &Bound<'_, PyDict>) -> PyResult<Self> {
        let is = |name: &str| item(of, name, "True or False").map(Option::unwrap_or_default);
        Ok(Self {
            to: item(of, "to", "'c', 'rust' or 'fmu'")?.unwrap_or_else(|| "c".to_owned()),
            fmi: item(of, "fmi", "2 or 3")?,
            layout: item(of, "layout", TEXT)?,
            libm: item(of, "libm", "'own' or 'target'")?,
            feedback: is("feedback")?,
            format: item(of, "format", "a text, such as 'f64' or 'q16.16'")?.unwrap_or_else(|| "f64".to_owned()),
            gains: item(of, "gains", "a text, such as 'q4.28'")?,
            period: item(of, "period", "a number")?,
            substeps: item(of, "substeps", COUNT)?,
            test_steps: item(of, "test_steps", COUNT)?,
            unproved: is("unproved")?,
        })
    }

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
pub(crate) fn refused(py: Python<'_>, why: &ExportRefusal, words: &Words) -> PyErr {
    raised(py, why, &why.to_string(), words)
}

fn raised(py: Python<'_>, why: &ExportRefusal, message: &str, words: &Words) -> PyErr {
    let message = (words.advice)(message);
    match why {
        ExportRefusal::Design { why, .. } if matches!(why.cause.as_deref(), Some(Cause::Design(_))) => {
            error::design(py, why, words)
        }
        ExportRefusal::Options(_) => error::plain(py, "InvalidArgument", message),
        ExportRefusal::Design { why, .. } => {
            let alternatives: Vec<String> = why.advice().iter().map(|advice| (words.advice)(advice)).collect();
            let alternatives = PyTuple::new(py, alternatives);
            let numbers = alternatives.and_then(|alternatives| Ok(dictionary!(py; alternatives)));
            numbers.map_or_else(|error| error, |numbers| error::raise(py, "ExportRefused", message, &numbers))
        }
        _ => error::plain(py, "ExportRefused", message),
    }
}

/// The exception of an observer that cannot be stepped, whose step would be that of the exported code.
pub(crate) fn without_step(py: Python<'_>, why: &ExportRefusal) -> PyErr {
    let text = why.to_string();
    match why {
        ExportRefusal::Design { .. } | ExportRefusal::Numbers { .. } => {
            let text = text.replacen("cannot be exported", "cannot be stepped", 1);
            raised(py, why, &text, &OF_CALL)
        }
        _ => refused(py, why, &OF_CALL),
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
