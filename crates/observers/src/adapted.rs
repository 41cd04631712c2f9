//! Filters whose noises depend on time, state and input, and whose estimates stay within bounds.
//!
//! The filter inside has constant noises W, V. At a sample, before its update, V is taken at the prediction, and for a
//! prediction W at the estimate with which it begins:
//!
//! ```text
//! V_k = V(t_k, xhat(t_k | t_k-1), u_k),     W = W(t, xhat(t | t), u)  until the end of the prediction
//! ```
//!
//! An iterated filter has the same V in all its linearisations. There is no theorem: for noise that depends on the
//! state the filter is that of noise with the covariance at the estimate.
//!
//! With bounds `l <= x <= u` an estimate xhat with covariance P that an update leaves outside is projected:
//!
//! ```text
//! least (x - xhat)' P^-1 (x - xhat)  subject to  l <= x <= u
//! ```
//!
//! For a Gaussian error it is the most probable state within the bounds. P is not changed: it is that of the estimate
//! without bounds, and states a deviation that is too large rather than too small. The estimates between an update and
//! the next are predictions, and can leave the bounds. The projection needs no inverse of P, which may be singular: a
//! state without variance does not move, and is put on its bound alone.
//!
//! Method: the dual active-set method of Goldfarb and Idnani, Mathematical Programming 27, 1983, which begins at xhat
//! and takes bounds in by the largest violation in standard deviations; it ends after finitely many steps.
//!
//! Source: D. Simon, Kalman filtering with state constraints: a survey of linear and nonlinear algorithms, IET Control
//! Theory and Applications 4, 2010, estimate projection with the weight `P^-1`.

extern crate alloc;

use alloc::vec;
use alloc::vec::Vec;

use luenberger_plants::{Column, Differentiable, Size};
use nalgebra::allocator::Allocator;
use nalgebra::{DMatrix, DVector, DefaultAllocator, Dim, DimAdd, DimSum, OMatrix, RealField, U1, convert};

use crate::covariance_filter::{CovarianceFilter, update_and_finish};
use crate::dense::Factor;
use crate::error::{ObserverError, check_bounds};
use crate::gaussian::{GaussianEstimate, NoiseModel, covariance};
use crate::kalman::ExtendedKalmanFilter;
use crate::observer::{ObserverDimensions, SampledObserver};
use crate::triangular::semidefinite_factor;
use crate::unscented::{SquareRootEstimate, UnscentedKalmanFilter};

/// A filter that can be made again with other noises, and whose estimate can be moved.
pub trait AdaptableFilter<T: RealField + Copy>: CovarianceFilter<T> + Sized {
    /// W (n x n) and V (p x p), by columns.
    fn noises(&self) -> (Vec<T>, Vec<T>);

    /// The same filter with W (n x n) or V (p x p) by columns in place of its own, where they are given.
    ///
    /// # Errors
    /// [`ObserverError`] of the constructor: V has to be positive definite, W semidefinite.
    fn with_noises(&self, w: Option<&[T]>, v: Option<&[T]>) -> Result<Self, ObserverError>;

    /// The state with another estimate, of n entries, and its covariance.
    fn moved(&self, state: &Self::State, xhat: &[T]) -> Self::State;
}

/// The matrix of these entries by columns, if it has the shape of another one.
fn entries<T: RealField + Copy, D: Dim>(
    like: &OMatrix<T, D, D>,
    columns: &[T],
) -> Result<OMatrix<T, D, D>, ObserverError>
where
    DefaultAllocator: Allocator<D, D>,
{
    let expected = like.len();
    if columns.len() != expected {
        return Err(ObserverError::Table { what: "a covariance", expected, found: columns.len() });
    }
    let order = like.shape_generic().0;
    Ok(OMatrix::from_column_slice_generic(order, order, columns))
}

