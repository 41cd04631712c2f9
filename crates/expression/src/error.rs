//! Errors in the text of an expression, with positions.

use core::fmt;
use core::ops::Range;

use crate::LIMITS;

/// Error of an expression, with its position in the text.
///
/// ```
/// use luenberger_expression::{Expression, Scope};
/// let error = Expression::parse("x1 * sinn(x2)", &Scope::plant(2, 0)).unwrap_err();
/// assert_eq!(error.to_string(), "line 1, column 6: there is no function `sinn`; did you mean `sin`?");
/// assert_eq!(error.pointer(), "x1 * sinn(x2)\n     ^^^^");
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct ExpressionError {
    text: Box<str>,
    span: Range<usize>,
    kind: Box<ExpressionErrorKind>,
}

impl ExpressionError {
    pub(crate) fn new(text: &str, span: Range<usize>, kind: ExpressionErrorKind) -> Self {
        Self { text: text.into(), span, kind: Box::new(kind) }
    }

    /// The kind of the error.
    pub fn kind(&self) -> &ExpressionErrorKind {
        &self.kind
    }

    /// The span in bytes; empty at the end of the text.
    pub fn span(&self) -> Range<usize> {
        self.span.clone()
    }

    /// The text of the expression.
    pub fn text(&self) -> &str {
        &self.text
    }

    /// The line, from 1.
    pub fn line(&self) -> usize {
        self.before().matches('\n').count() + 1
    }

    /// The column, in characters from 1.
    pub fn column(&self) -> usize {
        self.before().chars().rev().take_while(|&c| c != '\n').count() + 1
    }

    /// The line of the text with markers below the span.
    pub fn pointer(&self) -> String {
        let line = self.text.lines().nth(self.line() - 1).unwrap_or("");
        let meant = self.text.get(self.span.clone()).unwrap_or("").lines().next().unwrap_or("").chars().count();
        format!("{line}\n{}{}", " ".repeat(self.column() - 1), "^".repeat(meant.max(1)))
    }

    fn before(&self) -> &str {
        self.text.get(..self.span.start).unwrap_or(&self.text)
    }
}

impl fmt::Display for ExpressionError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "line {}, column {}: {}", self.line(), self.column(), self.kind)
    }
}

impl std::error::Error for ExpressionError {}

/// The token found instead of the expected one.
#[derive(Clone, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum Found {
    /// The text ends.
    End,
    /// A word, a number or a character.
    Text(String),
}

impl fmt::Display for Found {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::End => f.write_str("the end of the expression"),
            Self::Text(text) => write!(f, "`{text}`"),
        }
    }
}

/// The variables with numbered names.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Family {
    /// x1, x2, ...
    States,
    /// u1, u2, ...
    Inputs,
}

/// Kinds of errors of an expression.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum ExpressionErrorKind {
    /// An empty text.
    #[error("the expression is empty: expected {expected}")]
    Empty {
        /// What an expression begins with.
        expected: &'static str,
    },
    /// An unexpected token.
    #[error("expected {expected}, found {found}")]
    Unexpected {
        /// The expectation.
        expected: &'static str,
        /// The token found.
        found: Found,
    },
    /// A number that is not representable in binary64.
    #[error("the number {text} is too large: the largest is 1.8e308")]
    Number {
        /// As it is written.
        text: String,
    },
    /// An unknown name.
    #[error("there is no `{name}`; {}", advice(nearest.as_ref(), known))]
    UnknownName {
        /// The name.
        name: String,
        /// The nearest known name, if one is close.
        nearest: Option<String>,
        /// The known names.
        known: String,
    },
    /// A state or an input that does not exist.
    #[error("there is no `{name}`: {}", numbered(*family, *count))]
    OutOfRange {
        /// The name.
        name: String,
        /// Whether it is a state or an input.
        family: Family,
        /// The existing number.
        count: usize,
    },
    /// A known name that is not allowed here.
    #[error("`{name}` may not be used here: {reason}")]
    Unavailable {
        /// The name.
        name: String,
        /// The reason.
        reason: &'static str,
    },
    /// An unknown function.
    #[error("there is no function `{name}`; {}", advice(nearest.as_ref(), known))]
    UnknownFunction {
        /// The name.
        name: String,
        /// The nearest known name, if one is close.
        nearest: Option<String>,
        /// The known functions.
        known: String,
    },
    /// The name of a number with arguments.
    #[error("`{name}` is not a function; write `{name}*(...)` for a product")]
    NotAFunction {
        /// The name.
        name: String,
    },
    /// A function without arguments.
    #[error("`{name}` is a function: write `{name}(...)`")]
    WithoutArguments {
        /// The name.
        name: String,
    },
    /// A wrong number of arguments.
    #[error("`{function}` takes {expected}, and has {found}")]
    Arguments {
        /// The function.
        function: &'static str,
        /// The required number, as text.
        expected: &'static str,
        /// The actual number.
        found: usize,
    },
    /// A lookup table with another number of arguments than it has variables.
    #[error("`{table}` is a lookup table and takes {}", if *arguments == 1 { "one argument" } else { "two arguments" })]
    TableArguments {
        /// Its name.
        table: String,
        /// How many it takes.
        arguments: usize,
    },
    /// A condition where a number is needed.
    #[error("`{part}` is a condition and not a number: write `if({part}, 1, 0)` for a number")]
    NotANumber {
        /// The condition, as it is written.
        part: String,
    },
    /// A number where a condition is needed.
    #[error("`{part}` is a number and not a condition, such as `x1 > 0`")]
    NotACondition {
        /// The number, as it is written.
        part: String,
    },
    /// Something else where one inequality is needed.
    #[error("`{part}` is no inequality between two numbers, such as `x1^2 + x2^2 <= 4`")]
    NotAnInequality {
        /// As it is written.
        part: String,
    },
    /// A text longer than the limit.
    #[error("the expression has {length} bytes; at most {longest} are read")]
    TooLong {
        /// Its length in bytes.
        length: usize,
        /// The limit.
        longest: usize,
    },
    /// Parentheses, powers, signs or pending operations within each other beyond the bound.
    #[error("the expression is nested too deeply: more than {} operations wait for their operands", LIMITS.depth)]
    TooDeep,
}

impl Family {
    /// One of them.
    pub(crate) fn one(self) -> &'static str {
        match self {
            Self::States => "a state",
            Self::Inputs => "an input",
        }
    }
}

fn advice(nearest: Option<&String>, known: &str) -> String {
    nearest.map_or_else(|| format!("known are {known}"), |nearest| format!("did you mean `{nearest}`?"))
}

fn numbered(family: Family, count: usize) -> String {
    let (letter, one, many) = match family {
        Family::States => ('x', "state", "states"),
        Family::Inputs => ('u', "input", "inputs"),
    };
    match count {
        0 => format!("there are no {many}"),
        1 => format!("there is one {one}, {letter}1"),
        _ => format!("there are {count} {many}, {letter}1 to {letter}{count}"),
    }
}
