//! Bounds of the magnitudes in operation, from the simulation of a study.

use nalgebra::DMatrix;

use crate::study::{ObserverSpec, Study};
use crate::trajectory;

/// Bounds of operation relative to the magnitudes in the simulation.
pub(crate) const MARGIN: f64 = 1.2;

/// Half of the range of each state of the plant along the study's simulation, by which bounds of errors are judged: the
/// error of the best constant estimate. Nothing without a simulation, and with feedback, where an observer is in the
/// loop.
pub(crate) fn half_ranges(study: &Study) -> Vec<f64> {
    let run = study.simulation.as_ref().and_then(|simulation| trajectory::of_plant(study, simulation));
    run.map_or_else(Vec::new, |run| run.x.column_iter().map(|x| 0.5 * (x.max() - x.min())).collect())
}

/// Bounds of |x| and |u| in operation, for the widths that an interval observer states: 1.2 times those of the study's
/// simulation; without one, those of the box of the first state, and 1.
pub(crate) fn largest(study: &Study, observer: &ObserverSpec) -> (Vec<f64>, Vec<f64>) {
    let first: Vec<f64> = match observer.kind.first_bounds() {
        Some(bounds) => bounds.iter().zip(&observer.initial).map(|(w, x)| x.abs() + w).collect(),
        None => observer.initial.clone(),
    };
    let inputs = vec![1.0; study.plant.inputs.len()];
    let Some(run) = study.simulation.as_ref().and_then(|simulation| trajectory::of_plant(study, simulation)) else {
        return (first, inputs);
    };
    let of = |m: &DMatrix<f64>| m.column_iter().map(|column| MARGIN * column.amax()).collect::<Vec<_>>();
    (of(&run.x).into_iter().zip(first).map(|(x, first): (f64, f64)| x.max(first)).collect(), of(&run.u))
}
