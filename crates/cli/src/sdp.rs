//! `luenberger sdp`: rigorous bounds on the optimum of a semidefinite program.

use crate::answer::Answer;
use crate::failure::Failure;
use crate::input::Source;
use crate::progress::Spinner;
use luenberger_lmi::Solver;
use luenberger_lmi::sdpa::{Settings, Status, read, solve};
use std::fs::File;
use std::io::{self, BufReader};
use std::time::Instant;

pub(crate) fn sdp(source: &Source, solver: Solver) -> Result<Answer, Failure> {
    let origin = || source.to_string();
    let start = Instant::now();
    let program = match source {
        Source::Standard => read(io::stdin().lock()),
        Source::File(path) => {
            let file = File::open(path).map_err(|error| Failure::Read { origin: origin(), error })?;
            read(BufReader::new(file))
        }
    };
    let program = program.map_err(|error| Failure::Sdp { origin: origin(), error })?;
    let spinner = Spinner::new("solving and proving");
    let outcome = solve(&program, &Settings { solver, ..Settings::default() });
    drop(spinner);
    let seconds = start.elapsed().as_secs_f64();
    let answer = Answer::written(outcome.sentence(seconds), outcome.json(seconds));
    Ok(answer.negative(outcome.status == Status::Undecided))
}
