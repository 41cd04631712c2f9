//! The interacting multiple model filter (IMM): several models of a plant, of which one holds at a time, and which may
//! change into each other from sample to sample.
//!
//! Model i is a plant with noises of its own and an extended Kalman filter, the Kalman filter of a linear plant; all
//! have the same states, inputs and outputs. Which model holds is a Markov chain with the transition probabilities
//! `Pi_ij = P(model j at the next sample | model i at this one)`. With the mode probabilities mu, the estimates `x_i`
//! and covariances `P_i` a step is
//!
//! ```text
//! update       each filter by y, with the innovation v_i and its covariance S_i
//!              mu_i <- mu_i N(v_i; 0, S_i), then divided by their sum
//! estimate     xhat = sum mu_i x_i,    P = sum mu_i (P_i + (x_i - xhat)(x_i - xhat)')
//! interaction  c_j = sum_i Pi_ij mu_i,    mu_i|j = Pi_ij mu_i / c_j
//!              x0_j = sum_i mu_i|j x_i,    P0_j = sum_i mu_i|j (P_i + (x_i - x0_j)(x_i - x0_j)')
//! prediction   each filter from (x0_j, P0_j);  mu_j <- c_j,  xhat and P as above
//! ```
//!
//! Several Gaussian distributions are replaced by one with their mean and covariance, which is why the filter is not
//! optimal even where all models are linear; nothing is proved of it. With equal models it is their filter.
//!
//! Pi is that of one prediction, however long it is. A model under which a measurement is impossible in floating point
//! (S not positive definite, h not finite) gets the probability zero at this sample.
//!
//! Sources: H. A. P. Blom and Y. Bar-Shalom, The interacting multiple model algorithm for systems with Markovian
//! switching coefficients, IEEE Transactions on Automatic Control 33, 1988; Y. Bar-Shalom, X. R. Li and T. Kirubarajan,
//! Estimation with Applications to Tracking and Navigation, Wiley 2001, section 11.6.6.

extern crate alloc;

use alloc::vec::Vec;

use luenberger_plants::error::check_matrix;
use luenberger_plants::{Column, Differentiable};
use nalgebra::{ComplexField, DMatrix, DVector, Dyn};

use crate::covariance_filter::{CovarianceFilter, update_and_finish};
use crate::dense::{Factor, are_finite};
use crate::error::ObserverError;
use crate::gaussian::{GaussianEstimate, Innovation, symmetrise};
use crate::kalman::ExtendedKalmanFilter;
use crate::observer::{ObserverDimensions, SampledObserver, put_slice};
use crate::transition::Prediction;

/// How far a sum of probabilities may be from one: three digits less than a double has.
const ROUNDING: f64 = 1e-12;

/// An interacting multiple model filter; see the [module](self).
///
/// Its state is the estimate (n), its covariance (n x n by columns), the mode probabilities (r), and estimate and
/// covariance of each filter.
#[derive(Clone, Debug)]
pub struct InteractingMultipleModel<S> {
    filters: Vec<ExtendedKalmanFilter<S, f64, Dyn, Dyn, Dyn>>,
    transitions: DMatrix<f64>,
    start: DVector<f64>,
}

/// A state, taken apart.
struct Modes {
    probabilities: DVector<f64>,
    estimates: Vec<GaussianEstimate<f64, Dyn>>,
}

/// Mean and covariance of Gaussian distributions with these weights, which sum to one.
fn merged<'a>(
    weighted: &(impl Iterator<Item = (f64, &'a GaussianEstimate<f64, Dyn>)> + Clone),
    n: usize,
) -> (DVector<f64>, DMatrix<f64>) {
    // What has no weight has no part in it, whatever its numbers are.
    let parts = || weighted.clone().filter(|(weight, _)| *weight > 0.0);
    let mean = parts().fold(DVector::zeros(n), |mean, (weight, one)| mean + one.estimate() * weight);
    let mut spread = parts().fold(DMatrix::zeros(n, n), |spread, (weight, one)| {
        let away = one.estimate() - &mean;
        spread + (one.covariance() + &away * away.transpose()) * weight
    });
    symmetrise(&mut spread);
    (mean, spread)
}

/// Checks a row of probabilities.
fn distribution<'a>(
    what: &'static str,
    row: usize,
    entries: impl Iterator<Item = &'a f64> + Clone,
) -> Result<(), ObserverError> {
    let (least, sum) = (entries.clone().copied().fold(f64::INFINITY, f64::min), entries.sum::<f64>());
    // A NaN is in the sum.
    if least >= 0.0 && (sum - 1.0).abs() <= ROUNDING {
        return Ok(());
    }
    Err(ObserverError::Probabilities { what, row, least, sum })
}

