//! Which scalar unknowns an unknown matrix has, and where.

use luenberger_lmi::internals::{Rounded, expand};
use luenberger_lmi::{Expression, Problem};
use nalgebra::{DMatrix, dmatrix};

#[test]
fn a_symmetric_unknown_counts_each_pair_once() {
    let p = Problem::new().symmetric("P", 4);
    let entries = expand::<Rounded>(&Expression::from(&p), &[0]).unwrap();
    let unknown_at = |i: usize, j: usize| match entries[(i, j)].terms[..] {
        [(k, _)] => k,
        _ => panic!("{:?} at ({i}, {j})", entries[(i, j)]),
    };
    let mut seen = vec![0; p.unknowns()];
    for i in 0..4 {
        for j in 0..4 {
            let k = unknown_at(i, j);
            assert_eq!(k, unknown_at(j, i));
            seen[k] += 1;
        }
    }
    assert_eq!(seen, [1, 2, 2, 2, 1, 2, 2, 1, 2, 1]);
}

#[test]
fn a_diagonal_unknown_is_zero_outside_its_diagonal() {
    let mut lmi = Problem::new();
    let d = lmi.diagonal("D", 2);
    lmi.constrain("D > F", &d >> dmatrix![3.0, 0.0; 0.0, 4.0]);
    lmi.minimise(d.trace());
    let value = lmi.solve().unwrap().value(&d);
    assert_eq!((value[(0, 1)], value[(1, 0)]), (0.0, 0.0));
    assert!((value - DMatrix::from_diagonal(&nalgebra::dvector![3.0, 4.0])).amax() < 1e-4);
}
