//! A guaranteed bound of the estimation error, for maps that are given as expressions.
//!
//! The theorem is [`KklErrorBound`]; here are the choices that it leaves. With the entries of xi in half-widths of
//! phi(box), P is the identity for a diagonal Lambda, else the solution of a Lyapunov equation for the middle of
//! Lambda, and W the inverse of P, a little enlarged. The rate is the largest, to 2 %, that P proves for all of Lambda.
//! The bound of V from which the estimate is guaranteed, `start`, is the largest power of two, at most that of an error
//! of two half-widths in every entry, for which phi^L is shown to be defined around phi(box). The modulus of
//! injectivity is added where one M proves it.

use luenberger_linalg::{lyapunov, symmetric_part};
use luenberger_proof::certificate::{KklBox, KklErrorBound, KklInjectivity, KklMaps, KklTexts, Theorem};
use luenberger_proof::statement::decay_rate_within;
use luenberger_proof::{Interval, Matrix, Ring, UndecidedReason, positive_definite};
use nalgebra::DMatrix;

/// How often `start` is halved.
const HALVINGS: i32 = 40;

/// The largest rate, within this factor.
const RATE: f64 = 0.98;

/// Enlargement of the inverse of P.
const ROOM: f64 = 1.0 + 1e-6;

/// The bound of the estimation error of the observer with these maps, while x and u remain in the region: all
/// conditions of the theorem are proved.
///
/// ```
/// use luenberger_design::kkl::error_bound;
/// use luenberger_proof::Interval;
/// use luenberger_proof::certificate::{KklBox, KklTexts};
/// let list = |of: &[&str]| of.iter().map(|text| (*text).to_owned()).collect::<Vec<String>>();
/// // x1' = -x1 + x2^2, x2' = x1 - x2, y = x2, and phi = x1.
/// let maps = KklTexts {
///     f: list(&["-x1 + x2^2", "x1 - x2"]),
///     h: list(&["x2"]),
///     phi: list(&["x1"]),
///     lambda: list(&["-1"]),
///     b: list(&["y1^2"]),
///     left_inverse: list(&["xi1"]),
///     estimated: list(&["x1"]),
/// };
/// let unit = Interval::new(-1.0, 1.0).expect("in order");
/// let bound = error_bound(&maps, &KklBox { x: vec![unit, unit], u: Vec::new() })?;
/// assert!(bound.claims.residual == [0.0] && bound.rate > 0.97);
/// # Ok::<(), luenberger_proof::UndecidedReason>(())
/// ```
/// # Errors
/// [`UndecidedReason`]: the expressions cannot be read or bounded, Lambda is not shown to be stable, or a condition is
/// not proved.
pub fn error_bound(texts: &KklTexts, region: &KklBox) -> Result<KklErrorBound, UndecidedReason> {
    let no_proof = |status| UndecidedReason::NoProposal { status };
    let maps = KklMaps::new(texts, region.u.len()).map_err(|_| no_proof("an expression cannot be read"))?;
    let lambda = maps.lambda_over(region)?;
    let half = maps.image_over(region)?.iter().map(|range| 0.5 * range.width()).collect::<Vec<f64>>();
    let scale: Vec<f64> = half.iter().map(|half| if *half > 0.0 { 1.0 / half } else { 1.0 }).collect();
    let (p, w) = metric(&lambda, &scale).ok_or_else(|| no_proof("no P for the middle of Lambda"))?;
    let rate = rate(&lambda, &p).ok_or(UndecidedReason::NotByThisMatrix { name: "P" })?;
    // e'Pe for an error of two half-widths in every entry.
    let size = |i: usize, j: usize| (2.0 / scale[i]) * p[(i, j)] * (2.0 / scale[j]);
    let order = scale.len();
    let square: f64 = (0..order).flat_map(|i| (0..order).map(move |j| (i, j))).map(|(i, j)| size(i, j)).sum();
    let largest = square.max(f64::MIN_POSITIVE).sqrt().log2().floor();
    let mut last = no_proof("no bound of V");
    for halving in 0..HALVINGS {
        let start = (largest - f64::from(halving)).exp2();
        let metric = (p.clone(), w.clone(), rate);
        let bound = match KklErrorBound::propose(maps.clone(), region.clone(), lambda.clone(), metric, start) {
            Ok(bound) => bound,
            Err(why) => {
                last = why;
                continue;
            }
        };
        // The estimate is bounded below `start` only: the limit has to be smaller.
        if bound.claims.limit >= start && bound.claims.limit > 0.0 && halving > 0 {
            break;
        }
        let facts = Theorem::from(bound.clone()).facts();
        let facts = facts.map_err(|_| UndecidedReason::Overflow);
        match facts {
            Ok(facts) => match facts.into_iter().find(|fact| !fact.verdict.is_proved()) {
                None => return Ok(with_modulus(bound)),
                Some(fact) => {
                    if let luenberger_proof::Verdict::Undecided { why, .. } = fact.verdict {
                        last = why;
                    }
                }
            },
            Err(why) => last = why,
        }
    }
    Err(last)
}

