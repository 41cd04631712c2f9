//! The experiment of a study: inputs, initial states, noise, times; and what reproduces it.

use luenberger_expression::Formula as Typeset;
use luenberger_figures::{Cell, Formula, Grid, Section};

use super::super::document::{number, short, with_unit};
use super::typeset;
use crate::digest;
use crate::model::Model;
use crate::signal::{Input, Program};
use crate::study::{Simulation, Study};

/// Inputs, times, noise, x(0) and the initial estimates; none for a study without a simulation.
pub(super) fn section(study: &Study) -> Option<Section> {
    let simulation = study.simulation.as_ref()?;
    let unit = study.plant.time_unit.as_deref().map_or_else(String::new, |unit| format!(" {unit}"));
    let mut facts = vec![
        ("time", format!("0 to {}{unit}, {} samples", short(simulation.duration), simulation.samples)),
        ("input", input(study)),
    ];
    if let Some(hold) = simulation.hold {
        facts.push(("input held for", format!("{}{unit}", short(hold))));
    }
    facts.extend(noise(study, simulation, &unit).map(|noise| ("measurement noise", noise)));
    if study.plant.dt.is_none() {
        let settings = &simulation.settings;
        facts.push((
            "tolerances of the integrator",
            format!("{} relative, {} absolute", short(settings.rtol), short(settings.atol)),
        ));
    }
    let section = Section::new("Experiment").facts(facts);
    let section = match programs(&study.input) {
        Some(formulas) => section.formulas(
            study
                .plant
                .inputs
                .iter()
                .zip(formulas)
                .map(|(name, formula)| typeset(Typeset::name(name).equals(&formula))),
        ),
        None => section,
    };
    Some(section.grid(starts(study, simulation)))
}

fn input(study: &Study) -> String {
    let reference = |program: &Option<Program>| if program.is_some() { "r(t) " } else { "" };
    match &study.input {
        Input::Zero if study.plant.inputs.is_empty() => "none".to_owned(),
        Input::Zero => "0".to_owned(),
        Input::Program(Program::Expressions(_)) => "as below".to_owned(),
        Input::Program(Program::Table(_)) => "from a table".to_owned(),
        Input::Feedback { observer, reference: r, .. } => {
            format!("{}- K xhat, with the estimate of {observer}", reference(r))
        }
        Input::Law { .. } => "a law with the true states, as below".to_owned(),
        Input::StateFeedback { reference: r, .. } => format!("{}- K x, with the true state", reference(r)),
    }
}

/// The expressions of the input.
fn programs(input: &Input) -> Option<Vec<Typeset>> {
    match input {
        Input::Program(Program::Expressions(rows)) | Input::Law { law: rows, .. } => {
            Some(rows.iter().map(luenberger_expression::Expression::formula).collect())
        }
        _ => None,
    }
}

/// The noise of each output in words.
fn noise(study: &Study, simulation: &Simulation, unit: &str) -> Option<String> {
    let of = |(output, name): (usize, &String)| {
        let noise = simulation.noise_of(output)?;
        let form = if noise.gaussian { "Gaussian, standard deviation" } else { "uniform, at most" };
        let amplitude = study.plant.measured(name, short(noise.amplitude));
        Some(format!("{name}: {form} {amplitude}, a new value every {}{unit}", short(noise.period)))
    };
    let words: Vec<String> = study.plant.outputs.iter().enumerate().filter_map(of).collect();
    let seed = simulation.noise.as_ref().map_or_else(String::new, |noise| format!("; seed {}", noise.seed));
    (!words.is_empty()).then(|| words.join("; ") + &seed)
}

/// The largest number of states in the table of initial values.
const SHOWN: usize = 12;

/// x(0) and the initial estimates, a row each.
fn starts(study: &Study, simulation: &Simulation) -> Grid {
    let states = study.plant.states.len().min(SHOWN);
    let names = study.plant.states.iter().take(states);
    let head: Vec<String> = names.map(|name| with_unit(name, study.plant.unit(name))).collect();
    let head: Vec<&str> = std::iter::once("at t = 0").chain(head.iter().map(String::as_str)).collect();
    let row = |name: &str, values: &[f64]| -> Vec<Cell> {
        std::iter::once(Cell::from(name)).chain(values.iter().take(states).map(|x| number(*x))).collect()
    };
    let grid = Grid::new(&head).row(row("plant", &simulation.x0));
    let grid = study.observers.iter().fold(grid, |grid, observer| {
        let mut values = observer.initial.clone();
        values.resize(study.plant.states.len(), 0.0);
        grid.row(row(&observer.name, &values))
    });
    match study.plant.states.len() - states {
        0 => grid,
        more => grid.caption(format!("The first {states} states; the study file has the other {more}.")),
    }
}

/// Version, digest and text of the study: the report contains what it was computed from.
pub(super) fn reproduction(study: &Study) -> Section {
    let text = study.source.text();
    let mut facts = vec![
        ("computed by".to_owned(), format!("luenberger {}", env!("CARGO_PKG_VERSION"))),
        ("study".to_owned(), study.file_name()),
        ("SHA-256 of the study".to_owned(), digest::sha256(text.as_bytes())),
    ];
    facts.extend(study.files.iter().map(|file| (format!("SHA-256 of {}", file.name), file.sha256.clone())));
    Section::new("Reproduction").facts(facts).folded("The study file", Section::new("").verbatim(text.trim_end()))
}

/// Formulas of the plant's equations; none for a nonlinear plant of the library.
pub(super) fn equations(study: &Study) -> Option<Vec<Formula>> {
    let names = &study.plant;
    let plant = match &names.model {
        Model::Linear(plant) => {
            let product = |matrix: &str, vector: &str| Formula {
                mathml: format!("<mi>{matrix}</mi><mo>&#x2062;</mo><mi>{vector}</mi>"),
                latex: format!("{matrix} {vector}"),
            };
            let sum = |left: Typeset, first: &str, second: Option<&str>| {
                let (left, first) = (typeset(left), product(first, "x"));
                let second = second.map(|matrix| product(matrix, "u"));
                let (mathml, latex) = second
                    .map_or_else(Default::default, |s| (format!("<mo>+</mo>{}", s.mathml), format!(" + {}", s.latex)));
                Formula {
                    mathml: format!("{}<mo>=</mo>{}{mathml}", left.mathml, first.mathml),
                    latex: format!("{} = {}{latex}", left.latex, first.latex),
                }
            };
            let motion = sum(Typeset::motion("x", names.dt.is_some()), "A", (!names.inputs.is_empty()).then_some("B"));
            return Some(vec![motion, sum(Typeset::name("y"), "C", plant.d.as_ref().map(|_| "D"))]);
        }
        Model::Expressions(plant, _) => plant,
        Model::Builtin(_) => return None,
    };
    let f = names.states.iter().zip(plant.f());
    let f = f.map(|(name, row)| Typeset::motion(name, names.dt.is_some()).equals(&row.formula()));
    let h = names.outputs.iter().zip(plant.h()).enumerate().map(|(k, (name, row))| {
        let left = if row.text() == name { Typeset::name(&format!("y{}", k + 1)) } else { Typeset::name(name) };
        left.equals(&row.formula())
    });
    Some(f.chain(h).map(typeset).collect())
}
