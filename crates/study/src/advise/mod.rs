//! Which observer should I use? Every kind of observer whose hypotheses hold for the plant of a study is tuned by its
//! rule from the same information, run on the same noises or on the log of the study, and ranked.
//!
//! | file | subject |
//! |---|---|
//! | `information` | the prior information of every kind: given in the study, or derived |
//! | `rules`, `tuning` | **the table of kinds**; the numbers of their rules |
//! | `block` | an observer as text; a study with further observers |
//! | `candidate` | design, cost and scores of one observer |
//! | `on_log` | the information and the scores that a log gives |
//! | `ranking` | criteria and order |
//! | `words`, `figure`, `report` | the ranking in words, as a figure, as data |
//!
//! A kind of observer is added by one row in `rules`.

pub(crate) mod block;
mod candidate;
mod document;
mod figure;
mod on_log;
pub(crate) mod ranking;
mod report;
mod words;

pub use crate::tuning::{InformationKind, PriorInformation};
pub use candidate::Medians;
pub use ranking::{Criteria, Criterion, UNPROVED_FACTOR};
pub use report::{Advice, NotApplicable, RankedObserver};

use std::fmt::Write;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::time::Duration;

use luenberger_clock::Instant;
use luenberger_linalg::observability;
use luenberger_proof::wording::{complex, counted, shortest};
use luenberger_wording::setters;
use rayon::prelude::*;

use self::block::{Block, text_with};
use self::candidate::{Candidate, Outcome, Score};
use self::ranking::{Ranked, preferred, rank, tied};
use crate::error::StudyError;
use crate::error::log::LogError;
use crate::execute::prediction::{self, quoted};
use crate::execute::{self, Limits, Trial, within};
use crate::kinds::{self, Declaration, Rule, Tuning, registry};
use crate::read::Format;
use crate::results::Quantity;
use crate::statistics::pareto_front;
use crate::study::{AdviseSpec, Log, ObserverSpec, Simulation, Study};
use crate::synthesis::explain;
use crate::trajectory;
use crate::tuning::{Basis, Information};
use crate::{RunOptions, design, write_folder};

/// Default time budget in seconds.
pub const BUDGET: f64 = 60.0;

/// Options of the comparison.
pub struct AdviseOptions<'a> {
    /// Output folder, progress, interruption and threads; its limits do not apply.
    pub run: RunOptions<'a>,
    /// What the observers are ranked by; by default the error in a simulation, and the innovations on a log.
    pub criteria: Option<Criteria>,
    /// Time budget in seconds. What is not reached within it is listed.
    pub budget: f64,
    /// Whether observers of the study that a rule could tune are ranked too, with the tuning of the study (default
    /// true).
    pub own_tuning: bool,
}

impl Default for AdviseOptions<'_> {
    fn default() -> Self {
        Self { run: RunOptions::default(), criteria: None, budget: BUDGET, own_tuning: true }
    }
}

