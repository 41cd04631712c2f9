//! Result of a command, as text and as JSON.

use crate::exit::NEGATIVE;
use crate::output;
use serde::Serialize;
use std::process::ExitCode;

/// Result of a command.
#[derive(Debug)]
pub(crate) struct Answer {
    /// Text output: lines, each with its newline.
    text: String,
    /// JSON output: one object on one line.
    json: String,
    /// Whether the answer is negative: exit code 1.
    is_negative: bool,
    /// The exit code of a command that has printed its result itself.
    delivered: Option<ExitCode>,
}

impl Answer {
    /// A successful result. Numbers in `json` are printed with enough digits to be read back exactly; non-finite
    /// numbers are null.
    pub(crate) fn new(text: String, json: &impl Serialize) -> Result<Self, serde_json::Error> {
        Ok(Self { text, json: serde_json::to_string(json)?, is_negative: false, delivered: None })
    }

    /// A result whose JSON object is already serialized.
    pub(crate) fn written(text: String, json: String) -> Self {
        Self { text, json, is_negative: false, delivered: None }
    }

    /// A result that has been printed, with its exit code.
    pub(crate) fn delivered(code: ExitCode) -> Self {
        Self { delivered: Some(code), ..Self::written(String::new(), String::new()) }
    }

    /// The same result, marked as negative if `is_negative`.
    pub(crate) fn negative(self, is_negative: bool) -> Self {
        Self { is_negative, ..self }
    }

    /// The text output.
    pub(crate) fn text(&self) -> &str {
        &self.text
    }

    /// The JSON output.
    pub(crate) fn json(&self) -> serde_json::Value {
        serde_json::from_str(&self.json).unwrap_or_default()
    }

    /// Prints it.
    pub(crate) fn deliver(&self, json: bool) -> ExitCode {
        if let Some(code) = self.delivered {
            return code;
        }
        let printed = if json { output::line(&self.json) } else { output::text(&self.text) };
        let code = if self.is_negative { ExitCode::from(NEGATIVE) } else { ExitCode::SUCCESS };
        printed.map_or_else(|error| output::failed(&error, code), |()| code)
    }
}
