//! What the command `luenberger` does: a study is read, its plant is made from text, observers are designed, run and compared.
//!
//! | file | subject |
//! |---|---|
//! | [`expression`] | right-hand sides as text, over every scalar |
//! | [`plant`] | plants whose rows are expressions |
//! | [`signal`] | inputs and references: expressions of time, tables, feedback |
//! | [`table`] | CSV: measured logs, tables of inputs |

#![deny(missing_docs)]

pub mod expression;
pub mod plant;
pub mod signal;
pub mod table;
