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
pub fn products(e: &Expression) -> Vec<Product> {
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
