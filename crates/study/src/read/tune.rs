//! The table [tune].

use luenberger_expression::nearest;
use luenberger_proof::wording::shortest;
use nalgebra::DMatrix;

use super::advise::MOST_HELD_OUT;
use super::simulation_settings;
use super::tuned::{noise_node, order_of, place_of};
use crate::diagnostic::Diagnostic;
use crate::kinds::{Kalman, Kind, kind_of};
use crate::model::PlantModel;
use crate::reader::Reader;
use crate::reader::check;
use crate::reader::tree::{Entry, Node, Value};
use crate::study::{Estimated, GainSpec, Log, ObserverSpec, Part, Tunable, TuneCriterion, TuneSpec, Tuned};

pub(super) fn tune(
    (root, node): (&Node, &Node),
    (plant, estimated, observers, log): (&PlantModel, &[Estimated], Option<&[ObserverSpec]>, Option<&Log>),
    reader: &mut Reader,
) -> Option<TuneSpec> {
    let Some(table) = root.get("log") else {
        reader.absent(check::head(node), "[tune] without a [log]", "expected a [log] to fit");
        return None;
    };
    let (log, observers) = (log?, observers?);
    let names: Vec<String> = observers.iter().map(|observer| observer.name.clone()).collect();
    let at = node.get("observer")?;
    let observer = &observers[reader.position(at, "observer", &names)?];
    let criterion = criterion(node, (observer, observers), (plant, log), reader)?;
    if !plant.delays.is_empty() && !kind_of(&observer.kind).is_some_and(Kind::takes_delays) {
        let message = format!(
            "outputs are measured late ({}), and the kind {} takes a reading for one of now",
            plant.late_outputs(),
            observer.kind.name()
        );
        let expected = "expected extended-kalman, iterated-extended-kalman or ukf, or a log in which the late columns stand at their times, without `delays`";
        return reader.refuse(at.span.clone(), message, expected);
    }
    let list = node.get("parameters")?;
    let known = known(root, (plant, estimated), observer)?;
    let mut parameters = Vec::<Tuned>::new();
    for entry in list.list()? {
        for found in named((entry, &known), (plant, observer), reader)? {
            if parameters.iter().any(|other| other.name == found.name) {
                let message = format!("{} is named twice", found.name);
                return reader.refuse(entry.span.clone(), message, "expected each number once");
            }
            parameters.push(found);
        }
    }
    for entry in node.get("bounds").map(Node::entries).unwrap_or_default() {
        bounded(entry, &mut parameters, reader)?;
    }
    // An entry of a matrix that is 0 is moved in units of the others.
    let has_unit = |one: &Tuned| match &one.what {
        Tunable::Bias(_) => true,
        Tunable::Own(key, Part::Cell(..)) => parameters
            .iter()
            .any(|other| matches!(&other.what, Tunable::Own(of, Part::Cell(..)) if of == key && other.value != 0.0)),
        _ => false,
    };
    for one in parameters.iter().filter(|one| one.bounds.is_none()) {
        if matches!(one.what, Tunable::Delay(_)) {
            let message =
                format!("{} has no bounds, and what arrives within the longest delay is not fitted", one.name);
            let expected = format!("expected the shortest and the longest delay as {:?} in `bounds`", one.name);
            return reader.refuse(list.span.clone(), message, expected);
        }
        if one.value == 0.0 && !has_unit(one) {
            let message = format!("{} is 0 in the study, which is no start of a search without bounds", one.name);
            let expected = format!("expected a value that is not 0, or {:?} in `bounds`", one.name);
            return reader.refuse(list.span.clone(), message, expected);
        }
    }
    let held_out = node.get("held_out").map_or(Some(0.3), Node::number)?;
    if held_out > MOST_HELD_OUT {
        let message = format!("`held_out` is {held_out}");
        return reader.refuse(
            node.get("held_out")?.span.clone(),
            message,
            format!("expected a share from 0 to {MOST_HELD_OUT}"),
        );
    }
    let file = table.get("file")?.text()?.to_owned();
    let mut logs = vec![(file, log.clone())];
    for entry in node.get("files").and_then(Node::list).unwrap_or_default() {
        let name = entry.text()?.to_owned();
        if logs.iter().any(|(other, _)| *other == name) {
            let message = format!("the log {name:?} is named twice");
            return reader.refuse(entry.span.clone(), message, "expected each log once");
        }
        logs.push((name, simulation_settings::log(&with_file(table, entry), (plant, estimated), reader)?));
    }
    let count = |key: &str, default: usize| node.get(key).map_or(Some(default), Node::count);
    Some(TuneSpec {
        observer: observer.name.clone(),
        criterion,
        parameters,
        logs,
        held_out,
        starts: count("starts", 3)?,
        seed: count("seed", 0)? as u64,
        profile: count("profile", 4)?,
    })
}

