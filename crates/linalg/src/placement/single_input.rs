//! Placement with one input, by deflation of the Hessenberg form (Miminis and Paige, Int. J. Control 35, 1982).
//!
//! With `A` upper Hessenberg and `b = beta e1`, feedback reaches the first row only: the rows below decide the eigenvector `x` of
//! `A - b k` for the pole `lambda`, as the null vector of the last n - 1 rows of `A - lambda I`. A unitary `Z` with first column `x`, found as n - 1
//! rotations (the RQ step of the QR algorithm), takes the problem to
//!
//! ```text
//! Z*(A - b k) Z = [lambda      *      ]     k Z = [kappa, k1],    kappa = e1'(A - lambda I) x / beta,
//!                 [  0    A1 - b1 k1  ]     A1 Hessenberg, b1 = beta1 e1
//! ```
//!
//! with one pole less. Nothing is inverted but the `beta`, and no power of `A` is formed, unlike Ackermann's formula. Complex pairs are taken
//! in complex arithmetic; k is unique, and therefore real up to rounding. 20 n^3 flops.

use nalgebra::{Complex, DMatrix, DVector};

use super::poles::Wish;
use crate::staircase::Staircase;

/// The gain (1 x n) and the eigenvectors aimed at, in the order of [`in_sequence`]. Infinite or NaN if the gain does not fit a double.
pub(super) fn assign(a: &DMatrix<f64>, b: &DMatrix<f64>, wish: &Wish) -> (DMatrix<f64>, DMatrix<Complex<f64>>) {
    // Controllability has been decided; here every stair counts.
    let hessenberg = Staircase::new(a, b, 0.0);
    let poles = in_sequence(wish);
    let k = deflate(&hessenberg.f, hessenberg.g[(0, 0)], &poles);
    let gain = DMatrix::from_row_slice(1, k.len(), &k) * hessenberg.q.transpose();
    let mut vectors = DMatrix::zeros(a.nrows(), a.nrows());
    let q = hessenberg.q.map(Complex::from);
    for (j, pole) in poles.iter().enumerate() {
        vectors.set_column(j, &(&q * null_vector(&hessenberg.f, *pole)));
    }
    (gain, vectors)
}

/// Real poles, then the pairs, conjugates next to each other.
fn in_sequence(wish: &Wish) -> Vec<Complex<f64>> {
    let real = wish.real.iter().map(|x| Complex::from(*x));
    real.chain(wish.pairs.iter().flat_map(|p| [*p, p.conj()])).collect()
}

/// A rotation of the coordinates `first, first + 1`: the columns `x, y` become `c x - s y`, `s* x + c* y`.
struct Rotation {
    first: usize,
    c: Complex<f64>,
    s: Complex<f64>,
}

fn deflate(f: &DMatrix<f64>, beta: f64, poles: &[Complex<f64>]) -> Vec<f64> {
    let n = f.nrows();
    let mut h = f.map(Complex::from);
    let mut beta = Complex::from(beta);
    let mut steps: Vec<Vec<Rotation>> = Vec::with_capacity(n);
    let mut kappas = Vec::with_capacity(n);
    // The problem left lives in the rows and columns start..n.
    for (start, pole) in poles.iter().enumerate().take(n) {
        for i in start..n {
            h[(i, i)] -= pole;
        }
        let mut rotations = Vec::with_capacity(n - start);
        for i in (start + 1..n).rev() {
            let (x, y) = (h[(i, i)], h[(i, i - 1)]);
            let length = x.norm().hypot(y.norm());
            let rotation = Rotation { first: i - 1, c: x / length, s: y / length };
            for row in start..=i {
                let (left, right) = (h[(row, i - 1)], h[(row, i)]);
                h[(row, i - 1)] = rotation.c * left - rotation.s * right;
                h[(row, i)] = rotation.s.conj() * left + rotation.c.conj() * right;
            }
            h[(i, i - 1)] = Complex::from(0.0);
            rotations.push(rotation);
        }
        kappas.push(h[(start, start)] / beta);
        for rotation in &rotations {
            let (upper, lower) = (rotation.first, rotation.first + 1);
            for column in start..n {
                let (x, y) = (h[(upper, column)], h[(lower, column)]);
                h[(upper, column)] = rotation.c.conj() * x - rotation.s.conj() * y;
                h[(lower, column)] = rotation.s * x + rotation.c * y;
            }
        }
        if let Some(last) = rotations.last() {
            beta *= last.s;
        }
        for i in start..n {
            h[(i, i)] += pole;
        }
        steps.push(rotations);
    }
    let mut k: DVector<Complex<f64>> = DVector::from_vec(kappas);
    for rotations in steps.iter().rev() {
        // [kappa, k1] Z*, the last rotation first.
        for rotation in rotations.iter().rev() {
            let (x, y) = (k[rotation.first], k[rotation.first + 1]);
            k[rotation.first] = x * rotation.c.conj() + y * rotation.s;
            k[rotation.first + 1] = y * rotation.c - x * rotation.s.conj();
        }
    }
    k.iter().map(|x| x.re).collect()
}

/// The unit vector annihilated by the last n - 1 rows of `H - lambda I`.
fn null_vector(h: &DMatrix<f64>, lambda: Complex<f64>) -> DVector<Complex<f64>> {
    /// Far from overflow after one more step of any reasonable size.
    const LARGE: f64 = 1e100;
    let n = h.nrows();
    let mut x = DVector::from_element(n, Complex::from(0.0));
    x[n - 1] = Complex::from(1.0);
    for i in (1..n).rev() {
        let sum: Complex<f64> = (i..n).map(|j| x[j] * h[(i, j)]).sum();
        x[i - 1] = (lambda * x[i] - sum) / h[(i, i - 1)];
        let size = x[i - 1].norm();
        if size > LARGE {
            x.unscale_mut(size);
        }
    }
    x.unscale_mut(x.norm());
    x
}
