//! The bootstrap particle filter, for errors that are not Gaussian: several peaks, sharp ends, strong curvature.
//!
//! N particles x_i with weights w_i stand for the distribution of the state of
//!
//! ```text
//! x' = f(t, x, u) + w,   y = h(t, x, u) + v   at samples      (in discrete time x+ = f(t, x, u) + w)
//! ```
//!
//! with w white of intensity W (in discrete time of covariance W) and v of covariance V, both Gaussian:
//!
//! ```text
//! update      w_i <- w_i exp(-(y - h(x_i))' V^-1 (y - h(x_i))/2), then divided by their sum
//! estimate    xhat = sum w_i x_i,   P = sum w_i (x_i - xhat)(x_i - xhat)'
//! resampling  where 1/sum w_i^2 < N/2: systematic, N particles in proportion to the weights, then w_i = 1/N
//! prediction  x_i <- F(x_i) + G n_i
//! ```
//!
//! with F the plant over the time that passes, n_i standard normal, and `G G'` the covariance of the noise on the way
//! at the estimate, as the extended filter has it. The outputs are the weighted means of many runs of the plant: the
//! error that the number of particles leaves falls as `1/sqrt(N)`, and what N is enough grows fast with the number of
//! states and the information in a measurement. Nothing is proved here of a finite N.
//!
//! Random numbers are asked for by their place ([`ParticleNoise`]): a state that was stored goes on with the same ones.
//!
//! Sources: N. J. Gordon, D. J. Salmond and A. F. M. Smith, Novel approach to nonlinear/non-Gaussian Bayesian state
//! estimation, IEE Proceedings F 140, 1993; systematic resampling: G. Kitagawa, Monte Carlo filter and smoother for
//! non-Gaussian nonlinear state space models, Journal of Computational and Graphical Statistics 5, 1996; the threshold
//! of the effective number: J. S. Liu and R. Chen, Journal of the American Statistical Association 90, 1995.

extern crate alloc;

use alloc::vec;
use alloc::vec::Vec;

use luenberger_plants::Differentiable;
use nalgebra::{ComplexField, DMatrix, DVector, Dyn};

use crate::covariance_filter::{CovarianceFilter, update_and_finish};
use crate::dense::{Factor, are_finite};
use crate::error::ObserverError;
use crate::gaussian::{NoiseModel, covariance, symmetrise, usable};
use crate::observer::{ObserverDimensions, SampledObserver, put_slice};
use crate::transition::{Motion, Prediction};
use crate::triangular::semidefinite_factor;

/// The share of the particles below which their effective number leads to resampling.
pub const RESAMPLED_BELOW: f64 = 0.5;

/// The random numbers of a particle filter, by their place.
pub trait ParticleNoise {
    /// Puts independent standard normal numbers: those of prediction number k, from 1; for k = 0 of the first
    /// particles.
    fn normals(&self, k: u64, numbers: &mut [f64]);

    /// A number between 0 and 1, uniformly distributed: that of a resampling after k predictions.
    fn uniform(&self, k: u64) -> f64;
}

/// A bootstrap particle filter; see the [module](self).
///
/// Its state is the estimate (n), its covariance (n x n by columns), the number of predictions, the particles one after
/// the other, and the logarithms of their weights.
#[derive(Clone, Debug)]
pub struct ParticleFilter<S, R> {
    plant: S,
    w: DMatrix<f64>,
    v: DMatrix<f64>,
    p0: DMatrix<f64>,
    h: f64,
    prediction: Prediction,
    count: usize,
    random: R,
}

/// A state, taken apart.
#[derive(Clone)]
struct Cloud {
    xhat: DVector<f64>,
    p: DMatrix<f64>,
    predictions: f64,
    particles: Vec<DVector<f64>>,
    /// The logarithms of the weights, which sum to one.
    weights: Vec<f64>,
}

impl Cloud {
    /// Estimate and covariance of the particles.
    fn summarise(&mut self) {
        let n = self.xhat.len();
        let weights: Vec<f64> = self.weights.iter().map(|weight| ComplexField::exp(*weight)).collect();
        let all = || self.particles.iter().zip(&weights);
        let xhat = all().fold(DVector::zeros(n), |mean, (x, weight)| mean + x * *weight);
        let mut p = all().fold(DMatrix::zeros(n, n), |p, (x, weight)| {
            let away = x - &xhat;
            p + &away * away.transpose() * *weight
        });
        symmetrise(&mut p);
        (self.xhat, self.p) = (xhat, p);
    }

