//! Linear matrix inequalities `F_k0 + x_1 F_k1 + ... + x_m F_km > 0` (or `>= 0`) in the unknown x. That a point
//! satisfies them: [`inequality_holds`](super::inequality_holds); that none does:
//! [`inequality_refuted`](super::inequality_refuted).

use super::super::Fault;
use super::super::fields::{Fields, LARGEST_ORDER};
use super::super::write::Out;
use super::{FileError, combination, counted, unknown_word};
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
    pub(super) fn read(file: &mut Fields<'_>) -> Result<Self, FileError> {
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

    pub(super) fn write(&self) -> (&'static str, Out) {
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
