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
pub(super) struct Eigen {
    /// Eigenvalues, in the order of [`Schur::eigenvalues`].
    pub(super) values: Vec<Complex<f64>>,
    /// Right eigenvectors x.
    pub(super) right: Eigenvectors,
    /// Left eigenvectors y.
    pub(super) left: Eigenvectors,
}

impl Eigen {
    /// Eigenvalues and eigenvectors of `Q T Q'`.
    pub(super) fn of(form: &Schur) -> Self {
        let (mut right, mut left) = in_schur_coordinates(&form.t);
        right.columns = &form.q * right.columns;
        left.columns = &form.q * left.columns;
        Self { values: form.eigenvalues(), right, left }
    }
}

/// Condition number of each eigenvalue of `Q T Q'`, in the order of [`Schur::eigenvalues`], for vectors in the units
/// `x_given = 2^-powers x`. If all powers are zero, Q is not used.
pub(super) fn conditions(form: &Schur, powers: &[i32]) -> Vec<f64> {
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
        let apart_complex = |gap: Complex<f64>| {
            let near = gap.re.abs() < self.floor && gap.im.abs() < self.floor;
            if near && gap.norm() < self.floor { Complex::from(self.floor) } else { gap }
        };
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::schur::schur;

    /// Generic matrix with real and complex eigenvalues, against the inverse of a known complex matrix of eigenvectors.
    #[test]
    fn conditions_are_those_of_known_eigenvectors() {
        let x = DMatrix::from_row_slice(
            4,
            4,
            &[1.0, 0.2, 0.5, -0.3, 0.0, 1.0, 0.4, 0.9, 0.3, -0.6, 1.0, 0.1, 0.8, 0.2, 0.0, 1.0],
        );
        let mut lambda = DMatrix::zeros(4, 4);
        (lambda[(0, 0)], lambda[(1, 1)]) = (-1.0, 3.0);
        (lambda[(2, 2)], lambda[(2, 3)], lambda[(3, 2)], lambda[(3, 3)]) = (0.5, 2.0, -2.0, 0.5);
        let inverse = x.clone().try_inverse().unwrap();
        let form = schur(&(&x * lambda * &inverse)).unwrap();
        // Columns 2 and 3 hold the real and imaginary part of the pair's vector u + i v; its left vector is (row 2 - i
        // row 3) / 2.
        let real = |j: usize| x.column(j).norm() * inverse.row(j).norm();
        let pair =
            x.column(2).norm().hypot(x.column(3).norm()) * inverse.row(2).norm().hypot(inverse.row(3).norm()) / 2.0;
        for (value, found) in form.eigenvalues().iter().zip(conditions(&form, &[0; 4])) {
            let expected = if value.im != 0.0 {
                pair
            } else if value.re < 0.0 {
                real(0)
            } else {
                real(1)
            };
            assert!((found - expected).abs() < 1e-12 * expected, "{value}: {found} for {expected}");
        }
    }

    /// Real eigenvalues and pairs in any order along the diagonal: `A x = lambda x`, `y*A = lambda y*`, `Y*X = I`, and
    /// the condition numbers in other units computed from these vectors.
    #[test]
    fn vectors_of_both_sides_are_eigenvectors() {
        let n = 9;
        let a = DMatrix::from_fn(n, n, |i, j| ((5 * i * i + 3 * j + 1) as f64).sin() + f64::from(u8::from(i == j + 1)));
        let form = schur(&a).unwrap();
        let eigen = Eigen::of(&form);
        let pairs = eigen.right.parts.iter().filter(|part| **part == Part::Real).count();
        assert!(pairs >= 2 && 2 * pairs < n, "real eigenvalues and pairs: {:?}", eigen.values);
        let complex = |v: &Eigenvectors| DMatrix::from_fn(n, n, |i, k| v.entry(i, k));
        let (x, y) = (complex(&eigen.right), complex(&eigen.left));
        let lambda = DMatrix::from_diagonal(&nalgebra::DVector::from_vec(eigen.values.clone()));
        let (plain, a) = (a.clone(), a.map(Complex::from));
        let bound = 20.0 * n as f64 * f64::EPSILON * a.norm();
        assert!((&a * &x - &x * &lambda).norm() < bound * x.norm());
        assert!((y.adjoint() * &a - &lambda * y.adjoint()).norm() < bound * y.norm());
        assert!((y.adjoint() * &x - DMatrix::identity(n, n)).norm() < 1e-14 * x.norm() * y.norm());

        // In the units given, T alone suffices.
        let alone = crate::schur::triangular_factor(&plain).unwrap();
        assert!(alone.q.is_empty() && alone.t == form.t);
        assert_eq!(conditions(&alone, &[0; 9]), conditions(&form, &[0; 9]));

        let powers = [3, -7, 0, 12, 5, -20, 1, 1, -4];
        let unit = |i: usize| 2f64.powi(powers[i]);
        for (k, found) in conditions(&form, &powers).into_iter().enumerate() {
            let x = (0..n).map(|i| (x[(i, k)] / unit(i)).norm_sqr()).sum::<f64>().sqrt();
            let y = (0..n).map(|i| (y[(i, k)] * unit(i)).norm_sqr()).sum::<f64>().sqrt();
            assert!((found - x * y).abs() < 1e-12 * found, "{k}: {found} for {}", x * y);
        }
    }

    #[test]
    fn a_defective_eigenvalue_has_no_condition() {
        let form = schur(&DMatrix::from_row_slice(2, 2, &[1.0, 1.0, 0.0, 1.0])).unwrap();
        assert!(conditions(&form, &[0, 0]).iter().all(|x| *x > 1e15));
        // Two equal, coupled pairs.
        let pairs = [0.0, 2.0, 1.0, 0.5, -2.0, 0.0, 0.3, 1.0, 0.0, 0.0, 0.0, 2.0, 0.0, 0.0, -2.0, 0.0];
        let form = Schur { q: DMatrix::identity(4, 4), t: DMatrix::from_row_slice(4, 4, &pairs) };
        assert!(conditions(&form, &[0; 4]).iter().all(|x| *x > 1e14));
    }
}
