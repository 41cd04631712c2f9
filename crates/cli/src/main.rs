//! The command `luenberger`: reads arguments and files, calls the library, and prints. It contains no control theory.
//!
//! Standard output has only the result: text, or with `--json` one JSON object. Errors and progress go to standard
//! error. The exit code is 0 for success, 1 for a negative answer (no solution, not proved) or output that cannot be
//! written, 2 for invalid input (usage, files, data), 130 after Ctrl-C.

mod answer;
mod arguments;
mod examples;
mod exit;
mod failure;
mod import;
mod input;
mod limit;
mod matrix;
mod numbers;
mod output;
mod progress;
mod sdp;
mod shell;
mod studio;
mod study;
mod verify;

use answer::Answer;
use arguments::{Arguments, Command};
use clap::Parser;
use failure::Failure;
use input::given;
use luenberger_study::Step;
use output::Volume;
use std::process::ExitCode;

fn main() -> ExitCode {
    let words = std::env::args_os().map(given::bracketed);
    let arguments = match Arguments::try_parse_from(words) {
        Ok(arguments) => arguments,
        Err(error) => return arguments::refused(&error),
    };
    let json = arguments.json;
    output::set_volume(match (arguments.quiet, arguments.verbose) {
        (true, _) => Volume::Quiet,
        (_, true) => Volume::Verbose,
        _ => Volume::Normal,
    });
    match run(arguments.command) {
        Ok(answer) => answer.deliver(json),
        Err(failure) => failure.report(json),
    }
}

fn run(command: Command) -> Result<Answer, Failure> {
    match command {
        Command::New(input) => study::new(&input),
        Command::Run(input) => study::run(&input),
        Command::Observe(input) => study::step(Step::Observe, &input),
        Command::Design(input) => study::step(Step::Design, &input),
        Command::Certify(input) => study::step(Step::Certify, &input),
        Command::Simulate(input) => study::step(Step::Simulate, &input),
        Command::Compare(input) => study::step(Step::Compare, &input),
        Command::Advise(input) => study::advise(&input),
        Command::Tune(input) => study::tune(&input),
        Command::Sweep(input) => study::sweep(&input),
        Command::Export(input) => study::export(&input),
        Command::Stream(input) => study::stream(&input),
        Command::Lyap(input) => matrix::lyapunov::lyap(&input),
        Command::Dlyap(input) => matrix::lyapunov::dlyap(&input),
        Command::Sylv(input) => matrix::sylvester::sylv(input.data.given()),
        Command::Care(input) => matrix::riccati::care(input.data.given()),
        Command::Dare(input) => matrix::riccati::dare(input.data.given()),
        Command::Place(input) => matrix::placement::place(&input),
        Command::Obsv(input) => matrix::observability::obsv(&input),
        Command::Eig(input) => matrix::spectrum::eig(input.data.given()),
        Command::Bode(input) => matrix::bode::bode(&input),
        Command::C2d(input) => matrix::conversion::c2d(&input),
        Command::D2c(input) => matrix::conversion::d2c(&input),
        Command::Noise(input) => matrix::noise::noise(&input),
        Command::Poles(input) => matrix::poles::poles(&input),
        Command::Import(import) => import::import(&import),
        Command::Verify(input) => verify::verify(&input),
        Command::Sdp(sdp) => sdp::sdp(&sdp.file, sdp.solver.into()),
        Command::Studio(input) => studio::studio(&input),
        Command::Completions(input) => Ok(shell::completions(input.shell)),
        Command::Man(input) => shell::manual(&input.output),
    }
}
