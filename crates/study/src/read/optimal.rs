//! The kind optimal-cubic: what the observer is to be optimal for.

use luenberger_design::EstimationProblem;
use luenberger_plants::Dimensions;
use luenberger_proof::wording::counted;
use nalgebra::DMatrix;

use super::tree::Node;
use super::{Reader, check};
use crate::study::ObserverKind;

/// The noise of a simulation: standard deviations, whether it is uniform, and the time for which a value is held.
struct Simulated {
    deviations: Vec<f64>,
    is_uniform: bool,
    period: f64,
}

/// The problem of the observer `node`; what it does not say is that of `root`'s simulation.
pub(super) fn problem(node: &Node, size: Dimensions, root: &Node, reader: &mut Reader) -> Option<ObserverKind> {
    let (n, p) = (size.states, size.outputs);
    let of_states = format!("the plant has {}", counted(n, "state"));
    let first_errors = reader.numbers(node.get("first_errors")?, "first_errors", n, "state");
    let simulation = root.get("simulation");
    let horizon = node.get("horizon").or_else(|| simulation?.get("duration"));
    if horizon.is_none() {
        let message = "there is no simulation whose duration could be the horizon";
        reader.absent(check::head(node), message, "expected `horizon`, the time of operation after a first error");
    }
    let simulated = simulation.and_then(|simulation| simulated(simulation, p));
    let (noise, is_uniform) = match (node.get("noise_deviation"), &simulated) {
        (Some(given), _) => (reader.numbers(given, "noise_deviation", p, "output"), false),
        (None, Some(simulated)) => (Some(simulated.deviations.clone()), simulated.is_uniform),
        (None, None) => {
            let message = "no noise is given for every output, and without noise no gain is too large";
            let expected = "expected `noise_deviation`, or a [simulation] with `noise` on every output";
            reader.absent(check::head(node), message, expected);
            (None, false)
        }
    };
    let period = match (node.get("noise_period"), &simulated) {
        (Some(period), _) => period.number(),
        (None, Some(simulated)) => Some(simulated.period),
        (None, None) => {
            let message = "the time for which a value of the noise is held is not given";
            reader.absent(check::head(node), message, "expected `noise_period` with `noise_deviation`");
            None
        }
    };
    let process = match node.get("process_noise") {
        Some(process) => semidefinite(process, "process_noise", n, &of_states, reader),
        None => Some(DMatrix::zeros(n, n)),
    };
    let weight = node.given("weight", |weight| semidefinite(weight, "weight", n, &of_states, reader))?;
    if let Some(zero) = weight.as_ref().filter(|weight| weight.amax() == 0.0) {
        let message = format!("`weight` is 0, {} x {}", zero.nrows(), zero.ncols());
        return reader.refuse(node.get("weight")?.span.clone(), message, "expected a weight that counts some error");
    }
    if reader.dt.is_some() {
        return reader.refuse(check::head(node), "this kind is for plants in continuous time", "expected another kind");
    }
    let problem = EstimationProblem::new(&first_errors?, &noise?, period?, horizon?.number()?);
    let weight = weight.unwrap_or_else(|| problem.weight.clone());
    let problem = EstimationProblem { is_uniform, process: process?, weight, ..problem };
    Some(ObserverKind::OptimalCubic(Box::new(problem)))
}

/// A matrix that is symmetric and positive semidefinite.
fn semidefinite(node: &Node, name: &str, n: usize, why: &str, reader: &mut Reader) -> Option<DMatrix<f64>> {
    let matrix = reader.weight(node, name, n, why)?;
    let least =
        luenberger_linalg::symmetric(name_of(name), &matrix).ok().and_then(|m| luenberger_linalg::lambda_min(&m).ok());
    match least {
        Some(least) if least >= -(n as f64) * f64::EPSILON * matrix.norm() => Some(matrix),
        Some(least) => {
            let message = format!("`{name}` has the eigenvalue {}", luenberger_proof::wording::significant(least, 4));
            reader.refuse(node.span.clone(), message, "expected a positive semidefinite matrix")
        }
        None => reader.refuse(node.span.clone(), format!("`{name}` is not symmetric"), "expected a symmetric matrix"),
    }
}

/// What an error calls the matrix.
fn name_of(name: &str) -> &'static str {
    if name == "weight" { "T" } else { "W" }
}

/// The noise of the simulation, if every output has some.
fn simulated(simulation: &Node, outputs: usize) -> Option<Simulated> {
    let noise = simulation.get("noise")?;
    let amplitude = noise.get("amplitude")?.numbers()?;
    if amplitude.len() != outputs || amplitude.iter().any(|amplitude| *amplitude <= 0.0) {
        return None;
    }
    let is_uniform = noise.get("distribution").and_then(Node::text) == Some("uniform");
    let unit = if is_uniform { 3.0_f64.sqrt() } else { 1.0 };
    let deviations = amplitude.iter().map(|amplitude| amplitude / unit).collect();
    Some(Simulated { deviations, is_uniform, period: noise.get("period")?.number()? })
}
