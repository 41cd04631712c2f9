//! The mean-value-theorem observer of Ben Messaoud and Hajji, as printed, and with output injection into its error.
//!
//! ```text
//! xhat' = f(xhat, u) + G e1
//! e'    = (D - G) e                                as printed, eq. (3)
//! e'    = (D - G) e + (L - [G_m; 0]) (y - C xhat - C e)          with output injection
//! ```
//!
//! C = [I 0]: the first p states are measured. e is the observer's *internal* error, a state of its own; e1 holds the
//! measured errors `y - C xhat` in its first p rows and the internal ones in the rest. D is a mean of `Df` over the
//! segment from xhat to `xhat + e`, by rows ([`beta`]) or as an integral ([`integral`]), and `G = eta diag(alpha)`,
//! alpha_k the sum of row k and of column k of |D|, the diagonal counted twice: eq. (5), (6).
//!
//! **What holds.** `e'De <= sum alpha_k e_k^2 / 2`, so that as printed the internal error never grows when `eta > 1/2`,
//! and `|e|^2 / 2` falls at least at the rate `(eta - 1/2) sum alpha_k e_k^2`.
//!
//! **What does not.** That is the internal error, not `x - xhat`. With `z = xhat + e` the printed observer says
//! `z' = f(z, u) + [G_m; 0] (y - C z)`: the error x - z, which decides convergence, is injected into the measured
//! states only. Where that does not suffice, the observer converges from e(0) = x(0) - xhat(0), not in general. Output
//! injection into the equation of e turns that of z into `z' = f(z, u) + L (y - C z)`, so that `d = x - z` obeys
//! `d' = (Dbar - L C) d` with the mean Jacobian between z and x; where L makes that contract (one Lyapunov matrix for
//! all mean Jacobians), d tends to 0 from *any* e(0), and with it e and x - xhat.
//!
//! **Where it does after all.** As the injection grows, the unmeasured block of the Jacobian is what is left of the
//! equation of x - z. In coordinates `x_u - K x_m` in which that block contracts, the observer converges as printed
//! from any e(0); [`mapped`] gives its estimate in the plant's coordinates, and `luenberger-design` finds K.
//!
//! Source: R. Ben Messaoud and S. Hajji, WSEAS Transactions on Systems 17, 2018.

pub mod beta;
pub mod integral;
pub mod mapped;
pub(crate) mod quadrature;
pub mod segment;

use core::marker::PhantomData;

use luenberger_plants::error::check_matrix;
use luenberger_plants::{Column, Differentiable, Size};
use nalgebra::allocator::Allocator;
use nalgebra::{Const, DefaultAllocator, Dim, OMatrix, OVector, RealField, U1, U2};

use crate::error::ObserverError;
use crate::observer::{Observer, ObserverDimensions};

pub use self::beta::Beta;
pub use self::integral::Integral;
pub use self::mapped::{MappedObserver, StaticMappedObserver};

/// A mean D of the Jacobian over a segment, and the product `D e`.
#[derive(Clone, Debug, PartialEq)]
pub struct MeanJacobian<T: RealField + Copy, N: Dim>
where
    DefaultAllocator: Allocator<N> + Allocator<N, N>,
{
    /// D, n x n, from which the gain is built.
    pub jacobian: OMatrix<T, N, N>,
    /// `D e`, which is `f(xhat + e) - f(xhat)` as well as this mean has it.
    pub forward: OVector<T, N>,
}

/// A mean of `Df` over the segment from xhat to xhat + e: a matrix D with `D e = f(xhat + e) - f(xhat)`.
///
/// Here are [`Beta`] and [`Integral`]; `luenberger-design` has `LeastSquares`, the paper's own way to beta, which needs
/// `std`.
pub trait Mean<S, T, N, M, P>
where
    S: Differentiable<T, N, M, P>,
    T: RealField + Copy,
    N: Dim,
    M: Dim,
    P: Dim,
    DefaultAllocator: Size<N, M, P>,
{
    /// D and `D e`. Where Df is not finite on the segment, neither are they; [`examine`](Self::examine) says where that
    /// is.
    fn mean(&self, plant: &S, t: T, xhat: &OVector<T, N>, u: &OVector<T, M>, e: &OVector<T, N>) -> MeanJacobian<T, N>;

    /// Whether D and `D e` exist on this segment: found by evaluating f and Df at its ends and at eight points between,
    /// and D itself.
    ///
    /// # Errors
    /// [`ObserverError::JacobianNotFinite`] and [`ObserverError::SlopeNotFinite`] name the point.
    fn examine(
        &self,
        plant: &S,
        t: T,
        xhat: &OVector<T, N>,
        u: &OVector<T, M>,
        e: &OVector<T, N>,
    ) -> Result<(), ObserverError> {
        segment::examine(plant, t, xhat, u, e)
    }
}

