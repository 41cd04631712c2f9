//! Strict JSON by the crate `jsonc-parser`, which keeps the position of every value.

use jsonc_parser::ast::{self, ObjectPropName};
use jsonc_parser::common::Ranged;
use jsonc_parser::{CollectOptions, ParseOptions, parse_to_ast};

use crate::diagnostic::Diagnostic;
use crate::reader::tree::{Entry, Node, Value};

/// Standard JSON: no comments, no trailing commas.
const STRICT: ParseOptions = ParseOptions {
    allow_comments: false,
    allow_loose_object_property_names: false,
    allow_trailing_commas: false,
    allow_missing_commas: false,
    allow_single_quoted_strings: false,
    allow_hexadecimal_numbers: false,
    allow_unary_plus_numbers: false,
    allow_bare_decimal_point_numbers: false,
    allow_non_finite_numbers: false,
    allow_extended_string_escapes: false,
};

/// The tree of a JSON text, and its first syntax error.
pub(super) fn tree(text: &str) -> (Node, Vec<Diagnostic>) {
    let nothing = Node { span: 0..text.len(), value: Value::Table(Vec::new()) };
    match parse_to_ast(text, &CollectOptions::default(), &STRICT) {
        Ok(result) => {
            let Some(value) = result.value else {
                return (nothing, vec![Diagnostic::new(0..0, "the file is empty", "expected an object")]);
            };
            let mut twice = Vec::new();
            (node(&value, &mut twice), twice)
        }
        Err(error) => {
            let range = error.range();
            let mistake = Diagnostic::new(range.start..range.end, error.kind().to_string(), "this is not JSON");
            (nothing, vec![mistake])
        }
    }
}

fn node(value: &ast::Value<'_>, twice: &mut Vec<Diagnostic>) -> Node {
    let range = value.range();
    let inner = match value {
        ast::Value::StringLit(text) => Value::Text(text.value.clone().into_owned()),
        ast::Value::NumberLit(number) => match number.value.parse::<f64>() {
            Ok(x) => Value::Number(x, !number.value.contains(['.', 'e', 'E'])),
            Err(_) => Value::Other("a number out of range"),
        },
        ast::Value::BooleanLit(truth) => Value::Truth(truth.value),
        ast::Value::NullKeyword(_) => Value::Other("null"),
        ast::Value::Array(array) => Value::List(array.elements.iter().map(|x| node(x, twice)).collect()),
        ast::Value::Object(object) => {
            let mut entries: Vec<Entry> = Vec::new();
            for property in &object.properties {
                let key = match &property.name {
                    ObjectPropName::String(text) => text.value.clone().into_owned(),
                    ObjectPropName::Word(word) => word.value.to_owned(),
                };
                let range = property.name.range();
                let span = range.start..range.end;
                if entries.iter().any(|entry| entry.key == key) {
                    let message = format!("the key `{key}` stands here a second time");
                    twice.push(Diagnostic::new(span.clone(), message, "expected each key once"));
                }
                entries.push(Entry { key, span, node: node(&property.value, twice) });
            }
            Value::Table(entries)
        }
    };
    Node { span: range.start..range.end, value: inner }
}
