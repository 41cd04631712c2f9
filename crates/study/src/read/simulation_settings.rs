//! The tables around plant and observers: [input], [simulation], [log], [plot], [sweep].

use luenberger_expression::Scope;
use luenberger_linalg::{dlqr, lqr, place};
use luenberger_proof::certificate::MOST_MISSES;
use luenberger_proof::wording::counted;
use luenberger_sim::{BetweenRows, Estimates, Integrator, ScoreGrid, Settings, SimError};
use nalgebra::DMatrix;

use super::{Reported, plant};
use crate::maps::MapNames;
use crate::model::{Model, PlantModel};
use crate::reader::tree::Node;
use crate::reader::{Reader, check, gain, maps, region};
use crate::schema::QUANTITIES;
use crate::signal::{Input, Program};
use crate::study::{Estimated, GainSpec, Log, NoiseSpec, ObserverSpec, Plot, Quantity, SamplingSpec, Simulation};
use crate::table::LogColumns;

/// The input of `plant`, to which a feedback does not add what [estimate] adds to it; a law has the true values.
pub(super) fn input(
    node: Option<&Node>,
    (plant, with_parameters): (&PlantModel, &PlantModel),
    observers: Option<&[ObserverSpec]>,
    reader: &mut Reader,
) -> Option<Input> {
    let Some(node) = node else { return Some(Input::Zero) };
    let inputs = plant.inputs.len();
    if inputs == 0 {
        reader.absent(check::head(node), "[input], but the plant has no inputs", "expected no [input]");
        return None;
    }
    if node.entries().is_empty() {
        let expected = "expected `expressions`, `table`, `feedback` or `law`";
        reader.absent(node.span.clone(), "[input] is empty", expected);
        return None;
    }
    if let Some(entry) = node.entry("law") {
        return law(node, &entry.node, with_parameters, reader);
    }
    if let Some(entry) = node.entry("jumps") {
        return reader.refuse(entry.span.clone(), "`jumps` without a `law`", "expected a `law` that jumps then");
    }
    let signal = match (node.entry("expressions"), node.entry("table")) {
        (Some(_), Some(table)) => {
            reader.refuse(table.span.clone(), "`table` conflicts with `expressions`", "expected one of them")
        }
        (Some(entry), None) => {
            let count = entry.node.list()?.len();
            if count == inputs {
                // Names of states and inputs are known here too, so that the message can explain why they are not
                // allowed.
                let scope = Scope::time().named(&plant.states, &plant.inputs).unwrap_or_else(|_| Scope::time());
                plant::list(&entry.node, &scope, reader).map(|list| Some(Program::Expressions(list)))
            } else {
                let message =
                    format!("`expressions` has length {count}, and the plant has {}", counted(inputs, "input"));
                reader.refuse(
                    entry.node.span.clone(),
                    message,
                    format!("expected {} of t", counted(inputs, "expression")),
                )
            }
        }
        (None, Some(entry)) => {
            let linear = node.get("interpolation").and_then(Node::text) == Some("linear");
            super::csv::input(&entry.node, plant, linear, reader).map(|samples| Some(Program::Table(samples)))
        }
        (None, None) => Some(None),
    };
    if let (Some(entry), None) = (node.entry("interpolation"), node.get("table")) {
        return reader.refuse(
            entry.span.clone(),
            "`interpolation` without a `table`",
            "expected a `table` to interpolate",
        );
    }
    let feedback = node.given("feedback", |table| feedback(table, plant, observers, reader));
    Some(match (signal?, feedback?) {
        (None, None) => Input::Zero,
        (Some(program), None) => Input::Program(program),
        (reference, Some((gain, observer))) => Input::Feedback { observer, gain, reference },
    })
}

/// A control law with the true states.
fn law(node: &Node, law: &Node, plant: &PlantModel, reader: &mut Reader) -> Option<Input> {
    if let Some(other) = ["expressions", "table", "feedback"].iter().find_map(|key| node.entry(key)) {
        let message = format!("`{}` conflicts with `law`", other.key);
        return reader.refuse(other.span.clone(), message, "expected one of them");
    }
    if plant.dt.is_some() {
        return reader.refuse(law.span.clone(), "`law` is for plants in continuous time", "expected `feedback`");
    }
    let why = format!("the plant has {}", counted(plant.inputs.len(), "input"));
    let rows = maps::list(node, "law", (plant.inputs.len(), &why), MapNames::new(plant, 0).states(), reader)?;
    let mut jumps = node.get("jumps").map_or(Some(Vec::new()), Node::numbers)?;
    jumps.sort_by(f64::total_cmp);
    Some(Input::Law { law: rows, jumps })
}

