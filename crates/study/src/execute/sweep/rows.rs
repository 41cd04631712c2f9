//! The rows of a sweep: each of its observers at each of its values, and the designs for a row.

use luenberger_random::{Purpose, Stream};

use super::super::options::RunOptions;
use crate::design::{Designed, attempt};
use crate::error::StudyError;
use crate::study::{ObserverSpec, Simulation, Study, Sweep, Swept};
use crate::trajectory::{self, Member, member};

/// One observer at one value.
pub(super) struct Row<'a> {
    pub(super) study: &'a Study,
    pub(super) simulation: &'a Simulation,
    pub(super) requested: ObserverSpec,
    pub(super) value: f64,
}

/// The rows in the order of observers and values.
pub(super) fn rows<'a>(study: &'a Study, simulation: &'a Simulation, sweep: &'a Sweep) -> Vec<Row<'a>> {
    let mut rows = Vec::new();
    for requested in chosen(study, sweep) {
        for (k, &value) in sweep.values.iter().enumerate() {
            // A number of the study is varied in the study itself.
            let study = sweep.variants.get(k).unwrap_or(study);
            let Some(requested) = study.observer(&requested.name) else { continue };
            let simulation = study.simulation.as_ref().unwrap_or(simulation);
            let within = (Some(simulation), study.plant.dt);
            let Some(requested) = varied(requested, within, &sweep.parameter, value) else { continue };
            rows.push(Row { study, simulation, requested, value });
        }
    }
    rows
}

pub(super) fn chosen<'a>(study: &'a Study, sweep: &Sweep) -> Vec<&'a ObserverSpec> {
    let named =
        |requested: &&ObserverSpec| sweep.observers.as_ref().is_none_or(|names| names.contains(&requested.name));
    study.observers.iter().filter(named).collect()
}

/// The specification of an observer at a value; none if it does not have the parameter.
pub(super) fn varied(
    requested: &ObserverSpec,
    (simulation, dt): (Option<&Simulation>, Option<f64>),
    parameter: &Swept,
    value: f64,
) -> Option<ObserverSpec> {
    let mut requested = requested.clone();
    match parameter {
        Swept::Gamma => requested.kind = requested.kind.with_gamma(value)?,
        Swept::Poles => requested.kind = requested.kind.faster(value, dt),
        Swept::Noise | Swept::Number(_) => {}
        Swept::Initial => {
            for (xhat, x) in requested.initial.iter_mut().zip(&simulation?.x0) {
                *xhat = x - value * (x - *xhat);
            }
        }
    }
    Some(requested)
}

/// The initial estimate of an ensemble member: member 0 uses the study's own, the others an initial error of the same
/// norm in a random direction, in units of the scale. Without a scale the unit of each state is its initial error.
pub(in crate::execute) fn initial(
    requested: &ObserverSpec,
    simulation: &Simulation,
    scale: Option<&[f64]>,
    seed: u64,
    number: u64,
) -> Vec<f64> {
    if number == 0 {
        return requested.initial.clone();
    }
    let errors: Vec<f64> = simulation.x0.iter().zip(&requested.initial).map(|(x, xhat)| x - xhat).collect();
    let unit = |i: usize| scale.map_or(errors[i].abs(), |scale| scale[i]);
    let norm = |entries: &mut dyn Iterator<Item = f64>| entries.map(|x| x * x).sum::<f64>().sqrt();
    let size = norm(&mut errors.iter().enumerate().filter(|(_, e)| **e != 0.0).map(|(i, e)| e / unit(i)));
    // Gaussian entries, so that the direction is uniformly distributed.
    let mut draws = Stream::new(seed, Purpose::FirstEstimate, 0).member(number).draws(0);
    let direction: Vec<f64> = errors.iter().map(|_| draws.normal()).collect();
    let length = norm(&mut direction.iter().copied());
    let entry = |(i, x): (usize, &f64)| x - unit(i) * size * direction[i] / length;
    simulation.x0.iter().enumerate().map(entry).collect()
}

/// The designs for a row.
pub(super) struct RowDesign {
    own: Own,
    /// The observer in the feedback loop, if it is designed for the row as well.
    fed: Option<(ObserverSpec, Designed)>,
}

enum Own {
    /// That of the study.
    Study,
    /// One for the row.
    Anew(Box<Designed>),
    /// Why there is none.
    None(String),
}

impl RowDesign {
    /// Designs what differs from the study.
    pub(super) fn of(row: &Row<'_>, parameter: &Swept, options: &RunOptions<'_>) -> Result<Self, StudyError> {
        let Row { study, requested, .. } = row;
        let mut designs = Self { own: Own::Study, fed: None };
        if !parameter.redesigns() {
            return Ok(designs);
        }
        let design = |requested: &ObserverSpec| match attempt(study, requested, options.cancel, options.until) {
            Ok(designed) => Ok(Ok(designed)),
            Err(none) if none.is_interrupted() => Err(StudyError::Interrupted),
            Err(none) => Ok(Err(none.hypothesis)),
        };
        designs.own = match design(requested)? {
            Ok(designed) => Own::Anew(Box::new(designed)),
            Err(why) => Own::None(why),
        };
        // The observer that is fed back is designed for the same study, unless it is the swept one.
        let other = trajectory::fed(study).filter(|fed| *fed != requested.name).and_then(|fed| study.observer(fed));
        if let (Swept::Number(_), Some(fed), Own::Anew(_)) = (parameter, other, &designs.own) {
            match design(fed)? {
                Ok(designed) => designs.fed = Some((fed.clone(), designed)),
                Err(why) => {
                    designs.own = Own::None(format!("the observer {:?} in the feedback loop: {why}", fed.name));
                }
            }
        }
        Ok(designs)
    }

    /// The design of the observer, or why there is none.
    pub(super) fn own<'d>(&'d self, row: &Row<'_>, members: &'d [Member<'_>]) -> Result<&'d Designed, &'d str> {
        match &self.own {
            Own::Study => member(members, &row.requested.name).map(|member| member.designed).ok_or("no design"),
            Own::Anew(designed) => Ok(designed),
            Own::None(why) => Err(why),
        }
    }

    /// The other observers of the row.
    pub(super) fn others<'d>(&'d self, members: &[Member<'d>]) -> Vec<Member<'d>> {
        match &self.fed {
            Some((requested, designed)) => vec![Member { requested, designed }],
            None => members.to_vec(),
        }
    }
}
