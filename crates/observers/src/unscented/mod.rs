//! The unscented Kalman filter in square-root form.
//!
//! `x' = f(x, u) + w`, `y_k = h(x(t_k), u(t_k)) + v_k` with w white of intensity W per unit of time, or in discrete
//! time
//! `x+ = f(x, u) + w` with w of covariance W per sample; v_k of covariance V. Means and covariances come from the
//! images of [sigma points](SigmaPoints), `2 n + 1` evaluations of h at a sample and of f, or of its integral, between
//! two. What is stored is the factor S of the covariance, `P = S S'`, which cannot lose symmetry
//! or definiteness to rounding.
//!
//! At a sample the points are those of (xhat, S), and the columns of the images under h form, with those of S, the
//! factor of the covariance of measurement and state together:
//!
//! ```text
//! [V^(1/2), D, E, e0; 0, S, 0, 0]  ->  [G, 0; M, S+]                rotations from the right
//! xhat <- xhat + M G^-1 (y - yhat),  S <- S+                        innovation covariance G G'
//! ```
//!
//! with the half differences D, half sums E and the centre e0. Between two samples the points are those of (xhat, S) in
//! discrete time, and their images, with `W^(1/2)`, are rotated into the next S. In continuous time each point moves
//! along the plant, and the noise is that of the extended Kalman filter, `Q = int Phi W Phi' ds` along the centre
//! ([`Prediction`]): of the plant's derivatives the Jacobian along the centre is needed, and no other.
//!
//! For a linear plant this is the Kalman filter to rounding. For a nonlinear one it is right to second
//! order in the error, where the extended filter is right to first order; there is no theorem of stability for either.
//!
//! A factorisation can fail: where the centre's weight is negative (small alpha) its column is taken away, and what is
//! left need not be positive definite; or f or h is not finite at a sigma point.
//! [`update`](UnscentedKalmanFilter::update) and [`predict`](UnscentedKalmanFilter::predict) say so and leave the
//! estimate as it was; a [`step`](SampledObserver::step) whose prediction fails leaves an estimate that is NaN.
//!
//! Source: R. van der Merwe and E. A. Wan, The square-root unscented Kalman filter for state and parameter-estimation,
//! ICASSP 2001; the joint factor in place of their downdates by `K S_y`, which can fail for any weights: S. J. Julier
//! and J. K. Uhlmann, Unscented filtering and nonlinear estimation, Proc. IEEE 92, 2004, for the joint covariance.

mod sigma;

use core::marker::PhantomData;

use luenberger_plants::error::check_matrix;
use luenberger_plants::{Column, Differentiable, Size};
use nalgebra::allocator::Allocator;
use nalgebra::{Const, DefaultAllocator, Dim, DimAdd, DimSum, OMatrix, OVector, RealField, U1, convert};
#[cfg(feature = "alloc")]
use nalgebra::{DVector, Dyn, U0};

use crate::angles::{self, Turns};
use crate::covariance_filter::{CovarianceFilter, predict_columns, update_columns};
use crate::dense::{are_finite, times_transpose};
use crate::error::ObserverError;
use crate::gaussian::{GaussianEstimate, Innovation, NoiseModel, covariance, usable};
#[cfg(feature = "alloc")]
use crate::held::{AtInput, AtRunTime, Held, OnSlices, Part, on_numbers, same};
use crate::observer::{ObserverDimensions, SampledObserver, has_rows, put_slice, step_columns};
use crate::transition::{Motion, Prediction};
use crate::triangular::{Joint, add, semidefinite_factor, subtract};

use sigma::Images;
pub use sigma::{SigmaPoints, Weights};

/// The state of the filter: the estimate, and the factor S of its covariance `S S'`.
#[derive(Clone, Debug, PartialEq)]
pub struct SquareRootEstimate<T: RealField + Copy, N: DimAdd<U1>>(GaussianEstimate<T, N>)
where
    DefaultAllocator: Allocator<N, DimSum<N, U1>>;

impl<T: RealField + Copy, N: DimAdd<U1>> SquareRootEstimate<T, N>
where
    DefaultAllocator: Allocator<N, DimSum<N, U1>> + Allocator<N> + Allocator<N, N>,
{
    /// The state with estimate xhat (length n) and covariance `S S'` (S n x n, lower triangular).
    pub fn new(xhat: &OVector<T, N>, s: &OMatrix<T, N, N>) -> Self {
        Self(GaussianEstimate::new(xhat, s))
    }

    /// The estimate xhat.
    pub fn estimate(&self) -> OVector<T, N> {
        self.0.estimate()
    }

    /// The lower triangular factor S.
    pub fn factor(&self) -> OMatrix<T, N, N> {
        self.0.covariance()
    }

    /// The estimate and the factor, one beside the other.
    #[cfg(feature = "alloc")]
    pub(crate) fn joined(&self) -> &GaussianEstimate<T, N> {
        &self.0
    }

    /// The covariance `P = S S'`.
    pub fn covariance(&self) -> OMatrix<T, N, N> {
        let s = self.factor();
        times_transpose(&s, &s)
    }
}

