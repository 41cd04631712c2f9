//! A sampled observer whose samples arrive at varying periods, or not at all: correction and prediction apart.
//!
//! ```text
//! at a sample        xhat  <- xhat - N i + K r              the cubic part and the correction, r = y - C xhat without it
//! between samples    xhat' =  A xhat + B u                  for the time that really passes, u held
//! ```
//!
//! The prediction is the exponential series, `exp(A tau) = sum (A tau)^k/k!` to degree 18, in a number of substeps that
//! is fixed at construction: `|A| tau <= 1` for the longest time, in the largest row sum, so that the remainder is
//! below rounding in binary64. A call takes the same time whatever passes: `36 n^2` operations for a substep. Longer
//! times than the longest are predicted less accurately.
//!
//! As an [`Observer`] it is `xhat' = A xhat + B u`, which a simulation integrates between the samples.
//!
//! Convergence for all periods between two bounds and a number of samples missed in a row is a theorem of the gains:
//! `VaryingPeriodDesign` of the design crate.

use luenberger_plants::error::{PlantError, check_matrix};
use luenberger_plants::{LinearPlant, Size};
use nalgebra::{Const, DefaultAllocator, Dim, OMatrix, OVector, RealField};

use crate::cubic_sampled::SampledCubicObserver;
use crate::dense::{copy, entry, with_column};
use crate::error::ObserverError;
use crate::feedthrough;
use crate::observer::{ContinuousDiscreteObserver, Observer, ObserverDimensions, SampledObserver, state_is_estimate};

/// Degree of the series of a prediction.
pub const DEGREE: usize = 18;

/// The most substeps of a prediction.
const MOST_SUBSTEPS: usize = 4096;

/// An observer with N states, M inputs and P outputs that corrects when a sample arrives, and predicts over any time.
#[derive(Clone, Debug, PartialEq)]
pub struct VaryingPeriodObserver<T: RealField + Copy, N: Dim, M: Dim, P: Dim>
where
    DefaultAllocator: Size<N, M, P>,
{
    nominal: SampledCubicObserver<T, N, M, P>,
    a: OMatrix<T, N, N>,
    b: OMatrix<T, N, M>,
    k: OMatrix<T, N, P>,
    longest: T,
    substeps: usize,
}

/// An observer at varying periods whose sizes are known at compile time.
pub type StaticVaryingPeriodObserver<T, const N: usize, const M: usize, const P: usize> =
    VaryingPeriodObserver<T, Const<N>, Const<M>, Const<P>>;

