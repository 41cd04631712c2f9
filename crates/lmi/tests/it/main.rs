//! One test binary, a module a subject.

mod coefficients;
mod equations;
mod expression;
mod families;
mod joint_design;
mod known;
mod products;
mod rational;
mod schur_complement;
mod sdpa;
mod sdpa_centre;
mod sdpa_face;
mod sdpa_families;
mod sdpa_reader;
mod sequential;
mod solvers;
mod variable;
