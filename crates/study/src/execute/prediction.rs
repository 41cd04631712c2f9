//! One-step predictions on the last part of a log, by which observers of every kind can be compared: what each expects
//! of a measurement before it has it.
//!
//! Of most observers that is h at the estimate, so that `y - h` is their innovation. The estimate of some has the
//! measurement of its own row (`reduced-order`), and their innovation is 0 by construction; there the model carries the
//! last estimate on to the row.
//!
//! Observers are judged on the same rows: those at which each of them predicts what was measured, and the gate of none
//! rejects a part of it. A filter that rejects much would be judged on what it predicts well, and is no candidate.

use luenberger_clock::Instant;
use luenberger_plants::Plant;
use luenberger_proof::wording::{counted, shortest};
use luenberger_sim::replay::ReplayedObserver;
use luenberger_sim::{BetweenRows, SimError, solve};
use nalgebra::{DMatrix, DVector};

use super::log::{REJECTED, replay};
use super::stopped::why;
use crate::error::StudyError;
use crate::error::log::LogError;
use crate::results::{ErrorOf, PredictionOf, PredictionReport};
use crate::study::{Log, Study};
use crate::trajectory::Member;

/// Least measurements of the part that is held out: fewer have no test of whiteness, and compare little.
pub(crate) const LEAST_HELD_OUT: usize = 20;

/// What an observer predicted at a row.
struct Row {
    /// `y - h` of each output; none of one that was not measured.
    innovation: Vec<Option<f64>>,
    /// Of the whole row, given those before it.
    log_likelihood: Option<f64>,
    is_rejected: bool,
    errors: Vec<Option<f64>>,
}

/// What an observer predicted at the rows that are held out.
pub(crate) struct Predictions {
    rows: Vec<Option<Row>>,
    /// At how many rows it left the region of its design.
    pub(crate) outside: usize,
}

/// The share that is held out, unless the study says another.
const HELD_OUT: f64 = 0.3;

/// The share of a log that is held out: what is asked for, else that of [tune], else 0.3.
pub(crate) fn share(study: &Study, own: Option<f64>) -> f64 {
    let of_tune = || study.tune.as_ref().map(|tune| tune.held_out).filter(|share| *share > 0.0);
    own.or_else(of_tune).unwrap_or(HELD_OUT)
}

/// Checks that a log has a part that can be held out; its first row.
pub(crate) fn held_out(log: &Log, share: f64) -> Result<usize, LogError> {
    if log.recording.outputs_between() == BetweenRows::Linear {
        return Err(LogError::Linear);
    }
    let first = log.fitted(share);
    let (rows, outputs) = (log.recording.times().len() - first, log.recording.outputs());
    let measured = |k: usize| (0..outputs.values().ncols()).filter(|j| outputs.value(k, *j).is_some()).count();
    let measurements = (first..first + rows).map(measured).sum();
    if measurements < LEAST_HELD_OUT {
        let (what, advice) = ("the part of the log that is held out has", "increase `held_out`, or use a longer log");
        let (of, least) = ("measurement", LEAST_HELD_OUT);
        return Err(LogError::TooShort { what, rows, measurements, of, least, advice });
    }
    Ok(first)
}

/// The estimates of an observer on a log, one row for each of its times; none if its run ended early.
pub(crate) fn estimate(
    (study, log): (&Study, &Log),
    member: &Member<'_>,
    until: Option<Instant>,
) -> Result<Option<DMatrix<f64>>, StudyError> {
    match replay(study, log, member, until, &|_, _| ()) {
        Ok(replayed) => Ok(Some(replayed.estimate)),
        Err(SimError::TimeLimit { .. }) => Err(StudyError::Interrupted),
        Err(_) => Ok(None),
    }
}

