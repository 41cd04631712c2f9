//! Observers that need the left inverse of a matrix S, which is nearly singular and whose left inverse is known.
//!
//! With integer matrices K and R, `K'K = h I` and det R = 1, `S = K R` has the left inverse `(S'S)^-1 S' = R^-1 K'/h`.
//! The condition number of R is what one likes, and no result depends on it:
//!
//! - Reduced-order observer, `S = [C; T]`: for `A = R^-1 A0 R`, `TAM = K_T A0 K_T'/h`, K_T being the rows of K that
//!   belong to T. A, C and T are integers.
//! - Unknown-input observer, `S = CE`: for `E = C^-1 K R`, `T = I - E (S'S)^-1 S' C = C^-1 (I - KK'/h) C`.

use luenberger_proof::certificate::{PlantMatrices, ReducedOrderConvergence, Theorem, UnknownInputConvergence};
use luenberger_proof::{Matrix, Verdict};
use proptest::prelude::*;

/// The verdicts on the rank, on `P > 0` and on the decrease.
fn facts(theorem: impl Into<Theorem>) -> [Verdict<luenberger_proof::certificate::Witness>; 3] {
    let facts = theorem.into().facts().expect("shapes agree");
    facts.into_iter().map(|fact| fact.verdict).collect::<Vec<_>>().try_into().expect("three facts")
}

fn without_inputs(a: &Matrix<f64>, c: &Matrix<f64>) -> PlantMatrices {
    PlantMatrices { a: a.clone(), b: Matrix::from_fn(a.rows(), 0, |_, _| 0.0), c: c.clone() }
}

fn reduced_order(
    (a, c): (&Matrix<f64>, &Matrix<f64>),
    t: &Matrix<f64>,
    p: &Matrix<f64>,
    rate: f64,
) -> [Verdict<luenberger_proof::certificate::Witness>; 3] {
    facts(ReducedOrderConvergence { plant: without_inputs(a, c), t: t.clone(), p: p.clone(), rate })
}

type Integers = Vec<Vec<i128>>;

fn product(x: &Integers, y: &Integers) -> Integers {
    let entry = |row: &Vec<i128>, j: usize| row.iter().zip(y).map(|(a, row)| a * row[j]).sum();
    x.iter().map(|row| (0..y[0].len()).map(|j| entry(row, j)).collect()).collect()
}

/// R with `1` on the diagonals of its factors and `k` beside them, and its inverse.
fn unimodular(n: usize, k: i128) -> (Integers, Integers) {
    // The inverse of the lower bidiagonal factor has the entries (-k)^(i - j).
    let lower = |i: usize, j: usize| if i == j { 1 } else { i128::from(i == j + 1) * k };
    let inverse = |i: usize, j: usize| if i < j { 0 } else { (-k).pow((i - j) as u32) };
    let matrix =
        |f: &dyn Fn(usize, usize) -> i128| -> Integers { (0..n).map(|i| (0..n).map(|j| f(i, j)).collect()).collect() };
    let r = product(&matrix(&lower), &matrix(&|i, j| lower(j, i)));
    (r, product(&matrix(&|i, j| inverse(j, i)), &matrix(&inverse)))
}

/// As binary64, exactly; column j times 2^units[j], row i times 2^-rows[i].
fn stored(x: &Integers, rows: &[i32], units: &[i32]) -> Matrix<f64> {
    Matrix::from_fn(x.len(), x[0].len(), |i, j| {
        assert!(x[i][j].abs() < 1 << 53, "{}", x[i][j]);
        x[i][j] as f64 * 2f64.powi(units[j] - rows[i])
    })
}

/// The condition number of R is at least this: an entry of a matrix is at most its spectral norm.
fn condition(r: &Integers, inverse: &Integers) -> f64 {
    let largest = |x: &Integers| x.iter().flatten().map(|x| x.abs()).max().unwrap() as f64;
    largest(r) * largest(inverse)
}

/// A plant whose F is known.
struct Known<'a> {
    k: &'a Integers,
    outputs: usize,
    a0: &'a Integers,
    p: [f64; 2],
    /// `F'P + PF + 2 rate P < 0` iff the rate is below this, with P = diag(p).
    boundary: f64,
}

