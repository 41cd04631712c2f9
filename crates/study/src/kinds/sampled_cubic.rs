//! The sampled cubic observer, stable at every sampling period, and the same at varying periods.

use std::sync::Arc;

use luenberger_design::{CubicGain, DesignError, OperatingPoint, Periods, SampledCubicDesign, VaryingPeriodDesign};
use luenberger_live as live;
use luenberger_observers::{DeviationObserver, SampledCubicObserver, VaryingPeriodObserver};
use luenberger_plants::StateSpace;
use luenberger_proof::certificate::{MOST_MISSES, Reading, Theorem};
use luenberger_proof::wording::{at_least, at_most, significant};
use luenberger_sim::{AnyObserver, Replay, SampleTimes, Scenario};
use nalgebra::{DMatrix, DVector, Dyn};

use super::cubic::at_point_refusal;
use super::declaration::{Declaration, Information, Rule, Tuning};
use super::keys::{GAINS, OF_GAIN, PERIOD, THETA};
use super::settings::one_of;
use super::{Kind, as_kind};
use crate::designed::{At, NonlinearStep, Origin, Runnable, Running, SampledDesign, StepOf, continuous};
use crate::reader::{Given, Reader, gain};
use crate::results::{Advice, Cause, DesignReport, DesignVerdict, NoObserver, Proposal, Quantity, Statement};
use crate::study::{LinearSpec, ObserverKind, PlantClass, SamplingSpec, Specification, Study, Time};
use crate::synthesis::linear::{self, measurement};
use crate::synthesis::operating_point::{in_deviations, page_point};
use crate::synthesis::{
    Designed, Plan, Sampling, certified, discrete, facts, matrix, number, poles, proof_matrix, proved_of, upper_bound,
};
use crate::tuning::{CUBIC_SHARE, Context, Keys, Value, listed, placed, short, unit_strength};

/// The kind.
pub(super) static DECLARATION: Declaration = Declaration {
    name: "sampled-cubic",
    about: "Sampled cubic observer, stable at every sampling period, for linear plants.",
    source: "the same paper's observer, eq. (5), with a step in closed form: docs/theory-cubic.md",
    plant: PlantClass::AtPoint(Time::ANY),
    keys: &[SampledCubic::KEYS],
    kind: as_kind::<SampledCubic>,
    read: |given, reader| Some(SampledCubic::read(given, reader)?.into()),
    takes_long: false,
    tuning: Tuning::Rules(&[Rule {
        name: "sampled-cubic",
        turn: 7,
        tuning: "the poles of luenberger, and the strength at which an output error of one standard deviation adds an eighth to L",
        source: "docs/cubic-or-linear.md, rule 1",
        character: "the cubic term acts on large output errors only, such as after a push that nobody expects, and leaves the linear part to small ones",
        information: &[Information::Settling, Information::Noise],
        keys: |context| Ok(vec![tuned(context)?]),
    }]),
};

crate::keys! { |size|
    /// A sampled cubic observer.
    #[derive(Debug, Clone, PartialEq)]
    pub struct SampledCubic {
        /// Its linear part.
        linear: LinearSpec as [GAINS, OF_GAIN] => gain::linear,
        /// theta, p x p.
        theta: DMatrix<f64>[p, p] as &THETA = DMatrix::identity(size.outputs, size.outputs),
        /// The gain of its cubic term: radial ones are in closed form, others take a semi-implicit step.
        correction: CubicGain as [Correction::KEYS] => correction,
        /// The sampling period.
        period: f64 as &PERIOD,
        /// The periods and misses at which convergence is to be proved besides.
        varying: Option<Periods> as [Varying::KEYS] => |given, reader| varying(period?, given, reader),
    }
}

crate::keys! {
    struct Correction {
        /// w of the cubic term, N = -w P^-1 C'(C P^-1 C')^-1, whose flow has a closed form. Give one of gamma, weighted
        /// and s.
        gamma: Option<f64> as Number(Positive),
        /// gamma of N = -gamma P^-1 C' theta; the cubic term takes a semi-implicit step.
        weighted: Option<f64> as Number(Positive),
        /// S of N = -P^-1 C'S, p x p, S + S' >= 0; the cubic term takes a semi-implicit step.
        s: Option<DMatrix<f64>>[p, p] as Rows,
    }
}

