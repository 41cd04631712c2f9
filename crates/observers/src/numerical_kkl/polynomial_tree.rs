//! Piecewise polynomials on a tree of cells: the embedded form of a left inverse.
//!
//! A binary tree of comparisons of one coordinate with a threshold leads to a leaf; the leaf is a polynomial of small
//! total degree in its own local coordinates, one per output, evaluated by nested Horner. Cells are small where the map
//! bends (a cube root at an unobservable equilibrium) and large where it does not. A tree of one leaf is the ordinary
//! polynomial regression.
//!
//! Between leaves the map jumps by as much as the two polynomials differ, which is of the size of the fit's error.
//! Beyond the samples of a leaf its polynomial is held at the border, and its values at about those of the samples:
//! bounded, whatever the input.

#[cfg(feature = "alloc")]
extern crate alloc;

use core::marker::PhantomData;

use nalgebra::{Const, RealField, SVector, convert};

use crate::error::ObserverError;
use crate::kkl::LeftInverse;
use crate::numerical_kkl::Coordinates;

/// Where a comparison leads.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Branch {
    /// To another comparison, by its number.
    Node(u16),
    /// To a leaf, by its number.
    Leaf(u16),
}

/// One comparison: below or above a threshold of one coordinate.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Node<T> {
    /// The coordinate.
    pub axis: u16,
    /// The threshold.
    pub threshold: T,
    /// Where to go below it.
    pub below: Branch,
    /// Where to go otherwise.
    pub above: Branch,
}

/// A map from I coordinates to O, piecewise polynomial of total degree `degree`; `V` lends the coefficients, `K` the
/// comparisons.
///
/// A leaf holds, one after the other, the centre (I), the inverse half-widths (I), the least values (O) and the largest
/// (O) that it may give, and for each output its coefficients in the order in which [`monomials`] names them.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PolynomialTree<T, K, V, const I: usize, const O: usize> {
    degree: usize,
    root: Branch,
    nodes: K,
    leaves: V,
    scalar: PhantomData<T>,
}

