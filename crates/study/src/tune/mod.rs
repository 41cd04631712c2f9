//! What does a filter assume? Its W, V, P(0), parameters of its plant, biases and delays of its sensors, fitted to logs
//! by the maximum likelihood of its innovations (prediction errors; Åström 1980, Ljung 1999 section 7.4). The gains of
//! an observer without a covariance are fitted by its prediction errors, or by its errors where the logs have true
//! states.
//!
//! | file | subject |
//! |---|---|
//! | `criterion` | what the fit is by: the log-likelihood of the innovations on the logs, prediction errors, errors |
//! | `coordinate`, `maximise` | what the search sees; the search |
//! | `autocovariance` | W and V of linear plants by autocovariance least squares, as a start and as a check |
//! | `information` | standard errors, and what the data do not determine |
//! | `profile` | profile likelihoods |
//! | `judge` | the observer on the part that was held out |
//! | `text` | the tuned study |
//! | `words`, `document`, `figure`, `report` | the fit in words, as tables, as figures, as data |

mod autocovariance;
mod coordinate;
mod criterion;
mod document;
mod figure;
mod information;
mod judge;
mod maximise;
mod profile;
mod report;
mod text;
mod words;

pub use report::{
    ByAutocovariances, HeldOut, Judged, JudgedOutput, JudgedState, NoInterval, Profile, TuneReport, TunedLog,
    TunedParameter,
};

use std::path::Path;
use std::sync::atomic::{AtomicUsize, Ordering};

use luenberger_random::Random;
use luenberger_wording::{rounded, setters};
use rayon::prelude::*;

use crate::error::StudyError;
use crate::error::log::LogError;
pub use crate::error::tune::TuneError;
use crate::execute::{self, LEAST_HELD_OUT, Limits, within};
use crate::study::{Format, Part, Study, Tunable, TuneCriterion, TuneSpec, Tuned};
use crate::{RunOptions, write_folder};
use coordinate::Coordinate;
use criterion::Criterion;
use information::Information;
use maximise::{Interrupted, searched};

/// Options of the fit.
#[derive(Default)]
pub struct TuneOptions<'a> {
    /// Output folder, progress, interruption and threads; its limits do not apply.
    pub run: RunOptions<'a>,
    /// Whether the tuned study is written beside the study (default false), with `force` over one that is there.
    pub write: bool,
}

