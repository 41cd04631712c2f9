//! Observability and detectability of a pair `(A, C)`: the rank, the modes, and the unobservable directions.
//!
//! `(A, C)` is observable iff `[A - lambda I; C]` has full column rank for every complex `lambda` (Popov, Belevitch,
//! Hautus); it can fail only at eigenvalues of `A`, and a vector `v` with `A v = lambda v`, `C v = 0` is a motion
//! `e^{lambda t} v` that leaves no trace in `y = C x`. The pair is detectable iff every such motion decays.
//!
//! Two methods side by side. The *rank*, and the unobservable modes themselves, come from the orthogonal staircase,
//! which is right for defective modes too; the *margin* of each mode is the smallest singular value of
//! `[A - lambda I; C]`, from the Schur form. Where the margins show more hidden modes than the stairs, the stairs are
//! judged again, less finely.
//!
//! # What the answers do not depend on
//! Everything is decided in units of state, output and time that are chosen from the data first (powers of two, exact).
//! Neither the rank nor the margins change, up to the rounding of these powers to whole ones, when a state or an output
//! is measured in other units (`A -> D^-1 A D`, `C -> R C D` with diagonal `D`, `R`) or time is (`A -> s A`). The
//! price: there is no such thing as a small entry by itself. `A = diag(-1, -2)`, `C = [1, 1e-17]` is `C = [1, 1]` with
//! the second state in other units, and is observable; [`Observability::units`] then shows units 17 decades apart. An
//! entry that is 1e-17 by rounding and should be zero has to be zero in the data, unless the entries around it outvote
//! it.

use nalgebra::{Complex, DMatrix, DVector};

use crate::argument::{RealMatrixView, owned, shaped, square};
use crate::least_visible::least_visible;
use crate::schur::{Schur, schur};
use crate::staircase::Staircase;
use crate::subspace_refinement;
use crate::units::{Units, shift};
use crate::{LinalgError, Result};

/// One eigenvalue of `A` with its margin of observability.
#[derive(Debug, Clone, PartialEq)]
pub struct Mode {
    /// The eigenvalue.
    pub eigenvalue: Complex<f64>,
    /// `sigma_min([A - lambda I; C]) / |[A; C]|` (Frobenius norm) in the units chosen: 0 if no output sees the mode. It
    /// bounds from above the relative distance of the pair to one with a hidden mode.
    pub margin: f64,
    /// The least observable direction, which attains that minimum, as a unit vector `v` in the units given: for a
    /// hidden mode `A v = lambda v`, `C v = 0`. The largest component is real and positive; for a real eigenvalue all
    /// are real.
    pub direction: DVector<Complex<f64>>,
    /// How many independent directions attain the minimum to seven digits: with more than one, `direction` is one of
    /// them by chance. 1 where there are more than 64 states, for which they are not counted.
    pub directions: usize,
}

/// States up to which the directions of a mode are counted.
const MOST_STATES_COUNTED: usize = 64;

/// Observability of a pair `(A, C)`: rank, modes with margins, unobservable subspace.
#[derive(Debug, Clone, PartialEq)]
pub struct Observability {
    /// Number of states.
    pub order: usize,
    /// Rank of the observability matrix, from the staircase: the order of the observable part.
    pub rank: usize,
    /// Every eigenvalue of `A` with its margin and its least visible direction.
    pub modes: Vec<Mode>,
    /// The hidden modes: the eigenvalues of the unobservable part, `order - rank` of them.
    pub unobservable: Vec<Mode>,
    /// Orthonormal basis of the unobservable subspace, n x (n - rank): `C V = 0`, and `A V` lies in its span.
    pub subspace: DMatrix<f64>,
    /// The relative tolerance of the rank decisions: stairs and margins at or below it count as zero.
    pub tolerance: f64,
    /// The unit of each state in which the pair was judged, a power of two: `x_j = units[j] z_j`.
    pub units: Vec<f64>,
}

impl Observability {
    /// Whether the pair is observable: the rank is n.
    pub fn is_observable(&self) -> bool {
        self.rank == self.order
    }

    /// The mode with the smallest margin, hidden ones included; none if there is no state.
    pub fn weakest(&self) -> Option<&Mode> {
        self.unobservable.iter().chain(&self.modes).min_by(|x, y| x.margin.total_cmp(&y.margin))
    }
}