impl<S: Differentiable<f64, Dyn, Dyn, Dyn>> InteractingMultipleModel<S> {
    /// The filter of these models, `transitions` r x r with rows that sum to one, `probabilities` of the modes at the
    /// start (length r). The filters have one period and one way of prediction; their P(0) are those of the start.
    ///
    /// ```
    /// use luenberger_observers::{ExtendedKalmanFilter, InteractingMultipleModel, NoiseModel, SampledObserver};
    /// use luenberger_plants::StateSpace;
    /// use nalgebra::{DMatrix, DVector, dmatrix, dvector};
    /// // A level at rest, or one that moves at random.
    /// let model = |w: f64| {
    ///     let plant = StateSpace::new(dmatrix![1.0], DMatrix::zeros(1, 0), dmatrix![1.0])?;
    ///     let noises = NoiseModel { w: dmatrix![w], v: dmatrix![0.01], p0: dmatrix![0.01] };
    ///     Ok::<_, Box<dyn std::error::Error>>(ExtendedKalmanFilter::discrete(plant, noises, 1.0)?)
    /// };
    /// let transitions = dmatrix![0.95, 0.05; 0.05, 0.95];
    /// let filter = InteractingMultipleModel::new(vec![model(0.0)?, model(1.0)?], transitions, dvector![0.5, 0.5])?;
    /// let mut state = filter.initial(0.0, &dvector![0.0], &DVector::zeros(0), &dvector![0.0]);
    /// let moving = |state: &DVector<f64>| filter.probabilities(state).map_or(0.0, |mu| mu[1]);
    /// for _ in 0..20 {
    ///     filter.step(0.0, &mut state, &DVector::zeros(0), &dvector![0.0]);
    /// }
    /// assert!(moving(&state) < 0.3);
    /// filter.step(0.0, &mut state, &DVector::zeros(0), &dvector![3.0]);
    /// assert!(moving(&state) > 0.9);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    /// # Errors
    /// [`ObserverError::TooFew`] for less than two models; [`ObserverError::Table`] for models of other sizes, periods
    /// or predictions than those of the first; [`ObserverError::Matrix`] for the shape of `transitions`,
    /// [`ObserverError::Probabilities`] for what is negative or does not sum to one.
    pub fn new(
        filters: Vec<ExtendedKalmanFilter<S, f64, Dyn, Dyn, Dyn>>,
        transitions: DMatrix<f64>,
        probabilities: DVector<f64>,
    ) -> Result<Self, ObserverError> {
        let r = filters.len();
        let [first, _, ..] = &filters[..] else {
            return Err(ObserverError::TooFew { what: "models", least: 2, found: r });
        };
        let is_alike = |other: &ExtendedKalmanFilter<S, f64, Dyn, Dyn, Dyn>| {
            (other.dimensions(), other.period()) == (first.dimensions(), first.period())
                && other.prediction() == first.prediction()
        };
        let alike = filters.iter().filter(|other| is_alike(other)).count();
        if alike < r {
            let what = "models of one size, period and prediction";
            return Err(ObserverError::Table { what, expected: r, found: alike });
        }
        check_matrix("the transition probabilities", &transitions, (r, r))?;
        if probabilities.len() != r {
            let what = "mode probabilities";
            return Err(ObserverError::Table { what, expected: r, found: probabilities.len() });
        }
        for (row, entries) in transitions.row_iter().enumerate() {
            distribution("the transition probabilities", row, entries.iter())?;
        }
        distribution("the mode probabilities", 0, probabilities.iter())?;
        Ok(Self { filters, transitions, start: probabilities })
    }

