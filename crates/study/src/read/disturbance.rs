//! Disturbances of an observer: the bounds for which its error is bounded, and the kinds that estimate or ignore one.

use luenberger_design::Uncertainty;
use luenberger_plants::Dimensions;
use luenberger_proof::wording::counted;
use nalgebra::DMatrix;

use super::tree::{Entry, Node};
use super::{Reader, check, gain};
use crate::study::{ActingBounds, ObserverKind};

/// The most integrators in the model of a disturbance.
const LONGEST_CHAIN: usize = 16;

/// A mistake has been noted.
pub(super) struct Noted;

/// The table `bounds`, if there is one; the noise of `root`'s simulation is its default.
pub(super) fn bounds(
    node: &Node,
    size: Dimensions,
    root: &Node,
    reader: &mut Reader,
) -> Result<Option<ActingBounds>, Noted> {
    match node.entry("bounds") {
        Some(entry) => acting((node, entry), size, root, reader).map(Some).ok_or(Noted),
        None => Ok(None),
    }
}

/// Of the observer `node`.
fn acting((node, entry): (&Node, &Entry), size: Dimensions, root: &Node, reader: &mut Reader) -> Option<ActingBounds> {
    let (table, n, p) = (&entry.node, size.states, size.outputs);
    let is_interval = node.get("kind").and_then(Node::text) == Some("interval");
    if reader.dt.is_some() && !is_interval {
        let message = "`bounds` is for plants in continuous time, and `dt` makes this one discrete";
        return reader.refuse(entry.span.clone(), message, "expected no `bounds`");
    }
    let noise = match table.get("noise") {
        Some(noise) => reader.numbers(noise, "noise", p, "output"),
        None => Some(uniform_noise(root, p)),
    };
    let disturbance = table.get("disturbance").map_or(Some(Vec::new()), Node::numbers);
    let (noise, disturbance) = (noise?, disturbance?);
    let e = match table.get("e") {
        Some(e) => {
            let why =
                format!("the plant has {}, and `disturbance` has length {}", counted(n, "state"), disturbance.len());
            reader.matrix(e, "e", (Some(n), Some(disturbance.len())), &why)?
        }
        None if disturbance.is_empty() => DMatrix::zeros(n, 0),
        None if disturbance.len() == n => DMatrix::identity(n, n),
        None => {
            let message = format!(
                "`disturbance` has length {}, the plant has {}, and `e` does not say how it enters",
                disturbance.len(),
                counted(n, "state")
            );
            reader.absent(table.get("disturbance")?.span.clone(), message, "expected `e`, the matrix E of E w");
            return None;
        }
    };
    let uncertain = match ["states", "deviations", "m", "h"].iter().find_map(|key| table.entry(key)) {
        Some(first) if matches!(node.get("kind").and_then(Node::text), Some("luenberger" | "cubic")) => {
            Some(uncertain(table, first, n, reader)?)
        }
        Some(first) => {
            let message = format!("`{}` is for the kinds luenberger and cubic", first.key);
            return reader.refuse(first.span.clone(), message, "expected bounds of noise and disturbances only");
        }
        None => None,
    };
    if !is_interval && uncertain.is_none() && noise.iter().chain(&disturbance).all(|bound| *bound == 0.0) {
        let message = "all bounds are 0: without noise and disturbances the error tends to 0";
        return reader.refuse(entry.span.clone(), message, "expected `noise` or `disturbance` with a bound above 0");
    }
    Some(ActingBounds { noise, disturbance, e, uncertain })
}

/// The bounds of the states, and the deviations of A.
fn uncertain(table: &Node, first: &Entry, n: usize, reader: &mut Reader) -> Option<(Vec<f64>, Uncertainty)> {
    let of_states = format!("the plant has {}", counted(n, "state"));
    let Some(states) = table.get("states") else {
        let message = format!("`{}` without bounds of the states: the error tends to 0 only if they do", first.key);
        return reader.refuse(first.span.clone(), message, "expected `states` with it");
    };
    let bounds = reader.numbers(states, "states", n, "state")?;
    if bounds.iter().all(|bound| *bound == 0.0) {
        return reader.refuse(states.span.clone(), "all bounds of the states are 0", "expected a bound above 0");
    }
    let deviation = match (table.entry("deviations"), table.entry("m"), table.entry("h")) {
        (Some(list), None, None) => {
            let read =
                |node: &Node, reader: &mut Reader| reader.matrix(node.get("a")?, "a", (Some(n), Some(n)), &of_states);
            let all: Vec<Option<_>> = list.node.list()?.iter().map(|node| read(node, reader)).collect();
            let all: Vec<_> = all.into_iter().collect::<Option<_>>()?;
            if all.is_empty() {
                return reader.refuse(list.span.clone(), "`deviations` is empty", "expected a matrix at least");
            }
            Uncertainty::Polytope(all)
        }
        (None, Some(m), Some(h)) => Uncertainty::NormBounded {
            m: reader.matrix(&m.node, "m", (Some(n), None), &of_states)?,
            h: reader.matrix(&h.node, "h", (None, Some(n)), &of_states)?,
        },
        _ => {
            let message = "how the plant deviates is given by `deviations`, or by `m` and `h`";
            return reader.refuse(
                first.span.clone(),
                message,
                "expected `deviations`, or both `m` and `h`, with `states`",
            );
        }
    };
    Some((bounds, deviation))
}

