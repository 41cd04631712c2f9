//! Filters of measurements that arrive late: what a sensor says at t was true at `t - d`.
//!
//! The filter keeps what it knew at the times of the longest delay: the states before its measurements, the inputs, and
//! what was measured. A measurement that is late goes back to its time s = t - d; from there the updates and
//! predictions are made again with it, up to now:
//!
//! ```text
//! (xhat, P)(s-)  ->  update by y(t), h at s  ->  predictions and updates of all times after s  ->  (xhat, P)(t)
//! ```
//!
//! It is the filter that got every measurement at its own time: the estimate at t is that of a log in which the late
//! ones stand where they were true, and which ends with what has arrived by t. Between two stored times the state at s
//! is that of a prediction, whose interval is divided there; for a plant in discrete time s has to be one of its
//! samples. A measurement from before the stored times is passed over.
//!
//! An update returns the innovation of what it got, each at its time: the late ones first, and those of now after them.
//! Their squares are added. The likelihood of a log is not the sum of those of the updates, because an early update did
//! not have the late measurement: it is that of the log with the measurements at their times.
//!
//! A step costs the steps since the oldest late measurement again, at most as many as are kept.
//!
//! Source: Y. Bar-Shalom, X. R. Li and T. Kirubarajan, Estimation with Applications to Tracking and Navigation, Wiley
//! 2001, section 6.6 (out-of-sequence measurements), where reprocessing is the optimal solution.

extern crate alloc;

use alloc::vec;
use alloc::vec::Vec;

use luenberger_plants::Column;
use nalgebra::{DVector, RealField, convert};

use crate::covariance_filter::{CovarianceFilter, update_and_finish};
use crate::error::ObserverError;
use crate::observer::{ObserverDimensions, SampledObserver};

/// Two times are one if they are no further apart than this share of the period.
const SAME: f64 = 1e-6;

/// A filter of outputs of which some are late; see the [module](self).
///
/// Its state has that of the filter inside first, and then what is kept.
///
/// ```
/// use luenberger_observers::delayed::DelayedFilter;
/// use luenberger_observers::{CovarianceFilter, KalmanFilter, KalmanModel, SampledObserver};
/// use nalgebra::{Matrix1, Vector1, dvector};
/// # use nalgebra::{DMatrix, DVector};
/// // A sum of inputs, measured with a delay of two samples.
/// let one = DMatrix::from_element(1, 1, 1.0);
/// let [ad, bd, c, w, v, p0] = [(); 6].map(|()| one.clone());
/// let model = KalmanModel { ad, bd, c, w, v, p0, period: 0.1 };
/// let filter = DelayedFilter::new(KalmanFilter::new(model)?, &[0.2], 3)?;
/// let (zero, mut state) = (dvector![0.0], filter.initial(0.0, &dvector![0.0], &dvector![0.0], &dvector![0.0]));
/// for (k, y) in [f64::NAN, f64::NAN, 0.5].into_iter().enumerate() {
///     let t = 0.1 * k as f64;
///     filter.measure(t, &mut state, &dvector![1.0], &dvector![y], &[y.is_finite()]);
///     assert_eq!(filter.estimate(&state), dvector![k as f64 + if k == 2 { 0.25 } else { 0.0 }]);
///     filter.advance(t, &mut state, &dvector![1.0], 0.1);
/// }
/// # Ok::<(), luenberger_observers::ObserverError>(())
/// ```
#[derive(Clone, Debug)]
pub struct DelayedFilter<F, T> {
    filter: F,
    /// Of each output.
    delays: Vec<T>,
    /// Most times that are kept.
    most: usize,
}

/// What is kept of a time: the state before its measurements, the input from then on, and what was measured.
#[derive(Clone, Debug)]
struct Kept<T> {
    t: T,
    before: Vec<T>,
    u: Vec<T>,
    y: Vec<T>,
    measured: Vec<bool>,
}

/// Where an output is expected.
struct Expecting<T, F: SampledObserver<T>> {
    t: T,
    state: F::State,
    u: F::Input,
    /// Whether its time is known, and this is it.
    is_known: bool,
}

/// The state, taken apart: that of the filter, and what is kept, from the oldest time on.
struct Parts<T> {
    now: Vec<T>,
    kept: Vec<Kept<T>>,
}

