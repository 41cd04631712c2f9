//! The specification of an observer, of any kind: the settings that a study gives, and what follows from them alone.
//!
//! What a kind does with them (design, step on a target) is `kinds::Kind`.

use std::any::Any;
use std::fmt;
use std::sync::Arc;

use luenberger_design::{Periods, Region};
use luenberger_expression::Expression;
use nalgebra::{Complex, DMatrix};

use super::{Estimated, GainSpec, LinearSpec, Study};

/// Whether a kind takes plants that are linear only.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum PlantClass {
    /// Linear plants.
    Linear(Time),
    /// Linear plants, and the linearisation of others at the operating point of the study.
    AtPoint(Time),
    /// Nonlinear plants, linear ones among them.
    Nonlinear(Time),
}

/// The time of the plants that a kind takes, and whether their outputs may depend on the inputs.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Time {
    /// Whether a plant may be in discrete time.
    pub discrete: bool,
    /// Whether an output may depend on an input.
    pub feedthrough: bool,
}

impl Time {
    /// Continuous or discrete time, any outputs.
    pub const ANY: Self = Self { discrete: true, feedthrough: true };
    /// Continuous time, any outputs.
    pub const CONTINUOUS: Self = Self { discrete: false, feedthrough: true };
    /// Continuous time, outputs of the state alone.
    pub const OF_STATE: Self = Self { discrete: false, feedthrough: false };
}

impl fmt::Display for PlantClass {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let which = match self {
            Self::Linear(_) => "linear",
            Self::AtPoint(_) => "linear, others at an operating point",
            Self::Nonlinear(_) => "any",
        };
        let Time { discrete, feedthrough } = self.time();
        let time = if discrete { "continuous or discrete time" } else { "continuous time" };
        let outputs = if feedthrough { "" } else { ", outputs of the state alone" };
        write!(f, "{which}; {time}{outputs}")
    }
}

impl PlantClass {
    /// Time and outputs.
    pub fn time(self) -> Time {
        match self {
            Self::Linear(time) | Self::AtPoint(time) | Self::Nonlinear(time) => time,
        }
    }
}

/// A value that is compared with one of another type.
pub trait Setting: Any + fmt::Debug + Send + Sync {
    /// Whether they are of one type and equal.
    fn equals(&self, other: &dyn Any) -> bool;
}

impl<T: Any + PartialEq + fmt::Debug + Send + Sync> Setting for T {
    fn equals(&self, other: &dyn Any) -> bool {
        other.downcast_ref::<T>() == Some(self)
    }
}

/// An observer as a study specifies it.
pub trait Specification: Setting {
    /// The name of the kind in study files.
    fn name(&self) -> &'static str;

    /// The plants that the kind is for.
    fn plant(&self) -> PlantClass;

    /// Poles that it places, beside those of a gain.
    fn poles(&self) -> Option<&[Complex<f64>]> {
        None
    }

    /// Whether a gain can be given in place of one for its region.
    fn has_given_gain(&self) -> bool {
        false
    }

    /// The gain of its linear part.
    fn gain(&self) -> Option<&LinearSpec> {
        None
    }

    /// The names of the models between which it decides, of an observer that has several.
    fn modes(&self) -> Vec<String> {
        Vec::new()
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

    /// Whether it is a filter in samples, an update by each sample and a prediction, for a plant in continuous time, or
    /// in discrete time with the period `dt`.
    fn updates(&self, dt: Option<f64>) -> bool {
        let _ = dt;
        false
    }

    /// Whether its innovations on a log have a likelihood: their covariance is computed along.
    fn has_likelihood(&self, dt: Option<f64>) -> bool {
        let _ = dt;
        false
    }

    /// The keys whose numbers may be fitted to a log, where the study gives them: those that the observer is tuned by,
    /// beside noises. By default those of a linear gain, if it has one.
    fn free_keys(&self) -> &'static [&'static str] {
        if self.gain().is_some() { &["poles", "bandwidth", "decay_rate", "gain", "gamma", "radial"] } else { &[] }
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

    /// Inequalities that hold in the region of the design, each as a function of the states that is not positive there.
    fn inequalities(&self) -> &[Expression] {
        &[]
    }

    /// Whether the user bounds the states for it, in the key `region`.
    fn takes_region(&self) -> bool {
        false
    }

    /// What is said of a run outside of that region.
    fn outside_region(&self) -> &'static str {
        "Guarantee not valid outside the design region"
    }

    /// Whether bounds of its error are for an uncertain plant too.
    fn takes_uncertainty(&self) -> bool {
        false
    }

    /// Bounds of |x(0) - xhat(0)|, of an observer that states bounds of its error.
    fn first_bounds(&self) -> Option<&[f64]> {
        None
    }

    /// The same `factor` times as fast, in its poles and rates, for a plant in continuous time, or in discrete time
    /// with the period `dt`; none if it has neither.
    fn faster(&self, factor: f64, dt: Option<f64>) -> Option<ObserverKind> {
        let _ = (factor, dt);
        None
    }

    /// W and V of a filter whose V is the covariance of a sample; none of other kinds, and of noises that are not
    /// constant.
    fn noises(&self) -> Option<[&DMatrix<f64>; 2]> {
        None
    }

    /// The same for the plant with these parameters as further states, the last ones; none for a kind that does not
    /// estimate parameters.
    fn with_parameters(&self, parameters: &[Estimated]) -> Option<ObserverKind> {
        let _ = parameters;
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
            // The factorisations of the Schur complement.
            return 1e-9 * unknowns(study).powi(3);
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
            return (4.0 * NUMBER * unknowns(study).powi(2), what);
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

/// Unknowns of a matrix inequality: P and P L.
pub(crate) fn unknowns(study: &Study) -> f64 {
    let (n, p) = (study.plant.states.len() as f64, study.plant.outputs.len() as f64);
    n * (n + 1.0) / 2.0 + n * p
}

/// Bytes of a number.
pub(crate) const NUMBER: f64 = 8.0;

/// The specification of an observer, of any kind.
#[derive(Clone)]
pub struct ObserverKind(Arc<dyn Specification>);

impl<K: Specification> From<K> for ObserverKind {
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
    type Target = dyn Specification;

    fn deref(&self) -> &Self::Target {
        &*self.0
    }
}

impl ObserverKind {
    pub(crate) fn any(&self) -> &dyn Any {
        &*self.0
    }

    /// The specification, if it is of this type.
    ///
    /// ```
    /// use luenberger_study::kinds::{Luenberger, SlidingModeSpec};
    /// use luenberger_study::study::ObserverKind;
    /// let kind = ObserverKind::from(SlidingModeSpec::new(1.0, 0.01));
    /// assert_eq!(kind.of::<SlidingModeSpec>().map(|spec| spec.bound), Some(1.0));
    /// assert!(kind.of::<Luenberger>().is_none() && kind.name() == "sliding-mode");
    /// ```
    pub fn of<K: Specification>(&self) -> Option<&K> {
        let any: &dyn Any = &*self.0;
        any.downcast_ref()
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

    /// The same specification `factor` times as fast, in its poles and rates.
    #[must_use]
    pub fn faster(&self, factor: f64, dt: Option<f64>) -> Self {
        self.0.faster(factor, dt).unwrap_or_else(|| self.clone())
    }
}
