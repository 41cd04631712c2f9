//! Conversion of designed observers, whose sizes are known at run time, to the static sizes and the scalar of the
//! target.
//!
//! ```
//! use luenberger_observers::{CubicObserver, Observer, StaticCubicObserver};
//! use nalgebra::{DMatrix, Vector1, Vector2, dmatrix};
//! let plant = luenberger_plants::double_integrator().to_dynamic();
//! let designed = CubicObserver::of(plant, dmatrix![7.0; 10.0], dmatrix![-9.5; -11.5], DMatrix::identity(1, 1))?;
//! let target: StaticCubicObserver<f32, 2, 1, 1> = designed.to_static()?;
//! let slope = target.derivative(0.0, &Vector2::zeros(), &Vector1::new(0.0), &Vector1::new(2.0));
//! assert_eq!(slope, Vector2::new(14.0 + 76.0, 20.0 + 92.0));
//! // Other sizes than the observer has are an error.
//! assert!(designed.to_static::<f32, 3, 1, 1>().is_err());
//! # Ok::<(), luenberger_observers::ObserverError>(())
//! ```
//! An observer of a nonlinear plant is given the plant over the scalar of the target, which is of a type of its own;
//! gain, noises, period and steps are those of the design. From the design on the workstation to the step on the
//! target, in f32:
//!
//! ```
//! use luenberger_observers::{SampledNonlinearObserver, SampledObserver, StaticSampledNonlinearObserver};
//! use luenberger_plants::{Differentiable, Dimensions, Plant, Shape};
//! use nalgebra::{Const, RealField, SVector, Vector1, Vector2, convert};
//!
//! /// A pendulum whose angle is measured: x1' = x2, x2' = u - 9.81 sin x1 - x2/5, with its Jacobians, in any scalar.
//! struct Pendulum;
//!
//! impl Shape for Pendulum {
//!     fn dimensions(&self) -> Dimensions {
//!         Dimensions { states: 2, inputs: 1, outputs: 1 }
//!     }
//! }
//!
//! impl<T: RealField + Copy> Plant<T> for Pendulum {
//!     type State = SVector<T, 2>;
//!     type Input = SVector<T, 1>;
//!     type Output = SVector<T, 1>;
//!
//!     fn derivative(&self, _t: T, x: &SVector<T, 2>, u: &SVector<T, 1>) -> SVector<T, 2> {
//!         Vector2::new(x[1], u[0] - convert::<f64, T>(9.81) * x[0].sin() - convert::<f64, T>(0.2) * x[1])
//!     }
//!     fn output(&self, _t: T, x: &SVector<T, 2>, _u: &SVector<T, 1>) -> SVector<T, 1> {
//!         Vector1::new(x[0])
//!     }
//! }
//!
//! impl<T: RealField + Copy> Differentiable<T, Const<2>, Const<1>, Const<1>> for Pendulum {
//!     fn directional(
//!         &self,
//!         t: T,
//!         x: &SVector<T, 2>,
//!         u: &SVector<T, 1>,
//!         v: &SVector<T, 2>,
//!     ) -> (SVector<T, 2>, SVector<T, 2>) {
//!         let slope = -convert::<f64, T>(9.81) * x[0].cos() * v[0] - convert::<f64, T>(0.2) * v[1];
//!         (self.derivative(t, x, u), Vector2::new(v[1], slope))
//!     }
//!     fn output_directional(
//!         &self,
//!         t: T,
//!         x: &SVector<T, 2>,
//!         u: &SVector<T, 1>,
//!         v: &SVector<T, 2>,
//!     ) -> (SVector<T, 1>, SVector<T, 1>) {
//!         (self.output(t, x, u), Vector1::new(v[0]))
//!     }
//! }
//!
//! // The gain of an LPV, Lipschitz or mean-value design, in f64: design.observer.to_static(..) is the same.
//! let designed = SampledNonlinearObserver::new(Pendulum, Vector2::new(6.0, 4.0), 0.01, 1)?;
//! let target: StaticSampledNonlinearObserver<Pendulum, f32, 2, 1, 1> = designed.to_static(Pendulum)?;
//!
//! let (mut x, mut xhat, u) = (Vector2::new(1.0_f32, 0.0), Vector2::zeros(), Vector1::new(0.0));
//! for k in 0..1000 {
//!     let y = Pendulum.output(0.0, &x, &u);
//!     target.step(0.01 * k as f32, &mut xhat, &u, &y);
//!     // The machine, here its model in small steps.
//!     for _ in 0..10 {
//!         let middle = x + Pendulum.derivative(0.0, &x, &u) * 0.0005;
//!         x += Pendulum.derivative(0.0, &middle, &u) * 0.001;
//!     }
//! }
//! assert!((x - xhat).norm() < 1e-3);
//! # Ok::<(), luenberger_observers::ObserverError>(())
//! ```
//! `cast` keeps the sizes and changes the scalar alone, and `map` makes the observer of other matrices.
//!
//! Entries are rounded to the nearest number of the scalar. A certificate concerns the gains as designed; the rounded
//! gains need a new proof, for instance by `deployed_linear` of the design crate.

