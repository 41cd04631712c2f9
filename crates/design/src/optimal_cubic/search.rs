//! The search for the gains of least cost: coordinate search with pattern moves (Hooke and Jeeves, J. ACM 8, 1961;
//! Kolda, Lewis and Torczon, SIAM Review 45, 2003), from the linear optimum and from slower gains.
//!
//! Coordinates of a cubic observer: the entries of L; `Q = U'DU > 0` of the Lyapunov equation, which gives P; G and K
//! of `S = H (GG' + K) H`, `H = (C P^-1 C')^-1/2`, K skew; and G of `theta = GG'`. Each point is an observer with
//! `S + S' >= 0` and P of `F'P + PF = -Q`, hence globally convergent, and each such observer with S + S' > 0 and theta
//! > 0 is a point. Scales of Q and theta have no effect beside that of S: one entry of each is 1.

use luenberger_clock::Instant;
use luenberger_linalg::{LyapunovEquation, symmetric_part};
use nalgebra::DMatrix;

use super::cost::{Scaled, square_root};
use super::flow::Gains;

/// An observer with the matrices that certify it, in the units of the problem.
pub(super) struct Point {
    pub(super) gains: Gains,
    pub(super) q: DMatrix<f64>,
    pub(super) s: DMatrix<f64>,
}

/// The largest condition of Q: beyond it rounding could spoil the certificate.
const WORST_CONDITION: f64 = 1e4;

/// The number of coordinates behind the entries of L.
fn behind(n: usize, p: usize) -> usize {
    (n * (n + 1) / 2 - 1) + p * p + (p * (p + 1) / 2 - 1)
}

/// Coordinates of the observer with this L and Q, the radial S that makes `C N = -gamma I`, and theta = I.
pub(super) fn coordinates(l: &DMatrix<f64>, q: &DMatrix<f64>, gamma: f64) -> Option<Vec<f64>> {
    let (n, p) = l.shape();
    let factor = q.clone().cholesky()?.unpack();
    let mut z: Vec<f64> = l.as_slice().to_vec();
    let scale = factor[(0, 0)];
    z.extend((1..n).map(|i| 2.0 * (factor[(i, i)] / scale).ln()));
    for j in 0..n {
        z.extend((j + 1..n).map(|i| factor[(i, j)] / factor[(j, j)]));
    }
    z.extend((0..p).map(|_| gamma.ln()));
    z.resize(n * p + behind(n, p), 0.0);
    Some(z)
}

/// First steps: a quarter of the gain, and factors of e in what is positive.
pub(super) fn steps(l: &DMatrix<f64>) -> Vec<f64> {
    let (n, p) = l.shape();
    let size = l.amax();
    let mut steps: Vec<f64> = l.iter().map(|x| 0.25 * (x.abs() + 0.1 * size)).collect();
    steps.extend((1..n).map(|_| 1.0));
    steps.extend((0..n * (n - 1) / 2).map(|_| 0.5));
    steps.extend((0..p).map(|_| 1.0));
    steps.extend((0..p * (p - 1)).map(|_| 0.3));
    steps.extend((1..p).map(|_| 1.0));
    steps.extend((0..p * (p - 1) / 2).map(|_| 0.3));
    steps
}

/// A lower triangular matrix with these logarithms of squares on its diagonal, its unit part below.
fn triangular(logs: &[f64], below: &[f64]) -> DMatrix<f64> {
    let n = logs.len();
    let mut unit = DMatrix::identity(n, n);
    let mut entries = below.iter();
    for j in 0..n {
        for i in j + 1..n {
            unit[(i, j)] = entries.next().copied().unwrap_or(0.0);
        }
    }
    let diagonal = DMatrix::from_fn(n, n, |i, j| if i == j { (0.5 * logs[i]).exp() } else { 0.0 });
    unit * diagonal
}

