//! The workspace's own commands: `cargo xtask reproduce`, `cargo xtask test`, `cargo xtask lint`, `cargo xtask docs`,
//! `cargo xtask bench linalg`, `cargo xtask bench lmi`, `cargo xtask bench proof`, `cargo xtask bench sim`,
//! `cargo xtask bench observers`, `cargo xtask bench step`, `cargo xtask bench sweep`,
//! `cargo xtask stress proof`, `cargo xtask stress theorems`, `cargo xtask stress words`, `cargo xtask mutate`,
//! `cargo xtask firmware`, `cargo xtask deploy`, `cargo xtask cluster`, `cargo xtask kernel`,
//! `cargo xtask live`, `cargo xtask studio`, `cargo xtask screenshots`, `cargo xtask python`, `cargo xtask times`.
//!
//! Each is a sequence of cargo commands with their times; the first failure ends the sequence with its exit code.

mod bench;
mod cluster;
mod deploy;
mod features;
mod firmware;
mod kernel;
mod lint;
mod live;
mod mutate;
mod python;
mod screenshots;
mod step;
mod stress;
mod studio;
mod test;
mod times;
mod wasm;

use clap::{Parser, Subcommand, ValueEnum};
use std::path::{Path, PathBuf};
use std::process::ExitCode;
use std::time::Instant;
use step::{Failure, is_installed, program};

#[derive(Parser)]
#[command(name = "cargo xtask", about = "The workspace's own commands")]
struct Arguments {
    #[command(subcommand)]
    command: Command,
}

#[derive(Subcommand)]
enum Command {
    /// Reproduce the papers: claims.json, data, figures and report.html
    Reproduce {
        /// Output folder [default: target/reproduce]
        #[arg(long)]
        out: Option<PathBuf>,
    },
    /// All tests, and the examples in the documentation, two programs at a time
    Test {
        /// Seed of the random cases of the property tests
        #[arg(long, default_value_t = 2019)]
        seed: u64,
        /// As in CI: exports of every template (else of a third), and what is built apart (lmi without Clarabel,
        /// observers without dual numbers, all examples)
        #[arg(long)]
        all: bool,
    },
    /// The checks that run no test: format, features of dependencies, clippy, documentation, crates without some of
    /// their features, packages; licences and spelling where cargo-deny and typos are installed
    Lint,
    /// The times of the last run of each command, as a table
    Times {
        /// Put the table into docs/build.md as well
        #[arg(long)]
        document: bool,
    },
    /// Build the book of docs/ with mdbook: target/book/index.html
    Docs,
    /// Measure beside other tools (needs python3 and the network, for the other tools), or observers beside each other
    Bench {
        what: Subject,
        /// Only plants or matrices of at most this order (lmi, linalg), or sweeps of at most so many runs (sweep)
        #[arg(long)]
        largest: Option<usize>,
        /// Put the table into its page in docs as well (linalg, lmi, observers, sim, step, sweep)
        #[arg(long)]
        document: bool,
        /// Only this routine, as the tables name it; may be repeated (linalg)
        #[arg(long, conflicts_with = "document")]
        routine: Vec<String>,
        /// Instead of other tools an earlier commit of this repository, routine by routine (linalg)
        #[arg(long)]
        against: Option<String>,
        /// The folder of `.dat-s` files, from the root of the workspace (proof)
        #[arg(long, default_value = bench::proof::INSTANCES)]
        instances: PathBuf,
    },
    /// Test the claims on random and adversarial cases, with a table of the results
    Stress {
        what: Claimed,
        /// Number of cases (proof)
        #[arg(long, default_value_t = 1_000_000)]
        matrices: u64,
        /// Number of mutants of certificates for each theorem (theorems)
        #[arg(long, default_value_t = 100_000)]
        mutants: u64,
        /// Number of studies, over all kinds of observers (words)
        #[arg(long, default_value_t = 20_000)]
        studies: u64,
        /// Only the theorem of this name (theorems), or the kind of observer (words)
        #[arg(long)]
        kind: Option<String>,
        /// Designs only: no headers of exports, scores and alternatives (words)
        #[arg(long)]
        only_design: bool,
        /// Which cases
        #[arg(long, default_value_t = 2019)]
        seed: u64,
    },
    /// Build and run exports as their users do, the golden vectors bit for bit: C with CMake, FMUs with fmpy, Rust, its
    /// static library
    ///
    /// Says what it leaves out for lack of a tool (a C compiler, CMake, python3 and the network for fmpy).
    Deploy,
    /// Run a sweep on a SLURM with one node, started for it: a shard is killed, the results are those of one process
    ///
    /// Says so if SLURM is not installed.
    Cluster,
    /// Compile the theory in proofs/ and the files for Coq of templates and examples, and have false ones refused
    ///
    /// Says so if Coq is not installed.
    Kernel,
    /// Run the observers on boards in QEMU and emitted C on the host: the same bits everywhere, nothing can panic
    ///
    /// Says what it leaves out for lack of a tool (QEMU, targets of rustc, arm-none-eabi-gcc, clang, cppcheck).
    Firmware {
        /// Write what a step costs to docs/bench-target.md
        #[arg(long)]
        document: bool,
    },
    /// Build the WebAssembly module of reports, and compare its results in a browser with those of this machine
    ///
    /// Says so if the target of rustc or a browser (chromium) is not installed.
    Live {
        /// Leave the committed module as it is, and compare its results too
        #[arg(long)]
        check: bool,
    },
    /// Build the WebAssembly module of the studio, and compare its files with those of the command, in node; use the
    /// page in a browser
    ///
    /// Says what it leaves out for lack of a tool (the target of rustc, node, chromium).
    Studio {
        /// Leave the committed module as it is
        #[arg(long)]
        check: bool,
        /// Only these templates; may be repeated
        #[arg(long)]
        only: Vec<String>,
    },
    /// Write the pictures of README into docs/images from the program's own reports
    ///
    /// Says what it leaves out if no browser (chromium) is installed.
    Screenshots,
    /// Build the Python wheel and test it: pytest beside scipy, python-control, slycot and filterpy, notebooks,
    /// doctests, mypy and stubtest
    ///
    /// Says so and does nothing without python3 or the network.
    Python,
    /// Build what is given away of the Python package, into target/dist: a wheel for every Linux with glibc 2.17 or
    /// newer, and the sources
    ///
    /// The wheel of this machine is installed beside numpy alone and tried. Says so and does nothing without python3 or
    /// the network.
    Wheel {
        /// Target of rustc; may be repeated [default: this machine]
        #[arg(long)]
        target: Vec<String>,
    },
    /// Change the formulas of the papers one by one, in a copy, and show which tests notice (half an hour or more)
    ///
    /// Fails if a change that no test notices is not listed as equivalent in xtask/src/mutate/table; with --all, in
    /// .cargo/mutants.toml.
    Mutate {
        /// Only mutants with this in their names or in the paths of their files; may be repeated
        #[arg(long)]
        only: Vec<String>,
        /// Those that cargo-mutants finds in the files where results are formed (more than ten thousand, all of a
        /// package in one build)
        #[arg(long)]
        all: bool,
        #[command(flatten)]
        chosen: mutate::all::Chosen,
        /// Show the mutants and run nothing
        #[arg(long)]
        list: bool,
    },
}