/// Checks that the input is finite over the run, and that a table covers it.
pub(super) fn input_over(node: &Node, input: &Input, inputs: usize, simulation: &Simulation, reader: &mut Reader) {
    if let Err(error) = input.check(inputs, 0.0, simulation.duration) {
        let span = node.get("expressions").or(node.get("table")).unwrap_or(node).span.clone();
        let expected = format!("expected an input from t = 0 to t = {}", simulation.duration);
        reader.wrong(span, error.to_string(), expected);
    }
}

fn feedback(
    node: &Node,
    plant: &PlantModel,
    observers: Option<&[ObserverSpec]>,
    reader: &mut Reader,
) -> Option<(DMatrix<f64>, String)> {
    let k = feedback_gain(node, plant, reader);
    let name = node.get("observer")?;
    // Observers with mistakes are reported elsewhere; references to their names are not reported again.
    let names: Vec<String> = observers?.iter().map(|observer| observer.name.clone()).collect();
    reader.position(name, "observer", &names)?;
    Some((k?, name.text()?.to_owned()))
}

/// K as given, by poles, or by a quadratic cost.
fn feedback_gain(node: &Node, plant: &PlantModel, reader: &mut Reader) -> Option<DMatrix<f64>> {
    let (n, m) = (plant.states.len(), plant.inputs.len());
    let why = format!("the plant has {} and {}", counted(m, "input"), counted(n, "state"));
    let there: Vec<&str> = ["k", "poles", "lqr"].into_iter().filter(|key| node.get(key).is_some()).collect();
    let &[way] = there.as_slice() else {
        let message = match there.as_slice() {
            [first, second, ..] => format!("`{second}` conflicts with `{first}`"),
            _ => "the feedback has no gain".to_owned(),
        };
        return reader.refuse(check::head(node), message, "expected one of k, poles, lqr");
    };
    let entry = node.entry(way)?;
    if way == "k" {
        return reader.matrix(&entry.node, "k", (Some(m), Some(n)), &why);
    }
    let Some(linear) = plant.model.linear() else {
        let message = format!("`{way}` is for linear plants, and this one is not");
        return reader.refuse(entry.span.clone(), message, "expected `k`");
    };
    let found = if way == "poles" {
        let of_states = format!("the plant has {}", counted(n, "state"));
        let GainSpec::Poles(poles) = gain::poles(&entry.node, n, &of_states, reader)? else { return None };
        place(&linear.a, &linear.b, &poles).map(|placed| placed.gain)
    } else {
        let q = reader.weight(entry.node.get("q")?, "q", n, &why);
        let r = reader.weight(entry.node.get("r")?, "r", m, &why);
        let (q, r) = (q?, r?);
        if plant.dt.is_some() {
            dlqr(&linear.a, &linear.b, &q, &r).map(|found| found.k)
        } else {
            lqr(&linear.a, &linear.b, &q, &r).map(|found| found.k)
        }
    };
    found
        .map_err(|error| {
            reader.wrong(entry.span.clone(), error.to_string(), "expected a gain that exists, or `k`");
        })
        .ok()
}

pub(super) fn simulation(node: &Node, plant: &PlantModel, reader: &mut Reader) -> Option<Simulation> {
    let number = |key: &str, otherwise: f64| node.get(key).map_or(Some(otherwise), Node::number);
    let at = node.get("x0")?;
    let x0 = reader.numbers(at, "x0", plant.states.len(), "state")?;
    // An invalid duration is reported elsewhere; checks that depend on it are skipped.
    let duration = node.get("duration")?.number().filter(|duration| *duration > 0.0 && duration.is_finite())?;
    if let Model::Expressions(expressions, _) = &plant.model
        && let Err(error) = expressions.check_at(0.0, &x0, &vec![0.0; plant.inputs.len()])
    {
        let message = format!("the plant is not defined at x0: {error}");
        return reader.refuse(at.span.clone(), message, "expected a state where f, h and their derivatives are finite");
    }
    if let (Some(dt), Some(entry)) = (plant.dt, node.entry("hold"))
        && entry.node.number() != Some(dt)
    {
        let message = format!("`hold` differs from `dt` = {dt}: the input of a plant in discrete time is held for dt");
        return reader.refuse(entry.span.clone(), message, "expected no `hold`, or `dt`");
    }
    let integrator = match node.get("integrator").and_then(Node::text) {
        Some("explicit") => Integrator::Explicit,
        Some("implicit") => Integrator::Implicit,
        _ => Integrator::Auto,
    };
    let standard = Simulation::new(&x0, duration);
    let settings = Settings {
        integrator,
        rtol: number("rtol", standard.settings.rtol)?,
        atol: number("atol", standard.settings.atol)?,
        ..standard.settings
    };
    let noise = match node.get("noise") {
        None => None,
        Some(noise) => Some(NoiseSpec {
            gaussian: noise.get("distribution").and_then(Node::text) != Some("uniform"),
            amplitude: reader.numbers(noise.get("amplitude")?, "amplitude", plant.outputs.len(), "output")?,
            period: noise.get("period")?.number()?,
            seed: noise.get("seed").map_or(Some(0), Node::count)? as u64,
        }),
    };
    let sensors = super::sensor::sensors(node.get("sensor"), plant, noise.as_ref(), reader)?;
    let sampling = sampling(node.get("sampling"), noise.as_ref().map_or(0, |noise| noise.seed), reader)?;
    Some(Simulation {
        sensors,
        sampling,
        samples: node.get("samples").map_or(Some(standard.samples), Node::count)?,
        settings,
        hold: match node.get("hold") {
            Some(hold) => Some(hold.number()?),
            None => plant.dt,
        },
        band: number("band", standard.band)?,
        score_period: node.given("score_period", Node::number)?,
        estimates: estimates(node),
        hold_measurements: node.get("interpolation").and_then(Node::text) == Some("held"),
        scale: node.given("scale", |scale| reader.numbers(scale, "scale", plant.states.len(), "state"))?,
        noise,
        ..standard
    })
}

