//! One build of a crate with all of its mutants, and the programs of its tests.

use std::collections::{BTreeMap, HashMap};
use std::hash::{DefaultHasher, Hash, Hasher};
use std::ops::Range;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};

use serde_json::Value;

use crate::Failure;
use crate::found::Mutant;
use crate::switch::{Switched, switched};

/// The module that every crate gets; `COUNT` is added.
const RUNTIME: &str = include_str!("runtime.rs");
/// Mutants that overflow where the compiler sees it are tried like all others.
const ALLOWED: &str = "#![allow(arithmetic_overflow, unconditional_panic, warnings)] ";

/// A crate with its mutants, compiled.
pub(crate) struct Build {
    pub(crate) programs: Vec<Program>,
    /// The first of the mutants that are reached together with each that has a switch.
    pub(crate) group: HashMap<u32, u32>,
    /// Mutants without a switch, with the reason.
    pub(crate) without: BTreeMap<u32, String>,
}

/// A program of tests.
pub(crate) struct Program {
    pub(crate) path: PathBuf,
    /// The folder of its package, in which it runs.
    pub(crate) folder: PathBuf,
}

/// Where things are.
pub(crate) struct Place<'a> {
    /// A copy of the workspace, which is changed.
    pub(crate) tree: &'a Path,
    pub(crate) target: &'a Path,
    /// A file for what the compiler refuses.
    pub(crate) refused: &'a Path,
}

/// Rewrites the package's files in the copy, and compiles it with its tests; leaves out what the compiler refuses.
///
/// Mutants are numbered from 1 on, in their order; only those of `chosen` are put in.
pub(crate) fn build(package: &str, mutants: &[Mutant], chosen: &[u32], place: &Place) -> Result<Build, Failure> {
    let mut without: BTreeMap<u32, String> = BTreeMap::new();
    let mut files: BTreeMap<&Path, Vec<(u32, &Mutant)>> = BTreeMap::new();
    for (id, mutant) in (1..).zip(mutants).filter(|(id, _)| chosen.contains(id)) {
        files.entry(&mutant.file).or_default().push((id, mutant));
    }
    let library = library(package, place)?;
    files.entry(&library).or_default();
    let read = |file: &Path| std::fs::read_to_string(place.tree.join(file)).map_err(|error| Failure::io(file, &error));
    let sources: BTreeMap<&Path, String> =
        files.keys().map(|file| Ok((*file, read(file)?))).collect::<Result<_, Failure>>()?;
    // What the compiler refused the last time, of the same sources.
    let sources_hash = {
        let mut hasher = DefaultHasher::new();
        (&sources, ALLOWED).hash(&mut hasher);
        hasher.finish().to_string()
    };
    let known = std::fs::read_to_string(place.refused).unwrap_or_default();
    if let Some(known) = known.strip_prefix(&sources_hash) {
        let pairs = known.lines().filter_map(|line| line.split_once(' '));
        without.extend(pairs.filter_map(|(id, reason)| Some((id.parse().ok()?, reason.to_owned()))));
    }
    for round in 1.. {
        let mut written: BTreeMap<PathBuf, Switched> = BTreeMap::new();
        for (file, all) in &files {
            let root = **file == *library;
            let own = all.iter().filter(|(id, _)| !without.contains_key(id)).copied().collect::<Vec<_>>();
            let mut done =
                switched(&sources[file], &own).map_err(|error| Failure(format!("{}: {error}", file.display())))?;
            without.extend(done.without.drain(..).map(|(id, reason)| (id, reason.to_owned())));
            let text = if root {
                format!("{ALLOWED}{}{}", done.text, RUNTIME.replace("COUNT", &(mutants.len() + 1).to_string()))
            } else {
                done.text.clone()
            };
            std::fs::write(place.tree.join(file), text).map_err(|error| Failure::io(file, &error))?;
            if root {
                let moved = |range: &Range<usize>| range.start + ALLOWED.len()..range.end + ALLOWED.len();
                done.mutants.iter_mut().for_each(|(_, range)| *range = moved(range));
                done.around.iter_mut().for_each(|(_, range)| *range = moved(range));
            }
            written.insert(file.to_path_buf(), done);
        }
        // The library and its tests by one command, so that its dependencies have the same features for both.
        let (success, messages) = cargo(&["test", "--tests", "--no-run", "--package", package], place)?;
        if success {
            let lines = without.iter().map(|(id, reason)| format!("\n{id} {reason}"));
            std::fs::write(place.refused, sources_hash + &lines.collect::<String>())
                .map_err(|error| Failure::io(place.refused, &error))?;
            let group = written.values().flat_map(|done| done.group.clone()).collect();
            return Ok(Build { programs: messages.iter().filter_map(program).collect(), group, without });
        }
        let known = without.len();
        for message in messages.iter().map(|message| &message["message"]).filter(|message| message["level"] == "error")
        {
            refused(message, &written, &mut without);
        }
        eprintln!("── round {round}: the compiler refuses {} mutants", without.len() - known);
        if without.len() == known {
            let errors = messages.iter().filter_map(|message| message["message"]["rendered"].as_str());
            return Err(Failure(format!("{package} does not compile:\n{}", errors.collect::<String>())));
        }
    }
    unreachable!("rounds have no end")
}