impl<D, S, T, N, M, P> Mean<S, T, N, M, P> for &D
where
    D: Mean<S, T, N, M, P> + ?Sized,
    S: Differentiable<T, N, M, P>,
    T: RealField + Copy,
    N: Dim,
    M: Dim,
    P: Dim,
    DefaultAllocator: Size<N, M, P>,
{
    fn mean(&self, plant: &S, t: T, xhat: &OVector<T, N>, u: &OVector<T, M>, e: &OVector<T, N>) -> MeanJacobian<T, N> {
        (**self).mean(plant, t, xhat, u, e)
    }

    fn examine(
        &self,
        plant: &S,
        t: T,
        xhat: &OVector<T, N>,
        u: &OVector<T, M>,
        e: &OVector<T, N>,
    ) -> Result<(), ObserverError> {
        (**self).examine(plant, t, xhat, u, e)
    }
}

/// The state of the observer: estimate xhat and internal error e, one beside the other.
#[derive(Clone, Debug, PartialEq)]
pub struct EstimateAndError<T: RealField + Copy, N: Dim>(OMatrix<T, N, U2>)
where
    DefaultAllocator: Allocator<N, U2>;

impl<T: RealField + Copy, N: Dim> EstimateAndError<T, N>
where
    DefaultAllocator: Allocator<N, U2> + Allocator<N>,
{
    /// The state with estimate xhat and internal error e, of one length.
    pub fn new(xhat: &OVector<T, N>, e: &OVector<T, N>) -> Self {
        Self(OMatrix::from_fn_generic(xhat.shape_generic().0, U2, |i, j| if j == 0 { xhat[i] } else { e[i] }))
    }

    /// The estimate xhat.
    pub fn estimate(&self) -> OVector<T, N> {
        self.0.column(0).into_owned()
    }

    /// The internal error e.
    pub fn error(&self) -> OVector<T, N> {
        self.0.column(1).into_owned()
    }

    /// `z = xhat + e`, the second estimate of the plant's state.
    pub fn second_estimate(&self) -> OVector<T, N> {
        self.estimate() + self.error()
    }
}

impl<T: RealField + Copy, N: Dim> Column<T> for EstimateAndError<T, N>
where
    DefaultAllocator: Allocator<N, U2>,
{
    fn try_from_slice(entries: &[T]) -> Option<Self> {
        let n = entries.len() / 2;
        if entries.len() != 2 * n || N::try_to_usize().is_some_and(|fixed| fixed != n) {
            return None;
        }
        Some(Self(OMatrix::from_iterator_generic(N::from_usize(n), U2, entries.iter().copied())))
    }

    fn as_slice(&self) -> &[T] {
        self.0.as_slice()
    }

    fn fixed_len() -> Option<usize> {
        N::try_to_usize().map(|n| 2 * n)
    }
}

/// The mean-value-theorem observer of a plant `S` with N states, M inputs and P outputs; see the [module](self).
///
/// Fields are read through methods, because the constructors have checked them.
#[derive(Clone, Debug, PartialEq)]
pub struct MeanValueObserver<S, D, T: RealField + Copy, N: Dim, M: Dim, P: Dim>
where
    DefaultAllocator: Size<N, M, P>,
{
    plant: S,
    eta: T,
    mean: D,
    internal_error: OVector<T, N>,
    l: Option<OMatrix<T, N, P>>,
    inputs: PhantomData<M>,
}

/// A mean-value-theorem observer whose sizes are known at compile time.
pub type StaticMeanValueObserver<S, D, T, const N: usize, const M: usize, const P: usize> =
    MeanValueObserver<S, D, T, Const<N>, Const<M>, Const<P>>;

