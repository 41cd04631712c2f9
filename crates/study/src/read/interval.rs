//! The kind `interval`: its gain, its coordinates and the box of the first state.

use luenberger_design::ErrorCoordinates;
use luenberger_plants::Dimensions;

use super::tree::Node;
use super::{Reader, check, gain};
use crate::study::{IntervalSpec, ObserverKind};

pub(super) fn interval(node: &Node, size: Dimensions, reader: &mut Reader) -> Option<ObserverKind> {
    let first = reader.numbers(node.get("initial_bounds")?, "initial_bounds", size.states, "state");
    if node.get("bounds").is_none() {
        let message = "the kind interval without `bounds`: nothing is known of noise and disturbances";
        reader.absent(check::head(node), message, "expected `bounds`");
        return None;
    }
    let given = match node.get("coordinates").and_then(Node::text) {
        Some("plant") => Some(ErrorCoordinates::Plant),
        Some(_) => Some(ErrorCoordinates::Modal),
        None => None,
    };
    let least = node.entry("least_width").filter(|entry| entry.node.truth() == Some(true));
    if let Some(entry) = least {
        if let Some(gain) = ["poles", "decay_rate", "lmi", "kalman", "gain"].iter().find_map(|key| node.entry(key)) {
            let message = format!("`{}` conflicts with `least_width`", gain.key);
            return reader.refuse(gain.span.clone(), message, "expected one of them");
        }
        if given == Some(ErrorCoordinates::Modal) {
            let message = "`least_width` is the gain for the coordinates of the plant, and `coordinates` is \"modal\"";
            return reader.refuse(
                entry.span.clone(),
                message,
                "expected coordinates = \"plant\", or another specification of the gain",
            );
        }
        let spec = IntervalSpec { gain: None, coordinates: ErrorCoordinates::Plant, first: first? };
        return Some(ObserverKind::Interval(Box::new(spec)));
    }
    let of_states = format!("the plant has {}", luenberger_proof::wording::counted(size.states, "state"));
    let gain = gain::linear_of(node, size, &of_states, reader)?;
    let coordinates = given.unwrap_or(ErrorCoordinates::Modal);
    Some(ObserverKind::Interval(Box::new(IntervalSpec { gain: Some(gain), coordinates, first: first? })))
}