impl<T: RealField + Copy, F: CovarianceFilter<T>> DelayedFilter<F, T> {
    /// The filter of outputs with these delays, p nonnegative numbers, that keeps so many times: at least one more than
    /// there are updates and predictions during the longest delay.
    ///
    /// # Errors
    /// [`ObserverError::Table`] for another number of delays, [`ObserverError::TooFew`] for less than two times,
    /// [`ObserverError::NotPositive`] for a delay that is negative or not finite.
    pub fn new(filter: F, delays: &[T], most: usize) -> Result<Self, ObserverError> {
        let (expected, found) = (filter.dimensions().outputs, delays.len());
        if found != expected {
            return Err(ObserverError::Table { what: "delays of the outputs", expected, found });
        }
        if most < 2 {
            return Err(ObserverError::TooFew { what: "times that are kept", least: 2, found: most });
        }
        match delays.iter().find(|delay| !(delay.is_finite() && **delay >= T::zero())) {
            Some(delay) => Err(ObserverError::NotPositive { what: "a delay", value: delay.to_subset_unchecked() }),
            None => Ok(Self { filter, delays: delays.to_vec(), most }),
        }
    }

    /// The filter inside, whose measurements are all of now.
    pub fn inner(&self) -> &F {
        &self.filter
    }

    /// Most times that are kept.
    pub fn times_kept(&self) -> usize {
        self.most
    }

    /// The delays of the outputs.
    pub fn delays(&self) -> &[T] {
        &self.delays
    }

    /// The same filter that keeps at most so many times.
    ///
    /// # Errors
    /// [`ObserverError::TooFew`] for less than two.
    pub fn keeping(&self, most: usize) -> Result<Self, ObserverError>
    where
        F: Clone,
    {
        Self::new(self.filter.clone(), &self.delays, most)
    }

    /// The state of the filter inside.
    fn own(&self, state: &DVector<T>) -> Option<F::State> {
        state.as_slice().get(..self.filter.dimensions().state).and_then(F::State::try_from_slice)
    }

    /// Numbers of a time that is kept.
    fn width(&self) -> usize {
        let size = self.filter.dimensions();
        1 + size.state + size.inputs + 2 * size.outputs
    }

    fn parts(&self, state: &DVector<T>) -> Option<Parts<T>> {
        let size = self.filter.dimensions();
        let numbers = state.as_slice();
        if numbers.len() != self.dimensions().state {
            return None;
        }
        let (now, rest) = numbers.split_at(size.state);
        let (count, rest) = rest.split_first()?;
        let count = (0..self.most).take_while(|k| convert::<f64, T>(*k as f64 + 0.5) < *count).count();
        let one = |numbers: &[T]| {
            let (t, numbers) = numbers.split_first()?;
            let (before, numbers) = numbers.split_at(size.state);
            let (u, numbers) = numbers.split_at(size.inputs);
            let (y, measured) = numbers.split_at(size.outputs);
            let measured = measured.iter().map(|flag| *flag > T::zero()).collect();
            Some(Kept { t: *t, before: before.to_vec(), u: u.to_vec(), y: y.to_vec(), measured })
        };
        let kept = rest.chunks_exact(self.width()).take(count).map(one).collect::<Option<_>>()?;
        Some(Parts { now: now.to_vec(), kept })
    }

    /// Puts the parts together again, without the times that no delay reaches from t.
    fn join(&self, t: T, mut parts: Parts<T>) -> DVector<T> {
        let longest = self.delays.iter().fold(T::zero(), |longest, delay| longest.max(*delay));
        let reach = t - longest + self.same();
        // The last time before what can still arrive is where its prediction begins.
        let needed = parts.kept.iter().rposition(|kept| kept.t <= reach).unwrap_or(0);
        let most = parts.kept.len().saturating_sub(self.most);
        parts.kept.drain(..needed.max(most));
        let mut state = parts.now;
        state.push(convert(parts.kept.len() as f64));
        for kept in parts.kept {
            state.push(kept.t);
            state.extend(kept.before);
            state.extend(kept.u);
            state.extend(kept.y);
            state.extend(kept.measured.into_iter().map(|flag| if flag { T::one() } else { T::zero() }));
        }
        state.resize(self.dimensions().state, T::zero());
        DVector::from_vec(state)
    }

    /// Whether input and measurement have the lengths of the filter.
    fn fits(&self, u: &[T], y: &[T]) -> bool {
        (u.len(), y.len()) == (self.filter.dimensions().inputs, self.delays.len())
    }

    fn same(&self) -> T {
        self.filter.period() * convert(SAME)
    }

    /// Keeps the time t, if it is not kept, and the input from then on.
    fn keep(&self, parts: &mut Parts<T>, t: T, u: &[T]) {
        match parts.kept.last_mut() {
            Some(last) if last.t >= t - self.same() => last.u = u.to_vec(),
            _ => parts.kept.push(Kept {
                t,
                before: parts.now.clone(),
                u: u.to_vec(),
                y: vec![T::zero(); self.delays.len()],
                measured: vec![false; self.delays.len()],
            }),
        }
    }

