//! Dyadic rationals `m 2^e` with an integer `m` of any length: the ring that binary64 numbers generate.
//!
//! Every finite binary64 number is one, and so is every sum and product of them: polynomial expressions of the data,
//! such as `A'P + PA`, have no rounding error. There is no division; exact elimination is fraction-free (see
//! [`definite`](crate::definite)).

use core::cmp::Ordering;

use dashu_int::ops::BitTest;
use dashu_int::{IBig, Sign};

use crate::interval::Interval;
use crate::ring::Ring;

/// The number `mantissa * 2^exponent`; the mantissa is odd, or the number is 0.
///
/// Memory grows with the distance of the exponents that are added: expressions of degree d in binary64 data need at
/// most about `2100 d` bits.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Exact {
    mantissa: IBig,
    exponent: i64,
}

impl Exact {
    /// `mantissa * 2^exponent`.
    pub fn new(mantissa: IBig, exponent: i64) -> Self {
        match mantissa.trailing_zeros() {
            None => Self { mantissa, exponent: 0 },
            Some(0) => Self { mantissa, exponent },
            Some(zeros) => Self { mantissa: mantissa >> zeros, exponent: exponent + zeros.cast_signed() as i64 },
        }
    }

    /// `2^exponent`.
    pub fn power_of_two(exponent: i64) -> Self {
        Self { mantissa: IBig::ONE, exponent }
    }

    /// The odd integer m of `m 2^e`, or 0.
    pub fn mantissa(&self) -> &IBig {
        &self.mantissa
    }

    /// The e of `m 2^e`; 0 for the number 0.
    pub fn exponent(&self) -> i64 {
        self.exponent
    }

    /// `self * 2^k`.
    #[must_use]
    pub fn shifted(&self, k: i64) -> Self {
        if self.is_zero() {
            self.clone()
        } else {
            Self { mantissa: self.mantissa.clone(), exponent: self.exponent + k }
        }
    }

    /// The sign: -1, 0 or 1.
    pub fn signum(&self) -> i32 {
        if self.mantissa.is_zero() {
            0
        } else if self.mantissa.sign() == Sign::Negative {
            -1
        } else {
            1
        }
    }

    /// The E with `2^E <= |self| < 2^(E+1)`; `None` for 0.
    pub fn magnitude_exponent(&self) -> Option<i64> {
        (!self.is_zero()).then(|| self.exponent + self.mantissa.bit_len().cast_signed() as i64 - 1)
    }

    /// The largest binary64 number not above (possibly -inf, and `f64::MAX` for what is larger).
    pub fn round_down(&self) -> f64 {
        let (inner, outer) = self.magnitude_bounds();
        if self.signum() < 0 { -outer } else { inner }
    }

    /// The smallest binary64 number not below (possibly +inf, and `-f64::MAX` for what is smaller).
    pub fn round_up(&self) -> f64 {
        let (inner, outer) = self.magnitude_bounds();
        if self.signum() < 0 { -inner } else { outer }
    }

    /// The narrowest interval around this number.
    pub fn enclosure(&self) -> Interval {
        // round_down is never +inf, round_up never -inf, and they are in order: the alternative does not occur.
        Interval::new(self.round_down(), self.round_up()).unwrap_or(Interval::UNBOUNDED)
    }

    /// The integer nearest to `self / 2^quantum`, ties to even, for `|self| < 2^(quantum + 53)`: such an integer is a
    /// binary64 number.
    pub(crate) fn nearest_multiple(&self, quantum: i64) -> f64 {
        let cut = quantum - self.exponent;
        let magnitude = self.mantissa.clone().into_parts().1;
        let (truncated, rest) = match usize::try_from(cut) {
            Err(_) => (magnitude << cut.unsigned_abs() as usize, Ordering::Less),
            Ok(cut) => {
                // The mantissa is odd: what is cut off is a half only if it is a single bit.
                let rest = match cut {
                    0 => Ordering::Less,
                    1 => Ordering::Equal,
                    _ if magnitude.bit(cut - 1) => Ordering::Greater,
                    _ => Ordering::Less,
                };
                (magnitude >> cut, rest)
            }
        };
        let floor = u64::try_from(truncated).unwrap_or(u64::MAX);
        let up = match rest {
            Ordering::Less => false,
            Ordering::Equal => floor & 1 == 1,
            Ordering::Greater => true,
        };
        let nearest = (floor + u64::from(up)) as f64;
        if self.signum() < 0 { -nearest } else { nearest }
    }

