//! The scalar over which a plant is evaluated on a box: an interval, and the interval of its derivative along a
//! direction.
//!
//! It is a [`RealField`](nalgebra::RealField), so that a generic plant can be evaluated over it. Three things differ
//! from a number:
//! - A comparison of overlapping intervals has no answer; see [`paths`](super::paths) for what happens then. The
//!   absolute value, maximum and minimum need no comparison: their derivative is between those of the two sides.
//! - An operation that is not defined on the whole interval (`ln` at 0, division across 0), or jumps there (`floor`,
//!   `signum`), notes so, and the evaluation over that box has no result.
//! - Constants stand for the binary64 numbers they are, exactly; `pi` and its kin enclose both the real number and its
//!   rounding, since a plant may mean either.

use core::cmp::Ordering;
use core::fmt;
use core::ops::{Add, Div, Mul, Neg, Sub};

use luenberger_proof::{Interval, Ring};

use super::paths::{comparison, note_steered, note_undefined};
use luenberger_plants::real_field;
use luenberger_plants::real_field::Real;

/// An interval of values with an interval of derivatives along a direction.
///
/// Plants use it as their scalar `T` without knowing the type.
#[derive(Debug, Clone, Copy)]
pub struct IntervalDual {
    value: Interval,
    slope: Interval,
}

/// The product, without a rounding when a factor is 1: most entries of a Jacobian are a coefficient times that.
fn times(x: &Interval, y: &Interval) -> Interval {
    if *x == Interval::ONE {
        *y
    } else if *y == Interval::ONE {
        *x
    } else {
        x.mul(y)
    }
}

impl IntervalDual {
    /// A value with its derivative along the direction.
    pub fn new(value: Interval, slope: Interval) -> Self {
        Self { value, slope }
    }

    /// The values.
    pub fn value(&self) -> Interval {
        self.value
    }

    /// The derivatives along the direction of the evaluation.
    pub fn slope(&self) -> Interval {
        self.slope
    }

    fn constant(value: Interval) -> Self {
        Self { value, slope: Interval::zero() }
    }

    /// The result of an operation that has none on this interval.
    fn undefined(operation: &'static str) -> Self {
        note_undefined(operation);
        Self { value: Interval::UNBOUNDED, slope: Interval::UNBOUNDED }
    }

    /// `f(x)` by the chain rule, from the enclosures of f and f'.
    fn chain(&self, value: Interval, derivative: Interval) -> Self {
        Self { value, slope: times(&derivative, &self.slope) }
    }

    /// As [`chain`](Self::chain), where f or f' may have no enclosure. A constant has no derivative, whatever f' is.
    fn chain_if(&self, operation: &'static str, value: Option<Interval>, derivative: Option<Interval>) -> Self {
        match (value, derivative) {
            (Some(value), Some(derivative)) => self.chain(value, derivative),
            (Some(value), None) if self.slope.is_zero() => Self::constant(value),
            (Some(value), None) => Self { value, slope: Interval::UNBOUNDED },
            (None, _) => Self::undefined(operation),
        }
    }

    /// The answer to a comparison; `decided` is that of the values, if they have one.
    fn compared(&self, other: &Self, decided: Option<bool>) -> bool {
        if decided.is_none() && !(self.slope.is_zero() && other.slope.is_zero()) {
            note_steered();
        }
        comparison(decided)
    }

    /// Either of the two.
    fn either(value: Interval, x: &Self, y: &Self) -> Self {
        Self { value, slope: x.slope.hull(&y.slope) }
    }
}

impl Add for IntervalDual {
    type Output = Self;

    fn add(self, rhs: Self) -> Self {
        Self { value: self.value.add(&rhs.value), slope: self.slope.add(&rhs.slope) }
    }
}

impl Sub for IntervalDual {
    type Output = Self;

    fn sub(self, rhs: Self) -> Self {
        Self { value: self.value.sub(&rhs.value), slope: self.slope.sub(&rhs.slope) }
    }
}

