//! Immersion-and-invariance observers with an extension of any length: eq. (18), (19) of the [KKL+PEB] paper.
//!
//! ```text
//! chi' = -[D_chi beta]+ ((D_y beta) Dh(xhat) - Dphi(xhat)) f(xhat, u) + [D_chi beta]+ rho + (I - [D_chi beta]+ D_chi beta) Q
//! xhat = phi^L(beta(y, chi), y)
//! ```
//!
//! The manifold `beta(h(x), chi) = phi(x)` is invariant where D_chi beta has full rank (A4), because the distance
//! `d = beta(y, chi) - phi(x)` from it moves with what x and xhat differ in, eq. (16), and xhat = x on it. Whether it
//! attracts (A5) is the design of beta.
//!
//! No Jacobian is written by hand: beta and phi are defined once for every scalar, and the directional derivatives in
//! (18) come from dual numbers (feature `dual`), or by hand ([`DifferentiableImmersion`]). The
//! pseudo-inverse is that of [`pseudo_inverse`]: where D_chi beta loses rank the lost direction stands still, and
//! [`Diagnose`] reports it with the singular values.
//!
//! rho, of the length of beta, is zero in the paper, and then the proof of Proposition 5 fails: with (21) to (23) the
//! observer does not reproduce the parameter estimator of a [KKL+PEB]O, because (18) makes beta follow phi(xhat), and
//! an estimate that is still moving is something else. `rho = (0, d theta_hat/dt)` repairs that. Q is a column of the
//! length of chi (not a matrix).
//!
//! Source: D. Karagiannis, D. Carnevale and A. Astolfi, IEEE Transactions on Automatic Control 53, 2008; A. Astolfi, D.
//! Karagiannis and R. Ortega, Nonlinear and Adaptive Control with Applications, Springer 2008, ch. 5.

use luenberger_plants::{Differentiable, Size};
use nalgebra::allocator::Allocator;
use nalgebra::{DefaultAllocator, Dim, OMatrix, OVector, RealField, U1};

use crate::diagnosis::{Diagnose, Diagnosis};
use crate::observer::{Observer, ObserverDimensions};
use crate::pseudo_inverse::pseudo_inverse;

/// Every shape that an I&I observer forms can be stored. Never implement it yourself.
#[diagnostic::on_unimplemented(
    message = "not every column and matrix of an I&I observer of these sizes can be stored",
    note = "sizes `nalgebra::Const` and, with the feature `alloc`, `nalgebra::Dyn` can be stored in all combinations",
    note = "code that is generic in the sizes needs the bound `DefaultAllocator: ImmersionSize<N, M, P, Z, C, E>`"
)]
pub trait ImmersionSize<N: Dim, M: Dim, P: Dim, Z: Dim, C: Dim, E: Dim>:
    Size<N, M, P> + Allocator<Z> + Allocator<C> + Allocator<E> + Allocator<Z, C> + Allocator<C, Z> + Allocator<Z, Z>
{
}

impl<N: Dim, M: Dim, P: Dim, Z: Dim, C: Dim, E: Dim> ImmersionSize<N, M, P, Z, C, E> for DefaultAllocator where
    DefaultAllocator: Size<N, M, P>
        + Allocator<Z>
        + Allocator<C>
        + Allocator<E>
        + Allocator<Z, C>
        + Allocator<C, Z>
        + Allocator<Z, Z>
{
}

