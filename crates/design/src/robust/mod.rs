//! How much uncertainty a cubic observer tolerates: Theorems 4 and 5, and the exact margins behind them.
//!
//! For `A(eps) = A + eps I` and an observer with the nominal A, the error obeys `e' = F e + (y~'theta y~) N y~ + eps
//! x`: it tends to zero only if x does. Every margin here guarantees exponential stability of `e' = (F + eps I) e +
//! (y~'theta y~) N y~`, and input-to-state stability with respect to the forcing ([`input_to_state_gain`]), for the
//! cubic observer as for the linear one.
//!
//! In increasing order of freedom:
//!
//! | margin | P | N |
//! |---|---|---|
//! | [`theorem5_bound`] | fixed, only its largest eigenvalue used | fixed |
//! | [`fixed_lyapunov_margin`] | fixed | fixed |
//! | [`fixed_gain_margin`]; for p = 1 also [`positive_real_margin`] | free | fixed |
//! | [`redesigned_margin`] | free | free |

mod bounds;
mod fixed_gain;
mod polytope;
mod positive_real;

pub(crate) use bounds::greatest_rate;
pub use bounds::{fixed_lyapunov_margin, input_to_state_gain, redesigned_margin, theorem5_bound};
pub(crate) use fixed_gain::orthogonal_rows;
pub use fixed_gain::{FixedGainMargin, GainCertificate, certify_gain, fixed_gain_margin};
pub use polytope::PolytopicDesign;
pub use positive_real::positive_real_margin;
