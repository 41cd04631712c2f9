//! Falsification of the sentences of `luenberger-study`: random studies of every kind of observer are designed, and
//! what designs, failures and headers say is turned into checks.
//!
//! `generate` draws a study as text; [`sentences`] has the forms of all sentences with what they claim; `adversary`
//! tries to contradict each claim: exactly, by another algorithm, or by trajectories of an integrator of its own
//! (`integrate`, `simulate`) with the plant as this module reads it (`plant`, `expression`); `header` does so for
//! exported code; `shrink` makes a finding small. A sentence without a form is a finding as well.
//!
//! What a verdict, a bound or an impossibility is about is in the text: [`said::Said`] has the texts of one observer,
//! and the tests of this module put lies in their place.

mod adversary;
mod document;
mod expression;
mod generate;
mod header;
mod integrate;
mod linear;
mod plant;
pub mod said;
pub mod sentences;
mod shrink;
mod simulate;

use std::cell::{Cell, RefCell};
use std::collections::BTreeMap;
use std::fmt;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::Path;
use std::sync::atomic::AtomicBool;
use std::sync::mpsc;
use std::thread;
use std::time::{Duration, Instant};

use luenberger_design::UnseenModes;
use luenberger_proof::statement::Format as Numbers;
use luenberger_random::Random;
use luenberger_study::design::{Designed, NoObserver, design_until};
use luenberger_study::results::Results;
use luenberger_study::study::ObserverSpec;
use luenberger_study::{Format, RunOptions, Step, Study, execute};
use rayon::prelude::*;

use adversary::{Held, Subject, Verdict, Wrong};
use document::Value;
use plant::Plant;
use said::Said;
use sentences::{Claim, Sentence};

/// The kinds of observers.
pub fn kinds() -> Vec<&'static str> {
    luenberger_study::kinds::registry().iter().map(|kind| kind.name).collect()
}

/// The kinds that have a generator.
pub fn generated() -> Vec<&'static str> {
    generate::GENERATORS.iter().map(|(kind, _)| *kind).collect()
}

/// How bad a finding is.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum Class {
    /// A sentence is false.
    Contradiction,
    /// A number of a sentence is rounded to the wrong side.
    Rounding,
    /// A sentence has no form, and so no check.
    Unknown,
    /// The tool panics, or reads a plant as another one.
    Crash,
    /// An alternative of a failure is refused.
    Alternative,
}

impl Class {
    fn words(self) -> &'static str {
        match self {
            Self::Contradiction => "contradiction",
            Self::Rounding => "rounded to the wrong side",
            Self::Unknown => "a sentence without a check",
            Self::Crash => "a crash",
            Self::Alternative => "an alternative that is refused",
        }
    }
}

/// A finding.
#[derive(Debug, Clone)]
pub struct Finding {
    pub class: Class,
    pub kind: String,
    pub observer: String,
    /// The claim that is false.
    pub claim: Option<Claim>,
    pub sentence: String,
    pub why: String,
    pub study: String,
}

impl fmt::Display for Finding {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        writeln!(f, "# {} ({}): {}", self.observer, self.kind, self.class.words())?;
        for line in self.sentence.lines() {
            writeln!(f, "# says: {line}")?;
        }
        for line in self.why.lines() {
            writeln!(f, "# but: {line}")?;
        }
        f.write_str(&self.study)
    }
}

/// Results for the studies of one kind.
#[derive(Debug, Clone, Default)]
pub struct Tally {
    pub studies: u64,
    /// Observers that were designed; those whose verdict is `proved`; those that are refuted or have no design.
    pub designed: u64,
    pub proved: u64,
    pub refused: u64,
    /// Sentences, those held against trajectories, and those computed in another way.
    pub sentences: u64,
    pub simulated: u64,
    pub computed: u64,
    pub findings: Vec<Finding>,
}

impl Tally {
    pub fn count(&self, class: Class) -> usize {
        self.findings.iter().filter(|finding| finding.class == class).count()
    }

    fn add(&mut self, other: Self) {
        self.studies += other.studies;
        self.designed += other.designed;
        self.proved += other.proved;
        self.refused += other.refused;
        self.sentences += other.sentences;
        self.simulated += other.simulated;
        self.computed += other.computed;
        self.findings.extend(other.findings);
    }
}

