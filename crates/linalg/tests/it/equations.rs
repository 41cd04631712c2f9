//! Lyapunov, Stein and Sylvester equations, continuous and discrete: residuals, Kronecker products, published examples,
//! and singular data.

use approx::assert_abs_diff_eq;
use luenberger_linalg::{
    LinalgError, LyapunovEquation, discrete_sylvester, generalized_stein, lyapunov, stein, sylvester,
};
use nalgebra::{Complex, DMatrix, DVector, dmatrix};
use proptest::prelude::*;

/// Schur form, two orthogonal transformations each way and a substitution: the residual is a small multiple of `n eps`.
fn bound(n: usize) -> f64 {
    30.0 * n.max(1) as f64 * f64::EPSILON
}

/// `vec` of the solution of a linear matrix equation, by Gaussian elimination on its n m x n m matrix.
fn by_kronecker(operator: &DMatrix<f64>, c: &DMatrix<f64>) -> DMatrix<f64> {
    let rhs = DVector::from_column_slice(c.as_slice());
    let x = operator.clone().lu().solve(&rhs).unwrap();
    DMatrix::from_column_slice(c.nrows(), c.ncols(), x.as_slice())
}

fn identity(n: usize) -> DMatrix<f64> {
    DMatrix::identity(n, n)
}

fn entries(n: usize, m: usize) -> impl Strategy<Value = DMatrix<f64>> {
    prop::collection::vec(-1.0..1.0_f64, n * m).prop_map(move |data| DMatrix::from_row_slice(n, m, &data))
}

/// `A - (||A|| + margin) I`: every such matrix is Hurwitz, its eigenvalues left of `-margin`.
fn hurwitz(n: usize) -> impl Strategy<Value = DMatrix<f64>> {
    (entries(n, n), 0.01..2.0_f64).prop_map(move |(a, margin)| &a - identity(n) * (a.norm() + margin))
}

/// `rho A / ||A||`: every such matrix is Schur stable. Its rank may be less than full.
fn schur_stable(n: usize) -> impl Strategy<Value = DMatrix<f64>> {
    (entries(n, n), 0.01..0.99_f64, any::<bool>()).prop_map(|(a, rho, singular)| {
        let mut a = &a * (rho / a.norm());
        if singular {
            a.column_mut(0).fill(0.0);
        }
        a
    })
}

