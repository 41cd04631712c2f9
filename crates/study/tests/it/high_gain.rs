//! High-gain observers of plants whose chains have coefficients: the continuous stirred-tank reactor.

use std::sync::atomic::AtomicBool;

use luenberger_study::design::design;
use luenberger_study::{RunOptions, run};

use crate::studies::read;

/// The exothermic reactor of Seborg, Edgar and Mellichamp, Process Dynamics and Control: time in minutes, the
/// temperature T (K) measured, the concentration cA (mol/l) not; unstable at cA = 0.5, T = 350, Tc = 300. Near T = 0
/// the rate exp(-8750/T) underflows.
const REACTOR: &str = r#"[plant]
f = ["Tf - T + 209.205*k0*exp(-8750/T)*cA + 2.092*(Tc - T)", "1 - cA - k0*exp(-8750/T)*cA"]
h = ["T"]
states = ["T", "cA"]
inputs = ["Tc"]
outputs = ["measured T"]
parameters = { k0 = 7.2e10, Tf = 350 }

[input]
expressions = ["300 + 2*sin(t)"]

[simulation]
x0 = [348, 0.55]
duration = 4

[[observer]]
kind = "high-gain"
r = 0.1
initial = [348, 0.4]
"#;

#[test]
fn a_coefficient_that_underflows_elsewhere_is_a_dependence() -> Result<(), Box<dyn std::error::Error>> {
    let study = read(REACTOR)?;
    let designed = design(&study, &study.observers[0], &AtomicBool::new(false)).map_err(|why| format!("{why:?}"))?;
    let matrix = |name: &str| designed.report.matrices.iter().find(|m| m.name == name).map(|m| m.rows.clone());
    // 209.205 * 7.2e10 * exp(-8750/348), in Python.
    let coefficient = 181.194_026_643_461_97;
    let factors = matrix("factors").ok_or("factors")?;
    assert_eq!(factors[0], [1.0]);
    assert!((factors[1][0] * coefficient - 1.0).abs() < 1e-6, "{}", 1.0 / factors[1][0]);
    assert_eq!(matrix("alpha_i / r^i"), Some(vec![vec![20.0], vec![100.0]]));

    // Without noise the estimate of the unmeasured concentration comes within 1 % of its first error, 0.15 mol/l.
    let results = run(&study, &RunOptions::default())?;
    assert_eq!(results.failures(), Vec::<String>::new());
    let rows = &results.simulation.ok_or("runs")?.rows;
    let merits = rows[0].merits.as_ref().ok_or("merits")?;
    assert!(merits.states[1].last.abs() < 1.5e-3, "{merits:?}");
    Ok(())
}

#[test]
fn a_coefficient_of_zero_at_the_first_estimate_is_named() -> Result<(), Box<dyn std::error::Error>> {
    let study = read(&REACTOR.replace("initial = [348, 0.4]", "initial = [1, 0.4]"))?;
    let why = design(&study, &study.observers[0], &AtomicBool::new(false)).err().ok_or("no design")?;
    let text = format!("{why:?}");
    assert!(text.contains("divides by the derivative of T' by cA, which is 0 at the first estimate"), "{text}");
    Ok(())
}
