//! What the filters with a covariance share, those that are updated at samples.

use luenberger_observers::NoiseModel;
use nalgebra::{DMatrix, DVector, Dyn};

use super::keys::{PERIOD, V, W};
use crate::model::PlantModel;
use crate::study::Estimated;

crate::keys! { |size|
    /// The noises and the period of a filter with a covariance.
    #[derive(Debug, Clone, PartialEq)]
    pub struct Filter {
        /// W, n x n.
        w: DMatrix<f64>[n, n] as &W,
        /// V, p x p.
        v: DMatrix<f64>[p, p] as &V,
        /// Covariance of the initial error, n x n (default: the identity).
        p0: DMatrix<f64>[n, n] as Weight = DMatrix::identity(size.states, size.states),
        /// The sampling period.
        period: f64 as &PERIOD,
        /// Runge-Kutta steps per sampling period in exported code (default: as many as their error needs). Elsewhere
        /// the prediction controls its error.
        substeps: Option<usize> as Count(1),
    }
}

impl Filter {
    /// Noise of intensity W and covariance V, with P(0) = I.
    pub fn new(w: DMatrix<f64>, v: DMatrix<f64>, period: f64) -> Self {
        Self { p0: DMatrix::identity(w.nrows(), w.nrows()), w, v, period, substeps: None }
    }

    /// The same with these parameters as further states, whose errors and random walks are independent of the others.
    pub(super) fn with_parameters(&self, parameters: &[Estimated]) -> Self {
        let n = self.w.nrows();
        let extended = |matrix: &DMatrix<f64>, of: fn(&Estimated) -> f64| {
            DMatrix::from_fn(n + parameters.len(), n + parameters.len(), |i, j| match (i.checked_sub(n), j) {
                (None, j) if j < n => matrix[(i, j)],
                (Some(k), j) if i == j => of(&parameters[k]),
                _ => 0.0,
            })
        };
        Self { w: extended(&self.w, |one| one.w), p0: extended(&self.p0, |one| one.p0), ..self.clone() }
    }

    /// W, V and P(0).
    pub(super) fn noises(&self) -> NoiseModel<f64, Dyn, Dyn> {
        NoiseModel { w: self.w.clone(), v: self.v.clone(), p0: self.p0.clone() }
    }
}

/// The outputs whose innovations are wrapped, as a sentence.
pub(super) fn wrapped(plant: &PlantModel) -> String {
    let angles: Vec<&str> =
        plant.outputs.iter().filter(|name| plant.turns.contains_key(*name)).map(String::as_str).collect();
    if angles.is_empty() {
        return String::new();
    }
    format!(" Innovations of {} are angles, within half a turn.", angles.join(", "))
}

/// The full turns of outputs and states, if some of them are angles. In continuous time a state goes on beyond a turn,
/// and its images need no turn.
pub(super) fn turns(plant: &PlantModel) -> Option<(DVector<f64>, DVector<f64>)> {
    let states = plant.turns_of(&plant.states).filter(|_| plant.dt.is_some());
    let outputs = plant.turns_of(&plant.outputs);
    let column = |turns: Option<Vec<f64>>, names: &[String]| {
        turns.map_or_else(|| DVector::zeros(names.len()), DVector::from_vec)
    };
    (states.is_some() || outputs.is_some()).then(|| (column(outputs, &plant.outputs), column(states, &plant.states)))
}

/// Evaluations of a prediction, about, of a plant that is not stiff.
pub(super) const STAGES: f64 = 16.0;
