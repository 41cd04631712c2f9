//! Bounds of the states: a primal-dual interior-point method that ends when its steps are small, after a fixed number
//! of them at the latest.

use luenberger_plants::{Differentiable, Size};
use nalgebra::allocator::Allocator;
use nalgebra::{ComplexField, DefaultAllocator, Dim, OMatrix, OVector, RealField, U1, convert};

use super::pass::{Row, Stage, Used, unused};
use super::{MovingHorizonEstimator, Trajectory};
use crate::dense::larger;

/// The most steps of the interior-point method.
pub const INTERIOR_POINT_STEPS: usize = 30;

/// The share of the way to a bound that a step of the interior-point method takes.
pub const FRACTION_TO_BOUNDARY: f64 = 0.995;

/// The lower or the upper bounds of one stage: slacks and multipliers, and what the way back needs of their updates.
#[derive(Clone, Debug)]
struct Side<T: RealField + Copy, N: Dim>
where
    DefaultAllocator: Allocator<N> + Allocator<N, N>,
{
    s: OVector<T, N>,
    z: OVector<T, N>,
    used: Used<T, N, N>,
}

/// The bounds of one stage.
#[derive(Clone, Debug)]
pub(super) struct Barrier<T: RealField + Copy, N: Dim>
where
    DefaultAllocator: Allocator<N> + Allocator<N, N>,
{
    lower: Side<T, N>,
    upper: Side<T, N>,
}

