//! The noise of a stationary Kalman filter: that of the process, that of the measurement, and what they have in common.

use luenberger_linalg::{
    Kalman, LinalgError, RealMatrixView, correlated_kalman_gain, discrete_correlated_kalman_gain,
    positive_semidefinite, symmetric_part, zero_order_hold,
};
use luenberger_plants::StateSpace;
use nalgebra::DMatrix;

use crate::check;
use crate::error::DesignError;
use crate::norm_filter::TimeDomain;

/// Noise of `x' = A x + B u + G w`, `y = C x + D u + v`, white and of zero mean: intensities in continuous time,
/// covariances of a sample in discrete time.
///
/// ```
/// use luenberger_design::{KalmanNoise, LinearDesign, LyapunovWeight};
/// use luenberger_plants::StateSpace;
/// use nalgebra::{dmatrix, DMatrix};
/// // x' = -x + w, y = x + w: the output shows what disturbs the state, and its error decays by itself.
/// let plant = StateSpace::new(dmatrix![-1.0], DMatrix::zeros(1, 0), dmatrix![1.0])?;
/// let one = dmatrix![1.0];
/// let noise = KalmanNoise::new(&one, &one).cross(&one);
/// let filter = LinearDesign::kalman_of(&plant, &noise, LyapunovWeight::FirstProved)?;
/// assert!((filter.l()[(0, 0)] - 1.0).abs() < 1e-15);
/// # Ok::<(), luenberger_design::DesignError>(())
/// ```
#[derive(Debug, Clone, PartialEq)]
pub struct KalmanNoise {
    /// W of the process noise w, n x n, or q x q with G; positive semidefinite.
    pub w: DMatrix<f64>,
    /// V of the measurement noise v, p x p, positive definite.
    pub v: DMatrix<f64>,
    /// G, n x q: how w enters (default: the identity).
    pub g: Option<DMatrix<f64>>,
    /// S, q x p: what w and v have in common, `E w v'` (default: 0). `[W S; S' V]` is positive semidefinite.
    pub s: Option<DMatrix<f64>>,
    /// q of [loop transfer recovery](crate::recovery) at the inputs of the plant: `q^2 B B'` is added to the noise of
    /// the states (default: 0).
    pub recovery: f64,
}

impl KalmanNoise {
    /// Noise of the states, n x n, and of the outputs, p x p, without correlation.
    pub fn new<'a>(w: impl Into<RealMatrixView<'a>>, v: impl Into<RealMatrixView<'a>>) -> Self {
        Self { w: check::owned(w), v: check::owned(v), g: None, s: None, recovery: 0.0 }
    }

    /// With w entering by `g`, n x q.
    #[must_use]
    pub fn entering<'a>(mut self, g: impl Into<RealMatrixView<'a>>) -> Self {
        self.g = Some(check::owned(g));
        self
    }

    /// With the cross-covariance `s = E w v'`, q x p.
    #[must_use]
    pub fn cross<'a>(mut self, s: impl Into<RealMatrixView<'a>>) -> Self {
        self.s = Some(check::owned(s));
        self
    }

    /// With `q^2 B B'` added to the noise of the states, for [loop transfer recovery](crate::recovery).
    #[must_use]
    pub fn recovering(mut self, q: f64) -> Self {
        self.recovery = q;
        self
    }

    /// The noise of the states themselves: `G W G' + q^2 B B'`, `V` and `G S`, checked but for what the equation
    /// checks.
    pub(crate) fn of_states(&self, plant: &StateSpace) -> Result<Self, DesignError> {
        let (n, p) = (plant.a.nrows(), plant.c.nrows());
        let q = self.g.as_ref().map_or(n, DMatrix::ncols);
        let v = check::positive_definite("V", &self.v, p)?;
        if let Some(s) = &self.s {
            check::matrix("S", s, (q, p))?;
        }
        if !(self.recovery >= 0.0 && self.recovery.is_finite()) {
            return Err(DesignError::Negative { what: "q of the recovery", value: self.recovery });
        }
        let fictitious = |w: DMatrix<f64>| match self.recovery {
            0.0 => w,
            q => symmetric_part(&(w + &plant.b * q * (&plant.b * q).transpose())),
        };
        let Some(g) = &self.g else {
            let w = fictitious(check::positive_semidefinite("W", &self.w, n)?);
            return Ok(Self { w, v, g: None, s: self.s.clone(), recovery: 0.0 });
        };
        check::matrix("G", g, (n, q))?;
        check::matrix("W", &self.w, (q, q))?;
        let w = positive_semidefinite("W", &self.w)?;
        let w = fictitious(symmetric_part(&(g * w * g.transpose())));
        Ok(Self { w, v, g: None, s: self.s.as_ref().map(|s| g * s), recovery: 0.0 })
    }

    /// The stationary gain of a plant in this time, for noise of the states.
    pub(crate) fn gain(&self, time: TimeDomain, plant: &StateSpace) -> Result<Kalman, DesignError> {
        let StateSpace { a, c, .. } = plant;
        let found = match (&self.s, time) {
            (None, time) => check::kalman(time, (a, c), &self.w, &self.v),
            (Some(s), TimeDomain::Continuous) => correlated_kalman_gain(a, c, &self.w, &self.v, s),
            (Some(s), TimeDomain::Discrete) => discrete_correlated_kalman_gain(a, c, &self.w, &self.v, s),
        };
        found.map_err(|error| check::undetectable(error, time, plant))
    }

    /// What w of a period and the mean of v over it have in common: `int_0^h e^{As} ds S / h`, for noise of the states
    /// in continuous time.
    pub(crate) fn cross_of_period(&self, a: &DMatrix<f64>, h: f64) -> Result<Option<DMatrix<f64>>, LinalgError> {
        self.s.as_ref().map(|s| Ok(zero_order_hold(a, s, h)?.bd / h)).transpose()
    }
}
