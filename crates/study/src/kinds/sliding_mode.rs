//! The sliding-mode observer of a chain of integrators.

use luenberger_design::{SuperTwistingDesign, sliding_mode_gains};
use luenberger_export::ExportableObserver;
use luenberger_export::step::RecordedStep;
use luenberger_expression::{ExpressionPlant, Recorded, Row};
use luenberger_live as live;
use luenberger_observers::SampledObserver;
use luenberger_observers::sliding_mode::{Discretisation, SlidingModeObserver};
use luenberger_plants::Plant;
use luenberger_proof::certificate::Reading;
use luenberger_proof::wording::{at_most, significant};
use nalgebra::{DMatrix, DVector, Dyn, convert};

use super::declaration::{Declaration, Information, Rule, Tuning};
use super::keys::PERIOD;
use super::{Kind, as_kind};
use crate::designed::{NonlinearStep, Running, StepOf};
use crate::study::{ObserverKind, ObserverSpec, PlantClass, Specification, Study, Time};
use crate::synthesis::{Designed, Plan, facts, matrix, number, other_kinds, proof_matrix, proved_of, upper_bound};
use crate::tuning::{Context, INSTANTS, Keys, MANY, Value, continuous as in_continuous_time, short};

use crate::model::Model;
use crate::results::{Advice, DesignReport, DesignVerdict, NoObserver, Proposal, Quantity, Statement};
use crate::structure::Structure;
use crate::synthesis::explain;

/// The kind.
pub(super) static DECLARATION: Declaration = Declaration {
    name: "sliding-mode",
    about: "Super-twisting observer and robust exact differentiator, for chains of integrators x1' = x2, .., x_n' = f(x, u) + d with the output x1: exact after a finite time in continuous time, stepped at samples without chattering.",
    source: "Levant 2003; Davila, Fridman and Levant 2005; implicit step: Acary and Brogliato 2010, Mojallizadeh, Brogliato and Acary 2021",
    plant: PlantClass::Nonlinear(Time::CONTINUOUS),
    keys: &[SlidingModeSpec::KEYS],
    kind: as_kind::<SlidingModeSpec>,
    read: |given, reader| Some(SlidingModeSpec::read(given, reader)?.into()),
    takes_long: false,
    tuning: Tuning::Rules(&[Rule {
        name: "sliding-mode",
        turn: 17,
        tuning: "the larger of two bounds D: that of the disturbance and of what f differs by within the region, and the first error of the last state over the settling time",
        source: "docs/sliding-mode.md",
        character: "it rejects a bounded disturbance exactly in the limit of fast sampling, and does not average the noise",
        information: &[Information::Settling, Information::Region, Information::FirstError, Information::Bounds],
        keys: tuned,
    }]),
};

crate::keys! {
    /// A sliding-mode observer.
    #[derive(Debug, Clone, PartialEq)]
    pub struct SlidingModeSpec {
        /// Bound of |d|, the disturbance and the model error in the equation of x_n.
        bound: f64 as Number(Positive),
        /// Gains k_i of |e|^((n-i)/n) sign(e), n numbers (default: from the bound D, for n = 2 2.1 D^(1/2) and 1.1 D).
        k: Option<Vec<f64>>[n] as Numbers(Positive),
        /// The sampling period.
        period: f64 as &PERIOD,
        /// How the sign is discretised (default implicit).
        discretisation: Discretisation as Choice = Discretisation::Implicit,
    }
}

crate::words! { Discretisation {
    /// The implicit Euler method, which does not chatter.
    Implicit = "implicit",
    /// The explicit Euler method, for comparison.
    Explicit = "explicit",
} }

impl SlidingModeSpec {
    /// The gains that follow from the bound, and the implicit discretisation.
    pub fn new(bound: f64, period: f64) -> Self {
        Self { bound, k: None, period, discretisation: Discretisation::Implicit }
    }
}

impl Specification for SlidingModeSpec {
    declared!();

    fn free_keys(&self) -> &'static [&'static str] {
        &["bound", "k"]
    }

    fn period(&self) -> Option<f64> {
        Some(self.period)
    }

    // Gains as for a bound that is factor^n times as large: time in units of 1/factor.
    fn faster(&self, factor: f64, _dt: Option<f64>) -> Option<ObserverKind> {
        let power = |i: usize| factor.powi(i32::try_from(i + 1).unwrap_or(i32::MAX));
        let scaled = |gains: &Vec<f64>| gains.iter().enumerate().map(|(i, gain)| gain * power(i)).collect();
        Some(Self { k: self.k.as_ref().map(scaled), ..self.clone() }.into())
    }
}

impl Kind for SlidingModeSpec {
    fn design(&self, plan: &Plan<'_>) -> Result<Designed, NoObserver> {
        chain(plan.study, plan.requested)?;
        designed(&plan.study.plant.model, &plan.reading(), self)
    }
}

