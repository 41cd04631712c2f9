//! The Schur complement of unknowns that occur in products `sym(L X R)`, as those of `A'P + PA`.
//!
//! With `F_i = sym(L E_pq R)` and `F_j = sym(K E_rs S)`, of two products,
//! ```text
//! 4 tr(F_i V F_j Y) = (L'V K)_pr (R Y S')_qs + (L'V S')_ps (R Y K)_qr + (R V K)_qr (L'Y S')_ps + (R V S')_qs (L'Y K)_pr,
//! ```
//! so that for each j the numbers of all i are a matrix of rank four, whose factors are columns of eight products of
//! matrices: as many operations for each i as the rank, where the entries of F_i cost as many as there are.

use faer::{Mat, MatRef};

use crate::conic::ScaledProduct;
use crate::sequential::{product, product_into};
use crate::variable::{Structure, Variable};

/// `sym(L X R)` of an unknown matrix X, of which each unknown is multiplied by a factor.
#[derive(Debug)]
pub struct Structured {
    variable: Variable,
    /// The first unknown of X.
    offset: usize,
    /// L.
    left: Mat<f64>,
    /// `R'`.
    right: Mat<f64>,
    /// One for each unknown of X.
    factors: Vec<f64>,
}

impl Structured {
    /// The product in a program whose unknown i is `scale[i]` times another.
    pub(super) fn of(scaled: &ScaledProduct, scale: &[f64]) -> Self {
        let ScaledProduct { product, offset, factors } = scaled;
        Self {
            variable: product.variable.clone(),
            offset: *offset,
            left: Mat::from_fn(product.left.nrows(), product.left.ncols(), |i, j| product.left[(i, j)]),
            right: Mat::from_fn(product.right.ncols(), product.right.nrows(), |i, j| product.right[(j, i)]),
            factors: factors.iter().zip(&scale[*offset..]).map(|(factor, scale)| factor * scale).collect(),
        }
    }

    /// The unknowns of X.
    pub(super) fn unknowns(&self) -> std::ops::Range<usize> {
        self.offset..self.offset + self.factors.len()
    }

    fn is_symmetric(&self) -> bool {
        self.variable.structure() == Structure::Symmetric
    }
}

/// Adds `tr(F_i V F_j Y)` once for every pair of unknowns of the products, in either triangle.
pub(super) fn assemble(all: &[Structured], v: MatRef<'_, f64>, y: MatRef<'_, f64>, b: &mut Mat<f64>) {
    for (k, second) in all.iter().enumerate() {
        let right = [&second.left, &second.right];
        let [v, y] = [v, y].map(|m| right.map(|right| product(m, right.as_ref())));
        for (l, first) in all[..=k].iter().enumerate() {
            let left = [first.left.transpose(), first.right.transpose()];
            let pairs = Pairs {
                v: left.map(|left| [product(left, v[0].as_ref()), product(left, v[1].as_ref())]),
                y: left.map(|left| [product(left, y[0].as_ref()), product(left, y[1].as_ref())]),
            };
            pairs.add(first, second, l == k, b);
        }
    }
}

/// Products of V and Y with L' or R on the left, the first index, and K or S' on the right, the second.
struct Pairs {
    v: [[Mat<f64>; 2]; 2],
    y: [[Mat<f64>; 2]; 2],
}

impl Pairs {
    fn add(&self, first: &Structured, second: &Structured, is_same_product: bool, b: &mut Mat<f64>) {
        let is_same_variable = first.offset == second.offset;
        let (rows, columns) = (first.left.ncols(), first.right.ncols());
        let (seconds_rows, seconds_columns) = second.variable.shape();
        // Room for both orders of the factors, if both X are symmetric.
        let mut p = Vec::with_capacity(16 * rows);
        let mut q = Vec::with_capacity(16 * columns);
        let mut numbers = Mat::zeros(rows, columns);
        for s in 0..seconds_columns {
            for r in if second.is_symmetric() { s..seconds_rows } else { 0..seconds_rows } {
                p.clear();
                q.clear();
                self.push((r, s), &mut p, &mut q);
                if second.is_symmetric() && r != s {
                    self.push((s, r), &mut p, &mut q);
                }
                if first.is_symmetric() {
                    let half = p.len();
                    p.extend_from_slice(&q);
                    q.extend_from_within(..);
                    let (both, one) = (q.len() / 2, half);
                    q[both..].copy_from_slice(&p[..one]);
                }
                let Some(j) = second.variable.unknown_at(r, s) else { continue };
                let rank = p.len() / rows;
                product_into(
                    numbers.as_mut(),
                    MatRef::from_column_major_slice(&p, rows, rank),
                    MatRef::from_column_major_slice(&q, columns, rank).transpose(),
                );
                // Of the pairs of one product each once: those from j on.
                let (from_row, from_column) = if is_same_product { (r, s) } else { (0, 0) };
                let factor = 0.25 * second.factors[j];
                let out = &mut b.col_as_slice_mut(second.offset + j)[first.unknowns()];
                for c in from_column..columns {
                    let top = if c == from_column { from_row } else { 0 };
                    let top = if first.is_symmetric() { top.max(c) } else { top };
                    let Some(start) = first.variable.unknown_at(top, c) else { continue };
                    let numbers = &numbers.col_as_slice(c)[top..];
                    for ((out, number), own) in out[start..].iter_mut().zip(numbers).zip(&first.factors[start..]) {
                        *out += factor * own * number;
                    }
                    if first.is_symmetric() && top == c {
                        // A diagonal entry of X counts once.
                        out[start] -= 0.5 * factor * first.factors[start] * numbers[0];
                    }
                }
                if is_same_variable && !is_same_product {
                    // Both orders of the two products fall on the diagonal.
                    let own = if first.is_symmetric() && r == s { 0.5 } else { 1.0 };
                    out[j] += own * factor * first.factors[j] * numbers[(r, s)];
                }
            }
        }
    }

    /// The factors of the matrix of rank four of `F_j = sym(K E_rs S)`.
    fn push(&self, (r, s): (usize, usize), p: &mut Vec<f64>, q: &mut Vec<f64>) {
        let ([v, y], at) = ([&self.v, &self.y], [r, s]);
        for (one, other) in [(v, y), (y, v)] {
            for (left, right) in [(0, 1), (1, 0)] {
                p.extend_from_slice(one[0][left].col_as_slice(at[left]));
                q.extend_from_slice(other[1][right].col_as_slice(at[right]));
            }
        }
    }
}
