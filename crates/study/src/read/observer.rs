//! The tables [[observer]].

use luenberger_design::numerical_kkl::MOST_NODES;
use luenberger_design::{Sector, SystemNorm};
use luenberger_observers::SigmaPoints;
use luenberger_observers::numerical_kkl::tensor_train::MOST_RANK;
use luenberger_plants::Dimensions;
use luenberger_proof::wording::counted;

use super::gain::{
    alternatives, correction, functional, linear, periods, reduced_order, sampled_correction, theta, this_gain,
};
use super::nonlinear::{Filter, filter, high_gain, moving_horizon, printed_mean, sliding_mode, smooth};
use super::region::{finite_bounds, region, sector};
use super::tree::Node;
use super::{Reader, check, disturbance, interval, maps, norm_filter, optimal};
use crate::diagnostic::Source;
use crate::model::PlantModel;
use crate::study::{
    GainLimits, KklSpec, MOST_STATES_OF_A_FULL_TABLE, ObserverKind, ObserverSpec, RateSpec, UnscentedSpec,
};

/// The observers; none if one has mistakes.
pub(super) fn observers(
    root: &Node,
    plant: &PlantModel,
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

/// An observer from its table.
pub(super) fn observer(
    node: &Node,
    plant: &PlantModel,
    start: &[f64],
    (root, source): (&Node, &Source),
    reader: &mut Reader,
) -> Option<ObserverSpec> {
    let (size, kind_name) = (plant.model.size(), node.get("kind")?.text()?);
    let name = node.get("name").and_then(Node::text).unwrap_or(kind_name).to_owned();
    let initial = match node.get("initial") {
        Some(initial) => reader.numbers(initial, "initial", size.states, "state"),
        None => Some(start.to_vec()),
    };
    let kind = match kind_name {
        "kkl" => maps::kkl(node, plant, reader),
        "immersion-invariance" => maps::immersion(node, plant, reader),
        "pebo" => maps::peb(node, plant, reader).map(|peb| ObserverKind::Pebo(Box::new(peb))),
        "optimal-cubic" => optimal::problem(node, size, root, reader),
        "kkl-peb" => maps::peb(node, plant, reader).map(|peb| ObserverKind::KklPeb(Box::new(peb))),
        "high-gain" => high_gain(node, plant, reader),
        "functional" => functional(node, (&name, size), root, reader),
        _ => kind(node, kind_name, size, reader),
    };
    let limits = limits(node, size, reader);
    let bounds = disturbance::bounds(node, size, root, reader);
    smooth(node, root, reader)?;
    let place = source.place(check::head(node).start);
    Some(ObserverSpec { name, initial: initial?, kind: kind?, limits: limits?, bounds: bounds.ok()?, place })
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

fn kind(node: &Node, name: &str, size: Dimensions, reader: &mut Reader) -> Option<ObserverKind> {
    let (n, p) = (size.states, size.outputs);
    let number = |key: &str| node.get(key).and_then(Node::number);
    let positive = |key: &str, otherwise: f64| match node.get(key) {
        Some(value) => value.number(),
        None => Some(otherwise),
    };
    let of_states = format!("the plant has {}", counted(n, "state"));
    Some(match name {
        "luenberger" => ObserverKind::Luenberger(linear(node, size, reader)?),
        "kalman" => ObserverKind::Kalman(linear(node, size, reader)?),
        "cubic" => {
            let linear = linear(node, size, reader);
            let theta = theta(node, p, reader);
            let correction = correction(node, p, reader);
            ObserverKind::Cubic { linear: linear?, theta: theta?, correction: correction? }
        }
        "sampled-cubic" => {
            let linear = linear(node, size, reader);
            let theta = theta(node, p, reader);
            let correction = sampled_correction(node, p, reader);
            let period = number("period")?;
            let varying = match node.get("jitter").or_else(|| node.get("misses")) {
                Some(_) => Some(periods(node, period, reader)?).filter(|periods| !periods.is_constant()),
                None => None,
            };
            ObserverKind::SampledCubic { linear: linear?, theta: theta?, correction: correction?, period, varying }
        }
        "proportional-integral" | "extended-state" => disturbance::proportional_integral(node, size, reader)?,
        "reduced-order" => reduced_order(node, size, reader)?,
        "h-infinity" => norm_filter::norm_filter(SystemNorm::HInfinity, node, size, reader)?,
        "h2" => norm_filter::norm_filter(SystemNorm::H2, node, size, reader)?,
        "unknown-input" => disturbance::unknown_input(node, size, reader)?,
        "interval" => interval::interval(node, size, reader)?,
        "sliding-mode" => sliding_mode(node, size, reader)?,
        "lpv" => {
            let region = region(node, size, reader);
            alternatives(node, &["decay_rate", "fastest", "gain"], false, reader)?;
            let rate = match (node.get("fastest"), node.get("gain")) {
                (Some(ceiling), _) => RateSpec::Fastest(ceiling.number()?),
                (_, Some(gain)) => RateSpec::Gain(this_gain(gain, size, reader)?, 0.0),
                _ => RateSpec::Rate(positive("decay_rate", 0.0)?),
            };
            ObserverKind::Lpv { region: region?, rate }
        }
        "lipschitz" => {
            let region = region(node, size, reader);
            let gain = node.given("gain", |gain| this_gain(gain, size, reader))?;
            let split = match (node.entry("a"), node.entry("sectors")) {
                (None, None) => None,
                (Some(a), Some(sectors)) => {
                    let a = reader.matrix(&a.node, "a", (Some(n), Some(n)), &of_states);
                    let sectors: Vec<Option<Sector>> =
                        sectors.node.list()?.iter().map(|node| sector(node, n, reader)).collect();
                    Some((a?, sectors.into_iter().collect::<Option<Vec<_>>>()?))
                }
                (Some(one), None) | (None, Some(one)) => {
                    let message = format!("`{}` alone: `a` and `sectors` define the plant together", one.key);
                    return reader.refuse(one.span.clone(), message, "expected both, or neither");
                }
            };
            ObserverKind::Lipschitz { split, region: region?, rate: positive("decay_rate", 0.0)?, gain }
        }
        "mean-value" => {
            let region = region(node, size, reader);
            let internal_error = match node.get("internal_error") {
                Some(error) => reader.numbers(error, "internal_error", n, "state"),
                None => Some(vec![0.0; n]),
            };
            let printed = node.given("as_printed", |printed| printed_mean(node, printed, reader))?;
            ObserverKind::MeanValue {
                region: region?,
                rate: positive("decay_rate", 0.0)?,
                eta: positive("eta", 1.0)?,
                internal_error: internal_error?,
                printed,
            }
        }
        "extended-kalman" => {
            let Filter { w, v, p0, period, substeps, gate, smooth } = filter(node, size, reader)?;
            ObserverKind::ExtendedKalman { w, v, p0, period, substeps, gate, smooth }
        }
        "ukf" => {
            let filter = filter(node, size, reader);
            let standard = SigmaPoints::default();
            let number = |key: &str, otherwise: f64| node.get(key).map_or(Some(otherwise), Node::number);
            let sigma = SigmaPoints {
                alpha: number("alpha", standard.alpha)?,
                beta: number("beta", standard.beta)?,
                kappa: number("kappa", standard.kappa)?,
            };
            if sigma.weights::<f64>(n).is_err() {
                let key = node.entry("kappa").or_else(|| node.entry("alpha"))?;
                let message = format!(
                    "`{}` leaves no sigma points: alpha = {}, kappa = {}, and the plant has {}",
                    key.key,
                    sigma.alpha,
                    sigma.kappa,
                    counted(n, "state")
                );
                return reader.refuse(
                    key.span.clone(),
                    message,
                    format!("expected kappa > -{n} and an alpha of about 1e-3 to 1"),
                );
            }
            let Filter { w, v, p0, period, substeps, gate, smooth } = filter?;
            ObserverKind::Unscented(Box::new(UnscentedSpec { w, v, p0, sigma, period, substeps, gate, smooth }))
        }
        "mhe" => moving_horizon(node, size, reader)?,
        "kkl-numerical" => {
            let domain = finite_bounds(node.get("domain")?, "domain", (n, "state"), reader)?;
            let inputs = match node.get("inputs") {
                Some(inputs) => finite_bounds(inputs, "inputs", (size.inputs, "input"), reader)?,
                None => Vec::new(),
            };
            if inputs.is_empty()
                && let Some(nodes) = node.entry("nodes")
            {
                let message = "`nodes` without `inputs`";
                return reader.refuse(nodes.span.clone(), message, "expected `inputs`, the range of each input");
            }
            let count = |key: &str, otherwise: usize| node.get(key).map_or(Some(otherwise), Node::count);
            let standard = KklSpec::new(domain);
            let nodes = count("nodes", standard.nodes)?;
            if nodes > MOST_NODES {
                let message = format!("`nodes` is {nodes}");
                return reader.refuse(
                    node.get("nodes")?.span.clone(),
                    message,
                    format!("expected at most {MOST_NODES}"),
                );
            }
            let is_low_rank = n > MOST_STATES_OF_A_FULL_TABLE;
            if !is_low_rank && let Some(rank) = node.entry("rank") {
                let message = format!("`rank` for a plant with {}", counted(n, "state"));
                let expected =
                    format!("up to {MOST_STATES_OF_A_FULL_TABLE} states the table has all points of the grid");
                return reader.refuse(rank.span.clone(), message, expected);
            }
            let rank = count("rank", standard.rank)?;
            if rank > MOST_RANK {
                let message = format!("`rank` is {rank}");
                return reader.refuse(node.get("rank")?.span.clone(), message, format!("expected at most {MOST_RANK}"));
            }
            ObserverKind::KklNumerical(KklSpec {
                inputs,
                rank,
                nodes,
                cutoff: number("cutoff"),
                escape: number("escape"),
                points: node.given("points", Node::count)?,
                leaves: count("leaves", standard.leaves)?,
                degree: count("degree", standard.degree)?,
                samples: count("samples", standard.samples)?,
                embedded: node.get("form").and_then(Node::text) == Some("embedded"),
                ..standard
            })
        }
        // The description of the kinds has no other.
        _ => return None,
    })
}
