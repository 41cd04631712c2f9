//! Studies in TOML: read, designed, executed, or refused with their mistakes.

use std::path::{Path, PathBuf};
use std::sync::atomic::AtomicBool;

use luenberger_export::ExportableObserver;
use luenberger_export::extension::SampledExtension;
use luenberger_study::deployment::{Sampled, SampledDesign};
use luenberger_study::design::{Designed, NoObserver, design};
use luenberger_study::diagnostic::Located;
use luenberger_study::kinds::{Declaration, named, registry};
use luenberger_study::{Format, Results, RunOptions, Step, Study, StudyError, execute};

use crate::messages;

pub(crate) fn read(text: &str) -> Result<Study, StudyError> {
    Study::from_text("study.toml", text, Format::Toml, ".".as_ref())
}

#[track_caller]
pub(crate) fn study(text: &str) -> Study {
    study_in(".".as_ref(), text)
}

/// The study whose tables are in `folder`.
#[track_caller]
pub(crate) fn study_in(folder: &Path, text: &str) -> Study {
    Study::from_text("study.toml", text, Format::Toml, folder).unwrap_or_else(|error| panic!("{error}"))
}

/// The kinds that have all of these keys, in the order of the registry.
pub(crate) fn kinds_with(keys: &[&str]) -> Vec<&'static str> {
    let has = |kind: &Declaration, key: &str| kind.keys.iter().copied().flatten().any(|known| known.name == key);
    let all = registry().into_iter();
    all.filter(|kind| keys.iter().all(|key| has(kind, key))).map(|kind| kind.name).collect()
}

/// The kinds of filters with a covariance, which are updated at samples and need no more than w, v and the period.
pub(crate) fn filters() -> Vec<&'static str> {
    needing_noises(kinds_with(&["w", "v", "p0", "period", "substeps"]))
}

/// Those of these kinds that need no more than w, v and the period.
pub(crate) fn needing_noises(kinds: Vec<&'static str>) -> Vec<&'static str> {
    let needs = |kind: &str| {
        let keys = named(kind).into_iter().flat_map(|kind| kind.keys.iter().copied().flatten());
        keys.filter(|key| key.required).any(|key| !["w", "v", "period"].contains(&key.name))
    };
    kinds.into_iter().filter(|kind| !needs(kind)).collect()
}

/// The first observer of a study.
pub(crate) fn designed(study: &Study) -> Result<Designed, NoObserver> {
    design(study, &study.observers[0], &AtomicBool::new(false))
}

/// The step of an observer with given maps.
#[track_caller]
pub(crate) fn extension(sampled: &Sampled) -> &SampledExtension<f64> {
    match &sampled.design {
        SampledDesign::Nonlinear(step) => match &step.observer {
            ExportableObserver::Extension(extension) => extension,
            other => panic!("{other:?}"),
        },
        other => panic!("{other:?}"),
    }
}

#[track_caller]
pub(crate) fn executed(text: &str, step: Step) -> Results {
    execute(&study(text), step, &RunOptions::default()).unwrap_or_else(|error| panic!("{error}"))
}

/// The errors of an observer at the end of the simulation, one for each state.
#[track_caller]
pub(crate) fn last_errors(results: &Results, observer: &str) -> Vec<f64> {
    let rows = &results.simulation.as_ref().unwrap().rows;
    let row = rows.iter().find(|row| row.observer == observer).unwrap();
    row.merits.as_ref().unwrap_or_else(|| panic!("{row:?}")).states.iter().map(|state| state.last).collect()
}

/// The mistakes of a text that is no study. The tests of `messages` note them.
#[track_caller]
pub(crate) fn mistakes(text: &str) -> Vec<Located> {
    mistakes_of(text, read(text))
}

/// The first of them.
#[track_caller]
pub(crate) fn mistake(text: &str) -> Located {
    mistakes(text).swap_remove(0)
}

/// Those that reading `text` has found.
#[track_caller]
pub(crate) fn mistakes_of(text: &str, read: Result<Study, StudyError>) -> Vec<Located> {
    match read {
        Err(StudyError::File(diagnostics)) => {
            let located = diagnostics.located();
            located.iter().for_each(messages::mistake);
            located
        }
        Err(error) => panic!("{error}"),
        Ok(_) => panic!("the mistake was not found in\n{text}"),
    }
}

/// An empty folder of this name.
pub(crate) fn scratch(name: &str) -> PathBuf {
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join(name);
    _ = std::fs::remove_dir_all(&folder);
    std::fs::create_dir_all(&folder).unwrap();
    folder
}
