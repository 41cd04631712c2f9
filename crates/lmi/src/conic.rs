//! The conic program that the layer hands to its solver, and the solver: clarabel, an interior-point method. Nothing outside this file
//! knows its cones, its vectors of triangles, or its status.
//!
//! Settings and why: chordal decomposition off, since with it the solver returned `Solved` at a wrong optimum (SDPLIB control1);
//! the supernodal factorisation of faer, ten times faster than the default on dense inequalities; one thread, so that the answer
//! depends on no machine; tolerances near what binary64 allows, since the proof wants a centred point and loses nothing if the solver stops short.

use clarabel::algebra::CscMatrix;
use clarabel::solver::{DefaultSettings, DefaultSolver, IPSolver, SolverStatus, SupportedConeT};
use luenberger_lapack as _;
use nalgebra::DMatrix;

/// A linear term of one scalar unknown.
pub(crate) type Term = (usize, f64);

/// One lower-triangular entry of a symmetric matrix that depends affinely on the unknowns.
#[derive(Debug, Clone)]
pub(crate) struct BlockEntry {
    pub(crate) row: usize,
    pub(crate) column: usize,
    pub(crate) constant: f64,
    pub(crate) terms: Vec<Term>,
}

/// A symmetric affine matrix that is to be positive semidefinite.
#[derive(Debug, Clone)]
pub(crate) struct Block {
    pub(crate) order: usize,
    pub(crate) entries: Vec<BlockEntry>,
}

/// Minimise a linear cost under semidefinite constraints and, perhaps, a bound 1 on the Euclidean norm of the first unknowns.
#[derive(Debug)]
pub(crate) struct ConicProgram {
    pub(crate) cost: Vec<f64>,
    pub(crate) blocks: Vec<Block>,
    pub(crate) in_unit_ball: Option<usize>,
}

/// How the solver said it ended.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Ending {
    /// It has a point, good or not.
    Point,
    /// It thinks there is no point.
    NoPoint,
    /// It thinks the cost has no lower bound.
    Unbounded,
}

/// What the solver proposes. Nothing in it is proved.
#[derive(Debug)]
pub(crate) struct Proposal {
    pub(crate) unknowns: Vec<f64>,
    pub(crate) multipliers: Vec<DMatrix<f64>>,
    pub(crate) dual_cost: f64,
    pub(crate) ending: Ending,
    pub(crate) status: &'static str,
    pub(crate) iterations: u32,
}

