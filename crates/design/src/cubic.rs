//! The cubic observer (5): a certified linear observer and a gain N that preserves stability.
//!
//! `P N C + C'N'P <= 0` (13') holds iff `N = -P^-1 C'S` with `S + S' >= 0` (C of full row rank), and with (12) it gives
//! global exponential stability: `V = e'Pe` obeys `V' <= -e'Qe`. The paper's (14) is `S = gamma theta`.

use luenberger_linalg::{RealMatrixView, symmetric_part};
use luenberger_lmi::proof_matrix;
use luenberger_observers::CubicObserver;
use luenberger_proof::certificate::{self, Certificate, Region, Theorem};
use nalgebra::{DMatrix, Dyn};

use crate::certificate::{certified, plant};
use crate::check;
use crate::error::DesignError;
use crate::linear::LinearDesign;

/// The choice of S in `N = -P^-1 C'S`.
#[derive(Debug, Clone, PartialEq)]
pub enum CubicGain {
    /// `S = gamma theta`, eq. (14), gamma > 0: the error flow is a contraction in the P norm.
    Gamma(f64),
    /// `S = w (C P^-1 C')^-1`, w > 0: then `C N = -w I`, and the cubic flow is elementary for every p.
    Radial(f64),
    /// Any p x p matrix with `S + S' >= 0`.
    General(DMatrix<f64>),
}

certified!(CubicDesign);

/// A cubic observer with its certificate.
#[readonly::make]
#[derive(Debug, Clone)]
pub struct CubicDesign {
    /// The observer (5), ready to run.
    pub observer: CubicObserver<f64, Dyn, Dyn, Dyn>,
    /// `P > 0` of (9).
    pub p: DMatrix<f64>,
    /// `Q = -(F'P + PF) > 0` of (9).
    pub q: DMatrix<f64>,
    /// S of `N = -P^-1 C'S`.
    pub s: DMatrix<f64>,
    /// The certified decay rate: that of the linear design.
    pub rate: f64,
    /// The certificate: convergence with all gains exactly as stored, from every error or from those of an ellipsoid;
    /// if neither is proved, the theorem for the real gain `N = -P^-1 C'S`.
    pub certificate: Certificate,
}

