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
//! The least sum may be approached only as the gain tends to infinity, and next to it the widths hardly depend on the
//! gain. Of the gains whose sum is at most one per cent above the least, the one with the least largest entry is taken:
//! `|Y_ij| <= g p_i` with the least g, by bisection. Where there is none, since gains that are negligible beside that
//! of the program do as well (`x' = 0`, `y = x + v`: every L > 0 has the same width in the end), that of the program
//! is kept.
//!
//! Source: for positive systems, C. Briat, Robust stability and stabilization of uncertain linear positive systems via
//! integral linear constraints, International Journal of Robust and Nonlinear Control 23, 2013.

use luenberger_linalg::RealMatrixView;
use luenberger_lmi::{Expression, Problem, Solution, Variable};
use luenberger_proof::Verdict;
use luenberger_proof::statement::TimeDomain;
use nalgebra::DMatrix;

use crate::check;
use crate::error::DesignError;
use crate::error_bound::DisturbanceBounds;
use crate::lyapunov_choice::coordinates;
use crate::powers::{Powers, shift};

/// How much more than the least sum of the half-widths is allowed for a smaller gain.
const ALLOWANCE: f64 = 0.01;

const WHAT: &str = "the linear program of the gain of the least width";

/// The ratio of bounds of the entries of L at which the bisection ends.
const RATIO: f64 = 1.02;

/// By how much the bound is lowered at a time until no gain is found.
const DESCENT: f64 = 16.0;

/// The most programs of the bisection: at most 14 descend to EPSILON, and 8 lead from the factor 16 to the ratio.
const STEPS: usize = 24;

/// The gain L, n x p, for which the sum of the half-widths in the end is the least, in the coordinates of the plant: of
/// the gains with a sum at most one per cent larger, the one whose largest entry is the smallest.
///
/// The noise of every output needs a bound above 0: without it no gain is too large.
///
/// # Errors
/// [`DesignError::NoLeastWidth`] where no gain makes the comparison system stable, with multipliers;
/// [`DesignError::Undecided`] where the linear program was not solved; [`DesignError::QuietOutput`] where an output has
/// no noise; errors of shapes.
///
/// # Cost
/// Some twenty linear programs with `2 n (n + m)` unknowns for m disturbances.
pub fn least_width_gain<'a>(
    a: impl Into<RealMatrixView<'a>>,
    c: impl Into<RealMatrixView<'a>>,
    disturbances: &DisturbanceBounds,
    time: TimeDomain,
) -> Result<DMatrix<f64>, DesignError> {
    least_width((&check::owned(a), &check::owned(c)), disturbances, time)
}

fn least_width(
    (a, c): (&DMatrix<f64>, &DMatrix<f64>),
    disturbances: &DisturbanceBounds,
    time: TimeDomain,
) -> Result<DMatrix<f64>, DesignError> {
    let (n, p, m) = (a.nrows(), c.nrows(), disturbances.bounds.len());
    let DisturbanceBounds { d, bounds, .. } = disturbances;
    check::matrix("A", a, (n, n))?;
    check::matrix("C", c, (p, n))?;
    disturbances.check((n, p))?;
    let quiet = (0..p).find(|i| (0..m).all(|j| d[(*i, j)] * bounds[j] == 0.0));
    if let Some(output) = quiet {
        return Err(DesignError::QuietOutput { output });
    }
    // In the units given, and in those in which A is balanced.
    let mut verdict = None;
    let balanced = coordinates(time, a).into_iter().next();
    for units in std::iter::once(Powers::given(n)).chain(balanced) {
        let Some(mut least) = Program::new((a, c), disturbances, time, &units) else { continue };
        least.lp.minimise(&least.sum);
        let solution = least.lp.solve()?;
        match &solution.verdict {
            Verdict::Proved { .. } => return Ok(smallest(&least, &solution, (a, c), disturbances, time, &units)),
            Verdict::Refuted { witness } => return Err(DesignError::NoLeastWidth { witness: witness.clone() }),
            Verdict::Undecided { .. } => verdict = Some(solution.verdict.clone()),
        }
    }
    Err(DesignError::not_proved(WHAT, verdict))
}

/// Of the gains whose sum is about the least, the one whose largest entry is the smallest.
fn smallest(
    least: &Program,
    solution: &Solution,
    (a, c): (&DMatrix<f64>, &DMatrix<f64>),
    disturbances: &DisturbanceBounds,
    time: TimeDomain,
    units: &Powers,
) -> DMatrix<f64> {
    let (n, p) = (a.nrows(), c.nrows());
    let allowed = (1.0 + ALLOWANCE) * solution.value(&least.sum)[(0, 0)];
    let first = least.gain(solution);
    let (negligible, mut gain) = (f64::EPSILON * first.amax(), first.clone());
    // A gain with entries up to `above` is known; none up to `below`.
    let (mut below, mut above) = (0.0_f64, first.amax());
    for _ in 0..STEPS {
        if above <= RATIO * below {
            break;
        }
        if above <= negligible {
            return first;
        }
        let bound = if below > 0.0 { below.sqrt() * above.sqrt() } else { above / DESCENT };
        let Some(mut bounded) = Program::new((a, c), disturbances, time, units) else { break };
        bounded.lp.constrain("the sum of the half-widths", &bounded.sum << allowed);
        for i in 0..n {
            for j in 0..p {
                let value = entry(&Expression::from(&bounded.y), (n, i), (p, j));
                let largest = bounded.scale(i, j, bound) * entry(&Expression::from(&bounded.weight), (n, i), (n, i));
                bounded.lp.constrain(&format!("L({i},{j}) from above"), (largest.clone() - value.clone()) >> 0.0);
                bounded.lp.constrain(&format!("L({i},{j}) from below"), (largest + value) >> 0.0);
            }
        }
        match bounded.lp.solve() {
            Ok(solution) if solution.verdict.is_proved() => {
                gain = bounded.gain(&solution);
                above = gain.amax().min(bound);
            }
            _ => below = bound,
        }
    }
    gain
}