impl<T: RealField + Copy, N: DimAdd<U1>> Column<T> for SquareRootEstimate<T, N>
where
    DefaultAllocator: Allocator<N, DimSum<N, U1>> + Allocator<N> + Allocator<N, N>,
{
    fn try_from_slice(entries: &[T]) -> Option<Self> {
        GaussianEstimate::try_from_slice(entries).map(Self)
    }

    fn as_slice(&self) -> &[T] {
        self.0.as_slice()
    }

    fn fixed_len() -> Option<usize> {
        GaussianEstimate::<T, N>::fixed_len()
    }
}

/// The square-root unscented Kalman filter of a plant `S`; see the [module](self).
#[derive(Clone, Debug, PartialEq)]
pub struct UnscentedKalmanFilter<S, T: RealField + Copy, N: Dim, M: Dim, P: Dim>
where
    DefaultAllocator: Size<N, M, P>,
{
    plant: S,
    factors: NoiseModel<T, N, P>,
    sigma: SigmaPoints,
    weights: Weights<T>,
    h: T,
    prediction: Prediction,
    gate: Option<T>,
    /// Of the outputs, and of the states.
    turns: Turns<T, P>,
    state_turns: Turns<T, N>,
    inputs: PhantomData<M>,
}

/// An unscented Kalman filter whose sizes are known at compile time.
pub type StaticUnscentedKalmanFilter<S, T, const N: usize, const M: usize, const P: usize> =
    UnscentedKalmanFilter<S, T, Const<N>, Const<M>, Const<P>>;

