//! The three judges of definiteness against each other, on matrices chosen to deceive them.
//!
//! `PROPTEST_CASES=100000 cargo test -p luenberger-proof definiteness` tries millions.

use luenberger_proof::{
    Direction, Exact, Interval, Matrix, ProofError, Ring, UndecidedReason, Verdict, negative_definite,
    negative_semidefinite, positive_definite, positive_semidefinite, quadratic_form,
};
use proptest::prelude::*;

fn exactly(m: &Matrix<f64>) -> Matrix<Exact> {
    Matrix::embed(m, "M").expect("finite")
}

/// An independent judge: all principal minors, by Laplace expansion on exact numbers. Slow and obviously right.
fn determinant(m: &Matrix<Exact>, rows: &[usize]) -> Exact {
    fn expand(m: &Matrix<Exact>, rows: &[usize], columns: &[usize]) -> Exact {
        let Some((&first, rest)) = rows.split_first() else { return Exact::power_of_two(0) };
        let mut sum = Exact::zero();
        for (k, &column) in columns.iter().enumerate() {
            let others: Vec<usize> = columns.iter().copied().filter(|&c| c != column).collect();
            let term = m[(first, column)].mul(&expand(m, rest, &others));
            sum = if k % 2 == 0 { sum.add(&term) } else { sum.sub(&term) };
        }
        sum
    }
    expand(m, rows, rows)
}

fn is_semidefinite(m: &Matrix<Exact>) -> bool {
    (1..1_usize << m.rows()).all(|subset| {
        let rows: Vec<usize> = (0..m.rows()).filter(|i| subset >> i & 1 == 1).collect();
        determinant(m, &rows).signum() >= 0
    })
}

fn is_definite(m: &Matrix<Exact>) -> bool {
    (1..=m.rows()).all(|k| determinant(m, &(0..k).collect::<Vec<_>>()).signum() > 0)
}

/// What the witness says, recomputed: its value is a bound, of the right sign, along a direction that is not zero.
fn assert_witness(m: &Matrix<Exact>, witness: &Direction, strict: bool) {
    let v: Vec<Exact> = match &witness.exact {
        Some(v) => v.clone(),
        None => witness.v.iter().map(|&x| Exact::from_f64(x).expect("finite")).collect(),
    };
    assert!(v.iter().any(|x| !x.is_zero()), "the direction is zero");
    let form = quadratic_form(m, &v).expect("shapes agree");
    assert!(form.signum() < 0 || (strict && form.is_zero()), "v'Mv = {form:?} refutes nothing");
    assert!(form <= Exact::from_f64(witness.value).expect("finite"), "the value is no upper bound");
}

/// `lambda_min(M) >= margin`, by the minors of `M - margin I`.
fn assert_margin(m: &Matrix<Exact>, margin: f64) {
    let c = Exact::from_f64(margin).expect("finite");
    assert!(margin >= 0.0);
    let shifted = m.difference(&Matrix::scalar(m.rows(), &c)).expect("square");
    assert!(is_semidefinite(&shifted), "the margin {margin:e} is above the least eigenvalue");
}

fn assert_true(m: &Matrix<f64>) {
    let e = exactly(m);
    let enclosed: Matrix<Interval> = Matrix::embed(m, "M").expect("finite");
    // The same numbers with one float of doubt on each side.
    let wide = m.map(|&x| Interval::new(x.next_down(), x.next_up()).expect("ordered"));
    let (definite, semidefinite) = (is_definite(&e), is_semidefinite(&e));
    for (strict, truth) in [(true, definite), (false, semidefinite)] {
        let ask = if strict { [pd(m), pd(&enclosed), pd(&e)] } else { [psd(m), psd(&enclosed), psd(&e)] };
        for verdict in ask {
            match &verdict {
                Verdict::Proved { margin } => {
                    assert!(truth, "wrongly proved: {m:?}");
                    assert_margin(&e, *margin);
                }
                Verdict::Refuted { witness } => {
                    assert!(!truth, "wrongly refuted: {m:?}");
                    assert_witness(&e, witness, strict);
                }
                Verdict::Undecided { .. } => panic!("the referee was not called on {m:?}"),
            }
        }
        match if strict { pd(&wide) } else { psd(&wide) } {
            Verdict::Proved { margin } => {
                assert!(truth);
                assert_margin(&e, margin);
            }
            Verdict::Refuted { witness } => assert_witness(&e, &witness, strict),
            Verdict::Undecided { .. } => {}
        }
    }
    let negative = m.map(|x| -x);
    // The same but for the sign of the form.
    let turned = |mut verdict: Verdict<Direction>| {
        if let Verdict::Refuted { witness } = &mut verdict {
            witness.is_negated = !witness.is_negated;
        }
        verdict
    };
    assert_eq!(turned(negative_definite(&negative).expect("symmetric")), pd(m));
    assert_eq!(turned(negative_semidefinite(&negative).expect("symmetric")), psd(m));
}

