//! A truncated power series in time whose coefficients are dual numbers: the scalar over which the output of a plant is
//! differentiated.
//!
//! `x(t + s) = x_0 + x_1 s + .. + x_K s^K`, `K` = [`HIGHEST_ORDER`], each `x_k` a dual number `x_k + d_k eps`,
//! `eps^2 = 0`. Sums, products and quotients are those of truncated series; an elementary function `g(x)` follows from
//! the differential equation it satisfies, such as `g' = x' g` for exp, coefficient after coefficient. The k-th
//! coefficient of a result depends on coefficients up to the k-th alone.
//!
//! Source: A. Griewank and A. Walther, Evaluating Derivatives, 2nd ed., SIAM 2008, section 13.2 (Taylor arithmetic).

use core::ops::{Add, Div, Mul, Neg, Sub};

/// The highest power of time that a [`Jet`] keeps.
pub const HIGHEST_ORDER: usize = 15;

/// Number of coefficients.
pub(crate) const COUNT: usize = HIGHEST_ORDER + 1;

/// A number with its derivative along the direction of the evaluation.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub(crate) struct Dual {
    pub(crate) value: f64,
    pub(crate) slope: f64,
}

/// A truncated power series in time over dual numbers.
///
/// Plants use it as their scalar `T` without knowing the type. Comparisons are those of the value at `s = 0`.
#[derive(Debug, Clone, Copy)]
pub struct Jet {
    pub(crate) c: [Dual; COUNT],
}

impl Dual {
    pub(crate) fn constant(value: f64) -> Self {
        Self { value, slope: 0.0 }
    }

    /// `g(x)` from g and g' at x. A constant stays one, whatever g' is.
    fn map(self, value: f64, derivative: f64) -> Self {
        Self { value, slope: if self.slope == 0.0 { 0.0 } else { derivative * self.slope } }
    }

    fn times(self, factor: f64) -> Self {
        Self { value: self.value * factor, slope: self.slope * factor }
    }
}

impl Add for Dual {
    type Output = Self;

    fn add(self, rhs: Self) -> Self {
        Self { value: self.value + rhs.value, slope: self.slope + rhs.slope }
    }
}

impl Sub for Dual {
    type Output = Self;

    fn sub(self, rhs: Self) -> Self {
        Self { value: self.value - rhs.value, slope: self.slope - rhs.slope }
    }
}

impl Mul for Dual {
    type Output = Self;

    fn mul(self, rhs: Self) -> Self {
        Self { value: self.value * rhs.value, slope: self.slope * rhs.value + self.value * rhs.slope }
    }
}

impl Div for Dual {
    type Output = Self;

    fn div(self, rhs: Self) -> Self {
        let value = self.value / rhs.value;
        Self { value, slope: (self.slope - value * rhs.slope) / rhs.value }
    }
}

impl Neg for Dual {
    type Output = Self;

    fn neg(self) -> Self {
        Self { value: -self.value, slope: -self.slope }
    }
}

impl Jet {
    pub(crate) fn constant(value: f64) -> Self {
        let mut c = [Dual::default(); COUNT];
        c[0].value = value;
        Self { c }
    }

    /// The series with these coefficients, each with its derivative along the direction of the evaluation.
    pub fn from_fn(mut coefficient: impl FnMut(usize) -> (f64, f64)) -> Self {
        let dual = |(value, slope)| Dual { value, slope };
        Self { c: core::array::from_fn(|k| dual(coefficient(k))) }
    }

    /// `t + s`.
    pub fn time(t: f64) -> Self {
        let mut jet = Self::constant(t);
        jet.c[1].value = 1.0;
        jet
    }

    /// The value at `s = 0`.
    pub fn value(&self) -> f64 {
        self.c[0].value
    }

    /// The coefficient of `s^k`: the k-th derivative by time over k!. Zero beyond [`HIGHEST_ORDER`].
    pub fn coefficient(&self, k: usize) -> f64 {
        self.c.get(k).map_or(0.0, |c| c.value)
    }

    /// The derivative of [`coefficient`](Self::coefficient) along the direction of the evaluation.
    pub fn slope(&self, k: usize) -> f64 {
        self.c.get(k).map_or(0.0, |c| c.slope)
    }

    /// Whether nothing but the value is there.
    pub(crate) fn is_constant(&self) -> bool {
        self.c[0].slope == 0.0 && self.c[1..].iter().all(|c| *c == Dual::default())
    }

    /// The series with coefficients computed one after the other from those before.
    fn build(first: Dual, mut next: impl FnMut(usize, &[Dual; COUNT]) -> Dual) -> Self {
        let mut c = [Dual::default(); COUNT];
        c[0] = first;
        for k in 1..COUNT {
            c[k] = next(k, &c);
        }
        Self { c }
    }

    fn over(&self, other: &Self) -> Self {
        // q b = a.
        Self::build(self.c[0] / other.c[0], |k, q| (self.c[k] - convolution(q, &other.c, 0, k - 1, k)) / other.c[0])
    }

