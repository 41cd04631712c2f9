//! Mutation testing: the formulas of the papers, each changed by a typical error that the tests must detect; and, in
//! [`all`], what cargo-mutants finds in the files where results are formed.
//!
//! The mutants are data ([`table`]). A run copies the workspace to `target/mutate` (the checkout is never edited) and
//! has rounds: first the tests of the crates that define the formulas, then, for undetected mutants, those of the
//! dependent crates. Each round begins with the unchanged tests; the first failing test detects a mutant.

pub(crate) mod all;
mod copy;
mod suite;
mod table;

use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::path::Path;
use std::time::{Duration, Instant};

use crate::step::{Failure, root};
use suite::{Answer, Suite};
use table::{Mutant, Source, sources};

const MINUTE: Duration = Duration::new(60, 0);

/// Result for one mutant.
#[derive(Clone, Debug, PartialEq, Eq)]
enum Outcome {
    /// By this test, or by the time that a suite may take.
    Killed { by: String },
    /// No suite noticed.
    Survived,
    /// The compiler refused it: the row of the table is wrong.
    DoesNotBuild,
}

/// Runs the mutants with one of `only` in their names or files, all if there is none.
///
/// Fails if one survives that is not listed as equivalent, is killed although it is, or does not build.
pub(crate) fn run(only: &[String], list: bool) -> Result<(), Failure> {
    check(|file| read(&root().join(file)))?;
    let chosen: Vec<_> = chosen(only).collect();
    if list {
        for (source, mutant) in &chosen {
            println!("{:<56} {:<14} {}", mutant.name, mutant.kind, source.file);
        }
        println!("{} mutants", chosen.len());
        return Ok(());
    }
    if chosen.is_empty() {
        return Err(Failure::Mutants(format!("no mutant has one of {only:?} in its name or in the path of its file")));
    }
    let folder = root().join("target/mutate");
    let (tree, target) = (folder.join("workspace"), folder.join("target"));
    copy::mirror(&root(), &tree)?;
    suite::write_modules(&tree)?;
    let began = Instant::now();
    let mut outcomes = vec![Outcome::Survived; chosen.len()];
    let rounds = chosen.iter().map(|(source, _)| source.suites.len()).max().unwrap_or(0);
    for round in 0..rounds {
        let left: Vec<_> = (0..chosen.len())
            .filter(|&k| outcomes[k] == Outcome::Survived)
            .filter_map(|k| chosen[k].0.suites.get(round).map(|&suite| (k, suite)))
            .collect();
        let allowed = unchanged(left.iter().map(|(_, suite)| *suite), &tree, &target)?;
        for (done, (k, suite)) in left.iter().enumerate() {
            let (source, mutant) = chosen[*k];
            eprint!("── {}/{} {}: ", done + 1, left.len(), mutant.name);
            let started = Instant::now();
            outcomes[*k] = tried(source, mutant, *suite, (&tree, &target), allowed[suite])?;
            let word = match (&outcomes[*k], mutant.equivalent) {
                (Outcome::Killed { by }, None) => format!("killed by {by}"),
                (Outcome::Killed { by }, Some(_)) => format!("KILLED by {by}, although listed as equivalent"),
                (Outcome::Survived, _) if source.suites.get(round + 1).is_some() => "not noticed yet".to_owned(),
                (Outcome::Survived, Some(_)) => "survived, equivalent".to_owned(),
                (Outcome::Survived, None) => "SURVIVED".to_owned(),
                (Outcome::DoesNotBuild, _) => "DOES NOT BUILD".to_owned(),
            };
            eprintln!("{word} ({:.0} s)", started.elapsed().as_secs_f64());
        }
    }
    let rows: Vec<_> = chosen.into_iter().zip(outcomes).collect();
    print!("{}", report(&rows));
    eprintln!("── {} mutants in {:.0} s", rows.len(), began.elapsed().as_secs_f64());
    verdict(&rows)
}

fn chosen(only: &[String]) -> impl Iterator<Item = (&'static Source, &'static Mutant)> {
    let all = sources().flat_map(|source| source.mutants.iter().map(move |mutant| (source, mutant)));
    all.filter(move |(source, mutant)| {
        only.is_empty() || only.iter().any(|part| mutant.name.contains(part) || source.file.contains(part))
    })
}

/// The table and the sources belong together: each fragment occurs exactly once in its file, and each name is there
/// once.
fn check(text: impl Fn(&str) -> Result<String, Failure>) -> Result<(), Failure> {
    let (mut names, mut said) = (BTreeSet::new(), Vec::new());
    for source in sources() {
        let text = text(source.file)?;
        for mutant in source.mutants {
            let Mutant { name, fragment, .. } = mutant;
            let wrong = match text.matches(fragment).count() {
                _ if !names.insert(*name) => "another one has its name".to_owned(),
                _ if *fragment == mutant.replacement() => "it changes nothing".to_owned(),
                1 => continue,
                count => format!("its fragment occurs {count} times, not once: {fragment}"),
            };
            said.push(format!("the mutant {name:?} of {}: {wrong}", source.file));
        }
    }
    if said.is_empty() {
        return Ok(());
    }
    said.push("The table is xtask/src/mutate/table".to_owned());
    Err(Failure::Mutants(said.join("\n")))
}

fn read(path: &Path) -> Result<String, Failure> {
    fs::read_to_string(path).map_err(|source| Failure::io(path, source))
}

fn write(path: &Path, text: &str) -> Result<(), Failure> {
    fs::write(path, text).map_err(|source| Failure::io(path, source))
}

