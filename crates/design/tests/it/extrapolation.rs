//! The integrator of the many short trajectories.

use luenberger_design::internals::{Extrapolation, Halt};

#[test]
fn the_circle_closes_and_the_blow_up_is_named() {
    let mut method = Extrapolation::new(2, 1e-12);
    let mut y = [0.0, 1.0];
    let mut circle = |y: &[f64], slope: &mut [f64]| (slope[0], slope[1]) = (y[1], -y[0]);
    method.advance(&mut circle, 20.0 * std::f64::consts::PI, &mut y, &[1.0; 2], 2).unwrap();
    // About two hundred steps, each within 1e-12.
    assert!(y[0].hypot(y[1] - 1.0) < 1e-10, "{y:?}");
    let mut method = Extrapolation::new(1, 1e-10);
    // y' = y^2 from 1 ends at t = 1; it is 1e3 at 1 - 1e-3, and followed much farther.
    let halt = method.advance(&mut |y, slope| slope[0] = y[0] * y[0], 2.0, &mut [1.0], &[1.0], 1).unwrap_err();
    match halt {
        Halt::Escape { time, norm } => assert!((time - 1.0).abs() <= 1e-8 && norm > 1e8, "{time} {norm}"),
        other => panic!("{other:?}"),
    }
    let nan = method.advance(&mut |_, slope| slope[0] = f64::NAN, 1.0, &mut [1.0], &[1.0], 1);
    assert_eq!(nan, Err(Halt::NotFinite));
}