impl Command {
    /// The name under which its times are kept: commands of CI.
    fn timed(&self) -> Option<&'static str> {
        match self {
            Self::Reproduce { .. } => Some("reproduce"),
            Self::Test { all: false, .. } => Some("test"),
            Self::Test { all: true, .. } => Some("test --all"),
            Self::Lint => Some("lint"),
            Self::Firmware { .. } => Some("firmware"),
            Self::Deploy => Some("deploy"),
            Self::Cluster => Some("cluster"),
            Self::Kernel => Some("kernel"),
            Self::Live { .. } => Some("live"),
            Self::Studio { .. } => Some("studio"),
            Self::Python => Some("python"),
            _ => None,
        }
    }
}

#[derive(Clone, Copy, ValueEnum)]
enum Claimed {
    /// Definiteness of matrices of numbers and of intervals, and the inequalities of Lyapunov, Stein and of feedback
    Proof,
    /// Certificates of random designs, changed and sealed again: the accepted ones against adversaries
    Theorems,
    /// Sentences of designs, failures and headers of exports for random studies: each against simulations
    Words,
}

#[derive(Clone, Copy, ValueEnum)]
enum Subject {
    /// Schur form, matrix equations and placement, beside scipy, slycot, python-control and Rust crates
    Linalg,
    /// The joint design of the cubic observer, beside cvxpy with Clarabel and with SCS
    Lmi,
    /// All kinds of observers on fifteen plants, tuned by `luenberger advise`; some minutes, without other tools
    Observers,
    /// Proved bounds of semidefinite programs, beside the published optima
    Proof,
    /// Trajectories, beside scipy and Rust crates
    Sim,
    /// One step of each sampled observer: time, operations, allocations
    Step,
    /// Sweeps, beside scipy: runs per second, memory, files, and what 1e9 runs cost
    Sweep,
}

