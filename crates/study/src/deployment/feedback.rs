//! The feedback of a study's observer: its gain, and the magnitudes in the loop.

use nalgebra::{DMatrix, DVector};

use super::SampledDesign;
use crate::operation::MARGIN;
use crate::results::NoObserver;
use crate::signal::Input;
use crate::study::{ObserverSpec, Simulation, Study};

/// The gain K with which the study feeds back the estimate of an observer.
///
/// # Errors
/// [`NoObserver`] if the study feeds back another estimate or none.
pub fn gain<'a>(study: &'a Study, observer: &ObserverSpec) -> Result<&'a DMatrix<f64>, NoObserver> {
    let failure = |hypothesis: String| {
        NoObserver::new(hypothesis)
            .at(observer.place.line)
            .hint(format!("feedback = {{ k = [[..]], observer = \"{}\" }} in [input]", observer.name))
    };
    let has_bounds = observer.kind.first_bounds().is_some();
    if has_bounds || !observer.kind.estimated_disturbances().is_empty() {
        let hypothesis = if has_bounds {
            "an interval observer has no export with its feedback"
        } else {
            "an observer that estimates disturbances too has no export with its feedback"
        };
        let instead = "without --feedback: the first states of the exported observer are xhat of u = r - K xhat";
        return Err(NoObserver::new(hypothesis).at(observer.place.line).hint(instead));
    }
    match &study.input {
        Input::Feedback { observer: fed, gain, .. } if *fed == observer.name => Ok(gain),
        Input::Feedback { observer: fed, .. } => Err(failure(format!("the study feeds back the estimate of {fed}"))),
        _ => Err(failure("the study has no feedback".to_owned())),
    }
}

/// The magnitudes of the loop at its samples in the study's simulation, without noise: states and inputs, with the
/// margin of the bounds of operation. None if they are not finite.
pub(super) fn magnitudes(
    study: &Study,
    simulation: &Simulation,
    observer: &ObserverSpec,
    design: &SampledDesign,
) -> Option<(Vec<f64>, Vec<f64>)> {
    let k = gain(study, observer).ok()?;
    let m = design.matrices()?;
    let mut x = DVector::from_column_slice(&simulation.x0);
    let mut xhat = DVector::from_column_slice(&observer.initial);
    let (mut states, mut inputs) = (DVector::zeros(x.len()), DVector::zeros(k.nrows()));
    let samples = (simulation.duration / m.period + 1e-9).floor().min(1e7) as usize;
    for sample in 0..=samples {
        let mut r = vec![0.0; k.nrows()];
        if let Some(reference) = study.input.program() {
            reference.at(sample as f64 * m.period, &mut r);
        }
        let fed = match design.update_gain(observer) {
            Some(update) => &xhat + update * (m.c * (&x - &xhat)),
            None => xhat.clone(),
        };
        let u = DVector::from_vec(r) - k * fed;
        states = states.sup(&x.abs());
        inputs = inputs.sup(&u.abs());
        let y = m.c * &x + m.d.map_or_else(|| DVector::zeros(m.c.nrows()), |d| d * &u);
        design.step(&mut xhat, &u, &y);
        x = m.a * x + m.b * u;
    }
    let largest = |column: DVector<f64>| column.iter().map(|x| MARGIN * x).collect::<Vec<f64>>();
    let (states, inputs) = (largest(states), largest(inputs));
    states.iter().chain(&inputs).all(|x| x.is_finite()).then_some((states, inputs))
}
