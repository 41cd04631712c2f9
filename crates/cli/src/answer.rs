//! What a command found, for people and for machines.

use crate::exit::NEGATIVE;
use crate::output;
use serde::Serialize;
use std::process::ExitCode;

/// The answer of a command.
#[derive(Debug)]
pub(crate) struct Answer {
    /// For people; lines, each with its newline.
    text: String,
    /// For machines: one object on one line.
    json: String,
    /// Whether the answer is a no: exit code 1.
    is_negative: bool,
}

impl Answer {
    /// An answer that is a success. Numbers in `json` are printed so that reading them gives the same doubles; what is
    /// not finite is null.
    pub(crate) fn new(text: String, json: &impl Serialize) -> Result<Self, serde_json::Error> {
        Ok(Self { text, json: serde_json::to_string(json)?, is_negative: false })
    }

    /// An answer whose object is written already.
    pub(crate) fn written(text: String, json: String) -> Self {
        Self { text, json, is_negative: false }
    }

    /// The same answer, as a no where `is_negative`.
    pub(crate) fn negative(self, is_negative: bool) -> Self {
        Self { is_negative, ..self }
    }

    /// Prints it.
    pub(crate) fn deliver(&self, json: bool) -> ExitCode {
        if json {
            output::line(&self.json);
        } else {
            output::text(&self.text);
        }
        if self.is_negative { ExitCode::from(NEGATIVE) } else { ExitCode::SUCCESS }
    }
}
