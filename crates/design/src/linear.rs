//! The linear observer (2): from a wish to a gain L, with the Lyapunov matrix that certifies it.
//!
//! Every design ends with the same pair `P > 0`, `Q > 0` and `F'P + P F = -Q` for `F = A - L C` (9), so that whatever is built
//! on top (the cubic term, robust margins, feedback) does not care where L came from.

use luenberger_linalg::{Kalman, eigenvalues, kalman_gain, place_observer, symmetric_part};
use luenberger_lmi::Settings;
use luenberger_observers::LinearObserver;
use luenberger_plants::DynamicPlant;
use luenberger_proof::certificate::{self, Certificate, PlantWithin};
use nalgebra::{Complex, DMatrix, Dyn};

use crate::certificate::{certified, exact};
use crate::check::{self, StableLoop};
use crate::error::DesignError;
use crate::gain_lmi::{self, Gain};

/// What is wanted of the observer.
#[derive(Debug, Clone, PartialEq)]
pub enum Wish {
    /// The eigenvalues of `A - L C`, n numbers closed under conjugation, all in the open left half plane.
    Poles(Vec<Complex<f64>>),
    /// The stationary Kalman gain `L = Sigma C'V^-1` for process noise of intensity W (n x n) and measurement noise V (p x p).
    Kalman {
        /// Intensity of the process noise, n x n, positive semidefinite.
        w: DMatrix<f64>,
        /// Intensity of the measurement noise, p x p, positive definite.
        v: DMatrix<f64>,
    },
    /// Every error decays at least like `exp(-rate t)`, by the matrix inequality with the largest margin.
    DecayRate(f64),
    /// The LMI decides: the largest margin of `A'P + PA - YC - C'Y' < 0` over normalised (P, Y).
    Lmi,
    /// A gain L of one's own, n x p.
    Gain(DMatrix<f64>),
}

impl Wish {
    /// Real poles.
    pub fn poles(poles: &[f64]) -> Self {
        Self::Poles(poles.iter().map(|&re| Complex::new(re, 0.0)).collect())
    }
}

/// The right-hand side of the Lyapunov equation that certifies a given gain.
///
/// Designs by LMI ([`Wish::DecayRate`], [`Wish::Lmi`]) bring their own P, and Q follows from it.
#[derive(Debug, Clone, PartialEq)]
pub enum Decrease {
    /// `Q = rho I`, for which the theorems on the infinite-horizon cost hold.
    Scaled(f64),
    /// Any `Q = Q' > 0`, n x n.
    Matrix(DMatrix<f64>),
    /// Only with [`Wish::Kalman`]: P is the information matrix, the inverse of the stationary covariance, and
    /// `Q = P W P + C'V^-1 C`, which must be positive definite. Then `S = alpha V^-1` gives `N = -alpha L`.
    Information,
}

impl Default for Decrease {
    fn default() -> Self {
        Self::Scaled(1.0)
    }
}

impl Decrease {
    fn matrix(&self, n: usize) -> Result<DMatrix<f64>, DesignError> {
        match self {
            Self::Scaled(rho) => {
                check::positive("rho, the factor of the identity in Decrease::Scaled,", *rho)?;
                Ok(DMatrix::identity(n, n) * *rho)
            }
            Self::Matrix(q) => check::positive_definite("Q", q, n),
            Self::Information => Err(DesignError::NoCovariance),
        }
    }
}

certified!(LinearDesign);

/// A linear observer with its evidence.
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
    /// The decay rate that the certificate states, 0 unless [`Wish::DecayRate`] or an inequality with a rate asked for one.
    pub rate: f64,
    /// What is proved of it.
    pub certificate: Certificate,
}

impl LinearDesign {
    /// The observer that `wish` asks for, certified by `F'P + PF = -Q` with Q from `decrease`.
    ///
    /// [`Wish::Lmi`] exists whenever `(A, C)` is detectable. The others can ask for more: [`Wish::Poles`] and [`Wish::DecayRate`] than the
    /// unobservable modes allow, [`Wish::Kalman`] needs noise on every mode of the stability boundary, and a gain of one's own has to stabilise.
    /// The wishes by LMI do not read `decrease`: they bring their own P. Cost: that of the gain, and one Schur form of
    /// F, from which its poles and P come, about `35 n^3`; an SDP of `n(n+1)/2 + np` unknowns for the wishes by LMI.
    ///
    /// ```
    /// use luenberger_design::{Decrease, LinearDesign, Wish};
    ///
    /// let plant = luenberger_plants::double_integrator().to_dynamic();
    /// let design = LinearDesign::new(&plant, &Wish::poles(&[-2.0, -5.0]), &Decrease::Scaled(10.0))?;
    /// assert!((design.observer.l[(1, 0)] - 10.0).abs() < 1e-12);
    /// let f = &plant.a - &design.observer.l * &plant.c;
    /// let residual = f.transpose() * &design.p + &design.p * f + &design.q;
    /// assert!(residual.norm() < 1e-13 * design.p.norm());
    /// assert!(design.certificate.is_proved());
    /// # Ok::<(), luenberger_design::DesignError>(())
    /// ```
    ///
    /// # Errors
    /// [`DesignError::UnstablePole`] for a pole not in the open left half plane; [`DesignError::Linalg`] names the mode that no gain
    /// can move; [`DesignError::NotHurwitz`] for a gain of one's own that does not stabilise; [`LinalgError::NotPositiveDefinite`](luenberger_linalg::LinalgError::NotPositiveDefinite)
    /// and its kin for Q, W, V; [`DesignError::Infeasible`] with verified multipliers when no gain reaches the decay rate.
    pub fn new(plant: &DynamicPlant, wish: &Wish, decrease: &Decrease) -> Result<Self, DesignError> {
        Self::new_with(plant, wish, decrease, &Settings::default())
    }