fn pd<T: luenberger_proof::Entry>(m: &Matrix<T>) -> Verdict<Direction> {
    positive_definite(m).expect("symmetric and finite")
}

fn psd<T: luenberger_proof::Entry>(m: &Matrix<T>) -> Verdict<Direction> {
    positive_semidefinite(m).expect("symmetric and finite")
}

fn symmetric(n: usize, entries: &[f64]) -> Matrix<f64> {
    Matrix::from_fn(n, n, |i, j| entries[i.max(j) * (i.max(j) + 1) / 2 + i.min(j)])
}

/// `X X'` in floating point: of rank r up to rounding, so that the truth hangs on the last digits.
fn product(n: usize, r: usize, x: &[f64]) -> Matrix<f64> {
    Matrix::from_fn(n, n, |i, j| {
        let (i, j) = (i.max(j), i.min(j));
        (0..r).map(|k| x[i * r + k] * x[j * r + k]).sum()
    })
}

/// Multiplies row and column i by 2^k_i: exact but for underflow, which makes another matrix, no wrong one.
fn scaled(m: &Matrix<f64>, k: &[i32]) -> Matrix<f64> {
    Matrix::from_fn(m.rows(), m.rows(), |i, j| {
        let (i, j) = (i.max(j), i.min(j));
        (m[(i, j)] * 2.0_f64.powi(k[i])) * 2.0_f64.powi(k[j])
    })
}

fn nudged(m: &Matrix<f64>, entry: usize, up: bool) -> Matrix<f64> {
    let (i, j) = (entry / m.rows() % m.rows(), entry % m.rows());
    Matrix::from_fn(m.rows(), m.rows(), |r, c| {
        let x = m[(r, c)];
        if (r, c) == (i, j) || (r, c) == (j, i) { if up { x.next_up() } else { x.next_down() } } else { x }
    })
}

