//! One test binary, a module a subject.

mod adversaries;
mod conversion;
mod decomposition;
mod discretize;
mod distance;
mod equations;
mod exact_families;
mod factored;
mod functional_observer;
mod ill_conditioned;
mod observability;
mod placement;
mod prototype;
mod riccati;
mod riccati_families;
mod riccati_generalized;
mod schur;
mod slicot;
mod small_matrices;
mod static_matrices;
mod structured_placement;
mod three_routes;
mod zeros;