/// The unchanged tests, which must pass; how long each suite may take with a mutant in it.
fn unchanged(
    suites: impl Iterator<Item = Suite>,
    tree: &Path,
    target: &Path,
) -> Result<BTreeMap<Suite, Duration>, Failure> {
    let mut allowed = BTreeMap::new();
    for suite in suites {
        if allowed.contains_key(&suite) {
            continue;
        }
        eprint!("── unchanged, {suite}: ");
        let began = Instant::now();
        match suite.run(tree, target, MINUTE * 60)? {
            Answer::Passed { time } => {
                eprintln!(
                    "passed in {:.0} s, {:.0} s of them tests",
                    began.elapsed().as_secs_f64(),
                    time.as_secs_f64()
                );
                allowed.insert(suite, MINUTE + time * 5);
            }
            Answer::DoesNotBuild { errors } => {
                return Err(Failure::Mutants(format!("the unchanged tests do not build in {suite}:\n{errors}")));
            }
            other => return Err(Failure::Mutants(format!("the unchanged tests do not pass in {suite}: {other:?}"))),
        }
    }
    Ok(allowed)
}

/// The mutant in the copy, through one suite; the copy is as before afterwards.
fn tried(
    source: &Source,
    mutant: &Mutant,
    suite: Suite,
    (tree, target): (&Path, &Path),
    allowed: Duration,
) -> Result<Outcome, Failure> {
    let path = tree.join(source.file);
    let text = read(&path)?;
    write(&path, &text.replacen(mutant.fragment, &mutant.replacement(), 1))?;
    let answer = suite.run(tree, target, allowed);
    write(&path, &text)?;
    Ok(match answer? {
        Answer::Passed { .. } => Outcome::Survived,
        Answer::Failed { test } => Outcome::Killed { by: test },
        Answer::TimedOut => Outcome::Killed { by: "the time that its tests may take".to_owned() },
        Answer::DoesNotBuild { errors } => {
            eprintln!("\n{errors}");
            Outcome::DoesNotBuild
        }
    })
}

/// The counts of each file as a table of Markdown, and the survivors with their reasons.
fn report(rows: &[((&'static Source, &'static Mutant), Outcome)]) -> String {
    let mut files: BTreeMap<&str, [usize; 4]> = BTreeMap::new();
    let mut total = [0; 4];
    for ((source, mutant), outcome) in rows {
        let column = match (outcome, mutant.equivalent) {
            (Outcome::Killed { .. }, _) => 1,
            (Outcome::Survived, Some(_)) => 2,
            _ => 3,
        };
        for counts in [files.entry(source.file).or_default(), &mut total] {
            counts[0] += 1;
            counts[column] += 1;
        }
    }
    let head = "| file | mutants | killed | equivalent | others |\n|---|---:|---:|---:|---:|\n".to_owned();
    let line = |name: &str, [all, killed, equivalent, others]: [usize; 4]| {
        format!("| {name} | {all} | {killed} | {equivalent} | {others} |\n")
    };
    let table = files.iter().fold(head, |text, (file, counts)| text + &line(&format!("`{file}`"), *counts));
    let survivors = rows.iter().filter(|(_, outcome)| *outcome == Outcome::Survived).map(|((source, mutant), _)| {
        format!("{}: {} ({})\n", source.file, mutant.name, mutant.equivalent.unwrap_or("no test notices"))
    });
    format!("{table}{}\n{}", line("all", total), survivors.collect::<String>())
}

fn verdict(rows: &[((&'static Source, &'static Mutant), Outcome)]) -> Result<(), Failure> {
    let names = |wanted: &dyn Fn(&Mutant, &Outcome) -> bool| -> Vec<&str> {
        rows.iter()
            .filter(|((_, mutant), outcome)| wanted(mutant, outcome))
            .map(|((_, mutant), _)| mutant.name)
            .collect()
    };
    let wrong = [
        ("survived", names(&|mutant, outcome| *outcome == Outcome::Survived && mutant.equivalent.is_none())),
        ("do not build", names(&|_, outcome| *outcome == Outcome::DoesNotBuild)),
        (
            "were killed, although listed as equivalent",
            names(&|mutant, outcome| matches!(outcome, Outcome::Killed { .. }) && mutant.equivalent.is_some()),
        ),
    ];
    let said: Vec<_> = wrong
        .iter()
        .filter(|(_, names)| !names.is_empty())
        .map(|(what, names)| format!("{} {what}: {}", names.len(), names.join("; ")))
        .collect();
    if said.is_empty() { Ok(()) } else { Err(Failure::Mutants(said.join("\n"))) }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A formula that was rewritten takes its mutants along.
    #[test]
    fn every_fragment_occurs_once() {
        check(|file| read(&root().join(file))).unwrap();
    }

    #[test]
    fn a_fragment_that_is_gone_or_doubled_is_named() {
        let first = &sources().next().unwrap().mutants[0];
        let error = check(|_| Ok(String::new())).unwrap_err().to_string();
        assert!(error.contains(first.name) && error.contains("occurs 0 times"), "{error}");
        let fragment = first.fragment;
        let error = check(|_| Ok(format!("{fragment}\n{fragment}"))).unwrap_err().to_string();
        assert!(error.contains("occurs 2 times"), "{error}");
    }

    #[test]
    fn only_listed_survivors_pass() {
        let row = |equivalent: bool, outcome: Outcome| {
            let found = chosen(&[]).find(|(_, mutant)| mutant.equivalent.is_some() == equivalent).unwrap();
            verdict(&[(found, outcome)])
        };
        let killed = Outcome::Killed { by: "a test".to_owned() };
        assert!(row(false, killed.clone()).is_ok() && row(true, Outcome::Survived).is_ok());
        for (equivalent, outcome) in [(false, Outcome::Survived), (true, killed), (false, Outcome::DoesNotBuild)] {
            assert!(row(equivalent, outcome.clone()).is_err(), "{outcome:?}");
        }
    }
}