proptest! {
    /// Small integers: exactly singular ones are frequent.
    #[test]
    fn small_integers((n, entries) in (1..=5_usize).prop_flat_map(|n| (Just(n), prop::collection::vec(-3..=6_i32, n * (n + 1) / 2)))) {
        let entries: Vec<f64> = entries.into_iter().map(f64::from).collect();
        assert_true(&symmetric(n, &entries));
    }

    /// Rank-deficient up to the rounding of a product, then one entry moved by one float, then badly scaled.
    #[test]
    fn rank_deficient_by_one_ulp(
        (n, r, x) in (1..=5_usize, 1..=5_usize).prop_flat_map(|(n, r)| (Just(n), Just(r), prop::collection::vec(-1.0..1.0_f64, n * r))),
        entry in 0..25_usize,
        up: bool,
        k in prop::collection::vec(-40..40_i32, 5),
    ) {
        let m = product(n, r, &x);
        assert_true(&m);
        let m = nudged(&m, entry, up);
        assert_true(&m);
        assert_true(&scaled(&m, &k));
    }

    /// Integer vectors: exactly of rank r, nudged and not.
    #[test]
    fn exactly_rank_deficient(
        (n, r, x) in (2..=5_usize, 1..=3_usize).prop_flat_map(|(n, r)| (Just(n), Just(r), prop::collection::vec(-9..=9_i32, n * r))),
        entry in 0..25_usize,
        up: bool,
        k in prop::collection::vec(-400..400_i32, 5),
    ) {
        let x: Vec<f64> = x.into_iter().map(f64::from).collect();
        let m = product(n, r, &x);
        assert_true(&m);
        assert_true(&scaled(&m, &k));
        assert_true(&nudged(&m, entry, up));
    }

    /// Any bit patterns that are numbers.
    #[test]
    fn wild((n, bits) in (1..=4_usize).prop_flat_map(|n| (Just(n), prop::collection::vec(any::<u64>(), n * (n + 1) / 2)))) {
        let entries: Vec<f64> = bits.iter().map(|&b| f64::from_bits(b)).map(|x| if x.is_finite() { x } else { 1.0 }).collect();
        assert_true(&symmetric(n, &entries));
    }

    /// Subnormals, whose products underflow.
    #[test]
    fn denormals((n, bits) in (1..=4_usize).prop_flat_map(|n| (Just(n), prop::collection::vec(0..60_u64, n * (n + 1) / 2)))) {
        let mut entries: Vec<f64> = bits.iter().map(|&b| f64::from_bits(b)).collect();
        assert_true(&symmetric(n, &entries));
        for i in 0..n {
            entries[i * (i + 1) / 2 + i] = 1.0;
        }
        assert_true(&symmetric(n, &entries));
    }

    /// An interval matrix is proved only if every matrix within is definite, and refuted only if none is.
    #[test]
    fn intervals_speak_for_every_matrix_within(
        (n, entries) in (1..=4_usize).prop_flat_map(|n| (Just(n), prop::collection::vec(-1.0..1.0_f64, n * (n + 1) / 2))),
        radius in prop::sample::select(vec![1e-14, 1e-3, 0.1, 0.5]),
        within in prop::collection::vec(-1.0..1.0_f64, 10),
    ) {
        let mut m = symmetric(n, &entries);
        for i in 0..n { m[(i, i)] = m[(i, i)].abs() + 1.0; }
        let wide = m.map(|&x| Interval::around(x, radius).expect("finite"));
        let verdict = pd(&wide);
        for shift in 0..8 {
            let shifts: Vec<f64> = (0..10).map(|k| within[(k + shift) % 10].signum() * radius * if shift < 4 { 1.0 } else { within[k].abs() }).collect();
            let inside = Matrix::from_fn(n, n, |i, j| {
                let k = i.max(j) * (i.max(j) + 1) / 2 + i.min(j);
                m[(i, j)] + shifts[k]
            });
            let e = exactly(&inside);
            match &verdict {
                Verdict::Proved { margin } => { prop_assert!(is_definite(&e)); assert_margin(&e, *margin); }
                Verdict::Refuted { witness } => assert_witness(&e, witness, true),
                Verdict::Undecided { why, .. } => {
                    let is_wide = matches!(why, UndecidedReason::DataTooUncertain { width } if *width >= radius);
                    prop_assert!(is_wide, "{:?}", why);
                }
            }
        }
    }
}

/// Rows of the identity, rotated by a chain of exact-looking rotations: enough to fill a matrix with a chosen spectrum.
fn with_spectrum(spectrum: &[f64]) -> Matrix<f64> {
    let n = spectrum.len();
    let mut m = Matrix::from_fn(n, n, |i, j| if i == j { spectrum[i] } else { 0.0 });
    for (step, (i, j)) in (0..n).flat_map(|i| (i + 1..n).map(move |j| (i, j))).enumerate() {
        let (sin, cos) = (0.3 + step as f64).sin_cos();
        let rotate = |m: &Matrix<f64>| {
            Matrix::from_fn(n, n, |r, c| match r {
                _ if r == i => cos * m[(i, c)] - sin * m[(j, c)],
                _ if r == j => sin * m[(i, c)] + cos * m[(j, c)],
                _ => m[(r, c)],
            })
        };
        m = rotate(&rotate(&m).transpose());
    }
    Matrix::from_fn(n, n, |i, j| f64::midpoint(m[(i, j)], m[(j, i)]))
}

#[test]
fn the_margin_is_tight_for_every_condition_number_that_binary64_can_hold() {
    for (least, tightness) in [(1.0, 1e-9), (1e-4, 1e-8), (1e-8, 2e-4), (1e-12, 2e-4)] {
        let spectrum: Vec<f64> = (0..12).map(|k| if k == 0 { least } else { 1.0 + f64::from(k) }).collect();
        let m = with_spectrum(&spectrum);
        let margin = pd(&m).margin().expect("positive definite, even rounded");
        // Rounding moved the spectrum that was asked for; what the margin is measured against is the matrix itself.
        assert!(margin > 0.9 * least && margin < 1.1 * least, "{margin:e} for {least:e}");
        let above = Exact::from_f64(margin * (1.0 + tightness)).expect("finite");
        let shifted = exactly(&m).difference(&Matrix::scalar(12, &above)).expect("square");
        assert!(psd(&shifted).is_refuted(), "{margin:e} is not within {tightness:e} of the least eigenvalue");
    }
}

