//! Condition numbers of the eigenvalues of a closed loop: how far each moves when the matrix changes.
//!
//! A change E of the matrix moves the simple eigenvalue lambda by `y*E x / y*x` to first order, `x, y` its right and
//! left eigenvectors: at most by `|E|` times `|x| |y| / |y*x|` (Wilkinson, The Algebraic Eigenvalue Problem, 2.8). This
//! number is infinite for a defective eigenvalue, which moves like a root of `|E|`; in floating point it is then very
//! large.
//!
//! The vectors are computed by substitution in the quasi-triangular T, in real arithmetic for real eigenvalues (as
//! LAPACK dtrevc), `2/3 n^3` flops for both sides.

use nalgebra::{Complex, DMatrix};

use super::eigenvectors::{Eigenvectors, Part};
use crate::schur::{Schur, blocks};

/// Eigenvalues with right and left eigenvectors, scaled so that `y*x = 1` in exact arithmetic.
pub struct Eigen {
    /// Eigenvalues, in the order of [`Schur::eigenvalues`].
    pub values: Vec<Complex<f64>>,
    /// Right eigenvectors x.
    pub right: Eigenvectors,
    /// Left eigenvectors y.
    pub left: Eigenvectors,
}

impl Eigen {
    /// Eigenvalues and eigenvectors of `Q T Q'`.
    pub fn of(form: &Schur) -> Self {
        let (mut right, mut left) = in_schur_coordinates(&form.t);
        right.columns = &form.q * right.columns;
        left.columns = &form.q * left.columns;
        Self { values: form.eigenvalues(), right, left }
    }
}

/// Condition number of each eigenvalue of `Q T Q'`, in the order of [`Schur::eigenvalues`], for vectors in the units
/// `x_given = 2^-powers x`. If all powers are zero, Q is not used.
pub fn conditions(form: &Schur, powers: &[i32]) -> Vec<f64> {
    let (right, left) = if powers.iter().all(|power| *power == 0) {
        // Q is orthogonal: norms do not change.
        in_schur_coordinates(&form.t)
    } else {
        let eigen = Eigen::of(form);
        (eigen.right.in_units(powers.iter().map(|power| -power)), eigen.left.in_units(powers.iter().copied()))
    };
    let products = right.norms().into_iter().zip(left.norms()).map(|(x, y)| x * y);
    products.map(|condition| if condition.is_nan() { f64::INFINITY } else { condition }).collect()
}

/// Right and left eigenvectors of the quasi-triangular T.
fn in_schur_coordinates(t: &DMatrix<f64>) -> (Eigenvectors, Eigenvectors) {
    let n = t.nrows();
    let blocks = blocks(t);
    let floor = (f64::EPSILON * t.norm()).max(f64::MIN_POSITIVE);
    let (mut right, mut left) = (DMatrix::zeros(n, n), DMatrix::zeros(n, n));
    let mut parts = Vec::with_capacity(n);
    for (at, &(k, size)) in blocks.iter().enumerate() {
        let columns = k * n..(k + size) * n;
        let (x, x_im) = right.as_mut_slice()[columns.clone()].split_at_mut(n);
        let (y, y_im) = left.as_mut_slice()[columns].split_at_mut(n);
        let mut shifted = Shifted { t, lambda: Complex::from(t[(k, k)]), floor };
        if size == 1 {
            parts.push(Part::Whole);
            (x[k], y[k]) = (1.0, 1.0);
        } else {
            parts.extend([Part::Real, Part::Imaginary]);
            // [a b; c a], b c < 0, lambda = a + i w: (b, i w) is a right eigenvector and (c, i w), transposed, a left
            // one; their product is -2 w^2.
            let (b, c) = (t[(k, k + 1)], t[(k + 1, k)]);
            shifted.lambda.im = b.abs().sqrt() * c.abs().sqrt();
            let w = shifted.lambda.im;
            let length = b.hypot(w);
            let scale = -0.5 * (length / w) / w;
            (x[k], x_im[k + 1]) = (b / length, w / length);
            (y[k], y_im[k + 1]) = (c * scale, w * scale);
        }
        shifted.substitute_upwards(x, x_im, (k, size), &blocks[..at]);
        shifted.substitute_downwards(y, y_im, k, &blocks[at + 1..]);
        // From the transposed left vector to the left vector.
        for y in y_im.iter_mut() {
            *y = -*y;
        }
    }
    (Eigenvectors { columns: right, parts: parts.clone() }, Eigenvectors { columns: left, parts })
}

