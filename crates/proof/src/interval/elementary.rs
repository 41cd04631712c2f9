//! Elementary functions of intervals, outward rounded.
//!
//! Each function returns an interval that contains the function's value at every point of its argument, and `None` if
//! the function is undefined or unbounded at some point of it (`ln` at 0, `1/x` across 0, `tan` across a pole). The
//! argument is never restricted to the domain.
//!
//! # Assumptions
//! `sqrt` is correctly rounded, as IEEE 754 requires. The other functions are those of the platform's mathematical
//! library, with assumed errors of at most [`LIBM_ULPS`] units in the last place; every bound is moved outwards by that
//! amount. The GNU C library documents errors of at most 1 ulp for exp, log, sin, cos, atan, asin, acos and of at most
//! 3 for expm1, log1p, tan, sinh, cosh, tanh (manual, section Errors in Math Functions, x86_64 and aarch64); musl,
//! derived from FreeBSD's library, has errors below 2. The extrema of sine and cosine and the poles of the tangent are
//! located with an enclosure of pi, not with a rounded pi.

use core::f64::consts;

use super::Interval;
use crate::ring::Ring;

/// Assumed maximal error of a function of the mathematical library, in units in the last place.
pub const LIBM_ULPS: u32 = 8;

/// `x` moved down by the assumed error of the library.
fn below(x: f64) -> f64 {
    (0..LIBM_ULPS).fold(x, |x, _| x.next_down())
}

/// `x` moved up by the assumed error of the library.
fn above(x: f64) -> f64 {
    (0..LIBM_ULPS).fold(x, |x, _| x.next_up())
}

impl Interval {
    /// pi, between two neighbouring floats.
    pub const PI: Self = Self { lo: consts::PI, hi: consts::PI.next_up() };

    /// The number 1.
    pub const ONE: Self = Self { lo: 1.0, hi: 1.0 };

    /// The smallest interval that contains both.
    #[must_use]
    pub fn hull(&self, other: &Self) -> Self {
        Self { lo: self.lo.min(other.lo), hi: self.hi.max(other.hi) }
    }

    /// Values of an increasing library function, clipped to its range.
    fn increasing(&self, f: impl Fn(f64) -> f64, range: (f64, f64)) -> Self {
        Self { lo: below(f(self.lo)).max(range.0), hi: above(f(self.hi)).min(range.1) }
    }

    /// `1/x`; `None` if the interval contains 0.
    pub fn recip(&self) -> Option<Self> {
        if self.contains(0.0) {
            return None;
        }
        // 1/x is exact for a power of two. For an infinite bound the quotient is 0, the limit.
        let exact = |x: f64| x == 1.0 || x == -1.0;
        let (lo, hi) = (1.0 / self.hi, 1.0 / self.lo);
        Some(Self {
            lo: if exact(self.hi) || lo == 0.0 { lo } else { lo.next_down() },
            hi: if exact(self.lo) || hi == 0.0 { hi } else { hi.next_up() },
        })
    }

