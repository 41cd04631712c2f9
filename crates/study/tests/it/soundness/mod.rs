//! What a report says of an observer is implied by its certificate: studies that once made it say more.

mod enclosures;
mod maps;
mod refusals;
mod sentences;
mod structure;
