//! The sampled-data linear observer `xhat+ = Ad xhat + Bd u + Ld (y - C xhat)`: a predictor, one step per sample.
//!
//! Its error obeys `e+ = (Ad - Ld C) e`, whatever the input. With `Ld = Ad K`, K the stationary Kalman gain of the
//! sampled plant, it is the stationary Kalman predictor.

use luenberger_plants::error::check_matrix;
use luenberger_plants::{LinearPlant, Size};
use nalgebra::{Const, DefaultAllocator, Dim, OMatrix, OVector, RealField};

use crate::error::ObserverError;
use crate::feedthrough;
use crate::observer::{ObserverDimensions, SampledObserver};

/// The data of a [`SampledLinearObserver`], each by its name.
#[derive(Clone, Debug, PartialEq)]
pub struct SampledLinearGains<T: RealField + Copy, N: Dim, M: Dim, P: Dim>
where
    DefaultAllocator: Size<N, M, P>,
{
    /// State matrix of the discretised plant, n x n.
    pub ad: OMatrix<T, N, N>,
    /// Input matrix of the discretised plant, n x m.
    pub bd: OMatrix<T, N, M>,
    /// Output matrix, p x n.
    pub c: OMatrix<T, P, N>,
    /// Gain, n x p: `Ad - Ld C` with spectral radius below 1.
    pub ld: OMatrix<T, N, P>,
    /// The sampling period h.
    pub period: T,
}

/// The sampled-data linear observer with N states, M inputs and P outputs.
///
/// ```
/// use luenberger_observers::{SampledLinearGains, SampledLinearObserver, SampledObserver};
/// use nalgebra::{Matrix2, RowVector2, Vector1, Vector2};
/// // The double integrator every 0.1 s, poles of Ad - Ld C at 0.5 and 0.6.
/// let (ad, bd) = (Matrix2::new(1.0, 0.1, 0.0, 1.0), Vector2::new(0.005, 0.1));
/// let gains = SampledLinearGains { ad, bd, c: RowVector2::new(1.0, 0.0), ld: Vector2::new(0.9, 2.0), period: 0.1 };
/// let observer = SampledLinearObserver::new(gains)?;
/// let (mut x, mut xhat, u) = (Vector2::new(1.0, -1.0), Vector2::zeros(), Vector1::new(1.0));
/// for k in 0..50 {
///     observer.step(0.1 * f64::from(k), &mut xhat, &u, &Vector1::new(x[0]));
///     x = ad * x + bd * u;
/// }
/// assert!((x - xhat).norm() < 1e-9);
/// # Ok::<(), luenberger_observers::ObserverError>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct SampledLinearObserver<T: RealField + Copy, N: Dim, M: Dim, P: Dim>
where
    DefaultAllocator: Size<N, M, P>,
{
    gains: SampledLinearGains<T, N, M, P>,
    d: Option<OMatrix<T, P, M>>,
}

/// A sampled-data linear observer whose sizes are known at compile time.
pub type StaticSampledLinearObserver<T, const N: usize, const M: usize, const P: usize> =
    SampledLinearObserver<T, Const<N>, Const<M>, Const<P>>;

impl<T: RealField + Copy, N: Dim, M: Dim, P: Dim> SampledLinearObserver<T, N, M, P>
where
    DefaultAllocator: Size<N, M, P>,
{
    /// The observer with these gains; see [`SampledLinearGains`] for their shapes.
    ///
    /// # Errors
    /// [`ObserverError::Matrix`] for shapes and entries, [`ObserverError::Period`].
    pub fn new(gains: SampledLinearGains<T, N, M, P>) -> Result<Self, ObserverError> {
        let SampledLinearGains { ad, bd, c, ld, period } = gains;
        let LinearPlant { a: ad, b: bd, c, .. } = LinearPlant::new(ad, bd, c)?;
        check_matrix("Ld", &ld, (ad.nrows(), c.nrows()))?;
        if !(period.is_finite() && period > T::zero()) {
            return Err(ObserverError::Period { period: period.to_subset_unchecked() });
        }
        Ok(Self { gains: SampledLinearGains { ad, bd, c, ld, period }, d: None })
    }

    /// The same observer of a plant with the feedthrough D, p x m: `y = C x + D u`.
    ///
    /// # Errors
    /// [`ObserverError::Matrix`]: D of another shape, entries that are not finite.
    pub fn with_feedthrough(mut self, d: OMatrix<T, P, M>) -> Result<Self, ObserverError> {
        let (outputs, inputs) = (self.gains.c.nrows(), self.gains.bd.ncols());
        self.d = Some(feedthrough::checked(d, (outputs, inputs))?);
        Ok(self)
    }

    /// The gains.
    pub fn gains(&self) -> &SampledLinearGains<T, N, M, P> {
        &self.gains
    }

    /// Feedthrough matrix, p x m; `None` where the output does not depend on the input.
    pub fn d(&self) -> Option<&OMatrix<T, P, M>> {
        self.d.as_ref()
    }
}

impl<T: RealField + Copy, N: Dim, M: Dim, P: Dim> SampledObserver<T> for SampledLinearObserver<T, N, M, P>
where
    DefaultAllocator: Size<N, M, P>,
{
    type State = OVector<T, N>;
    type Input = OVector<T, M>;
    type Output = OVector<T, P>;
    type Estimate = OVector<T, N>;

    fn dimensions(&self) -> ObserverDimensions {
        let SampledLinearGains { ad, bd, c, .. } = &self.gains;
        ObserverDimensions { state: ad.nrows(), inputs: bd.ncols(), outputs: c.nrows(), estimate: ad.nrows() }
    }

    fn period(&self) -> T {
        self.gains.period
    }

    fn step(&self, _t: T, xhat: &mut Self::State, u: &Self::Input, y: &Self::Output) {
        let SampledLinearGains { ad, bd, c, ld, .. } = &self.gains;
        let innovation = feedthrough::without(self.d.as_ref(), u, y - c * &*xhat);
        *xhat = ad * &*xhat + bd * u + ld * innovation;
    }

    fn estimate(&self, xhat: &Self::State) -> Self::Estimate {
        xhat.clone()
    }

    fn initial(&self, _t: T, estimate: &Self::Estimate, _u: &Self::Input, _y: &Self::Output) -> Self::State {
        estimate.clone()
    }
}
