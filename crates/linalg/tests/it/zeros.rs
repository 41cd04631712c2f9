//! The zeros are where the system matrix loses rank, and no feedback moves them.

use luenberger_linalg::{InvariantZeros, LinalgError, eigenvalues, invariant_zeros};
use nalgebra::{Complex, DMatrix, dmatrix};
use proptest::prelude::*;

/// Each expected zero has one of its own within `tolerance` of the largest.
fn assert_zeros(found: &InvariantZeros, expected: &[Complex<f64>], tolerance: f64) {
    assert_eq!(found.zeros.len(), expected.len(), "{:?} for {expected:?}", found.zeros);
    let size = expected.iter().map(|z| z.norm()).fold(1.0, f64::max);
    let mut left = found.zeros.clone();
    for z in expected {
        let (at, off) = left.iter().map(|x| (x - z).norm()).enumerate().min_by(|x, y| x.1.total_cmp(&y.1)).unwrap();
        assert!(off <= tolerance * size, "{z}: nearest of {left:?} is {off:e} away");
        left.swap_remove(at);
    }
}

fn real(zeros: &[f64]) -> Vec<Complex<f64>> {
    zeros.iter().map(|z| Complex::from(*z)).collect()
}

/// SLICOT AB08ND, example program: normal rank 2, zeros 2 and -1 (one of them a hidden mode). slycot's `ab08nd` gives
/// the same.
#[test]
fn the_example_of_slicot_ab08nd() {
    let a = DMatrix::from_diagonal(&nalgebra::dvector![1.0, 1.0, 3.0, -4.0, -1.0, 3.0]);
    let b = dmatrix![0.0, -1.0; -1.0, 0.0; 1.0, -1.0; 0.0, 0.0; 0.0, 1.0; -1.0, -1.0];
    let c = dmatrix![1.0, 0.0, 0.0, 1.0, 0.0, 0.0; 0.0, 1.0, 0.0, 1.0, 0.0, 1.0; 0.0, 0.0, 1.0, 0.0, 0.0, 1.0];
    let found = invariant_zeros(&a, &b, &c, &DMatrix::zeros(3, 2)).unwrap();
    assert_zeros(&found, &real(&[2.0, -1.0]), 1e-13);
    assert_eq!((found.normal_rank, found.is_degenerate(), found.is_minimum_phase()), (2, false, false));
    // A third input that is the sum of the others, and three outputs: rank 2 where 3 were possible.
    let mut more = DMatrix::zeros(6, 3);
    more.columns_mut(0, 2).copy_from(&b);
    more.set_column(2, &(b.column(0) + b.column(1)));
    let found = invariant_zeros(&a, &more, &c, &DMatrix::zeros(3, 3)).unwrap();
    assert_zeros(&found, &real(&[2.0, -1.0]), 1e-13);
    assert_eq!((found.normal_rank, found.is_degenerate()), (2, true));
}

/// The reactor of Kautsky, Nichols and Van Dooren. Zeros by slycot 0.6's `ab08nd`.
#[test]
fn the_chemical_reactor() {
    let a = dmatrix![
        1.380, -0.2077, 6.715, -5.676;
        -0.5814, -4.290, 0.0, 0.6750;
        1.067, 4.273, -6.654, 5.893;
        0.0480, 4.273, 1.343, -2.104
    ];
    let b = dmatrix![0.0, 0.0; 5.679, 0.0; 1.136, -3.146; 1.136, 0.0];
    let c = dmatrix![1.0, 0.0, 1.0, -1.0; 0.0, 1.0, 0.0, 0.0];
    let found = invariant_zeros(&a, &b, &c, &DMatrix::zeros(2, 2)).unwrap();
    assert_zeros(&found, &real(&[-1.191594350597, -5.039429421194]), 1e-12);
    assert!(found.residuals.iter().all(|r| *r < 1e-14), "{:?}", found.residuals);
    // C B is 1.136 - 1.136 for the first input and output, and C A B is small: one of the two zeros is far out, and
    // known to fewer digits.
    let (b1, c1) = (b.columns(0, 1).into_owned(), c.rows(0, 1).into_owned());
    let one = invariant_zeros(&a, &b1, &c1, &dmatrix![0.0]).unwrap();
    assert_zeros(&one, &real(&[-3.766839509698e4, -9.016]), 1e-9);
    assert_eq!(one.normal_rank, 1);
    // Two inputs, one output: generically none.
    let wide = invariant_zeros(&a, &b, &c1, &DMatrix::zeros(1, 2)).unwrap();
    assert_eq!((wide.zeros.len(), wide.normal_rank), (0, 1));
}

