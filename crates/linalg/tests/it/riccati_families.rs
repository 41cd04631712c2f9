//! Riccati equations with solutions in closed form over the range of their conditioning: CAREX and DAREX (Benner, Laub
//! and Mehrmann, Chemnitz SPC 95_22 and 95_23; SLICOT BB01AD, BB02AD), and plants with few inputs, where others lose
//! the digits. Every error has to stay within the bound that comes with the answer.

use luenberger_linalg::{LinalgError, Riccati, care, dare, spectral_abscissa, spectral_radius};
use luenberger_random::Random;
use nalgebra::{DMatrix, dmatrix};

fn identity(n: usize) -> DMatrix<f64> {
    DMatrix::identity(n, n)
}

/// The relative error of `found`, which must not exceed its bound.
fn error(name: &str, found: &Riccati, exact: &DMatrix<f64>) -> f64 {
    let error = (&found.x - exact).norm() / exact.norm();
    assert!(error <= found.forward_error, "{name}: {error:e} > {:e}", found.forward_error);
    assert!(found.residual <= 50.0 * exact.nrows() as f64 * f64::EPSILON, "{name}: residual {:e}", found.residual);
    error
}

/// CAREX 1.1 and 1.2 and DAREX 1.1.
#[test]
fn fixed_examples() {
    let found = care(&dmatrix![0.0, 1.0; 0.0, 0.0], &dmatrix![0.0; 1.0], &dmatrix![1.0, 0.0; 0.0, 2.0], &dmatrix![1.0])
        .unwrap();
    assert!(found.forward_error <= 1e-12 && error("1.1", &found, &dmatrix![2.0, 1.0; 1.0, 2.0]) <= 1e-14);
    let (a, b) = (dmatrix![4.0, 3.0; -4.5, -3.5], dmatrix![1.0; -1.0]);
    let q = dmatrix![9.0, 6.0; 6.0, 4.0];
    let found = care(&a, &b, &q, &dmatrix![1.0]).unwrap();
    assert!(found.forward_error <= 1e-9);
    error("1.2", &found, &(&q * (1.0 + 2.0_f64.sqrt())));
    let found = dare(&a, &b, &q, &dmatrix![1.0]).unwrap();
    assert!(found.forward_error <= 1e-9);
    error("discrete 1.1", &found, &(&q * (f64::midpoint(1.0, 5.0_f64.sqrt()))));
}

/// CAREX 2.1: `A = diag(1, -2)`, an input that reaches the unstable state with strength e: X_11 = 2/e^2.
#[test]
fn a_weak_input() {
    for k in 0..=7 {
        let e = 10.0_f64.powi(-k);
        let found =
            care(&dmatrix![1.0, 0.0; 0.0, -2.0], &dmatrix![e; 0.0], &DMatrix::from_element(2, 2, 1.0), &dmatrix![1.0])
                .unwrap();
        let root = 1.0_f64.hypot(e);
        let (x11, x12) = ((1.0 + root) / (e * e), 1.0 / (2.0 + root));
        let x22 = 0.25 * (1.0 - e * e * x12 * x12);
        error(&format!("e = {e:e}"), &found, &dmatrix![x11, x12; x12, x22]);
        // The small entries, which the norm does not see, come in units of their own.
        assert!(
            (found.x[(0, 1)] - x12).abs() <= 1e-12 && (found.x[(1, 1)] - x22).abs() <= 1e-12,
            "{} {x12} {x22}",
            found.x
        );
    }
}

