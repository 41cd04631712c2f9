//! The cubic observer: a Luenberger observer with the term `-(y~'theta y~) N y~`.

use luenberger_design::{
    CubicDesign, CubicGain, DesignError, ErrorBound, LinearDesign, OperatingPoint, SampledCubicDesign, UncertainBound,
};
use luenberger_live as live;
use luenberger_observers::CubicObserver;
use luenberger_plants::StateSpace;
use luenberger_proof::certificate::Reading;
use nalgebra::{DMatrix, Dyn};

use super::declaration::{Declaration, Information, Rule, Tuning};
use super::keys::{ERROR_BOUNDS, GAINS, OF_GAIN, THETA};
use super::settings::one_of;
use super::{Kind, as_kind};
use crate::designed::{At, NonlinearStep, Runnable, Running, SampledDesign, StepOf};
use crate::operation::half_ranges;
use crate::reader::{Given, Reader, gain};
use crate::results::{DesignReport, NoObserver};
use crate::study::{ActingBounds, LinearSpec, ObserverKind, PlantClass, Specification, Study, Time};
use crate::synthesis::error_bound::{acting, bounded};
use crate::synthesis::linear::{self, measurement};
use crate::synthesis::noise_gain::NoiseGain;
use crate::synthesis::operating_point::{in_deviations, page_point};
use crate::synthesis::{Designed, Plan, Sampling, certified, feedback, matrix, number, poles, proof_matrix, proved_of};
use crate::tuning::{
    CUBIC_SHARE, Context, Keys, Value, continuous as in_continuous_time, listed, placed, short, unit_strength,
};

/// The kind.
pub(super) static DECLARATION: Declaration = Declaration {
    name: "cubic",
    about: "Luenberger observer with a cubic term -(y~'theta y~) N y~, which preserves stability, for linear plants.",
    source: "Share Pasand, Luenberger-type cubic observers, eq. (5)",
    plant: PlantClass::AtPoint(Time::CONTINUOUS),
    keys: &[Cubic::KEYS],
    kind: as_kind::<Cubic>,
    read: |given, reader| Some(Cubic::read(given, reader)?.into()),
    takes_long: false,
    tuning: Tuning::Rules(&[Rule {
        name: "cubic",
        turn: 6,
        tuning: "the poles of luenberger, and the gamma at which an output error of one standard deviation adds an eighth to L",
        source: "docs/cubic-or-linear.md, rule 1",
        character: "the cubic term acts on large output errors only, such as after a push that nobody expects, and leaves the linear part to small ones",
        information: &[Information::Settling, Information::Noise],
        keys: |context| Ok(vec![tuned(context)?]),
    }]),
};

crate::keys! { |size|
    /// A cubic observer.
    #[derive(Debug, Clone, PartialEq)]
    pub struct Cubic {
        /// Its linear part.
        linear: LinearSpec as [GAINS, OF_GAIN] => gain::linear,
        /// theta, p x p.
        theta: DMatrix<f64>[p, p] as &THETA = DMatrix::identity(size.outputs, size.outputs),
        /// N.
        correction: CubicGain as [Correction::KEYS] => correction,
        ..[&[ERROR_BOUNDS]]
    }
}

crate::keys! {
    struct Correction {
        /// Gain of the cubic term, N = -gamma P^-1 C' theta. Give one of gamma, radial and s.
        gamma: Option<f64> as Number(Positive),
        /// w of N = -w P^-1 C'(C P^-1 C')^-1.
        radial: Option<f64> as Number(Positive),
        /// S of N = -P^-1 C'S, p x p, S + S' >= 0.
        s: Option<DMatrix<f64>>[p, p] as Rows,
    }
}

fn correction(given: &Given<'_>, reader: &mut Reader) -> Option<CubicGain> {
    one_of(Correction::KEYS, given, true, reader)?;
    let Correction { gamma, radial, s } = Correction::read(given, reader)?;
    gamma.map(CubicGain::Gamma).or(radial.map(CubicGain::Radial)).or(s.map(CubicGain::General))
}

impl Specification for Cubic {
    declared!();

    fn gain(&self) -> Option<&LinearSpec> {
        Some(&self.linear)
    }

    fn takes_uncertainty(&self) -> bool {
        true
    }

    fn faster(&self, factor: f64, dt: Option<f64>) -> Option<ObserverKind> {
        Some(Self { linear: self.linear.faster(factor, dt), ..self.clone() }.into())
    }

    fn with_gamma(&self, gamma: f64) -> Option<ObserverKind> {
        let correction = super::sampled_cubic::with_strength(&self.correction, gamma)?;
        Some(Self { correction, ..self.clone() }.into())
    }
}

