//! Design of each `[[observer]]`, or the reason why it has none.

mod alternative;
mod discrete;
mod disturbance;
mod error_bound;
mod explain;
mod feedback;
mod functional;
mod immersion;
mod interval;
mod kkl;
mod kkl_maps;
mod linear;
mod moving_horizon;
mod noise_gain;
mod nonlinear;
pub(crate) mod norm_filter;
mod operating_point;
mod optimal;
pub(crate) mod peb;
mod printed_mean_value;
mod reduced_order;
mod sliding_mode;
mod unscented;
mod varying_periods;

pub use crate::designed::Designed;
pub use crate::runnable::{At, Chains, Kkl, Runnable, VaryingPeriods, WithDisturbance, WithoutDisturbance};
pub use crate::study::PrintedMean;
pub(crate) use interval::{Sampling, sampled_design as sampled_interval};
pub use kkl_maps::candidate;
pub use luenberger_export::moving_horizon::LONGEST_WINDOW;
pub(crate) use noise_gain::SPEED_RATIO;

use std::sync::atomic::AtomicBool;
use std::time::Instant;

use luenberger_design::numerical_kkl::NumericalKklError;
use luenberger_design::{Certificate, DesignError, DiscreteDesign, Fact, GainOptions, LinearDesign};
use luenberger_observers::Prediction;
use luenberger_plants::StateSpace;
use luenberger_proof::Verdict;
use luenberger_proof::certificate::Reading;
use luenberger_proof::wording::at_least;
use luenberger_proof::wording::significant;
use nalgebra::{Complex, DMatrix};

use self::explain::Misfit;
use crate::results::{
    DesignReport, DesignVerdict, FactReport, FailureReport, NamedMatrix, NamedNumber, Rounding, Statement,
};
use crate::study::{LinearSpec, ObserverKind, ObserverSpec, Study};

/// Why an observer has no design.
#[derive(Debug, Clone, PartialEq)]
pub enum NoDesign {
    /// The observer is not applicable to the plant: violated hypothesis, alternatives and hints.
    Misfit(FailureReport),
    /// Interrupted by the user.
    Interrupted,
}

impl From<FailureReport> for NoDesign {
    fn from(failure: FailureReport) -> Self {
        Self::Misfit(failure)
    }
}

/// The design of one observer of a study; of one that is refused, the alternatives that have a design. A design of
/// kind `kkl-numerical` takes minutes; it checks `cancel` continuously and stops once it is true.
///
/// # Errors
/// [`NoDesign`].
pub fn design(study: &Study, requested: &ObserverSpec, cancel: &AtomicBool) -> Result<Designed, NoDesign> {
    design_until(study, requested, cancel, None)
}

/// As [`design`], stopped at the instant `end` if there is one: matrix inequalities are solved no further, and a design
/// that fails for it is [`NoDesign::Interrupted`].
///
/// # Errors
/// [`NoDesign`].
pub fn design_until(
    study: &Study,
    requested: &ObserverSpec,
    cancel: &AtomicBool,
    end: Option<Instant>,
) -> Result<Designed, NoDesign> {
    attempt(study, requested, cancel, end).map_err(|none| match none {
        NoDesign::Misfit(refusal) => alternative::tried(study, requested, refusal, (cancel, end)).into(),
        NoDesign::Interrupted => NoDesign::Interrupted,
    })
}

/// As [`design_until`], without the alternatives of a refusal, which have to be designed themselves.
pub(crate) fn attempt(
    study: &Study,
    requested: &ObserverSpec,
    cancel: &AtomicBool,
    end: Option<Instant>,
) -> Result<Designed, NoDesign> {
    let designed = study.plant.names().with(|| in_words(study, requested, cancel, end));
    match designed {
        Err(_) if end.is_some_and(|end| Instant::now() >= end) => Err(NoDesign::Interrupted),
        designed => designed,
    }
}

