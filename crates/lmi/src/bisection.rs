//! Generalised eigenvalue problems: the largest parameter for which a family of inequalities is feasible.
//!
//! For a family LMI(alpha) that is feasible below some threshold and infeasible above it, such as the decay rate in
//! `P > 0, A'P + PA + 2 alpha P < 0`, whose threshold is minus the spectral abscissa of A.
//!
//! Method: bisection on the verdict. Each step halves the bracket, so the number of solves is known beforehand.

use luenberger_proof::Verdict;

use crate::error::LmiError;
use crate::problem::{Problem, Settings};
use crate::solution::{Infeasibility, Solution};

/// Threshold of provable feasibility.
#[derive(Debug, Clone)]
pub struct Bisection {
    /// The largest parameter proved feasible, with its solution; none if the low end was not proved.
    pub proved: Option<(f64, Solution)>,
    /// The smallest parameter not proved feasible, with its result: `Refuted` or `Undecided`. None if the high end was
    /// proved feasible; then the threshold lies beyond the bracket.
    pub stopped: Option<(f64, Verdict<Infeasibility>)>,
    /// Number of problems solved.
    pub solves: usize,
}

/// The largest `alpha` in `[low, high]` for which the problem `family(alpha)` is proved feasible, to within
/// `tolerance`.
///
/// The two returned parameters differ by at most `tolerance` and enclose the threshold of provable feasibility; it is
/// the threshold of feasibility itself if the upper one is `Refuted`. The family must be monotone: feasible at alpha
/// implies feasible below. Read the unknowns of the result by name, with [`Solution::named`].
///
/// Cost: 2 + log2((high - low) / tolerance) solves.
///
/// # Errors
/// A bracket or tolerance that is not finite and positive; whatever [`Problem::solve`] returns.
///
/// ```
/// use luenberger_lmi::{Problem, greatest_parameter, he};
/// use nalgebra::dmatrix;
/// let a = dmatrix![-1.0, 5.0; 0.0, -2.0]; // spectral abscissa -1
/// let rate = greatest_parameter(0.0, 10.0, 1e-3, |alpha| {
///     let mut lmi = Problem::new();
///     let p = lmi.symmetric("P", 2);
///     lmi.constrain("P > 0", &p >> 0.0);
///     lmi.constrain("decay", (he(&p * &a) + 2.0 * alpha * &p) << 0.0);
///     lmi
/// })?;
/// let (alpha, _) = rate.proved.unwrap();
/// assert!(0.999 <= alpha && alpha < 1.0);
/// # Ok::<(), luenberger_lmi::LmiError>(())
/// ```
pub fn greatest_parameter(
    low: f64,
    high: f64,
    tolerance: f64,
    family: impl FnMut(f64) -> Problem,
) -> Result<Bisection, LmiError> {
    greatest_parameter_with(&Settings::default(), low, high, tolerance, family)
}

/// As [`greatest_parameter`], each problem solved with these settings.
///
/// # Errors
/// As [`greatest_parameter`]; whatever [`Problem::solve_with`] returns.
pub fn greatest_parameter_with(
    settings: &Settings,
    low: f64,
    high: f64,
    tolerance: f64,
    mut family: impl FnMut(f64) -> Problem,
) -> Result<Bisection, LmiError> {
    let usable = low.is_finite() && high.is_finite() && low <= high && tolerance.is_finite() && tolerance > 0.0;
    if !usable {
        return Err(LmiError::BadBracket { low, high, tolerance });
    }
    let mut answer = Bisection { proved: None, stopped: None, solves: 0 };
    let mut examine = |alpha: f64, answer: &mut Bisection| -> Result<bool, LmiError> {
        let solution = family(alpha).solve_with(settings)?;
        answer.solves += 1;
        let proved = solution.verdict.is_proved();
        if proved {
            answer.proved = Some((alpha, solution));
        } else {
            answer.stopped = Some((alpha, solution.verdict));
        }
        Ok(proved)
    };
    if !examine(low, &mut answer)? || low == high || examine(high, &mut answer)? {
        return Ok(answer);
    }
    let (mut low, mut high) = (low, high);
    // The width halves at each step and stops at the tolerance or at neighbouring numbers, so at most about 2100 steps.
    while high - low > tolerance && !settings.is_over() {
        let middle = low + 0.5 * (high - low);
        if middle <= low || middle >= high {
            break;
        }
        if examine(middle, &mut answer)? {
            low = middle;
        } else {
            high = middle;
        }
    }
    Ok(answer)
}