/// Runs the solver. None if it refuses the program or returns numbers that are not finite.
pub(crate) fn solve(program: &ConicProgram, iterations: u32) -> Option<Proposal> {
    let unknowns = program.cost.len();
    // Column lists of the constraint matrix of `A x + s = b`, s in the cones.
    let mut columns: Vec<Vec<(usize, f64)>> = vec![Vec::new(); unknowns];
    let mut right_side = Vec::new();
    let mut cones = Vec::new();
    for block in &program.blocks {
        let start = right_side.len();
        right_side.resize(start + block.order * (block.order + 1) / 2, 0.0);
        for entry in &block.entries {
            // The upper triangle column by column, which is the lower one row by row; off the diagonal times sqrt 2.
            let (i, j) = (entry.row, entry.column);
            let row = start + i * (i + 1) / 2 + j;
            let weight = if i == j { 1.0 } else { std::f64::consts::SQRT_2 };
            right_side[row] = weight * entry.constant;
            for &(unknown, c) in &entry.terms {
                columns[unknown].push((row, -weight * c));
            }
        }
        // Numbers side by side are one cone: a thousand cones of one number each cost the solver more than one of a thousand.
        match cones.last_mut() {
            Some(SupportedConeT::NonnegativeConeT(count)) if block.order == 1 => *count += 1,
            _ if block.order == 1 => cones.push(SupportedConeT::NonnegativeConeT(1)),
            _ => cones.push(SupportedConeT::PSDTriangleConeT(block.order)),
        }
    }
    if let Some(count) = program.in_unit_ball {
        let start = right_side.len();
        right_side.resize(start + 1 + count, 0.0);
        right_side[start] = 1.0;
        for (k, column) in columns.iter_mut().enumerate().take(count) {
            column.push((start + 1 + k, -1.0));
        }
        cones.push(SupportedConeT::SecondOrderConeT(1 + count));
    }
    let rows = right_side.len();
    let mut starts = vec![0];
    let (mut positions, mut entries) = (Vec::new(), Vec::new());
    for mut column in columns {
        column.sort_by_key(|&(row, _)| row);
        for (row, value) in column {
            positions.push(row);
            entries.push(value);
        }
        starts.push(positions.len());
    }
    let a = CscMatrix::new(rows, unknowns, starts, positions, entries);
    let quadratic = CscMatrix::zeros((unknowns, unknowns));
    let settings = DefaultSettings {
        verbose: false,
        max_iter: iterations,
        max_threads: 1,
        direct_solve_method: "faer".to_owned(),
        chordal_decomposition_enable: false,
        presolve_enable: false,
        tol_gap_abs: 1e-10,
        tol_gap_rel: 1e-10,
        tol_feas: 1e-10,
        ..DefaultSettings::default()
    };
    let mut solver = DefaultSolver::new(&quadratic, &program.cost, &a, &right_side, &cones, settings).ok()?;
    solver.solve();
    let solution = &solver.solution;
    let mut position = 0;
    let mut multipliers = Vec::with_capacity(program.blocks.len());
    for block in &program.blocks {
        let triangle = &solution.z[position..];
        multipliers.push(DMatrix::from_fn(block.order, block.order, |i, j| {
            let (i, j) = (i.max(j), i.min(j));
            let weight = if i == j { 1.0 } else { std::f64::consts::FRAC_1_SQRT_2 };
            weight * triangle[i * (i + 1) / 2 + j]
        }));
        position += block.order * (block.order + 1) / 2;
    }
    let finite = solution.x.iter().chain(&solution.z).all(|x| x.is_finite());
    finite.then(|| Proposal {
        unknowns: solution.x.clone(),
        multipliers,
        dual_cost: solution.obj_val_dual,
        ending: match solution.status {
            SolverStatus::PrimalInfeasible | SolverStatus::AlmostPrimalInfeasible => Ending::NoPoint,
            SolverStatus::DualInfeasible | SolverStatus::AlmostDualInfeasible => Ending::Unbounded,
            _ => Ending::Point,
        },
        status: word(solution.status),
        iterations: solution.iterations,
    })
}

/// The solver's word for how it ended.
fn word(status: SolverStatus) -> &'static str {
    match status {
        SolverStatus::Unsolved => "unsolved",
        SolverStatus::Solved => "solved",
        SolverStatus::PrimalInfeasible => "infeasible",
        SolverStatus::DualInfeasible => "unbounded",
        SolverStatus::AlmostSolved => "almost solved",
        SolverStatus::AlmostPrimalInfeasible => "almost infeasible",
        SolverStatus::AlmostDualInfeasible => "almost unbounded",
        SolverStatus::MaxIterations => "iteration limit",
        SolverStatus::MaxTime => "time limit",
        SolverStatus::NumericalError => "numerical error",
        SolverStatus::InsufficientProgress => "insufficient progress",
        SolverStatus::CallbackTerminated => "stopped",
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// min x s.t. [[x, c], [c, y]] >= 0 and x^2 + y^2 <= 1, that is x y >= c^2: impossible for c = 1; for c = 1/4
    /// the optimum is x = sqrt((1 - sqrt(1 - 4 c^4)) / 2).
    #[test]
    fn a_two_by_two_program_with_a_ball() {
        let block = |corner: f64| Block {
            order: 2,
            entries: vec![
                BlockEntry { row: 0, column: 0, constant: 0.0, terms: vec![(0, 1.0)] },
                BlockEntry { row: 1, column: 0, constant: corner, terms: vec![] },
                BlockEntry { row: 1, column: 1, constant: 0.0, terms: vec![(1, 1.0)] },
            ],
        };
        let program =
            |corner| ConicProgram { cost: vec![1.0, 0.0], blocks: vec![block(corner)], in_unit_ball: Some(2) };
        assert_eq!(solve(&program(1.0), 100).unwrap().ending, Ending::NoPoint);
        let proposal = solve(&program(0.25), 100).unwrap();
        let expected = ((1.0 - (1.0f64 - 1.0 / 64.0).sqrt()) / 2.0).sqrt();
        // The solver was asked for a relative gap of 1e-10.
        assert!((proposal.unknowns[0] - expected).abs() < 1e-8, "{} {expected}", proposal.unknowns[0]);
    }
}
