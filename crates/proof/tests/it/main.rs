//! One test binary, a module a subject.

mod adversaries;
mod certificate_files;
mod cholesky;
mod definiteness;
mod deployed;
mod deployed_cubic;
mod elementary;
mod equations;
mod exact;
mod exponential;
mod gram;
mod hidden;
mod hostile_files;
mod interval;
mod jacobians;
mod kkl;
mod label;
mod left_inverses;
mod matrix;
mod number;
mod sectors;
mod sentences;
mod statements;
mod stress;
mod varying_periods;
mod wording;
