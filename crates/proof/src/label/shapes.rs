//! Whether the shapes of the data fit a formula, and which does not.

use super::parse::Formula;
use super::{Names, Value};
use crate::error::ProofError;

/// The name that was given first is right: an error has the later one, with the shape that it should have. The sides of
/// an inequality are square.
pub(super) fn check(formula: &Formula, is_square: bool, names: &Names<'_>) -> Result<(), ProofError> {
    let mut sizes = Sizes { same_as: (0..2 * names.names.len()).collect(), names };
    if let Some((rows, columns)) = sizes.of(formula).filter(|_| is_square) {
        sizes.are_equal(rows, columns);
    }
    let mut known: Vec<Option<usize>> = vec![None; sizes.same_as.len()];
    for (place, named) in names.names.iter().enumerate().filter(|(place, _)| formula.uses(*place)) {
        let found = match &named.value {
            Value::Points(m) => m.shape(),
            Value::Within(m) => m.shape(),
            Value::List(numbers) => (1, numbers.len()),
            Value::Number(_) | Value::Definition(_) | Value::Unknown => continue,
        };
        let rows = *known[sizes.root(2 * place)].get_or_insert(found.0);
        let columns = *known[sizes.root(2 * place + 1)].get_or_insert(found.1);
        if (rows, columns) != found {
            return Err(ProofError::DimensionMismatch { what: named.name, expected: (rows, columns), found });
        }
    }
    Ok(())
}

/// The numbers of rows and columns of the names, in classes of equal ones.
struct Sizes<'n> {
    same_as: Vec<usize>,
    names: &'n Names<'n>,
}

impl Sizes<'_> {
    fn root(&self, size: usize) -> usize {
        if self.same_as[size] == size { size } else { self.root(self.same_as[size]) }
    }

    fn are_equal(&mut self, one: usize, other: usize) {
        let (one, other) = (self.root(one), self.root(other));
        self.same_as[other] = one;
    }

    /// A size that no name has.
    fn other(&mut self) -> usize {
        self.same_as.push(self.same_as.len());
        self.same_as.len() - 1
    }

    fn square(&mut self, formula: &Formula) -> Option<(usize, usize)> {
        let shape = self.of(formula)?;
        self.are_equal(shape.0, shape.1);
        Some(shape)
    }

    /// Rows and columns; `None` for numbers, and for identities, which fit everywhere.
    fn of(&mut self, formula: &Formula) -> Option<(usize, usize)> {
        match formula {
            Formula::Name(place) => match self.names.names[*place].value {
                Value::Number(_) => None,
                _ => Some((2 * place, 2 * place + 1)),
            },
            Formula::Number(_) | Formula::Identity => None,
            Formula::Sum(terms) => terms.iter().fold(None, |all, (_, term)| match (all, self.of(term)) {
                (Some((rows, columns)), Some(shape)) => {
                    self.are_equal(rows, shape.0);
                    self.are_equal(columns, shape.1);
                    all
                }
                (one, other) => one.or(other),
            }),
            Formula::Product(factors) => factors.iter().fold(None, |left, factor| match (left, self.of(factor)) {
                (Some((rows, inner)), Some((same, columns))) => {
                    self.are_equal(inner, same);
                    Some((rows, columns))
                }
                (one, other) => one.or(other),
            }),
            Formula::Transpose(x) => self.of(x).map(|(rows, columns)| (columns, rows)),
            Formula::Square(x) | Formula::He(x) => self.square(x),
            Formula::Trace(x) => {
                self.square(x);
                None
            }
            Formula::Diagonal(x) => self.of(x).map(|(_, length)| (length, length)),
            Formula::Blocks(rows) => {
                let heights: Vec<usize> = rows.iter().map(|_| self.other()).collect();
                let widths: Vec<usize> = rows.first()?.iter().map(|_| self.other()).collect();
                for (i, row) in rows.iter().enumerate() {
                    for (j, entry) in row.iter().enumerate() {
                        if let Some((height, width)) = entry.as_ref().and_then(|entry| self.of(entry)) {
                            self.are_equal(heights[i], height);
                            self.are_equal(widths[j], width);
                        } else if entry.is_none() {
                            // The block opposite has these sizes in the other order.
                            self.are_equal(heights[i], widths[i]);
                            self.are_equal(heights[j], widths[j]);
                        }
                    }
                }
                Some((self.other(), self.other()))
            }
        }
    }
}
