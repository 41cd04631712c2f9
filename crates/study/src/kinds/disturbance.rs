//! Observers of the state and of a disturbance: the kinds `proportional-integral` and `extended-state`.

use luenberger_design::{
    CubicDesign, CubicGain, DesignError, DiscreteDesign, ErrorBound, LinearDesign, Pair, SampledCubicDesign,
    disturbances_with_rate, disturbances_with_sampled_rate, proportional_integral as handed_out,
    with_disturbance_chain, with_sampled_disturbance_chain,
};
use luenberger_live as live;
use luenberger_observers::{CubicObserver, DiscreteLinearObserver, LinearObserver, ProportionalIntegralObserver};
use luenberger_plants::{Dimensions, StateSpace};
use luenberger_proof::certificate::{Reading, Represented};
use luenberger_proof::wording::counted;
use nalgebra::{DMatrix, Dyn};

use super::Kind;
use super::keys::{GAMMA, THETA};
use super::{extended_state, proportional_integral};
use crate::designed::{Runnable, Running, SampledDesign};
use crate::operation::half_ranges;
use crate::reader::tree::Node;
use crate::reader::{Given, Reader, gain};
use crate::results::{Advice, Cause, DesignReport, NoObserver, Quantity};
use crate::steps::{self};
use crate::study::{ActingBounds, LinearSpec, ObserverKind, PlantClass, Specification, Study};
use crate::synthesis::alternative::another_gain;
use crate::synthesis::error_bound::{acting, bounded};
use crate::synthesis::linear::{self, measurement};
use crate::synthesis::{
    Designed, Plan, Sampling, asymptotic_rate, certified, discrete, matrix, number, poles, proof_matrix, proved_of,
};

/// An observer of the state and of a disturbance: an unknown one enters as `x' = A x + B u + E d`, in discrete time
/// `x+`.
pub type WithDisturbance<O> = ProportionalIntegralObserver<O, Dyn>;

/// The most integrators in the model of a disturbance.
const LONGEST_CHAIN: usize = 16;

/// The specification; of an extended-state observer with its order.
pub(super) fn read(given: &Given<'_>, is_extended: bool, reader: &mut Reader) -> Option<ObserverKind> {
    let (node, size) = (given.node, given.size());
    let e = unknown(node, size, reader)?;
    let q = e.ncols();
    let order = node.get("order").map_or(Some(1), Node::count)?;
    let chain = is_extended.then_some(order);
    if order == 0 {
        let message = "`order` is 0: no disturbance would be estimated";
        return reader.refuse(node.get("order")?.span.clone(), message, "expected 1 or more");
    }
    if order > LONGEST_CHAIN {
        let message = format!("`order` is {order}: {order} derivatives of each disturbance would be estimated");
        return reader.refuse(node.get("order")?.span.clone(), message, format!("expected at most {LONGEST_CHAIN}"));
    }
    let both = Dimensions { states: size.states + order * q, ..size };
    let disturbances = if order == 1 {
        counted(q, "disturbance")
    } else {
        format!("{} with {}", counted(q, "disturbance"), counted(order - 1, "derivative"))
    };
    let of_states = format!("the plant has {} and {disturbances} to be estimated", counted(size.states, "state"));
    let linear = gain::linear_of(node, both, &of_states, reader);
    let cubic = cubic(given, reader);
    let rate = match node.get("rate") {
        None => Some(vec![0.0; q]),
        Some(list) => {
            let rate = list.numbers()?;
            if rate.len() != q {
                let message = format!("`rate` has length {}, and `e` has {}", rate.len(), counted(q, "column"));
                return reader.refuse(list.span.clone(), message, format!("expected length {q}"));
            }
            Some(rate)
        }
    };
    let rate = rate?;
    if rate.iter().any(|rate| *rate > 0.0) && node.get("bounds").is_none() {
        let message = "`rate` has no effect without `bounds`, which asks for a bound of the error";
        return reader.refuse(node.entry("rate")?.span.clone(), message, "expected `bounds` with it");
    }
    Some(DisturbanceSpec { e, chain, rate, linear: linear?, cubic: cubic? }.into())
}

