//! Filters of a plant in discrete time whose process and measurement noise are correlated.
//!
//! The noise of a measurement and that of the step which follows it have the cross-covariance S:
//!
//! ```text
//! x(k+1) = f(x(k), u(k)) + w(k),   y(k) = h(x(k), u(k)) + v(k),   E w w' = W,   E v v' = V,   E w(k) v(k)' = S
//! ```
//!
//! With `K = S V^-1` the noise `w - K v` is not correlated with v, and `v = y - h(x)`. The same plant with noises that
//! are not correlated is
//!
//! ```text
//! x(k+1) = f(x, u) + K (y(k) - h(x, u)) + w~(k),   E w~ w~' = W - K S'
//! ```
//!
//! The update is that without S; the prediction, by this plant from the estimate after the update, uses the measurement
//! again. For a linear plant it is the Kalman filter of correlated noises: its predictor has the gain
//! `(A P C' + S) (C P C' + V)^-1`. The extended filter linearises f and h where its prediction begins, the unscented
//! one has the images of its sigma points under both. Outputs without a measurement, and those that a gate rejects, are
//! left out of K: of the others, S has the columns and V the rows and columns. A V of the sample in place of the
//! constant one keeps the correlations, and S is scaled as it is.
//!
//! Source: Y. Bar-Shalom, X. R. Li and T. Kirubarajan, Estimation with Applications to Tracking and Navigation, Wiley
//! 2001, section 8.3 (cross-correlation of the noises at the same time).

extern crate alloc;

use alloc::vec;
use alloc::vec::Vec;

use luenberger_plants::{Column, Differentiable, Dimensions, Plant, Shape};
use nalgebra::{DMatrix, DVector, Dyn, RealField, SymmetricEigen, convert};

use crate::adapted::{AdaptableFilter, AdaptedFilter, NoisesAlong};
use crate::angles;
use crate::covariance_filter::{CovarianceFilter, update_and_finish};
use crate::error::ObserverError;
use crate::gaussian::covariance;
use crate::observer::{ObserverDimensions, SampledObserver};

/// The plant `x+ = f(t, x, u) + K (y - h(t, x, u))`, with y and K among its inputs: u (m), y (p), K (n x p by columns).
#[derive(Clone, Debug)]
pub struct DecorrelatedPlant<S, T: RealField> {
    plant: S,
    turns: angles::Turns<T, Dyn>,
}

impl<T: RealField + Copy, S: Shape> DecorrelatedPlant<S, T> {
    /// The plant with y and K as inputs.
    pub fn new(plant: S) -> Self {
        Self { plant, turns: None }
    }

    /// The plant whose outputs with a full turn are angles, 0 for the others: their differences are within half a turn.
    ///
    /// # Errors
    /// [`ObserverError::Table`] for another length, [`ObserverError::NotPositive`] for a turn that is negative or not
    /// finite.
    pub fn with_angles(self, turns: DVector<T>) -> Result<Self, ObserverError> {
        let turns = angles::checked(turns, self.plant.dimensions().outputs)?;
        Ok(Self { turns, ..self })
    }

    /// u, y and K; nothing of an input that is too short.
    fn parts<'a>(&self, input: &'a DVector<T>) -> Option<(DVector<T>, &'a [T], &'a [T])> {
        let Dimensions { states, inputs, outputs } = self.plant.dimensions();
        let (u, rest) = input.as_slice().split_at_checked(inputs)?;
        let (y, k) = rest.split_at_checked(outputs)?;
        (k.len() == states * outputs).then(|| (DVector::from_column_slice(u), y, k))
    }
}

/// Adds `K e` by its columns.
fn add_product<T: RealField + Copy>(x: &mut DVector<T>, k: &[T], e: &DVector<T>) {
    let n = x.nrows();
    for (j, e) in e.iter().enumerate() {
        for i in 0..n {
            x[i] += k[j * n + i] * *e;
        }
    }
}

impl<S: Shape, T: RealField> Shape for DecorrelatedPlant<S, T> {
    fn dimensions(&self) -> Dimensions {
        let Dimensions { states, inputs, outputs } = self.plant.dimensions();
        Dimensions { states, inputs: inputs + outputs * (states + 1), outputs }
    }
}

