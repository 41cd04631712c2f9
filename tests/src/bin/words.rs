//! Stress test of the sentences of designs on random studies; fails if one is contradicted. `cargo xtask stress words`,
//! or `cargo run --release -p luenberger-tests --bin words -- --studies 20000 --seed 2019`.

use std::process::ExitCode;
use std::time::Instant;

use luenberger_tests::words::{Class, Extent, falsify, generated, hold};

fn main() -> ExitCode {
    let (mut studies, mut seed, mut kind, mut extent) = (20_000_u64, 2019_u64, None, Extent::All);
    let mut files = Vec::new();
    let mut arguments = std::env::args().skip(1);
    while let Some(name) = arguments.next() {
        let is_read = match name.as_str() {
            "--only-design" => {
                extent = Extent::Designs;
                true
            }
            "--studies" => arguments.next().and_then(|value| value.parse().ok()).map(|value| studies = value).is_some(),
            "--seed" => arguments.next().and_then(|value| value.parse().ok()).map(|value| seed = value).is_some(),
            "--kind" => {
                let value = arguments.next().unwrap_or_default();
                generated().iter().find(|known| **known == value).map(|known| kind = Some(*known)).is_some()
            }
            "--study" => arguments.next().map(|file| files.push(file)).is_some(),
            _ => false,
        };
        if !is_read {
            let kinds = generated().join(", ");
            eprintln!(
                "usage: words [--studies N] [--seed S] [--kind K] [--only-design] [--study FILE ..], K one of {kinds}"
            );
            return ExitCode::from(2);
        }
    }
    // A panic of a design is a finding, which is printed with its study.
    std::panic::set_hook(Box::new(|_| ()));
    if !files.is_empty() {
        return of_files(&files, extent);
    }
    println!("seed {seed}\n");
    println!(
        "| kind | studies | designed | proved | none found | sentences | by simulation | computed | contradicted | rounded | unknown | crashes | alternatives | s |"
    );
    println!("|---|---:|---:|---:|---:|---:|---:|---:|---:|---:|---:|---:|---:|---:|");
    let kinds: Vec<&str> = generated().into_iter().filter(|known| kind.is_none_or(|kind| kind == *known)).collect();
    // Tables and searches of a cost take seconds each: they have a fiftieth of the share of the other kinds.
    let share = |kind: &str| if matches!(kind, "kkl-numerical" | "optimal-cubic") { 1 } else { 50 };
    let all: u64 = kinds.iter().map(|kind| share(kind)).sum();
    let (mut wrong, mut before) = (0, 0);
    for kind in &kinds {
        let start = Instant::now();
        let first = studies * before / all;
        before += share(kind);
        let of_kind = studies * before / all - first;
        let tally = falsify(kind, of_kind, seed, extent);
        println!(
            "| {kind} | {} | {} | {} | {} | {} | {} | {} | {} | {} | {} | {} | {} | {:.0} |",
            tally.studies,
            tally.designed,
            tally.proved,
            tally.refused,
            tally.sentences,
            tally.simulated,
            tally.computed,
            tally.count(Class::Contradiction),
            tally.count(Class::Rounding),
            tally.count(Class::Unknown),
            tally.count(Class::Crash),
            tally.count(Class::Alternative),
            start.elapsed().as_secs_f64()
        );
        let mut printed: Vec<(Class, Option<_>)> = Vec::new();
        for finding in &tally.findings {
            let class = (finding.class, finding.claim);
            if printed.iter().filter(|other| **other == class).count() < 2 {
                eprintln!("{finding}\n");
            }
            printed.push(class);
        }
        wrong += tally.findings.iter().filter(|finding| finding.class != Class::Alternative).count();
    }
    if wrong == 0 { ExitCode::SUCCESS } else { ExitCode::FAILURE }
}

/// Holds studies of files.
fn of_files(files: &[String], extent: Extent) -> ExitCode {
    let mut wrong = 0;
    for file in files {
        let Ok(text) = std::fs::read_to_string(file) else {
            eprintln!("{file} cannot be read");
            return ExitCode::from(2);
        };
        println!("{file}");
        let mut seen = Vec::new();
        for seed in 0..6 {
            for finding in hold(&text, seed, extent).findings {
                let key = (finding.class, finding.claim, finding.observer.clone());
                if !seen.contains(&key) {
                    println!(
                        "  {:?} {} ({}): {}\n    but {}",
                        finding.class, finding.observer, finding.kind, finding.sentence, finding.why
                    );
                    seen.push(key);
                }
            }
        }
        wrong += seen.iter().filter(|(class, ..)| *class != Class::Alternative).count();
    }
    if wrong == 0 { ExitCode::SUCCESS } else { ExitCode::FAILURE }
}
