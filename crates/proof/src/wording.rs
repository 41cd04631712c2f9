//! Formatted numbers: exact or rounded to the safe side in statements, with few digits elsewhere.
//!
//! A statement about stored numbers must contain exactly these. [`exact`] writes a binary64 number without loss. In a
//! conclusion [`at_least`] and [`at_most`] write a short decimal that is not above, or not below, the number: a margin,
//! and a bound. In a hypothesis it is the other way round: [`if_at_most`] and [`if_at_least`] write a decimal for which
//! the printed hypothesis implies that of the number. The others are those of the crate `luenberger-wording`.

pub use luenberger_wording::{
    capital, complex, counted, entry, is_invisible, quoted, rounded, shortest, significant, visible,
};

use crate::number::Number;

/// Significant digits that distinguish all binary64 numbers: the exact expansion of one has at most 767.
const ALL_DIGITS: usize = 780;

/// The exact value of `x`: a decimal if a short one is exact, else hexadecimal digits and a power of two, followed by
/// the shortest decimal that reads back as `x`.
///
/// ```
/// use luenberger_proof::wording::exact;
/// assert_eq!([exact(0.5), exact(-3.0), exact(1e22)], ["0.5", "-3", "1e22"]);
/// assert_eq!(exact(0.3), "0x1.3333333333333p-2 (about 0.3)");
/// ```
pub fn exact(x: f64) -> String {
    let shortest = shortest(x);
    match Number::from_f64(x) {
        Some(number) if digits(&format!("{x:e}")) != digits(&format!("{x:.ALL_DIGITS$e}")) => {
            format!("{number} (about {shortest})")
        }
        _ => shortest,
    }
}

/// The digits of a number in scientific notation, without trailing zeros.
fn digits(scientific: &str) -> &str {
    let mantissa = scientific.split('e').next().unwrap_or_default();
    if mantissa.contains('.') { mantissa.trim_end_matches('0').trim_end_matches('.') } else { mantissa }
}

/// A decimal of so many significant digits that is at most `x`: for a margin, which may only be rounded down.
///
/// ```
/// use luenberger_proof::wording::at_least;
/// assert_eq!([at_least(0.769_999, 3), at_least(2.0, 3), at_least(-1.0004, 3)], ["0.769", "2", "-1.01"]);
/// assert_eq!(at_least(9.999_9e-7, 2), "9.9e-7");
/// ```
pub fn at_least(x: f64, digits: usize) -> String {
    decimal(x, digits, x < 0.0)
}

/// A decimal of so many significant digits that is at least `x`: for a bound of an error.
///
/// ```
/// use luenberger_proof::wording::at_most;
/// assert_eq!([at_most(0.769_101, 3), at_most(2.0, 3), at_most(9.991, 3), at_most(f64::INFINITY, 3)], ["0.77", "2", "10", "inf"]);
/// ```
pub fn at_most(x: f64, digits: usize) -> String {
    decimal(x, digits, x > 0.0)
}

/// A decimal of so many significant digits for a hypothesis "at most `x`": it is at most `x`, so that what satisfies
/// the printed bound satisfies that of `x`.
///
/// ```
/// use luenberger_proof::wording::if_at_most;
/// // 1.2 * 0.01 is above 0.012 by a rounding error, and 0.0121 would be no bound that was supposed.
/// assert_eq!([if_at_most(1.2 * 0.01, 3), if_at_most(0.769_999, 3), if_at_most(2.0, 3)], ["0.012", "0.769", "2"]);
/// ```
pub fn if_at_most(x: f64, digits: usize) -> String {
    at_least(x, digits)
}

/// A decimal of so many significant digits for a hypothesis "at least `x`": it is at least `x`.
///
/// ```
/// use luenberger_proof::wording::if_at_least;
/// assert_eq!([if_at_least(0.1, 3), if_at_least(0.769_101, 3), if_at_least(-1.239, 3)], ["0.101", "0.77", "-1.23"]);
/// ```
pub fn if_at_least(x: f64, digits: usize) -> String {
    at_most(x, digits)
}

/// The first digits of `x`, with one unit added to the last one where others follow and the magnitude is to be rounded
/// up.
fn decimal(x: f64, significant: usize, away_from_zero: bool) -> String {
    if x == 0.0 || !x.is_finite() {
        return format!("{x}");
    }
    let expansion = format!("{:.ALL_DIGITS$e}", x.abs());
    let (mantissa, exponent) = expansion.split_once('e').unwrap_or((&expansion, "0"));
    let mut exponent: i32 = exponent.parse().unwrap_or(0);
    let all: Vec<u8> = mantissa.bytes().filter(u8::is_ascii_digit).map(|byte| byte - b'0').collect();
    let (kept, rest) = all.split_at(significant.clamp(1, all.len()));
    let mut kept = kept.to_vec();
    if away_from_zero && rest.iter().any(|digit| *digit != 0) {
        let mut carried = true;
        for digit in kept.iter_mut().rev() {
            carried = *digit == 9;
            *digit = if carried { 0 } else { *digit + 1 };
            if !carried {
                break;
            }
        }
        if carried {
            kept.insert(0, 1);
            exponent += 1;
        }
    }
    while kept.len() > 1 && kept.last() == Some(&0) {
        kept.pop();
    }
    let sign = if x < 0.0 { "-" } else { "" };
    let text: String = kept.iter().map(|digit| char::from(b'0' + digit)).collect();
    let (first, others) = text.split_at(1);
    let point = if others.is_empty() { "" } else { "." };
    match exponent {
        -4..=-1 => format!("{sign}0.{}{text}", "0".repeat((-exponent - 1) as usize)),
        0..=6 => {
            let whole = exponent as usize + 1;
            if text.len() <= whole {
                format!("{sign}{text}{}", "0".repeat(whole - text.len()))
            } else {
                format!("{sign}{}.{}", &text[..whole], &text[whole..])
            }
        }
        _ => format!("{sign}{first}{point}{others}e{exponent}"),
    }
}
