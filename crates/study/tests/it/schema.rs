//! The schema of study files, and the kinds of observers that it has.

use luenberger_study::schema::{json_schema, observer_sources, schema};
use serde_json::Value;

#[test]
fn every_kind_of_observer_says_where_it_comes_from() {
    for kind in observer_sources() {
        assert!(!kind.source.is_empty(), "{}: no entry in SOURCES", kind.kind);
    }
}

#[test]
fn the_schema_is_json_with_every_kind_of_observer() {
    let read: Value = serde_json::from_str(&schema()).unwrap();
    assert!(read == json_schema());
    for kind in observer_sources() {
        assert!(schema().contains(&format!("\"{}\"", kind.kind)), "{}", kind.kind);
    }
}
