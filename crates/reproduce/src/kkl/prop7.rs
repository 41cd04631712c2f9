//! Proposition 7: a plant of the class with two parameters; comparison of the gradient estimator with DREM.

use std::f64::consts::PI;
use std::sync::Arc;

use crate::kkl::driven_cascade;
use luenberger_linalg::spectral_radius;
use luenberger_observers::cascade::CascadeMap;
use luenberger_observers::estimator::drem::{Drem, Kreisselmeier, LtiFilters};
use luenberger_observers::estimator::excitation::Monitored;
use luenberger_observers::estimator::gradient::Gradient;
use luenberger_observers::kkl_peb::KklPebObserver;
use luenberger_observers::{Diagnose, Diagnosis, Observer, ObserverError};
use luenberger_plants::{Column, DrivenCascade};
use luenberger_sim::{Scenario, Settings, Signal, SimError, Trajectory, solve};
use nalgebra::{DMatrix, Matrix2, SVector, U1, U2, Vector1, Vector2};

use crate::claim::{CheckError, Claim, Class, Outcome};
use crate::context::Context;
use crate::evidence::{Evidence, Hypothesis};
use crate::figure::{Dash, Figure, Hue, Panel, Series};
use crate::paper::{Drawing, Plate};
use crate::table::Table;
use crate::value::{Value, short};

const PLANT: &str = "x11' = -x11 + x3 + b'x4, x12' = -2 x12 + x2, x2' = -x2 + sin x12, x3' = -3 x3 + x2 x11, x4' = -b x11/2, b = u, y = (x11, x12)";
const EXCITED: &str = "u = (sin 2t, 1), for which (42) holds with T = π, δ = π/2; x(0) = (1, -1, 0.5, -0.5, 2, -1), α = 5, the estimates from 0";
const STARTED: &str = "x̂2 and x̂3 begin right, so that the regression is exact and nothing but the estimators is seen";

const START: [f64; 6] = [1.0, -1.0, 0.5, -0.5, 2.0, -1.0];
const ALPHA: f64 = 5.0;
/// Gamma of the gradient estimator, times I.
const GAIN: f64 = 2.0;
const END: f64 = 30.0;
/// Every 0.05.
const SAMPLES: usize = 601;
const GRADIENT: &str = "gradient";
const FILTERS: &str = "DREM, filters";
const KREISSELMEIER: &str = "DREM, Kreisselmeier";
const NAMES: [&str; 3] = [GRADIENT, FILTERS, KREISSELMEIER];
/// x2, x3, x4 in the state of the plant.
const UNMEASURED: [usize; 4] = [2, 3, 4, 5];
/// A hundred times the relative tolerance of the runs per step, which errors that decay forget.
const INTEGRATION: f64 = 1e-10;

pub(super) fn claims() -> Vec<Claim> {
    vec![
        super::chirp::claim(),
        Claim::holds(
            Class::Ours,
            "kkl.prop7.filtered",
            "beyond the paper: Proposition 7, (42) for F[b]",
            "with (42) for the filtered regressor ψ = F[b], which follows from (42) for b where b' is bounded, the observer with the gradient estimator converges (|x̂ - x| of x2, x3, x4 at T = 30)",
            &[PLANT, EXCITED, "Γ = 2 I"],
            gradient,
        ),
        Claim::holds(
            Class::Misprint,
            "kkl.prop7.error-equation",
            "proof of Proposition 7",
            "θ̃' = Γ ψ̂ ψ̂' θ̃",
            &[PLANT, EXCITED, STARTED, "Γ = 2 I"],
            error_equation,
        )
        .quoting(
            "θ̃' = Γ ψ̂ ψ̂ᵀ θ̃",
            "along the estimator (47), with θ̃ := θ̂ - θ as printed after it; θ - θ̂ would obey the same equation",
        ),
        Claim::holds(
            Class::Theorem,
            "kkl.prop7.drem",
            "remarks to Proposition 7",
            "DREM can replace the gradient estimator, and converges without (42), each parameter monotonically",
            &[
                PLANT,
                STARTED,
                "u = (sin 2t, 1), and the same times (1 + t)^(-1/8) and (1 + t)^(-1/2), which violate (42); x(0) and α as with excitation",
                "extension by the filter 1/(p + 1) with γ = 200, and Kreisselmeier's with a = 0.5, γ = 10; T = 30, for the last input 300",
            ],
            drem,
        )
        .quoting(
            "it is possible to replace this estimator with the high-performance dynamic regressor extension and mixing proposed in [3], see also [16]. As shown in these papers the parameter convergence is \
             ensured without the often restrictive, persistent excitation condition (42).",
            "without (42): DREM needs Δ ∉ L2, which some inputs that violate (42) give, and others do not",
        ),
        Claim::holds(
            Class::Ours,
            "kkl.prop7.not-exciting",
            "beyond the paper: Proposition 7, (iii)",
            "with an input that violates (42) θ is not found (error of x4 at T = 30, and the excitation that the observer reports)",
            &[PLANT, "u = (1, 0), otherwise as with excitation"],
            not_exciting,
        ),
    ]
}

