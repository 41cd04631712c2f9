//! Proposition 7 as printed, and a chirp: (42) asks excitation of b, and the estimator sees F[b].

use luenberger_observers::cascade::{Cascade, CascadeMap};
use luenberger_observers::estimator::gradient::Gradient;
use luenberger_observers::kkl_peb::KklPebObserver;
use luenberger_plants::{Plant, plant};
use luenberger_sim::{Scenario, Settings, Signal, Trajectory, solve};
use nalgebra::{DMatrix, Matrix1, U1, Vector1, Vector4};

use crate::claim::{CheckError, Claim, Class, Outcome};
use crate::context::Context;
use crate::evidence::{Counterexample, Evidence, Hypothesis};
use crate::hypotheses;
use crate::value::{Value, short};

const PLANT: &str = "x1' = -x1 + x3 + b x4, x2' = -x2 + sin x1, x3' = -3 x3 + x2 x1/(1 + x1²), x4' = 0, b = u = sin t², y = x1, from (1, 0.5, -0.5, 2)";
const START: [f64; 4] = [1.0, 0.5, -0.5, 2.0];
const END: f64 = 60.0;
const SAMPLES: usize = 601;
/// T of (42).
const WINDOW: f64 = 2.0;

pub(super) fn claim() -> Claim {
    Claim::holds(
        Class::Theorem,
        "kkl.prop7.gradient",
        "Proposition 7, (42) to (47)",
        "under (i) to (iii) the observer with the gradient estimator converges",
        &[PLANT, "α = 1, Γ = 1, all estimates from 0"],
        as_printed,
    )
    .quoting(
        "the following persistency of excitation condition is verified ∫_t^{t+T} b(s)bᵀ(s)ds ≥ δI_{n4}, (42) for all t ≥ 0 and some δ, T > 0. The system admits a [KKL+PEB]O of the form (43)-(47)",
        "(42) is of b, as printed; the estimator (47) sees ψ̂ = F[b]. \"All mappings in the paper are assumed smooth\", and b' is not assumed to be bounded",
    )
}

plant!(
    Chirped,
    (4, 1, 1),
    |plant, t, x, u| {
        let one = T::one();
        [
            x[2] - x[0] + u[0] * x[3],
            x[0].sin() - x[1],
            x[1] * x[0] / (one + x[0] * x[0]) - (one + one + one) * x[2],
            T::zero(),
        ]
    },
    [x[0]]
);

/// The plant, of the class (40).
#[derive(Clone, Copy)]
struct Chirped;

/// Its pieces.
#[derive(Clone, Copy)]
struct Pieces;

impl Cascade<f64> for Pieces {
    type Second = U1;
    type Third = U1;
    type Fourth = U1;
    type Inputs = U1;
    type Outputs = U1;

    fn a2(&self) -> Matrix1<f64> {
        Matrix1::new(-1.0)
    }

    fn a3(&self) -> Matrix1<f64> {
        Matrix1::new(-3.0)
    }

    fn k(&self) -> usize {
        0
    }

    fn f1k(&self, y: &Vector1<f64>, _x2: &Vector1<f64>, x3: &Vector1<f64>, _u: &Vector1<f64>) -> f64 {
        x3[0] - y[0]
    }

    fn f2(&self, y: &Vector1<f64>, _u: &Vector1<f64>) -> Vector1<f64> {
        Vector1::new(y[0].sin())
    }

    fn f3(&self, y: &Vector1<f64>, x2: &Vector1<f64>, _u: &Vector1<f64>) -> Vector1<f64> {
        Vector1::new(x2[0] * y[0] / (1.0 + y[0] * y[0]))
    }

    fn f4(&self, _y: &Vector1<f64>, _x2: &Vector1<f64>, _x3: &Vector1<f64>, _u: &Vector1<f64>) -> Vector1<f64> {
        Vector1::zeros()
    }

    fn b(&self, _y: &Vector1<f64>, _x2: &Vector1<f64>, _x3: &Vector1<f64>, u: &Vector1<f64>) -> Vector1<f64> {
        *u
    }
}

fn chirp(t: f64) -> f64 {
    (t * t).sin()
}

/// From this estimate of (x2, x3, x4).
fn run(estimate: [f64; 3]) -> Result<Trajectory, CheckError> {
    let observer = KklPebObserver::new(CascadeMap::new::<f64>(Pieces)?, Gradient::new(Matrix1::new(1.0))?, 1.0)?;
    Ok(Scenario::new(Chirped)
        .initial_state(&START)
        .input(Signal::scalar(chirp))
        .partial_observer("observer", observer, &estimate, &[1, 2, 3])
        .tolerances(1e-10, 1e-11)
        .until(END, SAMPLES)
        .run()?)
}

