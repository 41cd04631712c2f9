//! `report.html`: the results as an HTML page with interactive figures.

mod diagram;
mod experiment;
mod live;
mod summary;
mod terms;

use luenberger_expression::Formula as Typeset;
use luenberger_figures::{Cell, Figure, Formula, Grid, Report, Section};
use luenberger_live::Experiment;
use luenberger_live::page::{MODULE, SCRIPT, STYLE};

use super::Results;
use super::document::{self, comparison, matrices, number, observers, operating_point, short};
use crate::error::StudyError;
use crate::study::Study;

/// The ids of the figures for the summary, the first of them that there is: the norm of the error, on a log the errors
/// or, without true states, what the observers did not expect.
const FIRST: [&str; 3] = ["error-norm", "errors", "innovations"];

/// The page. `files` are the names of the files in its folder.
pub(crate) fn html(
    study: &Study,
    results: &Results,
    mut figures: Vec<(String, Figure)>,
    live: Option<&Result<(Experiment, Vec<String>), String>>,
    files: &[String],
) -> Result<String, StudyError> {
    // The answer, what was designed and proved, what the run gave, and what there is to look up.
    let main = FIRST.iter().find_map(|id| figures.iter().position(|(of, _)| of == id)).map(|k| figures.remove(k));
    let mut report = Report::new(&results.title).lead(&results.about).numbers_as(&[]);
    report = report.section(summary::section(results, main));
    if !results.warnings.is_empty() {
        report = report.section(Section::new("Warnings").list(results.warnings.clone()));
    }
    report = report.section(plant(study, results));
    if let Some(point) = &results.operating_point {
        report = report.section(operating_point(results, point));
    }
    if !results.observers.is_empty() {
        report = report.section(terms::section(observers(&results.observers), results));
    }
    if let Some(frequency) = &results.frequency {
        report = report.section(document::frequency(frequency, &results.plant));
    }
    if let Some(observability) = &results.observability {
        report = report.section(document::observability(observability));
    }
    if let Some(experiment) = experiment::section(study) {
        report = report.section(experiment);
    }
    if results.simulation.is_some() || results.log.is_some() {
        report = report.section(comparison(results, false));
    }
    match live {
        Some(Ok((experiment, omitted))) => {
            let section = live::section(experiment, omitted, &results.observers)?;
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
        report = report.section(document::sweep(results, sweep));
    }
    if let Some(sweep) = &results.sweep_on_log {
        report = report.section(document::sweep_on_log(results, sweep));
    }
    let links = files
        .iter()
        .filter(|name| {
            ["trajectories/", "frequency/", "certificates/", "sweep.csv"].iter().any(|folder| name.starts_with(folder))
        })
        .map(|name| (name.clone(), String::new()));
    let links: Vec<(String, String)> =
        std::iter::once(("study.json".to_owned(), "all numbers".to_owned())).chain(links).collect();
    report = report.section(Section::new("Files").links(links)).section(experiment::reproduction(study));
    report.html().map_err(|why| StudyError::Output { what: "report.html".to_owned(), why: why.to_string() })
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
