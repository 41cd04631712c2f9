//! Tests of the requests: what they answer, that files are those of the commands, and what is said of bad input.

mod bad_input;
mod page;
mod requests;
mod same_files;

use luenberger_studio::{Message, Quiet, answer};
use luenberger_study::{Template, template};
use serde_json::Value;

/// The answer to a request, which is a message.
fn ask(json: Value, files: &[(&str, &[u8])]) -> Message {
    let files = files.iter().map(|(name, bytes)| ((*name).to_owned(), bytes.to_vec()));
    Message::read(&answer(&Message::new(json).with(files).bytes(), &Quiet)).unwrap()
}

/// The answer to a request that succeeds.
fn asked(json: Value, files: &[(&str, &[u8])]) -> Message {
    let answer = ask(json, files);
    assert!(answer.json["error"].is_null(), "{}", answer.json["error"]);
    answer
}

/// The message of the error of a request.
fn refused(json: Value, files: &[(&str, &[u8])]) -> String {
    let answer = ask(json, files);
    assert!(answer.files.is_empty());
    answer.json["error"]["message"].as_str().unwrap().to_owned()
}

/// A template, and its files.
fn given(name: &str) -> (&'static str, Vec<(&'static str, &'static [u8])>) {
    let Template { text, files, .. } = template::template(name).unwrap();
    (text, files.iter().map(|(name, text)| (*name, text.as_bytes())).collect())
}

/// The bytes of a file of an answer.
fn file<'a>(answer: &'a Message, name: &str) -> &'a [u8] {
    let found = answer.files.iter().find(|(file, _)| file == name);
    let (_, bytes) = found.unwrap_or_else(|| panic!("no {name} among {:?}", names(answer)));
    bytes
}

fn names(answer: &Message) -> Vec<&str> {
    answer.files.iter().map(|(name, _)| name.as_str()).collect()
}