/// The maps beta, phi and phi^L, and the freedom Q, over the scalar `T`.
pub trait Immersion<T: RealField + Copy>
where
    DefaultAllocator:
        ImmersionSize<Self::States, Self::Inputs, Self::Outputs, Self::Manifold, Self::Extension, Self::Estimate>,
{
    /// Number n of plant states.
    type States: Dim;
    /// Number m of inputs.
    type Inputs: Dim;
    /// Number p of outputs.
    type Outputs: Dim;
    /// Length n_z of beta and phi.
    type Manifold: Dim;
    /// Length n_chi >= n_z of chi.
    type Extension: Dim;
    /// Length of the estimate.
    type Estimate: Dim;

    /// Lengths of the columns; `state` is the length of chi. Required where one of the types is [`nalgebra::Dyn`].
    fn dimensions(&self) -> ObserverDimensions {
        ObserverDimensions::of::<Self::Extension, Self::Inputs, Self::Outputs, Self::Estimate>()
    }

    /// `beta(y, chi)`.
    fn beta(&self, y: &OVector<T, Self::Outputs>, chi: &OVector<T, Self::Extension>) -> OVector<T, Self::Manifold>;

    /// `phi(x)`.
    fn phi(&self, x: &OVector<T, Self::States>) -> OVector<T, Self::Manifold>;

    /// `phi^L(z, y)`, with `phi^L(phi(x), h(x)) = x`: all n states.
    fn left_inverse(&self, z: &OVector<T, Self::Manifold>, y: &OVector<T, Self::Outputs>) -> OVector<T, Self::States>;

    /// The part of xhat that is the estimate: all states, or those that are not measured.
    fn estimate(&self, xhat: &OVector<T, Self::States>) -> OVector<T, Self::Estimate>;

    /// An initial chi for which the estimate is the given one.
    fn start(
        &self,
        estimate: &OVector<T, Self::Estimate>,
        y: &OVector<T, Self::Outputs>,
    ) -> OVector<T, Self::Extension>;

    /// `Q(y, chi, u)`, which matters in the directions of chi that beta does not see (default 0).
    fn freedom(
        &self,
        _y: &OVector<T, Self::Outputs>,
        chi: &OVector<T, Self::Extension>,
        _u: &OVector<T, Self::Inputs>,
    ) -> OVector<T, Self::Extension> {
        OVector::zeros_generic(chi.shape_generic().0, U1)
    }

    /// `rho(y, chi, u)`: by how much beta is to move beside phi(xhat). Default `None`, that is 0.
    fn rho(
        &self,
        _y: &OVector<T, Self::Outputs>,
        _chi: &OVector<T, Self::Extension>,
        _u: &OVector<T, Self::Inputs>,
    ) -> Option<OVector<T, Self::Manifold>> {
        None
    }
}

/// Maps whose derivatives along any direction can be evaluated.
///
/// With the feature `dual`, implemented for the maps that ask for it by [`ByDual`](luenberger_plants::ByDual) and are
/// maps over `T` and over dual numbers of `T`. Other maps implement the trait
/// themselves, whether the feature is enabled or not.
#[diagnostic::on_unimplemented(
    message = "`{Self}` is not an immersion with derivatives over `{T}`",
    note = "maps written for every scalar get them by `impl luenberger_plants::ByDual for ...` and the feature `dual`",
    note = "any other implements `DifferentiableImmersion` by hand"
)]
pub trait DifferentiableImmersion<T: RealField + Copy>: Immersion<T>
where
    DefaultAllocator: ImmersionSize<
            <Self as Immersion<T>>::States,
            <Self as Immersion<T>>::Inputs,
            <Self as Immersion<T>>::Outputs,
            <Self as Immersion<T>>::Manifold,
            <Self as Immersion<T>>::Extension,
            <Self as Immersion<T>>::Estimate,
        >,
{
    /// The derivative of `beta(y, chi)` along `(dy, dchi)`.
    fn beta_directional(
        &self,
        y: &OVector<T, Self::Outputs>,
        chi: &OVector<T, Self::Extension>,
        dy: &OVector<T, Self::Outputs>,
        dchi: &OVector<T, Self::Extension>,
    ) -> OVector<T, Self::Manifold>;

    /// The derivative of `phi(x)` along `dx`.
    fn phi_directional(
        &self,
        x: &OVector<T, Self::States>,
        dx: &OVector<T, Self::States>,
    ) -> OVector<T, Self::Manifold>;
}