/// N, where `gamma` is the strength of a radial gain.
fn correction(given: &Given<'_>, reader: &mut Reader) -> Option<CubicGain> {
    one_of(Correction::KEYS, given, true, reader)?;
    let Correction { gamma, weighted, s } = Correction::read(given, reader)?;
    gamma.map(CubicGain::Radial).or(weighted.map(CubicGain::Gamma)).or(s.map(CubicGain::General))
}

crate::keys! {
    struct Varying {
        /// Bounds [shortest, longest] of the real period: convergence is proved for all between, and a simulation draws
        /// the periods between them (default: the period only).
        jitter: Option<(f64, f64)> as Bound,
        /// Number of samples that may be missed in a row, for which convergence is proved; a simulation misses as many
        /// (default 0).
        misses: usize as Count(0) = 0,
    }
}

#[expect(clippy::option_option, reason = "wrong, absent, or given")]
fn varying(period: f64, given: &Given<'_>, reader: &mut Reader) -> Option<Option<Periods>> {
    let Varying { jitter, misses } = Varying::read(given, reader)?;
    if misses > MOST_MISSES {
        let span = given.node.get("misses")?.span.clone();
        return reader.refuse(span, format!("`misses` is {misses}"), format!("expected at most {MOST_MISSES}"));
    }
    let (shortest, longest) = jitter.unwrap_or((period, period));
    if !(shortest > 0.0 && shortest <= period && period <= longest && longest.is_finite()) {
        let message = format!("`jitter` is from {shortest} to {longest}, and `period` is {period}");
        let span = given.node.get("jitter")?.span.clone();
        return reader.refuse(span, message, "expected positive, finite bounds that contain the period");
    }
    Some(Some(Periods { shortest, longest, misses }).filter(|periods| !periods.is_constant()))
}

impl Specification for SampledCubic {
    declared!();

    fn gain(&self) -> Option<&LinearSpec> {
        Some(&self.linear)
    }

    fn poses_inequality(&self) -> bool {
        self.varying.is_some() || self.linear.poses_inequality()
    }

    fn period(&self) -> Option<f64> {
        Some(self.period)
    }

    fn varying_periods(&self) -> Option<&Periods> {
        self.varying.as_ref()
    }

    fn faster(&self, factor: f64, dt: Option<f64>) -> Option<ObserverKind> {
        Some(Self { linear: self.linear.faster(factor, dt), ..self.clone() }.into())
    }

    fn with_gamma(&self, gamma: f64) -> Option<ObserverKind> {
        let correction = with_strength(&self.correction, gamma)?;
        Some(Self { correction, ..self.clone() }.into())
    }
}

impl Kind for SampledCubic {
    fn design(&self, plan: &Plan<'_>) -> Result<Designed, NoObserver> {
        let (plant, reading) = (plan.linear()?, plan.reading());
        let Self { linear, theta, correction, period, varying } = self;
        let linear = linear::linear_design(plant, linear, &plan.options())?;
        plan.at_point(if let Some(periods) = varying {
            let design = VaryingPeriodDesign::new(&linear, theta, correction, *period, periods)?;
            of_varying(&design, (plant, &reading), *period)?
        } else {
            let design = SampledCubicDesign::with_cubic_gain(&linear, theta, correction, *period)?;
            report(&design, (plant, &reading), *period)
        })
    }

    fn design_in_discrete_time(&self, plan: &Plan<'_>, dt: f64) -> Result<Designed, NoObserver> {
        if self.varying.is_some() {
            let constant = Proposal::keys([], &["jitter", "misses"], "at constant periods");
            return Err(NoObserver::new("`jitter` and `misses` are for plants in continuous time")
                .advise(Advice::of([constant]))
                .hint("the plant in continuous time, whose motion over every period is known"));
        }
        plan.has_period_of_plant(self.period, dt)?;
        let gain = discrete::gain_of(plan, plan.linear()?, (&self.linear, dt))?;
        let design = SampledCubicDesign::of_discrete_with_cubic_gain(&gain, &self.theta, &self.correction)?;
        Ok(report(&design, (gain.observer.plant(), &plan.reading()), dt))
    }