#[test]
fn without_inputs_the_zeros_are_the_hidden_modes() {
    let a = dmatrix![-1.0, 2.0, 0.0; -2.0, -1.0, 0.0; 1.0, 1.0, 3.0];
    let none = DMatrix::zeros(3, 0);
    let found = invariant_zeros(&a, &none, &dmatrix![1.0, 0.0, 0.0], &DMatrix::zeros(1, 0)).unwrap();
    assert_zeros(&found, &real(&[3.0]), 1e-14);
    assert_eq!(found.normal_rank, 0);
    // Neither inputs nor outputs: every eigenvalue.
    let all = invariant_zeros(&a, &none, &DMatrix::zeros(0, 3), &DMatrix::zeros(0, 0)).unwrap();
    assert_zeros(&all, &eigenvalues(&a).unwrap(), 1e-14);
    // A zero transfer function: what is moved or seen is no zero, the rest is.
    let blind = invariant_zeros(&a, &dmatrix![0.0; 0.0; 1.0], &dmatrix![1.0, 0.0, 0.0], &dmatrix![0.0]).unwrap();
    assert_eq!((blind.zeros.len(), blind.normal_rank, blind.is_degenerate()), (0, 0, true));
}

#[test]
fn one_state_and_static_gains() {
    // (s + 5)/(s + 2) = 1 + 3/(s + 2).
    let found = invariant_zeros(&dmatrix![-2.0], &dmatrix![1.0], &dmatrix![3.0], &dmatrix![1.0]).unwrap();
    assert_zeros(&found, &real(&[-5.0]), 1e-15);
    let none = invariant_zeros(&dmatrix![-2.0], &dmatrix![1.0], &dmatrix![3.0], &dmatrix![0.0]).unwrap();
    assert!(none.zeros.is_empty() && none.normal_rank == 1);
    // Integrators: zeros at infinity only.
    let chain = DMatrix::from_fn(60, 60, |i, j| f64::from(u8::from(j == i + 1)));
    let (b, c) = (
        DMatrix::from_fn(60, 1, |i, _| f64::from(u8::from(i == 59))),
        DMatrix::from_fn(1, 60, |_, j| f64::from(u8::from(j == 0))),
    );
    assert!(invariant_zeros(&chain, &b, &c, &dmatrix![0.0]).unwrap().zeros.is_empty());
}

/// Orders at which faer's blocked QZ does not converge: with D = 1 the zeros are the eigenvalues of `A - B C`, here of
/// the companion kind with all of modulus near one.
#[test]
fn ninety_zeros() {
    let n = 90;
    let noise = |k: usize| ((k * 7919 + 13) as f64 * 0.618_033_988_749).fract() - 0.5;
    let a = DMatrix::from_fn(n, n, |i, j| 0.2 * noise(i * n + j) + f64::from(u8::from(j == (i + 1) % n)));
    let b = DMatrix::from_fn(n, 1, |i, _| noise(7 * i + 3));
    let c = DMatrix::from_fn(1, n, |_, j| noise(11 * j + 5));
    let found = invariant_zeros(&a, &b, &c, &dmatrix![1.0]).unwrap();
    assert_eq!((found.zeros.len(), found.normal_rank), (n, 1));
    assert!(found.residuals.iter().all(|r| *r < 10.0 * n as f64 * f64::EPSILON), "{:?}", found.residuals);
    let sum: Complex<f64> = found.zeros.iter().sum();
    let trace = (&a - &b * &c).trace();
    assert!((sum - trace).norm() < 1e-11 * a.norm(), "{sum} {trace}");
}

#[test]
fn bad_input_is_named() {
    let (a, b, c, d) = (dmatrix![0.0, 1.0; 0.0, 0.0], dmatrix![0.0; 1.0], dmatrix![1.0, 0.0], dmatrix![0.0]);
    assert!(matches!(invariant_zeros(&c, &b, &c, &d), Err(LinalgError::NotSquare { what: "A", .. })));
    assert!(matches!(invariant_zeros(&a, &c, &c, &d), Err(LinalgError::DimensionMismatch { what: "B", .. })));
    assert!(matches!(invariant_zeros(&a, &b, &b, &d), Err(LinalgError::DimensionMismatch { what: "C", .. })));
    assert!(matches!(invariant_zeros(&a, &b, &c, &b), Err(LinalgError::DimensionMismatch { what: "D", .. })));
    let nan = invariant_zeros(&a, &b, &c, &dmatrix![f64::NAN]);
    assert!(matches!(nan, Err(LinalgError::NotFinite { what: "D", .. })));
    let empty = DMatrix::zeros(0, 0);
    let none = invariant_zeros(&empty, &DMatrix::zeros(0, 1), &DMatrix::zeros(1, 0), &d);
    assert_eq!(none.unwrap_err(), LinalgError::Empty { what: "A" });
}

