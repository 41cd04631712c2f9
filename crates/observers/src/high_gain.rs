//! High-gain observers: chains of integrators, each corrected by the error of its first state.
//!
//! ```text
//! xi_i' = b_i(t, xi, u, y) + s_i(t, u, y) (alpha_i/r^j) (y_k - head_k)         state i at position j = 1, 2, ... of the chain of output k
//! ```
//!
//! head_k is the state at position 1 of chain k, `r` in (0, 1] is small, and `s^n + alpha_1 s^(n-1) + ... + alpha_n` is
//! Hurwitz for each chain. In a pure chain of integrators (`b_i = xi_(i+1)`, all s_i = 1) the poles of the error are
//! the roots of that polynomial divided by r. The shape s_i is what makes a chain with other coefficients behave like a
//! pure one: a state that enters the equation before it with the factor c gets s = 1/c.
//!
//! They converge fast and amplify noise by about `r^-(n - 1)`, and overshoot in between by as much (peaking).
//!
//! Source: H. K. Khalil, High-Gain Observers in Nonlinear Feedback Control, SIAM 2017; J. P. Gauthier, H. Hammouri and
//! S. Othman, IEEE Transactions on Automatic Control 37, 1992.

use luenberger_plants::PlantError;
use luenberger_plants::error::check_matrix;
use nalgebra::allocator::Allocator;
use nalgebra::{Const, DefaultAllocator, Dim, OVector, RealField, U1};

use crate::diagnosis::{Diagnose, Diagnosis};
use crate::error::ObserverError;
use crate::filters::{all_positive, positive};
use crate::observer::{Observer, ObserverDimensions};

/// Every column of a high-gain observer can be stored. Never implement it yourself.
#[diagnostic::on_unimplemented(
    message = "not every column and matrix of a high-gain observer of these sizes can be stored",
    note = "sizes `nalgebra::Const` and, with the feature `alloc`, `nalgebra::Dyn` can be stored in all combinations",
    note = "code that is generic in the sizes needs the bound `DefaultAllocator: HighGainSize<Z, M, P, E>`"
)]
pub trait HighGainSize<Z: Dim, M: Dim, P: Dim, E: Dim>:
    Allocator<Z> + Allocator<M> + Allocator<P> + Allocator<E>
{
}

impl<Z: Dim, M: Dim, P: Dim, E: Dim> HighGainSize<Z, M, P, E> for DefaultAllocator where
    DefaultAllocator: Allocator<Z> + Allocator<M> + Allocator<P> + Allocator<E>
{
}

/// Chain and position of a state of a high-gain observer.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct ChainPosition {
    /// Index of the output whose error corrects the state, from 0.
    pub output: usize,
    /// Position in the chain, from 1: the power of 1/r.
    pub position: usize,
}

/// The maps of a high-gain observer.
#[diagnostic::on_unimplemented(
    message = "`{Self}` does not have the maps of a high-gain observer over the scalar `{T}`",
    note = "implement `HighGainMap<T>` for every `T: RealField + Copy`, or for the scalar that is used"
)]
pub trait HighGainMap<T: RealField + Copy>
where
    DefaultAllocator: HighGainSize<Self::Xi, Self::Inputs, Self::Outputs, Self::Estimate>,
{
    /// Number of states of the observer.
    type Xi: Dim;
    /// Number of inputs.
    type Inputs: Dim;
    /// Number of outputs.
    type Outputs: Dim;
    /// Length of the estimate.
    type Estimate: Dim;

    /// Lengths of the columns. Required where one of the types is [`nalgebra::Dyn`].
    fn dimensions(&self) -> ObserverDimensions {
        ObserverDimensions::of::<Self::Xi, Self::Inputs, Self::Outputs, Self::Estimate>()
    }

    /// Chain and position of state `i`.
    fn place(&self, i: usize) -> ChainPosition;

    /// `b(t, xi, u, y)`: the right-hand side without correction.
    fn drift(
        &self,
        t: T,
        xi: &OVector<T, Self::Xi>,
        u: &OVector<T, Self::Inputs>,
        y: &OVector<T, Self::Outputs>,
    ) -> OVector<T, Self::Xi>;

    /// `s(t, u, y)`, the shape of the correction (default all 1).
    fn shape(&self, _t: T, _u: &OVector<T, Self::Inputs>, _y: &OVector<T, Self::Outputs>) -> OVector<T, Self::Xi> {
        OVector::repeat_generic(Self::Xi::from_usize(self.dimensions().state), U1, T::one())
    }

    /// The estimate xhat as a function of the state xi.
    fn estimate(
        &self,
        t: T,
        xi: &OVector<T, Self::Xi>,
        u: &OVector<T, Self::Inputs>,
        y: &OVector<T, Self::Outputs>,
    ) -> OVector<T, Self::Estimate>;

    /// The divisor of the maps and its lower bound, where they divide (default `None`); for [`Diagnose`].
    fn divisor(&self, _t: T, _u: &OVector<T, Self::Inputs>, _y: &OVector<T, Self::Outputs>) -> Option<(T, T)> {
        None
    }

    /// The initial state for an estimate, with the heads of the chains at y.
    fn start(
        &self,
        t: T,
        estimate: &OVector<T, Self::Estimate>,
        u: &OVector<T, Self::Inputs>,
        y: &OVector<T, Self::Outputs>,
    ) -> OVector<T, Self::Xi>;
}

