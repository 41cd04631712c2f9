//! Propositions 4 and 5: the [KKL+PEB]O as an I&IO, on the converter; the set relation (30).

use std::sync::Arc;

use crate::kkl::cuk::{self, Embedding, Tuning};
use luenberger_observers::{KklMap, Observer};
use luenberger_plants::{CukConverter, Plant};
use luenberger_sim::{Scenario, Signal, Trajectory};
use nalgebra::{Vector1, Vector2, Vector4, Vector6};

use crate::claim::{CheckError, Claim, Class, Outcome};
use crate::context::Context;
use crate::evidence::{Evidence, Hypothesis};
use crate::value::{Value, short};

const CONVERTER: &str = "the Cuk converter with its [KKL+PEB]O (Table I, corrected), towards |Vd| = 15 V from its equilibrium for 5 V, 0.2 s; L3 = 10 mH and λ = 0.2 are not printed";
const RHO: &str =
    "(18) with the term [∇χβ']⁺ρ, ρ = (0, dθ̂/dt), and Q the right-hand side of the [KKL+PEB]O; neither is printed";

const END: f64 = 0.2;
const SAMPLES: usize = 201;
const COMBINED: &str = "[KKL+PEB]O";
const PRINTED: &str = "I&IO, (21) to (23)";
const FREE: &str = "I&IO, with Q";
const WITH_RHO: &str = "I&IO, with Q and rho";
const KKLO: &str = "KKLO";
const AS_KKLO: &str = "I&IO, g1 = 1/L1, g2 = 0";
/// rtol = 1e-9 of the 50 V there are, and as much for the steps before: all errors decay or stand still.
const INTEGRATION: f64 = 1e-7;

pub(super) fn claims() -> Vec<Claim> {
    vec![
        Claim::holds(
            Class::Theorem,
            "kkl.prop5.as-printed",
            "Proposition 5, (21) to (23)",
            "with (21) to (23) the I&IO (18) coincides with the [KKL+PEB]O (the errors of i1 at 0.2 s agree)",
            &[CONVERTER],
            as_printed,
        )
        .quoting(
            "If the measurable output signals are partial states, the [KKL+PEB]O (15) exactly coincides with the I&IO (18)-(19)",
            "with β, Υ and Q of (21) to (23) the two give the same estimates from the same start; Q = 0, or the right-hand side of (15) where Q is read as a column",
        ),
        Claim::holds(
            Class::Ours,
            "kkl.prop5.repaired",
            "Proposition 5, with ρ",
            "with ρ in (18) the I&IO coincides with the [KKL+PEB]O (largest difference of their estimates, in A and V)",
            &[CONVERTER, RHO],
            with_rho,
        ),
        Claim::holds(
            Class::Theorem,
            "kkl.set-relation",
            "Corollary 1, (30)",
            "PEBO, KKLO ⊂ [KKL+PEB]O ⊂ I&IO",
            &[
                CONVERTER,
                "an inclusion is read as in the proof: the one observer, written as the other, gives the same estimates",
            ],
            set_relation,
        )
        .quoting(
            "For the nonlinear system (1), a [KKL+PEB]O implies the existence of I&I observers. Moreover, the following “set” relationship holds: PEBO, KKLO ⊂ [KKL+PEB]O ⊂ I&IO. (30)",
            "an I&IO is (18), (19) as printed, or with what the proof of Proposition 5 needs besides",
        ),
    ]
}