impl Predictions {
    /// Those of an observer from the row `first` on, or why its run ended early.
    pub(crate) fn of(
        (study, log): (&Study, &Log),
        member: &Member<'_>,
        first: usize,
        until: Option<Instant>,
    ) -> Result<Result<Self, String>, StudyError> {
        match replay(study, log, member, until, &|_, _| ()) {
            Ok(replayed) => Ok(Self::from_replay((study, log), member, first, &replayed)),
            Err(SimError::TimeLimit { .. }) => Err(StudyError::Interrupted),
            Err(error) => Ok(Err(why(study, &error))),
        }
    }

    fn from_replay(
        (study, log): (&Study, &Log),
        member: &Member<'_>,
        first: usize,
        replayed: &ReplayedObserver,
    ) -> Result<Self, String> {
        let by_model;
        let innovation = match &replayed.innovation {
            None => return Err("it does not estimate the whole state, and predicts no output".to_owned()),
            Some(_) if reads_measurement(member, log) => {
                by_model = predicted_by_model((study, log), replayed)?;
                &by_model
            }
            Some(innovation) => innovation,
        };
        let errors = log.truth.as_ref().map(|truth| replayed.errors(truth)).transpose();
        let errors = errors.map_err(|error| error.to_string())?;
        let count = log.recording.times().len() - first;
        let mut rows: Vec<Option<Row>> = (0..count).map(|_| None).collect();
        for k in 0..replayed.t.len() {
            let Some(row) = replayed.row[k].and_then(|row| row.checked_sub(first)) else { continue };
            rows[row] = Some(Row {
                innovation: innovation.row(k).iter().copied().collect(),
                log_likelihood: replayed.consistency.as_ref().and_then(|consistency| consistency.log_likelihood[k]),
                is_rejected: false,
                errors: errors.as_ref().map(|errors| errors.row(k).iter().copied().collect()).unwrap_or_default(),
            });
        }
        let mut rejected = 0usize;
        for (k, _) in replayed.consistency.iter().flat_map(|consistency| &consistency.rejected) {
            let Some(row) = replayed.row[*k].and_then(|row| row.checked_sub(first)) else { continue };
            if let Some(row) = &mut rows[row] {
                row.is_rejected = true;
                rejected += 1;
            }
        }
        let measured: usize = rows.iter().flatten().map(|row| row.innovation.iter().flatten().count()).sum();
        if rejected as f64 > REJECTED * measured as f64 {
            return Err(format!(
                "its gate rejects {rejected} of {} that are held out: it is overconfident, or the model is wrong",
                counted(measured, "measurement")
            ));
        }
        let outside = super::excursion::rows_outside(study, member.requested, log, replayed);
        Ok(Self { rows, outside })
    }

    /// The innovations of an output, in the order of the rows.
    pub(crate) fn innovations(&self, output: usize) -> Vec<f64> {
        self.rows.iter().flatten().filter_map(|row| row.innovation[output]).collect()
    }

    /// The errors of a state, in the order of the rows.
    pub(crate) fn errors(&self, state: usize) -> Vec<f64> {
        self.rows.iter().flatten().filter_map(|row| row.errors.get(state).copied().flatten()).collect()
    }

    /// How many measurements it predicts.
    fn count(&self) -> usize {
        self.rows.iter().flatten().map(|row| row.innovation.iter().flatten().count()).sum()
    }
}

/// Whether the estimate of an observer depends on the measurement of its own time: whether a NaN in its place leaves
/// something of it undefined.
fn reads_measurement(member: &Member<'_>, log: &Log) -> bool {
    let runs = &member.designed.runnable;
    let size = runs.dimensions();
    let mut u = vec![0.0; log.recording.inputs().values().ncols()];
    let t = log.recording.times()[0];
    log.recording.inputs().at(t, &mut u);
    let state = runs.initial(t, &member.requested.initial, &u, &vec![0.0; size.outputs]);
    let estimate = state.and_then(|state| runs.estimate(t, &state, &u, &vec![f64::NAN; size.outputs]));
    estimate.is_none_or(|estimate| estimate.iter().any(|x| x.is_nan()))
}