impl Mul for IntervalDual {
    type Output = Self;

    fn mul(self, rhs: Self) -> Self {
        let slope = times(&self.slope, &rhs.value).add(&times(&self.value, &rhs.slope));
        Self { value: times(&self.value, &rhs.value), slope }
    }
}

impl Div for IntervalDual {
    type Output = Self;

    fn div(self, rhs: Self) -> Self {
        let Some(value) = self.value.quotient(&rhs.value) else { return Self::undefined("division") };
        // (x/y)' = (x' - (x/y) y')/y.
        let slope = self.slope.sub(&times(&value, &rhs.slope)).quotient(&rhs.value);
        Self { value, slope: slope.unwrap_or(Interval::UNBOUNDED) }
    }
}

impl Neg for IntervalDual {
    type Output = Self;

    fn neg(self) -> Self {
        Self { value: self.value.neg(), slope: self.slope.neg() }
    }
}

impl PartialEq for IntervalDual {
    fn eq(&self, other: &Self) -> bool {
        let decided = if self.value.is_point() && self.value == other.value {
            Some(true)
        } else if self.value.hi() < other.value.lo() || self.value.lo() > other.value.hi() {
            Some(false)
        } else {
            None
        };
        self.compared(other, decided)
    }
}

impl PartialOrd for IntervalDual {
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        Some(if self < other {
            Ordering::Less
        } else if self == other {
            Ordering::Equal
        } else {
            Ordering::Greater
        })
    }

    fn lt(&self, other: &Self) -> bool {
        let decided = if self.value.hi() < other.value.lo() {
            Some(true)
        } else if self.value.lo() >= other.value.hi() {
            Some(false)
        } else {
            None
        };
        self.compared(other, decided)
    }

    fn gt(&self, other: &Self) -> bool {
        other.lt(self)
    }

    fn le(&self, other: &Self) -> bool {
        !other.lt(self)
    }

    fn ge(&self, other: &Self) -> bool {
        !self.lt(other)
    }
}

impl fmt::Display for IntervalDual {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let (value, slope) = (self.value, self.slope);
        write!(f, "[{}, {}] + [{}, {}] d", value.lo(), value.hi(), slope.lo(), slope.hi())
    }
}

/// An increasing function that has no interval version, by its enclosures at the two ends; an infinite end is its own
/// image.
fn increasing(x: &Interval, f: impl Fn(Interval) -> Option<Interval>) -> Option<Interval> {
    let end = |x: f64| Interval::from_f64(x).map_or(Some((x, x)), |x| f(x).map(|y| (y.lo(), y.hi())));
    Interval::new(end(x.lo())?.0, end(x.hi())?.1)
}

/// `sqrt(1 + x^2)`.
fn root_of_one_plus_square(x: &Interval) -> Option<Interval> {
    x.powi(2)?.add(&Interval::ONE).sqrt()
}

impl Real for IntervalDual {
    fn exactly(x: f64) -> Self {
        Interval::from_f64(x).map_or_else(|| Self::undefined("conversion"), Self::constant)
    }

    fn about(x: f64) -> Self {
        Interval::new(x.next_down(), x.next_up()).map_or_else(|| Self::undefined("conversion"), Self::constant)
    }

    fn mathematical(x: f64) -> Self {
        if x == core::f64::consts::PI { Self::constant(Interval::PI) } else { Self::about(x) }
    }

    /// Operations that need a single number are undefined for an interval, which is recorded.
    fn is_number(&self) -> bool {
        let constant = self.value.is_point() && self.slope.is_zero();
        if !constant {
            note_undefined("conversion to a single number");
        }
        constant
    }

    fn number(&self) -> f64 {
        self.is_number();
        self.value.lo()
    }

    /// By its values at the two ends.
    fn step(&self, operation: &'static str, f: impl Fn(f64) -> f64) -> Self {
        let (lo, hi) = (f(self.value.lo()), f(self.value.hi()));
        if lo == hi { Self::constant(Interval::of(lo)) } else { Self::undefined(operation) }
    }