#[test]
fn condition_1e16_is_decided_and_never_wrongly() {
    for k in 0..40 {
        let least = (f64::from(k) - 20.0) * 1e-17;
        let m = with_spectrum(&[least, 1.0, 0.7, 0.3, 0.9]);
        assert_true(&m);
    }
}

#[test]
fn hilbert_matrices_stay_definite_until_their_rounding_says_otherwise() {
    // The least eigenvalues of the exact matrices are 3.3e-6 (n = 5), 1.1e-13 (n = 10), 3e-21 (n = 15); rounding moves
    // entries by 1e-17.
    for n in 1..=20 {
        let m = Matrix::from_fn(n, n, |i, j| 1.0 / (i + j + 1) as f64);
        let verdict = pd(&m);
        match n {
            1..=11 => assert!(verdict.margin().is_some_and(|margin| margin > 0.0), "n = {n}: {verdict:?}"),
            15.. => assert!(verdict.is_refuted(), "n = {n}: {verdict:?}"),
            _ => assert!(!matches!(verdict, Verdict::Undecided { .. })),
        }
        if let Verdict::Refuted { witness } = &verdict {
            assert_witness(&exactly(&m), witness, true);
        }
    }
}

#[test]
fn scales_that_span_the_range_of_binary64_do_not_hide_definiteness() {
    let m = Matrix::from_rows([[1e300, 0.9, 0.0], [0.9, 1e-300, 1e-310], [0.0, 1e-310, 1e-318]]);
    assert_true(&m);
    let margin = pd(&Matrix::from_rows([[1e300, 0.9], [0.9, 1e-300]])).margin().expect("determinant 0.19");
    assert!(margin > 1.8e-301 && margin < 1.91e-301, "{margin:e}");
    assert!(pd(&Matrix::from_rows([[1e300, 1.1], [1.1, 1e-300]])).is_refuted());
    assert_true(&Matrix::from_rows([[f64::MAX, f64::MAX], [f64::MAX, f64::MAX]]));
    assert_true(&Matrix::from_rows([[f64::MAX, 1.0], [1.0, f64::from_bits(1)]]));
}

#[test]
fn exact_entries_beyond_the_range_of_binary64_are_decided() {
    let large = Exact::from_f64(1e300).expect("finite");
    let large = large.mul(&large);
    let small = Exact::from_f64(1e-300).expect("finite");
    let small = small.mul(&small);
    let m = |last: &Exact| {
        Matrix::from_rows([[large.clone(), Exact::power_of_two(0)], [Exact::power_of_two(0), last.clone()]])
    };
    assert!(pd(&m(&small.add(&small))).is_proved());
    assert!(pd(&m(&small.shifted(-1))).is_refuted());
}

#[test]
fn an_exactly_singular_matrix_is_semidefinite_with_no_room() {
    let m = Matrix::from_rows([[1.0, 2.0, 3.0], [2.0, 4.0, 6.0], [3.0, 6.0, 9.0]]);
    assert_eq!(psd(&m), Verdict::Proved { margin: 0.0 });
    let Verdict::Refuted { witness } = pd(&m) else { panic!("singular") };
    assert_witness(&exactly(&m), &witness, true);
}

#[test]
fn a_null_vector_that_binary64_cannot_hold_is_given_exactly() {
    // The null vector (b, -a) of [[a^2, ab], [ab, b^2]] is exact; that of a rank-2 matrix of 53-bit products needs more
    // digits.
    let (a, b) = (Exact::from_f64(0.1).expect("finite"), Exact::from_f64(0.7).expect("finite"));
    let c = Exact::from_f64(0.3).expect("finite");
    let x = Matrix::from_rows([[a.clone(), b.clone()], [b, c.clone()], [c, a]]);
    let m = x.product(&x.transpose()).expect("shapes agree");
    assert_eq!(psd(&m), Verdict::Proved { margin: 0.0 });
    let Verdict::Refuted { witness } = pd(&m) else { panic!("singular") };
    assert!(witness.exact.is_some());
    assert_witness(&m, &witness, true);
}

