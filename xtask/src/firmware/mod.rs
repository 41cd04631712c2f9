//! The observers on boards in QEMU: every step's bits against those of the host, and what a step costs.
//!
//! The golden programs are the workspace `firmware/`. Nothing is installed here; what is left out for lack of a tool is
//! said.
//!
//! | file | subject |
//! |---|---|
//! | `boards` | the boards, their compilers, and QEMU |
//! | `c` | emitted C on the host: compilers, sanitizers, cppcheck |
//! | `elf` | symbols and stack frames of a program |
//! | `output` | what a golden program prints |
//! | `studies` | the observers of templates and examples, exported by the command, on the board |
//! | `table` | the page of results |

mod boards;
mod c;
mod elf;
mod output;
mod studies;
mod table;

use crate::step::{Failure, Step, cargo, root};
use boards::{BOARDS, Board};
use output::Golden;
use std::fs;
use std::path::{Path, PathBuf};

/// What was measured on a board.
struct Measured {
    board: &'static Board,
    rust: Vec<(String, Cost)>,
    c: Vec<(String, Cost)>,
}

/// What a step costs: instructions on average and at most, bytes of stack and of code.
struct Cost {
    mean: f64,
    most: u32,
    stack: u32,
    frame: Option<u64>,
    code: u64,
    /// Bytes of constants, where they are known.
    constants: Option<u64>,
}

impl Cost {
    /// Bytes of stack that an interrupt finds taken: not all that a function reserves is written.
    fn reserved(&self) -> u64 {
        u64::from(self.stack).max(self.frame.unwrap_or_default())
    }
}

/// Runs what the tools of this machine allow; with `document` the page `docs/bench-target.md` is written, if no board
/// was left out.
pub(crate) fn run(document: bool) -> Result<(), Failure> {
    let target = target();
    let exports = target.join("exports");
    if exports.exists() {
        fs::remove_dir_all(&exports).map_err(|source| Failure::io(&exports, source))?;
    }
    // The elementary functions and the exports, with the profile of the boards: no operation may be contracted there.
    let host = ["run", "--quiet", "--release", "--package", "luenberger-golden-host", "--"];
    let printed = workspace(&host).argument(&exports).output("golden programs on the host")?;
    let golden = output::read(&printed)?;
    let names: Vec<String> = output::exported(&exports)?;
    eprintln!("── {} observers, {} of them exported as C", golden.len(), names.len());

    let mut skipped = c::on_the_host(&exports, &names, &golden)?;
    let on_the_host = skipped.len();
    let mut measured = Vec::new();
    for board in &BOARDS {
        if let Some(missing) = board.missing() {
            skipped.push(format!("{}: {missing}", board.target));
            continue;
        }
        let rust = rust_on(board, &target, &golden)?;
        let c = match board.c_missing() {
            None => boards::c_on(board, &exports, &names, &golden)?,
            Some(missing) => {
                skipped.push(format!("emitted C on {}: {missing}", board.target));
                Vec::new()
            }
        };
        measured.push(Measured { board, rust, c });
    }
    let board = &BOARDS[0];
    let studies = match board.emulator_missing().or_else(|| board.c_missing()) {
        None => studies::on(board, &target.join("studies"), board.target_missing().is_none())?,
        Some(missing) => {
            skipped.push(format!("the observers of templates and examples on {}: {missing}", board.target));
            Vec::new()
        }
    };
    for what in &skipped {
        eprintln!("── SKIPPED: {what}");
    }
    let page = table::page(&measured, &studies);
    let is_whole = skipped.len() == on_the_host;
    let path = if document && is_whole { root().join("docs/bench-target.md") } else { target.join("bench-target.md") };
    fs::write(&path, page).map_err(|source| Failure::io(&path, source))?;
    eprintln!("── {}", path.display());
    if document && !is_whole {
        return Err(Failure::Firmware("docs/bench-target.md is as it was: a board was left out".to_owned()));
    }
    Ok(())
}

/// The folder of all builds.
fn target() -> PathBuf {
    let all = std::env::var_os("CARGO_TARGET_DIR").map_or_else(|| root().join("target"), PathBuf::from);
    all.join("firmware")
}

/// cargo in the workspace of the golden programs.
fn workspace(arguments: &[&str]) -> Step {
    let (command, rest) = arguments.split_first().unwrap_or((&"build", &[]));
    cargo(&[command, "--manifest-path", "firmware/Cargo.toml", "--locked"])
        .variable("CARGO_TARGET_DIR", &target().to_string_lossy())
        .arguments(rest)
}

/// Builds the golden programs for the board, runs them and compares every step.
fn rust_on(board: &'static Board, target: &Path, golden: &[Golden]) -> Result<Vec<(String, Cost)>, Failure> {
    // It links only if nothing can panic: the panic handler calls a function that does not exist.
    workspace(&["build", "--release", "--package", "luenberger-board", "--target", board.target])
        // The sizes of stack frames are an output that stable compilers hide.
        .variable("RUSTC_BOOTSTRAP", "1")
        .variable("RUSTFLAGS", "-Zemit-stack-sizes")
        .step(board.target)?;
    let program = target.join(board.target).join("release/board");
    let found = output::read(&boards::run(board, &program)?)?;
    let image = elf::Image::read(&program)?;
    let mut costs = Vec::new();
    // Observers in fixed point are compared in C.
    for (index, golden) in golden.iter().filter(|golden| !golden.name.starts_with("fixed_")).enumerate() {
        let found = found.get(index).ok_or_else(|| golden.differs("is missing", board.target))?;
        golden.compare(found, board.target)?;
        let step = format!("step_{}", golden.name);
        let code = image.code(|name| name == step);
        costs.push((golden.name.clone(), found.cost(code, image.frame(&step))?));
    }
    eprintln!("── {}: {} observers, every step as on the host; nothing can panic", board.target, costs.len());
    Ok(costs)
}