/// A high-gain observer with the maps `H` and `Z` states; see the [module](self).
///
/// The velocity of a cart from its position, `x1' = x2`, `x2' = u - x2|x2|`:
/// ```
/// use luenberger_observers::high_gain::{HighGainMap, HighGainObserver, ChainPosition};
/// use luenberger_observers::{Observer, ObserverError};
/// use nalgebra::{U1, U2, Vector1, Vector2};
///
/// #[derive(Debug)]
/// struct Cart;
///
/// impl HighGainMap<f64> for Cart {
///     type Xi = U2;
///     type Inputs = U1;
///     type Outputs = U1;
///     type Estimate = U1;
///     fn place(&self, i: usize) -> ChainPosition {
///         ChainPosition { output: 0, position: i + 1 }
///     }
///     fn drift(&self, _t: f64, xi: &Vector2<f64>, u: &Vector1<f64>, _y: &Vector1<f64>) -> Vector2<f64> {
///         Vector2::new(xi[1], u[0] - xi[1] * xi[1].abs())
///     }
///     fn estimate(&self, _t: f64, xi: &Vector2<f64>, _u: &Vector1<f64>, _y: &Vector1<f64>) -> Vector1<f64> {
///         Vector1::new(xi[1])
///     }
///     fn start(&self, _t: f64, estimate: &Vector1<f64>, _u: &Vector1<f64>, y: &Vector1<f64>) -> Vector2<f64> {
///         Vector2::new(y[0], estimate[0])
///     }
/// }
///
/// let observer = HighGainObserver::new(Cart, Vector2::new(2.0, 1.0), 0.125)?;
/// // alpha_1/r, alpha_2/r^2: a double pole at -8.
/// assert_eq!(*observer.gain(), Vector2::new(16.0, 64.0));
/// let slope = observer.derivative(0.0, &Vector2::new(0.0, 1.0), &Vector1::new(0.5), &Vector1::new(0.25));
/// assert_eq!(slope, Vector2::new(1.0 + 4.0, 0.5 - 1.0 + 16.0));
/// assert_eq!(
///     HighGainObserver::new(Cart, Vector2::new(2.0, 1.0), 0.0).unwrap_err(),
///     ObserverError::NotPositive { what: "r", value: 0.0 }
/// );
/// # Ok::<(), ObserverError>(())
/// ```
///
/// Fields are read through methods, because the constructor has checked them.
#[derive(Clone, Debug, PartialEq)]
pub struct HighGainObserver<H, T: RealField + Copy, Z: Dim>
where
    DefaultAllocator: Allocator<Z>,
{
    map: H,
    /// `alpha_i/r^j`.
    gain: OVector<T, Z>,
    /// Where every run starts, if not where the estimate says.
    fixed_start: Option<OVector<T, Z>>,
}

/// A high-gain observer whose number of states Z is known at compile time.
pub type StaticHighGainObserver<H, T, const Z: usize> = HighGainObserver<H, T, Const<Z>>;

