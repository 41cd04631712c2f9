//! The reduced-order observer: the outputs enter the estimate directly. It runs as a KKL observer with linear maps:
//! `phi = T x`, `Lambda = F`, `B = G y + H u`, `phi^L = M xi + N y`.

use luenberger_design::ReducedOrderDesign;
use luenberger_export::extension::RecordedObserver;
use luenberger_expression::{Recorded, Recording};
use luenberger_linalg::{PolePattern, poles_from};
use luenberger_observers::{KklObserver, LinearInverse, LinearKkl};
use luenberger_plants::StateSpace;
use luenberger_proof::wording::counted;
use nalgebra::{Complex, DMatrix, Dyn};

use super::declaration::{Declaration, Information, Rule, Tuning};
use super::{Kind, as_kind};
use crate::designed::{Running, StepOf};
use crate::keys::{Type, required};
use crate::reader::{Given, Reader, check, gain};
use crate::results::{DesignReport, NoObserver, Quantity};
use crate::steps::recorded::{cast, recorded};
use crate::study::{GainSpec, ObserverKind, PlantClass, Specification, Study, Time};
use crate::synthesis::{Designed, Plan, asymptotic_rate, certified, matrix, number, poles, proved_of};
use crate::tuning::{Context, Keys, linear as is_linear, listed, sampled as in_time};

/// An observer of what the outputs leave open.
pub type ReducedOrderObserver = KklObserver<LinearKkl<f64, Dyn, Dyn, Dyn, Dyn, LinearInverse<f64, Dyn, Dyn, Dyn>>>;

/// The kind.
pub(super) static DECLARATION: Declaration = Declaration {
    name: "reduced-order",
    about: "Reduced-order observer (Luenberger, Gopinath): n - p states, the outputs enter the estimate directly; for linear plants whose outputs do not depend on the input.",
    source: "Luenberger 1964, Gopinath 1971",
    plant: PlantClass::Linear(Time::OF_STATE),
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

    fn poles(&self) -> Option<&[Complex<f64>]> {
        Some(&self.0)
    }

    fn faster(&self, factor: f64) -> Option<ObserverKind> {
        Some(Self(self.0.iter().map(|pole| pole * factor).collect()).into())
    }
}

impl Kind for ReducedOrder {
    fn design(&self, plan: &Plan<'_>) -> Result<Designed, NoObserver> {
        let plant = plan.linear()?;
        reduced_order(plan.study, plant, &self.0)
    }
}

impl Running for ReducedOrderObserver {
    runs!(continuous);

    fn record(&self, _of: &StepOf<'_>, recording: &mut Recording) -> Result<RecordedObserver, NoObserver> {
        let (maps, inverse) = (self.map(), self.map().inverse());
        let inverse = LinearInverse::new(cast(inverse.m()), cast(inverse.n()), cast(inverse.t()))?;
        let (d, b, e) = (cast(maps.d()), cast(maps.b()), cast(maps.e()));
        let maps = LinearKkl::<Recorded, Dyn, Dyn, Dyn, Dyn, _>::new(d, b, e, inverse);
        recorded(recording, &KklObserver::new(maps?))
    }
}

fn reduced_order(study: &Study, plant: &StateSpace, requested: &[Complex<f64>]) -> Result<Designed, NoObserver> {
    let design = ReducedOrderDesign::with_poles(plant, requested)?;
    let o = &design.observer;
    let inverse = LinearInverse::new(o.m.clone(), o.n.clone(), o.t.clone())?;
    let maps = LinearKkl::new(o.f.clone(), o.g.clone(), o.h.clone(), inverse)?;
    let slowest = -design.poles.iter().map(|pole| pole.re).fold(f64::NEG_INFINITY, f64::max);
    let named = [("T", &o.t), ("F", &o.f), ("G", &o.g), ("H", &o.h), ("M", &o.m), ("N", &o.n), ("P", &design.p)];
    let matrices = named.into_iter().filter(|(_, m)| !m.is_empty()).map(|(name, m)| matrix(name, m)).collect();
    let report = DesignReport {
        statement: proved_of(&design.certificate, &study.plant.reading())
            .remark("The outputs of the estimate are the measured ones, noise included.")
            .remark(asymptotic_rate(slowest)),
        matrices,
        poles: poles(&design.poles),
        numbers: vec![
            number(Quantity::DecayRate, slowest),
            number("noise passed to the estimate, norm of N", norm(&o.n)),
        ],
        ..certified(&design.certificate, &[])
    };
    let runnable = KklObserver::new(maps).into();
    Ok(Designed::new(runnable, report, Some(design.certificate.clone())))
}

fn norm(m: &DMatrix<f64>) -> f64 {
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
