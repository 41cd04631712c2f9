//! Linear matrix inequalities `F_k0 + x_1 F_k1 + ... + x_m F_km > 0` (or `>= 0`): a point that satisfies them, or multipliers that show there is none.
//!
//! **Holds.** `F_k(x) > 0` for every k, evaluated at the x given with outward rounding, then exactly. The margin is a lower bound of the smallest eigenvalue.
//!
//! **Refuted.** Multipliers `Z_k >= 0`, not all zero, with `sum_k tr(F_ki Z_k) = 0` for every unknown i and `sum_k tr(F_k0 Z_k) <= 0` (`< 0` for inequalities that are not strict), exactly.
//! Then no x satisfies the inequalities: `sum_k tr(F_k(x) Z_k)` would be positive (not negative), and is that constant whatever x is.

use super::super::fields::{Fields, LARGEST_ORDER};
use super::super::number::Number;
use super::super::write::Out;
use super::super::{Fault, Witness};
use super::{Fact, FileError, Statement, combination, counted, unknown_word};
use crate::definite::{self, Direction, positive_definite, positive_semidefinite};
use crate::error::ProofError;
use crate::exact::Exact;
use crate::interval::Interval;
use crate::matrix::Matrix;
use crate::ring::Ring;
use crate::verdict::Verdict;
use crate::wording::quoted;

/// One entry of the matrices of a constraint, and of its mirror image.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Coefficient {
    /// Which matrix: 0 for the constant `F_k0`, i for that of `x_i`.
    pub unknown: usize,
    /// The row, from 0.
    pub row: usize,
    /// The column, from 0, not below the row.
    pub column: usize,
    /// The entry.
    pub value: Number,
}

/// One constraint: a symmetric matrix that depends affinely on the unknowns and is to be positive.
#[derive(Debug, Clone, PartialEq)]
pub struct Constraint {
    /// What it is called.
    pub name: String,
    /// The order of its matrices.
    pub order: usize,
    /// The entries that are not 0, upper triangle. Entries at the same place add up.
    pub entries: Vec<Coefficient>,
}

/// A system of linear matrix inequalities.
#[derive(Debug, Clone, PartialEq)]
pub struct MatrixInequality {
    /// How many scalar unknowns.
    pub unknowns: usize,
    /// `F_k(x) > 0`, or `F_k(x) >= 0`.
    pub strict: bool,
    /// The constraints, at least one.
    pub constraints: Vec<Constraint>,
}

impl MatrixInequality {
    fn read(file: &mut Fields<'_>) -> Result<Self, FileError> {
        let mut fields = file.object("inequalities")?;
        let unknowns = fields.take("unknowns")?.index(1 << 20)?;
        let relation = fields.take("relation")?;
        let strict = match relation.text()? {
            ">" => true,
            ">=" => false,
            other => return Err(unknown_word(&relation, other, &[">", ">="])),
        };
        let list = fields.take("constraints")?;
        let mut constraints = Vec::new();
        for item in list.items()? {
            let mut fields = item.object()?;
            let name = fields.take("name")?.name()?;
            let order = fields.take("order")?;
            let order = match order.index(LARGEST_ORDER)? {
                0 => return Err(order.error(Fault::Empty)),
                order => order,
            };
            let mut entries = Vec::new();
            for entry in fields.take("entries")?.items()? {
                let parts = entry.items()?;
                let [unknown, row, column, value] = parts.as_slice() else {
                    return Err(entry.error(Fault::Length { expected: 4, found: parts.len() }));
                };
                let column = column.index(order - 1)?;
                let row = row.index(column)?;
                entries.push(Coefficient { unknown: unknown.index(unknowns)?, row, column, value: value.exact()? });
            }
            fields.finish()?;
            constraints.push(Constraint { name, order, entries });
        }
        fields.finish()?;
        list.bounded_entries(constraints.iter().map(|constraint: &Constraint| constraint.order))?;
        if constraints.is_empty() { Err(list.error(Fault::Empty)) } else { Ok(Self { unknowns, strict, constraints }) }
    }

    fn write(&self) -> (&'static str, Out) {
        let constraint = |constraint: &Constraint| {
            let entries = constraint.entries.iter().map(|entry| {
                let places = [entry.unknown, entry.row, entry.column].map(Out::Count);
                Out::Line(places.into_iter().chain([Out::Text(entry.value.to_string())]).collect())
            });
            Out::Object(vec![
                ("name", Out::Text(constraint.name.clone())),
                ("order", Out::Count(constraint.order)),
                ("entries", Out::Lines(entries.collect())),
            ])
        };
        let members = vec![
            ("unknowns", Out::Count(self.unknowns)),
            ("relation", Out::Text(self.relation().to_owned())),
            ("constraints", Out::Lines(self.constraints.iter().map(constraint).collect())),
        ];
        ("inequalities", Out::Object(members))
    }

