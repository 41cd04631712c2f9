//! The weight of the input, `R` or in discrete time `W = R + B'X B`, factored: by Cholesky's method if it must be
//! definite, else by its eigenvalues, `W = V diag(w) V'`.
//!
//! Where a bound needs the size of an indefinite weight, `|W| = V diag(|w|) V'` takes its place.

use crate::argument::symmetric_part;
use crate::product::view;
use crate::sequential::hermitian_eigen;
use nalgebra::{Cholesky, DMatrix, Dyn};

/// A factored weight, m x m.
#[derive(Clone)]
pub(super) enum InputWeight {
    Definite(Cholesky<f64, Dyn>),
    Indefinite { values: Vec<f64>, vectors: DMatrix<f64> },
}

impl InputWeight {
    /// `None` if `w` is not positive definite to working precision.
    pub(super) fn definite(w: DMatrix<f64>) -> Option<Self> {
        Cholesky::new(w).map(Self::Definite)
    }

    /// # Errors
    /// The condition number of `w`, or infinity, if it is singular to working precision.
    pub(super) fn regular(w: &DMatrix<f64>) -> Result<Self, f64> {
        let m = w.nrows();
        let (values, vectors) = hermitian_eigen(view(w)).ok_or(f64::INFINITY)?;
        let sizes = values.iter().map(|w| w.abs());
        let (least, largest) = (sizes.clone().fold(f64::INFINITY, f64::min), sizes.fold(0.0, f64::max));
        // The rounding error of an eigenvalue.
        if m > 0 && (!largest.is_finite() || least <= 4.0 * m as f64 * f64::EPSILON * largest) {
            return Err(if least > 0.0 { largest / least } else { f64::INFINITY });
        }
        Ok(Self::Indefinite { values, vectors: DMatrix::from_fn(m, m, |i, j| vectors[(i, j)]) })
    }

    pub(super) fn is_definite(&self) -> bool {
        matches!(self, Self::Definite(_))
    }

    /// The weight `w` factored as this one is; `None` if it is not definite, or not regular, to working precision.
    pub(super) fn likewise(&self, w: DMatrix<f64>) -> Option<Self> {
        if self.is_definite() { Self::definite(w) } else { Self::regular(&w).ok() }
    }

    /// `W^-1 M`.
    pub(super) fn solve(&self, m: &DMatrix<f64>) -> DMatrix<f64> {
        match self {
            Self::Definite(factor) => factor.solve(m),
            Self::Indefinite { values, vectors } => vectors * rows(vectors.tr_mul(m), values, |w| 1.0 / w),
        }
    }

    /// `W M`.
    pub(super) fn times(&self, m: &DMatrix<f64>) -> DMatrix<f64> {
        match self {
            Self::Definite(factor) => {
                let l = factor.l_dirty().lower_triangle();
                &l * l.tr_mul(m)
            }
            Self::Indefinite { values, vectors } => vectors * rows(vectors.tr_mul(m), values, |w| w),
        }
    }

    /// A matrix H with `H'H = M'|W| M`.
    pub(super) fn half(&self, m: &DMatrix<f64>) -> DMatrix<f64> {
        match self {
            Self::Definite(factor) => factor.l().tr_mul(m),
            Self::Indefinite { values, vectors } => rows(vectors.tr_mul(m), values, |w| w.abs().sqrt()),
        }
    }

    /// `B W^-1 B'`, exactly symmetric; for a definite W positive semidefinite whatever the rounding.
    pub(super) fn driven(&self, b: &DMatrix<f64>) -> DMatrix<f64> {
        match self {
            Self::Definite(factor) => {
                let mut half = b.transpose();
                factor.l_dirty().solve_lower_triangular_mut(&mut half);
                symmetric_part(&(half.transpose() * half))
            }
            Self::Indefinite { values, vectors } => {
                let b = vectors.tr_mul(&b.transpose());
                symmetric_part(&b.tr_mul(&rows(b.clone(), values, |w| 1.0 / w)))
            }
        }
    }

    /// `tr(H |G|)` for a positive semidefinite `h` and `G = B W^-1 B'`, `-|G| <= G <= |G|`. For an indefinite W that is
    /// from the eigenvalues of G, whose positive and negative part may cancel, and its rounding error.
    pub(super) fn pull(&self, b: &DMatrix<f64>, h: &DMatrix<f64>) -> f64 {
        match self {
            Self::Definite(factor) => factor.solve(&(b.tr_mul(h) * b)).trace(),
            Self::Indefinite { values, vectors } => {
                let (n, m) = b.shape();
                let turned = b * vectors;
                let size: f64 = values.iter().enumerate().map(|(j, w)| turned.column(j).norm_squared() / w.abs()).sum();
                let Some((signs, along)) = hermitian_eigen(view(&self.driven(b))) else {
                    return f64::INFINITY;
                };
                let along = DMatrix::from_fn(n, n, |i, j| along[(i, j)]);
                let seen = h * &along;
                let of_g: f64 = (0..n).map(|j| along.column(j).dot(&seen.column(j)) * signs[j].abs()).sum();
                of_g + 8.0 * (n + m) as f64 * f64::EPSILON * size * h.trace()
            }
        }
    }

    /// `W^-1`.
    pub(super) fn inverse(&self) -> DMatrix<f64> {
        match self {
            Self::Definite(factor) => factor.inverse(),
            Self::Indefinite { vectors, .. } => self.solve(&DMatrix::identity(vectors.nrows(), vectors.nrows())),
        }
    }
}

/// The rows of `m` times `f(values)`.
fn rows(mut m: DMatrix<f64>, values: &[f64], f: impl Fn(f64) -> f64) -> DMatrix<f64> {
    for (mut row, &w) in m.row_iter_mut().zip(values) {
        row *= f(w);
    }
    m
}
