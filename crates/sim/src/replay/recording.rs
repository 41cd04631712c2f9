//! What was measured: inputs and outputs at the times of a log.

use luenberger_plants::Dimensions;
use nalgebra::DMatrix;

use crate::error::SimError;
use crate::samples::{Between, Samples};

/// Inputs and outputs that were recorded at common times.
#[derive(Clone, Debug, PartialEq)]
pub struct Recording {
    inputs: Samples,
    outputs: Samples,
}

impl Recording {
    /// The recording of the inputs `u` (N x m) and the outputs `y` (N x p) at N increasing times.
    ///
    /// Between the samples inputs are held and outputs are on straight lines. An input is what a digital controller has
    /// sent, and it was held; an output is a sample of something continuous, and held it would be late by half a period
    /// on average, an error of the order of the period where the straight line leaves one of its square. The line looks
    /// ahead to the next sample, which a recording permits and a target does not.
    ///
    /// # Errors
    /// As [`Samples::new`].
    pub fn new(t: Vec<f64>, u: DMatrix<f64>, y: DMatrix<f64>) -> Result<Self, SimError> {
        Ok(Self { inputs: Samples::new(t.clone(), u, Between::Hold)?, outputs: Samples::new(t, y, Between::Line)? })
    }

    /// The same with other rules for what is between the samples.
    #[must_use]
    pub fn between(self, inputs: Between, outputs: Between) -> Self {
        Self { inputs: self.inputs.with(inputs), outputs: self.outputs.with(outputs) }
    }

    /// The times.
    pub fn times(&self) -> &[f64] {
        self.inputs.times()
    }

    /// The inputs.
    pub fn inputs(&self) -> &Samples {
        &self.inputs
    }

    /// The outputs.
    pub fn outputs(&self) -> &Samples {
        &self.outputs
    }

    /// Checks that it is one of a plant of this size.
    pub(super) fn check(&self, size: Dimensions) -> Result<(), SimError> {
        for (what, expected, samples) in [
            ("a recording, in inputs,", size.inputs, &self.inputs),
            ("a recording, in outputs,", size.outputs, &self.outputs),
        ] {
            let found = samples.values().ncols();
            if found != expected {
                return Err(SimError::Length { what: what.to_owned(), expected, found });
            }
        }
        Ok(())
    }
}
