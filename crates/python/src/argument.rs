//! Arguments that Python passes on as they were given: what has the wrong type is `InvalidArgument`, with its name.

use pyo3::prelude::*;
use pyo3::types::PyDict;

use crate::error::{self, dictionary};

/// A number that counts from 0 on.
pub(crate) const COUNT: &str = "a whole number from 0 on";

/// A text.
pub(crate) const TEXT: &str = "a text";

/// The value of the argument of this name; none for None.
pub(crate) fn given<'py, T: for<'a> FromPyObject<'a, 'py>>(
    name: &str,
    value: Option<&Bound<'py, PyAny>>,
    expected: &str,
) -> PyResult<Option<T>> {
    let Some(value) = value.filter(|value| !value.is_none()) else { return Ok(None) };
    if let Ok(read) = value.extract() {
        return Ok(Some(read));
    }
    let py = value.py();
    let numbers = dictionary!(py; what = name, hint = expected);
    Err(error::raise(py, "InvalidArgument", format!("{name} is {}", value.repr()?), &numbers))
}

/// That of an item of a dictionary.
pub(crate) fn item<'py, T: for<'a> FromPyObject<'a, 'py>>(
    of: &Bound<'py, PyDict>,
    name: &str,
    expected: &str,
) -> PyResult<Option<T>> {
    given(name, of.get_item(name)?.as_ref(), expected)
}
