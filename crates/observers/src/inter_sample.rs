//! An observer in continuous time stepped once per sample, with an inter-sample output predictor:
//!
//! ```text
//! z'   = g(t, z, u, w),   xhat = k(t, z, u, w)
//! w'   = Dh(t, xhat, u) f(t, xhat, u),   w(t_k) = y_k
//! ```
//!
//! from one sample to the next by steps of the classical Runge-Kutta method, u held. With `xhat = x` at a sample it is
//! w = y until the next one; a measurement that is held instead makes an error of the order of `h y'`. The bound of the
//! period h is not computed here: check it by simulation. The estimate at the end of a period uses the predicted
//! output. Where h depends on the time explicitly, that part of `y'` is left out.
//!
//! An observer whose state jumps ([`Observer::jump`]) does so at every sample, before the first of these steps. The
//! observer has to estimate all states of the plant. Its state here is z with the estimate behind it. Cost: 4
//! evaluations of g, k, f, h and Dh for each Runge-Kutta step.
//!
//! [`SampledNonlinearObserver`](crate::SampledNonlinearObserver) is the same for the copy of a plant with a constant
//! gain.
//!
//! Source: I. Karafyllis and C. Kravaris, From continuous-time design to sampled-data design of observers, IEEE
//! Transactions on Automatic Control 54, 2009, eq. (1.3).

use core::marker::PhantomData;

use luenberger_plants::{Column, Differentiable, Size};
use nalgebra::allocator::Allocator;
use nalgebra::{Const, DefaultAllocator, Dim, OMatrix, OVector, RealField, U1, convert};

use crate::dense::times;
use crate::error::ObserverError;
use crate::observer::{Observer, ObserverDimensions, SampledObserver};
use crate::runge_kutta;

/// The sampled form of the observer `O` of the plant `S` with N states, M inputs and P outputs. The state of `O` has
/// the length Z, the state of the sampled form the length D = Z + N; see the [module](self).
#[derive(Clone, Debug, PartialEq)]
pub struct InterSampleObserver<S, O, T, Z, N, M, P, D> {
    plant: S,
    observer: O,
    h: T,
    substeps: usize,
    sizes: PhantomData<(Z, N, M, P, D)>,
}

/// A sampled form whose sizes are known at compile time; D is Z + N.
pub type StaticInterSampleObserver<
    S,
    O,
    T,
    const Z: usize,
    const N: usize,
    const M: usize,
    const P: usize,
    const D: usize,
> = InterSampleObserver<S, O, T, Const<Z>, Const<N>, Const<M>, Const<P>, Const<D>>;

