//! One command at the root of the workspace, with its time.

use std::ffi::OsStr;
use std::fmt;
use std::io::{self, Read};
use std::path::{Path, PathBuf};
use std::process::{Command, ExitCode, ExitStatus, Stdio};
use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::{Mutex, PoisonError};
use std::time::Instant;

use serde_json::Value;

/// Why a row of steps ended early.
#[derive(Debug)]
pub(crate) enum Failure {
    /// A command ran and failed.
    Step { name: String, status: ExitStatus },
    /// A program that is needed is not installed.
    Missing(&'static str),
    /// Members that are built by themselves would compile dependencies a second time.
    Features { missing: String },
    /// A command could not be started, or a file not be written.
    Io { what: PathBuf, source: io::Error },
    /// What the mutants of the formulas were to show does not hold.
    Mutants(String),
    /// A golden program did not run, or gave other bits.
    Firmware(String),
    /// A sweep on SLURM did not end, or gave other bytes.
    Cluster(String),
    /// The kernel of Coq did not say what it should.
    Kernel(String),
    /// A report in a browser did not run, or gave other results.
    Live(String),
}

impl Failure {
    pub(crate) fn io(what: impl Into<PathBuf>, source: io::Error) -> Self {
        Self::Io { what: what.into(), source }
    }

    /// The exit code of the command that failed; 1 if it was killed or did not start.
    pub(crate) fn exit_code(&self) -> ExitCode {
        match self {
            Self::Step { status, .. } => {
                ExitCode::from(status.code().and_then(|code| u8::try_from(code).ok()).unwrap_or(1))
            }
            Self::Features { .. }
            | Self::Io { .. }
            | Self::Missing(_)
            | Self::Mutants(_)
            | Self::Firmware(_)
            | Self::Cluster(_)
            | Self::Kernel(_)
            | Self::Live(_) => ExitCode::FAILURE,
        }
    }
}

impl fmt::Display for Failure {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Step { name, status } => write!(f, "{name} failed ({status})"),
            Self::Features { missing } => {
                write!(f, "tests/features/Cargo.toml lacks features that the whole workspace turns on:{missing}")
            }
            Self::Io { what, source } => write!(f, "{}: {source}", what.display()),
            Self::Missing(name) => write!(f, "{name} is not installed"),
            Self::Mutants(said)
            | Self::Firmware(said)
            | Self::Cluster(said)
            | Self::Kernel(said)
            | Self::Live(said) => write!(f, "{said}"),
        }
    }
}

/// The root of the workspace, the folder above this package.
pub(crate) fn root() -> PathBuf {
    let here = Path::new(env!("CARGO_MANIFEST_DIR"));
    here.parent().unwrap_or(here).to_path_buf()
}

/// The folder of what cargo builds.
pub(crate) fn target() -> PathBuf {
    std::env::var_os("CARGO_TARGET_DIR").map_or_else(|| root().join("target"), |target| root().join(target))
}

/// The package that turns on the features of the whole workspace.
pub(crate) const FEATURES: &str = "luenberger-features";

/// Builds a program of a member (`--bin` or `--example`) with the features with which the tests are built: by itself a
/// member has its dependencies compiled once more.
pub(crate) fn build(package: &str, kind: &str, name: &str) -> Result<(), Failure> {
    cargo(&["build", "--package", FEATURES, "--package", package, kind, name]).step(name)
}

/// Where [`build`] puts a program, in `target/debug`.
pub(crate) fn built(program: &str) -> PathBuf {
    target().join("debug").join(format!("{program}{}", std::env::consts::EXE_SUFFIX))
}

/// Builds the command `luenberger`.
pub(crate) fn build_command() -> Result<(), Failure> {
    build("luenberger-cli", "--bin", COMMAND)
}

/// The command that [`build_command`] built.
pub(crate) fn luenberger(arguments: &[&str]) -> Step {
    program(built(COMMAND)).arguments(arguments)
}

const COMMAND: &str = "luenberger";

/// Builds the reproduction of the papers; the step that runs it into this folder.
pub(crate) fn reproduction(folder: &Path) -> Result<Step, Failure> {
    let name = "luenberger-reproduce";
    build(name, "--bin", name)?;
    Ok(program(built(name)).argument(folder))
}

