//! Linear plants over boxes: their matrices are numbers, so that they are written for one scalar only, and this is the other.

use luenberger_plants::{Dimensions, LinearPlant, Plant, Size};
use nalgebra::{DefaultAllocator, Dim, OVector, convert};

use super::IntervalDual;

impl<N: Dim, M: Dim, P: Dim> Plant<IntervalDual> for LinearPlant<f64, N, M, P>
where
    DefaultAllocator: Size<N, M, P>,
{
    type State = OVector<IntervalDual, N>;
    type Input = OVector<IntervalDual, M>;
    type Output = OVector<IntervalDual, P>;

    fn dimensions(&self) -> Dimensions {
        Plant::<f64>::dimensions(self)
    }

    fn derivative(&self, _t: IntervalDual, x: &Self::State, u: &Self::Input) -> Self::State {
        self.a.map(convert::<f64, IntervalDual>) * x + self.b.map(convert::<f64, IntervalDual>) * u
    }

    fn output(&self, _t: IntervalDual, x: &Self::State) -> Self::Output {
        self.c.map(convert::<f64, IntervalDual>) * x
    }
}
