//! The text of labels, as formulas.

use super::{Names, Value, relation, sense};
use crate::definite::Sense;
use crate::error::ProofError;

/// An expression. Equal expressions are equal formulas, so that `X + X'` is found by comparison.
#[derive(Debug, Clone, PartialEq)]
pub(super) enum Formula {
    /// By its place among the names.
    Name(usize),
    /// A whole number, or one half.
    Number(f64),
    Identity,
    /// Each term with whether it is subtracted.
    Sum(Vec<(bool, Formula)>),
    Product(Vec<Formula>),
    Transpose(Box<Formula>),
    Square(Box<Formula>),
    /// `X + X'`.
    He(Box<Formula>),
    Trace(Box<Formula>),
    /// The diagonal matrix of a list.
    Diagonal(Box<Formula>),
    /// Rows of blocks; `None` is the transpose of the block opposite.
    Blocks(Vec<Vec<Option<Formula>>>),
}

impl Formula {
    /// Its factors; itself where it is no product.
    pub(super) fn factors(&self) -> &[Self] {
        match self {
            Self::Product(factors) => factors,
            one => std::slice::from_ref(one),
        }
    }

    fn product(mut factors: Vec<Self>) -> Option<Self> {
        if factors.len() > 1 { Some(Self::Product(factors)) } else { factors.pop() }
    }

    /// Its parts.
    fn parts(&self) -> Vec<&Self> {
        match self {
            Self::Name(_) | Self::Number(_) | Self::Identity => Vec::new(),
            Self::Sum(terms) => terms.iter().map(|(_, term)| term).collect(),
            Self::Product(factors) => factors.iter().collect(),
            Self::Transpose(x) | Self::Square(x) | Self::He(x) | Self::Trace(x) | Self::Diagonal(x) => vec![x],
            Self::Blocks(rows) => rows.iter().flatten().flatten().collect(),
        }
    }

    /// Whether the name at this place is in it.
    pub(super) fn uses(&self, name: usize) -> bool {
        *self == Self::Name(name) || self.parts().into_iter().any(|part| part.uses(name))
    }
}

/// The difference of the sides of an inequality, and the sense in which it is definite.
pub(super) fn inequality(label: &str, names: &Names<'_>) -> Result<(Formula, Sense), ProofError> {
    let mut reader = Reader { rest: label, names };
    let parsed = reader.inequality();
    parsed.ok_or_else(|| ProofError::Label { label: label.to_owned() })
}

pub(super) fn expression(text: &str, names: &Names<'_>) -> Result<Formula, ProofError> {
    let mut reader = Reader { rest: text, names };
    let parsed = reader.sum().filter(|_| reader.rest.is_empty());
    parsed.ok_or_else(|| ProofError::Label { label: text.to_owned() })
}

struct Reader<'t, 'n> {
    rest: &'t str,
    names: &'n Names<'n>,
}

impl Reader<'_, '_> {
    fn eat(&mut self, text: &str) -> bool {
        let found = self.rest.strip_prefix(text);
        self.rest = found.unwrap_or(self.rest);
        found.is_some()
    }

    fn inequality(&mut self) -> Option<(Formula, Sense)> {
        let left = self.sum()?;
        let rest = self.rest.strip_prefix(' ')?;
        let (word, rest) = rest.split_once(' ')?;
        let (smaller, strict) = relation(word)?;
        self.rest = rest;
        let right = self.sum()?;
        if self.eat(" for ") {
            let definition = self.defined()?;
            if !self.eat(" = ") || self.sum()? != definition {
                return None;
            }
        }
        let is_number = |text: &str| text.strip_suffix(')').is_some_and(|text| !text.contains([' ', '(', ')']));
        if !self.rest.is_empty() && !self.rest.strip_prefix(" (").is_some_and(is_number) {
            return None;
        }
        if right == Formula::Number(0.0) {
            return Some((left, sense((smaller, strict))));
        }
        let (more, less) = if smaller { (right, left) } else { (left, right) };
        Some((Formula::Sum(vec![(false, more), (true, less)]), sense((false, strict))))
    }

