//! The commands on study files: `new`, and the steps `run`, `observe`, `design`, `certify`, `simulate`, `compare`,
//! `sweep`; and `advise`, `tune`, `export` and `stream`.

mod advise;
mod cost;
mod export;
mod file;
mod interrupt;
mod new;
mod step;
mod stream;
mod sweep;
mod sweep_script;
mod text_report;
mod tune;

pub(crate) use advise::advise;
pub(crate) use export::export;
pub(crate) use new::new;
pub(crate) use step::{run, step};
pub(crate) use stream::stream;
pub(crate) use sweep::sweep;
pub(crate) use tune::tune;