/// What is done with a study besides its designs.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Extent {
    /// Designs only.
    Designs,
    /// Headers, scores and alternatives as well, where the seed draws them.
    All,
}

/// The time for a design.
const PATIENCE: Duration = Duration::from_secs(10);

/// A lie for the tests: it changes what is said of an observer.
pub type Lie<'a> = &'a (dyn Fn(&ObserverSpec, &mut Said) + Sync);

/// Runs `studies` studies of one kind and shrinks the first findings of each claim.
///
/// # Panics
/// For a kind without a generator.
pub fn falsify(kind: &str, studies: u64, seed: u64, extent: Extent) -> Tally {
    let one = |number: u64| {
        let mut random = stream(seed, kind, number);
        let text = generate::study(kind, &mut random);
        hold(&text, random.bits(), extent)
    };
    let mut all = (0..studies).into_par_iter().map(one).reduce(Tally::default, |mut sum, one| {
        sum.add(one);
        sum
    });
    let mut shrunk: BTreeMap<(Class, Option<Claim>), usize> = BTreeMap::new();
    let mut crashes = Vec::new();
    for finding in all.findings.iter_mut().filter(|finding| finding.class != Class::Crash) {
        let count = shrunk.entry((finding.class, finding.claim)).or_default();
        *count += 1;
        if *count <= 2 {
            smaller(finding, extent, &mut crashes);
        }
    }
    all.findings.extend(crashes);
    all
}

/// A stream of random numbers for each seed, name and number.
fn stream(seed: u64, name: &str, number: u64) -> Random {
    let state = seed ^ number.wrapping_add(1).wrapping_mul(0xd134_2543_de82_ef95);
    Random(name.bytes().fold(state, |state, byte| state.wrapping_mul(0x0100_0000_01b3) ^ u64::from(byte)))
}

/// The finding with the smallest study that still has it; crashes on the way are findings too.
fn smaller(finding: &mut Finding, extent: Extent, crashes: &mut Vec<Finding>) {
    let mut found = None;
    let end = Instant::now() + PATIENCE;
    let text = shrink::shrink(&finding.study, &mut |text| {
        if Instant::now() > end {
            return false;
        }
        let again = (0..2).find_map(|seed| {
            let all = hold(text, seed, extent).findings;
            crashes.extend(all.iter().filter(|other| other.class == Class::Crash).cloned());
            all.into_iter().find(|other| {
                other.class == finding.class && other.claim == finding.claim && other.kind == finding.kind
            })
        });
        let remains = again.is_some();
        if remains {
            found = again;
        }
        remains
    });
    if let Some(found) = found {
        *finding = Finding { study: text, ..found };
    }
}

/// Holds one study.
pub fn hold(text: &str, seed: u64, extent: Extent) -> Tally {
    hold_with(text, seed, extent, &|_, _| ())
}