/// What the fit is by: what the study says, or what the observer and the log allow.
fn criterion(
    node: &Node,
    (observer, observers): (&ObserverSpec, &[ObserverSpec]),
    (plant, log): (&PlantModel, &Log),
    reader: &mut Reader,
) -> Option<TuneCriterion> {
    let given = node.get("criterion");
    let named = given.and_then(Node::text).and_then(TuneCriterion::named);
    let refused = without_likelihood(observer, plant);
    match (named, refused) {
        (None, Some(WithoutLikelihood::NoCovariance)) if log.truth.is_some() => Some(TuneCriterion::Errors),
        (None, Some(WithoutLikelihood::NoCovariance)) | (Some(TuneCriterion::Innovations), _) => {
            Some(TuneCriterion::Innovations)
        }
        (None | Some(TuneCriterion::Likelihood), None) => Some(TuneCriterion::Likelihood),
        (None | Some(TuneCriterion::Likelihood), Some(refused)) => {
            let message = format!(
                "the innovations of {:?}, of the kind {}, have no likelihood{}",
                observer.name,
                observer.kind.name(),
                refused.why()
            );
            let known = observers.iter().filter(|other| without_likelihood(other, plant).is_none());
            let known: Vec<String> = known.map(|other| format!("{:?}", other.name)).collect();
            let expected = if let Some(instead) = refused.instead(plant) {
                instead
            } else if known.is_empty() {
                "expected a filter that computes the covariance of its innovations, and no observer of this study does; or criterion = \"innovations\""
                    .to_owned()
            } else {
                let known = known.join(", ");
                format!(
                    "expected a filter that computes the covariance of its innovations: {known}; or criterion = \"innovations\""
                )
            };
            reader.refuse(given.or(node.get("observer"))?.span.clone(), message, expected)
        }
        (Some(TuneCriterion::Errors), _) if log.truth.is_none() => {
            let message = "criterion = \"errors\", and the log has no column of a true state";
            let expected = "expected `states` in [log], or criterion = \"innovations\"";
            reader.refuse(given?.span.clone(), message, expected)
        }
        (Some(TuneCriterion::Errors), _) => Some(TuneCriterion::Errors),
    }
}

/// Why the innovations of an observer have no likelihood.
#[derive(Clone, Copy, PartialEq)]
enum WithoutLikelihood {
    /// It computes no covariance.
    NoCovariance,
    /// It is stationary, and in continuous time: V is an intensity.
    Intensity,
    /// It is stationary, and takes an angle as a number.
    Angle,
    /// It is stationary, and its noises are correlated.
    Correlated,
}

/// None if they have one.
fn without_likelihood(observer: &ObserverSpec, plant: &PlantModel) -> Option<WithoutLikelihood> {
    let noises = observer.kind.of::<Kalman>().and_then(|of| match &of.0.gain {
        GainSpec::Kalman(noises) => Some(noises),
        _ => None,
    });
    match noises {
        Some(noises) if noises.s.is_some() => Some(WithoutLikelihood::Correlated),
        Some(_) if plant.dt.is_none() => Some(WithoutLikelihood::Intensity),
        Some(_) if plant.turns_of(&plant.outputs).is_some() => Some(WithoutLikelihood::Angle),
        _ => (!observer.kind.has_likelihood(plant.dt)).then_some(WithoutLikelihood::NoCovariance),
    }
}

impl WithoutLikelihood {
    fn why(self) -> &'static str {
        match self {
            Self::NoCovariance => "",
            Self::Intensity => ": in continuous time its V is an intensity, and a sample has no covariance",
            Self::Angle => {
                ": it takes the difference of an angle and its estimate as it is, so that a full turn is an error"
            }
            Self::Correlated => ": its process and measurement noise are correlated",
        }
    }

    /// What to write in its place, if another kind is the same filter.
    fn instead(self, plant: &PlantModel) -> Option<String> {
        match self {
            Self::NoCovariance => None,
            Self::Intensity => Some(
                "expected the same filter as kind = \"extended-kalman\": w as it is, v = the intensity over the sampling period, and period".to_owned(),
            ),
            Self::Angle => Some(format!(
                "expected the same filter as kind = \"extended-kalman\", which wraps angles: w and v as they are, and period = {}",
                plant.dt.map(shortest).unwrap_or_default()
            )),
            Self::Correlated => Some(match plant.dt {
                Some(dt) => format!(
                    "expected the same filter as kind = \"extended-kalman\": w, v and s as they are, and period = {}",
                    shortest(dt)
                ),
                None => "expected kind = \"extended-kalman\" with w and v, without s".to_owned(),
            }),
        }
    }
}