impl<S, T: RealField + Copy, N: Dim, M: Dim, P: Dim> UnscentedKalmanFilter<S, T, N, M, P>
where
    S: Differentiable<T, N, M, P>,
    DefaultAllocator: Size<N, M, P>,
{
    /// The filter of `plant`, sampled with period `h`, with `substeps` Runge-Kutta steps between samples: for a target.
    /// [`error_controlled`](Self::error_controlled) takes as many as are right.
    ///
    /// A step costs `2 n + 1` evaluations of h, `4 substeps (2 n + 2)` of f and `4 substeps` of Df, to leading order
    /// `6 n^3 + 26 substeps n^3 + 3 n (n + p)^2` flops of products and rotations, and about
    /// `4 n (n + p + substeps n)` roots.
    ///
    /// ```
    /// use luenberger_observers::kalman::NoiseModel;
    /// use luenberger_observers::unscented::{SigmaPoints, UnscentedKalmanFilter};
    /// use luenberger_observers::SampledObserver;
    /// use luenberger_plants::flexible_joint;
    /// use nalgebra::{Matrix2, Matrix4, Vector1, Vector2, Vector4};
    ///
    /// let noises = NoiseModel { w: Matrix4::identity() * 0.1, v: Matrix2::identity() * 1e-4, p0: Matrix4::identity() };
    /// let plant = flexible_joint::classical();
    /// let filter = UnscentedKalmanFilter::new(plant, noises, SigmaPoints::default(), 0.01, 2)?;
    /// let (u, y) = (Vector1::new(0.0), Vector2::new(1.0, 0.0));
    /// let mut estimate = filter.initial(0.0, &Vector4::zeros(), &u, &y);
    /// filter.step(0.0, &mut estimate, &u, &y);
    /// assert!(estimate.covariance()[(0, 0)] < 0.01);
    /// # Ok::<(), luenberger_observers::ObserverError>(())
    /// ```
    /// # Errors
    /// [`ObserverError::Matrix`] for shapes and entries, [`ObserverError::NotSymmetric`],
    /// [`ObserverError::NotDefinite`] when V is not positive definite or W or P(0) not semidefinite,
    /// [`ObserverError::NotPositive`] and [`ObserverError::NotFinite`] for the sigma points, [`ObserverError::Period`],
    /// [`ObserverError::Substeps`].
    pub fn new(
        plant: S,
        noises: NoiseModel<T, N, P>,
        sigma: SigmaPoints,
        h: T,
        substeps: usize,
    ) -> Result<Self, ObserverError> {
        let size = plant.dimensions();
        let factors = NoiseModel {
            w: semidefinite_factor(&covariance("W", noises.w, size.states, false)?),
            v: semidefinite_factor(&covariance("V", noises.v, size.outputs, true)?),
            p0: semidefinite_factor(&covariance("P(0)", noises.p0, size.states, false)?),
        };
        Self::from_factors(plant, factors, sigma, h, Prediction::RungeKutta(substeps))
    }

    /// The filter of a plant in discrete time, `x+ = f(t, x, u) + w`, whose `derivative` is the next state; W is a
    /// covariance per sample.
    ///
    /// # Errors
    /// As [`new`](Self::new).
    pub fn discrete(plant: S, noises: NoiseModel<T, N, P>, sigma: SigmaPoints, h: T) -> Result<Self, ObserverError> {
        Ok(Self { prediction: Prediction::Discrete, ..Self::new(plant, noises, sigma, h, 1)? })
    }

    #[cfg(feature = "alloc")]
    /// The filter of `plant`, sampled with period `h`, whose prediction controls its error: that of the Kalman filter
    /// for a plant that is linear between samples, and right for stiff ones. How long a step takes depends on the
    /// plant.
    ///
    /// # Errors
    /// As [`new`](Self::new).
    pub fn error_controlled(
        plant: S,
        noises: NoiseModel<T, N, P>,
        sigma: SigmaPoints,
        h: T,
    ) -> Result<Self, ObserverError> {
        Ok(Self { prediction: Prediction::ErrorControlled, ..Self::new(plant, noises, sigma, h, 1)? })
    }

    /// The filter with lower triangular factors in place of the covariances W, V and P(0), as
    /// [`factors`](Self::factors) has them.
    ///
    /// # Errors
    /// As [`new`](Self::new); [`ObserverError::NotDefinite`] for a diagonal entry that is negative, or of V zero.
    pub fn from_factors(
        plant: S,
        factors: NoiseModel<T, N, P>,
        sigma: SigmaPoints,
        h: T,
        prediction: Prediction,
    ) -> Result<Self, ObserverError> {
        let size = plant.dimensions();
        let NoiseModel { w, v, p0 } = factors;
        let factors = NoiseModel {
            w: triangle("W^(1/2)", w, size.states, false)?,
            v: triangle("V^(1/2)", v, size.outputs, true)?,
            p0: triangle("P(0)^(1/2)", p0, size.states, false)?,
        };
        let weights = sigma.weights(size.states)?;
        if !(h.is_finite() && h > T::zero()) {
            return Err(ObserverError::Period { period: h.to_subset_unchecked() });
        }
        if prediction == Prediction::RungeKutta(0) {
            return Err(ObserverError::Substeps);
        }
        let (turns, state_turns) = (None, None);
        Ok(Self { plant, factors, sigma, weights, h, prediction, gate: None, turns, state_turns, inputs: PhantomData })
    }

    /// The filter that rejects outliers: an output whose innovation is beyond `gate` standard deviations is treated as
    /// not measured, as of the [extended filter](crate::ExtendedKalmanFilter::with_gate).
    ///
    /// # Errors
    /// [`ObserverError::NotPositive`].
    pub fn with_gate(self, gate: T) -> Result<Self, ObserverError> {
        if gate.is_finite() && gate > T::zero() {
            return Ok(Self { gate: Some(gate), ..self });
        }
        Err(ObserverError::NotPositive { what: "the gate", value: gate.to_subset_unchecked() })
    }

    /// The filter of outputs and states of which some are angles, as of the [extended
    /// filter](crate::ExtendedKalmanFilter::with_angles): innovations are wrapped, and so are the differences of the
    /// sigma points' images to that of the centre, before their mean is taken. The turn of a state matters where f of a
    /// plant in discrete time wraps it; elsewhere it may be 0.
    ///
    /// The points of an angle are less than half a turn from the centre if its standard deviation is below
    /// `turn/(2 gamma)` with the distance gamma of the [weights](Self::weights); beyond, they are taken for others.
    ///
    /// # Errors
    /// [`ObserverError::Table`] for another length, [`ObserverError::NotPositive`] for a turn that is negative or not
    /// finite.
    pub fn with_angles(self, outputs: OVector<T, P>, states: OVector<T, N>) -> Result<Self, ObserverError> {
        let turns = angles::checked(outputs, self.factors.v.nrows())?;
        let state_turns = angles::checked(states, self.factors.w.nrows())?;
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
            (&self.turns, self.factors.v.shape_generic().0),
            (&self.state_turns, self.factors.w.shape_generic().0),
        )
    }

    /// The same filter with another prediction.
    ///
    /// # Errors
    /// [`ObserverError::Substeps`] for no steps.
    pub fn with_prediction(self, prediction: Prediction) -> Result<Self, ObserverError> {
        if prediction == Prediction::RungeKutta(0) {
            return Err(ObserverError::Substeps);
        }
        Ok(Self { prediction, ..self })
    }

    /// How the filter predicts.
    pub fn prediction(&self) -> Prediction {
        self.prediction
    }

    /// Runge-Kutta steps between two samples, where their number is fixed.
    pub fn substeps(&self) -> Option<usize> {
        self.prediction.substeps()
    }

    /// The sampling period.
    #[cfg(feature = "alloc")]
    pub(crate) fn h(&self) -> T {
        self.h
    }

    /// The [gate](Self::with_gate), in standard deviations.
    pub fn gate(&self) -> Option<T> {
        self.gate
    }

    /// The plant.
    pub fn plant(&self) -> &S {
        &self.plant
    }

    /// The parameters of the sigma points.
    pub fn sigma_points(&self) -> SigmaPoints {
        self.sigma
    }

    /// The numbers of the sigma points in the format of the filter.
    pub fn weights(&self) -> &Weights<T> {
        &self.weights
    }

    /// The same filter with factors that were checked.
    #[cfg(feature = "alloc")]
    pub(crate) fn of_factors(self, factors: NoiseModel<T, N, P>) -> Self {
        Self { factors, ..self }
    }

    /// The lower triangular factors of W, V and P(0).
    pub fn factors(&self) -> &NoiseModel<T, N, P> {
        &self.factors
    }

    /// A step at an input, or its update or prediction alone, of a filter whose sizes are known at run time; false for
    /// other sizes and lengths.
    #[cfg(feature = "alloc")]
    fn at_run_time(&self, (t, u): (T, &[T]), state: &mut [T], y: &[T], part: Part<'_>) -> bool {
        // A module for web pages, which has to be downloaded, has this filter for any size alone.
        if cfg!(target_arch = "wasm32") || u.len() != self.plant.dimensions().inputs {
            return false;
        }
        let (turns, state_turns) = (same(&self.turns), same(&self.state_turns));
        let (Some(turns), Some(state_turns)) = (turns, state_turns) else { return false };
        let (factors, weights) = (same(&self.factors), same(&self.weights));
        let (Some(factors), Some(weights)) = (factors, weights) else { return false };
        let (Some(gate), Some(h)) = (same(&self.gate), same(&self.h)) else { return false };
        let filter = UnscentedAtRunTime {
            plant: &AtInput::<_, _, (N, M, P)>::new(&self.plant, u),
            factors,
            sigma: self.sigma,
            weights: *weights,
            h: *h,
            prediction: self.prediction,
            gate: *gate,
            turns,
            state_turns,
        };
        on_numbers((t, y), state, |t, state, y| filter.run(t, state, y, part))
    }

    /// The measurement that (xhat, S) predicts, and the factor of its joint covariance with the state.
    #[allow(clippy::type_complexity, reason = "expected measurement, factor")]
    fn joint(
        &self,
        t: T,
        (xhat, s): (&OVector<T, N>, &OMatrix<T, N, N>),
        u: &OVector<T, M>,
        measured: impl Fn(usize) -> bool,
    ) -> Option<(OVector<T, P>, Joint<T, N, P>)> {
        let mut images = Images::of(xhat, s, self.weights.distance, |x| self.plant.output(t, x, u));
        let expected = images.reduce(&self.weights, &self.turns);
        let (states, outputs) = (xhat.shape_generic().0, expected.shape_generic().0);
        let mut joint = Joint {
            measured: self.factors.v.clone(),
            cross: OMatrix::zeros_generic(states, outputs),
            state: OMatrix::zeros_generic(states, states),
        };
        let mut column = OVector::<T, P>::zeros_generic(outputs, U1);
        for i in 0..expected.nrows() {
            if measured(i) {
                continue;
            }
            images.centre[i] = T::zero();
            images.plus.row_mut(i).fill(T::zero());
            images.minus.row_mut(i).fill(T::zero());
            joint.measured.row_mut(i).fill(T::zero());
            column.fill(T::zero());
            column[i] = T::one();
            add(&mut joint.measured, &mut column);
        }
        for k in 0..xhat.nrows() {
            column.copy_from(&images.minus.column(k));
            add(&mut joint.measured, &mut column);
        }
        let mut rest = OVector::<T, N>::zeros_generic(states, U1);
        for k in 0..xhat.nrows() {
            column.copy_from(&images.plus.column(k));
            rest.copy_from(&s.column(k));
            joint.add(&mut column, &mut rest);
        }
        rest.fill(T::zero());
        let is_factor = if self.weights.is_negative {
            joint.subtract(&mut images.centre, &mut rest)
        } else {
            joint.add(&mut images.centre, &mut rest);
            true
        };
        let diagonal = |i: usize| joint.measured[(i, i)] > T::zero();
        let is_right = is_factor
            && (0..expected.nrows()).all(diagonal)
            && are_finite(joint.measured.as_slice())
            && are_finite(joint.cross.as_slice())
            && are_finite(joint.state.as_slice());
        is_right.then_some((expected, joint))
    }
}

