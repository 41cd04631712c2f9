//! Stress test of the verdicts on millions of random and adversarial matrices; fails if any verdict is wrong. `cargo
//! xtask stress proof`, or `cargo run --release -p luenberger-proof --example stress -- --matrices 1000000 --seed
//! 2019`.

#[path = "../tests/it/adversaries/mod.rs"]
mod adversaries;

use std::process::ExitCode;
use std::sync::Mutex;
use std::sync::atomic::{AtomicU64, Ordering};
use std::time::Instant;

use adversaries::Tally;
use indicatif::{ProgressBar, ProgressStyle};

/// How many cases a thread takes at a time.
const PORTION: u64 = 500;

fn main() -> ExitCode {
    let (mut matrices, mut seed) = (1_000_000_u64, 2019_u64);
    let mut arguments = std::env::args().skip(1);
    while let Some(name) = arguments.next() {
        let value = arguments.next().and_then(|value| value.parse().ok());
        match (name.as_str(), value) {
            ("--matrices", Some(value)) => matrices = value,
            ("--seed", Some(value)) => seed = value,
            _ => {
                eprintln!("usage: stress [--matrices N] [--seed S]");
                return ExitCode::from(2);
            }
        }
    }
    let start = Instant::now();
    let sums = run(matrices, seed);
    print(&sums, matrices, seed, start.elapsed().as_secs_f64());
    let wrong: Vec<&String> = sums.iter().flat_map(|sum| &sum.wrong).collect();
    for case in wrong.iter().take(20) {
        eprintln!("{case}");
    }
    if wrong.is_empty() { ExitCode::SUCCESS } else { ExitCode::FAILURE }
}

fn run(matrices: u64, seed: u64) -> Vec<Tally> {
    let bar = ProgressBar::new(matrices);
    if let Ok(style) = ProgressStyle::with_template("{bar:40} {human_pos}/{human_len} cases, {eta} left, {msg}") {
        bar.set_style(style);
    }
    bar.set_message("none wrong");
    let sums = Mutex::new(vec![Tally::default(); adversaries::kinds().len()]);
    let next = AtomicU64::new(0);
    let threads = std::thread::available_parallelism().map_or(1, std::num::NonZero::get);
    std::thread::scope(|scope| {
        for _ in 0..threads {
            scope.spawn(|| {
                loop {
                    let first = next.fetch_add(PORTION, Ordering::Relaxed);
                    if first >= matrices {
                        return;
                    }
                    let last = (first + PORTION).min(matrices);
                    let mut here = vec![Tally::default(); adversaries::kinds().len()];
                    for number in first..last {
                        let (kind, tally) = adversaries::examine(seed, number);
                        here[kind].add(tally);
                    }
                    // Sums do not depend on who adds first.
                    let mut sums = sums.lock().unwrap_or_else(std::sync::PoisonError::into_inner);
                    sums.iter_mut().zip(here).for_each(|(sum, here)| sum.add(here));
                    let wrong: usize = sums.iter().map(|sum| sum.wrong.len()).sum();
                    if wrong > 0 {
                        bar.set_message(format!("{wrong} WRONG"));
                    }
                    bar.inc(last - first);
                }
            });
        }
    });
    bar.finish_and_clear();
    sums.into_inner().unwrap_or_else(std::sync::PoisonError::into_inner)
}

fn print(sums: &[Tally], matrices: u64, seed: u64, seconds: f64) {
    println!("{matrices} cases, seed {seed}, {seconds:.0} s\n");
    println!("| family | cases | verdicts | proved | refuted | undecided | of these decidable | wrong |");
    println!("|---|---:|---:|---:|---:|---:|---:|---:|");
    let mut total = Tally::default();
    for (name, sum) in adversaries::kinds().iter().zip(sums) {
        row(name, sum);
        total.add(sum.clone());
    }
    row("all", &total);
}

fn row(name: &str, sum: &Tally) {
    println!(
        "| {name} | {} | {} | {} | {} | {} | {} | {} |",
        sum.cases,
        sum.proved + sum.refuted + sum.undecided,
        sum.proved,
        sum.refuted,
        sum.undecided,
        sum.missed,
        sum.wrong.len()
    );
}