    fn advice(&self, _plan: &Plan<'_>, cause: &Cause) -> Option<Advice> {
        let Cause::Design(DesignError::VaryingPeriods { largest, .. }) = cause else { return None };
        Some(match largest {
            Some(periods) => {
                let keys = [
                    format!("jitter = [{}, {}]", at_most(periods.shortest, 4), at_least(periods.longest, 4)),
                    format!("misses = {}", periods.misses),
                ];
                let proved = Proposal::keys(keys, &["jitter", "misses"], "for which convergence is proved");
                Advice::of([proved]).and(Advice::hint("slower `poles`"))
            }
            None => Advice::hint("a shorter `period`; other `poles`"),
        })
    }

    fn sampled(&self, of: &Sampling<'_>) -> Result<Option<SampledDesign>, NoObserver> {
        let Some(plant) = of.plant() else { return Ok(None) };
        if let Some(design) = of.designed.and_then(Designed::sampled) {
            return Ok(Some(design.clone()));
        }
        let Self { linear: gain, theta, correction, varying, .. } = self;
        let design = match (of.plan.study.plant.dt, varying) {
            (Some(dt), _) => {
                let linear = discrete::gain_of_step(&of.plan, plant, gain, dt)?;
                SampledCubicDesign::of_discrete_with_cubic_gain(&linear, theta, correction)?
            }
            (None, Some(periods)) => {
                let linear = of.linear(plant, gain)?;
                let design = VaryingPeriodDesign::new(&linear, theta, correction, of.period, periods)?;
                return Ok(Some(SampledDesign::Varying(Box::new(design))));
            }
            (None, None) => {
                let linear = of.linear(plant, gain)?;
                SampledCubicDesign::with_cubic_gain(&linear, theta, correction, of.period)?
            }
        };
        Ok(Some(SampledDesign::Cubic(Box::new(design))))
    }
}

/// The same gain with another strength; none for one that is given as S.
pub(super) fn with_strength(correction: &CubicGain, gamma: f64) -> Option<CubicGain> {
    match correction {
        CubicGain::Gamma(_) => Some(CubicGain::Gamma(gamma)),
        CubicGain::Radial(_) => Some(CubicGain::Radial(gamma)),
        CubicGain::General(_) => None,
    }
}

impl Running for SampledCubicObserver<f64, Dyn, Dyn, Dyn> {
    runs!(sampled);

    fn at(&self, point: &OperatingPoint) -> Option<Result<Runnable, DesignError>> {
        Some(in_deviations(self.clone(), point).map(Runnable::from))
    }

    // In discrete time the matrices of the plant are not used: its period does not change.
    fn live(&self, study: &Study) -> Option<(live::ObserverKind, Option<live::OperatingPoint>)> {
        Some((of_page(self, study.plant.model.linear()?), None))
    }
}

impl Running for At<SampledCubicObserver<f64, Dyn, Dyn, Dyn>> {
    runs!(sampled);

    fn live(&self, study: &Study) -> Option<(live::ObserverKind, Option<live::OperatingPoint>)> {
        Some((of_page(self.inner(), &study.operating_point.as_ref()?.linear), Some(page_point(self))))
    }

    fn step(&self, _of: &StepOf<'_>) -> Result<Option<NonlinearStep>, NoObserver> {
        Err(at_point_refusal())
    }
}

fn of_page(observer: &SampledCubicObserver<f64, Dyn, Dyn, Dyn>, plant: &StateSpace) -> live::ObserverKind {
    let rows = crate::designed::rows;
    live::ObserverKind::SampledCubic { observer: Box::new(observer.clone()), a: rows(&plant.a), b: rows(&plant.b) }
}

/// An observer at varying periods, ready to run; in deviations from an operating point, which is 0 for a linear plant.
#[derive(Debug, Clone)]
pub struct VaryingPeriods {
    /// The observer, which a simulation corrects at the samples that it draws, and a log at its rows.
    pub observer: Box<At<VaryingPeriodObserver<f64, Dyn, Dyn, Dyn>>>,
    /// The periods for which convergence is proved.
    pub periods: Periods,
}

