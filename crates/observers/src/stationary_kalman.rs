//! The stationary Kalman filter of a plant in discrete time, in filter form: the estimate at a sample uses the
//! measurement of that sample.
//!
//! ```text
//! xhat(k|k)   = xhat(k|k-1) + K (y(k) - C xhat(k|k-1) - D u(k))
//! xhat(k+1|k) = A xhat(k|k-1) + B u(k) + L (y(k) - C xhat(k|k-1) - D u(k)),   L = A K
//! ```
//!
//! The state is the prediction `xhat(k|k-1)` and moves as that of the predictor [`DiscreteLinearObserver`]: what is
//! proved of the predictor is proved of it. The error of the estimate is `(I - K C) e(k) - K v(k)` for the prediction
//! error e and the measurement noise v.
//!
//! Source: B. D. O. Anderson and J. B. Moore, Optimal Filtering, Prentice-Hall 1979, section 4.1.

use luenberger_plants::Size;
use luenberger_plants::error::check_matrix;
use nalgebra::{Const, DefaultAllocator, Dim, OMatrix, OVector, RealField};

use crate::dense::entry;
use crate::discrete_linear::{DiscreteLinearObserver, predict};
use crate::error::ObserverError;
use crate::feedthrough;
use crate::observer::{ObserverDimensions, SampledObserver, state_is_estimate};
use crate::partial::{of_measured_or, only};

/// The stationary Kalman filter in filter form; see the [module](self).
///
/// Fields are read through methods, because the constructor has checked them.
#[derive(Clone, Debug, PartialEq)]
pub struct StationaryKalmanFilter<T: RealField + Copy, N: Dim, M: Dim, P: Dim>
where
    DefaultAllocator: Size<N, M, P>,
{
    predictor: DiscreteLinearObserver<T, N, M, P>,
    k: OMatrix<T, N, P>,
}

/// A stationary Kalman filter whose sizes are known at compile time.
pub type StaticStationaryKalmanFilter<T, const N: usize, const M: usize, const P: usize> =
    StationaryKalmanFilter<T, Const<N>, Const<M>, Const<P>>;

