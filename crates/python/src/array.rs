//! numpy's arrays as nalgebra's matrices, and back. Strides of any kind are read; what is returned is in C order.

use nalgebra::{Complex, DMatrix, DVector};
use numpy::ndarray::Array2;
use numpy::{IntoPyArray, PyArray1, PyArray2, PyReadonlyArray1, PyReadonlyArray2};
use pyo3::prelude::*;

pub(crate) type Matrix<'py> = PyReadonlyArray2<'py, f64>;
pub(crate) type Vector<'py> = PyReadonlyArray1<'py, f64>;

pub(crate) fn matrix(array: &Matrix<'_>) -> DMatrix<f64> {
    let view = array.as_array();
    DMatrix::from_fn(view.nrows(), view.ncols(), |i, j| view[[i, j]])
}

pub(crate) fn vector(array: &Vector<'_>) -> DVector<f64> {
    DVector::from_iterator(array.as_array().len(), array.as_array().iter().copied())
}

pub(crate) fn array<'py>(py: Python<'py>, matrix: &DMatrix<f64>) -> Bound<'py, PyArray2<f64>> {
    Array2::from_shape_fn(matrix.shape(), |entry| matrix[entry]).into_pyarray(py)
}

/// The transpose: times in columns.
pub(crate) fn columns<'py>(py: Python<'py>, matrix: &DMatrix<f64>) -> Bound<'py, PyArray2<f64>> {
    Array2::from_shape_fn((matrix.ncols(), matrix.nrows()), |(i, j)| matrix[(j, i)]).into_pyarray(py)
}

pub(crate) fn list<'py>(py: Python<'py>, values: &[f64]) -> Bound<'py, PyArray1<f64>> {
    values.to_vec().into_pyarray(py)
}

pub(crate) fn complex<'py>(py: Python<'py>, values: &[Complex<f64>]) -> Bound<'py, PyArray1<Complex<f64>>> {
    values.to_vec().into_pyarray(py)
}
