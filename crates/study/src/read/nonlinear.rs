//! Specifications of filters, sliding-mode and high-gain observers of nonlinear plants.

use luenberger_export::moving_horizon::LONGEST_WINDOW;
use luenberger_observers::Horizon;
use luenberger_plants::Dimensions;
use luenberger_proof::wording::counted;
use nalgebra::DMatrix;

use super::region::bounds;
use super::tree::Node;
use super::{Reader, check, maps};
use crate::model::PlantModel;
use crate::study::{HORIZON, MovingHorizonSpec, ObserverKind, PrintedMean, SlidingModeSpec};

/// The keys that the filters have in common.
pub(super) struct Filter {
    pub(super) w: DMatrix<f64>,
    pub(super) v: DMatrix<f64>,
    pub(super) p0: DMatrix<f64>,
    pub(super) period: f64,
    pub(super) substeps: Option<usize>,
    pub(super) gate: Option<f64>,
    pub(super) smooth: bool,
}

pub(super) fn filter(node: &Node, size: Dimensions, reader: &mut Reader) -> Option<Filter> {
    let (n, p) = (size.states, size.outputs);
    let (of_states, of_outputs) =
        (format!("the plant has {}", counted(n, "state")), format!("the plant has {}", counted(p, "output")));
    let w = reader.weight(node.get("w")?, "w", n, &of_states);
    let v = reader.weight(node.get("v")?, "v", p, &of_outputs);
    let p0 = match node.get("p0") {
        Some(p0) => reader.weight(p0, "p0", n, &of_states),
        None => Some(DMatrix::identity(n, n)),
    };
    let substeps = node.given("substeps", Node::count)?;
    let gate = node.given("gate", Node::number)?;
    let smooth = node.get("smooth").and_then(Node::truth).unwrap_or(false);
    let period = node.get("period")?.number()?;
    Some(Filter { w: w?, v: v?, p0: p0?, period, substeps, gate, smooth })
}

pub(super) fn moving_horizon(node: &Node, size: Dimensions, reader: &mut Reader) -> Option<ObserverKind> {
    let filter = filter(node, size, reader);
    let count = |key: &str, otherwise: usize| node.get(key).map_or(Some(otherwise), Node::count);
    let horizon =
        Horizon { window: count("window", HORIZON.window)?, iterations: count("iterations", HORIZON.iterations)? };
    if let Some(entry) = node.entry("window").filter(|_| horizon.window > LONGEST_WINDOW) {
        let message = format!("`window` is {}", horizon.window);
        return reader.refuse(entry.node.span.clone(), message, format!("expected at most {LONGEST_WINDOW} samples"));
    }
    let bounds = match node.entry("state_bounds") {
        Some(entry) => {
            let bounds = bounds(&entry.node, "state_bounds", size.states, "state", reader)?;
            if let Some(k) = bounds.iter().position(|(low, high)| low >= high) {
                let message = format!("pair {} of `state_bounds` is from {} to {}", k + 1, bounds[k].0, bounds[k].1);
                return reader.refuse(entry.node.span.clone(), message, "expected the lower bound below the upper one");
            }
            Some(bounds)
        }
        None => None,
    };
    let Filter { w, v, p0, period, substeps, .. } = filter?;
    Some(ObserverKind::MovingHorizon(Box::new(MovingHorizonSpec { w, v, p0, period, substeps, horizon, bounds })))
}

/// Smoothed estimates are of logs.
pub(super) fn smooth(node: &Node, root: &Node, reader: &mut Reader) -> Option<()> {
    let Some(entry) = node.entry("smooth").filter(|entry| entry.node.truth() == Some(true)) else { return Some(()) };
    if root.get("log").is_some() {
        return Some(());
    }
    let message = "`smooth` is for estimates on a log, and the study has none";
    reader.refuse(entry.span.clone(), message, "expected a table [log], or no `smooth`")
}