impl<'a> TuneOptions<'a> {
    setters! { run: RunOptions<'a>, write: bool }
}

/// Fits what `[tune]` names, and judges the filter on what was held out. Results depend neither on the number of
/// threads nor on the run.
///
/// ```
/// use luenberger_study::tune::{TuneOptions, tune};
/// use luenberger_study::{Format, Study};
/// // A random walk, measured with noise, of which only the measurements are known.
/// let folder = std::env::temp_dir().join(format!("luenberger-tune-{}", std::process::id()));
/// std::fs::create_dir_all(&folder)?;
/// let mut random = luenberger_random::Random(1);
/// let (mut x, mut log) = (0.0, "t,y\n".to_owned());
/// for k in 0..300 {
///     let [w, v] = random.normal_pair();
///     log += &format!("{k},{}\n", x + 2.0 * v);
///     x += w;
/// }
/// std::fs::write(folder.join("log.csv"), log)?;
/// let text = "
/// [plant]
/// a = [[1]]
/// c = [[1]]
/// dt = 1
/// outputs = [\"y\"]
/// [log]
/// file = \"log.csv\"
/// [[observer]]
/// name = \"filter\"
/// kind = \"extended-kalman\"
/// initial = [0]
/// w = [0.1]
/// v = [1]
/// period = 1
/// [tune]
/// observer = \"filter\"
/// parameters = [\"w\", \"v\"]
/// profile = 0
/// ";
/// let study = Study::from_text("study.toml", text, Format::Toml, &folder)?;
/// let tuned = tune(&study, &TuneOptions::default())?;
/// // V is 4; the interval has it.
/// let [low, high] = tuned.parameters[1].interval.ok_or("an interval")?;
/// assert!(tuned.parameters[1].name == "v[y]" && low < 4.0 && 4.0 < high);
/// # std::fs::remove_dir_all(&folder)?;
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
/// # Errors
/// [`StudyError::Missing`] without a table `[tune]`; [`TuneError`] for a log without information, a likelihood without
/// a maximum, a filter that fails, and a file that exists; [`LogError::TooShort`]; errors of files.
pub fn tune(study: &Study, options: &TuneOptions<'_>) -> Result<TuneReport, StudyError> {
    let missing = || StudyError::Missing { step: "tune", needs: "a table [tune]" };
    let spec = study.tune.as_ref().ok_or_else(missing)?;
    let name = file_name(study);
    let path = study.data.path(&name);
    let path = path.strip_prefix(".").map_or_else(|_| path.clone(), Path::to_owned);
    if options.write && !options.run.force && path.exists() {
        return Err(TuneError::Exists { path }.into());
    }
    let run = RunOptions { output: None, limits: Limits::NONE, sweep: options.run.sweep.clone(), ..options.run };
    let mut report = within(&run, |run| fitted(study, spec, name, run))?;
    if let Some(output) = &options.run.output {
        let files = document::files(&mut report)?;
        report.renamed = write_folder(output.clone(), options.run.force, "tune", study, &files)?;
    }
    if options.write {
        write(&path, &report.study)?;
    }
    Ok(report)
}

fn write(path: &Path, text: &str) -> Result<(), StudyError> {
    std::fs::write(path, text).map_err(|error| StudyError::io(path, error))
}

/// The name of the tuned study, which is never that of the study.
fn file_name(study: &Study) -> String {
    let extension = if study.format == Format::Json { "json" } else { "toml" };
    let own = study.file_name();
    let names = std::iter::once(format!("tuned.{extension}")).chain((2..).map(|k| format!("tuned-{k}.{extension}")));
    names.into_iter().find(|name| *name != own).unwrap_or_default()
}

/// Least measurements that are fitted, for each parameter.
const LEAST_FITTED: usize = 5;

/// A step that is to change the log-likelihood.
const PROBE: f64 = 0.5;

/// A gain of the log-likelihood up to a bound that is no flat tail.
const GAIN: f64 = 0.5;

/// Fitted values have so many digits: far more than their standard errors.
const DIGITS: usize = 6;

fn fitted(study: &Study, spec: &TuneSpec, file: String, run: &RunOptions<'_>) -> Result<TuneReport, StudyError> {
    let no_start = |why: String| TuneError::NoStart { observer: spec.observer.clone(), why };
    let criterion = Criterion::new(study, spec, run.cancel);
    let mut criterion = criterion.ok_or_else(|| no_start("the text of the study does not have it".to_owned()))?;
    criterion.prepare().map_err(no_start)?;
    is_long_enough(&criterion)?;
    let start = criterion.start();
    let before = criterion.log_likelihood(&start).map_err(no_start)?;
    let coordinates = coordinates(spec);
    let x: Vec<f64> = start.iter().zip(&coordinates).map(|(value, of)| of.of(*value)).collect();
    let values = |x: &[f64]| -> Vec<f64> { x.iter().zip(&coordinates).map(|(x, of)| of.value(*x)).collect() };
    let evaluations = AtomicUsize::new(0);
    // Where the filter fails, the cost is high and finite: a model of the cost has no place for infinities.
    let worst = 2.0 * before.abs() + 1e6;
    let cost_of = |x: &[f64]| {
        evaluations.fetch_add(1, Ordering::Relaxed);
        criterion.log_likelihood(&values(x)).map_or(worst, |found| (-found).min(worst))
    };
    let cost = |x: &[f64]| if run.interrupted() { Err(Interrupted) } else { Ok(cost_of(x)) };
    has_information(&criterion, (&x, before), &coordinates, &cost_of)?;

    let variances = |values: &[f64]| match spec.criterion {
        TuneCriterion::Likelihood => autocovariance::variances(&criterion, values),
        _ => None,
    };
    // What the autocovariances say, where nothing of the plant is fitted that they depend on.
    let only_noises = spec.parameters.iter().all(|one| one.what.is_variance());
    let guess = variances(&start).filter(|_| only_noises && spec.starts > 1).map(|found| {
        let mut guess = x.clone();
        for one in found.iter().filter(|one| one.value > 0.0) {
            guess[one.parameter] = coordinates[one.parameter].of(one.value);
        }
        guess.iter().zip(&coordinates).map(|(x, of)| x.clamp(of.low, of.high)).collect::<Vec<f64>>()
    });
    let found = searches(&cost, (&x, guess, spec), &coordinates, run)?;
    let (mut best, mut least) = found[0].clone();
    for (x, found) in &found {
        if *found < least {
            (best, least) = (x.clone(), *found);
        }
    }
    let agreeing = found.iter().filter(|(_, other)| other - least < 0.01).count();
    has_maximum(spec, (&best, least), &coordinates, &cost_of)?;
    run.check()?;

    // The values as they are written.
    for (x, of) in best.iter_mut().zip(&coordinates) {
        *x = of.of(rounded(of.value(*x), DIGITS));
    }
    let least = cost(&best).map_err(|_| StudyError::Interrupted)?;
    let free: Vec<usize> = (0..best.len()).filter(|&i| coordinates[i].bound(best[i]).is_none()).collect();
    let inner = |part: &[f64]| {
        let mut whole = best.clone();
        free.iter().zip(part).for_each(|(i, x)| whole[*i] = *x);
        whole
    };
    let part: Vec<f64> = free.iter().map(|i| best[*i]).collect();
    let bounds: Vec<Coordinate> = free.iter().map(|i| coordinates[*i]).collect();
    let information = Information::new(&|part: &[f64]| cost_of(&inner(part)), (&part, least), &bounds);
    run.check()?;
    // Errors of states in successive rows are correlated: what their squares say of deviations is too little.
    let is_likely = spec.criterion != TuneCriterion::Errors;
    let mut deviation = vec![None; best.len()];
    free.iter().zip(&information.deviation).for_each(|(i, found)| deviation[*i] = *found);
    let mut profiles = Vec::new();
    if spec.profile > 0 && is_likely {
        let one = |&i: &usize| {
            let found = profile::profile(&cost, (&best, least), (i, spec.profile), (&coordinates, deviation[i]));
            run.tell("profile", &spec.parameters[i].name, i + 1, best.len());
            found.map(|found| Profile { name: spec.parameters[i].name.clone(), ..found })
        };
        let found = free.par_iter().map(one).collect::<Result<Vec<_>, _>>();
        profiles = found.map_err(|_| StudyError::Interrupted)?;
    }
    let tuned = values(&best);
    let parameters = (0..best.len()).map(|i| {
        let one = &spec.parameters[i];
        let own = &coordinates[i];
        let profile = profiles.iter().find(|profile| profile.name == one.name);
        let at = |sign: f64, deviation: f64| own.value(best[i] + sign * 1.959_963_984_540_054 * deviation);
        TunedParameter {
            name: one.name.clone(),
            unit: words::unit(study, &one.what),
            before: one.value,
            after: rounded(tuned[i], DIGITS),
            standard_error: deviation[i].filter(|_| is_likely).map(|deviation| own.slope(best[i]).abs() * deviation),
            interval: deviation[i].filter(|_| is_likely).map(|deviation| [at(-1.0, deviation), at(1.0, deviation)]),
            profile_interval: profile.map(|profile| profile::interval(profile, own)),
            without: match (own.bound(best[i]), deviation[i]) {
                (Some(sign), _) => Some(NoInterval::at_end(sign, own.is_given)),
                (None, None) => Some(NoInterval::Undetermined),
                (None, Some(_)) => None,
            },
        }
    });
    let parameters: Vec<TunedParameter> = parameters.collect();
    let by_autocovariances = variances(&tuned).unwrap_or_default();
    let check = by_autocovariances.iter().map(|one| ByAutocovariances {
        name: spec.parameters[one.parameter].name.clone(),
        value: one.value,
        standard_error: one.deviation,
    });
    let autocovariances: Vec<ByAutocovariances> = check.collect();
    let remarks = words::remarks(&criterion, &parameters, (&free, &bounds), (&information, found.len(), agreeing));
    let tuned: Vec<f64> = parameters.iter().map(|one| one.after).collect();
    let log = |data: &criterion::Data<'_>| TunedLog {
        file: data.name.clone(),
        fitted: data.fitted,
        held_out: data.t.len() - data.fitted,
        measurements: data.measurements(0..data.fitted),
    };
    let relative = |values: &[f64]| criterion.errors(values, false).map(|errors| criterion.relative(&errors));
    let relative = match spec.criterion {
        TuneCriterion::Likelihood => None,
        _ => Some([relative(&start).map_err(no_start)?, relative(&tuned).map_err(no_start)?]),
    };
    let held_out = (spec.held_out > 0.0)
        .then(|| HeldOut { before: judge::judged(&criterion, &start), after: judge::judged(&criterion, &tuned) });
    let warn = |held_out: &HeldOut| words::warnings(&criterion, held_out, &tuned, &file);
    let warnings = held_out.as_ref().map_or_else(Vec::new, warn);
    let mut report = TuneReport {
        title: study.title.clone(),
        plant: execute::summary(study),
        observer: spec.observer.clone(),
        kind: criterion.requested.kind.name().to_owned(),
        criterion: spec.criterion.name(),
        reference: criterion.reference(),
        logs: criterion.data.iter().map(log).collect(),
        rejected: criterion.rejected.iter().sum(),
        log_likelihood_before: before,
        log_likelihood: criterion.log_likelihood(&tuned).map_err(no_start)?,
        relative,
        starts: found.len(),
        agreeing,
        evaluations: evaluations.load(Ordering::Relaxed),
        parameters,
        autocovariances,
        remarks,
        held_out,
        warnings,
        profiles,
        file,
        study: String::new(),
        files: Vec::new(),
        renamed: Vec::new(),
    };
    let edits = criterion.edits(&tuned, true).map_err(no_start)?;
    report.study = text::tuned(study, (&criterion.editable, &edits), &report)?;
    Ok(report)
}