/// `T - lambda I`. The imaginary part of a vector is a separate slice, empty if lambda is real.
struct Shifted<'a> {
    t: &'a DMatrix<f64>,
    lambda: Complex<f64>,
    /// Smallest pivot: an eigenvalue closer than this to another gets the vectors of a nearby matrix.
    floor: f64,
}

impl Shifted<'_> {
    /// Back substitution in `(T - lambda I) x = 0`: from the entries of x in the block `(k, size)`, through the blocks
    /// above.
    fn substitute_upwards(&self, x: &mut [f64], x_im: &mut [f64], (k, size): (usize, usize), above: &[(usize, usize)]) {
        let n = x.len();
        let columns = self.t.as_slice();
        let eliminate = |x: &mut [f64], above: usize, j: usize| {
            if let Some(known) = x.get(j).copied() {
                for (x, t) in x[..above].iter_mut().zip(&columns[j * n..]) {
                    *x -= known * t;
                }
            }
        };
        for j in k..k + size {
            eliminate(x, k, j);
            eliminate(x_im, k, j);
        }
        for &(j, size) in above.iter().rev() {
            self.solve(x, x_im, (j, size), false);
            for i in j..j + size {
                eliminate(x, j, i);
                eliminate(x_im, j, i);
            }
        }
    }

    /// Forward substitution in `y (T - lambda I) = 0`: from the entries of the row y in the block at k, through the
    /// blocks below.
    fn substitute_downwards(&self, y: &mut [f64], y_im: &mut [f64], k: usize, below: &[(usize, usize)]) {
        let n = y.len();
        let columns = self.t.as_slice();
        for &(j, size) in below {
            for y in [&mut *y, &mut *y_im] {
                for i in j..(j + size).min(y.len()) {
                    let known: f64 = y[k..j].iter().zip(&columns[i * n + k..]).map(|(y, t)| y * t).sum();
                    y[i] = -known;
                }
            }
            self.solve(y, y_im, (j, size), true);
        }
    }

    /// Solves with the diagonal block `(j, size)` of `T - lambda I`, or its transpose, for these entries of x, in
    /// place.
    fn solve(&self, x: &mut [f64], x_im: &mut [f64], (j, size): (usize, usize), transposed: bool) {
        let t = self.t;
        let gap = t[(j, j)] - self.lambda.re;
        let apart = |gap: f64| if gap.abs() < self.floor { self.floor } else { gap };
        let apart_complex = |gap: Complex<f64>| if gap.norm() < self.floor { Complex::from(self.floor) } else { gap };
        if size == 1 {
            if x_im.is_empty() {
                x[j] /= apart(gap);
            } else {
                let quotient = Complex::new(x[j], x_im[j]) / apart_complex(Complex::new(gap, -self.lambda.im));
                (x[j], x_im[j]) = (quotient.re, quotient.im);
            }
            return;
        }
        let (mut b, mut c) = (t[(j, j + 1)], t[(j + 1, j)]);
        let w = b.abs().sqrt() * c.abs().sqrt();
        if transposed {
            core::mem::swap(&mut b, &mut c);
        }
        // The determinant is the product of the differences between lambda and the two eigenvalues of the block.
        if x_im.is_empty() {
            let h = apart(gap.hypot(w));
            let (d, b, c) = (gap / h, b / h, c / h);
            (x[j], x[j + 1]) = ((d * x[j] - b * x[j + 1]) / h, (d * x[j + 1] - c * x[j]) / h);
        } else {
            let upper = apart_complex(Complex::new(gap, w - self.lambda.im));
            let lower = apart_complex(Complex::new(gap, -w - self.lambda.im));
            let (first, second) = (Complex::new(x[j], x_im[j]) / upper, Complex::new(x[j + 1], x_im[j + 1]) / upper);
            let d = Complex::new(gap, -self.lambda.im);
            let solved = ((d * first - second * b) / lower, (d * second - first * c) / lower);
            (x[j], x_im[j]) = (solved.0.re, solved.0.im);
            (x[j + 1], x_im[j + 1]) = (solved.1.re, solved.1.im);
        }
    }
}
