//! A design on its target: gains as stored in f32 or fixed point, and the remaining error of the target's arithmetic.
//!
//! The theory is in `docs/theory-deployed.md` and `docs/proofs.md`. Only the choice of P is made here: a Lyapunov
//! matrix with the fastest decrease gives a good contraction, a well-conditioned one a round ball.

use luenberger_linalg::{RealMatrixView, spectral_radius, stein};
use luenberger_lmi::proof_matrix;
use luenberger_plants::StateSpace;
use luenberger_proof::certificate::{Certificate, CertificateFile, ClaimedBall, DeployedObserver};
use luenberger_proof::statement::{self, CubicGains, Deployed, Formats, Operation, SampledPlant, Step};
use nalgebra::DMatrix;

use crate::certificate::certified;
use crate::check;
use crate::error::DesignError;
use crate::sampled::SampledCubicDesign;

certified!(DeployedLinear);

/// A deployed linear observer and the P that proves it.
#[readonly::make]
#[derive(Debug, Clone)]
pub struct DeployedLinear {
    /// The Lyapunov matrix, of the stored error matrix F where that is stable.
    pub p: DMatrix<f64>,
    /// The numbers stored, the verdicts, and the ball of the running error.
    pub deployed: Deployed,
    /// The certificate: convergence with the stored numbers, and the ball of the running error if there is one.
    pub certificate: Certificate,
}

/// The observer of the sampled plant `x+ = A x + B u`, `y = C x` with gain `l` (n x p), stored and run in `formats`.
///
/// For a plant with a feedthrough D the measurement of the analysed step is `y - D u`: the target subtracts `D u`
/// first, and the rounding of that must be included in the bounds of the measurement noise.
///
/// Tries a few Lyapunov matrices of the *stored* error matrix and returns the proof with the smallest ball: the
/// solutions of `F'PF - s^2 P + s^2 Q = 0`, which contract at least by s, for s between the spectral radius of F and 1,
/// in the units of the promised bounds of the state. Where the stored F is not stable, the P of the gain before
/// rounding is judged, and refuted.
///
/// ```
/// use luenberger_design::deployed_linear;
/// use luenberger_proof::statement::{Format, Operation, Step};
/// use nalgebra::dmatrix;
///
/// // A double integrator every 10 ms, estimated in f32; |position| <= 1 m, |velocity| <= 2 m/s.
/// let h = 0.01;
/// let (a, b) = (dmatrix![1.0, h; 0.0, 1.0], dmatrix![h * h / 2.0; h]);
/// let plant = luenberger_plants::StateSpace::new(a, b, dmatrix![1.0, 0.0])?;
/// let (state, error) = (vec![1.0, 2.0], vec![1.0, 2.0]);
/// let meets = Operation { state, input: vec![5.0], noise: vec![0.0], error, deviation: None };
/// let found = deployed_linear(&plant, &dmatrix![0.3; 2.0], Step::Innovation, Format::Binary32.into(), &meets)?;
/// let ball = found.deployed.ball().expect("proved");
/// println!("the error settles within {:?}", ball.entries);
/// assert!(ball.entries[0] < 1e-5 && ball.entries[1] < 1e-4);
/// # Ok::<(), luenberger_design::DesignError>(())
/// ```
/// # Errors
/// [`DesignError::Proof`]: shapes that do not fit, entries that are not finite or that the format cannot store, bounds
/// that are negative. [`DesignError::Matrix`] for the plant.
pub fn deployed_linear<'a>(
    plant: &StateSpace,
    l: impl Into<RealMatrixView<'a>>,
    step: Step,
    formats: Formats,
    operation: &Operation,
) -> Result<DeployedLinear, DesignError> {
    linear(plant, &check::owned(l), step, formats, operation)
}

