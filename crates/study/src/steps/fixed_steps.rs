//! The fixed number of Runge-Kutta steps that an exported step takes in a period: how many are needed, and what their
//! error is.
//!
//! Measured along a run without noise: the plant of the study from its start under its input, seen by the observer from
//! its first estimate on, for at most [`MOST_SAMPLES`] samples. At each of them the fixed steps and a reference start
//! from the same state. Of a filter the reference is its prediction with control of the error, and the difference is
//! counted in standard deviations, of the covariance in products of two. Of the other observers it is twice as many
//! steps, and the difference is counted in parts of the largest change of a state's estimate in a period.

use luenberger_expression::ExpressionPlant;
use luenberger_observers::{
    CovarianceFilter, ExtendedKalmanFilter, NoiseModel, ObserverError, Prediction, SampledObserver,
};
use luenberger_plants::{Differentiable, Plant};
use luenberger_proof::wording::{at_most, counted, significant};
use nalgebra::{DMatrix, DVector, Dyn};

use crate::results::NoObserver;
use crate::study::{ObserverSpec, Study};

/// Samples of the run.
const MOST_SAMPLES: usize = 200;

/// A prediction of a filter may be wrong by this share of the standard deviation.
pub(super) const SHARE: f64 = 1e-3;

/// A number of steps that is given may make it wrong by so much.
const MOST_SHARE: f64 = 0.1;

/// Steps per period beyond which a design is refused.
pub(super) const MOST_SUBSTEPS: usize = 100;

/// A filter with a fixed number of steps, and their error as a sentence.
pub(super) struct FixedSteps<F> {
    pub(super) filter: F,
    pub(super) sentence: String,
}

/// Inputs and outputs of the run without noise, sample by sample.
fn run(
    study: &Study,
    observer: &ObserverSpec,
    plant: &ExpressionPlant,
    period: f64,
) -> Vec<(DVector<f64>, DVector<f64>)> {
    let (n, p) = (study.plant.states.len(), study.plant.outputs.len());
    let (start, duration) = match &study.simulation {
        Some(simulation) => (simulation.x0.clone(), simulation.duration),
        None => (observer.initial.clone(), period * MOST_SAMPLES as f64),
    };
    let count = ((duration / period).floor() as usize).clamp(1, MOST_SAMPLES);
    let noises = NoiseModel { w: DMatrix::zeros(n, n), v: DMatrix::identity(p, p), p0: DMatrix::zeros(n, n) };
    let Ok(truth) = ExtendedKalmanFilter::error_controlled(plant.clone(), noises, period) else { return Vec::new() };
    let input = |k: usize| {
        let mut u = DVector::zeros(study.plant.inputs.len());
        if let Some(program) = study.input.program() {
            program.at(period * k as f64, u.as_mut_slice());
        }
        u
    };
    let mut x = truth.initial(0.0, &DVector::from_vec(start), &input(0), &DVector::zeros(p));
    let mut samples = Vec::new();
    for k in 0..count {
        let (t, u) = (period * k as f64, input(k));
        let y: DVector<f64> = plant.output(t, &x.estimate(), &u);
        if y.iter().any(|y| !y.is_finite()) {
            break;
        }
        let is_moved = truth.predict(t, &mut x, &u, period);
        samples.push((u, y));
        if !is_moved {
            break;
        }
    }
    samples
}

/// Where a filter is after the measurement of a sample, and where its prediction leads.
struct Passage<S> {
    t: f64,
    u: DVector<f64>,
    state: S,
    estimate: DVector<f64>,
    covariance: DMatrix<f64>,
}

