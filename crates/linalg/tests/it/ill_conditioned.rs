//! Linear matrix equations that are regular and as ill-conditioned as double precision allows, or more; and those that
//! are singular. Solutions are exact: integers by recursion, or chosen.

use luenberger_linalg::{
    LinalgError, LyapunovEquation, discrete_sylvester, generalized_lyapunov, lyapunov, stein, sylvester,
};
use nalgebra::{DMatrix, dmatrix};

fn identity(n: usize) -> DMatrix<f64> {
    DMatrix::identity(n, n)
}

/// `-1/4` on the diagonal, 1 above.
fn jordan_block(n: usize) -> DMatrix<f64> {
    DMatrix::from_fn(n, n, |i, j| if i == j { -0.25 } else { f64::from(u8::from(j == i + 1)) })
}

/// The solution for the Jordan block and `Q = I`: `P_ij = 2 (delta_ij + P_(i-1)j + P_i(j-1))`.
fn jordan_solution(n: usize) -> DMatrix<f64> {
    let mut p = vec![vec![0_u128; n]; n];
    for i in 0..n {
        for j in 0..n {
            let above = if i > 0 { p[i - 1][j] } else { 0 };
            let beside = if j > 0 { p[i][j - 1] } else { 0 };
            p[i][j] = 2 * (u128::from(i == j) + above + beside);
        }
    }
    DMatrix::from_fn(n, n, |i, j| p[i][j] as f64)
}

/// Eigenvalues that are nowhere near to adding to zero (each two add to -1/2), a separation down to 1e-23: the
/// substitution is right to the last digits, and the answer says so.
#[test]
fn jordan_blocks_whose_separation_is_rounding() {
    for n in [4, 8, 12, 14, 16, 20] {
        let p = jordan_solution(n);
        let found = lyapunov(&jordan_block(n), &identity(n)).unwrap_or_else(|error| panic!("n = {n}: {error}"));
        let error = (&found.p - &p).norm() / p.norm();
        println!("{n} {error:e} {:e} {:e}", found.forward_error(), found.separation);
        assert!(error <= found.forward_error(), "n = {n}: {error:e} > {:e}", found.forward_error());
        assert!(n < 12 || found.forward_error() <= 1e-10, "n = {n}: {:e}", found.forward_error());
        assert!(n < 14 || found.separation < 1e-15, "n = {n}: {:e}", found.separation);
        // As an equation, too, and for a Q of which P has no large part: that has no digits, and the bound or the error
        // says it.
        let mut equation = LyapunovEquation::new(&jordan_block(n)).unwrap();
        let q = -(jordan_block(n).transpose() + jordan_block(n));
        match equation.solve(&q) {
            Ok(found) => {
                assert!((&found.p - identity(n)).norm() <= found.forward_error() * (n as f64).sqrt(), "n = {n}");
            }
            Err(LinalgError::UndecidedEquation { .. }) => assert!(n >= 14),
            Err(other) => panic!("{other}"),
        }
        assert!((equation.solve(&identity(n)).unwrap().p - &p).norm() <= 1e-10 * p.norm());
        let sylvester = sylvester(&jordan_block(n).transpose(), &jordan_block(n), &-identity(n)).unwrap();
        let error = (&sylvester.x - &p).norm() / p.norm();
        assert!(error <= sylvester.forward_error() && error <= 1e-10, "n = {n}: {error:e}");
    }
}

