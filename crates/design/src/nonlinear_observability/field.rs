//! [`Jet`] as a field of nalgebra, so that a generic plant can be evaluated over it.

use core::cmp::Ordering;
use core::fmt;

use approx::{RelativeEq, UlpsEq};

use super::jet::Jet;
use luenberger_plants::real_field;
use luenberger_plants::real_field::Real;

impl PartialEq for Jet {
    fn eq(&self, other: &Self) -> bool {
        self.value() == other.value()
    }
}

impl PartialOrd for Jet {
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        self.value().partial_cmp(&other.value())
    }
}

impl fmt::Display for Jet {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{} + {} s + ..", self.value(), self.coefficient(1))
    }
}

impl Jet {
    fn one_plus(self) -> Self {
        Self::constant(1.0) + self
    }

    fn one_minus(self) -> Self {
        Self::constant(1.0) - self
    }
}

impl Real for Jet {
    fn exactly(x: f64) -> Self {
        Self::constant(x)
    }

    fn about(x: f64) -> Self {
        Self::constant(x)
    }

    fn is_number(&self) -> bool {
        self.is_constant()
    }

    fn number(&self) -> f64 {
        self.value()
    }

    fn is_zero(&self) -> bool {
        self.value() == 0.0 && self.is_constant()
    }

    fn is_finite(&self) -> bool {
        self.c.iter().all(|c| c.value.is_finite() && c.slope.is_finite())
    }

    fn step(&self, _operation: &'static str, f: impl Fn(f64) -> f64) -> Self {
        Self::constant(f(self.value()))
    }

    /// At 0, where it has no derivative, that of `x`.
    fn abs(self) -> Self {
        if self.value() < 0.0 { -self } else { self }
    }

    fn copysign(self, sign: Self) -> Self {
        if self.value().is_sign_negative() == sign.value().is_sign_negative() { self } else { -self }
    }

    fn is_sign_positive(&self) -> bool {
        self.value().is_sign_positive()
    }

    fn is_sign_negative(&self) -> bool {
        self.value().is_sign_negative()
    }

    fn max(self, other: Self) -> Self {
        if self.value() < other.value() || self.value().is_nan() { other } else { self }
    }

    fn min(self, other: Self) -> Self {
        if self.value() > other.value() || self.value().is_nan() { other } else { self }
    }

    fn sqrt(self) -> Self {
        self.root()
    }

    fn try_sqrt(self) -> Option<Self> {
        (self.value() >= 0.0).then(|| self.root())
    }

    fn cbrt(self) -> Self {
        let at = self.value().cbrt();
        self.power(1.0 / 3.0, at, 1.0 / (3.0 * at * at))
    }

    /// By repeated squaring, which is right at 0 too.
    fn powi(self, n: i32) -> Self {
        let (mut square, mut left, mut power) = (self, n.unsigned_abs(), Self::constant(1.0));
        while left > 0 {
            if left & 1 == 1 {
                power *= square;
            }
            left >>= 1;
            if left > 0 {
                square *= square;
            }
        }
        if n < 0 { power.recip() } else { power }
    }

    fn powf(self, n: Self) -> Self {
        let p = n.value();
        if !n.is_constant() {
            return (n * self.ln()).exponential();
        }
        if p.fract() == 0.0 && p.abs() < f64::from(i32::MAX) {
            return self.powi(p as i32);
        }
        self.power(p, self.value().powf(p), p * self.value().powf(p - 1.0))
    }

    fn exp(self) -> Self {
        self.exponential()
    }

    fn exp_m1(self) -> Self {
        self.chain(self.value().exp_m1(), &self.exponential())
    }

    fn ln(self) -> Self {
        self.chain(self.value().ln(), &self.recip())
    }

    fn ln_1p(self) -> Self {
        self.chain(self.value().ln_1p(), &self.one_plus().recip())
    }

    fn sin(self) -> Self {
        self.sin_cos().0
    }

    fn cos(self) -> Self {
        self.sin_cos().1
    }

    fn sin_cos(self) -> (Self, Self) {
        let (sine, cosine) = self.value().sin_cos();
        self.pair(-1.0, sine, cosine)
    }

    fn tan(self) -> Self {
        self.tangent(1.0, self.value().tan())
    }

    fn asin(self) -> Self {
        self.chain(self.value().asin(), &(self * self).one_minus().root().recip())
    }

    fn acos(self) -> Self {
        self.chain(self.value().acos(), &-(self * self).one_minus().root().recip())
    }

    fn atan(self) -> Self {
        self.chain(self.value().atan(), &(self * self).one_plus().recip())
    }

    fn atan2(self, other: Self) -> Self {
        self.angle(&other)
    }

    fn sinh(self) -> Self {
        self.sinh_cosh().0
    }

    fn cosh(self) -> Self {
        self.sinh_cosh().1
    }

    fn sinh_cosh(self) -> (Self, Self) {
        self.pair(1.0, self.value().sinh(), self.value().cosh())
    }

    fn tanh(self) -> Self {
        self.tangent(-1.0, self.value().tanh())
    }

    fn asinh(self) -> Self {
        self.chain(self.value().asinh(), &(self * self).one_plus().root().recip())
    }

    fn acosh(self) -> Self {
        self.chain(self.value().acosh(), &(self * self - Self::constant(1.0)).root().recip())
    }

    fn atanh(self) -> Self {
        self.chain(self.value().atanh(), &(self * self).one_minus().recip())
    }

    fn relative_eq(&self, other: &Self, epsilon: Self, max_relative: Self) -> bool {
        RelativeEq::relative_eq(&self.value(), &other.value(), epsilon.value(), max_relative.value())
    }

    fn ulps_eq(&self, other: &Self, epsilon: Self, max_ulps: u32) -> bool {
        UlpsEq::ulps_eq(&self.value(), &other.value(), epsilon.value(), max_ulps)
    }
}

real_field!(Jet);
