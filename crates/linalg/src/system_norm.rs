//! H2 and H-infinity norms of `x' = A x + B w`, `z = C x + D w` (D = 0 for H2) and of `x+ = A x + B w`.
//!
//! **H2**: `||G||_2^2 = tr(B'QB)` with `A'Q + Q A + C'C = 0` (in discrete time `A'QA - Q + C'C = 0`).
//!
//! **H-infinity**: the maximum over w of the largest singular value of `C(jw I - A)^-1 B + D`. A gamma that is no
//! singular value of D is one of it at the frequency w iff `jw` is an eigenvalue of the Hamiltonian matrix
//! ```text
//! [F  G ]
//! [-H -F'],    F = A + B R^-1 D'C,  G = gamma B R^-1 B',  H = gamma C'S^-1 C,  R = gamma^2 I - D'D,  S = gamma^2 I - D D'.
//! ```
//! Two-step method of N. A. Bruinsma and M. Steinbuch, Systems & Control Letters 14, 1990: gamma is set slightly above
//! the largest value found so far; the imaginary eigenvalues bound the frequency intervals with larger values, and the
//! midpoints of these intervals are evaluated next. Rounding moves eigenvalues that are about to meet on the axis by
//! the root of eps, so that none is excluded for its real part: the frequencies of all are evaluated, `O(n^2)` each,
//! and the largest value is followed to its local maximum.
//!
//! In discrete time the same holds on the unit circle for the eigenvalues z of the pencil `[F G; 0 I] - z [I 0; H F']`.
//! The frequency is `tau = tan(angle/2)`, `z = (1 + j tau)/(1 - j tau)`, and the eigenvalues are computed as those of
//! the pencil transformed by `(z - 1)/(z + 1)` or by its inverse, whichever is regular at the largest value found so
//! far. A itself is not transformed, which would lose the digits of a pole near -1.
//!
//! All of this is done in balanced units of the state, the inputs and the outputs (`frequency_response.rs`).

use nalgebra::{Complex, DMatrix};

use crate::argument::{RealMatrixView, owned, shaped, square};
use crate::frequency_response::{SchurResponse, largest};
use crate::units::shift;
use crate::{LinalgError, Result, eigenvalues, invariant_zeros, lyapunov_factor, stein_factor};

/// Relative gap allowed between the returned value and the norm.
const CLOSENESS: f64 = 1e-9;
const ITERATIONS: usize = 40;
/// Each reduces the interval by 0.618: 60 reduce it by 3e-13.
const GOLDEN_SECTIONS: usize = 60;
/// A gamma above the norm of D by less than this loses half of the digits in R^-1.
const NEAR: f64 = 1.0 + 1e-6;
/// Values this near to each other are equal up to rounding.
const FLAT: f64 = 1e-13;

/// The H-infinity norm of a system.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct HInfinityNorm {
    /// The largest singular value found. It is attained; the norm is at most larger by a relative 1e-9, up to rounding:
    /// that of a response at s, eps times the condition of `s I - A`.
    pub norm: f64,
    /// Frequency at which it is attained, in radians per unit of time; infinite for the norm of D. In discrete time an
    /// angle in radians per sample, from 0 to pi.
    pub frequency: f64,
}

/// The H2 norm of `C(sI - A)^-1 B` for a Hurwitz A.
///
/// `a` is n x n, `b` n x m, `c` p x n.
///
/// ```
/// use luenberger_linalg::h2_norm;
/// use nalgebra::dmatrix;
/// // 1/(s + 2): the integral of exp(-4 t) is 1/4.
/// assert!((h2_norm(&dmatrix![-2.0], &dmatrix![1.0], &dmatrix![1.0])? - 0.5).abs() < 1e-15);
/// # Ok::<(), luenberger_linalg::LinalgError>(())
/// ```
///
/// # Errors
/// [`LinalgError::NotStable`] names an eigenvalue that is not in the open left half plane; [`LinalgError::NotSquare`],
/// [`LinalgError::DimensionMismatch`], [`LinalgError::NotFinite`], and those of [`lyapunov()`](crate::lyapunov()).
pub fn h2_norm<'a>(
    a: impl Into<RealMatrixView<'a>>,
    b: impl Into<RealMatrixView<'a>>,
    c: impl Into<RealMatrixView<'a>>,
) -> Result<f64> {
    h2(&owned(a), &owned(b), &owned(c))
}

