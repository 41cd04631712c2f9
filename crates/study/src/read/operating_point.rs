//! The table [operating_point].

use luenberger_design::{OperatingPoint, OperatingPointError, operating_point as found};
use nalgebra::DVector;

use crate::model::PlantModel;
use crate::reader::tree::Node;
use crate::reader::{Reader, check};

/// The operating point near the guess, by Newton's method.
pub(super) fn operating_point(node: &Node, plant: &PlantModel, reader: &mut Reader) -> Option<OperatingPoint> {
    let size = plant.model.size();
    let mut column = |key: &str, count: usize, what: &str| match node.get(key) {
        None => Some(vec![0.0; count]),
        Some(list) => reader.numbers(list, key, count, what),
    };
    let (x, u) = (column("x", size.states, "state"), column("u", size.inputs, "input"));
    let (x, u) = (DVector::from_vec(x?), DVector::from_vec(u?));
    if plant.dt.is_some() {
        let message = "[operating_point] is for plants in continuous time, and `dt` makes this one discrete";
        return reader.refuse(check::head(node), message, "expected no operating point");
    }
    if let Some(row) = plant.model.structure().explicit_time() {
        let message = format!("{row} depends on the time t");
        return reader.refuse(check::head(node), message, "expected a plant x' = f(x, u) for an operating point");
    }
    match plant.names().with(|| found(&plant.model, &x, &u)) {
        Ok(point) => Some(point),
        Err(error) => {
            let expected = match &error {
                OperatingPointError::Singular { .. } => {
                    "expected an input for which one state rests; a guess at which f is 0 is taken as it is"
                }
                _ => "expected a guess nearer to a state at which f(x, u) = 0",
            };
            let span = node.get("x").map_or_else(|| check::head(node), |list| list.span.clone());
            reader.refuse(span, plant.names().with(|| error.to_string()), expected)
        }
    }
}