/// Holds one study, with a lie in the place of what is said.
pub fn hold_with(text: &str, seed: u64, extent: Extent, lie: Lie<'_>) -> Tally {
    let mut tally = Tally { studies: 1, ..Tally::default() };
    let crash = |kind: &str, sentence: String, why: String| Finding {
        class: Class::Crash,
        kind: kind.to_owned(),
        observer: String::new(),
        claim: None,
        sentence,
        why,
        study: text.to_owned(),
    };
    let Ok(study) = Study::from_text("study.toml", text, Format::Toml, Path::new(".")) else { return tally };
    let Some(document) = document::read(text) else { return tally };
    let Ok(plant) = Plant::read(&document) else { return tally };
    let mut random = Random(seed);
    if let Some(why) = differs(&study, &plant, &mut random) {
        tally.findings.push(crash("plant", "the plant".to_owned(), why));
        return tally;
    }
    let mut designs: Vec<(&ObserverSpec, Result<Designed, NoObserver>, Said)> = Vec::new();
    for spec in &study.observers {
        match designed_in_time(&study, spec) {
            Some(Ok(designed)) => {
                let mut said = Said::of(&designed);
                lie(spec, &mut said);
                designs.push((spec, designed, said));
            }
            Some(Err(why)) => {
                tally.findings.push(crash(spec.kind.name(), "design".to_owned(), format!("it panics: {why}")));
            }
            None => {
                let why = format!(
                    "it has not ended after {} s, with a limit of {} s",
                    2 * PATIENCE.as_secs(),
                    PATIENCE.as_secs()
                );
                tally.findings.push(crash(spec.kind.name(), "design".to_owned(), why));
                return tally;
            }
        }
    }
    let proved: Vec<String> =
        designs.iter().filter(|(.., said)| said.verdict == "proved").map(|(spec, ..)| spec.name.clone()).collect();
    let tables = document::observers(&document);
    for (spec, designed, said) in &designs {
        if designed.as_ref().is_err_and(NoObserver::is_interrupted) {
            continue;
        }
        match said.verdict.as_str() {
            "proved" => tally.proved += 1,
            "" => tally.refused += 1,
            _ => {}
        }
        tally.designed += u64::from(designed.is_ok());
        let Some(own) = tables.iter().zip(&study.observers).find(|(_, other)| other.name == spec.name) else {
            continue;
        };
        let subject = Subject {
            study: &study,
            plant: &plant,
            spec,
            own: own.0,
            designed: designed.as_ref().ok(),
            proved: &proved,
            random: RefCell::new(Random(random.bits())),
            tolerance: Cell::default(),
        };
        let mut note = |sentence: &Sentence, verdict: Verdict| {
            tally.sentences += 1;
            let (class, why) = match (sentence.claim, verdict) {
                (None, _) => (Class::Unknown, "it has no form in the table of sentences".to_owned()),
                (_, Ok(held)) => {
                    tally.simulated += u64::from(held == Held::Simulated);
                    tally.computed += u64::from(held == Held::Computed);
                    return;
                }
                (_, Err(Wrong::False(why))) => (Class::Contradiction, why),
                (_, Err(Wrong::Rounded(why))) => (Class::Rounding, why),
            };
            tally.findings.push(Finding {
                class,
                kind: spec.kind.name().to_owned(),
                observer: spec.name.clone(),
                claim: sentence.claim,
                sentence: format!(
                    "{}{}",
                    if said.verdict.is_empty() { String::new() } else { format!("{}: ", said.verdict) },
                    sentence.text
                ),
                why,
                study: text.to_owned(),
            });
        };
        let statements = said.statements();
        let whole = |text: &str| Sentence { text: text.to_owned(), claim: Some(Claim::Nothing), holes: Vec::new() };
        if !said.verdict.is_empty() {
            note(&whole("the verdict"), adversary::verdict(said));
            note(&whole(&said.statement), adversary::coherence(said, &statements));
        }
        for sentence in statements.iter().chain(&said.reasons()).chain(&said.others()) {
            note(sentence, subject.check(said, sentence));
        }
        if extent == Extent::All && designed.is_ok() {
            let format = [Numbers::Binary64, Numbers::Binary32, Numbers::Fixed { integer_bits: 6, fraction_bits: 10 }]
                [(seed % 3) as usize];
            if let Some(mut evidence) =
                catch_unwind(AssertUnwindSafe(|| header::of(&study, spec, format))).ok().flatten()
            {
                let mut of_export = Said { header: std::mem::take(&mut evidence.sentences), ..said.clone() };
                lie(spec, &mut of_export);
                for sentence in &of_export.headers() {
                    note(sentence, header::check(&of_export, sentence, &evidence));
                }
            }
        }
        if extent == Extent::All && random.once_in(4) {
            tally.findings.extend(alternatives(&document, own.0, spec, said, text));
        }
    }
    if let Some(finding) = observed(&study, &plant, text) {
        tally.findings.push(finding);
    }
    if extent == Extent::All && study.simulation.is_some() && random.once_in(4) {
        tally.findings.extend(scored(&study, &designs, text));
    }
    tally
}

