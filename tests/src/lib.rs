//! What crosses crates: see the integration tests beside this file. [`falsify`] tries to contradict the theorems of certificates.

pub mod falsify;