/// E, with a column for each disturbance.
pub(super) fn unknown(node: &Node, size: Dimensions, reader: &mut Reader) -> Option<DMatrix<f64>> {
    let why = format!("the plant has {}", counted(size.states, "state"));
    reader.matrix(node.get("e")?, "e", (Some(size.states), None), &why)
}

crate::keys! {
    /// A cubic term.
    pub(super) struct CubicTerm {
        /// theta, p x p.
        theta: Option<DMatrix<f64>>[p, p] as &THETA,
        /// gamma.
        gamma: Option<f64> as &GAMMA,
    }
}

/// theta and gamma; none without `gamma`, where theta has no effect.
#[expect(clippy::option_option, reason = "wrong, absent, or given")]
pub(super) fn cubic(given: &Given<'_>, reader: &mut Reader) -> Option<Option<(DMatrix<f64>, f64)>> {
    let (CubicTerm { theta, gamma }, p) = (CubicTerm::read(given, reader)?, given.size().outputs);
    if let (None, Some(entry)) = (gamma, given.node.entry(THETA.name)) {
        let message = "`theta` has no effect without a cubic term";
        return reader.refuse(entry.span.clone(), message, "expected `gamma` with it");
    }
    Some(gamma.map(|gamma| (theta.unwrap_or_else(|| DMatrix::identity(p, p)), gamma)))
}

/// An observer of the state and of a slowly varying disturbance, linear or cubic.
#[derive(Debug, Clone, PartialEq)]
pub struct DisturbanceSpec {
    /// E, n x q.
    pub e: DMatrix<f64>,
    /// The number k of integrators in the model `d^(k) = 0` of each disturbance; none for the kind that has one.
    pub chain: Option<usize>,
    /// Bounds of the k-th derivative of the disturbance, one for each.
    pub rate: Vec<f64>,
    /// Its linear part, for the plant with the disturbance among its states.
    pub linear: LinearSpec,
    /// theta, p x p, and gamma of a cubic term.
    pub cubic: Option<(DMatrix<f64>, f64)>,
}

impl Specification for DisturbanceSpec {
    fn name(&self) -> &'static str {
        if self.chain.is_some() { extended_state::DECLARATION.name } else { proportional_integral::DECLARATION.name }
    }

    fn plant(&self) -> PlantClass {
        proportional_integral::DECLARATION.plant
    }

    fn gain(&self) -> Option<&LinearSpec> {
        Some(&self.linear)
    }

    fn estimated_disturbances(&self) -> Vec<String> {
        let suffix = |derivative: usize| match derivative {
            0 => String::new(),
            1 => "_rate".to_owned(),
            k => format!("_rate{k}"),
        };
        let of = |k: usize| (1..=self.e.ncols()).map(move |j| format!("d{j}{}", suffix(k)));
        (0..self.order()).flat_map(of).collect()
    }

    fn unknown_disturbance(&self) -> Option<&DMatrix<f64>> {
        Some(&self.e)
    }

    fn faster(&self, factor: f64, dt: Option<f64>) -> Option<ObserverKind> {
        Some(Self { linear: self.linear.faster(factor, dt), ..self.clone() }.into())
    }

    fn with_gamma(&self, gamma: f64) -> Option<ObserverKind> {
        let (theta, _) = self.cubic.as_ref()?;
        Some(Self { cubic: Some((theta.clone(), gamma)), ..self.clone() }.into())
    }

    fn remark_of_export(&self, _study: &Study, is_certified: bool) -> Option<String> {
        let rate = match self.order() {
            1 => "constant disturbances".to_owned(),
            chain => format!("disturbances whose derivative of order {chain} is 0"),
        };
        is_certified.then(|| format!("The plant of the certificate is that of the study with {rate} among its states."))
    }
}

impl Kind for DisturbanceSpec {
    fn design(&self, plan: &Plan<'_>) -> Result<Designed, NoObserver> {
        let plant = plan.linear()?;
        self.designed(plan, plant)
    }

