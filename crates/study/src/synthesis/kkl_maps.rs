//! KKL observers with given maps: the checks of phi, Lambda, B and phi^L over the region, in numbers and words.

use luenberger_design::kkl::KklReport;
use luenberger_design::{Certificate, KklCandidate, KklError, Region};
use luenberger_observers::kkl::KklMap;
use luenberger_plants::Plant;
use luenberger_proof::Verdict;
use luenberger_proof::certificate::{KklErrorBound, Theorem};
use luenberger_proof::wording::{at_most, counted, significant};
use nalgebra::DVector;

use super::{facts, lower_bound, number, upper_bound};
use crate::maps::KklMaps;
use crate::model::Model;
use crate::results::{Advice, Cause, FactReport, NamedNumber, NoObserver};
use crate::study::Study;

/// The plant with the given maps, as the checks of `luenberger-design` take them. All states are estimated.
///
/// # Errors
/// [`KklError`] for sizes that do not fit, which a study cannot have.
pub fn candidate<'a>(model: &'a Model, maps: &'a KklMaps) -> Result<KklCandidate<'a, Model, KklMaps>, KklError> {
    let all: Vec<usize> = (0..maps.plant.states).collect();
    KklCandidate::new(model, maps, &all)
}

/// Whether the certificate says that phi^L has no defect.
pub(crate) fn is_exact(certificate: &Certificate) -> bool {
    certificate.theorems().iter().any(|proved| match proved.theorem() {
        Theorem::KklErrorBound(bound) => bound.claims.defect.iter().all(|defect| *defect == 0.0),
        _ => false,
    })
}

/// The numbers of the bound.
pub(crate) fn bound_numbers(bound: &KklErrorBound, names: &[String]) -> Vec<NamedNumber> {
    let claims = &bound.claims;
    let mut numbers = vec![
        lower_bound("guaranteed rate of decay of V = sqrt(e'Pe)", bound.rate),
        upper_bound("limit of V", claims.limit),
        lower_bound("largest V for which the estimate is bounded", claims.start),
    ];
    if let Some(injectivity) = &bound.injectivity {
        numbers.push(lower_bound("modulus of injectivity of (phi, h)", injectivity.modulus));
    }
    for (k, name) in names.iter().enumerate() {
        numbers.push(upper_bound(&format!("guaranteed limit of the error of {name}"), claims.eventual[k]));
    }
    numbers
}

/// An error with the worst point unless phi^L takes phi(x) back, to the tolerance of the other checks.
pub(crate) fn is_left_inverse(
    study: &Study,
    maps: &KklMaps,
    region: &Region,
    report: &KklReport,
    tolerance: f64,
) -> Result<(), NoObserver> {
    let plant = &study.plant;
    match &report.left_inverse {
        Ok((missed, _)) if *missed <= tolerance => Ok(()),
        Ok((missed, place)) => {
            let (x, t) = (DVector::from_column_slice(&place.state), place.time);
            let y = plant.model.output(t, &x, &DVector::zeros(maps.plant.inputs));
            let back = maps.left_inverse(t, &maps.image(t, &x, &y), &y);
            let half = |k: usize| {
                let (low, high) = region.states()[k];
                if high > low { 0.5 * (high - low) } else { 1.0 }
            };
            let share = |k: usize| (back[k] - x[k]).abs() / half(k);
            let state = (0..x.len()).max_by(|i, j| share(*i).total_cmp(&share(*j))).unwrap_or(0);
            let instant = match plant.model.structure().explicit_time() {
                Some(_) => format!(", t = {}", significant(t, 4)),
                None => String::new(),
            };
            let hypothesis = format!(
                "`left_inverse` is not a left inverse of phi: at {}{instant} it gives {} = {}, an error of {} half-widths of the region, the largest over all sampled states",
                plant.at_state(&place.state),
                plant.states[state],
                significant(back[state], 6),
                significant(*missed, 3)
            );
            let (found, point, missed) = (back[state], place.state.clone(), *missed);
            Err(NoObserver::new(hypothesis)
                .because(Cause::NotLeftInverse { state, found, point, time: t, missed })
                .hint("a `left_inverse` with phi^L(phi(x), h(x)) = x on the whole region"))
        }
        Err(place) => {
            let state = plant.at_state(&place.state);
            Err(NoObserver::new(format!("`left_inverse` has no finite value at {state}, in the region"))
                .because(Cause::UndefinedLeftInverse { point: place.state.clone() })
                .hint("a smaller `region`, in which phi^L(phi(x), h(x)) is defined"))
        }
    }
}

