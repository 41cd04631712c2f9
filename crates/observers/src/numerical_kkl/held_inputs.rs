//! The numerical KKL observer of a plant whose inputs are held: `z' = D z + B y`, `xhat = T^-L(z, u)`.
//!
//! For each constant u there is a map `T(., u)` with `D_x T(x, u) f(x, u) = D T(x, u) + B h(x, u)`. While u is held,
//! `e = z - T(x, u)` obeys `e' = D e`; where it varies, `e' = D e - D_u T(x, u) u'`; where it jumps from u to v, e
//! begins anew at `z - T(x, v)`.
//!
//! `T(x, u) = sum_k l_k(u) T(x, u_k)` with tables for the nodes `u_k` of a family of inputs, and Lagrange's polynomials
//! l_k (with several inputs their products). All tables are on the whole box, so that the interpolation by u has no
//! boundary in x: the left inverse is `min |T(x, u) - z|` over the box, with u as it is measured. An input outside of
//! the family is taken at its end.
//!
//! Source: J.-P. Berrut and L. N. Trefethen, Barycentric Lagrange interpolation, SIAM Review 46, 2004, for the error
//! at Chebyshev nodes.

#[cfg(feature = "alloc")]
extern crate alloc;

#[cfg(feature = "alloc")]
use alloc::vec::Vec;
use core::marker::PhantomData;

use luenberger_plants::error::check_matrix;
#[cfg(feature = "alloc")]
use nalgebra::convert;
use nalgebra::{RealField, SMatrix, SVector};

use crate::error::ObserverError;
use crate::numerical_kkl::least_squares::{BoxMap, Search};
use crate::numerical_kkl::polynomial_tree::{clamped, finite};
use crate::numerical_kkl::{Coordinates, Node, PolynomialTree, TensorSpline};
use crate::observer::{Observer, ObserverDimensions};

/// [`HeldInputTables`] on the heap.
#[cfg(feature = "alloc")]
pub type TablesOnHeap<T, const N: usize, const M: usize, const Z: usize> =
    HeldInputTables<T, Vec<T>, Vec<TensorSpline<T, Vec<T>, N, Z>>, N, M, Z>;

/// [`HeldInputInverse`] on the heap.
#[cfg(feature = "alloc")]
pub type InverseOnHeap<T, const N: usize, const M: usize, const Z: usize, const ZM: usize> =
    HeldInputInverse<T, Vec<Node<T>>, Vec<T>, Vec<TensorSpline<T, Vec<T>, N, Z>>, N, M, Z, ZM>;

/// `T(x, u)` for N states, M inputs and Z target states.
#[derive(Clone, Debug, PartialEq)]
pub struct HeldInputTables<T, V, S, const N: usize, const M: usize, const Z: usize> {
    coordinates: Coordinates<T, Z>,
    nodes: V,
    splines: S,
    scalar: PhantomData<T>,
}

