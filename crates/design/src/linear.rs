//! The linear observer (2): a gain L by pole placement, noise intensities, LMI or given, with the Lyapunov matrix that
//! certifies it.
//!
//! Every design ends with the same pair `P > 0`, `Q > 0` and `F'P + P F = -Q` for `F = A - L C` (9), so that later
//! designs (the cubic term, robustness margins, feedback) do not depend on how L was computed.
//!
//! A feedthrough D has no part in it: the observer subtracts D u from y, and the error obeys the same equation.

use luenberger_linalg::{Kalman, RealMatrixView, eigenvalues, place_observer, symmetric_part};
use luenberger_lmi::proof_matrix;
use luenberger_observers::LinearObserver;
use luenberger_plants::StateSpace;
use luenberger_proof::certificate::{self, Certificate, PlantWithin};
use luenberger_proof::statement::TimeDomain;
use nalgebra::{Complex, DMatrix, Dyn};

use crate::certificate::certified;
use crate::check::{self, StableLoop};
use crate::error::DesignError;
use crate::gain_lmi::{self, Gain};
use crate::gain_options::GainOptions;
use crate::kalman_noise::KalmanNoise;
use crate::lyapunov_choice::proved_or_first;

/// The right-hand side Q of the Lyapunov equation `F'P + P F + Q = 0` that certifies a gain.
///
/// One that is given is kept as it is: that its P fails does not mean that the observer does.
///
/// Designs by LMI ([`LinearDesign::lmi`], [`LinearDesign::with_decay_rate`]) bring their own P, and Q follows from it.
#[derive(Debug, Clone, PartialEq, Default)]
pub enum LyapunovWeight {
    /// The identity or, where that P is not proved, the first of a short list in other units.
    #[default]
    FirstProved,
    /// `Q = rho I`, for which the theorems on the infinite-horizon cost hold; where that P is not proved, as
    /// [`FirstProved`](Self::FirstProved), with another Q.
    Identity(f64),
    /// Any `Q = Q' > 0`, n x n.
    Matrix(DMatrix<f64>),
    /// Only for [`LinearDesign::kalman`]: P is the inverse of the stationary covariance (the information matrix), and
    /// `Q = P W P + C'V^-1 C`, which must be positive definite. Then `S = alpha V^-1` gives `N = -alpha L`.
    InverseCovariance,
}

impl LyapunovWeight {
    fn matrix(self, n: usize) -> Result<DMatrix<f64>, DesignError> {
        match self {
            Self::FirstProved => Ok(DMatrix::identity(n, n)),
            Self::Identity(rho) => {
                check::positive("rho, the factor of the identity in LyapunovWeight::Identity,", rho)?;
                Ok(DMatrix::identity(n, n) * rho)
            }
            Self::Matrix(q) => check::positive_definite("Q", &q, n),
            Self::InverseCovariance => Err(DesignError::NoCovariance),
        }
    }
}

certified!(LinearDesign);

/// A linear observer with its certificate.
#[readonly::make]
#[derive(Debug, Clone)]
pub struct LinearDesign {
    /// The observer (2), ready to run.
    pub observer: LinearObserver<f64, Dyn, Dyn, Dyn>,
    /// Eigenvalues of `F = A - L C`.
    pub poles: Vec<Complex<f64>>,
    /// `P > 0` of (9).
    pub p: DMatrix<f64>,
    /// `Q = -(F'P + PF) > 0` of (9).
    pub q: DMatrix<f64>,
    /// The certified decay rate, 0 except for [`LinearDesign::with_decay_rate`] or an inequality with a specified rate.
    pub rate: f64,
    /// The certificate.
    pub certificate: Certificate,
    origin: Origin,
}

/// Source of the gain, which determines the possible P.
#[derive(Debug, Clone)]
enum Origin {
    /// Poles, or a given gain: P solves the Lyapunov equation.
    Gain,
    /// Kalman's gain, with its stationary covariance.
    Kalman(DMatrix<f64>),
    /// An inequality that includes P.
    Inequality,
}

