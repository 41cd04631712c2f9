//! Matrix products at the speed of the machine: nalgebra's storage, seen by faer without a copy.
//!
//! Sequential throughout: an equation of this crate is a step of something larger, and who has several of them runs them side by side.

use faer::linalg::matmul::matmul;
use faer::linalg::matmul::triangular::{self, BlockStructure};
use faer::{Accum, MatMut, MatRef, Par};
use nalgebra::DMatrix;

/// The matrix as faer reads it.
pub(crate) fn view(m: &DMatrix<f64>) -> MatRef<'_, f64> {
    MatRef::from_column_major_slice(m.as_slice(), m.nrows(), m.ncols())
}

/// The matrix as faer writes it.
pub(crate) fn view_mut(m: &mut DMatrix<f64>) -> MatMut<'_, f64> {
    let (rows, cols) = m.shape();
    MatMut::from_column_major_slice_mut(m.as_mut_slice(), rows, cols)
}

/// `D := D + alpha L R` ([`Accum::Add`]) or `D := alpha L R` ([`Accum::Replace`]).
pub(crate) fn multiply(d: MatMut<'_, f64>, accum: Accum, alpha: f64, l: MatRef<'_, f64>, r: MatRef<'_, f64>) {
    matmul(d, accum, l, r, alpha, Par::Seq);
}

/// Up to this order the whole product is quicker than its upper triangle.
const WHOLE: usize = 24;

/// As [`multiply`], the upper triangle of `D` alone; what is below means nothing afterwards.
pub(crate) fn multiply_upper(d: MatMut<'_, f64>, accum: Accum, alpha: f64, l: MatRef<'_, f64>, r: MatRef<'_, f64>) {
    if d.nrows() <= WHOLE {
        return multiply(d, accum, alpha, l, r);
    }
    let full = BlockStructure::Rectangular;
    triangular::matmul(d, BlockStructure::TriangularUpper, accum, l, full, r, full, alpha, Par::Seq);
}

/// Copies the upper triangle below the diagonal.
pub(crate) fn mirror(mut d: MatMut<'_, f64>) {
    for j in 0..d.ncols() {
        for i in 0..j {
            d[(j, i)] = d[(i, j)];
        }
    }
}