/// Observability of `x' = A x, y = C x` (and of the discrete pair: the notion is the same).
///
/// `a` is n x n, `c` p x n; p = 0 is allowed. The relative tolerance is `10 max(n, p) eps`: a chain of n orthogonal
/// steps on rounded data cannot tell smaller numbers from zero. [`observability_within`] takes another one.
///
/// # Errors
/// [`LinalgError::NotSquare`], [`LinalgError::DimensionMismatch`], [`LinalgError::NotFinite`], [`LinalgError::Empty`];
/// that of [`schur`] if its iteration does not converge.
///
/// # Cost
/// About `40 n^3 + 24 p n^3` flops, most of them for the margins; up to 64 states a decomposition of a
/// complex matrix for each mode besides.
///
/// # Example
/// Two equal masses on springs, and the difference of the positions as the output: the common motion is hidden.
/// ```
/// use luenberger_linalg::observability;
/// use nalgebra::{Complex, dmatrix};
///
/// let a = dmatrix![0.0, 0.0, 1.0, 0.0; 0.0, 0.0, 0.0, 1.0; -2.0, 1.0, 0.0, 0.0; 1.0, -2.0, 0.0, 0.0];
/// let c = dmatrix![1.0, -1.0, 0.0, 0.0];
/// let seen = observability(&a, &c)?;
/// assert_eq!((seen.rank, seen.order), (2, 4));
/// for mode in &seen.unobservable {
///     let v = &mode.direction;
///     let residual = (a.map(Complex::from) * v - v * mode.eigenvalue).norm() + (c.map(Complex::from) * v).norm();
///     println!("hidden: {} along {v}, residual {residual:e}", mode.eigenvalue);
///     assert!(residual < 1e-14);
///     assert!((mode.eigenvalue.norm() - 1.0).abs() < 1e-14);
/// }
/// # Ok::<(), luenberger_linalg::LinalgError>(())
/// ```
///
/// Source: Hautus, Indag. Math. 31, 1969; Paige, IEEE TAC 26, 1981.
pub fn observability<'a>(a: impl Into<RealMatrixView<'a>>, c: impl Into<RealMatrixView<'a>>) -> Result<Observability> {
    let (a, c) = (owned(a), owned(c));
    observed(&a, &c, default_tolerance(a.nrows(), c.nrows()))
}

/// [`observability`] with a relative tolerance supplied by the user, for data known to fewer digits than a double has.
///
/// `tolerance` is the relative size below which a stair of the staircase counts as zero, in the units the pair is
/// judged in.
///
/// # Errors
/// As [`observability`]; [`LinalgError::InvalidTolerance`] if `tolerance` is negative, infinite or NaN.
pub fn observability_within<'a>(
    a: impl Into<RealMatrixView<'a>>,
    c: impl Into<RealMatrixView<'a>>,
    tolerance: f64,
) -> Result<Observability> {
    observed(&owned(a), &owned(c), tolerance)
}

fn observed(a: &DMatrix<f64>, c: &DMatrix<f64>, tolerance: f64) -> Result<Observability> {
    check(a, c)?;
    if !(tolerance >= 0.0 && tolerance.is_finite()) {
        return Err(LinalgError::InvalidTolerance { tolerance });
    }
    let judged = Judged::new(a, c, tolerance)?;
    Ok(Observability {
        order: a.nrows(),
        rank: judged.staircase.rank,
        unobservable: judged.hidden()?,
        subspace: judged.subspace(),
        tolerance,
        units: judged.units.state.iter().map(|d| 2f64.powi(*d)).collect(),
        modes: judged.modes,
    })
}

/// The region of the complex plane whose eigenvalues decay.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum StabilityRegion {
    /// `Re lambda < 0`, of `x' = A x`.
    LeftHalfPlane,
    /// `|lambda| < 1`, of `x+ = A x`.
    UnitDisk,
}

