//! Two oscillators with one measured coordinate: test plants of numerical Kazantzis-Kravaris-Luenberger observers.
//!
//! Neither has an input. Both have an invariant compact set, which those observers require.
//!
//! Sources: M. Buisson-Fenet, L. Bahr, V. Morgenthaler and F. Di Meglio, Towards gain tuning for numerical KKL
//! observers, IFAC World Congress 2023, for the reverse Duffing oscillator; B. van der Pol, On relaxation-oscillations,
//! Philosophical Magazine 2, 1926.

use nalgebra::{RealField, Vector2, convert};

/// The reverse Duffing oscillator: `x1' = x2^3`, `x2' = -x1`, `y = x1`.
///
/// `x1^2/2 + x2^4/4` is constant along every solution ([`energy`](Self::energy)), so that all solutions are periodic.
/// It is observable, but not uniformly: `y' = x2^3` says little about x2 near 0.
///
/// ```
/// use luenberger_plants::{Plant, ReverseDuffing};
/// use nalgebra::{SVector, Vector2};
/// let x = Vector2::new(1.0, 2.0);
/// let slope = ReverseDuffing.derivative(0.0, &x, &SVector::zeros());
/// assert_eq!(slope, Vector2::new(8.0, -1.0));
/// // The gradient of the energy is (x1, x2^3).
/// assert_eq!(slope.dot(&Vector2::new(1.0, 8.0)), 0.0);
/// assert_eq!(ReverseDuffing::energy(&x), 4.5);
/// ```
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct ReverseDuffing;

impl ReverseDuffing {
    /// `x1^2/2 + x2^4/4`, constant along every solution.
    pub fn energy<T: RealField + Copy>(x: &Vector2<T>) -> T {
        let square = x[1] * x[1];
        x[0] * x[0] * convert(0.5) + square * square * convert(0.25)
    }
}

crate::plant!(ReverseDuffing, (2, 0, 1), |plant, t, x, u| [x[1] * x[1] * x[1], -x[0]], [x[0]]);

/// Van der Pol's oscillator: `x1' = x2`, `x2' = mu (1 - x1^2) x2 - x1`, `y = x1`; mu = 1 by default.
///
/// For mu > 0 every solution tends to one limit cycle, except the equilibrium at the origin.
///
/// ```
/// use luenberger_plants::{Plant, VanDerPol};
/// use nalgebra::{SVector, Vector2};
/// let slope = VanDerPol { mu: 2.0 }.derivative(0.0, &Vector2::new(2.0, 1.0), &SVector::zeros());
/// assert_eq!(slope, Vector2::new(1.0, -8.0));
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct VanDerPol {
    /// Strength of the damping, negative inside the strip |x1| < 1 and positive outside.
    pub mu: f64,
}

impl Default for VanDerPol {
    fn default() -> Self {
        Self { mu: 1.0 }
    }
}

crate::plant!(
    VanDerPol,
    (2, 0, 1),
    |plant, t, x, u| [x[1], convert::<f64, T>(plant.mu) * (T::one() - x[0] * x[0]) * x[1] - x[0]],
    [x[0]]
);
