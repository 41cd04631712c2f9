//! Direct feedthrough: a plant with `y = C x + D u` is observed through `y - D u`.
//!
//! The input is known, so that neither gain nor error equation changes. An observer without D does not pay for it: its
//! right-hand side is to the last bit what it is for `y = C x`.

use crate::dense::entry;
use luenberger_plants::PlantError;
use luenberger_plants::error::check_matrix;
use nalgebra::allocator::Allocator;
use nalgebra::{DefaultAllocator, Dim, OMatrix, OVector, RealField};

/// `value - D u`, for a value that is y or `y - C xhat`; the value itself where there is no D.
pub(crate) fn without<T: RealField + Copy, M: Dim, P: Dim>(
    d: Option<&OMatrix<T, P, M>>,
    u: &OVector<T, M>,
    value: OVector<T, P>,
) -> OVector<T, P>
where
    DefaultAllocator: Allocator<P, M> + Allocator<M> + Allocator<P>,
{
    match d {
        Some(d) => value - d * u,
        None => value,
    }
}

/// `y - C xhat - D u` into `innovation`.
#[inline(always)]
#[allow(clippy::inline_always, reason = "as in dense.rs")]
pub(crate) fn innovation<T: RealField + Copy, N: Dim, M: Dim, P: Dim>(
    c: &OMatrix<T, P, N>,
    d: Option<&OMatrix<T, P, M>>,
    (xhat, u, y): (&[T], &[T], &[T]),
    innovation: &mut [T],
) where
    DefaultAllocator: Allocator<P, N> + Allocator<P, M>,
{
    debug_assert_eq!(y.len(), innovation.len(), "outputs");
    for (i, (value, y)) in innovation.iter_mut().zip(y).enumerate() {
        *value = *y - entry(c, i, xhat);
        if let Some(d) = d {
            *value -= entry(d, i, u);
        }
    }
}

/// `y - C xhat - D u`.
#[allow(clippy::type_complexity, reason = "three columns, not a type")]
pub(crate) fn innovation_of<T: RealField + Copy, N: Dim, M: Dim, P: Dim>(
    c: &OMatrix<T, P, N>,
    d: Option<&OMatrix<T, P, M>>,
    (xhat, u, y): (&OVector<T, N>, &OVector<T, M>, &OVector<T, P>),
) -> OVector<T, P>
where
    DefaultAllocator: Allocator<P, N> + Allocator<P, M> + Allocator<N> + Allocator<M> + Allocator<P>,
{
    let mut column = y.clone();
    innovation(c, d, (xhat.as_slice(), u.as_slice(), y.as_slice()), column.as_mut_slice());
    column
}

/// D of a plant with these sizes.
pub(crate) fn checked<T: RealField + Copy, M: Dim, P: Dim>(
    d: OMatrix<T, P, M>,
    (outputs, inputs): (usize, usize),
) -> Result<OMatrix<T, P, M>, PlantError>
where
    DefaultAllocator: Allocator<P, M>,
{
    check_matrix("D", &d, (outputs, inputs))?;
    Ok(d)
}
