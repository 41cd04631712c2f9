//! Rigorous bounds of a semidefinite program in SDPA's sparse format:
//! `cargo run --release -p luenberger-lmi --example sdpa -- FILE [--json] [--seconds N]`.

use std::fs::File;
use std::io::BufReader;
use std::process::ExitCode;
use std::time::{Duration, Instant};

use luenberger_lmi::sdpa::{Settings, read, solve};

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
        println!("{}", outcome.json(seconds));
    } else {
        print!("{}", outcome.sentence(seconds));
    }
    ExitCode::SUCCESS
}
