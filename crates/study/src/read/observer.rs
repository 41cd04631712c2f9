//! The tables [[observer]].

use luenberger_plants::Dimensions;
use luenberger_proof::wording::counted;

use crate::diagnostic::Source;
use crate::kinds;
use crate::model::PlantModel;
use crate::reader::tree::Node;
use crate::reader::{Given, Reader, check, disturbance};
use crate::study::{Estimated, GainLimits, ObserverKind, ObserverSpec};

/// The observers; none if one has mistakes.
pub(super) fn observers(
    root: &Node,
    plant: (&PlantModel, &[Estimated]),
    start: &[f64],
    source: &Source,
    reader: &mut Reader,
) -> Option<Vec<ObserverSpec>> {
    let Some(list) = root.get("observer") else { return Some(Vec::new()) };
    let read: Vec<Option<ObserverSpec>> =
        list.list()?.iter().map(|node| observer(node, plant, start, (root, source), reader)).collect();
    let observers: Vec<ObserverSpec> = read.into_iter().collect::<Option<_>>()?;
    names(&observers, list, root, reader).then_some(observers)
}

/// Checks that each observer has a name of its own, which can also name its files.
fn names(observers: &[ObserverSpec], list: &Node, root: &Node, reader: &mut Reader) -> bool {
    // The run on a log is written to `log-NAME`, beside that of the simulation.
    let prefixes: &[&str] = match (root.get("simulation"), root.get("log")) {
        (Some(_), Some(_)) => &["", "log-"],
        _ => &[""],
    };
    let before = reader.mistakes.len();
    let mut taken: Vec<(String, &str)> = Vec::new();
    for (observer, node) in observers.iter().zip(list.list().unwrap_or(&[])) {
        let name = observer.name.as_str();
        let span = node.get("name").map_or_else(|| check::head(node), |name| name.span.clone());
        let files: Vec<String> =
            prefixes.iter().map(|prefix| format!("{prefix}{}", file_name(name)).to_ascii_lowercase()).collect();
        let same = taken.iter().find(|(file, _)| files.contains(file)).map(|(_, other)| *other);
        match same {
            Some(other) if other == name => {
                let message = format!("two observers are named {name:?}");
                reader.wrong(span, message, "expected different names");
            }
            Some(other) => {
                let message = format!("{other:?} and {name:?} give the same file names");
                let expected = "expected names that differ in more than case and punctuation";
                reader.wrong(span, message, expected);
            }
            None if file_name(name).is_empty() => {
                reader.wrong(
                    span,
                    format!("{name:?} cannot be part of a file name"),
                    "expected a letter or a digit (ASCII)",
                );
            }
            None if is_reserved(&file_name(name)) => {
                let message = format!("{name:?} cannot be part of a file name: Windows reserves it for a device");
                reader.wrong(span, message, "expected another name");
            }
            None => {}
        }
        taken.extend(files.into_iter().map(|file| (file, name)));
    }
    reader.mistakes.len() == before
}

/// Whether Windows reserves the name, with any extension.
fn is_reserved(name: &str) -> bool {
    let name = name.to_ascii_lowercase();
    let numbered =
        |device: &str| name.strip_prefix(device).is_some_and(|rest| matches!(rest.as_bytes(), [b'1'..=b'9']));
    ["con", "prn", "aux", "nul"].contains(&name.as_str()) || ["com", "lpt"].into_iter().any(numbered)
}

/// The name as part of a file name: letters, digits, `-` and `_`; all other characters become `-`.
pub(crate) fn file_name(name: &str) -> String {
    let plain: String = name.chars().map(|c| if c.is_ascii_alphanumeric() || c == '_' { c } else { '-' }).collect();
    plain.split('-').filter(|part| !part.is_empty()).collect::<Vec<_>>().join("-")
}

/// An observer from its table, of the plant with these parameters as its last states.
pub(super) fn observer(
    node: &Node,
    (plant, estimated): (&PlantModel, &[Estimated]),
    start: &[f64],
    (root, source): (&Node, &Source),
    reader: &mut Reader,
) -> Option<ObserverSpec> {
    let (size, kind) = (plant.model.size(), kinds::named(node.get("kind")?.text()?)?);
    let name = node.get("name").and_then(Node::text).unwrap_or(kind.name).to_owned();
    let initial = match node.get("initial") {
        Some(initial) => reader.numbers(initial, "initial", size.states, "state"),
        None => Some(start.to_vec()),
    };
    reader.fits_time = reader.dt.is_none() || kind.plant.time().discrete;
    let read = (kind.read)(&Given { node, plant, name: &name, root, models: super::model_of }, reader);
    let kind = if estimated.is_empty() { read } else { with_parameters(node, &read?, estimated, reader) };
    let limits = limits(node, size, reader);
    // A kind with mistakes has them already.
    let is_uncertain = kind.as_ref().is_none_or(|kind| kind.takes_uncertainty());
    let bounds = disturbance::bounds(node, size, root, is_uncertain, reader);
    smooth(node, root, reader)?;
    let place = source.place(check::head(node).start);
    let mut initial = initial?;
    initial.extend(estimated.iter().map(|one| one.value));
    Some(ObserverSpec { name, initial, kind: kind?, limits: limits?, bounds: bounds.ok()?, place })
}

/// The kind that estimates these parameters too.
fn with_parameters(
    node: &Node,
    kind: &ObserverKind,
    estimated: &[Estimated],
    reader: &mut Reader,
) -> Option<ObserverKind> {
    let with = kind.with_parameters(estimated);
    if with.is_none() {
        let names: Vec<&str> = estimated.iter().map(|one| one.name.as_str()).collect();
        let message =
            format!("the kind {} does not estimate the parameters of [estimate]: {}", kind.name(), names.join(", "));
        // What has a first covariance can have one of parameters.
        let has_covariance =
            |kind: &&kinds::Declaration| kind.keys.iter().copied().flatten().any(|key| key.name == "p0");
        let known: Vec<&str> = kinds::registry().into_iter().filter(has_covariance).map(|kind| kind.name).collect();
        reader.wrong(node.get("kind")?.span.clone(), message, format!("expected one of {}", known.join(", ")));
    }
    with
}

/// Smoothed estimates are of logs.
fn smooth(node: &Node, root: &Node, reader: &mut Reader) -> Option<()> {
    let Some(entry) = node.entry("smooth").filter(|entry| entry.node.truth() == Some(true)) else { return Some(()) };
    if root.get("log").is_some() {
        return Some(());
    }
    let message = "`smooth` is for estimates on a log, and the study has none";
    reader.refuse(entry.span.clone(), message, "expected a table [log], or no `smooth`")
}

/// `max_gain` and `noise`, which apply to gains that an inequality chooses.
fn limits(node: &Node, size: Dimensions, reader: &mut Reader) -> Option<GainLimits> {
    let given = ["max_gain", "noise"].iter().find_map(|key| node.entry(key));
    let fixed = ["bandwidth", "poles", "kalman", "gain"].iter().find_map(|key| node.entry(key));
    if let (Some(limit), Some(fixed)) = (given, fixed) {
        let message = format!("`{}` conflicts with `{}`, which determines the gain", limit.key, fixed.key);
        return reader.refuse(limit.span.clone(), message, "expected `decay_rate`, `lmi` or `fastest` with it");
    }
    let noise = match node.get("noise") {
        Some(v) => Some(reader.weight(
            v,
            "noise",
            size.outputs,
            &format!("the plant has {}", counted(size.outputs, "output")),
        )?),
        None => None,
    };
    Some(GainLimits { max_gain: node.get("max_gain").and_then(Node::number), noise })
}
