//! The mutants that cargo-mutants finds in a package, all in one build, each behind a switch that the environment sets
//! (`LUENBERGER_MUTANT=id`): mutant schemata (Untch, Offutt, Harrold 1993). Each test runs once to see what it
//! reaches; each mutant is then run against the tests of its package that reach it, until one fails.
//!
//! Run by `cargo xtask mutate --all`, which makes the copy that is changed.

mod build;
mod found;
mod switch;
mod trial;

use std::collections::BTreeMap;
use std::fmt::{self, Write as _};
use std::path::{Path, PathBuf};
use std::process::ExitCode;
use std::time::Duration;

use clap::Parser;

use build::Place;
use found::Mutant;
use trial::Outcome;

#[derive(Parser)]
struct Arguments {
    /// A copy of the workspace: its files are changed
    #[arg(long)]
    tree: PathBuf,
    /// The folder of build output
    #[arg(long)]
    target: PathBuf,
    /// The configuration of cargo-mutants
    #[arg(long)]
    config: PathBuf,
    /// A list of cargo-mutants, in JSON, instead of asking it
    #[arg(long)]
    listed: Option<PathBuf>,
    /// The folder of results
    #[arg(long)]
    out: PathBuf,
    /// Packages, all that have mutants by default
    #[arg(long)]
    package: Vec<String>,
    /// Only mutants with this in their names (files, lines, functions)
    #[arg(long)]
    only: Vec<String>,
    /// Every n-th, from the k-th on: k/n
    #[arg(long)]
    shard: Option<String>,
    /// Only those that survived the last time
    #[arg(long)]
    again: bool,
    /// Show the mutants and run nothing
    #[arg(long)]
    list: bool,
    /// How many tests run at once
    #[arg(long)]
    jobs: Option<usize>,
    /// Seconds of tests after which a mutant counts as one that survives; all tests that reach it by default
    #[arg(long)]
    seconds: Option<u64>,
}

/// What went wrong, in words.
#[derive(Debug)]
struct Failure(String);

impl Failure {
    fn io(path: &Path, error: &std::io::Error) -> Self {
        Self(format!("{}: {error}", path.display()))
    }
}

impl fmt::Display for Failure {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        f.write_str(&self.0)
    }
}

fn main() -> ExitCode {
    match run(&Arguments::parse()) {
        Ok(0) => ExitCode::SUCCESS,
        Ok(survived) => {
            eprintln!("mutants: {survived} survived; those that no test can notice belong into .cargo/mutants.toml");
            ExitCode::FAILURE
        }
        Err(failure) => {
            eprintln!("mutants: {failure}");
            ExitCode::from(2)
        }
    }
}

/// Returns how many survived.
fn run(arguments: &Arguments) -> Result<usize, Failure> {
    let found = match &arguments.listed {
        Some(path) => found::parse(&std::fs::read_to_string(path).map_err(|error| Failure::io(path, &error))?)?,
        None => found::list(&arguments.tree, &arguments.config)?,
    };
    let is_wanted = |mutant: &&Mutant| {
        let name = mutant.package.as_str();
        let short = name.strip_prefix("luenberger-").unwrap_or(name);
        arguments.package.is_empty() || arguments.package.iter().any(|wanted| wanted == name || wanted == short)
    };
    let mut packages: BTreeMap<&str, Vec<Mutant>> = BTreeMap::new();
    for mutant in found.iter().filter(is_wanted) {
        packages.entry(&mutant.package).or_default().push(mutant.clone());
    }
    if packages.is_empty() {
        return Err(Failure(format!("no mutants in {:?}", arguments.package)));
    }
    let shard = arguments.shard.as_deref().map(fraction).transpose()?;
    std::fs::create_dir_all(&arguments.out).map_err(|error| Failure::io(&arguments.out, &error))?;
    let mut survived = 0;
    for (package, mutants) in packages {
        let file = arguments.out.join(format!("{package}.survived"));
        let before = std::fs::read_to_string(&file).unwrap_or_default();
        let before: Vec<_> = before.lines().collect();
        let is_chosen = |(id, mutant): &(u32, &Mutant)| {
            shard.is_none_or(|(k, n)| id % n == (k + 1) % n)
                && (arguments.only.is_empty() || arguments.only.iter().any(|part| mutant.name.contains(part)))
                && (!arguments.again || before.contains(&mutant.name.as_str()))
        };
        let chosen: Vec<u32> = (1..).zip(&mutants).filter(is_chosen).map(|(id, _)| id).collect();
        if arguments.list {
            for id in &chosen {
                println!("{}", mutants[*id as usize - 1].name);
            }
            eprintln!("── {package}: {} of {} mutants", chosen.len(), mutants.len());
            continue;
        }
        eprintln!("── {package}: {} of {} mutants, compiled at once", chosen.len(), mutants.len());
        let refused = arguments.out.join(format!("{package}.refused"));
        let place = Place { tree: &arguments.tree, target: &arguments.target, refused: &refused };
        let built = build::build(package, &mutants, &chosen, &place)?;
        let tried: Vec<_> = chosen.iter().copied().filter(|id| built.group.contains_key(id)).collect();
        let cores = std::thread::available_parallelism().map_or(1, std::num::NonZero::get);
        let name = |id: u32| mutants[id as usize - 1].name.as_str();
        let most = arguments.seconds.map_or(Duration::MAX, Duration::from_secs);
        let limits = (arguments.jobs.unwrap_or(cores), most);
        let outcomes = trial::run(&built, &tried, &name, limits, &arguments.out)?;
        let without = chosen.iter().filter_map(|id| Some((*id, built.without.get(id)?.as_str()))).collect();
        let (text, names) = report(package, &name, &without, &outcomes);
        print!("{text}");
        let all = arguments.out.join(format!("{package}.txt"));
        let lines = outcomes.iter().map(|(id, outcome)| format!("{}: {outcome:?}\n", name(*id)));
        let lines: String = lines.chain(without.iter().map(|(id, why)| format!("{}: {why}\n", name(*id)))).collect();
        std::fs::write(&all, lines).map_err(|error| Failure::io(&all, &error))?;
        std::fs::write(&file, names.join("\n") + "\n").map_err(|error| Failure::io(&file, &error))?;
        survived += names.len();
    }
    Ok(survived)
}