/// CAREX 2.3: `A = [0 e; 0 0]`, and 2.4: `A = [1+e 1; 1 1+e]`, whose closed loop nears the axis.
#[test]
fn couplings_that_vanish() {
    for k in 0..=6 {
        let e = 10.0_f64.powi(-k);
        let found = care(&dmatrix![0.0, e; 0.0, 0.0], &dmatrix![0.0; 1.0], &identity(2), &dmatrix![1.0]).unwrap();
        let root = (1.0 + 2.0 * e).sqrt();
        error(&format!("2.3, e = {e:e}"), &found, &dmatrix![root / e, 1.0; 1.0, root]);
        let a = dmatrix![1.0 + e, 1.0; 1.0, 1.0 + e];
        let found = care(&a, &identity(2), &(identity(2) * (e * e)), &identity(2)).unwrap();
        let d = 1.0 + e;
        let x11 = 0.5 * (2.0 * d + (2.0 * d * d + 2.0).sqrt() + 2.0_f64.sqrt() * e);
        let x12 = x11 / (x11 - d);
        let difference = (&found.x - dmatrix![x11, x12; x12, x11]).norm() / found.x.norm();
        assert!(difference <= found.forward_error, "2.4, e = {e:e}: {difference:e} > {:e}", found.forward_error);
    }
}

/// CAREX 3.2 (Laub): a ring of n states. X is circulant, its eigenvalues those of scalar equations.
#[test]
fn rings() {
    for n in [3_usize, 10, 30] {
        let neighbour = |i: usize, j: usize| i.abs_diff(j) == 1 || i.abs_diff(j) == n - 1;
        let a = DMatrix::from_fn(n, n, |i, j| if i == j { -2.0 } else { f64::from(u8::from(neighbour(i, j))) });
        let found = care(&a, &identity(n), &identity(n), &identity(n)).unwrap();
        // A is normal and its own transpose: 2 a x - x^2 + 1 = 0 for each eigenvalue a.
        let x = DMatrix::from_fn(n, n, |i, j| {
            (0..n)
                .map(|k| {
                    let phase = 2.0 * std::f64::consts::PI * k as f64 / n as f64;
                    let pole = -2.0 + 2.0 * phase.cos();
                    (pole + pole.hypot(1.0)) * (phase * (i as f64 - j as f64)).cos()
                })
                .sum::<f64>()
                / n as f64
        });
        assert!(found.forward_error <= 1e-8);
        error(&format!("n = {n}"), &found, &x);
    }
}

/// DAREX 2.3 (`X = diag(1, 1 + e^2)` for a coupling e) and 4.1 (a chain of n delays: `X = diag(1, .., n)` whatever R).
#[test]
fn discrete_chains() {
    for e in [1e-6, 1e-3, 1.0, 1e3, 1e6] {
        let found = dare(&dmatrix![0.0, e; 0.0, 0.0], &dmatrix![0.0; 1.0], &identity(2), &dmatrix![1.0]).unwrap();
        error(&format!("e = {e:e}"), &found, &dmatrix![1.0, 0.0; 0.0, 1.0 + e * e]);
    }
    for (n, r) in [1_usize, 5, 40].into_iter().flat_map(|n| [1e-9, 1.0, 1e9].map(|r| (n, r))) {
        let a = DMatrix::from_fn(n, n, |i, j| f64::from(u8::from(j == i + 1)));
        let b = DMatrix::from_fn(n, 1, |i, _| f64::from(u8::from(i + 1 == n)));
        let found = dare(&a, &b, &identity(n), &dmatrix![r]).unwrap();
        let exact = DMatrix::from_fn(n, n, |i, j| if i == j { (i + 1) as f64 } else { 0.0 });
        let difference = (&found.x - &exact).norm() / exact.norm();
        assert!(difference <= found.forward_error && difference <= 1e-13, "n = {n}, r = {r:e}: {difference:e}");
    }
}

/// `W D W`, W the reflection at the plane across (1, 1, 1): what CAREX 2.6 and DAREX 2.4 hide their diagonal matrices
/// behind.
fn reflected(d: [f64; 3]) -> DMatrix<f64> {
    let w = DMatrix::from_fn(3, 3, |i, j| f64::from(u8::from(i == j)) - 2.0 / 3.0);
    let d = &w * DMatrix::from_diagonal(&nalgebra::dvector![d[0], d[1], d[2]]) * w;
    (&d + d.transpose()) * 0.5
}

