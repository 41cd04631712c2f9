//! An empty crate with a list of features, see its `Cargo.toml`.
