//! Diagnosis of an observer that is not applicable: the violated hypothesis with its numbers, alternatives to be tried,
//! and hints.

use luenberger_design::kkl::ResidualWitness;
use luenberger_design::{DesignError, EnclosureError, KklError, LpvError, NumericalKklError, Pair, UnseenModes};
use luenberger_expression::{ExpressionPlantError, Row};
use luenberger_linalg::{LinalgError, observability};
use luenberger_observers::ObserverError;
use luenberger_plants::PlantError;
use luenberger_proof::wording::{at_least, at_most, shortest, significant};

use super::alternative::{Advice, another_gain, list, other_kinds, rows, slower};
use crate::model::Model;
use crate::results::report::eigenvalue;
use crate::results::{FailureReport, Proposal};
use crate::structure::Structure;
use crate::study::{ObserverSpec, Study};

/// With more states the table of a numerical KKL observer is of low rank.
pub(crate) const MOST_STATES_OF_A_FULL_TABLE: usize = 4;

/// Error of a design, or a hypothesis that is checked by the study.
pub(crate) enum Misfit {
    Design(DesignError),
    Enclosure(EnclosureError),
    Lpv(LpvError),
    NumericalKkl(NumericalKklError),
    Expressions(ExpressionPlantError),
    Kkl(KklError),
    NotLeftInverse { state: usize, found: f64, point: Vec<f64>, time: f64, missed: f64 },
    UndefinedLeftInverse { point: Vec<f64> },
    Rank { needed: usize, smallest: f64, point: Vec<f64> },
    NotRegression { worst: ResidualWitness, inputs: usize },
    Silent { delta: f64, window: f64, from: f64, direction: Vec<f64> },
}

impl From<DesignError> for Misfit {
    fn from(error: DesignError) -> Self {
        Self::Design(error)
    }
}

impl From<ExpressionPlantError> for Misfit {
    fn from(error: ExpressionPlantError) -> Self {
        Self::Expressions(error)
    }
}

impl From<EnclosureError> for Misfit {
    fn from(error: EnclosureError) -> Self {
        Self::Enclosure(error)
    }
}

impl From<LpvError> for Misfit {
    fn from(error: LpvError) -> Self {
        match error {
            LpvError::Design(error) => Self::Design(error),
            LpvError::Enclosure(error) => Self::Enclosure(error),
            error => Self::Lpv(error),
        }
    }
}

impl From<NumericalKklError> for Misfit {
    fn from(error: NumericalKklError) -> Self {
        match error {
            NumericalKklError::Design(error) => Self::Design(error),
            error => Self::NumericalKkl(error),
        }
    }
}

impl From<KklError> for Misfit {
    fn from(error: KklError) -> Self {
        match error {
            KklError::Design(error) => Self::Design(error),
            KklError::Enclosure(error) => Self::Enclosure(error),
            error => Self::Kkl(error),
        }
    }
}

impl From<PlantError> for Misfit {
    fn from(error: PlantError) -> Self {
        Self::Design(error.into())
    }
}

impl From<ObserverError> for Misfit {
    fn from(error: ObserverError) -> Self {
        Self::Design(error.into())
    }
}

pub(crate) fn failure(requested: &ObserverSpec, hypothesis: String, advice: Advice) -> FailureReport {
    let Advice { proposals, hints } = advice;
    FailureReport { hints, proposals, ..FailureReport::new(hypothesis, requested.place.line) }
}

pub(crate) fn not_linear(study: &Study, requested: &ObserverSpec) -> FailureReport {
    let parts = study.plant.model.nonlinearities();
    let what = match (&study.plant.model, parts.is_empty()) {
        (Model::Builtin(builtin), _) => format!("`{}` is nonlinear", builtin.name()),
        (_, false) => format!("this one is nonlinear: {}", parts.join(" and ")),
        (_, true) => "this one has a constant term".to_owned(),
    };
    let kind = requested.kind.name();
    let hypothesis = format!("the kind {kind} needs a linear plant, x' = A x + B u and y = C x + D u, and {what}");
    failure(requested, hypothesis, other_kinds(study, requested))
}

