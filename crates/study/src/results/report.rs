//! `report.html`: the results as an HTML page with interactive figures.

mod diagram;
mod experiment;
mod live;
mod log_section;
mod summary;
mod terms;

pub use log_section::data as log_data;

use luenberger_expression::Formula as Typeset;
use luenberger_figures::{Cell, Figure, Formula, Grid, Report, Section, Tone};
use luenberger_live::Experiment;
use luenberger_live::page::{MODULE, SCRIPT, STYLE};
use luenberger_proof::wording::{complex, counted, significant};

use super::{
    ABOUT_ZERO, ABOUT_ZERO_MEANS, DesignReport, DesignVerdict, ModeReport, NamedMatrix, ObservabilityAt,
    ObservabilityReport, ObserverReport, OperatingPointReport, Results, ScoreCell, ScoreTable, SweepReport,
    is_about_zero,
};
use crate::error::StudyError;
use crate::study::Study;

/// The page. `files` are the names of the files in its folder.
pub(crate) fn html(
    study: &Study,
    results: &Results,
    figures: Vec<(String, Figure)>,
    live: Option<&Result<(Experiment, Vec<String>), String>>,
    files: &[String],
) -> Result<String, StudyError> {
    let mut report = Report::new(&results.title).lead(&results.about).numbers_as(&[]);
    report = report.section(summary::section(results));
    if !results.warnings.is_empty() {
        report = report.section(Section::new("Warnings").list(results.warnings.clone()));
    }
    report = report.section(plant(study, results));
    if let Some(experiment) = experiment::section(study) {
        report = report.section(experiment);
    }
    if let Some(point) = &results.operating_point {
        report = report.section(operating_point(results, point));
    }
    if let Some(observability) = &results.observability {
        report = report.section(self::observability(observability));
    }
    let section = results.observers.iter().fold(Section::new("Observers"), observer);
    if !results.observers.is_empty() {
        report = report.section(terms::section(section, results));
    }
    if results.simulation.is_some() || results.log.is_some() {
        report = report.section(comparison(results));
    }
    match live {
        Some(Ok((experiment, omitted))) => {
            let section = live::section(experiment, omitted)?;
            report = report.section(section).with(STYLE, SCRIPT).packed("live-module", MODULE);
        }
        Some(Err(why)) => report = report.section(live::absent(why)),
        None => {}
    }
    if !figures.is_empty() {
        let section =
            figures.into_iter().fold(Section::new("Figures"), |section, (id, figure)| section.figure(id, figure));
        report = report.section(section);
    }
    if let Some(sweep) = &results.sweep {
        report = report.section(self::sweep(results, sweep));
    }
    let links = files
        .iter()
        .filter(|name| ["trajectories/", "certificates/", "sweep.csv"].iter().any(|folder| name.starts_with(folder)))
        .map(|name| (name.clone(), String::new()));
    let links: Vec<(String, String)> =
        std::iter::once(("study.json".to_owned(), "all numbers".to_owned())).chain(links).collect();
    report = report.section(Section::new("Files").links(links)).section(experiment::reproduction(study));
    report.html().map_err(|why| StudyError::Output { what: "report.html".to_owned(), why: why.to_string() })
}

fn short(x: f64) -> String {
    significant(x, 6)
}

fn number(x: f64) -> Cell {
    Cell::number(short(x))
}

fn maybe(x: Option<f64>) -> Cell {
    x.map_or_else(|| Cell::number("–"), number)
}

/// A formula of the plant, for the page.
fn typeset(formula: Typeset) -> Formula {
    Formula { mathml: formula.mathml, latex: formula.latex }
}

fn plant(study: &Study, results: &Results) -> Section {
    let plant = &results.plant;
    let list = |names: &[String]| match names {
        [] => "none".to_owned(),
        names => names.iter().map(|name| plant.labelled(name)).collect::<Vec<_>>().join(", "),
    };
    let mut facts = vec![
        ("kind", plant.kind.clone()),
        ("states", list(&plant.states)),
        ("inputs", list(&plant.inputs)),
        ("outputs", list(&plant.outputs)),
    ];
    facts.extend(plant.time_unit.iter().map(|unit| ("time in", unit.clone())));
    facts.extend(plant.dt.iter().map(|dt| ("period dt", short(*dt))));
    let mut section = Section::new("Plant").html(diagram::svg(study)).facts(facts);
    section = match experiment::equations(study) {
        Some(equations) => section.formulas(equations),
        None if plant.equations.is_empty() => section,
        None => section.verbatim(plant.equations.join("\n")),
    };
    if !plant.parameters.is_empty() {
        let united = plant.parameters.iter().any(|parameter| parameter.unit.is_some());
        let columns = ["parameter", "value", "unit"];
        let grid = Grid::new(if united { &columns } else { &columns[..2] });
        let grid = plant.parameters.iter().fold(grid, |grid, parameter| {
            let unit = united.then(|| Cell::from(parameter.unit.as_deref().unwrap_or("–")));
            grid.row([Cell::from(parameter.name.as_str()), number(parameter.value)].into_iter().chain(unit))
        });
        section = section.grid(grid);
    }
    matrices(section, plant.matrices.iter())
}

