//! Progress of a design, and its cancellation.

use std::ops::ControlFlow;

use crate::numerical_kkl::error::NumericalKklError;

/// How far a design has come.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Progress {
    /// The stage.
    pub stage: &'static str,
    /// Steps of it that are done.
    pub done: usize,
    /// Steps that it has.
    pub total: usize,
}

/// Callback for progress; its return value decides whether the design continues.
pub(crate) type Listener<'a> = dyn FnMut(Progress) -> ControlFlow<()> + 'a;

impl Progress {
    /// Calls the listener; its break is an error, which ends the computation.
    pub(crate) fn tell(self, listener: &mut Listener<'_>) -> Result<(), NumericalKklError> {
        let Self { stage, done, total } = self;
        match listener(self) {
            ControlFlow::Continue(()) => Ok(()),
            ControlFlow::Break(()) => Err(NumericalKklError::Stopped { stage, done, total }),
        }
    }
}
