//! Paper 2: a nonlinear observer by the mean value theorem.
//!
//! The corrected theory, with proofs, is in `docs/theory-mvt.md` of the repository.

mod eta;
mod example1;
mod example2;
mod figures;
mod findings;
mod output_injection;
mod peers;
mod runs;
mod text;
mod theorem1;

use crate::paper::{Drawing, Paper};

/// The paper.
pub(crate) fn paper() -> Paper {
    Paper {
        key: "mvt",
        title: "A nonlinear observer by the mean value theorem and lsqnonlin",
        short: "the mean-value-theorem observer",
        citation: "R. Ben Messaoud and S. Hajji, WSEAS Transactions on Systems 17, 2018",
        claims: [
            theorem1::claims(),
            eta::claims(),
            example1::claims(),
            example2::claims(),
            peers::claims(),
            output_injection::claims(),
            text::claims(),
        ]
        .concat(),
        figures: [
            example1::figures(),
            example2::figures(),
            vec![Drawing { id: "mvt-fig9", draw: peers::fig9 }],
            eta::figures(),
            peers::figures(),
        ]
        .concat(),
        datasets: runs::datasets(),
        live: Vec::new(),
        kernel: Vec::new(),
        findings: findings::findings(),
    }
}