/// The same in discrete time, P a sum of positive terms.
#[test]
fn stein_and_its_sylvester_form_whose_separation_is_rounding() {
    for n in [6, 12, 16] {
        // A = 1/2 I + 4 N: `3/4 P_ij = delta_ij + 2 (P_(i-1)j + P_i(j-1)) + 16 P_(i-1)(j-1)`.
        let a = DMatrix::from_fn(n, n, |i, j| if i == j { 0.5 } else { 4.0 * f64::from(u8::from(j == i + 1)) });
        let mut p = DMatrix::zeros(n, n);
        for i in 0..n {
            for j in 0..n {
                let at = |i: usize, j: usize| if i < n && j < n { p[(i, j)] } else { 0.0 };
                let (above, beside, corner) =
                    (at(i.wrapping_sub(1), j), at(i, j.wrapping_sub(1)), at(i.wrapping_sub(1), j.wrapping_sub(1)));
                // Positive terms: right to 6 n roundings.
                p[(i, j)] = (f64::from(u8::from(i == j)) + 2.0 * (above + beside) + 16.0 * corner) / 0.75;
            }
        }
        let allowed = 6.0 * n as f64 * f64::EPSILON;
        let found = stein(&a, &identity(n)).unwrap_or_else(|error| panic!("n = {n}: {error}"));
        let error = (&found.p - &p).norm() / p.norm();
        println!("{n} {error:e} {:e} {:e}", found.forward_error(), found.separation);
        assert!(error <= found.forward_error() + allowed, "n = {n}: {error:e} > {:e}", found.forward_error());
        assert!(
            n < 12 || found.separation < 1e-16 && found.forward_error() <= 1e-10,
            "n = {n}: {:e}",
            found.separation
        );
        let found = discrete_sylvester(&a.transpose(), &a, &identity(n)).unwrap();
        assert!((&found.x - &p).norm() <= (found.forward_error() + allowed) * p.norm(), "n = {n}");
    }
}

/// Sums of eigenvalues far below the rounding of the largest, and matrices within a rounding of singular: what is
/// stored decides.
#[test]
fn one_unit_in_the_last_place_from_singular() {
    let up = 1.0 + f64::EPSILON;
    let found = lyapunov(&dmatrix![1.0, 0.0; 0.0, -up], &dmatrix![1.0, 1.0; 1.0, 1.0]).unwrap();
    assert_eq!(found.p, dmatrix![-0.5, 1.0 / f64::EPSILON; 1.0 / f64::EPSILON, 0.5 / up]);
    assert!(found.forward_error() <= 1e-15 && found.condition >= 1e15);
    let found = lyapunov(&dmatrix![1.0, 0.0; 0.0, -1.0], &identity(2));
    let Err(LinalgError::SingularEquation { equation: "Lyapunov", first, second, gap }) = found else {
        panic!("{found:?}")
    };
    assert_eq!((first.re + second.re, gap), (0.0, 0.0));
    let found = lyapunov(&dmatrix![1.0, 0.0; 0.0, -2.0_f64.powi(-70)], &identity(2)).unwrap();
    assert_eq!((found.p[(0, 0)], found.p[(1, 1)]), (-0.5, 2.0_f64.powi(69)));
    let found = stein(&dmatrix![0.5, 0.0; 0.0, 2.0 * up], &dmatrix![0.75, 1.0; 1.0, 1.0]).unwrap();
    assert_eq!((found.p[(0, 0)], found.p[(0, 1)]), (1.0, -1.0 / f64::EPSILON));
    let found = sylvester(&dmatrix![3.0e9], &dmatrix![-3.0e9 * up], &dmatrix![1.0]).unwrap();
    assert_eq!(found.x[(0, 0)], -1.0 / (3.0e9 * up - 3.0e9));
    assert!(found.forward_error() <= 1e-15);
    let found = discrete_sylvester(&dmatrix![4.0], &dmatrix![0.25], &dmatrix![1.0]);
    assert!(
        matches!(found, Err(LinalgError::SingularEquation { equation: "discrete Sylvester", gap: 0.0, .. })),
        "{found:?}"
    );
}

