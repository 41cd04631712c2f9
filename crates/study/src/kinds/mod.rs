//! The kinds of observers that a study can ask for, one module each.
//!
//! A module has everything that is of its kind alone: the keys and their reader, the plants it is for, its design in
//! continuous and in discrete time, its step on a target, its tuning rule and its words. Everything that lists kinds
//! (schema, help, alternatives, `luenberger advise`, exports, the live page, Python, the tables of the documentation)
//! derives from the [`registry`]. A new kind is a module and a line of `KINDS`; a kind of another crate is one call of
//! [`register`].
//!
//! | file | subject |
//! |---|---|
//! | `declaration`, `plan`, `running` | what a kind declares; what its design is given; an observer that runs |
//! | `keys`, `filter`, `disturbance`, `norm_filter`, `peb` | keys and designs that kinds share |
//! | the others | a kind each, under its name in studies |

pub(crate) mod cubic;
mod declaration;
pub(crate) mod disturbance;
mod extended_kalman;
mod extended_state;
mod filter;
mod functional;
mod h2;
mod h_infinity;
mod high_gain;
mod immersion_invariance;
pub(crate) mod interval;
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
pub(crate) mod peb;
mod pebo;
mod plan;
mod proportional_integral;
mod reduced_order;
pub(crate) mod running;
mod sampled_cubic;
mod sliding_mode;
mod ukf;
mod unknown_input;

use std::any::Any;
use std::fmt;
use std::sync::{Arc, PoisonError, RwLock};

use luenberger_design::{OperatingPoint, Periods, Region};
use nalgebra::DMatrix;

use crate::deployment::SampledDesign;
use crate::design::{Advice, Designed, NoDesign};
use crate::execute::estimate;
use crate::results::FailureReport;
use crate::study::{GainSpec, LinearSpec, Study};

pub use cubic::Cubic;
pub use declaration::{Context, Declaration, Information, Keys, PlantClass, Rule, Time, Tuning, Value};
pub use disturbance::{DisturbanceSpec, WithDisturbance};
pub use extended_kalman::ExtendedKalman;
pub use functional::Functional;
pub use high_gain::{Chains, HighGain};
pub use interval::IntervalSpec;
pub use kalman::Kalman;
pub use kkl_numerical::{Kkl, KklSpec};
pub use kkl_peb::KklPeb;
pub use lipschitz::Lipschitz;
pub use lpv::Lpv;
pub use luenberger::Luenberger;
pub use mean_value::{MeanValue, PrintedMean};
pub use mhe::MovingHorizonSpec;
pub use norm_filter::NormFilterSpec;
pub use optimal_cubic::OptimalCubic;
pub use peb::PebObserver;
pub use pebo::Pebo;
pub use plan::{Plan, Sampling};
pub use reduced_order::{ReducedOrder, ReducedOrderObserver};
pub use running::{At, Runnable, Running, StepOf};
pub use sampled_cubic::{SampledCubic, VaryingPeriods};
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
    &ukf::DECLARATION,
    &mhe::DECLARATION,
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

/// A value that is compared with one of another type.
pub trait Specification: Any + fmt::Debug + Send + Sync {
    /// Whether they are of one type and equal.
    fn equals(&self, other: &dyn Any) -> bool;
}

impl<T: Any + PartialEq + fmt::Debug + Send + Sync> Specification for T {
    fn equals(&self, other: &dyn Any) -> bool {
        other.downcast_ref::<T>() == Some(self)
    }
}

/// An observer as a study specifies it: the settings of its kind, and what follows from them.
pub trait Kind: Specification {
    /// What the kind declares.
    fn declaration(&self) -> &'static Declaration;

    /// The design for a plant in continuous time.
    ///
    /// # Errors
    /// [`NoDesign`].
    fn design(&self, plan: &Plan<'_>) -> Result<Designed, NoDesign>;

    /// The design for a plant in discrete time with the period dt, of a kind for such plants.
    ///
    /// # Errors
    /// [`NoDesign`].
    fn design_in_discrete_time(&self, plan: &Plan<'_>, dt: f64) -> Result<Designed, NoDesign> {
        Err(plan.only_in_continuous_time(dt))
    }

    /// The sampled design, where it is not made of the design of the study.
    fn sampled(&self, of: &Sampling<'_>) -> Option<Result<SampledDesign, FailureReport>> {
        let _ = of;
        None
    }

    /// The sampled design of one whose design is that of the linearisation at the operating point of the study.
    fn sampled_at_point(
        &self,
        of: &Sampling<'_>,
        point: &OperatingPoint,
    ) -> Option<Result<SampledDesign, FailureReport>> {
        let _ = (of, point);
        None
    }

    /// The gain of its linear part.
    fn gain(&self) -> Option<&LinearSpec> {
        None
    }

    /// The gain of an observer that is determined by it alone: two such observers with the same gain are one.
    fn whole_gain(&self) -> Option<&LinearSpec> {
        None
    }

    /// The decay rate that it asks for.
    fn decay_rate(&self) -> Option<f64> {
        match self.gain()?.gain {
            GainSpec::DecayRate(rate) => Some(rate),
            _ => None,
        }
    }

    /// Other ways to a gain that the kind has.
    fn other_gains(&self, study: &Study) -> Advice {
        self.gain().map_or_else(Advice::default, |gain| crate::design::other_gains(study, gain))
    }

    /// Whether the design solves a matrix inequality.
    fn poses_inequality(&self) -> bool {
        self.gain().is_some_and(|linear| matches!(linear.gain, GainSpec::DecayRate(_) | GainSpec::Lmi))
    }

    /// The sampling period; none in continuous time.
    fn period(&self) -> Option<f64> {
        None
    }

    /// The periods for which convergence is proved, of an observer at varying periods.
    fn varying_periods(&self) -> Option<&Periods> {
        None
    }

    /// The Runge-Kutta steps per period that a study asks of the exported step.
    fn substeps(&self) -> Option<usize> {
        None
    }

    /// Whether it is a filter in samples: an update by each sample, and a prediction.
    fn updates(&self) -> bool {
        false
    }

    /// Whether estimates on a log are smoothed.
    fn smooths(&self) -> bool {
        false
    }

    /// The names of the disturbances that are estimated with the state, and of their derivatives: `d1`, `d1_rate`,
    /// `d1_rate2`.
    fn estimated_disturbances(&self) -> Vec<String> {
        Vec::new()
    }

    /// E, n x q, of an unknown disturbance.
    fn unknown_disturbance(&self) -> Option<&DMatrix<f64>> {
        None
    }

    /// K of the functions `z = K x` that are estimated in place of the state, and their names `z1`, `z2`, ..
    fn functions(&self) -> Option<(&DMatrix<f64>, Vec<String>)> {
        None
    }

    /// The region of the design; with no finite bound it is that of all states.
    fn region_of_design(&self) -> Option<Region> {
        None
    }

    /// Whether the user bounds the states for it, in the key `region`.
    fn takes_region(&self) -> bool {
        false
    }

    /// What is said of a run outside of that region.
    fn outside_region(&self) -> &'static str {
        "Guarantee not valid outside the design region"
    }

