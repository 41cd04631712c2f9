//! A plant that neither a KKL nor a parameter-estimation-based observer can observe, but their combination can.
//!
//! Source: B. Yi, R. Ortega and W. Zhang, IEEE Transactions on Automatic Control, 2018, Proposition 6.

/// `x1' = -x1^3 + exp(x3)`, `x2' = -x2 + x1^2 + sin x1`, `x3' = 1/(x1^2 + 1) + x1 u`, `y = x1`: eq. (31).
///
/// x2 forgets where it started, x3 does not. Without input x3 grows for ever; `u = -y` keeps the plant bounded, because
/// `x3' = 1/(x1^2 + 1) - x1^2` is then negative as soon as x1 is large.
///
/// ```
/// use luenberger_plants::{ExponentialCascade, Plant};
/// use nalgebra::{Vector1, Vector3};
/// let slope = ExponentialCascade.derivative(0.0, &Vector3::new(1.0, 2.0, 0.0), &Vector1::new(-1.0));
/// assert_eq!(slope, Vector3::new(0.0, -1.0 + 1f64.sin(), -0.5));
/// ```
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct ExponentialCascade;

crate::plant!(
    ExponentialCascade,
    (3, 1, 1),
    |plant, t, x, u| {
        let square = x[0] * x[0];
        [x[2].exp() - square * x[0], square + x[0].sin() - x[1], T::one() / (square + T::one()) + x[0] * u[0]]
    },
    [x[0]]
);
