//! Rigorous bounds of a semidefinite program in SDPA's sparse format:
//! `cargo run --release -p luenberger-lmi --example sdpa -- FILE [--json] [--seconds N]`.

use std::fs::File;
use std::io::BufReader;
use std::process::ExitCode;
use std::time::{Duration, Instant};

use luenberger_lmi::sdpa::{Outcome, Settings, Status, read, solve};

fn main() -> ExitCode {
    let (mut file, mut json, mut settings) = (None, false, Settings::default());
    let mut arguments = std::env::args().skip(1);
    let mut is_understood = true;
    while let Some(argument) = arguments.next() {
        match argument.as_str() {
            "--json" => json = true,
            "--seconds" => {
                let seconds = arguments.next().and_then(|n| n.parse().ok());
                settings.time = seconds.and_then(|n| Duration::try_from_secs_f64(n).ok());
                is_understood &= settings.time.is_some();
            }
            _ => file = Some(argument),
        }
    }
    let Some(file) = file.filter(|_| is_understood) else {
        eprintln!("usage: sdpa FILE.dat-s [--json] [--seconds N]");
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
    let outcome = solve(&program, &settings);
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
        if let Some(why) = outcome.why {
            println!("{why}");
        }
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
        "{{ \"status\": \"{}\", \"lower\": {}, \"upper\": {}, \"primal_margin\": {}, \"seconds\": {seconds}, \"solve_seconds\": {}, \"verify_seconds\": {}, \"runs\": {}, \"reason\": {} }}",
        word(outcome.status),
        number(outcome.lower),
        number(outcome.upper),
        outcome.primal_margin.map_or("null".to_owned(), number),
        outcome.solving.as_secs_f64(),
        outcome.verifying.as_secs_f64(),
        outcome.runs,
        outcome.why.map_or("null".to_owned(), |why| format!("\"{why}\""))
    )
}
