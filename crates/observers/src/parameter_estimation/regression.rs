//! The regression of a parameter-estimation-based observer: how the constant that xi lacks shows in a function of the
//! outputs.
//!
//! [`kkl_peb`](crate::kkl_peb) filters both sides of it; [`pebo`](crate::pebo) says why the filtered one is exact.

use nalgebra::allocator::Allocator;
use nalgebra::{DefaultAllocator, Dim, DimAdd, DimMul, DimProd, DimSum, OMatrix, OVector, RealField, U2};

use super::estimator::RegressionSize;
use crate::kkl::{KklMap, KklSize};
use crate::observer::length;

/// `d s(y)/dt = g + m theta`, and the map from theta to the missing part of xi.
#[diagnostic::on_unimplemented(
    message = "`{Self}` has no regression for the parameters over the scalar `{T}`",
    note = "implement `Regression<T>` beside `KklMap<T>`"
)]
pub trait Regression<T: RealField + Copy>: KklMap<T>
where
    DefaultAllocator: KklSize<
            <Self as KklMap<T>>::Xi,
            <Self as KklMap<T>>::Inputs,
            <Self as KklMap<T>>::Outputs,
            <Self as KklMap<T>>::Estimate,
        > + RegressionSize<<Self as Regression<T>>::Rows, <Self as Regression<T>>::Parameters>,
{
    /// Length r of s.
    type Rows: Dim;
    /// Number q of parameters.
    type Parameters: Dim;

    /// The lengths r of s and q of theta. Required where one of the types is [`nalgebra::Dyn`].
    fn rows_and_parameters(&self) -> (usize, usize) {
        (length::<Self::Rows>(), length::<Self::Parameters>())
    }

    /// `s(t, y)`, of length r.
    fn signal(&self, t: T, y: &OVector<T, Self::Outputs>) -> OVector<T, Self::Rows>;

    /// `g(t, xi, u, y)`, of length r.
    fn known(
        &self,
        t: T,
        xi: &OVector<T, Self::Xi>,
        u: &OVector<T, Self::Inputs>,
        y: &OVector<T, Self::Outputs>,
    ) -> OVector<T, Self::Rows>;

    /// `m(t, xi, u, y)`, r x q.
    fn regressor(
        &self,
        t: T,
        xi: &OVector<T, Self::Xi>,
        u: &OVector<T, Self::Inputs>,
        y: &OVector<T, Self::Outputs>,
    ) -> OMatrix<T, Self::Rows, Self::Parameters>;

    /// What is missing in xi, as a function of theta: `phi(x) = xi + missing(theta)`. Zero in the entries that the KKL
    /// part finds by itself; the logarithm where theta is an exponential.
    fn missing(&self, theta: &OVector<T, Self::Parameters>) -> OVector<T, Self::Xi>;

    /// Whether entry i of xi is only integrated, so that a part of it is missing (default true).
    fn is_open(&self, _entry: usize) -> bool {
        true
    }

    /// The least value that parameter i may have, when [`missing`](Self::missing) is not defined below it. The estimate
    /// is held there.
    fn lower_bound(&self, _parameter: usize) -> Option<T> {
        None
    }
}

/// The length of the state of an observer with an extension of length `Z`, r = `R` filtered rows of `Q` parameters, and
/// an estimator of length `L`: `Z + R (Q + 2) + L`. Never implement it yourself.
#[diagnostic::on_unimplemented(
    message = "not every column and matrix of a parameter-estimation-based observer of these sizes can be stored",
    note = "code that is generic in the sizes needs the bound `DefaultAllocator: PebSize<Z, R, Q, L>`"
)]
pub trait PebSize<Z: Dim, R: Dim, Q: Dim, L: Dim>:
    RegressionSize<R, Q> + Allocator<<Self as PebSize<Z, R, Q, L>>::Length>
{
    /// The length as a dimension.
    type Length: Dim;
}

impl<Z, R, Q, L> PebSize<Z, R, Q, L> for DefaultAllocator
where
    L: Dim,
    Q: DimAdd<U2>,
    R: DimMul<DimSum<Q, U2>>,
    Z: DimAdd<DimProd<R, DimSum<Q, U2>>>,
    DimSum<Z, DimProd<R, DimSum<Q, U2>>>: DimAdd<L>,
    DefaultAllocator: RegressionSize<R, Q> + Allocator<DimSum<DimSum<Z, DimProd<R, DimSum<Q, U2>>>, L>>,
{
    type Length = DimSum<DimSum<Z, DimProd<R, DimSum<Q, U2>>>, L>;
}
