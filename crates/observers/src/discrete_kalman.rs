//! The Kalman filter of a plant in discrete time.
//!
//! `x+ = Ad x + Bd u + w`, `y = C x + D u + v`, with w of covariance W (n x n) and v of covariance V (p x p), both
//! white and *per sample*. At a sample
//!
//! ```text
//! S = C P C' + V,  K = P C' S^-1                                    innovation covariance, gain
//! xhat <- xhat + K (y - C xhat - D u)
//! P    <- (I - K C) P (I - K C)' + K V K'                           Joseph's form
//! ```
//!
//! and to the next one
//!
//! ```text
//! xhat <- Ad xhat + Bd u,  P <- Ad P Ad' + W
//! ```
//!
//! For a detectable plant with controllable (Ad, W^(1/2)) the gain `Ad K` tends to that of
//! `linalg::discrete_kalman_gain`, whatever P(0).
//!
//! Source: B. D. O. Anderson and J. B. Moore, Optimal Filtering, Prentice-Hall 1979, ch. 3; R. S. Bucy and P. D.
//! Joseph, Filtering for Stochastic Processes, 1968, for the form of the update.

use luenberger_plants::{LinearPlant, Size};
#[cfg(feature = "alloc")]
use nalgebra::Dyn;
use nalgebra::allocator::Allocator;
use nalgebra::{Const, DefaultAllocator, Dim, DimAdd, DimSum, OMatrix, OVector, RealField, U1, convert};

use crate::covariance_filter::{CovarianceFilter, update_columns};
#[cfg(feature = "alloc")]
use crate::dense::{entry, with_column};
use crate::dense::{times, times_transpose};
use crate::error::ObserverError;
use crate::feedthrough;
use crate::gaussian::{GaussianEstimate, Innovation, correct, covariance, moved, symmetrise, usable};
#[cfg(feature = "alloc")]
use crate::held::{AtRunTime, OnSlices, Part, copied, on_numbers, same};
#[cfg(feature = "alloc")]
use crate::kalman::ExtendedAtRunTime;
use crate::observer::{ObserverDimensions, SampledObserver, has_rows, put_slice, step_columns};
#[cfg(feature = "alloc")]
use crate::transition::Prediction;

/// The data of a [`KalmanFilter`]: plant, noise, and covariance of the initial error.
#[derive(Clone, Debug, PartialEq)]
pub struct KalmanModel<T: RealField + Copy, N: Dim, M: Dim, P: Dim>
where
    DefaultAllocator: Size<N, M, P>,
{
    /// State matrix of the discretised plant, n x n.
    pub ad: OMatrix<T, N, N>,
    /// Input matrix of the discretised plant, n x m.
    pub bd: OMatrix<T, N, M>,
    /// Output matrix, p x n.
    pub c: OMatrix<T, P, N>,
    /// Covariance W of the process noise of one period, n x n, symmetric positive semidefinite.
    pub w: OMatrix<T, N, N>,
    /// Covariance V of one measurement, p x p, symmetric positive definite.
    pub v: OMatrix<T, P, P>,
    /// Covariance of the error of the initial estimate, n x n, symmetric positive semidefinite.
    pub p0: OMatrix<T, N, N>,
    /// The sampling period.
    pub period: T,
}