impl<'a> AdviseOptions<'a> {
    setters! { run: RunOptions<'a>, criteria: Criteria, budget: f64, own_tuning: bool }
}

/// Tries every kind of observer on the study, and ranks them. Beside the result is the interruption by the user, if
/// there was one.
///
/// ```
/// use luenberger_study::advise::{AdviseOptions, advise};
/// use luenberger_study::{Format, Study};
/// let text = "
/// [plant]
/// a = [[0, 1], [0, 0]]
/// c = [[1, 0]]
/// [simulation]
/// x0 = [1, 0]
/// duration = 10
/// noise = { distribution = \"gaussian\", amplitude = [0.01], period = 0.1 }
/// [advise]
/// ensemble = 2
/// ";
/// let study = Study::from_text("study.toml", text, Format::Toml, ".".as_ref())?;
/// let (advice, _) = advise(&study, &AdviseOptions::default())?;
/// assert!(advice.ranking.iter().any(|observer| observer.kind == "kalman"));
/// assert!(advice.not_applicable.iter().any(|kind| kind.name == "lpv"));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
/// # Errors
/// [`StudyError::Missing`] without a simulation with measurement noise and without a log, and for criteria that need
/// the other of them; [`StudyError::OnLog`] for a log on which observers cannot be compared; [`StudyError::Sim`] for a
/// plant that cannot be simulated; errors of the results folder.
pub fn advise(study: &Study, options: &AdviseOptions<'_>) -> Result<(Advice, Option<StudyError>), StudyError> {
    let ground = ground(study, options)?;
    let end = Duration::try_from_secs_f64(options.budget).ok().and_then(|budget| Instant::now().checked_add(budget));
    let run =
        RunOptions { output: None, limits: Limits::NONE, sweep: options.run.sweep.clone(), until: end, ..options.run };
    let mut advice = within(&run, |run| compare(study, ground, options, run))?;
    if let Some(output) = &options.run.output {
        let mut files = std::mem::take(&mut advice.1);
        files.push(("advice.json".to_owned(), (serde_json::to_string_pretty(&advice.0)? + "\n").into_bytes()));
        advice.0.renamed = write_folder(output.clone(), options.run.force, "advise", study, &files)?;
    }
    let interrupted = options.run.cancel.load(Ordering::Relaxed).then_some(StudyError::Interrupted);
    Ok((advice.0, interrupted))
}

/// Where the observers run.
#[derive(Clone, Copy)]
enum Ground<'a> {
    Simulation(&'a Simulation),
    Log(&'a Log),
}

impl Ground<'_> {
    /// What observers are ranked by if nothing else is asked for.
    fn criterion(self) -> Criterion {
        match self {
            Self::Simulation(_) => Criterion::Error,
            Self::Log(_) => Criterion::Innovations,
        }
    }
}

/// Where the observers of a study run: on its log for criteria of a log and without a noisy simulation, otherwise in
/// its simulation.
fn ground<'a>(study: &'a Study, options: &AdviseOptions<'_>) -> Result<Ground<'a>, StudyError> {
    let missing = |needs| Err(StudyError::Missing { step: "advise", needs });
    if !study.estimated.is_empty() {
        return missing("a plant without parameters as states ([estimate]): its rules are for the states of [plant]");
    }
    let asks = |of: fn(Criterion) -> bool| {
        options.criteria.as_ref().is_some_and(|criteria| criteria.0.iter().any(|(criterion, _)| of(*criterion)))
    };
    match (&study.simulation, &study.log) {
        (None, None) => missing("a [simulation] with measurement noise, or a [log]"),
        (_, None) if asks(Criterion::is_of_log) => missing("a [log] to rank by innovations or likelihood"),
        (None, Some(_)) if asks(Criterion::is_of_simulation) => {
            missing("a [simulation] to rank by noise, peak or settling, which need the true state")
        }
        (Some(_), Some(_)) if asks(Criterion::is_of_log) && asks(Criterion::is_of_simulation) => missing(
            "criteria of one kind (noise, peak and settling are those of a simulation, innovations and likelihood of a log)",
        ),
        (Some(simulation), log) if !asks(Criterion::is_of_log) => match log {
            _ if simulation.is_noisy() => Ok(Ground::Simulation(simulation)),
            Some(log) if !asks(Criterion::is_of_simulation) => on_log(log, asks(|one| one == Criterion::Error)),
            _ => missing(
                "measurement noise (simulation.noise, or sensors with an amplitude), without which the fastest observer is the best",
            ),
        },
        (_, Some(log)) => on_log(log, asks(|one| one == Criterion::Error)),
        (Some(simulation), None) => Ok(Ground::Simulation(simulation)),
    }
}

/// A log, which has true states where they are asked for.
fn on_log(log: &Log, needs_truth: bool) -> Result<Ground<'_>, StudyError> {
    if needs_truth && log.truth.is_none() {
        let needs = "columns of true states (`states` in [log]) to rank by error";
        return Err(StudyError::Missing { step: "advise", needs });
    }
    Ok(Ground::Log(log))
}

