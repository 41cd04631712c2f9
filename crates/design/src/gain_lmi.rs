//! The gain by linear matrix inequality: one L and one P for one or several state matrices.
//!
//! `P > 0`, `A_k'P + P A_k - YC - C'Y' + 2 rate P < 0` for every k, `L = P^-1 Y`. Homogeneous in (P, Y): the solver normalises them together.

use luenberger_lmi::{Problem, Solution, he};
use luenberger_plants::DynamicPlant;
use luenberger_proof::Verdict;
use nalgebra::DMatrix;

use crate::check;
use crate::error::{DesignError, Obstruction};

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
    check::plant(plant)?;
    check::rate(rate)?;
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