fn symmetric(n: usize) -> impl Strategy<Value = DMatrix<f64>> {
    entries(n, n).prop_map(|m| &m + m.transpose())
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(64))]

    /// For Hurwitz A the equation has one solution, symmetric, and definite with Q.
    #[test]
    fn lyapunov_agrees_with_kronecker(
        (a, q) in (1..=6_usize).prop_flat_map(|n| (hurwitz(n), symmetric(n))),
        (da, dq) in (-140..140_i32, -140..140_i32),
    ) {
        let n = a.nrows();
        let found = lyapunov(&a, &q).unwrap();
        prop_assert!(found.residual <= bound(n), "{:e}", found.residual);
        prop_assert_eq!(&found.p, &found.p.transpose());
        let at = a.transpose();
        let operator = identity(n).kronecker(&at) + at.kronecker(&identity(n));
        let p = by_kronecker(&operator, &-&q);
        prop_assert!((&found.p - &p).norm() <= bound(n) * found.condition * p.norm(), "{} {p}", found.p);
        // The estimate of the separation is never below it, up to rounding, in any norm equivalence: sigma_min <= sep_1
        // sqrt(N).
        let sigma = operator.singular_values().min();
        prop_assert!(found.separation >= sigma / (n as f64) * (1.0 - bound(n) * found.condition));
        prop_assert!(found.separation <= 3.0 * sigma * n as f64);
        // In other units: the same digits.
        let (ua, uq) = (10.0_f64.powi(da), 10.0_f64.powi(dq));
        let scaled = lyapunov(&(&a * ua), &(&q * uq)).unwrap();
        prop_assert!(scaled.residual <= bound(n));
        prop_assert!((scaled.p / uq * ua - &found.p).norm() <= bound(n) * found.condition * p.norm());
    }

    /// Lyapunov's theorem: A Hurwitz and Q > 0 give P > 0.
    #[test]
    fn a_hurwitz_matrix_has_a_positive_definite_lyapunov_matrix(
        (a, q) in (1..=8_usize).prop_flat_map(|n| (hurwitz(n), entries(n, n))),
    ) {
        let n = a.nrows();
        let q = &q * q.transpose() + identity(n);
        let found = lyapunov(&a, &q).unwrap();
        prop_assert!(found.p.cholesky().is_some());
    }

    #[test]
    fn stein_agrees_with_kronecker(
        (a, q) in (1..=6_usize).prop_flat_map(|n| (schur_stable(n), symmetric(n))),
        dq in -140..140_i32,
    ) {
        let n = a.nrows();
        let found = stein(&a, &q).unwrap();
        prop_assert!(found.residual <= bound(n), "{:e}", found.residual);
        prop_assert_eq!(&found.p, &found.p.transpose());
        let at = a.transpose();
        let p = by_kronecker(&(at.kronecker(&at) - identity(n * n)), &-&q);
        prop_assert!((&found.p - &p).norm() <= bound(n) * found.condition * p.norm());
        let uq = 10.0_f64.powi(dq);
        let scaled = stein(&a, &(&q * uq)).unwrap();
        prop_assert!((scaled.p / uq - &found.p).norm() <= bound(n) * found.condition * p.norm());
    }

    #[test]
    fn sylvester_agrees_with_kronecker(
        (a, b, c) in (1..=6_usize, 1..=6_usize).prop_flat_map(|(n, m)| (hurwitz(n), hurwitz(m), entries(n, m))),
        du in -140..140_i32,
    ) {
        let (n, m) = c.shape();
        let found = sylvester(&a, &b, &c).unwrap();
        prop_assert!(found.residual <= bound(n.max(m)), "{:e}", found.residual);
        let operator = identity(m).kronecker(&a) + b.transpose().kronecker(&identity(n));
        let x = by_kronecker(&operator, &c);
        prop_assert!((&found.x - &x).norm() <= bound(n.max(m)) * found.condition * x.norm());
        let u = 10.0_f64.powi(du);
        let scaled = sylvester(&(&a * u), &(&b * u), &c).unwrap();
        prop_assert!((scaled.x * u - &found.x).norm() <= bound(n.max(m)) * found.condition * x.norm());
    }

    /// For Schur stable coefficients the solution is unique; what A has too much and B too little changes nothing.
    #[test]
    fn discrete_sylvester_agrees_with_kronecker(
        (a, b, c) in (1..=6_usize, 1..=6_usize).prop_flat_map(|(n, m)| (schur_stable(n), schur_stable(m), entries(n, m))),
        (du, dc) in (-140..140_i32, -140..140_i32),
    ) {
        let (n, m) = c.shape();
        let found = discrete_sylvester(&a, &b, &c).unwrap();
        prop_assert!(found.residual <= bound(n.max(m)), "{:e}", found.residual);
        let operator = b.transpose().kronecker(&a) - identity(n * m);
        let x = by_kronecker(&operator, &-&c);
        prop_assert!((&found.x - &x).norm() <= bound(n.max(m)) * found.condition * x.norm());
        // ||Z||_2 <= ||Z||_1 <= sqrt(nm) ||Z||_2 for the entries of Z: the separation in the sum of the entries is
        // within that factor of the smallest singular value, and the estimate is not below it up to rounding.
        let (sigma, order) = (operator.singular_values().min(), ((n * m) as f64).sqrt());
        prop_assert!(found.separation >= sigma / order * (1.0 - bound(n.max(m)) * found.condition));
        prop_assert!(found.separation <= 10.0 * sigma * order, "{:e} {sigma:e}", found.separation);
        let (u, v) = (10.0_f64.powi(du), 10.0_f64.powi(dc));
        let scaled = discrete_sylvester(&(&a * u), &(&b / u), &(&c * v)).unwrap();
        prop_assert!((scaled.x / v - &found.x).norm() <= bound(n.max(m)) * found.condition * x.norm());
    }

    /// With `A'` and A for coefficients and a symmetric C it is Stein's equation; with E for a coefficient of P, the
    /// generalised one.
    #[test]
    fn the_discrete_equations_agree((a, q) in (1..=6_usize).prop_flat_map(|n| (schur_stable(n), symmetric(n)))) {
        let n = a.nrows();
        let stein = stein(&a, &q).unwrap();
        let found = discrete_sylvester(&a.transpose(), &a, &q).unwrap();
        let allowed = (found.forward_error() + stein.forward_error()) * stein.p.norm();
        prop_assert!((&found.x - &stein.p).norm() <= allowed);
        let e = DMatrix::from_fn(n, n, |i, j| 0.5 * (f64::from(u8::from(i == j)) + f64::from(u8::from(i <= j))));
        let found = generalized_stein(&(&a * &e), &e, &(e.transpose() * &q * &e)).unwrap();
        // The defect of the standard equation, between E' and E.
        prop_assert!(found.residual <= found.condition_e.powi(2).max(1.0) * bound(n), "{:e}", found.residual);
        // The data are rounded once more: each of the products by E to n eps, and E^-1 brings them back.
        let rounding = 10.0 * n as f64 * f64::EPSILON * found.condition_e * found.condition_e * stein.condition;
        let allowed = (found.forward_error() + stein.forward_error() + rounding) * stein.p.norm();
        prop_assert!((&found.p - &stein.p).norm() <= allowed, "{:e} > {allowed:e}", (&found.p - &stein.p).norm());
    }
}

