//! Floating-point numbers as literals: hexadecimal in C, which is exact, and the shortest decimal in Rust, which is
//! read back to the same bits.

use crate::scalar::Scalar;

/// A literal of C99, of the number as the format stores it: `0x1.999999999999ap-4`, with `f` for binary32.
pub fn c(x: f64, scalar: Scalar) -> String {
    let suffix = match scalar {
        Scalar::Binary32 => "f",
        Scalar::Binary64 => "",
    };
    let x = scalar.round(x);
    let sign = if x.is_sign_negative() { "-" } else { "" };
    let magnitude = x.abs();
    if magnitude == 0.0 {
        return format!("{sign}0.0{suffix}");
    }
    let bits = magnitude.to_bits();
    let (exponent, fraction) = ((bits >> 52).cast_signed(), bits & ((1 << 52) - 1));
    // A subnormal number has no leading one.
    let (lead, power) = if exponent == 0 { (0, -1022) } else { (1, exponent - 1023) };
    let digits = format!("{fraction:013x}");
    let digits = digits.trim_end_matches('0');
    let point = if digits.is_empty() { "" } else { "." };
    format!("{sign}0x{lead}{point}{digits}p{power:+}{suffix}")
}

/// A literal of Rust, of the type of the format.
pub fn rust(x: f64, scalar: Scalar) -> String {
    match scalar {
        Scalar::Binary32 => format!("{:?}", x as f32),
        Scalar::Binary64 => format!("{x:?}"),
    }
}