use luenberger_plants::{Differentiable, Dimensions, PlantError, Size};
use nalgebra::allocator::Allocator;
use nalgebra::{Const, DMatrix, DefaultAllocator, Dim, Dyn, OMatrix, RealField};

use crate::cubic::{CubicObserver, StaticCubicObserver};
use crate::error::ObserverError;
use crate::linear::{LinearObserver, StaticLinearObserver};
use crate::matrix_name::MatrixName;
use crate::mean_value::{Mean, MeanValueObserver, StaticMeanValueObserver};
use crate::proportional_integral::{ProportionalIntegralObserver, StaticProportionalIntegralObserver};
use crate::unknown_input::{StaticUnknownInputObserver, UnknownInputObserver};

/// The matrix over `T`, each entry rounded to the nearest number.
pub(crate) fn rounded<T: RealField + Copy>(_name: MatrixName, m: &DMatrix<f64>) -> DMatrix<T> {
    m.map(nalgebra::convert)
}

/// The same matrix with sizes known at run time.
pub(crate) fn dynamic<T: RealField + Copy, R: Dim, C: Dim>(m: &OMatrix<T, R, C>) -> DMatrix<T>
where
    DefaultAllocator: Allocator<R, C>,
{
    DMatrix::from_fn(m.nrows(), m.ncols(), |i, j| m[(i, j)])
}

/// The same matrix with the sizes of the type.
///
/// # Errors
/// [`ObserverError::Matrix`] for another shape.
pub(crate) fn sized<T: RealField + Copy, R: Dim, C: Dim>(
    what: &'static str,
    m: &DMatrix<T>,
) -> Result<OMatrix<T, R, C>, ObserverError>
where
    DefaultAllocator: Allocator<R, C>,
{
    let (rows, columns) = m.shape();
    let expected = (R::try_to_usize().unwrap_or(rows), C::try_to_usize().unwrap_or(columns));
    if m.shape() != expected {
        return Err(PlantError::DimensionMismatch { what, expected, found: m.shape() }.into());
    }
    Ok(OMatrix::from_fn_generic(R::from_usize(rows), C::from_usize(columns), |i, j| m[(i, j)]))
}

/// `to_static` of observers that are made of a linear or a cubic one.
macro_rules! with_inner {
    ($($inner:ident, $target:ident;)+) => {$(
        impl ProportionalIntegralObserver<$inner<f64, Dyn, Dyn, Dyn>, Dyn> {
            /// The same observer with N states, K states and disturbances together, M inputs and P outputs, over the
            /// scalar `T`; see the [module](crate::static_size).
            ///
            /// # Errors
            /// [`ObserverError::Matrix`] for other sizes, and for an entry beyond the range of `T`.
            pub fn to_static<
                T: RealField + Copy,
                const N: usize,
                const K: usize,
                const M: usize,
                const P: usize,
            >(
                &self,
            ) -> Result<StaticProportionalIntegralObserver<$target<T, K, M, P>, N>, ObserverError> {
                let (expected, found) = ((N, 1), (self.states(), 1));
                if found != expected {
                    return Err(PlantError::DimensionMismatch { what: "the state", expected, found }.into());
                }
                ProportionalIntegralObserver::new::<T>(self.inner().to_static()?, Const)
            }
        }

        impl UnknownInputObserver<$inner<f64, Dyn, Dyn, Dyn>, f64, Dyn, Dyn, Dyn> {
            /// The same observer over the scalar `T` and with these sizes, of matrices that `f` makes of its own, whose
            /// names it is given.
            ///
            /// # Errors
            /// [`ObserverError::Matrix`] for matrices of other sizes; those of [`new`](Self::new).
            pub fn map<T: RealField + Copy, N: Dim, M: Dim, P: Dim>(
                &self,
                mut f: impl FnMut(MatrixName, &DMatrix<f64>) -> DMatrix<T>,
            ) -> Result<UnknownInputObserver<$inner<T, N, M, P>, T, N, M, P>, ObserverError>
            where
                DefaultAllocator: Size<N, M, P>,
            {
                let d = self.d().map(|d| sized("D", &f(MatrixName::D, d))).transpose()?;
                UnknownInputObserver::new(self.inner().map(&mut f)?, sized("H", &f(MatrixName::H, self.h()))?, d)
            }

            /// The same observer over the scalar `T`.
            ///
            /// # Errors
            /// [`ObserverError::Matrix`] for an entry beyond the range of `T`.
            #[allow(clippy::type_complexity, reason = "the type of the observer itself")]
            pub fn cast<T: RealField + Copy>(
                &self,
            ) -> Result<UnknownInputObserver<$inner<T, Dyn, Dyn, Dyn>, T, Dyn, Dyn, Dyn>, ObserverError> {
                self.map(rounded)
            }

            /// The same observer with N states, M inputs and P outputs, over the scalar `T`; see the
            /// [module](crate::static_size).
            ///
            /// # Errors
            /// [`ObserverError::Matrix`] for other sizes, and for an entry beyond the range of `T`.
            pub fn to_static<T: RealField + Copy, const N: usize, const M: usize, const P: usize>(
                &self,
            ) -> Result<StaticUnknownInputObserver<$target<T, N, M, P>, T, N, M, P>, ObserverError> {
                self.map(rounded)
            }
        }
    )+};
}