impl<T: RealField + Copy, N: Dim, M: Dim, P: Dim> VaryingPeriodObserver<T, N, M, P>
where
    DefaultAllocator: Size<N, M, P>,
{
    /// The observer with the correction gain K (n x p), the cubic part of `nominal`, and the plant `x' = A x + B u`
    /// that `nominal` samples; `longest` is the longest time between two calls of [`predict`](Self::predict).
    ///
    /// ```
    /// use luenberger_observers::{SampledCubicGains, SampledCubicObserver, VaryingPeriodObserver};
    /// use nalgebra::{Matrix1, Matrix2, RowVector2, Vector1, Vector2};
    /// // The double integrator, nominally every 0.1 s; K = Ad^-1 Ld.
    /// let (h, c) = (0.1, RowVector2::new(1.0, 0.0));
    /// let (ad, bd) = (Matrix2::new(1.0, h, 0.0, 1.0), Vector2::new(h * h / 2.0, h));
    /// let (ld, n) = (Vector2::new(0.9, 2.0), Vector2::new(-1.0, -1.5));
    /// let gains = SampledCubicGains { ad, bd, c, ld, n, theta: Matrix1::new(10.0), w: 1.0, period: h };
    /// let nominal = SampledCubicObserver::new(gains)?;
    /// let (a, b, k) = (Matrix2::new(0.0, 1.0, 0.0, 0.0), Vector2::new(0.0, 1.0), Vector2::new(0.7, 2.0));
    /// let observer = VaryingPeriodObserver::new(nominal, a, b, k, 0.3)?;
    ///
    /// let (mut x, mut xhat, u) = (Vector2::new(1.0, -1.0), Vector2::zeros(), Vector1::new(1.0));
    /// for period in [0.08, 0.12, 0.3, 0.1].into_iter().cycle().take(200) {
    ///     observer.correct(&mut xhat, &u, &(c * x), period);
    ///     observer.predict(&mut xhat, &u, period);
    ///     x += Vector2::new(x[1] + period / 2.0, 1.0) * period;
    /// }
    /// assert!((x - xhat).norm() < 1e-9 * x.norm());
    /// # Ok::<(), luenberger_observers::ObserverError>(())
    /// ```
    /// # Errors
    /// [`ObserverError::Matrix`] for shapes and entries; [`ObserverError::NotPositive`] for `longest`;
    /// [`ObserverError::PredictionTime`] where `|A| longest` is above 4096.
    pub fn new(
        nominal: SampledCubicObserver<T, N, M, P>,
        a: OMatrix<T, N, N>,
        b: OMatrix<T, N, M>,
        k: OMatrix<T, N, P>,
        longest: T,
    ) -> Result<Self, ObserverError> {
        let plant = LinearPlant::new(a, b, nominal.c().clone())?;
        check_matrix("B", &plant.b, nominal.bd().shape())?;
        check_matrix("K", &k, nominal.n().shape())?;
        if !(longest.is_finite() && longest > T::zero()) {
            let value = longest.to_subset_unchecked();
            return Err(ObserverError::NotPositive { what: "the longest time between samples", value });
        }
        let norm = plant
            .a
            .row_iter()
            .fold(T::zero(), |norm, row| norm.max(row.iter().fold(T::zero(), |sum, entry| sum + entry.abs())));
        let (mut substeps, mut reach) = (1, T::one());
        while reach < norm * longest {
            (substeps, reach) = (substeps + 1, reach + T::one());
            if substeps > MOST_SUBSTEPS {
                let needed = (norm * longest).to_subset_unchecked();
                return Err(ObserverError::PredictionTime { needed, most: MOST_SUBSTEPS });
            }
        }
        Ok(Self { nominal, a: plant.a, b: plant.b, k, longest, substeps })
    }

    /// The gain of the correction, n x p.
    pub fn k(&self) -> &OMatrix<T, N, P> {
        &self.k
    }

    /// The observer of the nominal period, with C, D and the cubic part of this one.
    pub fn nominal(&self) -> &SampledCubicObserver<T, N, M, P> {
        &self.nominal
    }

    /// State matrix A of the plant in continuous time, n x n.
    pub fn a(&self) -> &OMatrix<T, N, N> {
        &self.a
    }

    /// Input matrix B of the plant in continuous time, n x m.
    pub fn b(&self) -> &OMatrix<T, N, M> {
        &self.b
    }

    /// The longest time that is predicted with full accuracy.
    pub fn longest(&self) -> T {
        self.longest
    }

    /// Number of substeps of the exponential series in a prediction.
    pub fn substeps(&self) -> usize {
        self.substeps
    }

    /// A sample: the cubic flow for the time `elapsed`, the period or what has passed since the last correction, then
    /// the correction.
    pub fn correct(&self, xhat: &mut OVector<T, N>, u: &OVector<T, M>, y: &OVector<T, P>, elapsed: T) {
        let n = self.nominal.n();
        let (xhat, outputs) = (xhat.as_mut_slice(), n.shape_generic().1);
        with_column(outputs, |innovation| {
            let c = self.nominal.c();
            feedthrough::sampled_innovation(c, self.nominal.d(), (xhat, u.as_slice(), y.as_slice()), innovation);
            with_column(outputs, |impulse| {
                self.nominal.flow(elapsed, innovation, impulse);
                for (i, xhat) in xhat.iter_mut().enumerate() {
                    *xhat = *xhat - entry(n, i, impulse) + entry(&self.k, i, innovation);
                }
            });
        });
    }

    /// A term of the series of a prediction from the one before it, `(A term + B u) tau / degree`, into `next`.
    pub fn term(&self, term: &[T], u: Option<&[T]>, (tau, degree): (T, T), next: &mut [T]) {
        for (i, next) in next.iter_mut().enumerate() {
            let slope = entry(&self.a, i, term);
            let slope = u.map_or(slope, |u| slope + entry(&self.b, i, u));
            *next = slope * tau / degree;
        }
    }

    /// The estimate after the time `elapsed` without a sample, u being held.
    pub fn predict(&self, xhat: &mut OVector<T, N>, u: &OVector<T, M>, elapsed: T) {
        let (xhat, states) = (xhat.as_mut_slice(), self.a.shape_generic().0);
        let tau = elapsed / crate::cubic::count(self.substeps);
        with_column(states, |term| {
            with_column(states, |next| {
                for _ in 0..self.substeps {
                    copy(xhat, term);
                    let mut degree = T::zero();
                    for k in 0..DEGREE {
                        degree += T::one();
                        // The input is in the first derivative only.
                        let u = (k == 0).then_some(u.as_slice());
                        self.term(term, u, (tau, degree), next);
                        copy(next, term);
                        for (xhat, term) in xhat.iter_mut().zip(term.iter()) {
                            *xhat += *term;
                        }
                    }
                }
            });
        });
    }
}

impl<T: RealField + Copy, N: Dim, M: Dim, P: Dim> Observer<T> for VaryingPeriodObserver<T, N, M, P>
where
    DefaultAllocator: Size<N, M, P>,
{
    state_is_estimate! { Observer }

    fn dimensions(&self) -> ObserverDimensions {
        let (states, outputs) = self.k.shape();
        ObserverDimensions { state: states, inputs: self.b.ncols(), outputs, estimate: states }
    }

    fn derivative(&self, _t: T, xhat: &Self::State, u: &Self::Input, _y: &Self::Output) -> Self::State {
        &self.a * xhat + &self.b * u
    }

    fn is_affine(&self) -> bool {
        true
    }
}

