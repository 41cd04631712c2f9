//! Sampled cubic observers at varying periods.

use luenberger_design::{CubicGain, GainOptions, Periods, VaryingPeriodDesign};
use luenberger_plants::StateSpace;
use luenberger_proof::wording::at_most;
use nalgebra::{DMatrix, DVector};

use super::explain::Misfit;
use super::{Designed, facts, linear, matrix, upper_bound, verdict};
use crate::runnable::{Runnable, VaryingPeriods};
use crate::study::LinearSpec;

/// The factor to which V falls from correction to correction, rounded upwards.
fn factor(design: &VaryingPeriodDesign) -> f64 {
    let square = (design.factor * design.factor).next_up();
    if design.nominal.observer.coupling().is_some() {
        // Grows with the square; 2 square is exact.
        (2.0 * square / (1.0 + square).next_down()).next_up()
    } else {
        square
    }
}

/// What is proved.
pub(crate) fn statement(design: &VaryingPeriodDesign) -> String {
    format!(
        "For {}, with the correction gain K and a prediction over the time that passes: before each correction V = e'Pe is at most {} times what it was before the last one, for every error.",
        design.periods,
        at_most(factor(design), 4)
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
    let slowest = design.nominal.poles.iter().map(|pole| pole.norm()).fold(0.0, f64::max);
    report.statement = format!(
        "{}{}{}",
        statement(design),
        linear::semi_implicit(&design.nominal),
        linear::of_samples(plant, slowest)
    );
    report.matrices.insert(0, matrix("K", &design.k));
    report.numbers.push(upper_bound("factor of V from correction to correction", factor(design)));
    report.facts = facts(&design.certificate, &[]);
    report.verdict = verdict(&design.certificate);
    let zero = [plant.a.nrows(), plant.b.ncols(), plant.c.nrows()].map(DVector::zeros);
    let varying = VaryingPeriods::new(design.observer.clone(), design.periods, zero.each_ref())?;
    Ok(Designed::new(Runnable::VaryingPeriods(Box::new(varying)), report, Some(design.certificate.clone())))
}
