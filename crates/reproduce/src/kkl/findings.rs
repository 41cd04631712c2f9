//! The errata: what does not hold as printed, each with the claims that show it.

use crate::paper::Finding;

pub(super) fn findings() -> Vec<Finding> {
    converter()
}

/// Section V.C.
fn converter() -> Vec<Finding> {
    Vec::new()
}
