//! What to do in place of an observer that is refused: alternatives, and hints.
//!
//! - An *alternative* is an observer of the same plant, given by the keys to write into the study. Its design was
//!   tried, has succeeded, and all its facts are verified: `tried` alone makes an [`Alternative`]. What it prints are
//!   the keys that were read and designed.
//! - A *hint* names a remedy that cannot be tried: another plant or sensor, maps or numbers of the user's choice, or a
//!   kind whose design takes minutes.
//!
//! A refusal states its alternatives as [`Proposal`]s. They are designed by [`attempt`], which tries no further ones,
//! and only where a user reads the refusal: not in a sweep, nor for the candidates of `luenberger advise`.

use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};

use luenberger_design::{OperatingPoint, Region, operating_point};
use luenberger_proof::wording::shortest;
use nalgebra::{DMatrix, DVector};

use super::{NoDesign, attempt};
use crate::kinds::PlantClass;
use crate::kinds::kkl_numerical::{KklSpec, has_table};
use crate::read::varied;
use crate::results::{Alternative, FailureReport, Proposal};
use crate::study::{GainSpec, LinearSpec, ObserverSpec, Study};

/// Time for all alternatives to one observer: a safeguard, which designs of usual sizes do not reach.
const PATIENCE: Duration = Duration::from_secs(5);

/// A matrix inequality is tried for at most so many states.
const MOST_STATES: usize = 20;

/// What a refusal proposes and says.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Advice {
    pub(crate) proposals: Vec<Proposal>,
    pub(crate) hints: Vec<String>,
}

impl Advice {
    pub(crate) fn hint(hint: impl Into<String>) -> Self {
        Self { proposals: Vec::new(), hints: vec![hint.into()] }
    }

    pub(crate) fn of(proposals: impl IntoIterator<Item = Proposal>) -> Self {
        Self { proposals: proposals.into_iter().collect(), hints: Vec::new() }
    }

    /// Both, this one first.
    pub(crate) fn and(mut self, other: Self) -> Self {
        self.proposals.extend(other.proposals);
        self.hints.extend(other.hints);
        self
    }
}

/// A matrix as the value of a key.
pub(crate) fn rows(matrix: &DMatrix<f64>) -> String {
    let row = |row: nalgebra::RowDVector<f64>| list(row.iter().copied());
    format!("[{}]", matrix.row_iter().map(|each| row(each.into_owned())).collect::<Vec<_>>().join(", "))
}

/// A list of numbers as the value of a key.
pub(crate) fn list(numbers: impl IntoIterator<Item = f64>) -> String {
    format!("[{}]", numbers.into_iter().map(shortest).collect::<Vec<_>>().join(", "))
}

fn region_key(region: &Region) -> Option<String> {
    let is_bounded = |bounds: &(f64, f64)| bounds.0.is_finite() || bounds.1.is_finite();
    let pairs = |all: &[(f64, f64)]| all.iter().map(|(low, high)| list([*low, *high])).collect::<Vec<_>>().join(", ");
    let mut keys = Vec::new();
    if region.states().iter().any(is_bounded) {
        keys.push(format!("states = [{}]", pairs(region.states())));
    }
    if let Some(inputs) = region.input_bounds().filter(|inputs| inputs.iter().any(is_bounded)) {
        keys.push(format!("inputs = [{}]", pairs(inputs)));
    }
    let time = region.time_bounds();
    if is_bounded(&time) {
        keys.push(format!("time = {}", list([time.0, time.1])));
    }
    (!keys.is_empty()).then(|| format!("region = {{ {} }}", keys.join(", ")))
}

const LARGEST_MARGIN: &str = "the gain with the largest margin of its inequality";

/// The kinds for a linear plant.
fn for_linear(is_discrete: bool) -> Vec<Proposal> {
    let why = "a filter for noise of these intensities, which are to be chosen";
    let mut kinds = vec![Proposal::kind("kalman", unit_noise(), why)];
    if !is_discrete {
        kinds.push(Proposal::kind("luenberger", ["lmi = true".to_owned()], LARGEST_MARGIN));
    }
    kinds
}

/// Noise of unit intensity.
fn unit_noise() -> [String; 2] {
    ["w = 1", "v = 1"].map(str::to_owned)
}