/// CAREX 2.6 (Petkov, Christov and Konstantinov): diagonal but for a reflection, with entries of size e, 1 and 1/e.
/// Each state has an equation `2 a x - g x^2 + q = 0` of its own.
#[test]
fn diagonal_behind_a_reflection() {
    for k in 0..=6 {
        let e = 10.0_f64.powi(k);
        let (a, q) = ([e, 2.0 * e, 3.0 * e], [1.0 / e, 1.0, e]);
        let found = care(&reflected(a), &identity(3), &reflected(q), &(identity(3) * e)).unwrap();
        let scalar = |i: usize| e * (a[i] + a[i].hypot((q[i] / e).sqrt()));
        let exact = reflected([scalar(0), scalar(1), scalar(2)]);
        let difference = (&found.x - &exact).norm() / exact.norm();
        assert!(difference <= found.forward_error && difference <= 1e-13, "e = {e:e}: {difference:e}");
    }
}

/// DAREX 2.4 (Petkov, Christov and Konstantinov): the same for the discrete equation,
/// `X = e W diag(1, (1 + sqrt 5)/2, (9 + sqrt 85)/2) W`, and DAREX 2.1: `X = (1 + sqrt(1 + 4 r))/2 Q`.
#[test]
fn discrete_families_in_closed_form() {
    for k in -6..=6 {
        let e = 10.0_f64.powi(k);
        let found = dare(&reflected([0.0, 1.0, 3.0]), &identity(3), &(identity(3) * e), &(identity(3) * e)).unwrap();
        let exact = reflected([1.0, f64::midpoint(1.0, 5.0_f64.sqrt()), f64::midpoint(9.0, 85.0_f64.sqrt())]) * e;
        error(&format!("2.4, e = {e:e}"), &found, &exact);
    }
    for k in 0..=6 {
        let r = 10.0_f64.powi(k);
        let q = dmatrix![9.0, 6.0; 6.0, 4.0];
        let found = dare(&dmatrix![4.0, 3.0; -4.5, -3.5], &dmatrix![1.0; -1.0], &q, &dmatrix![r]).unwrap();
        error(&format!("2.1, r = {r:e}"), &found, &(&q * f64::midpoint(1.0, (1.0 + 4.0 * r).sqrt())));
    }
}

/// DAREX 2.5 (Pappas, Laub and Sandell): a pole at `1 - 1/t` before three delays; `X = diag(x, 1, 1, 1)` with the x of
/// a scalar equation.
#[test]
fn a_slow_pole_before_delays() {
    for k in 0..=8 {
        let (t, r) = (10.0_f64.powi(k), 0.25);
        let (alpha, beta) = (1.0 - 1.0 / t, 1.0 / t);
        let mut a = DMatrix::from_fn(4, 4, |i, j| f64::from(u8::from(i == j + 1)));
        a[(0, 0)] = alpha;
        let q = DMatrix::from_fn(4, 4, |i, j| f64::from(u8::from(i == 3 && j == 3)));
        let found = dare(&a, &dmatrix![beta; 0.0; 0.0; 0.0], &q, &dmatrix![r]).unwrap();
        let square = beta * beta;
        let half = r * (alpha + 1.0) * (alpha - 1.0) + square;
        let x = (half + half.hypot(2.0 * beta * r.sqrt())) / (2.0 * square);
        let exact = DMatrix::from_diagonal(&nalgebra::dvector![x, 1.0, 1.0, 1.0]);
        error(&format!("t = {t:e}"), &found, &exact);
    }
}

