//! H-infinity and H2 filters, for the plant and for its sampled form: the kinds `h-infinity` and `h2`.

use luenberger_design::{
    DesignError, DiscreteDesign, GainOptions, GeneralizedPlant, LinearDesign, NormFilterDesign, NormTarget, SystemNorm,
    TimeDomain,
};
use luenberger_linalg::zero_order_hold;
use luenberger_observers::DiscreteLinearObserver;
use luenberger_plants::StateSpace;
use luenberger_proof::wording::{at_most, counted};
use nalgebra::{DMatrix, Dyn};

use super::keys::MAX_GAIN;
use super::settings::one_of;
use super::{Kind, h_infinity, h2};
use crate::designed::{Runnable, SampledDesign};
use crate::keys::Key;
use crate::reader::{Given, Reader};
use crate::results::{Advice, Cause, DesignReport, NoObserver, Proposal, Quantity};
use crate::steps::around;
use crate::study::{ObserverKind, PlantClass, Specification, Study};
use crate::synthesis::linear::measurement;
use crate::synthesis::noise_gain::NoiseGain;
use crate::synthesis::{
    Designed, Plan, Sampling, asymptotic_factor, asymptotic_rate, certified, matrix, number, poles, proof_matrix,
    proved_of, upper_bound,
};
use crate::tuning::{Context, Keys, Value, linear as is_linear, noisy, process_noise, short};

crate::keys! { |size|
    /// The keys of an H-infinity or H2 filter.
    pub(super) struct NormFilter {
        /// E, n x q: disturbances and noises w enter as x' = A x + B u + E w (x+ in discrete time).
        e: DMatrix<f64>[n, _] as Rows,
        /// D, p x q: the same w enters the outputs, y = C x + D w.
        d: DMatrix<f64> as Rows => |key, given, reader| in_outputs(key, e.as_ref(), given, reader),
        /// H, r x n: the errors z = H e that count (default: those of all states).
        h: DMatrix<f64>[_, n] as Rows = DMatrix::identity(size.states, size.states),
        /// The least norm, a bound, or a given gain.
        goal: NormTarget as [Goal::KEYS] => goal,
        ..[&[MAX_GAIN]]
    }
}

crate::keys! {
    struct Goal {
        /// Bound of the norm from w to z (default: the least; for h-infinity 1 % above it).
        gamma: Option<f64> as Number(Positive),
        /// In place of a design: the norm of a given gain L, n x p.
        gain: Option<DMatrix<f64>>[n, p] as Rows,
    }
}

/// D, with the columns of E.
fn in_outputs(key: &Key, e: Option<&DMatrix<f64>>, given: &Given<'_>, reader: &mut Reader) -> Option<DMatrix<f64>> {
    let (p, q) = (given.size().outputs, e.map(DMatrix::ncols));
    let columns = q.map_or_else(String::new, |q| format!(" and `e` {}", counted(q, "column")));
    let why = format!("the plant has {}{columns}", counted(p, "output"));
    reader.matrix(given.node.get(key.name)?, key.name, (Some(p), q), &why)
}

fn goal(given: &Given<'_>, reader: &mut Reader) -> Option<NormTarget> {
    one_of(Goal::KEYS, given, false, reader)?;
    let Goal { gamma, gain } = Goal::read(given, reader)?;
    Some(gamma.map(NormTarget::Below).or(gain.map(NormTarget::OfGain)).unwrap_or(NormTarget::Least))
}

pub(super) fn read(given: &Given<'_>, norm: SystemNorm, reader: &mut Reader) -> Option<ObserverKind> {
    let NormFilter { e, d, h, goal } = NormFilter::read(given, reader)?;
    Some(NormFilterSpec { norm, performance: GeneralizedPlant { e, d, h }, goal }.into())
}

/// An H-infinity or H2 filter.
#[derive(Debug, Clone, PartialEq)]
pub struct NormFilterSpec {
    /// The norm.
    pub norm: luenberger_design::SystemNorm,
    /// What acts on the plant, and the errors that count.
    pub performance: luenberger_design::GeneralizedPlant,
    /// The least norm, a bound, or a given gain.
    pub goal: luenberger_design::NormTarget,
}

