//! Implicit double-shift QR iteration on a small upper Hessenberg matrix (Francis, Computer Journal 4, 1961-62), as in
//! LAPACK dlahqr.
//!
//! Deflation by Ahues and Tisseur (LAPACK Working Note 122, 1997), which keeps the small eigenvalues of graded
//! matrices; an exceptional shift after every ten sweeps without deflation, for matrices that the ordinary shift maps
//! to themselves (a cyclic permutation, for instance); a bounded number of sweeps. About 20 n^3 flops with the vectors.
//!
//! Each reflector depends on the previous one, and this latency dominates. While the matrices fit into the nearest
//! caches, all other work fits into the waiting time, so each reflector is applied immediately.

use super::bulge::reflect_vector;
use super::chain::{Reflector, reflect2, reflect3};
use super::standard::standardise_block;
use crate::kernel::{Kernel, fma};
use core::array;

/// Sweeps without deflation before a shift is replaced by an exceptional one.
const PATIENCE: usize = 10;
/// Maximum number of sweeps per row. Two or three are usual.
pub(super) const SWEEPS_PER_ROW: usize = 30;

/// Eigenvalues `re[i] + i im[i]` used as shifts of a sweep.
#[derive(Debug, Clone, Copy)]
pub(super) struct Shifts {
    pub(super) re: [f64; 2],
    pub(super) im: [f64; 2],
}

/// Matrix entries by columns, and the length of a column.
pub(super) type Columns<'a> = (&'a mut [f64], usize);

/// The matrices of an iteration, independent of their storage.
pub(super) trait Sweeps {
    /// H and Q.
    fn parts(&mut self) -> (Columns<'_>, Columns<'_>);

    /// Chases one bulge, introduced at row `passage.from` by the reflector of `v`, out of the block at row
    /// `passage.last`.
    fn sweep<const FMA: bool>(&mut self, passage: Passage, v: [f64; 3]);
}

/// Path of a bulge through the active block, which begins at row `first`.
#[derive(Clone, Copy)]
pub(super) struct Passage {
    pub(super) first: usize,
    pub(super) from: usize,
    pub(super) last: usize,
    /// First row, and column after the last one, that are transformed.
    pub(super) window: (usize, usize),
}

/// The iteration on a Hessenberg matrix of order `n`, which becomes the real Schur form T (only its diagonal blocks
/// unless `whole`). The transformation multiplies Q from the right.
///
/// Returns the number of leading rows that have not converged: zero, unless the maximum number of sweeps is reached.
#[inline(always)]
pub(super) fn iterate<const FMA: bool>(matrices: &mut impl Sweeps, n: usize, whole: bool) -> usize {
    let cap = SWEEPS_PER_ROW * n.max(PATIENCE);
    let mut sweeps = 0;
    let mut stalled = 0;
    // The active block ends at row `last`; the rows below are in Schur form.
    let mut end = n;
    while end > 1 {
        let last = end - 1;
        let ((h, ld), (q, rows)) = matrices.parts();
        let first = first_of_active_block(h, ld, last);
        if first > 0 {
            h[(first - 1) * ld + first] = 0.0;
        }
        if first == last {
            end = last;
            stalled = 0;
            continue;
        }
        let window = if whole { (0, n) } else { (first, end) };
        if first + 1 == last {
            standardise_block(h, ld, q, rows, first, window);
            end = first;
            stalled = 0;
            continue;
        }
        if sweeps == cap {
            return end;
        }
        sweeps += 1;
        stalled += 1;
        let shifts = shifts(h, ld, first, last, stalled);
        let (from, v) = start_of_bulge(h, ld, first, last, shifts);
        matrices.sweep::<FMA>(Passage { first, from, last, window }, v);
    }
    0
}

/// [`iterate`] on `h` of order `n`, with a `q` of `n` columns (or none).
pub(super) struct Francis<'a> {
    pub(super) h: &'a mut [f64],
    pub(super) n: usize,
    pub(super) q: &'a mut [f64],
    pub(super) whole: bool,
}

impl Kernel for Francis<'_> {
    type Output = usize;

    #[inline(always)]
    fn run<const FMA: bool>(mut self) -> usize {
        let (n, whole) = (self.n, self.whole);
        iterate::<FMA>(&mut self, n, whole)
    }
}

