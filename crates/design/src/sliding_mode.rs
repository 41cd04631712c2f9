//! Gains of sliding-mode observers, and the certificate of the super-twisting one.
//!
//! A chain of n integrators, `|d| <= D` in the last: see `luenberger_observers::sliding_mode`. The gains scale as `k_i
//! = c_i D^(i/n)`. For n = 2 the theorem is at the head of `proof/src/certificate/theorem/super_twisting.rs`; its P is
//! computed for D = 1 and scaled: with `e1 = D e1'`, `e2 = D e2'` the matrix is `[D^1.5 p11, D p12; *, D^0.5 p22]`, and
//! alpha is `D^0.5` times that for D = 1.
//!
//! The inequality can be satisfied iff the gain of `1/(2 s^2 + k1 s + k2)` is below 1/D at all frequencies (bounded
//! real lemma), for `k1 >= 2 sqrt(k2)` iff `k2 > D`. The gains 1.5 and 1.1 that are usual for simulations, from which
//! Levant shows convergence by other means, miss that by 4 %; the default has 2.1 in place of 1.5.

use luenberger_lmi::{Problem, block, he, proof_matrix, trace};
use luenberger_observers::sliding_mode::levant_gains;
use luenberger_proof::certificate::{Certificate, SuperTwistingConvergence};
use nalgebra::{DMatrix, Dyn, dmatrix};

use crate::certificate::certified;
use crate::check;
use crate::error::DesignError;

/// The largest order: with the gains of Levant for 6 states the implicit step does not always end its switching.
pub const LARGEST_ORDER: usize = 5;

/// The gains for a chain of `order` integrators and the bound D: 1.1 D for n = 1, `2.1 D^(1/2), 1.1 D` for n = 2, which
/// are certified, and those of Levant above.
///
/// ```
/// use luenberger_design::sliding_mode_gains;
/// assert_eq!(sliding_mode_gains(2, 4.0)?, [4.2, 4.4]);
/// // Levant's third order: 2, 1.5 2^(1/2), 1.1 for D = 1.
/// let third = sliding_mode_gains(3, 1.0)?;
/// assert!((third[1] - 2.1213203435596424).abs() < 1e-12 && third[2] == 1.1);
/// # Ok::<(), luenberger_design::DesignError>(())
/// ```
/// # Errors
/// [`DesignError::NotPositive`] for D, [`DesignError::SlidingOrder`] for orders above 5.
pub fn sliding_mode_gains(order: usize, bound: f64) -> Result<Vec<f64>, DesignError> {
    check::positive("the bound of the disturbance", bound)?;
    if order == 2 {
        return Ok(vec![2.1 * bound.sqrt(), 1.1 * bound]);
    }
    let gains = if order <= LARGEST_ORDER { levant_gains::<f64, Dyn>(Dyn(order), bound) } else { None };
    let gains = gains.ok_or(DesignError::SlidingOrder { order })?;
    Ok(gains.as_slice().to_vec())
}

certified!(SuperTwistingDesign);

/// The convergence of a super-twisting observer in continuous time, with its certificate.
#[readonly::make]
#[derive(Debug, Clone, PartialEq)]
pub struct SuperTwistingDesign {
    /// P of `V = z'Pz`, `z = (|e1|^(1/2) sign(e1), e2)`, 2 x 2.
    pub p: DMatrix<f64>,
    /// alpha of `V' <= -(alpha/c) V^(1/2)`.
    pub alpha: f64,
    /// c of the same inequality.
    pub c: f64,
    /// The certificate.
    pub certificate: Certificate,
}

