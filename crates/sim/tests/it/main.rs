//! One test binary, a module a subject.

mod compare;
mod disturbance;
mod ensemble;
mod exponential;
mod feedthrough;
mod gramian;
mod on_slices;
mod replay;
mod replay_missing;
mod runs;
mod sample_times;
mod scores;
mod sensors;
mod smoother;
