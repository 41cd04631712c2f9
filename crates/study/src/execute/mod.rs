//! The steps of a study: observability, designs, simulations, sweep, and the output folder.

pub(crate) mod estimate;
mod excursion;
pub(crate) mod filter;
mod folder;
mod frequency;
pub(crate) mod live;
mod log;
mod observe;
mod options;
mod pareto;
pub(crate) mod pictures;
pub(crate) mod prediction;
mod rows;
mod sampling;
mod scores;
mod simulate;
mod stationary;
mod stopped;
pub(crate) mod sweep;
mod threads;
mod time_limit;
mod trial;
mod warn;

pub use crate::digest::FileDigest;
pub use crate::error::log::LogError;
pub use crate::error::sweep::{Fault, SweepError};
pub use crate::limits::{Excess, Limits, about, bytes, duration};
pub use estimate::{Estimate, MemoryEstimate, estimate, estimate_roughly};
pub use folder::{MemoryFolder, Output};
pub(crate) use log::{replay_of, settings as replay_settings, with_variances};
pub use options::{Progress, RunOptions, RunsAsCsv, Step, SweepOptions};
pub(crate) use prediction::LEAST_HELD_OUT;
pub(crate) use trial::{Scored, Trial};

pub use sweep::{BLOCKS, BlockSettings, Computed, Plan, Shard, SharedSweep, SweepStatus, reduce_sweep, sweep_status};

use luenberger_figures::Figure;
use luenberger_plants::StateSpace;
use luenberger_proof::certificate::Theorem;

use crate::design::{Designed, design_with_alternatives};
use crate::error::StudyError;
use crate::kinds;
use crate::model::Model;
use crate::read::file_name;
use crate::results::{
    ModelReport, NamedMatrix, NoObserver, ObserverReport, ObserverRun, ParameterReport, PlantSummary, Results, report,
};
use crate::study::{ObserverSpec, Study};
use crate::synthesis::matrix;
use crate::trajectory::{self, Member, Variation};
use folder::Folder;
use rows::Run;

/// Executes one step of a study, with what it needs of the steps before it, or all steps ([`Step::Run`]).
///
/// With [`RunOptions::output`] results are written to a folder, on the disk or in memory, in place of those of an
/// earlier run; an interruption leaves what is finished, another error leaves the folder as it was. The same study
/// gives identical bytes.
///
/// ```
/// use luenberger_study::{Format, RunOptions, Step, Study, execute, template};
/// let template = template::template("double-integrator")?;
/// let study = Study::from_text("study.toml", template.text, Format::Toml, ".".as_ref())?;
/// let results = execute(&study, Step::Design, &RunOptions::default())?;
/// assert!(results.failures().is_empty());
/// let cubic = results.observers[1].design.as_ref().ok_or("a design")?;
/// assert!(cubic.verdict.is_proved());
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
/// # Errors
/// [`StudyError::Missing`] if the study has no table for the step, [`StudyError::TooExpensive`] if its memory exceeds
/// the limit, [`StudyError::Interrupted`] and [`StudyError::TimeLimit`] if it was stopped, [`StudyError::Io`] and
/// similar for files that cannot be written. An observer that is not applicable, or a simulation that diverges, is not
/// an error: see [`Results::failures`].
pub fn execute(study: &Study, step: Step, options: &RunOptions<'_>) -> Result<Results, StudyError> {
    match execute_in_part(study, step, options)? {
        (results, None) => Ok(results),
        (_, Some(stopped)) => Err(stopped),
    }
}

