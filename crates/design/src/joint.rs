//! The convexified joint design: P, `Y = P L` and S in one linear matrix inequality.
//!
//! With `Z = P N = -C'S`, which is what (13') means, the conditions of Theorem 1 read `P > 0`,
//! `A'P + PA - YC - C'Y' + 2 rate P < 0`, `S + S' > 0`. They are feasible iff `(A + rate I, C)` is detectable; the
//! cubic term never costs feasibility, because S stands alone.

use luenberger_linalg::RealMatrixView;
use luenberger_lmi::{Problem, he};
use luenberger_plants::StateSpace;

use crate::check;
use crate::cubic::{CubicDesign, CubicGain};
use crate::error::DesignError;
use crate::gain_lmi;
use crate::gain_options::GainOptions;
use crate::linear::LinearDesign;

/// L, N and P from one inequality, every error decaying at least like `exp(-rate t)`; `rate = 0` asks for stability
/// only.
///
/// `theta` is p x p, positive semidefinite; S comes out of the inequality and is scaled to `|S| = gamma`, so that
/// `gamma` is the strength of the cubic term: `N = -P^-1 C'S`. Cost: one SDP of `n(n+1)/2 + np + p^2` unknowns.
///
/// ```
/// use luenberger_design::cubic_lmi_design;
/// use nalgebra::dmatrix;
///
/// let plant = luenberger_plants::double_integrator().to_dynamic();
/// let design = cubic_lmi_design(&plant, &dmatrix![1.0], 0.5, 1.0)?;
/// assert!(design.certificate.is_proved());
/// # Ok::<(), luenberger_design::DesignError>(())
/// ```
///
/// # Errors
/// [`DesignError::NotDetectable`] names the unobservable mode that does not decay fast enough;
/// [`DesignError::Undecided`] if the inequality could not be decided.
pub fn cubic_lmi_design<'a>(
    plant: &StateSpace,
    theta: impl Into<RealMatrixView<'a>>,
    rate: f64,
    gamma: f64,
) -> Result<CubicDesign, DesignError> {
    let (linear, cubic_gain) = joint(plant, rate, gamma)?;
    CubicDesign::new(&linear, theta, &cubic_gain)
}

fn joint(plant: &StateSpace, rate: f64, gamma: f64) -> Result<(LinearDesign, CubicGain), DesignError> {
    check::positive("gamma", gamma)?;
    let outputs = plant.c.nrows();
    let mut lmi = Problem::new();
    let s = lmi.rectangular("S", outputs, outputs);
    lmi.constrain("S + S' > 0", he(&s) >> 0.0);
    let (gain, solution) = gain_lmi::solve(plant, std::slice::from_ref(&plant.a), rate, lmi, &GainOptions::default())?;
    let s = solution.value(&s);
    let s = &s * (gamma / s.norm());
    Ok((LinearDesign::with_lyapunov_matrix(plant, gain, rate)?, CubicGain::General(s)))
}