/// The Kalman filter of a linear plant in discrete time; see the [module](self).
///
/// The state is the estimate with its covariance *before* the sample. One period is [`update`](Self::update), then
/// [`predict`](Self::predict), which is what [`step`](SampledObserver::step) does. A sample that is missed is a
/// `predict` without an `update`; a slower sensor is a [`partial update`](Self::update_partial) in the periods in which
/// it is silent.
///
/// ```
/// use luenberger_observers::{KalmanFilter, KalmanModel, SampledObserver};
/// use nalgebra::{Matrix1, Matrix2, RowVector2, Vector1, Vector2};
/// // A position measured every 0.1 s, a velocity driven by noise.
/// let filter = KalmanFilter::new(KalmanModel {
///     ad: Matrix2::new(1.0, 0.1, 0.0, 1.0),
///     bd: Vector2::new(0.005, 0.1),
///     c: RowVector2::new(1.0, 0.0),
///     w: Matrix2::new(0.0, 0.0, 0.0, 0.01),
///     v: Matrix1::new(0.04),
///     p0: Matrix2::identity(),
///     period: 0.1,
/// })?;
/// let (u, y) = (Vector1::new(0.0), Vector1::new(1.0));
/// let mut estimate = filter.initial(0.0, &Vector2::zeros(), &u, &y);
/// // Variances: 1 of the estimate, 0.04 of the measurement: K = 1/1.04.
/// let innovation = filter.update(&mut estimate, &u, &y).ok_or("S is not positive definite")?;
/// assert_eq!(innovation.value, Vector1::new(1.0));
/// assert!((estimate.estimate() - Vector2::new(1.0 / 1.04, 0.0)).amax() < 1e-15);
/// // The next sample is missing: the variance grows.
/// let before = estimate.covariance()[(0, 0)];
/// assert!(filter.predict(&mut estimate, &u));
/// assert!(filter.predict(&mut estimate, &u));
/// assert!(estimate.covariance()[(0, 0)] > before);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
///
/// # Missed, slower and late samples
///
/// A measurement that arrives some periods after its sample belongs to the estimate of that sample. Keep a log of the
/// last periods: the estimate before each sample, the input, and the measurements that have arrived. Go back to the
/// sample, take the measurement, and replay the periods since then. The result is that of a filter in which nothing was
/// late, to the last bit; the cost is a step for each period of the delay.
///
/// ```
/// use luenberger_observers::{GaussianEstimate, KalmanFilter, KalmanModel, SampledObserver};
/// use nalgebra::{Const, Matrix2, SVector, Vector1, Vector2};
/// // A position every period, missing in period 5, and a speed every second period.
/// let filter = KalmanFilter::new(KalmanModel {
///     ad: Matrix2::new(1.0, 0.1, 0.0, 1.0),
///     bd: Vector2::new(0.005, 0.1),
///     c: Matrix2::identity(),
///     w: Matrix2::new(0.0, 0.0, 0.0, 0.01),
///     v: Matrix2::new(0.04, 0.0, 0.0, 0.01),
///     p0: Matrix2::identity(),
///     period: 0.1,
/// })?;
/// type Filter = KalmanFilter<f64, Const<2>, Const<1>, Const<2>>;
///
/// /// What is kept of a period: the estimate before its sample, the input from it to the next, the outputs so far.
/// #[derive(Clone)]
/// struct Period {
///     estimate: GaussianEstimate<f64, Const<2>>,
///     u: SVector<f64, 1>,
///     y: [Option<f64>; 2],
/// }
///
/// /// The estimate before the next sample.
/// fn advance(filter: &Filter, period: &Period) -> GaussianEstimate<f64, Const<2>> {
///     let mut estimate = period.estimate.clone();
///     let y = SVector::from(period.y.map(|y| y.unwrap_or(0.0)));
///     // `None` where a measured value is NaN: the estimate is as it was.
///     filter.update_partial(&mut estimate, &period.u, &y, |output| period.y[output].is_some());
///     assert!(filter.predict(&mut estimate, &period.u), "u is finite");
///     estimate
/// }
///
/// /// Output `output` of period `k` arrives: back to its sample, and on again to the present.
/// fn arrives(filter: &Filter, log: &mut [Period], k: usize, output: usize, y: f64) {
///     log[k].y[output] = Some(y);
///     for k in k + 1..log.len() {
///         log[k].estimate = advance(filter, &log[k - 1]);
///     }
/// }
///
/// let (position, speed) = (|k: usize| 0.1 * k as f64, 1.0);
/// let start = filter.initial(0.0, &Vector2::zeros(), &Vector1::new(0.0), &Vector2::zeros());
/// let run = |delay: usize| {
///     let mut log: Vec<Period> = Vec::new();
///     for k in 0..12 {
///         let estimate = log.last().map_or_else(|| start.clone(), |last| advance(&filter, last));
///         log.push(Period { estimate, u: Vector1::new(0.0), y: [None; 2] });
///         // The position of period 5 is missed.
///         if k != 5 {
///             arrives(&filter, &mut log, k, 0, position(k));
///         }
///         // The speed is measured in even periods, and takes `delay` periods to arrive.
///         if k >= delay && (k - delay) % 2 == 0 {
///             arrives(&filter, &mut log, k - delay, 1, speed);
///         }
///     }
///     log[9].estimate.clone()
/// };
/// assert_eq!(run(2), run(0));
/// assert!((run(2).estimate() - Vector2::new(0.9, 1.0)).amax() < 0.05);
/// # Ok::<(), luenberger_observers::ObserverError>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct KalmanFilter<T: RealField + Copy, N: Dim, M: Dim, P: Dim>
where
    DefaultAllocator: Size<N, M, P>,
{
    model: KalmanModel<T, N, M, P>,
    d: Option<OMatrix<T, P, M>>,
}