impl<T, V, S, const N: usize, const M: usize, const Z: usize> HeldInputTables<T, V, S, N, M, Z>
where
    T: RealField + Copy,
    V: AsRef<[T]>,
    S: AsRef<[TensorSpline<T, V, N, Z>]>,
{
    /// `nodes` are the increasing values of each input, one input after the other and equally many of each; `splines`
    /// are `W (T(x, u_k) - m)` in `coordinates` for all their combinations, the last input running fastest.
    ///
    /// # Errors
    /// [`ObserverError::Table`] for sizes that do not fit, nodes that do not increase, and splines on different boxes;
    /// [`ObserverError::TableNotFinite`] for the nodes.
    pub fn new(coordinates: Coordinates<T, Z>, nodes: V, splines: S) -> Result<Self, ObserverError> {
        let wrong = |what, expected, found| Err(ObserverError::Table { what, expected, found });
        let values = nodes.as_ref();
        finite("the nodes of the inputs", values)?;
        if M == 0 || !values.len().is_multiple_of(M) || values.len() < 2 * M {
            return wrong("the nodes of the inputs, at least two of each", 2 * M, values.len());
        }
        let count = values.len() / M;
        for axis in values.chunks(count) {
            if let Some(k) = axis.windows(2).position(|pair| pair[0] >= pair[1]) {
                return wrong("the nodes of an input, which increase up to the last node", count - 1, k);
            }
        }
        let tables = splines.as_ref();
        let expected = (0..M).fold(1usize, |product, _| product.saturating_mul(count));
        if tables.len() != expected {
            return wrong("the tables of the inputs", expected, tables.len());
        }
        if let Some(k) = tables.iter().position(|spline| spline.bounds() != tables[0].bounds()) {
            return wrong("the tables on the box of the first one", expected, k);
        }
        Ok(Self { coordinates, nodes, splines, scalar: PhantomData })
    }

    /// The coordinates.
    pub fn coordinates(&self) -> &Coordinates<T, Z> {
        &self.coordinates
    }

    /// One table for each combination of nodes.
    pub fn splines(&self) -> &[TensorSpline<T, V, N, Z>] {
        self.splines.as_ref()
    }

    /// The values of input i for which there are tables; the first and the last are the ends of the family.
    pub fn nodes(&self, i: usize) -> &[T] {
        let all = self.nodes.as_ref();
        let count = all.len() / M;
        &all[i * count..][..count]
    }

    /// The ends of the family: the first and the last node of each input.
    pub fn family(&self) -> (SVector<T, M>, SVector<T, M>) {
        let end =
            |of: fn(&[T]) -> Option<&T>| SVector::from_fn(|i, _| of(self.nodes(i)).copied().unwrap_or_else(T::zero));
        (end(<[T]>::first), end(<[T]>::last))
    }

    /// The tables at an input, which is taken into the family.
    pub fn at(&self, u: &SVector<T, M>) -> TablesAtInput<'_, T, V, S, N, M, Z> {
        let (low, high) = self.family();
        TablesAtInput { tables: self, u: clamped(u, &low, &high) }
    }

    /// The same over another scalar, on the heap.
    ///
    /// # Errors
    /// As [`new`](Self::new): nodes that are one number of the other scalar.
    #[cfg(feature = "alloc")]
    pub fn cast<U: RealField + Copy>(&self) -> Result<TablesOnHeap<U, N, M, Z>, ObserverError> {
        let nodes = self.nodes.as_ref().iter().map(|x| convert::<f64, U>(x.to_subset_unchecked())).collect();
        let splines = self.splines().iter().map(TensorSpline::cast).collect();
        HeldInputTables::new(self.coordinates.cast(), nodes, splines)
    }

    /// `T(x, u)` for x in the box; outside, the value at the nearest point of the box.
    pub fn target(&self, x: &SVector<T, N>, u: &SVector<T, M>) -> SVector<T, Z> {
        self.coordinates.coloured(&self.at(u).with_gradient(x).0)
    }

    /// The product of Lagrange's polynomials that belongs to table k.
    fn weight(&self, u: &SVector<T, M>, k: usize) -> T {
        let mut rest = k;
        let mut product = T::one();
        // The last input runs fastest.
        for i in (0..M).rev() {
            let nodes = self.nodes(i);
            let own = rest % nodes.len();
            rest /= nodes.len();
            for (_, node) in nodes.iter().enumerate().filter(|(j, _)| *j != own) {
                product *= (u[i] - *node) / (nodes[own] - *node);
            }
        }
        product
    }
}

/// The tables at one input, `W (T(., u) - m)`.
#[derive(Debug)]
pub struct TablesAtInput<'a, T, V, S, const N: usize, const M: usize, const Z: usize> {
    tables: &'a HeldInputTables<T, V, S, N, M, Z>,
    u: SVector<T, M>,
}

