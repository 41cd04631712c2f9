//! Kazantzis-Kravaris-Luenberger observers: `xi' = Lambda xi + B(y, u)`, `xhat = phi^L(xi, y)`; eq. (6) of the
//! [KKL+PEB] paper.
//!
//! phi maps the plant to a stable linear system driven by what is known, `d phi(x)/dt = Lambda phi(x) + B(h(x), u)`
//! (4), and phi^L takes it back, `phi^L(phi(x), h(x)) = x`. The error `e = xi - phi(x)` then obeys `e' = Lambda e`
//! whatever the plant does, and `xhat - x` follows as fast as phi^L is continuous.
//!
//! Two things are more general here than in Proposition 1. Lambda may depend on t, u and y (the converter's does;
//! convergence then needs more than negative entries: an integral that diverges for a diagonal Lambda, a common
//! Lyapunov matrix in general). And B may read xi in cascade: entry i may use entries of xi before it, as in
//! Proposition 7, where the error of an early entry disturbs the later ones and is gone first.
//!
//! Sources: N. Kazantzis and C. Kravaris, Systems and Control Letters 34, 1998; V. Andrieu and L. Praly, SIAM Journal
//! on Control and Optimization 45, 2006; B. Yi, R. Ortega and W. Zhang, IEEE Transactions on Automatic Control, 2018,
//! Proposition 1.

use luenberger_plants::error::check_matrix;
use nalgebra::allocator::Allocator;
use nalgebra::{DefaultAllocator, Dim, OMatrix, OVector, RealField};

use crate::error::ObserverError;
use crate::observer::{Observer, ObserverDimensions};

/// Every shape that can be made of an extension of length `Z`, `M` inputs, `P` outputs and an estimate of length `N`
/// can be stored.
///
/// Holds for all combinations of [`nalgebra::Const`] and (feature `alloc`) [`nalgebra::Dyn`]; never implement it
/// yourself.
#[diagnostic::on_unimplemented(
    message = "not every column and matrix of a KKL observer of these sizes can be stored",
    note = "sizes `nalgebra::Const` and, with the feature `alloc`, `nalgebra::Dyn` can be stored in all combinations",
    note = "code that is generic in the sizes needs the bound `DefaultAllocator: KklSize<Z, M, P, N>`"
)]
pub trait KklSize<Z: Dim, M: Dim, P: Dim, N: Dim>:
    Allocator<Z> + Allocator<M> + Allocator<P> + Allocator<N> + Allocator<Z, Z> + Allocator<Z, M> + Allocator<Z, P>
{
}

impl<Z: Dim, M: Dim, P: Dim, N: Dim> KklSize<Z, M, P, N> for DefaultAllocator where
    DefaultAllocator:
        Allocator<Z> + Allocator<M> + Allocator<P> + Allocator<N> + Allocator<Z, Z> + Allocator<Z, M> + Allocator<Z, P>
{
}

