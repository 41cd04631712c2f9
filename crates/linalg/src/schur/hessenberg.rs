//! Householder reduction to upper Hessenberg form, `A = Q H Q'` (Golub and Van Loan, Matrix Computations, 7.4.3).
//!
//! 10/3 n^3 flops, and 4/3 n^3 more for `Q`. Works down columns, which is how the matrix lies in memory.

use nalgebra::DMatrix;

/// The reflector `I - tau v v'`, `v[0] = 1`, that maps `x` to `beta e1`. Overwrites `x` with `v` and returns `(beta, tau)`.
/// `tau = 0` (the identity) when `x` is a multiple of `e1` already.
pub(crate) fn reflector(x: &mut [f64]) -> (f64, f64) {
    let Some((head, tail)) = x.split_first_mut() else { return (0.0, 0.0) };
    if tail.iter().all(|&e| e == 0.0) {
        let beta = *head;
        *head = 1.0;
        return (beta, 0.0);
    }
    let largest = tail.iter().fold(head.abs(), |m, e| m.max(e.abs()));
    // Outside this range the squares below would underflow or overflow.
    let scale = if (1e-140..1e140).contains(&largest) { 1.0 } else { largest };
    let alpha = *head / scale;
    for e in tail.iter_mut() {
        *e /= scale;
    }
    let norm = (alpha * alpha + tail.iter().map(|e| e * e).sum::<f64>()).sqrt();
    let beta = if alpha > 0.0 { -norm } else { norm };
    let pivot = alpha - beta;
    for e in tail.iter_mut() {
        *e /= pivot;
    }
    *head = 1.0;
    (beta * scale, (beta - alpha) / beta)
}

/// `M := (I - tau v v') M` on the rows from `row` and the columns `cols` of `m`.
pub(crate) fn reflect_rows(m: &mut DMatrix<f64>, v: &[f64], tau: f64, row: usize, cols: core::ops::Range<usize>) {
    let n = m.nrows();
    let data = m.as_mut_slice();
    for j in cols {
        let column = &mut data[j * n + row..j * n + row + v.len()];
        let s = tau * column.iter().zip(v).map(|(c, v)| c * v).sum::<f64>();
        column.iter_mut().zip(v).for_each(|(c, v)| *c -= s * v);
    }
}

/// `M := M (I - tau v v')` on the columns from `col` of `m`; `work` has one entry for each row.
pub(crate) fn reflect_cols(m: &mut DMatrix<f64>, v: &[f64], tau: f64, col: usize, work: &mut [f64]) {
    let n = m.nrows();
    work.fill(0.0);
    let data = &mut m.as_mut_slice()[col * n..(col + v.len()) * n];
    for (column, v) in data.chunks_exact(n).zip(v) {
        work.iter_mut().zip(column).for_each(|(w, c)| *w += c * v);
    }
    for (column, v) in data.chunks_exact_mut(n).zip(v) {
        let s = tau * v;
        column.iter_mut().zip(work.iter()).for_each(|(c, w)| *c -= s * w);
    }
}

/// `A = Q H Q'`; returns `(H, Q)`. The entries below the subdiagonal of `H` are exactly zero.
pub(crate) fn hessenberg(mut h: DMatrix<f64>) -> (DMatrix<f64>, DMatrix<f64>) {
    let n = h.nrows();
    let mut q = DMatrix::identity(n, n);
    let mut work = vec![0.0; n];
    let mut reflectors = Vec::with_capacity(n.saturating_sub(2));
    for k in 0..n.saturating_sub(2) {
        let mut v = h.as_slice()[k * n + k + 1..(k + 1) * n].to_vec();
        let (beta, tau) = reflector(&mut v);
        let column = &mut h.as_mut_slice()[k * n + k + 1..(k + 1) * n];
        column.fill(0.0);
        column[0] = beta;
        if tau != 0.0 {
            reflect_rows(&mut h, &v, tau, k + 1, k + 1..n);
            reflect_cols(&mut h, &v, tau, k + 1, &mut work);
        }
        reflectors.push((v, tau));
    }
    // Backwards, so that each reflector meets only the part of Q that is no longer the identity.
    for (k, (v, tau)) in reflectors.iter().enumerate().rev() {
        reflect_rows(&mut q, v, *tau, k + 1, k + 1..n);
    }
    (h, q)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn hessenberg_is_an_orthogonal_similarity() {
        let n = 7;
        let a = DMatrix::from_fn(n, n, |i, j| ((i * 7 + j * 3) % 11) as f64 - 4.5);
        let (h, q) = hessenberg(a.clone());
        let bound = 10.0 * n as f64 * f64::EPSILON * a.norm();
        assert!((&q * &h * q.transpose() - &a).norm() <= bound);
        assert!((q.transpose() * &q - DMatrix::identity(n, n)).norm() <= 10.0 * n as f64 * f64::EPSILON);
        for j in 0..n {
            for i in j + 2..n {
                assert_eq!(h[(i, j)], 0.0);
            }
        }
    }

    #[test]
    fn a_reflector_survives_the_ends_of_the_range() {
        for scale in [1e-300, 1.0, 1e300] {
            let x = [3.0 * scale, 0.0, -4.0 * scale];
            let mut v = x;
            let (beta, tau) = reflector(&mut v);
            assert!((beta.abs() / scale - 5.0).abs() <= 1e-14);
            let s = tau * (0..3).map(|i| v[i] * (x[i] / scale)).sum::<f64>();
            assert!((x[2] / scale - s * v[2]).abs() <= 1e-14);
        }
    }
}