impl<S, T: RealField + Copy, N: Dim, M: Dim, P: Dim, D: Dim, const L: usize> MovingHorizonEstimator<S, T, N, M, P, D, L>
where
    S: Differentiable<T, N, M, P>,
    DefaultAllocator: Size<N, M, P> + Allocator<D>,
{
    /// The bounds of a stage as measurements of its states: `lower + s + mu/z` with the variance s/z, and likewise
    /// above.
    pub(super) fn bounded(&self, barrier: &mut Barrier<T, N>, mu: T, at: &mut Stage<T, N, P>) -> Option<()> {
        let (lower, upper) = self.bounds.as_ref()?;
        for j in 0..lower.nrows() {
            let sides = [(lower[j], &mut barrier.lower, T::one()), (upper[j], &mut barrier.upper, -T::one())];
            for (bound, Side { s, z, used }, sign) in sides {
                if !ComplexField::is_finite(&bound) {
                    continue;
                }
                let value = bound + sign * (s[j] + mu / z[j]);
                if !at.bound(j, (value - at.mean[j], s[j] / z[j]), used) {
                    return None;
                }
            }
        }
        Some(())
    }

    /// The adjoint variables of a stage before its bounds, from those behind them.
    pub(super) fn before_bounds(&self, barrier: &Barrier<T, N>, adjoint: &mut OVector<T, N>) {
        let Some((lower, upper)) = self.bounds.as_ref() else { return };
        for j in (0..lower.nrows()).rev() {
            for (bound, side) in [(upper[j], &barrier.upper), (lower[j], &barrier.lower)] {
                if ComplexField::is_finite(&bound) {
                    side.used.before(j, Row::State(j), adjoint.as_mut_slice());
                }
            }
        }
    }

    /// Whether all states of a trajectory lie within the bounds.
    pub(super) fn is_within(&self, count: usize, x: &Trajectory<T, N, L>) -> bool {
        let Some((lower, upper)) = &self.bounds else { return true };
        (0..count).all(|i| (0..lower.nrows()).all(|j| lower[j] <= x[i][j] && x[i][j] <= upper[j]))
    }

    /// The primal-dual interior-point method from x on.
    #[allow(clippy::type_complexity, reason = "trajectory, covariance")]
    pub(super) fn interior(
        &self,
        state: &[T],
        count: usize,
        mut x: Trajectory<T, N, L>,
    ) -> Option<(Trajectory<T, N, L>, OMatrix<T, N, N>)> {
        let (lower, upper) = self.bounds.as_ref()?;
        let n = lower.nrows();
        let (share, tenth): (T, T) = (convert(FRACTION_TO_BOUNDARY), convert(0.1));
        let least = T::default_epsilon() * convert::<f64, T>(1e3);
        // It ends where mu has its least value, and the steps of all states are small beside their deviations.
        let small = T::default_epsilon().sqrt();
        let p = &state[self.layout.covariance()];
        // Slacks of one standard deviation at least, and products of 1, the size of one normalised square.
        let deviation = lower.map_with_location(|j, _, _| larger(p[j + j * n], least * least).sqrt());
        let clamp = |x: &mut [OVector<T, N>]| {
            for stage in x.iter_mut().take(count) {
                for j in 0..n {
                    let above = larger(stage[j], lower[j]);
                    stage[j] = if above < upper[j] { above } else { upper[j] };
                }
            }
        };
        clamp(&mut x);
        let slack = |gap: T, j: usize| if ComplexField::is_finite(&gap) { larger(gap, deviation[j]) } else { T::one() };
        let side = |gap: &dyn Fn(usize) -> T| {
            let mut s = lower.clone();
            (0..n).for_each(|j| s[j] = slack(gap(j), j));
            let order = s.shape_generic().0;
            Side { z: s.map(|s| T::one() / s), s, used: Used::none(order, order) }
        };
        let nothing = || {
            let (none, order) = (OVector::<T, N>::zeros_generic(unused(), U1), unused::<N>());
            Side { s: none.clone(), z: none, used: Used::none(order, order) }
        };
        let mut barrier: [Barrier<T, N>; L] = core::array::from_fn(|i| {
            if i < count {
                Barrier { lower: side(&|j| x[i][j] - lower[j]), upper: side(&|j| upper[j] - x[i][j]) }
            } else {
                Barrier { lower: nothing(), upper: nothing() }
            }
        });
        let (mut mu, mut covariance) = (T::one(), None);
        for _ in 0..INTERIOR_POINT_STEPS {
            let (solution, p) = self.pass(state, count, &x, Some((&mut barrier, mu)))?;
            covariance = Some(p);
            // The steps of all slacks and multipliers, and how far they may go.
            let mut alpha = T::one();
            let visit = |apply: Option<T>, barrier: &mut [Barrier<T, N>; L], alpha: &mut T| {
                let (mut sum, mut number) = (T::zero(), T::zero());
                for i in 0..count {
                    let Barrier { lower: below, upper: above } = &mut barrier[i];
                    for j in 0..n {
                        for (bound, Side { s, z, .. }, sign) in
                            [(lower[j], &mut *below, T::one()), (upper[j], &mut *above, -T::one())]
                        {
                            if !ComplexField::is_finite(&bound) {
                                continue;
                            }
                            let ds = sign * (solution[i][j] - bound) - s[j];
                            let dz = mu / s[j] - z[j] - z[j] / s[j] * ds;
                            match apply {
                                None => {
                                    for (value, step) in [(s[j], ds), (z[j], dz)] {
                                        if value + *alpha * step < (T::one() - share) * value {
                                            *alpha = -share * value / step;
                                        }
                                    }
                                }
                                Some(alpha) => {
                                    s[j] += alpha * ds;
                                    z[j] += alpha * dz;
                                    sum += s[j] * z[j];
                                    number += T::one();
                                }
                            }
                        }
                    }
                }
                if number > T::zero() { sum / number } else { sum }
            };
            visit(None, &mut barrier, &mut alpha);
            let mean = visit(Some(alpha), &mut barrier, &mut alpha);
            let mut ends = mu <= least;
            for i in 0..count {
                for j in 0..n {
                    let step = solution[i][j] - x[i][j];
                    x[i][j] += alpha * step;
                    ends = ends && step.abs() <= small * deviation[j];
                }
            }
            if ends {
                break;
            }
            // After a short step the centre is aimed at again; near the solution mu falls faster than in proportion.
            let half = convert::<f64, T>(0.5);
            let root = mean.sqrt();
            let factor = if root < tenth { root } else { tenth };
            let reduced = if alpha > half { factor * mean } else { half * mean };
            mu = larger(reduced, least);
        }
        clamp(&mut x);
        covariance.map(|p| (x, p))
    }
}
