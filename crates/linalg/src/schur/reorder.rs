//! Exchange of neighbouring diagonal blocks of a real Schur form (Bai and Demmel, Linear Algebra Appl. 186, 1993).
//!
//! For the blocks `A11`, `A22` coupled by `A12`, the solution of `A11 X - X A22 = A12` gives `[-X; I]`, a basis of the invariant subspace
//! of `A22`; the reflectors that make it triangular exchange the blocks. What they leave below the diagonal is compared with
//! rounding before it is dropped: blocks whose eigenvalues nearly coincide may refuse.

use super::hessenberg::{reflect_cols, reflect_rows, reflector};
use super::standard::{rotate_cols, rotate_rows, standardise_block};
use super::{Schur, block_eigenvalues, blocks};
use crate::linear_block::LinearBlock;
use crate::{LinalgError, Result};
use nalgebra::{Complex, DMatrix};

impl Schur {
    /// The same factorisation with the eigenvalues that `select` picks first: the leading columns of `Q` then span their
    /// invariant subspace. Returns it with the dimension of that subspace.
    ///
    /// `select` sees each eigenvalue once (of a conjugate pair, the one above the real axis), before anything is moved.
    ///
    /// # Errors
    /// [`LinalgError::SwapRejected`] names two eigenvalues that are too close to be separated.
    pub fn ordered(mut self, select: impl Fn(Complex<f64>) -> bool) -> Result<(Self, usize)> {
        let n = self.t.nrows();
        // (size, selected) of each block, from the top.
        let mut order: Vec<(usize, bool)> = blocks(&self.t)
            .into_iter()
            .map(|(k, size)| (size, select(block_eigenvalues(&self.t, k, size).0)))
            .collect();
        // Each exchange removes one inversion; a block that falls apart into two real ones adds fewer than n, n times.
        for _ in 0..=2 * n * n {
            let Some(i) = order.windows(2).position(|pair| !pair[0].1 && pair[1].1) else {
                let chosen = order.iter().filter(|block| block.1).map(|block| block.0).sum();
                return Ok((self, chosen));
            };
            let k = order[..i].iter().map(|block| block.0).sum();
            let (upper, lower) = (order[i].0, order[i + 1].0);
            swap(&mut self.t, &mut self.q, k, upper, lower)?;
            let mut parts = Vec::with_capacity(4);
            for (start, size, selected) in [(k, lower, true), (k + lower, upper, false)] {
                if size == 2 && self.t[(start + 1, start)] == 0.0 {
                    parts.extend([(1, selected); 2]);
                } else {
                    parts.push((size, selected));
                }
            }
            order.splice(i..i + 2, parts);
        }
        Err(LinalgError::NotConverged {
            method: "the reordering of the Schur form",
            iterations: 2 * n * n,
            remaining: order.windows(2).filter(|pair| !pair[0].1 && pair[1].1).count() as f64,
            allowed: 0.0,
        })
    }
}

/// Exchanges the diagonal block of order `p` at `k` with the one of order `s` that follows it.
fn swap(t: &mut DMatrix<f64>, q: &mut DMatrix<f64>, k: usize, p: usize, s: usize) -> Result<()> {
    let n = t.nrows();
    if p == 1 && s == 1 {
        let (first, second) = (t[(k, k)], t[(k + 1, k + 1)]);
        let (x, y) = (t[(k, k + 1)], second - first);
        let norm = x.hypot(y);
        if norm > 0.0 {
            let (cs, sn) = (x / norm, y / norm);
            rotate_rows(t, k, k + 2, cs, sn);
            rotate_cols(t, k, k, cs, sn);
            rotate_cols(q, k, n, cs, sn);
        }
        (t[(k, k)], t[(k + 1, k + 1)], t[(k + 1, k)]) = (second, first, 0.0);
        return Ok(());
    }
    let m = p + s;
    let local = t.view((k, k), (m, m)).into_owned();
    // The basis [-X; gamma I], found from the small linear equation with complete pivoting.
    let mut equation = LinearBlock::sylvester(p, s, |i, l| local[(i, l)], |l, j| -local[(p + l, p + j)]);
    for j in 0..s {
        for i in 0..p {
            equation.set_rhs(i, j, local[(i, p + j)]);
        }
    }
    let tiny = f64::EPSILON * local.amax();
    equation.solve(tiny.max(f64::MIN_POSITIVE / f64::EPSILON));
    let largest =
        (0..s).flat_map(|j| (0..p).map(move |i| (i, j))).map(|(i, j)| equation.x(i, j).abs()).fold(1.0, f64::max);
    let mut basis = DMatrix::from_fn(m, s, |i, j| {
        if i < p { -equation.x(i, j) / largest } else { f64::from(u8::from(i - p == j)) / largest }
    });
    let mut reflectors = Vec::with_capacity(2);
    for j in 0..s {
        let mut v = basis.as_slice()[j * m + j..(j + 1) * m].to_vec();
        let (_, tau) = reflector(&mut v);
        reflect_rows(&mut basis, &v, tau, j, j..s);
        reflectors.push((v, tau));
    }
    // Try on the copy first.
    let mut trial = local.clone();
    let mut work = vec![0.0; n];
    for (j, (v, tau)) in reflectors.iter().enumerate() {
        reflect_rows(&mut trial, v, *tau, j, 0..m);
        reflect_cols(&mut trial, v, *tau, j, &mut work[..m]);
    }
    let residual = trial.view((s, 0), (p, s)).amax();
    let allowed = (20.0 * f64::EPSILON * local.amax()).max(f64::MIN_POSITIVE / f64::EPSILON);
    if residual.is_nan() || residual > allowed {
        return Err(LinalgError::SwapRejected {
            first: block_eigenvalues(t, k, p).0,
            second: block_eigenvalues(t, k + p, s).0,
            residual,
            allowed,
        });
    }
    for (j, (v, tau)) in reflectors.iter().enumerate() {
        reflect_rows(t, v, *tau, k + j, k..n);
        reflect_cols(t, v, *tau, k + j, &mut work);
        reflect_cols(q, v, *tau, k + j, &mut work);
    }
    for j in 0..s {
        for i in s..m {
            t[(k + i, k + j)] = 0.0;
        }
    }
    if s == 2 {
        standardise_block(t, q, k);
    } else {
        t[(k, k)] = local[(p, p)];
    }
    if p == 2 {
        standardise_block(t, q, k + s);
    } else {
        t[(k + s, k + s)] = local[(0, 0)];
    }
    Ok(())
}
