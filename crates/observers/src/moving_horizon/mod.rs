//! The moving-horizon estimator, linear and nonlinear, with bounds of the states.
//!
//! At each sample the states of the last L samples are those that minimise
//!
//! ```text
//! |x_0 - a|^2_(Pi^-1) + sum |y_i - h(x_i)|^2_(V^-1) + sum |x_(i+1) - F(x_i)|^2_(W^-1),    lower <= x_i <= upper
//! ```
//!
//! with F the plant from one sample to the next. Each step linearises F and h along the trajectory of the step before
//! and solves the linear problem exactly, by a Kalman filter forward and its adjoint backward (`pass`): a
//! Gauss-Newton step of `O(L n^3)`. There is a fixed number of them. If bounds are violated after them, steps of a
//! primal-dual interior-point method follow until they are small, at most a fixed number, each of the same cost: a
//! bound is a measurement of its state there, with the variance s/z of its slack and multiplier.
//!
//! **Arrival cost.** (a, Pi) is what the samples *before* the window say of its first state, and no sample of the
//! window is in it. When the window moves on, its first sample goes into (a, Pi) by the update and the prediction of
//! the extended Kalman filter, linearised at the smoothed estimate x_0 and corrected for the difference, `y - h(x_0) -
//! C (a - x_0)`: the smoothed estimate is where it is linearised, and not its mean, which would count the samples of
//! the window twice. Without active bounds the estimate of a linear plant is therefore that of the Kalman filter, for
//! every L. The bounds themselves are not in the arrival cost.
//!
//! The state is one column of numbers of the length [`state_length`]: nothing is allocated with static sizes. There is
//! no theorem of stability here.
//!
//! Sources: C. V. Rao, J. B. Rawlings and D. Q. Mayne, Constrained state estimation for nonlinear discrete-time
//! systems, IEEE Transactions on Automatic Control 48, 2003 (arrival cost); B. M. Bell, J. V. Burke and G. Pillonetto,
//! An inequality constrained nonlinear Kalman-Bucy smoother by interior point likelihood maximization, Automatica 45,
//! 2009.

mod interior;
mod pass;
mod traits;
mod window;

use core::marker::PhantomData;

use luenberger_plants::{Differentiable, Size};
#[cfg(feature = "alloc")]
use nalgebra::Dyn;
use nalgebra::allocator::Allocator;
use nalgebra::{Const, DefaultAllocator, Dim, OMatrix, OVector, RealField, U1, convert};

use crate::angles::{self, Turns};
use crate::dense::{Factor, are_finite, times, times_transpose};
use crate::error::{ObserverError, check_bounds};
use crate::gaussian::{NoiseModel, covariance, usable};
#[cfg(feature = "alloc")]
use crate::held::{AtInput, same, same_mut};
#[cfg(feature = "alloc")]
use crate::kalman::ExtendedAtRunTime;
use crate::observer::has_rows;
use crate::transition::{Motion, Prediction, Transition};

use interior::Barrier;
pub use interior::{FRACTION_TO_BOUNDARY, INTERIOR_POINT_STEPS};
use pass::{Stage, unused};
pub use window::state_length;
use window::{Layout, Part};

/// Length of the window and number of Gauss-Newton steps.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Horizon {
    /// Samples in the window, at least 1.
    pub window: usize,
    /// Gauss-Newton steps at each sample, at least 1; one is exact for a linear plant.
    pub iterations: usize,
}

/// The moving-horizon estimator of a plant `S`, with a state of dimension D and a window of at most L samples; see the
/// [module](self).
#[derive(Clone, Debug, PartialEq)]
pub struct MovingHorizonEstimator<S, T: RealField + Copy, N: Dim, M: Dim, P: Dim, D: Dim, const L: usize>
where
    DefaultAllocator: Size<N, M, P>,
{
    plant: S,
    noises: NoiseModel<T, N, P>,
    /// Of V.
    root: Factor<T, P>,
    bounds: Option<(OVector<T, N>, OVector<T, N>)>,
    /// Of the outputs, and of the states.
    turns: Turns<T, P>,
    state_turns: Turns<T, N>,
    h: T,
    prediction: Prediction,
    horizon: Horizon,
    layout: Layout,
    sizes: PhantomData<(M, D)>,
}

