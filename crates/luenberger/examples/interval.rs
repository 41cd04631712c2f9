//! An interval observer: bounds that enclose the state, and what makes them narrow.

use luenberger::design::{Certified, DisturbanceBounds, ErrorCoordinates, IntervalDesign, LinearDesign};
use luenberger::observers::Observer;
use luenberger::plants::StateSpace;
use nalgebra::{DVector, dmatrix};

pub(crate) fn main() -> Result<(), Box<dyn std::error::Error>> {
    // A motor with an unknown load torque up to 0.3, and a tachometer with noise up to 0.05.
    let plant = StateSpace::new(dmatrix![-1.0, 2.0; -4.0, -8.0], dmatrix![0.0; 5.0], dmatrix![1.0, 0.0])?;
    let acting = DisturbanceBounds::of_states_and_outputs(&dmatrix![1.0; 0.0], &[0.3], &[0.05]);
    let first = [2.0, 2.0];

    println!("half-widths in the end   speed   current");
    for poles in [[-4.0, -8.0], [-6.0, -9.0], [-12.0, -18.0]] {
        let linear = LinearDesign::with_poles(&plant, &poles)?;
        let design = IntervalDesign::new(&linear.observer, &acting, ErrorCoordinates::Modal, &first)?;
        println!("poles {poles:?}: {:.3} {:.3}", design.widths[0], design.widths[1]);
        assert!(design.certificate.is_proved());
    }
    let best = IntervalDesign::least_width(&plant, &acting, &first)?;
    println!("least sum, in the coordinates of the plant: {:.3} {:.3}", best.widths[0], best.widths[1]);
    println!("{}", best.certificate_file("a motor")?.statement());

    // The bounds along a run with the load at a corner: Euler steps of 1 ms, of the plant and of the observer. The gain
    // of least width is too fast for such steps.
    let linear = LinearDesign::with_poles(&plant, &[-6.0, -9.0])?;
    let best = IntervalDesign::new(&linear.observer, &acting, ErrorCoordinates::Modal, &first)?;
    let (mut x, u, h) = (DVector::from_vec(vec![1.0, -1.5]), DVector::from_element(1, 0.2), 1e-3);
    let mut state = best.observer.initial(0.0, &DVector::zeros(2), &u, &DVector::zeros(1));
    for k in 0..3000 {
        let r = best.observer.half_widths(state.as_slice());
        for i in 0..2 {
            assert!((x[i] - state[i]).abs() <= r[i] * (1.0 + 1e-6), "step {k}: x{} left its bounds", i + 1);
        }
        let y = &plant.c * &x + DVector::from_element(1, if k % 7 < 3 { 0.05 } else { -0.05 });
        state += best.observer.derivative(0.0, &state, &u, &y) * h;
        x += (&plant.a * &x + &plant.b * &u + dmatrix![0.3; 0.0].column(0)) * h;
    }
    let r = best.observer.half_widths(state.as_slice());
    println!("after 3 s: speed {:.3} in [{:.3}, {:.3}]", x[0], state[0] - r[0], state[0] + r[0]);
    Ok(())
}
