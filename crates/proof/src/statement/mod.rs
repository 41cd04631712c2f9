//! The control-theoretic statements of this project, evaluated from the original data.
//!
//! Each is a matrix expression over a [`Ring`]. It is evaluated with outward rounding first, and exactly if that is
//! inconclusive. No product is rounded without a bound of its error.
//!
//! Throughout, `A` is n x n, `B` n x m, `C` p x n, `L` and `N` n x p, `K` m x n, `P` symmetric n x n (exactly
//! symmetric: symmetrise the result of a solver), `F = A - LC`.

mod contracting;
mod cubic;
mod decoupling;
mod deployed;
pub(crate) mod deployed_cubic;
mod equation;
pub(crate) mod exponential;
mod feedback;
mod hidden;
mod input_to_state;
mod interval_observer;
mod kkl;
mod left_inverse;
mod linear_system;
mod lyapunov;
mod reduced_order;
mod sector;
mod semi_implicit;
mod spectrum;
mod super_twisting;
mod system_norm;
mod unknown_input;
mod varying_periods;

pub use contracting::cascade_decrease;
pub use cubic::{accretive, cubic_dissipation, cubic_dissipation_structured};
pub use decoupling::{Decoupling, Undisturbed, decoupling};
pub use deployed::{
    CubicGains, Deployed, Deviation, ErrorBall, Format, Formats, Intermediate, NoErrorBallReason, Operation, Running,
    SampledPlant, Step, Stored, deployed_linear, deployed_sampled_cubic, saturated_decrease,
};
pub(crate) use deployed_cubic::deployed_cubic_knowing;
pub use deployed_cubic::{DeployedCubic, Ellipsoid, Reach, deployed_cubic};
pub use equation::{ELIMINATION_ORDER, Enclosed, Enclosure, lyapunov_solution, stein_solution};
pub use feedback::feedback_block;
pub use hidden::{HIDDEN_ORDER, HiddenMotion, hidden_motion, hurwitz_spectrum, schur_spectrum};
pub use input_to_state::{CubicTerm, DisturbedObserver, ErrorBound, InputToState, input_to_state};
pub use interval_observer::{BlockCoordinates, HeldPlant, SampledBounds, SampledIntervals, held_plant};
pub(crate) use interval_observer::{entries_at_least, product_up, rounding, units};
pub(crate) use kkl::{Axes, Composition, Expressions};
pub(crate) use lyapunov::largest_eigenvalue_bound;
pub use lyapunov::{
    contraction_within, decay_rate, decay_rate_within, hurwitz, lyapunov_decrease, overshoot_bound, positive,
    stein_decrease,
};
pub use reduced_order::{ReducedOrder, reduced_order};
pub use sector::{SectorTerm, sector_decrease, sector_decrease_within};
pub use semi_implicit::{semi_implicit_decrease, semi_implicit_room};
pub use spectrum::{schur_stable, spectral_abscissa, spectral_radius};
pub use super_twisting::super_twisting;
pub use system_norm::{ErrorSystem, TimeDomain, bounded_real, bounded_variance};
pub use unknown_input::{Decoupled, UnknownInput, unknown_input};
pub(crate) use varying_periods::Effort;
pub use varying_periods::decrease_over_times;

use crate::definite::{self, Direction, Sense};
use crate::error::ProofError;
use crate::exact::Exact;
use crate::interval::Interval;
use crate::matrix::Matrix;
use crate::ring::Ring;
use crate::verdict::Verdict;

/// Largest order for exact evaluation: a product costs n^3 exact multiplications, about 1 s at this order.
const EXACT_ORDER: usize = 160;

/// A matrix as an expression in the data, over any ring.
trait Expression {
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
fn number<R: Ring>(x: f64, what: &'static str) -> Result<R, ProofError> {
    R::from_f64(x).ok_or(ProofError::NotFinite { what, row: 0, column: 0, value: x })
}

/// Embeds a matrix that must be symmetric of the given order.
fn embed_symmetric<R: Ring>(data: &Matrix<f64>, what: &'static str, order: usize) -> Result<Matrix<R>, ProofError> {
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
