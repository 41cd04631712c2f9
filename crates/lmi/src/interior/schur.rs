//! The Schur complement `B_ij = tr(F_i V F_j Y)`: assembled by the entries of the constraints, factored, and solved
//! with.

use faer::{Mat, MatRef};

use super::program::{Dense, Number, pair};
use super::structured;
use crate::sequential::{Cholesky, product};

impl Number {
    /// Adds `factor c_i c_j` once for every pair of unknowns, in either triangle.
    pub(super) fn assemble(&self, factor: f64, b: &mut Mat<f64>) {
        for (k, &(j, d)) in self.terms.iter().enumerate() {
            for &(i, c) in &self.terms[k..] {
                b[(i, j)] += c * d * factor;
            }
        }
    }
}

/// The symmetric matrix of which each entry off the diagonal was added up in two parts, one in each triangle.
pub fn joined(mut b: Mat<f64>) -> Mat<f64> {
    for j in 0..b.ncols() {
        for i in j + 1..b.nrows() {
            let sum = b[(i, j)] + b[(j, i)];
            b[(i, j)] = sum;
            b[(j, i)] = sum;
        }
    }
    b
}

/// How many operations a product of matrices does in the time of one on its own.
const GAIN: usize = 12;

/// Adds `tr(F_i V F_j Y)` once for every pair of unknowns, in either triangle.
pub fn assemble(block: &Dense, v: MatRef<'_, f64>, y: MatRef<'_, f64>, b: &mut Mat<f64>) {
    let n = block.order;
    // Entries of all constraints from the k-th on.
    let mut rest: Vec<usize> = block.constraints.iter().map(|(_, entries)| entries.len()).collect();
    for k in (0..rest.len().saturating_sub(1)).rev() {
        rest[k] += rest[k + 1];
    }
    structured::assemble(&block.products, v, y, b);
    for (k, (j, entries)) in block.constraints[..block.others].iter().enumerate() {
        let mut rows: Vec<usize> = entries.iter().flat_map(|e| [e.row, e.column]).collect();
        rows.sort_unstable();
        rows.dedup();
        // Columns of (F_j Y)' that are not zero: (F_j Y)(r, :) = sum_c F_j(r, c) Y(c, :), stored as columns, like those
        // of V.
        let place = |row: usize| rows.binary_search(&row).unwrap_or(0);
        let both = entries.iter().flat_map(|e| {
            let mirrored = if e.row == e.column { None } else { Some((e.column, e.row, e.value)) };
            std::iter::once((e.row, e.column, e.value)).chain(mirrored)
        });
        let mut g: Mat<f64> = Mat::zeros(n, rows.len());
        if GAIN * 2 * entries.len() > n * rows.len() {
            let mut f: Mat<f64> = Mat::zeros(n, rows.len());
            both.for_each(|(r, c, value)| f[(c, place(r))] = value);
            g = product(y, f.as_ref());
        } else {
            for (r, c, value) in both {
                for (out, y) in g.col_as_slice_mut(place(r)).iter_mut().zip(y.col(c).iter()) {
                    *out += value * y;
                }
            }
        }
        let selected = Mat::from_fn(n, rows.len(), |i, c| v[(i, rows[c])]);
        // The whole product costs n^2 a row, at the speed of a matrix product; single entries cost one operation a row
        // each.
        let is_whole = 2 * rest[k] * 4 > n * n;
        let whole = if is_whole { folded(&product(selected.as_ref(), g.transpose())) } else { Vec::new() };
        // Rows of the two factors side by side in memory.
        let (vt, gt) = if is_whole {
            (Mat::zeros(0, 0), Mat::zeros(0, 0))
        } else {
            (selected.transpose().to_owned(), g.transpose().to_owned())
        };
        let column = b.col_as_slice_mut(*j);
        for (i, others) in &block.constraints[k..] {
            column[*i] += if is_whole {
                others.iter().map(|e| e.value * whole[e.column * n + e.row]).sum::<f64>()
            } else {
                let entry =
                    |r: usize, c: usize| -> f64 { vt.col(r).iter().zip(gt.col(c).iter()).map(|(x, y)| x * y).sum() };
                others.iter().map(|e| pair(e, entry)).sum::<f64>()
            };
        }
    }
}

/// The upper triangle of `U + U'`, with the diagonal of U, column by column: what an entry and its mirror image take
/// from U, in one number.
fn folded(u: &Mat<f64>) -> Vec<f64> {
    let n = u.nrows();
    let mut folded = vec![0.0; n * n];
    for c in 0..n {
        for r in 0..c {
            folded[c * n + r] = u[(r, c)] + u[(c, r)];
        }
        folded[c * n + c] = u[(c, c)];
    }
    folded
}

/// The factor of a matrix that is positive definite up to rounding: with nearly dependent constraints, or near the
/// optimum, a small regularisation is added, whose effect iterative refinement removes.
pub(super) fn regularised(matrix: &Mat<f64>) -> Option<Cholesky> {
    let largest = (0..matrix.nrows()).map(|i| matrix[(i, i)]).fold(0.0, f64::max);
    Cholesky::of(matrix).or_else(|| {
        [1e-15, 1e-13, 1e-11].into_iter().find_map(|share| {
            let mut regular = matrix.clone();
            for i in 0..regular.nrows() {
                // The second term is for an unknown that occurs nowhere: its row is zero.
                regular[(i, i)] += share * (regular[(i, i)] + 1e-3 * largest);
            }
            Cholesky::of(&regular)
        })
    })
}

/// `B^-1 right` with two steps of iterative refinement.
pub(super) fn refined(factor: &Cholesky, matrix: &Mat<f64>, right: &[f64]) -> Vec<f64> {
    let m = right.len();
    let right = Mat::from_fn(m, 1, |i, _| right[i]);
    let mut x = right.clone();
    factor.solve_in_place(&mut x);
    for _ in 0..2 {
        let mut residual = &right - product(matrix.as_ref(), x.as_ref());
        factor.solve_in_place(&mut residual);
        x += residual;
    }
    (0..m).map(|i| x[(i, 0)]).collect()
}
