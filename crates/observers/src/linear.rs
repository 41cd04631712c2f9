//! Luenberger's observer `xhat' = (A - L C) xhat + B u + L (y - D u)`: eq. (2) of the cubic-observer paper, where D =
//! 0.
//!
//! Its error obeys `e' = (A - L C) e`, whatever the input.

use luenberger_plants::error::check_matrix;
use luenberger_plants::{LinearPlant, Size};
use nalgebra::{Const, DefaultAllocator, Dim, OMatrix, RealField};

use crate::dense::{entry, with_column};
use crate::error::ObserverError;
use crate::feedthrough;
use crate::observer::{Observer, ObserverDimensions, state_is_estimate};

/// `xhat' = A xhat + B u + L (y - C xhat - D u)` with N states, M inputs and P outputs.
///
/// ```
/// use luenberger_observers::LinearObserver;
/// use nalgebra::Vector2;
/// let plant = luenberger_plants::double_integrator();
/// let observer = LinearObserver::new(plant.a, plant.b, plant.c, Vector2::new(7.0, 10.0))?;
/// assert_eq!(observer.to_string(), "A = [0, 1; 0, 0]\nB = [0; 1]\nC = [1, 0]\nL = [7; 10]");
/// # Ok::<(), luenberger_observers::ObserverError>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct LinearObserver<T: RealField + Copy, N: Dim, M: Dim, P: Dim>
where
    DefaultAllocator: Size<N, M, P>,
{
    /// State matrix, n x n.
    pub a: OMatrix<T, N, N>,
    /// Input matrix, n x m.
    pub b: OMatrix<T, N, M>,
    /// Output matrix, p x n.
    pub c: OMatrix<T, P, N>,
    /// Feedthrough matrix, p x m; `None` where the output does not depend on the input.
    pub d: Option<OMatrix<T, P, M>>,
    /// Observer gain, n x p.
    pub l: OMatrix<T, N, P>,
}

/// A linear observer whose sizes are known at compile time.
pub type StaticLinearObserver<T, const N: usize, const M: usize, const P: usize> =
    LinearObserver<T, Const<N>, Const<M>, Const<P>>;

impl<T: RealField + Copy, N: Dim, M: Dim, P: Dim> LinearObserver<T, N, M, P>
where
    DefaultAllocator: Size<N, M, P>,
{
    /// The plant that is observed.
    pub fn plant(&self) -> LinearPlant<T, N, M, P> {
        LinearPlant { a: self.a.clone(), b: self.b.clone(), c: self.c.clone(), d: self.d.clone() }
    }

    /// The gain L, n x p.
    pub fn l(&self) -> &OMatrix<T, N, P> {
        &self.l
    }

    /// The observer with gain L (n x p) of the plant (A, B, C).
    ///
    /// ```
    /// use luenberger_observers::{LinearObserver, Observer};
    /// use nalgebra::{Vector1, Vector2};
    /// let plant = luenberger_plants::double_integrator();
    /// let observer = LinearObserver::new(plant.a, plant.b, plant.c, Vector2::new(7.0, 10.0))?;
    /// let slope = observer.derivative(0.0, &Vector2::zeros(), &Vector1::new(0.5), &Vector1::new(-3.0));
    /// assert_eq!(slope, Vector2::new(-21.0, -29.5));
    /// # Ok::<(), luenberger_observers::ObserverError>(())
    /// ```
    /// # Errors
    /// [`ObserverError::Matrix`]: shapes that do not fit, entries that are not finite.
    pub fn new(
        a: OMatrix<T, N, N>,
        b: OMatrix<T, N, M>,
        c: OMatrix<T, P, N>,
        l: OMatrix<T, N, P>,
    ) -> Result<Self, ObserverError> {
        Self::of(LinearPlant::new(a, b, c)?, l)
    }

    /// The observer with gain L (n x p) of `plant`, and with its D.
    ///
    /// # Errors
    /// [`ObserverError::Matrix`]: L of another shape, entries that are not finite.
    pub fn of(plant: LinearPlant<T, N, M, P>, l: OMatrix<T, N, P>) -> Result<Self, ObserverError> {
        let LinearPlant { a, b, c, d } = plant.checked()?;
        check_matrix("L", &l, (a.nrows(), c.nrows()))?;
        Ok(Self { a, b, c, d, l })
    }
}

impl<T: RealField + Copy, N: Dim, M: Dim, P: Dim> Observer<T> for LinearObserver<T, N, M, P>
where
    DefaultAllocator: Size<N, M, P>,
{
    state_is_estimate! { Observer }

    fn dimensions(&self) -> ObserverDimensions {
        ObserverDimensions {
            state: self.a.nrows(),
            inputs: self.b.ncols(),
            outputs: self.c.nrows(),
            estimate: self.a.nrows(),
        }
    }

    fn derivative(&self, t: T, xhat: &Self::State, u: &Self::Input, y: &Self::Output) -> Self::State {
        let mut slope = xhat.clone();
        let fits = self.derivative_into(t, xhat.as_slice(), u.as_slice(), y.as_slice(), slope.as_mut_slice());
        debug_assert!(fits, "columns of other lengths than the observer's");
        slope
    }

    fn is_affine(&self) -> bool {
        true
    }

    fn derivative_into(&self, _t: T, xhat: &[T], u: &[T], y: &[T], slope: &mut [T]) -> bool {
        let (order, outputs) = self.l.shape_generic();
        let fits = (xhat.len(), u.len(), y.len()) == (order.value(), self.b.ncols(), outputs.value());
        let fits = fits && slope.len() == xhat.len();
        if fits {
            with_column(outputs, |innovation| {
                feedthrough::innovation(&self.c, self.d.as_ref(), (xhat, u, y), innovation);
                for (i, slope) in slope.iter_mut().enumerate() {
                    *slope = entry(&self.a, i, xhat) + entry(&self.b, i, u) + entry(&self.l, i, innovation);
                }
            });
        }
        fits
    }
}
