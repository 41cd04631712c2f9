//! Expansion of an expression: from the syntax tree to the coefficient of every scalar unknown in every entry, or to a
//! matrix if the unknowns have values.
//!
//! Written once over a ring. In binary64 the coefficients are used by the solver; exact coefficients are used to check
//! witnesses; a matrix evaluated over intervals or exactly is proved definite.

use luenberger_proof::{Matrix, Ring};
use nalgebra::DMatrix;

use crate::error::Fault;
use crate::expression::{Expression, Node};
use crate::variable::Variable;

/// Binary64 with rounding errors, for the solver only; no proof depends on it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Rounded(pub(crate) f64);

impl Ring for Rounded {
    fn zero() -> Self {
        Self(0.0)
    }
    fn from_f64(x: f64) -> Option<Self> {
        x.is_finite().then_some(Self(x))
    }
    fn add(&self, rhs: &Self) -> Self {
        Self(self.0 + rhs.0)
    }
    fn sub(&self, rhs: &Self) -> Self {
        Self(self.0 - rhs.0)
    }
    fn mul(&self, rhs: &Self) -> Self {
        Self(self.0 * rhs.0)
    }
    fn neg(&self) -> Self {
        Self(-self.0)
    }
    fn is_zero(&self) -> bool {
        self.0 == 0.0
    }
}

/// One entry of an affine matrix: a constant and the coefficients of the unknowns, in ascending order, none of them
/// zero.
#[derive(Debug, Clone)]
pub struct Entry<R> {
    pub constant: R,
    pub terms: Vec<(usize, R)>,
}

impl<R: Ring> Entry<R> {
    fn zero() -> Self {
        Self { constant: R::zero(), terms: Vec::new() }
    }

    fn accumulate(&mut self, factor: &R, other: &Self) {
        if factor.is_zero() {
            return;
        }
        if !other.constant.is_zero() {
            self.constant = self.constant.add(&factor.mul(&other.constant));
        }
        self.terms.extend(other.terms.iter().map(|(unknown, c)| (*unknown, factor.mul(c))));
    }

    /// Adds up the coefficients of each unknown.
    fn merge(mut self) -> Self {
        self.terms.sort_by_key(|&(unknown, _)| unknown);
        let mut merged: Vec<(usize, R)> = Vec::with_capacity(self.terms.len());
        for (unknown, c) in self.terms {
            match merged.last_mut() {
                Some((last, sum)) if *last == unknown => *sum = sum.add(&c),
                _ => merged.push((unknown, c)),
            }
        }
        merged.retain(|(_, c)| !c.is_zero());
        Self { constant: self.constant, terms: merged }
    }
}

/// A binary64 number as an element of the ring; `None` if it is not finite.
fn number<R: Ring>(value: f64) -> Result<R, Fault> {
    R::from_f64(value).ok_or(Fault::NotFinite { row: 0, column: 0, value })
}

/// The same of a matrix.
fn embed<R: Ring>(m: &DMatrix<f64>) -> Result<Matrix<R>, Fault> {
    let (rows, columns) = m.shape();
    let mut embedded = Matrix::from_fn(rows, columns, |_, _| R::zero());
    for row in 0..rows {
        for column in 0..columns {
            let value = m[(row, column)];
            embedded[(row, column)] = R::from_f64(value).ok_or(Fault::NotFinite { row, column, value })?;
        }
    }
    Ok(embedded)
}

