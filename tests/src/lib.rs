//! What crosses crates: see the integration tests beside this file.
