//! Coordinates of the target space in which every direction of T(box) counts.
//!
//! The entries of z are low-pass filters of the same output and hence nearly the same signal: T(box) is thin, and what
//! tells the unmeasured states is in its thin directions. `w = W (z - m)`, m and W from the mean and the covariance of
//! T over the box, makes all directions about one wide. Directions of no width at all (a linear plant with more target
//! states than states) hold nothing but noise; the design gives them no weight.

use luenberger_plants::error::check_matrix;
use nalgebra::{RealField, SMatrix, SVector};

use crate::error::ObserverError;

/// `w = W (z - m)`, and back.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Coordinates<T, const Z: usize> {
    mean: SVector<T, Z>,
    whiten: SMatrix<T, Z, Z>,
    colour: SMatrix<T, Z, Z>,
}

impl<T: RealField + Copy, const Z: usize> Coordinates<T, Z> {
    /// m, W and the inverse of W, or its pseudo-inverse where W leaves directions out.
    ///
    /// # Errors
    /// [`ObserverError::Matrix`] for entries that are not finite.
    pub fn new(mean: SVector<T, Z>, whiten: SMatrix<T, Z, Z>, colour: SMatrix<T, Z, Z>) -> Result<Self, ObserverError> {
        check_matrix("m", &mean, (Z, 1))?;
        check_matrix("W", &whiten, (Z, Z))?;
        check_matrix("W^-1", &colour, (Z, Z))?;
        Ok(Self { mean, whiten, colour })
    }

    /// The identity, `w = z`.
    pub fn identity() -> Self {
        Self { mean: SVector::zeros(), whiten: SMatrix::identity(), colour: SMatrix::identity() }
    }

    /// `W (z - m)`; zero in the entries that overflow.
    pub fn white(&self, z: &SVector<T, Z>) -> SVector<T, Z> {
        (self.whiten * (z - self.mean)).map(|entry| if entry.is_finite() { entry } else { T::zero() })
    }

    /// `m + W^-1 w`.
    pub fn coloured(&self, w: &SVector<T, Z>) -> SVector<T, Z> {
        self.mean + self.colour * w
    }

    /// W.
    pub fn whiten(&self) -> &SMatrix<T, Z, Z> {
        &self.whiten
    }

    /// The inverse of W.
    pub fn colour(&self) -> &SMatrix<T, Z, Z> {
        &self.colour
    }

    /// m.
    pub fn mean(&self) -> &SVector<T, Z> {
        &self.mean
    }

    /// The same over another scalar.
    pub fn cast<U: RealField + Copy>(&self) -> Coordinates<U, Z> {
        let cast = |x: T| nalgebra::convert::<f64, U>(x.to_subset_unchecked());
        Coordinates { mean: self.mean.map(cast), whiten: self.whiten.map(cast), colour: self.colour.map(cast) }
    }
}
