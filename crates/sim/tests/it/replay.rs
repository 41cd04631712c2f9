//! Replay: an observer on a log of a simulation does what it did in the simulation, and the statistics say what is in
//! the data.

use luenberger_observers::kalman::{ExtendedKalmanFilter, NoiseModel};
use luenberger_observers::{LinearObserver, Observer, ObserverDimensions, SampledObserver};
use luenberger_plants::{Plant, StaticPlant, double_integrator};
use luenberger_sim::replay::InnovationStatistics;
use luenberger_sim::{
    BetweenRows, Noise, Purpose, Recording, Replay, SampleInterpolation, Scenario, Sensor, Settings, Signal, SimError,
    Trajectory,
};
use nalgebra::{Const, DMatrix, Matrix1, Matrix2, SMatrix, Vector1, Vector2, dmatrix};

type Filter = ExtendedKalmanFilter<luenberger_plants::StaticPlant<f64, 2, 1, 1>, f64, Const<2>, Const<1>, Const<1>>;

fn observer() -> LinearObserver<f64, Const<2>, Const<1>, Const<1>> {
    LinearObserver::of(double_integrator(), Vector2::new(7.0, 10.0)).unwrap()
}

fn simulated(samples: usize) -> Trajectory {
    Scenario::new(double_integrator())
        .initial_state(&[-3.0, 1.0])
        .input(Signal::scalar(f64::sin))
        .observer("linear", observer(), &[0.0, 0.0])
        .until(4.0, samples)
        .run()
        .unwrap()
}

fn recording(run: &Trajectory) -> Recording {
    Recording::new(run.t.clone(), run.u.clone(), run.y.clone()).unwrap()
}

/// The largest difference of the estimates of the simulation and of the replay of its log.
fn apart(samples: usize, inputs: SampleInterpolation, outputs: BetweenRows) -> f64 {
    let run = simulated(samples);
    let log = recording(&run).between(inputs, outputs);
    let replayed = Replay::new(double_integrator(), log).observer("linear", observer(), &[0.0, 0.0]).run().unwrap();
    let linear = replayed.observer("linear").unwrap();
    assert_eq!(linear.t, run.t);
    (&linear.estimate - &run.observers[0].estimate).amax()
}

/// The time limit of a replay, which acts at every row.
#[test]
fn a_replay_ends_at_its_time_limit() {
    let settings = Settings { end: Some(std::time::Instant::now()), ..Settings::default() };
    let replay = Replay::new(double_integrator(), recording(&simulated(5))).settings(settings);
    let error = replay.observer("linear", observer(), &[0.0, 0.0]).run().unwrap_err();
    assert!(matches!(error, SimError::TimeLimit { time: 0.0 }), "{error}");
}

/// Straight lines miss a quantity by `h^2/8` of its second derivative: here |y''| = |u| <= 1 and |u''| <= 1. The error
/// `d' = (A - L C) d + L dy + B du` has the poles -2 and -5; the integral of `|exp((A - L C) t) [L B]|` is below 4 in
/// each row.
#[test]
fn a_replayed_simulation_is_the_simulation_up_to_interpolation() {
    let h = |samples: usize| 4.0 / (samples - 1) as f64;
    let line = |samples| apart(samples, SampleInterpolation::Linear, BetweenRows::Linear);
    let (coarse, fine) = (line(101), line(201));
    assert!(coarse <= 4.0 * 2.0 * h(101).powi(2) / 8.0, "{coarse:e}");
    // Of second order in the period.
    assert!((3.5..4.5).contains(&(coarse / fine)), "{coarse:e} {fine:e}");
    // Held, inputs are late by half a period, and more so outputs, which L multiplies: first order.
    let (coarse, fine) = (
        apart(101, SampleInterpolation::ZeroOrderHold, BetweenRows::Held),
        apart(201, SampleInterpolation::ZeroOrderHold, BetweenRows::Held),
    );
    assert!((1.8..2.2).contains(&(coarse / fine)) && coarse > 5.0 * line(101), "{coarse:e} {fine:e}");
}

