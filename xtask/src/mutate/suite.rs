//! One set of tests of one package: built, run until the first test fails, with a time limit.
//!
//! The test binaries of `design` and of the workspace take minutes to compile, and a mutant needs few of their modules:
//! these are compiled alone, in a package that exists in the copy only.

use std::fmt;
use std::fs;
use std::io::{BufRead, BufReader};
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::sync::mpsc;
use std::thread;
use std::time::{Duration, Instant};

use crate::step::Failure;

/// Tests of one package.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(super) struct Suite {
    /// The package.
    pub(super) package: &'static str,
    /// Which of its test binaries.
    pub(super) binaries: &'static [&'static str],
    /// Only tests with one of these in their names; all if there is none.
    pub(super) only: &'static [&'static str],
}

/// The package that exists in the copy only.
pub(super) const MODULES: &str = "luenberger-mutants";

/// Its test binaries, each with the modules that it consists of.
const BINARIES: [(&str, &[&str]); 12] = [
    ("designs", &["crates/design/tests/it/designs.rs", "crates/design/tests/it/bad_input.rs"]),
    ("cubic", &["tests/tests/it/generators.rs", "tests/tests/it/theorems_cubic.rs"]),
    ("input_to_state", &["tests/tests/it/generators.rs", "tests/tests/it/theorems_input_to_state.rs"]),
    ("interval", &["tests/tests/it/generators.rs", "tests/tests/it/theorems_interval.rs"]),
    ("sliding_mode", &["tests/tests/it/theorems_sliding_mode.rs"]),
    ("filters", &["tests/tests/it/generators.rs", "tests/tests/it/theorems_filters.rs"]),
    ("sampled", &["tests/tests/it/generators.rs", "tests/tests/it/theorems_sampled.rs"]),
    ("uncertain", &["tests/tests/it/generators.rs", "tests/tests/it/theorems_uncertain.rs"]),
    ("optimal_cubic", &["crates/design/tests/it/optimal_cubic.rs"]),
    ("positive_real", &["crates/design/tests/it/positive_real.rs"]),
    ("mean_value", &["tests/tests/it/generators.rs", "tests/tests/it/theorems_mvt.rs"]),
    (
        "kkl",
        &["tests/tests/it/generators.rs", "tests/tests/it/theorems_kkl.rs", "tests/tests/it/theorems_kkl_converter.rs"],
    ),
];

const MANIFEST: &str = r#"[package]
name = "luenberger-mutants"
edition.workspace = true
publish = false

[dev-dependencies]
approx.workspace = true
luenberger-design.workspace = true
luenberger-expression.workspace = true
luenberger-linalg.workspace = true
luenberger-lmi.workspace = true
luenberger-observers.workspace = true
luenberger-plants.workspace = true
luenberger-proof.workspace = true
luenberger-reproduce.workspace = true
luenberger-sim.workspace = true
nalgebra = { workspace = true, features = ["macros", "std"] }
proptest.workspace = true
"#;

/// Writes the package of modules into the copy `tree`.
pub(super) fn write_modules(tree: &Path) -> Result<(), Failure> {
    let folder = tree.join("crates/mutants");
    let put = |name: &str, text: &str| {
        let path = folder.join(name);
        let written = path.parent().map_or(Ok(()), fs::create_dir_all).and_then(|()| fs::write(&path, text));
        written.map_err(|source| Failure::io(path, source))
    };
    put("Cargo.toml", MANIFEST)?;
    put("src/lib.rs", "")?;
    for (name, modules) in BINARIES {
        let lines = modules.iter().map(|module| {
            let name = Path::new(module).file_stem().unwrap_or_default().to_string_lossy();
            format!("#[path = \"../../../{module}\"]\nmod {name};\n")
        });
        put(&format!("tests/{name}.rs"), &lines.collect::<String>())?;
    }
    Ok(())
}

/// Result of a suite.
#[derive(Debug)]
pub(super) enum Answer {
    Passed { time: Duration },
    Failed { test: String },
    TimedOut,
    DoesNotBuild { errors: String },
}

impl fmt::Display for Suite {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{} {} {}", self.package, self.binaries.join(" "), self.only.join(" "))
    }
}

/// A test binary, and the folder to run it in.
struct Binary {
    program: PathBuf,
    folder: PathBuf,
}