/// The four maps that make a KKL observer: Lambda, B, phi^L and phi.
///
/// Nothing checks that they solve (4); a test should: `Dphi(x) f(x, u) = Lambda phi(x) + B` at random points.
#[diagnostic::on_unimplemented(
    message = "`{Self}` does not have the maps of a KKL observer over the scalar `{T}`",
    note = "implement `KklMap<T>` for every `T: RealField + Copy`, or for the scalar that is used"
)]
pub trait KklMap<T: RealField + Copy>
where
    DefaultAllocator: KklSize<Self::Xi, Self::Inputs, Self::Outputs, Self::Estimate>,
{
    /// Dimension of xi.
    type Xi: Dim;
    /// Number of inputs.
    type Inputs: Dim;
    /// Number of outputs.
    type Outputs: Dim;
    /// Length of the estimate: n, or less when only some states are estimated.
    type Estimate: Dim;

    /// Lengths of the columns; `state` is the length of xi. Required where one of the types is [`nalgebra::Dyn`].
    fn dimensions(&self) -> ObserverDimensions {
        ObserverDimensions::of::<Self::Xi, Self::Inputs, Self::Outputs, Self::Estimate>()
    }

    /// `Lambda(t, u, y)`, square of the order of xi (default zero), which is what a PEBO has ([`pebo`](crate::pebo)).
    fn lambda(
        &self,
        _t: T,
        _u: &OVector<T, Self::Inputs>,
        _y: &OVector<T, Self::Outputs>,
    ) -> OMatrix<T, Self::Xi, Self::Xi> {
        let order = Self::Xi::from_usize(self.dimensions().state);
        OMatrix::zeros_generic(order, order)
    }

    /// `B(t, xi, u, y)`; entry i may read `xi[j]` for j < i only.
    fn injection(
        &self,
        t: T,
        xi: &OVector<T, Self::Xi>,
        u: &OVector<T, Self::Inputs>,
        y: &OVector<T, Self::Outputs>,
    ) -> OVector<T, Self::Xi>;

    /// `phi^L(t, xi, y)`, the estimate.
    fn left_inverse(
        &self,
        t: T,
        xi: &OVector<T, Self::Xi>,
        y: &OVector<T, Self::Outputs>,
    ) -> OVector<T, Self::Estimate>;

    /// `phi(t, xhat, y)`: where to start xi so that the estimate is xhat, `phi^L(t, phi(t, xhat, y), y) = xhat`.
    fn image(&self, t: T, xhat: &OVector<T, Self::Estimate>, y: &OVector<T, Self::Outputs>) -> OVector<T, Self::Xi>;

    /// `Lambda xi + B`, the right-hand side.
    fn slope(
        &self,
        t: T,
        xi: &OVector<T, Self::Xi>,
        u: &OVector<T, Self::Inputs>,
        y: &OVector<T, Self::Outputs>,
    ) -> OVector<T, Self::Xi> {
        self.lambda(t, u, y) * xi + self.injection(t, xi, u, y)
    }
}

/// `xi' = Lambda xi + B`, `xhat = phi^L(xi, y)`, with the maps of `K`; see the [module](self).
///
/// The plant `x1' = -x1 + u + y^2, x2' = -x2 + x1, y = x2` needs no transformation to be of this form:
/// ```
/// use luenberger_observers::kkl::{KklMap, KklObserver};
/// use luenberger_observers::Observer;
/// use nalgebra::{Matrix1, U1, Vector1};
///
/// struct FirstState;
///
/// impl KklMap<f64> for FirstState {
///     type Xi = U1;
///     type Inputs = U1;
///     type Outputs = U1;
///     type Estimate = U1;
///     fn lambda(&self, _t: f64, _u: &Vector1<f64>, _y: &Vector1<f64>) -> Matrix1<f64> {
///         Matrix1::new(-1.0)
///     }
///     fn injection(&self, _t: f64, _xi: &Vector1<f64>, u: &Vector1<f64>, y: &Vector1<f64>) -> Vector1<f64> {
///         Vector1::new(u[0] + y[0] * y[0])
///     }
///     fn left_inverse(&self, _t: f64, xi: &Vector1<f64>, _y: &Vector1<f64>) -> Vector1<f64> {
///         *xi
///     }
///     fn image(&self, _t: f64, xhat: &Vector1<f64>, _y: &Vector1<f64>) -> Vector1<f64> {
///         *xhat
///     }
/// }
///
/// let observer = KklObserver::new(FirstState);
/// let (u, y) = (Vector1::new(1.0), Vector1::new(2.0));
/// assert_eq!(observer.derivative(0.0, &Vector1::new(3.0), &u, &y)[0], -3.0 + 1.0 + 4.0);
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct KklObserver<K> {
    map: K,
}

impl<K> KklObserver<K> {
    /// The observer with these maps.
    pub fn new(map: K) -> Self {
        Self { map }
    }

    /// The maps.
    pub fn map(&self) -> &K {
        &self.map
    }
}

impl<T: RealField + Copy, K: KklMap<T>> Observer<T> for KklObserver<K>
where
    DefaultAllocator: KklSize<K::Xi, K::Inputs, K::Outputs, K::Estimate>,
{
    type State = OVector<T, K::Xi>;
    type Input = OVector<T, K::Inputs>;
    type Output = OVector<T, K::Outputs>;
    type Estimate = OVector<T, K::Estimate>;

    fn dimensions(&self) -> ObserverDimensions {
        self.map.dimensions()
    }

    fn derivative(&self, t: T, xi: &Self::State, u: &Self::Input, y: &Self::Output) -> Self::State {
        self.map.slope(t, xi, u, y)
    }

    fn estimate(&self, t: T, xi: &Self::State, _u: &Self::Input, y: &Self::Output) -> Self::Estimate {
        self.map.left_inverse(t, xi, y)
    }

    fn initial(&self, t: T, estimate: &Self::Estimate, _u: &Self::Input, y: &Self::Output) -> Self::State {
        self.map.image(t, estimate, y)
    }
}