impl<S, T: RealField + Copy> Plant<T> for DecorrelatedPlant<S, T>
where
    S: Plant<T, State = DVector<T>, Input = DVector<T>, Output = DVector<T>>,
{
    type State = DVector<T>;
    type Input = DVector<T>;
    type Output = DVector<T>;

    fn derivative(&self, t: T, x: &DVector<T>, input: &DVector<T>) -> DVector<T> {
        let Some((u, y, k)) = self.parts(input) else { return x.map(|_| convert(f64::NAN)) };
        let mut next = self.plant.derivative(t, x, &u);
        if k.iter().any(|entry| *entry != T::zero()) {
            let y = DVector::from_column_slice(y);
            add_product(&mut next, k, &angles::difference(&self.turns, &y, &self.plant.output(t, x, &u)));
        }
        next
    }

    fn output(&self, t: T, x: &DVector<T>, input: &DVector<T>) -> DVector<T> {
        match self.parts(input) {
            Some((u, ..)) => self.plant.output(t, x, &u),
            None => DVector::repeat(self.plant.dimensions().outputs, convert(f64::NAN)),
        }
    }
}

impl<S, T: RealField + Copy> Differentiable<T, Dyn, Dyn, Dyn> for DecorrelatedPlant<S, T>
where
    S: Differentiable<T, Dyn, Dyn, Dyn>,
{
    fn directional(&self, t: T, x: &DVector<T>, input: &DVector<T>, v: &DVector<T>) -> (DVector<T>, DVector<T>) {
        let nan = || x.map(|_| convert(f64::NAN));
        let Some((u, _, k)) = self.parts(input) else { return (nan(), nan()) };
        let mut along = self.plant.directional(t, x, &u, v).1;
        if k.iter().any(|entry| *entry != T::zero()) {
            add_product(&mut along, k, &-self.plant.output_directional(t, x, &u, v).1);
        }
        (self.derivative(t, x, input), along)
    }

    fn output_directional(&self, t: T, x: &DVector<T>, input: &DVector<T>, v: &DVector<T>) -> (DVector<T>, DVector<T>) {
        match self.parts(input) {
            Some((u, ..)) => self.plant.output_directional(t, x, &u, v),
            None => (self.output(t, x, input), self.output(t, x, input)),
        }
    }

    fn state_jacobian(&self, t: T, x: &DVector<T>, input: &DVector<T>) -> DMatrix<T> {
        let (n, p) = (x.nrows(), self.plant.dimensions().outputs);
        let Some((u, _, k)) = self.parts(input) else { return DMatrix::repeat(n, n, convert(f64::NAN)) };
        let f = self.plant.state_jacobian(t, x, &u);
        if k.iter().all(|entry| *entry == T::zero()) {
            return f;
        }
        f - DMatrix::from_column_slice(n, p, k) * self.plant.output_jacobian(t, x, &u)
    }

    fn output_jacobian(&self, t: T, x: &DVector<T>, input: &DVector<T>) -> DMatrix<T> {
        match self.parts(input) {
            Some((u, ..)) => self.plant.output_jacobian(t, x, &u),
            None => DMatrix::repeat(self.plant.dimensions().outputs, x.nrows(), convert(f64::NAN)),
        }
    }

    // Only the steps of a plant in discrete time.
    fn is_linear_between_samples(&self) -> bool {
        false
    }
}

/// A filter of correlated noises; see the [module](self).
///
/// Its state has that of the filter inside first, and then what the next prediction takes of the last measurement: y,
/// K and S, zero for outputs that were not measured.
///
/// ```
/// use luenberger_observers::correlated::{CorrelatedFilter, DecorrelatedPlant};
/// use luenberger_observers::{AdaptedFilter, ExtendedKalmanFilter, NoiseModel, SampledObserver};
/// use luenberger_plants::StateSpace;
/// use nalgebra::{dmatrix, dvector};
/// // x+ = x/2 + w, y = x + w: the measurement says what the noise of the next step is.
/// let plant = StateSpace::new(dmatrix![0.5], dmatrix![0.0], dmatrix![1.0])?;
/// let noises = NoiseModel { w: dmatrix![1.0], v: dmatrix![1.0], p0: dmatrix![0.0] };
/// let filter = ExtendedKalmanFilter::discrete(DecorrelatedPlant::new(plant), noises, 1.0)?;
/// let filter = CorrelatedFilter::new(AdaptedFilter::new(filter, ()), dmatrix![1.0])?;
/// let (u, y) = (dvector![0.0], dvector![3.0]);
/// let mut state = filter.initial(0.0, &dvector![2.0], &u, &y);
/// filter.step(0.0, &mut state, &u, &y);
/// // 2/2 + (3 - 2), without an error.
/// assert_eq!(filter.estimate(&state), dvector![2.0]);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug)]
pub struct CorrelatedFilter<F, T: RealField, A> {
    filter: AdaptedFilter<F, T, A>,
    s: DMatrix<T>,
    /// The diagonal of the constant V.
    variances: Vec<T>,
}