fn h2(a: &DMatrix<f64>, b: &DMatrix<f64>, c: &DMatrix<f64>) -> Result<f64> {
    let n = check(a, b, c)?;
    if n == 0 {
        return Ok(0.0);
    }
    let system = SchurResponse::new(a, b, c, &DMatrix::zeros(c.nrows(), b.ncols()), false)?;
    // Otherwise there is no such P.
    if let Some(pole) = system.poles.iter().find(|lambda| lambda.re >= 0.0) {
        return Err(LinalgError::NotStable { equation: "Lyapunov", eigenvalue: in_time(*pole, system.time) });
    }
    let factor = lyapunov_factor(&system.t, &system.c).map_err(|error| with_time(error, system.time))?;
    // The square of the norm has the unit of a frequency.
    Ok(shift((factor.u * &system.b).norm(), system.gain) * 2f64.powf(0.5 * f64::from(system.time)))
}

/// An eigenvalue in the time given.
fn in_time(lambda: Complex<f64>, time: i32) -> Complex<f64> {
    Complex::new(shift(lambda.re, time), shift(lambda.im, time))
}

fn with_time(error: LinalgError, time: i32) -> LinalgError {
    match error {
        LinalgError::NotStable { equation, eigenvalue } => {
            LinalgError::NotStable { equation, eigenvalue: in_time(eigenvalue, time) }
        }
        other => other,
    }
}

/// The H2 norm of `C(zI - A)^-1 B` for A with all eigenvalues inside the unit circle. Otherwise as [`h2_norm`].
///
/// # Errors
/// [`LinalgError::NotStable`] names an eigenvalue that is not inside the unit circle; [`LinalgError::NotSquare`],
/// [`LinalgError::DimensionMismatch`], [`LinalgError::NotFinite`], and those of [`stein()`](crate::stein()).
pub fn discrete_h2_norm<'a>(
    a: impl Into<RealMatrixView<'a>>,
    b: impl Into<RealMatrixView<'a>>,
    c: impl Into<RealMatrixView<'a>>,
) -> Result<f64> {
    discrete_h2(&owned(a), &owned(b), &owned(c))
}

fn discrete_h2(a: &DMatrix<f64>, b: &DMatrix<f64>, c: &DMatrix<f64>) -> Result<f64> {
    let n = check(a, b, c)?;
    if n == 0 {
        return Ok(0.0);
    }
    let system = SchurResponse::new(a, b, c, &DMatrix::zeros(c.nrows(), b.ncols()), true)?;
    if let Some(pole) = system.poles.iter().find(|lambda| lambda.norm() >= 1.0) {
        return Err(LinalgError::NotStable { equation: "Stein", eigenvalue: *pole });
    }
    Ok(shift((stein_factor(&system.t, &system.c)?.u * &system.b).norm(), system.gain))
}

/// The H-infinity norm of `C(sI - A)^-1 B + D` for a Hurwitz A.
///
/// `a` is n x n, `b` n x m, `c` p x n, `d` p x m. Whether A is Hurwitz is not tested; at a pole on the imaginary axis
/// the value is infinite. Powers of two as units of time and of the states change nothing, and as units common to all
/// inputs or to all outputs change the norm by that factor.
///
/// ```
/// use luenberger_linalg::h_infinity_norm;
/// use nalgebra::dmatrix;
/// // 1/(s^2 + 0.2 s + 1): the peak is 1/(2 zeta sqrt(1 - zeta^2)) for zeta = 0.1.
/// let (a, b, c) = (dmatrix![0.0, 1.0; -1.0, -0.2], dmatrix![0.0; 1.0], dmatrix![1.0, 0.0]);
/// let found = h_infinity_norm(&a, &b, &c, &dmatrix![0.0])?;
/// assert!((found.norm - 1.0 / (0.2 * 0.99f64.sqrt())).abs() < 1e-8);
/// assert!((found.frequency - 0.98f64.sqrt()).abs() < 1e-4);
/// # Ok::<(), luenberger_linalg::LinalgError>(())
/// ```
///
/// # Errors
/// [`LinalgError::NotSquare`], [`LinalgError::DimensionMismatch`], [`LinalgError::NotFinite`], and those of
/// [`eigenvalues`]; [`LinalgError::NotConverged`] after 40 steps.
pub fn h_infinity_norm<'a>(
    a: impl Into<RealMatrixView<'a>>,
    b: impl Into<RealMatrixView<'a>>,
    c: impl Into<RealMatrixView<'a>>,
    d: impl Into<RealMatrixView<'a>>,
) -> Result<HInfinityNorm> {
    h_infinity(&owned(a), &owned(b), &owned(c), &owned(d))
}

