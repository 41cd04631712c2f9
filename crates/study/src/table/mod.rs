//! Tables of numbers from CSV text: measured logs, inputs and references.
//!
//! The first line has the names of the columns, the others numbers. The separator is a tab, semicolon or comma, as in
//! the first line; lines that begin with `#` are comments. The decimal sign is a point, or a comma between semicolons
//! or tabs. A cell that is blank, `NaN`, `NA` or `null` is a missing value. A name may have a unit in brackets, which
//! is left out when the column is looked for: `voltage [V]` is `voltage`. Text in a column that is not used is no
//! mistake; every other one is reported with line and column.
//!
//! In place of a name may stand an expression of columns, such as `acc_x/9.81` or `(stamp - 1.7e9)/1e6`; a column of
//! that name comes first. The column of times may have dates or times of day in place of numbers: they are seconds
//! since the first row. Rows of one time, of sensors that measure independently of each other, are one row of a log.

mod cell;
mod error;
mod moment;
mod repeats;
mod rows;
mod suspicion;

use std::borrow::Cow;
use std::ops::Range;
use std::path::Path;

use csv::{ReaderBuilder, StringRecord, Trim};
use luenberger_expression::{Expression, Scope, Variable, nearest};
use luenberger_sim::{Recording, SampleInterpolation, Samples};
use nalgebra::DMatrix;

use cell::{Cell, Decimal};
use moment::Moment;

pub use error::TableError;
pub use rows::{Form, LogColumns};
pub(crate) use rows::{LogRow, LogRows};
pub use suspicion::Suspicion;

/// The maximal number of values: 400 MB.
const LARGEST: usize = 50_000_000;

/// The line number of a record: the reader's position is before the empty lines and comments that it skips.
fn line_of(text: &str, position: &csv::Position) -> u64 {
    let rest = usize::try_from(position.byte()).ok().and_then(|byte| text.get(byte..)).unwrap_or("");
    let left_out = rest.lines().take_while(|line| is_left_out(line)).count();
    position.line() + left_out as u64
}

/// Whether a line, without the spaces before it, has no cells: it is blank or a comment.
fn is_left_out(line: &str) -> bool {
    line.is_empty() || line.starts_with('#')
}

/// The separator of the cells, by the line that names the columns.
fn separator_of(line: &str) -> u8 {
    [b'\t', b';'].into_iter().find(|separator| line.as_bytes().contains(separator)).unwrap_or(b',')
}

/// What reads the cells of lines.
fn records(separator: u8) -> ReaderBuilder {
    let mut records = ReaderBuilder::new();
    records.has_headers(false).flexible(true).delimiter(separator).comment(Some(b'#')).trim(Trim::All);
    records
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
    /// Its moments, as long as every cell is a date, a time of day, or blank.
    moments: Vec<Option<Moment>>,
    /// The first cell that is neither number nor blank.
    wrong: Option<(u64, String)>,
    /// Whether a cell is a number, or text that is no moment: then it has no moments.
    is_settled: bool,
}

impl Column {
    /// Reads a cell that is not a number: a moment, if every cell above is blank or one too.
    fn other(&mut self, line: u64, text: &str) {
        match moment::moment(text).filter(|_| !self.is_settled) {
            Some(moment) => self.moments.push(Some(moment)),
            None => self.settle(),
        }
        self.wrong.get_or_insert_with(|| (line, text.to_owned()));
    }

    /// Reads a blank cell.
    fn blank(&mut self) {
        if !self.is_settled {
            self.moments.push(None);
        }
    }

    /// From here on it is no column of moments.
    fn settle(&mut self) {
        if !self.is_settled {
            self.is_settled = true;
            self.moments = Vec::new();
        }
    }
}

/// What stands for a column: the column itself, or an expression of columns.
#[derive(Clone, Debug)]
enum Reader {
    Column(usize),
    Expression {
        text: String,
        expression: Expression,
        /// The column of the name `t`, if that occurs.
        time: Option<usize>,
        /// The columns in it.
        used: Vec<usize>,
    },
}

impl Reader {
    /// The column, or the first one in the expression.
    fn first(&self) -> usize {
        match self {
            Self::Column(k) => *k,
            Self::Expression { used, .. } => used.first().copied().unwrap_or(0),
        }
    }
}

