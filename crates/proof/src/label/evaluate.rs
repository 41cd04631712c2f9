//! Formulas over a ring.

use super::parse::Formula;
use super::{Named, Names, Value};
use crate::embed::number;
use crate::error::ProofError;
use crate::matrix::Matrix;
use crate::ring::Ring;

/// A value; an identity takes its size from what it is added to.
#[derive(Debug, Clone)]
pub(super) enum Term<R> {
    Number(R),
    Identity(R),
    Matrix(Matrix<R>),
}

/// The matrix of a formula, of order 1 for a number, with these values of the names.
pub(super) fn matrix<R: Ring>(
    formula: &Formula,
    names: &Names<'_>,
    embedded: &dyn Fn(&Named<'_>) -> Result<Term<R>, ProofError>,
) -> Result<Matrix<R>, ProofError> {
    let evaluation = Evaluation { names, embedded };
    match evaluation.of(formula)? {
        Term::Matrix(m) => Ok(m),
        Term::Number(x) => Matrix::from_row_major(1, 1, vec![x]),
        Term::Identity(_) => Err(meaningless()),
    }
}

/// A number beside a matrix, and the like: no label of this crate.
fn meaningless() -> ProofError {
    ProofError::Label { label: "an expression of numbers and matrices that do not go together".to_owned() }
}

struct Evaluation<'e, R> {
    names: &'e Names<'e>,
    embedded: &'e dyn Fn(&Named<'_>) -> Result<Term<R>, ProofError>,
}