fn main() -> ExitCode {
    let began = Instant::now();
    let command = Arguments::parse().command;
    let name = command.timed();
    let done = match command {
        Command::Reproduce { out } => reproduce(out.as_deref()),
        Command::Test { seed, all } => test::run(seed, all),
        Command::Lint => lint::run(),
        Command::Times { document } => times::run(document),
        Command::Docs => docs(),
        Command::Bench { what: Subject::Linalg, largest, document, against, routine, .. } => {
            bench::linalg::run(largest, &routine, document, against.as_deref())
        }
        Command::Bench { what: Subject::Lmi, largest, document, .. } => bench::lmi::run(largest, document),
        Command::Bench { what: Subject::Observers, document, .. } => bench::observers::run(document),
        Command::Bench { what: Subject::Proof, instances, .. } => bench::proof::run(&instances),
        Command::Bench { what: Subject::Sim, document, .. } => bench::sim::run(document),
        Command::Bench { what: Subject::Step, document, .. } => bench::sim::steps(document),
        Command::Bench { what: Subject::Sweep, largest, document, .. } => bench::sweep::run(largest, document),
        Command::Stress { what: Claimed::Proof, matrices, seed, .. } => stress::proof::run(matrices, seed),
        Command::Stress { what: Claimed::Theorems, mutants, seed, kind, .. } => {
            stress::theorems::run(mutants, seed, kind.as_deref())
        }
        Command::Stress { what: Claimed::Words, studies, seed, kind, only_design, .. } => {
            stress::words::run(studies, seed, kind.as_deref(), only_design)
        }
        Command::Cluster => cluster::run(),
        Command::Deploy => deploy::run(),
        Command::Kernel => kernel::run(),
        Command::Live { check } => live::run(check),
        Command::Studio { check, only } => studio::run(check, &only),
        Command::Screenshots => screenshots::run(),
        Command::Firmware { document } => firmware::run(document),
        Command::Python => python::run(),
        Command::Wheel { target } => python::wheel(&target),
        Command::Mutate { all: true, chosen, only, list } => mutate::all::run(&chosen, &only, list),
        Command::Mutate { only, list, .. } => mutate::run(&only, list),
    };
    match done.and_then(|()| name.map_or(Ok(()), |name| times::keep(name, began))) {
        Ok(()) => ExitCode::SUCCESS,
        Err(failure) => {
            eprintln!("xtask: {failure}");
            failure.exit_code()
        }
    }
}

/// Built and run in the development profile: dependencies are optimised in it too, and a newcomer, who runs the tests
/// as well, compiles them once.
fn reproduce(out: Option<&Path>) -> Result<(), Failure> {
    let out = match out {
        // Relative to where the user stands, while the steps run at the root.
        Some(out) => std::path::absolute(out).map_err(|source| Failure::io(out, source))?,
        None => step::root().join("target/reproduce"),
    };
    // The README's counts are those of the run.
    step::reproduction(&out)?.arguments(&["--counted-in", "README.md"]).step("reproduce")
}

fn docs() -> Result<(), Failure> {
    if is_installed("mdbook") {
        return program("mdbook").arguments(&["build", "docs"]).step("book");
    }
    skipped("the book", "mdbook");
    Err(Failure::Missing("mdbook"))
}

fn skipped(what: &str, package: &str) {
    eprintln!("── SKIPPED: {what}. To have it: cargo install --locked {package}");
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Each `cargo xtask ..` in a block of the README and of `docs/` is a command with its arguments.
    #[test]
    fn the_pages_name_commands_that_exist() {
        let mut count = 0;
        let pages = ["README.md", "CONTRIBUTING.md"].map(|page| step::root().join(page));
        let docs = std::fs::read_dir(step::root().join("docs")).unwrap().map(|entry| entry.unwrap().path());
        for page in pages.into_iter().chain(docs.filter(|page| page.extension().is_some_and(|md| md == "md"))) {
            let text = std::fs::read_to_string(&page).unwrap();
            for line in text.lines().filter(|line| line.starts_with("cargo xtask ")) {
                let words = line.split('#').next().unwrap_or(line).split_whitespace().skip(1);
                if let Err(error) = Arguments::try_parse_from(words) {
                    panic!("{}: {line}: {error}", page.display());
                }
                count += 1;
            }
        }
        assert!(count > 2, "{count} commands");
    }
}
