//! Input of a command, from a file or standard input, as text.

pub(crate) mod given;
pub(crate) mod json;
mod json_matrix;

use crate::failure::Failure;
use std::convert::Infallible;
use std::fmt;
use std::fs::File;
use std::io::{self, Read};
use std::path::PathBuf;
use std::str::FromStr;

/// Maximal length of the input in bytes: enough for a dense matrix of order 3000 with all digits.
const LONGEST: u64 = 256 << 20;

/// A file, or standard input.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) enum Source {
    Standard,
    File(PathBuf),
}

impl FromStr for Source {
    type Err = Infallible;

    fn from_str(word: &str) -> Result<Self, Infallible> {
        Ok(if word == "-" { Self::Standard } else { Self::File(word.into()) })
    }
}

impl fmt::Display for Source {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Standard => write!(f, "standard input"),
            Self::File(path) => write!(f, "{}", path.display()),
        }
    }
}

impl Source {
    /// The whole input as text, without a byte order mark.
    pub(crate) fn text(&self) -> Result<String, Failure> {
        let bytes = self.bytes(LONGEST)?;
        let text = String::from_utf8(bytes).map_err(|error| {
            let byte = error.utf8_error().valid_up_to();
            let before = &error.as_bytes()[..byte];
            let line_start = before.iter().rposition(|b| *b == b'\n').map_or(0, |at| at + 1);
            Failure::NotText {
                origin: self.to_string(),
                line: before.split(|b| *b == b'\n').count(),
                column: byte - line_start + 1,
                byte: byte + 1,
                found: error.as_bytes().get(byte).copied().unwrap_or_default(),
            }
        })?;
        Ok(match text.strip_prefix('\u{feff}') {
            Some(rest) => rest.to_owned(),
            None => text,
        })
    }

    /// The whole input, if it is not longer than `limit`.
    pub(crate) fn bytes(&self, limit: u64) -> Result<Vec<u8>, Failure> {
        let unreadable = |error| Failure::Read { origin: self.to_string(), error };
        let mut bytes = Vec::new();
        let read = match self {
            Self::Standard => io::stdin().lock().take(limit + 1).read_to_end(&mut bytes),
            Self::File(path) => File::open(path).and_then(|file| file.take(limit + 1).read_to_end(&mut bytes)),
        };
        if read.map_err(unreadable)? as u64 > limit {
            return Err(Failure::TooLong { origin: self.to_string(), limit });
        }
        Ok(bytes)
    }
}
