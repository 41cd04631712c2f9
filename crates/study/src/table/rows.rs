//! Rows of a log one at a time, as they arrive: lines of CSV below a line that names the columns, or JSON objects, one
//! a line, whose keys are the names.
//!
//! Each row is read as a table of one row, by the rules of logs. In JSON an absent key and null are a missing value, a
//! text is what would stand in the cell.

use csv::{ReaderBuilder, StringRecord};
use serde_json::{Map, Value};

use super::moment::{Clock, Moment};
use super::{Reader, Table, TableError, is_left_out, records, separator_of};

/// How rows are written.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Form {
    /// Comma-separated values, with a line that names the columns.
    Csv,
    /// A JSON object a line.
    Json,
}

/// The columns of a log, or expressions of columns, for the time, the inputs and the outputs.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct LogColumns {
    /// The time.
    pub time: String,
    /// The inputs.
    pub inputs: Vec<String>,
    /// The outputs.
    pub outputs: Vec<String>,
}

/// What the times are counted from.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Times {
    /// No row has come.
    Unknown,
    /// They are numbers.
    Numbers,
    /// They are dates or times of day.
    Moments(Clock),
}

/// A row. Values may be missing.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct LogRow {
    /// None of rows without times.
    pub(crate) time: Option<f64>,
    pub(crate) inputs: Vec<Option<f64>>,
    pub(crate) outputs: Vec<Option<f64>>,
    times: Times,
}

/// The rows of a log that arrives.
#[derive(Debug)]
pub(crate) struct LogRows {
    /// None until the first line that is no comment.
    form: Option<Form>,
    columns: LogColumns,
    is_timed: bool,
    /// The names, and the last row; none before the line of names.
    table: Option<Table>,
    records: ReaderBuilder,
    time: Option<Reader>,
    inputs: Vec<Option<Reader>>,
    outputs: Vec<Option<Reader>>,
    times: Times,
}

impl LogRows {
    /// Rows with these columns, without a form in that of the first of them: an object begins with a brace. `is_timed`
    /// says whether they have times.
    pub(crate) fn new(form: Option<Form>, columns: LogColumns, is_timed: bool) -> Self {
        let (inputs, outputs) = (vec![None; columns.inputs.len()], vec![None; columns.outputs.len()]);
        let (table, records, times) = (None, records(b','), Times::Unknown);
        Self { form, columns, is_timed, table, records, time: None, inputs, outputs, times }
    }

    /// How the rows are written, if that is known.
    pub(crate) fn form(&self) -> Option<Form> {
        self.form
    }

    /// Whether the columns are known, without which no row is read.
    pub(crate) fn knows_columns(&self) -> bool {
        self.table.is_some() || self.form == Some(Form::Json)
    }

    /// The columns of inputs and outputs that have not occurred in the objects so far.
    pub(crate) fn unseen(&self) -> Vec<&str> {
        if self.form != Some(Form::Json) {
            return Vec::new();
        }
        let inputs = self.inputs.iter().zip(&self.columns.inputs);
        let all = inputs.chain(self.outputs.iter().zip(&self.columns.outputs));
        all.filter_map(|(reader, name)| reader.is_none().then_some(name.as_str())).collect()
    }

    /// The row in a line, without its end; none for the line of names, a comment and a blank line.
    ///
    /// # Errors
    /// [`TableError`] with the line. The next line can be read all the same if the columns are known.
    pub(crate) fn line(&mut self, line: u64, bytes: &[u8]) -> Result<Option<LogRow>, TableError> {
        let text = std::str::from_utf8(bytes)
            .map_err(|error| TableError::Encoding { line, byte: bytes[error.valid_up_to()] })?;
        let text = if line == 1 { text.strip_prefix('\u{feff}').unwrap_or(text) } else { text };
        if is_left_out(text.trim_start()) {
            return Ok(None);
        }
        let found = if text.trim_start().starts_with('{') { Form::Json } else { Form::Csv };
        match (*self.form.get_or_insert(found), &mut self.table) {
            (Form::Json, _) => self.object(line, text)?,
            (Form::Csv, None) => {
                self.records = records(separator_of(text));
                let names = self.cells(text)?;
                self.table = Some(self.found(Table::header(line, &names, separator_of(text))?)?);
                return Ok(None);
            }
            (Form::Csv, Some(_)) => {
                let cells = self.cells(text)?;
                if let Some(table) = &mut self.table {
                    table.only(line, &cells)?;
                }
            }
        }
        self.row(line).map(Some)
    }

    /// The cells of a line.
    fn cells(&self, text: &str) -> Result<StringRecord, TableError> {
        let mut cells = StringRecord::new();
        self.records.from_reader(text.as_bytes()).read_record(&mut cells)?;
        Ok(cells)
    }

    /// The table, with the readers of all columns.
    fn found(&mut self, table: Table) -> Result<Table, TableError> {
        if self.is_timed {
            self.time = Some(table.reader(&self.columns.time)?);
        }
        let all = |names: &[String]| names.iter().map(|name| table.reader(name).map(Some)).collect::<Result<_, _>>();
        (self.inputs, self.outputs) = (all(&self.columns.inputs)?, all(&self.columns.outputs)?);
        Ok(table)
    }

