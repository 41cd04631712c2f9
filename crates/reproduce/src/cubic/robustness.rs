//! Theorems 4 and 5: what they prove, what they do not cover, and the conservatism of (23).

use luenberger_design::robust::{
    PolytopicDesign, fixed_gain_margin, fixed_lyapunov_margin, input_to_state_gain, theorem5_bound,
};
use luenberger_design::{CubicDesign, CubicGain, LinearDesign, LyapunovWeight};
use luenberger_linalg::{lambda_max, lambda_min};
use luenberger_lmi::proof_matrix;
use luenberger_observers::{CubicObserver, Observer};
use luenberger_plants::StateSpace;
use luenberger_proof::certificate::Number;
use luenberger_proof::coq::cubic_paper::{self, AtEquality};
use luenberger_proof::statement::{decay_rate, lyapunov_decrease};
use luenberger_sim::{Scenario, Trajectory};
use nalgebra::{DMatrix, DVector, dmatrix};

use super::random::Random;
use super::theorems::{TESTS, random_designs, seeded, truth};
use super::{FORCING, example1};
use crate::claim::{CheckError, Claim, Class, Outcome};
use crate::context::Context;
use crate::evidence::{Evidence, Hypothesis};
use crate::hypotheses::{self, as_printed};
use crate::paper::KernelRefutation;
use crate::value::{Value, short};

const TWO_ERRORS: &str = "the error is that of the proof's dynamics, or x - x̂ of an observer that runs the nominal A";

pub(super) fn claims() -> Vec<Claim> {
    vec![
        Claim::holds(
            Class::Theorem,
            "cubic.thm4",
            "Theorem 4, (21)",
            "with a common P the estimation error is robustly stable: it tends to 0 for every A(ε)",
            &["an oscillator whose frequency is known to 10%", TWO_ERRORS],
            theorem4,
        )
        .quoting(
            "The cubic observer (5) yields robustly stable estimation error dynamics for all uncertainties captured by A(ε) if (13) holds.",
            "the estimation error is x - x̂_c, (6); the error dynamics of the proof are V̇_1 + V̇_2, which leave out (A(ε) - A) x",
        ),
        Claim::holds(
            Class::Theorem,
            "cubic.thm4.margin",
            "after Theorem 4",
            "the cubic term gives a confidence margin where the error is large: V' is negative there also for an A(ε) for which V_1' is not",
            &["random plants, A(ε) = A + εI with the ε at which V_1' is first positive somewhere, doubled; errors of size 10⁶ in 200 random directions and in those where V_1' is largest"],
            confidence_margin,
        )
        .quoting(
            "Note that V̇_2 introduced in the proof of Theorem 4, is not affected by uncertainty and therefore provides a confidence margin for the cubic observer convergence when the estimation error of \
             (20) is large.",
            "a margin is what V̇_2 < 0 leaves for V̇_1 ≥ 0, for large errors; V̇_2 is 0 for errors that no output sees",
        ),
        Claim::holds(
            Class::Theorem,
            "cubic.thm5",
            "Theorem 5, (23)",
            "for ε below (23) the estimation error is robustly stable: it tends to 0",
            &["a plant that neither grows nor decays at A + ε I", TWO_ERRORS],
            theorem5,
        )
        .quoting(
            "The estimation error dynamics of the cubic observer are robustly stable if (23) holds.",
            "the estimation error is x - x̂_c, (6); the error dynamics of the proof are V̇_cN + V̇_cε, which leave out εx",
        ),
        Claim::holds(
            Class::Theorem,
            "cubic.thm5.linear",
            "before Theorem 5",
            "Theorem 5 holds for linear observers too: below (23) V decreases with N = 0",
            &["random plants, random Q > 0; the error dynamics of the proof, at ε = 0.999 and ten times less of the bound"],
            linear_theorem5,
        )
        .quoting(
            "This theorem also holds for linear observers as can be seen from the proof.",
            "the theorem with N_c = 0, for the error dynamics of its proof; what they leave out is the same for both observers (cubic.thm5)",
        )
        .proved_in("theory-cubic.md", "## Robustness", TESTS, "the_bound_of_theorem_5_suffices_for_every_q"),
        Claim::holds(
            Class::Misprint,
            "cubic.thm5.equality",
            "Theorem 5, (23)",
            "(23) may hold with equality (the error that is left)",
            &["the observer runs A(ε), so that nothing but the equality is tested"],
            equality,
        )
        .quoting(
            "ε_max ≤ λ_min(Q)/(2 λ_max(P)) (23) [..] In order for the Lyapunov derivative to be negative, it is sufficient that: -λ_min(Q) + 2 ε_max λ_max(P) < 0",
            "the last line of the proof has <, and (23) has ≤: one of the two is a slip, and < is what is proved. \
             θ ≥ 0 may be singular, as in Theorem 1. Robustly stable is: the error tends to 0, as an observer's must \
             (\"aimed to converge to the state vector of (1)\"); stable in the sense of Lyapunov it is at equality too",
        ),
        Claim::holds(
            Class::Ours,
            "cubic.thm5.equality-observable",
            "beyond the paper: Theorem 5",
            "at equality in (23) the error still tends to 0 where (A, C) is observable, θ > 0 and S + S' > 0, though not exponentially (|e| at t = 60, 1000, 10000)",
            &["A - LC = [-1 1; -1 -1], C = (1, 0), P = I, Q = 2 I, θ = γ = 1, e(0) = (0, 1)"],
            equality_observable,
        ),
        Claim::holds(
            Class::Ours,
            "cubic.thm5.tight",
            "Theorem 5; Section 3",
            "for its P the bound (23) is the supremum; with P chosen anew the same L and N allow more (both bounds)",
            &["Example 1, Q = 10 I"],
            tight,
        )
        .quoting(
            "Tightening of the bounds as well as more generic uncertainty structures require future research.",
            "a task, not a claim: what can be had with P fixed, and with P free",
        ),
    ]
}