/// As [`execute()`], with what was finished before an interruption or the time limit beside that error.
///
/// # Errors
/// As [`execute()`] but for [`StudyError::Interrupted`] and [`StudyError::TimeLimit`].
pub fn execute_in_part(
    study: &Study,
    step: Step,
    options: &RunOptions<'_>,
) -> Result<(Results, Option<StudyError>), StudyError> {
    check(study, step)?;
    estimate::memory(study, step, options.thread_count()).within(&options.limits)?;
    let folder = Folder::open(options.output.clone(), options.force)?;
    let mut results = Results {
        title: study.title.clone(),
        about: study.about.clone(),
        plant: summary(study),
        operating_point: study.operating_point.as_ref().map(observe::operating_point).transpose()?,
        observability: None,
        observers: Vec::new(),
        frequency: None,
        simulation: None,
        filters: Vec::new(),
        models: Vec::new(),
        coverage: Vec::new(),
        intervals: Vec::new(),
        log: None,
        sweep: None,
        sweep_on_log: None,
        warnings: Vec::new(),
        files: Vec::new(),
        renamed: Vec::new(),
        notes: Vec::new(),
        runs: Vec::new(),
    };
    let blocks = sweep::blocks(study, step, options, &folder)?;
    let executed = within(options, |options| stages(study, step, options, (&folder, blocks.as_ref()), &mut results));
    let stopped = match executed {
        Ok(()) => None,
        Err(error @ (StudyError::Interrupted | StudyError::TimeLimit { .. })) => Some(error),
        Err(error) => return Err(error),
    };
    if stopped.is_some() {
        save(&folder, &mut results)?;
    }
    results.renamed = folder.finish(step.name(), (&study.file_name(), study.source.text()))?;
    Ok((results, stopped))
}

