//! One test binary, a module a subject.

mod families;
mod joint_design;
mod known;
mod sdpa;
mod sdpa_families;
mod sdpa_reader;
mod solvers;
