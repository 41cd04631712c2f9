//! The kinds of observers that a study can ask for, one module each.
//!
//! A module has everything that is of its kind alone: the keys and their reader, the plants it is for, its design in
//! continuous and in discrete time, its step on a target, its tuning rule and its words. Schema, help, `luenberger new
//! --list`, `luenberger advise` and its benchmark, exports and the live page derive from the [`registry`]. A new kind
//! is a module and a line of `KINDS`; a kind of another crate is one call of [`register`].
//!
//! | file | subject |
//! |---|---|
//! | `declaration` | what a kind declares |
//! | `settings` | the macro `keys!`: the keys of a kind as a struct, with their list and reader |
//! | `keys`, `filter`, `disturbance`, `norm_filter`, `peb` | keys and designs that kinds share |
//! | the others | a kind each, under its name in studies |

/// Name and plants of a specification, as its module declares them.
macro_rules! declared {
    () => {
        fn name(&self) -> &'static str {
            DECLARATION.name
        }

        fn plant(&self) -> crate::study::PlantClass {
            DECLARATION.plant
        }
    };
}

/// An observer as one that is simulated: `continuous`, or in samples (`sampled`).
macro_rules! runs {
    ($time:ident) => {
        fn any(&self) -> std::sync::Arc<dyn luenberger_sim::AnyObserver + '_> {
            crate::designed::$time(self)
        }
    };
}

/// The designs of a filter with a covariance: the same in both times, but for its prediction.
macro_rules! filters {
    () => {
        fn design(&self, plan: &Plan<'_>) -> Result<Designed, NoObserver> {
            self.designed(&plan.study.plant, Prediction::ErrorControlled)
        }

        fn design_in_discrete_time(&self, plan: &Plan<'_>, dt: f64) -> Result<Designed, NoObserver> {
            plan.has_period_of_plant(self.filter.period, dt)?;
            self.designed(&plan.study.plant, Prediction::Discrete)
        }

        fn wraps_angles(&self) -> bool {
            true
        }
    };
}

pub(crate) mod cubic;
mod declaration;
pub(crate) mod disturbance;
mod error_state_kalman;
mod extended_kalman;
mod extended_state;
mod filter;
mod functional;
mod h2;
mod h_infinity;
mod high_gain;
mod imm;
mod immersion_invariance;
pub(crate) mod interval;
mod iterated_extended_kalman;
mod kalman;
pub(crate) mod keys;
mod kkl;
pub(crate) mod kkl_numerical;
mod kkl_peb;
mod lipschitz;
mod lpv;
mod luenberger;
mod mean_value;
mod mhe;
pub(crate) mod norm_filter;
mod optimal_cubic;
mod particle;
pub(crate) mod peb;
mod pebo;
mod proportional_integral;
mod reduced_order;
mod sampled_cubic;
mod settings;
mod sliding_mode;
mod ukf;
mod unknown_input;

use std::any::Any;
use std::sync::{PoisonError, RwLock};

use luenberger_design::OperatingPoint;

use crate::designed::{Designed, SampledDesign};
use crate::results::{Advice, Cause, NoObserver};
use crate::steps;
use crate::study::{ObserverKind, Specification};
use crate::synthesis::explain;

pub use crate::designed::{Along, At, LinearForm, RowVariances, Runnable, Running, StepOf};
#[doc(hidden)]
pub use crate::keys::{Key, Range, Type};
pub use crate::reader::{Given, Reader};
pub use crate::study::{PlantClass, Time};
pub use crate::synthesis::{Plan, Sampling};
pub use cubic::Cubic;
pub use declaration::{Context, Declaration, Information, Keys, Rule, Tuning, Value};
pub use disturbance::{DisturbanceSpec, WithDisturbance};
pub use extended_kalman::ExtendedKalman;
pub use filter::Filter;
pub use functional::Functional;
pub use high_gain::{Chains, HighGain};
pub use imm::{InteractingModels, ModeSpec};
pub use interval::IntervalSpec;
pub use kalman::Kalman;
pub use kkl_numerical::{Form, Kkl, KklSpec};
pub use lipschitz::Lipschitz;
pub use lpv::Lpv;
pub use luenberger::Luenberger;
pub use mean_value::{MeanValue, PrintedMean};
pub use mhe::MovingHorizonSpec;
pub use norm_filter::NormFilterSpec;
pub use optimal_cubic::OptimalCubic;
pub use particle::ParticleSpec;
pub use peb::{ParameterEstimation, PebObserver};
pub use reduced_order::{ReducedOrder, ReducedOrderObserver, WithFeedthrough};
pub use sampled_cubic::{SampledCubic, VaryingPeriods};
pub use settings::{KeyValue, Present, Size, Words};
#[doc(hidden)]
pub use settings::{by_key, by_keys, count, flat, of_name, value};
pub use sliding_mode::SlidingModeSpec;
pub use ukf::UnscentedSpec;
pub use unknown_input::{UnknownInput, WithoutDisturbance};

