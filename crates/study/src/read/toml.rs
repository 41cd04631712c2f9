//! TOML by the crate `toml`, which continues after a mistake and keeps the position of every value.

use ::toml::Spanned;
use ::toml::de::{DeTable, DeValue};
use luenberger_proof::wording::counted;

use crate::diagnostic::Diagnostic;
use crate::reader::tree::{Entry, Node, Value};

/// The most syntax errors that are said: a file that is no study has one in every line.
const MOST: usize = 3;

/// The tree of a TOML document, and its syntax errors.
pub(super) fn tree(text: &str) -> (Node, Vec<Diagnostic>) {
    let (table, errors) = DeTable::parse_recoverable(text);
    let mistakes = errors.iter().map(|error| {
        let span = error.span().unwrap_or(0..0);
        let (message, expected) = match error.message().split_once(", expected ") {
            Some((message, expected)) => (message.to_owned(), format!("expected {expected}")),
            None => (error.message().to_owned(), "this is not TOML".to_owned()),
        };
        Diagnostic::new(span, message, expected)
    });
    let mut mistakes: Vec<Diagnostic> = mistakes.collect();
    if let Some(more) = mistakes.len().checked_sub(MOST).filter(|more| *more > 0) {
        mistakes.truncate(MOST);
        mistakes[MOST - 1].help = Some(format!("and {}: is this a study in TOML?", counted(more, "more syntax error")));
    }
    let span = table.span();
    (Node { span, value: Value::Table(entries(table.get_ref())) }, mistakes)
}

fn entries(table: &DeTable<'_>) -> Vec<Entry> {
    let entry = |(key, value): (&Spanned<_>, &Spanned<DeValue<'_>>)| {
        let key: &Spanned<std::borrow::Cow<'_, str>> = key;
        Entry { key: key.get_ref().clone().into_owned(), span: key.span(), node: node(value) }
    };
    let mut entries: Vec<Entry> = table.iter().map(entry).collect();
    // The crate sorts by name; here the order of the file is restored.
    entries.sort_by_key(|entry| entry.span.start);
    entries
}

fn node(value: &Spanned<DeValue<'_>>) -> Node {
    let inner = match value.get_ref() {
        DeValue::String(text) => Value::Text(text.clone().into_owned()),
        DeValue::Integer(integer) => match i64::from_str_radix(integer.as_str(), integer.radix()) {
            Ok(x) => Value::Number(x as f64, true),
            Err(_) => Value::Other("an integer of more than 64 bits"),
        },
        DeValue::Float(float) => match float.as_str().parse::<f64>() {
            Ok(x) => Value::Number(x, false),
            Err(_) => Value::Other("a number out of range"),
        },
        DeValue::Boolean(truth) => Value::Truth(*truth),
        DeValue::Datetime(_) => Value::Other("a date"),
        DeValue::Array(array) => Value::List(array.iter().map(node).collect()),
        DeValue::Table(table) => Value::Table(entries(table)),
    };
    Node { span: value.span(), value: inner }
}
