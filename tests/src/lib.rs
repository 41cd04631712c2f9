//! Tests across crates: see the integration tests beside this file. [`falsify`] tries to contradict the theorems of
//! certificates, [`words`] the sentences of designs.
#![allow(clippy::missing_panics_doc, clippy::return_self_not_must_use, reason = "for the tests beside it only")]

pub mod falsify;
pub mod kkl_maps;
pub mod words;

use luenberger_linalg::{lyapunov, stein};
use luenberger_lmi::proof_matrix;
use luenberger_proof::Matrix;
use luenberger_proof::certificate::{CertificateFile, Equation, SolutionWithin};
use nalgebra::DMatrix;

/// The certificate that the exact solution of an equation with these matrices lies in intervals, from the solution in
/// floating point; none where that is not found or not proved.
pub fn solution_certificate(equation: Equation, a: &DMatrix<f64>, q: &DMatrix<f64>) -> Option<CertificateFile> {
    let solve = |q: &DMatrix<f64>| match equation {
        Equation::Lyapunov => lyapunov(a, q).map(|found| found.p).ok(),
        Equation::Stein => stein(a, q).map(|found| found.p).ok(),
    };
    let (p, w) = (solve(q)?, solve(&DMatrix::identity(a.nrows(), a.nrows()))?);
    let points = |m: &DMatrix<f64>| Matrix::embed(&proof_matrix(m), "a matrix of the equation").ok();
    let (p, w) = (proof_matrix(&p), proof_matrix(&w));
    let theorem = SolutionWithin::derive(equation, &points(a)?, &points(q)?, &[p], Some(&w)).ok()?;
    CertificateFile::prove("an equation", theorem).ok()
}

/// The examples of the README and of `docs/`, compiled and run with the documentation's tests.
#[cfg(doctest)]
mod pages {
    #[doc = include_str!("../../README.md")]
    struct Readme;
    #[doc = include_str!("../../docs/adding-an-observer.md")]
    struct AddingAnObserver;
    #[doc = include_str!("../../docs/from-matlab.md")]
    struct FromMatlab;
    #[doc = include_str!("../../docs/reduced-order.md")]
    struct ReducedOrder;
}