/// The work within the time limit of the options, on their number of threads.
pub(crate) fn within<T: Send>(
    options: &RunOptions<'_>,
    work: impl FnOnce(&RunOptions<'_>) -> Result<T, StudyError> + Send,
) -> Result<T, StudyError> {
    time_limit::timed(options, |options| threads::on(options.threads, || work(options)))
}

/// The observers that have a design.
fn members<'a>(study: &'a Study, designs: &'a [Option<Outcome>]) -> Vec<Member<'a>> {
    let designed = |outcome: &'a Option<Outcome>| outcome.as_ref()?.designed.as_ref().ok();
    let both = study.observers.iter().zip(designs);
    both.filter_map(|(requested, outcome)| Some(Member { requested, designed: designed(outcome)? })).collect()
}

/// Writes files into a folder, in place of those that an earlier run of any command wrote there; `study` is recorded in
/// the manifest, with the name of the command. Returns which other files had to be renamed.
///
/// # Errors
/// [`StudyError`] for a folder with other files unless `force`, one that another run has locked, and for what cannot be
/// written.
pub fn write_folder(
    output: impl Into<Output>,
    force: bool,
    command: &str,
    study: &Study,
    files: &[(String, Vec<u8>)],
) -> Result<Vec<(String, String)>, StudyError> {
    let folder = Folder::open(Some(output.into()), force)?;
    for (name, bytes) in files {
        folder.write(name, bytes)?;
    }
    folder.finish(command, (&study.file_name(), study.source.text()))
}

/// The run of a designed observer in the simulation of a study, at the rows that [`execute()`] has. The study may be
/// another one than that of the design, of the same plant and observer.
///
/// # Errors
/// [`StudyError::Missing`] without a simulation, [`StudyError::Sim`] for a run that ends early.
pub fn simulate_designed(
    study: &Study,
    observer: &ObserverSpec,
    designed: &Designed,
    until: Option<luenberger_clock::Instant>,
) -> Result<ObserverRun, StudyError> {
    let missing = || StudyError::Missing { step: "simulate", needs: "a [simulation]" };
    let simulation = study.simulation.as_ref().ok_or_else(missing)?;
    let member = Member { requested: observer, designed };
    let trajectory = trajectory::run(study, simulation, &[member], Some(&member), Variation::NONE, until)?;
    let mut run = simulate::samples(simulation, &trajectory, Some(&member));
    run.warnings
        .extend(excursion::of_simulation(study, observer, &trajectory)?.map(|left| left.in_run(&observer.name)));
    Ok(run.named(&observer.name, false))
}

/// A designed observer on the log of a study, which may be another one than that of the design, with what the report
/// of [`execute()`] warns of.
///
/// # Errors
/// As [`simulate_designed`].
pub fn replay_designed(
    study: &Study,
    observer: &ObserverSpec,
    designed: &Designed,
    until: Option<luenberger_clock::Instant>,
) -> Result<ObserverRun, StudyError> {
    let log = study.log.as_ref().ok_or(StudyError::Missing { step: "simulate", needs: "a [log]" })?;
    Ok(log::replay_one(study, log, &Member { requested: observer, designed }, until)?.named(&observer.name, true))
}

/// All steps of a study: [`execute()`] with [`Step::Run`].
///
/// # Errors
/// As [`execute()`].
pub fn run(study: &Study, options: &RunOptions<'_>) -> Result<Results, StudyError> {
    execute(study, Step::Run, options)
}

/// Checks that the study has the tables the step needs.
fn check(study: &Study, step: Step) -> Result<(), StudyError> {
    let missing = |needs| Err(StudyError::Missing { step: step.name(), needs });
    let data = study.simulation.is_some() || study.log.is_some();
    match step {
        Step::Observe | Step::Run => Ok(()),
        _ if study.observers.is_empty() => missing("an [[observer]]"),
        Step::Simulate | Step::Compare if !data => missing("a [simulation] or a [log]"),
        Step::Sweep if study.sweep.is_none() => missing("a [sweep]"),
        _ => Ok(()),
    }
}

fn stages(
    study: &Study,
    step: Step,
    options: &RunOptions<'_>,
    (folder, blocks): (&Folder, Option<&sweep::Blocks>),
    results: &mut Results,
) -> Result<(), StudyError> {
    let all = step == Step::Run;
    // A nonlinear plant is linearized along its trajectory, which depends on the observers under feedback.
    let designs = if step == Step::Observe && trajectory::fed(study).is_none() {
        Vec::new()
    } else {
        designs(study, options, folder, all || step == Step::Certify)?
    };
    let described =
        |(requested, outcome): (&ObserverSpec, &Option<Outcome>)| Some(described(study, requested, outcome.as_ref()?));
    let observers = study.observers.iter().zip(&designs).filter_map(described).collect();
    if options.interrupted() {
        results.observers = observers;
        let open = study.observers.iter().zip(&designs).filter(|(_, outcome)| outcome.is_none());
        results.warnings.extend(unfinished("design", open.map(|(requested, _)| requested.name.as_str())));
        return Err(StudyError::Interrupted);
    }
    let members = members(study, &designs);
    if all || step == Step::Observe {
        options.check()?;
        results.observability = Some(observe::observability(study, &members, options, &mut results.warnings)?);
        options.tell("observe", "observability", 1, 1);
        save(folder, results)?;
    }
    if step == Step::Observe {
        return Ok(());
    }
    results.observers = observers;
    results.warnings.extend(warn::of_designs(study, results));
    results.warnings.extend(designs.iter().flatten().filter_map(|outcome| outcome.open.clone()));
    let mut figures: Vec<(String, Figure)> = Vec::new();
    if let (Some(spec), true) = (&study.frequency, all || step == Step::Design) {
        options.check()?;
        let found = frequency::responses(study, spec, &members);
        for (name, table) in &found.tables {
            folder.table(name, table)?;
        }
        results.warnings.extend(found.warnings);
        results.frequency = Some(found.report);
        figures.extend(found.figures);
    }
    save(folder, results)?;

    if let (Some(simulation), true) = (&study.simulation, all || matches!(step, Step::Simulate | Step::Compare)) {
        options.check()?;
        let failed = std::sync::Mutex::new(None);
        let finished = |member: &Member<'_>, run: &Run| {
            let name = format!("trajectories/{}", file_name(&member.requested.name));
            let samples = format!("trajectories/samples-{}", file_name(&member.requested.name));
            let samples = || pictures::samples_table(run).map_or(Ok(()), |table| folder.table(&samples, &table));
            if let Err(error) = folder.table(&name, &pictures::table(study, run)).and_then(|()| samples()) {
                failed.lock().unwrap_or_else(std::sync::PoisonError::into_inner).get_or_insert(error);
            }
        };
        let simulated = simulate::simulate_all(study, simulation, &members, options, &finished)?;
        results.simulation = Some(simulated.report);
        results.filters = simulated.filters;
        results.intervals = simulated.intervals;
        if let Some(error) = failed.into_inner().unwrap_or_else(std::sync::PoisonError::into_inner) {
            return Err(error);
        }
        let of: Vec<_> = simulated.runs.iter().filter_map(|(member, run)| Some((member, run.as_ref()?))).collect();
        results.coverage = filter::coverage(study, &of, false);
        results.models = of.iter().flat_map(|(member, run)| models(member, run)).collect();
        results.warnings.extend(simulated.warnings);
        let reached: Vec<&str> = simulated.runs.iter().map(|(member, _)| member.requested.name.as_str()).collect();
        results.warnings.extend(unfinished("simulation", names(&members, &reached)));
        save(folder, results)?;
        options.check()?;
        let mut alone = None;
        // The plant is drawn from the run with the most rows.
        let densest = of.iter().rev().max_by_key(|(_, run)| run.t.len());
        let first = match densest {
            Some((_, run)) => Some(*run),
            // No observer run finished: the plant alone, if it can be simulated.
            None if trajectory::fed(study).is_none() => {
                match trajectory::run(study, simulation, &[], None, Variation::NONE, options.until) {
                    Ok(trajectory) => {
                        let run = alone.insert(simulate::samples(simulation, &trajectory, None));
                        folder.table("trajectories/plant", &pictures::table(study, run))?;
                        Some(&*run)
                    }
                    // With observers, each of their rows says how far it came.
                    Err(error) if error.ends_run() && !members.is_empty() => {
                        results.warnings.push(format!("The plant alone: {}", stopped::why(study, &error)));
                        None
                    }
                    Err(error) => return Err(error.into()),
                }
            }
            None => None,
        };
        if let Some(first) = first {
            figures.extend(pictures::figures(&pictures::Runs { study, first, of, measured: false }));
            figures.extend(results.simulation.as_ref().and_then(|report| pareto::simulation(study, report)));
        }
        results.runs.extend(alone.map(|run| run.named("", false)));
        results.runs.extend(simulate::named(simulated.runs, false));
    }
    if let (Some(log), true) = (&study.log, all || matches!(step, Step::Simulate | Step::Compare)) {
        options.check()?;
        let (report, outcomes, warnings) = log::replay_all(study, log, &members, options);
        results.warnings.extend(warnings);
        let reached: Vec<&str> = outcomes.iter().map(|(member, _)| member.requested.name.as_str()).collect();
        results.warnings.extend(unfinished("run on the log", names(&members, &reached)));
        results.log = Some(report);
        let of: Vec<_> = outcomes.iter().filter_map(|(member, run)| Some((member, run.as_ref()?))).collect();
        results.coverage.extend(filter::coverage(study, &of, true));
        results.warnings.extend(excursion::warnings(study, &of));
        for (member, run) in &of {
            let name = format!("trajectories/log-{}", file_name(&member.requested.name));
            folder.table(&name, &pictures::table(study, run))?;
        }
        save(folder, results)?;
        if let Some((_, first)) = of.first() {
            let drawn = pictures::figures(&pictures::Runs { study, first, of: of.clone(), measured: true });
            let own = |(id, figure): (String, Figure)| (format!("log-{id}"), figure);
            figures.extend(drawn.into_iter().map(own));
        }
        results.runs.extend(simulate::named(outcomes, true));
    }
    if let (Some(sweep), Some(simulation), Some(blocks)) = (&study.sweep, &study.simulation, blocks) {
        options.check()?;
        let sweep::Outcome { report, warnings, notes } =
            sweep::sweep_all(study, (simulation, sweep), &members, blocks, (folder, options))?;
        results.warnings.extend(warnings);
        results.notes = notes;
        figures.extend(pictures::sweep(study, &report).into_iter().chain(pareto::sweep(study, &report)));
        results.sweep = Some(report);
        save(folder, results)?;
    }
    if let (Some(sweep), Some(log), true) =
        (study.sweep.as_ref().filter(|sweep| sweep.on_log), &study.log, all || step == Step::Sweep)
    {
        options.check()?;
        let (report, open) = sweep::on_log::sweep(study, (log, sweep), options)?;
        folder.write("sweep.csv", sweep::on_log::table(study, &report).as_bytes())?;
        results.warnings.extend(open);
        figures.extend(pictures::sweep_on_log(study, &report));
        results.sweep_on_log = Some(report);
        save(folder, results)?;
    }
    if folder.is_wanted() {
        for (count, (id, figure)) in figures.iter().enumerate().filter(|_| options.figures) {
            options.check()?;
            folder.figure(id, figure)?;
            options.tell("figures", id, count + 1, figures.len());
        }
        if all {
            let live = live::experiment(study, &members);
            let page = report::html(study, results, figures, live.as_ref(), &folder.written())?;
            folder.write("report.html", page.as_bytes())?;
        }
        save(folder, results)?;
    }
    options.check()
}