/// The linear program of the head.
struct Program {
    lp: Problem,
    /// `diag(p)`, n x n.
    weight: Variable,
    /// Y, n x p.
    y: Variable,
    /// At least the sum of the half-widths.
    sum: Variable,
    /// Units of the states, and of the outputs: the largest entry of a row of C in them.
    units: Powers,
    outputs: Vec<i32>,
}

impl Program {
    /// The program for `x = T z`, whose half-widths in the end are those of z times T; none without a disturbance.
    fn new(
        (a, c): (&DMatrix<f64>, &DMatrix<f64>),
        DisturbanceBounds { e, d, bounds }: &DisturbanceBounds,
        time: TimeDomain,
        units: &Powers,
    ) -> Option<Self> {
        let (n, p, m) = (a.nrows(), c.nrows(), bounds.len());
        let is_given = units.0.iter().all(|power| *power == 0);
        let (a, c, e) = (units.similar(a), units.columns(c), units.rows(e));
        let size = |row: f64| if is_given || row == 0.0 { 0 } else { row.log2().round() as i32 };
        let outputs: Vec<i32> = c.row_iter().map(|row| size(row.amax())).collect();
        let seen = |m: &DMatrix<f64>| DMatrix::from_fn(p, m.ncols(), |i, j| shift(m[(i, j)], -outputs[i]));
        let (a, c, e, d) = (&a, &seen(&c), &e, &seen(d));
        let largest = units.0.iter().copied().max().unwrap_or(0);
        let mut lp = Problem::new();
        let weight = lp.diagonal("p", n);
        let y = lp.rectangular("Y", n, p);
        let flow: Expression = &weight * a - &y * c;
        let forced: Expression = &weight * e - &y * d;
        for j in 0..n {
            let own = entry(&Expression::from(&weight), (n, j), (n, j));
            lp.constrain(&format!("p({j}) > 0"), own.clone() >> 0.0);
            // K~_jj, or K~_jj - p_j.
            let mut column = match time {
                TimeDomain::Continuous => entry(&flow, (n, j), (n, j)),
                TimeDomain::Discrete => -own,
            };
            for i in (0..n).filter(|&i| i != j || time == TimeDomain::Discrete) {
                let bound = lp.scalar(&format!("K({i},{j})"));
                within(&mut lp, &format!("F({i},{j})"), entry(&flow, (n, i), (n, j)), &bound);
                column = column + &bound;
            }
            lp.constrain(&format!("column {j}"), column << -shift(1.0, units.0[j] - largest));
        }
        let mut cost: Option<Expression> = None;
        for j in (0..m).filter(|j| bounds[*j] > 0.0) {
            for i in 0..n {
                let bound = lp.scalar(&format!("t({i},{j})"));
                within(&mut lp, &format!("G({i},{j})"), entry(&forced, (n, i), (m, j)), &bound);
                let term = bounds[j] * &bound;
                cost = Some(match cost.take() {
                    Some(cost) => cost + term,
                    None => term,
                });
            }
        }
        let sum = lp.scalar("sum of the half-widths");
        lp.constrain("sum of the half-widths", (&sum - cost?) >> 0.0);
        Some(Self { lp, weight, y, sum, units: units.clone(), outputs })
    }

    /// `diag(p)^-1 Y`, in the units given.
    fn gain(&self, solution: &Solution) -> DMatrix<f64> {
        let (weight, y) = (solution.value(&self.weight), solution.value(&self.y));
        DMatrix::from_fn(y.nrows(), y.ncols(), |i, j| {
            shift(y[(i, j)] / weight[(i, i)], self.units.0[i] - self.outputs[j])
        })
    }

    /// A bound of `L_ij` in the units of the program.
    fn scale(&self, i: usize, j: usize, bound: f64) -> f64 {
        shift(bound, self.outputs[j] - self.units.0[i])
    }
}

/// `|value| <= bound`.
fn within(lp: &mut Problem, name: &str, value: Expression, bound: &Variable) {
    lp.constrain(&format!("{name} from above"), (bound - value.clone()) >> 0.0);
    lp.constrain(&format!("{name} from below"), (bound + value) >> 0.0);
}

/// An entry (i, j) of a matrix with so many rows and columns.
fn entry(matrix: &Expression, (rows, i): (usize, usize), (columns, j): (usize, usize)) -> Expression {
    let unit = |length: usize, k: usize| DMatrix::from_fn(length, 1, |i, _| f64::from(u8::from(i == k)));
    unit(rows, i).transpose() * matrix.clone() * unit(columns, j)
}
