//! The conic programs whose approximate solutions are verified: the program itself, and its centring problems, for
//! solutions too close to the boundary.
//!
//! With S the size of the sought point, and the cost kept within `g = room (1 + |value|)` of the approximate optimum
//! (the margin is a concave function of g, so that a small g gives more margin per cost, and a large one more margin in
//! total),
//! ```text
//! centre of (P):  maximise s   subject to  X(x) >= s I,  s <= S,  c'x <= value + g
//! centre of (D):  maximise s   subject to  tr(F_i Y) = c_i,  Y >= s I,  s <= S,  tr(F_0 Y) >= value - g
//! ray of (P):     maximise s   subject to  x_1 F_1 + ... >= s I,  c'x <= -s |c|,  |x_i| <= 1/|F_i|
//! ray of (D):     maximise s   subject to  tr(F_i Y) = 0,  Y >= s I,  tr(F_0 Y) >= s |F_0|,  tr Y <= 1
//! ```
//! Those of (D) are posed as their duals, in the unknowns x and mu, so that each has as few unknowns as (P): with `Z =
//! x_1 F_1 + ... - mu F_0`,
//! ```text
//! centre:  minimise  c'x - mu (value - g) + S (1 - tr Z)   subject to  Z >= 0, tr Z <= 1, mu >= 0:   Y = W + (S - eta) I
//! ray:     minimise  tau   subject to  Z + tau I >= 0,  tr(Z + tau I) + mu |F_0| >= 1,  mu, tau >= 0:           Y = W + eta I
//! ```
//! where W is the multiplier of the matrix inequality and eta that of the inequality with the trace.

use luenberger_proof::semidefinite::{Block, Program};

use super::dual::{self, Point, middle};
use crate::conic::{self, BlockEntry, ConicProgram};
use nalgebra::DMatrix;

fn costs(program: &Program) -> Vec<f64> {
    program.costs().iter().map(|c| c.midpoint_radius().map_or(0.0, |c| c.0)).collect()
}

/// c'x.
pub(super) fn value(program: &Program, x: &[f64]) -> f64 {
    costs(program).iter().zip(x).map(|(c, x)| c * x).sum()
}

/// The blocks of `sum_k x_k F_k` over the matrices listed with their unknowns and factors, a diagonal block as many of
/// order one; `constant` times F_0 is the constant part, and `identity` the unknown that multiplies I.
fn pencil(
    program: &Program,
    constant: f64,
    zeroth: Option<(usize, f64)>,
    identity: Option<(usize, f64)>,
) -> Vec<conic::Block> {
    let mut entries: Vec<(usize, usize, usize, Option<usize>, f64)> = Vec::new();
    for k in 0..=program.unknowns() {
        for e in program.matrix(k) {
            let value = middle(e);
            if k > 0 {
                entries.push((e.block, e.row, e.column, Some(k - 1), value));
                continue;
            }
            if constant != 0.0 {
                entries.push((e.block, e.row, e.column, None, constant * value));
            }
            if let Some((unknown, factor)) = zeroth {
                entries.push((e.block, e.row, e.column, Some(unknown), factor * value));
            }
        }
    }
    if let Some((unknown, factor)) = identity {
        for (k, block) in program.blocks().iter().enumerate() {
            entries.extend((0..block.order()).map(|i| (k, i, i, Some(unknown), factor)));
        }
    }
    entries.sort_by_key(|e| (e.0, e.1, e.2));
    // Where the blocks of the conic program begin.
    let mut blocks: Vec<conic::Block> = Vec::new();
    let mut firsts = Vec::new();
    for block in program.blocks() {
        firsts.push(blocks.len());
        match *block {
            Block::Dense(order) => blocks.push(conic::Block::of(order, Vec::new())),
            Block::Diagonal(n) => blocks.extend((0..n).map(|_| conic::Block::of(1, Vec::new()))),
        }
    }
    for here in entries.chunk_by(|a, b| (a.0, a.1, a.2) == (b.0, b.1, b.2)) {
        let (block, row, column, ..) = here[0];
        let (target, row, column) = match program.blocks()[block] {
            Block::Dense(_) => (firsts[block], row, column),
            Block::Diagonal(_) => (firsts[block] + row, 0, 0),
        };
        // The lower triangle.
        let mut entry = BlockEntry { row: column, column: row, constant: 0.0, terms: Vec::new() };
        for (.., unknown, value) in here {
            match unknown {
                Some(unknown) => entry.terms.push((*unknown, *value)),
                None => entry.constant += value,
            }
        }
        blocks[target].entries.push(entry);
    }
    blocks
}

fn traces(program: &Program) -> Vec<f64> {
    (0..=program.unknowns()).map(|k| program.matrix(k).iter().filter(|e| e.row == e.column).map(middle).sum()).collect()
}

