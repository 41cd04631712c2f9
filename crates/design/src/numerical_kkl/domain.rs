//! The domain of the observer: a box or a part of one, and the modified plant outside of it, for which T is defined.
//!
//! T depends on the whole past of a state, and the past of most plants is unbounded. `x' = chi(x) f(x)` with chi = 1 in
//! the box and 0 outside a larger one has a bounded past, and the same right-hand side in the box: T of the slowed
//! plant obeys `DT f = D T + B h` *in the box*, and z - T(x) decays exactly as long as x is in the box. The
//! modification is an approximation outside the box only.
//!
//! With inequalities `g(x) <= 0` the domain is the part of the box in which they hold: there T is fitted, inverted,
//! judged and tested for injectivity, and chi falls outside of it. The table of T is on the whole box nevertheless, so
//! that f and h have to be defined on it, and the left inverse is sought in it.

use core::fmt;
use std::sync::Arc;

use luenberger_random::{Purpose, Stream};
use nalgebra::SVector;

use crate::check::within;
use crate::golden_sequence::GoldenSequence;
use crate::numerical_kkl::error::NumericalKklError;

/// The dynamics outside the domain.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Escape {
    /// The unmodified plant: for plants whose past is bounded.
    Free,
    /// It is slowed to a standstill over a margin around the box: `margin` half-widths wide on every side; beyond an
    /// inequality, where g has risen to `margin` times the largest -g found in the domain.
    Slowed {
        /// Width of the margin, in half-widths of the box.
        margin: f64,
    },
}

/// A function g of the states, with its gradient, of an inequality `g(x) <= 0`.
pub type Inequality<const N: usize> = Arc<dyn Fn(&SVector<f64, N>) -> (f64, SVector<f64, N>) + Send + Sync>;

/// A box of states, or the part of it in which inequalities hold, and what the plant does outside.
#[derive(Clone)]
pub struct Domain<const N: usize> {
    lower: SVector<f64, N>,
    upper: SVector<f64, N>,
    escape: Escape,
    /// Each with the largest -g at these points of the domain.
    inequalities: Vec<(Inequality<N>, f64)>,
}

/// How many points of the box are tried for the inequalities.
const TRIED: usize = 4096;

/// How many of these have to be in the domain: samples are drawn in the box, and those outside are left out.
const LEAST: usize = 16;

impl<const N: usize> Domain<N> {
    /// The box from `lower` to `upper`.
    ///
    /// # Errors
    /// [`NumericalKklError::Box`] unless `lower < upper` in every entry, all finite;
    /// [`DesignError::Setting`](crate::DesignError::Setting) for the margin.
    pub fn new(lower: [f64; N], upper: [f64; N], escape: Escape) -> Result<Self, NumericalKklError> {
        if N == 0 {
            return Err(NumericalKklError::Empty { states: 0, outputs: 1, targets: 1 });
        }
        for axis in 0..N {
            let (lower, upper) = (lower[axis], upper[axis]);
            let sound = lower.is_finite() && upper.is_finite() && lower < upper && (upper - lower).is_finite();
            if !sound {
                return Err(NumericalKklError::Box { axis, lower, upper });
            }
        }
        if let Escape::Slowed { margin } = escape {
            within("the margin", margin, 1e-3, 1e3)?;
        }
        Ok(Self { lower: lower.into(), upper: upper.into(), escape, inequalities: Vec::new() })
    }

    /// The part of the domain in which `g(x) <= 0` for every g of these, none of which changes with its scale: g and
    /// 1000 g are the same.
    ///
    /// Half of a disk in the box of the reverse Duffing oscillator:
    /// ```
    /// use luenberger_design::numerical_kkl::{Domain, Escape, Inequality};
    /// use nalgebra::{Vector2, vector};
    /// use std::sync::Arc;
    /// let disk: Inequality<2> = Arc::new(|x: &Vector2<f64>| (x.norm_squared() - 1.0, 2.0 * x));
    /// let half: Inequality<2> = Arc::new(|x: &Vector2<f64>| (-x[0], vector![-1.0, 0.0]));
    /// let domain = Domain::new([-1.0; 2], [1.0; 2], Escape::Free)?.inside([disk, half])?;
    /// assert!(domain.contains(&vector![0.5, -0.5]));
    /// assert!(!domain.contains(&vector![-0.5, 0.5]) && !domain.contains(&vector![0.8, 0.8]));
    /// # Ok::<(), luenberger_design::numerical_kkl::NumericalKklError>(())
    /// ```
    /// # Errors
    /// Of 4096 points spread evenly over the box: [`NumericalKklError::Inequality`] for a function that is not finite
    /// at one of them, [`NumericalKklError::SmallDomain`] where they hold at less than 16. Elsewhere a value that is
    /// not finite counts as outside.
    pub fn inside(self, inequalities: impl IntoIterator<Item = Inequality<N>>) -> Result<Self, NumericalKklError> {
        let mut domain = self;
        domain.inequalities.extend(inequalities.into_iter().map(|g| (g, 0.0)));
        if domain.inequalities.is_empty() {
            return Ok(domain);
        }
        let mut depths = vec![0.0f64; domain.inequalities.len()];
        let mut inside = 0;
        for x in domain.box_points().take(TRIED) {
            let values: Vec<f64> = domain.inequalities.iter().map(|(g, _)| g(&x).0).collect();
            if let Some(index) = values.iter().position(|value| !value.is_finite()) {
                return Err(NumericalKklError::Inequality { index, at: x.iter().copied().collect() });
            }
            if values.iter().all(|value| *value <= 0.0) {
                inside += 1;
                for (depth, value) in depths.iter_mut().zip(values) {
                    *depth = depth.max(-value);
                }
            }
        }
        if inside < LEAST || depths.contains(&0.0) {
            return Err(NumericalKklError::SmallDomain { inside, tried: TRIED });
        }
        for ((_, depth), found) in domain.inequalities.iter_mut().zip(depths) {
            *depth = found;
        }
        Ok(domain)
    }

