//! The pseudo-inverse by the conditions of Penrose.

use luenberger_observers::pseudo_inverse::pseudo_inverse;
use nalgebra::{DMatrix, SMatrix};
use proptest::prelude::*;

/// The four conditions of Penrose, each to rounding amplified by the condition number that was kept.
fn check(a: &DMatrix<f64>, rank: usize) -> Result<(), TestCaseError> {
    let answer = pseudo_inverse(a);
    prop_assert_eq!(answer.rank(), rank, "{}", answer.singular_values);
    let x = &answer.inverse;
    let condition = a.norm() * x.norm();
    let rounding = 64.0 * a.nrows().max(a.ncols()) as f64 * f64::EPSILON * condition;
    let (ax, xa) = (a * x, x * a);
    prop_assert!((&ax * a - a).norm() <= rounding * a.norm());
    prop_assert!((&xa * x - x).norm() <= rounding * x.norm() * condition);
    prop_assert!((&ax - ax.transpose()).norm() <= rounding * condition);
    prop_assert!((&xa - xa.transpose()).norm() <= rounding * condition);
    Ok(())
}

proptest! {
    #[test]
    fn the_conditions_of_penrose_hold(
        entries in prop::array::uniform15(-1.0..1.0f64),
        v in prop::array::uniform3(-1.0..1.0f64),
        w in prop::array::uniform5(0.5..1.0f64),
    ) {
        let wide = DMatrix::from_column_slice(3, 5, &entries) + DMatrix::identity(3, 5) * 4.0;
        check(&wide, 3)?;
        check(&wide.transpose(), 3)?;
        // Rank 2 of 3 rows: the last is a combination of the others.
        let mut deficient = wide.clone();
        deficient.set_row(2, &(wide.row(0) * v[0] + wide.row(1) * v[1]));
        check(&deficient, 2)?;
        check(&DMatrix::from_row_slice(1, 5, &w), 1)?;
    }
}

#[test]
fn nothing_is_divided_by_zero() {
    let zero = pseudo_inverse(&SMatrix::<f64, 2, 3>::zeros());
    assert_eq!((zero.rank(), zero.inverse), (0, SMatrix::<f64, 3, 2>::zeros()));
    assert_eq!(pseudo_inverse(&SMatrix::<f64, 2, 2>::new(f64::NAN, 0.0, 0.0, 1.0)).rank(), 0);
    assert!((pseudo_inverse(&SMatrix::<f64, 1, 1>::new(1e-300)).inverse[0] / 1e300 - 1.0).abs() <= 4.0 * f64::EPSILON);
    // 1/5e-324 is infinite.
    assert_eq!(pseudo_inverse(&SMatrix::<f64, 2, 2>::new(5e-324, 0.0, 0.0, 0.0)).rank(), 0);
    assert_eq!(pseudo_inverse(&SMatrix::<f64, 0, 2>::zeros()).rank(), 0);
}