/// The diagnosis, with the names of the study.
pub(crate) fn misfit(study: &Study, requested: &ObserverSpec, misfit: &Misfit) -> FailureReport {
    let kind = requested.kind.name();
    let (hypothesis, advice) = match misfit {
        Misfit::Design(DesignError::VaryingOutput { output, state, low, high }) => {
            let hypothesis = format!(
                "the kind {kind} needs outputs that are linear in the state, and the derivative of {} by {} is between {} and {}",
                study.plant.outputs[*output],
                study.plant.states[*state],
                shortest(*low),
                shortest(*high)
            );
            (hypothesis, other_kinds(study, requested))
        }
        Misfit::Design(error) => {
            let others = || other_kinds(study, requested);
            let advice = match error {
                DesignError::NotDetectable { .. }
                | DesignError::OfPair { .. }
                | DesignError::Linalg(
                    LinalgError::Unobservable { .. }
                    | LinalgError::NotDetectable { .. }
                    | LinalgError::PoleMultiplicity { .. },
                ) => return hidden(study, requested, error).caused_by(misfit),
                DesignError::Linalg(error) => of_functional(study, requested, error),
                DesignError::Infeasible { .. } => with_smaller_rate(study, requested),
                DesignError::VaryingPeriods { largest: Some(periods), .. } => {
                    let keys = [
                        format!("jitter = [{}, {}]", at_most(periods.shortest, 4), at_least(periods.longest, 4)),
                        format!("misses = {}", periods.misses),
                    ];
                    let proved = Proposal::keys(keys, &["jitter", "misses"], "for which convergence is proved");
                    Advice::of([proved]).and(Advice::hint("slower `poles`"))
                }
                DesignError::VaryingPeriods { largest: None, .. } => Advice::hint("a shorter `period`; other `poles`"),
                DesignError::Undecided { .. } if kind == "interval" => Advice::hint("`poles`, with modal coordinates"),
                DesignError::Undecided { .. } | DesignError::RefutedAsRounded { .. } => {
                    slower(requested).and(others()).and(Advice::hint("a smaller `decay_rate` or `region`"))
                }
                DesignError::NotHurwitz { .. }
                | DesignError::NotSchur { .. }
                | DesignError::StabilityUndecided { .. } => another_gain(study, requested),
                DesignError::UnseenDisturbance { .. } => {
                    Advice::hint("fewer columns of `e`, or an output that depends on this state")
                }
                DesignError::NothingReachesTheError => {
                    Advice::of([Proposal::keys([], &["bounds"], "nothing acts that would have to be bounded")])
                }
                DesignError::NormTooSmall { best, .. } => of_larger_gamma(*best, false),
                DesignError::NormNotFound { best, is_limited, .. } => of_larger_gamma(*best, *is_limited),
                DesignError::NoiselessOutput { .. } => {
                    Advice::hint("`gamma` or `max_gain`, which bound the gain; or a row of `d` for each output")
                }
                DesignError::FixedPoles { .. } => {
                    another_gain(study, requested).and(Advice::hint("`poles` with these zeros among them"))
                }
                DesignError::NoModalCoordinates { .. } | DesignError::DependentModes { .. } => {
                    Advice::of([in_coordinates("plant")]).and(Advice::hint("distinct `poles`"))
                }
                DesignError::WidthGrows { plant: true, .. } => Advice::of([
                    in_coordinates("modal"),
                    Proposal::keys(
                        ["least_width = true".to_owned()],
                        &["poles", "decay_rate", "lmi", "kalman", "gain", "coordinates"],
                        "a gain with a stable width",
                    ),
                ]),
                DesignError::WidthGrows { plant: false, .. } | DesignError::ComparisonUndecided => {
                    Advice::hint("faster or more separate `poles`")
                }
                DesignError::NoLeastWidth { .. } => Advice::hint("`poles`, with modal coordinates"),
                DesignError::QuietOutput { .. } => {
                    Advice::hint("`noise` in `bounds` with a bound above 0 for each output, or `poles`")
                }
                DesignError::UnmatchedDisturbance { .. } | DesignError::UnstableZero { is_fed: false, .. } => {
                    with_slow_disturbance(requested)
                }
                DesignError::UnmatchedInOutputs { .. } | DesignError::UnstableZero { is_fed: true, .. } => {
                    Advice::hint("a further output, without the disturbance, whose derivative depends on it")
                }
                DesignError::CubicOfOutputs => {
                    Advice::of([Proposal::keys([], &["gamma", "theta"], "the linear observer")])
                }
                _ => Advice::default(),
            };
            (error.to_string(), advice)
        }
        Misfit::Enclosure(error) => (
            format!("{error}; the derivatives must be bounded over the region"),
            other_kinds(study, requested)
                .and(Advice::hint("a smaller, bounded `region` in which the state is known to stay")),
        ),
        Misfit::Lpv(error) => {
            let advice = match error {
                LpvError::TooManyVertices { .. } => {
                    other_kinds(study, requested).and(Advice::hint("a smaller `region`, in which fewer entries vary"))
                }
                LpvError::HiddenMode(_) | LpvError::Conflict(_) => with_smaller_rate(study, requested),
                LpvError::UnstableVertex { .. } => another_gain(study, requested),
                _ => Advice::default(),
            };
            (error.to_string(), advice)
        }
        Misfit::NumericalKkl(error) => {
            let is_held = !study.plant.inputs.is_empty();
            // What fails at one input has the remedies of what fails without.
            let failing = match error {
                NumericalKklError::HeldInput { error, .. } => error.as_ref(),
                error => error,
            };
            let remedy = match failing {
                NumericalKklError::Unresolved { .. } if is_held => Some(
                    "increase `points`, `nodes` or `cutoff`, or choose a smaller `domain` or smaller ranges of `inputs`",
                ),
                NumericalKklError::Unresolved { .. } if study.plant.states.len() > MOST_STATES_OF_A_FULL_TABLE => {
                    Some("increase `points`, `rank` or `cutoff`, or choose a smaller `domain`")
                }
                NumericalKklError::Unresolved { .. } => {
                    Some("increase `points` or `cutoff`, or choose a smaller `domain`")
                }
                NumericalKklError::NoneFits { .. } => {
                    Some("a smaller `domain`, or `cutoff` and `points` of your choice")
                }
                NumericalKklError::GridTooLarge { .. } if is_held => Some("fewer `points` or `nodes`"),
                NumericalKklError::GridTooLarge { .. } => Some("fewer `points`"),
                NumericalKklError::Escapes { .. } => {
                    Some("give `escape`, the margin around `domain` outside of which the plant is slowed down")
                }
                NumericalKklError::NotInjective { .. } => {
                    Some("increase `cutoff`, or choose a `domain` on which the output distinguishes all states")
                }
                _ => None,
            };
            let remedy = remedy.map_or_else(Advice::default, Advice::hint);
            (error.to_string(), other_kinds(study, requested).and(remedy))
        }
        Misfit::Kkl(error) => (error.to_string(), another_map(study, error)),
        Misfit::NotLeftInverse { state, found, point, time, missed } => {
            let states = &study.plant.states;
            let instant = match study.plant.model.structure().explicit_time() {
                Some(_) => format!(", t = {}", significant(*time, 4)),
                None => String::new(),
            };
            let hypothesis = format!(
                "`left_inverse` is not a left inverse of phi: at {}{instant} it gives {} = {}, an error of {} half-widths of the region, the largest over all sampled states",
                at_state(study, point),
                states[*state],
                significant(*found, 6),
                significant(*missed, 3)
            );
            (hypothesis, Advice::hint("a `left_inverse` with phi^L(phi(x), h(x)) = x on the whole region"))
        }
        Misfit::UndefinedLeftInverse { point } => (
            format!("`left_inverse` has no finite value at {}, in the region", at_state(study, point)),
            Advice::hint("a smaller `region`, in which phi^L(phi(x), h(x)) is defined"),
        ),
        Misfit::Rank { needed, smallest, point } => {
            let hypothesis = format!(
                "D_chi beta does not have the rank {needed} (A4): its least singular value is {} at {}, with chi of the start",
                significant(*smallest, 3),
                at_state(study, point)
            );
            (
                hypothesis,
                Advice::hint("a `beta` whose Jacobian by chi has full row rank, such as chi plus a function of y"),
            )
        }
        Misfit::NotRegression { worst, inputs } => {
            let ResidualWitness { row, at_least, place, .. } = worst;
            let (u, theta) = place.input.split_at(*inputs);
            let input = if u.is_empty() { String::new() } else { format!(", u = {u:?}") };
            let hypothesis = format!(
                "row {} of `s`, `g` and `m` is no regression: d s(y)/dt and g + m theta differ by at least {} at x = {:?}{input}, theta = {theta:?}, with xi = phi(x) - missing(theta)",
                row + 1,
                significant(*at_least, 4),
                place.state
            );
            (hypothesis, Advice::hint("other `s`, `g`, `m` or `missing`: the two sides differ at the point named"))
        }
        Misfit::Silent { delta, window, from, direction } => {
            let direction: Vec<String> = direction.iter().map(|x| significant(*x, 3)).collect();
            let hypothesis = format!(
                "the regression is not exciting along the run of [simulation]: over the {} after t = {} the least eigenvalue of int M'M is {}, and the direction ({}) of theta is not seen",
                significant(*window, 4),
                significant(*from, 4),
                significant(*delta, 3),
                direction.join(", ")
            );
            let exciting = "an input or an initial state that excites the regressor m, or a longer `window`";
            let kkl = "the kind kkl: a Lambda that is stable, where there is one, needs no excitation";
            (hypothesis, Advice::hint(exciting).and(Advice::hint(kkl)))
        }
        Misfit::Expressions(error) => (error.to_string(), Advice::default()),
    };
    failure(requested, hypothesis, advice).caused_by(misfit)
}