fn fraction(text: &str) -> Result<(u32, u32), Failure> {
    let parts = text.split_once('/').and_then(|(k, n)| Some((k.parse().ok()?, n.parse().ok()?)));
    parts.filter(|(k, n)| k < n).ok_or_else(|| Failure(format!("{text:?} is not a shard: k/n with 0 <= k < n")))
}

/// Counts, what has no switch, and the survivors; and the names of the survivors.
fn report<'a>(
    package: &str,
    name: &dyn Fn(u32) -> &'a str,
    without: &BTreeMap<u32, &str>,
    outcomes: &BTreeMap<u32, Outcome>,
) -> (String, Vec<&'a str>) {
    let mut text = String::new();
    let mut reasons: BTreeMap<&str, usize> = BTreeMap::new();
    for (id, reason) in without {
        let is_refused = reason.starts_with("does not compile");
        *reasons.entry(if is_refused { "does not compile" } else { reason }).or_default() += 1;
        if !is_refused {
            let _ = writeln!(text, "NOT TRIED {} ({reason})", name(*id));
        }
    }
    let mut names = Vec::new();
    for (id, outcome) in outcomes {
        match outcome {
            Outcome::Survived(tests) => {
                let _ = writeln!(text, "SURVIVED {} ({tests} tests reach it)", name(*id));
            }
            Outcome::Unnoticed(run, tests) => {
                let _ = writeln!(text, "SURVIVED {} ({run} of {tests} tests that reach it)", name(*id));
            }
            Outcome::Failed(_) | Outcome::TimedOut(_) => continue,
        }
        names.push(name(*id));
    }
    let count = |which: fn(&Outcome) -> bool| outcomes.values().filter(|outcome| which(outcome)).count();
    let (all, survived) = (outcomes.len(), names.len());
    let unreached = count(|outcome| *outcome == Outcome::Survived(0));
    let failed = count(|outcome| matches!(outcome, Outcome::Failed(_)));
    let in_part = count(|outcome| matches!(outcome, Outcome::Unnoticed(..)));
    let late = count(|outcome| matches!(outcome, Outcome::TimedOut(_)));
    let (low, high) = interval(survived, all);
    let _ = writeln!(
        text,
        "{package}: {all} tried, {failed} noticed, {late} by time, {survived} survived ({unreached} not reached, {in_part} some tests only): {:.1} % \
         (95 %: {:.1} to {:.1} %)",
        100.0 * survived as f64 / all.max(1) as f64,
        100.0 * low,
        100.0 * high
    );
    for (reason, count) in reasons {
        let _ = writeln!(text, "{package}: {count} not tried: {reason}");
    }
    (text, names)
}

/// Wilson's interval of a share, at 95 %.
fn interval(of: usize, all: usize) -> (f64, f64) {
    if all == 0 {
        return (0.0, 1.0);
    }
    let (n, p, z) = (all as f64, of as f64 / all as f64, 1.959_964_f64);
    let center = (p + z * z / (2.0 * n)) / (1.0 + z * z / n);
    let half = z / (1.0 + z * z / n) * (p * (1.0 - p) / n + z * z / (4.0 * n * n)).sqrt();
    ((center - half).max(0.0), (center + half).min(1.0))
}
