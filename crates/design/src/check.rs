//! Checks of user-supplied data, each with an error that names the matrix and the value.

use luenberger_linalg::{
    Kalman, LinalgError, LyapunovEquation, RealMatrixView, balanced, detectability, discrete_detectability,
    discrete_kalman_gain, eigenvalues, kalman_gain, lambda_min, spectral_abscissa,
};
use luenberger_plants::error::check_matrix;
use luenberger_plants::{PlantError, StateSpace};
use luenberger_proof::statement::{TimeDomain, hidden_motion, hurwitz_spectrum, schur_spectrum};
use luenberger_proof::{Exact, Matrix, Ring};
use nalgebra::allocator::Allocator;
use nalgebra::{Complex, DMatrix, DefaultAllocator, Dim, OMatrix};

use crate::error::{DesignError, NearlyHidden};
use crate::unseen_modes::UnseenModes;
use luenberger_lmi::proof_matrix;

/// A matrix argument as a dynamic matrix, so that all that follows is compiled once.
pub(crate) fn owned<'a>(m: impl Into<RealMatrixView<'a>>) -> DMatrix<f64> {
    m.into().into_owned()
}

/// Shape and finiteness.
pub(crate) fn matrix(what: &'static str, m: &DMatrix<f64>, expected: (usize, usize)) -> Result<(), DesignError> {
    Ok(check_matrix(what, m, expected)?)
}

/// Shape, finiteness and [symmetry](luenberger_linalg::symmetric) up to rounding. Returns the symmetric part, which is
/// what is used from there on.
pub(crate) fn symmetric(what: &'static str, m: &DMatrix<f64>, n: usize) -> Result<DMatrix<f64>, DesignError> {
    matrix(what, m, (n, n))?;
    Ok(luenberger_linalg::symmetric(what, m)?)
}

/// The same matrix with the sizes that a plant's type fixes; `expected` are the sizes the plant declares.
pub(crate) fn sized<R: Dim, C: Dim>(
    what: &'static str,
    m: &DMatrix<f64>,
    expected: (usize, usize),
) -> Result<OMatrix<f64, R, C>, DesignError>
where
    DefaultAllocator: Allocator<R, C>,
{
    matrix(what, m, expected)?;
    let fixed = (R::try_to_usize().unwrap_or(expected.0), C::try_to_usize().unwrap_or(expected.1));
    if fixed != expected {
        return Err(PlantError::DimensionMismatch { what, expected: fixed, found: expected }.into());
    }
    Ok(OMatrix::from_iterator_generic(R::from_usize(fixed.0), C::from_usize(fixed.1), m.iter().copied()))
}

/// Symmetric and positive definite; returns the symmetric part.
pub(crate) fn positive_definite(what: &'static str, m: &DMatrix<f64>, n: usize) -> Result<DMatrix<f64>, DesignError> {
    let m = symmetric(what, m, n)?;
    Ok(luenberger_linalg::positive_definite(what, &m)?)
}

/// Symmetric and positive semidefinite up to rounding; returns the symmetric part.
pub(crate) fn positive_semidefinite(
    what: &'static str,
    m: &DMatrix<f64>,
    n: usize,
) -> Result<DMatrix<f64>, DesignError> {
    let m = symmetric(what, m, n)?;
    Ok(luenberger_linalg::positive_semidefinite(what, &m)?)
}

/// A positive, finite number.
pub(crate) fn positive(what: &'static str, value: f64) -> Result<(), DesignError> {
    if value > 0.0 && value.is_finite() { Ok(()) } else { Err(DesignError::NotPositive { what, value }) }
}

/// Finite numbers, 0 or more.
pub(crate) fn not_negative(what: &'static str, values: &[f64]) -> Result<(), DesignError> {
    match values.iter().find(|value| !(**value >= 0.0 && value.is_finite())) {
        Some(&value) => Err(DesignError::Negative { what, value }),
        None => Ok(()),
    }
}