    fn abs(self) -> Self {
        if self.value.lo() >= 0.0 {
            self
        } else if self.value.hi() <= 0.0 {
            -self
        } else {
            Self::either(self.value.abs(), &self, &-self)
        }
    }

    fn modulus_squared(self) -> Self {
        self.chain_if("powi", self.value.powi(2), Some(self.value.add(&self.value)))
    }

    fn copysign(self, sign: Self) -> Self {
        self.abs() * sign.step("signum", f64::signum)
    }

    fn max(self, other: Self) -> Self {
        let (x, y) = (&self.value, &other.value);
        if x.lo() >= y.hi() {
            self
        } else if y.lo() >= x.hi() {
            other
        } else {
            // The bounds of an interval that contains a real number, as x and y do.
            let value = Interval::new(x.lo().max(y.lo()), x.hi().max(y.hi())).unwrap_or(Interval::UNBOUNDED);
            Self::either(value, &self, &other)
        }
    }

    fn min(self, other: Self) -> Self {
        -(-self).max(-other)
    }

    /// The derivative `(x x' + y y')/sqrt(x^2 + y^2)` is bounded at the origin too.
    fn hypot(self, other: Self) -> Self {
        let Some(value) = self.value.powi(2).zip(other.value.powi(2)).and_then(|(x, y)| x.add(&y).sqrt()) else {
            return Self::undefined("hypot");
        };
        let share = |x: &Interval| {
            let unit = Interval::ONE.hull(&Interval::ONE.neg());
            x.quotient(&value).and_then(|q| q.intersection(&unit)).unwrap_or(unit)
        };
        let slope = times(&share(&self.value), &self.slope).add(&times(&share(&other.value), &other.slope));
        Self { value, slope }
    }

    fn sqrt(self) -> Self {
        let value = self.value.sqrt();
        let derivative = value.and_then(|root| root.add(&root).recip());
        self.chain_if("sqrt", value, derivative)
    }

    fn try_sqrt(self) -> Option<Self> {
        if self < Self::exactly(0.0) {
            return None;
        }
        // Those of the values that are not negative, which is what this branch is for.
        let value = Interval::new(self.value.lo().max(0.0), self.value.hi())?;
        Some(Self { value, ..self }.sqrt())
    }

    fn cbrt(self) -> Self {
        let value = self.value.cbrt();
        let derivative = value.powi(2).and_then(|square| Interval::of(3.0).mul(&square).recip());
        self.chain_if("cbrt", Some(value), derivative)
    }

    fn powi(self, n: i32) -> Self {
        let derivative = match n.checked_sub(1) {
            _ if n == 0 => Some(Interval::zero()),
            Some(less) => self.value.powi(less).map(|power| Interval::of(f64::from(n)).mul(&power)),
            None => None,
        };
        self.chain_if("powi", self.value.powi(n), if n == 1 { Some(Interval::ONE) } else { derivative })
    }

    /// For an exponent that is an integer, the power; else `exp(n ln x)`.
    fn powf(self, n: Self) -> Self {
        let exponent = n.value.lo();
        if n.value.is_point() && n.slope.is_zero() && exponent.fract() == 0.0 && exponent.abs() < f64::from(i32::MAX) {
            return self.powi(exponent as i32);
        }
        (n * self.ln()).exp()
    }

    fn exp(self) -> Self {
        self.chain(self.value.exp(), self.value.exp())
    }

    fn exp_m1(self) -> Self {
        self.chain(self.value.exp_m1(), self.value.exp())
    }

    fn ln(self) -> Self {
        self.chain_if("ln", self.value.ln(), self.value.recip())
    }

    fn ln_1p(self) -> Self {
        self.chain_if("ln_1p", self.value.ln_1p(), self.value.add(&Interval::ONE).recip())
    }

    fn sin(self) -> Self {
        self.chain(self.value.sin(), self.value.cos())
    }

