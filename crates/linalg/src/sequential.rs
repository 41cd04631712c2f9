//! Singular values and eigenvalues by faer on one thread.
//!
//! faer's functions use a global number of threads if any crate of the program enables faer's feature `rayon`, and for
//! orders of some hundreds the order of summation then depends on that number. On one thread the same matrix always
//! gives the same result, bit for bit.

use faer::diag::Diag;
use faer::dyn_stack::{MemBuffer, MemStack};
use faer::linalg::evd::{self, self_adjoint_evd, self_adjoint_evd_scratch};
use faer::linalg::svd::{self, ComputeSvdVectors};
use faer::traits::ComplexField;
use faer::traits::math_utils::real;
use faer::{Mat, MatRef, Par, Spec};

/// `M = U diag(sigma) V'` with square U and V, sigma descending.
pub(crate) struct Svd {
    pub(crate) u: Mat<f64>,
    pub(crate) sigma: Vec<f64>,
    pub(crate) v: Mat<f64>,
}

/// The singular value decomposition. `None` if its iteration does not converge; no such case is known.
pub(crate) fn svd(m: MatRef<'_, f64>) -> Option<Svd> {
    let (rows, columns) = m.shape();
    let (mut u, mut v) = (Mat::zeros(rows, rows), Mat::zeros(columns, columns));
    let mut sigma = Diag::zeros(rows.min(columns));
    let full = ComputeSvdVectors::Full;
    let scratch = svd::svd_scratch::<f64>(rows, columns, full, full, Par::Seq, Spec::default());
    let mut memory = MemBuffer::new(scratch);
    let stack = MemStack::new(&mut memory);
    svd::svd(m, sigma.as_mut(), Some(u.as_mut()), Some(v.as_mut()), Par::Seq, stack, Spec::default()).ok()?;
    Some(Svd { u, sigma: sigma.column_vector().iter().copied().collect(), v })
}

/// Singular values, descending. `None` as for [`svd`].
pub(crate) fn singular_values<T: ComplexField>(m: MatRef<'_, T>) -> Option<Vec<T::Real>> {
    let (rows, columns) = m.shape();
    let mut sigma = Diag::<T>::zeros(rows.min(columns));
    let none = ComputeSvdVectors::No;
    let scratch = svd::svd_scratch::<T>(rows, columns, none, none, Par::Seq, Spec::default());
    let mut memory = MemBuffer::new(scratch);
    let stack = MemStack::new(&mut memory);
    svd::svd(m, sigma.as_mut(), None, None, Par::Seq, stack, Spec::default()).ok()?;
    Some(sigma.column_vector().iter().map(real).collect())
}

/// Eigenvalues, ascending, and orthonormal eigenvectors of a Hermitian matrix, given by its lower triangle. `None` as
/// for [`svd`].
pub(crate) fn hermitian_eigen<T: ComplexField>(m: MatRef<'_, T>) -> Option<(Vec<T::Real>, Mat<T>)> {
    let n = m.nrows();
    let (mut values, mut vectors) = (Diag::<T>::zeros(n), Mat::zeros(n, n));
    let scratch = self_adjoint_evd_scratch::<T>(n, evd::ComputeEigenvectors::Yes, Par::Seq, Spec::default());
    let mut memory = MemBuffer::new(scratch);
    let stack = MemStack::new(&mut memory);
    self_adjoint_evd(m, values.as_mut(), Some(vectors.as_mut()), Par::Seq, stack, Spec::default()).ok()?;
    Some((values.column_vector().iter().map(real).collect(), vectors))
}

/// Eigenvalues of a symmetric matrix, ascending. `None` as for [`svd`].
pub(crate) fn symmetric_eigenvalues(m: MatRef<'_, f64>) -> Option<Vec<f64>> {
    let n = m.nrows();
    let mut values = Diag::zeros(n);
    let scratch = self_adjoint_evd_scratch::<f64>(n, evd::ComputeEigenvectors::No, Par::Seq, Spec::default());
    let mut memory = MemBuffer::new(scratch);
    let stack = MemStack::new(&mut memory);
    self_adjoint_evd(m, values.as_mut(), None, Par::Seq, stack, Spec::default()).ok()?;
    Some(values.column_vector().iter().copied().collect())
}
