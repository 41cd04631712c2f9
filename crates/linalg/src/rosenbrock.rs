//! Rosenbrock's system matrix, `S(lambda) = [A - lambda I, B; C, D]`, in balanced units of state, input, output and
//! time.
//!
//! The units are those of [`Units`] for the pair `([A B; 0 0], [C D])`: a unit of an input scales its column, as a unit
//! of a state does.

use nalgebra::DMatrix;

use crate::argument::{shaped, square};
use crate::units::{Units, shift};
use crate::{LinalgError, Result};

/// A plant `(A, B, C, D)` in balanced units.
#[derive(Debug, Clone)]
pub(crate) struct Rosenbrock {
    pub(crate) a: DMatrix<f64>,
    pub(crate) b: DMatrix<f64>,
    pub(crate) c: DMatrix<f64>,
    pub(crate) d: DMatrix<f64>,
    /// `|[A B; C D]|`, Frobenius.
    pub(crate) size: f64,
    /// Powers of two: the states followed by the inputs; the outputs; time.
    units: Units,
}

impl Rosenbrock {
    /// Checks the shapes (at least one state; no input or no output is allowed) and chooses the units.
    pub(crate) fn new(a: &DMatrix<f64>, b: &DMatrix<f64>, c: &DMatrix<f64>, d: &DMatrix<f64>) -> Result<Self> {
        let n = square("A", a)?;
        if n == 0 {
            return Err(LinalgError::Empty { what: "A" });
        }
        let (m, p) = (b.ncols(), c.nrows());
        shaped("B", b, n, m)?;
        shaped("C", c, p, n)?;
        shaped("D", d, p, m)?;
        let mut dynamics = DMatrix::zeros(n + m, n + m);
        dynamics.view_mut((0, 0), (n, n)).copy_from(a);
        dynamics.view_mut((0, n), (n, m)).copy_from(b);
        let mut outputs = DMatrix::zeros(p, n + m);
        outputs.view_mut((0, 0), (p, n)).copy_from(c);
        outputs.view_mut((0, n), (p, m)).copy_from(d);
        let units = Units::of(&dynamics, &outputs);
        let (dynamics, outputs) = (units.dynamics(&dynamics), units.outputs(&outputs));
        let size = dynamics.norm().hypot(outputs.norm());
        if !size.is_finite() {
            return Err(LinalgError::Overflow { what: "the norm of [A B; C D]" });
        }
        Ok(Self {
            a: dynamics.view((0, 0), (n, n)).into_owned(),
            b: dynamics.view((0, n), (n, m)).into_owned(),
            c: outputs.columns(0, n).into_owned(),
            d: outputs.columns(n, m).into_owned(),
            size,
            units,
        })
    }

    /// Power of two of the unit of time: an eigenvalue here is `2^-time` times the one in the given units.
    pub(crate) fn time(&self) -> i32 {
        self.units.time
    }

    /// Power of two by which the transfer function of one input and one output exceeds that of the scaled plant.
    pub(crate) fn gain_power(&self) -> i32 {
        self.units.output[0] - self.units.state[self.a.nrows()]
    }

    /// Powers of two of the units of the states.
    pub(crate) fn states(&self) -> Vec<i32> {
        self.units.state[..self.a.nrows()].to_vec()
    }

    /// `2^-time D^-1 A D` of the given A.
    pub(crate) fn dynamics_of(&self, a: &DMatrix<f64>, time: i32) -> DMatrix<f64> {
        let d = &self.units.state;
        DMatrix::from_fn(a.nrows(), a.ncols(), |i, j| shift(a[(i, j)], d[j] - d[i] - time))
    }

    /// `2^-time D^-1 B` of the given B: inputs in the units given.
    pub(crate) fn driven_of(&self, b: &DMatrix<f64>, time: i32) -> DMatrix<f64> {
        DMatrix::from_fn(b.nrows(), b.ncols(), |i, j| shift(b[(i, j)], -self.units.state[i] - time))
    }

    /// `C D` of the given C: outputs in the units given.
    pub(crate) fn seen_of(&self, c: &DMatrix<f64>) -> DMatrix<f64> {
        DMatrix::from_fn(c.nrows(), c.ncols(), |i, j| shift(c[(i, j)], self.units.state[j]))
    }

    /// `D M` (D the state units): rows in units of the states, back in the given units.
    pub(crate) fn states_back(&self, m: &DMatrix<f64>) -> DMatrix<f64> {
        DMatrix::from_fn(m.nrows(), m.ncols(), |i, j| shift(m[(i, j)], self.units.state[i]))
    }

    /// Columns in units of the inputs, rows rates of dimensionless states, as `T^-1 B`: back in the given units.
    pub(crate) fn driven_back(&self, m: &DMatrix<f64>) -> DMatrix<f64> {
        let n = self.a.nrows();
        DMatrix::from_fn(m.nrows(), m.ncols(), |i, j| shift(m[(i, j)], self.units.time - self.units.state[n + j]))
    }

    /// Rows in units of the outputs, columns dimensionless states, as `C T`: back in the given units.
    pub(crate) fn outputs_back(&self, m: &DMatrix<f64>) -> DMatrix<f64> {
        DMatrix::from_fn(m.nrows(), m.ncols(), |i, j| shift(m[(i, j)], self.units.output[i]))
    }
}
