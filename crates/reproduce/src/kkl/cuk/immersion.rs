//! The maps of the I&IO: `beta = (chi1 + C2 g1 y1, chi2 - L3 g2 y2)`, `phi = (i1, v4)`.

use luenberger_plants::CukConverter;
use nalgebra::{RealField, U1, U2, U4, Vector2, Vector4, convert};

use super::{complete, unmeasured};
use luenberger_observers::immersion_invariance::Immersion;

/// `beta = (chi1 + C2 g1 y1, chi2 - L3 g2 y2)`, `phi = (i1, v4)`; everything else in (18) follows from the plant.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CukImmersion {
    pub(super) converter: CukConverter,
    pub(super) g1: f64,
    pub(super) g2: f64,
}

impl CukImmersion {
    /// `beta - chi`.
    fn output_part<T: RealField + Copy>(&self, y: &Vector2<T>) -> Vector2<T> {
        let first: T = convert(self.converter.c2 * self.g1);
        let second: T = convert(self.converter.l3 * self.g2);
        Vector2::new(first * y[0], -second * y[1])
    }
}

impl luenberger_plants::ByDual for CukImmersion {}

impl<T: RealField + Copy> Immersion<T> for CukImmersion {
    type States = U4;
    type Inputs = U1;
    type Outputs = U2;
    type Manifold = U2;
    type Extension = U2;
    type Estimate = U2;

    fn beta(&self, y: &Vector2<T>, chi: &Vector2<T>) -> Vector2<T> {
        chi + self.output_part(y)
    }

    fn phi(&self, x: &Vector4<T>) -> Vector2<T> {
        unmeasured(x)
    }

    fn left_inverse(&self, z: &Vector2<T>, y: &Vector2<T>) -> Vector4<T> {
        complete(z, y)
    }

    fn estimate(&self, xhat: &Vector4<T>) -> Vector2<T> {
        unmeasured(xhat)
    }

    fn start(&self, estimate: &Vector2<T>, y: &Vector2<T>) -> Vector2<T> {
        estimate - self.output_part(y)
    }
}
