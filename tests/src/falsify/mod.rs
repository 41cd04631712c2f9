//! Falsification of the theorems of `luenberger-proof`: certificates of random designs are changed meaningfully and
//! sealed again, and each accepted one is tested for contradictions.
//!
//! A certificate is processed as a JSON document: `mutate` changes its data, `CertificateFile::read` must accept the
//! form, `CertificateFile::prove` the mathematics with its own margins, and [`verify`] the result; occasionally also
//! the document itself, with the original margins, one of them an ulp larger, with new text and a new digest.
//! `adversary` reads the accepted text without `luenberger-proof` and tries to contradict it. An accepted mutant is
//! often mutated again, so that changes accumulate; and where the change of one number decides between acceptance and
//! rejection, the boundary is found by bisection, down to neighbouring numbers. `labels` changes the hypotheses.

mod adversary;
mod cubic;
mod deployed;
mod disturbed;
mod document;
pub mod exact;
mod families;
mod filters;
mod forged;
mod intervals;
mod kkl;
mod labels;
mod mutate;
mod programs;
mod sampled;
mod seeds;

use luenberger_proof::certificate::{CertificateFile, Theorem, digest, verify};
use luenberger_random::Random;
use serde_json::Value;

use adversary::Found;
use document::hexadecimal;

pub use forged::{Forged, forged};
pub use labels::{Changed, Noticed, changed_labels};

type Generator = fn(&mut Random) -> Option<CertificateFile>;
type Adversary = fn(&Value, &mut Random) -> Found;

/// Each theorem with the generator of its certificates and the adversary of those that are accepted.
const KINDS: &[(&str, Generator, Adversary)] = &[
    ("linear-observer", seeds::linear_observer, adversary::linear_observer),
    ("discrete-observer", seeds::discrete_observer, adversary::discrete_observer),
    ("hurwitz", seeds::hurwitz, adversary::hurwitz),
    ("schur", seeds::schur, adversary::schur),
    ("cubic-observer", seeds::cubic_observer, cubic::observer),
    ("cubic-observer-with-structured-gain", seeds::structured, cubic::structured),
    ("cubic-observer-theorem-1", seeds::theorem1, cubic::theorem1),
    ("sampled-cubic-observer", seeds::sampled, adversary::sampled),
    ("unknown-input-observer", seeds::unknown_input, cubic::unknown_input),
    ("input-to-state-stability", seeds::input_to_state, disturbed::contradicted),
    ("discrete-input-to-state-stability", seeds::discrete_input_to_state, disturbed::in_steps),
    ("interval-observer", seeds::interval, intervals::continuous),
    ("sampled-interval-observer", seeds::sampled_interval, intervals::sampled),
    ("super-twisting-observer", seeds::super_twisting, adversary::super_twisting),
    ("decoupling-observer", seeds::decoupling, adversary::decoupling),
    ("reduced-order-observer", seeds::reduced_order, adversary::reduced_order),
    ("h-infinity-filter", filters::h_infinity, filters::gain_contradicted),
    ("h2-filter", filters::h2, filters::variance_contradicted),
    ("sampled-cubic-observer-semi-implicit", seeds::semi_implicit, sampled::semi_implicit),
    ("sampled-observer-at-varying-periods", seeds::varying_periods, sampled::varying_periods),
    ("deployed-observer", seeds::deployed, deployed::contradicted),
    ("feedback-loop", seeds::feedback, cubic::feedback),
    ("polytope-of-plants", seeds::polytope, families::polytope),
    ("polytope-of-jacobians", seeds::jacobians, families::polytope),
    ("discrete-polytope-of-jacobians", seeds::discrete_jacobians, families::discrete_polytope),
    ("sector-observer", seeds::sector, families::sector),
    ("contracting-coordinates", seeds::contracting, families::contracting),
    ("kkl-error-bound", kkl::generate, kkl::contradicted),
    ("definiteness", seeds::definiteness, adversary::definiteness),
    ("solution-within", seeds::solution, adversary::solution),
    ("matrix-inequality-holds", seeds::holds, programs::holds),
    ("matrix-inequality-refuted", seeds::refuted, programs::refuted),
    ("semidefinite-program", seeds::program, programs::semidefinite),
];

