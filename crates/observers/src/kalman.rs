//! The continuous-discrete extended Kalman filter: plant in continuous time, measurements in samples.
//!
//! `x' = f(x, u) + w`, `y_k = h(x(t_k), u(t_k)) + v_k`, with w white of intensity W (n x n, per unit of time) and v_k
//! of covariance V (p x p). At a sample, with `H = Dh(xhat, u)`:
//!
//! ```text
//! S = H P H' + V,  K = P H' S^-1                                    innovation covariance, gain
//! xhat <- xhat + K (y - h(xhat, u))
//! P    <- (I - K H) P (I - K H)' + K V K'                           Joseph's form
//! ```
//!
//! and until the next one, with `F = Df(xhat)`:
//!
//! ```text
//! xhat' = f(xhat, u),  P <- Phi P Phi' + Q                          with Phi and Q along xhat
//! ```
//!
//! The iterated filter ([`with_iterations`](ExtendedKalmanFilter::with_iterations)) linearises a measurement several
//! times, from `x_0 = xhat` on, with the H, S and K of each x_i:
//!
//! ```text
//! x_(i+1) = xhat + K_i (y - h(x_i, u) - H_i (xhat - x_i))
//! ```
//!
//! These are Gauss-Newton steps of `|x - xhat|^2_(P^-1) + |y - h(x, u)|^2_(V^-1)`, which is least where the posterior
//! density is largest. The last x is the estimate, and P is updated by the last H and K. A fixed number of steps need
//! not converge. Once is the extended Kalman filter; where h is linear in x, once is all.
//!
//! F and H come from the plant ([`Differentiable`]). Joseph's form keeps P positive semidefinite whatever rounding does
//! to K, and P is made exactly symmetric after both stages. Products and factorisation have one order of operations
//! (`dense`), so that the filter gives the same bits with sizes of either kind. How Phi and Q are found, exactly, with
//! control of the error, or in a fixed number of steps, is [`Prediction`]'s.
//!
//! For a linear plant it is the Kalman filter, optimal and convergent when the plant is detectable; for a nonlinear
//! plant there is no proof of convergence from large errors, nor that an iteration makes them smaller.
//!
//! Source: A. Gelb (ed.), Applied Optimal Estimation, MIT Press 1974, table 6.1-1; R. S. Bucy and P. D. Joseph,
//! Filtering for Stochastic Processes, 1968, for the form of the update; B. M. Bell and F. W. Cathey, IEEE Transactions
//! on Automatic Control 38, 1993, for its iteration.

use core::marker::PhantomData;

#[cfg(all(feature = "alloc", target_arch = "wasm32"))]
use luenberger_plants::Column as _;
use luenberger_plants::{Differentiable, Size};
use nalgebra::allocator::Allocator;
use nalgebra::{Const, DefaultAllocator, Dim, DimAdd, DimSum, OMatrix, OVector, RealField, U1, convert, try_convert};
#[cfg(feature = "alloc")]
use nalgebra::{DMatrix, DVector, Dyn, U0};

use crate::angles::{self, Turns};
use crate::covariance_filter::{CovarianceFilter, predict_columns, update_columns};
use crate::dense::{times, times_transpose};
use crate::error::ObserverError;
use crate::gaussian::{correct, covariance, moved, usable};
#[cfg(feature = "alloc")]
use crate::held::{AtInput, AtRunTime, Held, OnSlices, Part, on_numbers, same, sized};
use crate::observer::{ObserverDimensions, SampledObserver, has_rows, put_slice, step_columns};
use crate::transition::{Motion, Prediction, Transition};
use crate::unit_vectors::{self, UnitVectors};

pub use crate::gaussian::{GaussianEstimate, Innovation, NoiseModel};

/// The continuous-discrete extended Kalman filter of a plant `S`; see the [module](self).
///
/// Fields are read through methods, because [`step`](SampledObserver::step) relies on what [`new`](Self::new) has
/// checked.
#[derive(Clone, Debug, PartialEq)]
pub struct ExtendedKalmanFilter<S, T: RealField + Copy, N: Dim, M: Dim, P: Dim>
where
    DefaultAllocator: Size<N, M, P>,
{
    plant: S,
    noises: NoiseModel<T, N, P>,
    h: T,
    prediction: Prediction,
    gate: Option<T>,
    iterations: usize,
    /// Of the outputs.
    turns: Turns<T, P>,
    /// Of the states.
    unit_vectors: UnitVectors<T, N>,
    inputs: PhantomData<M>,
}

/// An extended Kalman filter whose sizes are known at compile time.
pub type StaticExtendedKalmanFilter<S, T, const N: usize, const M: usize, const P: usize> =
    ExtendedKalmanFilter<S, T, Const<N>, Const<M>, Const<P>>;

