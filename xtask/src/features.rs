//! Checks that `--package X` builds its dependencies with the same features as `--workspace`, so that nothing is
//! compiled twice: see `tests/features/Cargo.toml`.

use std::collections::{BTreeMap, BTreeSet};

use crate::step::{FEATURES, Failure, cargo, packages};

/// The builds of each package: its name and version, and its features. One package may be built in several ways.
type Built = BTreeMap<String, BTreeSet<String>>;

/// Members that are built with fewer features alone, on purpose: live for the module of reports without the theorems
/// that it does not verify, lmi without its second solver.
const LEAN: [&str; 2] = ["luenberger-live", "luenberger-lmi"];

/// The members whose programs are built here, without their tests: see [`build`](crate::step::build).
const PROGRAMS: [&str; 2] = ["luenberger-cli", "luenberger-reproduce"];

/// What a program is built from, and what tests are.
const PROGRAM: &str = "normal,build";
const TESTS: &str = "normal,build,dev";

/// Fails with the features that are missing in `tests/features/Cargo.toml`.
pub(crate) fn check() -> Result<(), Failure> {
    let packages = packages()?;
    let members = packages.as_array().into_iter().flatten().filter_map(|package| package["name"].as_str());
    let whole = built(&["--workspace"], TESTS)?;
    let mut missing: BTreeMap<String, Vec<&str>> = BTreeMap::new();
    // This program has to start where the workspace does not compile, and shares nothing with it.
    let members = members.filter(|&member| member != env!("CARGO_PKG_NAME") && !LEAN.contains(&member));
    let tests = members.map(|member| (member, built(&["--package", member], TESTS)));
    let programs = PROGRAMS.map(|member| (member, built(&["--package", FEATURES, "--package", member], PROGRAM)));
    for (member, built) in tests.chain(programs) {
        for (package, ways) in built? {
            for features in ways.difference(whole.get(&package).unwrap_or(&BTreeSet::new())) {
                missing.entry(lacking(&package, features, &whole)).or_default().push(member);
            }
        }
    }
    if missing.is_empty() {
        return Ok(());
    }
    let lines: Vec<_> = missing.iter().map(|(what, members)| format!("\n  {what}: {}", members.join(", "))).collect();
    Err(Failure::Features { missing: lines.concat() })
}

/// The package with the features that the workspace has and `features` lacks.
fn lacking(package: &str, features: &str, whole: &Built) -> String {
    let found: BTreeSet<&str> = features.split(',').collect();
    let lacking = whole.get(package).into_iter().flatten().map(|all| all.split(',').filter(|f| !found.contains(f)));
    let least = lacking.map(Iterator::collect::<Vec<_>>).min_by_key(Vec::len).unwrap_or_default();
    format!("{package} without {}", least.join(","))
}

/// The packages and their features as built for a selection of packages.
fn built(selection: &[&str], edges: &str) -> Result<Built, Failure> {
    let tree = cargo(&["tree", "--edges", edges, "--prefix", "none", "--format", "{p}|{f}"])
        .arguments(selection)
        .quiet_output("the dependencies")?;
    let mut built = Built::new();
    for line in tree.lines() {
        let Some((package, features)) = line.trim_end_matches(" (*)").split_once('|') else { continue };
        // Members have their path behind the version.
        let package: Vec<&str> = package.split(' ').take(2).collect();
        built.entry(package.join(" ")).or_default().insert(features.to_owned());
    }
    Ok(built)
}
