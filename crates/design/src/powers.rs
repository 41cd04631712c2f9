//! Units of states that are powers of two: a change to them rounds nothing.

use nalgebra::DMatrix;

/// Units of the states: `x_j = 2^k_j z_j`.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) struct Powers(pub(crate) Vec<i32>);

impl Powers {
    /// The units as given, of n states.
    pub(crate) fn given(n: usize) -> Self {
        Self(vec![0; n])
    }

    /// `D^-1 F D`.
    pub(crate) fn similar(&self, f: &DMatrix<f64>) -> DMatrix<f64> {
        DMatrix::from_fn(f.nrows(), f.ncols(), |i, j| shift(f[(i, j)], self.0[j] - self.0[i]))
    }

    /// `D^-1 E`.
    pub(crate) fn rows(&self, e: &DMatrix<f64>) -> DMatrix<f64> {
        DMatrix::from_fn(e.nrows(), e.ncols(), |i, j| shift(e[(i, j)], -self.0[i]))
    }

    /// `D E`.
    pub(crate) fn rows_back(&self, e: &DMatrix<f64>) -> DMatrix<f64> {
        DMatrix::from_fn(e.nrows(), e.ncols(), |i, j| shift(e[(i, j)], self.0[i]))
    }

    /// `C D`.
    pub(crate) fn columns(&self, c: &DMatrix<f64>) -> DMatrix<f64> {
        DMatrix::from_fn(c.nrows(), c.ncols(), |i, j| shift(c[(i, j)], self.0[j]))
    }

    /// `C D^-1`.
    pub(crate) fn outputs_back(&self, c: &DMatrix<f64>) -> DMatrix<f64> {
        DMatrix::from_fn(c.nrows(), c.ncols(), |i, j| shift(c[(i, j)], -self.0[j]))
    }

    /// `D^-1 P D^-1`, a form in the coordinates of the user.
    pub(crate) fn form_back(&self, p: &DMatrix<f64>) -> DMatrix<f64> {
        DMatrix::from_fn(p.nrows(), p.ncols(), |i, j| shift(p[(i, j)], -self.0[i] - self.0[j]))
    }
}

/// `x 2^power` without intermediate overflow.
pub(crate) fn shift(x: f64, power: i32) -> f64 {
    let half = power / 2;
    x * 2f64.powi(half) * 2f64.powi(power - half)
}
