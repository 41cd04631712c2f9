//! Sigma points and their weights, after Van der Merwe.
//!
//! Of an estimate xhat with the covariance `S S'` these are xhat and `xhat +- gamma s_k`, with the columns s_k of S,
//!
//! ```text
//! c = alpha^2 (n + kappa),  gamma = sqrt(c),  w = 1/(2 c)                      weight of the outer points
//! w0 = 1 - n/c  in the mean,  w0 + 1 - alpha^2 + beta  in the covariance       weights of the centre
//! ```
//!
//! The images y0, y_k+, y_k- have the mean `y0 + w sum (y_k+ + y_k- - 2 y0)`, which is the weighted mean without the
//! cancellation of large weights. The pairs enter the covariance by their half differences and sums,
//! `(y_k+ - y_k-)/(2 gamma)` and `(y_k+ + y_k- - 2 mean)/(2 gamma)`: of a linear map the first are `A s_k` and the
//! second are 0.
//!
//! Source: R. van der Merwe, Sigma-Point Kalman Filters for Probabilistic Inference in Dynamic State-Space Models,
//! dissertation, Oregon Health & Science University 2004, chapter 3.

use luenberger_plants::wrap;
use nalgebra::allocator::Allocator;
use nalgebra::{ComplexField, DefaultAllocator, Dim, OMatrix, OVector, RealField, convert};

use crate::angles::Turns;
use crate::error::ObserverError;

/// The parameters of the sigma points.
///
/// The default is `alpha = 1`, `beta = 2`, `kappa = 0`: no weight is negative and nothing cancels, so that f32
/// suffices. beta = 2 makes the variance of a quadratic function of one Gaussian variable exact for every alpha. A
/// small alpha keeps the points close to the estimate, for functions that are defined near it only; the usual `1e-3`
/// costs
/// `-2 log10(alpha)`, that is 6 of the 16 digits, and in f32 all of them.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SigmaPoints {
    /// How far the points are from the estimate, positive.
    pub alpha: f64,
    /// Prior knowledge of the distribution: 2 for a Gaussian.
    pub beta: f64,
    /// A second parameter of the distance, above -n; `n + kappa = 3` matches the fourth moment of a Gaussian with alpha
    /// = 1.
    pub kappa: f64,
}

impl Default for SigmaPoints {
    fn default() -> Self {
        Self { alpha: 1.0, beta: 2.0, kappa: 0.0 }
    }
}

/// The numbers that a step needs, in the format of the target.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Weights<T> {
    /// gamma, the distance of the points in standard deviations.
    pub distance: T,
    /// w, the weight of an outer point in the mean.
    pub outer: T,
    /// `1/(2 gamma)`.
    pub half: T,
    /// The root of the magnitude of the centre's weight in the covariance.
    pub centre: T,
    /// Whether that weight is negative.
    pub is_negative: bool,
}

impl SigmaPoints {
    /// The weights for so many states.
    ///
    /// # Errors
    /// [`ObserverError::NotPositive`] unless alpha and `n + kappa` are positive numbers, [`ObserverError::NotFinite`]
    /// for beta.
    pub fn weights<T: RealField + Copy>(&self, states: usize) -> Result<Weights<T>, ObserverError> {
        let Self { alpha, beta, kappa } = *self;
        let count = states as f64 + kappa;
        let scale = alpha * alpha * count;
        for (what, value) in [("alpha", alpha), ("n + kappa", count), ("alpha^2 (n + kappa)", scale)] {
            if !(value.is_finite() && value > 0.0) {
                return Err(ObserverError::NotPositive { what, value });
            }
        }
        let centre = 1.0 - states as f64 / scale + (1.0 - alpha * alpha + beta);
        if !centre.is_finite() {
            return Err(ObserverError::NotFinite { what: "beta", value: beta });
        }
        // In f64, so that roots and quotients are rounded once for every format.
        let distance = ComplexField::sqrt(scale);
        let magnitude = ComplexField::sqrt(ComplexField::abs(centre));
        Ok(Weights {
            distance: convert(distance),
            outer: convert(0.5 / scale),
            half: convert(0.5 / distance),
            centre: convert(magnitude),
            is_negative: centre < 0.0,
        })
    }
}

/// The images of the sigma points under a map with values in R.
pub(crate) struct Images<T: RealField + Copy, R: Dim, N: Dim>
where
    DefaultAllocator: Allocator<R> + Allocator<R, N>,
{
    /// Of the estimate; then its difference to the mean, times the root of its weight.
    pub(crate) centre: OVector<T, R>,
    /// Of the points `xhat + gamma s_k`; then half differences.
    pub(crate) plus: OMatrix<T, R, N>,
    /// Of the points `xhat - gamma s_k`; then half sums, without the mean.
    pub(crate) minus: OMatrix<T, R, N>,
}

impl<T: RealField + Copy, R: Dim, N: Dim> Images<T, R, N>
where
    DefaultAllocator: Allocator<R> + Allocator<N> + Allocator<R, N> + Allocator<N, N>,
{
    /// The images under `map`.
    pub(crate) fn of(
        xhat: &OVector<T, N>,
        s: &OMatrix<T, N, N>,
        distance: T,
        map: impl Fn(&OVector<T, N>) -> OVector<T, R>,
    ) -> Self {
        let centre = map(xhat);
        let order = xhat.shape_generic().0;
        let mut plus = OMatrix::zeros_generic(centre.shape_generic().0, order);
        let mut minus = plus.clone();
        for k in 0..xhat.nrows() {
            let (mut above, mut below) = (xhat.clone(), xhat.clone());
            // The columns of S begin at the diagonal.
            for i in k..xhat.nrows() {
                let step = distance * s[(i, k)];
                above[i] = xhat[i] + step;
                below[i] = xhat[i] - step;
            }
            plus.set_column(k, &map(&above));
            minus.set_column(k, &map(&below));
        }
        Self { centre, plus, minus }
    }

    /// The mean; what is left are the columns of the covariance. Of angles, the images are taken on the branch of the
    /// centre's first: each is less than half a turn from it.
    pub(crate) fn reduce(&mut self, weights: &Weights<T>, turns: &Turns<T, R>) -> OVector<T, R> {
        let two = T::one() + T::one();
        let mut mean = self.centre.clone();
        for i in 0..mean.nrows() {
            if let Some(turn) = turns.as_ref().map(|turns| turns[i]).filter(|turn| *turn > T::zero()) {
                let first = self.centre[i];
                for k in 0..self.plus.ncols() {
                    self.plus[(i, k)] = first + wrap(self.plus[(i, k)] - first, turn);
                    self.minus[(i, k)] = first + wrap(self.minus[(i, k)] - first, turn);
                }
            }
            let double = two * self.centre[i];
            let mut sum = T::zero();
            for k in 0..self.plus.ncols() {
                sum += (self.plus[(i, k)] + self.minus[(i, k)]) - double;
            }
            mean[i] = self.centre[i] + weights.outer * sum;
            let double = two * mean[i];
            for k in 0..self.plus.ncols() {
                let (above, below) = (self.plus[(i, k)], self.minus[(i, k)]);
                self.plus[(i, k)] = weights.half * (above - below);
                self.minus[(i, k)] = weights.half * ((above + below) - double);
            }
            self.centre[i] = weights.centre * (self.centre[i] - mean[i]);
        }
        mean
    }
}
