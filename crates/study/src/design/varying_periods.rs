//! Sampled cubic observers at varying periods.

use luenberger_design::{DesignError, OperatingPoint, Periods, VaryingPeriodDesign};
use luenberger_observers::{DeviationObserver, VaryingPeriodObserver};
use luenberger_plants::StateSpace;
use luenberger_proof::wording::significant;
use luenberger_sim::SampleTimes;
use nalgebra::{DVector, Dyn};

use super::explain::Misfit;
use super::runnable::{At, Runnable};
use super::{Designed, facts, linear, matrix, number, verdict};
use crate::study::SamplingSpec;

/// An observer at varying periods, ready to run; in deviations from an operating point, which is 0 for a linear plant.
#[derive(Debug, Clone)]
pub struct VaryingPeriods {
    /// The observer, which a simulation corrects at the samples that it draws, and a log at its rows.
    pub observer: Box<At<VaryingPeriodObserver<f64, Dyn, Dyn, Dyn>>>,
    /// The periods for which convergence is proved.
    pub periods: Periods,
}

impl VaryingPeriods {
    fn new(
        observer: VaryingPeriodObserver<f64, Dyn, Dyn, Dyn>,
        periods: Periods,
        point: [&DVector<f64>; 3],
    ) -> Result<Self, DesignError> {
        let [x, u, y] = point.map(DVector::clone);
        let observer = DeviationObserver::new(observer, x, u, y)?;
        Ok(Self { observer: Box::new(observer), periods })
    }

    /// The same observer in deviations from an operating point.
    pub(super) fn at(&self, point: &OperatingPoint) -> Result<Self, Misfit> {
        Ok(Self::new(self.observer.inner().clone(), self.periods, [&point.x, &point.u, &point.y])?)
    }

    /// How the samples of a simulation are drawn.
    pub fn sample_times(&self, sampling: &SamplingSpec) -> SampleTimes {
        let (shortest, longest) = sampling.jitter.unwrap_or((self.periods.shortest, self.periods.longest));
        SampleTimes { shortest, longest, misses: sampling.misses.unwrap_or(self.periods.misses), seed: sampling.seed }
    }
}

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

/// The observer in numbers and words.
pub(super) fn report(design: &VaryingPeriodDesign, plant: &StateSpace, period: f64) -> Result<Designed, Misfit> {
    let Designed { mut report, .. } = linear::sampled_report(&design.nominal, plant, period);
    report.statement = format!("{} {}", statement(design), report.statement);
    report.matrices.insert(0, matrix("K", &design.k));
    report.numbers.push(number("factor of V from correction to correction", factor(design)));
    report.facts = facts(&design.certificate, &[]);
    report.verdict = verdict(&design.certificate);
    let zero = [plant.a.nrows(), plant.b.ncols(), plant.c.nrows()].map(DVector::zeros);
    let varying = VaryingPeriods::new(design.observer.clone(), design.periods, zero.each_ref())?;
    Ok(Designed::new(Runnable::VaryingPeriods(Box::new(varying)), report, Some(design.certificate.clone())))
}
