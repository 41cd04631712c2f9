//! The copy of a nonlinear plant with a constant gain, stepped once per sample:
//! `xhat' = f(t, xhat, u) + L (w - h(t, xhat, u))` between samples, with an output w that is predicted from the last
//! measurement.
//!
//! ```text
//! xhat' = f(t, xhat, u) + L (w - h(t, xhat, u))
//! w'    = Dh(t, xhat, u) f(t, xhat, u),   w(t_k) = y_k
//! ```
//!
//! from one sample to the next by so many steps of the classical Runge-Kutta method, u held. With `xhat = x` at a
//! sample it is w = y and `xhat = x` until the next one, as in continuous time; a measurement that is held instead
//! makes an error of the order of `h y'` while the plant moves. With the error e small, w differs from y by `O(h |e|)`,
//! so that the observer approaches the one in continuous time as h goes to 0, and keeps converging for h small enough:
//! I. Karafyllis and C. Kravaris show it for globally Lipschitz plants. The bound of h is not computed here: check the
//! period by simulation. Where h depends on the time explicitly, that part of `y'` is left out.
//!
//! Lipschitz, LPV and high-gain designs run as this. Cost: 4 evaluations of f, h and Dh for each Runge-Kutta step.
//!
//! Source: I. Karafyllis and C. Kravaris, From continuous-time design to sampled-data design of observers, IEEE
//! Transactions on Automatic Control 54, 2009, eq. (1.3), the inter-sample output predictor.

use core::marker::PhantomData;

#[cfg(feature = "alloc")]
use luenberger_plants::Column as _;
use luenberger_plants::error::check_matrix;
use luenberger_plants::{Differentiable, Size};
use nalgebra::{Const, DefaultAllocator, Dim, OMatrix, OVector, RealField, convert};
#[cfg(feature = "alloc")]
use nalgebra::{DMatrix, U0, U1};

use crate::dense::times;
use crate::error::ObserverError;
#[cfg(feature = "alloc")]
use crate::held::{AtInput, Held, OnSlices, on_numbers, same, sized};
#[cfg(feature = "alloc")]
use crate::observer::put_slice;
use crate::observer::{ObserverDimensions, SampledObserver, state_is_estimate, step_columns};
use crate::partial::{of_measured, only};
use crate::runge_kutta;

/// The sampled copy of a plant `S` with N states, M inputs and P outputs; see the [module](self).
///
/// Fields are read through methods, because the constructor has checked them.
#[derive(Clone, Debug, PartialEq)]
pub struct SampledNonlinearObserver<S, T: RealField + Copy, N: Dim, M: Dim, P: Dim>
where
    DefaultAllocator: Size<N, M, P>,
{
    plant: S,
    l: OMatrix<T, N, P>,
    h: T,
    substeps: usize,
    inputs: PhantomData<M>,
}

/// A sampled copy whose sizes are known at compile time.
pub type StaticSampledNonlinearObserver<S, T, const N: usize, const M: usize, const P: usize> =
    SampledNonlinearObserver<S, T, Const<N>, Const<M>, Const<P>>;

impl<S, T: RealField + Copy, N: Dim, M: Dim, P: Dim> SampledNonlinearObserver<S, T, N, M, P>
where
    DefaultAllocator: Size<N, M, P>,
{
    /// The plant.
    pub fn plant(&self) -> &S {
        &self.plant
    }

    /// The gain L, n x p.
    pub fn l(&self) -> &OMatrix<T, N, P> {
        &self.l
    }
}

