//! The sampled-data cubic observer: stable at every period, with the discrete Lyapunov matrix that proves it.
//!
//! With `x+ = Ad x + Bd u`, `Fd = Ad - Ld C`, `Fd'P Fd - P = -Q < 0` and `N = -P^-1 C'S`, `S = w (C P^-1 C')^-1`, one
//! period of the cubic flow does not increase `V = e'Pe` (its derivative is `-2 (y~'theta y~) y~'S y~`), and the linear
//! step multiplies it by at most `1 - lambda_min(P^-1/2 Q P^-1/2)`. Hence global exponential stability, whatever the
//! period: no step size has to be small.
//!
//! The stored N violates the structure `P N = -C'S` by its rounding, but the structure is not needed: one step is `e+ =
//! M(g) e` with `M(g) = Fd + g (Ad N + w Ld) C`, `0 <= g < 1/w`, for any N, and `M'PM - P` is convex in g. The
//! certificate has the decrease at both ends, `M(0) = Fd` and `w M(1/w) = w Ad + Ad N C`, for the stored numbers: they
//! prove convergence in exact arithmetic. The effect of f32 or fixed point is analysed by
//! [`SampledCubicDesign::deployed`].
//!
//! Gains that are not radial, `S = gamma theta` or any S with `S + S' >= 0`, have no closed form of the flow: with
//! [`SampledCubicDesign::with_cubic_gain`] the observer takes the semi-implicit step of
//! [`luenberger_observers::semi_implicit`], which does not increase V either, at any period. The stored N violates the
//! structure by `R = PN + C'S`; with a small R, which the certificate has in an inequality, V still falls at each step.

use luenberger_linalg::{LinalgError, RealMatrixView, SteinEquation, discrete_kalman_gain};
use luenberger_lmi::proof_matrix;
use luenberger_observers::{SampledCubicGains, SampledCubicObserver, SampledObserver, semi_implicit};
use luenberger_plants::StateSpace;
use luenberger_proof::certificate::{self, Certificate, CertificateFile, DiscreteConvergence};
use luenberger_proof::statement::TimeDomain;
use nalgebra::{Complex, DMatrix, Dyn};

use crate::certificate::{certified, plant as matrices};
use crate::check;
use crate::cubic::{CubicDesign, CubicGain, structure};
use crate::discrete::{self, DiscreteDesign};
use crate::error::{DesignError, Pair};
use crate::linear::LinearDesign;
use crate::lyapunov_choice::proved_or_first;

certified!(SampledCubicDesign);

/// A sampled-data cubic observer with its certificate.
#[readonly::make]
#[derive(Debug, Clone)]
pub struct SampledCubicDesign {
    /// The observer, ready to run.
    pub observer: SampledCubicObserver<f64, Dyn, Dyn, Dyn>,
    /// Eigenvalues of `Ad - Ld C`, as achieved: those of the continuous design, mapped by `z = exp(h s)`.
    pub poles: Vec<Complex<f64>>,
    /// `P > 0` of the discrete Lyapunov equation.
    pub p: DMatrix<f64>,
    /// S of `N = -P^-1 C'S`.
    pub s: DMatrix<f64>,
    /// The certificate.
    pub certificate: Certificate,
}

