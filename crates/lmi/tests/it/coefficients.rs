//! Coefficients and values of expressions, exactly.

use luenberger_lmi::internals::{Rounded, evaluate, expand};
use luenberger_lmi::{Expression, Fault, Problem, Structure, Variable, block, he, zeros};
use luenberger_proof::{Exact, Ring};
use nalgebra::DMatrix;

/// The matrix of these scalar unknowns: a symmetric one has its lower triangle column by column.
fn assembled(v: &Variable, x: &[f64]) -> DMatrix<f64> {
    let (rows, columns) = v.shape();
    let mut unknowns = x.iter().copied();
    let mut next = || unknowns.next().expect("as many as the variable counts");
    let mut m = DMatrix::zeros(rows, columns);
    for j in 0..columns {
        for i in 0..rows {
            match v.structure() {
                Structure::Symmetric if i < j => m[(i, j)] = m[(j, i)],
                Structure::Diagonal if i != j => {}
                _ => m[(i, j)] = next(),
            }
        }
    }
    m
}

/// The expanded form at given values and the tree evaluated directly agree exactly, with every kind of node
/// present.
#[test]
fn expanding_and_evaluating_are_the_same_exactly() {
    let mut lmi = Problem::new();
    let (p, y) = (lmi.symmetric("P", 3), lmi.rectangular("Y", 3, 2));
    let (d, g) = (lmi.diagonal("D", 2), lmi.scalar("g"));
    let a = DMatrix::from_fn(3, 3, |i, j| 0.1 * (i + 1) as f64 - 0.3 * j as f64);
    let c = DMatrix::from_fn(2, 3, |i, j| 0.7 - 0.2 * (i * j) as f64);
    let top = he(&p * &a - &y * &c) + g.identity(3) - 0.3 * DMatrix::<f64>::identity(3, 3);
    let corner = a.transpose() * &y - &p * c.transpose();
    let last = -Expression::from(&d) + &g * &DMatrix::from_element(2, 2, 0.1) + zeros(2, 2);
    let trace = block![[p.trace()]];
    let whole = block![
        [&top, &corner, zeros(3, 1)],
        [corner.transpose(), last, zeros(2, 1)],
        [zeros(1, 3), zeros(1, 2), trace]
    ];
    assert_eq!(whole.fault(), None);
    let mut offset = 0;
    let mut offsets = vec![];
    let variables = [p, y, d, g];
    for v in &variables {
        offsets.push(offset);
        offset += v.unknowns();
    }
    let x: Vec<f64> = (0..offset).map(|k| 0.37 * k as f64 - 1.1).collect();
    let values: Vec<_> = variables.iter().zip(&offsets).map(|(v, &o)| (v.clone(), assembled(v, &x[o..]))).collect();
    let direct = evaluate::<Exact>(&whole, &values).unwrap();
    let expanded = expand::<Exact>(&whole, &offsets).unwrap().map(|entry| {
        entry.terms.iter().fold(entry.constant.clone(), |sum, (k, c)| sum.add(&c.mul(&Exact::from_f64(x[*k]).unwrap())))
    });
    assert_eq!(direct, expanded);
}

/// A value that is not finite is an error wherever it occurs, and is not treated as 0.
#[test]
fn what_is_not_a_number_is_not_zero() {
    let mut lmi = Problem::new();
    let p = lmi.symmetric("P", 2);
    let positive = Expression::from(&p) + DMatrix::<f64>::identity(2, 2);
    for bad in [f64::NAN, f64::INFINITY] {
        let values = [(p.clone(), DMatrix::from_row_slice(2, 2, &[0.0, 0.0, bad, 0.0]))];
        let found = evaluate::<Exact>(&positive, &values);
        assert!(matches!(found, Err(Fault::NotFinite { row: 1, column: 0, .. })), "{found:?}");
        assert!(evaluate::<Rounded>(&positive, &values).is_err());
        let constant = Expression::from(&p) + DMatrix::from_element(2, 2, bad);
        assert!(matches!(expand::<Exact>(&constant, &[0]), Err(Fault::NotFinite { row: 0, column: 0, .. })));
        assert!(matches!(expand::<Exact>(&(bad * &positive), &[0]), Err(Fault::NotFinite { .. })));
    }
}