    fn design_in_discrete_time(&self, plan: &Plan<'_>, dt: f64) -> Result<Designed, NoObserver> {
        let plant = plan.linear()?;
        if self.cubic.is_some() {
            let hypothesis =
                format!("a cubic term, `gamma`, is for plants in continuous time, and this one has dt = {dt}");
            return Err(NoObserver::new(hypothesis).hint("no `gamma`"));
        }
        let both = with_sampled_disturbance_chain(plant, &self.e, self.order(), dt)?;
        let found = discrete::decided(plan, &both, (&self.linear, dt))?;
        let design = found.map_err(|error| error.of_pair(Pair::WithDisturbance))?;
        self.designed_at_samples(plan, plant, (&design, dt))
    }

    fn advice(&self, plan: &Plan<'_>, cause: &Cause) -> Option<Advice> {
        match cause {
            Cause::Design(DesignError::UnseenDisturbance { .. }) => {
                Some(Advice::hint("fewer columns of `e`, or an output that depends on this state"))
            }
            Cause::Design(DesignError::OfPair { pair: Pair::WithDisturbance, .. }) => {
                let hint = Advice::hint("other units, or an output that depends more on the disturbance");
                Some(another_gain(plan.requested).and(hint))
            }
            _ => None,
        }
    }

    fn sampled(&self, of: &Sampling<'_>) -> Result<Option<SampledDesign>, NoObserver> {
        let Some(plant) = of.plant() else { return Ok(None) };
        if let Some(dt) = of.plan.study.plant.dt {
            if let Some(design) = of.designed.and_then(Designed::sampled) {
                return Ok(Some(design.clone()));
            }
            let both = with_sampled_disturbance_chain(plant, &self.e, self.order(), dt)?;
            let design = discrete::gain_of_step(&of.plan, &both, &self.linear, dt)?;
            return Ok(Some(SampledDesign::Linear(Box::new(design))));
        }
        let both = with_disturbance_chain(plant, &self.e, self.order())?;
        let linear = of.linear(&both, &self.linear)?;
        Ok(Some(match &self.cubic {
            Some((theta, gamma)) => {
                let cubic = of.cubic(&linear, (theta, &CubicGain::Gamma(*gamma)))?;
                SampledDesign::Cubic(Box::new(SampledCubicDesign::from_cubic(&linear, &cubic, of.period)?))
            }
            None => SampledDesign::Linear(Box::new(steps::sampled_linear(&linear, &self.linear, of.period)?)),
        }))
    }
}

/// The numbers of a linear and perhaps a cubic design.
pub(super) fn matrices(linear: &LinearDesign, cubic: Option<&CubicDesign>) -> Vec<crate::results::NamedMatrix> {
    let mut found = vec![matrix("L", linear.l()), proof_matrix("P", &linear.p), proof_matrix("Q", &linear.q)];
    if let Some(cubic) = cubic {
        found.extend([
            matrix("N", &cubic.observer.n),
            matrix("theta", &cubic.observer.theta),
            proof_matrix("S", &cubic.s),
        ]);
    }
    found
}

pub(super) fn cubic_of(
    linear: &LinearDesign,
    cubic: Option<&(DMatrix<f64>, f64)>,
) -> Result<Option<CubicDesign>, NoObserver> {
    let design = cubic.map(|(theta, gamma)| CubicDesign::new(linear, theta, &CubicGain::Gamma(*gamma)));
    Ok(design.transpose()?)
}

impl DisturbanceSpec {
    /// The number of integrators in the model of each disturbance.
    fn order(&self) -> usize {
        self.chain.unwrap_or(1)
    }

    fn designed_at_samples(
        &self,
        plan: &Plan<'_>,
        plant: &StateSpace,
        (design, dt): (&DiscreteDesign, f64),
    ) -> Result<Designed, NoObserver> {
        let n = plant.a.nrows();
        let all: Vec<String> = plan.reading().states.iter().cloned().chain(self.estimated_disturbances()).collect();
        let represented = Represented::WithDisturbance { states: n, order: self.order() };
        let reading = Reading { states: &all, plant: represented, ..plan.reading() };
        let (report, _) = discrete::described(&reading, plant, design, (&self.linear, dt));
        let observer = ProportionalIntegralObserver::of_samples(design.observer.clone(), Dyn(n))?;
        let designed = discrete::designed(observer.into(), report, design);
        let Some(bounds) = &plan.requested.bounds else { return Ok(designed) };
        let acting = disturbances_with_sampled_rate(&acting(bounds), &self.rate, self.order(), dt);
        let bound = ErrorBound::discrete(&design.observer, &acting)?;
        Ok(bounded(designed, &bound, &Reading { scales: &half_ranges(plan.study), ..reading }, bounds))
    }