/// Number of mutants derived from one design.
const MUTANTS_OF_A_DESIGN: u64 = 100;

/// Results for the mutants of one theorem.
#[derive(Debug, Clone, Default)]
pub struct Tally {
    /// Certificates of designs.
    pub certificates: u64,
    /// Mutants of them.
    pub mutants: u64,
    /// Accepted ones.
    pub accepted: u64,
    /// Refused ones, of which nothing is claimed.
    pub refused: u64,
    /// Refused ones that are well formed and were given to the adversary, one in four.
    pub tried: u64,
    /// Those of them that it contradicts: it has to find something where there is something.
    pub convicted: u64,
    /// The contradictions to accepted mutants, with the document.
    pub wrong: Vec<String>,
}

/// The names of the theorems.
pub fn kinds() -> &'static [&'static str] {
    Theorem::NAMES
}

/// The theorems that lack a generator or an adversary.
pub fn without_seeds() -> Vec<&'static str> {
    kinds().iter().copied().filter(|kind| KINDS.iter().all(|(name, ..)| name != kind)).collect()
}

/// The functions of a theorem, by its name.
///
/// # Panics
/// For a theorem that the table does not have: it needs a generator and an adversary.
fn of_kind(kind: &str) -> (Generator, Adversary) {
    let Some((_, generator, adversary)) = KINDS.iter().find(|(name, ..)| *name == kind) else {
        panic!("the theorem {kind} has no generator, or no adversary, in KINDS");
    };
    (*generator, *adversary)
}

/// At least this many mutants of certificates of one theorem.
///
/// # Panics
/// For a theorem without a generator or an adversary, and where none of 200 random designs has a certificate.
pub fn falsify(kind: &'static str, mutants: u64, seed: u64) -> Tally {
    let mut run = Run { kind, tally: Tally::default(), random: stream(seed, kind, 0) };
    let mut other = run.design();
    while run.tally.mutants < mutants {
        let design = run.design();
        run.descend(&design, &other, (mutants - run.tally.mutants).min(MUTANTS_OF_A_DESIGN));
        other = design;
    }
    run.tally
}

/// A stream of random numbers for each seed, name and number.
fn stream(seed: u64, name: &str, number: u64) -> Random {
    let state = seed ^ number.wrapping_mul(0xd134_2543_de82_ef95);
    Random(name.bytes().fold(state, |state, byte| state.wrapping_mul(0x0100_0000_01b3) ^ u64::from(byte)))
}

struct Run {
    kind: &'static str,
    tally: Tally,
    random: Random,
}

impl Run {
    /// A certificate of a random design, which is held against the adversary too.
    fn design(&mut self) -> Value {
        let (generator, _) = of_kind(self.kind);
        for _ in 0..200 {
            let Some(file) = generator(&mut self.random) else { continue };
            if file.theorem().name() != self.kind {
                continue;
            }
            self.tally.certificates += 1;
            let document: Value = serde_json::from_str(&file.to_json()).expect("the writer writes JSON");
            self.hold(&document, "the design itself");
            return document;
        }
        panic!("no certificate of {} from 200 random designs", self.kind);
    }

    fn descend(&mut self, design: &Value, other: &Value, mutants: u64) {
        let mut current = design.clone();
        let end = self.tally.mutants + mutants;
        while self.tally.mutants < end {
            let Some(next) = mutate::mutant(&current, other, &mut self.random) else { continue };
            let accepted = self.examine(&next);
            if !accepted && self.random.once_in(40) {
                self.bisect(&current, &next);
            }
            match self.random.below(4) {
                0 => current.clone_from(design),
                1 | 2 if accepted => current = next,
                _ => {}
            }
        }
    }