type Observed<E> = KklPebObserver<CascadeMap<driven_cascade::Pieces>, E, f64>;
type Monitor = Monitored<f64, Gradient<f64, U2>>;
type WithFilters = Drem<f64, U2, LtiFilters<f64, U1>>;

fn with_gradient() -> Result<Observed<Monitor>, ObserverError> {
    let estimator = Monitored::new(Gradient::new(Matrix2::identity() * GAIN)?, 0.0)?;
    Ok(KklPebObserver::new(CascadeMap::new::<f64>(driven_cascade::Pieces)?, estimator, ALPHA)?.wanting_excitation(1.0))
}

fn with_filters() -> Result<Observed<WithFilters>, ObserverError> {
    let estimator = Drem::new(Vector2::repeat(200.0), LtiFilters::new(Vector1::new(1.0))?)?;
    KklPebObserver::new(CascadeMap::new::<f64>(driven_cascade::Pieces)?, estimator, ALPHA)
}

fn with_kreisselmeier() -> Result<Observed<Drem<f64, U2, Kreisselmeier<f64>>>, ObserverError> {
    let estimator = Drem::new(Vector2::repeat(10.0), Kreisselmeier::new(0.5)?)?;
    KklPebObserver::new(CascadeMap::new::<f64>(driven_cascade::Pieces)?, estimator, ALPHA)
}

/// The three observers from this estimate of (x2, x3, x4), under this input.
fn observe(estimate: &[f64; 4], input: Signal<'_>) -> Result<Trajectory, CheckError> {
    Ok(Scenario::new(DrivenCascade)
        .initial_state(&START)
        .input(input)
        .partial_observer(GRADIENT, with_gradient()?, estimate, &UNMEASURED)
        .partial_observer(FILTERS, with_filters()?, estimate, &UNMEASURED)
        .partial_observer(KREISSELMEIER, with_kreisselmeier()?, estimate, &UNMEASURED)
        .tolerances(1e-12, 1e-13)
        .until(END, SAMPLES)
        .run()?)
}

struct Runs {
    /// x2hat and x3hat from 0.
    zero: Trajectory,
    /// x2hat and x3hat right from the start.
    exact: Trajectory,
}

fn runs(context: &Context) -> Result<Arc<Runs>, CheckError> {
    context.once("kkl.prop7", || {
        let exciting = || Signal::function(|t, u| (u[0], u[1]) = ((2.0 * t).sin(), 1.0));
        Ok(Runs { zero: observe(&[0.0; 4], exciting())?, exact: observe(&[START[2], START[3], 0.0, 0.0], exciting())? })
    })
}

/// The size of theta~_i = x4hat_i - x4_i along a run.
fn parameter_error(run: &Trajectory, name: &str, parameter: usize) -> Result<Vec<f64>, SimError> {
    Ok(run.observer(name)?.error.column(2 + parameter).iter().map(|e| e.abs()).collect())
}

/// By how much the sequence ever exceeds what it was before.
fn rise(sizes: &[f64]) -> f64 {
    let (mut least, mut rise) = (f64::INFINITY, 0.0_f64);
    for &size in sizes {
        least = least.min(size);
        rise = rise.max(size - least);
    }
    rise
}

