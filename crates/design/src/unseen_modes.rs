//! Modes that no output sees, decided exactly.
//!
//! Floating point calls a mode unobservable when its margin is below a tolerance relative to the norm of A. What
//! follows from that depends on the numbers as stored: an entry of 1e-20 may be enough to see the mode, and a mode of
//! -1e-9 in a plant with another of -1e8 decays. Only `luenberger_proof::statement::hidden_motion` says that no
//! observer exists.

use luenberger_linalg::RealMatrixView;
use luenberger_lmi::proof_matrix;
use luenberger_proof::statement::{HIDDEN_ORDER, TimeDomain, hidden_motion};

/// What is decided of the unobservable modes of a pair (A, C), for the numbers as stored.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum UnseenModes {
    /// There are none: the pair is observable.
    None,
    /// They all decay: the pair is detectable.
    Decay,
    /// One of them does not decay: no observer exists.
    Remain,
    /// Not decided: the plant has more states than [`HIDDEN_ORDER`], or its matrices are no pair of finite numbers.
    Undecided,
}

impl UnseenModes {
    /// Decides for A, n x n, and C, p x n. Exact elimination, of numbers that grow with n.
    ///
    /// ```
    /// use luenberger_design::{TimeDomain, UnseenModes};
    /// use nalgebra::dmatrix;
    /// // The unseen state decays, if slowly.
    /// let a = dmatrix![-1e-9, 0.0; 0.0, -1e8];
    /// assert_eq!(UnseenModes::of(&a, &dmatrix![0.0, 1.0], TimeDomain::Continuous), UnseenModes::Decay);
    /// assert_eq!(UnseenModes::of(&a, &dmatrix![0.0, 1.0], TimeDomain::Discrete), UnseenModes::Decay);
    /// assert_eq!(UnseenModes::of(&a, &dmatrix![1.0, 0.0], TimeDomain::Discrete), UnseenModes::Remain);
    /// assert_eq!(UnseenModes::of(&a, &dmatrix![1.0, 1e-300], TimeDomain::Continuous), UnseenModes::None);
    /// ```
    pub fn of<'a>(a: impl Into<RealMatrixView<'a>>, c: impl Into<RealMatrixView<'a>>, time: TimeDomain) -> Self {
        let (a, c) = (proof_matrix(&a.into().into_owned()), proof_matrix(&c.into().into_owned()));
        let hidden = match hidden_motion(&a, &c) {
            Ok(Some(hidden)) => hidden,
            Ok(None) if a.rows() <= HIDDEN_ORDER => return Self::None,
            _ => return Self::Undecided,
        };
        let decays = match time {
            TimeDomain::Continuous => hidden.decays_at(0.0),
            TimeDomain::Discrete => hidden.decays_in_steps(),
        };
        match decays {
            Some(true) => Self::Decay,
            Some(false) => Self::Remain,
            None => Self::Undecided,
        }
    }

    /// The dimension of the unobservable subspace of (A, C), decided exactly; none where it is not.
    pub fn count<'a>(a: impl Into<RealMatrixView<'a>>, c: impl Into<RealMatrixView<'a>>) -> Option<usize> {
        let (a, c) = (proof_matrix(&a.into().into_owned()), proof_matrix(&c.into().into_owned()));
        match hidden_motion(&a, &c) {
            Ok(Some(hidden)) => Some(hidden.basis.cols()),
            Ok(None) if a.rows() <= HIDDEN_ORDER => Some(0),
            _ => None,
        }
    }

    /// Whether an observer exists; none where that is not decided.
    pub fn is_detectable(self) -> Option<bool> {
        match self {
            Self::None | Self::Decay => Some(true),
            Self::Remain => Some(false),
            Self::Undecided => None,
        }
    }
}