fn h_infinity(a: &DMatrix<f64>, b: &DMatrix<f64>, c: &DMatrix<f64>, d: &DMatrix<f64>) -> Result<HInfinityNorm> {
    search(a, b, c, d, false)
}

/// The H-infinity norm of `C(zI - A)^-1 B + D` for A with all eigenvalues inside the unit circle.
///
/// # Errors
/// As [`h_infinity_norm`].
pub fn discrete_h_infinity_norm<'a>(
    a: impl Into<RealMatrixView<'a>>,
    b: impl Into<RealMatrixView<'a>>,
    c: impl Into<RealMatrixView<'a>>,
    d: impl Into<RealMatrixView<'a>>,
) -> Result<HInfinityNorm> {
    discrete_h_infinity(&owned(a), &owned(b), &owned(c), &owned(d))
}

fn discrete_h_infinity(
    a: &DMatrix<f64>,
    b: &DMatrix<f64>,
    c: &DMatrix<f64>,
    d: &DMatrix<f64>,
) -> Result<HInfinityNorm> {
    search(a, b, c, d, true)
}

fn search(
    a: &DMatrix<f64>,
    b: &DMatrix<f64>,
    c: &DMatrix<f64>,
    d: &DMatrix<f64>,
    discrete: bool,
) -> Result<HInfinityNorm> {
    let n = check(a, b, c)?;
    shaped("D", d, c.nrows(), b.ncols())?;
    if n == 0 {
        return Ok(HInfinityNorm { norm: largest(&d.map(Complex::from)), frequency: f64::INFINITY });
    }
    let mut search = Search::new(SchurResponse::new(a, b, c, d, discrete)?, discrete);
    search.start();
    let converged = search.climb()?;
    let Search { system, best, .. } = search;
    let norm = shift(best.norm, system.gain);
    if !converged {
        return Err(LinalgError::NotConverged {
            method: "the bisection of the H-infinity norm",
            iterations: ITERATIONS,
            remaining: norm,
            allowed: CLOSENESS * norm,
        });
    }
    let frequency = if discrete { 2.0 * best.frequency.atan() } else { shift(best.frequency, system.time) };
    Ok(HInfinityNorm { norm, frequency })
}

/// The search for the maximum over the frequency: w in continuous time, tau in discrete time.
struct Search {
    system: SchurResponse,
    discrete: bool,
    best: HInfinityNorm,
    /// Finite frequencies evaluated so far, with their values.
    seen: Vec<(f64, f64)>,
}

impl Search {
    fn new(system: SchurResponse, discrete: bool) -> Self {
        Self { system, discrete, best: HInfinityNorm { norm: 0.0, frequency: 0.0 }, seen: Vec::new() }
    }

    fn value(&self, frequency: f64) -> f64 {
        if !self.discrete {
            return match frequency {
                f64::INFINITY => largest(&self.system.d.map(Complex::from)),
                w => self.system.at(0.0, Complex::new(0.0, w)),
            };
        }
        // `z - 1 = 2 j tau/(1 - j tau)`, `z + 1 = 2/(1 - j tau)`.
        if frequency <= 1.0 {
            let tau = Complex::new(0.0, frequency);
            self.system.at(1.0, tau * 2.0 / (1.0 - tau))
        } else {
            let inverse = Complex::new(0.0, -frequency.recip());
            self.system.at(-1.0, inverse * 2.0 / (1.0 + inverse))
        }
    }

    fn attempt(&mut self, frequency: f64) {
        if frequency.is_nan() {
            return;
        }
        let norm = self.value(frequency);
        if frequency.is_finite() {
            self.seen.push((frequency, norm));
        }
        if norm > self.best.norm {
            self.best = HInfinityNorm { norm, frequency };
        }
    }