impl<T: RealField + Copy, N: Dim, M: Dim, P: Dim> ContinuousDiscreteObserver<T> for VaryingPeriodObserver<T, N, M, P>
where
    DefaultAllocator: Size<N, M, P>,
{
    fn correct(&self, xhat: &mut Self::State, u: &Self::Input, y: &Self::Output, elapsed: T) {
        Self::correct(self, xhat, u, y, elapsed);
    }
}

/// The observer as a step for each sample that arrives: it predicts over the time that has passed since the last call,
/// and corrects. After the step the estimate is that at the sample.
///
/// The time is the last of the inputs, (u, dt): the columns of B and D for it are zero.
///
/// ```
/// use luenberger_observers::{
///     SampledCubicGains, SampledCubicObserver, SampledObserver, VaryingPeriodObserver, VaryingPeriodStep,
/// };
/// use nalgebra::{Matrix1, Matrix2, RowVector2, Vector1, Vector2};
/// let (h, c) = (0.1, RowVector2::new(1.0, 0.0));
/// let (ad, bd) = (Matrix2::new(1.0, h, 0.0, 1.0), Matrix2::new(h * h / 2.0, 0.0, h, 0.0));
/// let (ld, n) = (Vector2::new(0.9, 2.0), Vector2::new(-1.0, -1.5));
/// let gains = SampledCubicGains { ad, bd, c, ld, n, theta: Matrix1::new(10.0), w: 1.0, period: h };
/// let nominal = SampledCubicObserver::new(gains)?;
/// let (a, b, k) = (Matrix2::new(0.0, 1.0, 0.0, 0.0), Matrix2::new(0.0, 0.0, 1.0, 0.0), Vector2::new(0.7, 2.0));
/// let step = VaryingPeriodStep::new(VaryingPeriodObserver::new(nominal, a, b, k, 0.3)?)?;
///
/// let (mut x, mut xhat, force) = (Vector2::new(1.0, -1.0), Vector2::zeros(), 1.0);
/// for dt in [0.08, 0.12, 0.3, 0.1].into_iter().cycle().take(200) {
///     x += Vector2::new(x[1] + force * dt / 2.0, force) * dt;
///     step.step(0.0, &mut xhat, &Vector2::new(force, dt), &Vector1::new(x[0]));
/// }
/// assert!((x - xhat).norm() < 1e-9 * x.norm());
/// # Ok::<(), luenberger_observers::ObserverError>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct VaryingPeriodStep<T: RealField + Copy, N: Dim, M: Dim, P: Dim>(VaryingPeriodObserver<T, N, M, P>)
where
    DefaultAllocator: Size<N, M, P>;

/// A step whose sizes are known at compile time; M counts the time among the inputs.
pub type StaticVaryingPeriodStep<T, const N: usize, const M: usize, const P: usize> =
    VaryingPeriodStep<T, Const<N>, Const<M>, Const<P>>;

impl<T: RealField + Copy, N: Dim, M: Dim, P: Dim> VaryingPeriodStep<T, N, M, P>
where
    DefaultAllocator: Size<N, M, P>,
{
    /// The step of `observer`, whose last input has no effect.
    ///
    /// # Errors
    /// [`ObserverError::Matrix`] without an input; [`ObserverError::TimeInput`] where the last one has an effect.
    pub fn new(observer: VaryingPeriodObserver<T, N, M, P>) -> Result<Self, ObserverError> {
        let Some(last) = observer.b.ncols().checked_sub(1) else {
            let (expected, found) = ((observer.b.nrows(), 1), observer.b.shape());
            return Err(PlantError::DimensionMismatch { what: "B", expected, found }.into());
        };
        // Matrices are stored by columns.
        let of_b = observer.b.as_slice().iter().skip(last * observer.b.nrows());
        let of_d = observer.nominal.d().into_iter().flat_map(|d| d.as_slice().iter().skip(last * d.nrows()));
        let effect = of_b.chain(of_d).copied().find(|x| *x != T::zero());
        match effect {
            Some(effect) => Err(ObserverError::TimeInput { effect: effect.to_subset_unchecked() }),
            None => Ok(Self(observer)),
        }
    }

    /// The observer, for a prediction alone.
    pub fn observer(&self) -> &VaryingPeriodObserver<T, N, M, P> {
        &self.0
    }
}

impl<T: RealField + Copy, N: Dim, M: Dim, P: Dim> SampledObserver<T> for VaryingPeriodStep<T, N, M, P>
where
    DefaultAllocator: Size<N, M, P>,
{
    state_is_estimate! { SampledObserver }

    fn dimensions(&self) -> ObserverDimensions {
        Observer::dimensions(&self.0)
    }

    /// The nominal period.
    fn period(&self) -> T {
        SampledObserver::period(&self.0.nominal)
    }

    crate::partial::step_of_measured! {}

    fn step(&self, _t: T, xhat: &mut Self::State, u: &Self::Input, y: &Self::Output) {
        let elapsed = u.as_slice().last().copied().unwrap_or_else(T::zero);
        self.0.predict(xhat, u, elapsed);
        self.0.correct(xhat, u, y, elapsed);
    }
}