/// As [`design_until`], with the names of the study in all messages.
fn in_words(
    study: &Study,
    requested: &ObserverSpec,
    cancel: &AtomicBool,
    end: Option<Instant>,
) -> Result<Designed, NoDesign> {
    let model = &study.plant.model;
    let options = requested.limits.options(study.solver, end);
    if let Some(dt) = study.plant.dt {
        return discrete::design(study, requested, dt, end);
    }
    // A nonlinear plant is linearised at the operating point, and the observer shifted there.
    let shift = if model.linear().is_some() { None } else { study.operating_point.as_ref() };
    let linear = || {
        let plant = model.linear().or_else(|| shift.map(|point| point.linear.clone()));
        plant.ok_or_else(|| explain::not_linear(study, requested))
    };
    let shifted = |design: Result<Designed, Misfit>| {
        design.and_then(|design| match shift {
            Some(point) => operating_point::shifted(study, design, point),
            None => Ok(design),
        })
    };
    let in_loop = |plant: &StateSpace, designed: Designed| match &designed.runnable {
        Runnable::Linear(observer) => {
            let l = observer.l.clone();
            feedback::linear(study, requested, plant, &l, designed)
        }
        _ => designed,
    };
    let explained = |misfit| match misfit {
        Misfit::NumericalKkl(NumericalKklError::Stopped { .. }) => NoDesign::Interrupted,
        misfit => explain::misfit(study, requested, &misfit).into(),
    };
    if let ObserverKind::MeanValue { .. }
    | ObserverKind::HighGain { .. }
    | ObserverKind::Kkl(_)
    | ObserverKind::ImmersionInvariance(_)
    | ObserverKind::Pebo(_)
    | ObserverKind::KklPeb(_)
    | ObserverKind::KklNumerical(_) = requested.kind
    {
        explain::output_of_the_state(study, requested)?;
    }
    match &requested.kind {
        ObserverKind::Luenberger(gain) | ObserverKind::Kalman(gain) => {
            let plant = linear()?;
            let designed = linear::luenberger(study, &plant, gain, (&options, requested.bounds.as_ref()));
            shifted(designed.map(|designed| in_loop(&plant, designed))).map_err(explained)
        }
        ObserverKind::Cubic { linear: gain, theta, correction } => {
            let options = (&options, requested.bounds.as_ref());
            let plant = linear()?;
            let of = (study, requested.name.as_str());
            shifted(linear::cubic(of, &plant, gain, theta, correction, options)).map_err(explained)
        }
        ObserverKind::OptimalCubic(problem) => {
            let plant = model.linear().ok_or_else(|| explain::not_linear(study, requested))?;
            optimal::design(study, &plant, problem, (requested.bounds.as_ref(), end)).map_err(explained)
        }
        ObserverKind::ProportionalIntegral { e, chain, rate, linear: gain, cubic } => {
            let plant = model.linear().ok_or_else(|| explain::not_linear(study, requested))?;
            let names = requested.kind.estimated_disturbances();
            let acting = (requested.bounds.as_ref(), rate.as_slice(), names.as_slice());
            let reading = study.plant.reading();
            let (plant, e) = ((&plant, &reading), (e, *chain));
            disturbance::proportional_integral(plant, e, gain, cubic.as_ref(), acting, &options).map_err(explained)
        }
        ObserverKind::UnknownInput { e, linear: gain, cubic } => {
            let plant = model.linear().ok_or_else(|| explain::not_linear(study, requested))?;
            let reading = study.plant.reading();
            disturbance::unknown_input((&plant, &reading), e, gain, cubic.as_ref(), &options).map_err(explained)
        }
        ObserverKind::SlidingMode(spec) => sliding_mode::design(study, requested, spec),
        ObserverKind::Interval(spec) => {
            let plant = model.linear().ok_or_else(|| explain::not_linear(study, requested))?;
            let reading = study.plant.reading();
            interval::continuous((&plant, &reading), spec, requested.bounds.as_ref(), &options).map_err(explained)
        }
        ObserverKind::ReducedOrder(poles) => {
            explain::output_of_the_state(study, requested)?;
            let plant = model.linear().ok_or_else(|| explain::not_linear(study, requested))?;
            reduced_order::reduced_order(study, &plant, poles).map_err(explained)
        }
        ObserverKind::Functional { k, poles } => {
            explain::output_of_the_state(study, requested)?;
            let plant = model.linear().ok_or_else(|| explain::not_linear(study, requested))?;
            functional::functional(&plant, k, poles).map_err(explained)
        }
        ObserverKind::NormFilter(spec) => {
            let plant = linear()?;
            let designed = norm_filter::norm_filter(study, &plant, spec, None, &options);
            shifted(designed.map(|designed| in_loop(&plant, designed))).map_err(explained)
        }
        ObserverKind::SampledCubic { linear: gain, theta, correction, period, varying } => {
            let (plant, reading) = (linear()?, study.plant.reading());
            let designed = match varying {
                Some(periods) => {
                    varying_periods::design((&plant, &reading), gain, theta, (correction, *period, periods), &options)
                }
                None => linear::sampled((&plant, &reading), gain, theta, (correction, *period), &options),
            };
            shifted(designed).map_err(explained)
        }
        ObserverKind::Lpv { region, rate } => nonlinear::lpv(study, region, rate, &options).map_err(explained),
        ObserverKind::Lipschitz { split, region, rate, gain } => {
            nonlinear::lipschitz(study, split.as_ref(), region, *rate, gain.as_ref(), &options).map_err(explained)
        }
        ObserverKind::MeanValue { eta, internal_error, printed: Some(mean), .. } => {
            explain::first_states_measured(study, requested)?;
            printed_mean_value::design(model, *mean, *eta, internal_error).map_err(explained)
        }
        ObserverKind::MeanValue { region, rate, eta, internal_error, printed: None } => {
            explain::first_states_measured(study, requested)?;
            nonlinear::mean_value(study, region, *rate, *eta, internal_error, &options).map_err(explained)
        }
        ObserverKind::HighGain { r, alpha, maps: Some(maps), .. } => {
            nonlinear::high_gain_maps(study, requested, maps, alpha, *r).map_err(explained)
        }
        ObserverKind::HighGain { r, chains, alpha, maps: None } => {
            nonlinear::high_gain(explain::chains(study, requested, chains)?, alpha, *r).map_err(explained)
        }
        ObserverKind::ExtendedKalman { w, v, p0, period, gate, .. } => {
            nonlinear::extended_kalman(model, (w, v, p0), *period, *gate).map_err(explained)
        }
        ObserverKind::Unscented(spec) => unscented::design(model, spec, Prediction::ErrorControlled).map_err(explained),
        ObserverKind::MovingHorizon(spec) => {
            moving_horizon::design(model, spec, Prediction::ErrorControlled).map_err(explained)
        }
        ObserverKind::Kkl(spec) => kkl_maps::kkl(model, spec, &study.plant.reading()).map_err(explained),
        ObserverKind::ImmersionInvariance(spec) => {
            explain::output_without_time(study, requested)?;
            immersion::immersion(study, spec).map_err(explained)
        }
        ObserverKind::Pebo(spec) | ObserverKind::KklPeb(spec) => peb::peb(study, requested, spec).map_err(explained),
        ObserverKind::KklNumerical(kkl) => {
            explain::tabulated(study, requested, kkl)?;
            kkl::design(model, kkl, cancel).map_err(explained)
        }
    }
}