with_inner! {
    LinearObserver, StaticLinearObserver;
    CubicObserver, StaticCubicObserver;
}

/// The plant of the target, after a check of its sizes: those of the type, and of the design's plant with the gain or
/// the noises.
pub(crate) fn same_sizes<const N: usize, const M: usize, const P: usize>(
    found: Dimensions,
    designed: (usize, usize),
) -> Result<(), ObserverError> {
    for (what, expected, found) in [
        ("the state of the plant", N, found.states),
        ("the input of the plant", M, found.inputs),
        ("the output of the plant", P, found.outputs),
        ("the state of the design", N, designed.0),
        ("the output of the design", P, designed.1),
    ] {
        if expected != found {
            return Err(PlantError::DimensionMismatch { what, expected: (expected, 1), found: (found, 1) }.into());
        }
    }
    Ok(())
}

impl<S, D, N0: Dim, M0: Dim, P0: Dim> MeanValueObserver<S, D, f64, N0, M0, P0>
where
    S: Differentiable<f64, N0, M0, P0>,
    D: Mean<S, f64, N0, M0, P0>,
    DefaultAllocator: Size<N0, M0, P0>,
{
    /// The same observer of `plant` with the mean `mean`, which are those of this one over the scalar `T`, with N
    /// states, M inputs and P outputs; see the [module](crate::static_size). It is stepped as a
    /// [`StaticInterSampleObserver`](crate::StaticInterSampleObserver).
    ///
    /// # Errors
    /// [`ObserverError::Matrix`] for other sizes of plant or gain, and for an entry beyond the range of `T`; those of
    /// [`new`](Self::new) for what rounding may destroy.
    pub fn to_static<T: RealField + Copy, const N: usize, const M: usize, const P: usize, Q, E>(
        &self,
        plant: Q,
        mean: E,
    ) -> Result<StaticMeanValueObserver<Q, E, T, N, M, P>, ObserverError>
    where
        Q: Differentiable<T, Const<N>, Const<M>, Const<P>>,
        E: Mean<Q, T, Const<N>, Const<M>, Const<P>>,
    {
        let designed = self.plant().dimensions();
        same_sizes::<N, M, P>(plant.dimensions(), (designed.states, designed.outputs))?;
        let (eta, error) = (nalgebra::convert(self.eta()), dynamic(self.internal_error()).map(nalgebra::convert));
        let internal_error = sized::<T, Const<N>, Const<1>>("e", &error)?;
        match self.l() {
            Some(l) => StaticMeanValueObserver::<Q, E, T, N, M, P>::with_output_injection(
                plant,
                eta,
                mean,
                internal_error,
                sized::<T, Const<N>, Const<P>>("L", &rounded(MatrixName::L, &dynamic(l)))?,
            ),
            None => StaticMeanValueObserver::<Q, E, T, N, M, P>::new(plant, eta, mean, internal_error),
        }
    }
}