impl LinearDesign {
    /// The observer whose error has the given `poles`: `L` with the eigenvalues of `A - L C` there.
    ///
    /// `poles` are n numbers, real or complex, closed under conjugation, all in the open left half plane. They exist
    /// for every choice iff (A, C) is observable. P solves `F'P + P F + I = 0`;
    /// [`with_poles_and_weight`](Self::with_poles_and_weight) chooses another right-hand side. Cost: one placement and
    /// one Lyapunov equation, about `35 n^3`, and the proof.
    ///
    /// ```
    /// use luenberger_design::{LinearDesign, LyapunovWeight};
    ///
    /// let plant = luenberger_plants::double_integrator().to_dynamic();
    /// let design = LinearDesign::with_poles_and_weight(&plant, &[-2.0, -5.0], LyapunovWeight::Identity(10.0))?;
    /// assert!((design.l()[(1, 0)] - 10.0).abs() < 1e-12);
    /// let f = &plant.a - design.l() * &plant.c;
    /// let residual = f.transpose() * &design.p + &design.p * f + &design.q;
    /// assert!(residual.norm() < 1e-13 * design.p.norm());
    /// assert_eq!(design.to_string().lines().next(), Some("L = [7; 10]")); // then poles and verdicts
    /// assert!(design.certificate.is_proved());
    /// # Ok::<(), luenberger_design::DesignError>(())
    /// ```
    ///
    /// # Errors
    /// [`DesignError::UnstablePole`] for a pole not in the open left half plane; [`DesignError::Linalg`] names the mode
    /// that no gain can move.
    pub fn with_poles<Z: Into<Complex<f64>> + Copy>(plant: &StateSpace, poles: &[Z]) -> Result<Self, DesignError> {
        Self::with_poles_and_weight(plant, poles, LyapunovWeight::FirstProved)
    }

    /// The same, certified by the Lyapunov equation with this right-hand side.
    ///
    /// # Errors
    /// As [`with_poles`](Self::with_poles); [`DesignError::NoCovariance`] for [`LyapunovWeight::InverseCovariance`]; a
    /// Q that is not symmetric and positive definite.
    pub fn with_poles_and_weight<Z: Into<Complex<f64>> + Copy>(
        plant: &StateSpace,
        poles: &[Z],
        weight: LyapunovWeight,
    ) -> Result<Self, DesignError> {
        check::plant(plant)?;
        let poles: Vec<Complex<f64>> = poles.iter().map(|&pole| pole.into()).collect();
        if let Some(&pole) = poles.iter().find(|pole| pole.re >= 0.0) {
            return Err(DesignError::UnstablePole { pole });
        }
        let l = place_observer(&plant.a, &plant.c, &poles)?.gain;
        Self::with_equation(plant, l, Origin::Gain, weight)
    }