/// The kinds, in the order of the schema.
static KINDS: &[&Declaration] = &[
    &luenberger::DECLARATION,
    &kalman::DECLARATION,
    &cubic::DECLARATION,
    &optimal_cubic::DECLARATION,
    &proportional_integral::DECLARATION,
    &extended_state::DECLARATION,
    &unknown_input::DECLARATION,
    &interval::DECLARATION,
    &sliding_mode::DECLARATION,
    &functional::DECLARATION,
    &reduced_order::DECLARATION,
    &h_infinity::DECLARATION,
    &h2::DECLARATION,
    &sampled_cubic::DECLARATION,
    &lpv::DECLARATION,
    &lipschitz::DECLARATION,
    &mean_value::DECLARATION,
    &high_gain::DECLARATION,
    &extended_kalman::DECLARATION,
    &iterated_extended_kalman::DECLARATION,
    &error_state_kalman::DECLARATION,
    &ukf::DECLARATION,
    &mhe::DECLARATION,
    &particle::DECLARATION,
    &imm::DECLARATION,
    &kkl::DECLARATION,
    &pebo::DECLARATION,
    &kkl_peb::DECLARATION,
    &immersion_invariance::DECLARATION,
    &kkl_numerical::DECLARATION,
];

/// Kinds of other crates.
static REGISTERED: RwLock<Vec<&'static Declaration>> = RwLock::new(Vec::new());

/// All kinds, in the order of the schema; those of other crates are the last.
///
/// ```
/// let kinds: Vec<&str> = luenberger_study::kinds::registry().iter().map(|kind| kind.name).collect();
/// assert!(kinds.contains(&"cubic") && kinds.contains(&"kkl-peb"));
/// ```
pub fn registry() -> Vec<&'static Declaration> {
    let registered = REGISTERED.read().unwrap_or_else(PoisonError::into_inner);
    KINDS.iter().chain(registered.iter()).copied().collect()
}

/// Adds a kind of another crate: from now on studies can ask for it. False, and nothing is added, if there is a kind of
/// its name.
pub fn register(kind: &'static Declaration) -> bool {
    let mut registered = REGISTERED.write().unwrap_or_else(PoisonError::into_inner);
    let is_new = KINDS.iter().chain(registered.iter()).all(|known| known.name != kind.name);
    if is_new {
        registered.push(kind);
    }
    is_new
}

/// The kind of this name.
pub fn named(name: &str) -> Option<&'static Declaration> {
    registry().into_iter().find(|kind| kind.name == name)
}