    /// The same with another escape.
    ///
    /// # Errors
    /// [`DesignError::Setting`](crate::DesignError::Setting) for the margin.
    pub fn escaping(&self, escape: Escape) -> Result<Self, NumericalKklError> {
        let Self { lower, upper, escape, .. } = Self::new((self.lower).into(), (self.upper).into(), escape)?;
        Ok(Self { lower, upper, escape, inequalities: self.inequalities.clone() })
    }

    /// Points of the box, evenly, without end.
    fn box_points(&self) -> impl Iterator<Item = SVector<f64, N>> {
        let shares = GoldenSequence::new(N, Stream::new(0, Purpose::TransformExtent, 0));
        shares.map(|share| self.point(|i| share[i]))
    }

    /// As many points as a grid with `per_axis` of them on each axis has: the grid of a box, and in a part of one
    /// points that fill it evenly.
    pub(crate) fn grid(&self, per_axis: usize) -> Vec<SVector<f64, N>> {
        let count = per_axis.pow(N as u32);
        if !self.inequalities.is_empty() {
            return self.box_points().filter(|x| self.satisfies(x)).take(count).collect();
        }
        let share =
            |index: usize, axis: usize| (index / per_axis.pow(axis as u32) % per_axis) as f64 / (per_axis - 1) as f64;
        (0..count).map(|index| self.point(|axis| share(index, axis))).collect()
    }

    /// The corner with the smallest coordinates.
    pub fn lower(&self) -> &SVector<f64, N> {
        &self.lower
    }

    /// The corner with the largest coordinates.
    pub fn upper(&self) -> &SVector<f64, N> {
        &self.upper
    }

    /// Half the lengths of the edges.
    pub fn half_width(&self) -> SVector<f64, N> {
        (self.upper - self.lower) * 0.5
    }

    /// The centre.
    pub fn centre(&self) -> SVector<f64, N> {
        self.lower + self.half_width()
    }

    /// Whether x is in the box, and all inequalities hold there.
    pub fn contains(&self, x: &SVector<f64, N>) -> bool {
        (0..N).all(|i| (self.lower[i]..=self.upper[i]).contains(&x[i])) && self.satisfies(x)
    }

    /// Whether all inequalities hold at x.
    pub(crate) fn satisfies(&self, x: &SVector<f64, N>) -> bool {
        self.inequalities.iter().all(|(g, _)| g(x).0 <= 0.0)
    }

    /// The state at `share` of each edge, 0 to 1.
    pub(crate) fn point(&self, share: impl Fn(usize) -> f64) -> SVector<f64, N> {
        SVector::from_fn(|i, _| {
            let s = share(i);
            (1.0 - s) * self.lower[i] + s * self.upper[i]
        })
    }

    /// The factor chi by which the plant is slowed at x, 1 in the domain, and its gradient.
    pub fn speed(&self, x: &SVector<f64, N>) -> (f64, SVector<f64, N>) {
        let Escape::Slowed { margin } = self.escape else { return (1.0, SVector::zeros()) };
        let (centre, half) = (self.centre(), self.half_width());
        let factors: SVector<(f64, f64), N> = SVector::from_fn(|i, _| {
            let offset = (x[i] - centre[i]) / half[i];
            let (value, slope) = fall((offset.abs() - 1.0) / margin);
            (value, slope * offset.signum() / (half[i] * margin))
        });
        let mut chi: f64 = factors.iter().map(|(value, _)| value).product();
        let mut gradient =
            SVector::from_fn(|j, _| (0..N).map(|i| if i == j { factors[i].1 } else { factors[i].0 }).product());
        for (g, depth) in &self.inequalities {
            let (value, slope) = g(x);
            let (factor, fallen) = fall(value / (margin * depth));
            // Where the plant stands still, g may have no value.
            gradient = if fallen == 0.0 {
                gradient * factor
            } else {
                gradient * factor + slope * (chi * fallen / (margin * depth))
            };
            chi *= factor;
        }
        (chi, gradient)
    }
}

impl<const N: usize> fmt::Debug for Domain<N> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Domain")
            .field("lower", &self.lower)
            .field("upper", &self.upper)
            .field("escape", &self.escape)
            .field("inequalities", &self.inequalities.len())
            .finish()
    }
}

/// From 1 at s <= 0 to 0 at s >= 1, three times continuously differentiable; value and slope.
fn fall(s: f64) -> (f64, f64) {
    if s <= 0.0 {
        (1.0, 0.0)
    } else if s >= 1.0 || s.is_nan() {
        (0.0, 0.0)
    } else {
        let rise = s.powi(4) * (35.0 + s * (-84.0 + s * (70.0 - 20.0 * s)));
        (1.0 - rise, -140.0 * (s * (1.0 - s)).powi(3))
    }
}
