//! Stress test of the checker on hundreds of thousands of mutated certificates; fails if an accepted one is wrong.
//! `cargo xtask stress theorems`, or `cargo run --release -p luenberger-tests --bin falsify -- --mutants 100000 --seed
//! 2019`. With `--coq FOLDER` it writes forged files for Coq instead, of as many refuted mutants of each theorem.

use std::path::{Path, PathBuf};
use std::process::ExitCode;
use std::time::Instant;

use luenberger_proof::coq;
use luenberger_tests::falsify::{falsify, forged, kinds};

fn main() -> ExitCode {
    let (mut mutants, mut seed, mut kind, mut folder) = (100_000_u64, 2019_u64, None, None);
    let mut arguments = std::env::args().skip(1);
    while let Some(name) = arguments.next() {
        let value = arguments.next().unwrap_or_default();
        let is_read = match name.as_str() {
            "--mutants" => value.parse().map(|value| mutants = value).is_ok(),
            "--seed" => value.parse().map(|value| seed = value).is_ok(),
            "--coq" => {
                folder = Some(PathBuf::from(&value));
                !value.is_empty()
            }
            "--kind" => kinds().iter().find(|known| **known == value).map(|known| kind = Some(*known)).is_some(),
            _ => false,
        };
        if !is_read {
            eprintln!(
                "usage: falsify [--mutants N] [--seed S] [--kind K] [--coq FOLDER], K one of {}",
                kinds().join(", ")
            );
            return ExitCode::from(2);
        }
    }
    if let Some(folder) = folder {
        return forge(&folder, usize::try_from(mutants).unwrap_or(usize::MAX), seed);
    }
    println!("seed {seed}\n");
    println!("| theorem | certificates | mutants | accepted | refused | of these tried | contradicted | wrong | s |");
    println!("|---|---:|---:|---:|---:|---:|---:|---:|---:|");
    let mut wrong = 0;
    for kind in kinds().iter().filter(|known| kind.is_none_or(|kind| kind == **known)) {
        let start = Instant::now();
        let tally = falsify(kind, mutants, seed);
        println!(
            "| {kind} | {} | {} | {} | {} | {} | {} | {} | {:.0} |",
            tally.certificates,
            tally.mutants,
            tally.accepted,
            tally.refused,
            tally.tried,
            tally.convicted,
            tally.wrong.len(),
            start.elapsed().as_secs_f64()
        );
        for case in tally.wrong.iter().take(5) {
            eprintln!("{case}\n");
        }
        wrong += tally.wrong.len();
    }
    if wrong == 0 { ExitCode::SUCCESS } else { ExitCode::FAILURE }
}

/// Writes forged files of this number of mutants of each theorem that has files for Coq.
fn forge(folder: &Path, mutants: usize, seed: u64) -> ExitCode {
    let write = || -> std::io::Result<()> {
        for kind in coq::KINDS {
            for file in forged(kind, mutants, seed) {
                for (part, text) in
                    [("designs", file.design), ("mutants", file.mutant), ("without_margins", file.without_margins)]
                {
                    std::fs::create_dir_all(folder.join(part))?;
                    std::fs::write(folder.join(part).join(format!("{}.v", file.name)), text)?;
                }
            }
        }
        Ok(())
    };
    match write() {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("error: {}: {error}", folder.display());
            ExitCode::FAILURE
        }
    }
}
