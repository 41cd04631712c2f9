//! The Schur complement `B_ij = tr(F_i V F_j Y)`: assembled by the entries of the constraints, factored, and solved with.

use faer::linalg::solvers::{Llt, Solve};
use faer::{Mat, MatRef, Side};

use super::program::{Dense, Number, pair};

impl Number {
    /// Adds `factor c_i c_j` to every pair of unknowns.
    pub(super) fn assemble(&self, factor: f64, b: &mut Mat<f64>) {
        for &(i, c) in &self.terms {
            for &(j, d) in &self.terms {
                b[(i, j)] += c * d * factor;
            }
        }
    }
}
/// Adds `tr(F_i V F_j Y)` to B, both triangles.
pub(super) fn assemble(block: &Dense, v: MatRef<'_, f64>, y: MatRef<'_, f64>, b: &mut Mat<f64>) {
    let n = block.order;
    // Entries of all constraints from the k-th on.
    let mut rest: Vec<usize> = block.constraints.iter().map(|(_, entries)| entries.len()).collect();
    for k in (0..rest.len().saturating_sub(1)).rev() {
        rest[k] += rest[k + 1];
    }
    for (k, (j, entries)) in block.constraints.iter().enumerate() {
        let mut rows: Vec<usize> = entries.iter().flat_map(|e| [e.row, e.column]).collect();
        rows.sort_unstable();
        rows.dedup();
        // Columns of (F_j Y)' that are not zero: (F_j Y)(r, :) = sum_c F_j(r, c) Y(c, :), stored as columns, like those of V.
        let mut g: Mat<f64> = Mat::zeros(n, rows.len());
        let place = |row: usize| rows.binary_search(&row).unwrap_or(0);
        for e in entries {
            let mirrored = if e.row == e.column { None } else { Some((e.column, e.row)) };
            for (r, c) in std::iter::once((e.row, e.column)).chain(mirrored) {
                let target = place(r);
                for (out, y) in g.col_mut(target).iter_mut().zip(y.col(c).iter()) {
                    *out += e.value * y;
                }
            }
        }
        let selected = Mat::from_fn(n, rows.len(), |i, c| v[(i, rows[c])]);
        // The whole product costs n^2 a row, at the speed of a matrix product; single entries cost one operation a row each.
        let is_whole = 2 * rest[k] * 4 > n * n;
        let whole = if is_whole { Some(&selected * g.transpose()) } else { None };
        // Rows of the two factors side by side in memory.
        let (vt, gt) = if is_whole {
            (Mat::zeros(0, 0), Mat::zeros(0, 0))
        } else {
            (selected.transpose().to_owned(), g.transpose().to_owned())
        };
        for (i, others) in &block.constraints[k..] {
            let entry =
                |r: usize, c: usize| -> f64 { vt.col(r).iter().zip(gt.col(c).iter()).map(|(x, y)| x * y).sum() };
            let sum: f64 = match &whole {
                Some(u) => others.iter().map(|e| pair(e, |r, c| u[(r, c)])).sum(),
                None => others.iter().map(|e| pair(e, entry)).sum(),
            };
            b[(*i, *j)] += sum;
            if i != j {
                b[(*j, *i)] += sum;
            }
        }
    }
}
/// The factor of a matrix that is positive definite but for rounding: where its constraints are nearly dependent, or the optimum is near, a
/// touch of regularisation, which refinement takes back.
pub(super) fn regularised(matrix: &Mat<f64>) -> Option<Llt<f64>> {
    [0.0, 1e-15, 1e-13, 1e-11].into_iter().find_map(|share| {
        let mut regular = matrix.clone();
        for i in 0..regular.nrows() {
            regular[(i, i)] *= 1.0 + share;
        }
        regular.llt(Side::Lower).ok()
    })
}

/// `B^-1 right` with two steps of iterative refinement.
pub(super) fn refined(factor: &Llt<f64>, matrix: &Mat<f64>, right: &[f64]) -> Vec<f64> {
    let m = right.len();
    let right = Mat::from_fn(m, 1, |i, _| right[i]);
    let mut x = right.clone();
    factor.solve_in_place(&mut x);
    for _ in 0..2 {
        let mut residual = &right - matrix * &x;
        factor.solve_in_place(&mut residual);
        x += residual;
    }
    (0..m).map(|i| x[(i, 0)]).collect()
}
