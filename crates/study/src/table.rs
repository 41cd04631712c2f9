//! Tables of numbers from CSV text: measured logs, inputs and references.
//!
//! The first line has the names of the columns, the others numbers. The separator is a comma, semicolon or tab, as in
//! the first line; lines that begin with `#` are comments. The decimal sign is a point. Every mistake is reported with
//! line and column.

use std::io;
use std::path::{Path, PathBuf};

use csv::{ReaderBuilder, StringRecord, Trim};
use luenberger_expression::nearest;
use luenberger_sim::{Between, Recording, Samples, SimError};
use nalgebra::DMatrix;

/// The maximal number of values: 400 MB.
const LARGEST: usize = 50_000_000;

/// Error of a table. Lines and columns count from 1.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum TableError {
    /// A file that cannot be read.
    #[error("{}: {error}", path.display())]
    File {
        /// The file.
        path: PathBuf,
        /// Why not.
        error: io::Error,
    },
    /// A text that is not UTF-8, or has unbalanced quotation marks.
    #[error("the table cannot be read: {0}")]
    Csv(#[from] csv::Error),
    /// The text has no lines.
    #[error("the table is empty: expected a line that names the columns")]
    Empty,
    /// A first line with a number where a name should be.
    #[error(
        "line {line}, column {column}: expected the name of a column, found `{cell}`; the first line of a table names its columns"
    )]
    NoHeader {
        /// The line.
        line: u64,
        /// The column.
        column: usize,
        /// The cell.
        cell: String,
    },
    /// Two columns with the same name.
    #[error("columns {first} and {second} are both named `{name}`")]
    DuplicateColumn {
        /// The name.
        name: String,
        /// The first of the two.
        first: usize,
        /// The second of the two.
        second: usize,
    },
    /// A line with more or fewer cells than columns.
    #[error("line {line} has {found} cells where the table has {expected} columns")]
    Cells {
        /// The line.
        line: u64,
        /// Number of columns.
        expected: usize,
        /// Number of cells.
        found: usize,
    },
    /// A cell that is not a number.
    #[error("line {line}, column {column} ({name}): expected a number, found `{cell}`")]
    NotANumber {
        /// The line.
        line: u64,
        /// The column.
        column: usize,
        /// Name of the column.
        name: String,
        /// The cell.
        cell: String,
    },
    /// A cell that is NaN or infinite.
    #[error("line {line}, column {column} ({name}): {value} is not a finite number")]
    NotFinite {
        /// The line.
        line: u64,
        /// The column.
        column: usize,
        /// Name of the column.
        name: String,
        /// What is there.
        value: f64,
    },
    /// More values than the limit.
    #[error("line {line}: the table has more than {LARGEST} numbers")]
    TooLarge {
        /// The line at which the limit is exceeded.
        line: u64,
    },
    /// A column that the table does not have.
    #[error("there is no column `{name}`; {}", advice(nearest.as_ref(), known))]
    MissingColumn {
        /// The name.
        name: String,
        /// The nearest name, if one is close.
        nearest: Option<String>,
        /// The existing names.
        known: Vec<String>,
    },
    /// Too few lines.
    #[error("the table has {rows} rows; at least {needed} are needed")]
    TooFewRows {
        /// Number of rows.
        rows: usize,
        /// Required number of rows.
        needed: usize,
    },
    /// Times that do not increase.
    #[error("line {line}: the time {next} does not come after {previous}, the time of the row before")]
    TimesUnsorted {
        /// The line of the second of the two.
        line: u64,
        /// The first of the two.
        previous: f64,
        /// The second of the two.
        next: f64,
    },
    /// An error of the simulation for these samples.
    #[error(transparent)]
    Samples(#[from] SimError),
}

fn advice(nearest: Option<&String>, known: &[String]) -> String {
    match nearest {
        Some(nearest) => format!("did you mean `{nearest}`?"),
        None => format!("the columns are {}", known.join(", ")),
    }
}