/// The Runge-Kutta steps of a filter: as many as are given, or as its error needs.
pub(super) fn of_filter<F>(
    (study, observer): (&Study, &ObserverSpec),
    plant: &ExpressionPlant,
    filter: &F,
    with: impl Fn(&F, Prediction) -> Result<F, ObserverError>,
    given: Option<usize>,
) -> Result<FixedSteps<F>, NoObserver>
where
    F: CovarianceFilter<f64, Input = DVector<f64>, Output = DVector<f64>, Estimate = DVector<f64>>,
    F::State: Clone,
{
    let (period, n) = (filter.period(), plant_order(plant));
    let made = |prediction| with(filter, prediction);
    let controlled = made(Prediction::ErrorControlled)?;
    let samples = run(study, observer, plant, period);
    let found = |state: &F::State| {
        let mut p = DMatrix::zeros(n, n);
        controlled.covariance_into(state, p.as_mut_slice());
        (controlled.estimate(state), p)
    };
    let mut passages = Vec::new();
    let mut state = None;
    for (k, (u, y)) in samples.into_iter().enumerate() {
        let t = period * k as f64;
        let at = state
            .get_or_insert_with(|| controlled.initial(0.0, &DVector::from_column_slice(&observer.initial), &u, &y));
        controlled.measure(t, at, &u, &y, &[]);
        let before = at.clone();
        if !controlled.advance(t, at, &u, period) {
            break;
        }
        let (estimate, covariance) = found(at);
        passages.push(Passage { t, u, state: before, estimate, covariance });
    }
    if passages.is_empty() {
        let hypothesis = "the error of a fixed number of Runge-Kutta steps cannot be measured: from the first estimate and the start of the plant the prediction of the first period has no result";
        return Err(
            NoObserver::new(hypothesis).hint("a first estimate and an x0 where f, h and their Jacobians are finite")
        );
    }
    let error = |substeps: usize| -> Result<f64, NoObserver> {
        let fixed = made(Prediction::RungeKutta(substeps))?;
        Ok(passages.iter().fold(0.0, |most: f64, passage| {
            let mut state = passage.state.clone();
            if !fixed.advance(passage.t, &mut state, &passage.u, period) {
                return f64::INFINITY;
            }
            let (estimate, covariance) = found(&state);
            let before = controlled.estimate(&passage.state);
            let error = in_deviations(passage, &before, &estimate, &covariance);
            if error <= most { most } else { error }
        }))
    };
    let fastest = || {
        passages.iter().fold(0.0, |fastest: f64, passage| {
            let x = controlled.estimate(&passage.state);
            let jacobian: DMatrix<f64> = plant.state_jacobian(passage.t, &x, &passage.u);
            jacobian.complex_eigenvalues().iter().fold(fastest, |fastest, mode| fastest.max(mode.norm()))
        })
    };
    let refused = |what: String| {
        let h = significant(fastest() * period, 3);
        let hypothesis = format!("{what}; |lambda| h = {h} of the fastest mode of the plant over the period {period}");
        NoObserver::new(hypothesis)
            .hint(format!("a period of {} or shorter", significant(2.0 / fastest(), 2)))
            .hint("a plant without its fastest mode: what follows at once is no state")
    };
    let counts = [1, 2, 4, 8, 16, 32, 64, MOST_SUBSTEPS];
    let substeps = if let Some(substeps) = given {
        substeps
    } else {
        let mut enough = None;
        for count in counts {
            if error(count)? <= SHARE {
                enough = Some(count);
                break;
            }
        }
        enough.ok_or_else(|| {
            refused(format!(
                "more than {MOST_SUBSTEPS} Runge-Kutta steps per period would be needed for an error below {SHARE} standard deviations"
            ))
        })?
    };
    let error = error(substeps)?;
    let is_right = error <= MOST_SHARE;
    if !is_right {
        let most = if error.is_finite() {
            format!("an error of {} standard deviations", significant(error, 2))
        } else {
            "no result".to_owned()
        };
        return Err(refused(format!("a prediction with {} has {most}", counted(substeps, "Runge-Kutta step"))));
    }
    let sentence = format!(
        "A prediction takes {} of the Runge-Kutta method; along {} of a run without noise its error was measured: at most {} standard deviations.",
        counted(substeps, "step"),
        counted(passages.len(), "sample"),
        at_most(error, 2),
    );
    Ok(FixedSteps { filter: made(Prediction::RungeKutta(substeps))?, sentence })
}

fn plant_order(plant: &ExpressionPlant) -> usize {
    luenberger_plants::Shape::dimensions(plant).states
}