    /// The state of the filter after the measurements of a time that is kept, if it has some.
    fn updated(&self, kept: &Kept<T>) -> Option<F::State> {
        let (mut state, u, y) = columns::<T, F>(&kept.before, &kept.u, &kept.y)?;
        if kept.measured.contains(&true) {
            self.filter.measure(kept.t, &mut state, &u, &y, &kept.measured);
        }
        Some(state)
    }

    /// What was known before the measurements of every time after `first`, and now, with what is kept of `first`. False
    /// where a prediction has no result.
    fn again(&self, parts: &mut Parts<T>, first: usize) -> bool {
        for k in first..parts.kept.len() {
            let Some(mut state) = self.updated(&parts.kept[k]) else { return false };
            if k + 1 == parts.kept.len() {
                parts.now = state.as_slice().to_vec();
                return true;
            }
            let (t, duration) = (parts.kept[k].t, parts.kept[k + 1].t - parts.kept[k].t);
            let Some(u) = Column::try_from_slice(&parts.kept[k].u) else { return false };
            if !self.filter.advance(t, &mut state, &u, duration) {
                return false;
            }
            parts.kept[k + 1].before = state.as_slice().to_vec();
        }
        true
    }

    /// What is known of the time s: the entry of what is kept, with its place; a new one if s is between two. None if s
    /// is not among the stored times.
    fn known(&self, parts: &Parts<T>, s: T) -> Option<(usize, Kept<T>, bool)> {
        let place = parts.kept.iter().rposition(|kept| kept.t <= s + self.same())?;
        let from = &parts.kept[place];
        if s - from.t <= self.same() {
            return Some((place, from.clone(), true));
        }
        if self.filter.is_discrete() {
            return None;
        }
        let mut state = self.updated(from)?;
        let u = Column::try_from_slice(&from.u)?;
        let moves = self.filter.advance(from.t, &mut state, &u, s - from.t);
        let (none, flags) = (vec![T::zero(); self.delays.len()], vec![false; self.delays.len()]);
        let (before, u) = (state.as_slice().to_vec(), from.u.clone());
        moves.then_some((place + 1, Kept { t: s, before, u, y: none, measured: flags }, false))
    }

    /// The update by the outputs `late` that were true at `s`, which may be now; none if nothing is known of that time,
    /// or the update has no result.
    fn update_at(&self, parts: &mut Parts<T>, s: T, y: &[T], late: &[bool]) -> Option<(T, Option<T>)> {
        let (place, mut at, is_there) = self.known(parts, s)?;
        // What is new, after what was known of that time.
        let mut state = self.updated(&at)?;
        let (u, measurement) = (Column::try_from_slice(&at.u)?, Column::try_from_slice(y)?);
        let found = self.filter.measure_with_determinant(at.t, &mut state, &u, &measurement, late)?;
        for j in (0..y.len()).filter(|j| late[*j]) {
            (at.y[j], at.measured[j]) = (y[j], true);
        }
        let mut next = Parts { now: parts.now.clone(), kept: parts.kept.clone() };
        if is_there {
            next.kept[place] = at;
        } else {
            next.kept.insert(place, at);
        }
        if !self.again(&mut next, place) {
            return None;
        }
        *parts = next;
        Some(found)
    }

    /// The state, the input and the time at which output j of a measurement at t is expected; those of now where the
    /// filter does not know its time.
    fn expecting(&self, t: T, state: &DVector<T>, u: &F::Input, j: usize) -> Option<Expecting<T, F>> {
        let mut parts = self.parts(state)?;
        self.keep(&mut parts, t, u.as_slice());
        let delay = *self.delays.get(j)?;
        if delay > T::zero()
            && let Some((_, at, _)) = self.known(&parts, t - delay)
        {
            let (state, u) = (self.updated(&at)?, Column::try_from_slice(&at.u)?);
            return Some(Expecting { t: at.t, state, u, is_known: true });
        }
        let state = F::State::try_from_slice(&parts.now)?;
        Some(Expecting { t, state, u: u.clone(), is_known: delay == T::zero() })
    }

    /// The delays of the outputs that are measured, the longest first.
    fn longest_first(&self, measured: &[bool]) -> Vec<T> {
        let is_in = |j: &usize| measured[*j];
        let mut delays: Vec<T> = (0..self.delays.len()).filter(is_in).map(|j| self.delays[j]).collect();
        delays.sort_by(|a, b| b.partial_cmp(a).unwrap_or(core::cmp::Ordering::Equal));
        delays.dedup();
        delays
    }

    fn finish(&self, t: T, state: &mut DVector<T>, u: &F::Input) {
        if !self.advance(t, state, u, self.filter.period()) {
            state.fill(convert(f64::NAN));
        }
    }
}