/// The exact solution of `op x = rhs` in rationals, `(numerators, denominator)`, by fraction-free elimination
/// (Bareiss): every number on the way is a minor of the matrix, an integer. `None` for a singular one.
fn in_rationals(operator: Vec<Vec<i128>>, rhs: Vec<i128>) -> Option<(Vec<i128>, i128)> {
    let n = rhs.len();
    let mut rows: Vec<Vec<i128>> = operator
        .into_iter()
        .zip(rhs)
        .map(|(mut row, b)| {
            row.push(b);
            row
        })
        .collect();
    let mut previous = 1;
    for k in 0..n {
        let pivot = (k..n).find(|&i| rows[i][k] != 0)?;
        rows.swap(k, pivot);
        let top = rows[k].clone();
        for (i, row) in rows.iter_mut().enumerate() {
            if i == k {
                continue;
            }
            let factor = row[k];
            for (entry, above) in row.iter_mut().zip(&top) {
                *entry = (*entry * top[k] - factor * above) / previous;
            }
        }
        previous = top[k];
    }
    Some((rows.iter().map(|row| row[n]).collect(), previous))
}

fn quarters(n: usize, m: usize) -> impl Strategy<Value = DMatrix<i128>> {
    prop::collection::vec(-3..=3_i128, n * m).prop_map(move |data| DMatrix::from_vec(n, m, data))
}

/// Up to order six, ten unknowns at most: minors of order ten of rows of norm below 40 are below 2^54, and products of
/// two fit.
fn shapes() -> impl Strategy<Value = (usize, usize)> {
    prop::sample::select(vec![(1, 1), (1, 6), (6, 1), (2, 2), (2, 3), (3, 2), (3, 3), (2, 5), (5, 2), (2, 4), (4, 2)])
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(256))]

    /// The error of both kinds against the rational solution of the Kronecker system; and an exactly singular equation
    /// is refused, or without a bound. Entries are multiples of 1/4, small ones: some one in ten is singular.
    #[test]
    fn errors_against_the_exact_solution(
        (a, b, c) in shapes().prop_flat_map(|(n, m)| (quarters(n, n), quarters(m, m), quarters(n, m))),
        discrete in any::<bool>(),
    ) {
        let (n, m) = c.shape();
        let float = |m: &DMatrix<i128>| m.map(|v| v as f64 / 4.0);
        // vec by columns, everything times 16, or 4.
        let operator = (0..n * m).map(|r| {
            let (i, j) = (r % n, r / n);
            (0..n * m).map(|s| {
                let (k, l) = (s % n, s / n);
                let one = |x: bool| i128::from(x);
                if discrete { a[(i, k)] * b[(l, j)] - 16 * one(r == s) } else { a[(i, k)] * one(j == l) + b[(l, j)] * one(i == k) }
            }).collect()
        }).collect();
        // A X B - X = -C times 16, the entries of C being c/4; A X + X B = C times 4.
        let rhs = c.iter().map(|&c| if discrete { -4 * c } else { c }).collect();
        let exact = in_rationals(operator, rhs).map(|(numerators, denominator)| {
            DMatrix::from_iterator(n, m, numerators.iter().map(|&x| x as f64 / denominator as f64))
        });
        let found = if discrete {
            discrete_sylvester(&float(&a), &float(&b), &float(&c)).map(|found| (found.forward_error(), found.x))
        } else {
            sylvester(&float(&a), &float(&b), &float(&c)).map(|found| (found.forward_error(), found.x))
        };
        match (found, exact) {
            (Ok((bound, x)), Some(exact)) => {
                // The exact solution is rounded three times.
                let allowed = (bound + 2.0 * f64::EPSILON) * exact.norm();
                prop_assert!((&x - &exact).norm() <= allowed, "{:e} > {allowed:e}", (&x - &exact).norm());
            }
            (Ok((bound, _)), None) => prop_assert!(bound == f64::INFINITY, "singular, and bounded by {bound:e}"),
            (Err(LinalgError::SingularEquation { .. }), None) => {}
            // A regular one only where it is within rounding of a singular one, norms being below 10 and orders below
            // 7.
            (Err(LinalgError::UndecidedEquation { regular: true, separation, .. }), Some(_)) => prop_assert!(separation <= 1e-13, "{separation:e}"),
            (Err(error), _) => prop_assert!(false, "{error}"),
        }
    }
}

