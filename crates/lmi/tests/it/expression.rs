//! Faults of expressions: the first one is kept, and named.

use luenberger_lmi::{Fault, Problem, Variable, block, he, zeros};
use nalgebra::DMatrix;

fn unknown(rows: usize, columns: usize) -> Variable {
    Problem::new().rectangular("X", rows, columns)
}

#[test]
fn the_first_fault_survives_what_is_built_on_it() {
    let x = unknown(2, 3);
    let e = he(&DMatrix::identity(3, 3) * &x + DMatrix::identity(3, 3));
    let expected = Fault::ShapeMismatch { operation: "product", left: (3, 3), right: (2, 3) };
    assert_eq!(e.fault(), Some(expected));
}

#[test]
fn a_number_that_is_not_finite_is_remembered() {
    let x = unknown(2, 2);
    assert!(matches!((f64::NAN * &x).fault(), Some(Fault::NotFinite { .. })));
    let m = DMatrix::from_row_slice(2, 2, &[0.0, 0.0, f64::INFINITY, 0.0]);
    assert_eq!((&m * &x).fault(), Some(Fault::NotFinite { row: 1, column: 0, value: f64::INFINITY }));
}

#[test]
fn a_scalar_unknown_scales_a_matrix_of_any_shape() {
    let gamma = Problem::new().scalar("gamma");
    let m = DMatrix::<f64>::zeros(3, 2);
    assert_eq!((&gamma * &m).shape(), (3, 2));
    assert_eq!((&m * &gamma).shape(), (3, 2));
    assert_eq!(gamma.identity(4).shape(), (4, 4));
}

#[test]
fn blocks_of_different_heights_are_a_fault() {
    let x = unknown(2, 2);
    let e = block![[&x, zeros(3, 1)]];
    assert!(matches!(e.fault(), Some(Fault::ShapeMismatch { operation: "row of blocks", .. })));
    let e = block![[&x], [zeros(1, 1)]];
    assert!(matches!(e.fault(), Some(Fault::ShapeMismatch { operation: "column of blocks", .. })));
}
