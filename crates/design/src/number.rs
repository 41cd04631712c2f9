//! Numbers in sentences and formulas, as people write them: `11.904` and `2P`, not `1.1904e1` and `2(1e0)P`.

/// Magnitudes that are written without an exponent.
fn is_moderate(x: f64) -> bool {
    x == 0.0 || (1e-4..1e7).contains(&x.abs())
}

/// The shortest decimal that reads back as `x`, in scientific notation only where it is very large or very small.
///
/// ```
/// use luenberger_design::number::shortest;
/// assert_eq!([shortest(0.1), shortest(2.0), shortest(-0.25), shortest(1e-9), shortest(3e8)], ["0.1", "2", "-0.25", "1e-9", "3e8"]);
/// ```
pub fn shortest(x: f64) -> String {
    if is_moderate(x) || !x.is_finite() { x.to_string() } else { format!("{x:e}") }
}

/// `x` to so many significant digits, without trailing zeros.
///
/// ```
/// use luenberger_design::number::significant;
/// assert_eq!([significant(11.904_37, 5), significant(0.098_457_4, 4), significant(10.0, 4)], ["11.904", "0.09846", "10"]);
/// assert_eq!([significant(2.5e-13, 4), significant(9.999_96e6, 5), significant(f64::INFINITY, 3)], ["2.5e-13", "1e7", "inf"]);
/// ```
pub fn significant(x: f64, digits: usize) -> String {
    // What is written so is read back as the nearest double, whose shortest decimal has no more digits.
    let rounded = format!("{x:.*e}", digits.saturating_sub(1)).parse().unwrap_or(x);
    shortest(rounded)
}

/// `x` in front of a symbol: nothing for 1.
///
/// ```
/// use luenberger_design::number::coefficient;
/// assert_eq!(format!("{}P, {}P", coefficient(2.0), coefficient(1.0)), "2P, P");
/// ```
pub fn coefficient(x: f64) -> String {
    if x == 1.0 { String::new() } else { shortest(x) }
}

/// `exp(-rate t)`.
///
/// ```
/// use luenberger_design::number::decay;
/// assert_eq!([decay(0.1), decay(1.0)], ["exp(-0.1 t)", "exp(-t)"]);
/// ```
pub fn decay(rate: f64) -> String {
    if rate == 1.0 { "exp(-t)".to_owned() } else { format!("exp(-{} t)", shortest(rate)) }
}
