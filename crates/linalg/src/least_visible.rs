//! The direction that `[T - lambda I; C]` shortens most: its right singular vector at the smallest singular value, T
//! quasi upper triangular.
//!
//! The rows of C and the subdiagonal of T are rotated into the triangle R, which costs `p n^2` instead of `n^3`.
//! Inverse iteration with `R* R` then converges like the squared ratio of the two smallest singular values. Where these
//! are near each other (a long chain of states seen at its ends), Lanczos' method on the inverse supplies a better
//! vector: its error falls with the square root of the gap (Parlett, The Symmetric Eigenvalue Problem, section 12.4).

use nalgebra::{Complex, ComplexField, DMatrix, DVector, SymmetricEigen};

use crate::{LinalgError, Result};

/// Most steps of the inverse iteration. With the vectors of Lanczos' method in between, two singular values that are
/// not separated by then are so close that either vector serves.
const STEPS: usize = 300;

/// Steps of the inverse iteration before each of Lanczos' method.
const PATIENCE: usize = 8;

/// Dimension of the Krylov space.
const KRYLOV: usize = 24;

/// The direction, of length 1; real for a real `lambda`.
///
/// # Errors
/// [`LinalgError::Overflow`].
pub fn least_visible(t: &DMatrix<f64>, c: &DMatrix<f64>, lambda: Complex<f64>) -> Result<DVector<Complex<f64>>> {
    let v = if lambda.im == 0.0 {
        direction(t, c, lambda.re).map(|v| v.map(Complex::from))
    } else {
        direction(t, c, lambda)
    };
    v.ok_or(LinalgError::Overflow { what: "the direction of a mode" })
}

/// A real or complex number.
trait Scalar: ComplexField<RealField = f64> + Copy {}
impl<T: ComplexField<RealField = f64> + Copy> Scalar for T {}

/// The direction; none if it overflows.
fn direction<T: Scalar>(t: &DMatrix<f64>, c: &DMatrix<f64>, lambda: T) -> Option<DVector<T>> {
    let triangle = Triangle::new(t, c, lambda);
    // Real for real lambda, and without preference for any coordinate.
    let start = |j: usize| T::from_real(1.0 + 0.5 * ((j as f64 + 1.0) * 2.399_963).cos());
    let mut v: Vec<T> = (0..t.nrows()).map(start).collect();
    let length = norm(&v);
    scale(&mut v, 1.0 / length);
    let mut sigma = f64::INFINITY;
    for step in 1..=STEPS {
        if !triangle.invert(&mut v) {
            break;
        }
        let next = triangle.size_of_product(&v);
        if sigma.is_finite() && sigma - next <= 1e-12 * sigma {
            break;
        }
        sigma = next;
        if step % PATIENCE == 0
            && let Some(better) = triangle.lanczos(&v, sigma)
        {
            v = better;
        }
    }
    v.iter().all(ComplexField::is_finite).then(|| DVector::from_vec(v))
}

/// An upper triangular matrix.
struct Triangle<T> {
    n: usize,
    /// Row after row, each with its n entries.
    rows: Vec<T>,
}

impl<T: Scalar> Triangle<T> {
    /// R of `[T - lambda I; C] = Q R`.
    fn new(t: &DMatrix<f64>, c: &DMatrix<f64>, lambda: T) -> Self {
        let n = t.nrows();
        let mut rows: Vec<T> = Vec::with_capacity(n * n);
        for i in 0..n {
            rows.extend(t.row(i).iter().map(|x| T::from_real(*x)));
            rows[i * n + i] -= lambda;
        }
        let size = norm(&rows).hypot(c.norm());
        let mut triangle = Self { n, rows };
        for j in 1..n {
            if triangle.rows[j * n + j - 1] != T::zero() {
                let mut below = triangle.rows[j * n..(j + 1) * n].to_vec();
                triangle.rotate_away(j - 1, &mut below);
                triangle.rows[j * n..(j + 1) * n].copy_from_slice(&below);
            }
        }
        for output in c.row_iter() {
            let mut row: Vec<T> = output.iter().map(|x| T::from_real(*x)).collect();
            for j in 0..n {
                triangle.rotate_away(j, &mut row);
            }
        }
        // A zero on the diagonal is replaced by what rounding would have put there.
        let floor = (f64::EPSILON * size).max(f64::MIN_POSITIVE) * f64::EPSILON;
        for j in 0..n {
            if triangle.rows[j * n + j].modulus() < floor {
                triangle.rows[j * n + j] = T::from_real(floor);
            }
        }
        triangle
    }

    /// Row j from its diagonal on.
    fn row(&self, j: usize) -> &[T] {
        &self.rows[j * self.n + j..(j + 1) * self.n]
    }

    /// Rotates row j of the triangle with `row` so that `row[j]` vanishes.
    fn rotate_away(&mut self, j: usize, row: &mut [T]) {
        let upper = &mut self.rows[j * self.n + j..(j + 1) * self.n];
        let lower = &mut row[j..];
        let (x, y) = (upper[0], lower[0]);
        let length = x.modulus().hypot(y.modulus());
        if y.modulus() == 0.0 || length == 0.0 {
            return;
        }
        let (c, s) = (x.unscale(length), y.unscale(length));
        let (c_bar, s_bar) = (c.conjugate(), s.conjugate());
        for (upper, lower) in upper.iter_mut().zip(lower.iter_mut()) {
            let (x, y) = (*upper, *lower);
            *upper = c_bar * x + s_bar * y;
            *lower = c * y - s * x;
        }
        lower[0] = T::zero();
    }