    fn relation(&self) -> &'static str {
        if self.strict { ">" } else { ">=" }
    }

    fn names(&self) -> String {
        self.constraints.iter().map(|constraint| quoted(&constraint.name)).collect::<Vec<_>>().join(", ")
    }

    fn described(&self) -> String {
        format!(
            "F_k(x) = F_k0 + {} {} 0, {} ({})",
            combination("F_k", self.unknowns),
            self.relation(),
            counted(self.constraints.len(), "constraint"),
            self.names(),
        )
    }
}

/// `F_k(x)` over a ring.
fn evaluate<R: Ring>(constraint: &Constraint, x: &[f64], number: impl Fn(&Number) -> R) -> Matrix<R> {
    let mut sum = Matrix::<R>::zeros(constraint.order, constraint.order);
    for entry in &constraint.entries {
        let factor = match entry.unknown {
            0 => R::from_f64(1.0),
            i => x.get(i - 1).and_then(|x| R::from_f64(*x)),
        };
        let term = factor.unwrap_or_else(R::zero).mul(&number(&entry.value));
        let at = &mut sum[(entry.row, entry.column)];
        *at = at.add(&term);
    }
    Matrix::from_fn(constraint.order, constraint.order, |i, j| sum[(i.min(j), i.max(j))].clone())
}

fn decide<T: definite::Entry>(m: &Matrix<T>, strict: bool) -> Result<Verdict<Direction>, ProofError> {
    if strict { positive_definite(m) } else { positive_semidefinite(m) }
}

/// A point satisfies the inequalities; the head of the file has the theorem.
#[derive(Debug, Clone, PartialEq)]
pub struct InequalityHolds {
    /// The inequalities.
    pub inequalities: MatrixInequality,
    /// The values of the unknowns.
    pub x: Vec<f64>,
}

impl Statement for InequalityHolds {
    const NAME: &'static str = "matrix-inequality-holds";

    fn facts(&self) -> Result<Vec<Fact>, ProofError> {
        if self.x.len() != self.inequalities.unknowns {
            let (expected, found) = ((self.inequalities.unknowns, 1), (self.x.len(), 1));
            return Err(ProofError::DimensionMismatch { what: "x", expected, found });
        }
        if let Some((row, &value)) = self.x.iter().enumerate().find(|(_, x)| !x.is_finite()) {
            return Err(ProofError::NotFinite { what: "x", row, column: 0, value });
        }
        let strict = self.inequalities.strict;
        let mut facts = Vec::new();
        for constraint in &self.inequalities.constraints {
            let enclosed: Matrix<Interval> = evaluate(constraint, &self.x, Number::enclosure);
            let mut verdict = decide(&enclosed, strict)?;
            let dyadic = constraint.entries.iter().all(|entry| entry.value.exact().is_some());
            if dyadic && matches!(verdict, Verdict::Undecided { .. }) {
                let exact: Matrix<Exact> =
                    evaluate(constraint, &self.x, |value| value.exact().cloned().unwrap_or_else(Exact::zero));
                verdict = decide(&exact, strict)?;
            }
            facts.push(Fact::new(
                format!("F(x) {} 0 of {}", self.inequalities.relation(), quoted(&constraint.name)),
                verdict,
            ));
        }
        Ok(facts)
    }

    fn words(&self) -> String {
        format!("The x given satisfies the linear matrix inequalities {}.", self.inequalities.described())
    }

    fn read(file: &mut Fields<'_>) -> Result<Self, FileError> {
        let inequalities = MatrixInequality::read(file)?;
        let list = file.take("x")?;
        let x = list.items()?.iter().map(super::Field::binary64).collect::<Result<Vec<_>, _>>()?;
        if x.len() != inequalities.unknowns {
            return Err(list.error(Fault::Length { expected: inequalities.unknowns, found: x.len() }));
        }
        Ok(Self { inequalities, x })
    }

    fn write(&self) -> Vec<(&'static str, Out)> {
        vec![self.inequalities.write(), ("x", Out::numbers(&self.x))]
    }
}

/// No point satisfies the inequalities; the head of the file has theorem and proof.
#[derive(Debug, Clone, PartialEq)]
pub struct InequalityRefuted {
    /// The inequalities, with dyadic coefficients.
    pub inequalities: MatrixInequality,
    /// The multiplier of each constraint, dyadic; a matrix of zeros where it takes no part.
    pub multipliers: Vec<Matrix<Exact>>,
}

