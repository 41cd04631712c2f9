//! The packages outside the workspace (Python, fuzzing, targets, benchmarks) have lock files of their own, which go
//! along with the dependencies of the crates: they are built with `--locked`.

use std::collections::BTreeSet;
use std::fs;
use std::path::Path;

use toml::Spanned;
use toml::de::{DeTable, DeValue};

use crate::pages::root;

fn read(path: &Path) -> String {
    fs::read_to_string(path).unwrap_or_else(|error| panic!("{}: {error}", path.display()))
}

fn parsed(text: &str) -> DeTable<'_> {
    DeTable::parse(text).unwrap().into_inner()
}

fn names(table: Option<&Spanned<DeValue<'_>>>, is_wanted: impl Fn(&DeValue<'_>) -> bool) -> BTreeSet<String> {
    let table = table.and_then(|table| table.get_ref().as_table());
    let wanted = table.into_iter().flatten().filter(|(_, value)| is_wanted(value.get_ref()));
    wanted.map(|(name, _)| name.get_ref().to_string()).collect()
}

/// Names of dependencies that are always there, and of all there may be. Those for some targets and at build time may
/// be.
fn dependencies(manifest: &DeTable<'_>) -> [BTreeSet<String>; 2] {
    let is_optional =
        |value: &DeValue<'_>| value.get("optional").is_some_and(|optional| optional.get_ref().as_bool() == Some(true));
    let always = names(manifest.get("dependencies"), |value| !is_optional(value));
    let mut possible = names(manifest.get("dependencies"), |_| true);
    possible.extend(names(manifest.get("build-dependencies"), |_| true));
    let targets = manifest.get("target").and_then(|targets| targets.get_ref().as_table());
    for (_, target) in targets.into_iter().flatten() {
        possible.extend(names(target.get_ref().get("dependencies"), |_| true));
    }
    [always, possible]
}

#[test]
fn lock_files_outside_the_workspace_have_the_dependencies_of_the_crates() {
    let locks = ["crates/python", "crates/studio/unpack", "firmware", "fuzz", "xtask/bench/linalg", "xtask/bench/sim"];
    let (mut wrong, mut seen) = (Vec::new(), 0);
    for folder in locks {
        let text = read(&root().join(folder).join("Cargo.lock"));
        for package in parsed(&text)["package"].get_ref().as_array().unwrap() {
            let field = |field: &str| package.get_ref().get(field).map(Spanned::get_ref);
            let name = field("name").and_then(DeValue::as_str).unwrap_or_default();
            let manifest =
                root().join("crates").join(name.strip_prefix("luenberger-").unwrap_or("-")).join("Cargo.toml");
            if field("source").is_some() || !manifest.exists() {
                continue;
            }
            seen += 1;
            // A version follows where there are several.
            let first = |text: &Spanned<DeValue<'_>>| text.get_ref().as_str()?.split(' ').next().map(str::to_owned);
            let locked = field("dependencies").and_then(DeValue::as_array);
            let locked: BTreeSet<String> = locked.into_iter().flat_map(|all| all.iter()).filter_map(first).collect();
            let manifest = read(&manifest);
            let [always, possible] = dependencies(&parsed(&manifest));
            let missing: Vec<_> = always.difference(&locked).collect();
            let beyond: Vec<_> = locked.difference(&possible).collect();
            if !(missing.is_empty() && beyond.is_empty()) {
                wrong.push(format!("{folder}: {name} lacks {missing:?} and has {beyond:?} more"));
            }
        }
    }
    assert!(wrong.is_empty() && seen > 30, "{seen} packages, build them without --locked:\n{}", wrong.join("\n"));
}
