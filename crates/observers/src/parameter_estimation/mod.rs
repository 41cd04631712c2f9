//! The observers of one paper, Yi, Ortega and Zhang on [KKL+PEB] observers: those by parameter estimation with their
//! parts, and the immersion-and-invariance observers that it compares them with.
//!
//! | file | subject |
//! |---|---|
//! | [`pebo`], [`kkl_peb`] | parameter-estimation-based observers, and [KKL+PEB] observers, which are both |
//! | `regression` | the linear regression of both, `Y = M theta`, by filters of measured signals |
//! | [`filters`], [`estimator`] | the filters; gradient, DREM, excitation |
//! | [`cascade`] | [KKL+PEB] observers of a class of cascades |
//! | [`immersion_invariance`] | immersion-and-invariance observers |

pub mod cascade;
pub mod estimator;
pub mod filters;
pub mod immersion_invariance;
pub mod kkl_peb;
pub mod pebo;
pub(crate) mod regression;