    /// Makes the weights sum to one; false if all are zero.
    fn normalise(&mut self) -> bool {
        let largest = self.weights.iter().copied().fold(f64::NEG_INFINITY, f64::max);
        if !largest.is_finite() {
            return false;
        }
        let sum: f64 = self.weights.iter().map(|weight| ComplexField::exp(weight - largest)).sum();
        let all = largest + ComplexField::ln(sum);
        for weight in &mut self.weights {
            *weight -= all;
        }
        true
    }

    /// `1/sum w_i^2`.
    fn effective(&self) -> f64 {
        self.weights.iter().map(|weight| ComplexField::exp(2.0 * weight)).sum::<f64>().recip()
    }

    /// As many particles in proportion to their weights: those at `(i + uniform)/N` of the running sum.
    fn resample(&mut self, uniform: f64) {
        let count = self.particles.len();
        let mut next = Vec::with_capacity(count);
        let (mut chosen, mut sum) = (0, ComplexField::exp(self.weights[0]));
        for i in 0..count {
            let at = (i as f64 + uniform) / count as f64;
            while sum < at && chosen + 1 < count {
                chosen += 1;
                sum += ComplexField::exp(self.weights[chosen]);
            }
            next.push(self.particles[chosen].clone());
        }
        self.particles = next;
        self.weights.fill(-ComplexField::ln(count as f64));
    }
}

/// The particles after a prediction; none where it has no result.
type Images = Vec<Option<DVector<f64>>>;

/// What an update by some outputs needs: which, with y, h of each particle, and the factor of their V.
struct Measured {
    rows: Vec<usize>,
    /// Not finite where h is not.
    expected: Vec<DVector<f64>>,
    factor: Factor<f64, Dyn>,
    v: DMatrix<f64>,
}

impl<S: Differentiable<f64, Dyn, Dyn, Dyn>, R: ParticleNoise> ParticleFilter<S, R> {
    /// The filter with so many particles for a plant in continuous time, with intensity W of the process noise,
    /// covariance V of the measurement noise, sampling period h and this [prediction](Prediction); in discrete time W
    /// is the covariance per sample. The first particles have the covariance P(0) around the first estimate.
    ///
    /// # Errors
    /// [`ObserverError`] for matrices of other shapes than the plant's, or that are no covariances (V has to be
    /// positive definite); for a period that is not positive, no steps, and fewer than two particles.
    pub fn new(
        plant: S,
        noises: NoiseModel<f64, Dyn, Dyn>,
        (h, prediction): (f64, Prediction),
        count: usize,
        random: R,
    ) -> Result<Self, ObserverError> {
        let size = plant.dimensions();
        let NoiseModel { w, v, p0 } = noises;
        let w = covariance("W", w, size.states, false)?;
        let v = covariance("V", v, size.outputs, true)?;
        let p0 = covariance("P(0)", p0, size.states, false)?;
        if !(h.is_finite() && h > 0.0) {
            return Err(ObserverError::Period { period: h });
        }
        if prediction == Prediction::RungeKutta(0) {
            return Err(ObserverError::Substeps);
        }
        if count < 2 {
            return Err(ObserverError::TooFew { what: "particles", least: 2, found: count });
        }
        Ok(Self { plant, w, v, p0, h, prediction, count, random })
    }

    /// Number of particles.
    pub fn count(&self) -> usize {
        self.count
    }

    /// `1/sum w_i^2` of a state, from 1 to the number of particles; none for another length.
    pub fn effective_number(&self, state: &DVector<f64>) -> Option<f64> {
        self.apart(state).map(|cloud| cloud.effective())
    }

    fn order(&self) -> usize {
        self.w.nrows()
    }

    /// Where the particles begin.
    fn head(&self) -> usize {
        self.order() * (self.order() + 1) + 1
    }

    fn length(&self) -> usize {
        self.head() + self.count * (self.order() + 1)
    }

    fn apart(&self, state: &DVector<f64>) -> Option<Cloud> {
        let (n, head) = (self.order(), self.head());
        if state.len() != self.length() {
            return None;
        }
        let entries = state.as_slice();
        let (particles, weights) = entries[head..].split_at(self.count * n);
        Some(Cloud {
            xhat: DVector::from_column_slice(&entries[..n]),
            p: DMatrix::from_column_slice(n, n, &entries[n..head - 1]),
            predictions: entries[head - 1],
            particles: particles.chunks_exact(n).map(DVector::from_column_slice).collect(),
            weights: weights.to_vec(),
        })
    }

