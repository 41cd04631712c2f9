//! What is said of input that is not what it should be.

use luenberger_studio::{Message, MessageError, Quiet, answer};
use proptest::prelude::*;
use serde_json::{Value, json};

use crate::{ask, given, refused};

/// A valid message, its length in front of its JSON.
fn raw(json: &str, rest: &[u8]) -> Vec<u8> {
    [&(json.len() as u32).to_le_bytes()[..], json.as_bytes(), rest].concat()
}

#[test]
fn messages_that_are_cut_or_forged() {
    let whole = raw(r#"{"do": "zip", "files": [{"name": "a", "bytes": 3}]}"#, b"abc");
    assert_eq!(Message::read(&whole).unwrap().files, [("a".to_owned(), b"abc".to_vec())]);
    for end in 0..whole.len() {
        let cut = Message::read(&whole[..end]).unwrap_err();
        assert!(matches!(cut, MessageError::Cut { found, needed } if found == end && needed > end), "{end}: {cut:?}");
    }
    let longer = [&whole[..], b"de"].concat();
    assert_eq!(Message::read(&longer), Err(MessageError::Longer { more: 2 }));
    let most = format!(r#"{{"files": [{{"name": "a", "bytes": {}}}]}}"#, u64::MAX);
    assert!(matches!(Message::read(&raw(&most, b"")), Err(MessageError::Cut { .. })));
    for name in ["", "/etc/passwd", "../a", "a/../b", "a//b", "./a", "a\\b"] {
        let json = json!({ "files": [{ "name": name, "bytes": 0 }] }).to_string();
        let expected = Err(MessageError::Name { name: name.to_owned() });
        assert_eq!(Message::read(&raw(&json, b"")), expected, "{name}");
    }
    let twice = r#"{"files": [{"name": "a", "bytes": 0}, {"name": "a", "bytes": 0}]}"#;
    assert_eq!(Message::read(&raw(twice, b"")), Err(MessageError::Twice { name: "a".to_owned() }));
    for json in ["[]", "3", r#"{"files": {}}"#, r#"{"files": [3]}"#, r#"{"files": [{"name": "a", "bytes": -1}]}"#] {
        assert_eq!(Message::read(&raw(json, b"")), Err(MessageError::Form), "{json}");
    }
    assert!(matches!(Message::read(&raw("{", b"")), Err(MessageError::Json { .. })));
    // The module says so, and goes on.
    let said = Message::read(&answer(&whole[..9], &Quiet)).unwrap();
    assert!(said.json["error"]["message"].as_str().unwrap().contains("the message is cut"));
}

#[test]
fn requests_that_do_not_exist_or_lack_something() {
    assert!(refused(json!({ "do": "fly" }), &[]).contains("there is no request \"fly\""));
    assert!(refused(json!({}), &[]).contains("about, check, run"));
    for request in ["check", "run", "export", "advise", "tune"] {
        assert!(refused(json!({ "do": request }), &[]).contains("the text of a study"), "{request}");
    }
    let (text, _) = given("double-integrator");
    for (key, value) in [
        ("step", json!("leap")),
        ("step", json!(3)),
        ("limit_seconds", json!(-1)),
        ("figures", json!("yes")),
        ("format", json!("yaml")),
    ] {
        let mut request = json!({ "do": "run", "study": text });
        request[key] = value;
        assert!(refused(request, &[]).contains(&format!("the request needs {key}")), "{key}");
    }
    for (key, value) in [("language", json!("ada")), ("scalar", json!("f16")), ("period", json!(0))] {
        let mut request = json!({ "do": "export", "study": text, "observer": "cubic" });
        request[key] = value;
        assert!(refused(request, &[]).contains(&format!("the request needs {key}")), "{key}");
    }
    assert!(refused(json!({ "do": "export", "study": text, "observer": "cubist" }), &[]).contains("cubist"));
    assert!(refused(json!({ "do": "verify" }), &[]).contains("one file"));
    assert!(refused(json!({ "do": "verify" }), &[("a", b""), ("b", b"")]).contains("one file"));
    assert!(refused(json!({ "do": "tune", "study": text }), &[]).contains("tune needs a table [tune]"));
}

#[test]
fn studies_that_are_too_long_or_name_files_that_are_not_there() {
    let long = format!("# {}\n", "x".repeat(10_000_000));
    assert!(refused(json!({ "do": "check", "study": long }), &[]).contains("the study has 10000003 bytes"));
    let (text, data) = given("measured-log");
    let check = ask(json!({ "do": "check", "study": text }), &[]);
    let said = check.json["diagnostics"][0]["message"].as_str().unwrap();
    assert_eq!(said, "measured-log.csv cannot be read: there is no file of this name");
    assert_eq!(ask(json!({ "do": "check", "study": text }), &data).json["diagnostics"], json!([]));
    let check = ask(json!({ "do": "check", "study": text }), &[("measured-log.csv", b"\xff\xfe")]);
    assert!(check.json["diagnostics"][0]["message"].as_str().unwrap().contains("UTF-8"));
    assert!(refused(json!({ "do": "columns" }), &[("a.csv", b"")]).starts_with("a.csv: "));
}

/// Nothing is read but what is given: not the files of this machine.
#[test]
fn a_study_does_not_reach_the_disk() {
    let (text, _) = given("measured-log");
    let path = concat!(env!("CARGO_MANIFEST_DIR"), "/../study/templates/measured-log.csv");
    assert!(std::path::Path::new(path).exists());
    let text = text.replace("\"measured-log.csv\"", &format!("{path:?}"));
    let check = ask(json!({ "do": "check", "study": text }), &[]);
    assert!(check.json["diagnostics"][0]["message"].as_str().unwrap().contains("there is no file of this name"));
}

/// Depth of brackets that a parser without a bound does not survive.
#[test]
fn studies_that_are_deep() {
    for (name, open) in [("study.toml", "a = ["), ("study.json", "{\"a\": [")] {
        let study = format!("{open}{}", "[".repeat(100_000));
        let check = ask(json!({ "do": "check", "study": study, "name": name }), &[]);
        assert!(!check.json["diagnostics"].as_array().unwrap().is_empty(), "{name}");
    }
}

proptest! {
    /// Whatever the bytes are, the answer is a message with an error, or the answer to a request.
    #[test]
    fn any_bytes_have_an_answer(bytes in prop::collection::vec(any::<u8>(), 0..64)) {
        let said = Message::read(&answer(&bytes, &Quiet)).unwrap();
        prop_assert!(said.json["error"]["message"].is_string());
    }

    /// A message is read as it was written.
    #[test]
    fn messages_are_read_as_written(
        names in prop::collection::btree_set("[a-z]{1,4}(/[a-z.]{3,5}x)?", 0..4),
        bytes in prop::collection::vec(any::<u8>(), 0..40),
        text in ".*",
    ) {
        let files = names.into_iter().enumerate().map(|(k, name)| (name, bytes[..bytes.len() / (k + 1)].to_vec()));
        let message = Message::new(json!({ "text": text, "nothing": Value::Null })).with(files);
        prop_assert_eq!(Message::read(&message.bytes()).unwrap(), message);
    }
}
