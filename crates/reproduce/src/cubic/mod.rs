//! Paper 1: Luenberger-type cubic observers.
//!
//! The corrected theory, with proofs, is in `docs/theory-cubic.md` of the repository.

mod example1;
mod example2;
mod example3;
mod findings;
mod kalman;
mod lmis;
mod noise;
mod random;
mod remarks;
mod robustness;
mod theorems;

use luenberger_design::Certificate;
use luenberger_live::{ObserverKind, StoredObserver};

use crate::claim::CheckError;
use crate::paper::Paper;

/// The limitation of every robust margin of this paper; printed wherever one is reported.
const FORCING: &str = "This is a margin of the error dynamics in the paper's proof. An observer that runs the nominal A on such a plant has the \
                       forcing εx in its error besides: it is input-to-state stable, and its error tends to 0 only if x does.";

/// The paper.
pub(crate) fn paper() -> Paper {
    Paper {
        key: "cubic",
        title: "Luenberger-type cubic observers for state estimation of linear systems",
        short: "the cubic observer",
        citation: "M. M. Share Pasand",
        claims: [
            example1::claims(),
            example2::claims(),
            example3::claims(),
            theorems::claims(),
            remarks::claims(),
            robustness::claims(),
            lmis::claims(),
            noise::claims(),
            kalman::claims(),
        ]
        .concat(),
        figures: [example1::figures(), example2::figures(), example3::figures(), noise::figures()].concat(),
        datasets: Vec::new(),
        live: vec![example1::live(), example2::live(), example3::live()],
        kernel: vec![theorems::kernel(), example3::kernel(), robustness::kernel()],
        findings: findings::findings(),
    }
}

/// An observer of the page with its certificate files, from the estimate 0.
fn certified(
    name: &str,
    kind: ObserverKind,
    certificate: &Certificate,
    states: usize,
) -> Result<StoredObserver, CheckError> {
    let files = certificate.theorems().iter().map(|theorem| Ok(theorem.file(name)?.to_json()));
    let certificates = files.collect::<Result<_, CheckError>>()?;
    Ok(StoredObserver { certificates: Some(certificates), ..StoredObserver::new(name, kind, &vec![0.0; states]) })
}
