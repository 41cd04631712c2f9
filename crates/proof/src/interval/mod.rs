//! Intervals with outward rounding.
//!
//! Each operation rounds to nearest and then steps one float outwards (`next_down`, `next_up`), which costs at most one
//! ulp more than directed rounding and needs no rounding mode. Sums compute their rounding error and step only if it is
//! not 0. Overflow gives an infinite bound, which is valid; NaN does not occur, because an infinite bound times an
//! operand that is exactly 0 is defined as 0 (the product of a real and 0).

mod elementary;

pub use elementary::LIBM_ULPS;

use crate::ring::Ring;

/// The real numbers between two bounds, either of which may be infinite.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Interval {
    lo: f64,
    hi: f64,
}

impl Interval {
    /// All real numbers.
    pub const UNBOUNDED: Self = Self { lo: f64::NEG_INFINITY, hi: f64::INFINITY };

    /// The single number x, which the caller knows to be finite.
    pub(crate) const fn point(x: f64) -> Self {
        Self { lo: x, hi: x }
    }

    /// The number x; all real numbers where x is not one.
    pub fn of(x: f64) -> Self {
        Self::from_f64(x).unwrap_or(Self::UNBOUNDED)
    }

    /// The interval `[lo, hi]`; `None` unless `lo <= hi` and it contains a real number.
    pub fn new(lo: f64, hi: f64) -> Option<Self> {
        (lo <= hi && lo < f64::INFINITY && hi > f64::NEG_INFINITY).then_some(Self { lo, hi })
    }

    /// `x` known up to `radius`: an interval that contains `[x - radius, x + radius]`; `None` for NaN, infinite `x`, or
    /// a negative radius.
    pub fn around(x: f64, radius: f64) -> Option<Self> {
        if radius == 0.0 {
            return Self::from_f64(x);
        }
        (x.is_finite() && radius > 0.0).then(|| Self { lo: (x - radius).next_down(), hi: (x + radius).next_up() })
    }

    /// The lower bound.
    pub fn lo(&self) -> f64 {
        self.lo
    }

    /// The upper bound.
    pub fn hi(&self) -> f64 {
        self.hi
    }

    /// Whether the interval is a single number.
    pub fn is_point(&self) -> bool {
        self.lo == self.hi
    }

    /// Whether both bounds are finite.
    pub fn is_bounded(&self) -> bool {
        self.lo.is_finite() && self.hi.is_finite()
    }

    /// Whether `x` lies within.
    pub fn contains(&self, x: f64) -> bool {
        self.lo <= x && x <= self.hi
    }

    /// A bound on the distance of the two ends, rounded up.
    pub fn width(&self) -> f64 {
        if self.is_point() { 0.0 } else { (self.hi - self.lo).next_up() }
    }

    /// The largest absolute value within.
    pub fn magnitude(&self) -> f64 {
        self.lo.abs().max(self.hi.abs())
    }

    /// The numbers in both; `None` when there are none.
    pub fn intersection(&self, other: &Self) -> Option<Self> {
        Self::new(self.lo.max(other.lo), self.hi.min(other.hi))
    }

    /// A float near the middle; NaN when the interval is unbounded.
    pub fn midpoint(&self) -> f64 {
        self.midpoint_radius().map_or(f64::NAN, |(middle, _)| middle)
    }

    /// A float near the middle and a radius that together enclose the interval; `None` when it is unbounded.
    pub fn midpoint_radius(&self) -> Option<(f64, f64)> {
        if self.is_point() {
            return Some((self.lo, 0.0));
        }
        let middle = self.lo / 2.0 + self.hi / 2.0;
        let radius = (middle - self.lo).max(self.hi - middle).next_up();
        (middle.is_finite() && radius.is_finite()).then_some((middle, radius))
    }
}

/// The rounding error `x + y - fl(x + y)`, exactly (Knuth's TwoSum); infinite or NaN when the range is left on the way.
fn rounding_error(x: f64, y: f64, sum: f64) -> f64 {
    let from_y = sum - x;
    (x - (sum - from_y)) + (y - from_y)
}

/// `x + y` rounded down.
fn sum_below(x: f64, y: f64) -> f64 {
    let sum = x + y;
    let error = rounding_error(x, y, sum);
    if error.is_finite() && error >= 0.0 { sum } else { sum.next_down() }
}

/// `x + y` rounded up.
fn sum_above(x: f64, y: f64) -> f64 {
    let sum = x + y;
    let error = rounding_error(x, y, sum);
    if error.is_finite() && error <= 0.0 { sum } else { sum.next_up() }
}

impl Ring for Interval {
    fn zero() -> Self {
        Self { lo: 0.0, hi: 0.0 }
    }

    fn from_f64(x: f64) -> Option<Self> {
        x.is_finite().then_some(Self { lo: x, hi: x })
    }

    // A lower bound is never +inf and an upper never -inf, so that neither sum below is inf - inf. A sum of lower
    // bounds that overflows upwards exceeds MAX, which is what next_down(+inf) is.
    fn add(&self, rhs: &Self) -> Self {
        if self.is_zero() {
            return *rhs;
        }
        if rhs.is_zero() {
            return *self;
        }
        Self { lo: sum_below(self.lo, rhs.lo), hi: sum_above(self.hi, rhs.hi) }
    }

    fn sub(&self, rhs: &Self) -> Self {
        self.add(&rhs.neg())
    }

    fn mul(&self, rhs: &Self) -> Self {
        if self.is_zero() || rhs.is_zero() {
            return Self::zero();
        }
        let bounds = [(self.lo, rhs.lo), (self.lo, rhs.hi), (self.hi, rhs.lo), (self.hi, rhs.hi)];
        let (mut lo, mut hi) = (f64::INFINITY, f64::NEG_INFINITY);
        for (x, y) in bounds {
            let xy = if x == 0.0 || y == 0.0 { 0.0 } else { x * y };
            lo = lo.min(xy);
            hi = hi.max(xy);
        }
        Self { lo: lo.next_down(), hi: hi.next_up() }
    }

    fn neg(&self) -> Self {
        Self { lo: -self.hi, hi: -self.lo }
    }

    fn is_zero(&self) -> bool {
        self.lo == 0.0 && self.hi == 0.0
    }
}
