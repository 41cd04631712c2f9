//! Exchange of two neighbouring diagonal blocks of a real Schur form (Bai and Demmel, Linear Algebra Appl. 186, 1993).
//!
//! For the blocks `A11`, `A22` coupled by `A12`, the solution of `A11 X - X A22 = A12` gives `[-X; I]`, a basis of the
//! invariant subspace of `A22`; the reflectors that make it triangular exchange the blocks. What remains below the
//! diagonal is dropped if it is at rounding level; otherwise the exchange is rejected, which happens if the eigenvalues
//! nearly coincide.

// Indices (i, j) of a matrix of order four are clearer than iterators here.
#![allow(clippy::needless_range_loop)]

use super::hessenberg::reflector;
use super::standard::{rotate_cols, rotate_rows, standardise_block};
use crate::linear_block::LinearBlock;

/// A rejected exchange: it would leave `residual` below the diagonal, more than `allowed`.
#[derive(Debug, Clone, Copy)]
pub(super) struct Refused {
    pub(super) residual: f64,
    pub(super) allowed: f64,
}

/// Order of the diagonal block at `k` of a quasi-triangular matrix.
#[inline(always)]
pub(super) fn block_order(t: &[f64], n: usize, k: usize) -> usize {
    if k + 1 < n && t[k * n + k + 1] != 0.0 { 2 } else { 1 }
}

/// Exchanges the diagonal block of order `p` at `k` with the following one of order `s`, in the matrix `t` of order
/// `n`; `q`, of `n` columns, is updated.
#[inline(always)]
pub(super) fn swap(t: &mut [f64], n: usize, q: &mut [f64], k: usize, p: usize, s: usize) -> Result<(), Refused> {
    let rows = q.len() / n;
    if p == 1 && s == 1 {
        let d = k * n + k;
        let (first, second) = (t[d], t[d + n + 1]);
        let (x, y) = (t[d + n], second - first);
        let norm = x.hypot(y);
        if norm > 0.0 {
            let (cs, sn) = (x / norm, y / norm);
            rotate_rows(t, n, k, k + 2..n, cs, sn);
            rotate_cols(t, n, k, 0..k, cs, sn);
            rotate_cols(q, rows, k, 0..rows, cs, sn);
        }
        (t[d], t[d + n + 1], t[d + 1]) = (second, first, 0.0);
        return Ok(());
    }
    let m = p + s;
    // Column-major like the matrix: local[j][i].
    let mut local = [[0.0; 4]; 4];
    for (j, column) in local.iter_mut().enumerate().take(m) {
        column[..m].copy_from_slice(&t[(k + j) * n + k..(k + j) * n + k + m]);
    }
    let largest = local.iter().flatten().fold(0.0_f64, |a, e| a.max(e.abs()));
    // The basis [-X; gamma I], from the small linear system with complete pivoting.
    let mut equation = LinearBlock::sylvester(p, s, |i, l| local[l][i], |l, j| -local[p + j][p + l]);
    for j in 0..s {
        for i in 0..p {
            equation.set_rhs(i, j, local[p + j][i]);
        }
    }
    let tiny = f64::MIN_POSITIVE / f64::EPSILON;
    equation.solve((f64::EPSILON * largest).max(tiny));
    let mut gamma = 1.0_f64;
    for j in 0..s {
        for i in 0..p {
            gamma = gamma.max(equation.x(i, j).abs());
        }
    }
    let mut basis = [[0.0; 4]; 2];
    for (j, column) in basis.iter_mut().enumerate().take(s) {
        for (i, e) in column.iter_mut().enumerate().take(p) {
            *e = -equation.x(i, j) / gamma;
        }
        column[p + j] = 1.0 / gamma;
    }
    // First the block alone: `turned = Z'(block) Z`, with columns of four.
    let (mut turned, mut z) = ([0.0; 16], [0.0; 16]);
    for (column, from) in turned.chunks_exact_mut(4).zip(&local) {
        column.copy_from_slice(from);
    }
    z.iter_mut().step_by(5).for_each(|e| *e = 1.0);
    for j in 0..s {
        let mut v = basis[j];
        let head = v[j];
        let (_, tau) = reflector(head, &mut v[j + 1..m]);
        v[..j].fill(0.0);
        v[j] = 1.0;
        for column in &mut basis {
            reflect(column, &v, tau);
        }
        for column in turned.chunks_exact_mut(4).filter_map(|column| column.first_chunk_mut()) {
            reflect(column, &v, tau);
        }
        for matrix in [&mut turned, &mut z] {
            for i in 0..4 {
                let sum: f64 = (0..m).map(|j| matrix[4 * j + i] * v[j]).sum();
                for j in 0..m {
                    matrix[4 * j + i] -= tau * sum * v[j];
                }
            }
        }
    }
    let residual = turned
        .chunks_exact(4)
        .take(s)
        .flat_map(|column| &column[s..m])
        .fold(0.0_f64, |a, e| if e.is_nan() { f64::NAN } else { a.max(e.abs()) });
    let allowed = (20.0 * f64::EPSILON * largest).max(tiny);
    if residual.is_nan() || residual > allowed {
        return Err(Refused { residual, allowed });
    }
    for column in turned.chunks_exact_mut(4).take(s) {
        column[s..m].fill(0.0);
    }
    if s == 2 {
        standardise_block(&mut turned, 4, &mut z, 4, 0, (0, m));
    } else {
        turned[0] = local[p][p];
    }
    if p == 2 {
        standardise_block(&mut turned, 4, &mut z, 4, s, (0, m));
    } else {
        turned[5 * s] = local[0][0];
    }
    if m == 3 {
        turn::<3>(t, n, q, rows, k, &z);
    } else {
        turn::<4>(t, n, q, rows, k, &z);
    }
    for j in 0..m {
        t[(k + j) * n + k..(k + j) * n + k + m].copy_from_slice(&turned[4 * j..4 * j + m]);
    }
    Ok(())
}