/// An input that was held is known exactly, also at its jumps.
#[test]
fn held_inputs_are_replayed_as_they_were() {
    let run = Scenario::new(double_integrator())
        .input(Signal::scalar(|t| (3.0 * t).cos()))
        .hold_input(0.01)
        .observer("linear", observer(), &[1.0, -1.0])
        .until(4.0, 401)
        .run()
        .unwrap();
    let log = recording(&run).between(SampleInterpolation::ZeroOrderHold, BetweenRows::Linear);
    let replayed = Replay::new(double_integrator(), log).observer("linear", observer(), &[1.0, -1.0]).run().unwrap();
    let apart = (&replayed.observers[0].estimate - &run.observers[0].estimate).amax();
    // Only y is interpolated: |y''| = |u| <= 1, and |exp((A - L C) t) L| has an integral below 4.
    assert!(apart <= 4.0 * 1e-4 / 8.0, "{apart:e}");
}

/// `x' = -x`, `xhat' = -xhat + 100 (w - xhat)`, a row every 0.1: ten time constants of the observer. The errors are
/// those of scipy.linalg.expm for the stacked equation of x, xhat and w, with w = x at every row; `w' = -xhat`, and 0
/// for the held measurement.
#[test]
fn a_measurement_moves_with_the_model_between_the_rows() {
    let plant = StaticPlant::new(Matrix1::new(-1.0), SMatrix::<f64, 1, 0>::zeros(), Matrix1::new(1.0)).unwrap();
    let t: Vec<f64> = (0..6).map(|k| 0.1 * f64::from(k)).collect();
    let y = DMatrix::from_fn(6, 1, |k, _| (-t[k]).exp());
    let log = Recording::new(t, DMatrix::zeros(6, 0), y.clone()).unwrap();
    let run = |between: BetweenRows| {
        let log = log.clone().between(SampleInterpolation::ZeroOrderHold, between);
        let observer = LinearObserver::of(plant.clone(), Matrix1::new(100.0)).unwrap();
        Replay::new(plant.clone(), log).observer("o", observer, &[3.0]).run().unwrap().observers[0].clone()
    };
    for (between, expected) in [
        (
            BetweenRows::Predicted,
            [-2.0, 0.018187826768882864, -0.00016539852128749644, 1.504119826467587e-06, -1.3678335575306733e-08, 0.0],
        ),
        (
            BetweenRows::Held,
            [
                -2.0,
                -0.0853441577037507,
                -0.07715175256378692,
                -0.06980978967690665,
                -0.06316650984476602,
                -0.057155421674281115,
            ],
        ),
    ] {
        let found = run(between);
        // A sensor in a simulation does the same.
        let observer = LinearObserver::of(plant.clone(), Matrix1::new(100.0)).unwrap();
        let scenario = Scenario::new(plant.clone()).initial_state(&[1.0]).sensor(Sensor::new(0, 0.1));
        let scenario = if between == BetweenRows::Held { scenario.hold_measurements() } else { scenario };
        let simulated = scenario.observer("o", observer, &[3.0]).until(0.5, 6).run().unwrap();
        for (k, expected) in expected.into_iter().enumerate() {
            let error = simulated.observers[0].error[(k, 0)];
            assert!((error - expected).abs() < 1e-8, "{between:?}, sample {k}: {error} instead of {expected}");
        }
        for (k, expected) in expected.into_iter().enumerate() {
            let error = y[(k, 0)] - found.estimate[(k, 0)];
            assert!((error - expected).abs() < 1e-8, "{between:?}, row {k}: {error} instead of {expected}");
        }
    }
}

fn filter(v: f64) -> Filter {
    let noises = NoiseModel { w: Matrix2::zeros(), v: Matrix1::new(v), p0: Matrix2::identity() * 1e-2 };
    ExtendedKalmanFilter::new(double_integrator(), noises, 0.02, 1).unwrap()
}

/// A log every 0.02 s, with Gaussian noise of deviation 0.1 on the output.
fn noisy() -> (Trajectory, Recording) {
    let run = Scenario::new(double_integrator())
        .initial_state(&[0.1, -0.1])
        .input(Signal::scalar(f64::sin))
        .hold_input(0.02)
        .sampled_observer("filter", filter(0.01), &[0.0, 0.0])
        .until(20.0, 1001)
        .run()
        .unwrap();
    let noise = Noise::gaussian(&[0.1], 0.02, 11);
    let y = DMatrix::from_fn(1001, 1, |k, _| run.y[(k, 0)] + noise.sample(Purpose::MeasurementNoise, k as u64)[0]);
    let log = Recording::new(run.t.clone(), run.u.clone(), y).unwrap();
    (run, log)
}

