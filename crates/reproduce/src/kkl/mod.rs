//! Paper 3: KKL, PEB, [KKL+PEB] and I&I observers.
//!
//! The corrected theory is in `docs/theory-kkl.md` of the repository.

mod chirp;
pub mod converter;
pub mod cuk;
pub mod driven_cascade;
mod duffing;
pub mod exponential_cascade;
mod extensions;
mod findings;
mod prop5;
pub mod prop6;
mod prop7;
mod propositions;
mod remarks;
mod safety_nets;

use crate::paper::Paper;

/// The paper.
pub(crate) fn paper() -> Paper {
    Paper {
        key: "kkl",
        title: "On state observers for nonlinear systems: a new design and a unifying framework",
        short: "KKL, PEB and I&I observers",
        citation: "B. Yi, R. Ortega and W. Zhang, IEEE Transactions on Automatic Control, 2018",
        claims: [
            propositions::claims(),
            remarks::claims(),
            safety_nets::claims(),
            prop5::claims(),
            prop6::claims(),
            prop7::claims(),
            extensions::claims(),
            converter::claims(),
            duffing::claims(),
        ]
        .concat(),
        figures: [prop6::figures(), prop7::figures(), converter::figures(), duffing::figures()].concat(),
        datasets: Vec::new(),
        live: Vec::new(),
        kernel: Vec::new(),
        findings: findings::findings(),
    }
}