/// The linear design of a specification, for a plant in discrete time; why there is none.
pub(crate) fn discrete_design(
    study: &Study,
    plant: &StateSpace,
    gain: &LinearSpec,
    dt: f64,
    observer: &ObserverSpec,
) -> Result<DiscreteDesign, String> {
    match discrete::gain_of(study, plant, (gain, dt), observer) {
        Ok(design) => design.map_err(|misfit| explain::misfit(study, observer, &misfit).hypothesis),
        Err(failure) => Err(failure.hypothesis),
    }
}

/// The linear design of a specification.
pub(crate) fn linear_design(
    plant: &StateSpace,
    gain: &LinearSpec,
    options: &GainOptions,
) -> Result<LinearDesign, DesignError> {
    linear::of(plant, gain, options)
}

pub(crate) fn matrix(name: &str, m: &DMatrix<f64>) -> NamedMatrix {
    let rows = m.row_iter().map(|row| row.iter().copied().collect()).collect();
    NamedMatrix { name: name.to_owned(), rows }
}

/// A computed number.
pub(crate) fn number(name: &str, value: f64) -> NamedNumber {
    NamedNumber { name: name.to_owned(), value: value.is_finite().then_some(value), rounding: Rounding::Nearest }
}

/// A number that is proved to be at least this.
pub(crate) fn lower_bound(name: &str, value: f64) -> NamedNumber {
    NamedNumber { rounding: Rounding::Down, ..number(name, value) }
}

