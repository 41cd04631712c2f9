//! A study as a TOML document that can be changed and written again.

use std::fmt::Write;

use toml::Spanned;
use toml::de::{DeTable, DeValue};

/// A value of the document.
#[derive(Debug, Clone, PartialEq)]
pub(super) enum Value {
    Text(String),
    Number(f64),
    Truth(bool),
    List(Vec<Self>),
    Table(Table),
}

/// The entries of a table, in the order of their names.
#[derive(Debug, Clone, PartialEq, Default)]
pub(super) struct Table(pub(super) Vec<(String, Value)>);

impl Table {
    pub(super) fn get(&self, key: &str) -> Option<&Value> {
        self.0.iter().find(|(name, _)| name == key).map(|(_, value)| value)
    }

    pub(super) fn get_mut(&mut self, key: &str) -> Option<&mut Value> {
        self.0.iter_mut().find(|(name, _)| name == key).map(|(_, value)| value)
    }

    pub(super) fn has(&self, key: &str) -> bool {
        self.get(key).is_some()
    }

    pub(super) fn insert(&mut self, key: &str, value: Value) {
        self.remove(key);
        self.0.push((key.to_owned(), value));
    }

    pub(super) fn remove(&mut self, key: &str) {
        self.0.retain(|(name, _)| name != key);
    }
}

impl Value {
    pub(super) fn table(&self) -> Option<&Table> {
        if let Self::Table(table) = self { Some(table) } else { None }
    }

    pub(super) fn table_mut(&mut self) -> Option<&mut Table> {
        if let Self::Table(table) = self { Some(table) } else { None }
    }

    pub(super) fn list(&self) -> Option<&Vec<Self>> {
        if let Self::List(list) = self { Some(list) } else { None }
    }

    pub(super) fn list_mut(&mut self) -> Option<&mut Vec<Self>> {
        if let Self::List(list) = self { Some(list) } else { None }
    }

    pub(super) fn number(&self) -> Option<f64> {
        if let Self::Number(x) = self { Some(*x) } else { None }
    }

    pub(super) fn numbers(&self) -> Option<Vec<f64>> {
        self.list()?.iter().map(Self::number).collect()
    }

    pub(super) fn texts(&self) -> Option<Vec<String>> {
        self.list()?.iter().map(|text| if let Self::Text(text) = text { Some(text.clone()) } else { None }).collect()
    }

    /// A matrix given by rows.
    pub(super) fn rows(&self) -> Option<Vec<Vec<f64>>> {
        self.list()?.iter().map(Self::numbers).collect()
    }
}

/// The document of a text; none for what is not TOML.
pub(super) fn read(text: &str) -> Option<Table> {
    let table = DeTable::parse(text).ok()?;
    entries(table.get_ref())
}

fn entries(table: &DeTable<'_>) -> Option<Table> {
    let entries = table.iter().map(|(key, value)| Some((key.get_ref().clone().into_owned(), node(value)?)));
    entries.collect::<Option<_>>().map(Table)
}

fn node(value: &Spanned<DeValue<'_>>) -> Option<Value> {
    Some(match value.get_ref() {
        DeValue::String(text) => Value::Text(text.clone().into_owned()),
        DeValue::Integer(integer) => Value::Number(i64::from_str_radix(integer.as_str(), integer.radix()).ok()? as f64),
        DeValue::Float(float) => Value::Number(float.as_str().parse().ok()?),
        DeValue::Boolean(truth) => Value::Truth(*truth),
        DeValue::Datetime(_) => return None,
        DeValue::Array(array) => Value::List(array.iter().map(node).collect::<Option<_>>()?),
        DeValue::Table(table) => Value::Table(entries(table)?),
    })
}

/// The text of a document: scalars first, then tables, then arrays of tables.
pub(super) fn write(document: &Table) -> String {
    let mut text = String::new();
    for (name, value) in document.0.iter().filter(|(_, value)| value.table().is_none() && !is_list_of_tables(value)) {
        _ = writeln!(text, "{name} = {}", inline(value));
    }
    let entries = |text: &mut String, table: &Table| {
        for (name, value) in &table.0 {
            _ = writeln!(text, "{name} = {}", inline(value));
        }
    };
    for (name, value) in &document.0 {
        if let Some(table) = value.table() {
            _ = writeln!(text, "[{name}]");
            entries(&mut text, table);
        }
    }
    for (name, value) in document.0.iter().filter(|(_, value)| is_list_of_tables(value)) {
        for table in value.list().into_iter().flatten().filter_map(Value::table) {
            _ = writeln!(text, "[[{name}]]");
            entries(&mut text, table);
        }
    }
    text
}

fn is_list_of_tables(value: &Value) -> bool {
    value.list().is_some_and(|list| !list.is_empty() && list.iter().all(|value| value.table().is_some()))
}

fn inline(value: &Value) -> String {
    match value {
        Value::Text(text) if text.contains(['"', '\\']) => format!("'{text}'"),
        Value::Text(text) => format!("\"{text}\""),
        Value::Number(x) => number(*x),
        Value::Truth(truth) => truth.to_string(),
        Value::List(list) => format!("[{}]", list.iter().map(inline).collect::<Vec<_>>().join(", ")),
        Value::Table(table) => {
            let entries: Vec<String> =
                table.0.iter().map(|(name, value)| format!("{name} = {}", inline(value))).collect();
            format!("{{ {} }}", entries.join(", "))
        }
    }
}

/// A number as TOML has it; a whole one without a point.
pub(super) fn number(x: f64) -> String {
    let is_whole = x == x.trunc() && x.abs() < 1e6 && (x != 0.0 || x.is_sign_positive());
    if is_whole { format!("{x:.0}") } else { format!("{x:?}") }
}

/// The observers of a study.
pub(super) fn observers(document: &Table) -> Vec<&Table> {
    document.get("observer").and_then(Value::list).into_iter().flatten().filter_map(Value::table).collect()
}