fn norm(program: &Program, k: usize) -> f64 {
    let square = |e| f64::powi(middle(e), 2);
    let weight = |row, column| if row == column { 1.0 } else { 2.0 };
    program.matrix(k).iter().map(|e| weight(e.row, e.column) * square(e)).sum::<f64>().sqrt()
}

/// (P).
pub(super) fn primal(program: &Program) -> ConicProgram {
    ConicProgram::new(costs(program), pencil(program, -1.0, None, None))
}

/// The centre of (P), with s as its last unknown.
pub(super) fn primal_centre(program: &Program, x: &[f64], room: f64) -> ConicProgram {
    let (m, c) = (program.unknowns(), costs(program));
    let value = value(program, x);
    let largest = x.iter().enumerate().map(|(k, x)| x.abs() * norm(program, k + 1)).fold(norm(program, 0), f64::max);
    let mut blocks = pencil(program, -1.0, None, Some((m, -1.0)));
    blocks.push(conic::Block::number(
        value + room * (1.0 + value.abs()),
        c.iter().enumerate().map(|(k, c)| (k, -c)).collect(),
    ));
    blocks.push(conic::Block::number(1.0 + largest, vec![(m, -1.0)]));
    let mut cost = vec![0.0; m];
    cost.push(-1.0);
    ConicProgram::new(cost, blocks)
}

/// The ray of (P), with s as its last unknown.
pub(super) fn primal_ray(program: &Program) -> ConicProgram {
    let (m, c) = (program.unknowns(), costs(program));
    let size = c.iter().map(|c| c * c).sum::<f64>().sqrt();
    let mut blocks = pencil(program, 0.0, None, Some((m, -1.0)));
    let mut terms: Vec<_> = c.iter().enumerate().map(|(k, c)| (k, -c)).collect();
    terms.push((m, -size));
    blocks.push(conic::Block::number(0.0, terms));
    for k in 0..m {
        let reach = 1.0 / norm(program, k + 1).max(f64::MIN_POSITIVE);
        blocks.push(conic::Block::number(reach, vec![(k, 1.0)]));
        blocks.push(conic::Block::number(reach, vec![(k, -1.0)]));
    }
    let mut cost = vec![0.0; m];
    cost.push(-1.0);
    ConicProgram::new(cost, blocks)
}

/// A conic program whose multipliers give a point of (D).
pub(super) struct Posed {
    pub(super) program: ConicProgram,
    /// The block whose multiplier is eta.
    trace: usize,
    /// The shift of W is `offset + factor eta`.
    offset: f64,
    factor: f64,
}

impl Posed {
    pub(super) fn centre(&self, program: &Program, multipliers: &[DMatrix<f64>]) -> Point {
        let eta = multipliers.get(self.trace).map_or(0.0, |z| z[(0, 0)]);
        dual::blocks(program, multipliers).shifted(program, self.offset + self.factor * eta)
    }
}

/// The centre of (D), near a point with this value and this size.
pub(super) fn dual_centre(program: &Program, value: f64, size: f64, room: f64) -> Posed {
    let m = program.unknowns();
    let (c, traces, size) = (costs(program), traces(program), 1.0 + size);
    // Unknowns: x, mu. tr Z = sum x_i tr F_i - mu tr F_0.
    let trace_terms: Vec<f64> = traces[1..].iter().copied().chain([-traces[0]]).collect();
    let mut cost: Vec<f64> = c.iter().copied().chain([-(value - room * (1.0 + value.abs()))]).collect();
    for (cost, trace) in cost.iter_mut().zip(&trace_terms) {
        *cost -= size * trace;
    }
    let mut blocks = pencil(program, 0.0, Some((m, -1.0)), None);
    let trace = blocks.len();
    blocks.push(conic::Block::number(1.0, trace_terms.iter().enumerate().map(|(k, t)| (k, -t)).collect()));
    blocks.push(conic::Block::number(0.0, vec![(m, 1.0)]));
    Posed { program: ConicProgram::new(cost, blocks), trace, offset: size, factor: -1.0 }
}

/// The ray of (D).
pub(super) fn dual_ray(program: &Program) -> Posed {
    let m = program.unknowns();
    let rows: usize = program.blocks().iter().map(|block| block.order()).sum();
    let traces = traces(program);
    // Unknowns: x, mu, tau.
    let mut blocks = pencil(program, 0.0, Some((m, -1.0)), Some((m + 1, 1.0)));
    let trace = blocks.len();
    let mut terms: Vec<_> = traces[1..].iter().copied().enumerate().collect();
    terms.push((m, norm(program, 0) - traces[0]));
    terms.push((m + 1, rows as f64));
    blocks.push(conic::Block::number(-1.0, terms));
    blocks.push(conic::Block::number(0.0, vec![(m, 1.0)]));
    blocks.push(conic::Block::number(0.0, vec![(m + 1, 1.0)]));
    let mut cost = vec![0.0; m + 1];
    cost.push(1.0);
    Posed { program: ConicProgram::new(cost, blocks), trace, offset: 0.0, factor: 1.0 }
}
