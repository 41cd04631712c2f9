//! The page of the kinds of observers is that of their registry. `UPDATE=1` writes it.

use luenberger_study::kinds::{Declaration, Tuning, registry};
use luenberger_study::study::PlantClass;

use crate::pages::root;

const HEAD: &str = "# The kinds of observers

What a study can ask for, `kind = \"..\"` in an `[[observer]]`; `luenberger new --list` prints the same. The keys of a kind
are in `study.schema.json`, which editors use, and in its messages. Written from the declarations of the kinds
(`UPDATE=1 cargo test -p luenberger-tests kinds_page`).

- *plants*: a kind for linear plants is for others at an operating point where that is said, as the observer of the
  linearisation in deviations from it. A kind for any plant may have further conditions, which its first sentence names.
- *time*: of the plants. In continuous time an observer is exported as a step for samples all the same.
- *u in y*: whether an output may depend on an input.
- *advised*: whether `luenberger advise` tunes it by a rule of its own. Kinds with maps that are derived by hand are
  ranked where the study has one.

";

fn row(kind: &Declaration) -> String {
    let Declaration { name, about, source, plant, tuning, .. } = kind;
    let plants = match plant {
        PlantClass::Linear(_) => "linear",
        PlantClass::AtPoint(_) => "linear, others at an operating point",
        PlantClass::Nonlinear(_) => "any",
    };
    let time = if plant.time().discrete { "continuous, discrete" } else { "continuous" };
    let feedthrough = if plant.time().feedthrough { "yes" } else { "no" };
    let advised = if matches!(tuning, Tuning::Rules(_)) { "yes" } else { "no" };
    let plain = |text: &str| text.replace('|', "\\|");
    format!("| `{name}` | {} | {plants} | {time} | {feedthrough} | {advised} | {} |\n", plain(about), plain(source))
}

#[test]
fn the_page_of_the_kinds_is_that_of_their_registry() {
    let table = "| kind | observer | plants | time | u in y | advised | from |\n|---|---|---|---|---|---|---|\n";
    let page = format!("{HEAD}{table}{}", registry().into_iter().map(row).collect::<String>());
    let path = root().join("docs/kinds.md");
    if std::env::var_os("UPDATE").is_some() {
        std::fs::write(&path, &page).unwrap();
    }
    let found = std::fs::read_to_string(&path).unwrap_or_default();
    assert!(found == page, "docs/kinds.md is not that of the registry: run with UPDATE=1");
}
