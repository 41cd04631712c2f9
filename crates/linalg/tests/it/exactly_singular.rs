//! Equations that are singular or regular for the coefficients as stored, decided in integers.

use luenberger_linalg::internals::{Equation, Regularity, characteristic, power, prime_below, regularity, residue};
use nalgebra::{DMatrix, dmatrix};

#[test]
fn primes_and_residues_are_those_of_arithmetic() {
    // The largest primes below 2^31 and below 100.
    assert_eq!((prime_below(1 << 31), prime_below((1 << 31) - 1)), (2_147_483_647, 2_147_483_629));
    assert_eq!([100, 97, 89].map(prime_below), [97, 89, 83]);
    let p = 2_147_483_647_u64;
    for (x, expected) in [(0.0, 0), (-0.0, 0), (-3.0, p - 3), (0.5, p.div_ceil(2)), (2.0_f64.powi(31), 1)] {
        assert_eq!(residue(x, p), expected, "{x}");
    }
    // 2^-1074 times 2^1074.
    assert_eq!(residue(f64::from_bits(1), p) * power(2, 1074, p) % p, 1);
    // x^2 + 3 x + 2 and x^3 - 1, the latter with a zero pivot.
    assert_eq!(characteristic(&dmatrix![0.0, 1.0; -2.0, -3.0], p), [2, 3, 1]);
    assert_eq!(characteristic(&dmatrix![0.0, 0.0, 1.0; 1.0, 0.0, 0.0; 0.0, 1.0, 0.0], p), [p - 1, 0, 0, 1]);
}

#[test]
fn one_unit_in_the_last_place_decides() {
    let sylvester = |a: &DMatrix<f64>| regularity(Equation::Sylvester, a, a, true);
    let up = 1.0 + f64::EPSILON;
    assert_eq!(sylvester(&dmatrix![1.0, 3.0; 0.0, -1.0]), Regularity::Singular);
    assert_eq!(sylvester(&dmatrix![1.0, 3.0; 0.0, -up]), Regularity::Regular);
    // Of trace zero, and all the same full; from one end of the range to the other.
    assert_eq!(sylvester(&dmatrix![0.1, 0.7; 0.3, -0.1]), Regularity::Singular);
    assert_eq!(sylvester(&dmatrix![1e300, 1e-300; 1.0, -1e300]), Regularity::Singular);
    assert_eq!(sylvester(&dmatrix![1e300, 1e-300; 1.0, -1e300 * up]), Regularity::Regular);
    assert_eq!(sylvester(&DMatrix::zeros(3, 3)), Regularity::Singular);
    assert_eq!(sylvester(&DMatrix::zeros(0, 0)), Regularity::Regular);
    let stein = |a: &DMatrix<f64>, b: &DMatrix<f64>| regularity(Equation::Stein, a, b, false);
    assert_eq!(stein(&dmatrix![0.5, 1.0; 0.0, 8.0], &dmatrix![2.0]), Regularity::Singular);
    assert_eq!(stein(&dmatrix![0.5, 1.0; 0.0, 8.0], &dmatrix![2.0 * up]), Regularity::Regular);
    assert_eq!(stein(&dmatrix![0.0, 1.0; 0.0, 0.0], &dmatrix![0.0, 1.0; 0.0, 0.0]), Regularity::Regular);
    // 3 times the double nearest to 1/3 is not one.
    assert_eq!(stein(&dmatrix![3.0], &dmatrix![1.0 / 3.0]), Regularity::Regular);
    // Too large to prove singular, not too large to prove regular.
    let shift = DMatrix::from_fn(90, 90, |i, j| f64::from(u8::from(j == i + 1)));
    assert_eq!(sylvester(&(&shift * 0.1)), Regularity::Unknown);
    assert_eq!(sylvester(&(&shift - DMatrix::identity(90, 90))), Regularity::Regular);
}
