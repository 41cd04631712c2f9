//! Expressions of studies, read and evaluated by a second implementation.
//!
//! A recursive descent over the grammar in the head of `luenberger-expression`, without lookup tables. Nothing here is
//! shared with that crate, so that a plant in text and the plant that the tool has made of it can be compared.

use std::collections::HashMap;

/// An expression. A condition is 1 or 0.
#[derive(Debug, Clone)]
pub(super) enum Expression {
    Number(f64),
    /// The entry of this place in the values.
    Variable(usize),
    Negative(Box<Self>),
    Binary(Operator, Box<Self>, Box<Self>),
    Call(Name, Vec<Self>),
}

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Operator {
    Or,
    And,
    Less,
    LessOrEqual,
    Greater,
    GreaterOrEqual,
    Equal,
    NotEqual,
    Plus,
    Minus,
    Times,
    Over,
    Power,
}

#[derive(Debug, Clone, Copy)]
pub(super) enum Name {
    One(fn(f64) -> f64),
    Atan2,
    Min,
    Max,
    Saturate,
    If,
}

/// `sign`, which is 0 at 0.
fn sign(x: f64) -> f64 {
    if x == 0.0 { 0.0 } else { x.signum() }
}

/// `step`, which is 1 at 0.
fn step(x: f64) -> f64 {
    if x < 0.0 { 0.0 } else { 1.0 }
}

fn not(x: f64) -> f64 {
    f64::from(u8::from(x == 0.0))
}

fn named(name: &str) -> Option<Name> {
    Some(match name {
        "sqrt" => Name::One(f64::sqrt),
        "exp" => Name::One(f64::exp),
        "ln" => Name::One(f64::ln),
        "log10" => Name::One(f64::log10),
        "sin" => Name::One(f64::sin),
        "cos" => Name::One(f64::cos),
        "tan" => Name::One(f64::tan),
        "asin" => Name::One(f64::asin),
        "acos" => Name::One(f64::acos),
        "atan" => Name::One(f64::atan),
        "sinh" => Name::One(f64::sinh),
        "cosh" => Name::One(f64::cosh),
        "tanh" => Name::One(f64::tanh),
        "asinh" => Name::One(f64::asinh),
        "acosh" => Name::One(f64::acosh),
        "atanh" => Name::One(f64::atanh),
        "abs" => Name::One(f64::abs),
        "sign" => Name::One(sign),
        "step" => Name::One(step),
        "atan2" => Name::Atan2,
        "min" => Name::Min,
        "max" => Name::Max,
        "sat" => Name::Saturate,
        "if" => Name::If,
        _ => return None,
    })
}

/// The operators with their binding powers, the longer ones first.
const OPERATORS: [(&str, Operator, u8); 13] = [
    ("||", Operator::Or, 1),
    ("&&", Operator::And, 2),
    ("<=", Operator::LessOrEqual, 3),
    (">=", Operator::GreaterOrEqual, 3),
    ("==", Operator::Equal, 3),
    ("!=", Operator::NotEqual, 3),
    ("<", Operator::Less, 3),
    (">", Operator::Greater, 3),
    ("+", Operator::Plus, 5),
    ("-", Operator::Minus, 5),
    ("*", Operator::Times, 7),
    ("/", Operator::Over, 7),
    ("^", Operator::Power, 9),
];

struct Reader<'a> {
    rest: &'a str,
    variables: &'a [String],
    constants: &'a HashMap<String, f64>,
}

impl Expression {
    /// The expression of a text; the variables are `variables`, other names have values.
    ///
    /// # Errors
    /// What is not understood.
    pub(super) fn read(text: &str, variables: &[String], constants: &HashMap<String, f64>) -> Result<Self, String> {
        let text = text.replace("**", "^");
        let mut reader = Reader { rest: &text, variables, constants };
        let expression = reader.above(0)?;
        reader.space();
        if reader.rest.is_empty() { Ok(expression) } else { Err(format!("`{}` in `{text}`", reader.rest)) }
    }

    pub(super) fn at(&self, values: &[f64]) -> f64 {
        match self {
            Self::Number(x) => *x,
            Self::Variable(k) => values[*k],
            Self::Negative(x) => -x.at(values),
            Self::Binary(operator, x, y) => {
                let (x, y) = (x.at(values), y.at(values));
                let truth = |x: bool| f64::from(u8::from(x));
                match operator {
                    Operator::Or => truth(x != 0.0 || y != 0.0),
                    Operator::And => truth(x != 0.0 && y != 0.0),
                    Operator::Less => truth(x < y),
                    Operator::LessOrEqual => truth(x <= y),
                    Operator::Greater => truth(x > y),
                    Operator::GreaterOrEqual => truth(x >= y),
                    Operator::Equal => truth(x == y),
                    Operator::NotEqual => truth(x != y),
                    Operator::Plus => x + y,
                    Operator::Minus => x - y,
                    Operator::Times => x * y,
                    Operator::Over => x / y,
                    Operator::Power => x.powf(y),
                }
            }
            Self::Call(Name::If, given) => {
                if given[0].at(values) == 0.0 {
                    given[2].at(values)
                } else {
                    given[1].at(values)
                }
            }
            Self::Call(name, given) => {
                let mut given = given.iter().map(|x| x.at(values));
                let mut next = || given.next().unwrap_or(f64::NAN);
                match name {
                    Name::One(function) => function(next()),
                    Name::Atan2 => {
                        let y = next();
                        y.atan2(next())
                    }
                    Name::Min => given.fold(f64::INFINITY, |least, x| if x < least { x } else { least }),
                    Name::Max => given.fold(f64::NEG_INFINITY, |most, x| if x > most { x } else { most }),
                    Name::Saturate => {
                        let x = next();
                        let (low, high) = (given.next().unwrap_or(-1.0), given.next().unwrap_or(1.0));
                        x.max(low).min(high)
                    }
                    Name::If => f64::NAN,
                }
            }
        }
    }

