//! Condition and error bound of a Riccati equation, computed a second time from the formulas that
//! `riccati/condition.rs` states, with its Lyapunov equations solved as linear systems by Kronecker products.

use luenberger_linalg::{Riccati, care, dare};
use nalgebra::{DMatrix, dmatrix};

/// `F'H + H F = -W`, in discrete time `F'H F - H = -W`.
fn lyapunov(f: &DMatrix<f64>, w: &DMatrix<f64>, discrete: bool) -> DMatrix<f64> {
    let n = f.nrows();
    let (one, ft) = (DMatrix::identity(n, n), f.transpose());
    let operator = if discrete {
        ft.kronecker(&ft) - DMatrix::<f64>::identity(n * n, n * n)
    } else {
        one.kronecker(&ft) + ft.kronecker(&one)
    };
    let h = operator.lu().solve(&-DMatrix::from_column_slice(n * n, 1, w.as_slice())).unwrap();
    DMatrix::from_column_slice(n, n, h.as_slice())
}

struct Problem {
    a: DMatrix<f64>,
    b: DMatrix<f64>,
    q: DMatrix<f64>,
    r: DMatrix<f64>,
    discrete: bool,
}

/// `(condition, forward error)`: norms are Frobenius'; the defect is what is reported, and its rounding error.
fn expected(p: &Problem, found: &Riccati) -> (f64, f64) {
    let Problem { a, b, q, r, discrete } = p;
    let (x, k, n) = (&found.x, &found.k, a.nrows() as f64);
    let f = a - b * k;
    let h0 = lyapunov(&f, &DMatrix::identity(a.nrows(), a.nrows()), *discrete);
    let seen = if *discrete { x * &f } else { x.clone() };
    let h2 = lyapunov(&f, &(seen.transpose() * &seen), *discrete);
    let g = b * r.clone().try_inverse().unwrap() * b.transpose();
    let (size, sensitivity) = (x.norm(), 2.0 * (h0.norm() * h2.norm()).sqrt() * a.norm());
    let condition = (h0.norm() * q.norm() + sensitivity + h2.norm() * g.norm()) / size;
    let cross = x * b * k;
    let (terms, linear, quadratic) = if *discrete {
        let cross = a.transpose() * &cross;
        (
            (a.transpose() * x * a).norm() + size + cross.norm() + q.norm(),
            (a.norm() * a.norm() + 1.0) * size + q.norm(),
            a.norm() * size * b.norm() * k.norm(),
        )
    } else {
        let linear = 2.0 * a.norm() * size + q.norm();
        (linear + cross.norm(), linear, size * b.norm() * k.norm())
    };
    let is_definite = r.clone().cholesky().is_some();
    let of_gain = if is_definite { 0.0 } else { r.norm() * k.norm().powi(2) };
    let rounding = 2.0 * n * f64::EPSILON * (linear + 2.0 * quadratic + of_gain);
    let defect = found.residual * terms + rounding;
    let bound = 2.0 * h0.norm() * defect * n.sqrt() / size;
    (condition, bound / (1.0 - bound))
}

/// Of data that are balanced as they are, and weights 1 of each input, so that the units of computation differ by
/// factors of the whole equation.
#[test]
fn condition_and_bound_are_those_of_the_formulas() {
    let a = dmatrix![0.3, 1.0; -0.8, -0.5];
    let b = dmatrix![1.0, 0.15; 0.75, -0.3];
    let q = dmatrix![1.0, 0.25; 0.25, 1.5];
    for r in [dmatrix![1.0, 0.25; 0.25, 1.0], dmatrix![1.0, 0.0; 0.0, -1.0]] {
        for discrete in [false, true] {
            let found = if discrete { dare(&a, &b, &q, &r) } else { care(&a, &b, &q, &r) }.unwrap();
            let problem = Problem { a: a.clone(), b: b.clone(), q: q.clone(), r: r.clone(), discrete };
            let (condition, bound) = expected(&problem, &found);
            assert!((found.condition / condition - 1.0).abs() < 1e-9, "{} {condition} {r} {discrete}", found.condition);
            assert!(
                (found.forward_error / bound - 1.0).abs() < 1e-9,
                "{:e} {bound:e} {r} {discrete}",
                found.forward_error
            );
        }
    }
}

/// `2 a x - g x^2 + q = 0` near the double root: with the closed loop -f, f = sqrt(a^2 + g q), `H0 = 1/(2 f)`, and the
/// existence test `4 c H0 (H0 g) <= 1` with c = 6 EPSILON or so decides between f = 1e-8 and 1e-7.
#[test]
fn a_solution_near_a_double_one_has_a_bound_while_it_is_known_to_exist() {
    let of = |f: f64| {
        // a = -1, and q g = f^2 - 1 with g = 1.
        let one = |x: f64| DMatrix::from_element(1, 1, x);
        care(&one(-1.0), &one(1.0), &one(f * f - 1.0), &one(1.0))
    };
    for f in [1e-3, 1e-5, 4e-7] {
        let found = of(f).unwrap();
        // x = a + f = f - 1; the error of x is what f is off by, EPSILON/f.
        assert!(found.forward_error.is_finite() && found.forward_error > 0.0, "{f:e}");
        assert!((found.x[(0, 0)] - (f - 1.0)).abs() <= found.forward_error * (1.0 - f), "{f:e}: {}", found.x[(0, 0)]);
    }
}
