//! The statements behind Lipschitz and mean-value observers: at their boundary, against equal statements of another
//! form, and on bad data.

use luenberger_proof::certificate::{
    ContractionInCoordinates, SectorConvergence, SectorTerm, Theorem, Vertex, Witness,
};
use luenberger_proof::statement::decay_rate;
use luenberger_proof::{Matrix, ProofError, Verdict};
use proptest::prelude::*;

fn one(x: f64) -> Matrix<f64> {
    Matrix::from_rows([[x]])
}

fn scalar(gamma: f64) -> SectorTerm {
    SectorTerm { g: one(1.0), h: one(1.0), low: -gamma, high: gamma, tau: 0.5 }
}

/// Small integers: every product and sum of a statement is exact in binary64, so that two forms of one matrix can be
/// compared.
fn integers(rows: usize, cols: usize) -> impl Strategy<Value = Matrix<f64>> {
    prop::collection::vec(-4i32..=4, rows * cols).prop_map(move |entries| {
        Matrix::from_row_major(rows, cols, entries.into_iter().map(f64::from).collect()).unwrap()
    })
}

fn symmetric(n: usize) -> impl Strategy<Value = Matrix<f64>> {
    integers(n, n)
        .prop_map(move |m| Matrix::from_fn(n, n, |i, j| m[(i.max(j), i.min(j))] + if i == j { 6.0 } else { 0.0 }))
}

/// Integers with a diagonal far to the left, so that about as many statements hold as do not.
fn damped(n: usize) -> impl Strategy<Value = Matrix<f64>> {
    (integers(n, n), 0i32..=24).prop_map(move |(m, damping)| {
        Matrix::from_fn(n, n, |i, j| m[(i, j)] - if i == j { f64::from(damping) } else { 0.0 })
    })
}

/// The last fact of a theorem with one inequality beside that of its matrix.
fn decided(theorem: impl Into<Theorem>) -> Result<Verdict<Witness>, ProofError> {
    Ok(theorem.into().facts()?.pop().expect("a fact").verdict)
}

/// The block inequality of the S-procedure, for all pairs (A, C) of the vertex.
pub(super) fn sector_decrease_within(
    Vertex { a, c }: Vertex,
    l: &Matrix<f64>,
    p: &Matrix<f64>,
    rate: f64,
    terms: &[SectorTerm],
) -> Result<Verdict<Witness>, ProofError> {
    decided(SectorConvergence { a, c, terms: terms.to_vec(), l: l.clone(), p: p.clone(), rate })
}

/// The same for one pair.
fn sector_decrease(
    a: &Matrix<f64>,
    l: &Matrix<f64>,
    c: &Matrix<f64>,
    p: &Matrix<f64>,
    rate: f64,
    terms: &[SectorTerm],
) -> Result<Verdict<Witness>, ProofError> {
    sector_decrease_within(Vertex::exactly(a, c)?, l, p, rate, terms)
}

fn cascade_decrease(
    j: &Matrix<f64>,
    k: &Matrix<f64>,
    q: &Matrix<f64>,
    injection: f64,
    rate: f64,
) -> Result<Verdict<Witness>, ProofError> {
    decided(ContractionInCoordinates { vertices: vec![j.clone()], k: k.clone(), q: q.clone(), injection, rate })
}

fn same<V, W>(one: &Verdict<V>, other: &Verdict<W>) -> bool {
    (one.is_proved(), one.is_refuted()) == (other.is_proved(), other.is_refuted())
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 256, failure_persistence: None, ..ProptestConfig::default() })]

    /// A slope in [low, high] says the same as one in [-r, r] about A + m G H: the two matrices are congruent by w = w'
    /// + m H e.
    #[test]
    fn a_sector_may_be_moved_into_a(
        a in damped(3), l in integers(3, 1), c in integers(1, 3), p in symmetric(3), g in integers(3, 1), h in integers(1, 3),
        middle in -3i32..=3, radius in 0i32..=3, tau in 1i32..=9,
    ) {
        let (m, r, tau) = (f64::from(middle), f64::from(radius), f64::from(tau));
        let shifted = SectorTerm { g: g.clone(), h: h.clone(), low: m - r, high: m + r, tau };
        let moved = Matrix::from_fn(3, 3, |i, j| a[(i, j)] + m * g[(i, 0)] * h[(0, j)]);
        let centred = SectorTerm { g, h, low: -r, high: r, tau };
        let one = sector_decrease(&a, &l, &c, &p, 0.25, &[shifted]).unwrap();
        let other = sector_decrease(&moved, &l, &c, &p, 0.25, &[centred]).unwrap();
        prop_assert!(same(&one, &other), "{one:?} {other:?}");
    }

    /// What is proved for a sector is proved for every slope in it.
    #[test]
    fn a_proved_sector_covers_every_slope_in_it(
        l in 0i32..=8, p in 1i32..=8, low in -4i32..=0, high in 0i32..=4, tau in 1i32..=8,
    ) {
        let term = SectorTerm { low: f64::from(low), high: f64::from(high), tau: f64::from(tau), ..scalar(1.0) };
        let (l, p) = (one(f64::from(l)), one(f64::from(p)));
        if sector_decrease(&one(0.0), &l, &one(1.0), &p, 0.0, &[term]).unwrap().is_proved() {
            for slope in low..=high {
                let linear = decay_rate(&one(f64::from(slope)), &l, &one(1.0), &p, 0.0).unwrap();
                prop_assert!(linear.is_proved());
            }
        }
    }

    /// Without K the cascade is a decay rate with the gain [g I; 0] and P = [I 0; 0 Q]; with K it is that of T^-1 J T.
    #[test]
    fn the_cascade_is_a_decay_rate_in_other_coordinates(
        j in damped(4), k in integers(2, 2), q in symmetric(2), g in 0i32..=200,
    ) {
        let g = f64::from(g);
        let t = |sign: f64| Matrix::from_fn(4, 4, |row, column| match (row < 2, column < 2) {
            (false, true) => sign * k[(row - 2, column)],
            _ => f64::from(i8::from(row == column)),
        });
        let product = |x: &Matrix<f64>, y: &Matrix<f64>| {
            Matrix::from_fn(4, 4, |row, column| (0..4).map(|i| x[(row, i)] * y[(i, column)]).sum::<f64>())
        };
        let moved = product(&product(&t(-1.0), &j), &t(1.0));
        let gain = Matrix::from_fn(4, 2, |row, column| if row == column { g } else { 0.0 });
        let c = Matrix::from_fn(2, 4, |row, column| f64::from(i8::from(row == column)));
        let p = Matrix::from_fn(4, 4, |row, column| match (row < 2, column < 2) {
            (false, false) => q[(row - 2, column - 2)],
            _ => f64::from(i8::from(row == column)),
        });
        let one = cascade_decrease(&j, &k, &q, g, 0.5).unwrap();
        let other = decay_rate(&moved, &gain, &c, &p, 0.5).unwrap();
        prop_assert!(same(&one, &other), "{one:?} {other:?}");
    }
}

