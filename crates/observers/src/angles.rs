//! Angles among outputs and states: full turns, modulo which differences are taken.
//!
//! A column of turns has the full turn of each entry that is an angle, in its unit (2 pi or 360), and 0 for the others.
//! Differences are [wrapped](luenberger_plants::angle) into half a turn to either side; the estimates themselves are
//! not.

use luenberger_plants::wrap;
use nalgebra::allocator::Allocator;
use nalgebra::{DefaultAllocator, Dim, OVector, RealField, U1};

use crate::error::ObserverError;

/// The turns of a column; none if no entry is an angle.
pub(crate) type Turns<T, D> = Option<OVector<T, D>>;

/// The turns of a column of this length, after a check.
///
/// # Errors [`ObserverError::Table`] for another length, [`ObserverError::NotPositive`] for a turn that is negative or
/// not finite.
pub(crate) fn checked<T: RealField + Copy, D: Dim>(
    turns: OVector<T, D>,
    expected: usize,
) -> Result<Turns<T, D>, ObserverError>
where
    DefaultAllocator: Allocator<D>,
{
    if turns.nrows() != expected {
        return Err(ObserverError::Table { what: "full turns", expected, found: turns.nrows() });
    }
    match turns.iter().find(|turn| !(turn.is_finite() && **turn >= T::zero())) {
        Some(turn) => Err(ObserverError::NotPositive { what: "a full turn", value: turn.to_subset_unchecked() }),
        None => Ok(Some(turns).filter(|turns| turns.iter().any(|turn| *turn > T::zero()))),
    }
}

/// The turns of outputs and states, 0 for what is no angle; none without angles.
pub(crate) fn both<T: RealField + Copy, P: Dim, N: Dim>(
    (outputs, p): (&Turns<T, P>, P),
    (states, n): (&Turns<T, N>, N),
) -> Option<(OVector<T, P>, OVector<T, N>)>
where
    DefaultAllocator: Allocator<P> + Allocator<N>,
{
    (outputs.is_some() || states.is_some()).then(|| {
        let outputs = outputs.clone().unwrap_or_else(|| OVector::zeros_generic(p, U1));
        (outputs, states.clone().unwrap_or_else(|| OVector::zeros_generic(n, U1)))
    })
}

/// An entry of a difference.
pub(crate) fn entry<T: RealField + Copy, D: Dim>(turns: &Turns<T, D>, index: usize, difference: T) -> T
where
    DefaultAllocator: Allocator<D>,
{
    turns.as_ref().map_or(difference, |turns| wrap(difference, turns[index]))
}

/// `a - b`.
pub(crate) fn difference<T: RealField + Copy, D: Dim>(
    turns: &Turns<T, D>,
    a: &OVector<T, D>,
    b: &OVector<T, D>,
) -> OVector<T, D>
where
    DefaultAllocator: Allocator<D>,
{
    let mut difference = a - b;
    if let Some(turns) = turns {
        for i in 0..difference.nrows() {
            difference[i] = wrap(difference[i], turns[i]);
        }
    }
    difference
}