/// The other kinds for this plant.
pub(crate) fn other_kinds(study: &Study, requested: &ObserverSpec) -> Advice {
    let (plant, is_discrete) = (&study.plant, study.plant.dt.is_some());
    if plant.model.linear().is_some() {
        return Advice::of(for_linear(is_discrete));
    }
    let advised = study.advise.as_ref().and_then(|advise| advise.region.clone());
    let region = requested.kind.region().or(advised).and_then(|region| region_key(&region));
    // A kind that takes a region says itself that it needs a bounded one.
    let takes_region = requested.kind.takes_region();
    let bounded = "lpv over a bounded `region` in which the state is known to stay; over all states it was refused";
    let mut kinds = vec![
        Proposal::kind("lpv", region.clone(), "one gain for all Jacobians over the region, with a proof")
            .otherwise((region.is_none() && !takes_region).then_some(bounded)),
    ];
    if !is_discrete {
        kinds.push(Proposal::kind("lipschitz", region.clone(), "one gain for all slopes within sectors, with a proof"));
        kinds.push(Proposal::kind("mean-value", region, "for a plant that measures its first states, with a proof"));
    }
    let hold = study.simulation.as_ref().and_then(|simulation| simulation.hold);
    let period = requested.kind.period().or(plant.dt).or(hold).unwrap_or(0.1);
    let filter = ["w = 1".to_owned(), "v = 1".to_owned(), format!("period = {}", shortest(period))];
    kinds.push(Proposal::kind("extended-kalman", filter, "without a proof; w, v and period are to be chosen"));
    let timed = plant.model.structure().explicit_time().is_some();
    if study.operating_point.is_some() {
        kinds.extend(for_linear(false));
    } else if !is_discrete && !timed {
        if matches!(requested.kind.declaration().plant, PlantClass::AtPoint(_)) {
            let why = "the same observer of the linearisation there, in deviations from it";
            kinds.push(Proposal::keys([], &[], why).at_point());
        } else {
            let why = "of the linearisation there, in deviations from it";
            kinds.push(Proposal::kind("kalman", unit_noise(), why).at_point());
        }
    }
    let mut advice = Advice::of(kinds);
    let has_table = has_table(plant.model.size()) && !timed && !is_discrete;
    if has_table && requested.kind.of::<KklSpec>().is_none() {
        let held = if plant.inputs.is_empty() { "" } else { ", for inputs that are held" };
        advice.hints.push(format!(
            "kkl-numerical takes plants of this size, by simulation, without assumptions on f{held}; it was not tried, since its design takes minutes"
        ));
    }
    advice
}

/// The ways to a gain that the kind has beside its own one.
pub(crate) fn another_gain(study: &Study, requested: &ObserverSpec) -> Advice {
    requested.kind.other_gains(study)
}

/// Another gain of a linear observer.
pub(crate) fn other_gains(study: &Study, linear: &LinearSpec) -> Advice {
    // The last two are limits, which go with a gain by matrix inequality.
    const UNLIMITED: &[&str] =
        &["bandwidth", "poles", "decay_rate", "lmi", "kalman", "gain", "rho", "q", "max_gain", "noise"];
    const ALL: &[&str] = UNLIMITED.split_at(UNLIMITED.len() - 2).0;
    let mut ways = Vec::new();
    if study.plant.dt.is_none() && !matches!(linear.gain, GainSpec::Lmi) {
        ways.push(Proposal::keys(["lmi = true".to_owned()], ALL, LARGEST_MARGIN));
    }
    if !matches!(linear.gain, GainSpec::Kalman { .. }) {
        let unit = "kalman = { w = 1, v = 1 }".to_owned();
        let why = "the gain of a filter for noise of these intensities, which are to be chosen";
        ways.push(Proposal::keys([unit], UNLIMITED, why));
    }
    Advice::of(ways)
}

/// Another gain of a copy of the plant over a region.
pub(crate) fn gain_for_region() -> Advice {
    let zero = ["decay_rate = 0".to_owned()];
    Advice::of([Proposal::keys(zero, &["gain", "fastest", "decay_rate"], "a gain for the whole region")])
}