/// How probable the models of a filter were over a run.
fn models(member: &Member<'_>, run: &Run) -> Vec<ModelReport> {
    let Some((names, found)) = &run.modes else { return Vec::new() };
    let rows: Vec<_> = found.row_iter().filter(|row| row.iter().all(|mu| mu.is_finite())).collect();
    let report = |(j, name): (usize, &String)| ModelReport {
        observer: member.requested.name.clone(),
        model: name.clone(),
        mean: rows.iter().map(|row| row[j]).sum::<f64>() / rows.len() as f64,
        most_probable: rows.iter().filter(|row| row.transpose().imax() == j).count() as f64 / rows.len() as f64,
        last: rows.last().map_or(f64::NAN, |row| row[j]),
    };
    if rows.is_empty() { Vec::new() } else { names.iter().enumerate().map(report).collect() }
}

/// The observers that are not among those of these names.
fn names<'a>(members: &'a [Member<'_>], but: &'a [&str]) -> impl Iterator<Item = &'a str> {
    members.iter().map(|member| member.requested.name.as_str()).filter(|name| !but.contains(name))
}

/// What an interruption or the time limit has left undone of a stage.
fn unfinished<'a>(stage: &str, names: impl Iterator<Item = &'a str>) -> Option<String> {
    let names: Vec<&str> = names.collect();
    (!names.is_empty()).then(|| format!("Not finished: {stage} of {}", names.join(", ")))
}