/// A lower triangular factor, after a check of its shape and its entries.
fn triangle<T: RealField + Copy, D: Dim>(
    what: &'static str,
    s: OMatrix<T, D, D>,
    order: usize,
    is_definite: bool,
) -> Result<OMatrix<T, D, D>, ObserverError>
where
    DefaultAllocator: Allocator<D, D>,
{
    check_matrix(what, &s, (order, order))?;
    for row in 0..order {
        for column in row + 1..order {
            if s[(row, column)] != T::zero() {
                let entry = s[(row, column)].to_subset_unchecked();
                return Err(ObserverError::NotTriangular { what, row, column, entry });
            }
        }
        let pivot = s[(row, row)];
        if pivot < T::zero() || is_definite && pivot == T::zero() {
            return Err(ObserverError::NotDefinite { what, row, pivot: pivot.to_subset_unchecked() });
        }
    }
    Ok(s)
}

impl<S, T: RealField + Copy, N: DimAdd<U1>, M: Dim, P: Dim> UnscentedKalmanFilter<S, T, N, M, P>
where
    S: Differentiable<T, N, M, P>,
    DefaultAllocator: Size<N, M, P> + Allocator<N, DimSum<N, U1>>,
{
    /// From time t to `t + duration`, the input held; for a plant in [discrete time](Self::discrete) to the next
    /// sample, whatever the duration, which is nonnegative. A fixed number of Runge-Kutta steps is taken for each
    /// period or part of one.
    ///
    /// False, with `estimate` unchanged, if the covariance has no factor in floating point: f is not finite at a sigma
    /// point, as for an input that is NaN, or taking the centre away leaves no positive definite matrix; and for
    /// columns of other lengths than the plant's.
    #[must_use = "without a factor the estimate is unchanged"]
    pub fn predict(&self, t: T, estimate: &mut SquareRootEstimate<T, N>, u: &OVector<T, M>, duration: T) -> bool {
        self.predicted(t, estimate, u, duration).is_some_and(|(next, _)| {
            *estimate = next;
            true
        })
    }

    /// The estimate after the prediction, and the covariance of the states before and after it.
    #[allow(clippy::type_complexity, reason = "estimate, cross covariance")]
    fn predicted(
        &self,
        t: T,
        estimate: &SquareRootEstimate<T, N>,
        u: &OVector<T, M>,
        duration: T,
    ) -> Option<(SquareRootEstimate<T, N>, OMatrix<T, N, N>)> {
        if !self.fits(estimate, u) {
            return None;
        }
        let (xhat, s) = (estimate.estimate(), estimate.factor());
        let (mut images, mut next) = self.images(t, (&xhat, &s), u, duration)?;
        let xhat = images.reduce(&self.weights, &self.state_turns);
        for columns in [&images.minus, &images.plus] {
            for k in 0..xhat.nrows() {
                add(&mut next, &mut columns.column(k).into_owned());
            }
        }
        let is_factor = if self.weights.is_negative {
            subtract(&mut next, &mut images.centre)
        } else {
            add(&mut next, &mut images.centre);
            true
        };
        let is_finite = are_finite(xhat.as_slice()) && are_finite(next.as_slice());
        // The half differences D belong to the columns of S.
        (is_factor && is_finite).then(|| (SquareRootEstimate::new(&xhat, &next), times_transpose(&s, &images.plus)))
    }

    /// The images of the sigma points after a duration, and the factor of Q.
    #[allow(clippy::type_complexity, reason = "images, factor")]
    #[cfg_attr(
        not(feature = "alloc"),
        allow(clippy::unnecessary_wraps, reason = "none with control of the error alone")
    )]
    fn images(
        &self,
        t: T,
        (xhat, s): (&OVector<T, N>, &OMatrix<T, N, N>),
        u: &OVector<T, M>,
        duration: T,
    ) -> Option<(Images<T, N, N>, OMatrix<T, N, N>)> {
        let Self { plant, prediction, h, .. } = self;
        let distance = self.weights.distance;
        let derivative = |t: T, x: &OVector<T, N>| plant.derivative(t, x, u);
        let field = |t: T, x: &OVector<T, N>| plant.motion(t, x, u);
        // Where the next state alone is asked for, Df is not.
        let unknown = s * T::zero();
        let alone = |t: T, x: &OVector<T, N>| (derivative(t, x), unknown.clone());
        let w = times_transpose(&self.factors.w, &self.factors.w);
        let centre = Motion { field, is_linear: plant.is_linear_between_samples(), w: &w, with_covariance: true };
        let point = Motion { field: alone, is_linear: false, w: &w, with_covariance: false };
        match prediction {
            Prediction::Discrete => {
                let images = Images::of(xhat, s, distance, |x| derivative(t, x));
                Some((images, self.factors.w.clone()))
            }
            Prediction::RungeKutta(_) => {
                let count = prediction.steps(duration, *h);
                let images = Images::of(xhat, s, distance, |x| point.classical(t, duration, count, x).next);
                Some((images, centre.classical_by_factors((t, duration), count, xhat, &self.factors.w).noise))
            }
            #[cfg(feature = "alloc")]
            Prediction::ErrorControlled => {
                let (p, nan) = (times_transpose(s, s), convert::<f64, T>(f64::NAN));
                let (image, noise) = centre.around(&point, *prediction, (t, duration, *h), (xhat, &p))?;
                let images = Images::of(xhat, s, distance, |x| image(x).unwrap_or_else(|| x * nan));
                Some((images, semidefinite_factor(&noise)))
            }
        }
    }

    /// Updates estimate and covariance by the measurement y (length p) at time t under the input u; returns the
    /// innovation.
    ///
    /// `None`, with `estimate` unchanged, if there is no result: no entry of y is finite (one that is not counts as not
    /// measured), or an overflow; the joint covariance has no factor in floating point, because h is not
    /// finite at a sigma point, or taking the centre away leaves no positive definite matrix; columns of other lengths
    /// than the plant's.
    pub fn update(
        &self,
        t: T,
        estimate: &mut SquareRootEstimate<T, N>,
        u: &OVector<T, M>,
        y: &OVector<T, P>,
    ) -> Option<Innovation<T, P>> {
        self.update_partial(t, estimate, u, y, |_| true)
    }

    /// [`update`](Self::update) with those outputs alone for which `measured` is true; the other entries of y are not
    /// read. What the [gate](Self::with_gate) rejects counts as not measured.
    pub fn update_partial(
        &self,
        t: T,
        estimate: &mut SquareRootEstimate<T, N>,
        u: &OVector<T, M>,
        y: &OVector<T, P>,
        measured: impl Fn(usize) -> bool,
    ) -> Option<Innovation<T, P>> {
        if !self.fits(estimate, u) || !self.is_measurement(y) {
            return None;
        }
        let mut kept = usable(y, measured)?;
        let (xhat, s) = (estimate.estimate(), estimate.factor());
        let (expected, mut joint) = self.joint(t, (&xhat, &s), u, |i| self.gate.is_some() || kept[i])?;
        let mut value = angles::difference(&self.turns, y, &expected);
        if let Some(gate) = self.gate {
            for i in 0..value.nrows() {
                kept[i] = kept[i] && !beyond(gate, value[i], &joint.measured, i);
            }
            joint = self.joint(t, (&xhat, &s), u, |i| kept[i])?.1;
        }
        (0..value.nrows()).filter(|&i| !kept[i]).for_each(|i| value[i] = T::zero());
        // G^-1 y~.
        let mut whitened = value.clone();
        for i in 0..whitened.nrows() {
            let entry = (0..i).fold(whitened[i], |entry, k| entry - joint.measured[(i, k)] * whitened[k]);
            whitened[i] = entry / joint.measured[(i, i)];
        }
        let mut next = xhat;
        for i in 0..next.nrows() {
            for k in 0..whitened.nrows() {
                next[i] += joint.cross[(i, k)] * whitened[k];
            }
        }
        if !are_finite(next.as_slice()) {
            return None;
        }
        *estimate = SquareRootEstimate::new(&next, &joint.state);
        let covariance = times_transpose(&joint.measured, &joint.measured);
        Some(Innovation { value, covariance, normalized_square: whitened.dot(&whitened) })
    }

    /// Whether the gate rejects output `output` of the measurement y at time t under the input u: NaN and infinities
    /// always; nothing without a [gate](Self::with_gate), nor for columns of other lengths.
    pub fn rejects(
        &self,
        t: T,
        estimate: &SquareRootEstimate<T, N>,
        u: &OVector<T, M>,
        y: &OVector<T, P>,
        output: usize,
    ) -> bool {
        let Some(gate) = self.gate else { return false };
        if !self.fits(estimate, u) || !self.is_measurement(y) || output >= y.nrows() {
            return false;
        }
        let joint = self.joint(t, (&estimate.estimate(), &estimate.factor()), u, |_| true);
        joint.is_some_and(|(expected, joint)| {
            let value = angles::entry(&self.turns, output, y[output] - expected[output]);
            beyond(gate, value, &joint.measured, output)
        })
    }

    /// [`step`](SampledObserver::step) without the [update](Self::update): the prediction over the period, and NaN
    /// where it has no result. Columns of other lengths change nothing.
    pub fn finish(&self, t: T, state: &mut SquareRootEstimate<T, N>, u: &OVector<T, M>) {
        if self.fits(state, u) && !self.predict(t, state, u, self.h) {
            state.0 = state.0.lost();
        }
    }

    /// Whether estimate and input have the lengths of the plant.
    fn fits(&self, estimate: &SquareRootEstimate<T, N>, u: &OVector<T, M>) -> bool {
        has_rows::<N>(estimate.0.order(), || self.factors.w.nrows())
            && has_rows::<M>(u.nrows(), || self.plant.dimensions().inputs)
    }

    fn is_measurement(&self, y: &OVector<T, P>) -> bool {
        has_rows::<P>(y.nrows(), || self.factors.v.nrows())
    }
}

