//! The copy of a nonlinear plant, corrected by a constant gain: `xhat' = f(t, xhat, u) + L (y - h(t, xhat, u))`.
//!
//! The run-time form of Thau's, Rajamani's and the LPV (mean value theorem) designs: they differ in how L is found and
//! in what is then proved, not in what runs. Its error obeys `e' = (Fbar - L Hbar) e` with the mean Jacobians of f and
//! h over the segment from xhat to x.
//!
//! Sources: F. E. Thau, Observing the state of non-linear dynamic systems, International Journal of Control 17, 1973;
//! R. Rajamani, Observers for Lipschitz nonlinear systems, IEEE Transactions on Automatic Control 43, 1998.

use core::marker::PhantomData;

use luenberger_plants::error::check_matrix;
use luenberger_plants::{Plant, Size};
use nalgebra::{Const, DefaultAllocator, Dim, OMatrix, OVector, RealField};

use crate::dense::{entry, with_column};
use crate::error::ObserverError;
use crate::observer::{Observer, ObserverDimensions, state_is_estimate};

/// `xhat' = f(t, xhat, u) + L (y - h(t, xhat, u))` for a plant `S` with N states, M inputs and P outputs.
///
/// Fields are read through methods, because the constructor has checked them.
#[derive(Clone, Debug, PartialEq)]
pub struct NonlinearLuenbergerObserver<S, T: RealField + Copy, N: Dim, M: Dim, P: Dim>
where
    DefaultAllocator: Size<N, M, P>,
{
    plant: S,
    l: OMatrix<T, N, P>,
    inputs: PhantomData<M>,
}

/// A nonlinear Luenberger observer whose sizes are known at compile time.
pub type StaticNonlinearLuenbergerObserver<S, T, const N: usize, const M: usize, const P: usize> =
    NonlinearLuenbergerObserver<S, T, Const<N>, Const<M>, Const<P>>;

impl<S, T: RealField + Copy, N: Dim, M: Dim, P: Dim> NonlinearLuenbergerObserver<S, T, N, M, P>
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

impl<S, T: RealField + Copy, N: Dim, M: Dim, P: Dim> NonlinearLuenbergerObserver<S, T, N, M, P>
where
    S: Plant<T, State = OVector<T, N>, Input = OVector<T, M>, Output = OVector<T, P>>,
    DefaultAllocator: Size<N, M, P>,
{
    /// The observer of `plant` with the gain L (n x p).
    ///
    /// ```
    /// use luenberger_observers::{NonlinearLuenbergerObserver, Observer, ObserverError};
    /// use luenberger_plants::{Chaotic, Plant};
    /// use nalgebra::{Matrix3x2, SVector, Vector3};
    /// let l = Matrix3x2::new(1.0, 0.0, 0.0, 2.0, 0.0, 3.0);
    /// let observer = NonlinearLuenbergerObserver::new(Chaotic, l)?;
    /// let (x, u) = (Vector3::new(-2.0, -1.0, -1.0), SVector::zeros());
    /// // On the plant's own state it is the plant.
    /// let y = Chaotic.output(0.0, &x, &u);
    /// assert_eq!(observer.derivative(0.0, &x, &u, &y), Chaotic.derivative(0.0, &x, &u));
    /// # Ok::<(), ObserverError>(())
    /// ```
    /// # Errors
    /// [`ObserverError::Matrix`] for the shape and the entries of L.
    pub fn new(plant: S, l: OMatrix<T, N, P>) -> Result<Self, ObserverError> {
        let size = plant.dimensions();
        check_matrix("L", &l, (size.states, size.outputs))?;
        Ok(Self { plant, l, inputs: PhantomData })
    }
}

impl<S, T: RealField + Copy, N: Dim, M: Dim, P: Dim> Observer<T> for NonlinearLuenbergerObserver<S, T, N, M, P>
where
    S: Plant<T, State = OVector<T, N>, Input = OVector<T, M>, Output = OVector<T, P>>,
    DefaultAllocator: Size<N, M, P>,
{
    state_is_estimate! { Observer }

    fn dimensions(&self) -> ObserverDimensions {
        let size = self.plant.dimensions();
        ObserverDimensions { state: size.states, inputs: size.inputs, outputs: size.outputs, estimate: size.states }
    }

    fn derivative(&self, t: T, xhat: &Self::State, u: &Self::Input, y: &Self::Output) -> Self::State {
        let mut slope = xhat.clone();
        let fits = self.derivative_into(t, xhat.as_slice(), u.as_slice(), y.as_slice(), slope.as_mut_slice());
        debug_assert!(fits, "columns of other lengths than the observer's");
        slope
    }

    fn is_affine(&self) -> bool {
        self.plant.is_affine()
    }

    fn derivative_into(&self, t: T, xhat: &[T], u: &[T], y: &[T], slope: &mut [T]) -> bool {
        let outputs = self.l.shape_generic().1;
        y.len() == outputs.value()
            && with_column(outputs, |innovation| {
                let fits =
                    self.plant.output_into(t, xhat, u, innovation) && self.plant.derivative_into(t, xhat, u, slope);
                for (innovation, y) in innovation.iter_mut().zip(y) {
                    *innovation = *y - *innovation;
                }
                for (i, slope) in slope.iter_mut().enumerate() {
                    *slope += entry(&self.l, i, innovation);
                }
                fits
            })
    }
}
