//! Jacobians of plants: `Df = df/dx`, `Dh = dh/dx`, exact to rounding.
//!
//! A plant that is written once for every scalar, `impl<T: RealField + Copy> Plant<T> for ...`, is a plant over dual
//! numbers too, and evaluating it at `x + v d` with `d^2 = 0` gives `f(x) + (Df(x) v) d`: the derivative along v, to
//! rounding, at the cost of two or three evaluations of f (feature `dual`). There is no step
//! size to choose. A Jacobian is n such evaluations.
//!
//! Observers that need derivatives require [`Differentiable`]. The dual numbers are those of `num-dual`, which links
//! `std`; a bare-metal target builds without the feature and implements the trait for its plant by hand.
//!
//! Source: A. Griewank and A. Walther, Evaluating Derivatives, 2nd ed., SIAM 2008, ch. 3 (the forward mode).

use nalgebra::{DefaultAllocator, Dim, OMatrix, OVector, RealField, U1};

use crate::column::Column;
use crate::linear::LinearPlant;
use crate::plant::{Plant, put};
use crate::size::Size;

/// A plant whose derivatives along any direction can be evaluated.
///
/// Implemented for [`LinearPlant`] and, with the feature `dual`, for every plant that asks for it by [`ByDual`]. Any
/// other plant implements [`directional`](Self::directional) and [`output_directional`](Self::output_directional)
/// itself, whether the feature is enabled or not.
#[diagnostic::on_unimplemented(
    message = "`{Self}` is not a plant with derivatives over `{T}`",
    note = "a plant written for every scalar gets them by `impl luenberger_plants::ByDual for ...` and the feature `dual`",
    note = "the path in the facade is `luenberger::plants::ByDual`",
    note = "any other implements `Differentiable` by hand"
)]
pub trait Differentiable<T, N, M, P>:
    Plant<T, State = OVector<T, N>, Input = OVector<T, M>, Output = OVector<T, P>>
where
    T: RealField + Copy,
    N: Dim,
    M: Dim,
    P: Dim,
    DefaultAllocator: Size<N, M, P>,
{
    /// `f(t, x, u)` and its derivative `Df(t, x, u) v` along v.
    fn directional(
        &self,
        t: T,
        x: &OVector<T, N>,
        u: &OVector<T, M>,
        v: &OVector<T, N>,
    ) -> (OVector<T, N>, OVector<T, N>);

    /// `h(t, x, u)` and its derivative `Dh(t, x, u) v` along v.
    fn output_directional(
        &self,
        t: T,
        x: &OVector<T, N>,
        u: &OVector<T, M>,
        v: &OVector<T, N>,
    ) -> (OVector<T, P>, OVector<T, P>);

    /// `Df(t, x, u)`, n x n: entry (i, j) is the derivative of `f_i` by `x_j`. Costs n directional derivatives.
    fn state_jacobian(&self, t: T, x: &OVector<T, N>, u: &OVector<T, M>) -> OMatrix<T, N, N> {
        let (rows, n) = (x.shape_generic().0, x.nrows());
        let mut jacobian = OMatrix::zeros_generic(rows, rows);
        let mut direction = OVector::zeros_generic(rows, U1);
        for j in 0..n {
            direction[j] = T::one();
            jacobian.set_column(j, &self.directional(t, x, u, &direction).1);
            direction[j] = T::zero();
        }
        jacobian
    }

    /// `Dh(t, x, u)`, p x n. Costs n directional derivatives.
    fn output_jacobian(&self, t: T, x: &OVector<T, N>, u: &OVector<T, M>) -> OMatrix<T, P, N> {
        let (rows, n) = (x.shape_generic().0, x.nrows());
        let outputs = self.output(t, x, u).shape_generic().0;
        let mut jacobian = OMatrix::zeros_generic(outputs, rows);
        let mut direction = OVector::zeros_generic(rows, U1);
        for j in 0..n {
            direction[j] = T::one();
            jacobian.set_column(j, &self.output_directional(t, x, u, &direction).1);
            direction[j] = T::zero();
        }
        jacobian
    }

    /// Whether `f(t, x, u) = A(u) x + g(u)`, as of every [affine](Plant::is_affine) plant: filters then predict by the
    /// exact exponential, the input held. False where this is not known.
    fn is_linear_between_samples(&self) -> bool {
        self.is_affine()
    }

    /// `f(t, x, u)` and `Df(t, x, u)`: the same to the last bit as [`derivative`](Plant::derivative) and
    /// [`state_jacobian`](Self::state_jacobian). Override this for a plant whose derivatives share work with its
    /// right-hand side.
    fn motion(&self, t: T, x: &OVector<T, N>, u: &OVector<T, M>) -> (OVector<T, N>, OMatrix<T, N, N>) {
        (self.derivative(t, x, u), self.state_jacobian(t, x, u))
    }

    /// `h(t, x, u)` and `Dh(t, x, u)`, as [`motion`](Self::motion).
    fn measurement(&self, t: T, x: &OVector<T, N>, u: &OVector<T, M>) -> (OVector<T, P>, OMatrix<T, P, N>) {
        (self.output(t, x, u), self.output_jacobian(t, x, u))
    }

    /// [`motion`](Self::motion) on slices, matrices by columns. Returns whether the lengths fit; otherwise nothing is
    /// written. Override this for a plant whose columns have dynamic length, to avoid allocation.
    fn motion_into(&self, t: T, x: &[T], u: &[T], f: &mut [T], df: &mut [T]) -> bool {
        let columns = (OVector::<T, N>::try_from_slice(x), OVector::<T, M>::try_from_slice(u));
        let (Some(x), Some(u)) = columns else { return false };
        let (slope, jacobian) = self.motion(t, &x, &u);
        put(&slope, f) && put_matrix(&jacobian, df)
    }

    /// [`measurement`](Self::measurement) on slices, as [`motion_into`](Self::motion_into).
    fn measurement_into(&self, t: T, x: &[T], u: &[T], h: &mut [T], dh: &mut [T]) -> bool {
        let columns = (OVector::<T, N>::try_from_slice(x), OVector::<T, M>::try_from_slice(u));
        let (Some(x), Some(u)) = columns else { return false };
        let (output, jacobian) = self.measurement(t, &x, &u);
        put(&output, h) && put_matrix(&jacobian, dh)
    }
}