fn linear(
    plant: &StateSpace,
    l: &DMatrix<f64>,
    step: Step,
    formats: Formats,
    operation: &Operation,
) -> Result<DeployedLinear, DesignError> {
    check::plant(plant)?;
    let n = plant.a.nrows();
    let gain = proof_matrix(l);
    let real = sampled_plant(plant);
    let judge = |p: DMatrix<f64>| -> Result<(DMatrix<f64>, Deployed), DesignError> {
        let deployed = statement::deployed_linear(&real, &gain, &proof_matrix(&p), step, formats, operation)?;
        Ok((p, deployed))
    };
    let finish = |(p, deployed): (DMatrix<f64>, Deployed)| -> Result<DeployedLinear, DesignError> {
        let theorem = DeployedObserver {
            plant: real.clone(),
            stored: deployed.stored.clone(),
            step,
            formats,
            operation: operation.clone(),
            p: proof_matrix(&p),
            ball: deployed.ball().map(ClaimedBall::from),
        };
        Ok(DeployedLinear { p, deployed, certificate: Certificate::of([theorem])? })
    };
    let mut best = judge(DMatrix::identity(n, n))?;
    let from_proof = |m: &luenberger_proof::Matrix<f64>| DMatrix::from_row_slice(m.rows(), m.cols(), m.as_slice());
    let stored = &best.1.stored;
    let f = match step {
        Step::Joined => from_proof(&stored.a),
        Step::Innovation | Step::Accumulated => from_proof(&stored.a) - from_proof(&stored.l) * from_proof(&stored.c),
    };
    let radius = spectral_radius(&f)?;
    if radius.is_nan() || radius >= 1.0 {
        let designed = stein(&(&plant.a - l * &plant.c), &DMatrix::identity(n, n));
        return match designed {
            Ok(found) => finish(judge(found.p)?),
            Err(_) => finish(best),
        };
    }
    let weight = DMatrix::from_fn(n, n, |i, j| {
        let bound = operation.state.get(i).copied().unwrap_or(0.0);
        let unit = 1.0 / (bound * bound);
        if i != j {
            0.0
        } else if unit.is_normal() {
            unit
        } else {
            1.0
        }
    });
    for share in [1.0, 0.5, 0.2, 0.05] {
        let s = radius + share * (1.0 - radius);
        // The solution may overflow where F is far from normal: another s serves.
        let Ok(found) = stein(&(&f / s), &weight) else { continue };
        let tried = judge(found.p)?;
        if is_better(&tried.1, &best.1) {
            best = tried;
        }
    }
    finish(best)
}

/// A ball before none, then the smaller one; where there is none, stability before none.
fn is_better(one: &Deployed, other: &Deployed) -> bool {
    match (one.ball(), other.ball()) {
        (Some(one), Some(other)) => {
            let ratio: f64 = one.entries.iter().zip(&other.entries).map(|(x, y)| x.ln() - y.ln()).sum();
            ratio < 0.0
        }
        (None, None) => one.is_stable() && !other.is_stable(),
        (one, _) => one.is_some(),
    }
}

fn sampled_plant(plant: &StateSpace) -> SampledPlant {
    SampledPlant { a: proof_matrix(&plant.a), b: proof_matrix(&plant.b), c: proof_matrix(&plant.c) }
}

impl SampledCubicDesign {
    pub(crate) fn sampled_plant(&self) -> SampledPlant {
        let o = &self.observer;
        SampledPlant { a: proof_matrix(o.ad()), b: proof_matrix(o.bd()), c: proof_matrix(o.c()) }
    }

