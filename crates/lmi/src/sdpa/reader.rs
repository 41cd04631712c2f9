//! SDPA's sparse format (`.dat-s`).
//!
//! ```text
//! "comments, at the head of the file, begin with a quote or a star
//! 1                       number of unknowns, m; what follows on the line is a comment
//! 2                       number of blocks
//! (2, -3)                 their orders; negative for a diagonal block. Words after them are a comment
//! 10.0                    the costs c, and perhaps words
//! 0 1 1 2 -1.0            matrix (0 for F_0), block, row, column, value: of the upper triangle, numbers from 1
//! ```
//! Commas, parentheses and braces count as blanks, an entry below the diagonal as its mirror image; entries at the same
//! position are added. The numbers are read as exact decimals: as one binary64 number if it is exact, otherwise as the
//! interval between the two neighbouring binary64 numbers.
//!
//! Memory is bounded by the length of the text, independent of the declared sizes.

use std::io::BufRead;

use luenberger_proof::semidefinite::{Block, Entry, Program, ProgramError};
use luenberger_proof::{Interval, Ring};
use thiserror::Error;

/// Error of reading SDPA's sparse format. Lines are counted from 1.
#[derive(Debug, Clone, PartialEq, Error)]
#[non_exhaustive]
pub enum ReadError {
    /// The text could not be read.
    #[error("line {line}: {message}")]
    Io {
        /// The line.
        line: usize,
        /// The error of the system.
        message: String,
    },
    /// A line is longer than [`LONGEST_LINE`].
    #[error("line {line} is longer than {limit} bytes")]
    TooLong {
        /// The line.
        line: usize,
        /// The limit.
        limit: usize,
    },
    /// A line is not UTF-8.
    #[error("line {line}: byte {byte} is not UTF-8")]
    NotText {
        /// The line.
        line: usize,
        /// The first byte that is not, from 1.
        byte: usize,
    },
    /// The text ends early.
    #[error("line {line}: the text ends where {expected} is expected")]
    Truncated {
        /// The last line.
        line: usize,
        /// What is missing.
        expected: &'static str,
    },
    /// A number is expected, and something else found.
    #[error("line {line}: {found:?} stands where {expected} is expected")]
    Number {
        /// The line.
        line: usize,
        /// The expectation.
        expected: &'static str,
        /// The text found, shortened.
        found: String,
    },
    /// A number out of its range.
    #[error("line {line}: {what} is {found}; it must be between {least} and {most}")]
    Range {
        /// The line.
        line: usize,
        /// Meaning of the number.
        what: &'static str,
        /// The value found.
        found: i64,
        /// The smallest valid value.
        least: i64,
        /// The largest valid value.
        most: i64,
    },
    /// The numbers are well-formed but do not define a program.
    #[error(transparent)]
    Program(#[from] ProgramError),
}

/// Longest line that is read, in bytes.
pub const LONGEST_LINE: usize = 1 << 28;

/// The largest accepted order of a block, and number of blocks.
const LARGEST: i64 = 1 << 24;

/// Reads a program.
///
/// ```
/// let text = "1\n1\n2\n1.0\n0 1 1 2 -1.0\n1 1 1 1 1.0\n1 1 2 2 1.0\n";
/// let program = luenberger_lmi::sdpa::read(text.as_bytes())?;
/// assert_eq!(program.unknowns(), 1);
/// let error = luenberger_lmi::sdpa::read("1\n1\n2\n1.0\n0 1 1 3 -1.0\n".as_bytes()).unwrap_err();
/// assert_eq!(error.to_string(), "line 5: the column is 3; it must be between 1 and 2");
/// # Ok::<(), luenberger_lmi::sdpa::ReadError>(())
/// ```
/// # Errors
/// [`ReadError`] with line and field.
pub fn read(text: impl BufRead) -> Result<Program, ReadError> {
    let mut tokens = Tokens::new(text);
    tokens.skip_comments()?;
    let unknowns = tokens.integer("the number of unknowns", 1, LARGEST)? as usize;
    tokens.rest_is_comment();
    let count = tokens.integer("the number of blocks", 1, LARGEST)? as usize;
    tokens.rest_is_comment();
    let mut blocks = Vec::new();
    for _ in 0..count {
        let order = tokens.integer("the order of a block", -LARGEST, LARGEST)?;
        blocks.push(match order {
            0 => return Err(tokens.range("the order of a block", 0, 1, LARGEST)),
            1.. => Block::Dense(order as usize),
            _ => Block::Diagonal(order.unsigned_abs() as usize),
        });
    }
    tokens.words_are_comment();
    let mut costs = Vec::new();
    for _ in 0..unknowns {
        costs.push(tokens.decimal("a cost")?);
    }
    tokens.words_are_comment();
    let mut matrices = vec![Vec::new(); unknowns + 1];
    while tokens.more()? {
        let matrix = tokens.integer("the number of a matrix", 0, signed(unknowns))? as usize;
        let block = tokens.integer("the number of a block", 1, signed(count))? as usize - 1;
        let order = signed(blocks[block].order());
        let i = tokens.integer("the row", 1, order)? as usize - 1;
        let j = tokens.integer("the column", 1, order)? as usize - 1;
        if i != j && matches!(blocks[block], Block::Diagonal(_)) {
            return Err(tokens.range("the column in a diagonal block", signed(j) + 1, signed(i) + 1, signed(i) + 1));
        }
        let value = tokens.decimal("a value")?;
        if !value.is_zero() {
            matrices[matrix].push(Entry { block, row: i.min(j), column: i.max(j), value });
        }
    }
    for entries in &mut matrices {
        add_up(entries);
    }
    Ok(Program::new(blocks, costs, matrices)?)
}

/// Adds up the entries at one position.
fn add_up(entries: &mut Vec<Entry>) {
    entries.sort_by_key(|entry| (entry.block, entry.row, entry.column));
    entries.dedup_by(|next, kept| {
        let same = (next.block, next.row, next.column) == (kept.block, kept.row, kept.column);
        if same {
            kept.value = kept.value.add(&next.value);
        }
        same
    });
}

/// The numbers of a text, one after the other.
struct Tokens<R> {
    text: R,
    line: String,
    number: usize,
    /// Where the rest of the line begins.
    at: usize,
    ended: bool,
}

impl<R: BufRead> Tokens<R> {
    fn new(text: R) -> Self {
        Self { text, line: String::new(), number: 0, at: 0, ended: false }
    }