#[test]
fn larger_orders_keep_the_residual_small() {
    for n in [20, 41, 80] {
        let entry = |i: usize, j: usize| ((1 + 31 * i + 17 * j * j + i * i * j) as f64).sin();
        let a = DMatrix::from_fn(n, n, entry);
        let q = DMatrix::from_fn(n, n, |i, j| entry(i.min(j) + 3, i.max(j)));
        // Indefinite Q and an unstable A are allowed; only sums of eigenvalues matter.
        assert!(lyapunov(&a, &q).unwrap().residual <= bound(n));
        let half = &a * (0.9 / a.norm());
        assert!(stein(&half, &q).unwrap().residual <= bound(n));
        let b = DMatrix::from_fn(n / 2, n / 2, |i, j| entry(i + 5, j + 2)) + identity(n / 2) * 3.0;
        let c = DMatrix::from_fn(n, n / 2, entry);
        assert!(sylvester(&a, &b, &c).unwrap().residual <= bound(n));
        // Spectral radii of about one: nothing definite.
        let found =
            discrete_sylvester(&(&a * (1.3 / (n as f64).sqrt())), &(&b * (1.1 / (n as f64).sqrt())), &c).unwrap();
        assert!(found.residual <= bound(n));
    }
}

/// Quasi-triangular coefficients and one entry on the right: rows below and columns left of it stay zero, but for the
/// partner of a complex pair, and the solutions add up to that for the sum.
#[test]
fn a_right_hand_side_of_one_entry() {
    let a = dmatrix![
        0.5, 1.0, -2.0, 0.25;
        0.0, 0.3, 0.4, 1.0;
        0.0, -0.9, 0.3, 2.0;
        0.0, 0.0, 0.0, 0.75
    ];
    let b = dmatrix![0.25, 0.5, 1.0; -0.5, 0.25, -1.0; 0.0, 0.0, 0.625];
    let (first_row, last_column) = ([0, 1, 1, 3], [0, 0, 2]);
    for discrete in [false, true] {
        let solve = |c: &DMatrix<f64>| {
            if discrete {
                discrete_sylvester(&a, &b, c).map(|found| (found.x, found.residual)).unwrap()
            } else {
                sylvester(&a, &b, c).map(|found| (found.x, found.residual)).unwrap()
            }
        };
        let mut sum = DMatrix::zeros(4, 3);
        for (i, j) in (0..4).flat_map(|i| (0..3).map(move |j| (i, j))) {
            let (x, residual) = solve(&DMatrix::from_fn(4, 3, |k, l| f64::from(u8::from((k, l) == (i, j)))));
            assert!(residual <= bound(4));
            for (k, l) in (0..4).flat_map(|k| (0..3).map(move |l| (k, l))) {
                // One of a block's two rows sees the other.
                let reached = first_row[k] <= i && l >= last_column[j];
                assert!(reached || x[(k, l)].abs() <= bound(4), "({i}, {j}) -> ({k}, {l})");
            }
            sum += x;
        }
        // Eigenvalues add to more than 0.5 and multiply to less than 0.5, couplings of two: condition below 1e3.
        let (whole, _) = solve(&DMatrix::from_element(4, 3, 1.0));
        assert!((sum - &whole).norm() <= 1e3 * bound(4) * whole.norm());
        assert_eq!(solve(&DMatrix::zeros(4, 3)), (DMatrix::zeros(4, 3), 0.0));
    }
}

#[test]
fn slicot_sb03md() {
    // Example program data and results of SLICOT routine SB03MD: discrete, A'X A - X = C, no transposition.
    let a = dmatrix![3.0, 1.0, 1.0; 1.0, 3.0, 0.0; 0.0, 0.0, 3.0];
    let c = dmatrix![25.0, 24.0, 15.0; 24.0, 32.0, 8.0; 15.0, 8.0, 40.0];
    let found = stein(&a, &-c).unwrap();
    let printed = dmatrix![2.0, 1.0, 1.0; 1.0, 3.0, 0.0; 1.0, 0.0, 4.0];
    assert!((found.p - printed).amax() <= 10.0 * f64::EPSILON * found.condition);
}

#[test]
fn slicot_sb03qd() {
    // Example program data and results of SLICOT routine SB03QD: continuous, A'X + X A = C, four decimals printed.
    let a = dmatrix![3.0, 1.0, 1.0; 1.0, 3.0, 0.0; 0.0, 0.0, 3.0];
    let c = dmatrix![25.0, 24.0, 15.0; 24.0, 32.0, 8.0; 15.0, 8.0, 40.0];
    let found = lyapunov(&a, &-c).unwrap();
    let printed = dmatrix![3.2604, 2.7187, 1.8616; 2.7187, 4.4271, 0.5699; 1.8616, 0.5699, 6.0461];
    assert_abs_diff_eq!(found.p, printed, epsilon = 0.5001e-4);
    // "Estimated separation = 4.9068", an estimate too, and restricted to symmetric matrices.
    assert!((4.9068 / 3.0..4.9068 * 1.001).contains(&found.separation), "{}", found.separation);
}