impl<T, V, S, const N: usize, const M: usize, const Z: usize> BoxMap<T, N, Z> for TablesAtInput<'_, T, V, S, N, M, Z>
where
    T: RealField + Copy,
    V: AsRef<[T]>,
    S: AsRef<[TensorSpline<T, V, N, Z>]>,
{
    fn bounds(&self) -> (&SVector<T, N>, &SVector<T, N>) {
        // There is at least one table, and all have the same box.
        self.tables.splines()[0].bounds()
    }

    fn with_gradient(&self, x: &SVector<T, N>) -> (SVector<T, Z>, SMatrix<T, Z, N>) {
        let (mut value, mut gradient) = (SVector::zeros(), SMatrix::zeros());
        for (k, spline) in self.tables.splines().iter().enumerate() {
            let weight = self.tables.weight(&self.u, k);
            // At a node all other weights are zero.
            if weight != T::zero() {
                let (one, slope) = spline.with_gradient(x);
                value += one * weight;
                gradient += slope * weight;
            }
        }
        (value, gradient)
    }
}

/// `T^-L(z, u)` for N states, M inputs and Z target states, `ZM = Z + M`.
#[derive(Clone, Debug, PartialEq)]
pub struct HeldInputInverse<T, K, V, S, const N: usize, const M: usize, const Z: usize, const ZM: usize> {
    tables: HeldInputTables<T, V, S, N, M, Z>,
    start: PolynomialTree<T, K, V, ZM, N>,
    search: Option<Search<T>>,
}

impl<T, K, V, S, const N: usize, const M: usize, const Z: usize, const ZM: usize>
    HeldInputInverse<T, K, V, S, N, M, Z, ZM>
where
    T: RealField + Copy,
    K: AsRef<[Node<T>]>,
    V: AsRef<[T]>,
    S: AsRef<[TensorSpline<T, V, N, Z>]>,
{
    /// `start` gives a state from `(W (z - m), u)`, from which `search` goes on in the tables. Without `search` that
    /// state, taken into the box, is the estimate: the embedded form.
    ///
    /// # Errors
    /// [`ObserverError::Table`] unless `ZM = Z + M`; as [`InterpolatedInverse`](super::InterpolatedInverse) for the
    /// search.
    pub fn new(
        tables: HeldInputTables<T, V, S, N, M, Z>,
        start: PolynomialTree<T, K, V, ZM, N>,
        search: Option<Search<T>>,
    ) -> Result<Self, ObserverError> {
        if ZM != Z + M {
            let what = "the arguments of the tree, target states and inputs";
            return Err(ObserverError::Table { what, expected: Z + M, found: ZM });
        }
        if let Some(search) = &search {
            search.check::<N>()?;
        }
        Ok(Self { tables, start, search })
    }

    /// T.
    pub fn tables(&self) -> &HeldInputTables<T, V, S, N, M, Z> {
        &self.tables
    }

    /// How it searches; none for the embedded form.
    pub fn search(&self) -> Option<&Search<T>> {
        self.search.as_ref()
    }

    /// The tree from which the search starts.
    pub fn start(&self) -> &PolynomialTree<T, K, V, ZM, N> {
        &self.start
    }

    /// The same over another scalar, on the heap.
    ///
    /// # Errors
    /// As [`HeldInputTables::cast`].
    #[cfg(feature = "alloc")]
    pub fn cast<U: RealField + Copy>(&self) -> Result<InverseOnHeap<U, N, M, Z, ZM>, ObserverError> {
        HeldInputInverse::new(self.tables.cast()?, self.start.cast(), self.search.map(|search| search.cast()))
    }

    /// The embedded form.
    #[must_use]
    pub fn embedded(self) -> Self {
        Self { search: None, ..self }
    }

    /// `T^-L(z, u)`: the state of the box whose image at u is nearest to z.
    pub fn state(&self, z: &SVector<T, Z>, u: &SVector<T, M>) -> SVector<T, N> {
        let map = self.tables.at(u);
        let w = self.tables.coordinates.white(z);
        let (lower, upper) = map.bounds();
        let guess = self.start.at(&SVector::from_fn(|i, _| if i < Z { w[i] } else { map.u[i - Z] }));
        let guess = clamped(&guess, lower, upper);
        self.search.as_ref().map_or(guess, |search| search.solve(&map, &w, &guess).x)
    }
}