/// The design, or the words of a panic; none if it does not end, which leaves its thread behind.
fn designed_in_time(study: &Study, spec: &ObserverSpec) -> Option<Result<Result<Designed, NoObserver>, String>> {
    let (answer, answered) = mpsc::channel();
    let (study, spec) = (study.clone(), spec.clone());
    thread::spawn(move || {
        let end = Some(Instant::now() + PATIENCE);
        let cancel = AtomicBool::new(false);
        let designed = catch_unwind(AssertUnwindSafe(|| design_until(&study, &spec, &cancel, end)));
        _ = answer.send(designed.map_err(|panic| {
            let text = panic.downcast_ref::<String>().cloned();
            text.or_else(|| panic.downcast_ref::<&str>().map(|text| (*text).to_owned())).unwrap_or_default()
        }));
    });
    answered.recv_timeout(2 * PATIENCE).ok()
}

/// Where the plant of the tool and the plant as it is read here differ.
fn differs(study: &Study, plant: &Plant, random: &mut Random) -> Option<String> {
    use luenberger_plants::Plant as _;
    let size = study.plant.model.size();
    let (n, m, p) = (size.states, size.inputs, size.outputs);
    if (n, m, p) != (plant.states.len(), plant.inputs.len(), plant.outputs.len()) {
        return Some(format!("it has {n} states, {m} inputs and {p} outputs"));
    }
    for _ in 0..3 {
        let x = nalgebra::DVector::from_fn(n, |_, _| random.unit());
        let u = nalgebra::DVector::from_fn(m, |_, _| random.unit());
        let t = random.uniform();
        let (mut moved, mut seen) = (vec![0.0; n], vec![0.0; p]);
        plant.motion(t, x.as_slice(), u.as_slice(), &mut moved);
        plant.output(t, x.as_slice(), u.as_slice(), &mut seen);
        let theirs: nalgebra::DVector<f64> = study.plant.model.derivative(t, &x, &u);
        let output: nalgebra::DVector<f64> = study.plant.model.output(t, &x, &u);
        for (ours, theirs) in moved.iter().chain(&seen).zip(theirs.iter().chain(output.iter())) {
            let size = moved.iter().chain(&seen).fold(1.0, |most: f64, x| most.max(x.abs()));
            if (ours - theirs).abs() > 1e-9 * size && ours.is_finite() && theirs.is_finite() {
                return Some(format!(
                    "at x = {:?}, u = {:?}, t = {t} it gives {theirs}, and not {ours}",
                    x.as_slice(),
                    u.as_slice()
                ));
            }
        }
    }
    None
}

/// What `observe` says of a linear plant.
fn observed(study: &Study, plant: &Plant, text: &str) -> Option<Finding> {
    let (a, _, c, _) = plant.matrices()?;
    let results = execute(study, Step::Observe, &RunOptions::default()).ok()?;
    let point = results.observability?.points.into_iter().next()?;
    let (unseen, is_detectable) = (linear::unseen(a, c).rows, linear::is_detectable(a, c, study.plant.dt.is_some()));
    let (is_right, claim) = match point.unseen {
        UnseenModes::None => (unseen == 0, Claim::Observable),
        UnseenModes::Decay => (unseen > 0 && is_detectable, Claim::Detectable),
        UnseenModes::Remain => (unseen > 0 && !is_detectable, Claim::NotDetectable),
        UnseenModes::Undecided => return None,
    };
    (!is_right).then(|| Finding {
        class: Class::Contradiction,
        kind: "observe".to_owned(),
        observer: String::new(),
        claim: Some(claim),
        sentence: format!("observe: of the unobservable modes: {:?}", point.unseen),
        why: format!("{unseen} of the modes are unobservable, exactly; detectable: {is_detectable}"),
        study: text.to_owned(),
    })
}