/// Copies a matrix out by columns; whether its size fits.
fn put_matrix<T: RealField + Copy, R: Dim, C: Dim>(matrix: &OMatrix<T, R, C>, target: &mut [T]) -> bool
where
    DefaultAllocator: nalgebra::allocator::Allocator<R, C>,
{
    let fits = matrix.len() == target.len();
    for (target, entry) in target.iter_mut().zip(matrix.iter()) {
        *target = *entry;
    }
    fits
}

impl<T: RealField + Copy, N: Dim, M: Dim, P: Dim> Differentiable<T, N, M, P> for LinearPlant<T, N, M, P>
where
    DefaultAllocator: Size<N, M, P>,
{
    fn directional(
        &self,
        t: T,
        x: &OVector<T, N>,
        u: &OVector<T, M>,
        v: &OVector<T, N>,
    ) -> (OVector<T, N>, OVector<T, N>) {
        (self.derivative(t, x, u), &self.a * v)
    }

    fn output_directional(
        &self,
        t: T,
        x: &OVector<T, N>,
        u: &OVector<T, M>,
        v: &OVector<T, N>,
    ) -> (OVector<T, P>, OVector<T, P>) {
        (self.output(t, x, u), &self.c * v)
    }
}

/// A plant that takes its derivatives from dual numbers: with the feature `dual` it is [`Differentiable`] if it is a
/// plant over `T` and over dual numbers of `T` (f32 or f64). Without the feature it has no effect.
///
/// ```
/// use luenberger_plants::{ByDual, Dimensions, Plant, Shape, state_jacobian};
/// use nalgebra::{RealField, SVector, Vector1};
///
/// /// x' = -x^3, y = x.
/// struct Drag;
///
/// impl ByDual for Drag {}
///
/// impl Shape for Drag {
///     fn dimensions(&self) -> Dimensions {
///         Dimensions { states: 1, inputs: 0, outputs: 1 }
///     }
/// }
///
/// impl<T: RealField + Copy> Plant<T> for Drag {
///     type State = Vector1<T>;
///     type Input = SVector<T, 0>;
///     type Output = Vector1<T>;
///     fn derivative(&self, _t: T, x: &Vector1<T>, _u: &SVector<T, 0>) -> Vector1<T> {
///         Vector1::new(-x[0] * x[0] * x[0])
///     }
///     fn output(&self, _t: T, x: &Vector1<T>, _u: &Self::Input) -> Vector1<T> {
///         *x
///     }
/// }
/// let jacobian = state_jacobian(&Drag, 0.0, &Vector1::new(2.0), &SVector::zeros());
/// assert_eq!(jacobian[0], -12.0);
/// ```
pub trait ByDual {}