/// Detectability of a pair `(A, C)`: whether every unobservable mode decays.
#[derive(Debug, Clone, PartialEq)]
pub struct Detectability {
    /// Where modes decay: the half plane in continuous time, the disk in discrete time.
    pub region: StabilityRegion,
    /// Number of states.
    pub order: usize,
    /// Order of the observable part.
    pub rank: usize,
    /// All hidden modes.
    pub unobservable: Vec<Mode>,
    /// The hidden modes that do not decay: those in the closed right half plane, or with `|lambda| >= 1`.
    pub undetectable_modes: Vec<Mode>,
    /// The relative tolerance of the rank decisions.
    pub tolerance: f64,
    /// A hidden mode this near to the boundary of stability counts as lying on it.
    pub boundary: f64,
}

impl Detectability {
    /// Whether the pair is detectable, so that a convergent observer exists: every hidden mode decays.
    pub fn is_detectable(&self) -> bool {
        self.undetectable_modes.is_empty()
    }
}

/// Detectability of `x' = A x, y = C x`: every hidden mode has `Re lambda < 0`, that is, some `L` makes `A - L C`
/// Hurwitz.
///
/// `a` is n x n, `c` p x n; p = 0 asks whether `A` itself is Hurwitz. A hidden eigenvalue is known to about
/// `tolerance |A|`, and one within that of the imaginary axis counts as lying on it: a drifting bias must not pass as a
/// decaying one because its 0 came out as -1e-17.
///
/// # Errors
/// As [`observability`].
///
/// # Cost
/// As [`observability`].
///
/// # Example
/// ```
/// use luenberger_linalg::detectability;
/// use nalgebra::dmatrix;
///
/// // The hidden state decays with -2, whatever the visible one does.
/// assert!(detectability(&dmatrix![1.0, 0.0; 3.0, -2.0], &dmatrix![1.0, 0.0])?.is_detectable());
/// let drifting = detectability(&dmatrix![-1.0, 0.0; 3.0, 0.0], &dmatrix![1.0, 0.0])?;
/// assert_eq!(drifting.undetectable_modes[0].eigenvalue.re, 0.0);
/// # Ok::<(), luenberger_linalg::LinalgError>(())
/// ```
///
/// Source: Wonham, Linear Multivariable Control, section 3.6; Hautus, 1970.
pub fn detectability<'a>(a: impl Into<RealMatrixView<'a>>, c: impl Into<RealMatrixView<'a>>) -> Result<Detectability> {
    detectability_in(StabilityRegion::LeftHalfPlane, &owned(a), &owned(c))
}

/// Detectability of the discrete pair `x+ = A x, y = C x`: every hidden mode has `|lambda| < 1`, that is, some `L`
/// makes `A - L C` Schur stable.
///
/// As [`detectability`], with the unit circle for the imaginary axis.
///
/// # Errors
/// As [`observability`].
///
/// # Example
/// ```
/// use luenberger_linalg::discrete_detectability;
/// use nalgebra::dmatrix;
///
/// assert!(discrete_detectability(&dmatrix![2.0, 0.0; 1.0, 0.5], &dmatrix![1.0, 0.0])?.is_detectable());
/// assert!(!discrete_detectability(&dmatrix![0.5, 0.0; 1.0, -1.0], &dmatrix![1.0, 0.0])?.is_detectable());
/// # Ok::<(), luenberger_linalg::LinalgError>(())
/// ```
pub fn discrete_detectability<'a>(
    a: impl Into<RealMatrixView<'a>>,
    c: impl Into<RealMatrixView<'a>>,
) -> Result<Detectability> {
    detectability_in(StabilityRegion::UnitDisk, &owned(a), &owned(c))
}

fn detectability_in(region: StabilityRegion, a: &DMatrix<f64>, c: &DMatrix<f64>) -> Result<Detectability> {
    check(a, c)?;
    let tolerance = default_tolerance(a.nrows(), c.nrows());
    let judged = Judged::new(a, c, tolerance)?;
    let unobservable = judged.hidden()?;
    // In the units of time given; the circle is the same in every unit of state.
    let boundary = shift(tolerance * judged.a.norm(), judged.units.time);
    let fails = |lambda: Complex<f64>| match region {
        StabilityRegion::LeftHalfPlane => lambda.re >= -boundary,
        StabilityRegion::UnitDisk => lambda.norm() >= 1.0 - boundary,
    };
    let undetectable_modes = unobservable.iter().filter(|mode| fails(mode.eigenvalue)).cloned().collect();
    Ok(Detectability {
        region,
        order: a.nrows(),
        rank: judged.staircase.rank,
        unobservable,
        undetectable_modes,
        tolerance,
        boundary,
    })
}

