//! The sampled-data cubic observer: exact cubic flow, then exact linear step.
//!
//! With the innovation `y~ = y_k - C xhat - D u` of one sample and a radial gain, `C N = -w I`:
//!
//! ```text
//! r      = 1/sqrt(1 + 2 w h y~' theta y~)
//! xhat'  = xhat - N y~ (1 - r)/w                 the cubic part, for the time h
//! xhat+  = Ad xhat' + Bd u + Ld r y~             the linear part, for the time h
//! ```
//!
//! The error then obeys `e' = e + N y~ (1 - r)/w`, `e+ = (Ad - Ld C) e'`. With P from the discrete Lyapunov inequality
//! `(Ad - Ld C)' P (Ad - Ld C) < P` and `N = -P^-1 C' S` neither step increases `V = e'Pe`, and the second decreases
//! it: global exponential stability at *every* period h, where an explicit Euler step diverges as soon as e is large.
//! Only the samples are needed, no derivative and no iteration.
//!
//! One output: every admissible N is radial, w = -C N. Any number of outputs: `S = w (C P^-1 C')^-1`, so `C N = -w I`.
//!
//! Other gains `N = -P^-1 C'S`, `S + S' >= 0`, have no closed form. [`SampledCubicObserver::semi_implicit`] takes them,
//! with the cubic part in one semi-implicit step, which does not increase V either: see
//! [`semi_implicit`].

use luenberger_plants::error::check_matrix;
use luenberger_plants::{LinearPlant, Size};
use nalgebra::allocator::Allocator;
use nalgebra::{Const, DefaultAllocator, Dim, OMatrix, OVector, RealField};

use crate::cubic::{advance, count, entry_of_product};
use crate::dense::{copy, entry, with_column};
use crate::discrete_linear::predict;
use crate::error::ObserverError;
use crate::feedthrough;
use crate::observer::{ObserverDimensions, SampledObserver, state_is_estimate};
use crate::semi_implicit;
use crate::semidefinite::failing_pivot;

/// The data of a [`SampledCubicObserver`], each by its name: plant `x+ = Ad x + Bd u`, `y = C x`, and gains.
#[derive(Clone, Debug, PartialEq)]
pub struct SampledCubicGains<T: RealField + Copy, N: Dim, M: Dim, P: Dim>
where
    DefaultAllocator: Size<N, M, P>,
{
    /// State matrix of the discretised plant, n x n.
    pub ad: OMatrix<T, N, N>,
    /// Input matrix of the discretised plant, n x m.
    pub bd: OMatrix<T, N, M>,
    /// Output matrix, p x n.
    pub c: OMatrix<T, P, N>,
    /// Gain of the discrete linear observer, n x p: `Ad - Ld C` with spectral radius below 1.
    pub ld: OMatrix<T, N, P>,
    /// Cubic gain, n x p, with `C N = -w I`; any for a semi-implicit step.
    pub n: OMatrix<T, N, P>,
    /// Weight of the outputs, p x p, with nonnegative symmetric part.
    pub theta: OMatrix<T, P, P>,
    /// Rate of the cubic flow; [`rate`](crate::cubic::rate) takes it from C and N. 0 for a semi-implicit step.
    pub w: T,
    /// The sampling period h.
    pub period: T,
}

/// The sampled-data cubic observer with N states, M inputs and P outputs.
///
/// Fields are read through methods, because [`step`](SampledObserver::step) relies on what [`new`](Self::new) has
/// checked.
#[derive(Clone, Debug, PartialEq)]
pub struct SampledCubicObserver<T: RealField + Copy, N: Dim, M: Dim, P: Dim>
where
    DefaultAllocator: Size<N, M, P>,
{
    gains: SampledCubicGains<T, N, M, P>,
    semi_implicit: Option<SemiImplicit<T, P>>,
    d: Option<OMatrix<T, P, M>>,
}

/// What a semi-implicit step takes besides the gains.
#[derive(Clone, Debug, PartialEq)]
struct SemiImplicit<T: RealField + Copy, P: Dim>
where
    DefaultAllocator: Allocator<P, P>,
{
    coupling: OMatrix<T, P, P>,
    reach: T,
}

