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
//! Entries are rounded to the nearest number of the scalar. A certificate concerns the gains as designed; the rounded
//! gains need a new proof, for instance by `deployed_linear` of the design crate.

use luenberger_plants::error::check_matrix;
use luenberger_plants::{Differentiable, Dimensions, Plant, PlantError, Size, StateSpace, StaticPlant};
use nalgebra::allocator::Allocator;
use nalgebra::{Const, DMatrix, DVector, DefaultAllocator, Dim, Dyn, OMatrix, OVector, RealField, SMatrix, SVector};

use crate::cubic::{CubicObserver, StaticCubicObserver};
use crate::cubic_sampled::{SampledCubicGains, SampledCubicObserver, StaticSampledCubicObserver};
use crate::discrete_kalman::{KalmanFilter, KalmanModel, StaticKalmanFilter};
use crate::discrete_linear::{DiscreteLinearObserver, StaticDiscreteLinearObserver};
use crate::discrete_luenberger::{DiscreteNonlinearObserver, StaticDiscreteNonlinearObserver};
use crate::error::ObserverError;
use crate::functional::{FunctionalObserver, StaticFunctionalObserver};
use crate::gaussian::NoiseModel;
use crate::interval::{SampledIntervalGains, SampledIntervalObserver, StaticSampledIntervalObserver};
use crate::kalman::{ExtendedKalmanFilter, StaticExtendedKalmanFilter};
use crate::linear::{LinearObserver, StaticLinearObserver};
use crate::mean_value::{Mean, MeanValueObserver, StaticMeanValueObserver};
use crate::nonlinear_luenberger::{NonlinearLuenbergerObserver, StaticNonlinearLuenbergerObserver};
use crate::observer::SampledObserver;
use crate::proportional_integral::{ProportionalIntegralObserver, StaticProportionalIntegralObserver};
use crate::sampled_nonlinear::{SampledNonlinearObserver, StaticSampledNonlinearObserver};
use crate::stationary_kalman::{StaticStationaryKalmanFilter, StationaryKalmanFilter};
use crate::unknown_input::{StaticUnknownInputObserver, UnknownInputObserver};
use crate::unscented::{StaticUnscentedKalmanFilter, UnscentedKalmanFilter};
use crate::varying_period::{StaticVaryingPeriodObserver, VaryingPeriodObserver};

/// The same matrix with sizes known at compile time, over `T`.
///
/// # Errors
/// [`ObserverError::Matrix`] for another shape, and for an entry beyond the range of `T`.
fn fixed<T: RealField + Copy, const R: usize, const C: usize, R0: Dim, C0: Dim>(
    what: &'static str,
    m: &OMatrix<f64, R0, C0>,
) -> Result<SMatrix<T, R, C>, ObserverError>
where
    DefaultAllocator: Allocator<R0, C0>,
{
    if m.shape() != (R, C) {
        return Err(PlantError::DimensionMismatch { what, expected: (R, C), found: m.shape() }.into());
    }
    rounded(what, |i, j| m[(i, j)])
}

/// The entries over `T`, apart from [`fixed`] and its bound on the allocator, which hides those of static sizes.
fn rounded<T: RealField + Copy, const R: usize, const C: usize>(
    what: &'static str,
    entry: impl Fn(usize, usize) -> f64,
) -> Result<SMatrix<T, R, C>, ObserverError> {
    let fixed = SMatrix::<T, R, C>::from_fn(|i, j| nalgebra::convert(entry(i, j)));
    check_matrix(what, &fixed, (R, C))?;
    Ok(fixed)
}

/// The same column with its length known at compile time, over `T`.
///
/// # Errors
/// As [`fixed`].
fn fixed_column<T: RealField + Copy, const R: usize>(
    what: &'static str,
    v: &DVector<f64>,
) -> Result<SVector<T, R>, ObserverError> {
    fixed(what, &DMatrix::from_column_slice(v.len(), 1, v.as_slice()))
}

/// The same plant with sizes known at compile time, over `T`.
fn fixed_plant<T: RealField + Copy, const N: usize, const M: usize, const P: usize>(
    plant: StateSpace,
) -> Result<StaticPlant<T, N, M, P>, ObserverError> {
    let StateSpace { a, b, c, d } = plant;
    let plant = StaticPlant::new(fixed("A", &a)?, fixed("B", &b)?, fixed("C", &c)?)?;
    Ok(match d {
        Some(d) => plant.with_feedthrough(fixed("D", &d)?)?,
        None => plant,
    })
}

