//! Matrix equations, placement and observability: each answer with its evidence.
//!
//! The equations are those of python-control and scipy; the library's own are their transposes.

use luenberger_linalg as linalg;
use luenberger_linalg::{LinalgError, Mode, Riccati};
use nalgebra::Complex;
use numpy::PyReadonlyArray1;
use pyo3::prelude::*;
use pyo3::types::{PyDict, PyList};

use crate::array::{Matrix, array, complex, list, matrix};
use crate::error::{self, dictionary};

type Answer<'py> = PyResult<Bound<'py, PyDict>>;

/// What `work` returns, computed without the interpreter's lock.
fn solved<T: Send>(py: Python<'_>, work: impl FnOnce() -> Result<T, LinalgError> + Send) -> PyResult<T> {
    py.detach(work).map_err(|error| error::linalg(py, &error))
}

/// `A X + X A' + Q = 0`, with E `A X E' + E X A' + Q = 0`.
#[pyfunction]
#[pyo3(signature = (a, q, e=None, /))]
fn lyap<'py>(py: Python<'py>, a: Matrix<'py>, q: Matrix<'py>, e: Option<Matrix<'py>>) -> Answer<'py> {
    let (a, q, e) = (matrix(&a).transpose(), matrix(&q), e.map(|e| matrix(&e).transpose()));
    Ok(match e {
        None => {
            let found = solved(py, || linalg::lyapunov(&a, &q))?;
            dictionary!(py; x = array(py, &found.p), residual = found.residual, forward_error = found.forward_error(),
                condition = found.condition, separation = found.separation)
        }
        Some(e) => {
            let found = solved(py, || linalg::generalized_lyapunov(&a, &e, &q))?;
            dictionary!(py; x = array(py, &found.p), residual = found.residual, forward_error = found.forward_error(),
                condition = found.standard.condition, separation = found.standard.separation)
        }
    })
}

/// `A X A' - X + Q = 0`, with E `A X A' - E X E' + Q = 0`.
#[pyfunction]
#[pyo3(signature = (a, q, e=None, /))]
fn dlyap<'py>(py: Python<'py>, a: Matrix<'py>, q: Matrix<'py>, e: Option<Matrix<'py>>) -> Answer<'py> {
    let (a, q, e) = (matrix(&a).transpose(), matrix(&q), e.map(|e| matrix(&e).transpose()));
    Ok(match e {
        None => {
            let found = solved(py, || linalg::stein(&a, &q))?;
            dictionary!(py; x = array(py, &found.p), residual = found.residual, forward_error = found.forward_error(),
                condition = found.condition, separation = found.separation)
        }
        Some(e) => {
            let found = solved(py, || linalg::generalized_stein(&a, &e, &q))?;
            dictionary!(py; x = array(py, &found.p), residual = found.residual, forward_error = found.forward_error(),
                condition = found.standard.condition, separation = found.standard.separation)
        }
    })
}

/// `A X + X B = C`.
#[pyfunction]
#[pyo3(signature = (a, b, c, /))]
fn sylv<'py>(py: Python<'py>, a: Matrix<'py>, b: Matrix<'py>, c: Matrix<'py>) -> Answer<'py> {
    let (a, b, c) = (matrix(&a), matrix(&b), matrix(&c));
    let found = solved(py, || linalg::sylvester(&a, &b, &c))?;
    Ok(dictionary!(py; x = array(py, &found.x), residual = found.residual, forward_error = found.forward_error(),
        condition = found.condition, separation = found.separation))
}

/// `A X B - X + C = 0`.
#[pyfunction]
#[pyo3(signature = (a, b, c, /))]
fn dsylv<'py>(py: Python<'py>, a: Matrix<'py>, b: Matrix<'py>, c: Matrix<'py>) -> Answer<'py> {
    let (a, b, c) = (matrix(&a), matrix(&b), matrix(&c));
    let found = solved(py, || linalg::discrete_sylvester(&a, &b, &c))?;
    Ok(dictionary!(py; x = array(py, &found.x), residual = found.residual, forward_error = found.forward_error(),
        condition = found.condition, separation = found.separation))
}

fn riccati<'py>(py: Python<'py>, found: &Riccati) -> Answer<'py> {
    Ok(dictionary!(py; x = array(py, &found.x), k = array(py, &found.k), poles = complex(py, &found.poles),
        residual = found.residual, forward_error = found.forward_error, condition = found.condition))
}

/// `A'X E + E'X A - (E'X B + S) R^-1 (B'X E + S') + Q = 0`; S and E are given both or not at all.
#[pyfunction]
#[pyo3(signature = (a, b, q, r, s_e=None, /))]
fn care<'py>(
    py: Python<'py>,
    a: Matrix<'py>,
    b: Matrix<'py>,
    q: Matrix<'py>,
    r: Matrix<'py>,
    s_e: Option<(Matrix<'py>, Matrix<'py>)>,
) -> Answer<'py> {
    let (a, b, q, r) = (matrix(&a), matrix(&b), matrix(&q), matrix(&r));
    let s_e = s_e.map(|(s, e)| (matrix(&s), matrix(&e)));
    let found = solved(py, || match &s_e {
        None => linalg::care(&a, &b, &q, &r),
        Some((s, e)) => linalg::generalized_care(&a, &b, &q, &r, s, e),
    })?;
    riccati(py, &found)
}

