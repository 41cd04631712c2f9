//! A plant with disturbances, a linear observer of it, and the errors `z = H e` that count: the data of the filters.

use super::super::fields::{Field, LARGEST_ORDER};
use super::super::members::members;
use super::super::write::{Out, Written};
use super::{FileError, PlantMatrices, counted, exact};
use crate::error::ProofError;
use crate::matrix::Matrix;
use crate::statement::TimeDomain;

/// A plant `x' = Ax + Bu + Ew`, `y = Cx + Dw` (or `x+`), the gain of an observer, P, and the bound gamma of a norm of
/// the errors `z = He`, e = x - xhat.
#[derive(Debug, Clone, PartialEq)]
pub struct FilterProblem {
    /// Continuous or discrete.
    pub time: TimeDomain,
    /// The plant.
    pub plant: PlantMatrices,
    /// E, n x q.
    pub e: Matrix<f64>,
    /// D, p x q.
    pub d: Matrix<f64>,
    /// H, r x n.
    pub h: Matrix<f64>,
    /// The gain L, n x p, as stored.
    pub l: Matrix<f64>,
    /// P, n x n.
    pub p: Matrix<f64>,
    /// The bound, positive.
    pub gamma: f64,
}

/// The words of the member `time`.
pub(super) const TIMES: [(&str, TimeDomain); 2] =
    [("continuous", TimeDomain::Continuous), ("discrete", TimeDomain::Discrete)];

impl FilterProblem {
    pub(super) fn check(&self) -> Result<(), ProofError> {
        if !(self.gamma > 0.0 && self.gamma.is_finite()) {
            return Err(ProofError::Sign { what: "gamma, which should be positive,", value: self.gamma });
        }
        Ok(())
    }

    /// `F'P + PF + H'H` or `F'PF - P + H'H` in words.
    pub(super) fn decrease(&self) -> &'static str {
        match self.time {
            TimeDomain::Continuous => "(A - LC)'P + P(A - LC) + H'H",
            TimeDomain::Discrete => "(A - LC)'P(A - LC) - P + H'H",
        }
    }

    /// The plant, the observer and its error in words, to the end of the claim that the error decays without w.
    fn words(&self) -> String {
        let sizes = format!(
            "{}, {}, {} and {}",
            counted(self.plant.a.rows(), "state"),
            counted(self.plant.b.cols(), "input"),
            counted(self.e.cols(), "disturbance"),
            counted(self.plant.c.rows(), "output")
        );
        let (kind, next) = match self.time {
            TimeDomain::Continuous => ("plant", "'"),
            TimeDomain::Discrete => ("discrete-time plant", "+"),
        };
        format!(
            "For the {kind} x{next} = Ax + Bu + Ew, y = Cx + Dw with {sizes}, any u, and the observer xhat{next} = A xhat + Bu + L(y - C xhat) with the gain exactly as stored, the error e = x - xhat obeys e{next} = (A - LC)e + (E - LD)w. Without w, e tends to 0 exponentially from every e(0)"
        )
    }

    /// The claim that this norm of the errors is bounded, in words.
    pub(super) fn bounded(&self, norm: &str) -> String {
        format!(
            "{}, and the {norm} norm of the transfer function from w to z = He with {} is below gamma = {}",
            self.words(),
            counted(self.h.rows(), "row"),
            exact(self.gamma)
        )
    }
}

members! { FilterProblem {
    {
        time = "time".word(&TIMES);
        plant: PlantMatrices = "plant".part();
        e = "E".by(|e| disturbed(e, plant.order()));
        d = "D".matrix((plant.outputs(), e.cols()));
        h = "H".matrix_with_columns(plant.order());
    }
    "observer" { l = "L".matrix(plant.gain()); }
    "lyapunov" { p = "P".symmetric(plant.order()); }
    { gamma = "gamma".positive("gamma is positive"); }
} }

/// The block inequality has a row for each state and each disturbance.
fn disturbed(field: &Field<'_>, order: usize) -> Result<Matrix<f64>, FileError> {
    let e = field.columns(order)?;
    field.bounded_order(order + e.cols(), LARGEST_ORDER)?;
    Ok(e)
}

impl Written for TimeDomain {
    fn out(&self) -> Out {
        match self {
            Self::Continuous => TIMES[0].0.out(),
            Self::Discrete => TIMES[1].0.out(),
        }
    }
}