impl Running for SlidingModeObserver<Model, f64, Dyn, Dyn, Dyn> {
    runs!(sampled);

    fn live(&self, _study: &Study) -> Option<(live::ObserverKind, Option<live::OperatingPoint>)> {
        let (gains, period) = (self.gains().as_slice().to_vec(), self.period());
        let explicit = self.discretisation() == Discretisation::Explicit;
        Some((live::ObserverKind::SlidingMode { gains, period, explicit }, None))
    }

    fn step(&self, of: &StepOf<'_>) -> Result<Option<NonlinearStep>, NoObserver> {
        Ok(Some(NonlinearStep::of(of.designed, ExportableObserver::Step(program(self, of.plant)?))))
    }
}

/// The step of a sliding-mode observer.
///
/// # Errors
/// Why it has none.
fn program(
    observer: &SlidingModeObserver<Model, f64, Dyn, Dyn, Dyn>,
    plant: &ExpressionPlant,
) -> Result<RecordedStep<f64>, NoObserver> {
    let (rule, period) = (observer.discretisation(), observer.period());
    plant.record(|recording| {
        let gains = observer.gains().map(convert);
        let same: SlidingModeObserver<Model, Recorded, Dyn, Dyn, Dyn> =
            SlidingModeObserver::new(observer.plant().clone(), gains, convert(period), rule)?;
        let size = same.dimensions();
        let step = |t, xhat: &[Recorded], u: &[Recorded], y: &[Recorded]| {
            let mut xhat = DVector::from_column_slice(xhat);
            same.step(t, &mut xhat, &DVector::from_column_slice(u), &DVector::from_column_slice(y));
            xhat.as_slice().to_vec()
        };
        let output = |t, xhat: &[Recorded]| {
            plant.output(t, &DVector::from_column_slice(xhat), &DVector::zeros(size.inputs)).as_slice().to_vec()
        };
        Ok(RecordedStep::new(recording, size, period, step, output)?)
    })
}

/// Why the plant is not shown to be a chain `x1' = x2, .., x_n' = f` with the output x1 and the inputs in the last.
fn not_a_chain(study: &Study, structure: &Structure) -> Option<String> {
    let size = study.plant.model.size();
    if size.outputs != 1 {
        return Some(format!("the plant has {} outputs", size.outputs));
    }
    if structure.output_state(0) != Some(0) {
        return Some(explain::other_than(study, structure, Row::Output(0), 0));
    }
    let i = (0..size.states.saturating_sub(1)).find(|i| !structure.is_next_state(*i))?;
    Some(explain::other_than(study, structure, Row::Derivative(i), i + 1))
}

fn chain(study: &Study, requested: &ObserverSpec) -> Result<(), NoObserver> {
    let (structure, kind) = (study.plant.model.structure(), requested.kind.name());
    let Some(why) = not_a_chain(study, &structure) else { return Ok(()) };
    let hypothesis = format!(
        "the kind {kind} is for a chain of integrators, x1' = x2, .., with the output x1 and the input in the last: {why}"
    );
    let is_triangular = study.plant.outputs.len() == 1
        && structure.feedthrough().is_none()
        && explain::no_chains(study, &structure, kind, &[study.plant.states.len()]).is_none();
    let high_gain = Proposal::kind("high-gain", ["r = 0.1".to_owned()], "for triangular plants; r is to be chosen");
    let advice = Advice::of(is_triangular.then_some(high_gain))
        .and(other_kinds(study, requested))
        .and(Advice::hint("states that are the output and its derivatives, where the plant has them"));
    Err(NoObserver::new(hypothesis).advise(advice))
}

/// The gains of a specification.
fn gains(spec: &SlidingModeSpec, order: usize) -> Result<Vec<f64>, luenberger_design::DesignError> {
    match &spec.k {
        Some(gains) => Ok(gains.clone()),
        None => sliding_mode_gains(order, spec.bound),
    }
}