/// Files by their names in the results folder.
type Files = Vec<(String, Vec<u8>)>;

fn compare(
    study: &Study,
    ground: Ground<'_>,
    options: &AdviseOptions<'_>,
    run: &RunOptions<'_>,
) -> Result<(Advice, Files), StudyError> {
    let default = AdviseSpec::default();
    let spec = study.advise.as_ref().unwrap_or(&default);
    let criteria = options.criteria.clone().unwrap_or_else(|| ground.criterion().into());
    let mut advice = Advice {
        title: study.title.clone(),
        plant: execute::summary(study),
        observability: None,
        information: Vec::new(),
        criteria,
        runs: 0,
        ensemble: if matches!(ground, Ground::Log(_)) { 1 } else { spec.ensemble },
        scoring: None,
        held_out: None,
        ranking: Vec::new(),
        pareto_cost: Vec::new(),
        pareto_peak: Vec::new(),
        explanation: Vec::new(),
        not_applicable: Vec::new(),
        not_reached: Vec::new(),
        recommended: Vec::new(),
        files: Vec::new(),
        renamed: Vec::new(),
        study: String::new(),
    };
    if let Some(why) = undetectable(study)? {
        advice.observability = Some(why);
        return Ok((advice, Files::new()));
    }
    let found = match ground {
        Ground::Simulation(simulation) => simulated((study, simulation), spec, options, run, &mut advice)?,
        Ground::Log(log) => logged((study, log), spec, options, run, &mut advice)?,
    };
    let Some(candidates) = found else { return Ok((advice, Files::new())) };
    let accuracy = advice.accuracy();
    let (scores, order) = rank(&candidates, &advice.criteria, accuracy);
    let ordered: Vec<&Candidate> = order.iter().map(|&i| &candidates[i]).collect();
    advice.ranking = order.iter().map(|&i| ranked(&candidates[i], scores[i])).collect();
    for (criterion, names) in [(Criterion::Cost, &mut advice.pareto_cost), (Criterion::Peak, &mut advice.pareto_peak)] {
        if matches!(ground, Ground::Log(_)) && criterion == Criterion::Peak {
            continue;
        }
        let complete: Vec<&&Candidate> = ordered.iter().filter(|one| one.is_complete()).collect();
        let points: Vec<_> = complete.iter().map(|one| (one.value(criterion), one.value(accuracy))).collect();
        *names = pareto_front(&points).into_iter().map(|i| complete[i].spec.name.clone()).collect();
    }
    let scored: Vec<(&Candidate, f64)> = order.iter().map(|&i| (&candidates[i], scores[i])).collect();
    let chosen = recommended(&scored);
    let words = words::Ranking { study, criteria: &advice.criteria, accuracy, ordered: scored, runs: advice.runs };
    advice.explanation = words.sentences();
    advice.recommended = chosen.iter().map(|one| one.spec.name.clone()).collect();
    let blocks: Vec<Block> = chosen.iter().filter_map(|one| one.block.clone()).collect();
    advice.study = text_with(study, &blocks)?;
    let files = if options.run.output.is_some() { files(study, &advice, &ordered, accuracy)? } else { Files::new() };
    advice.files = files.iter().map(|(name, _)| name.clone()).chain(["advice.json".to_owned()]).collect();
    Ok((advice, files))
}

