//! Section V.C: the Cuk converter, its observers of Table I and Fig. 2.

use crate::claim::Claim;
use crate::paper::Drawing;

pub(super) fn claims() -> Vec<Claim> {
    Vec::new()
}

pub(super) fn figures() -> Vec<Drawing> {
    Vec::new()
}
