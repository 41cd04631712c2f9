//! Largest and smallest singular value of a small square matrix, without the others.
//!
//! Method: Householder bidiagonalisation `U'X V = B` (Golub and Van Loan, Matrix Computations, 5.4.8), then Laguerre's
//! iteration for the extreme eigenvalues of `B'B`, which converges monotonically from outside the spectrum, with order
//! three. The determinant of `B'B - x I` and its derivatives are those of the stationary qd transform (Parlett and
//! Dhillon, Linear Algebra Appl. 309, 2000), which gives even the smallest singular value of a bidiagonal matrix with
//! high relative accuracy. `8/3 n^3` flops.

use nalgebra::DMatrix;

use crate::staircase::{dot, subtract};

/// Maximum number of Laguerre steps. A simple eigenvalue takes about five; one that is double to working precision
/// gains at least half a digit per step.
const STEPS: usize = 100;

/// `(largest, smallest)` singular value of X, whose entries are finite and not far from one. `None` if the iteration
/// does not converge; no such case is known.
pub fn extreme_singular_values(x: DMatrix<f64>) -> Option<(f64, f64)> {
    let bidiagonal = Bidiagonal::of(x);
    let size: f64 = bidiagonal.diagonal.iter().chain(&bidiagonal.above).sum();
    if size == 0.0 {
        return Some((0.0, 0.0));
    }
    // The trace of `B'B` bounds all eigenvalues; 1.01 covers rounding.
    let largest = bidiagonal.approach(1.01 * size)?;
    let smallest = if bidiagonal.diagonal.contains(&0.0) { 0.0 } else { bidiagonal.approach(0.0)? };
    Some((largest.sqrt(), smallest.sqrt()))
}

/// The squares of the entries of an upper bidiagonal matrix.
struct Bidiagonal {
    diagonal: Vec<f64>,
    above: Vec<f64>,
}

impl Bidiagonal {
    fn of(mut x: DMatrix<f64>) -> Self {
        let n = x.nrows();
        let (mut diagonal, mut above) = (Vec::with_capacity(n), Vec::with_capacity(n));
        let (mut row, mut image) = (vec![0.0; n], vec![0.0; n]);
        for k in 0..n {
            let (left, right) = x.as_mut_slice().split_at_mut((k + 1) * n);
            let column = &mut left[k * n + k..];
            diagonal.push(dot(column, column));
            if let Some(tau) = reflector(column, diagonal[k]) {
                for other in right.chunks_exact_mut(n) {
                    let projection = tau * dot(column, &other[k..]);
                    subtract(&mut other[k..], projection, column);
                }
            }
            if k + 1 == n {
                break;
            }
            let row = &mut row[k + 1..];
            for (x, other) in row.iter_mut().zip(right.chunks_exact(n)) {
                *x = other[k];
            }
            above.push(dot(row, row));
            if let Some(tau) = reflector(row, above[k]) {
                let image = &mut image[k + 1..];
                image.fill(0.0);
                for (x, other) in row.iter().zip(right.chunks_exact(n)) {
                    subtract(image, -x, &other[k + 1..]);
                }
                for (x, other) in row.iter().zip(right.chunks_exact_mut(n)) {
                    subtract(&mut other[k + 1..], tau * x, image);
                }
            }
        }
        Self { diagonal, above }
    }

    /// The eigenvalue of `B'B` nearest to the start x, which lies below all eigenvalues or above all.
    fn approach(&self, mut x: f64) -> Option<f64> {
        let n = self.diagonal.len() as f64;
        for _ in 0..STEPS {
            let Some((first, second)) = self.sums(x) else { return Some(x) };
            let root = ((n - 1.0) * (n * second - first * first)).max(0.0).sqrt();
            let next = x + n / (first + root.copysign(first));
            if !next.is_finite() || (next - x).abs() <= 4.0 * f64::EPSILON * next.abs() {
                return next.is_finite().then_some(next);
            }
            x = next;
        }
        None
    }

    /// Sums of `1/(lambda - x)` and `1/(lambda - x)^2` over the eigenvalues. `None` if x is an eigenvalue or lies
    /// between two.
    fn sums(&self, x: f64) -> Option<(f64, f64)> {
        let (mut first, mut second) = (0.0, 0.0);
        // Term added to the pivot of `B'B - x I`, with its first and second derivative.
        let mut s = [-x, -1.0, 0.0];
        for (i, q) in self.diagonal.iter().enumerate() {
            let pivot = s[0] + q;
            if pivot == 0.0 || (pivot > 0.0) != (self.diagonal[0] > x) {
                return None;
            }
            let (u, v) = (s[1] / pivot, s[2] / pivot);
            first -= u;
            second += u * u - v;
            if let Some(e) = self.above.get(i) {
                let t = [e / pivot, -(e / pivot) * u, (e / pivot) * (2.0 * u * u - v)];
                s = [t[0] * s[0] - x, t[1] * s[0] + t[0] * s[1] - 1.0, t[2] * s[0] + 2.0 * t[1] * s[1] + t[0] * s[2]];
            }
        }
        Some((first, second))
    }
}

/// Overwrites x, whose sum of squares is `squares`, with the v of the reflector `I - tau v v'` that maps x to a
/// multiple of the first unit vector; returns tau. `None` if x is already such a multiple.
fn reflector(x: &mut [f64], squares: f64) -> Option<f64> {
    if x.len() < 2 || squares == 0.0 {
        return None;
    }
    let norm = squares.sqrt();
    let tau = 1.0 / (squares + x[0].abs() * norm);
    x[0] += norm.copysign(x[0]);
    Some(tau)
}
