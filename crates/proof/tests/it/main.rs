//! One test binary, a module a subject.

mod adversaries;
mod certificate_files;
mod definiteness;
mod deployed;
mod elementary;
mod equations;
mod hostile_files;
mod kkl;
mod left_inverses;
mod sectors;
mod statements;
mod stress;
mod varying_periods;
