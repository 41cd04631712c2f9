//! Exact integer solutions of homogeneous equations near a given point.

use dashu_int::IBig;
use luenberger_lmi::internals::{Row, solve_near};
use luenberger_proof::{Exact, Ring};

fn row(terms: &[(usize, f64)]) -> Row {
    Row::from_exact(terms.iter().map(|&(place, c)| (place, Exact::from_f64(c).unwrap())).collect())
}

fn value(terms: &[(usize, f64)], z: &[IBig]) -> Exact {
    terms.iter().fold(Exact::zero(), |sum, &(place, c)| {
        sum.add(&Exact::from_f64(c).unwrap().mul(&Exact::new(z[place].clone(), 0)))
    })
}

#[test]
fn equations_hold_exactly_and_nearby() {
    // 0.1 and 0.3 are no thirds of each other in binary64; the exact solution knows.
    let equations: [&[(usize, f64)]; 3] =
        [&[(0, 0.1), (1, -0.3)], &[(1, 1.0), (2, 0.7), (3, -1e-3)], &[(0, 0.2), (1, -0.6)]];
    let start = [3.0, 1.0 + 1e-9, -1.0, 300.0];
    let z = solve_near(equations.iter().map(|terms| row(terms)).collect(), &start, || false).unwrap();
    for terms in equations {
        assert!(value(terms, &z).is_zero());
    }
    let ratio = |i: usize, j: usize| {
        let number = |k: usize| Exact::new(z[k].clone(), 0).round_down();
        number(i) / number(j)
    };
    assert!((ratio(0, 1) - 3.0).abs() < 1e-14);
    assert!((ratio(0, 3) - 0.01).abs() < 1e-10);
}

#[test]
fn nothing_is_eliminated_after_the_end() {
    let rows = || vec![row(&[(0, 1.0), (1, 2.0)]), row(&[(1, 1.0), (2, 3.0)])];
    assert!(solve_near(rows(), &[1.0; 3], || false).is_some());
    assert!(solve_near(rows(), &[1.0; 3], || true).is_none());
}

#[test]
fn a_repeated_unknown_is_one_unknown() {
    let z = solve_near(vec![row(&[(0, 1.0), (1, 1.0), (0, -1.0)])], &[1.0, 1e-9], || false).unwrap();
    assert!(z[1].is_zero() && !z[0].is_zero());
}

/// Dense rows of 60 unknowns with coefficients from `2^-1000` to `2^1000`: integers of some 60 000 bits.
#[test]
fn the_work_is_bounded() {
    let n = 60_u8;
    // Mantissas of 50 bits from a linear congruential generator.
    let mut state = 1_u64;
    let mut number = |exponent: i32| {
        state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        ((state >> 14) as f64) * 2.0f64.powi(exponent)
    };
    let rows = (0..n - 1).map(|i| {
        let terms: Vec<(usize, f64)> =
            (0..n).map(|j| (j.into(), number((37 * i32::from(i) + 53 * i32::from(j)) % 1900 - 1000))).collect();
        row(&terms)
    });
    let rows = rows.collect();
    assert!(solve_near(rows, &[1.0; 60], || false).is_none());
}