    fn joined(cloud: &Cloud) -> DVector<f64> {
        let mut entries = cloud.xhat.as_slice().to_vec();
        entries.extend_from_slice(cloud.p.as_slice());
        entries.push(cloud.predictions);
        for x in &cloud.particles {
            entries.extend_from_slice(x.as_slice());
        }
        entries.extend_from_slice(&cloud.weights);
        DVector::from_vec(entries)
    }

    fn fits(&self, u: &DVector<f64>) -> bool {
        u.len() == self.plant.dimensions().inputs
    }

    fn is_measurement(&self, y: &DVector<f64>) -> bool {
        y.len() == self.v.nrows()
    }

    fn measured(&self, t: f64, cloud: &Cloud, u: &DVector<f64>, used: impl Fn(usize) -> bool) -> Option<Measured> {
        let rows: Vec<usize> = (0..self.v.nrows()).filter(|&row| used(row)).collect();
        let v = DMatrix::from_fn(rows.len(), rows.len(), |i, j| self.v[(rows[i], rows[j])]);
        let expected = |x: &DVector<f64>| {
            let h = self.plant.output(t, x, u);
            DVector::from_fn(rows.len(), |i, _| h[rows[i]])
        };
        let expected = cloud.particles.iter().map(expected).collect();
        Some(Measured { factor: Factor::new(&v)?, expected, v, rows })
    }

    /// The mean of h over the particles at which it is finite, and the covariance of the innovation.
    fn predicted(cloud: &Cloud, measured: &Measured) -> (DVector<f64>, DMatrix<f64>) {
        let p = measured.rows.len();
        let finite = || {
            let all = measured.expected.iter().zip(&cloud.weights);
            all.filter(|(h, _)| are_finite(h.as_slice())).map(|(h, weight)| (h, ComplexField::exp(*weight)))
        };
        let sum: f64 = finite().map(|(_, weight)| weight).sum();
        let mean = finite().fold(DVector::zeros(p), |mean, (h, weight)| mean + h * (weight / sum));
        let spread = finite().fold(measured.v.clone(), |spread, (h, weight)| {
            let away = h - &mean;
            spread + &away * away.transpose() * (weight / sum)
        });
        (mean, spread)
    }

    /// The states of the particles after a duration, and the covariance of the noise on the way.
    fn moved(&self, t: f64, cloud: &Cloud, u: &DVector<f64>, duration: f64) -> Option<(Images, DMatrix<f64>)> {
        let Self { plant, prediction, h, w, .. } = self;
        let derivative = |t: f64, x: &DVector<f64>| plant.derivative(t, x, u);
        let field = |t: f64, x: &DVector<f64>| (derivative(t, x), plant.state_jacobian(t, x, u));
        // Where the next state alone is asked for, Df is not.
        let unknown = w * 0.0;
        let alone = |t: f64, x: &DVector<f64>| (derivative(t, x), unknown.clone());
        let centre = Motion { field, is_linear: plant.is_linear_between_samples(), w, with_covariance: true };
        let point = Motion { field: alone, is_linear: false, w, with_covariance: false };
        let (image, noise) = centre.around(&point, *prediction, (t, duration, *h), (&cloud.xhat, &cloud.p))?;
        Some((cloud.particles.iter().map(image).collect(), noise))
    }

    fn finish(&self, t: f64, state: &mut DVector<f64>, u: &DVector<f64>) {
        if self.fits(u) && state.len() == self.length() && !self.advance(t, state, u, self.h) {
            state.rows_mut(0, self.order()).fill(f64::NAN);
        }
    }
}

/// An output that is NaN or infinite counts as not measured; a sample under which no particle is possible is passed
/// over. A prediction without a result makes the estimate NaN.
impl<S: Differentiable<f64, Dyn, Dyn, Dyn>, R: ParticleNoise> SampledObserver<f64> for ParticleFilter<S, R> {
    type State = DVector<f64>;
    type Input = DVector<f64>;
    type Output = DVector<f64>;
    type Estimate = DVector<f64>;

    fn dimensions(&self) -> ObserverDimensions {
        let size = self.plant.dimensions();
        ObserverDimensions { state: self.length(), inputs: size.inputs, outputs: size.outputs, estimate: size.states }
    }

    fn period(&self) -> f64 {
        self.h
    }

    update_and_finish!(f64);

    fn estimate(&self, state: &DVector<f64>) -> DVector<f64> {
        state.rows(0, self.order()).into_owned()
    }

    fn estimate_into(&self, state: &[f64], estimate: &mut [f64]) -> bool {
        state.get(..estimate.len()).is_some_and(|xhat| put_slice(xhat, estimate))
    }