/// A moving-horizon estimator whose sizes are known at compile time; D is [`state_length`] of the sizes and the window.
pub type StaticMovingHorizonEstimator<
    S,
    T,
    const N: usize,
    const M: usize,
    const P: usize,
    const D: usize,
    const L: usize,
> = MovingHorizonEstimator<S, T, Const<N>, Const<M>, Const<P>, Const<D>, L>;

/// A trajectory over the window; what stands behind the last stage in use is not read.
type Trajectory<T, N, const L: usize> = [OVector<T, N>; L];

impl<S, T: RealField + Copy, N: Dim, M: Dim, P: Dim, D: Dim, const L: usize> MovingHorizonEstimator<S, T, N, M, P, D, L>
where
    S: Differentiable<T, N, M, P>,
    DefaultAllocator: Size<N, M, P> + Allocator<D>,
{
    /// The estimator of `plant`, sampled with period `h`, with `substeps` Runge-Kutta steps between samples: for a
    /// target. [`error_controlled`](Self::error_controlled) takes as many as are right.
    ///
    /// A step costs `iterations` times `window` times that of an extended Kalman filter that takes `9 n^2` flops for
    /// each output; with active bounds some 10 times `window` more of these and at most 30, with `5 n^2` for each
    /// bound.
    ///
    /// ```
    /// use luenberger_observers::moving_horizon::{Horizon, StaticMovingHorizonEstimator, state_length};
    /// use luenberger_observers::{NoiseModel, SampledObserver};
    /// use nalgebra::{Matrix1, Matrix2, Vector1, Vector2};
    /// const STATE: usize = state_length(2, 1, 1, 4);
    /// type Estimator<S> = StaticMovingHorizonEstimator<S, f64, 2, 1, 1, STATE, 4>;
    /// let noises = NoiseModel { w: Matrix2::identity() * 0.1, v: Matrix1::new(1e-2), p0: Matrix2::identity() };
    /// let horizon = Horizon { window: 4, iterations: 1 };
    /// let plant = luenberger_plants::double_integrator();
    /// let estimator = Estimator::new(plant, noises, horizon, 0.1, 1)?;
    /// // The speed is known to be nonnegative.
    /// let (lower, upper) = (Vector2::new(f64::NEG_INFINITY, 0.0), Vector2::repeat(f64::INFINITY));
    /// let estimator = estimator.with_bounds(lower, upper)?;
    /// let (u, y) = (Vector1::new(0.0), Vector1::new(-1.0));
    /// let mut state = estimator.initial(0.0, &Vector2::zeros(), &u, &y);
    /// for k in 0..10 {
    ///     estimator.step(0.1 * f64::from(k), &mut state, &u, &(y * f64::from(k)));
    ///     assert!(estimator.estimate(&state)[1] >= 0.0);
    /// }
    /// # Ok::<(), luenberger_observers::ObserverError>(())
    /// ```
    /// # Errors
    /// [`ObserverError::Matrix`] for shapes and entries, [`ObserverError::NotSymmetric`],
    /// [`ObserverError::NotDefinite`] when V is not positive definite or W or P(0) not semidefinite,
    /// [`ObserverError::Period`], [`ObserverError::Substeps`]; [`ObserverError::Table`] for a window of no sample or of
    /// more than L, no iteration, and a dimension D that is not [`state_length`] of the sizes and the window.
    pub fn new(
        plant: S,
        noises: NoiseModel<T, N, P>,
        horizon: Horizon,
        h: T,
        substeps: usize,
    ) -> Result<Self, ObserverError> {
        let size = plant.dimensions();
        let noises = NoiseModel {
            w: covariance("W", noises.w, size.states, false)?,
            v: covariance("V", noises.v, size.outputs, true)?,
            p0: covariance("P(0)", noises.p0, size.states, false)?,
        };
        if !(h.is_finite() && h > T::zero()) {
            return Err(ObserverError::Period { period: h.to_subset_unchecked() });
        }
        if substeps == 0 {
            return Err(ObserverError::Substeps);
        }
        let Horizon { window, iterations } = horizon;
        if window == 0 || window > L {
            return Err(ObserverError::Table { what: "samples in the window", expected: L, found: window });
        }
        if iterations == 0 {
            return Err(ObserverError::Table { what: "Gauss-Newton steps", expected: 1, found: 0 });
        }
        let layout = Layout { n: size.states, m: size.inputs, p: size.outputs, stages: window, joins: false };
        if let Some(found) = D::try_to_usize().filter(|found| *found != layout.len()) {
            let what = "the dimension of the state of the estimator";
            return Err(ObserverError::Table { what, expected: layout.len(), found });
        }
        let not_definite = || ObserverError::NotDefinite { what: "V", row: size.outputs.saturating_sub(1), pivot: 0.0 };
        let root = Factor::new(&noises.v).ok_or_else(not_definite)?;
        let prediction = Prediction::RungeKutta(substeps);
        let (turns, state_turns) = (None, None);
        Ok(Self {
            plant,
            noises,
            root,
            bounds: None,
            turns,
            state_turns,
            h,
            prediction,
            horizon,
            layout,
            sizes: PhantomData,
        })
    }

    /// The estimator of a plant in discrete time, `x+ = f(t, x, u) + w`, whose `derivative` is the next state; W is a
    /// covariance per sample.
    ///
    /// # Errors
    /// As [`new`](Self::new).
    pub fn discrete(plant: S, noises: NoiseModel<T, N, P>, horizon: Horizon, h: T) -> Result<Self, ObserverError> {
        Ok(Self { prediction: Prediction::Discrete, ..Self::new(plant, noises, horizon, h, 1)? })
    }

    #[cfg(feature = "alloc")]
    /// The estimator of `plant`, sampled with period `h`, whose prediction controls its error: exact for a plant that
    /// is linear between samples, and right for stiff ones. How long a step takes depends on the plant.
    ///
    /// # Errors
    /// As [`new`](Self::new).
    pub fn error_controlled(
        plant: S,
        noises: NoiseModel<T, N, P>,
        horizon: Horizon,
        h: T,
    ) -> Result<Self, ObserverError> {
        Ok(Self { prediction: Prediction::ErrorControlled, ..Self::new(plant, noises, horizon, h, 1)? })
    }

    /// The estimator with bounds of the states at the samples; an infinite one is none. They bound the estimates after
    /// the measurements, not the prediction for the next sample.
    ///
    /// # Errors
    /// [`ObserverError::Box`] for a state whose lower bound is not below its upper one.
    pub fn with_bounds(self, lower: OVector<T, N>, upper: OVector<T, N>) -> Result<Self, ObserverError> {
        check_bounds(lower.as_slice(), upper.as_slice(), self.layout.n)?;
        Ok(Self { bounds: Some((lower, upper)), ..self })
    }

    /// The estimator of outputs and states of which some are angles, as of the [extended
    /// filter](crate::ExtendedKalmanFilter::with_angles): the residuals `y - h(x)` are wrapped, and so are the
    /// differences of the means to the trajectory along which the problem is linearised. The turn of a state matters
    /// where f of a plant in discrete time wraps it; elsewhere it may be 0.
    ///
    /// # Errors
    /// [`ObserverError::Table`] for another length, [`ObserverError::NotPositive`] for a turn that is negative or not
    /// finite.
    pub fn with_angles(self, outputs: OVector<T, P>, states: OVector<T, N>) -> Result<Self, ObserverError> {
        let turns = angles::checked(outputs, self.layout.p)?;
        let state_turns = angles::checked(states, self.layout.n)?;
        Ok(Self { turns, state_turns, ..self })
    }

    /// The full turns of the outputs, if some are [angles](Self::with_angles).
    pub fn turns(&self) -> Option<&OVector<T, P>> {
        self.turns.as_ref()
    }

    /// The full turns of the states, if some are [angles](Self::with_angles).
    pub fn state_turns(&self) -> Option<&OVector<T, N>> {
        self.state_turns.as_ref()
    }

    /// The full turns of outputs and states as [`with_angles`](Self::with_angles) takes them; none without angles.
    pub fn angles(&self) -> Option<(OVector<T, P>, OVector<T, N>)> {
        angles::both(
            (&self.turns, self.noises.v.shape_generic().0),
            (&self.state_turns, self.noises.w.shape_generic().0),
        )
    }

    /// The estimator that joins predictions without a measurement between them into one, linearised where they were
    /// made: the window then counts samples with a measurement, as for a log with more rows of inputs than of outputs.
    /// Bounds hold at these samples. The state is longer by `window (1 + 2 n (n + 1))` numbers.
    ///
    /// # Errors
    /// [`ObserverError::Table`] for a length D of the state that is fixed.
    pub fn with_joined_predictions(self) -> Result<Self, ObserverError> {
        let layout = Layout { joins: true, ..self.layout };
        if let Some(found) = D::try_to_usize() {
            let what = "the dimension of the state of the estimator";
            return Err(ObserverError::Table { what, expected: layout.len(), found });
        }
        Ok(Self { layout, ..self })
    }

    /// Window and iterations.
    pub fn horizon(&self) -> Horizon {
        self.horizon
    }

    /// The plant.
    pub fn plant(&self) -> &S {
        &self.plant
    }

    /// The noise the estimator is designed for.
    pub fn noise_model(&self) -> &NoiseModel<T, N, P> {
        &self.noises
    }

    /// The lower triangle of G, with V = G G'.
    pub fn root(&self) -> &OMatrix<T, P, P> {
        self.root.lower()
    }

    /// The same estimator with another prediction.
    ///
    /// # Errors
    /// [`ObserverError::Substeps`] for no steps.
    pub fn with_prediction(self, prediction: Prediction) -> Result<Self, ObserverError> {
        if prediction == Prediction::RungeKutta(0) {
            return Err(ObserverError::Substeps);
        }
        Ok(Self { prediction, ..self })
    }

    /// How the estimator predicts.
    pub fn prediction(&self) -> Prediction {
        self.prediction
    }

    /// Runge-Kutta steps between samples, where their number is fixed.
    pub fn substeps(&self) -> Option<usize> {
        self.prediction.substeps()
    }

    /// The [bounds](Self::with_bounds), lower and upper.
    #[allow(clippy::type_complexity, reason = "lower and upper bounds")]
    pub fn bounds(&self) -> Option<(&OVector<T, N>, &OVector<T, N>)> {
        self.bounds.as_ref().map(|(lower, upper)| (lower, upper))
    }

    /// The covariance P of the error that a state holds, without regard to bounds: that of the linear problem along its
    /// trajectory.
    pub fn covariance(&self, state: &OVector<T, D>) -> OMatrix<T, N, N> {
        let order = self.noises.w.shape_generic().0;
        let stored = &state.as_slice()[self.layout.covariance()];
        OMatrix::from_fn_generic(order, order, |i, j| stored[i + j * self.layout.n])
    }

    /// `F(x)`, its Jacobian A and the covariance Q of the noise, over a duration from t on; errors are compared with
    /// the covariance `p` at x.
    fn linearised(
        &self,
        (t, duration): (T, T),
        x: &OVector<T, N>,
        p: &OMatrix<T, N, N>,
        u: &OVector<T, M>,
    ) -> Option<Transition<T, N>> {
        #[cfg(feature = "alloc")]
        if let Some(way) = self.linearised_at_run_time((t, duration), x, p, u) {
            return way;
        }
        let field = |t: T, x: &OVector<T, N>| self.plant.motion(t, x, u);
        let is_linear = self.plant.is_linear_between_samples();
        Motion { field, is_linear, w: &self.noises.w, with_covariance: true }.over(
            self.prediction,
            (t, duration, self.h),
            x,
            p,
        )
    }

    /// The same of a plant whose sizes are known at run time, by the extended filter with its sizes in its type; none
    /// for other sizes.
    #[cfg(feature = "alloc")]
    #[allow(clippy::option_option, reason = "no such sizes, or no result")]
    fn linearised_at_run_time(
        &self,
        (t, duration): (T, T),
        x: &OVector<T, N>,
        p: &OMatrix<T, N, N>,
        u: &OVector<T, M>,
    ) -> Option<Option<Transition<T, N>>> {
        // A module for web pages, which has to be downloaded, has this estimator for any size alone.
        if cfg!(target_arch = "wasm32") {
            return None;
        }
        let noises = same::<_, NoiseModel<f64, Dyn, Dyn>>(&self.noises)?;
        let filter = ExtendedAtRunTime {
            plant: &AtInput::<_, _, (N, M, P)>::new(&self.plant, u.as_slice()),
            noises: (&noises.w, &noises.v),
            gate: None,
            iterations: 1,
            turns: None,
            unit_vectors: None,
            h: *same(&self.h)?,
            prediction: self.prediction,
        };
        let mut way = Transition::none(x);
        let is_way = filter.way((*same(&t)?, *same(&duration)?), (same(x)?, same(p)?), same_mut(&mut way)?)?;
        Some(is_way.then_some(way))
    }

    /// The way from x at a stage of the window to the next one.
    fn way(&self, state: &[T], stage: usize, x: &OVector<T, N>, p: &OMatrix<T, N, N>) -> Option<Transition<T, N>> {
        if self.layout.joins && self.number(state, stage, Part::IsJoined) != T::zero() {
            let order = x.shape_generic().0;
            let [phi, noise] = [Part::Forward, Part::Noise].map(|part| {
                let entries = &state[self.layout.part(stage, part)];
                OMatrix::<T, N, N>::from_fn_generic(order, order, |i, j| entries[i + j * self.layout.n])
            });
            let [from, to] = [Part::From, Part::To].map(|part| self.column(order, state, stage, part));
            let next = to + times(&phi, &self.deviation(x, &from));
            return Some(Transition { next, phi, noise });
        }
        let (u, t) = (self.input(state, stage), self.number(state, stage, Part::Time));
        self.linearised((t, self.number(state, stage, Part::Duration)), x, p, &u)
    }

    /// Joins a way to those that led to the last stage, which measured nothing: into the way from the stage before it,
    /// or into the arrival cost.
    fn join(&self, state: &mut [T], way: &Transition<T, N>) -> Option<()> {
        let (order, n, layout) = (self.noises.w.shape_generic().0, self.layout.n, self.layout);
        let last = layout.count(state) - 1;
        let square = |entries: &[T]| OMatrix::<T, N, N>::from_fn_generic(order, order, |i, j| entries[i + j * n]);
        let Some(before) = last.checked_sub(1) else {
            let p = square(&state[layout.prior_covariance()]);
            let (mean, x) = (&state[layout.prior_mean()], self.column(order, state, 0, Part::State));
            let mean = OVector::<T, N>::from_fn_generic(order, U1, |i, _| mean[i]);
            let mean = &way.next + times(&way.phi, &self.deviation(&mean, &x));
            state[layout.prior_mean()].copy_from_slice(mean.as_slice());
            state[layout.prior_covariance()].copy_from_slice(way.spread(&p).as_slice());
            return Some(());
        };
        let x = self.column(order, state, before, Part::State);
        let first = self.way(state, before, &x, &self.noises.p0)?;
        let (phi, noise) = (times(&way.phi, &first.phi), way.spread(&first.noise));
        state[layout.part(before, Part::From)].copy_from_slice(x.as_slice());
        state[layout.part(before, Part::To)].copy_from_slice(way.next.as_slice());
        state[layout.part(before, Part::Forward)].copy_from_slice(phi.as_slice());
        state[layout.part(before, Part::Noise)].copy_from_slice(noise.as_slice());
        state[layout.part(before, Part::IsJoined)].fill(T::one());
        Some(())
    }

    /// How far a mean is from the trajectory.
    fn deviation(&self, mean: &OVector<T, N>, x: &OVector<T, N>) -> OVector<T, N> {
        angles::difference(&self.state_turns, mean, x)
    }

    /// A column of a stage.
    fn column<R: Dim>(&self, rows: R, state: &[T], stage: usize, part: Part) -> OVector<T, R>
    where
        DefaultAllocator: Allocator<R>,
    {
        let entries = &state[self.layout.part(stage, part)];
        OVector::from_fn_generic(rows, U1, |i, _| entries[i])
    }

    fn input(&self, state: &[T], stage: usize) -> OVector<T, M> {
        self.column(M::from_usize(self.layout.m), state, stage, Part::Input)
    }

    fn number(&self, state: &[T], stage: usize, part: Part) -> T {
        state[self.layout.part(stage, part).start]
    }

    /// The update of a stage by its measurements, linearised at x. None if a covariance is no covariance.
    fn measured(&self, state: &[T], stage: usize, x: &OVector<T, N>, at: &mut Stage<T, N, P>) -> Option<()> {
        let flags = &state[self.layout.part(stage, Part::Measured)];
        if flags.iter().all(|flag| *flag == T::zero()) {
            return Some(());
        }
        let (t, u) = (self.number(state, stage, Part::Time), self.input(state, stage));
        let (mut residual, mut c) = self.plant.measurement(t, x, &u);
        let y = &state[self.layout.part(stage, Part::Output)];
        let mut others = None;
        for i in 0..residual.nrows() {
            if flags[i] == T::zero() {
                residual[i] = T::zero();
                c.row_mut(i).fill(T::zero());
                let v = others.get_or_insert_with(|| self.noises.v.clone());
                v.row_mut(i).fill(T::zero());
                v.column_mut(i).fill(T::zero());
                v[(i, i)] = T::one();
            } else {
                residual[i] = angles::entry(&self.turns, i, y[i] - residual[i]);
            }
        }
        // With V = G G', the entries of G^-1 y are independent, with variance 1.
        let others = match others {
            Some(v) => Some(Factor::new(&v)?),
            None => None,
        };
        let factor = others.as_ref().unwrap_or(&self.root);
        factor.half_solve(&mut c);
        factor.half_solve(&mut residual);
        for i in 0..residual.nrows() {
            let mut innovation = residual[i];
            for k in 0..x.nrows() {
                at.rows[(k, i)] = c[(i, k)];
                innovation -= c[(i, k)] * angles::entry(&self.state_turns, k, at.mean[k] - x[k]);
            }
            if !at.measure(i, innovation) {
                return None;
            }
        }
        Some(())
    }

    /// One Gauss-Newton step: the solution of the problem linearised along x, and the covariance of the last stage.
    #[allow(clippy::type_complexity, reason = "trajectory, covariance")]
    fn pass(
        &self,
        state: &[T],
        count: usize,
        x: &Trajectory<T, N, L>,
        mut barrier: Option<(&mut [Barrier<T, N>; L], T)>,
    ) -> Option<(Trajectory<T, N, L>, OMatrix<T, N, N>)> {
        let (order, outputs) = (self.noises.w.shape_generic().0, self.noises.v.shape_generic().0);
        let (n, layout) = (self.layout.n, self.layout);
        let prior = &state[layout.prior_covariance()];
        let mean = &state[layout.prior_mean()];
        let first = Stage::new(
            OVector::from_fn_generic(order, U1, |i, _| mean[i]),
            OMatrix::from_fn_generic(order, order, |i, j| prior[i + j * n]),
            outputs,
        );
        let mut stages: [Stage<T, N, P>; L] =
            core::array::from_fn(|i| if i == 0 { first.clone() } else { Stage::unused() });
        for i in 0..count {
            self.measured(state, i, &x[i], &mut stages[i])?;
            if let Some((barrier, mu)) = &mut barrier {
                self.bounded(&mut barrier[i], *mu, &mut stages[i])?;
            }
            if i + 1 < count {
                let way = self.way(state, i, &x[i], &stages[i].covariance)?;
                let mean = &way.next + times(&way.phi, &self.deviation(&stages[i].mean, &x[i]));
                let p = way.spread(&stages[i].covariance);
                stages[i].forward = way.phi;
                stages[i + 1] = Stage::new(mean, p, outputs);
            }
        }
        let mut solution: Trajectory<T, N, L> = core::array::from_fn(|_| OVector::zeros_generic(unused(), U1));
        let mut lambda = OVector::<T, N>::zeros_generic(order, U1);
        for i in (0..count).rev() {
            if i + 1 < count {
                if let Some((barrier, _)) = &barrier {
                    self.before_bounds(&barrier[i + 1], &mut lambda);
                }
                stages[i + 1].before_outputs(&mut lambda);
                lambda = stages[i].backward(&lambda);
            }
            solution[i] = stages[i].smoothed(&lambda);
            if !are_finite(solution[i].as_slice()) {
                return None;
            }
        }
        Some((solution, stages[count - 1].covariance.clone()))
    }

    /// The trajectory that solves the window's problem, and the covariance of its last state.
    #[allow(clippy::type_complexity, reason = "trajectory, covariance")]
    fn solve(&self, state: &[T]) -> Option<(Trajectory<T, N, L>, OMatrix<T, N, N>)> {
        let (count, order) = (self.layout.count(state), self.noises.w.shape_generic().0);
        let stored = |i: usize| self.column(order, state, i, Part::State);
        let nothing = || OVector::zeros_generic(unused(), U1);
        let guess: Trajectory<T, N, L> = core::array::from_fn(|i| if i < count { stored(i) } else { nothing() });
        let mut solution = Some((guess.clone(), self.noises.w.clone()));
        for _ in 0..self.horizon.iterations {
            solution = solution.and_then(|(x, _)| self.pass(state, count, &x, None));
        }
        match solution {
            Some((x, p)) if self.is_within(count, &x) => Some((x, p)),
            Some((x, p)) => self.interior(state, count, x).map(|(x, _)| (x, p)),
            None if self.bounds.is_some() => self.interior(state, count, guess),
            None => None,
        }
    }

    /// The first sample of the window goes into the arrival cost.
    fn forget(&self, state: &mut [T]) -> Option<()> {
        let (order, n, layout) = (self.noises.w.shape_generic().0, self.layout.n, self.layout);
        let (mean, prior) = (&state[layout.prior_mean()], &state[layout.prior_covariance()]);
        let mut first = Stage::new(
            OVector::from_fn_generic(order, U1, |i, _| mean[i]),
            OMatrix::from_fn_generic(order, order, |i, j| prior[i + j * n]),
            self.noises.v.shape_generic().0,
        );
        let x = self.column(order, state, 0, Part::State);
        self.measured(state, 0, &x, &mut first)?;
        let way = self.way(state, 0, &x, &first.covariance)?;
        let mean = &way.next + times(&way.phi, &self.deviation(&first.mean, &x));
        let p = way.spread(&first.covariance);
        state[layout.prior_mean()].copy_from_slice(mean.as_slice());
        state[layout.prior_covariance()].copy_from_slice(p.as_slice());
        layout.shift(state);
        Some(())
    }

    /// The measurement y (length p) at time t under the input u, of which the outputs are used that are finite and for
    /// which `measured` is true: the window's problem is solved with it. `nu' S^-1 nu` of its innovation, or `None`,
    /// and the state as it was, if there is no such output, if the problem has no solution in floating point (f or h is
    /// not finite, a covariance is none), and for columns of other lengths than the plant's.
    pub fn update(
        &self,
        t: T,
        state: &mut OVector<T, D>,
        u: &OVector<T, M>,
        y: &OVector<T, P>,
        measured: impl Fn(usize) -> bool,
    ) -> Option<T> {
        let layout = self.layout;
        if !self.fits(state, u) || !self.is_measurement(y) {
            return None;
        }
        let usable = usable(y, measured)?;
        let mut next = state.clone();
        let entries = next.as_mut_slice();
        let last = layout.count(entries) - 1;
        entries[layout.part(last, Part::Input)].copy_from_slice(u.as_slice());
        entries[layout.part(last, Part::Time)].fill(t);
        for i in 0..layout.p {
            let (y, flag) = if usable[i] { (y[i], T::one()) } else { (T::zero(), T::zero()) };
            entries[layout.part(last, Part::Output).start + i] = y;
            entries[layout.part(last, Part::Measured).start + i] = flag;
        }
        let square = self.normalized_square(entries, last)?;
        let (x, p) = self.solve(entries)?;
        for (i, x) in x.iter().enumerate().take(last + 1) {
            entries[layout.part(i, Part::State)].copy_from_slice(x.as_slice());
        }
        entries[layout.estimate()].copy_from_slice(x[last].as_slice());
        entries[layout.covariance()].copy_from_slice(p.as_slice());
        *state = next;
        Some(square)
    }

    /// `nu' S^-1 nu` of the last stage, by the estimate and the covariance before its measurement.
    fn normalized_square(&self, state: &[T], last: usize) -> Option<T> {
        let (order, n) = (self.noises.w.shape_generic().0, self.layout.n);
        let (xhat, p) = (&state[self.layout.estimate()], &state[self.layout.covariance()]);
        let x = OVector::<T, N>::from_fn_generic(order, U1, |i, _| xhat[i]);
        let p = OMatrix::<T, N, N>::from_fn_generic(order, order, |i, j| p[i + j * n]);
        let (t, u) = (self.number(state, last, Part::Time), self.input(state, last));
        let (expected, c) = self.plant.measurement(t, &x, &u);
        let mut s = times_transpose(&times(&c, &p), &c) + &self.noises.v;
        let (y, flags) = (&state[self.layout.part(last, Part::Output)], &state[self.layout.part(last, Part::Measured)]);
        let mut innovation = expected.clone();
        for i in 0..innovation.nrows() {
            innovation[i] = angles::entry(&self.turns, i, y[i] - expected[i]);
            if flags[i] == T::zero() {
                innovation[i] = T::zero();
                s.row_mut(i).fill(T::zero());
                s.column_mut(i).fill(T::zero());
                s[(i, i)] = T::one();
            }
        }
        let solved = Factor::new(&s)?.solve(&innovation);
        let mut square = T::zero();
        for i in 0..innovation.nrows() {
            square += innovation[i] * solved[i];
        }
        Some(square)
    }

    /// From t to `t + duration`, the input held; in [discrete time](Self::discrete) to the next sample, whatever the
    /// duration. False, and the state as it was, if it has no result in floating point, and for columns of other
    /// lengths than the plant's.
    #[must_use = "without a result the state has not moved"]
    pub fn predict(&self, t: T, state: &mut OVector<T, D>, u: &OVector<T, M>, duration: T) -> bool {
        self.predicted(t, state, u, duration).is_some_and(|next| {
            *state = next;
            true
        })
    }

    fn predicted(&self, t: T, state: &OVector<T, D>, u: &OVector<T, M>, duration: T) -> Option<OVector<T, D>> {
        if !self.fits(state, u) {
            return None;
        }
        let (layout, mut moved) = (self.layout, state.clone());
        let entries = moved.as_mut_slice();
        let mut count = layout.count(entries);
        let last = count - 1;
        entries[layout.part(last, Part::Input)].copy_from_slice(u.as_slice());
        entries[layout.part(last, Part::Time)].fill(t);
        entries[layout.part(last, Part::Duration)].fill(duration);
        let x = self.column(self.noises.w.shape_generic().0, entries, last, Part::State);
        let before = self.covariance(state);
        let way = self.linearised((t, duration), &x, &before, u)?;
        let (next, p) = (&way.next, way.spread(&before));
        if !(are_finite(next.as_slice()) && are_finite(p.as_slice())) {
            return None;
        }
        let measured = entries[layout.part(last, Part::Measured)].iter().any(|flag| *flag != T::zero());
        if layout.joins && !measured {
            self.join(entries, &way)?;
            count -= 1;
        } else if count == layout.stages {
            self.forget(entries)?;
            count -= 1;
        }
        entries[layout.estimate()].copy_from_slice(next.as_slice());
        entries[layout.covariance()].copy_from_slice(p.as_slice());
        entries[layout.part(count, Part::State)].copy_from_slice(next.as_slice());
        entries[layout.part(count, Part::Measured)].fill(T::zero());
        entries[layout.part(count, Part::Output)].fill(T::zero());
        if layout.joins {
            entries[layout.part(count, Part::IsJoined)].fill(T::zero());
        }
        layout.set_count(entries, count + 1);
        Some(moved)
    }

    /// Whether state and input have the lengths of estimator and plant.
    fn fits(&self, state: &OVector<T, D>, u: &OVector<T, M>) -> bool {
        has_rows::<D>(state.nrows(), || self.layout.len()) && has_rows::<M>(u.nrows(), || self.layout.m)
    }

    fn is_measurement(&self, y: &OVector<T, P>) -> bool {
        has_rows::<P>(y.nrows(), || self.layout.p)
    }

    fn finish(&self, t: T, state: &mut OVector<T, D>, u: &OVector<T, M>) {
        if self.fits(state, u) && !self.predict(t, state, u, self.h) {
            state.as_mut_slice()[self.layout.estimate()].fill(convert(f64::NAN));
        }
    }
}
