//! The smallest plants on which the mean-value-theorem observer, as printed, fails.
//!
//! Theorem 1 of the paper says that the estimate converges whenever the measured states come first and f is
//! continuously differentiable. Each of these plants satisfies that, and for each there are starts from which the
//! estimate does not converge; `docs/theory-mvt.md` of the repository says why. Two more counterexamples are plants
//! in other files: [`double_integrator`](crate::double_integrator()) and [`Chaotic`](crate::Chaotic).
//!
//! | plant | reason of the failure |
//! |---|---|
//! | [`integrator`] | Df = 0 leaves a gain of 0 |
//! | [`unstable`] | an error in the unknown x2(0) grows |
//! | [`stable`] | a gain in the measured row alone can destabilise |
//! | [`Bistable`] | the gain vanishes before the estimate arrives |
//! | [`Dimple`] | a least-squares solver for beta stops short of the root that exists |
//!
//! Source of the theorem: R. Ben Messaoud and S. Hajji, WSEAS Transactions on Systems 17, 2018.

use nalgebra::{Matrix1, Matrix2, RowVector2, SMatrix, convert};

use crate::linear::{LinearPlant, StaticPlant};

/// `x' = u`, `y = x`: the measured state itself is missed.
pub fn integrator() -> StaticPlant<f64, 1, 1, 1> {
    LinearPlant { a: Matrix1::new(0.0), b: Matrix1::new(1.0), c: Matrix1::new(1.0), d: None }
}

/// `x1' = x2`, `x2' = x2/2`, `y = x1`: observable, with poles at 0 and 1/2.
pub fn unstable() -> StaticPlant<f64, 2, 0, 1> {
    measured_first(Matrix2::new(0.0, 1.0, 0.0, 0.5))
}

/// `x1' = -3 x1 + 2 x2`, `x2' = -2 x1 + x2`, `y = x1`: observable, with both poles at -1, although x2 alone is
/// unstable.
pub fn stable() -> StaticPlant<f64, 2, 0, 1> {
    measured_first(Matrix2::new(-3.0, 2.0, -2.0, 1.0))
}

fn measured_first(a: Matrix2<f64>) -> StaticPlant<f64, 2, 0, 1> {
    LinearPlant { a, b: SMatrix::zeros(), c: RowVector2::new(1.0, 0.0), d: None }
}

/// `x' = x - x^3`, `y = x`: every solution that does not start at 0 goes to 1 or to -1.
///
/// ```
/// use luenberger_plants::{Plant, counterexamples::Bistable};
/// use nalgebra::{SVector, Vector1};
/// assert_eq!(Bistable.derivative(0.0, &Vector1::new(2.0), &SVector::zeros()), Vector1::new(-6.0));
/// ```
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Bistable;

/// `x' = d^3/3 - 2 d^5` with `d = x - 1/2`, `y = x`: between 0 and 1 the slope `d^2 - 10 d^4` has the mean -1/24, and a
/// local minimum above it at d = 0.
///
/// ```
/// use luenberger_plants::{Plant, counterexamples::Dimple};
/// use nalgebra::{SVector, Vector1};
/// let slope: Vector1<f64> = Dimple.derivative(0.0, &Vector1::new(1.0), &SVector::zeros());
/// assert!((slope[0] + 1.0 / 48.0).abs() <= f64::EPSILON);
/// ```
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Dimple;

crate::plant!(Bistable, (1, 0, 1), |plant, t, x, u| [x[0] - x[0] * x[0] * x[0]], *x);
crate::plant!(
    Dimple,
    (1, 0, 1),
    |plant, t, x, u| {
        let (half, third, two): (T, T, T) = (convert(0.5), convert(1.0 / 3.0), convert(2.0));
        let d = x[0] - half;
        [d * d * d * (third - two * d * d)]
    },
    *x
);
