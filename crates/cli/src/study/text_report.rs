//! Results as text: values, failures, and the files written.

use super::columns::table;
use super::text_log;
use crate::answer::Answer;
use crate::failure::Failure;
use crate::numbers::{beside, complex, margin, number, size};
use luenberger_proof::wording::counted;
use luenberger_study::results::{
    ABOUT_ZERO, ABOUT_ZERO_MEANS, ModeReport, ObservabilityAt, ObservabilityReport, ObserverReport,
    OperatingPointReport, ScoreCell, ScoreTable, SimulationReport, SweepReport, UnseenModes, is_about_zero, leading,
};
use luenberger_study::{Results, Step, StudyError};
use nalgebra::Complex;
use std::fmt::Write;
use std::path::Path;

/// Maximal number of modes and of poles printed; --json has all.
const SHOWN: usize = 12;

/// Maximal number of states of which the scores are printed; --json has all.
const STATES: usize = 6;

/// Maximal number of matrix entries printed; --json and study.json have all.
const ENTRIES: usize = 36;

/// The results with their text, or with why they are not complete.
pub(super) fn answer(
    step: Step,
    results: &Results,
    folder: Option<&Path>,
    stopped: Option<StudyError>,
) -> Result<Answer, Failure> {
    let failures = results.failures();
    let text = self::results(step, results, &failures, folder);
    let answer = Answer::new(text, results)?.negative(!failures.is_empty());
    match stopped {
        None => Ok(answer),
        Some(error) => Err(Failure::Stopped { error, finished: Box::new(answer) }),
    }
}

/// The whole text.
fn results(step: Step, results: &Results, failures: &[String], folder: Option<&Path>) -> String {
    let plant = &results.plant;
    let mut text = format!(
        "{}: {}, {}, {} ({})\n",
        results.title,
        counted(plant.states.len(), "state"),
        counted(plant.inputs.len(), "input"),
        counted(plant.outputs.len(), "output"),
        plant.kind
    );
    if let Some(point) = &results.operating_point {
        operating_point(&mut text, results, point);
    }
    if let Some(report) = &results.observability {
        observability(&mut text, report);
    }
    // Gains and proofs are printed by `design`, `certify` and `run` only.
    let is_full = matches!(step, Step::Design | Step::Certify | Step::Run);
    if !is_full && !results.observers.is_empty() {
        text.push('\n');
    }
    for report in &results.observers {
        match &report.design {
            Some(design) if !is_full => {
                _ = writeln!(text, "{} ({}): {}", report.name, report.kind, design.verdict);
            }
            _ => observer(&mut text, report),
        }
    }
    if let Some(report) = &results.simulation {
        simulation(&mut text, results, report);
    }
    if !results.intervals.is_empty() {
        text_log::intervals(&mut text, results);
    }
    if !results.filters.is_empty() {
        text_log::filters(&mut text, &results.filters);
    }
    if let Some(report) = &results.log {
        text_log::log(&mut text, report, &results.plant);
    }
    if let Some(report) = &results.sweep {
        sweep(&mut text, results, report);
    }
    for warning in &results.warnings {
        text.extend(["\nwarning: ", warning]);
    }
    for failure in failures {
        text.extend(["\nfailed: ", failure]);
    }
    if !results.warnings.is_empty() || !failures.is_empty() {
        text.push('\n');
    }
    if let Some(folder) = folder {
        _ = writeln!(text, "\n{} in {}", counted(results.files.len() + 2, "file"), folder.display());
        if results.files.iter().any(|file| file == "report.html") {
            _ = writeln!(text, "report: {}", folder.join("report.html").display());
        }
    }
    text
}

/// A list of poles; those after the first ones of many are counted.
fn poles(all: &[[f64; 2]]) -> String {
    if all.len() <= SHOWN {
        return all.iter().map(|[re, im]| complex(Complex::new(*re, *im))).collect::<Vec<_>>().join(", ");
    }
    let shown: Vec<String> = all[..SHOWN].iter().map(|[re, im]| complex(Complex::new(*re, *im))).collect();
    format!("{} and {} more: see --json or study.json", shown.join(", "), all.len() - SHOWN)
}

