//! Warnings that qualify the results.

use luenberger_proof::wording::significant;

use crate::results::Results;
use crate::results::report::eigenvalue;
use crate::signal::Input;
use crate::study::{ObserverKind, Study};

/// Modes with a margin below this are weakly observable.
const HARDLY: f64 = 1e-6;

pub(super) fn of_designs(study: &Study, results: &Results) -> Vec<String> {
    let mut warnings = Vec::new();
    for point in results.observability.iter().flat_map(|report| &report.points) {
        let hidden = |margin: f64| point.hidden.iter().any(|mode| mode.margin >= margin);
        for mode in point.modes.iter().filter(|mode| mode.margin < HARDLY && !hidden(mode.margin)) {
            warnings.push(format!(
                "the outputs hardly see the mode {} along {} (margin {}): a small change of the plant hides it",
                eigenvalue(mode.eigenvalue),
                mode.words,
                significant(mode.margin, 2)
            ));
        }
    }
    let driven = !matches!(study.input, Input::Zero);
    if let (Some(simulation), true) = (&study.simulation, driven) {
        for wish in &study.observers {
            let period = match &wish.kind {
                ObserverKind::SampledCubic { period, .. } | ObserverKind::ExtendedKalman { period, .. } => *period,
                _ => continue,
            };
            if simulation.hold != Some(period) {
                warnings.push(format!(
                    "{} takes the input as held over its period {period}, and simulation.hold is {}: its error does not tend to 0",
                    wish.name,
                    simulation.hold.map_or_else(|| "not there".to_owned(), |hold| hold.to_string())
                ));
            }
        }
    }
    warnings
}
