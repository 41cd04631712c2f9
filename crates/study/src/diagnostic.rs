//! Mistakes in a file: position, expectation, and the surrounding lines.
//!
//! A [`Diagnostic`] holds a span of bytes; a [`Source`] converts it to line and column, and [`Diagnostics`] prints all
//! mistakes of a file in the order of the file:
//!
//! ```text
//! error: `pols` is not a key of an observer of the kind luenberger
//!   --> study.toml:14:1
//!    |
//! 14 | pols = [-2, -5]
//!    | ^^^^ expected one of name, kind, initial, poles, decay_rate
//!    = help: the nearest key is `poles`
//! ```

use std::fmt::{self, Write};
use std::ops::Range;
use std::sync::Arc;

use serde::Serialize;

/// A text with the name of its file.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Source {
    name: String,
    text: String,
}

/// A position in a text, counted from 1; columns are counted in characters.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
pub struct Place {
    /// The line.
    pub line: usize,
    /// The column.
    pub column: usize,
}

/// The start of the text.
impl Default for Place {
    fn default() -> Self {
        Self { line: 1, column: 1 }
    }
}

impl fmt::Display for Place {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}:{}", self.line, self.column)
    }
}

impl Source {
    /// The text `text` of the file `name`.
    pub fn new(name: impl Into<String>, text: impl Into<String>) -> Self {
        Self { name: name.into(), text: text.into() }
    }

    /// The name.
    pub fn name(&self) -> &str {
        &self.name
    }

    /// The text.
    pub fn text(&self) -> &str {
        &self.text
    }

    /// The position of the byte `offset`; the end of the text for a larger offset.
    ///
    /// ```
    /// use luenberger_study::diagnostic::{Place, Source};
    /// assert_eq!(Source::new("study.toml", "a = 1\nb = 2\n").place(8), Place { line: 2, column: 3 });
    /// ```
    pub fn place(&self, offset: usize) -> Place {
        let offset = self.boundary(offset);
        let before = &self.text[..offset];
        let start = before.rfind('\n').map_or(0, |newline| newline + 1);
        Place { line: before.matches('\n').count() + 1, column: before[start..].chars().count() + 1 }
    }

    /// The offset itself, or the start of the character that contains it.
    fn boundary(&self, offset: usize) -> usize {
        let mut offset = offset.min(self.text.len());
        while !self.text.is_char_boundary(offset) {
            offset -= 1;
        }
        offset
    }

    /// The line that contains the byte `offset`, without its end, and the offset of its start.
    fn line(&self, offset: usize) -> (usize, &str) {
        let offset = self.boundary(offset);
        let start = self.text[..offset].rfind('\n').map_or(0, |newline| newline + 1);
        let rest = &self.text[start..];
        let line = rest.split('\n').next().unwrap_or(rest);
        (start, line.strip_suffix('\r').unwrap_or(line))
    }
}

/// One mistake.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Diagnostic {
    /// The message.
    pub message: String,
    /// The span in bytes.
    pub span: Range<usize>,
    /// What was expected, printed under the excerpt.
    pub expected: String,
    /// A hint, if any.
    pub help: Option<String>,
    /// Whether it is that a required key is missing.
    pub is_absence: bool,
}

impl Diagnostic {
    /// A mistake at `span`, with the expectation.
    pub fn new(span: Range<usize>, message: impl Into<String>, expected: impl Into<String>) -> Self {
        Self { message: message.into(), span, expected: expected.into(), help: None, is_absence: false }
    }

    /// That a required key is missing.
    #[must_use]
    pub fn absence(self) -> Self {
        Self { is_absence: true, ..self }
    }

    /// The same with a hint.
    #[must_use]
    pub fn help(mut self, help: impl Into<String>) -> Self {
        self.help = Some(help.into());
        self
    }
}

/// All mistakes of one file: at least one, in the order of the file.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Diagnostics {
    source: Arc<Source>,
    list: Vec<Diagnostic>,
}

