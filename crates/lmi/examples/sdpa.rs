//! Rigorous bounds of a semidefinite program in SDPA's sparse format:
//! `cargo run --release -p luenberger-lmi --example sdpa -- FILE [--json] [--seconds N] [--certificate FILE]`.
//!
//! With `--certificate`, the proof is written to a file that `luenberger-verify` checks without a solver.

use std::ffi::OsStr;
use std::fs::File;
use std::io::BufReader;
use std::path::Path;
use std::process::ExitCode;
use std::time::{Duration, Instant};

use luenberger_lmi::sdpa::{Settings, read, solve};

fn main() -> ExitCode {
    let (mut file, mut json, mut settings, mut certificate) = (None, false, Settings::default(), None);
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
            "--certificate" => {
                certificate = arguments.next();
                is_understood &= certificate.is_some();
            }
            _ => file = Some(argument),
        }
    }
    let Some(file) = file.filter(|_| is_understood) else {
        eprintln!("usage: sdpa FILE.dat-s [--json] [--seconds N] [--certificate FILE]");
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
    if let Some(to) = certificate {
        let title = Path::new(&file).file_name().map_or(file.as_str().into(), OsStr::to_string_lossy);
        let written =
            outcome.certificate_file(&program, &title).map_err(|error| error.to_string()).and_then(|certificate| {
                std::fs::write(&to, certificate.to_json()).map_err(|error| format!("{to}: {error}"))
            });
        if let Err(error) = written {
            eprintln!("{error}");
            return ExitCode::FAILURE;
        }
    }
    ExitCode::SUCCESS
}
