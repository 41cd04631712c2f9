//! Placement with several inputs: eigenvectors of the largest volume (Tits and Yang, IEEE TAC 41, 1996; from method 0
//! of Kautsky, Nichols and Van Dooren, Int. J. Control 41, 1985).
//!
//! With `B = U1 Z`, `[U1 U0]` orthogonal, `x` can be an eigenvector for `lambda` iff `U0'(A - lambda I) x = 0`: a
//! subspace of dimension rank(B), with basis `S`. Unit vectors from these subspaces are chosen to make `|det X|` large,
//! two at a time with the others fixed, each choice being optimal. With `w1, w2` an orthonormal basis of the orthogonal
//! complement of the others:
//!
//! ```text
//! two real poles     maximise | z1' S1'(w1 w2' - w2 w1') S2 z2 |        the largest singular vectors
//! a complex pair     maximise | Im( (w1'S z) conj(w2'S z) ) |           an eigenvector of a hermitian matrix of rank 2
//! one real pole      maximise | w1'S z |                                a projection
//! ```
//! `|det X| <= 1` never decreases, so the sweeps converge; their number is bounded, and the starting points are fixed.
//! Then `K = U1'(A - X Lambda X^-1)`.

use faer::Mat;
use luenberger_random::Random;
use nalgebra::{Complex, DMatrix, DVector};

use super::eigenvectors::Eigenvectors;
use super::poles::RequestedPoles;
use crate::{LinalgError, Result};

/// Maximum number of sweeps over all poles; most of the volume is gained in the first few.
const SWEEPS: usize = 40;
/// A sweep that gains less than this in `log |det X|` is the last: the condition no longer moves in its third digit.
const SETTLED: f64 = 1e-4;
/// Number of starting points; the best-conditioned result is kept.
const STARTS: u64 = 4;
/// Maximum number of starting points if the first ones all give a singular X.
const MOST_STARTS: u64 = 20;

/// Gain (rank x n) of `A - U1 K`, and its eigenvectors: those of the real poles, then the pairs.
pub(super) fn assign(
    a: &DMatrix<f64>,
    inputs: &DMatrix<f64>,
    others: &DMatrix<f64>,
    requested: &RequestedPoles,
) -> Result<(DMatrix<f64>, Eigenvectors)> {
    let n = a.nrows();
    // If rank(B) = n every vector is admissible: X = I, and e1 + i e2 for pairs.
    let x = if others.ncols() == 0 { DMatrix::identity(n, n) } else { best_eigenvectors(a, others, requested)? };
    let mut x_lambda = x.clone();
    for (j, lambda) in requested.real.iter().enumerate() {
        x_lambda.column_mut(j).scale_mut(*lambda);
    }
    for (pair, lambda) in requested.pairs.iter().enumerate() {
        // A (u + i v) = lambda (u + i v).
        let j = requested.real.len() + 2 * pair;
        let (u, v) = (x.column(j).into_owned(), x.column(j + 1).into_owned());
        x_lambda.set_column(j, &(&u * lambda.re - &v * lambda.im));
        x_lambda.set_column(j + 1, &(&u * lambda.im + &v * lambda.re));
    }
    let closed = x
        .transpose()
        .lu()
        .solve(&x_lambda.transpose())
        .ok_or(LinalgError::Overflow { what: "the inverse of the eigenvectors" })?
        .transpose();
    Ok((inputs.transpose() * (a - closed), Eigenvectors::reals_first(x, requested.real.len())))
}

/// The eigenvectors in real columns: `x` of a real pole, `Re x, Im x` of a pair.
fn best_eigenvectors(a: &DMatrix<f64>, others: &DMatrix<f64>, requested: &RequestedPoles) -> Result<DMatrix<f64>> {
    let real: Vec<DMatrix<f64>> =
        requested.real.iter().map(|p| admissible(a, others, Complex::from(*p)).map(|x| x.re)).collect();
    let complex: Vec<DMatrix<Complex<f64>>> = requested.pairs.iter().map(|p| admissible(a, others, *p)).collect();
    let mut best: Option<(f64, Ascent)> = None;
    for seed in 0..MOST_STARTS {
        if seed >= STARTS && best.is_some() {
            break;
        }
        let Some(mut ascent) = Ascent::start(&real, &complex, seed) else { continue };
        ascent.run();
        // With unit columns `|X^-1|` is the Frobenius cond(X) up to a constant factor.
        let size = ascent.y.norm();
        if size.is_finite() && best.as_ref().is_none_or(|(least, _)| size < *least) {
            best = Some((size, ascent));
        }
    }
    let (_, ascent) = best.ok_or(LinalgError::Overflow { what: "the inverse of the eigenvectors" })?;
    Ok(ascent.x)
}