/// The verdicts at rates next to the boundary. 2^-44 is above the rounding errors of the decision: F has entries of at
/// most 30 boundaries, is enclosed up to some 2^-53 of them, and enters sums of few terms.
fn check(known: &Known<'_>, (r, inverse): &(Integers, Integers), units: &[i32]) {
    let s = product(known.k, r);
    let a = stored(&product(&product(inverse, known.a0), r), units, units);
    let (measured, other) = s.split_at(known.outputs);
    let none = vec![0; s.len()];
    let (c, t) = (stored(&measured.to_vec(), &none, units), stored(&other.to_vec(), &none, units));
    let p = Matrix::from_fn(2, 2, |i, j| if i == j { known.p[i] } else { 0.0 });
    for (factor, expected) in [(1.0 - 2f64.powi(-44), true), (1.0 + 2f64.powi(-44), false)] {
        let [rank, _, verdict] = reduced_order((&a, &c), &t, &p, known.boundary * factor);
        assert!(rank.is_proved());
        assert_eq!((verdict.is_proved(), verdict.is_refuted()), (expected, !expected), "{verdict} at {factor}");
    }
}

/// Of growing condition numbers, in usual and in strange units.
fn check_all(known: &Known<'_>) {
    for (k, least) in [(1, 1.0), (10, 1e6), (40, 1e9), (90, 1e11)] {
        let r = unimodular(3, k);
        assert!(condition(&r.0, &r.1) >= least);
        check(known, &r, &[0, 0, 0]);
        check(known, &r, &[-200, 0, 170]);
    }
}

/// Two outputs and two states of an observer of a plant of order 3: the columns of K are those of a Hadamard matrix.
fn hadamard() -> Integers {
    vec![vec![1, 1, 1], vec![-1, 1, -1], vec![1, -1, -1], vec![-1, -1, 1]]
}

#[test]
fn one_more_row_than_columns_does_not_square_the_condition() {
    // F = -K_T diag(1, 2, 3) K_T' = [-6 2; 2 -6], with the eigenvalues -4 and -8.
    let a0 = vec![vec![-4, 0, 0], vec![0, -8, 0], vec![0, 0, -12]];
    check_all(&Known { k: &hadamard(), outputs: 2, a0: &a0, p: [1.0, 1.0], boundary: 4.0 });
}

fn identity() -> Integers {
    vec![vec![1, 0, 0], vec![0, 1, 0], vec![0, 0, 1]]
}

#[test]
fn a_square_matrix_is_not_squared() {
    // F = [-2 1; 1 -2], with the eigenvalues -1 and -3.
    let symmetric = vec![vec![1, -5, 2], vec![7, -2, 1], vec![-3, 1, -2]];
    check_all(&Known { k: &identity(), outputs: 1, a0: &symmetric, p: [1.0, 1.0], boundary: 1.0 });
    // F = [-1 8; 0 -1], P = diag(1, 100): [2r - 2, 8; 8, 200 r - 200] is singular at 1 - r = 0.4.
    let triangular = vec![vec![1, -5, 2], vec![7, -1, 8], vec![-3, 0, -1]];
    check_all(&Known { k: &identity(), outputs: 1, a0: &triangular, p: [1.0, 100.0], boundary: 0.6 });
}

#[test]
fn a_plant_beyond_exact_residuals() {
    // 81 copies of R = [1 k; k 1 + k^2], of which the first row is measured: F = -3 I.
    let (copies, k) = (81, 3);
    let n = 2 * copies;
    let r = unimodular(2, k);
    let block = product(&product(&r.1, &vec![vec![1, 2], vec![4, -3]]), &r.0);
    let row = |of: &Vec<i128>, copy: usize| -> Vec<i128> {
        (0..n).map(|j| if j / 2 == copy { of[j % 2] } else { 0 }).collect()
    };
    let rows = |of: &Integers| -> Integers {
        (0..copies).flat_map(|copy| of.iter().map(move |of| (of, copy))).map(|(of, copy)| row(of, copy)).collect()
    };
    let none = vec![0; n];
    let a = stored(&rows(&block), &none, &none);
    let (c, t) =
        (stored(&rows(&vec![r.0[0].clone()]), &none, &none), stored(&rows(&vec![r.0[1].clone()]), &none, &none));
    let p = Matrix::from_fn(copies, copies, |i, j| if i == j { 1.0 } else { 0.0 });
    let at = |rate: f64| reduced_order((&a, &c), &t, &p, rate);
    assert!(at(3.0 * (1.0 - 1e-9))[2].is_proved() && at(3.0 * (1.0 + 1e-9))[2].is_refuted());
}