impl<S, T: RealField + Copy, N: Dim, M: Dim, P: Dim> ExtendedKalmanFilter<S, T, N, M, P>
where
    S: Differentiable<T, N, M, P>,
    DefaultAllocator: Size<N, M, P>,
{
    /// The filter of `plant`, sampled with period `h`, with `substeps` Runge-Kutta steps between samples: for a target.
    /// [`error_controlled`](Self::error_controlled) takes as many as are right.
    ///
    /// A step costs about `4 substeps (n derivatives along a direction) + (12 substeps - 1) 2 n^3` and one Cholesky
    /// factorisation of order p.
    ///
    /// ```
    /// use luenberger_observers::kalman::{ExtendedKalmanFilter, NoiseModel};
    /// use luenberger_observers::SampledObserver;
    /// use luenberger_plants::flexible_joint;
    /// use nalgebra::{Matrix2, Matrix4, Vector1, Vector2, Vector4};
    ///
    /// let noises = NoiseModel { w: Matrix4::identity() * 0.1, v: Matrix2::identity() * 1e-4, p0: Matrix4::identity() };
    /// let filter = ExtendedKalmanFilter::new(flexible_joint::classical(), noises, 0.01, 2)?;
    /// let (u, y) = (Vector1::new(0.0), Vector2::new(1.0, 0.0));
    /// let mut estimate = filter.initial(0.0, &Vector4::zeros(), &u, &y);
    /// filter.step(0.0, &mut estimate, &u, &y);
    /// // The variance of x1 was 1, that of the measurement is 1e-4.
    /// assert!(estimate.covariance()[(0, 0)] < 0.01);
    /// # Ok::<(), luenberger_observers::ObserverError>(())
    /// ```
    /// # Errors
    /// [`ObserverError::Matrix`] for shapes and entries, [`ObserverError::NotSymmetric`],
    /// [`ObserverError::NotDefinite`] when V is not positive definite or W or P(0) not semidefinite,
    /// [`ObserverError::Period`], [`ObserverError::Substeps`].
    pub fn new(plant: S, noises: NoiseModel<T, N, P>, h: T, substeps: usize) -> Result<Self, ObserverError> {
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
        let prediction = Prediction::RungeKutta(substeps);
        let (iterations, inputs) = (1, PhantomData);
        Ok(Self { plant, noises, h, prediction, gate: None, iterations, turns: None, unit_vectors: None, inputs })
    }

    /// The filter of a plant in discrete time, `x+ = f(t, x, u) + w`, whose `derivative` is the next state; W is a
    /// covariance per sample, and between samples `xhat <- f(xhat, u)`, `P <- F P F' + W`.
    ///
    /// # Errors
    /// As [`new`](Self::new).
    pub fn discrete(plant: S, noises: NoiseModel<T, N, P>, h: T) -> Result<Self, ObserverError> {
        Ok(Self { prediction: Prediction::Discrete, ..Self::new(plant, noises, h, 1)? })
    }

    /// The filter of `plant`, sampled with period `h`, whose prediction controls its error: exact for a plant that is
    /// linear between samples, and right for stiff ones. How long a step takes depends on the plant.
    ///
    /// ```
    /// use luenberger_observers::kalman::{ExtendedKalmanFilter, NoiseModel};
    /// use luenberger_observers::SampledObserver;
    /// use nalgebra::{Matrix1, Matrix2, Vector1, Vector2};
    /// // A lag of 1 ms, sampled every second.
    /// let a = Matrix2::new(0.0, 1.0, 0.0, -1000.0);
    /// let plant = luenberger_plants::LinearPlant::new(a, Vector2::new(0.0, 1000.0), nalgebra::RowVector2::new(1.0, 0.0))?;
    /// let noises = NoiseModel { w: Matrix2::identity(), v: Matrix1::new(1.0), p0: Matrix2::identity() };
    /// let filter = ExtendedKalmanFilter::error_controlled(plant, noises, 1.0)?;
    /// let (u, y) = (Vector1::new(1.0), Vector1::new(0.0));
    /// let mut estimate = filter.initial(0.0, &Vector2::zeros(), &u, &y);
    /// filter.step(0.0, &mut estimate, &u, &y);
    /// // The variance of the lag is that at rest, W/2000.
    /// let variance: f64 = estimate.covariance()[(1, 1)];
    /// assert!((variance - 5e-4).abs() < 1e-12);
    /// # Ok::<(), luenberger_observers::ObserverError>(())
    /// ```
    /// # Errors
    /// As [`new`](Self::new).
    #[cfg(feature = "alloc")]
    pub fn error_controlled(plant: S, noises: NoiseModel<T, N, P>, h: T) -> Result<Self, ObserverError> {
        Ok(Self { prediction: Prediction::ErrorControlled, ..Self::new(plant, noises, h, 1)? })
    }

    /// How the filter predicts.
    pub fn prediction(&self) -> Prediction {
        self.prediction
    }

    /// The same filter with another prediction.
    ///
    /// # Errors
    /// [`ObserverError::Substeps`] for none.
    pub fn with_prediction(self, prediction: Prediction) -> Result<Self, ObserverError> {
        if prediction == Prediction::RungeKutta(0) {
            return Err(ObserverError::Substeps);
        }
        Ok(Self { prediction, ..self })
    }

    /// The filter that rejects outliers: an output whose innovation is beyond `gate` standard deviations, by the
    /// covariance that the filter computes, is treated as not measured. 4 or 5 are usual: they reject 6e-5
    /// and 6e-7 of the correct measurements.
    ///
    /// An overconfident filter rejects correct measurements and may never recover: P(0) has to cover the initial error,
    /// and W the model errors.
    ///
    /// Source: Y. Bar-Shalom, X. R. Li and T. Kirubarajan, Estimation with Applications to Tracking and Navigation,
    /// Wiley 2001, section 5.4 (validation of measurements).
    ///
    /// # Errors
    /// [`ObserverError::NotPositive`].
    pub fn with_gate(self, gate: T) -> Result<Self, ObserverError> {
        if gate.is_finite() && gate > T::zero() {
            return Ok(Self { gate: Some(gate), ..self });
        }
        Err(ObserverError::NotPositive { what: "the gate", value: gate.to_subset_unchecked() })
    }

    /// The filter whose updates are linearised so often: the iterated extended Kalman filter; see the [module](self).
    ///
    /// What the [gate](Self::with_gate) rejects at the first linearisation is not measured in the others. One more
    /// costs h with its Jacobian, about `2 n^2 p + 4 n p^2` flops and one Cholesky factorisation of order p.
    ///
    /// ```
    /// use luenberger_observers::kalman::{NoiseModel, StaticExtendedKalmanFilter};
    /// use luenberger_observers::SampledObserver;
    /// use luenberger_plants::plant;
    /// use nalgebra::{Matrix1, SVector, Vector1};
    ///
    /// /// A level at rest, whose square is measured.
    /// struct Level;
    /// plant!(Level, (1, 0, 1), |plant, t, x, u| [x[0]], [x[0] * x[0]]);
    ///
    /// let noises = NoiseModel { w: Matrix1::new(0.0), v: Matrix1::new(1e-4), p0: Matrix1::new(1.0) };
    /// let (u, y) = (SVector::zeros(), Vector1::new(4.0));
    /// let error = |iterations: usize| {
    ///     let filter = StaticExtendedKalmanFilter::<_, f64, 1, 0, 1>::discrete(Level, noises.clone(), 0.1)?;
    ///     let filter = filter.with_iterations(iterations)?;
    ///     let mut estimate = filter.initial(0.0, &Vector1::new(1.0), &u, &y);
    ///     filter.update(0.0, &mut estimate, &u, &y);
    ///     Ok::<f64, luenberger_observers::ObserverError>((estimate.estimate()[0] - 2.0).abs())
    /// };
    /// // Newton's method for the root of 4.
    /// assert!(error(1)? > 0.4 && error(5)? < 1e-4);
    /// # Ok::<(), luenberger_observers::ObserverError>(())
    /// ```
    /// # Errors
    /// [`ObserverError::Table`] for none.
    pub fn with_iterations(self, iterations: usize) -> Result<Self, ObserverError> {
        if iterations == 0 {
            let what = "linearisations of an update";
            return Err(ObserverError::Table { what, expected: 1, found: 0 });
        }
        Ok(Self { iterations, ..self })
    }

    /// How often an update linearises; 1 unless the filter is [iterated](Self::with_iterations).
    pub fn iterations(&self) -> usize {
        self.iterations
    }

    /// The filter of outputs of which some are angles: `turns` has the full turn of each of these in its unit (2 pi or
    /// 360), and 0 for the others. Their innovations are wrapped into half a turn to either side
    /// ([`wrap`](luenberger_plants::wrap())); the estimate is not, and goes on beyond a turn.
    ///
    /// ```
    /// use luenberger_observers::kalman::{NoiseModel, StaticExtendedKalmanFilter};
    /// use luenberger_observers::SampledObserver;
    /// use luenberger_plants::plant;
    /// use nalgebra::{Matrix1, SVector, Vector1};
    ///
    /// /// A heading in degrees, at rest.
    /// struct Heading;
    /// plant!(Heading, (1, 0, 1), |plant, t, x, u| [x[0]], [x[0]]);
    ///
    /// let noises = NoiseModel { w: Matrix1::new(0.0), v: Matrix1::new(1.0), p0: Matrix1::new(1.0) };
    /// let filter = StaticExtendedKalmanFilter::<_, f64, 1, 0, 1>::discrete(Heading, noises, 1.0)?;
    /// let filter = filter.with_angles(Vector1::new(360.0))?;
    /// let (u, y) = (SVector::zeros(), Vector1::new(-179.0));
    /// let mut estimate = filter.initial(0.0, &Vector1::new(179.0), &u, &y);
    /// filter.update(0.0, &mut estimate, &u, &y);
    /// assert_eq!(estimate.estimate()[0], 180.0);
    /// # Ok::<(), luenberger_observers::ObserverError>(())
    /// ```
    /// # Errors
    /// [`ObserverError::Table`] for another length, [`ObserverError::NotPositive`] for a turn that is negative or not
    /// finite.
    pub fn with_angles(self, turns: OVector<T, P>) -> Result<Self, ObserverError> {
        let turns = angles::checked(turns, self.noises.v.nrows())?;
        Ok(Self { turns, ..self })
    }

    /// The full turns of the outputs, if some are [angles](Self::with_angles).
    pub fn turns(&self) -> Option<&OVector<T, P>> {
        self.turns.as_ref()
    }

    /// The filter of states of which some form unit vectors, as a quaternion: the error-state filter. `vectors` has for
    /// each state the number of its unit vector, from 1 on, and 0 for the others.
    ///
    /// After each update and prediction, and at the start, `q <- q/|q|` and `P <- T P T'`, where T is the derivative of
    /// that, `(I - q q')/|q|` for the entries of q: P says nothing of the length of q. For a quaternion that
    /// is the multiplicative filter, whose rotation error has the covariance `4 X' P X`, X the three columns with
    /// which the vector part of a rotation multiplies q. A unit vector that becomes 0 stays as it is.
    ///
    /// ```
    /// use luenberger_observers::kalman::{NoiseModel, StaticExtendedKalmanFilter};
    /// use luenberger_observers::SampledObserver;
    /// use luenberger_plants::plant;
    /// use nalgebra::{Matrix2, Vector1, Vector2, SVector};
    ///
    /// /// Cosine and sine of an angle at rest; the sine is measured.
    /// struct Rest;
    /// plant!(Rest, (2, 0, 1), |plant, t, x, u| [x[0], x[1]], [x[1]]);
    ///
    /// let noises = NoiseModel { w: Matrix2::zeros(), v: Vector1::new(0.01), p0: Matrix2::identity() };
    /// let filter = StaticExtendedKalmanFilter::<_, f64, 2, 0, 1>::discrete(Rest, noises, 1.0)?;
    /// let filter = filter.with_unit_vectors(Vector2::new(1.0, 1.0))?;
    /// let (u, y) = (SVector::zeros(), Vector1::new(0.6));
    /// let mut estimate = filter.initial(0.0, &Vector2::new(1.0, 0.0), &u, &y);
    /// filter.update(0.0, &mut estimate, &u, &y);
    /// let (x, p) = (estimate.estimate(), estimate.covariance());
    /// assert!((x.norm() - 1.0).abs() < 1e-15 && (p * x).norm() < 1e-15);
    /// # Ok::<(), luenberger_observers::ObserverError>(())
    /// ```
    /// # Errors
    /// [`ObserverError::Table`] for another length, [`ObserverError::NotPositive`] for what is no number of a unit
    /// vector (they are 1, 2, ... without a gap).
    ///
    /// Source: F. L. Markley and J. L. Crassidis, Fundamentals of Spacecraft Attitude Determination and Control,
    /// Springer 2014, section 6.2.
    pub fn with_unit_vectors(self, vectors: OVector<T, N>) -> Result<Self, ObserverError> {
        let unit_vectors = unit_vectors::checked(vectors, self.noises.w.nrows())?;
        Ok(Self { unit_vectors, ..self })
    }

    /// The numbers of the [unit vectors](Self::with_unit_vectors) of the states, if there are some.
    pub fn unit_vectors(&self) -> Option<&OVector<T, N>> {
        self.unit_vectors.as_ref()
    }

    /// The filter that predicts, iterates and rejects as another one does, of the same plant over another scalar or in
    /// another form.
    ///
    /// # Errors
    /// [`ObserverError::NotPositive`] for a gate that rounding makes zero.
    pub fn with_options_of<S0, N0: Dim, M0: Dim, P0: Dim>(
        self,
        other: &ExtendedKalmanFilter<S0, f64, N0, M0, P0>,
    ) -> Result<Self, ObserverError>
    where
        DefaultAllocator: Size<N0, M0, P0>,
    {
        let (prediction, iterations) = (other.prediction, other.iterations);
        let mut same = Self { prediction, iterations, ..self };
        if let Some(turns) = &other.turns {
            let outputs = same.noises.v.shape_generic().0;
            let turn = |i: usize| turns.get(i).map_or_else(T::zero, |turn| convert(*turn));
            same = same.with_angles(OVector::from_fn_generic(outputs, U1, |i, _| turn(i)))?;
        }
        if let Some(vectors) = &other.unit_vectors {
            let states = same.noises.w.shape_generic().0;
            let number = |i: usize| vectors.get(i).map_or_else(T::zero, |number| convert(*number));
            same = same.with_unit_vectors(OVector::from_fn_generic(states, U1, |i, _| number(i)))?;
        }
        match other.gate {
            Some(gate) => same.with_gate(convert(gate)),
            None => Ok(Self { gate: None, ..same }),
        }
    }

    /// The same filter with noises that were checked.
    #[cfg(feature = "alloc")]
    pub(crate) fn of_noises(self, noises: NoiseModel<T, N, P>) -> Self {
        Self { noises, ..self }
    }

    /// Whether the gate rejects output `output` of the measurement y (length p) at time t, under the input u (length
    /// m): NaN and infinities always; nothing without a [gate](Self::with_gate), nor for columns of other lengths.
    pub fn rejects(
        &self,
        t: T,
        estimate: &GaussianEstimate<T, N>,
        u: &OVector<T, M>,
        y: &OVector<T, P>,
        output: usize,
    ) -> bool
    where
        N: DimAdd<U1>,
        DefaultAllocator: Allocator<N, DimSum<N, U1>>,
    {
        let Some(gate) = self.gate else { return false };
        if !self.fits(estimate, u) || !self.is_measurement(y) || output >= y.nrows() {
            return false;
        }
        let innovation = y[output] - self.plant.output(t, &estimate.estimate(), u)[output];
        let innovation = angles::entry(&self.turns, output, innovation);
        let variance = self.innovation_covariance(t, estimate, u)[(output, output)];
        !within(gate, innovation, variance)
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

    /// The noise the filter is designed for.
    pub fn noise_model(&self) -> &NoiseModel<T, N, P> {
        &self.noises
    }

    /// The covariance `S = H P H' + V` that the innovation `y - h(xhat, u)` of a sample at time t has for this
    /// estimate and covariance, p x p.
    pub fn innovation_covariance(&self, t: T, estimate: &GaussianEstimate<T, N>, u: &OVector<T, M>) -> OMatrix<T, P, P>
    where
        N: DimAdd<U1>,
        DefaultAllocator: Allocator<N, DimSum<N, U1>>,
    {
        self.spread(&self.plant.output_jacobian(t, &estimate.estimate(), u), estimate)
    }

    /// `H P H' + V`.
    fn spread(&self, h: &OMatrix<T, P, N>, estimate: &GaussianEstimate<T, N>) -> OMatrix<T, P, P>
    where
        N: DimAdd<U1>,
        DefaultAllocator: Allocator<N, DimSum<N, U1>>,
    {
        times_transpose(&times(h, &estimate.covariance()), h) + &self.noises.v
    }

    /// Whether estimate and input have the lengths of the plant.
    fn fits(&self, estimate: &GaussianEstimate<T, N>, u: &OVector<T, M>) -> bool
    where
        N: DimAdd<U1>,
        DefaultAllocator: Allocator<N, DimSum<N, U1>>,
    {
        has_rows::<N>(estimate.order(), || self.noises.w.nrows())
            && has_rows::<M>(u.nrows(), || self.plant.dimensions().inputs)
    }

    fn is_measurement(&self, y: &OVector<T, P>) -> bool {
        has_rows::<P>(y.nrows(), || self.noises.v.nrows())
    }

    /// A step at an input, or its update or prediction alone, of a filter whose sizes are known at run time; false for
    /// other sizes and lengths.
    #[cfg(feature = "alloc")]
    fn at_run_time(&self, (t, u): (T, &[T]), state: &mut [T], y: &[T], part: Part<'_>) -> bool {
        let noises = same::<_, NoiseModel<f64, Dyn, Dyn>>(&self.noises);
        let turns = same::<_, Turns<f64, Dyn>>(&self.turns);
        let unit_vectors = same::<_, UnitVectors<f64, Dyn>>(&self.unit_vectors);
        let (Some(noises), Some(turns), Some(unit_vectors)) = (noises, turns, unit_vectors) else { return false };
        let (Some(gate), Some(h)) = (same(&self.gate), same(&self.h)) else { return false };
        if u.len() != self.plant.dimensions().inputs {
            return false;
        }
        let filter = ExtendedAtRunTime {
            plant: &AtInput::<_, _, (N, M, P)>::new(&self.plant, u),
            noises: (&noises.w, &noises.v),
            gate: *gate,
            iterations: self.iterations,
            turns: turns.as_ref(),
            unit_vectors: unit_vectors.as_ref(),
            h: *h,
            prediction: self.prediction,
        };
        on_numbers((t, y), state, |t, state, y| filter.run(t, state, y, part))
    }

    /// From (xhat, P) at time t over a duration.
    fn transition(
        &self,
        (t, duration): (T, T),
        xhat: &OVector<T, N>,
        p: &OMatrix<T, N, N>,
        u: &OVector<T, M>,
    ) -> Option<Transition<T, N>> {
        let field = |t: T, x: &OVector<T, N>| self.plant.motion(t, x, u);
        let is_linear = self.plant.is_linear_between_samples();
        Motion { field, is_linear, w: &self.noises.w, with_covariance: true }.over(
            self.prediction,
            (t, duration, self.h),
            xhat,
            p,
        )
    }
}

impl<S, T: RealField + Copy, N: DimAdd<U1>, M: Dim, P: Dim> ExtendedKalmanFilter<S, T, N, M, P>
where
    S: Differentiable<T, N, M, P>,
    DefaultAllocator: Size<N, M, P> + Allocator<N, DimSum<N, U1>>,
{
    /// From time t to `t + duration`, the input held: `xhat' = f(xhat, u)`, `P <- Phi P Phi' + Q`. For a plant in
    /// [discrete time](Self::discrete) to the next sample, whatever the duration.
    ///
    /// The duration is nonnegative and need not be the period: predict up to a late sample, or past a missed one. A
    /// fixed number of Runge-Kutta steps is taken for each period or part of one.
    ///
    /// False, with `estimate` unchanged, if there is no result: f or its Jacobian is not finite, as for an input that
    /// is NaN; an overflow; more than [`MOST_STEPS`](crate::transition::MOST_STEPS); columns of other lengths than the
    /// plant's.
    ///
    /// ```
    /// use luenberger_observers::{ExtendedKalmanFilter, NoiseModel, SampledObserver};
    /// use nalgebra::{Matrix1, Matrix2, Vector1, Vector2};
    /// let noises = NoiseModel { w: Matrix2::identity(), v: Matrix1::new(1.0), p0: Matrix2::identity() };
    /// let filter = ExtendedKalmanFilter::new(luenberger_plants::double_integrator(), noises, 0.1, 1)?;
    /// let (u, y) = (Vector1::new(0.0), Vector1::new(1.0));
    /// let mut estimate = filter.initial(0.0, &Vector2::new(0.0, 1.0), &u, &y);
    /// // The first sample comes at 0.13, the time of the next is still 0.2.
    /// assert!(filter.predict(0.0, &mut estimate, &u, 0.13));
    /// assert!((estimate.estimate()[0] - 0.13).abs() < 1e-15);
    /// assert!(filter.update(0.13, &mut estimate, &u, &y).is_some());
    /// assert!(filter.predict(0.13, &mut estimate, &u, 0.07));
    /// # Ok::<(), luenberger_observers::ObserverError>(())
    /// ```
    #[must_use = "without a result the estimate is unchanged"]
    pub fn predict(&self, t: T, estimate: &mut GaussianEstimate<T, N>, u: &OVector<T, M>, duration: T) -> bool {
        if !self.fits(estimate, u) {
            return false;
        }
        let p = estimate.covariance();
        let found = self.transition((t, duration), &estimate.estimate(), &p, u);
        let is_moved = found.is_some_and(|found| moved(estimate, &found.next, &found.spread(&p)));
        if is_moved {
            unit_vectors::normalise(&self.unit_vectors, estimate, None);
        }
        is_moved
    }

    /// [`step`](SampledObserver::step) without the [update](Self::update): the prediction over the period, and NaN
    /// where it has no result. Columns of other lengths change nothing.
    pub fn finish(&self, t: T, state: &mut GaussianEstimate<T, N>, u: &OVector<T, M>) {
        if self.fits(state, u) && !self.predict(t, state, u, self.h) {
            *state = state.lost();
        }
    }

    /// Updates estimate and covariance by the measurement y (length p) at time t under the input u; returns the
    /// innovation.
    ///
    /// `None`, with `estimate` unchanged, if there is no result: no entry of y is finite (one that is not counts as not
    /// measured), nor h or its Jacobian; the innovation covariance S is not positive definite in floating
    /// point; an overflow; columns of other lengths than the plant's.
    pub fn update(
        &self,
        t: T,
        estimate: &mut GaussianEstimate<T, N>,
        u: &OVector<T, M>,
        y: &OVector<T, P>,
    ) -> Option<Innovation<T, P>> {
        self.update_partial(t, estimate, u, y, |_| true)
    }

    /// [`update`](Self::update) with only those outputs for which `measured` is true, for sensors of different rates;
    /// the other entries of y are not read. What the [gate](Self::with_gate) rejects counts as not measured.
    pub fn update_partial(
        &self,
        t: T,
        estimate: &mut GaussianEstimate<T, N>,
        u: &OVector<T, M>,
        y: &OVector<T, P>,
        measured: impl Fn(usize) -> bool,
    ) -> Option<Innovation<T, P>> {
        if !self.fits(estimate, u) || !self.is_measurement(y) {
            return None;
        }
        let usable = usable(y, measured)?;
        let linearised = |x: &OVector<T, N>| {
            let (expected, h) = self.plant.measurement(t, x, u);
            (h, angles::difference(&self.turns, y, &expected))
        };
        let first = linearised(&estimate.estimate());
        let gate = self.gate.map(|gate| (gate, first.1.clone(), self.spread(&first.0, estimate)));
        let is_within = |output| {
            gate.as_ref().is_none_or(|(gate, innovation, s)| within(*gate, innovation[output], s[(output, output)]))
        };
        let accepted = |output| usable[output] && is_within(output);
        let again = (self.iterations, linearised);
        let innovation = correct::<T, N, M, P>(estimate, first, self.noises.v.clone(), accepted, again)?;
        unit_vectors::normalise(&self.unit_vectors, estimate, None);
        Some(innovation)
    }
}

impl<S, T: RealField + Copy, N: DimAdd<U1>, M: Dim, P: Dim> SampledObserver<T> for ExtendedKalmanFilter<S, T, N, M, P>
where
    S: Differentiable<T, N, M, P>,
    DefaultAllocator: Size<N, M, P> + Allocator<N, DimSum<N, U1>>,
{
    type State = GaussianEstimate<T, N>;
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
    /// [`update`](ExtendedKalmanFilter::update) is `None` is passed over as if it were missed. A
    /// [prediction](ExtendedKalmanFilter::predict) without a result, as for an input that is NaN, makes the estimate
    /// NaN. Columns of other lengths change nothing.
    fn step(&self, t: T, state: &mut Self::State, u: &Self::Input, y: &Self::Output) {
        #[cfg(feature = "alloc")]
        if self.at_run_time((t, u.as_slice()), state.as_mut_slice(), y.as_slice(), Part::Step(&[])) {
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
            && self.at_run_time((t, u.as_slice()), state.as_mut_slice(), y.as_slice(), Part::Step(measured))
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
        // Before the covariance.
        state.get(..estimate.len()).is_some_and(|xhat| put_slice(xhat, estimate))
    }

    fn initial(&self, _t: T, estimate: &Self::Estimate, _u: &Self::Input, _y: &Self::Output) -> Self::State {
        let mut start = GaussianEstimate::new(estimate, &self.noises.p0);
        unit_vectors::normalise(&self.unit_vectors, &mut start, None);
        start
    }
}

/// Whether an innovation is within a gate of so many standard deviations; NaN is not.
fn within<T: RealField + Copy>(gate: T, innovation: T, variance: T) -> bool {
    innovation * innovation <= gate * gate * variance
}

/// The filter of a plant whose sizes are known at run time, at an input that is held.
#[cfg(feature = "alloc")]
pub(crate) struct ExtendedAtRunTime<'f> {
    pub(crate) plant: &'f dyn OnSlices,
    /// W and V.
    pub(crate) noises: (&'f DMatrix<f64>, &'f DMatrix<f64>),
    pub(crate) gate: Option<f64>,
    pub(crate) iterations: usize,
    pub(crate) turns: Option<&'f DVector<f64>>,
    pub(crate) unit_vectors: Option<&'f DVector<f64>>,
    pub(crate) h: f64,
    pub(crate) prediction: Prediction,
}

#[cfg(feature = "alloc")]
impl ExtendedAtRunTime<'_> {
    /// The filter with its sizes in its type, and these noises.
    fn of_size<N: Dim, P: Dim>(
        &self,
        w: OMatrix<f64, N, N>,
        v: OMatrix<f64, P, P>,
    ) -> ExtendedKalmanFilter<Held<'_, N, P>, f64, N, U0, P>
    where
        DefaultAllocator: Size<N, U0, P>,
    {
        let Self { plant, gate, iterations, turns, unit_vectors, h, prediction, .. } = *self;
        let (n, p) = (w.shape_generic().0, v.shape_generic().0);
        let noises = NoiseModel { w, v, p0: OMatrix::zeros_generic(n, n) };
        // A prediction has one output, and reads no turn.
        let turn = |turns: &DVector<f64>, i: usize| turns.get(i).copied().unwrap_or(0.0);
        let turns = turns.map(|turns| OVector::from_fn_generic(p, U1, |i, _| turn(turns, i)));
        let unit_vectors = unit_vectors.map(|vectors| OVector::from_column_slice_generic(n, U1, vectors.as_slice()));
        ExtendedKalmanFilter {
            plant: Held { plant, size: (n, p) },
            noises,
            h,
            prediction,
            gate,
            iterations,
            turns,
            unit_vectors,
            inputs: PhantomData,
        }
    }

    /// The way from x with the covariance p at time t over a duration, as of a prediction; none for other sizes, and
    /// false where it has no result.
    pub(crate) fn way(
        &self,
        during: (f64, f64),
        from: (&DVector<f64>, &DMatrix<f64>),
        way: &mut Transition<f64, Dyn>,
    ) -> Option<bool> {
        let mut is_way = None;
        sized!(from.0.nrows(), [1 2 3 4] [5 6 7 8], n => {
            is_way = Some(self.way_of_size(n, during, from, way).is_some());
            true
        });
        is_way
    }

    fn way_of_size<N: Dim>(
        &self,
        n: N,
        during: (f64, f64),
        (x, p): (&DVector<f64>, &DMatrix<f64>),
        way: &mut Transition<f64, Dyn>,
    ) -> Option<()>
    where
        DefaultAllocator: Size<N, U0, U1>,
    {
        let square = |entries: &DMatrix<f64>| OMatrix::from_column_slice_generic(n, n, entries.as_slice());
        let filter = self.of_size(square(self.noises.0), OMatrix::zeros_generic(U1, U1));
        let x = OVector::from_column_slice_generic(n, U1, x.as_slice());
        let found = filter.transition(during, &x, &square(p), &OVector::zeros_generic(U0, U1))?;
        way.next.copy_from_slice(found.next.as_slice());
        way.phi.copy_from_slice(found.phi.as_slice());
        way.noise.copy_from_slice(found.noise.as_slice());
        Some(())
    }

    /// The state after the prediction, by the body for any size.
    #[cfg(target_arch = "wasm32")]
    fn predicted(&self, t: f64, state: &[f64]) -> Option<GaussianEstimate<f64, Dyn>> {
        let mut next = GaussianEstimate::try_from_slice(state)?;
        self.finish(Dyn(self.size().0), t, &mut next);
        Some(next)
    }
}

