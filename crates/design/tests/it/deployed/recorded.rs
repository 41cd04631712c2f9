//! A scalar that computes as the one it wraps, and writes down the result of every operation: what the code of an
//! observer really goes through.

use core::cell::RefCell;
use core::fmt;
use core::ops::{Add, AddAssign, Div, DivAssign, Mul, MulAssign, Neg, Rem, RemAssign, Sub, SubAssign};

use nalgebra::{ComplexField, Field, RealField, SimdValue};
use num_traits::{FromPrimitive, Num, One, Signed, Zero};
use simba::scalar::{SubsetOf, SupersetOf};

thread_local! {
    static TAPE: RefCell<Vec<(&'static str, f64)>> = const { RefCell::new(Vec::new()) };
}

/// What `run` computes, and the results of its operations in their order.
pub(crate) fn record<R>(run: impl FnOnce() -> R) -> (R, Vec<(&'static str, f64)>) {
    TAPE.take();
    let result = run();
    (result, TAPE.take())
}

#[derive(Debug, Clone, Copy, PartialEq, PartialOrd)]
pub(crate) struct Recorded<T>(pub(crate) T);

/// Writes the result of an operation down.
fn noted<T: RealField + Copy>(operation: &'static str, result: T) -> Recorded<T> {
    let value: f64 = result.to_subset_unchecked();
    TAPE.with_borrow_mut(|tape| tape.push((operation, value)));
    Recorded(result)
}

impl<T: fmt::Display> fmt::Display for Recorded<T> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.0.fmt(f)
    }
}

macro_rules! operators {
    ($($operator:ident $method:ident $assign:ident $assigned:ident,)*) => {$(
        impl<T: RealField + Copy> $operator for Recorded<T> {
            type Output = Self;

            fn $method(self, rhs: Self) -> Self {
                noted(stringify!($method), self.0.$method(rhs.0))
            }
        }

        impl<T: RealField + Copy> $assign for Recorded<T> {
            fn $assigned(&mut self, rhs: Self) {
                *self = self.$method(rhs);
            }
        }
    )*};
}

operators! {
    Add add AddAssign add_assign,
    Sub sub SubAssign sub_assign,
    Mul mul MulAssign mul_assign,
    Div div DivAssign div_assign,
    Rem rem RemAssign rem_assign,
}

impl<T: RealField + Copy> Neg for Recorded<T> {
    type Output = Self;

    fn neg(self) -> Self {
        Self(-self.0)
    }
}

impl<T: RealField + Copy> Zero for Recorded<T> {
    fn zero() -> Self {
        Self(T::zero())
    }

    fn is_zero(&self) -> bool {
        self.0.is_zero()
    }
}

impl<T: RealField + Copy> One for Recorded<T> {
    fn one() -> Self {
        Self(T::one())
    }
}

impl<T: RealField + Copy> Num for Recorded<T> {
    type FromStrRadixErr = T::FromStrRadixErr;

    fn from_str_radix(text: &str, radix: u32) -> Result<Self, Self::FromStrRadixErr> {
        T::from_str_radix(text, radix).map(Self)
    }
}

impl<T: RealField + Copy> FromPrimitive for Recorded<T> {
    fn from_i64(n: i64) -> Option<Self> {
        T::from_i64(n).map(Self)
    }

    fn from_u64(n: u64) -> Option<Self> {
        T::from_u64(n).map(Self)
    }

    fn from_f64(x: f64) -> Option<Self> {
        T::from_f64(x).map(Self)
    }
}

impl<T: RealField + Copy> Signed for Recorded<T> {
    fn abs(&self) -> Self {
        Self(Signed::abs(&self.0))
    }

    fn abs_sub(&self, other: &Self) -> Self {
        Self(self.0.abs_sub(&other.0))
    }

    fn signum(&self) -> Self {
        Self(Signed::signum(&self.0))
    }

    fn is_positive(&self) -> bool {
        self.0.is_positive()
    }

    fn is_negative(&self) -> bool {
        self.0.is_negative()
    }
}

impl<T: RealField + Copy> approx::AbsDiffEq for Recorded<T> {
    type Epsilon = Self;

    fn default_epsilon() -> Self {
        Self(T::default_epsilon())
    }

    fn abs_diff_eq(&self, other: &Self, epsilon: Self) -> bool {
        self.0.abs_diff_eq(&other.0, epsilon.0)
    }
}

