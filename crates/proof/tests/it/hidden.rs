//! Unobservable motions with decay rates that are known by construction, decided exactly.

use std::cmp::Ordering;

use luenberger_proof::statement::{hidden_motion, hurwitz_spectrum, schur_spectrum};
use luenberger_proof::{Exact, Matrix, Ring};
use proptest::prelude::*;

fn exact(m: &Matrix<f64>) -> Matrix<Exact> {
    m.map(|x| Exact::from_f64(*x).expect("finite"))
}

#[test]
fn a_jordan_block_beside_the_axis() {
    // Eigenvalues -2^-40 and 2^-40, four times each, in a basis in which no entry shows them: T = I + N with
    // nilpotent N has an integer inverse.
    let t = Matrix::from_fn(4, 4, |i, j| match i.cmp(&j) {
        Ordering::Equal => 1.0,
        Ordering::Less => (1 + i + j) as f64,
        Ordering::Greater => 0.0,
    });
    let mut inverse = Matrix::from_fn(4, 4, |i, j| if i == j { 1.0 } else { 0.0 });
    for _ in 0..4 {
        // X <- I - N X.
        inverse = Matrix::from_fn(4, 4, |i, j| {
            let sum: f64 = (i + 1..4).map(|l| t[(i, l)] * inverse[(l, j)]).sum();
            f64::from(i == j) - sum
        });
    }
    let with_eigenvalue = |x: f64| {
        let j = Matrix::from_fn(4, 4, |i, k| {
            if i == k {
                x
            } else if i + 1 == k {
                1.0
            } else {
                0.0
            }
        });
        exact(&t).product(&exact(&j)).unwrap().product(&exact(&inverse)).unwrap()
    };
    let small = 2f64.powi(-40);
    for (x, expected) in [(-small, true), (small, false), (0.0, false)] {
        assert_eq!(hurwitz_spectrum(&with_eigenvalue(x)), Some(expected));
    }
    // Beside the unit circle, at 1 and at -1.
    for side in [1.0, -1.0] {
        for (x, expected) in [(1.0 - small, true), (1.0, false), (1.0 + small, false), (0.0, true)] {
            assert_eq!(schur_spectrum(&with_eigenvalue(side * x)), Some(expected), "{side} {x}");
        }
    }
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 200, failure_persistence: None, ..ProptestConfig::default() })]

    /// Block triangular by construction, with the unobservable block `-d I + skew`, transformed by an integer
    /// matrix of determinant 1: unobservable, and the decay rate is exactly d.
    #[test]
    fn what_is_hidden_by_construction_is_found(
        entries in prop::collection::vec(-9i32..=9, 40), d in 1i32..20, scale in prop_oneof![-300i32..300, -6..2],
    ) {
        let n = 4;
        let number = |k: usize| f64::from(entries[k]);
        let size = 2f64.powi(scale);
        let a = Matrix::from_fn(n, n, |i, j| size * match (i < 2, j < 2) {
            (_, true) => number(4 * i + j),
            (true, false) => 0.0,
            (false, false) if i == j => -f64::from(d),
            (false, false) => if i < j { number(20) } else { -number(20) },
        });
        // x = T z with T unit lower triangular: A <- T A T^-1, C <- C T^-1.
        let t = Matrix::from_fn(n, n, |i, j| match i.cmp(&j) { Ordering::Equal => 1.0, Ordering::Greater => number(21 + 4 * i + j), Ordering::Less => 0.0 });
        let mut inverse = Matrix::from_fn(n, n, |_, _| 0.0);
        for j in 0..n {
            for i in 0..n {
                let sum: f64 = (0..i).map(|l| t[(i, l)] * inverse[(l, j)]).sum();
                inverse = Matrix::from_fn(n, n, |r, s| if (r, s) == (i, j) { f64::from(i == j) - sum } else { inverse[(r, s)] });
            }
        }
        let turned = exact(&t).product(&exact(&a)).unwrap().product(&exact(&inverse)).unwrap();
        let c = exact(&Matrix::from_fn(1, n, |_, j| if j < 2 { number(38) + j as f64 } else { 0.0 })).product(&exact(&inverse)).unwrap();
        // Small integers times a power of two are exact.
        let (a, c) = (turned.map(Exact::round_down), c.map(Exact::round_down));
        prop_assert_eq!(exact(&a), turned);
        let hidden = hidden_motion(&a, &c).unwrap().unwrap();
        prop_assert!(hidden.is_of(&a, &c).unwrap());
        prop_assert_eq!(hidden.decays_at(f64::from(d) * size), Some(false));
        if hidden.motion.rows() == 2 {
            prop_assert_eq!(hidden.decays_at((f64::from(d) * size).next_down()), Some(true));
            // The square of the modulus, exactly.
            let modulus = f64::from(d * d + entries[20] * entries[20]) * size * size;
            prop_assert_eq!(hidden.decays_in_steps(), Some(modulus < 1.0));
        }
        let mut wrong = hidden.clone();
        wrong.motion = wrong.motion.scaled(&Exact::from_f64(3.0).unwrap());
        prop_assert!(!wrong.is_of(&a, &c).unwrap());
    }
}