/// A state with the names of the study.
fn at_state(study: &Study, point: &[f64]) -> String {
    let entries = study.plant.states.iter().zip(point);
    entries.map(|(name, x)| format!("{name} = {}", significant(*x, 4))).collect::<Vec<_>>().join(", ")
}

impl FailureReport {
    fn caused_by(mut self, misfit: &Misfit) -> Self {
        if let Misfit::Design(error) = misfit {
            self.cause = Some(Box::new(error.clone()));
        }
        self
    }
}

fn with_smaller_rate(study: &Study, requested: &ObserverSpec) -> Advice {
    let hint = if requested.kind.takes_region() { Advice::hint("a smaller `region`") } else { Advice::default() };
    slower(requested).and(other_kinds(study, requested)).and(hint)
}

/// The same bounds in other coordinates.
fn in_coordinates(coordinates: &str) -> Proposal {
    Proposal::keys([format!("coordinates = \"{coordinates}\"")], &["coordinates"], "the error bounded in these")
}

/// The disturbance of an unknown-input observer as a state, or seen by another output.
fn with_slow_disturbance(requested: &ObserverSpec) -> Advice {
    let Some(e) = requested.kind.unknown_disturbance() else { return Advice::default() };
    let keys = [format!("e = {}", rows(e)), "lmi = true".to_owned()];
    let why = "for a disturbance that is constant or varies slowly";
    Advice::of([Proposal::kind("proportional-integral", keys, why)])
        .and(Advice::hint("a further output, whose derivative depends on the disturbance"))
}

