//! `luenberger sdp`: rigorous bounds on the optimum of a semidefinite program.

use crate::answer::Answer;
use crate::failure::Failure;
use crate::progress::Spinner;
use luenberger_lmi::Solver;
use luenberger_lmi::sdpa::{Settings, Status, read, solve};
use std::fs::File;
use std::io::BufReader;
use std::path::Path;
use std::time::Instant;

pub(crate) fn sdp(path: &Path, solver: Solver) -> Result<Answer, Failure> {
    let origin = || path.display().to_string();
    let start = Instant::now();
    let file = File::open(path).map_err(|error| Failure::Read { origin: origin(), error })?;
    let program = read(BufReader::new(file)).map_err(|error| Failure::Sdp { origin: origin(), error })?;
    let spinner = Spinner::new("solving and proving");
    let outcome = solve(&program, &Settings { solver, ..Settings::default() });
    drop(spinner);
    let seconds = start.elapsed().as_secs_f64();
    let answer = Answer::written(outcome.sentence(seconds), outcome.json(seconds));
    Ok(answer.negative(outcome.status == Status::Undecided))
}
