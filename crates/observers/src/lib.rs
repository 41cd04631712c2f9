//! State observers as they run on the target: `no_std`, no allocation, no panic.
//!
//! Nothing here links `alloc` unless the feature of that name is on: with `--no-default-features` the crate builds for
//! bare targets such as thumbv7em-none-eabihf.
//!
//! Each observer is defined once, generic over the scalar and over nalgebra's dimensions. With [`nalgebra::Const`]
//! sizes it runs on a microcontroller in `f32` or `f64`; with [`nalgebra::Dyn`] (feature `alloc`) the same code is
//! simulated, checked and certified on a workstation.
//!
//! | file | subject |
//! |---|---|
//! | [`observer`] | the traits [`Observer`] (continuous time) and [`SampledObserver`] (one step per sample) |
//! | [`linear`] | Luenberger's observer `xhat' = A xhat + B u + L (y - C xhat)` |
//! | [`cubic`] | the cubic observer, which adds `-(y~' theta y~) N y~`, and its flow in closed form |
//! | [`semi_implicit`] | the cubic part of the cubic observer as a semi-implicit step, for gains that are not radial |
//! | [`varying_period`] | the sampled cubic observer at varying periods and with missed samples |
//! | [`cubic_sampled`] | the sampled-data cubic observer, stable at every step size |
//! | [`kalman`] | the continuous-discrete extended Kalman filter |
//! | [`unscented`] | the unscented Kalman filter in square-root form |
//! | [`interacting_models`] (feature `alloc`) | the interacting multiple model filter (IMM): several models, of which one holds at a time |
//! | [`particle`] (feature `alloc`) | the bootstrap particle filter |
//! | [`moving_horizon`] | the moving-horizon estimator, with bounds of the states |
//! | [`covariance_filter`] | the trait of filters with a covariance, measurement update and prediction apart |
//! | [`adapted`] (feature `alloc`) | filters whose noises depend on the estimate, and with bounds of their estimates |
//! | [`correlated`] (feature `alloc`) | filters of process and measurement noise that are correlated |
//! | [`delayed`] (feature `alloc`) | filters of measurements that arrive late |
//! | [`discrete_linear`] | the linear observer of a plant in discrete time |
//! | [`stationary_kalman`] | the stationary Kalman filter in filter form: the estimate uses the measurement of its sample |
//! | [`fixed_point`] | the linear observer in discrete time in fixed point, in integers |
//! | [`discrete_kalman`] | the Kalman filter of a plant in discrete time |
//! | [`nonlinear_luenberger`] | the copy of a nonlinear plant with a constant gain: Thau's, Lipschitz and LPV designs run as this |
//! | [`sampled_nonlinear`] | the copy of a plant stepped once per sample, with an output predicted between samples |
//! | [`mean_value`] | the mean-value-theorem observer, as printed and with output injection |
//! | [`kkl`] | Kazantzis-Kravaris-Luenberger observers: a stable linear extension and a left inverse |
//! | [`pebo`], [`kkl_peb`] | parameter-estimation-based observers, and [KKL+PEB] observers, which are both: folder `parameter_estimation` |
//! | [`filters`], [`estimator`] | parts of these two: filters; gradient, DREM, excitation |
//! | [`immersion_invariance`], [`pseudo_inverse`] | immersion-and-invariance observers |
//! | [`inter_sample`] | an observer in continuous time stepped once per sample, with an output predicted between samples |
//! | [`high_gain`] | chains of integrators with corrections alpha/r^i |
//! | [`cascade`] | [KKL+PEB] observers of a class of cascades |
//! | [`deviation`] | a linear observer of a nonlinear plant, in deviations from an operating point |
//! | [`proportional_integral`] | a disturbance estimated with the state |
//! | [`unknown_input`] | an estimate that does not depend on an unknown disturbance |
//! | [`functional`] | functions of the state alone, by fewer states |
//! | [`discrete_form`] | the equations of an observer in continuous time, in discrete time |
//! | [`feedthrough`] | the input in the outputs, `y - D u` in place of y |
//! | [`interval`] | bounds that enclose the state |
//! | [`sliding_mode`] | super-twisting observer and robust exact differentiator, with an implicit step |
//! | [`output_feedback`] | an observer with the feedback `u = r - K xhat` as one block |
//! | `static_size` (feature `alloc`) | designed observers with the sizes and the scalar of the target |
//! | `serialization` (feature `serde`) | observers in files: matrices by rows, read through the constructors |
//! | [`diagnosis`] | diagnosis of an observer at run time |
//! | [`numerical_kkl`] | `z' = D z + B y` with a tabulated left inverse of T, embedded or interpolated |
//!
//! Where an observer has an innovation it is `y~ = y - C xhat`, and the error is `e = x - xhat`, so that `y~ = C e`;
//! the files from [`kkl`] on have the paper's `e = xhat - x`, and say so.

#![no_std]
#![deny(missing_docs)]

