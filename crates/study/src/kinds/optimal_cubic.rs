//! The cubic observer of least cost, beside the linear optimum.

use luenberger_design::{
    CubicDesign, DiscreteDesign, EstimationProblem, LinearDesign, OptimalCubicDesign, SampledCubicDesign,
};
use luenberger_plants::{Dimensions, StateSpace};
use luenberger_proof::wording::{counted, significant};
use nalgebra::DMatrix;

use super::cubic;
use super::declaration::{Declaration, Information, Rule, Tuning};
use super::keys::ERROR_BOUNDS;
use super::{Kind, as_kind};
use crate::designed::SampledDesign;
use crate::keys::Key;
use crate::reader::tree::Node;
use crate::reader::{Given, Reader, check};
use crate::results::{NoObserver, Statement};
use crate::study::{ObserverKind, PlantClass, Specification, Study, Time, unknowns};
use crate::synthesis::linear::linear_report;
use crate::synthesis::{Designed, Plan, Sampling, matrix, number};
use crate::tuning::{
    Context, Keys, Value, continuous as in_continuous_time, linear as is_linear, noisy, process_noise, short,
};

/// The kind.
pub(super) static DECLARATION: Declaration = Declaration {
    name: "optimal-cubic",
    about: "Cubic observer whose gains L, N and theta have the least cost for given noise and first errors, found by a search from the linear optimum, for linear plants.",
    source: "open problem of Share Pasand, Luenberger-type cubic observers: docs/theory-cubic.md",
    plant: PlantClass::Linear(Time::CONTINUOUS),
    keys: &[Costs::KEYS],
    kind: as_kind::<OptimalCubic>,
    read,
    takes_long: true,
    tuning: Tuning::Rules(&[Rule {
        name: "optimal-cubic",
        turn: 8,
        tuning: "the least cost for the intensities of process and measurement noise and first errors of the given size, each error in units of its scale, over the duration of the simulation",
        source: "docs/theory-cubic.md",
        character: "its gains L and N have the least cost that a search finds, and it is linear where no cubic term pays; it pays for pushes that nobody expects, while for a first error of known covariance a Kalman filter that starts from it costs less",
        information: &[Information::Noise, Information::ProcessNoise, Information::FirstError],
        keys: tuned,
    }]),
};

/// The noise of a simulation: standard deviations, whether it is uniform, and the time for which a value is held.
struct Simulated {
    deviations: Vec<f64>,
    is_uniform: bool,
    period: f64,
}

crate::keys! {
    /// What the cost is of.
    struct Costs {
        /// Semi-axes of the ellipsoid of first errors x(0) - xhat(0), n numbers.
        first_errors: Vec<f64>[n] as Numbers(Positive),
        /// Time of operation that follows a first error: the factor of the error under noise in the cost (default: the
        /// duration of the simulation).
        horizon: Option<f64> as Number(Positive),
        /// Standard deviations of the measurement noise, p numbers, of a normal distribution (default: the noise of the
        /// simulation, with its distribution).
        noise_deviation: Option<Vec<f64>>[p] as Numbers(Positive),
        /// Time for which each value of the noise is held (default: that of the simulation).
        noise_period: Option<f64> as Number(Positive),
        /// Intensity of the process noise, n x n, per unit of time (default 0).
        process_noise: Option<DMatrix<f64>> as Weight => |key, given, reader| semidefinite(key, "W", given, reader),
        /// T of e'Te in the cost, n x n (default: each error in units of its first error).
        weight: Option<DMatrix<f64>> as Weight => |key, given, reader| semidefinite(key, "T", given, reader),
        ..[&[ERROR_BOUNDS]]
    }
}

/// The problem of the observer; what it does not say is that of the simulation.
fn read(given: &Given<'_>, reader: &mut Reader) -> Option<ObserverKind> {
    let (node, root, Dimensions { states: n, outputs: p, .. }) = (given.node, given.root, given.size());
    let costs = Costs::read(given, reader);
    let simulation = root.get("simulation");
    let missing = |key: &str| node.get(key).is_none();
    let duration = simulation.and_then(|simulation| simulation.get("duration")?.number());
    if missing("horizon") && duration.is_none() {
        let message = "there is no simulation whose duration could be the horizon";
        reader.absent(check::head(node), message, "expected `horizon`, the time of operation after a first error");
    }
    let simulated = simulation.and_then(|simulation| simulated(simulation, p));
    if missing("noise_deviation") && simulated.is_none() {
        let message = "no noise is given for every output, and without noise no gain is too large";
        let expected = "expected `noise_deviation`, or a [simulation] with `noise` on every output";
        reader.absent(check::head(node), message, expected);
    }
    if missing("noise_period") && simulated.is_none() {
        let message = "the time for which a value of the noise is held is not given";
        reader.absent(check::head(node), message, "expected `noise_period` with `noise_deviation`");
    }
    let Costs { first_errors, horizon, noise_deviation, noise_period, process_noise, weight } = costs?;
    if let Some(zero) = weight.as_ref().filter(|weight| weight.amax() == 0.0) {
        let message = format!("`weight` is 0, {} x {}", zero.nrows(), zero.ncols());
        return reader.refuse(node.get("weight")?.span.clone(), message, "expected a weight that counts some error");
    }
    let is_uniform = noise_deviation.is_none() && simulated.as_ref().is_some_and(|of| of.is_uniform);
    let period = noise_period.or(simulated.as_ref().map(|of| of.period))?;
    let deviations = noise_deviation.or(simulated.map(|of| of.deviations))?;
    let problem = EstimationProblem::new(&first_errors, &deviations, period, horizon.or(duration)?);
    let weight = weight.unwrap_or_else(|| problem.weight.clone());
    let process = process_noise.unwrap_or_else(|| DMatrix::zeros(n, n));
    Some(OptimalCubic(EstimationProblem { is_uniform, process, weight, ..problem }).into())
}

