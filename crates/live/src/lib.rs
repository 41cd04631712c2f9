//! The observers of a report, simulated and verified in its page while sliders are moved.
//!
//! The code is that of the other crates: `luenberger-sim` integrates, `luenberger-observers` has the right-hand sides,
//! `luenberger-proof` verifies the certificates. [`Experiment`] is what a report embeds, as JSON; [`Sliders`] are the
//! positions of the sliders; [`Outcome`] is what the page draws. `cargo xtask live` compiles the crate to WebAssembly,
//! and compares the module's results in a browser with those of this machine, bit by bit.
//!
//! ```
//! use luenberger_live::{Experiment, ObserverKind, StoredObserver, StoredPlant, Sliders, run};
//! use luenberger_observers::LinearObserver;
//! let plant = luenberger_plants::double_integrator().to_dynamic();
//! let linear = LinearObserver::of(plant.clone(), nalgebra::dmatrix![7.0; 10.0])?;
//! let observer = StoredObserver::new("linear", ObserverKind::Linear(Box::new(linear)), &[0.0, 0.0]);
//! let experiment = Experiment::new(StoredPlant::linear(&plant), &[1.0, 0.0], 8.0, 81).observer(observer);
//! let outcome = run(&experiment, &Sliders::NEUTRAL);
//! assert!(outcome.runs[0].scores.as_ref().is_some_and(|scores| scores.last < 1e-5));
//! // Without a gain the error of the position remains.
//! let outcome = run(&experiment, &Sliders { gain: 0.0, ..Sliders::NEUTRAL });
//! assert_eq!(outcome.runs[0].scores.as_ref().map(|scores| scores.last), Some(1.0));
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

mod any_plant;
mod certificate;
mod experiment;
mod input;
mod join;
mod noise;
#[cfg(feature = "page")]
pub mod page;
mod plant;
mod plants;
mod rows;
mod run;
mod truth;
// The module of reports is built without the page; where the crate is a part of another module, nothing is exported.
#[cfg(all(target_arch = "wasm32", not(feature = "page")))]
pub mod wasm;

pub use certificate::{GainVerdict, verifies, verify};
pub use experiment::{
    Estimates, Experiment, Feedback, FeedbackSignal, Hypotheses, Law, Lookup, Method, ObserverKind, OperatingPoint,
    Sensor, Sliders, StoredObserver, Table,
};
pub use nalgebra;
pub use noise::StoredNoise;
pub use plant::StoredPlant;
pub use rows::Rows;
pub use run::{Outcome, Run, Scores, run};
pub use truth::{Event, Fault, MeasurementLoss, Truth};

/// The example of `README.md`, compiled and run with the documentation's tests.
#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct Readme;
