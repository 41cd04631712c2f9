//! JSON parser for certificate files: a tree in which every value has its line number.
//!
//! A dedicated parser is used for three reasons: errors of a certificate must name their line, long after parsing;
//! general parsers round numbers; and the checker is trusted code, which must be short and readable. It is strict: no
//! duplicate names, no control characters in strings (escaped or not), no escapes of halves of surrogate pairs, no
//! depth beyond [`DEEPEST`], no text after the end, no byte order mark, no size beyond [`LARGEST_FILE`] and
//! [`MOST_VALUES`].

use super::error::{Fault, FileError};
use super::limits::{DEEPEST, LARGEST_FILE, MOST_VALUES};
use crate::number::quoted;

/// A value and the line it begins on, from 1.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Node {
    pub(super) line: usize,
    pub(super) value: Value,
}

#[derive(Debug, Clone, PartialEq)]
pub(super) enum Value {
    Null,
    Bool(bool),
    /// As it was written.
    Number(Box<str>),
    Text(Box<str>),
    Array(Vec<Node>),
    Object(Vec<Member>),
}

#[derive(Debug, Clone, PartialEq)]
pub(super) struct Member {
    pub(super) name: Box<str>,
    pub(super) node: Node,
}

impl Value {
    /// What it is, for an error about what it should be.
    pub(super) fn kind(&self) -> &'static str {
        match self {
            Self::Null => "null",
            Self::Bool(_) => "a truth value",
            Self::Number(_) => "a JSON number",
            Self::Text(_) => "a string",
            Self::Array(_) => "an array",
            Self::Object(_) => "an object",
        }
    }
}

/// The tree of a whole document.
pub(super) fn parse(bytes: &[u8]) -> Result<Node, FileError> {
    if bytes.len() > LARGEST_FILE {
        return Err(FileError::at(1, Fault::TooLarge { bytes: bytes.len() }));
    }
    let text = core::str::from_utf8(bytes).map_err(|error| {
        let good = &bytes[..error.valid_up_to()];
        let line = good.split(|b| *b == b'\n').count();
        FileError::at(line, Fault::NotUtf8 { byte: error.valid_up_to() })
    })?;
    let mut parser = Parser { text, at: 0, line: 1, values: 0 };
    let node = parser.value(0)?;
    parser.skip();
    if parser.at < text.len() {
        return Err(parser.unexpected("the end of the file"));
    }
    Ok(node)
}

struct Parser<'a> {
    text: &'a str,
    at: usize,
    line: usize,
    /// How many values were begun.
    values: usize,
}

