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
//! Entries are rounded to the nearest number of the scalar. A certificate concerns the gains as designed; the rounded
//! gains need a new proof, for instance by `deployed_linear` of the design crate.

use luenberger_plants::error::check_matrix;
use luenberger_plants::{PlantError, StateSpace, StaticPlant};
use nalgebra::{Const, DMatrix, DVector, Dyn, RealField, SMatrix, SVector};

use crate::cubic::{CubicObserver, StaticCubicObserver};
use crate::cubic_sampled::{SampledCubicGains, SampledCubicObserver, StaticSampledCubicObserver};
use crate::discrete_kalman::{KalmanFilter, KalmanModel, StaticKalmanFilter};
use crate::discrete_linear::{DiscreteLinearObserver, StaticDiscreteLinearObserver};
use crate::error::ObserverError;
use crate::functional::{FunctionalObserver, StaticFunctionalObserver};
use crate::interval::{SampledIntervalGains, SampledIntervalObserver, StaticSampledIntervalObserver};
use crate::linear::{LinearObserver, StaticLinearObserver};
use crate::observer::SampledObserver;
use crate::proportional_integral::{ProportionalIntegralObserver, StaticProportionalIntegralObserver};
use crate::stationary_kalman::{StaticStationaryKalmanFilter, StationaryKalmanFilter};
use crate::unknown_input::{StaticUnknownInputObserver, UnknownInputObserver};
use crate::varying_period::{StaticVaryingPeriodObserver, VaryingPeriodObserver};

/// The same matrix with sizes known at compile time, over `T`.
///
/// # Errors
/// [`ObserverError::Matrix`] for another shape, and for an entry beyond the range of `T`.
fn fixed<T: RealField + Copy, const R: usize, const C: usize>(
    what: &'static str,
    m: &DMatrix<f64>,
) -> Result<SMatrix<T, R, C>, ObserverError> {
    check_matrix(what, m, (R, C))?;
    let fixed = SMatrix::<T, R, C>::from_fn(|i, j| nalgebra::convert(m[(i, j)]));
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
