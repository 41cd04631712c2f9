//! The Cholesky factorisation behind proofs of definiteness: its order of operations, its scaling and its shift.

use luenberger_proof::internals::{factor, half_exponent, times_power_of_two};
use luenberger_proof::{Matrix, positive_definite};
use luenberger_random::Random;

/// Gram matrices of n vectors in n - 1 dimensions with small integer entries are exactly singular. At these orders
/// an unshifted Cholesky completes for some of them, because rounding determines the sign of the last pivot.
#[test]
fn a_singular_matrix_is_never_certified() {
    let mut random = Random(1);
    let mut survived_unshifted = 0;
    for trial in 0..120 {
        let n = 20 + trial % 30;
        let x: Vec<f64> = (0..n * (n - 1)).map(|_| random.below(16) as f64 - 7.5).collect();
        // Multiples of 1/4 below 2^14: exact.
        let mid =
            Matrix::from_fn(n, n, |i, j| (0..n - 1).map(|k| x[i * (n - 1) + k] * x[j * (n - 1) + k]).sum::<f64>());
        survived_unshifted += i32::from(factor(mid.clone()).is_ok());
        assert!(positive_definite(&mid).expect("symmetric").is_refuted(), "a singular matrix of order {n}");
    }
    assert!(survived_unshifted > 20, "only {survived_unshifted} of these matrices put the shift to the test");
}

#[test]
fn the_exponent_brings_every_positive_number_into_one_to_four() {
    for x in [f64::from_bits(1), f64::from_bits(77), f64::MIN_POSITIVE, 0.3, 1.0, 3.999, 4.0, 1e300, f64::MAX] {
        let scaled = times_power_of_two(x, -2 * half_exponent(x));
        assert!((1.0..4.0).contains(&scaled), "{x:e} becomes {scaled}");
    }
}

/// The unblocked loop of the head of `cholesky.rs`.
fn plainly(mut b: Matrix<f64>) -> Matrix<f64> {
    let n = b.rows();
    for j in 0..n {
        for i in 0..=j {
            let mut sum = b[(i, j)];
            for k in 0..i {
                sum -= b[(k, i)] * b[(k, j)];
            }
            b[(i, j)] = if i == j { sum.sqrt() } else { sum / b[(i, i)] };
        }
    }
    b
}

/// Bitwise equality: the bound is proved for this order of operations.
#[test]
fn the_order_of_operations_does_not_depend_on_the_size() {
    for n in [1, 3, 47, 48, 49, 52, 97, 131, 200] {
        let b = Matrix::from_fn(n, n, |i, j| {
            let x = 1.0 / (1.0 + (i as f64 - j as f64).powi(2) + ((i * j) % 7) as f64);
            if i == j { n as f64 } else { x }
        });
        let expected = plainly(b.clone());
        let Ok(r) = factor(b) else { panic!("diagonally dominant") };
        for i in 0..n {
            assert_eq!(r.row(i)[i..], expected.row(i)[i..], "row {i} of {n}");
        }
    }
}

#[test]
fn a_stop_leaves_the_rows_before_it() {
    for n in [5, 60, 120] {
        for row in [0, 3, n - 1] {
            let b = Matrix::from_fn(n, n, |i, j| match (i, j) {
                _ if i != j => 1.0 / (2.0 + (i + j) as f64),
                _ if i == row => -1.0,
                _ => n as f64,
            });
            let expected = plainly(b.clone());
            let Err((r, stopped)) = factor(b) else { panic!("a negative diagonal entry") };
            assert_eq!(stopped, row);
            for i in 0..row {
                assert_eq!(r.row(i)[i..], expected.row(i)[i..], "row {i} of {n}");
            }
        }
    }
}
