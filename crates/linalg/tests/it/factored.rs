//! Lyapunov and Stein equations by the factor of the solution; the generalised equation.

use luenberger_linalg::{LinalgError, generalized_lyapunov, lyapunov, lyapunov_factor, stein, stein_factor};
use nalgebra::{DMatrix, dmatrix};
use proptest::prelude::*;

/// A Schur form, a congruence and two QR factorisations, each good to a small multiple of n eps.
fn bound(n: usize) -> f64 {
    60.0 * n.max(1) as f64 * f64::EPSILON
}

fn entries(n: usize, m: usize) -> impl Strategy<Value = DMatrix<f64>> {
    prop::collection::vec(-1.0..1.0_f64, n * m).prop_map(move |data| DMatrix::from_row_slice(n, m, &data))
}

/// `(A, C)` with A Hurwitz by a shift, C with one to n rows.
fn stable_pair() -> impl Strategy<Value = (DMatrix<f64>, DMatrix<f64>)> {
    (1..=8_usize, 1..=8_usize).prop_flat_map(|(n, p)| (entries(n, n), entries(p, n), 0.01..2.0_f64)).prop_map(
        |(a, c, margin)| {
            let n = a.nrows();
            (&a - DMatrix::identity(n, n) * (a.norm() + margin), c)
        },
    )
}

fn is_factor(u: &DMatrix<f64>) -> bool {
    (0..u.ncols()).all(|j| u[(j, j)] >= 0.0 && (j + 1..u.nrows()).all(|i| u[(i, j)] == 0.0))
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(64))]

    /// `U'U` is the solution that the other method finds, in any units.
    #[test]
    fn the_factor_squares_to_the_solution((a, c) in stable_pair(), (da, dc) in (-100..100_i32, -60..60_i32)) {
        let n = a.nrows();
        let found = lyapunov_factor(&a, &c).unwrap();
        prop_assert!(is_factor(&found.u) && found.residual <= bound(n), "{:e}", found.residual);
        let whole = lyapunov(&a, &c.tr_mul(&c)).unwrap();
        prop_assert!((found.p() - &whole.p).norm() <= bound(n) * whole.condition * whole.p.norm());
        let (ua, uc) = (10.0_f64.powi(da), 10.0_f64.powi(dc));
        let scaled = lyapunov_factor(&(&a * ua), &(&c * uc)).unwrap().u * (ua.sqrt() / uc);
        prop_assert!((scaled.tr_mul(&scaled) - &whole.p).norm() <= 2.0 * bound(n) * whole.condition * whole.p.norm());

        let discrete = &a * (0.95 / a.norm());
        let found = stein_factor(&discrete, &c).unwrap();
        prop_assert!(is_factor(&found.u) && found.residual <= bound(n), "{:e}", found.residual);
        let whole = stein(&discrete, &c.tr_mul(&c)).unwrap();
        prop_assert!((found.p() - &whole.p).norm() <= bound(n) * whole.condition * whole.p.norm());
    }

    /// A descriptor plant: the equation holds, and E = I is the ordinary one.
    #[test]
    fn the_generalized_equation_holds((a, e, q) in (1..=6_usize).prop_flat_map(|n| (entries(n, n), entries(n, n), entries(n, n)))) {
        let n = a.nrows();
        let e = DMatrix::identity(n, n) * (1.5 * n as f64) + e;
        let a = (&a - DMatrix::identity(n, n) * (a.norm() + 0.1)) * &e;
        let q = &q + q.transpose();
        let found = generalized_lyapunov(&a, &e, &q).unwrap();
        prop_assert!(found.residual <= bound(n) * found.condition_e, "{:e}", found.residual);
        let defect = a.transpose() * &found.p * &e + e.transpose() * &found.p * &a + &q;
        prop_assert!(defect.norm() <= 2.0 * bound(n) * found.condition_e * (2.0 * a.norm() * e.norm() * found.p.norm() + q.norm()));
    }
}

