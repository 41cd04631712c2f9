//! Aggressive early deflation (Braman, Byers, Mathias, SIAM J. Matrix Anal. Appl. 23, 2002, part II; Byers, LAPACK
//! Working Note 187, 2007).
//!
//! The Schur form of a window at the bottom of the active block turns the one entry that couples it to the rest into a
//! column, the spike. Where an entry of the spike is negligible, the eigenvalue in that row has converged, long before
//! the subdiagonal entries show it. The other eigenvalues are moved up and serve as shifts of the next sweep, and the
//! window is reduced to Hessenberg form again.

use super::francis::Francis;
use super::hessenberg::{Reduction, reflector};
use super::swap::{block_order, swap};
use crate::kernel::{Kernel, dispatch};
use faer::linalg::matmul::matmul;
use faer::{Accum, MatMut, MatRef, Par};

/// The matrix under iteration: `h` of order `n`, the transformation `q` of `n` columns (or empty), and whether all of T
/// is wanted or only its diagonal blocks.
pub(super) struct Iterate<'a> {
    pub(super) h: &'a mut [f64],
    pub(super) n: usize,
    pub(super) q: &'a mut [f64],
    pub(super) whole: bool,
}

/// Workspace: the window, its transformation, a few vectors, and a block row or column of the matrix.
#[derive(Default)]
pub(super) struct Window {
    t: Vec<f64>,
    v: Vec<f64>,
    work: Vec<f64>,
    strip: Vec<f64>,
    /// Eigenvalues that have not converged.
    pub(super) values: Vec<(f64, f64)>,
}

/// Result of one deflation.
pub(super) struct Deflated {
    /// Trailing rows that are in Schur form.
    pub(super) rows: usize,
    /// Leading rows of the window that did not converge within the maximum number of sweeps.
    pub(super) stuck: usize,
}

impl Window {
    pub(super) fn reserve(&mut self, n: usize, order: usize) {
        let grow = |x: &mut Vec<f64>, len: usize| {
            if x.len() < len {
                x.resize(len, 0.0);
            }
        };
        grow(&mut self.t, order * order);
        grow(&mut self.v, order * order);
        grow(&mut self.work, 4 * order);
        grow(&mut self.strip, n * order);
        if self.values.capacity() < order {
            self.values.reserve(order - self.values.len());
        }
    }

    /// Deflates in the window `at..at + order` of the active block that begins at `first` and ends with the window.
    pub(super) fn deflate(&mut self, m: &mut Iterate<'_>, first: usize, at: usize, order: usize) -> Deflated {
        let n = m.n;
        self.reserve(n, order);
        let Self { t, v, work, strip, values } = self;
        let (t, v) = (&mut t[..order * order], &mut v[..order * order]);
        for (column, from) in t.chunks_exact_mut(order).zip(m.h[at * n..].chunks_exact(n)) {
            column.copy_from_slice(&from[at..at + order]);
        }
        v.fill(0.0);
        v.iter_mut().step_by(order + 1).for_each(|e| *e = 1.0);
        let stuck = dispatch(Francis { h: t, n: order, q: v, whole: true });
        let spike = if at > first { m.h[(at - 1) * n + at] } else { 0.0 };
        let kept = if at > first { dispatch(Detection { t, v, order, stuck, spike }) } else { stuck };
        values_of(t, order, stuck..kept, values);
        let found = Deflated { rows: order - kept, stuck };
        if kept == order && spike != 0.0 {
            return found;
        }
        if kept > 1 && spike != 0.0 {
            // Reflects the spike to a single entry.
            let row = &mut work[3 * order..3 * order + kept];
            row.iter_mut().zip(v.iter().step_by(order)).for_each(|(e, v)| *e = *v);
            let (_, tau) = reflector(row[0], &mut row[1..]);
            row[0] = 1.0;
            let row = &*row;
            for column in t.chunks_exact_mut(order) {
                let s: f64 = row.iter().zip(&*column).map(|(v, c)| v * c).sum();
                column.iter_mut().zip(row).for_each(|(c, v)| *c -= tau * s * v);
            }
            for (m, rows) in [(&mut *t, kept), (&mut *v, order)] {
                let product = &mut strip[..rows];
                product.fill(0.0);
                for (column, v) in m.chunks_exact(order).zip(row) {
                    product.iter_mut().zip(column).for_each(|(p, c)| *p += c * v);
                }
                for (column, v) in m.chunks_exact_mut(order).zip(row) {
                    column.iter_mut().zip(&*product).for_each(|(c, p)| *c -= tau * v * p);
                }
            }
            dispatch(Reduction { h: t, n: order, order: kept, q: v, fresh: false, work: &mut work[..3 * order] });
        }
        if at > first {
            m.h[(at - 1) * n + at] = if kept == 0 { 0.0 } else { spike * v[0] };
        }
        for (column, to) in t.chunks_exact(order).zip(m.h[at * n..].chunks_exact_mut(n)) {
            to[at..at + order].copy_from_slice(column);
        }
        follow(m, first, at, order, v, strip);
        found
    }

