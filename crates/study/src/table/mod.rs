//! Tables of numbers from CSV text: measured logs, inputs and references.
//!
//! The first line has the names of the columns, the others numbers. The separator is a comma, semicolon or tab, as in
//! the first line; lines that begin with `#` are comments. The decimal sign is a point. A cell that is blank, `NaN`,
//! `NA` or `null` is a missing value. Every mistake is reported with line and column.

mod error;
mod suspicion;

use std::path::Path;

use csv::{ReaderBuilder, StringRecord, Trim};
use luenberger_expression::nearest;
use luenberger_sim::{Between, Recording, Samples};
use nalgebra::DMatrix;

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

/// What stands in a cell without a value, in any case.
const MISSING: [&str; 5] = ["", "nan", "na", "n/a", "null"];

/// Named columns of finite numbers, of equal length; values may be missing.
#[derive(Clone, Debug, PartialEq)]
pub struct Table {
    names: Vec<String>,
    columns: Vec<Vec<Option<f64>>>,
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
    /// let error = Table::parse("t,u\n0,1\n0.1,1.5V\n").unwrap_err();
    /// assert_eq!(error.to_string(), "line 3, column 2 (u): expected a number, found `1.5V`");
    /// # Ok::<(), luenberger_study::table::TableError>(())
    /// ```
    /// # Errors
    /// [`TableError`] with line and column.
    pub fn parse(text: &str) -> Result<Self, TableError> {
        // Spreadsheets begin a file with a byte-order mark, and some use semicolons.
        let text = text.strip_prefix('\u{feff}').unwrap_or(text);
        let first = text.lines().map(str::trim_start).find(|line| !line.is_empty() && !line.starts_with('#'));
        let first = first.ok_or(TableError::Empty)?;
        let delimiter = [',', ';', '\t'].into_iter().find(|&delimiter| first.contains(delimiter)).unwrap_or(',');
        let mut reader = ReaderBuilder::new()
            .has_headers(false)
            .flexible(true)
            .delimiter(delimiter as u8)
            .comment(Some(b'#'))
            .trim(Trim::All)
            .from_reader(text.as_bytes());
        let mut table: Option<Self> = None;
        let mut record = StringRecord::new();
        while reader.read_record(&mut record)? {
            let line = record.position().map_or(0, |position| line_of(text, position));
            match &mut table {
                None => table = Some(Self::header(line, &record)?),
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
        let text = std::fs::read_to_string(path).map_err(|error| TableError::File { path: path.to_owned(), error })?;
        Self::parse(&text)
    }

    fn header(line: u64, record: &StringRecord) -> Result<Self, TableError> {
        let names: Vec<String> = record.iter().map(str::to_owned).collect();
        for (k, name) in names.iter().enumerate() {
            if name.is_empty() || name.parse::<f64>().is_ok() {
                return Err(TableError::NoHeader { line, column: k + 1, cell: name.clone() });
            }
            if let Some(first) = names[..k].iter().position(|other| other == name) {
                return Err(TableError::DuplicateColumn { name: name.clone(), first: first + 1, second: k + 1 });
            }
        }
        Ok(Self { columns: vec![Vec::new(); names.len()], names, lines: Vec::new() })
    }

    fn row(&mut self, line: u64, record: &StringRecord) -> Result<(), TableError> {
        if record.len() != self.names.len() {
            return Err(TableError::Cells { line, expected: self.names.len(), found: record.len() });
        }
        if self.names.len() * (self.lines.len() + 1) > LARGEST {
            return Err(TableError::TooLarge { line });
        }
        for (k, cell) in record.iter().enumerate() {
            let (column, name) = (k + 1, &self.names[k]);
            if MISSING.iter().any(|missing| cell.eq_ignore_ascii_case(missing)) {
                self.columns[k].push(None);
                continue;
            }
            let Ok(value) = cell.parse::<f64>() else {
                return Err(TableError::NotANumber { line, column, name: name.clone(), cell: cell.to_owned() });
            };
            if !value.is_finite() {
                return Err(TableError::NotFinite { line, column, name: name.clone(), value });
            }
            self.columns[k].push(Some(value));
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

    fn index(&self, name: &str) -> Result<usize, TableError> {
        self.names.iter().position(|known| known == name).ok_or_else(|| TableError::MissingColumn {
            name: name.to_owned(),
            nearest: nearest(name, self.names.iter().map(String::as_str)).map(str::to_owned),
            known: self.names.clone(),
        })
    }

    /// The column of that name, in which values may be missing.
    ///
    /// # Errors
    /// [`TableError::MissingColumn`].
    pub fn values(&self, name: &str) -> Result<&[Option<f64>], TableError> {
        Ok(&self.columns[self.index(name)?])
    }

    /// The column of that name, which has to be complete.
    ///
    /// # Errors
    /// [`TableError::MissingColumn`], [`TableError::Missing`].
    pub fn column(&self, name: &str) -> Result<Vec<f64>, TableError> {
        let k = self.index(name)?;
        let cells = self.columns[k].iter().zip(&self.lines);
        let missing = |line: u64| TableError::Missing { line, column: k + 1, name: name.to_owned() };
        cells.map(|(cell, line)| cell.ok_or_else(|| missing(*line))).collect()
    }

    /// The time column, which must be increasing and have at least two rows.
    fn times(&self, name: &str) -> Result<Vec<f64>, TableError> {
        let t = self.column(name)?;
        if t.len() < 2 {
            return Err(TableError::TooFewRows { rows: t.len(), needed: 2 });
        }
        for (pair, line) in t.windows(2).zip(&self.lines[1..]) {
            if pair[1] <= pair[0] {
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
    pub fn samples<S: AsRef<str>>(&self, time: &str, columns: &[S], between: Between) -> Result<Samples, TableError> {
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
        Ok(Samples::with_missing(self.times(time)?, &values, Between::Hold)?)
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
            if self.columns[k].first().is_some_and(Option::is_none) {
                return Err(TableError::Missing { line: self.lines[0], column: k + 1, name: name.to_owned() });
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
        Ok(suspicion::of(&recording, &inputs, &outputs))
    }
}
