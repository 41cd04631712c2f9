//! Single-threaded products, Cholesky factors and eigenvalues by faer.
//!
//! faer's operators use a global number of threads as soon as any crate in the program enables faer's feature `rayon`;
//! for orders above some hundreds, the order of summation depends on the number of threads. Solving the same program
//! twice would then give results that differ in the last digits, and different certificate files. Here the order is
//! fixed; several programs can be solved in parallel instead.

use faer::diag::Diag;
use faer::dyn_stack::{MemBuffer, MemStack};
use faer::linalg::cholesky::llt::factor::LltRegularization;
use faer::linalg::cholesky::llt::{factor, inverse, solve};
use faer::linalg::evd::{ComputeEigenvectors, self_adjoint_evd, self_adjoint_evd_scratch};
use faer::linalg::matmul::matmul;
use faer::{Accum, Mat, MatMut, MatRef, Par, Spec};

/// `L R`.
pub fn product(l: MatRef<'_, f64>, r: MatRef<'_, f64>) -> Mat<f64> {
    let mut product = Mat::zeros(l.nrows(), r.ncols());
    product_into(product.as_mut(), l, r);
    product
}

/// `M := L R`.
pub(crate) fn product_into(m: MatMut<'_, f64>, l: MatRef<'_, f64>, r: MatRef<'_, f64>) {
    matmul(m, Accum::Replace, l, r, 1.0, Par::Seq);
}

/// `M = L L'` of a symmetric matrix that is positive definite.
#[derive(Debug)]
pub struct Cholesky(Mat<f64>);

impl Cholesky {
    /// The factor, from the lower triangle of `M`. `None` if M is not positive definite to rounding.
    pub fn of(m: &Mat<f64>) -> Option<Self> {
        let n = m.nrows();
        let mut l = Mat::zeros(n, n);
        l.copy_from_triangular_lower(m);
        let scratch = factor::cholesky_in_place_scratch::<f64>(n, Par::Seq, Spec::default());
        let mut memory = MemBuffer::new(scratch);
        let stack = MemStack::new(&mut memory);
        factor::cholesky_in_place(l.as_mut(), LltRegularization::default(), Par::Seq, stack, Spec::default()).ok()?;
        for j in 1..n {
            l.col_as_slice_mut(j)[..j].fill(0.0);
        }
        Some(Self(l))
    }

    /// `L`, with zeros above its diagonal.
    pub fn l(&self) -> MatRef<'_, f64> {
        self.0.as_ref()
    }

    /// `X := M^-1 X`.
    pub fn solve_in_place(&self, x: &mut Mat<f64>) {
        let mut memory = MemBuffer::new(solve::solve_in_place_scratch::<f64>(self.0.nrows(), x.ncols(), Par::Seq));
        solve::solve_in_place(self.l(), x.as_mut(), Par::Seq, MemStack::new(&mut memory));
    }

    /// `M^-1`, exactly symmetric.
    pub fn inverse(&self) -> Mat<f64> {
        let n = self.0.nrows();
        let mut out = Mat::zeros(n, n);
        let mut memory = MemBuffer::new(inverse::inverse_scratch::<f64>(n, Par::Seq));
        inverse::inverse(out.as_mut(), self.l(), Par::Seq, MemStack::new(&mut memory));
        // The lower triangle is what is computed.
        for j in 0..n {
            for i in 0..j {
                out[(i, j)] = out[(j, i)];
            }
        }
        out
    }
}

/// The eigenvalues of a symmetric matrix, of which the lower triangle is read, the smallest first.
pub fn eigenvalues(m: &Mat<f64>) -> Option<Vec<f64>> {
    let n = m.nrows();
    let mut values = Diag::zeros(n);
    let scratch = self_adjoint_evd_scratch::<f64>(n, ComputeEigenvectors::No, Par::Seq, Spec::default());
    let mut memory = MemBuffer::new(scratch);
    let stack = MemStack::new(&mut memory);
    self_adjoint_evd(m.as_ref(), values.as_mut(), None, Par::Seq, stack, Spec::default()).ok()?;
    Some(values.column_vector().iter().copied().collect())
}