impl<R: Ring> Evaluation<'_, R> {
    fn of(&self, formula: &Formula) -> Result<Term<R>, ProofError> {
        Ok(match formula {
            Formula::Name(place) => (self.embedded)(&self.names.names[*place])?,
            Formula::Number(x) => Term::Number(number(*x, "a number of the inequality")?),
            Formula::Identity => Term::Identity(number(1.0, "1")?),
            Formula::Sum(terms) => self.sum(terms)?,
            Formula::Product(factors) => self.product(&factors.iter().collect::<Vec<_>>())?,
            Formula::Transpose(x) => match self.of(x)? {
                Term::Matrix(m) => Term::Matrix(m.transpose()),
                same => same,
            },
            Formula::Square(x) => match self.of(x)? {
                Term::Number(x) => Term::Number(x.mul(&x)),
                Term::Identity(x) => Term::Identity(x.mul(&x)),
                Term::Matrix(m) => Term::Matrix(m.product(&m)?),
            },
            Formula::He(x) => Term::Matrix(self.matrix(x)?.plus_transpose()?),
            Formula::Trace(_) => self.sum(&[(false, formula.clone())])?,
            Formula::Diagonal(x) => {
                let list = self.matrix(x)?;
                let at = |i: usize, j: usize| if i == j { list[(0, i)].clone() } else { R::zero() };
                Term::Matrix(Matrix::from_fn(list.cols(), list.cols(), at))
            }
            Formula::Blocks(rows) => Term::Matrix(self.blocks(rows)?),
        })
    }

    fn matrix(&self, formula: &Formula) -> Result<Matrix<R>, ProofError> {
        match self.of(formula)? {
            Term::Matrix(m) => Ok(m),
            Term::Number(_) | Term::Identity(_) => Err(meaningless()),
        }
    }

    fn is_number(&self, formula: &Formula) -> bool {
        match formula {
            Formula::Name(place) => matches!(self.names.names[*place].value, Value::Number(_)),
            Formula::Number(_) | Formula::Trace(_) => true,
            Formula::Sum(terms) => terms.iter().all(|(_, term)| self.is_number(term)),
            Formula::Product(factors) => factors.iter().all(|factor| self.is_number(factor)),
            Formula::Transpose(x) | Formula::Square(x) => self.is_number(x),
            Formula::Identity | Formula::He(_) | Formula::Diagonal(_) | Formula::Blocks(_) => false,
        }
    }

    fn is_symmetric(&self, formula: &Formula) -> bool {
        matches!(formula, Formula::Name(place) if self.names.names[*place].is_symmetric)
    }

    /// Numbers first, then the matrices from the right.
    fn product(&self, factors: &[&Formula]) -> Result<Term<R>, ProofError> {
        let (numbers, matrices): (Vec<&Formula>, Vec<&Formula>) =
            factors.iter().partition(|factor| self.is_number(factor));
        let mut coefficient: Option<R> = None;
        // Twice a number is its sum with itself, which is rounded only where it has to be.
        let (twos, numbers): (Vec<&Formula>, Vec<&Formula>) =
            numbers.iter().partition(|factor| ***factor == Formula::Number(2.0));
        for factor in numbers {
            let Term::Number(x) = self.of(factor)? else { return Err(meaningless()) };
            coefficient = Some(coefficient.map_or_else(|| x.clone(), |product| product.mul(&x)));
        }
        let has_coefficient = coefficient.is_some();
        let one: R = number(1.0, "1")?;
        let mut coefficient = coefficient.unwrap_or(one);
        let matrices: Vec<&Formula> = matrices.into_iter().filter(|m| **m != Formula::Identity).collect();
        let is_identity = factors.iter().any(|factor| **factor == Formula::Identity) && matrices.is_empty();
        if has_coefficient || matrices.is_empty() {
            for _ in &twos {
                coefficient = coefficient.add(&coefficient);
            }
        }
        if is_identity {
            return Ok(Term::Identity(coefficient));
        }
        if matrices.is_empty() {
            return Ok(Term::Number(coefficient));
        }
        let mut m = self.chain(&matrices)?;
        if has_coefficient {
            return Ok(Term::Matrix(m.scaled(&coefficient)));
        }
        for _ in &twos {
            m = m.sum(&m)?;
        }
        Ok(Term::Matrix(m))
    }

    /// A product of matrices; `X'PX` and `X'X` symmetric entry by entry.
    fn chain(&self, matrices: &[&Formula]) -> Result<Matrix<R>, ProofError> {
        if let [Formula::Transpose(x), rest @ ..] = matrices {
            let is_x = |factors: &[&Formula]| factors.iter().copied().eq(x.factors());
            if is_x(rest) {
                let x = self.matrix(x)?;
                return x.congruence(&Matrix::scalar(x.rows(), &number(1.0, "1")?));
            }
            if let [p, rest @ ..] = rest
                && self.is_symmetric(p)
                && is_x(rest)
            {
                return self.matrix(x)?.congruence(&self.matrix(p)?);
            }
        }
        let [rest @ .., last] = matrices else { return Err(meaningless()) };
        rest.iter().rev().try_fold(self.matrix(last)?, |product, factor| self.matrix(factor)?.product(&product))
    }

    /// The transpose in the form in which labels have it.
    fn transposed(&self, formula: &Formula) -> Formula {
        match formula {
            Formula::Transpose(x) => (**x).clone(),
            Formula::Product(factors) => {
                let (numbers, matrices): (Vec<&Formula>, Vec<&Formula>) =
                    factors.iter().partition(|factor| self.is_number(factor));
                let transposed = matrices.into_iter().rev().map(|factor| self.transposed(factor));
                Formula::Product(numbers.into_iter().cloned().chain(transposed).collect())
            }
            symmetric if self.is_number(symmetric) || self.is_symmetric(symmetric) => symmetric.clone(),
            other => Formula::Transpose(Box::new(other.clone())),
        }
    }

    /// The term X of `X + X'`, and the places of both; that of `He(X)` twice.
    fn half<'f>(&self, terms: &'f [(bool, Formula)]) -> Option<(&'f Formula, usize, usize)> {
        for (i, (sign, term)) in terms.iter().enumerate().filter(|(_, (_, term))| !self.is_number(term)) {
            if let Formula::He(x) = term {
                return Some((&**x, i, i));
            }
            let mirrored = self.transposed(term);
            let j = (i + 1..terms.len()).find(|&j| terms[j] == (*sign, mirrored.clone()));
            if let Some(j) = j {
                let is_transposed = matches!(term.factors().first(), Some(Formula::Transpose(_)));
                let other = &terms[j].1;
                let both = matches!(other.factors().first(), Some(Formula::Transpose(_)));
                return Some((if is_transposed && !both { other } else { term }, i, j));
            }
        }
        None
    }

    /// The numbers r of a term `2 r P`.
    fn shift(&self, term: &Formula, p: &Formula) -> Result<Option<R>, ProofError> {
        let [Formula::Number(2.0), numbers @ .., last] = term.factors() else { return Ok(None) };
        if last != p || numbers.is_empty() || !numbers.iter().all(|factor| self.is_number(factor)) {
            return Ok(None);
        }
        match self.product(&numbers.iter().collect::<Vec<_>>())? {
            Term::Number(x) => Ok(Some(x)),
            Term::Identity(_) | Term::Matrix(_) => Ok(None),
        }
    }

    /// `A(w I + X)` of `w A + A X`.
    fn factored(&self, terms: &[(bool, Formula)]) -> Result<Option<Term<R>>, ProofError> {
        let [(false, Formula::Product(multiple)), (false, Formula::Product(product))] = terms else { return Ok(None) };
        let ([numbers @ .., a], [b, rest @ ..]) = (multiple.as_slice(), product.as_slice()) else { return Ok(None) };
        if a != b || numbers.is_empty() || !numbers.iter().all(|factor| self.is_number(factor)) {
            return Ok(None);
        }
        let Term::Number(w) = self.product(&numbers.iter().collect::<Vec<_>>())? else { return Ok(None) };
        let x = self.chain(&rest.iter().collect::<Vec<_>>())?;
        Ok(Some(Term::Matrix(self.matrix(a)?.product(&Matrix::scalar(x.rows(), &w).sum(&x)?)?)))
    }

    fn sum(&self, terms: &[(bool, Formula)]) -> Result<Term<R>, ProofError> {
        if let Some(product) = self.factored(terms)? {
            return Ok(product);
        }
        let mut symmetric: Option<(usize, Matrix<R>)> = None;
        let mut done = Vec::new();
        if let Some((x, first, second)) = self.half(terms) {
            done.extend((first != second).then_some(second));
            let mut shift = None;
            if let [p, _, ..] = x.factors()
                && self.is_symmetric(p)
            {
                for (k, (sign, term)) in terms.iter().enumerate() {
                    if k != first && k != second && *sign == terms[first].0 && shift.is_none() {
                        shift = self.shift(term, p)?.map(|number| (number, k));
                    }
                }
            }
            let product = match (&shift, x.factors()) {
                // PF + F'P + 2 r P = P(F + r I) and its transpose.
                (Some((number, k)), [p, rest @ ..]) => {
                    done.push(*k);
                    let flow = self.chain(&rest.iter().collect::<Vec<_>>())?;
                    let shifted = flow.sum(&Matrix::scalar(flow.rows(), number))?;
                    self.matrix(p)?.product(&shifted)?
                }
                _ => self.matrix(x)?,
            };
            symmetric = Some((first, product.plus_transpose()?));
        }
        let mut sum: Option<Term<R>> = None;
        for (k, (is_subtracted, term)) in terms.iter().enumerate().filter(|(k, _)| !done.contains(k)) {
            let mut add = |value| {
                sum = Some(plus(sum.take(), *is_subtracted, value)?);
                Ok::<(), ProofError>(())
            };
            match (&symmetric, term) {
                (Some((place, m)), _) if *place == k => add(Term::Matrix(m.clone()))?,
                (_, Formula::Trace(x)) => {
                    let m = self.matrix(x)?;
                    (0..m.rows()).try_for_each(|i| add(Term::Number(m[(i, i)].clone())))?;
                }
                _ => add(self.of(term)?)?,
            }
        }
        Ok(sum.unwrap_or(Term::Number(R::zero())))
    }

    fn blocks(&self, rows: &[Vec<Option<Formula>>]) -> Result<Matrix<R>, ProofError> {
        let mut grid: Vec<Vec<Option<Term<R>>>> = Vec::with_capacity(rows.len());
        for row in rows {
            grid.push(
                row.iter().map(|entry| entry.as_ref().map(|x| self.of(x)).transpose()).collect::<Result<_, _>>()?,
            );
        }
        // The blocks left out, from those opposite.
        let mut full = Vec::with_capacity(grid.len());
        for (i, row) in grid.iter().enumerate() {
            let entry = |(j, entry): (usize, &Option<Term<R>>)| match entry {
                Some(entry) => Ok(entry.clone()),
                None => match grid.get(j).and_then(|row| row.get(i)) {
                    Some(Some(Term::Matrix(m))) => Ok(Term::Matrix(m.transpose())),
                    Some(Some(other)) => Ok(other.clone()),
                    _ => Err(meaningless()),
                },
            };
            full.push(row.iter().enumerate().map(entry).collect::<Result<Vec<_>, _>>()?);
        }
        let columns = full.first().map_or(0, Vec::len);
        let (mut heights, mut widths) = (vec![None; full.len()], vec![None; columns]);
        for (i, row) in full.iter().enumerate() {
            for (j, entry) in row.iter().enumerate() {
                if let Term::Matrix(m) = entry {
                    (heights[i], widths[j]) = (Some(m.rows()), Some(m.cols()));
                }
            }
        }
        // An identity is square; a number without a matrix beside it is a matrix of order 1.
        for (i, row) in full.iter().enumerate() {
            for (j, entry) in row.iter().enumerate().filter(|(_, entry)| !matches!(entry, Term::Matrix(_))) {
                if matches!(entry, Term::Identity(_)) || i == j {
                    (heights[i], widths[j]) = (heights[i].or(widths[j]), widths[j].or(heights[i]));
                }
            }
        }
        let places = |sizes: &[Option<usize>]| -> Vec<(usize, usize)> {
            let sizes = sizes.iter().enumerate().map(|(k, size)| (k, size.unwrap_or(1)));
            sizes.flat_map(|(k, size)| (0..size).map(move |at| (k, at))).collect()
        };
        let (rows, columns) = (places(&heights), places(&widths));
        for (i, row) in full.iter().enumerate() {
            for (j, entry) in row.iter().enumerate() {
                let shape = (heights[i].unwrap_or(1), widths[j].unwrap_or(1));
                match entry {
                    Term::Matrix(m) => m.expect_shape("a block", shape)?,
                    Term::Number(x) | Term::Identity(x) if shape.0 != shape.1 && !x.is_zero() => {
                        return Err(meaningless());
                    }
                    Term::Number(_) | Term::Identity(_) => {}
                }
            }
        }
        Ok(Matrix::from_fn(rows.len(), columns.len(), |i, j| {
            let ((block, i), (beside, j)) = (rows[i], columns[j]);
            match &full[block][beside] {
                Term::Matrix(m) => m[(i, j)].clone(),
                Term::Number(x) | Term::Identity(x) if i == j => x.clone(),
                Term::Number(_) | Term::Identity(_) => R::zero(),
            }
        }))
    }
}

