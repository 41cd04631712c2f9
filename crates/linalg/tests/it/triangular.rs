//! Equations with quasi-triangular coefficients, in every form, symmetric ones and singular ones.

use luenberger_linalg::internals::{Coefficient, Equation, solve, solve_symmetric, view, view_mut};
use nalgebra::DMatrix;

/// Upper quasi-triangular, about half of the diagonal in standardised 2 x 2 blocks, eigenvalues of modulus 0.2 to
/// 0.9.
fn quasi_triangular(n: usize, seed: usize) -> DMatrix<f64> {
    let entry = |i: usize, j: usize| (((seed + 1) * (1 + 31 * i + 17 * j * j + i * i * j)) as f64).sin();
    let mut t = DMatrix::from_fn(n, n, |i, j| if i < j { 0.3 * entry(i, j) / (n as f64).sqrt() } else { 0.0 });
    let mut k = 0;
    while k < n {
        let real = 0.55 + 0.15 * entry(k, k);
        t[(k, k)] = real;
        if k + 1 < n && (k + seed) % 5 < 3 {
            t[(k + 1, k + 1)] = real;
            (t[(k, k + 1)], t[(k + 1, k)]) = (0.5, -0.2);
            k += 1;
        }
        k += 1;
    }
    t
}

fn right_hand_side(n: usize, m: usize) -> DMatrix<f64> {
    DMatrix::from_fn(n, m, |i, j| ((3 + 7 * i + 13 * j * j + i * j) as f64).cos())
}

/// T or its transpose, as a coefficient.
fn coefficient(t: &DMatrix<f64>, transposed: bool) -> Coefficient<'_> {
    if transposed { Coefficient::transposed(view(t)) } else { Coefficient::plain(view(t)) }
}

fn operator(equation: Equation, s: &DMatrix<f64>, t: &DMatrix<f64>, y: &DMatrix<f64>) -> DMatrix<f64> {
    match equation {
        Equation::Sylvester => s * y + y * t,
        Equation::Stein => s * y * t - y,
    }
}

/// Backward stability: a residual of a few n eps for every transposition, with and without recursion.
#[test]
fn every_form_of_the_equation_is_solved() {
    for (n, m) in [(1, 1), (3, 20), (16, 16), (17, 5), (17, 17), (40, 33), (33, 90), (70, 70)] {
        let (s, t) = (quasi_triangular(n, 1), quasi_triangular(m, 2));
        for equation in [Equation::Sylvester, Equation::Stein] {
            for (left, right) in [(false, false), (false, true), (true, false), (true, true)] {
                let d = right_hand_side(n, m);
                let mut y = d.clone();
                let coefficients = (coefficient(&s, left), coefficient(&t, right));
                let mut work = vec![0.0; n * m];
                assert!(solve(equation, coefficients.0, coefficients.1, view_mut(&mut y), &mut work));
                let whole = |c: &DMatrix<f64>, transposed: bool| if transposed { c.transpose() } else { c.clone() };
                let residual = (operator(equation, &whole(&s, left), &whole(&t, right), &y) - &d).norm();
                let terms = (s.norm() + t.norm() + s.norm() * t.norm()) * y.norm() + d.norm();
                assert!(residual <= 10.0 * n.max(m) as f64 * f64::EPSILON * terms, "{n} {m} {equation:?} {residual:e}");
            }
        }
    }
}

/// The symmetric and the general recursion give the same solution.
#[test]
fn the_symmetric_solution_is_the_solution() {
    for n in [1, 2, 16, 17, 18, 33, 50, 97] {
        let t = quasi_triangular(n, 3);
        let d = right_hand_side(n, n);
        let d = &d + d.transpose();
        for equation in [Equation::Sylvester, Equation::Stein] {
            for transposed in [false, true] {
                let (own, other) = (coefficient(&t, transposed), coefficient(&t, !transposed));
                let (mut whole, mut half) = (d.clone(), d.clone());
                // Entries below the diagonal are not read.
                (0..n).for_each(|j| (j + 1..n).for_each(|i| half[(i, j)] = f64::NAN));
                let mut work = vec![0.0; n * n];
                assert!(solve(equation, other, own, view_mut(&mut whole), &mut work));
                assert!(solve_symmetric(equation, own, view_mut(&mut half), &mut work));
                assert_eq!(half, half.transpose());
                // Sums of eigenvalues exceed 0.4 and products stay below 0.85: condition below 1e3.
                assert!((&half - &whole).norm() <= 1e3 * n as f64 * f64::EPSILON * whole.norm(), "{n} {equation:?}");
            }
        }
    }
}

#[test]
fn a_vanishing_pivot_is_reported_and_the_answer_stays_finite() {
    for n in [1, 2, 40] {
        let t =
            DMatrix::from_fn(n, n, |i, j| if i + 1 == n && j == i { -0.5 } else { f64::from(u8::from(i == j)) * 0.5 });
        let mut y = right_hand_side(n, n);
        let t = Coefficient::plain(view(&t));
        let regular = solve(Equation::Sylvester, t, t, view_mut(&mut y), &mut []);
        assert!(y.iter().all(|e| e.is_finite()));
        assert_eq!(regular, n == 1);
    }
}