/// The [KKL+PEB]O, three I&IOs made of it, the KKLO, and the I&IO that it is; all from (i1hat, v4hat) = (0.3, -8).
fn run(context: &Context) -> Result<Arc<Trajectory>, CheckError> {
    context.once("kkl.prop5", || {
        let (plant, tuning, start, states) =
            (CukConverter::default(), Tuning::<f64>::default(), [0.3, -8.0], [0_usize, 3]);
        let immersed = |embedding| cuk::kkl_pebo_immersed(plant, &tuning, embedding);
        let as_kklo = Tuning { g1: 1.0 / plant.l1, g2: 0.0, ..tuning };
        Ok(Scenario::new(plant)
            .initial_state(plant.equilibrium(5.0).as_slice())
            .input(Signal::law(move |view, u| {
                u[0] = plant.control(&Vector4::from_column_slice(view.x), 15.0, 0.2);
            }))
            .partial_observer(COMBINED, cuk::kkl_pebo(plant, &tuning)?, &start, &states)
            .partial_observer(PRINTED, immersed(Embedding::Printed)?, &start, &states)
            .partial_observer(FREE, immersed(Embedding::Free)?, &start, &states)
            .partial_observer(WITH_RHO, immersed(Embedding::Equivalent)?, &start, &states)
            .partial_observer(KKLO, cuk::kklo(plant)?, &start, &states)
            .partial_observer(AS_KKLO, cuk::immersion_invariance(plant, &as_kklo)?, &start, &states)
            .tolerances(1e-9, 1e-10)
            .until(END, SAMPLES)
            .run()?)
    })
}

/// The largest difference between the estimates of two observers along the run.
fn difference(run: &Trajectory, one: &str, other: &str) -> Result<f64, CheckError> {
    Ok((&run.observer(one)?.estimate - &run.observer(other)?.estimate).amax())
}

/// The error of i1 at the start and at the end.
fn current(run: &Trajectory, name: &str) -> Result<(f64, f64), CheckError> {
    let error = &run.observer(name)?.error;
    Ok((error[(0, 0)], error[(SAMPLES - 1, 0)]))
}

fn as_printed(context: &Context) -> Result<Outcome, CheckError> {
    let run = run(context)?;
    let coincides =
        |name| -> Result<Value, CheckError> { Ok(Value::Truth(difference(&run, COMBINED, name)? <= INTEGRATION)) };
    let ((start, combined), (_, printed), (_, free)) =
        (current(&run, COMBINED)?, current(&run, PRINTED)?, current(&run, FREE)?);
    let error = &run.observer(PRINTED)?.error;
    let moved = error.column(0).iter().map(|e| (e - start).abs()).fold(0.0, f64::max);
    Ok(Outcome::new(Evidence::Readings(vec![
        ("Q = 0, (23)", coincides(PRINTED)?),
        ("Q is the right-hand side of the [KKL+PEB]O", coincides(FREE)?),
    ]))
    .note(format!(
        "The error of i1 is {} A at the start. At the end it is {} A with the [KKL+PEB]O, and {} A and {} A with the two I&IOs: (18) makes β follow φ(x̂), so that d(î1)/dt is di1/dt and \
         the error stays as it is (it moves by {} A), whereas î1 of the [KKL+PEB]O moves by dθ̂/dt besides.",
        short(start),
        short(combined),
        short(printed),
        short(free),
        short(moved)
    ))
    .given(hypotheses(&run)?))
}

