//! `cargo xtask test`: every test of the workspace, and every example of its documentation.
//!
//! The tests are compiled at once. Their programs and the examples then run two at a time, each with half of the
//! cores, the longest first: one program alone ends with a test that keeps a single core busy.

use std::num::NonZero;
use std::path::{Path, PathBuf};

use serde_json::Value;

use crate::step::{Failure, Job, Step, cargo, packages, program, target, together};

/// Tests read it to try all of what they otherwise take a sample of.
const EVERY_CASE: &str = "EVERY_CASE";

/// The programs that run longest, in this order; the others follow in the order of cargo.
const LONGEST: [&str; 6] = [
    "luenberger-study",
    "luenberger-cli",
    "luenberger-export",
    "luenberger-tests",
    "luenberger-reproduce",
    "luenberger-design",
];

/// Members whose examples are optimised like the crates: without it they take longer to run than to compile.
const OPTIMISED: [&str; 4] = ["luenberger-reproduce", "luenberger-sim", "luenberger-study", "luenberger-tests"];

/// A test program of a package.
struct Binary {
    package: String,
    /// The folder of the package, in which its tests run.
    folder: PathBuf,
    /// How cargo selects it: `--test it`, `--bins`.
    selected: Vec<String>,
    path: PathBuf,
}

/// Fails with the first program that failed, after all have run and the commands that repeat what failed.
pub(crate) fn run(seed: u64, all: bool) -> Result<(), Failure> {
    let variables = variables(seed, all);
    let shown: Vec<_> = variables.iter().map(|(name, value)| format!("{name}={value}")).collect();
    let shown = shown.join(" ");
    eprintln!("property tests: {shown}");
    let with = |step: Step| variables.iter().fold(step, |step, (name, value)| step.variable(name, value));
    let mut binaries = compile()?;
    if all {
        let names = examples()?.into_iter().flat_map(|name| ["--example".to_owned(), name]);
        names.fold(cargo(&["build", "--workspace"]), Step::argument).step("examples that no test runs")?;
    }
    let rank = |package: &str| LONGEST.iter().position(|name| *name == package).unwrap_or(LONGEST.len());
    binaries.sort_by_key(|binary| rank(&binary.package));
    let cores = std::thread::available_parallelism().map_or(1, NonZero::get);
    let threads = cores.div_ceil(2).to_string();
    let mut jobs: Vec<Job> = documented().into_iter().map(|(name, step)| Job::new(name, with(step))).collect();
    let documented = jobs.len();
    for binary in &binaries {
        let name = format!("{} ({})", binary.package, binary.selected.last().map_or("", String::as_str));
        let step = program(&binary.path).folder(&binary.folder);
        jobs.push(Job::new(&name, with(step).variable("CARGO_MANIFEST_DIR", &binary.folder.to_string_lossy())));
    }
    if all {
        jobs.extend(built_apart().into_iter().map(|(name, step)| Job::new(name, with(step))));
    }
    let jobs = jobs.into_iter().map(|job| job.variable("RUST_TEST_THREADS", &threads)).collect();
    let (printed, ended) = together(jobs, cores.min(2));
    for (binary, text) in binaries.iter().zip(printed.iter().skip(documented)) {
        for test in failed(text) {
            let selected = binary.selected.join(" ");
            eprintln!("── to repeat: {shown} cargo test -p {} {selected} -- --exact {test}", binary.package);
        }
    }
    ended?;
    if !all {
        eprintln!("── a sample of the templates, and nothing built apart: cargo xtask test --all has the rest");
    }
    Ok(())
}

fn variables(seed: u64, all: bool) -> Vec<(&'static str, String)> {
    let seed = ("PROPTEST_RNG_SEED", seed.to_string());
    let every = all.then(|| (EVERY_CASE, "1".to_owned()));
    [seed].into_iter().chain(every).collect()
}

