//! Pole placement: the gain `K` that gives `A - B K`, or the gain `L` that gives `A - L C`, the requested eigenvalues.
//!
//! A gain exists for every set of n poles closed under conjugation iff the pair is controllable (for `L`: observable;
//! Wonham 1967). With one independent input it is unique. With more, the remaining freedom is used for well-conditioned
//! eigenvectors `X`: a change `E` of the closed loop moves its eigenvalues by at most `cond(X) |E|` (Bauer and Fike).
//!
//! | independent inputs | method |
//! |---|---|
//! | 1 | deflation of the Hessenberg form, Miminis and Paige |
//! | more | eigenvectors of largest volume, Tits and Yang |
//! | n | `K = B^+ (A - Lambda)`, directly |
//! | more, and all poles at zero | the deadbeat gain of least norm |

mod deadbeat;
pub(crate) mod eigenvectors;
pub(crate) mod extremes;
pub(crate) mod poles;
mod robust;
pub(crate) mod sensitivity;
mod single_input;
mod structured;

use std::fmt;

use luenberger_wording::significant;
use nalgebra::{Complex, DMatrix};

use crate::argument::{RealMatrixView, owned, shaped, square};
use crate::error::listed;
use crate::observability::{Mode, Seen, default_tolerance, seen};
use crate::product::view;
use crate::schur::{schur, triangular_factor};
use crate::sequential::svd;
use crate::staircase::Staircase;
use crate::units::{Units, shift, spread};
use crate::{LinalgError, Result};
use eigenvectors::Eigenvectors;
use poles::RequestedPoles;
use sensitivity::conditions;
pub use structured::{StructuredPlacement, place_observer_structured, place_structured};

/// A gain with the achieved poles, their errors and their condition.
///
/// ```
/// use luenberger_linalg::place_observer;
/// use nalgebra::dmatrix;
/// let text = place_observer(&dmatrix![0.0, 1.0; 0.0, 0.0], &dmatrix![1.0, 0.0], &[-2.0, -5.0])?.to_string();
/// assert!(text.contains("poles -2, -5; relative deviation ") && text.contains("cond(X) "));
/// # Ok::<(), luenberger_linalg::LinalgError>(())
/// ```
#[derive(Debug, Clone, PartialEq)]
pub struct Placement {
    /// `K`, m x n, for [`place`]; `L`, n x p, for [`place_observer`].
    pub gain: DMatrix<f64>,
    /// The eigenvalues of the closed loop with the returned gain, each matched to a requested pole, in the order of
    /// the argument.
    pub poles: Vec<Complex<f64>>,
    /// The distance of each achieved pole from the requested one, in the units of the poles.
    pub errors: Vec<f64>,
    /// Condition number `|x| |y| / |y*x|` of each achieved pole, `x, y` its right and left eigenvectors in the units
    /// given: to first order, a change E of the closed loop moves the pole by at most this times `|E|`. 1 is best;
    /// beyond `1e8` the pole is defective to working precision.
    pub sensitivities: Vec<f64>,
    /// Largest distance between a requested and an achieved pole, relative to the larger of the largest requested pole
    /// and the norm of `A` in balanced units. Large for an ill-conditioned placement.
    pub deviation: f64,
    /// `cond_2(X)`, X the normalised eigenvectors of the closed loop with exactly the requested poles, in the units
    /// given. Infinite if that loop is defective, as for a repeated pole with one input.
    pub condition: f64,
}

impl fmt::Display for Placement {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let (deviation, condition) = (significant(self.deviation, 3), significant(self.condition, 3));
        write!(f, "gain ={}poles {}", self.gain, listed(&self.poles))?;
        write!(f, "; relative deviation {deviation}, cond(X) {condition}")
    }
}