/// The matrix of entries of `e`, which fits together; the unknowns of the variable declared k-th start at `offsets[k]`.
///
/// # Errors
/// [`Fault::NotFinite`] names a constant that no ring has.
pub fn expand<R: Ring>(e: &Expression, offsets: &[usize]) -> Result<Matrix<Entry<R>>, Fault> {
    let (rows, columns) = e.shape();
    let one = number::<R>(1.0)?;
    Ok(match e.node() {
        Node::Constant(m) => embed(m)?.map(|constant: &R| Entry { constant: constant.clone(), terms: Vec::new() }),
        Node::Variable(v) => Matrix::from_fn(rows, columns, |i, j| Entry {
            constant: R::zero(),
            terms: v.unknown_at(i, j).map(|k| (offsets[v.position()] + k, one.clone())).into_iter().collect(),
        }),
        Node::Sum(left, right) => {
            let (left, right) = (expand::<R>(left, offsets)?, expand::<R>(right, offsets)?);
            Matrix::from_fn(rows, columns, |i, j| {
                let mut sum = left[(i, j)].clone();
                sum.accumulate(&one, &right[(i, j)]);
                sum.merge()
            })
        }
        Node::Negation(inner) => multiple(&one.neg(), &expand(inner, offsets)?),
        Node::Multiple(factor, inner) => multiple(&number(*factor)?, &expand(inner, offsets)?),
        Node::LeftProduct(m, inner) => {
            let (m, inner) = (embed::<R>(m)?, expand::<R>(inner, offsets)?);
            Matrix::from_fn(rows, columns, |i, j| {
                let mut sum = Entry::zero();
                for k in 0..inner.rows() {
                    sum.accumulate(&m[(i, k)], &inner[(k, j)]);
                }
                sum.merge()
            })
        }
        Node::RightProduct(inner, m) => {
            let (inner, m) = (expand::<R>(inner, offsets)?, embed::<R>(m)?);
            Matrix::from_fn(rows, columns, |i, j| {
                let mut sum = Entry::zero();
                for k in 0..inner.cols() {
                    sum.accumulate(&m[(k, j)], &inner[(i, k)]);
                }
                sum.merge()
            })
        }
        Node::Scaling(inner, m) => {
            let (inner, m) = (expand::<R>(inner, offsets)?, embed::<R>(m)?);
            Matrix::from_fn(rows, columns, |i, j| {
                let mut scaled = Entry::zero();
                scaled.accumulate(&m[(i, j)], &inner[(0, 0)]);
                scaled.merge()
            })
        }
        Node::Transpose(inner) => expand(inner, offsets)?.transpose(),
        Node::Trace(inner) => {
            let inner = expand::<R>(inner, offsets)?;
            let mut sum = Entry::zero();
            for k in 0..inner.rows() {
                sum.accumulate(&one, &inner[(k, k)]);
            }
            let sum = sum.merge();
            Matrix::from_fn(1, 1, |_, _| sum.clone())
        }
        Node::Blocks(blocks) => {
            let expanded: Vec<Vec<_>> = blocks
                .iter()
                .map(|row| row.iter().map(|e| expand(e, offsets)).collect())
                .collect::<Result<_, Fault>>()?;
            assemble(rows, columns, &expanded)
        }
    })
}

fn multiple<R: Ring>(factor: &R, m: &Matrix<Entry<R>>) -> Matrix<Entry<R>> {
    m.map(|entry| {
        let mut scaled = Entry::zero();
        scaled.accumulate(factor, entry);
        scaled.merge()
    })
}

/// One matrix from blocks that were found to fit.
fn assemble<T: Clone>(rows: usize, columns: usize, blocks: &[Vec<Matrix<T>>]) -> Matrix<T> {
    // Which block a row or column falls into, and where in it.
    let place = |sizes: &mut dyn Iterator<Item = usize>| -> Vec<(usize, usize)> {
        sizes.enumerate().flat_map(|(block, size)| (0..size).map(move |k| (block, k))).collect()
    };
    let row_places = place(&mut blocks.iter().map(|row| row.first().map_or(0, Matrix::rows)));
    let column_places: Vec<Vec<(usize, usize)>> =
        blocks.iter().map(|row| place(&mut row.iter().map(Matrix::cols))).collect();
    Matrix::from_fn(rows, columns, |i, j| {
        let (block_row, k) = row_places[i];
        let (block_column, l) = column_places[block_row][j];
        blocks[block_row][block_column][(k, l)].clone()
    })
}

