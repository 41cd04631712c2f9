//! Singular value decomposition: `gesdd`, `gesvd`.

use faer::{Mat, MatMut, MatRef};

use crate::blas::is_finite;
use crate::element::Element;

/// `A = U diag(s) V'`, s in descending order.
pub(crate) struct Svd<T> {
    pub(crate) u: Mat<T>,
    pub(crate) s: Vec<T>,
    pub(crate) v: Mat<T>,
}

/// The decomposition with square U and V, or with min(m, n) columns in each. None if the matrix is not finite or the
/// iteration did not converge.
pub(crate) fn svd<T: Element>(a: MatRef<'_, T>, square: bool) -> Option<Svd<T>> {
    if !is_finite(a) {
        return None;
    }
    let d = if square { a.svd() } else { a.thin_svd() }.ok()?;
    Some(Svd { u: d.U().to_owned(), s: d.S().column_vector().iter().copied().collect(), v: d.V().to_owned() })
}

/// Copies as many columns as the target has.
pub(crate) fn copy_columns<T: Element>(from: MatRef<'_, T>, mut to: MatMut<'_, T>) {
    for j in 0..to.ncols() {
        for i in 0..to.nrows() {
            to[(i, j)] = from[(i, j)];
        }
    }
}
