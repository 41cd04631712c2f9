//! The gain of the least width in the coordinates of the plant, by a linear program.
//!
//! The half-widths in the end are `r = -K^-1 g` with `K_ij = |F_ij|` off the diagonal of `F = A - LC`, `K_ii = F_ii`
//! and `g = |E - LD| W`. Their sum is the least `p'g` under `p'K <= -1'`, p > 0, since `p' = -1'K^-1` is the least such
//! p. With `Y = diag(p) L` all of it is linear: `K~ = diag(p) K` bounds the entries of `diag(p) A - Y C`, and t those
//! of `diag(p) E - Y D`:
//! ```text
//! min sum t_ij W_j,    sum_i K~_ij <= -1,    |p_i E_ij - (Y D)_ij| <= t_ij,
//! ```
//! with `|p_i A_ij - (Y C)_ij| <= K~_ij` off the diagonal and equality on it. In discrete time K is |F|, and the column
//! sums are at most `p_j - 1`. A gain for which A - LC is Metzler (nonnegative in discrete time) is a special case.
//!
//! Source: for positive systems, C. Briat, Robust stability and stabilization of uncertain linear positive systems via
//! integral linear constraints, International Journal of Robust and Nonlinear Control 23, 2013.

use luenberger_lmi::{Expression, Problem};
use luenberger_proof::statement::TimeDomain;
use nalgebra::DMatrix;

use crate::check;
use crate::error::DesignError;
use crate::error_bound::Disturbances;

/// The gain L, n x p, for which the sum of the half-widths in the end is least, in the coordinates of the plant.
///
/// The noise of every output needs a bound above 0: without it no gain is too large.
///
/// # Errors
/// [`DesignError::NoLeastWidth`] where no gain makes the comparison system stable, or an output has no noise; errors of
/// shapes.
pub fn least_width_gain(
    (a, c): (&DMatrix<f64>, &DMatrix<f64>),
    disturbances: &Disturbances,
    time: TimeDomain,
) -> Result<DMatrix<f64>, DesignError> {
    let (n, p, m) = (a.nrows(), c.nrows(), disturbances.bounds.len());
    let Disturbances { e, d, bounds } = disturbances;
    check::matrix("A", a, (n, n))?;
    check::matrix("C", c, (p, n))?;
    check::matrix("E", e, (n, m))?;
    check::matrix("D", d, (p, m))?;
    let quiet = (0..p).find(|i| (0..m).all(|j| d[(*i, j)] * bounds[j] == 0.0));
    if let Some(output) = quiet {
        return Err(DesignError::NoLeastWidth { quiet: Some(output) });
    }
    let mut lp = Problem::new();
    let weight = lp.diagonal("p", n);
    let y = lp.rectangular("Y", n, p);
    let unit = |length: usize, k: usize| DMatrix::from_fn(length, 1, |i, _| f64::from(u8::from(i == k)));
    let flow: Expression = &weight * a - &y * c;
    let forced: Expression = &weight * e - &y * d;
    let entry = |m: &Expression, (rows, i): (usize, usize), (columns, j): (usize, usize)| {
        unit(rows, i).transpose() * m.clone() * unit(columns, j)
    };
    let mut sums: Vec<Option<Expression>> = vec![None; n];
    let mut add = |j: usize, term: Expression| {
        let sum = sums[j].take();
        sums[j] = Some(match sum {
            Some(sum) => sum + term,
            None => term,
        });
    };
    for j in 0..n {
        for i in 0..n {
            let value = entry(&flow, (n, i), (n, j));
            if i == j && time == TimeDomain::Continuous {
                add(j, value);
                continue;
            }
            let bound = lp.scalar(&format!("K({i},{j})"));
            lp.constrain(&format!("F({i},{j}) from above"), (&bound - value.clone()) >> 0.0);
            lp.constrain(&format!("F({i},{j}) from below"), (&bound + value) >> 0.0);
            add(j, Expression::from(&bound));
        }
        lp.constrain(&format!("p({j}) > 0"), entry(&Expression::from(&weight), (n, j), (n, j)) >> 0.0);
    }
    for (j, sum) in sums.into_iter().enumerate() {
        let Some(sum) = sum else { continue };
        let sum = match time {
            TimeDomain::Continuous => sum,
            TimeDomain::Discrete => sum - entry(&Expression::from(&weight), (n, j), (n, j)),
        };
        lp.constrain(&format!("column {j}"), sum << -1.0);
    }
    let mut cost: Option<Expression> = None;
    for j in (0..m).filter(|j| bounds[*j] > 0.0) {
        for i in 0..n {
            let value = entry(&forced, (n, i), (m, j));
            let bound = lp.scalar(&format!("t({i},{j})"));
            lp.constrain(&format!("G({i},{j}) from above"), (&bound - value.clone()) >> 0.0);
            lp.constrain(&format!("G({i},{j}) from below"), (&bound + value) >> 0.0);
            let term = bounds[j] * &bound;
            cost = Some(match cost.take() {
                Some(cost) => cost + term,
                None => term,
            });
        }
    }
    let Some(cost) = cost else { return Err(DesignError::NoLeastWidth { quiet: Some(0) }) };
    lp.minimise(cost);
    let solution = lp.solve()?;
    if !solution.verdict.is_proved() {
        return Err(DesignError::NoLeastWidth { quiet: None });
    }
    let (weight, y) = (solution.value(&weight), solution.value(&y));
    Ok(DMatrix::from_fn(n, p, |i, j| y[(i, j)] / weight[(i, i)]))
}
