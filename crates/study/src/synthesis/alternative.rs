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

use luenberger_design::Region;
use luenberger_plants::Dimensions;
use luenberger_proof::wording::shortest;
use nalgebra::DMatrix;

use crate::results::{Advice, Proposal};
use crate::study::{GainSpec, LinearSpec, ObserverSpec, PlantClass, Study};

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
fn for_linear() -> [Proposal; 2] {
    let why = "a filter for noise of these intensities, which are to be chosen";
    [
        Proposal::kind("kalman", unit_noise(), why),
        Proposal::kind("luenberger", ["lmi = true".to_owned()], LARGEST_MARGIN),
    ]
}

/// Noise of unit intensity.
fn unit_noise() -> [String; 2] {
    ["w = 1", "v = 1"].map(str::to_owned)
}

/// The other kinds for this plant.
pub(crate) fn other_kinds(study: &Study, requested: &ObserverSpec) -> Advice {
    let (plant, is_discrete) = (&study.plant, study.plant.dt.is_some());
    if plant.model.linear().is_some() {
        return Advice::of(for_linear());
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
        kinds.extend(for_linear());
    } else if !is_discrete && !timed {
        if matches!(requested.kind.plant(), PlantClass::AtPoint(_)) {
            let why = "the same observer of the linearisation there, in deviations from it";
            kinds.push(Proposal::keys([], &[], why).at_point());
        } else {
            let why = "of the linearisation there, in deviations from it";
            kinds.push(Proposal::kind("kalman", unit_noise(), why).at_point());
        }
    }
    let mut advice = Advice::of(kinds);
    let has_table = has_table(plant.model.size()) && !timed && !is_discrete;
    if has_table && requested.kind.name() != "kkl-numerical" {
        let held = if plant.inputs.is_empty() { "" } else { ", for inputs that are held" };
        advice.hints.push(format!(
            "kkl-numerical takes plants of this size, by simulation, without assumptions on f{held}; it was not tried, since its design takes minutes"
        ));
    }
    advice
}

/// The ways to a gain that the kind has beside its own one.
pub(crate) fn another_gain(requested: &ObserverSpec) -> Advice {
    match (requested.kind.gain(), requested.kind.takes_region()) {
        (Some(gain), _) => other_gains(gain),
        (None, true) if requested.kind.has_given_gain() => gain_for_region(),
        _ => Advice::default(),
    }
}

/// Another gain of a linear observer.
pub(crate) fn other_gains(linear: &LinearSpec) -> Advice {
    // The last two are limits, which go with a gain by matrix inequality.
    const UNLIMITED: &[&str] =
        &["bandwidth", "poles", "decay_rate", "lmi", "kalman", "gain", "rho", "q", "max_gain", "noise"];
    const ALL: &[&str] = UNLIMITED.split_at(UNLIMITED.len() - 2).0;
    let mut ways = Vec::new();
    if !matches!(linear.gain, GainSpec::Lmi) {
        ways.push(Proposal::keys(["lmi = true".to_owned()], ALL, LARGEST_MARGIN));
    }
    if !matches!(linear.gain, GainSpec::Kalman(_)) {
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

/// The most states of a table without inputs, and with.
pub(crate) const MOST_STATES: (usize, usize) = (6, 3);

/// The most held inputs.
pub(crate) const MOST_INPUTS: usize = 2;

/// Whether there is a numerical KKL observer for a plant of this size.
pub(crate) fn has_table(size: Dimensions) -> bool {
    let most = if size.inputs == 0 { MOST_STATES.0 } else { MOST_STATES.1 };
    size.outputs == 1 && (2..=most).contains(&size.states) && size.inputs <= MOST_INPUTS
}
