//! An observer computed by simulation: the reverse Duffing oscillator, whose linearisation at the origin sees nothing
//! of x2.
//!
//! The table here is small, to be quick. `numerical_kkl_table` has those of `docs/numerical-kkl.md`.

use luenberger::design::numerical_kkl::{Domain, Escape, Settings, TargetSystem, Trial, held_out};
use luenberger::plants::ReverseDuffing;
use luenberger::prelude::*;
use nalgebra::SVector;
use std::ops::ControlFlow::Continue;

pub(crate) fn main() -> Result<(), luenberger::Error> {
    // x1' = x2^3, x2' = -x1, y = x1, on a box; z' = D z + B y with the poles of a Bessel filter, and z = T(x) from the
    // plant's simulated past.
    let domain = Domain::new([-1.0; 2], [1.0; 2], Escape::Free)?;
    let target = TargetSystem::<1, 3>::bessel(1.5)?;
    let settings = Settings { points: [17; 2], leaves: 8, samples: 2000, ..Settings::default() };
    let none = SVector::zeros();
    let design = NumericalKklDesign::new(&ReverseDuffing, &target, &domain, none, &settings, &mut |_| Continue(()))?;
    println!("{}", design.report);

    // What the report measured on held-out points, on trajectories that were not fitted either.
    for start in [[0.5, 0.5], [-0.3, 0.6]] {
        let trial = [Trial { start, transient: 10.0, end: 30.0, samples: 401 }];
        let error = held_out(&ReverseDuffing, &design.embedded, &domain, &none, &trial)?;
        let (e1, e2) = (error.inside.rmse[0], error.inside.rmse[1]);
        println!("from {start:?}, t = 10 to 30: root mean square of the errors {e1:.1e} and {e2:.1e}");
        assert!(e1 < 0.1 && e2 < 0.1, "a tenth of the box's half-width");
    }
    Ok(())
}
