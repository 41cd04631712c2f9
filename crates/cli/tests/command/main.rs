//! End-to-end tests of the built binary: streams and exit codes.

mod examples;
mod export;
mod file_messages;
mod from_matlab;
mod limits;
mod manners;
mod matrix;
mod messages;
mod mistakes;
mod pages;
mod results;
mod sdp;
mod stream;
mod study;
mod sweep;
mod terminal;
