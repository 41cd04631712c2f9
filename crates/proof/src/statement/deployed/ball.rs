//! Invariant ball and ultimate bound of the error of the running observer, from a contraction and a bounded
//! disturbance.

use super::disturbance::{Disturbance, Stage, StepBound};
use crate::definite::{proved_eigenvalue_bound, solve_approximately};
use crate::error::ProofError;
use crate::interval::Interval;
use crate::matrix::Matrix;
use crate::ring::Ring;
use crate::statement::embed_symmetric;
use crate::statement::spectrum::contraction;
use crate::verdict::NoErrorBallReason;

/// Result for the running observer.
#[derive(Debug, Clone, PartialEq)]
pub enum Running {
    /// The error stays bounded and converges to within known bounds.
    Within(ErrorBall),
    /// No bound is proved.
    Unproved(NoErrorBallReason),
}

/// Bounds of the error `e = x - xhat` of the running observer, rounding errors included.
#[derive(Debug, Clone, PartialEq)]
pub struct ErrorBall {
    /// rho: one step of the exact error map reduces `|e|_P = sqrt(e'Pe)` at least by this factor.
    pub contraction: f64,
    /// kappa: increase of that factor by rounding errors that are proportional to the error.
    pub relative: f64,
    /// Radius of the invariant ball: `|e|_P` stays below this. The ball contains the initial error of the
    /// [`Operation`](super::Operation).
    pub start: f64,
    /// Upper bound of `limsup |e|_P`.
    pub ultimate: f64,
    /// Upper bounds of `limsup |e_i|`, for each component.
    pub entries: Vec<f64>,
    /// Largest ratio of an intermediate result to the limit of its range, at most 1.
    pub headroom: f64,
    /// All intermediate results of a step, in execution order.
    pub intermediates: Vec<Intermediate>,
}

/// An intermediate result of the step, or all partial sums of one sum of products, in any order of summation.
#[derive(Debug, Clone, PartialEq)]
pub struct Intermediate {
    /// Its name in the statement of a certificate and in `docs/theory-deployed.md`.
    pub what: &'static str,
    /// Upper bound of its magnitude while the error is in the invariant ball.
    pub size: f64,
    /// Largest magnitude allowed.
    pub limit: f64,
}

#[cfg(feature = "all-theorems")]
/// What one step adds to the exact map, and the bounds that follow from it in the norm of P, as numbers of a proof.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct RunningBound {
    /// `|e+ - M e| <= added (1, |e|)` while `|e|_P <= start`, n x (n + 1).
    pub(crate) added: Matrix<f64>,
    /// `|e_i| <= widths_i |e|_P`.
    pub(crate) widths: Vec<f64>,
    /// `|M e|_P <= contraction |e|_P`.
    pub(crate) contraction: f64,
    /// What is added in proportion to the error is at most this times `|e|_P`.
    pub(crate) kappa: f64,
    /// What is added besides.
    pub(crate) beta: f64,
    /// At least `beta / (1 - contraction - kappa)`.
    pub(crate) limit: f64,
    /// At least the limit.
    pub(crate) start: f64,
}

/// Maximum number of iterations to make the invariant ball and the bounds that hold in it consistent.
const TURNS: usize = 8;

/// Number of refinements of the bounds of the components by themselves.
const REFINEMENTS: usize = 3;

/// Maximum number of powers of the error map in the series for the components: 34 MB for 32 states.
const POWERS: usize = 4096;

