//! Placeholder of the first landing.
use crate::error::LmiError;
use crate::problem::{Problem, Settings};
use crate::solution::{Effort, Solution};
use luenberger_proof::{Doubt, Verdict};

pub(crate) fn solve(problem: &Problem, settings: &Settings) -> Result<Solution, LmiError> {
    let _ = (problem, settings.iterations);
    let why = Doubt::NoProposal { status: "not attempted" };
    Ok(Solution {
        verdict: Verdict::Undecided { why, best: f64::NEG_INFINITY },
        margins: vec![],
        objective: None,
        effort: Effort { iterations: 0, status: "not attempted" },
        values: vec![],
    })
}