impl<S, T: RealField + Copy, N: DimAdd<U1>, M: Dim, P: Dim> AdaptableFilter<T> for ExtendedKalmanFilter<S, T, N, M, P>
where
    S: Differentiable<T, N, M, P> + Clone,
    DefaultAllocator: Size<N, M, P> + Allocator<N, DimSum<N, U1>>,
{
    fn noises(&self) -> (Vec<T>, Vec<T>) {
        let NoiseModel { w, v, .. } = self.noise_model();
        (w.as_slice().to_vec(), v.as_slice().to_vec())
    }

    fn with_noises(&self, w: Option<&[T]>, v: Option<&[T]>) -> Result<Self, ObserverError> {
        let mut noises = self.noise_model().clone();
        if let Some(w) = w {
            noises.w = covariance("W", entries(&noises.w, w)?, noises.w.nrows(), false)?;
        }
        if let Some(v) = v {
            noises.v = covariance("V", entries(&noises.v, v)?, noises.v.nrows(), true)?;
        }
        Ok(self.clone().of_noises(noises))
    }

    fn moved(&self, state: &Self::State, xhat: &[T]) -> Self::State {
        moved_to(state, xhat)
    }
}

impl<S, T: RealField + Copy, N: DimAdd<U1>, M: Dim, P: Dim> AdaptableFilter<T> for UnscentedKalmanFilter<S, T, N, M, P>
where
    S: Differentiable<T, N, M, P> + Clone,
    DefaultAllocator: Size<N, M, P> + Allocator<N, DimSum<N, U1>>,
{
    fn noises(&self) -> (Vec<T>, Vec<T>) {
        let NoiseModel { w, v, .. } = self.factors();
        let (w, v) = (w * w.transpose(), v * v.transpose());
        (w.as_slice().to_vec(), v.as_slice().to_vec())
    }

    fn with_noises(&self, w: Option<&[T]>, v: Option<&[T]>) -> Result<Self, ObserverError> {
        let mut factors = self.factors().clone();
        if let Some(w) = w {
            factors.w = semidefinite_factor(&covariance("W", entries(&factors.w, w)?, factors.w.nrows(), false)?);
        }
        if let Some(v) = v {
            factors.v = semidefinite_factor(&covariance("V", entries(&factors.v, v)?, factors.v.nrows(), true)?);
        }
        Ok(self.clone().of_factors(factors))
    }

    fn moved(&self, state: &Self::State, xhat: &[T]) -> Self::State {
        SquareRootEstimate::try_from_slice(moved_to(state.joined(), xhat).as_slice()).unwrap_or_else(|| state.clone())
    }
}

fn moved_to<T: RealField + Copy, N: DimAdd<U1>>(state: &GaussianEstimate<T, N>, xhat: &[T]) -> GaussianEstimate<T, N>
where
    DefaultAllocator: Allocator<N, DimSum<N, U1>> + Allocator<N> + Allocator<N, N>,
{
    let mut entries = state.as_slice().to_vec();
    let given = xhat.len().min(entries.len());
    entries[..given].copy_from_slice(&xhat[..given]);
    GaussianEstimate::try_from_slice(&entries).unwrap_or_else(|| state.clone())
}

/// Covariances along the way of an estimate.
pub trait NoisesAlong<T> {
    /// Puts entries of W (n x n, by columns; it comes with the constant one) for time, estimate and input; false where
    /// W is the constant one.
    fn process_noise(&self, t: T, xhat: &[T], u: &[T], w: &mut [T]) -> bool {
        let _ = (t, xhat, u, w);
        false
    }

    /// Puts entries of V (p x p), likewise.
    fn measurement_noise(&self, t: T, xhat: &[T], u: &[T], v: &mut [T]) -> bool {
        let _ = (t, xhat, u, v);
        false
    }
}

/// Constant noises.
impl<T> NoisesAlong<T> for () {}

