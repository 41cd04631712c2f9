//! Inequalities as text, such as `(A - LC)'P + P(A - LC) + 2 rate P < 0 (12)`: parsed, evaluated, decided.
//!
//! The label of a fact is its definition: what a certificate prints is what is decided. A label is
//! ```text
//! label    = sum relation sum [" for " definition] [" (" number of an equation ")"]
//! relation = "<" | "<=" | ">" | ">="             definition = name " = " sum
//! sum      = ["-"] product {("+" | "-") product}
//! product  = factor {factor} ["/2"]
//! factor   = atom {"'" | "^2"}
//! atom     = name | whole number | "I" | "(" sum ")" | "[" row {"; " row} "]"
//!          | "He(" sum ")" | "tr " product | "diag(" name ")"
//! row      = entry {", " entry}                                        entry = sum | "*"
//! ```
//! `'` is the transpose, `He(X) = X + X'`, `*` the transpose of the block opposite, `I` the identity of the size that
//! fits. Names are those of [`Names`], the longest that fits: numbers, matrices, matrices of intervals, and definitions
//! in the same language; a name may be a phrase, such as a sum over a list or a block matrix. The definition behind
//! `for` is that of its name. Between two symmetric sides `<` means that the difference is definite; in `tr X < y` the
//! sides are numbers.
//!
//! An expression is evaluated in [`Interval`]s, and exactly if that is inconclusive and all data are single numbers.
//! Some forms are evaluated so that the result is symmetric entry by entry, with few roundings: `X + X'` with one
//! product, `X'PX` with one triangle, `PF + F'P + 2 rate P` as `P(F + rate I)` plus its transpose, and `wA + AX` as
//! `A(wI + X)`. Other products are formed from the right.
//!
//! ```
//! use luenberger_proof::{Matrix, label::Names};
//! # fn main() -> Result<(), luenberger_proof::ProofError> {
//! // A double integrator, its position measured, poles at -2 and -5: F'P + PF = -14 I.
//! let a = Matrix::from_rows([[0.0, 1.0], [0.0, 0.0]]);
//! let (l, c) = (Matrix::from_rows([[7.0], [10.0]]), Matrix::from_rows([[1.0, 0.0]]));
//! let p = Matrix::from_rows([[11.0, -7.0], [-7.0, 6.0]]);
//! let names = Names::new().matrix("A", &a).matrix("C", &c).matrix("L", &l).symmetric("P", &p);
//! let margin = names.decide("(A - LC)'P + P(A - LC) < 0")?.margin().expect("proved");
//! assert!((margin - 14.0).abs() < 1e-9 && margin <= 14.0);
//! assert!(names.decide("(A - LC)'P + P(A - LC) > 0")?.is_refuted());
//! # Ok(())
//! # }
//! ```

mod evaluate;
mod parse;
mod shapes;

use core::fmt;
use std::borrow::Cow;

use crate::definite::{self, Direction, Sense};
use crate::embed::{EXACT_ORDER, Expression, embed_symmetric, number};
use crate::error::ProofError;
use crate::exact::Exact;
use crate::interval::Interval;
use crate::matrix::Matrix;
use crate::ring::Ring;
use crate::verdict::{UndecidedReason, Verdict};
use evaluate::Term;
use parse::Formula;

/// What the names of labels stand for. Where shapes do not fit, the name that was given later is the wrong one.
#[derive(Debug, Clone, Default)]
pub struct Names<'a> {
    names: Vec<Named<'a>>,
    reader: Option<Reader<'a>>,
}

/// What a text is read as.
#[derive(Clone, Copy)]
struct Reader<'a>(&'a dyn Fn(&str) -> String);

impl fmt::Debug for Reader<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("Reader")
    }
}

#[derive(Debug, Clone)]
struct Named<'a> {
    name: &'static str,
    value: Value<'a>,
    is_symmetric: bool,
}