    fn cos(self) -> Self {
        self.chain(self.value.cos(), self.value.sin().neg())
    }

    fn tan(self) -> Self {
        let value = self.value.tan();
        let derivative = value.and_then(|y| y.powi(2)).map(|square| square.add(&Interval::ONE));
        self.chain_if("tan", value, derivative)
    }

    fn asin(self) -> Self {
        let derivative = Interval::ONE.sub(&self.value.abs()).mul(&Interval::ONE.add(&self.value.abs()));
        self.chain_if("asin", self.value.asin(), derivative.sqrt().and_then(|root| root.recip()))
    }

    fn acos(self) -> Self {
        let derivative = Interval::ONE.sub(&self.value.abs()).mul(&Interval::ONE.add(&self.value.abs()));
        self.chain_if("acos", self.value.acos(), derivative.sqrt().and_then(|root| root.recip()).map(|d| d.neg()))
    }

    fn atan(self) -> Self {
        let derivative = self.value.powi(2).and_then(|square| square.add(&Interval::ONE).recip());
        self.chain_if("atan", Some(self.value.atan()), derivative)
    }

    fn atan2(self, other: Self) -> Self {
        let (y, x) = (self, other);
        if x.value.lo() > 0.0 {
            (y / x).atan()
        } else if y.value.lo() > 0.0 {
            Self::mathematical(core::f64::consts::FRAC_PI_2) - (x / y).atan()
        } else if y.value.hi() < 0.0 {
            -Self::mathematical(core::f64::consts::FRAC_PI_2) - (x / y).atan()
        } else {
            // It jumps across the negative half axis and is not differentiable at the origin.
            Self::undefined("atan2")
        }
    }

    fn sinh(self) -> Self {
        self.chain(self.value.sinh(), self.value.cosh())
    }

    fn cosh(self) -> Self {
        self.chain(self.value.cosh(), self.value.sinh())
    }

    fn tanh(self) -> Self {
        let derivative = self.value.cosh().recip().and_then(|sech| sech.powi(2));
        self.chain_if("tanh", Some(self.value.tanh()), derivative)
    }

    fn asinh(self) -> Self {
        // ln(1 + x + x^2/(1 + sqrt(1 + x^2))) for x >= 0, odd.
        let at = |x: Interval| {
            let (size, root) = (x.abs(), root_of_one_plus_square(&x)?);
            let y = size.add(&size.powi(2)?.quotient(&root.add(&Interval::ONE))?).ln_1p()?;
            Some(if x.lo() < 0.0 { y.neg() } else { y })
        };
        let derivative = root_of_one_plus_square(&self.value).and_then(|root| root.recip());
        self.chain_if("asinh", increasing(&self.value, at), derivative)
    }

    fn acosh(self) -> Self {
        let radicand = |x: &Interval| x.sub(&Interval::ONE).mul(&x.add(&Interval::ONE));
        // ln(1 + (x - 1) + sqrt((x - 1)(x + 1))).
        let at = |x: Interval| {
            x.sub(&Interval::ONE).add(&Interval::new(radicand(&x).lo().max(0.0), radicand(&x).hi())?.sqrt()?).ln_1p()
        };
        let value = if self.value.lo() < 1.0 { None } else { increasing(&self.value, at) };
        self.chain_if("acosh", value, radicand(&self.value).sqrt().and_then(|root| root.recip()))
    }

    fn atanh(self) -> Self {
        let half = Interval::of(0.5);
        // ln((1 + x)/(1 - x))/2.
        let at = |x: Interval| Some(half.mul(&x.add(&x).quotient(&Interval::ONE.sub(&x))?.ln_1p()?));
        let inside = self.value.magnitude() < 1.0;
        let derivative = Interval::ONE.sub(&self.value.abs()).mul(&Interval::ONE.add(&self.value.abs())).recip();
        self.chain_if("atanh", if inside { increasing(&self.value, at) } else { None }, derivative)
    }
}

real_field!(IntervalDual);
