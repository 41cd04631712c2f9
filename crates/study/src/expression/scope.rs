//! The names that an expression may use.

use core::cmp::Reverse;
use std::collections::BTreeMap;

use super::error::{ExpressionErrorKind, Family};
use super::function;

/// Named numbers of a study: masses, gains, set-points.
pub type Parameters = BTreeMap<String, f64>;

/// Why something cannot be a parameter.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum ParameterError {
    /// A name that means something else already.
    #[error("`{name}` cannot be the name of a parameter: it is {meaning}")]
    Taken {
        /// The name.
        name: String,
        /// What it means.
        meaning: &'static str,
    },
    /// A name that is not a word.
    #[error("`{name}` cannot be the name of a parameter: names are letters, digits and _, and begin with a letter")]
    NotAWord {
        /// The name.
        name: String,
    },
    /// A value that is NaN or infinite.
    #[error("the parameter `{name}` is {value}, not a finite number")]
    NotFinite {
        /// The name.
        name: String,
        /// Its value.
        value: f64,
    },
}

/// What stands for a name.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Symbol {
    Time,
    /// From 0.
    State(usize),
    /// From 0.
    Input(usize),
    Pi,
    E,
    Parameter(f64),
}

/// Which columns an expression may read.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Reads {
    StatesAndInputs,
    States,
    Nothing,
}

/// The names that an expression may use: `x1..xn`, `u1..um`, `t`, `pi`, `e` and parameters.
#[derive(Clone, Debug, PartialEq)]
pub struct Scope {
    states: usize,
    inputs: usize,
    reads: Reads,
    parameters: Parameters,
}

impl Scope {
    /// The names of a right-hand side f: so many states and inputs, and the time.
    pub fn plant(states: usize, inputs: usize) -> Self {
        Self { states, inputs, reads: Reads::StatesAndInputs, parameters: Parameters::new() }
    }

    /// The names of an output h: the states and the time. What is measured does not jump with the input: `y = h(t, x)`.
    pub fn output(states: usize) -> Self {
        Self { states, inputs: 0, reads: Reads::States, parameters: Parameters::new() }
    }

    /// The names of a function of time: `t`.
    pub fn time() -> Self {
        Self { states: 0, inputs: 0, reads: Reads::Nothing, parameters: Parameters::new() }
    }

    /// The same with these parameters.
    ///
    /// ```
    /// use luenberger_study::expression::{ParameterError, Parameters, Scope};
    /// let error = Scope::plant(2, 0).with(&Parameters::from([("x2".to_owned(), 1.0)])).unwrap_err();
    /// assert_eq!(error, ParameterError::Taken { name: "x2".to_owned(), meaning: "a state" });
    /// ```
    /// # Errors
    /// [`ParameterError`] names the first that cannot be one.
    pub fn with(mut self, parameters: &Parameters) -> Result<Self, ParameterError> {
        for (name, &value) in parameters {
            let taken = |meaning| Err(ParameterError::Taken { name: name.clone(), meaning });
            if !is_word(name) {
                return Err(ParameterError::NotAWord { name: name.clone() });
            }
            match name.as_str() {
                "t" => return taken("the time"),
                "pi" => return taken("3.14159..."),
                "e" => return taken("2.71828..."),
                name if function::function(name).is_some() => return taken("a function"),
                name if numbered(name, 'x').is_some() => return taken("a state"),
                name if numbered(name, 'u').is_some() => return taken("an input"),
                _ => {}
            }
            if !value.is_finite() {
                return Err(ParameterError::NotFinite { name: name.clone(), value });
            }
        }
        self.parameters.extend(parameters.iter().map(|(name, value)| (name.clone(), *value)));
        Ok(self)
    }