impl<T, K, V, const I: usize, const O: usize> PolynomialTree<T, K, V, I, O>
where
    T: RealField + Copy,
    K: AsRef<[Node<T>]>,
    V: AsRef<[T]>,
{
    /// The tree that begins at node 0, or consists of leaf 0 alone when there is no node.
    ///
    /// `x^2 - 1` on [-2, 2], one leaf:
    /// ```
    /// use luenberger_observers::numerical_kkl::{Node, PolynomialTree};
    /// use nalgebra::Vector1;
    /// let nodes: [Node<f64>; 0] = [];
    /// // Centre 0, inverse half-width 1/2, values from -1 to 4, coefficients of s^2, s, 1 for s = x/2.
    /// let tree = PolynomialTree::<_, _, _, 1, 1>::new(2, nodes, [0.0, 0.5, -1.0, 4.0, 4.0, 0.0, -1.0])?;
    /// assert_eq!(tree.at(&Vector1::new(1.5))[0], 1.25);
    /// assert_eq!(tree.at(&Vector1::new(1e300))[0], 4.0);
    /// # Ok::<(), luenberger_observers::ObserverError>(())
    /// ```
    /// # Errors
    /// [`ObserverError::Table`] when the number of coefficients is not a whole number of leaves, when a comparison
    /// leads to a leaf that does not exist or to a comparison that does not come after it (so that every walk ends),
    /// and for degrees above 16; [`ObserverError::TableNotFinite`].
    pub fn new(degree: usize, nodes: K, leaves: V) -> Result<Self, ObserverError> {
        if degree > MOST_DEGREE {
            return Err(ObserverError::Table { what: "the degree", expected: MOST_DEGREE, found: degree });
        }
        let stride = stride::<I, O>(degree);
        let found = leaves.as_ref().len();
        if stride == 0 || found == 0 || !found.is_multiple_of(stride) {
            return Err(ObserverError::Table { what: "the coefficients of the leaves", expected: stride, found });
        }
        finite("the coefficients of the leaves", leaves.as_ref())?;
        let (leaf_count, node_count) = (found / stride, nodes.as_ref().len());
        for (index, node) in nodes.as_ref().iter().enumerate() {
            if usize::from(node.axis) >= I {
                let found = usize::from(node.axis);
                return Err(ObserverError::Table { what: "the axis of a comparison", expected: I, found });
            }
            finite("the thresholds", &[node.threshold])?;
            for branch in [node.below, node.above] {
                match branch {
                    Branch::Leaf(leaf) if usize::from(leaf) >= leaf_count => {
                        let found = usize::from(leaf);
                        return Err(ObserverError::Table { what: "the number of a leaf", expected: leaf_count, found });
                    }
                    Branch::Node(next) if usize::from(next) <= index || usize::from(next) >= node_count => {
                        let found = usize::from(next);
                        return Err(ObserverError::Table { what: "the next comparison", expected: index + 1, found });
                    }
                    _ => {}
                }
            }
        }
        let root = if node_count == 0 { Branch::Leaf(0) } else { Branch::Node(0) };
        Ok(Self { degree, root, nodes, leaves, scalar: PhantomData })
    }

    /// The value at `point`.
    pub fn at(&self, point: &SVector<T, I>) -> SVector<T, O> {
        // What new() has checked is out of the compiler's sight: an index would keep a panic on a target.
        let mut branch = self.root;
        let leaf = loop {
            match branch {
                Branch::Leaf(leaf) => break usize::from(leaf),
                Branch::Node(index) => {
                    let Some(node) = self.nodes.as_ref().get(usize::from(index)) else { break 0 };
                    let below = point.get(usize::from(node.axis)).is_some_and(|x| *x < node.threshold);
                    branch = if below { node.below } else { node.above };
                }
            }
        };
        let data = self.leaves.as_ref().chunks_exact(stride::<I, O>(self.degree).max(1)).nth(leaf).unwrap_or(&[]);
        let number = |k: usize| data.get(k).copied().unwrap_or_else(T::zero);
        // A little beyond the samples a low-degree polynomial is still good; far beyond it is held.
        let reach = convert::<f64, T>(REACH);
        let local = SVector::<T, I>::from_fn(|i, _| between((point[i] - number(i)) * number(I + i), -reach, reach));
        let mut coefficients = data.get(2 * (I + O)..).unwrap_or(&[]).iter();
        SVector::from_fn(|o, _| {
            let value = horner(&mut coefficients, self.degree, local.as_slice());
            between(value, number(2 * I + o), number(2 * I + O + o))
        })
    }

    /// Total degree of the polynomials.
    pub fn degree(&self) -> usize {
        self.degree
    }

    /// Number of leaves.
    pub fn leaf_count(&self) -> usize {
        self.leaves.as_ref().len() / stride::<I, O>(self.degree)
    }

    /// Numbers stored: those of the leaves, and one threshold per comparison.
    pub fn numbers(&self) -> usize {
        self.leaves.as_ref().len() + self.nodes.as_ref().len()
    }

    /// Multiply-adds per evaluation, comparisons apart: of each output as many as it has coefficients, and as many as
    /// polynomials of the same degree in fewer variables have.
    pub fn multiply_adds(&self) -> usize {
        I + O * (1..=I).map(|variables| monomial_count(variables, self.degree)).sum::<usize>()
    }

    /// The longest walk from the root to a leaf, in comparisons.
    pub fn depth(&self) -> usize {
        // Children come after their parents: from the end, every depth is known when it is asked for.
        fn below<T>(nodes: &[Node<T>], branch: Branch) -> usize {
            match branch {
                Branch::Leaf(_) => 0,
                Branch::Node(index) => {
                    let node = &nodes[usize::from(index)];
                    1 + below(nodes, node.below).max(below(nodes, node.above))
                }
            }
        }
        below(self.nodes.as_ref(), self.root)
    }

    /// The same over another scalar, on the heap.
    #[cfg(feature = "alloc")]
    pub fn cast<U: RealField + Copy>(&self) -> PolynomialTree<U, alloc::vec::Vec<Node<U>>, alloc::vec::Vec<U>, I, O> {
        let cast = |x: T| convert::<f64, U>(x.to_subset_unchecked());
        PolynomialTree {
            degree: self.degree,
            root: self.root,
            nodes: self
                .nodes
                .as_ref()
                .iter()
                .map(|node| Node {
                    axis: node.axis,
                    threshold: cast(node.threshold),
                    below: node.below,
                    above: node.above,
                })
                .collect(),
            leaves: self.leaves.as_ref().iter().map(|&x| cast(x)).collect(),
            scalar: PhantomData,
        }
    }

    /// The comparisons.
    pub fn nodes(&self) -> &[Node<T>] {
        self.nodes.as_ref()
    }

    /// The numbers of the leaves, one leaf after the other.
    pub fn leaves(&self) -> &[T] {
        self.leaves.as_ref()
    }
}