impl Specification for NormFilterSpec {
    fn name(&self) -> &'static str {
        match self.norm {
            SystemNorm::HInfinity => h_infinity::DECLARATION.name,
            SystemNorm::H2 => h2::DECLARATION.name,
        }
    }

    fn plant(&self) -> PlantClass {
        h2::DECLARATION.plant
    }

    fn free_keys(&self) -> &'static [&'static str] {
        &["gamma", "gain"]
    }

    fn poses_inequality(&self) -> bool {
        true
    }

    fn remark_of_export(&self, study: &Study, _is_certified: bool) -> Option<String> {
        let is_designed = study.plant.dt.is_none() && !matches!(self.goal, NormTarget::OfGain(_));
        is_designed.then(|| {
            format!(
                "The gain is that of the {} filter of the sampled plant, disturbances and noise held over the period. The bound of the norm is not in the certificate.",
                self.norm.name()
            )
        })
    }
}

impl Kind for NormFilterSpec {
    fn design(&self, plan: &Plan<'_>) -> Result<Designed, NoObserver> {
        let plant = plan.linear()?;
        let designed = designed(plan.study, plant, self, None, &plan.options())?;
        plan.at_point(plan.in_loop(plant, designed))
    }

    fn design_in_discrete_time(&self, plan: &Plan<'_>, dt: f64) -> Result<Designed, NoObserver> {
        let plant = plan.linear()?;
        let designed = designed(plan.study, plant, self, Some(dt), &plan.options())?;
        Ok(plan.in_loop(plant, designed))
    }

    fn advice(&self, _plan: &Plan<'_>, cause: &Cause) -> Option<Advice> {
        match cause {
            Cause::Design(DesignError::NormTooSmall { best, .. }) => Some(of_larger_gamma(*best, false)),
            Cause::Design(DesignError::NormNotFound { best, is_limited, .. }) => {
                Some(of_larger_gamma(*best, *is_limited))
            }
            Cause::Design(DesignError::NoDisturbance { .. }) => {
                Some(Advice::hint("`e` with a column for what disturbs the states; or `gamma`, which L = 0 keeps"))
            }
            Cause::Design(DesignError::NoiselessOutput { .. }) => {
                Some(Advice::hint("`gamma` or `max_gain`, which bound the gain; or a row of `d` for each output"))
            }
            _ => None,
        }
    }

    fn sampled(&self, of: &Sampling<'_>) -> Result<Option<SampledDesign>, NoObserver> {
        let (study, options) = (of.plan.study, of.plan.options());
        let design = match (of.plant(), study.plant.dt, &study.operating_point) {
            (Some(plant), Some(dt), _) => {
                let runs = of
                    .designed
                    .and_then(|designed| designed.runnable.of::<DiscreteLinearObserver<f64, Dyn, Dyn, Dyn>>());
                match runs {
                    Some(filter) => DiscreteDesign::with_gain(plant, dt, filter.l())?,
                    None => in_discrete_time(plant, self, dt, &options)?,
                }
            }
            (Some(plant), None, _) => held_filter(plant, self, of.period, &options)?,
            (None, None, Some(point)) => {
                let held = held_filter(&point.linear, self, of.period, &options)?;
                return around(&held, point, (of.period, &of.plan.reading())).map(Some);
            }
            (None, ..) => return Err(NoObserver::new(format!("the kind {} needs a linear plant", self.name()))),
        };
        Ok(Some(SampledDesign::Linear(Box::new(design))))
    }
}

/// A bound of a norm that a gain is known to keep, with a hundredth to spare.
fn of_larger_gamma(best: Option<f64>, is_limited: bool) -> Advice {
    let gamma = best.map(|best| {
        let gamma = format!("gamma = {}", at_most(1.01 * best, 4));
        Proposal::keys([gamma], &["gamma"], "a norm that was found")
    });
    let hint = if is_limited { Advice::hint("a larger `max_gain`") } else { Advice::default() };
    Advice::of(gamma).and(hint)
}

