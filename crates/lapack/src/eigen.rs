//! Eigenvalues and eigenvectors of a symmetric matrix: `syevr`.

use faer::{Mat, MatRef, Side};

use crate::abi::Triangle;
use crate::element::Element;

/// Which eigenvalues, counted in ascending order.
#[derive(Debug, Clone, Copy)]
pub(crate) enum Range<T> {
    All,
    /// Those in the half-open interval (low, high].
    Between(T, T),
    /// From the first to the last, both included, counted from 0.
    Numbered(usize, usize),
}

/// The chosen eigenvalues in ascending order and, if wished, their eigenvectors as columns. None if the matrix is not
/// finite or the iteration did not converge.
pub(crate) fn syevr<T: Element>(
    stored: Triangle,
    a: MatRef<'_, T>,
    range: Range<T>,
    vectors: bool,
) -> Option<(Vec<T>, Option<Mat<T>>)> {
    let n = a.nrows();
    let (side, reads) = match stored {
        Triangle::Lower => (Side::Lower, (|i, j| i >= j) as fn(usize, usize) -> bool),
        Triangle::Upper => (Side::Upper, (|i, j| i <= j) as fn(usize, usize) -> bool),
    };
    if !(0..n).all(|j| (0..n).all(|i| !reads(i, j) || a[(i, j)].finite())) {
        return None;
    }
    let (values, basis): (Vec<T>, Option<Mat<T>>) = if vectors {
        let decomposition = a.self_adjoint_eigen(side).ok()?;
        let values = decomposition.S().column_vector().iter().copied().collect();
        (values, Some(decomposition.U().to_owned()))
    } else {
        (a.self_adjoint_eigenvalues(side).ok()?, None)
    };
    let (first, end) = match range {
        Range::All => (0, n),
        Range::Between(low, high) => (values.partition_point(|&x| x <= low), values.partition_point(|&x| x <= high)),
        Range::Numbered(first, last) => (first.min(n), (last + 1).min(n)),
    };
    let end = end.max(first);
    let basis = basis.map(|u| u.subcols(first, end - first).to_owned());
    Some((values[first..end].to_vec(), basis))
}