/// What a kind does with its specification.
pub trait Kind: Specification {
    /// The design for a plant in continuous time.
    ///
    /// # Errors
    /// [`NoObserver`]: an error of the design as it is, by `?`, or a hypothesis of the kind in its words.
    fn design(&self, plan: &Plan<'_>) -> Result<Designed, NoObserver>;

    /// The design for a plant in discrete time with the period dt, of a kind for such plants.
    ///
    /// # Errors
    /// [`NoObserver`].
    fn design_in_discrete_time(&self, plan: &Plan<'_>, dt: f64) -> Result<Designed, NoObserver> {
        Err(plan.only_in_continuous_time(dt))
    }

    /// Whether it takes the differences of outputs that are angles modulo a full turn. One that does not is refused for
    /// them.
    fn wraps_angles(&self) -> bool {
        false
    }

    /// Whether it takes outputs that are measured late at their times. One that does not is refused for them.
    fn takes_delays(&self) -> bool {
        false
    }

    /// The filter that computes the covariance of its innovations along a log, of a kind that
    /// [has a likelihood](Specification::has_likelihood): by default its design.
    ///
    /// # Errors
    /// [`NoObserver`].
    fn with_covariance(&self, plan: &Plan<'_>) -> Result<Designed, NoObserver> {
        match plan.study.plant.dt {
            Some(dt) => self.design_in_discrete_time(plan, dt),
            None => self.design(plan),
        }
    }

    /// What to do where its design fails for this reason; none where any kind would advise the same.
    fn advice(&self, plan: &Plan<'_>, cause: &Cause) -> Option<Advice> {
        let _ = (plan, cause);
        None
    }

    /// The sampled design; none where it is made of the design of the study.
    ///
    /// # Errors
    /// [`NoObserver`].
    fn sampled(&self, of: &Sampling<'_>) -> Result<Option<SampledDesign>, NoObserver> {
        self.whole_gain().map_or(Ok(None), |gain| steps::of_gain(of, gain))
    }

    /// The sampled design of one whose design is that of the linearisation at the operating point of the study.
    ///
    /// # Errors
    /// [`NoObserver`].
    fn sampled_at_point(&self, of: &Sampling<'_>, point: &OperatingPoint) -> Result<Option<SampledDesign>, NoObserver> {
        self.whole_gain().map(|gain| steps::of_gain_at_point(of, gain, point)).transpose()
    }
}

/// The specification as one of this type, of a declaration.
pub fn as_kind<K: Kind>(specification: &dyn Any) -> Option<&dyn Kind> {
    specification.downcast_ref::<K>().map(|kind| kind as &dyn Kind)
}

/// What the kind of a specification does.
pub(crate) fn kind_of(specification: &ObserverKind) -> Option<&dyn Kind> {
    (named(specification.name())?.kind)(specification.any())
}

/// Whether a design of this kind takes minutes.
pub(crate) fn takes_long(specification: &ObserverKind) -> bool {
    named(specification.name()).is_some_and(|kind| kind.takes_long)
}

/// The filter whose innovations have a likelihood.
pub(crate) fn with_covariance(plan: &Plan<'_>) -> Result<Designed, NoObserver> {
    let Some(kind) = kind_of(&plan.requested.kind) else {
        return Err(NoObserver::new(format!("there is no kind {}", plan.requested.kind.name())));
    };
    for_outputs(kind, plan)?;
    kind.with_covariance(plan)
}

/// Whether outputs that are angles, if there are some, are taken modulo a full turn, and late ones at their times.
fn for_outputs(kind: &dyn Kind, plan: &Plan<'_>) -> Result<(), NoObserver> {
    let plant = &plan.study.plant;
    if !kind.wraps_angles() && plant.turns_of(&plant.outputs).is_some() {
        return Err(plan.not_for_angles());
    }
    if !kind.takes_delays() && !plant.delays.is_empty() {
        return Err(plan.not_for_delays());
    }
    Ok(())
}

/// The design of an observer.
pub(crate) fn design(plan: &Plan<'_>) -> Result<Designed, NoObserver> {
    let Some(kind) = kind_of(&plan.requested.kind) else {
        let hypothesis = format!("there is no kind {}", plan.requested.kind.name());
        return Err(NoObserver::new(hypothesis).at(plan.requested.place.line));
    };
    let time = kind.plant().time();
    let designed = for_outputs(kind, plan).and_then(|()| match plan.study.plant.dt {
        Some(dt) if !time.discrete => Err(plan.only_in_continuous_time(dt)),
        Some(dt) => kind.design_in_discrete_time(plan, dt),
        None if time.feedthrough => kind.design(plan),
        None => explain::output_of_the_state(plan.study, plan.requested).and_then(|()| kind.design(plan)),
    });
    designed.map_err(|none| {
        let own = none.cause.as_deref().and_then(|cause| kind.advice(plan, cause));
        explain::explained(plan, none, own).at(plan.requested.place.line)
    })
}
