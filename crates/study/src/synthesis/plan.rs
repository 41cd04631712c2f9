//! What the design of an observer is given.

use std::borrow::Cow;
use std::sync::atomic::AtomicBool;

use luenberger_clock::Instant;
use luenberger_design::{CubicDesign, CubicGain, DesignError, GainOptions, LinearDesign};
use luenberger_plants::StateSpace;
use luenberger_proof::certificate::Reading;
use luenberger_proof::wording::shortest;
use nalgebra::DMatrix;

use super::explain;
use super::linear;
use super::{Designed, feedback, operating_point, other_kinds};
use crate::results::{Advice, Cause, NoObserver, Proposal};
use crate::study::{LinearSpec, ObserverSpec, PlantClass, Study};

/// The study and its observer that is designed.
#[derive(Debug, Clone, Copy)]
pub struct Plan<'a> {
    /// The study.
    pub study: &'a Study,
    /// The observer.
    pub requested: &'a ObserverSpec,
    pub(crate) cancel: &'a AtomicBool,
    pub(crate) end: Option<Instant>,
}

impl<'a> Plan<'a> {
    /// The refusal of a plant in discrete time.
    pub fn only_in_continuous_time(&self, dt: f64) -> NoObserver {
        let kind = self.requested.kind.name();
        NoObserver::new(format!("the kind {kind} is for plants in continuous time, and this one has dt = {dt}"))
            .because(Cause::DiscreteTime { dt })
            .advise(other_kinds(self.study, self.requested))
    }

    /// The refusal of a plant with angles among its outputs.
    pub(crate) fn not_for_angles(&self) -> NoObserver {
        let (kind, plant) = (self.requested.kind.name(), &self.study.plant);
        let angles: Vec<&str> =
            plant.outputs.iter().filter(|name| plant.turns.contains_key(*name)).map(String::as_str).collect();
        let are = if angles.len() == 1 { "is an angle" } else { "are angles" };
        NoObserver::new(format!(
            "{} {are}, and the kind {kind} takes the difference of a reading and its estimate as it is: a full turn would be an error",
            angles.join(", ")
        ))
        .hint("sine and cosine of the angle as outputs, which have no jump, or `angles` without it where readings go on beyond a turn")
        .advise(other_kinds(self.study, self.requested))
    }

    /// The refusal of a plant of which outputs are measured late.
    pub(crate) fn not_for_delays(&self) -> NoObserver {
        let (kind, late) = (self.requested.kind.name(), self.study.plant.late_outputs());
        NoObserver::new(format!("outputs are measured late ({late}), and the kind {kind} takes a reading for one of now"))
            .hint("extended-kalman, iterated-extended-kalman or ukf, or `measurement_delay` in [truth], of which observers do not know")
            .advise(other_kinds(self.study, self.requested))
    }

    /// That the period of the observer is that of the plant.
    ///
    /// # Errors
    /// [`Cause::OtherPeriod`].
    pub fn has_period_of_plant(&self, period: f64, dt: f64) -> Result<(), NoObserver> {
        if (period - dt).abs() <= 1e-9 * dt {
            return Ok(());
        }
        let same = Proposal::keys([format!("period = {}", shortest(dt))], &["period"], "that of the plant");
        Err(NoObserver::new(format!("period = {period}, and the plant is in discrete time with dt = {dt}"))
            .because(Cause::OtherPeriod { period, dt })
            .advise(Advice::of([same])))
    }

    /// The options of a gain by a matrix inequality.
    pub fn options(&self) -> GainOptions {
        self.requested.limits.options(self.study.solver, self.end)
    }

    /// What certificates call the plant.
    pub fn reading(&self) -> Reading<'a> {
        self.study.plant.reading()
    }

    /// The linear plant; of a kind that takes an operating point, the linearisation there.
    ///
    /// # Errors
    /// [`Cause::NotLinear`] for another plant.
    pub fn linear(&self) -> Result<&'a StateSpace, NoObserver> {
        let of_point = match self.requested.kind.plant() {
            PlantClass::AtPoint(_) if self.study.plant.dt.is_none() => self.study.operating_point.as_ref(),
            _ => None,
        };
        let plant = self.study.plant.model.linear().or(of_point.map(|point| &point.linear));
        plant.ok_or_else(|| explain::not_linear(self.study, self.requested))
    }

    /// The design, run in deviations from the operating point if the plant is the linearisation there.
    pub(crate) fn at_point(&self, designed: Designed) -> Result<Designed, NoObserver> {
        match &self.study.operating_point {
            Some(point) if self.study.plant.model.linear().is_none() => {
                operating_point::shifted(self.study, designed, point)
            }
            _ => Ok(designed),
        }
    }

    /// With what is proved of the loop in which the study feeds the estimate back, of an observer with the gain L.
    pub(crate) fn in_loop(&self, plant: &StateSpace, designed: Designed) -> Designed {
        match designed.runnable.gain_of_loop() {
            Some(l) => feedback::linear(self.study, self.requested, plant, &l, designed),
            None => designed,
        }
    }
}

/// The observer whose step for each sample is designed.
#[derive(Debug, Clone, Copy)]
pub struct Sampling<'a> {
    /// The study and its observer.
    pub plan: Plan<'a>,
    /// The sampling period.
    pub period: f64,
    /// The design of the study, if there is one already.
    pub designed: Option<&'a Designed>,
}

impl<'a> Sampling<'a> {
    /// The linear design in continuous time, that of the study if it is there.
    pub(crate) fn linear(&self, plant: &StateSpace, gain: &LinearSpec) -> Result<Cow<'a, LinearDesign>, DesignError> {
        match self.designed.and_then(Designed::linear) {
            Some(linear) => Ok(Cow::Borrowed(linear)),
            None => linear::linear_design(plant, gain, &self.plan.options()).map(Cow::Owned),
        }
    }

    /// The cubic design of this linear one, that of the study if it is there.
    pub(crate) fn cubic(
        &self,
        linear: &LinearDesign,
        (theta, correction): (&DMatrix<f64>, &CubicGain),
    ) -> Result<Cow<'a, CubicDesign>, DesignError> {
        match self.designed.and_then(Designed::cubic) {
            Some(cubic) => Ok(Cow::Borrowed(cubic)),
            None => CubicDesign::new(linear, theta, correction).map(Cow::Owned),
        }
    }

    /// The linear plant of the study.
    pub(crate) fn plant(&self) -> Option<&'a StateSpace> {
        self.plan.study.plant.model.linear()
    }
}
