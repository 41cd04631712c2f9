//! The Jacobians of a plant over one box.

use luenberger_plants::{Column, Dimensions, Plant};
use luenberger_proof::{Interval, Ring};

use super::error::{CHOICE, EnclosureError};
use super::paths::{self, Undefined};
use super::scalar::IntervalDual;

/// The operation of a plant that the search needs: the Jacobians over one box.
pub(super) struct Evaluation<'a, S> {
    pub(super) plant: &'a S,
    pub(super) size: Dimensions,
}

/// Why one box has no result.
pub(super) enum Failure {
    Undefined(Undefined, &'static str),
    Wrong(EnclosureError),
}

impl<S: Plant<IntervalDual>> Evaluation<'_, S> {
    /// Df row by row, then Dh row by row, over one box, whose entries may be unbounded; and whether the box leaves a
    /// branch open.
    pub(super) fn jacobians(&self, cell: &[Interval]) -> Result<(Vec<Interval>, bool), Failure> {
        let (n, m, p) = (self.size.states, self.size.inputs, self.size.outputs);
        let constant = |x: &Interval| IntervalDual::new(*x, Interval::zero());
        let u: Vec<IntervalDual> = cell[n..n + m].iter().map(constant).collect();
        let u = column::<S::Input>("inputs", &u, m)?;
        let t = constant(&cell[n + m]);
        let mut entries = vec![Interval::zero(); (n + p) * n];
        let mut branched = false;
        for j in 0..n {
            let x: Vec<IntervalDual> = (0..n)
                .map(|i| IntervalDual::new(cell[i], if i == j { Interval::ONE } else { Interval::zero() }))
                .collect();
            let x = column::<S::State>("states", &x, n)?;
            let f = paths::explore(|| self.plant.derivative(t, &x, &u).as_slice().to_vec());
            let h = paths::explore(|| self.plant.output(t, &x, &u).as_slice().to_vec());
            branched |= [&f, &h].iter().any(|ways| ways.as_ref().is_ok_and(|ways| ways.len() > 1));
            let slopes = united("f", n, f)?.into_iter().chain(united("h", p, h)?);
            for (i, slope) in slopes.enumerate() {
                entries[i * n + j] = slope;
            }
        }
        Ok((entries, branched))
    }
}

/// The column of the Jacobian to be computed.
pub(super) fn column<C: Column<IntervalDual>>(
    what: &'static str,
    entries: &[IntervalDual],
    expected: usize,
) -> Result<C, Failure> {
    let found = C::fixed_len().unwrap_or(expected);
    C::try_from_slice(entries).ok_or(Failure::Wrong(EnclosureError::Dimension { what, expected, found }))
}

/// The slopes on all branches, as long as the values of no two branches are apart.
fn united(
    side: &'static str,
    expected: usize,
    ways: Result<Vec<Vec<IntervalDual>>, Undefined>,
) -> Result<Vec<Interval>, Failure> {
    let ways = ways.map_err(|undefined| Failure::Undefined(undefined, side))?;
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
