//! Matrices from lists of entries.

use luenberger_proof::{Matrix, ProofError};

#[test]
fn column_major_is_the_transpose_of_row_major() {
    let entries = [1.0, 2.0, 3.0, 4.0, 5.0, 6.0];
    let by_columns = Matrix::from_column_major(2, 3, &entries).expect("6 entries");
    assert_eq!(by_columns, Matrix::from_rows([[1.0, 3.0, 5.0], [2.0, 4.0, 6.0]]));
    assert_eq!(by_columns.transpose(), Matrix::from_row_major(3, 2, entries.to_vec()).expect("6 entries"));
}

#[test]
fn a_list_of_the_wrong_length_is_an_error() {
    assert!(matches!(
        Matrix::from_column_major(2, 2, &[1.0]),
        Err(ProofError::DimensionMismatch { expected: (2, 2), found: (1, 1), .. })
    ));
    assert!(Matrix::from_row_major(usize::MAX, 2, vec![1.0]).is_err());
    assert_eq!(Matrix::from_rows([[1.0, 2.0]]).get(0, 2), None);
}