fn operating_point(results: &Results, point: &OperatingPointReport) -> Section {
    let plant = &results.plant;
    let named = |names: &[String], values: &[f64]| plant.listed(names, values.iter().map(|value| short(*value)));
    let poles: Vec<String> = point.poles.iter().map(|pole| eigenvalue(*pole)).collect();
    let mut facts = vec![("states", named(&plant.states, &point.x))];
    if !point.u.is_empty() {
        facts.push(("inputs", named(&plant.inputs, &point.u)));
    }
    facts.extend([
        ("outputs", named(&plant.outputs, &point.y)),
        ("largest |f(x, u)|", short(point.residual)),
        ("Newton steps", point.steps.to_string()),
        ("eigenvalues of A", poles.join(", ")),
        (
            "the linearisation is",
            if point.observable { "observable" } else { "not observable to working precision" }.to_owned(),
        ),
    ]);
    let section = Section::new("Operating point")
        .prose("The plant rests at this state under this constant input. A, B, C and D are its linearisation there, of deviations from the point.")
        .facts(facts);
    matrices(section, point.matrices.iter())
}

/// A name with its unit, if there is one: `position (m)`.
pub(crate) fn with_unit(name: &str, unit: Option<&String>) -> String {
    unit.map_or_else(|| name.to_owned(), |unit| format!("{name} ({unit})"))
}

pub(crate) fn eigenvalue(z: [f64; 2]) -> String {
    complex(z, 6)
}

/// The largest terms of a direction, and the number of the others; `study.json` has all.
pub fn leading(words: &str) -> String {
    const SHOWN: usize = 6;
    let mut signs: Vec<usize> =
        [" + ", " - "].iter().flat_map(|sign| words.match_indices(sign)).map(|(at, _)| at).collect();
    signs.sort_unstable();
    match signs.get(SHOWN - 1) {
        Some(end) => format!("{} and {} smaller terms", &words[..*end], signs.len() + 1 - SHOWN),
        None => words.to_owned(),
    }
}

fn modes(modes: &[ModeReport]) -> Grid {
    modes.iter().fold(Grid::new(&["mode", "margin", "least observable direction"]), |grid, mode| {
        grid.row([Cell::number(eigenvalue(mode.eigenvalue)), number(mode.margin), Cell::from(leading(&mode.words))])
    })
}

fn observability(report: &ObservabilityReport) -> Section {
    let mut section = Section::new("Observability");
    let linear = report.points.iter().all(|point| point.t.is_none());
    section = section.prose(match (linear, report.rank == report.order) {
        (true, true) => format!("The plant is observable: rank {0} of {0}.", report.order),
        (true, false) if report.is_decided() => {
            format!("The plant is not observable: rank {} of {}.", report.rank, report.order)
        }
        (true, false) => format!("The plant has the rank {} of {} to working precision.", report.rank, report.order),
        (false, true) => format!("The linearisations along the trajectory are observable at every point: rank {0} of {0}.", report.order),
        (false, false) => format!(
            "The linearisations along the trajectory have rank {} of {} at the worst point. A nonlinear plant can be observable nevertheless.",
            report.rank, report.order
        ),
    });
    section = section.prose(
        "The margin of a mode is sigma_min([A - lambda I; C]) relative to the norm of [A; C]: 0 for an unobservable mode.",
    );
    section = if linear { report.points.iter().fold(section, of_linear) } else { section.grid(along(report)) };
    match &report.nonlinear {
        Some(nonlinear) => section.verbatim(&nonlinear.words),
        None => section,
    }
}

/// Every mode of a linear plant.
fn of_linear(section: Section, point: &ObservabilityAt) -> Section {
    if point.hidden.is_empty() {
        return section.grid(modes(&point.modes));
    }
    section.prose(point.unseen_in_words("These modes")).grid(modes(&point.hidden)).grid(modes(&point.modes))
}

