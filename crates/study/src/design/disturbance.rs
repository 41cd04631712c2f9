//! Observers of plants with disturbances: the estimate of a slowly varying one, and an estimate that does not depend on
//! one.

use luenberger_design::{
    CubicDesign, CubicGain, DecoupledPlant, ErrorBound, GainOptions, LinearDesign, Pair, UnknownInputDesign,
    disturbances_with_rate, proportional_integral as handed_out, with_disturbance_chain,
};
use luenberger_plants::StateSpace;
use luenberger_proof::certificate::{Reading, Represented};
use nalgebra::DMatrix;

use super::error_bound::{acting, bounded};
use super::explain::Misfit;
use super::linear::{measurement, of};
use super::{Designed, asymptotic_rate, certified, matrix, number, poles, proved_of};
use crate::results::DesignReport;
use crate::results::report::eigenvalue;
use crate::runnable::Runnable;
use crate::study::{ActingBounds, GainSpec, LinearSpec};

/// The numbers of a linear and perhaps a cubic design.
fn matrices(linear: &LinearDesign, cubic: Option<&CubicDesign>) -> Vec<crate::results::NamedMatrix> {
    let mut found = vec![matrix("L", linear.l()), matrix("P", &linear.p), matrix("Q", &linear.q)];
    if let Some(cubic) = cubic {
        found.extend([matrix("N", &cubic.observer.n), matrix("theta", &cubic.observer.theta), matrix("S", &cubic.s)]);
    }
    found
}

fn cubic_of(linear: &LinearDesign, cubic: Option<&(DMatrix<f64>, f64)>) -> Result<Option<CubicDesign>, Misfit> {
    let design = cubic.map(|(theta, gamma)| CubicDesign::new(linear, theta, &CubicGain::Gamma(*gamma)));
    Ok(design.transpose()?)
}

pub(super) fn proportional_integral(
    (plant, reading): (&StateSpace, &Reading<'_>),
    (e, chain): (&DMatrix<f64>, Option<usize>),
    gain: &LinearSpec,
    cubic: Option<&(DMatrix<f64>, f64)>,
    (bounds, rate, names): (Option<&ActingBounds>, &[f64], &[String]),
    options: &GainOptions,
) -> Result<Designed, Misfit> {
    let (n, order) = (plant.a.nrows(), chain.unwrap_or(1));
    let both = with_disturbance_chain(plant, e, order)?;
    let linear = of(&both, gain, options).map_err(|error| error.of_pair(Pair::WithDisturbance))?;
    let cubic = cubic_of(&linear, cubic)?;
    let certificate = cubic.as_ref().map_or(&linear.certificate, |cubic| &cubic.certificate).clone();
    let runnable = match &cubic {
        None => Runnable::ProportionalIntegral(Box::new(handed_out(linear.observer.clone(), n)?)),
        Some(cubic) => Runnable::ProportionalIntegralCubic(Box::new(handed_out(cubic.observer.clone(), n)?)),
    };
    let speed = -linear.spectral_abscissa();
    let all: Vec<String> = reading.states.iter().chain(names).cloned().collect();
    let reading = Reading { states: &all, plant: Represented::WithDisturbance { states: n, order }, ..*reading };
    let report = DesignReport {
        statement: proved_of(&certificate, &reading).remark(measurement(plant)).remark(asymptotic_rate(speed)),
        matrices: matrices(&linear, cubic.as_ref()),
        poles: poles(&linear.poles),
        numbers: vec![number("decay rate", speed)],
        ..certified(&certificate, &[])
    };
    let designed = Designed::new(runnable, report, Some(certificate)).with_continuous(&linear, cubic.as_ref());
    let Some(bounds) = bounds else { return Ok(designed) };
    let acting = disturbances_with_rate(&acting(bounds), rate, order);
    let bound = match &cubic {
        None => ErrorBound::linear(&linear.observer, &acting)?,
        Some(cubic) => ErrorBound::cubic(cubic, &acting)?,
    };
    Ok(bounded(designed, &bound, &reading, bounds))
}

pub(super) fn unknown_input(
    (plant, reading): (&StateSpace, &Reading<'_>),
    e: &DMatrix<f64>,
    gain: &LinearSpec,
    cubic: Option<&(DMatrix<f64>, f64)>,
    options: &GainOptions,
) -> Result<Designed, Misfit> {
    let decoupled = DecoupledPlant::new(plant, e)?;
    let zeros: Vec<String> = decoupled.zeros.iter().map(|zero| eigenvalue([zero.re, zero.im])).collect();
    let linear = match &gain.gain {
        GainSpec::Poles(poles) => decoupled.with_poles_and_weight(poles, gain.weight.clone().unwrap_or_default())?,
        _ => of(&decoupled.reduced, gain, options).map_err(|error| error.of_pair(Pair::Decoupled))?,
    };
    let cubic = cubic_of(&linear, cubic)?;
    let (runnable, certificate) = match &cubic {
        None => {
            let design = UnknownInputDesign::linear(&decoupled, &linear)?;
            (Runnable::UnknownInput(Box::new(design.observer.clone())), design.certificate.clone())
        }
        Some(cubic) => {
            let design = UnknownInputDesign::cubic(&decoupled, cubic)?;
            (Runnable::UnknownInputCubic(Box::new(design.observer.clone())), design.certificate.clone())
        }
    };
    let speed = -linear.spectral_abscissa();
    let fixed = match zeros.as_slice() {
        [] => String::new(),
        zeros => format!("The invariant zeros of (A, E, C) are among the poles, whatever L is: {}.", zeros.join(", ")),
    };
    let mut all = matrices(&linear, cubic.as_ref());
    all.extend([matrix("H", &decoupled.h), matrix("TA", &decoupled.reduced.a), matrix("TB", &decoupled.reduced.b)]);
    let report = DesignReport {
        statement: proved_of(&certificate, reading)
            .remark(fixed)
            .remark(measurement(plant))
            .remark(asymptotic_rate(speed)),
        matrices: all.into_iter().filter(|m| m.rows.iter().any(|row| !row.is_empty())).collect(),
        poles: poles(&linear.poles),
        numbers: vec![number("decay rate", speed)],
        ..certified(&certificate, &[])
    };
    Ok(Designed::new(runnable, report, Some(certificate)))
}
