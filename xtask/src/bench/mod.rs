//! What is measured beside others, or against what is published.

pub(crate) mod linalg;
pub(crate) mod lmi;
pub(crate) mod proof;
