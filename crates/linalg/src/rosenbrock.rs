//! The system matrix of Rosenbrock, `S(lambda) = [A - lambda I, B; C, D]`, in units of state, input, output and time
//! that suit it.
//!
//! They are those of [`Units`] for the pair `([A B; 0 0], [C D])`: a unit of input scales a column as a unit of state
//! does, and nothing else.

use nalgebra::DMatrix;

use crate::argument::{shaped, square};
use crate::units::{Units, shift};
use crate::{LinalgError, Result};

/// A plant `(A, B, C, D)` in its units.
#[derive(Debug, Clone)]
pub(crate) struct Rosenbrock {
    pub(crate) a: DMatrix<f64>,
    pub(crate) b: DMatrix<f64>,
    pub(crate) c: DMatrix<f64>,
    pub(crate) d: DMatrix<f64>,
    /// `|[A B; C D]|`, Frobenius.
    pub(crate) size: f64,
    /// Powers of two: of the states, then the inputs; of the outputs; of time.
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

    /// The power of two of time: an eigenvalue here is `2^-time` of the one in the units given.
    pub(crate) fn time(&self) -> i32 {
        self.units.time
    }

    /// `D M`: rows that are states, in the units given.
    pub(crate) fn states_back(&self, m: &DMatrix<f64>) -> DMatrix<f64> {
        DMatrix::from_fn(m.nrows(), m.ncols(), |i, j| shift(m[(i, j)], self.units.state[i]))
    }

    /// Columns that are inputs and rows that are rates of a state without unit, as `T^-1 B`, in the units given.
    pub(crate) fn driven_back(&self, m: &DMatrix<f64>) -> DMatrix<f64> {
        let n = self.a.nrows();
        DMatrix::from_fn(m.nrows(), m.ncols(), |i, j| shift(m[(i, j)], self.units.time - self.units.state[n + j]))
    }

    /// Rows that are outputs and columns that are states without unit, as `C T`, in the units given.
    pub(crate) fn outputs_back(&self, m: &DMatrix<f64>) -> DMatrix<f64> {
        DMatrix::from_fn(m.nrows(), m.ncols(), |i, j| shift(m[(i, j)], self.units.output[i]))
    }
}
