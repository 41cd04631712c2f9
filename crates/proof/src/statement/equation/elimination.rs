//! Error bound of an approximate solution, from the equation as a linear system with a verified inverse (Krawczyk).

use super::super::linear_system::VerifiedInverse;
use super::{Enclosure, Kind, Posed};
use crate::error::ProofError;
use crate::interval::Interval;
use crate::matrix::Matrix;
use crate::ring::Ring;
use crate::verdict::UndecidedReason;

/// Largest order of A for which the equation is solved as a linear system, of order 300.
pub const ELIMINATION_ORDER: usize = 24;

impl Posed<'_> {
    pub(super) fn by_elimination(&self) -> Result<Enclosure, ProofError> {
        let n = self.a.rows();
        let operator = operator(self.kind, self.a);
        let undecided =
            |estimate: f64| Ok(Enclosure::Undecided { why: UndecidedReason::ProposalNotProved { estimate } });
        let inverse = match VerifiedInverse::of(&operator)? {
            Ok(inverse) => inverse,
            Err(estimate) => return undecided(estimate),
        };
        let upper = Matrix::from_fn(operator.rows(), 1, |k, _| self.residual[pair(k, n)].neg());
        let step = match inverse.times(&upper)? {
            Ok(step) => step,
            Err(estimate) => return undecided(estimate),
        };
        let x = Matrix::from_fn(n, n, |i, j| step[(place(i, j, n), 0)]);
        self.corrected(&x)
    }
}

/// Index of the entry (i, j) in the upper triangle, row by row.
fn place(i: usize, j: usize, n: usize) -> usize {
    let (i, j) = (i.min(j), i.max(j));
    i * (2 * n - i + 1) / 2 + (j - i)
}

/// Row and column of that index.
fn pair(k: usize, n: usize) -> (usize, usize) {
    let (mut i, mut first) = (0, 0);
    while first + (n - i) <= k {
        first += n - i;
        i += 1;
    }
    (i, i + (k - first))
}

/// T as a matrix on the upper triangles of symmetric matrices.
fn operator(kind: Kind, a: &Matrix<Interval>) -> Matrix<Interval> {
    let n = a.rows();
    let order = n * (n + 1) / 2;
    let mut m = Matrix::<Interval>::zeros(order, order);
    for i in 0..n {
        for j in i..n {
            let row = place(i, j, n);
            let mut add = |k: usize, l: usize, coefficient: Interval| {
                let column = place(k, l, n);
                m[(row, column)] = m[(row, column)].add(&coefficient);
            };
            match kind {
                // sum_k A_ki X_kj + X_ik A_kj.
                Kind::Lyapunov => {
                    for k in 0..n {
                        add(k, j, a[(k, i)]);
                        add(i, k, a[(k, j)]);
                    }
                }
                // sum_kl A_ki X_kl A_lj - X_ij.
                Kind::Stein => {
                    for k in 0..n {
                        for l in 0..n {
                            add(k, l, a[(k, i)].mul(&a[(l, j)]));
                        }
                    }
                    add(i, j, Interval::ONE.neg());
                }
            }
        }
    }
    m
}