/// V' with N = 0 below the bound, proved, for random plants and random Q.
fn linear_theorem5(_: &Context) -> Result<Outcome, CheckError> {
    let mut random = Random::new();
    let mut truths = Vec::new();
    for n in 1..=5 {
        for p in 1..=n {
            let plant = random.plant(n, p)?;
            let poles: Vec<f64> = (0..n).map(|k| -1.0 - 0.5 * k as f64).collect();
            let weight = LyapunovWeight::Matrix(random.definite(n));
            let design = LinearDesign::with_poles_and_weight(&plant, &poles, weight)?;
            let bound = theorem5_bound(&design.p, &design.q)?;
            let (l, c) = (proof_matrix(design.l()), proof_matrix(&plant.c));
            for share in [0.999, 0.0999] {
                let a = proof_matrix(&(&plant.a + DMatrix::identity(n, n) * (share * bound)));
                truths.push(truth(&[decay_rate(&a, &l, &c, &proof_matrix(&design.p), 0.0)?]));
            }
        }
    }
    Ok(Outcome::new(Evidence::cases(truths))
        .note(seeded("Proved for each: the cubic term, which is not positive in V', is not used in the proof.")))
}

/// Large errors along random directions, and along that of the largest V_1'.
fn confidence_margin(_: &Context) -> Result<Outcome, CheckError> {
    const LARGE: f64 = 1e6;
    let mut random = Random::new();
    let (mut everywhere, mut seen, mut cases, mut grows) = (true, true, 0, 0.0_f64);
    let mut unaffected = true;
    for design in random_designs(|_, _| CubicGain::Gamma(1.0))? {
        let o = &design.observer;
        let n = design.p.nrows();
        // V_1' = -e'(Q - 2 ε P)e is first positive beyond the margin of this P.
        let eps = 2.0 * fixed_lyapunov_margin(&design.p, &design.q)?;
        let form = &design.p * (eps * 2.0) - &design.q;
        let eigen = form.clone().symmetric_eigen();
        let worst = eigen.eigenvectors.column(eigen.eigenvalues.imax()).into_owned();
        let second = |e: &DVector<f64>, a: &DMatrix<f64>| {
            let (u, y) = (DVector::zeros(o.b.ncols()), DVector::zeros(o.c.nrows()));
            let mut perturbed = o.clone();
            perturbed.a.copy_from(a);
            let linear = (a - &o.l * &o.c) * e;
            let cubic = -perturbed.derivative(0.0, &-e, &u, &y) - linear;
            2.0 * (&design.p * e).dot(&cubic)
        };
        let shifted = &o.a + DMatrix::identity(n, n) * eps;
        // The kernel of C, where there is one: what no output sees.
        let hidden = hidden_direction(&o.c, &form);
        let random_directions = (0..200).map(|_| random.vector(n)).collect::<Vec<_>>();
        for direction in random_directions.iter().chain([&worst]).chain(hidden.as_ref()) {
            let e = direction * (LARGE / direction.norm());
            let (v1, v2) = (e.dot(&(&form * &e)), second(&e, &shifted));
            let nominal = second(&e, &o.a);
            unaffected &= (v2 - nominal).abs() <= 1e-9 * (v2.abs() + v1.abs());
            let decreases = v1 + v2 < 0.0;
            everywhere &= decreases;
            if (&o.c * &e).norm() > 1e-2 * LARGE * o.c.norm() {
                seen &= decreases;
            }
            grows = grows.max((v1 + v2) / e.norm_squared());
            cases += 1;
        }
    }
    if !unaffected {
        return Err("V_2' depends on ε".into());
    }
    Ok(Outcome::new(Evidence::Readings(vec![
        ("errors of which the outputs show at least a hundredth", Value::Truth(seen)),
        ("every large error", Value::Truth(everywhere)),
    ]))
    .instances(cases)
    .note(seeded(&format!(
        "V_2' is the same for every ε. It is of fourth order in C e, and 0 where C e = 0: there V' = V_1' is up to {} |e|², however large e is. A margin for every large error needs as many outputs as \
         states.",
        short(grows)
    ))))
}