/// A Kalman filter whose sizes are known at compile time.
pub type StaticKalmanFilter<T, const N: usize, const M: usize, const P: usize> =
    KalmanFilter<T, Const<N>, Const<M>, Const<P>>;

impl<T: RealField + Copy, N: Dim, M: Dim, P: Dim> KalmanFilter<T, N, M, P>
where
    DefaultAllocator: Size<N, M, P>,
{
    /// The filter of this plant and this noise.
    ///
    /// # Errors
    /// [`ObserverError::Matrix`] for shapes and entries, [`ObserverError::NotSymmetric`],
    /// [`ObserverError::NotDefinite`] when V is not positive definite or W or P(0) not semidefinite,
    /// [`ObserverError::Period`].
    pub fn new(model: KalmanModel<T, N, M, P>) -> Result<Self, ObserverError> {
        let KalmanModel { ad, bd, c, w, v, p0, period } = model;
        let LinearPlant { a: ad, b: bd, c, .. } = LinearPlant::new(ad, bd, c)?;
        if !(period.is_finite() && period > T::zero()) {
            return Err(ObserverError::Period { period: period.to_subset_unchecked() });
        }
        let w = covariance("W", w, ad.nrows(), false)?;
        let v = covariance("V", v, c.nrows(), true)?;
        let p0 = covariance("P(0)", p0, ad.nrows(), false)?;
        Ok(Self { model: KalmanModel { ad, bd, c, w, v, p0, period }, d: None })
    }

    /// The same observer of a plant with the feedthrough D, p x m: `y = C x + D u`.
    ///
    /// # Errors
    /// [`ObserverError::Matrix`]: D of another shape, entries that are not finite.
    pub fn with_feedthrough(mut self, d: OMatrix<T, P, M>) -> Result<Self, ObserverError> {
        let (outputs, inputs) = (self.model.c.nrows(), self.model.bd.ncols());
        self.d = Some(feedthrough::checked(d, (outputs, inputs))?);
        Ok(self)
    }

    /// Feedthrough matrix, p x m; `None` where the output does not depend on the input.
    pub fn d(&self) -> Option<&OMatrix<T, P, M>> {
        self.d.as_ref()
    }

    /// The plant and the noise, the covariances exactly symmetric.
    pub fn model(&self) -> &KalmanModel<T, N, M, P> {
        &self.model
    }
}