impl<S: ByDual + ?Sized> ByDual for &S {}

/// `df/dx (t, x, u)`, of a plant written once for every scalar by dual numbers: n x n, entry (i, j) is `d f_i / d x_j`.
///
/// Exact up to the rounding of f itself. Where f is not differentiable the entries are those of the branch that f
/// takes; where it is not defined they are NaN or infinite. Costs n evaluations of f over dual numbers, allocates
/// nothing for static sizes.
///
/// ```
/// use luenberger_plants::{Chaotic, state_jacobian};
/// use nalgebra::{Matrix3, SVector, Vector3};
/// // x1' = ln(0.1 + exp(x2 - x1)), x2' = x1 x3, x3' = 0.2 - x1 x2
/// let x = Vector3::new(2.0, 2.0, 5.0);
/// let jacobian = state_jacobian(&Chaotic, 0.0, &x, &SVector::zeros());
/// let slope = 1.0 / 1.1;
/// let expected = Matrix3::new(-slope, slope, 0.0, 5.0, 0.0, 2.0, -2.0, -2.0, 0.0);
/// assert!((jacobian - expected).amax() <= f64::EPSILON);
/// ```
///
/// Source: forward mode, see the [module](self).
pub fn state_jacobian<S, T, N, M, P>(plant: &S, t: T, x: &OVector<T, N>, u: &OVector<T, M>) -> OMatrix<T, N, N>
where
    S: Differentiable<T, N, M, P>,
    T: RealField + Copy,
    N: Dim,
    M: Dim,
    P: Dim,
    DefaultAllocator: Size<N, M, P>,
{
    plant.state_jacobian(t, x, u)
}

#[cfg(feature = "dual")]
pub use dual::{along, apart, linearize};

/// The dual numbers over f64.
#[cfg(feature = "dual")]
pub use num_dual::Dual64;

#[cfg(feature = "dual")]
mod dual {
    use nalgebra::allocator::Allocator;
    use nalgebra::{DefaultAllocator, Dim, OMatrix, OVector, RealField};
    use num_dual::{Dual, DualNumFloat};

    use super::{ByDual, Differentiable};
    use crate::linear::LinearPlant;
    use crate::plant::Plant;
    use crate::size::Size;

    /// `x + v d`: the argument of a map over dual numbers that gives its derivative along v.
    pub fn along<T: DualNumFloat + RealField, N: Dim>(x: &OVector<T, N>, v: &OVector<T, N>) -> OVector<Dual<T>, N>
    where
        DefaultAllocator: Allocator<N>,
    {
        x.zip_map(v, Dual::new)
    }

    /// `u` as dual numbers with the derivative 0.
    fn constant<T: DualNumFloat + RealField, M: Dim>(u: &OVector<T, M>) -> OVector<Dual<T>, M>
    where
        DefaultAllocator: Allocator<M>,
    {
        u.map(Dual::from_re)
    }

    /// The real parts and the derivatives of a vector of dual numbers.
    pub fn apart<T: DualNumFloat + RealField, N: Dim>(y: &OVector<Dual<T>, N>) -> (OVector<T, N>, OVector<T, N>)
    where
        DefaultAllocator: Allocator<N>,
    {
        (y.map(|entry| entry.re), y.map(|entry| entry.eps))
    }

