//! The cost J of an observer: its closed form for a linear one, its evaluation for a cubic one.
//!
//! Everything is in units of the problem: states in units of the first errors, outputs in units of the standard
//! deviation of their noise, so that the first errors are the unit sphere and the noise has covariance I.

use luenberger_linalg::{
    LinalgError, LyapunovEquation, ZeroOrderHold, kalman_gain, stein, symmetric_part, zero_order_hold,
};
use luenberger_random::{Draws, Purpose, Stream};
use nalgebra::{Complex, DMatrix, SymmetricEigen};

use super::flow::{Column, ErrorFlow, Gains, LANES, Lanes, Rest, dot, lanes, rows, square};

/// The two parts of the cost J of an observer.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Cost {
    /// The mean of `int_0^inf e'Te dt` over the first errors, without noise.
    pub transient: f64,
    /// The stationary mean of `e'Te` under noise, at the ends of its periods.
    pub mean_square: f64,
    /// `transient + horizon mean_square`.
    pub total: f64,
}

/// A problem in its own units.
pub(super) struct Scaled {
    pub(super) a: DMatrix<f64>,
    pub(super) c: DMatrix<f64>,
    pub(super) weight: DMatrix<f64>,
    pub(super) process: DMatrix<f64>,
    pub(super) horizon: f64,
    pub(super) period: f64,
    pub(super) uniform: bool,
}

/// The linear error `e' = F e`, `F = A - L C` Hurwitz, and what its cost consists of.
struct LinearError {
    f: DMatrix<f64>,
    poles: Vec<Complex<f64>>,
    /// M of `F'M + M F + T = 0`.
    tail: DMatrix<f64>,
    /// P of `F'P + P F + I = 0`: without the cubic term e'Pe does not grow.
    metric: DMatrix<f64>,
    /// Over a period, `e+ = ad e + bd (w, v)`.
    held: ZeroOrderHold,
    cost: Cost,
}

/// Values of the noise, one period after the other: process noise, then measurement noise.
///
/// A lane has a part of the sequence, and begins before it by the time in which errors settle, half of all at most.
pub(super) struct Noise {
    values: Vec<Lanes>,
    width: usize,
    /// Periods that are not counted.
    settling: usize,
    /// Longest integration of a period, in steps.
    most_steps: f64,
}

/// Longest integration of a period in the search; an answer is judged with [`PATIENCE`] times as many steps, so that a
/// rare value of the noise does not leave it without a cost.
const MOST_STEPS: f64 = 100.0;
const PATIENCE: f64 = 1e4;

impl Noise {
    /// As many periods as the slowest mode of this rate needs for its mean squares, between 1000 and 4000, times
    /// `factor`.
    pub(super) fn new(problem: &Scaled, slowest: f64, factor: f64, mut draws: Draws) -> Self {
        let (n, p) = (problem.a.nrows(), problem.c.nrows());
        let periods = (factor * 400.0 / (slowest * problem.period)).clamp(1000.0 * factor, 4000.0 * factor) as usize;
        let settling = ((7.0 / (slowest * problem.period)) as usize).min(periods / 2);
        let counted = periods.div_ceil(LANES);
        let root = square_root(&problem.process) / problem.period.sqrt();
        let width = n + p;
        let mut sequence = Vec::with_capacity((counted * LANES + settling) * width);
        for _ in 0..counted * LANES + settling {
            let w: Vec<f64> = (0..n).map(|_| draws.normal()).collect();
            sequence.extend((0..n).map(|i| (0..n).map(|j| root[(i, j)] * w[j]).sum::<f64>()));
            // Of variance 1.
            let value = |_| if problem.uniform { 3f64.sqrt() * draws.unit() } else { draws.normal() };
            sequence.extend((0..p).map(value));
        }
        let part = |at: usize| lanes(|lane| sequence[lane * counted * width + at]);
        let values = (0..(counted + settling) * width).map(part).collect();
        Self { values, width, settling, most_steps: MOST_STEPS }
    }

    /// The same, for the cost of an answer.
    pub(super) fn judging(self) -> Self {
        Self { most_steps: PATIENCE * MOST_STEPS, ..self }
    }

    /// The mean of what `square` gives after each period, for the noise in it; none once it is above `most`.
    #[inline(always)]
    #[allow(clippy::inline_always, reason = "as of its caller")]
    fn mean(&self, most: f64, mut square: impl FnMut(&[Lanes]) -> Option<Lanes>) -> Option<f64> {
        let counted = (self.values.len() / self.width - self.settling) * LANES;
        let (mut sum, most) = (0.0, most * counted as f64);
        for (k, values) in self.values.chunks_exact(self.width).enumerate() {
            let now = square(values)?;
            if k >= self.settling {
                sum += now.iter().sum::<f64>();
                if sum > most {
                    return None;
                }
            }
        }
        let mean = sum / counted as f64;
        mean.is_finite().then_some(mean)
    }
}

