//! One test binary, a module a subject.

mod arguments;
mod converter;
mod kkl_observers;
mod kkl_prop6_data;
mod lmis;
mod mvt_data;
mod readings;
mod run;
mod values;
mod verdicts;
