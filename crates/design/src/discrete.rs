//! The linear observer of a plant in discrete time, `x(k+1) = A x(k) + B u(k)`, `y(k) = C x(k) + D u(k)`: a gain by
//! poles, by noise covariances, by a decay rate, or given, with the Lyapunov matrix that certifies it.
//!
//! The certificate is about this recursion: with the matrices of `x' = A x + B u` it says nothing about the plant that
//! they describe. Such a plant is discretised first, by [`DiscreteDesign::sampled`],
//! [`DiscreteDesign::sampled_kalman`] or `luenberger_linalg::zero_order_hold`.
//!
//! P solves `F'P F - P + I = 0` for `F = A - L C`, so that `V = e'Pe` falls at each step by `|e|^2`; where that is not
//! proved, the same in other units. A gain by a decay rate brings its own P, with `F'P F < factor^2 P` for the factor
//! `exp(-rate h)` of a step; the inequality for both is linear in P and `Y = P L` (de Oliveira, Bernussou, Geromel
//! 1999).

use luenberger_linalg::{
    Kalman, RealMatrixView, SteinEquation, discrete_process_noise, eigenvalues, place_observer, reduced_order_observer,
    sampled_measurement_covariance, sylvester, symmetric_part, zero_order_hold,
};
use luenberger_lmi::proof_matrix;
use luenberger_observers::{DiscreteLinearObserver, StationaryKalmanFilter};
use luenberger_plants::StateSpace;
use luenberger_proof::certificate::{self, Certificate};
use luenberger_proof::statement::TimeDomain;
use nalgebra::{Complex, DMatrix, Dyn};

use crate::certificate::{certified, plant as matrices};
use crate::check;
use crate::error::{DesignError, Pair};
use crate::gain_lmi::{self, Gain};
use crate::gain_options::GainOptions;
use crate::kalman_noise::KalmanNoise;
use crate::linear::LinearDesign;
use crate::lyapunov_choice::proved_or_first;

certified!(DiscreteDesign);

/// The most decay in a period: with more the error falls by about the rounding of numbers at once.
const MOST_DECAY: f64 = 30.0;

/// A linear observer in discrete time with its certificate.
#[readonly::make]
#[derive(Debug, Clone)]
pub struct DiscreteDesign {
    /// The observer, ready to run.
    pub observer: DiscreteLinearObserver<f64, Dyn, Dyn, Dyn>,
    /// Eigenvalues of `A - L C`.
    pub poles: Vec<Complex<f64>>,
    /// `P > 0` of the Lyapunov equation in discrete time.
    pub p: DMatrix<f64>,
    /// The factor by which `sqrt(e'Pe)` is certified to fall at each step; 1 except for
    /// [`with_decay_rate`](Self::with_decay_rate) or an inequality with a specified rate.
    pub factor: f64,
    /// The certificate.
    pub certificate: Certificate,
    covariance: Option<DMatrix<f64>>,
    update: Option<DMatrix<f64>>,
}

/// The plant with its input held over the period h.
pub(crate) fn held(plant: &StateSpace, h: f64) -> Result<StateSpace, DesignError> {
    let sampled = zero_order_hold(&plant.a, &plant.b, h)?;
    Ok(StateSpace { a: sampled.ad, b: sampled.bd, ..plant.clone() }.checked()?)
}