/// What to change of the maps.
fn another_map(study: &Study, error: &KklError) -> Advice {
    if let (KklError::ResidualUndecided { .. }, Some(row)) = (error, study.plant.model.structure().explicit_time()) {
        let row = study.plant.row(row);
        let maps = format!("other `phi`, `lambda` or `b`, in which t may occur: {row} depends on the time t");
        return Advice::hint(maps).and(Advice::hint("a smaller `region`, its `time` included"));
    }
    let remedy = match error {
        KklError::NotASolution(_) => "other `phi`, `lambda` or `b`: the two sides differ at the point named",
        KklError::ResidualUndecided { .. } => "a smaller `region`, or maps without kinks, jumps and lookup tables",
        KklError::NotHurwitz { eigenvalue, .. } if eigenvalue.re == 0.0 && eigenvalue.im == 0.0 => {
            "the kind kkl-peb: rows of `lambda` that are zero leave a constant, which it estimates"
        }
        KklError::NotHurwitz { .. } | KklError::HurwitzUndecided { .. } => {
            "another `lambda`, or a smaller `region` of the inputs"
        }
        KklError::ReadsItself(_) | KklError::CouplingUndecided(_) => {
            "rows of `b` that use earlier entries of xi only; the linear part belongs into `lambda`"
        }
        KklError::NotInjective(_) | KklError::Indistinct(_) => {
            "a `phi` with more rows, or a smaller `region` on which (phi, h) distinguishes all states"
        }
        KklError::Undefined { .. } => "a smaller `region`, in which plant and maps are defined",
        _ => return Advice::default(),
    };
    Advice::hint(remedy)
}

