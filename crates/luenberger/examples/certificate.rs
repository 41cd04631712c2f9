//! A design, its certificate file, and the check of that file, which needs neither the design nor a solver.
//!
//! `cargo run --example certificate > observer.json && cargo run -p luenberger-proof --bin luenberger-verify
//! observer.json`

use luenberger::design::{Certified, CubicDesign, CubicGain, LinearDesign, LyapunovWeight};
use luenberger::plants::StateSpace;
use luenberger::proof::certificate::verify;
use nalgebra::dmatrix;

pub(crate) fn main() -> Result<(), luenberger::Error> {
    let plant = StateSpace::new(dmatrix![0.0, 1.0; 0.0, 0.0], dmatrix![0.0; 1.0], dmatrix![1.0, 0.0])?;
    let linear = LinearDesign::with_poles_and_weight(&plant, &[-2.0, -5.0], LyapunovWeight::Identity(10.0))?;
    let cubic = CubicDesign::new(&linear, &dmatrix![10.0], &CubicGain::Gamma(2.0))?;
    let file = cubic.certificate_file("Example 1: the cubic observer of a double integrator")?.to_json();
    print!("{file}");

    let proved = verify(file.as_bytes())?;
    eprintln!("Proved: {}", proved.statement);
    for fact in &proved.facts {
        eprintln!("  {fact}");
    }
    // Another gain than the one that was certified: a digit of L.
    let forged = file.replacen("0x1.4", "0x1.5", 1);
    if let Err(why) = verify(forged.as_bytes()) {
        eprintln!("Rejected, one digit of L changed: {why}");
    }
    Ok(())
}
