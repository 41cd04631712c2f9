//! Clarabel as an alternative solver: the conic program in its standard form, and its last iterate.
//!
//! ```text
//! minimise q'x   subject to   A x + s = b,   s in K,      z in K*,   A'z + q = 0
//! ```
//! with `b` the constants and `-A` the coefficients of the blocks, each the stacked columns of its upper triangle,
//! entries off the diagonal times the square root of 2; z are the multipliers in the same coordinates.
//!
//! One thread and its own factorisation, so that results are reproducible. Its decomposition of sparse blocks is
//! disabled: with it, status `Solved` was returned at a wrong optimum of SDPLIB's control1.
//!
//! Source: P. Goulart and Y. Chen, Clarabel: an interior-point solver for conic programs with quadratic objectives,
//! arXiv:2405.12762, 2024.

use std::collections::BTreeMap;
use std::f64::consts::{FRAC_1_SQRT_2, SQRT_2};

use clarabel::algebra::CscMatrix;
use clarabel::solver::{DefaultSettings, DefaultSolver, IPSolver, SolverStatus, SupportedConeT};
// Defines the BLAS and LAPACK symbols that Clarabel links.
use luenberger_clock::Instant;
use luenberger_lapack as _;
use nalgebra::DMatrix;

use crate::conic::{Block, ConicProgram, Ending};
use crate::interior::{Iterate, Path};

/// Requested relative gap and residuals. If they are not reached, the last iterate is used all the same.
const PRECISE: f64 = 1e-9;

/// Runs Clarabel. `None` for a program without unknowns or constraints, after `end`, or if it has no finite iterate.
pub(crate) fn solve_until(program: &ConicProgram, iterations: u32, end: Option<Instant>) -> Option<Path> {
    if program.cost.is_empty() || program.blocks.is_empty() {
        return None;
    }
    let time_limit = match end.map(|end| end.saturating_duration_since(Instant::now())) {
        Some(left) if left.is_zero() => return None,
        left => left.map_or(f64::INFINITY, |left| left.as_secs_f64()),
    };
    let settings = DefaultSettings {
        max_iter: iterations,
        time_limit,
        verbose: false,
        tol_gap_abs: PRECISE,
        tol_gap_rel: PRECISE,
        tol_feas: PRECISE,
        max_threads: 1,
        direct_solve_method: "qdldl".to_owned(),
        presolve_enable: false,
        chordal_decomposition_enable: false,
        ..DefaultSettings::default()
    };
    let count = program.cost.len();
    let (matrix, constants, cones) = standard(program);
    let none = CscMatrix::zeros((count, count));
    let mut solver = DefaultSolver::new(&none, &program.cost, &matrix, &constants, &cones, settings).ok()?;
    solver.solve();
    let found = &solver.solution;
    let (ending, status) = match found.status {
        SolverStatus::Solved => (Ending::Point, "solved"),
        SolverStatus::AlmostSolved => (Ending::Point, "almost solved"),
        SolverStatus::PrimalInfeasible | SolverStatus::AlmostPrimalInfeasible => (Ending::NoPoint, "infeasible"),
        SolverStatus::DualInfeasible | SolverStatus::AlmostDualInfeasible => (Ending::Unbounded, "unbounded"),
        SolverStatus::MaxIterations => (Ending::Point, "iteration limit"),
        SolverStatus::MaxTime => (Ending::Point, "time limit"),
        SolverStatus::InsufficientProgress => (Ending::Point, "insufficient progress"),
        SolverStatus::NumericalError | SolverStatus::Unsolved | SolverStatus::CallbackTerminated => {
            (Ending::Point, "numerical error")
        }
    };
    if !found.x.iter().chain(&found.z).all(|x| x.is_finite()) {
        return None;
    }
    let iterate = Iterate { unknowns: found.x.clone(), multipliers: multipliers(&program.blocks, &found.z) };
    Some(Path::of(program, iterate, ending, status, found.iterations))
}

/// The place of an entry of the lower triangle among the stacked columns of the upper one.
fn place(row: usize, column: usize) -> usize {
    row * (row + 1) / 2 + column
}

/// `A`, `b` and the cones.
fn standard(program: &ConicProgram) -> (CscMatrix<f64>, Vec<f64>, Vec<SupportedConeT<f64>>) {
    let mut columns: Vec<BTreeMap<usize, f64>> = vec![BTreeMap::new(); program.cost.len()];
    let (mut constants, mut cones) = (Vec::new(), Vec::new());
    for block in &program.blocks {
        let start = constants.len();
        constants.resize(start + place(block.order, 0), 0.0);
        for entry in &block.entries {
            let weight = if entry.row == entry.column { 1.0 } else { SQRT_2 };
            let at = start + place(entry.row, entry.column);
            constants[at] += weight * entry.constant;
            for &(unknown, c) in &entry.terms {
                *columns[unknown].entry(at).or_insert(0.0) -= weight * c;
            }
        }
        match cones.last_mut() {
            Some(SupportedConeT::NonnegativeConeT(size)) if block.order == 1 => *size += 1,
            _ if block.order == 1 => cones.push(SupportedConeT::NonnegativeConeT(1)),
            _ => cones.push(SupportedConeT::PSDTriangleConeT(block.order)),
        }
    }
    let mut starts = vec![0];
    let (mut rows, mut values): (Vec<usize>, Vec<f64>) = (Vec::new(), Vec::new());
    for column in columns {
        rows.extend(column.keys());
        values.extend(column.values());
        starts.push(rows.len());
    }
    (CscMatrix::new(constants.len(), program.cost.len(), starts, rows, values), constants, cones)
}

/// The multiplier of each block.
fn multipliers(blocks: &[Block], z: &[f64]) -> Vec<DMatrix<f64>> {
    let mut start = 0;
    blocks
        .iter()
        .map(|block| {
            let n = block.order;
            let entry = |i: usize, j: usize| {
                let weight = if i == j { 1.0 } else { FRAC_1_SQRT_2 };
                weight * z[start + place(i.max(j), i.min(j))]
            };
            let multiplier = DMatrix::from_fn(n, n, entry);
            start += place(n, 0);
            multiplier
        })
        .collect()
}
