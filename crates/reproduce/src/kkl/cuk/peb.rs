//! The maps of the PEBO, `phi(x) = (i1, v4 - G L3 i3/C4)`, and of the [KKL+PEB]O, `phi(x) = (i1, v4)`.

use luenberger_plants::CukConverter;
use nalgebra::{Matrix1, Matrix2, RealField, U1, U2, Vector1, Vector2, convert};

use super::Equations;
use luenberger_observers::kkl::KklMap;
use luenberger_observers::pebo::Regression;

/// Both unknown states by parameter estimation: Lambda = 0.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CukPeb {
    pub(super) converter: CukConverter,
}

impl CukPeb {
    /// `G L3/C4`: by it v4 differs from phi_2, per ampere of y2.
    fn ratio<T: RealField + Copy>(&self) -> T {
        convert(self.converter.g * self.converter.l3 / self.converter.c4)
    }
}

impl<T: RealField + Copy> KklMap<T> for CukPeb {
    type Xi = U2;
    type Inputs = U1;
    type Outputs = U2;
    type Estimate = U2;

    fn injection(&self, _t: T, _xi: &Vector2<T>, u: &Vector1<T>, y: &Vector2<T>) -> Vector2<T> {
        let known = Equations::new(&self.converter, u, y);
        Vector2::new(known.i1_rate(), (known.y2 + known.g * known.u * known.y1) / known.c4)
    }

    fn left_inverse(&self, _t: T, xi: &Vector2<T>, y: &Vector2<T>) -> Vector2<T> {
        Vector2::new(xi[0], xi[1] + self.ratio::<T>() * y[1])
    }

    fn image(&self, _t: T, xhat: &Vector2<T>, y: &Vector2<T>) -> Vector2<T> {
        Vector2::new(xhat[0], xhat[1] - self.ratio::<T>() * y[1])
    }
}

/// `s = y`: both outputs are filtered.
impl<T: RealField + Copy> Regression<T> for CukPeb {
    type Rows = U2;
    type Parameters = U2;

    fn signal(&self, _t: T, y: &Vector2<T>) -> Vector2<T> {
        *y
    }

    fn known(&self, t: T, xi: &Vector2<T>, u: &Vector1<T>, y: &Vector2<T>) -> Vector2<T> {
        let known = Equations::new(&self.converter, u, y);
        let estimated = self.left_inverse(t, xi, y);
        Vector2::new(known.y1_rate(estimated[0]), known.y2_rate(estimated[1]))
    }

    fn regressor(&self, _t: T, _xi: &Vector2<T>, u: &Vector1<T>, y: &Vector2<T>) -> Matrix2<T> {
        let known = Equations::new(&self.converter, u, y);
        Matrix2::from_diagonal(&Vector2::new(known.w / known.c2, -T::one() / known.l3))
    }

    fn missing(&self, theta: &Vector2<T>) -> Vector2<T> {
        *theta
    }
}

/// i1 by parameter estimation, v4 by the KKL part: Lambda = diag(0, -G/C4).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CukKklPeb {
    pub(super) converter: CukConverter,
}

impl<T: RealField + Copy> KklMap<T> for CukKklPeb {
    type Xi = U2;
    type Inputs = U1;
    type Outputs = U2;
    type Estimate = U2;

    fn lambda(&self, _t: T, u: &Vector1<T>, y: &Vector2<T>) -> Matrix2<T> {
        let Equations { g, c4, .. } = Equations::new(&self.converter, u, y);
        Matrix2::from_diagonal(&Vector2::new(T::zero(), -g / c4))
    }

    fn injection(&self, _t: T, _xi: &Vector2<T>, u: &Vector1<T>, y: &Vector2<T>) -> Vector2<T> {
        let known = Equations::new(&self.converter, u, y);
        Vector2::new(known.i1_rate(), known.y2 / known.c4)
    }

    fn left_inverse(&self, _t: T, xi: &Vector2<T>, _y: &Vector2<T>) -> Vector2<T> {
        *xi
    }

    fn image(&self, _t: T, xhat: &Vector2<T>, _y: &Vector2<T>) -> Vector2<T> {
        *xhat
    }
}

/// `s = y1`.
impl<T: RealField + Copy> Regression<T> for CukKklPeb {
    type Rows = U1;
    type Parameters = U1;

    fn signal(&self, _t: T, y: &Vector2<T>) -> Vector1<T> {
        Vector1::new(y[0])
    }

    fn known(&self, _t: T, xi: &Vector2<T>, u: &Vector1<T>, y: &Vector2<T>) -> Vector1<T> {
        Vector1::new(Equations::new(&self.converter, u, y).y1_rate(xi[0]))
    }

    fn regressor(&self, _t: T, _xi: &Vector2<T>, u: &Vector1<T>, y: &Vector2<T>) -> Matrix1<T> {
        let known = Equations::new(&self.converter, u, y);
        Matrix1::new(known.w / known.c2)
    }

    fn missing(&self, theta: &Vector1<T>) -> Vector2<T> {
        Vector2::new(theta[0], T::zero())
    }
}
