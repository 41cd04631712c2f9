//! [`Jet`] as a field of nalgebra, so that a generic plant can be evaluated over it.

use core::cmp::Ordering;
use core::fmt;

use approx::{RelativeEq, UlpsEq};

use super::jet::Jet;
use crate::real_field::{Real, real_field};

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

#[cfg(test)]
mod tests {
    use nalgebra::{ComplexField, RealField};
    use num_traits::{One, Zero};

    use super::super::jet::{COUNT, Dual, Jet};

    /// `0.6 + s/4 - s^2/8 + ..`, with derivatives along a direction that depends on the order.
    fn curve(at: f64) -> Jet {
        let mut jet = Jet::constant(at);
        for (k, c) in jet.c.iter_mut().enumerate() {
            let share = 0.25 / (1 + k * k) as f64;
            *c = Dual { value: if k == 0 { at } else { share * (1.0 - 2.0 * (k % 2) as f64) }, slope: 1.0 - share };
        }
        jet
    }

    /// Each of some 300 operations rounds by half an ulp of numbers up to about 1e3 here.
    const ROUNDING: f64 = 300.0 * 1e3 * f64::EPSILON;

    fn agree(what: &str, x: &Jet, y: &Jet) {
        for (k, (x, y)) in x.c.iter().zip(&y.c).enumerate() {
            let bound = ROUNDING * (1.0 + y.value.abs() + y.slope.abs());
            assert!((x.value - y.value).abs() <= bound, "{what}, order {k}: {} against {}", x.value, y.value);
            assert!((x.slope - y.slope).abs() <= bound, "{what}, order {k}: slope {} against {}", x.slope, y.slope);
        }
    }

    #[test]
    fn a_function_and_its_inverse_give_the_series_back() {
        for at in [0.6, -0.4, 1e-3] {
            let x = curve(at);
            agree("ln exp", &x.exp().ln(), &x);
            agree("ln_1p exp_m1", &x.exp_m1().ln_1p(), &x);
            agree("asin sin", &x.sin().asin(), &x);
            agree("acos cos", &(x + Jet::one()).cos().acos(), &(x + Jet::one()));
            agree("atan tan", &x.tan().atan(), &x);
            agree("atan2", &x.sin().atan2(x.cos()), &x);
            agree("atan2 on the left", &x.cos().atan2(-x.sin()), &(x + Jet::frac_pi_2()));
            agree("asinh sinh", &x.sinh().asinh(), &x);
            agree("atanh tanh", &x.tanh().atanh(), &x);
            agree("acosh cosh", &(x + Jet::one()).cosh().acosh(), &(x + Jet::one()));
            agree("sqrt squared", &(x + Jet::one()).sqrt().powi(2), &(x + Jet::one()));
            agree("x/y y", &(x / (x + Jet::constant(2.0)) * (x + Jet::constant(2.0))), &x);
        }
        for at in [0.6, -0.8] {
            agree("cbrt cubed", &curve(at).cbrt().powi(3), &curve(at));
        }
    }

    #[test]
    fn functions_that_are_made_of_others_are_so_as_series() {
        let x = curve(0.6);
        let (s, c) = x.sin_cos();
        agree("sin^2 + cos^2", &(s * s + c * c), &Jet::one());
        agree("tan", &x.tan(), &(s / c));
        let (s, c) = x.sinh_cosh();
        agree("cosh^2 - sinh^2", &(c * c - s * s), &Jet::one());
        agree("tanh", &x.tanh(), &(s / c));
        agree("hypot", &x.hypot(Jet::constant(2.0)), &(x * x + Jet::constant(4.0)).sqrt());
        agree("powf", &x.powf(Jet::constant(2.5)), &(x.sqrt() * x * x));
        agree("powf of a series", &x.powf(x), &(x * x.ln()).exp());
        agree("powi", &x.powi(-3), &(Jet::one() / (x * x * x)));
        agree("exp2", &x.exp2().log2(), &x);
        agree("log", &x.log(Jet::constant(10.0)), &x.log10());
        agree("abs", &ComplexField::abs(curve(-0.5)), &-curve(-0.5));
        agree("remainder", &((x + Jet::constant(2.0)) % Jet::one()), &x);
        agree("max", &RealField::max(x, Jet::zero()), &x);
    }

    #[test]
    fn the_series_of_the_books() {
        let s = Jet::time(0.0);
        let mut factorial = 1.0;
        for k in 1..COUNT {
            factorial *= k as f64;
            let even = k % 2 == 0;
            let near =
                |x: f64, y: f64| assert!((x - y).abs() <= 4.0 * f64::EPSILON * y.abs(), "order {k}: {x} for {y}");
            near(s.exp().coefficient(k), 1.0 / factorial);
            near(s.ln_1p().coefficient(k), if even { -1.0 } else { 1.0 } / k as f64);
            near(s.sin().coefficient(k), if even { 0.0 } else { [1.0, -1.0][k / 2 % 2] / factorial });
            near(s.atan().coefficient(k), if even { 0.0 } else { [1.0, -1.0][k / 2 % 2] / k as f64 });
            near((Jet::one() - s).recip().coefficient(k), 1.0);
        }
        // Powers at 0, where the logarithm has no value.
        assert_eq!((s.powi(3).coefficient(3), s.powi(3).coefficient(2)), (1.0, 0.0));
        assert!(!s.sqrt().is_finite() && Jet::zero().sqrt().is_finite());
    }
}