/// A bound of a norm that a gain is known to keep, with a hundredth to spare.
fn of_larger_gamma(best: Option<f64>, is_limited: bool) -> Advice {
    let gamma = best.map(|best| {
        let gamma = format!("gamma = {}", at_most(1.01 * best, 4));
        Proposal::keys([gamma], &["gamma"], "a norm that was found")
    });
    let hint = if is_limited { Advice::hint("a larger `max_gain`") } else { Advice::default() };
    Advice::of(gamma).and(hint)
}

/// A plant with an unobservable mode, or a pair made of it: the mode, its direction, and which observers still exist.
fn hidden(study: &Study, requested: &ObserverSpec, error: &DesignError) -> FailureReport {
    let plant =
        study.plant.model.linear().filter(|_| !matches!(error, DesignError::OfPair { pair: Pair::Decoupled, .. }));
    let seen = plant.and_then(|plant| observability(&plant.a, &plant.c).ok().map(|seen| (plant, seen)));
    let Some((plant, seen)) = seen.filter(|(_, seen)| !seen.unobservable.is_empty()) else {
        return failure(requested, error.to_string(), instead_of(study, requested, error));
    };
    let unseen = UnseenModes::of(&plant.a, &plant.c, study.plant.time());
    let modes = seen.unobservable.iter().map(|mode| {
        let direction: Vec<f64> = mode.direction.iter().map(|x| x.re).collect();
        format!(
            "{} along {} (margin {})",
            eigenvalue([mode.eigenvalue.re, mode.eigenvalue.im]),
            study.plant.direction_in_words(&direction),
            significant(mode.margin, 2)
        )
    });
    let modes: Vec<String> = modes.collect();
    // Beside the modes that no output sees there may be others that floating point cannot tell from them.
    let are_all = UnseenModes::count(&plant.a, &plant.c) == Some(modes.len());
    let how = match unseen {
        UnseenModes::Decay | UnseenModes::Remain if are_all => ": unobservable modes",
        UnseenModes::Decay | UnseenModes::Remain => ", and to working precision its unobservable modes are",
        UnseenModes::None | UnseenModes::Undecided => " to working precision: unobservable modes",
    };
    let others = || another_gain(study, requested).and(other_kinds(study, requested));
    let advice = match unseen {
        UnseenModes::Decay if !are_all => others().and(Advice::hint(
            "an observer exists, since the plant as stored is detectable, and its gain is large: other units, or an output that depends more on these directions",
        )),
        UnseenModes::Decay => {
            others().and(Advice::hint("the unobservable modes are stable (the plant is detectable): no gain changes them"))
        }
        UnseenModes::Remain => Advice::hint(
            "the plant is not detectable, no observer exists: add an output that depends on this direction",
        ),
        UnseenModes::None => others().and(Advice::hint(
            "an observer exists, since the plant as stored is observable, and its gain is large: other units, or an output that depends more on this direction",
        )),
        UnseenModes::Undecided => others().and(Advice::hint("an output that depends on this direction")),
    };
    let hypothesis = format!("the plant is not observable{how} {}", modes.join(", "));
    failure(requested, hypothesis, advice)
}

/// What to do about a hidden mode of a pair that is not hidden in the plant.
fn instead_of(study: &Study, requested: &ObserverSpec, error: &DesignError) -> Advice {
    // The other kinds do not estimate a disturbance.
    let others = if requested.kind.unknown_disturbance().is_some() {
        another_gain(study, requested)
    } else {
        another_gain(study, requested).and(other_kinds(study, requested))
    };
    let hint = match error {
        DesignError::Linalg(LinalgError::PoleMultiplicity { .. }) => "fewer repeated poles",
        DesignError::OfPair { pair: Pair::Sampled, .. } => "a shorter `period`",
        DesignError::OfPair { pair: Pair::Decoupled, .. } => {
            return with_slow_disturbance(requested).and(others);
        }
        DesignError::OfPair { pair: Pair::WithDisturbance, .. } => {
            "other units, or an output that depends more on the disturbance"
        }
        DesignError::NotDetectable { .. } => "an output that depends on this mode",
        DesignError::OfPair { error, .. } => return instead_of(study, requested, error),
        _ => "other units, or an output that depends more on this mode",
    };
    others.and(Advice::hint(hint))
}

