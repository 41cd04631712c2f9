//! A plant with disturbances, a linear observer of it, and the errors `z = H e` that count: the data of the filters.

use super::super::Fault;
use super::super::fields::{Fields, LARGEST_ORDER};
use super::super::write::Out;
use super::{FileError, PlantMatrices, counted, exact, unknown_word};
use crate::error::ProofError;
use crate::matrix::Matrix;
use crate::statement::{ErrorSystem, TimeDomain};

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

const TIMES: [&str; 2] = ["continuous", "discrete"];

impl FilterProblem {
    pub(super) fn system(&self) -> Result<ErrorSystem<'_>, ProofError> {
        if !(self.gamma > 0.0 && self.gamma.is_finite()) {
            return Err(ProofError::Sign { what: "gamma, which should be positive,", value: self.gamma });
        }
        let (a, c) = (&self.plant.a, &self.plant.c);
        Ok(ErrorSystem { time: self.time, a, c, e: &self.e, d: &self.d, h: &self.h, l: &self.l })
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

    pub(super) fn read(file: &mut Fields<'_>) -> Result<Self, FileError> {
        let field = file.take("time")?;
        let time = match field.text()? {
            "continuous" => TimeDomain::Continuous,
            "discrete" => TimeDomain::Discrete,
            found => return Err(unknown_word(&field, found, &TIMES)),
        };
        let plant = PlantMatrices::read(file)?;
        let (order, outputs) = plant.gain();
        let field = file.take("E")?;
        let e = field.matrix_with_rows(order)?;
        if e.cols() == 0 {
            return Err(field.error(Fault::Empty));
        }
        // The block inequality has a row for each state and each disturbance.
        if order + e.cols() > LARGEST_ORDER {
            return Err(field.error(Fault::TooManyRows { order: order + e.cols(), allowed: LARGEST_ORDER }));
        }
        let d = file.take("D")?.matrix((outputs, e.cols()))?;
        let h = file.take("H")?.matrix_with_columns(order)?;
        let mut observer = file.object("observer")?;
        let l = observer.take("L")?.matrix((order, outputs))?;
        observer.finish()?;
        let mut lyapunov = file.object("lyapunov")?;
        let p = lyapunov.take("P")?.symmetric(order)?;
        lyapunov.finish()?;
        let field = file.take("gamma")?;
        let gamma = field.binary64()?;
        if gamma <= 0.0 {
            return Err(field.error(Fault::Range { value: gamma, requirement: "gamma is positive" }));
        }
        Ok(Self { time, plant, e, d, h, l, p, gamma })
    }

    pub(super) fn write(&self) -> Vec<(&'static str, Out)> {
        let time = match self.time {
            TimeDomain::Continuous => TIMES[0],
            TimeDomain::Discrete => TIMES[1],
        };
        vec![
            ("time", Out::Text(time.to_owned())),
            self.plant.write(),
            ("E", Out::matrix(&self.e)),
            ("D", Out::matrix(&self.d)),
            ("H", Out::matrix(&self.h)),
            ("observer", Out::Object(vec![("L", Out::matrix(&self.l))])),
            ("lyapunov", Out::Object(vec![("P", Out::matrix(&self.p))])),
            ("gamma", Out::number(self.gamma)),
        ]
    }
}
