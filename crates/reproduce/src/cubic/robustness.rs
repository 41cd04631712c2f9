//! Theorems 4 and 5: what they prove, what they leave out, and how tight (23) is.

use luenberger_design::robust::{PolytopicDesign, fixed_gain_margin, input_to_state_gain, theorem5_bound};
use luenberger_design::{Correction, CubicDesign, Decrease, LinearDesign, Wish};
use luenberger_plants::DynamicPlant;
use luenberger_proof::Matrix;
use luenberger_proof::statement::decay_rate;
use luenberger_sim::{Scenario, Trajectory};
use nalgebra::{DMatrix, dmatrix};

use super::{FORCING, example1};
use crate::claim::{CheckError, Claim, Outcome};
use crate::context::Context;
use crate::evidence::Evidence;
use crate::value::{Value, short};

const TWO_ERRORS: &str = "the error is that of the proof's dynamics, or x - x̂ of an observer that runs the nominal A";

pub(super) fn claims() -> Vec<Claim> {
    vec![
        Claim::holds(
            "cubic.thm4",
            "Theorem 4, (21)",
            "with a common P the estimation error is robustly stable: it tends to 0 for every A(ε)",
            &["an oscillator whose frequency is known to 10%", TWO_ERRORS],
            theorem4,
        ),
        Claim::holds(
            "cubic.thm5",
            "Theorem 5, (23)",
            "for ε below (23) the estimation error is robustly stable: it tends to 0",
            &["a plant that neither grows nor decays at A + ε I", TWO_ERRORS],
            theorem5,
        ),
        Claim::holds(
            "cubic.thm5.equality",
            "Theorem 5, (23)",
            "(23) may hold with equality (the error that is left)",
            &["A - LC = -I with two states and one output, Q = 2 P, so that (23) reads ε_max ≤ 1"],
            equality,
        ),
        Claim::holds(
            "cubic.thm5.tight",
            "Theorem 5; Section 3",
            "(23) can be tightened",
            &["Example 1, Q = 10 I", "tightened with P fixed, or with P chosen anew for the same L and N"],
            tight,
        ),
    ]
}

/// A harmonic oscillator of squared frequency `stiffness`, position measured.
fn oscillator(stiffness: f64) -> Result<DynamicPlant, CheckError> {
    Ok(DynamicPlant::new(dmatrix![0.0, 1.0; -stiffness, 0.0], DMatrix::zeros(2, 0), dmatrix![1.0, 0.0])?)
}

const END: f64 = 60.0;

/// The largest |e| over the last fifth of a run to [`END`].
fn late_error(run: &Trajectory) -> Result<f64, CheckError> {
    let size = run.trace(|view| view.error("cubic").map_or(f64::NAN, |e| e.iter().map(|e| e * e).sum::<f64>().sqrt()));
    Ok(size.maximum(0.8 * END)?.value)
}

fn run(plant: DynamicPlant, design: &CubicDesign, knows_the_plant: bool) -> Result<Trajectory, CheckError> {
    let mut observer = design.observer.clone();
    if knows_the_plant {
        // Then the error has exactly the dynamics of the proof, without forcing.
        observer.a.copy_from(&plant.a);
    }
    Ok(Scenario::new(plant)
        .initial_state(&[1.0, 0.0])
        .observer("cubic", observer, &[0.0, 0.0])
        .until(END, 601)
        .run()?)
}

/// The two readings of a robust theorem: what remains of the error at the end, and the bound on it.
fn readings(design: &CubicDesign, plant: &DynamicPlant, of: &str) -> Result<Outcome, CheckError> {
    let unforced = late_error(&run(plant.clone(), design, true)?)?;
    let forced = late_error(&run(plant.clone(), design, false)?)?;
    let forcing = run(plant.clone(), design, false)?;
    let (a, nominal) = (plant.a.clone(), design.observer.a.clone());
    let largest_forcing = forcing
        .trace(move |view| ((&a - &nominal) * nalgebra::DVector::from_column_slice(view.x)).norm())
        .maximum(0.0)?
        .value;
    let bound = input_to_state_gain(&design.p, &design.q)? * largest_forcing;
    if forced > bound {
        return Err(format!("|e| = {forced} at the end exceeds the bound {bound} of input-to-state stability").into());
    }
    // Rounding of a run that starts from |e| = 1.
    let vanishes = |error: f64| Value::Truth(error < 1e-9);
    Ok(Outcome::new(Evidence::Readings(vec![
        ("the error dynamics of the proof", vanishes(unforced)),
        ("x - x̂ of an observer that runs the nominal A", vanishes(forced)),
    ]))
    .note(format!(
        "At the end |e| is {} by the first reading and {} by the second: {of} forces the error by (A(ε) - A) x, which the proof \
         leaves out. What holds is input-to-state stability, here |e| ≤ {}, as for the linear observer.",
        short(unforced),
        short(forced),
        short(bound)
    )))
}