/// The points of a trajectory, one row each, with the least observable mode there.
fn along(report: &ObservabilityReport) -> Grid {
    let lie = |t: Option<f64>| {
        let ranks = &report.nonlinear.as_ref()?.lie;
        ranks.iter().find(|at| Some(at.t) == t).map(|at| at.rank)
    };
    let head = [
        "t",
        "rank linearised",
        "rank of the Lie derivatives",
        "least observable mode",
        "margin",
        "direction",
        "unobservable",
    ];
    let grid = report.points.iter().fold(Grid::new(&head), |grid, point| {
        let least = point.modes.iter().min_by(|a, b| a.margin.total_cmp(&b.margin));
        let hidden = match point.hidden.len() {
            0 => "none".to_owned(),
            count => counted(count, "mode"),
        };
        grid.row([
            maybe(point.t),
            Cell::number(point.rank.to_string()),
            lie(point.t).map_or_else(|| Cell::number("–"), Cell::from),
            least.map_or_else(|| Cell::number("–"), |mode| Cell::number(eigenvalue(mode.eigenvalue))),
            maybe(least.map(|mode| mode.margin)),
            Cell::from(least.map(|mode| leading(&mode.words)).unwrap_or_default()),
            Cell::from(hidden),
        ])
    });
    grid.caption("Of the linearisation at each time, to working precision, and of the plant itself by its Lie derivatives; `study.json` has every mode.")
}

fn tone(verdict: DesignVerdict) -> Tone {
    if verdict.is_proved() {
        Tone::Good
    } else if verdict.is_refuted() {
        Tone::Bad
    } else {
        Tone::Open
    }
}

fn observer(section: Section, observer: &ObserverReport) -> Section {
    let mut section = section.heading(format!("{} ({})", observer.name, observer.kind));
    if let Some(failure) = &observer.failure {
        section = section.facts([("design", Cell::badge("not applicable", Tone::Failed))]).prose(&failure.hypothesis);
        if !failure.alternatives.is_empty() {
            let alternatives = failure.alternatives.iter().map(|alternative| alternative.words().to_owned());
            section = section.prose("Alternatives:").list(alternatives.collect::<Vec<_>>());
        }
        if !failure.hints.is_empty() {
            section = section.prose("Hints:").list(failure.hints.clone());
        }
    }
    match &observer.design {
        Some(design) => designed(section, design, observer.solver),
        None => section,
    }
}

fn designed(section: Section, design: &DesignReport, solver: Option<&str>) -> Section {
    let mut section = section.prose(design.statement.to_string());
    if let Some(evidence) = &design.evidence {
        section = section.prose(format!("Evidence: {evidence}."));
    }
    let mut facts = vec![("certificate".to_owned(), Cell::badge(design.verdict.word(), tone(design.verdict)))];
    for number in &design.numbers {
        facts.push((number.name.clone(), Cell::number(number.text())));
    }
    if !design.noise_deviation.is_empty() {
        let deviations = design.noise_deviation.iter().map(|x| short(*x)).collect::<Vec<_>>().join(", ");
        facts.push(("standard deviation of the error due to noise".to_owned(), Cell::number(deviations)));
    }
    if !design.poles.is_empty() {
        let poles = design.poles.iter().map(|pole| eigenvalue(*pole)).collect::<Vec<_>>().join(",  ");
        facts.push(("poles".to_owned(), Cell::number(poles)));
    }
    facts.extend(solver.map(|solver| ("solver".to_owned(), Cell::from(solver))));
    section = section.facts(facts);
    let shown = |matrix: &&NamedMatrix| matrix.name != "P" && matrix.name != "Q" && matrix.name != "S";
    section = matrices(section, design.matrices.iter().filter(shown));
    if design.facts.is_empty() {
        return section;
    }
    let (shown, folded) = design.leading_facts();
    let grid = shown.iter().fold(Grid::new(&["condition", "verdict", "result"]), |grid, fact| {
        grid.row([
            Cell::from(fact.statement.as_str()),
            Cell::badge(fact.verdict.word(), tone(fact.verdict)),
            Cell::from(fact.words.as_str()),
        ])
    });
    let mut caption = Vec::new();
    if folded > 0 {
        let count = design.facts.len();
        caption.push(format!("The {} smallest margins of {count} conditions; `study.json` has all.", shown.len()));
    }
    if design.facts.iter().any(|fact| fact.is_at_vertex) {
        caption.push(
            "A vertex (A, C) is a combination of extreme values of the entries of the Jacobians df/dx and dh/dx over the \
             region: what holds at all vertices holds for all Jacobians over the region."
                .to_owned(),
        );
    }
    let has = |equation: &str| design.facts.iter().any(|fact| fact.equation.as_deref() == Some(equation));
    match (has("(12)"), has("(13')")) {
        (true, true) => caption.push("(12) and (13') are their numbers in the paper on the cubic observer.".to_owned()),
        (true, false) => caption.push("(12) is its number in the paper on the cubic observer.".to_owned()),
        (false, true) => caption.push("(13') is its number in the paper on the cubic observer.".to_owned()),
        (false, false) => {}
    }
    section.grid(grid.caption(caption.join(" ")))
}

