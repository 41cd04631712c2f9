//! A certificate as a JSON document, read without `luenberger-proof`: hexadecimal floats, integers, fractions, and
//! intervals, from which a number is sampled.

use dashu_int::{IBig, UBig};
use luenberger_random::Random;
use serde_json::Value;

use super::exact::Exact;

/// The rational number of a text; `None` if it is not one.
pub(super) fn number(text: &str) -> Option<Exact> {
    let (negative, magnitude) = text.strip_prefix('-').map_or((false, text), |rest| (true, rest));
    let signed = |x: UBig| if negative { -IBig::from(x) } else { IBig::from(x) };
    if let Some(hexadecimal) = magnitude.strip_prefix("0x") {
        let (digits, exponent) = hexadecimal.split_once('p')?;
        let (whole, part) = digits.split_once('.').unwrap_or((digits, ""));
        let mantissa = UBig::from_str_radix(&format!("{whole}{part}"), 16).ok()?;
        let exponent: i64 = exponent.parse().ok()?;
        return Some(Exact::rational(signed(mantissa), exponent - 4 * i64::try_from(part.len()).ok()?, IBig::ONE));
    }
    let (numerator, denominator) = magnitude.split_once('/').unwrap_or((magnitude, "1"));
    let integer = |text: &str| UBig::from_str_radix(text, 10).ok().filter(|_| text.bytes().all(|b| b.is_ascii_digit()));
    let denominator = IBig::from(integer(denominator)?);
    (!denominator.is_zero()).then_some(Exact::rational(signed(integer(numerator)?), 0, denominator))
}

/// The binary64 number that a hexadecimal float is.
pub(super) fn float(text: &str) -> Option<f64> {
    let (negative, magnitude) = text.strip_prefix('-').map_or((false, text), |rest| (true, rest));
    let (digits, exponent) = magnitude.strip_prefix("0x")?.split_once('p')?;
    let (whole, part) = digits.split_once('.').unwrap_or((digits, ""));
    let mantissa = u64::from_str_radix(&format!("{whole}{part}"), 16).ok()?;
    let mut exponent: i32 = exponent.parse::<i32>().ok()? - 4 * i32::try_from(part.len()).ok()?;
    let mut x = mantissa as f64;
    // In steps, of which none rounds: the number is one of binary64.
    while exponent != 0 {
        let step = exponent.clamp(-500, 500);
        x *= 2.0_f64.powi(step);
        exponent -= step;
    }
    Some(if negative { -x } else { x })
}

/// The hexadecimal float of a binary64 number, as an integer times a power of two.
pub(super) fn hexadecimal(x: f64) -> Value {
    let bits = x.to_bits() & !(1 << 63);
    let (biased, fraction) = ((bits >> 52).cast_signed(), bits & ((1 << 52) - 1));
    let (digits, exponent) = if biased == 0 { (fraction, -1074) } else { (fraction | 1 << 52, biased - 1075) };
    let zeros = if digits == 0 { 0 } else { digits.trailing_zeros() };
    let sign = if x.is_sign_negative() && digits != 0 { "-" } else { "" };
    let exponent = if digits == 0 { 0 } else { exponent + i64::from(zeros) };
    Value::String(format!("{sign}0x{:x}p{exponent}", digits >> zeros))
}

/// The binary64 number that a text stands for, be it written as a fraction.
pub(super) fn binary64(value: &Value) -> f64 {
    let text = value.as_str().unwrap_or_default();
    let fraction = || {
        let (numerator, denominator) = text.split_once('/').unwrap_or((text, "1"));
        Some(numerator.parse::<f64>().ok()? / denominator.parse::<f64>().ok()?)
    };
    float(text).or_else(fraction).unwrap_or(f64::NAN)
}

pub(super) fn floats(value: &Value) -> Vec<f64> {
    value.as_array().into_iter().flatten().map(binary64).collect()
}

/// A matrix of single numbers, row by row.
pub(super) fn float_matrix(value: &Value) -> nalgebra::DMatrix<f64> {
    let rows: Vec<Vec<f64>> = value.as_array().into_iter().flatten().map(floats).collect();
    let cols = rows.first().map_or(0, Vec::len);
    nalgebra::DMatrix::from_fn(rows.len(), cols, |i, j| rows[i][j])
}

/// A number, or one drawn from between two bounds: most often one of them.
pub(super) fn drawn(value: &Value, random: &mut Random) -> Exact {
    let text = |value: &Value| number(value.as_str().expect("a number")).expect("a number");
    match value {
        Value::Array(ends) => {
            let (lo, hi) = (text(&ends[0]), text(&ends[1]));
            let share = [0, 0, 16, 16, random.below(17)][random.below(5)];
            lo.plus(&hi.minus(&lo).scaled(&Exact::dyadic(i64::try_from(share).unwrap_or(0), 4)))
        }
        _ => text(value),
    }
}

/// A matrix of which every entry is drawn.
pub(super) fn matrix(value: &Value, random: &mut Random) -> Exact {
    matrix_with_columns(value, 0, random)
}

/// The same; `columns` is the number of columns if there are no rows.
pub(super) fn matrix_with_columns(value: &Value, columns: usize, random: &mut Random) -> Exact {
    let rows = value.as_array().expect("a matrix");
    let columns = rows.first().map_or(columns, |row| row.as_array().expect("a row").len());
    let entries: Vec<Exact> =
        rows.iter().flat_map(|row| row.as_array().expect("a row")).map(|x| drawn(x, random)).collect();
    Exact::from_numbers(rows.len(), columns, &entries)
}

/// A symmetric matrix of which every entry of the upper triangle is drawn.
pub(super) fn symmetric(value: &Value, random: &mut Random) -> Exact {
    let m = matrix(value, random);
    let n = m.rows;
    let entries: Vec<Exact> = (0..n * n).map(|k| m.at((k / n).min(k % n), (k / n).max(k % n))).collect();
    Exact::from_numbers(n, n, &entries)
}

/// Whether all numbers below are single.
pub(super) fn is_single(value: &Value) -> bool {
    value.as_array().into_iter().flatten().all(|row| row.as_array().into_iter().flatten().all(Value::is_string))
}