impl<S, D, T: RealField + Copy, N: Dim, M: Dim, P: Dim> MeanValueObserver<S, D, T, N, M, P>
where
    S: Differentiable<T, N, M, P>,
    D: Mean<S, T, N, M, P>,
    DefaultAllocator: Size<N, M, P>,
{
    /// The observer as printed, whose internal error starts at `internal_error`.
    ///
    /// The plant's outputs must be its first p states. An `internal_error` that is x(0) - xhat(0) tells the observer
    /// the plant's state; the estimate is then exact up to that error's decay, whatever the plant.
    ///
    /// ```
    /// use luenberger_observers::{EstimateAndError, Integral, MeanValueObserver, Observer, ObserverError};
    /// use luenberger_plants::Chaotic;
    /// use nalgebra::{SVector, Vector2, Vector3};
    ///
    /// let e0 = Vector3::new(-1.0, -0.5, 0.5);
    /// let observer = MeanValueObserver::new(Chaotic, 1.0, Integral, e0)?;
    /// let (u, y) = (SVector::zeros(), Vector2::new(-2.0, -1.0));
    /// let state = observer.initial(0.0, &Vector3::new(-1.0, -0.5, -1.5), &u, &y);
    /// assert_eq!(state.second_estimate(), Vector3::new(-2.0, -1.0, -1.0));
    /// // e points along a direction in which the internal error falls.
    /// let slope: EstimateAndError<f64, _> = observer.derivative(0.0, &state, &u, &y);
    /// assert!(slope.error().dot(&e0) < 0.0);
    ///
    /// let refused = MeanValueObserver::new(Chaotic, 0.5, Integral, e0).unwrap_err();
    /// assert_eq!(refused, ObserverError::Eta { eta: 0.5 });
    /// # Ok::<(), ObserverError>(())
    /// ```
    /// # Errors
    /// [`ObserverError::Eta`] unless eta > 1/2, [`ObserverError::Matrix`] for the length and the entries of
    /// `internal_error`, [`ObserverError::OutputNotState`] when y is not the first p states (tested at two
    /// states and inputs).
    pub fn new(plant: S, eta: T, mean: D, internal_error: OVector<T, N>) -> Result<Self, ObserverError> {
        if !(eta.is_finite() && eta + eta > T::one()) {
            return Err(ObserverError::Eta { eta: eta.to_subset_unchecked() });
        }
        let (n, p) = (plant.dimensions().states, plant.dimensions().outputs);
        check_matrix("e(0)", &internal_error, (n, 1))?;
        // Distinct values, twice: a permutation, a scale, an offset or a curvature of h shows, and an input in it.
        for scale in [2.0, -3.0] {
            let x = OVector::from_fn_generic(internal_error.shape_generic().0, U1, |i, _| {
                nalgebra::convert::<f64, T>(scale * (i as f64 + 1.0))
            });
            let u = OVector::from_fn_generic(M::from_usize(plant.dimensions().inputs), U1, |j, _| {
                nalgebra::convert::<f64, T>(scale * (j as f64 + 0.5))
            });
            let y = plant.output(T::zero(), &x, &u);
            for k in 0..p.max(y.nrows()) {
                let found = y.get(k).copied();
                if k >= n || found != Some(x[k]) {
                    return Err(ObserverError::OutputNotState {
                        output: k,
                        expected: x.get(k).map_or(f64::NAN, |&x| x.to_subset_unchecked()),
                        found: found.map_or(f64::NAN, |y| y.to_subset_unchecked()),
                    });
                }
            }
        }
        Ok(Self { plant, eta, mean, internal_error, l: None, inputs: PhantomData })
    }

    /// The observer with output injection into its internal error, `z' = f(z, u) + L (y - C z)`; L is n x p.
    ///
    /// It converges where `Df - L C` contracts in one quadratic norm over all mean Jacobians between the plant and z.
    ///
    /// # Errors
    /// As [`new`](Self::new), and [`ObserverError::Matrix`] for the shape and the entries of L.
    pub fn with_output_injection(
        plant: S,
        eta: T,
        mean: D,
        internal_error: OVector<T, N>,
        l: OMatrix<T, N, P>,
    ) -> Result<Self, ObserverError> {
        let printed = Self::new(plant, eta, mean, internal_error)?;
        let size = printed.plant.dimensions();
        check_matrix("L", &l, (size.states, size.outputs))?;
        Ok(Self { l: Some(l), ..printed })
    }

    /// The plant.
    pub fn plant(&self) -> &S {
        &self.plant
    }

    /// The factor eta of the gain, above 1/2.
    pub fn eta(&self) -> T {
        self.eta
    }

    /// The internal error at the start.
    pub fn internal_error(&self) -> &OVector<T, N> {
        &self.internal_error
    }

    /// The gain of the output injection, `None` for the observer as printed.
    pub fn l(&self) -> Option<&OMatrix<T, N, P>> {
        self.l.as_ref()
    }

    /// The mean of the Jacobian it uses.
    pub fn mean(&self) -> &D {
        &self.mean
    }

    /// Whether the right-hand side exists at this estimate and internal error: [`derivative`](Observer::derivative)
    /// itself returns no error, and where Df is not finite on the segment its result is not either.
    ///
    /// # Errors
    /// [`ObserverError::JacobianNotFinite`] and [`ObserverError::SlopeNotFinite`] name the point.
    pub fn examine(&self, t: T, state: &EstimateAndError<T, N>, u: &OVector<T, M>) -> Result<(), ObserverError>
    where
        DefaultAllocator: Allocator<N, U2>,
    {
        self.mean.examine(&self.plant, t, &state.estimate(), u, &state.error())
    }
}