/// Writes the results so far.
fn save(folder: &Folder, results: &mut Results) -> Result<(), StudyError> {
    results.files = folder.written().into_iter().filter(|name| name != "study.json").collect();
    if folder.is_wanted() { folder.write("study.json", results.to_json()?.as_bytes()) } else { Ok(()) }
}

/// Result of the design of an observer.
struct Outcome {
    designed: Result<Designed, NoObserver>,
    /// Why its proof cannot be written as a file.
    open: Option<String>,
}

/// The designs, in parallel, in the order of the observers. If `certified`, each certificate is written to
/// `certificates/NAME.json` as soon as it exists. Designs not finished before an interruption are `None`.
fn designs(
    study: &Study,
    options: &RunOptions<'_>,
    folder: &Folder,
    certified: bool,
) -> Result<Vec<Option<Outcome>>, StudyError> {
    use rayon::prelude::*;
    let done = std::sync::atomic::AtomicUsize::new(0);
    let total = study.observers.len();
    let one = |requested: &ObserverSpec| -> Result<Option<Outcome>, StudyError> {
        if options.interrupted() {
            return Ok(None);
        }
        let until = (options.cancel, options.until);
        let designed = match design_with_alternatives(study, requested, until, options.limits.alternatives) {
            Err(none) if none.is_interrupted() => return Ok(None),
            designed => designed,
        };
        let open = match &designed {
            Ok(designed) if certified => certificate(folder, &requested.name, designed)?,
            _ => None,
        };
        let count = done.fetch_add(1, std::sync::atomic::Ordering::Relaxed) + 1;
        options.tell("design", &requested.name, count, total);
        Ok(Some(Outcome { designed, open }))
    };
    // Long designs are started last, so that an interruption keeps the others.
    let takes_long = |requested: &ObserverSpec| kinds::takes_long(&requested.kind);
    let mut outcomes: Vec<Option<Outcome>> = study.observers.iter().map(|_| None).collect();
    for long in [false, true] {
        let parts = study.observers.par_iter().enumerate().filter(|(_, requested)| takes_long(requested) == long);
        let part = parts.map(|(i, requested)| Ok((i, one(requested)?))).collect::<Result<Vec<_>, StudyError>>()?;
        for (i, outcome) in part {
            outcomes[i] = outcome;
        }
    }
    Ok(outcomes)
}

fn described(study: &Study, requested: &ObserverSpec, outcome: &Outcome) -> ObserverReport {
    let (design, failure) = match &outcome.designed {
        Ok(designed) => (Some(designed.report.clone()), None),
        Err(failure) => (None, Some(failure.clone())),
    };
    let solver = requested.kind.poses_inequality().then(|| study.solver.name());
    ObserverReport { name: requested.name.clone(), kind: requested.kind.name().to_owned(), solver, design, failure }
}

