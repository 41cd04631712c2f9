//! Condition and error bound of a Riccati equation, computed a second time from the formulas that
//! `riccati/condition.rs` states, with its Lyapunov equations solved as linear systems by Kronecker products.

use luenberger_linalg::internals::near_identity;
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

/// Multiples of the identity: the closed loop is F = f I, `H0 = h I` and `X = x I`, and all norms are known. In
/// coordinates T = x^-1/2 I the solution is I up to rounding, so that of the defect only its bounds are left: that of
/// the closed loop, `10 n eps |F|` for its Schur form, and `2 n eps` times the norms of the terms. What rounding adds
/// to them is a part of either, at most.
#[test]
fn the_bound_in_other_coordinates_is_that_of_the_formulas() {
    let eps = f64::EPSILON;
    // a, q, r, discrete; b = 1.
    let problems = [
        (15.0, 64.0, 1.0, false),
        (-0.25, 3.0, 2.0, false),
        (-5.0, 9.0, -0.5, false),
        (2.0, 11.25, 1.0, true),
        (0.5, 3.0, 4.0, true),
        (-1.5, 0.5, 1.0, true),
        (0.75, 0.25, -8.0, true),
    ];
    for (a, q, r, discrete) in problems {
        for n in [1, 3] {
            let (order, one) = (n as f64, DMatrix::<f64>::identity(n, n));
            let root = order.sqrt();
            let found = near_identity(&(&one * a), &one, &(&one * q), &(&one * r), discrete).unwrap().unwrap();
            // x^2/r - 2 a x - q = 0; x^2 + (r - a^2 r - q) x - q r = 0.
            let (half, product) = if discrete { (0.5 * (a * a * r + q - r), q * r) } else { (a * r, q * r) };
            let spread = (half * half + product).sqrt();
            let gain = |x: f64| if discrete { a * x / (r + x) } else { x / r };
            let stable = |x: f64| if discrete { (a - gain(x)).abs() < 1.0 } else { a < gain(x) };
            let x = if stable(half + spread) { half + spread } else { half - spread };
            let k = gain(x);
            assert!((found.x[(0, 0)] / x - 1.0).abs() < 1e-13, "{a} {q} {r} {discrete}: {} {x}", found.x[(0, 0)]);
            let f = a - k;
            let (h, steps, linear) = if discrete {
                (1.0 / (1.0 - f * f), 2.0 * f.abs() * root, (order * f * f + 1.0) * root)
            } else {
                (-0.5 / f, 2.0, 2.0 * order * f.abs())
            };
            // T'Q T + K'R K of the equation F'+ F + .. = 0, F'F - I + .. = 0.
            let weight = if discrete { 1.0 - f * f } else { -2.0 * f };
            let of_gain = if r > 0.0 { 0.0 } else { root * order * r.abs() * k * k / x };
            let terms = linear + root * weight + order * root * q / x + of_gain;
            let unknown = 10.0 * order * eps * root * f.abs();
            let defect = steps * unknown * root + 2.0 * order * eps * terms;
            let bound = 2.0 * root * h * defect + 2.0 * order * eps * order;
            // Of the terms of the defect and of the gain, each is rounded to eps once or twice.
            let rounding = 2.0 * root * h * 2.0 * eps * root * (linear.max(weight) + f.abs() * steps);
            let least = bound * (1.0 - 1e-9);
            assert!(
                found.forward_error >= least && found.forward_error <= bound + rounding,
                "{a} {q} {r} {discrete} {n}: {:e} for {bound:e} to {:e}",
                found.forward_error,
                bound + rounding
            );
            // |H0| |Q| + 2 sqrt(|H0| |H2|) |A| + |H2| |G|, relative to |X|, with the seen X or X F in H2.
            let h2 = h * x * x * if discrete { f * f } else { 1.0 };
            let condition = root * (h * q.abs() + 2.0 * (h * h2).sqrt() * a.abs() + h2 / r.abs()) / x;
            assert!((found.condition / condition - 1.0).abs() < 1e-9, "{} for {condition}", found.condition);
        }
    }
}

/// With an indefinite R the Lyapunov solution is enlarged by `1/(1 - s e |H0|)`, for the rounding `e = 2 (n + m) eps
/// (|A| + |B| |K|)` of the closed loop and s = 2, `2 (|A| + |B| |K|)` in discrete time: near a double root this is seen
/// in the seventh digit.
#[test]
fn an_indefinite_weight_pays_for_the_rounding_of_its_closed_loop() {
    let one = |x: f64| DMatrix::from_element(1, 1, x);
    // a x^2 + 2 b x + c = 0 by hand: with r = -1, x = -a - f and the closed loop a + x = -f; in discrete time from f.
    for discrete in [false, true] {
        let (a, f) = (0.75, 3e-6);
        let (q, r) = if discrete { (0.0, -1.0) } else { (a * a - f * f, -1.0) };
        let found = if discrete {
            // f = a r/(r + x) with f = 1 - 3e-6, and x (1 - a f) = q.
            let f = 1.0 - f;
            let x = a * r / f - r;
            dare(&one(a), &one(1.0), &one(x * (1.0 - a * f)), &one(r))
        } else {
            care(&one(a), &one(1.0), &one(q), &one(r))
        }
        .unwrap();
        let (x, k) = (found.x[(0, 0)], found.k[(0, 0)]);
        let closed = a - k;
        let h0 = if discrete { 1.0 / ((1.0 - closed) * (1.0 + closed)) } else { -0.5 / closed };
        let sizes = a + k.abs();
        let unknown = 2.0 * 2.0 * f64::EPSILON * sizes;
        let factor = 1.0 / (1.0 - if discrete { 2.0 * sizes } else { 2.0 } * unknown * h0);
        let q = if discrete { x * (1.0 - a * closed) } else { q };
        let problem = Problem { a: one(a), b: one(1.0), q: one(q), r: one(r), discrete };
        let (_, plain) = expected(&problem, &found);
        // Of the exact solution, from that of the one found, and back.
        let bound = plain / (1.0 + plain) * factor;
        let bound = bound / (1.0 - bound);
        let digits = (found.forward_error / bound - 1.0).abs() / (factor - 1.0);
        assert!(digits < 0.02, "{discrete}: {:e} for {bound:e}, factor {factor}", found.forward_error);
    }
}
