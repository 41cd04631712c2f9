//! Numbers in formulas in their usual form: `2P`, not `2(1e0)P`.

use luenberger_proof::wording::{self, shortest, significant};
use nalgebra::Complex;

/// `x` in front of a symbol: nothing for 1.
///
/// ```
/// use luenberger_design::number::coefficient;
/// assert_eq!(format!("{}P, {}P", coefficient(2.0), coefficient(1.0)), "2P, P");
/// ```
pub fn coefficient(x: f64) -> String {
    if x == 1.0 { String::new() } else { shortest(x) }
}

/// `exp(-rate t)`; for the rate 0, of which the strict inequality is proved, that the error tends to 0.
///
/// ```
/// use luenberger_design::number::decay;
/// assert_eq!([decay(0.1), decay(1.0), decay(0.0)], ["exp(-0.1 t)", "exp(-t)", "and tends to 0"]);
/// ```
pub fn decay(rate: f64) -> String {
    if rate == 0.0 {
        "and tends to 0".to_owned()
    } else if rate == 1.0 {
        "exp(-t)".to_owned()
    } else {
        format!("exp(-{} t)", shortest(rate))
    }
}

/// A number of a message, with three significant digits.
pub(crate) fn short(x: f64) -> String {
    significant(x, 3)
}

/// A complex number of a message, with six significant digits.
pub(crate) fn complex(z: Complex<f64>) -> String {
    wording::complex([z.re, z.im], 6)
}
