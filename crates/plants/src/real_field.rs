//! Implements nalgebra's scalar traits from a few operations, for types over which a plant is evaluated instead of
//! numbers.
//!
//! A plant is written once for every [`RealField`](nalgebra::RealField). To be one, a type has to be some twenty traits
//! of four crates, most of them the same lines whatever the type: `modulus` is `abs`, `log10 x` is `ln x/ln 10`, a
//! conversion goes through one constructor, a vector of one lane is its element (whose trait has two `unsafe`
//! signatures, the only ones of the workspace). Those lines stand here. What a type has of its own is:
//!
//! - Rust's `+ - * /` and the sign, `PartialEq`, `PartialOrd` and `Display`;
//! - [`Real`]: conversion from a number, elementary functions, and unsupported operations;
//! - [`real_field!(Type)`](crate::real_field!), which writes the rest. A crate that calls it depends on `approx`,
//!   `nalgebra`, `num-traits` and `simba`.
//!
//! A macro and not a generic wrapper, because the types are public and appear in the messages of users' compilers:
//! `IntervalDual` is to be read there, and not `Real<Dual<Interval>>`.
//!
//! The four: `IntervalDual` over a box, `SymbolicPolynomial` for what cancels and `Jet` along a trajectory in the crate
//! of designs, `Recorded` for the program that an observer runs in that of expressions.

use core::ops::{Add, Div, Mul, Neg, Sub};

/// The largest integer up to which all integers are binary64 numbers.
const EXACT_INTEGERS: u64 = 1 << f64::MANTISSA_DIGITS;