/// The line number of a record: the reader's position is before the empty lines and comments that it skips.
fn line_of(text: &str, position: &csv::Position) -> u64 {
    let rest = usize::try_from(position.byte()).ok().and_then(|byte| text.get(byte..)).unwrap_or("");
    let left_out = rest.lines().take_while(|line| line.is_empty() || line.starts_with('#')).count();
    position.line() + left_out as u64
}

/// Named columns of finite numbers, of equal length.
#[derive(Clone, Debug, PartialEq)]
pub struct Table {
    names: Vec<String>,
    columns: Vec<Vec<f64>>,
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
            let Ok(value) = cell.parse::<f64>() else {
                return Err(TableError::NotANumber { line, column, name: name.clone(), cell: cell.to_owned() });
            };
            if !value.is_finite() {
                return Err(TableError::NotFinite { line, column, name: name.clone(), value });
            }
            self.columns[k].push(value);
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

    /// The column of that name.
    ///
    /// # Errors
    /// [`TableError::MissingColumn`].
    pub fn column(&self, name: &str) -> Result<&[f64], TableError> {
        match self.names.iter().position(|known| known == name) {
            Some(k) => Ok(&self.columns[k]),
            None => Err(TableError::MissingColumn {
                name: name.to_owned(),
                nearest: nearest(name, self.names.iter().map(String::as_str)).map(str::to_owned),
                known: self.names.clone(),
            }),
        }
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
        Ok(t.to_vec())
    }

    fn matrix<S: AsRef<str>>(&self, names: &[S]) -> Result<DMatrix<f64>, TableError> {
        let columns = names.iter().map(|name| self.column(name.as_ref())).collect::<Result<Vec<_>, _>>()?;
        Ok(DMatrix::from_fn(self.rows(), names.len(), |i, j| columns[j][i]))
    }

    /// Some columns as a function of the time column.
    ///
    /// # Errors
    /// [`TableError::MissingColumn`], [`TableError::TooFewRows`], [`TableError::TimesUnsorted`].
    pub fn samples<S: AsRef<str>>(&self, time: &str, columns: &[S], between: Between) -> Result<Samples, TableError> {
        Ok(Samples::new(self.times(time)?, self.matrix(columns)?, between)?)
    }

    /// A measured log: the columns of the time, of the inputs and of the outputs.
    ///
    /// ```
    /// use luenberger_study::table::Table;
    /// let table = Table::parse("t,y1,u1\n0,1,0\n0.1,2,0\n0.25,3,1\n")?;
    /// let log = table.recording("t", &["u1"], &["y1"])?;
    /// assert_eq!(log.times(), [0.0, 0.1, 0.25]);
    /// let error = table.recording("t", &["u1"], &["y2"]).unwrap_err();
    /// assert_eq!(error.to_string(), "there is no column `y2`; did you mean `y1`?");
    /// # Ok::<(), luenberger_study::table::TableError>(())
    /// ```
    /// # Errors
    /// As [`samples`](Self::samples).
    pub fn recording<S: AsRef<str>>(&self, time: &str, inputs: &[S], outputs: &[S]) -> Result<Recording, TableError> {
        Ok(Recording::new(self.times(time)?, self.matrix(inputs)?, self.matrix(outputs)?)?)
    }

    /// Suspicious data of a log: gaps, and outputs that are constant or stay at a limit.
    ///
    /// # Errors
    /// [`TableError::MissingColumn`], [`TableError::TooFewRows`], [`TableError::TimesUnsorted`].
    pub fn suspicions<S: AsRef<str>>(&self, time: &str, outputs: &[S]) -> Result<Vec<Suspicion>, TableError> {
        let t = self.times(time)?;
        let mut found = gaps(&t);
        for name in outputs {
            let column = self.column(name.as_ref())?;
            found.extend(stuck(name.as_ref(), &t, column));
        }
        Ok(found)
    }
}

