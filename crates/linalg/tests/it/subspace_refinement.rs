//! Refinement of an unobservable subspace that is off by more than rounding.

use luenberger_linalg::internals::{Staircase, refine};
use nalgebra::{DMatrix, QR};

/// What V, the last columns of Q after the first `r`, leaves of `A V = V (V'A V)` and `C V = 0`.
fn residual(a: &DMatrix<f64>, c: &DMatrix<f64>, q: &DMatrix<f64>, r: usize) -> f64 {
    let (w, v) = (q.columns(0, r), q.columns(r, q.ncols() - r));
    (w.transpose() * (a * v)).norm().hypot((c * v).norm())
}

/// A subspace with an error of 1e-6 is restored to rounding level, also if an unobservable eigenvalue is observable
/// too.
#[test]
fn a_subspace_that_is_off_is_brought_back() {
    // Two observable states with eigenvalues -1, -2, three unobservable with -1, 1 +- 2i; only C makes Z unique.
    let a = DMatrix::from_row_slice(
        5,
        5,
        &[
            -1.0, 1.0, 0.0, 0.0, 0.0, 0.0, -2.0, 0.0, 0.0, 0.0, 0.3, -0.4, -1.0, 0.0, 0.0, 0.2, 0.1, 0.0, 1.0, 2.0,
            -0.5, 0.7, 0.0, -2.0, 1.0,
        ],
    );
    let c = DMatrix::from_row_slice(1, 5, &[1.0, 0.5, 0.0, 0.0, 0.0]);
    let off = DMatrix::from_fn(5, 5, |i, j| f64::from(u8::from(i == j)) + 1e-6 * ((3 * i + 5 * j) as f64).sin());
    let q = QR::new(off).q();
    let mut staircase = Staircase {
        f: q.transpose() * a.transpose() * &q,
        g: q.transpose() * c.transpose(),
        q,
        rank: 2,
        stairs: vec![1, 1],
    };
    let size = a.norm().hypot(c.norm());
    assert!(residual(&a, &c, &staircase.q, 2) > 1e-7);
    refine(&mut staircase, &a, &c, size).unwrap();
    let q = &staircase.q;
    assert!(residual(&a, &c, q, 2) < 5.0 * f64::EPSILON * size);
    assert!((q.transpose() * q - DMatrix::identity(5, 5)).norm() < 1e-14);
    // The unobservable block (transposed in the staircase of A') has the unobservable eigenvalues.
    let block = staircase.f.view((2, 2), (3, 3)).into_owned();
    assert!((block.trace() - 1.0).abs() < 1e-13 && (block.determinant() + 5.0).abs() < 1e-12);
}