/// The examples in the documentation.
fn documented() -> [(&'static str, Step); 2] {
    let others = OPTIMISED.map(|name| format!("--exclude={name}"));
    let others = others.iter().fold(cargo(&["test", "--workspace", "--doc"]), Step::argument);
    let optimised = OPTIMISED.map(|name| format!("--package={name}"));
    let optimised = optimised.iter().fold(cargo(&["test", "--doc"]), Step::argument);
    let optimised = optimised.variable("RUSTDOCFLAGS", "-C opt-level=1");
    [("examples in the documentation", others), ("examples of runs", optimised)]
}

/// Crates without some of their features, and the program of mutants on a toy.
fn built_apart() -> [(&'static str, Step); 3] {
    // Other members turn on the feature `clarabel` of lmi: with the workspace it is tested on, by itself off. Nothing
    // but lmi is compiled for it, because the features of all that it stands on are those of the workspace.
    let lmi = cargo(&["test", "--package", "luenberger-lmi"]);
    let bare = ["test", "--package", "luenberger-observers-tests", "--no-default-features", "--features", "serde"];
    let bare = cargo(&bare);
    let mutants = ["test", "--locked", "--manifest-path", "xtask/mutants/Cargo.toml", "--target-dir"];
    let mutants = cargo(&mutants).argument(target().join("mutants"));
    [("lmi without Clarabel", lmi), ("observers without dual numbers", bare), ("mutants of a toy", mutants)]
}

/// Compiles all tests, and returns their programs.
fn compile() -> Result<Vec<Binary>, Failure> {
    let members = members()?;
    let messages = ["test", "--workspace", "--tests", "--no-run", "--message-format", "json-render-diagnostics"];
    let text = cargo(&messages).output("compiling the tests")?;
    let messages = text.lines().filter_map(|line| serde_json::from_str::<Value>(line).ok());
    Ok(messages.filter_map(|message| binary(&message, &members)).collect())
}

/// The test program of a message of cargo, if it is about one.
fn binary(message: &Value, members: &[(PathBuf, String)]) -> Option<Binary> {
    let path = PathBuf::from(message["executable"].as_str()?);
    if message["reason"] != "compiler-artifact" || message["profile"]["test"] != true {
        return None;
    }
    let manifest = Path::new(message["manifest_path"].as_str()?);
    let (_, package) = members.iter().find(|(known, _)| known == manifest)?;
    let name = message["target"]["name"].as_str()?;
    let selected = match message["target"]["kind"][0].as_str()? {
        "lib" => vec!["--lib".to_owned()],
        kind => vec![format!("--{kind}"), name.to_owned()],
    };
    Some(Binary { package: package.clone(), folder: manifest.parent()?.to_owned(), selected, path })
}

/// The manifest and the name of each member.
fn members() -> Result<Vec<(PathBuf, String)>, Failure> {
    let packages = packages()?;
    let packages = packages.as_array().into_iter().flatten();
    let members = packages.filter_map(|package| {
        Some((PathBuf::from(package["manifest_path"].as_str()?), package["name"].as_str()?.to_owned()))
    });
    Ok(members.collect())
}

/// The examples that no test runs: those of `luenberger` are modules of its tests, all but one.
fn examples() -> Result<Vec<String>, Failure> {
    let packages = packages()?;
    let others = packages.as_array().into_iter().flatten().filter(|package| package["name"] != "luenberger");
    let targets = others.filter_map(|package| package["targets"].as_array()).flatten();
    let examples = targets.filter(|target| target["kind"][0] == "example").filter_map(|target| target["name"].as_str());
    Ok(examples.chain(["numerical_kkl_table"]).map(str::to_owned).collect())
}

/// The names of the tests that failed, from what their program printed.
fn failed(printed: &str) -> Vec<&str> {
    let lines = printed.lines().filter_map(|line| line.strip_prefix("test ")?.strip_suffix(" ... FAILED"));
    // `should_panic` stands between the name and the dots.
    lines.map(|name| name.split(" - ").next().unwrap_or(name)).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// As libtest prints them, for a test in a module, one that should panic, and one that passes.
    #[test]
    fn failed_tests_are_named() {
        let printed = "running 3 tests\ntest placement::poles ... FAILED\ntest edge - should panic ... FAILED\n\
                       test other ... ok\n\nfailures:\n    placement::poles\n    edge\n";
        assert_eq!(failed(printed), ["placement::poles", "edge"]);
    }

    /// A message of `cargo test --no-run --message-format json`, cargo 1.95, shortened; and one of a library.
    #[test]
    fn programs_are_found_in_the_messages_of_cargo() {
        let members = [(PathBuf::from("/w/crates/sim/Cargo.toml"), "luenberger-sim".to_owned())];
        let message = |test: bool| {
            serde_json::json!({
                "reason": "compiler-artifact", "package_id": "path+file:///w/crates/sim#luenberger-sim@0.2.0",
                "manifest_path": "/w/crates/sim/Cargo.toml", "profile": { "opt_level": "2", "test": test },
                "target": { "kind": ["test"], "crate_types": ["bin"], "name": "it" },
                "executable": "/w/target/debug/deps/it-0123",
            })
        };
        let found = binary(&message(true), &members).unwrap();
        assert_eq!((found.package.as_str(), found.folder.as_path()), ("luenberger-sim", Path::new("/w/crates/sim")));
        assert_eq!(found.selected, ["--test", "it"]);
        assert!(binary(&message(false), &members).is_none() && binary(&message(true), &[]).is_none());
    }
}