/// The table of the log with another file.
fn with_file(table: &Node, file: &Node) -> Node {
    let entry =
        |entry: &Entry| if entry.key == "file" { Entry { node: file.clone(), ..entry.clone() } } else { entry.clone() };
    Node { span: table.span.clone(), value: Value::Table(table.entries().iter().map(entry).collect()) }
}

/// Names, each with the numbers that it stands for.
type Known = Vec<(String, Vec<Tuned>)>;

/// Everything that can be fitted.
fn known(root: &Node, (plant, estimated): (&PlantModel, &[Estimated]), observer: &ObserverSpec) -> Option<Known> {
    let own = root.at(&place_of(root, &observer.name)?)?;
    let mut known = Known::new();
    let (n, p) = (plant.states.len(), plant.outputs.len());
    for key in ["w", "v", "p0"] {
        if key == "p0" && observer.kind.period().is_none() {
            continue;
        }
        let (states, outputs) = (plant.states.clone(), plant.outputs.clone());
        let numbered = |count: usize| (1..=count).map(|k| k.to_string()).collect::<Vec<_>>();
        let node = noise_node(own, key);
        // Other kinds than filters have no noises unless they are given.
        if node.is_none() && !observer.kind.has_likelihood(plant.dt) {
            continue;
        }
        let order = order_of(own, key, (n, p));
        // Noise that enters by a matrix G has entries without a name.
        let names = match key {
            "v" => outputs,
            "w" if noise_node(own, "g").is_some() => numbered(order),
            _ => states,
        };
        // Expressions are no numbers that are fitted.
        let Some(matrix) = node.map_or_else(|| Some(DMatrix::identity(order, order)), |node| weight(node, order))
        else {
            continue;
        };
        let one = |(i, name): (usize, &String)| Tuned {
            what: match key {
                "w" => Tunable::W(i),
                "v" => Tunable::V(i),
                _ => Tunable::P0(i),
            },
            name: format!("{key}[{name}]"),
            value: matrix[(i, i)],
            bounds: None,
        };
        let mut all: Vec<Tuned> = names.iter().enumerate().map(one).collect();
        // A coloured noise has numbers of its own.
        all.extend(estimated.iter().enumerate().filter(|(_, one)| one.noise.is_none()).filter_map(|(k, one)| {
            let (what, value) = match key {
                "w" => (Tunable::W(order + k), one.w),
                "p0" => (Tunable::P0(order + k), one.p0),
                _ => return None,
            };
            Some(Tuned { what, name: format!("{key}[{}]", one.name), value, bounds: None })
        }));
        known.extend(all.iter().map(|one| (one.name.clone(), vec![one.clone()])));
        known.push((key.to_owned(), all.into_iter().filter(|one| one.value > 0.0).collect()));
    }
    for (name, value) in &plant.parameters {
        let what = Tunable::Parameter(name.clone());
        known.push((name.clone(), vec![Tuned { what, name: name.clone(), value: *value, bounds: None }]));
    }
    for (one, noise) in estimated.iter().filter_map(|one| Some((one, one.noise?))) {
        let name = &one.name;
        for (name, what, value) in [
            (format!("deviation[{name}]"), Tunable::Deviation(name.clone()), noise.deviation),
            (format!("tau[{name}]"), Tunable::CorrelationTime(name.clone()), noise.tau),
        ] {
            known.push((name.clone(), vec![Tuned { what, name, value, bounds: None }]));
        }
    }
    for j in 0..p {
        let name = format!("bias[{}]", plant.outputs[j]);
        known.push((name.clone(), vec![Tuned { what: Tunable::Bias(j), name, value: 0.0, bounds: None }]));
    }
    for key in observer.kind.free_keys() {
        let Some(all) = own.get(key).and_then(|node| super::own::numbers(key, node, plant.dt)) else { continue };
        let is_one = matches!(&all[..], [one] if one.name == *key);
        known.extend(all.iter().filter(|_| !is_one).map(|one| (one.name.clone(), vec![one.clone()])));
        known.push(((*key).to_owned(), all));
    }
    // That of a plant in discrete time is a multiple of its period, which no search varies.
    let delays = root.get("plant")?.get("delays").map(Node::entries).unwrap_or_default();
    for entry in delays.iter().filter(|_| plant.dt.is_none()) {
        let j = plant.outputs.iter().position(|output| *output == entry.key)?;
        let (name, value) = (format!("delay[{}]", entry.key), entry.node.number()?);
        known.push((name.clone(), vec![Tuned { what: Tunable::Delay(j), name, value, bounds: None }]));
    }
    // A parameter that is an expression of others follows from them.
    let texts: Vec<&str> = root
        .get("plant")?
        .get("parameters")
        .map(Node::entries)
        .unwrap_or_default()
        .iter()
        .filter(|entry| entry.node.number().is_none())
        .map(|entry| entry.key.as_str())
        .collect();
    known.retain(|(name, _)| !texts.contains(&name.as_str()));
    Some(known)
}