/// What [`seen`] finds.
pub(crate) enum Seen {
    /// The pair is observable: the staircase of `(A', C')` in the units.
    All(Staircase),
    /// The least visible of the hidden modes.
    Hidden(Mode),
}

/// Whether a pair is observable, for arguments already checked, in units already chosen; without a single eigenvalue
/// where the margin of the staircase is clear ([`Staircase::least_margin`]).
pub(crate) fn seen(units: &Units, a: &DMatrix<f64>, c: &DMatrix<f64>) -> Result<Seen> {
    let tolerance = default_tolerance(a.nrows(), c.nrows());
    let (scaled_a, scaled_c) = (units.dynamics(a), units.outputs(c));
    let size = scaled_a.norm().hypot(scaled_c.norm());
    if size.is_finite() {
        let staircase = Staircase::new(&scaled_a.transpose(), &scaled_c.transpose(), tolerance * size);
        if staircase.rank == a.nrows() && staircase.least_margin() > CLEAR_MARGIN * tolerance * size {
            return Ok(Seen::All(staircase));
        }
    }
    let judged = Judged::within(units.clone(), a, c, tolerance)?;
    let hidden = judged.hidden()?.into_iter().min_by(|x, y| x.margin.total_cmp(&y.margin));
    Ok(hidden.map_or(Seen::All(judged.staircase), Seen::Hidden))
}

/// A square, with at least one state; C of its width; both finite.
pub(crate) fn check(a: &DMatrix<f64>, c: &DMatrix<f64>) -> Result<()> {
    if square("A", a)? == 0 {
        return Err(LinalgError::Empty { what: "A" });
    }
    shaped("C", c, c.nrows(), a.nrows())
}

/// `10 max(n, p) eps`: n orthogonal steps of backward error a few eps each, on entries rounded once.
pub(crate) fn default_tolerance(n: usize, p: usize) -> f64 {
    10.0 * n.max(p) as f64 * f64::EPSILON
}

/// A pair in its units, its modes, and its staircase.
struct Judged {
    units: Units,
    a: DMatrix<f64>,
    c: DMatrix<f64>,
    /// `|[A; C]|`.
    size: f64,
    modes: Vec<Mode>,
    staircase: Staircase,
}

/// A stair is never taken as zero above this relative size, whatever the margins say.
const LARGEST_TOLERANCE: f64 = 1e-8;

/// An estimate of the least margin this many times the tolerance decides: ten for the points it looks at, as
/// much again for the one right-hand side it looks along, and for the rounding of the stairs.
const CLEAR_MARGIN: f64 = 1e3;

impl Judged {
    fn new(a: &DMatrix<f64>, c: &DMatrix<f64>, tolerance: f64) -> Result<Self> {
        Self::within(Units::of(a, c), a, c, tolerance)
    }

    fn within(units: Units, a: &DMatrix<f64>, c: &DMatrix<f64>, tolerance: f64) -> Result<Self> {
        let (a, c) = (units.dynamics(a), units.outputs(c));
        let size = a.norm().hypot(c.norm());
        if !size.is_finite() {
            return Err(LinalgError::Overflow { what: "the norm of [A; C]" });
        }
        let (modes, staircase) = judge(&units, &a, &c, tolerance, size)?;
        Ok(Self { units, a, c, size, modes, staircase })
    }

    /// The last n - rank columns of the staircase's Q: orthonormal, of the unobservable subspace.
    fn unobservable_basis(&self) -> DMatrix<f64> {
        let rank = self.staircase.rank;
        self.staircase.q.columns(rank, self.a.nrows() - rank).into_owned()
    }

