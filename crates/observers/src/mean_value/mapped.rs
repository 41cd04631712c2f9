//! An observer of a plant in other coordinates, with the estimate in the plant's coordinates: `xhat = T zhat`.

use nalgebra::allocator::Allocator;
use nalgebra::{Const, DefaultAllocator, Dim, OMatrix, OVector, RealField};

use luenberger_plants::Plant;
use luenberger_plants::coordinates::InCoordinates;

use crate::observer::{Observer, ObserverDimensions};

/// The observer `O` of `z' = T^-1 f(T z, u)` with its estimate mapped by T. Its own state stays in the coordinates z.
#[derive(Clone, Debug, PartialEq)]
pub struct MappedObserver<O, T: RealField + Copy, N: Dim>
where
    DefaultAllocator: Allocator<N, N>,
{
    observer: O,
    matrix: OMatrix<T, N, N>,
    inverse: OMatrix<T, N, N>,
}

/// A mapped observer whose number of states is known at compile time; the other sizes are those of `O`.
pub type StaticMappedObserver<O, T, const N: usize> = MappedObserver<O, T, Const<N>>;

impl<O, T: RealField + Copy, N: Dim> MappedObserver<O, T, N>
where
    O: Observer<T, Estimate = OVector<T, N>>,
    DefaultAllocator: Allocator<N, N> + Allocator<N>,
{
    /// `observer`, which observes `plant`, with its estimate in the coordinates of the plant inside.
    ///
    /// ```
    /// use luenberger_observers::mean_value::{Integral, MappedObserver, MeanValueObserver};
    /// use luenberger_observers::Observer;
    /// use luenberger_plants::coordinates::InCoordinates;
    /// use luenberger_plants::{LinearPlant, Plant};
    /// use nalgebra::{Matrix2, RowVector2, SMatrix, SVector, Vector1, Vector2};
    ///
    /// // y = 2 x1 is no state; in x = diag(1/2, 1) z it is z1.
    /// let (a, b) = (Matrix2::new(0.0, 1.0, -1.0, -1.0), SMatrix::<f64, 2, 0>::zeros());
    /// let plant = LinearPlant { a, b, c: RowVector2::new(2.0, 0.0), d: None };
    /// let other = InCoordinates::measured_first(plant, Matrix2::new(0.5, 0.0, 0.0, 1.0))?;
    /// let observer = MeanValueObserver::new(other.clone(), 1.0, Integral, Vector2::zeros())?;
    /// let observer = MappedObserver::new(&other, observer);
    /// let (xhat, u, y) = (Vector2::new(3.0, 4.0), SVector::zeros(), Vector1::new(6.0));
    /// let state = observer.initial(0.0, &xhat, &u, &y);
    /// assert_eq!(observer.estimate(0.0, &state, &u, &y), xhat);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn new<S>(plant: &InCoordinates<S, T, N>, observer: O) -> Self
    where
        S: Plant<T, State = OVector<T, N>>,
    {
        Self { observer, matrix: plant.matrix().clone(), inverse: plant.inverse().clone() }
    }

    /// The observer in the coordinates z.
    pub fn inner(&self) -> &O {
        &self.observer
    }
}

impl<O, T: RealField + Copy, N: Dim> Observer<T> for MappedObserver<O, T, N>
where
    O: Observer<T, Estimate = OVector<T, N>>,
    DefaultAllocator: Allocator<N, N> + Allocator<N>,
{
    type State = O::State;
    type Input = O::Input;
    type Output = O::Output;
    type Estimate = OVector<T, N>;

    fn dimensions(&self) -> ObserverDimensions {
        self.observer.dimensions()
    }

    fn derivative(&self, t: T, state: &Self::State, u: &Self::Input, y: &Self::Output) -> Self::State {
        self.observer.derivative(t, state, u, y)
    }

    fn estimate(&self, t: T, state: &Self::State, u: &Self::Input, y: &Self::Output) -> Self::Estimate {
        &self.matrix * self.observer.estimate(t, state, u, y)
    }

    fn initial(&self, t: T, estimate: &Self::Estimate, u: &Self::Input, y: &Self::Output) -> Self::State {
        self.observer.initial(t, &(&self.inverse * estimate), u, y)
    }
}
