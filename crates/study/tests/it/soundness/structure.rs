//! Outputs that are states, chains and time invariance are read from expressions.