    /// Analysis of this observer, stored and run in `formats`: no structure of N is needed. With
    /// a feedthrough its measurement is `y - D u`, as for [`deployed_linear`].
    ///
    /// The design's own P proves it, since N was made for that P.
    ///
    /// ```
    /// use luenberger_design::{LyapunovWeight, LinearDesign, SampledCubicDesign};
    /// use luenberger_proof::statement::{Format, Operation};
    /// use nalgebra::dmatrix;
    ///
    /// let plant = luenberger_plants::double_integrator().to_dynamic();
    /// let linear = LinearDesign::with_poles_and_weight(&plant, &[-2.0, -5.0], LyapunovWeight::Identity(10.0))?;
    /// let design = SampledCubicDesign::new(&linear, &dmatrix![1.0], 10.0, 0.1)?;
    /// let (state, error) = (vec![1.0, 2.0], vec![100.0, 100.0]);
    /// let meets = Operation { state, input: vec![5.0], noise: vec![0.0], error, deviation: None };
    /// let deployed = design.deployed(Format::Binary32.into(), &meets)?;
    /// assert!(deployed.is_stable(), "as stored in f32, from every error");
    /// assert!(deployed.ball().expect("proved").entries[0] < 1e-5);
    /// # Ok::<(), luenberger_design::DesignError>(())
    /// ```
    /// # Errors
    /// [`DesignError::Proof`]: numbers that the format cannot store, bounds of the wrong length or negative;
    /// [`DesignError::SemiImplicit`] for a gain that is not radial.
    pub fn deployed(&self, formats: Formats, operation: &Operation) -> Result<Deployed, DesignError> {
        let o = &self.observer;
        if o.coupling().is_some() {
            return Err(DesignError::SemiImplicit);
        }
        let real = self.sampled_plant();
        let gains = CubicGains {
            n: proof_matrix(o.n()),
            theta: proof_matrix(o.theta()),
            w: o.w(),
            h: luenberger_observers::SampledObserver::period(o),
        };
        Ok(statement::deployed_sampled_cubic(
            &real,
            &proof_matrix(o.ld()),
            &gains,
            &proof_matrix(&self.p),
            formats,
            operation,
        )?)
    }

    /// The certificate file of this observer stored and run in `formats`, as [`deployed`](Self::deployed) proves it:
    /// with the ball of the running error where there is one.
    ///
    /// ```
    /// use luenberger_design::{LyapunovWeight, LinearDesign, SampledCubicDesign};
    /// use luenberger_proof::certificate::verify;
    /// use luenberger_proof::statement::{Format, Operation};
    /// use nalgebra::dmatrix;
    ///
    /// let plant = luenberger_plants::double_integrator().to_dynamic();
    /// let linear = LinearDesign::with_poles_and_weight(&plant, &[-2.0, -5.0], LyapunovWeight::Identity(10.0))?;
    /// let design = SampledCubicDesign::new(&linear, &dmatrix![1.0], 10.0, 0.1)?;
    /// let (state, error) = (vec![1.0, 2.0], vec![10.0, 10.0]);
    /// let meets = Operation { state, input: vec![5.0], noise: vec![0.0], error, deviation: None };
    /// let file = design.deployed_certificate_file("in f32", Format::Binary32.into(), &meets)?.to_json();
    /// assert!(verify(file.as_bytes())?.statement.contains("stored in binary32"));
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    /// # Errors
    /// [`DesignError::CertificateFile`] names the inequality that is not proved; those of [`deployed`](Self::deployed).
    pub fn deployed_certificate_file(
        &self,
        title: &str,
        formats: Formats,
        operation: &Operation,
    ) -> Result<CertificateFile, DesignError> {
        Ok(self.deployed_certificate(formats, operation)?.file(title)?)
    }

    /// The certificate of [`deployed_certificate_file`](Self::deployed_certificate_file).
    ///
    /// # Errors
    /// Those of [`deployed`](Self::deployed).
    pub fn deployed_certificate(&self, formats: Formats, operation: &Operation) -> Result<Certificate, DesignError> {
        let deployed = self.deployed(formats, operation)?;
        let theorem = DeployedObserver {
            plant: self.sampled_plant(),
            ball: deployed.ball().map(ClaimedBall::from),
            stored: deployed.stored,
            step: Step::Innovation,
            formats,
            operation: operation.clone(),
            p: proof_matrix(&self.p),
        };
        Ok(Certificate::of([theorem])?)
    }
}
