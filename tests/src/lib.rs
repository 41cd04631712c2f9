//! Tests across crates: see the integration tests beside this file. [`falsify`] tries to contradict the theorems of
//! certificates, [`words`] the sentences of designs.
#![allow(clippy::missing_panics_doc, clippy::return_self_not_must_use, reason = "for the tests beside it only")]

pub mod falsify;
pub mod kkl_maps;
pub mod words;

/// The examples of the README and of `docs/`, compiled and run with the documentation's tests.
#[cfg(doctest)]
mod pages {
    #[doc = include_str!("../../README.md")]
    struct Readme;
    #[doc = include_str!("../../docs/adding-an-observer.md")]
    struct AddingAnObserver;
    #[doc = include_str!("../../docs/from-matlab.md")]
    struct FromMatlab;
    #[doc = include_str!("../../docs/reduced-order.md")]
    struct ReducedOrder;
}