/// A number that is proved to be at most this.
pub(crate) fn upper_bound(name: &str, value: f64) -> NamedNumber {
    NamedNumber { rounding: Rounding::Up, ..number(name, value) }
}

fn poles(poles: &[Complex<f64>]) -> Vec<[f64; 2]> {
    let mut poles: Vec<[f64; 2]> = poles.iter().map(|pole| [pole.re, pole.im]).collect();
    poles.sort_by(|x, y| x[0].total_cmp(&y[0]).then(x[1].total_cmp(&y[1])));
    poles
}

/// The facts of a certificate, each with its verdict in words: those that are not verified first, then by margin, the
/// smallest first, and at the end those without a margin.
fn facts(certificate: &Certificate, vertices: &[String]) -> Vec<FactReport> {
    let mut facts: Vec<FactReport> = certificate.facts().map(|each| fact(each, vertices)).collect();
    let order = |fact: &FactReport| match (fact.verdict.is_proved(), fact.margin) {
        (true, Some(margin)) if margin > 0.0 => margin,
        (true, _) => f64::INFINITY,
        _ => f64::NEG_INFINITY,
    };
    facts.sort_by(|x, y| order(x).total_cmp(&order(y)));
    facts
}

fn fact(fact: &Fact, vertices: &[String]) -> FactReport {
    let words = match &fact.verdict {
        Verdict::Proved { margin } if *margin > 0.0 => {
            format!("verified; margin >= {}", at_least(*margin, 4))
        }
        Verdict::Proved { .. } => "verified; no margin".to_owned(),
        Verdict::Refuted { witness } => format!("false for these numbers: {witness}"),
        Verdict::Undecided { why, best } if best.is_nan() => format!("undecided: {why}"),
        Verdict::Undecided { why, best } => {
            format!("undecided: {why} (margin in floating point: {})", significant(*best, 4))
        }
    };
    FactReport {
        statement: fact.inequality_naming(vertices),
        verdict: DesignVerdict::of_fact(&fact.verdict),
        margin: fact.verdict.margin(),
        words,
    }
}

/// What a certificate proves of the plant that it is read as; that nothing is proved, where that is so.
fn proved_of(certificate: &Certificate, reading: &Reading<'_>) -> Statement {
    Statement::of_proved(certificate.sentences(reading))
}

/// The rate at which errors decay in the end, by the poles in floating point.
fn asymptotic_rate(rate: f64) -> String {
    format!("Computed: asymptotic rate exp(-{} t).", significant(rate, 5))
}

/// The same from sample to sample.
fn asymptotic_factor(radius: f64) -> String {
    format!("Computed: asymptotic factor {} at each sample.", significant(radius, 5))
}

/// The part of a report that is the certificate's; the rest is empty.
fn certified(certificate: &Certificate, vertices: &[String]) -> DesignReport {
    DesignReport {
        facts: facts(certificate, vertices),
        verdict: DesignVerdict::of(certificate),
        ..DesignReport::default()
    }
}

/// That of a design without a certificate, for this reason.
fn uncertified(why: &str) -> DesignReport {
    DesignReport {
        verdict: DesignVerdict::NONE,
        evidence: Some(format!("no certificate: {why}")),
        ..DesignReport::default()
    }
}
