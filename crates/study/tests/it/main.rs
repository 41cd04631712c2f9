//! One test binary, a module a subject.

mod battery;
mod blocks;
mod choices;
mod discrete_time;
mod feedthrough;
mod folder;
mod gain_limits;
mod high_gain;
mod limits;
mod log;
mod maps;
mod messages;
mod mistakes;
mod operating_point;
mod plant;
mod printed_mean_value;
mod report_in_browser;
mod scores;
mod sensors;
mod signal;
mod solver;
mod sweep;
mod table;
mod templates;
mod trajectories;
mod truth;
