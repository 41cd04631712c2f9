//! The maps of the observers of the [KKL+PEB] paper as expressions of a study: phi, Lambda, B and phi^L, regressions,
//! beta.
//!
//! The right-hand sides are those of `luenberger-observers`; here its traits of maps are implemented by expressions,
//! over every scalar, so that the checks of `luenberger-design` take the maps that run.
//!
//! | file | subject |
//! |---|---|
//! | `high_gain` | a high-gain observer with given maps |
//! | `immersion` | beta, phi and phi^L of an immersion-and-invariance observer |
//! | `names` | what the variables of each map are called |
//! | `kkl` | phi, Lambda, B and phi^L |
//! | `bound` | the guaranteed bound of the estimation error |
//! | `regression` | s, g and m, and what theta adds to xi; estimators |

mod bound;
pub(crate) mod high_gain;
mod immersion;
mod kkl;
mod names;
mod regression;

pub(crate) use bound::{kkl_error_bound, left_inverse_defect};
pub use high_gain::HighGainMaps;
pub use immersion::{ImmersionMaps, ImmersionSpec};
pub use kkl::{KklMaps, KklMapsSpec};
pub(crate) use names::MapNames;
pub use regression::{Estimator, PebSpec, RegressionMaps, ResetSpec};