/// Degrees beyond this are not polynomials anybody evaluates by powers.
const MOST_DEGREE: usize = 16;

/// Numbers of one leaf.
fn stride<const I: usize, const O: usize>(degree: usize) -> usize {
    2 * (I + O) + O * monomial_count(I, degree)
}

/// How far beyond its samples, in half-widths from its centre, the polynomial of a leaf is followed.
const REACH: f64 = 1.125;

/// Number of monomials of total degree at most `degree` in `variables` variables.
pub const fn monomial_count(variables: usize, degree: usize) -> usize {
    let (mut count, mut i) = (1, 1);
    while i <= variables {
        count = count * (degree + i) / i;
        i += 1;
    }
    count
}

/// Names the monomials of total degree at most `degree` at `point`, times `factor`, in the order of the coefficients.
pub fn monomials<T: RealField + Copy>(point: &[T], degree: usize, factor: T, visit: &mut impl FnMut(T)) {
    match point.split_last() {
        None => visit(factor),
        Some((&last, rest)) => {
            for power in (0..=degree).rev() {
                let factor = (0..power).fold(factor, |product, _| product * last);
                monomials(rest, degree - power, factor, visit);
            }
        }
    }
}

/// The polynomial whose coefficients `coefficients` lends next: highest power of the last variable first.
fn horner<T: RealField + Copy>(coefficients: &mut core::slice::Iter<'_, T>, degree: usize, point: &[T]) -> T {
    match point.split_last() {
        None => coefficients.next().copied().unwrap_or_else(T::zero),
        Some((&last, rest)) => {
            (0..=degree).rev().fold(T::zero(), |sum, power| sum * last + horner(coefficients, degree - power, rest))
        }
    }
}

/// Every number is finite.
pub(super) fn finite<T: RealField + Copy>(what: &'static str, numbers: &[T]) -> Result<(), ObserverError> {
    match numbers.iter().position(|x| !x.is_finite()) {
        None => Ok(()),
        Some(index) => Err(ObserverError::TableNotFinite { what, index, value: numbers[index].to_subset_unchecked() }),
    }
}

/// The embedded form: `xhat` from z by one tree, `T(x)` by another, both in [`Coordinates`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PolynomialInverse<T, K, V, const N: usize, const Z: usize> {
    coordinates: Coordinates<T, Z>,
    lower: SVector<T, N>,
    upper: SVector<T, N>,
    inverse: PolynomialTree<T, K, V, Z, N>,
    forward: PolynomialTree<T, K, V, N, Z>,
}