/// That `[W S; S' V]` is positive semidefinite, for W (n x n), V (p x p) and S (n x p); decided in units in which its
/// diagonal is 1.
///
/// # Errors
/// [`ObserverError::Matrix`] for other shapes and entries that are not finite, [`ObserverError::NotSymmetric`],
/// [`ObserverError::NotDefinite`].
pub fn check_joint_covariance<T: RealField + Copy>(
    w: &DMatrix<T>,
    v: &DMatrix<T>,
    s: &DMatrix<T>,
) -> Result<(), ObserverError> {
    let (n, p) = (w.nrows(), v.nrows());
    luenberger_plants::error::check_matrix("S", s, (n, p))?;
    let mut joint = DMatrix::zeros(n + p, n + p);
    joint.view_mut((0, 0), (n, n)).copy_from(w);
    joint.view_mut((n, n), (p, p)).copy_from(v);
    joint.view_mut((0, n), (n, p)).copy_from(s);
    joint.view_mut((n, 0), (p, n)).copy_from(&s.transpose());
    let mut unit: Vec<T> = joint.diagonal().iter().map(|d| if *d > T::zero() { d.sqrt() } else { T::one() }).collect();
    // What has no variance has no covariance: the largest that it has becomes 1.
    for i in (0..n + p).filter(|i| joint[(*i, *i)].is_zero()) {
        let largest = (0..n + p).fold(T::zero(), |largest: T, j| largest.max(joint[(i, j)].abs() / unit[j]));
        unit[i] = if largest > T::zero() { largest } else { T::one() };
    }
    let balanced = DMatrix::from_fn(n + p, n + p, |i, j| joint[(i, j)] / unit[i] / unit[j]);
    covariance("[W S; S' V]", balanced, n + p, false).map(|_| ())
}

