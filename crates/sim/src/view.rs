//! States, inputs, outputs and estimates at one instant of a simulation.

/// Plant and observers at one instant, as integrands and control laws see them.
#[derive(Clone, Copy, Debug)]
pub struct View<'v> {
    /// Time.
    pub t: f64,
    /// State of the plant.
    pub x: &'v [f64],
    /// Input of the plant.
    pub u: &'v [f64],
    /// Output of the plant, without noise.
    pub y: &'v [f64],
    pub(crate) names: &'v [String],
    pub(crate) estimates: &'v [Vec<f64>],
    pub(crate) errors: &'v [Vec<f64>],
}

impl<'v> View<'v> {
    /// The estimate of the observer of that name.
    pub fn estimate(&self, observer: &str) -> Option<&'v [f64]> {
        self.position(observer).map(|k| self.estimates[k].as_slice())
    }

    /// The error `e = x - xhat` of the observer of that name.
    pub fn error(&self, observer: &str) -> Option<&'v [f64]> {
        self.position(observer).map(|k| self.errors[k].as_slice())
    }

    fn position(&self, observer: &str) -> Option<usize> {
        self.names.iter().position(|name| name == observer)
    }
}
