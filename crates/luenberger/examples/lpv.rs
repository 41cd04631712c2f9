//! A plant supplied by the user, written once; one gain for all of its states, with the proof.

use luenberger::design::{LpvDesign, Region};
use nalgebra::convert;

/// A pendulum with friction: x1' = x2, x2' = -9.81 sin x1 - 0.1 x2 + u, the angle is measured.
#[derive(Clone, Copy)]
struct Pendulum;

luenberger::plants::plant!(
    Pendulum,
    (2, 1, 1),
    |pendulum, t, x, u| {
        let (g, friction): (T, T) = (convert(9.81), convert(0.1));
        [x[1], -g * x[0].sin() - friction * x[1] + u[0]]
    },
    [x[0]]
);

pub(crate) fn main() -> Result<(), luenberger::design::LpvError> {
    let design = LpvDesign::new(Pendulum, &Region::everywhere(2), 3.0)?;
    println!("{design}");
    Ok(())
}
