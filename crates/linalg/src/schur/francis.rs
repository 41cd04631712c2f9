//! Implicit double-shift QR iteration on an upper Hessenberg matrix (Francis, Computer Journal 4, 1961-62), as in LAPACK dlahqr.
//!
//! Deflation by Ahues and Tisseur (LAPACK Working Note 122, 1997), which keeps the small eigenvalues of graded matrices; an
//! exceptional shift after every ten sweeps without deflation, for matrices that the ordinary shift maps to themselves (a cyclic
//! permutation has no preferred eigenvalue); a hard cap on the number of sweeps. About 20 n^3 flops with the vectors.

use super::hessenberg::reflector;
use super::standard::standardise_block;
use crate::{LinalgError, Result};
use nalgebra::DMatrix;

/// Sweeps without deflation before a shift is replaced by an exceptional one.
const PATIENCE: usize = 10;
/// Sweeps allowed for each row. Two or three are used in practice.
const SWEEPS_PER_ROW: usize = 30;

/// Eigenvalues `re[i] + i im[i]` that shift a sweep.
#[derive(Clone, Copy)]
struct Shifts {
    re: [f64; 2],
    im: [f64; 2],
}

/// Reduces the Hessenberg matrix `h` to real Schur form in place, and multiplies `q` by the transformation from the right.
pub(crate) fn francis(h: &mut DMatrix<f64>, q: &mut DMatrix<f64>) -> Result<()> {
    let n = h.nrows();
    if n == 0 {
        return Ok(());
    }
    let cap = SWEEPS_PER_ROW * n.max(PATIENCE);
    let mut sweeps = 0;
    let mut stalled = 0;
    // The active block ends at row `last`; what lies below is in Schur form.
    let mut end = n;
    while end > 1 {
        let last = end - 1;
        let first = first_of_active_block(h, last);
        if first > 0 {
            h[(first, first - 1)] = 0.0;
        }
        if first == last {
            end = last;
            stalled = 0;
            continue;
        }
        if first + 1 == last {
            standardise_block(h, q, first);
            end = first;
            stalled = 0;
            continue;
        }
        if sweeps == cap {
            return Err(LinalgError::NotConverged {
                method: "the QR iteration for the real Schur form",
                iterations: cap,
                remaining: h[(last, last - 1)].abs(),
                allowed: f64::EPSILON * (h[(last, last)].abs() + h[(last - 1, last - 1)].abs()),
            });
        }
        sweeps += 1;
        stalled += 1;
        let shifts = shifts(h, first, last, stalled);
        let (start, v) = start_of_bulge(h, first, last, shifts);
        sweep(h, q, first, last, start, v);
    }
    Ok(())
}

/// The row where the unreduced block that ends at `last` begins.
fn first_of_active_block(h: &DMatrix<f64>, last: usize) -> usize {
    let n = h.nrows();
    let tiny = f64::MIN_POSITIVE * (n as f64 / f64::EPSILON);
    for k in (1..=last).rev() {
        let sub = h[(k, k - 1)].abs();
        if sub <= tiny {
            return k;
        }
        let mut near = h[(k - 1, k - 1)].abs() + h[(k, k)].abs();
        if near == 0.0 {
            if k >= 2 {
                near += h[(k - 1, k - 2)].abs();
            }
            if k < last {
                near += h[(k + 1, k)].abs();
            }
        }
        if sub <= f64::EPSILON * near {
            let sup = h[(k - 1, k)].abs();
            let difference = (h[(k - 1, k - 1)] - h[(k, k)]).abs();
            let (ab, ba) = (sub.max(sup), sub.min(sup));
            let (aa, bb) = (h[(k, k)].abs().max(difference), h[(k, k)].abs().min(difference));
            let s = aa + ab;
            if ba * (ab / s) <= tiny.max(f64::EPSILON * (bb * (aa / s))) {
                return k;
            }
        }
    }
    0
}

