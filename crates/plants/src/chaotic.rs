//! The chaotic plant of Example 1 of the mean-value-theorem paper.

use nalgebra::convert;

/// `x1' = ln(0.1 + exp(x2 - x1))`, `x2' = x1 x3`, `x3' = 0.2 - x1 x2`, `y = (x1, x2)`: eq. (22); no input.
///
/// Sprott's flow of no linear term. `x2^2 + x3^2` changes at the rate `0.4 x3` only, so that trajectories stay bounded
/// over any finite time.
///
/// ```
/// use luenberger_plants::{Chaotic, Plant};
/// use nalgebra::{SVector, Vector3};
/// let slope = Chaotic.derivative(0.0, &Vector3::new(1.0, 1.0, 3.0), &SVector::zeros());
/// assert!((slope - Vector3::new(1.1f64.ln(), 3.0, -0.8)).amax() <= f64::EPSILON);
/// ```
///
/// Source: R. Ben Messaoud and S. Hajji, WSEAS Transactions on Systems 17, 2018, Example 1.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Chaotic;

crate::plant!(
    Chaotic,
    (3, 0, 2),
    |plant, t, x, u| {
        let (tenth, fifth): (T, T) = (convert(0.1), convert(0.2));
        let d = x[1] - x[0];
        // Both branches are the printed function; the second does not overflow for large d.
        let first = if d < T::one() { (tenth + d.exp()).ln() } else { d + (tenth * (-d).exp()).ln_1p() };
        [first, x[0] * x[2], fifth - x[0] * x[1]]
    },
    [x[0], x[1]]
);