/// A number of the settings between these bounds.
pub(crate) fn within(what: &'static str, value: f64, least: f64, most: f64) -> Result<(), DesignError> {
    if (least..=most).contains(&value) { Ok(()) } else { Err(DesignError::Setting { what, value, least, most }) }
}

/// The matrix in exact arithmetic; its entries are finite.
pub(crate) fn exactly(m: &DMatrix<f64>) -> Result<Matrix<Exact>, DesignError> {
    Ok(Matrix::embed(&proof_matrix(m), "a matrix")?)
}

/// `A - L C` without rounding.
pub(crate) fn exact_closed_loop(
    a: &DMatrix<f64>,
    l: &DMatrix<f64>,
    c: &DMatrix<f64>,
) -> Result<Matrix<Exact>, DesignError> {
    let lc = exactly(l)?.product(&exactly(c)?)?;
    let a = exactly(a)?;
    Ok(Matrix::from_fn(a.rows(), a.cols(), |i, j| a[(i, j)].sub(&lc[(i, j)])))
}

/// `A - L C` (or `A - B K`) has all eigenvalues in the open left half plane; returns the spectral abscissa in floating
/// point, which rounding can make 0 or more. Where floating point finds it so, the error is said of the matrix
/// multiplied out exactly.
pub(crate) fn hurwitz(
    what: &'static str,
    (a, l, c): (&DMatrix<f64>, &DMatrix<f64>, &DMatrix<f64>),
) -> Result<f64, DesignError> {
    decided(what, spectral_abscissa(&(a - l * c))?, (a, l, c))
}

/// Whether `A - L C` is Hurwitz, of which floating point finds this spectral abscissa.
fn decided(
    what: &'static str,
    abscissa: f64,
    (a, l, c): (&DMatrix<f64>, &DMatrix<f64>, &DMatrix<f64>),
) -> Result<f64, DesignError> {
    if abscissa < 0.0 {
        return Ok(abscissa);
    }
    match hurwitz_spectrum(&exact_closed_loop(a, l, c)?) {
        // In the units given its sign was lost.
        Some(true) => Ok(spectral_abscissa(&balanced(&(a - l * c))?.matrix).unwrap_or(abscissa).min(abscissa)),
        Some(false) => Err(DesignError::NotHurwitz { what, abscissa }),
        None => Err(DesignError::StabilityUndecided { what, size: abscissa, limit: 0.0 }),
    }
}

/// `A - L C`, each entry rounded once.
pub(crate) fn closed_loop(pair: (&DMatrix<f64>, &DMatrix<f64>, &DMatrix<f64>)) -> Result<DMatrix<f64>, DesignError> {
    let (a, l, c) = pair;
    let exact = exact_closed_loop(a, l, c)?;
    Ok(DMatrix::from_fn(exact.rows(), exact.cols(), |i, j| exact[(i, j)].round_down()))
}

/// Where no P is proved: an error if `A - L C` is not Hurwitz, decided exactly. Nothing is said where it is undecided.
pub(crate) fn not_refuted(
    what: &'static str,
    abscissa: f64,
    (a, l, c): (&DMatrix<f64>, &DMatrix<f64>, &DMatrix<f64>),
) -> Result<(), DesignError> {
    match hurwitz_spectrum(&exact_closed_loop(a, l, c)?) {
        Some(false) => Err(DesignError::NotHurwitz { what, abscissa }),
        _ => Ok(()),
    }
}

/// `A - L C` has all eigenvalues inside the unit circle, of which floating point finds this spectral radius. Where
/// `settled` is false, exact arithmetic is asked although the radius is below 1.
pub(crate) fn schur_stable(
    what: &'static str,
    (radius, settled): (f64, bool),
    (a, l, c): (&DMatrix<f64>, &DMatrix<f64>, &DMatrix<f64>),
) -> Result<(), DesignError> {
    if radius < 1.0 && settled {
        return Ok(());
    }
    match schur_spectrum(&exact_closed_loop(a, l, c)?) {
        Some(false) => Err(DesignError::NotSchur { what, radius }),
        None if radius >= 1.0 => Err(DesignError::StabilityUndecided { what, size: radius, limit: 1.0 }),
        _ => Ok(()),
    }
}