#[test]
fn slicot_sb04md_and_sb04qd() {
    // SB04MD solves A X + X B = C; four decimals printed.
    let a = dmatrix![2.0, 1.0, 3.0; 0.0, 2.0, 1.0; 6.0, 1.0, 2.0];
    let b = dmatrix![2.0, 1.0; 1.0, 6.0];
    let c = dmatrix![2.0, 1.0; 1.0, 4.0; 0.0, 5.0];
    let printed = dmatrix![-2.7685, 0.5498; -1.0531, 0.6865; 4.5257, -0.4389];
    assert_abs_diff_eq!(sylvester(&a, &b, &c).unwrap().x, printed, epsilon = 0.5001e-4);
    // SB04QD solves X + A X B = C, which is A X + X B^-1 = C B^-1, and the discrete equation with -A.
    let a = dmatrix![1.0, 2.0, 3.0; 6.0, 7.0, 8.0; 9.0, 2.0, 3.0];
    let b = dmatrix![7.0, 2.0, 3.0; 2.0, 1.0, 2.0; 3.0, 4.0, 1.0];
    let c = dmatrix![271.0, 135.0, 147.0; 923.0, 494.0, 482.0; 578.0, 383.0, 287.0];
    let inverse = b.clone().try_inverse().unwrap();
    let found = sylvester(&a, &inverse, &(&c * &inverse)).unwrap();
    let printed = dmatrix![2.0, 3.0, 6.0; 4.0, 7.0, 1.0; 5.0, 3.0, 2.0];
    assert!((found.x - &printed).amax() <= 100.0 * f64::EPSILON * found.condition);
    // What is printed is exact.
    assert_eq!(&printed + &a * &printed * &b, c);
    let found = discrete_sylvester(&-a, &b, &c).unwrap();
    assert!((&found.x - &printed).norm() <= found.forward_error() * printed.norm() && found.forward_error() <= 1e-10);
}

#[test]
fn eigenvalues_that_meet_are_named() {
    // +-2i on the axis: they add to zero.
    let a = dmatrix![0.0, 2.0, 0.0; -2.0, 0.0, 1.0; 0.0, 0.0, -1.0];
    let Err(LinalgError::SingularEquation { equation, first, second, gap }) = lyapunov(&a, &identity(3)) else {
        panic!("singular")
    };
    assert_eq!(equation, "Lyapunov");
    assert!((first + second).norm() <= bound(3) && (first.im.abs() - 2.0).abs() <= bound(3));
    assert!(gap <= bound(3));
    // 0.5 and 2 multiply to one.
    let a = dmatrix![0.5, 1.0; 0.0, 2.0];
    let found = stein(&a, &identity(2));
    assert!(matches!(found, Err(LinalgError::SingularEquation { equation: "Stein", gap: 0.0, .. })), "{found:?}");
    let found = sylvester(&dmatrix![3.0e9], &dmatrix![-3.0e9], &dmatrix![1.0]);
    let (first, second) = (Complex::new(3.0e9, 0.0), Complex::new(-3.0e9, 0.0));
    assert!(matches!(found, Err(LinalgError::SingularEquation { equation: "Sylvester", first: f, second: s, .. })
            if (f - first).norm() <= 1.0 && (s - second).norm() <= 1.0));
    // 2i and its conjugate, and -i/2 and its: in units far apart, rounded.
    let (a, b) =
        (dmatrix![0.0, -2.0; 2.0, 0.0] * 1e200, dmatrix![0.0, 0.5, 1.0; -0.5, 0.0, 1.0; 0.0, 0.0, 3.0] * 1e-200);
    let found = discrete_sylvester(&a, &b, &DMatrix::zeros(2, 3));
    let Err(LinalgError::UndecidedEquation { equation: "discrete Sylvester", first, second, gap, separation, .. }) =
        found
    else {
        panic!("{found:?}")
    };
    assert!((first * second - 1.0).norm() <= bound(3) && gap <= bound(3) && separation <= bound(3), "{first} {second}");
    assert!((first.im.abs() / 1e200 - 2.0).abs() <= bound(3) && (second.im.abs() * 1e200 - 0.5).abs() <= bound(3));
    // Nilpotent, hidden by an orthogonal similarity: the computed eigenvalues are near 1e-5, the separation still
    // tells.
    let w = DMatrix::from_fn(3, 3, |i, j| f64::from(u8::from(i == j)) - 2.0 / 3.0);
    let shift = dmatrix![0.0, 1.0, 0.0; 0.0, 0.0, 1.0; 0.0, 0.0, 0.0];
    // As rounded, it is regular.
    let found = lyapunov(&(&w * shift * &w), &identity(3));
    assert!(matches!(found, Err(LinalgError::UndecidedEquation { .. })), "{found:?}");
    assert!(matches!(lyapunov(&DMatrix::zeros(2, 2), &identity(2)), Err(LinalgError::SingularEquation { .. })));
}