/// A sampled-data observer sees the samples of the log and no others: its replay is its run.
#[test]
fn sampled_observers_are_replayed_exactly() {
    let (run, _) = noisy();
    let replayed = Replay::new(double_integrator(), recording(&run))
        .sampled_observer("filter", filter(0.01), &[0.0, 0.0])
        .run()
        .unwrap();
    let replayed = replayed.observer("filter").unwrap();
    assert_eq!((replayed.t.len(), replayed.rows_used(), replayed.interpolated), (1001, 1001, 0));
    let apart = (&replayed.estimate - &run.observers[0].estimate).amax();
    // The samples of the log are those of the run to its integration error.
    assert!(apart <= 1e-9, "{apart:e}");
    // The covariance is not known of an observer that is only sampled.
    assert!(replayed.consistency.is_none() && replayed.consistency(0.0).unwrap().is_none());
    // As a filter it is the same run, and its estimates are those after the measurement.
    let after = Replay::new(double_integrator(), recording(&run)).filter("filter", filter(0.01), &[0.0, 0.0]);
    let after = after.run().unwrap();
    let before: Vec<f64> = (0..1001).map(|k| run.y[(k, 0)] - run.observers[0].estimate[(k, 0)]).collect();
    let innovation = after.observers[0].innovation.as_ref().unwrap();
    assert!((0..1001).all(|k| (innovation[(k, 0)].unwrap() - before[k]).abs() <= 1e-9));
}

/// The filter that knows the noise has white innovations of the covariance it believes in; one that does not is found
/// out.
#[test]
fn innovations_tell_a_right_filter_from_a_wrong_one() {
    let (_, log) = noisy();
    let replayed = Replay::new(double_integrator(), log)
        .filter("right", filter(0.01), &[0.0, 0.0])
        .filter("trusting", filter(1e-4), &[0.0, 0.0])
        .filter("doubting", filter(1.0), &[0.0, 0.0])
        .observer("slow", LinearObserver::of(double_integrator(), Vector2::new(0.2, 0.01)).unwrap(), &[2.0, 0.0])
        .run()
        .unwrap();
    let consistency = |name: &str| replayed.observer(name).unwrap().consistency(0.0).unwrap().unwrap();
    let right = consistency("right");
    assert!((right.bounds.0..right.bounds.1).contains(&right.mean), "{right:?}");
    assert!(right.accepted() && right.expected == 1.0 && right.samples == 1001);
    // scipy 1.17.1: chi2.ppf([0.025, 0.975], 1001)/1001.
    assert!((right.bounds.0 - 0.914299032188253).abs() < 1e-12 && (right.bounds.1 - 1.089485250648115).abs() < 1e-12);
    assert!(consistency("trusting").mean > 50.0 && consistency("doubting").mean < 0.02);
    let statistics = |name: &str| replayed.observer(name).unwrap().statistics(1.0).unwrap().remove(0);
    let right = statistics("right");
    let whiteness = right.whiteness.clone().unwrap();
    assert!(whiteness.p_value > 0.01, "{whiteness:?}");
    let outside = whiteness.autocorrelation.iter().filter(|r| r.abs() > whiteness.bound).count();
    assert!(outside <= 3, "{whiteness:?}");
    // The noise itself: 0.1, to three deviations of a root mean square of 951 samples.
    assert!((right.rms - 0.1).abs() < 3.0 * 0.1 / (2.0 * 951f64).sqrt() && right.samples == 951, "{right:?}");
    // An observer that is still on its way: its innovation is the error that it has not corrected.
    let slow = statistics("slow");
    assert!(slow.whiteness.unwrap().p_value < 1e-12 && slow.mean.abs() > 0.05);
}

