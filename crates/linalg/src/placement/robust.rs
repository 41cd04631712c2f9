//! Placement with several inputs: eigenvectors of the largest volume (Tits and Yang, IEEE TAC 41, 1996; from method 0 of Kautsky, Nichols and
//! Van Dooren, Int. J. Control 41, 1985).
//!
//! With `B = U1 Z`, `[U1 U0]` orthogonal, `x` can be made an eigenvector for `lambda` iff `U0'(A - lambda I) x = 0`: a subspace `S` of dimension
//! rank(B). Unit vectors are chosen from these subspaces so as to make `|det X|` large, two at a time with the others fixed, each choice
//! being optimal: with `w1, w2` an orthonormal basis of what is orthogonal to the others,
//!
//! ```text
//! two real poles     maximise | z1' S1'(w1 w2' - w2 w1') S2 z2 |        the largest singular vectors
//! a complex pair     maximise | Im( (w1'S z) conj(w2'S z) ) |           an eigenvector of a hermitian matrix of rank 2
//! one real pole      maximise | w1'S z |                                a projection
//! ```
//!
//! `|det X| <= 1` never decreases, so that the sweeps settle; their number is capped, and the starts are fixed. Then `K = U1'(A - X Lambda X^-1)`.

use faer::Mat;
use nalgebra::{Complex, DMatrix, DVector};

use super::poles::Wish;
use crate::{LinalgError, Result};

/// Most sweeps over all poles. Volume is gained in the first few.
const SWEEPS: usize = 40;
/// A sweep that gains less than this in `log |det X|` is the last: the condition no longer moves in its third digit.
const SETTLED: f64 = 1e-4;
/// Starting points that are tried; the best-conditioned result is kept.
const STARTS: u64 = 4;
/// More starts are tried if these all give a singular X.
const MOST_STARTS: u64 = 20;

/// The gain (rank x n) for `A - U1 K`, and the eigenvectors aimed at: those of the real poles, then conjugates side by side.
pub(super) fn assign(
    a: &DMatrix<f64>,
    inputs: &DMatrix<f64>,
    others: &DMatrix<f64>,
    wish: &Wish,
) -> Result<(DMatrix<f64>, DMatrix<Complex<f64>>)> {
    let n = a.nrows();
    let eigenvectors = if others.ncols() == 0 {
        // Every vector serves: X = I, and (e1 + i e2)/sqrt 2 for pairs.
        Eigenvectors { x: DMatrix::identity(n, n), reals: wish.real.len() }
    } else {
        best_eigenvectors(a, others, wish)?
    };
    let x = &eigenvectors.x;
    let mut x_lambda = x.clone();
    for (j, lambda) in wish.real.iter().enumerate() {
        x_lambda.column_mut(j).scale_mut(*lambda);
    }
    for (pair, lambda) in wish.pairs.iter().enumerate() {
        // A (u + i v) = lambda (u + i v).
        let j = wish.real.len() + 2 * pair;
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
    Ok((inputs.transpose() * (a - closed), eigenvectors.complex()))
}

/// Real columns: `x` of a real pole, `Re x, Im x` of a pair.
struct Eigenvectors {
    x: DMatrix<f64>,
    reals: usize,
}

impl Eigenvectors {
    fn complex(&self) -> DMatrix<Complex<f64>> {
        let n = self.x.nrows();
        DMatrix::from_fn(n, n, |i, j| {
            if j < self.reals {
                Complex::from(self.x[(i, j)])
            } else {
                let first = j - (j - self.reals) % 2;
                let sign = if first == j { 1.0 } else { -1.0 };
                Complex::new(self.x[(i, first)], sign * self.x[(i, first + 1)])
            }
        })
    }
}

fn best_eigenvectors(a: &DMatrix<f64>, others: &DMatrix<f64>, wish: &Wish) -> Result<Eigenvectors> {
    let real: Vec<DMatrix<f64>> =
        wish.real.iter().map(|p| admissible(a, others, Complex::from(*p)).map(|x| x.re)).collect();
    let complex: Vec<DMatrix<Complex<f64>>> = wish.pairs.iter().map(|p| admissible(a, others, *p)).collect();
    let mut best: Option<(f64, Ascent)> = None;
    for seed in 0..MOST_STARTS {
        if seed >= STARTS && best.is_some() {
            break;
        }
        let Some(mut ascent) = Ascent::start(&real, &complex, seed) else { continue };
        ascent.run()?;
        // With unit columns |X^-1| is cond(X) in the Frobenius norm up to a constant.
        let size = ascent.y.norm();
        if size.is_finite() && best.as_ref().is_none_or(|(least, _)| size < *least) {
            best = Some((size, ascent));
        }
    }
    let (_, ascent) = best.ok_or(LinalgError::Overflow { what: "the inverse of the eigenvectors" })?;
    Ok(Eigenvectors { x: ascent.x, reals: real.len() })
}

/// Orthonormal basis of the null space of `U0'(A - lambda I)`, n x rank(B): what a QR of its adjoint leaves.
fn admissible(a: &DMatrix<f64>, others: &DMatrix<f64>, lambda: Complex<f64>) -> DMatrix<Complex<f64>> {
    let (n, k) = others.shape();
    let real_part = a.transpose() * others;
    let adjoint = Mat::from_fn(n, k, |i, j| Complex::from(real_part[(i, j)]) - lambda.conj() * others[(i, j)]);
    let q = adjoint.qr().compute_Q();
    DMatrix::from_fn(n, n - k, |i, j| q[(i, k + j)])
}

/// The eigenvectors on their way up.
struct Ascent<'a> {
    real: &'a [DMatrix<f64>],
    complex: &'a [DMatrix<Complex<f64>>],
    x: DMatrix<f64>,
    /// `X^-T`: its columns are orthogonal to all other columns of X.
    y: DMatrix<f64>,
    log_volume: f64,
}

