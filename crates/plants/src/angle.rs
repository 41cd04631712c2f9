//! Angles: differences modulo a full turn.
//!
//! ```text
//! w(x) = x + turn floor(1/2 - x/turn),   in (-turn/2, turn/2]
//! ```
//!
//! Half a turn stays half a turn, and minus half a turn becomes it. What lies in the interval is returned as it is, to
//! the last bit. Elsewhere the error is that of the multiple of the turn, about `epsilon |x|`; the end of the interval
//! is that of the rounded quotient, so that a result can be beyond it by a rounding. A full turn of 0 stands for what
//! is no angle. NaN and infinities are NaN.

use nalgebra::{ComplexField, RealField, convert};

/// x less the multiple of the full turn nearest to it: an angle in (-turn/2, turn/2]; x itself if the turn is 0.
///
/// ```
/// use luenberger_plants::wrap;
/// // From 359 degrees to 1 degree is 2 degrees.
/// assert_eq!(wrap(1.0 - 359.0, 360.0), 2.0);
/// assert_eq!((wrap(180.0, 360.0), wrap(-180.0, 360.0)), (180.0, 180.0));
/// assert_eq!(wrap(1000.0, 0.0), 1000.0);
/// ```
pub fn wrap<T: RealField + Copy>(x: T, turn: T) -> T {
    if turn == T::zero() { x } else { wrapped(x, turn, ComplexField::floor) }
}

/// The same for a turn that is not 0, with the `floor` of a scalar that has none of its own.
pub fn wrapped<T: RealField + Copy>(x: T, turn: T, floor: impl Fn(T) -> T) -> T {
    x + turn * floor(convert::<f64, T>(0.5) - x / turn)
}
