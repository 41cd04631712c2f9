//! One test binary, a module a subject.

mod folder;
mod limits;
mod mistakes;
mod plant;
mod report_in_browser;
mod signal;
mod solver;
mod table;
mod templates;
