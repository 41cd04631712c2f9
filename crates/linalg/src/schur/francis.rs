//! Implicit double-shift QR iteration on a small upper Hessenberg matrix (Francis, Computer Journal 4, 1961-62), as in LAPACK dlahqr.
//!
//! Deflation by Ahues and Tisseur (LAPACK Working Note 122, 1997), which keeps the small eigenvalues of graded matrices; an
//! exceptional shift after every ten sweeps without deflation, for matrices that the ordinary shift maps to themselves (a cyclic
//! permutation has no preferred eigenvalue); a hard cap on the number of sweeps. About 20 n^3 flops with the vectors.

use super::bulge::{STEPS, Way, chase};
use super::chain::{Chain, Reflector, WIDTH, chain_on_columns};
use super::standard::standardise_block;
use crate::kernel::Kernel;

/// Sweeps without deflation before a shift is replaced by an exceptional one.
const PATIENCE: usize = 10;
/// Sweeps allowed for each row. Two or three are used in practice.
pub(super) const SWEEPS_PER_ROW: usize = 30;

/// Eigenvalues `re[i] + i im[i]` that shift a sweep.
#[derive(Debug, Clone, Copy)]
pub(super) struct Shifts {
    pub(super) re: [f64; 2],
    pub(super) im: [f64; 2],
}

/// What one sweep needs beside the matrices: its reflectors, and a few rows transposed.
#[derive(Debug, Clone, Default)]
pub(super) struct Scratch {
    reflectors: Vec<Reflector>,
    packed: Vec<f64>,
}

impl Scratch {
    pub(super) fn reserve(&mut self, n: usize) {
        if self.reflectors.len() < n {
            self.reflectors.resize(n, Reflector::default());
        }
        self.packed.resize(WIDTH * (STEPS + 2), 0.0);
    }
}

/// The iteration on the Hessenberg matrix `h` of order `n`, which becomes the real Schur form T if `whole`, else only its diagonal blocks. The
/// transformation is multiplied to `q`, of `n` columns, from the right.
///
/// The answer is the number of leading rows that have not converged: zero, unless the cap on the sweeps was met.
pub(super) struct Francis<'a> {
    pub(super) h: &'a mut [f64],
    pub(super) n: usize,
    pub(super) q: &'a mut [f64],
    pub(super) whole: bool,
    pub(super) scratch: &'a mut Scratch,
}

impl Kernel for Francis<'_> {
    type Output = usize;

    #[inline(always)]
    fn run<const FMA: bool>(self) -> usize {
        let Self { h, n, q, whole, scratch } = self;
        if n == 0 {
            return 0;
        }
        let rows = q.len() / n;
        scratch.reserve(n);
        let Scratch { reflectors, packed } = scratch;
        let cap = SWEEPS_PER_ROW * n.max(PATIENCE);
        let mut sweeps = 0;
        let mut stalled = 0;
        // The active block ends at row `last`; what lies below is in Schur form.
        let mut end = n;
        while end > 1 {
            let last = end - 1;
            let first = first_of_active_block(h, n, last);
            if first > 0 {
                h[(first - 1) * n + first] = 0.0;
            }
            if first == last {
                end = last;
                stalled = 0;
                continue;
            }
            if first + 1 == last {
                standardise_block(h, n, q, rows, first, if whole { (0, n) } else { (first, end) });
                end = first;
                stalled = 0;
                continue;
            }
            if sweeps == cap {
                return end;
            }
            sweeps += 1;
            stalled += 1;
            let shifts = shifts(h, n, first, last, stalled);
            let (from, v) = start_of_bulge(h, n, first, last, shifts);
            let window = if whole { (0, n) } else { (first, end) };
            let way = Way { from, to: last, last, window, entry: Some((v, from > first)) };
            chase::<FMA>(h, n, way, &mut reflectors[..last - from], packed);
            let chain = Chain { at: from, reflectors: &reflectors[..last - from], pair: true };
            chain_on_columns::<FMA>(q, rows, 0..rows, chain);
        }
        0
    }
}

/// The row where the unreduced block that ends at `last` begins.
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
    // The block whose eigenvalues are the shifts; the numbers of the exceptional ones are LAPACK's.
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

/// Where the sweep may start: the lowest row at which two consecutive small subdiagonal entries let the bulge enter, and the
/// first column of the shifted product there.
#[inline(always)]
fn start_of_bulge(h: &[f64], n: usize, first: usize, last: usize, shifts: Shifts) -> (usize, [f64; 3]) {
    let at = |i: usize, j: usize| h[j * n + i];
    let Shifts { re, im } = shifts;
    let mut m = last - 2;
    // Without a division, and without regard to underflow, which at worst calls for the test below.
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
