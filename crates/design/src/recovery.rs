//! Loop transfer recovery at the inputs of a plant, by fictitious process noise.
//!
//! State feedback has the loop `K (s I - A)^-1 B`; with the estimate of a Kalman filter in place of the state it is
//! `H G` ([`LoopTransfer`]), whose margins may be arbitrarily small (Doyle 1978). With the process noise
//! ```text
//! W + q^2 B B'
//! ```
//! of the filter, H G tends to the loop of state feedback at each frequency as q grows, if the plant has at least as
//! many outputs as inputs and no zero in the closed right half plane: J. C. Doyle and G. Stein, IEEE Transactions on
//! Automatic Control 24, 1979, and 26, 1981. Otherwise it need not. The price is noise: L grows with q.
//!
//! In discrete time the loop around a predictor, which uses no measurement of the same sample, does not tend to it
//! (Maciejowski, IEEE Transactions on Automatic Control 30, 1985).

use luenberger_linalg::{
    HInfinityNorm, LoopMargins, LoopTransfer, RealMatrixView, Realization, h_infinity_norm, invariant_zeros,
    sensitivity,
};
use luenberger_plants::StateSpace;
use luenberger_proof::wording::counted;
use nalgebra::{Complex, DMatrix};
use std::fmt;

use crate::check;
use crate::error::DesignError;
use crate::kalman_noise::KalmanNoise;
use crate::linear::{LinearDesign, LyapunovWeight};
use crate::number::complex;

/// The matrices of a plant, D as zeros where it has none.
pub fn realization(plant: &StateSpace) -> Realization {
    let StateSpace { a, b, c, d } = plant.clone();
    let d = d.unwrap_or_else(|| DMatrix::zeros(c.nrows(), b.ncols()));
    Realization { a, b, c, d }
}

/// Why recovery is not complete, however large q is.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum RecoveryObstacle {
    /// More inputs than outputs.
    Outputs {
        /// Number of inputs.
        inputs: usize,
        /// Number of outputs.
        outputs: usize,
    },
    /// A combination of inputs has no effect on the outputs.
    Degenerate,
    /// A zero in the closed right half plane: a plant that is not minimum phase.
    Zero(Complex<f64>),
}

impl fmt::Display for RecoveryObstacle {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Outputs { inputs, outputs } => write!(
                f,
                "the plant has {} and {}, and at least as many outputs as inputs are needed",
                counted(*inputs, "input"),
                counted(*outputs, "output")
            ),
            Self::Degenerate => write!(f, "a combination of the inputs has no effect on the outputs"),
            Self::Zero(zero) => {
                write!(f, "the plant is not minimum phase, it has a zero at {}", complex(*zero))
            }
        }
    }
}

/// What keeps the loop of this plant, in continuous time, from being recovered at its inputs; none for a plant with at
/// least as many outputs as inputs and with zeros in the open left half plane alone.
///
/// # Errors
/// [`DesignError::Linalg`]: those of [`invariant_zeros`].
pub fn recovery_obstacle(plant: &StateSpace) -> Result<Option<RecoveryObstacle>, DesignError> {
    let Realization { a, b, c, d } = realization(plant);
    let (inputs, outputs) = (b.ncols(), c.nrows());
    if inputs > outputs {
        return Ok(Some(RecoveryObstacle::Outputs { inputs, outputs }));
    }
    let found = invariant_zeros(&a, &b, &c, &d)?;
    if found.is_degenerate() {
        return Ok(Some(RecoveryObstacle::Degenerate));
    }
    let worst = found.zeros.into_iter().max_by(|x, y| x.re.total_cmp(&y.re));
    Ok(worst.filter(|zero| zero.re >= 0.0).map(RecoveryObstacle::Zero))
}

/// The loop with one q.
#[derive(Debug, Clone, PartialEq)]
pub struct Recovery {
    /// q.
    pub q: f64,
    /// The observer gain L.
    pub l: DMatrix<f64>,
    /// The H-infinity norm of `(I + H G)^-1 - (I + K (s I - A)^-1 B)^-1`, and where it is attained: zero where the loop
    /// is recovered.
    pub difference: HInfinityNorm,
    /// The margins of H G.
    pub margins: LoopMargins,
}

/// The loops of `plant` in continuous time with the feedback gain `k`, m x n, and the Kalman filter for `noise` with
/// each of these q in place of its own.
///
/// `A - B K` is to be Hurwitz. Cost: a Riccati equation and the norms of [`LoopMargins`] for each q.
///
/// ```
/// use luenberger_design::{KalmanNoise, recovery::loop_transfer_recovery};
/// use luenberger_linalg::lqr;
/// use nalgebra::{DMatrix, dmatrix};
/// let plant = luenberger_plants::double_integrator().to_dynamic();
/// let k = lqr(&plant.a, &plant.b, &DMatrix::identity(2, 2), &dmatrix![1.0])?.k;
/// let noise = KalmanNoise::new(&DMatrix::identity(2, 2), &dmatrix![1.0]);
/// let found = loop_transfer_recovery(&plant, &noise, &k, &[0.0, 1e2, 1e4])?;
/// assert!(found.windows(2).all(|pair| pair[1].difference.norm < 0.5 * pair[0].difference.norm));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
/// # Errors
/// Those of [`LinearDesign::kalman_of`], [`LoopTransfer::new`] and [`LoopMargins::continuous`];
/// [`DesignError::Negative`] for q;
/// [`DesignError::NotHurwitz`] where `A - B K` is not.
pub fn loop_transfer_recovery<'a>(
    plant: &StateSpace,
    noise: &KalmanNoise,
    k: impl Into<RealMatrixView<'a>>,
    q: &[f64],
) -> Result<Vec<Recovery>, DesignError> {
    let k = check::owned(k);
    check::matrix("K", &k, (plant.b.ncols(), plant.a.nrows()))?;
    check::StableLoop::new("A - B K", (&plant.a, &plant.b, &k))?;
    let one = |q: &f64| {
        let filter = LinearDesign::kalman_of(plant, &noise.clone().recovering(*q), LyapunovWeight::default())?;
        let transfer = LoopTransfer::new(&realization(plant), filter.l(), &k)?;
        let margins = LoopMargins::continuous(&transfer.at_inputs)?;
        let difference = difference_of_sensitivities(&transfer.at_inputs, &transfer.state_feedback)?;
        Ok(Recovery { q: *q, l: filter.l().clone(), difference, margins })
    };
    q.iter().map(one).collect()
}

/// The H-infinity norm of the difference of the sensitivities of two loops that are stable when they are closed.
fn difference_of_sensitivities(one: &Realization, other: &Realization) -> Result<HInfinityNorm, DesignError> {
    let (one, other) = (sensitivity(one)?, sensitivity(other)?);
    let (n, m) = (one.a.nrows(), one.b.ncols());
    let all = n + other.a.nrows();
    let mut a = DMatrix::zeros(all, all);
    a.view_mut((0, 0), (n, n)).copy_from(&one.a);
    a.view_mut((n, n), other.a.shape()).copy_from(&other.a);
    let (mut b, mut c) = (DMatrix::zeros(all, m), DMatrix::zeros(m, all));
    b.rows_mut(0, n).copy_from(&one.b);
    b.rows_mut(n, all - n).copy_from(&other.b);
    c.columns_mut(0, n).copy_from(&one.c);
    c.columns_mut(n, all - n).copy_from(&-&other.c);
    Ok(h_infinity_norm(&a, &b, &c, &(&one.d - &other.d))?)
}