/// A filter with [noises along its way](NoisesAlong), and with bounds of its estimates; see the [module](self).
///
/// ```
/// use luenberger_observers::adapted::AdaptedFilter;
/// use luenberger_observers::kalman::{ExtendedKalmanFilter, NoiseModel};
/// use luenberger_observers::{CovarianceFilter, SampledObserver};
/// use nalgebra::{Matrix1, Matrix2, Vector1, Vector2};
/// let noises = NoiseModel { w: Matrix2::zeros(), v: Matrix1::new(1.0), p0: Matrix2::new(1.0, 0.5, 0.5, 1.0) };
/// let filter = ExtendedKalmanFilter::new(luenberger_plants::double_integrator(), noises, 0.1, 1)?;
/// let filter = AdaptedFilter::new(filter, ()).with_bounds(&[-1.0, -9.0], &[1.0, 9.0])?;
/// let (u, y) = (Vector1::new(0.0), Vector1::new(4.0));
/// let mut state = filter.initial(0.0, &Vector2::zeros(), &u, &y);
/// filter.measure(0.0, &mut state, &u, &y, &[true]);
/// // The update leads to (2, 1), and the bound of the first state takes the second one half as far along.
/// assert!((filter.estimate(&state) - Vector2::new(1.0, 0.5)).norm() < 1e-15);
/// # Ok::<(), luenberger_observers::ObserverError>(())
/// ```
#[derive(Clone, Debug)]
pub struct AdaptedFilter<F, T, A> {
    filter: F,
    along: A,
    /// Lower and upper ends.
    bounds: Option<(Vec<T>, Vec<T>)>,
}

impl<T: RealField + Copy, F: AdaptableFilter<T>, A: NoisesAlong<T>> AdaptedFilter<F, T, A> {
    /// The filter with these noises along its way, and no bounds.
    pub fn new(filter: F, along: A) -> Self {
        Self { filter, along, bounds: None }
    }

    /// The filter whose estimates after an update lie between these ends, n each, which may be infinite.
    ///
    /// # Errors
    /// [`ObserverError::Table`] for other lengths, [`ObserverError::Box`] unless each lower end is below the upper one.
    pub fn with_bounds(self, lower: &[T], upper: &[T]) -> Result<Self, ObserverError> {
        check_bounds(lower, upper, self.filter.dimensions().estimate)?;
        Ok(Self { bounds: Some((lower.to_vec(), upper.to_vec())), ..self })
    }

    /// The noises along the way.
    pub fn along(&self) -> &A {
        &self.along
    }

    /// The same filter with other noises along its way.
    #[must_use]
    pub fn with_noises_along(self, along: A) -> Self {
        Self { along, ..self }
    }

    /// The filter inside, with constant noises and without bounds.
    pub fn inner(&self) -> &F {
        &self.filter
    }

    fn xhat(&self, state: &F::State) -> F::Estimate {
        self.filter.estimate(state)
    }

    /// The filter with the V of a sample; none if it is no covariance.
    pub(crate) fn at_sample(&self, t: T, state: &F::State, u: &F::Input) -> Option<F> {
        let (_, mut v) = self.filter.noises();
        let varies = self.along.measurement_noise(t, self.xhat(state).as_slice(), u.as_slice(), &mut v);
        self.filter.with_noises(None, varies.then_some(&v[..])).ok()
    }

    /// The filter with the W of a prediction.
    pub(crate) fn at_prediction(&self, t: T, state: &F::State, u: &F::Input) -> Option<F> {
        let (mut w, _) = self.filter.noises();
        let varies = self.along.process_noise(t, self.xhat(state).as_slice(), u.as_slice(), &mut w);
        self.filter.with_noises(varies.then_some(&w[..]), None).ok()
    }

    /// Puts the estimate within its bounds.
    fn confine(&self, state: &mut F::State) {
        let Some((lower, upper)) = &self.bounds else { return };
        let xhat = self.xhat(state);
        let (xhat, n) = (xhat.as_slice(), xhat.as_slice().len());
        let is_within = |(x, (lower, upper)): (&T, (&T, &T))| x >= lower && x <= upper;
        if xhat.iter().zip(lower.iter().zip(upper)).all(is_within) {
            return;
        }
        let mut p = vec![T::zero(); n * n];
        if self.filter.covariance_into(state, &mut p) {
            let nearest = nearest_within(xhat, &DMatrix::from_column_slice(n, n, &p), lower, upper);
            *state = self.filter.moved(state, &nearest);
        }
    }

    /// The prediction of a step.
    fn finish(&self, t: T, state: &mut F::State, u: &F::Input) {
        if !self.advance(t, state, u, self.filter.period()) {
            let nan = vec![convert(f64::NAN); self.filter.dimensions().estimate];
            *state = self.filter.moved(state, &nan);
        }
    }
}