#[test]
fn jordan_blocks_and_stiff_plants_are_solved() {
    for n in [2, 5, 8] {
        let jordan = DMatrix::from_fn(n, n, |i, j| if i == j { -1.0 } else { f64::from(u8::from(j == i + 1)) });
        let found = lyapunov(&jordan, &identity(n)).unwrap();
        assert!(found.residual <= bound(n));
        // P_11 = 1/2 whatever the order.
        assert!((found.p[(0, 0)] - 0.5).abs() <= bound(n) * found.condition);
    }
    // Time constants nine decades apart.
    let a = dmatrix![-1e9, 1.0; 0.0, -1.0];
    let found = lyapunov(&a, &identity(2)).unwrap();
    assert!(found.residual <= bound(2) && (found.p[(1, 1)] - 0.5).abs() <= 1e-9);
    // Cyclic permutation, scaled inside the unit circle: the sum of squares of a geometric series.
    let n = 16;
    let cycle = DMatrix::from_fn(n, n, |i, j| if i == (j + 1) % n { 0.5 } else { 0.0 });
    let p = stein(&cycle, &identity(n)).unwrap().p;
    assert!((p - identity(n) * (4.0 / 3.0)).norm() <= bound(n));
    // A stable mode beside a very fast unstable one.
    let a = dmatrix![0.5, 0.0; 1.0, 1e9];
    assert!(stein(&a, &identity(2)).unwrap().residual <= bound(2));
}

#[test]
fn units_of_the_state_decades_apart_are_no_singularity() {
    let a = dmatrix![-1.0, 2.0, 0.5; -1.0, -2.5, 2.0; 1.0, 0.0, -3.0];
    let units = [1e-12, 1.0, 1e12];
    let hidden = DMatrix::from_fn(3, 3, |i, j| a[(i, j)] * (units[j] / units[i]));
    let q = DMatrix::from_fn(3, 3, |i, j| if i == j { units[i] * units[i] } else { 0.0 });
    let back = |p: DMatrix<f64>| DMatrix::from_fn(3, 3, |i, j| p[(i, j)] / units[i] / units[j]);
    let reference = lyapunov(&a, &identity(3)).unwrap();
    let found = lyapunov(&hidden, &q).unwrap();
    assert!((back(found.p) - &reference.p).norm() <= bound(3) * reference.condition * reference.p.norm());
    let reference = stein(&(&a * 0.1), &identity(3)).unwrap();
    let found = stein(&(&hidden * 0.1), &q).unwrap();
    assert!((back(found.p) - &reference.p).norm() <= bound(3) * reference.condition * reference.p.norm());
}

/// Scalars with exact solutions have no residual: the bound is its rounding EPSILON times `(2 |a| + q/p) / separation`,
/// which is 2 for `-2 p + 2 = 0`, relative to the exact solution; of Stein's `p/4 - p + 3 = 0` it is
/// `2 (1/4 + 1)/(1 - 1/4) = 10/3`; of Sylvester's `-2 x + 2 = 0` three times 2, because its separation is an estimate.
#[test]
fn bounds_of_scalars_in_closed_form() {
    let one = |x: f64| DMatrix::from_element(1, 1, x);
    let (found, known) = (lyapunov(&one(-1.0), &one(2.0)).unwrap(), stein(&one(0.5), &one(3.0)).unwrap());
    let plain = sylvester(&one(-1.0), &one(-1.0), &one(-2.0)).unwrap();
    assert_eq!((found.p[(0, 0)], known.p[(0, 0)], plain.x[(0, 0)]), (1.0, 4.0, 1.0));
    let bounds = [found.forward_error(), known.forward_error(), plain.forward_error()];
    for (bound, factor) in bounds.into_iter().zip([2.0, 10.0 / 3.0, 6.0]) {
        assert!(
            (bound / f64::EPSILON - factor).abs() <= 1e-9 * factor,
            "{:e}, expected {factor}",
            bound / f64::EPSILON
        );
    }
}