/// What Proposition 5 asks for, on the converter: a [KKL+PEB]O, outputs that are states, the rank, and the invariance
/// of θ = θ̂.
fn hypotheses(run: &Trajectory) -> Result<Vec<Hypothesis>, CheckError> {
    let (start, end) = current(run, COMBINED)?;
    let (plant, tuning) = (CukConverter::default(), Tuning::<f64>::default());
    // From an estimate that is right the parameter does not move.
    let x = plant.equilibrium(5.0);
    let exact = Scenario::new(plant)
        .initial_state(x.as_slice())
        .input(Signal::law(move |view, u| u[0] = plant.control(&Vector4::from_column_slice(view.x), 15.0, 0.2)))
        .partial_observer(COMBINED, cuk::kkl_pebo(plant, &tuning)?, &[x[0], x[3]], &[0, 3])
        .tolerances(1e-9, 1e-10)
        .until(END, SAMPLES)
        .run()?;
    let off = exact.observer(COMBINED)?.error.amax();
    // By the estimate, which is β here: what each of the six entries of χ moves.
    let immersed = cuk::kkl_pebo_immersed(plant, &tuning, Embedding::Printed)?;
    let beta = |chi: Vector6<f64>| immersed.estimate(0.0, &chi, &Vector1::new(0.5), &Vector2::new(17.0, -0.2));
    let moves = (0..6).map(|i| beta(Vector6::from_fn(|j, _| f64::from(u8::from(i == j)))) - beta(Vector6::zeros()));
    let rank = nalgebra::DMatrix::from_columns(
        &moves.map(|m| nalgebra::DVector::from_column_slice(m.as_slice())).collect::<Vec<_>>(),
    )
    .rank(1e-9);
    Ok(vec![
        Hypothesis::computed(
            "the plant admits the [KKL+PEB]O",
            end.abs() < 1e-3 * start.abs(),
            format!("its error of i1 goes from {} A to {} A", short(start), short(end)),
        ),
        Hypothesis::computed(
            "the outputs are partial states",
            (0..4).all(|state| {
                let seen =
                    plant.output(0.0, &Vector4::from_fn(|i, _| f64::from(u8::from(i == state))), &Vector1::new(0.5));
                [1, 2].iter().enumerate().all(|(i, &row)| seen[i].total_cmp(&f64::from(u8::from(row == state))).is_eq())
            }),
            "y = (v2, i3), by the columns of h",
        ),
        Hypothesis::computed("rank [I + ∇_ξ N', ∇_ζ N'] = nξ", rank == 2, "N = (0, θ̂): the rank of D_χβ of the I&IO"),
        Hypothesis::computed(
            "{θ = θ̂} is invariant",
            off <= INTEGRATION,
            format!("begun there, the estimate stays right to {}", short(off)),
        ),
    ])
}

fn with_rho(context: &Context) -> Result<Outcome, CheckError> {
    let run = run(context)?;
    let apart = difference(&run, COMBINED, WITH_RHO)?;
    let (start, end) = current(&run, WITH_RHO)?;
    Ok(Outcome::new(Evidence::holds_by(apart <= INTEGRATION && end.abs() < 1e-3 * start.abs(), apart)).note(format!(
        "Integrated side by side; the error of i1 goes from {} A to {} A with both.",
        short(start),
        short(end)
    )))
}

fn set_relation(context: &Context) -> Result<Outcome, CheckError> {
    let run = run(context)?;
    let (kklo, printed, completed) =
        (difference(&run, KKLO, AS_KKLO)?, difference(&run, COMBINED, PRINTED)?, difference(&run, COMBINED, WITH_RHO)?);
    // R4: a PEBO is a [KKL+PEB]O without a Lambda_L.
    let tuning = Tuning::<f64>::default();
    let (u, y) = (Vector1::new(0.5), Vector2::new(17.0, 0.25));
    let integrates = cuk::pebo(CukConverter::default(), &tuning)?.map().lambda(0.0, &u, &y).amax() == 0.0;
    let inner = integrates && kklo <= INTEGRATION;
    Ok(Outcome::new(Evidence::Readings(vec![
        ("(18) with ρ", Value::Truth(inner && completed <= INTEGRATION)),
        ("(18) as printed", Value::Truth(inner && printed <= INTEGRATION)),
    ]))
    .note(format!(
        "PEBO and KKLO ⊂ [KKL+PEB]O holds by definition (q = 0, q = nξ); KKLO ⊂ I&IO holds as printed (R9; on the converter with γ1 = 1/L1, γ2 = 0, to {}). What has an estimator in it, \
         PEBO or [KKL+PEB]O, is an I&IO with ρ (difference {}) and not without ({}). Whether every plant with a [KKL+PEB]O has some other I&IO as printed is not decided by this.",
        short(kklo),
        short(completed),
        short(printed)
    )))
}