impl SampledCubicDesign {
    /// The observer with the poles of `linear`, sampled every `h`, with weight `theta` (p x p, positive semidefinite)
    /// and strength w > 0: under the cubic part alone the output error decays like `1/sqrt(1 + 2 w (y~'theta y~) t)`.
    ///
    /// Exists whenever `(Ad, C)` is observable, which sampling can spoil only at special periods (Kalman, Ho and
    /// Narendra 1963). Cost: one matrix exponential, one placement, one Stein equation.
    ///
    /// ```
    /// use luenberger_design::{LyapunovWeight, LinearDesign, SampledCubicDesign};
    /// use nalgebra::dmatrix;
    ///
    /// let plant = luenberger_plants::double_integrator().to_dynamic();
    /// let linear = LinearDesign::with_poles_and_weight(&plant, &[-2.0, -5.0], LyapunovWeight::Identity(10.0))?;
    /// let design = SampledCubicDesign::new(&linear, &dmatrix![1.0], 10.0, 1e-3)?;
    /// assert!(design.certificate.is_proved());
    /// # Ok::<(), luenberger_design::DesignError>(())
    /// ```
    ///
    /// # Errors
    /// [`DesignError::NotPositive`] for h or w; `NotPositiveSemidefinite` for theta; [`DesignError::DependentOutputs`];
    /// the errors of placement when the period hides a mode.
    pub fn new<'a>(
        linear: &LinearDesign,
        theta: impl Into<RealMatrixView<'a>>,
        w: f64,
        h: f64,
    ) -> Result<Self, DesignError> {
        Self::with_cubic_gain(linear, theta, &CubicGain::Radial(w), h)
    }

    /// As [`new`](Self::new), with any admissible cubic gain: in closed form for [`CubicGain::Radial`], else with a
    /// semi-implicit step.
    ///
    /// ```
    /// use luenberger_design::{CubicGain, LinearDesign, SampledCubicDesign};
    /// use luenberger_plants::StateSpace;
    /// use nalgebra::{DMatrix, dmatrix};
    ///
    /// let a = dmatrix![0.0, 1.0, 0.0; 0.0, 0.0, 1.0; -1.0, -2.0, 0.0];
    /// let plant = StateSpace::new(a, DMatrix::zeros(3, 0), dmatrix![1.0, 0.0, 0.0; 0.0, 0.0, 1.0])?;
    /// let linear = LinearDesign::with_poles(&plant, &[-1.0, -2.0, -3.0])?;
    /// let s = CubicGain::General(dmatrix![2.0, 1.0; -1.0, 0.5]);
    /// let design = SampledCubicDesign::with_cubic_gain(&linear, &DMatrix::identity(2, 2), &s, 0.1)?;
    /// assert!(design.certificate.is_proved());
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    /// # Errors
    /// As [`new`](Self::new); [`DesignError`] for an S of another shape, or with `S + S'` not positive semidefinite.
    pub fn with_cubic_gain<'a>(
        linear: &LinearDesign,
        theta: impl Into<RealMatrixView<'a>>,
        cubic_gain: &CubicGain,
        h: f64,
    ) -> Result<Self, DesignError> {
        let (plant, ld) = placed(linear, h)?;
        Self::with_gain(&plant, ld, &check::owned(theta), cubic_gain, (h, Lyapunov::FirstProved))
    }

    /// The same for the stationary Kalman predictor of the sampled plant: `Ld = Ad Sigma C'(C Sigma C' + V)^-1` for
    /// process noise of covariance W (n x n) per sample and measurement noise V (p x p). Detectability is enough.
    ///
    /// # Errors
    /// As [`new`](Self::new), and those of the discrete Riccati equation.
    pub fn kalman<'a>(
        linear: &LinearDesign,
        noise: impl Into<RealMatrixView<'a>>,
        measurement: impl Into<RealMatrixView<'a>>,
        theta: impl Into<RealMatrixView<'a>>,
        w: f64,
        h: f64,
    ) -> Result<Self, DesignError> {
        let o = &linear.observer;
        check::positive("the sampling period h", h)?;
        let noise = check::positive_semidefinite("W", &check::owned(noise), o.a.nrows())?;
        let measurement = check::positive_definite("V", &check::owned(measurement), o.c.nrows())?;
        let plant = discrete::held(&o.plant(), h)?;
        let ld = discrete_kalman_gain(&plant.a, &o.c, &noise, &measurement).map_err(of_sampled)?.l;
        Self::with_gain(&plant, ld, &check::owned(theta), &CubicGain::Radial(w), (h, Lyapunov::FirstProved))
    }

    /// The sampled form of a continuous design: same poles, same theta, same strength `w = trace(C P^-1 C'S) / p` of
    /// its cubic term.
    ///
    /// # Errors
    /// As [`new`](Self::new).
    pub fn from_cubic(linear: &LinearDesign, cubic: &CubicDesign, h: f64) -> Result<Self, DesignError> {
        let o = &cubic.observer;
        Self::new(linear, &o.theta, luenberger_observers::cubic::rate(&o.c, &o.n), h)
    }

    /// As [`from_cubic`](Self::from_cubic), with the P of the same Q, `Fd'P Fd - P = -h Q`, which approaches that of
    /// the continuous design as h -> 0, and with its S: the direction of N is kept. In closed form for one output, else
    /// with a semi-implicit step.
    ///
    /// # Errors
    /// As [`with_cubic_gain`](Self::with_cubic_gain).
    pub fn from_cubic_with_weight(linear: &LinearDesign, cubic: &CubicDesign, h: f64) -> Result<Self, DesignError> {
        let o = &cubic.observer;
        let cubic_gain = match o.c.nrows() {
            1 => CubicGain::Radial(luenberger_observers::cubic::rate(&o.c, &o.n)),
            _ => CubicGain::General(cubic.s.clone()),
        };
        let (plant, ld) = placed(linear, h)?;
        Self::with_gain(&plant, ld, &o.theta, &cubic_gain, (h, Lyapunov::Weight(&(&cubic.q * h))))
    }

    /// The observer of a plant in discrete time with the gain of `linear`, weight `theta` and strength `w`.
    ///
    /// ```
    /// use luenberger_design::{DiscreteDesign, SampledCubicDesign};
    /// use luenberger_plants::StateSpace;
    /// use nalgebra::dmatrix;
    /// let plant = StateSpace::new(dmatrix![1.0, 0.1; 0.0, 1.0], dmatrix![0.005; 0.1], dmatrix![1.0, 0.0])?;
    /// let linear = DiscreteDesign::with_poles(&plant, 0.1, &[0.5, 0.6])?;
    /// let design = SampledCubicDesign::of_discrete(&linear, &dmatrix![1.0], 10.0)?;
    /// assert!(design.certificate.is_proved());
    /// # Ok::<(), luenberger_design::DesignError>(())
    /// ```
    /// # Errors
    /// As [`new`](Self::new).
    pub fn of_discrete<'a>(
        linear: &DiscreteDesign,
        theta: impl Into<RealMatrixView<'a>>,
        w: f64,
    ) -> Result<Self, DesignError> {
        Self::of_discrete_with_cubic_gain(linear, theta, &CubicGain::Radial(w))
    }

    /// The same with any admissible cubic gain, as [`with_cubic_gain`](Self::with_cubic_gain).
    ///
    /// # Errors
    /// As [`with_cubic_gain`](Self::with_cubic_gain).
    pub fn of_discrete_with_cubic_gain<'a>(
        linear: &DiscreteDesign,
        theta: impl Into<RealMatrixView<'a>>,
        cubic_gain: &CubicGain,
    ) -> Result<Self, DesignError> {
        let o = &linear.observer;
        Self::with_gain(o.plant(), o.l().clone(), &check::owned(theta), cubic_gain, (o.period(), Lyapunov::FirstProved))
    }

    /// The same linear observer with the cubic gain that belongs to another P (n x n).
    pub(crate) fn with_lyapunov(&self, p: &DMatrix<f64>, cubic_gain: &CubicGain) -> Result<Self, DesignError> {
        let o = &self.observer;
        let plant = StateSpace::new(o.ad().clone(), o.bd().clone(), o.c().clone())?;
        let plant = StateSpace { d: o.d().cloned(), ..plant };
        Self::with_gain(&plant, o.ld().clone(), o.theta(), cubic_gain, (o.period(), Lyapunov::Matrix(p)))
    }

    fn with_gain(
        plant: &StateSpace,
        ld: DMatrix<f64>,
        theta: &DMatrix<f64>,
        cubic_gain: &CubicGain,
        (h, given): (f64, Lyapunov<'_>),
    ) -> Result<Self, DesignError> {
        let StateSpace { a: ad, b: bd, c, d } = plant.clone();
        let (n, outputs) = (ad.nrows(), c.nrows());
        let theta = &check::positive_semidefinite("theta", theta, outputs)?;
        if matches!(cubic_gain, CubicGain::Radial(_)) {
            check::independent_outputs(&c)?;
        }
        let f = &ad - &ld * &c;
        let mut equation = SteinEquation::new(&f)?;
        // The scale of Q is that of the continuous equation over one period.
        let p = match given {
            Lyapunov::Matrix(p) => p.clone(),
            Lyapunov::Weight(q) => equation.solve(q)?.p,
            Lyapunov::FirstProved => {
                let first = equation.solve(&(DMatrix::identity(n, n) * h)).map(|found| found.p);
                let exact = check::closed_loop((&ad, &ld, &c))?;
                let decreasing = |p: &DMatrix<f64>| discrete::theorem(plant, &ld, p, 1.0);
                proved_or_first(TimeDomain::Discrete, &exact, first.map_err(DesignError::from), decreasing)?.0
            }
        };
        let poles = equation.eigenvalues();
        let p_inverse_ct = check::solve_definite("P", &p, &c.transpose())?;
        let s = structure(cubic_gain, theta, (&c, &p_inverse_ct))?;
        let gain = -(p_inverse_ct * &s);
        let numbers = (matrices((&ad, &bd, &c)), [&ld, &gain, theta, &p].map(proof_matrix));
        let (plant, [l, n_stored, weight, lyapunov]) = numbers;
        let gains = |w| SampledCubicGains { ad, bd, c, ld, n: gain, theta: theta.clone(), w, period: h };
        let (observer, certificate) = match cubic_gain {
            CubicGain::Radial(w) => {
                let theorem = certificate::SampledCubicConvergence {
                    plant,
                    l,
                    n: n_stored,
                    theta: weight,
                    w: *w,
                    period: h,
                    p: lyapunov,
                };
                (SampledCubicObserver::new(gains(*w))?, Certificate::of([theorem])?)
            }
            CubicGain::Gamma(_) | CubicGain::General(_) => {
                let theorem = certificate::SemiImplicitCubicConvergence {
                    plant,
                    l,
                    n: n_stored,
                    theta: weight,
                    period: h,
                    p: lyapunov,
                    s: proof_matrix(&s),
                };
                let gains = gains(0.0);
                let coupling = semi_implicit::coupling(&gains.c, &gains.n);
                (SampledCubicObserver::semi_implicit(gains, coupling)?, Certificate::of([theorem])?)
            }
        };
        let observer = match d {
            Some(d) => observer.with_feedthrough(d)?,
            None => observer,
        };
        Ok(Self { observer, poles, p, s, certificate })
    }

    /// The observer gain Ld, n x p.
    pub fn l(&self) -> &DMatrix<f64> {
        self.observer.ld()
    }

    /// The certificate file of its linear part alone, `xhat+ = Ad xhat + Bd u + Ld(y - C xhat)`.
    ///
    /// # Errors
    /// [`DesignError::CertificateFile`] names the inequality that is not proved.
    pub fn linear_certificate_file(&self, title: &str) -> Result<CertificateFile, DesignError> {
        let o = &self.observer;
        let theorem = DiscreteConvergence {
            plant: matrices((o.ad(), o.bd(), o.c())),
            l: proof_matrix(o.ld()),
            p: proof_matrix(&self.p),
            factor: None,
        };
        Ok(CertificateFile::prove(title, theorem)?)
    }
}

/// The choice of P.
enum Lyapunov<'a> {
    /// By the equation with `Q = h I` or, where that is not proved, the first of a list.
    FirstProved,
    /// By the equation with this Q.
    Weight(&'a DMatrix<f64>),
    /// This one.
    Matrix(&'a DMatrix<f64>),
}

/// The plant of a continuous design with its input held over h, and the gain with the same poles.
fn placed(linear: &LinearDesign, h: f64) -> Result<(StateSpace, DMatrix<f64>), DesignError> {
    check::positive("the sampling period h", h)?;
    let plant = discrete::held(&linear.observer.plant(), h)?;
    let gain = discrete::sampled_gain(linear, &plant.a, h)?;
    Ok((plant, gain))
}

/// An error of the sampled pair.
fn of_sampled(error: LinalgError) -> DesignError {
    DesignError::from(error).of_pair(Pair::Sampled)
}