impl Sweeps for Francis<'_> {
    #[inline(always)]
    fn parts(&mut self) -> (Columns<'_>, Columns<'_>) {
        let rows = self.q.len() / self.n;
        ((self.h, self.n), (self.q, rows))
    }

    #[inline(always)]
    fn sweep<const FMA: bool>(&mut self, passage: Passage, v: [f64; 3]) {
        let ((h, ld), (q, rows)) = self.parts();
        let Passage { first, from, last, window } = passage;
        for k in from..last {
            let r = if k > from {
                next_reflector(&mut h[(k - 1) * ld..k * ld], k, k + 1 < last)
            } else {
                let (_, r) = reflect_vector(v);
                if from > first {
                    // This entry is small but not zero: to working precision the reflection changes it by this factor.
                    h[(k - 1) * ld + k] *= 1.0 - r.t[0];
                }
                r
            };
            if r.t[0] == 0.0 {
                continue;
            }
            let columns = h[k * ld..window.1 * ld].chunks_exact_mut(ld);
            // Below the bulge these columns are zero.
            let below = window.0..(k + 4).min(last + 1);
            if k + 1 < last {
                reflect_rows3::<FMA>(columns, k, &r);
                reflect_columns3::<FMA>(&mut h[k * ld..(k + 3) * ld], ld, below, &r);
                if rows > 0 {
                    reflect_columns3::<FMA>(&mut q[k * rows..(k + 3) * rows], rows, 0..rows, &r);
                }
            } else {
                reflect_rows2::<FMA>(columns, k, &r);
                reflect_columns2::<FMA>(&mut h[k * ld..(k + 2) * ld], ld, below, &r);
                if rows > 0 {
                    reflect_columns2::<FMA>(&mut q[k * rows..(k + 2) * rows], rows, 0..rows, &r);
                }
            }
        }
    }
}

/// The reflector that advances the bulge; clears the column it is computed from (rows `k..`).
#[inline(always)]
pub(super) fn next_reflector(column: &mut [f64], k: usize, triple: bool) -> Reflector {
    let x = [column[k], column[k + 1], if triple { column[k + 2] } else { 0.0 }];
    let (beta, r) = reflect_vector(x);
    (column[k], column[k + 1]) = (beta, 0.0);
    if triple {
        column[k + 2] = 0.0;
    }
    r
}

/// Applies a reflector of order three to rows `row..row + 3` of the columns.
#[inline(always)]
pub(super) fn reflect_rows3<'a, const FMA: bool>(
    columns: impl Iterator<Item = &'a mut [f64]>,
    row: usize,
    r: &Reflector,
) {
    for column in columns {
        if let Some([x, y, z]) = column.get_mut(row..).and_then(|c| c.first_chunk_mut::<3>()) {
            // The previous reflector does not change the last row, so its product starts early.
            let s = fma::<FMA>(r.t[1], *y, fma::<FMA>(r.t[0], *x, r.t[2] * *z));
            *x -= s;
            *y = fma::<FMA>(-s, r.v[0], *y);
            *z = fma::<FMA>(-s, r.v[1], *z);
        }
    }
}

/// As [`reflect_rows3`], of order two.
#[inline(always)]
pub(super) fn reflect_rows2<'a, const FMA: bool>(
    columns: impl Iterator<Item = &'a mut [f64]>,
    row: usize,
    r: &Reflector,
) {
    for column in columns {
        if let Some([x, y]) = column.get_mut(row..).and_then(|c| c.first_chunk_mut::<2>()) {
            let s = fma::<FMA>(r.t[1], *y, r.t[0] * *x);
            *x -= s;
            *y = fma::<FMA>(-s, r.v[0], *y);
        }
    }
}

/// Applies a reflector of order three to three columns, from the right.
#[inline(always)]
fn reflect_columns3<const FMA: bool>(columns: &mut [f64], ld: usize, rows: core::ops::Range<usize>, r: &Reflector) {
    let (x, rest) = columns.split_at_mut(ld);
    let (y, z) = rest.split_at_mut(ld);
    let (x, x_rest) = x[rows.clone()].as_chunks_mut::<4>();
    let (y, y_rest) = y[rows.clone()].as_chunks_mut::<4>();
    let (z, z_rest) = z[rows].as_chunks_mut::<4>();
    for ((x, y), z) in x.iter_mut().zip(y).zip(z) {
        reflect3::<4, FMA>(r, x, y, z);
    }
    for ((x, y), z) in x_rest.iter_mut().zip(y_rest).zip(z_rest) {
        reflect3::<1, FMA>(r, array::from_mut(x), array::from_mut(y), array::from_mut(z));
    }
}

/// As [`reflect_columns3`], of order two.
#[inline(always)]
fn reflect_columns2<const FMA: bool>(columns: &mut [f64], ld: usize, rows: core::ops::Range<usize>, r: &Reflector) {
    let (x, y) = columns.split_at_mut(ld);
    let (x, x_rest) = x[rows.clone()].as_chunks_mut::<4>();
    let (y, y_rest) = y[rows].as_chunks_mut::<4>();
    for (x, y) in x.iter_mut().zip(y) {
        reflect2::<4, FMA>(r, x, y);
    }
    for (x, y) in x_rest.iter_mut().zip(y_rest) {
        reflect2::<1, FMA>(r, array::from_mut(x), array::from_mut(y));
    }
}

