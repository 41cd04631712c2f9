//! Reproduces the papers: `luenberger-reproduce [OPTIONS] [OUT]`, with default `target/reproduce` for `OUT`.

use clap::Parser;
use luenberger_reproduce::terminal::{self, Filter};
use luenberger_reproduce::{Class, Verdict};
use std::io::IsTerminal;
use std::path::{Path, PathBuf};
use std::process::ExitCode;

/// Reproduce the papers: every figure, number and theorem with a verdict, as claims.json, data, figures and
/// report.html.
#[derive(Parser)]
#[command(
    name = "luenberger-reproduce",
    version,
    after_help = "Exit code: 0 if every claim could be checked, 1 if one could not, a refutation shows no ground, a file could not be written or a page counts otherwise, 2 for wrong arguments."
)]
struct Arguments {
    /// The folder to write, which is made if it is not there
    #[arg(default_value = "target/reproduce")]
    out: PathBuf,
    /// Show only claims of this class; may be repeated. All claims are checked and written
    #[arg(long, value_enum, value_name = "CLASS")]
    class: Vec<Class>,
    /// Show only claims with this verdict; may be repeated
    #[arg(long, value_enum, value_name = "VERDICT")]
    verdict: Vec<Verdict>,
    /// Fail unless this page holds the counts of the run, line by line
    #[arg(long, value_name = "PAGE")]
    counted_in: Option<PathBuf>,
    /// Only write the refutations for Coq into this folder, and check no claim
    #[arg(long, value_name = "FOLDER")]
    coq: Option<PathBuf>,
}

fn main() -> ExitCode {
    let Arguments { out, class: classes, verdict: verdicts, counted_in, coq } = Arguments::parse();
    if let Some(folder) = coq {
        return match luenberger_reproduce::write_refutations(&luenberger_reproduce::papers(), &folder) {
            Ok(count) => {
                println!("{count} refutations for Coq: {}", folder.display());
                ExitCode::SUCCESS
            }
            Err(error) => {
                eprintln!("error: {error}");
                ExitCode::FAILURE
            }
        };
    }
    match luenberger_reproduce::run(&out) {
        Ok(summary) => {
            println!("{}", terminal::table(&summary, &Filter { classes, verdicts }, std::io::stdout().is_terminal()));
            println!("report: {}", out.join("report.html").display());
            let counted = counted_in.is_none_or(|page| counted(&page, &terminal::headline(&summary)));
            if summary.is_complete() && counted { ExitCode::SUCCESS } else { ExitCode::FAILURE }
        }
        Err(error) => {
            eprintln!("error: {error}");
            ExitCode::FAILURE
        }
    }
}

/// Whether the page contains these lines; prints a message if it does not.
fn counted(page: &Path, lines: &str) -> bool {
    match std::fs::read_to_string(page) {
        Ok(text) if text.contains(lines) => true,
        Ok(_) => {
            eprintln!("error: {} does not hold the counts of this run:\n{lines}", page.display());
            false
        }
        Err(error) => {
            eprintln!("error: {}: {error}", page.display());
            false
        }
    }
}
