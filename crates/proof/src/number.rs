//! Exact numbers as certificate files write them: hexadecimal floats for binary64 numbers, fractions for others.
//!
//! `"0x1.8p-3"` is 1.5 times 2 to the power -3. The digits are hexadecimal, the exponent of two is decimal, and the
//! number must be exactly representable in binary64: reading does not round. `"7"` and `"42/85"` are integers and
//! fractions of any length. Where an interval is allowed, a fraction that is not representable is enclosed between the
//! two neighbouring binary64 numbers.

use core::fmt;
use core::str::FromStr;

use dashu_int::ops::{BitTest, Gcd};
use dashu_int::{IBig, UBig};
use thiserror::Error;

use crate::exact::Exact;
use crate::interval::Interval;
use crate::ring::Ring;

/// The longest number in a file, in characters: exact multipliers of infeasibility have thousands of digits.
pub const LONGEST_NUMBER: usize = 20_000;

/// Hexadecimal digits in a float, leading and trailing zeros included.
const LONGEST_HEXADECIMAL: usize = 64;

/// A rational number, exactly.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Number {
    /// `m 2^e`: every binary64 number, every integer.
    Dyadic(Exact),
    /// Any other fraction.
    Fraction {
        /// The numerator, without a factor in common with the denominator.
        numerator: IBig,
        /// The denominator, which is positive and no power of two.
        denominator: UBig,
    },
}

/// Why a text is not a valid number of a certificate.
#[derive(Debug, Clone, PartialEq, Eq, Error)]
#[non_exhaustive]
pub enum NumberError {
    /// A decimal such as 0.1, in a string or as a JSON number.
    #[error(
        "{text} is a decimal, which binary64 rounds in silence: write the fraction that is meant (one tenth is \"1/10\"), or the binary64 number that is stored, here \"{nearest}\""
    )]
    Decimal {
        /// The text.
        text: String,
        /// The hexadecimal float nearest to it.
        nearest: String,
    },
    /// It begins as a hexadecimal float.
    #[error("\"{text}\" is not a hexadecimal float such as \"0x1.8p-3\"")]
    NotHexadecimal {
        /// The text.
        text: String,
    },
    /// It is a hexadecimal float with more digits than binary64 has.
    #[error("\"{text}\" is a hexadecimal float that binary64 does not have; the nearest below is \"{below}\"")]
    NotBinary64 {
        /// The text.
        text: String,
        /// The neighbour below.
        below: String,
    },
    /// It is larger than every binary64 number.
    #[error("\"{text}\" is beyond the largest binary64 number, 0x1.fffffffffffffp1023")]
    Overflow {
        /// The text, or its beginning.
        text: String,
    },
    /// A fraction with the denominator 0.
    #[error("\"{text}\" has the denominator 0")]
    ZeroDenominator {
        /// The text, or its beginning.
        text: String,
    },
    /// Longer than any number need be.
    #[error(
        "a number of {length} characters: {LONGEST_NUMBER} are allowed, {LONGEST_HEXADECIMAL} digits in a hexadecimal float"
    )]
    TooLong {
        /// Its length.
        length: usize,
    },
    /// Anything else, NaN and infinity among it.
    #[error(
        "\"{text}\" is not a number: write a hexadecimal float such as \"0x1.8p-3\", an integer, or a fraction such as \"42/85\""
    )]
    NotANumber {
        /// The text, or its beginning.
        text: String,
    },
}

/// As much of a text as an error quotes.
pub(crate) fn quoted(text: &str) -> String {
    const LENGTH: usize = 80;
    let shown = luenberger_wording::visible(text);
    if shown.chars().count() <= LENGTH { shown } else { shown.chars().take(LENGTH).chain("...".chars()).collect() }
}

impl Number {
    /// The number that a binary64 number is; `None` for NaN and infinities.
    pub fn from_f64(x: f64) -> Option<Self> {
        Exact::from_f64(x).map(Self::Dyadic)
    }

    /// The fraction that the shortest decimal of a binary64 number is, as a paper prints it: 267/1000 for 0.267. `None`
    /// for NaN and infinities.
    /// ```
    /// use luenberger_proof::certificate::Number;
    /// assert_eq!(Number::of_decimal(-0.267).unwrap().to_string(), "-267/1000");
    /// assert_eq!(Number::of_decimal(2.5e3).unwrap().to_string(), "0x1.388p11");
    /// ```
    pub fn of_decimal(x: f64) -> Option<Self> {
        let text = format!("{x:e}");
        let (digits, exponent) = text.split_once('e')?;
        let (whole, part) = digits.split_once('.').unwrap_or((digits, ""));
        let numerator = IBig::from_str_radix(&[whole, part].concat(), 10).ok()?;
        let places = exponent.parse::<i64>().ok()? - part.len().cast_signed() as i64;
        let power = UBig::from(10_u8).pow(places.unsigned_abs() as usize);
        Some(if places < 0 { Self::fraction(numerator, power) } else { Self::fraction(numerator * power, UBig::ONE) })
    }