fn designed(model: &Model, reading: &Reading<'_>, spec: &SlidingModeSpec) -> Result<Designed, NoObserver> {
    let states = reading.states;
    let n = model.size().states;
    let gains = gains(spec, n)?;
    let (rule, is_explicit) = (spec.discretisation, spec.discretisation == Discretisation::Explicit);
    let observer = SlidingModeObserver::new(model.clone(), DVector::from_column_slice(&gains), spec.period, rule)?;
    let certified = match gains.as_slice() {
        [k1, k2] => SuperTwistingDesign::new([*k1, *k2], spec.bound)?,
        _ => None,
    };
    let (h, bound) = (spec.period, spec.bound);
    let statement = match (&certified, n) {
        (Some(design), _) => proved_of(&design.certificate, reading),
        (None, 2) => Statement::of(
            "No stability certificate: the quadratic Lyapunov function was not found for these gains and this bound, which does not mean that the observer fails.",
        ),
        (None, _) => Statement::of(format!(
            "No stability certificate for {n} states: convergence in continuous time is a theorem of Levant's, for gains that are large enough."
        )),
    };
    let mut statement = statement.remark(match (is_explicit, n) {
        (true, _) => "The step evaluates the sign at the old estimate (explicit Euler): it chatters, and is meant for comparison.",
        (false, _) => "The step solves for the sign (implicit Euler): it does not chatter.",
    });
    if !is_explicit && n == 2 && gains[1] >= bound {
        statement = statement.remark(format!(
            "Of the sampled observer the theory says, beside the certificate: once two innovations in a row are at most h^2 k2, about {}, and without noise, {} is exact at every sample after its correction, and {} up to h {}/2 = {}.",
            significant(h * h * gains[1], 4),
            states[0],
            states[1],
            at_most(bound, 5),
            at_most(h * bound / 2.0, 4)
        ));
    }
    let mut numbers =
        vec![number(Quantity::Period, h), number("innovation that is corrected to 0", observer.boundary_layer())];
    let mut matrices = vec![matrix("k", &DMatrix::from_column_slice(n, 1, &gains))];
    let (found, word, evidence) = match &certified {
        Some(design) => {
            numbers.push(number("alpha", design.alpha));
            numbers.push(number("c", design.c));
            numbers.push(upper_bound(
                "bound of the reaching time from an error of 1 in the last state",
                design.reaching_time(0.0, 1.0),
            ));
            matrices.push(proof_matrix("P", &design.p));
            (facts(&design.certificate, &[]), DesignVerdict::of(&design.certificate), None)
        }
        None => (Vec::new(), DesignVerdict::NONE, Some("no certificate: check these gains by simulation".to_owned())),
    };
    let report = DesignReport {
        statement,
        matrices,
        poles: Vec::new(),
        numbers,
        facts: found,
        verdict: word,
        evidence,
        noise_deviation: Vec::new(),
        stationary_deviation: None,
    };
    let certificate = certified.map(|design| design.certificate.clone());
    Ok(Designed::new(observer.into(), report, certificate))
}

/// D of the reaching time: from an error e2 without a disturbance the default gains for two states reach 0 after the
/// time 0.99 e2/D.
fn tuned(context: &Context<'_>) -> Result<Vec<Keys>, String> {
    in_continuous_time(context)?;
    let (plant, information) = (&context.study.plant, context.information);
    let last = plant.states.len() - 1;
    let open =
        spread(context, last).ok_or_else(|| format!("{}' is not finite anywhere in the region", plant.states[last]))?;
    let acting = information.acting.as_ref().map_or(0.0, |(bounds, e)| {
        bounds.iter().zip(e.row(last).iter()).map(|(bound, e)| (bound * e).abs()).sum::<f64>()
    });
    let reaching = information.first_error[last] / information.settling;
    let bound = (open + acting).max(reaching);
    Ok(vec![vec![("bound", Value::Number(short(bound))), ("period", Value::Number(information.period))]])
}

/// By how much the derivative of a state differs at most between points of a grid over the region, under one input and
/// at one time.
fn spread(context: &Context<'_>, state: usize) -> Option<f64> {
    let (plant, region) = (&context.study.plant, &context.information.region);
    let (n, inputs) = (plant.states.len(), region.input_bounds().unwrap_or_default());
    // At least the corners, the middle and the quarters of each axis, and a few thousand points.
    let steps = (4000f64.powf(1.0 / n as f64) as usize).clamp(2, 64);
    let points = (steps + 1).pow(n.min(2 * MANY) as u32);
    let derivative = |k: usize, t: f64, u: &DVector<f64>| {
        let x = region.states().iter().enumerate().map(|(i, (low, high))| {
            let share = k / (steps + 1).pow(i.min(2 * MANY) as u32) % (steps + 1);
            low + share as f64 / steps as f64 * (high - low)
        });
        plant.model.derivative(t, &DVector::from_iterator(n, x), u)[state]
    };
    let duration = context.study.simulation.as_ref().map_or(0.0, |simulation| simulation.duration);
    let instants = if plant.model.structure().explicit_time().is_some() { INSTANTS } else { 1 };
    let corners = 0..1usize << inputs.len().min(MANY);
    let cases = corners.flat_map(|corner| (0..instants).map(move |k| (corner, duration * k as f64 / INSTANTS as f64)));
    let widths = cases.filter_map(|(corner, t)| {
        let at = |(j, (low, high)): (usize, &(f64, f64))| if corner >> j & 1 == 0 { *low } else { *high };
        let u = DVector::from_iterator(inputs.len(), inputs.iter().enumerate().map(at));
        let values = (0..points).map(|k| derivative(k, t, &u)).filter(|value| value.is_finite());
        let (low, high) = values.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), x| (low.min(x), high.max(x)));
        (low <= high).then_some(high - low)
    });
    widths.reduce(f64::max)
}
