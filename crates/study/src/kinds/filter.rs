//! What the filters with a covariance share, those that are updated at samples.

use luenberger_proof::wording::counted;
use nalgebra::DMatrix;

use crate::reader::tree::Node;
use crate::reader::{Given, Reader};

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

/// Their values.
pub(super) fn read(given: &Given<'_>, reader: &mut Reader) -> Option<Filter> {
    let (node, size) = (given.node, given.size());
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

/// Evaluations of a prediction, about, of a plant that is not stiff.
pub(super) const STAGES: f64 = 16.0;
