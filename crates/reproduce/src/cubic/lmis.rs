//! (12) with (13), (12) with (13') and (25) as linear matrix inequalities in all of their unknowns, each solved by both
//! solvers.
//!
//! The solvers are not trusted: a problem counts as feasible if the returned values are verified, and as infeasible if
//! the multipliers are verified exactly.

use std::fmt;

use luenberger_design::{CubicGain, LinearDesign};
use luenberger_linalg::lqr;
use luenberger_lmi::{Problem, Settings, Solver, block, he};
use luenberger_plants::{StateSpace, double_integrator, third_order};
use luenberger_proof::Verdict;
use nalgebra::DMatrix;

use super::random::{Random, SEED};
use super::theorems::random_designs;
use crate::claim::{CheckError, Claim, Class, Outcome};
use crate::context::Context;
use crate::evidence::Evidence;
use crate::value::short;

const PLANTS: &str = "the plants of Examples 1 and 3, and random plants with n = 1..4, p ≤ n";

pub(super) fn claims() -> Vec<Claim> {
    vec![
        Claim::holds(
            Class::Ours,
            "cubic.lmi.strict",
            "beyond the paper, (12) and (13)",
            "in P, Y = PL and Z = PN, (12) and (13) have a solution where C has n rows and none where it has fewer: by two solvers",
            &[PLANTS],
            strict,
        ),
        Claim::holds(
            Class::Ours,
            "cubic.lmi.nonstrict",
            "beyond the paper, (12) and (13')",
            "in P, Y = PL and S with PN = -C'S, S + S' > 0, (12) and (13') have a solution for every observable plant: by two solvers",
            &[PLANTS],
            nonstrict,
        ),
        Claim::holds(
            Class::Theorem,
            "cubic.thm6.lmi",
            "Theorem 6, (25)",
            "(25) with P, P1 > 0 is feasible if A - BK and A - LC are Hurwitz, and only if: solved as an inequality in both unknowns, by two solvers",
            &[
                "the plants of Examples 1 and 3 with K and L by their Riccati equations, and random plants with n = 1..5, p ≤ n, with L by poles; each also with -(A - BK) and with -(A - LC)",
            ],
            feedback,
        )
        .quoting(
            "The closed loop control system governed by (1), (5) and (24) is stable if the positive definite symmetric matrices P, P_1 fulfill (25). [..] Note that stability of (A - BK) \
             and (A - L_cC) is necessary for (25).",
            "P is an unknown of (25), as P1 is; N = -P⁻¹C'S follows from the P that is found",
        ),
    ]
}

const SOLVERS: [Solver; 2] = [Solver::Interior, Solver::Clarabel];

/// The answers of one solver, counted.
#[derive(Default)]
struct Answers {
    solver: Solver,
    feasible: usize,
    infeasible: usize,
    undecided: usize,
    least_margin: Option<f64>,
    iterations: u32,
}

impl fmt::Display for Answers {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { solver, feasible, infeasible, undecided, iterations, .. } = self;
        write!(f, "{solver}: {feasible} proved")?;
        if let Some(margin) = self.least_margin {
            write!(f, " with margins from {} up", short(margin))?;
        }
        write!(f, ", {infeasible} refuted by exact multipliers, {undecided} undecided, {iterations} iterations.")
    }
}

/// Whether each solver reaches the expected result for an inequality; none if undecided.
type Expected = [Option<bool>; 2];

/// The results of the two solvers for each inequality, and their answers as text.
fn answers(problems: &[(Problem, bool)]) -> Result<(Vec<Expected>, String), CheckError> {
    let mut truths = vec![[None; 2]; problems.len()];
    let mut said = vec![format!("{} inequalities, each solved twice. Seed {SEED}.", problems.len())];
    for (column, solver) in SOLVERS.into_iter().enumerate() {
        let settings = Settings { solver, ..Settings::default() };
        let mut answers = Answers { solver, ..Answers::default() };
        for ((lmi, is_feasible), truths) in problems.iter().zip(&mut truths) {
            let solution = lmi.solve_with(&settings)?;
            answers.iterations += solution.effort.iterations;
            let found = match &solution.verdict {
                Verdict::Proved { margin } => {
                    answers.feasible += 1;
                    answers.least_margin = Some(answers.least_margin.map_or(*margin, |least| least.min(*margin)));
                    Some(true)
                }
                Verdict::Refuted { witness } if lmi.is_refuted_by(witness) => {
                    answers.infeasible += 1;
                    Some(false)
                }
                _ => {
                    answers.undecided += 1;
                    None
                }
            };
            truths[column] = found.map(|found| found == *is_feasible);
        }
        said.push(answers.to_string());
    }
    Ok((truths, said.join(" ")))
}