    /// The frequency of an eigenvalue.
    fn frequency(&self, lambda: Complex<f64>) -> f64 {
        let im = lambda.im.abs();
        match self.discrete {
            false => im,
            true if lambda.re >= 0.0 => im / (lambda.norm() + lambda.re),
            true => (lambda.norm() - lambda.re) / im,
        }
    }

    /// Both ends, and the frequencies of the poles with their resonances `sqrt(im^2 - re^2)`.
    fn start(&mut self) {
        self.attempt(f64::INFINITY);
        self.attempt(0.0);
        for pole in self.system.poles.clone() {
            self.attempt(self.frequency(pole));
            if self.discrete {
                continue;
            }
            self.attempt(pole.norm());
            if pole.im.abs() > pole.re.abs() {
                self.attempt((pole.im.abs() - pole.re.abs()).sqrt() * (pole.im.abs() + pole.re.abs()).sqrt());
            }
        }
        // Where the response vanishes at all of these.
        self.attempt(self.system.t.norm());
        self.ascend();
    }

    /// Whether a step ended that found nothing larger; false after too many steps.
    fn climb(&mut self) -> Result<bool> {
        for _ in 0..ITERATIONS {
            let before = self.best.norm;
            if before == 0.0 || before.is_infinite() {
                return Ok(true);
            }
            let Some(mut crossings) = self.crossings(before * (1.0 + CLOSENESS))? else { return Ok(true) };
            crossings.sort_by(f64::total_cmp);
            crossings.dedup();
            if let Some(first) = crossings.first() {
                self.attempt(0.5 * first);
            }
            // Above the norm of D by little, one crossing is near infinity: the geometric mean is far from it.
            for pair in crossings.windows(2) {
                self.attempt(0.5 * (pair[0] + pair[1]));
                self.attempt((pair[0] * pair[1]).sqrt());
            }
            for crossing in &crossings {
                self.attempt(*crossing);
            }
            if self.best.norm > before {
                self.ascend();
            }
            if self.best.norm <= before * (1.0 + CLOSENESS) {
                return Ok(true);
            }
        }
        Ok(false)
    }

    /// The local maximum between the neighbours of the best frequency, by golden sections.
    fn ascend(&mut self) {
        const INVERSE_RATIO: f64 = 0.618_033_988_749_894_9;
        let HInfinityNorm { frequency: top, norm } = self.best;
        if !(top > 0.0 && top.is_finite() && norm.is_finite()) {
            return;
        }
        // A quarter of the frequency at most: beyond that the neighbours say nothing.
        let (mut low, mut high) = (0.75 * top, 1.25 * top);
        for &(frequency, _) in &self.seen {
            if frequency < top {
                low = low.max(frequency);
            } else if frequency > top {
                high = high.min(frequency);
            }
        }
        let inner = |low: f64, high: f64| (high - INVERSE_RATIO * (high - low), low + INVERSE_RATIO * (high - low));
        let (mut left, mut right) = inner(low, high);
        let (mut at_left, mut at_right) = (self.value(left), self.value(right));
        for _ in 0..GOLDEN_SECTIONS {
            if at_left > at_right {
                (high, right, at_right) = (right, left, at_left);
                left = inner(low, high).0;
                at_left = self.value(left);
            } else {
                (low, left, at_left) = (left, right, at_right);
                right = inner(low, high).1;
                at_right = self.value(right);
            }
            let larger = at_left.max(at_right);
            // Two values within a section of the maximum: the error is of the order of their difference.
            if larger >= self.best.norm && (at_left - at_right).abs() <= FLAT * larger && high - low <= 0.01 * high {
                break;
            }
        }
        self.attempt(left);
        self.attempt(right);
    }