impl<T, F, A> CorrelatedFilter<F, T, A>
where
    T: RealField + Copy,
    F: AdaptableFilter<T, Input = DVector<T>, Output = DVector<T>, Estimate = DVector<T>>,
    A: NoisesAlong<T>,
{
    /// The filter of a [`DecorrelatedPlant`] in discrete time with the cross-covariance S, n x p.
    ///
    /// # Errors
    /// [`ObserverError::NotDiscrete`]; those of [`check_joint_covariance`]; [`ObserverError::Table`] if the plant of
    /// the filter has no inputs for y and K.
    pub fn new(filter: AdaptedFilter<F, T, A>, s: DMatrix<T>) -> Result<Self, ObserverError> {
        if !filter.is_discrete() {
            return Err(ObserverError::NotDiscrete { what: "correlated noises" });
        }
        let size = filter.dimensions();
        let (n, p) = (size.estimate, size.outputs);
        let (w, v) = filter.inner().noises();
        let v = DMatrix::from_vec(p, p, v);
        check_joint_covariance(&DMatrix::from_vec(n, n, w), &v, &s)?;
        if size.inputs < p * (n + 1) {
            let expected = p * (n + 1);
            return Err(ObserverError::Table { what: "inputs for y and K", expected, found: size.inputs });
        }
        Ok(Self { filter, s, variances: v.diagonal().as_slice().to_vec() })
    }

    /// The filter inside, with its noises along the way.
    pub fn inner(&self) -> &AdaptedFilter<F, T, A> {
        &self.filter
    }

    /// S.
    pub fn cross_covariance(&self) -> &DMatrix<T> {
        &self.s
    }

    /// The same filter with other noises along its way.
    #[must_use]
    pub fn with_noises_along(self, along: A) -> Self {
        Self { filter: self.filter.with_noises_along(along), ..self }
    }

    /// Length of the state of the filter inside.
    fn own_length(&self) -> usize {
        self.filter.dimensions().state
    }

    /// The state of the filter inside.
    fn own(&self, state: &DVector<T>) -> Option<F::State> {
        state.as_slice().get(..self.own_length()).and_then(F::State::try_from_slice)
    }

    fn put(state: &mut DVector<T>, own: &F::State) {
        let own = own.as_slice();
        state.as_mut_slice()[..own.len()].copy_from_slice(own);
    }

    /// The input of the plant inside with what follows it.
    fn input(&self, u: &DVector<T>, taken: Option<&[T]>) -> DVector<T> {
        let mut input = DVector::zeros(self.filter.dimensions().inputs);
        let (m, input_length) = (u.nrows(), input.nrows());
        if m <= input_length {
            input.rows_mut(0, m).copy_from(u);
            for (entry, taken) in input.iter_mut().skip(m).zip(taken.unwrap_or_default()) {
                *entry = *taken;
            }
        }
        input
    }

    /// Whether the columns have the lengths of the filter.
    fn fits(&self, state: &DVector<T>, u: &DVector<T>) -> bool {
        let size = self.dimensions();
        (state.nrows(), u.nrows()) == (size.state, size.inputs)
    }

    /// Keeps y, K and S of the outputs that an update with this V uses.
    fn keep(&self, state: &mut DVector<T>, y: &DVector<T>, used: &[usize], v: &DMatrix<T>) {
        let (n, p, own) = (self.s.nrows(), self.s.ncols(), self.own_length());
        let scaled = DMatrix::from_fn(n, used.len(), |i, l| {
            self.s[(i, used[l])] * (v[(used[l], used[l])] / self.variances[used[l]]).sqrt()
        });
        let of_used = DMatrix::from_fn(used.len(), used.len(), |k, l| v[(used[k], used[l])]);
        // It is positive definite, as V is.
        let Some(factor) = of_used.cholesky() else { return };
        let gain = factor.solve(&scaled.transpose());
        let taken = &mut state.as_mut_slice()[own..];
        for (l, j) in used.iter().enumerate() {
            taken[*j] = y[*j];
            for i in 0..n {
                taken[p + j * n + i] = gain[(l, i)];
                taken[p * (n + 1) + j * n + i] = scaled[(i, l)];
            }
        }
    }

    /// The filter with `W - K S'` and the input of the next prediction.
    fn at_prediction(&self, t: T, state: &DVector<T>, own: &F::State, u: &DVector<T>) -> Option<(F, DVector<T>)> {
        let (n, p) = (self.s.nrows(), self.s.ncols());
        let taken = &state.as_slice()[self.own_length()..];
        let input = self.input(u, Some(&taken[..p * (n + 1)]));
        let filter = self.filter.at_prediction(t, own, &input)?;
        let (gain, s) = (
            DMatrix::from_column_slice(n, p, &taken[p..p * (n + 1)]),
            DMatrix::from_column_slice(n, p, &taken[p * (n + 1)..]),
        );
        if s.iter().all(|entry| *entry == T::zero()) {
            return Some((filter, input));
        }
        let w = DMatrix::from_vec(n, n, filter.noises().0);
        let less = without(&w, &(gain * s.transpose()));
        Some((filter.with_noises(Some(less.as_slice()), None).ok()?, input))
    }

    fn finish(&self, t: T, state: &mut DVector<T>, u: &DVector<T>) {
        if !self.advance(t, state, u, self.period()) {
            let n = self.filter.dimensions().estimate;
            state.rows_mut(0, n).fill(convert(f64::NAN));
        }
    }
}

/// `W - R`, which is positive semidefinite but for rounding, without its eigenvalues that are rounding, in units in
/// which the diagonal of W is 1.
fn without<T: RealField + Copy>(w: &DMatrix<T>, r: &DMatrix<T>) -> DMatrix<T> {
    let n = w.nrows();
    let unit: Vec<T> = w.diagonal().iter().map(|d| if *d > T::zero() { d.sqrt() } else { T::one() }).collect();
    let half: T = convert(0.5);
    let scaled = DMatrix::from_fn(n, n, |i, j| (w[(i, j)] - half * (r[(i, j)] + r[(j, i)])) / unit[i] / unit[j]);
    let least = T::default_epsilon() * convert::<f64, T>(8.0 * (n * n) as f64);
    let mut eigen = SymmetricEigen::new(scaled.clone());
    if eigen.eigenvalues.iter().all(|value| *value > least) {
        return DMatrix::from_fn(n, n, |i, j| scaled[(i, j)] * unit[i] * unit[j]);
    }
    eigen.eigenvalues.apply(|value| {
        if *value <= least {
            *value = T::zero();
        }
    });
    let clean = eigen.recompose();
    DMatrix::from_fn(n, n, |i, j| half * (clean[(i, j)] + clean[(j, i)]) * unit[i] * unit[j])
}