#[test]
fn a_t_that_repeats_the_outputs_defines_nothing() {
    let (a, c) = (Matrix::from_rows([[0.0, 1.0], [0.0, 0.0]]), Matrix::from_rows([[1.0, 0.0]]));
    let found = reduced_order((&a, &c), &Matrix::from_rows([[2.0, 0.0]]), &Matrix::from_rows([[1.0]]), 0.0);
    assert!(found[0].is_refuted() && !found[2].is_proved());
}

/// C of four outputs and its inverse; `T = C^-1 (I - KK'/4) C` for an E of three columns.
#[test]
fn the_decoupling_of_three_disturbances_is_not_squared() {
    let k = hadamard();
    let transposed: Integers = (0..3).map(|j| k.iter().map(|row| row[j]).collect()).collect();
    let removed = product(&k, &transposed);
    let (c, inverse) = unimodular(4, 1);
    // A = C^-1 A0 C and L = C^-1 L0 with (I - KK'/4) A0 - L0 = -diag(1, 2, 3, 4); A0 is a multiple of 4.
    let a0: Integers = vec![vec![4, -8, 0, 12], vec![0, 4, 16, -4], vec![8, 8, -4, 0], vec![-12, 0, 4, 8]];
    let seen = product(&removed, &a0);
    let l0 = |i: usize, j: usize| a0[i][j] - seen[i][j] / 4 + if i == j { i as i128 + 1 } else { 0 };
    let l0: Integers = (0..4).map(|i| (0..4).map(|j| l0(i, j)).collect()).collect();
    let none = [0; 4];
    let plain = |x: &Integers| stored(x, &none, &none);
    let (a, l) = (plain(&product(&product(&inverse, &a0), &c)), plain(&product(&inverse, &l0)));
    // With P = C'C the decrease is C'(-2 diag(1, 2, 3, 4) + 2 rate I)C.
    let c_transposed: Integers = (0..4).map(|j| c.iter().map(|row| row[j]).collect()).collect();
    let p = plain(&product(&c_transposed, &c));
    for (entry, least) in [(1, 1.0), (10, 1e6), (40, 1e9), (90, 1e11)] {
        let r = unimodular(3, entry);
        assert!(condition(&r.0, &r.1) >= least);
        for units in [[0, 0, 0], [-200, 0, 170]] {
            let e = stored(&product(&product(&inverse, &k), &r.0), &none, &units);
            let plant = without_inputs(&a, &plain(&c));
            // T is rounded before it meets A and P, whose entries and inverses of eigenvalues multiply its 2^-53.
            for (rate, expected) in [(1.0 - 2f64.powi(-28), true), (1.0 + 2f64.powi(-28), false)] {
                let (plant, e, l, p) = (plant.clone(), e.clone(), l.clone(), p.clone());
                let [rank, _, verdict] = facts(UnknownInputConvergence { plant, e, l, cubic: None, p, rate });
                assert!(rank.is_proved());
                assert_eq!((verdict.is_proved(), verdict.is_refuted()), (expected, !expected), "{verdict} at {rate}");
            }
        }
    }
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 100, failure_persistence: None, ..ProptestConfig::default() })]

    /// Whatever the condition of R and the units: the F that is enclosed is `K_T A0 K_T'/h`, so that the rate of the
    /// symmetric F is decided on both sides.
    #[test]
    fn f_is_that_of_the_well_conditioned_coordinates(
        k in -90_i128..=90, diagonal in prop::collection::vec(1_i128..20, 3),
        above in prop::collection::vec(-9_i128..=9, 2), units in prop::collection::vec(-150_i32..=150, 3),
    ) {
        let r = unimodular(3, k);
        // F = [-a b; b -a], of which -a + |b| is the larger eigenvalue.
        let a = diagonal[0] + 10;
        let a0 = vec![vec![1, -5, 2], vec![above[0], -a, above[1]], vec![7, above[1], -a]];
        let boundary = (a - above[1].abs()) as f64;
        check(&Known { k: &identity(), outputs: 1, a0: &a0, p: [1.0, 1.0], boundary }, &r, &units);
        // F = [-a b; b -a] with a the sum of all and b = d1 - d2 + d3.
        let (sum, cross) = (diagonal.iter().sum::<i128>(), diagonal[0] - diagonal[1] + diagonal[2]);
        let a0 = (0..3).map(|i| (0..3).map(|j| if i == j { -4 * diagonal[i] } else { 0 }).collect()).collect();
        let boundary = (sum - cross.abs()) as f64;
        check(&Known { k: &hadamard(), outputs: 2, a0: &a0, p: [1.0, 1.0], boundary }, &r, &units);
    }
}