    /// Frequencies at which gamma may be a singular value; `None` if it is one of D. (In discrete time gamma can be
    /// below the norm of D, which the maximum over the circle is not.)
    fn crossings(&self, gamma: f64) -> Result<Option<Vec<f64>>> {
        let SchurResponse { t: a, b, c, d, .. } = &self.system;
        let n = a.nrows();
        if !self.discrete && (self.best.frequency.is_infinite() || gamma <= NEAR * largest(&d.map(Complex::from))) {
            // gamma is so little above the norm of D that R^-1 is large.
            return frequencies_of_singular_value([a, b, c, d], gamma).map(Some);
        }
        let inverse = |square: DMatrix<f64>| {
            let m = DMatrix::identity(square.nrows(), square.nrows()) * (gamma * gamma) - square;
            m.try_inverse().filter(|m| m.iter().all(|x| x.is_finite()))
        };
        let (Some(r), Some(s)) = (inverse(d.tr_mul(d)), inverse(d * d.transpose())) else { return Ok(None) };
        let f = a + b * &r * d.tr_mul(c);
        let g = b * r * b.transpose() * gamma;
        let h = c.tr_mul(&s) * c * gamma;
        let assembled = |blocks: [&DMatrix<f64>; 4]| {
            let mut whole = DMatrix::zeros(2 * n, 2 * n);
            for (k, block) in blocks.into_iter().enumerate() {
                whole.view_mut((k / 2 * n, k % 2 * n), (n, n)).copy_from(block);
            }
            whole
        };
        if !self.discrete {
            let hamiltonian = assembled([&f, &g, &-h, &-f.transpose()]);
            return Ok(Some(eigenvalues(&hamiltonian)?.iter().map(|z| z.im.abs()).collect()));
        }
        let (identity, zero) = (DMatrix::identity(n, n), DMatrix::zeros(n, n));
        let (left, right) = (assembled([&f, &g, &zero, &identity]), assembled([&identity, &zero, &h, &f.transpose()]));
        let (plus, minus) = (&left + &right, &left - &right);
        // Where gamma is a singular value at -1, `plus` is singular.
        let near_minus_one = self.best.frequency > 1.0;
        let (divisor, dividend) = if near_minus_one { (minus, plus) } else { (plus, minus) };
        let singular = LinalgError::Singular { what: "the transformed pencil of the norm", condition: f64::INFINITY };
        let quotient = divisor.lu().solve(&dividend).filter(|m| m.iter().all(|x| x.is_finite())).ok_or(singular)?;
        let found = eigenvalues(&quotient)?;
        let frequencies = found.iter().map(|z| if near_minus_one { z.im.abs().recip() } else { z.im.abs() });
        Ok(Some(frequencies.filter(|tau| tau.is_finite()).collect()))
    }
}

/// The order of (A, B, C), if their shapes fit and their entries are finite.
fn check(a: &DMatrix<f64>, b: &DMatrix<f64>, c: &DMatrix<f64>) -> Result<usize> {
    let n = square("A", a)?;
    shaped("B", b, n, b.ncols())?;
    shaped("C", c, c.nrows(), n)?;
    Ok(n)
}

/// The block diagonal matrix of two others.
pub(crate) fn block_diagonal(first: &DMatrix<f64>, last: &DMatrix<f64>) -> DMatrix<f64> {
    let ((rows, columns), both) = (first.shape(), (first.nrows() + last.nrows(), first.ncols() + last.ncols()));
    let mut whole = DMatrix::zeros(both.0, both.1);
    whole.view_mut((0, 0), first.shape()).copy_from(first);
    whole.view_mut((rows, columns), last.shape()).copy_from(last);
    whole
}

/// Frequencies at which gamma may be a singular value of `C(jw I - A)^-1 B + D`, by orthogonal steps: the imaginary
/// parts of the zeros of the system whose states are those of `G u = gamma v` and of its adjoint `G* v = gamma u`, with
/// the inputs u and v.
pub(crate) fn frequencies_of_singular_value([a, b, c, d]: [&DMatrix<f64>; 4], gamma: f64) -> Result<Vec<f64>> {
    let (m, p) = (b.ncols(), c.nrows());
    let mut feedthrough = block_diagonal(d, &d.transpose());
    feedthrough.view_mut((0, m), (p, p)).fill_diagonal(-gamma);
    feedthrough.view_mut((p, 0), (m, m)).fill_diagonal(-gamma);
    let zeros = invariant_zeros(
        &block_diagonal(a, &-a.transpose()),
        &block_diagonal(b, &-c.transpose()),
        &block_diagonal(c, &b.transpose()),
        &feedthrough,
    )?;
    Ok(zeros.zeros.iter().map(|z| z.im.abs()).collect())
}