/// As [`hurwitz`], for eigenvalues that are computed already.
pub(crate) fn stable_poles(
    what: &'static str,
    poles: &[Complex<f64>],
    pair: (&DMatrix<f64>, &DMatrix<f64>, &DMatrix<f64>),
) -> Result<(), DesignError> {
    decided(what, poles.iter().map(|pole| pole.re).fold(f64::NEG_INFINITY, f64::max), pair).map(|_| ())
}

/// A stable `F = A - L C` (or `A - B K`): its spectrum, and its Lyapunov equation, from one Schur form.
pub(crate) struct StableLoop {
    pub(crate) poles: Vec<Complex<f64>>,
    equation: Result<LyapunovEquation, LinalgError>,
}

impl StableLoop {
    /// # Errors
    /// As [`hurwitz`].
    pub(crate) fn new(
        what: &'static str,
        (a, l, c): (&DMatrix<f64>, &DMatrix<f64>, &DMatrix<f64>),
    ) -> Result<Self, DesignError> {
        let f = a - l * c;
        let equation = LyapunovEquation::new(&f);
        // The equation is refused where it is singular, which a stable F is to rounding at most.
        let poles = equation.as_ref().map_or_else(|_| eigenvalues(&f), |equation| Ok(equation.eigenvalues()))?;
        stable_poles(what, &poles, (a, l, c))?;
        Ok(Self { poles, equation })
    }

    /// P of `F'P + P F + Q = 0`.
    pub(crate) fn lyapunov(self, q: &DMatrix<f64>) -> Result<DMatrix<f64>, DesignError> {
        Ok(self.equation?.solve(q)?.p)
    }
}

/// `P^-1 B` for a P that must be positive definite.
pub(crate) fn solve_definite(
    what: &'static str,
    p: &DMatrix<f64>,
    b: &DMatrix<f64>,
) -> Result<DMatrix<f64>, DesignError> {
    match p.clone().cholesky() {
        Some(cholesky) => Ok(cholesky.solve(b)),
        None => Err(LinalgError::NotPositiveDefinite { what, lambda_min: lambda_min(p)? }.into()),
    }
}

/// Linearly independent rows, whatever their units: the rows are scaled to length one first.
pub(crate) fn independent_outputs(c: &DMatrix<f64>) -> Result<(), DesignError> {
    let mut scaled = c.clone();
    for mut row in scaled.row_iter_mut() {
        let length = row.norm();
        if length > 0.0 {
            row /= length;
        }
    }
    let sigma_min = lambda_min(&(&scaled * scaled.transpose()))?.max(0.0).sqrt();
    // The Gram matrix squares the condition, so independence is decided down to sqrt(n EPSILON).
    if sigma_min > (c.ncols() as f64 * f64::EPSILON).sqrt() {
        Ok(())
    } else {
        Err(DesignError::DependentOutputs { sigma_min })
    }
}

/// The plant's fields are public: what its constructor checked is checked again.
pub(crate) fn plant(plant: &StateSpace) -> Result<(), DesignError> {
    plant.clone().checked()?;
    Ok(())
}

/// A plant with fewer outputs than states, none of them dependent on others: what a reduced-order observer takes.
pub(crate) fn something_unmeasured(of: &StateSpace) -> Result<(), DesignError> {
    plant(of)?;
    let (n, p) = (of.a.nrows(), of.c.nrows());
    if p >= n {
        return Err(DesignError::NothingUnmeasured { states: n, outputs: p });
    }
    let rows = DMatrix::from_fn(p, n, |i, j| of.c[(i, j)] / of.c.row(i).norm().max(f64::MIN_POSITIVE));
    let sigma_min = rows.svd(false, false).singular_values.min();
    if sigma_min <= n as f64 * f64::EPSILON {
        return Err(DesignError::DependentOutputs { sigma_min });
    }
    Ok(())
}

