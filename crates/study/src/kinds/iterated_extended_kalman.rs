//! The iterated extended Kalman filter.

use super::as_kind;
use super::declaration::{Context, Declaration, Information, Keys, Rule, Tuning};
use super::extended_kalman::ExtendedKalman;
use super::filter;
use super::keys::{FILTER, OF_FILTER};
use crate::keys::{Type, optional};
use crate::reader::tree::Node;
use crate::reader::{Given, Reader};
use crate::study::{ObserverKind, PlantClass, Time};
use crate::tuning;

/// The kind.
pub(super) static DECLARATION: Declaration = Declaration {
    name: "iterated-extended-kalman",
    about: "Iterated extended Kalman filter: each measurement is linearised again where its update leads, by Gauss-Newton steps, for a plant in continuous time with sampled measurements, or in discrete time.",
    source: "Bell and Cathey 1993; Jazwinski, Stochastic Processes and Filtering Theory, 1970, section 8.3",
    plant: PlantClass::Nonlinear(Time::ANY),
    keys: &[
        FILTER,
        OF_FILTER,
        &[optional(
            "iterations",
            Type::Count(1),
            "How often each measurement is linearised, at most 100 (default 3; 1 is extended-kalman).",
        )],
    ],
    kind: as_kind::<ExtendedKalman>,
    read,
    takes_long: false,
    tuning: Tuning::Rules(&[Rule {
        name: "iterated-extended-kalman",
        turn: 18,
        tuning: "the covariances of extended-kalman, where an output is not linear in the state",
        source: "Bell and Cathey 1993",
        character: "as extended-kalman, with each measurement linearised where it leads: more accurate where an error is large for the curvature of h",
        information: &[Information::Noise, Information::ProcessNoise, Information::FirstError],
        keys: tuned,
    }]),
};

/// How often a measurement is linearised, where nothing is given.
const ITERATIONS: usize = 3;

/// The most. Gauss-Newton steps that do not converge in so many do not converge.
const MOST_ITERATIONS: usize = 100;

fn read(given: &Given<'_>, reader: &mut Reader) -> Option<ObserverKind> {
    let filter = filter::read(given, reader);
    let iterations = given.node.get("iterations").map_or(Some(ITERATIONS), Node::count)?;
    if let Some(entry) = given.node.entry("iterations").filter(|_| iterations > MOST_ITERATIONS) {
        let message = format!("`iterations` is {iterations}");
        return reader.refuse(entry.node.span.clone(), message, format!("expected at most {MOST_ITERATIONS}"));
    }
    Some(ExtendedKalman::of(filter?, Some(iterations)).into())
}

fn tuned(context: &Context<'_>) -> Result<Vec<Keys>, String> {
    if context.study.plant.model.structure().has_linear_outputs() {
        return Err("the outputs are linear in the state: it is extended-kalman".to_owned());
    }
    Ok(vec![tuning::filter(context)?])
}