/// The same with smaller decay rates, down to none.
pub(crate) fn slower(requested: &ObserverSpec) -> Advice {
    let rate = requested.kind.decay_rate().unwrap_or(0.0);
    let factors = if rate > 0.0 { &[0.5, 0.1, 0.0][..] } else { &[] };
    let slower = |factor: &f64| format!("decay_rate = {}", shortest(rate * factor));
    Advice::of(factors.iter().map(|factor| Proposal::keys([slower(factor)], &["decay_rate"], "a smaller rate")))
}

/// An operating point that the study could name, and its keys: near 0, or near the start of the simulation.
fn a_point(study: &Study) -> Option<(OperatingPoint, String)> {
    let size = study.plant.model.size();
    let zero = vec![0.0; size.states];
    let starts = [Some(&zero), study.simulation.as_ref().map(|simulation| &simulation.x0)];
    let input = DVector::zeros(size.inputs);
    starts.into_iter().flatten().find_map(|x| {
        let point = operating_point(&study.plant.model, &DVector::from_column_slice(x), &input).ok()?;
        let u = if input.is_empty() { String::new() } else { format!(", u = {}", list(input.iter().copied())) };
        Some((point, format!("[operating_point] with x = {}{u}", list(x.iter().copied()))))
    })
}

/// Whether they are one observer: the kinds luenberger and kalman are, with the same gain.
fn is_same(known: &ObserverSpec, other: &ObserverSpec) -> bool {
    let kinds = match (known.kind.whole_gain(), other.kind.whole_gain()) {
        (Some(known), Some(other)) => known == other,
        _ => known.kind == other.kind,
    };
    kinds && (&known.limits, &known.bounds) == (&other.limits, &other.bounds)
}

/// The observer, and how its keys are printed.
fn read(proposal: &Proposal, study: &Study, requested: &ObserverSpec) -> Option<(ObserverSpec, String)> {
    let (spec, replaced) = varied(study, requested, &proposal.keys.join("\n"), proposal.instead)?;
    let (keys, replaced) = (proposal.keys.join(", "), replaced.join(", "));
    let words = match (keys.is_empty(), replaced.is_empty()) {
        (true, true) => String::new(),
        (true, false) => format!("without {replaced}"),
        (false, true) => keys,
        (false, false) => format!("{keys} in place of {replaced}"),
    };
    Some((spec, words))
}

/// The refusal with those of its proposals that have a design.
pub(crate) fn tried(
    study: &Study,
    requested: &ObserverSpec,
    mut refusal: FailureReport,
    (cancel, end): (&AtomicBool, Option<Instant>),
) -> FailureReport {
    let deadline = Instant::now() + PATIENCE;
    let end = end.map_or(deadline, |end| end.min(deadline));
    let (mut designed, mut left): (Vec<ObserverSpec>, _) = (vec![requested.clone()], Vec::new());
    let mut reasons = Vec::new();
    for proposal in std::mem::take(&mut refusal.proposals) {
        // One alternative for each reason: the first of several rates.
        if reasons.contains(&proposal.why) {
            continue;
        }
        let Some((spec, mut words)) = read(&proposal, study, requested) else { continue };
        let at_point;
        let mut within = study;
        if proposal.at_point {
            let Some((point, place)) = a_point(study) else { continue };
            words = if words.is_empty() { place } else { format!("{words} and {place}") };
            at_point = Study { operating_point: Some(point), ..study.clone() };
            within = &at_point;
        } else if designed.iter().any(|known| is_same(known, &spec)) {
            continue;
        }
        let is_large = spec.kind.poses_inequality() && study.plant.states.len() > MOST_STATES;
        if is_large || Instant::now() >= end || cancel.load(Ordering::Relaxed) {
            left.push(words);
            continue;
        }
        match attempt(within, &spec, cancel, Some(end)) {
            Ok(found) if found.report.facts.iter().all(|fact| fact.verdict.is_proved()) => {
                refusal.alternatives.push(Alternative::designed(format!("{words}: {}", proposal.why)));
                reasons.push(proposal.why);
                if !proposal.at_point {
                    designed.push(spec);
                }
            }
            Ok(_) | Err(NoDesign::Misfit(_)) => refusal.hints.extend(proposal.otherwise.map(str::to_owned)),
            Err(NoDesign::Interrupted) => left.push(words),
        }
    }
    if !left.is_empty() {
        refusal.hints.push(format!("not tried, since the design takes long: {}", left.join("; ")));
    }
    refusal
}