impl Kind for Cubic {
    fn design(&self, plan: &Plan<'_>) -> Result<Designed, NoObserver> {
        let plant = plan.linear()?;
        plan.at_point(designed(plan, plant, self)?)
    }

    fn sampled(&self, of: &Sampling<'_>) -> Result<Option<SampledDesign>, NoObserver> {
        let Some(plant) = of.plant() else { return Ok(None) };
        let linear = of.linear(plant, &self.linear)?;
        let cubic = of.cubic(&linear, (&self.theta, &self.correction))?;
        Ok(Some(SampledDesign::Cubic(Box::new(SampledCubicDesign::from_cubic(&linear, &cubic, of.period)?))))
    }
}

impl Running for CubicObserver<f64, Dyn, Dyn, Dyn> {
    runs!(continuous);

    fn at(&self, point: &OperatingPoint) -> Option<Result<Runnable, DesignError>> {
        Some(in_deviations(self.clone(), point).map(Runnable::from))
    }

    fn live(&self, _study: &Study) -> Option<(live::ObserverKind, Option<live::OperatingPoint>)> {
        Some((live::ObserverKind::Cubic(Box::new(self.clone())), None))
    }
}

impl Running for At<CubicObserver<f64, Dyn, Dyn, Dyn>> {
    runs!(continuous);

    fn live(&self, _study: &Study) -> Option<(live::ObserverKind, Option<live::OperatingPoint>)> {
        Some((live::ObserverKind::Cubic(Box::new(self.inner().clone())), Some(page_point(self))))
    }

    fn step(&self, _of: &StepOf<'_>) -> Result<Option<NonlinearStep>, NoObserver> {
        Err(at_point_refusal())
    }
}

/// Why a cubic observer at an operating point has no step on a target.
pub(super) fn at_point_refusal() -> NoObserver {
    NoObserver::new("a cubic observer in deviations from an operating point has no export")
        .hint("kind = \"luenberger\" at the same operating point has one")
}

fn designed(plan: &Plan<'_>, plant: &StateSpace, spec: &Cubic) -> Result<Designed, NoObserver> {
    let study = plan.study;
    let linear = linear::linear_design(plant, &spec.linear, &plan.options())?;
    let cubic = CubicDesign::new(&linear, &spec.theta, &spec.correction)?;
    let designed = report(study, plant, (&linear, &cubic), plan.requested.bounds.as_ref())?;
    Ok(feedback::cubic(study, &plan.requested.name, plant, &cubic, designed))
}

/// A cubic observer in numbers and words, with the bound of its error if that is asked for.
pub(crate) fn report(
    study: &Study,
    plant: &StateSpace,
    (linear, design): (&LinearDesign, &CubicDesign),
    bounds: Option<&ActingBounds>,
) -> Result<Designed, NoObserver> {
    let noise = NoiseGain::of(study, [(&plant.a, &plant.c)], design.l(), Some(&linear.poles));
    let mut numbers = vec![number("decay rate of small errors", -linear.spectral_abscissa())];
    numbers.extend(noise.numbers());
    let report = DesignReport {
        statement: proved_of(&design.certificate, &study.plant.reading()).remark(measurement(plant)),
        matrices: vec![
            matrix("L", design.l()),
            matrix("N", &design.observer.n),
            matrix("theta", &design.observer.theta),
            proof_matrix("P", &design.p),
            proof_matrix("Q", &design.q),
            proof_matrix("S", &design.s),
        ],
        poles: poles(&linear.poles),
        numbers,
        noise_deviation: noise.deviation,
        ..certified(&design.certificate, &[])
    };
    let designed = Designed::new(design.observer.clone().into(), report, Some(design.certificate.clone()))
        .with_continuous(linear, Some(design));
    match bounds {
        Some(bounds) => {
            let acting = acting(bounds);
            let bound = match &bounds.uncertain {
                Some((states, deviation)) => {
                    UncertainBound::cubic(design, deviation, states, Some(&acting))?.bound.clone()
                }
                None => ErrorBound::cubic(design, &acting)?,
            };
            let reading = Reading { scales: &half_ranges(study), ..study.plant.reading() };
            Ok(bounded(designed, &bound, &reading, bounds))
        }
        None => Ok(designed),
    }
}

fn tuned(context: &Context<'_>) -> Result<Keys, String> {
    in_continuous_time(context)?;
    let poles = placed(context, 0)?;
    let mut keys = vec![("poles", listed(&poles))];
    let (theta, unit) = unit_strength(context, &poles, false)?;
    keys.push(("theta", Value::numbers(theta)));
    keys.push(("gamma", Value::Number(short(CUBIC_SHARE / unit))));
    Ok(keys)
}
