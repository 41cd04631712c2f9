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
//! xhat' = f(xhat, u),  P' = F P + P F' + W                          so many steps of the classical Runge-Kutta method
//! ```
//!
//! F and H come from the plant ([`Differentiable`]); nobody types them. Joseph's form keeps P positive semidefinite
//! whatever rounding does to K, and P is made exactly symmetric after both stages. Products and factorisation have one order
//! of operations (`dense`), so that the filter gives the same bits with sizes of either kind. Runge-Kutta steps are not a
//! congruence, so that sub-steps h/r with `|F| h/r` well above 1 may lose definiteness: choose r accordingly.
//!
//! What it is not: a proof. For a linear plant it is the Kalman filter, optimal and convergent when the plant is
//! detectable; for a nonlinear one it converges from small errors, and nothing is promised from large ones.
//!
//! Source: A. Gelb (ed.), Applied Optimal Estimation, MIT Press 1974, table 6.1-1; R. S. Bucy and P. D. Joseph,
//! Filtering for Stochastic Processes, 1968, for the form of the update.

use core::marker::PhantomData;

use luenberger_plants::error::check_matrix;
use luenberger_plants::{Column, Differentiable, Size};
use nalgebra::allocator::Allocator;
use nalgebra::{ComplexField, Const, DefaultAllocator, Dim, DimAdd, DimSum, OMatrix, OVector, RealField, U1, convert};

use crate::covariance_filter::CovarianceFilter;
use crate::dense::{Factor, times, times_transpose};
use crate::error::ObserverError;
use crate::kalman_on_slices::Sample;
use crate::observer::{ObserverDimensions, SampledObserver, put_slice, step_columns};
use crate::runge_kutta;
use crate::semidefinite::failing_pivot;

/// The state of the filter: estimate and covariance, one beside the other.
#[derive(Clone, Debug, PartialEq)]
pub struct GaussianEstimate<T: RealField + Copy, N: DimAdd<U1>>(OMatrix<T, N, DimSum<N, U1>>)
where
    DefaultAllocator: Allocator<N, DimSum<N, U1>>;

impl<T: RealField + Copy, N: DimAdd<U1>> GaussianEstimate<T, N>
where
    DefaultAllocator: Allocator<N, DimSum<N, U1>> + Allocator<N> + Allocator<N, N>,
{
    /// The belief with estimate xhat (length n) and covariance P (n x n).
    pub fn new(xhat: &OVector<T, N>, p: &OMatrix<T, N, N>) -> Self {
        let rows = xhat.shape_generic().0;
        Self(OMatrix::from_fn_generic(rows, rows.add(U1), |i, j| if j == 0 { xhat[i] } else { p[(i, j - 1)] }))
    }

    /// The estimate xhat.
    pub fn estimate(&self) -> OVector<T, N> {
        self.0.column(0).into_owned()
    }

    /// The covariance P that the filter believes its error to have.
    pub fn covariance(&self) -> OMatrix<T, N, N> {
        let rows = self.0.shape_generic().0;
        OMatrix::from_fn_generic(rows, rows, |i, j| self.0[(i, j + 1)])
    }
}

impl<T: RealField + Copy, N: DimAdd<U1>> Column<T> for GaussianEstimate<T, N>
where
    DefaultAllocator: Allocator<N, DimSum<N, U1>>,
{
    fn try_from_slice(entries: &[T]) -> Option<Self> {
        // n (n + 1) entries: n is the integer part of the root.
        let n = entries.len().isqrt();
        if n * (n + 1) != entries.len() || N::try_to_usize().is_some_and(|fixed| fixed != n) {
            return None;
        }
        let rows = N::from_usize(n);
        Some(Self(OMatrix::from_iterator_generic(rows, rows.add(U1), entries.iter().copied())))
    }

    fn as_slice(&self) -> &[T] {
        self.0.as_slice()
    }

    fn fixed_len() -> Option<usize> {
        N::try_to_usize().map(|n| n * (n + 1))
    }
}

/// The noise a filter is designed for, and its doubt at the start.
#[derive(Clone, Debug, PartialEq)]
pub struct NoiseModel<T: RealField + Copy, N: Dim, P: Dim>
where
    DefaultAllocator: Allocator<N, N> + Allocator<P, P>,
{
    /// Intensity W of the process noise, n x n, symmetric positive semidefinite, per unit of time.
    pub w: OMatrix<T, N, N>,
    /// Covariance V of one measurement, p x p, symmetric positive definite.
    pub v: OMatrix<T, P, P>,
    /// Covariance of the error of the initial estimate, n x n, symmetric positive semidefinite.
    pub p0: OMatrix<T, N, N>,
}