/// A left inverse phi^L with its phi, for [`LinearKkl`]: in closed form, or learned from data.
pub trait LeftInverse<T: RealField + Copy, Z: Dim, P: Dim, N: Dim>
where
    DefaultAllocator: Allocator<Z> + Allocator<P> + Allocator<N>,
{
    /// Length of the estimate.
    fn estimate_len(&self) -> usize;

    /// `phi^L(z, y)`.
    fn left_inverse(&self, z: &OVector<T, Z>, y: &OVector<T, P>) -> OVector<T, N>;

    /// `phi(xhat)`: where to start z so that the estimate is xhat (for a learned phi, about xhat).
    fn image(&self, xhat: &OVector<T, N>, y: &OVector<T, P>) -> OVector<T, Z>;
}

/// A linear left inverse, `phi^L(z, y) = M z + N y` of `phi(x) = T x` with `M T + N C = I`: that of a reduced-order
/// observer.
///
/// ```
/// use luenberger_observers::{KklObserver, LinearInverse, LinearKkl, Observer};
/// use nalgebra::{Const, Vector1, matrix, vector};
/// // The double integrator, y = x1: z = x2 - 4 x1 obeys z' = -4 z - 16 y + u.
/// let inverse = LinearInverse::new(matrix![0.0; 1.0], matrix![1.0; 4.0], matrix![-4.0, 1.0])?;
/// let maps = LinearKkl::<f64, _, _, _, Const<2>, _>::new(matrix![-4.0], matrix![-16.0], matrix![1.0], inverse)?;
/// let observer = KklObserver::new(maps);
/// let (u, y) = (Vector1::new(0.5), Vector1::new(2.0));
/// let z = observer.initial(0.0, &vector![2.0, 1.0], &u, &y);
/// assert_eq!(z, Vector1::new(-7.0));
/// assert_eq!(observer.derivative(0.0, &z, &u, &y), Vector1::new(-3.5));
/// assert_eq!(observer.estimate(0.0, &z, &u, &y), vector![2.0, 1.0]);
/// # Ok::<(), luenberger_observers::ObserverError>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct LinearInverse<T: RealField + Copy, Z: Dim, P: Dim, N: Dim>
where
    DefaultAllocator: Allocator<N, Z> + Allocator<N, P> + Allocator<Z, N>,
{
    m: OMatrix<T, N, Z>,
    n: OMatrix<T, N, P>,
    t: OMatrix<T, Z, N>,
}

impl<T: RealField + Copy, Z: Dim, P: Dim, N: Dim> LinearInverse<T, Z, P, N>
where
    DefaultAllocator: Allocator<N, Z> + Allocator<N, P> + Allocator<Z, N>,
{
    /// M (n x n_z), N (n x p) and T (n_z x n).
    ///
    /// # Errors
    /// [`ObserverError::Matrix`]: shapes that do not fit, entries that are not finite.
    pub fn new(m: OMatrix<T, N, Z>, n: OMatrix<T, N, P>, t: OMatrix<T, Z, N>) -> Result<Self, ObserverError> {
        let (states, order) = m.shape();
        check_matrix("M", &m, (states, order))?;
        check_matrix("N", &n, (states, n.ncols()))?;
        check_matrix("T", &t, (order, states))?;
        Ok(Self { m, n, t })
    }

    /// M, n x n_z.
    pub fn m(&self) -> &OMatrix<T, N, Z> {
        &self.m
    }

    /// N, n x p.
    pub fn n(&self) -> &OMatrix<T, N, P> {
        &self.n
    }

    /// T, n_z x n.
    pub fn t(&self) -> &OMatrix<T, Z, N> {
        &self.t
    }
}

