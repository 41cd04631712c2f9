//! Estimates of the separation of operators that are known.

use luenberger_linalg::internals::{of_exact, separation, separation_by_three};
use nalgebra::{DMatrix, dmatrix};

#[test]
fn the_estimate_is_exact_for_diagonal_operators_and_never_below_the_separation() {
    let d = dmatrix![4.0, -2.0; 0.5, 8.0];
    let solve = |x: &mut DMatrix<f64>| x.component_div_assign(&d);
    assert_eq!(separation(2, 2, solve, solve), 0.5);
    assert_eq!(separation_by_three(&mut DMatrix::zeros(2, 2), solve, solve), 0.5);
    assert_eq!(separation_by_three(&mut DMatrix::zeros(1, 1), |x| *x /= -4.0, |x| *x /= -4.0), 4.0);
    assert_eq!(separation_by_three(&mut DMatrix::zeros(0, 3), solve, solve), f64::INFINITY);
    // An overflow gives the separation zero.
    assert_eq!(separation_by_three(&mut DMatrix::zeros(2, 2), |x| x.fill(f64::NAN), solve), 0.0);
    // A full operator: X -> X M, whose inverse has the 1-norm of M^-1 transposed.
    let m = dmatrix![1.0, 2.0, 0.0; 0.0, 1.0, 3.0; -1.0, 0.0, 2.0];
    let inverse = m.clone().try_inverse().unwrap();
    let norm = inverse.row_iter().map(|r| r.lp_norm(1)).fold(0.0_f64, f64::max);
    let solve = |x: &mut DMatrix<f64>| *x = &*x * &inverse;
    let adjoint = |x: &mut DMatrix<f64>| *x = &*x * inverse.transpose();
    for found in [separation(2, 3, solve, adjoint), separation_by_three(&mut DMatrix::zeros(2, 3), solve, adjoint)] {
        assert!(found >= 1.0 / norm * (1.0 - 1e-14) && found <= 3.0 / norm, "{found} {}", 1.0 / norm);
    }
}

/// `X -> B vec X` for 300 random B of order 9: estimates of `|B|_1` are never above it, none is off by a factor of
/// three, and on average they are near to it.
#[test]
fn estimates_for_random_operators_are_near_the_norm() {
    let mut state = 7_u64;
    let mut random = || {
        state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (state >> 11) as f64 / 2f64.powi(52) - 1.0
    };
    let (mut whole, mut three) = (Vec::new(), Vec::new());
    for _ in 0..300 {
        let b = DMatrix::from_fn(9, 9, |_, _| random());
        let norm = b.column_iter().map(|column| column.lp_norm(1)).fold(0.0_f64, f64::max);
        let apply = |b: &DMatrix<f64>, x: &mut DMatrix<f64>| {
            let image = b * DMatrix::from_column_slice(9, 1, x.as_slice());
            x.copy_from_slice(image.as_slice());
        };
        let solve = |x: &mut DMatrix<f64>| apply(&b, x);
        let adjoint = |x: &mut DMatrix<f64>| apply(&b.transpose(), x);
        whole.push(1.0 / separation(3, 3, solve, adjoint) / norm);
        three.push(1.0 / separation_by_three(&mut DMatrix::zeros(3, 3), solve, adjoint) / norm);
    }
    for (shares, average) in [(&whole, 0.85), (&three, 0.85)] {
        let mean = shares.iter().sum::<f64>() / 300.0;
        let (least, largest) = shares.iter().fold((1.0_f64, 0.0_f64), |(l, h), x| (l.min(*x), h.max(*x)));
        assert!(mean > average && least > 1.0 / 3.0 && largest <= 1.0 + 1e-14, "{mean} {least} {largest}");
    }
}

/// `e/|x|` of `|x - e|` at least: `b/(1 - b)`.
#[test]
fn an_error_relative_to_what_was_found_as_one_of_the_exact_solution() {
    assert_eq!([0.0, 0.2, 0.5, 0.75].map(of_exact), [0.0, 0.25, 1.0, 3.0]);
    assert_eq!([1.0, 2.0, f64::NAN].map(of_exact), [f64::INFINITY; 3]);
}
