//! Certificate file of a semidefinite program: the program, and the points that prove its bounds or the ray that proves
//! infeasibility.
//!
//! A decimal of the SDPA file that is not representable in binary64 is stored as an enclosing interval, so that the
//! proof holds for the decimal.

use luenberger_proof::certificate::{CertificateFile, SemidefiniteEvidence, SemidefiniteProgram};
use luenberger_proof::semidefinite::Program;

use super::{Outcome, Status};
use crate::error::LmiError;

impl Outcome {
    /// The certificate file for the verified result of `program`, the one that was [solved](super::solve): both bounds,
    /// the finite one, or infeasibility.
    ///
    /// Verification needs neither this crate nor a solver, and costs as much as one verification of the final points.
    ///
    /// ```
    /// use luenberger_proof::certificate::verify;
    /// // minimise x subject to [[x, 1], [1, x]] >= 0: the optimum is 1.
    /// let program = luenberger_lmi::sdpa::read("1\n1\n2\n1.0\n0 1 1 2 -1.0\n1 1 1 1 1.0\n1 1 2 2 1.0\n".as_bytes())?;
    /// let found = luenberger_lmi::sdpa::solve(&program, &Default::default());
    /// let file = found.certificate_file(&program, "the larger eigenvalue of a swap")?.to_json();
    /// let proved = verify(file.as_bytes())?;
    /// assert!(proved.facts[0].inequality.starts_with("the optimum >= ") && proved.facts.len() == 2);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    /// # Errors
    /// [`LmiError::CertificateFile`] if nothing is verified, for another program, and for one that exceeds the limits
    /// of a file: blocks of order 512, 8 MiB of text.
    pub fn certificate_file(&self, program: &Program, title: &str) -> Result<CertificateFile, LmiError> {
        let evidence = match self.status {
            Status::PrimalInfeasible => SemidefiniteEvidence::PrimalInfeasible(self.y.clone()),
            Status::DualInfeasible => SemidefiniteEvidence::DualInfeasible(self.x.clone()),
            Status::Bounds | Status::Undecided => SemidefiniteEvidence::Bounds {
                lower: self.lower.is_finite().then(|| (self.lower, self.y.clone())),
                upper: self.upper.is_finite().then(|| (self.upper, self.x.clone())),
            },
        };
        let theorem = SemidefiniteProgram { program: program.clone(), evidence };
        CertificateFile::prove(title, theorem).map_err(|rejection| LmiError::CertificateFile(Box::new(rejection)))
    }
}