/// Whether entry `i` of an innovation with the covariance `G G'` is beyond so many standard deviations, or NaN.
fn beyond<T: RealField + Copy, P: Dim>(gate: T, value: T, g: &OMatrix<T, P, P>, i: usize) -> bool
where
    DefaultAllocator: Allocator<P, P>,
{
    let mut variance = T::zero();
    for k in 0..=i {
        variance += g[(i, k)] * g[(i, k)];
    }
    let is_within = value * value <= gate * gate * variance;
    !is_within
}

impl<S, T: RealField + Copy, N: DimAdd<U1>, M: Dim, P: Dim> SampledObserver<T> for UnscentedKalmanFilter<S, T, N, M, P>
where
    S: Differentiable<T, N, M, P>,
    DefaultAllocator: Size<N, M, P> + Allocator<N, DimSum<N, U1>>,
{
    type State = SquareRootEstimate<T, N>;
    type Input = OVector<T, M>;
    type Output = OVector<T, P>;
    type Estimate = OVector<T, N>;

    fn dimensions(&self) -> ObserverDimensions {
        let size = self.plant.dimensions();
        ObserverDimensions {
            state: size.states * (size.states + 1),
            inputs: size.inputs,
            outputs: size.outputs,
            estimate: size.states,
        }
    }

    fn period(&self) -> T {
        self.h
    }

    /// Update and prediction. An output that is NaN or infinite counts as not measured; a sample where
    /// [`update`](UnscentedKalmanFilter::update) is `None` is passed over as if it were missed. A
    /// [prediction](UnscentedKalmanFilter::predict) without a result, as for an input that is NaN, makes the estimate
    /// NaN. Columns of other lengths change nothing.
    fn step(&self, t: T, state: &mut Self::State, u: &Self::Input, y: &Self::Output) {
        #[cfg(feature = "alloc")]
        if self.at_run_time((t, u.as_slice()), state.0.as_mut_slice(), y.as_slice(), Part::Step(&[])) {
            return;
        }
        if self.is_measurement(y) {
            self.update(t, state, u, y);
            self.finish(t, state, u);
        }
    }

    fn step_partial(&self, t: T, state: &mut Self::State, u: &Self::Input, y: &Self::Output, measured: &[bool]) {
        #[cfg(feature = "alloc")]
        if !measured.is_empty()
            && self.at_run_time((t, u.as_slice()), state.0.as_mut_slice(), y.as_slice(), Part::Step(measured))
        {
            return;
        }
        if self.is_measurement(y) {
            if measured.contains(&true) {
                self.update_partial(t, state, u, y, |output| measured.get(output).copied().unwrap_or(true));
            }
            self.finish(t, state, u);
        }
    }

    fn step_into(&self, t: T, state: &mut [T], u: &[T], y: &[T], measured: &[bool]) -> bool {
        #[cfg(feature = "alloc")]
        if self.at_run_time((t, u), state, y, Part::Step(measured)) {
            return true;
        }
        step_columns(self, t, state, (u, y), measured)
    }

    fn update_into(&self, t: T, state: &mut [T], u: &[T], y: &[T], measured: &[bool]) -> bool {
        #[cfg(feature = "alloc")]
        if self.at_run_time((t, u), state, y, Part::Update(measured)) {
            return true;
        }
        update_columns(self, t, state, (u, y), measured)
    }

    fn predict_into(&self, t: T, state: &mut [T], u: &[T]) -> bool {
        #[cfg(feature = "alloc")]
        if self.at_run_time((t, u), state, &[], Part::Prediction) {
            return true;
        }
        predict_columns(self, state, u, |state, u| self.finish(t, state, u))
    }

    fn estimate(&self, state: &Self::State) -> Self::Estimate {
        state.estimate()
    }

    fn estimate_into(&self, state: &[T], estimate: &mut [T]) -> bool {
        // Before the factor.
        state.get(..estimate.len()).is_some_and(|xhat| put_slice(xhat, estimate))
    }

    fn initial(&self, _t: T, estimate: &Self::Estimate, _u: &Self::Input, _y: &Self::Output) -> Self::State {
        SquareRootEstimate::new(estimate, &self.factors.p0)
    }
}