    /// Bounds of |x(0) - xhat(0)|, of an observer that states bounds of its error.
    fn first_bounds(&self) -> Option<&[f64]> {
        None
    }

    /// The same with poles and rates scaled by `factor`; none if it has neither.
    fn faster(&self, factor: f64) -> Option<ObserverKind> {
        let _ = factor;
        None
    }

    /// The same with a cubic term of strength `gamma`; none for kinds without one.
    fn with_gamma(&self, gamma: f64) -> Option<ObserverKind> {
        let _ = gamma;
        None
    }

    /// Seconds of a design for this plant on one thread, to an order of magnitude.
    fn seconds(&self, study: &Study) -> f64 {
        let n = study.plant.states.len() as f64;
        if self.poses_inequality() {
            return estimate::seconds_of_inequality(study);
        }
        if self.gain().is_some_and(|linear| matches!(linear.gain, GainSpec::Poles(_))) {
            return 1e-6 * n * n * n;
        }
        2e-7 * n * n * n
    }

    /// Bytes of a design, and what takes them.
    fn memory(&self, study: &Study) -> (f64, &'static str) {
        if self.poses_inequality() {
            let what = "the matrix inequality of an observer (for a linear plant, use poles or kalman)";
            return (estimate::memory_of_inequality(study), what);
        }
        (0.0, "")
    }

    /// Seconds of its own steps in a run of this duration, beside those of the plant.
    fn seconds_of_steps(&self, duration: f64) -> f64 {
        let _ = duration;
        0.0
    }

    /// Whether fewer operations than counted may do for a step.
    fn has_shorter_steps(&self) -> bool {
        false
    }

    /// What an export says of its design beside the certificate, which is there or not.
    fn remark_of_export(&self, study: &Study, is_certified: bool) -> Option<String> {
        let _ = (study, is_certified);
        None
    }
}

/// The specification of an observer, of any kind.
#[derive(Clone)]
pub struct ObserverKind(Arc<dyn Kind>);

impl<K: Kind> From<K> for ObserverKind {
    fn from(kind: K) -> Self {
        Self(Arc::new(kind))
    }
}

impl fmt::Debug for ObserverKind {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.0.fmt(f)
    }
}

impl PartialEq for ObserverKind {
    fn eq(&self, other: &Self) -> bool {
        let other: &dyn Any = &*other.0;
        self.0.equals(other)
    }
}

impl std::ops::Deref for ObserverKind {
    type Target = dyn Kind;

    fn deref(&self) -> &Self::Target {
        &*self.0
    }
}

impl ObserverKind {
    /// The specification, if it is of this type.
    ///
    /// ```
    /// use luenberger_study::kinds::{Luenberger, ObserverKind, SlidingModeSpec};
    /// let kind = ObserverKind::from(SlidingModeSpec::new(1.0, 0.01));
    /// assert_eq!(kind.of::<SlidingModeSpec>().map(|spec| spec.bound), Some(1.0));
    /// assert!(kind.of::<Luenberger>().is_none() && kind.name() == "sliding-mode");
    /// ```
    pub fn of<K: Kind>(&self) -> Option<&K> {
        let any: &dyn Any = &*self.0;
        any.downcast_ref()
    }

    /// The name of the kind in study files.
    pub fn name(&self) -> &'static str {
        self.declaration().name
    }

    /// The period of an observer with equidistant samples, between which a simulation holds its estimate; none at
    /// varying periods, where the observer predicts.
    pub fn fixed_period(&self) -> Option<f64> {
        if self.varying_periods().is_some() { None } else { self.period() }
    }

    /// The region of the design, if it is bounded somewhere.
    pub fn region(&self) -> Option<Region> {
        let region = self.region_of_design()?;
        let bounded = |bounds: &(f64, f64)| bounds.0.is_finite() || bounds.1.is_finite();
        let (inputs, time) = (region.input_bounds().unwrap_or_default(), region.time_bounds());
        let bounded = region.states().iter().chain(inputs).chain([&time]).any(bounded);
        bounded.then_some(region)
    }

    /// The same specification with poles and rates scaled by `factor`.
    #[must_use]
    pub fn faster(&self, factor: f64) -> Self {
        self.0.faster(factor).unwrap_or_else(|| self.clone())
    }
}