/// The candidates with their runs in a simulation; none if the time is over before.
fn simulated(
    (study, simulation): (&Study, &Simulation),
    spec: &AdviseSpec,
    options: &AdviseOptions<'_>,
    run: &RunOptions<'_>,
    advice: &mut Advice,
) -> Result<Option<Vec<Candidate>>, StudyError> {
    let fed = fed(study, run)?;
    let fed = fed.as_ref().map(|(requested, designed)| (*requested, designed));
    let period = crate::tuning::period(study, simulation, spec).0;
    let longest = study.observers.iter().filter_map(|observer| observer.kind.period()).fold(period, f64::max);
    let score_period = Some(simulation.score_period.unwrap_or(longest));
    // Any scale will do for the run of the plant alone.
    let rough = Simulation { scale: Some(vec![1.0; simulation.x0.len()]), score_period, ..simulation.clone() };
    let plant = match Trial::new(study, &rough, fed, 0)?.plant(run.until) {
        Err(luenberger_sim::SimError::TimeLimit { .. }) => {
            advice.not_reached.push("everything: the run of the plant alone takes longer than the budget".to_owned());
            return Ok(None);
        }
        plant => plant?,
    };
    let basis = Basis::of_simulation(study, simulation, spec, &plant);
    let information = Information::of(study, spec, &basis).ok_or(LogError::NoRegion)?;
    advice.observability = hidden(study, &information)?;
    advice.information.clone_from(&information.lines);
    let scored = Simulation { scale: Some(information.scale.clone()), ..rough.clone() };
    let trial = Trial::new(study, &scored, fed, spec.seed)?;
    advice.scoring = Some(trial.scoring());
    let mut candidates = designs(study, &information, options, run, advice)?;
    advice.runs = runs(&trial, &mut candidates, &information, spec.ensemble, run, &mut advice.not_reached)?;
    Ok(Some(candidates))
}

/// The candidates with their run on a log; none if the time is over before.
fn logged(
    (study, log): (&Study, &Log),
    spec: &AdviseSpec,
    options: &AdviseOptions<'_>,
    run: &RunOptions<'_>,
    advice: &mut Advice,
) -> Result<Option<Vec<Candidate>>, StudyError> {
    let first = prediction::held_out(log, prediction::share(study, spec.held_out))?;
    let basis = match on_log::basis((study, log), spec, first, run) {
        Err(StudyError::Interrupted) => {
            advice.not_reached.push("everything: the first run on the log takes longer than the budget".to_owned());
            return Ok(None);
        }
        basis => basis?,
    };
    let information = Information::of(study, spec, &basis).ok_or(LogError::NoRegion)?;
    advice.observability = hidden(study, &information)?;
    advice.information.clone_from(&information.lines);
    let mut candidates = designs(study, &information, options, run, advice)?;
    let open = (run, &mut advice.not_reached);
    advice.held_out = on_log::scored((study, log), first, &mut candidates, &information, open)?;
    advice.runs = usize::from(!candidates.is_empty());
    Ok(Some(candidates))
}

/// Why no observer of a linear plant exists, if none does.
fn undetectable(study: &Study) -> Result<Option<String>, StudyError> {
    let Some(plant) = study.plant.model.linear() else { return Ok(None) };
    if explain::undetectable(&study.plant).is_none() {
        return Ok(None);
    }
    Ok(Some(format!(
        "{}: the plant is not detectable, no observer exists. Add an output that depends on these directions.",
        modes(study, &plant.a, &plant.c)?
    )))
}

/// What no observer can speed up, at the first estimate.
fn hidden(study: &Study, information: &Information) -> Result<Option<String>, StudyError> {
    let (a, c) = &information.linearised;
    if a.iter().chain(c.iter()).any(|entry| !entry.is_finite()) {
        return Ok(Some("The derivatives at the first estimate are not finite.".to_owned()));
    }
    if observability(a, c)?.is_observable() {
        return Ok(None);
    }
    let of = if study.plant.model.linear().is_some() { "" } else { " Of the linearisation at the first estimate:" };
    let rest = "to working precision their errors decay as the plant itself does, whatever the observer";
    Ok(Some(format!(
        "{}{}: {rest}.",
        of.trim_start().to_owned() + if of.is_empty() { "" } else { " " },
        modes(study, a, c)?
    )))
}