#[derive(Debug, Clone)]
enum Value<'a> {
    Number(f64),
    /// A list of numbers, for `diag`.
    List(&'a [f64]),
    Points(Cow<'a, Matrix<f64>>),
    Within(Matrix<Interval>),
    Definition(Formula),
    /// A matrix that was not enclosed: nothing about it is proved.
    Unknown,
}

impl<'a> Names<'a> {
    /// No names.
    pub fn new() -> Self {
        Self::default()
    }

    /// No names; each label and each definition is decided as what `read` makes of its text.
    pub(crate) fn read_by(read: &'a dyn Fn(&str) -> String) -> Self {
        Self { names: Vec::new(), reader: Some(Reader(read)) }
    }

    fn read<'t>(&self, text: &'t str) -> Cow<'t, str> {
        self.reader.map_or(Cow::Borrowed(text), |Reader(read)| Cow::Owned(read(text)))
    }

    fn with(mut self, name: &'static str, value: Value<'a>, is_symmetric: bool) -> Self {
        self.names.push(Named { name, value, is_symmetric });
        self
    }

    /// A number.
    #[must_use]
    pub fn number(self, name: &'static str, x: f64) -> Self {
        self.with(name, Value::Number(x), true)
    }

    /// A list of numbers, for `diag(name)`.
    #[must_use]
    pub fn list(self, name: &'static str, numbers: &'a [f64]) -> Self {
        self.with(name, Value::List(numbers), false)
    }

    /// A matrix, exactly as given.
    #[must_use]
    pub fn matrix(self, name: &'static str, m: &'a Matrix<f64>) -> Self {
        self.with(name, Value::Points(Cow::Borrowed(m)), false)
    }

    /// A matrix that must be symmetric.
    #[must_use]
    pub fn symmetric(self, name: &'static str, m: &'a Matrix<f64>) -> Self {
        self.with(name, Value::Points(Cow::Borrowed(m)), true)
    }

    /// Every matrix between bounds. If the bounds of all entries agree it is a matrix of numbers.
    #[must_use]
    pub fn within(self, name: &'static str, m: &Matrix<Interval>) -> Self {
        let value = if m.as_slice().iter().all(Interval::is_point) {
            Value::Points(Cow::Owned(m.map(Interval::lo)))
        } else {
            Value::Within(m.clone())
        };
        self.with(name, value, false)
    }

    /// An enclosure of a matrix; without one, every label with this name is undecided. `is_symmetric` is known of the
    /// matrix, and not checked.
    #[must_use]
    pub(crate) fn enclosed(self, name: &'static str, m: Option<&Matrix<Interval>>, is_symmetric: bool) -> Self {
        let Some(m) = m else { return self.with(name, Value::Unknown, is_symmetric) };
        let mut names = self.within(name, m);
        if let Some(last) = names.names.last_mut() {
            last.is_symmetric = is_symmetric;
        }
        names
    }

    /// An expression in the names before.
    ///
    /// # Errors
    /// [`ProofError::Label`] for text that is no expression in these names.
    pub fn define(self, name: &'static str, expression: &str) -> Result<Self, ProofError> {
        let formula = parse::expression(&self.read(expression), &self)?;
        Ok(self.with(name, Value::Definition(formula), false))
    }

    /// An expression in names of numbers and of matrices of numbers.
    ///
    /// # Errors
    /// [`ProofError`] for text that is no expression in these names, and for shapes that do not fit.
    pub(crate) fn expression(&self, text: &str) -> Result<InNames<'_>, ProofError> {
        let formula = parse::expression(&self.read(text), self)?;
        shapes::check(&formula, false, self)?;
        Ok(InNames { formula, names: self })
    }

    /// Decides the inequality. The margin is a lower bound of the least eigenvalue of the difference of its sides.
    ///
    /// # Errors
    /// [`ProofError`] for text that is no inequality in these names, inconsistent shapes, numbers that are not finite,
    /// and matrices that are not symmetric.
    pub fn decide(&self, label: &str) -> Result<Verdict<Direction>, ProofError> {
        let (formula, sense) = parse::inequality(&self.read(label), self)?;
        let names = self.names.iter().enumerate();
        let used: Vec<&Named<'_>> = names.filter(|(k, _)| formula.uses(*k)).map(|(_, named)| named).collect();
        if used.iter().any(|named| matches!(named.value, Value::Unknown)) {
            let why = UndecidedReason::NotByThisMatrix { name: "P" };
            return Ok(Verdict::Undecided { why, best: f64::NAN });
        }
        shapes::check(&formula, true, self)?;
        for named in &used {
            named.check()?;
        }
        let enclosed = evaluate::matrix(&formula, self, &|named| match &named.value {
            Value::Within(m) => Ok(Term::Matrix(m.clone())),
            _ => named.embedded::<Interval>(),
        })?;
        let verdict = definite::decide(&enclosed, sense)?;
        let has_points = !used.iter().any(|named| matches!(named.value, Value::Within(_)));
        if matches!(verdict, Verdict::Undecided { .. }) && has_points && enclosed.rows() <= EXACT_ORDER {
            return definite::decide(&evaluate::matrix(&formula, self, &|named| named.embedded::<Exact>())?, sense);
        }
        Ok(verdict)
    }
}

/// An expression in names, over any ring.
pub(crate) struct InNames<'n> {
    formula: Formula,
    names: &'n Names<'n>,
}

impl Expression for InNames<'_> {
    fn evaluate<R: Ring>(&self) -> Result<Matrix<R>, ProofError> {
        evaluate::matrix(&self.formula, self.names, &|named| named.embedded::<R>())
    }
}

impl Named<'_> {
    /// What is asked of the data alone.
    fn check(&self) -> Result<(), ProofError> {
        let Value::Points(m) = &self.value else { return Ok(()) };
        if self.is_symmetric {
            embed_symmetric::<Interval>(m, self.name, m.rows())?;
        }
        Ok(())
    }

    /// The number or the matrix of numbers in the ring.
    fn embedded<R: Ring>(&self) -> Result<Term<R>, ProofError> {
        Ok(match &self.value {
            Value::Number(x) => Term::Number(number(*x, self.name)?),
            Value::Points(m) => Term::Matrix(Matrix::embed(m, self.name)?),
            Value::List(numbers) => {
                let row = Matrix::from_row_major(1, numbers.len(), numbers.to_vec())?;
                Term::Matrix(Matrix::embed(&row, self.name)?)
            }
            Value::Within(_) | Value::Definition(_) | Value::Unknown => {
                return Err(ProofError::Label { label: self.name.to_owned() });
            }
        })
    }
}

/// The sense of a relation, and whether the right side is the larger one.
fn relation(text: &str) -> Option<(bool, bool)> {
    // (is the left side the smaller one, is it strict)
    Some(match text {
        "<" => (true, true),
        "<=" => (true, false),
        ">" => (false, true),
        ">=" => (false, false),
        _ => return None,
    })
}

/// The sense in which `left relation 0` is decided.
fn sense((smaller, strict): (bool, bool)) -> Sense {
    match (smaller, strict) {
        (true, true) => Sense::NegativeDefinite,
        (true, false) => Sense::NegativeSemidefinite,
        (false, true) => Sense::PositiveDefinite,
        (false, false) => Sense::PositiveSemidefinite,
    }
}