/// The value of `e` when the variable declared k-th has the value `values[k]`, computed over the ring from the user's
/// constants as they were written.
///
/// # Errors
/// [`Fault::NotFinite`] names a constant, or an entry of a value, that no ring has.
pub fn evaluate<R: Ring>(e: &Expression, values: &[(Variable, DMatrix<f64>)]) -> Result<Matrix<R>, Fault> {
    let (rows, columns) = e.shape();
    Ok(match e.node() {
        Node::Constant(m) => embed(m)?,
        Node::Variable(v) => embed(&values[v.position()].1)?,
        Node::Sum(left, right) => {
            let (left, right) = (evaluate::<R>(left, values)?, evaluate::<R>(right, values)?);
            Matrix::from_fn(rows, columns, |i, j| left[(i, j)].add(&right[(i, j)]))
        }
        Node::Negation(inner) => evaluate::<R>(inner, values)?.map(R::neg),
        Node::Multiple(factor, inner) => {
            let factor = number::<R>(*factor)?;
            evaluate::<R>(inner, values)?.map(|x| factor.mul(x))
        }
        Node::LeftProduct(m, inner) => {
            let (left, right) = (embed::<R>(m)?, evaluate::<R>(inner, values)?);
            Matrix::from_fn(rows, columns, |i, j| dot(right.rows(), |k| (&left[(i, k)], &right[(k, j)])))
        }
        Node::RightProduct(inner, m) => {
            let (left, right) = (evaluate::<R>(inner, values)?, embed::<R>(m)?);
            Matrix::from_fn(rows, columns, |i, j| dot(right.rows(), |k| (&left[(i, k)], &right[(k, j)])))
        }
        Node::Scaling(inner, m) => {
            let factor = evaluate::<R>(inner, values)?[(0, 0)].clone();
            embed::<R>(m)?.map(|x| factor.mul(x))
        }
        Node::Transpose(inner) => evaluate::<R>(inner, values)?.transpose(),
        Node::Trace(inner) => {
            let inner = evaluate::<R>(inner, values)?;
            let sum = (0..inner.rows()).fold(R::zero(), |sum, k| sum.add(&inner[(k, k)]));
            Matrix::from_fn(1, 1, |_, _| sum.clone())
        }
        Node::Blocks(blocks) => {
            let evaluated: Vec<Vec<_>> = blocks
                .iter()
                .map(|row| row.iter().map(|e| evaluate(e, values)).collect())
                .collect::<Result<_, Fault>>()?;
            assemble(rows, columns, &evaluated)
        }
    })
}

fn dot<'a, R: Ring + 'a>(length: usize, factors: impl Fn(usize) -> (&'a R, &'a R)) -> R {
    (0..length).fold(R::zero(), |sum, k| {
        let (x, y) = factors(k);
        if x.is_zero() || y.is_zero() { sum } else { sum.add(&x.mul(y)) }
    })
}

/// The first variable in `e` that is not the one the problem declared at its position.
pub(crate) fn foreign_variable(e: &Expression, declared: &[Variable]) -> Option<String> {
    match e.node() {
        Node::Constant(_) => None,
        Node::Variable(v) => {
            let known = declared.get(v.position()).is_some_and(|own| own.is_same(v));
            (!known).then(|| v.name().to_owned())
        }
        Node::Sum(left, right) => foreign_variable(left, declared).or_else(|| foreign_variable(right, declared)),
        Node::Negation(inner)
        | Node::Multiple(_, inner)
        | Node::LeftProduct(_, inner)
        | Node::RightProduct(inner, _)
        | Node::Scaling(inner, _)
        | Node::Transpose(inner)
        | Node::Trace(inner) => foreign_variable(inner, declared),
        Node::Blocks(blocks) => blocks.iter().flatten().find_map(|e| foreign_variable(e, declared)),
    }
}