impl Scaled {
    /// The closed form for a linear observer; none if `A - L C` is not Hurwitz.
    ///
    /// `F'M + M F + T = 0`, the transient is `trace(M)/n`; `X = Phi X Phi' + G diag(W/h, I) G'` with `Phi = exp(Fh)`,
    /// `G = int_0^h exp(Fs) ds [I, -L]`, the mean square is `trace(T X)`.
    pub(super) fn linear(&self, l: &DMatrix<f64>) -> Option<Cost> {
        Some(self.linear_error(l)?.cost)
    }

    fn linear_error(&self, l: &DMatrix<f64>) -> Option<LinearError> {
        let n = self.a.nrows();
        let f = &self.a - l * &self.c;
        let mut equation = LyapunovEquation::new(&f).ok()?;
        let poles = equation.eigenvalues();
        if poles.iter().any(|z| z.re >= 0.0) {
            return None;
        }
        let tail = equation.solve(&self.weight).ok()?.p;
        let metric = equation.solve(&DMatrix::identity(n, n)).ok()?.p;
        let p = self.c.nrows();
        let held = self.held(&f, l)?;
        let of_process = held.bd.columns(0, n);
        let of_outputs = held.bd.columns(n, p);
        let q =
            of_process * (&self.process / self.period) * of_process.transpose() + of_outputs * of_outputs.transpose();
        let x = stein(&held.ad.transpose(), &symmetric_part(&q)).ok()?.p;
        let cost = self.sum(tail.trace() / n as f64, (&self.weight * x).trace());
        Some(LinearError { f, poles, tail, metric, held, cost })
    }

    /// Kalman's gain for process noise `W + shares/(n tau)` and measurement noise of intensity h I.
    pub(super) fn kalman(&self, shares: &DMatrix<f64>) -> Result<DMatrix<f64>, LinalgError> {
        let (n, p) = (self.a.nrows(), self.c.nrows());
        let w = symmetric_part(&(&self.process + shares / (n as f64 * self.horizon)));
        Ok(kalman_gain(&self.a, &self.c, &w, &(DMatrix::identity(p, p) * self.period))?.l)
    }

    /// The linear error over a period, `e+ = ad e + bd (w, v)`.
    fn held(&self, f: &DMatrix<f64>, l: &DMatrix<f64>) -> Option<ZeroOrderHold> {
        let n = f.nrows();
        let entry = |i: usize, j: usize| match j.checked_sub(n) {
            Some(output) => -l[(i, output)],
            None => f64::from(u8::from(i == j)),
        };
        zero_order_hold(f, &DMatrix::from_fn(n, n + l.ncols(), entry), self.period).ok()
    }

    fn sum(&self, transient: f64, mean_square: f64) -> Cost {
        Cost { transient, mean_square, total: transient + self.horizon * mean_square }
    }

    /// The cost of a cubic observer; none if `A - L C` is not Hurwitz, where the error changes too fast for the steps
    /// of the integration, and as soon as the cost is known to be above `most`: the integrands are not negative.
    ///
    /// The mean square is that along the noise, or that of the linear observer with the same L in closed form plus the
    /// difference of the two along the noise, whichever is larger: either alone is too small for some slow observers.
    pub(super) fn cubic(&self, gains: &Gains, first_errors: &[Vec<f64>], noise: &Noise, most: f64) -> Option<Cost> {
        let error = &self.linear_error(&gains.l)?;
        let along = (first_errors, noise, most);
        // With the vectors that this machine has; rounded as without them.
        let found = pulp::Arch::new().dispatch(|| match gains.l.shape() {
            (1, 1) => self.along::<[Lanes; 1], [Lanes; 1]>(gains, error, along),
            (2, 1) => self.along::<[Lanes; 2], [Lanes; 1]>(gains, error, along),
            (3, 1) => self.along::<[Lanes; 3], [Lanes; 1]>(gains, error, along),
            (4, 1) => self.along::<[Lanes; 4], [Lanes; 1]>(gains, error, along),
            (2, 2) => self.along::<[Lanes; 2], [Lanes; 2]>(gains, error, along),
            (3, 2) => self.along::<[Lanes; 3], [Lanes; 2]>(gains, error, along),
            (4, 2) => self.along::<[Lanes; 4], [Lanes; 2]>(gains, error, along),
            _ => self.along::<Vec<Lanes>, Vec<Lanes>>(gains, error, along),
        });
        let (transient, with, without) = found?;
        let mean_square = with.max(error.cost.mean_square + with - without);
        Some(self.sum(transient, mean_square))
    }