impl LinearObserver<f64, Dyn, Dyn, Dyn> {
    /// The same observer with N states, M inputs and P outputs, over the scalar `T`; see the
    /// [module](crate::static_size).
    ///
    /// # Errors
    /// [`ObserverError::Matrix`] for other sizes, and for an entry beyond the range of `T`.
    pub fn to_static<T: RealField + Copy, const N: usize, const M: usize, const P: usize>(
        &self,
    ) -> Result<StaticLinearObserver<T, N, M, P>, ObserverError> {
        LinearObserver::of(fixed_plant(self.plant())?, fixed("L", &self.l)?)
    }
}

impl CubicObserver<f64, Dyn, Dyn, Dyn> {
    /// The same observer with N states, M inputs and P outputs, over the scalar `T`; see the
    /// [module](crate::static_size).
    ///
    /// # Errors
    /// [`ObserverError::Matrix`] for other sizes, and for an entry beyond the range of `T`.
    pub fn to_static<T: RealField + Copy, const N: usize, const M: usize, const P: usize>(
        &self,
    ) -> Result<StaticCubicObserver<T, N, M, P>, ObserverError> {
        let Self { l, n, theta, .. } = self;
        CubicObserver::of(fixed_plant(self.plant())?, fixed("L", l)?, fixed("N", n)?, fixed("theta", theta)?)
    }
}

impl DiscreteLinearObserver<f64, Dyn, Dyn, Dyn> {
    /// The same observer with N states, M inputs and P outputs, over the scalar `T`; see the
    /// [module](crate::static_size).
    ///
    /// # Errors
    /// [`ObserverError::Matrix`] for other sizes, and for an entry beyond the range of `T`.
    pub fn to_static<T: RealField + Copy, const N: usize, const M: usize, const P: usize>(
        &self,
    ) -> Result<StaticDiscreteLinearObserver<T, N, M, P>, ObserverError> {
        let period = nalgebra::convert(self.period());
        DiscreteLinearObserver::new(fixed_plant(self.plant().clone())?, fixed("L", self.l())?, period)
    }
}

impl SampledCubicObserver<f64, Dyn, Dyn, Dyn> {
    /// The same observer with N states, M inputs and P outputs, over the scalar `T`; see the
    /// [module](crate::static_size).
    ///
    /// # Errors
    /// [`ObserverError::Matrix`] for other sizes, and for an entry beyond the range of `T`; those of
    /// [`new`](Self::new) for what rounding may destroy.
    pub fn to_static<T: RealField + Copy, const N: usize, const M: usize, const P: usize>(
        &self,
    ) -> Result<StaticSampledCubicObserver<T, N, M, P>, ObserverError> {
        let gains = SampledCubicGains {
            ad: fixed("Ad", self.ad())?,
            bd: fixed("Bd", self.bd())?,
            c: fixed("C", self.c())?,
            ld: fixed("Ld", self.ld())?,
            n: fixed("N", self.n())?,
            theta: fixed("theta", self.theta())?,
            w: nalgebra::convert(self.w()),
            period: nalgebra::convert(self.period()),
        };
        let observer = match self.coupling() {
            Some(coupling) => SampledCubicObserver::semi_implicit(gains, fixed("-C N", coupling)?)?,
            None => SampledCubicObserver::new(gains)?,
        };
        match self.d() {
            Some(d) => observer.with_feedthrough(fixed("D", d)?),
            None => Ok(observer),
        }
    }
}

impl KalmanFilter<f64, Dyn, Dyn, Dyn> {
    /// The same filter with N states, M inputs and P outputs, over the scalar `T`; see the
    /// [module](crate::static_size).
    ///
    /// # Errors
    /// [`ObserverError::Matrix`] for other sizes, and for an entry beyond the range of `T`; those of
    /// [`new`](Self::new) for what rounding may destroy.
    pub fn to_static<T: RealField + Copy, const N: usize, const M: usize, const P: usize>(
        &self,
    ) -> Result<StaticKalmanFilter<T, N, M, P>, ObserverError> {
        let model = self.model();
        let filter = KalmanFilter::new(KalmanModel {
            ad: fixed("Ad", &model.ad)?,
            bd: fixed("Bd", &model.bd)?,
            c: fixed("C", &model.c)?,
            w: fixed("W", &model.w)?,
            v: fixed("V", &model.v)?,
            p0: fixed("P(0)", &model.p0)?,
            period: nalgebra::convert(model.period),
        })?;
        match self.d() {
            Some(d) => filter.with_feedthrough(fixed("D", d)?),
            None => Ok(filter),
        }
    }
}