/// Orthonormal basis of the null space of `U0'(A - lambda I)`, n x rank(B), from a QR decomposition of its adjoint.
fn admissible(a: &DMatrix<f64>, others: &DMatrix<f64>, lambda: Complex<f64>) -> DMatrix<Complex<f64>> {
    let (n, k) = others.shape();
    let real_part = a.transpose() * others;
    let adjoint = Mat::from_fn(n, k, |i, j| Complex::from(real_part[(i, j)]) - lambda.conj() * others[(i, j)]);
    let q = adjoint.qr().compute_Q();
    DMatrix::from_fn(n, n - k, |i, j| q[(i, k + j)])
}

/// Eigenvectors during the ascent of `|det X|`.
struct Ascent<'a> {
    real: &'a [DMatrix<f64>],
    complex: &'a [DMatrix<Complex<f64>>],
    x: DMatrix<f64>,
    /// `X^-T`: its columns are orthogonal to all other columns of X.
    y: DMatrix<f64>,
    log_volume: f64,
}

impl<'a> Ascent<'a> {
    /// Start from fixed, generic coordinates in each subspace; `None` if X is singular.
    fn start(real: &'a [DMatrix<f64>], complex: &'a [DMatrix<Complex<f64>>], seed: u64) -> Option<Self> {
        let n = real.len() + 2 * complex.len();
        let mut numbers = Random(seed << 32);
        let mut x = DMatrix::zeros(n, n);
        for (j, s) in real.iter().enumerate() {
            let z = DVector::from_fn(s.ncols(), |_, _| numbers.unit());
            let v = s * z;
            x.set_column(j, &(&v / v.norm()));
        }
        for (pair, s) in complex.iter().enumerate() {
            let z = DVector::from_fn(s.ncols(), |_, _| Complex::new(numbers.unit(), numbers.unit()));
            let v = s * z;
            set_pair(&mut x, real.len() + 2 * pair, &v.unscale(v.norm()));
        }
        let mut ascent = Self { real, complex, x, y: DMatrix::zeros(n, n), log_volume: 0.0 };
        ascent.refresh().then_some(ascent)
    }

    /// Recomputes `X^-T` and the volume; false if X is singular.
    fn refresh(&mut self) -> bool {
        let lu = self.x.clone().lu();
        let log_volume: f64 = lu.u().diagonal().iter().map(|x| x.abs().ln()).sum();
        let Some(inverse) = lu.try_inverse() else { return false };
        if !log_volume.is_finite() || inverse.iter().any(|x| !x.is_finite()) {
            return false;
        }
        self.log_volume = log_volume;
        self.y = inverse.transpose();
        true
    }

    fn run(&mut self) {
        let reals = self.real.len();
        for sweep in 0..SWEEPS {
            let before = self.log_volume;
            // Each sweep pairs the real poles differently: neighbours, starting one position later.
            let order: Vec<usize> = (0..reals).map(|i| (i + sweep) % reals).collect();
            for pair in order.chunks(2) {
                match pair {
                    [i, j] => self.move_two(*i, *j),
                    _ => self.move_one(pair[0]),
                }
            }
            for pair in 0..self.complex.len() {
                self.move_pair(pair);
            }
            if !self.refresh() || self.log_volume - before < SETTLED {
                break;
            }
        }
    }

    fn move_one(&mut self, j: usize) {
        let v = &self.real[j] * self.real[j].tr_mul(&self.y.column(j));
        let norm = v.norm();
        if norm > 0.0 {
            self.x.set_column(j, &(v / norm));
            self.update(&[j]);
        }
    }

    fn move_two(&mut self, i: usize, j: usize) {
        let Some((w1, w2)) = self.complement(i, j) else { return };
        let (s1, s2) = (&self.real[i], &self.real[j]);
        let found = largest_singular([s1.tr_mul(&w1), s1.tr_mul(&w2)], [s2.tr_mul(&w2), -s2.tr_mul(&w1)]);
        if let Some((z1, z2)) = found {
            self.x.set_column(i, &(s1 * z1));
            self.x.set_column(j, &(s2 * z2));
            self.update(&[i, j]);
        }
    }

    fn move_pair(&mut self, pair: usize) {
        let j = self.real.len() + 2 * pair;
        let Some((w1, w2)) = self.complement(j, j + 1) else { return };
        let s = &self.complex[pair];
        let (alpha, beta) = (s.tr_mul(&w1.map(Complex::from)), s.tr_mul(&w2.map(Complex::from)));
        if let Some(z) = largest_pair(&alpha, &beta) {
            set_pair(&mut self.x, j, &(s * z));
            self.update(&[j, j + 1]);
        }
    }

    /// Orthonormal basis of the orthogonal complement of all columns but i and j.
    fn complement(&self, i: usize, j: usize) -> Option<(DVector<f64>, DVector<f64>)> {
        let unit = |v: DVector<f64>| {
            let norm = v.norm();
            (norm > 0.0 && norm.is_finite()).then(|| v / norm)
        };
        let w1 = unit(self.y.column(i).into_owned())?;
        let mut w2 = unit(self.y.column(j).into_owned())?;
        // Two orthogonalisations reach working precision.
        for _ in 0..2 {
            w2 = unit(&w2 - &w1 * w1.dot(&w2))?;
        }
        Some((w1, w2))
    }