fn modes(study: &Study, a: &nalgebra::DMatrix<f64>, c: &nalgebra::DMatrix<f64>) -> Result<String, StudyError> {
    let found = observability(a, c)?;
    let mut text = format!("rank {} of {}, unobservable modes at", found.rank, a.nrows());
    for (k, mode) in found.unobservable.iter().enumerate() {
        let direction: Vec<f64> = mode.direction.iter().map(|x| x.re).collect();
        let comma = if k > 0 { "," } else { "" };
        let value = complex([mode.eigenvalue.re, mode.eigenvalue.im], 3);
        _ = write!(text, "{comma} {value} along {}", study.plant.direction_in_words(&direction));
    }
    Ok(text)
}

/// The observer in the feedback loop of the study, designed.
fn fed<'a>(study: &'a Study, run: &RunOptions<'_>) -> Result<Option<(&'a ObserverSpec, design::Designed)>, StudyError> {
    let Some(spec) = study.observers.iter().find(|observer| trajectory::is_fed(study, &observer.name)) else {
        return Ok(None);
    };
    match design::attempt(study, spec, run.cancel, run.until) {
        Ok(designed) => Ok(Some((spec, designed))),
        Err(none) if none.is_interrupted() => Err(StudyError::Interrupted),
        Err(_) => Err(StudyError::Missing { step: "advise", needs: "a design of the observer in the feedback loop" }),
    }
}

/// What is to be designed: a rule, or an observer of the study.
#[derive(Clone, Copy)]
enum Task<'a> {
    Rule(&'static Declaration, &'static Rule),
    Own(&'a ObserverSpec),
}

impl Task<'_> {
    fn name(&self) -> &str {
        match self {
            Self::Rule(_, rule) => rule.name,
            Self::Own(spec) => &spec.name,
        }
    }

    fn takes_long(&self) -> bool {
        match self {
            Self::Rule(kind, _) => kind.takes_long,
            Self::Own(spec) => kinds::takes_long(&spec.kind),
        }
    }
}

/// The designs, within half of the budget, the long ones last.
fn designs(
    study: &Study,
    information: &Information,
    options: &AdviseOptions<'_>,
    run: &RunOptions<'_>,
    advice: &mut Advice,
) -> Result<Vec<Candidate>, StudyError> {
    let ranked = |spec: &&ObserverSpec| options.own_tuning || without_rule().any(|(kind, _)| kind == spec.kind.name());
    let own = study.observers.iter().filter(ranked).map(Task::Own);
    let tasks: Vec<Task<'_>> = rules().into_iter().map(|(kind, rule)| Task::Rule(kind, rule)).chain(own).collect();
    let half = Duration::try_from_secs_f64(0.5 * options.budget).ok().and_then(|half| Instant::now().checked_add(half));
    let until = half.into_iter().chain(run.until).min();
    let part = RunOptions { sweep: run.sweep.clone(), output: None, until, threads: None, ..*run };
    let done = AtomicUsize::new(0);
    let outcomes = within(&part, |part| {
        let one = |(number, task): (usize, &Task<'_>)| {
            if part.interrupted() {
                return (number, Outcome::Open);
            }
            let stop = (part.cancel, part.until);
            let outcome = match task {
                Task::Rule(kind, rule) => candidate::by_rule(study, information, (kind.name, rule), stop),
                Task::Own(spec) => candidate::of_study(study, information, spec, stop),
            };
            let count = done.fetch_add(1, Ordering::Relaxed) + 1;
            part.tell("design", task.name(), count, tasks.len());
            (number, outcome)
        };
        let mut outcomes = Vec::new();
        for long in [false, true] {
            let of = tasks.par_iter().enumerate().filter(|(_, task)| task.takes_long() == long);
            outcomes.extend(of.map(one).collect::<Vec<_>>());
        }
        outcomes.sort_by_key(|(number, _)| *number);
        Ok(outcomes)
    })?;
    let mut candidates = Vec::new();
    for (number, outcome) in outcomes {
        let name = match &tasks[number] {
            // Beside the rule of this name.
            Task::Own(spec) if rules().iter().any(|(_, rule)| rule.name == spec.name) => {
                format!("{} of the study", spec.name)
            }
            task => task.name().to_owned(),
        };
        match outcome {
            Outcome::Designed(candidate) => candidates.push(*candidate),
            Outcome::Unfit(hypothesis) => advice.not_applicable.push(NotApplicable { name, hypothesis }),
            Outcome::Open => advice.not_reached.push(format!("the design of {name}, within half of the budget")),
        }
    }
    candidate::find_same(&mut candidates);
    for (kind, why) in without_rule() {
        if !study.observers.iter().any(|observer| observer.kind.name() == kind) {
            advice.not_applicable.push(NotApplicable { name: kind.to_owned(), hypothesis: why.to_owned() });
        }
    }
    Ok(candidates)
}