/// A weight that was read without a mistake.
pub(super) fn weight(node: &Node, order: usize) -> Option<DMatrix<f64>> {
    if let Some(x) = node.number() {
        return Some(DMatrix::identity(order, order) * x);
    }
    let matrix = match node.numbers() {
        Some(diagonal) => DMatrix::from_diagonal(&diagonal.into()),
        None => crate::reader::rows_of(node)?,
    };
    (matrix.shape() == (order, order)).then_some(matrix)
}

/// What a name stands for.
fn named(
    (entry, known): (&Node, &Known),
    (plant, observer): (&PlantModel, &ObserverSpec),
    reader: &mut Reader,
) -> Option<Vec<Tuned>> {
    let name = entry.text()?;
    if let Some((_, found)) = known.iter().find(|(known, _)| known == name) {
        if found.is_empty() {
            let message = format!("`{name}` has no positive entry in its diagonal");
            return reader.refuse(entry.span.clone(), message, "expected a variance that is positive in the study");
        }
        return Some(found.clone());
    }
    let names = || known.iter().map(|(name, _)| name.as_str());
    let message = format!("`parameters` has {name:?}, which cannot be fitted");
    let expected = format!("expected one of {}", names().collect::<Vec<_>>().join(", "));
    let mut mistake = Diagnostic::new(entry.span.clone(), message, expected);
    let free = observer.kind.free_keys();
    if name.starts_with("delay[") {
        mistake = mistake.help(match plant.dt {
            Some(_) => "a delay of a plant in discrete time is a multiple of `dt`, which no search varies: fit a study for each of a few, and compare their log-likelihoods",
            None => "a delay is fitted where `delays` in [plant] has one",
        });
    } else if free.contains(&name) {
        mistake = mistake.help(format!("{:?} has no `{name}` in the study", observer.name));
    } else if let Some(near) = nearest(name, names()) {
        mistake = mistake.help(format!("the nearest is {near:?}"));
    }
    reader.mistakes.push(mistake);
    None
}

/// Puts bounds to a parameter, or to all of a name.
fn bounded(entry: &Entry, parameters: &mut [Tuned], reader: &mut Reader) -> Option<()> {
    let [low, high] = entry.node.numbers()?[..] else { return None };
    let of = |one: &&mut Tuned| one.name == entry.key || one.name.starts_with(&format!("{}[", entry.key));
    let mut found: Vec<&mut Tuned> = parameters.iter_mut().filter(of).collect();
    if found.is_empty() {
        let message = format!("`bounds` has {:?}, which is not among the parameters", entry.key);
        return reader.refuse(entry.span.clone(), message, "expected a name in `parameters`");
    }
    for one in &mut found {
        let is_right = low < high && low.is_finite() && high.is_finite();
        if !is_right || !(low..=high).contains(&one.value) {
            let message = format!("the bounds of {} are [{low}, {high}], and its value is {}", one.name, one.value);
            return reader.refuse(entry.node.span.clone(), message, "expected finite bounds around the value");
        }
        if one.what.is_positive() && low <= 0.0 {
            let message = format!("the lower bound of {} is {low}", one.name);
            return reader.refuse(entry.node.span.clone(), message, "expected a positive number");
        }
        if matches!(one.what, Tunable::Delay(_)) && low < 0.0 {
            let message = format!("the lower bound of {} is {low}", one.name);
            return reader.refuse(entry.node.span.clone(), message, "expected 0 or more");
        }
        one.bounds = Some((low, high));
    }
    Some(())
}
