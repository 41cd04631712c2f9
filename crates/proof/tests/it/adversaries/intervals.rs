//! Matrices of intervals. What is true of all symmetric matrices within is decided by finitely many (J. Rohn, Positive
//! definiteness and stability of interval matrices, SIAM J. Matrix Anal. Appl. 15, 1994): the least eigenvalue is least
//! at one of those with `m_ii = lo_ii` and `m_ij = lo_ij` or `hi_ij` as `z_i z_j = 1` or -1, over the 2^(n-1) vectors z
//! of signs.

use luenberger_proof::{Direction, Interval, Matrix, Verdict};
use rand::RngExt;
use rand_chacha::ChaCha8Rng as Random;

use super::families::{self, FAMILIES};
use super::oracle::{Integers, Spectrum};
use super::trial::{SENSES, Tally, ask, bounds};

/// Bounds of all entries, the same on both sides of the diagonal.
struct Ends {
    lo: Matrix<f64>,
    hi: Matrix<f64>,
}

pub(crate) fn examine(random: &mut Random) -> Tally {
    let m = loop {
        let family = &FAMILIES[random.random_range(0..FAMILIES.len())];
        let m = (family.make)(random);
        if m.rows() <= 4 {
            break families::disguised(random, &m);
        }
    };
    let n = m.rows();
    let largest = m.as_slice().iter().fold(0.0_f64, |largest, x| largest.max(x.abs()));
    let relative = [0.0, 1e-16, 1e-13, 1e-8, 1e-3, 0.1][random.random_range(0..6)];
    let is_common = random.random_bool(0.5);
    let mut enclose = |x: f64| {
        let radius = relative * random.random::<f64>() * if is_common { largest } else { x.abs() };
        let radius = if radius.is_finite() { radius } else { 0.0 };
        let clamp = |x: f64| x.clamp(-f64::MAX, f64::MAX);
        Interval::new(clamp(x - radius), clamp(x + radius)).expect("in order")
    };
    // The two mirror images need not be the same interval: what is meant is what both contain.
    let given = Matrix::from_fn(n, n, |i, j| enclose(m[(i, j)]));
    let both = Matrix::from_fn(n, n, |i, j| given[(i, j)].intersection(&given[(j, i)]).expect("both contain m_ij"));
    let ends = Ends { lo: both.map(Interval::lo), hi: both.map(Interval::hi) };
    let mirrored = Ends { lo: both.map(|x| -x.hi()), hi: both.map(|x| -x.lo()) };
    let mut tally = Tally { cases: 1, ..Tally::default() };
    let spectra = [vertices(&ends), vertices(&mirrored)];
    for sense in SENSES {
        let verdict = ask(&given, sense);
        let (ends, spectra) = if sense.is_negated() { (&mirrored, &spectra[1]) } else { (&ends, &spectra[0]) };
        let holds = spectra.iter().all(|s| {
            let inertia = s.inertia();
            inertia.negative == 0 && (!sense.is_strict() || inertia.zero == 0)
        });
        let fault = match &verdict {
            Verdict::Proved { .. } if !holds => Some("wrongly proved"),
            Verdict::Proved { margin } => {
                let has_margin = margin.is_finite()
                    && *margin >= 0.0
                    && spectra.iter().all(|s| s.lowered(*margin).inertia().negative == 0);
                (!has_margin).then_some("a margin above the truth")
            }
            Verdict::Refuted { witness } => {
                (!refutes_all(ends, witness, sense.is_strict())).then_some("a witness that does not refute all")
            }
            Verdict::Undecided { .. } => None,
        };
        tally.count(&verdict, holds, (&given, sense), fault);
    }
    tally
}

/// The spectra of the 2^(n-1) matrices among which the least eigenvalue is least.
fn vertices(ends: &Ends) -> Vec<Spectrum> {
    let n = ends.lo.rows();
    (0..1_u32 << (n - 1))
        .map(|z| {
            let m = Matrix::from_fn(n, n, |i, j| {
                let same = (z >> i & 1) == (z >> j & 1);
                if i == j || same { ends.lo[(i, j)] } else { ends.hi[(i, j)] }
            });
            Spectrum::of(&Integers::of(&m))
        })
        .collect()
}

/// Whether the largest `v'Mv` within, which has `hi_ij` where `v_i v_j > 0` and `lo_ij` elsewhere, is of the wrong
/// sign.
fn refutes_all(ends: &Ends, witness: &Direction, strict: bool) -> bool {
    let n = ends.lo.rows();
    let v = witness.exact.as_ref().map_or_else(|| Integers::column(&witness.v), |v| Integers::exact_column(v));
    let signs: Vec<i32> = (0..n).map(|i| v.sign_at(i)).collect();
    let m = Matrix::from_fn(n, n, |i, j| if signs[i] * signs[j] > 0 { ends.hi[(i, j)] } else { ends.lo[(i, j)] });
    let form = v.transpose().times(&Integers::of(&m)).times(&v);
    !v.is_zero() && (form.sign() < 0 || (strict && form.sign() == 0)) && bounds(witness.value, &form)
}