/// State feedback gain `K`, m x n, that places the eigenvalues of `A - B K` at `poles`.
///
/// `a` is n x n, `b` n x m, `poles` n numbers, real or complex, closed under conjugation, in any order. With rank(B) >
/// 1 each may be repeated at most rank(B) times (more would make the loop defective). With rank(B) = 1 any repetition
/// is allowed; the gain is unique. Sign: `u = -K x`.
///
/// All poles at zero are the exception: the *deadbeat* gain takes every state of `x+ = (A - B K) x` to zero in the
/// fewest steps, the last one after as many as the largest controllability index. Of these gains it is the one of least
/// Frobenius norm in the units chosen.
///
/// # Errors
/// - [`LinalgError::Uncontrollable`] names the eigenvalue that no gain can move, with the direction that no input
///   excites.
/// - [`LinalgError::PoleCount`], [`LinalgError::PoleNotFinite`], [`LinalgError::PoleUnpaired`],
///   [`LinalgError::PoleMultiplicity`].
/// - [`LinalgError::NotSquare`], [`LinalgError::DimensionMismatch`], [`LinalgError::NotFinite`],
///   [`LinalgError::Empty`]; [`LinalgError::Overflow`] if the gain does not fit a double.
///
/// A nearly uncontrollable pair is no error: see [`Placement::deviation`] and [`Placement::condition`].
///
/// # Cost
/// One input: about `50 n^3` flops, half of them for the achieved poles. Several inputs: one QR decomposition of order
/// n per pole, `O(n^4)` in all.
///
/// # Example
/// ```
/// use luenberger_linalg::place;
/// use nalgebra::{Complex, dmatrix};
///
/// let (a, b) = (dmatrix![0.0, 1.0; 3.0, 2.0], dmatrix![0.0; 1.0]);
/// let requested = [Complex::new(-1.0, 2.0), Complex::new(-1.0, -2.0)];
/// let placed = place(&a, &b, &requested)?;
/// let residual = (&placed.gain - dmatrix![8.0, 4.0]).norm();
/// println!("K = {}, residual {residual:e}, poles off by {:e}", placed.gain, placed.deviation);
/// assert!(residual < 1e-14 && placed.deviation < 1e-14);
/// # Ok::<(), luenberger_linalg::LinalgError>(())
/// ```
///
/// Source: Miminis and Paige, Int. J. Control 35, 1982; Kautsky, Nichols, Van Dooren, Int. J. Control 41, 1985; Tits
/// and Yang, IEEE TAC 41, 1996; for poles at zero Van Dooren, BIT 24, 1984.
pub fn place<'a>(
    a: impl Into<RealMatrixView<'a>>,
    b: impl Into<RealMatrixView<'a>>,
    poles: &[impl Into<Complex<f64>> + Copy],
) -> Result<Placement> {
    let poles: Vec<_> = poles.iter().map(|&pole| pole.into()).collect();
    controller(&owned(a), &owned(b), &poles)
}

fn controller(a: &DMatrix<f64>, b: &DMatrix<f64>, poles: &[Complex<f64>]) -> Result<Placement> {
    check(a)?;
    shaped("B", b, a.nrows(), b.ncols())?;
    let requested = RequestedPoles::new(poles, a.nrows())?;
    let (dual, inputs) = (a.transpose(), b.transpose());
    let units = Units::of(&dual, &inputs);
    let staircase = observable(&units, &dual, &inputs)?.map_err(|mode| {
        let Mode { eigenvalue, direction, margin, .. } = mode;
        LinalgError::Uncontrollable { eigenvalue, direction, margin }
    })?;
    let assigned = assign(a, b, &requested, units, Some(staircase))?;
    let condition = if requested.is_defective(assigned.rank) { f64::INFINITY } else { assigned.vectors.condition()? };
    Ok(finish(assigned.gain.clone(), &requested, &assigned, condition))
}

