//! What a replay does at samples, rows and limits, by hand.

use luenberger_observers::kalman::{ExtendedKalmanFilter, NoiseModel};
use luenberger_observers::{ObserverDimensions, SampledObserver};
use luenberger_plants::StateSpace;
use luenberger_sim::replay::ReplayedObserver;
use luenberger_sim::{BetweenRows, Recording, Replay, SampleInterpolation, SimError};
use nalgebra::{DMatrix, Dyn, Vector1, dmatrix};

/// Its estimate is the output of the sample before.
struct Before;

impl SampledObserver<f64> for Before {
    type State = Vector1<f64>;
    type Input = nalgebra::SVector<f64, 0>;
    type Output = Vector1<f64>;
    type Estimate = Vector1<f64>;

    fn dimensions(&self) -> ObserverDimensions {
        ObserverDimensions { state: 1, inputs: 0, outputs: 1, estimate: 1 }
    }

    fn period(&self) -> f64 {
        0.5
    }

    fn step(&self, _t: f64, state: &mut Vector1<f64>, _u: &Self::Input, y: &Vector1<f64>) {
        *state = *y;
    }

    fn estimate(&self, state: &Vector1<f64>) -> Vector1<f64> {
        *state
    }

    fn initial(&self, _t: f64, estimate: &Vector1<f64>, _u: &Self::Input, _y: &Vector1<f64>) -> Vector1<f64> {
        *estimate
    }
}

/// x' = 0, y = x, of so many states, without inputs.
fn still(states: usize) -> StateSpace {
    let c = DMatrix::from_fn(1, states, |_, j| f64::from(u8::from(j == 0)));
    StateSpace::new(DMatrix::zeros(states, states), DMatrix::zeros(states, 0), c).unwrap()
}

fn log(t: &[f64], y: &[f64], between: BetweenRows) -> Recording {
    let recording =
        Recording::new(t.to_vec(), DMatrix::zeros(t.len(), 0), DMatrix::from_column_slice(y.len(), 1, y)).unwrap();
    recording.between(SampleInterpolation::ZeroOrderHold, between)
}

fn before(t: &[f64], y: &[f64], between: BetweenRows) -> ReplayedObserver {
    let replayed = Replay::new(still(1), log(t, y, between)).sampled_observer("before", Before, &[9.0]).run().unwrap();
    replayed.observers[0].clone()
}

/// Rows every 1, samples every 1/2: between rows on a line, but not across a gap of more than one and a half periods,
/// where y is predicted as the estimate.
#[test]
fn samples_between_rows_are_on_lines_where_these_are_asked_for() {
    let (t, y) = ([0.0, 1.0, 2.0, 3.0, 5.0], [0.0, 2.0, 6.0, 7.0, 1.0]);
    let lines = before(&t, &y, BetweenRows::Linear);
    let seen = [9.0, 0.0, 1.0, 2.0, 4.0, 6.0, 6.5, 7.0, 7.0, 7.0, 7.0];
    assert_eq!((lines.estimate.as_slice(), lines.interpolated), (&seen[..], 3));
    // Without lines it is predicted between all rows: what was there before.
    let plain = before(&t, &y, BetweenRows::Held);
    assert_eq!(plain.estimate.as_slice(), [9.0, 0.0, 0.0, 2.0, 2.0, 6.0, 6.0, 7.0, 7.0, 7.0, 7.0]);
    assert_eq!(plain.interpolated, 0);
}

/// Of two rows within a hundredth of the period of a sample the nearer one is taken.
#[test]
fn the_nearest_row_is_the_one_of_a_sample() {
    for (near, far) in [(0.4992, 0.5018), (0.5018, 0.4965)] {
        let mut rows = [(0.0_f64, 1.0), (near, 2.0), (far, 3.0), (1.0, 4.0), (1.5, 5.0)];
        rows.sort_by(|a, b| a.0.total_cmp(&b.0));
        let found = before(&rows.map(|row| row.0), &rows.map(|row| row.1), BetweenRows::Held);
        assert_eq!(found.estimate.as_slice(), [9.0, 1.0, 2.0, 4.0], "{near} {far}");
    }
}

fn filter(states: usize, v: f64, period: f64) -> ExtendedKalmanFilter<StateSpace, f64, Dyn, Dyn, Dyn> {
    let diagonal = |entry: f64| DMatrix::from_diagonal_element(states, states, entry);
    let noises = NoiseModel { w: diagonal(0.0), v: dmatrix![v], p0: diagonal(2.0) };
    ExtendedKalmanFilter::new(still(states), noises, period, 1).unwrap()
}

/// `P = 2` and `V = 2`: after the measurement of 5 from the estimate 1 it is 3, with the variance 1; before the next,
/// the same.
#[test]
fn predictions_are_the_estimates_before_the_measurements() {
    let log = log(&[0.0, 1.0], &[5.0, 3.0], BetweenRows::Held);
    let replayed = Replay::new(still(1), log).filter("f", filter(1, 2.0, 1.0), &[1.0]).run().unwrap();
    let (after, before) = (&replayed.observers[0], replayed.observers[0].with_predictions());
    let near = |found: &ReplayedObserver, estimates: [f64; 2], variances: [f64; 2]| {
        for k in 0..2 {
            let variance = found.consistency.as_ref().unwrap().covariance(k).unwrap()[0];
            assert!((found.estimate[(k, 0)] - estimates[k]).abs() < 1e-12 && (variance - variances[k]).abs() < 1e-12);
        }
    };
    near(after, [3.0, 3.0], [1.0, 2.0 / 3.0]);
    near(&before, [1.0, 3.0], [2.0, 1.0]);
    // NIS: (5 - 1)^2/4 and 0.
    let nis = after.consistency(0.0).unwrap().unwrap();
    assert!((nis.mean - 2.0).abs() < 1e-12 && nis.samples == 2 && nis.left_out == 0);
}

/// A smoother keeps `3 n^2 + 2 n` numbers of each step, of 1.5e8 at most: for n = 2 9 375 000 steps. Without one there
/// may be 2e7.
#[test]
fn a_log_with_more_steps_than_fit_is_refused_with_its_numbers() {
    let replay = |end: f64| Replay::new(still(2), log(&[0.0, end], &[0.0, 0.0], BetweenRows::Held));
    let filter = || filter(2, 2.0, 1.0);
    let error = replay(9_400_000.0).smoothed_filter("f", filter(), &[0.0, 0.0]).run().unwrap_err();
    let expected =
        |steps: f64, limit: f64| SimError::TooManySamples { name: "f".to_owned(), period: 1.0, steps, limit };
    assert_eq!(error, expected(9_400_000.0, 9_375_000.0));
    let error = replay(20_000_001.0).filter("f", filter(), &[0.0, 0.0]).run().unwrap_err();
    assert_eq!(error, expected(20_000_001.0, 2e7));
}