/// Whether a program can be started.
pub(crate) fn is_installed(name: &str) -> bool {
    let quiet = |command: &mut Command| command.stdout(Stdio::null()).stderr(Stdio::null()).status();
    quiet(Command::new(name).arg("--version")).is_ok_and(|status| status.success())
}

/// A command to run at the root.
pub(crate) struct Step {
    command: Command,
}

/// The cargo that runs this program.
pub(crate) fn cargo(arguments: &[&str]) -> Step {
    let cargo = std::env::var_os("CARGO").unwrap_or_else(|| "cargo".into());
    program(&cargo).arguments(arguments)
}

/// The members of the workspace, as cargo describes them.
pub(crate) fn packages() -> Result<Value, Failure> {
    let metadata = cargo(&["metadata", "--format-version", "1", "--no-deps"]).quiet_output("the members")?;
    let metadata: Value =
        serde_json::from_str(&metadata).map_err(|source| Failure::io("cargo metadata", source.into()))?;
    Ok(metadata["packages"].clone())
}

/// Another program.
pub(crate) fn program(name: impl AsRef<OsStr>) -> Step {
    let mut command = Command::new(name);
    command.current_dir(root());
    Step { command }
}

impl Step {
    pub(crate) fn arguments(mut self, arguments: &[&str]) -> Self {
        self.command.args(arguments);
        self
    }

    pub(crate) fn argument(mut self, argument: impl AsRef<OsStr>) -> Self {
        self.command.arg(argument);
        self
    }

    /// Runs in this folder instead of the root.
    pub(crate) fn folder(mut self, folder: impl AsRef<Path>) -> Self {
        self.command.current_dir(folder);
        self
    }

    pub(crate) fn variable(mut self, name: &str, value: &str) -> Self {
        self.command.env(name, value);
        self
    }

    /// Runs it, its output going where ours goes.
    pub(crate) fn step(self, name: &str) -> Result<(), Failure> {
        self.run(name).map(|_| ())
    }

    /// Runs it and returns what it wrote to standard output.
    pub(crate) fn output(mut self, name: &str) -> Result<String, Failure> {
        self.command.stdout(Stdio::piped());
        self.run(name)
    }

    /// Runs it without a word and returns what it wrote to standard output.
    pub(crate) fn quiet_output(mut self, name: &str) -> Result<String, Failure> {
        let output = self.command.stderr(Stdio::inherit()).output();
        let output = output.map_err(|source| Failure::io(self.command.get_program(), source))?;
        Self::checked(name, output.status)?;
        Ok(String::from_utf8_lossy(&output.stdout).into_owned())
    }

    /// Runs it and returns what it would have printed.
    fn run_silently(mut self, name: &str) -> (String, Result<(), Failure>) {
        let began = Instant::now();
        let mut text = String::new();
        let ended = io::pipe().and_then(|(mut printed, writer)| {
            let mut child = self.command.stdout(writer.try_clone()?).stderr(writer).spawn()?;
            // The pipe ends once the child has ended, which has the only ends to write to left.
            self.command.stdout(Stdio::null()).stderr(Stdio::null());
            let mut bytes = Vec::new();
            printed.read_to_end(&mut bytes)?;
            text = String::from_utf8_lossy(&bytes).into_owned();
            child.wait()
        });
        let ended = ended.map_err(|source| Failure::io(self.command.get_program(), source)).and_then(|status| {
            let ended = Self::ended(name, began, status);
            // What passed is not of interest.
            if status.success() {
                eprintln!("{ended}");
            } else {
                eprintln!("{}\n{text}{ended}", self.started(name));
            }
            Self::checked(name, status)
        });
        (text, ended)
    }

    fn run(mut self, name: &str) -> Result<String, Failure> {
        eprintln!("{}", self.started(name));
        let began = Instant::now();
        let ended = self.command.stderr(Stdio::inherit()).spawn().and_then(std::process::Child::wait_with_output);
        let output = ended.map_err(|source| Failure::io(self.command.get_program(), source))?;
        eprintln!("{}", Self::ended(name, began, output.status));
        Self::checked(name, output.status)?;
        Ok(String::from_utf8_lossy(&output.stdout).into_owned())
    }