/// CAREX 2.2 (R nears a singular matrix) and 2.8 (the closed loop nears the axis), for which nothing is published but
/// where they lead: residual, stability and definiteness.
#[test]
fn families_without_a_closed_form() {
    for k in 0..=8 {
        let e = 10.0_f64.powi(-k);
        let (a, b) = (dmatrix![-0.1, 0.0; 0.0, -0.02], dmatrix![0.1, 0.0; 0.001, 0.01]);
        let c = dmatrix![10.0, 100.0];
        let found = care(&a, &b, &c.tr_mul(&c), &dmatrix![1.0 + e, 1.0; 1.0, 1.0]).unwrap();
        // R^-1 amplifies the rounding of the gain by the condition of R.
        assert!(found.residual <= 100.0 * f64::EPSILON / e, "2.2, e = {e:e}: {:e}", found.residual);
        assert!(found.poles.iter().all(|l| l.re < 0.0) && found.x.clone().cholesky().is_some());
        let a = dmatrix![-e, 1.0, 0.0, 0.0; -1.0, -e, 0.0, 0.0; 0.0, 0.0, e, 1.0; 0.0, 0.0, -1.0, e];
        let found = care(&a, &DMatrix::from_element(4, 1, 1.0), &DMatrix::from_element(4, 4, 1.0), &dmatrix![1.0]);
        // Two pairs of poles 2 e apart, and the closed loop e from the axis: by 1e-8 that is below the root of
        // rounding, and the answer may be that it is on it.
        match found {
            Ok(found) => {
                assert!(found.residual <= 200.0 * f64::EPSILON, "2.8, e = {e:e}: {:e}", found.residual);
                assert!(found.poles.iter().all(|l| l.re < 0.0));
            }
            Err(
                LinalgError::NotStabilizing { .. }
                | LinalgError::NotStabilizable { .. }
                | LinalgError::NotWeighted { .. },
            ) => {
                assert!(k > 6, "e = {e:e}: {found:?}");
            }
            Err(other) => panic!("2.8, e = {e:e}: {other}"),
        }
    }
}

/// CAREX 3.1 (Athans, Levine and Levis; Laub): a string of vehicles, speeds and distances in turn. Behind each its
/// neighbours count alone: the gains are those of the string read backwards.
#[test]
fn strings_of_vehicles() {
    for vehicles in [2, 5, 20] {
        let n = 2 * vehicles - 1;
        let a = DMatrix::from_fn(n, n, |i, j| match (i % 2, j) {
            (0, j) if j == i => -1.0,
            (1, j) if j + 1 == i => 1.0,
            (1, j) if j == i + 1 => -1.0,
            _ => 0.0,
        });
        let b = DMatrix::from_fn(n, vehicles, |i, j| f64::from(u8::from(i == 2 * j)));
        let q = DMatrix::from_fn(n, n, |i, j| if i == j && i % 2 == 1 { 10.0 } else { 0.0 });
        let found = care(&a, &b, &q, &identity(vehicles)).unwrap();
        assert!(found.residual <= 20.0 * n as f64 * f64::EPSILON && found.poles.iter().all(|l| l.re < 0.0));
        // Reading backwards exchanges the ends of each distance, hence its sign.
        let backwards = DMatrix::from_fn(n, n, |i, j| {
            let sign = if (i + j) % 2 == 0 { 1.0 } else { -1.0 };
            sign * found.x[(n - 1 - i, n - 1 - j)]
        });
        assert!((backwards - &found.x).norm() <= 2.0 * found.forward_error * found.x.norm());
    }
}

/// CAREX 4.1 (Laub): a chain of n integrators, of which the last is driven and the first is weighted. `A - B K` has
/// Butterworth's polynomial, hence K its coefficients, and `X_1n = sqrt(q r)`.
#[test]
fn chains_of_integrators() {
    for n in [1_usize, 2, 5, 10, 21] {
        let a = DMatrix::from_fn(n, n, |i, j| f64::from(u8::from(j == i + 1)));
        let b = DMatrix::from_fn(n, 1, |i, _| f64::from(u8::from(i + 1 == n)));
        let q = DMatrix::from_fn(n, n, |i, j| f64::from(u8::from(i == 0 && j == 0)));
        let found = care(&a, &b, &q, &dmatrix![1.0]).unwrap();
        assert!(found.residual <= 50.0 * n as f64 * f64::EPSILON, "n = {n}: {:e}", found.residual);
        // The coefficients of s^k, by the ratio of neighbours.
        let angle = std::f64::consts::PI / (2 * n) as f64;
        let mut coefficient = 1.0;
        for k in 0..n {
            // K depends on X as F does on K: the bound is that of X, and K is a row of it.
            let allowed = (found.forward_error * found.x.norm()).max(100.0 * n as f64 * f64::EPSILON * coefficient);
            assert!(
                (found.k[(0, k)] - coefficient).abs() <= allowed,
                "n = {n}, k = {k}: {} {coefficient}",
                found.k[(0, k)]
            );
            coefficient *= (k as f64 * angle).cos() / ((k + 1) as f64 * angle).sin();
        }
        assert!(
            (found.x[(0, n - 1)] - 1.0).abs()
                <= (found.forward_error * found.x.norm()).max(100.0 * n as f64 * f64::EPSILON)
        );
    }
}