/// The theorem with the modulus of injectivity of (phi, h), if that is proved with the pseudo-inverse of the middle of
/// the Jacobian, states in half-widths of the box, as M.
fn with_modulus(bound: KklErrorBound) -> KklErrorBound {
    let found = modulus(&bound).map(|of| KklErrorBound { injectivity: Some(of), ..bound.clone() });
    let is_proved = |theorem: &KklErrorBound| {
        Theorem::from(theorem.clone()).facts().is_ok_and(|facts| facts.iter().all(|fact| fact.verdict.is_proved()))
    };
    found.filter(is_proved).unwrap_or(bound)
}

fn modulus(bound: &KklErrorBound) -> Option<KklInjectivity> {
    let jacobian = bound.maps.jacobian_over(&bound.region).ok()?;
    let (rows, states, order) = (jacobian.rows(), jacobian.cols(), bound.p.rows());
    let half: Vec<f64> = bound.region.x.iter().map(|axis| 0.5 * axis.width()).collect();
    let half: Vec<f64> = half.into_iter().map(|half| if half > 0.0 { half } else { 1.0 }).collect();
    let size = |i: usize| (0..states).map(|j| jacobian[(i, j)].magnitude() * half[j]).fold(0.0, f64::max);
    let weight: Vec<f64> = (0..rows).map(|i| if size(i) > 0.0 { 1.0 / size(i) } else { 1.0 }).collect();
    let middle = DMatrix::from_fn(rows, states, |i, j| weight[i] * jacobian[(i, j)].midpoint() * half[j]);
    let inverse = middle.pseudo_inverse(1e-12).ok()?;
    let m = Matrix::from_fn(states, rows, |i, j| inverse[(i, j)] * weight[j] / half[i]);
    let embedded = Matrix::<Interval>::embed(&m, "M").ok()?;
    let decrease = embedded.product(&jacobian).ok()?.plus_transpose().ok()?;
    let modulus = 0.499 * positive_definite(&decrease).ok()?.margin()?;
    // The largest |M_phi e|/V: through the root of P.
    let p = DMatrix::from_fn(order, order, |i, j| bound.p[(i, j)]);
    let root = p.cholesky()?.l().transpose().try_inverse()?;
    let of_phi = DMatrix::from_fn(states, order, |i, j| m[(i, j)]);
    let spread = (of_phi * root).singular_values().max() * (1.0 + 1e-6);
    Some(KklInjectivity { jacobian, m, modulus, spread })
}

/// P and W, in the units of xi.
fn metric(lambda: &Matrix<Interval>, scale: &[f64]) -> Option<(Matrix<f64>, Matrix<f64>)> {
    let order = scale.len();
    let is_diagonal = (0..order).all(|i| (0..order).all(|j| i == j || lambda[(i, j)].is_zero()));
    let scaled = if is_diagonal {
        DMatrix::identity(order, order)
    } else {
        let middle = DMatrix::from_fn(order, order, |i, j| scale[i] * lambda[(i, j)].midpoint() / scale[j]);
        let size = middle.norm();
        symmetric_part(&lyapunov(&(middle / size), &DMatrix::identity(order, order)).ok()?.p)
    };
    let p = DMatrix::from_fn(order, order, |i, j| scale[i] * scaled[(i, j)] * scale[j]);
    let w = symmetric_part(&p.clone().try_inverse()?) * ROOM;
    let proof = |m: &DMatrix<f64>| Matrix::from_fn(order, order, |i, j| m[(i.min(j), i.max(j))]);
    (p.iter().chain(w.iter()).all(|x| x.is_finite())).then(|| (proof(&p), proof(&w)))
}

/// The largest rate that P proves, to [`RATE`].
fn rate(lambda: &Matrix<Interval>, p: &Matrix<f64>) -> Option<f64> {
    let order = p.rows();
    let no_output = Matrix::from_fn(1, order, |_, _| Interval::zero());
    let no_gain = Matrix::from_fn(order, 1, |_, _| 0.0);
    let holds =
        |rate: f64| decay_rate_within(lambda, &no_gain, &no_output, p, rate).is_ok_and(|verdict| verdict.is_proved());
    // No rate exceeds the size of the diagonal of Lambda.
    let largest = (0..order).map(|i| lambda[(i, i)].magnitude()).fold(0.0, f64::max);
    let mut low = largest;
    for _ in 0..60 {
        if low <= 0.0 || holds(low) {
            break;
        }
        low *= 0.5;
    }
    if !(low > 0.0 && holds(low)) {
        return None;
    }
    let mut high = 2.0 * low;
    while low < RATE * high {
        let middle = 0.5 * (low + high);
        if holds(middle) {
            low = middle;
        } else {
            high = middle;
        }
    }
    Some(low)
}
