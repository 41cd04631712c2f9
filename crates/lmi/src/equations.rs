//! Exact solution of homogeneous linear equations near a given point.
//!
//! Given integer rows and a point z0 in binary64, an integer vector proportional to a point near z0 on which all rows
//! vanish. Method: Gauss-Jordan elimination on sparse integer rows, each kept primitive (divided by the greatest common
//! divisor of its entries), which holds the growth of the integers to that of the answer itself for the
//! block-structured equations of matrix inequalities. The pivot of a row is its largest entry, so that the pivoted
//! unknowns depend mildly on the free ones; the free ones keep their values on a fixed grid.

use dashu_int::ops::{Abs, BitTest, Gcd, UnsignedAbs};
use dashu_int::{IBig, UBig};
use luenberger_proof::Exact;
use luenberger_proof::Ring;

/// The grid on which free unknowns are placed, as a fraction of the largest.
const GRID_BITS: i32 = 44;

/// Integers longer than this abort the attempt: the witness would be too large to check.
const LONGEST: usize = 200_000;

/// A linear equation with integer coefficients, in ascending order of the unknowns, none of them zero.
#[derive(Debug, Clone)]
pub struct Row {
    terms: Vec<(usize, IBig)>,
}

impl Row {
    /// From dyadic coefficients in any order, with repetitions.
    pub fn from_exact(mut terms: Vec<(usize, Exact)>) -> Self {
        terms.sort_by_key(|&(place, _)| place);
        let mut merged: Vec<(usize, Exact)> = Vec::with_capacity(terms.len());
        for (place, c) in terms {
            match merged.last_mut() {
                Some((last, sum)) if *last == place => *sum = sum.add(&c),
                _ => merged.push((place, c)),
            }
        }
        merged.retain(|(_, c)| !c.is_zero());
        let lowest = merged.iter().map(|(_, c)| c.exponent()).min().unwrap_or(0);
        let integer = |c: &Exact| c.mantissa() << usize::try_from(c.exponent() - lowest).unwrap_or(0);
        let mut row = Self { terms: merged.iter().map(|(place, c)| (*place, integer(c))).collect() };
        row.make_primitive();
        row
    }

    pub(crate) fn is_empty(&self) -> bool {
        self.terms.is_empty()
    }

    fn coefficient(&self, place: usize) -> Option<&IBig> {
        self.terms.binary_search_by_key(&place, |&(p, _)| p).ok().map(|k| &self.terms[k].1)
    }

    fn make_primitive(&mut self) {
        let mut divisor = UBig::ZERO;
        for (_, c) in &self.terms {
            divisor = if divisor.is_zero() { c.clone().unsigned_abs() } else { divisor.gcd(c.clone().unsigned_abs()) };
            if divisor.is_one() {
                return;
            }
        }
        if !divisor.is_zero() {
            let divisor = IBig::from(divisor);
            for (_, c) in &mut self.terms {
                *c /= &divisor;
            }
        }
    }

    /// The place of the largest entry.
    fn pivot(&self) -> Option<usize> {
        self.terms.iter().max_by(|x, y| (&x.1).abs().cmp(&(&y.1).abs())).map(|(place, _)| *place)
    }

    /// `p self - q other`, primitive, where p and q cancel the entry at `place`.
    fn eliminate(&self, place: usize, other: &Self) -> Self {
        let (Some(own), Some(pivot)) = (self.coefficient(place), other.coefficient(place)) else { return self.clone() };
        let (p, q) = (pivot.clone(), own.clone());
        let mut terms = Vec::with_capacity(self.terms.len() + other.terms.len());
        let (mut i, mut j) = (0, 0);
        while i < self.terms.len() || j < other.terms.len() {
            let next = match (self.terms.get(i), other.terms.get(j)) {
                (Some((u, c)), Some((v, d))) if u == v => {
                    i += 1;
                    j += 1;
                    (*u, &p * c - &q * d)
                }
                (Some((u, c)), Some((v, _))) if u < v => {
                    i += 1;
                    (*u, &p * c)
                }
                (Some((u, c)), None) => {
                    i += 1;
                    (*u, &p * c)
                }
                (_, Some((v, d))) => {
                    j += 1;
                    (*v, -(&q * d))
                }
                (None, None) => break,
            };
            if !next.1.is_zero() {
                terms.push(next);
            }
        }
        let mut row = Self { terms };
        row.make_primitive();
        row
    }

    fn longest(&self) -> usize {
        self.terms.iter().map(|(_, c)| c.bit_len()).max().unwrap_or(0)
    }
}

/// Integers z, proportional to a point near `start`, on which every row vanishes. None if only zero is found nearby, if
/// the integers grow beyond the limit, or if `is_over` says that the time is.
pub fn solve_near(rows: Vec<Row>, start: &[f64], is_over: impl Fn() -> bool) -> Option<Vec<IBig>> {
    // Each solved row is free of the pivots of all others.
    let mut solved: Vec<(usize, Row)> = Vec::new();
    for mut row in rows {
        for (place, other) in &solved {
            if is_over() {
                return None;
            }
            row = row.eliminate(*place, other);
        }
        let Some(place) = row.pivot() else { continue };
        if row.longest() > LONGEST {
            return None;
        }
        for (_, other) in &mut solved {
            if is_over() {
                return None;
            }
            *other = other.eliminate(place, &row);
        }
        solved.push((place, row));
    }
    let largest = start.iter().fold(0.0f64, |m, x| m.max(x.abs()));
    if largest == 0.0 || !largest.is_finite() {
        return None;
    }
    let grid = 2.0f64.powi(GRID_BITS) / largest;
    // Below 2^45 in size by the choice of the grid.
    let mut z: Vec<IBig> = start.iter().map(|x| IBig::from((x * grid).round() as i64)).collect();
    // Pivoted unknowns become fractions -s / p; one common denominator makes everything integer.
    let mut denominator = UBig::ONE;
    let mut sums = Vec::with_capacity(solved.len());
    for (place, row) in &solved {
        let mut sum = IBig::ZERO;
        let mut pivot = IBig::ONE;
        for (other, c) in &row.terms {
            if other == place {
                pivot.clone_from(c);
            } else {
                sum -= c * &z[*other];
            }
        }
        let divisor = if sum.is_zero() { pivot.clone().unsigned_abs() } else { pivot.clone().gcd(&sum) };
        let divisor = IBig::from(divisor);
        let (sum, pivot) = (sum / &divisor, pivot / &divisor);
        let size = pivot.clone().unsigned_abs();
        let common = denominator.clone().gcd(&size);
        denominator = denominator / common * size;
        if denominator.bit_len() > LONGEST {
            return None;
        }
        sums.push((*place, sum, pivot));
    }
    let denominator = IBig::from(denominator);
    for value in &mut z {
        *value *= &denominator;
    }
    for (place, sum, pivot) in sums {
        z[place] = sum * (&denominator / pivot);
    }
    Some(z)
}
