//! One test binary, a module a subject.

mod arguments;
mod kkl_observers;
mod kkl_prop6_data;
mod mvt_data;
mod run;
mod verdicts;