    /// `X^-T` after these columns of X were replaced: `G = Y_P' X_P`, `Y_P <- Y_P G^-T`, and the others are made
    /// orthogonal to X_P again.
    fn update(&mut self, columns: &[usize]) {
        let new = self.x.select_columns(columns);
        let products = self.y.tr_mul(&new);
        let Some(inverse) = products.select_rows(columns).try_inverse() else { return };
        let moved = self.y.select_columns(columns) * inverse.transpose();
        let mut others = products;
        for c in columns {
            others.row_mut(*c).fill(0.0);
        }
        self.y -= &moved * others.transpose();
        for (at, c) in columns.iter().enumerate() {
            self.y.set_column(*c, &moved.column(at));
        }
    }
}

fn set_pair(x: &mut DMatrix<f64>, j: usize, v: &DVector<Complex<f64>>) {
    x.set_column(j, &v.map(|x| x.re));
    x.set_column(j + 1, &v.map(|x| x.im));
}

/// Largest singular vectors of `a1 b1' + a2 b2'`, from its 2 x 2 matrix between orthonormal bases of the two spans;
/// `None` if it is zero.
fn largest_singular(a: [DVector<f64>; 2], b: [DVector<f64>; 2]) -> Option<(DVector<f64>, DVector<f64>)> {
    let ([p1, p2], ra) = orthonormal(a);
    let ([q1, q2], rb) = orthonormal(b);
    // m = Ra Rb', both upper triangular.
    let m = [[ra[0] * rb[0] + ra[1] * rb[1], ra[1] * rb[2]], [ra[2] * rb[1], ra[2] * rb[2]]];
    let (xx, yy) = (m[0][0].powi(2) + m[1][0].powi(2), m[0][1].powi(2) + m[1][1].powi(2));
    let (sin, cos) = (0.5 * (2.0 * (m[0][0] * m[0][1] + m[1][0] * m[1][1])).atan2(xx - yy)).sin_cos();
    let u = [m[0][0] * cos + m[0][1] * sin, m[1][0] * cos + m[1][1] * sin];
    let length = u[0].hypot(u[1]);
    (length > 0.0 && length.is_finite()).then(|| (p1 * (u[0] / length) + p2 * (u[1] / length), q1 * cos + q2 * sin))
}

/// `[v1 v2] = [q1 q2] [r0 r1; 0 r2]`; a q is zero if its v is linearly dependent.
fn orthonormal([mut v1, mut v2]: [DVector<f64>; 2]) -> ([DVector<f64>; 2], [f64; 3]) {
    let r0 = v1.norm();
    if r0 > 0.0 {
        v1 /= r0;
    }
    let r1 = v1.dot(&v2);
    v2.axpy(-r1, &v1, 1.0);
    let again = v1.dot(&v2);
    v2.axpy(-again, &v1, 1.0);
    let r2 = v2.norm();
    if r2 > 0.0 {
        v2 /= r2;
    }
    ([v1, v2], [r0, r1 + again, r2])
}

/// Unit vector z that maximises `|Im((alpha'z) conj(beta'z))|`: an eigenvector of `(b a* - a b*)/2i`, with `a, b` the
/// conjugates of alpha and beta. For `a = r0 q1`, `b = r1 q1 + r2 q2`, q1 and q2 orthonormal, this is the matrix
/// `[h ig; -ig 0]`, `h = r0 Im r1`, `g = r0 r2/2`. `None` if it is zero.
fn largest_pair(alpha: &DVector<Complex<f64>>, beta: &DVector<Complex<f64>>) -> Option<DVector<Complex<f64>>> {
    let (mut q1, mut q2) = (alpha.map(|x| x.conj()), beta.map(|x| x.conj()));
    let r0 = q1.norm();
    if !(r0 > 0.0 && r0.is_finite()) {
        return None;
    }
    q1.unscale_mut(r0);
    let r1 = q1.dotc(&q2);
    q2.axpy(-r1, &q1, Complex::from(1.0));
    let again = q1.dotc(&q2);
    q2.axpy(-again, &q1, Complex::from(1.0));
    let r2 = q2.norm();
    if r2 > 0.0 {
        q2.unscale_mut(r2);
    }
    let (h, g) = (r0 * (r1 + again).im, 0.5 * r0 * r2);
    // Eigenvalue of larger modulus, with the eigenvector (lambda, -ig).
    let lambda = 0.5 * h + (0.5 * h).hypot(g).copysign(h);
    let length = lambda.hypot(g);
    (length > 0.0 && length.is_finite())
        .then(|| q1 * Complex::from(lambda / length) + q2 * Complex::new(0.0, -g / length))
}