fn gradient(context: &Context) -> Result<Outcome, CheckError> {
    let runs = runs(context)?;
    let found = runs.zero.observer(GRADIENT)?;
    let (first, last) = (found.error.row(0).amax(), found.error.row(SAMPLES - 1));
    let state = SVector::from_fn(|i, _| found.state[(SAMPLES - 1, i)]);
    let excitation = with_gradient()?.excitation(&state).ok_or("the observer reports no excitation")?;
    let multiplier = floquet_multiplier(GAIN)?;
    let rate = |gain: f64| floquet_multiplier(gain).map(|multiplier| short(-multiplier.ln() / PI));
    let size = |t: f64| -> Result<f64, SimError> {
        Ok(runs.zero.error_trace(GRADIENT, 2)?.at(t)?.hypot(runs.zero.error_trace(GRADIENT, 3)?.at(t)?))
    };
    let claimed = multiplier.powi(5);
    let found_ratio = size(END)? / size(END - 5.0 * PI)?;
    // At T - 5π = 14 the errors of x2 and x3, e^-14, are a ten-thousandth of those of the parameters, and the second
    // multiplier has had four periods.
    let holds = multiplier < 1.0 && (found_ratio / claimed - 1.0).abs() < 0.02;
    Ok(Outcome::new(Evidence::holds_by(holds, last.iter().map(|e| e.abs()).collect::<Vec<_>>())).note(format!(
        "The largest error at the start is {}. θ̃' = -Γψψ'θ̃ has the largest Floquet multiplier {}, less than 1: exponential convergence, at the rate {}; over the last five periods the errors \
         of the run shrink by {} where that says {}. A larger Γ is not faster: the rate is {} for Γ = 20 I. The smallest eigenvalue of ∫ψψ' dt is {} or more at the end.",
        short(first),
        short(multiplier),
        rate(GAIN)?,
        short(found_ratio),
        short(claimed),
        rate(20.0)?,
        short(excitation)
    )))
}

/// The largest Floquet multiplier of `theta~' = -gain psi psi' theta~` over the period π, for the psi = F[b] to which
/// the filters tend.
pub(super) fn floquet_multiplier(gain: f64) -> Result<f64, CheckError> {
    // F[sin 2t] = (alpha/|alpha + 2i|) sin(2t - arg(alpha + 2i)), F[1] = 1.
    let (size, angle) = (ALPHA / ALPHA.hypot(2.0), 2.0_f64.atan2(ALPHA));
    let flow = |t: f64, x: &[f64], slope: &mut [f64]| {
        let psi = [size * (2.0 * t - angle).sin(), 1.0];
        for (x, slope) in x.chunks(2).zip(slope.chunks_mut(2)) {
            let seen = psi[0] * x[0] + psi[1] * x[1];
            (slope[0], slope[1]) = (-gain * psi[0] * seen, -gain * psi[1] * seen);
        }
    };
    let columns = solve(flow, 0.0, PI, &[1.0, 0.0, 0.0, 1.0], &Settings::default())?.at(PI)?;
    Ok(spectral_radius(&DMatrix::from_column_slice(2, 2, &columns))?)
}

/// theta~, psi and d theta_hat/dt of the gradient estimator at sample k of a run.
fn rates(run: &Trajectory, k: usize) -> Result<[Vector2<f64>; 3], CheckError> {
    let (observer, found) = (with_gradient()?, run.observer(GRADIENT)?);
    let state = SVector::from_fn(|i, _| found.state[(k, i)]);
    let row = |matrix: &DMatrix<f64>| Vector2::new(matrix[(k, 0)], matrix[(k, 1)]);
    let slope = observer.derivative(run.t[k], &state, &row(&run.u), &row(&run.y));
    let parts = observer.parts(&state);
    // xi (4), w, F[g], psi (2), theta_hat (2).
    let error = Vector2::new(-found.error[(k, 2)], -found.error[(k, 3)]);
    Ok([error, parts.regressor.transpose(), Vector2::new(slope[8], slope[9])])
}