impl<T: RealField + Copy> approx::RelativeEq for Recorded<T> {
    fn default_max_relative() -> Self {
        Self(T::default_max_relative())
    }

    fn relative_eq(&self, other: &Self, epsilon: Self, max_relative: Self) -> bool {
        self.0.relative_eq(&other.0, epsilon.0, max_relative.0)
    }
}

impl<T: RealField + Copy> approx::UlpsEq for Recorded<T> {
    fn default_max_ulps() -> u32 {
        T::default_max_ulps()
    }

    fn ulps_eq(&self, other: &Self, epsilon: Self, max_ulps: u32) -> bool {
        self.0.ulps_eq(&other.0, epsilon.0, max_ulps)
    }
}

impl<T: RealField + Copy> SubsetOf<Self> for Recorded<T> {
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
    ($($float:ident)*) => {$(
        impl<T: RealField + Copy> SupersetOf<$float> for Recorded<T> {
            fn is_in_subset(&self) -> bool {
                SupersetOf::<$float>::is_in_subset(&self.0)
            }

            fn to_subset_unchecked(&self) -> $float {
                self.0.to_subset_unchecked()
            }

            fn from_subset(element: &$float) -> Self {
                Self(T::from_subset(element))
            }
        }
    )*};
}

supersets! { f32 f64 }

impl<T: RealField + Copy> SimdValue for Recorded<T> {
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

impl<T: RealField + Copy> Field for Recorded<T> {}

/// Functions of the wrapped scalar, their results noted.
macro_rules! noting {
    ($($method:ident($($argument:ident),*);)*) => {$(
        fn $method(self $(, $argument: Self)*) -> Self {
            noted(stringify!($method), self.0.$method($($argument.0),*))
        }
    )*};
}

/// Functions that round nothing.
macro_rules! exact {
    ($($method:ident($($argument:ident),*);)*) => {$(
        fn $method(self $(, $argument: Self)*) -> Self {
            Self(self.0.$method($($argument.0),*))
        }
    )*};
}

impl<T: RealField + Copy> ComplexField for Recorded<T> {
    type RealField = Self;

    noting! {
        modulus_squared(); hypot(other); recip(); sqrt(); cbrt(); powf(n); powc(n); exp(); exp2(); exp_m1(); ln(); ln_1p(); log(base); log2(); log10();
        sin(); cos(); tan(); asin(); acos(); atan(); sinh(); cosh(); tanh(); asinh(); acosh(); atanh();
        scale(factor); unscale(factor); mul_add(a, b); argument();
    }

    exact! {
        floor(); ceil(); round(); trunc(); fract(); imaginary(); conjugate();
    }

    fn from_real(re: Self) -> Self {
        re
    }

    fn real(self) -> Self {
        self
    }

    fn modulus(self) -> Self {
        Self(ComplexField::abs(self.0))
    }

    fn norm1(self) -> Self {
        Self(ComplexField::abs(self.0))
    }

    fn abs(self) -> Self {
        Self(ComplexField::abs(self.0))
    }

    fn sin_cos(self) -> (Self, Self) {
        (self.sin(), self.cos())
    }

    fn powi(self, n: i32) -> Self {
        noted("powi", self.0.powi(n))
    }

    fn try_sqrt(self) -> Option<Self> {
        self.0.try_sqrt().map(|root| noted("sqrt", root))
    }

    fn is_finite(&self) -> bool {
        ComplexField::is_finite(&self.0)
    }
}

/// Constants of the wrapped scalar.
macro_rules! constants {
    ($($method:ident)*) => {$(
        fn $method() -> Self {
            Self(T::$method())
        }
    )*};
}

impl<T: RealField + Copy> RealField for Recorded<T> {
    exact! {
        copysign(sign); max(other); min(other); clamp(min, max);
    }

    constants! {
        pi two_pi frac_pi_2 frac_pi_3 frac_pi_4 frac_pi_6 frac_pi_8 frac_1_pi frac_2_pi frac_2_sqrt_pi e log2_e log10_e ln_2 ln_10
    }

    fn atan2(self, other: Self) -> Self {
        noted("atan2", self.0.atan2(other.0))
    }

    fn is_sign_positive(&self) -> bool {
        self.0.is_sign_positive()
    }

    fn is_sign_negative(&self) -> bool {
        self.0.is_sign_negative()
    }

    fn min_value() -> Option<Self> {
        T::min_value().map(Self)
    }

    fn max_value() -> Option<Self> {
        T::max_value().map(Self)
    }
}
