//! The margin problem: maximise the distance to the boundary of all constraints at once.
//!
//! In standard form (see [`standard`](crate::standard)),
//! ```text
//!     maximise t   subject to   F_k(x) >= t I for all k,   |x_i| <= 1,
//! ```
//! whose optimum is attained, is never negative, and is positive iff the strict inequalities have a solution. Its dual,
//! ```text
//!     minimise sum_i |sum_k tr(F_ki Z_k)|   subject to   Z_k >= 0,   sum_k tr Z_k = 1,
//! ```
//! has the optimum 0 iff they have none, and then its Z is the witness. Both have interior points, so the solver's
//! problem always has a solution; the maximiser lies well inside the constraints, where verification is easy.
//!
//! Cost per iteration, for N scalar unknowns: a Cholesky factorisation of order N and what its matrix takes to
//! assemble, see [`interior`](crate::interior).

use luenberger_proof::{UndecidedReason, Verdict};
use nalgebra::DMatrix;

use crate::coefficients::{Rounded, expand};
use crate::conic::{Block, BlockEntry, ConicProgram, Ending};
use crate::error::LmiError;
use crate::interior::Path;
use crate::problem::{Problem, Settings};
use crate::refute::refute;
use crate::solution::{Effort, Margin, Optimum, Solution};
use crate::standard::{Anchor, Small, Standard, power, standard_form};
use crate::variable::Variable;
use crate::verify::verify;

/// The margin of the scaled standard form is taken within this share of the best: digits beyond those that are printed
/// are worth nothing, and take a third of the iterations.
const ENOUGH: f64 = 1e-5;

/// Above this margin in the scaled standard form, no witness of infeasibility is sought.
const HOPELESS: f64 = 1e-5;

impl Problem {
    /// Solves with the default [`Settings`].
    ///
    /// # Errors
    /// An ill-posed problem: see [`LmiError`], which names the constraint. Infeasibility is not an error but the
    /// verdict `Refuted`.
    pub fn solve(&self) -> Result<Solution, LmiError> {
        self.solve_with(&Settings::default())
    }

    /// Solves.
    ///
    /// # Errors
    /// As [`Problem::solve`]; [`LmiError::NotBuiltIn`] for a solver that is not compiled in.
    pub fn solve_with(&self, settings: &Settings) -> Result<Solution, LmiError> {
        solve(self, settings)
    }
}

/// First the margin, then the objective; each solution is verified.
fn solve(problem: &Problem, settings: &Settings) -> Result<Solution, LmiError> {
    let standard = standard_form(problem, Anchor::Middle, Small::Kept)?;
    let first = attempt(problem, settings, &standard)?;
    let mut effort = first.effort;
    if !matches!(first.verdict, Verdict::Undecided { .. }) {
        return Ok(first);
    }
    let choices = [
        (Anchor::Largest, Small::Kept),
        (Anchor::Smallest, Small::Kept),
        (Anchor::Middle, Small::LeftOutAsGiven),
        (Anchor::Middle, Small::LeftOutAsScaled),
    ];
    let mut tried = vec![(standard.unknown_scale, standard.left_out)];
    for (anchor, small) in choices {
        if settings.is_over() {
            break;
        }
        // Other scales are worth a try only if they are others.
        let standard = standard_form(problem, anchor, small)?;
        let scales = (standard.unknown_scale.clone(), standard.left_out);
        if tried.contains(&scales) {
            continue;
        }
        tried.push(scales);
        let mut next = attempt(problem, settings, &standard)?;
        effort.iterations += next.effort.iterations;
        if !matches!(next.verdict, Verdict::Undecided { .. }) {
            next.effort.iterations = effort.iterations;
            return Ok(next);
        }
    }
    Ok(Solution { effort, ..first })
}