    fn hidden(&self) -> Result<Vec<Mode>> {
        let (n, rank) = (self.a.nrows(), self.staircase.rank);
        if rank == n {
            return Ok(Vec::new());
        }
        // A Q2 = Q2 Fu', the order of the block that no output reaches.
        let block = self.staircase.f.view((rank, rank), (n - rank, n - rank)).transpose();
        let none = DMatrix::zeros(0, n - rank);
        let mut hidden = modes_of(&self.units, &self.a, &self.c, &schur(&block)?, &self.unobservable_basis(), &none)?;
        // The staircase is right for defective modes; for the others the whole pair may know the mode better.
        let mut used = vec![false; n];
        let near = LARGEST_TOLERANCE * shift(self.size, self.units.time);
        for mode in &mut hidden {
            let distance = |k: usize| (self.modes[k].eigenvalue - mode.eigenvalue).norm();
            let nearest = (0..n).filter(|k| !used[*k]).min_by(|j, k| distance(*j).total_cmp(&distance(*k)));
            if let Some(k) = nearest.filter(|k| distance(*k) <= near) {
                used[k] = true;
                if self.modes[k].margin < mode.margin {
                    mode.clone_from(&self.modes[k]);
                }
            }
        }
        Ok(hidden)
    }

    /// Orthonormal basis of `D` times that basis. Elimination with complete pivoting first: it keeps the small rows of
    /// a graded matrix accurate, where a QR of it would lose them in the large ones. O(n k^2) and the pivot search, n
    /// k^2 too.
    fn subspace(&self) -> DMatrix<f64> {
        let mut v = self.unobservable_basis();
        let (n, k) = v.shape();
        let mean = self.units.state.iter().map(|d| f64::from(*d)).sum::<f64>() / n as f64;
        for (j, d) in self.units.state.iter().enumerate() {
            let power = d - mean.round() as i32;
            v.row_mut(j).iter_mut().for_each(|x| *x = shift(*x, power));
        }
        let mut free: Vec<usize> = (0..n).collect();
        for step in 0..k {
            let mut best = (0, step, 0.0);
            for (at, row) in free.iter().enumerate() {
                for column in step..k {
                    if v[(*row, column)].abs() > best.2 {
                        best = (at, column, v[(*row, column)].abs());
                    }
                }
            }
            if best.2 == 0.0 {
                break;
            }
            let row = free.swap_remove(best.0);
            v.swap_columns(step, best.1);
            let pivot = v[(row, step)];
            v.column_mut(step).iter_mut().for_each(|x| *x /= pivot);
            for column in (0..k).filter(|column| *column != step) {
                let factor = v[(row, column)];
                if factor != 0.0 {
                    let eliminated = v.column(column) - v.column(step) * factor;
                    v.set_column(column, &eliminated);
                    v[(row, column)] = 0.0;
                }
            }
        }
        gram_schmidt(v)
    }
}

/// The modes and the staircase of a pair in its units; `tolerance` is relative to `size`.
fn judge(
    units: &Units,
    a: &DMatrix<f64>,
    c: &DMatrix<f64>,
    tolerance: f64,
    size: f64,
) -> Result<(Vec<Mode>, Staircase)> {
    let stairs = |tolerance: f64| Staircase::new(&a.transpose(), &c.transpose(), tolerance * size);
    let mut staircase = stairs(tolerance);
    let modes = modes_of(units, a, c, &schur(a)?, &DMatrix::identity(a.nrows(), a.nrows()), c)?;
    // A small stair that counts (two outputs that almost agree) magnifies the rounding noise in the stairs below it.
    // The margins do not suffer from that: where they show more hidden modes, a stair somewhat above the tolerance was
    // noise.
    let hidden = modes.iter().filter(|mode| mode.margin <= tolerance).count();
    let mut larger_tolerance = 10.0 * tolerance;
    while a.nrows() - staircase.rank < hidden && larger_tolerance <= LARGEST_TOLERANCE && larger_tolerance > 0.0 {
        let other = stairs(larger_tolerance);
        if a.nrows() - other.rank <= hidden {
            staircase = other;
        }
        larger_tolerance *= 10.0;
    }
    subspace_refinement::refine(&mut staircase, a, c, size)?;
    Ok((modes, staircase))
}

/// The staircase of `(A', C')` for a pair already in its units, part of something of norm `size`: the last columns of
/// its Q span what C does not see.
pub(crate) fn staircase_within(a: &DMatrix<f64>, c: &DMatrix<f64>, tolerance: f64, size: f64) -> Result<Staircase> {
    Ok(judge(&Units::given(a.nrows(), c.nrows()), a, c, tolerance, size)?.1)
}