/// P has singular values down to 1e-24 of the largest, which no matrix P in binary64 can hold in general coordinates;
/// its factor does.
#[test]
fn directions_that_are_hardly_seen_keep_their_digits() {
    let n = 4;
    let h = DMatrix::from_fn(n, n, |i, j| f64::from(u8::from(i == j)) - 0.5);
    let rates = [1.0, 2.0, 3.0, 4.0];
    let seen = [1.0, 1e-4, 1e-8, 1e-12];
    let a = &h * DMatrix::from_fn(n, n, |i, j| if i == j { -rates[i] } else { 0.0 }) * &h;
    // H is symmetric and orthogonal, and exact in binary64: so is C = D H.
    let c = DMatrix::from_fn(n, n, |i, j| seen[i] * h[(i, j)]);
    let u = lyapunov_factor(&a, &c).unwrap().u;
    let mut sigma: Vec<f64> = u.singular_values().iter().copied().collect();
    sigma.sort_by(|x, y| y.total_cmp(x));
    for (k, s) in sigma.iter().enumerate() {
        let exact = seen[k] / (2.0 * rates[k]).sqrt();
        // Absolute errors are n eps times the largest: twelve decades below, four digits are left.
        assert!((s - exact).abs() <= bound(n), "{s:e} {exact:e}");
    }
    assert!((sigma[3] / (1e-12 / 8.0_f64.sqrt()) - 1.0).abs() < 0.2);
    // Beside it: P itself has lost the last two directions.
    let p = lyapunov(&a, &c.tr_mul(&c)).unwrap().p;
    assert!(p.symmetric_eigenvalues().min().abs() > 1e-22);
}

#[test]
fn what_is_not_seen_at_all_is_zero() {
    // The second state is invisible: its column of U is zero.
    let found = lyapunov_factor(&dmatrix![-1.0, 0.0; 0.0, -2.0], &dmatrix![1.0, 0.0]).unwrap();
    assert_eq!(found.u[(0, 1)], 0.0);
    assert_eq!(found.u[(1, 1)], 0.0);
    let none = lyapunov_factor(&dmatrix![-1.0, 3.0; 0.0, -2.0], &DMatrix::zeros(0, 2)).unwrap();
    assert_eq!(none.u, DMatrix::zeros(2, 2));
    assert_eq!(lyapunov_factor(&DMatrix::zeros(0, 0), &DMatrix::zeros(1, 0)).unwrap().u.shape(), (0, 0));
}

#[test]
fn what_cannot_be_factored_is_named() {
    let c = dmatrix![1.0, 1.0];
    for (a, worst) in [(dmatrix![1.0, 0.0; 0.0, -2.0], 1.0), (dmatrix![0.0, 1.0; -1.0, 0.0], 0.0)] {
        let Err(LinalgError::NotStable { equation: "Lyapunov", eigenvalue }) = lyapunov_factor(&a, &c) else {
            panic!("{a} is not Hurwitz")
        };
        assert_eq!(eigenvalue.re, worst);
    }
    assert!(matches!(
        stein_factor(&dmatrix![0.5, 0.0; 0.0, 1.0], &c),
        Err(LinalgError::NotStable { equation: "Stein", .. })
    ));
    assert!(matches!(lyapunov_factor(&dmatrix![-1.0], &c), Err(LinalgError::DimensionMismatch { what: "C", .. })));
    assert!(matches!(
        lyapunov_factor(&dmatrix![f64::NAN], &dmatrix![1.0]),
        Err(LinalgError::NotFinite { what: "A", .. })
    ));
    assert!(matches!(
        stein_factor(&dmatrix![0.5], &dmatrix![f64::INFINITY]),
        Err(LinalgError::NotFinite { what: "C", .. })
    ));
    let (a, one) = (dmatrix![-1.0, 0.0; 0.0, -1.0], DMatrix::identity(2, 2));
    let singular = dmatrix![1.0, 1.0; 1.0, 1.0];
    assert!(matches!(generalized_lyapunov(&a, &singular, &one), Err(LinalgError::Singular { what: "E", .. })));
    assert!(matches!(
        generalized_lyapunov(&a, &dmatrix![1.0], &one),
        Err(LinalgError::DimensionMismatch { what: "E", .. })
    ));
}
