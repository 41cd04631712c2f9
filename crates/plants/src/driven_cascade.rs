//! A plant of the class of Proposition 7 of the [KKL+PEB]-observer paper: two stable blocks in cascade, and two states
//! that are only integrated.
//!
//! Source of the class: B. Yi, R. Ortega and W. Zhang, IEEE Transactions on Automatic Control, 2018, Proposition 7.

use nalgebra::{Vector2, convert};

/// `x11' = -x11 + x3 + u'x4`, `x12' = -2 x12 + x2`, `x2' = -x2 + sin x12`, `x3' = -3 x3 + x2 x11`, `x4' = -u x11/2`,
/// `y = (x11, x12)`.
///
/// The state is (x11, x12, x2, x3, x4) with x4 of length 2, the length of u. x4 is observable as far as u is
/// exciting: both entries under `u = (sin 2t, 1)`, one entry under `u = (1, 0)`.
///
/// ```
/// use luenberger_plants::{DrivenCascade, Plant};
/// use nalgebra::{SVector, Vector2};
/// let x = SVector::from([1.0, 0.0, 3.0, 4.0, 5.0, 6.0]);
/// let slope: SVector<f64, 6> = DrivenCascade.derivative(0.0, &x, &Vector2::new(1.0, 2.0));
/// assert_eq!(slope, SVector::from([20.0, 3.0, -3.0, -9.0, -0.5, -1.0]));
/// ```
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct DrivenCascade;

crate::plant!(
    DrivenCascade,
    (6, 2, 2),
    |plant, t, x, u| {
        let [half, two, three] = [0.5, 2.0, 3.0].map(convert::<f64, T>);
        let [x11, x12, x2, x3] = [x[0], x[1], x[2], x[3]];
        let x4 = Vector2::new(x[4], x[5]);
        let rate = u * (-half * x11);
        [x3 - x11 + u.dot(&x4), x2 - two * x12, x12.sin() - x2, x2 * x11 - three * x3, rate[0], rate[1]]
    },
    [x[0], x[1]]
);
