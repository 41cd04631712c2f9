//! The domain of the observer: the box, and the modified plant outside of it, for which T is defined.
//!
//! T depends on the whole past of a state, and the past of most plants is unbounded. `x' = chi(x) f(x)` with chi = 1 in
//! the box and 0 outside a larger one has a bounded past, and the same right-hand side in the box: T of the slowed
//! plant obeys `DT f = D T + B h` *in the box*, and z - T(x) decays exactly as long as x is in the box. The
//! modification is an approximation outside the box only.

use nalgebra::SVector;

use crate::check::within;
use crate::numerical_kkl::error::NumericalKklError;

/// The dynamics outside the box.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Escape {
    /// The unmodified plant: for plants whose past is bounded.
    Free,
    /// It is slowed to a standstill over a margin around the box: `margin` half-widths wide on every side.
    Slowed {
        /// Width of the margin, in half-widths of the box.
        margin: f64,
    },
}

/// A box of states, and what the plant does outside.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Domain<const N: usize> {
    lower: SVector<f64, N>,
    upper: SVector<f64, N>,
    escape: Escape,
}

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
        Ok(Self { lower: lower.into(), upper: upper.into(), escape })
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

    /// Whether x is in the box.
    pub fn contains(&self, x: &SVector<f64, N>) -> bool {
        (0..N).all(|i| (self.lower[i]..=self.upper[i]).contains(&x[i]))
    }

    /// The state at `share` of each edge, 0 to 1.
    pub(crate) fn point(&self, share: impl Fn(usize) -> f64) -> SVector<f64, N> {
        SVector::from_fn(|i, _| {
            let s = share(i);
            (1.0 - s) * self.lower[i] + s * self.upper[i]
        })
    }

    /// The factor chi by which the plant is slowed at x, 1 in the box, and its gradient.
    pub fn speed(&self, x: &SVector<f64, N>) -> (f64, SVector<f64, N>) {
        let Escape::Slowed { margin } = self.escape else { return (1.0, SVector::zeros()) };
        let (centre, half) = (self.centre(), self.half_width());
        let factors: SVector<(f64, f64), N> = SVector::from_fn(|i, _| {
            let offset = (x[i] - centre[i]) / half[i];
            let (value, slope) = fall((offset.abs() - 1.0) / margin);
            (value, slope * offset.signum() / (half[i] * margin))
        });
        let chi = factors.iter().map(|(value, _)| value).product();
        let gradient =
            SVector::from_fn(|j, _| (0..N).map(|i| if i == j { factors[i].1 } else { factors[i].0 }).product());
        (chi, gradient)
    }
}

/// From 1 at s <= 0 to 0 at s >= 1, three times continuously differentiable; value and slope.
fn fall(s: f64) -> (f64, f64) {
    if s <= 0.0 {
        (1.0, 0.0)
    } else if s >= 1.0 {
        (0.0, 0.0)
    } else {
        let rise = s.powi(4) * (35.0 + s * (-84.0 + s * (70.0 - 20.0 * s)));
        (1.0 - rise, -140.0 * (s * (1.0 - s)).powi(3))
    }
}