/// The modes of `block = Q T Q'` living on the columns of `basis`, seen by `outputs` (in the coordinates of the block).
/// The margin is that of the direction found in the whole pair.
fn modes_of(
    units: &Units,
    a: &DMatrix<f64>,
    c: &DMatrix<f64>,
    block: &Schur,
    basis: &DMatrix<f64>,
    outputs: &DMatrix<f64>,
) -> Result<Vec<Mode>> {
    let outputs = outputs * &block.q;
    let basis = (basis * &block.q).map(Complex::from);
    let (a, c) = (a.map(Complex::from), c.map(Complex::from));
    let size = a.norm().hypot(c.norm());
    let mut modes: Vec<Mode> = Vec::new();
    for lambda in block.eigenvalues() {
        let eigenvalue = Complex::new(shift(lambda.re, units.time), shift(lambda.im, units.time));
        // A conjugate pair is computed once.
        if let Some(twin) = modes.last().filter(|m| lambda.im != 0.0 && m.eigenvalue == eigenvalue.conj()) {
            let (margin, direction) = (twin.margin, twin.direction.map(|x| x.conj()));
            modes.push(Mode { eigenvalue, margin, direction, directions: twin.directions });
            continue;
        }
        let z = &basis * least_visible(&block.t, &outputs, lambda)?;
        let motion = &a * &z - &z * lambda;
        let trace = &c * &z;
        let margin = if size > 0.0 { motion.norm().hypot(trace.norm()) / size } else { 0.0 };
        let directions = directions(&a, &c, lambda, size);
        modes.push(Mode { eigenvalue, margin, direction: in_given_units(units, &z), directions });
    }
    Ok(modes)
}

/// How many singular values of `[A - lambda I; C]` are the smallest one, to seven digits or the rounding of `size`.
fn directions(a: &DMatrix<Complex<f64>>, c: &DMatrix<Complex<f64>>, lambda: Complex<f64>, size: f64) -> usize {
    let n = a.nrows();
    if n > MOST_STATES_COUNTED {
        return 1;
    }
    let mut both = DMatrix::<Complex<f64>>::zeros(n + c.nrows(), n);
    both.rows_mut(0, n).copy_from(a);
    both.rows_mut(n, c.nrows()).copy_from(c);
    for i in 0..n {
        both[(i, i)] -= lambda;
    }
    // Bounded iterations; without an answer nothing is known of others.
    let Some(svd) = both.try_svd(false, false, f64::EPSILON, 1000) else { return 1 };
    let least = svd.singular_values.iter().copied().fold(f64::INFINITY, f64::min);
    let limit = least * (1.0 + 1e-7) + 64.0 * f64::EPSILON * size;
    svd.singular_values.iter().filter(|value| **value <= limit).count().max(1)
}

/// A direction in the units given, normalised.
fn in_given_units(units: &Units, z: &DVector<Complex<f64>>) -> DVector<Complex<f64>> {
    // Relative to the largest product, so that no power overflows.
    let top = z
        .iter()
        .zip(&units.state)
        .filter(|(z, _)| z.norm() > 0.0)
        .map(|(z, d)| z.norm().log2() + f64::from(*d))
        .fold(f64::NEG_INFINITY, f64::max);
    let top = if top.is_finite() { top.round() as i32 } else { 0 };
    let mut v = DVector::from_fn(z.len(), |j, _| {
        let power = units.state[j] - top;
        Complex::new(shift(z[j].re, power), shift(z[j].im, power))
    });
    let largest =
        v.iter().fold(Complex::from(0.0), |best: Complex<f64>, x| if x.norm() > best.norm() { *x } else { best });
    if largest.norm() > 0.0 {
        let factor = largest.conj() / (largest.norm() * v.norm());
        v *= factor;
    }
    v
}

/// Orthonormal columns by Gram-Schmidt, twice: unlike Householder's method it leaves each row an error of the size of
/// that row. The reduced columns are nearly independent, so that twice is enough for orthogonality to rounding.
fn gram_schmidt(mut v: DMatrix<f64>) -> DMatrix<f64> {
    for k in 0..v.ncols() {
        let mut column = v.column(k).into_owned();
        for _ in 0..2 {
            for previous in 0..k {
                let projection = v.column(previous).dot(&column);
                column.axpy(-projection, &v.column(previous), 1.0);
            }
            let norm = column.norm();
            if norm > 0.0 {
                column /= norm;
            }
        }
        v.set_column(k, &column);
    }
    v
}
