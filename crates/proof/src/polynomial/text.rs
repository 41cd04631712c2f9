//! Expressions as text: `x2^3 - 0.5*sin(x1)/(1 + u1)`.
//!
//! ```text
//! sum     = product { ("+" | "-") product }
//! product = factor { ("*" | "/") factor }
//! factor  = "-" factor | base [ "^" [ "-" ] digits ]
//! base    = number | variable | function "(" sum ")" | "(" sum ")"
//! number  = digits [ "." digits ] | hexadecimal float
//! ```
//! Numbers must be exact binary64 numbers. Exponents are at most 64. Spaces are allowed between tokens.

use dashu_int::{IBig, UBig};
use thiserror::Error;

use super::{Arena, Computed, Function, Polynomial, Rational};
use crate::number::Number;

/// Maximum length of an expression, in characters.
pub const LONGEST_EXPRESSION: usize = 16_384;

/// Maximum nesting of an expression.
pub const DEEPEST_EXPRESSION: usize = 48;

const LARGEST_EXPONENT: u32 = 64;

/// Why a text is not an expression of a certificate.
#[derive(Debug, Clone, PartialEq, Eq, Error)]
#[non_exhaustive]
pub enum ExpressionError {
    /// Too many characters.
    #[error("an expression of {length} characters; at most {LONGEST_EXPRESSION} are allowed")]
    TooLong {
        /// The number of characters.
        length: usize,
    },
    /// Too many levels of parentheses, functions and signs.
    #[error("an expression that is nested deeper than {DEEPEST_EXPRESSION}")]
    TooDeep,
    /// Another token is required at a position.
    #[error("at character {position} of the expression {expected} should be")]
    Expected {
        /// The position, from 1.
        position: usize,
        /// What should be there.
        expected: &'static str,
    },
    /// A name that is neither a variable nor a function here.
    #[error("{name} is no variable or function here; the variables are {known}")]
    UnknownName {
        /// The name found.
        name: String,
        /// The variables that are defined.
        known: String,
    },
    /// A decimal number that is not exactly a binary64 number.
    #[error("the number {number} is not one of binary64; write the quotient or the hexadecimal float that is meant")]
    NotBinary64 {
        /// The number.
        number: String,
    },
    /// An exponent that is not an integer within the limit.
    #[error("the exponent {exponent}: powers are integers, of magnitude {LARGEST_EXPONENT} at most")]
    Exponent {
        /// The exponent.
        exponent: String,
    },
}