    /// The neighbouring binary64 numbers below and above |self|, equal when |self| is one.
    fn magnitude_bounds(&self) -> (f64, f64) {
        let Some(top) = self.magnitude_exponent() else { return (0.0, 0.0) };
        if top > 1023 {
            return (f64::MAX, f64::INFINITY);
        }
        // The spacing of the binary64 numbers in [2^top, 2^(top + 1)) is 2^quantum.
        let quantum = (top - 52).max(-1074);
        if top < -1074 {
            return (0.0, f64::from_bits(1));
        }
        let magnitude = self.mantissa.clone().into_parts().1;
        // Below 2^53 in both branches, since |self| < 2^(top + 1) <= 2^(quantum + 53).
        let (truncated, is_exact) = if quantum > self.exponent {
            // The mantissa is odd: cutting loses something.
            (magnitude >> ((quantum - self.exponent) as usize), false)
        } else {
            (magnitude << ((self.exponent - quantum) as usize), true)
        };
        let digits = u64::try_from(truncated).unwrap_or(u64::MAX >> 11);
        let inner = digits as f64 * power_of_two(quantum);
        (inner, if is_exact { inner } else { inner.next_up() })
    }
}

/// `2^k` as binary64, for k from -1074 to 1023; 0 below, infinity above.
pub(crate) fn power_of_two(k: i64) -> f64 {
    match k {
        1024.. => f64::INFINITY,
        -1022..=1023 => f64::from_bits(((k + 1023) as u64) << 52),
        -1074..=-1023 => f64::from_bits(1 << (k + 1074)),
        _ => 0.0,
    }
}

impl Ring for Exact {
    fn zero() -> Self {
        Self { mantissa: IBig::ZERO, exponent: 0 }
    }

    fn from_f64(x: f64) -> Option<Self> {
        if !x.is_finite() {
            return None;
        }
        let bits = x.to_bits();
        let biased = ((bits >> 52) & 0x7ff).cast_signed();
        let fraction = bits & ((1 << 52) - 1);
        // value = fraction 2^-1074 for subnormals, (2^52 + fraction) 2^(biased - 1075) for the others.
        let (digits, exponent) = if biased == 0 { (fraction, -1074) } else { (fraction | (1 << 52), biased - 1075) };
        let mantissa = IBig::from(digits);
        Some(Self::new(if x < 0.0 { -mantissa } else { mantissa }, exponent))
    }

    fn add(&self, rhs: &Self) -> Self {
        if self.is_zero() {
            return rhs.clone();
        }
        if rhs.is_zero() {
            return self.clone();
        }
        let (low, high) = if self.exponent <= rhs.exponent { (self, rhs) } else { (rhs, self) };
        let shift = (high.exponent - low.exponent) as usize;
        Self::new(&low.mantissa + (&high.mantissa << shift), low.exponent)
    }

    fn sub(&self, rhs: &Self) -> Self {
        self.add(&rhs.neg())
    }

    fn mul(&self, rhs: &Self) -> Self {
        if self.is_zero() || rhs.is_zero() {
            return Self::zero();
        }
        // A product of odd numbers is odd.
        Self { mantissa: &self.mantissa * &rhs.mantissa, exponent: self.exponent + rhs.exponent }
    }

    fn neg(&self) -> Self {
        Self { mantissa: -&self.mantissa, exponent: self.exponent }
    }

    fn is_zero(&self) -> bool {
        self.mantissa.is_zero()
    }
}

impl PartialOrd for Exact {
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}

impl Ord for Exact {
    fn cmp(&self, other: &Self) -> Ordering {
        self.sub(other).signum().cmp(&0)
    }
}
