//! Syntax tree of a study, independent of the format: values with their spans in bytes.

use std::ops::Range;

/// A value with its span.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Node {
    pub(crate) span: Range<usize>,
    pub(crate) value: Value,
}

/// A value.
#[derive(Debug, Clone, PartialEq)]
pub(crate) enum Value {
    Text(String),
    /// A number, and whether it was written as an integer.
    Number(f64, bool),
    Truth(bool),
    List(Vec<Node>),
    Table(Vec<Entry>),
    /// A value of a type that studies do not use, such as a date.
    Other(&'static str),
}

/// A key with its value.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Entry {
    pub(crate) key: String,
    pub(crate) span: Range<usize>,
    pub(crate) node: Node,
}

/// A step from a table or a list to what it holds.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) enum Step {
    Key(String),
    Entry(usize),
}

impl Node {
    /// The value at a place.
    pub(crate) fn at(&self, steps: &[Step]) -> Option<&Node> {
        steps.iter().try_fold(self, |node, step| match step {
            Step::Key(key) => node.get(key),
            Step::Entry(k) => node.list()?.get(*k),
        })
    }

    /// The value at a place, to be changed.
    pub(crate) fn at_mut(&mut self, steps: &[Step]) -> Option<&mut Node> {
        steps.iter().try_fold(self, |node, step| match (step, &mut node.value) {
            (Step::Key(key), Value::Table(entries)) => {
                entries.iter_mut().find(|entry| entry.key == *key).map(|entry| &mut entry.node)
            }
            (Step::Entry(k), Value::List(list)) => list.get_mut(*k),
            _ => None,
        })
    }

    /// The type of the value for messages.
    pub(crate) fn kind(&self) -> &'static str {
        match &self.value {
            Value::Text(_) => "a text",
            Value::Number(..) => "a number",
            Value::Truth(_) => "true or false",
            Value::List(_) => "a list",
            Value::Table(_) => "a table",
            Value::Other(kind) => kind,
        }
    }

    /// The value of a key; none if the key is absent or `self` is not a table.
    pub(crate) fn get(&self, key: &str) -> Option<&Node> {
        self.entry(key).map(|entry| &entry.node)
    }

    /// What `read` makes of the value of a key, or `Some(None)` without the key.
    #[expect(clippy::option_option, reason = "wrong, absent, or given")]
    pub(crate) fn given<'a, T>(&'a self, key: &str, read: impl FnOnce(&'a Self) -> Option<T>) -> Option<Option<T>> {
        self.get(key).map_or(Some(None), |node| read(node).map(Some))
    }

    /// A key with its value.
    pub(crate) fn entry(&self, key: &str) -> Option<&Entry> {
        match &self.value {
            Value::Table(entries) => entries.iter().find(|entry| entry.key == key),
            _ => None,
        }
    }

    /// The entries of a table; none of another value.
    pub(crate) fn entries(&self) -> &[Entry] {
        match &self.value {
            Value::Table(entries) => entries,
            _ => &[],
        }
    }

    /// The text.
    pub(crate) fn text(&self) -> Option<&str> {
        match &self.value {
            Value::Text(text) => Some(text),
            _ => None,
        }
    }

    /// The number; the strings `"inf"` and `"-inf"` are accepted, since JSON cannot represent them otherwise.
    pub(crate) fn number(&self) -> Option<f64> {
        match &self.value {
            Value::Number(x, _) => Some(*x),
            Value::Text(text) if text == "inf" => Some(f64::INFINITY),
            Value::Text(text) if text == "-inf" => Some(f64::NEG_INFINITY),
            _ => None,
        }
    }

    /// A nonnegative integer up to 2^53.
    pub(crate) fn count(&self) -> Option<usize> {
        let x = self.number()?;
        ((0.0..=9_007_199_254_740_992.0).contains(&x) && x.fract() == 0.0).then_some(x as usize)
    }

    /// The boolean.
    pub(crate) fn truth(&self) -> Option<bool> {
        match &self.value {
            Value::Truth(truth) => Some(*truth),
            _ => None,
        }
    }

    /// The entries of a list.
    pub(crate) fn list(&self) -> Option<&[Node]> {
        match &self.value {
            Value::List(list) => Some(list),
            _ => None,
        }
    }

    /// The numbers of a list of numbers.
    pub(crate) fn numbers(&self) -> Option<Vec<f64>> {
        self.list()?.iter().map(Node::number).collect()
    }

    /// The texts of a list of texts.
    pub(crate) fn texts(&self) -> Option<Vec<&str>> {
        self.list()?.iter().map(Node::text).collect()
    }
}