/// What does not fit, with its numbers; and what happens on the way.
#[test]
fn bad_recordings_and_observers_are_refused() {
    let t = vec![0.0, 0.1, 0.2];
    let column = |rows: usize, value: f64| DMatrix::from_element(rows, 1, value);
    assert_eq!(Recording::new(vec![0.0], column(1, 0.0), column(1, 0.0)), Err(SimError::Samples { samples: 1 }));
    let short = Recording::new(t.clone(), column(2, 0.0), column(3, 0.0)).unwrap_err();
    assert!(matches!(short, SimError::Length { expected: 3, found: 2, .. }));
    let unsorted = Recording::new(vec![0.0, 0.2, 0.2], column(3, 0.0), column(3, 0.0)).unwrap_err();
    assert_eq!(unsorted, SimError::TimesUnsorted { index: 2, previous: 0.2, next: 0.2 });
    let nan = Recording::new(t.clone(), column(3, 0.0), dmatrix![0.0; f64::NAN; 0.0]).unwrap_err();
    assert!(matches!(nan, SimError::NotFinite { index: 1, .. }));

    let log = || Recording::new(t.clone(), column(3, 0.0), column(3, 1.0)).unwrap();
    let two_outputs = Recording::new(t.clone(), column(3, 0.0), DMatrix::zeros(3, 2)).unwrap();
    let wrong = Replay::new(double_integrator(), two_outputs).run().unwrap_err();
    assert!(matches!(wrong, SimError::Length { expected: 1, found: 2, .. }));
    let twice = Replay::new(double_integrator(), log()).observer("a", observer(), &[0.0; 2]).observer(
        "a",
        observer(),
        &[0.0; 2],
    );
    assert_eq!(twice.run(), Err(SimError::DuplicateName { name: "a".to_owned() }));
    let initial = Replay::new(double_integrator(), log()).observer("a", observer(), &[0.0]).run().unwrap_err();
    assert!(matches!(initial, SimError::Length { expected: 2, found: 1, .. }));
    let settings = Settings { rtol: -1.0, ..Settings::default() };
    assert!(Replay::new(double_integrator(), log()).settings(settings).run().is_err());
    let unstable = LinearObserver::of(double_integrator(), Vector2::new(-1e4, -1e7)).unwrap();
    let blown = Replay::new(double_integrator(), log()).observer("a", unstable, &[0.0; 2]).run();
    assert!(matches!(blown, Err(SimError::BlowUp { .. })), "{blown:?}");
    let run = Replay::new(double_integrator(), log()).observer("a", observer(), &[0.0; 2]).run().unwrap();
    assert!(run.observer("b").is_err() && run.observer("a").unwrap().statistics(9.0).is_err());
    // An observer of some states has no innovation.
    let partial = Replay::new(double_integrator(), log()).partial_observer("a", observer(), &[0.0; 2]).run().unwrap();
    assert!(partial.observers[0].innovation.is_none() && partial.observers[0].statistics(0.0).unwrap().is_empty());
}

/// A gap is more than five times the median period, of the rows or of the measurements of an output.
#[test]
fn gaps_are_those_of_the_times() {
    let t = vec![0.0, 1.0, 2.0, 3.0, 8.0, 13.5, 14.5];
    let y = DMatrix::from_fn(7, 2, |k, j| (j == 0 || ![1, 2].contains(&k)).then_some(1.0));
    let log = Recording::with_missing(t, &DMatrix::from_element(7, 0, None), &y).unwrap();
    assert_eq!((log.median_period(), log.gaps()), (1.0, vec![(8.0, 13.5)]));
    // Of the second output the times are 0, 3, 8, 13.5, 14.5: differences 3, 5, 5.5, 1, of which the median is 5.
    assert_eq!((log.output_period(1), log.output_gaps(1)), (5.0, vec![]));
    assert_eq!((log.output_period(0), log.output_gaps(0)), (1.0, vec![(8.0, 13.5)]));
}

/// z' = 0 and z+ = z + 1 every 0.31.
struct Counter;

impl Observer<f64> for Counter {
    type State = Vector1<f64>;
    type Input = Vector1<f64>;
    type Output = Vector1<f64>;
    type Estimate = Vector1<f64>;

    fn dimensions(&self) -> ObserverDimensions {
        ObserverDimensions { state: 1, inputs: 1, outputs: 1, estimate: 1 }
    }

    fn derivative(&self, _t: f64, _z: &Vector1<f64>, _u: &Vector1<f64>, _y: &Vector1<f64>) -> Vector1<f64> {
        Vector1::new(0.0)
    }

    fn estimate(&self, _t: f64, z: &Vector1<f64>, _u: &Vector1<f64>, _y: &Vector1<f64>) -> Vector1<f64> {
        *z
    }

    fn initial(&self, _t: f64, estimate: &Vector1<f64>, _u: &Vector1<f64>, _y: &Vector1<f64>) -> Vector1<f64> {
        *estimate
    }

    fn jump_period(&self) -> Option<f64> {
        Some(0.31)
    }

