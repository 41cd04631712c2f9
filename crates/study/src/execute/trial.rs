//! Single runs of designed observers with their scores, for comparisons that are no step of a study.

use luenberger_clock::Instant;
use luenberger_sim::{SimError, Trajectory};

use super::excursion;
use super::scores::Scoring;
use super::stopped::why;
use super::sweep::ensemble_initial;
use crate::design::Designed;
use crate::error::StudyError;
use crate::results::{MeritsReport, ScoringReport};
use crate::study::{ObserverSpec, Simulation, Study};
use crate::trajectory::{self, Member, Variation};

/// The plant, noise and scores that all runs have in common.
pub(crate) struct Trial<'a> {
    study: &'a Study,
    simulation: &'a Simulation,
    /// The observer in the feedback loop.
    fed: Option<Member<'a>>,
    scoring: Scoring,
    seed: u64,
}

/// A run that finished.
#[derive(Debug, Clone)]
pub(crate) struct Scored {
    pub(crate) merits: MeritsReport,
    /// Whether it left the region of the design, where that has one.
    pub(crate) left: bool,
}

impl<'a> Trial<'a> {
    /// Runs in this simulation, which has `scale` and `score_period`.
    pub(crate) fn new(
        study: &'a Study,
        simulation: &'a Simulation,
        fed: Option<(&'a ObserverSpec, &'a Designed)>,
        seed: u64,
    ) -> Result<Self, StudyError> {
        let fed = fed.map(|(requested, designed)| Member { requested, designed });
        let scoring = Scoring::of(study, simulation, std::iter::empty(), &[])?;
        Ok(Self { study, simulation, fed, scoring, seed })
    }

    /// Where and in which units errors are scored.
    pub(crate) fn scoring(&self) -> ScoringReport {
        self.scoring.report(self.study)
    }

    /// The plant without an observer to compare.
    pub(crate) fn plant(&self, until: Option<Instant>) -> Result<Trajectory, SimError> {
        let fed: Vec<Member<'_>> = self.fed.into_iter().collect();
        trajectory::run(self.study, self.simulation, &fed, None, Variation::NONE, until)
    }

    /// The first estimate of a run: that of the study in run 0; in the others of an error of the same norm in a random
    /// direction, in the opposite one if that is outside of the region, and held to the region.
    pub(crate) fn initial(&self, requested: &ObserverSpec, region: &[(f64, f64)], number: u64) -> Vec<f64> {
        let drawn = ensemble_initial(requested, self.simulation, self.scoring.scale(), self.seed, number);
        let is_inside = |x: &[f64]| x.iter().zip(region).all(|(x, (low, high))| (*low..=*high).contains(x));
        if number == 0 || is_inside(&drawn) {
            return drawn;
        }
        let opposite: Vec<f64> = self.simulation.x0.iter().zip(&drawn).map(|(x, xhat)| 2.0 * x - xhat).collect();
        if is_inside(&opposite) {
            return opposite;
        }
        drawn.iter().zip(region).map(|(x, (low, high))| x.max(*low).min(*high)).collect()
    }

    /// A run: its scores, or why it ended early. `number` selects the noise.
    pub(crate) fn run(
        &self,
        (requested, designed): (&ObserverSpec, &Designed),
        initial: Vec<f64>,
        number: u64,
        until: Option<Instant>,
    ) -> Result<Result<Scored, String>, StudyError> {
        let requested = ObserverSpec { initial, ..requested.clone() };
        let member = Member { requested: &requested, designed };
        let fed: Vec<Member<'_>> = self.fed.into_iter().collect();
        let variation = Variation { noise: 1.0, member: number };
        let outcome = trajectory::run(self.study, self.simulation, &fed, Some(&member), variation, until).and_then(
            |trajectory| {
                let merits = self.scoring.merits(self.study, &trajectory, &requested)?;
                let left = excursion::of_simulation(self.study, &requested, &trajectory)?.is_some();
                Ok(Scored { merits, left })
            },
        );
        match outcome {
            Ok(scored) => Ok(Ok(scored)),
            Err(SimError::TimeLimit { .. }) => Err(StudyError::Interrupted),
            Err(error) => Ok(Err(why(self.study, &error))),
        }
    }
}
