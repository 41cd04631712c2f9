//! Exact rational numbers: the coefficients of polynomials.

use dashu_int::ops::{BitTest, Gcd};
use dashu_int::{IBig, UBig};

use crate::exact::Exact;
use crate::interval::Interval;
use crate::number::Number;
use crate::ring::Ring;

/// `numerator / denominator` in lowest terms.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct Rational {
    numerator: IBig,
    denominator: UBig,
}

impl Rational {
    pub(crate) fn new(numerator: IBig, denominator: UBig) -> Self {
        if numerator.is_zero() {
            return Self { numerator, denominator: UBig::ONE };
        }
        let common = numerator.clone().into_parts().1.gcd(&denominator);
        Self { numerator: numerator / IBig::from(common.clone()), denominator: denominator / common }
    }

    pub(crate) fn integer(n: i64) -> Self {
        Self { numerator: IBig::from(n), denominator: UBig::ONE }
    }

    /// A binary64 number, exactly; `None` for NaN and infinities.
    pub(crate) fn from_f64(x: f64) -> Option<Self> {
        Exact::from_f64(x).map(|x| Self::from(&x))
    }

    pub(crate) fn is_zero(&self) -> bool {
        self.numerator.is_zero()
    }

    /// Length of the longer of the two integers, in bits.
    pub(crate) fn bits(&self) -> usize {
        self.numerator.bit_len().max(self.denominator.bit_len())
    }

    pub(crate) fn plus(&self, other: &Self) -> Self {
        let left = &self.numerator * IBig::from(other.denominator.clone());
        let right = &other.numerator * IBig::from(self.denominator.clone());
        Self::new(left + right, &self.denominator * &other.denominator)
    }

    pub(crate) fn times(&self, other: &Self) -> Self {
        Self::new(&self.numerator * &other.numerator, &self.denominator * &other.denominator)
    }

    pub(crate) fn negative(&self) -> Self {
        Self { numerator: -&self.numerator, denominator: self.denominator.clone() }
    }

    /// `1 / self`; `None` for 0.
    pub(crate) fn inverse(&self) -> Option<Self> {
        let (sign, magnitude) = self.numerator.clone().into_parts();
        let numerator = IBig::from_parts(sign, self.denominator.clone());
        (!magnitude.is_zero()).then_some(Self { numerator, denominator: magnitude })
    }

    /// The narrowest interval with binary64 bounds that contains the number.
    pub(crate) fn enclosure(&self) -> Interval {
        Number::fraction(self.numerator.clone(), self.denominator.clone()).enclosure()
    }
}

impl From<&Number> for Rational {
    fn from(x: &Number) -> Self {
        match x {
            Number::Dyadic(exact) => Self::from(exact),
            Number::Fraction { numerator, denominator } => {
                Self { numerator: numerator.clone(), denominator: denominator.clone() }
            }
        }
    }
}

impl From<Rational> for Number {
    fn from(x: Rational) -> Self {
        Self::fraction(x.numerator, x.denominator)
    }
}

impl From<&Exact> for Rational {
    fn from(x: &Exact) -> Self {
        let shift = x.exponent().unsigned_abs() as usize;
        if x.exponent() >= 0 {
            Self { numerator: x.mantissa() << shift, denominator: UBig::ONE }
        } else {
            Self::new(x.mantissa().clone(), UBig::ONE << shift)
        }
    }
}
