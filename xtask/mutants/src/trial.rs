//! Which tests reach which mutants, and what they say of them.

use std::collections::{BTreeMap, HashMap, HashSet};
use std::path::Path;
use std::process::{Child, Command, Stdio};
use std::sync::Mutex;
use std::sync::atomic::{AtomicU64, AtomicUsize, Ordering::Relaxed};
use std::time::{Duration, Instant};

use crate::Failure;
use crate::build::{Build, Program};

/// Bytes of memory that no test of the workspace comes near to: a mutant that has more is one that does not end.
const MEMORY: u64 = 6 << 30;
const LEAST_TIME: Duration = Duration::from_secs(10);
const TIMES_LONGER: u32 = 5;
/// What a test may take without a mutant.
const UNCHANGED: Duration = Duration::new(1800, 0);

/// How many of the dearest tests are named.
const DEAREST: usize = 25;

/// What the tests say of a mutant.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) enum Outcome {
    /// By the test of this name.
    Failed(String),
    /// This test took too long.
    TimedOut(String),
    /// All tests that reach it passed; their number. Or those for which there was time, of so many.
    Survived(usize),
    Unnoticed(usize, usize),
}

struct Test<'a> {
    program: &'a Program,
    name: String,
    time: Duration,
    /// Mutants that it reaches, by the first of their groups.
    reaches: HashSet<u32>,
    /// Two runs of one test at once would share its folder.
    running: Mutex<()>,
    /// How many mutants it has noticed.
    noticed: AtomicU64,
}

enum Ended {
    Passed,
    Failed,
    TimedOut,
}

/// Runs each test once with everything off, then each mutant of `chosen` against the tests that reach it, until one
/// fails; the tests that fail without a mutant are left out, and named.
pub(crate) fn run<'n>(
    build: &Build,
    chosen: &[u32],
    name: &(dyn Fn(u32) -> &'n str + Sync),
    (jobs, most): (usize, Duration),
    scratch: &Path,
) -> Result<BTreeMap<u32, Outcome>, Failure> {
    let mut names = Vec::new();
    for program in &build.programs {
        names.extend(listed(program)?.into_iter().map(|name| (program, name)));
    }
    let next = AtomicUsize::new(0);
    let tests = Mutex::new(Vec::new());
    let began = Instant::now();
    std::thread::scope(|scope| {
        for _ in 0..jobs {
            scope.spawn(|| {
                while let Some((program, name)) = names.get(next.fetch_add(1, Relaxed)) {
                    if let Some(test) = unchanged(program, name, scratch, &build.group) {
                        tests.lock().unwrap_or_else(std::sync::PoisonError::into_inner).push(test);
                    }
                }
            });
        }
    });
    let tests = tests.into_inner().unwrap_or_default();
    let seconds = tests.iter().map(|test| test.time.as_secs_f64()).sum::<f64>();
    let mut dearest: Vec<_> = tests.iter().collect();
    dearest.sort_by_key(|test| std::cmp::Reverse(test.time));
    for test in dearest.iter().take(DEAREST) {
        eprintln!("── {:>6.1} s  {}", test.time.as_secs_f64(), test.name);
    }
    eprintln!(
        "── {} tests unchanged, {seconds:.0} s one by one, in {:.0} s",
        tests.len(),
        began.elapsed().as_secs_f64()
    );
    let (next, outcomes) = (AtomicUsize::new(0), Mutex::new(BTreeMap::new()));
    std::thread::scope(|scope| {
        for _ in 0..jobs {
            scope.spawn(|| {
                while let Some(&id) = chosen.get(next.fetch_add(1, Relaxed)) {
                    let group = build.group[&id];
                    let outcome = tried(id, tests.iter().filter(|test| test.reaches.contains(&group)).collect(), most);
                    // For who does not wait for the end.
                    if outcome.is_survived() {
                        eprintln!("── survived: {}", name(id));
                    }
                    let mut outcomes = outcomes.lock().unwrap_or_else(std::sync::PoisonError::into_inner);
                    outcomes.insert(id, outcome);
                    if outcomes.len() % 50 == 0 {
                        let survived = outcomes.values().filter(|done| done.is_survived()).count();
                        let (done, all) = (outcomes.len(), chosen.len());
                        eprintln!("── {done} of {all}, {survived} survive, {:.0} s", began.elapsed().as_secs_f64());
                    }
                }
            });
        }
    });
    outcomes.into_inner().map_err(|_| Failure("a thread failed".to_owned()))
}

impl Outcome {
    /// Whether no test has noticed it.
    pub(crate) fn is_survived(&self) -> bool {
        matches!(self, Self::Survived(_) | Self::Unnoticed(..))
    }
}

