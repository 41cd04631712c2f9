//! Errors as exceptions of `luenberger.errors`, with their numbers as attributes.

use luenberger_design::DesignError;
use luenberger_linalg::LinalgError;
use luenberger_observers::ObserverError;
use luenberger_study::results::{Cause, NoObserver};
use pyo3::prelude::*;
use pyo3::types::PyDict;

use crate::array::complex;
use crate::words::Words;

/// A dictionary of names and values; a name alone is its own value.
macro_rules! dictionary {
    ($py:expr; $($name:ident $(= $value:expr)?),* $(,)?) => {{
        let dictionary = pyo3::types::PyDict::new($py);
        $( dictionary.set_item(stringify!($name), dictionary!(@ $name $(, $value)?))?; )*
        dictionary
    }};
    (@ $name:ident) => { $name };
    (@ $name:ident, $value:expr) => { $value };
}
pub(crate) use dictionary;

/// The exception of that class, or the reason why there is none.
pub(crate) fn raise(py: Python<'_>, class: &str, message: String, numbers: &Bound<'_, PyDict>) -> PyErr {
    let value = py
        .import("luenberger.errors")
        .and_then(|errors| errors.getattr(class))
        .and_then(|class| class.call((message,), Some(numbers)));
    value.map_or_else(|error| error, PyErr::from_value)
}

/// An exception without numbers.
pub(crate) fn plain(py: Python<'_>, class: &str, message: impl ToString) -> PyErr {
    raise(py, class, message.to_string(), &PyDict::new(py))
}

pub(crate) fn linalg(py: Python<'_>, error: &LinalgError) -> PyErr {
    class_of(py, error).map_or_else(|error| error, |(class, numbers)| raise(py, class, error.to_string(), &numbers))
}

fn class_of<'py>(py: Python<'py>, error: &LinalgError) -> PyResult<(&'static str, Bound<'py, PyDict>)> {
    use LinalgError as E;
    Ok(match error {
        E::NotSquare { what, rows, cols } => {
            let side = *rows.max(cols);
            ("DimensionMismatch", dictionary!(py; what, expected = (side, side), found = (*rows, *cols)))
        }
        E::DimensionMismatch { what, expected, found } => {
            ("DimensionMismatch", dictionary!(py; what, expected = *expected, found = *found))
        }
        E::NotFinite { what, row, col, value } => ("NotFinite", dictionary!(py; what, row, column = col, value)),
        E::NotSymmetric { what, row, col, asymmetry, allowed } => {
            ("NotSymmetric", dictionary!(py; what, row, column = col, asymmetry, allowed))
        }
        E::NotPositiveDefinite { what, lambda_min } | E::NotPositiveSemidefinite { what, lambda_min } => {
            ("NotPositiveDefinite", dictionary!(py; what, lambda_min))
        }
        E::NotConverged { method, iterations, remaining, allowed } => {
            ("NotConverged", dictionary!(py; method, iterations, remaining, allowed))
        }
        E::SingularEquation { equation, first, second, gap } => {
            let condition = f64::INFINITY;
            let numbers = dictionary!(py; equation, first = *first, second = *second, gap, decided = true, condition);
            ("SingularEquation", numbers)
        }
        E::UndecidedEquation { equation, first, second, gap, condition, .. } => {
            let numbers = dictionary!(py; equation, first = *first, second = *second, gap, decided = false, condition);
            ("SingularEquation", numbers)
        }
        E::NotStable { eigenvalue, .. } => ("NotStable", dictionary!(py; eigenvalue = *eigenvalue)),
        E::NotStabilizable { eigenvalue, margin } | E::NotExcited { eigenvalue, margin } => {
            ("NotStabilizable", dictionary!(py; eigenvalue = *eigenvalue, margin))
        }
        E::NotDetectable { eigenvalue, margin } => ("NotDetectable", dictionary!(py; eigenvalue = *eigenvalue, margin)),
        E::NotWeighted { eigenvalue, margin } => ("LinAlgError", dictionary!(py; eigenvalue = *eigenvalue, margin)),
        E::NotStabilizing { eigenvalue, distance } => {
            ("LinAlgError", dictionary!(py; eigenvalue = *eigenvalue, distance))
        }
        E::NotGraph { sigma_min } => ("LinAlgError", dictionary!(py; sigma_min)),
        E::Unobservable { eigenvalue, direction, margin } => {
            let direction = complex(py, direction.as_slice());
            ("Unobservable", dictionary!(py; eigenvalue = *eigenvalue, margin, direction))
        }
        E::Uncontrollable { eigenvalue, direction, margin } => {
            let direction = complex(py, direction.as_slice());
            ("Uncontrollable", dictionary!(py; eigenvalue = *eigenvalue, margin, direction))
        }
        E::PoleCount { order, found } => ("InvalidPole", dictionary!(py; expected = order, found)),
        E::PoleNotFinite { index, pole } => ("InvalidPole", dictionary!(py; index, pole = *pole)),
        E::PoleUnpaired { pole } => ("InvalidPole", dictionary!(py; pole = *pole)),
        E::PoleMultiplicity { pole, multiplicity, rank, .. } => {
            ("InvalidPole", dictionary!(py; pole = *pole, found = multiplicity, expected = rank))
        }
        E::Singular { what, condition } => ("LinAlgError", dictionary!(py; what, condition)),
        E::InvalidTolerance { tolerance } => ("InvalidArgument", dictionary!(py; tolerance)),
        E::Empty { what } => ("DimensionMismatch", dictionary!(py; what, expected = (1, 1), found = (0, 0))),
        _ => ("LinAlgError", PyDict::new(py)),
    })
}

