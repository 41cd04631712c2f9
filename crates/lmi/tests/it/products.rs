//! Symmetric expressions as sums of products of their unknowns.

use luenberger_lmi::internals::products;
use luenberger_lmi::{Problem, block, he, zeros};
use nalgebra::DMatrix;

fn symmetric_part(m: &DMatrix<f64>) -> DMatrix<f64> {
    (m + m.transpose()) * 0.5
}

#[test]
fn a_lyapunov_operator_is_one_product_however_it_is_written() {
    let a = DMatrix::from_fn(3, 3, |i, j| 0.3 * i as f64 - 0.7 * j as f64 + 0.1);
    let mut lmi = Problem::new();
    let p = lmi.symmetric("P", 3);
    for e in [he(&p * &a), a.transpose() * &p + &p * &a, &p * &a + (&p * &a).transpose()] {
        let found = products(&e);
        assert_eq!(found.len(), 1);
        let x = DMatrix::from_fn(3, 3, |i, j| (1 + i * j) as f64);
        let value = symmetric_part(&(&found[0].left * &x * &found[0].right));
        assert!((value - (a.transpose() * &x + &x * &a)).amax() < 1e-13);
    }
}

/// The sum of the products at random values is the expression without its constants and its other unknowns.
#[test]
fn products_in_blocks_have_the_value_of_the_expression() {
    let mut lmi = Problem::new();
    let (p, y, g) = (lmi.symmetric("P", 3), lmi.rectangular("Y", 3, 2), lmi.scalar("g"));
    let a = DMatrix::from_fn(3, 3, |i, j| 0.1 * (i + 1) as f64 - 0.3 * j as f64);
    let (b, c) = (DMatrix::from_element(3, 2, 0.4), DMatrix::from_fn(2, 3, |i, j| 0.7 - 0.2 * (i * j) as f64));
    let top = he(&p * &a - &y * &c) + 0.3 * DMatrix::<f64>::identity(3, 3);
    let corner = &p * &b - 2.0 * &y;
    let e = block![[&top, &corner], [corner.transpose(), zeros(2, 2) - g.identity(2)]];
    let (p, y) =
        (DMatrix::from_fn(3, 3, |i, j| (1 + i * j) as f64), DMatrix::from_fn(3, 2, |i, j| i as f64 - 0.6 * j as f64));
    let top = {
        let half = &p * &a - &y * &c;
        &half + half.transpose()
    };
    let corner = &p * &b - &y * 2.0;
    let mut expected = DMatrix::zeros(5, 5);
    expected.view_mut((0, 0), (3, 3)).copy_from(&top);
    expected.view_mut((0, 3), (3, 2)).copy_from(&corner);
    expected.view_mut((3, 0), (2, 3)).copy_from(&corner.transpose());
    let found = products(&e);
    assert!(found.iter().all(|product| product.variable.name() != "g"));
    let sum = found.iter().fold(DMatrix::zeros(5, 5), |sum, product| {
        let x = if product.variable.name() == "P" { &p } else { &y };
        sum + symmetric_part(&(&product.left * x * &product.right))
    });
    assert!((sum - expected).amax() < 1e-13);
}

#[test]
fn an_unknown_in_a_trace_is_left_out() {
    let mut lmi = Problem::new();
    let p = lmi.symmetric("P", 2);
    assert!(products(&(&p + p.trace() * &DMatrix::<f64>::identity(2, 2))).is_empty());
}
