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

/// Products of two 64-bit words that an attempt may take, by the lengths of the integers that it multiplies and whose
/// common divisors it finds: about a second. A limit on the work, so that the result does not depend on the machine.
const MOST_WORK: u64 = 4_000_000_000;

/// The work that is left to an attempt, and its time.
struct Budget<F> {
    left: u64,
    is_over: F,
}

impl<F: Fn() -> bool> Budget<F> {
    fn of(is_over: F) -> Self {
        Self { left: MOST_WORK, is_over }
    }

    /// Takes the work of so many products of integers of these lengths in bits; none where it is not left.
    fn spend(&mut self, products: usize, bits: (usize, usize)) -> Option<()> {
        let words = |bits: usize| (bits / 64 + 1) as u64;
        let work = (products as u64).saturating_mul(words(bits.0).saturating_mul(words(bits.1)));
        self.left = self.left.checked_sub(work)?;
        (!(self.is_over)()).then_some(())
    }
}

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

    /// `p self - q other`, primitive, where p and q cancel the entry at `place`; none beyond the budget.
    fn eliminate(&self, place: usize, other: &Self, budget: &mut Budget<impl Fn() -> bool>) -> Option<Self> {
        let (Some(own), Some(pivot)) = (self.coefficient(place), other.coefficient(place)) else {
            return Some(self.clone());
        };
        let (p, q) = (pivot.clone(), own.clone());
        let longest = self.longest().max(other.longest());
        if longest > LONGEST {
            return None;
        }
        // The common divisor of the results, which are twice as long, takes four times the work of a product.
        budget.spend(6 * (self.terms.len() + other.terms.len()), (longest, longest))?;
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
        Some(row)
    }

    fn longest(&self) -> usize {
        self.terms.iter().map(|(_, c)| c.bit_len()).max().unwrap_or(0)
    }
}

/// Integers z, proportional to a point near `start`, on which every row vanishes. None if only zero is found nearby, if
/// the integers or the work grow beyond the limits, or if `is_over` says that the time is.
pub fn solve_near(rows: Vec<Row>, start: &[f64], is_over: impl Fn() -> bool) -> Option<Vec<IBig>> {
    let mut budget = Budget::of(is_over);
    // Each solved row is free of the pivots of all others.
    let mut solved: Vec<(usize, Row)> = Vec::new();
    for mut row in rows {
        for (place, other) in &solved {
            row = row.eliminate(*place, other, &mut budget)?;
        }
        let Some(place) = row.pivot() else { continue };
        for (_, other) in &mut solved {
            *other = other.eliminate(place, &row, &mut budget)?;
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
        budget.spend(8, (row.longest(), row.longest()))?;
        let divisor = if sum.is_zero() { pivot.clone().unsigned_abs() } else { pivot.clone().gcd(&sum) };
        let divisor = IBig::from(divisor);
        let (sum, pivot) = (sum / &divisor, pivot / &divisor);
        let size = pivot.clone().unsigned_abs();
        budget.spend(4, (denominator.bit_len(), size.bit_len()))?;
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
