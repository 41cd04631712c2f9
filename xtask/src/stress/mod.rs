//! What is tried by the million, for longer than a suite of tests may take.

pub(crate) mod proof;
pub(crate) mod theorems;