/// Observer gain `L`, n x p, that places the eigenvalues of `A - L C` at `poles`.
///
/// `a` is n x n, `c` p x n, `poles` n numbers, real or complex, closed under conjugation, in any order. With rank(C) >
/// 1 each may be repeated at most rank(C) times; with rank(C) = 1 any repetition is allowed. This is [`place`] of
/// `(A', C')`, transposed. All poles at zero give the deadbeat observer: `(A - L C)^mu = 0`, mu the largest
/// observability index.
///
/// # Errors
/// As [`place`], with [`LinalgError::Unobservable`], which names the eigenvalue that no gain can move and the direction
/// that no output sees.
///
/// # Cost
/// As [`place`].
///
/// # Example
/// The double integrator with its position measured: `L = (7, 10)` for the poles -2, -5.
/// ```
/// use luenberger_linalg::place_observer;
/// use nalgebra::dmatrix;
///
/// let (a, c) = (dmatrix![0.0, 1.0; 0.0, 0.0], dmatrix![1.0, 0.0]);
/// let placed = place_observer(&a, &c, &[-2.0, -5.0])?;
/// let residual = (&placed.gain - dmatrix![7.0; 10.0]).norm();
/// println!("L = {}, residual {residual:e}, cond(X) = {}", placed.gain, placed.condition);
/// assert!(residual < 1e-14);
/// # Ok::<(), luenberger_linalg::LinalgError>(())
/// ```
///
/// The position of a double integrator and a bias measured, sampled: the observability indices are 2 and 1, and the
/// error of the deadbeat observer is zero after two steps.
/// ```
/// use luenberger_linalg::place_observer;
/// use nalgebra::dmatrix;
///
/// let a = dmatrix![1.0, 0.1, 0.0; 0.0, 1.0, 0.0; 0.0, 0.0, 1.0];
/// let c = dmatrix![1.0, 0.0, 0.0; 0.0, 0.0, 1.0];
/// let placed = place_observer(&a, &c, &[0.0; 3])?;
/// let residual = (&placed.gain - dmatrix![2.0, 0.0; 10.0, 0.0; 0.0, 1.0]).norm();
/// println!("L = {}, residual {residual:e}", placed.gain);
/// assert!(residual < 1e-13 && (&a - &placed.gain * &c).pow(2).norm() < 1e-13);
/// # Ok::<(), luenberger_linalg::LinalgError>(())
/// ```
///
/// Source: Luenberger, IEEE TAC 11, 1966; the methods of [`place`].
pub fn place_observer<'a>(
    a: impl Into<RealMatrixView<'a>>,
    c: impl Into<RealMatrixView<'a>>,
    poles: &[impl Into<Complex<f64>> + Copy],
) -> Result<Placement> {
    let poles: Vec<_> = poles.iter().map(|&pole| pole.into()).collect();
    observer(&owned(a), &owned(c), &poles)
}

fn observer(a: &DMatrix<f64>, c: &DMatrix<f64>, poles: &[Complex<f64>]) -> Result<Placement> {
    check(a)?;
    shaped("C", c, c.nrows(), a.nrows())?;
    let requested = RequestedPoles::new(poles, a.nrows())?;
    let units = Units::of(a, c);
    let staircase = observable(&units, a, c)?.map_err(|mode| {
        let Mode { eigenvalue, direction, margin, .. } = mode;
        LinalgError::Unobservable { eigenvalue, direction, margin }
    })?;
    place_observed(a, c, &requested, units, Some(staircase))
}

/// Staircase form of an observable pair, or the least observable mode.
fn observable(units: &Units, a: &DMatrix<f64>, c: &DMatrix<f64>) -> Result<core::result::Result<Staircase, Mode>> {
    Ok(match seen(units, a, c)? {
        Seen::All(staircase) => Ok(staircase),
        Seen::Hidden(mode) => Err(mode),
    })
}

/// [`place_observer`] of a pair that is known to be observable.
fn place_observed(
    a: &DMatrix<f64>,
    c: &DMatrix<f64>,
    requested: &RequestedPoles,
    units: Units,
    staircase: Option<Staircase>,
) -> Result<Placement> {
    let assigned = assign(&a.transpose(), &c.transpose(), requested, units, staircase)?;
    // The eigenvectors of A - L C are the left ones of its transpose.
    let condition = match assigned.vectors.dual() {
        Some(vectors) if !requested.is_defective(assigned.rank) => vectors.normalised().condition()?,
        _ => f64::INFINITY,
    };
    Ok(finish(assigned.gain.transpose(), requested, &assigned, condition))
}