impl<S, O, T: RealField + Copy, Z: Dim, N: Dim, M: Dim, P: Dim, D: Dim> InterSampleObserver<S, O, T, Z, N, M, P, D>
where
    S: Differentiable<T, N, M, P>,
    O: Observer<T, Input = OVector<T, M>, Output = OVector<T, P>, Estimate = OVector<T, N>>,
    DefaultAllocator: Size<N, M, P> + Allocator<Z> + Allocator<D>,
{
    /// The sampled form of `observer` with period `h` and `substeps` Runge-Kutta steps between samples.
    ///
    /// ```
    /// use luenberger_observers::{LinearObserver, SampledObserver, StaticInterSampleObserver};
    /// use nalgebra::{Vector1, Vector2, Vector4};
    /// // x1' = x2, x2' = u: with poles at -5 and -5, a sample every 0.01, from another first estimate.
    /// let plant = luenberger_plants::double_integrator();
    /// let observer = LinearObserver::new(plant.a, plant.b, plant.c, Vector2::new(10.0, 25.0))?;
    /// let sampled = StaticInterSampleObserver::<_, _, f64, 2, 2, 1, 1, 4>::new(plant, observer, 0.01, 1)?;
    /// let mut state = Vector4::new(1.0, 0.0, 1.0, 0.0);
    /// for k in 0..1000 {
    ///     let t = f64::from(k) * 0.01;
    ///     sampled.step(t, &mut state, &Vector1::new(2.0), &Vector1::new(t * t));
    /// }
    /// // x1 = t^2, x2 = 2 t at t = 10: no error is left, although the output moves.
    /// assert!((sampled.estimate(&state) - Vector2::new(100.0, 20.0)).norm() < 1e-10);
    /// # Ok::<(), luenberger_observers::ObserverError>(())
    /// ```
    /// The state of the observer may be a column of any type, as the estimate with its internal error of a mean-value
    /// observer: Z = 2 N.
    ///
    /// ```
    /// use luenberger_observers::{Integral, MeanValueObserver, SampledObserver, StaticInterSampleObserver};
    /// use nalgebra::{Vector1, Vector2};
    /// let plant = luenberger_plants::double_integrator();
    /// let (e, l) = (Vector2::zeros(), Vector2::new(10.0, 25.0));
    /// let observer = MeanValueObserver::with_output_injection(plant.clone(), 4.0, Integral, e, l)?;
    /// let sampled = StaticInterSampleObserver::<_, _, f64, 4, 2, 1, 1, 6>::new(plant, observer, 0.01, 1)?;
    /// let (u, mut y) = (Vector1::new(2.0), Vector1::new(0.0));
    /// let mut state = sampled.initial(0.0, &Vector2::new(1.0, 0.0), &u, &y);
    /// for k in 0..1000 {
    ///     let t = f64::from(k) * 0.01;
    ///     y[0] = t * t;
    ///     sampled.step(t, &mut state, &u, &y);
    /// }
    /// // xhat and e; their sum is the estimate that converges, to x1 = t^2, x2 = 2 t at t = 10.
    /// let z = Vector2::new(state[0] + state[2], state[1] + state[3]);
    /// assert!((z - Vector2::new(100.0, 20.0)).norm() < 1e-9);
    /// # Ok::<(), luenberger_observers::ObserverError>(())
    /// ```
    /// # Errors
    /// [`ObserverError::Matrix`] for an observer that does not estimate the states of this plant or for D,
    /// [`ObserverError::Period`], [`ObserverError::Substeps`].
    pub fn new(plant: S, observer: O, h: T, substeps: usize) -> Result<Self, ObserverError> {
        let (size, own) = (plant.dimensions(), observer.dimensions());
        let all = own.state + own.estimate;
        for (what, expected, found) in [
            ("the estimate", size.states, own.estimate),
            ("u of the observer", size.inputs, own.inputs),
            ("y of the observer", size.outputs, own.outputs),
            ("z", own.state, Z::try_to_usize().unwrap_or(own.state)),
            ("z of the observer", own.state, O::State::fixed_len().unwrap_or(own.state)),
            ("z with the estimate", all, D::try_to_usize().unwrap_or(all)),
        ] {
            if expected != found {
                let (expected, found) = ((expected, 1), (found, 1));
                return Err(luenberger_plants::PlantError::DimensionMismatch { what, expected, found }.into());
            }
        }
        if !(h.is_finite() && h > T::zero()) {
            return Err(ObserverError::Period { period: h.to_subset_unchecked() });
        }
        if substeps == 0 {
            return Err(ObserverError::Substeps);
        }
        Ok(Self { plant, observer, h, substeps, sizes: PhantomData })
    }

    /// The plant.
    pub fn plant(&self) -> &S {
        &self.plant
    }

    /// The observer in continuous time.
    pub fn observer(&self) -> &O {
        &self.observer
    }

    /// Runge-Kutta steps between two samples.
    pub fn substeps(&self) -> usize {
        self.substeps
    }

    /// `z'` and `w'`.
    fn slope(&self, t: T, z: &OVector<T, Z>, w: &OVector<T, P>, u: &OVector<T, M>) -> (OVector<T, Z>, OVector<T, P>) {
        let z: O::State = converted(z);
        let xhat = self.observer.estimate(t, &z, u, w);
        let f = self.plant.derivative(t, &xhat, u);
        let rate: OMatrix<T, P, U1> = times(&self.plant.output_jacobian(t, &xhat, u), &f);
        (converted(&self.observer.derivative(t, &z, u, w)), rate)
    }

    /// z with the estimate behind it.
    fn joined(z: &[T], xhat: &OVector<T, N>) -> OVector<T, D> {
        let length = z.len() + xhat.len();
        OVector::from_iterator_generic(D::from_usize(length), U1, z.iter().chain(xhat.iter()).copied())
    }
}

/// The same entries as a column of another type; the constructor has compared the lengths.
fn converted<T, C: Column<T>>(column: &impl Column<T>) -> C {
    C::from_slice(column.as_slice())
}

impl<S, O, T: RealField + Copy, Z: Dim, N: Dim, M: Dim, P: Dim, D: Dim> SampledObserver<T>
    for InterSampleObserver<S, O, T, Z, N, M, P, D>
where
    S: Differentiable<T, N, M, P>,
    O: Observer<T, Input = OVector<T, M>, Output = OVector<T, P>, Estimate = OVector<T, N>>,
    DefaultAllocator: Size<N, M, P> + Allocator<Z> + Allocator<D>,
{
    type State = OVector<T, D>;
    type Input = OVector<T, M>;
    type Output = OVector<T, P>;
    type Estimate = OVector<T, N>;

    fn dimensions(&self) -> ObserverDimensions {
        let own = self.observer.dimensions();
        ObserverDimensions { state: own.state + own.estimate, ..own }
    }

    fn period(&self) -> T {
        self.h
    }

    fn step(&self, t: T, state: &mut Self::State, u: &Self::Input, y: &Self::Output) {
        let tau = self.h / convert::<f64, T>(self.substeps as f64);
        let order = self.observer.dimensions().state;
        let z = O::State::from_slice(&state.as_slice()[..order]);
        let mut z: OVector<T, Z> = converted(&self.observer.jump(t, &z, u, y));
        let mut w = y.clone();
        for k in 0..self.substeps {
            let now = t + tau * convert::<f64, T>(k as f64);
            runge_kutta::step(now, tau, (&mut z, &mut w), |t, z, w| self.slope(t, z, w, u));
        }
        let xhat = self.observer.estimate(t + self.h, &converted(&z), u, &w);
        *state = Self::joined(z.as_slice(), &xhat);
    }

    fn estimate(&self, state: &Self::State) -> Self::Estimate {
        let order = self.observer.dimensions().state;
        <OVector<T, N> as Column<T>>::from_slice(&state.as_slice()[order..])
    }

    /// The observer starts with the output that the estimate predicts.
    fn initial(&self, t: T, estimate: &Self::Estimate, u: &Self::Input, _y: &Self::Output) -> Self::State {
        let y = self.plant.output(t, estimate, u);
        Self::joined(self.observer.initial(t, estimate, u, &y).as_slice(), estimate)
    }
}