/// `[simulation.sampling]`, with the seed of the noise unless it has its own.
fn sampling(node: Option<&Node>, seed: u64, reader: &mut Reader) -> Option<SamplingSpec> {
    let Some(node) = node else { return Some(SamplingSpec { seed, ..SamplingSpec::default() }) };
    let jitter = match node.get("jitter") {
        None => None,
        Some(jitter) => {
            let (shortest, longest) = region::bound(jitter)?;
            if !(shortest > 0.0 && longest.is_finite()) {
                let message = format!("`jitter` is from {shortest} to {longest}");
                return reader.refuse(jitter.span.clone(), message, "expected positive, finite bounds");
            }
            Some((shortest, longest))
        }
    };
    let misses = node.given("misses", Node::count)?;
    if let (Some(misses), Some(entry)) = (misses.filter(|misses| *misses > MOST_MISSES), node.entry("misses")) {
        return reader.refuse(
            entry.node.span.clone(),
            format!("`misses` is {misses}"),
            format!("expected at most {MOST_MISSES}"),
        );
    }
    let seed = node.get("seed").map_or(Some(seed as usize), Node::count)? as u64;
    Some(SamplingSpec { jitter, misses, seed })
}

/// Checks that `[simulation.sampling]` concerns an observer.
pub(super) fn sampling_used(node: &Node, observers: &[ObserverSpec], reader: &mut Reader) {
    if let (Some(entry), false) =
        (node.entry("sampling"), observers.iter().any(|observer| observer.kind.varying_periods().is_some()))
    {
        let message = "[simulation.sampling], but no observer has `jitter` or `misses`";
        reader.wrong(entry.span.clone(), message, "expected an observer of the kind sampled-cubic with one of them");
    }
}

/// Checks that there are instants at which all observers can be scored.
pub(super) fn score_grid(node: &Node, simulation: &Simulation, observers: &[ObserverSpec], reader: &mut Reader) {
    let periods: Vec<Option<f64>> = observers.iter().map(|observer| observer.kind.fixed_period()).collect();
    let Some(period) = simulation.score_period else {
        // A period that is not positive is reported at its own key.
        if let Err(error @ SimError::NoCommonGrid { .. }) = ScoreGrid::common(&periods, simulation.duration) {
            let expected = "expected `score_period`, at which each observer is scored by its last sample";
            reader.wrong(check::head(node), error.to_string(), expected);
        }
        return;
    };
    let longest = periods.into_iter().flatten().fold(0.0, f64::max);
    if let (Some(entry), true) = (node.get("score_period"), period < longest * (1.0 - 1e-9)) {
        let message = format!("`score_period` is {period}, finer than the samples of an observer, every {longest}");
        let expected = format!("expected at least {longest}: between samples an estimate is not defined");
        reader.wrong(entry.span.clone(), message, expected);
    }
}

