//! The control-theoretic statements of this project, evaluated from the original data.
//!
//! Each is a matrix expression over a [`Ring`], most as the text of a [label](crate::label). It is evaluated with outward
//! rounding first, and exactly if that is inconclusive. No product is rounded without a bound of its error.
//!
//! Throughout, `A` is n x n, `B` n x m, `C` p x n, `L` and `N` n x p, `K` m x n, `P` symmetric n x n (exactly
//! symmetric: symmetrise the result of a solver), `F = A - LC`.

mod contracting;
mod cubic;
mod deployed;
pub(crate) mod deployed_cubic;
mod equation;
pub(crate) mod exponential;
mod hidden;
mod interval_observer;
mod kkl;
mod left_inverse;
mod linear_system;
mod lyapunov;
mod sector;
mod spectrum;
mod super_twisting;
mod varying_periods;

pub use contracting::cascade_decrease;
pub use cubic::{accretive, cubic_dissipation, cubic_dissipation_structured};
pub use deployed::{
    CubicGains, Deployed, Deviation, ErrorBall, Format, Formats, Intermediate, NoErrorBallReason, Operation, Running,
    SampledPlant, Step, Stored, deployed_linear, deployed_sampled_cubic, saturated_decrease,
};
pub use deployed_cubic::{DeployedCubic, Ellipsoid, Reach, deployed_cubic};
pub(crate) use deployed_cubic::{deployed_cubic_knowing, structured_for};
pub use equation::{ELIMINATION_ORDER, Enclosed, Enclosure, lyapunov_solution, stein_solution};
pub use hidden::{HIDDEN_ORDER, HiddenMotion, hidden_motion, hurwitz_spectrum, schur_spectrum};
pub use interval_observer::{BlockCoordinates, HeldPlant, SampledBounds, SampledIntervals, held_plant};
pub(crate) use interval_observer::{entries_at_least, product_up, rounding, units};
pub(crate) use kkl::{Axes, Composition, Expressions};
pub(crate) use left_inverse::{Product, Stacked, times_left_inverse};
pub(crate) use lyapunov::largest_eigenvalue_bound;
pub use lyapunov::{
    decay_rate, decay_rate_within, hurwitz, lyapunov_decrease, overshoot_bound, positive, stein_decrease,
};
pub use sector::{SectorTerm, sector_decrease, sector_decrease_within};
pub use spectrum::{schur_stable, spectral_abscissa, spectral_radius};
pub use super_twisting::super_twisting;
pub(crate) use varying_periods::Effort;
pub use varying_periods::decrease_over_times;

use crate::definite::{self, Direction, Sense};
use crate::error::ProofError;
use crate::exact::Exact;
use crate::interval::Interval;
use crate::matrix::Matrix;
use crate::ring::Ring;
use crate::verdict::Verdict;

/// Continuous or discrete time.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum TimeDomain {
    /// `e' = F e + G w`.
    Continuous,
    /// `e+ = F e + G w`.
    Discrete,
}

/// Largest order for exact evaluation: a product costs n^3 exact multiplications, about 1 s at this order.
pub(crate) const EXACT_ORDER: usize = 160;

/// A matrix as an expression in the data, over any ring.
pub(crate) trait Expression {
    fn evaluate<R: Ring>(&self) -> Result<Matrix<R>, ProofError>;

    /// Decides the definiteness of the expression, which must be symmetric.
    fn decide(&self, sense: Sense) -> Result<Verdict<Direction>, ProofError> {
        let enclosed: Matrix<Interval> = self.evaluate()?;
        let verdict = definite::decide(&enclosed, sense)?;
        if matches!(verdict, Verdict::Undecided { .. }) && enclosed.rows() <= EXACT_ORDER {
            return definite::decide(&self.evaluate::<Exact>()?, sense);
        }
        Ok(verdict)
    }
}

impl Expression for Matrix<f64> {
    fn evaluate<R: Ring>(&self) -> Result<Matrix<R>, ProofError> {
        Matrix::embed(self, "the matrix")
    }
}

/// Embeds a matrix of data into the ring, after a check of its shape.
fn embed<R: Ring>(data: &Matrix<f64>, what: &'static str, shape: (usize, usize)) -> Result<Matrix<R>, ProofError> {
    data.expect_shape(what, shape)?;
    Matrix::embed(data, what)
}

/// Embeds a number.
pub(crate) fn number<R: Ring>(x: f64, what: &'static str) -> Result<R, ProofError> {
    R::from_f64(x).ok_or(ProofError::NotFinite { what, row: 0, column: 0, value: x })
}

/// Embeds a matrix that must be symmetric of the given order.
pub(crate) fn embed_symmetric<R: Ring>(
    data: &Matrix<f64>,
    what: &'static str,
    order: usize,
) -> Result<Matrix<R>, ProofError> {
    let embedded = embed(data, what, (order, order))?;
    for row in 0..order {
        for column in row + 1..order {
            let (upper, lower) = (data[(row, column)], data[(column, row)]);
            if upper != lower {
                return Err(ProofError::NotSymmetric { what, row, column, upper, lower });
            }
        }
    }
    Ok(embedded)
}

/// Upper bound of the Frobenius norm, hence of the spectral norm; 0 for the zero matrix.
fn norm_bound(m: &Matrix<Interval>) -> f64 {
    let square = m.as_slice().iter().fold(0.0_f64, |sum, x| {
        let x = x.magnitude();
        if x == 0.0 { sum } else { (sum + (x * x).next_up()).next_up() }
    });
    if square == 0.0 { 0.0 } else { square.sqrt().next_up() }
}