fn theorem4(_: &Context) -> Result<Outcome, CheckError> {
    let vertices = [oscillator(0.9)?.a, oscillator(1.1)?.a];
    let polytope = PolytopicDesign::new(&oscillator(1.0)?, &vertices, 0.5)?;
    if !polytope.certificate.is_proved() {
        return Err(format!("the common P is not proved:\n{}", polytope.certificate).into());
    }
    let design = CubicDesign::new(&polytope.nominal, &dmatrix![1.0], &Correction::Gamma(1.0))?;
    readings(&design, &oscillator(1.1)?, "an oscillation that does not decay")
}

/// A plant with poles -eps +- i, so that at A + eps I it neither grows nor decays.
fn theorem5(_: &Context) -> Result<Outcome, CheckError> {
    let eps = 0.05;
    let shift = DMatrix::identity(2, 2) * eps;
    let at_eps = oscillator(1.0)?;
    let nominal = DynamicPlant::new(&at_eps.a - &shift, at_eps.b.clone(), at_eps.c.clone())?;
    let linear = LinearDesign::new(&nominal, &Wish::poles(&[-1.0, -2.0]), &Decrease::Scaled(1.0))?;
    let bound = theorem5_bound(&linear.p, &linear.q)?;
    if eps >= bound {
        return Err(format!("ε = {eps} is not below the bound {bound}").into());
    }
    let design = CubicDesign::new(&linear, &dmatrix![1.0], &Correction::Gamma(1.0))?;
    readings(&design, &at_eps, "a state that does not decay")
}

/// At ε = 1 the error dynamics of A - LC = -I are the cubic term alone, which an error in the kernel of C does not feel.
fn equality(_: &Context) -> Result<Outcome, CheckError> {
    let plant = DynamicPlant::new(-DMatrix::identity(2, 2), DMatrix::zeros(2, 0), dmatrix![1.0, 0.0])?;
    let linear = LinearDesign::new(&plant, &Wish::Gain(DMatrix::zeros(2, 1)), &Decrease::Scaled(2.0))?;
    let bound = theorem5_bound(&linear.p, &linear.q)?;
    let mut observer = CubicDesign::new(&linear, &dmatrix![1.0], &Correction::Gamma(1.0))?.observer.clone();
    observer.a += DMatrix::identity(2, 2) * bound;
    let at_bound = DynamicPlant::new(observer.a.clone(), plant.b, plant.c)?;
    let run = Scenario::new(at_bound).observer("cubic", observer, &[0.0, -1.0]).until(END, 2).run()?;
    let left = late_error(&run)?;
    Ok(Outcome::new(Evidence::holds_by(left < 1e-9, left))
        .note(format!("The bound is {} here. The proof needs the strict inequality.", short(bound))))
}

fn tight(_: &Context) -> Result<Outcome, CheckError> {
    let design = example1::cubic()?;
    let bound = theorem5_bound(&design.p, &design.q)?;
    let exact = |m: &DMatrix<f64>| Matrix::from_column_major(m.nrows(), m.ncols(), m.as_slice());
    let (a, l) = (exact(&design.observer.a)?, exact(&design.observer.l)?);
    let (c, p) = (exact(&design.observer.c)?, exact(&design.p)?);
    let at = |eps: f64| decay_rate(&a, &l, &c, &p, eps);
    // With P fixed: proved just below the bound, refuted just above it.
    let is_tight = at(bound * (1.0 - 1e-9))?.is_proved() && at(bound * (1.0 + 1e-9))?.is_refuted();
    let free = fixed_gain_margin(&example1::plant(), &design.observer.l, &design.observer.n, 1e-4)?.margin;
    Ok(Outcome::new(Evidence::Readings(vec![
        ("P is fixed", Value::Truth(!is_tight)),
        ("P is chosen anew, L and N are kept", Value::Truth(free > bound)),
    ]))
    .note(format!(
        "For this P and Q = ρ I the bound {} is the supremum: proved below it and refuted above it, to 1e-9. With P free the same \
         gains allow {}. {FORCING}",
        short(bound),
        short(free)
    )))
}