/// Of trace zero, or with a nilpotent part, full: singular for certain, though no computed eigenvalue adds to zero. A
/// change of one entry in its last place, and it is not singular, and must not be reported as singular.
#[test]
fn only_what_is_singular_is_called_so() {
    let w = DMatrix::from_fn(4, 4, |i, j| {
        [[1.0, 1.0, 1.0, 1.0], [1.0, -1.0, 1.0, -1.0], [1.0, 1.0, -1.0, -1.0], [1.0, -1.0, -1.0, 1.0]][i][j]
    });
    // `w w = 4 I`; eigenvalues 3, -3, 1 and 2; entries in quarters.
    let d = dmatrix![3.0, 5.0, 0.0, 1.0; 0.0, -3.0, 7.0, 0.0; 0.0, 0.0, 1.0, 9.0; 0.0, 0.0, 0.0, 2.0];
    let a = &w * d * &w * 0.25;
    let shift = DMatrix::from_fn(4, 4, |i, j| f64::from(u8::from(j == i + 1)));
    let nilpotent = &w * shift * &w * 0.25;
    for a in [a, nilpotent] {
        let found = lyapunov(&a, &identity(4));
        let Err(error @ LinalgError::SingularEquation { gap, .. }) = &found else { panic!("{found:?}") };
        assert!(*gap <= 1e-2 && error.to_string().contains("for the data as stored"), "{error}");
        let found = sylvester(&a.transpose(), &a, &identity(4));
        assert!(matches!(found, Err(LinalgError::SingularEquation { .. })), "{found:?}");
        // Of the next matrix a solution exists. It is given with a bound that holds, with none, or not at all.
        let mut next = a.clone();
        next[(0, 0)] = next[(0, 0)].next_up();
        match lyapunov(&next, &identity(4)) {
            Ok(found) => assert!(found.forward_error() > 1e-2, "{found:?}"),
            Err(error @ LinalgError::UndecidedEquation { regular: true, separation, condition, digits, .. }) => {
                let text = error.to_string();
                assert!(
                    text.contains("has a unique solution, of which no digit is certain in double precision"),
                    "{text}"
                );
                assert!(separation * condition <= 4.0 * a.norm() && condition >= 1e14, "{text}");
                assert!(digits.is_none_or(|digits| digits >= 17), "{text}");
            }
            other => panic!("{other:?}"),
        }
    }
    // Of a pencil the product `A E^-1` is rounded: nothing is certain of it.
    let found = generalized_lyapunov(&dmatrix![1.0, 0.0; 0.0, -1.0], &identity(2), &identity(2));
    assert!(matches!(found, Err(LinalgError::UndecidedEquation { regular: false, .. })), "{found:?}");
}

/// Companion matrices of `(x + 1)(x + 2) .. (x + n)`: eigenvalues one apart, a separation below rounding from n = 8 on.
/// No message may call them singular.
#[test]
fn companions_are_regular_or_undecided() {
    for n in 2..=14_usize {
        let mut coefficients = vec![1.0];
        for k in 1..=n {
            let shifted = coefficients.iter().map(|c| c * k as f64).collect::<Vec<_>>();
            coefficients.push(0.0);
            coefficients.iter_mut().skip(1).zip(&shifted).for_each(|(c, s)| *c += s);
        }
        let a =
            DMatrix::from_fn(n, n, |i, j| if i == 0 { -coefficients[j + 1] } else { f64::from(u8::from(i == j + 1)) });
        match lyapunov(&a, &identity(n)) {
            Ok(found) => assert!(found.residual <= 1e-12, "n = {n}: {:e}", found.residual),
            Err(error @ LinalgError::UndecidedEquation { regular, separation, condition, digits, .. }) => {
                println!("{n} {error}");
                assert!(regular && n >= 7 && separation > 0.0 && condition > 1e14, "n = {n}: {error}");
                // Those that the condition takes, of each of n products twice and between norms, sqrt n to 3 n; and
                // three that are left.
                let needed = |norms: f64| (condition * 2.0 * n as f64 * norms).log10().ceil() + 3.0;
                let digits = f64::from(digits.unwrap());
                let (least, most) = (needed((n as f64).sqrt()), needed(3.0 * n as f64));
                assert!((least..=most).contains(&digits), "n = {n}: {digits} of {least} to {most}");
            }
            Err(other) => panic!("n = {n}: {other}"),
        }
    }
}