    /// Stores the eigenvalues of the block `at..at + order` in `values`, as many as converge.
    pub(super) fn shifts_of(&mut self, m: &Iterate<'_>, at: usize, order: usize) {
        let n = m.n;
        self.reserve(n, order);
        let Self { t, values, .. } = self;
        let t = &mut t[..order * order];
        for (column, from) in t.chunks_exact_mut(order).zip(m.h[at * n..].chunks_exact(n)) {
            column.copy_from_slice(&from[at..at + order]);
        }
        let stuck = dispatch(Francis { h: t, n: order, q: &mut [], whole: false });
        values_of(t, order, stuck..order, values);
    }
}

/// Stores the eigenvalues of the diagonal blocks in `rows` of a Schur form of order `n` in `values`.
fn values_of(t: &[f64], n: usize, rows: core::ops::Range<usize>, values: &mut Vec<(f64, f64)>) {
    values.clear();
    let mut k = rows.start;
    while k < rows.end {
        let d = k * n + k;
        if block_order(t, n, k) == 2 {
            let im = t[d + 1].abs().sqrt() * t[d + n].abs().sqrt();
            values.extend([(t[d], im), (t[d], -im)]);
            k += 2;
        } else {
            values.push((t[d], 0.0));
            k += 1;
        }
    }
}

/// Applies the transformation `v` of the window to the rest of the matrix.
fn follow(m: &mut Iterate<'_>, first: usize, at: usize, order: usize, v: &[f64], strip: &mut [f64]) {
    let n = m.n;
    let end = at + order;
    let (top, right) = if m.whole { (0, n) } else { (first, end) };
    let v = MatRef::from_column_major_slice(v, order, order);
    let mut columns = |data: &mut [f64], ld: usize, rows: core::ops::Range<usize>| {
        let count = rows.len();
        if count == 0 {
            return;
        }
        let block = &mut data[at * ld + rows.start..];
        let copy = &mut strip[..count * order];
        for (to, from) in copy.chunks_exact_mut(count).zip(block.chunks(ld)) {
            to.copy_from_slice(&from[..count]);
        }
        let copy = MatRef::from_column_major_slice(copy, count, order);
        let block = MatMut::from_column_major_slice_with_stride_mut(block, count, order, ld);
        matmul(block, Accum::Replace, copy, v, 1.0, Par::Seq);
    };
    columns(m.h, n, top..at);
    if let Some(rows) = m.q.len().checked_div(n) {
        columns(m.q, rows, 0..rows);
    }
    if right > end {
        let block = &mut m.h[end * n + at..];
        let copy = &mut strip[..(right - end) * order];
        for (to, from) in copy.chunks_exact_mut(order).zip(block.chunks(n)) {
            to.copy_from_slice(&from[..order]);
        }
        let copy = MatRef::from_column_major_slice(copy, order, right - end);
        let block = MatMut::from_column_major_slice_with_stride_mut(block, order, right - end, n);
        matmul(block, Accum::Replace, v.transpose(), copy, 1.0, Par::Seq);
    }
}

/// Moves the eigenvalues with a negligible spike to the bottom of the window `t`; returns the number of rows above
/// them.
struct Detection<'a> {
    t: &'a mut [f64],
    v: &'a mut [f64],
    order: usize,
    stuck: usize,
    spike: f64,
}

impl Kernel for Detection<'_> {
    type Output = usize;

    #[inline(always)]
    fn run<const FMA: bool>(self) -> usize {
        let Self { t, v, order: n, stuck, spike } = self;
        let tiny = f64::MIN_POSITIVE * (n as f64 / f64::EPSILON);
        let at = |t: &[f64], i: usize, j: usize| t[j * n + i];
        let mut kept = n;
        let mut top = stuck;
        while top < kept {
            let size = if kept >= top + 2 && at(t, kept - 1, kept - 2) != 0.0 { 2 } else { 1 };
            let mut near = at(t, kept - 1, kept - 1).abs();
            let mut height = (spike * v[(kept - 1) * n]).abs();
            if size == 2 {
                near += at(t, kept - 1, kept - 2).abs().sqrt() * at(t, kept - 2, kept - 1).abs().sqrt();
                height = height.max((spike * v[(kept - 2) * n]).abs());
            }
            if near == 0.0 {
                near = spike.abs();
            }
            if height <= tiny.max(f64::EPSILON * near) {
                kept -= size;
                continue;
            }
            // Moves the block up to the others that have not converged.
            let mut k = kept - size;
            while k > top {
                let above = if k >= top + 2 && at(t, k - 1, k - 2) != 0.0 { 2 } else { 1 };
                if swap(t, n, v, k - above, above, size).is_err() {
                    break;
                }
                k -= above;
                if size == 2 && at(t, k + 1, k) == 0.0 {
                    break;
                }
            }
            top = k + size;
        }
        kept
    }
}
