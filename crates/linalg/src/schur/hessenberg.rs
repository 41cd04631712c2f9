//! Householder reduction to upper Hessenberg form, `A = Q H Q'` (Golub and Van Loan, Matrix Computations, 7.4.3).
//!
//! 10/3 n^3 flops, and 4/3 n^3 more for `Q`. Small orders use an unblocked loop, which works along columns and reads
//! the matrix twice per column; from order [`BLOCKED`] on faer's blocked reduction is used.

use crate::kernel::{Kernel, fma};
use faer::dyn_stack::{MemBuffer, MemStack, StackReq};
use faer::linalg::evd::hessenberg::{HessenbergParams, hessenberg_in_place, hessenberg_in_place_scratch};
use faer::linalg::householder::{
    apply_block_householder_sequence_on_the_left_in_place_scratch as apply_scratch,
    apply_block_householder_sequence_on_the_left_in_place_with_conj as apply,
};
use faer::linalg::qr::no_pivoting::factor::recommended_block_size;
use faer::{Conj, MatMut, MatRef, Par, Spec};

/// Order from which faer's reduction is faster.
pub(super) const BLOCKED: usize = 100;

/// Overwrites `x` with the tail of `v`, where `I - tau v v'`, `v[0] = 1`, maps `(head, x)` to `beta e1`, and returns
/// `(beta, tau)`. `tau = 0` (the identity) when `x` is zero already.
#[inline(always)]
pub fn reflector(head: f64, x: &mut [f64]) -> (f64, f64) {
    let largest = x.iter().fold(0.0_f64, |m, e| m.max(e.abs()));
    if largest == 0.0 {
        return (head, 0.0);
    }
    let largest = largest.max(head.abs());
    // Outside this range the squares below would underflow or overflow.
    let scale = if (1e-140..1e140).contains(&largest) { 1.0 } else { largest };
    if scale != 1.0 {
        for e in x.iter_mut() {
            *e /= scale;
        }
    }
    let alpha = head / scale;
    let norm = (alpha * alpha + x.iter().map(|e| e * e).sum::<f64>()).sqrt();
    let beta = if alpha > 0.0 { -norm } else { norm };
    let pivot = alpha - beta;
    for e in x.iter_mut() {
        *e /= pivot;
    }
    (beta * scale, -pivot / beta)
}

/// Reduces the leading block of order `order` of the matrix `h` of order `n`: its rows in full, its columns down to row
/// `order`. The reflectors multiply `q`, of `n` columns, from the right; with `fresh`, `q` must be the identity.
pub struct Reduction<'a> {
    /// The matrix.
    pub h: &'a mut [f64],
    /// Its order.
    pub n: usize,
    /// Order of the leading block.
    pub order: usize,
    /// What the reflectors multiply.
    pub q: &'a mut [f64],
    /// Whether `q` is the identity.
    pub fresh: bool,
    /// `3 n` numbers.
    pub work: &'a mut [f64],
}

impl Kernel for Reduction<'_> {
    type Output = ();

    #[inline(always)]
    fn run<const FMA: bool>(self) {
        let Self { h, n, order, q, fresh, work } = self;
        if order < 3 {
            return;
        }
        let rows = q.len() / n;
        let (taus, work) = work.split_at_mut(n);
        let (product, full) = work.split_at_mut(n);
        for k in 0..order - 2 {
            let (left, right) = h.split_at_mut((k + 1) * n);
            let column = &mut left[k * n + k + 1..k * n + order];
            let (head, tail) = (column[0], &mut column[1..]);
            let (beta, tau) = reflector(head, tail);
            taus[k] = tau;
            column[0] = beta;
            if tau == 0.0 {
                continue;
            }
            let v = &mut full[..order - k - 1];
            v.copy_from_slice(column);
            v[0] = 1.0;
            let v = &*v;
            // w = A v
            let w = &mut product[..order];
            times::<FMA>(right, n, v, w);
            // A - tau (w v'), then the reflector from the left, a column at a time.
            for (j, column) in right.chunks_exact_mut(n).enumerate() {
                let mut s = 0.0;
                if let Some(vj) = v.get(j) {
                    let (above, below) = column[..order].split_at_mut(k + 1);
                    axpy::<FMA>(above, -tau * vj, &w[..=k]);
                    s += axpy_dot::<FMA>(below, -tau * vj, &w[k + 1..], v);
                } else {
                    s += dot::<FMA>(&column[k + 1..order], v);
                }
                axpy::<FMA>(&mut column[k + 1..order], -tau * s, v);
            }
            if !fresh && rows > 0 {
                let block = &mut q[(k + 1) * rows..order * rows];
                times::<FMA>(block, rows, v, &mut product[..rows]);
                for (column, vj) in block.chunks_exact_mut(rows).zip(v) {
                    axpy::<FMA>(column, -tau * vj, &product[..rows]);
                }
            }
        }
        if fresh && rows > 0 {
            // Backward accumulation: each reflector changes only the part of Q that differs from the identity.
            for k in (0..order - 2).rev() {
                let v = &mut full[..order - k - 1];
                v.copy_from_slice(&h[k * n + k + 1..k * n + order]);
                v[0] = 1.0;
                for column in q[(k + 1) * rows..order * rows].chunks_exact_mut(rows) {
                    let column = &mut column[k + 1..order];
                    let s = dot::<FMA>(column, v);
                    axpy::<FMA>(column, -taus[k] * s, v);
                }
            }
        }
        for (k, column) in h.chunks_exact_mut(n).enumerate().take(order - 2) {
            column[k + 2..order].fill(0.0);
        }
    }
}

