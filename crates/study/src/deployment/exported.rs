//! The observer that an export prints: the sampled design of an observer under the names of the study.

use luenberger_export::{Export, ExportError, ExportableObserver, Names, Scalar, names};

use super::SampledDesign;
use crate::study::{ObserverSpec, Study};

/// The export of a sampled design, from the estimate of its study or another one.
///
/// # Errors
/// [`ExportError`]: what cannot be printed in this format.
pub fn exported(
    study: &Study,
    observer: &ObserverSpec,
    design: SampledDesign,
    scalar: Scalar,
    initial: Option<&[f64]>,
) -> Result<Export, ExportError> {
    let of_states = initial.unwrap_or_default();
    // Behind the states are those of disturbances.
    let mut initial = design.initial(observer);
    initial.splice(..of_states.len().min(initial.len()), of_states.iter().copied());
    let mut more = observer.kind.estimated_disturbances();
    if let SampledDesign::Interval(interval) = &design {
        initial = interval.start(scalar, &initial);
        more = interval.names(&study.plant.states);
    }
    let names = if let SampledDesign::Nonlinear(step) = &design { step.names.clone() } else { None };
    let update = design.update_gain(observer).cloned();
    let exportable = match design {
        SampledDesign::Linear(design) => ExportableObserver::Linear(design.observer.clone()),
        SampledDesign::Cubic(design) => ExportableObserver::Cubic(design.observer.clone()),
        SampledDesign::Varying(design) => ExportableObserver::varying(&design.observer)
            .map_err(|error| ExportError::Rounded { format: scalar.name(), error })?,
        SampledDesign::Nonlinear(step) => step.observer,
        SampledDesign::Interval(design) => ExportableObserver::Step(design.program(scalar)?),
    };
    let plant = &study.plant;
    let states = names.unwrap_or_else(|| plant.states.iter().cloned().chain(more).collect());
    let columns = Names {
        units: plant.units_of(&states),
        input_units: plant.units_of(&plant.inputs),
        output_units: plant.units_of(&plant.outputs),
        states,
        inputs: plant.inputs.clone(),
        outputs: plant.outputs.clone(),
        time_unit: plant.time_unit.clone().unwrap_or_default(),
    };
    let export = Export::new(&names::identifier(&observer.name), exportable, scalar, &initial, columns)?;
    match update {
        // Its gains are not those of a Kalman filter.
        Some(k) if observer.kind.whole_gain().is_none() => {
            export.with_update(&k).map(|export| export.titled("Reduced-order observer in filter form"))
        }
        Some(k) => export.with_update(&k),
        None => Ok(export),
    }
}