fn error_equation(context: &Context) -> Result<Outcome, CheckError> {
    let runs = runs(context)?;
    let (mut printed, mut corrected, mut witness) = (0.0_f64, 0.0_f64, Vector2::zeros());
    for k in 0..SAMPLES {
        let [error, psi, rate] = rates(&runs.exact, k)?;
        let claimed = psi * (GAIN * psi.dot(&error));
        if (rate - claimed).amax() > printed {
            (printed, witness) = ((rate - claimed).amax(), error);
        }
        corrected = corrected.max((rate + claimed).amax());
    }
    // With the minus sign the two sides differ by what the run is wrong by.
    let bound = GAIN * INTEGRATION * 10.0;
    if corrected > bound {
        return Err(format!("θ̂' differs from -Γψψ'θ̃ by {}, more than {}", short(corrected), short(bound)).into());
    }
    Ok(Outcome::new(Evidence::counterexample(
        "θ̃' = Γ ψ ψ' θ̃ along the run",
        printed - bound,
        Some(Value::from([witness[0], witness[1]])),
        vec![
            Hypothesis::computed("(42), persistent excitation", floquet_multiplier(GAIN)? < 1.0, "the largest Floquet multiplier of -Γψψ' over its period is below 1"),
            Hypothesis::computed("the regression is exact", corrected <= bound, format!("θ̂' = -Γψψ'θ̃ to {}", short(corrected))),
        ],
    ))
    .note(format!(
        "A minus sign is missing: θ̃' = -Γ ψ ψ' θ̃ holds along the whole run to {}. As printed no error could ever decrease.",
        short(corrected)
    )))
}

/// The largest share of a parameter's error that DREM leaves by `end`, with either extension, and the gradient
/// estimator's; u is that with excitation times `(1 + t)^-power`.
fn decaying(power: f64, end: f64) -> Result<[f64; 3], CheckError> {
    let input = Signal::function(move |t, u| {
        let size = (1.0 + t).powf(-power);
        (u[0], u[1]) = (size * (2.0 * t).sin(), size);
    });
    let estimate = [START[2], START[3], 0.0, 0.0];
    let run = Scenario::new(DrivenCascade)
        .initial_state(&START)
        .input(input)
        .partial_observer(GRADIENT, with_gradient()?, &estimate, &UNMEASURED)
        .partial_observer(FILTERS, with_filters()?, &estimate, &UNMEASURED)
        .partial_observer(KREISSELMEIER, with_kreisselmeier()?, &estimate, &UNMEASURED)
        .tolerances(1e-11, 1e-12)
        .until(end, 2)
        .run()?;
    let left = |name: &str| -> Result<f64, CheckError> {
        let mut share = 0.0_f64;
        for parameter in 0..2 {
            let error = parameter_error(&run, name, parameter)?;
            share = share.max(error[1] / error[0]);
        }
        Ok(share)
    };
    Ok([left(FILTERS)?, left(KREISSELMEIER)?, left(GRADIENT)?])
}

fn drem(context: &Context) -> Result<Outcome, CheckError> {
    let runs = runs(context)?;
    let (mut excited, mut largest, mut highest) = (true, 0.0_f64, 0.0_f64);
    for name in [FILTERS, KREISSELMEIER] {
        for parameter in 0..2 {
            let from_zero = parameter_error(&runs.zero, name, parameter)?;
            let exact = parameter_error(&runs.exact, name, parameter)?;
            let left = from_zero[SAMPLES - 1].max(exact[SAMPLES - 1]);
            // Gains of 10 and 200 are moderate for Delta² of a hundredth: a thousandth of the start within the run.
            excited &= left <= 1e-3 * exact[0] && rise(&exact) <= INTEGRATION;
            (largest, highest) = (largest.max(left), highest.max(rise(&exact)));
        }
    }
    let gradient =
        rise(&parameter_error(&runs.exact, GRADIENT, 0)?).max(rise(&parameter_error(&runs.exact, GRADIENT, 1)?));
    let (slow, fast) = (decaying(0.125, END)?, decaying(0.5, 10.0 * END)?);
    let converges = |[filters, kreisselmeier, _]: [f64; 3]| Value::Truth(filters.max(kreisselmeier) <= 1e-3);
    Ok(Outcome::new(Evidence::Readings(vec![
        ("(42) holds", Value::Truth(excited)),
        ("(42) fails, b decays as (1 + t)^(-1/8): Δ ∉ L2", converges(slow)),
        ("(42) fails, b decays as (1 + t)^(-1/2): Δ ∈ L2", converges(fast)),
    ]))
    .instances(6)
    .note(format!(
        "With excitation the largest error left is {} and the largest rise {}, where with the gradient estimator a parameter's error rises by {}. Δ decays as the square of b with the filters, and as its \
         fourth power with Kreisselmeier's extension. Left of the errors are, with the filters, Kreisselmeier's and the gradient: {}, {} and {} for the slow decay at 30; {}, {} and {} for the fast one at \
         300, where Kreisselmeier's stands still and the gradient estimator, which needs b ∉ L2 in every direction, goes on.",
        short(largest),
        short(highest),
        short(gradient),
        short(slow[0]),
        short(slow[1]),
        short(slow[2]),
        short(fast[0]),
        short(fast[1]),
        short(fast[2])
    )))
}

