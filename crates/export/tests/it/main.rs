//! One test binary, a module a subject.

mod by_hand;
mod c_math;
mod compiled;
mod emitted;
mod fixed_point;
mod fmu;
mod fuzz;
mod kernels;
mod kkl;
mod layouts;
mod loops;
mod moving_horizon;
mod names;
mod number;
mod operations;
mod quoted;
mod rows;
mod texts;
