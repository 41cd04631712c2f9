//! Result of a problem: values, margins, and a verdict obtained by rigorous verification.

use std::fmt;

use luenberger_proof::wording::{at_least, shortest, significant};
use luenberger_proof::{Exact, Matrix, Verdict};
use nalgebra::DMatrix;

use crate::variable::Variable;

/// Result of a [`Problem`](crate::Problem).
///
/// ```
/// let mut lmi = luenberger_lmi::Problem::new();
/// let p = lmi.symmetric("P", 2);
/// lmi.constrain("P > 0", &p >> 0.0);
/// let text = lmi.solve()?.to_string();
/// assert!(text.contains("\nP > 0: margin at least "), "{text}");
/// # Ok::<(), luenberger_lmi::LmiError>(())
/// ```
#[derive(Debug, Clone)]
pub struct Solution {
    /// `Proved`: every inequality holds strictly at exactly the returned values, verified independently of the solver
    /// on the original data; the margin is the smallest of the constraints' margins. `Refuted`: no values satisfy the
    /// inequalities, proved by the witness. `Undecided`: neither could be proved; the values are the best attempt.
    pub verdict: Verdict<Infeasibility>,
    /// One entry per constraint, in the order they were stated.
    pub margins: Vec<Margin>,
    /// Value of the objective, if there is one and the constraints are proved.
    pub objective: Option<Optimum>,
    /// Statistics of the solver.
    pub effort: Effort,
    pub(crate) values: Vec<(Variable, DMatrix<f64>)>,
}

/// Margin of one constraint at the returned values.
#[derive(Debug, Clone, PartialEq)]
pub struct Margin {
    /// The constraint's name.
    pub constraint: String,
    /// A rigorous lower bound on the smallest eigenvalue of the positive side of the inequality, if it was proved
    /// positive at the returned values.
    pub proved: Option<f64>,
    /// The smallest eigenvalue in floating point, not rigorous.
    pub estimate: f64,
}

/// The objective at the returned values, which were moved inside the constraints and are therefore slightly suboptimal.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Optimum {
    /// The objective at the returned values, rounded.
    pub achieved: f64,
    /// The optimum as the solver estimates it from its dual; infinite if it found the objective unbounded. Not proved.
    pub estimate: f64,
}

/// Statistics of the solver, summed over its runs.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Effort {
    /// Interior-point iterations.
    pub iterations: u32,
    /// The solver's own status of its last run; no verdict depends on it.
    pub status: &'static str,
}

/// Why no values satisfy the inequalities: multipliers `Z_k >= 0`, not all zero, such that `sum_k tr(Z_k F_k(x))` is
/// the same number at most zero for every x, while `F_k(x) > 0` for all k would make it positive.
///
/// The multipliers are exact: `multipliers` shows them rounded to binary64 and divided by the largest trace, and
/// [`Problem::is_refuted_by`](crate::Problem::is_refuted_by) checks the exact ones from the problem's data alone.
#[derive(Debug, Clone, PartialEq)]
pub struct Infeasibility {
    /// One multiplier per constraint that takes part in the contradiction.
    pub multipliers: Vec<Multiplier>,
    /// The constant value of `sum_k tr(Z_k F_k(x))`, at most zero, rounded, in the units of the rounded multipliers.
    pub value: f64,
}

/// The multiplier of one constraint.
#[derive(Debug, Clone, PartialEq)]
pub struct Multiplier {
    /// The constraint's name.
    pub constraint: String,
    /// The multiplier, rounded to binary64 and divided by the largest trace.
    pub z: DMatrix<f64>,
    /// The multiplier itself.
    pub exact: Matrix<Exact>,
}

impl Solution {
    /// The value of an unknown matrix. An unknown of another problem has no value here: every entry is NaN.
    ///
    /// If the verdict is not `Proved`, this is the best attempt and not verified.
    pub fn value(&self, variable: &Variable) -> DMatrix<f64> {
        let (rows, columns) = variable.shape();
        self.values
            .iter()
            .find(|(known, _)| known.is_same(variable))
            .map_or_else(|| DMatrix::from_element(rows, columns, f64::NAN), |(_, value)| value.clone())
    }

    /// The value of the unknown matrix declared with this name, if there is one. For answers whose problem was built
    /// elsewhere, as in a bisection.
    pub fn named(&self, name: &str) -> Option<&DMatrix<f64>> {
        self.values.iter().find(|(known, _)| known.name() == name).map(|(_, value)| value)
    }

    /// The proved margin of the constraint of this name, if it was proved.
    pub fn margin(&self, constraint: &str) -> Option<f64> {
        self.margins.iter().find(|margin| margin.constraint == constraint).and_then(|margin| margin.proved)
    }
}

/// The verdict, the margins, the objective; the values are given by [`value`](Solution::value).
impl fmt::Display for Solution {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}", self.verdict)?;
        for Margin { constraint, proved, estimate } in &self.margins {
            match proved {
                Some(margin) => write!(f, "\n{constraint}: margin at least {}", at_least(*margin, 3))?,
                None => write!(f, "\n{constraint}: not proved, margin about {}", significant(*estimate, 3))?,
            }
        }
        match &self.objective {
            Some(objective) => write!(f, "\nobjective {}", significant(objective.achieved, 6)),
            None => Ok(()),
        }
    }
}

impl fmt::Display for Infeasibility {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let names: Vec<&str> = self.multipliers.iter().map(|m| m.constraint.as_str()).collect();
        write!(
            f,
            "no values satisfy {} together: their weighted sum is {} whatever the unknowns",
            names.join(", "),
            shortest(self.value)
        )
    }
}