fn not_exciting(_: &Context) -> Result<Outcome, CheckError> {
    let run = observe(&[0.0; 4], Signal::constant(&[1.0, 0.0]))?;
    let (observer, last) = (with_gradient()?, SAMPLES - 1);
    let found = run.observer(GRADIENT)?;
    let state = <Observed<Monitor> as Observer<f64>>::State::from_slice(
        found.state.row(last).iter().copied().collect::<Vec<_>>().as_slice(),
    );
    let row = |matrix: &DMatrix<f64>| Vector2::new(matrix[(last, 0)], matrix[(last, 1)]);
    let said = observer.diagnose(END, &state, &row(&run.u), &row(&run.y));
    let Diagnosis::NotExciting { excitation, wanted } = said else {
        return Err(format!("without excitation the observer says {said:?}").into());
    };
    let stays = |name: &str| -> Result<f64, CheckError> {
        let error = parameter_error(&run, name, 1)?;
        Ok(error.iter().map(|e| (e - error[0]).abs()).fold(0.0, f64::max))
    };
    let moved = stays(GRADIENT)?.max(stays(FILTERS)?).max(stays(KREISSELMEIER)?);
    let seen = parameter_error(&run, GRADIENT, 0)?;
    let error = [found.error[(last, 2)].abs(), found.error[(last, 3)].abs(), excitation];
    Ok(Outcome::new(Evidence::holds_by(moved <= INTEGRATION && seen[last] <= 1e-6 * seen[0], error)).note(format!(
        "The second parameter is not seen: its error moves by {} with each of the three estimators. The observer reports that its excitation is {excitation}, where {wanted} was asked \
         for.",
        short(moved)
    )))
}

pub(super) fn figures() -> Vec<Drawing> {
    vec![Drawing { id: "kkl-prop7", draw: parameters }]
}

fn parameters(context: &Context) -> Result<Plate, CheckError> {
    let runs = runs(context)?;
    let t = runs.exact.t.clone();
    let mut figure = Figure::new("Proposition 7: the gradient estimator and DREM").caption(
        "Errors of the two parameters. From an exact regression those of DREM decrease monotonically, one by one; those of the gradient estimator together only, so that one may \
         overshoot on the way. Γ = 2 I, about the best there is; DREM with γ = 200 (filters) and 10 (Kreisselmeier), whose Δ is of a smaller scale.",
    );
    let mut data = Table::new().column("t", t.clone());
    for parameter in 0..2 {
        let mut panel =
            Panel::new("time t", format!("error of {}", ["θ₁", "θ₂"][parameter])).log_y().y_range(1e-8, 5.0);
        for (place, (name, short)) in NAMES.into_iter().zip(["gradient", "filters", "kreisselmeier"]).enumerate() {
            let error: Vec<f64> =
                parameter_error(&runs.exact, name, parameter)?.into_iter().map(|e| e.max(1e-10)).collect();
            let dash = [Dash::Solid, Dash::Dashed, Dash::DashDotted][place];
            panel = panel.series(Series::line(name, &t, &error).hue(Hue::Palette(place)).dash(dash));
            data = data.column(format!("theta{}_{short}", parameter + 1), error);
        }
        figure = figure.panel(panel);
    }
    Ok(Plate { figure, data })
}
