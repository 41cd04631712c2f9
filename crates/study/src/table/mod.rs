//! Tables of numbers from CSV text: measured logs, inputs and references.
//!
//! The first line has the names of the columns, the others numbers. The separator is a tab, semicolon or comma, as in
//! the first line; lines that begin with `#` are comments. The decimal sign is a point, or a comma between semicolons
//! or tabs. A cell that is blank, `NaN`, `NA` or `null` is a missing value. A name may have a unit in brackets, which
//! is left out when the column is looked for: `voltage [V]` is `voltage`. Text in a column that is not used is no
//! mistake; every other one is reported with line and column.

mod cell;
mod error;
mod suspicion;

use std::path::Path;

use csv::{ReaderBuilder, StringRecord, Trim};
use luenberger_expression::nearest;
use luenberger_sim::{Recording, SampleInterpolation, Samples};
use nalgebra::DMatrix;

use cell::{Cell, Decimal};

pub use error::TableError;
pub use suspicion::Suspicion;

/// The maximal number of values: 400 MB.
const LARGEST: usize = 50_000_000;

/// The line number of a record: the reader's position is before the empty lines and comments that it skips.
fn line_of(text: &str, position: &csv::Position) -> u64 {
    let rest = usize::try_from(position.byte()).ok().and_then(|byte| text.get(byte..)).unwrap_or("");
    let left_out = rest.lines().take_while(|line| line.is_empty() || line.starts_with('#')).count();
    position.line() + left_out as u64
}

/// A name without the unit in brackets after it.
fn without_unit(name: &str) -> &str {
    let cut = [('[', ']'), ('(', ')')]
        .into_iter()
        .find_map(|(open, close)| name.strip_suffix(close).and_then(|rest| rest.rfind(open)).filter(|at| *at > 0));
    cut.map_or(name, |at| name[..at].trim_end())
}

/// A column of numbers, some of which may be missing, and its first cell that is neither.
#[derive(Clone, Debug, Default, PartialEq)]
struct Column {
    values: Vec<Option<f64>>,
    wrong: Option<(u64, String)>,
}

/// Named columns of finite numbers, of equal length; values may be missing.
#[derive(Clone, Debug, PartialEq)]
pub struct Table {
    names: Vec<String>,
    columns: Vec<Column>,
    separator: u8,
    decimal: Option<Decimal>,
    /// The line of each row.
    lines: Vec<u64>,
}

impl Table {
    /// The table in a text.
    ///
    /// ```
    /// use luenberger_study::table::Table;
    /// let table = Table::parse("# bench, run 3\nt; u; angle\n0; 1.5; 0\n0.1; 1.5; 0.02\n")?;
    /// assert_eq!(table.column("angle")?, [0.0, 0.02]);
    /// let error = Table::parse("t,u [V]\n0,1\n0.1,1.5V\n")?.column("u").unwrap_err();
    /// assert_eq!(error.to_string(), "line 3, column 2 (u [V]): expected a number, found `1.5V`");
    /// # Ok::<(), luenberger_study::table::TableError>(())
    /// ```
    /// # Errors
    /// [`TableError`] with line and column. A cell that is no number is one of the column, when it is used.
    pub fn parse(text: &str) -> Result<Self, TableError> {
        // Spreadsheets begin a file with a byte-order mark, and some use semicolons.
        let text = text.strip_prefix('\u{feff}').unwrap_or(text);
        let first = text.lines().map(str::trim_start).find(|line| !line.is_empty() && !line.starts_with('#'));
        let first = first.ok_or(TableError::Empty)?;
        let separator =
            [b'\t', b';'].into_iter().find(|separator| first.as_bytes().contains(separator)).unwrap_or(b',');
        let mut reader = ReaderBuilder::new()
            .has_headers(false)
            .flexible(true)
            .delimiter(separator)
            .comment(Some(b'#'))
            .trim(Trim::All)
            .from_reader(text.as_bytes());
        let mut table: Option<Self> = None;
        let mut record = StringRecord::new();
        while reader.read_record(&mut record)? {
            let line = record.position().map_or(0, |position| line_of(text, position));
            match &mut table {
                None => table = Some(Self::header(line, &record, separator)?),
                // A line of spaces only.
                Some(_) if record.len() == 1 && record[0].is_empty() => {}
                Some(table) => table.row(line, &record)?,
            }
        }
        table.ok_or(TableError::Empty)
    }

    /// The table in a file.
    ///
    /// # Errors
    /// [`TableError::File`], and those of [`parse`](Self::parse).
    pub fn read(path: &Path) -> Result<Self, TableError> {
        let bytes = std::fs::read(path).map_err(|error| TableError::File { path: path.to_owned(), error })?;
        Self::from_bytes(&bytes)
    }

