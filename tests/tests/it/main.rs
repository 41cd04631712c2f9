//! One test binary, a module a subject.

mod bad_input;
mod certificates;
mod cuk_table_1;
mod examples;
mod falsify;
mod generators;
mod glossary;
mod golden_trajectories;
mod moving_horizon;
mod numerical_kkl;
mod pages;
mod polytopes;
mod second_checker;
mod stiff_starts;
mod study_converter;
mod theorems_cubic;
mod theorems_filters;
mod theorems_input_to_state;
mod theorems_interval;
mod theorems_kkl;
mod theorems_kkl_bound;
mod theorems_kkl_converter;
mod theorems_mvt;
mod theorems_sampled;
mod theorems_sliding_mode;
mod theorems_uncertain;
