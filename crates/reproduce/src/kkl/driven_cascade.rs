//! The plant [`DrivenCascade`](luenberger_plants::DrivenCascade) in the form of the class of Proposition 7.

use luenberger_observers::cascade::Cascade;
use nalgebra::{Matrix1, RealField, U1, U2, Vector1, Vector2, convert};

/// The pieces of [`DrivenCascade`](luenberger_plants::DrivenCascade).
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Pieces;

impl<T: RealField + Copy> Cascade<T> for Pieces {
    type Second = U1;
    type Third = U1;
    type Fourth = U2;
    type Inputs = U2;
    type Outputs = U2;

    fn a2(&self) -> Matrix1<T> {
        Matrix1::new(-T::one())
    }

    fn a3(&self) -> Matrix1<T> {
        Matrix1::new(convert(-3.0))
    }

    fn k(&self) -> usize {
        0
    }

    fn f1k(&self, y: &Vector2<T>, _x2: &Vector1<T>, x3: &Vector1<T>, _u: &Vector2<T>) -> T {
        x3[0] - y[0]
    }

    fn f2(&self, y: &Vector2<T>, _u: &Vector2<T>) -> Vector1<T> {
        Vector1::new(y[1].sin())
    }

    fn f3(&self, y: &Vector2<T>, x2: &Vector1<T>, _u: &Vector2<T>) -> Vector1<T> {
        x2 * y[0]
    }

    fn f4(&self, y: &Vector2<T>, _x2: &Vector1<T>, _x3: &Vector1<T>, u: &Vector2<T>) -> Vector2<T> {
        u * (y[0] * convert(-0.5))
    }

    fn b(&self, _y: &Vector2<T>, _x2: &Vector1<T>, _x3: &Vector1<T>, u: &Vector2<T>) -> Vector2<T> {
        *u
    }
}