/// One input and n unstable states without a weight: `X^-1` is a Cauchy matrix, X and K are products, and the poles are
/// mirrored. X grows like 1e3^(n/2), beyond what its own entries can tell of its small directions, and K with its root.
#[test]
fn one_input_for_many_unstable_states() {
    let mut beyond = 0;
    for (discrete, orders) in [(false, [2_usize, 5, 8, 11, 14]), (true, [2, 4, 6, 8, 10])] {
        for n in orders {
            let b = DMatrix::from_element(n, 1, 1.0);
            let zero = DMatrix::zeros(n, n);
            let pole = |i: usize| if discrete { 1.0 + 0.5 * (i + 1) as f64 } else { (i + 1) as f64 };
            let mirrored = |i: usize| if discrete { 1.0 / pole(i) } else { -pole(i) };
            let k = DMatrix::from_fn(1, n, |_, i| {
                let factor = |j: usize| (pole(i) - mirrored(j)) / if j == i { 1.0 } else { pole(i) - pole(j) };
                (0..n).map(factor).product::<f64>()
            });
            let weight = if discrete { (0..n).map(|i| pole(i) * pole(i)).product() } else { 1.0 };
            let sum = |i: usize, j: usize| if discrete { pole(i) * pole(j) - 1.0 } else { pole(i) + pole(j) };
            let x = DMatrix::from_fn(n, n, |i, j| weight * k[i] * k[j] / sum(i, j));
            let inverse = DMatrix::from_fn(n, n, |i, j| 1.0 / sum(i, j));
            let a = DMatrix::from_fn(n, n, |i, j| if i == j { pole(i) } else { 0.0 });
            let found = if discrete { dare } else { care }(&a, &b, &zero, &dmatrix![1.0]).unwrap();
            let error = (&found.x - &x).norm() / x.norm();
            assert!(error <= found.forward_error, "n = {n}: {error:e} > {:e}", found.forward_error);
            // K is not that of the rounded X, whose small directions are lost, but as good as X where it is large.
            let error = (&found.k - &k).norm() / k.norm();
            assert!(error <= found.forward_error, "n = {n}, discrete {discrete}: K is off by {error:e}");
            assert!(found.poles.iter().all(|l| if discrete { l.norm() < 1.0 } else { l.re < 0.0 }));
            assert!(found.poles.iter().all(|l| if discrete { l.norm() < 1.0 } else { l.re < 0.0 }));
            // The coordinates of the solution are the root of X: as K is stored, its digits in them are fewer by that.
            // One pole has a sensitivity of its own on top; their sum has none.
            let root = (x.norm() * inverse.norm()).sqrt();
            let allowed = 1e3 * n as f64 * f64::EPSILON * root;
            let (sum, expected) = (found.poles.iter().map(|l| l.re).sum::<f64>(), (0..n).map(mirrored).sum::<f64>());
            assert!((sum - expected).abs() <= allowed * expected.abs(), "n = {n}: poles add to {sum} for {expected}");
            beyond += usize::from(root * root > 1.0 / f64::EPSILON);
        }
    }
    assert!(beyond >= 2, "no X beyond 1/eps: {beyond}");
}