impl<T: RealField + Copy, N: DimAdd<U1>, M: Dim, P: Dim> KalmanFilter<T, N, M, P>
where
    DefaultAllocator: Size<N, M, P> + Allocator<N, DimSum<N, U1>>,
{
    /// From one sample to the next: `xhat <- Ad xhat + Bd u`, `P <- Ad P Ad' + W`. Costs 4 n^3 flops.
    ///
    /// False, with `estimate` unchanged, if there is no result: an input that is not finite, an overflow, columns of
    /// other lengths than the model's.
    #[must_use = "without a result the estimate is unchanged"]
    pub fn predict(&self, estimate: &mut GaussianEstimate<T, N>, u: &OVector<T, M>) -> bool {
        if !self.fits(estimate, u) {
            return false;
        }
        let KalmanModel { ad, bd, w, .. } = &self.model;
        let xhat = ad * estimate.estimate() + bd * u;
        let mut p = times_transpose(&times(ad, &estimate.covariance()), ad) + w;
        symmetrise(&mut p);
        moved(estimate, &xhat, &p)
    }

    /// [`step`](SampledObserver::step) without the update; columns of other lengths change nothing.
    fn finish(&self, state: &mut GaussianEstimate<T, N>, u: &OVector<T, M>) {
        if self.fits(state, u) && !self.predict(state, u) {
            *state = state.lost();
        }
    }

    /// Whether estimate and input have the lengths of the model.
    fn fits(&self, estimate: &GaussianEstimate<T, N>, u: &OVector<T, M>) -> bool {
        has_rows::<N>(estimate.order(), || self.model.ad.nrows()) && has_rows::<M>(u.nrows(), || self.model.bd.ncols())
    }

    fn is_measurement(&self, y: &OVector<T, P>) -> bool {
        has_rows::<P>(y.nrows(), || self.model.c.nrows())
    }

    /// Updates estimate and covariance by the measurement y (length p) under u; returns the innovation. Without a
    /// [feedthrough](Self::with_feedthrough) the input is not read.
    ///
    /// `None`, with `estimate` unchanged, if there is no result: no entry of y that is finite (one that is not counts
    /// as not measured), an innovation covariance S that is not positive definite in floating point, an overflow,
    /// columns of other lengths than the model's.
    ///
    /// ```
    /// # use luenberger_observers::{KalmanFilter, KalmanModel, SampledObserver};
    /// # use nalgebra::{Matrix1, Vector1};
    /// # let one = Matrix1::new(1.0);
    /// # let model = KalmanModel { ad: one, bd: one, c: one, w: one, v: one, p0: one, period: 1.0 };
    /// # let filter = KalmanFilter::new(model)?;
    /// let (u, lost) = (Vector1::new(0.0), Vector1::new(f64::NAN));
    /// let mut estimate = filter.initial(0.0, &Vector1::new(2.0), &u, &lost);
    /// // The estimate is what it was, and a step is the prediction alone.
    /// assert!(filter.update(&mut estimate, &u, &lost).is_none());
    /// filter.step(0.0, &mut estimate, &u, &lost);
    /// assert_eq!((estimate.estimate()[0], estimate.covariance()[0]), (2.0, 2.0));
    /// # Ok::<(), luenberger_observers::ObserverError>(())
    /// ```
    pub fn update(
        &self,
        estimate: &mut GaussianEstimate<T, N>,
        u: &OVector<T, M>,
        y: &OVector<T, P>,
    ) -> Option<Innovation<T, P>> {
        self.update_partial(estimate, u, y, |_| true)
    }

    /// [`update`](Self::update) with only those outputs for which `measured` is true, for sensors of different rates;
    /// the other entries of y are not read.
    ///
    /// ```
    /// use luenberger_observers::{KalmanFilter, KalmanModel, SampledObserver};
    /// use nalgebra::{Matrix2, SVector, Vector2};
    /// let filter = KalmanFilter::new(KalmanModel {
    ///     ad: Matrix2::identity(),
    ///     bd: nalgebra::SMatrix::<f64, 2, 0>::zeros(),
    ///     c: Matrix2::identity(),
    ///     w: Matrix2::zeros(),
    ///     v: Matrix2::identity() * 3.0,
    ///     p0: Matrix2::identity(),
    ///     period: 1.0,
    /// })?;
    /// let (u, y) = (SVector::zeros(), Vector2::new(2.0, f64::NAN));
    /// let mut estimate = filter.initial(0.0, &Vector2::zeros(), &u, &y);
    /// assert!(filter.update_partial(&mut estimate, &u, &y, |output| output == 0).is_some());
    /// assert_eq!(estimate.estimate(), Vector2::new(0.5, 0.0));
    /// # Ok::<(), luenberger_observers::ObserverError>(())
    /// ```
    pub fn update_partial(
        &self,
        estimate: &mut GaussianEstimate<T, N>,
        u: &OVector<T, M>,
        y: &OVector<T, P>,
        measured: impl Fn(usize) -> bool,
    ) -> Option<Innovation<T, P>> {
        if !self.fits(estimate, u) || !self.is_measurement(y) {
            return None;
        }
        let usable = usable(y, measured)?;
        let KalmanModel { c, v, .. } = &self.model;
        let innovation = feedthrough::without(self.d.as_ref(), u, y - c * estimate.estimate());
        let first = (c.clone(), innovation);
        // The measurement is linear: once is exact.
        correct::<T, N, M, P>(estimate, first.clone(), v.clone(), |i| usable[i], (1, |_| first.clone()))
    }

    /// A step at an input, or its update alone, of a filter whose sizes are known at run time: that of the extended
    /// filter. False for other sizes and lengths, and with a feedthrough, whose sums have another order there.
    #[cfg(feature = "alloc")]
    fn at_run_time(&self, u: &[T], state: &mut [T], y: &[T], part: Part<'_>) -> bool {
        let Some(model) = same::<_, KalmanModel<f64, Dyn, Dyn, Dyn>>(&self.model) else { return false };
        if self.d.is_some() || u.len() != model.bd.ncols() {
            return false;
        }
        with_column(Dyn(u.len()), |input| {
            with_column(Dyn(model.ad.nrows()), |drive| {
                if !copied(u, input) {
                    return false;
                }
                (0..drive.len()).for_each(|i| drive[i] = entry(&model.bd, i, input));
                let filter = ExtendedAtRunTime {
                    plant: &AtDrive { model, drive },
                    noises: (&model.w, &model.v),
                    gate: None,
                    iterations: 1,
                    turns: None,
                    unit_vectors: None,
                    h: model.period,
                    prediction: Prediction::Discrete,
                };
                on_numbers((T::zero(), y), state, |t, state, y| filter.run(t, state, y, part))
            })
        })
    }
}