/// `w = M v`, for the leading columns of `M`, as many as `v` has entries.
#[inline(always)]
fn times<const FMA: bool>(m: &[f64], ld: usize, v: &[f64], w: &mut [f64]) {
    w.fill(0.0);
    let rows = w.len();
    let (fours, rest) = v.split_at(v.len() / 4 * 4);
    let mut columns = m.chunks_exact(ld);
    for v in fours.chunks_exact(4) {
        if let (Some(a), Some(b), Some(c), Some(d)) = (columns.next(), columns.next(), columns.next(), columns.next()) {
            for ((((w, a), b), c), d) in w.iter_mut().zip(&a[..rows]).zip(&b[..rows]).zip(&c[..rows]).zip(&d[..rows]) {
                *w = fma::<FMA>(*d, v[3], fma::<FMA>(*c, v[2], fma::<FMA>(*b, v[1], fma::<FMA>(*a, v[0], *w))));
            }
        }
    }
    for (v, column) in rest.iter().zip(columns) {
        axpy::<FMA>(w, *v, &column[..rows]);
    }
}

/// `y += a x`.
#[inline(always)]
fn axpy<const FMA: bool>(y: &mut [f64], a: f64, x: &[f64]) {
    for (y, x) in y.iter_mut().zip(x) {
        *y = fma::<FMA>(a, *x, *y);
    }
}

#[inline(always)]
fn dot<const FMA: bool>(x: &[f64], y: &[f64]) -> f64 {
    let mut sums = [0.0; 8];
    let (xs, ys) = (x.chunks_exact(8), y.chunks_exact(8));
    let rest: f64 = xs.remainder().iter().zip(ys.remainder()).map(|(x, y)| x * y).sum();
    for (x, y) in xs.zip(ys) {
        for l in 0..8 {
            sums[l] = fma::<FMA>(x[l], y[l], sums[l]);
        }
    }
    rest + ((sums[0] + sums[4]) + (sums[1] + sums[5])) + ((sums[2] + sums[6]) + (sums[3] + sums[7]))
}

/// `y += a x`, and `y'v` of the new y.
#[inline(always)]
fn axpy_dot<const FMA: bool>(y: &mut [f64], a: f64, x: &[f64], v: &[f64]) -> f64 {
    let mut sums = [0.0; 8];
    let (mut ys, xs, vs) = (y.chunks_exact_mut(8), x.chunks_exact(8), v.chunks_exact(8));
    let (x_rest, v_rest) = (xs.remainder(), vs.remainder());
    for ((y, x), v) in ys.by_ref().zip(xs).zip(vs) {
        for l in 0..8 {
            y[l] = fma::<FMA>(a, x[l], y[l]);
            sums[l] = fma::<FMA>(y[l], v[l], sums[l]);
        }
    }
    let mut rest = 0.0;
    for ((y, x), v) in ys.into_remainder().iter_mut().zip(x_rest).zip(v_rest) {
        *y = fma::<FMA>(a, *x, *y);
        rest += *y * v;
    }
    rest + ((sums[0] + sums[4]) + (sums[1] + sums[5])) + ((sums[2] + sums[6]) + (sums[3] + sums[7]))
}

/// Workspace of the blocked reduction.
#[derive(Default)]
pub struct Blocked {
    order: usize,
    factors: Vec<f64>,
    stack: Option<MemBuffer>,
}

impl Blocked {
    /// Reduces the matrix `h` of order `n`, and overwrites `q` with the transformation unless it is empty.
    pub fn reduce(&mut self, h: &mut [f64], n: usize, q: &mut [f64]) {
        if n < 3 {
            return;
        }
        let block = recommended_block_size::<f64>(n - 1, n - 1);
        let parameters = Spec::<HessenbergParams, f64>::default();
        if self.order != n || self.stack.is_none() {
            self.order = n;
            self.factors.resize(block * (n - 1), 0.0);
            let request = StackReq::any_of(&[
                hessenberg_in_place_scratch::<f64>(n, block, Par::Seq, parameters),
                apply_scratch::<f64>(n - 1, block, n - 1),
            ]);
            self.stack = Some(MemBuffer::new(request));
        }
        let Some(stack) = &mut self.stack else { return };
        let stack = MemStack::new(stack);
        hessenberg_in_place(
            MatMut::from_column_major_slice_mut(h, n, n),
            MatMut::from_column_major_slice_mut(&mut self.factors, block, n - 1),
            Par::Seq,
            stack,
            parameters,
        );
        if !q.is_empty() {
            q.fill(0.0);
            q.iter_mut().step_by(n + 1).for_each(|e| *e = 1.0);
            apply(
                MatRef::from_column_major_slice(h, n, n).submatrix(1, 0, n - 1, n - 1),
                MatRef::from_column_major_slice(&self.factors, block, n - 1),
                Conj::No,
                MatMut::from_column_major_slice_mut(q, n, n).submatrix_mut(1, 1, n - 1, n - 1),
                Par::Seq,
                stack,
            );
        }
        for (k, column) in h.chunks_exact_mut(n).enumerate().take(n - 2) {
            column[k + 2..].fill(0.0);
        }
    }
}
