//! The embedded left inverse for held inputs: trees of polynomials alone, without tables.
//!
//! The tree that gives the state is that of [`HeldInputInverse`](super::HeldInputInverse), with the same bits; a
//! second one gives `T(x, u)`, which only the start of an observer uses.

#[cfg(feature = "alloc")]
extern crate alloc;

use nalgebra::{RealField, SVector};

use crate::error::ObserverError;
use crate::numerical_kkl::polynomial_tree::{check_box, clamped};
use crate::numerical_kkl::{Coordinates, Node, PolynomialTree};

/// `T^-L(z, u)` and `T(x, u)` for N states, M inputs and Z target states, `ZM = Z + M` and `NM = N + M`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct HeldInputTrees<T, K, V, const N: usize, const M: usize, const Z: usize, const ZM: usize, const NM: usize> {
    coordinates: Coordinates<T, Z>,
    bounds: (SVector<T, N>, SVector<T, N>),
    family: (SVector<T, M>, SVector<T, M>),
    inverse: PolynomialTree<T, K, V, ZM, N>,
    forward: PolynomialTree<T, K, V, NM, Z>,
}

/// [`HeldInputTrees`] on the heap.
#[cfg(feature = "alloc")]
pub type TreesOnHeap<T, const N: usize, const M: usize, const Z: usize, const ZM: usize, const NM: usize> =
    HeldInputTrees<T, alloc::vec::Vec<Node<T>>, alloc::vec::Vec<T>, N, M, Z, ZM, NM>;

impl<T, K, V, const N: usize, const M: usize, const Z: usize, const ZM: usize, const NM: usize>
    HeldInputTrees<T, K, V, N, M, Z, ZM, NM>
where
    T: RealField + Copy,
    K: AsRef<[Node<T>]>,
    V: AsRef<[T]>,
{
    /// From `(W (z - m), u)` to the state by `inverse`, from `(x, u)` to `W (T(x, u) - m)` by `forward`. Estimates stay
    /// between `bounds`, and inputs are taken between those of `family`.
    ///
    /// # Errors
    /// [`ObserverError::Box`] unless lower ends are below upper ones, all finite; [`ObserverError::Table`] unless
    /// `ZM = Z + M` and `NM = N + M`.
    pub fn new(
        coordinates: Coordinates<T, Z>,
        bounds: (SVector<T, N>, SVector<T, N>),
        family: (SVector<T, M>, SVector<T, M>),
        (inverse, forward): (PolynomialTree<T, K, V, ZM, N>, PolynomialTree<T, K, V, NM, Z>),
    ) -> Result<Self, ObserverError> {
        check_box(&bounds.0, &bounds.1)?;
        check_box(&family.0, &family.1)?;
        for (what, expected, found) in [
            ("the arguments of the tree, target states and inputs", Z + M, ZM),
            ("the arguments of the tree, states and inputs", N + M, NM),
        ] {
            if expected != found {
                return Err(ObserverError::Table { what, expected, found });
            }
        }
        Ok(Self { coordinates, bounds, family, inverse, forward })
    }

    /// `T^-L(z, u)`, in the box.
    pub fn state(&self, z: &SVector<T, Z>, u: &SVector<T, M>) -> SVector<T, N> {
        let (w, u) = (self.coordinates.white(z), clamped(u, &self.family.0, &self.family.1));
        let guess = self.inverse.at(&SVector::from_fn(|i, _| if i < Z { w[i] } else { u[i - Z] }));
        clamped(&guess, &self.bounds.0, &self.bounds.1)
    }

    /// `T(x, u)` for x in the box, to the accuracy of the fit; outside, the value at the nearest point of the box.
    pub fn target(&self, x: &SVector<T, N>, u: &SVector<T, M>) -> SVector<T, Z> {
        let (x, u) = (clamped(x, &self.bounds.0, &self.bounds.1), clamped(u, &self.family.0, &self.family.1));
        self.coordinates.coloured(&self.forward.at(&SVector::from_fn(|i, _| if i < N { x[i] } else { u[i - N] })))
    }

    /// The coordinates.
    pub fn coordinates(&self) -> &Coordinates<T, Z> {
        &self.coordinates
    }

    /// The box in which estimates stay.
    pub fn bounds(&self) -> (&SVector<T, N>, &SVector<T, N>) {
        (&self.bounds.0, &self.bounds.1)
    }

    /// The ends of the family of inputs.
    pub fn family(&self) -> (SVector<T, M>, SVector<T, M>) {
        self.family
    }

    /// The tree from (w, u) to the state.
    pub fn inverse(&self) -> &PolynomialTree<T, K, V, ZM, N> {
        &self.inverse
    }

    /// The tree from (x, u) to w.
    pub fn forward(&self) -> &PolynomialTree<T, K, V, NM, Z> {
        &self.forward
    }

    /// The same over another scalar, on the heap.
    ///
    /// # Errors
    /// As [`new`](Self::new): ends that are one number of the other scalar.
    #[cfg(feature = "alloc")]
    pub fn cast<U: RealField + Copy>(&self) -> Result<TreesOnHeap<U, N, M, Z, ZM, NM>, ObserverError> {
        fn ends<T: RealField + Copy, U: RealField + Copy, const L: usize>(
            (low, high): (SVector<T, L>, SVector<T, L>),
        ) -> (SVector<U, L>, SVector<U, L>) {
            let cast = |x: T| nalgebra::convert::<f64, U>(x.to_subset_unchecked());
            (low.map(cast), high.map(cast))
        }
        let trees = (self.inverse.cast(), self.forward.cast());
        HeldInputTrees::new(self.coordinates.cast(), ends(self.bounds), ends(self.family), trees)
    }
}
