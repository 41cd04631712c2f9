//! Randomized tests with millions of cases, too long for the test suite.

pub(crate) mod proof;
pub(crate) mod theorems;
pub(crate) mod words;
