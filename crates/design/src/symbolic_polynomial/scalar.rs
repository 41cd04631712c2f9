//! [`SymbolicPolynomial`] as a scalar of nalgebra; unsupported operations are recorded.

use core::cmp::Ordering;
use core::fmt;
use core::ops::{Div, Mul, Neg};

use luenberger_proof::{Interval, Ring};

use super::{Function, SymbolicPolynomial, fail, open_question};
use luenberger_plants::real_field;
use luenberger_plants::real_field::Real;

impl Div for SymbolicPolynomial {
    type Output = Self;

    fn div(self, rhs: Self) -> Self {
        self.mul(rhs.of(Function::Recip))
    }
}

impl Neg for SymbolicPolynomial {
    type Output = Self;

    fn neg(self) -> Self {
        Self::exactly(0.0) - self
    }
}

/// Whether `x - y` is a number, and which.
fn difference(x: SymbolicPolynomial, y: SymbolicPolynomial) -> Option<Interval> {
    (x - y).as_constant()
}

impl PartialEq for SymbolicPolynomial {
    fn eq(&self, other: &Self) -> bool {
        match difference(*self, *other) {
            Some(d) if d.is_point() => d.is_zero(),
            Some(d) if !d.contains(0.0) => false,
            _ => open_question("a comparison", &[*self, *other]),
        }
    }
}

impl PartialOrd for SymbolicPolynomial {
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        Some(match difference(*self, *other) {
            Some(d) if d.lo() > 0.0 => Ordering::Greater,
            Some(d) if d.hi() < 0.0 => Ordering::Less,
            Some(d) if d.is_point() => Ordering::Equal,
            _ if open_question("a comparison", &[*self, *other]) => Ordering::Less,
            _ => Ordering::Greater,
        })
    }
}

impl fmt::Display for SymbolicPolynomial {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self.as_constant() {
            Some(x) => write!(f, "[{}, {}]", x.lo(), x.hi()),
            None => f.write_str("a polynomial in atoms"),
        }
    }
}

/// A number given by an enclosure, if there is one.
fn finite(enclosure: Option<Interval>, made: impl Fn(Interval) -> SymbolicPolynomial) -> SymbolicPolynomial {
    enclosure.map_or_else(|| fail("a constant that is not finite"), made)
}

/// Functions that have no atom.
macro_rules! cannot {
    ($($function:ident)*) => {$(
        fn $function(self) -> Self {
            fail(stringify!($function))
        }
    )*};
}

impl Real for SymbolicPolynomial {
    fn exactly(x: f64) -> Self {
        finite(Interval::from_f64(x), Self::constant)
    }

    fn about(x: f64) -> Self {
        finite(Interval::new(x.next_down(), x.next_up()), Self::constant)
    }

    fn mathematical(x: f64) -> Self {
        finite(Interval::new(x.next_down(), x.next_up()), |enclosure| Self::named(x.to_bits(), enclosure))
    }

    fn is_number(&self) -> bool {
        let constant = self.as_constant().is_some_and(|x| x.is_point());
        if !constant {
            open_question("a conversion to a single number", &[*self]);
        }
        constant
    }

    fn number(&self) -> f64 {
        self.is_number();
        self.as_constant().map_or(0.0, |x| x.lo())
    }

    fn step(&self, operation: &'static str, _f: impl Fn(f64) -> f64) -> Self {
        fail(operation)
    }

    fn remainder(self, _other: Self) -> Self {
        fail("a remainder")
    }

    fn argument(self) -> Self {
        fail("the argument of a number")
    }

    fn atan2(self, _other: Self) -> Self {
        fail("atan2")
    }

    cannot!(cbrt asin acos asinh acosh atanh);

    fn abs(self) -> Self {
        match self.as_constant() {
            Some(x) => Self::constant(x.abs()),
            None => fail("an absolute value"),
        }
    }

    fn copysign(self, sign: Self) -> Self {
        if sign >= Self::exactly(0.0) { self.abs() } else { -self.abs() }
    }

    fn max(self, other: Self) -> Self {
        if self >= other { self } else { other }
    }

    fn min(self, other: Self) -> Self {
        if self <= other { self } else { other }
    }

    fn recip(self) -> Self {
        self.of(Function::Recip)
    }

    fn sqrt(self) -> Self {
        self.of(Function::Sqrt)
    }

    fn try_sqrt(self) -> Option<Self> {
        Some(self.sqrt())
    }

    fn powi(self, n: i32) -> Self {
        let base = if n < 0 { self.recip() } else { self };
        // The arena refuses high powers, so that this ends.
        match n.unsigned_abs() {
            power @ 0..=64 => (0..power).fold(Self::exactly(1.0), |product, _| product * base),
            _ => fail("a high power"),
        }
    }

    fn powf(self, n: Self) -> Self {
        match n.as_constant() {
            Some(x) if x.is_point() && x.lo().fract() == 0.0 && x.lo().abs() <= 64.0 => self.powi(x.lo() as i32),
            _ => (n * self.ln()).exp(),
        }
    }

    fn exp(self) -> Self {
        self.of(Function::Exp)
    }

    fn exp_m1(self) -> Self {
        self.exp() - Self::exactly(1.0)
    }

    fn ln(self) -> Self {
        self.of(Function::Ln)
    }

    fn ln_1p(self) -> Self {
        (Self::exactly(1.0) + self).ln()
    }

    fn sin(self) -> Self {
        self.of(Function::Sin)
    }

    fn cos(self) -> Self {
        self.of(Function::Cos)
    }

    fn tan(self) -> Self {
        self.sin() / self.cos()
    }

    fn atan(self) -> Self {
        self.of(Function::Atan)
    }

    fn sinh(self) -> Self {
        (self.exp() - (-self).exp()) * Self::exactly(0.5)
    }

    fn cosh(self) -> Self {
        (self.exp() + (-self).exp()) * Self::exactly(0.5)
    }

    fn tanh(self) -> Self {
        self.of(Function::Tanh)
    }
}

real_field!(SymbolicPolynomial);
