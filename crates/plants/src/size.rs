//! One trait bound in place of nalgebra's allocator bounds.
//!
//! Code generic over the numbers of states N, inputs M and outputs P needs an allocator for every shape it forms. This
//! trait collects them: a signature needs only `where DefaultAllocator: Size<N, M, P>`.

use nalgebra::allocator::Allocator;
use nalgebra::{DefaultAllocator, Dim};

/// Every shape that can be made of `N` states, `M` inputs and `P` outputs can be stored.
///
/// Holds for all combinations of [`nalgebra::Const`] and (feature `alloc`) [`nalgebra::Dyn`]; never implement it
/// yourself.
pub trait Size<N: Dim, M: Dim, P: Dim>:
    Allocator<N>
    + Allocator<M>
    + Allocator<P>
    + Allocator<N, N>
    + Allocator<N, M>
    + Allocator<N, P>
    + Allocator<M, N>
    + Allocator<P, M>
    + Allocator<P, N>
    + Allocator<P, P>
{
}

impl<N: Dim, M: Dim, P: Dim> Size<N, M, P> for DefaultAllocator where
    DefaultAllocator: Allocator<N>
        + Allocator<M>
        + Allocator<P>
        + Allocator<N, N>
        + Allocator<N, M>
        + Allocator<N, P>
        + Allocator<M, N>
        + Allocator<P, M>
        + Allocator<P, N>
        + Allocator<P, P>
{
}