/// A matrix that is symmetric and positive semidefinite, which an error calls `symbol`.
#[expect(clippy::option_option, reason = "wrong, absent, or given")]
fn semidefinite(
    key: &Key,
    symbol: &'static str,
    given: &Given<'_>,
    reader: &mut Reader,
) -> Option<Option<DMatrix<f64>>> {
    let (Some(node), name, n) = (given.node.get(key.name), key.name, given.size().states) else { return Some(None) };
    let matrix = reader.weight(node, name, n, &format!("the plant has {}", counted(n, "state")))?;
    let least = luenberger_linalg::symmetric(symbol, &matrix).ok().and_then(|m| luenberger_linalg::lambda_min(&m).ok());
    match least {
        Some(least) if least >= -(n as f64) * f64::EPSILON * matrix.norm() => Some(Some(matrix)),
        Some(least) => {
            let message = format!("`{name}` has the eigenvalue {}", significant(least, 4));
            reader.refuse(node.span.clone(), message, "expected a positive semidefinite matrix")
        }
        None => reader.refuse(node.span.clone(), format!("`{name}` is not symmetric"), "expected a symmetric matrix"),
    }
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

/// The cubic observer that is optimal for this problem.
#[derive(Debug, Clone, PartialEq)]
pub struct OptimalCubic(pub EstimationProblem);

impl Specification for OptimalCubic {
    declared!();

    // Evaluations of the cost, each of up to 20000 periods of the noise.
    fn seconds(&self, study: &Study) -> f64 {
        let n = study.plant.states.len() as f64;
        1e-3 * n * n * 300.0 * unknowns(study)
    }
}

impl Kind for OptimalCubic {
    fn design(&self, plan: &Plan<'_>) -> Result<Designed, NoObserver> {
        let plant = plan.linear()?;
        designed(plan, plant, &self.0)
    }

    fn sampled(&self, of: &Sampling<'_>) -> Result<Option<SampledDesign>, NoObserver> {
        let Some(plant) = of.plant() else { return Ok(None) };
        let sampled = |linear: &LinearDesign, cubic: Option<&CubicDesign>| {
            Ok(Some(match cubic {
                Some(cubic) => {
                    let design = SampledCubicDesign::from_cubic_with_weight(linear, cubic, of.period)?;
                    SampledDesign::Cubic(Box::new(design))
                }
                None => SampledDesign::Linear(Box::new(DiscreteDesign::sampled(linear, of.period)?)),
            }))
        };
        if let Some((linear, designed)) = of.designed.and_then(|designed| Some((designed.linear()?, designed))) {
            return sampled(linear, designed.cubic());
        }
        let found = OptimalCubicDesign::new(plant, &self.0, of.plan.end)?;
        sampled(&found.linear, found.cubic.as_ref())
    }
}

fn designed(plan: &Plan<'_>, plant: &StateSpace, problem: &EstimationProblem) -> Result<Designed, NoObserver> {
    let (study, bounds) = (plan.study, plan.requested.bounds.as_ref());
    let found = OptimalCubicDesign::new(plant, problem, plan.end)?;
    let mut designed = match &found.cubic {
        Some(cubic) => cubic::report(study, plant, (&found.linear, cubic), bounds)?,
        None => linear_report(study, plant, &found.linear, bounds)?,
    };
    let (cost, linear) = (found.cost, found.linear_cost);
    let comparison = match &found.cubic {
        Some(_) => format!(
            "Its cost J is {}, that of the linear optimum {}: {} % less.",
            significant(cost.total, 4),
            significant(linear.total, 4),
            significant(100.0 * found.cost_reduction(), 3)
        ),
        None => format!(
            "The cubic term does not pay: no cubic observer was found whose cost J is less than that of the linear optimum, {}, by a thousandth. This is the linear optimum.",
            significant(linear.total, 4)
        ),
    };
    let report = &mut designed.report;
    report.statement = Statement::of(comparison).and(&report.statement);
    if found.cubic.is_some() {
        report.matrices.push(matrix("L of the linear optimum", &found.linear_gain));
    }
    report.numbers.extend([
        number("cost J", cost.total),
        number("cost J: first errors", cost.transient),
        number("cost J: noise", cost.total - cost.transient),
        number("cost J of the linear optimum", linear.total),
        number("cost J of the linear optimum: first errors", linear.transient),
        number("cost J of the linear optimum: noise", linear.total - linear.transient),
        number("cost J of the Kalman gain", found.kalman_cost.total),
        number("cubic observers evaluated", found.evaluations as f64),
    ]);
    Ok(designed)
}

/// Semi-axes of the ellipsoid whose points have the standard deviations of the first error, `sqrt(n)` of them.
fn tuned(context: &Context<'_>) -> Result<Vec<Keys>, String> {
    in_continuous_time(context)?;
    is_linear(context)?;
    noisy(context)?;
    let information = context.information;
    let axes = (information.first_error.len() as f64).sqrt();
    // Outputs whose noise is held for a longer time have the same intensity here.
    let deviations = information.intensity.iter().map(|intensity| short((intensity / information.held).sqrt()));
    let weight = information.scale.iter().map(|scale| short(1.0 / (scale * scale)));
    Ok(vec![vec![
        ("first_errors", Value::numbers(information.first_error.iter().map(|deviation| short(axes * deviation)))),
        ("noise_deviation", Value::numbers(deviations)),
        ("noise_period", Value::Number(information.held)),
        ("process_noise", Value::weight(&process_noise(context)?)),
        ("weight", Value::numbers(weight)),
    ]])
}