fn shifts(h: &DMatrix<f64>, first: usize, last: usize, stalled: usize) -> Shifts {
    // The block whose eigenvalues are the shifts; the numbers of the exceptional ones are LAPACK's.
    let exceptional = |s: f64, centre: f64| [[0.75 * s + centre, -0.4375 * s], [s, 0.75 * s + centre]];
    let [[a, b], [c, d]] = if stalled.is_multiple_of(2 * PATIENCE) {
        exceptional(h[(last, last - 1)].abs() + h[(last - 1, last - 2)].abs(), h[(last, last)])
    } else if stalled.is_multiple_of(PATIENCE) {
        exceptional(h[(first + 1, first)].abs() + h[(first + 2, first + 1)].abs(), h[(first, first)])
    } else {
        let k = last - 1;
        [[h[(k, k)], h[(k, last)]], [h[(last, k)], h[(last, last)]]]
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

/// Where the sweep may start: the lowest row at which two consecutive small subdiagonal entries let the bulge enter, and the
/// first column of the shifted product there, up to scale.
fn start_of_bulge(h: &DMatrix<f64>, first: usize, last: usize, shifts: Shifts) -> (usize, [f64; 3]) {
    let Shifts { re, im } = shifts;
    let mut m = last - 2;
    loop {
        let (here, next) = (h[(m, m)], h[(m + 1, m + 1)]);
        let s = (here - re[1]).abs() + im[1].abs() + h[(m + 1, m)].abs();
        let mut v = if s == 0.0 {
            [0.0; 3]
        } else {
            let below = h[(m + 1, m)] / s;
            [
                below * h[(m, m + 1)] + (here - re[0]) * ((here - re[1]) / s) - im[0] * (im[1] / s),
                below * (here + next - re[0] - re[1]),
                below * h[(m + 2, m + 1)],
            ]
        };
        let size = v[0].abs() + v[1].abs() + v[2].abs();
        if size > 0.0 {
            v = v.map(|e| e / size);
        }
        if m == first {
            return (m, v);
        }
        let around = h[(m - 1, m - 1)].abs() + here.abs() + next.abs();
        if h[(m, m - 1)].abs() * (v[1].abs() + v[2].abs()) <= f64::EPSILON * v[0].abs() * around {
            return (m, v);
        }
        m -= 1;
    }
}

/// One double-shift sweep: makes the bulge at `start` and chases it out of the block at `last`.
fn sweep(h: &mut DMatrix<f64>, q: &mut DMatrix<f64>, first: usize, last: usize, start: usize, mut v: [f64; 3]) {
    let n = h.nrows();
    for k in start..last {
        let size = 3.min(last - k + 1);
        if k > start {
            for (i, e) in v.iter_mut().enumerate().take(size) {
                *e = h[(k + i, k - 1)];
            }
        }
        let (beta, tau) = reflector(&mut v[..size]);
        if k > start {
            h[(k, k - 1)] = beta;
            for i in 1..size {
                h[(k + i, k - 1)] = 0.0;
            }
        } else if start > first {
            // The entry is not zero but small: the reflection changes it this way to working precision.
            h[(k, k - 1)] *= 1.0 - tau;
        }
        if tau == 0.0 {
            continue;
        }
        let rows = n.min(last.min(k + 3) + 1);
        if size == 3 {
            let v = [1.0, v[1], v[2]];
            left3(&mut h.as_mut_slice()[k * n..], n, k, v, tau);
            right3(&mut h.as_mut_slice()[k * n..(k + 3) * n], n, rows, v, tau);
            right3(&mut q.as_mut_slice()[k * n..(k + 3) * n], n, n, v, tau);
        } else {
            left2(&mut h.as_mut_slice()[k * n..], n, k, v[1], tau);
            right2(&mut h.as_mut_slice()[k * n..(k + 2) * n], n, rows, v[1], tau);
            right2(&mut q.as_mut_slice()[k * n..(k + 2) * n], n, n, v[1], tau);
        }
    }
}

/// Reflects rows `row..row + 3` of the columns in `data`.
fn left3(data: &mut [f64], n: usize, row: usize, v: [f64; 3], tau: f64) {
    for column in data.chunks_exact_mut(n) {
        if let [x, y, z] = &mut column[row..row + 3] {
            let s = tau * (*x + v[1] * *y + v[2] * *z);
            *x -= s;
            *y -= s * v[1];
            *z -= s * v[2];
        }
    }
}

fn left2(data: &mut [f64], n: usize, row: usize, v: f64, tau: f64) {
    for column in data.chunks_exact_mut(n) {
        if let [x, y] = &mut column[row..row + 2] {
            let s = tau * (*x + v * *y);
            *x -= s;
            *y -= s * v;
        }
    }
}

/// Reflects the three columns in `data`, rows `0..rows`.
fn right3(data: &mut [f64], n: usize, rows: usize, v: [f64; 3], tau: f64) {
    let (x, rest) = data.split_at_mut(n);
    let (y, z) = rest.split_at_mut(n);
    for ((x, y), z) in x[..rows].iter_mut().zip(&mut y[..rows]).zip(&mut z[..rows]) {
        let s = tau * (*x + v[1] * *y + v[2] * *z);
        *x -= s;
        *y -= s * v[1];
        *z -= s * v[2];
    }
}

fn right2(data: &mut [f64], n: usize, rows: usize, v: f64, tau: f64) {
    let (x, y) = data.split_at_mut(n);
    for (x, y) in x[..rows].iter_mut().zip(&mut y[..rows]) {
        let s = tau * (*x + v * *y);
        *x -= s;
        *y -= s * v;
    }
}
