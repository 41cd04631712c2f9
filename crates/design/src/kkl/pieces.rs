//! What a candidate consists of, over any scalar: the plant, and the maps of the observer that is going to run.

use luenberger_observers::kkl::{KklMap, KklSize};
use luenberger_plants::{Column, Dimensions, Plant};
use nalgebra::{DefaultAllocator, OVector, RealField};

use crate::kkl::KklCandidate;

/// The plant and the maps of a [`KklCandidate`] over the scalar `T`. Holds where both are written for it; never implement it yourself.
pub trait Pieces<T> {
    /// n, m, p of the plant.
    fn plant_dimensions(&self) -> Dimensions;
    /// `f(t, x, u)`.
    fn field(&self, t: T, x: &[T], u: &[T]) -> Vec<T>;
    /// `h(t, x)`.
    fn output(&self, t: T, x: &[T]) -> Vec<T>;
    /// `phi(x)`: the map's image of the states that it estimates.
    fn image(&self, t: T, x: &[T], y: &[T]) -> Vec<T>;
    /// `Lambda(t, u, y)`, column by column.
    fn lambda(&self, t: T, u: &[T], y: &[T]) -> Vec<T>;
    /// `B(t, xi, u, y)`.
    fn injection(&self, t: T, xi: &[T], u: &[T], y: &[T]) -> Vec<T>;
    /// `phi^L(t, xi, y)`.
    fn left_inverse(&self, t: T, xi: &[T], y: &[T]) -> Vec<T>;
}

impl<T, S, K> Pieces<T> for KklCandidate<'_, S, K>
where
    T: RealField + Copy,
    S: Plant<T>,
    K: KklMap<T>,
    DefaultAllocator: KklSize<K::Xi, K::Inputs, K::Outputs, K::Estimate>,
{
    fn plant_dimensions(&self) -> Dimensions {
        self.plant.dimensions()
    }

    fn field(&self, t: T, x: &[T], u: &[T]) -> Vec<T> {
        let slope = self.plant.derivative(t, &S::State::from_slice(x), &S::Input::from_slice(u));
        Column::as_slice(&slope).to_vec()
    }

    fn output(&self, t: T, x: &[T]) -> Vec<T> {
        Column::as_slice(&self.plant.output(t, &S::State::from_slice(x))).to_vec()
    }

    fn image(&self, t: T, x: &[T], y: &[T]) -> Vec<T> {
        let estimate: Vec<T> = self.estimated.iter().map(|&k| x[k]).collect();
        let (estimate, y) = (column::<T, K::Estimate>(&estimate), column::<T, K::Outputs>(y));
        self.map.image(t, &estimate, &y).iter().copied().collect()
    }

    fn lambda(&self, t: T, u: &[T], y: &[T]) -> Vec<T> {
        self.map.lambda(t, &column(u), &column(y)).iter().copied().collect()
    }

    fn injection(&self, t: T, xi: &[T], u: &[T], y: &[T]) -> Vec<T> {
        self.map.injection(t, &column(xi), &column(u), &column(y)).iter().copied().collect()
    }

    fn left_inverse(&self, t: T, xi: &[T], y: &[T]) -> Vec<T> {
        self.map.left_inverse(t, &column(xi), &column(y)).iter().copied().collect()
    }
}

/// The lengths were checked when the candidate was made.
fn column<T: RealField + Copy, D: nalgebra::Dim>(entries: &[T]) -> OVector<T, D>
where
    DefaultAllocator: nalgebra::allocator::Allocator<D>,
{
    <OVector<T, D> as Column<T>>::from_slice(entries)
}
