//! Octave's text format, which its `save` writes unless told otherwise.
//!
//! ```text
//! # Created by Octave 8.4.0, Mon Jan 01 12:00:00 2024 GMT <user@host>
//! # name: A
//! # type: matrix
//! # rows: 2
//! # columns: 2
//!  0 1
//!  -2 -3
//! ```
//!
//! Each variable has a name, a type, the lines that the type needs, and its numbers. Matrices (real, complex, boolean,
//! integer, sparse, diagonal), scalars, and structures of them are read, and lists of texts as names. Of a variable
//! with another name or type the lines are skipped up to the next name.
//!
//! Source: GNU Octave, `load-save` and `ls-oct-text.cc`.

use super::ImportError;
use super::model::unread;
use super::variable::{Value, Variable, entries, is_known, names_of};
use nalgebra::DMatrix;

/// The name of an entry of a cell array.
const CELL: &str = "<cell-element>";

/// How deep structures and cell arrays may be nested.
const DEEPEST: usize = 32;

/// What stands before the type of a matrix or scalar.
const PREFIXES: [&str; 11] =
    ["float ", "complex ", "bool ", "int8 ", "int16 ", "int32 ", "int64 ", "uint8 ", "uint16 ", "uint32 ", "uint64 "];

/// Whether a text begins as one of Octave: with comments, the first or second of which names a variable or the program.
pub(super) fn is_octave(text: &[u8]) -> bool {
    let mut lines = text.split(|byte| *byte == b'\n').take(2).map(<[u8]>::trim_ascii);
    let is_header = |line: &[u8]| matches!(line.first(), Some(b'#' | b'%'));
    let names = |line: &[u8]| is_header(line) && line[1..].trim_ascii_start().starts_with(b"name:");
    lines.next().is_some_and(|first| {
        is_header(first)
            && (names(first)
                || first[1..].trim_ascii_start().starts_with(b"Created by Octave")
                || lines.next().is_some_and(names))
    })
}

/// The variables of a file.
pub(super) fn read(text: &[u8]) -> Result<Vec<Variable>, ImportError> {
    let text = String::from_utf8_lossy(text);
    let mut reader = Reader { rest: &text, line: 0 };
    let mut variables = Vec::new();
    while let Some(name) = reader.name() {
        let value = reader.value(&name, 0)?;
        variables.push(variable(name, value));
    }
    Ok(variables)
}

fn variable(name: String, value: Value) -> Variable {
    if is_known(&name) || matches!(value, Value::Structure(_)) { Variable { name, value } } else { unread(name) }
}

struct Reader<'a> {
    rest: &'a str,
    /// The number of the line before the rest.
    line: usize,
}

impl<'a> Reader<'a> {
    fn damaged(&self, message: impl Into<String>) -> ImportError {
        ImportError::Text { line: self.line.max(1), message: message.into() }
    }

