//! Linear plants over boxes: their matrices are binary64, so a plant exists for one scalar only; these are the other
//! scalars.

use luenberger_plants::{LinearPlant, Plant, Size};
use nalgebra::{DefaultAllocator, Dim, OVector, convert};

use super::scalar::IntervalDual;
use crate::symbolic_polynomial::SymbolicPolynomial;

macro_rules! linear_plant_over {
    ($($scalar:ident),*) => {$(
        impl<N: Dim, M: Dim, P: Dim> Plant<$scalar> for LinearPlant<f64, N, M, P>
        where
            DefaultAllocator: Size<N, M, P>,
        {
            type State = OVector<$scalar, N>;
            type Input = OVector<$scalar, M>;
            type Output = OVector<$scalar, P>;

            fn derivative(&self, _t: $scalar, x: &Self::State, u: &Self::Input) -> Self::State {
                self.a.map(convert::<f64, $scalar>) * x + self.b.map(convert::<f64, $scalar>) * u
            }

            fn output(&self, _t: $scalar, x: &Self::State, u: &Self::Input) -> Self::Output {
                let seen = self.c.map(convert::<f64, $scalar>) * x;
                match &self.d {
                    Some(d) => seen + d.map(convert::<f64, $scalar>) * u,
                    None => seen,
                }
            }
        }
    )*};
}

linear_plant_over!(IntervalDual, SymbolicPolynomial);
