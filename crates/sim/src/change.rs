//! Changes of the plant during a run: new parameters or equations from a given time on, and jumps of the state.
//!
//! The integration stops at the time and goes on with the new plant, so that no step spans it. A plant in discrete time
//! changes at its first step at or after the time.

use std::sync::Arc;

use luenberger_plants::Plant;

use crate::erased::{AnyPlant, Erased};
use crate::error::{SimError, check};

/// A change of the plant at a given time. The observers keep their model.
///
/// ```
/// use luenberger_plants::StateSpace;
/// use luenberger_sim::{Change, Scenario};
/// use nalgebra::dmatrix;
/// // x' = -x, from t = 1 on x' = -3 x, and at t = 2 it is pushed by 1.
/// let of = |rate: f64| StateSpace::new(dmatrix![-rate], nalgebra::DMatrix::zeros(1, 0), dmatrix![1.0]);
/// let run = Scenario::new(of(1.0)?)
///     .initial_state(&[1.0])
///     .change(Change::at(1.0).plant(of(3.0)?))
///     .change(Change::at(2.0).jump(&[1.0]))
///     .until(3.0, 4)
///     .run()?;
/// let pushed = (-4f64).exp() + 1.0;
/// assert!((run.x[(1, 0)] - (-1f64).exp()).abs() < 1e-10 && (run.x[(2, 0)] - pushed).abs() < 1e-10);
/// assert!((run.x[(3, 0)] - pushed * (-3f64).exp()).abs() < 1e-10);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug)]
pub struct Change<'a> {
    pub(crate) time: f64,
    pub(crate) plant: Option<Arc<dyn AnyPlant + 'a>>,
    pub(crate) jump: Option<Vec<f64>>,
}

impl<'a> Change<'a> {
    /// A change at `time`, after the start of the run.
    pub fn at(time: f64) -> Self {
        Self { time, plant: None, jump: None }
    }

    /// The plant from this time on, with the same numbers of states, inputs and outputs.
    #[must_use]
    pub fn plant(mut self, plant: impl Plant<f64> + Send + Sync + 'a) -> Self {
        self.plant = Some(Arc::new(Erased(plant)));
        self
    }

    /// Adds `by` (n entries) to the state of the plant at this time.
    #[must_use]
    pub fn jump(mut self, by: &[f64]) -> Self {
        self.jump = Some(by.to_vec());
        self
    }

    pub(crate) fn check(&self, start: f64, plant: &dyn AnyPlant) -> Result<(), SimError> {
        if !(self.time.is_finite() && self.time > start) {
            return Err(SimError::ChangeTime { time: self.time, start });
        }
        let size = plant.dimensions();
        if let Some(plant) = &self.plant {
            plant.check()?;
            let found = plant.dimensions();
            for (what, expected, found) in [
                ("state", size.states, found.states),
                ("input", size.inputs, found.inputs),
                ("output", size.outputs, found.outputs),
            ] {
                if expected != found {
                    let what = format!("the {what} of the plant from t = {} on", self.time);
                    return Err(SimError::Length { what, expected, found });
                }
            }
        }
        match &self.jump {
            Some(jump) => check(&format!("the jump at t = {}", self.time), jump, size.states),
            None => Ok(()),
        }
    }
}