impl<T: RealField + Copy, Z: Dim, P: Dim, N: Dim> LeftInverse<T, Z, P, N> for LinearInverse<T, Z, P, N>
where
    DefaultAllocator: Allocator<N, Z> + Allocator<N, P> + Allocator<Z, N> + Allocator<Z> + Allocator<P> + Allocator<N>,
{
    fn estimate_len(&self) -> usize {
        self.m.nrows()
    }

    fn left_inverse(&self, z: &OVector<T, Z>, y: &OVector<T, P>) -> OVector<T, N> {
        &self.m * z + &self.n * y
    }

    fn image(&self, xhat: &OVector<T, N>, _y: &OVector<T, P>) -> OVector<T, Z> {
        &self.t * xhat
    }
}

/// The maps of `z' = D z + B y + E u`, `xhat = phi^L(z, y)` with constant matrices: the form of Luenberger's first
/// paper and of numerical KKL observers, where phi^L comes from data.
///
/// Fields are read through methods, because the constructor has checked them.
#[derive(Clone, Debug, PartialEq)]
pub struct LinearKkl<T: RealField + Copy, Z: Dim, M: Dim, P: Dim, N: Dim, I>
where
    DefaultAllocator: KklSize<Z, M, P, N>,
{
    d: OMatrix<T, Z, Z>,
    b: OMatrix<T, Z, P>,
    e: OMatrix<T, Z, M>,
    inverse: I,
    estimate: core::marker::PhantomData<N>,
}

impl<T: RealField + Copy, Z: Dim, M: Dim, P: Dim, N: Dim, I: LeftInverse<T, Z, P, N>> LinearKkl<T, Z, M, P, N, I>
where
    DefaultAllocator: KklSize<Z, M, P, N>,
{
    /// D (n_z x n_z), B (n_z x p), E (n_z x m; no columns for a plant without inputs) and the left inverse.
    ///
    /// That D is Hurwitz is not checked here; designs prove it.
    /// # Errors
    /// [`ObserverError::Matrix`]: shapes that do not fit, entries that are not finite.
    pub fn new(
        d: OMatrix<T, Z, Z>,
        b: OMatrix<T, Z, P>,
        e: OMatrix<T, Z, M>,
        inverse: I,
    ) -> Result<Self, ObserverError> {
        let order = d.nrows();
        check_matrix("D", &d, (order, order))?;
        check_matrix("B", &b, (order, b.ncols()))?;
        check_matrix("E", &e, (order, e.ncols()))?;
        Ok(Self { d, b, e, inverse, estimate: core::marker::PhantomData })
    }

    /// D, n_z x n_z.
    pub fn d(&self) -> &OMatrix<T, Z, Z> {
        &self.d
    }

    /// B, n_z x p.
    pub fn b(&self) -> &OMatrix<T, Z, P> {
        &self.b
    }

    /// E, n_z x m.
    pub fn e(&self) -> &OMatrix<T, Z, M> {
        &self.e
    }

    /// The left inverse.
    pub fn inverse(&self) -> &I {
        &self.inverse
    }
}

impl<T: RealField + Copy, Z: Dim, M: Dim, P: Dim, N: Dim, I: LeftInverse<T, Z, P, N>> KklMap<T>
    for LinearKkl<T, Z, M, P, N, I>
where
    DefaultAllocator: KklSize<Z, M, P, N>,
{
    type Xi = Z;
    type Inputs = M;
    type Outputs = P;
    type Estimate = N;

    fn dimensions(&self) -> ObserverDimensions {
        ObserverDimensions {
            state: self.d.nrows(),
            inputs: self.e.ncols(),
            outputs: self.b.ncols(),
            estimate: self.inverse.estimate_len(),
        }
    }

    fn lambda(&self, _t: T, _u: &OVector<T, M>, _y: &OVector<T, P>) -> OMatrix<T, Z, Z> {
        self.d.clone()
    }

    fn injection(&self, _t: T, _z: &OVector<T, Z>, u: &OVector<T, M>, y: &OVector<T, P>) -> OVector<T, Z> {
        &self.b * y + &self.e * u
    }

    fn left_inverse(&self, _t: T, z: &OVector<T, Z>, y: &OVector<T, P>) -> OVector<T, N> {
        self.inverse.left_inverse(z, y)
    }

    fn image(&self, _t: T, xhat: &OVector<T, N>, y: &OVector<T, P>) -> OVector<T, Z> {
        self.inverse.image(xhat, y)
    }
}
