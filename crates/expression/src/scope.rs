//! The names in scope of an expression.

use std::collections::BTreeMap;

use crate::error::{ExpressionErrorKind, Family};
use crate::function;
use crate::nearest::nearest;
use crate::surface::{LookupTable, Tables};

/// Named parameters of a study: masses, gains, set-points.
pub type Parameters = BTreeMap<String, f64>;

/// Why a name or value is not a valid parameter.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum ParameterError {
    /// A name that is in use already.
    #[error("`{name}` cannot be the name of a parameter: it is {meaning}")]
    Taken {
        /// The name.
        name: String,
        /// Its present meaning.
        meaning: &'static str,
    },
    /// A name that is not an identifier.
    #[error("`{name}` cannot be the name of a parameter: names are letters, digits and _, and begin with a letter")]
    NotAWord {
        /// The name.
        name: String,
    },
    /// A name that a lookup table cannot have.
    #[error("`{name}` cannot be the name of a lookup table: it is {meaning}")]
    Table {
        /// The name.
        name: String,
        /// Its present meaning.
        meaning: &'static str,
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

impl ParameterError {
    /// The parameter.
    pub fn name(&self) -> &str {
        match self {
            Self::Taken { name, .. }
            | Self::NotAWord { name }
            | Self::Table { name, .. }
            | Self::NotFinite { name, .. } => name,
        }
    }
}

/// Why a name is not a valid name of a state or an input in expressions.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[error("`{name}` cannot be the name of {}: it is {meaning}", family.one())]
pub struct NameError {
    /// Whether it is a state or an input.
    pub family: Family,
    /// The index, from 0.
    pub index: usize,
    /// The name.
    pub name: String,
    /// Its present meaning.
    pub meaning: &'static str,
}

/// Why a parameter has no variable in it.
const CONSTANT: &str = "a parameter is a number: it may depend on other parameters alone";

/// The meaning of a name.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Symbol {
    Time,
    /// From 0.
    State(usize),
    /// From 0.
    Input(usize),
    Pi,
    E,
    Parameter(f64),
}

/// The variables that an expression may use.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Reads {
    StatesAndInputs,
    /// The time alone.
    Nothing,
    /// Not even the time.
    Constants,
}

/// A place among the values that an expression is evaluated with.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Variable {
    /// The state of this index, from 0.
    State(usize),
    /// The input of this index, from 0.
    Input(usize),
}

/// The names in scope of an expression: `x1..xn`, `u1..um`, `t`, `pi`, `e`, parameters, and user-supplied names of the
/// states and inputs.
#[derive(Clone, Debug, PartialEq)]
pub struct Scope {
    states: usize,
    inputs: usize,
    reads: Reads,
    parameters: Parameters,
    tables: Tables,
    /// User-supplied names, of all states or of none.
    state_names: Vec<String>,
    /// Of all inputs or of none.
    input_names: Vec<String>,
    /// The only names of variables, if there are such.
    variables: Option<Vec<(String, Variable)>>,
}

impl Scope {
    /// The names of a right-hand side f or an output h: the given numbers of states and inputs, and the time.
    pub fn plant(states: usize, inputs: usize) -> Self {
        Self::of(states, inputs, Reads::StatesAndInputs)
    }

    /// The names of a number: parameters alone. See [`derived`](crate::derived).
    pub fn constant() -> Self {
        Self::of(0, 0, Reads::Constants)
    }

    /// The names of a function of time: `t`.
    pub fn time() -> Self {
        Self::of(0, 0, Reads::Nothing)
    }

    fn of(states: usize, inputs: usize, reads: Reads) -> Self {
        let (parameters, state_names, input_names) = (Parameters::new(), Vec::new(), Vec::new());
        let (tables, variables) = (Tables::new(), None);
        Self { states, inputs, reads, parameters, tables, state_names, input_names, variables }
    }

