//! Sampled cubic observers at varying periods.

use luenberger_design::{CubicGain, GainOptions, Periods, VaryingPeriodDesign};
use luenberger_plants::StateSpace;
use luenberger_proof::certificate::Reading;
use nalgebra::{DMatrix, DVector};

use super::explain::Misfit;
use super::{Designed, facts, linear, matrix, proved_of, upper_bound};
use crate::results::{DesignVerdict, Statement};
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

/// The observer, with the gains of the nominal period.
pub(super) fn design(
    (plant, reading): (&StateSpace, &Reading<'_>),
    requested: &LinearSpec,
    theta: &DMatrix<f64>,
    (correction, period, periods): (&CubicGain, f64, &Periods),
    options: &GainOptions,
) -> Result<Designed, Misfit> {
    let linear = linear::of(plant, requested, options)?;
    let design = VaryingPeriodDesign::new(&linear, theta, correction, period, periods)?;
    report(&design, (plant, reading), period)
}

/// The observer in numbers and words.
fn report(
    design: &VaryingPeriodDesign,
    (plant, reading): (&StateSpace, &Reading<'_>),
    period: f64,
) -> Result<Designed, Misfit> {
    let Designed { mut report, .. } = linear::sampled_report(&design.nominal, (plant, reading), period);
    let computed: Vec<String> = report.statement.remarks().map(str::to_owned).collect();
    report.statement = computed.into_iter().fold(proved_of(&design.certificate, reading), Statement::remark);
    report.matrices.insert(0, matrix("K", &design.k));
    report.numbers.push(upper_bound("factor of V from correction to correction", factor(design)));
    report.facts = facts(&design.certificate, &[]);
    report.verdict = DesignVerdict::of(&design.certificate);
    let zero = [plant.a.nrows(), plant.b.ncols(), plant.c.nrows()].map(DVector::zeros);
    let varying = VaryingPeriods::new(design.observer.clone(), design.periods, zero.each_ref())?;
    Ok(Designed::new(Runnable::VaryingPeriods(Box::new(varying)), report, Some(design.certificate.clone())))
}
