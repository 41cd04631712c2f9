//! The kinds h-infinity and h2.

use luenberger_design::{GeneralizedPlant, NormTarget, SystemNorm};
use luenberger_plants::Dimensions;
use luenberger_proof::wording::counted;
use nalgebra::DMatrix;

use super::Reader;
use super::gain::{alternatives, this_gain};
use super::tree::Node;
use crate::study::{NormFilterSpec, ObserverKind};

pub(super) fn norm_filter(
    norm: SystemNorm,
    node: &Node,
    size: Dimensions,
    reader: &mut Reader,
) -> Option<ObserverKind> {
    let (n, p) = (size.states, size.outputs);
    let of_states = format!("the plant has {}", counted(n, "state"));
    let e = reader.matrix(node.get("e")?, "e", (Some(n), None), &of_states);
    let q = e.as_ref().map(DMatrix::ncols);
    let columns = q.map_or_else(String::new, |q| format!(" and `e` {}", counted(q, "column")));
    let of_outputs = format!("the plant has {}{columns}", counted(p, "output"));
    let d = reader.matrix(node.get("d")?, "d", (Some(p), q), &of_outputs);
    let h = match node.get("h") {
        Some(h) => reader.matrix(h, "h", (None, Some(n)), &of_states),
        None => Some(DMatrix::identity(n, n)),
    };
    alternatives(node, &["gamma", "gain"], false, reader)?;
    let goal = match (node.get("gamma"), node.get("gain")) {
        (Some(gamma), _) => Some(NormTarget::Below(gamma.number()?)),
        (None, Some(gain)) => this_gain(gain, size, reader).map(NormTarget::OfGain),
        (None, None) => Some(NormTarget::Least),
    };
    let performance = GeneralizedPlant { e: e?, d: d?, h: h? };
    Some(ObserverKind::NormFilter(Box::new(NormFilterSpec { norm, performance, goal: goal? })))
}
