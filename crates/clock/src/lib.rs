//! The clock that time limits read: [`Instant`]; and the flag with which another thread ends work: [`stoppable`].
//!
//! It is that of the standard library, except in WebAssembly without an operating system, where that one panics. There
//! it is what the program gave to [`set_clock`], and without it time stands still: no limit is reached. Only limits and
//! measured times depend on the clock, never a result.
//!
//! ```
//! use luenberger_clock::Instant;
//! use std::time::Duration;
//! let began = Instant::now();
//! let end = began.checked_add(Duration::from_secs(60)).ok_or("a time that can be written")?;
//! assert!(Instant::now() < end && end.saturating_duration_since(began) == Duration::from_secs(60));
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

#![deny(missing_docs)]

pub mod page;
mod stop;

#[cfg(all(target_family = "wasm", target_os = "unknown"))]
pub use page::Instant;
#[cfg(not(all(target_family = "wasm", target_os = "unknown")))]
pub use std::time::Instant;

pub use page::set_clock;
pub use stop::{is_stopped, set_stop_flag, stop_flag, stoppable};

/// The example of `README.md`, compiled and run with the documentation's tests.
#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct Readme;
