//! Simulation of plants with observers: trajectories, events, noise, metrics and comparisons.
//!
//! A [`Scenario`] is a plant, any number of observers, an input and perhaps noise; running it integrates plant and
//! observers as one stacked equation, through the very objects that run on the target, and gives a [`Trajectory`] with
//! dense output.
//!
//! Example 1 of the cubic-observer paper:
//! ```
//! use luenberger_observers::{CubicObserver, LinearObserver};
//! use luenberger_sim::{Scenario, Signal, metrics};
//! use nalgebra::{Matrix1, Vector2};
//!
//! let plant = luenberger_plants::double_integrator();
//! let l = Vector2::new(7.0, 10.0);
//! let n = Vector2::new(-168.0, -196.0) / 17.0; // -gamma P^-1 C' theta
//! let trajectory = Scenario::new(plant.clone())
//!     .initial_state(&[-3.0, -3.0])
//!     .input(Signal::scalar(f64::sin))
//!     .observer("linear", LinearObserver::of(plant.clone(), l)?, &[0.0, 0.0])
//!     .observer("cubic", CubicObserver::of(plant, l, n, Matrix1::new(10.0))?, &[0.0, 0.0])
//!     .until(4.0, 401)
//!     .run()?;
//!
//! let e2 = trajectory.error_trace("cubic", 1)?;
//! let overshoot = metrics::overshoot(&e2).ok_or("e2 changes its sign")?;
//! let settling = metrics::settling_last(&e2, 0.05).ok_or("e2 settles")?;
//! assert_eq!(format!("{:.3} {settling:.2}", overshoot.value), "0.485 1.65");
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! | file | subject |
//! |---|---|
//! | [`scenario`], [`trajectory`] | the setup of a run; its result |
//! | [`compare`] | observers side by side on one plant, from the same information |
//! | [`scores`] | scores of errors, in continuous time or at the samples |
//! | [`signal`], [`noise`] | inputs and feedback; measurement noise |
//! | [`disturbance`] | unknown to the observers: process noise, delays, faults, quantisation, dropouts, outliers |
//! | [`change`] | changes of the plant during a run, jumps of its state |
//! | [`sensor`] | sensors with different sampling periods; missing measurements |
//! | [`sample_times`] | samples at varying periods, some of them missed |
//! | [`replay`], [`samples`] | observers on recorded data; sampled quantities and their interpolation |
//! | [`chi_squared`] | the distribution that consistency is tested by |
//! | [`integral`] | integrals along a run, as extra states |
//! | [`integrate`], [`dense`] | the integrators and their dense output; between jumps of a linear run its exponential |
//! | [`gramian`] | the empirical observability Gramian |
//! | [`events`], [`metrics`] | crossings and extrema of any quantity; peak, settling, Lyapunov value |

#![deny(missing_docs)]

pub mod change;
pub mod chi_squared;
pub mod compare;
pub mod dense;
pub mod disturbance;
mod dop853;
mod dop853_tableau;
mod erased;
pub mod error;
pub mod events;
mod exponential;

pub mod gramian;
pub mod integral;
pub mod integrate;
pub mod metrics;
mod model;
mod moving;
pub mod noise;
mod particles;
mod radau;
pub mod replay;
mod rows;
mod run;
pub mod sample_times;
pub mod samples;
pub mod scenario;
mod score_grid;
pub mod scores;
pub mod sensor;
pub mod signal;
mod step;
pub mod trajectory;
mod updates;
pub mod view;

pub use change::Change;
pub use compare::{Compared, Comparison, Cost};
pub use dense::Dense;
pub use disturbance::{Disturbances, Fault, MeasurementLoss};
pub use erased::{AnyObserver, Continuous, Sampled};
pub use error::SimError;
pub use events::{Crossing, Extremum, Trace};
pub use gramian::{EmpiricalGramian, GramianSettings, empirical_gramian};
pub use integral::Integrand;
pub use integrate::{Integrator, Settings, solve};
pub use luenberger_random::Purpose;
pub use nalgebra;
pub use noise::Noise;
pub use particles::SeededParticles;
pub use replay::{BetweenRows, Recording, Replay, Replayed, ReplayedObserver};
pub use rows::row_times;
pub use sample_times::{SampleTime, SampleTimes};
pub use samples::{SampleInterpolation, Samples};
pub use scenario::Scenario;
pub use scores::{ErrorMetrics, Errors, Estimates, ScoreGrid, StateScores};
pub use sensor::Sensor;
pub use signal::Signal;
pub use trajectory::{IntegralTrajectory, ObserverTrajectory, Trajectory};
pub use updates::SampleEstimates;
pub use view::View;

#[doc(hidden)]
pub mod internals {
    //! For the tests of this crate, no part of its interface.

    pub use crate::radau::{ALPHA, BETA, GAMMA, R6, T, T_INVERSE};
}

/// The example of `README.md`, compiled and run with the documentation's tests.
#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct Readme;