pub(super) fn running(p: &Matrix<f64>, disturbance: &Disturbance<'_>) -> Result<Running, ProofError> {
    let n = disturbance.order();
    let metric = embed_symmetric::<Interval>(p, "P", n)?;
    if n == 0 {
        let intermediates = match in_range(&disturbance.step_bound(&[])?.stages, &[])? {
            Ok(intermediates) => intermediates,
            Err(reason) => return Ok(Running::Unproved(reason)),
        };
        return Ok(Running::Within(ErrorBall {
            contraction: 0.0,
            relative: 0.0,
            start: 0.0,
            ultimate: 0.0,
            entries: Vec::new(),
            headroom: headroom(&intermediates),
            intermediates,
        }));
    }
    let maps = disturbance.maps()?;
    let unproved =
        |contraction, relative| Ok(Running::Unproved(NoErrorBallReason::RoundingDominates { contraction, relative }));
    let Some(rho) = contraction(&metric, &maps, 1.0)? else { return unproved(f64::INFINITY, 0.0) };
    let Some(half_widths) = half_widths(p, &metric)? else { return unproved(rho, f64::INFINITY) };
    let longest = |bound: &Matrix<Interval>| longest(&metric, bound);
    let at = |radius: f64| -> Vec<f64> { half_widths.iter().map(|s| s.mul(&Interval::of(radius)).hi()).collect() };
    let error = &disturbance.operation.error;
    let mut start = longest(&Matrix::from_fn(n, 1, |i, _| Interval::of(error[i])))?;
    for _ in 0..TURNS {
        let StepBound { added, stages, .. } = disturbance.step_bound(&at(start))?;
        let beta = longest(&Matrix::from_fn(n, 1, |i, _| added[(i, 0)]))?;
        let slope = Matrix::from_fn(n, n, |i, j| added[(i, j + 1)]);
        let kappa = longest(&slope.product(&Matrix::from_fn(n, 1, |i, _| half_widths[i]))?)?;
        let factor = Interval::of(rho).add(&Interval::of(kappa)).hi();
        let left = (1.0 - factor).next_down();
        if left.is_nan() || left <= 0.0 {
            return unproved(rho, kappa);
        }
        let ultimate = (beta / left).next_up();
        if !ultimate.is_finite() {
            return unproved(rho, kappa);
        }
        if ultimate > start {
            // The bounds hold for a smaller ball only: repeat with a larger one.
            start = 1.01 * ultimate;
            continue;
        }
        let intermediates = match in_range(&stages, &at(start))? {
            Ok(intermediates) => intermediates,
            Err(reason) => return Ok(Running::Unproved(reason)),
        };
        let mut entries = at(ultimate);
        let mut powers = Powers::of(&maps[0]);
        for _ in 0..REFINEMENTS {
            let StepBound { added, bend, .. } = disturbance.step_bound(&entries)?;
            let per_step = evaluated(&added.sum(&bend)?, &entries)?;
            series(&mut powers, &per_step, &half_widths, (rho, ultimate), &mut entries)?;
        }
        let ball = ErrorBall {
            contraction: rho,
            relative: kappa,
            start,
            ultimate,
            entries,
            headroom: headroom(&intermediates),
            intermediates,
        };
        return Ok(Running::Within(ball));
    }
    unproved(rho, f64::INFINITY)
}

/// `sqrt(b'|P|b)`, rounded up: no vector with these entries at most is longer in the norm of P.
fn longest(metric: &Matrix<Interval>, bound: &Matrix<Interval>) -> Result<f64, ProofError> {
    let sizes = metric.map(|x| Interval::of(x.magnitude()));
    let square = bound.transpose().product(&sizes.product(bound)?)?[(0, 0)];
    Ok(square.sqrt().map_or(f64::INFINITY, |root| root.hi()))
}

#[cfg(feature = "all-theorems")]
/// The numbers by which a ball is proved; none where they have no room.
pub(super) fn running_bound(
    p: &Matrix<f64>,
    disturbance: &Disturbance<'_>,
    ball: &ErrorBall,
) -> Result<Option<RunningBound>, ProofError> {
    let n = disturbance.order();
    let metric = embed_symmetric::<Interval>(p, "P", n)?;
    let Some(half_widths) = half_widths(p, &metric)? else { return Ok(None) };
    let reach: Vec<f64> = half_widths.iter().map(|s| s.mul(&Interval::of(ball.start)).hi()).collect();
    let added = disturbance.step_bound(&reach)?.added.map(Interval::hi);
    let entry = |i: usize, j: usize| Interval::of(added[(i, j)]);
    let beta = longest(&metric, &Matrix::from_fn(n, 1, |i, _| entry(i, 0)))?;
    let slope = Matrix::from_fn(n, n, |i, j| entry(i, j + 1));
    let kappa = longest(&metric, &slope.product(&Matrix::from_fn(n, 1, |i, _| half_widths[i]))?)?;
    let left = (1.0 - Interval::of(ball.contraction).add(&Interval::of(kappa)).hi()).next_down();
    let limit = (beta / left).next_up();
    let widths = half_widths.iter().map(Interval::hi).collect();
    let (contraction, start) = (ball.contraction, ball.start);
    let has_room = left > 0.0 && limit <= start;
    Ok(has_room.then_some(RunningBound { added, widths, contraction, kappa, beta, limit, start }))
}

/// The intermediate results for `|e_i| = reach_i`, or the first that may exceed its range.
fn in_range(stages: &[Stage], reach: &[f64]) -> Result<Result<Vec<Intermediate>, NoErrorBallReason>, ProofError> {
    let mut found = Vec::with_capacity(stages.len());
    for &Stage { what, ref size, limit } in stages {
        let size = evaluated(size, reach)?;
        let size = size.into_iter().fold(0.0_f64, |largest, x| if x.is_nan() { f64::INFINITY } else { largest.max(x) });
        if size > limit {
            return Ok(Err(NoErrorBallReason::Range { what, size, limit }));
        }
        found.push(Intermediate { what, size, limit });
    }
    Ok(Ok(found))
}

