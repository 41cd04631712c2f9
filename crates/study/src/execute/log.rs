//! The observers on a measured log: no plant is simulated; the innovation is the figure of merit.

use luenberger_sim::replay::{Recording, Replay, ReplayedObserver};
use luenberger_sim::{Settings, SimError};
use nalgebra::DMatrix;
use rayon::prelude::*;

use super::Member;
use super::options::RunOptions;
use super::simulate::Run;
use crate::results::{InnovationOf, InnovationReport, LogReport};
use crate::study::{Log, Study};

fn replay(study: &Study, recording: &Recording, member: &Member<'_>) -> Result<ReplayedObserver, SimError> {
    let settings = Settings { rtol: 1e-9, ..study.simulation.as_ref().map_or_else(Settings::default, |s| s.settings) };
    let replay = Replay::new(&study.plant.model, recording.clone()).settings(settings);
    let name = member.wish.name.as_str();
    member.designed.runnable.replay(replay, name, &member.wish.initial).run()?.observer(name).cloned()
}

fn report(study: &Study, recording: &Recording, replayed: &ReplayedObserver) -> Result<InnovationReport, SimError> {
    let times = recording.times();
    let middle = times[times.len() / 2];
    let named = |(statistics, name): (luenberger_sim::replay::InnovationStatistics, &String)| InnovationOf {
        output: name.clone(),
        mean: statistics.mean,
        rms: statistics.rms,
        peak: statistics.peak,
        white: statistics.whiteness.map(|whiteness| whiteness.p_value),
    };
    let outputs = replayed.statistics(middle)?.into_iter().zip(&study.plant.outputs).map(named).collect();
    let last = replayed.estimate.nrows().saturating_sub(1);
    Ok(InnovationReport {
        observer: replayed.name.clone(),
        outputs,
        estimate: replayed.estimate.row(last).iter().copied().collect(),
        normalised: replayed.consistency(middle)?.map(|consistency| consistency.mean),
        interpolated: replayed.interpolated,
        failure: None,
    })
}

/// An observer with its estimates on the log, if the replay finished.
pub(super) type Outcome<'a> = (Member<'a>, Option<Run>);

pub(super) fn all<'a>(
    study: &Study,
    log: &Log,
    members: &[Member<'a>],
    options: &RunOptions<'_>,
) -> (LogReport, Vec<Outcome<'a>>) {
    let recording = &log.recording;
    let times = recording.times();
    let one = |member: &Member<'a>| {
        if options.interrupted() {
            return None;
        }
        let outcome = replay(study, recording, member).and_then(|replayed| {
            let report = report(study, recording, &replayed)?;
            Ok((report, run(recording, replayed)))
        });
        options.tell("log", &member.wish.name, 1, 1);
        let failed = |error: SimError| InnovationReport {
            observer: member.wish.name.clone(),
            outputs: Vec::new(),
            estimate: Vec::new(),
            normalised: None,
            interpolated: 0,
            failure: Some(error.to_string()),
        };
        Some(match outcome {
            Ok((report, run)) => (report, (*member, Some(run))),
            Err(error) => (failed(error), (*member, None)),
        })
    };
    let (reports, runs): (Vec<_>, Vec<_>) = members.par_iter().filter_map(one).collect::<Vec<_>>().into_iter().unzip();
    let ends = (times.first().copied().unwrap_or(0.0), times.last().copied().unwrap_or(0.0));
    (LogReport { samples: times.len(), start: ends.0, end: ends.1, rows: reports }, runs)
}

fn run(recording: &Recording, replayed: ReplayedObserver) -> Run {
    let at = |samples: &luenberger_sim::Samples| {
        let mut values = DMatrix::zeros(replayed.t.len(), samples.values().ncols());
        let mut row = vec![0.0; samples.values().ncols()];
        for (k, t) in replayed.t.iter().enumerate() {
            samples.at(*t, &mut row);
            for (j, x) in row.iter().enumerate() {
                values[(k, j)] = *x;
            }
        }
        values
    };
    let (u, y) = (at(recording.inputs()), at(recording.outputs()));
    // The true state of a log is unknown.
    let x = DMatrix::zeros(replayed.t.len(), 0);
    Run { t: replayed.t, x, u, y, estimate: Some(replayed.estimate) }
}
