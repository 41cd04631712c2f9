//! Benchmarks against other tools or published results.

pub(crate) mod linalg;
pub(crate) mod lmi;
pub(crate) mod proof;
