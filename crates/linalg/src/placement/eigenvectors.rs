//! Eigenvectors closed under conjugation, in real columns.
//!
//! For `X = [.. x conj(x) ..]` and `W = [.. sqrt2 Re x, sqrt2 Im x ..]`, `X = W U` with U block diagonal and unitary
//! blocks `[1 1; i -i] / sqrt2`. So X and W have the same singular values, and the left eigenvectors `X^-* = W^-T U`
//! have the real columns `W^-T`: no complex arithmetic is needed. Where only directions matter, the factor `sqrt2` is
//! left out.

use nalgebra::{Complex, DMatrix};

use super::extremes::extreme_singular_values;
use crate::observability::default_tolerance;
use crate::units::shift;
use crate::{LinalgError, Result};

/// Meaning of a real column.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Part {
    /// A real eigenvector.
    Whole,
    /// Real part of the eigenvector of an eigenvalue above the real axis; the next column is its imaginary part.
    Real,
    /// Imaginary part of the eigenvector in the previous column. As an index k it stands for the conjugate eigenvector.
    Imaginary,
}

/// Eigenvectors `x_k` as real columns.
#[derive(Debug, Clone)]
pub struct Eigenvectors {
    pub(super) columns: DMatrix<f64>,
    /// What each column is.
    pub parts: Vec<Part>,
}

impl Eigenvectors {
    /// Columns of `reals` real eigenvectors, followed by complex pairs.
    pub fn reals_first(columns: DMatrix<f64>, reals: usize) -> Self {
        let pairs = (columns.ncols() - reals) / 2;
        let mut parts = vec![Part::Whole; reals];
        parts.extend((0..pairs).flat_map(|_| [Part::Real, Part::Imaginary]));
        Self { columns, parts }
    }

    /// Entry i of `x_k`.
    pub fn entry(&self, i: usize, k: usize) -> Complex<f64> {
        let x = &self.columns;
        match self.parts[k] {
            Part::Whole => Complex::from(x[(i, k)]),
            Part::Real => Complex::new(x[(i, k)], x[(i, k + 1)]),
            Part::Imaginary => Complex::new(x[(i, k - 1)], -x[(i, k)]),
        }
    }

    /// The same vectors in the coordinates `z_i = 2^powers[i] x_i`.
    pub(super) fn in_units(mut self, powers: impl Iterator<Item = i32>) -> Self {
        for (i, power) in powers.enumerate().filter(|(_, power)| *power != 0) {
            self.columns.row_mut(i).iter_mut().for_each(|x| *x = shift(*x, power));
        }
        self
    }

    /// Norms `|x_k|`, conjugates included.
    pub(super) fn norms(&self) -> Vec<f64> {
        let n = self.columns.nrows();
        let mut norms = Vec::with_capacity(self.parts.len());
        for (k, part) in self.parts.iter().enumerate() {
            norms.push(match part {
                Part::Whole => norm(self.columns.column(k).as_slice()),
                Part::Real => norm(&self.columns.as_slice()[k * n..(k + 2) * n]),
                Part::Imaginary => norms[k - 1],
            });
        }
        norms
    }

    /// The columns W of the file's head: real vectors of norm one, and pairs of norm one times `sqrt2`. A vector that
    /// is zero or not finite is left as it is.
    #[must_use]
    pub fn normalised(mut self) -> Self {
        for (k, norm) in self.norms().into_iter().enumerate() {
            if norm > 0.0 && norm.is_finite() {
                let mut column = self.columns.column_mut(k);
                if self.parts[k] == Part::Whole {
                    column.unscale_mut(norm);
                } else {
                    // Two operations: `norm / sqrt2` could underflow.
                    column.unscale_mut(norm);
                    column *= core::f64::consts::SQRT_2;
                }
            }
        }
        self
    }

    /// Dual basis: vector k is orthogonal to all `x_j`, j != k. `None` if the `x_j` are linearly dependent.
    pub fn dual(&self) -> Option<Self> {
        let columns = self.columns.clone().try_inverse()?.transpose();
        Some(Self { columns, parts: self.parts.clone() })
    }

    /// `cond_2(X)` of [`Self::normalised`] vectors; infinite if they are linearly dependent.
    ///
    /// # Errors
    /// [`LinalgError::Overflow`]; [`LinalgError::NotConverged`], of which no case is known.
    pub fn condition(&self) -> Result<f64> {
        if self.columns.iter().any(|x| !x.is_finite()) {
            return Err(LinalgError::Overflow { what: "an eigenvector of the closed loop" });
        }
        let (largest, smallest) =
            extreme_singular_values(self.columns.clone()).ok_or_else(|| LinalgError::NotConverged {
                method: "singular values of the eigenvectors",
                iterations: 0,
                remaining: f64::NAN,
                allowed: default_tolerance(self.columns.nrows(), 0),
            })?;
        Ok(if smallest > 0.0 { largest / smallest } else { f64::INFINITY })
    }
}

/// Euclidean norm, safe where squares overflow or underflow.
pub fn norm(x: &[f64]) -> f64 {
    let squares: f64 = x.iter().map(|x| x * x).sum();
    if (1e-280..1e280).contains(&squares) {
        return squares.sqrt();
    }
    let largest = x.iter().fold(0.0, |largest: f64, x| if x.is_nan() { f64::NAN } else { largest.max(x.abs()) });
    if largest == 0.0 || !largest.is_finite() {
        return largest;
    }
    largest * x.iter().map(|x| (x / largest).powi(2)).sum::<f64>().sqrt()
}
