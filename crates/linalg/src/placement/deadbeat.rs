//! All poles at zero with several inputs: the deadbeat gain.
//!
//! `S_0 = 0`, `S_i = {x : A x in S_(i-1) + Im B}` are the states that some input takes to zero in i steps. With the
//! heights of the stairs `s_1 >= .. >= s_mu`, the dimension of `S_i` is `s_1 + .. + s_i`: no rank is decided here. A
//! gain takes every state to zero in the fewest steps iff `(A - B K) S_i` lies in `S_(i-1)` for all i; then `(A - B
//! K)^mu = 0`, mu the largest controllability index, and no gain has a smaller power. These conditions are independent
//! for orthogonal directions: of the gains that satisfy them, the one of least Frobenius norm has for x in `S_i`,
//! orthogonal to `S_(i-1)`, the shortest u with `A x - B u` in `S_(i-1)`.
//!
//! Computed for `N_i`, an orthonormal basis of the orthogonal complement of `S_i`: mu singular value decompositions of
//! `N' B` and as many of `U0' N' A`, `O(mu n^3)` flops.
//!
//! Source: C. T. Mullis, IEEE TAC 17, 1972; P. Van Dooren, BIT 24, 1984.

use nalgebra::DMatrix;

use crate::product::view;
use crate::sequential::{Svd, svd};
use crate::{LinalgError, Result};

/// The gain K, m x n, of the controllable pair (A, B) with these stairs.
pub(super) fn assign(a: &DMatrix<f64>, b: &DMatrix<f64>, stairs: &[usize]) -> Result<DMatrix<f64>> {
    let (n, m) = b.shape();
    let mut gain = DMatrix::<f64>::zeros(m, n);
    // N_0: nothing is at zero yet.
    let mut outside = DMatrix::identity(n, n);
    for stair in stairs {
        let left = outside.ncols().saturating_sub(*stair);
        let reached = decomposed(&outside.tr_mul(b))?;
        let moved = outside.tr_mul(a);
        let shortest = DMatrix::from_fn(m, outside.ncols(), |i, j| {
            (0..*stair).map(|k| reached.v[(i, k)] / reached.sigma[k] * reached.u[(j, k)]).sum::<f64>()
        });
        let unreached = DMatrix::from_fn(outside.ncols(), left, |i, j| reached.u[(i, stair + j)]);
        let next = if left == 0 {
            DMatrix::zeros(n, 0)
        } else {
            let v = decomposed(&unreached.tr_mul(&moved))?.v;
            DMatrix::from_fn(n, left, |i, j| v[(i, j)])
        };
        // The projector on S_i, orthogonal to S_(i-1).
        let step = &outside * outside.transpose() - &next * next.transpose();
        gain += shortest * moved * step;
        outside = next;
    }
    if gain.iter().all(|x| x.is_finite()) { Ok(gain) } else { Err(LinalgError::Overflow { what: "the gain" }) }
}

fn decomposed(m: &DMatrix<f64>) -> Result<Svd> {
    svd(view(m)).ok_or(LinalgError::NotConverged {
        method: "singular values of a deadbeat gain",
        iterations: 0,
        remaining: f64::NAN,
        allowed: f64::EPSILON,
    })
}
