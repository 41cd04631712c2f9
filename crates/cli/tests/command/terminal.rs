//! Runs the built binary as a shell would.

use serde_json::Value;
use std::io::Write;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};

/// Output and exit code of one run.
#[derive(Debug)]
pub(crate) struct Ran {
    pub(crate) code: Option<i32>,
    pub(crate) stdout: String,
    pub(crate) stderr: String,
}

impl Ran {
    /// The error stream without the estimate of the run time.
    pub(crate) fn stderr_without_estimate(&self) -> String {
        without_estimate(&self.stderr).collect::<Vec<_>>().join("\n")
    }

    /// The one JSON object on standard output.
    #[track_caller]
    pub(crate) fn json(&self) -> Value {
        assert_eq!(self.stdout.lines().count(), 1, "one line: {self:?}");
        serde_json::from_str(&self.stdout).unwrap()
    }
}

/// The lines without the estimate of the run time, which is printed on slow or busy machines only.
pub(crate) fn without_estimate(text: &str) -> impl Iterator<Item = &str> {
    text.lines().filter(|line| !line.starts_with("estimate: "))
}

/// Runs the binary with these arguments and this standard input, which is not a terminal.
#[track_caller]
pub(crate) fn luenberger(arguments: &[&str], input: impl AsRef<[u8]>) -> Ran {
    run(Command::new(env!("CARGO_BIN_EXE_luenberger")).args(arguments), input.as_ref())
}

#[track_caller]
pub(crate) fn run(command: &mut Command, input: &[u8]) -> Ran {
    let mut child = command.stdin(Stdio::piped()).stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().unwrap();
    // A command that rejects its arguments does not read standard input.
    _ = child.stdin.take().unwrap().write_all(input);
    let output = child.wait_with_output().unwrap();
    Ran {
        code: output.status.code(),
        stdout: String::from_utf8(output.stdout).unwrap(),
        stderr: String::from_utf8(output.stderr).unwrap(),
    }
}

/// Whether `EVERY_CASE` is set, as by `cargo xtask test --all`: otherwise a sample of what takes long.
pub(crate) fn every_case() -> bool {
    std::env::var_os("EVERY_CASE").is_some()
}

/// A new folder for one test, below the build folder.
pub(crate) fn folder(name: &str) -> PathBuf {
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join(name);
    _ = std::fs::remove_dir_all(&folder);
    std::fs::create_dir_all(&folder).unwrap();
    folder
}