/// The observer (18), (19) of the plant `S` with the maps `I`; see the [module](self).
///
/// The output must not depend on the input: y' would contain u', which is not known.
///
/// For Van der Pol's oscillator, `x2' = mu (1 - y^2) x2 - y`, with `phi = x2` and `beta = chi + k y`: the error obeys
/// `e' = (mu (1 - y^2) - k) e`. Only the maps are written down.
/// ```
/// # #[cfg(feature = "dual")] {
/// use luenberger_observers::{Immersion, ImmersionInvarianceObserver, Observer};
/// use luenberger_plants::{ByDual, Plant, VanDerPol};
/// use nalgebra::{RealField, SVector, U0, U1, U2, Vector1, Vector2, convert};
///
/// struct Shifted;
///
/// impl ByDual for Shifted {}
///
/// impl<T: RealField + Copy> Immersion<T> for Shifted {
///     type States = U2;
///     type Inputs = U0;
///     type Outputs = U1;
///     type Manifold = U1;
///     type Extension = U1;
///     type Estimate = U1;
///     fn beta(&self, y: &Vector1<T>, chi: &Vector1<T>) -> Vector1<T> {
///         chi + y * convert::<f64, T>(3.0)
///     }
///     fn phi(&self, x: &Vector2<T>) -> Vector1<T> {
///         Vector1::new(x[1])
///     }
///     fn left_inverse(&self, z: &Vector1<T>, y: &Vector1<T>) -> Vector2<T> {
///         Vector2::new(y[0], z[0])
///     }
///     fn estimate(&self, xhat: &Vector2<T>) -> Vector1<T> {
///         Vector1::new(xhat[1])
///     }
///     fn start(&self, estimate: &Vector1<T>, y: &Vector1<T>) -> Vector1<T> {
///         estimate - y * convert::<f64, T>(3.0)
///     }
/// }
///
/// let plant = VanDerPol { mu: 1.0 };
/// let observer = ImmersionInvarianceObserver::new(plant, Shifted);
/// let (x, e, u) = (Vector2::new(2.0, 0.5), 0.25, SVector::<f64, 0>::zeros());
/// let y = plant.output(0.0, &x, &u);
/// let chi = observer.initial(0.0, &Vector1::new(x[1] + e), &u, &y);
/// // chi' + 3 y' - x2' = (1 - 4 - 3) e.
/// let rate = plant.derivative(0.0, &x, &u);
/// let change: f64 = observer.derivative(0.0, &chi, &u, &y)[0] + 3.0 * rate[0] - rate[1];
/// assert_eq!(change, -6.0 * e);
/// # }
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ImmersionInvarianceObserver<S, I> {
    plant: S,
    map: I,
}

impl<S, I> ImmersionInvarianceObserver<S, I> {
    /// The observer of `plant` with these maps.
    pub fn new(plant: S, map: I) -> Self {
        Self { plant, map }
    }

    /// The plant.
    pub fn plant(&self) -> &S {
        &self.plant
    }

    /// The maps.
    pub fn map(&self) -> &I {
        &self.map
    }
}

/// `D_chi beta(y, chi)`, n_z x n_chi.
fn jacobian<T, I>(
    map: &I,
    y: &OVector<T, I::Outputs>,
    chi: &OVector<T, I::Extension>,
) -> OMatrix<T, I::Manifold, I::Extension>
where
    T: RealField + Copy,
    I: DifferentiableImmersion<T>,
    DefaultAllocator: ImmersionSize<I::States, I::Inputs, I::Outputs, I::Manifold, I::Extension, I::Estimate>,
{
    let still = OVector::zeros_generic(y.shape_generic().0, U1);
    let columns = chi.shape_generic().0;
    let rows = map.beta(y, chi).shape_generic().0;
    let mut jacobian = OMatrix::zeros_generic(rows, columns);
    let mut direction = OVector::zeros_generic(columns, U1);
    for j in 0..chi.nrows() {
        direction[j] = T::one();
        jacobian.set_column(j, &map.beta_directional(y, chi, &still, &direction));
        direction[j] = T::zero();
    }
    jacobian
}

impl<T, S, I> Observer<T> for ImmersionInvarianceObserver<S, I>
where
    T: RealField + Copy,
    I: DifferentiableImmersion<T>,
    S: Differentiable<T, I::States, I::Inputs, I::Outputs>,
    DefaultAllocator: ImmersionSize<I::States, I::Inputs, I::Outputs, I::Manifold, I::Extension, I::Estimate>,
{
    type State = OVector<T, I::Extension>;
    type Input = OVector<T, I::Inputs>;
    type Output = OVector<T, I::Outputs>;
    type Estimate = OVector<T, I::Estimate>;

    fn dimensions(&self) -> ObserverDimensions {
        self.map.dimensions()
    }

    fn derivative(&self, t: T, chi: &Self::State, u: &Self::Input, y: &Self::Output) -> Self::State {
        let xhat = self.map.left_inverse(&self.map.beta(y, chi), y);
        let f = self.plant.derivative(t, &xhat, u);
        let output_rate = self.plant.output_directional(t, &xhat, u, &f).1;
        let still = OVector::zeros_generic(chi.shape_generic().0, U1);
        let mut wanted = self.map.phi_directional(&xhat, &f) - self.map.beta_directional(y, chi, &output_rate, &still);
        if let Some(rho) = self.map.rho(y, chi, u) {
            wanted += rho;
        }
        let jacobian = jacobian(&self.map, y, chi);
        let free = self.map.freedom(y, chi, u);
        let seen = &jacobian * &free;
        free + pseudo_inverse(&jacobian).inverse * (wanted - seen)
    }

    fn estimate(&self, _t: T, chi: &Self::State, _u: &Self::Input, y: &Self::Output) -> Self::Estimate {
        self.map.estimate(&self.map.left_inverse(&self.map.beta(y, chi), y))
    }

    fn initial(&self, _t: T, estimate: &Self::Estimate, _u: &Self::Input, y: &Self::Output) -> Self::State {
        self.map.start(estimate, y)
    }
}

