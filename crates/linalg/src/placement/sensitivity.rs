//! How far the eigenvalues of a closed loop move when the loop changes: their condition numbers, one by one.
//!
//! A change E of the matrix moves the simple eigenvalue lambda by `y*E x / y*x` to first order, `x, y` its right and left eigenvectors: by `|x| |y| / |y*x|` times `|E|` at most (Wilkinson, The Algebraic Eigenvalue
//! Problem, 2.8). It is infinite for a defective eigenvalue, which moves like a root of `|E|`; in floating point, very large.

use nalgebra::{Complex, DMatrix};

use crate::schur::{Schur, blocks};
use crate::units::shift;

/// Eigenvalues with right and left eigenvectors, scaled so that `y*x = 1` in exact arithmetic.
pub(super) struct Eigen {
    /// In the order of [`Schur::eigenvalues`].
    pub(super) values: Vec<Complex<f64>>,
    /// Columns x.
    pub(super) right: DMatrix<Complex<f64>>,
    /// Columns y.
    pub(super) left: DMatrix<Complex<f64>>,
}

impl Eigen {
    /// From `Q T Q'`, by substitution in the complex triangle that T is similar to; `6 n^3` flops.
    pub(super) fn of(form: &Schur) -> Self {
        let n = form.t.nrows();
        let (r, z) = triangular(form);
        let floor = (f64::EPSILON * form.t.norm()).max(f64::MIN_POSITIVE);
        // Of an eigenvalue that meets another, the vectors are those of a neighbouring matrix.
        let gap = |i: usize, k: usize| {
            let gap = r[(i, i)] - r[(k, k)];
            if gap.norm() < floor { Complex::from(floor) } else { gap }
        };
        let (mut right, mut left) = (DMatrix::identity(n, n), DMatrix::identity(n, n));
        for k in 0..n {
            for i in (0..k).rev() {
                let sum: Complex<f64> = (i + 1..=k).map(|j| r[(i, j)] * right[(j, k)]).sum();
                right[(i, k)] = -sum / gap(i, k);
            }
            // The conjugate of the left vector: y*(R - lambda I) = 0.
            for i in k + 1..n {
                let sum: Complex<f64> = (k..i).map(|j| r[(j, i)] * left[(j, k)]).sum();
                left[(i, k)] = -sum / gap(i, k);
            }
        }
        Self { values: form.eigenvalues(), right: &z * right, left: z * left.map(|y: Complex<f64>| y.conj()) }
    }
}

/// The condition of each eigenvalue of `Q T Q'`, in the order of [`Schur::eigenvalues`], for vectors in units `x_given = 2^-powers x`.
pub(super) fn conditions(form: &Schur, powers: &[i32]) -> Vec<f64> {
    let n = form.t.nrows();
    let eigen = Eigen::of(form);
    let given = |v: &DMatrix<Complex<f64>>, k: usize, sign: i32| {
        let size = |i: usize| shift(v[(i, k)].norm(), sign * powers[i]);
        // Scaled, so that squares neither overflow nor vanish.
        let largest = (0..n).map(size).fold(0.0, f64::max);
        if largest == 0.0 || !largest.is_finite() {
            return largest;
        }
        largest * (0..n).map(|i| (size(i) / largest).powi(2)).sum::<f64>().sqrt()
    };
    (0..n)
        .map(|k| given(&eigen.right, k, -1) * given(&eigen.left, k, 1))
        .map(|condition| if condition.is_nan() { f64::INFINITY } else { condition })
        .collect()
}

/// `A = Z R Z*` with R complex triangular: each 2 x 2 block is turned by its eigenvector.
fn triangular(form: &Schur) -> (DMatrix<Complex<f64>>, DMatrix<Complex<f64>>) {
    let n = form.t.nrows();
    let (mut r, mut z) = (form.t.map(Complex::from), form.q.map(Complex::from));
    for (k, _) in blocks(&form.t).into_iter().filter(|block| block.1 == 2) {
        // [a b; c a], b c < 0: (b, lambda - a) is the eigenvector of a + i sqrt(-b c).
        let (b, c) = (form.t[(k, k + 1)], form.t[(k + 1, k)]);
        let im = b.abs().sqrt() * c.abs().sqrt();
        let length = b.hypot(im);
        let (p, q) = (Complex::from(b / length), Complex::new(0.0, im / length));
        for i in 0..n {
            for m in [&mut r, &mut z] {
                let (x, y) = (m[(i, k)], m[(i, k + 1)]);
                m[(i, k)] = x * p + y * q;
                m[(i, k + 1)] = y * p.conj() - x * q.conj();
            }
        }
        for j in 0..n {
            let (x, y) = (r[(k, j)], r[(k + 1, j)]);
            r[(k, j)] = p.conj() * x + q.conj() * y;
            r[(k + 1, j)] = p * y - q * x;
        }
        r[(k + 1, k)] = Complex::from(0.0);
    }
    (r, z)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::schur::schur;

    /// The eigenvectors of a generic matrix with real and complex eigenvalues, by the inverse of a complex matrix of eigenvectors made by hand.
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
        // Columns 2, 3 hold the real and the imaginary part of the pair's vector u + i v; its left one is (rows 2 - i row 3) / 2.
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

    #[test]
    fn a_defective_eigenvalue_has_no_condition() {
        let form = schur(&DMatrix::from_row_slice(2, 2, &[1.0, 1.0, 0.0, 1.0])).unwrap();
        assert!(conditions(&form, &[0, 0]).iter().all(|x| *x > 1e15));
    }
}