/// The certificate of an observer as a file, if it has one, or why its proof cannot be written.
fn certificate(folder: &Folder, name: &str, designed: &Designed) -> Result<Option<String>, StudyError> {
    match designed.certificate.as_ref().map(|certificate| certificate.file(name)) {
        Some(Ok(file)) => {
            folder.write(&format!("certificates/{}.json", file_name(name)), file.to_json().as_bytes())?;
            bounds(folder, name, designed)?;
            closed_loop(folder, name, designed).map(|()| None)
        }
        Some(Err(error)) => Ok(Some(format!("{name} has no certificate file: {error}"))),
        None => Ok(None),
    }
}

/// The bound of the error under disturbances, if it is proved, in a file of its own.
fn bounds(folder: &Folder, name: &str, designed: &Designed) -> Result<(), StudyError> {
    let theorems = designed.certificate.iter().flat_map(luenberger_design::Certificate::theorems);
    for proved in theorems.filter(|proved| matches!(proved.theorem(), Theorem::InputToStateStability(_))) {
        if let Ok(file) = proved.file(&format!("{name}: bound of the error")) {
            folder.write(&format!("certificates/{}.bounds.json", file_name(name)), file.to_json().as_bytes())?;
        }
    }
    Ok(())
}

/// What is proved of the loop with the feedback of the study, in a file of its own.
fn closed_loop(folder: &Folder, name: &str, designed: &Designed) -> Result<(), StudyError> {
    let behind = designed.certificate.iter().flat_map(|certificate| certificate.theorems().iter().skip(1));
    let is_loop = |theorem: &Theorem| {
        matches!(theorem, Theorem::LinearConvergence(_) | Theorem::DiscreteConvergence(_) | Theorem::FeedbackLoop(_))
    };
    for proved in behind.filter(|proved| is_loop(proved.theorem())) {
        if let Ok(file) = proved.file(&format!("{name}: the loop, with (x, xhat) as its error")) {
            folder.write(&format!("certificates/{}.feedback.json", file_name(name)), file.to_json().as_bytes())?;
        }
    }
    Ok(())
}

pub(crate) fn summary(study: &Study) -> PlantSummary {
    let plant = &study.plant;
    let (kind, mut equations) = match &plant.model {
        Model::Linear(_) => ("linear".to_owned(), Vec::new()),
        Model::Expressions(expressions, _) => {
            let mark = if plant.dt.is_some() { "+" } else { "'" };
            let f =
                plant.states.iter().zip(expressions.f()).map(|(name, row)| format!("{name}{mark} = {}", row.text()));
            let h = plant.outputs.iter().zip(expressions.h()).enumerate().map(|(k, (name, row))| match row.text() {
                // An output with the same name as the state it measures: `v2 = v2` carries no information.
                text if text == name => format!("y{} = {text}", k + 1),
                text => format!("{name} = {text}"),
            });
            ("expressions".to_owned(), f.chain(h).collect())
        }
        Model::Builtin(builtin) => (builtin.name().to_owned(), Vec::new()),
    };
    let linear = plant.model.linear();
    let mark = if plant.dt.is_some() { "+" } else { "'" };
    let motion = format!("x{mark} = A x{}", if plant.inputs.is_empty() { "" } else { " + B u" });
    if let Some(linear) = linear {
        let output = if linear.d.is_some() { "y = C x + D u" } else { "y = C x" };
        equations.extend([motion, output.to_owned()]);
    }
    let matrices = linear.map(matrices).unwrap_or_default();
    PlantSummary {
        kind,
        states: plant.states.clone(),
        units: plant.units_of(&plant.states),
        input_units: plant.units_of(&plant.inputs),
        output_units: plant.units_of(&plant.outputs),
        time_unit: plant.time_unit.clone(),
        dt: plant.dt,
        parameters: plant
            .parameters
            .iter()
            .map(|(name, value)| ParameterReport { name: name.clone(), value: *value, unit: plant.unit(name).cloned() })
            .collect(),
        inputs: plant.inputs.clone(),
        outputs: plant.outputs.clone(),
        equations,
        matrices,
    }
}

/// A, B, C and D of a linear plant, as far as they are not empty.
fn matrices(plant: &StateSpace) -> Vec<NamedMatrix> {
    let all = [("A", &plant.a), ("B", &plant.b), ("C", &plant.c)];
    let all = all.into_iter().chain(plant.d.iter().map(|d| ("D", d)));
    all.filter(|(_, m)| !m.is_empty()).map(|(name, m)| matrix(name, m)).collect()
}
