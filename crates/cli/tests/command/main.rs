//! The command from end to end: the built binary, its streams and its exit code.

mod manners;
mod matrix;
mod mistakes;
mod sdp;
mod terminal;