/// The operating point with A, B, C and D.
fn operating_point(text: &mut String, results: &Results, point: &OperatingPointReport) {
    let plant = &results.plant;
    let named = |names: &[String], values: &[f64]| plant.listed(names, values.iter().map(|value| number(*value)));
    _ = writeln!(text, "\noperating point: {}", named(&plant.states, &point.x));
    if !point.u.is_empty() {
        _ = writeln!(text, "  under {}", named(&plant.inputs, &point.u));
    }
    _ = writeln!(text, "  outputs {}", named(&plant.outputs, &point.y));
    _ = writeln!(text, "  largest |f(x, u)| {} after {}", size(point.residual), counted(point.steps, "Newton step"));
    for matrix in &point.matrices {
        _ = writeln!(text, "  {} =", matrix.name);
        for row in &matrix.rows {
            let row: Vec<String> = row.iter().map(|x| number(*x)).collect();
            _ = writeln!(text, "    {}", row.join("  "));
        }
    }
    _ = writeln!(text, "  eigenvalues of A: {}", poles(&point.poles));
    let seen = if point.observable { "observable" } else { "not observable to working precision" };
    _ = writeln!(text, "  the linearisation is {seen}");
}

fn observability(text: &mut String, report: &ObservabilityReport) {
    let word = match (report.rank == report.order, report.is_decided()) {
        (true, _) => "observable",
        (false, true) => "not observable",
        (false, false) => "not observable to working precision",
    };
    _ = writeln!(text, "\nobservability: rank {} of {}, {word}", report.rank, report.order);
    for point in &report.points {
        if let (Some(t), Some(x)) = (point.t, &point.x) {
            let x: Vec<String> = x.iter().map(|x| number(*x)).collect();
            _ = writeln!(text, "linearised at t = {}, x = [{}]: rank {}", number(t), x.join(", "), point.rank);
        }
        modes(text, point);
    }
    if let Some(nonlinear) = &report.nonlinear {
        for lie in &nonlinear.lie {
            _ = writeln!(text, "Lie derivatives at t = {}: rank {}", number(lie.t), lie.rank);
        }
        for line in nonlinear.words.lines() {
            text.extend(["  ", line, "\n"]);
        }
        // The eigenvalues are sorted, the largest first.
        if let Some(least) = nonlinear.gramian.last() {
            _ = writeln!(text, "  empirical Gramian: least eigenvalue {}", size(*least));
        }
    }
}

fn modes(text: &mut String, point: &ObservabilityAt) {
    let values =
        point.modes.iter().chain(&point.hidden).map(|mode| Complex::new(mode.eigenvalue[0], mode.eigenvalue[1]));
    let largest = values.map(Complex::norm).fold(0.0, f64::max);
    let eigenvalue = |mode: &ModeReport| {
        let [re, im] = match point.unseen {
            // A small eigenvalue of a mode that is decided to decay is no rounding.
            UnseenModes::Decay => mode.eigenvalue,
            _ => mode.eigenvalue.map(|part| beside(part, largest)),
        };
        complex(Complex::new(re, im))
    };
    // The least observable modes come first; of a large plant only these are printed.
    let mut modes: Vec<&ModeReport> = point.modes.iter().collect();
    modes.sort_by(|x, y| x.margin.total_cmp(&y.margin));
    for mode in modes.iter().take(SHOWN) {
        let words = format!(
            "  mode {}: margin {}, least observable direction {}\n",
            eigenvalue(mode),
            margin(mode.margin),
            leading(&mode.words)
        );
        text.push_str(&words);
    }
    if modes.len() > SHOWN {
        _ = writeln!(text, "  and {} more with larger margins", modes.len() - SHOWN);
    }
    for mode in &point.hidden {
        _ = writeln!(text, "  unobservable: {} along {}", eigenvalue(mode), leading(&mode.words));
    }
    if !point.hidden.is_empty() {
        let word = match point.unseen {
            UnseenModes::Decay => "detectable: the unobservable modes are stable",
            UnseenModes::None => "unobservable to working precision only: the plant as stored is observable",
            UnseenModes::Remain => "not detectable: no observer exists",
            UnseenModes::Undecided if point.t.is_some() => "unobservable to working precision",
            UnseenModes::Undecided => "unobservable to working precision: whether an observer exists is not decided",
        };
        _ = writeln!(text, "  {word}");
    }
}