    /// Reads an object.
    fn object(&mut self, line: u64, text: &str) -> Result<(), TableError> {
        let mut object: Map<String, Value> = serde_json::from_str(text).map_err(|error| {
            let why = if text.trim_start().starts_with('{') {
                // The position without the line, which is that of the text and not that of the stream.
                let said = error.to_string();
                let what = said.rsplit_once(" at line ").map_or(said.as_str(), |(what, _)| what);
                format!("{what} at column {}", error.column())
            } else {
                // Enough of it to be recognised.
                let begin: String = text.trim().chars().take(20).collect();
                format!("it begins with `{begin}`; the form of rows of CSV is csv")
            };
            TableError::Json { line, why }
        })?;
        // A key that cannot name a column is not used.
        let names = |key: &&String| !key.is_empty() && key.parse::<f64>().is_err();
        let known = self.table.as_ref().map_or(&[][..], Table::names);
        let new: Vec<String> = object.keys().filter(names).filter(|key| !known.contains(key)).cloned().collect();
        if !new.is_empty() {
            let names: StringRecord = known.iter().cloned().chain(new).collect();
            let table = Table::header(line, &names, b',')?;
            let of = |name: &String| table.reader(name).ok();
            self.time = of(&self.columns.time).filter(|_| self.is_timed);
            self.inputs = self.columns.inputs.iter().map(of).collect();
            self.outputs = self.columns.outputs.iter().map(of).collect();
            self.table = Some(table);
        }
        let Some(table) = &mut self.table else {
            return Err(TableError::Json { line, why: "it has no keys".to_owned() });
        };
        let cells: StringRecord = table
            .names()
            .iter()
            .map(|name| match object.remove(name) {
                None | Some(Value::Null) => String::new(),
                Some(Value::String(text)) => text.trim().to_owned(),
                Some(other) => other.to_string(),
            })
            .collect();
        table.only(line, &cells)?;
        if self.is_timed && self.time.is_none() {
            table.reader(&self.columns.time)?;
        }
        match self.columns.outputs.first() {
            Some(name) if self.inputs.iter().chain(&self.outputs).all(Option::is_none) => {
                table.reader(name).map(|_| ())
            }
            _ => Ok(()),
        }
    }

    /// The row that the table holds.
    fn row(&self, line: u64) -> Result<LogRow, TableError> {
        let table = self.table.as_ref().ok_or(TableError::Empty)?;
        let value = |reader: &Reader| table.read_by(reader).map(|(_, values)| values.first().copied().flatten());
        let all = |readers: &[Option<Reader>]| {
            readers.iter().map(|reader| reader.as_ref().map_or(Ok(None), value)).collect::<Result<Vec<_>, _>>()
        };
        let (inputs, outputs) = (all(&self.inputs)?, all(&self.outputs)?);
        let Some(time) = &self.time else {
            return Ok(LogRow { time: None, inputs, outputs, times: self.times });
        };
        let column = time.first();
        let name = || self.columns.time.clone();
        let (time, times) = match (moment(table, time), self.times) {
            (Some(moment), Times::Unknown) => {
                let mut clock = Clock::at(moment);
                (clock.seconds(moment), Times::Moments(clock))
            }
            (Some(moment), Times::Moments(mut clock)) => {
                let seconds = clock.seconds(moment);
                let is_like = || TableError::NoMoment { line, column: column + 1, name: name() };
                (Some(seconds.ok_or_else(is_like)?), Times::Moments(clock))
            }
            (None, Times::Moments(_)) if value(time).is_ok_and(|value| value.is_some()) => {
                return Err(TableError::NoMoment { line, column: column + 1, name: name() });
            }
            (_, times) => (value(time)?, if times == Times::Unknown { Times::Numbers } else { times }),
        };
        let missing = || TableError::Missing { line, column: column + 1, name: name() };
        Ok(LogRow { time: Some(time.ok_or_else(missing)?), inputs, outputs, times })
    }

    /// That this row has been used: the times after it are counted from it.
    pub(crate) fn accept(&mut self, row: &LogRow) {
        self.times = row.times;
    }

    /// From what times are counted, as words.
    pub(crate) fn words_of_times(&self) -> String {
        match &self.times {
            Times::Unknown => "unknown".to_owned(),
            Times::Numbers => "numbers".to_owned(),
            Times::Moments(clock) => clock.words(),
        }
    }

    /// Goes on from [`words_of_times`](Self::words_of_times); false for other words.
    pub(crate) fn resume_times(&mut self, words: &str) -> bool {
        let times = match words {
            "unknown" => Some(Times::Unknown),
            "numbers" => Some(Times::Numbers),
            words => Clock::from_words(words).map(Times::Moments),
        };
        self.times = times.unwrap_or(self.times);
        times.is_some()
    }
}

/// The moment in a column of the only row.
fn moment(table: &Table, reader: &Reader) -> Option<Moment> {
    let Reader::Column(k) = reader else { return None };
    table.columns[*k].moments.first().copied().flatten()
}