    /// The stationary Kalman filter: `L = Sigma C'V^-1` for process noise of intensity `w` and measurement noise of
    /// intensity `v`.
    ///
    /// `w` is n x n, positive semidefinite; `v` is p x p, positive definite. It exists iff (A, C) is detectable and W
    /// excites every mode on the imaginary axis. P solves `F'P + P F + I = 0`;
    /// [`kalman_with_weight`](Self::kalman_with_weight) chooses another right-hand side.
    ///
    /// ```
    /// use luenberger_design::LinearDesign;
    /// use nalgebra::{Matrix2, matrix};
    ///
    /// let plant = luenberger_plants::double_integrator().to_dynamic();
    /// let filter = LinearDesign::kalman(&plant, &Matrix2::new(0.0, 0.0, 0.0, 4.0), &matrix![1.0])?;
    /// // L = (sqrt(2 w), w) for the ratio w = 2 of the standard deviations.
    /// assert!((filter.l() - matrix![2.0; 2.0]).norm() < 1e-14);
    /// # Ok::<(), luenberger_design::DesignError>(())
    /// ```
    ///
    /// # Errors
    /// [`DesignError::NotDetectable`] names the mode that is not detectable, [`DesignError::Linalg`] one that is not
    /// excited, or the defect of `w` and `v`.
    pub fn kalman<'a>(
        plant: &StateSpace,
        w: impl Into<RealMatrixView<'a>>,
        v: impl Into<RealMatrixView<'a>>,
    ) -> Result<Self, DesignError> {
        Self::kalman_with_weight(plant, w, v, LyapunovWeight::FirstProved)
    }

    /// The same, certified by the Lyapunov equation with this right-hand side; with
    /// [`LyapunovWeight::InverseCovariance`] P is the inverse of the covariance Sigma.
    ///
    /// # Errors
    /// As [`kalman`](Self::kalman); a Q that is not symmetric and positive definite.
    pub fn kalman_with_weight<'a>(
        plant: &StateSpace,
        w: impl Into<RealMatrixView<'a>>,
        v: impl Into<RealMatrixView<'a>>,
        weight: LyapunovWeight,
    ) -> Result<Self, DesignError> {
        Self::kalman_of(plant, &KalmanNoise::new(w, v), weight)
    }

    /// The same for noise that enters by G, or process and measurement noise that are correlated:
    /// `L = (Sigma C' + G S) V^-1`.
    ///
    /// # Errors
    /// As [`kalman_with_weight`](Self::kalman_with_weight); shapes of G and S that do not fit; a joint intensity of
    /// both noises that is not positive semidefinite.
    pub fn kalman_of(plant: &StateSpace, noise: &KalmanNoise, weight: LyapunovWeight) -> Result<Self, DesignError> {
        check::plant(plant)?;
        let Kalman { l, p, .. } = noise.of_states(plant)?.gain(TimeDomain::Continuous, plant)?;
        Self::with_equation(plant, l, Origin::Kalman(p), weight)
    }

    /// A given gain `l`, n x p, with P from `F'P + P F + I = 0`.
    ///
    /// # Errors
    /// [`DesignError::NotHurwitz`] if `A - L C` has an eigenvalue that is not in the open left half plane.
    pub fn with_gain<'a>(plant: &StateSpace, l: impl Into<RealMatrixView<'a>>) -> Result<Self, DesignError> {
        Self::with_gain_and_weight(plant, l, LyapunovWeight::FirstProved)
    }

    /// The same, certified by the Lyapunov equation with this right-hand side.
    ///
    /// # Errors
    /// As [`with_gain`](Self::with_gain); [`DesignError::NoCovariance`] for [`LyapunovWeight::InverseCovariance`]; a Q
    /// that is not symmetric and positive definite.
    pub fn with_gain_and_weight<'a>(
        plant: &StateSpace,
        l: impl Into<RealMatrixView<'a>>,
        weight: LyapunovWeight,
    ) -> Result<Self, DesignError> {
        let l = check::owned(l);
        check::plant(plant)?;
        check::matrix("L", &l, (plant.a.nrows(), plant.c.nrows()))?;
        Self::with_equation(plant, l, Origin::Gain, weight)
    }

    /// L and P by linear matrix inequality: the largest margin of `A'P + P A - Y C - C'Y' < 0` over normalised (P, Y),
    /// `L = P^-1 Y`.
    ///
    /// It exists iff (A, C) is detectable. Cost: an SDP of `n(n+1)/2 + np` unknowns.
    ///
    /// # Errors
    /// [`DesignError::Infeasible`] with verified multipliers; [`DesignError::Undecided`] if neither is proved.
    pub fn lmi(plant: &StateSpace) -> Result<Self, DesignError> {
        Self::lmi_with(plant, 0.0, &GainOptions::default())
    }

    /// L and P by linear matrix inequality such that every error decays at least like `exp(-rate t)`:
    /// `A'P + P A - Y C - C'Y' + 2 rate P < 0` with the largest margin.
    ///
    /// It exists iff every mode of (A, C) with real part >= -`rate` is observable.
    ///
    /// # Errors
    /// As [`lmi`](Self::lmi); a rate that is not positive and finite.
    pub fn with_decay_rate(plant: &StateSpace, rate: f64) -> Result<Self, DesignError> {
        check::positive("decay rate", rate)?;
        Self::lmi_with(plant, rate, &GainOptions::default())
    }

    /// [`with_decay_rate`](Self::with_decay_rate), or [`lmi`](Self::lmi) for the rate 0, with a bound of the gain, the
    /// least noise gain, or another solver.
    ///
    /// # Errors
    /// As [`with_decay_rate`](Self::with_decay_rate); [`LmiError::NotBuiltIn`](luenberger_lmi::LmiError::NotBuiltIn) in
    /// [`DesignError::Lmi`].
    pub fn lmi_with(plant: &StateSpace, rate: f64, options: &GainOptions) -> Result<Self, DesignError> {
        check::plant(plant)?;
        Self::with_lyapunov_matrix(plant, gain_lmi::gain_by_lmi(plant, rate, options)?, rate)
    }

    /// P by the Lyapunov equation for `Q = I` or, where that is not proved, for another Q.
    fn with_some_weight(plant: &StateSpace, l: DMatrix<f64>, origin: Origin) -> Result<Self, DesignError> {
        let (n, pair) = (plant.a.nrows(), (&plant.a, &l, &plant.c));
        let closed = StableLoop::new("A - L C", pair)?;
        let poles = closed.poles.clone();
        let first = closed.lyapunov(&DMatrix::identity(n, n));
        let plain = first.clone().ok();
        let f = check::closed_loop(pair)?;
        let (p, certificate) = proved_or_first(TimeDomain::Continuous, &f, first, |p| theorem(plant, &l, p, 0.0))?;
        if !certificate.is_proved() {
            check::not_refuted("A - L C", closed_abscissa(&poles), pair)?;
        }
        let q = if plain.as_ref() == Some(&p) { DMatrix::identity(n, n) } else { right_hand_side(&f, &p) };
        let observer = LinearObserver::of(plant.clone(), l)?;
        Ok(Self { observer, poles, p, q, rate: 0.0, certificate, origin })
    }

    /// P by the Lyapunov equation of the weight, or from the covariance.
    fn with_equation(
        plant: &StateSpace,
        l: DMatrix<f64>,
        origin: Origin,
        weight: LyapunovWeight,
    ) -> Result<Self, DesignError> {
        let n = plant.a.nrows();
        let is_identity = matches!(weight, LyapunovWeight::Identity(_));
        let (poles, p, q) = match (&origin, weight) {
            (_, LyapunovWeight::FirstProved) => return Self::with_some_weight(plant, l, origin),
            (Origin::Kalman(covariance), LyapunovWeight::InverseCovariance) => {
                let identity = DMatrix::identity(n, n);
                let inverse = check::solve_definite("the stationary covariance", covariance, &identity)?;
                let p = symmetric_part(&inverse);
                let f = &plant.a - &l * &plant.c;
                let q = right_hand_side(&f, &p);
                check::positive_definite("Q = P W P + C'V^-1 C", &q, n)?;
                (eigenvalues(&f)?, p, q)
            }
            (_, weight) => {
                let closed = StableLoop::new("A - L C", (&plant.a, &l, &plant.c))?;
                let q = weight.matrix(n)?;
                (closed.poles.clone(), closed.lyapunov(&q)?, q)
            }
        };
        let design = Self::certified(plant, l, poles, (p, q), 0.0, origin)?;
        // In unsuitable units the rounding of P decides by chance, whatever the factor of the identity.
        let other = if is_identity && !design.certificate.is_proved() {
            Self::with_some_weight(plant, design.l().clone(), design.origin.clone()).ok()
        } else {
            None
        };
        Ok(other.filter(|other| other.certificate.is_proved()).unwrap_or(design))
    }

    /// A design whose P came with the gain, and certifies the decay rate.
    pub(crate) fn with_lyapunov_matrix(plant: &StateSpace, gain: Gain, rate: f64) -> Result<Self, DesignError> {
        let Gain { l, p } = gain;
        let f = &plant.a - &l * &plant.c;
        let q = right_hand_side(&f, &p);
        Self::certified(plant, l, eigenvalues(&f)?, (p, q), rate, Origin::Inequality)
    }

    fn certified(
        plant: &StateSpace,
        l: DMatrix<f64>,
        poles: Vec<Complex<f64>>,
        (p, q): (DMatrix<f64>, DMatrix<f64>),
        rate: f64,
        origin: Origin,
    ) -> Result<Self, DesignError> {
        let certificate = theorem(plant, &l, &p, rate)?;
        let observer = LinearObserver::of(plant.clone(), l)?;
        Ok(Self { observer, poles, p, q, rate, certificate, origin })
    }

    /// The observer gain L, n x p.
    pub fn l(&self) -> &DMatrix<f64> {
        self.observer.l()
    }

    /// The stationary covariance of the error of a design by [`kalman`](Self::kalman), the stabilising solution of the
    /// Riccati equation; none for other designs. [`p`](Self::p) is the Lyapunov matrix.
    pub fn covariance(&self) -> Option<&DMatrix<f64>> {
        match &self.origin {
            Origin::Kalman(covariance) => Some(covariance),
            Origin::Gain | Origin::Inequality => None,
        }
    }

    /// The largest real part of an eigenvalue of `F = A - L C`: in the end errors decay like `exp` of this times t.
    pub fn spectral_abscissa(&self) -> f64 {
        closed_abscissa(&self.poles)
    }

    /// `F = A - L C`.
    pub fn error_matrix(&self) -> DMatrix<f64> {
        &self.observer.a - self.l() * &self.observer.c
    }
}

fn closed_abscissa(poles: &[Complex<f64>]) -> f64 {
    poles.iter().map(|pole| pole.re).fold(f64::NEG_INFINITY, f64::max)
}

/// `-(F'P + PF)`.
fn right_hand_side(f: &DMatrix<f64>, p: &DMatrix<f64>) -> DMatrix<f64> {
    let half = p * f;
    -(&half + half.transpose())
}

/// (9), decided for these numbers.
fn theorem(plant: &StateSpace, l: &DMatrix<f64>, p: &DMatrix<f64>, rate: f64) -> Result<Certificate, DesignError> {
    Ok(Certificate::of([certificate::LinearConvergence {
        plant: PlantWithin::exactly(&proof_matrix(&plant.a), &proof_matrix(&plant.b), &proof_matrix(&plant.c))?,
        l: proof_matrix(l),
        p: proof_matrix(p),
        rate,
    }])?)
}