impl<T, S, I> Diagnose<T> for ImmersionInvarianceObserver<S, I>
where
    T: RealField + Copy,
    I: DifferentiableImmersion<T>,
    S: Differentiable<T, I::States, I::Inputs, I::Outputs>,
    DefaultAllocator: ImmersionSize<I::States, I::Inputs, I::Outputs, I::Manifold, I::Extension, I::Estimate>,
{
    /// D_chi beta without full row rank (A4), or a right-hand side that is not finite.
    fn diagnose(&self, t: T, chi: &Self::State, u: &Self::Input, y: &Self::Output) -> Diagnosis<T> {
        let jacobian = jacobian(&self.map, y, chi);
        let inverse = pseudo_inverse(&jacobian);
        let (rank, needed) = (inverse.rank(), jacobian.nrows());
        if rank < needed {
            let (smallest, largest) = (inverse.smallest(), inverse.largest());
            return Diagnosis::RankDeficient { rank, needed, smallest, largest };
        }
        let slope = self.derivative(t, chi, u, y);
        match slope.iter().position(|entry| !entry.is_finite()) {
            Some(entry) => Diagnosis::Overflow { entry },
            None => Diagnosis::Sound,
        }
    }
}

#[cfg(feature = "dual")]
mod dual {
    use luenberger_plants::ByDual;
    use luenberger_plants::jacobian::{along, apart};
    use nalgebra::{DefaultAllocator, OVector, RealField};
    use num_dual::{Dual, DualNum, DualNumFloat};

    use super::{DifferentiableImmersion, Immersion, ImmersionSize};

    impl<I, T> DifferentiableImmersion<T> for I
    where
        T: DualNumFloat + DualNum<Primitive = T> + RealField,
        I: ByDual
            + Immersion<T>
            + Immersion<
                Dual<T>,
                States = <I as Immersion<T>>::States,
                Inputs = <I as Immersion<T>>::Inputs,
                Outputs = <I as Immersion<T>>::Outputs,
                Manifold = <I as Immersion<T>>::Manifold,
                Extension = <I as Immersion<T>>::Extension,
                Estimate = <I as Immersion<T>>::Estimate,
            >,
        DefaultAllocator: ImmersionSize<
                <I as Immersion<T>>::States,
                <I as Immersion<T>>::Inputs,
                <I as Immersion<T>>::Outputs,
                <I as Immersion<T>>::Manifold,
                <I as Immersion<T>>::Extension,
                <I as Immersion<T>>::Estimate,
            >,
    {
        fn beta_directional(
            &self,
            y: &OVector<T, <I as Immersion<T>>::Outputs>,
            chi: &OVector<T, <I as Immersion<T>>::Extension>,
            dy: &OVector<T, <I as Immersion<T>>::Outputs>,
            dchi: &OVector<T, <I as Immersion<T>>::Extension>,
        ) -> OVector<T, <I as Immersion<T>>::Manifold> {
            apart(&Immersion::<Dual<T>>::beta(self, &along(y, dy), &along(chi, dchi))).1
        }

        fn phi_directional(
            &self,
            x: &OVector<T, <I as Immersion<T>>::States>,
            dx: &OVector<T, <I as Immersion<T>>::States>,
        ) -> OVector<T, <I as Immersion<T>>::Manifold> {
            apart(&Immersion::<Dual<T>>::phi(self, &along(x, dx))).1
        }
    }
}
