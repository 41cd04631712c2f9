//! The error-state Kalman filter: an extended Kalman filter of states that form unit vectors, as a quaternion.

use super::as_kind;
use super::declaration::{Declaration, Tuning};
use super::extended_kalman::ExtendedKalman;
use crate::keys::{Key, Type, required};
use crate::reader::tree::Node;
use crate::reader::{Given, Reader};
use crate::study::{ObserverKind, PlantClass, Time};

/// The kind.
pub(super) static DECLARATION: Declaration = Declaration {
    name: "error-state-kalman",
    about: "Error-state (multiplicative extended) Kalman filter of states that form unit vectors, as the quaternion of an attitude: their norm stays 1, and the covariance is that of the rotation, for a plant in continuous time with sampled measurements, or in discrete time.",
    source: "Markley and Crassidis, Fundamentals of Spacecraft Attitude Determination and Control, 2014, section 6.2",
    plant: PlantClass::Nonlinear(Time::ANY),
    keys: &[ErrorState::KEYS],
    kind: as_kind::<ExtendedKalman>,
    read,
    takes_long: false,
    tuning: Tuning::OfStudy(
        "which states form unit vectors is known of the plant and not derived, and the study specifies no such observer",
    ),
};

/// A state without bounds.
const FREE: (f64, f64) = (f64::NEG_INFINITY, f64::INFINITY);

fn read(given: &Given<'_>, reader: &mut Reader) -> Option<ObserverKind> {
    let ErrorState { filter, unit_vectors } = ErrorState::read(given, reader)?;
    let states = &given.plant.states;
    let is_bounded = |i: usize| filter.state_bounds.as_ref().is_some_and(|bounds| bounds[i] != FREE);
    if let Some(i) = (0..unit_vectors.len()).find(|&i| unit_vectors[i] > 0 && is_bounded(i)) {
        let node = given.node.get("state_bounds")?;
        let message = format!("`state_bounds` bounds {}, an entry of a unit vector", states[i]);
        return reader.refuse(node.span.clone(), message, "expected no bounds of unit vectors");
    }
    // 0 has no direction, and is where an estimate begins of which nothing is said.
    let initial = given.node.get("initial").and_then(Node::numbers).unwrap_or_else(|| vec![0.0; states.len()]);
    let lists = given.node.get(UNIT_VECTORS.name)?.list()?;
    for (list, vector) in lists.iter().zip(1..) {
        let mut entries = unit_vectors.iter().zip(&initial).filter(|(number, _)| **number == vector);
        if initial.len() == states.len() && entries.all(|(_, x)| *x == 0.0) {
            let message = format!("the first estimate of unit vector {vector} is 0");
            return reader.refuse(list.span.clone(), message, "expected `initial` with a direction for it");
        }
    }
    Some(ExtendedKalman { unit_vectors: Some(unit_vectors), ..filter }.into())
}

crate::keys! {
    struct ErrorState {
        /// The filter.
        filter: ExtendedKalman as [ExtendedKalman::KEYS] => ExtendedKalman::read,
        /// The number of the unit vector of each state, from 1 on, and 0 for the others.
        unit_vectors: Vec<usize> as &UNIT_VECTORS => unit_vectors,
    }
}

const UNIT_VECTORS: Key = required(
    "unit_vectors",
    Type::NameLists(2),
    "Lists of the names of the states that form a unit vector together, as [[\"q0\", \"q1\", \"q2\", \"q3\"]]; the plant keeps their norms.",
);

fn unit_vectors(key: &Key, given: &Given<'_>, reader: &mut Reader) -> Option<Vec<usize>> {
    let lists = given.node.get(key.name)?.list()?;
    let states = &given.plant.states;
    let mut numbers = vec![0; states.len()];
    for (k, list) in lists.iter().enumerate() {
        for node in list.list()? {
            let name = node.text()?;
            let Some(i) = states.iter().position(|state| state == name) else {
                let message = format!("there is no state {name:?}");
                let expected = format!("expected states of the plant: {}", states.join(", "));
                return reader.refuse(node.span.clone(), message, expected);
            };
            if numbers[i] > 0 {
                let message = format!("{name} is in a unit vector already");
                return reader.refuse(node.span.clone(), message, "expected each state once");
            }
            numbers[i] = k + 1;
        }
    }
    Some(numbers)
}
