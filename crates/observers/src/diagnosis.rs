//! Diagnosis of an observer at run time: domains left, missing excitation, loss of rank, overflow.
//!
//! A right-hand side returns no error: a value that leaves its domain is kept finite, and [`Diagnose`] reports it with
//! numbers. On a target: call it beside the step, as often as there is time for. After a simulation: the
//! trajectory has the observer's own states, and u and y of the same rows,
//!
//! ```text
//! let run = scenario.partial_observer("name", &observer, &xhat0, &states).run()?;
//! let own = &run.observer("name")?.state;
//! for k in 0..run.t.len() {
//!     let row = |matrix: &DMatrix<f64>| matrix.row(k).transpose();
//!     let (z, u, y) = (row(own), row(&run.u), row(&run.y));
//!     observer.diagnose(run.t[k], &Column::from_slice(z.as_slice()), &Column::from_slice(u.as_slice()), &Column::from_slice(y.as_slice()));
//! }
//! ```
//!
//! (scenarios take observers by reference, so that it is still there). With noise the observer saw another y than the
//! row has.

use crate::observer::Observer;

/// The state of health of an observer at one instant.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Diagnosis<T> {
    /// Nothing to report.
    Sound,
    /// A parameter has reached the end of the domain in which it makes an estimate, and is held there.
    LeftDomain {
        /// Index of the parameter, from 0.
        parameter: usize,
        /// Its value.
        value: T,
        /// The bound it is held at.
        bound: T,
    },
    /// A parameter is about to leave its domain: at its present rate it does so within the time constant of the
    /// observer's filters.
    LeavingDomain {
        /// Index of the parameter, from 0.
        parameter: usize,
        /// Its value.
        value: T,
        /// The bound of the domain.
        bound: T,
        /// The time that is left at the present rate.
        time: T,
    },
    /// The regression is not sufficiently exciting: some direction of theta is not yet estimated.
    NotExciting {
        /// The excitation: see [`ParameterEstimator::excitation`](crate::estimator::ParameterEstimator::excitation).
        excitation: T,
        /// The required excitation.
        wanted: T,
    },
    /// A Jacobian lacks the full rank that is required; the deficient directions are not corrected.
    RankDeficient {
        /// The rank found.
        rank: usize,
        /// The rank needed.
        needed: usize,
        /// The smallest singular value.
        smallest: T,
        /// The largest singular value.
        largest: T,
    },
    /// A divisor is below its bound; the bound is used instead.
    Division {
        /// The divisor.
        divisor: T,
        /// The bound it is held at.
        bound: T,
    },
    /// An entry of the right-hand side is not finite; `KklPebObserver` replaces it by 0.
    Overflow {
        /// Index of the entry of the state, from 0.
        entry: usize,
    },
}

/// An observer that can diagnose its state at run time.
pub trait Diagnose<T>: Observer<T> {
    /// The first problem found at this instant, or [`Diagnosis::Sound`]. Costs about as much as a derivative.
    fn diagnose(&self, t: T, state: &Self::State, u: &Self::Input, y: &Self::Output) -> Diagnosis<T>;
}
