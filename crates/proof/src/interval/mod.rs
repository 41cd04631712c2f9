//! Intervals with outward rounding.
//!
//! Each operation rounds to nearest and then moves the bound one float outwards (`next_down`, `next_up`), which costs
//! at most one ulp more than directed rounding and needs no rounding mode. Sums compute their rounding error and move
//! the bound only if it is not 0. Overflow gives an infinite bound, which is valid. NaN does not occur: 0 times an
//! infinite bound is defined as 0 (the product of a real number and 0).

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

    /// The interval `[x, x]` for finite x.
    pub(crate) const fn point(x: f64) -> Self {
        Self { lo: x, hi: x }
    }

    /// The interval `[x, x]`; all real numbers if x is NaN or infinite.
    pub fn of(x: f64) -> Self {
        Self::from_f64(x).unwrap_or(Self::UNBOUNDED)
    }

    /// The interval `[lo, hi]`; `None` unless `lo <= hi` and it contains a real number.
    pub fn new(lo: f64, hi: f64) -> Option<Self> {
        (lo <= hi && lo < f64::INFINITY && hi > f64::NEG_INFINITY).then_some(Self { lo, hi })
    }

    /// An interval that contains `[x - radius, x + radius]`; `None` for NaN, infinite `x`, or a negative radius.
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

    /// Whether `x` lies in the interval.
    pub fn contains(&self, x: f64) -> bool {
        self.lo <= x && x <= self.hi
    }

    /// The width `hi - lo`, rounded up.
    pub fn width(&self) -> f64 {
        if self.is_point() { 0.0 } else { (self.hi - self.lo).next_up() }
    }

    /// The largest absolute value in the interval.
    pub fn magnitude(&self) -> f64 {
        self.lo.abs().max(self.hi.abs())
    }

    /// The intersection; `None` if it is empty.
    pub fn intersection(&self, other: &Self) -> Option<Self> {
        Self::new(self.lo.max(other.lo), self.hi.min(other.hi))
    }

    /// A float near the middle; NaN if the interval is unbounded.
    pub fn midpoint(&self) -> f64 {
        self.midpoint_radius().map_or(f64::NAN, |(middle, _)| middle)
    }

    /// A float near the middle and a radius that together enclose the interval; `None` if it is unbounded.
    pub fn midpoint_radius(&self) -> Option<(f64, f64)> {
        if self.is_point() {
            return Some((self.lo, 0.0));
        }
        let middle = self.lo / 2.0 + self.hi / 2.0;
        let radius = (middle - self.lo).max(self.hi - middle).next_up();
        (middle.is_finite() && radius.is_finite()).then_some((middle, radius))
    }
}

/// The exact rounding error `x + y - fl(x + y)` (Knuth's TwoSum); infinite or NaN on overflow.
fn rounding_error(x: f64, y: f64, sum: f64) -> f64 {
    let from_y = sum - x;
    (x - (sum - from_y)) + (y - from_y)
}

/// The next float below x if `step` is 1, x if it is 0: `f64::next_down` without data-dependent branches on the sign
/// and on `step`.
fn below(x: f64, step: u64) -> f64 {
    if x == 0.0 || !x.is_finite() {
        return if step == 0 { x } else { x.next_down() };
    }
    // Floats of one sign are ordered like their bit patterns: 1 for x > 0, -1 for x < 0.
    let towards_zero = 1_u64.wrapping_sub((x.to_bits() >> 63) << 1);
    f64::from_bits(x.to_bits().wrapping_sub(towards_zero.wrapping_mul(step)))
}

/// The next float above x if `step` is 1, and x if it is 0.
fn above(x: f64, step: u64) -> f64 {
    -below(-x, step)
}

/// `x + y` rounded down.
fn sum_below(x: f64, y: f64) -> f64 {
    let sum = x + y;
    let error = rounding_error(x, y, sum);
    below(sum, 1 - u64::from(error.is_finite()) * u64::from(error >= 0.0))
}

/// `x + y` rounded up.
fn sum_above(x: f64, y: f64) -> f64 {
    let sum = x + y;
    let error = rounding_error(x, y, sum);
    above(sum, 1 - u64::from(error.is_finite()) * u64::from(error <= 0.0))
}

impl Ring for Interval {
    fn zero() -> Self {
        Self { lo: 0.0, hi: 0.0 }
    }

    fn from_f64(x: f64) -> Option<Self> {
        x.is_finite().then_some(Self { lo: x, hi: x })
    }

    // A lower bound is never +inf and an upper bound never -inf, so no sum is inf - inf. A sum of lower bounds that
    // overflows upwards exceeds MAX = next_down(+inf).
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
        let products = if self.is_bounded() && rhs.is_bounded() {
            [self.lo * rhs.lo, self.lo * rhs.hi, self.hi * rhs.lo, self.hi * rhs.hi]
        } else {
            let product = |x: f64, y: f64| if x == 0.0 || y == 0.0 { 0.0 } else { x * y };
            [(self.lo, rhs.lo), (self.lo, rhs.hi), (self.hi, rhs.lo), (self.hi, rhs.hi)].map(|(x, y)| product(x, y))
        };
        // None of the products is NaN.
        let [a, b, c, d] = products;
        let less = |x: f64, y: f64| if x < y { x } else { y };
        let more = |x: f64, y: f64| if x > y { x } else { y };
        let (lo, hi) = (less(less(a, b), less(c, d)), more(more(a, b), more(c, d)));
        Self { lo: below(lo, 1), hi: above(hi, 1) }
    }

    fn neg(&self) -> Self {
        Self { lo: -self.hi, hi: -self.lo }
    }

    fn is_zero(&self) -> bool {
        self.lo == 0.0 && self.hi == 0.0
    }
}