/// `sum + value`, or `sum - value`.
fn plus<R: Ring>(sum: Option<Term<R>>, is_subtracted: bool, value: Term<R>) -> Result<Term<R>, ProofError> {
    let numbers = |x: &R, y: &R| if is_subtracted { x.sub(y) } else { x.add(y) };
    let matrices = |x: &Matrix<R>, y: &Matrix<R>| if is_subtracted { x.difference(y) } else { x.sum(y) };
    Ok(match (sum, value) {
        (None, value) if !is_subtracted => value,
        (None, Term::Number(x)) => Term::Number(x.neg()),
        (None, Term::Identity(x)) => Term::Identity(x.neg()),
        (None, Term::Matrix(m)) => Term::Matrix(m.negative()),
        (Some(Term::Number(x)), Term::Number(y)) => Term::Number(numbers(&x, &y)),
        (Some(Term::Identity(x)), Term::Identity(y)) => Term::Identity(numbers(&x, &y)),
        (Some(Term::Matrix(x)), Term::Matrix(y)) => Term::Matrix(matrices(&x, &y)?),
        (Some(Term::Matrix(x)), Term::Identity(y)) => Term::Matrix(matrices(&x, &Matrix::scalar(x.rows(), &y))?),
        (Some(Term::Identity(x)), Term::Matrix(y)) => Term::Matrix(matrices(&Matrix::scalar(y.rows(), &x), &y)?),
        _ => return Err(meaningless()),
    })
}
