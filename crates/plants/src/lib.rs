//! Plants: the traits a plant implements, and the benchmark plants of the observer literature.
//!
//! A plant is data and a right-hand side, `x' = f(t, x, u)`, `y = h(t, x, u)`; observers are separate. The crate is
//! `no_std`; sizes are known at compile time ([`nalgebra::Const`]) on a target, or at run time ([`nalgebra::Dyn`],
//! feature `alloc`) on a workstation, with the same code.
//!
//! | file | subject |
//! |---|---|
//! | [`mod@angle`] | differences of angles, modulo a full turn |
//! | [`binary32`] | `sin`, `cos`, `tan`, `asin` in binary32 arithmetic alone |
//! | [`mod@column`] | the trait of vectors of states, inputs and outputs |
//! | [`size`] | the trait bound that stands for nalgebra's allocators |
//! | [`mod@plant`] | the traits [`Plant`] and [`Shape`] |
//! | [`closures`] | a plant from two closures |
//! | [`equations`] | a plant from its equations, for every scalar |
//! | [`linear`] | `x' = A x + B u`, `y = C x + D u` |
//! | [`mod@straight_line`] | a plant from four functions on arrays, as exports have it |
//! | [`coordinates`] | a plant in other linear coordinates, `x = T z` |
//! | [`jacobian`] | `df/dx` and `dh/dx` by dual numbers (feature `dual`), linearisation at a point |
//! | [`mod@double_integrator`], [`third_order`] | the plants of the cubic-observer paper |
//! | [`chaotic`], [`flexible_joint`] | the plants of the mean-value-theorem paper |
//! | [`counterexamples`] | small plants on which the mean-value-theorem observer fails |
//! | [`cuk`], [`exponential_cascade`], [`driven_cascade`] | the plants of the [KKL+PEB]-observer paper: the Cuk converter with its controller, Proposition 6's, and one of Proposition 7's class |
//! | `serialization` (feature `serde`) | linear plants in files: matrices by rows, read through the constructor |
//! | [`mod@real_field`] | other scalars than numbers, from a few operations |
//! | [`text`] | linear plants and matrices as text |
//! | [`oscillators`] | the reverse Duffing oscillator and Van der Pol's |

#![no_std]
#![deny(missing_docs)]

#[cfg(feature = "alloc")]
extern crate alloc;

pub mod angle;
pub mod binary32;
pub mod chaotic;
pub mod closures;
pub mod column;
pub mod coordinates;
pub mod counterexamples;
pub mod cuk;
pub mod double_integrator;
pub mod driven_cascade;
pub mod equations;
pub mod error;
pub mod exponential_cascade;
pub mod flexible_joint;
pub mod jacobian;
pub mod linear;
pub mod oscillators;
pub mod plant;
pub mod real_field;
#[cfg(feature = "serde")]
pub mod serialization;
pub mod size;
pub mod straight_line;
pub mod text;
pub mod third_order;

pub use angle::wrap;
pub use chaotic::Chaotic;
pub use closures::{FromFn, from_fn};
pub use column::Column;
pub use coordinates::InCoordinates;
pub use cuk::CukConverter;
pub use double_integrator::double_integrator;
pub use driven_cascade::DrivenCascade;
pub use error::PlantError;
pub use exponential_cascade::ExponentialCascade;
pub use flexible_joint::FlexibleJoint;
pub use jacobian::{ByDual, Differentiable, state_jacobian};
#[cfg(feature = "dual")]
pub use jacobian::{Dual64, linearize};
#[cfg(feature = "alloc")]
pub use linear::StateSpace;
pub use linear::{LinearPlant, StaticPlant};
pub use oscillators::{ReverseDuffing, VanDerPol};
pub use plant::{Dimensions, Plant, Shape};
pub use size::Size;

/// nalgebra, in the version of the columns and matrices of this crate.
pub use nalgebra;

/// The example of `README.md`, compiled and run with the documentation's tests.
#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct Readme;