fn observer(text: &mut String, report: &ObserverReport) {
    _ = write!(text, "\n{} ({})", report.name, report.kind);
    let Some(design) = &report.design else {
        let failure = report.failure.iter();
        for failure in failure {
            _ = writeln!(text, ": not applicable (line {}): {}", failure.line, failure.hypothesis);
            for line in failure.advice() {
                text.extend(["  ", &line, "\n"]);
            }
        }
        return;
    };
    _ = writeln!(text, ": {}\n  {}", design.verdict, design.statement);
    let mut about = false;
    for matrix in &design.matrices {
        let columns = matrix.rows.first().map_or(0, Vec::len);
        if matrix.rows.len() * columns > ENTRIES {
            _ = writeln!(text, "  {} is {} x {columns}: see --json or study.json", matrix.name, matrix.rows.len());
            continue;
        }
        let zeros = is_about_zero(&matrix.rows);
        about |= zeros.iter().flatten().any(|zero| *zero);
        let entry = |(x, zero): (&f64, &bool)| if *zero { ABOUT_ZERO.to_owned() } else { number(*x) };
        let row =
            |(row, zeros): (&Vec<f64>, &Vec<bool>)| row.iter().zip(zeros).map(entry).collect::<Vec<_>>().join(" ");
        let rows: Vec<String> = matrix.rows.iter().zip(&zeros).map(row).collect();
        _ = writeln!(text, "  {} = [{}]", matrix.name, rows.join("; "));
    }
    if about {
        _ = writeln!(text, "  {ABOUT_ZERO}: {ABOUT_ZERO_MEANS}; --json has the digits");
    }
    if !design.poles.is_empty() {
        _ = writeln!(text, "  poles {}", poles(&design.poles));
    }
    for entry in &design.numbers {
        _ = writeln!(text, "  {} {}", entry.name, entry.text());
    }
    if !design.noise_deviation.is_empty() {
        let deviations: Vec<String> = design.noise_deviation.iter().map(|x| number(*x)).collect();
        _ = writeln!(text, "  standard deviation of the error due to noise [{}]", deviations.join(" "));
    }
    if let Some(solver) = report.solver {
        _ = writeln!(text, "  solver {solver}");
    }
    let (shown, folded) = design.leading_facts();
    for fact in shown {
        _ = writeln!(text, "  {}: {}", fact.statement, fact.words);
    }
    if folded > 0 {
        _ = writeln!(
            text,
            "  and {} verified with larger margins: see --json or study.json",
            counted(folded, "condition")
        );
    }
    if let Some(evidence) = &design.evidence {
        _ = writeln!(text, "  {evidence}");
    }
}

fn simulation(text: &mut String, results: &Results, report: &SimulationReport) {
    let plant = &results.plant;
    let unit = plant.time_unit.as_ref().map(|unit| format!(" {unit}")).unwrap_or_default();
    _ = writeln!(text, "\nsimulation to t = {}{unit}", number(report.duration));
    let sampling = report.sampling.iter().map(|sampling| &sampling.words);
    for sentence in report.truth.iter().chain(&report.measurements).chain(sampling).chain(&report.scoring.words) {
        text.extend(["  ", sentence, "\n"]);
    }
    if report.rows.len() > 1 {
        text.push_str("  The best values have an asterisk.\n");
    }
    if let Some(norm) = report.norm_table(plant) {
        scores(text, &norm);
        text.push('\n');
    }
    match report.state_table(plant, STATES) {
        Some(states) => scores(text, &states),
        None => text.push_str("  No observer finished its run:\n"),
    }
    for ended in report.ended().into_iter().chain(results.not_run()) {
        text.extend(["  ", &ended, "\n"]);
    }
}

/// A table of scores, the best of them marked.
fn scores(text: &mut String, scores: &ScoreTable) {
    let cell = |cell: &ScoreCell| if cell.best { format!("{}*", cell.text) } else { cell.text.clone() };
    let rows = scores.rows.iter().map(|row| row.iter().map(cell).collect());
    table(text, &std::iter::once(scores.head.clone()).chain(rows).collect::<Vec<_>>());
    if scores.omitted > 0 {
        _ = writeln!(text, "  and {} without a row; --json has them", counted(scores.omitted, "state"));
    }
}

fn sweep(text: &mut String, results: &Results, report: &SweepReport) {
    let runs = counted(report.ensemble, "run");
    let medians = if report.ensemble == 1 { "" } else { ": medians, and the 5th .. 95th percentile" };
    _ = writeln!(text, "\nsweep of {}, {runs} at each value{medians}", report.parameter);
    for sentence in &report.scoring.words {
        text.extend(["  ", sentence, "\n"]);
    }
    match report.table(&results.plant, STATES) {
        Some(table) => scores(text, &table),
        None => text.push_str("  No run finished:\n"),
    }
    for ended in report.ended() {
        text.extend(["  ", &ended, "\n"]);
    }
}