    /// [`new`](Self::new), the wishes by LMI granted by the solver of `settings`.
    ///
    /// # Errors
    /// As [`new`](Self::new); [`LmiError::NotBuiltIn`](luenberger_lmi::LmiError::NotBuiltIn) in [`DesignError::Lmi`].
    pub fn new_with(
        plant: &DynamicPlant,
        wish: &Wish,
        decrease: &Decrease,
        settings: &Settings,
    ) -> Result<Self, DesignError> {
        check::plant(plant)?;
        let (n, p) = (plant.a.nrows(), plant.c.nrows());
        let l = match wish {
            Wish::Poles(poles) => {
                if let Some(&pole) = poles.iter().find(|pole| pole.re >= 0.0) {
                    return Err(DesignError::UnstablePole { pole });
                }
                place_observer(&plant.a, &plant.c, poles)?.gain
            }
            Wish::Kalman { w, v } => {
                let w = check::positive_semidefinite("W", w, n)?;
                let v = check::positive_definite("V", v, p)?;
                let kalman = kalman_gain(&plant.a, &plant.c, &w, &v)?;
                if *decrease == Decrease::Information {
                    return Self::with_information(plant, &kalman);
                }
                kalman.l
            }
            Wish::Gain(l) => {
                check::matrix("L", l, (n, p))?;
                l.clone()
            }
            Wish::DecayRate(rate) => {
                check::positive("decay rate", *rate)?;
                return Self::with_lyapunov_matrix(plant, gain_lmi::gain_by_lmi(plant, *rate, settings)?, *rate);
            }
            Wish::Lmi => {
                return Self::with_lyapunov_matrix(plant, gain_lmi::gain_by_lmi(plant, 0.0, settings)?, 0.0);
            }
        };
        let closed = StableLoop::new("A - L C", (&plant.a, &l, &plant.c))?;
        if *decrease == Decrease::Information {
            return Err(DesignError::NoCovariance);
        }
        let q = decrease.matrix(n)?;
        let poles = closed.poles.clone();
        Self::certified(plant, l, poles, (closed.lyapunov(&q)?, q), 0.0)
    }

    /// The Kalman gain with the inverse covariance as P.
    fn with_information(plant: &DynamicPlant, kalman: &Kalman) -> Result<Self, DesignError> {
        let n = plant.a.nrows();
        let inverse = check::solve_definite("the stationary covariance", &kalman.p, &DMatrix::identity(n, n))?;
        let p = symmetric_part(&inverse);
        let f = &plant.a - &kalman.l * &plant.c;
        let half = &p * &f;
        let q = -(&half + half.transpose());
        check::positive_definite("Q = P W P + C'V^-1 C", &q, n)?;
        Self::certified(plant, kalman.l.clone(), eigenvalues(&f)?, (p, q), 0.0)
    }

    /// A design whose P came with the gain, and certifies the decay rate.
    pub(crate) fn with_lyapunov_matrix(plant: &DynamicPlant, gain: Gain, rate: f64) -> Result<Self, DesignError> {
        let Gain { l, p } = gain;
        let f = &plant.a - &l * &plant.c;
        let half = &p * &f;
        let q = -(&half + half.transpose());
        Self::certified(plant, l, eigenvalues(&f)?, (p, q), rate)
    }

    fn certified(
        plant: &DynamicPlant,
        l: DMatrix<f64>,
        poles: Vec<Complex<f64>>,
        (p, q): (DMatrix<f64>, DMatrix<f64>),
        rate: f64,
    ) -> Result<Self, DesignError> {
        let theorem = certificate::LinearObserver {
            plant: PlantWithin::exactly(&exact(&plant.a)?, &exact(&plant.b)?, &exact(&plant.c)?)?,
            l: exact(&l)?,
            p: exact(&p)?,
            rate,
        };
        let certificate = Certificate::of([theorem])?;
        let observer = LinearObserver::of(plant.clone(), l)?;
        Ok(Self { observer, poles, p, q, rate, certificate })
    }

    /// The largest real part of an eigenvalue of `F = A - L C`: in the end errors decay like `exp` of this times t.
    pub fn spectral_abscissa(&self) -> f64 {
        self.poles.iter().map(|pole| pole.re).fold(f64::NEG_INFINITY, f64::max)
    }

    /// `F = A - L C`.
    pub fn error_matrix(&self) -> DMatrix<f64> {
        &self.observer.a - &self.observer.l * &self.observer.c
    }
}