    /// The binary64 number that this is, if it is one.
    pub fn to_f64(&self) -> Option<f64> {
        let exact = self.exact()?;
        let below = exact.round_down();
        (below.is_finite() && below == exact.round_up()).then_some(below)
    }

    /// The dyadic number that this is, if it is one.
    pub fn exact(&self) -> Option<&Exact> {
        match self {
            Self::Dyadic(exact) => Some(exact),
            Self::Fraction { .. } => None,
        }
    }

    /// The narrowest interval with binary64 ends around this number.
    pub fn enclosure(&self) -> Interval {
        match self {
            Self::Dyadic(exact) => exact.enclosure(),
            Self::Fraction { numerator, denominator } => {
                // The quotient cut off after at least 64 bits, and one unit more: the binary64 numbers are a coarser
                // grid, so that they are rounded as the quotient itself would be.
                let (sign, numerator) = numerator.clone().into_parts();
                let places = (64 + denominator.bit_len()).saturating_sub(numerator.bit_len()).max(1100);
                let cut = IBig::from((numerator << places) / denominator);
                let places = -(places.cast_signed() as i64);
                let (inner, outer) = (Exact::new(cut.clone(), places), Exact::new(cut + IBig::ONE, places));
                let (inner, outer) = (inner.round_down(), outer.round_up());
                let ends = if sign == dashu_int::Sign::Negative { (-outer, -inner) } else { (inner, outer) };
                Interval::new(ends.0, ends.1).unwrap_or(Interval::UNBOUNDED)
            }
        }
    }

    /// `numerator / denominator`, the denominator not 0.
    pub(crate) fn fraction(numerator: IBig, denominator: UBig) -> Self {
        let common = numerator.clone().into_parts().1.gcd(&denominator);
        let (numerator, denominator) = (numerator / IBig::from(common.clone()), denominator / common);
        // A power of two has as many trailing zeros as it has bits after the first.
        match denominator.trailing_zeros() {
            Some(zeros) if zeros + 1 == denominator.bit_len() => {
                Self::Dyadic(Exact::new(numerator, -(zeros.cast_signed() as i64)))
            }
            _ => Self::Fraction { numerator, denominator },
        }
    }
}

impl From<Exact> for Number {
    fn from(exact: Exact) -> Self {
        Self::Dyadic(exact)
    }
}

impl FromStr for Number {
    type Err = NumberError;

    fn from_str(text: &str) -> Result<Self, NumberError> {
        if text.len() > LONGEST_NUMBER {
            return Err(NumberError::TooLong { length: text.len() });
        }
        let (is_negative, magnitude) = text.strip_prefix('-').map_or((false, text), |rest| (true, rest));
        if let Some(hexadecimal) = magnitude.strip_prefix("0x") {
            return parse_hexadecimal(text, hexadecimal, is_negative);
        }
        let not_a_number = || NumberError::NotANumber { text: quoted(text) };
        let digits = |part: &str| !part.is_empty() && part.bytes().all(|b| b.is_ascii_digit());
        let (numerator, denominator) = magnitude.split_once('/').unwrap_or((magnitude, "1"));
        if !digits(numerator) || !digits(denominator) {
            return Err(decimal(text).unwrap_or_else(not_a_number));
        }
        let integer = |part: &str| UBig::from_str_radix(part, 10).map_err(|_| not_a_number());
        let (numerator, denominator) = (IBig::from(integer(numerator)?), integer(denominator)?);
        if denominator.is_zero() {
            return Err(NumberError::ZeroDenominator { text: quoted(text) });
        }
        Ok(Self::fraction(if is_negative { -numerator } else { numerator }, denominator))
    }
}

/// The error for a decimal, if the text is one.
pub(crate) fn decimal(text: &str) -> Option<NumberError> {
    let is_decimal = text.bytes().any(|b| b.is_ascii_digit())
        && text.bytes().all(|b| b.is_ascii_digit() || matches!(b, b'.' | b'e' | b'E' | b'+' | b'-'));
    let value: f64 = if is_decimal { text.parse().ok()? } else { return None };
    Some(match Number::from_f64(value) {
        Some(nearest) => NumberError::Decimal { text: quoted(text), nearest: nearest.to_string() },
        None => NumberError::Overflow { text: quoted(text) },
    })
}