    /// The numbers in it: where it may have kinks, jumps and spikes.
    pub(super) fn numbers(&self, into: &mut Vec<f64>) {
        match self {
            Self::Number(x) => into.push(*x),
            Self::Variable(_) => {}
            Self::Negative(x) => {
                x.numbers(into);
                into.extend(into.last().map(|x| -x));
            }
            Self::Binary(_, x, y) => {
                x.numbers(into);
                y.numbers(into);
            }
            Self::Call(_, given) => given.iter().for_each(|x| x.numbers(into)),
        }
    }
}

impl Reader<'_> {
    fn space(&mut self) {
        self.rest = self.rest.trim_start();
    }

    fn takes(&mut self, text: &str) -> bool {
        self.space();
        match self.rest.strip_prefix(text) {
            Some(rest) => {
                self.rest = rest;
                true
            }
            None => false,
        }
    }

    /// An expression whose operators bind tighter than `least`.
    fn above(&mut self, least: u8) -> Result<Expression, String> {
        let mut left = if self.takes("-") {
            Expression::Negative(Box::new(self.above(8)?))
        } else if self.takes("+") {
            self.above(8)?
        } else if !self.rest.starts_with("!=") && self.takes("!") {
            Expression::Call(Name::One(not), vec![self.above(8)?])
        } else {
            self.operand()?
        };
        loop {
            self.space();
            let next = OPERATORS.iter().find(|(sign, ..)| self.rest.starts_with(sign));
            let Some((sign, operator, power)) = next.filter(|(.., power)| *power > least) else { return Ok(left) };
            self.rest = &self.rest[sign.len()..];
            // A power is read from the right, and its exponent may have a sign.
            let right = self.above(if *operator == Operator::Power { 8 } else { *power })?;
            left = Expression::Binary(*operator, Box::new(left), Box::new(right));
        }
    }

    fn operand(&mut self) -> Result<Expression, String> {
        self.space();
        if self.takes("(") {
            let inner = self.above(0)?;
            return if self.takes(")") { Ok(inner) } else { Err(format!("`)` before `{}`", self.rest)) };
        }
        let begins = self.rest.chars().next().unwrap_or(' ');
        if begins.is_ascii_digit() || begins == '.' {
            return self.number();
        }
        let word: String = self.rest.chars().take_while(|c| c.is_alphanumeric() || *c == '_').collect();
        if word.is_empty() {
            return Err(format!("an operand before `{}`", self.rest));
        }
        self.rest = &self.rest[word.len()..];
        if self.takes("(") {
            let name = named(&word).ok_or_else(|| format!("the function `{word}`"))?;
            let mut given = vec![self.above(0)?];
            while self.takes(",") {
                given.push(self.above(0)?);
            }
            return if self.takes(")") {
                Ok(Expression::Call(name, given))
            } else {
                Err(format!("`)` after `{word}`"))
            };
        }
        if let Some(place) = self.variables.iter().position(|known| *known == word) {
            return Ok(Expression::Variable(place));
        }
        match (self.constants.get(&word), word.as_str()) {
            (Some(value), _) => Ok(Expression::Number(*value)),
            (None, "pi") => Ok(Expression::Number(std::f64::consts::PI)),
            (None, "e") => Ok(Expression::Number(std::f64::consts::E)),
            _ => Err(format!("the name `{word}`")),
        }
    }

    fn number(&mut self) -> Result<Expression, String> {
        let bytes = self.rest.as_bytes();
        let digits = |from: usize| bytes[from..].iter().take_while(|byte| byte.is_ascii_digit()).count();
        let mut end = digits(0);
        if bytes.get(end) == Some(&b'.') {
            end += 1 + digits(end + 1);
        }
        if matches!(bytes.get(end), Some(b'e' | b'E')) {
            let signed = usize::from(matches!(bytes.get(end + 1), Some(b'+' | b'-')));
            let exponent = digits((end + 1 + signed).min(bytes.len()));
            if exponent > 0 {
                end += 1 + signed + exponent;
            }
        }
        let (number, rest) = self.rest.split_at(end);
        self.rest = rest;
        number.parse().map(Expression::Number).map_err(|_| format!("the number `{number}`"))
    }
}
