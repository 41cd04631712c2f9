//! The KKL observer with given maps: `xi' = Lambda xi + B(y, u)`, `xhat = phi^L(xi, y)`.

use luenberger_design::kkl::KklSettings;
use luenberger_design::{Certificate, DesignError, KklDesign, Region};
use luenberger_export::extension::RecordedObserver;
use luenberger_expression::Recording;
use luenberger_observers::KklObserver;
use nalgebra::DMatrix;

use super::declaration::{Declaration, Tuning};
use super::keys::{LAMBDA, MAPS, PHI};
use super::{Kind, as_kind};
use crate::designed::{Running, StepOf};
use crate::maps::{KklMaps, KklMapsSpec, kkl_error_bound};
use crate::reader::maps::{bounded, kkl_maps};
use crate::reader::{Given, Reader};
use crate::results::{Advice, Cause, DesignReport, DesignVerdict, FactReport, NoObserver, Statement};
use crate::steps::recorded::recorded;
use crate::study::{ObserverKind, PlantClass, Specification, Study, Time};
use crate::synthesis::kkl_maps::{
    all_facts, bound_numbers, is_exact, is_left_inverse, measured_left_inverse, numbers, other_maps,
    undecided_injectivity,
};
use crate::synthesis::{Designed, Plan, proof_matrix, proved_of};

/// The kind.
pub(super) static DECLARATION: Declaration = Declaration {
    name: "kkl",
    about: "KKL observer xi' = Lambda xi + B(y, u), xhat = phi^L(xi, y), with maps that are given.",
    source: "Yi, Ortega and Zhang 2018, eq. (6), Proposition 1",
    plant: PlantClass::Nonlinear(Time::OF_STATE),
    keys: &[&[PHI, LAMBDA], MAPS],
    kind: as_kind::<KklMapsSpec>,
    read,
    takes_long: false,
    tuning: Tuning::MAPS_BY_HAND,
};

fn read(given: &Given<'_>, reader: &mut Reader) -> Option<ObserverKind> {
    let region = bounded(given.node, given.plant, reader);
    let maps = kkl_maps(given.node, given.plant, reader);
    Some(KklMapsSpec { maps: maps?, region: region? }.into())
}

impl Specification for KklMapsSpec {
    declared!();

    fn region_of_design(&self) -> Option<Region> {
        Some(self.region.clone())
    }
}

impl Kind for KklMapsSpec {
    fn design(&self, plan: &Plan<'_>) -> Result<Designed, NoObserver> {
        kkl(plan.study, self)
    }

    fn advice(&self, plan: &Plan<'_>, cause: &Cause) -> Option<Advice> {
        other_maps(plan.study, cause)
    }
}

impl Running for KklObserver<KklMaps> {
    runs!(continuous);

    fn record(&self, _of: &StepOf<'_>, recording: &mut Recording) -> Result<RecordedObserver, NoObserver> {
        recorded(recording, self)
    }
}

/// The observer, if (4) holds over the region up to rounding, Lambda is Hurwitz there, B is in cascade, and phi^L takes
/// phi(x) back at the samples.
///
/// What is proved of its error is what the certificate of the bound says, and nothing else: it covers (4), Lambda and
/// phi^L over the whole region.
fn kkl(study: &Study, spec: &KklMapsSpec) -> Result<Designed, NoObserver> {
    let KklMapsSpec { maps, region } = spec;
    let (model, reading) = (&study.plant.model, &study.plant.reading());
    let all: Vec<usize> = (0..maps.plant.states).collect();
    let settings = KklSettings::default();
    let design = KklDesign::new(model, maps.clone(), &all, region, &settings)?;
    is_left_inverse(study, maps, region, &design.report, settings.tolerance)?;
    let report = &design.report;
    let mut numbers = numbers(report);
    let stable = &report.stability;
    let poles = stable.eigenvalues.iter().map(|z| [z.re, z.im]).collect();
    let (statement, certificate, matrices, verdict, evidence) = match kkl_error_bound(model, maps, region) {
        Ok(bound) => {
            numbers.extend(bound_numbers(&bound, reading.states));
            let order = bound.p.rows();
            let p = proof_matrix("P", &DMatrix::from_fn(order, order, |i, j| bound.p[(i, j)]));
            // Its decrease implies that Lambda is Hurwitz.
            let certificate = Certificate::of([bound]).map_err(DesignError::from)?;
            let statement = proved_of(&certificate, reading);
            let verdict = DesignVerdict::of(&certificate);
            (statement, certificate, vec![p], verdict, None)
        }
        Err(why) => {
            let statement = Statement::of(format!(
                "The observer is made for xi - phi(x) to decay and xhat = phi^L(xi, y) to tend to x while x(t) and u(t) stay in the region ({region}). No bound of the estimation error is certified: {why}."
            ));
            let mut evidence = vec![measured_left_inverse(report)];
            if !report.injectivity.verdict.is_proved() {
                evidence.push(undecided_injectivity(report));
            }
            let p = stable.p.iter().map(|p| proof_matrix("P", p)).collect();
            (statement, stable.certificate.clone(), p, DesignVerdict::MEASURED, Some(evidence.join("; ")))
        }
    };
    let mut facts = all_facts(report, &certificate);
    if is_exact(&certificate) {
        // phi^L takes every (phi, h)(x) of the region back to x.
        facts.push(FactReport::of_region("phi^L(phi(x), h(x)) = x", "verified over the region".to_owned(), None));
    }
    let design_report = DesignReport {
        statement,
        matrices,
        poles,
        numbers,
        facts,
        verdict,
        evidence,
        noise_deviation: Vec::new(),
        stationary_deviation: None,
    };
    let runnable = design.observer.into();
    Ok(Designed::new(runnable, design_report, Some(certificate)))
}