/// The observer with these coordinates; none if `A - L C` is not Hurwitz, or Q badly conditioned.
pub(super) fn point(problem: &Scaled, z: &[f64]) -> Option<Point> {
    let (n, p) = (problem.a.nrows(), problem.c.nrows());
    let mut rest = z;
    let mut take = |count: usize| {
        let (head, tail) = rest.split_at(count);
        rest = tail;
        head
    };
    let l = DMatrix::from_column_slice(n, p, take(n * p));
    let logs: Vec<f64> = core::iter::once(0.0).chain(take(n - 1).iter().copied()).collect();
    let factor = triangular(&logs, take(n * (n - 1) / 2));
    let q = symmetric_part(&(&factor * factor.transpose()));
    let spread = q.symmetric_eigenvalues();
    if spread.max() > WORST_CONDITION * spread.min() {
        return None;
    }
    let logs = take(p).to_vec();
    let factor = triangular(&logs, take(p * (p - 1) / 2));
    let skew = take(p * (p - 1) / 2);
    let weights: Vec<f64> = core::iter::once(0.0).chain(take(p - 1).iter().copied()).collect();
    let theta = triangular(&weights, take(p * (p - 1) / 2));
    let f = &problem.a - &l * &problem.c;
    let mut equation = LyapunovEquation::new(&f).ok()?;
    if equation.eigenvalues().iter().any(|z| z.re >= 0.0) {
        return None;
    }
    let metric = symmetric_part(&equation.solve(&q).ok()?.p);
    let p_inverse_ct = metric.cholesky()?.solve(&problem.c.transpose());
    let gram = symmetric_part(&(&problem.c * &p_inverse_ct));
    let half = square_root(&gram.cholesky()?.inverse());
    let mut inner = &factor * factor.transpose();
    let mut entries = skew.iter();
    for j in 0..p {
        for i in j + 1..p {
            let k = entries.next().copied().unwrap_or(0.0) * (0.5 * (logs[i] + logs[j])).exp();
            inner[(i, j)] += k;
            inner[(j, i)] -= k;
        }
    }
    let s = &half * inner * &half;
    let gain = -(p_inverse_ct * &s);
    let theta = symmetric_part(&(&theta * theta.transpose()));
    Some(Point { gains: Gains { l, n: gain, theta }, q, s })
}

/// What a search may spend.
pub(super) struct Budget {
    /// It ends with steps of this share of the first ones.
    pub(super) last_step: f64,
    pub(super) evaluations: usize,
    pub(super) end: Option<Instant>,
}

impl Budget {
    pub(super) fn is_spent(&self, used: usize) -> bool {
        used >= self.evaluations || self.end.is_some_and(|end| Instant::now() >= end)
    }
}

/// Descends from z until every step is the share of the first one that the budget says; returns the best point with its
/// cost, and counts the evaluations. A cost is evaluated to find out whether it is below the number beside the point:
/// otherwise any other above it will do.
pub(super) fn descend(
    mut cost: impl FnMut(&[f64], f64) -> f64,
    z: Vec<f64>,
    first_steps: &[f64],
    budget: &Budget,
    used: &mut usize,
) -> (Vec<f64>, f64) {
    let mut best = (cost(&z, f64::INFINITY), z);
    *used += 1;
    let mut steps = first_steps.to_vec();
    let small = |step: f64, first: f64| step.abs() <= budget.last_step * first;
    while steps.iter().zip(first_steps).any(|(now, first)| !small(*now, *first)) && !budget.is_spent(*used) {
        let before = best.1.clone();
        for i in 0..steps.len() {
            let mut improved = false;
            for sign in [1.0, -1.0] {
                let mut z = best.1.clone();
                z[i] += sign * steps[i];
                let value = cost(&z, best.0);
                *used += 1;
                if value < best.0 {
                    best = (value, z);
                    // A step that helped grows, and keeps its sign.
                    steps[i] = (1.5 * sign * steps[i]).clamp(-4.0 * first_steps[i], 4.0 * first_steps[i]);
                    improved = true;
                    break;
                }
            }
            if !improved {
                steps[i] *= 0.5;
            }
        }
        // The pattern move: once more what this sweep has done.
        let further: Vec<f64> = best.1.iter().zip(&before).map(|(now, before)| 2.0 * now - before).collect();
        if best.1 != before {
            let value = cost(&further, best.0);
            *used += 1;
            if value < best.0 {
                best = (value, further);
            }
        }
    }
    (best.1, best.0)
}
