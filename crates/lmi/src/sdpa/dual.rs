//! Approximate points of (D) in binary64; nothing is verified here.

use faer::Mat;
use luenberger_proof::Matrix;
use luenberger_proof::semidefinite::{Block, DualBlock, Entry, Program};
use nalgebra::DMatrix;

use crate::sequential::Cholesky;

/// A matrix Y in blocks; the diagonal blocks are columns.
#[derive(Debug, Clone)]
pub(super) struct Point(Vec<DMatrix<f64>>);

/// The blocks of Y from the multipliers of the conic program, in which a diagonal block is as many blocks of order one.
pub(super) fn blocks(program: &Program, multipliers: &[DMatrix<f64>]) -> Point {
    let mut rest = multipliers.iter();
    Point(
        program
            .blocks()
            .iter()
            .map(|block| match *block {
                Block::Dense(n) => rest.next().cloned().unwrap_or_else(|| DMatrix::zeros(n, n)),
                Block::Diagonal(n) => DMatrix::from_fn(n, 1, |_, _| rest.next().map_or(0.0, |z| z[(0, 0)])),
            })
            .collect(),
    )
}

/// The middle of an interval of data.
pub(super) fn middle(entry: &Entry) -> f64 {
    entry.value.midpoint_radius().map_or(0.0, |(middle, _)| middle)
}

fn weight(entry: &Entry) -> f64 {
    if entry.row == entry.column { 1.0 } else { 2.0 }
}

/// The column of an entry in a block of a [`Point`].
fn column(block: Block, entry: &Entry) -> usize {
    if matches!(block, Block::Dense(_)) { entry.column } else { 0 }
}

impl Point {
    /// `tr(F_k Y)`.
    fn inner(&self, program: &Program, k: usize) -> f64 {
        program
            .matrix(k)
            .iter()
            .map(|e| weight(e) * middle(e) * self.0[e.block][(e.row, column(program.blocks()[e.block], e))])
            .sum()
    }

    /// `tr(F_0 Y)`.
    pub(super) fn value(&self, program: &Program) -> f64 {
        self.inner(program, 0)
    }

    /// The Frobenius norm.
    pub(super) fn size(&self) -> f64 {
        self.0.iter().map(nalgebra::Matrix::norm_squared).sum::<f64>().sqrt()
    }

    /// `Y + shift I`.
    pub(super) fn shifted(mut self, program: &Program, shift: f64) -> Self {
        for (y, block) in self.0.iter_mut().zip(program.blocks()) {
            match *block {
                Block::Dense(n) => (0..n).for_each(|i| y[(i, i)] += shift),
                Block::Diagonal(_) => y.add_scalar_mut(shift),
            }
        }
        self
    }

    /// The point at this fraction of the way to another.
    pub(super) fn towards(&self, other: &Self, share: f64) -> Self {
        Self(self.0.iter().zip(&other.0).map(|(y, z)| y * (1.0 - share) + z * share).collect())
    }

    /// The point in the form that the verification takes.
    pub(super) fn into_blocks(self, program: &Program) -> Vec<DualBlock> {
        self.0
            .into_iter()
            .zip(program.blocks())
            .map(|(y, block)| match *block {
                Block::Diagonal(_) => DualBlock::Diagonal(y.as_slice().to_vec()),
                Block::Dense(n) => DualBlock::Dense(Matrix::from_fn(n, n, |i, j| y[(i.min(j), i.max(j))])),
            })
            .collect()
    }
}

/// The equations `tr(F_i Y) = c_i`, each scaled to norm 1, with the factor of their Gram matrix.
#[derive(Debug)]
pub(super) struct Equations {
    scales: Vec<f64>,
    gram: Option<Cholesky>,
}

impl Equations {
    pub(super) fn of(program: &Program) -> Self {
        let m = program.unknowns();
        let scales: Vec<f64> = (1..=m)
            .map(|i| {
                let norm = program.matrix(i).iter().map(|e| weight(e) * middle(e).powi(2)).sum::<f64>().sqrt();
                if norm > 0.0 { 1.0 / norm } else { 1.0 }
            })
            .collect();
        let mut all: Vec<(usize, &Entry)> =
            (1..=m).flat_map(|i| program.matrix(i).iter().map(move |e| (i - 1, e))).collect();
        let key = |e: &Entry| (e.block, e.row, e.column);
        all.sort_by_key(|(_, e)| key(e));
        let mut gram: Mat<f64> = Mat::zeros(m, m);
        let mut column: Vec<(usize, f64)> = Vec::new();
        for here in all.chunk_by(|(_, a), (_, b)| key(a) == key(b)) {
            let root = weight(here[0].1).sqrt();
            column.clear();
            column.extend(here.iter().map(|(i, x)| (*i, root * scales[*i] * middle(x))));
            for (k, &(j, y)) in column.iter().enumerate() {
                // The lower triangle: at one position the unknowns are in order.
                let to = gram.col_as_slice_mut(j);
                for &(i, x) in &column[k..] {
                    to[i] += x * y;
                }
            }
        }
        Self { scales, gram: Cholesky::of(&gram) }
    }

    /// The nearest matrix that satisfies the equations, with c or with zeros on the right, to rounding.
    pub(super) fn move_onto(&self, program: &Program, mut y: Point, with_costs: bool) -> Point {
        let Some(gram) = &self.gram else { return y };
        // Three rounds: each takes off all but a rounding of what is left.
        for _ in 0..3 {
            let mut step = Mat::from_fn(self.scales.len(), 1, |i, _| {
                let right = if with_costs { program.costs()[i].midpoint_radius().map_or(0.0, |c| c.0) } else { 0.0 };
                self.scales[i] * (right - y.inner(program, i + 1))
            });
            gram.solve_in_place(&mut step);
            for (i, (x, scale)) in step.col_as_slice(0).iter().zip(&self.scales).enumerate() {
                for e in program.matrix(i + 1) {
                    let block = program.blocks()[e.block];
                    let change = x * scale * middle(e);
                    let (row, column) = (e.row, column(block, e));
                    y.0[e.block][(row, column)] += change;
                    if matches!(block, Block::Dense(_)) && row != column {
                        y.0[e.block][(column, row)] += change;
                    }
                }
            }
        }
        y
    }
}