/// The filter of a plant whose sizes are known at run time, at an input that is held.
#[cfg(feature = "alloc")]
struct UnscentedAtRunTime<'f> {
    plant: &'f dyn OnSlices,
    factors: &'f NoiseModel<f64, Dyn, Dyn>,
    sigma: SigmaPoints,
    weights: Weights<f64>,
    h: f64,
    prediction: Prediction,
    gate: Option<f64>,
    turns: &'f Turns<f64, Dyn>,
    state_turns: &'f Turns<f64, Dyn>,
}

#[cfg(feature = "alloc")]
impl UnscentedAtRunTime<'_> {
    /// The filter with its sizes in its type, and these factors.
    fn of_size<N: Dim, P: Dim>(
        &self,
        w: OMatrix<f64, N, N>,
        v: OMatrix<f64, P, P>,
    ) -> UnscentedKalmanFilter<Held<'_, N, P>, f64, N, U0, P>
    where
        DefaultAllocator: Size<N, U0, P>,
    {
        let Self { plant, sigma, weights, h, prediction, gate, turns, state_turns, .. } = *self;
        let (n, p) = (w.shape_generic().0, v.shape_generic().0);
        let factors = NoiseModel { w, v, p0: OMatrix::zeros_generic(n, n) };
        // A prediction has one output, and reads no turn of it.
        let turn = |turns: &DVector<f64>, i: usize| turns.get(i).copied().unwrap_or(0.0);
        let turns = turns.as_ref().map(|turns| OVector::from_fn_generic(p, U1, |i, _| turn(turns, i)));
        let state_turns = state_turns.as_ref().map(|turns| OVector::from_column_slice_generic(n, U1, turns.as_slice()));
        UnscentedKalmanFilter {
            plant: Held { plant, size: (n, p) },
            factors,
            sigma,
            weights,
            h,
            prediction,
            gate,
            turns,
            state_turns,
            inputs: PhantomData,
        }
    }
}