/// The maximal number of rows and columns of a matrix shown entry by entry.
const LARGEST: usize = 12;

/// The entries of a matrix with six digits, [`ABOUT_ZERO`] for one that is [`is_about_zero`].
fn entries(rows: &[Vec<f64>]) -> Vec<Vec<String>> {
    let text = |(x, about): (&f64, bool)| if about { ABOUT_ZERO.to_owned() } else { short(*x) };
    rows.iter().zip(is_about_zero(rows)).map(|(row, about)| row.iter().zip(about).map(text).collect()).collect()
}

/// Small matrices entry by entry; larger ones by their sizes.
fn matrices<'a>(section: Section, matrices: impl Iterator<Item = &'a NamedMatrix>) -> Section {
    let (mut formulas, mut large) = (Vec::new(), Vec::new());
    let mut about = false;
    for matrix in matrices {
        let (rows, columns) = (matrix.rows.len(), matrix.rows.first().map_or(0, Vec::len));
        if rows.max(columns) > LARGEST {
            large.push(format!("{} is {rows} x {columns}: see `study.json`.", matrix.name));
        } else {
            let rows = entries(&matrix.rows);
            about |= rows.iter().flatten().any(|entry| entry == ABOUT_ZERO);
            formulas.push(Formula::matrix(&matrix.name, &rows));
        }
    }
    let section = if formulas.is_empty() { section } else { section.formulas(formulas) };
    let section =
        if about { section.prose(format!("≈ 0: {ABOUT_ZERO_MEANS}; `study.json` has the digits.")) } else { section };
    if large.is_empty() { section } else { section.prose(large.join(" ")) }
}

/// The maximal number of states of which the scores are shown.
const SCORED: usize = 12;

fn scores(table: &ScoreTable, caption: &str) -> Grid {
    let head: Vec<&str> = table.head.iter().map(String::as_str).collect();
    let cell = |cell: &ScoreCell| match (cell.best, cell.number) {
        (true, _) => Cell::best(cell.text.as_str()),
        (false, true) => Cell::number(cell.text.as_str()),
        (false, false) => Cell::from(cell.text.as_str()),
    };
    let grid = table.rows.iter().fold(Grid::new(&head), |grid, row| grid.row(row.iter().map(cell)));
    match table.omitted {
        0 => grid.caption(caption),
        omitted => grid.caption(format!("{caption} `study.json` has the other {omitted} states.")),
    }
}

fn sweep(results: &Results, sweep: &SweepReport) -> Section {
    let mut section = Section::new("Sweep").prose(sweep.scoring.words.join(" "));
    if let Some(table) = sweep.table(&results.plant, SCORED) {
        section = section.grid(scores(
            &table,
            match sweep.ensemble {
                1 => "One run at each value.",
                _ => "Medians over the ensemble; in brackets the 5th and the 95th percentile.",
            },
        ));
    }
    let ended = sweep.ended();
    if ended.is_empty() { section } else { section.prose("Without a run, or ended early:").list(ended) }
}

fn comparison(results: &Results) -> Section {
    let mut section = Section::new("Comparison");
    if let Some(simulation) = &results.simulation {
        section = section.prose(
            simulation
                .truth
                .iter()
                .chain(&simulation.measurements)
                .chain(simulation.sampling.iter().map(|sampling| &sampling.words))
                .chain(&simulation.scoring.words)
                .cloned()
                .collect::<Vec<_>>()
                .join(" "),
        );
        if let Some(table) = simulation.norm_table(&results.plant) {
            section = section.grid(scores(&table, "Norm of the error; the best values are marked."));
        }
        match simulation.state_table(&results.plant, SCORED) {
            Some(table) => {
                let caption = "Error of each state, in its unit. Settling: the error stays within 5 % or 2 % of its \
                               initial value; overshoot: the largest error after its first change of sign.";
                section = section.grid(scores(&table, caption));
            }
            None => section = section.prose("No observer finished its run."),
        }
        if let Some(seed) = simulation.seed {
            section = section.prose(format!("The noise has the seed {seed}, the same for all."));
        }
        let ended: Vec<String> = simulation.ended().into_iter().chain(results.not_run()).collect();
        if !ended.is_empty() {
            section = section.prose("Ended early, or not run:").list(ended);
        }
    }
    if !results.intervals.is_empty() {
        section = log_section::intervals(section, &results.intervals, &results.plant);
    }
    if !results.filters.is_empty() {
        section = log_section::filters(section, &results.filters);
    }
    if let Some(log) = &results.log {
        section = log_section::log(section, log, &results.plant);
    }
    if !results.coverage.is_empty() {
        section = log_section::coverage(section, &results.coverage, &results.plant);
    }
    section
}