/// Of the kernel of C the direction in which the form is largest; none if C has full column rank.
fn hidden_direction(c: &DMatrix<f64>, form: &DMatrix<f64>) -> Option<DVector<f64>> {
    let eigen = (c.transpose() * c).symmetric_eigen();
    let largest = eigen.eigenvalues.amax();
    let kernel: Vec<_> = (0..c.ncols())
        .filter(|&k| eigen.eigenvalues[k].abs() <= 1e-9 * largest)
        .map(|k| eigen.eigenvectors.column(k).into_owned())
        .collect();
    if kernel.is_empty() {
        return None;
    }
    let basis = DMatrix::from_columns(&kernel);
    let inside = (basis.transpose() * form * &basis).symmetric_eigen();
    Some(&basis * inside.eigenvectors.column(inside.eigenvalues.imax()))
}

/// A harmonic oscillator of squared frequency `stiffness`, position measured.
fn oscillator(stiffness: f64) -> Result<StateSpace, CheckError> {
    Ok(StateSpace::new(dmatrix![0.0, 1.0; -stiffness, 0.0], DMatrix::zeros(2, 0), dmatrix![1.0, 0.0])?)
}

const END: f64 = 60.0;

/// The largest |e| over the last fifth of a run to [`END`].
fn late_error(run: &Trajectory) -> Result<f64, CheckError> {
    let size = run.trace(|view| view.error("cubic").map_or(f64::NAN, |e| e.iter().map(|e| e * e).sum::<f64>().sqrt()));
    Ok(size.maximum(0.8 * END)?.value)
}

