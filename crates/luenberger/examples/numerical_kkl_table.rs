//! The reverse Duffing oscillator and Van der Pol's, observed without a closed form: T by simulation, its left inverse
//! in two forms.
//!
//! `cargo run --release -p luenberger --example numerical_kkl_table`

use std::io::IsTerminal;
use std::ops::ControlFlow::Continue;
use std::time::Instant;

use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};
use luenberger::design::numerical_kkl::{
    Domain, Escape, NumericalKklDesign, Progress, Settings, TargetSystem, Trial, held_out,
};
use luenberger::plants::{Differentiable, ReverseDuffing, VanDerPol};
use nalgebra::{Const, SVector};

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let starts = [[0.5, 0.5], [-0.3, 0.6], [0.1, 0.1], [0.9, 0.9]];
    let square = Domain::new([-1.0; 2], [1.0; 2], Escape::Free)?;
    for (name, cutoff, degree, leaves) in [
        ("reverse Duffing, 64 leaves of degree 4", 1.5, 4, 64),
        ("reverse Duffing, 32 leaves of degree 4, faster", 2.0, 4, 32),
        ("reverse Duffing, one polynomial of degree 8", 1.5, 8, 1),
        ("reverse Duffing, faster target", 5.0, 4, 64),
    ] {
        table(name, &ReverseDuffing, &square, cutoff, Settings { degree, leaves, ..Settings::default() }, &starts)?;
    }
    let domain = Domain::new([-2.3, -3.0], [2.3, 3.0], Escape::Slowed { margin: 1.0 })?;
    let starts = [[0.5, 0.5], [0.01, 0.0], [2.2, 2.5]];
    table("Van der Pol", &VanDerPol::default(), &domain, 8.0, Settings::default(), &starts)?;
    let fine = Settings { points: [129; 2], ..Settings::default() };
    table("Van der Pol, finer grid", &VanDerPol::default(), &domain, 8.0, fine, &starts)
}

/// Designs, and prints the evidence and the errors from t = 10 to 50, begun at z = 0.
fn table<S: Differentiable<f64, Const<2>, Const<0>, Const<1>>>(
    name: &str,
    plant: &S,
    domain: &Domain<2>,
    cutoff: f64,
    settings: Settings<2>,
    starts: &[[f64; 2]],
) -> Result<(), Box<dyn std::error::Error>> {
    let target = TargetSystem::<1, 3>::bessel(cutoff)?;
    let bar = bar()?;
    let began = Instant::now();
    let mut progress = |progress: Progress| {
        bar.set_length(progress.total as u64);
        bar.set_position(progress.done as u64);
        bar.set_message(progress.stage);
        Continue(())
    };
    let design = NumericalKklDesign::new(plant, &target, domain, SVector::zeros(), &settings, &mut progress)?;
    bar.finish_and_clear();
    println!("{name}: Bessel poles, cut-off {cutoff}; designed in {:.2} s", began.elapsed().as_secs_f64());
    println!("{}", design.report);
    println!("{:<14} | embedded: rmse x1, x2  | interpolated: rmse    | in the box", "from");
    for &start in starts {
        let trial = [Trial { start, transient: 10.0, end: 50.0, samples: 4001 }];
        let none = SVector::zeros();
        let (e, i) = (
            held_out(plant, &design.embedded, domain, &none, &trial)?,
            held_out(plant, &design.interpolated, domain, &none, &trial)?,
        );
        println!(
            "{:<14} | {:.2e}   {:.2e} | {:.2e}   {:.2e} | {:.0} %",
            format!("({}, {})", start[0], start[1]),
            e.inside.rmse[0],
            e.inside.rmse[1],
            i.inside.rmse[0],
            i.inside.rmse[1],
            100.0 * e.inside.samples as f64 / 4001.0
        );
        if e.outside.samples > 0 {
            println!(
                "{:<14} | {:.2e}   {:.2e} | {:.2e}   {:.2e} | outside",
                "", e.outside.rmse[0], e.outside.rmse[1], i.outside.rmse[0], i.outside.rmse[1]
            );
        }
    }
    println!();
    Ok(())
}

/// A bar on a terminal, nothing elsewhere.
fn bar() -> Result<ProgressBar, Box<dyn std::error::Error>> {
    let terminal = std::io::stderr().is_terminal();
    let target = if terminal { ProgressDrawTarget::stderr() } else { ProgressDrawTarget::hidden() };
    let bar = ProgressBar::with_draw_target(Some(1), target);
    bar.set_style(ProgressStyle::with_template("{bar:32.cyan/dim} {percent:>3} % {msg}")?);
    Ok(bar)
}
