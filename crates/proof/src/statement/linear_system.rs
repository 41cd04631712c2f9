//! Enclosure of the solution of a linear system `M x = r`, with a verified floating-point inverse (Krawczyk).
//!
//! Let G be any matrix (here a floating-point inverse of the midpoint of M), `E = I - G M`, v > 0 a vector and
//! `|E| v <= h v` with h < 1. Then M is nonsingular, and
//! ```text
//! x in G r + [-1, 1] |E| y,    y = v max_k(|G r|_k / v_k) / (1 - h).
//! ```
//! *Proof.* `|E| v <= h v` bounds the spectral radius of E by h, so that `G M = I - E` is nonsingular. `M x = r` gives
//! `x = G r + E x`, hence `|x| <= (I - |E|)^-1 |G r|`; and `|G r| + |E| y <= (1 - h) y + h y = y` gives `|x| <= y`.
//! *qed.*
//!
//! An interval matrix M and an interval vector r stand for all within; the proof holds for each pair. If r is the
//! residual of an approximate solution, x is its error, and the second term is of second order in the rounding errors.

use crate::error::ProofError;
use crate::interval::Interval;
use crate::matrix::Matrix;
use crate::ring::Ring;

/// A matrix proved to be nonsingular by an approximate inverse.
pub(super) struct VerifiedInverse {
    /// G.
    g: Matrix<Interval>,
    /// `|E|`.
    defect: Matrix<Interval>,
    /// v, one column.
    weights: Matrix<Interval>,
    /// `1 - h`, rounded down, positive.
    left: f64,
}

impl VerifiedInverse {
    /// For a square M with bounded entries. The error value is `1 - h` if that is not positive, and 0 if no approximate
    /// inverse is found.
    pub(super) fn of(m: &Matrix<Interval>) -> Result<Result<Self, f64>, ProofError> {
        let order = m.rows();
        m.expect_shape("the matrix of a linear system", (order, order))?;
        let Some(inverse) = approximate_inverse(&m.map(|x| x.lo() / 2.0 + x.hi() / 2.0)) else { return Ok(Err(0.0)) };
        let g = Matrix::<Interval>::embed(&inverse, "an approximate inverse")?;
        let defect = Matrix::scalar(order, &Interval::ONE).difference(&g.product(m)?)?.map(size);
        // The row sums of |G| have the units of the unknowns.
        let sums: Vec<f64> = (0..order).map(|k| inverse.row(k).iter().map(|x| x.abs()).sum()).collect();
        let weights = Matrix::from_fn(order, 1, |k, _| sums[k].clamp(f64::MIN_POSITIVE, f64::MAX));
        let weights = Matrix::<Interval>::embed(&weights, "the weights of the unknowns")?;
        let h = largest_ratio(&defect.product(&weights)?, 0, &weights);
        if h.is_nan() || h >= 1.0 {
            return Ok(Err(1.0 - h));
        }
        let left = (1.0 - h).next_down();
        Ok(if left > 0.0 { Ok(Self { g, defect, weights, left }) } else { Err(left) })
    }

    /// `M^-1 r`, column by column; the error value is `1 - h` if a bound overflows.
    pub(super) fn times(&self, r: &Matrix<Interval>) -> Result<Result<Matrix<Interval>, f64>, ProofError> {
        let mut x = self.g.product(r)?;
        for j in 0..x.cols() {
            let reach = (largest_ratio(&x, j, &self.weights) / self.left).next_up();
            let Some(reach) = Interval::from_f64(reach) else { return Ok(Err(self.left)) };
            let rest = self.defect.product(&self.weights.scaled(&reach))?;
            for i in 0..x.rows() {
                let bound = rest[(i, 0)].hi();
                x[(i, j)] = x[(i, j)].add(&Interval::new(-bound, bound).unwrap_or(Interval::UNBOUNDED));
            }
        }
        Ok(Ok(x))
    }
}

/// Upper bound of `max_k |x|_k / v_k` for column j.
fn largest_ratio(x: &Matrix<Interval>, j: usize, v: &Matrix<Interval>) -> f64 {
    (0..x.rows()).fold(0.0_f64, |largest, k| {
        let ratio = size(&x[(k, j)]).quotient(&v[(k, 0)]).map_or(f64::INFINITY, |ratio| ratio.hi());
        largest.max(ratio)
    })
}

/// The largest magnitude of the interval, as a number.
fn size(x: &Interval) -> Interval {
    Interval::of(x.magnitude())
}

/// Approximate inverse by Gauss-Jordan elimination with partial pivoting, without error bound. `None` if a pivot is
/// zero or an entry overflows.
fn approximate_inverse(m: &Matrix<f64>) -> Option<Matrix<f64>> {
    let n = m.rows();
    let mut work = Matrix::from_fn(n, 2 * n, |i, j| {
        if j < n {
            m[(i, j)]
        } else if j - n == i {
            1.0
        } else {
            0.0
        }
    });
    for k in 0..n {
        let pivot_row = (k..n).max_by(|&i, &j| work[(i, k)].abs().total_cmp(&work[(j, k)].abs()))?;
        let pivot = work[(pivot_row, k)];
        if pivot == 0.0 || !pivot.is_finite() {
            return None;
        }
        let mut row: Vec<f64> = work.row(pivot_row).iter().map(|x| x / pivot).collect();
        row[k] = 1.0;
        let displaced = work.row(k).to_vec();
        work.row_mut(pivot_row).copy_from_slice(&displaced);
        for i in (0..n).filter(|&i| i != k) {
            let factor = work[(i, k)];
            if factor != 0.0 {
                for (x, y) in work.row_mut(i).iter_mut().zip(&row).skip(k) {
                    *x -= factor * y;
                }
            }
        }
        work.row_mut(k).copy_from_slice(&row);
    }
    let inverse = Matrix::from_fn(n, n, |i, j| work[(i, n + j)]);
    inverse.as_slice().iter().all(|x| x.is_finite()).then_some(inverse)
}
