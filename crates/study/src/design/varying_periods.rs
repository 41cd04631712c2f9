//! Sampled cubic observers at varying periods.

use luenberger_design::{CubicGain, GainOptions, Periods, VaryingPeriodDesign};
use luenberger_plants::StateSpace;
use luenberger_proof::certificate::{Reading, Theorem};
use nalgebra::{DMatrix, DVector};

use super::explain::Misfit;
use super::{Designed, facts, linear, matrix, proved_of, upper_bound};
use crate::deployment::SampledDesign;
use crate::designed::Origin;
use crate::results::{DesignVerdict, Statement};
use crate::runnable::{Runnable, VaryingPeriods};
use crate::study::LinearSpec;

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
    report.numbers.extend(design.certificate.theorems().iter().find_map(|proved| match proved.theorem() {
        Theorem::VaryingPeriodConvergence(periods) => {
            Some(upper_bound("factor of V from correction to correction", periods.decrease()))
        }
        _ => None,
    }));
    report.facts = facts(&design.certificate, &[]);
    report.verdict = DesignVerdict::of(&design.certificate);
    let zero = [plant.a.nrows(), plant.b.ncols(), plant.c.nrows()].map(DVector::zeros);
    let varying = VaryingPeriods::new(design.observer.clone(), design.periods, zero.each_ref())?;
    Ok(Designed {
        runnable: Runnable::VaryingPeriods(Box::new(varying)),
        report,
        certificate: Some(design.certificate.clone()),
        origin: Origin::Sampled(SampledDesign::Varying(Box::new(design.clone()))),
    })
}
