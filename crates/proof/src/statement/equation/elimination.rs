//! Error bound of an approximate solution, from the equation as a linear system with a verified inverse (Krawczyk).

use super::{Enclosure, Kind, Posed};
use crate::error::ProofError;
use crate::interval::Interval;
use crate::matrix::Matrix;
use crate::ring::Ring;
use crate::verdict::UndecidedReason;

/// The order of A up to which the equation is eliminated: a linear system of order 300.
pub const ELIMINATION_ORDER: usize = 24;

impl Posed<'_> {
    pub(super) fn by_elimination(&self) -> Result<Enclosure, ProofError> {
        let n = self.a.rows();
        let operator = operator(self.kind, self.a);
        let undecided =
            |estimate: f64| Ok(Enclosure::Undecided { why: UndecidedReason::ProposalNotProved { estimate } });
        let Some(inverse) = approximate_inverse(&operator.map(|x| x.lo() / 2.0 + x.hi() / 2.0)) else {
            return undecided(0.0);
        };
        let g = Matrix::<Interval>::embed(&inverse, "an approximate inverse")?;
        let order = operator.rows();
        let defect = Matrix::scalar(order, &Interval::ONE).difference(&g.product(&operator)?)?.map(size);
        let upper = Matrix::from_fn(order, 1, |k, _| self.residual[pair(k, n)]);
        let step = g.product(&upper)?.negative();
        // The row sums of |G| know the units of the unknowns.
        let weights: Vec<f64> = (0..order).map(|k| inverse.row(k).iter().map(|x| x.abs()).sum()).collect();
        let v = Matrix::<Interval>::embed(
            &Matrix::from_fn(order, 1, |k, _| weights[k].clamp(f64::MIN_POSITIVE, f64::MAX)),
            "the weights of the unknowns",
        )?;
        let largest_ratio = |x: &Matrix<Interval>| {
            (0..order).fold(0.0_f64, |largest, k| {
                let ratio = size(&x[(k, 0)]).quotient(&v[(k, 0)]).map_or(f64::INFINITY, |ratio| ratio.hi());
                largest.max(ratio)
            })
        };
        let h = largest_ratio(&defect.product(&v)?);
        if h.is_nan() || h >= 1.0 {
            return undecided(1.0 - h);
        }
        let left = (1.0 - h).next_down();
        let Some(reach) = (left > 0.0).then(|| (largest_ratio(&step) / left).next_up()).and_then(Interval::from_f64)
        else {
            return undecided(left);
        };
        let rest = defect.product(&v.scaled(&reach))?;
        let x = Matrix::from_fn(n, n, |i, j| {
            let k = place(i, j, n);
            let bound = rest[(k, 0)].hi();
            step[(k, 0)].add(&Interval::new(-bound, bound).unwrap_or(Interval::UNBOUNDED))
        });
        self.corrected(&x)
    }
}

/// `[0, |x|]` by its upper end, as a number.
fn size(x: &Interval) -> Interval {
    Interval::of(x.magnitude())
}

/// The place of the entry (i, j) in the upper triangle, row by row.
fn place(i: usize, j: usize, n: usize) -> usize {
    let (i, j) = (i.min(j), i.max(j));
    i * (2 * n - i + 1) / 2 + (j - i)
}

/// The entry at that place.
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

/// The inverse by Gauss and Jordan with partial pivoting, in floating point: a proposal. `None` where a pivot vanishes
/// or an entry overflows.
fn approximate_inverse(m: &Matrix<f64>) -> Option<Matrix<f64>> {
    let n = m.rows();
    let mut work = Matrix::from_fn(n, 2 * n, |i, j| {
        if j < n {
            m[(i, j)]
        } else if j - n == i {
            1.0
        } else {
            0.0
        }
    });
    for k in 0..n {
        let pivot_row = (k..n).max_by(|&i, &j| work[(i, k)].abs().total_cmp(&work[(j, k)].abs()))?;
        let pivot = work[(pivot_row, k)];
        if pivot == 0.0 || !pivot.is_finite() {
            return None;
        }
        let mut row: Vec<f64> = work.row(pivot_row).iter().map(|x| x / pivot).collect();
        row[k] = 1.0;
        let displaced = work.row(k).to_vec();
        work.row_mut(pivot_row).copy_from_slice(&displaced);
        for i in (0..n).filter(|&i| i != k) {
            let factor = work[(i, k)];
            if factor != 0.0 {
                for (x, y) in work.row_mut(i).iter_mut().zip(&row).skip(k) {
                    *x -= factor * y;
                }
            }
        }
        work.row_mut(k).copy_from_slice(&row);
    }
    let inverse = Matrix::from_fn(n, n, |i, j| work[(i, n + j)]);
    inverse.as_slice().iter().all(|x| x.is_finite()).then_some(inverse)
}