impl<'a> Parser<'a> {
    fn rest(&self) -> &'a str {
        // `at` only ever moves over whole characters.
        self.text.get(self.at..).unwrap_or_default()
    }

    fn peek(&self) -> Option<u8> {
        self.text.as_bytes().get(self.at).copied()
    }

    fn skip(&mut self) {
        while let Some(b) = self.peek().filter(|b| matches!(b, b' ' | b'\t' | b'\r' | b'\n')) {
            self.line += usize::from(b == b'\n');
            self.at += 1;
        }
    }

    fn unexpected(&self, expected: &'static str) -> FileError {
        let fault = match self.rest().chars().next() {
            None => Fault::Truncated { expected },
            Some(found) => Fault::Unexpected { expected, found },
        };
        FileError::at(self.line, fault)
    }

    fn expect(&mut self, byte: u8, expected: &'static str) -> Result<(), FileError> {
        self.skip();
        if self.peek() == Some(byte) {
            self.at += 1;
            return Ok(());
        }
        Err(self.unexpected(expected))
    }

    /// Whether the next character is this one, which is then passed.
    fn passes(&mut self, byte: u8) -> bool {
        self.skip();
        let passes = self.peek() == Some(byte);
        self.at += usize::from(passes);
        passes
    }

    fn value(&mut self, depth: usize) -> Result<Node, FileError> {
        self.skip();
        let line = self.line;
        if depth > DEEPEST {
            return Err(FileError::at(line, Fault::TooDeep));
        }
        self.values += 1;
        if self.values > MOST_VALUES {
            return Err(FileError::at(line, Fault::TooManyValues));
        }
        let value = match self.peek() {
            Some(b'{') => self.object(depth)?,
            Some(b'[') => self.array(depth)?,
            Some(b'"') => Value::Text(self.string()?),
            Some(b'-' | b'0'..=b'9') => self.number()?,
            _ => self.word()?,
        };
        Ok(Node { line, value })
    }

    fn object(&mut self, depth: usize) -> Result<Value, FileError> {
        self.at += 1;
        let mut members: Vec<Member> = Vec::new();
        if self.passes(b'}') {
            return Ok(Value::Object(members));
        }
        loop {
            self.skip();
            if self.peek() != Some(b'"') {
                return Err(self.unexpected("a name in quotes"));
            }
            let line = self.line;
            let name = self.string()?;
            // No object of a certificate has many members; more are an error before they cost anything.
            if members.len() >= 64 {
                return Err(FileError::at(line, Fault::TooManyMembers));
            }
            if members.iter().any(|member| member.name == name) {
                return Err(FileError::at(line, Fault::Duplicate { name: quoted(&name) }));
            }
            self.expect(b':', "a colon")?;
            let node = self.value(depth + 1)?;
            members.push(Member { name, node });
            if self.passes(b'}') {
                return Ok(Value::Object(members));
            }
            self.expect(b',', "a comma or the end of the object")?;
        }
    }

    fn array(&mut self, depth: usize) -> Result<Value, FileError> {
        self.at += 1;
        let mut items = Vec::new();
        if self.passes(b']') {
            return Ok(Value::Array(items));
        }
        loop {
            items.push(self.value(depth + 1)?);
            if self.passes(b']') {
                return Ok(Value::Array(items));
            }
            self.expect(b',', "a comma or the end of the array")?;
        }
    }

    fn string(&mut self) -> Result<Box<str>, FileError> {
        self.at += 1;
        let mut text = String::new();
        loop {
            let rest = self.rest();
            let plain = rest.find(|c: char| c == '"' || c == '\\' || c.is_control()).unwrap_or(rest.len());
            text.push_str(rest.get(..plain).unwrap_or_default());
            self.at += plain;
            match self.peek() {
                Some(b'"') => {
                    self.at += 1;
                    return Ok(text.into_boxed_str());
                }
                Some(b'\\') => {
                    self.at += 1;
                    text.push(self.escaped()?);
                }
                _ => return Err(self.unexpected("the end of a string, which holds no control characters")),
            }
        }
    }

    fn escaped(&mut self) -> Result<char, FileError> {
        let short = match self.peek() {
            Some(c @ (b'"' | b'\\' | b'/')) => Some(char::from(c)),
            Some(b'u') => None,
            _ => return Err(self.unexpected("\\\", \\\\, \\/ or \\uXXXX")),
        };
        if let Some(c) = short {
            self.at += 1;
            return Ok(c);
        }
        let digits = self.rest().get(1..5).filter(|digits| digits.bytes().all(|b| b.is_ascii_hexdigit()));
        let code = digits.and_then(|digits| u32::from_str_radix(digits, 16).ok());
        match code.and_then(char::from_u32).filter(|c| !c.is_control()) {
            Some(c) => {
                self.at += 5;
                Ok(c)
            }
            None => {
                Err(self
                    .unexpected("four hexadecimal digits of a character that is neither half of a pair nor control"))
            }
        }
    }

    fn number(&mut self) -> Result<Value, FileError> {
        let rest = self.rest();
        let end = rest
            .find(|c: char| !(c.is_ascii_digit() || matches!(c, '.' | 'e' | 'E' | '+' | '-')))
            .unwrap_or(rest.len());
        let text = rest.get(..end).unwrap_or_default();
        if !is_number(text) {
            return Err(FileError::at(self.line, Fault::NotJson { text: quoted(text) }));
        }
        self.at += end;
        Ok(Value::Number(text.into()))
    }

    fn word(&mut self) -> Result<Value, FileError> {
        for (word, value) in [("null", Value::Null), ("true", Value::Bool(true)), ("false", Value::Bool(false))] {
            if self.rest().starts_with(word) {
                self.at += word.len();
                return Ok(value);
            }
        }
        Err(self.unexpected("a value"))
    }
}

/// RFC 8259, section 6: `-`, an integer without leading zeros, digits after a point, an exponent.
fn is_number(text: &str) -> bool {
    let digits = |part: &str| !part.is_empty() && part.bytes().all(|b| b.is_ascii_digit());
    let text = text.strip_prefix('-').unwrap_or(text);
    let (text, exponent) = text.split_once(['e', 'E']).map_or((text, None), |(text, rest)| (text, Some(rest)));
    let (whole, part) = text.split_once('.').map_or((text, None), |(whole, rest)| (whole, Some(rest)));
    digits(whole)
        && (whole == "0" || !whole.starts_with('0'))
        && part.is_none_or(digits)
        && exponent.is_none_or(|rest| digits(rest.strip_prefix(['+', '-']).unwrap_or(rest)))
}

/// The canonical form: no white space between tokens, the members of each object in the order of their names, and those
/// of the whole document without `left_out`.
pub(super) fn canonical(node: &Node, left_out: &str) -> String {
    let mut text = String::new();
    write_canonical(node, left_out, &mut text);
    text
}

fn write_canonical(node: &Node, left_out: &str, text: &mut String) {
    match &node.value {
        Value::Null => text.push_str("null"),
        Value::Bool(truth) => text.push_str(if *truth { "true" } else { "false" }),
        Value::Number(number) => text.push_str(number),
        Value::Text(string) => write_string(string, text),
        Value::Array(items) => {
            text.push('[');
            for (k, item) in items.iter().enumerate() {
                if k > 0 {
                    text.push(',');
                }
                write_canonical(item, "", text);
            }
            text.push(']');
        }
        Value::Object(members) => {
            let mut members: Vec<&Member> = members.iter().filter(|member| *member.name != *left_out).collect();
            members.sort_by(|x, y| x.name.cmp(&y.name));
            text.push('{');
            for (k, member) in members.into_iter().enumerate() {
                if k > 0 {
                    text.push(',');
                }
                write_string(&member.name, text);
                text.push(':');
                write_canonical(&member.node, "", text);
            }
            text.push('}');
        }
    }
}

pub(super) fn write_string(string: &str, text: &mut String) {
    text.push('"');
    for c in string.chars() {
        match c {
            '"' => text.push_str("\\\""),
            '\\' => text.push_str("\\\\"),
            // A reader refuses these; what cannot be read is not written.
            c if c.is_control() => text.push(' '),
            c => text.push(c),
        }
    }
    text.push('"');
}
