//! The control-theoretic statements of this project, evaluated from the original data.
//!
//! Each is a matrix expression over a [ring](crate::Ring), most as the text of a [label](crate::label). It is evaluated
//! with outward rounding first, and exactly if that is inconclusive. No product is rounded without a bound of its
//! error.
//!
//! Throughout, `A` is n x n, `B` n x m, `C` p x n, `L` and `N` n x p, `K` m x n, `P` symmetric n x n (exactly
//! symmetric: symmetrise the result of a solver), `F = A - LC`.

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
mod spectrum;
mod varying_periods;

pub(crate) use crate::embed::{Expression, embed, embed_symmetric, number};
pub use cubic::{accretive, cubic_dissipation, cubic_dissipation_structured};
pub use deployed::{
    CubicGains, Deployed, Deviation, ErrorBall, Format, Formats, Intermediate, NoErrorBallReason, Operation, Running,
    SampledPlant, Step, Stored, deployed_linear, deployed_sampled_cubic, saturated_decrease,
};
#[cfg(feature = "all-theorems")]
pub(crate) use deployed::{RunningBound, running_bound};
#[cfg(feature = "all-theorems")]
pub(crate) use deployed_cubic::output_metric;
pub use deployed_cubic::{DeployedCubic, Ellipsoid, Reach, deployed_cubic};
pub(crate) use deployed_cubic::{deployed_cubic_knowing, structured_for};
pub use equation::{ELIMINATION_ORDER, Enclosed, Enclosure, lyapunov_solution, stein_solution};
pub use hidden::{HIDDEN_ORDER, HiddenMotion, hidden_motion, hurwitz_spectrum, schur_spectrum};
pub use interval_observer::{BlockCoordinates, HeldPlant, SampledBounds, SampledIntervals, held_plant};
pub(crate) use interval_observer::{entries_at_least, product_up, rounding, units};
pub(crate) use kkl::{Axes, Composition, Expressions};
pub(crate) use left_inverse::times_left_inverse;
pub(crate) use lyapunov::largest_eigenvalue_bound;
pub use lyapunov::{
    decay_rate, decay_rate_within, hurwitz, lyapunov_decrease, overshoot_bound, positive, stein_decrease,
};
pub use spectrum::{schur_stable, spectral_abscissa, spectral_radius};
pub(crate) use varying_periods::Effort;
pub use varying_periods::decrease_over_times;

use crate::embed::EXACT_ORDER;
use crate::interval::Interval;
use crate::matrix::Matrix;

/// Continuous or discrete time.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum TimeDomain {
    /// `e' = F e + G w`.
    Continuous,
    /// `e+ = F e + G w`.
    Discrete,
}

/// Upper bound of the Frobenius norm, hence of the spectral norm; 0 for the zero matrix.
pub(crate) fn norm_bound(m: &Matrix<Interval>) -> f64 {
    let square = m.as_slice().iter().fold(0.0_f64, |sum, x| {
        let x = x.magnitude();
        if x == 0.0 { sum } else { (sum + (x * x).next_up()).next_up() }
    });
    if square == 0.0 { 0.0 } else { square.sqrt().next_up() }
}