/// `y - h` where the model has carried the estimate of the time before on to this one.
fn predicted_by_model(
    (study, log): (&Study, &Log),
    replayed: &ReplayedObserver,
) -> Result<DMatrix<Option<f64>>, String> {
    let (plant, recording) = (&study.plant, &log.recording);
    let settings = super::log::settings(study, None);
    let (inputs, times) = (recording.inputs(), recording.times());
    let mut u = DVector::zeros(inputs.values().ncols());
    let mut found = DMatrix::from_element(replayed.t.len(), plant.outputs.len(), None);
    for k in 0..replayed.t.len() {
        let t = replayed.t[k];
        let mut x =
            DVector::from_iterator(plant.states.len(), replayed.estimate.row(k.saturating_sub(1)).iter().copied());
        if k > 0 {
            let mut from = replayed.t[k - 1];
            // The inputs are held from row to row.
            let between = times.partition_point(|row| *row <= from)..times.partition_point(|row| *row < t);
            let is_stepped = plant.dt.is_some();
            let ends = times[between].iter().copied().filter(|_| !is_stepped).chain([t]);
            for end in ends {
                inputs.at(from, u.as_mut_slice());
                if is_stepped {
                    x = plant.model.derivative(from, &x, &u);
                } else {
                    let slope = |t: f64, x: &[f64], slope: &mut [f64]| {
                        slope.copy_from_slice(plant.model.derivative(t, &DVector::from_column_slice(x), &u).as_slice());
                    };
                    let solved = solve(slope, from, end, x.as_slice(), &settings).and_then(|dense| dense.at(end));
                    x = DVector::from_vec(solved.map_err(|error| why(study, &error))?);
                }
                from = end;
            }
        }
        let Some(row) = replayed.row[k] else { continue };
        inputs.at(t, u.as_mut_slice());
        let h = plant.model.output(t, &x, &u);
        for j in 0..plant.outputs.len() {
            found[(k, j)] = recording.outputs().value(row, j).map(|y| plant.innovation(j, y, h[j]));
        }
    }
    Ok(found)
}

/// The rows, counted from the first that is held out, on which all of them are judged.
///
/// # Errors
/// [`LogError::NoCommonRows`] if there are too few.
pub(crate) fn common(log: &Log, first: usize, all: &[(&str, &Predictions)]) -> Result<Vec<usize>, LogError> {
    let outputs = log.recording.outputs();
    let is_common = |k: &usize| {
        let measured: Vec<usize> =
            (0..outputs.values().ncols()).filter(|j| outputs.value(first + k, *j).is_some()).collect();
        let predicts = |row: &Row| !row.is_rejected && measured.iter().all(|j| row.innovation[*j].is_some());
        !measured.is_empty() && all.iter().all(|(_, one)| one.rows[*k].as_ref().is_some_and(predicts))
    };
    let rows: Vec<usize> = (0..log.recording.times().len() - first).filter(is_common).collect();
    let measurements: usize = match all.first() {
        Some((_, one)) => {
            rows.iter().filter_map(|k| one.rows[*k].as_ref()).map(|row| row.innovation.iter().flatten().count()).sum()
        }
        None => return Ok(rows),
    };
    if measurements < LEAST_HELD_OUT {
        let fewest = all.iter().min_by_key(|(_, one)| one.count());
        let (observer, count) = fewest.map_or(("", 0), |(name, one)| (*name, one.count()));
        let least = LEAST_HELD_OUT;
        return Err(LogError::NoCommonRows { measurements, least, observer: observer.to_owned(), count });
    }
    Ok(rows)
}