/// A variable of an expression: the name of its vector, and its index from 0.
pub(crate) type Variable = (&'static str, usize);

/// An expression.
#[derive(Debug, Clone, PartialEq)]
pub(crate) enum Tree {
    Number(Rational),
    Variable(Variable),
    Negative(Box<Tree>),
    Sum(Box<Tree>, Box<Tree>),
    Difference(Box<Tree>, Box<Tree>),
    Product(Box<Tree>, Box<Tree>),
    Quotient(Box<Tree>, Box<Tree>),
    Power(Box<Tree>, i32),
    Function(Function, Box<Tree>),
}

/// The defined variables: name and length of each vector.
pub(crate) type Names = [(&'static str, usize)];

/// The values of the variables: name and entries of each vector.
pub(crate) type Scope<'a> = [(&'static str, &'a [Polynomial])];

struct Reader<'a> {
    text: &'a [u8],
    at: usize,
    depth: usize,
    names: &'a Names,
}

type Read<T> = Result<T, ExpressionError>;

impl Tree {
    pub(crate) fn parse(text: &str, names: &Names) -> Read<Self> {
        if text.len() > LONGEST_EXPRESSION {
            return Err(ExpressionError::TooLong { length: text.len() });
        }
        let mut reader = Reader { text: text.as_bytes(), at: 0, depth: 0, names };
        let tree = reader.sum()?;
        if reader.peek().is_some() {
            return Err(reader.expected("an operator or the end"));
        }
        Ok(tree)
    }

    /// The polynomial, with the variables replaced by those of the scope. A sum of many terms is a tree that is deep on
    /// the left; that side is traversed in a loop, without recursion.
    pub(crate) fn value(&self, arena: &mut Arena, scope: &Scope<'_>) -> Computed {
        let mut rest = Vec::new();
        let mut first = self;
        while let Self::Sum(left, _) | Self::Difference(left, _) | Self::Product(left, _) | Self::Quotient(left, _) =
            first
        {
            rest.push(first);
            first = left;
        }
        let mut value = match first {
            Self::Number(x) => Polynomial::constant(x.clone()),
            Self::Variable((letter, k)) => {
                let values = scope.iter().find(|(name, _)| name == letter).map(|(_, values)| *values);
                values.and_then(|values| values.get(*k)).cloned().unwrap_or_default()
            }
            Self::Negative(inner) => inner.value(arena, scope)?.negative(),
            Self::Power(base, n) => {
                let base = if *n < 0 { base.reciprocal(arena, scope)? } else { base.value(arena, scope)? };
                arena.power(&base, n.unsigned_abs())?
            }
            Self::Function(function, argument) => {
                let argument = argument.value(arena, scope)?;
                arena.function(*function, argument)?
            }
            _ => Polynomial::zero(),
        };
        for tree in rest.into_iter().rev() {
            value = match tree {
                Self::Sum(_, right) => value.plus(&right.value(arena, scope)?),
                Self::Difference(_, right) => value.minus(&right.value(arena, scope)?),
                Self::Product(_, right) => {
                    let right = right.value(arena, scope)?;
                    arena.product(&value, &right)?
                }
                Self::Quotient(_, right) => {
                    let inverse = right.reciprocal(arena, scope)?;
                    arena.product(&value, &inverse)?
                }
                _ => value,
            };
        }
        Ok(value)
    }

    /// The reciprocal, factor by factor, so that `1/(a^2 b)` has the atoms 1/a and 1/b.
    fn reciprocal(&self, arena: &mut Arena, scope: &Scope<'_>) -> Computed {
        match self {
            Self::Power(base, n) if *n > 0 => {
                let inverse = base.reciprocal(arena, scope)?;
                arena.power(&inverse, n.unsigned_abs())
            }
            Self::Product(left, right) => {
                let (left, right) = (left.reciprocal(arena, scope)?, right.reciprocal(arena, scope)?);
                arena.product(&left, &right)
            }
            Self::Negative(inner) => Ok(inner.reciprocal(arena, scope)?.negative()),
            _ => {
                let value = self.value(arena, scope)?;
                arena.reciprocal(&value)
            }
        }
    }
}

impl Reader<'_> {
    fn peek(&mut self) -> Option<u8> {
        while self.text.get(self.at) == Some(&b' ') {
            self.at += 1;
        }
        self.text.get(self.at).copied()
    }

    fn accepts(&mut self, byte: u8) -> bool {
        let found = self.peek() == Some(byte);
        self.at += usize::from(found);
        found
    }

    fn expected(&self, expected: &'static str) -> ExpressionError {
        ExpressionError::Expected { position: self.at + 1, expected }
    }

    fn nested<T>(&mut self, read: impl FnOnce(&mut Self) -> Read<T>) -> Read<T> {
        if self.depth >= DEEPEST_EXPRESSION {
            return Err(ExpressionError::TooDeep);
        }
        self.depth += 1;
        let found = read(self);
        self.depth -= 1;
        found
    }

    fn sum(&mut self) -> Read<Tree> {
        let mut tree = self.product()?;
        loop {
            if self.accepts(b'+') {
                tree = Tree::Sum(Box::new(tree), Box::new(self.product()?));
            } else if self.accepts(b'-') {
                tree = Tree::Difference(Box::new(tree), Box::new(self.product()?));
            } else {
                return Ok(tree);
            }
        }
    }

    fn product(&mut self) -> Read<Tree> {
        let mut tree = self.factor()?;
        loop {
            if self.accepts(b'*') {
                tree = Tree::Product(Box::new(tree), Box::new(self.factor()?));
            } else if self.accepts(b'/') {
                tree = Tree::Quotient(Box::new(tree), Box::new(self.factor()?));
            } else {
                return Ok(tree);
            }
        }
    }

    fn factor(&mut self) -> Read<Tree> {
        if self.accepts(b'-') {
            return Ok(Tree::Negative(Box::new(self.nested(Self::factor)?)));
        }
        let base = self.base()?;
        if !self.accepts(b'^') {
            return Ok(base);
        }
        let is_negative = self.accepts(b'-');
        self.peek();
        let digits = self.run(u8::is_ascii_digit).to_owned();
        if digits.is_empty() {
            return Err(self.expected("an integer exponent"));
        }
        match digits.parse::<u32>() {
            Ok(n) if n <= LARGEST_EXPONENT => {
                let n = n.cast_signed();
                Ok(Tree::Power(Box::new(base), if is_negative { -n } else { n }))
            }
            _ => Err(ExpressionError::Exponent { exponent: digits.chars().take(20).collect() }),
        }
    }

    fn base(&mut self) -> Read<Tree> {
        match self.peek() {
            Some(b'(') => {
                self.at += 1;
                let inner = self.nested(Self::sum)?;
                if self.accepts(b')') { Ok(inner) } else { Err(self.expected("an operator or a closing parenthesis")) }
            }
            Some(byte) if byte.is_ascii_digit() => self.number(),
            Some(byte) if byte.is_ascii_lowercase() => self.name(),
            _ => Err(self.expected("a number, a variable, a function or a parenthesis")),
        }
    }

    fn run(&mut self, accepts: impl Fn(&u8) -> bool) -> &str {
        let start = self.at;
        while self.text.get(self.at).is_some_and(&accepts) {
            self.at += 1;
        }
        core::str::from_utf8(&self.text[start..self.at]).unwrap_or_default()
    }

    fn name(&mut self) -> Read<Tree> {
        let name = self.run(u8::is_ascii_alphanumeric).to_owned();
        if let Some((_, function)) = Function::NAMES.iter().find(|(known, _)| *known == name) {
            if !self.accepts(b'(') {
                return Err(self.expected("an opening parenthesis"));
            }
            let argument = self.nested(Self::sum)?;
            if !self.accepts(b')') {
                return Err(self.expected("an operator or a closing parenthesis"));
            }
            return Ok(Tree::Function(*function, Box::new(argument)));
        }
        for &(letter, count) in self.names {
            let index = name.strip_prefix(letter).and_then(|digits| digits.parse::<usize>().ok());
            if let Some(k) = index
                && (1..=count).contains(&k)
                && name == format!("{letter}{k}")
            {
                return Ok(Tree::Variable((letter, k - 1)));
            }
        }
        let known = |&(letter, count): &(&str, usize)| match count {
            0 => None,
            1 => Some(format!("{letter}1")),
            _ => Some(format!("{letter}1 to {letter}{count}")),
        };
        let known: Vec<_> = self.names.iter().filter_map(known).collect();
        Err(ExpressionError::UnknownName { name: name.chars().take(40).collect(), known: known.join(", ") })
    }

    fn number(&mut self) -> Read<Tree> {
        let start = self.at;
        if self.text[self.at..].starts_with(b"0x") {
            self.at += 2;
            self.run(|byte| byte.is_ascii_hexdigit() || *byte == b'.');
            if self.text.get(self.at) == Some(&b'p') {
                self.at += 1;
                if matches!(self.text.get(self.at), Some(b'+' | b'-')) {
                    self.at += 1;
                }
                self.run(u8::is_ascii_digit);
            }
        } else {
            self.run(u8::is_ascii_digit);
            if self.text.get(self.at) == Some(&b'.') {
                self.at += 1;
                if self.run(u8::is_ascii_digit).is_empty() {
                    return Err(self.expected("a digit"));
                }
            }
        }
        let text = core::str::from_utf8(&self.text[start..self.at]).unwrap_or_default();
        let number = exact(text).filter(|number| number.to_f64().is_some());
        let value = number.as_ref().and_then(Number::exact).map(Rational::from);
        let refused = || ExpressionError::NotBinary64 { number: text.chars().take(40).collect() };
        value.map(Tree::Number).ok_or_else(refused)
    }
}

/// Exact value of a decimal without an exponent, or of a hexadecimal float.
fn exact(text: &str) -> Option<Number> {
    if text.starts_with("0x") {
        return text.parse().ok();
    }
    let (whole, part) = text.split_once('.').unwrap_or((text, ""));
    let digits = UBig::from_str_radix(&[whole, part].concat(), 10).ok()?;
    Some(Number::fraction(IBig::from(digits), UBig::from(10_u8).pow(part.len())))
}
