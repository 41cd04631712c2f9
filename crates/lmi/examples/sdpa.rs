//! Rigorous bounds of a semidefinite program in SDPA's sparse format: `cargo run --release -p luenberger-lmi --example sdpa -- FILE [--json]`.

use std::fs::File;
use std::io::BufReader;
use std::process::ExitCode;
use std::time::Instant;

use luenberger_lmi::sdpa::{Outcome, Settings, Status, read, solve};

fn main() -> ExitCode {
    let (mut file, mut json) = (None, false);
    for argument in std::env::args().skip(1) {
        if argument == "--json" { json = true } else { file = Some(argument) }
    }
    let Some(file) = file else {
        eprintln!("usage: sdpa FILE.dat-s [--json]");
        return ExitCode::from(2);
    };
    let start = Instant::now();
    let program = match File::open(&file)
        .map_err(|e| e.to_string())
        .and_then(|f| read(BufReader::new(f)).map_err(|e| e.to_string()))
    {
        Ok(program) => program,
        Err(error) => {
            eprintln!("{file}: {error}");
            return ExitCode::FAILURE;
        }
    };
    let outcome = solve(&program, &Settings::default());
    let seconds = start.elapsed().as_secs_f64();
    if json {
        println!("{}", as_json(&outcome, seconds));
    } else {
        println!(
            "{} after {seconds:.3} s ({} runs of the solver, which said: {})",
            word(outcome.status),
            outcome.runs,
            outcome.word
        );
        println!("{:e} <= optimum <= {:e}", outcome.lower, outcome.upper);
    }
    ExitCode::SUCCESS
}

fn word(status: Status) -> &'static str {
    match status {
        Status::Bounds => "proved-optimal-bounds",
        Status::PrimalInfeasible => "proved-primal-infeasible",
        Status::DualInfeasible => "proved-dual-infeasible",
        Status::Undecided => "undecided",
    }
}

fn as_json(outcome: &Outcome, seconds: f64) -> String {
    let number = |x: f64| if x.is_finite() { format!("{x:e}") } else { "null".to_owned() };
    format!(
        "{{ \"status\": \"{}\", \"lower\": {}, \"upper\": {}, \"primal_margin\": {}, \"seconds\": {seconds}, \"solve_seconds\": {}, \"verify_seconds\": {}, \"runs\": {} }}",
        word(outcome.status),
        number(outcome.lower),
        number(outcome.upper),
        outcome.primal_margin.map_or("null".to_owned(), number),
        outcome.solving.as_secs_f64(),
        outcome.verifying.as_secs_f64(),
        outcome.runs
    )
}