/// x' = phi(x), gain 2, P = 1, tau = 1/2: the matrix is [-4 + gamma^2/2, 1; 1, -1/2], singular at gamma = 2, and
/// decided on both sides of it.
#[test]
fn the_greatest_constant_is_decided_to_the_last_bit() {
    let at = |gamma: f64| sector_decrease(&one(0.0), &one(2.0), &one(1.0), &one(1.0), 0.0, &[scalar(gamma)]).unwrap();
    assert!(at(2f64.next_down()).is_proved());
    assert!(at(2.0).is_refuted() && at(2f64.next_up()).is_refuted());
    // Two halves of a nonlinearity, each with its multiplier: G = H = 1 twice, gamma = 1 each.
    let halves = [scalar(0.5), scalar(0.5)];
    assert!(sector_decrease(&one(0.0), &one(4.0), &one(1.0), &one(1.0), 0.0, &halves).unwrap().is_proved());
    assert!(sector_decrease(&one(0.0), &one(0.5), &one(1.0), &one(1.0), 0.0, &halves).unwrap().is_refuted());
    // No nonlinearity: a Lyapunov inequality.
    assert!(sector_decrease(&one(-1.0), &one(0.0), &one(1.0), &one(1.0), 0.5, &[]).unwrap().is_proved());
    // A multiplier that is not positive proves nothing.
    let term = SectorTerm { tau: 0.0, ..scalar(1.0) };
    assert!(sector_decrease(&one(0.0), &one(2.0), &one(1.0), &one(1.0), 0.0, &[term]).unwrap().is_refuted());
}

#[test]
fn bad_data_are_named() {
    let with = |term: SectorTerm| sector_decrease(&one(0.0), &one(2.0), &one(1.0), &one(1.0), 0.0, &[term]);
    for (what, term) in [
        ("low", SectorTerm { low: f64::NAN, ..scalar(1.0) }),
        ("high", SectorTerm { high: f64::INFINITY, ..scalar(1.0) }),
        ("tau", SectorTerm { tau: f64::NAN, ..scalar(1.0) }),
        ("G", SectorTerm { g: one(f64::NAN), ..scalar(1.0) }),
    ] {
        let error = with(term).unwrap_err();
        assert!(matches!(error, ProofError::NotFinite { what: found, .. } if found == what), "{error}");
    }
    let long = Matrix::from_rows([[1.0], [1.0]]);
    assert!(matches!(with(SectorTerm { g: long.clone(), ..scalar(1.0) }), Err(ProofError::DimensionMismatch { .. })));
    assert!(matches!(
        with(SectorTerm { h: Matrix::from_rows([[1.0, 1.0]]), ..scalar(1.0) }),
        Err(ProofError::DimensionMismatch { .. })
    ));
    // Only a symmetric sector allows H another height than the width of G.
    assert!(with(SectorTerm { h: long.clone(), ..scalar(0.5) }).is_ok());
    assert!(matches!(with(SectorTerm { h: long, low: 0.0, ..scalar(0.5) }), Err(ProofError::DimensionMismatch { .. })));
    let j = Matrix::from_rows([[0.0, 1.0], [0.0, 0.0]]);
    assert!(matches!(cascade_decrease(&j, &one(1.0), &one(1.0), f64::NAN, 0.0), Err(ProofError::NotFinite { .. })));
    assert!(matches!(
        cascade_decrease(&one(1.0), &one(1.0), &one(1.0), 1.0, 0.0),
        Err(ProofError::DimensionMismatch { .. })
    ));
}