/// `z' = D z + B y`, `xhat = T^-L(z, u)` for N states, M held inputs, P outputs and Z target states.
#[derive(Clone, Debug, PartialEq)]
pub struct HeldInputObserver<
    T,
    K,
    V,
    S,
    const N: usize,
    const M: usize,
    const P: usize,
    const Z: usize,
    const ZM: usize,
> {
    d: SMatrix<T, Z, Z>,
    b: SMatrix<T, Z, P>,
    inverse: HeldInputInverse<T, K, V, S, N, M, Z, ZM>,
}

impl<T, K, V, S, const N: usize, const M: usize, const P: usize, const Z: usize, const ZM: usize>
    HeldInputObserver<T, K, V, S, N, M, P, Z, ZM>
where
    T: RealField + Copy,
    K: AsRef<[Node<T>]>,
    V: AsRef<[T]>,
    S: AsRef<[TensorSpline<T, V, N, Z>]>,
{
    /// D, B and the left inverse. That D is Hurwitz is not checked here; designs choose it so.
    ///
    /// # Errors
    /// [`ObserverError::Matrix`] for entries that are not finite.
    pub fn new(
        d: SMatrix<T, Z, Z>,
        b: SMatrix<T, Z, P>,
        inverse: HeldInputInverse<T, K, V, S, N, M, Z, ZM>,
    ) -> Result<Self, ObserverError> {
        check_matrix("D", &d, (Z, Z))?;
        check_matrix("B", &b, (Z, P))?;
        Ok(Self { d, b, inverse })
    }

    /// D.
    pub fn d(&self) -> &SMatrix<T, Z, Z> {
        &self.d
    }

    /// B.
    pub fn b(&self) -> &SMatrix<T, Z, P> {
        &self.b
    }

    /// The left inverse.
    pub fn inverse(&self) -> &HeldInputInverse<T, K, V, S, N, M, Z, ZM> {
        &self.inverse
    }

    /// The embedded form: the tree alone.
    #[must_use]
    pub fn embedded(self) -> Self {
        Self { inverse: self.inverse.embedded(), ..self }
    }
}

impl<T, K, V, S, const N: usize, const M: usize, const P: usize, const Z: usize, const ZM: usize> Observer<T>
    for HeldInputObserver<T, K, V, S, N, M, P, Z, ZM>
where
    T: RealField + Copy,
    K: AsRef<[Node<T>]>,
    V: AsRef<[T]>,
    S: AsRef<[TensorSpline<T, V, N, Z>]>,
{
    type State = SVector<T, Z>;
    type Input = SVector<T, M>;
    type Output = SVector<T, P>;
    type Estimate = SVector<T, N>;

    fn dimensions(&self) -> ObserverDimensions {
        ObserverDimensions { state: Z, inputs: M, outputs: P, estimate: N }
    }

    fn derivative(&self, _t: T, z: &SVector<T, Z>, _u: &SVector<T, M>, y: &SVector<T, P>) -> SVector<T, Z> {
        self.d * z + self.b * y
    }

    fn estimate(&self, _t: T, z: &SVector<T, Z>, u: &SVector<T, M>, _y: &SVector<T, P>) -> SVector<T, N> {
        self.inverse.state(z, u)
    }

    fn initial(&self, _t: T, estimate: &SVector<T, N>, u: &SVector<T, M>, _y: &SVector<T, P>) -> SVector<T, Z> {
        self.inverse.tables.target(estimate, u)
    }
}