pub(super) fn log(node: &Node, (plant, estimated): (&PlantModel, &[Estimated]), reader: &mut Reader) -> Option<Log> {
    let mut columns = |key: &str, names: &[String], what: &str| {
        let Some(list) = node.get(key) else { return Some(names.to_vec()) };
        let given: Vec<String> = list.texts()?.into_iter().map(str::to_owned).collect();
        if given.len() != names.len() {
            let message = format!(
                "`{key}` has {}, and the plant has {}",
                counted(given.len(), "column"),
                counted(names.len(), what)
            );
            return reader.refuse(list.span.clone(), message, format!("expected {}", counted(names.len(), "column")));
        }
        Some(given)
    };
    let (inputs, outputs) = (columns("inputs", &plant.inputs, "input"), columns("outputs", &plant.outputs, "output"));
    let variances = node.given("variances", |_| columns("variances", &plant.outputs, "output"))?;
    let states = node.given("states", |_| columns("states", &plant.states, "state"))?;
    if let (Some(outputs), Some(list)) = (&outputs, node.get("outputs")) {
        let again = (0..outputs.len()).find_map(|j| Some((outputs[..j].iter().position(|of| *of == outputs[j])?, j)));
        if let Some((first, second)) = again {
            let (one, other) = (&plant.outputs[first], &plant.outputs[second]);
            let message = format!("the outputs {one} and {other} are both the column {:?}", outputs[first]);
            return reader.refuse(
                list.span.clone(),
                message,
                "expected a column for each: one measurement would count twice",
            );
        }
    }
    let known = |name: String| (name != "-").then_some(name);
    let columns = LogColumns {
        time: node.get("time").map_or(Some("t"), Node::text)?.to_owned(),
        inputs: inputs?,
        outputs: outputs?,
    };
    // The true values of parameters are in no column.
    let unknown = || estimated.iter().map(|_| None);
    let states = states.map(|states| states.into_iter().map(known).chain(unknown()).collect());
    let variances = variances.map(|columns| columns.into_iter().map(known).collect());
    let between = match node.get("interpolation").and_then(Node::text) {
        Some("linear") => BetweenRows::Linear,
        Some("held") => BetweenRows::Held,
        _ => BetweenRows::Predicted,
    };
    let every_row = node.get("repeats").and_then(Node::text) == Some("measured");
    let known = (&columns, &states, &variances);
    let log = super::csv::log(node.get("file")?, known, (between, estimates(node)), every_row, reader)?;
    if let (Some(variances), Some(list)) = (&log.variances, node.get("variances")) {
        let (rows, outputs) = variances.values().shape();
        let places = (0..outputs).flat_map(|j| (0..rows).map(move |k| (k, j)));
        let wrong = places.filter_map(|(k, j)| Some((k, j, variances.value(k, j)?))).find(|(.., value)| *value <= 0.0);
        if let Some((k, j, value)) = wrong {
            let (t, name) = (variances.times()[k], &plant.outputs[j]);
            let message = format!("the variance of {name} is {value} at t = {t}");
            return reader.refuse(list.span.clone(), message, "expected positive numbers, or none");
        }
    }
    Some(log)
}

/// Which estimates of filters are scored.
fn estimates(node: &Node) -> Estimates {
    match node.get("estimates").and_then(Node::text) {
        Some("predicted") => Estimates::Predicted,
        _ => Estimates::Filtered,
    }
}

pub(super) fn plot(
    node: Option<&Node>,
    plant: &PlantModel,
    observers: Option<&[ObserverSpec]>,
    reader: &mut Reader,
) -> Option<Plot> {
    let Some(node) = node else { return Some(Plot::default()) };
    let show = match node.get("show") {
        None => None,
        Some(show) => {
            let one = |name: &str| {
                let all = [
                    Quantity::States,
                    Quantity::Errors,
                    Quantity::ErrorNorm,
                    Quantity::Inputs,
                    Quantity::Outputs,
                    Quantity::Innovations,
                ];
                QUANTITIES.iter().position(|(known, _)| *known == name).map(|k| all[k])
            };
            Some(show.texts()?.into_iter().map(one).collect::<Option<Vec<_>>>()?)
        }
    };
    let states = match node.get("states") {
        None => None,
        Some(list) => {
            let found: Vec<Option<usize>> =
                list.list()?.iter().map(|name| reader.position(name, "state", &plant.states)).collect();
            Some(found.into_iter().collect::<Option<Vec<_>>>()?)
        }
    };
    let named = named(node, observers, reader).ok()?;
    let end = |key: &str| node.given(key, Node::number);
    let (from, to) = (end("from")?, end("to")?);
    if let (Some(from), Some(to), Some(entry)) = (from, to, node.entry("to"))
        && to <= from
    {
        return reader.refuse(
            entry.node.span.clone(),
            format!("the figures go from {from} to {to}"),
            "expected from < to",
        );
    }
    Some(Plot { show, states, observers: named, from, to })
}

/// The names under the key `observers`, each of which must exist; `None` without the key.
pub(super) fn named(
    node: &Node,
    observers: Option<&[ObserverSpec]>,
    reader: &mut Reader,
) -> Result<Option<Vec<String>>, Reported> {
    let (Some(list), Some(observers)) = (node.get("observers"), observers) else { return Ok(None) };
    let known: Vec<String> = observers.iter().map(|observer| observer.name.clone()).collect();
    let list = list.list().ok_or(Reported)?;
    let found: Vec<Option<usize>> = list.iter().map(|name| reader.position(name, "observer", &known)).collect();
    let found: Vec<usize> = found.into_iter().collect::<Option<_>>().ok_or(Reported)?;
    Ok(Some(found.into_iter().map(|k| known[k].clone()).collect()))
}
