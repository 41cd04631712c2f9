//! One test binary, a module a subject.

#[macro_use]
mod plants;

mod bad_input;
mod cost;
mod deployed;
mod designs;
mod discrete;
mod display;
mod enclosure;
mod extrapolation;
mod feedthrough;
mod gain_options;
mod interpolation;
mod jets;
mod kalman_noise;
mod kkl;
mod kkl_adversary;
mod lipschitz;
mod low_rank;
mod lpv;
mod lpv_discrete;
mod mean_value;
mod nonlinear_observability;
mod norm_filter;
mod numerical_kkl;
mod numerical_kkl_choice;
mod numerical_kkl_held;
mod operating_point;
mod optimal_cubic;
mod paths;
mod positive_real;
mod recovery;
mod refusals;
mod regression;
mod symbolic_polynomial;
