//! One test binary, a module a subject.

mod c_math;
mod compiled;
mod fmu;
mod fuzz;