/// The tests that notice most in their time come first, and none begins when those before took `most`.
fn tried(id: u32, mut left: Vec<&Test>, most: Duration) -> Outcome {
    let (count, mut taken) = (left.len(), Duration::ZERO);
    let switch = ("LUENBERGER_MUTANT", id.to_string());
    while !left.is_empty() {
        if taken >= most {
            return Outcome::Unnoticed(count - left.len(), count);
        }
        let worth = |test: &Test| (test.noticed.load(Relaxed) as f64 + 0.1) / (test.time.as_secs_f64() + 0.01);
        left.sort_by(|a, b| worth(a).total_cmp(&worth(b)));
        let free = left.iter().rposition(|test| test.running.try_lock().is_ok()).unwrap_or(left.len() - 1);
        let test = left.remove(free);
        let Ok(running) = test.running.lock() else { continue };
        let began = Instant::now();
        let ended = ended(test.program, &test.name, (switch.0, &switch.1), LEAST_TIME + test.time * TIMES_LONGER);
        drop(running);
        taken += began.elapsed();
        let name = test.name.clone();
        match ended {
            Ended::Passed => continue,
            Ended::Failed => test.noticed.fetch_add(1, Relaxed),
            Ended::TimedOut => return Outcome::TimedOut(name),
        };
        return Outcome::Failed(name);
    }
    Outcome::Survived(count)
}

/// The names of the tests of a program that are not ignored.
fn listed(program: &Program) -> Result<Vec<String>, Failure> {
    let list = |arguments: &[&str]| {
        let output = command(program, arguments).stderr(Stdio::null()).output();
        let output = output.map_err(|error| Failure::io(&program.path, &error))?;
        let text = String::from_utf8_lossy(&output.stdout);
        Ok(text.lines().filter_map(|line| line.strip_suffix(": test")).map(str::to_owned).collect::<Vec<_>>())
    };
    let ignored = list(&["--list", "--format", "terse", "--ignored"])?;
    Ok(list(&["--list", "--format", "terse"])?.into_iter().filter(|name| !ignored.contains(name)).collect())
}

fn unchanged<'a>(program: &'a Program, name: &str, scratch: &Path, group: &HashMap<u32, u32>) -> Option<Test<'a>> {
    let record = scratch.join(format!("{:?}", std::thread::current().id()));
    let _ = std::fs::remove_file(&record);
    let began = Instant::now();
    let ended = ended(program, name, ("LUENBERGER_MUTANTS_REACHED", &record.to_string_lossy()), UNCHANGED);
    if !matches!(ended, Ended::Passed) {
        eprintln!("── LEFT OUT: the test {name} of {} does not pass unchanged", program.path.display());
        return None;
    }
    let text = std::fs::read_to_string(&record).unwrap_or_default();
    let known: HashSet<u32> = group.values().copied().collect();
    let reaches = text.lines().filter_map(|line| line.parse().ok()).filter(|first| known.contains(first)).collect();
    let (running, noticed) = (Mutex::new(()), AtomicU64::new(0));
    Some(Test { program, name: name.to_owned(), time: began.elapsed(), reaches, running, noticed })
}

/// Runs one test, and ends it and what it has started when its time is over.
fn ended(program: &Program, name: &str, variable: (&str, &str), limit: Duration) -> Ended {
    let mut command = command(program, &["--exact", name, "--test-threads", "1"]);
    command.env(variable.0, variable.1).stdin(Stdio::null()).stdout(Stdio::null()).stderr(Stdio::null());
    let Ok(mut child) = command.spawn() else { return Ended::Failed };
    let began = Instant::now();
    let mut pause = Duration::from_millis(1);
    loop {
        match child.try_wait() {
            Ok(Some(status)) => return if status.success() { Ended::Passed } else { Ended::Failed },
            Ok(None) if began.elapsed() < limit && resident(&child) < MEMORY => std::thread::sleep(pause),
            _ => break,
        }
        pause = (pause * 2).min(Duration::from_millis(20));
    }
    kill(&mut child);
    Ended::TimedOut
}

/// Bytes in memory, where the system says. A limit of the address space would stop programs with sanitizers, too.
fn resident(child: &Child) -> u64 {
    let text = std::fs::read_to_string(format!("/proc/{}/statm", child.id())).unwrap_or_default();
    text.split_whitespace().nth(1).and_then(|pages| pages.parse::<u64>().ok()).unwrap_or(0) * 4096
}

fn kill(child: &mut Child) {
    // The group: compilers and simulations that a test has started.
    let _ = Command::new("kill").args(["-KILL", "--", &format!("-{}", child.id())]).stderr(Stdio::null()).status();
    let _ = child.kill();
    let _ = child.wait();
}

fn command(program: &Program, arguments: &[&str]) -> Command {
    let mut command = Command::new(&program.path);
    command.args(arguments);
    command.current_dir(&program.folder).env("CARGO_MANIFEST_DIR", &program.folder);
    // The same cases each time; a failing one is enough: none is made smaller, and none is kept.
    command.env("PROPTEST_RNG_SEED", "1").env("PROPTEST_MAX_SHRINK_ITERS", "0");
    command.env("PROPTEST_DISABLE_FAILURE_PERSISTENCE", "true").env("RUST_BACKTRACE", "0").env_remove("UPDATE");
    std::os::unix::process::CommandExt::process_group(&mut command, 0);
    command
}