/// The filter of a plant in continuous time, or in discrete time with this period.
fn designed(
    study: &Study,
    plant: &StateSpace,
    spec: &NormFilterSpec,
    dt: Option<f64>,
    options: &GainOptions,
) -> Result<Designed, NoObserver> {
    let time = if dt.is_some() { TimeDomain::Discrete } else { TimeDomain::Continuous };
    let design = NormFilterDesign::new(plant, time, spec.norm, &spec.performance, &spec.goal, options)?;
    let name = spec.norm.name();
    let largest = |f: fn(f64, f64) -> f64| {
        let each = design.poles.iter().map(|pole| f(pole.re, pole.im));
        each.fold(f64::NEG_INFINITY, f64::max)
    };
    let (runnable, decay, speed) = match dt {
        None => {
            let rate = -largest(|re, _| re);
            (Runnable::from(design.observer()?), asymptotic_rate(rate), number(Quantity::DecayRate, rate))
        }
        Some(dt) => {
            let radius = largest(f64::hypot);
            let runnable = design.discrete_observer(dt)?.into();
            (runnable, asymptotic_factor(radius), number(Quantity::LargestPole, radius))
        }
    };
    let mut numbers = vec![speed, upper_bound("gamma", design.gamma), number(&format!("{name} norm"), design.norm)];
    numbers.extend(design.least.map(|least| number(&format!("least {name} norm"), least)));
    numbers.extend(design.found.map(|found| number(&format!("least {name} norm found"), found)));
    numbers.extend(design.frequency.map(|frequency| number("frequency of the peak", frequency)));
    let mut noise = NoiseGain::default();
    if dt.is_none() {
        noise = NoiseGain::of(study, [(&plant.a, &plant.c)], &design.l, Some(&design.poles));
        numbers.extend(noise.numbers());
    }
    let report = DesignReport {
        statement: proved_of(&design.certificate, &study.plant.reading()).remark(measurement(plant)).remark(decay),
        matrices: vec![matrix("L", &design.l), proof_matrix("P", &design.p)],
        poles: poles(&design.poles),
        numbers,
        noise_deviation: noise.deviation,
        ..certified(&design.certificate, &[])
    };
    Ok(Designed::new(runnable, report, Some(design.certificate.clone())))
}

/// The filter of the sampled plant, its input and w held over the period h. For H2, w has the covariance `I/h`, which
/// approaches white noise of unit intensity. A given gain keeps its poles, `exp(h s)`.
fn held_filter(
    plant: &StateSpace,
    spec: &NormFilterSpec,
    h: f64,
    options: &GainOptions,
) -> Result<DiscreteDesign, DesignError> {
    if let NormTarget::OfGain(l) = &spec.goal {
        return DiscreteDesign::sampled(&LinearDesign::with_gain(plant, l)?, h);
    }
    let of = &spec.performance;
    let input = zero_order_hold(&plant.a, &plant.b, h)?;
    let acting = zero_order_hold(&plant.a, &of.e, h)?;
    let mut held = StateSpace::new(input.ad, input.bd, plant.c.clone())?;
    if let Some(d) = &plant.d {
        held = held.with_feedthrough(d.clone())?;
    }
    let size = match spec.norm {
        SystemNorm::HInfinity => 1.0,
        SystemNorm::H2 => 1.0 / h.sqrt(),
    };
    let of = GeneralizedPlant { e: acting.bd * size, d: &of.d * size, h: of.h.clone() };
    let design = NormFilterDesign::new(&held, TimeDomain::Discrete, spec.norm, &of, &spec.goal, options)?;
    DiscreteDesign::with_gain(&held, h, &design.l)
}

/// The filter of a plant in discrete time, as the exported observer.
fn in_discrete_time(
    plant: &StateSpace,
    spec: &NormFilterSpec,
    dt: f64,
    options: &GainOptions,
) -> Result<DiscreteDesign, DesignError> {
    let design = NormFilterDesign::new(plant, TimeDomain::Discrete, spec.norm, &spec.performance, &spec.goal, options)?;
    DiscreteDesign::with_gain(plant, dt, &design.l)
}

/// Process noise and measurement noise as one w of unit intensity, and errors in units of the scale.
pub(super) fn tuned(context: &Context<'_>) -> Result<Vec<Keys>, String> {
    is_linear(context)?;
    noisy(context)?;
    let information = context.information;
    let eigen = process_noise(context)?.symmetric_eigen();
    let root = DMatrix::from_diagonal(&eigen.eigenvalues.map(|value| value.max(0.0).sqrt()));
    let entering = &eigen.eigenvectors * root * eigen.eigenvectors.transpose();
    let (n, p) = (entering.nrows(), information.noise.len());
    let of_sample = context.study.plant.dt.is_some();
    let deviation = |j: usize| if of_sample { information.noise[j] } else { information.intensity[j].sqrt() };
    let e = DMatrix::from_fn(n, n + p, |i, j| if j < n { short(entering[(i, j)]) } else { 0.0 });
    let d = DMatrix::from_fn(p, n + p, |i, j| if j == n + i { deviation(i) } else { 0.0 });
    let h = DMatrix::from_fn(n, n, |i, j| if i == j { short(1.0 / information.scale[i]) } else { 0.0 });
    Ok(vec![vec![("e", Value::rows(&e)), ("d", Value::rows(&d)), ("h", Value::rows(&h))]])
}