impl<T: RealField + Copy, F: AdaptableFilter<T>, A: NoisesAlong<T>> SampledObserver<T> for AdaptedFilter<F, T, A> {
    type State = F::State;
    type Input = F::Input;
    type Output = F::Output;
    type Estimate = F::Estimate;

    fn dimensions(&self) -> ObserverDimensions {
        self.filter.dimensions()
    }

    fn period(&self) -> T {
        self.filter.period()
    }

    update_and_finish!(T);

    fn estimate(&self, state: &Self::State) -> Self::Estimate {
        self.filter.estimate(state)
    }

    fn estimate_into(&self, state: &[T], estimate: &mut [T]) -> bool {
        self.filter.estimate_into(state, estimate)
    }

    fn initial(&self, t: T, estimate: &Self::Estimate, u: &Self::Input, y: &Self::Output) -> Self::State {
        self.filter.initial(t, estimate, u, y)
    }
}

/// A sample whose V is no covariance is passed over; a prediction whose W is none has no result.
impl<T: RealField + Copy, F: AdaptableFilter<T>, A: NoisesAlong<T>> CovarianceFilter<T> for AdaptedFilter<F, T, A> {
    fn is_discrete(&self) -> bool {
        self.filter.is_discrete()
    }

    fn unit_vector_of(&self, state: usize) -> usize {
        self.filter.unit_vector_of(state)
    }

    fn covariance_into(&self, state: &Self::State, p: &mut [T]) -> bool {
        self.filter.covariance_into(state, p)
    }

    fn measure(
        &self,
        t: T,
        state: &mut Self::State,
        u: &Self::Input,
        y: &Self::Output,
        measured: &[bool],
    ) -> Option<T> {
        self.measure_with_determinant(t, state, u, y, measured).map(|(square, _)| square)
    }

    fn measure_with_determinant(
        &self,
        t: T,
        state: &mut Self::State,
        u: &Self::Input,
        y: &Self::Output,
        measured: &[bool],
    ) -> Option<(T, Option<T>)> {
        let found = self.at_sample(t, state, u)?.measure_with_determinant(t, state, u, y, measured)?;
        self.confine(state);
        Some(found)
    }

    fn innovation(&self, t: T, state: &Self::State, u: &Self::Input, y: &Self::Output) -> Self::Output {
        self.filter.innovation(t, state, u, y)
    }

    fn advance(&self, t: T, state: &mut Self::State, u: &Self::Input, duration: T) -> bool {
        self.at_prediction(t, state, u).is_some_and(|filter| filter.advance(t, state, u, duration))
    }

    fn advance_across(&self, t: T, state: &mut Self::State, u: &Self::Input, duration: T, cross: &mut [T]) -> bool {
        self.at_prediction(t, state, u).is_some_and(|filter| filter.advance_across(t, state, u, duration, cross))
    }

    fn rejects_output(&self, t: T, state: &Self::State, u: &Self::Input, y: &Self::Output, output: usize) -> bool {
        self.at_sample(t, state, u).is_some_and(|filter| filter.rejects_output(t, state, u, y, output))
    }
}

/// A bound that holds with equality.
#[derive(Clone, Copy, Debug)]
struct Active<T> {
    state: usize,
    /// 1 at the lower end, -1 at the upper one: the bound is `sign x >= sign end`.
    sign: T,
    multiplier: T,
}

