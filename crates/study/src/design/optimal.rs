//! The cubic observer of least cost, beside the linear optimum.

use std::time::Instant;

use luenberger_design::{EstimationProblem, OptimalCubicDesign};
use luenberger_plants::StateSpace;
use luenberger_proof::wording::significant;

use super::explain::Misfit;
use super::linear::{cubic_report, linear_report};
use super::{Designed, matrix, number};
use crate::results::Statement;
use crate::study::{ActingBounds, Study};

pub(super) fn design(
    study: &Study,
    plant: &StateSpace,
    problem: &EstimationProblem,
    (bounds, end): (Option<&ActingBounds>, Option<Instant>),
) -> Result<Designed, Misfit> {
    let found = OptimalCubicDesign::new(plant, problem, end)?;
    let mut designed = match &found.cubic {
        Some(cubic) => cubic_report(study, plant, (&found.linear, cubic), bounds)?,
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
