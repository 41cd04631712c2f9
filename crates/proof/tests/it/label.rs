//! Labels: what is read, what is refused, and that each is decided as what it says.

use luenberger_proof::label::Names;
use luenberger_proof::{Exact, Interval, Matrix, ProofError, Ring, Verdict, negative_definite};
use proptest::prelude::*;

fn m<const R: usize, const C: usize>(rows: [[f64; C]; R]) -> Matrix<f64> {
    Matrix::from_rows(rows)
}

/// The margins are those of 1 x 1 and 2 x 2 matrices by hand.
#[test]
fn every_form_of_the_language_is_what_it_says() {
    let (a, p) = (m([[1.0, 2.0], [0.0, -3.0]]), m([[2.0, 1.0], [1.0, 3.0]]));
    let (b, c, list) = (m([[1.0], [-1.0]]), m([[0.0, 2.0]]), [4.0, 0.5]);
    let swap = m([[0.0, 1.0], [1.0, 0.0]]);
    let names = Names::new().matrix("A", &a).symmetric("P", &p).matrix("B", &b).matrix("C", &c);
    let names = names.number("rate", 0.25).number("gamma", 3.0).list("lambda", &list);
    let names = names.define("S~", "-CB").expect("an expression").define("J", "[rate, 1; -2 rate, 0]").expect("one");
    // Names that are phrases: the sum over a list, and a block matrix.
    let names = names.define("sum lambda P", "diag(lambda)P").expect("one").matrix("[0 I; I 0]", &swap);
    // The left side less the right one, or the other way round, entry by entry.
    for (label, expected) in [
        ("P > 0", vec![2.0, 1.0, 1.0, 3.0]),
        ("-P < 0 (12)", vec![2.0, 1.0, 1.0, 3.0]),
        ("P + I > 0 (13')", vec![3.0, 1.0, 1.0, 4.0]),
        ("I - P < 0", vec![1.0, 1.0, 1.0, 2.0]),
        ("A + A' < 8 I", vec![6.0, -2.0, -2.0, 14.0]),
        ("2 P >= 0", vec![4.0, 2.0, 2.0, 6.0]),
        ("gamma^2 P >= 0", vec![18.0, 9.0, 9.0, 27.0]),
        // PA = [2 1; 1 -7].
        ("A'P + PA < 5 I", vec![1.0, -2.0, -2.0, 19.0]),
        ("PA + A'P < 5 I", vec![1.0, -2.0, -2.0, 19.0]),
        ("He(PA) < 5 I", vec![1.0, -2.0, -2.0, 19.0]),
        ("A'P + PA + 2 rate P < 7 I", vec![2.0, -2.5, -2.5, 19.5]),
        ("He(PA) + 2 rate P < 7 I", vec![2.0, -2.5, -2.5, 19.5]),
        // A'PA = [2 1; 1 23].
        ("A'PA - P > -I", vec![1.0, 0.0, 0.0, 21.0]),
        ("(P + A'PA)/2 > 0", vec![2.0, 1.0, 1.0, 13.0]),
        ("(1 - rate^2)P/2 > 0", vec![0.9375, 0.46875, 0.46875, 1.40625]),
        ("(AB)'AB > 0", vec![10.0]),
        ("B'PB > 0", vec![3.0]),
        ("tr P < gamma^2", vec![4.0]),
        ("tr A'PA < gamma^2 gamma", vec![2.0]),
        // S~ = 2.
        ("S~ + S~' > 0", vec![4.0]),
        ("CA C' < 0", vec![12.0]),
        ("[P, PB; *, gamma^2 I] > 0", vec![2.0, 1.0, 1.0, 1.0, 3.0, -2.0, 1.0, -2.0, 9.0]),
        ("[gamma I, C'; *, 2] > 0", vec![3.0, 0.0, 0.0, 0.0, 3.0, 2.0, 0.0, 2.0, 2.0]),
        ("[gamma, rate; *, 1] > 0", vec![3.0, 0.25, 0.25, 1.0]),
        ("P - diag(lambda) < 5 I", vec![7.0, -1.0, -1.0, 2.5]),
        ("J'J > 0", vec![0.3125, 0.25, 0.25, 1.0]),
        ("J'J > 0 for J = [rate, 1; -2 rate, 0] (7)", vec![0.3125, 0.25, 0.25, 1.0]),
        // diag(lambda)P = [8 4; 1/2 3/2].
        ("He(sum lambda P) > -I", vec![17.0, 4.5, 4.5, 4.0]),
        ("3 P - [0 I; I 0] > 0", vec![6.0, 2.0, 2.0, 9.0]),
        ("[0 I; I 0]P[0 I; I 0] > 0", vec![3.0, 1.0, 1.0, 2.0]),
    ] {
        let n = expected.len().isqrt();
        let expected = Matrix::from_fn(n, n, |i, j| expected[i * n + j]);
        let verdict = names.decide(label).unwrap_or_else(|why| panic!("{label}: {why}"));
        let Verdict::Proved { margin } = verdict else { panic!("{label}: {verdict:?}") };
        let by_hand = negative_definite(&expected.map(|x| -x)).expect("symmetric").margin().expect("definite");
        // Of rounded entries a little less is proved than the least eigenvalue.
        assert!((0.95 * by_hand..=by_hand * (1.0 + 1e-14)).contains(&margin), "{label}: {margin} for {by_hand}");
    }
}