/// Each solver has to come to each expectation.
fn by_both(problems: &[(Problem, bool)]) -> Result<Outcome, CheckError> {
    let (truths, said) = answers(problems)?;
    Ok(Outcome::new(Evidence::cases(truths.concat())).note(said))
}

/// A proof by one solver decides an inequality, unless the other contradicts it.
fn by_either(problems: &[(Problem, bool)]) -> Result<Outcome, CheckError> {
    let (truths, said) = answers(problems)?;
    let decided = |truths: &Expected| truths.iter().copied().flatten().reduce(|one, other| one && other);
    Ok(Outcome::new(Evidence::cases(truths.iter().map(decided))).note(format!(
        "{said} An answer that is proved decides; cubic.thm6 keeps the P of the observer and scales P1."
    )))
}

fn plants() -> Result<Vec<StateSpace>, CheckError> {
    let mut random = Random::new();
    let mut plants = vec![double_integrator().to_dynamic(), third_order::example3().to_dynamic()];
    for n in 1..=4 {
        for p in 1..=n {
            plants.push(random.plant(n, p)?);
        }
    }
    Ok(plants)
}

/// `P > 0` and (12) with `Y = PL`.
fn observer(lmi: &mut Problem, plant: &StateSpace) {
    let (n, outputs) = (plant.a.nrows(), plant.c.nrows());
    let (p, y) = (lmi.symmetric("P", n), lmi.rectangular("Y", n, outputs));
    lmi.constrain("P > 0", &p >> 0.0);
    lmi.constrain("(12)", he(&p * &plant.a - &y * &plant.c) << 0.0);
}

fn strict(_: &Context) -> Result<Outcome, CheckError> {
    let pose = |plant: &StateSpace| {
        let (outputs, n) = plant.c.shape();
        let mut lmi = Problem::new();
        observer(&mut lmi, plant);
        let z = lmi.rectangular("Z", n, outputs);
        lmi.constrain("(13)", he(&z * &plant.c) << 0.0);
        (lmi, outputs == n)
    };
    by_both(&plants()?.iter().map(pose).collect::<Vec<_>>())
}

fn nonstrict(_: &Context) -> Result<Outcome, CheckError> {
    let pose = |plant: &StateSpace| {
        let outputs = plant.c.nrows();
        let mut lmi = Problem::new();
        observer(&mut lmi, plant);
        let s = lmi.rectangular("S", outputs, outputs);
        lmi.constrain("S + S' > 0", he(&s) >> 0.0);
        (lmi, true)
    };
    by_both(&plants()?.iter().map(pose).collect::<Vec<_>>())
}

/// Each design as it is, and with A - BK or A - LC made unstable by a sign.
fn feedback(_: &Context) -> Result<Outcome, CheckError> {
    let mut designs = Vec::new();
    for plant in [double_integrator().to_dynamic(), third_order::example3().to_dynamic()] {
        let (n, outputs) = (plant.a.nrows(), plant.c.nrows());
        let linear = LinearDesign::kalman(&plant, &DMatrix::identity(n, n), &DMatrix::identity(outputs, outputs))?;
        designs.push((plant, linear.error_matrix()));
    }
    for design in random_designs(|_, _| CubicGain::Gamma(1.0))? {
        let o = &design.observer;
        designs.push((StateSpace::new(o.a.clone(), o.b.clone(), o.c.clone())?, design.error_matrix()));
    }
    let mut problems = Vec::new();
    for (plant, error) in &designs {
        let (n, inputs) = plant.b.shape();
        let k = lqr(&plant.a, &plant.b, &DMatrix::identity(n, n), &DMatrix::identity(inputs, inputs))?.k;
        let coupling = &plant.b * &k;
        let closed = &plant.a - &coupling;
        for (closed, error, is_feasible) in
            [(&closed, error, true), (&-&closed, error, false), (&closed, &-error, false)]
        {
            let mut lmi = Problem::new();
            let (p1, p) = (lmi.symmetric("P1", n), lmi.symmetric("P", n));
            lmi.constrain("P1 > 0", &p1 >> 0.0);
            lmi.constrain("P > 0", &p >> 0.0);
            let across = &p1 * &coupling;
            let (first, last) = (he(&p1 * closed), he(&p * error));
            lmi.constrain("(25)", block![[first, across.clone()], [across.transpose(), last]] << 0.0);
            problems.push((lmi, is_feasible));
        }
    }
    by_either(&problems)
}