impl<S, T: RealField + Copy, N: Dim, M: Dim, P: Dim> SampledNonlinearObserver<S, T, N, M, P>
where
    S: Differentiable<T, N, M, P>,
    DefaultAllocator: Size<N, M, P>,
{
    /// The copy of `plant` with the gain L (n x p), sampled with period `h`, with `substeps` Runge-Kutta steps between
    /// samples.
    ///
    /// ```
    /// use luenberger_observers::{ObserverError, SampledNonlinearObserver, SampledObserver};
    /// use nalgebra::{Vector1, Vector2};
    /// // x1' = x2, x2' = u: with poles at -5 and -5, a sample every 0.01, from another first estimate.
    /// let plant = luenberger_plants::double_integrator();
    /// let observer = SampledNonlinearObserver::new(plant, Vector2::new(10.0, 25.0), 0.01, 1)?;
    /// let mut xhat = Vector2::new(1.0, 0.0);
    /// for k in 0..1000 {
    ///     let t = f64::from(k) * 0.01;
    ///     observer.step(t, &mut xhat, &Vector1::new(2.0), &Vector1::new(t * t));
    /// }
    /// // x1 = t^2, x2 = 2 t at t = 10: no error is left, although the output moves.
    /// assert!((xhat - Vector2::new(100.0, 20.0)).norm() < 1e-10);
    /// # Ok::<(), ObserverError>(())
    /// ```
    /// # Errors
    /// [`ObserverError::Matrix`] for the shape and the entries of L, [`ObserverError::Period`],
    /// [`ObserverError::Substeps`].
    pub fn new(plant: S, l: OMatrix<T, N, P>, h: T, substeps: usize) -> Result<Self, ObserverError> {
        let size = plant.dimensions();
        check_matrix("L", &l, (size.states, size.outputs))?;
        if !(h.is_finite() && h > T::zero()) {
            return Err(ObserverError::Period { period: h.to_subset_unchecked() });
        }
        if substeps == 0 {
            return Err(ObserverError::Substeps);
        }
        Ok(Self { plant, l, h, substeps, inputs: PhantomData })
    }

    /// Runge-Kutta steps between two samples.
    pub fn substeps(&self) -> usize {
        self.substeps
    }

    /// `xhat'` and `w'`, which a step integrates from one sample to the next. An output w that is not finite stays so,
    /// and does not correct.
    pub fn slope(
        &self,
        t: T,
        xhat: &OVector<T, N>,
        w: &OVector<T, P>,
        u: &OVector<T, M>,
    ) -> (OVector<T, N>, OVector<T, P>) {
        let f = self.plant.derivative(t, xhat, u);
        let rate = times(&self.plant.output_jacobian(t, xhat, u), &f);
        let mut innovation = w - self.plant.output(t, xhat, u);
        innovation.zip_apply(w, |innovation, w| *innovation = of_measured(w, *innovation));
        (f + times(&self.l, &innovation), rate)
    }

    /// From one sample to the next.
    fn advance(&self, t: T, xhat: &mut OVector<T, N>, u: &OVector<T, M>, mut w: OVector<T, P>) {
        let tau = self.h / convert::<f64, T>(self.substeps as f64);
        for k in 0..self.substeps {
            let now = t + tau * convert::<f64, T>(k as f64);
            runge_kutta::step(now, tau, (xhat, &mut w), |t, xhat, w| self.slope(t, xhat, w, u));
        }
    }

    /// A step on slices, if the sizes are known at run time; false for other sizes and lengths.
    #[cfg(feature = "alloc")]
    fn at_run_time(&self, (t, u): (T, &[T]), xhat: &mut [T], y: &[T], measured: &[bool]) -> bool {
        // A module for web pages, which has to be downloaded, has this observer for any size alone.
        if cfg!(target_arch = "wasm32") || u.len() != self.plant.dimensions().inputs {
            return false;
        }
        let (Some(l), Some(h)) = (same(&self.l), same(&self.h)) else { return false };
        let plant = &AtInput::<_, _, (N, M, P)>::new(&self.plant, u);
        let copy = CopyAtRunTime { plant, l, h: *h, substeps: self.substeps };
        on_numbers((t, y), xhat, |t, xhat, y| copy.step(t, xhat, y, measured))
    }
}

impl<S, T: RealField + Copy, N: Dim, M: Dim, P: Dim> SampledObserver<T> for SampledNonlinearObserver<S, T, N, M, P>
where
    S: Differentiable<T, N, M, P>,
    DefaultAllocator: Size<N, M, P>,
{
    state_is_estimate! { SampledObserver }

    fn dimensions(&self) -> ObserverDimensions {
        let size = self.plant.dimensions();
        ObserverDimensions { state: size.states, inputs: size.inputs, outputs: size.outputs, estimate: size.states }
    }

    fn period(&self) -> T {
        self.h
    }

    fn step_partial(&self, t: T, xhat: &mut Self::State, u: &Self::Input, y: &Self::Output, measured: &[bool]) {
        #[cfg(feature = "alloc")]
        if self.at_run_time((t, u.as_slice()), xhat.as_mut_slice(), y.as_slice(), measured) {
            return;
        }
        self.advance(t, xhat, u, only(y, measured));
    }

    fn step_into(&self, t: T, state: &mut [T], u: &[T], y: &[T], measured: &[bool]) -> bool {
        #[cfg(feature = "alloc")]
        if self.at_run_time((t, u), state, y, measured) {
            return true;
        }
        step_columns(self, t, state, (u, y), measured)
    }

    fn step(&self, t: T, xhat: &mut Self::State, u: &Self::Input, y: &Self::Output) {
        self.step_partial(t, xhat, u, y, &[]);
    }
}

/// The observer of a plant whose sizes are known at run time, at an input that is held.
#[cfg(feature = "alloc")]
struct CopyAtRunTime<'f> {
    plant: &'f dyn OnSlices,
    l: &'f DMatrix<f64>,
    h: f64,
    substeps: usize,
}

#[cfg(feature = "alloc")]
impl CopyAtRunTime<'_> {
    /// False for other sizes.
    fn step(&self, t: f64, xhat: &mut [f64], y: &[f64], measured: &[bool]) -> bool {
        sized!(self.l.nrows(), [1 2 3 4] [5 6 7 8], n => sized!(
            self.l.ncols(), [1 2] [3 4], p => self.step_of_size((n, p), t, xhat, (y, measured))
        ))
    }

    fn step_of_size<N: Dim, P: Dim>(
        &self,
        size: (N, P),
        t: f64,
        xhat: &mut [f64],
        (y, measured): (&[f64], &[bool]),
    ) -> bool
    where
        DefaultAllocator: Size<N, U0, P>,
    {
        let (next, y) = (OVector::<f64, N>::try_from_slice(xhat), OVector::<f64, P>::try_from_slice(y));
        let (Some(mut next), Some(y)) = (next, y) else { return false };
        let observer = SampledNonlinearObserver {
            plant: Held { plant: self.plant, size },
            l: OMatrix::from_column_slice_generic(size.0, size.1, self.l.as_slice()),
            h: self.h,
            substeps: self.substeps,
            inputs: PhantomData,
        };
        observer.advance(t, &mut next, &OVector::zeros_generic(U0, U1), only(&y, measured));
        put_slice(next.as_slice(), xhat)
    }
}
