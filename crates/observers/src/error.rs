//! What can be wrong with the data of an observer.

use luenberger_plants::PlantError;

/// Why matrices do not make an observer.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
pub enum ObserverError {
    /// A matrix of the wrong shape, or with an entry that is not finite.
    #[error(transparent)]
    Matrix(#[from] PlantError),
    /// A sampling period that is not a positive number.
    #[error("the sampling period is {period}; it must be positive and finite")]
    Period {
        /// The period given.
        period: f64,
    },
    /// A weight theta for which `y~' theta y~` can be negative.
    #[error("theta is not positive semidefinite: pivot {pivot:e} in row {row} of its symmetric part")]
    ThetaIndefinite {
        /// Row of the pivot, from 0.
        row: usize,
        /// The pivot: negative, or zero where the rest of its row is not.
        pivot: f64,
    },
    /// A rate `w` with which the cubic flow would blow up, or do nothing in the output, in finite time.
    #[error("C N = -w I with w = {w:e}: w must be positive (or zero together with N)")]
    Rate {
        /// The rate.
        w: f64,
    },
    /// A gain N that is not radial: the cubic flow has no closed form.
    #[error("C N differs from -w I, w = {w:e}, by {deviation:e}; rounding explains at most {tolerance:e}")]
    NotRadial {
        /// The rate that was stated.
        w: f64,
        /// Largest entry of `|C N + w I|`.
        deviation: f64,
        /// The largest deviation accepted.
        tolerance: f64,
    },
}
