//! The schema of study files, and the kinds of observers that it has.

use luenberger_study::kinds::registry;
use luenberger_study::schema::{json_schema, schema};
use serde_json::Value;

#[test]
fn every_kind_of_observer_says_where_it_comes_from() {
    for kind in registry() {
        assert!(!kind.source.is_empty(), "{} has no source", kind.name);
    }
}

#[test]
fn the_schema_is_json_with_every_kind_of_observer() {
    let read: Value = serde_json::from_str(&schema()).unwrap();
    assert!(read == json_schema());
    for kind in registry() {
        assert!(schema().contains(&format!("\"{}\"", kind.name)), "{}", kind.name);
    }
}