impl<S, D, T: RealField + Copy, N: Dim, M: Dim, P: Dim> Observer<T> for MeanValueObserver<S, D, T, N, M, P>
where
    S: Differentiable<T, N, M, P>,
    D: Mean<S, T, N, M, P>,
    DefaultAllocator: Size<N, M, P> + Allocator<N, U2>,
{
    type State = EstimateAndError<T, N>;
    type Input = OVector<T, M>;
    type Output = OVector<T, P>;
    type Estimate = OVector<T, N>;

    fn dimensions(&self) -> ObserverDimensions {
        let size = self.plant.dimensions();
        ObserverDimensions { state: 2 * size.states, inputs: size.inputs, outputs: size.outputs, estimate: size.states }
    }

    fn derivative(&self, t: T, state: &Self::State, u: &Self::Input, y: &Self::Output) -> Self::State {
        let (xhat, e) = (state.estimate(), state.error());
        let MeanJacobian { jacobian: d, forward } = self.mean.mean(&self.plant, t, &xhat, u, &e);
        let mut slope = self.plant.derivative(t, &xhat, u);
        let mut error_slope = forward;
        for k in 0..xhat.nrows() {
            let g = self.eta * gain(&d, k);
            let e1 = if k < y.nrows() { y[k] - xhat[k] } else { e[k] };
            slope[k] += g * e1;
            error_slope[k] -= g * e[k];
            if self.l.is_some() {
                // - [G_m; 0] (y - C xhat - C e): zero in the rows that are not measured.
                error_slope[k] -= g * (e1 - e[k]);
            }
        }
        if let Some(l) = &self.l {
            let innovation = OVector::from_fn_generic(y.shape_generic().0, U1, |k, _| y[k] - xhat[k] - e[k]);
            error_slope += l * innovation;
        }
        EstimateAndError::new(&slope, &error_slope)
    }

    fn estimate(&self, _t: T, state: &Self::State, _u: &Self::Input, _y: &Self::Output) -> Self::Estimate {
        state.estimate()
    }

    fn initial(&self, _t: T, estimate: &Self::Estimate, _u: &Self::Input, _y: &Self::Output) -> Self::State {
        EstimateAndError::new(estimate, &self.internal_error)
    }
}

/// `alpha_k` of eq. (6): the sum of row k and of column k of |D|.
fn gain<T: RealField + Copy, N: Dim>(d: &OMatrix<T, N, N>, k: usize) -> T
where
    DefaultAllocator: Allocator<N, N>,
{
    (0..d.nrows()).fold(T::zero(), |sum, j| sum + d[(k, j)].abs() + d[(j, k)].abs())
}