/// The error of a design, with what is applicable instead, and hints.
pub(crate) fn design(py: Python<'_>, why: &NoObserver, words: &Words) -> PyErr {
    let cause = match why.cause.as_deref() {
        Some(Cause::Design(DesignError::OfPair { error, .. })) => Some(error.as_ref()),
        Some(Cause::Design(error)) => Some(error),
        _ => None,
    };
    let found = || -> PyResult<(&'static str, Bound<'_, PyDict>)> {
        Ok(match cause {
            Some(DesignError::Linalg(error)) => class_of(py, error)?,
            // The least eigenvalue is that of the argument, which Python has.
            Some(DesignError::Observer(ObserverError::NotDefinite { what, .. })) => {
                ("NotPositiveDefinite", dictionary!(py; what))
            }
            Some(DesignError::Observer(ObserverError::NotSymmetric { what, row, column, difference })) => {
                ("NotSymmetric", dictionary!(py; what, row, column, asymmetry = difference.abs()))
            }
            Some(DesignError::NotDetectable { eigenvalue, margin, .. }) => {
                ("NotDetectable", dictionary!(py; eigenvalue = *eigenvalue, margin))
            }
            Some(DesignError::UnstablePole { pole } | DesignError::PoleOutside { pole }) => {
                ("InvalidPole", dictionary!(py; pole = *pole))
            }
            Some(DesignError::Infeasible { what, .. }) => ("Infeasible", dictionary!(py; what)),
            Some(DesignError::Undecided { what, best, .. }) => ("Undecided", dictionary!(py; what, best)),
            Some(DesignError::NotHurwitz { abscissa, .. }) => ("NotStable", dictionary!(py; abscissa)),
            Some(DesignError::NotSchur { radius, .. }) => ("NotStable", dictionary!(py; radius)),
            Some(_) => ("DesignError", PyDict::new(py)),
            None => ("NotApplicable", PyDict::new(py)),
        })
    };
    let (class, numbers) = match found() {
        Ok(found) => found,
        Err(error) => return error,
    };
    let alternatives: Vec<String> = why.alternatives.iter().map(|one| (words.advice)(one.words())).collect();
    let hints: Vec<String> = why.hints.iter().map(|hint| (words.advice)(hint)).collect();
    let mut text = (words.message)(&why.hypothesis);
    // The arguments are those that every kind has there; a function for one kind may have others.
    for (title, some) in [(words.instead, &alternatives), ("Hint", &hints)] {
        if !some.is_empty() {
            text = format!("{text}. {title}: {}", some.join("; "));
        }
    }
    let with_advice = || -> PyResult<()> {
        numbers.set_item("alternatives", pyo3::types::PyTuple::new(py, alternatives)?)?;
        numbers.set_item("hints", pyo3::types::PyTuple::new(py, hints)?)
    };
    match with_advice() {
        Ok(()) => raise(py, class, text, &numbers),
        Err(error) => error,
    }
}