#[cfg(feature = "alloc")]
impl AtRunTime for UnscentedAtRunTime<'_> {
    fn size(&self) -> (usize, usize) {
        (self.factors.w.nrows(), self.factors.v.nrows())
    }

    fn measure<N: DimAdd<U1>, P: Dim>(
        &self,
        (n, p): (N, P),
        t: f64,
        state: &mut GaussianEstimate<f64, N>,
        y: &OVector<f64, P>,
        measured: &[bool],
    ) where
        DefaultAllocator: Size<N, U0, P> + Allocator<N, DimSum<N, U1>>,
    {
        // The factor of W is not read.
        let v = OMatrix::from_column_slice_generic(p, p, self.factors.v.as_slice());
        let mut next = SquareRootEstimate(state.clone());
        let filter = self.of_size(OMatrix::zeros_generic(n, n), v);
        filter.measure(t, &mut next, &OVector::zeros_generic(U0, U1), y, measured);
        *state = next.0;
    }

    fn finish<N: DimAdd<U1>>(&self, n: N, t: f64, state: &mut GaussianEstimate<f64, N>)
    where
        DefaultAllocator: Size<N, U0, U1> + Allocator<N, DimSum<N, U1>>,
    {
        // The factor of V is not read.
        let w = OMatrix::from_column_slice_generic(n, n, self.factors.w.as_slice());
        let mut next = SquareRootEstimate(state.clone());
        let filter = self.of_size(w, OMatrix::zeros_generic(U1, U1));
        filter.finish(t, &mut next, &OVector::zeros_generic(U0, U1));
        *state = next.0;
    }
}