fn headroom(intermediates: &[Intermediate]) -> f64 {
    let shares = intermediates.iter().map(|found| (found.size / found.limit).next_up());
    shares.fold(0.0, f64::max).min(1.0)
}

/// The rows of a bound, evaluated at `|e_i| = reach_i` and rounded up.
fn evaluated(bound: &Matrix<Interval>, reach: &[f64]) -> Result<Vec<f64>, ProofError> {
    let at =
        Matrix::from_fn(reach.len() + 1, 1, |i, _| if i == 0 { Interval::ONE } else { Interval::of(reach[i - 1]) });
    Ok(bound.product(&at)?.as_slice().iter().map(Interval::hi).collect())
}

/// `s_i >= sqrt((P^-1)_ii)`: `|e_i| <= s_i |e|_P`. `t > (P^-1)_ii` if and only if `[[P, unit_i], [unit_i', t]] > 0`.
fn half_widths(p: &Matrix<f64>, metric: &Matrix<Interval>) -> Result<Option<Vec<Interval>>, ProofError> {
    let n = p.rows();
    let identity = Matrix::from_fn(n, n, |i, j| if i == j { 1.0 } else { 0.0 });
    let Some(inverse) = solve_approximately(p, &identity) else { return Ok(None) };
    let mut widths = Vec::with_capacity(n);
    for i in 0..n {
        let unit = Matrix::from_fn(n, 1, |j, _| if i == j { Interval::ONE } else { Interval::zero() });
        let mut proved = None;
        for room in [1.0 + 1e-9, 1.0 + 1e-6, 1.001, 2.0, 100.0] {
            let t = Interval::of((inverse[(i, i)] * room).abs());
            let bordered = metric.bordered(&unit, &Matrix::from_rows([[t]]))?;
            if t.is_bounded() && proved_eigenvalue_bound(&bordered).is_some() {
                proved = t.sqrt();
                break;
            }
        }
        let Some(width) = proved else { return Ok(None) };
        widths.push(Interval::of(width.hi()));
    }
    Ok(Some(widths))
}

/// `|F^j|` for j = 0, 1, .., computed when first asked for; they end after an enclosure that is too wide.
struct Powers<'a> {
    map: &'a Matrix<Interval>,
    last: Matrix<Interval>,
    magnitudes: Vec<Matrix<f64>>,
}

impl<'a> Powers<'a> {
    fn of(map: &'a Matrix<Interval>) -> Self {
        Self { map, last: Matrix::scalar(map.rows(), &Interval::ONE), magnitudes: Vec::new() }
    }

    /// `|F^j|`, where j is at most one more than in the calls before.
    fn magnitude(&mut self, j: usize) -> Result<Option<&Matrix<f64>>, ProofError> {
        if j == self.magnitudes.len() {
            if j > 0 {
                if self.last.as_slice().iter().any(|x| x.width() > 1.0 || !x.is_bounded()) {
                    return Ok(None);
                }
                self.last = self.last.product(self.map)?;
            }
            self.magnitudes.push(self.last.map(Interval::magnitude));
        }
        Ok(self.magnitudes.get(j))
    }
}

/// Refines the bounds of the components by `sum_{j<k} |F^j| d + s rho^k ultimate`, with the best k for each.
fn series(
    powers: &mut Powers<'_>,
    per_step: &[f64],
    half_widths: &[Interval],
    (rho, ultimate): (f64, f64),
    entries: &mut [f64],
) -> Result<(), ProofError> {
    let n = per_step.len();
    let d = Matrix::from_fn(n, 1, |i, _| Interval::of(per_step[i]));
    let mut sum = Matrix::<Interval>::zeros(n, 1);
    let mut rest = ultimate;
    for j in 0..POWERS {
        let Some(power) = powers.magnitude(j)? else { break };
        sum = sum.sum(&power.map(|&x| Interval::of(x)).product(&d)?)?;
        rest = (rest * rho).next_up();
        let mut is_last = true;
        for i in 0..n {
            let tail = half_widths[i].mul(&Interval::of(rest));
            let bound = sum[(i, 0)].add(&tail).hi();
            entries[i] = entries[i].min(bound);
            is_last &= tail.hi() <= 1e-3 * sum[(i, 0)].hi();
        }
        if is_last {
            break;
        }
    }
    Ok(())
}