/// The share of the remaining budget that the first run of an observer may take.
const RUN_SHARE: f64 = 0.1;

/// The runs, all observers on one noise before the next; returns how many noises all of them have.
fn runs(
    trial: &Trial<'_>,
    candidates: &mut Vec<Candidate>,
    information: &Information,
    ensemble: usize,
    run: &RunOptions<'_>,
    open: &mut Vec<String>,
) -> Result<usize, StudyError> {
    let mut finished = 0;
    for number in 0..ensemble {
        let share = |end: Instant| {
            let now = Instant::now();
            now + end.saturating_duration_since(now).mul_f64(RUN_SHARE)
        };
        let until = if number == 0 { run.until.map(share) } else { run.until };
        let one = |candidate: &Candidate| {
            if run.interrupted() {
                return Ok(None);
            }
            let spec = &candidate.spec;
            let initial = trial.initial(spec, information.region.states(), number as u64);
            match trial.run((spec, &candidate.designed), initial, number as u64, until) {
                Ok(outcome) => Ok(Some(outcome.map(Score::Simulated))),
                Err(StudyError::Interrupted) => Ok(None),
                Err(error) => Err(error),
            }
        };
        let outcomes = candidates.par_iter().map(one).collect::<Result<Vec<_>, StudyError>>()?;
        let is_over = run.interrupted();
        if number > 0 && (is_over || outcomes.iter().any(Option::is_none)) {
            open.push(format!(
                "runs {} to {ensemble} of {ensemble}: the ranking is of the first {}",
                number + 1,
                counted(number, "run")
            ));
            return Ok(finished);
        }
        let mut kept = Vec::new();
        for (mut candidate, outcome) in std::mem::take(candidates).into_iter().zip(outcomes) {
            let name = &candidate.spec.name;
            match outcome {
                Some(outcome) => {
                    candidate.runs.push(outcome);
                    kept.push(candidate);
                }
                None if is_over => open.push(format!("the first run of {name}")),
                None => {
                    let share = shortest(100.0 * RUN_SHARE);
                    open.push(format!("{name}, whose first run takes more than {share} % of the rest of the budget"));
                }
            }
        }
        *candidates = kept;
        finished = number + 1;
        run.tell("simulate", &format!("run {finished}"), finished, ensemble);
        if is_over {
            open.push(format!("runs 2 to {ensemble} of {ensemble}: the ranking is of one run"));
            break;
        }
    }
    Ok(finished)
}

fn ranked(one: &Candidate, score: f64) -> RankedObserver {
    let report = &one.designed.report;
    RankedObserver {
        name: one.spec.name.clone(),
        kind: one.spec.kind.name().to_owned(),
        score: score.is_finite().then_some(score),
        finished: one.finished(),
        ended: one.runs.iter().find_map(|run| run.as_ref().err().cloned()),
        left_region: one.runs.iter().flatten().filter(|run| run.left()).count(),
        medians: one.medians(),
        on_log: one.on_log().cloned(),
        operations: one.cost.as_ref().ok().copied(),
        not_exported: one.cost.as_ref().err().cloned(),
        noise_gain: report.quantity(Quantity::NoiseGain),
        verdict: report.verdict,
        statement: report.statement.clone(),
        same_as: one.same_as.clone(),
        rule: one.rule.to_owned(),
        source: one.source.to_owned(),
        information: one.information.clone(),
    }
}