    /// What the name stands for.
    pub(super) fn resolve(&self, name: &str) -> Result<Symbol, ExpressionErrorKind> {
        let unavailable = |reason| Err(ExpressionErrorKind::Unavailable { name: name.to_owned(), reason });
        let out_of_range =
            |family, count| Err(ExpressionErrorKind::OutOfRange { name: name.to_owned(), family, count });
        if let Some(value) = self.parameters.get(name) {
            return Ok(Symbol::Parameter(*value));
        }
        match (name, numbered(name, 'x'), numbered(name, 'u')) {
            ("t", ..) => Ok(Symbol::Time),
            ("pi", ..) => Ok(Symbol::Pi),
            ("e", ..) => Ok(Symbol::E),
            (_, Some(k), _) => match self.reads {
                Reads::Nothing => unavailable("this is a function of the time t alone"),
                _ if (1..=self.states).contains(&k) => Ok(Symbol::State(k - 1)),
                _ => out_of_range(Family::States, self.states),
            },
            (_, _, Some(k)) => match self.reads {
                Reads::Nothing => unavailable("this is a function of the time t alone"),
                Reads::States => unavailable("an output y = h(t, x) does not depend on the input"),
                Reads::StatesAndInputs if (1..=self.inputs).contains(&k) => Ok(Symbol::Input(k - 1)),
                Reads::StatesAndInputs => out_of_range(Family::Inputs, self.inputs),
            },
            _ => Err(ExpressionErrorKind::UnknownName {
                name: name.to_owned(),
                nearest: nearest(name, self.names().iter().map(String::as_str)),
                known: self.known(),
            }),
        }
    }

    /// Every name.
    fn names(&self) -> Vec<String> {
        let mut names: Vec<String> = self.parameters.keys().cloned().collect();
        if self.reads != Reads::Nothing {
            names.extend((1..=self.states).map(|k| format!("x{k}")));
        }
        if self.reads == Reads::StatesAndInputs {
            names.extend((1..=self.inputs).map(|k| format!("u{k}")));
        }
        names.extend(["t", "pi"].map(str::to_owned));
        names
    }

    /// Every name, in words.
    fn known(&self) -> String {
        let range = |letter: char, count: usize| match count {
            0 => None,
            1 => Some(format!("{letter}1")),
            _ => Some(format!("{letter}1 to {letter}{count}")),
        };
        let states = if self.reads == Reads::Nothing { 0 } else { self.states };
        let inputs = if self.reads == Reads::StatesAndInputs { self.inputs } else { 0 };
        let mut known: Vec<String> = range('x', states).into_iter().chain(range('u', inputs)).collect();
        known.extend(["t", "pi", "e"].map(str::to_owned));
        known.extend(self.parameters.keys().cloned());
        known.join(", ")
    }
}

/// The nearest of the known names, if one differs in a third of its letters at most, and not in all.
pub(crate) fn nearest<'k>(name: &str, known: impl Iterator<Item = &'k str>) -> Option<String> {
    let length = name.chars().count();
    known
        .map(|candidate| (strsim::damerau_levenshtein(&name.to_lowercase(), &candidate.to_lowercase()), candidate))
        .filter(|(distance, candidate)| {
            let letters = length.max(candidate.chars().count());
            *distance <= letters.div_ceil(3) && *distance < letters
        })
        // Among equals, the one that begins alike for longest.
        .min_by_key(|(distance, candidate)| {
            let alike = name.chars().zip(candidate.chars()).take_while(|(a, b)| a == b).count();
            (*distance, Reverse(alike))
        })
        .map(|(_, candidate)| candidate.to_owned())
}

/// k of a name such as x12; leading zeros make another name.
fn numbered(name: &str, letter: char) -> Option<usize> {
    let digits = name.strip_prefix(letter)?;
    let plain = digits == "0" || !digits.starts_with('0');
    if plain && !digits.is_empty() && digits.bytes().all(|b| b.is_ascii_digit()) {
        // More digits than fit are a state that does not exist.
        Some(digits.parse().unwrap_or(usize::MAX))
    } else {
        None
    }
}

pub(super) fn begins_word(c: char) -> bool {
    c.is_alphabetic() || c == '_'
}

pub(super) fn continues_word(c: char) -> bool {
    c.is_alphanumeric() || c == '_'
}

fn is_word(name: &str) -> bool {
    name.starts_with(begins_word) && name.chars().all(continues_word)
}