    /// `self / rhs`; `None` if `rhs` contains 0.
    pub fn quotient(&self, rhs: &Self) -> Option<Self> {
        if *rhs == Self::ONE {
            return Some(*self);
        }
        let inverse = rhs.recip()?;
        if self.is_zero() {
            return Some(Self::zero());
        }
        if !(self.is_bounded() && rhs.is_bounded()) {
            return Some(self.mul(&inverse));
        }
        // Direct quotients of the bounds are rounded once; via the reciprocal they would be rounded twice.
        let quotients = [self.lo / rhs.lo, self.lo / rhs.hi, self.hi / rhs.lo, self.hi / rhs.hi];
        let (lo, hi) = quotients.iter().fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), q| (l.min(*q), h.max(*q)));
        Some(Self { lo: lo.next_down(), hi: hi.next_up() })
    }

    /// `|x|`.
    #[must_use]
    pub fn abs(&self) -> Self {
        if self.lo >= 0.0 {
            *self
        } else if self.hi <= 0.0 {
            self.neg()
        } else {
            Self { lo: 0.0, hi: self.magnitude() }
        }
    }

    /// `x^n`; `None` for a negative n if the interval contains 0.
    pub fn powi(&self, n: i32) -> Option<Self> {
        if n < 0 {
            // Power of the reciprocal, with the unsigned exponent: also correct for i32::MIN.
            return self.recip()?.power(n.unsigned_abs()).into();
        }
        Some(self.power(n.unsigned_abs()))
    }

    fn power(&self, n: u32) -> Self {
        let base = if n.is_multiple_of(2) { self.abs() } else { *self };
        // x^n is monotone here, so the powers of the bounds are the bounds.
        let end = |x: f64, unbounded: Self| if x.is_finite() { repeated(&Self::point(x), n) } else { unbounded };
        if n == 0 {
            return Self::ONE;
        }
        let lo = end(base.lo, Self { lo: f64::NEG_INFINITY, hi: f64::MAX });
        let hi = end(base.hi, Self { lo: f64::MIN, hi: f64::INFINITY });
        Self { lo: if n.is_multiple_of(2) { lo.lo.max(0.0) } else { lo.lo }, hi: hi.hi }
    }

    /// The square root; `None` if the interval contains a negative number.
    pub fn sqrt(&self) -> Option<Self> {
        if self.lo < 0.0 {
            return None;
        }
        let (lo, hi) = (self.lo.sqrt(), self.hi.sqrt());
        // 0 and the squares of small integers have exact roots.
        let exact = |root: f64, x: f64| root <= 2f64.powi(26) && root.trunc() == root && root * root == x;
        Some(Self {
            lo: if exact(lo, self.lo) { lo } else { lo.next_down().max(0.0) },
            hi: if exact(hi, self.hi) || hi.is_infinite() { hi } else { hi.next_up() },
        })
    }

    /// The cube root.
    #[must_use]
    pub fn cbrt(&self) -> Self {
        self.increasing(f64::cbrt, (f64::NEG_INFINITY, f64::INFINITY))
    }

    /// `e^x`.
    #[must_use]
    pub fn exp(&self) -> Self {
        if self.is_zero() { Self::ONE } else { self.increasing(f64::exp, (0.0, f64::INFINITY)) }
    }

    /// `e^x - 1`.
    #[must_use]
    pub fn exp_m1(&self) -> Self {
        if self.is_zero() { *self } else { self.increasing(f64::exp_m1, (-1.0, f64::INFINITY)) }
    }

    /// The natural logarithm; `None` unless all numbers of the interval are positive.
    pub fn ln(&self) -> Option<Self> {
        if self.lo <= 0.0 {
            return None;
        }
        Some(if *self == Self::ONE {
            Self::zero()
        } else {
            self.increasing(f64::ln, (f64::NEG_INFINITY, f64::INFINITY))
        })
    }

    /// `ln(1 + x)`; `None` unless all numbers of the interval are greater than -1.
    pub fn ln_1p(&self) -> Option<Self> {
        if self.lo <= -1.0 {
            return None;
        }
        Some(if self.is_zero() { *self } else { self.increasing(f64::ln_1p, (f64::NEG_INFINITY, f64::INFINITY)) })
    }

    /// The cosine.
    #[must_use]
    pub fn cos(&self) -> Self {
        if self.is_zero() { Self::ONE } else { self.wave(f64::cos, &Self::zero()) }
    }

    /// The sine.
    #[must_use]
    pub fn sin(&self) -> Self {
        if self.is_zero() { *self } else { self.wave(f64::sin, &Self::point(0.5)) }
    }

    /// Values of a function that is 1 at `(shift + k) pi` for even k, -1 for odd k, and monotone in between.
    fn wave(&self, f: impl Fn(f64) -> f64, shift: &Self) -> Self {
        let all = Self { lo: -1.0, hi: 1.0 };
        let Some((first, last)) = self.multiples_of_pi(shift) else { return all };
        if last > first {
            return all;
        }
        let (at_lo, at_hi) = (f(self.lo), f(self.hi));
        let mut values = Self { lo: below(at_lo.min(at_hi)).max(-1.0), hi: above(at_lo.max(at_hi)).min(1.0) };
        if first == last {
            // |first| < 2^53, so half of it is exact.
            if (first / 2.0).fract() == 0.0 { values.hi = 1.0 } else { values.lo = -1.0 }
        }
        values
    }

    /// First and last integer k for which `(shift + k) pi` may lie in the interval; the first exceeds the last if there
    /// is none. `None` if the arguments are infinite or so large that neighbouring floats are many periods apart.
    fn multiples_of_pi(&self, shift: &Self) -> Option<(f64, f64)> {
        if self.magnitude() > 2f64.powi(40) {
            return None;
        }
        let first = Self::point(self.lo).quotient(&Self::PI)?.sub(shift).lo.ceil();
        let last = Self::point(self.hi).quotient(&Self::PI)?.sub(shift).hi.floor();
        Some((first, last))
    }

    /// The tangent; `None` if the interval may contain a pole.
    pub fn tan(&self) -> Option<Self> {
        if self.is_zero() {
            return Some(*self);
        }
        let (first, last) = self.multiples_of_pi(&Self::point(0.5))?;
        (last < first).then(|| self.increasing(f64::tan, (f64::NEG_INFINITY, f64::INFINITY)))
    }

    /// The inverse tangent.
    #[must_use]
    pub fn atan(&self) -> Self {
        if self.is_zero() {
            *self
        } else {
            self.increasing(f64::atan, (-above(consts::FRAC_PI_2), above(consts::FRAC_PI_2)))
        }
    }

    /// The inverse sine; `None` unless the interval lies within [-1, 1].
    pub fn asin(&self) -> Option<Self> {
        (self.magnitude() <= 1.0).then(|| self.increasing(f64::asin, (f64::NEG_INFINITY, f64::INFINITY)))
    }

    /// The inverse cosine; `None` unless the interval lies within [-1, 1].
    pub fn acos(&self) -> Option<Self> {
        (self.magnitude() <= 1.0).then(|| Self { lo: below(self.hi.acos()).max(0.0), hi: above(self.lo.acos()) })
    }

    /// The hyperbolic sine.
    #[must_use]
    pub fn sinh(&self) -> Self {
        if self.is_zero() { *self } else { self.increasing(f64::sinh, (f64::NEG_INFINITY, f64::INFINITY)) }
    }

    /// The hyperbolic cosine.
    #[must_use]
    pub fn cosh(&self) -> Self {
        let size = self.abs();
        if size.is_zero() { Self::ONE } else { size.increasing(f64::cosh, (1.0, f64::INFINITY)) }
    }

    /// The hyperbolic tangent.
    #[must_use]
    pub fn tanh(&self) -> Self {
        if self.is_zero() { *self } else { self.increasing(f64::tanh, (-1.0, 1.0)) }
    }
}

/// `x^n` by repeated squaring of enclosures.
fn repeated(x: &Interval, n: u32) -> Interval {
    if x.is_point() && x.magnitude() == 1.0 {
        return if n.is_multiple_of(2) { Interval::ONE } else { *x };
    }
    let (mut result, mut square, mut left): (Option<Interval>, Interval, u32) = (None, *x, n);
    while left > 0 {
        if left % 2 == 1 {
            result = Some(result.map_or(square, |r| r.mul(&square)));
        }
        left /= 2;
        if left > 0 {
            // A square is not negative, although its rounded lower bound may be.
            let next = square.mul(&square);
            square = Interval { lo: next.lo.max(0.0), hi: next.hi };
        }
    }
    result.unwrap_or(Interval::ONE)
}