impl Suite {
    /// Builds and runs the suite in the workspace `tree`; `allowed` bounds the time of the tests alone.
    pub(super) fn run(&self, tree: &Path, target: &Path, allowed: Duration) -> Result<Answer, Failure> {
        let binaries = match self.build(tree, target)? {
            Ok(binaries) => binaries,
            Err(errors) => return Ok(Answer::DoesNotBuild { errors }),
        };
        let began = Instant::now();
        for binary in &binaries {
            let left = allowed.saturating_sub(began.elapsed());
            match self.test(binary, left)? {
                Answer::Passed { .. } => {}
                other => return Ok(other),
            }
        }
        Ok(Answer::Passed { time: began.elapsed() })
    }

    /// The binaries, or the compiler's error.
    fn build(&self, tree: &Path, target: &Path) -> Result<Result<Vec<Binary>, String>, Failure> {
        let cargo = std::env::var_os("CARGO").unwrap_or_else(|| "cargo".into());
        let output = Command::new(&cargo)
            .current_dir(tree)
            .args(["test", "--no-run", "--quiet", "--message-format", "json-render-diagnostics"])
            .args(["--package", self.package])
            .args(self.binaries)
            .arg("--target-dir")
            .arg(target)
            .output()
            .map_err(|source| Failure::io(&cargo, source))?;
        if !output.status.success() {
            return Ok(Err(String::from_utf8_lossy(&output.stderr).into_owned()));
        }
        let messages = String::from_utf8_lossy(&output.stdout);
        let binaries = messages.lines().filter_map(|line| {
            let message: serde_json::Value = serde_json::from_str(line).ok()?;
            let program = message["executable"].as_str()?;
            let folder = Path::new(message["manifest_path"].as_str()?).parent()?;
            let is_test = message["profile"]["test"].as_bool()?;
            is_test.then(|| Binary { program: program.into(), folder: folder.into() })
        });
        Ok(Ok(binaries.collect()))
    }

    /// Ends at the first failing test, or after the time allowed.
    fn test(&self, binary: &Binary, allowed: Duration) -> Result<Answer, Failure> {
        // A failing case is enough: none is made smaller, and none is kept for the next mutant.
        let mut child = Command::new(&binary.program)
            .current_dir(&binary.folder)
            .args(self.only)
            .env("PROPTEST_MAX_SHRINK_ITERS", "0")
            .env("PROPTEST_DISABLE_FAILURE_PERSISTENCE", "true")
            .stdin(Stdio::null())
            .stdout(Stdio::piped())
            .stderr(Stdio::null())
            .spawn()
            .map_err(|source| Failure::io(&binary.program, source))?;
        let began = Instant::now();
        let (sender, lines) = mpsc::channel();
        let stdout = child.stdout.take();
        let reader = thread::spawn(move || {
            let lines = stdout.into_iter().flat_map(|stdout| BufReader::new(stdout).lines());
            lines.map_while(Result::ok).for_each(|line| {
                let _ = sender.send(line);
            });
        });
        let mut answer = None;
        while answer.is_none() {
            match lines.recv_timeout(allowed.saturating_sub(began.elapsed())) {
                Ok(line) => answer = failed(&line).map(|test| Answer::Failed { test }),
                Err(mpsc::RecvTimeoutError::Timeout) => answer = Some(Answer::TimedOut),
                Err(mpsc::RecvTimeoutError::Disconnected) => break,
            }
        }
        if answer.is_some() {
            // It may have ended by itself meanwhile.
            let _ = child.kill();
        }
        let status = child.wait().map_err(|source| Failure::io(&binary.program, source))?;
        let _ = reader.join();
        Ok(answer.unwrap_or_else(|| {
            if status.success() {
                Answer::Passed { time: began.elapsed() }
            } else {
                Answer::Failed { test: format!("a test binary that ended with {status}") }
            }
        }))
    }
}

/// The name of the failed test in a line of the harness.
fn failed(line: &str) -> Option<String> {
    Some(line.strip_prefix("test ")?.strip_suffix(" ... FAILED")?.to_owned())
}

#[cfg(test)]
mod tests {
    use super::failed;

    #[test]
    fn the_harness_names_the_failing_test() {
        assert_eq!(failed("test cubic::the_flow_is_a_flow ... FAILED").as_deref(), Some("cubic::the_flow_is_a_flow"));
        assert_eq!(failed("test cubic::the_flow_is_a_flow ... ok"), None);
        assert_eq!(failed("test result: FAILED. 1 passed; 1 failed"), None);
    }
}