    fn jump(&self, _t: f64, z: &Vector1<f64>, _u: &Vector1<f64>, _y: &Vector1<f64>) -> Vector1<f64> {
        z.add_scalar(1.0)
    }
}

/// An observer that jumps every 0.31 has jumped `floor(t/0.31)` times, in a simulation and on a log that begins at t =
/// 2, in which the output is missing for a while, so that its hold ends between two rows.
#[test]
fn jumps_are_at_the_multiples_of_their_period() {
    let plant = StaticPlant::new(Matrix1::new(0.0), Matrix1::new(1.0), Matrix1::new(1.0)).unwrap();
    let jumps = |since: f64| (since / 0.31).floor();
    let run = Scenario::new(plant.clone()).observer("counter", Counter, &[0.0]).until(3.0, 13).run().unwrap();
    for (k, t) in run.t.iter().enumerate() {
        assert_eq!(run.observers[0].estimate[(k, 0)], jumps(*t), "{t}");
    }
    let t: Vec<f64> = (0..13).map(|k| 2.0 + 0.5 * f64::from(k)).collect();
    let y = DMatrix::from_fn(13, 1, |k, _| (!(4..9).contains(&k)).then_some(1.0));
    let log = Recording::with_missing(t, &DMatrix::from_element(13, 1, Some(0.0)), &y).unwrap();
    for between in [BetweenRows::Predicted, BetweenRows::Held, BetweenRows::Linear] {
        let log = log.clone().between(SampleInterpolation::ZeroOrderHold, between);
        let found = Replay::new(plant.clone(), log).observer("counter", Counter, &[0.0]).run().unwrap();
        let found = &found.observers[0];
        for (k, t) in found.t.iter().enumerate() {
            assert_eq!(found.estimate[(k, 0)], jumps(t - 2.0), "{between:?} {t}");
        }
    }
}

/// The covariance that a filter shows is the one that its correction uses: after a sample, `P+ = P - P H' S^-1 H P`.
#[test]
fn the_innovation_covariance_is_that_of_the_correction() {
    let filter = filter(0.01);
    let (u, y) = (Vector1::new(0.0), Vector1::new(0.3));
    let mut estimate = filter.initial(0.0, &Vector2::zeros(), &u, &y);
    for k in 0..5 {
        filter.step(0.02 * f64::from(k), &mut estimate, &u, &y);
    }
    let (p, s) = (estimate.covariance(), filter.innovation_covariance(0.1, &estimate, &u));
    let c = double_integrator().c;
    assert!((s - (c * p * c.transpose() + Matrix1::new(0.01))).amax() <= 4.0 * f64::EPSILON);
    let gain = p * c.transpose() / s[(0, 0)];
    let corrected = estimate.estimate() + gain * (y - double_integrator().output(0.0, &estimate.estimate(), &u));
    filter.step(0.1, &mut estimate, &u, &y);
    // One Runge-Kutta step of a double integrator is exact.
    let predicted = Vector2::new(corrected[0] + 0.02 * corrected[1], corrected[1]);
    assert!((estimate.estimate() - predicted).amax() <= 16.0 * f64::EPSILON);
}

#[test]
fn a_sequence_with_a_known_correlation() {
    // 1, -1, 1, ...: r_k = (-1)^k (N - k)/N, so that Q = (N + 2)/N sum (N - k).
    let alternating: Vec<f64> = (0..100).map(|k| if k % 2 == 0 { 1.0 } else { -1.0 }).collect();
    let statistics = InnovationStatistics::of(&alternating);
    assert_eq!((statistics.mean, statistics.rms, statistics.peak), (0.0, 1.0, 1.0));
    let whiteness = statistics.whiteness.unwrap();
    assert_eq!(whiteness.autocorrelation.len(), 10);
    assert!((whiteness.autocorrelation[0] + 0.99).abs() < 1e-15 && (whiteness.autocorrelation[1] - 0.98).abs() < 1e-15);
    assert!((whiteness.statistic - 1.02 * 945.0).abs() < 1e-9 && whiteness.p_value < 1e-190);
    assert!((whiteness.bound - 0.196).abs() < 1e-15, "{}", whiteness.bound);
    assert!(InnovationStatistics::of(&[0.1; 50]).whiteness.is_none());
    assert!(InnovationStatistics::of(&[0.1; 1000]).whiteness.is_none());
    assert_eq!((InnovationStatistics::of(&[]).samples, InnovationStatistics::of(&[]).rms), (0, 0.0));
}
