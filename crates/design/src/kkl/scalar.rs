//! [`Collected`] as a scalar of nalgebra: what it can, by its polynomials; what it cannot, noted.

use core::cmp::Ordering;
use core::fmt;
use core::ops::{Add, AddAssign, Div, DivAssign, Mul, MulAssign, Neg, Rem, RemAssign, Sub, SubAssign};

use approx::{AbsDiffEq, RelativeEq, UlpsEq};
use luenberger_proof::{Interval, Ring};
use nalgebra::{ComplexField, Field, RealField, SimdValue};
use num_traits::{FromPrimitive, Num, One, Signed, Zero};
use simba::scalar::{SubsetOf, SupersetOf};

use super::collected::{Collected, Function, fail, open_question};

/// The binary64 number x.
fn exactly(x: f64) -> Collected {
    Interval::from_f64(x).map_or_else(|| fail("a constant that is not finite"), Collected::constant)
}

/// A number that is x up to its rounding.
fn about(x: f64) -> Collected {
    Interval::new(x.next_down(), x.next_up()).map_or_else(|| fail("a constant that is not finite"), Collected::constant)
}

/// A constant of mathematics; asked for twice it is the same number.
fn named(x: f64) -> Collected {
    let enclosure = Interval::new(x.next_down(), x.next_up());
    enclosure
        .map_or_else(|| fail("a constant that is not finite"), |enclosure| Collected::named(x.to_bits(), enclosure))
}

impl Add for Collected {
    type Output = Self;

    fn add(self, rhs: Self) -> Self {
        self.plus(rhs)
    }
}

impl Sub for Collected {
    type Output = Self;

    fn sub(self, rhs: Self) -> Self {
        self.minus(rhs)
    }
}

impl Mul for Collected {
    type Output = Self;

    fn mul(self, rhs: Self) -> Self {
        self.times(rhs)
    }
}

impl Div for Collected {
    type Output = Self;

    fn div(self, rhs: Self) -> Self {
        self.times(rhs.of(Function::Recip))
    }
}

impl Rem for Collected {
    type Output = Self;

    fn rem(self, _rhs: Self) -> Self {
        fail("a remainder")
    }
}

impl Neg for Collected {
    type Output = Self;

    fn neg(self) -> Self {
        Self::zero() - self
    }
}

macro_rules! assign {
    ($($operator:ident $method:ident $of:ident),*) => {$(
        impl $operator for Collected {
            fn $method(&mut self, rhs: Self) {
                *self = self.$of(rhs);
            }
        }
    )*};
}

assign!(AddAssign add_assign add, SubAssign sub_assign sub, MulAssign mul_assign mul, DivAssign div_assign div, RemAssign rem_assign rem);

/// Whether `x - y` is a number, and which.
fn difference(x: Collected, y: Collected) -> Option<Interval> {
    (x - y).as_constant()
}

impl PartialEq for Collected {
    fn eq(&self, other: &Self) -> bool {
        match difference(*self, *other) {
            Some(d) if d.is_point() => d.is_zero(),
            Some(d) if !d.contains(0.0) => false,
            _ => open_question(),
        }
    }
}

impl PartialOrd for Collected {
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        Some(match difference(*self, *other) {
            Some(d) if d.lo() > 0.0 => Ordering::Greater,
            Some(d) if d.hi() < 0.0 => Ordering::Less,
            Some(d) if d.is_point() => Ordering::Equal,
            _ if open_question() => Ordering::Less,
            _ => Ordering::Greater,
        })
    }
}

impl fmt::Display for Collected {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self.as_constant() {
            Some(x) => write!(f, "[{}, {}]", x.lo(), x.hi()),
            None => f.write_str("a polynomial in atoms"),
        }
    }
}

impl Zero for Collected {
    fn zero() -> Self {
        exactly(0.0)
    }

    fn is_zero(&self) -> bool {
        *self == Self::zero()
    }
}

impl One for Collected {
    fn one() -> Self {
        exactly(1.0)
    }
}

impl Num for Collected {
    type FromStrRadixErr = <f64 as Num>::FromStrRadixErr;

    /// The decimal number is not a binary64 one, so that this is its rounding and both neighbours.
    fn from_str_radix(text: &str, radix: u32) -> Result<Self, Self::FromStrRadixErr> {
        f64::from_str_radix(text, radix).map(about)
    }
}

/// The largest integer up to which all integers are binary64 numbers.
const EXACT_INTEGERS: u64 = 1 << f64::MANTISSA_DIGITS;

impl FromPrimitive for Collected {
    fn from_i64(n: i64) -> Option<Self> {
        Some(if n.unsigned_abs() <= EXACT_INTEGERS { exactly(n as f64) } else { about(n as f64) })
    }

    fn from_u64(n: u64) -> Option<Self> {
        Some(if n <= EXACT_INTEGERS { exactly(n as f64) } else { about(n as f64) })
    }

    fn from_f64(x: f64) -> Option<Self> {
        Some(exactly(x))
    }
}

impl SubsetOf<Self> for Collected {
    fn to_superset(&self) -> Self {
        *self
    }

