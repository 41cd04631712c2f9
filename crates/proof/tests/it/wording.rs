//! Decimals of binary64 numbers, compared with them exactly.

use luenberger_proof::wording::{at_least, at_most, exact};
use luenberger_proof::{Exact, Ring};
use proptest::prelude::*;

/// The exact value of a decimal in comparison with that of `x`: both times a power of ten that makes the decimal an
/// integer.
fn compare(decimal: &str, x: f64) -> core::cmp::Ordering {
    let (mantissa, exponent) = decimal.split_once('e').unwrap_or((decimal, "0"));
    let (whole, fraction) = mantissa.split_once('.').unwrap_or((mantissa, ""));
    let exponent = exponent.parse::<i32>().unwrap() - i32::try_from(fraction.len()).unwrap();
    let ten = Exact::from_f64(10.0).unwrap();
    let power = |k: i32| (0..k).fold(Exact::from_f64(1.0).unwrap(), |p, _| p.mul(&ten));
    let negative = whole.starts_with('-');
    let digits = format!("{whole}{fraction}");
    let integer = digits.bytes().filter(u8::is_ascii_digit).fold(Exact::from_f64(0.0).unwrap(), |sum, byte| {
        sum.mul(&ten).add(&Exact::from_f64(f64::from(byte - b'0')).unwrap())
    });
    let integer = if negative { integer.neg() } else { integer };
    let left = integer.mul(&power(exponent));
    let right = Exact::from_f64(x).unwrap().mul(&power(-exponent));
    left.add(&right.neg()).signum().cmp(&0)
}

proptest! {
    #[test]
    fn rounding_is_to_the_safe_side(x in prop_oneof![-1e3..1e3_f64, any::<f64>()], digits in 1..8_usize) {
        prop_assert!(compare(&at_least(x, digits), x).is_le(), "{} of {x:e}", at_least(x, digits));
        prop_assert!(compare(&at_most(x, digits), x).is_ge(), "{} of {x:e}", at_most(x, digits));
        prop_assert!((at_least(x, digits).parse::<f64>().unwrap() - x).abs() <= 10.1 * x.abs() * 10_f64.powi(-i32::try_from(digits).unwrap()));
    }

    /// Without a hexadecimal form the decimal is the number, to the last bit.
    #[test]
    fn exact_decimals_are_exact(x in prop_oneof![-1e3..1e3_f64, any::<f64>(), (-1_000_000..1_000_000_i32).prop_map(|k| f64::from(k) / 64.0)]) {
        let text = exact(x);
        if !text.contains("0x") {
            prop_assert!(compare(&text, x).is_eq(), "{text} of {x:e}");
        }
    }
}