/// Enough measurements in both parts.
fn is_long_enough(criterion: &Criterion<'_>) -> Result<(), StudyError> {
    let count = |part: &dyn Fn(&criterion::Data<'_>) -> std::ops::Range<usize>| {
        let ranges = || criterion.data.iter().map(|data| (data, part(data)));
        let rows: usize = ranges().map(|(_, range)| range.len()).sum();
        (rows, ranges().map(|(data, range)| criterion.count_of(data, range)).sum::<usize>())
    };
    // What the gate leaves out would be enough.
    let gated = |part: &'static str, rejected: usize, measurements: usize, least: usize| {
        let (observer, is_likely) = (&criterion.spec.observer, criterion.spec.criterion != TuneCriterion::Errors);
        let error = || TuneError::Gate { observer: observer.clone(), part, rejected, measurements, least };
        (is_likely && measurements < least && measurements + rejected >= least).then(error).map_or(Ok(()), Err)
    };
    let [fitted, held_out] = criterion.rejected;
    let of = if criterion.spec.criterion == TuneCriterion::Errors { "true state" } else { "measurement" };
    let least = LEAST_FITTED * criterion.spec.parameters.len();
    let (rows, measurements) = count(&|data| 0..data.fitted);
    gated("fitted", fitted, measurements, least)?;
    if measurements < least {
        let (what, advice) = ("the part that is fitted has", "fit fewer parameters, or more of the log");
        return Err(LogError::TooShort { what, rows, measurements, of, least, advice }.into());
    }
    let (rows, measurements) = count(&|data| data.fitted..data.t.len());
    if criterion.spec.held_out > 0.0 && measurements < LEAST_HELD_OUT {
        gated("held out", held_out, measurements, LEAST_HELD_OUT)?;
        let (what, advice) = ("the part that is held out has", "increase `held_out`, or set it to 0 to fit all rows");
        return Err(LogError::TooShort { what, rows, measurements, of, least: LEAST_HELD_OUT, advice }.into());
    }
    Ok(())
}