fn run(plant: StateSpace, design: &CubicDesign, knows_the_plant: bool) -> Result<Trajectory, CheckError> {
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
fn readings(design: &CubicDesign, plant: &StateSpace, of: &str) -> Result<Outcome, CheckError> {
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
    let design = CubicDesign::new(&polytope.nominal, &dmatrix![1.0], &CubicGain::Gamma(1.0))?;
    let o = &design.observer;
    let (mut observability, mut decrease) = (Vec::new(), Vec::new());
    for a in std::iter::once(&o.a).chain(&vertices) {
        observability.push(hypotheses::observability(a, &o.c)?);
        decrease.push(lyapunov_decrease(
            &proof_matrix(a),
            &proof_matrix(&o.l),
            &proof_matrix(&o.c),
            &proof_matrix(&design.p),
        )?);
    }
    let given = vec![
        hypotheses::in_each("(A(ε), C) is observable, at both ends and half-way", &observability),
        hypotheses::in_each("(21) at both ends, hence for every ε", &decrease),
    ];
    Ok(readings(&design, &oscillator(1.1)?, "an oscillation that does not decay")?
        .given(given)
        .given(of_both(&design)?))
}

/// P > 0, what (13) says of theta and N, and (11), which follows.
fn of_both(design: &CubicDesign) -> Result<Vec<Hypothesis>, CheckError> {
    Ok(vec![
        hypotheses::positive("P = P' > 0", &design.p)?,
        hypotheses::nonnegative("θ = θ' ≥ 0", &design.observer.theta)?,
        hypotheses::nonnegative("(13): S + S' ≥ 0, with N = -P⁻¹C'S", &(&design.s + design.s.transpose()))?,
        hypotheses::stable("(11), which follows from these where A - LC is stable: A - LC", &design.error_matrix())?,
    ])
}

/// A plant with poles -eps +- i, so that at A + eps I it neither grows nor decays.
fn theorem5(_: &Context) -> Result<Outcome, CheckError> {
    let eps = 0.05;
    let shift = DMatrix::identity(2, 2) * eps;
    let at_eps = oscillator(1.0)?;
    let nominal = StateSpace::new(&at_eps.a - &shift, at_eps.b.clone(), at_eps.c.clone())?;
    let linear = LinearDesign::with_poles(&nominal, &[-1.0, -2.0])?;
    let bound = theorem5_bound(&linear.p, &linear.q)?;
    if eps >= bound {
        return Err(format!("ε = {eps} is not below the bound {bound}").into());
    }
    let design = CubicDesign::new(&linear, &dmatrix![1.0], &CubicGain::Gamma(1.0))?;
    let o = &design.observer;
    let given = vec![
        hypotheses::observable(&o.a, &o.c)?,
        hypotheses::positive("(12), Q > 0", &design.q)?,
        Hypothesis::proof(
            "(9): -(F'P + PF) > 0",
            &lyapunov_decrease(
                &proof_matrix(&o.a),
                &proof_matrix(&o.l),
                &proof_matrix(&o.c),
                &proof_matrix(&design.p),
            )?,
        ),
        // For a Q that is a multiple of I this is (23).
        hypotheses::positive(
            "(23) with ε_max = 0.05, Q = I: Q - 2 ε_max P > 0",
            &(&design.q - &design.p * (2.0 * eps)),
        )?,
    ];
    Ok(readings(&design, &at_eps, "a state that does not decay")?.given(given).given(of_both(&design)?))
}

/// The matrices of the counterexample to (23) with equality, and an error that stands still: at ε = 1 the error
/// dynamics of A - LC = -I are the cubic term alone, which an error that θ does not weigh does not feel.
struct AtTheBound {
    a: DMatrix<f64>,
    c: DMatrix<f64>,
    l: DMatrix<f64>,
    n: DMatrix<f64>,
    p: DMatrix<f64>,
    q: DMatrix<f64>,
    theta: DMatrix<f64>,
    error: [f64; 2],
}

fn at_the_bound() -> AtTheBound {
    let one = DMatrix::<f64>::identity(2, 2);
    AtTheBound {
        a: -&one,
        c: one.clone(),
        l: DMatrix::zeros(2, 2),
        n: -&one,
        p: one.clone(),
        q: one * 2.0,
        theta: dmatrix![1.0, 0.0; 0.0, 0.0],
        error: [0.0, 1.0],
    }
}

/// The counterexample as a theorem for Coq.
pub(super) fn kernel() -> KernelRefutation {
    KernelRefutation {
        claim: "cubic.thm5.equality",
        file: |claim| {
            let AtTheBound { a, c, l, n, p, q, theta, error } = at_the_bound();
            let [eps, largest, least] = [theorem5_bound(&p, &q)?, lambda_max(&p)?, lambda_min(&q)?];
            let margin = lambda_min(&-(&p * &n * &c + c.transpose() * n.transpose() * &p))?;
            let error = DMatrix::from_column_slice(2, 1, &error);
            let matrices = [&a, &c, &l, &n, &p, &q, &theta, &error].map(as_printed);
            let numbers = [eps, lambda_min(&p)?, least, largest, margin].map(Number::of_decimal);
            let (
                [Some(a), Some(c), Some(l), Some(n), Some(p), Some(q), Some(theta), Some(error)],
                [Some(eps), Some(positive), Some(least), Some(largest), Some(margin)],
            ) = (&matrices, &numbers)
            else {
                return Err("not finite".into());
            };
            let data = AtEquality { a, c, l, n, p, q, theta, eps, positive, least, largest, margin, error };
            Ok(cubic_paper::equality(claim, &data))
        },
    }
}

fn equality(_: &Context) -> Result<Outcome, CheckError> {
    let AtTheBound { a, c, l, n, p, q, theta, error } = at_the_bound();
    // Small integers: no product below is rounded.
    let f = &a - &l * &c;
    let cubic_form = &p * &n * &c + c.transpose() * n.transpose() * &p;
    let eps = theorem5_bound(&p, &q)?;
    let hypotheses = vec![
        hypotheses::observable(&a, &c)?,
        hypotheses::positive("P = P' > 0", &p)?,
        Hypothesis::computed("(9): F'P + PF = -Q", f.transpose() * &p + &p * &f == -&q, "equal, in integers"),
        hypotheses::positive("(12), Q > 0", &q)?,
        hypotheses::positive("(13), as printed: -(P N C + C'N'P) > 0", &-&cubic_form)?,
        hypotheses::nonnegative("θ = θ' ≥ 0, C'θC ≥ 0", &(c.transpose() * &theta * &c))?,
        Hypothesis::computed(
            "(11)",
            true,
            "follows from (12) and (13): at an equilibrium v ≠ 0 of (7) V' would be 0, and it is at most -v'Qv",
        ),
        hypotheses::nonnegative("(23) with ε_max = 1: Q - 2 ε_max P ≥ 0", &(&q - &p * (2.0 * eps)))?,
    ];
    let at_bound = StateSpace::new(&a + DMatrix::identity(2, 2) * eps, DMatrix::zeros(2, 0), c)?;
    let observer = CubicObserver::of(at_bound.clone(), l, n, theta)?;
    let run = Scenario::new(at_bound).observer("cubic", observer, &error.map(|x| -x)).until(END, 2).run()?;
    let left = late_error(&run)?;
    Ok(Outcome::new(Evidence::counterexample(
        "from e(0) = (0, 1) the error is what is left of it at t = 60, less 1e-9",
        left - 1e-9,
        Some(Value::from(error)),
        hypotheses,
    ))
    .note(format!(
        "C = I, A - LC = -I, P = I, Q = 2 I, N = -I, θ = diag(1, 0): the bound is {}, and there e' = -e1² e, which vanishes on e1 = 0. The last line of the proof asks for the strict \
         inequality, with which the theorem holds. So it does at equality if θ > 0 and S + S' > 0 (cubic.thm5.equality-observable).",
        short(eps)
    )))
}

/// With V = |e|^2, V' = -2 e1^4: LaSalle. On average over a turn the radius r obeys r' = -3/8 r^3.
fn equality_observable(_: &Context) -> Result<Outcome, CheckError> {
    let [a, c, l] = [dmatrix![-1.0, 1.0; -1.0, -1.0], dmatrix![1.0, 0.0], DMatrix::zeros(2, 1)];
    let p = DMatrix::identity(2, 2);
    let plant = StateSpace::new(a.clone(), DMatrix::zeros(2, 0), c.clone())?;
    let linear = LinearDesign::with_gain_and_weight(&plant, &l, LyapunovWeight::Identity(2.0))?;
    let eps = theorem5_bound(&linear.p, &linear.q)?;
    if linear.p != p || eps.total_cmp(&1.0).is_ne() {
        return Err(format!("P = {} and the bound is {eps}, not I and 1", linear.p).into());
    }
    let mut observer = CubicDesign::new(&linear, &dmatrix![1.0], &CubicGain::Gamma(1.0))?.observer.clone();
    observer.a += DMatrix::identity(2, 2) * eps;
    let at_bound = StateSpace::new(observer.a.clone(), plant.b, plant.c)?;
    let times = [0.0, 60.0, 1e3, 1e4];
    let run = Scenario::new(at_bound).observer("cubic", observer, &[0.0, -1.0]).times(&times).run()?;
    let error = &run.observer("cubic")?.error;
    let sizes: Vec<f64> = error.row_iter().skip(1).map(|row| row.norm()).collect();
    // Averaging leaves an error of the size of r^2 relative to r, and no more.
    let algebraic = times[1..].iter().zip(&sizes).all(|(t, size)| {
        let averaged = 1.0 / (1.0 + 0.75 * t).sqrt();
        (size / averaged - 1.0).abs() <= averaged * averaged
    });
    Ok(Outcome::new(Evidence::holds_by(algebraic, sizes))
        .note(
            "LaSalle: V' = 0 only where y~ = 0, and no error but 0 stays there. Averaging gives |e| ≈ 1/√(1 + 3t/4), which is met to the square of it: no exponential. With N = 0, which \
             (13') admits, the error turns for ever, so that S + S' > 0 is needed.",
        )
        .given(vec![
            hypotheses::observable(&a, &c)?,
            hypotheses::positive("θ > 0", &dmatrix![1.0])?,
            hypotheses::positive("S + S' > 0 (S = γθ = 1)", &dmatrix![2.0])?,
            hypotheses::nonnegative("(23): Q - 2 ε_max P ≥ 0", &(&linear.q - &linear.p * (2.0 * eps)))?,
        ]))
}

fn tight(_: &Context) -> Result<Outcome, CheckError> {
    let design = example1::cubic()?;
    let bound = theorem5_bound(&design.p, &design.q)?;
    let (a, l) = (proof_matrix(&design.observer.a), proof_matrix(design.l()));
    let (c, p) = (proof_matrix(&design.observer.c), proof_matrix(&design.p));
    let at = |eps: f64| decay_rate(&a, &l, &c, &p, eps);
    // With P fixed: proved just below the bound, refuted just above it.
    let is_tight = at(bound * (1.0 - 1e-9))?.is_proved() && at(bound * (1.0 + 1e-9))?.is_refuted();
    let free = fixed_gain_margin(&example1::plant(), design.l(), &design.observer.n, 1e-4)?.margin;
    Ok(Outcome::new(Evidence::holds_by(is_tight && free > bound, [bound, free]))
        .note(format!("Proved below the first and refuted above it, to 1e-9, for this P and Q = ρ I. {FORCING}")))
}
