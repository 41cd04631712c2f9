//! Whether a run or a log stays in the region for which an observer was designed.

use luenberger_design::Region;
use nalgebra::DMatrix;

use super::Member;
use super::simulate::Run;
use crate::study::{ObserverKind, Study};

/// Bounds of the states, and of the inputs if there are any.
struct Bounds<'a> {
    states: &'a [(f64, f64)],
    inputs: Option<&'a [(f64, f64)]>,
    /// Whether it bounds the validity of a proof; otherwise that of a fit.
    certified: bool,
}

fn certified(region: &Region) -> Bounds<'_> {
    Bounds { states: region.states(), inputs: region.input_bounds(), certified: true }
}

/// The region of an observer's design, if it is bounded somewhere.
fn bounds(kind: &ObserverKind) -> Option<Bounds<'_>> {
    let bounds = match kind {
        ObserverKind::Lpv { region, .. }
        | ObserverKind::MeanValue { region, .. }
        | ObserverKind::Lipschitz { region, split: None, .. } => certified(region),
        ObserverKind::KklNumerical(kkl) => Bounds { states: &kkl.domain, inputs: None, certified: false },
        _ => return None,
    };
    let all = bounds.states.iter().chain(bounds.inputs.unwrap_or(&[]));
    all.clone().any(|(low, high)| low.is_finite() || high.is_finite()).then_some(bounds)
}

/// In how many rows something is outside, and what is furthest outside first.
struct Outside {
    rows: usize,
    first: (usize, usize),
}

/// The rows of `values` outside the bounds; a value that is not known is not outside.
fn outside(values: &DMatrix<f64>, bounds: &[(f64, f64)]) -> Option<Outside> {
    let column = |k: usize| {
        (0..values.ncols().min(bounds.len())).find(|&i| values[(k, i)] < bounds[i].0 || values[(k, i)] > bounds[i].1)
    };
    let found: Vec<(usize, usize)> = (0..values.nrows()).filter_map(|k| Some((k, column(k)?))).collect();
    Some(Outside { rows: found.len(), first: *found.first()? })
}

/// Warnings of the observers whose run, or log, leaves the region of their design.
pub(super) fn warnings(study: &Study, runs: &[(&Member<'_>, &Run)]) -> Vec<String> {
    let mut warnings = Vec::new();
    for (member, run) in runs {
        let (name, Some(bounds)) = (&member.wish.name, bounds(&member.wish.kind)) else { continue };
        let plant = &study.plant;
        let states = (bounds.states, &plant.states);
        let parts = [
            ("inputs", Some(&run.u), bounds.inputs.map(|inputs| (inputs, &plant.inputs))),
            ("true states", Some(&run.x), Some(states)),
            ("estimates", run.estimate.as_ref(), Some(states)),
        ];
        for (what, values, of) in parts {
            let (Some(values), Some((bounds_of, names))) = (values, of) else { continue };
            let Some(Outside { rows, first: (k, i) }) = outside(values, bounds_of) else { continue };
            let number = |x: f64| luenberger_proof::wording::significant(x, 5);
            let valid = if bounds.certified { "Guarantee not valid" } else { "Fit not valid" };
            let (low, high) = bounds_of[i];
            warnings.push(format!(
                "{name}: {valid} outside the design region: {rows} of {} rows of the {what}, first at t = {}, where {} = {} (region {} to {})",
                values.nrows(),
                number(run.t[k]),
                names[i],
                number(values[(k, i)]),
                number(low),
                number(high)
            ));
        }
    }
    warnings
}