    fn designed(&self, plan: &Plan<'_>, plant: &StateSpace) -> Result<Designed, NoObserver> {
        let names = self.estimated_disturbances();
        let acting = (plan.requested.bounds.as_ref(), self.rate.as_slice(), names.as_slice());
        let scales = plan.requested.bounds.as_ref().map_or_else(Vec::new, |_| half_ranges(plan.study));
        let plant = (plant, &Reading { scales: &scales, ..plan.reading() });
        let gain = (&self.linear, self.cubic.as_ref());
        designed(plant, (&self.e, self.chain), gain, acting, &plan.options())
    }
}

fn designed(
    (plant, reading): (&StateSpace, &Reading<'_>),
    (e, chain): (&DMatrix<f64>, Option<usize>),
    (gain, cubic): (&LinearSpec, Option<&(DMatrix<f64>, f64)>),
    (bounds, rate, names): (Option<&ActingBounds>, &[f64], &[String]),
    options: &luenberger_design::GainOptions,
) -> Result<Designed, NoObserver> {
    let (n, order) = (plant.a.nrows(), chain.unwrap_or(1));
    let both = with_disturbance_chain(plant, e, order)?;
    let linear = linear::linear_design(&both, gain, options).map_err(|error| error.of_pair(Pair::WithDisturbance))?;
    let cubic = cubic_of(&linear, cubic)?;
    let certificate = cubic.as_ref().map_or(&linear.certificate, |cubic| &cubic.certificate).clone();
    let runnable = match &cubic {
        None => Runnable::from(handed_out(linear.observer.clone(), n)?),
        Some(cubic) => handed_out(cubic.observer.clone(), n)?.into(),
    };
    let speed = -linear.spectral_abscissa();
    let all: Vec<String> = reading.states.iter().chain(names).cloned().collect();
    let reading = Reading { states: &all, plant: Represented::WithDisturbance { states: n, order }, ..*reading };
    let report = DesignReport {
        statement: proved_of(&certificate, &reading).remark(measurement(plant)).remark(asymptotic_rate(speed)),
        matrices: matrices(&linear, cubic.as_ref()),
        poles: poles(&linear.poles),
        numbers: vec![number(Quantity::DecayRate, speed)],
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

impl Running for WithDisturbance<LinearObserver<f64, Dyn, Dyn, Dyn>> {
    runs!(continuous);

    fn disturbances(&self) -> usize {
        disturbances(self)
    }

    fn live(&self, _study: &Study) -> Option<(live::ObserverKind, Option<live::OperatingPoint>)> {
        Some((live::ObserverKind::ProportionalIntegral { observer: Box::new(self.inner().clone()) }, None))
    }
}

impl Running for WithDisturbance<DiscreteLinearObserver<f64, Dyn, Dyn, Dyn>> {
    runs!(sampled);

    fn disturbances(&self) -> usize {
        disturbances(self)
    }

    fn live(&self, _study: &Study) -> Option<(live::ObserverKind, Option<live::OperatingPoint>)> {
        Some((live::ObserverKind::ProportionalIntegralDiscrete { observer: Box::new(self.inner().clone()) }, None))
    }
}

impl Running for WithDisturbance<CubicObserver<f64, Dyn, Dyn, Dyn>> {
    runs!(continuous);

    fn disturbances(&self) -> usize {
        disturbances(self)
    }

    fn live(&self, _study: &Study) -> Option<(live::ObserverKind, Option<live::OperatingPoint>)> {
        Some((live::ObserverKind::ProportionalIntegralCubic { observer: Box::new(self.inner().clone()) }, None))
    }
}

/// The states of an observer that are not its estimate.
fn disturbances<O: Running>(observer: &O) -> usize {
    let size = observer.any().dimensions();
    size.state - size.estimate
}
