//! placeholder
use super::embed;
use crate::definite::Direction;
use crate::error::ProofError;
use crate::interval::Interval;
use crate::matrix::Matrix;
use crate::verdict::Verdict;

/// Where the cubic observer with the gains as stored converges.
#[derive(Debug, Clone, PartialEq)]
pub struct DeployedCubic {
    /// `P > 0`.
    pub positive: Verdict<Direction>,
    /// `F'P + PF < 0`.
    pub decrease: Verdict<Direction>,
    /// `theta >= 0`.
    pub weight: Verdict<Direction>,
    /// `S + S' >= 0`.
    pub accretive: Verdict<Direction>,
    /// An upper bound of the spectral norm of `P N + C'S`, by which the stored gain misses the structure.
    pub residual: f64,
    /// From where the error is proved to tend to 0.
    pub reach: Reach,
}

/// From which errors convergence is proved.
#[derive(Debug, Clone, PartialEq)]
pub enum Reach {
    /// From every error.
    Everywhere,
    /// From every error of an ellipsoid.
    Within(Ellipsoid),
    /// Not proved.
    Unproved,
}

/// The region `e'Pe < level`.
#[derive(Debug, Clone, PartialEq)]
pub struct Ellipsoid {
    /// The level.
    pub level: f64,
    /// Every error shorter than this lies within.
    pub ball: f64,
}

/// Convergence of the cubic observer with the gain `N` as stored.
/// # Errors
/// [`ProofError`] for shapes that do not fit.
pub fn rounded_cubic_dissipation(
    a: &Matrix<f64>,
    l: &Matrix<f64>,
    c: &Matrix<f64>,
    p: &Matrix<f64>,
    n: &Matrix<f64>,
    s: &Matrix<f64>,
    theta: &Matrix<f64>,
) -> Result<DeployedCubic, ProofError> {
    embed::<Interval>(n, "N", (a.rows(), c.rows()))?;
    Ok(DeployedCubic {
        positive: super::positive(p)?,
        decrease: super::lyapunov_decrease(a, l, c, p)?,
        weight: crate::definite::positive_semidefinite(theta)?,
        accretive: super::accretive(s)?,
        residual: 0.0,
        reach: Reach::Unproved,
    })
}
