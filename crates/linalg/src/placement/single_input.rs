//! Placement with one input, by deflation of the Hessenberg form (Miminis and Paige, Int. J. Control 35, 1982).
//!
//! With `A` upper Hessenberg and `b = beta e1`, feedback changes the first row only. The other rows determine the
//! eigenvector `x` of `A - b k` for the pole `lambda`: the null vector of the last n - 1 rows of `A - lambda I`. A
//! unitary `Z` with first column `x`, a product of n - 1 rotations (the RQ step of the QR algorithm), gives
//!
//! ```text
//! Z*(A - b k) Z = [lambda      *      ]     k Z = [kappa, k1],    kappa = e1'(A - lambda I) x / beta,
//!                 [  0    A1 - b1 k1  ]     A1 Hessenberg, b1 = beta1 e1
//! ```
//!
//! with one pole less. The only divisions are by the `beta`, and no power of `A` is formed, unlike in Ackermann's
//! formula. Real poles are placed first, in real arithmetic, then the pairs in complex arithmetic; k is unique and
//! therefore real up to rounding. `2 n^3` flops if all poles are real, ten times as many if none is.

use nalgebra::{Complex, ComplexField, DMatrix, DVector};

use super::eigenvectors::Eigenvectors;
use super::poles::RequestedPoles;
use crate::staircase::Staircase;

/// Gain (1 x n) for the pair with the staircase form `hessenberg`, all stairs nonzero, and the closed-loop
/// eigenvectors: those of the real poles, then the pairs. Entries are infinite or NaN if the gain overflows.
pub(super) fn assign(hessenberg: &Staircase, requested: &RequestedPoles) -> (DMatrix<f64>, Eigenvectors) {
    let k = deflate(&hessenberg.f, hessenberg.g[(0, 0)], requested);
    let gain = DMatrix::from_row_slice(1, k.len(), (&hessenberg.q * &k).as_slice());
    let columns = &hessenberg.q * null_vectors(&hessenberg.f, requested);
    (gain, Eigenvectors::reals_first(columns, requested.real.len()))
}

/// Rotation of the coordinates `first, first + 1`: the columns `x, y` become `c x - s y`, `s* x + c* y`.
struct Rotation<T> {
    first: usize,
    c: T,
    s: T,
}

fn deflate(f: &DMatrix<f64>, beta: f64, requested: &RequestedPoles) -> DVector<f64> {
    let mut deflated = Deflated { h: f.clone(), start: 0, beta };
    let real: Vec<_> = requested.real.iter().map(|pole| deflated.deflate(*pole)).collect();
    let mut k = DVector::zeros(f.nrows());
    if !requested.pairs.is_empty() {
        let mut deflated =
            Deflated { h: deflated.h.map(Complex::from), start: deflated.start, beta: Complex::from(deflated.beta) };
        let pairs: Vec<_> =
            requested.pairs.iter().flat_map(|pole| [*pole, pole.conj()]).map(|p| deflated.deflate(p)).collect();
        k = restored(k.map(Complex::from), real.len(), &pairs).map(|x| x.re);
    }
    restored(k, 0, &real)
}

/// `[kappa, k1] Z*` for the deflation steps in reverse order; the first step removed the pole number `start`.
fn restored<T: ComplexField>(mut k: DVector<T>, start: usize, steps: &[(T, Vec<Rotation<T>>)]) -> DVector<T> {
    for (at, (kappa, rotations)) in steps.iter().enumerate().rev() {
        k[start + at] = kappa.clone();
        for Rotation { first, c, s } in rotations.iter().rev() {
            let (x, y) = (k[*first].clone(), k[first + 1].clone());
            k[*first] = x.clone() * c.clone().conjugate() + y.clone() * s.clone();
            k[first + 1] = y * c.clone() - x * s.clone().conjugate();
        }
    }
    k
}

/// Problem that remains after `start` poles, stored in the rows and columns from `start` on.
struct Deflated<T> {
    h: DMatrix<T>,
    start: usize,
    beta: T,
}