/// The continuous-discrete extended Kalman filter of a plant `S`; see the [module](self).
///
/// Fields are read through methods, because [`step`](SampledObserver::step) relies on what [`new`](Self::new) has
/// checked.
#[derive(Clone, Debug, PartialEq)]
pub struct ExtendedKalmanFilter<S, T: RealField + Copy, N: Dim, M: Dim, P: Dim>
where
    DefaultAllocator: Size<N, M, P>,
{
    pub(crate) plant: S,
    pub(crate) noises: NoiseModel<T, N, P>,
    pub(crate) h: T,
    /// Runge-Kutta steps between two samples; none for a plant in discrete time.
    pub(crate) substeps: Option<usize>,
    pub(crate) gate: Option<T>,
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
    /// The filter of `plant`, sampled with period `h`, with so many Runge-Kutta steps between samples.
    ///
    /// A step costs about `4 substeps (n derivatives along a direction + 2 n^3)` and one Cholesky factorisation of
    /// order p.
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
    /// let mut belief = filter.initial(0.0, &Vector4::zeros(), &u, &y);
    /// filter.step(0.0, &mut belief, &u, &y);
    /// // One sample is worth its weight: the doubt about x1 was 1, of the measurement 1e-4.
    /// assert!(belief.covariance()[(0, 0)] < 0.01);
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
        Ok(Self { plant, noises, h, substeps: Some(substeps), gate: None, inputs: PhantomData })
    }

    /// The filter of a plant in discrete time, `x+ = f(t, x, u) + w`, whose `derivative` is the next state; W is a
    /// covariance per sample, and between samples `xhat <- f(xhat, u)`, `P <- F P F' + W`.
    ///
    /// # Errors
    /// As [`new`](Self::new).
    pub fn discrete(plant: S, noises: NoiseModel<T, N, P>, h: T) -> Result<Self, ObserverError> {
        Ok(Self { substeps: None, ..Self::new(plant, noises, h, 1)? })
    }

    /// The filter that rejects outliers: an output whose innovation is beyond `gate` standard deviations, by the
    /// covariance that the filter computes, is treated as not measured. 4 or 5 are usual: of right measurements 6e-5
    /// and 6e-7 are beyond.
    ///
    /// A filter that is surer than it should be rejects right measurements, and may never recover: P(0) has to cover
    /// the first error, and W what the model does not know.
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

    /// Whether the gate rejects output `output` of the measurement y (length p) at time t, under the input u (length
    /// m); never without a [gate](Self::with_gate).
    pub fn rejects(
        &self,
        t: T,
        belief: &GaussianEstimate<T, N>,
        u: &OVector<T, M>,
        y: &OVector<T, P>,
        output: usize,
    ) -> bool
    where
        N: DimAdd<U1>,
        DefaultAllocator: Allocator<N, DimSum<N, U1>>,
    {
        let Some(gate) = self.gate else { return false };
        let innovation = y[output] - self.plant.output(t, &belief.estimate(), u)[output];
        innovation * innovation > gate * gate * self.innovation_covariance(t, belief, u)[(output, output)]
    }

    /// Runge-Kutta steps between two samples; none for a plant in [discrete time](Self::discrete).
    pub fn substeps(&self) -> Option<usize> {
        self.substeps
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

    /// The covariance `S = H P H' + V` that the innovation `y - h(xhat, u)` of a sample at time t has by this belief,
    /// p x p.
    pub fn innovation_covariance(&self, t: T, belief: &GaussianEstimate<T, N>, u: &OVector<T, M>) -> OMatrix<T, P, P>
    where
        N: DimAdd<U1>,
        DefaultAllocator: Allocator<N, DimSum<N, U1>>,
    {
        let c = self.plant.output_jacobian(t, &belief.estimate(), u);
        times_transpose(&times(&c, &belief.covariance()), &c) + &self.noises.v
    }

    /// `f(xhat)` and `F P + P F' + W`.
    fn slope(
        &self,
        t: T,
        xhat: &OVector<T, N>,
        p: &OMatrix<T, N, N>,
        u: &OVector<T, M>,
    ) -> (OVector<T, N>, OMatrix<T, N, N>) {
        let spread = spread(&self.plant.state_jacobian(t, xhat, u), p, &self.noises.w);
        (self.plant.derivative(t, xhat, u), spread)
    }
}