/// The mutants that an error of the compiler is about: the one whose text it points at; if there is none, all of the
/// innermost expression or function with switches.
fn refused(message: &Value, written: &BTreeMap<PathBuf, Switched>, without: &mut BTreeMap<u32, String>) {
    let code = message["code"]["code"].as_str().unwrap_or("error");
    for span in message["spans"].as_array().into_iter().flatten().filter(|span| span["is_primary"] == true) {
        let mut span = span;
        while let Some(outer) = Some(&span["expansion"]["span"]).filter(|outer| outer.is_object()) {
            span = outer;
        }
        let file = PathBuf::from(span["file_name"].as_str().unwrap_or_default());
        let at = span["byte_start"].as_u64().and_then(|at| usize::try_from(at).ok()).unwrap_or(0);
        let Some(done) = written.get(&file) else { continue };
        if let Some((id, _)) = done.mutants.iter().find(|(_, range)| range.contains(&at)) {
            without.insert(*id, format!("does not compile: {code}"));
        } else if let Some((ids, _)) =
            done.around.iter().filter(|(_, range)| range.contains(&at)).min_by_key(|(_, range)| range.len())
        {
            without.extend(ids.iter().map(|id| (*id, format!("its switch does not compile: {code}"))));
        }
    }
}

/// The root of the package's library, relative to the copy.
fn library(package: &str, place: &Place) -> Result<PathBuf, Failure> {
    let mut command = Command::new("cargo");
    command.args(["metadata", "--no-deps", "--offline", "--format-version", "1"]).current_dir(place.tree);
    let output =
        command.stderr(Stdio::inherit()).output().map_err(|error| Failure(format!("cargo metadata: {error}")))?;
    let all: Value = serde_json::from_slice(&output.stdout).map_err(|error| Failure(format!("metadata: {error}")))?;
    let found = all["packages"].as_array().into_iter().flatten().find(|found| found["name"] == package);
    let targets = found.and_then(|found| found["targets"].as_array()).into_iter().flatten();
    let root = targets.filter(|target| target["kind"][0] == "lib").find_map(|target| target["src_path"].as_str());
    let root = root.ok_or_else(|| Failure(format!("{package} has no library")))?;
    let tree = place.tree.canonicalize().map_err(|error| Failure::io(place.tree, &error))?;
    let root = Path::new(root);
    let relative = root.strip_prefix(&tree).or_else(|_| root.strip_prefix(place.tree));
    relative.map(Path::to_path_buf).map_err(|_| Failure(format!("{} is outside of the copy", root.display())))
}

/// The program of tests that a message of cargo is about.
fn program(message: &Value) -> Option<Program> {
    let path = message["executable"].as_str().filter(|_| message["profile"]["test"] == true)?.into();
    let folder = Path::new(message["manifest_path"].as_str()?).parent()?.to_path_buf();
    Some(Program { path, folder })
}

fn cargo(arguments: &[&str], place: &Place) -> Result<(bool, Vec<Value>), Failure> {
    let mut command = Command::new("cargo");
    command.args(arguments).args(["--message-format", "json"]).current_dir(place.tree);
    command.env("CARGO_TARGET_DIR", place.target).env("CARGO_INCREMENTAL", "0").stderr(Stdio::inherit());
    let output = command.output().map_err(|error| Failure(format!("cargo: {error}")))?;
    let text = String::from_utf8_lossy(&output.stdout);
    Ok((output.status.success(), text.lines().filter_map(|line| serde_json::from_str(line).ok()).collect()))
}
