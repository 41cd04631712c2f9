//! The table [advise].

use luenberger_design::Region;
use luenberger_proof::wording::counted;

use crate::model::PlantModel;
use crate::reader::tree::Node;
use crate::reader::{Reader, region};
use crate::study::{AdviseSpec, Simulation};

/// The largest share of a log that can be held out.
pub(super) const MOST_HELD_OUT: f64 = 0.9;

pub(super) fn advise(
    node: &Node,
    plant: &PlantModel,
    simulation: Option<&Simulation>,
    reader: &mut Reader,
) -> Option<AdviseSpec> {
    let size = plant.model.size();
    let before = reader.mistakes.len();
    let region = node.get("region").and_then(|_| region::region(node, size, reader));
    if let (Some(region), Some(span)) = (&region, node.get("region").map(|node| node.span.clone())) {
        bounded(region, plant, simulation, span, reader);
    }
    let initial = node.get("initial").and_then(|list| reader.numbers(list, "initial", size.states, "state"));
    let why = "as many as the plant has states";
    let w = node.get("w").and_then(|w| reader.weight(w, "w", size.states, why));
    let e = node.get("e").and_then(|e| reader.matrix(e, "e", (Some(size.states), None), why));
    let disturbance = node.entry("disturbance").and_then(|entry| {
        let Some(e) = &e else {
            let message = "`disturbance` without `e`, the matrix E of E w";
            return reader.refuse(entry.span.clone(), message, "expected `e` with it");
        };
        let bounds = entry.node.numbers()?;
        if bounds.len() != e.ncols() {
            let columns = counted(e.ncols(), "column");
            let message = format!("`disturbance` has length {}, and `e` has {columns}", bounds.len());
            reader.wrong(entry.node.span.clone(), message, format!("expected length {}", e.ncols()));
        }
        Some(bounds)
    });
    let period = node.get("period").and_then(Node::number);
    if let (Some(period), Some(dt), Some(entry)) = (period, plant.dt, node.get("period"))
        && (period - dt).abs() > 1e-9 * dt
    {
        let message = format!("`period` is {period}, and the plant is in discrete time with dt = {dt}");
        reader.wrong(entry.span.clone(), message, format!("expected {dt}"));
    }
    let noise = node.get("noise").and_then(|list| reader.numbers(list, "noise", size.outputs, "output"));
    let held_out = node.get("held_out").and_then(Node::number);
    if let (Some(share), Some(entry)) = (held_out.filter(|share| *share > MOST_HELD_OUT), node.get("held_out")) {
        let message = format!("`held_out` is {share}");
        reader.wrong(entry.span.clone(), message, format!("expected a share up to {MOST_HELD_OUT}"));
    }
    let default = AdviseSpec::default();
    let spec = AdviseSpec {
        settling: node.get("settling").and_then(Node::number),
        region,
        initial,
        w,
        e,
        disturbance,
        period,
        noise,
        held_out,
        ensemble: node.get("ensemble").map_or(Some(default.ensemble), Node::count)?,
        seed: node.get("seed").map_or(Some(0), Node::count)? as u64,
    };
    (reader.mistakes.len() == before).then_some(spec)
}

/// Checks that the region bounds every state, and contains the initial state of the simulation.
fn bounded(
    region: &Region,
    plant: &PlantModel,
    simulation: Option<&Simulation>,
    span: std::ops::Range<usize>,
    reader: &mut Reader,
) {
    for (i, (low, high)) in region.states().iter().enumerate() {
        let name = &plant.states[i];
        if !(low.is_finite() && high.is_finite() && low < high) {
            let message = format!("`region` has {name} from {low} to {high}");
            reader.wrong(span, message, "expected finite bounds of every state, the lower one less");
            return;
        }
        if let Some(x) = simulation.map(|simulation| simulation.x0[i]).filter(|x| !(*low..=*high).contains(x)) {
            let message = format!("`region` has {name} from {low} to {high}, and x0 is {x}");
            reader.wrong(span, message, "expected a region that contains simulation.x0");
            return;
        }
    }
}
