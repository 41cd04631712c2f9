//! What the command `luenberger` does: a study is read, its plant is made from text, observers are designed, run and compared.

#![deny(missing_docs)]

pub mod expression;