/// `F P + P F' + W`.
pub(crate) fn spread<T: RealField + Copy, N: Dim>(
    f: &OMatrix<T, N, N>,
    p: &OMatrix<T, N, N>,
    w: &OMatrix<T, N, N>,
) -> OMatrix<T, N, N>
where
    DefaultAllocator: Allocator<N, N>,
{
    let fp = times(f, p);
    fp.transpose() + fp + w
}

impl<S, T: RealField + Copy, N: DimAdd<U1>, M: Dim, P: Dim> ExtendedKalmanFilter<S, T, N, M, P>
where
    S: Differentiable<T, N, M, P>,
    DefaultAllocator: Size<N, M, P> + Allocator<N, DimSum<N, U1>>,
{
    /// From time t to `t + duration`, the input held: `xhat' = f(xhat, u)`, `P' = F P + P F' + W`. For a plant in
    /// [discrete time](Self::discrete) to the next sample, whatever the duration.
    ///
    /// The duration is nonnegative and need not be the period: a sample that comes late is waited for, one that is
    /// missed is passed. So many Runge-Kutta steps are taken as between two samples, whatever the duration: cut a long
    /// one.
    ///
    /// ```
    /// use luenberger_observers::{ExtendedKalmanFilter, NoiseModel, SampledObserver};
    /// use nalgebra::{Matrix1, Matrix2, Vector1, Vector2};
    /// let noises = NoiseModel { w: Matrix2::identity(), v: Matrix1::new(1.0), p0: Matrix2::identity() };
    /// let filter = ExtendedKalmanFilter::new(luenberger_plants::double_integrator(), noises, 0.1, 1)?;
    /// let (u, y) = (Vector1::new(0.0), Vector1::new(1.0));
    /// let mut belief = filter.initial(0.0, &Vector2::new(0.0, 1.0), &u, &y);
    /// // The first sample comes at 0.13, the time of the next is still 0.2.
    /// filter.predict(0.0, &mut belief, &u, 0.13);
    /// assert!((belief.estimate()[0] - 0.13).abs() < 1e-15);
    /// assert!(filter.update(0.13, &mut belief, &u, &y).is_some());
    /// filter.predict(0.13, &mut belief, &u, 0.07);
    /// # Ok::<(), luenberger_observers::ObserverError>(())
    /// ```
    pub fn predict(&self, t: T, belief: &mut GaussianEstimate<T, N>, u: &OVector<T, M>, duration: T) {
        let (mut xhat, mut p) = (belief.estimate(), belief.covariance());
        let Some(substeps) = self.substeps else {
            let f = self.plant.state_jacobian(t, &xhat, u);
            let mut p = times_transpose(&times(&f, &p), &f) + &self.noises.w;
            symmetrise(&mut p);
            *belief = GaussianEstimate::new(&self.plant.derivative(t, &xhat, u), &p);
            return;
        };
        let tau = duration / convert::<f64, T>(substeps as f64);
        for k in 0..substeps {
            let now = t + tau * convert::<f64, T>(k as f64);
            runge_kutta::step(now, tau, (&mut xhat, &mut p), |t, xhat, p| self.slope(t, xhat, p, u));
            symmetrise(&mut p);
        }
        *belief = GaussianEstimate::new(&xhat, &p);
    }

    /// The belief after the measurement y (length p) at time t under the input u, and what was new in it.
    ///
    /// `None`, and the belief as it was, if the innovation covariance S is not positive definite in floating point: an
    /// overflow, a NaN, a P that has lost its definiteness.
    pub fn update(
        &self,
        t: T,
        belief: &mut GaussianEstimate<T, N>,
        u: &OVector<T, M>,
        y: &OVector<T, P>,
    ) -> Option<Innovation<T, P>> {
        self.update_partial(t, belief, u, y, |_| true)
    }

    /// [`update`](Self::update) with those outputs alone for which `measured` is true, for sensors of different rates;
    /// the other entries of y are not read. What the [gate](Self::with_gate) rejects counts as not measured.
    pub fn update_partial(
        &self,
        t: T,
        belief: &mut GaussianEstimate<T, N>,
        u: &OVector<T, M>,
        y: &OVector<T, P>,
        measured: impl Fn(usize) -> bool,
    ) -> Option<Innovation<T, P>> {
        let xhat = belief.estimate();
        let h = self.plant.output_jacobian(t, &xhat, u);
        let innovation = y - self.plant.output(t, &xhat, u);
        let before = self.gate.map(|_| belief.clone());
        let rejected = |output| before.as_ref().is_some_and(|before| self.rejects(t, before, u, y, output));
        let accepted = |output| measured(output) && !rejected(output);
        correct::<T, N, M, P>(belief, h, innovation, self.noises.v.clone(), accepted)
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

    /// Update and prediction. A sample without a gain, where [`update`](ExtendedKalmanFilter::update) is `None`, is
    /// passed over.
    fn step(&self, t: T, state: &mut Self::State, u: &Self::Input, y: &Self::Output) {
        self.update(t, state, u, y);
        self.predict(t, state, u, self.h);
    }

    fn step_partial(&self, t: T, state: &mut Self::State, u: &Self::Input, y: &Self::Output, measured: &[bool]) {
        if measured.contains(&true) {
            self.update_partial(t, state, u, y, |output| measured.get(output).copied().unwrap_or(true));
        }
        self.predict(t, state, u, self.h);
    }

    fn step_into(&self, t: T, state: &mut [T], u: &[T], y: &[T], measured: &[bool]) -> bool {
        let dynamic = N::try_to_usize().is_none();
        dynamic && self.step_of_size(state, Sample { t, u, y, measured })
            || step_columns(self, t, state, (u, y), measured)
    }

    fn estimate(&self, state: &Self::State) -> Self::Estimate {
        state.estimate()
    }

    fn estimate_into(&self, state: &[T], estimate: &mut [T]) -> bool {
        // Before the covariance.
        state.get(..estimate.len()).is_some_and(|xhat| put_slice(xhat, estimate))
    }

    fn initial(&self, _t: T, estimate: &Self::Estimate, _u: &Self::Input, _y: &Self::Output) -> Self::State {
        GaussianEstimate::new(estimate, &self.noises.p0)
    }
}

impl<S, T: RealField + Copy, N: DimAdd<U1>, M: Dim, P: Dim> CovarianceFilter<T> for ExtendedKalmanFilter<S, T, N, M, P>
where
    S: Differentiable<T, N, M, P>,
    DefaultAllocator: Size<N, M, P> + Allocator<N, DimSum<N, U1>>,
{
    fn is_discrete(&self) -> bool {
        self.substeps.is_none()
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

    fn advance(&self, t: T, state: &mut Self::State, u: &Self::Input, duration: T) -> bool {
        self.predict(t, state, u, duration);
        true
    }

    /// P Phi', with `Phi' = F Phi` along the estimate, by the same Runge-Kutta steps.
    fn advance_across(&self, t: T, state: &mut Self::State, u: &Self::Input, duration: T, cross: &mut [T]) -> bool {
        let (mut xhat, p) = (state.estimate(), state.covariance());
        let order = xhat.shape_generic().0;
        let mut phi = OMatrix::<T, N, N>::identity_generic(order, order);
        if let Some(substeps) = self.substeps {
            let tau = duration / convert::<f64, T>(substeps as f64);
            for k in 0..substeps {
                let now = t + tau * convert::<f64, T>(k as f64);
                runge_kutta::step(now, tau, (&mut xhat, &mut phi), |t, xhat, phi| {
                    (self.plant.derivative(t, xhat, u), times(&self.plant.state_jacobian(t, xhat, u), phi))
                });
            }
        } else {
            phi = self.plant.state_jacobian(t, &xhat, u);
        }
        self.predict(t, state, u, duration);
        put_slice(times_transpose(&p, &phi).as_slice(), cross)
    }

    fn rejects_output(&self, t: T, state: &Self::State, u: &Self::Input, y: &Self::Output, output: usize) -> bool {
        self.rejects(t, state, u, y, output)
    }
}

/// What was new in a sample, and how unlikely the filter holds it to be.
#[derive(Clone, Debug, PartialEq)]
pub struct Innovation<T: RealField + Copy, P: Dim>
where
    DefaultAllocator: Allocator<P> + Allocator<P, P>,
{
    /// The innovation `y~ = y - h(xhat, u)` before the update, length p; zero for an output that was not measured.
    pub value: OVector<T, P>,
    /// Its covariance `S = H P H' + V`, p x p; the row and column of an output that was not measured are those of I.
    pub covariance: OMatrix<T, P, P>,
    /// `y~' S^-1 y~`: for the right noise and a linear plant chi-squared distributed, with as many degrees of freedom
    /// as outputs were measured.
    pub normalized_square: T,
}

/// The measurement update in Joseph's form, shared by the filters: H is `h` (p x n).
///
/// An output that is not measured gets a zero row of H, a zero innovation and a noise of its own, so that its column of
/// K is zero: what is left is the update by the other rows.
pub(crate) fn correct<T: RealField + Copy, N: DimAdd<U1>, M: Dim, P: Dim>(
    belief: &mut GaussianEstimate<T, N>,
    h: OMatrix<T, P, N>,
    innovation: OVector<T, P>,
    v: OMatrix<T, P, P>,
    measured: impl Fn(usize) -> bool,
) -> Option<Innovation<T, P>>
where
    DefaultAllocator: Size<N, M, P> + Allocator<N, DimSum<N, U1>>,
{
    let (xhat, p) = (belief.estimate(), belief.covariance());
    let (xhat, p, innovation) = corrected(xhat, &p, (h, innovation, v), measured)?;
    *belief = GaussianEstimate::new(&xhat, &p);
    Some(innovation)
}

/// Estimate and covariance after the update by the measurement with H, innovation and V.
#[allow(clippy::type_complexity, reason = "estimate, covariance, innovation")]
pub(crate) fn corrected<T: RealField + Copy, N: Dim, P: Dim>(
    mut xhat: OVector<T, N>,
    p: &OMatrix<T, N, N>,
    (mut h, mut innovation, mut v): (OMatrix<T, P, N>, OVector<T, P>, OMatrix<T, P, P>),
    measured: impl Fn(usize) -> bool,
) -> Option<(OVector<T, N>, OMatrix<T, N, N>, Innovation<T, P>)>
where
    DefaultAllocator:
        Allocator<N> + Allocator<P> + Allocator<N, N> + Allocator<N, P> + Allocator<P, N> + Allocator<P, P>,
{
    for i in (0..innovation.nrows()).filter(|&i| !measured(i)) {
        h.row_mut(i).fill(T::zero());
        innovation[i] = T::zero();
        v.row_mut(i).fill(T::zero());
        v.column_mut(i).fill(T::zero());
        v[(i, i)] = T::one();
    }
    let hp = times(&h, p);
    let s = times_transpose(&hp, &h) + &v;
    if !s.iter().all(ComplexField::is_finite) {
        return None;
    }
    let factor = Factor::new(&s)?;
    // K' = S^-1 (H P).
    let gain = factor.solve(&hp).transpose();
    let order = xhat.shape_generic().0;
    let keep = OMatrix::<T, N, N>::identity_generic(order, order) - times(&gain, &h);
    xhat += times(&gain, &innovation);
    let mut p = times_transpose(&times(&keep, p), &keep) + times_transpose(&times(&gain, &v), &gain);
    symmetrise(&mut p);
    let normalized_square = innovation.dot(&factor.solve(&innovation));
    Some((xhat, p, Innovation { value: innovation, covariance: s, normalized_square }))
}

/// Replaces a matrix by its symmetric part, exactly symmetric.
pub(crate) fn symmetrise<T: RealField + Copy, N: Dim>(p: &mut OMatrix<T, N, N>)
where
    DefaultAllocator: Allocator<N, N>,
{
    let half: T = convert(0.5);
    for i in 0..p.nrows() {
        for j in 0..i {
            let mean = (p[(i, j)] + p[(j, i)]) * half;
            (p[(i, j)], p[(j, i)]) = (mean, mean);
        }
    }
}

/// The symmetric part of a covariance, after a check of shape, entries, symmetry and definiteness (or
/// semidefiniteness).
///
/// Mirrored entries may differ by 8 n epsilon of the largest entry, as for the designs that these matrices come from:
/// those of `C'WC` differ by `2 n epsilon` of `|C'| |W| |C|`.
pub(crate) fn covariance<T: RealField + Copy, D: Dim>(
    what: &'static str,
    mut matrix: OMatrix<T, D, D>,
    order: usize,
    definite: bool,
) -> Result<OMatrix<T, D, D>, ObserverError>
where
    DefaultAllocator: Allocator<D, D> + Allocator<D>,
{
    check_matrix(what, &matrix, (order, order))?;
    let largest = matrix.iter().fold(T::zero(), |largest: T, entry| largest.max(entry.abs()));
    let rounding = largest * T::default_epsilon() * convert::<f64, T>(8.0 * order as f64);
    for row in 0..order {
        for column in 0..row {
            let difference = matrix[(row, column)] - matrix[(column, row)];
            if difference.abs() > rounding {
                let difference = difference.to_subset_unchecked();
                return Err(ObserverError::NotSymmetric { what, row, column, difference });
            }
        }
    }
    symmetrise(&mut matrix);
    match failing_pivot(&matrix, (!definite).then_some(8)) {
        Some((row, pivot)) => Err(ObserverError::NotDefinite { what, row, pivot: pivot.to_subset_unchecked() }),
        None => Ok(matrix),
    }
}
