//! Linear matrix equations whose separation is no larger than rounding.
//!
//! A small separation says that some change of the coefficients within their rounding makes the equation singular. It
//! does not say that the substitution makes such a change: a matrix that is triangular as given is its own Schur form,
//! and the substitution with it may be right to the last digits. Three things are tried.
//!
//! - *Integers* (`exactly_singular.rs`) decide whether the equation is regular or singular as stored. Only this calls
//!   an equation singular.
//! - *The defect in twice the working precision.* With S the substitution and L the operator, `E = I - S L` takes the
//!   error of a solution to that of the refined one. Measured is how much E shrinks `S C` for random C, in which the
//!   directions of a small separation prevail: what L nearly loses and S does not follow, E keeps whole. Where it
//!   shrinks them at least to `RATE`, refinement converges to the exact solution or is seen not to, and the correction
//!   at which it stops measures the error.
//! - *Otherwise* the answer is the error that says so, with the separation and the digits that the condition asks for.

use crate::LinalgError;
use crate::exactly_singular::Regularity;
use crate::forward_error::relative;
use nalgebra::{Complex, DMatrix};

/// A refinement that reduces the error by less than this factor is not used.
pub(crate) const RATE: f64 = 0.25;

/// A bound of the forward error above this calls for refinement.
pub(crate) const DIGIT: f64 = 0.1;

/// What the separation says of an equation.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Standing {
    /// The bound of the forward error leaves a digit at least.
    Clear,
    /// It is not.
    Doubtful,
    /// The separation is rounding.
    Rounding,
}

/// By how much a refinement shrinks errors that are solutions for random right-hand sides, in which the directions of a
/// small separation prevail: the worst factor of three times three, infinite where one is beyond `RATE`.
/// `correct(c, x)` is the correction of `x` for the right-hand side c.
pub fn contraction(
    shape: (usize, usize),
    symmetric: bool,
    mut correct: impl FnMut(&DMatrix<f64>, &DMatrix<f64>) -> DMatrix<f64>,
) -> f64 {
    let mut state = 1_u64;
    let mut random = || {
        state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (state >> 11) as f64 / 2.0_f64.powi(52) - 1.0
    };
    let zero = DMatrix::zeros(shape.0, shape.1);
    let mut worst = 0.0_f64;
    for _ in 0..3 {
        let mut c = DMatrix::from_fn(shape.0, shape.1, |_, _| random());
        if symmetric {
            c = (&c + c.transpose()) * 0.5;
        }
        let mut x = correct(&c, &zero);
        for _ in 0..3 {
            let size = x.norm();
            x += correct(&zero, &x);
            let rate = relative(x.norm(), size);
            if rate.is_nan() || rate > RATE {
                return f64::INFINITY;
            }
            worst = worst.max(rate);
        }
    }
    worst
}

/// Refines `x` until nothing changes, for an equation with this contraction. A bound of its error relative to its size,
/// as far as the contraction is one for all errors. `None` if the corrections do not become small.
pub fn refined(x: &mut DMatrix<f64>, rate: f64, mut correct: impl FnMut(&DMatrix<f64>) -> DMatrix<f64>) -> Option<f64> {
    let mut last = 1.0;
    for _ in 0..60 {
        let correction = correct(x);
        let moved = relative(correction.norm(), x.norm());
        if moved.is_nan() || moved >= 1.0 {
            return None;
        }
        if moved >= 0.5 * last {
            // The error is the sum of this correction and all that would follow, and the rounding of x; the correction
            // itself is rounded, and may be ten times too small.
            let order = x.nrows().max(x.ncols()) as f64;
            return (moved <= RATE).then_some(10.0 * moved / (1.0 - rate) + order * f64::EPSILON);
        }
        *x += correction;
        last = moved;
    }
    None
}

/// The two eigenvalues that are nearest to making an equation singular.
#[derive(Debug, Clone, Copy)]
pub struct Closest {
    /// Of the left coefficient.
    pub first: Complex<f64>,
    /// Of the right one.
    pub second: Complex<f64>,
    /// How far the two are from a singular equation.
    pub gap: f64,
}

impl Closest {
    pub(crate) fn singular(self, equation: &'static str) -> LinalgError {
        let Self { first, second, gap } = self;
        LinalgError::SingularEquation { equation, first, second, gap }
    }

    /// `stretch` is the factor from the condition to a bound of the relative error for a unit roundoff of one.
    pub fn undecided(
        self,
        equation: &'static str,
        regularity: Regularity,
        separation: f64,
        condition: f64,
        stretch: f64,
    ) -> LinalgError {
        let Self { first, second, gap } = self;
        // Three digits of the solution are to be left.
        let digits = (condition * stretch).log10().ceil() + 3.0;
        let digits = digits.is_finite().then_some(digits as u32);
        let regular = regularity == Regularity::Regular;
        LinalgError::UndecidedEquation { equation, regular, first, second, gap, separation, condition, digits }
    }
}