/// The condition bounds what relative changes of A, Q and G do, and is not beside the point: some change comes within
/// three decades of it.
#[test]
fn the_condition_bounds_perturbations() {
    let mut random = Random(11);
    for (n, discrete) in [1_usize, 2, 4, 8].into_iter().flat_map(|n| [(n, false), (n, true)]) {
        let solve = |a: &DMatrix<f64>, b: &DMatrix<f64>, q: &DMatrix<f64>, r: &DMatrix<f64>| {
            if discrete { dare(a, b, q, r) } else { care(a, b, q, r) }
        };
        let (a, b) = (random.matrix(n, n), random.matrix(n, n.min(2)) + DMatrix::identity(n, n.min(2)));
        let q = identity(n) + DMatrix::from_element(n, n, 0.5);
        let r = identity(b.ncols());
        let found = solve(&a, &b, &q, &r).unwrap();
        let step = 1e-7;
        let mut largest = 0.0_f64;
        for _ in 0..10 {
            let m = random.matrix(n, n);
            let (da, dq) = (&m * (step * a.norm() / m.norm()), &m + m.transpose());
            let dq = &dq * (step * q.norm() / dq.norm());
            let changes =
                [solve(&(&a + da), &b, &q, &r), solve(&a, &b, &(&q + dq), &r), solve(&a, &b, &q, &(&r / (1.0 + step)))];
            for changed in changes {
                let change = (changed.unwrap().x - &found.x).norm() / found.x.norm();
                // Spectral against Frobenius: sqrt(n). The second order: as the step.
                let allowed = 1.01 * (n as f64).sqrt() * found.condition * step;
                assert!(change <= allowed, "n = {n}: {change:e} > {allowed:e}");
                largest = largest.max(change);
            }
        }
        assert!(largest >= 1e-3 * found.condition * step, "n = {n}: {largest:e}, condition {:e}", found.condition);
    }
}

/// Kenney and Hewer's condition in closed form. Continuous, a = 3, g = b^2/r = 4, q = 4: x = (3 + 5)/4 = 2, F = -5,
/// H0 = 1/10, H2 = x^2/10 = 2/5, so that `(H0 q + 2 sqrt(H0 H2) a + H2 g)/x = (0.4 + 1.2 + 1.6)/2`. Discrete, a = 2,
/// g = 1, q = 0: x = 3, F = 1/2, H0 = 4/3, H2 = F^2 x^2 H0 = 3, and `(0 + 2 sqrt(4) 2 + 3)/3`.
#[test]
fn the_condition_of_scalars_in_closed_form() {
    let one = |x: f64| DMatrix::from_element(1, 1, x);
    let continuous = care(&one(3.0), &one(2.0), &one(4.0), &one(1.0)).unwrap();
    let discrete = dare(&one(2.0), &one(1.0), &one(0.0), &one(1.0)).unwrap();
    for (found, x, condition) in [(continuous, 2.0, 1.6), (discrete, 3.0, 11.0 / 3.0)] {
        assert!((found.x[(0, 0)] - x).abs() <= 1e-14 * x, "{found:?}");
        assert!((found.condition - condition).abs() <= 1e-13 * condition, "{found:?}, expected {condition}");
    }
}

/// Cheap control: inputs so strong that some modes are 1e8 and more times faster than the others, which rounding throws
/// together with their mirror images about the axis.
#[test]
fn inputs_that_cost_nothing() {
    let (a, b) = (
        dmatrix![0.5, 1.0, -0.3, 0.2; -1.0, 0.4, 0.6, 0.1; 0.3, -0.2, -0.5, 1.0; 0.7, 0.1, -1.0, 0.3],
        dmatrix![1.0, 0.2; -0.5, 1.0; 0.3, 0.4; 0.1, -0.8],
    );
    for k in [0, 4, 6, 8, 9] {
        let strong = 10.0_f64.powi(k);
        let found = care(&a, &(&b * strong), &identity(4), &identity(2)).unwrap();
        assert!(found.poles.iter().all(|l| l.re < 0.0));
        // The fast modes, of size |B|, round the slow ones, on which X depends.
        assert!(found.residual <= 1e3 * f64::EPSILON * strong, "|B| = {strong:e}: {:e}", found.residual);
    }
}

