//! The Schur complement of the interior-point method, by products of matrices and by entries.

use faer::Mat;
use luenberger_lmi::internals::{Anchor, ConicProgram, Scaled, Small, assemble, joined, standard_form};
use luenberger_lmi::{Problem, block, he};
use nalgebra::DMatrix;

/// With two products of the same unknown that cannot be added up (`P - A'PA`), a rectangular unknown, blocks and a
/// scalar: the matrix is that of the entries.
#[test]
fn products_and_entries_give_the_same_matrix() {
    let number = |i: usize, j: usize, k: usize| (((i * 37 + j * 101 + k * 17 + 11) % 64) as f64 - 31.5) / 40.0;
    let n = 7;
    let a = DMatrix::from_fn(n, n, |i, j| number(i, j, 1));
    let (b, c) = (DMatrix::from_fn(n, 2, |i, j| number(i, j, 2)), DMatrix::from_fn(2, n, |i, j| number(i, j, 3)));
    let mut lmi = Problem::new();
    let (p, y, g) = (lmi.symmetric("P", n), lmi.rectangular("Y", n, 2), lmi.scalar("g"));
    lmi.constrain("continuous", (he(&y * &c - &p * &a) + g.identity(n)) >> 0.0);
    lmi.constrain("discrete", (&p - a.transpose() * &p * &a - he(&y * &c)) >> 1.0);
    let top = he(&p * &a) + g.identity(n);
    let corner = &p * &b - 2.0 * &y;
    lmi.constrain("blocks", block![[top, &corner], [corner.transpose(), g.identity(2)]] >> 0.0);
    let standard = standard_form(&lmi, Anchor::Middle, Small::Kept).unwrap();
    let program = |blocks| ConicProgram::new(vec![1.0; standard.cone_unknowns()], blocks);
    let structured = Scaled::of(&program(standard.blocks.clone()));
    let mut plain = standard.blocks.clone();
    for block in &mut plain {
        block.products.clear();
    }
    let plain = Scaled::of(&program(plain));
    let definite = |order: usize, k: usize| {
        let root = Mat::from_fn(order, order, |i, j| number(i, j, k));
        &root * root.transpose()
    };
    for (with, without) in structured.dense.iter().zip(&plain.dense) {
        assert!(!with.products.is_empty() && without.products.is_empty());
        let (v, y) = (definite(with.order, 4), definite(with.order, 5));
        let matrix = |block| {
            let mut b = Mat::zeros(standard.cone_unknowns(), standard.cone_unknowns());
            assemble(block, v.as_ref(), y.as_ref(), &mut b);
            joined(b)
        };
        let (found, expected) = (matrix(with), matrix(without));
        let size = (0..expected.ncols()).map(|k| expected[(k, k)]).fold(0.0, f64::max);
        assert!((found - expected).norm_max() <= 1e-13 * size);
    }
}