/// The best observer, or the one preferred of those that tie with it, and the best one with a proof.
fn recommended<'a>(scored: &[(&'a Candidate, f64)]) -> Vec<&'a Candidate> {
    let mut chosen: Vec<&Candidate> = preferred(&tied(scored)).into_iter().collect();
    if let Some((proved, _)) = scored.iter().find(|(one, _)| one.is_complete() && one.is_proved())
        && chosen.iter().all(|one| !one.is_proved())
    {
        chosen.push(proved);
    }
    chosen
}

/// The study with the recommended observers and its data, the scores of all runs, and the figure.
fn files(study: &Study, advice: &Advice, ordered: &[&Candidate], accuracy: Criterion) -> Result<Files, StudyError> {
    let mut files = figure::files(ordered, accuracy)?;
    let extension = if study.format == Format::Json { "json" } else { "toml" };
    files.push((format!("study.{extension}"), advice.study.clone().into_bytes()));
    for file in &study.files {
        let is_inside =
            std::path::Path::new(&file.name).components().all(|part| matches!(part, std::path::Component::Normal(_)));
        if is_inside {
            let read = study.data.read(&file.name);
            let bytes = read.map_err(|error| StudyError::io(&study.data.path(&file.name), error))?;
            files.push((file.name.clone(), bytes));
        }
    }
    let table = if advice.held_out.is_some() { table_on_log(study, ordered) } else { table(ordered) };
    files.push(("runs.csv".to_owned(), table.into_bytes()));
    Ok(files)
}

/// The scores on the part of the log that is held out.
fn table_on_log(study: &Study, ordered: &[&Candidate]) -> String {
    let (outputs, states) = (&study.plant.outputs, &study.plant.states);
    let mut text = format!("observer,{},failure\n", prediction::csv_head(outputs, states));
    for one in ordered {
        let cells = prediction::csv_cells(one.on_log(), outputs, states);
        _ = writeln!(text, "{},{cells},{}", quoted(&one.spec.name), failure(one.runs.first()));
    }
    text
}

/// Why a run ended early, as a cell.
fn failure(run: Option<&Result<Score, String>>) -> String {
    run.and_then(|run| run.as_ref().err()).map(|why| quoted(why)).unwrap_or_default()
}

/// The scores of each run.
fn table(ordered: &[&Candidate]) -> String {
    let mut text = "observer,run,rms,settling,peak,steady_rms,failure\n".to_owned();
    for one in ordered {
        let columns = [one.rms(), one.settling(), one.peak(), one.steady()];
        for (number, run) in one.runs.iter().enumerate() {
            let cell = |column: &Vec<f64>| {
                let x = column[number];
                if x.is_finite() { shortest(x) } else { String::new() }
            };
            let cells = columns.iter().map(cell).collect::<Vec<_>>().join(",");
            _ = writeln!(text, "{},{number},{cells},{}", quoted(&one.spec.name), failure(Some(run)));
        }
    }
    text
}

/// All rules with their kinds, the quick designs first.
fn rules() -> Vec<(&'static Declaration, &'static Rule)> {
    let of = |kind: &'static Declaration| match kind.tuning {
        Tuning::Rules(rules) => rules.iter().map(|rule| (kind, rule)).collect(),
        Tuning::OfStudy(_) | Tuning::Never(_) => Vec::new(),
    };
    let mut all: Vec<_> = registry().into_iter().flat_map(of).collect();
    all.sort_by_key(|(_, rule)| rule.turn);
    all
}

/// The kinds without a rule, and why: they are ranked where the study has one.
fn without_rule() -> impl Iterator<Item = (&'static str, &'static str)> {
    registry().into_iter().filter_map(|kind| match kind.tuning {
        Tuning::Rules(_) => None,
        Tuning::OfStudy(why) | Tuning::Never(why) => Some((kind.name, why)),
    })
}