    fn next_line(&mut self) -> Result<(), ReadError> {
        let mut bytes = Vec::new();
        let mut limited = std::io::Read::take(&mut self.text, LONGEST_LINE as u64 + 1);
        let read = limited
            .read_until(b'\n', &mut bytes)
            .map_err(|error| ReadError::Io { line: self.number + 1, message: error.to_string() })?;
        self.at = 0;
        self.line.clear();
        if read == 0 {
            self.ended = true;
            return Ok(());
        }
        self.number += 1;
        if read > LONGEST_LINE {
            return Err(ReadError::TooLong { line: self.number, limit: LONGEST_LINE });
        }
        self.line = String::from_utf8(bytes)
            .map_err(|error| ReadError::NotText { line: self.number, byte: error.utf8_error().valid_up_to() + 1 })?;
        Ok(())
    }

    /// Goes to the first line that is not a comment.
    fn skip_comments(&mut self) -> Result<(), ReadError> {
        loop {
            self.next_line()?;
            let text = self.line.trim_start();
            if self.ended || !(text.is_empty() || text.starts_with(['"', '*'])) {
                return Ok(());
            }
        }
    }

    fn rest_is_comment(&mut self) {
        self.at = self.line.len();
    }

    /// The rest of the line is a comment unless it begins like a number: `(2, -3) = the orders`.
    fn words_are_comment(&mut self) {
        let rest = self.line[self.at..].trim_start_matches(is_blank);
        if !rest.starts_with(|c: char| c.is_ascii_digit() || matches!(c, '+' | '-' | '.')) {
            self.rest_is_comment();
        }
    }

