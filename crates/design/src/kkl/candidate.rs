//! A candidate: the plant, and the maps of the observer as implemented, over any scalar.

use luenberger_observers::ObserverDimensions;
use luenberger_observers::kkl::{KklMap, KklSize};
use luenberger_plants::{Column, Dimensions, Plant, PlantError};
use luenberger_proof::{Interval, Ring};
use nalgebra::{DefaultAllocator, Dim, OVector, RealField};

use super::error::KklError;
use crate::enclosure::IntervalDual;
use crate::enclosure::paths::explore;

/// A plant, and the maps of a KKL observer for it; see the [module](super).
#[derive(Clone, Debug, PartialEq)]
pub struct KklCandidate<'a, S, K> {
    pub(super) plant: &'a S,
    pub(super) map: &'a K,
    pub(super) estimated: Vec<usize>,
    pub(super) order: usize,
}

impl<'a, S, K> KklCandidate<'a, S, K> {
    /// `map` as a KKL observer of `plant`, estimating the states with the indices `estimated`, from 0, in this order.
    ///
    /// # Errors
    /// [`DesignError::Matrix`](crate::DesignError::Matrix) for a map with other numbers of inputs or outputs than the
    /// plant, [`KklError::Estimated`] for the indices.
    pub fn new(plant: &'a S, map: &'a K, estimated: &[usize]) -> Result<Self, KklError>
    where
        S: Plant<IntervalDual>,
        K: KklMap<IntervalDual>,
        DefaultAllocator: KklSize<K::Xi, K::Inputs, K::Outputs, K::Estimate>,
    {
        let (size, own) = (plant.dimensions(), map.dimensions());
        let ObserverDimensions { state: order, inputs, outputs, estimate } = own;
        for (what, fixed, expected) in [
            ("x", S::State::fixed_len(), size.states),
            ("u of the plant", S::Input::fixed_len(), size.inputs),
            ("y of the plant", S::Output::fixed_len(), size.outputs),
            ("u of the map", Some(K::Inputs::try_to_usize().unwrap_or(inputs)), size.inputs),
            ("y of the map", Some(K::Outputs::try_to_usize().unwrap_or(outputs)), size.outputs),
            ("u of the map", Some(inputs), size.inputs),
            ("y of the map", Some(outputs), size.outputs),
            ("xi", K::Xi::try_to_usize(), order),
            ("the estimate", K::Estimate::try_to_usize(), estimate),
        ] {
            let found = fixed.unwrap_or(expected);
            if found != expected {
                return Err(PlantError::DimensionMismatch { what, expected: (expected, 1), found: (found, 1) }.into());
            }
        }
        if order == 0 || size.states == 0 {
            let (expected, found) = ((1, 1), (order.min(size.states), 1));
            return Err(PlantError::DimensionMismatch { what: "xi or x", expected, found }.into());
        }
        let mut sorted = estimated.to_vec();
        sorted.sort_unstable();
        sorted.dedup();
        if estimated.len() != estimate || sorted.len() != estimate || sorted.last().is_some_and(|k| *k >= size.states) {
            let (estimated, count, states) = (estimated.to_vec(), estimate, size.states);
            return Err(KklError::Estimated { estimated, count, states });
        }
        Ok(Self { plant, map, estimated: estimated.to_vec(), order })
    }
}

/// An output whose derivative by an input is not zero, over the box or in its middle.
pub(super) fn feedthrough<C: Pieces<IntervalDual>>(
    candidate: &C,
    axes: &[Interval],
    size: Dimensions,
) -> Option<usize> {
    let middle: Vec<Interval> = axes.iter().map(|axis| Interval::of(axis.midpoint())).collect();
    [axes, &middle].into_iter().find_map(|axes| {
        let (x, u, t) = still(axes, size);
        (0..size.inputs).find_map(|k| {
            let mut u = u.clone();
            u[k] = IntervalDual::new(u[k].value(), Interval::ONE);
            let ways = explore(|| candidate.output_under(t, &x, &u)).ok()?;
            let reads = |y: &IntervalDual| y.slope().is_bounded() && y.slope() != Interval::zero();
            ways.iter().find_map(|way| way.iter().position(reads))
        })
    })
}

/// The plant and the maps of a [`KklCandidate`] over the scalar `T`. Holds where both are written for it; never
/// implement it yourself.
pub trait Pieces<T> {
    /// n, m, p of the plant.
    fn plant_dimensions(&self) -> Dimensions;
    /// `f(t, x, u)`.
    fn field(&self, t: T, x: &[T], u: &[T]) -> Vec<T>;
    /// `h(t, x, u)`.
    fn output_under(&self, t: T, x: &[T], u: &[T]) -> Vec<T>;
    /// `h(t, x)`, of a plant whose output does not depend on the input: the check refuses any other.
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

    fn output_under(&self, t: T, x: &[T], u: &[T]) -> Vec<T> {
        Column::as_slice(&self.plant.output(t, &S::State::from_slice(x), &S::Input::from_slice(u))).to_vec()
    }

    fn output(&self, t: T, x: &[T]) -> Vec<T> {
        self.output_under(t, x, &vec![T::zero(); self.plant.dimensions().inputs])
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
fn column<T: RealField + Copy, D: Dim>(entries: &[T]) -> OVector<T, D>
where
    DefaultAllocator: nalgebra::allocator::Allocator<D>,
{
    <OVector<T, D> as Column<T>>::from_slice(entries)
}

/// States, inputs and time without derivatives.
pub(super) fn still(axes: &[Interval], size: Dimensions) -> (Vec<IntervalDual>, Vec<IntervalDual>, IntervalDual) {
    let mut scalars = axes.iter().map(|axis| IntervalDual::new(*axis, Interval::zero()));
    let x = scalars.by_ref().take(size.states).collect();
    let u = scalars.by_ref().take(size.inputs).collect();
    (x, u, scalars.next().unwrap_or(IntervalDual::new(Interval::zero(), Interval::zero())))
}
