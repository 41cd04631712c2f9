//! Reduced-order observers: of order n - p, since the outputs determine p combinations of the states.
//!
//! `x' = A x + B u`, `y = C x` with rank(C) = p: an observer of order n - p,
//! ```text
//! w' = F w + G y + H u,    xhat = M w + N y,    T A - F T = G C,    H = T B,    M T + N C = I
//! ```
//! with the eigenvalues of F as one likes iff (A, C) is observable (Luenberger 1964, Gopinath 1971;
//! [`luenberger_linalg::reduced_order_observer`]). Measurement noise reaches xhat through N without a filter.
//!
//! The certificate is about the stored T. The real matrices `N = (C'C + T'T)^-1 C'`, `M = (C'C + T'T)^-1 T'`, `F = TAM`
//! and
//! `G = TAN` satisfy the equations exactly, whatever T is: `proof/src/certificate/theorem/reduced_order.rs`.

use luenberger_linalg::{FunctionalObserver, eigenvalues, lyapunov, reduced_order_observer, symmetric_part};
use luenberger_lmi::proof_matrix;
use luenberger_plants::StateSpace;
use luenberger_proof::certificate::{Certificate, ReducedOrderConvergence};
use luenberger_proof::statement::TimeDomain;
use nalgebra::{Complex, DMatrix};

use crate::certificate::{certified, plant as matrices};
use crate::check;
use crate::error::DesignError;
use crate::lyapunov_choice::proved_or_first;

certified!(ReducedOrderDesign);

/// A reduced-order observer with its certificate.
#[readonly::make]
#[derive(Debug, Clone)]
pub struct ReducedOrderDesign {
    /// The plant.
    pub plant: StateSpace,
    /// T, F, G, H, M and N.
    pub observer: FunctionalObserver,
    /// Eigenvalues of F.
    pub poles: Vec<Complex<f64>>,
    /// P of `F'P + PF + I = 0`.
    pub p: DMatrix<f64>,
    /// The certificate.
    pub certificate: Certificate,
}

impl ReducedOrderDesign {
    /// The observer whose error has these poles, n - p of them in the open left half plane, closed under conjugation.
    ///
    /// A feedthrough D has no part in it: the observer takes y - D u for y. For a plant in discrete time use
    /// [`DiscreteDesign::reduced_order`](crate::DiscreteDesign::reduced_order).
    ///
    /// ```
    /// use luenberger_design::ReducedOrderDesign;
    /// let plant = luenberger_plants::double_integrator().to_dynamic();
    /// let design = ReducedOrderDesign::with_poles(&plant, &[-4.0])?;
    /// assert!((design.observer.f[(0, 0)] + 4.0).abs() < 1e-14 && design.certificate.is_proved());
    /// # Ok::<(), luenberger_design::DesignError>(())
    /// ```
    ///
    /// # Errors
    /// [`DesignError::UnstablePole`]; [`DesignError::Linalg`] names the mode that no output sees, or a number of poles
    /// that is not n - rank(C); [`DesignError::NothingUnmeasured`] where that is 0;
    /// [`DesignError::DependentOutputs`] where C has dependent rows.
    pub fn with_poles<Z: Into<Complex<f64>> + Copy>(plant: &StateSpace, poles: &[Z]) -> Result<Self, DesignError> {
        let poles: Vec<Complex<f64>> = poles.iter().map(|&pole| pole.into()).collect();
        if let Some(&pole) = poles.iter().find(|pole| pole.re >= 0.0) {
            return Err(DesignError::UnstablePole { pole });
        }
        check::something_unmeasured(plant)?;
        let observer = reduced_order_observer(&plant.a, &plant.b, &plant.c, &poles)?;
        let order = observer.f.nrows();
        let first = lyapunov(&observer.f, &DMatrix::identity(order, order));
        let first = first.map(|found| symmetric_part(&found.p)).map_err(DesignError::from);
        let (p, certificate) = proved_or_first(TimeDomain::Continuous, &observer.f, first, |p| {
            Ok(Certificate::of([ReducedOrderConvergence {
                plant: matrices((&plant.a, &plant.b, &plant.c)),
                t: proof_matrix(&observer.t),
                p: proof_matrix(p),
                rate: 0.0,
            }])?)
        })?;
        let poles = eigenvalues(&observer.f)?;
        Ok(Self { plant: plant.clone(), observer, poles, p, certificate })
    }
}
