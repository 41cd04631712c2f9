//! Chasing one bulge down an upper Hessenberg matrix: the implicit QR step of Francis, Computer Journal 4, 1961-62.
//!
//! A few steps at a time are made near the diagonal; their chain of reflectors is then applied to the rest of the
//! window: see `chain.rs`.

use super::chain::{Chain, Reflector, chain_on_columns, chain_on_rows, reflect2, reflect3};
use crate::kernel::fma;

/// Steps near the diagonal before the rest of the window is updated.
pub(super) const STEPS: usize = 12;

/// Path of a bulge.
#[derive(Debug, Clone, Copy)]
pub(super) struct Way {
    /// The first reflector acts on rows `from..from + 3`, the last on `to - 1..to + 2`.
    pub(super) from: usize,
    pub(super) to: usize,
    /// The last row of the active block; if `to` equals `last`, the bulge leaves the block.
    pub(super) last: usize,
    /// First row, and column after the last one, to which the reflectors are applied immediately.
    pub(super) window: (usize, usize),
    /// First column of the shifted product, if the bulge enters the block at `from`.
    pub(super) entry: Option<[f64; 3]>,
}

/// The reflector that maps `x` to `beta e1`, and `beta`.
#[inline(always)]
pub(super) fn reflect_vector(x: [f64; 3]) -> (f64, Reflector) {
    if x[1] == 0.0 && x[2] == 0.0 {
        return (x[0], Reflector::default());
    }
    let square = x[0] * x[0] + x[1] * x[1] + x[2] * x[2];
    if !(1e-280..1e280).contains(&square) {
        return reflect_scaled(x);
    }
    let norm = square.sqrt();
    let pivot = x[0] + norm.copysign(x[0]);
    // Two independent divisions.
    let (inverse, tau) = (1.0 / pivot, pivot.abs() / norm);
    let v = [x[1] * inverse, x[2] * inverse];
    (-norm.copysign(x[0]), Reflector { v, t: [tau, tau * v[0], tau * v[1]] })
}

/// [`reflect_vector`] for entries whose squares underflow or overflow.
#[cold]
fn reflect_scaled(x: [f64; 3]) -> (f64, Reflector) {
    let scale = x[0].abs().max(x[1].abs()).max(x[2].abs());
    let x = x.map(|e| e / scale);
    let norm = (x[0] * x[0] + x[1] * x[1] + x[2] * x[2]).sqrt();
    let pivot = x[0] + norm.copysign(x[0]);
    let v = [x[1] / pivot, x[2] / pivot];
    let tau = pivot.abs() / norm;
    (-norm.copysign(x[0]) * scale, Reflector { v, t: [tau, tau * v[0], tau * v[1]] })
}

/// Rows of the copied part of the matrix near the diagonal.
const TILE: usize = STEPS + 4;

/// Chases a bulge. Its `to - from` reflectors are stored in `chain`; `packed` has room for `WIDTH * (STEPS + 2)`
/// numbers.
#[inline(always)]
pub(super) fn chase<const FMA: bool>(h: &mut [f64], n: usize, way: Way, chain: &mut [Reflector], packed: &mut [f64]) {
    let Way { from, to, last, window, .. } = way;
    let mut begin = from;
    while begin < to {
        let end = to.min(begin + STEPS);
        let part = &mut chain[begin - from..end - from];
        if last - begin < 8 {
            diagonal::<8, FMA>(h, n, way, begin, part);
        } else {
            diagonal::<TILE, FMA>(h, n, way, begin, part);
        }
        let part = Chain { at: begin, reflectors: part, pair: end == last };
        chain_on_columns::<FMA>(h, n, window.0..begin, part);
        chain_on_rows::<FMA>(h, n, (end + 2).min(last + 1)..window.1, part, packed);
        begin = end;
    }
}

/// The steps from row `begin` on, one for each reflector in `part`, applied to the at most `R` rows and columns near
/// the diagonal that these reflectors affect.
#[inline(always)]
fn diagonal<const R: usize, const FMA: bool>(h: &mut [f64], n: usize, way: Way, begin: usize, part: &mut [Reflector]) {
    let Way { from, last, entry, .. } = way;
    let end = begin + part.len();
    let cols = (end + 2).min(last + 1) - begin;
    let rows = (end + 3).min(last + 1) - begin;
    // A copy with columns of constant length. Entries copied below the affected rows are reflected too, but not written
    // back.
    let mut tile = [[0.0; R]; TILE];
    for (to, from) in tile.iter_mut().zip(h[begin * n..].chunks_exact(n)).take(cols) {
        if let Some(all) = from[begin..].first_chunk::<R>() {
            *to = *all;
        } else {
            for (to, from) in to.iter_mut().zip(&from[begin..]) {
                *to = *from;
            }
        }
    }
    for (i, slot) in part.iter_mut().enumerate() {
        let k = begin + i;
        let triple = k < last - 1;
        let r = match entry {
            Some(v) if k == from => reflect_vector(v).1,
            _ => {
                let column = if i == 0 { h[(k - 1) * n..k * n].get_mut(k..) } else { tile[i - 1].get_mut(i..) };
                let column = column.unwrap_or_default();
                if let (true, Some(x)) = (triple, column.first_chunk_mut::<3>()) {
                    let (beta, r) = reflect_vector(*x);
                    *x = [beta, 0.0, 0.0];
                    r
                } else if let Some(x) = column.first_chunk_mut::<2>() {
                    let (beta, r) = reflect_vector([x[0], x[1], 0.0]);
                    *x = [beta, 0.0];
                    r
                } else {
                    Reflector::default()
                }
            }
        };
        *slot = r;
        if r.t[0] == 0.0 {
            continue;
        }
        if triple {
            for column in &mut tile[i..cols] {
                if let Some([x, y, z]) = column.get_mut(i..).and_then(|c| c.first_chunk_mut::<3>()) {
                    let s = fma::<FMA>(r.t[1], *y, fma::<FMA>(r.t[0], *x, r.t[2] * *z));
                    *x -= s;
                    *y = fma::<FMA>(-s, r.v[0], *y);
                    *z = fma::<FMA>(-s, r.v[1], *z);
                }
            }
            if let Some([x, y, z]) = tile.get_mut(i..).and_then(|t| t.first_chunk_mut::<3>()) {
                reflect3::<R, FMA>(&r, x, y, z);
            }
        } else {
            for column in &mut tile[i..cols] {
                if let Some([x, y]) = column.get_mut(i..).and_then(|c| c.first_chunk_mut::<2>()) {
                    let s = fma::<FMA>(r.t[1], *y, r.t[0] * *x);
                    *x -= s;
                    *y = fma::<FMA>(-s, r.v[0], *y);
                }
            }
            if let Some([x, y]) = tile.get_mut(i..).and_then(|t| t.first_chunk_mut::<2>()) {
                reflect2::<R, FMA>(&r, x, y);
            }
        }
    }
    for (from, to) in tile.iter().zip(h[begin * n..].chunks_exact_mut(n)).take(cols) {
        to[begin..begin + rows].copy_from_slice(&from[..rows]);
    }
}