    /// The mean of `int_0^inf e'Te dt` over the first errors, and those of `e'Te` along the noise with the cubic term
    /// and without it.
    #[inline(always)]
    #[allow(clippy::inline_always, reason = "compiled for the instructions of its caller")]
    fn along<E: Column<Lanes>, R: Column<Lanes>>(
        &self,
        gains: &Gains,
        LinearError { f, poles, tail, metric, held, .. }: &LinearError,
        (first_errors, noise, most): (&[Vec<f64>], &Noise, f64),
    ) -> Option<(f64, f64, f64)> {
        let (n, count) = (self.a.nrows(), first_errors.len() as f64);
        let fastest = poles.iter().map(|z| z.norm()).fold(0.0, f64::max);
        let slowest = -poles.iter().map(|z| z.re).fold(f64::NEG_INFINITY, f64::max);
        let mut flow = ErrorFlow::<E, R>::new(f, &self.c, gains, &self.weight, fastest);
        // |C e|^2 <= |C P^-1 C'| e'Pe.
        let seen = (&self.c * metric.clone().cholesky()?.solve(&self.c.transpose())).norm();
        let ahead = metric * (3.0 * gains.theta.norm() * seen);
        let (rest, mut sum) = (Rest::<E> { tail: rows(tail), ahead: rows(&ahead) }, 0.0);
        for firsts in first_errors.chunks(LANES) {
            let found = flow.transients(firsts, slowest, &rest, most * count - sum)?;
            sum += found[..firsts.len()].iter().sum::<f64>();
        }
        let transient = sum / count;
        let mut e = E::filled(n, [0.0; LANES]);
        let with = noise.mean((most - transient) / self.horizon, |values| {
            flow.held(&mut e, values.split_at(n), self.period, noise.most_steps)?;
            Some(flow.square(&e))
        })?;
        let (ad, bd, weight) = (rows::<E::Row>(&held.ad), rows::<Vec<f64>>(&held.bd), rows::<E::Row>(&self.weight));
        let mut e = E::filled(n, [0.0; LANES]);
        let without = noise.mean(f64::INFINITY, |values| {
            let before = e.clone();
            for (e, (ad, bd)) in e.as_mut().iter_mut().zip(ad.iter().zip(&bd)) {
                let (moved, added) = (dot(ad, before.as_ref()), dot(bd, values));
                *e = lanes(|lane| moved[lane] + added[lane]);
            }
            Some(square(&weight, e.as_ref()))
        })?;
        Some((transient, with, without))
    }
}

/// Directions of length one whose second moments are those of the sphere, `I/n`, exactly; one of each pair (e, -e).
pub fn directions(n: usize) -> Vec<Vec<f64>> {
    if n == 1 {
        return vec![vec![1.0]];
    }
    if n == 2 {
        let angle = |k: usize| core::f64::consts::PI * (k as f64 + 0.5) / 8.0;
        return (0..8).map(|k| vec![libm_cos(angle(k)), libm_sin(angle(k))]).collect();
    }
    // Columns of orthogonal matrices, the first of which is the identity.
    let mut draws = Stream::new(0, Purpose::ErrorDirections, 0).draws(0);
    let mut found = Vec::new();
    for basis in 0..(16usize.div_ceil(n)).max(3) {
        let q =
            if basis == 0 { DMatrix::identity(n, n) } else { DMatrix::from_fn(n, n, |_, _| draws.normal()).qr().q() };
        found.extend(q.column_iter().map(|column| column.iter().copied().collect()));
    }
    found
}

fn libm_cos(x: f64) -> f64 {
    nalgebra::ComplexField::cos(x)
}

fn libm_sin(x: f64) -> f64 {
    nalgebra::ComplexField::sin(x)
}

/// The positive semidefinite square root.
pub(super) fn square_root(m: &DMatrix<f64>) -> DMatrix<f64> {
    let eigen = SymmetricEigen::new(symmetric_part(m));
    let roots = eigen.eigenvalues.map(|value| value.max(0.0).sqrt());
    &eigen.eigenvectors * DMatrix::from_diagonal(&roots) * eigen.eigenvectors.transpose()
}
