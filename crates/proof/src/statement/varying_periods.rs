//! Decrease of a quadratic form for every time between two corrections of a sampled observer.
//!
//! After the correction `e -> M e` the error grows by `exp(A t)`. Required for all t between two bounds:
//! ```text
//! W(t) = factor^2 P - X(t)'P X(t) > 0,     X(t) = exp(A t) M.
//! ```
//! The time interval is divided into cells. On a cell `[c - r, c + r]` the mean value theorem gives `W(t)` in
//! `W(c) + [-r, r] X'(A'P + PA)X`, with X enclosed on the cell by `(I + E) X(c)`, `|E| <= exp(r |A|) - I` entry by
//! entry. W(c) and the exponentials are computed in intervals. A cell for which this is not positive definite is
//! halved, up to [`MOST_CELLS`] cells of an interval and to [`MOST_WORK`] of all intervals of a certificate.

use super::exponential::exponential;
use super::{embed, embed_symmetric, number};
use crate::definite::{self, Direction, Sense};
use crate::error::ProofError;
use crate::interval::Interval;
use crate::matrix::Matrix;
use crate::ring::Ring;
use crate::verdict::{UndecidedReason, Verdict};

/// Maximum number of cells of one interval of times.
const MOST_CELLS: usize = 1 << 14;

/// Maximum of the cells of all intervals, each weighted with the cube of the order: half a minute.
const MOST_WORK: usize = 1 << 24;

/// The work that is left for the intervals of times of one certificate. It is counted, not timed: the result is the
/// same on every machine.
#[derive(Debug)]
pub(crate) struct Effort(usize);

impl Default for Effort {
    fn default() -> Self {
        Self(MOST_WORK)
    }
}

/// `factor^2 P - X'P X > 0` with `X = exp(A t) M` for every t in `times`, for the numbers as stored and every M within
/// its bounds.
///
/// `A` and `M` n x n, `P` symmetric n x n. The margin returned is 0, because it depends on t.
/// # Errors
/// [`ProofError`] for inconsistent shapes, entries that are not finite, or a `P` that is not symmetric.
/// ```
/// use luenberger_proof::{Interval, Matrix, statement::decrease_over_times};
/// # fn main() -> Result<(), luenberger_proof::ProofError> {
/// // e' = e between corrections that halve e: exp(t)/2 < 0.9 for t up to log(1.8) = 0.587..
/// let number = |x: f64| Matrix::from_rows([[x]]);
/// let half = Matrix::from_rows([[Interval::of(0.5)]]);
/// let until = |end| decrease_over_times(&number(1.0), &half, &number(1.0), 0.9, (0.1, end));
/// assert!(until(0.587)?.is_proved());
/// assert!(until(0.6)?.is_refuted());
/// # Ok(())
/// # }
/// ```
pub fn decrease_over_times(
    a: &Matrix<f64>,
    map: &Matrix<Interval>,
    p: &Matrix<f64>,
    factor: f64,
    times: (f64, f64),
) -> Result<Verdict<Direction>, ProofError> {
    Effort::default().decrease_over_times(a, map, p, factor, times)
}

impl Effort {
    /// As [`decrease_over_times`]; undecided as well where the work that is left does not suffice.
    pub(crate) fn decrease_over_times(
        &mut self,
        a: &Matrix<f64>,
        map: &Matrix<Interval>,
        p: &Matrix<f64>,
        factor: f64,
        times: (f64, f64),
    ) -> Result<Verdict<Direction>, ProofError> {
        let n = a.rows();
        let (a, p) = (embed::<Interval>(a, "A", (n, n))?, embed_symmetric::<Interval>(p, "P", n)?);
        map.expect_shape("M", (n, n))?;
        let factor = number::<Interval>(factor, "the factor")?;
        let cells = Cells {
            level: p.scaled(&factor.mul(&factor)),
            growth: p.product(&a)?.plus_transpose()?,
            magnitudes: a.map(|x| Interval::of(x.magnitude())),
            a,
            p,
            map,
        };
        let undecided = |best| Ok(Verdict::Undecided { why: UndecidedReason::NotByThisMatrix { name: "P" }, best });
        let mut open = vec![times];
        let mut count = 0;
        while let Some((from, to)) = open.pop() {
            count += 1;
            // The empty matrix costs as well.
            match self.0.checked_sub(n.saturating_pow(3).max(1)) {
                Some(left) => self.0 = left,
                None => return Ok(Verdict::Undecided { why: UndecidedReason::TooMuchWork, best: f64::NAN }),
            }
            let middle = from + (to - from) / 2.0;
            let radius = (to - middle).max(middle - from).next_up();
            let Some(at_middle) = cells.enclosed(middle)? else { return undecided(f64::NAN) };
            let point = definite::decide(&cells.form(&at_middle)?, Sense::PositiveDefinite)?;
            if !point.is_proved() {
                return Ok(point);
            }
            if cells.holds_around(&at_middle, radius)? {
                continue;
            }
            if count + open.len() >= MOST_CELLS || middle <= from || middle >= to {
                return undecided(point.margin().unwrap_or(0.0));
            }
            open.extend([(middle, to), (from, middle)]);
        }
        Ok(Verdict::Proved { margin: 0.0 })
    }
}

struct Cells<'a> {
    a: Matrix<Interval>,
    /// `|A|`, entry by entry.
    magnitudes: Matrix<Interval>,
    p: Matrix<Interval>,
    /// `factor^2 P`.
    level: Matrix<Interval>,
    /// `A'P + PA`.
    growth: Matrix<Interval>,
    map: &'a Matrix<Interval>,
}

impl Cells<'_> {
    /// `X(t)`.
    fn enclosed(&self, t: f64) -> Result<Option<Matrix<Interval>>, ProofError> {
        match exponential(&self.a.scaled(&Interval::of(t)))? {
            Some(exponential) => Ok(Some(exponential.product(self.map)?)),
            None => Ok(None),
        }
    }

    /// `factor^2 P - X'P X`.
    fn form(&self, x: &Matrix<Interval>) -> Result<Matrix<Interval>, ProofError> {
        self.level.difference(&x.congruence(&self.p)?)
    }

    /// Whether the form is positive definite at all times within `radius` of the time of `x`.
    fn holds_around(&self, x: &Matrix<Interval>, radius: f64) -> Result<bool, ProofError> {
        let Some(reach) = Interval::new(-radius, radius) else { return Ok(false) };
        let Some(largest) = exponential(&self.magnitudes.scaled(&Interval::of(radius)))? else { return Ok(false) };
        let n = x.rows();
        let moved = Matrix::from_fn(n, n, |i, j| {
            // Upper bound of exp(r |A|) - I.
            let size = if i == j { (largest[(i, j)].hi() - 1.0).next_up() } else { largest[(i, j)].hi() };
            let change = Interval::new(-size, size).unwrap_or(Interval::UNBOUNDED);
            if i == j { change.add(&Interval::point(1.0)) } else { change }
        });
        let slope = moved.product(x)?.congruence(&self.growth)?.scaled(&reach);
        Ok(definite::decide(&self.form(x)?.sum(&slope)?, Sense::PositiveDefinite)?.is_proved())
    }
}