/// A stable plant without a weight costs nothing.
#[test]
fn a_solution_that_is_zero() {
    let (a, b, zero) = (dmatrix![-1.0, 2.0; 0.0, -3.0], dmatrix![1.0; 1.0], DMatrix::zeros(2, 2));
    let found = care(&a, &b, &zero, &dmatrix![1.0]).unwrap();
    assert_eq!(found.x, zero);
    assert!((found.condition, found.forward_error) == (0.0, 0.0) && found.residual == 0.0);
}

/// About half of 50 states unstable, two or three inputs: X is 1e7 to 1e12 in some directions and 1 in others. The
/// stable subspace of the Hamiltonian matrix alone leaves residuals of 1e-5 to 1e-9 (as scipy's and SLICOT's solvers
/// do, and closed loops that are not stable); in the coordinates of the solution they are rounding of the gain.
#[test]
fn many_states_and_few_inputs() {
    for (seed, inputs) in [(1, 3), (2, 3), (3, 2), (4, 2)] {
        let n = 50;
        let mut random = Random(seed);
        let a = random.matrix(n, n) * (3.0 / n as f64).sqrt();
        let b = random.matrix(n, inputs);
        let found = care(&a, &b, &identity(n), &identity(inputs)).unwrap();
        assert!(spectral_abscissa(&a).unwrap() > 0.5 && spectral_abscissa(&(&a - &b * &found.k)).unwrap() < 0.0);
        // K is as large as the root of X: an X rounded entry by entry leaves n eps |K| of the equation, relative to X.
        let allowed = 10.0 * n as f64 * f64::EPSILON * found.k.norm();
        assert!(
            found.residual <= allowed,
            "{inputs} inputs: {:e} > {allowed:e}, |X| = {:e}",
            found.residual,
            found.x.norm()
        );
        assert!(found.x.clone().cholesky().is_some());
        let found = dare(&a, &b, &identity(n), &identity(inputs)).unwrap();
        assert!(found.residual <= 10.0 * n as f64 * f64::EPSILON, "{:e}", found.residual);
        assert!(spectral_radius(&(&a - &b * &found.k)).unwrap() < 1.0);
    }
}

/// Beyond what any entry of X can tell: one input for half of 50 states makes X about 1e20, and `A - B K`, formed entry
/// by entry, has lost A. In the loop, where the input is computed from the state, K stabilizes.
#[test]
fn a_gain_that_outlives_its_solution() {
    let n = 50;
    let mut random = Random(5);
    let a = random.matrix(n, n) * (3.0 / n as f64).sqrt();
    let b = random.matrix(n, 1);
    let found = dare(&a, &b, &identity(n), &identity(1)).unwrap();
    assert!(spectral_radius(&a).unwrap() > 0.8 && found.forward_error <= 1e-3);
    let found = care(&a, &b, &identity(n), &identity(1)).unwrap();
    assert!(spectral_abscissa(&a).unwrap() > 0.5 && found.x.norm() > 1.0 / f64::EPSILON);
    // The error of X costs as much as the cost itself: one that is bounded is known.
    assert!(found.forward_error <= 0.1, "{:e}", found.forward_error);
    // Twenty times the slowest time constant, by Runge and Kutta's steps well below the fastest.
    let slowest = found.poles.iter().map(|l| -l.re).fold(f64::INFINITY, f64::min);
    assert!(slowest > 0.0);
    let step = 0.2 / a.norm();
    let mut x = random.matrix(n, 1);
    let rate = |x: &DMatrix<f64>| &a * x - &b * (&found.k * x);
    let mut largest = 0.0_f64;
    for _ in 0..(20.0 / slowest / step).ceil() as usize {
        let k1 = rate(&x);
        let k2 = rate(&(&x + &k1 * (0.5 * step)));
        let k3 = rate(&(&x + &k2 * (0.5 * step)));
        let k4 = rate(&(&x + &k3 * step));
        x += (k1 + (k2 + k3) * 2.0 + k4) * (step / 6.0);
        largest = largest.max(x.norm());
    }
    // exp(-20) of the largest excursion, times what the transient of a closed loop of this order leaves.
    assert!(x.norm() <= 1e-5 * largest, "{:e} of {largest:e}", x.norm());
}