    /// The table in the bytes of a file, which has to be UTF-8.
    ///
    /// # Errors
    /// [`TableError::Encoding`], and those of [`parse`](Self::parse).
    pub fn from_bytes(bytes: &[u8]) -> Result<Self, TableError> {
        match std::str::from_utf8(bytes) {
            Ok(text) => Self::parse(text),
            Err(error) => {
                let before = &bytes[..error.valid_up_to()];
                let line = before.split(|byte| *byte == b'\n').count() as u64;
                Err(TableError::Encoding { line, byte: bytes[error.valid_up_to()] })
            }
        }
    }

    fn header(line: u64, record: &StringRecord, separator: u8) -> Result<Self, TableError> {
        let mut names: Vec<String> = record.iter().map(str::to_owned).collect();
        // Some loggers end each line with a separator.
        if names.len() > 1 && names.last().is_some_and(String::is_empty) {
            names.pop();
        }
        for (k, name) in names.iter().enumerate() {
            if name.is_empty() || name.parse::<f64>().is_ok() {
                return Err(TableError::NoHeader { line, column: k + 1, cell: name.clone() });
            }
            if let Some(first) = names[..k].iter().position(|other| other == name) {
                return Err(TableError::DuplicateColumn { name: name.clone(), first: first + 1, second: k + 1 });
            }
        }
        Ok(Self { columns: vec![Column::default(); names.len()], names, separator, decimal: None, lines: Vec::new() })
    }

    fn row(&mut self, line: u64, record: &StringRecord) -> Result<(), TableError> {
        let cells = match record.len() {
            length if length == self.names.len() + 1 && record[length - 1].is_empty() => length - 1,
            length => length,
        };
        if cells != self.names.len() {
            return Err(TableError::Cells { line, expected: self.names.len(), found: cells });
        }
        if self.names.len() * (self.lines.len() + 1) > LARGEST {
            return Err(TableError::TooLarge { line });
        }
        for (column, text) in self.columns.iter_mut().zip(record) {
            let value = match cell::cell(text, self.separator, &mut self.decimal) {
                Cell::Number(value) if value.is_finite() => Some(value),
                Cell::Missing => None,
                Cell::Number(_) | Cell::Wrong(_) => {
                    column.wrong.get_or_insert_with(|| (line, text.to_owned()));
                    None
                }
            };
            column.values.push(value);
        }
        self.lines.push(line);
        Ok(())
    }

    /// The names of the columns.
    pub fn names(&self) -> &[String] {
        &self.names
    }

    /// Number of rows.
    pub fn rows(&self) -> usize {
        self.lines.len()
    }

    /// The column of that name, or the only one of that name with a unit in brackets.
    fn index(&self, name: &str) -> Result<usize, TableError> {
        let plain = |k: &usize| self.names[*k] == name;
        let with_unit = |k: &usize| without_unit(&self.names[*k]) == name;
        let mut found = (0..self.names.len()).filter(with_unit);
        if let Some(k) = (0..self.names.len()).find(plain).or(found.next().filter(|_| found.next().is_none())) {
            return Ok(k);
        }
        Err(TableError::MissingColumn {
            name: name.to_owned(),
            nearest: nearest(name, self.names.iter().map(|name| without_unit(name))).map(str::to_owned),
            known: self.names.clone(),
        })
    }

    /// The column of that name, in which values may be missing.
    ///
    /// # Errors
    /// [`TableError::MissingColumn`], [`TableError::NotANumber`], [`TableError::NotFinite`].
    pub fn values(&self, name: &str) -> Result<&[Option<f64>], TableError> {
        let k = self.index(name)?;
        let column = &self.columns[k];
        let Some((line, text)) = &column.wrong else { return Ok(&column.values) };
        let (line, name) = (*line, self.names[k].clone());
        if let Ok(value) = text.parse::<f64>().map_err(|_| ()).and_then(|x| if x.is_finite() { Err(()) } else { Ok(x) })
        {
            return Err(TableError::NotFinite { line, column: k + 1, name, value });
        }
        let advice = cell::advice(text, self.decimal);
        Err(TableError::NotANumber { line, column: k + 1, name, cell: text.clone(), advice })
    }

    /// The column of that name, which has to be complete.
    ///
    /// # Errors
    /// [`TableError::MissingColumn`], [`TableError::Missing`].
    pub fn column(&self, name: &str) -> Result<Vec<f64>, TableError> {
        let k = self.index(name)?;
        let cells = self.values(name)?.iter().zip(&self.lines);
        let missing = |line: u64| TableError::Missing { line, column: k + 1, name: self.names[k].clone() };
        cells.map(|(cell, line)| cell.ok_or_else(|| missing(*line))).collect()
    }