/// The largest error of a prediction, in standard deviations; where these are zero, in thousandths of the change.
fn in_deviations<S>(
    exact: &Passage<S>,
    before: &DVector<f64>,
    estimate: &DVector<f64>,
    covariance: &DMatrix<f64>,
) -> f64 {
    let deviation = exact.covariance.diagonal().map(|variance| variance.max(0.0).sqrt());
    let mut most = 0.0f64;
    let mut count = |error: f64, scale: f64| {
        let share = if error == 0.0 { 0.0 } else { error.abs() / scale };
        most = if share <= most { most } else { share };
    };
    for i in 0..estimate.len() {
        let rounding = 1e4 * f64::EPSILON * (exact.estimate[i].abs() + before[i].abs());
        let change = 1e-3 * (exact.estimate[i] - before[i]).abs();
        count(estimate[i] - exact.estimate[i], deviation[i].max(change).max(rounding));
        for j in 0..=i {
            let scale = deviation[i] * deviation[j];
            if scale > 0.0 {
                count(covariance[(i, j)] - exact.covariance[(i, j)], scale);
            }
        }
    }
    most
}

/// What the error of a step is, of an observer whose steps are `coarse`, against twice as many.
pub(super) fn sentence<O>(
    (study, observer): (&Study, &ObserverSpec),
    plant: &ExpressionPlant,
    (coarse, fine): (&O, &O),
    (substeps, initial): (usize, &[f64]),
) -> String
where
    O: SampledObserver<f64, Input = DVector<f64>, Output = DVector<f64>, Estimate = DVector<f64>>,
    O::State: Clone,
{
    let period = coarse.period();
    let samples = run(study, observer, plant, period);
    let n = plant_order(plant);
    let mut state = None;
    let (mut errors, mut changes) = (DVector::<f64>::zeros(n), DVector::<f64>::zeros(n));
    let count = samples.len();
    for (k, (u, y)) in samples.into_iter().enumerate() {
        let t = period * k as f64;
        let at = state.get_or_insert_with(|| coarse.initial(0.0, &DVector::from_column_slice(initial), &u, &y));
        let before = coarse.estimate(at);
        let mut better = at.clone();
        coarse.step(t, at, &u, &y);
        fine.step(t, &mut better, &u, &y);
        let (one, other) = (coarse.estimate(at), fine.estimate(&better));
        for i in 0..n.min(one.len()) {
            // Of a method of order 4.
            errors[i] = larger(errors[i], (one[i] - other[i]).abs() * 16.0 / 15.0);
            changes[i] = larger(changes[i], (other[i] - before[i]).abs());
        }
    }
    let worst = errors
        .iter()
        .zip(changes.iter())
        .fold(0.0, |most: f64, (error, change)| larger(most, if *error == 0.0 { 0.0 } else { error / change }));
    let how = format!(
        "A step takes {} of the Runge-Kutta method; along {} of a run without noise its error was measured",
        counted(substeps, "step"),
        counted(count, "sample"),
    );
    if count == 0 {
        return format!(
            "A step takes {} of the Runge-Kutta method; its error was not measured: h is not finite at the start of the run.",
            counted(substeps, "step")
        );
    }
    if worst.is_finite() {
        format!("{how}: at most {} of the largest change of an estimate in a period.", at_most(worst, 2))
    } else {
        format!("{how}, and is not finite.")
    }
}

/// The larger number; what is no number is larger than every number.
fn larger(x: f64, y: f64) -> f64 {
    if y <= x { x } else { y }
}

/// The plant with its inputs held over a period, as one in discrete time, and the covariance of its noise, if its
/// motion is affine: `x+ = Phi x + ...` is exact.
pub(super) fn discretised(
    plant: &ExpressionPlant,
    w: &DMatrix<f64>,
    period: f64,
) -> Option<(ExpressionPlant, DMatrix<f64>)> {
    let (a, b, f0) = plant.affine_motion()?;
    let exact = luenberger_observers::transition::ExactDiscretisation::<f64, Dyn>::new(&a, w, period);
    let (b, c) = (&exact.integral * b, &exact.integral * f0);
    let entries = [exact.phi.as_slice(), b.as_slice(), c.as_slice(), exact.noise.as_slice()];
    if entries.into_iter().flatten().any(|entry| !entry.is_finite()) {
        return None;
    }
    let sampled = plant.with_motion(&exact.phi, &b, &c).ok()?;
    Some((sampled, exact.noise))
}