/// A sampled-data cubic observer whose sizes are known at compile time.
pub type StaticSampledCubicObserver<T, const N: usize, const M: usize, const P: usize> =
    SampledCubicObserver<T, Const<N>, Const<M>, Const<P>>;

impl<T: RealField + Copy, N: Dim, M: Dim, P: Dim> SampledCubicObserver<T, N, M, P>
where
    DefaultAllocator: Size<N, M, P>,
{
    /// The observer with these gains; see [`SampledCubicGains`] for their shapes.
    ///
    /// ```
    /// use luenberger_observers::{SampledCubicGains, SampledCubicObserver, SampledObserver, cubic};
    /// use nalgebra::{Matrix1, Matrix2, RowVector2, Vector1, Vector2};
    /// // The double integrator every 0.1 s, poles of Ad - Ld C at 0.5 and 0.6; P = [[1.3, -.7], [-.7, .6]] scaled.
    /// let (h, c) = (0.1, RowVector2::new(1.0, 0.0));
    /// let (ad, bd) = (Matrix2::new(1.0, h, 0.0, 1.0), Vector2::new(h * h / 2.0, h));
    /// let (ld, n) = (Vector2::new(0.9, 2.0), Vector2::new(-1.0, -1.5));
    /// let w = cubic::rate(&c, &n);
    /// let gains = SampledCubicGains { ad, bd, c, ld, n, theta: Matrix1::new(10.0), w, period: h };
    /// let observer = SampledCubicObserver::new(gains)?;
    ///
    /// let (mut x, mut xhat, u) = (Vector2::new(1.0e3, -1.0e3), Vector2::zeros(), Vector1::new(1.0));
    /// for k in 0..100 {
    ///     observer.step(f64::from(k) * h, &mut xhat, &u, &(c * x));
    ///     x = ad * x + bd * u;
    /// }
    /// assert!((x - xhat).norm() < 1e-9 * x.norm());
    /// # Ok::<(), luenberger_observers::ObserverError>(())
    /// ```
    /// # Errors
    /// [`ObserverError::Matrix`] for shapes and entries, [`ObserverError::Period`], [`ObserverError::ThetaIndefinite`],
    /// [`ObserverError::Rate`] when w < 0 or when w = 0 with N != 0, [`ObserverError::NotRadial`] when `C N + w I` is
    /// more than rounding in the computation of N explains: sqrt(epsilon) times `|C| |N|`.
    pub fn new(gains: SampledCubicGains<T, N, M, P>) -> Result<Self, ObserverError> {
        let SampledCubicGains { ad, bd, c, ld, n, theta, w, period } = checked(gains)?;
        let idle = n.iter().all(|entry| *entry == T::zero());
        if !w.is_finite() || w < T::zero() || (w == T::zero() && !idle) {
            return Err(ObserverError::Rate { w: w.to_subset_unchecked() });
        }
        let tolerance = product_size(&c, &n).max(w) * T::default_epsilon().sqrt();
        let deviation = radial_deviation(&c, &n, w);
        if !idle && deviation > tolerance {
            return Err(ObserverError::NotRadial {
                w: w.to_subset_unchecked(),
                deviation: deviation.to_subset_unchecked(),
                tolerance: tolerance.to_subset_unchecked(),
            });
        }
        // An idle cubic part must not touch the innovation either.
        let w = if idle { T::zero() } else { w };
        Ok(Self { gains: SampledCubicGains { ad, bd, c, ld, n, theta, w, period }, semi_implicit: None, d: None })
    }

    /// The observer whose cubic part is one semi-implicit step, for a gain `N = -P^-1 C'S` that need not be radial:
    /// `(I + s G) r = y~`, `s = h y~'theta y~`, `xhat' = xhat - s N r`, `xhat+ = Ad xhat' + Bd u + Ld r`.
    ///
    /// `coupling` is `G = -C N`, p x p, from [`coupling`](crate::semi_implicit::coupling); w is not used.
    ///
    /// ```
    /// use luenberger_observers::semi_implicit::coupling;
    /// use luenberger_observers::{SampledCubicGains, SampledCubicObserver, SampledObserver};
    /// use nalgebra::{Matrix2, OMatrix, U0, U2, Vector2, matrix};
    /// // Two measured states at rest; S = [2, 1; -1, 0.5] has S + S' > 0 and couples the outputs; P = I.
    /// let n = matrix![-2.0, -1.0; 1.0, -0.5];
    /// let (ad, c, ld) = (Matrix2::identity(), Matrix2::identity(), Matrix2::identity() * 0.1);
    /// let (bd, theta) = (OMatrix::<f64, U2, U0>::zeros(), Matrix2::identity());
    /// let gains = SampledCubicGains { ad, bd, c, ld, n, theta, w: 0.0, period: 0.5 };
    /// let observer = SampledCubicObserver::semi_implicit(gains, coupling(&c, &n))?;
    ///
    /// let (x, mut xhat) = (Vector2::new(1.0e6, -1.0e6), Vector2::zeros());
    /// let none = OMatrix::<f64, U0, nalgebra::U1>::zeros();
    /// for _ in 0..3 {
    ///     observer.step(0.0, &mut xhat, &none, &x);
    /// }
    /// assert!((x - xhat).norm() < 1.0);
    /// # Ok::<(), luenberger_observers::ObserverError>(())
    /// ```
    /// # Errors
    /// [`ObserverError::Matrix`] for shapes and entries, [`ObserverError::Period`], [`ObserverError::ThetaIndefinite`],
    /// [`ObserverError::Coupling`] when `G + C N` is more than rounding explains: sqrt(epsilon) times `|C| |N|`.
    pub fn semi_implicit(
        gains: SampledCubicGains<T, N, M, P>,
        coupling: OMatrix<T, P, P>,
    ) -> Result<Self, ObserverError> {
        let gains = SampledCubicGains { w: T::zero(), ..checked(gains)? };
        let SampledCubicGains { c, n, .. } = &gains;
        check_matrix("-C N", &coupling, (c.nrows(), c.nrows()))?;
        let tolerance = product_size(c, n) * T::default_epsilon().sqrt();
        let deviation = semi_implicit::deviation(c, n, &coupling);
        if deviation > tolerance {
            return Err(ObserverError::Coupling {
                deviation: deviation.to_subset_unchecked(),
                tolerance: tolerance.to_subset_unchecked(),
            });
        }
        let reach = semi_implicit::reach(&coupling);
        Ok(Self { gains, semi_implicit: Some(SemiImplicit { coupling, reach }), d: None })
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

    /// Feedthrough matrix, p x m; `None` where the output does not depend on the input.
    pub fn d(&self) -> Option<&OMatrix<T, P, M>> {
        self.d.as_ref()
    }

    /// State matrix of the discretised plant, n x n.
    pub fn ad(&self) -> &OMatrix<T, N, N> {
        &self.gains.ad
    }

    /// Input matrix of the discretised plant, n x m.
    pub fn bd(&self) -> &OMatrix<T, N, M> {
        &self.gains.bd
    }

    /// Output matrix, p x n.
    pub fn c(&self) -> &OMatrix<T, P, N> {
        &self.gains.c
    }

    /// Gain of the linear part, n x p.
    pub fn ld(&self) -> &OMatrix<T, N, P> {
        &self.gains.ld
    }

    /// Gain of the cubic part, n x p.
    pub fn n(&self) -> &OMatrix<T, N, P> {
        &self.gains.n
    }

    /// Weight of the outputs, p x p.
    pub fn theta(&self) -> &OMatrix<T, P, P> {
        &self.gains.theta
    }

    /// The rate w of the cubic flow, `C N = -w I`; 0 for a semi-implicit step.
    pub fn w(&self) -> T {
        self.gains.w
    }

    /// The innovation `y - C xhat - D u`.
    pub fn innovation(&self, xhat: &OVector<T, N>, u: &OVector<T, M>, y: &OVector<T, P>) -> OVector<T, P> {
        feedthrough::innovation_of(&self.gains.c, self.d.as_ref(), (xhat, u, y))
    }

    /// The cubic part for the time `t`: the innovation after it, and its impulse, of which N takes the multiple.
    pub(crate) fn flow(&self, t: T, innovation: &mut [T], impulse: &mut [T]) {
        let SampledCubicGains { theta, w, .. } = &self.gains;
        match &self.semi_implicit {
            Some(SemiImplicit { coupling, reach }) => {
                semi_implicit::advance(theta, (coupling, *reach), t, innovation, impulse);
            }
            None => advance(theta, *w, t, innovation, impulse),
        }
    }

    /// `G = -C N` of a semi-implicit step; none where the flow is in closed form.
    pub fn coupling(&self) -> Option<&OMatrix<T, P, P>> {
        self.semi_implicit.as_ref().map(|step| &step.coupling)
    }
}

impl<T: RealField + Copy, N: Dim, M: Dim, P: Dim> SampledObserver<T> for SampledCubicObserver<T, N, M, P>
where
    DefaultAllocator: Size<N, M, P>,
{
    state_is_estimate! { SampledObserver }

    fn dimensions(&self) -> ObserverDimensions {
        let SampledCubicGains { ad, bd, c, .. } = &self.gains;
        ObserverDimensions { state: ad.nrows(), inputs: bd.ncols(), outputs: c.nrows(), estimate: ad.nrows() }
    }

    fn period(&self) -> T {
        self.gains.period
    }

    crate::partial::step_of_measured! {}

    fn step(&self, _t: T, xhat: &mut Self::State, u: &Self::Input, y: &Self::Output) {
        let SampledCubicGains { ad, bd, c, ld, n, period, .. } = &self.gains;
        let (order, outputs) = n.shape_generic();
        let (u, y, xhat) = (u.as_slice(), y.as_slice(), xhat.as_mut_slice());
        with_column(outputs, |innovation| {
            feedthrough::sampled_innovation(c, self.d.as_ref(), (xhat, u, y), innovation);
            with_column(outputs, |impulse| {
                self.flow(*period, innovation, impulse);
                for (i, xhat) in xhat.iter_mut().enumerate() {
                    *xhat -= entry(n, i, impulse);
                }
            });
            with_column(order, |next| {
                predict((ad, bd, ld), (xhat, u, innovation), next);
                copy(next, xhat);
            });
        });
    }
}

/// The gains, if shapes, entries, period and theta are those of an observer.
fn checked<T: RealField + Copy, N: Dim, M: Dim, P: Dim>(
    gains: SampledCubicGains<T, N, M, P>,
) -> Result<SampledCubicGains<T, N, M, P>, ObserverError>
where
    DefaultAllocator: Size<N, M, P>,
{
    let SampledCubicGains { ad, bd, c, ld, n, theta, w, period } = gains;
    let LinearPlant { a: ad, b: bd, c, .. } = LinearPlant::new(ad, bd, c)?;
    let (states, outputs) = (ad.nrows(), c.nrows());
    check_matrix("Ld", &ld, (states, outputs))?;
    check_matrix("N", &n, (states, outputs))?;
    check_matrix("theta", &theta, (outputs, outputs))?;
    if !(period.is_finite() && period > T::zero()) {
        return Err(ObserverError::Period { period: period.to_subset_unchecked() });
    }
    if let Some((row, pivot)) = failing_pivot(&theta, Some(4)) {
        return Err(ObserverError::ThetaIndefinite { row, pivot: pivot.to_subset_unchecked() });
    }
    Ok(SampledCubicGains { ad, bd, c, ld, n, theta, w, period })
}

/// A bound of the entries of `C N`.
fn product_size<T: RealField + Copy, N: Dim, P: Dim>(c: &OMatrix<T, P, N>, n: &OMatrix<T, N, P>) -> T
where
    DefaultAllocator: Allocator<P, N> + Allocator<N, P>,
{
    magnitude(c) * magnitude(n) * count(c.ncols())
}

/// Largest entry of `|C N + w I|`.
fn radial_deviation<T: RealField + Copy, N: Dim, P: Dim>(c: &OMatrix<T, P, N>, n: &OMatrix<T, N, P>, w: T) -> T
where
    DefaultAllocator: Allocator<P, N> + Allocator<N, P>,
{
    let mut deviation = T::zero();
    for i in 0..c.nrows() {
        for j in 0..c.nrows() {
            let expected = if i == j { w } else { T::zero() };
            deviation = deviation.max((entry_of_product(c, n, i, j) + expected).abs());
        }
    }
    deviation
}

/// Largest magnitude of an entry.
fn magnitude<T: RealField + Copy, R: Dim, C: Dim>(matrix: &OMatrix<T, R, C>) -> T
where
    DefaultAllocator: Allocator<R, C>,
{
    matrix.iter().fold(T::zero(), |largest, entry| largest.max(entry.abs()))
}