    /// The names of a map whose variables are of several kinds, such as that of an observer: these names alone, and the
    /// time. There is no `x1` and no `u1` unless it is one of them; a variable may have several names, and of two equal
    /// names the first counts. `states` and `inputs` are the numbers of values that the expression is evaluated with.
    ///
    /// A name that is not an identifier, or has a meaning of its own (`t`, `pi`, `e`, a function), is left out.
    ///
    /// ```
    /// use luenberger_expression::{Expression, Scope, Variable};
    /// let names = [("xi1", Variable::State(0)), ("y1", Variable::Input(0)), ("speed", Variable::Input(0))];
    /// let scope = Scope::variables(1, 1, names.map(|(name, place)| (name.to_owned(), place)));
    /// assert_eq!(Expression::parse("xi1 - 2*speed + y1", &scope)?.evaluate(0.0, &[3.0], &[1.0]), 2.0);
    /// let error = Expression::parse("x1", &scope).unwrap_err();
    /// assert_eq!(error.kind().to_string(), "there is no `x1`; did you mean `xi1`?");
    /// # Ok::<(), luenberger_expression::ExpressionError>(())
    /// ```
    pub fn variables(states: usize, inputs: usize, names: impl IntoIterator<Item = (String, Variable)>) -> Self {
        let mut own: Vec<(String, Variable)> = Vec::new();
        for (name, place) in names {
            let meaning = reserved(&name).filter(|meaning| !matches!(meaning, Reserved::Numbered(..)));
            if is_word(&name) && meaning.is_none() && own.iter().all(|(other, _)| *other != name) {
                own.push((name, place));
            }
        }
        Self { variables: Some(own), ..Self::of(states, inputs, Reads::StatesAndInputs) }
    }

    /// The same with user-supplied names of the states and inputs, in their order, in addition to `x1, ..` and `u1,
    /// ..`; an empty list gives no names.
    ///
    /// A name that is not an identifier, such as `motor angle`, is used in figures and tables only, not in expressions.
    ///
    /// ```
    /// use luenberger_expression::{Expression, Scope};
    /// let names = ["angle", "speed"].map(str::to_owned);
    /// let scope = Scope::plant(2, 0).named(&names, &[])?;
    /// assert_eq!(Expression::parse("2*angle - x2", &scope)?.evaluate(0.0, &[3.0, 1.0], &[]), 5.0);
    /// let error = Expression::parse("angel", &scope).unwrap_err();
    /// assert_eq!(error.kind().to_string(), "there is no `angel`; did you mean `angle`?");
    /// let error = Scope::plant(1, 0).named(&["sin".to_owned()], &[]).unwrap_err();
    /// assert_eq!(error.to_string(), "`sin` cannot be the name of a state: it is a function");
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    /// # Errors
    /// [`NameError`] for the first name that is in use already: `t`, `pi`, `e`, a function, a parameter, another state
    /// or input. `x2` may be the name of the second state only.
    pub fn named(mut self, states: &[String], inputs: &[String]) -> Result<Self, NameError> {
        let lists = [(Family::States, states), (Family::Inputs, inputs)];
        for (family, names) in lists {
            for (index, name) in names.iter().enumerate() {
                let earlier = |names: &[String]| names.contains(name);
                let meaning = match reserved(name) {
                    Some(Reserved::Numbered(of, k)) if of == family && k == index + 1 => None,
                    Some(reserved) => Some(reserved.meaning()),
                    None if self.parameters.contains_key(name) => Some("a parameter"),
                    None if self.tables.contains_key(name) => Some("a lookup table"),
                    None if family == Family::Inputs && earlier(states) => Some("a state"),
                    None if earlier(&names[..index]) => Some(match family {
                        Family::States => "another state",
                        Family::Inputs => "another input",
                    }),
                    None => None,
                };
                if let Some(meaning) = meaning {
                    return Err(NameError { family, index, name: name.clone(), meaning });
                }
            }
        }
        (self.state_names, self.input_names) = (states.to_vec(), inputs.to_vec());
        Ok(self)
    }

    /// The same with these parameters.
    ///
    /// ```
    /// use luenberger_expression::{ParameterError, Parameters, Scope};
    /// let error = Scope::plant(2, 0).with(&Parameters::from([("x2".to_owned(), 1.0)])).unwrap_err();
    /// assert_eq!(error, ParameterError::Taken { name: "x2".to_owned(), meaning: "a state" });
    /// ```
    /// # Errors
    /// [`ParameterError`] names the first invalid one.
    pub fn with(mut self, parameters: &Parameters) -> Result<Self, ParameterError> {
        for (name, &value) in parameters {
            let taken = |meaning| Err(ParameterError::Taken { name: name.clone(), meaning });
            if !is_word(name) {
                return Err(ParameterError::NotAWord { name: name.clone() });
            }
            if let Some(meaning) = self.taken(name) {
                return taken(meaning);
            }
            if self.tables.contains_key(name) {
                return taken("a lookup table");
            }
            if !value.is_finite() {
                return Err(ParameterError::NotFinite { name: name.clone(), value });
            }
        }
        self.parameters.extend(parameters.iter().map(|(name, value)| (name.clone(), *value)));
        Ok(self)
    }

