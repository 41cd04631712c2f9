//! Luenberger's observer by poles, noise, a decay rate or a given gain, each with its proof.

use luenberger::prelude::*;
use nalgebra::dmatrix;

pub(crate) fn main() -> Result<(), luenberger::Error> {
    // A cart with friction: position is measured, velocity is wanted.
    let plant = StateSpace::new(dmatrix![0.0, 1.0; 0.0, -0.5], dmatrix![0.0; 1.0], dmatrix![1.0, 0.0])?;
    let designs = [
        ("poles at -2, -5", LinearDesign::with_poles(&plant, &[-2.0, -5.0])?),
        ("known noise", LinearDesign::kalman(&plant, &dmatrix![0.0, 0.0; 0.0, 1.0], &dmatrix![0.01])?),
        ("errors decay like exp(-2 t)", LinearDesign::with_decay_rate(&plant, 2.0)?),
        ("a given gain", LinearDesign::with_gain(&plant, &dmatrix![3.0; 2.0])?),
    ];
    for (words, design) in &designs {
        assert!(design.certificate.is_proved());
        let run = Scenario::new(&plant)
            .initial_state(&[-3.0, -3.0])
            .input(Signal::scalar(f64::sin))
            .observer("linear", design.observer.clone(), &[0.0, 0.0])
            .until(5.0, 101)
            .run()?;
        let error = run.error_trace("linear", 1)?;
        let settled = metrics::settling_last(&error, 0.05).map_or("later".to_owned(), |t| format!("from t = {t:.2}"));
        println!("{words}: L = {:.3}", design.l().transpose());
        println!("  poles of A - L C: {:.3?}", design.poles.iter().map(|s| (s.re, s.im)).collect::<Vec<_>>());
        println!("  |velocity - estimate| below 0.05 {settled}");
        print!("{}", design.certificate);
    }
    // A velocity sensor alone never sees the position: the error names the mode.
    let blind = StateSpace { c: dmatrix![0.0, 1.0], ..plant };
    let refused = LinearDesign::with_poles(&blind, &[-2.0, -5.0]);
    println!("velocity measured instead: {}", refused.expect_err("no gain moves the position's mode"));
    Ok(())
}