impl DiscreteDesign {
    /// The observer whose error has the given `poles`, n numbers closed under conjugation inside the unit circle; 0 may
    /// be one of them (a deadbeat observer).
    ///
    /// `plant` is in discrete time, `x(k+1) = A x(k) + B u(k)`, sampled every `period`. For a plant `x' = A x + B u`
    /// use [`sampled`](Self::sampled), or discretise it as here:
    ///
    /// ```
    /// use luenberger_design::DiscreteDesign;
    /// use luenberger_linalg::zero_order_hold;
    /// use luenberger_plants::StateSpace;
    /// use nalgebra::dmatrix;
    /// // The double integrator x1' = x2, x2' = u, every 0.1 s: A = [1 0.1; 0 1], B = [0.005; 0.1].
    /// let held = zero_order_hold(&dmatrix![0.0, 1.0; 0.0, 0.0], &dmatrix![0.0; 1.0], 0.1)?;
    /// let plant = StateSpace::new(held.ad, held.bd, dmatrix![1.0, 0.0])?;
    /// let design = DiscreteDesign::with_poles(&plant, 0.1, &[0.5, 0.6])?;
    /// assert!((design.l() - dmatrix![0.9; 2.0]).amax() < 1e-13);
    /// assert!(design.certificate.is_proved());
    /// # Ok::<(), luenberger_design::DesignError>(())
    /// ```
    /// # Errors
    /// [`DesignError::PoleOutside`] for a pole that is not inside the unit circle; [`DesignError::Linalg`] names the
    /// mode that no gain can move; [`DesignError::Observer`] for the period.
    pub fn with_poles<Z: Into<Complex<f64>> + Copy>(
        plant: &StateSpace,
        period: f64,
        poles: &[Z],
    ) -> Result<Self, DesignError> {
        check::plant(plant)?;
        let poles: Vec<Complex<f64>> = poles.iter().map(|&pole| pole.into()).collect();
        if let Some(&pole) = poles.iter().find(|pole| pole.norm() >= 1.0) {
            return Err(DesignError::PoleOutside { pole });
        }
        let l = place_observer(&plant.a, &plant.c, &poles)?.gain;
        Self::certified(plant, period, l, None)
    }

    /// The reduced-order observer in discrete time: `w+ = F w + G y + H u`, `xhat = M w + N y` with n - p `poles`
    /// inside the unit circle, closed under conjugation.
    ///
    /// With `F = TAM` and `G = TAN` it is the observer in filter form with the gain `K = N` of the
    /// [update](Self::update_gain) and `L = A N`, since `w = T xhat(k|k-1)`: of its n poles p are 0, and
    /// `C xhat(k|k) = y(k)`. It runs in that form, whose prediction also replaces an output that is missing.
    ///
    /// ```
    /// use luenberger_design::DiscreteDesign;
    /// use luenberger_plants::StateSpace;
    /// use nalgebra::dmatrix;
    /// // x1+ = x1 + x2/2, x2+ = x2, y = x1: w = x2 - l x1, w+ = (1 - l/2) w + .., and N = (1, l).
    /// let plant = StateSpace::new(dmatrix![1.0, 0.5; 0.0, 1.0], dmatrix![0.0; 0.5], dmatrix![1.0, 0.0])?;
    /// let design = DiscreteDesign::reduced_order(&plant, 0.5, &[0.25])?;
    /// let k = design.update_gain().expect("the filter form");
    /// assert!((k - dmatrix![1.0; 1.5]).amax() < 1e-14 && design.certificate.is_proved());
    /// # Ok::<(), luenberger_design::DesignError>(())
    /// ```
    /// # Errors
    /// [`DesignError::PoleOutside`]; [`DesignError::NothingUnmeasured`] for p >= n, [`DesignError::DependentOutputs`];
    /// [`DesignError::Linalg`] names the mode that no output sees, or a number of poles that is not n - p;
    /// [`DesignError::Observer`] for the period.
    ///
    /// Source: G. F. Franklin, J. D. Powell, M. L. Workman, Digital Control of Dynamic Systems, 3rd ed., section 8.2.4.
    pub fn reduced_order<Z: Into<Complex<f64>> + Copy>(
        plant: &StateSpace,
        period: f64,
        poles: &[Z],
    ) -> Result<Self, DesignError> {
        let poles: Vec<Complex<f64>> = poles.iter().map(|&pole| pole.into()).collect();
        if let Some(&pole) = poles.iter().find(|pole| pole.norm() >= 1.0) {
            return Err(DesignError::PoleOutside { pole });
        }
        check::something_unmeasured(plant)?;
        let n = reduced_order_observer(&plant.a, &plant.b, &plant.c, &poles)?.n;
        Self::certified(plant, period, &plant.a * &n, None).map(|design| Self { update: Some(n), ..design })
    }