    /// The same with these lookup tables, used as functions of one argument or two.
    ///
    /// ```
    /// use luenberger_expression::{Expression, Extrapolation, Interpolation, Scope, Table, Tables};
    /// let torque = Table::new(&[0.0, 100.0], &[20.0, 0.0], Interpolation::Linear, Extrapolation::Hold)?;
    /// let scope = Scope::plant(1, 0).tables(&Tables::from([("torque".to_owned(), torque.into())]))?;
    /// assert_eq!(Expression::parse("2*torque(x1)", &scope)?.evaluate(0.0, &[25.0], &[]), 30.0);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    /// # Errors
    /// [`ParameterError`] for the first name that cannot be one.
    pub fn tables(mut self, tables: &Tables) -> Result<Self, ParameterError> {
        for name in tables.keys() {
            let word = (!is_word(name)).then_some("no word of letters, digits and _ that begins with a letter");
            let parameter = self.parameters.contains_key(name).then_some("a parameter");
            if let Some(meaning) = word.or(self.taken(name)).or(parameter) {
                return Err(ParameterError::Table { name: name.clone(), meaning });
            }
        }
        self.tables.extend(tables.iter().map(|(name, table)| (name.clone(), table.clone())));
        Ok(self)
    }

    /// The numbers of states and inputs.
    pub(crate) fn counts(&self) -> (usize, usize) {
        (self.states, self.inputs)
    }

