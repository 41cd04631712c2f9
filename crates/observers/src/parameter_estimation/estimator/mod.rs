//! Estimators of constant parameters: from a regression `Y = M theta` to theta.
//!
//! Y has r rows, M is r x q, theta has q entries; both Y and M change with time and are known. An estimator is a part
//! of an observer ([`kkl_peb`](crate::kkl_peb)) and has no separate inputs or outputs; it works on a part of the
//! observer's state, whose **first q entries are theta_hat**.
//!
//! | file | estimator | converges when |
//! |---|---|---|
//! | [`gradient`] | `theta_hat' = Gamma M'(Y - M theta_hat)` | M is persistently exciting: `int M'M >= delta I` over every window of one length |
//! | [`drem`] | dynamic regressor extension and mixing: one scalar equation per parameter | the determinant Delta is not square integrable |
//! | [`excitation`] | either of them, together with how exciting M has been | |
//!
//! | file | subject |
//! |---|---|
//! | [`adjugate`] | `adj A` and `det A` without an inverse |

pub mod adjugate;
pub mod drem;
pub mod excitation;
pub mod gradient;

use nalgebra::allocator::Allocator;
use nalgebra::{DefaultAllocator, Dim, OMatrix, OVector, RealField};

use crate::dense::choose;

/// Every shape of a regression with `R` rows and `Q` parameters can be stored. Never implement it yourself.
#[diagnostic::on_unimplemented(
    message = "not every column and matrix of a regression of these sizes can be stored",
    note = "sizes `nalgebra::Const` and, with the feature `alloc`, `nalgebra::Dyn` can be stored in all combinations",
    note = "code that is generic in the sizes needs the bound `DefaultAllocator: RegressionSize<R, Q>`"
)]
pub trait RegressionSize<R: Dim, Q: Dim>:
    Allocator<R> + Allocator<Q> + Allocator<R, Q> + Allocator<Q, R> + Allocator<Q, Q>
{
}

impl<R: Dim, Q: Dim> RegressionSize<R, Q> for DefaultAllocator where
    DefaultAllocator: Allocator<R> + Allocator<Q> + Allocator<R, Q> + Allocator<Q, R> + Allocator<Q, Q>
{
}

/// An estimator of theta in `Y = M theta`, with `R` rows and `Q` parameters.
///
/// Slices have the length [`state_len`](Self::state_len); the first q entries of the state are theta_hat.
pub trait ParameterEstimator<T: RealField + Copy, R: Dim, Q: Dim>
where
    DefaultAllocator: RegressionSize<R, Q>,
{
    /// The length of the state as a dimension.
    type Length: Dim;

    /// The length of the state, for regressions with `rows` rows.
    fn state_len(&self, rows: usize) -> usize;

    /// Number of parameters q.
    fn parameters(&self) -> usize;

    /// Writes the rate of the state, given `Y` and `M`.
    fn rate(&self, state: &[T], y: &OVector<T, R>, m: &OMatrix<T, R, Q>, rate: &mut [T]);

    /// A measure of the excitation of the regression that is 0 if and only if some direction of theta is not excited;
    /// each estimator defines it. `None` if the estimator does not compute one.
    fn excitation(&self, state: &[T], m: &OMatrix<T, R, Q>) -> Option<T>;

    /// Moves the state to the coordinates `theta - delta`, in which the regression is
    /// `Y - M delta = M (theta - delta)`: theta_hat decreases by delta, and what the estimator keeps of Y changes with
    /// it. The error stays the same.
    fn shift(&self, state: &mut [T], delta: &OVector<T, Q>);
}

/// The first entries of a slice as a column as long as `like` has columns.
fn leading<T: RealField + Copy, R: Dim, Q: Dim>(state: &[T], like: &OMatrix<T, R, Q>) -> OVector<T, Q>
where
    DefaultAllocator: Allocator<R, Q> + Allocator<Q>,
{
    OVector::from_fn_generic(like.shape_generic().1, nalgebra::U1, |i, _| state[i])
}

/// The rate, or 0 where it has overflown: a state stands still rather than become NaN.
pub fn finite_or_zero<T: RealField + Copy>(rate: T) -> T {
    choose(|| rate.is_finite(), rate, T::zero())
}
