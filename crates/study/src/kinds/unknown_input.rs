//! The unknown-input observer, whose error does not depend on a disturbance of any form.

use luenberger_design::{DecoupledPlant, DesignError, GainOptions, Pair, UnknownInputDesign};
use luenberger_export::extension::RecordedObserver;
use luenberger_expression::{Recorded, Recording};
use luenberger_live as live;
use luenberger_observers::{CubicObserver, LinearObserver, Observer, ObserverError, UnknownInputObserver};
use luenberger_plants::StateSpace;
use luenberger_proof::certificate::Reading;
use nalgebra::{DMatrix, Dyn};

use super::declaration::{Declaration, Information, Rule, Tuning};
use super::disturbance::{cubic, cubic_of, matrices, unknown};
use super::keys::{GAINS, GAMMA, OF_GAIN, THETA, UNKNOWN};
use super::{Kind, as_kind};
use crate::designed::{Runnable, Running, StepOf, rows};
use crate::reader::{Given, Reader, gain};
use crate::results::eigenvalue;
use crate::results::{Advice, Cause, DesignReport, NoObserver, Proposal, Quantity};
use crate::steps::recorded::{cast, recorded};
use crate::study::{GainSpec, LinearSpec, ObserverKind, PlantClass, Specification, Study, Time};
use crate::synthesis::alternative::{self, another_gain};
use crate::synthesis::linear::{linear_design, measurement};
use crate::synthesis::{Designed, Plan, asymptotic_rate, certified, matrix, number, poles, proved_of};
use crate::tuning::{Context, Keys, Value, disturbance as of_study, linear as is_linear, rates};

/// An observer whose error does not depend on a disturbance.
pub type WithoutDisturbance<O> = UnknownInputObserver<O, f64, Dyn, Dyn, Dyn>;

/// The kind.
pub(super) static DECLARATION: Declaration = Declaration {
    name: "unknown-input",
    about: "Observer whose error does not depend on a disturbance d of any form, x' = A x + B u + E d, for linear plants with rank(C E) = q and stable invariant zeros of (A, E, C).",
    source: "open problem of Share Pasand, Luenberger-type cubic observers; Darouach, Zasadzinski and Xu 1994",
    plant: PlantClass::Linear(Time::CONTINUOUS),
    keys: &[&[UNKNOWN], GAINS, OF_GAIN, &[THETA, GAMMA]],
    kind: as_kind::<UnknownInput>,
    read,
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

fn read(given: &Given<'_>, reader: &mut Reader) -> Option<ObserverKind> {
    let (node, size) = (given.node, given.size());
    let e = unknown(node, size, reader);
    let linear = gain::linear(node, size, reader);
    let cubic = cubic(node, size, reader);
    Some(UnknownInput { e: e?, linear: linear?, cubic: cubic.ok()? }.into())
}

/// An observer whose error does not depend on a disturbance, linear or cubic.
#[derive(Debug, Clone, PartialEq)]
pub struct UnknownInput {
    /// E, n x q.
    pub e: DMatrix<f64>,
    /// Its linear part, for the plant without the disturbance.
    pub linear: LinearSpec,
    /// theta, p x p, and gamma of a cubic term.
    pub cubic: Option<(DMatrix<f64>, f64)>,
}

impl Specification for UnknownInput {
    declared!();

    fn gain(&self) -> Option<&LinearSpec> {
        Some(&self.linear)
    }

    fn unknown_disturbance(&self) -> Option<&DMatrix<f64>> {
        Some(&self.e)
    }

    fn faster(&self, factor: f64) -> Option<ObserverKind> {
        Some(Self { linear: self.linear.faster(factor), ..self.clone() }.into())
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

    fn advice(&self, plan: &Plan<'_>, cause: &Cause) -> Option<Advice> {
        let another = || another_gain(plan.requested);
        match cause {
            Cause::Design(DesignError::FixedPoles { .. }) => {
                Some(another().and(Advice::hint("`poles` with these zeros among them")))
            }
            Cause::Design(DesignError::UnmatchedDisturbance { .. } | DesignError::UnstableZero { .. }) => {
                Some(self.with_slow_disturbance())
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
    UnknownInput { e, linear: gain, cubic }: &UnknownInput,
    options: &GainOptions,
) -> Result<Designed, NoObserver> {
    let decoupled = DecoupledPlant::new(plant, e)?;
    let zeros: Vec<String> = decoupled.zeros.iter().map(|zero| eigenvalue([zero.re, zero.im])).collect();
    let linear = match &gain.gain {
        GainSpec::Poles(poles) => decoupled.with_poles_and_weight(poles, gain.weight.clone().unwrap_or_default())?,
        _ => linear_design(&decoupled.reduced, gain, options).map_err(|error| error.of_pair(Pair::Decoupled))?,
    };
    let cubic = cubic_of(&linear, cubic.as_ref())?;
    let (runnable, certificate) = match &cubic {
        None => {
            let design = UnknownInputDesign::linear(&decoupled, &linear)?;
            (Runnable::from(design.observer.clone()), design.certificate.clone())
        }
        Some(cubic) => {
            let design = UnknownInputDesign::cubic(&decoupled, cubic)?;
            (design.observer.clone().into(), design.certificate.clone())
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
        numbers: vec![number(Quantity::DecayRate, speed)],
        ..certified(&certificate, &[])
    };
    Ok(Designed::new(runnable, report, Some(certificate)))
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
        let LinearObserver { a, b, c, d, l } = self.inner();
        let inner = LinearObserver { a: cast(a), b: cast(b), c: cast(c), d: d.as_ref().map(cast), l: cast(l) };
        recorded(recording, &without_disturbance(self, inner)?)
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
        let CubicObserver { a, b, c, d, l, n, theta } = self.inner();
        let (a, b, c, d) = (cast(a), cast(b), cast(c), d.as_ref().map(cast));
        let inner = CubicObserver { a, b, c, d, l: cast(l), n: cast(n), theta: cast(theta) };
        recorded(recording, &without_disturbance(self, inner)?)
    }

    fn remark_of_step(&self) -> &'static str {
        REMARK
    }
}

fn without_disturbance<O, I>(
    decoupled: &WithoutDisturbance<O>,
    inner: I,
) -> Result<UnknownInputObserver<I, Recorded, Dyn, Dyn, Dyn>, ObserverError>
where
    I: Observer<Recorded>,
{
    UnknownInputObserver::new(inner, cast(decoupled.h()), decoupled.d().map(cast))
}

fn tuned(context: &Context<'_>) -> Result<Vec<Keys>, String> {
    let e = of_study(context)?;
    is_linear(context)?;
    let keys = |rate: f64| vec![("e", Value::rows(e)), ("decay_rate", Value::Number(rate))];
    Ok(rates(context.information.linear_rate).filter(|rate| *rate > 0.0).map(keys).collect())
}