    /// The g with `g' = h x'` and the given value at `s = 0`, for `x = self`.
    pub(crate) fn integral_of(&self, first: Dual, h: &Self) -> Self {
        Self::build(first, |k, _| weighted(&self.c, &h.c, k))
    }

    /// `g' = g x'`.
    pub(crate) fn exponential(&self) -> Self {
        let at = self.value().exp();
        Self::build(self.c[0].map(at, at), |k, g| weighted(&self.c, g, k))
    }

    /// `s' = c x'`, `c' = sign s x'`: sine and cosine for the sign -1, the hyperbolic ones for +1.
    pub(crate) fn pair(&self, sign: f64, sine: f64, cosine: f64) -> (Self, Self) {
        let mut s = [Dual::default(); COUNT];
        let mut c = s;
        (s[0], c[0]) = (self.c[0].map(sine, cosine), self.c[0].map(cosine, sign * sine));
        for k in 1..COUNT {
            (s[k], c[k]) = (weighted(&self.c, &c, k), weighted(&self.c, &s, k).times(sign));
        }
        (Self { c: s }, Self { c })
    }

    /// `g' = (1 + sign g^2) x'`: the tangent for +1, the hyperbolic one for -1.
    pub(crate) fn tangent(&self, sign: f64, at: f64) -> Self {
        let mut h = [Dual::default(); COUNT];
        h[0] = Dual::constant(1.0) + self.c[0].map(sign * at * at, 2.0 * sign * at * (1.0 + sign * at * at));
        Self::build(self.c[0].map(at, 1.0 + sign * at * at), |k, g| {
            let next = weighted(&self.c, &h, k);
            let mut known = *g;
            known[k] = next;
            h[k] = convolution(&known, &known, 0, k, k).times(sign);
            next
        })
    }

    /// `x^p` for a constant p, from its value: `x g' = p g x'`.
    pub(crate) fn power(&self, p: f64, value: f64, derivative: f64) -> Self {
        Self::build(self.c[0].map(value, derivative), |k, g| {
            let sum = (1..=k)
                .fold(Dual::default(), |sum, j| sum + (self.c[j] * g[k - j]).times(p * j as f64 - (k - j) as f64));
            sum / self.c[0].times(k as f64)
        })
    }

    /// `g^2 = x`.
    pub(crate) fn root(&self) -> Self {
        let at = self.value().sqrt();
        let first = self.c[0].map(at, 0.5 / at);
        Self::build(first, |k, g| {
            let rest = self.c[k] - convolution(g, g, 1, k - 1, k);
            if rest == Dual::default() { rest } else { rest / first.times(2.0) }
        })
    }

    /// The angle of (other, self): `(x^2 + y^2) g' = x y' - y x'`.
    pub(crate) fn angle(&self, other: &Self) -> Self {
        let (y, x) = (self, other);
        let square = *x * *x + *y * *y;
        let (over_x, over_y) = (*y / square, *x / square);
        let value = y.value().atan2(x.value());
        let slope = over_y.value() * y.c[0].slope - over_x.value() * x.c[0].slope;
        Self::build(Dual { value, slope }, |k, _| weighted(&y.c, &over_y.c, k) - weighted(&x.c, &over_x.c, k))
    }

    /// A function with the value and derivative at `s = 0`, and h its derivative as a series.
    pub(crate) fn chain(&self, value: f64, h: &Self) -> Self {
        self.integral_of(self.c[0].map(value, h.value()), h)
    }
}

impl Add for Jet {
    type Output = Self;

    fn add(self, rhs: Self) -> Self {
        Self { c: core::array::from_fn(|k| self.c[k] + rhs.c[k]) }
    }
}

impl Sub for Jet {
    type Output = Self;

    fn sub(self, rhs: Self) -> Self {
        Self { c: core::array::from_fn(|k| self.c[k] - rhs.c[k]) }
    }
}

impl Mul for Jet {
    type Output = Self;

    fn mul(self, rhs: Self) -> Self {
        Self { c: core::array::from_fn(|k| convolution(&self.c, &rhs.c, 0, k, k)) }
    }
}

impl Div for Jet {
    type Output = Self;

    fn div(self, rhs: Self) -> Self {
        self.over(&rhs)
    }
}

impl Neg for Jet {
    type Output = Self;

    fn neg(self) -> Self {
        Self { c: self.c.map(Neg::neg) }
    }
}

/// `sum_{j=from}^{to} a_j b_{k-j}`.
fn convolution(a: &[Dual; COUNT], b: &[Dual; COUNT], from: usize, to: usize, k: usize) -> Dual {
    (from..=to).fold(Dual::default(), |sum, j| sum + a[j] * b[k - j])
}

/// `1/k sum_{j=1}^k j x_j h_{k-j}`: the coefficient of the integral of `h x'`.
fn weighted(x: &[Dual; COUNT], h: &[Dual; COUNT], k: usize) -> Dual {
    let sum = (1..=k).fold(Dual::default(), |sum, j| sum + (x[j] * h[k - j]).times(j as f64));
    Dual { value: sum.value / k as f64, slope: sum.slope / k as f64 }
}