impl<H, T: RealField + Copy, Z: Dim> HighGainObserver<H, T, Z>
where
    H: HighGainMap<T, Xi = Z>,
    DefaultAllocator: HighGainSize<Z, H::Inputs, H::Outputs, H::Estimate>,
{
    /// The observer with coefficients alpha_i > 0, one for each state, and the small number r.
    ///
    /// That the polynomials are Hurwitz is not checked (for chains of two, positive coefficients are enough).
    /// # Errors
    /// [`ObserverError::NotPositive`], [`ObserverError::Matrix`] for a wrong number of coefficients,
    /// [`ObserverError::Chain`] for a state whose chain has no head or whose output does not exist.
    pub fn new(map: H, alpha: OVector<T, Z>, r: T) -> Result<Self, ObserverError> {
        let size = map.dimensions();
        if alpha.nrows() != size.state {
            let (expected, found) = ((size.state, 1), alpha.shape());
            return Err(PlantError::DimensionMismatch { what: "alpha", expected, found }.into());
        }
        all_positive("a coefficient alpha", &alpha)?;
        positive("r", r)?;
        for state in 0..size.state {
            let ChainPosition { output, position } = map.place(state);
            let heads = (0..size.state).filter(|&i| map.place(i) == ChainPosition { output, position: 1 }).count();
            if output >= size.outputs || position == 0 || heads != 1 {
                return Err(ObserverError::Chain { state, output, position, heads });
            }
        }
        let mut gain = alpha;
        for (i, gain) in gain.iter_mut().enumerate() {
            *gain = (0..map.place(i).position).fold(*gain, |gain, _| gain / r);
            positive("alpha/r^j", *gain)?;
        }
        Ok(Self { map, gain, fixed_start: None })
    }

    /// The same observer, whose state always starts at `xi`, whatever the initial estimate (papers often take zero).
    ///
    /// # Errors
    /// [`ObserverError::Matrix`] for its length and its entries.
    pub fn starting_at(self, xi: OVector<T, Z>) -> Result<Self, ObserverError> {
        check_matrix("xi(0)", &xi, (self.gain.nrows(), 1))?;
        Ok(Self { fixed_start: Some(xi), ..self })
    }

    /// The maps.
    pub fn map(&self) -> &H {
        &self.map
    }

    /// `alpha_i/r^j`, one for each state.
    pub fn gain(&self) -> &OVector<T, Z> {
        &self.gain
    }
}

impl<H, T: RealField + Copy, Z: Dim> Observer<T> for HighGainObserver<H, T, Z>
where
    H: HighGainMap<T, Xi = Z>,
    DefaultAllocator: HighGainSize<Z, H::Inputs, H::Outputs, H::Estimate>,
{
    type State = OVector<T, Z>;
    type Input = OVector<T, H::Inputs>;
    type Output = OVector<T, H::Outputs>;
    type Estimate = OVector<T, H::Estimate>;

    fn dimensions(&self) -> ObserverDimensions {
        self.map.dimensions()
    }

    fn derivative(&self, t: T, xi: &Self::State, u: &Self::Input, y: &Self::Output) -> Self::State {
        // y_k - head_k.
        let mut error = y.clone();
        for i in 0..xi.nrows() {
            let ChainPosition { output, position } = self.map.place(i);
            if position == 1 {
                error[output] -= xi[i];
            }
        }
        let shape = self.map.shape(t, u, y);
        let mut slope = self.map.drift(t, xi, u, y);
        for i in 0..xi.nrows() {
            slope[i] += shape[i] * self.gain[i] * error[self.map.place(i).output];
        }
        slope
    }

    fn estimate(&self, t: T, xi: &Self::State, u: &Self::Input, y: &Self::Output) -> Self::Estimate {
        self.map.estimate(t, xi, u, y)
    }

    fn initial(&self, t: T, estimate: &Self::Estimate, u: &Self::Input, y: &Self::Output) -> Self::State {
        match &self.fixed_start {
            Some(xi) => xi.clone(),
            None => self.map.start(t, estimate, u, y),
        }
    }
}

impl<H, T: RealField + Copy, Z: Dim> Diagnose<T> for HighGainObserver<H, T, Z>
where
    H: HighGainMap<T, Xi = Z>,
    DefaultAllocator: HighGainSize<Z, H::Inputs, H::Outputs, H::Estimate>,
{
    /// A divisor at its bound, or a right-hand side that is not finite.
    fn diagnose(&self, t: T, xi: &Self::State, u: &Self::Input, y: &Self::Output) -> Diagnosis<T> {
        match self.map.divisor(t, u, y) {
            Some((divisor, bound)) if divisor <= bound => return Diagnosis::Division { divisor, bound },
            _ => {}
        }
        match self.derivative(t, xi, u, y).iter().position(|entry| !entry.is_finite()) {
            Some(entry) => Diagnosis::Overflow { entry },
            None => Diagnosis::Sound,
        }
    }
}