/// Observers whose theory is for outputs without the input.
pub(crate) fn output_of_the_state(study: &Study, requested: &ObserverSpec) -> Result<(), FailureReport> {
    let Some(k) = study.plant.model.structure().feedthrough() else { return Ok(()) };
    let (kind, output) = (requested.kind.name(), &study.plant.outputs[k]);
    let hypothesis =
        format!("the kind {kind} is for outputs of the state alone, y = h(t, x): {output} depends on the input");
    Err(failure(requested, hypothesis, other_kinds(study, requested)))
}

/// That a row is not the state that it should be, or is not shown to be it.
pub(crate) fn other_than(study: &Study, structure: &Structure, row: Row, state: usize) -> String {
    let differs = structure.differs(row, state);
    let (name, state) = (study.plant.row(row), &study.plant.states[state]);
    if differs {
        format!("{name} is not {state}")
    } else {
        format!("{name} is not shown to be {state} for all states, inputs and times")
    }
}

/// What output k is, where it should be state i.
pub(crate) fn measured_in_place_of(study: &Study, structure: &Structure, k: usize, i: usize) -> String {
    let (states, output) = (&study.plant.states, &study.plant.outputs[k]);
    match structure.output_state(k) {
        Some(j) => format!("{output} measures {}, not {}; reorder the states", states[j], states[i]),
        None => other_than(study, structure, Row::Output(k), i),
    }
}

/// Why the plant has no chains of these lengths: each begins at its output, and each equation of a chain depends on the
/// next state and on no later one.
pub(crate) fn no_chains(study: &Study, structure: &Structure, kind: &str, lengths: &[usize]) -> Option<String> {
    let states = &study.plant.states;
    let heads = lengths.iter().scan(0, |next, length| Some(std::mem::replace(next, *next + length)));
    for (k, (head, length)) in heads.zip(lengths).enumerate() {
        if structure.output_state(k) != Some(head) {
            let why = measured_in_place_of(study, structure, k, head);
            return Some(format!("the kind {kind} needs chains that begin at the outputs: {why}"));
        }
        for i in head..(head + length).saturating_sub(1) {
            if !structure.depends_on(i, i + 1) {
                return Some(format!(
                    "the kind {kind} needs a chain: {}' does not depend on {}",
                    states[i],
                    states[i + 1]
                ));
            }
            if let Some(j) = (i + 2..head + length).find(|&j| structure.depends_on(i, j)) {
                return Some(format!(
                    "the kind {kind} needs a triangular plant: {}' depends on {}, which is further down its chain than the next state",
                    states[i], states[j]
                ));
            }
        }
    }
    None
}

/// What to do where Darouach's conditions of a functional observer do not hold.
fn of_functional(study: &Study, requested: &ObserverSpec, error: &LinalgError) -> Advice {
    let hint = match error {
        LinalgError::NotFunctional { .. } => None,
        LinalgError::FixedObserverMode { .. } => Some("other rows of `k`"),
        _ => return Advice::default(),
    };
    let (Some((k, _)), Some(poles), Some(plant)) =
        (requested.kind.functions(), requested.kind.poles(), study.plant.model.linear())
    else {
        return Advice::default();
    };
    let fastest = poles.iter().map(|pole| pole.re).fold(0.0, f64::min);
    // Poles a tenth apart, from the fastest one on.
    let further = |count: usize| (0..count).map(move |i| significant_value(fastest * (1.0 + 0.1 * (i + 1) as f64)));
    let mut ways = Vec::new();
    if let (LinalgError::NotFunctional { row, .. }, true) = (error, poles.iter().all(|pole| pole.im == 0.0)) {
        let mut longer = k.clone().insert_row(k.nrows(), 0.0);
        longer.row_mut(k.nrows()).copy_from(&(k.row(*row) * &plant.a));
        let poles = poles.iter().map(|pole| pole.re).chain(further(1));
        let keys = [format!("k = {}", rows(&longer)), format!("poles = {}", list(poles))];
        ways.push(Proposal::keys(keys, &["k", "poles"], "with the rate of a function among the functions"));
    }
    let left = plant.a.nrows().saturating_sub(plant.c.nrows());
    let poles = format!("poles = {}", list(further(left)));
    ways.push(Proposal::kind("reduced-order", [poles], "for the whole state"));
    Advice::of(ways).and(other_kinds(study, requested)).and(hint.map_or_else(Advice::default, Advice::hint))
}

/// A number with three digits.
fn significant_value(x: f64) -> f64 {
    significant(x, 3).parse().unwrap_or(x)
}