    fn initial(&self, _t: f64, estimate: &DVector<f64>, _u: &DVector<f64>, _y: &DVector<f64>) -> DVector<f64> {
        let (n, factor) = (self.order(), semidefinite_factor(&self.p0));
        let mut numbers = vec![0.0; self.count * n];
        self.random.normals(0, &mut numbers);
        let particle = |numbers: &[f64]| estimate + &factor * DVector::from_column_slice(numbers);
        Self::joined(&Cloud {
            xhat: estimate.clone(),
            p: self.p0.clone(),
            predictions: 0.0,
            particles: numbers.chunks_exact(n).map(particle).collect(),
            weights: vec![-ComplexField::ln(self.count as f64); self.count],
        })
    }
}

/// The square of an innovation is that of a Gaussian distribution with the mean and the covariance of the particles.
impl<S: Differentiable<f64, Dyn, Dyn, Dyn>, R: ParticleNoise> CovarianceFilter<f64> for ParticleFilter<S, R> {
    fn is_discrete(&self) -> bool {
        self.prediction == Prediction::Discrete
    }

    fn covariance_into(&self, state: &DVector<f64>, p: &mut [f64]) -> bool {
        state.as_slice().get(self.order()..self.head() - 1).is_some_and(|entries| put_slice(entries, p))
    }

    fn measure(
        &self,
        t: f64,
        state: &mut DVector<f64>,
        u: &DVector<f64>,
        y: &DVector<f64>,
        measured: &[bool],
    ) -> Option<f64> {
        self.measure_with_determinant(t, state, u, y, measured).map(|(square, _)| square)
    }

    fn measure_with_determinant(
        &self,
        t: f64,
        state: &mut DVector<f64>,
        u: &DVector<f64>,
        y: &DVector<f64>,
        measured: &[bool],
    ) -> Option<(f64, Option<f64>)> {
        if !self.is_measurement(y) || !self.fits(u) {
            return None;
        }
        let used = usable(y, |output| measured.get(output).copied().unwrap_or(true))?;
        let mut cloud = self.apart(state)?;
        let of = self.measured(t, &cloud, u, |output| used[output])?;
        let y = DVector::from_fn(of.rows.len(), |i, _| y[of.rows[i]]);
        let (mean, spread) = Self::predicted(&cloud, &of);
        let innovation = &y - mean;
        let factor = Factor::new(&spread)?;
        let square = innovation.dot(&factor.solve(&innovation));
        let determinant = factor.log_determinant();
        for (weight, h) in cloud.weights.iter_mut().zip(&of.expected) {
            let mut away = &y - h;
            of.factor.half_solve(&mut away);
            let exponent = 0.5 * away.norm_squared();
            *weight = if exponent.is_finite() { *weight - exponent } else { f64::NEG_INFINITY };
        }
        if !cloud.normalise() {
            return None;
        }
        cloud.summarise();
        if cloud.effective() < RESAMPLED_BELOW * self.count as f64 {
            cloud.resample(self.random.uniform(cloud.predictions as u64));
        }
        *state = Self::joined(&cloud);
        Some((square, Some(determinant)))
    }

    fn innovation(&self, t: f64, state: &DVector<f64>, u: &DVector<f64>, y: &DVector<f64>) -> DVector<f64> {
        let expected = || {
            let cloud = self.apart(state).filter(|_| self.is_measurement(y) && self.fits(u))?;
            let of = self.measured(t, &cloud, u, |_| true)?;
            Some(y - Self::predicted(&cloud, &of).0)
        };
        expected().unwrap_or_else(|| y.map(|_| f64::NAN))
    }

    fn advance(&self, t: f64, state: &mut DVector<f64>, u: &DVector<f64>, duration: f64) -> bool {
        let Some(mut cloud) = self.apart(state).filter(|_| self.fits(u)) else { return false };
        let Some((images, noise)) = self.moved(t, &cloud, u, duration) else { return false };
        let (n, factor) = (self.order(), semidefinite_factor(&noise));
        cloud.predictions += 1.0;
        let mut numbers = vec![0.0; self.count * n];
        self.random.normals(cloud.predictions as u64, &mut numbers);
        for (i, (image, numbers)) in images.into_iter().zip(numbers.chunks_exact(n)).enumerate() {
            match image {
                Some(x) => cloud.particles[i] = x + &factor * DVector::from_column_slice(numbers),
                // No state is known to come after it.
                None => cloud.weights[i] = f64::NEG_INFINITY,
            }
        }
        if !cloud.normalise() {
            return false;
        }
        cloud.summarise();
        let next = Self::joined(&cloud);
        let is_finite = are_finite(&next.as_slice()[..self.head()]);
        if is_finite {
            *state = next;
        }
        is_finite
    }
}