impl SuperTwistingDesign {
    /// P, alpha and c for the gains k1, k2 and `|F| <= bound`; `None` if no solution of the inequality is found.
    ///
    /// ```
    /// use luenberger_design::{Certified, SuperTwistingDesign};
    /// let design = SuperTwistingDesign::new([2.1, 1.1], 1.0)?.ok_or("no certificate")?;
    /// assert!(design.certificate.is_proved());
    /// // Without a disturbance the exact time from (0, 1) is (1 + q)/((1 - q) k2), which the bound is not below.
    /// assert!(design.reaching_time(0.0, 1.0) > 1.0 / 1.1);
    /// // k2 below the bound.
    /// assert!(SuperTwistingDesign::new([2.1, 0.9], 1.0)?.is_none());
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    /// # Errors
    /// [`DesignError::NotPositive`] for gains and bound.
    pub fn new([k1, k2]: [f64; 2], bound: f64) -> Result<Option<Self>, DesignError> {
        check::positive("k1", k1)?;
        check::positive("k2", k2)?;
        check::positive("the bound of the disturbance", bound)?;
        let (unit1, unit2) = (k1 / bound.sqrt(), k2 / bound);
        if k2 <= bound {
            return Ok(None);
        }
        let mut best: Option<(f64, DMatrix<f64>, f64, f64)> = None;
        for share in [0.005, 0.02, 0.05, 0.1, 0.2, 0.35, 0.5, 0.65, 0.8] {
            let alpha = 0.5 * share * unit1;
            let Some(p) = lyapunov(unit1, unit2, alpha)? else { continue };
            let Some(inverse) = p.clone().try_inverse() else { continue };
            let c = inverse[(0, 0)].sqrt();
            let time = c / alpha * p[(1, 1)].sqrt();
            if best.as_ref().is_none_or(|(least, ..)| time < *least) {
                best = Some((time, p, alpha, c));
            }
        }
        let Some((_, unit, alpha, c)) = best else { return Ok(None) };
        let root = bound.sqrt();
        let off = bound * unit[(0, 1)];
        let p = dmatrix![bound * root * unit[(0, 0)], off; off, root * unit[(1, 1)]];
        // |z1| is D^(1/2) times that for D = 1, V is D^2.5 times.
        let (alpha, c) = (alpha * root, c * (1.0 + 1e-9) / bound.powf(0.75));
        let theorem = SuperTwistingConvergence { k1, k2, bound, p: proof_matrix(&p), alpha, c };
        let certificate = Certificate::of([theorem])?;
        if !certificate.is_proved() {
            return Ok(None);
        }
        Ok(Some(Self { p, alpha, c, certificate }))
    }

    /// The proved bound of the reaching time in continuous time from an error.
    pub fn reaching_time(&self, e1: f64, e2: f64) -> f64 {
        let z = nalgebra::dvector![e1.abs().sqrt().copysign(e1), e2];
        2.0 * self.c / self.alpha * z.dot(&(&self.p * &z)).max(0.0).sqrt()
    }
}

/// P with the least trace for D = 1.
fn lyapunov(k1: f64, k2: f64, alpha: f64) -> Result<Option<DMatrix<f64>>, DesignError> {
    let a = dmatrix![-k1, 1.0; -2.0 * k2, 0.0];
    let (b, seen) = (dmatrix![0.0; 2.0], dmatrix![2.0, 0.0; 0.0, 0.0]);
    let mut lmi = Problem::new();
    let p = lmi.symmetric("P", 2);
    lmi.constrain("P > 0", &p >> 0.0);
    let corner = &p * &b;
    let flow = he(&p * &a) + (2.0 * alpha) * &p + luenberger_lmi::Expression::constant(seen);
    let last = luenberger_lmi::Expression::constant(dmatrix![-2.0]);
    lmi.constrain("decrease", block![[flow, corner.clone()], [corner.transpose(), last]] << 0.0);
    lmi.minimise(trace(&p));
    let solution = lmi.solve()?;
    Ok(solution.verdict.is_proved().then(|| luenberger_linalg::symmetric_part(&solution.value(&p))))
}

/// Exact reaching times in continuous time, of errors without noise: what simulations are compared with.
pub mod reaching_time {
    /// Of the first-order sliding mode `e' = d - k sign(e)` with a constant d, |d| < k, from e: `|e|/(k - d sign(e))`.
    pub fn first_order(e: f64, k: f64, d: f64) -> f64 {
        e.abs() / (k - d * e.signum())
    }

    /// Of the super-twisting error `e1' = e2 - k1 |e1|^(1/2) sign(e1)`, `e2' = -k2 sign(e1)` from (0, e2).
    ///
    /// On a half turn, `u = |e1|^(1/2)` in the time `ds = dt/u` obeys a linear equation with the eigenvalues `-k1/4 +-
    /// i w`, `w^2 = k2/2 - k1^2/16`: e2 is multiplied by -q, `q = exp(-pi k1/(4 w))`, while it changes at the rate k2.
    /// So the times are a geometric series, `|e2| (1 + q)/((1 - q) k2)`. For `k1^2 >= 8 k2` there is no turn, and q =
    /// 0.
    pub fn super_twisting(e2: f64, k1: f64, k2: f64) -> f64 {
        let square = k2 / 2.0 - k1 * k1 / 16.0;
        let q = if square > 0.0 { (-core::f64::consts::PI * k1 / (4.0 * square.sqrt())).exp() } else { 0.0 };
        e2.abs() * (1.0 + q) / ((1.0 - q) * k2)
    }
}