#[test]
fn large_orders_are_proved_and_refuted_without_the_referee() {
    let n = 150;
    let m = Matrix::from_fn(n, n, |i, j| {
        if i == j {
            2.0
        } else if i.abs_diff(j) == 1 {
            -1.0
        } else {
            0.0
        }
    });
    let least = 4.0 * (std::f64::consts::PI / (2.0 * (n as f64 + 1.0))).sin().powi(2);
    let margin = pd(&m).margin().expect("the discrete Laplacian");
    assert!(margin <= least && margin > least * (1.0 - 1e-6));
    let shifted = Matrix::from_fn(n, n, |i, j| m[(i, j)] - if i == j { least * (1.0 + 1e-6) } else { 0.0 });
    assert!(psd(&shifted).is_refuted());
    let singular = Matrix::from_fn(n, n, |i, j| if i == j && (i == 0 || i == n - 1) { 1.0 } else { m[(i, j)] });
    assert!(
        matches!(psd(&singular), Verdict::Undecided { why: UndecidedReason::RoundingDominates { order: 150, .. }, .. }),
        "beyond the referee's order the boundary stays undecided"
    );
}

#[test]
fn the_referee_reaches_its_order() {
    let n = luenberger_proof::definite::REFEREE_ORDER;
    let singular = Matrix::from_fn(n, n, |i, j| match i.abs_diff(j) {
        0 if i == 0 || i == n - 1 => 1.0,
        0 => 2.0,
        1 => -1.0,
        _ => 0.0,
    });
    assert_eq!(psd(&singular), Verdict::Proved { margin: 0.0 });
    assert!(pd(&singular).is_refuted());
}

#[test]
fn orders_zero_and_one() {
    let none: Matrix<f64> = Matrix::from_fn(0, 0, |_, _| 0.0);
    assert_eq!(pd(&none), Verdict::Proved { margin: f64::INFINITY });
    assert_eq!(pd(&Matrix::from_rows([[3.5]])), Verdict::Proved { margin: 3.5 });
    assert_eq!(psd(&Matrix::from_rows([[0.0]])), Verdict::Proved { margin: 0.0 });
    assert!(pd(&Matrix::from_rows([[0.0]])).is_refuted());
    assert!(pd(&Matrix::from_rows([[-f64::from_bits(1)]])).is_refuted());
    assert!(psd(&Matrix::from_rows([[-f64::from_bits(1)]])).is_refuted());
    assert!(psd(&Matrix::from_rows([[f64::from_bits(1)]])).is_proved());
}

#[test]
fn bad_input_is_an_error_that_names_the_entry() {
    assert!(matches!(
        positive_definite(&Matrix::from_rows([[1.0, f64::NAN], [f64::NAN, 1.0]])),
        Err(ProofError::NotFinite { row: 0, column: 1, value, .. }) if value.is_nan()
    ));
    assert!(matches!(
        positive_definite(&Matrix::from_rows([[1.0, 0.5], [0.5_f64.next_up(), 1.0]])),
        Err(ProofError::NotSymmetric { row: 0, column: 1, .. })
    ));
    assert!(matches!(
        positive_semidefinite(&Matrix::from_rows([[1.0, 0.5]])),
        Err(ProofError::DimensionMismatch { found: (1, 2), .. })
    ));
    let disjoint =
        [Interval::new(0.0, 0.1), Interval::new(0.2, 0.3), Interval::new(1.0, 1.0)].map(|x| x.expect("ordered"));
    let m = Matrix::from_rows([[disjoint[2], disjoint[0]], [disjoint[1], disjoint[2]]]);
    assert!(matches!(positive_definite(&m), Err(ProofError::NotSymmetric { .. })));
    let unbounded = Matrix::from_rows([[Interval::UNBOUNDED]]);
    assert!(matches!(positive_definite(&unbounded), Ok(Verdict::Undecided { why: UndecidedReason::Overflow, .. })));
}

/// A refutation says the value of the form as the condition has it: of `M < 0` that it is not negative.
#[test]
fn a_refutation_has_the_sign_of_its_condition() {
    let (m, minus) = (Matrix::from_rows([[2.5, 0.0], [0.0, -1.0]]), Matrix::from_rows([[-2.5, 0.0], [0.0, 1.0]]));
    let words = |verdict: Result<Verdict<Direction>, ProofError>| match verdict.unwrap() {
        Verdict::Refuted { witness } => (witness.is_negated, witness.to_string()),
        other => panic!("{other:?}"),
    };
    for verdict in [negative_definite(&m), negative_semidefinite(&m)] {
        assert_eq!(words(verdict), (true, "v = (1, 0), where the form is at least 2.49999".to_owned()));
    }
    for verdict in [positive_definite(&minus), positive_semidefinite(&minus)] {
        assert_eq!(words(verdict), (false, "v = (1, 0), where the form is at most -2.49999".to_owned()));
    }
}
