//! Reproduces the papers: `luenberger-reproduce [OUT]`, with `target/reproduce` for `OUT` if it is not given.

use luenberger_reproduce::terminal;
use std::io::IsTerminal;
use std::path::PathBuf;
use std::process::ExitCode;

fn main() -> ExitCode {
    let out = std::env::args_os().nth(1).map_or_else(|| PathBuf::from("target/reproduce"), PathBuf::from);
    match luenberger_reproduce::run(&out) {
        Ok(summary) => {
            println!("{}", terminal::table(&summary, std::io::stdout().is_terminal()));
            println!("report: {}", out.join("report.html").display());
            if summary.is_complete() { ExitCode::SUCCESS } else { ExitCode::FAILURE }
        }
        Err(error) => {
            eprintln!("error: {error}");
            ExitCode::FAILURE
        }
    }
}
