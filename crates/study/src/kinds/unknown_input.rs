//! The unknown-input observer, whose error does not depend on a disturbance of any form.

use luenberger_design::{
    DecoupledPlant, DesignError, DiscreteDesign, GainOptions, Pair, TimeDomain, UnknownInputDesign,
};
use luenberger_export::extension::RecordedObserver;
use luenberger_expression::{Recorded, Recording};
use luenberger_live as live;
use luenberger_observers::{
    CubicObserver, DiscreteForm, LinearObserver, Observer, SampledObserver, UnknownInputObserver,
};
use luenberger_plants::StateSpace;
use luenberger_proof::certificate::Reading;
use luenberger_proof::wording::counted;
use nalgebra::{DMatrix, DVector, Dyn};

use super::declaration::{Declaration, Information, Rule, Tuning};
use super::disturbance::{CubicTerm, cubic, cubic_of, matrices};
use super::keys::{GAINS, OF_GAIN, UNKNOWN};
use super::{Kind, as_kind};
use crate::designed::{NonlinearStep, Runnable, Running, StepOf, rows};
use crate::keys::{Key, Type, optional};
use crate::reader::{Given, Reader, gain};
use crate::results::eigenvalue;
use crate::results::{Advice, Cause, DesignReport, NamedMatrix, NoObserver, Proposal, Quantity};
use crate::steps::recorded::{cast, recorded, step_at_samples};
use crate::study::{GainSpec, LinearSpec, ObserverKind, PlantClass, Specification, Study, Time};
use crate::synthesis::alternative::{self, another_gain};
use crate::synthesis::discrete::gain_of;
use crate::synthesis::linear::{linear_design, measurement};
use crate::synthesis::{
    Designed, Plan, asymptotic_factor, asymptotic_rate, certified, matrix, number, poles, proof_matrix, proved_of,
};
use crate::tuning::{Context, Keys, Value, disturbance as of_study, linear as is_linear, rates};

/// An observer whose error does not depend on a disturbance.
pub type WithoutDisturbance<O> = UnknownInputObserver<O, f64, Dyn, Dyn, Dyn>;

const OF_OUTPUTS: Key = optional(
    "f",
    Type::Rows,
    "F, p x q: the disturbance enters the outputs as y = C x + D u + F d; its columns that are not 0 are independent (default: 0).",
);

/// The kind.
pub(super) static DECLARATION: Declaration = Declaration {
    name: "unknown-input",
    about: "Observer whose error does not depend on a disturbance d of any form, x' = A x + B u + E d, which may enter the outputs, y = C x + D u + F d, for linear plants with rank [C E, F; F, 0] = q + rank(F) and stable invariant zeros of (A, E, C, F).",
    source: "open problem of Share Pasand, Luenberger-type cubic observers; Hautus 1983; Darouach, Zasadzinski and Xu 1994",
    plant: PlantClass::Linear(Time::ANY),
    keys: &[UnknownInput::KEYS],
    kind: as_kind::<UnknownInput>,
    read: |given, reader| Some(UnknownInput::read(given, reader)?.into()),
    takes_long: false,
    tuning: Tuning::Rules(&[Rule {
        name: "unknown-input",
        turn: 12,
        tuning: "the decay rate, or half of it as often as needed, by a matrix inequality",
        source: "Darouach, Zasadzinski and Xu 1994",
        character: "the disturbance does not reach its error, and the noise of the outputs does unfiltered",
        information: &[Information::Settling, Information::Disturbance],
        keys: tuned,
    }]),
};

crate::keys! {
    /// An observer whose error does not depend on a disturbance, linear or cubic.
    #[derive(Debug, Clone, PartialEq)]
    pub struct UnknownInput {
        /// E, n x q.
        e: DMatrix<f64>[n, _] as &UNKNOWN,
        /// F, p x q.
        f: DMatrix<f64> as &OF_OUTPUTS => |key, given, reader| in_outputs(key, e.as_ref()?.ncols(), given, reader),
        /// Its linear part, for the plant without the disturbance.
        linear: LinearSpec as [GAINS, OF_GAIN] => gain::linear,
        /// theta, p x p, and gamma of a cubic term.
        cubic: Option<(DMatrix<f64>, f64)> as [CubicTerm::KEYS] => cubic,
    }
}