/// A pattern in a log that suggests a sensor fault.
#[derive(Clone, Debug, PartialEq)]
pub enum Suspicion {
    /// No samples for several times the usual period.
    Gap {
        /// The last time before the gap.
        from: f64,
        /// The first time after the gap.
        to: f64,
        /// The median period.
        usual: f64,
    },
    /// A column that never changes.
    Constant {
        /// Its name.
        column: String,
        /// Its value.
        value: f64,
    },
    /// A column that stays at its largest or smallest value: a sensor in saturation.
    Saturated {
        /// Its name.
        column: String,
        /// The value.
        value: f64,
        /// Number of samples at this value.
        samples: usize,
        /// Begin and end of the longest interval.
        longest: (f64, f64),
    },
    /// A column that repeats one value exactly, within its range: a sensor dropout.
    Frozen {
        /// Its name.
        column: String,
        /// The value.
        value: f64,
        /// Number of consecutive samples at this value.
        samples: usize,
        /// Begin and end of the interval.
        during: (f64, f64),
    },
}

impl core::fmt::Display for Suspicion {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        match self {
            Self::Gap { from, to, usual } => {
                write!(f, "no samples from t = {from} to t = {to}, where {usual} from one to the next is usual")
            }
            Self::Constant { column, value } => write!(f, "`{column}` is {value} throughout"),
            Self::Saturated { column, value, samples, longest: (from, to) } => write!(
                f,
                "`{column}` is at its limit {value} in {samples} samples, longest from t = {from} to t = {to}: saturation?"
            ),
            Self::Frozen { column, value, samples, during: (from, to) } => write!(
                f,
                "`{column}` is exactly {value} in {samples} samples in a row, from t = {from} to t = {to}: a dropout?"
            ),
        }
    }
}

/// An interval longer than this many usual periods is a gap.
const GAP: f64 = 5.0;

/// Minimal number of consecutive equal samples, at a limit and in between.
const AT_LIMIT: usize = 4;
const IN_BETWEEN: usize = 10;

/// Coarsely quantized columns repeat values normally: repetitions are only reported if the column has at least this
/// many different values.
const DIFFERENT: usize = 100;

fn gaps(t: &[f64]) -> Vec<Suspicion> {
    let mut periods: Vec<f64> = t.windows(2).map(|pair| pair[1] - pair[0]).collect();
    periods.sort_by(f64::total_cmp);
    let usual = periods[periods.len() / 2];
    let wide = t.windows(2).filter(|pair| pair[1] - pair[0] > GAP * usual);
    wide.map(|pair| Suspicion::Gap { from: pair[0], to: pair[1], usual }).collect()
}

fn stuck(name: &str, t: &[f64], column: &[f64]) -> Vec<Suspicion> {
    let (low, high) =
        column.iter().fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), &y| (low.min(y), high.max(y)));
    let column_name = name.to_owned();
    if low == high {
        return vec![Suspicion::Constant { column: column_name, value: low }];
    }
    let mut different = column.to_vec();
    different.sort_by(f64::total_cmp);
    different.dedup();
    if different.len() < DIFFERENT.min(column.len() / 4) {
        return Vec::new();
    }
    // Runs of equal values: start index, length.
    let mut runs: Vec<(usize, usize)> = Vec::new();
    for (k, value) in column.iter().enumerate() {
        match runs.last_mut() {
            Some((start, length)) if column[*start] == *value => *length += 1,
            _ => runs.push((k, 1)),
        }
    }
    let span = |(start, length): (usize, usize)| (t[start], t[start + length - 1]);
    let mut found = Vec::new();
    for value in [low, high] {
        let at: Vec<_> =
            runs.iter().copied().filter(|(start, length)| column[*start] == value && *length >= AT_LIMIT).collect();
        if let Some(longest) = at.iter().copied().max_by_key(|(_, length)| *length) {
            let samples = at.iter().map(|(_, length)| length).sum();
            found.push(Suspicion::Saturated { column: column_name.clone(), value, samples, longest: span(longest) });
        }
    }
    for run in runs
        .into_iter()
        .filter(|(start, length)| *length >= IN_BETWEEN && column[*start] != low && column[*start] != high)
    {
        let (value, samples) = (column[run.0], run.1);
        found.push(Suspicion::Frozen { column: column_name.clone(), value, samples, during: span(run) });
    }
    found
}
