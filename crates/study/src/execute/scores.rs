//! Scores of runs: where errors are scored, and in which units their norm is.

use luenberger_proof::wording::{shortest, significant};
use luenberger_sim::{Errors, Estimates, ScoreGrid, SimError, Trajectory};

use crate::results::{MeritsReport, NormReport, ScoringReport, StateReport};
use crate::study::{ObserverSpec, Simulation, Study};
use crate::trajectory::{self, Member, member};

/// A scale is written to so many digits: all but the rounding error of a difference of bounds.
const DIGITS: usize = 15;

/// How all observers of a comparison are scored.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Scoring {
    grid: ScoreGrid,
    scale: Option<(Vec<f64>, ScaleSource)>,
    band: f64,
    estimates: Estimates,
    /// Whether a filter is among the observers, which has two estimates at a sample.
    filters: bool,
}

impl Scoring {
    /// The scoring of these observers, and the one in the feedback loop, in a simulation.
    pub(super) fn of<'a>(
        study: &Study,
        simulation: &Simulation,
        observers: impl Iterator<Item = &'a Member<'a>>,
        members: &[Member<'_>],
    ) -> Result<Self, SimError> {
        let grid = if let Some(period) = simulation.score_period {
            ScoreGrid::Samples { period }
        } else {
            let fed = trajectory::fed(study).and_then(|name| member(members, name));
            let fed = fed.and_then(|member| member.designed.runnable.period());
            let periods: Vec<_> = observers.map(|member| member.designed.runnable.period()).chain([fed]).collect();
            ScoreGrid::common(&periods, simulation.duration)?
        };
        Ok(Self {
            grid,
            scale: scale(study, simulation),
            band: simulation.band,
            estimates: simulation.estimates,
            filters: study.observers.iter().any(|observer| observer.kind.updates(study.plant.dt)),
        })
    }

    /// The period at whose multiples errors are scored; none in continuous time.
    pub(super) fn period(&self) -> Option<f64> {
        self.grid.period()
    }

    /// The scale of the states, if there is one.
    pub(super) fn scale(&self) -> Option<&[f64]> {
        self.scale.as_ref().map(|(scale, _)| scale.as_slice())
    }

    /// The scores of an observer in a run.
    pub(super) fn merits(
        &self,
        study: &Study,
        trajectory: &Trajectory,
        observer: &ObserverSpec,
    ) -> Result<MeritsReport, SimError> {
        let errors = Errors::of_estimates(trajectory, &observer.name, self.grid, self.estimates)?;
        let states = errors.states()?;
        let functions = observer
            .kind
            .functions()
            .map(|(_, names)| names.into_iter().map(|name| format!("{name} of {}", observer.name)).collect::<Vec<_>>());
        // Functions of the state have no scale, and no norm that others could be compared with.
        let norm = match self.scale().filter(|_| functions.is_none()) {
            None => None,
            Some(scale) => {
                let norm = errors.norm(Some(scale), self.band)?;
                Some(NormReport {
                    initial: norm.initial,
                    band: self.band * norm.initial,
                    settling_first: norm.settling_first,
                    settling_last: norm.settling_last,
                    peak: norm.peak,
                    rms: norm.rmse,
                    last: norm.last,
                    steady_rms: norm.steady_rmse,
                })
            }
        };
        let plant = &study.plant;
        let names = functions.as_ref().unwrap_or(&plant.states);
        let named = states.iter().zip(names).map(|(scores, name)| StateReport {
            state: name.clone(),
            unit: plant.unit(name).filter(|_| functions.is_none()).cloned(),
            initial: scores.initial,
            rmse: scores.rmse,
            peak: scores.peak,
            overshoot: scores.overshoot,
            settling_5: scores.settling_5,
            settling_2: scores.settling_2,
            last: scores.last,
            steady_rmse: scores.steady_rmse,
        });
        Ok(MeritsReport {
            norm,
            rms_by_state: states.iter().map(|scores| scores.rmse).collect(),
            states: named.collect(),
        })
    }

    pub(super) fn report(&self, study: &Study) -> ScoringReport {
        let mut words = vec![match &study.plant.time_unit {
            Some(unit) if self.grid.period().is_some() => format!("{} {unit}.", self.grid),
            _ => format!("{}.", self.grid),
        }];
        if self.filters {
            words.push(of_filters(self.estimates).to_owned());
        }
        let percent = shortest(100.0 * self.band);
        match &self.scale {
            Some((scale, source)) => {
                let plant = &study.plant;
                let entry = |(name, x): (&String, &f64)| plant.measured(name, significant(*x, DIGITS));
                let entries: Vec<String> = plant.states.iter().zip(scale).map(entry).collect();
                // One number is said once.
                let alike = entries.iter().all(|entry| *entry == entries[0]) && entries.len() > 6;
                let list = if alike { format!("[{}, ..]", entries[0]) } else { format!("[{}]", entries.join(", ")) };
                words.push(format!("Norm |e| in units of scale = {list}{}.", source.words()));
                words.push(format!("Settling time: |e| stays within {percent} % of |e(0)|."));
            }
            None => words.push(NO_SCALE.to_owned()),
        }
        ScoringReport {
            period: self.grid.period(),
            scale: self.scale().map(<[f64]>::to_vec),
            band: self.band,
            estimates: key(self.estimates),
            words,
        }
    }
}

/// As the key `estimates` has it.
pub(super) fn key(estimates: Estimates) -> &'static str {
    match estimates {
        Estimates::Filtered => "filtered",
        Estimates::Predicted => "predicted",
    }
}

/// Which estimates of filters have the errors.
pub(super) fn of_filters(estimates: Estimates) -> &'static str {
    match estimates {
        Estimates::Filtered => "Errors of filters are those after the measurement of a sample (filtered).",
        Estimates::Predicted => "Errors of filters are those before the measurement of a sample (predicted).",
    }
}

/// How to get a norm.
const NO_SCALE: &str =
    "No norm of the error: its states have no scale; set simulation.scale, one positive number per state.";

/// Where a scale is from.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum ScaleSource {
    /// The simulation.
    Given,
    /// The region of the designs.
    Region,
    /// All states have this unit.
    CommonUnit,
}

impl ScaleSource {
    fn words(self) -> &'static str {
        match self {
            Self::Given => "",
            Self::Region => ", the widths of the design region",
            Self::CommonUnit => ", the unit of all states",
        }
    }
}

/// The scale of the states: that of the simulation; else the widths of the region of the designs, if it is finite and
/// the same for all observers that have one; else 1 for states that have one unit in common.
pub(super) fn scale(study: &Study, simulation: &Simulation) -> Option<(Vec<f64>, ScaleSource)> {
    if let Some(scale) = &simulation.scale {
        return Some((scale.clone(), ScaleSource::Given));
    }
    let mut regions = study.observers.iter().filter_map(|observer| observer.kind.region());
    if let Some(first) = regions.next() {
        let widths: Vec<f64> = first.states().iter().map(|(low, high)| high - low).collect();
        let are_alike = regions.all(|other| other.states() == first.states());
        if are_alike && widths.iter().all(|width| width.is_finite() && *width > 0.0) {
            return Some((widths, ScaleSource::Region));
        }
    }
    let plant = &study.plant;
    let unit = plant.unit(plant.states.first()?)?;
    let have_one = plant.states.iter().all(|state| plant.unit(state) == Some(unit));
    have_one.then(|| (vec![1.0; plant.states.len()], ScaleSource::CommonUnit))
}
