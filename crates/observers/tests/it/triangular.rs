//! Factors of covariances, changed by one column at a time.

use luenberger_observers::internals::{Joint, add, semidefinite_factor, subtract};
use nalgebra::{Matrix1, Matrix2, Matrix3, Matrix4, Vector1, Vector2, Vector3};
use proptest::prelude::*;

#[test]
fn columns_are_added_and_taken_away() {
    let p = Matrix3::new(4.0, 1.0, 0.5, 1.0, 3.0, -0.2, 0.5, -0.2, 2.0);
    let (before, v) = (semidefinite_factor(&p), Vector3::new(0.3, -1.2, 0.7));
    let mut s = before;
    add(&mut s, &mut v.clone());
    assert!((s * s.transpose() - p - v * v.transpose()).amax() <= 8.0 * f64::EPSILON);
    assert!(subtract(&mut s, &mut v.clone()));
    assert!((s - before).amax() <= 16.0 * f64::EPSILON, "{s}");
    // |S^-1 v| = 1 is the limit: 2.1 e1 against the variance 4.
    assert!(!subtract(&mut s.clone(), &mut Vector3::new(2.1, 0.0, 0.0)));
    assert!(!subtract(&mut s, &mut Vector3::new(f64::NAN, 0.0, 0.0)));
}

#[test]
fn a_joint_factor_conditions_the_state_on_the_measurement() {
    let start = || Joint { measured: Matrix1::new(0.5_f64), cross: Vector2::zeros(), state: Matrix2::zeros() };
    let mut joint = start();
    for (a, b) in [(1.0, Vector2::new(2.0, 0.5)), (0.25, Vector2::new(0.0, 1.5))] {
        joint.add(&mut Vector1::new(a), &mut b.clone());
    }
    let (s, c) = (0.25 + 1.0 + 0.0625, Vector2::new(2.0, 0.875));
    let p = Matrix2::new(4.0, 1.0, 1.0, 2.5);
    assert!((joint.measured[0] * joint.measured[0] - s).abs() < 1e-15);
    assert!((joint.cross * joint.measured[0] - c).amax() < 1e-15);
    let expected = p - c * c.transpose() / s;
    assert!((joint.state * joint.state.transpose() - expected).amax() < 4e-15, "{}", joint.state);
    let (mut a, mut b) = (Vector1::new(0.25), Vector2::new(0.0, 1.5));
    // What is left has one column for two states, without rounding.
    joint.state[(1, 1)] += 1e-3;
    assert!(joint.subtract(&mut a, &mut b));
    assert!((joint.measured[0] * joint.measured[0] - 1.25).abs() < 1e-15);
    assert!(!start().subtract(&mut Vector1::new(0.6), &mut Vector2::zeros()));
}

#[test]
fn a_singular_covariance_has_a_factor() {
    let d = Vector3::new(1e-9, 0.3, 1.0);
    let p = d * d.transpose();
    let s = semidefinite_factor(&p);
    assert!((s * s.transpose() - p).amax() <= 4.0 * f64::EPSILON, "{s}");
    assert_eq!(s[(1, 1)], 0.0);
    assert_eq!(semidefinite_factor(&Matrix2::<f64>::zeros()), Matrix2::zeros());
}

proptest! {
    /// `s s'` is p to rounding, whatever the rank and however near to singular; the entries are compared with the
    /// roots of the diagonal.
    #[test]
    fn the_factor_of_a_nearly_singular_matrix_is_accurate(
        roots in prop::array::uniform16(-1.0f64..1.0), rank in 0usize..=4, small in -12i32..=0, units in prop::array::uniform4(-6i32..=6),
    ) {
        let mut root = Matrix4::from_row_slice(&roots);
        root.columns_mut(rank, 4 - rank).fill(0.0);
        if rank > 0 {
            root.column_mut(rank - 1).scale_mut(10f64.powi(small));
        }
        let root = Matrix4::from_diagonal(&units.map(|unit| 10f64.powi(unit)).into()) * root;
        let p = root * root.transpose();
        let s = semidefinite_factor(&p);
        prop_assert!(s.upper_triangle() == Matrix4::from_diagonal(&s.diagonal()));
        for i in 0..4 {
            for j in 0..4 {
                let error = (s * s.transpose() - p)[(i, j)].abs();
                // 128 epsilon is where a pivot counts as rounding.
                prop_assert!(error <= 256.0 * f64::EPSILON * (p[(i, i)] * p[(j, j)]).sqrt(), "{p} {s} {error:e}");
            }
        }
    }
}
