//! Linear matrix inequalities `F_k0 + x_1 F_k1 + ... + x_m F_km > 0` (or `>= 0`) in the unknown x. That a point
//! satisfies them: [`inequality_holds`](super::inequality_holds); that none does:
//! [`inequality_refuted`](super::inequality_refuted).

use super::super::Fault;
use super::super::fields::{Field, Fields, LARGEST_ORDER};
use super::super::members::{Members, members};
use super::super::write::{Out, Written};
use super::{FileError, combination, counted};
use crate::number::Number;
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
    /// Its name, for messages.
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
    pub(super) fn relation(&self) -> &'static str {
        if self.strict { ">" } else { ">=" }
    }

    fn names(&self) -> String {
        self.constraints.iter().map(|constraint| quoted(&constraint.name)).collect::<Vec<_>>().join(", ")
    }

    pub(super) fn described(&self) -> String {
        format!(
            "F_k(x) = F_k0 + {} {} 0, {} ({})",
            combination("F_k", self.unknowns),
            self.relation(),
            counted(self.constraints.len(), "constraint"),
            self.names(),
        )
    }
}

impl Members for MatrixInequality {
    fn read(file: &mut Fields<'_>, (): ()) -> Result<Self, FileError> {
        let unknowns = file.take("unknowns")?.index(1 << 20)?;
        let strict = file.take("relation")?.word(&[(">", true), (">=", false)])?;
        let list = file.take("constraints")?;
        let constraints: Vec<Constraint> = list.some_of(|item| item.part_of(unknowns))?;
        list.bounded_entries(constraints.iter().map(|constraint| constraint.order))?;
        Ok(Self { unknowns, strict, constraints })
    }

    fn write(&self) -> Vec<(&'static str, Out)> {
        vec![
            ("unknowns", self.unknowns.out()),
            ("relation", self.relation().out()),
            ("constraints", self.constraints.out()),
        ]
    }
}

impl Written for MatrixInequality {
    fn out(&self) -> Out {
        Out::Object(self.write())
    }
}

members! { Constraint, unknowns: usize { {
    name = "name".name();
    order = "order".by(read_order);
    entries = "entries".list_of(|entry| Coefficient::read(entry, unknowns, order));
} } }

fn read_order(field: &Field<'_>) -> Result<usize, FileError> {
    match field.index(LARGEST_ORDER)? {
        0 => Err(field.error(Fault::Empty)),
        order => Ok(order),
    }
}

impl Coefficient {
    fn read(entry: &Field<'_>, unknowns: usize, order: usize) -> Result<Self, FileError> {
        let parts = entry.items()?;
        let [unknown, row, column, value] = parts.as_slice() else {
            return Err(entry.error(Fault::Length { expected: 4, found: parts.len() }));
        };
        let column = column.index(order - 1)?;
        let row = row.index(column)?;
        Ok(Self { unknown: unknown.index(unknowns)?, row, column, value: value.exact()? })
    }
}

impl Written for Coefficient {
    fn out(&self) -> Out {
        Out::Line(vec![self.unknown.out(), self.row.out(), self.column.out(), self.value.out()])
    }
}