    fn from_superset_unchecked(element: &Self) -> Self {
        *element
    }

    fn is_in_subset(_: &Self) -> bool {
        true
    }
}

macro_rules! supersets {
    ($($float:ident),*) => {$(
        impl SupersetOf<$float> for Collected {
            fn is_in_subset(&self) -> bool {
                let constant = self.as_constant().is_some_and(|x| x.is_point());
                if !constant {
                    fail("a conversion to a single number");
                }
                constant
            }

            fn to_subset_unchecked(&self) -> $float {
                SupersetOf::<$float>::is_in_subset(self);
                self.as_constant().map_or(0.0, |x| x.lo()) as $float
            }

            fn from_subset(&element: &$float) -> Self {
                exactly(f64::from(element))
            }
        }
    )*};
}

supersets!(f32, f64);

impl AbsDiffEq for Collected {
    type Epsilon = Self;

    fn default_epsilon() -> Self {
        exactly(f64::EPSILON)
    }

    fn abs_diff_eq(&self, other: &Self, epsilon: Self) -> bool {
        Signed::abs(&(*self - *other)) <= epsilon
    }
}

impl RelativeEq for Collected {
    fn default_max_relative() -> Self {
        exactly(f64::EPSILON)
    }

    fn relative_eq(&self, other: &Self, epsilon: Self, max_relative: Self) -> bool {
        let largest = RealField::max(Signed::abs(self), Signed::abs(other));
        Signed::abs(&(*self - *other)) <= RealField::max(epsilon, largest * max_relative)
    }
}

impl UlpsEq for Collected {
    fn default_max_ulps() -> u32 {
        4
    }

    fn ulps_eq(&self, other: &Self, epsilon: Self, max_ulps: u32) -> bool {
        self.relative_eq(other, epsilon, exactly(f64::EPSILON * f64::from(max_ulps)))
    }
}

impl Signed for Collected {
    fn abs(&self) -> Self {
        match self.as_constant() {
            Some(x) => Self::constant(x.abs()),
            None => fail("an absolute value"),
        }
    }

    fn abs_sub(&self, other: &Self) -> Self {
        RealField::max(*self - *other, Self::zero())
    }

    fn signum(&self) -> Self {
        fail("signum")
    }

    fn is_positive(&self) -> bool {
        *self > Self::zero()
    }

    fn is_negative(&self) -> bool {
        *self < Self::zero()
    }
}

impl SimdValue for Collected {
    const LANES: usize = 1;
    type Element = Self;
    type SimdBool = bool;

    fn splat(val: Self) -> Self {
        val
    }

    fn extract(&self, _: usize) -> Self {
        *self
    }

    // SAFETY: nothing is assumed of the index; only the trait's signature is unsafe.
    #[allow(unsafe_code)]
    unsafe fn extract_unchecked(&self, _: usize) -> Self {
        *self
    }

    fn replace(&mut self, _: usize, val: Self) {
        *self = val;
    }

    // SAFETY: as above.
    #[allow(unsafe_code)]
    unsafe fn replace_unchecked(&mut self, _: usize, val: Self) {
        *self = val;
    }

    fn select(self, cond: bool, other: Self) -> Self {
        if cond { self } else { other }
    }
}

impl Field for Collected {}

impl ComplexField for Collected {
    type RealField = Self;

    fn from_real(re: Self) -> Self {
        re
    }

    fn real(self) -> Self {
        self
    }

    fn conjugate(self) -> Self {
        self
    }

    fn imaginary(self) -> Self {
        Self::zero()
    }

    fn modulus(self) -> Self {
        Signed::abs(&self)
    }

    fn norm1(self) -> Self {
        Signed::abs(&self)
    }

    fn abs(self) -> Self {
        Signed::abs(&self)
    }

    fn modulus_squared(self) -> Self {
        self * self
    }

    fn argument(self) -> Self {
        fail("the argument of a number")
    }

    fn scale(self, factor: Self) -> Self {
        self * factor
    }

    fn unscale(self, factor: Self) -> Self {
        self / factor
    }

    fn signum(self) -> Self {
        fail("signum")
    }

    fn floor(self) -> Self {
        fail("floor")
    }

    fn ceil(self) -> Self {
        fail("ceil")
    }

    fn round(self) -> Self {
        fail("round")
    }

    fn trunc(self) -> Self {
        fail("trunc")
    }

    fn fract(self) -> Self {
        fail("fract")
    }

    fn asin(self) -> Self {
        fail("asin")
    }

    fn acos(self) -> Self {
        fail("acos")
    }

    fn asinh(self) -> Self {
        fail("asinh")
    }

    fn acosh(self) -> Self {
        fail("acosh")
    }

    fn atanh(self) -> Self {
        fail("atanh")
    }

    fn cbrt(self) -> Self {
        fail("cbrt")
    }

    fn mul_add(self, a: Self, b: Self) -> Self {
        self * a + b
    }

    fn hypot(self, other: Self) -> Self {
        (self * self + other * other).of(Function::Sqrt)
    }