impl StationaryKalmanFilter<f64, Dyn, Dyn, Dyn> {
    /// The same filter with N states, M inputs and P outputs, over the scalar `T`; see the
    /// [module](crate::static_size).
    ///
    /// # Errors
    /// [`ObserverError::Matrix`] for other sizes, and for an entry beyond the range of `T`; [`ObserverError::Period`]
    /// for a period that `T` rounds to 0 or to infinity.
    pub fn to_static<T: RealField + Copy, const N: usize, const M: usize, const P: usize>(
        &self,
    ) -> Result<StaticStationaryKalmanFilter<T, N, M, P>, ObserverError> {
        StationaryKalmanFilter::new(self.predictor().to_static()?, fixed("K", self.k())?)
    }
}

impl VaryingPeriodObserver<f64, Dyn, Dyn, Dyn> {
    /// The same observer with N states, M inputs and P outputs, over the scalar `T`; see the
    /// [module](crate::static_size).
    ///
    /// # Errors
    /// [`ObserverError::Matrix`] for other sizes, and for an entry beyond the range of `T`; those of
    /// [`new`](Self::new) and of [`SampledCubicObserver::new`] for what rounding may destroy.
    pub fn to_static<T: RealField + Copy, const N: usize, const M: usize, const P: usize>(
        &self,
    ) -> Result<StaticVaryingPeriodObserver<T, N, M, P>, ObserverError> {
        let (nominal, longest) = (self.nominal().to_static()?, nalgebra::convert(self.longest()));
        VaryingPeriodObserver::new(
            nominal,
            fixed("A", self.a())?,
            fixed("B", self.b())?,
            fixed("K", self.k())?,
            longest,
        )
    }
}

impl FunctionalObserver<f64, Dyn, Dyn, Dyn> {
    /// The same observer of R functions with M inputs and P outputs, over the scalar `T`; see the
    /// [module](crate::static_size).
    ///
    /// # Errors
    /// [`ObserverError::Matrix`] for other sizes, and for an entry beyond the range of `T`.
    pub fn to_static<T: RealField + Copy, const R: usize, const M: usize, const P: usize>(
        &self,
    ) -> Result<StaticFunctionalObserver<T, R, M, P>, ObserverError> {
        let (f, g) = (fixed("F", self.f())?, fixed("G", self.g())?);
        FunctionalObserver::new(f, g, fixed("H", self.h())?, fixed("N", self.n())?)
    }
}

