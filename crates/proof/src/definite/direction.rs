//! Refutation of definiteness: a direction `v` for which `v'Mv` provably has the wrong sign.
//!
//! The candidate v is computed without error bounds, from the diagonal, a 2 x 2 minor, the pivot at which Cholesky
//! stopped, or an approximate eigenvector. `v'Mv` is then enclosed with outward rounding, and computed exactly if the
//! enclosure is inconclusive and the entries are exact.

use super::Direction;
use super::cholesky::{Ball, Factor, factor, half_exponent, rounding_bound, times_power_of_two};
use crate::exact::{Exact, power_of_two};
use crate::interval::Interval;
use crate::matrix::Matrix;
use crate::ring::Ring;

/// Returns the candidate as a witness if `v'Mv <= 0` is proved (`strict`, against M > 0) or `v'Mv < 0` (against M >=
/// 0).
pub(super) fn verify(
    enclosed: &Matrix<Interval>,
    exact: Option<&Matrix<Exact>>,
    mut v: Vec<f64>,
    strict: bool,
) -> Option<Direction> {
    let largest = v.iter().fold(0.0_f64, |m, x| m.max(x.abs()));
    if !(largest > 0.0 && largest.is_finite()) || v.iter().any(|x| x.is_nan()) {
        return None;
    }
    // Scales the largest entry to [1, 4). The scaled v, with its rounding, is the vector that is verified; its largest
    // entry stays nonzero.
    let scale = power_of_two(-half_exponent(largest));
    for x in &mut v {
        *x = *x * scale * scale;
    }
    let refutes = |bound: f64| if strict { bound <= 0.0 } else { bound < 0.0 };
    let value = enclosed_form(enclosed, &v)?.hi();
    if refutes(value) {
        return Some(Direction { v, value, exact: None, is_negated: false });
    }
    let w: Option<Vec<Exact>> = v.iter().map(|&x| Exact::from_f64(x)).collect();
    let form = super::quadratic_form(exact?, &w?).ok()?;
    let value = form.round_up();
    refutes(value).then_some(Direction { v, value, exact: None, is_negated: false })
}

/// Enclosure of `v'Mv` with outward rounding.
fn enclosed_form(m: &Matrix<Interval>, v: &[f64]) -> Option<Interval> {
    let mut value = Interval::zero();
    for (i, &x) in v.iter().enumerate() {
        let mut row = Interval::zero();
        for (&y, entry) in v.iter().zip(m.row(i)) {
            row = row.add(&Interval::from_f64(y)?.mul(entry));
        }
        value = value.add(&row.mul(&Interval::from_f64(x)?));
    }
    Some(value)
}

/// Unit vector of the smallest diagonal entry, if that is not positive.
pub(super) fn from_diagonal(ball: &Ball) -> Option<Vec<f64>> {
    let n = ball.mid.rows();
    let lowest = (0..n).min_by(|&i, &j| ball.mid[(i, i)].total_cmp(&ball.mid[(j, j)]))?;
    (ball.mid[(lowest, lowest)] <= 0.0).then(|| unit(n, lowest))
}

fn unit(n: usize, i: usize) -> Vec<f64> {
    let mut v = vec![0.0; n];
    v[i] = 1.0;
    v
}

/// Direction of the 2 x 2 principal minor with the largest `|m_ij| / sqrt(m_ii m_jj) > 1`.
pub(super) fn from_minor(ball: &Ball) -> Option<Vec<f64>> {
    let n = ball.mid.rows();
    let mut worst: Option<(f64, usize, usize)> = None;
    for i in 0..n {
        for j in i + 1..n {
            let (x, a, b) = (ball.mid[(i, j)].abs(), ball.mid[(i, i)].max(0.0), ball.mid[(j, j)].max(0.0));
            // The roots before the product avoid overflow and underflow.
            let room = a.sqrt() * b.sqrt();
            let excess = x / room;
            if x > room && worst.is_none_or(|(w, _, _)| excess > w) {
                worst = Some((excess, i, j));
            }
        }
    }
    let (_, i, j) = worst?;
    let (x, a, b) = (ball.mid[(i, j)], ball.mid[(i, i)].max(0.0), ball.mid[(j, j)].max(0.0));
    let mut v = vec![0.0; n];
    if a > 0.0 && b > 0.0 {
        // With v_i^2 a = v_j^2 b the form is 2 (1 - excess) times this number. The larger entry is 1.
        let ratio = (a / b).sqrt();
        (v[i], v[j]) = if ratio <= 1.0 { (1.0, -ratio * x.signum()) } else { (1.0 / ratio, -x.signum()) };
    } else {
        // One diagonal entry is 0 (index k) but its row is not. With v_l = 1, v_k = -sign(x) t and t |x| >= m_ll the
        // form is < 0.
        let (k, l, rest) = if a > 0.0 { (j, i, a) } else { (i, j, b) };
        let t = if rest > 0.0 { rest / x.abs() } else { 1.0 };
        (v[k], v[l]) = if t <= 1.0 { (-x.signum() * t, 1.0) } else { (-x.signum(), 1.0 / t) };
    }
    Some(v)
}

/// Direction from a Cholesky factorisation stopped at `row`: `R z = -r_row` above that row, 1 in it, 0 below. Its
/// quadratic form is the pivot.
pub(super) fn from_stopped(r: &Matrix<f64>, exponent: &[i64], row: usize) -> Vec<f64> {
    let n = exponent.len();
    let mut z = vec![0.0; n];
    z[row] = 1.0;
    for k in (0..row).rev() {
        let sum: f64 = (k + 1..=row).map(|j| r[(k, j)] * z[j]).sum();
        z[k] = -sum / r[(k, k)];
    }
    // Back from the scaled matrix: v = D z, scaled by the largest entry of D in use.
    let least = exponent[..=row].iter().copied().min().unwrap_or(0);
    for (z, k) in z.iter_mut().zip(exponent) {
        *z *= power_of_two((least - k).min(0));
    }
    z
}

/// Approximate eigenvector for the smallest eigenvalue of the equilibrated midpoint, by inverse iteration with the
/// smallest shift of a geometric sequence for which Cholesky completes. `None` if a diagonal entry is not positive, or
/// on overflow.
pub(super) fn from_eigenvector(ball: &Ball) -> Option<Vec<f64>> {
    let n = ball.mid.rows();
    if (0..n).any(|i| ball.mid[(i, i)] <= 0.0) {
        return None;
    }
    let exponent: Vec<i64> = (0..n).map(|i| half_exponent(ball.mid[(i, i)])).collect();
    let scaled = Matrix::from_fn(n, n, |i, j| times_power_of_two(ball.mid[(i, j)], -(exponent[i] + exponent[j])));
    let mut shift = rounding_bound(n, &scaled);
    // From about 1e-15 to beyond the norm of any matrix that passed the test of its minors, at most 4 n.
    while shift < 8.0 * n as f64 {
        let mut shifted = scaled.clone();
        for i in 0..n {
            shifted[(i, i)] += shift;
        }
        if let Ok(r) = factor(shifted) {
            let factored = Factor { r, exponent: vec![0; n], order: (0..n).collect() };
            let (_, mut v) = factored.smallest_eigenvalue()?;
            let least = exponent.iter().copied().min()?;
            for (x, k) in v.iter_mut().zip(&exponent) {
                *x *= power_of_two(least - k);
            }
            return Some(v);
        }
        shift *= 8.0;
    }
    None
}