impl Statement for InequalityRefuted {
    const NAME: &'static str = "matrix-inequality-refuted";

    fn facts(&self) -> Result<Vec<Fact>, ProofError> {
        let constraints = &self.inequalities.constraints;
        let mut facts = Vec::new();
        let mut terms = Vec::new();
        let mut all_zero = true;
        for (constraint, z) in constraints.iter().zip(&self.multipliers) {
            z.expect_shape("a multiplier", (constraint.order, constraint.order))?;
            facts.push(Fact::new(format!("Z >= 0 of {}", quoted(&constraint.name)), positive_semidefinite(z)?));
            all_zero &= z.as_slice().iter().all(Ring::is_zero);
            terms.extend(constraint.entries.iter().map(|entry| (entry, &z[(entry.row, entry.column)])));
        }
        // One trace at a time: each may be as long as the longest number.
        terms.sort_by_key(|(entry, _)| entry.unknown);
        let (mut constant, mut unsatisfied) = (Exact::zero(), None);
        for terms in terms.chunk_by(|x, y| x.0.unknown == y.0.unknown) {
            let mut trace = Exact::zero();
            for (entry, z) in terms {
                let Some(value) = entry.value.exact() else { continue };
                let product = value.mul(z);
                // An entry off the diagonal stands for its mirror image too.
                trace = trace.add(&if entry.row == entry.column { product } else { product.shifted(1) });
            }
            let unknown = terms.first().map_or(0, |(entry, _)| entry.unknown);
            if unknown == 0 {
                constant = trace;
            } else if !trace.is_zero() {
                unsatisfied = Some((unknown, trace));
                break;
            }
        }
        let holds = |witness: Option<Witness>, margin: f64| match witness {
            Some(witness) => Verdict::Refuted { witness },
            None => Verdict::Proved { margin },
        };
        let value = |x: &Exact| if x.signum() < 0 { x.round_down() } else { x.round_up() };
        let unsatisfied = unsatisfied.map(|(unknown, trace)| Witness::Equation { unknown, value: value(&trace) });
        facts.push(Fact::stated("sum_k tr(F_ki Z_k) = 0 for every unknown x_i", holds(unsatisfied, 0.0)));
        facts.push(Fact::stated("the Z_k are not all zero", holds(all_zero.then_some(Witness::Zero), 0.0)));
        let (relation, right_sign) =
            if self.inequalities.strict { ("<=", constant.signum() <= 0) } else { ("<", constant.signum() < 0) };
        let wrong = (!right_sign).then(|| Witness::Equation { unknown: 0, value: value(&constant) });
        let margin = constant.neg().round_down().clamp(0.0, f64::MAX);
        facts.push(Fact::stated(format!("sum_k tr(F_k0 Z_k) {relation} 0"), holds(wrong, margin)));
        Ok(facts)
    }

    fn words(&self) -> String {
        format!("No x satisfies the linear matrix inequalities {}.", self.inequalities.described())
    }

    fn read(file: &mut Fields<'_>) -> Result<Self, FileError> {
        let inequalities = MatrixInequality::read(file)?;
        let list = file.take("multipliers")?;
        let items = list.items()?;
        if items.len() != inequalities.constraints.len() {
            return Err(list.error(Fault::Length { expected: inequalities.constraints.len(), found: items.len() }));
        }
        for (k, constraint) in inequalities.constraints.iter().enumerate() {
            if let Some(entry) = constraint.entries.iter().find(|entry| entry.value.exact().is_none()) {
                let mut error = list.not_exact(&entry.value, "dyadic number (scale the constraint)");
                error.path = format!("inequalities.constraints[{k}].entries");
                return Err(error);
            }
        }
        let mut multipliers = Vec::with_capacity(items.len());
        for (item, constraint) in items.iter().zip(&inequalities.constraints) {
            let z = item.symmetric_exact(constraint.order)?;
            let mut entries = Vec::with_capacity(z.as_slice().len());
            for number in z.as_slice() {
                let exact = number
                    .exact()
                    .ok_or_else(|| item.not_exact(number, "dyadic number (scale the multipliers to integers)"))?;
                entries.push(exact.clone());
            }
            let order = constraint.order;
            multipliers.push(Matrix::from_row_major(order, order, entries).map_err(|_| item.error(Fault::Empty))?);
        }
        Ok(Self { inequalities, multipliers })
    }

    fn write(&self) -> Vec<(&'static str, Out)> {
        let multiplier = |z: &Matrix<Exact>| Out::exact(&z.map(|x| Number::from(x.clone())));
        vec![self.inequalities.write(), ("multipliers", Out::Lines(self.multipliers.iter().map(multiplier).collect()))]
    }
}