/// What to change of the maps.
pub(crate) fn other_maps(study: &Study, cause: &Cause) -> Option<Advice> {
    let Cause::Kkl(error) = cause else { return None };
    if let (KklError::ResidualUndecided { .. }, Some(row)) = (error, study.plant.model.structure().explicit_time()) {
        let row = study.plant.row(row);
        let maps = format!("other `phi`, `lambda` or `b`, in which t may occur: {row} depends on the time t");
        return Some(Advice::hint(maps).and(Advice::hint("a smaller `region`, its `time` included")));
    }
    let remedy = match error {
        KklError::NotASolution(_) => "other `phi`, `lambda` or `b`: the two sides differ at the point named",
        KklError::ResidualUndecided { .. } => "a smaller `region`, or maps without kinks, jumps and lookup tables",
        KklError::NotHurwitz { eigenvalue, .. } if eigenvalue.re == 0.0 && eigenvalue.im == 0.0 => {
            "the kind kkl-peb: rows of `lambda` that are zero leave a constant, which it estimates"
        }
        KklError::NotHurwitz { .. } | KklError::HurwitzUndecided { .. } => {
            "another `lambda`, or a smaller `region` of the inputs"
        }
        KklError::ReadsItself(_) | KklError::CouplingUndecided(_) => {
            "rows of `b` that use earlier entries of xi only; the linear part belongs into `lambda`"
        }
        KklError::NotInjective(_) | KklError::Indistinct(_) => {
            "a `phi` with more rows, or a smaller `region` on which (phi, h) distinguishes all states"
        }
        KklError::Undefined { .. } => "a smaller `region`, in which plant and maps are defined",
        _ => return None,
    };
    Some(Advice::hint(remedy))
}

/// What was found of phi^L without a proof.
pub(crate) fn measured_left_inverse(report: &KklReport) -> String {
    let missed = report.left_inverse.as_ref().map_or(f64::NAN, |(missed, _)| *missed);
    format!(
        "that phi^L(phi(x), h(x)) = x is measured at {}: the largest error is {} half-widths of the region",
        counted(report.residual.points, "point"),
        significant(missed, 3)
    )
}

/// What was found of (phi, h) without a proof.
pub(crate) fn undecided_injectivity(report: &KklReport) -> String {
    let found = &report.injectivity;
    format!(
        "that (phi, h) is injective on the region is not proved: over {} the smallest ratio |(phi, h)(x) - (phi, h)(z)| / |x - z| is {}",
        counted(found.points, "sampled state"),
        significant(found.smallest_ratio, 3)
    )
}

/// The numbers of all checks.
pub(crate) fn numbers(report: &KklReport) -> Vec<NamedNumber> {
    let KklReport { residual, injectivity, left_inverse, .. } = report;
    let largest = residual.bounds.iter().copied().fold(0.0, f64::max);
    let mut numbers = vec![
        upper_bound("bound of the residual of D phi f = Lambda phi + B", largest),
        number("parts of the region", residual.parts as f64),
        number("smallest ratio of distances under (phi, h)", injectivity.smallest_ratio),
        number("smallest singular value of D(phi, h)", injectivity.smallest_singular_value),
        number("sampled states", injectivity.points as f64),
    ];
    if let Ok((missed, _)) = left_inverse {
        numbers.push(number("largest error of phi^L(phi(x), h(x)) in half-widths of the region", *missed));
    }
    numbers
}

/// What the coupling of B says.
pub(crate) const DECAY: &str = "B leaves the decay of xi - phi(x) to Lambda";

/// The proved conditions: those of the certificate, and those of the maps.
pub(crate) fn all_facts(report: &KklReport, certificate: &Certificate) -> Vec<FactReport> {
    let KklReport { residual, coupling, injectivity, .. } = report;
    let mut all = facts(certificate, &[]);
    // Where phi jumps, its derivative does not tell how it moves.
    if residual.verdict.is_proved() && residual.continuous {
        let bounds: Vec<String> = residual.bounds.iter().map(|bound| at_most(*bound, 3)).collect();
        let words = format!("verified over the region; residual by rows at most {}", bounds.join(", "));
        all.push(FactReport::of_region("D phi f = Lambda phi + B", words, None));
    }
    if coupling.verdict.is_proved() {
        let pairs: Vec<String> = coupling.reads.iter().map(|(i, j)| format!("B{} reads xi{}", i + 1, j + 1)).collect();
        let words = if pairs.is_empty() { "B does not depend on xi".to_owned() } else { pairs.join(", ") };
        let words = format!("verified; {words}");
        all.push(FactReport::of_region(DECAY, words, None));
    }
    if let Verdict::Proved { margin } = injectivity.verdict {
        all.push(FactReport::of_region("(phi, h) is injective", "verified over the region".to_owned(), Some(margin)));
    }
    all
}
