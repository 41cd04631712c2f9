//! One test binary, a module a subject.

mod angles;
mod between_rows;
mod chi_squared;
mod compare;
mod consistency;
mod defect;
mod dense;
mod disturbance;
mod events;
mod exponential;
mod feedthrough;
mod gramian;
mod likelihood;
mod noise;
mod on_slices;
mod radau;
mod replay;
mod replay_grid;
mod replay_missing;
mod runs;
mod sample_times;
mod scores;
mod sensors;
mod smoother;
mod work;
