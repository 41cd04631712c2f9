//! Sampled cubic observers at varying periods.

use luenberger_design::{CubicGain, GainOptions, Periods, VaryingPeriodDesign};
use luenberger_plants::StateSpace;
use luenberger_proof::wording::significant;
use nalgebra::{DMatrix, DVector};

use super::explain::Misfit;
use super::{Designed, facts, linear, matrix, upper_bound, verdict};
use crate::runnable::{Runnable, VaryingPeriods};
use crate::study::LinearSpec;

/// The factor by which V falls from correction to correction.
fn factor(design: &VaryingPeriodDesign) -> f64 {
    let square = design.factor * design.factor;
    if design.nominal.observer.coupling().is_some() { 2.0 * square / (1.0 + square) } else { square }
}

/// What is proved.
pub(crate) fn statement(design: &VaryingPeriodDesign) -> String {
    format!(
        "For {}, with the correction gain K and a prediction over the time that passes: V = e'Pe decreases from correction to correction by the factor {} or less, for every error.",
        design.periods,
        significant(factor(design), 4)
    )
}

/// The observer, with the gains of the nominal period.
pub(super) fn design(
    plant: &StateSpace,
    requested: &LinearSpec,
    theta: &DMatrix<f64>,
    (correction, period, periods): (&CubicGain, f64, &Periods),
    options: &GainOptions,
) -> Result<Designed, Misfit> {
    let linear = linear::of(plant, requested, options)?;
    let design = VaryingPeriodDesign::new(&linear, theta, correction, period, periods)?;
    report(&design, plant, period)
}

/// The observer in numbers and words.
fn report(design: &VaryingPeriodDesign, plant: &StateSpace, period: f64) -> Result<Designed, Misfit> {
    let Designed { mut report, .. } = linear::sampled_report(&design.nominal, plant, period);
    report.statement = format!("{} {}", statement(design), report.statement);
    report.matrices.insert(0, matrix("K", &design.k));
    report.numbers.push(upper_bound("factor of V from correction to correction", factor(design)));
    report.facts = facts(&design.certificate, &[]);
    report.verdict = verdict(&design.certificate);
    let zero = [plant.a.nrows(), plant.b.ncols(), plant.c.nrows()].map(DVector::zeros);
    let varying = VaryingPeriods::new(design.observer.clone(), design.periods, zero.each_ref())?;
    Ok(Designed::new(Runnable::VaryingPeriods(Box::new(varying)), report, Some(design.certificate.clone())))
}