impl<'a> Ascent<'a> {
    /// Fixed, generic coordinates in each subspace; none if X is singular.
    fn start(real: &'a [DMatrix<f64>], complex: &'a [DMatrix<Complex<f64>>], seed: u64) -> Option<Self> {
        let n = real.len() + 2 * complex.len();
        let mut numbers = Generic(seed << 32);
        let mut x = DMatrix::zeros(n, n);
        for (j, s) in real.iter().enumerate() {
            let z = DVector::from_fn(s.ncols(), |_, _| numbers.next());
            let v = s * z;
            x.set_column(j, &(&v / v.norm()));
        }
        for (pair, s) in complex.iter().enumerate() {
            let z = DVector::from_fn(s.ncols(), |_, _| Complex::new(numbers.next(), numbers.next()));
            let v = s * z;
            set_pair(&mut x, real.len() + 2 * pair, &v.unscale(v.norm()));
        }
        let mut ascent = Self { real, complex, x, y: DMatrix::zeros(n, n), log_volume: 0.0 };
        ascent.refresh().then_some(ascent)
    }

    /// `X^-T` and the volume afresh; false if X is singular.
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

    fn run(&mut self) -> Result<()> {
        let reals = self.real.len();
        for sweep in 0..SWEEPS {
            let before = self.log_volume;
            // Each sweep pairs the real poles another way: neighbours, starting one further on.
            let order: Vec<usize> = (0..reals).map(|i| (i + sweep) % reals).collect();
            for pair in order.chunks(2) {
                match pair {
                    [i, j] => self.move_two(*i, *j)?,
                    _ => self.move_one(pair[0]),
                }
            }
            for pair in 0..self.complex.len() {
                self.move_pair(pair)?;
            }
            if !self.refresh() || self.log_volume - before < SETTLED {
                break;
            }
        }
        Ok(())
    }

