//! Exchange of neighbouring diagonal blocks of a real Schur form (Bai and Demmel, Linear Algebra Appl. 186, 1993).
//!
//! For the blocks `A11`, `A22` coupled by `A12`, the solution of `A11 X - X A22 = A12` gives `[-X; I]`, a basis of the
//! invariant subspace of `A22`; the reflectors that make it triangular exchange the blocks. What remains below the
//! diagonal is dropped if it is at rounding level; otherwise the exchange is rejected, which happens if the eigenvalues
//! nearly coincide.

use super::swap::swap;
use super::{Schur, block_eigenvalues, blocks};
use crate::kernel::{Kernel, dispatch};
use crate::{LinalgError, Result};
use nalgebra::Complex;

impl Schur {
    /// The same factorisation with the eigenvalues for which `select` is true first: the leading columns of `Q` then
    /// span their invariant subspace. Returns it with the dimension of that subspace.
    ///
    /// `select` is called once per real eigenvalue and once per conjugate pair (with the one above the real axis),
    /// before any exchange.
    ///
    /// # Errors
    /// [`LinalgError::SwapRejected`] names two eigenvalues that are too close to be separated.
    pub fn ordered(mut self, select: impl Fn(Complex<f64>) -> bool) -> Result<(Self, usize)> {
        // (size, selected) of each block, from the top.
        let mut order: Vec<(usize, bool)> = blocks(&self.t)
            .into_iter()
            .map(|(k, size)| (size, select(block_eigenvalues(&self.t, k, size).0)))
            .collect();
        dispatch(Reordering { form: &mut self, order: &mut order })?;
        let chosen = order.iter().filter(|block| block.1).map(|block| block.0).sum();
        Ok((self, chosen))
    }
}

/// Moves the selected blocks of `order` to the top.
struct Reordering<'a> {
    form: &'a mut Schur,
    order: &'a mut Vec<(usize, bool)>,
}

impl Kernel for Reordering<'_> {
    type Output = Result<()>;

    #[inline(always)]
    fn run<const FMA: bool>(self) -> Result<()> {
        let Self { form: Schur { q, t }, order } = self;
        let n = t.nrows();
        // Each exchange removes one inversion. At most n times a block splits into two real ones, which adds fewer than
        // n inversions.
        for _ in 0..=2 * n * n {
            let Some(i) = order.windows(2).position(|pair| !pair[0].1 && pair[1].1) else { return Ok(()) };
            let k = order[..i].iter().map(|block| block.0).sum();
            let (upper, lower) = (order[i].0, order[i + 1].0);
            swap(t.as_mut_slice(), n, q.as_mut_slice(), k, upper, lower).map_err(|refused| {
                LinalgError::SwapRejected {
                    first: block_eigenvalues(t, k, upper).0,
                    second: block_eigenvalues(t, k + upper, lower).0,
                    residual: refused.residual,
                    allowed: refused.allowed,
                }
            })?;
            order.swap(i, i + 1);
            for (index, start) in [(i + 1, k + lower), (i, k)] {
                let (size, selected) = order[index];
                if size == 2 && t[(start + 1, start)] == 0.0 {
                    order[index].0 = 1;
                    order.insert(index, (1, selected));
                }
            }
        }
        Err(LinalgError::NotConverged {
            method: "the reordering of the Schur form",
            iterations: 2 * n * n,
            remaining: order.windows(2).filter(|pair| !pair[0].1 && pair[1].1).count() as f64,
            allowed: 0.0,
        })
    }
}