#[cfg(feature = "alloc")]
impl AtRunTime for ExtendedAtRunTime<'_> {
    fn size(&self) -> (usize, usize) {
        (self.noises.0.nrows(), self.noises.1.nrows())
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
        // W is not read.
        let v = OMatrix::from_column_slice_generic(p, p, self.noises.1.as_slice());
        let filter = self.of_size(OMatrix::zeros_generic(n, n), v);
        filter.measure(t, state, &OVector::zeros_generic(U0, U1), y, measured);
    }

    fn finish<N: DimAdd<U1>>(&self, n: N, t: f64, state: &mut GaussianEstimate<f64, N>)
    where
        DefaultAllocator: Size<N, U0, U1> + Allocator<N, DimSum<N, U1>>,
    {
        // It is most of the filter: a module for web pages, which has to be downloaded, has it for any size alone.
        #[cfg(target_arch = "wasm32")]
        if N::try_to_usize().is_some() {
            let next = self.predicted(t, state.as_slice());
            *state =
                next.and_then(|next| GaussianEstimate::try_from_slice(next.as_slice())).unwrap_or_else(|| state.lost());
            return;
        }
        // V is not read.
        let w = OMatrix::from_column_slice_generic(n, n, self.noises.0.as_slice());
        let filter = self.of_size(w, OMatrix::zeros_generic(U1, U1));
        filter.finish(t, state, &OVector::zeros_generic(U0, U1));
    }
}

