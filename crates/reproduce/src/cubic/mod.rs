//! Paper 1: Luenberger-type cubic observers.
//!
//! What is true of the paper's theory and what is not, with proofs, stands in `docs/theory-cubic.md` of the repository.

mod example1;
mod example2;
mod example3;
mod findings;
mod random;
mod robustness;
mod theorems;

use crate::paper::Paper;

/// The paper.
pub(crate) fn paper() -> Paper {
    Paper {
        key: "cubic",
        title: "Luenberger-type cubic observers for state estimation of linear systems",
        citation: "M. M. Share Pasand",
        claims: [example1::claims(), example2::claims(), example3::claims(), theorems::claims(), robustness::claims()]
            .concat(),
        figures: [example1::figures(), example2::figures(), example3::figures()].concat(),
        findings: findings::findings(),
    }
}