/// [`place_observer`] for a part of an observable pair: the part is observable too and is not tested.
pub(crate) fn place_part(a: &DMatrix<f64>, c: &DMatrix<f64>, poles: &[Complex<f64>]) -> Result<Placement> {
    place_observed(a, c, &RequestedPoles::new(poles, a.nrows())?, Units::of(a, c), None)
}

fn check(a: &DMatrix<f64>) -> Result<()> {
    if square("A", a)? == 0 { Err(LinalgError::Empty { what: "A" }) } else { Ok(()) }
}

fn finish(gain: DMatrix<f64>, requested: &RequestedPoles, closed: &Assigned, condition: f64) -> Placement {
    let at = requested.matched(&closed.achieved);
    let poles: Vec<Complex<f64>> = at.iter().map(|k| closed.achieved[*k]).collect();
    let sensitivities = at.iter().map(|k| closed.sensitivities[*k]).collect();
    let errors: Vec<f64> = poles.iter().zip(requested.poles()).map(|(x, y)| (x - y).norm()).collect();
    let scale = requested.poles().iter().map(|p| p.norm()).fold(closed.size, f64::max);
    let distance = errors.iter().copied().fold(0.0, f64::max);
    let deviation = if distance == 0.0 { 0.0 } else { distance / scale };
    Placement { gain, poles, errors, sensitivities, deviation, condition }
}

impl Placement {
    /// The empty placement: no poles, and a 0 x `outputs` gain (an observer of order zero).
    pub(crate) fn nothing(outputs: usize) -> Self {
        Self {
            gain: DMatrix::zeros(0, outputs),
            poles: Vec::new(),
            errors: Vec::new(),
            sensitivities: Vec::new(),
            deviation: 0.0,
            condition: 1.0,
        }
    }

    /// The same poles with time in other units; the gain is unchanged.
    pub(crate) fn in_time(mut self, power: i32) -> Self {
        for pole in &mut self.poles {
            *pole = Complex::new(shift(pole.re, power), shift(pole.im, power));
        }
        for error in &mut self.errors {
            *error = shift(*error, power);
        }
        self
    }
}

/// Result of the placement for `A - B K`.
struct Assigned {
    gain: DMatrix<f64>,
    achieved: Vec<Complex<f64>>,
    /// The condition of each achieved pole, in the units given.
    sensitivities: Vec<f64>,
    /// Normalised eigenvectors of the closed loop with the requested poles, in the units given.
    vectors: Eigenvectors,
    rank: usize,
    /// `|A|` in the units chosen.
    size: f64,
}

/// For several inputs, the units of the states are left as given if they differ by less than this power of two. This
/// costs at most three digits, and the conditioning that is optimised is that of the user's own coordinates.
const NEARBY: i32 = 10;

/// If the units of the states differ by no more than this power of two, the poles of the closed loop are computed in
/// the units given. This costs at most one digit, and the condition numbers need no Schur vectors.
const SLIGHT: i32 = 3;

