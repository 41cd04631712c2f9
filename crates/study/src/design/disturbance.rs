//! Observers of plants with disturbances: the estimate of a slowly varying one, and an estimate that does not depend on
//! one.

use luenberger_design::{
    CubicDesign, CubicGain, DecoupledPlant, ErrorBound, GainOptions, LinearDesign, UnknownInputDesign,
    disturbances_with_rate, proportional_integral as handed_out, with_disturbance_chain,
};
use luenberger_plants::StateSpace;
use nalgebra::DMatrix;

use super::error_bound::{acting, bounded};
use super::explain::Misfit;
use super::linear::{measurement, of};
use super::{Designed, as_stored, certified, computed_rate, matrix, number, poles, within};
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
    (plant, states): (&StateSpace, &[String]),
    (e, chain): (&DMatrix<f64>, Option<usize>),
    gain: &LinearSpec,
    cubic: Option<&(DMatrix<f64>, f64)>,
    (bounds, rate, names): (Option<&ActingBounds>, &[f64], &[String]),
    options: &GainOptions,
) -> Result<Designed, Misfit> {
    let (n, order) = (plant.a.nrows(), chain.unwrap_or(1));
    let both = with_disturbance_chain(plant, e, order)?;
    let linear = of(&both, gain, options)?;
    let cubic = cubic_of(&linear, cubic)?;
    let certificate = cubic.as_ref().map_or(&linear.certificate, |cubic| &cubic.certificate).clone();
    let runnable = match &cubic {
        None => Runnable::ProportionalIntegral(Box::new(handed_out(linear.observer.clone(), n)?)),
        Some(cubic) => Runnable::ProportionalIntegralCubic(Box::new(handed_out(cubic.observer.clone(), n)?)),
    };
    let speed = -linear.spectral_abscissa();
    let model = match order {
        1 => "a constant disturbance d".to_owned(),
        2 => "a disturbance d that is linear in t".to_owned(),
        k => format!("a disturbance d that is a polynomial in t of degree {}", k - 1),
    };
    // A region of a cubic term is one of the errors of x and d together.
    let stored = cubic.as_ref().and_then(|cubic| as_stored(&cubic.certificate));
    let is_exact = cubic.is_some() && stored.is_none();
    let error = if order == 1 { "e = (x - xhat, d - dhat)" } else { "e = (x - xhat, d - dhat, ..)" };
    let from = match stored.and_then(|theorem| within(theorem, error)) {
        Some(region) => format!("from every initial error{region}"),
        None => "for all x(0), xhat(0) and d".to_owned(),
    };
    let report = DesignReport {
        statement: format!(
            "For {model} {}the errors of x and of d tend to 0, {from}.{}{}",
            if is_exact { "and the real matrix -P^-1 C'S in place of N " } else { "" },
            measurement(plant),
            computed_rate(speed)
        ),
        matrices: matrices(&linear, cubic.as_ref()),
        poles: poles(&linear.poles),
        numbers: vec![number("decay rate", speed)],
        ..certified(&certificate, &[])
    };
    let designed = Designed::new(runnable, report, Some(certificate));
    let Some(bounds) = bounds else { return Ok(designed) };
    let acting = disturbances_with_rate(&acting(bounds), rate, order);
    let bound = match &cubic {
        None => ErrorBound::linear(&linear.observer, &acting)?,
        Some(cubic) => ErrorBound::cubic(cubic, &acting)?,
    };
    let names: Vec<String> = states.iter().chain(names).cloned().collect();
    Ok(bounded(designed, &bound, &names, bounds))
}

pub(super) fn unknown_input(
    plant: &StateSpace,
    e: &DMatrix<f64>,
    gain: &LinearSpec,
    cubic: Option<&(DMatrix<f64>, f64)>,
    options: &GainOptions,
) -> Result<Designed, Misfit> {
    let decoupled = DecoupledPlant::new(plant, e)?;
    let zeros: Vec<String> = decoupled.zeros.iter().map(|zero| eigenvalue([zero.re, zero.im])).collect();
    let linear = match (&gain.gain, &gain.weight) {
        (GainSpec::Poles(poles), Some(weight)) => decoupled.with_poles(poles)?.lyapunov_weight(weight.clone())?,
        (GainSpec::Poles(poles), None) => decoupled.with_poles(poles)?,
        _ => of(&decoupled.reduced, gain, options)?,
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
        zeros => format!(" The invariant zeros of (A, E, C) are among the poles, whatever L is: {}.", zeros.join(", ")),
    };
    let mut all = matrices(&linear, cubic.as_ref());
    all.extend([matrix("H", &decoupled.h), matrix("TA", &decoupled.reduced.a), matrix("TB", &decoupled.reduced.b)]);
    let report = DesignReport {
        statement: format!(
            "For every disturbance d(t) the error of x tends to 0, for all x(0) and xhat(0), with H and T = I - HC as real matrices.{fixed}{}{}",
            measurement(plant),
            computed_rate(speed)
        ),
        matrices: all.into_iter().filter(|m| m.rows.iter().any(|row| !row.is_empty())).collect(),
        poles: poles(&linear.poles),
        numbers: vec![number("decay rate", speed)],
        ..certified(&certificate, &[])
    };
    Ok(Designed::new(runnable, report, Some(certificate)))
}