    /// The next line as it is, without its end.
    fn whole_line(&mut self) -> Option<&'a str> {
        if self.rest.is_empty() {
            return None;
        }
        let (line, rest) = self.rest.split_once('\n').unwrap_or((self.rest, ""));
        self.rest = rest;
        self.line += 1;
        Some(line.strip_suffix('\r').unwrap_or(line))
    }

    /// The next line that is not empty, without its blanks.
    fn next_line(&mut self) -> Option<&'a str> {
        loop {
            let line = self.whole_line()?.trim();
            if !line.is_empty() {
                return Some(line);
            }
        }
    }

    /// The next line that is not empty, if it is `# key: value` with this key; otherwise it is not consumed.
    fn optional(&mut self, key: &str) -> Option<&'a str> {
        let (rest, line) = (self.rest, self.line);
        let found = self.next_line().and_then(entry).filter(|(found, _)| *found == key);
        if found.is_none() {
            (self.rest, self.line) = (rest, line);
        }
        found.map(|(_, value)| value)
    }

    fn expect(&mut self, key: &str) -> Result<&'a str, ImportError> {
        self.optional(key).ok_or_else(|| {
            _ = self.next_line();
            self.damaged(format!("\"# {key}: ..\" is expected"))
        })
    }

    fn count(&mut self, key: &str) -> Result<u64, ImportError> {
        let text = self.expect(key)?;
        text.parse().map_err(|_| self.damaged(format!("{text:?} is not a number of {key}")))
    }

    /// The name of the next variable; what stands before it is skipped.
    fn name(&mut self) -> Option<String> {
        loop {
            if let Some(("name", name)) = entry(self.next_line()?) {
                return Some(name.to_owned());
            }
        }
    }

    /// Rows and columns, as two lines, or as `# ndims: 2` and both in a line. None of an array of more dimensions.
    fn shape(&mut self) -> Result<Option<(u64, u64)>, ImportError> {
        if self.optional("ndims").is_none() {
            return Ok(Some((self.count("rows")?, self.count("columns")?)));
        }
        let line = self.next_line().unwrap_or_default();
        let sizes: Option<Vec<u64>> = line.split_whitespace().map(|size| size.parse().ok()).collect();
        match sizes.as_deref() {
            Some([rows, columns]) => Ok(Some((*rows, *columns))),
            Some(_) => Ok(None),
            None => Err(self.damaged("the dimensions are not numbers")),
        }
    }

    /// `count` numbers, in the lines from here; none if one of them has an imaginary part.
    fn numbers(&mut self, count: usize) -> Result<Option<Vec<f64>>, ImportError> {
        let (mut numbers, mut is_real) = (Vec::new(), true);
        while numbers.len() < count {
            let line = self.next_line().filter(|line| !line.starts_with(['#', '%'])).unwrap_or_default();
            for word in line.split_whitespace() {
                let (real, imaginary) = self.number(word)?;
                is_real &= imaginary == 0.0;
                numbers.push(real);
            }
            if line.is_empty() || numbers.len() > count {
                return Err(self.damaged(format!("{count} numbers are expected, and {} found", numbers.len())));
            }
        }
        Ok(is_real.then_some(numbers))
    }

    /// Real and imaginary part; a complex number is `(re,im)`.
    fn number(&self, word: &str) -> Result<(f64, f64), ImportError> {
        let parse = |text: &str| match text {
            "NA" => Ok(f64::NAN),
            _ => text.parse::<f64>().map_err(|_| self.damaged(format!("{word:?} is not a number"))),
        };
        match word.strip_prefix('(').and_then(|word| word.strip_suffix(')')?.split_once(',')) {
            Some((real, imaginary)) => Ok((parse(real)?, parse(imaginary)?)),
            None => Ok((parse(word)?, 0.0)),
        }
    }

    /// The value of the variable whose name was read, within so many structures and cell arrays.
    fn value(&mut self, name: &str, depth: usize) -> Result<Value, ImportError> {
        if depth > DEEPEST {
            return Err(self.damaged(format!("structures and cell arrays are nested deeper than {DEEPEST}")));
        }
        let kind = self.expect("type")?;
        match kind {
            "scalar struct" => return self.structure(depth),
            "struct" => return self.structure(depth).map(|_| Value::Other("an array of structures".to_owned())),
            "cell" => return self.cells(depth),
            "string" | "sq_string" => return Ok(self.texts()?.map_or(Value::Other("text".to_owned()), Value::Names)),
            _ if !is_known(name) || names_of(name).is_some() => return Ok(Value::Other(kind.to_owned())),
            _ => {}
        }
        let complex = || Ok(Value::Other("complex".to_owned()));
        let plain = PREFIXES.iter().fold(kind, |kind, prefix| kind.strip_prefix(prefix).unwrap_or(kind));
        match plain {
            "scalar" | "bool" => {
                let numbers = self.numbers(1)?;
                numbers.map_or_else(complex, |numbers| Ok(Value::Matrix(DMatrix::from_vec(1, 1, numbers))))
            }
            "matrix" | "null_matrix" | "diagonal matrix" => {
                // Numbers by columns after ndims, else by rows.
                let by_columns = entry(self.rest.trim_start().lines().next().unwrap_or_default());
                let by_columns = by_columns.is_some_and(|(key, _)| key == "ndims");
                let Some((rows, columns)) = self.shape()? else {
                    return Ok(Value::Other("an array of more than two dimensions".to_owned()));
                };
                let count = entries(name, rows, columns)?;
                let (rows, columns) = (rows as usize, columns as usize);
                let is_diagonal = plain == "diagonal matrix";
                let Some(numbers) = self.numbers(if is_diagonal { rows.min(columns) } else { count })? else {
                    return complex();
                };
                Ok(Value::Matrix(if is_diagonal {
                    DMatrix::from_fn(rows, columns, |i, j| if i == j { numbers[i] } else { 0.0 })
                } else if by_columns {
                    DMatrix::from_vec(rows, columns, numbers)
                } else {
                    DMatrix::from_row_slice(rows, columns, &numbers)
                }))
            }
            "sparse matrix" | "sparse complex matrix" | "sparse bool matrix" => self.sparse(name),
            _ => Ok(Value::Other(kind.to_owned())),
        }
    }

    fn sparse(&mut self, name: &str) -> Result<Value, ImportError> {
        let stored = self.count("nnz")?;
        let (rows, columns) = (self.count("rows")?, self.count("columns")?);
        if stored > entries(name, rows, columns)? as u64 {
            return Err(self.damaged(format!("{stored} entries of a {rows} x {columns} matrix")));
        }
        let mut m = DMatrix::zeros(rows as usize, columns as usize);
        for _ in 0..stored {
            let words: Vec<&str> = self.next_line().unwrap_or_default().split_whitespace().collect();
            let [row, column, value] = words[..] else {
                return Err(self.damaged("a row, a column and a number are expected"));
            };
            let (value, imaginary) = self.number(value)?;
            if imaginary != 0.0 {
                return Ok(Value::Other("complex".to_owned()));
            }
            let place = |word: &str| word.parse::<usize>().ok()?.checked_sub(1);
            let found = place(row).zip(place(column)).and_then(|at| m.get_mut(at));
            *found.ok_or_else(|| self.damaged("an entry outside of the matrix"))? = value;
        }
        Ok(Value::Matrix(m))
    }

    /// The texts of a cell array; of one with anything else a description.
    fn cells(&mut self, depth: usize) -> Result<Value, ImportError> {
        let mut names = Some(Vec::new());
        let shape = self.shape()?;
        let count = shape.map_or(Ok(0), |(rows, columns)| entries(CELL, rows, columns))?;
        for _ in 0..count {
            if self.expect("name")? != CELL {
                return Err(self.damaged("an entry of a cell array is expected"));
            }
            let text = match self.value(CELL, depth + 1)? {
                Value::Names(mut texts) if texts.len() <= 1 => Some(texts.pop().unwrap_or_default()),
                _ => None,
            };
            names = names.zip(text).map(|(mut names, text)| {
                names.push(text);
                names
            });
        }
        Ok(names.map_or(Value::Other("a cell array".to_owned()), Value::Names))
    }

    /// The rows of an array of characters without the blanks at their ends; none of one with more dimensions.
    fn texts(&mut self) -> Result<Option<Vec<String>>, ImportError> {
        if self.optional("ndims").is_some() {
            return Ok(None);
        }
        let mut texts = Vec::new();
        for _ in 0..self.count("elements")? {
            let length = self.count("length")? as usize;
            let mut text = self.whole_line().unwrap_or_default().to_owned();
            // A text may have several lines.
            while text.len() < length {
                let line = self.whole_line().ok_or_else(|| self.damaged("a text that is cut short"))?;
                text.extend(["\n", line]);
            }
            texts.push(text.trim_end().to_owned());
        }
        if texts.is_empty() {
            _ = self.optional("length");
        }
        Ok(Some(texts))
    }

    /// A structure, within so many others; those within are described only.
    fn structure(&mut self, depth: usize) -> Result<Value, ImportError> {
        // `# ndims: 2` and `1 1`, which old versions omit.
        if self.optional("ndims").is_some() {
            _ = self.next_line();
        }
        let count = self.count("length")?;
        let mut fields = Vec::new();
        for at in 0..count {
            let name = self.name().ok_or_else(|| self.damaged(format!("{at} of {count} fields of a structure")))?;
            let value = self.value(&name, depth + 1)?;
            if depth == 0 {
                fields.push(variable(name, value));
            }
        }
        Ok(if depth == 0 { Value::Structure(fields) } else { Value::Other("a structure".to_owned()) })
    }
}

/// `# key: value` in a line.
fn entry(line: &str) -> Option<(&str, &str)> {
    let (key, value) = line.trim().strip_prefix(['#', '%'])?.split_once(':')?;
    Some((key.trim(), value.trim()))
}