/// F, with a column for each disturbance.
fn in_outputs(key: &Key, q: usize, given: &Given<'_>, reader: &mut Reader) -> Option<DMatrix<f64>> {
    let p = given.size().outputs;
    let Some(node) = given.node.get(key.name) else { return Some(DMatrix::zeros(p, q)) };
    let why = format!("the plant has {}, and `e` has {}", counted(p, "output"), counted(q, "column"));
    reader.matrix(node, key.name, (Some(p), Some(q)), &why)
}

impl Specification for UnknownInput {
    declared!();

    fn gain(&self) -> Option<&LinearSpec> {
        Some(&self.linear)
    }

    fn unknown_disturbance(&self) -> Option<&DMatrix<f64>> {
        Some(&self.e)
    }

    fn faster(&self, factor: f64, dt: Option<f64>) -> Option<ObserverKind> {
        Some(Self { linear: self.linear.faster(factor, dt), ..self.clone() }.into())
    }

    fn updates(&self, dt: Option<f64>) -> bool {
        dt.is_some()
    }

    fn with_gamma(&self, gamma: f64) -> Option<ObserverKind> {
        let (theta, _) = self.cubic.as_ref()?;
        Some(Self { cubic: Some((theta.clone(), gamma)), ..self.clone() }.into())
    }
}

impl Kind for UnknownInput {
    fn design(&self, plan: &Plan<'_>) -> Result<Designed, NoObserver> {
        let plant = plan.linear()?;
        designed((plant, &plan.reading()), self, &plan.options())
    }

    fn design_in_discrete_time(&self, plan: &Plan<'_>, dt: f64) -> Result<Designed, NoObserver> {
        let plant = plan.linear()?;
        let decoupled = DecoupledPlant::of_outputs(plant, &self.e, &self.f, TimeDomain::Discrete)?;
        if self.cubic.is_some() {
            return Err(DesignError::CubicOfOutputs.into());
        }
        let design = match &self.linear.gain {
            GainSpec::Poles(poles) if self.linear.weight.is_none() => {
                decoupled.with_poles_in_discrete_time(dt, poles)?
            }
            _ => gain_of(plan, &decoupled.reduced, (&self.linear, dt)).map_err(|none| match none.cause.as_deref() {
                Some(Cause::Design(error)) => error.clone().of_pair(Pair::Decoupled).into(),
                _ => none,
            })?,
        };
        in_discrete_time(&decoupled, &design, (&plan.reading(), dt))
    }

    fn advice(&self, plan: &Plan<'_>, cause: &Cause) -> Option<Advice> {
        let another = || another_gain(plan.requested);
        match cause {
            Cause::Design(DesignError::FixedPoles { .. }) => {
                Some(another().and(Advice::hint("`poles` with these zeros among them")))
            }
            Cause::Design(
                DesignError::UnmatchedDisturbance { .. } | DesignError::UnstableZero { is_fed: false, .. },
            ) => Some(self.with_slow_disturbance()),
            Cause::Design(DesignError::UnmatchedInOutputs { .. } | DesignError::UnstableZero { is_fed: true, .. }) => {
                Some(Advice::hint("a further output, without the disturbance, whose derivative depends on it"))
            }
            Cause::Design(DesignError::CubicOfOutputs) => {
                Some(Advice::of([Proposal::keys([], &["gamma", "theta"], "the linear observer")]))
            }
            Cause::Design(DesignError::OfPair { pair: Pair::Decoupled, .. }) => {
                Some(self.with_slow_disturbance().and(another()))
            }
            _ => None,
        }
    }
}

impl UnknownInput {
    /// The disturbance as a state, or seen by another output.
    fn with_slow_disturbance(&self) -> Advice {
        let keys = [format!("e = {}", alternative::rows(&self.e)), "lmi = true".to_owned()];
        let why = "for a disturbance that is constant or varies slowly";
        Advice::of([Proposal::kind("proportional-integral", keys, why)])
            .and(Advice::hint("a further output, whose derivative depends on the disturbance"))
    }
}

