//! The reduced-order observer: the outputs enter the estimate directly. It runs as a KKL observer with linear maps:
//! `phi = T x`, `Lambda = F`, `B = G y + H u`, `phi^L = M xi + N y`, with `y - D u` for y; in discrete time in filter
//! form, as `DiscreteDesign::reduced_order` has it.

use luenberger_design::{DiscreteDesign, ReducedOrderDesign};
use luenberger_export::extension::RecordedObserver;
use luenberger_expression::{Recorded, Recording};
use luenberger_linalg::{PolePattern, poles_from};
use luenberger_observers::{
    FeedthroughObserver, KklObserver, LinearInverse, LinearKkl, ObserverError, StationaryKalmanFilter,
};
use luenberger_plants::StateSpace;
use luenberger_proof::wording::counted;
use nalgebra::{Complex, DMatrix, Dyn};

use super::declaration::{Declaration, Information, Rule, Tuning};
use super::{Kind, as_kind};
use crate::designed::{Origin, Running, SampledDesign, StepOf};
use crate::keys::{Type, required};
use crate::reader::{Given, Reader, check, gain};
use crate::results::{DesignReport, NoObserver, Quantity};
use crate::steps::recorded::{cast, recorded};
use crate::study::{GainSpec, ObserverKind, PlantClass, Specification, Study, Time, faster_poles};
use crate::synthesis::linear::measurement;
use crate::synthesis::{
    Designed, Plan, Sampling, asymptotic_factor, asymptotic_rate, certified, matrix, number, poles, proof_matrix,
    proved_of,
};
use crate::tuning::{Context, Keys, linear as is_linear, listed, sampled as in_time};

/// An observer of what the outputs leave open.
pub type ReducedOrderObserver = KklObserver<LinearMaps<f64>>;

type LinearMaps<T> = LinearKkl<T, Dyn, Dyn, Dyn, Dyn, LinearInverse<T, Dyn, Dyn, Dyn>>;

/// An observer of lower order of a plant whose outputs depend on the input.
pub type WithFeedthrough<O> = FeedthroughObserver<O, f64, Dyn, Dyn>;

/// The kind.
pub(super) static DECLARATION: Declaration = Declaration {
    name: "reduced-order",
    about: "Reduced-order observer (Luenberger, Gopinath): n - p states, the outputs enter the estimate directly; for linear plants.",
    source: "Luenberger 1964, Gopinath 1971",
    plant: PlantClass::Linear(Time::ANY),
    keys: &[&[required(
        "poles",
        Type::Poles,
        "Eigenvalues of F: n - p numbers, complex ones as [re, im] with their conjugates.",
    )]],
    kind: as_kind::<ReducedOrder>,
    read,
    takes_long: false,
    tuning: Tuning::Rules(&[Rule {
        name: "reduced-order",
        turn: 5,
        tuning: "poles of a Bessel filter of order n - p at the rate of luenberger",
        source: "luenberger poles --pattern bessel",
        character: "the measured states are taken from the outputs, with all of their noise",
        information: &[Information::Settling],
        keys: tuned,
    }]),
};

fn read(given: &Given<'_>, reader: &mut Reader) -> Option<ObserverKind> {
    let (node, size) = (given.node, given.size());
    let (n, p) = (size.states, size.outputs);
    if p >= n {
        let message =
            format!("the plant has {} and {}: no state is left to estimate", counted(n, "state"), counted(p, "output"));
        return reader.refuse(check::head(node), message, "expected a plant with fewer outputs than states");
    }
    let left = format!("of {} the outputs leave {}", counted(n, "state"), n - p);
    match gain::poles(node.get("poles")?, n - p, &left, reader)? {
        GainSpec::Poles(poles) => Some(ReducedOrder(poles).into()),
        _ => None,
    }
}

/// A reduced-order observer with these poles.
#[derive(Debug, Clone, PartialEq)]
pub struct ReducedOrder(pub Vec<Complex<f64>>);

impl Specification for ReducedOrder {
    declared!();

    fn free_keys(&self) -> &'static [&'static str] {
        &["poles"]
    }

    fn poles(&self) -> Option<&[Complex<f64>]> {
        Some(&self.0)
    }

    fn updates(&self, dt: Option<f64>) -> bool {
        dt.is_some()
    }

    fn faster(&self, factor: f64, dt: Option<f64>) -> Option<ObserverKind> {
        Some(Self(faster_poles(&self.0, factor, dt)).into())
    }
}

impl Kind for ReducedOrder {
    fn design(&self, plan: &Plan<'_>) -> Result<Designed, NoObserver> {
        let plant = plan.linear()?;
        reduced_order(plan.study, plant, &self.0)
    }

    fn design_in_discrete_time(&self, plan: &Plan<'_>, dt: f64) -> Result<Designed, NoObserver> {
        let plant = plan.linear()?;
        in_filter_form(plan, (plant, dt), &self.0)
    }

    fn sampled(&self, of: &Sampling<'_>) -> Result<Option<SampledDesign>, NoObserver> {
        let (Some(plant), Some(dt)) = (of.plant(), of.plan.study.plant.dt) else { return Ok(None) };
        if let Some(design) = of.designed.and_then(Designed::sampled) {
            return Ok(Some(design.clone()));
        }
        let design = DiscreteDesign::reduced_order(plant, dt, &self.0)?;
        Ok(Some(SampledDesign::Linear(Box::new(design))))
    }
}