/// A finite decay rate, zero or more.
pub(crate) fn rate(rate: f64) -> Result<(), DesignError> {
    if rate >= 0.0 && rate.is_finite() { Ok(()) } else { Err(DesignError::BadRate { rate }) }
}

/// `(A + rate I, C)` detectable: every unobservable mode of A decays faster than `exp(-rate t)`. The error is decided
/// exactly for the numbers as stored; a mode that is unobservable only to working precision is returned.
pub(crate) fn detectable(a: &DMatrix<f64>, c: &DMatrix<f64>, rate: f64) -> Result<Option<NearlyHidden>, DesignError> {
    let n = a.nrows();
    let pair = detectability(&(a + DMatrix::identity(n, n) * rate), c)?;
    let Some(mode) = pair.undetectable_modes.first() else { return Ok(None) };
    let (eigenvalue, margin) = (mode.eigenvalue - Complex::new(rate, 0.0), mode.margin);
    let hidden = hidden_motion(&proof_matrix(a), &proof_matrix(c))?;
    if hidden.and_then(|hidden| hidden.decays_at(rate)) == Some(false) {
        return Err(DesignError::NotDetectable { eigenvalue, margin, rate });
    }
    Ok(Some(NearlyHidden { place: None, eigenvalue, margin }))
}

/// The same of `x+ = A x`: every unobservable mode falls at each step by more than the factor, that of this rate.
pub(crate) fn detectable_in_steps(
    a: &DMatrix<f64>,
    c: &DMatrix<f64>,
    (rate, factor): (f64, f64),
) -> Result<Option<NearlyHidden>, DesignError> {
    let pair = discrete_detectability(&(a / factor), c)?;
    let Some(mode) = pair.undetectable_modes.first() else { return Ok(None) };
    let (eigenvalue, margin) = (mode.eigenvalue * factor, mode.margin);
    let hidden = hidden_motion(&proof_matrix(a), &proof_matrix(c))?;
    if hidden.and_then(|hidden| hidden.falls_by(factor)) == Some(false) {
        return Err(DesignError::NotDetectable { eigenvalue, margin, rate });
    }
    Ok(Some(NearlyHidden { place: None, eigenvalue, margin }))
}

/// The Kalman gain of V > 0. Where V is singular to rounding in the units given, the outputs get units in which its
/// diagonal is about 1.
pub(crate) fn kalman(
    time: TimeDomain,
    (a, c): (&DMatrix<f64>, &DMatrix<f64>),
    w: &DMatrix<f64>,
    v: &DMatrix<f64>,
) -> Result<Kalman, LinalgError> {
    match time {
        TimeDomain::Continuous => kalman_gain(a, c, w, v),
        TimeDomain::Discrete => discrete_kalman_gain(a, c, w, v),
    }
}

/// The error of a Riccati equation, which calls a plant undetectable to working precision: exact where that is decided.
pub(crate) fn undetectable(error: LinalgError, time: TimeDomain, plant: &StateSpace) -> DesignError {
    match error {
        LinalgError::NotDetectable { eigenvalue, margin }
            if UnseenModes::of(&plant.a, &plant.c, time) == UnseenModes::Remain =>
        {
            DesignError::NotDetectable { eigenvalue, margin, rate: 0.0 }
        }
        error => error.into(),
    }
}

/// (A, C) detectable in its time, as [`detectable`].
pub(crate) fn detectable_in(time: TimeDomain, a: &DMatrix<f64>, c: &DMatrix<f64>) -> Result<(), DesignError> {
    match time {
        TimeDomain::Continuous => detectable(a, c, 0.0).map(|_| ()),
        TimeDomain::Discrete => detectable_in_steps(a, c, (0.0, 1.0)).map(|_| ()),
    }
}