impl SampledIntervalObserver<f64, Dyn, Dyn, Dyn, Dyn, Dyn> {
    /// The same observer with N states, M inputs, P outputs, Q blocks and `S = N + Q`, over the scalar `T`; see the
    /// [module](crate::static_size).
    ///
    /// The enclosure is proved for the format of the design, rounding of the step included: `f64` for binary64, `f32`
    /// for binary32, whose gains `f32` has exactly. In another scalar the bounds need a new proof.
    ///
    /// # Errors
    /// [`ObserverError::Matrix`] for other sizes, and for an entry beyond the range of `T`; those of
    /// [`new`](Self::new) for what rounding may destroy.
    pub fn to_static<
        T: RealField + Copy,
        const N: usize,
        const M: usize,
        const P: usize,
        const Q: usize,
        const S: usize,
    >(
        &self,
    ) -> Result<StaticSampledIntervalObserver<T, N, M, P, Q, S>, ObserverError> {
        let gains = self.gains();
        SampledIntervalObserver::new(SampledIntervalGains {
            f: fixed("F", &gains.f)?,
            g: fixed("G", &gains.g)?,
            c: fixed("C", &gains.c)?,
            l: fixed("L", &gains.l)?,
            blocks: fixed("N", &gains.blocks)?,
            constant: fixed_column("g", &gains.constant)?,
            of_estimate: fixed("Q", &gains.of_estimate)?,
            of_input: fixed("U", &gains.of_input)?,
            h: fixed("H", &gains.h)?,
            outward: nalgebra::convert(gains.outward),
            start: fixed_column("rho", &gains.start)?,
            period: nalgebra::convert(gains.period),
        })
    }
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
            /// The same observer with N states, M inputs and P outputs, over the scalar `T`; see the
            /// [module](crate::static_size).
            ///
            /// # Errors
            /// [`ObserverError::Matrix`] for other sizes, and for an entry beyond the range of `T`.
            pub fn to_static<T: RealField + Copy, const N: usize, const M: usize, const P: usize>(
                &self,
            ) -> Result<StaticUnknownInputObserver<$target<T, N, M, P>, T, N, M, P>, ObserverError> {
                let d = self.d().map(|d| fixed("D", d)).transpose()?;
                UnknownInputObserver::new(self.inner().to_static()?, fixed("H", self.h())?, d)
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
fn same_sizes<const N: usize, const M: usize, const P: usize>(
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

impl<S, N0: Dim, M0: Dim, P0: Dim> NonlinearLuenbergerObserver<S, f64, N0, M0, P0>
where
    DefaultAllocator: Size<N0, M0, P0>,
{
    /// The same observer of `plant`, which is the plant of this one over the scalar `T`, with N states, M inputs and P
    /// outputs; see the [module](crate::static_size).
    ///
    /// # Errors
    /// [`ObserverError::Matrix`] for other sizes of plant or gain, and for an entry beyond the range of `T`; those of
    /// `new` for what rounding may destroy.
    pub fn to_static<T: RealField + Copy, const N: usize, const M: usize, const P: usize, Q>(
        &self,
        plant: Q,
    ) -> Result<StaticNonlinearLuenbergerObserver<Q, T, N, M, P>, ObserverError>
    where
        Q: Plant<T, State = SVector<T, N>, Input = SVector<T, M>, Output = SVector<T, P>>,
    {
        same_sizes::<N, M, P>(plant.dimensions(), self.l().shape())?;
        StaticNonlinearLuenbergerObserver::<Q, T, N, M, P>::new(plant, fixed::<T, N, P, _, _>("L", self.l())?)
    }
}

impl<S, N0: Dim, M0: Dim, P0: Dim> SampledNonlinearObserver<S, f64, N0, M0, P0>
where
    S: Differentiable<f64, N0, M0, P0>,
    DefaultAllocator: Size<N0, M0, P0>,
{
    /// The same observer of `plant`, which is the plant of this one over the scalar `T`, with N states, M inputs and P
    /// outputs; see the [module](crate::static_size).
    ///
    /// # Errors
    /// [`ObserverError::Matrix`] for other sizes of plant or gain, and for an entry beyond the range of `T`; those of
    /// `new` for what rounding may destroy.
    pub fn to_static<T: RealField + Copy, const N: usize, const M: usize, const P: usize, Q>(
        &self,
        plant: Q,
    ) -> Result<StaticSampledNonlinearObserver<Q, T, N, M, P>, ObserverError>
    where
        Q: Differentiable<T, Const<N>, Const<M>, Const<P>>,
    {
        same_sizes::<N, M, P>(plant.dimensions(), self.l().shape())?;
        let period = nalgebra::convert(self.period());
        StaticSampledNonlinearObserver::<Q, T, N, M, P>::new(
            plant,
            fixed::<T, N, P, _, _>("L", self.l())?,
            period,
            self.substeps(),
        )
    }
}

impl<S, N0: Dim, M0: Dim, P0: Dim> DiscreteNonlinearObserver<S, f64, N0, M0, P0>
where
    S: Plant<f64, State = OVector<f64, N0>, Input = OVector<f64, M0>, Output = OVector<f64, P0>>,
    DefaultAllocator: Size<N0, M0, P0>,
{
    /// The same observer of `plant`, which is the plant of this one over the scalar `T`, with N states, M inputs and P
    /// outputs; see the [module](crate::static_size).
    ///
    /// # Errors
    /// [`ObserverError::Matrix`] for other sizes of plant or gain, and for an entry beyond the range of `T`; those of
    /// `new` for what rounding may destroy.
    pub fn to_static<T: RealField + Copy, const N: usize, const M: usize, const P: usize, Q>(
        &self,
        plant: Q,
    ) -> Result<StaticDiscreteNonlinearObserver<Q, T, N, M, P>, ObserverError>
    where
        Q: Plant<T, State = SVector<T, N>, Input = SVector<T, M>, Output = SVector<T, P>>,
    {
        same_sizes::<N, M, P>(plant.dimensions(), self.l().shape())?;
        let period = nalgebra::convert(self.period());
        StaticDiscreteNonlinearObserver::<Q, T, N, M, P>::new(plant, fixed::<T, N, P, _, _>("L", self.l())?, period)
    }
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
        let (eta, internal_error) =
            (nalgebra::convert(self.eta()), fixed::<T, N, 1, _, _>("e", self.internal_error())?);
        match self.l() {
            Some(l) => StaticMeanValueObserver::<Q, E, T, N, M, P>::with_output_injection(
                plant,
                eta,
                mean,
                internal_error,
                fixed::<T, N, P, _, _>("L", l)?,
            ),
            None => StaticMeanValueObserver::<Q, E, T, N, M, P>::new(plant, eta, mean, internal_error),
        }
    }
}

/// The covariances, or their factors.
#[allow(clippy::type_complexity, reason = "noises of static sizes")]
fn fixed_noises<T: RealField + Copy, const N: usize, const P: usize, N0: Dim, P0: Dim>(
    noises: &NoiseModel<f64, N0, P0>,
) -> Result<NoiseModel<T, Const<N>, Const<P>>, ObserverError>
where
    DefaultAllocator: Allocator<N0, N0> + Allocator<P0, P0>,
{
    let NoiseModel { w, v, p0 } = noises;
    Ok(NoiseModel {
        w: fixed::<T, N, N, _, _>("W", w)?,
        v: fixed::<T, P, P, _, _>("V", v)?,
        p0: fixed::<T, N, N, _, _>("P(0)", p0)?,
    })
}

impl<S, N0: Dim, M0: Dim, P0: Dim> ExtendedKalmanFilter<S, f64, N0, M0, P0>
where
    S: Differentiable<f64, N0, M0, P0>,
    DefaultAllocator: Size<N0, M0, P0>,
{
    /// The same filter of `plant`, which is the plant of this one over the scalar `T`, with N states, M inputs and P
    /// outputs; see the [module](crate::static_size).
    ///
    /// # Errors
    /// [`ObserverError::Matrix`] for other sizes, and for an entry beyond the range of `T`; those of [`new`](Self::new)
    /// and [`with_gate`](Self::with_gate) for what rounding may destroy.
    pub fn to_static<T: RealField + Copy, const N: usize, const M: usize, const P: usize, Q>(
        &self,
        plant: Q,
    ) -> Result<StaticExtendedKalmanFilter<Q, T, N, M, P>, ObserverError>
    where
        Q: Differentiable<T, Const<N>, Const<M>, Const<P>>,
    {
        let noises = self.noise_model();
        same_sizes::<N, M, P>(plant.dimensions(), (noises.w.nrows(), noises.v.nrows()))?;
        let (noises, h) = (fixed_noises::<T, N, P, _, _>(noises)?, nalgebra::convert(self.h()));
        StaticExtendedKalmanFilter::<Q, T, N, M, P>::discrete(plant, noises, h)?.with_options_of(self)
    }
}

impl<S, N0: Dim, M0: Dim, P0: Dim> UnscentedKalmanFilter<S, f64, N0, M0, P0>
where
    S: Differentiable<f64, N0, M0, P0>,
    DefaultAllocator: Size<N0, M0, P0>,
{
    /// The same filter of `plant`, which is the plant of this one over the scalar `T`, with N states, M inputs and P
    /// outputs; see the [module](crate::static_size). The factors of the covariances are rounded, not the covariances.
    ///
    /// # Errors
    /// [`ObserverError::Matrix`] for other sizes, and for an entry beyond the range of `T`; those of [`new`](Self::new)
    /// and [`with_gate`](Self::with_gate) for what rounding may destroy.
    pub fn to_static<T: RealField + Copy, const N: usize, const M: usize, const P: usize, Q>(
        &self,
        plant: Q,
    ) -> Result<StaticUnscentedKalmanFilter<Q, T, N, M, P>, ObserverError>
    where
        Q: Differentiable<T, Const<N>, Const<M>, Const<P>>,
    {
        let factors = self.factors();
        same_sizes::<N, M, P>(plant.dimensions(), (factors.w.nrows(), factors.v.nrows()))?;
        let (factors, h) = (fixed_noises::<T, N, P, _, _>(factors)?, nalgebra::convert(self.h()));
        let filter = StaticUnscentedKalmanFilter::<Q, T, N, M, P>::from_factors(
            plant,
            factors,
            self.sigma_points(),
            h,
            self.prediction(),
        )?;
        match self.gate() {
            Some(gate) => filter.with_gate(nalgebra::convert(gate)),
            None => Ok(filter),
        }
    }
}