impl Running for ReducedOrderObserver {
    runs!(continuous);

    fn record(&self, _of: &StepOf<'_>, recording: &mut Recording) -> Result<RecordedObserver, NoObserver> {
        recorded(recording, &over_recorded(self)?)
    }
}

impl Running for WithFeedthrough<ReducedOrderObserver> {
    runs!(continuous);

    fn record(&self, _of: &StepOf<'_>, recording: &mut Recording) -> Result<RecordedObserver, NoObserver> {
        recorded(recording, &FeedthroughObserver::new(over_recorded(self.inner())?, self.d().map(cast))?)
    }
}

/// The same over the scalar that records.
fn over_recorded(of: &ReducedOrderObserver) -> Result<KklObserver<LinearMaps<Recorded>>, ObserverError> {
    let (maps, inverse) = (of.map(), of.map().inverse());
    let inverse = LinearInverse::new(cast(inverse.m()), cast(inverse.n()), cast(inverse.t()))?;
    LinearKkl::new(cast(maps.d()), cast(maps.b()), cast(maps.e()), inverse).map(KklObserver::new)
}

/// What the estimate has of the outputs.
const MEASURED: &str = "The outputs of the estimate are the measured ones, noise included.";

fn reduced_order(study: &Study, plant: &StateSpace, requested: &[Complex<f64>]) -> Result<Designed, NoObserver> {
    let design = ReducedOrderDesign::with_poles(plant, requested)?;
    let o = &design.observer;
    let inverse = LinearInverse::new(o.m.clone(), o.n.clone(), o.t.clone())?;
    let observer = KklObserver::new(LinearKkl::new(o.f.clone(), o.g.clone(), o.h.clone(), inverse)?);
    let slowest = -design.poles.iter().map(|pole| pole.re).fold(f64::NEG_INFINITY, f64::max);
    let named = [("T", &o.t), ("F", &o.f), ("G", &o.g), ("H", &o.h), ("M", &o.m), ("N", &o.n), ("P", &design.p)];
    let matrices = named.into_iter().filter(|(_, m)| !m.is_empty()).map(|(name, m)| matrix(name, m)).collect();
    let report = DesignReport {
        statement: proved_of(&design.certificate, &study.plant.reading())
            .remark(MEASURED)
            .remark(measurement(plant))
            .remark(asymptotic_rate(slowest)),
        matrices,
        poles: poles(&design.poles),
        numbers: vec![number(Quantity::DecayRate, slowest), number(NOISE_PASSED, norm(&o.n))],
        ..certified(&design.certificate, &[])
    };
    let runnable = match &plant.d {
        Some(d) => FeedthroughObserver::new(observer, Some(d.clone()))?.into(),
        None => observer.into(),
    };
    Ok(Designed::new(runnable, report, Some(design.certificate.clone())))
}

/// The observer of a plant in discrete time.
fn in_filter_form(
    plan: &Plan<'_>,
    (plant, dt): (&StateSpace, f64),
    requested: &[Complex<f64>],
) -> Result<Designed, NoObserver> {
    let design = DiscreteDesign::reduced_order(plant, dt, requested)?;
    let (radius, n) = (design.spectral_radius(), design.update_gain().cloned().unwrap_or_default());
    let report = DesignReport {
        statement: proved_of(&design.certificate, &plan.reading())
            .remark("The estimate is xhat(k|k) = xhat(k|k-1) + N (y(k) - C xhat(k|k-1)); e is the error of the prediction xhat(k|k-1), and w = T xhat(k|k-1) has n - p entries: p of the poles are 0.")
            .remark(MEASURED)
            .remark(measurement(plant))
            .remark(asymptotic_factor(radius)),
        matrices: vec![matrix("N (gain of the measurement update, L = A N)", &n), matrix("L", design.l()), proof_matrix("P", &design.p)],
        poles: poles(&design.poles),
        numbers: vec![
            number(Quantity::Period, dt),
            number(Quantity::LargestPole, radius),
            number(NOISE_PASSED, norm(&n)),
        ],
        ..certified(&design.certificate, &[])
    };
    let filter = StationaryKalmanFilter::new(design.observer.clone(), n)?;
    let origin = Origin::Sampled(SampledDesign::Linear(Box::new(design.clone())));
    Ok(Designed { runnable: filter.into(), report, certificate: Some(design.certificate.clone()), origin })
}

/// The name of the norm of N in reports.
pub(super) const NOISE_PASSED: &str = "noise passed to the estimate, norm of N";

/// The spectral norm.
pub(super) fn norm(m: &DMatrix<f64>) -> f64 {
    m.clone().svd(false, false).singular_values.max()
}

fn tuned(context: &Context<'_>) -> Result<Vec<Keys>, String> {
    is_linear(context)?;
    let (plant, information) = (&context.study.plant, context.information);
    let order = plant.states.len().saturating_sub(plant.outputs.len());
    if order == 0 {
        return Err(format!("it estimates n - p states, and the plant has n = p = {}", plant.states.len()));
    }
    let settling = -information.band.ln() / information.linear_rate;
    let found =
        poles_from(PolePattern::Bessel, order, settling, information.band).map_err(|error| error.to_string())?;
    let poles: Vec<_> = found.into_iter().map(|pole| in_time(pole, plant.dt)).collect();
    Ok(vec![vec![("poles", listed(&poles))]])
}