#[inline(always)]
fn reflect<const M: usize>(column: &mut [f64; M], v: &[f64; M], tau: f64) {
    let mut s = 0.0;
    for i in 0..M {
        s += column[i] * v[i];
    }
    for i in 0..M {
        column[i] -= tau * s * v[i];
    }
}

/// Applies `Z`, of order M, to the rows and columns of `t` from `k` outside the block, and to those columns of `q`:
/// once for all reflectors and rotations of an exchange.
#[inline(always)]
fn turn<const M: usize>(t: &mut [f64], n: usize, q: &mut [f64], rows: usize, k: usize, z: &[f64; 16]) {
    for column in t[(k + M) * n..].chunks_exact_mut(n) {
        if let Some(part) = column.get_mut(k..).and_then(|c| c.first_chunk_mut::<M>()) {
            let x = *part;
            let mut y = [0.0; M];
            for l in 0..M {
                for j in 0..M {
                    y[j] += z[4 * j + l] * x[l];
                }
            }
            *part = y;
        }
    }
    turn_columns::<M>(t, n, k, k, z);
    turn_columns::<M>(q, rows, k, rows, z);
}

/// Columns from `k`, of length `ld`, in the rows before `end`, four rows at a time.
#[inline(always)]
fn turn_columns<const M: usize>(data: &mut [f64], ld: usize, k: usize, end: usize, z: &[f64; 16]) {
    if end == 0 {
        return;
    }
    let columns = &mut data[k * ld..(k + M) * ld];
    let mut i = 0;
    while i + 4 <= end {
        turn_rows::<M, 4>(columns, ld, i, z);
        i += 4;
    }
    while i < end {
        turn_rows::<M, 1>(columns, ld, i, z);
        i += 1;
    }
}

#[inline(always)]
fn turn_rows<const M: usize, const W: usize>(columns: &mut [f64], ld: usize, i: usize, z: &[f64; 16]) {
    let mut x = [[0.0; W]; M];
    for l in 0..M {
        x[l].copy_from_slice(&columns[l * ld + i..l * ld + i + W]);
    }
    for j in 0..M {
        let mut y = [0.0; W];
        for l in 0..M {
            for w in 0..W {
                y[w] += x[l][w] * z[4 * j + l];
            }
        }
        columns[j * ld + i..j * ld + i + W].copy_from_slice(&y);
    }
}