    fn recip(self) -> Self {
        self.of(Function::Recip)
    }

    fn sin(self) -> Self {
        self.of(Function::Sin)
    }

    fn cos(self) -> Self {
        self.of(Function::Cos)
    }

    fn sin_cos(self) -> (Self, Self) {
        (ComplexField::sin(self), ComplexField::cos(self))
    }

    fn tan(self) -> Self {
        ComplexField::sin(self) / ComplexField::cos(self)
    }

    fn atan(self) -> Self {
        self.of(Function::Atan)
    }

    fn sinh(self) -> Self {
        (self.of(Function::Exp) - (-self).of(Function::Exp)) * exactly(0.5)
    }

    fn cosh(self) -> Self {
        (self.of(Function::Exp) + (-self).of(Function::Exp)) * exactly(0.5)
    }

    fn tanh(self) -> Self {
        self.of(Function::Tanh)
    }

    fn log(self, base: Self) -> Self {
        ComplexField::ln(self) / ComplexField::ln(base)
    }

    fn log2(self) -> Self {
        ComplexField::ln(self) / Self::ln_2()
    }

    fn log10(self) -> Self {
        ComplexField::ln(self) / Self::ln_10()
    }

    fn ln(self) -> Self {
        self.of(Function::Ln)
    }

    fn ln_1p(self) -> Self {
        (Self::one() + self).of(Function::Ln)
    }

    fn sqrt(self) -> Self {
        self.of(Function::Sqrt)
    }

    fn exp(self) -> Self {
        self.of(Function::Exp)
    }

    fn exp2(self) -> Self {
        (self * Self::ln_2()).of(Function::Exp)
    }

    fn exp_m1(self) -> Self {
        self.of(Function::Exp) - Self::one()
    }

    fn powi(self, n: i32) -> Self {
        let base = if n < 0 { self.of(Function::Recip) } else { self };
        // The sheet refuses high powers, so that this ends.
        match n.unsigned_abs() {
            power @ 0..=64 => (0..power).fold(Self::one(), |product, _| product * base),
            _ => fail("a high power"),
        }
    }

    fn powf(self, n: Self) -> Self {
        match n.as_constant() {
            Some(x) if x.is_point() && x.lo().fract() == 0.0 && x.lo().abs() <= 64.0 => self.powi(x.lo() as i32),
            _ => (n * self.of(Function::Ln)).of(Function::Exp),
        }
    }

    fn powc(self, n: Self) -> Self {
        self.powf(n)
    }

    fn is_finite(&self) -> bool {
        true
    }

    fn try_sqrt(self) -> Option<Self> {
        Some(self.of(Function::Sqrt))
    }
}

impl RealField for Collected {
    fn is_sign_positive(&self) -> bool {
        *self >= Self::zero()
    }

    fn is_sign_negative(&self) -> bool {
        *self < Self::zero()
    }

    fn copysign(self, sign: Self) -> Self {
        if sign >= Self::zero() { Signed::abs(&self) } else { -Signed::abs(&self) }
    }

    fn max(self, other: Self) -> Self {
        if self >= other { self } else { other }
    }

    fn min(self, other: Self) -> Self {
        if self <= other { self } else { other }
    }

    fn clamp(self, min: Self, max: Self) -> Self {
        RealField::min(RealField::max(self, min), max)
    }

    fn atan2(self, _other: Self) -> Self {
        fail("atan2")
    }

    fn min_value() -> Option<Self> {
        Some(exactly(f64::MIN))
    }

    fn max_value() -> Option<Self> {
        Some(exactly(f64::MAX))
    }

    fn pi() -> Self {
        named(core::f64::consts::PI)
    }

    fn two_pi() -> Self {
        named(core::f64::consts::TAU)
    }

    fn frac_pi_2() -> Self {
        named(core::f64::consts::FRAC_PI_2)
    }

    fn frac_pi_3() -> Self {
        named(core::f64::consts::FRAC_PI_3)
    }

    fn frac_pi_4() -> Self {
        named(core::f64::consts::FRAC_PI_4)
    }

    fn frac_pi_6() -> Self {
        named(core::f64::consts::FRAC_PI_6)
    }

    fn frac_pi_8() -> Self {
        named(core::f64::consts::FRAC_PI_8)
    }

    fn frac_1_pi() -> Self {
        named(core::f64::consts::FRAC_1_PI)
    }

    fn frac_2_pi() -> Self {
        named(core::f64::consts::FRAC_2_PI)
    }

    fn frac_2_sqrt_pi() -> Self {
        named(core::f64::consts::FRAC_2_SQRT_PI)
    }

    fn e() -> Self {
        named(core::f64::consts::E)
    }

    fn log2_e() -> Self {
        named(core::f64::consts::LOG2_E)
    }

    fn log10_e() -> Self {
        named(core::f64::consts::LOG10_E)
    }

    fn ln_2() -> Self {
        named(core::f64::consts::LN_2)
    }

    fn ln_10() -> Self {
        named(core::f64::consts::LN_10)
    }
}
