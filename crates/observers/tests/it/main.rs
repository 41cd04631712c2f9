//! One test binary, a module a subject; each says which features it needs.

#[cfg(feature = "alloc")]
mod adapted;
#[cfg(feature = "alloc")]
mod adjugate;
mod aliases;
mod angles;
#[cfg(feature = "alloc")]
mod at_run_time;
#[cfg(feature = "alloc")]
mod bad_samples;
mod by_hand;
mod continuous;
#[cfg(feature = "alloc")]
mod correlated;
#[cfg(feature = "alloc")]
mod delayed;
#[cfg(feature = "alloc")]
mod dense;
mod discrete_kalman;
mod estimators;
#[cfg(feature = "alloc")]
mod fixed_point;
mod immersion_invariance;
#[cfg(feature = "alloc")]
mod interacting_models;
#[cfg(feature = "alloc")]
mod iterated;
mod kalman;
mod kkl;
mod mean_value;
mod moving_horizon;
mod numerical_kkl;
#[cfg(all(feature = "alloc", feature = "dual"))]
mod on_target;
#[cfg(feature = "alloc")]
mod partial;
#[cfg(feature = "alloc")]
mod particle;
mod pendulum;
#[cfg(feature = "alloc")]
mod prediction;
mod pseudo_inverse;
mod quadrature;
mod reset;
mod sampled;
mod sampled_jumps;
mod sampled_nonlinear;
mod semi_implicit;
#[cfg(feature = "serde")]
mod serialization;
#[cfg(feature = "alloc")]
mod static_size;
mod triangular;
#[cfg(feature = "alloc")]
mod unit_vectors;
mod unscented;