#[test]
fn orders_zero_and_one() {
    let empty = DMatrix::zeros(0, 0);
    assert_eq!(lyapunov(&empty, &empty).unwrap().p.shape(), (0, 0));
    assert_eq!(stein(&empty, &empty).unwrap().p.shape(), (0, 0));
    assert_eq!(sylvester(&empty, &identity(2), &DMatrix::zeros(0, 2)).unwrap().x.shape(), (0, 2));
    assert_eq!(sylvester(&identity(2), &empty, &DMatrix::zeros(2, 0)).unwrap().x.shape(), (2, 0));
    assert_eq!(discrete_sylvester(&empty, &identity(2), &DMatrix::zeros(0, 2)).unwrap().x.shape(), (0, 2));
    assert_eq!(discrete_sylvester(&identity(2), &empty, &DMatrix::zeros(2, 0)).unwrap().x.shape(), (2, 0));
    assert_eq!(generalized_stein(&empty, &empty, &empty).unwrap().p.shape(), (0, 0));
    assert_eq!(lyapunov(&dmatrix![-2.0], &dmatrix![8.0]).unwrap().p, dmatrix![2.0]);
    let found = discrete_sylvester(&dmatrix![0.5], &dmatrix![-2.0], &dmatrix![8.0]).unwrap();
    assert_eq!((found.x, found.separation), (dmatrix![4.0], 2.0));
    assert_eq!(generalized_stein(&dmatrix![1.0], &dmatrix![2.0], &dmatrix![6.0]).unwrap().p, dmatrix![2.0]);
    // A coefficient of zeros leaves X = C, whatever the other is.
    let (zero, huge) = (DMatrix::zeros(2, 2), dmatrix![1e300, -1e300; 3e299, 1.0]);
    assert!((discrete_sylvester(&zero, &huge, &identity(2)).unwrap().x - identity(2)).norm() <= bound(2));
    assert!((discrete_sylvester(&huge, &zero, &identity(2)).unwrap().x - identity(2)).norm() <= bound(2));
    assert_eq!(stein(&dmatrix![0.5], &dmatrix![3.0]).unwrap().p, dmatrix![4.0]);
    assert_eq!(sylvester(&dmatrix![1.0], &dmatrix![3.0], &dmatrix![8.0]).unwrap().x, dmatrix![2.0]);
}

#[test]
fn bad_input_is_named() {
    let (a, rectangular) = (-identity(2), DMatrix::zeros(2, 3));
    assert_eq!(lyapunov(&rectangular, &a), Err(LinalgError::NotSquare { what: "A", rows: 2, cols: 3 }));
    let mismatch = |what, expected, found| LinalgError::DimensionMismatch { what, expected, found };
    assert_eq!(lyapunov(&a, &identity(3)), Err(mismatch("Q", (2, 2), (3, 3))));
    assert_eq!(stein(&a, &rectangular), Err(mismatch("Q", (2, 2), (2, 3))));
    assert_eq!(sylvester(&a, &identity(3), &identity(2)), Err(mismatch("C", (2, 3), (2, 2))));
    assert_eq!(sylvester(&a, &rectangular, &a), Err(LinalgError::NotSquare { what: "B", rows: 2, cols: 3 }));
    assert_eq!(discrete_sylvester(&a, &identity(3), &identity(2)), Err(mismatch("C", (2, 3), (2, 2))));
    let not_square = Err(LinalgError::NotSquare { what: "B", rows: 2, cols: 3 });
    assert_eq!(discrete_sylvester(&a, &rectangular, &a), not_square);
    assert_eq!(generalized_stein(&a, &identity(3), &a).unwrap_err(), mismatch("E", (2, 2), (3, 3)));
    let singular = generalized_stein(&a, &dmatrix![1.0, 2.0; 2.0, 4.0], &a).unwrap_err();
    assert!(matches!(singular, LinalgError::Singular { what: "E", condition } if condition > 1e15), "{singular}");
    let q = dmatrix![1.0, 2.0; 2.5, 1.0];
    for found in [lyapunov(&a, &q).unwrap_err(), stein(&a, &q).unwrap_err()] {
        assert!(
            matches!(found, LinalgError::NotSymmetric { what: "Q", row: 1, col: 0, asymmetry: 0.5, .. }),
            "{found}"
        );
    }
    let nan = dmatrix![1.0, f64::NAN; f64::NAN, 1.0];
    assert!(matches!(lyapunov(&a, &nan), Err(LinalgError::NotFinite { what: "Q", row: 1, col: 0, .. })));
    assert!(matches!(stein(&nan, &a), Err(LinalgError::NotFinite { what: "A", row: 1, col: 0, .. })));
    assert!(matches!(sylvester(&a, &a, &nan), Err(LinalgError::NotFinite { what: "C", row: 1, col: 0, .. })));
    // P would be 1e400.
    assert!(matches!(lyapunov(&(&a * 1e-200), &(identity(2) * 1e200)), Err(LinalgError::Overflow { .. })));
    assert!(matches!(stein(&(&a * 1e200), &identity(2)), Err(LinalgError::Overflow { .. })));
    let huge = &a * 1e100;
    assert!(matches!(
        discrete_sylvester(&huge, &huge, &a),
        Err(LinalgError::Overflow { what: "the product of entries of a and b" })
    ));
    let found = discrete_sylvester(&dmatrix![0.5], &dmatrix![2.0 - 1e-10], &dmatrix![1e300]);
    assert!(matches!(found, Err(LinalgError::Overflow { what: "the solution x" })), "{found:?}");
    assert!(matches!(generalized_stein(&(&a * 1e200), &(&a * 1e200), &a), Err(LinalgError::UndecidedEquation { .. })));
    assert!(matches!(generalized_stein(&a, &(&a * 1e200), &a), Err(LinalgError::Overflow { .. })));
}

