//! Design, certify, simulate and deploy state observers