/// `units` are those of the dual pair: `A = 2^t D^-1 As D`, `B = D^-1 Bs R`, `K = 2^t R^-1 Ks D`. `staircase` is that
/// of `(As, Bs)`, if it is known.
fn assign(
    a: &DMatrix<f64>,
    b: &DMatrix<f64>,
    requested: &RequestedPoles,
    mut units: Units,
    staircase: Option<Staircase>,
) -> Result<Assigned> {
    let (n, m) = b.shape();
    let within =
        |units: &Units| (units.dynamics(&a.transpose()).transpose(), units.outputs(&b.transpose()).transpose());
    let (mut scaled_a, mut scaled_b) = within(&units);
    let tolerance = if m == 1 { 0.0 } else { default_tolerance(n, m) * scaled_a.norm().hypot(scaled_b.norm()) };
    let staircase = staircase.unwrap_or_else(|| Staircase::new(&scaled_a, &scaled_b, tolerance));
    let scaled = requested.in_time(-units.time);
    let (rank, scaled_gain, vectors) = if m == 1 {
        let (gain, vectors) = single_input::assign(&staircase, &scaled);
        (1, gain, vectors)
    } else if requested.is_deadbeat(&staircase) {
        let gain = deadbeat::assign(&scaled_a, &scaled_b, &staircase.stairs)?;
        // The loop is defective: nothing is said of its eigenvectors.
        (staircase.stairs[0], gain, Eigenvectors::reals_first(DMatrix::identity(n, n), n))
    } else {
        if units.spread() <= NEARBY {
            units.state.fill(0);
            (scaled_a, scaled_b) = within(&units);
        }
        let found = assign_several(&scaled_a, &scaled_b, &scaled, &staircase.stairs);
        found.map_err(|error| error.in_time(units.time))?
    };
    let gain = DMatrix::from_fn(m, n, |i, j| shift(scaled_gain[(i, j)], units.time - units.output[i] + units.state[j]));
    if gain.iter().any(|x| !x.is_finite()) {
        return Err(LinalgError::Overflow { what: "the gain" });
    }
    let size = shift(scaled_a.norm(), units.time);
    let mut closed = scaled_a;
    closed.gemm(-1.0, &scaled_b, &scaled_gain, 1.0);
    let (form, sensitivities) = if spread(&units.state) <= SLIGHT {
        let given = DMatrix::from_fn(n, n, |i, j| shift(closed[(i, j)], units.state[j] - units.state[i]));
        let form = triangular_factor(&given)?;
        let sensitivities = conditions(&form, &vec![0; n]);
        (form, sensitivities)
    } else {
        let form = schur(&closed)?;
        let sensitivities = conditions(&form, &units.state);
        (form, sensitivities)
    };
    let achieved = form
        .eigenvalues()
        .into_iter()
        .map(|x| Complex::new(shift(x.re, units.time), shift(x.im, units.time)))
        .collect();
    let vectors = vectors.in_units(units.state.iter().map(|power| -power)).normalised();
    Ok(Assigned { gain, achieved, sensitivities, vectors, rank, size })
}

/// Rank of B, gain, and normalised eigenvectors, for any number of inputs, linearly dependent or not.
fn assign_several(
    a: &DMatrix<f64>,
    b: &DMatrix<f64>,
    requested: &RequestedPoles,
    stairs: &[usize],
) -> Result<(usize, DMatrix<f64>, Eigenvectors)> {
    let (n, m) = b.shape();
    let svd = svd(view(b)).ok_or_else(|| LinalgError::NotConverged {
        method: "singular values of B",
        iterations: 0,
        remaining: f64::NAN,
        allowed: default_tolerance(n, m),
    })?;
    let sigma = svd.sigma;
    let floor = default_tolerance(n, m) * sigma.first().copied().unwrap_or(0.0);
    // B of a controllable pair is not zero.
    let rank = sigma.iter().filter(|s| **s > floor).count().max(1);
    if rank > 1 {
        requested.allowed_by(stairs)?;
    }

    let u = svd.u;
    let inputs = DMatrix::from_fn(n, rank, |i, j| u[(i, j)]);
    let others = DMatrix::from_fn(n, n - rank, |i, j| u[(i, rank + j)]);
    let (orthogonal, vectors) = if rank == 1 {
        single_input::assign(&Staircase::new(a, &inputs, 0.0), requested)
    } else {
        robust::assign(a, &inputs, &others, requested)?
    };
    let v = svd.v;
    let gain = DMatrix::from_fn(m, n, |i, j| (0..rank).map(|k| v[(i, k)] / sigma[k] * orthogonal[(k, j)]).sum::<f64>());
    Ok((rank, gain, vectors))
}
