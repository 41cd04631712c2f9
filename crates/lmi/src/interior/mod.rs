//! A primal-dual interior-point method for semidefinite programs whose constraints are sparse.
//!
//! ```text
//! minimise c'x   subject to   X = F_0 + x_1 F_1 + ... + x_m F_m >= 0,      maximise -tr(F_0 Y)   subject to   tr(F_i Y) = c_i,  Y >= 0
//! ```
//! in the notation of [`conic`](crate::conic), where the constant comes with a plus sign.
//!
//! Each iteration solves for the direction of Helmberg, Rendl, Vanderbei and Wolkowicz, Kojima, Shindoh and Hara, and
//! Monteiro (HKM): with V = X^-1,
//! ```text
//! dX = R + sum dx_i F_i,   dY = mu V - Y - sym(V dX Y),   tr(F_i dY) = c_i - tr(F_i Y)   =>   B dx = tr(F_i (mu V - V R Y)) - c_i,   B_ij = tr(F_i V F_j Y),
//! ```
//! by Mehrotra's predictor and corrector. Cost per iteration: a Cholesky factorisation of order m, a dozen operations
//! of n^3 per block, and the assembly of B, which takes for each pair of constraints a number of operations that
//! follows their entries. A general conic solver factors a matrix of order n (n + 1)/2 per block instead: n^6
//! operations where these are n^3.
//!
//! The iterates stay positive definite, and once the equations hold they are strictly feasible, as a proof requires.
//! The last several are returned, since the final one is closest to the boundary.
//!
//! Sources: C. Helmberg, F. Rendl, R. J. Vanderbei, H. Wolkowicz, An interior-point method for semidefinite
//! programming, SIAM J. Optim. 6, 1996; K. Fujisawa, M. Kojima, K. Nakata, Exploiting sparsity in primal-dual
//! interior-point methods for semidefinite programming, Math. Program. 79, 1997.

pub(crate) mod program;
pub(crate) mod schur;
mod state;
mod structured;

use faer::Mat;
use luenberger_clock::Instant;
use nalgebra::DMatrix;

use crate::conic::{ConicProgram, Ending};
use crate::sequential::product;
pub(crate) use program::Iterate;
use program::Scaled;
use schur::{assemble, joined, refined, regularised};
use state::State;

/// The last iterates that were better than all before, the nearest to the optimum last.
#[derive(Debug)]
pub(crate) struct Path {
    scaled: Scaled,
    pub(crate) iterates: Vec<Iterate>,
    pub(crate) ending: Ending,
    pub(crate) status: &'static str,
    pub(crate) iterations: u32,
}

/// Number of iterates returned.
const KEPT: usize = 16;

/// Relative gap and residuals below this are at the limit of the precision.
const PRECISE: f64 = 1e-12;

/// Below this gap the method stops after 3 iterations without progress, above it after 25.
const FINE: f64 = 1e-8;

/// Runs the method, with no iteration started after `end`. `None` for a program without unknowns or constraints, or if
/// no step could be taken.
pub(crate) fn solve_until(program: &ConicProgram, iterations: u32, end: Option<Instant>) -> Option<Path> {
    if program.cost.is_empty() || program.blocks.is_empty() {
        return None;
    }
    let scaled = Scaled::of(program);
    let mut state = State::start(&scaled);
    let mut kept: Vec<Iterate> = Vec::new();
    let (mut ending, mut status, mut done) = (Ending::Point, "iteration limit", iterations);
    let (mut last_merit, mut last_kept) = (f64::INFINITY, f64::INFINITY);
    let mut stalled = 0;
    for iteration in 0..iterations {
        if end.is_some_and(|end| Instant::now() >= end) {
            (status, done) = ("time limit", iteration);
            break;
        }
        let Some(progress) = state.step(&scaled) else {
            (status, done) = ("numerical error", iteration);
            break;
        };
        let merit = progress.gap.max(progress.residual);
        let ray = state.ray(&scaled);
        let is_enough =
            state.is_primal_feasible && progress.residual < FINE && progress.excess <= scaled.enough * -progress.cost;
        // One for each octave of the gap: the last iterates of all crowd at the boundary, and prove nothing.
        if progress.gap < 0.5 * last_kept || ray.is_some() || is_enough {
            last_kept = progress.gap;
            if kept.len() == KEPT {
                kept.remove(0);
            }
            kept.push(scaled.original(&state.x, &state.dual));
        }
        if let Some(ray) = ray {
            (ending, done) = (ray, iteration + 1);
            status = if ray == Ending::NoPoint { "infeasible" } else { "unbounded" };
            break;
        }
        if merit < PRECISE || is_enough {
            (status, done) = ("solved", iteration + 1);
            break;
        }
        stalled = if merit < 0.9 * last_merit { 0 } else { stalled + 1 };
        last_merit = last_merit.min(merit);
        if stalled >= if merit < FINE { 3 } else { 25 } {
            (status, done) = ("insufficient progress", iteration + 1);
            break;
        }
    }
    (!kept.is_empty()).then_some(Path { scaled, iterates: kept, ending, status, iterations: done })
}

impl Path {
    /// The iterate of another solver, which returns only one.
    #[cfg(feature = "clarabel")]
    pub(crate) fn of(
        program: &ConicProgram,
        iterate: Iterate,
        ending: Ending,
        status: &'static str,
        iterations: u32,
    ) -> Self {
        Self { scaled: Scaled::of(program), iterates: vec![iterate], ending, status, iterations }
    }

    /// The last iterate.
    pub(crate) fn last(&self) -> Option<&Iterate> {
        self.iterates.last()
    }

    /// The multipliers of an iterate, moved onto their equations `tr(F_i Y) = c_i` (or = 0, of a ray) within the cone:
    /// `Y + Y (sum l_i F_i) Y` changes no eigenvalue by more than a share of itself, where a plain projection may leave
    /// the cone at the small ones.
    pub(crate) fn on_equations(&self, iterate: &Iterate, is_ray: bool) -> Vec<DMatrix<f64>> {
        let scaled = &self.scaled;
        let mut y = scaled.multipliers(iterate);
        for _ in 0..2 {
            let residual: Vec<f64> =
                scaled.adjoint(&y).iter().zip(&scaled.cost).map(|(a, c)| if is_ray { -a } else { c - a }).collect();
            let mut matrix: Mat<f64> = Mat::zeros(residual.len(), residual.len());
            for (block, y) in scaled.dense.iter().zip(&y.dense) {
                assemble(block, y.as_ref(), y.as_ref(), &mut matrix);
            }
            for (number, y) in scaled.numbers.iter().zip(&y.numbers) {
                number.assemble(y * y, &mut matrix);
            }
            let matrix = joined(matrix);
            let Some(factor) = regularised(&matrix) else { break };
            let change = scaled.pencil(&refined(&factor, &matrix, &residual), false);
            for (y, change) in y.dense.iter_mut().zip(&change.dense) {
                let moved = product(y.as_ref(), product(change.as_ref(), y.as_ref()).as_ref());
                let n = y.nrows();
                *y += Mat::from_fn(n, n, |i, j| 0.5 * (moved[(i, j)] + moved[(j, i)]));
            }
            for (y, change) in y.numbers.iter_mut().zip(&change.numbers) {
                *y += *y * change * *y;
            }
        }
        scaled.original_multipliers(&y)
    }
}