/// What differs from one scalar to the next. Methods have the names and the meaning they have in nalgebra, unless they
/// say so.
///
/// A file that implements it imports it in place of `ComplexField` and `RealField`, so that `x.sin()` is this one.
#[expect(missing_docs, reason = "a method without words is that of nalgebra with its name")]
#[expect(clippy::return_self_not_must_use, reason = "as in nalgebra")]
pub trait Real:
    Copy
    + PartialOrd
    + Add<Output = Self>
    + Sub<Output = Self>
    + Mul<Output = Self>
    + Div<Output = Self>
    + Neg<Output = Self>
{
    /// The binary64 number x.
    fn exactly(x: f64) -> Self;

    /// A number that is x up to its rounding.
    fn about(x: f64) -> Self;

    /// The mathematical constant that x is the rounding of; repeated calls give the same number.
    fn mathematical(x: f64) -> Self {
        Self::about(x)
    }

    /// An integer of this magnitude and, as a binary64 number, of this value.
    fn integer(magnitude: u64, x: f64) -> Self {
        if magnitude <= EXACT_INTEGERS { Self::exactly(x) } else { Self::about(x) }
    }

    /// Whether this is a single number. Something is going to be decided or computed from it outside of the scalar:
    /// where that is not allowed, it is noted here.
    fn is_number(&self) -> bool;

    /// The number that this is, or a number in its place.
    fn number(&self) -> f64;

    fn is_zero(&self) -> bool {
        *self == Self::exactly(0.0)
    }

    fn is_finite(&self) -> bool {
        true
    }

    /// The distance from 1 to the next number.
    fn epsilon() -> Self {
        Self::exactly(f64::EPSILON)
    }

    /// The largest number.
    fn largest() -> Self {
        Self::exactly(f64::MAX)
    }

    /// What a function with branches comes to: `map_lanes` of one lane. A scalar that follows both branches joins them
    /// here.
    fn joined(branches: impl Fn() -> Self) -> Self {
        branches()
    }

    /// A piecewise constant function: `floor`, `signum` and similar.
    fn step(&self, operation: &'static str, f: impl Fn(f64) -> f64) -> Self;

    fn fract(self) -> Self {
        self - self.step("fract", <f64 as nalgebra::ComplexField>::trunc)
    }

    /// `x - y trunc(x/y)`, which jumps where x/y is an integer.
    fn remainder(self, other: Self) -> Self {
        self - other * (self / other).step("remainder", <f64 as nalgebra::ComplexField>::trunc)
    }

    fn abs(self) -> Self;

    fn copysign(self, sign: Self) -> Self;

    fn is_sign_positive(&self) -> bool {
        *self >= Self::exactly(0.0)
    }

    fn is_sign_negative(&self) -> bool {
        *self < Self::exactly(0.0)
    }

    fn max(self, other: Self) -> Self;

    fn min(self, other: Self) -> Self;

    /// The angle of a real number beside the positive half axis.
    fn argument(self) -> Self {
        if self >= Self::exactly(0.0) { Self::exactly(0.0) } else { Self::mathematical(core::f64::consts::PI) }
    }

    fn recip(self) -> Self {
        Self::exactly(1.0) / self
    }

    fn modulus_squared(self) -> Self {
        self * self
    }

    fn hypot(self, other: Self) -> Self {
        (self * self + other * other).sqrt()
    }

    fn sqrt(self) -> Self;

    fn try_sqrt(self) -> Option<Self>;

    fn cbrt(self) -> Self;

    fn powi(self, n: i32) -> Self;

    fn powf(self, n: Self) -> Self;

    fn exp(self) -> Self;

    fn exp_m1(self) -> Self;

    fn ln(self) -> Self;

    fn ln_1p(self) -> Self;

    fn sin(self) -> Self;

    fn cos(self) -> Self;

    fn sin_cos(self) -> (Self, Self) {
        (self.sin(), self.cos())
    }

    fn tan(self) -> Self;

    fn asin(self) -> Self;

    fn acos(self) -> Self;

    fn atan(self) -> Self;

    fn atan2(self, other: Self) -> Self;

    fn sinh(self) -> Self;

    fn cosh(self) -> Self;

    fn sinh_cosh(self) -> (Self, Self) {
        (self.sinh(), self.cosh())
    }

    fn tanh(self) -> Self;

    fn asinh(self) -> Self;

    fn acosh(self) -> Self;

    fn atanh(self) -> Self;

    fn relative_eq(&self, other: &Self, epsilon: Self, max_relative: Self) -> bool {
        (*self - *other).abs() <= epsilon.max(self.abs().max(other.abs()) * max_relative)
    }

    fn ulps_eq(&self, other: &Self, epsilon: Self, max_ulps: u32) -> bool {
        self.relative_eq(other, epsilon, Self::exactly(f64::EPSILON * f64::from(max_ulps)))
    }
}

/// Writes what a [`Real`](crate::real_field::Real) needs to be a scalar of nalgebra's.
#[macro_export]
macro_rules! real_field {
    // Methods of a trait of nalgebra that are those of `Real`.
    (@by_real $($method:ident($($argument:ident: $of:ty),*) -> $result:ty;)*) => {$(
        #[inline]
        fn $method(self $(, $argument: $of)*) -> $result {
            $crate::real_field::Real::$method(self $(, $argument)*)
        }
    )*};
    // Functions that jump.
    (@steps $($method:ident)*) => {$(
        #[inline]
        fn $method(self) -> Self {
            $crate::real_field::Real::step(
                &self,
                stringify!($method),
                <f64 as nalgebra::ComplexField>::$method,
            )
        }
    )*};
    // The constants of mathematics.
    (@constants $($method:ident $name:ident,)*) => {$(
        #[inline]
        fn $method() -> Self {
            $crate::real_field::Real::mathematical(core::f64::consts::$name)
        }
    )*};
    // An operator with an assignment.
    (@assigned $scalar:ty: $($operator:ident $method:ident $by:ident::$of:ident,)*) => {$(
        impl core::ops::$operator for $scalar {
            #[inline]
            fn $method(&mut self, rhs: Self) {
                *self = core::ops::$by::$of(*self, rhs);
            }
        }
    )*};
    // Conversions from and to floating point.
    (@supersets $scalar:ty: $($float:ident)*) => {$(
        impl simba::scalar::SupersetOf<$float> for $scalar {
            #[inline]
            fn is_in_subset(&self) -> bool {
                $crate::real_field::Real::is_number(self)
            }

            #[inline]
            fn to_subset_unchecked(&self) -> $float {
                $crate::real_field::Real::number(self) as $float
            }

            #[inline]
            fn from_subset(&element: &$float) -> Self {
                $crate::real_field::Real::exactly(f64::from(element))
            }
        }
    )*};
    ($scalar:ident) => {
        impl core::ops::Rem for $scalar {
            type Output = Self;

            #[inline]
            fn rem(self, rhs: Self) -> Self {
                $crate::real_field::Real::remainder(self, rhs)
            }
        }

        $crate::real_field! { @assigned $scalar:
            AddAssign add_assign Add::add,
            SubAssign sub_assign Sub::sub,
            MulAssign mul_assign Mul::mul,
            DivAssign div_assign Div::div,
            RemAssign rem_assign Rem::rem,
        }

        impl num_traits::Zero for $scalar {
            #[inline]
            fn zero() -> Self {
                $crate::real_field::Real::exactly(0.0)
            }

            #[inline]
            fn is_zero(&self) -> bool {
                $crate::real_field::Real::is_zero(self)
            }
        }

        impl num_traits::One for $scalar {
            #[inline]
            fn one() -> Self {
                $crate::real_field::Real::exactly(1.0)
            }
        }

        impl num_traits::Num for $scalar {
            type FromStrRadixErr = <f64 as num_traits::Num>::FromStrRadixErr;

            /// The decimal number is not a binary64 one, so that this is its rounding and both neighbours.
            fn from_str_radix(text: &str, radix: u32) -> Result<Self, Self::FromStrRadixErr> {
                <f64 as num_traits::Num>::from_str_radix(text, radix).map($crate::real_field::Real::about)
            }
        }

        impl num_traits::FromPrimitive for $scalar {
            #[inline]
            fn from_i64(n: i64) -> Option<Self> {
                Some($crate::real_field::Real::integer(n.unsigned_abs(), n as f64))
            }

            #[inline]
            fn from_u64(n: u64) -> Option<Self> {
                Some($crate::real_field::Real::integer(n, n as f64))
            }

            #[inline]
            fn from_f64(x: f64) -> Option<Self> {
                Some($crate::real_field::Real::exactly(x))
            }
        }

        impl num_traits::Signed for $scalar {
            #[inline]
            fn abs(&self) -> Self {
                $crate::real_field::Real::abs(*self)
            }

            #[inline]
            fn abs_sub(&self, other: &Self) -> Self {
                $crate::real_field::Real::max(*self - *other, num_traits::Zero::zero())
            }

            #[inline]
            fn signum(&self) -> Self {
                $crate::real_field::Real::step(self, "signum", <f64 as nalgebra::ComplexField>::signum)
            }

            #[inline]
            fn is_positive(&self) -> bool {
                *self > num_traits::Zero::zero()
            }

            #[inline]
            fn is_negative(&self) -> bool {
                *self < num_traits::Zero::zero()
            }
        }

        impl approx::AbsDiffEq for $scalar {
            type Epsilon = Self;

            fn default_epsilon() -> Self {
                $crate::real_field::Real::epsilon()
            }

            fn abs_diff_eq(&self, other: &Self, epsilon: Self) -> bool {
                $crate::real_field::Real::abs(*self - *other) <= epsilon
            }
        }

        impl approx::RelativeEq for $scalar {
            fn default_max_relative() -> Self {
                $crate::real_field::Real::epsilon()
            }

            fn relative_eq(&self, other: &Self, epsilon: Self, max_relative: Self) -> bool {
                $crate::real_field::Real::relative_eq(self, other, epsilon, max_relative)
            }
        }

        impl approx::UlpsEq for $scalar {
            fn default_max_ulps() -> u32 {
                <f64 as approx::UlpsEq>::default_max_ulps()
            }

            fn ulps_eq(&self, other: &Self, epsilon: Self, max_ulps: u32) -> bool {
                $crate::real_field::Real::ulps_eq(self, other, epsilon, max_ulps)
            }
        }

        impl simba::scalar::SubsetOf<Self> for $scalar {
            #[inline]
            fn to_superset(&self) -> Self {
                *self
            }

            #[inline]
            fn from_superset_unchecked(element: &Self) -> Self {
                *element
            }

            #[inline]
            fn is_in_subset(_: &Self) -> bool {
                true
            }
        }

        $crate::real_field! { @supersets $scalar: f32 f64 }

        impl nalgebra::SimdValue for $scalar {
            const LANES: usize = 1;
            type Element = Self;
            type SimdBool = bool;

            #[inline]
            fn splat(val: Self) -> Self {
                val
            }

            #[inline]
            fn extract(&self, _: usize) -> Self {
                *self
            }

            // SAFETY: nothing is assumed of the index; only the trait's signature is unsafe.
            #[allow(unsafe_code)]
            #[inline]
            unsafe fn extract_unchecked(&self, _: usize) -> Self {
                *self
            }

            #[inline]
            fn replace(&mut self, _: usize, val: Self) {
                *self = val;
            }

            // SAFETY: as above.
            #[allow(unsafe_code)]
            #[inline]
            unsafe fn replace_unchecked(&mut self, _: usize, val: Self) {
                *self = val;
            }

            #[inline]
            fn select(self, cond: bool, other: Self) -> Self {
                if cond { self } else { other }
            }

            #[inline]
            fn map_lanes(self, f: impl Fn(Self) -> Self) -> Self {
                $crate::real_field::Real::joined(|| f(self))
            }

            #[inline]
            fn zip_map_lanes(self, b: Self, f: impl Fn(Self, Self) -> Self) -> Self {
                $crate::real_field::Real::joined(|| f(self, b))
            }
        }

        impl nalgebra::Field for $scalar {}

        impl nalgebra::ComplexField for $scalar {
            type RealField = Self;

            $crate::real_field! { @by_real
                abs() -> Self; argument() -> Self; modulus_squared() -> Self; hypot(other: Self) -> Self; fract() -> Self; recip() -> Self;
                sqrt() -> Self; try_sqrt() -> Option<Self>; cbrt() -> Self; powi(n: i32) -> Self; powf(n: Self) -> Self;
                exp() -> Self; exp_m1() -> Self; ln() -> Self; ln_1p() -> Self;
                sin() -> Self; cos() -> Self; sin_cos() -> (Self, Self); tan() -> Self; asin() -> Self; acos() -> Self; atan() -> Self;
                sinh() -> Self; cosh() -> Self; sinh_cosh() -> (Self, Self); tanh() -> Self; asinh() -> Self; acosh() -> Self; atanh() -> Self;
            }

            $crate::real_field! { @steps signum floor ceil round trunc }

            #[inline]
            fn from_real(re: Self) -> Self {
                re
            }

            #[inline]
            fn real(self) -> Self {
                self
            }

            #[inline]
            fn imaginary(self) -> Self {
                num_traits::Zero::zero()
            }

            #[inline]
            fn conjugate(self) -> Self {
                self
            }

            #[inline]
            fn modulus(self) -> Self {
                $crate::real_field::Real::abs(self)
            }

            #[inline]
            fn norm1(self) -> Self {
                $crate::real_field::Real::abs(self)
            }

            #[inline]
            fn scale(self, factor: Self) -> Self {
                self * factor
            }

            #[inline]
            fn unscale(self, factor: Self) -> Self {
                self / factor
            }

            #[inline]
            fn mul_add(self, a: Self, b: Self) -> Self {
                self * a + b
            }

            #[inline]
            fn log(self, base: Self) -> Self {
                $crate::real_field::Real::ln(self) / $crate::real_field::Real::ln(base)
            }

            #[inline]
            fn log2(self) -> Self {
                $crate::real_field::Real::ln(self) / <Self as nalgebra::RealField>::ln_2()
            }

            #[inline]
            fn log10(self) -> Self {
                $crate::real_field::Real::ln(self) / <Self as nalgebra::RealField>::ln_10()
            }

            #[inline]
            fn exp2(self) -> Self {
                $crate::real_field::Real::exp(self * <Self as nalgebra::RealField>::ln_2())
            }

            #[inline]
            fn powc(self, n: Self) -> Self {
                $crate::real_field::Real::powf(self, n)
            }

            #[inline]
            fn is_finite(&self) -> bool {
                $crate::real_field::Real::is_finite(self)
            }
        }

        impl nalgebra::RealField for $scalar {
            $crate::real_field! { @by_real
                copysign(sign: Self) -> Self; max(other: Self) -> Self; min(other: Self) -> Self; atan2(other: Self) -> Self;
            }

            $crate::real_field! { @constants
                pi PI, two_pi TAU, frac_pi_2 FRAC_PI_2, frac_pi_3 FRAC_PI_3, frac_pi_4 FRAC_PI_4, frac_pi_6 FRAC_PI_6, frac_pi_8 FRAC_PI_8,
                frac_1_pi FRAC_1_PI, frac_2_pi FRAC_2_PI, frac_2_sqrt_pi FRAC_2_SQRT_PI,
                e E, log2_e LOG2_E, log10_e LOG10_E, ln_2 LN_2, ln_10 LN_10,
            }

            #[inline]
            fn is_sign_positive(&self) -> bool {
                $crate::real_field::Real::is_sign_positive(self)
            }

            #[inline]
            fn is_sign_negative(&self) -> bool {
                $crate::real_field::Real::is_sign_negative(self)
            }

            #[inline]
            fn clamp(self, min: Self, max: Self) -> Self {
                $crate::real_field::Real::min($crate::real_field::Real::max(self, min), max)
            }

            #[inline]
            fn min_value() -> Option<Self> {
                Some(-<Self as $crate::real_field::Real>::largest())
            }

            #[inline]
            fn max_value() -> Option<Self> {
                Some($crate::real_field::Real::largest())
            }
        }
    };
}