/// The columns of a filter.
fn columns<T: RealField + Copy, F: CovarianceFilter<T>>(
    state: &[T],
    u: &[T],
    y: &[T],
) -> Option<(F::State, F::Input, F::Output)> {
    Some((F::State::try_from_slice(state)?, F::Input::try_from_slice(u)?, F::Output::try_from_slice(y)?))
}

impl<T: RealField + Copy, F: CovarianceFilter<T>> SampledObserver<T> for DelayedFilter<F, T> {
    type State = DVector<T>;
    type Input = F::Input;
    type Output = F::Output;
    type Estimate = F::Estimate;

    fn dimensions(&self) -> ObserverDimensions {
        let size = self.filter.dimensions();
        ObserverDimensions { state: size.state + 1 + self.most * self.width(), ..size }
    }

    fn period(&self) -> T {
        self.filter.period()
    }

    update_and_finish!(T);

    fn estimate(&self, state: &Self::State) -> Self::Estimate {
        let nan = || F::Estimate::from_slice(&vec![convert(f64::NAN); self.filter.dimensions().estimate]);
        self.own(state).map_or_else(nan, |own| self.filter.estimate(&own))
    }

    fn initial(&self, t: T, estimate: &Self::Estimate, u: &Self::Input, y: &Self::Output) -> Self::State {
        let own = self.filter.initial(t, estimate, u, y);
        self.join(t, Parts { now: own.as_slice().to_vec(), kept: Vec::new() })
    }
}

/// The innovation of a late output is that at its time. An output of a time that is not kept is rejected, as an outlier
/// is.
impl<T: RealField + Copy, F: CovarianceFilter<T>> CovarianceFilter<T> for DelayedFilter<F, T> {
    fn is_discrete(&self) -> bool {
        self.filter.is_discrete()
    }

    fn unit_vector_of(&self, state: usize) -> usize {
        self.filter.unit_vector_of(state)
    }

    fn covariance_into(&self, state: &Self::State, p: &mut [T]) -> bool {
        self.own(state).is_some_and(|own| self.filter.covariance_into(&own, p))
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
        let (mut parts, y) = (self.parts(state)?, y.as_slice());
        if !self.fits(u.as_slice(), y) {
            return None;
        }
        self.keep(&mut parts, t, u.as_slice());
        let is_measured = |j: usize| measured.get(j).copied().unwrap_or(true);
        let measured: Vec<bool> = (0..y.len()).map(is_measured).collect();
        let of = |delay: T| -> Vec<bool> { (0..y.len()).map(|j| measured[j] && self.delays[j] == delay).collect() };
        let mut sum: Option<(T, Option<T>)> = None;
        for delay in self.longest_first(&measured) {
            let found = self.update_at(&mut parts, t - delay, y, &of(delay));
            sum = match (sum, found) {
                (Some((square, determinant)), Some((more, other))) => {
                    Some((square + more, determinant.zip(other).map(|(a, b)| a + b)))
                }
                (sum, found) => sum.or(found),
            };
        }
        if sum.is_some() {
            *state = self.join(t, parts);
        }
        sum
    }

    fn innovation(&self, t: T, state: &Self::State, u: &Self::Input, y: &Self::Output) -> Self::Output {
        let nan: T = convert(f64::NAN);
        let of = |j: usize| {
            let Expecting { t, state, u, .. } = self.expecting(t, state, u, j)?;
            self.filter.innovation(t, &state, &u, y).as_slice().get(j).copied()
        };
        let entries: Vec<T> = (0..y.as_slice().len()).map(|j| of(j).unwrap_or(nan)).collect();
        F::Output::from_slice(&entries)
    }

    fn advance(&self, t: T, state: &mut Self::State, u: &Self::Input, duration: T) -> bool {
        let Some(mut parts) = self.parts(state) else { return false };
        self.keep(&mut parts, t, u.as_slice());
        let Some(mut now) = F::State::try_from_slice(&parts.now) else { return false };
        let moves = self.filter.advance(t, &mut now, u, duration);
        if moves {
            parts.now = now.as_slice().to_vec();
            *state = self.join(t + duration, parts);
        }
        moves
    }

    /// Not for a smoother, to which late measurements mean nothing: false.
    fn advance_across(
        &self,
        _t: T,
        _state: &mut Self::State,
        _u: &Self::Input,
        _duration: T,
        _cross: &mut [T],
    ) -> bool {
        false
    }

    fn rejects_output(&self, t: T, state: &Self::State, u: &Self::Input, y: &Self::Output, output: usize) -> bool {
        let fits = self.fits(u.as_slice(), y.as_slice());
        let found = fits.then(|| self.expecting(t, state, u, output)).flatten();
        let Some(Expecting { t, state, u, is_known }) = found else { return false };
        !is_known || self.filter.rejects_output(t, &state, &u, y, output)
    }
}