    fn sum(&mut self) -> Option<Formula> {
        let mut terms = vec![(self.eat("-"), self.product()?)];
        loop {
            let is_subtracted = if self.eat(" + ") {
                false
            } else if self.eat(" - ") {
                true
            } else {
                break;
            };
            terms.push((is_subtracted, self.product()?));
        }
        Some(match terms.as_slice() {
            [(false, one)] => one.clone(),
            _ => Formula::Sum(terms),
        })
    }

    fn product(&mut self) -> Option<Formula> {
        let mut factors = Vec::new();
        loop {
            if self.eat("/2") {
                factors.push(Formula::Number(0.5));
                continue;
            }
            // Factors stand beside each other, with a space or without; before a sign a space ends the product.
            let rest = self.rest.strip_prefix(' ').unwrap_or(self.rest);
            let has_factor = rest.starts_with(|c: char| c.is_alphanumeric() || matches!(c, '(' | '['));
            if !has_factor || self.rest.starts_with(" for ") || self.at_reference() {
                break;
            }
            self.rest = if factors.is_empty() { self.rest } else { rest };
            factors.push(self.factor()?);
        }
        // Brackets around a product do not matter where nothing is done to it.
        let flat = factors.into_iter().flat_map(|factor| match factor {
            Formula::Product(inner) => inner,
            one => vec![one],
        });
        Formula::product(flat.collect())
    }

    /// Whether the number of an equation is what is left.
    fn at_reference(&self) -> bool {
        self.rest.strip_prefix(" (").is_some_and(|rest| rest.starts_with(|c: char| c.is_ascii_digit()))
            && self.rest.ends_with(')')
            && self.rest.matches(')').count() == 1
    }

    fn factor(&mut self) -> Option<Formula> {
        let mut factor = self.atom()?;
        loop {
            factor = if self.eat("'") {
                Formula::Transpose(Box::new(factor))
            } else if self.eat("^2") {
                Formula::Square(Box::new(factor))
            } else {
                return Some(factor);
            };
        }
    }

    /// The longest name that fits.
    fn name(&mut self) -> Option<usize> {
        let names = self.names.names.iter().enumerate().filter(|(_, named)| self.rest.starts_with(named.name));
        let (place, named) = names.max_by_key(|(_, named)| named.name.len())?;
        self.eat(named.name);
        Some(place)
    }

    /// The expression that a name is defined as.
    fn defined(&mut self) -> Option<Formula> {
        match &self.names.names[self.name()?].value {
            Value::Definition(formula) => Some(formula.clone()),
            _ => None,
        }
    }

    fn atom(&mut self) -> Option<Formula> {
        for (open, of) in [
            ("He(", (|x| Formula::He(Box::new(x))) as fn(Formula) -> Formula),
            ("diag(", |x| Formula::Diagonal(Box::new(x))),
            ("(", |x| x),
        ] {
            if self.eat(open) {
                let inner = self.sum()?;
                return self.eat(")").then(|| of(inner));
            }
        }
        if self.eat("tr ") {
            return Some(Formula::Trace(Box::new(self.product()?)));
        }
        if let Some(place) = self.name() {
            return Some(match &self.names.names[place].value {
                Value::Definition(formula) => formula.clone(),
                _ => Formula::Name(place),
            });
        }
        if self.eat("[") {
            return self.blocks();
        }
        if self.eat("I") {
            return Some(Formula::Identity);
        }
        let digits = self.rest.len() - self.rest.trim_start_matches(|c: char| c.is_ascii_digit()).len();
        let number = self.rest.get(..digits)?.parse::<u32>().ok()?;
        self.rest = &self.rest[digits..];
        Some(Formula::Number(f64::from(number)))
    }

    fn blocks(&mut self) -> Option<Formula> {
        let mut rows = vec![Vec::new()];
        loop {
            let entry = if self.eat("*") { None } else { Some(self.sum()?) };
            rows.last_mut()?.push(entry);
            if self.eat("; ") {
                rows.push(Vec::new());
            } else if self.eat("]") {
                let width = rows.first()?.len();
                return rows.iter().all(|row| row.len() == width).then_some(Formula::Blocks(rows));
            } else if !self.eat(", ") {
                return None;
            }
        }
    }
}
