//! Errors of tables, with line and column.

use std::io;
use std::path::PathBuf;

use luenberger_proof::wording::counted;
use luenberger_sim::SimError;

use super::LARGEST;

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
    /// A file in another encoding.
    #[error("line {line}: the byte {byte:#04x} is not UTF-8; save the file as UTF-8 (a spreadsheet: \"CSV UTF-8\")")]
    Encoding {
        /// The line.
        line: u64,
        /// The first byte that does not fit.
        byte: u8,
    },
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
    #[error("line {line} has {} where the table has {}{}", counted(*found, "cell"), counted(*expected, "column"), if found > expected {
        "; a decimal comma needs semicolons or tabs between the cells"
    } else {
        ""
    })]
    Cells {
        /// The line.
        line: u64,
        /// Number of columns.
        expected: usize,
        /// Number of cells.
        found: usize,
    },
    /// A cell that is not a number.
    #[error("line {line}, column {column} ({name}): expected a number, found `{cell}`{advice}")]
    NotANumber {
        /// The line.
        line: u64,
        /// The column.
        column: usize,
        /// Name of the column.
        name: String,
        /// The cell.
        cell: String,
        /// What may be meant; may be empty.
        advice: &'static str,
    },
    /// A cell that is infinite.
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
    /// A time that is not of the kind of those before it.
    #[error("line {line}, column {column} ({name}): expected a date or a time of day of the form of those above")]
    NoMoment {
        /// The line.
        line: u64,
        /// The column.
        column: usize,
        /// Name of the column.
        name: String,
    },
    /// A line that is no JSON object.
    #[error("line {line}: expected a JSON object such as {{\"t\": 0.1, \"y\": 2}}: {why}")]
    Json {
        /// The line.
        line: u64,
        /// Why not.
        why: String,
    },
    /// A blank cell where every value is needed.
    #[error("line {line}, column {column} ({name}): the value is missing")]
    Missing {
        /// The line.
        line: u64,
        /// The column.
        column: usize,
        /// Name of the column.
        name: String,
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
    #[error("the table has {}; at least {needed} are needed", counted(*rows, "row"))]
    TooFewRows {
        /// Number of rows.
        rows: usize,
        /// Required number of rows.
        needed: usize,
    },
    /// Two rows of one time.
    #[error("line {line}: the time {time} is that of the row before; each row needs a time of its own")]
    TimeTwice {
        /// The line of the second.
        line: u64,
        /// The time.
        time: f64,
    },
    /// Two values of an output at one time.
    #[error("line {line}, column {column} ({name}): this time has another value above")]
    TwoValues {
        /// The line of the second.
        line: u64,
        /// The column.
        column: usize,
        /// The name of the column, or the expression.
        name: String,
    },
    /// Something that is neither the name of a column nor an expression of columns.
    #[error("`{text}` is no column, and no expression of columns: {why}")]
    Expression {
        /// The text.
        text: String,
        /// Why not.
        why: String,
    },
    /// Times that decrease.
    #[error(
        "line {line}: the time {next} comes before {previous}, the time of the row above; where the logger started again begins another log"
    )]
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
