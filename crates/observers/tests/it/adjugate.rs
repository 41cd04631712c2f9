//! The adjugate against cofactors, and of singular matrices.

use luenberger_observers::estimator::adjugate::adjugate;
use nalgebra::{DMatrix, Matrix3, SMatrix};
use proptest::prelude::*;

/// The cofactors by their definition, as an independent answer.
fn by_minors(a: &Matrix3<f64>) -> Matrix3<f64> {
    Matrix3::from_fn(|i, j| {
        let sign = if (i + j) % 2 == 0 { 1.0 } else { -1.0 };
        sign * a.remove_row(j).remove_column(i).determinant()
    })
}

fn check(a: &DMatrix<f64>) -> Result<(), TestCaseError> {
    let (answer, n) = (adjugate(a), a.nrows());
    let deviation = a * &answer.adjugate - DMatrix::identity(n, n) * answer.determinant;
    // Backward stable elimination with complete pivoting (growth below 2 at these orders), and n products of n
    // factors.
    let size = answer.adjugate.norm().max((1..n).fold(1.0, |power, _| power * a.norm()));
    let bound = 64.0 * (n * n * n) as f64 * f64::EPSILON * a.norm() * size;
    prop_assert!(deviation.amax() <= bound, "{deviation} {bound:e}");
    let determinant = a.determinant();
    prop_assert!((answer.determinant - determinant).abs() <= bound, "{determinant}");
    Ok(())
}

proptest! {
    #[test]
    fn adjugate_times_matrix_is_the_determinant(entries in prop::array::uniform25(-3.0..3.0f64)) {
        check(&DMatrix::from_column_slice(5, 5, &entries))?;
        check(&DMatrix::from_column_slice(2, 2, &entries[..4]))?;
        check(&DMatrix::from_element(1, 1, entries[0]))?;
    }

    /// Rank 2 and rank 1 of order 3: the adjugate is a matrix of rank 1, and 0, up to rounding of the entries'
    /// products.
    #[test]
    fn singular_matrices_have_an_adjugate(v in prop::array::uniform6(-3i32..=3), w in prop::array::uniform6(-3i32..=3)) {
        let rows = SMatrix::<f64, 3, 2>::from_fn(|i, j| f64::from(v[i + 3 * j]));
        let columns = SMatrix::<f64, 2, 3>::from_fn(|i, j| f64::from(w[i + 2 * j]));
        let a = rows * columns;
        let answer = adjugate(&a);
        // Cofactors of integers below 18 in magnitude are exact in by_minors.
        let rounding = 256.0 * f64::EPSILON * a.norm().powi(2);
        prop_assert!((answer.adjugate - by_minors(&a)).amax() <= rounding, "{}", answer.adjugate - by_minors(&a));
        prop_assert!(answer.determinant.abs() <= rounding * a.norm());
    }
}

#[test]
fn the_extremes_are_what_they_are() {
    assert_eq!(adjugate(&SMatrix::<f64, 0, 0>::zeros()).determinant, 1.0);
    assert_eq!(adjugate(&SMatrix::<f64, 1, 1>::zeros()).adjugate[0], 1.0);
    assert_eq!(adjugate(&Matrix3::<f64>::zeros()).adjugate, Matrix3::zeros());
    assert!(adjugate(&SMatrix::<f64, 1, 1>::new(f64::NAN)).determinant.is_nan());
    // Units that differ by 24 decades: elimination is by ratios.
    let a = SMatrix::<f64, 2, 2>::new(1e-12, 0.0, 0.0, 1e12);
    assert_eq!(adjugate(&a).adjugate, SMatrix::<f64, 2, 2>::new(1e12, 0.0, 0.0, 1e-12));
}
