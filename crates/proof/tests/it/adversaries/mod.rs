//! Random and adversarial questions to this crate, and an oracle that shares no code with it.
//!
//! A case is a seed and a number: it is the same whichever thread meets it, and can be met again alone.

mod families;
mod intervals;
mod oracle;
mod statements;
mod trial;

use luenberger_proof::{Exact, Interval, Matrix};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng as Random;

use families::FAMILIES;
use oracle::Integers;
pub(crate) use trial::Tally;
use trial::{Judged, SENSES, ask};

type Examine = fn(&mut Random) -> Tally;

/// The kinds beyond the families of matrices.
const OTHERS: [(&str, Examine); 5] = [
    ("intervals, n <= 4", intervals::examine),
    ("decay rate of A - LC", statements::lyapunov),
    ("Stein, A - LC", statements::stein),
    ("feedback block", statements::feedback),
    ("Hurwitz by P", statements::hurwitz),
];

/// The names of all kinds of cases, in their order.
pub(crate) fn kinds() -> Vec<&'static str> {
    FAMILIES.iter().map(|family| family.name).chain(OTHERS.iter().map(|(name, _)| *name)).collect()
}

/// The case of this number: its kind, and what came of it.
pub(crate) fn examine(seed: u64, number: u64) -> (usize, Tally) {
    let mut random = Random::seed_from_u64(seed);
    random.set_stream(number);
    let kinds = FAMILIES.len() + OTHERS.len();
    let kind = (number % kinds as u64) as usize;
    let mut tally = match FAMILIES.get(kind) {
        Some(family) => {
            let m = (family.make)(&mut random);
            of_matrix(&families::disguised(&mut random, &m), &mut random)
        }
        None => (OTHERS[kind - FAMILIES.len()].1)(&mut random),
    };
    for wrong in &mut tally.wrong {
        *wrong = format!("seed {seed}, case {number}: {wrong}");
    }
    (kind, tally)
}

/// All four questions about a matrix of numbers, and one of them about the same numbers as intervals and as exact
/// numbers.
fn of_matrix(m: &Matrix<f64>, random: &mut Random) -> Tally {
    let truth = Judged::of(Integers::of(m));
    let mut tally = Tally { cases: 1, ..Tally::default() };
    for sense in SENSES {
        let verdict = ask(m, sense);
        tally.count(&verdict, true, (m, sense), truth.fault(&verdict, sense));
    }
    let sense = SENSES[random.random_range(0..4)];
    let points: Matrix<Interval> = Matrix::embed(m, "M").expect("finite");
    let exact: Matrix<Exact> = Matrix::embed(m, "M").expect("finite");
    for verdict in [ask(&points, sense), ask(&exact, sense)] {
        tally.count(&verdict, true, (m, sense), truth.fault(&verdict, sense));
    }
    tally
}
