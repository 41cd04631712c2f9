//! The numerical Kazantzis-Kravaris-Luenberger observer: `z' = D z + B y`, `xhat = T^-L(z)`, for a plant without a
//! closed form of T.
//!
//! D is Hurwitz (n_z x n_z), (D, B) controllable, and T maps states to target states: `DT(x) f(x) = D T(x) + B h(x)`.
//! Then `z - T(x)` obeys `e' = D e`, whatever the plant: the convergence of z is *linear*, and all that is left to do
//! is to undo T. T and its left inverse are computed beforehand (`luenberger-design`, `numerical_kkl`); here are the
//! left inverses that then run, as [`LeftInverse`](crate::kkl::LeftInverse) of [`LinearKkl`].
//!
//! | file | subject |
//! |---|---|
//! | [`coordinates`] | z in coordinates in which every direction of T(box) counts |
//! | [`held_inputs`] | the observer for inputs that are held: T as a function of state and input |
//! | [`held_trees`] | its embedded form, by trees alone |
//! | [`polynomial_tree`] | the embedded form: a tree of small polynomials, from z straight to xhat |
//! | [`sampled`], [`sampled_held`] | the observer stepped once per sample, without inputs and for held ones |
//! | [`spline`] | T itself, interpolated by tensor cubic splines |
//! | [`tensor_train`] | T of low rank, for more states than a grid of splines can hold |
//! | [`least_squares`] | the interpolated form: `min |T(x) - z|` over the box by damped Gauss-Newton steps |
//!
//! Sizes are compile-time constants and coefficients are anything that lends a slice (`&'static [f32]` in flash, a
//! `Vec` on a workstation): nothing allocates, nothing panics, and a target state that is far away or overflows gives
//! an estimate in the box.
//!
//! Sources: N. Kazantzis and C. Kravaris, Systems & Control Letters 34, 1998; V. Andrieu and L. Praly, SIAM Journal on
//! Control and Optimization 45, 2006.

pub mod coordinates;
pub mod held_inputs;
pub mod held_trees;
pub mod least_squares;
pub mod polynomial_tree;
pub mod sampled;
pub mod sampled_held;
pub mod spline;
pub mod tensor_train;

use nalgebra::Const;

use crate::kkl::{KklObserver, LinearKkl};

pub use coordinates::Coordinates;
pub use held_inputs::{HeldInputInverse, HeldInputObserver, HeldInputTables};
pub use held_trees::HeldInputTrees;
pub use least_squares::{BoxMap, InterpolatedInverse, LeastSquares, Search};
pub use polynomial_tree::{Branch, Node, PolynomialInverse, PolynomialTree};
pub use sampled::{SampledFilter, SampledKkl, StateInverse};
pub use sampled_held::{HeldStateInverse, SampledHeldKkl};
pub use spline::TensorSpline;
pub use tensor_train::TensorTrain;

/// `z' = D z + B y`, `xhat = T^-L(z)` for a plant of N states, M inputs, P outputs, with Z target states and the left
/// inverse `I` ([`PolynomialInverse`] or [`InterpolatedInverse`]).
///
/// The input is not used: T belongs to the plant at one constant input u0 ([`HeldInputObserver`] takes others). With
/// another, `e = z - T(x)` obeys
/// `e' = D e - DT(x) (f(x, u) - f(x, u0))`, and does not tend to zero.
pub type NumericalKklObserver<I, T, const N: usize, const M: usize, const P: usize, const Z: usize> =
    KklObserver<LinearKkl<T, Const<Z>, Const<M>, Const<P>, Const<N>, I>>;