impl CubicDesign {
    /// The cubic observer on top of `linear`, with weight theta (p x p, symmetric, positive semidefinite) and
    /// `N = -P^-1 C'S`.
    ///
    /// Theorem 2 of the paper in its general form. Always exists. Cost: one Cholesky factorisation, `n^3 / 3`, and the
    /// proof, which takes over what is proved of `linear`.
    ///
    /// ```
    /// use luenberger_design::{CubicGain, CubicDesign, LyapunovWeight, LinearDesign};
    /// use nalgebra::dmatrix;
    ///
    /// let plant = luenberger_plants::double_integrator().to_dynamic();
    /// let linear = LinearDesign::with_poles_and_weight(&plant, &[-2.0, -5.0], LyapunovWeight::Identity(10.0))?;
    /// let cubic = CubicDesign::new(&linear, &dmatrix![10.0], &CubicGain::Gamma(2.0))?;
    /// assert!((cubic.observer.n[(1, 0)] + 11.5294).abs() < 1e-4);
    /// assert!(cubic.certificate.is_proved());
    /// # Ok::<(), luenberger_design::DesignError>(())
    /// ```
    ///
    /// # Errors
    /// [`LinalgError::NotPositiveSemidefinite`](luenberger_linalg::LinalgError::NotPositiveSemidefinite) for theta or
    /// `S + S'`, [`DesignError::NotPositive`] for gamma or w, [`DesignError::DependentOutputs`] when the radial choice
    /// does not exist.
    pub fn new<'a>(
        linear: &LinearDesign,
        theta: impl Into<RealMatrixView<'a>>,
        cubic_gain: &CubicGain,
    ) -> Result<Self, DesignError> {
        Self::of(linear, &check::owned(theta), cubic_gain)
    }

    fn of(linear: &LinearDesign, theta: &DMatrix<f64>, cubic_gain: &CubicGain) -> Result<Self, DesignError> {
        let o = &linear.observer;
        let outputs = o.c.nrows();
        let theta = &check::positive_semidefinite("theta", theta, outputs)?;
        let p_inverse_ct = check::solve_definite("P", &linear.p, &o.c.transpose())?;
        let s = structure(cubic_gain, theta, (&o.c, &p_inverse_ct))?;
        let n = -(p_inverse_ct * &s);
        let certificate = theorem((&o.a, &o.b, &o.c), (&o.l, &n, theta), (&linear.p, &s), linear.rate);
        let certificate = certificate.certify_knowing(&linear.certificate)?;
        let observer = CubicObserver::of(o.plant(), o.l.clone(), n, theta.clone())?;
        Ok(Self { observer, p: linear.p.clone(), q: linear.q.clone(), s, rate: linear.rate, certificate })
    }

    /// The theorem for the stored gains, with the region for which it is proved; if there is none, the claim of global
    /// convergence.
    pub(crate) fn theorem(&self) -> certificate::CubicConvergence {
        for proved in self.certificate.theorems() {
            if let Theorem::CubicConvergence(theorem) = proved.theorem() {
                return theorem.clone();
            }
        }
        let o = &self.observer;
        theorem((&o.a, &o.b, &o.c), (&o.l, &o.n, &o.theta), (&self.p, &self.s), self.rate)
    }

    /// The observer gain L, n x p.
    pub fn l(&self) -> &DMatrix<f64> {
        self.observer.l()
    }

    /// `F = A - L C`.
    pub fn error_matrix(&self) -> DMatrix<f64> {
        &self.observer.a - self.l() * &self.observer.c
    }
}

/// The claim that the cubic observer with these gains converges globally.
pub(crate) fn theorem(
    abc: (&DMatrix<f64>, &DMatrix<f64>, &DMatrix<f64>),
    (l, n, theta): (&DMatrix<f64>, &DMatrix<f64>, &DMatrix<f64>),
    (p, s): (&DMatrix<f64>, &DMatrix<f64>),
    rate: f64,
) -> certificate::CubicConvergence {
    certificate::CubicConvergence {
        plant: plant(abc),
        l: proof_matrix(l),
        n: proof_matrix(n),
        theta: proof_matrix(theta),
        p: proof_matrix(p),
        s: proof_matrix(s),
        rate,
        region: Region::Everywhere,
    }
}

/// S of `N = -P^-1 C'S`.
pub(crate) fn structure(
    cubic_gain: &CubicGain,
    theta: &DMatrix<f64>,
    (c, p_inverse_ct): (&DMatrix<f64>, &DMatrix<f64>),
) -> Result<DMatrix<f64>, DesignError> {
    let outputs = c.nrows();
    Ok(match cubic_gain {
        CubicGain::Gamma(gamma) => {
            check::positive("gamma", *gamma)?;
            theta * *gamma
        }
        CubicGain::Radial(w) => {
            check::positive("w", *w)?;
            check::independent_outputs(c)?;
            radial_s(c, p_inverse_ct, *w)?
        }
        CubicGain::General(s) => {
            check::matrix("S", s, (outputs, outputs))?;
            check::positive_semidefinite("S + S'", &(s + s.transpose()), outputs)?;
            s.clone()
        }
    })
}

/// `w (C P^-1 C')^-1`, the S of the radial choice; with w = 1 the largest X with `|Ce|_X^2 <= |e|_P^2`.
pub(crate) fn radial_s(c: &DMatrix<f64>, p_inverse_ct: &DMatrix<f64>, w: f64) -> Result<DMatrix<f64>, DesignError> {
    let gram = c * p_inverse_ct;
    let outputs = c.nrows();
    check::solve_definite("C P^-1 C'", &symmetric_part(&gram), &(DMatrix::identity(outputs, outputs) * w))
}