/// A mistake in machine-readable form.
#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
pub struct Located {
    /// The file.
    pub file: String,
    /// The line, from 1.
    pub line: usize,
    /// The column in characters, from 1.
    pub column: usize,
    /// What is wrong.
    pub message: String,
    /// What was expected.
    pub expected: String,
    /// A hint.
    pub help: Option<String>,
}

/// The colour sequences of a terminal.
struct Paint {
    red: &'static str,
    blue: &'static str,
    bold: &'static str,
    reset: &'static str,
}

const COLOURED: Paint = Paint { red: "\x1b[1;31m", blue: "\x1b[1;34m", bold: "\x1b[1m", reset: "\x1b[0m" };
const PLAIN: Paint = Paint { red: "", blue: "", bold: "", reset: "" };

impl Diagnostics {
    /// The mistakes `list` of `source`.
    pub fn new(source: Arc<Source>, mut list: Vec<Diagnostic>) -> Self {
        list.sort_by_key(|diagnostic| (diagnostic.span.start, diagnostic.span.end));
        list.dedup();
        Self { source, list }
    }

    /// The file.
    pub fn source(&self) -> &Source {
        &self.source
    }

    /// The mistakes.
    pub fn list(&self) -> &[Diagnostic] {
        &self.list
    }

    /// The mistakes with line and column, for machines.
    pub fn located(&self) -> Vec<Located> {
        let located = |diagnostic: &Diagnostic| {
            let Place { line, column } = self.source.place(diagnostic.span.start);
            Located {
                file: self.source.name.clone(),
                line,
                column,
                message: diagnostic.message.clone(),
                expected: diagnostic.expected.clone(),
                help: diagnostic.help.clone(),
            }
        };
        self.list.iter().map(located).collect()
    }

    /// All mistakes with their excerpts, optionally coloured by escape sequences.
    pub fn render(&self, coloured: bool) -> String {
        let paint = if coloured { COLOURED } else { PLAIN };
        let mut text: String = self.list.iter().map(|diagnostic| self.one(diagnostic, &paint)).collect();
        if self.list.len() > 1 {
            let _ = writeln!(text, "{} mistakes in {}", self.list.len(), self.source.name);
        }
        text
    }

    fn one(&self, diagnostic: &Diagnostic, paint: &Paint) -> String {
        let Paint { red, blue, bold, reset } = paint;
        let place = self.source.place(diagnostic.span.start);
        let (start, line) = self.source.line(diagnostic.span.start);
        let number = place.line.to_string();
        let margin = " ".repeat(number.len());
        let end = self.source.boundary(diagnostic.span.end.max(diagnostic.span.start)).min(start + line.len());
        let from = self.source.boundary(diagnostic.span.start).min(start + line.len());
        let marks = self.source.text[from..end.max(from)].chars().count().max(1);
        // Tabs are kept, so that the markers are aligned with the excerpt.
        let blank: String = self.source.text[start..from].chars().map(|c| if c == '\t' { '\t' } else { ' ' }).collect();
        let mut text = format!("{red}error{reset}{bold}: {}{reset}\n", diagnostic.message);
        let _ = writeln!(text, "{margin}{blue}-->{reset} {}:{place}", self.source.name);
        let _ = writeln!(text, "{margin} {blue}|{reset}\n{blue}{number} |{reset} {line}");
        let mark = "^".repeat(marks);
        let _ = writeln!(text, "{margin} {blue}|{reset} {blank}{red}{mark} {}{reset}", diagnostic.expected);
        if let Some(help) = &diagnostic.help {
            let _ = writeln!(text, "{margin} {blue}={reset} help: {help}");
        }
        text.push('\n');
        text
    }
}

impl fmt::Display for Diagnostics {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.render(false).trim_end())
    }
}

impl std::error::Error for Diagnostics {}
