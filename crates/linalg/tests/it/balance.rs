//! Units of the state in which a plant has entries of comparable size.

use luenberger_linalg::internals::{Balance, sizes};
use nalgebra::{DMatrix, dmatrix};

#[test]
fn units_are_found_back() {
    let a = dmatrix![1.0, 2.0, 1.0; -1.0, 1.0, 2.0; 1.0, 1.0, 1.0];
    let units = [-20, 0, 35];
    let hidden = |a: &DMatrix<f64>| DMatrix::from_fn(3, 3, |i, j| a[(i, j)] * 2f64.powi(units[j] - units[i]));
    let found = Balance::of(&sizes(&hidden(&a)), None);
    let balanced = found.similar(&hidden(&a));
    assert!(balanced.amax() <= 8.0, "{balanced}");
    assert!(Balance::of(&sizes(&a), None).is_trivial());
    // Triangular: the row of the last state is empty, and nothing runs away.
    assert!(Balance::of(&sizes(&dmatrix![-1.0, 1.0; 0.0, -1.0]), None).is_trivial());
    // Worth it are units that are far apart, not those of a chain with a large gain.
    assert!(Balance::worthwhile(&hidden(&a)).is_some());
    assert!(Balance::worthwhile(&a).is_none());
    assert!(Balance::worthwhile(&dmatrix![-1.0, 1e9; -1e9, -1.0]).is_none());
    assert!(Balance::worthwhile(&DMatrix::zeros(2, 2)).is_none());
    // Where the plant couples nothing, the weight and the input still tell.
    let (q, g) = (dmatrix![1e10, 0.0; 0.0, 1.0], dmatrix![1e-10, 0.0; 0.0, 1.0]);
    let found = Balance::of(&sizes(&DMatrix::zeros(2, 2)), Some((&sizes(&q), &sizes(&g))));
    let q = found.form(&q);
    assert!((0.2..5.0).contains(&(q[(0, 0)] / q[(1, 1)])), "{q}");
}