/// First row of the unreduced block that ends at `last`.
#[inline(always)]
pub(super) fn first_of_active_block(h: &[f64], n: usize, last: usize) -> usize {
    let at = |i: usize, j: usize| h[j * n + i];
    let tiny = f64::MIN_POSITIVE * (n as f64 / f64::EPSILON);
    for k in (1..=last).rev() {
        let sub = at(k, k - 1).abs();
        if sub <= tiny {
            return k;
        }
        let mut near = at(k - 1, k - 1).abs() + at(k, k).abs();
        if near == 0.0 {
            if k >= 2 {
                near += at(k - 1, k - 2).abs();
            }
            if k < last {
                near += at(k + 1, k).abs();
            }
        }
        if sub <= f64::EPSILON * near {
            let sup = at(k - 1, k).abs();
            let difference = (at(k - 1, k - 1) - at(k, k)).abs();
            let (ab, ba) = (sub.max(sup), sub.min(sup));
            let (aa, bb) = (at(k, k).abs().max(difference), at(k, k).abs().min(difference));
            let s = aa + ab;
            if ba * (ab / s) <= tiny.max(f64::EPSILON * (bb * (aa / s))) {
                return k;
            }
        }
    }
    0
}

#[inline(always)]
fn shifts(h: &[f64], n: usize, first: usize, last: usize, stalled: usize) -> Shifts {
    let at = |i: usize, j: usize| h[j * n + i];
    // Block whose eigenvalues are the shifts; the constants of the exceptional shift are those of LAPACK.
    let exceptional = |s: f64, centre: f64| [[0.75 * s + centre, -0.4375 * s], [s, 0.75 * s + centre]];
    let [[a, b], [c, d]] = if stalled.is_multiple_of(2 * PATIENCE) {
        exceptional(at(last, last - 1).abs() + at(last - 1, last - 2).abs(), at(last, last))
    } else if stalled.is_multiple_of(PATIENCE) {
        exceptional(at(first + 1, first).abs() + at(first + 2, first + 1).abs(), at(first, first))
    } else {
        let k = last - 1;
        [[at(k, k), at(k, last)], [at(last, k), at(last, last)]]
    };
    let s = a.abs() + b.abs() + c.abs() + d.abs();
    if s == 0.0 {
        return Shifts { re: [0.0; 2], im: [0.0; 2] };
    }
    let (a, b, c, d) = (a / s, b / s, c / s, d / s);
    let mean = 0.5 * (a + d);
    let determinant = (a - mean) * (d - mean) - b * c;
    let root = determinant.abs().sqrt();
    if determinant >= 0.0 {
        return Shifts { re: [mean * s; 2], im: [root * s, -root * s] };
    }
    // Two real eigenvalues: take the one nearer to the corner twice.
    let (above, below) = (mean + root, mean - root);
    let nearer = if (above - d).abs() <= (below - d).abs() { above } else { below };
    Shifts { re: [nearer * s; 2], im: [0.0; 2] }
}

/// The first column of the shifted product on rows `m..m + 3`, up to scale.
#[inline(always)]
pub(super) fn shifted_column(h: &[f64], n: usize, m: usize, shifts: Shifts) -> [f64; 3] {
    let at = |i: usize, j: usize| h[j * n + i];
    let Shifts { re, im } = shifts;
    let (here, next) = (at(m, m), at(m + 1, m + 1));
    let s = (here - re[1]).abs() + im[1].abs() + at(m + 1, m).abs();
    if s == 0.0 {
        return [0.0; 3];
    }
    let below = at(m + 1, m) / s;
    let v = [
        below * at(m, m + 1) + (here - re[0]) * ((here - re[1]) / s) - im[0] * (im[1] / s),
        below * (here + next - re[0] - re[1]),
        below * at(m + 2, m + 1),
    ];
    let size = v[0].abs() + v[1].abs() + v[2].abs();
    if size > 0.0 { v.map(|e| e / size) } else { v }
}

/// Start of the sweep: the lowest row at which two small consecutive subdiagonal entries let the bulge enter, and the
/// first column of the shifted product there.
#[inline(always)]
fn start_of_bulge(h: &[f64], n: usize, first: usize, last: usize, shifts: Shifts) -> (usize, [f64; 3]) {
    let at = |i: usize, j: usize| h[j * n + i];
    let Shifts { re, im } = shifts;
    let mut m = last - 2;
    // Without division. Underflow does no harm: at worst the test below is made.
    while m > first {
        let (here, next, below) = (at(m, m), at(m + 1, m + 1), at(m + 1, m));
        let v0 = below * at(m, m + 1) + (here - re[0]) * (here - re[1]) - im[0] * im[1];
        let v12 = below.abs() * ((here + next - re[0] - re[1]).abs() + at(m + 2, m + 1).abs());
        let around = at(m - 1, m - 1).abs() + here.abs() + next.abs();
        if at(m, m - 1).abs() * v12 <= 2.0 * f64::EPSILON * v0.abs() * around {
            break;
        }
        m -= 1;
    }
    loop {
        let v = shifted_column(h, n, m, shifts);
        if m == first {
            return (m, v);
        }
        let around = at(m - 1, m - 1).abs() + at(m, m).abs() + at(m + 1, m + 1).abs();
        if at(m, m - 1).abs() * (v[1].abs() + v[2].abs()) <= f64::EPSILON * v[0].abs() * around {
            return (m, v);
        }
        m -= 1;
    }
}
