//! One test binary, a module a subject.

mod base85;
mod figures;
mod npz;
mod packed;
mod report;
mod stroke;
mod style;
mod table;
mod thinned;
mod ticks;