/// The x between `lower` and `upper` with the least `(x - xhat)' P^-1 (x - xhat)`, for P positive semidefinite: x moves
/// in the range of P, and a state that cannot move is put on its bound.
///
/// With the bounds of A active `x = xhat + P N m`, `m = (N' P N)^-1 (b - N' xhat) >= 0`, N the signed unit vectors.
pub fn nearest_within<T: RealField + Copy>(xhat: &[T], p: &DMatrix<T>, lower: &[T], upper: &[T]) -> Vec<T> {
    let n = xhat.len();
    let mut x = xhat.to_vec();
    let mut active: Vec<Active<T>> = Vec::new();
    let mut stuck = vec![false; n];
    // Each bound taken in raises the least value for its set of active bounds, of which there are finitely many; the
    // limit is for rounding.
    for _ in 0..16 * (n + 1) {
        let Some(mut next) = most_violated(&x, p, (lower, upper), &stuck, &active) else { break };
        let end = if next.sign > T::zero() { lower[next.state] } else { upper[next.state] };
        loop {
            let Some((direction, response)) = towards(p, &active, next) else {
                active.clear();
                break;
            };
            let gap = next.sign * (end - x[next.state]);
            let speed = next.sign * direction[next.state];
            // What rounding leaves of a state that the active bounds determine.
            let full = (speed > p[(next.state, next.state)] * T::default_epsilon().sqrt()).then(|| gap / speed);
            let leaving = active
                .iter()
                .enumerate()
                .filter(|(k, _)| response[*k] > T::zero())
                .map(|(k, one)| (k, one.multiplier / response[k]))
                .min_by(|a, b| a.1.partial_cmp(&b.1).unwrap_or(core::cmp::Ordering::Equal));
            let (step, leaves) = match (full, leaving) {
                (Some(full), Some((k, partial))) if partial < full => (partial, Some(k)),
                (Some(full), _) => (full, None),
                (None, Some((k, partial))) => (partial, Some(k)),
                (None, None) => {
                    stuck[next.state] = true;
                    break;
                }
            };
            if full.is_some() {
                for (x, direction) in x.iter_mut().zip(direction.iter()) {
                    *x += *direction * step;
                }
            }
            for (one, response) in active.iter_mut().zip(response.iter()) {
                one.multiplier -= *response * step;
            }
            next.multiplier += step;
            if let Some(k) = leaves {
                active.remove(k);
            } else {
                active.push(next);
                break;
            }
        }
    }
    // To the bound exactly.
    for (x, (lower, upper)) in x.iter_mut().zip(lower.iter().zip(upper)) {
        *x = if *x < *lower {
            *lower
        } else if *x > *upper {
            *upper
        } else {
            *x
        };
    }
    for one in &active {
        x[one.state] = if one.sign > T::zero() { lower[one.state] } else { upper[one.state] };
    }
    x
}

/// The bound that x violates by the most standard deviations, if it violates one that is not active.
fn most_violated<T: RealField + Copy>(
    x: &[T],
    p: &DMatrix<T>,
    (lower, upper): (&[T], &[T]),
    stuck: &[bool],
    active: &[Active<T>],
) -> Option<Active<T>> {
    let mut worst: Option<(T, Active<T>)> = None;
    for state in (0..x.len()).filter(|&i| !stuck[i] && active.iter().all(|one| one.state != i)) {
        let deviation = p[(state, state)].max(T::zero()).sqrt();
        for (gap, sign) in [(lower[state] - x[state], T::one()), (x[state] - upper[state], -T::one())] {
            let is_violated = gap > T::zero();
            if !is_violated {
                continue;
            }
            // A state without variance is the last.
            let share = if deviation > T::zero() { gap / deviation } else { T::zero() };
            if worst.is_none_or(|(other, _)| share > other) {
                worst = Some((share, Active { state, sign, multiplier: T::zero() }));
            }
        }
    }
    worst.map(|(_, bound)| bound)
}

/// The direction of x towards a bound along the active ones, `P n - P N r`, and the response `r = (N' P N)^-1 N' P n`
/// of their multipliers; none if N' P N has no factor.
fn towards<T: RealField + Copy>(
    p: &DMatrix<T>,
    active: &[Active<T>],
    next: Active<T>,
) -> Option<(DVector<T>, DVector<T>)> {
    let count = active.len();
    let mut direction = p.column(next.state) * next.sign;
    if count == 0 {
        return Some((direction, DVector::zeros(0)));
    }
    let inner =
        DMatrix::from_fn(count, count, |i, j| active[i].sign * active[j].sign * p[(active[i].state, active[j].state)]);
    let right = DVector::from_fn(count, |i, _| active[i].sign * direction[active[i].state]);
    let response = Factor::new(&inner)?.solve(&right);
    for (one, response) in active.iter().zip(response.iter()) {
        direction -= p.column(one.state) * (one.sign * *response);
    }
    Some((direction, response))
}
