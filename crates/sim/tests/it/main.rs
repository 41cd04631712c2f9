//! One test binary, a module a subject.

mod compare;
mod feedthrough;
mod gramian;
mod replay;
mod runs;
mod scores;