    /// The filters of the models.
    pub fn filters(&self) -> &[ExtendedKalmanFilter<S, f64, Dyn, Dyn, Dyn>] {
        &self.filters
    }

    /// The mode probabilities of a state, length r: after an update given its measurement too, after a prediction those
    /// of the next sample. None for another length.
    pub fn probabilities(&self, state: &DVector<f64>) -> Option<DVector<f64>> {
        self.apart(state).map(|modes| modes.probabilities)
    }

    fn order(&self) -> usize {
        self.filters[0].dimensions().estimate
    }

    /// Where the mode probabilities begin.
    fn head(&self) -> usize {
        self.order() * (self.order() + 1)
    }

    fn length(&self) -> usize {
        self.head() + self.filters.len() * (1 + self.head())
    }

    fn apart(&self, state: &DVector<f64>) -> Option<Modes> {
        let (r, head) = (self.filters.len(), self.head());
        if state.len() != self.length() {
            return None;
        }
        let (probabilities, estimates) = state.as_slice()[head..].split_at(r);
        let estimates = estimates.chunks_exact(head).map(GaussianEstimate::try_from_slice).collect::<Option<_>>()?;
        Some(Modes { probabilities: DVector::from_column_slice(probabilities), estimates })
    }

    fn joined(&self, modes: &Modes) -> DVector<f64> {
        let weighted = modes.probabilities.iter().copied().zip(&modes.estimates);
        let (xhat, p) = merged(&weighted, self.order());
        let mut entries = xhat.as_slice().to_vec();
        entries.extend_from_slice(p.as_slice());
        entries.extend_from_slice(modes.probabilities.as_slice());
        for one in &modes.estimates {
            entries.extend_from_slice(one.as_slice());
        }
        DVector::from_vec(entries)
    }

    fn fits(&self, u: &DVector<f64>) -> bool {
        u.len() == self.filters[0].dimensions().inputs
    }

    fn finish(&self, t: f64, state: &mut DVector<f64>, u: &DVector<f64>) {
        let h = self.period();
        if self.fits(u) && state.len() == self.length() && !self.advance(t, state, u, h) {
            state.rows_mut(0, self.order()).fill(f64::NAN);
        }
    }

    /// Mean and covariance of the innovation over the models, `y~' S^-1 y~` and `ln det S`.
    fn of_all(weighted: &[(f64, Innovation<f64, Dyn>)]) -> Option<(f64, f64)> {
        let p = weighted.first()?.1.value.len();
        let mean = weighted.iter().fold(DVector::zeros(p), |mean, (weight, one)| mean + &one.value * *weight);
        let covariance = weighted.iter().fold(DMatrix::zeros(p, p), |spread, (weight, one)| {
            let away = &one.value - &mean;
            spread + (&one.covariance + &away * away.transpose()) * *weight
        });
        let factor = Factor::new(&covariance)?;
        let square = mean.dot(&factor.solve(&mean));
        Some((square, factor.log_determinant()))
    }
}

/// An output that is NaN or infinite counts as not measured; a sample that is impossible under every model is passed
/// over. A prediction without a result makes the estimate NaN.
impl<S: Differentiable<f64, Dyn, Dyn, Dyn>> SampledObserver<f64> for InteractingMultipleModel<S> {
    type State = DVector<f64>;
    type Input = DVector<f64>;
    type Output = DVector<f64>;
    type Estimate = DVector<f64>;

    fn dimensions(&self) -> ObserverDimensions {
        ObserverDimensions { state: self.length(), ..self.filters[0].dimensions() }
    }

    fn period(&self) -> f64 {
        self.filters[0].period()
    }

    update_and_finish!(f64);

    fn estimate(&self, state: &DVector<f64>) -> DVector<f64> {
        state.rows(0, self.order()).into_owned()
    }

    fn estimate_into(&self, state: &[f64], estimate: &mut [f64]) -> bool {
        state.get(..estimate.len()).is_some_and(|xhat| put_slice(xhat, estimate))
    }

