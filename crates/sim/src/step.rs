//! One step of a method: what it has to keep, its outcome, and the solution within it.

/// What a step has to keep.
#[derive(Clone, Copy)]
pub(crate) struct Tolerance {
    pub(crate) rtol: f64,
    pub(crate) atol: f64,
}

/// Outcome of an attempted step.
pub(crate) enum Attempt {
    Accepted,
    Rejected,
}

/// The solution within the last step of a method.
pub(crate) trait Interpolant {
    /// Writes the solution at `t`.
    fn interpolate(&self, t: f64, value: &mut [f64]);
}

/// An accepted step.
pub(crate) struct Accepted<'m> {
    pub(crate) start: f64,
    pub(crate) end: f64,
    pub(crate) solution: &'m dyn Interpolant,
}

impl Accepted<'_> {
    /// Writes the solution at `t` within the step.
    #[inline]
    pub(crate) fn at(&self, t: f64, value: &mut [f64]) {
        self.solution.interpolate(t, value);
    }
}
