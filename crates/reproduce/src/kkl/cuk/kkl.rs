//! The maps of the KKLO: `phi(x) = (v4, L1 i1 - C2 v2)`.

use luenberger_plants::CukConverter;
use nalgebra::{Matrix2, RealField, U1, U2, Vector1, Vector2, convert};

use super::Equations;
use luenberger_observers::kkl::KklMap;

/// `phi = (v4, L1 i1 - C2 v2)`, `Lambda = diag(-G/C4, -w/L1)`, `B = (y2/C4, -(1 + C2/L1) w y1 + E - u y2)`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CukKkl {
    pub(super) converter: CukConverter,
}

impl<T: RealField + Copy> KklMap<T> for CukKkl {
    type Xi = U2;
    type Inputs = U1;
    type Outputs = U2;
    type Estimate = U2;

    fn lambda(&self, _t: T, u: &Vector1<T>, y: &Vector2<T>) -> Matrix2<T> {
        let Equations { g, c4, w, l1, .. } = Equations::new(&self.converter, u, y);
        Matrix2::from_diagonal(&Vector2::new(-g / c4, -w / l1))
    }

    fn injection(&self, _t: T, _xi: &Vector2<T>, u: &Vector1<T>, y: &Vector2<T>) -> Vector2<T> {
        let Equations { l1, c2, c4, e, u, w, y1, y2, .. } = Equations::new(&self.converter, u, y);
        Vector2::new(y2 / c4, e - u * y2 - (T::one() + c2 / l1) * w * y1)
    }

    fn left_inverse(&self, _t: T, xi: &Vector2<T>, y: &Vector2<T>) -> Vector2<T> {
        let (l1, c2): (T, T) = (convert(self.converter.l1), convert(self.converter.c2));
        Vector2::new((xi[1] + c2 * y[0]) / l1, xi[0])
    }

    fn image(&self, _t: T, xhat: &Vector2<T>, y: &Vector2<T>) -> Vector2<T> {
        let (l1, c2): (T, T) = (convert(self.converter.l1), convert(self.converter.c2));
        Vector2::new(xhat[1], l1 * xhat[0] - c2 * y[0])
    }
}