    /// The time column, which must be increasing and have at least two rows.
    fn times(&self, name: &str) -> Result<Vec<f64>, TableError> {
        let t = self.column(name)?;
        if t.len() < 2 {
            return Err(TableError::TooFewRows { rows: t.len(), needed: 2 });
        }
        for (pair, line) in t.windows(2).zip(&self.lines[1..]) {
            if pair[1] == pair[0] {
                return Err(TableError::TimeTwice { line: *line, time: pair[1] });
            }
            if pair[1] < pair[0] {
                return Err(TableError::TimesUnsorted { line: *line, previous: pair[0], next: pair[1] });
            }
        }
        Ok(t)
    }

    /// Columns in which values may be missing.
    fn matrix<S: AsRef<str>>(&self, names: &[S]) -> Result<DMatrix<Option<f64>>, TableError> {
        let columns = names.iter().map(|name| self.values(name.as_ref())).collect::<Result<Vec<_>, _>>()?;
        Ok(DMatrix::from_fn(self.rows(), names.len(), |i, j| columns[j][i]))
    }

    /// Some columns as a function of the time column.
    ///
    /// # Errors
    /// [`TableError::MissingColumn`], [`TableError::TooFewRows`], [`TableError::TimesUnsorted`],
    /// [`TableError::Missing`].
    pub fn samples<S: AsRef<str>>(
        &self,
        time: &str,
        columns: &[S],
        between: SampleInterpolation,
    ) -> Result<Samples, TableError> {
        let t = self.times(time)?;
        let columns = columns.iter().map(|name| self.column(name.as_ref())).collect::<Result<Vec<_>, _>>()?;
        Ok(Samples::new(t, DMatrix::from_fn(self.rows(), columns.len(), |i, j| columns[j][i]), between)?)
    }

    /// Some columns at the times of the time column, in which values may be missing; a name that is none is a column
    /// without values.
    ///
    /// # Errors
    /// [`TableError::MissingColumn`], [`TableError::TooFewRows`], [`TableError::TimesUnsorted`].
    pub fn samples_with_missing(&self, time: &str, columns: &[Option<&str>]) -> Result<Samples, TableError> {
        let none = vec![None; self.rows()];
        let columns = columns.iter().map(|name| name.map_or(Ok(&none[..]), |name| self.values(name)));
        let columns = columns.collect::<Result<Vec<_>, _>>()?;
        let values = DMatrix::from_fn(self.rows(), columns.len(), |i, j| columns[j][i]);
        Ok(Samples::with_missing(self.times(time)?, &values, SampleInterpolation::ZeroOrderHold)?)
    }

    /// A measured log: the columns of the time, of the inputs and of the outputs. Values of inputs and outputs may be
    /// missing.
    ///
    /// ```
    /// use luenberger_study::table::Table;
    /// let table = Table::parse("t,y1,u1\n0,1,0\n0.1,,0\n0.25,3,1\n")?;
    /// let log = table.recording("t", &["u1"], &["y1"])?;
    /// assert_eq!(log.times(), [0.0, 0.1, 0.25]);
    /// assert_eq!(log.outputs().value(1, 0), None);
    /// let error = table.recording("t", &["u1"], &["y2"]).unwrap_err();
    /// assert_eq!(error.to_string(), "there is no column `y2`; did you mean `y1`?");
    /// # Ok::<(), luenberger_study::table::TableError>(())
    /// ```
    /// # Errors
    /// [`TableError::MissingColumn`], [`TableError::TooFewRows`], [`TableError::TimesUnsorted`],
    /// [`TableError::Missing`] for a time and for an input in the first row.
    pub fn recording<S: AsRef<str>>(&self, time: &str, inputs: &[S], outputs: &[S]) -> Result<Recording, TableError> {
        let t = self.times(time)?;
        for name in inputs {
            let (name, k) = (name.as_ref(), self.index(name.as_ref())?);
            if self.values(name)?.first().is_some_and(Option::is_none) {
                return Err(TableError::Missing { line: self.lines[0], column: k + 1, name: self.names[k].clone() });
            }
        }
        Ok(Recording::with_missing(t, &self.matrix(inputs)?, &self.matrix(outputs)?)?)
    }

    /// Suspicious data of a log: gaps, missing values, and outputs that are constant or stay at a limit.
    ///
    /// # Errors
    /// As [`recording`](Self::recording).
    pub fn suspicions<S: AsRef<str>>(
        &self,
        time: &str,
        inputs: &[S],
        outputs: &[S],
    ) -> Result<Vec<Suspicion>, TableError> {
        let recording = self.recording(time, inputs, outputs)?;
        let inputs: Vec<&str> = inputs.iter().map(AsRef::as_ref).collect();
        let outputs: Vec<&str> = outputs.iter().map(AsRef::as_ref).collect();
        Ok(suspicion::suspicions(&recording, &inputs, &outputs))
    }
}
