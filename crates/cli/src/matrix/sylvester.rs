//! `luenberger sylv`, with the sign of python-control's `lyap(A, B, Q)`.

use super::{from, lyapunov};
use crate::answer::Answer;
use crate::failure::Failure;
use crate::input::given::{Given, Sylvester};
use crate::input::json;
use luenberger_linalg::LinalgError;

/// `A X + X B + Q = 0`.
pub(crate) fn sylv(source: &Given) -> Result<Answer, Failure> {
    let [a, b, q] = json::matrices(source, Sylvester::KEYS)?;
    let found = luenberger_linalg::sylvester(&a, &b, &-q).map_err(|error| {
        from(source)(match error {
            // The library's right-hand side is called c.
            LinalgError::DimensionMismatch { expected, found, .. } => {
                LinalgError::DimensionMismatch { what: "Q", expected, found }
            }
            other => other,
        })
    })?;
    lyapunov::solution("A X + X B + Q = 0", &found.x, found.residual, found.condition, found.forward_error())
}