/// The coordinates of the search.
fn coordinates(spec: &TuneSpec) -> Vec<Coordinate> {
    // The deviation of an output from its mean, where nothing better is known.
    let deviation = |j: usize| {
        let outputs = spec.logs[0].1.recording.outputs();
        let y: Vec<f64> = (0..outputs.times().len()).filter_map(|k| outputs.value(k, j)).collect();
        let mean = y.iter().sum::<f64>() / y.len().max(1) as f64;
        let square = y.iter().map(|y| (y - mean).powi(2)).sum::<f64>() / y.len().max(1) as f64;
        if square > 0.0 { square.sqrt() } else { 1.0 }
    };
    // An entry of a matrix is as large as the largest.
    let largest = |key: &String| {
        let of_key = |what: &Tunable| matches!(what, Tunable::Own(other, Part::Cell(..)) if other == key);
        let all = spec.parameters.iter().filter(|one| of_key(&one.what));
        all.fold(0.0f64, |largest, one| largest.max(one.value.abs()))
    };
    let unit = |one: &Tuned| match &one.what {
        Tunable::Bias(j) => deviation(*j),
        Tunable::Own(key, Part::Cell(..)) => largest(key),
        _ => one.value.abs(),
    };
    spec.parameters.iter().map(|one| Coordinate::new(one, unit(one))).collect()
}

