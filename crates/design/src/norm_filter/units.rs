//! Units for the programs of a filter, and the Kalman filters that give them.
//!
//! With `x = T z`, `y = R v`, time in units of tau and errors in units of 1/h, all powers of two, the plant keeps its
//! form:
//! ```text
//! A~ = tau T^-1 A T,    C~ = R^-1 C T,    H~ = h H T,    gamma~ = h gamma,    L = T L~ R^-1/tau,
//! H-infinity   E~ = tau T^-1 E,          D~ = R^-1 D,             P = tau h^-2 T^-1 P~ T^-1
//! H2           E~ = tau^(1/2) T^-1 E,    D~ = tau^(-1/2) R^-1 D
//! ```
//! and tau = 1 in discrete time. T and R are the deviations of the errors and of the measurements of a filter for this
//! plant, tau is the time constant of its fastest pole: a change of units changes them alike.

use luenberger_linalg::{lyapunov, stein};
use luenberger_plants::StateSpace;
use nalgebra::{DMatrix, DVector};

use super::equations::Uncorrelated;
use super::{GeneralizedPlant, SystemNorm, Task, TimeDomain};
use crate::check;
use crate::lyapunov_choice::coordinates;
use crate::powers::{Powers, shift};

/// A Kalman filter for noise that may have been added to.
pub(super) struct Reference {
    /// Its gain.
    pub(super) l: DMatrix<f64>,
    /// The covariance of its error.
    covariance: DMatrix<f64>,
    /// The intensity of the noise of the outputs.
    noise: DMatrix<f64>,
}

/// The units of the head, as exponents.
pub(super) struct Units {
    pub(super) state: Powers,
    pub(super) output: Vec<i32>,
    /// Half of the exponent of tau.
    pub(super) half_time: i32,
    /// The exponent of h.
    pub(super) size: i32,
}

impl Task<'_> {
    /// The Kalman filter for `DD'` or, at a level, with noise of all outputs added to it that is smaller the higher the
    /// level is; none where the Riccati equation has no solution.
    pub(super) fn kalman(&self, level: Option<i32>) -> Option<Reference> {
        let (StateSpace { a, c, .. }, GeneralizedPlant { e, d, .. }) = (self.plant, self.of);
        let (outputs, through) = (c.nrows(), c * e);
        let rate = match self.time {
            TimeDomain::Continuous if a.norm() > 0.0 => a.norm(),
            _ => 1.0,
        };
        let added = DVector::from_fn(outputs, |i, _| {
            let Some(level) = level else { return 0.0 };
            let size = d.row(i).norm_squared() + through.row(i).norm_squared() / (rate * rate);
            shift(if size > 0.0 { size } else { c.row(i).norm_squared() }, -8 * level)
        });
        let Uncorrelated { a, w, v, shown, .. } = self.uncorrelated(&added)?;
        let found = check::kalman(self.time, (&a, c), &w, &v).ok()?;
        Some(Reference { l: found.l + shown, covariance: found.p, noise: v })
    }
}

/// The power of two next to `sqrt(x)`; 1 for a number that has none.
fn root(x: f64) -> i32 {
    if x > 0.0 && x.is_finite() { (0.5 * x.log2()).round() as i32 } else { 0 }
}

impl Units {
    /// Those of a filter, for a norm of this size; the units given without one.
    pub(super) fn of(task: &Task<'_>, reference: Option<(&Reference, f64)>) -> Self {
        let (n, p) = (task.plant.a.nrows(), task.plant.c.nrows());
        let Some((filter, gamma)) = reference else {
            return Self { state: Powers::given(n), output: vec![0; p], half_time: 0, size: 0 };
        };
        let variances = filter.covariance.diagonal();
        let output = filter.noise.diagonal().iter().map(|x| root(*x)).collect();
        Self::with(task, &filter.l, variances.as_slice(), output, gamma)
    }

    /// Those of a gain, from the covariance of its error under white noise.
    pub(super) fn of_gain(task: &Task<'_>, l: &DMatrix<f64>, gamma: f64) -> Self {
        let (f, g) = task.flow(l);
        let driven = &g * g.transpose();
        let variances = match task.time {
            TimeDomain::Continuous => lyapunov(&f.transpose(), &driven).map(|found| found.p),
            TimeDomain::Discrete => stein(&f.transpose(), &driven).map(|found| found.p),
        };
        let variances = variances.map_or_else(|_| Vec::new(), |p| p.diagonal().as_slice().to_vec());
        Self::with(task, l, &variances, vec![0; l.ncols()], gamma)
    }

    /// Those of a gain, whose error has these variances, or none where they are not known.
    fn with(task: &Task<'_>, l: &DMatrix<f64>, variances: &[f64], output: Vec<i32>, gamma: f64) -> Self {
        let f = task.flow(l).0;
        let are_known = variances.len() == f.nrows() && variances.iter().all(|x| *x > 0.0 && x.is_finite());
        let state = if are_known {
            Powers(variances.iter().map(|x| root(*x)).collect())
        } else {
            coordinates(task.time, &f).pop().unwrap_or_else(|| Powers::given(f.nrows()))
        };
        let half_time = match task.time {
            TimeDomain::Continuous => -root(state.similar(&f).amax()),
            TimeDomain::Discrete => 0,
        };
        Self { state, output, half_time, size: -root(gamma * gamma) }
    }

    /// A, C, E, D and H in these units.
    pub(super) fn scaled(&self, task: &Task<'_>) -> (StateSpace, GeneralizedPlant) {
        let (StateSpace { a, c, .. }, GeneralizedPlant { e, d, h }) = (task.plant, task.of);
        let (time, half) = (2 * self.half_time, self.half_time);
        let rows = |m: &DMatrix<f64>, by: i32| {
            DMatrix::from_fn(m.nrows(), m.ncols(), |i, j| shift(m[(i, j)], by - self.output[i]))
        };
        let times = |m: DMatrix<f64>, by: i32| m.map(|x| shift(x, by));
        let (driven, noisy) = match task.norm {
            SystemNorm::HInfinity => (time, 0),
            SystemNorm::H2 => (half, -half),
        };
        let plant = StateSpace {
            a: times(self.state.similar(a), time),
            b: DMatrix::zeros(a.nrows(), 0),
            c: rows(&self.state.columns(c), 0),
            d: None,
        };
        let of = GeneralizedPlant {
            e: times(self.state.rows(e), driven),
            d: rows(d, noisy),
            h: times(self.state.columns(h), self.size),
        };
        (plant, of)
    }

    /// L in the units given.
    pub(super) fn gain_back(&self, l: &DMatrix<f64>) -> DMatrix<f64> {
        let time = 2 * self.half_time;
        DMatrix::from_fn(l.nrows(), l.ncols(), |i, j| shift(l[(i, j)], self.state.0[i] - self.output[j] - time))
    }

    /// P of an H-infinity norm in the units given.
    pub(super) fn form_back(&self, p: &DMatrix<f64>) -> DMatrix<f64> {
        self.state.form_back(p).map(|x| shift(x, 2 * self.half_time - 2 * self.size))
    }
}