/// `int b^2` over windows, and `int F[b]^2` over the whole time: states b's integral, psi and its.
struct Integrals {
    /// The least over windows from [0, 1], by steps of a thousandth; any other such window has at most that much less.
    least: f64,
    filtered: f64,
}

fn integrals() -> Result<Integrals, CheckError> {
    let flow = |t: f64, z: &[f64], slope: &mut [f64]| {
        let b = chirp(t);
        slope.copy_from_slice(&[b * b, b - z[1], z[1] * z[1]]);
    };
    let settings = Settings { rtol: 1e-10, atol: 1e-12, ..Settings::default() };
    let run = solve(flow, 0.0, END, &[0.0; 3], &settings)?;
    let mut least = f64::INFINITY;
    for k in 0..=1000 {
        let t = f64::from(k) / 1000.0;
        least = least.min(run.at(t + WINDOW)?[0] - run.at(t)?[0]);
    }
    Ok(Integrals { least, filtered: run.at(END)?[2] })
}

/// (40) and (41): the pieces are the plant's, at points of |x_i|, |u| up to 2.
fn mismatch() -> f64 {
    let mut largest = 0.0_f64;
    for k in 1..=200 {
        let point = |i: u32| 2.0 * (f64::from(k) * f64::from(2 + i).sqrt()).sin();
        let (x, u) = (Vector4::new(point(0), point(1), point(2), point(3)), Vector1::new(point(4)));
        let f = Chirped.derivative(0.0, &x, &u);
        let (y, x2, x3) = (Vector1::new(x[0]), Vector1::new(x[1]), Vector1::new(x[2]));
        let claimed = Vector4::new(
            Pieces.f1k(&y, &x2, &x3, &u) + Pieces.b(&y, &x2, &x3, &u)[0] * x[3],
            Pieces.a2()[0] * x[1] + Pieces.f2(&y, &u)[0],
            Pieces.a3()[0] * x[2] + Pieces.f3(&y, &x2, &u)[0],
            Pieces.f4(&y, &x2, &x3, &u)[0],
        );
        largest = largest.max((f - claimed).amax());
    }
    largest
}

fn as_printed(_: &Context) -> Result<Outcome, CheckError> {
    let (zero, exact) = (run([0.0; 3])?, run([START[1], START[2], 0.0])?);
    // xhat4 - x4; the errors of a run are x - xhat.
    let left = |run: &Trajectory| run.observer("observer").map(|found| -found.error[(SAMPLES - 1, 2)]);
    let (from_zero, from_exact) = (left(&zero)?, left(&exact)?);
    let Integrals { least, filtered } = integrals()?;
    // With ∫cos 2s² over [t, t + T] at most 1/(2t), by parts: from t = 1 on δ ≥ 3/4; before, b² changes ∫ by 1 per
    // unit.
    let delta = (least - 1e-3).min(0.75);
    let apart = mismatch();
    let halves = [zero.x.rows(0, SAMPLES / 2).amax(), zero.x.rows(SAMPLES / 2, SAMPLES - SAMPLES / 2).amax()];
    let hypotheses = vec![
        Hypothesis::computed(
            "(40), (41), (i)",
            apart <= 64.0 * f64::EPSILON,
            format!("the pieces are the plant's at 200 points, to {}", short(apart)),
        ),
        hypotheses::stable("(ii) diag(A2, A3)", &DMatrix::from_diagonal(&nalgebra::dvector![-1.0, -3.0]))?,
        Hypothesis::computed(
            "(iii) bounded trajectories",
            halves[1] <= halves[0],
            format!(
                "|x_i| ≤ {} along the run, ≤ {} in its second half; |u| ≤ 1, and x1' = -x1 + x3 + 2u",
                short(halves[0]),
                short(halves[1])
            ),
        ),
        Hypothesis::computed(
            "(iii) (42), persistent excitation of b",
            delta > 0.0,
            format!(
                "T = 2, δ = {}: the integral is {} at the least over windows from [0, 1], and 1 - 1/(4t) or more after it, for all t",
                short(delta),
                short(least)
            ),
        ),
    ];
    Ok(Outcome::new(Evidence::Counterexamples(vec![Counterexample {
        case: String::new(),
        what: "|x̂4 - x4| at T = 60, less 1; it is 2 at first".to_owned(),
        violation: from_zero.abs() - 1.0,
        witness: Some(Value::Number(from_zero)),
        hypotheses,
    }]))
    .note(format!(
        "ψ = F[b] is about -cos t²/(2t), and ∫ψ² is {} at T = 60: θ̃' = -ψ²θ̃ stops. From x̂2, x̂3 right the error goes from -2 to {} = -2 exp(-∫ψ²), and stays. With (42) for F[b], which follows from (42) \
         where b' is bounded, it converges (kkl.prop7.filtered).",
        short(filtered),
        short(from_exact)
    )))
}