    /// `|R v|`.
    fn size_of_product(&self, v: &[T]) -> f64 {
        let entry = |j: usize| dot(self.row(j), &v[j..]).modulus();
        (0..self.n).map(entry).fold(0.0, f64::hypot)
    }

    /// `v = R^-* v`.
    fn solve_adjoint(&self, v: &mut [T]) {
        for j in 0..self.n {
            let row = self.row(j);
            v[j] /= row[0].conjugate();
            let x = v[j];
            for (v, r) in v[j + 1..].iter_mut().zip(&row[1..]) {
                *v -= r.conjugate() * x;
            }
        }
    }

    /// `v = R^-1 v`.
    fn solve(&self, v: &mut [T]) {
        for j in (0..self.n).rev() {
            let row = self.row(j);
            v[j] = (v[j] - dot(&row[1..], &v[j + 1..])) / row[0];
        }
    }

    /// `v = (R* R)^-1 v`, of length 1 in between and after; false, with v as it was, if it overflows.
    fn invert(&self, v: &mut Vec<T>) -> bool {
        let mut x = v.clone();
        self.solve_adjoint(&mut x);
        if !normalise(&mut x) {
            return false;
        }
        self.solve(&mut x);
        if !normalise(&mut x) {
            return false;
        }
        *v = x;
        true
    }

    /// The vector of the largest Ritz value of `sigma^2 (R* R)^-1` in the Krylov space of `start`; none if it
    /// overflows. With sigma near the smallest singular value the Ritz value is near 1.
    fn lanczos(&self, start: &[T], sigma: f64) -> Option<Vec<T>> {
        let mut basis = vec![start.to_vec()];
        let (mut diagonal, mut beside) = (Vec::new(), Vec::new());
        while let Some(last) = basis.last() {
            let mut w = last.clone();
            self.solve_adjoint(&mut w);
            scale(&mut w, sigma);
            self.solve(&mut w);
            scale(&mut w, sigma);
            diagonal.push(dot_conjugate(last, &w).real());
            // Against all vectors, twice: the three-term recurrence loses orthogonality as soon as it converges.
            for _ in 0..2 {
                for q in &basis {
                    let share = dot_conjugate(q, &w);
                    w.iter_mut().zip(q).for_each(|(w, q)| *w -= share * *q);
                }
            }
            let length = norm(&w);
            if !length.is_finite() {
                return None;
            }
            if basis.len() == KRYLOV.min(self.n) || length <= 1e-14 {
                break;
            }
            scale(&mut w, 1.0 / length);
            beside.push(length);
            basis.push(w);
        }
        let k = diagonal.len();
        let projected = DMatrix::from_fn(k, k, |i, j| match i.abs_diff(j) {
            0 => diagonal[i],
            1 => beside[i.min(j)],
            _ => 0.0,
        });
        if projected.iter().any(|x: &f64| !x.is_finite()) {
            return None;
        }
        let ritz = SymmetricEigen::new(projected);
        let vector = ritz.eigenvectors.column(ritz.eigenvalues.imax());
        let mut v = vec![T::zero(); self.n];
        for (q, share) in basis.iter().zip(vector.iter()) {
            v.iter_mut().zip(q).for_each(|(v, q)| *v += q.scale(*share));
        }
        normalise(&mut v).then_some(v)
    }
}

fn dot<T: Scalar>(x: &[T], y: &[T]) -> T {
    x.iter().zip(y).fold(T::zero(), |sum, (x, y)| sum + *x * *y)
}

fn dot_conjugate<T: Scalar>(x: &[T], y: &[T]) -> T {
    x.iter().zip(y).fold(T::zero(), |sum, (x, y)| sum + x.conjugate() * *y)
}

/// The Euclidean norm, relative to the largest entry, so that no square overflows.
fn norm<T: Scalar>(x: &[T]) -> f64 {
    let largest = x.iter().map(|x| x.norm1()).fold(0.0, f64::max);
    if largest == 0.0 || !largest.is_finite() {
        return largest;
    }
    largest * x.iter().map(|x| x.unscale(largest).modulus_squared()).sum::<f64>().sqrt()
}

fn scale<T: Scalar>(x: &mut [T], factor: f64) {
    for x in x {
        *x = x.scale(factor);
    }
}

/// A reciprocal in place of the division would overflow for the smallest numbers.
fn divide<T: Scalar>(x: &mut [T], by: f64) {
    for x in x {
        *x = x.unscale(by);
    }
}

/// The same direction with length 1; false if it has none.
fn normalise<T: Scalar>(x: &mut [T]) -> bool {
    let largest = x.iter().map(|x| x.norm1()).fold(0.0, f64::max);
    if !(largest > 0.0 && largest.is_finite() && x.iter().all(ComplexField::is_finite)) {
        return false;
    }
    divide(x, largest);
    let length = norm(x);
    divide(x, length);
    true
}