/// Whether each parameter matters for the likelihood.
fn has_information(
    criterion: &Criterion<'_>,
    (x, before): (&[f64], f64),
    coordinates: &[Coordinate],
    cost: &(dyn Fn(&[f64]) -> f64 + Sync),
) -> Result<(), TuneError> {
    for (i, of) in coordinates.iter().enumerate() {
        let at = |sign: f64| {
            let mut point = x.to_vec();
            point[i] = (point[i] + sign * PROBE).clamp(of.low, of.high);
            (of.value(point[i]), cost(&point))
        };
        let ((low, down), (high, up)) = (at(-1.0), at(1.0));
        let small = 1e-9 * (1.0 + before.abs());
        if (down + before).abs() < small && (up + before).abs() < small {
            let one = &criterion.spec.parameters[i];
            return Err(TuneError::NoInformation {
                name: one.name.clone(),
                log_likelihood: before,
                value: one.value,
                low,
                high,
                because: words::constant_inputs(criterion),
            });
        }
    }
    Ok(())
}

/// Where each search ended; the first is from the values of the study, the second from the guess if there is one.
fn searches(
    cost: &(dyn Fn(&[f64]) -> Result<f64, Interrupted> + Sync),
    (x, guess, spec): (&[f64], Option<Vec<f64>>, &TuneSpec),
    coordinates: &[Coordinate],
    run: &RunOptions<'_>,
) -> Result<Vec<(Vec<f64>, f64)>, StudyError> {
    let mut random = Random(spec.seed);
    let mut starts = vec![x.to_vec()];
    starts.extend(guess);
    while starts.len() < spec.starts {
        let one = |(x, of): (&f64, &Coordinate)| (x + of.spread() * random.unit()).clamp(of.low, of.high);
        starts.push(x.iter().zip(coordinates).map(one).collect());
    }
    let done = AtomicUsize::new(0);
    let search = |start: &Vec<f64>| {
        let found = searched(cost, coordinates, start);
        let count = done.fetch_add(1, Ordering::Relaxed) + 1;
        run.tell("tune", &format!("search {count}"), count, starts.len());
        found
    };
    let found: Result<Vec<_>, _> = starts.par_iter().map(search).collect();
    found.map_err(|_| StudyError::Interrupted)
}

/// Whether the likelihood has stopped to grow where a parameter is at a bound that the study did not give.
fn has_maximum(
    spec: &TuneSpec,
    (best, least): (&[f64], f64),
    coordinates: &[Coordinate],
    cost: &(dyn Fn(&[f64]) -> f64 + Sync),
) -> Result<(), TuneError> {
    for (i, of) in coordinates.iter().enumerate().filter(|(_, of)| !of.is_given) {
        let Some(sign) = of.bound(best[i]) else { continue };
        let mut inside = best.to_vec();
        inside[i] -= sign * of.vague();
        let gain = cost(&inside) - least;
        if gain > GAIN {
            return Err(TuneError::NoMaximum {
                name: spec.parameters[i].name.clone(),
                falls: sign < 0.0,
                at: of.value(best[i]),
                gain,
                advice: if sign < 0.0 && spec.parameters[i].what.is_variance() {
                    "the model fits the log without this noise, as a simulated log without noise does; give `bounds`, or leave it out"
                } else {
                    "the model does not fit the log, or the log does not determine it; give `bounds`, or leave it out"
                },
            });
        }
    }
    Ok(())
}
