//! A Lipschitz plant: its constant alone is too little to know for any gain, where the nonlinearity acts is enough.

use luenberger::design::DesignError;
use luenberger::plants::flexible_joint;
use luenberger::prelude::*;
use nalgebra::{DMatrix, dmatrix};

pub(crate) fn main() -> Result<(), Box<dyn std::error::Error>> {
    // x' = A x + (0, 0, 0, -3.33 sin x3) + B u: a robot link behind a spring, seen from the motor.
    let plant = flexible_joint::classical();
    let a = DMatrix::from_column_slice(4, 4, plant.linear_part().as_slice());
    let c = DMatrix::identity(2, 4);

    // |phi(x) - phi(z)| <= 3.33 |x - z|, and nothing else: that no gain serves all such phi is proved.
    let crude = LipschitzPlant::unstructured(a.clone(), c.clone(), 3.33)?;
    match LipschitzDesign::new(&crude, 0.0) {
        Err(error @ DesignError::Infeasible { .. }) => println!("the constant alone: {error}"),
        other => return Err(format!("expected a refutation, found {other:?}").into()),
    }
    // It acts on x4' and depends on x3.
    let sine = Sector::structured(dmatrix![0.0; 0.0; 0.0; 1.0], dmatrix![0.0, 0.0, 1.0, 0.0], 3.33);
    let design = LipschitzDesign::new(&LipschitzPlant::new(a, c, vec![sine])?, 1.0)?;
    println!("with its structure: L = {:.2}{}", design.l, design.certificate);
    assert!(design.certificate.is_proved());

    let run = Scenario::new(plant)
        .initial_state(&[3.0; 4])
        .input(Signal::scalar(f64::sin))
        .observer("lipschitz", design.observer(plant)?, &[1.0, 2.0, 0.5, 1.0])
        .until(10.0, 6)
        .run()?;
    let error = &run.observer("lipschitz")?.error;
    for (t, e) in run.t.iter().zip(error.row_iter()) {
        println!("t = {t:4}: |e| = {:.2e}", e.norm());
    }
    // P bounds the error as a whole: |e| <= sqrt(cond P) exp(-t) |e(0)|.
    assert!(error.row(5).norm() < 1e-2 * error.row(0).norm());
    Ok(())
}
