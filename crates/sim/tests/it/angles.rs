//! Errors of states that are angles: the scores do not depend on the turn of the estimate, nor on that of a true state.

use luenberger_observers::{KalmanFilter, KalmanModel, LinearObserver};
use luenberger_plants::{StaticPlant, double_integrator};
use luenberger_sim::replay::{Recording, Replay};
use luenberger_sim::{Errors, SampleInterpolation, Samples, Scenario, ScoreGrid, SimError};
use nalgebra::{DMatrix, Matrix1, Matrix2, RowVector2, SMatrix, Vector2};

/// An observer whose first estimate is `turns` turns off, and scores in continuous time.
fn scores(turns: f64, is_angle: bool) -> (Vec<f64>, Vec<f64>) {
    let plant = double_integrator();
    let observer = LinearObserver::of(plant.clone(), Vector2::new(7.0, 10.0)).unwrap();
    let scenario = Scenario::new(plant).initial_state(&[100.0, 30.0]);
    let scenario = if is_angle { scenario.angles(&[360.0, 0.0]) } else { scenario };
    let first = [100.0 + 25.0 - 360.0 * turns, 20.0];
    let run = scenario.observer("linear", observer, &first).until(4.0, 41).run().unwrap();
    let errors = Errors::of(&run, "linear", ScoreGrid::Continuous).unwrap();
    let state = errors.state(0).unwrap();
    let norm = errors.norm(None, 0.05).unwrap();
    let trace = run.error_trace("linear", 0).unwrap();
    let all = vec![state.initial, state.rmse, state.peak, state.last, norm.peak, norm.rmse, trace.at(1.0).unwrap()];
    (all, run.observer("linear").unwrap().error.column(0).iter().copied().collect())
}

/// The correction of the observer is the same where the output is measured relative to its estimate: here the estimate
/// has no turn, and the plant's own error is that of the start.
#[test]
fn an_estimate_on_another_branch_has_the_errors_of_its_own() {
    let (expected, rows) = scores(0.0, false);
    let (found, wrapped) = scores(0.0, true);
    // Within half a turn nothing changes, to the last bit.
    assert_eq!((expected, rows), (found, wrapped));
    // An observer that corrects the turn passes through half a turn: every error is within it.
    let (_, rows) = scores(1.0, true);
    assert!(rows.iter().all(|error| *error > -180.0 && *error <= 180.0), "{rows:?}");
    assert_eq!(rows[0], -25.0);
    let (found, _) = scores(1.0, true);
    assert_eq!(found[0], -25.0);
    assert!(found[2] <= 180.0, "{found:?}");
    let (plain, _) = scores(1.0, false);
    assert_eq!(plain[0], 335.0);
}

/// On a log the true heading may jump: errors and NEES are those of the heading that goes on.
#[test]
fn a_true_state_that_jumps_has_the_errors_of_one_that_does_not() {
    let (count, rate) = (200, 7.0);
    let times: Vec<f64> = (0..count).map(f64::from).collect();
    let heading: Vec<f64> = times.iter().map(|t| 3.0 + rate * t).collect();
    let y = DMatrix::from_iterator(heading.len(), 1, heading.iter().enumerate().map(|(k, x)| x + (k % 3) as f64 - 1.0));
    let filter = KalmanFilter::new(KalmanModel {
        ad: Matrix2::new(1.0, 1.0, 0.0, 1.0),
        bd: SMatrix::<f64, 2, 0>::zeros(),
        c: RowVector2::new(1.0, 0.0),
        w: Matrix2::identity() * 1e-4,
        v: Matrix1::new(0.6),
        p0: Matrix2::identity(),
        period: 1.0,
    })
    .unwrap();
    let plant = StaticPlant::new(filter.model().ad, filter.model().bd, filter.model().c).unwrap();
    let replay = |turns: &[f64]| {
        let recording = Recording::new(times.clone(), DMatrix::zeros(times.len(), 0), y.clone()).unwrap();
        let replay = Replay::new(plant.clone(), recording).filter("filter", filter.clone(), &[3.0, 6.0]);
        replay.angles(turns).run().map(|replayed| replayed.observer("filter").unwrap().clone())
    };
    let truth = |wraps: bool| {
        let of = |x: f64| if wraps { x - 360.0 * (x / 360.0).round() } else { x };
        let values = heading.iter().flat_map(|x| [of(*x), rate]);
        Samples::new(
            times.clone(),
            DMatrix::from_row_iterator(times.len(), 2, values),
            SampleInterpolation::ZeroOrderHold,
        )
        .unwrap()
    };
    let (plain, angles) = (replay(&[]).unwrap(), replay(&[360.0, 0.0]).unwrap());
    let expected = plain.errors(&truth(false)).unwrap();
    for found in [angles.errors(&truth(true)).unwrap(), angles.errors(&truth(false)).unwrap()] {
        let apart = expected.iter().zip(&found).map(|(a, b)| (a.unwrap() - b.unwrap()).abs());
        assert!(apart.fold(0.0, f64::max) < 1e-9);
    }
    let mean = |replayed: &luenberger_sim::replay::ReplayedObserver, wraps: bool| {
        replayed.nees(&truth(wraps), 100.0).unwrap().unwrap().mean
    };
    assert!((mean(&plain, false) - mean(&angles, true)).abs() < 1e-6);
    assert!(mean(&plain, true) > 1e3);
    assert!(matches!(replay(&[360.0]), Err(SimError::Length { expected: 2, found: 1, .. })));
    assert!(matches!(replay(&[-360.0, 0.0]), Err(SimError::NotPositive { .. })));
    let wrong = Scenario::new(double_integrator()).angles(&[f64::NAN, 0.0]).until(1.0, 2).run();
    assert!(wrong.is_err());
}
