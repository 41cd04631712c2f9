//! The sampled-data linear observer: a gain for the sampled plant, with the discrete Lyapunov matrix that proves it.
//!
//! With `x+ = Ad x + Bd u` the zero-order hold of the plant at the period h and `Fd = Ad - Ld C`, P solves
//! `Fd'P Fd - P + h I = 0`, and `V = e'Pe` decreases at every sample. The gain is designed for the sampled plant, not by
//! discretising a continuous observer, whose estimate would lag by the motion of the output within a period.
//!
//! Source: G. F. Franklin, J. D. Powell, M. L. Workman, Digital Control of Dynamic Systems, 3rd ed., Addison-Wesley
//! 1998, section 8.2.

use luenberger_linalg::{
    SteinEquation, discrete_kalman_gain, discrete_process_noise, place_observer, sampled_measurement_covariance,
    zero_order_hold,
};
use luenberger_lmi::proof_matrix;
use luenberger_observers::{SampledLinearGains, SampledLinearObserver};
use luenberger_proof::certificate::{Certificate, DiscreteConvergence};
use nalgebra::{Complex, DMatrix, Dyn};

use crate::certificate::{certified, plant};
use crate::check;
use crate::error::DesignError;
use crate::linear::LinearDesign;

certified!(SampledLinearDesign);

/// A sampled-data linear observer with its evidence.
#[readonly::make]
#[derive(Debug, Clone)]
pub struct SampledLinearDesign {
    /// The observer, ready to run.
    pub observer: SampledLinearObserver<f64, Dyn, Dyn, Dyn>,
    /// Eigenvalues of `Ad - Ld C`, as achieved.
    pub poles: Vec<Complex<f64>>,
    /// `P > 0` of the discrete Lyapunov equation.
    pub p: DMatrix<f64>,
    /// The certificate: `P > 0` and `Fd'P Fd - P < 0` for the gains as stored.
    pub certificate: Certificate,
}

impl SampledLinearDesign {
    /// The observer with the poles of `linear`, sampled every `h`: `exp(h s)` for each pole s.
    ///
    /// Exists whenever `(Ad, C)` is observable, which sampling can spoil only at special periods (Kalman, Ho and
    /// Narendra 1963). Cost: one matrix exponential, one placement, one Stein equation.
    ///
    /// ```
    /// use luenberger_design::{LinearDesign, SampledLinearDesign};
    /// let plant = luenberger_plants::double_integrator().to_dynamic();
    /// let design = SampledLinearDesign::new(&LinearDesign::with_poles(&plant, &[-2.0, -5.0])?, 0.1)?;
    /// let slowest = design.poles.iter().map(|pole| pole.norm()).fold(0.0, f64::max);
    /// assert!((slowest - (-0.2f64).exp()).abs() < 1e-12 && design.certificate.is_proved());
    /// # Ok::<(), luenberger_design::DesignError>(())
    /// ```
    ///
    /// # Errors
    /// [`DesignError::NotPositive`] for h; the errors of placement when the period hides a mode.
    pub fn new(linear: &LinearDesign, h: f64) -> Result<Self, DesignError> {
        check::positive("the sampling period h", h)?;
        let o = &linear.observer;
        let held = zero_order_hold(&o.a, &o.b, h)?;
        let poles: Vec<_> = linear.poles.iter().map(|s| (s * h).exp()).collect();
        let gain = place_observer(&held.ad, &o.c, &poles)?.gain;
        Self::with_gain(linear, (held.ad, held.bd), gain, h)
    }

    /// The stationary Kalman predictor of the sampled plant, for the intensities `w` (n x n) and `v` (p x p) of the
    /// continuous noises: `Qd = int_0^h e^(As) W e^(A's) ds`, `Rd = V/h`, `Ld = Ad Sigma C'(C Sigma C' + Rd)^-1`.
    /// Detectability is enough.
    ///
    /// # Errors
    /// As [`new`](Self::new), and those of the discrete Riccati equation.
    pub fn kalman(linear: &LinearDesign, w: &DMatrix<f64>, v: &DMatrix<f64>, h: f64) -> Result<Self, DesignError> {
        check::positive("the sampling period h", h)?;
        let o = &linear.observer;
        let w = check::positive_semidefinite("W", w, o.a.nrows())?;
        let v = check::positive_definite("V", v, o.c.nrows())?;
        let held = zero_order_hold(&o.a, &o.b, h)?;
        let noise = discrete_process_noise(&o.a, &w, h)?;
        let measurement = sampled_measurement_covariance(&v, h)?;
        let gain = discrete_kalman_gain(&held.ad, &o.c, &noise, &measurement)?.l;
        Self::with_gain(linear, (held.ad, held.bd), gain, h)
    }

    fn with_gain(
        linear: &LinearDesign,
        (ad, bd): (DMatrix<f64>, DMatrix<f64>),
        ld: DMatrix<f64>,
        h: f64,
    ) -> Result<Self, DesignError> {
        let o = &linear.observer;
        let n = o.a.nrows();
        let mut equation = SteinEquation::new(&(&ad - &ld * &o.c))?;
        // The scale of the right-hand side is that of the continuous equation over one period.
        let p = equation.solve(&(DMatrix::identity(n, n) * h))?.p;
        let poles = equation.eigenvalues();
        let theorem = DiscreteConvergence { plant: plant((&ad, &bd, &o.c)), l: proof_matrix(&ld), p: proof_matrix(&p) };
        let certificate = Certificate::of([theorem])?;
        let observer = SampledLinearObserver::new(SampledLinearGains { ad, bd, c: o.c.clone(), ld, period: h })?;
        let observer = match &o.d {
            Some(d) => observer.with_feedthrough(d.clone())?,
            None => observer,
        };
        Ok(Self { observer, poles, p, certificate })
    }
}