impl<T, F, A> SampledObserver<T> for CorrelatedFilter<F, T, A>
where
    T: RealField + Copy,
    F: AdaptableFilter<T, Input = DVector<T>, Output = DVector<T>, Estimate = DVector<T>>,
    A: NoisesAlong<T>,
{
    type State = DVector<T>;
    type Input = DVector<T>;
    type Output = DVector<T>;
    type Estimate = DVector<T>;

    fn dimensions(&self) -> ObserverDimensions {
        let size = self.filter.dimensions();
        let (n, p) = (size.estimate, size.outputs);
        ObserverDimensions { state: size.state + p * (2 * n + 1), inputs: size.inputs - p * (n + 1), ..size }
    }

    fn period(&self) -> T {
        self.filter.period()
    }

    update_and_finish!(T);

    fn estimate(&self, state: &Self::State) -> Self::Estimate {
        DVector::from_column_slice(&state.as_slice()[..self.filter.dimensions().estimate])
    }

    fn estimate_into(&self, state: &[T], estimate: &mut [T]) -> bool {
        self.filter.estimate_into(&state[..self.own_length().min(state.len())], estimate)
    }

    fn initial(&self, t: T, estimate: &Self::Estimate, u: &Self::Input, y: &Self::Output) -> Self::State {
        let own = self.filter.initial(t, estimate, &self.input(u, None), y);
        let mut state = DVector::zeros(self.dimensions().state);
        Self::put(&mut state, &own);
        state
    }
}

impl<T, F, A> CovarianceFilter<T> for CorrelatedFilter<F, T, A>
where
    T: RealField + Copy,
    F: AdaptableFilter<T, Input = DVector<T>, Output = DVector<T>, Estimate = DVector<T>>,
    A: NoisesAlong<T>,
{
    fn is_discrete(&self) -> bool {
        true
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
        if !self.fits(state, u) || y.nrows() != self.s.ncols() {
            return None;
        }
        let (mut own, input) = (self.own(state)?, self.input(u, None));
        let of_sample = self.filter.at_sample(t, &own, &input)?;
        let is_used = |j: &usize| {
            let is_measured = measured.get(*j).copied().unwrap_or(true);
            is_measured && y[*j].is_finite() && !of_sample.rejects_output(t, &own, &input, y, *j)
        };
        let used: Vec<usize> = (0..y.nrows()).filter(is_used).collect();
        let found = self.filter.measure_with_determinant(t, &mut own, &input, y, measured)?;
        Self::put(state, &own);
        self.keep(state, y, &used, &DMatrix::from_vec(y.nrows(), y.nrows(), of_sample.noises().1));
        Some(found)
    }

    fn innovation(&self, t: T, state: &Self::State, u: &Self::Input, y: &Self::Output) -> Self::Output {
        match self.own(state) {
            Some(own) => self.filter.innovation(t, &own, &self.input(u, None), y),
            None => y.map(|_| convert(f64::NAN)),
        }
    }

    fn advance(&self, t: T, state: &mut Self::State, u: &Self::Input, duration: T) -> bool {
        let n = self.s.nrows();
        self.advance_across(t, state, u, duration, &mut vec![T::zero(); n * n])
    }

    fn advance_across(&self, t: T, state: &mut Self::State, u: &Self::Input, duration: T, cross: &mut [T]) -> bool {
        if !self.fits(state, u) {
            return false;
        }
        let Some(mut own) = self.own(state) else { return false };
        let Some((filter, input)) = self.at_prediction(t, state, &own, u) else { return false };
        let has_result = filter.advance_across(t, &mut own, &input, duration, cross);
        if has_result {
            state.fill(T::zero());
            Self::put(state, &own);
        }
        has_result
    }

    fn rejects_output(&self, t: T, state: &Self::State, u: &Self::Input, y: &Self::Output, output: usize) -> bool {
        self.own(state).is_some_and(|own| self.filter.rejects_output(t, &own, &self.input(u, None), y, output))
    }
}
