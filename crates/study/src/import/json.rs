//! A JSON object of lists, as `json.dump` writes it.

use super::model::unread;
use super::variable::{NONE, Value, Variable, is_known, names_of};
use super::{ImportError, LARGEST_MATRIX};
use nalgebra::DMatrix;
use serde::de::{Deserialize, DeserializeSeed, Deserializer, Error, IgnoredAny, MapAccess, SeqAccess, Visitor};
use std::fmt;

/// The variables of an object.
pub(super) fn read(text: &[u8]) -> Result<Vec<Variable>, ImportError> {
    let mut reader = serde_json::Deserializer::from_slice(text);
    let found = Object::deserialize(&mut reader).and_then(|object| reader.end().map(|()| object.0));
    found.map_err(|error| {
        let whole = error.to_string();
        let place = format!(" at line {} column {}", error.line(), error.column());
        let message = whole.strip_suffix(&place).unwrap_or(&whole);
        let message = match not_json(text, error.line(), error.column()) {
            Some(word) => format!("{word} is not a JSON number, and every entry must be finite"),
            None => message.replace("expected f64", "expected a number"),
        };
        ImportError::Json { line: error.line().max(1), column: error.column().max(1), message }
    })
}

/// What Python writes for a number that JSON does not have, where the reader stopped.
fn not_json(text: &[u8], line: usize, column: usize) -> Option<&'static str> {
    let line = text.split(|byte| *byte == b'\n').nth(line.checked_sub(1)?)?;
    let rest = line.get(column.checked_sub(1)?..)?;
    // The reader stops at the letter of -Infinity, after its sign.
    let is_minus = column > 1 && line[column - 2] == b'-';
    match rest {
        rest if rest.starts_with(b"NaN") => Some("NaN"),
        rest if rest.starts_with(b"-I") || (is_minus && rest.starts_with(b"I")) => Some("-Infinity"),
        rest if rest.starts_with(b"Infinity") => Some("Infinity"),
        _ => None,
    }
}

/// An object: a model, or one that contains models by name.
struct Object(Vec<Variable>);

impl<'de> Deserialize<'de> for Object {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        deserializer.deserialize_map(Fields { is_outer: true }).map(Self)
    }
}

struct Fields {
    is_outer: bool,
}

impl<'de> Visitor<'de> for Fields {
    type Value = Vec<Variable>;

    fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "an object with the matrices \"A\", \"B\" and \"C\"")
    }

    fn visit_map<M: MapAccess<'de>>(self, mut map: M) -> Result<Self::Value, M::Error> {
        let mut variables: Vec<Variable> = Vec::new();
        while let Some(name) = map.next_key::<String>()? {
            if variables.iter().any(|variable| variable.name == name) {
                return Err(M::Error::custom(format!("the key {name:?} stands twice")));
            }
            // An unknown key may be a structure that contains the model.
            let is_known = is_known(&name);
            let is_list = names_of(&name).is_some();
            let value = map.next_value_seed(Field { is_outer: self.is_outer && !is_known, is_known, is_list })?;
            variables.push(match value {
                Value::Other(_) if !is_known => unread(name),
                value => Variable { name, value },
            });
        }
        Ok(variables)
    }
}

/// The value under a key.
struct Field {
    /// Whether a structure may be the model.
    is_outer: bool,
    /// Whether a matrix is expected, or a list of names.
    is_known: bool,
    /// Whether a list of names is expected.
    is_list: bool,
}

impl<'de> DeserializeSeed<'de> for Field {
    type Value = Value;

    fn deserialize<D: Deserializer<'de>>(self, deserializer: D) -> Result<Value, D::Error> {
        deserializer.deserialize_any(self)
    }
}

impl<'de> Visitor<'de> for Field {
    type Value = Value;

    fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "a matrix as a list of its rows")
    }

    fn visit_f64<E: Error>(self, value: f64) -> Result<Value, E> {
        Ok(Value::Matrix(DMatrix::from_element(1, 1, value)))
    }

    fn visit_i64<E: Error>(self, value: i64) -> Result<Value, E> {
        self.visit_f64(value as f64)
    }

    fn visit_u64<E: Error>(self, value: u64) -> Result<Value, E> {
        self.visit_f64(value as f64)
    }

    /// As numpy and MATLAB keep it.
    fn visit_bool<E: Error>(self, value: bool) -> Result<Value, E> {
        self.visit_f64(f64::from(u8::from(value)))
    }

    fn visit_unit<E: Error>(self) -> Result<Value, E> {
        Ok(Value::Other(NONE.to_owned()))
    }

    fn visit_str<E: Error>(self, _: &str) -> Result<Value, E> {
        Ok(Value::Other("text".to_owned()))
    }

    fn visit_map<M: MapAccess<'de>>(self, mut map: M) -> Result<Value, M::Error> {
        if self.is_outer {
            return Fields { is_outer: false }.visit_map(map).map(Value::Structure);
        }
        while map.next_entry::<IgnoredAny, IgnoredAny>()?.is_some() {}
        Ok(Value::Other("an object".to_owned()))
    }

    fn visit_seq<S: SeqAccess<'de>>(self, mut rows: S) -> Result<Value, S::Error> {
        if !self.is_known {
            while rows.next_element::<IgnoredAny>()?.is_some() {}
            return Ok(Value::Other("a list".to_owned()));
        }
        if self.is_list {
            let (mut names, mut is_text) = (Vec::new(), true);
            while let Some(entry) = rows.next_element::<serde_json::Value>()? {
                match entry.as_str() {
                    Some(name) if names.len() < LARGEST_MATRIX => names.push(name.to_owned()),
                    _ => is_text = false,
                }
            }
            return Ok(if is_text { Value::Names(names) } else { Value::Other("a list".to_owned()) });
        }
        let (mut entries, mut columns, mut count) = (Vec::new(), 0, 0);
        while let Some(Row(row)) = rows.next_element()? {
            if count == 0 {
                columns = row.len();
            } else if row.len() != columns {
                let length = row.len();
                return Err(S::Error::custom(format!(
                    "row {} has length {length}, and row 1 has length {columns}",
                    count + 1
                )));
            }
            count += 1;
            entries.extend(row);
            if entries.len() > LARGEST_MATRIX {
                return Err(S::Error::custom(format!("a matrix of more than {LARGEST_MATRIX} entries")));
            }
        }
        Ok(Value::Matrix(DMatrix::from_row_slice(count, columns, &entries)))
    }
}

/// One row.
struct Row(Vec<f64>);

impl<'de> Deserialize<'de> for Row {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        Vec::deserialize(deserializer).map(Self)
    }
}