impl<T: RealField + Copy, N: Dim, M: Dim, P: Dim> StationaryKalmanFilter<T, N, M, P>
where
    DefaultAllocator: Size<N, M, P>,
{
    /// The filter with the gain K (n x p) of the measurement update. The gain of the predictor is `L = A K`, which is
    /// not checked.
    ///
    /// ```
    /// use luenberger_observers::{DiscreteLinearObserver, SampledObserver, StationaryKalmanFilter};
    /// use luenberger_plants::StaticPlant;
    /// use nalgebra::{Matrix1, Vector1};
    /// // x+ = x/2 + u, y = x, K = 1/2: the mean of prediction and measurement.
    /// let plant = StaticPlant::new(Matrix1::new(0.5), Matrix1::new(1.0), Matrix1::new(1.0))?;
    /// let predictor = DiscreteLinearObserver::new(plant, Matrix1::new(0.25), 1.0)?;
    /// let filter = StationaryKalmanFilter::new(predictor, Matrix1::new(0.5))?;
    /// let (u, y) = (Vector1::new(0.0), Vector1::new(4.0));
    /// let mut prediction = Vector1::new(2.0);
    /// assert_eq!(filter.estimate_at(&prediction, &u, &y), Vector1::new(3.0));
    /// filter.step(0.0, &mut prediction, &u, &y);
    /// assert_eq!(prediction, Vector1::new(1.5));
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    /// # Errors
    /// [`ObserverError::Matrix`]: a shape that does not fit, entries that are not finite.
    pub fn new(predictor: DiscreteLinearObserver<T, N, M, P>, k: OMatrix<T, N, P>) -> Result<Self, ObserverError> {
        check_matrix("K", &k, predictor.l().shape())?;
        Ok(Self { predictor, k })
    }

    /// The predictor.
    pub fn predictor(&self) -> &DiscreteLinearObserver<T, N, M, P> {
        &self.predictor
    }

    /// The gain K of the measurement update, n x p.
    pub fn k(&self) -> &OMatrix<T, N, P> {
        &self.k
    }

    /// The innovation `y - C xhat(k|k-1) - D u` of a sample; 0 of an output that is not finite, which counts as not
    /// measured.
    pub fn innovation(&self, prediction: &OVector<T, N>, u: &OVector<T, M>, y: &OVector<T, P>) -> OVector<T, P> {
        self.joined_innovation(&y.map(|_| T::zero()), prediction, u, y)
    }

    /// The innovation of a sample whose outputs arrive at different times: that of the outputs of `y` that are finite,
    /// and of the others what `before` has, the innovation of those that arrived before.
    pub fn joined_innovation(
        &self,
        before: &OVector<T, P>,
        prediction: &OVector<T, N>,
        u: &OVector<T, M>,
        y: &OVector<T, P>,
    ) -> OVector<T, P> {
        let plant = self.predictor.plant();
        let mut found = y.clone();
        let columns = (prediction.as_slice(), u.as_slice(), y.as_slice());
        feedthrough::innovation(&plant.c, plant.d.as_ref(), columns, found.as_mut_slice());
        found.zip_zip_apply(y, before, |found, y, before| *found = of_measured_or(y, *found, before));
        found
    }

    /// The update of a step, apart from its prediction: `xhat(k|k) = xhat(k|k-1) + K z` for the innovation z.
    ///
    /// Measurements of one sample that arrive at different times have their innovations in [one
    /// column](Self::joined_innovation), with 0 for those that have not arrived. `estimate_at` and `step` are
    /// innovation, update and [`predict`](Self::predict), with the same bits.
    pub fn update(&self, prediction: &OVector<T, N>, innovation: &OVector<T, P>) -> OVector<T, N> {
        let mut estimate = prediction.clone();
        for (i, entry_of_estimate) in estimate.iter_mut().enumerate() {
            *entry_of_estimate += entry(&self.k, i, innovation.as_slice());
        }
        estimate
    }

    /// The prediction of a step, apart from its update: `xhat(k+1|k) = A xhat(k|k-1) + B u(k) + L z` for the innovation
    /// z of the sample, in place.
    pub fn predict(&self, prediction: &mut OVector<T, N>, u: &OVector<T, M>, innovation: &OVector<T, P>) {
        let plant = self.predictor.plant();
        let before = prediction.clone();
        predict(
            (&plant.a, &plant.b, self.predictor.l()),
            (before.as_slice(), u.as_slice(), innovation.as_slice()),
            prediction.as_mut_slice(),
        );
    }
}

impl<T: RealField + Copy, N: Dim, M: Dim, P: Dim> SampledObserver<T> for StationaryKalmanFilter<T, N, M, P>
where
    DefaultAllocator: Size<N, M, P>,
{
    state_is_estimate! { SampledObserver }

    fn dimensions(&self) -> ObserverDimensions {
        self.predictor.dimensions()
    }

    fn period(&self) -> T {
        self.predictor.period()
    }

    fn step(&self, t: T, state: &mut Self::State, u: &Self::Input, y: &Self::Output) {
        self.predictor.step(t, state, u, y);
    }

    crate::partial::step_of_measured! {}

    fn estimate_at(&self, state: &Self::State, u: &Self::Input, y: &Self::Output) -> Self::Estimate {
        self.update(state, &self.innovation(state, u, y))
    }

    fn estimate_at_partial(
        &self,
        state: &Self::State,
        u: &Self::Input,
        y: &Self::Output,
        measured: &[bool],
    ) -> Self::Estimate {
        self.estimate_at(state, u, &only(y, measured))
    }

    fn is_filter(&self) -> bool {
        true
    }
}
