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
pub(super) struct Structured {
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

#[cfg(test)]
mod tests {
    use faer::Mat;
    use nalgebra::DMatrix;

    use super::super::program::Scaled;
    use super::super::schur;
    use crate::conic::ConicProgram;
    use crate::standard::{Anchor, Small, standard_form};
    use crate::{Problem, block, he};

    /// With two products of the same unknown that cannot be added up (`P - A'PA`), a rectangular unknown, blocks and a
    /// scalar: the matrix is that of the entries.
    #[test]
    fn products_and_entries_give_the_same_matrix() {
        let number = |i: usize, j: usize, k: usize| (((i * 37 + j * 101 + k * 17 + 11) % 64) as f64 - 31.5) / 40.0;
        let n = 7;
        let a = DMatrix::from_fn(n, n, |i, j| number(i, j, 1));
        let (b, c) = (DMatrix::from_fn(n, 2, |i, j| number(i, j, 2)), DMatrix::from_fn(2, n, |i, j| number(i, j, 3)));
        let mut lmi = Problem::new();
        let (p, y, g) = (lmi.symmetric("P", n), lmi.rectangular("Y", n, 2), lmi.scalar("g"));
        lmi.constrain("continuous", (he(&y * &c - &p * &a) + g.identity(n)) >> 0.0);
        lmi.constrain("discrete", (&p - a.transpose() * &p * &a - he(&y * &c)) >> 1.0);
        let top = he(&p * &a) + g.identity(n);
        let corner = &p * &b - 2.0 * &y;
        lmi.constrain("blocks", block![[top, &corner], [corner.transpose(), g.identity(2)]] >> 0.0);
        let standard = standard_form(&lmi, Anchor::Middle, Small::Kept).unwrap();
        let program = |blocks| ConicProgram::new(vec![1.0; standard.cone_unknowns()], blocks);
        let structured = Scaled::of(&program(standard.blocks.clone()));
        let mut plain = standard.blocks.clone();
        for block in &mut plain {
            block.products.clear();
        }
        let plain = Scaled::of(&program(plain));
        let definite = |order: usize, k: usize| {
            let root = Mat::from_fn(order, order, |i, j| number(i, j, k));
            &root * root.transpose()
        };
        for (with, without) in structured.dense.iter().zip(&plain.dense) {
            assert!(!with.products.is_empty() && without.products.is_empty());
            let (v, y) = (definite(with.order, 4), definite(with.order, 5));
            let matrix = |block| {
                let mut b = Mat::zeros(standard.cone_unknowns(), standard.cone_unknowns());
                schur::assemble(block, v.as_ref(), y.as_ref(), &mut b);
                schur::joined(b)
            };
            let (found, expected) = (matrix(with), matrix(without));
            let size = (0..expected.ncols()).map(|k| expected[(k, k)]).fold(0.0, f64::max);
            assert!((found - expected).norm_max() <= 1e-13 * size);
        }
    }
}
