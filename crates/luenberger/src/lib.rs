//! Design, certify, simulate and deploy state observers.
//!
//! This crate re-exports the library crates of the project under one name. Each can also be used alone:
//!
//! | here | crate | for |
//! |---|---|---|
//! | [`plants`] | `luenberger-plants` | plants: the traits, and benchmark plants |
//! | [`observers`] | `luenberger-observers` | the observers as they run on the target: `no_std`, no allocation |
//! | [`design`] | `luenberger-design` | from a plant to an observer with its certificate |
//! | [`sim`] | `luenberger-sim` | simulation of plants with observers, comparison, replay of logs |
//! | [`linalg`] | `luenberger-linalg` | matrix equations, placement, observability |
//! | [`lmi`] | `luenberger-lmi` | linear matrix inequalities, verified outside the solver |
//! | [`proof`] | `luenberger-proof` | rigorous verification in exact or interval arithmetic; certificates |
//!
//! Not re-exported, because of their dependencies (a parser, plotting libraries): `luenberger-study` reads plants and
//! studies from text and writes reports, `luenberger-figures` draws figures, and the command `luenberger`
//! (`luenberger-cli`) does both from a terminal.
//!
//! Matrices are those of [`nalgebra`], which is part of the interface and re-exported in the matching version:
//! the [`prelude`] has the name, which its macros need in scope, with `dmatrix!`, `dvector!`, `DMatrix` and `DVector`.
//! [`Error`] collects the errors of all crates.
//!
//! `examples/` has a program for each observer.
//!
//! ```
//! use luenberger::prelude::*;
//!
//! // Position is measured, velocity is wanted.
//! let plant = StateSpace::new(dmatrix![0.0, 1.0; 0.0, 0.0], dmatrix![0.0; 1.0], dmatrix![1.0, 0.0])?;
//! let linear = LinearDesign::with_poles_and_weight(&plant, &[-2.0, -5.0], LyapunovWeight::Identity(10.0))?;
//! let cubic = CubicDesign::new(&linear, &dmatrix![10.0], &CubicGain::Gamma(2.0))?;
//! assert!(cubic.certificate.is_proved());
//!
//! let run = Scenario::new(&plant)
//!     .initial_state(&[-3.0, -3.0])
//!     .observer("cubic", cubic.observer.clone(), &[0.0, 0.0])
//!     .until(8.0, 201)
//!     .run()?;
//! assert!(run.error_trace("cubic", 1)?.last().abs() < 1e-5);
//! # Ok::<(), luenberger::Error>(())
//! ```
#![deny(missing_docs)]

mod error;

pub use error::Error;
pub use luenberger_design as design;
pub use luenberger_linalg as linalg;
pub use luenberger_lmi as lmi;
pub use luenberger_observers as observers;
pub use luenberger_plants as plants;
pub use luenberger_proof as proof;
pub use luenberger_sim as sim;
pub use nalgebra;

/// What most programs need: `use luenberger::prelude::*;`.
pub mod prelude {
    pub use luenberger_design::{
        Certificate, Certified, CubicDesign, CubicGain, DesignError, DiscreteDesign, DiscreteLpvDesign, EnclosureError,
        FeedbackDesign, GainOptions, IntervalDesign, KklCandidate, KklDesign, KklError, KklPebDesign, LinearDesign,
        LipschitzDesign, LipschitzPlant, LpvDesign, LpvError, LyapunovWeight, NormFilterDesign, NumericalKklDesign,
        NumericalKklError, OperatingPointError, ReducedOrderDesign, Region, SampledCubicDesign, Sector,
        UnknownInputDesign, cubic_lmi_design, nonlinear_observability::ObservabilityError,
    };
    pub use luenberger_linalg::LinalgError;
    pub use luenberger_lmi::LmiError;
    pub use luenberger_observers::{
        CubicObserver, Diagnose, DiscreteLinearObserver, DiscreteNonlinearObserver, ExtendedKalmanFilter,
        GaussianEstimate, HighGainMap, HighGainObserver, Immersion, ImmersionInvarianceObserver, KalmanFilter,
        KalmanModel, KklMap, KklObserver, KklPebObserver, LinearObserver, MeanValueObserver, MovingHorizonEstimator,
        NoiseModel, NonlinearLuenbergerObserver, Observer, ObserverDimensions, ObserverError, PeboObserver, Regression,
        SampledCubicGains, SampledCubicObserver, SampledObserver, StationaryKalmanFilter, UnscentedKalmanFilter,
    };
    pub use luenberger_plants::{
        ByDual, Differentiable, Dimensions, LinearPlant, Plant, PlantError, Shape, StateSpace, from_fn, linearize,
    };
    pub use luenberger_proof::{ProofError, Verdict};
    pub use luenberger_sim::{
        Comparison, Integrand, Noise, Purpose, Recording, Replay, Scenario, Signal, SimError, Trajectory, metrics,
    };
    pub use nalgebra::{self, DMatrix, DVector, dmatrix, dvector};
}

/// The example of `README.md`, compiled and run with the documentation's tests.
#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct Readme;