fn parse_hexadecimal(text: &str, magnitude: &str, is_negative: bool) -> Result<Number, NumberError> {
    let malformed = || NumberError::NotHexadecimal { text: quoted(text) };
    let (digits, exponent) = magnitude.split_once('p').ok_or_else(malformed)?;
    let (whole, part) = digits.split_once('.').unwrap_or((digits, ""));
    let mantissa: String = [whole, part].concat();
    if mantissa.len() > LONGEST_HEXADECIMAL {
        return Err(NumberError::TooLong { length: text.len() });
    }
    if whole.is_empty() || !mantissa.bytes().all(|b| b.is_ascii_hexdigit()) {
        return Err(malformed());
    }
    let unsigned = exponent.strip_prefix(['-', '+']).unwrap_or(exponent);
    if unsigned.is_empty() || unsigned.len() > 6 || !unsigned.bytes().all(|b| b.is_ascii_digit()) {
        return Err(malformed());
    }
    let exponent: i64 = exponent.parse().map_err(|_| malformed())?;
    let mantissa = IBig::from(UBig::from_str_radix(&mantissa, 16).map_err(|_| malformed())?);
    let exact =
        Exact::new(if is_negative { -mantissa } else { mantissa }, exponent - 4 * part.len().cast_signed() as i64);
    let (below, above) = (exact.round_down(), exact.round_up());
    if exact.is_zero() || (below == above && below.is_finite()) {
        return Ok(Number::Dyadic(exact));
    }
    Err(if !above.is_finite() || !below.is_finite() {
        NumberError::Overflow { text: quoted(text) }
    } else {
        let below = Number::from_f64(below).map_or_else(String::new, |number| number.to_string());
        NumberError::NotBinary64 { text: quoted(text), below }
    })
}

impl fmt::Display for Number {
    /// The shortest hexadecimal float where binary64 has the number, else the integer or the fraction.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Dyadic(exact) if self.to_f64().is_some() => hexadecimal(exact, f),
            Self::Dyadic(exact) => {
                let shift = exact.exponent().unsigned_abs() as usize;
                if exact.exponent() >= 0 {
                    write!(f, "{}", exact.mantissa() << shift)
                } else {
                    write!(f, "{}/{}", exact.mantissa(), UBig::ONE << shift)
                }
            }
            Self::Fraction { numerator, denominator } => write!(f, "{numerator}/{denominator}"),
        }
    }
}

fn hexadecimal(exact: &Exact, f: &mut fmt::Formatter<'_>) -> fmt::Result {
    let magnitude = exact.mantissa().clone().into_parts().1;
    // The mantissa of a binary64 number is odd and below 2^53, or 0.
    let digits = u64::try_from(magnitude).unwrap_or(0);
    let sign = if exact.signum() < 0 { "-" } else { "" };
    let Some(top) = exact.magnitude_exponent() else { return f.write_str("0x0p0") };
    let bits = u64::BITS - 1 - digits.leading_zeros();
    let width = bits.div_ceil(4);
    if width == 0 {
        return write!(f, "{sign}0x1p{top}");
    }
    let part = (digits ^ (1 << bits)) << (4 * width - bits);
    write!(f, "{sign}0x1.{part:0width$x}p{top}", width = width as usize)
}

/// An entry of the plant's data: one number, or all numbers between two.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Datum {
    /// One number.
    Number(Number),
    /// All numbers from the first to the second.
    Between(Number, Number),
}

impl Datum {
    /// The number that a binary64 number is; `None` for NaN and infinities.
    pub fn from_f64(x: f64) -> Option<Self> {
        Number::from_f64(x).map(Self::Number)
    }

    /// The numbers of an interval; `None` when it is unbounded.
    pub fn from_interval(interval: &Interval) -> Option<Self> {
        let (lo, hi) = (Number::from_f64(interval.lo())?, Number::from_f64(interval.hi())?);
        Some(if lo == hi { Self::Number(lo) } else { Self::Between(lo, hi) })
    }

    /// An interval that contains all of it.
    pub fn interval(&self) -> Interval {
        match self {
            Self::Number(x) => x.enclosure(),
            Self::Between(lo, hi) => {
                Interval::new(lo.enclosure().lo(), hi.enclosure().hi()).unwrap_or(Interval::UNBOUNDED)
            }
        }
    }

    /// Whether it is a single binary64 number.
    pub fn is_point(&self) -> bool {
        matches!(self, Self::Number(x) if x.to_f64().is_some())
    }
}