/// How well an observer predicts on these rows; errors are in units of `scale`, if there is one.
pub(crate) fn judged(
    (study, log): (&Study, &Log),
    predictions: &Predictions,
    (first, common): (usize, &[usize]),
    scale: Option<&[f64]>,
) -> PredictionReport {
    let rows = || common.iter().filter_map(|k| Some((k, predictions.rows[*k].as_ref()?)));
    let rms = |values: &[f64]| (values.iter().map(|x| x * x).sum::<f64>() / values.len().max(1) as f64).sqrt();
    let output = |(j, name): (usize, &String)| {
        let nu: Vec<f64> = rows().filter_map(|(_, row)| row.innovation[j]).collect();
        let y: Vec<f64> = rows().filter_map(|(k, _)| log.recording.outputs().value(first + k, j)).collect();
        let mean = y.iter().sum::<f64>() / y.len().max(1) as f64;
        let about: Vec<f64> = y.iter().map(|y| study.plant.innovation(j, *y, mean)).collect();
        let (samples, deviation) = (nu.len(), rms(&about));
        (samples > 0).then(|| PredictionOf { output: name.clone(), samples, rms: rms(&nu), deviation })
    };
    let outputs: Vec<PredictionOf> = study.plant.outputs.iter().enumerate().filter_map(output).collect();
    let samples: usize = outputs.iter().map(|of| of.samples).sum();
    // An output that is constant has no deviation to compare with.
    let one =
        |of: &PredictionOf| of.samples as f64 * (of.rms / if of.deviation > 0.0 { of.deviation } else { 1.0 }).ln();
    let relative = (outputs.iter().map(one).sum::<f64>() / samples.max(1) as f64).exp();
    let likelihoods: Option<Vec<f64>> = rows().map(|(_, row)| row.log_likelihood).collect();
    let log_likelihood = likelihoods.filter(|all| !all.is_empty()).map(|all| all.iter().sum::<f64>() / samples as f64);
    let state = |(i, name): (usize, &String)| {
        let errors = predictions.errors(i);
        (!errors.is_empty()).then(|| (i, ErrorOf { state: name.clone(), samples: errors.len(), rms: rms(&errors) }))
    };
    let states: Vec<(usize, ErrorOf)> = study.plant.states.iter().enumerate().filter_map(state).collect();
    let error = match (scale, &states[..]) {
        (_, []) => None,
        (Some(scale), states) => Some(states.iter().map(|(i, of)| (of.rms / scale[*i]).powi(2)).sum::<f64>().sqrt()),
        (None, [(_, one)]) => Some(one.rms),
        (None, _) => None,
    };
    PredictionReport { relative, outputs, log_likelihood, error, states: states.into_iter().map(|of| of.1).collect() }
}

/// On which rows observers were judged, as a sentence.
pub(crate) fn rows_in_words(log: &Log, first: usize, common: &[usize]) -> String {
    let rows = log.recording.times().len() - first;
    let from = shortest(log.recording.times()[first]);
    let which = if common.len() == rows {
        "all of them".to_owned()
    } else {
        format!("{} of them, at which each observer predicts what was measured and no gate rejects it", common.len())
    };
    format!("Held out: the last {}, from t = {from}; judged on {which}.", counted(rows, "row"))
}

/// The head of the scores as CSV.
pub(crate) fn csv_head(outputs: &[String], states: &[String]) -> String {
    let outputs = outputs.iter().map(|name| format!(",rms_{name}"));
    let states = states.iter().map(|name| format!(",error_{name}"));
    "relative_innovation,log_likelihood,error".to_owned() + &outputs.chain(states).collect::<String>()
}

/// The scores as cells, empty for what is not known.
pub(crate) fn csv_cells(report: Option<&PredictionReport>, outputs: &[String], states: &[String]) -> String {
    let rms = |name: &String| report?.outputs.iter().find(|of| of.output == *name).map(|of| of.rms);
    let error = |name: &String| report?.states.iter().find(|of| of.state == *name).map(|of| of.rms);
    let first = [report.map(|of| of.relative), report.and_then(|of| of.log_likelihood), report.and_then(|of| of.error)];
    let cells = first.into_iter().chain(outputs.iter().map(rms)).chain(states.iter().map(error));
    cells.map(|x| x.map(shortest).unwrap_or_default()).collect::<Vec<_>>().join(",")
}

/// A cell of text.
pub(crate) fn quoted(text: &str) -> String {
    format!("\"{}\"", text.replace('"', "\"\""))
}
