//! Columns of scalars: the states, inputs, outputs and estimates that plants and observers exchange.
//!
//! Simulation stacks columns of plants and observers into one vector and takes them apart again; this trait is all it
//! needs to know of them, so that static and dynamic sizes go the same way.

use nalgebra::allocator::Allocator;
use nalgebra::{DefaultAllocator, Dim, OVector, Scalar, U1};

/// A column vector with entries `T`.
///
/// Implemented for every nalgebra column: `SVector<T, N>` and, with the feature `alloc`, `DVector<T>`.
pub trait Column<T>: Clone + Sized {
    /// The column with these entries, or `None` if the type has a fixed length other than `entries.len()`.
    fn try_from_slice(entries: &[T]) -> Option<Self>;

    /// The column with these entries.
    ///
    /// ```
    /// use luenberger_plants::Column;
    /// use nalgebra::Vector2;
    /// assert_eq!(Vector2::from_slice(&[1.0, 2.0]).as_slice(), [1.0, 2.0]);
    /// assert!(<Vector2<f64> as Column<f64>>::try_from_slice(&[1.0]).is_none());
    /// ```
    ///
    /// # Panics
    /// If the type has a fixed length other than `entries.len()`. Where the length may not fit, use
    /// [`try_from_slice`](Self::try_from_slice).
    fn from_slice(entries: &[T]) -> Self {
        match Self::try_from_slice(entries) {
            Some(column) => column,
            None => panic!("{} entries do not fit a column of fixed length", entries.len()),
        }
    }

    /// The entries, first to last.
    fn as_slice(&self) -> &[T];

    /// The length that the type fixes, `None` when it is known at run time only.
    fn fixed_len() -> Option<usize>;
}

impl<T: Scalar, D: Dim> Column<T> for OVector<T, D>
where
    DefaultAllocator: Allocator<D>,
{
    fn try_from_slice(entries: &[T]) -> Option<Self> {
        if D::try_to_usize().is_some_and(|n| n != entries.len()) {
            return None;
        }
        Some(Self::from_iterator_generic(D::from_usize(entries.len()), U1, entries.iter().cloned()))
    }

    fn as_slice(&self) -> &[T] {
        // The inherent method of nalgebra, not this one.
        nalgebra::Matrix::as_slice(self)
    }

    fn fixed_len() -> Option<usize> {
        D::try_to_usize()
    }
}