/// Solves with one choice of scaling.
fn attempt(problem: &Problem, settings: &Settings, standard: &Standard) -> Result<Solution, LmiError> {
    if standard.homogeneous && problem.objective.is_some() {
        return Err(LmiError::HomogeneousObjective);
    }
    let path = settings.solver.propose(&margin_program(standard), settings.iterations, settings.end)?;
    let Some((path, last)) = path.as_ref().and_then(|path| Some((path, path.last()?))) else {
        return Ok(no_proposal(problem, standard));
    };
    let effort = Effort { iterations: path.iterations, status: path.status };
    let centre = unscale(standard, &last.unknowns);
    let values = assemble(problem, standard, &centre);
    let margins = verify(problem, &values);
    if let Some(margin) = smallest_proved(&margins) {
        let mut solution = Solution { verdict: Verdict::Proved { margin }, margins, objective: None, effort, values };
        if problem.objective.is_some() {
            improve(problem, settings, standard, &centre, &mut solution)?;
        }
        return Ok(solution);
    }
    let best = margins.iter().map(|margin| margin.estimate).fold(f64::INFINITY, f64::min);
    let reached = last.unknowns.last().copied().unwrap_or_default();
    let multipliers = &last.multipliers[..standard.blocks.len()];
    let witness =
        if reached < HOPELESS && !settings.is_over() { refute(problem, settings, standard, multipliers) } else { None };
    let verdict = match witness {
        Some(witness) => Verdict::Refuted { witness },
        None => Verdict::Undecided { why: undecided_reason(&margins, path), best },
    };
    Ok(Solution { verdict, margins, objective: None, effort, values })
}

/// Why neither feasibility nor infeasibility could be proved.
fn undecided_reason(margins: &[Margin], path: &Path) -> UndecidedReason {
    if path.ending == Ending::Point {
        let estimate = margins.iter().filter(|m| m.proved.is_none()).map(|m| m.estimate).fold(f64::INFINITY, f64::min);
        UndecidedReason::ProposalNotProved { estimate }
    } else {
        UndecidedReason::NoProposal { status: path.status }
    }
}

fn no_proposal(problem: &Problem, standard: &Standard) -> Solution {
    let status = "no proposal";
    Solution {
        verdict: Verdict::Undecided { why: UndecidedReason::NoProposal { status }, best: f64::NEG_INFINITY },
        margins: Vec::new(),
        objective: None,
        effort: Effort { iterations: 0, status },
        values: assemble(problem, standard, &vec![0.0; standard.unknowns]),
    }
}

/// The smallest margin, if all are proved.
fn smallest_proved(margins: &[Margin]) -> Option<f64> {
    margins.iter().try_fold(f64::INFINITY, |least, margin| margin.proved.map(|proved| least.min(proved)))
}

/// The margin problem; its unknowns are those of the cone, then t.
fn margin_program(standard: &Standard) -> ConicProgram {
    let count = standard.cone_unknowns();
    let mut blocks = standard.blocks.clone();
    for entry in blocks.iter_mut().flat_map(|block| &mut block.entries) {
        if entry.row == entry.column {
            entry.terms.push((count, -1.0));
        }
    }
    for k in 0..count {
        blocks.extend([1.0, -1.0].map(|sign| Block::number(1.0, vec![(k, sign)])));
    }
    let mut cost = vec![0.0; count + 1];
    cost[count] = -1.0;
    ConicProgram { cost, blocks, enough: ENOUGH }
}

/// The problem's scalar unknowns from a point of the scaled cone.
///
/// With `x_0`, they are divided by it. Without, a homogeneous problem leaves their common factor free: the largest is
/// brought into [1/2, 1).
fn unscale(standard: &Standard, point: &[f64]) -> Vec<f64> {
    let count = standard.unknowns;
    let scaled = |i: usize| point[i] * power(standard.unknown_scale[i]);
    if standard.homogeneous {
        let largest = (0..count).map(|i| scaled(i).abs()).fold(0.0, f64::max);
        let factor = if largest > 0.0 { power(-(largest.log2().floor() as i32) - 1) } else { 1.0 };
        (0..count).map(|i| scaled(i) * factor).collect()
    } else {
        let divisor = scaled(count);
        // A divisor that is not positive leaves values that prove nothing; they only have to be finite.
        let divisor = if divisor > 0.0 { divisor } else { 1.0 };
        (0..count).map(|i| finite(scaled(i) / divisor)).collect()
    }
}

fn finite(x: f64) -> f64 {
    if x.is_finite() { x } else { 0.0 }
}