/// Every name, sign and bracket that is missing or too many, and matrices that do not fit.
#[test]
fn what_is_no_inequality_is_refused() {
    let (a, p, l) = (m([[1.0, 2.0], [0.0, -3.0]]), m([[2.0, 1.0], [1.0, 3.0]]), m([[1.0], [2.0]]));
    let names = Names::new().matrix("A", &a).symmetric("P", &p).matrix("L", &l).number("rate", 1.0);
    let names = names.define("J", "2 P").expect("an expression");
    for label in [
        "",
        "P",
        "P >",
        "P > ",
        "> 0",
        "P > 0 ",
        " P > 0",
        "P >> 0",
        "P = 0",
        "P > 0 (12",
        "P > 0 (see (12))",
        "Q > 0",
        "P + > 0",
        "P - - P > 0",
        "(P > 0",
        "P) > 0",
        "[P, P; *] > 0",
        "[P, P; * P] > 0",
        "[*, P; P, P] > 0",
        "P^3 > 0",
        "P/3 > 0",
        "'P > 0",
        "P + rate > 0",
        "He(P > 0",
        "diag(P > 0",
        "P > 0 for P = A",
        "P > 0 for P = P",
        "P > 0 for J = P",
        "P > 0 for J = 2 P > 0",
        "P > 0 for J",
        "P > 0 for 2 P",
        "P > 0 (12) for J = 2 P",
        "P\u{2032}A > 0",
    ] {
        let found = names.decide(label);
        assert!(matches!(found, Err(ProofError::Label { .. })), "{label}: {found:?}");
    }
    for (label, what, expected) in [
        ("LP > 0", "L", (2, 2)),
        ("A + L > 0", "L", (2, 2)),
        ("LA + PL > 0", "L", (2, 2)),
        ("tr LP < rate", "L", (2, 2)),
    ] {
        let found = names.decide(label);
        assert!(
            matches!(found, Err(ProofError::DimensionMismatch { what: w, expected: e, .. }) if w == what && e == expected),
            "{label}: {found:?}"
        );
    }
    let nan = Names::new().symmetric("P", &p).number("rate", f64::NAN);
    assert!(matches!(nan.decide("P + rate P > 0"), Err(ProofError::NotFinite { what: "rate", .. })));
    assert!(names.decide("P > 0").expect("what is not used is not examined").is_proved());
    assert!(matches!(Names::new().define("F", "A - LC"), Err(ProofError::Label { .. })));
}

/// x' = a x with a between -1.1 and -0.9; a point of an interval is exact.
#[test]
fn bounds_are_kept_apart_from_numbers() {
    let p = m([[1.0]]);
    let a = |lo, hi| Matrix::from_rows([[Interval::new(lo, hi).expect("in order")]]);
    let at = |lo, hi, rate| {
        let names = Names::new().within("A", &a(lo, hi)).symmetric("P", &p).number("rate", rate);
        names.decide("A'P + PA + 2 rate P < 0").expect("shapes agree")
    };
    assert!(at(-1.1, -0.9, 0.8).is_proved());
    assert!(matches!(at(-1.1, -0.9, 1.0), Verdict::Undecided { .. }));
    assert!(at(-1.1, -0.9, 1.2).is_refuted());
    assert!(at(-1.0, -1.0, 1.0).is_refuted(), "0 is not negative");
    assert!(at(-1.0, -1.0, 1.0_f64.next_down()).is_proved());
}

fn exact(m: &Matrix<f64>) -> Matrix<Exact> {
    Matrix::embed(m, "a test").expect("finite")
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(96))]

    /// The margin that is proved of a label is one of the exact matrix, formed by hand without the forms that the
    /// evaluation knows; and a little more than the least eigenvalue would show is not proved.
    #[test]
    fn a_margin_is_one_of_the_exact_matrix(
        (n, entries) in (1..=4_usize).prop_flat_map(|n| (Just(n), prop::collection::vec(-2.0..2.0_f64, 4 * n * n))),
        rate in -1.0..1.0_f64,
    ) {
        let part = |k: usize| Matrix::from_fn(n, n, |i, j| entries[k * n * n + i * n + j]);
        let (a, l, c) = (part(0), part(1), part(2));
        let p = Matrix::from_fn(n, n, |i, j| entries[3 * n * n + i.max(j) * n + i.min(j)]);
        let names = Names::new().matrix("A", &a).matrix("C", &c).matrix("L", &l).symmetric("P", &p).number("rate", rate);
        let (ea, el, ec, ep) = (exact(&a), exact(&l), exact(&c), exact(&p));
        let f = ea.difference(&el.product(&ec).unwrap()).unwrap();
        let fp = f.transpose().product(&ep).unwrap();
        let pf = ep.product(&f).unwrap();
        let twice = Exact::from_f64(2.0 * rate).unwrap();
        let lyapunov = fp.sum(&pf).unwrap().sum(&ep.scaled(&twice)).unwrap();
        let stein = fp.product(&f).unwrap().difference(&ep).unwrap();
        for (label, by_hand) in [
            ("(A - LC)'P + P(A - LC) + 2 rate P < 0", lyapunov),
            ("(A - LC)'P(A - LC) - P < 0", stein),
        ] {
            let verdict = names.decide(label).unwrap();
            let expected = negative_definite(&by_hand).unwrap();
            prop_assert_eq!(verdict.is_proved(), expected.is_proved(), "{}", label);
            prop_assert_eq!(verdict.is_refuted(), expected.is_refuted(), "{}", label);
            if let Some(margin) = verdict.margin() {
                let left = by_hand.sum(&Matrix::scalar(n, &Exact::from_f64(margin).unwrap())).unwrap();
                prop_assert!(luenberger_proof::negative_semidefinite(&left).unwrap().is_proved(), "{} {}", label, margin);
            }
        }
    }
}