fn designed(
    (plant, reading): (&StateSpace, &Reading<'_>),
    UnknownInput { e, f, linear: gain, cubic }: &UnknownInput,
    options: &GainOptions,
) -> Result<Designed, NoObserver> {
    let decoupled = DecoupledPlant::of_outputs(plant, e, f, TimeDomain::Continuous)?;
    let linear = match &gain.gain {
        GainSpec::Poles(poles) => decoupled.with_poles_and_weight(poles, gain.weight.clone().unwrap_or_default())?,
        _ => linear_design(&decoupled.reduced, gain, options).map_err(|error| error.of_pair(Pair::Decoupled))?,
    };
    let cubic = cubic_of(&linear, cubic.as_ref())?;
    let mut all = matrices(&linear, cubic.as_ref());
    let (runnable, certificate) = match &cubic {
        None => {
            let design = UnknownInputDesign::linear(&decoupled, &linear)?;
            all[0] = matrix("L", &design.gain);
            all.extend(of_the_observer(&design.observer, decoupled.f.amax() > 0.0));
            (Runnable::from(design.observer.clone()), design.certificate.clone())
        }
        Some(cubic) => {
            let design = UnknownInputDesign::cubic(&decoupled, cubic)?;
            let reduced = &decoupled.reduced;
            all.extend([matrix("H", &decoupled.h), matrix("TA", &reduced.a), matrix("TB", &reduced.b)]);
            (design.observer.clone().into(), design.certificate.clone())
        }
    };
    let speed = -linear.spectral_abscissa();
    let report = DesignReport {
        statement: proved_of(&certificate, reading)
            .remark(fixed(&decoupled))
            .remark(measurement(plant))
            .remark(asymptotic_rate(speed)),
        matrices: all.into_iter().filter(|m| m.rows.iter().any(|row| !row.is_empty())).collect(),
        poles: poles(&linear.poles),
        numbers: vec![number(Quantity::DecayRate, speed)],
        ..certified(&certificate, &[])
    };
    Ok(Designed::new(runnable, report, Some(certificate)))
}

/// The poles that no gain moves, in words.
fn fixed(decoupled: &DecoupledPlant) -> String {
    let zeros: Vec<String> = decoupled.zeros.iter().map(|zero| eigenvalue([zero.re, zero.im])).collect();
    let of = if decoupled.f.amax() > 0.0 { "(A, E, C, F)" } else { "(A, E, C)" };
    match zeros.as_slice() {
        [] => String::new(),
        zeros => format!("The invariant zeros of {of} are among the poles, whatever L is: {}.", zeros.join(", ")),
    }
}

/// H, TA and TB, and J where it is not L.
fn of_the_observer(
    observer: &WithoutDisturbance<LinearObserver<f64, Dyn, Dyn, Dyn>>,
    is_fed: bool,
) -> impl Iterator<Item = NamedMatrix> {
    let inner = observer.inner();
    let j = is_fed.then(|| matrix("J", &inner.l));
    let all = [matrix("H", observer.h()), matrix("TA", &inner.a), matrix("TB", &inner.b)];
    j.into_iter().chain(all)
}

/// The observer of a plant in discrete time.
fn in_discrete_time(
    decoupled: &DecoupledPlant,
    linear: &DiscreteDesign,
    (reading, dt): (&Reading<'_>, f64),
) -> Result<Designed, NoObserver> {
    let design = UnknownInputDesign::discrete(decoupled, linear)?;
    let (plant, radius) = (&decoupled.plant, linear.spectral_radius());
    let mut all = vec![matrix("L", &design.gain), proof_matrix("P", &linear.p)];
    all.extend(of_the_observer(&design.observer, decoupled.f.amax() > 0.0));
    let report = DesignReport {
        statement: proved_of(&design.certificate, reading)
            .remark("The estimate at a sample has the measurement of that sample, xhat(k) = z(k) + H y(k).")
            .remark(fixed(decoupled))
            .remark(measurement(plant))
            .remark(asymptotic_factor(radius)),
        matrices: all.into_iter().filter(|m| m.rows.iter().any(|row| !row.is_empty())).collect(),
        poles: poles(&linear.poles),
        numbers: vec![number(Quantity::Period, dt), number(Quantity::LargestPole, radius)],
        ..certified(&design.certificate, &[])
    };
    let observer = DiscreteForm::predicting(design.observer.clone(), plant.clone(), dt)?;
    let runnable: AtSamples = observer;
    Ok(Designed::new(runnable.into(), report, Some(design.certificate.clone())))
}

/// The observer of a plant in discrete time.
type AtSamples = DiscreteForm<WithoutDisturbance<LinearObserver<f64, Dyn, Dyn, Dyn>>, f64, Dyn, Dyn, Dyn, Dyn, Dyn>;

impl Running for AtSamples {
    runs!(sampled);

    fn step(&self, of: &StepOf<'_>) -> Result<Option<NonlinearStep>, NoObserver> {
        let (observer, states) = (self.observer(), &of.study.plant.states);
        let names = states.iter().cloned().chain(states.iter().map(|state| format!("z_{state}"))).collect();
        // The start is at u = 0, with the output that the first estimate predicts.
        let xhat = DVector::from_column_slice(&of.observer.initial);
        let size = observer.dimensions();
        let (u, y) = (DVector::zeros(size.inputs), DVector::zeros(size.outputs));
        let state = self.initial(0.0, &xhat, &u, &y);
        let start = xhat.iter().chain(state.iter().take(size.state)).copied().collect();
        let c = &observer.inner().c;
        let make = || observer.cast();
        let predicted = |xhat: &[Recorded]| (cast(c) * DVector::from_column_slice(xhat)).as_slice().to_vec();
        step_at_samples(of, make, (names, start), predicted).map(Some)
    }
}

/// What the step has in addition to the observer in continuous time.
const REMARK: &str = "Between two samples the disturbance is not seen: it adds an error of the order of the period times the disturbance.";

impl Running for WithoutDisturbance<LinearObserver<f64, Dyn, Dyn, Dyn>> {
    runs!(continuous);

    fn live(&self, _study: &Study) -> Option<(live::ObserverKind, Option<live::OperatingPoint>)> {
        let (h, d) = (rows(self.h()), self.d().map(rows));
        Some((live::ObserverKind::UnknownInput { observer: Box::new(self.inner().clone()), h, d }, None))
    }

    fn record(&self, _of: &StepOf<'_>, recording: &mut Recording) -> Result<RecordedObserver, NoObserver> {
        recorded(recording, &self.cast()?)
    }

    fn remark_of_step(&self) -> &'static str {
        REMARK
    }
}

impl Running for WithoutDisturbance<CubicObserver<f64, Dyn, Dyn, Dyn>> {
    runs!(continuous);

    fn live(&self, _study: &Study) -> Option<(live::ObserverKind, Option<live::OperatingPoint>)> {
        let (h, d) = (rows(self.h()), self.d().map(rows));
        Some((live::ObserverKind::UnknownInputCubic { observer: Box::new(self.inner().clone()), h, d }, None))
    }

    fn record(&self, _of: &StepOf<'_>, recording: &mut Recording) -> Result<RecordedObserver, NoObserver> {
        recorded(recording, &self.cast()?)
    }

    fn remark_of_step(&self) -> &'static str {
        REMARK
    }
}

fn tuned(context: &Context<'_>) -> Result<Vec<Keys>, String> {
    let e = of_study(context)?;
    is_linear(context)?;
    if let Some(dt) = context.study.plant.dt {
        return Err(format!("its matrix inequality is for plants in continuous time, and this one has dt = {dt}"));
    }
    let keys = |rate: f64| vec![("e", Value::rows(e)), ("decay_rate", Value::Number(rate))];
    Ok(rates(context.information.linear_rate).filter(|rate| *rate > 0.0).map(keys).collect())
}