/// Alternatives of a failure that are refused in turn, each applied as it is printed.
fn alternatives(
    document: &document::Table,
    own: &document::Table,
    spec: &ObserverSpec,
    said: &Said,
    text: &str,
) -> Vec<Finding> {
    let Some(reason) = &said.reason else { return Vec::new() };
    let refused = |alternative: &String| {
        let other = document::write(&applied(document, own, alternative)?);
        let study = match Study::from_text("study.toml", &other, Format::Toml, Path::new(".")) {
            Ok(study) => study,
            Err(error) => return Some(error.to_string()),
        };
        let end = Some(Instant::now() + PATIENCE);
        match design_until(&study, study.observers.first()?, &AtomicBool::new(false), end) {
            Err(none) if !none.is_interrupted() => Some(none.hypothesis),
            _ => None,
        }
    };
    let finding = |alternative: &String| {
        Some(Finding {
            class: Class::Alternative,
            kind: spec.kind.name().to_owned(),
            observer: spec.name.clone(),
            claim: None,
            why: refused(alternative)?,
            sentence: format!("{reason}; alternative: {alternative}"),
            study: text.to_owned(),
        })
    };
    said.alternatives.iter().filter_map(finding).collect()
}

/// The document with an alternative, `KEYS in place of NAMES and [operating_point] with KEYS: WHY`, in place of its
/// observers.
fn applied(document: &document::Table, own: &document::Table, alternative: &str) -> Option<document::Table> {
    let (head, _) = alternative.rsplit_once(": ")?;
    let keys = |text: &str| document::read(&format!("x = {{ {text} }}"))?.get("x")?.table().cloned();
    let mut other = document.clone();
    let head = match head.split_once("[operating_point] with ") {
        Some((head, point)) => {
            other.insert("operating_point", Value::Table(keys(point)?));
            head.trim_end().trim_end_matches(" and")
        }
        None => head,
    };
    let (head, replaced) = match head.split_once(" in place of ") {
        Some(parts) => parts,
        None => head.strip_prefix("without ").map_or((head, ""), |replaced| ("", replaced)),
    };
    let new = keys(head)?;
    let mut observer = if new.has("kind") { document::Table::default() } else { own.clone() };
    for key in replaced.split(", ") {
        observer.remove(key);
    }
    for (key, value) in new.0 {
        observer.insert(&key, value);
    }
    other.insert("observer", Value::List(vec![Value::Table(observer)]));
    Some(other)
}

/// Scores beside the verdict: an error that is proved to decay settles in a run of many of its time constants.
fn scored(study: &Study, designs: &[(&ObserverSpec, Result<Designed, NoObserver>, Said)], text: &str) -> Vec<Finding> {
    let Some(simulation) = study.simulation.as_ref().filter(|simulation| !simulation.is_noisy()) else {
        return Vec::new();
    };
    if study.truth.is_some() || study.operating_point.is_some() {
        return Vec::new();
    }
    let results: Results = match execute(study, Step::Compare, &RunOptions::default()) {
        Ok(results) => results,
        Err(_) => return Vec::new(),
    };
    let mut found = Vec::new();
    for row in results.simulation.iter().flat_map(|report| &report.rows) {
        let Some((spec, _, said)) = designs.iter().find(|(spec, ..)| spec.name == row.observer) else { continue };
        let everywhere = [Claim::Decay, Claim::Envelope, Claim::Reduced, Claim::Sectors, Claim::MeanValue];
        let Some(sentence) = said
            .statements()
            .into_iter()
            .find(|sentence| sentence.claim.is_some_and(|claim| everywhere.contains(&claim)))
        else {
            continue;
        };
        let rate = said.number("decay rate").or_else(|| said.number("rate")).unwrap_or(0.0);
        if said.verdict != "proved" || rate * simulation.duration < 25.0 || spec.kind.region().is_some() {
            continue;
        }
        let Some(norm) = row.merits.as_ref().and_then(|merits| merits.norm.as_ref()) else { continue };
        let size = results
            .simulation
            .as_ref()
            .map_or(0.0, |report| report.x_end.iter().fold(0.0, |most: f64, x| most.max(x.abs())));
        if norm.settling_last.is_none() && norm.initial > 0.0 && norm.last > norm.band * norm.initial + 1e-6 * size {
            found.push(Finding {
                class: Class::Contradiction,
                kind: spec.kind.name().to_owned(),
                observer: spec.name.clone(),
                claim: sentence.claim,
                sentence: format!("proved: {}", sentence.text),
                why: format!(
                    "its own simulation of {} ends with |e| = {:e} and |e(0)| = {:e}: settling `never`",
                    simulation.duration, norm.last, norm.initial
                ),
                study: text.to_owned(),
            });
        }
    }
    found
}