    /// The stationary Kalman predictor for process noise of covariance `w` (n x n, positive semidefinite) and
    /// measurement noise of covariance `v` (p x p, positive definite), per sample.
    ///
    /// `plant` is in discrete time, `x(k+1) = A x(k) + B u(k)`, sampled every `period`. For a plant `x' = A x + B u`
    /// with the intensities of its noises use [`sampled_kalman`](Self::sampled_kalman).
    ///
    /// # Errors
    /// [`DesignError::NotDetectable`] names the mode that is not detectable, [`DesignError::Linalg`] one that is not
    /// excited, or the defect of `w` and `v`.
    pub fn kalman<'a>(
        plant: &StateSpace,
        period: f64,
        w: impl Into<RealMatrixView<'a>>,
        v: impl Into<RealMatrixView<'a>>,
    ) -> Result<Self, DesignError> {
        Self::kalman_of(plant, period, &KalmanNoise::new(w, v))
    }

    /// The same for noise that enters by G, or process and measurement noise that are correlated:
    /// `L = (A P C' + G S)(C P C' + V)^-1`.
    ///
    /// # Errors
    /// As [`kalman`](Self::kalman); shapes of G and S that do not fit; a joint covariance of both noises that is not
    /// positive semidefinite.
    pub fn kalman_of(plant: &StateSpace, period: f64, noise: &KalmanNoise) -> Result<Self, DesignError> {
        check::plant(plant)?;
        let noise = noise.of_states(plant)?;
        let Kalman { l, p, .. } = noise.gain(TimeDomain::Discrete, plant)?;
        let v = &noise.v;
        let innovation = symmetric_part(&(&plant.c * &p * plant.c.transpose() + v));
        let innovation = check::positive_definite("C P C' + V", &innovation, plant.c.nrows())?;
        let update = innovation.cholesky().map(|s| s.solve(&(&plant.c * &p)).transpose());
        Self::certified(plant, period, l, Some(p)).map(|design| Self { update, ..design })
    }

    /// The observer with the poles of `linear` for its plant with the input held over the period h: `exp(h s)` for each
    /// pole s, and A, B of the zero-order hold.
    ///
    /// The gain is designed for the sampled plant, not by discretising the continuous observer, whose estimate would
    /// lag by the motion of the output within a period. For one output it is the one with these poles; for several
    /// outputs, of which many gains have them, `Ld = T^-1 G` with `T Ad - E T = G C`, where `E = exp((A - L C) h)` and
    /// `G = int_0^h exp((A - L C) s) ds L`: then `Ad - Ld C = T^-1 E T`, T tends to the identity as h does to 0, and
    /// `Ld/h` to L. Where the plant and the observer share an eigenvalue there is no such T, and the gain is placed.
    /// Exists whenever the sampled pair is observable, which sampling can spoil only at special periods
    /// (Kalman, Ho and Narendra 1963). Of an observer with modes that no output sees, which decay by themselves, the
    /// gain is G, if that is stable: then the poles are near `exp(h s)`, for periods that are short beside the poles.
    ///
    /// ```
    /// use luenberger_design::{DiscreteDesign, LinearDesign};
    /// let plant = luenberger_plants::double_integrator().to_dynamic();
    /// let design = DiscreteDesign::sampled(&LinearDesign::with_poles(&plant, &[-2.0, -5.0])?, 0.1)?;
    /// assert!((design.spectral_radius() - (-0.2f64).exp()).abs() < 1e-12 && design.certificate.is_proved());
    /// # Ok::<(), luenberger_design::DesignError>(())
    /// ```
    ///
    /// Source: G. F. Franklin, J. D. Powell, M. L. Workman, Digital Control of Dynamic Systems, 3rd ed., section 8.2; T
    /// is that of Luenberger, IEEE Transactions on Military Electronics 8, 1964.
    ///
    /// # Errors
    /// [`DesignError::NotPositive`] for h; the errors of placement when the period hides a mode.
    pub fn sampled(linear: &LinearDesign, h: f64) -> Result<Self, DesignError> {
        check::positive("the sampling period h", h)?;
        let plant = held(&linear.observer.plant(), h)?;
        let l = sampled_gain(linear, &plant.a, h)?;
        Self::certified(&plant, h, l, None)
    }

    /// The stationary Kalman predictor of the plant `x' = A x + B u` with the input held over the `period` h, for the
    /// intensities `w` (n x n) and `v` (p x p) of the continuous noises: `Qd = int_0^h e^(As) W e^(A's) ds`,
    /// `Rd = V/h`.
    ///
    /// ```
    /// use luenberger_design::DiscreteDesign;
    /// use nalgebra::dmatrix;
    /// // A random walk, x' = w with W = 2 and V = 0.5, every second: Qd = 2, Rd = 0.5.
    /// let plant = luenberger_plants::StateSpace::new(dmatrix![0.0], dmatrix![1.0], dmatrix![1.0])?;
    /// let design = DiscreteDesign::sampled_kalman(&plant, 1.0, &dmatrix![2.0], &dmatrix![0.5])?;
    /// let p = design.covariance().expect("a Kalman filter")[(0, 0)];
    /// // P - P^2/(P + Rd) + Qd = P, P^2 = Qd (P + Rd).
    /// assert!((p * p - 2.0 * (p + 0.5)).abs() < 1e-13);
    /// # Ok::<(), luenberger_design::DesignError>(())
    /// ```
    /// # Errors
    /// As [`kalman`](Self::kalman); [`DesignError::NotPositive`] for h.
    pub fn sampled_kalman<'a>(
        plant: &StateSpace,
        period: f64,
        w: impl Into<RealMatrixView<'a>>,
        v: impl Into<RealMatrixView<'a>>,
    ) -> Result<Self, DesignError> {
        Self::sampled_kalman_of(plant, period, &KalmanNoise::new(w, v))
    }

    /// The same for noise that enters by G, or process and measurement noise that are correlated: of the process noise
    /// of a period and the mean of the measurement noise over it, `int_0^h e^(As) ds G S / h`.
    ///
    /// # Errors
    /// As [`sampled_kalman`](Self::sampled_kalman) and [`kalman_of`](Self::kalman_of).
    pub fn sampled_kalman_of(plant: &StateSpace, period: f64, noise: &KalmanNoise) -> Result<Self, DesignError> {
        check::positive("the sampling period h", period)?;
        check::plant(plant)?;
        let noise = noise.of_states(plant)?;
        let sampled = KalmanNoise {
            w: discrete_process_noise(&plant.a, &noise.w, period)?,
            v: sampled_measurement_covariance(&noise.v, period)?,
            g: None,
            s: noise.cross_of_period(&plant.a, period)?,
            recovery: 0.0,
        };
        Self::kalman_of(&held(plant, period)?, period, &sampled).map_err(|error| error.of_pair(Pair::Sampled))
    }

    /// L and P by linear matrix inequality: the largest margin of `[P, A'P - C'Y'; *, P] > 0` over normalised (P, Y),
    /// `L = P^-1 Y`.
    ///
    /// It exists iff (A, C) is detectable. Cost: an SDP of `n(n+1)/2 + np` unknowns and 2n rows.
    ///
    /// # Errors
    /// [`DesignError::NotDetectable`]; [`DesignError::Infeasible`] with verified multipliers;
    /// [`DesignError::Undecided`] if neither is proved; [`DesignError::Observer`] for the period.
    pub fn lmi(plant: &StateSpace, period: f64) -> Result<Self, DesignError> {
        Self::lmi_with(plant, period, 0.0, &GainOptions::default())
    }

    /// L and P by linear matrix inequality such that every error decays at least like `exp(-rate t)`, by the factor
    /// `exp(-rate period)` at each step: `[factor^2 P, A'P - C'Y'; *, P] > 0` with the largest margin.
    ///
    /// It exists iff every mode of (A, C) of modulus >= the factor is observable.
    ///
    /// ```
    /// use luenberger_design::DiscreteDesign;
    /// use luenberger_plants::StateSpace;
    /// use nalgebra::dmatrix;
    /// let plant = StateSpace::new(dmatrix![1.0, 0.1; 0.0, 1.0], dmatrix![0.005; 0.1], dmatrix![1.0, 0.0])?;
    /// let design = DiscreteDesign::with_decay_rate(&plant, 0.1, 5.0)?;
    /// assert!(design.certificate.is_proved() && design.factor == (-0.5f64).exp());
    /// assert!(design.spectral_radius() < design.factor);
    /// # Ok::<(), luenberger_design::DesignError>(())
    /// ```
    /// # Errors
    /// As [`lmi`](Self::lmi); a rate that is not positive and finite; [`DesignError::Setting`] for a rate of more than
    /// 30 per period, with which errors fall by rounding in one step.
    pub fn with_decay_rate(plant: &StateSpace, period: f64, rate: f64) -> Result<Self, DesignError> {
        check::positive("decay rate", rate)?;
        Self::lmi_with(plant, period, rate, &GainOptions::default())
    }

    /// [`with_decay_rate`](Self::with_decay_rate), or [`lmi`](Self::lmi) for the rate 0, with a bound of the gain, the
    /// least noise gain, or another solver.
    ///
    /// # Errors
    /// As [`with_decay_rate`](Self::with_decay_rate); [`LmiError::NotBuiltIn`](luenberger_lmi::LmiError::NotBuiltIn) in
    /// [`DesignError::Lmi`].
    pub fn lmi_with(plant: &StateSpace, period: f64, rate: f64, options: &GainOptions) -> Result<Self, DesignError> {
        check::plant(plant)?;
        check::rate(rate)?;
        check::positive("the period", period)?;
        check::within("the decay rate times the period", rate * period, 0.0, MOST_DECAY)?;
        let factor = (-rate * period).exp();
        let Gain { l, p } = gain_lmi::gain_in_steps(plant, (rate, factor), options)?;
        let f = check::closed_loop((&plant.a, &l, &plant.c))?;
        // V falls by the factor iff that of F/factor falls at all.
        let (p, certificate) =
            proved_or_first(TimeDomain::Discrete, &(&f / factor), Ok(p), |p| theorem(plant, &l, p, factor))?;
        let poles = eigenvalues(&f)?;
        let observer = DiscreteLinearObserver::new(plant.clone(), l, period)?;
        Ok(Self { observer, poles, p, factor, certificate, covariance: None, update: None })
    }

    /// A given gain `l`, n x p, of a plant in discrete time, `x(k+1) = A x(k) + B u(k)`, sampled every `period`.
    ///
    /// # Errors
    /// [`DesignError::NotSchur`] if `A - L C` has an eigenvalue that is not inside the unit circle.
    pub fn with_gain<'a>(
        plant: &StateSpace,
        period: f64,
        l: impl Into<RealMatrixView<'a>>,
    ) -> Result<Self, DesignError> {
        let l = check::owned(l);
        check::plant(plant)?;
        check::matrix("L", &l, (plant.a.nrows(), plant.c.nrows()))?;
        Self::certified(plant, period, l, None)
    }

    /// The observer gain L, n x p.
    pub fn l(&self) -> &DMatrix<f64> {
        self.observer.l()
    }

    /// The stationary covariance of the prediction error, of a design by [`kalman`](Self::kalman).
    pub fn covariance(&self) -> Option<&DMatrix<f64>> {
        self.covariance.as_ref()
    }

    /// The gain K of the measurement update: of a design by [`kalman`](Self::kalman) `K = P C' (C P C' + V)^-1`, with
    /// `L = A K` unless the noises are correlated; of one by [`reduced_order`](Self::reduced_order) N, with `L = A N`.
    pub fn update_gain(&self) -> Option<&DMatrix<f64>> {
        self.update.as_ref()
    }

    /// The observer in filter form, whose estimate at a sample uses the measurement of that sample, of a design by
    /// [`kalman`](Self::kalman) or [`reduced_order`](Self::reduced_order).
    ///
    /// ```
    /// use luenberger_design::DiscreteDesign;
    /// use luenberger_plants::StateSpace;
    /// use nalgebra::dmatrix;
    /// // A random walk, W = 1, V = 2: P = 2, K = P/(P + V) = 1/2.
    /// let plant = StateSpace::new(dmatrix![1.0], dmatrix![0.0], dmatrix![1.0])?;
    /// let design = DiscreteDesign::kalman(&plant, 1.0, &dmatrix![1.0], &dmatrix![2.0])?;
    /// let filter = design.filter().expect("a Kalman filter");
    /// assert!((filter.k()[(0, 0)] - 0.5).abs() < 1e-14);
    /// # Ok::<(), luenberger_design::DesignError>(())
    /// ```
    pub fn filter(&self) -> Option<StationaryKalmanFilter<f64, Dyn, Dyn, Dyn>> {
        StationaryKalmanFilter::new(self.observer.clone(), self.update.clone()?).ok()
    }

    /// The stationary covariance `(I - K C) P` of the error of the estimate in filter form.
    pub fn filter_covariance(&self) -> Option<DMatrix<f64>> {
        let (p, k) = (self.covariance()?, self.update_gain()?);
        Some(symmetric_part(&(p - k * &self.observer.plant().c * p)))
    }

    /// The largest modulus of an eigenvalue of `A - L C`: in the end errors fall by this factor at each step.
    pub fn spectral_radius(&self) -> f64 {
        self.poles.iter().map(|pole| pole.norm()).fold(0.0, f64::max)
    }

    fn certified(
        plant: &StateSpace,
        period: f64,
        l: DMatrix<f64>,
        covariance: Option<DMatrix<f64>>,
    ) -> Result<Self, DesignError> {
        let (n, f, pair) = (plant.a.nrows(), &plant.a - &l * &plant.c, (&plant.a, &l, &plant.c));
        let equation = SteinEquation::new(&f);
        // The equation is refused where it is singular, as for a pole on the unit circle.
        let poles = equation.as_ref().map_or_else(|_| eigenvalues(&f), |equation| Ok(equation.eigenvalues()))?;
        let radius = poles.iter().map(|pole| pole.norm()).fold(0.0, f64::max);
        check::schur_stable("A - L C", (radius, true), pair)?;
        let first = equation.and_then(|mut equation| equation.solve(&DMatrix::identity(n, n)));
        let first = first.map(|found| found.p).map_err(DesignError::from);
        let (p, certificate) =
            proved_or_first(TimeDomain::Discrete, &check::closed_loop(pair)?, first, |p| theorem(plant, &l, p, 1.0))?;
        check::schur_stable("A - L C", (radius, certificate.is_proved()), pair)?;
        Ok(Self {
            observer: DiscreteLinearObserver::new(plant.clone(), l, period)?,
            poles,
            p,
            factor: 1.0,
            certificate,
            covariance,
            update: None,
        })
    }
}