/// The plant of a filter at an input that is held: `x+ = Ad x + Bd u` with the column Bd u.
#[cfg(feature = "alloc")]
struct AtDrive<'f> {
    model: &'f KalmanModel<f64, Dyn, Dyn, Dyn>,
    drive: &'f [f64],
}

#[cfg(feature = "alloc")]
impl OnSlices for AtDrive<'_> {
    fn derivative(&self, _t: f64, x: &[f64], f: &mut [f64]) -> bool {
        f.iter_mut().zip(self.drive).enumerate().for_each(|(i, (f, drive))| *f = entry(&self.model.ad, i, x) + drive);
        true
    }

    fn output(&self, _t: f64, x: &[f64], h: &mut [f64]) -> bool {
        h.iter_mut().enumerate().for_each(|(i, h)| *h = entry(&self.model.c, i, x));
        true
    }

    fn motion(&self, t: f64, x: &[f64], f: &mut [f64], df: &mut [f64]) -> bool {
        self.derivative(t, x, f) && put_slice(self.model.ad.as_slice(), df)
    }

    fn measurement(&self, t: f64, x: &[f64], h: &mut [f64], dh: &mut [f64]) -> bool {
        self.output(t, x, h) && put_slice(self.model.c.as_slice(), dh)
    }

    fn is_linear_between_samples(&self) -> bool {
        true
    }
}

