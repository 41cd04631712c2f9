//! The Jacobians of a plant over one box.

use luenberger_plants::{Column, Dimensions, Plant};
use luenberger_proof::{Interval, Ring};

use super::error::{CHOICE, EnclosureError};
use super::paths::{self, Undefined};
use super::scalar::IntervalDual;

/// The two sides of a plant, f and h.
pub(super) trait Sides {
    /// Number of states, inputs and outputs.
    fn size(&self) -> Dimensions;
    /// f, or h, at columns of any length.
    fn at(&self, side: &str, t: IntervalDual, x: &[IntervalDual], u: &[IntervalDual]) -> Values;
}

/// The rows of f or of h.
pub(super) type Values = Result<Vec<IntervalDual>, Failure>;

impl<S: Plant<IntervalDual>> Sides for S {
    fn size(&self) -> Dimensions {
        self.dimensions()
    }

    fn at(&self, side: &str, t: IntervalDual, x: &[IntervalDual], u: &[IntervalDual]) -> Values {
        let (x, u) = (column("states", x)?, column("inputs", u)?);
        Ok(if side == "h" {
            self.output(t, &x, &u).as_slice().to_vec()
        } else {
            self.derivative(t, &x, &u).as_slice().to_vec()
        })
    }
}

/// The operations of a plant that the search needs, compiled once for all plants.
pub(super) struct Evaluation<'a> {
    pub(super) plant: &'a dyn Sides,
    pub(super) size: Dimensions,
}

/// Why one box has no result.
pub(super) enum Failure {
    Undefined(Undefined, &'static str),
    Wrong(EnclosureError),
}

impl Evaluation<'_> {
    /// Df row by row, then Dh row by row, over one box, whose entries may be unbounded; and whether the box leaves a
    /// branch open.
    pub(super) fn jacobians(&self, cell: &[Interval]) -> Result<(Vec<Interval>, bool), Failure> {
        let (n, p) = (self.size.states, self.size.outputs);
        let mut entries = vec![Interval::zero(); (n + p) * n];
        let mut branched = false;
        for j in 0..n {
            let [f, h] = ["f", "h"].map(|side| paths::explore(|| self.over(side, cell, Some(j))));
            branched |= [&f, &h].iter().any(|ways| ways.as_ref().is_ok_and(|ways| ways.len() > 1));
            let slopes = united("f", n, f)?.into_iter().chain(united("h", p, h)?);
            for (i, slope) in slopes.enumerate() {
                entries[i * n + j] = slope;
            }
        }
        Ok((entries, branched))
    }

    /// f or h over a part, with the slopes along coordinate `along`, if one is given.
    pub(super) fn over(&self, side: &str, cell: &[Interval], along: Option<usize>) -> Values {
        let (n, m) = (self.size.states, self.size.inputs);
        let seed = |k: usize| if along == Some(k) { Interval::ONE } else { Interval::zero() };
        let coordinates: Vec<IntervalDual> = (0..cell.len()).map(|k| IntervalDual::new(cell[k], seed(k))).collect();
        self.plant.at(side, coordinates[n + m], &coordinates[..n], &coordinates[n..n + m])
    }
}

/// The entries as a column of the plant.
fn column<C: Column<IntervalDual>>(what: &'static str, entries: &[IntervalDual]) -> Result<C, Failure> {
    let expected = entries.len();
    let found = C::fixed_len().unwrap_or(expected);
    C::try_from_slice(entries).ok_or(Failure::Wrong(EnclosureError::Dimension { what, expected, found }))
}

/// The slopes on all branches, as long as the values of no two branches are apart.
fn united(side: &'static str, expected: usize, ways: Result<Vec<Values>, Undefined>) -> Result<Vec<Interval>, Failure> {
    let ways = ways.map_err(|undefined| Failure::Undefined(undefined, side))?;
    let ways: Vec<Vec<IntervalDual>> = ways.into_iter().collect::<Result<_, _>>()?;
    let what = if side == "f" { "rows of f" } else { "rows of h" };
    if let Some(found) = ways.iter().map(Vec::len).find(|len| *len != expected) {
        return Err(Failure::Wrong(EnclosureError::Dimension { what, expected, found }));
    }
    let mut union: Vec<IntervalDual> = Vec::new();
    for way in ways {
        if union.is_empty() {
            union = way;
            continue;
        }
        for (all, one) in union.iter_mut().zip(&way) {
            if all.value().intersection(&one.value()).is_none() {
                return Err(Failure::Undefined(Undefined::Operation(CHOICE), side));
            }
            *all = IntervalDual::new(all.value().hull(&one.value()), all.slope().hull(&one.slope()));
        }
    }
    Ok(union.iter().map(IntervalDual::slope).collect())
}

/// A number inside: the middle, or twice the finite end of a half line, so that 48 halvings reach 1e14.
pub(super) fn middle(axis: &Interval) -> f64 {
    match (axis.lo().is_finite(), axis.hi().is_finite()) {
        (true, true) => axis.lo() / 2.0 + axis.hi() / 2.0,
        (true, false) => (2.0 * axis.lo()).clamp(1.0, f64::MAX),
        (false, true) => (2.0 * axis.hi()).clamp(f64::MIN, -1.0),
        (false, false) => 0.0,
    }
}