fn assemble(problem: &Problem, standard: &Standard, unknowns: &[f64]) -> Vec<(Variable, DMatrix<f64>)> {
    problem
        .variables
        .iter()
        .zip(&standard.offsets)
        .map(|(variable, &offset)| (variable.clone(), variable.assemble(&unknowns[offset..])))
        .collect()
}

/// Moves a verified solution from the centre towards the optimum of the objective, as far as the constraints can be
/// verified.
///
/// The optimum lies on the boundary, where strict inequalities fail; the points `optimum + w (centre - optimum)` are
/// inside by at least w times the centre's margin, since the constraints are affine.
fn improve(
    problem: &Problem,
    settings: &Settings,
    standard: &Standard,
    centre: &[f64],
    solution: &mut Solution,
) -> Result<(), LmiError> {
    let Some(objective) = &problem.objective else { return Ok(()) };
    let expanded = expand::<Rounded>(&objective.expression, &standard.offsets)
        .map_err(|fault| LmiError::Malformed { place: "objective".to_owned(), fault })?;
    let entry = &expanded[(0, 0)];
    if !entry.constant.0.is_finite() || entry.terms.iter().any(|(_, c)| !c.0.is_finite()) {
        return Err(LmiError::Overflow { place: "objective".to_owned() });
    }
    let value = |x: &[f64]| entry.terms.iter().fold(entry.constant.0, |sum, (k, c)| sum + c.0 * x[*k]);
    let sign = if objective.maximise { -1.0 } else { 1.0 };
    // In the scaled unknowns, with x_0 held at the scaled value that means 1.
    let count = standard.unknowns;
    let mut cost = vec![0.0; count];
    for (k, c) in &entry.terms {
        cost[*k] = sign * c.0 * power(standard.unknown_scale[*k]);
    }
    let size = cost.iter().fold(0.0f64, |m, c| m.max(c.abs()));
    if size > 0.0 {
        for c in &mut cost {
            *c /= size;
        }
    }
    let x0 = power(-standard.unknown_scale.get(count).copied().unwrap_or_default());
    let user_blocks = problem.constraints.len();
    let blocks: Vec<Block> = standard.blocks[..user_blocks]
        .iter()
        .map(|block| Block {
            order: block.order,
            entries: block
                .entries
                .iter()
                .map(|entry| {
                    let (constants, terms): (Vec<_>, Vec<_>) = entry.terms.iter().partition(|(k, _)| *k == count);
                    let constant = constants.iter().map(|(_, c)| c * x0).sum();
                    BlockEntry { constant, terms, ..*entry }
                })
                .collect(),
            products: block.products.clone(),
        })
        .collect();
    let program = ConicProgram::new(cost, blocks);
    let unbounded = -sign * f64::INFINITY;
    let mut estimate = f64::NAN;
    let path = settings.solver.propose(&program, settings.iterations, settings.end)?;
    if let Some((path, last)) = path.as_ref().and_then(|path| Some((path, path.last()?))) {
        solution.effort.iterations += path.iterations;
        solution.effort.status = path.status;
        match path.ending {
            Ending::Unbounded => estimate = unbounded,
            Ending::NoPoint => {}
            Ending::Point => {
                estimate = entry.constant.0 + sign * size * program.dual_cost(&last.multipliers);
                let optimum: Vec<f64> =
                    (0..count).map(|i| finite(last.unknowns[i] * power(standard.unknown_scale[i]))).collect();
                let mut weight = settings.closeness.clamp(f64::EPSILON, 1.0);
                while weight < 1.0 {
                    let point: Vec<f64> = optimum.iter().zip(centre).map(|(o, c)| o + weight * (c - o)).collect();
                    let values = assemble(problem, standard, &point);
                    let margins = verify(problem, &values);
                    if sign * value(&point) >= sign * value(centre) {
                        break;
                    }
                    if let Some(margin) = smallest_proved(&margins) {
                        solution.verdict = Verdict::Proved { margin };
                        solution.margins = margins;
                        solution.values = values;
                        solution.objective = Some(Optimum { achieved: value(&point), estimate });
                        return Ok(());
                    }
                    // At most 16 decades between the smallest weight and 1.
                    weight *= 10.0;
                }
            }
        }
    }
    solution.objective = Some(Optimum { achieved: value(centre), estimate });
    Ok(())
}
