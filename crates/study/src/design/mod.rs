//! Design of each `[[observer]]`, or the reason why it has none.

mod alternative;

use std::sync::atomic::AtomicBool;

use luenberger_clock::Instant;

pub use luenberger_export::moving_horizon::LONGEST_WINDOW;

pub use crate::designed::{Designed, Innovation, Runnable, SteppedFilter};
use crate::kinds;
use crate::limits::Limits;
pub use crate::results::{Advice, Cause, NoObserver};
use crate::study::{ObserverSpec, Study};
use crate::synthesis::Plan;
pub use crate::synthesis::kkl_maps::candidate;

/// The design of one observer of a study; of one that is refused, the alternatives that have a design. A design of
/// kind `kkl-numerical` takes minutes; it checks `cancel` continuously and stops once it is true.
///
/// # Errors
/// [`NoObserver`].
pub fn design(study: &Study, requested: &ObserverSpec, cancel: &AtomicBool) -> Result<Designed, NoObserver> {
    design_until(study, requested, cancel, None)
}

/// As [`design`], stopped at the instant `end` if there is one: matrix inequalities are solved no further, and a design
/// that fails for it is [`Cause::Interrupted`].
///
/// # Errors
/// [`NoObserver`].
pub fn design_until(
    study: &Study,
    requested: &ObserverSpec,
    cancel: &AtomicBool,
    end: Option<Instant>,
) -> Result<Designed, NoObserver> {
    design_with_alternatives(study, requested, (cancel, end), Limits::default().alternatives)
}

/// As [`design_until`], with so many seconds for the alternatives.
pub(crate) fn design_with_alternatives(
    study: &Study,
    requested: &ObserverSpec,
    (cancel, end): (&AtomicBool, Option<Instant>),
    seconds: f64,
) -> Result<Designed, NoObserver> {
    attempt(study, requested, cancel, end)
        .map_err(|none| alternative::tried(study, requested, none, (cancel, end), seconds))
}

/// As [`design_until`], without the alternatives of a refusal, which have to be designed themselves.
pub(crate) fn attempt(
    study: &Study,
    requested: &ObserverSpec,
    cancel: &AtomicBool,
    end: Option<Instant>,
) -> Result<Designed, NoObserver> {
    let designed = study.plant.names().with(|| kinds::design(&Plan { study, requested, cancel, end }));
    match designed {
        Err(_) if end.is_some_and(|end| Instant::now() >= end) => Err(NoObserver::interrupted()),
        designed => designed,
    }
}