/// The decrease of V, by the square of a factor below 1 or by any, decided for these numbers.
pub(crate) fn theorem(
    plant: &StateSpace,
    l: &DMatrix<f64>,
    p: &DMatrix<f64>,
    factor: f64,
) -> Result<Certificate, DesignError> {
    Ok(Certificate::of([certificate::DiscreteConvergence {
        plant: matrices((&plant.a, &plant.b, &plant.c)),
        l: proof_matrix(l),
        p: proof_matrix(p),
        factor: (factor < 1.0).then_some(factor),
    }])?)
}

/// The gain of [`DiscreteDesign::sampled`] for Ad, the plant of `linear` sampled with the period h.
pub(crate) fn sampled_gain(linear: &LinearDesign, ad: &DMatrix<f64>, h: f64) -> Result<DMatrix<f64>, DesignError> {
    let o = &linear.observer;
    // E and G: the designed observer with its measurement held.
    let own = zero_order_hold(&(&o.a - o.l() * &o.c), o.l(), h)?;
    let is_stable = |l: &DMatrix<f64>| {
        eigenvalues(&(ad - l * &o.c)).is_ok_and(|all| all.iter().all(|eigenvalue| eigenvalue.norm() < 1.0))
    };
    if o.c.nrows() > 1 {
        let similar = sylvester(&-&own.ad, ad, &(&own.bd * &o.c)).ok().and_then(|found| found.x.lu().solve(&own.bd));
        if let Some(l) = similar.filter(is_stable) {
            return Ok(l);
        }
    }
    let poles: Vec<Complex<f64>> = linear.poles.iter().map(|s| (s * h).exp()).collect();
    match place_observer(ad, &o.c, &poles) {
        Ok(placed) => Ok(placed.gain),
        Err(_) if is_stable(&own.bd) => Ok(own.bd),
        Err(error) => Err(DesignError::from(error).of_pair(Pair::Sampled)),
    }
}