impl<S, T: RealField + Copy, N: DimAdd<U1>, M: Dim, P: Dim> CovarianceFilter<T> for UnscentedKalmanFilter<S, T, N, M, P>
where
    S: Differentiable<T, N, M, P>,
    DefaultAllocator: Size<N, M, P> + Allocator<N, DimSum<N, U1>>,
{
    fn is_discrete(&self) -> bool {
        self.prediction == Prediction::Discrete
    }

    fn covariance_into(&self, state: &Self::State, p: &mut [T]) -> bool {
        put_slice(state.covariance().as_slice(), p)
    }

    fn measure(
        &self,
        t: T,
        state: &mut Self::State,
        u: &Self::Input,
        y: &Self::Output,
        measured: &[bool],
    ) -> Option<T> {
        let measured = |output: usize| measured.get(output).copied().unwrap_or(true);
        self.update_partial(t, state, u, y, measured).map(|innovation| innovation.normalized_square)
    }

    fn measure_with_determinant(
        &self,
        t: T,
        state: &mut Self::State,
        u: &Self::Input,
        y: &Self::Output,
        measured: &[bool],
    ) -> Option<(T, Option<T>)> {
        let measured = |output: usize| measured.get(output).copied().unwrap_or(true);
        self.update_partial(t, state, u, y, measured)
            .map(|innovation| (innovation.normalized_square, Some(innovation.log_determinant())))
    }

    fn innovation(&self, t: T, state: &Self::State, u: &Self::Input, y: &Self::Output) -> Self::Output {
        if !self.fits(state, u) || !self.is_measurement(y) {
            return y.map(|_| convert(f64::NAN));
        }
        let h = |x: &OVector<T, N>| self.plant.output(t, x, u);
        let mut images = Images::of(&state.estimate(), &state.factor(), self.weights.distance, h);
        angles::difference(&self.turns, y, &images.reduce(&self.weights, &self.turns))
    }

    fn advance(&self, t: T, state: &mut Self::State, u: &Self::Input, duration: T) -> bool {
        self.predict(t, state, u, duration)
    }

    fn advance_across(&self, t: T, state: &mut Self::State, u: &Self::Input, duration: T, cross: &mut [T]) -> bool {
        let Some((next, across)) = self.predicted(t, state, u, duration) else { return false };
        *state = next;
        put_slice(across.as_slice(), cross)
    }

    fn rejects_output(&self, t: T, state: &Self::State, u: &Self::Input, y: &Self::Output, output: usize) -> bool {
        self.rejects(t, state, u, y, output)
    }
}
