//! Diagnosis of an observer that is not applicable: the violated hypothesis with its numbers, and applicable
//! alternatives.

use luenberger_design::kkl::ResidualWitness;
use luenberger_design::{DesignError, EnclosureError, KklError, LpvError, NumericalKklError, Pair, UnseenModes};
use luenberger_expression::{ExpressionPlantError, Row};
use luenberger_linalg::{LinalgError, observability};
use luenberger_observers::ObserverError;
use luenberger_plants::{Dimensions, PlantError};
use luenberger_proof::wording::{at_least, at_most, counted, shortest, significant};
use nalgebra::DVector;

use crate::model::{Builtin, Model};
use crate::results::FailureReport;
use crate::results::report::eigenvalue;
use crate::runnable::Chains;
use crate::structure::Structure;
use crate::study::{KklSpec, MOST_STATES_OF_A_FULL_TABLE, ObserverKind, ObserverSpec, Study};

/// Error of a design, or a hypothesis that is checked here.
pub(super) enum Misfit {
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

pub(super) fn failure(requested: &ObserverSpec, hypothesis: String, alternatives: Vec<String>) -> FailureReport {
    FailureReport { hypothesis, alternatives, line: requested.place.line, cause: None }
}

/// The kinds of observers for nonlinear plants that are applicable to this one.
pub(super) fn for_nonlinear(study: &Study, but: &str) -> Vec<String> {
    let (size, structure) = (study.plant.model.size(), study.plant.model.structure());
    let is_of_the_state = structure.feedthrough().is_none();
    let mut kinds = vec![("lpv", "one gain for all Jacobians over a bounded `region`, with a proof")];
    if study.plant.dt.is_none() {
        if structure.has_linear_outputs() {
            kinds.push(("lipschitz", "one gain for all slopes within sectors, with a proof"));
        }
        if is_of_the_state && not_measured_first(&structure, size).is_none() && size.outputs < size.states {
            kinds.push(("mean-value", "for a plant that measures its first states, with a proof"));
        }
        if is_of_the_state && structure.explicit_time().is_none() && has_table(size) {
            let why = if size.inputs == 0 {
                "by simulation, without assumptions on f; its errors are measured"
            } else {
                "by simulation, without assumptions on f, for inputs that are held; its errors are measured"
            };
            kinds.push(("kkl-numerical", why));
        }
    }
    kinds.push(("extended-kalman", "without a proof"));
    kinds.into_iter().filter(|(kind, _)| *kind != but).map(|(kind, why)| format!("{kind}: {why}")).collect()
}

pub(super) fn not_linear(study: &Study, requested: &ObserverSpec) -> FailureReport {
    let parts = study.plant.model.nonlinearities();
    let what = match (&study.plant.model, parts.is_empty()) {
        (Model::Builtin(builtin), _) => format!("`{}` is nonlinear", builtin.name()),
        (_, false) => format!("this one is nonlinear: {}", parts.join(" and ")),
        (_, true) => "this one has a constant term".to_owned(),
    };
    let kind = requested.kind.name();
    let hypothesis = format!("the kind {kind} needs a linear plant, x' = A x + B u and y = C x + D u, and {what}");
    let mut instead = for_nonlinear(study, kind);
    if study.plant.model.structure().explicit_time().is_none() {
        let at_point = match kind {
            "optimal-cubic" | "proportional-integral" | "unknown-input" => "luenberger",
            kind => kind,
        };
        instead
            .push(format!("{at_point} with an [operating_point]: of the linearisation there, in deviations from it"));
    }
    failure(requested, hypothesis, instead)
}

/// The diagnosis, with the names of the study.
pub(super) fn misfit(study: &Study, requested: &ObserverSpec, misfit: &Misfit) -> FailureReport {
    let kind = requested.kind.name();
    let (hypothesis, alternatives) = match misfit {
        Misfit::Design(DesignError::VaryingOutput { output, state, low, high }) => {
            let hypothesis = format!(
                "the kind {kind} needs outputs that are linear in the state, and the derivative of {} by {} is between {} and {}",
                study.plant.outputs[*output],
                study.plant.states[*state],
                shortest(*low),
                shortest(*high)
            );
            (hypothesis, for_nonlinear(study, kind))
        }
        Misfit::Design(error) => {
            let alternatives = match error {
                DesignError::NotDetectable { .. }
                | DesignError::OfPair { .. }
                | DesignError::Linalg(
                    LinalgError::Unobservable { .. }
                    | LinalgError::NotDetectable { .. }
                    | LinalgError::PoleMultiplicity { .. },
                ) => return hidden(study, requested, error).caused_by(misfit),
                DesignError::Linalg(error) => of_functional(error).unwrap_or_default(),
                DesignError::Infeasible { .. } => with_smaller_rate(study, kind),
                DesignError::VaryingPeriods { largest: Some(periods), .. } => {
                    vec![format!(
                        "jitter = [{}, {}] and misses = {}, which are proved; or slower `poles`",
                        at_most(periods.shortest, 4),
                        at_least(periods.longest, 4),
                        periods.misses
                    )]
                }
                DesignError::VaryingPeriods { largest: None, .. } => {
                    vec!["a shorter `period`; other `poles`".to_owned()]
                }
                DesignError::Undecided { .. } if kind == "interval" => {
                    vec!["`poles`, with modal coordinates".to_owned()]
                }
                DesignError::Undecided { .. } | DesignError::RefutedAsRounded { .. } => {
                    vec!["a smaller `decay_rate` or `region`".to_owned()]
                }
                DesignError::NotHurwitz { .. }
                | DesignError::NotSchur { .. }
                | DesignError::StabilityUndecided { .. } => another_gain(kind),
                DesignError::UnseenDisturbance { .. } => {
                    vec!["fewer columns of `e`, or an output that depends on this state".to_owned()]
                }
                DesignError::NothingReachesTheError => vec!["the same observer without `bounds`".to_owned()],
                DesignError::NormTooSmall { best, .. } => of_larger_gamma(*best, false),
                DesignError::NormNotFound { best, is_limited, .. } => of_larger_gamma(*best, *is_limited),
                DesignError::NoiselessOutput { .. } => {
                    vec!["`gamma` or `max_gain`, which bound the gain; or a row of `d` for each output".to_owned()]
                }
                DesignError::FixedPoles { .. } => {
                    vec!["`poles` with these zeros among them".to_owned(), "`lmi` or `kalman`".to_owned()]
                }
                DesignError::NoModalCoordinates { .. } | DesignError::DependentModes { .. } => {
                    vec!["distinct `poles`, or coordinates = \"plant\"".to_owned()]
                }
                DesignError::WidthGrows { plant: true, .. } => vec![
                    "coordinates = \"modal\"".to_owned(),
                    "least_width = true, which looks for a gain with a stable width".to_owned(),
                ],
                DesignError::WidthGrows { plant: false, .. } | DesignError::ComparisonUndecided => {
                    vec!["faster or more separate `poles`".to_owned()]
                }
                DesignError::NoLeastWidth { .. } => vec!["`poles`, with modal coordinates".to_owned()],
                DesignError::QuietOutput { .. } => {
                    vec!["`noise` in `bounds` with a bound above 0 for each output, or `poles`".to_owned()]
                }
                DesignError::UnmatchedDisturbance { .. } | DesignError::UnstableZero { .. } => {
                    vec!["proportional-integral: for a disturbance that is constant or varies slowly".to_owned()]
                }
                _ => Vec::new(),
            };
            (error.to_string(), alternatives)
        }
        Misfit::Enclosure(error) => {
            let mut kinds = vec!["a smaller, bounded `region` in which the state is known to stay".to_owned()];
            kinds.extend(for_nonlinear(study, kind).into_iter().filter(|other| {
                !["lpv", "lipschitz", "mean-value"].iter().any(|enclosing| other.starts_with(enclosing))
            }));
            (format!("{error}; the derivatives must be bounded over the region"), kinds)
        }
        Misfit::Lpv(error) => {
            let alternatives = match error {
                LpvError::TooManyVertices { .. } => {
                    vec!["a smaller `region`, in which fewer entries vary".to_owned()]
                }
                LpvError::HiddenMode(_) | LpvError::Conflict(_) => with_smaller_rate(study, kind),
                LpvError::UnstableVertex { .. } => another_gain(kind),
                _ => Vec::new(),
            };
            (error.to_string(), alternatives)
        }
        Misfit::NumericalKkl(error) => {
            let is_held = matches!(&requested.kind, ObserverKind::KklNumerical(spec) if !spec.inputs.is_empty());
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
            let mut alternatives: Vec<String> = remedy.into_iter().map(str::to_owned).collect();
            alternatives.extend(for_nonlinear(study, kind));
            (error.to_string(), alternatives)
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
            (hypothesis, vec!["a `left_inverse` with phi^L(phi(x), h(x)) = x on the whole region".to_owned()])
        }
        Misfit::UndefinedLeftInverse { point } => (
            format!("`left_inverse` has no finite value at {}, in the region", at_state(study, point)),
            vec!["a smaller `region`, in which phi^L(phi(x), h(x)) is defined".to_owned()],
        ),
        Misfit::Rank { needed, smallest, point } => {
            let hypothesis = format!(
                "D_chi beta does not have the rank {needed} (A4): its least singular value is {} at {}, with chi of the start",
                significant(*smallest, 3),
                at_state(study, point)
            );
            (
                hypothesis,
                vec!["a `beta` whose Jacobian by chi has full row rank, such as chi plus a function of y".to_owned()],
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
            (hypothesis, vec!["other `s`, `g`, `m` or `missing`: the two sides differ at the point named".to_owned()])
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
            let remedies = [
                "an input or an initial state that excites the regressor m, or a longer `window`",
                "kkl: a Lambda that is stable, where there is one, needs no excitation",
            ];
            (hypothesis, remedies.map(str::to_owned).to_vec())
        }
        Misfit::Expressions(error) => (error.to_string(), Vec::new()),
    };
    failure(requested, hypothesis, alternatives).caused_by(misfit)
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

fn with_smaller_rate(study: &Study, kind: &str) -> Vec<String> {
    let mut kinds = vec!["a smaller `region` or a smaller `decay_rate`".to_owned()];
    kinds.extend(for_nonlinear(study, kind));
    kinds
}

/// What to change of the maps.
fn another_map(study: &Study, error: &KklError) -> Vec<String> {
    if let (KklError::ResidualUndecided { .. }, Some(row)) = (error, study.plant.model.structure().explicit_time()) {
        let row = study.plant.row(row);
        let maps = format!("other `phi`, `lambda` or `b`, in which t may occur: {row} depends on the time t");
        return vec![maps, "a smaller `region`, its `time` included".to_owned()];
    }
    let remedy = match error {
        KklError::NotASolution(_) => "other `phi`, `lambda` or `b`: the two sides differ at the point named",
        KklError::ResidualUndecided { .. } => "a smaller `region`, or maps without kinks, jumps and lookup tables",
        KklError::NotHurwitz { eigenvalue, .. } if eigenvalue.re == 0.0 && eigenvalue.im == 0.0 => {
            "kkl-peb: rows of `lambda` that are zero leave a constant, which it estimates"
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
        _ => return Vec::new(),
    };
    vec![remedy.to_owned()]
}

/// The ways to a gain that the kind has beside a given one.
fn another_gain(kind: &str) -> Vec<String> {
    let ways = match kind {
        "lpv" => "`decay_rate` or `fastest`",
        "lipschitz" => "`decay_rate`",
        _ => "`poles`, `decay_rate` or `lmi`",
    };
    vec![format!("{ways} in place of a given gain")]
}

/// The bounds of a norm that a gain is known to keep.
fn of_larger_gamma(best: Option<f64>, is_limited: bool) -> Vec<String> {
    let gamma = best.map(|best| format!("`gamma` above {}", at_most(best, 5)));
    gamma.into_iter().chain(is_limited.then(|| "a larger `max_gain`".to_owned())).collect()
}

/// A plant with an unobservable mode, or a pair made of it: the mode, its direction, and which observers still exist.
fn hidden(study: &Study, requested: &ObserverSpec, error: &DesignError) -> FailureReport {
    let plant =
        study.plant.model.linear().filter(|_| !matches!(error, DesignError::OfPair { pair: Pair::Decoupled, .. }));
    let seen = plant.and_then(|plant| observability(&plant.a, &plant.c).ok().map(|seen| (plant, seen)));
    let Some((plant, seen)) = seen.filter(|(_, seen)| !seen.unobservable.is_empty()) else {
        return failure(requested, error.to_string(), instead_of(error));
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
    let instead = match unseen {
        UnseenModes::Decay if !are_all => {
            "an observer exists, since the plant as stored is detectable, and its gain is large: other units, or an output that depends more on these directions"
        }
        UnseenModes::Decay => {
            "the unobservable modes are stable (the plant is detectable): `lmi = true`, `kalman`, or `poles` that contain them"
        }
        UnseenModes::Remain => {
            "the plant is not detectable, no observer exists: add an output that depends on this direction"
        }
        UnseenModes::None => {
            "an observer exists, since the plant as stored is observable, and its gain is large: other units, or an output that depends more on this direction"
        }
        UnseenModes::Undecided => "an output that depends on this direction",
    };
    let hypothesis = format!("the plant is not observable{how} {}", modes.join(", "));
    failure(requested, hypothesis, vec![instead.to_owned()])
}

/// What to do about a hidden mode of a pair that is not hidden in the plant.
fn instead_of(error: &DesignError) -> Vec<String> {
    let instead = match error {
        DesignError::Linalg(LinalgError::PoleMultiplicity { .. }) => {
            "fewer repeated poles: the multiplicity of a pole is at most the number of independent outputs"
        }
        DesignError::OfPair { pair: Pair::Sampled, .. } => "a shorter `period`",
        DesignError::OfPair { pair: Pair::Decoupled, .. } => {
            "proportional-integral: for a disturbance that is constant or varies slowly"
        }
        DesignError::OfPair { pair: Pair::WithDisturbance, .. } => {
            "other units, or an output that depends more on the disturbance"
        }
        DesignError::NotDetectable { .. } => "an output that depends on this mode",
        DesignError::OfPair { error, .. } => return instead_of(error),
        _ => "other units, or an output that depends more on this mode",
    };
    vec![instead.to_owned()]
}

/// Observers whose theory is for outputs without the input.
pub(super) fn output_of_the_state(study: &Study, requested: &ObserverSpec) -> Result<(), FailureReport> {
    let Some(k) = study.plant.model.structure().feedthrough() else { return Ok(()) };
    let (kind, output) = (requested.kind.name(), &study.plant.outputs[k]);
    let hypothesis =
        format!("the kind {kind} is for outputs of the state alone, y = h(t, x): {output} depends on the input");
    Err(failure(requested, hypothesis, for_nonlinear(study, kind)))
}

/// Observers whose theory takes the derivative of the output along f alone.
pub(super) fn output_without_time(study: &Study, requested: &ObserverSpec) -> Result<(), FailureReport> {
    let Some(k) = study.plant.model.structure().timed_output() else { return Ok(()) };
    let (kind, output) = (requested.kind.name(), &study.plant.outputs[k]);
    let hypothesis =
        format!("the kind {kind} is for outputs y = h(x) without the time: {output} depends on the time t");
    Err(failure(requested, hypothesis, for_nonlinear(study, kind)))
}

/// That a row is not the state that it should be, or is not shown to be it.
pub(super) fn other_than(study: &Study, structure: &Structure, row: Row, state: usize) -> String {
    let differs = structure.differs(row, state);
    let (name, state) = (study.plant.row(row), &study.plant.states[state]);
    if differs {
        format!("{name} is not {state}")
    } else {
        format!("{name} is not shown to be {state} for all states, inputs and times")
    }
}

/// What output k is, where it should be state i.
fn measured_in_place_of(study: &Study, structure: &Structure, k: usize, i: usize) -> String {
    let (states, output) = (&study.plant.states, &study.plant.outputs[k]);
    match structure.output_state(k) {
        Some(j) => format!("{output} measures {}, not {}; reorder the states", states[j], states[i]),
        None => other_than(study, structure, Row::Output(k), i),
    }
}

/// The first output that is not shown to be the state of its number.
fn not_measured_first(structure: &Structure, size: Dimensions) -> Option<usize> {
    (0..size.outputs.min(size.states)).find(|&k| structure.output_state(k) != Some(k))
}

pub(super) fn first_states_measured(study: &Study, requested: &ObserverSpec) -> Result<(), FailureReport> {
    let size = study.plant.model.size();
    let kind = requested.kind.name();
    if size.outputs >= size.states {
        let hypothesis =
            format!("the kind {kind} needs unmeasured states; this plant measures {} of {}", size.outputs, size.states);
        return Err(failure(requested, hypothesis, for_nonlinear(study, kind)));
    }
    let structure = study.plant.model.structure();
    let Some(k) = not_measured_first(&structure, size) else { return Ok(()) };
    let why = measured_in_place_of(study, &structure, k, k);
    let hypothesis = format!("the kind {kind} needs outputs that are the first states, y = (x1, .., xp): {why}");
    Err(failure(requested, hypothesis, for_nonlinear(study, kind)))
}

/// Why the plant has no chains of these lengths: each begins at its output, and each equation of a chain depends on the
/// next state and on no later one.
pub(super) fn no_chains(study: &Study, structure: &Structure, kind: &str, lengths: &[usize]) -> Option<String> {
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

/// The chains of a high-gain observer, whose coefficients of the next states are not 0 at the first estimate.
pub(super) fn chains(study: &Study, requested: &ObserverSpec, lengths: &[usize]) -> Result<Chains, FailureReport> {
    let (model, size) = (&study.plant.model, study.plant.model.size());
    let (states, kind) = (&study.plant.states, requested.kind.name());
    if let Some(hypothesis) = no_chains(study, &model.structure(), kind, lengths) {
        return Err(failure(requested, hypothesis, for_nonlinear(study, kind)));
    }
    let mut input = DVector::zeros(size.inputs);
    if let Some(program) = study.input.program() {
        program.at(0.0, input.as_mut_slice());
    }
    Chains::at(model, lengths, &requested.initial, &input).map_err(|(i, coefficient)| {
        let hypothesis = format!(
            "the kind {kind} divides by the derivative of {}' by {}, which is {} at the first estimate",
            states[i],
            states[i + 1],
            shortest(coefficient)
        );
        let remedy = "`initial` at a state where this derivative is finite and not 0, such as the operating point";
        failure(requested, hypothesis, vec![remedy.to_owned()])
    })
}

/// The most states of a table without inputs, and with.
const MOST_STATES: (usize, usize) = (6, 3);

/// The most held inputs.
const MOST_INPUTS: usize = 2;

/// Whether there is a numerical KKL observer for a plant of this size.
fn has_table(size: Dimensions) -> bool {
    let most = if size.inputs == 0 { MOST_STATES.0 } else { MOST_STATES.1 };
    size.outputs == 1 && (2..=most).contains(&size.states) && size.inputs <= MOST_INPUTS
}

pub(super) fn tabulated(study: &Study, requested: &ObserverSpec, spec: &KklSpec) -> Result<(), FailureReport> {
    let size = study.plant.model.size();
    let kind = requested.kind.name();
    let sizes = format!(
        "the kind {kind} takes plants with one output, of 2 to {} states, or of 2 or {} states with at most \
         {MOST_INPUTS} inputs",
        MOST_STATES.0, MOST_STATES.1
    );
    let hypothesis = if let Some(row) = study.plant.model.structure().explicit_time() {
        format!(
            "the kind {kind} is for plants x' = f(x, u), y = h(x, u) without the time: {} depends on the time t",
            study.plant.row(row)
        )
    } else if !has_table(size) {
        let what = if size.outputs != 1 {
            counted(size.outputs, "output")
        } else if (2..=MOST_STATES.0).contains(&size.states) && size.inputs > 0 {
            format!("{} and {}", counted(size.states, "state"), counted(size.inputs, "input"))
        } else {
            counted(size.states, "state")
        };
        format!("{sizes}; this plant has {what}")
    } else if size.inputs > 0 && spec.inputs.is_empty() {
        format!(
            "the kind {kind} takes inputs that are held at constant values, and needs their range, `inputs`; this \
             plant has {}",
            counted(size.inputs, "input")
        )
    } else {
        return Ok(());
    };
    let linear = matches!(study.plant.model, Model::Linear(_) | Model::Builtin(Builtin::DoubleIntegrator(_)));
    let mut alternatives = Vec::new();
    if has_table(size) && study.plant.model.structure().explicit_time().is_none() {
        let range = vec!["[lower, upper]"; size.inputs].join(", ");
        alternatives.push(format!("inputs = [{range}], if the input is held at constant values"));
    }
    if linear {
        alternatives.push("luenberger or cubic: the plant is linear".to_owned());
    } else {
        alternatives.extend(for_nonlinear(study, kind));
    }
    Err(failure(requested, hypothesis, alternatives))
}

/// What to do where Darouach's conditions of a functional observer do not hold; none for other errors.
fn of_functional(error: &LinalgError) -> Option<Vec<String>> {
    match error {
        LinalgError::NotFunctional { row, .. } => Some(vec![
            format!("row {} of K A as a further row of `k`, and a further pole", row + 1),
            "reduced-order, for the whole state".to_owned(),
        ]),
        LinalgError::FixedObserverMode { .. } => {
            Some(vec!["this eigenvalue among `poles`, if it is stable; other rows of `k`".to_owned()])
        }
        _ => None,
    }
}