impl<T, K, V, const N: usize, const Z: usize> PolynomialInverse<T, K, V, N, Z>
where
    T: RealField + Copy,
    K: AsRef<[Node<T>]>,
    V: AsRef<[T]>,
{
    /// From `w = W (z - m)` to the state by `inverse`, from the state to w by `forward`; estimates stay between `lower`
    /// and `upper`.
    ///
    /// # Errors
    /// [`ObserverError::Box`] unless `lower < upper` in every entry, all finite.
    pub fn new(
        coordinates: Coordinates<T, Z>,
        (lower, upper): (SVector<T, N>, SVector<T, N>),
        inverse: PolynomialTree<T, K, V, Z, N>,
        forward: PolynomialTree<T, K, V, N, Z>,
    ) -> Result<Self, ObserverError> {
        check_box(&lower, &upper)?;
        Ok(Self { coordinates, lower, upper, inverse, forward })
    }

    /// `T^-L(z)`: the state whose image is z, or one whose image comes near, always in the box.
    pub fn state(&self, z: &SVector<T, Z>) -> SVector<T, N> {
        clamped(&self.inverse.at(&self.coordinates.white(z)), &self.lower, &self.upper)
    }

    /// `T(x)` for x in the box, to the accuracy of the fit; outside, the value at the nearest point of the box.
    pub fn target(&self, x: &SVector<T, N>) -> SVector<T, Z> {
        self.coordinates.coloured(&self.forward.at(&clamped(x, &self.lower, &self.upper)))
    }

    /// The tree from w to the state.
    pub fn inverse(&self) -> &PolynomialTree<T, K, V, Z, N> {
        &self.inverse
    }

    /// The tree from the state to w: used by `initial` alone, and of no interest where the observer starts at z = 0.
    pub fn forward(&self) -> &PolynomialTree<T, K, V, N, Z> {
        &self.forward
    }

    /// The coordinates.
    pub fn coordinates(&self) -> &Coordinates<T, Z> {
        &self.coordinates
    }

    /// The box in which estimates stay.
    pub fn bounds(&self) -> (&SVector<T, N>, &SVector<T, N>) {
        (&self.lower, &self.upper)
    }

    /// The same over another scalar, on the heap.
    #[cfg(feature = "alloc")]
    pub fn cast<U: RealField + Copy>(
        &self,
    ) -> PolynomialInverse<U, alloc::vec::Vec<Node<U>>, alloc::vec::Vec<U>, N, Z> {
        let cast = |x: T| convert::<f64, U>(x.to_subset_unchecked());
        PolynomialInverse {
            coordinates: self.coordinates.cast(),
            lower: self.lower.map(cast),
            upper: self.upper.map(cast),
            inverse: self.inverse.cast(),
            forward: self.forward.cast(),
        }
    }
}

impl<T, K, V, const N: usize, const P: usize, const Z: usize> LeftInverse<T, Const<Z>, Const<P>, Const<N>>
    for PolynomialInverse<T, K, V, N, Z>
where
    T: RealField + Copy,
    K: AsRef<[Node<T>]>,
    V: AsRef<[T]>,
{
    fn estimate_len(&self) -> usize {
        N
    }

    fn left_inverse(&self, z: &SVector<T, Z>, _y: &SVector<T, P>) -> SVector<T, N> {
        self.state(z)
    }

    fn image(&self, xhat: &SVector<T, N>, _y: &SVector<T, P>) -> SVector<T, Z> {
        self.target(xhat)
    }
}

/// The number of `[low, high]` nearest to x, and `low` for NaN. Comparisons, because `max` and `min` leave open which
/// zero they return.
fn between<T: RealField + Copy>(x: T, low: T, high: T) -> T {
    let x = if x > low { x } else { low };
    if x < high { x } else { high }
}

/// The point of the box nearest to x.
pub(super) fn clamped<T: RealField + Copy, const N: usize>(
    x: &SVector<T, N>,
    lower: &SVector<T, N>,
    upper: &SVector<T, N>,
) -> SVector<T, N> {
    SVector::from_fn(|i, _| between(x[i], lower[i], upper[i]))
}

/// `lower < upper` in every entry, all finite.
pub(super) fn check_box<T: RealField + Copy, const N: usize>(
    lower: &SVector<T, N>,
    upper: &SVector<T, N>,
) -> Result<(), ObserverError> {
    for axis in 0..N {
        let (lower, upper) = (lower[axis], upper[axis]);
        if !(lower.is_finite() && upper.is_finite() && lower < upper) {
            return Err(ObserverError::Box {
                axis,
                lower: lower.to_subset_unchecked(),
                upper: upper.to_subset_unchecked(),
            });
        }
    }
    Ok(())
}
