//! The four statements of the [module](super), each proved from one approximate point.

use super::gram::{inner, is_above, norm};
use super::{Block, DualBlock, Program};
use crate::definite::positive_definite;
use crate::interval::Interval;
use crate::matrix::Matrix;
use crate::ring::Ring;
use crate::verdict::Verdict;

/// Bounds from a feasible point of (P).
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PrimalBound {
    /// An upper bound of c'x, and so of the optimum.
    pub value: f64,
    /// A lower bound of the smallest eigenvalue of X(x).
    pub margin: f64,
}

/// Bounds from a feasible point or a ray of (D) near the given approximate one.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct DualBound {
    /// A lower bound of `tr(F_0 Y*)`; for a feasible point also of the optimum.
    pub value: f64,
    /// An upper bound of the Frobenius distance from the given Y to the exact Y*, which satisfies the equations.
    pub distance: f64,
}

impl Program {
    /// Proves that the optimum of (P) is at most c'x; `None` unless X(x) >= 0 is proved. Cost: a dozen Cholesky
    /// factorisations of the blocks.
    pub fn upper_bound(&self, x: &[f64]) -> Option<PrimalBound> {
        let (slack, value) = (self.combination(x, true)?, self.cost(x)?);
        Some(PrimalBound { value: value.hi(), margin: smallest_eigenvalue(&slack)? }).filter(|b| b.value.is_finite())
    }

    /// Proves that the optimum of (P) is at least `tr(F_0 Y) - error`; `None` unless a feasible point of (D) is proved
    /// to exist near Y.
    ///
    /// The blocks of Y must be symmetric. Cost: one Cholesky factorisation of each block; at the first call also a few
    /// of order m, if Gershgorin circles do not suffice.
    pub fn lower_bound(&self, y: &[DualBlock]) -> Option<DualBound> {
        self.dual(y, |i| self.costs()[i]).filter(|bound| bound.value.is_finite())
    }

    /// Proves that (P) has no feasible point: a ray Y* >= 0 of (D) with `tr(F_i Y*) = 0` and `tr(F_0 Y*) > 0` exists
    /// near Y. A feasible X would give `0 <= tr(X Y*) = -tr(F_0 Y*) < 0`. The bound is that of `tr(F_0 Y*)`.
    pub fn is_primal_infeasible(&self, y: &[DualBlock]) -> Option<DualBound> {
        self.dual(y, |_| Interval::zero()).filter(|bound| bound.value > 0.0)
    }

    /// Proves that (D) has no feasible point: `x_1 F_1 + ... + x_m F_m >= 0` and c'x < 0. A feasible Y would give
    /// `0 > c'x = tr((x_1 F_1 + ...) Y) >= 0`. The bound is that of c'x.
    pub fn is_dual_infeasible(&self, x: &[f64]) -> Option<PrimalBound> {
        let (combination, value) = (self.combination(x, false)?, self.cost(x)?);
        (value.hi() < 0.0)
            .then(|| Some(PrimalBound { value: value.hi(), margin: smallest_eigenvalue(&combination)? }))
            .flatten()
    }

    fn cost(&self, x: &[f64]) -> Option<Interval> {
        let mut sum = Interval::zero();
        for (c, x) in self.costs().iter().zip(x) {
            sum = sum.add(&c.mul(&Interval::from_f64(*x)?));
        }
        Some(sum)
    }

    /// `x_1 F_1 + ... + x_m F_m`, minus F_0 if `less_constant`. `None` if x has another length or is not finite.
    fn combination(&self, x: &[f64], less_constant: bool) -> Option<Vec<Slack>> {
        if x.len() != self.unknowns() {
            return None;
        }
        let mut sum: Vec<Slack> = self
            .blocks()
            .iter()
            .map(|block| match *block {
                Block::Dense(n) => Slack::Dense(Matrix::from_fn(n, n, |_, _| Interval::zero())),
                Block::Diagonal(n) => Slack::Diagonal(vec![Interval::zero(); n]),
            })
            .collect();
        let constant = if less_constant { -1.0 } else { 0.0 };
        for (k, factor) in std::iter::once(&constant).chain(x).enumerate() {
            let factor = Interval::from_f64(*factor)?;
            if factor.is_zero() {
                continue;
            }
            for entry in self.matrix(k) {
                let at = match &mut sum[entry.block] {
                    Slack::Dense(m) => &mut m[(entry.row, entry.column)],
                    Slack::Diagonal(d) => &mut d[entry.row],
                };
                *at = at.add(&factor.mul(&entry.value));
            }
        }
        for block in &mut sum {
            if let Slack::Dense(m) = block {
                for i in 0..m.rows() {
                    for j in 0..i {
                        m[(i, j)] = m[(j, i)];
                    }
                }
            }
        }
        Some(sum)
    }

    fn dual(&self, y: &[DualBlock], right_side: impl Fn(usize) -> Interval) -> Option<DualBound> {
        // Checks shapes and finite entries first: the code below indexes by position.
        if !is_above(self.blocks(), y, 0.0) {
            return None;
        }
        let residuals: Vec<Interval> =
            (0..self.unknowns()).map(|i| right_side(i).sub(&inner(self.matrix(i + 1), y))).collect();
        let distance = self.equations()?.distance(&residuals);
        if !(distance.is_finite() && is_above(self.blocks(), y, distance)) {
            return None;
        }
        let error = (distance * norm(self.matrix(0))).next_up();
        Some(DualBound { value: (inner(self.matrix(0), y).lo() - error).next_down(), distance })
    }
}

/// A block of X.
enum Slack {
    Dense(Matrix<Interval>),
    Diagonal(Vec<Interval>),
}

/// A proved lower bound of the smallest eigenvalue of all blocks; `None` if it is negative or not proved.
fn smallest_eigenvalue(blocks: &[Slack]) -> Option<f64> {
    blocks.iter().try_fold(f64::INFINITY, |smallest, block| {
        let here = match block {
            Slack::Dense(m) => match positive_definite(m) {
                Ok(Verdict::Proved { margin }) => margin,
                _ => return None,
            },
            Slack::Diagonal(d) => d.iter().map(Interval::lo).fold(f64::INFINITY, f64::min),
        };
        (here >= 0.0).then(|| smallest.min(here))
    })
}