impl VaryingPeriods {
    pub(crate) fn new(
        observer: VaryingPeriodObserver<f64, Dyn, Dyn, Dyn>,
        periods: Periods,
        point: [&DVector<f64>; 3],
    ) -> Result<Self, DesignError> {
        let [x, u, y] = point.map(DVector::clone);
        let observer = DeviationObserver::new(observer, x, u, y)?;
        Ok(Self { observer: Box::new(observer), periods })
    }

    /// How the samples of a simulation are drawn.
    pub fn sample_times(&self, sampling: &SamplingSpec) -> SampleTimes {
        let (shortest, longest) = sampling.jitter.unwrap_or((self.periods.shortest, self.periods.longest));
        SampleTimes { shortest, longest, misses: sampling.misses.unwrap_or(self.periods.misses), seed: sampling.seed }
    }
}

impl Running for VaryingPeriods {
    fn any(&self) -> Arc<dyn AnyObserver + '_> {
        continuous(self.observer.as_ref())
    }

    fn join<'a>(
        &'a self,
        scenario: Scenario<'a>,
        name: &str,
        initial: &[f64],
        sampling: &SamplingSpec,
    ) -> Scenario<'a> {
        scenario.continuous_discrete_observer(name, self.observer.as_ref(), self.sample_times(sampling), initial)
    }

    fn replay<'a>(&'a self, replay: Replay<'a>, name: &str, initial: &[f64]) -> Replay<'a> {
        replay.corrected_observer(name, self.observer.as_ref(), initial)
    }

    fn at(&self, point: &OperatingPoint) -> Option<Result<Runnable, DesignError>> {
        let at = Self::new(self.observer.inner().clone(), self.periods, [&point.x, &point.u, &point.y]);
        Some(at.map(Runnable::from))
    }

    fn step(&self, _of: &StepOf<'_>) -> Result<Option<NonlinearStep>, NoObserver> {
        Err(at_point_refusal())
    }
}

/// A sampled cubic observer in numbers and words.
fn report(design: &SampledCubicDesign, (plant, reading): (&StateSpace, &Reading<'_>), period: f64) -> Designed {
    let slowest = design.poles.iter().map(|pole| pole.norm()).fold(0.0, f64::max);
    let report = DesignReport {
        statement: proved_of(&design.certificate, reading)
            .remark(measurement(plant))
            .remark(format!("Computed: asymptotic factor of V {} per sample.", significant(slowest * slowest, 4))),
        matrices: vec![
            matrix("L", design.observer.ld()),
            matrix("N", design.observer.n()),
            matrix("theta", design.observer.theta()),
            proof_matrix("P", &design.p),
            proof_matrix("S", &design.s),
        ],
        poles: poles(&design.poles),
        numbers: vec![number(Quantity::Period, period), number(Quantity::LargestPole, slowest)],
        ..certified(&design.certificate, &[])
    };
    let origin = Origin::Sampled(SampledDesign::Cubic(Box::new(design.clone())));
    Designed { origin, ..Designed::new(design.observer.clone().into(), report, Some(design.certificate.clone())) }
}

/// The observer at varying periods in numbers and words.
fn of_varying(
    design: &VaryingPeriodDesign,
    (plant, reading): (&StateSpace, &Reading<'_>),
    period: f64,
) -> Result<Designed, NoObserver> {
    let Designed { mut report, .. } = self::report(&design.nominal, (plant, reading), period);
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
    let origin = Origin::Sampled(SampledDesign::Varying(Box::new(design.clone())));
    Ok(Designed { origin, ..Designed::new(varying.into(), report, Some(design.certificate.clone())) })
}

fn tuned(context: &Context<'_>) -> Result<Keys, String> {
    let poles = placed(context, 0)?;
    let mut keys = vec![("poles", listed(&poles))];
    let (theta, unit) = unit_strength(context, &poles, true)?;
    keys.push(("theta", Value::numbers(theta)));
    keys.push(("gamma", Value::Number(short(CUBIC_SHARE / unit))));
    keys.push(("period", Value::Number(context.information.period)));
    Ok(keys)
}
