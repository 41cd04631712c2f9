//! Attractivity of the manifold of an immersion-and-invariance observer: `d' = M d`, with M a mean of Jacobians that
//! are enclosed over a box. One P that proves every matrix of the enclosure Hurwitz proves that d decays exponentially.
//!
//! The mean value theorem needs a right-hand side that is continuous along the segment from phi(x) to phi(x) + d: its
//! jumps are searched for by values, as those of a plant are ([`enclosure`](crate::enclosure)), and where branches are
//! left open without a proof that they meet there is no theorem.

use luenberger_plants::Plant;
use luenberger_proof::certificate::{Certificate, Certified};
use luenberger_proof::{Interval, Matrix};
use nalgebra::{Complex, DMatrix};

use super::error::KklError;
use super::stability::{HurwitzAnalysis, hurwitz};
use crate::enclosure::{Branches, IntervalDual, Region, enclose};

/// The enclosed Jacobian, and what is proved of it.
#[derive(Debug, Clone, PartialEq)]
pub struct Attractivity {
    /// The Jacobian over the box.
    pub jacobian: Matrix<Interval>,
    /// Eigenvalues of its middle, the largest real part first.
    pub eigenvalues: Vec<Complex<f64>>,
    /// P; none where the middle is not Hurwitz.
    pub p: Option<DMatrix<f64>>,
    /// The branches between which a jump is not excluded. With them nothing is proved of d.
    pub jumps: Option<Branches>,
    /// That every matrix of the enclosure is Hurwitz, with one P; no theorem where there is no P.
    pub certificate: Certificate,
}

impl Certified for Attractivity {
    fn certificate(&self) -> &Certificate {
        &self.certificate
    }
}

impl Attractivity {
    /// Whether d decays exponentially: every matrix of the enclosure is proved Hurwitz, and there is no jump.
    pub fn is_proved(&self) -> bool {
        self.certificate.is_proved() && self.jumps.is_none()
    }
}

/// What is proved of d, for a plant `z' = K(phi^L(z, y))` whose states are z, and whose inputs are all that K reads
/// beside z. Its outputs are continuous too if there is no jump, with bounded derivatives by z.
///
/// `z' = -(1 + u^2) z` for u in [-1, 1]:
/// ```
/// use luenberger_design::Region;
/// use luenberger_design::kkl::attractivity;
/// use luenberger_plants::plant;
///
/// struct Distance;
/// plant!(Distance, (1, 1, 1), |plant, t, x, u| [-x[0] - x[0] * u[0] * u[0]], [x[0]]);
///
/// let found = attractivity(&Distance, &Region::new(&[(-2.0, 2.0)]).inputs(&[(-1.0, 1.0)]))?;
/// assert!(found.is_proved());
/// assert!(found.jacobian[(0, 0)].hi() < -0.9 && found.jacobian[(0, 0)].lo() > -2.01);
/// # Ok::<(), luenberger_design::KklError>(())
/// ```
/// # Errors
/// [`KklError::Enclosure`] names a jump, or an entry without bounds, and the place; those of the Lyapunov equation.
pub fn attractivity<S: Plant<IntervalDual>>(distance: &S, region: &Region) -> Result<Attractivity, KklError> {
    let enclosure = enclose(distance, region)?;
    let HurwitzAnalysis { spectrum: eigenvalues, p, certificate } = hurwitz(&enclosure.a)?;
    // Branches that coincide wherever both are possible are no choice.
    let jumps = enclosure.branches.filter(|branches| branches.jump > 0.0);
    Ok(Attractivity { jacobian: enclosure.a, eigenvalues, p, jumps, certificate })
}
