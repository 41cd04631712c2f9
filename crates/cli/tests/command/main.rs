//! The command from end to end: the built binary, its streams and its exit code.

mod from_matlab;
mod manners;
mod matrix;
mod mistakes;
mod pages;
mod sdp;
mod study;
mod terminal;