#[cfg(feature = "alloc")]
pub mod adapted;
mod angles;
#[cfg(feature = "alloc")]
pub mod correlated;
pub mod covariance_filter;
pub mod cubic;
pub mod cubic_sampled;
#[cfg(feature = "alloc")]
pub mod delayed;
mod dense;
pub mod deviation;
pub mod diagnosis;
pub mod discrete_form;
pub mod discrete_kalman;
pub mod discrete_linear;
pub mod discrete_luenberger;
pub mod error;
#[cfg(feature = "alloc")]
mod exponential;
pub mod feedthrough;
pub mod fixed_point;
pub mod functional;
mod gaussian;
#[cfg(feature = "alloc")]
mod held;
pub mod high_gain;
pub mod inter_sample;
#[cfg(feature = "alloc")]
pub mod interacting_models;
pub mod interval;
pub mod kalman;
pub mod kkl;
pub mod linear;
mod matrix_name;
pub mod mean_value;
pub mod moving_horizon;
pub mod nonlinear_luenberger;
mod numbers;
pub mod numerical_kkl;
pub mod observer;
pub mod output_feedback;
mod parameter_estimation;
mod partial;
#[cfg(feature = "alloc")]
pub mod particle;
pub mod proportional_integral;
pub mod pseudo_inverse;
mod runge_kutta;
pub mod sampled_jumps;
pub mod sampled_nonlinear;
pub mod semi_implicit;
mod semidefinite;
#[cfg(feature = "serde")]
mod serialization;
pub mod sliding_mode;
#[cfg(feature = "alloc")]
pub mod static_size;
pub mod stationary_kalman;
pub mod transition;
mod triangular;
mod unit_vectors;
pub mod unknown_input;
pub mod unscented;
pub mod varying_period;

#[cfg(feature = "alloc")]
pub use adapted::{AdaptableFilter, AdaptedFilter, NoisesAlong};
#[cfg(feature = "alloc")]
pub use correlated::{CorrelatedFilter, DecorrelatedPlant};
pub use covariance_filter::CovarianceFilter;
pub use cubic::{CubicObserver, StaticCubicObserver};
pub use cubic_sampled::{SampledCubicGains, SampledCubicObserver, StaticSampledCubicObserver};
#[cfg(feature = "alloc")]
pub use delayed::DelayedFilter;
pub use deviation::{DeviationObserver, StaticDeviationObserver};
pub use diagnosis::{Diagnose, Diagnosis};
pub use discrete_form::{DiscreteForm, StaticDiscreteForm};
pub use discrete_kalman::{KalmanFilter, KalmanModel, StaticKalmanFilter};
pub use discrete_linear::{DiscreteLinearObserver, StaticDiscreteLinearObserver};
pub use discrete_luenberger::{DiscreteNonlinearObserver, StaticDiscreteNonlinearObserver};
pub use error::{ObserverError, Point};
pub use feedthrough::FeedthroughObserver;
pub use fixed_point::{
    FixedPointFormat, FixedPointFormats, FixedPointGains, FixedPointObserver, FixedPointState, StaticFixedPointObserver,
};
pub use functional::{FunctionalObserver, StaticFunctionalObserver};
pub use high_gain::{HighGainMap, HighGainObserver, StaticHighGainObserver};
pub use immersion_invariance::{Immersion, ImmersionInvarianceObserver};
pub use inter_sample::{InterSampleObserver, StaticInterSampleObserver};
#[cfg(feature = "alloc")]
pub use interacting_models::InteractingMultipleModel;
pub use interval::{
    ComparisonSystem, IntervalObserver, SampledIntervalGains, SampledIntervalObserver, StaticIntervalObserver,
    StaticSampledIntervalObserver,
};
pub use kalman::{ExtendedKalmanFilter, GaussianEstimate, Innovation, NoiseModel, StaticExtendedKalmanFilter};
pub use kkl::{KklMap, KklObserver, LeftInverse, LinearInverse, LinearKkl};
pub use kkl_peb::{FilterMemory, KklPebObserver, Reset};
pub use linear::{LinearObserver, StaticLinearObserver};
pub use luenberger_plants::{Differentiable, Dimensions, LinearPlant, Plant, Shape, binary32, straight_line_plant};
pub use matrix_name::MatrixName;
pub use mean_value::{
    Beta, EstimateAndError, Integral, MappedObserver, Mean, MeanJacobian, MeanValueObserver, StaticMappedObserver,
    StaticMeanValueObserver,
};
pub use moving_horizon::{Horizon, MovingHorizonEstimator, StaticMovingHorizonEstimator};
pub use nonlinear_luenberger::{NonlinearLuenbergerObserver, StaticNonlinearLuenbergerObserver};
#[cfg(feature = "alloc")]
pub use numbers::SizedPlant;
pub use observer::{ContinuousDiscreteObserver, Observer, ObserverDimensions, SampledObserver};
pub use output_feedback::OutputFeedback;
pub use parameter_estimation::{cascade, estimator, filters, immersion_invariance, kkl_peb, pebo};
#[cfg(feature = "alloc")]
pub use particle::{ParticleFilter, ParticleNoise};
pub use pebo::{PeboObserver, Regression};
pub use proportional_integral::{ProportionalIntegralObserver, StaticProportionalIntegralObserver};
pub use sampled_jumps::SampledJumps;
pub use sampled_nonlinear::{SampledNonlinearObserver, StaticSampledNonlinearObserver};
pub use sliding_mode::{SlidingModeObserver, StaticSlidingModeObserver};
pub use stationary_kalman::{StaticStationaryKalmanFilter, StationaryKalmanFilter};
pub use transition::Prediction;
pub use unit_vectors::tangential;
pub use unknown_input::{StaticUnknownInputObserver, UnknownInputObserver};
pub use unscented::{SigmaPoints, SquareRootEstimate, StaticUnscentedKalmanFilter, UnscentedKalmanFilter};
pub use varying_period::{
    StaticVaryingPeriodObserver, StaticVaryingPeriodStep, VaryingPeriodObserver, VaryingPeriodStep,
};

/// nalgebra, in the version of the columns and matrices of this crate.
pub use nalgebra;

#[doc(hidden)]
pub mod internals {
    //! For the tests of this crate, no part of its interface.

    pub use crate::dense::{Factor, times, times_transpose};
    pub use crate::mean_value::quadrature::GAUSS_LEGENDRE_8;
    pub use crate::semi_implicit::eliminate;
    pub use crate::triangular::{Joint, add, semidefinite_factor, subtract};
}

/// The example of `README.md`, compiled and run with the documentation's tests.
#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct Readme;
