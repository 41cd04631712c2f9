//! The schema of study files, and the kinds of observers that it has.

use luenberger_study::schema::{SCHEMA, json_schema, observer_sources};
use serde_json::Value;

#[test]
fn every_kind_of_observer_says_where_it_comes_from() {
    for kind in observer_sources() {
        assert!(!kind.source.is_empty(), "{}: no entry in SOURCES", kind.kind);
    }
}

/// Run with `UPDATE=1` in the environment after a change of the tables.
#[test]
fn the_shipped_schema_is_current() {
    let current = json_schema();
    if std::env::var_os("UPDATE").is_some() {
        let path = concat!(env!("CARGO_MANIFEST_DIR"), "/schema/study.schema.json");
        std::fs::write(path, serde_json::to_string_pretty(&current).unwrap() + "\n").unwrap();
        return;
    }
    let shipped: Value = serde_json::from_str(SCHEMA).unwrap();
    assert!(shipped == current, "schema/study.schema.json is not what the tables say: run this test with UPDATE=1");
}