    /// The linear plant of the Jacobians at a point: `A = df/dx`, `B = df/du`, `C = dh/dx`, `D = dh/du`, of deviations
    /// from (x, u).
    ///
    /// Exact to rounding; D is `None` where it is zero. Entries are not finite where a derivative does not exist:
    /// [`LinearPlant::checked`] finds them. Costs n + m evaluations of f and of h over dual numbers.
    ///
    /// ```
    /// use luenberger_plants::{CukConverter, linearize};
    /// use nalgebra::{Vector1, Vector4};
    /// // x2' = ((1 - u) x1 + u x3)/C2: by u it is (x3 - x1)/C2.
    /// let plant = CukConverter::default();
    /// let linear = linearize(&plant, 0.0, &Vector4::new(1.0, 2.0, 3.0, 4.0), &Vector1::new(0.25));
    /// assert!((linear.b[(1, 0)] * plant.c2 - 2.0).abs() < 1e-14);
    /// assert!((linear.a[(1, 0)] * plant.c2 - 0.75).abs() < 1e-14 && linear.d.is_none());
    /// // Designs take a plant whose sizes are known at run time.
    /// let plant: luenberger_plants::StateSpace = linear.to_dynamic().checked()?;
    /// assert_eq!((plant.a.shape(), plant.b.shape(), plant.c.shape()), ((4, 4), (4, 1), (2, 4)));
    /// # Ok::<(), luenberger_plants::PlantError>(())
    /// ```
    pub fn linearize<S, T, N, M, P>(plant: &S, t: T, x: &OVector<T, N>, u: &OVector<T, M>) -> LinearPlant<T, N, M, P>
    where
        S: Differentiable<T, N, M, P>
            + Plant<Dual<T>, State = OVector<Dual<T>, N>, Input = OVector<Dual<T>, M>, Output = OVector<Dual<T>, P>>,
        T: DualNumFloat + RealField,
        N: Dim,
        M: Dim,
        P: Dim,
        DefaultAllocator: Size<N, M, P>,
    {
        let (a, c) = (plant.state_jacobian(t, x, u), plant.output_jacobian(t, x, u));
        let (states, inputs, outputs) = (x.shape_generic().0, u.shape_generic().0, c.shape_generic().0);
        let mut b = OMatrix::zeros_generic(states, inputs);
        let mut d = OMatrix::zeros_generic(outputs, inputs);
        let (now, x) = (Dual::from_re(t), constant(x));
        for j in 0..u.nrows() {
            let moved = OVector::from_fn_generic(inputs, nalgebra::U1, |k, _| {
                Dual::new(u[k], if k == j { T::one() } else { T::zero() })
            });
            b.set_column(j, &apart(&Plant::<Dual<T>>::derivative(plant, now, &x, &moved)).1);
            d.set_column(j, &apart(&Plant::<Dual<T>>::output(plant, now, &x, &moved)).1);
        }
        let is_zero = d.iter().all(|entry: &T| *entry == T::zero());
        LinearPlant { a, b, c, d: if is_zero { None } else { Some(d) } }
    }

    impl<S, T, N, M, P> Differentiable<T, N, M, P> for S
    where
        S: ByDual
            + Plant<T, State = OVector<T, N>, Input = OVector<T, M>, Output = OVector<T, P>>
            + Plant<Dual<T>, State = OVector<Dual<T>, N>, Input = OVector<Dual<T>, M>, Output = OVector<Dual<T>, P>>,
        T: DualNumFloat + RealField,
        N: Dim,
        M: Dim,
        P: Dim,
        DefaultAllocator: Size<N, M, P>,
    {
        fn directional(
            &self,
            t: T,
            x: &OVector<T, N>,
            u: &OVector<T, M>,
            v: &OVector<T, N>,
        ) -> (OVector<T, N>, OVector<T, N>) {
            apart(&Plant::<Dual<T>>::derivative(self, Dual::from_re(t), &along(x, v), &constant(u)))
        }

        fn output_directional(
            &self,
            t: T,
            x: &OVector<T, N>,
            u: &OVector<T, M>,
            v: &OVector<T, N>,
        ) -> (OVector<T, P>, OVector<T, P>) {
            apart(&Plant::<Dual<T>>::output(self, Dual::from_re(t), &along(x, v), &constant(u)))
        }
    }
}