#[derive(Debug, Clone)]
struct Plant {
    a: DMatrix<f64>,
    b: DMatrix<f64>,
    c: DMatrix<f64>,
    d: DMatrix<f64>,
    k: DMatrix<f64>,
    l: DMatrix<f64>,
    units: Vec<i32>,
}

/// As many inputs as outputs, D well away from singular.
fn square_plant() -> impl Strategy<Value = Plant> {
    (1..=7_usize, 1..=3_usize).prop_flat_map(|(n, m)| {
        let entries = |k: usize| prop::collection::vec(-1.0..1.0_f64, k);
        (entries(n * n), entries(4 * n * m), entries(m * m), prop::collection::vec(-40..=40_i32, n + 2 * m)).prop_map(
            move |(a, x, d, units)| Plant {
                a: DMatrix::from_vec(n, n, a),
                b: DMatrix::from_column_slice(n, m, &x[..n * m]),
                c: DMatrix::from_column_slice(m, n, &x[n * m..2 * n * m]),
                k: DMatrix::from_column_slice(m, n, &x[2 * n * m..3 * n * m]),
                l: DMatrix::from_column_slice(n, m, &x[3 * n * m..]),
                d: DMatrix::from_vec(m, m, d) * 0.25 + DMatrix::identity(m, m),
                units,
            },
        )
    })
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(64))]

    /// With D regular the zeros are the eigenvalues of `A - B D^-1 C`: the plant run backwards. They are compared
    /// through the characteristic polynomial's value, `det(z I - A + B D^-1 C)`, which is insensitive to how
    /// ill-conditioned a single eigenvalue is.
    #[test]
    fn a_regular_feedthrough_gives_the_poles_of_the_inverse(p in square_plant()) {
        let found = invariant_zeros(&p.a, &p.b, &p.c, &p.d).unwrap();
        let backwards = &p.a - &p.b * p.d.clone().try_inverse().unwrap() * &p.c;
        let n = p.a.nrows();
        prop_assert_eq!(found.zeros.len(), n);
        prop_assert_eq!(found.normal_rank, p.d.nrows());
        prop_assert!(found.residuals.iter().all(|r| *r < 50.0 * n as f64 * f64::EPSILON), "{:?}", found.residuals);
        for z in &found.zeros {
            let shifted = backwards.map(Complex::from) - DMatrix::identity(n, n) * *z;
            let sigma = shifted.clone().svd(false, false).singular_values;
            // An eigenvalue of a matrix within n eps of this one, D^-1 being of condition 10.
            prop_assert!(sigma.min() <= 1e4 * n as f64 * f64::EPSILON * (backwards.norm() + z.norm()), "{z}: {sigma}");
        }
    }

    /// State feedback and output injection leave the zeros where they are, and so do other units of states, inputs and
    /// outputs.
    #[test]
    fn no_gain_moves_a_zero(p in square_plant()) {
        let zero = DMatrix::zeros(p.d.nrows(), p.d.ncols());
        // Feedthrough zero: C B is generically regular, so n - m zeros.
        let plain = invariant_zeros(&p.a, &p.b, &p.c, &zero).unwrap();
        let closed = &p.a - &p.b * &p.k - &p.l * &p.c;
        let fed = invariant_zeros(&closed, &p.b, &p.c, &zero).unwrap();
        prop_assert_eq!(plain.zeros.len(), fed.zeros.len());
        prop_assert_eq!(plain.normal_rank, fed.normal_rank);
        let (n, m) = p.b.shape();
        let d = |k: usize| 2f64.powi(p.units[k]);
        let a = DMatrix::from_fn(n, n, |i, j| closed[(i, j)] * d(j) / d(i));
        let b = DMatrix::from_fn(n, m, |i, j| p.b[(i, j)] * d(n + j) / d(i));
        let c = DMatrix::from_fn(m, n, |i, j| p.c[(i, j)] * d(j) / d(n + m + i));
        let scaled = invariant_zeros(&a, &b, &c, &zero).unwrap();
        prop_assert_eq!(scaled.zeros.len(), fed.zeros.len());
        // Each zero of the one is a zero of the other: its residual in the other's system matrix is rounding.
        for z in plain.zeros.iter().chain(&scaled.zeros) {
            let s = DMatrix::from_fn(n + m, n + m, |i, j| match (i < n, j < n) {
                (true, true) => Complex::from(p.a[(i, j)]) - if i == j { *z } else { Complex::from(0.0) },
                (true, false) => Complex::from(p.b[(i, j - n)]),
                (false, true) => Complex::from(p.c[(i - n, j)]),
                (false, false) => Complex::from(0.0),
            });
            let sigma = s.clone().svd(false, false).singular_values;
            prop_assert!(sigma.min() <= 1e-9 * s.norm(), "{z}: {sigma}");
        }
    }
}
