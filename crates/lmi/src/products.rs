//! The linear part of a symmetric expression as products of the unknown matrices: the sum of `sym(L X R)`, with `sym M
//! = (M + M')/2`.
//!
//! The interior-point method assembles its matrix from these at a cost of n^2 for an unknown of X, where the entries of
//! `A'P + PA` cost that for every pair of unknowns: see [`interior`](crate::interior).

use std::collections::BTreeSet;

use nalgebra::DMatrix;

use crate::conic::Product;
use crate::expression::{Expression, Node};
use crate::variable::{Structure, Variable};

/// The products of the symmetric and rectangular unknowns of `e`, which is square and symmetric. An unknown that also
/// occurs in another way (in a trace, as the factor of a matrix) is left out.
pub(crate) fn products(e: &Expression) -> Vec<Product> {
    let identity = DMatrix::identity(e.shape().0, e.shape().0);
    let mut found = Found { products: Vec::new(), others: BTreeSet::new() };
    found.walk(e, &identity, &identity);
    let Found { mut products, others } = found;
    products.retain(|product| !others.contains(&product.variable.position()));
    products
}

struct Found {
    products: Vec<Product>,
    /// The variables that also occur in another way, by their positions.
    others: BTreeSet<usize>,
}

impl Found {
    /// Adds `sym(left e right)`.
    fn walk(&mut self, e: &Expression, left: &DMatrix<f64>, right: &DMatrix<f64>) {
        match e.node() {
            Node::Constant(_) => {}
            Node::Variable(v) => match v.structure() {
                Structure::Symmetric | Structure::Rectangular => self.add(v, left, right),
                Structure::Diagonal | Structure::Scalar => _ = self.others.insert(v.position()),
            },
            Node::Sum(one, other) => {
                self.walk(one, left, right);
                self.walk(other, left, right);
            }
            Node::Negation(inner) => self.walk(inner, &-left, right),
            Node::Multiple(factor, inner) => self.walk(inner, &(left * *factor), right),
            Node::LeftProduct(m, inner) => self.walk(inner, &(left * m), right),
            Node::RightProduct(inner, m) => self.walk(inner, left, &(m * right)),
            Node::Transpose(inner) => self.walk(inner, &right.transpose(), &left.transpose()),
            Node::Scaling(inner, _) | Node::Trace(inner) => self.leave_out(inner),
            Node::Blocks(blocks) => {
                let mut row = 0;
                for line in blocks {
                    let height = line.first().map_or(0, |e| e.shape().0);
                    let mut column = 0;
                    for e in line {
                        let width = e.shape().1;
                        let (left, right) = (left.columns(row, height), right.rows(column, width));
                        self.walk(e, &left.into_owned(), &right.into_owned());
                        column += width;
                    }
                    row += height;
                }
            }
        }
    }

    /// Adds `sym(L X R)`, to a product with the same L or R where there is one.
    fn add(&mut self, v: &Variable, left: &DMatrix<f64>, right: &DMatrix<f64>) {
        let mut ways = vec![(left.clone(), right.clone())];
        if v.structure() == Structure::Symmetric {
            ways.push((right.transpose(), left.transpose()));
        }
        for product in self.products.iter_mut().filter(|product| product.variable.is_same(v)) {
            for (left, right) in &ways {
                if product.left == *left {
                    product.right += right;
                    return;
                }
                if product.right == *right {
                    product.left += left;
                    return;
                }
            }
        }
        self.products.push(Product { variable: v.clone(), left: left.clone(), right: right.clone() });
    }

    fn leave_out(&mut self, e: &Expression) {
        match e.node() {
            Node::Constant(_) => {}
            Node::Variable(v) => _ = self.others.insert(v.position()),
            Node::Sum(one, other) => {
                self.leave_out(one);
                self.leave_out(other);
            }
            Node::Negation(inner)
            | Node::Multiple(_, inner)
            | Node::LeftProduct(_, inner)
            | Node::RightProduct(inner, _)
            | Node::Scaling(inner, _)
            | Node::Transpose(inner)
            | Node::Trace(inner) => self.leave_out(inner),
            Node::Blocks(blocks) => blocks.iter().flatten().for_each(|e| self.leave_out(e)),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Problem, block, he, zeros};

    fn symmetric_part(m: &DMatrix<f64>) -> DMatrix<f64> {
        (m + m.transpose()) * 0.5
    }

    #[test]
    fn a_lyapunov_operator_is_one_product_however_it_is_written() {
        let a = DMatrix::from_fn(3, 3, |i, j| 0.3 * i as f64 - 0.7 * j as f64 + 0.1);
        let mut lmi = Problem::new();
        let p = lmi.symmetric("P", 3);
        for e in [he(&p * &a), a.transpose() * &p + &p * &a, &p * &a + (&p * &a).transpose()] {
            let found = products(&e);
            assert_eq!(found.len(), 1);
            let x = DMatrix::from_fn(3, 3, |i, j| (1 + i * j) as f64);
            let value = symmetric_part(&(&found[0].left * &x * &found[0].right));
            assert!((value - (a.transpose() * &x + &x * &a)).amax() < 1e-13);
        }
    }

    /// The sum of the products at random values is the expression without its constants and its other unknowns.
    #[test]
    fn products_in_blocks_have_the_value_of_the_expression() {
        let mut lmi = Problem::new();
        let (p, y, g) = (lmi.symmetric("P", 3), lmi.rectangular("Y", 3, 2), lmi.scalar("g"));
        let a = DMatrix::from_fn(3, 3, |i, j| 0.1 * (i + 1) as f64 - 0.3 * j as f64);
        let (b, c) = (DMatrix::from_element(3, 2, 0.4), DMatrix::from_fn(2, 3, |i, j| 0.7 - 0.2 * (i * j) as f64));
        let top = he(&p * &a - &y * &c) + 0.3 * DMatrix::<f64>::identity(3, 3);
        let corner = &p * &b - 2.0 * &y;
        let e = block![[&top, &corner], [corner.transpose(), zeros(2, 2) - g.identity(2)]];
        let (p, y) = (
            DMatrix::from_fn(3, 3, |i, j| (1 + i * j) as f64),
            DMatrix::from_fn(3, 2, |i, j| i as f64 - 0.6 * j as f64),
        );
        let top = {
            let half = &p * &a - &y * &c;
            &half + half.transpose()
        };
        let corner = &p * &b - &y * 2.0;
        let mut expected = DMatrix::zeros(5, 5);
        expected.view_mut((0, 0), (3, 3)).copy_from(&top);
        expected.view_mut((0, 3), (3, 2)).copy_from(&corner);
        expected.view_mut((3, 0), (2, 3)).copy_from(&corner.transpose());
        let found = products(&e);
        assert!(found.iter().all(|product| product.variable.name() != "g"));
        let sum = found.iter().fold(DMatrix::zeros(5, 5), |sum, product| {
            let x = if product.variable.name() == "P" { &p } else { &y };
            sum + symmetric_part(&(&product.left * x * &product.right))
        });
        assert!((sum - expected).amax() < 1e-13);
    }

    #[test]
    fn an_unknown_in_a_trace_is_left_out() {
        let mut lmi = Problem::new();
        let p = lmi.symmetric("P", 2);
        assert!(products(&(&p + p.trace() * &DMatrix::<f64>::identity(2, 2))).is_empty());
    }
}
