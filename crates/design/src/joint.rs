//! The convexified joint design: P, `Y = P L` and S in one linear matrix inequality.
//!
//! With `Z = P N = -C'S`, which is what (13') means, the conditions of Theorem 1 read
//! `P > 0`, `A'P + PA - YC - C'Y' + 2 rate P < 0`, `S + S' > 0`. They are feasible iff `(A + rate I, C)` is detectable; the cubic term
//! never costs feasibility, because S stands alone.

use luenberger_lmi::{Problem, Solution, he};
use luenberger_plants::DynamicPlant;
use luenberger_proof::Verdict;
use nalgebra::DMatrix;

use crate::check;
use crate::cubic::{Correction, CubicDesign};
use crate::error::{DesignError, Obstruction};
use crate::linear::LinearDesign;

/// L, N and P from one inequality, every error decaying at least like `exp(-rate t)`; `rate = 0` asks for stability only.
///
/// `theta` is p x p, positive semidefinite; S comes out of the inequality, scaled by `gamma`: `N = -gamma P^-1 C'S`, `|S| = 1`.
/// Cost: one SDP of `n(n+1)/2 + np + p^2` unknowns.
///
/// ```
/// use luenberger_design::joint_design;
/// use nalgebra::dmatrix;
///
/// let plant = luenberger_plants::double_integrator().to_dynamic();
/// let design = joint_design(&plant, &dmatrix![1.0], 0.5, 1.0)?;
/// assert!(design.certificate.is_proved());
/// # Ok::<(), luenberger_design::DesignError>(())
/// ```
///
/// # Errors
/// `NotDetectable` (in [`DesignError::Linalg`]) names the mode that no output sees and that does not decay fast enough by itself;
/// [`DesignError::Undecided`] when the inequality could not be decided.
pub fn joint_design(
    plant: &DynamicPlant,
    theta: &DMatrix<f64>,
    rate: f64,
    gamma: f64,
) -> Result<CubicDesign, DesignError> {
    check::positive("gamma", gamma)?;
    let outputs = plant.c.nrows();
    let mut lmi = Problem::new();
    let s = lmi.rectangular("S", outputs, outputs);
    lmi.constrain("S + S' > 0", he(&s) >> 0.0);
    let (gain, solution) = solve(plant, std::slice::from_ref(&plant.a), rate, lmi)?;
    let s = solution.value(&s);
    let s = &s * (gamma / s.norm());
    let linear = LinearDesign::from_lyapunov_matrix(plant, gain)?;
    CubicDesign::new(&linear, theta, &Correction::General(s))
}

/// A gain with the Lyapunov matrix that came with it.
pub(crate) struct Gain {
    pub(crate) l: DMatrix<f64>,
    pub(crate) p: DMatrix<f64>,
}

/// L and P alone.
pub(crate) fn gain_by_lmi(plant: &DynamicPlant, rate: f64) -> Result<Gain, DesignError> {
    Ok(solve(plant, std::slice::from_ref(&plant.a), rate, Problem::new())?.0)
}

/// One L and one P for every state matrix in `vertices`, with whatever `lmi` already asks for.
pub(crate) fn solve(
    plant: &DynamicPlant,
    vertices: &[DMatrix<f64>],
    rate: f64,
    mut lmi: Problem,
) -> Result<(Gain, Solution), DesignError> {
    let (n, outputs) = (plant.a.nrows(), plant.c.nrows());
    for a in vertices {
        check::detectable(a, &plant.c, rate)?;
    }
    let p = lmi.symmetric("P", n);
    let y = lmi.rectangular("Y", n, outputs);
    lmi.constrain("P > 0", &p >> 0.0);
    for (k, a) in vertices.iter().enumerate() {
        lmi.constrain(
            &format!("decrease at vertex {}", k + 1),
            (he(&p * a - &y * &plant.c) + (2.0 * rate) * &p) << 0.0,
        );
    }
    let solution = lmi.solve()?;
    match &solution.verdict {
        Verdict::Proved { .. } => {
            let p = solution.value(&p);
            let l = check::solve_definite("P", &p, &solution.value(&y))?;
            Ok((Gain { l, p }, solution))
        }
        Verdict::Refuted { witness } => {
            Err(DesignError::Infeasible { what: WHAT, reason: Obstruction::Dual(witness.clone()) })
        }
        Verdict::Undecided { why, best } => Err(DesignError::Undecided { what: WHAT, why: why.clone(), best: *best }),
    }
}

const WHAT: &str = "P > 0, A'P + PA - YC - C'Y' + 2 rate P < 0";