    /// Whether a mutant is accepted: then the adversary has it.
    fn examine(&mut self, mutant: &Value) -> bool {
        self.tally.mutants += 1;
        let resealed = self.random.once_in(8) && self.is_verified_as_it_is(mutant);
        let accepted = match Self::proved(mutant) {
            Ok(Some(document)) => {
                self.hold(&document, "proved");
                true
            }
            Ok(None) => false,
            Err(why) => {
                self.tally.wrong.push(format!("{}: {why}\n{mutant}", self.kind));
                false
            }
        };
        if resealed && !accepted {
            self.tally.wrong.push(format!("{}: verified with old margins, and not proved\n{mutant}", self.kind));
        }
        if accepted || resealed {
            self.tally.accepted += 1;
        } else {
            self.tally.refused += 1;
            if self.random.once_in(4) {
                self.convict(mutant);
            }
        }
        accepted
    }

    /// The certificate of the mutant's theorem with margins of its own, as it is written.
    fn proved(mutant: &Value) -> Result<Option<Value>, String> {
        let Ok(read) = CertificateFile::read(mutant.to_string().as_bytes()) else { return Ok(None) };
        let Ok(file) = CertificateFile::prove("a mutant", read.theorem().clone()) else { return Ok(None) };
        let text = file.to_json();
        verify(text.as_bytes()).map_err(|why| format!("proved, and not verified: {why}"))?;
        Ok(Some(serde_json::from_str(&text).map_err(|why| why.to_string())?))
    }

    /// The document with its own margins, sometimes one of them an ulp larger than what is proved, with words and a
    /// digest that agree with it; held against the adversary if it is verified.
    fn is_verified_as_it_is(&mut self, mutant: &Value) -> bool {
        let mut document = mutant.clone();
        let Ok(read) = CertificateFile::read(document.to_string().as_bytes()) else { return false };
        document["statement"] = Value::String(read.theorem().words());
        if self.random.once_in(2)
            && let Ok(facts) = read.theorem().facts()
            && let Some(margins) = document["margins"].as_array_mut()
            && !margins.is_empty()
        {
            let at = self.random.below(margins.len());
            if let Some(margin) = facts.get(at).and_then(|fact| fact.verdict.margin()) {
                margins[at]["margin"] = hexadecimal(margin.next_up());
            }
        }
        let Ok(seal) = digest(document.to_string().as_bytes()) else { return false };
        document["sha256"] = Value::String(seal);
        let verified = verify(document.to_string().as_bytes()).is_ok();
        if verified {
            self.hold(&document, "verified with its margins");
        }
        verified
    }

    /// The adversary's result for a rejected mutant without its margins.
    fn convict(&mut self, mutant: &Value) {
        if CertificateFile::read(mutant.to_string().as_bytes()).is_err() {
            return;
        }
        let mut document = mutant.clone();
        document["margins"] = Value::Array(Vec::new());
        self.tally.tried += 1;
        self.tally.convicted += u64::from(self.adversary(&document).is_err());
    }

    fn adversary(&mut self, document: &Value) -> Result<(), String> {
        of_kind(self.kind).1(document, &mut self.random)
    }

    fn hold(&mut self, document: &Value, how: &str) {
        if let Err(why) = self.adversary(document) {
            self.tally.wrong.push(format!("{}: {how}, but {why}\n{document}", self.kind));
        }
    }

    /// Between an accepted and a refused document that differ in one number: the last accepted number, and every mutant
    /// on the way.
    fn bisect(&mut self, accepted: &Value, refused: &Value) {
        let Some((path, good, bad)) = mutate::single_difference(accepted, refused) else { return };
        if good.is_sign_negative() != bad.is_sign_negative() || !good.is_finite() || !bad.is_finite() {
            return;
        }
        // Numbers of one sign are ordered as their bits are.
        let (mut good, mut bad) = (good.to_bits(), bad.to_bits());
        while good.abs_diff(bad) > 1 {
            let middle = good.midpoint(bad);
            let mutant = mutate::with_number(refused, &path, f64::from_bits(middle));
            if self.examine(&mutant) {
                good = middle;
            } else {
                bad = middle;
            }
        }
    }
}