    /// Moves to the next number; false if there is none.
    fn more(&mut self) -> Result<bool, ReadError> {
        loop {
            let rest = &self.line[self.at..];
            let trimmed = rest.trim_start_matches(is_blank);
            if !trimmed.is_empty() {
                self.at += rest.len() - trimmed.len();
                return Ok(true);
            }
            if self.ended {
                return Ok(false);
            }
            self.next_line()?;
        }
    }

    fn token(&mut self, expected: &'static str) -> Result<&str, ReadError> {
        if !self.more()? {
            return Err(ReadError::Truncated { line: self.number.max(1), expected });
        }
        let rest = &self.line[self.at..];
        let end = rest.find(is_blank).unwrap_or(rest.len());
        let token = &rest[..end];
        self.at += end;
        Ok(token)
    }

    fn range(&self, what: &'static str, found: i64, least: i64, most: i64) -> ReadError {
        ReadError::Range { line: self.number, what, found, least, most }
    }

    fn integer(&mut self, what: &'static str, least: i64, most: i64) -> Result<i64, ReadError> {
        let token = self.token(what)?;
        let found = token.parse::<i64>().map_err(|_| shorten(token));
        match found {
            Ok(found) if (least..=most).contains(&found) => Ok(found),
            Ok(found) => Err(self.range(what, found, least, most)),
            Err(found) => Err(ReadError::Number { line: self.number, expected: what, found }),
        }
    }

    fn decimal(&mut self, expected: &'static str) -> Result<Interval, ReadError> {
        let token = self.token(expected)?;
        decimal(token).map_err(|found| ReadError::Number { line: self.number, expected, found })
    }
}

fn is_blank(c: char) -> bool {
    c.is_whitespace() || matches!(c, ',' | '(' | ')' | '{' | '}' | '[' | ']')
}

/// A count, at most [`LARGEST`].
fn signed(count: usize) -> i64 {
    i64::try_from(count).unwrap_or(i64::MAX)
}

fn shorten(token: &str) -> String {
    token.chars().take(40).collect()
}

/// The enclosure of a decimal number; the token back if it is not a number, or too large for binary64.
fn decimal(token: &str) -> Result<Interval, String> {
    // Fortran writes 1.0D+00.
    let plain = token.replace(['d', 'D'], "e");
    let value: f64 = plain.parse().map_err(|_| shorten(token))?;
    let point = Interval::from_f64(value).ok_or_else(|| shorten(token))?;
    if is_exact(&plain, value) {
        return Ok(point);
    }
    Interval::new(value.next_down(), value.next_up()).ok_or_else(|| shorten(token))
}

/// Whether a decimal is known to be exactly the binary64 number nearest to it: D 10^k with |D| < 2^53 and |k| <= 22,
/// tested by one fused operation.
fn is_exact(token: &str, value: f64) -> bool {
    let (mantissa, exponent) = token.split_once(['e', 'E']).unwrap_or((token, "0"));
    let Ok(exponent) = exponent.parse::<i32>() else { return false };
    let (whole, fraction) = mantissa.split_once('.').unwrap_or((mantissa, ""));
    let fraction = fraction.trim_end_matches('0');
    let Ok(digits) = format!("{whole}{fraction}").parse::<i64>() else {
        return whole.is_empty() && fraction.is_empty();
    };
    let power = exponent.saturating_sub(i32::try_from(fraction.len()).unwrap_or(i32::MAX));
    if digits.unsigned_abs() >= 1 << 53 || power.unsigned_abs() > 22 {
        return digits == 0;
    }
    let (digits, ten) = (digits as f64, 10f64.powi(power.abs()));
    // Powers of ten up to the 22nd are binary64 numbers, and the residual of a product is one too.
    if power < 0 { value.mul_add(ten, -digits) == 0.0 } else { digits.mul_add(ten, -value) == 0.0 }
}