    /// The meaning that a name has of itself, or as a state or an input.
    fn taken(&self, name: &str) -> Option<&'static str> {
        if let Some(own) = &self.variables {
            let meaning = reserved(name).filter(|meaning| !matches!(meaning, Reserved::Numbered(..)));
            let variable = own.iter().any(|(other, _)| other == name).then_some("a variable");
            return meaning.map(Reserved::meaning).or(variable);
        }
        if let Some(reserved) = reserved(name) {
            return Some(reserved.meaning());
        }
        let is_in = |names: &[String]| names.iter().any(|own| own == name);
        if is_in(&self.state_names) {
            return Some("a state");
        }
        is_in(&self.input_names).then_some("an input")
    }

    /// The lookup table of that name.
    pub(crate) fn table(&self, name: &str) -> Option<LookupTable> {
        self.tables.get(name).cloned()
    }

    /// The names of the lookup tables.
    pub(crate) fn table_names(&self) -> Vec<String> {
        self.tables.keys().cloned().collect()
    }

    /// The meaning of the name.
    pub(crate) fn resolve(&self, name: &str) -> Result<Symbol, ExpressionErrorKind> {
        let unavailable = |reason| Err(ExpressionErrorKind::Unavailable { name: name.to_owned(), reason });
        let out_of_range =
            |family, count| Err(ExpressionErrorKind::OutOfRange { name: name.to_owned(), family, count });
        if let Some(value) = self.parameters.get(name) {
            return Ok(Symbol::Parameter(*value));
        }
        if let Some(variables) = &self.variables {
            let place = variables.iter().find(|(own, _)| own == name).map(|(_, place)| *place);
            return match (name, place) {
                ("t", _) => Ok(Symbol::Time),
                ("pi", _) => Ok(Symbol::Pi),
                ("e", _) => Ok(Symbol::E),
                (_, Some(Variable::State(k))) => Ok(Symbol::State(k)),
                (_, Some(Variable::Input(k))) => Ok(Symbol::Input(k)),
                _ => Err(self.unknown(name)),
            };
        }
        let own = |names: &[String]| names.iter().position(|own| own == name).map(|k| k + 1);
        let state = own(&self.state_names).or_else(|| numbered(name, 'x'));
        let input = own(&self.input_names).or_else(|| numbered(name, 'u'));
        match (name, state, input) {
            ("t", ..) if self.reads == Reads::Constants => unavailable(CONSTANT),
            ("t", ..) => Ok(Symbol::Time),
            ("pi", ..) => Ok(Symbol::Pi),
            ("e", ..) => Ok(Symbol::E),
            (_, Some(k), _) => match self.reads {
                Reads::Constants => unavailable(CONSTANT),
                Reads::Nothing => unavailable("this is a function of the time t alone"),
                _ if (1..=self.states).contains(&k) => Ok(Symbol::State(k - 1)),
                Reads::StatesAndInputs => out_of_range(Family::States, self.states),
            },
            (_, _, Some(k)) => match self.reads {
                Reads::Constants => unavailable(CONSTANT),
                Reads::Nothing => unavailable("this is a function of the time t alone"),
                Reads::StatesAndInputs if (1..=self.inputs).contains(&k) => Ok(Symbol::Input(k - 1)),
                Reads::StatesAndInputs => out_of_range(Family::Inputs, self.inputs),
            },
            _ => Err(self.unknown(name)),
        }
    }

    fn unknown(&self, name: &str) -> ExpressionErrorKind {
        ExpressionErrorKind::UnknownName {
            name: name.to_owned(),
            nearest: nearest(name, self.names().iter().map(String::as_str)).map(str::to_owned),
            known: self.known(),
        }
    }

    /// Every name.
    fn names(&self) -> Vec<String> {
        let mut names: Vec<String> = self.parameters.keys().cloned().collect();
        if let Some(own) = &self.variables {
            names.extend(own.iter().map(|(name, _)| name.clone()).chain(["t", "pi"].map(str::to_owned)));
            return names;
        }
        if self.reads == Reads::StatesAndInputs {
            names.extend((1..=self.states).map(|k| format!("x{k}")));
            names.extend(self.state_names.iter().filter(|name| is_word(name)).cloned());
        }
        if self.reads == Reads::StatesAndInputs {
            names.extend((1..=self.inputs).map(|k| format!("u{k}")));
            names.extend(self.input_names.iter().filter(|name| is_word(name)).cloned());
        }
        let time = (self.reads != Reads::Constants).then_some("t");
        names.extend(time.into_iter().chain(["pi"]).map(str::to_owned));
        names
    }

    /// Every name, as text.
    fn known(&self) -> String {
        if let Some(own) = &self.variables {
            let constants = ["t", "pi", "e"].map(str::to_owned).into_iter().chain(self.parameters.keys().cloned());
            return own.iter().map(|(name, _)| name.clone()).chain(constants).collect::<Vec<_>>().join(", ");
        }
        let range = |letter: char, count: usize| match count {
            0 => None,
            1 => Some(format!("{letter}1")),
            _ => Some(format!("{letter}1 to {letter}{count}")),
        };
        let states = if self.reads == Reads::StatesAndInputs { self.states } else { 0 };
        let inputs = if self.reads == Reads::StatesAndInputs { self.inputs } else { 0 };
        let own = |names: &[String], count: usize, letter: char| match names {
            // A name that is x1 already is said once.
            _ if count == 0 => Vec::new(),
            names => names
                .iter()
                .enumerate()
                .filter(|(k, name)| is_word(name) && **name != format!("{letter}{}", k + 1))
                .map(|(_, name)| name.clone())
                .collect(),
        };
        let mut known = own(&self.state_names, states, 'x');
        known.extend(own(&self.input_names, inputs, 'u'));
        known.extend(range('x', states).into_iter().chain(range('u', inputs)));
        let time = (self.reads != Reads::Constants).then_some("t");
        known.extend(time.into_iter().chain(["pi", "e"]).map(str::to_owned));
        known.extend(self.parameters.keys().cloned());
        known.join(", ")
    }
}

/// The meaning of a name common to all expressions.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Reserved {
    Time,
    Pi,
    E,
    Function,
    /// `x2`, `u1`: from 1.
    Numbered(Family, usize),
}

impl Reserved {
    fn meaning(self) -> &'static str {
        match self {
            Self::Time => "the time",
            Self::Pi => "3.14159...",
            Self::E => "2.71828...",
            Self::Function => "a function",
            Self::Numbered(family, _) => family.one(),
        }
    }
}

fn reserved(name: &str) -> Option<Reserved> {
    match name {
        "t" => Some(Reserved::Time),
        "pi" => Some(Reserved::Pi),
        "e" => Some(Reserved::E),
        name if function::function(name).is_some() => Some(Reserved::Function),
        name => {
            let state = numbered(name, 'x').map(|k| Reserved::Numbered(Family::States, k));
            state.or_else(|| numbered(name, 'u').map(|k| Reserved::Numbered(Family::Inputs, k)))
        }
    }
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

pub(crate) fn begins_word(c: char) -> bool {
    c.is_alphabetic() || c == '_'
}

pub(crate) fn continues_word(c: char) -> bool {
    c.is_alphanumeric() || c == '_'
}

fn is_word(name: &str) -> bool {
    name.starts_with(begins_word) && name.chars().all(continues_word)
}
