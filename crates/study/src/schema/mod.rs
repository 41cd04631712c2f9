//! Description of study files as data: tables, keys and types.
//!
//! The description has three uses: files are checked against it ([`crate::read`]), the JSON Schema for editors is
//! generated from it ([`json_schema`]), and the guide can list it. Keys that are not in it are errors.

mod advise;
mod estimate;
mod frequency;
mod json;
mod keys;
mod observers;
mod truth;
mod tune;

pub use crate::keys::{Key, Range, Table, Type, Variant, Variants, optional, required};
pub use json::{json_schema, schema};
pub use keys::STUDY;
pub(crate) use keys::{QUANTITIES, SWEPT};
pub(crate) use observers::OBSERVER;
