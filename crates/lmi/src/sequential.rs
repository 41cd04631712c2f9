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
pub(crate) fn product(l: MatRef<'_, f64>, r: MatRef<'_, f64>) -> Mat<f64> {
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
pub(crate) struct Cholesky(Mat<f64>);

impl Cholesky {
    /// The factor, from the lower triangle of `M`. `None` if M is not positive definite to rounding.
    pub(crate) fn of(m: &Mat<f64>) -> Option<Self> {
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
    pub(crate) fn l(&self) -> MatRef<'_, f64> {
        self.0.as_ref()
    }

    /// `X := M^-1 X`.
    pub(crate) fn solve_in_place(&self, x: &mut Mat<f64>) {
        let mut memory = MemBuffer::new(solve::solve_in_place_scratch::<f64>(self.0.nrows(), x.ncols(), Par::Seq));
        solve::solve_in_place(self.l(), x.as_mut(), Par::Seq, MemStack::new(&mut memory));
    }

    /// `M^-1`, exactly symmetric.
    pub(crate) fn inverse(&self) -> Mat<f64> {
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
pub(crate) fn eigenvalues(m: &Mat<f64>) -> Option<Vec<f64>> {
    let n = m.nrows();
    let mut values = Diag::zeros(n);
    let scratch = self_adjoint_evd_scratch::<f64>(n, ComputeEigenvectors::No, Par::Seq, Spec::default());
    let mut memory = MemBuffer::new(scratch);
    let stack = MemStack::new(&mut memory);
    self_adjoint_evd(m.as_ref(), values.as_mut(), None, Par::Seq, stack, Spec::default()).ok()?;
    Some(values.column_vector().iter().copied().collect())
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The second difference of order n has the eigenvalues 2 - 2 cos(k pi / (n + 1)), the determinant n + 1, and the
    /// inverse min(i, j) (n + 1 - max(i, j)) / (n + 1).
    #[test]
    fn the_second_difference_is_factored_inverted_and_has_its_eigenvalues() {
        for n in [1, 2, 7, 40, 150] {
            let m = Mat::from_fn(n, n, |i, j| [2.0, -1.0, 0.0][i.abs_diff(j).min(2)]);
            let cholesky = Cholesky::of(&m).unwrap();
            // Each of these loses the condition of the matrix, 4 (n + 1)^2 / pi^2, times its rounding errors.
            let bound = f64::EPSILON * ((n + 1) * (n + 1)) as f64 * n as f64;
            let back = product(cholesky.l(), cholesky.l().transpose());
            let inverse = cholesky.inverse();
            let mut column = Mat::from_fn(n, 1, |i, _| f64::from(u8::from(i == 0)));
            cholesky.solve_in_place(&mut column);
            for i in 0..n {
                for j in 0..n {
                    assert!((back[(i, j)] - m[(i, j)]).abs() <= 4.0 * n as f64 * f64::EPSILON);
                    let exact = ((i.min(j) + 1) * (n - i.max(j))) as f64 / (n + 1) as f64;
                    assert!((inverse[(i, j)] - exact).abs() <= bound * n as f64, "{n}: {i} {j}");
                    assert_eq!(inverse[(i, j)].to_bits(), inverse[(j, i)].to_bits());
                }
                assert!((column[(i, 0)] - (n - i) as f64 / (n + 1) as f64).abs() <= bound);
            }
            for (k, value) in eigenvalues(&m).unwrap().into_iter().enumerate() {
                let exact = 2.0 - 2.0 * ((k + 1) as f64 * std::f64::consts::PI / (n + 1) as f64).cos();
                assert!((value - exact).abs() <= 10.0 * n as f64 * f64::EPSILON, "{n}: {value} {exact}");
            }
            let mut indefinite = m;
            indefinite[(n - 1, n - 1)] = -1.0;
            assert!(Cholesky::of(&indefinite).is_none());
        }
    }
}
