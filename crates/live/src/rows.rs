//! Matrices as arrays of their rows, as a page stores them.

pub(crate) use luenberger_plants::serialization::rows;
use nalgebra::DMatrix;

/// A matrix as an array of its rows.
pub type Rows = Vec<Vec<f64>>;

pub(crate) fn matrix(rows: &Rows) -> DMatrix<f64> {
    let columns = rows.first().map_or(0, Vec::len);
    DMatrix::from_fn(rows.len(), columns, |i, j| rows[i].get(j).copied().unwrap_or(f64::NAN))
}