impl<T: RealField + Copy, N: DimAdd<U1>, M: Dim, P: Dim> SampledObserver<T> for KalmanFilter<T, N, M, P>
where
    DefaultAllocator: Size<N, M, P> + Allocator<N, DimSum<N, U1>>,
{
    type State = GaussianEstimate<T, N>;
    type Input = OVector<T, M>;
    type Output = OVector<T, P>;
    type Estimate = OVector<T, N>;

    fn dimensions(&self) -> ObserverDimensions {
        let (n, m, p) = (self.model.ad.nrows(), self.model.bd.ncols(), self.model.c.nrows());
        ObserverDimensions { state: n * (n + 1), inputs: m, outputs: p, estimate: n }
    }

    fn period(&self) -> T {
        self.model.period
    }

    /// Update and prediction. An output that is NaN or infinite counts as not measured; a sample where
    /// [`update`](KalmanFilter::update) is `None` is passed over as if it were missed. A
    /// [prediction](KalmanFilter::predict) without a result, as for an input that is NaN, makes the estimate NaN.
    /// Columns of other lengths change nothing.
    fn step(&self, _t: T, state: &mut Self::State, u: &Self::Input, y: &Self::Output) {
        #[cfg(feature = "alloc")]
        if self.at_run_time(u.as_slice(), state.as_mut_slice(), y.as_slice(), Part::Step(&[])) {
            return;
        }
        if self.is_measurement(y) {
            self.update(state, u, y);
            self.finish(state, u);
        }
    }

    fn step_partial(&self, _t: T, state: &mut Self::State, u: &Self::Input, y: &Self::Output, measured: &[bool]) {
        #[cfg(feature = "alloc")]
        if !measured.is_empty()
            && self.at_run_time(u.as_slice(), state.as_mut_slice(), y.as_slice(), Part::Step(measured))
        {
            return;
        }
        if self.is_measurement(y) {
            if measured.contains(&true) {
                self.update_partial(state, u, y, |output| measured.get(output).copied().unwrap_or(true));
            }
            self.finish(state, u);
        }
    }

    fn step_into(&self, t: T, state: &mut [T], u: &[T], y: &[T], measured: &[bool]) -> bool {
        #[cfg(feature = "alloc")]
        if self.at_run_time(u, state, y, Part::Step(measured)) {
            return true;
        }
        step_columns(self, t, state, (u, y), measured)
    }

    fn update_into(&self, t: T, state: &mut [T], u: &[T], y: &[T], measured: &[bool]) -> bool {
        #[cfg(feature = "alloc")]
        if self.at_run_time(u, state, y, Part::Update(measured)) {
            return true;
        }
        update_columns(self, t, state, (u, y), measured)
    }

    fn estimate(&self, state: &Self::State) -> Self::Estimate {
        state.estimate()
    }

    fn initial(&self, _t: T, estimate: &Self::Estimate, _u: &Self::Input, _y: &Self::Output) -> Self::State {
        GaussianEstimate::new(estimate, &self.model.p0)
    }
}

impl<T: RealField + Copy, N: DimAdd<U1>, M: Dim, P: Dim> CovarianceFilter<T> for KalmanFilter<T, N, M, P>
where
    DefaultAllocator: Size<N, M, P> + Allocator<N, DimSum<N, U1>>,
{
    fn is_discrete(&self) -> bool {
        true
    }

    fn covariance_into(&self, state: &Self::State, p: &mut [T]) -> bool {
        put_slice(state.covariance().as_slice(), p)
    }

    fn measure(
        &self,
        _t: T,
        state: &mut Self::State,
        u: &Self::Input,
        y: &Self::Output,
        measured: &[bool],
    ) -> Option<T> {
        let measured = |output: usize| measured.get(output).copied().unwrap_or(true);
        self.update_partial(state, u, y, measured).map(|innovation| innovation.normalized_square)
    }

    fn measure_with_determinant(
        &self,
        _t: T,
        state: &mut Self::State,
        u: &Self::Input,
        y: &Self::Output,
        measured: &[bool],
    ) -> Option<(T, Option<T>)> {
        let measured = |output: usize| measured.get(output).copied().unwrap_or(true);
        self.update_partial(state, u, y, measured)
            .map(|innovation| (innovation.normalized_square, Some(innovation.log_determinant())))
    }

    fn innovation(&self, _t: T, state: &Self::State, u: &Self::Input, y: &Self::Output) -> Self::Output {
        if !self.fits(state, u) || !self.is_measurement(y) {
            return y.map(|_| convert(f64::NAN));
        }
        feedthrough::without(self.d.as_ref(), u, y - &self.model.c * state.estimate())
    }

    fn advance(&self, _t: T, state: &mut Self::State, u: &Self::Input, _duration: T) -> bool {
        self.predict(state, u)
    }

    fn advance_across(&self, _t: T, state: &mut Self::State, u: &Self::Input, _duration: T, cross: &mut [T]) -> bool {
        if !self.fits(state, u) {
            return false;
        }
        let across = times_transpose(&state.covariance(), &self.model.ad);
        self.predict(state, u) && put_slice(across.as_slice(), cross)
    }
}