    fn move_one(&mut self, j: usize) {
        let v = &self.real[j] * self.real[j].tr_mul(&self.y.column(j));
        let norm = v.norm();
        if norm > 0.0 {
            self.x.set_column(j, &(v / norm));
            self.update(&[j]);
        }
    }

    fn move_two(&mut self, i: usize, j: usize) -> Result<()> {
        let Some((w1, w2)) = self.complement(i, j) else { return Ok(()) };
        let (s1, s2) = (&self.real[i], &self.real[j]);
        let volume = s1.tr_mul(&w1) * s2.tr_mul(&w2).transpose() - s1.tr_mul(&w2) * s2.tr_mul(&w1).transpose();
        let svd = Mat::from_fn(volume.nrows(), volume.ncols(), |r, c| volume[(r, c)])
            .svd()
            .map_err(|_| not_converged("singular vectors of a pair of poles"))?;
        let (u, v) = (svd.U(), svd.V());
        if svd.S().column_vector()[0] > 0.0 {
            self.x.set_column(i, &(s1 * DVector::from_fn(s1.ncols(), |r, _| u[(r, 0)])));
            self.x.set_column(j, &(s2 * DVector::from_fn(s2.ncols(), |r, _| v[(r, 0)])));
            self.update(&[i, j]);
        }
        Ok(())
    }

    fn move_pair(&mut self, pair: usize) -> Result<()> {
        let j = self.real.len() + 2 * pair;
        let Some((w1, w2)) = self.complement(j, j + 1) else { return Ok(()) };
        let s = &self.complex[pair];
        let (alpha, beta) = (s.tr_mul(&w1.map(Complex::from)), s.tr_mul(&w2.map(Complex::from)));
        let k = s.ncols();
        let hermitian =
            Mat::from_fn(k, k, |r, c| (beta[r].conj() * alpha[c] - alpha[r].conj() * beta[c]) / Complex::new(0.0, 2.0));
        let eigen = hermitian
            .self_adjoint_eigen(faer::Side::Lower)
            .map_err(|_| not_converged("eigenvectors of a complex pair of poles"))?;
        let values = eigen.S().column_vector();
        // Ascending: the largest in size is at one of the ends.
        let at = if values[0].re.abs() > values[k - 1].re.abs() { 0 } else { k - 1 };
        if values[at].re != 0.0 {
            let u = eigen.U();
            let z = DVector::from_fn(k, |r, _| u[(r, at)]);
            set_pair(&mut self.x, j, &(s * z));
            self.update(&[j, j + 1]);
        }
        Ok(())
    }

    /// Orthonormal basis of the orthogonal complement of all columns but i and j.
    fn complement(&self, i: usize, j: usize) -> Option<(DVector<f64>, DVector<f64>)> {
        let unit = |v: DVector<f64>| {
            let norm = v.norm();
            (norm > 0.0 && norm.is_finite()).then(|| v / norm)
        };
        let w1 = unit(self.y.column(i).into_owned())?;
        let mut w2 = unit(self.y.column(j).into_owned())?;
        // Twice is enough.
        for _ in 0..2 {
            w2 = unit(&w2 - &w1 * w1.dot(&w2))?;
        }
        Some((w1, w2))
    }

    /// `X^-T` after these columns of X were replaced: `G = Y_P' X_P`, `Y_P <- Y_P G^-T`, and the others are made orthogonal to X_P again.
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

fn not_converged(method: &'static str) -> LinalgError {
    LinalgError::NotConverged { method, iterations: 0, remaining: f64::NAN, allowed: f64::EPSILON }
}

/// Fixed numbers in (-1, 1) without pattern (splitmix64), so that a start is generic and the same everywhere.
struct Generic(u64);

impl Generic {
    fn next(&mut self) -> f64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        z ^= z >> 31;
        (z >> 11) as f64 / (1u64 << 52) as f64 - 1.0
    }
}