impl<T: ComplexField<RealField = f64> + Copy> Deflated<T> {
    /// One deflation step: returns `kappa`, and Z as rotations.
    fn deflate(&mut self, pole: T) -> (T, Vec<Rotation<T>>) {
        let Self { h, start, beta } = self;
        let (n, start) = (h.nrows(), *start);
        for i in start..n {
            h[(i, i)] -= pole;
        }
        let columns = h.as_mut_slice();
        let mut rotations: Vec<Rotation<T>> = Vec::with_capacity(n - start);
        for i in (start + 1..n).rev() {
            let (left, right) = columns[(i - 1) * n..(i + 1) * n].split_at_mut(n);
            let length = hypot(left[i], right[i]);
            let (c, s) = (right[i].unscale(length), left[i].unscale(length));
            let (c_conj, s_conj) = (c.conjugate(), s.conjugate());
            for (x, y) in left[start..i].iter_mut().zip(&mut right[start..i]) {
                (*x, *y) = (c * *x - s * *y, s_conj * *x + c_conj * *y);
            }
            (left[i], right[i]) = (T::zero(), s_conj * left[i] + c_conj * right[i]);
            rotations.push(Rotation { first: i - 1, c, s });
        }
        let kappa = columns[start * n + start] / *beta;
        // RQ product: the rotations, applied to the rows, bottom first, make the triangular factor Hessenberg again.
        let mut column = start;
        while column < n {
            let width = if column + WIDTH <= n { WIDTH } else { 1 };
            let of_these = &rotations[n - 1 - (column + width).min(n - 1)..];
            let entries = &mut columns[column * n..(column + width) * n];
            if width == WIDTH {
                turn_rows::<T, WIDTH>(entries, n, of_these);
            } else {
                turn_rows::<T, 1>(entries, n, of_these);
            }
            column += width;
        }
        if let Some(last) = rotations.last() {
            *beta *= last.s;
        }
        for i in start..n {
            columns[i * n + i] += pole;
        }
        self.start += 1;
        (kappa, rotations)
    }
}

/// Columns rotated at a time: rotations of the same column depend on each other, those of different columns do not.
const WIDTH: usize = 4;

/// Applies rotations of neighbouring rows, from the bottom up, to W columns of n entries.
fn turn_rows<T: ComplexField + Copy, const W: usize>(columns: &mut [T], n: usize, rotations: &[Rotation<T>]) {
    let Some(first) = rotations.first().map(|r| r.first) else { return };
    let last = first + 1 - rotations.len();
    // Lower of the two rows, after the previous rotation.
    let mut lower: [T; W] = core::array::from_fn(|w| columns[w * n + first + 1]);
    for Rotation { first, c, s } in rotations {
        let (c_conj, s_conj) = (c.conjugate(), s.conjugate());
        for (w, y) in lower.iter_mut().enumerate() {
            let at = w * n + first;
            let x = columns[at];
            columns[at + 1] = *s * x + *c * *y;
            *y = c_conj * x - s_conj * *y;
        }
    }
    for (w, y) in lower.into_iter().enumerate() {
        columns[w * n + last] = y;
    }
}

/// `sqrt(|x|^2 + |y|^2)`, safe where squares overflow or underflow.
fn hypot<T: ComplexField<RealField = f64>>(x: T, y: T) -> f64 {
    let squares = x.clone().modulus_squared() + y.clone().modulus_squared();
    if (1e-280..1e280).contains(&squares) { squares.sqrt() } else { x.modulus().hypot(y.modulus()) }
}

/// For each pole the null vector of the last n - 1 rows of `H - lambda I`, as columns for
/// [`Eigenvectors::reals_first`]; not normalised.
fn null_vectors(h: &DMatrix<f64>, requested: &RequestedPoles) -> DMatrix<f64> {
    /// Rescaling threshold: one further step cannot overflow.
    const LARGE: f64 = 1e50;
    let (n, reals) = (h.nrows(), requested.real.len());
    // Column i of `x` holds entry i of all vectors; `sums` holds the partial sums of the rows above.
    let (mut x, mut sums) = (DMatrix::zeros(n, n), DMatrix::<f64>::zeros(n, n));
    let mut first = x.column_mut(n - 1);
    first.rows_mut(0, reals).fill(1.0);
    first.rows_mut(reals, n - reals).iter_mut().step_by(2).for_each(|x| *x = 1.0);
    for i in (1..n).rev() {
        let column = &h.as_slice()[i * n..(i + 1) * n];
        let (next, known) = x.as_mut_slice()[(i - 1) * n..(i + 1) * n].split_at_mut(n);
        for (sums, entry) in sums.as_mut_slice().chunks_exact_mut(n).zip(&column[..=i]).skip(1) {
            for (sum, known) in sums.iter_mut().zip(&*known) {
                *sum += entry * known;
            }
        }
        let sums_here = &sums.as_slice()[i * n..(i + 1) * n];
        let below = h[(i, i - 1)];
        for (p, lambda) in requested.real.iter().enumerate() {
            next[p] = (lambda * known[p] - sums_here[p]) / below;
        }
        for (p, lambda) in requested.pairs.iter().enumerate() {
            let (re, im) = (reals + 2 * p, reals + 2 * p + 1);
            next[re] = (lambda.re * known[re] - lambda.im * known[im] - sums_here[re]) / below;
            next[im] = (lambda.re * known[im] + lambda.im * known[re] - sums_here[im]) / below;
        }
        for p in (0..n).filter(|p| *p < reals || (p - reals).is_multiple_of(2)) {
            let width = if p < reals { 1 } else { 2 };
            let size = x.column(i - 1).rows(p, width).amax();
            if size > LARGE {
                x.rows_mut(p, width).unscale_mut(size);
                sums.rows_mut(p, width).unscale_mut(size);
            }
        }
    }
    x.transpose()
}