/// An equation that could not be had solves nothing, and is as new after the next one that can.
#[test]
fn an_equation_is_refactored_after_an_error() {
    let (a, q) = (dmatrix![-1.0, 2.0; 0.0, -3.0], DMatrix::identity(2, 2));
    let mut equation = LyapunovEquation::new(&a).unwrap();
    let before = equation.clone();
    let expected = equation.solve(&q);
    let nearly = equation.refactor(&dmatrix![1.0, 0.0; 0.0, -1.0]).unwrap_err();
    assert!(matches!(nearly, LinalgError::SingularEquation { .. }), "{nearly}");
    assert!(matches!(equation.solve(&q), Err(LinalgError::Overflow { .. })));
    assert!(matches!(equation.refactor(&dmatrix![f64::NAN, 0.0; 0.0, 1.0]), Err(LinalgError::NotFinite { .. })));
    assert!(equation.solve(&q).is_err());
    // Of another order.
    equation.refactor(&dmatrix![-2.0]).unwrap();
    assert_eq!(equation.solve(&dmatrix![4.0]).unwrap().p, dmatrix![1.0]);
    equation.refactor(&a).unwrap();
    assert_eq!(equation.solve(&q), expected);
    assert_eq!(equation, before);
}

/// A descriptor plant in units sixteen decades apart: mpmath with 50 digits.
#[test]
fn a_descriptor_in_other_units() {
    let (a, e) = (dmatrix![-1e8, 0.5; 0.2, -2e-8], dmatrix![1e8, 0.0; 0.0, 1e-8]);
    let p = luenberger_linalg::generalized_lyapunov(&a, &e, &identity(2)).unwrap().p;
    for (found, exact) in [
        (p[(0, 0)], 0.003_508_771_929_824_561),
        (p[(0, 1)], 1_754_385.964_912_281),
        (p[(1, 1)], 2_543_859_649_122_807.0),
    ] {
        // In balanced units the entries differ by a factor of 200.
        assert!((found / exact - 1.0).abs() <= 1e-13, "{p}");
    }
    let found = luenberger_linalg::generalized_care(
        &a,
        &dmatrix![1e8; 1e-8],
        &dmatrix![1.0, 0.0; 0.0, 1e-32],
        &dmatrix![1.0],
        &DMatrix::zeros(2, 1),
        &e,
    );
    assert!(found.is_ok(), "{found:?}");
}

/// `.9 I + k N`, N the shift: the solution is that of k = 1 in other units, `p_ij k^(i+j)`.
#[test]
fn a_chain_in_any_unit() {
    let shift = DMatrix::from_fn(4, 4, |i, j| if j == i + 1 { 1.0 } else { 0.0 });
    let exact = [5.263_157_894_736_842, 269.150_021_869_077_1, 20_042.592_036_909_67, 1_667_520.676_138_190_4];
    for power in [0, 10, 15, 16, 17, 18, 20, 40] {
        let unit = 2f64.powi(power);
        let weight = |k: usize| (0..2 * k).map(|_| unit).product::<f64>();
        let q = DMatrix::from_fn(4, 4, |i, j| if i == j { weight(i) } else { 0.0 });
        let p = stein(&(identity(4) * 0.9 + &shift * unit), &q).unwrap().p;
        for (k, exact) in exact.into_iter().enumerate() {
            // 0.9 is rounded: seven factors 1 - .81.
            let found = p[(k, k)] / weight(k);
            assert!((found / exact - 1.0).abs() <= 1e-12, "2^{power}: {p}");
        }
    }
}