    fn initial(&self, t: f64, estimate: &DVector<f64>, u: &DVector<f64>, y: &DVector<f64>) -> DVector<f64> {
        let estimates = self.filters.iter().map(|filter| filter.initial(t, estimate, u, y)).collect();
        self.joined(&Modes { probabilities: self.start.clone(), estimates })
    }
}

/// The square of an innovation is that of a Gaussian distribution with the mean and the covariance of the models.
impl<S: Differentiable<f64, Dyn, Dyn, Dyn>> CovarianceFilter<f64> for InteractingMultipleModel<S> {
    fn is_discrete(&self) -> bool {
        self.filters[0].prediction() == Prediction::Discrete
    }

    fn covariance_into(&self, state: &DVector<f64>, p: &mut [f64]) -> bool {
        state.as_slice().get(self.order()..self.head()).is_some_and(|entries| put_slice(entries, p))
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
        let mut modes = self.apart(state)?;
        let used = |output: usize| measured.get(output).copied().unwrap_or(true);
        let mut exponents = DVector::from_element(self.filters.len(), f64::NEG_INFINITY);
        let mut known = Vec::new();
        for (i, filter) in self.filters.iter().enumerate() {
            let mu = modes.probabilities[i];
            if let Some(innovation) = filter.update_partial(t, &mut modes.estimates[i], u, y, used) {
                // ln of mu_i N(v_i; 0, S_i), but for what is common to all models.
                let exponent = -0.5 * (innovation.normalized_square + innovation.log_determinant());
                if mu > 0.0 && exponent.is_finite() {
                    exponents[i] = ComplexField::ln(mu) + exponent;
                }
                known.push((mu, innovation));
            }
        }
        let largest = exponents.max();
        if !largest.is_finite() {
            return None;
        }
        let weights = exponents.map(|exponent| ComplexField::exp(exponent - largest));
        modes.probabilities = &weights / weights.sum();
        let share: f64 = known.iter().map(|(mu, _)| mu).sum();
        for (mu, _) in &mut known {
            *mu /= share;
        }
        let (square, determinant) = Self::of_all(&known)?;
        let next = self.joined(&modes);
        if !are_finite(&next.as_slice()[..self.head()]) {
            return None;
        }
        *state = next;
        Some((square, Some(determinant)))
    }

    fn innovation(&self, t: f64, state: &DVector<f64>, u: &DVector<f64>, y: &DVector<f64>) -> DVector<f64> {
        let Some(modes) = self.apart(state) else { return y.map(|_| f64::NAN) };
        let parts = self.filters.iter().zip(&modes.estimates).zip(&modes.probabilities);
        parts.filter(|(_, mu)| **mu > 0.0).fold(y * 0.0, |mean, ((filter, estimate), mu)| {
            let innovation = filter.innovation(t, estimate, u, y);
            if innovation.len() == mean.len() { mean + innovation * *mu } else { mean * f64::NAN }
        })
    }

    fn advance(&self, t: f64, state: &mut DVector<f64>, u: &DVector<f64>, duration: f64) -> bool {
        let Some(Modes { probabilities, estimates }) = self.apart(state).filter(|_| self.fits(u)) else { return false };
        let next = self.transitions.tr_mul(&probabilities);
        let mut mixed = Vec::with_capacity(estimates.len());
        for (j, filter) in self.filters.iter().enumerate() {
            // A mode that cannot be reached keeps its own.
            let mut one = if next[j] > 0.0 {
                let part = |i: usize| self.transitions[(i, j)] * probabilities[i] / next[j];
                let weighted = estimates.iter().enumerate().map(|(i, estimate)| (part(i), estimate));
                let (xhat, p) = merged(&weighted, self.order());
                GaussianEstimate::new(&xhat, &p)
            } else {
                estimates[j].clone()
            };
            if !filter.predict(t, &mut one, u, duration) && next[j] > 0.0 {
                return false;
            }
            mixed.push(one);
        }
        let joined = self.joined(&Modes { probabilities: next, estimates: mixed });
        let is_finite = are_finite(&joined.as_slice()[..self.head()]);
        if is_finite {
            *state = joined;
        }
        is_finite
    }
}
