//! Riccati equations with solutions in closed form over the range of their conditioning: CAREX and DAREX (Benner, Laub and Mehrmann, Chemnitz SPC 95_22 and 95_23; SLICOT BB01AD,
//! BB02AD), and plants with few inputs, where others lose the digits. Every error has to stay within the bound that comes with the answer.

use luenberger_linalg::{Riccati, care, dare, spectral_abscissa, spectral_radius};
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

/// CAREX 4.1 (Laub): a ring of n states. X is circulant, its eigenvalues those of scalar equations.
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

/// The condition bounds what relative changes of A, Q and G do, and is not beside the point: some change comes within three decades of it.
#[test]
fn the_condition_bounds_perturbations() {
    let mut state = 11;
    for (n, discrete) in [1_usize, 2, 4, 8].into_iter().flat_map(|n| [(n, false), (n, true)]) {
        let solve = if discrete { dare } else { care };
        let (a, b) = (random(n, n, &mut state), random(n, n.min(2), &mut state) + DMatrix::identity(n, n.min(2)));
        let q = identity(n) + DMatrix::from_element(n, n, 0.5);
        let r = identity(b.ncols());
        let found = solve(&a, &b, &q, &r).unwrap();
        let step = 1e-7;
        let mut largest = 0.0_f64;
        for _ in 0..10 {
            let m = random(n, n, &mut state);
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

/// A stable plant without a weight costs nothing.
#[test]
fn a_solution_that_is_zero() {
    let (a, b, zero) = (dmatrix![-1.0, 2.0; 0.0, -3.0], dmatrix![1.0; 1.0], DMatrix::zeros(2, 2));
    let found = care(&a, &b, &zero, &dmatrix![1.0]).unwrap();
    assert_eq!(found.x, zero);
    assert!((found.condition, found.forward_error) == (0.0, 0.0) && found.residual == 0.0);
}

/// Uniform in -1..1, by a congruential generator: the plants are the same wherever they are built.
fn random(rows: usize, cols: usize, state: &mut u64) -> DMatrix<f64> {
    DMatrix::from_fn(rows, cols, |_, _| {
        *state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (*state >> 11) as f64 / 2.0_f64.powi(52) - 1.0
    })
}

/// About half of 50 states unstable, two or three inputs: X is 1e7 to 1e12 in some directions and 1 in others. The stable subspace of the Hamiltonian matrix alone
/// leaves residuals of 1e-5 to 1e-9 (as scipy's and SLICOT's solvers do, and closed loops that are not stable); in the coordinates of the solution they are rounding of the gain.
#[test]
fn many_states_and_few_inputs() {
    for (seed, inputs) in [(1, 3), (2, 3), (3, 2), (4, 2)] {
        let n = 50;
        let mut state = seed;
        let a = random(n, n, &mut state) * (3.0 / n as f64).sqrt();
        let b = random(n, inputs, &mut state);
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
