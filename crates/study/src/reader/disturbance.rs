//! Disturbances of an observer: the bounds for which its error is bounded, and the kinds that estimate or ignore one.

use luenberger_design::Uncertainty;
use luenberger_plants::Dimensions;
use luenberger_proof::wording::counted;
use nalgebra::DMatrix;

use super::tree::{Entry, Node};
use super::{Reader, Reported};
use crate::study::ActingBounds;

/// The table `bounds`, if there is one; the noise of `root`'s simulation is its default.
/// `is_uncertain` says whether the kind takes an uncertain plant.
pub(crate) fn bounds(
    node: &Node,
    size: Dimensions,
    root: &Node,
    is_uncertain: bool,
    reader: &mut Reader,
) -> Result<Option<ActingBounds>, Reported> {
    match node.entry("bounds") {
        Some(entry) => acting((node, entry), size, (root, is_uncertain), reader).map(Some).ok_or(Reported),
        None => Ok(None),
    }
}

/// Of the observer `node`.
fn acting(
    (node, entry): (&Node, &Entry),
    size: Dimensions,
    (root, is_uncertain): (&Node, bool),
    reader: &mut Reader,
) -> Option<ActingBounds> {
    let (table, n, p) = (&entry.node, size.states, size.outputs);
    let is_interval = node.get("kind").and_then(Node::text) == Some("interval");
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
        Some(first) if reader.dt.is_some() => {
            let message = format!("`{}` is for plants in continuous time, and `dt` makes this one discrete", first.key);
            return reader.refuse(first.span.clone(), message, "expected bounds of noise and disturbances only");
        }
        Some(first) if is_uncertain => Some(uncertain(table, first, n, reader)?),
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
