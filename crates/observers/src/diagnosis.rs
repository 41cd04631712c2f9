//! What an observer knows about its own trouble.
//!
//! A right-hand side returns no error; where something can leave its domain it is kept finite instead, and [`Diagnose`]
//! says so, with numbers. On a target: call it beside the step, as often as there is time for. After a simulation: the
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
    /// The regression has not shown all parameters: what is estimated of them is where they started.
    NotExciting {
        /// The excitation: see [`ParameterEstimator::excitation`](crate::estimator::ParameterEstimator::excitation).
        excitation: T,
        /// What was asked for.
        wanted: T,
    },
    /// A Jacobian that has to have full rank has not; the directions without rank are left alone.
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
    /// Something that is divided by is too small; the bound is divided by instead.
    Division {
        /// The divisor.
        divisor: T,
        /// The bound it is held at.
        bound: T,
    },
    /// The right-hand side has overflown; the entry stands still.
    Overflow {
        /// Index of the entry of the state, from 0.
        entry: usize,
    },
}

/// An observer that can say whether something is wrong.
pub trait Diagnose<T>: Observer<T> {
    /// The first trouble there is at this instant, or [`Diagnosis::Sound`]. Costs about as much as a derivative.
    fn diagnose(&self, t: T, state: &Self::State, u: &Self::Input, y: &Self::Output) -> Diagnosis<T>;
}
