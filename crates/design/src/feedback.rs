//! Theorem 6 and Corollary 1: the observer in the feedback loop `u = -K xhat`.
//!
//! Given the P of a certified observer, the block inequality (25) has a solution `P1 > 0` iff `A - B K` is Hurwitz.
//! With `(A - BK)'P0 + P0(A - BK) = -I` and `P1 = mu P0` it reads, by the Schur complement, `Q - mu (P0BK)'(P0BK) > 0`,
//! which holds for `mu < lambda_min(Q) / |P0 B K|^2`. Hence Corollary 1 with (13') in place of (13): whenever the loop
//! with the linear observer is stable, so is the loop with the cubic one. The linear observer is the case `N = 0`.

use luenberger_linalg::{RealMatrixView, lambda_max, lambda_min};
use luenberger_lmi::proof_matrix;
use luenberger_proof::certificate::{Certificate, CubicConvergence, FeedbackLoop};
use nalgebra::{Complex, DMatrix};

use crate::certificate::certified;
use crate::check::{self, StableLoop};
use crate::cubic::{CubicDesign, theorem};
use crate::error::DesignError;
use crate::linear::LinearDesign;

certified!(FeedbackDesign);

/// A feedback loop `u = -K xhat` around a linear or a cubic observer, with its certificate.
#[readonly::make]
#[derive(Debug, Clone)]
pub struct FeedbackDesign {
    /// The feedback gain K, m x n.
    pub k: DMatrix<f64>,
    /// Eigenvalues of `A - B K`.
    pub poles: Vec<Complex<f64>>,
    /// `P1 > 0` of (25).
    pub p1: DMatrix<f64>,
    /// The certificate of the loop: the conditions of the observer with its gains as stored, and (25).
    pub certificate: Certificate,
}

impl FeedbackDesign {
    /// Certifies the loop with gain `k` (m x n, `u = -K xhat`) around a linear observer, whatever its gain came from.
    ///
    /// Exists iff `A - B K` is Hurwitz. The certificate is that of a cubic observer with N = 0 and theta = 0. Cost: one
    /// Lyapunov equation.
    ///
    /// ```
    /// use luenberger_design::{FeedbackDesign, LinearDesign};
    /// use luenberger_linalg::lqr;
    /// use nalgebra::{Matrix1, Matrix2, dmatrix};
    ///
    /// let plant = luenberger_plants::double_integrator().to_dynamic();
    /// let k = lqr(&plant.a, &plant.b, &Matrix2::identity(), &Matrix1::new(1.0))?.k;
    /// let filter = LinearDesign::kalman(&plant, &Matrix2::identity(), &Matrix1::new(0.01))?;
    /// let feedback = FeedbackDesign::linear(&filter, &k)?;
    /// assert!(feedback.certificate.is_proved());
    /// # Ok::<(), luenberger_design::DesignError>(())
    /// ```
    ///
    /// # Errors
    /// As [`cubic`](Self::cubic).
    pub fn linear<'a>(observer: &LinearDesign, k: impl Into<RealMatrixView<'a>>) -> Result<Self, DesignError> {
        let o = &observer.observer;
        let (n, p) = o.l.shape();
        let (gain, weight) = (DMatrix::zeros(n, p), DMatrix::zeros(p, p));
        let zero = theorem((&o.a, &o.b, &o.c), (&o.l, &gain, &weight), (&observer.p, &weight), observer.rate);
        Self::around(zero, (&o.a, &o.b), &observer.q, &check::owned(k))
    }

    /// Certifies the loop with gain `k` (m x n, `u = -K xhat`) around a cubic observer.
    ///
    /// Exists iff `A - B K` is Hurwitz. Then `V = x'P1x + e'Pe` decreases along every solution of the loop: the origin
    /// is globally asymptotically stable. Cost: one Lyapunov equation.
    ///
    /// ```
    /// use luenberger_design::{CubicGain, CubicDesign, LyapunovWeight, FeedbackDesign, LinearDesign};
    /// use nalgebra::dmatrix;
    ///
    /// let plant = luenberger_plants::double_integrator().to_dynamic();
    /// let linear = LinearDesign::with_poles_and_weight(&plant, &[-2.0, -5.0], LyapunovWeight::Identity(10.0))?;
    /// let cubic = CubicDesign::new(&linear, &dmatrix![10.0], &CubicGain::Gamma(2.0))?;
    /// let feedback = FeedbackDesign::cubic(&cubic, &dmatrix![1.0, 2.0])?;
    /// assert!(feedback.certificate.is_proved());
    /// # Ok::<(), luenberger_design::DesignError>(())
    /// ```
    ///
    /// # Errors
    /// [`DesignError::NotHurwitz`] when `A - B K` is not stable;
    /// [`PlantError::DimensionMismatch`](luenberger_plants::PlantError::DimensionMismatch) and
    /// [`PlantError::NotFinite`](luenberger_plants::PlantError::NotFinite) for K.
    pub fn cubic<'a>(observer: &CubicDesign, k: impl Into<RealMatrixView<'a>>) -> Result<Self, DesignError> {
        let o = &observer.observer;
        Self::around(observer.theorem(), (&o.a, &o.b), &observer.q, &check::owned(k))
    }

    fn around(
        observer: CubicConvergence,
        (a, b): (&DMatrix<f64>, &DMatrix<f64>),
        q: &DMatrix<f64>,
        k: &DMatrix<f64>,
    ) -> Result<Self, DesignError> {
        let (n, m) = b.shape();
        check::matrix("K", k, (m, n))?;
        let closed = StableLoop::new("A - B K", (a, b, k))?;
        let poles = closed.poles.clone();
        let p0 = closed.lyapunov(&DMatrix::identity(n, n))?;
        let coupling = &p0 * b * k;
        let coupling_squared = lambda_max(&(coupling.transpose() * &coupling))?;
        // Half of the largest admissible mu, so that (25) holds with room; any mu when x and e do not couple.
        let mu = if coupling_squared > 0.0 { 0.5 * lambda_min(q)? / coupling_squared } else { 1.0 };
        let p1 = p0 * mu;
        let theorem = FeedbackLoop { observer, k: proof_matrix(k), p1: proof_matrix(&p1) };
        let certificate = Certificate::of([theorem])?;
        Ok(Self { k: k.clone(), poles, p1, certificate })
    }
}
