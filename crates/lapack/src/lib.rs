//! The BLAS and LAPACK symbols that an SDP solver links, in pure Rust on faer.
//!
//! A Rust crate that calls BLAS through `blas-sys` and LAPACK through `lapack-sys` leaves `dgemm_`, `dpotrf_` and so on
//! for the linker to find. This crate defines them, so that a machine with cargo and a C linker is enough: no Fortran,
//! no system library. Depend on it and write, once in the crate that is linked,
//!
//! ```
//! use luenberger_lapack as _;
//! ```
//!
//! Defined, each for `s` (f32) and `d` (f64): `gemm gemv symv syrk syr2k` of BLAS, `potrf potrs syevr gesdd gesvd gesv`
//! of LAPACK. A program that needs another one fails to link and names it; a program that links a second BLAS has each
//! symbol twice.
//!
//! Conventions are the reference implementation's: matrices column by column with a leading dimension, `uplo` names the
//! only triangle that is read or written, `beta = 0` does not read the output, a workspace query (`lwork = -1`) answers
//! in `work[0]`. The differences: workspace is taken from the heap and the caller's is left alone, the reported size is
//! the documented minimum; `syevr`, `gesdd` and `gesvd` of a matrix with NaN or infinity return at once with `info` not
//! 0; an impossible argument makes a BLAS function return without touching anything, where the reference stops the
//! program.
//!
//! Layout: the kernels (`blas`, `cholesky`, `eigen`, `svd`, `lu`) are safe Rust on faer's views; all `unsafe` of
//! turning pointers into views is in `abi` and in the exported functions of [`symbols`].
#![deny(missing_docs)]
#![allow(unsafe_code, reason = "a C ABI takes raw pointers")]

mod abi;
mod blas;
mod cholesky;
mod eigen;
mod element;
mod lu;
mod svd;
pub mod symbols;

/// The example of `README.md`, compiled and run with the documentation's tests.
#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct Readme;
