//! One test binary, a module a subject.

mod c_math;
mod compiled;
mod emitted;
mod fmu;
mod fuzz;