/// The mean of the Jacobian of the observer as printed, which has no gain to be designed.
pub(super) fn printed_mean(node: &Node, printed: &Node, reader: &mut Reader) -> Option<PrintedMean> {
    if let Some(given) = ["decay_rate", "region", "max_gain", "noise"].iter().find_map(|key| node.entry(key)) {
        let message = format!("`{}` has no effect: the observer as printed has no gain to be designed", given.key);
        return reader.refuse(given.span.clone(), message, "expected it without `as_printed`");
    }
    Some(match printed.text()? {
        "least-squares" => PrintedMean::LeastSquares,
        "root" => PrintedMean::Root,
        _ => PrintedMean::Integral,
    })
}

pub(super) fn sliding_mode(node: &Node, size: Dimensions, reader: &mut Reader) -> Option<ObserverKind> {
    let gains = node.given("k", |gains| reader.numbers(gains, "k", size.states, "state"))?;
    let spec = SlidingModeSpec {
        gains,
        explicit: node.get("discretisation").and_then(Node::text) == Some("explicit"),
        ..SlidingModeSpec::new(node.get("bound")?.number()?, node.get("period")?.number()?)
    };
    if reader.dt.is_some() {
        return reader.refuse(check::head(node), "this kind is for plants in continuous time", "expected another kind");
    }
    Some(ObserverKind::SlidingMode(spec))
}

pub(super) fn high_gain(node: &Node, plant: &PlantModel, reader: &mut Reader) -> Option<ObserverKind> {
    let size = plant.model.size();
    let p = size.outputs;
    let given = node.get("drift").map(|drift| drift.list().map_or(0, <[Node]>::len));
    if given.is_none()
        && let Some(entry) = ["shape", "estimate", "start"].iter().find_map(|key| node.entry(key))
    {
        let message = format!("`{}` is given, and `drift` is not", entry.key);
        return reader.refuse(entry.span.clone(), message, "expected `drift`, the right-hand side without corrections");
    }
    let (n, whose) = match given {
        Some(order) => (order, format!("`drift` has {}", counted(order, "row"))),
        None => (size.states, format!("the plant has {}", counted(size.states, "state"))),
    };
    let chains = match node.entry("chains") {
        Some(entry) => {
            let lengths = reader.numbers(&entry.node, "chains", p, "output")?;
            if lengths.iter().any(|length| length.fract() != 0.0) || lengths.iter().sum::<f64>() != n as f64 {
                let message = format!("`chains` is {}, and {whose}", listed(&lengths));
                return reader.refuse(
                    entry.node.span.clone(),
                    message,
                    format!("expected whole numbers that add to {n}"),
                );
            }
            lengths.into_iter().map(|length| length as usize).collect()
        }
        None if p == 1 => vec![n],
        None => {
            let message =
                format!("the plant has {}, and `chains` does not assign the states to them", counted(p, "output"));
            reader.absent(check::head(node), message, format!("expected `chains`, {p} lengths that add to {n}"));
            return None;
        }
    };
    let alpha = match node.get("alpha") {
        Some(alpha) if given.is_some() => {
            let alpha_i = alpha.numbers()?;
            if alpha_i.len() != n {
                let message = format!("`alpha` has length {}, and {whose}", alpha_i.len());
                return reader.refuse(alpha.span.clone(), message, format!("expected length {n}"));
            }
            alpha_i
        }
        Some(alpha) => reader.numbers(alpha, "alpha", n, "state")?,
        None => chains.iter().flat_map(|length| binomials(*length)).collect(),
    };
    let maps = match given {
        Some(_) => Some(Box::new(maps::high_gain(node, plant, &chains, reader)?)),
        None => None,
    };
    Some(ObserverKind::HighGain { r: node.get("r")?.number()?, chains, alpha, maps })
}

/// `[1, 2.5]`.
fn listed(numbers: &[f64]) -> String {
    format!("[{}]", numbers.iter().map(f64::to_string).collect::<Vec<_>>().join(", "))
}

/// The coefficients of `(s + 1)^length` after the first.
fn binomials(length: usize) -> Vec<f64> {
    let next = |last: &f64, k: usize| last * (length - k) as f64 / (k + 1) as f64;
    let mut row = vec![1.0];
    for k in 0..length {
        row.push(next(&row[k], k));
    }
    row.split_off(1)
}
