//! Whole runs: of a study's kind (plant in expressions, observers, feedback, noise, scores).
//!
//! ```text
//! runs ekf 100 20       {"us": least time of a run in 20 rounds of 100, "end": [state and estimate at the end]}
//! ```
//! - `ekf`, `lpv`: the example study `cart-pole` with its extended Kalman filter in the loop, and its LPV observer.
//! - `held`: Example 1's plant and linear observer with the input held and noise at 100 Hz, which is exact;
//!   `integrated`: the same with an integral, so that it is integrated.
//! - `noise`: the noise of those, one row per sample.
use luenberger_expression::{ExpressionPlant, Parameters};
use luenberger_observers::{ExtendedKalmanFilter, LinearObserver, NoiseModel, NonlinearLuenbergerObserver};
use luenberger_plants::double_integrator;
use luenberger_sim::{Errors, Integrand, Noise, Purpose, Scenario, ScoreGrid, Signal, SimError};
use nalgebra::{Const, DMatrix, DVector, Vector2};
use serde_json::json;
use std::error::Error;
use std::hint::black_box;
use std::time::Instant;

/// Cart and pendulum of the example study `cart-pole`.
fn cart_pole() -> Result<ExpressionPlant, Box<dyn Error>> {
    let parameters = [("M", 0.5), ("m", 0.2), ("b", 0.1), ("I", 0.006), ("g", 9.81), ("l", 0.3)];
    let parameters: Parameters = parameters.map(|(name, value)| (name.to_owned(), value)).into();
    let f = [
        "x2",
        "((I + m*l^2)*(u1 - b*x2 - m*l*x4^2*sin(x3)) + m^2*l^2*g*sin(x3)*cos(x3))/((M + m)*(I + m*l^2) - m^2*l^2*cos(x3)^2)",
        "x4",
        "((M + m)*m*g*l*sin(x3) + m*l*cos(x3)*(u1 - b*x2 - m*l*x4^2*sin(x3)))/((M + m)*(I + m*l^2) - m^2*l^2*cos(x3)^2)",
    ];
    Ok(ExpressionPlant::new(&f, &["x1", "x3"], 1, &parameters)?)
}

/// The gain of the study's LPV observer, to six digits.
const GAIN: [f64; 8] = [23.7061, 0.0299409, 145.062, -1.65731, -0.0492469, 41.6805, -5.30579, 306.7];

/// Its amplitudes of the noise.
const NOISE: [f64; 2] = [0.0005, 0.001];

fn run(plant: &ExpressionPlant, lpv: bool, seed: u64) -> Result<Vec<f64>, Box<dyn Error>> {
    let diagonal = |entries: &[f64]| DMatrix::from_diagonal(&DVector::from_column_slice(entries));
    let noises = NoiseModel {
        w: diagonal(&[1e-6, 1e-3, 1e-6, 1e-3]),
        v: diagonal(&[2.5e-7, 1e-6]),
        p0: diagonal(&[1e-4, 0.01, 0.01, 0.1]),
    };
    let filter = ExtendedKalmanFilter::new(plant.clone(), noises, 0.01, 4)?;
    let observer = NonlinearLuenbergerObserver::new(plant.clone(), DMatrix::from_row_slice(4, 2, &GAIN))?;
    let gain = DMatrix::from_row_slice(1, 4, &[-70.7107, -37.8345, 105.5298, 20.9238]);
    let times: Vec<f64> = (0..=400).map(|k| f64::from(k) * 0.01).collect();
    let mut scenario = Scenario::new(plant)
        .initial_state(&[0.0, 0.0, 0.1, 0.0])
        .times(&times)
        .input(Signal::feedback("ekf", gain))
        .hold_input(0.01)
        .noise(Noise::uniform(&NOISE, 0.01, seed))
        .sampled_observer("ekf", &filter, &[0.0; 4]);
    if lpv {
        scenario = scenario.observer("lpv", &observer, &[0.0; 4]);
    }
    let trajectory = scenario.run()?;
    let name = if lpv { "lpv" } else { "ekf" };
    let errors = Errors::of(&trajectory, name, ScoreGrid::Samples { period: 0.01 })?;
    let scores = errors.states()?;
    let norm = errors.norm(Some(&[2.0, 4.0, 1.0, 6.0]), 0.05)?;
    let mut outside = 0;
    if lpv {
        let count = |_: f64, x: &[f64], u: &[f64], xhat: &[f64]| {
            outside += u32::from(x[2].abs() > 0.5 || xhat[2].abs() > 0.5 || u[0].abs() > 30.0);
        };
        trajectory.visit(name, count)?;
    }
    black_box((scores, norm, outside));
    let last = trajectory.t.len() - 1;
    let estimate = &trajectory.observer(name).map_err(|error: SimError| error)?.estimate;
    let end = trajectory.x.row(last).iter().chain(estimate.row(last).iter()).copied().collect();
    Ok(end)
}

/// A linear run between samples of the input.
fn held(
    observer: &LinearObserver<f64, Const<2>, Const<1>, Const<1>>,
    integrated: bool,
) -> Result<Vec<f64>, Box<dyn Error>> {
    let times: Vec<f64> = (0..=400).map(|k| f64::from(k) * 0.01).collect();
    let mut scenario = Scenario::new(double_integrator())
        .initial_state(&[3.0, 3.0])
        .times(&times)
        .input(Signal::scalar(f64::sin))
        .hold_input(0.01)
        .noise(Noise::uniform(&[0.01], 0.01, 1))
        .observer("linear", observer, &[0.0, 0.0]);
    if integrated {
        scenario = scenario.integral("none", Integrand::custom(|_| 0.0));
    }
    let run = scenario.run()?;
    Ok(run.x.row(400).iter().chain(run.observers[0].estimate.row(400).iter()).copied().collect())
}

fn main() -> Result<(), Box<dyn Error>> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let [who, runs, rounds] = &arguments[..] else { return Err("WHO RUNS ROUNDS".into()) };
    let (runs, rounds): (u32, u32) = (runs.parse()?, rounds.parse()?);
    if who == "noise" {
        let noise = Noise::uniform(&NOISE, 0.01, 1);
        println!("{}", json!((0..=400).map(|k| noise.sample(Purpose::MeasurementNoise, k)).collect::<Vec<_>>()));
        return Ok(());
    }
    let plant = cart_pole()?;
    let linear = LinearObserver::of(double_integrator(), Vector2::new(7.0, 10.0))?;
    let round = || -> Result<Vec<f64>, Box<dyn Error>> {
        let mut end = Vec::new();
        for _ in 0..runs {
            end = match who.as_str() {
                "held" | "integrated" => held(&linear, who == "integrated")?,
                _ => run(&plant, who == "lpv", 1)?,
            };
        }
        Ok(end)
    };
    let mut end = Vec::new();
    let mut least = f64::INFINITY;
    for _ in 0..rounds {
        let start = Instant::now();
        end = black_box(round()?);
        least = least.min(start.elapsed().as_secs_f64() * 1e6 / f64::from(runs));
    }
    println!("{}", json!({"us": least, "end": end}));
    Ok(())
}