/// `A'X A - E'X E - (A'X B + S)(B'X B + R)^-1 (B'X A + S') + Q = 0`.
#[pyfunction]
#[pyo3(signature = (a, b, q, r, s_e=None, /))]
fn dare<'py>(
    py: Python<'py>,
    a: Matrix<'py>,
    b: Matrix<'py>,
    q: Matrix<'py>,
    r: Matrix<'py>,
    s_e: Option<(Matrix<'py>, Matrix<'py>)>,
) -> Answer<'py> {
    let (a, b, q, r) = (matrix(&a), matrix(&b), matrix(&q), matrix(&r));
    let s_e = s_e.map(|(s, e)| (matrix(&s), matrix(&e)));
    let found = solved(py, || match &s_e {
        None => linalg::dare(&a, &b, &q, &r),
        Some((s, e)) => linalg::generalized_dare(&a, &b, &q, &r, s, e),
    })?;
    riccati(py, &found)
}

/// K that gives `A - B K` these eigenvalues.
#[pyfunction]
#[pyo3(signature = (a, b, poles, /))]
fn place<'py>(
    py: Python<'py>,
    a: Matrix<'py>,
    b: Matrix<'py>,
    poles: PyReadonlyArray1<'py, Complex<f64>>,
) -> Answer<'py> {
    let (a, b, poles) = (matrix(&a), matrix(&b), poles.as_array().to_vec());
    let found = solved(py, || linalg::place(&a, &b, &poles))?;
    Ok(dictionary!(py; x = array(py, &found.gain), poles = complex(py, &found.poles), errors = list(py, &found.errors),
        sensitivities = list(py, &found.sensitivities), deviation = found.deviation, condition = found.condition))
}

fn modes<'py>(py: Python<'py>, modes: &[Mode]) -> PyResult<Bound<'py, PyList>> {
    let one = |mode: &Mode| -> Answer<'py> {
        let direction = complex(py, mode.direction.as_slice());
        Ok(dictionary!(py; eigenvalue = mode.eigenvalue, margin = mode.margin, direction))
    };
    PyList::new(py, modes.iter().map(one).collect::<PyResult<Vec<_>>>()?)
}

/// Observability of (A, C), and whether the hidden modes decay.
#[pyfunction]
#[pyo3(signature = (a, c, is_discrete, tolerance=None, /))]
fn observability<'py>(
    py: Python<'py>,
    a: Matrix<'py>,
    c: Matrix<'py>,
    is_discrete: bool,
    tolerance: Option<f64>,
) -> Answer<'py> {
    let (a, c) = (matrix(&a), matrix(&c));
    let (seen, detectable) = solved(py, || {
        let seen = match tolerance {
            Some(tolerance) => linalg::observability_within(&a, &c, tolerance)?,
            None => linalg::observability(&a, &c)?,
        };
        let detectable =
            if is_discrete { linalg::discrete_detectability(&a, &c)? } else { linalg::detectability(&a, &c)? };
        Ok((seen, detectable))
    })?;
    Ok(dictionary!(py;
        order = seen.order, rank = seen.rank, modes = modes(py, &seen.modes)?,
        unobservable = modes(py, &seen.unobservable)?, undetectable_modes = modes(py, &detectable.undetectable_modes)?,
        subspace = array(py, &seen.subspace), tolerance = seen.tolerance, units = list(py, &seen.units),
    ))
}

/// The distance of (A, C) to the nearest pair with a hidden mode.
#[pyfunction]
#[pyo3(signature = (a, c, /))]
fn unobservability_distance<'py>(py: Python<'py>, a: Matrix<'py>, c: Matrix<'py>) -> Answer<'py> {
    let (a, c) = (matrix(&a), matrix(&c));
    let found = solved(py, || linalg::distance_to_unobservability(&a, &c))?;
    let direction = complex(py, found.direction.as_slice());
    Ok(dictionary!(py; lower = found.lower, upper = found.upper, at = found.at, direction))
}

pub(crate) fn register(module: &Bound<'_, PyModule>) -> PyResult<()> {
    module.add_function(wrap_pyfunction!(lyap, module)?)?;
    module.add_function(wrap_pyfunction!(dlyap, module)?)?;
    module.add_function(wrap_pyfunction!(sylv, module)?)?;
    module.add_function(wrap_pyfunction!(dsylv, module)?)?;
    module.add_function(wrap_pyfunction!(care, module)?)?;
    module.add_function(wrap_pyfunction!(dare, module)?)?;
    module.add_function(wrap_pyfunction!(place, module)?)?;
    module.add_function(wrap_pyfunction!(observability, module)?)?;
    module.add_function(wrap_pyfunction!(unobservability_distance, module)?)
}