/// The place of a column, and its values.
type Reading<'a> = (usize, Cow<'a, [Option<f64>]>);

/// How the values of rows of one time are one value.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Together {
    /// The last one holds, as of an input that is set.
    Last,
    /// There is one only, as of a sensor.
    Only,
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
    /// Whether every row of a repeated output is a measurement.
    every_row: bool,
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
        let first = text.lines().map(str::trim_start).find(|line| !is_left_out(line));
        let separator = separator_of(first.ok_or(TableError::Empty)?);
        let mut reader = records(separator).from_reader(text.as_bytes());
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
            // Tables of pandas begin with a column without a name: the numbers of the rows.
            if k == 0 && name.is_empty() && names.len() > 1 {
                continue;
            }
            if name.is_empty() || name.parse::<f64>().is_ok() {
                return Err(TableError::NoHeader { line, column: k + 1, cell: name.clone() });
            }
            if let Some(first) = names[..k].iter().position(|other| other == name) {
                return Err(TableError::DuplicateColumn { name: name.clone(), first: first + 1, second: k + 1 });
            }
        }
        let (columns, lines) = (vec![Column::default(); names.len()], Vec::new());
        Ok(Self { columns, names, separator, decimal: None, lines, every_row: false })
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
                Cell::Number(value) if value.is_finite() => {
                    column.settle();
                    Some(value)
                }
                Cell::Missing => {
                    column.blank();
                    None
                }
                Cell::Number(_) | Cell::Wrong(_) => {
                    column.other(line, text);
                    None
                }
            };
            column.values.push(value);
        }
        self.lines.push(line);
        Ok(())
    }

    /// Reads a line in place of all that were read before.
    fn only(&mut self, line: u64, record: &StringRecord) -> Result<(), TableError> {
        self.lines.clear();
        for column in &mut self.columns {
            column.values.clear();
            column.moments.clear();
            (column.wrong, column.is_settled) = (None, false);
        }
        self.row(line, record)
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
            known: self.names.iter().filter(|name| !name.is_empty()).cloned().collect(),
        })
    }

    /// The column of that name, in which values may be missing.
    ///
    /// # Errors
    /// [`TableError::MissingColumn`], [`TableError::NotANumber`], [`TableError::NotFinite`].
    pub fn values(&self, name: &str) -> Result<&[Option<f64>], TableError> {
        self.values_at(self.index(name)?)
    }

    /// The column at this place.
    fn values_at(&self, k: usize) -> Result<&[Option<f64>], TableError> {
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
        self.complete(name, self.values(name)?)
    }

    /// The column of that name or an expression of columns.
    fn reader(&self, name: &str) -> Result<Reader, TableError> {
        let missing = match self.index(name) {
            Ok(k) => return Ok(Reader::Column(k)),
            Err(missing) => missing,
        };
        let is_expression = |c: char| "+-*/^()".contains(c);
        if !name.contains(is_expression) {
            return Err(missing);
        }
        let names = self.names.iter().enumerate().map(|(k, name)| (without_unit(name).to_owned(), Variable::State(k)));
        let expression = Expression::parse(name, &Scope::variables(self.names.len(), 0, names));
        let expression = match (expression, missing) {
            (Ok(expression), _) => expression,
            // More likely the name of a column with a sign in it, misspelt.
            (Err(_), near @ TableError::MissingColumn { nearest: Some(_), .. }) => return Err(near),
            (Err(error), _) => {
                return Err(TableError::Expression { text: name.to_owned(), why: error.kind().to_string() });
            }
        };
        // `t` is a name of its own in expressions; here it is the column.
        let time = if expression.uses_time() { Some(self.index("t")?) } else { None };
        let is_used = |k: &usize| time == Some(*k) || expression.depends_on_state(*k);
        let used: Vec<usize> = (0..self.names.len()).filter(is_used).collect();
        if used.is_empty() {
            let why = "no column occurs in it".to_owned();
            return Err(TableError::Expression { text: name.to_owned(), why });
        }
        Ok(Reader::Expression { text: name.to_owned(), expression, time, used })
    }

    /// The values of a column or of an expression of columns, in which values may be missing; and the place of the
    /// column, or of the first one in the expression.
    fn read_by(&self, reader: &Reader) -> Result<Reading<'_>, TableError> {
        let (text, expression, time, used) = match reader {
            Reader::Column(k) => return Ok((*k, self.values_at(*k)?.into())),
            Reader::Expression { text, expression, time, used } => (text, expression, time, used),
        };
        let first = reader.first();
        let columns = used.iter().map(|k| self.values_at(*k)).collect::<Result<Vec<_>, _>>()?;
        let mut x = vec![f64::NAN; self.names.len()];
        let value = |i: usize| {
            for (k, column) in used.iter().zip(&columns) {
                let Some(value) = column[i] else { return Ok(None) };
                x[*k] = value;
            }
            let value = expression.evaluate(time.map_or(f64::NAN, |k| x[k]), &x, &[]);
            let wrong = || TableError::NotFinite { line: self.lines[i], column: first + 1, name: text.clone(), value };
            if value.is_finite() { Ok(Some(value)) } else { Err(wrong()) }
        };
        Ok((first, (0..self.rows()).map(value).collect::<Result<Vec<_>, _>>()?.into()))
    }

    fn reading(&self, name: &str) -> Result<Reading<'_>, TableError> {
        self.read_by(&self.reader(name)?)
    }

    /// The values of the column of that name, or of an expression, of which none may be missing.
    fn complete<T: Copy>(&self, name: &str, values: &[Option<T>]) -> Result<Vec<T>, TableError> {
        values.iter().enumerate().map(|(row, value)| value.ok_or_else(|| self.missing(row, name))).collect()
    }

    /// That a value is missing in a row, of a column or of an expression, whose place is its first column.
    fn missing(&self, row: usize, name: &str) -> TableError {
        let (column, name) = match self.index(name) {
            Ok(k) => (k, self.names[k].clone()),
            Err(_) => (self.reading(name).map_or(0, |(k, _)| k), name.to_owned()),
        };
        TableError::Missing { line: self.lines[row], column: column + 1, name }
    }

    /// The time column, which must not decrease and have at least two rows.
    fn instants(&self, name: &str) -> Result<Vec<f64>, TableError> {
        let moments = self.index(name).ok().map(|k| &self.columns[k].moments);
        let t = match moments.filter(|moments| moments.iter().any(Option::is_some)) {
            // Of different kinds: the error is that of a column of numbers.
            Some(moments) => moment::seconds(&self.complete(name, moments)?).map_or_else(|| self.column(name), Ok)?,
            None => self.complete(name, &self.reading(name)?.1)?,
        };
        if t.len() < 2 {
            return Err(TableError::TooFewRows { rows: t.len(), needed: 2 });
        }
        for (pair, line) in t.windows(2).zip(&self.lines[1..]) {
            if pair[1] < pair[0] {
                return Err(TableError::TimesUnsorted { line: *line, previous: pair[0], next: pair[1] });
            }
        }
        Ok(t)
    }

    /// The time column, in which each row has a time of its own.
    fn times(&self, name: &str) -> Result<Vec<f64>, TableError> {
        let t = self.instants(name)?;
        match t.windows(2).position(|pair| pair[1] == pair[0]) {
            Some(k) => Err(TableError::TimeTwice { line: self.lines[k + 1], time: t[k] }),
            None => Ok(t),
        }
    }

    /// The times of a log, and the rows of each.
    fn distinct_times(&self, name: &str) -> Result<(Vec<f64>, Vec<Range<usize>>), TableError> {
        let t = self.instants(name)?;
        let starts: Vec<usize> = (0..t.len()).filter(|&k| k == 0 || t[k] > t[k - 1]).collect();
        let ends = starts.iter().skip(1).copied().chain([t.len()]);
        let rows: Vec<Range<usize>> = starts.iter().zip(ends).map(|(start, end)| *start..end).collect();
        if rows.len() < 2 {
            return Err(TableError::TooFewRows { rows: rows.len(), needed: 2 });
        }
        Ok((starts.into_iter().map(|k| t[k]).collect(), rows))
    }

    /// Columns in which values may be missing, with one row for each of these groups of rows.
    fn matrix<S: AsRef<str>>(
        &self,
        names: &[S],
        rows: &[Range<usize>],
        together: Together,
    ) -> Result<DMatrix<Option<f64>>, TableError> {
        let mut matrix = DMatrix::from_element(rows.len(), names.len(), None);
        for (j, name) in names.iter().enumerate() {
            let (column, values) = self.reading(name.as_ref())?;
            for (i, group) in rows.iter().enumerate() {
                let mut given = group.clone().filter_map(|row| Some((row, values[row]?)));
                let Some((_, first)) = given.next() else { continue };
                let other = given.rfind(|(_, value)| *value != first);
                if let (Some((row, _)), Together::Only) = (other, together) {
                    let (line, name) = (self.lines[row], name.as_ref().to_owned());
                    return Err(TableError::TwoValues { line, column: column + 1, name });
                }
                let last = group.clone().rev().find_map(|row| values[row]);
                matrix[(i, j)] = last;
            }
        }
        Ok(matrix)
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
        let (t, rows) = self.distinct_times(time)?;
        let mut values = DMatrix::from_element(rows.len(), columns.len(), None);
        for (j, name) in columns.iter().enumerate().filter_map(|(j, name)| Some((j, (*name)?))) {
            values.set_column(j, &self.matrix(&[name], &rows, Together::Last)?.column(0));
        }
        Ok(Samples::with_missing(t, &values, SampleInterpolation::ZeroOrderHold)?)
    }

    /// The same table, in which every row of a repeated output is a measurement; otherwise the first of the rows that
    /// repeat it in a rhythm is.
    #[must_use]
    pub fn counting_repeats(self) -> Self {
        Self { every_row: true, ..self }
    }

    /// A measured log: the columns of the time, of the inputs and of the outputs, or expressions of columns. Values of
    /// inputs and outputs may be missing. Rows of one time are one row: an output has one value at a time, and of an
    /// input the last holds.
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
        Ok(self.log(time, inputs, outputs)?.0)
    }

    /// A measured log, and in how many rows each output is repeated.
    fn log<S: AsRef<str>>(
        &self,
        time: &str,
        inputs: &[S],
        outputs: &[S],
    ) -> Result<(Recording, Vec<Option<usize>>), TableError> {
        let (t, rows) = self.distinct_times(time)?;
        let u = self.matrix(inputs, &rows, Together::Last)?;
        if let Some(j) = (0..inputs.len()).find(|j| u[(0, *j)].is_none()) {
            return Err(self.missing(0, inputs[j].as_ref()));
        }
        let mut y = self.matrix(outputs, &rows, Together::Only)?;
        let mut repeated = vec![None; outputs.len()];
        for (j, repeated) in repeated.iter_mut().enumerate().filter(|_| !self.every_row) {
            let there: Vec<usize> = (0..rows.len()).filter(|i| y[(*i, j)].is_some()).collect();
            let values: Vec<f64> = there.iter().filter_map(|i| y[(*i, j)]).collect();
            let Some(rhythm) = repeats::measured(&values) else { continue };
            let mut measured = rhythm.rows.iter().peekable();
            for (k, &i) in there.iter().enumerate() {
                if measured.next_if(|row| **row == k).is_none() {
                    y[(i, j)] = None;
                }
            }
            *repeated = Some(rhythm.each);
        }
        Ok((Recording::with_missing(t, &u, &y)?, repeated))
    }

    /// Suspicious data of a log: gaps, missing values, and outputs that are constant, repeated or stay at a limit.
    ///
    /// # Errors
    /// As [`recording`](Self::recording).
    pub fn suspicions<S: AsRef<str>>(
        &self,
        time: &str,
        inputs: &[S],
        outputs: &[S],
    ) -> Result<Vec<Suspicion>, TableError> {
        Ok(self.recording_with_suspicions(time, inputs, outputs)?.1)
    }

    /// [`recording`](Self::recording) and [`suspicions`](Self::suspicions).
    pub(crate) fn recording_with_suspicions<S: AsRef<str>>(
        &self,
        time: &str,
        inputs: &[S],
        outputs: &[S],
    ) -> Result<(Recording, Vec<Suspicion>), TableError> {
        let (recording, repeated) = self.log(time, inputs, outputs)?;
        let inputs: Vec<&str> = inputs.iter().map(AsRef::as_ref).collect();
        let outputs: Vec<&str> = outputs.iter().map(AsRef::as_ref).collect();
        let suspicions = suspicion::suspicions(&recording, time, (&inputs, &outputs), &repeated);
        Ok((recording, suspicions))
    }
}
