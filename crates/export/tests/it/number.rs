//! Numbers as literals.

use luenberger_export::Scalar;
use luenberger_export::number::{c, rust};

#[test]
fn literals_are_exact() {
    assert_eq!(c(0.1, Scalar::Binary64), "0x1.999999999999ap-4");
    assert_eq!(c(0.1, Scalar::Binary32), "0x1.99999ap-4f");
    assert_eq!(c(-1.0, Scalar::Binary64), "-0x1p+0");
    assert_eq!(c(5e-324, Scalar::Binary64), "0x0.0000000000001p-1022");
    assert_eq!(c(-0.0, Scalar::Binary64), "-0.0");
    assert_eq!(rust(0.1, Scalar::Binary64), "0.1");
}