impl<S, T: RealField + Copy, N: DimAdd<U1>, M: Dim, P: Dim> CovarianceFilter<T> for ExtendedKalmanFilter<S, T, N, M, P>
where
    S: Differentiable<T, N, M, P>,
    DefaultAllocator: Size<N, M, P> + Allocator<N, DimSum<N, U1>>,
{
    fn is_discrete(&self) -> bool {
        self.prediction == Prediction::Discrete
    }

    fn unit_vector_of(&self, state: usize) -> usize {
        let number = self.unit_vectors.as_ref().and_then(|vectors| vectors.get(state));
        number.and_then(|number| try_convert::<T, f64>(*number)).map_or(0, |number| number as usize)
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
        angles::difference(&self.turns, y, &self.plant.output(t, &state.estimate(), u))
    }

    fn advance(&self, t: T, state: &mut Self::State, u: &Self::Input, duration: T) -> bool {
        self.predict(t, state, u, duration)
    }

    /// P Phi', with the Phi of the prediction.
    fn advance_across(&self, t: T, state: &mut Self::State, u: &Self::Input, duration: T, cross: &mut [T]) -> bool {
        if !self.fits(state, u) {
            return false;
        }
        let p = state.covariance();
        let Some(found) = self.transition((t, duration), &state.estimate(), &p, u) else { return false };
        if !moved(state, &found.next, &found.spread(&p)) {
            return false;
        }
        let mut covariance = times_transpose(&p, &found.phi);
        unit_vectors::normalise(&self.unit_vectors, state, Some(&mut covariance));
        put_slice(covariance.as_slice(), cross)
    }

    fn rejects_output(&self, t: T, state: &Self::State, u: &Self::Input, y: &Self::Output, output: usize) -> bool {
        self.rejects(t, state, u, y, output)
    }
}