    /// The line before a step, with its command.
    fn started(&self, name: &str) -> String {
        let words = std::iter::once(self.command.get_program()).chain(self.command.get_args());
        let shown = words.map(|word| Path::new(word).file_name().unwrap_or(word).to_string_lossy());
        format!("── {name}: {}", shown.collect::<Vec<_>>().join(" "))
    }

    /// The line after a step, with its time, which is noted.
    fn ended(name: &str, began: Instant, status: ExitStatus) -> String {
        let seconds = began.elapsed().as_secs_f64();
        ENDED.lock().unwrap_or_else(PoisonError::into_inner).push((name.to_owned(), seconds));
        let word = if status.success() { "done" } else { "failed" };
        format!("── {name}: {word} in {seconds:.1} s")
    }

    fn checked(name: &str, status: ExitStatus) -> Result<(), Failure> {
        if status.success() { Ok(()) } else { Err(Failure::Step { name: name.to_owned(), status }) }
    }
}

/// Name and seconds of each step that has ended, in this order.
static ENDED: Mutex<Vec<(String, f64)>> = Mutex::new(Vec::new());

/// The steps that have ended, each with its seconds.
pub(crate) fn ended() -> Vec<(String, f64)> {
    ENDED.lock().unwrap_or_else(PoisonError::into_inner).clone()
}

/// One of several commands that run at the same time.
pub(crate) struct Job {
    name: String,
    step: Step,
}

impl Job {
    pub(crate) fn new(name: &str, step: Step) -> Self {
        Self { name: name.to_owned(), step }
    }

    pub(crate) fn variable(self, name: &str, value: &str) -> Self {
        Self { name: self.name, step: self.step.variable(name, value) }
    }
}

/// Runs `at_once` of the jobs at a time, in their order, to the end of all. Returns what each printed, which is shown
/// of those that fail, and the failure of the first of these.
pub(crate) fn together(jobs: Vec<Job>, at_once: usize) -> (Vec<String>, Result<(), Failure>) {
    type Place = Mutex<(Option<Job>, String, Result<(), Failure>)>;
    let places: Vec<Place> = jobs.into_iter().map(|job| Mutex::new((Some(job), String::new(), Ok(())))).collect();
    let next = AtomicUsize::new(0);
    let work = || {
        while let Some(place) = places.get(next.fetch_add(1, Ordering::Relaxed)) {
            // Nobody else takes this place.
            let mut place = place.lock().unwrap_or_else(PoisonError::into_inner);
            if let Some(Job { name, step }) = place.0.take() {
                (place.1, place.2) = step.run_silently(&name);
            }
        }
    };
    std::thread::scope(|scope| {
        for _ in 0..at_once {
            scope.spawn(work);
        }
    });
    let places = places.into_iter().map(|place| place.into_inner().unwrap_or_else(PoisonError::into_inner));
    let (printed, ended): (Vec<_>, Vec<_>) = places.map(|(_, text, ended)| (text, ended)).unzip();
    (printed, ended.into_iter().collect())
}

#[cfg(all(test, unix))]
mod tests {
    use super::*;

    /// Three jobs, two at a time: each runs to its end, and the second fails.
    #[test]
    fn jobs_run_to_the_end_of_all() {
        let shell = |script: &str| program("sh").arguments(&["-c", script]);
        let jobs = vec![
            Job::new("first", shell("sleep 0.1; echo one")),
            Job::new("second", shell("echo two >&2; exit 3")),
            Job::new("third", shell("echo $NUMBER")).variable("NUMBER", "three"),
        ];
        let (printed, ended) = together(jobs, 2);
        assert_eq!(printed, ["one\n", "two\n", "three\n"]);
        match ended {
            Err(Failure::Step { name, status }) => assert_eq!((name.as_str(), status.code()), ("second", Some(3))),
            other => panic!("{other:?}"),
        }
        assert!(super::ended().iter().any(|(name, seconds)| name == "first" && *seconds >= 0.1));
    }
}
