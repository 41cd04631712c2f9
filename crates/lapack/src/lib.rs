//! The BLAS and LAPACK symbols that an SDP solver links, in pure Rust on faer
