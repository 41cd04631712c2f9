//! A plant supplied by the user, written once; one gain for all of its states, with the proof.

use luenberger::design::{LpvDesign, Region};
use luenberger::plants::{Dimensions, Plant, Shape};
use nalgebra::{RealField, Vector1, Vector2, convert};

/// A pendulum with friction: x1' = x2, x2' = -9.81 sin x1 - 0.1 x2 + u, the angle is measured.
#[derive(Clone, Copy)]
struct Pendulum;

impl Shape for Pendulum {
    fn dimensions(&self) -> Dimensions {
        Dimensions { states: 2, inputs: 1, outputs: 1 }
    }
}

impl<T: RealField + Copy> Plant<T> for Pendulum {
    type State = Vector2<T>;
    type Input = Vector1<T>;
    type Output = Vector1<T>;

    fn derivative(&self, _t: T, x: &Vector2<T>, u: &Vector1<T>) -> Vector2<T> {
        let (g, friction): (T, T) = (convert(9.81), convert(0.1));
        Vector2::new(x[1], -g * x[0].sin() - friction * x[1] + u[0])
    }

    fn output(&self, _t: T, x: &Vector2<T>, _u: &Self::Input) -> Vector1<T> {
        Vector1::new(x[0])
    }
}

pub(crate) fn main() -> Result<(), luenberger::design::LpvError> {
    let design = LpvDesign::new(Pendulum, &Region::everywhere(2), 3.0)?;
    println!("L = {}{design}", design.l());
    Ok(())
}