/// The amplitudes of the uniform noise of the simulation; 0 where there is none.
fn uniform_noise(root: &Node, outputs: usize) -> Vec<f64> {
    let noise = root.get("simulation").and_then(|simulation| simulation.get("noise"));
    let uniform = noise.filter(|noise| noise.get("distribution").and_then(Node::text) == Some("uniform"));
    let amplitude = uniform.and_then(|noise| noise.get("amplitude"));
    match amplitude.map(|amplitude| (amplitude.number(), amplitude.numbers())) {
        Some((Some(one), _)) => vec![one; outputs],
        Some((None, Some(all))) if all.len() == outputs => all,
        _ => vec![0.0; outputs],
    }
}

/// E, with a column for each disturbance.
fn unknown(node: &Node, size: Dimensions, reader: &mut Reader) -> Option<DMatrix<f64>> {
    let why = format!("the plant has {}", counted(size.states, "state"));
    reader.matrix(node.get("e")?, "e", (Some(size.states), None), &why)
}

/// theta and gamma; none without `gamma`, where theta has no effect.
fn cubic(node: &Node, size: Dimensions, reader: &mut Reader) -> Result<Option<(DMatrix<f64>, f64)>, Noted> {
    match (node.get("gamma"), node.entry("theta")) {
        (Some(gamma), _) => {
            let theta = gain::theta(node, size.outputs, reader).ok_or(Noted)?;
            Ok(Some((theta, gamma.number().ok_or(Noted)?)))
        }
        (None, Some(theta)) => {
            let message = "`theta` has no effect without a cubic term";
            reader.wrong(theta.span.clone(), message, "expected `gamma` with it");
            Err(Noted)
        }
        (None, None) => Ok(None),
    }
}

pub(super) fn proportional_integral(node: &Node, size: Dimensions, reader: &mut Reader) -> Option<ObserverKind> {
    let e = unknown(node, size, reader)?;
    let q = e.ncols();
    let is_extended = node.get("kind").and_then(Node::text) == Some("extended-state");
    let order = node.get("order").map_or(Some(1), Node::count)?;
    let chain = is_extended.then_some(order);
    if order == 0 {
        let message = "`order` is 0: no disturbance would be estimated";
        return reader.refuse(node.get("order")?.span.clone(), message, "expected 1 or more");
    }
    if order > LONGEST_CHAIN {
        let message = format!("`order` is {order}: {order} derivatives of each disturbance would be estimated");
        return reader.refuse(node.get("order")?.span.clone(), message, format!("expected at most {LONGEST_CHAIN}"));
    }
    let both = Dimensions { states: size.states + order * q, ..size };
    let disturbances = if order == 1 {
        counted(q, "disturbance")
    } else {
        format!("{} with {}", counted(q, "disturbance"), counted(order - 1, "derivative"))
    };
    let of_states = format!("the plant has {} and {disturbances} to be estimated", counted(size.states, "state"));
    let linear = gain::linear_of(node, both, &of_states, reader);
    let cubic = cubic(node, size, reader);
    let rate = match node.get("rate") {
        None => Some(vec![0.0; q]),
        Some(list) => {
            let rate = list.numbers()?;
            if rate.len() != q {
                let message = format!("`rate` has length {}, and `e` has {}", rate.len(), counted(q, "column"));
                return reader.refuse(list.span.clone(), message, format!("expected length {q}"));
            }
            Some(rate)
        }
    };
    let rate = rate?;
    if rate.iter().any(|rate| *rate > 0.0) && node.get("bounds").is_none() {
        let message = "`rate` has no effect without `bounds`, which asks for a bound of the error";
        return reader.refuse(node.entry("rate")?.span.clone(), message, "expected `bounds` with it");
    }
    Some(ObserverKind::ProportionalIntegral { e, chain, rate, linear: linear?, cubic: cubic.ok()? })
}

pub(super) fn unknown_input(node: &Node, size: Dimensions, reader: &mut Reader) -> Option<ObserverKind> {
    let e = unknown(node, size, reader);
    let of_states = format!("the plant has {}", counted(size.states, "state"));
    let linear = gain::linear_of(node, size, &of_states, reader);
    let cubic = cubic(node, size, reader);
    let kind = ObserverKind::UnknownInput { e: e?, linear: linear?, cubic: cubic.ok()? };
    if reader.dt.is_some() {
        return reader.refuse(check::head(node), "this kind is for plants in continuous time", "expected another kind");
    }
    Some(kind)
}
