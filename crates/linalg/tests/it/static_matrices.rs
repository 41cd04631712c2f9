//! Matrices of static size and views give the same result as dynamic ones, to the last bit.

use luenberger_linalg::{
    RealMatrixView, balanced, discrete_h_infinity_norm, discrete_h2_norm, distance_to_unobservability,
    functional_observer, generalized_lyapunov, generalized_stein, h_infinity_norm, h2_norm, invariant_zeros,
    kalman_decomposition, lambda_max, lambda_min, lyapunov_factor, observability_within, place_observer_structured,
    place_structured, reduced_order_observer, schur, stein_factor, symmetric_eigenvalues, zero_order_hold_observer,
};
use nalgebra::{Complex, DMatrix, Matrix1, Matrix2, RowVector2, Vector2, dmatrix};

/// Calls the function with the static matrices, with dynamic ones, and with views into larger ones.
macro_rules! assert_same {
    ($function:ident($($matrix:expr),+ $(; $other:expr)*)) => {{
        let found = $function($(&dynamic(&$matrix)),+ $(, $other)*).unwrap();
        assert_eq!($function($(&$matrix),+ $(, $other)*).unwrap(), found);
        let views = $function($(&padded(&$matrix).view_with_steps((0, 0), $matrix.shape(), (1, 1))),+ $(, $other)*);
        assert_eq!(views.unwrap(), found);
    }};
}

fn dynamic<'a>(m: impl Into<RealMatrixView<'a>>) -> DMatrix<f64> {
    m.into().into_owned()
}

/// The matrix in every second row and column of one twice as large; its other entries are not numbers.
fn padded<'a>(m: impl Into<RealMatrixView<'a>>) -> DMatrix<f64> {
    let m = m.into();
    let mut padded = DMatrix::from_element(2 * m.nrows(), 2 * m.ncols(), f64::NAN);
    padded.view_with_steps_mut((0, 0), m.shape(), (1, 1)).copy_from(&m);
    padded
}

#[test]
fn static_matrices_and_views_give_what_dynamic_ones_give() {
    let (a, b, c) = (Matrix2::new(-0.5, 0.25, 0.125, -0.75), Vector2::new(0.0, 1.0), RowVector2::new(1.0, 0.0));
    let (d, e, q) = (Matrix1::new(0.5), Matrix2::new(2.0, 0.0, 1.0, 1.0), Matrix2::new(2.0, 1.0, 1.0, 2.0));

    assert_same!(schur(a));
    assert_same!(balanced(a));
    assert_same!(symmetric_eigenvalues(q));
    assert_same!(lambda_min(q));
    assert_same!(lambda_max(q));
    assert_same!(lyapunov_factor(a, c));
    assert_same!(stein_factor(a, c));
    assert_same!(generalized_lyapunov(a, e, q));
    assert_same!(generalized_stein(a, e, q));
    assert_same!(observability_within(a, c; 1e-12));
    assert_same!(distance_to_unobservability(a, c));
    assert_same!(kalman_decomposition(a, b, c));
    assert_same!(invariant_zeros(a, b, c, d));
    assert_same!(zero_order_hold_observer(a, b, Vector2::new(3.0, 2.0), c; 0.1));
    assert_same!(h2_norm(a, b, c));
    assert_same!(discrete_h2_norm(a, b, c));
    assert_same!(h_infinity_norm(a, b, c, d));
    assert_same!(discrete_h_infinity_norm(a, b, c, d));
    assert_same!(reduced_order_observer(a, b, c; &[-4.0]));
    assert_same!(functional_observer(a, b, c, RowVector2::new(0.0, 1.0); &[-4.0]));
}

/// Real poles as numbers or complex numbers, the pattern of the gain of static or dynamic size.
#[test]
fn poles_and_patterns_of_any_type_give_the_same_gain() {
    let (a, b, c) = (Matrix2::new(0.0, 1.0, -4.0, -0.4), Vector2::new(0.0, 1.0), Matrix2::identity());
    let (real, complex) = ([-5.0, -6.0], [Complex::from(-5.0), Complex::from(-6.0)]);

    let free = RowVector2::new(true, true);
    let found = place_structured(&a, &b, &real, &free).unwrap();
    assert_eq!(place_structured(&dynamic(&a), &dynamic(&b), &complex, &dmatrix![true, true]).unwrap(), found);

    let free = Matrix2::new(true, true, false, true);
    let found = place_observer_structured(&a, &c, &real, &free).unwrap();
    let other = dmatrix![true, true; false, true];
    assert_eq!(place_observer_structured(&dynamic(&a), &dynamic(&c), &complex, &other).unwrap(), found);

    let (b, c) = (Vector2::new(0.0, 1.0), RowVector2::new(1.0, 0.0));
    let found = reduced_order_observer(&a, &b, &c, &real[..1]).unwrap();
    assert_eq!(reduced_order_observer(&a, &b, &c, &complex[..1]).unwrap(), found);
}
