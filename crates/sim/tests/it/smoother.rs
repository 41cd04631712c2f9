//! The fixed-interval smoother on logs: against filterpy, against batch least squares, and across gaps.

use luenberger_observers::{
    ExtendedKalmanFilter, KalmanFilter, KalmanModel, NoiseModel, SigmaPoints, UnscentedKalmanFilter,
};
use luenberger_plants::{StaticPlant, double_integrator, plant};
use luenberger_sim::replay::{Recording, Replay, ReplayedObserver};
use nalgebra::{DMatrix, DVector, Matrix1, Matrix2, RowVector2, SMatrix, Vector2};
use proptest::prelude::*;

/// A log of one output with values that are missing, every `period` from 0 on.
fn log(period: f64, u: &[f64], y: &[Option<f64>]) -> Recording {
    let t = (0..y.len()).map(|k| period * k as f64).collect();
    let u = DMatrix::from_fn(u.len(), 1, |k, _| Some(u[k]));
    Recording::with_missing(t, &u, &DMatrix::from_fn(y.len(), 1, |k, _| y[k])).unwrap()
}

fn one(replay: Replay<'_>) -> ReplayedObserver {
    replay.run().unwrap().observers.remove(0)
}

/// filterpy 2.0.0, `KalmanFilter.rts_smoother`, of deviations from the response to the input, which it does not know.
#[test]
fn a_linear_plant_as_by_filterpy() {
    let (ad, bd, c) = (Matrix2::new(1.0, 0.5, 0.0, 1.0), Vector2::new(0.125, 0.5), RowVector2::new(1.0, 0.0));
    let (w, v, p0) = (Matrix2::new(0.02, 0.01, 0.01, 0.04), Matrix1::new(0.09), Matrix2::new(1.0, 0.2, 0.2, 0.5));
    let filter = KalmanFilter::new(KalmanModel { ad, bd, c, w, v, p0, period: 0.5 }).unwrap();
    let y = [Some(0.1), Some(0.4), None, Some(1.0), None, None, Some(2.5), Some(3.1)];
    let recording = log(0.5, &[0.2, -0.1, 0.3, 0.0, 0.5, 0.1, -0.2, 0.4], &y);
    let plant = StaticPlant::new(ad, bd, c).unwrap();
    let found = one(Replay::new(plant, recording).smoothed_filter("filter", filter, &[0.5, -0.2]));
    let smoothed = found.smoothed.as_ref().unwrap();
    for (k, x, p, filtered) in [
        (
            0,
            [0.16649713150298645, 0.40548787855209406],
            [0.050504839691811854, -0.026198084458540286, 0.07893422748122875],
            [0.1330275229357798, -0.27339449541284405],
        ),
        (
            2,
            [0.6969565354224121, 0.5666940263525968],
            [0.04192058296388396, 0.0023429894237639026, 0.04523614601182174],
            [0.346352181279119, 0.07748835239305381],
        ),
        (
            5,
            [1.9218001107671911, 1.0855334000087298],
            [0.04884487643439167, -0.0031589418667393454, 0.047352776240656536],
            [1.5712557440107393, 0.8379408044196612],
        ),
        (
            7,
            [3.0532567831461805, 1.0572126141752904],
            [0.05800190864940866, 0.03496398313094934, 0.09949817248966208],
            [3.0532567831461805, 1.0572126141752904],
        ),
    ] {
        for i in 0..2 {
            assert!((found.estimate[(k, i)] - filtered[i]).abs() < 1e-13, "{k} {i}");
            assert!((smoothed.estimate[(k, i)] - x[i]).abs() < 1e-13, "{k} {i}: {}", smoothed.estimate[(k, i)]);
        }
        let expected = Matrix2::new(p[0], p[1], p[1], p[2]);
        assert!((smoothed.covariance(k).unwrap() - expected).amax() < 1e-13, "{k}");
    }
    // Errors and NEES of the smoothed estimates are those of a replay with them.
    let hindsight = found.with_smoothed_estimates().unwrap();
    assert_eq!(
        (&hindsight.estimate, hindsight.consistency.unwrap().deviation()),
        (&smoothed.estimate, smoothed.deviation())
    );
}

/// x1+ = x1 + x2/10, x2+ = 0.98 x2 - sin(x1)/10, y = (sin x1, x1 x2).
struct Pendulum;

plant!(
    Pendulum,
    (2, 0, 2),
    |plant, t, x, u| {
        let of = |x: f64| nalgebra::convert::<f64, T>(x);
        [x[0] + of(0.1) * x[1], x[1] - of(0.1) * x[0].sin() - of(0.02) * x[1]]
    },
    [x[0].sin(), x[0] * x[1]]
);

/// filterpy 2.0.0, `UnscentedKalmanFilter.rts_smoother` with `MerweScaledSigmaPoints(2, 1, 2, 0)`.
#[test]
fn an_unscented_filter_as_by_filterpy() {
    let noises = NoiseModel {
        w: Matrix2::new(0.01, 0.002, 0.002, 0.02),
        v: Matrix2::new(0.04, 0.01, 0.01, 0.09),
        p0: Matrix2::new(0.5, 0.1, 0.1, 0.3),
    };
    let filter = UnscentedKalmanFilter::discrete(Pendulum, noises, SigmaPoints::default(), 0.1).unwrap();
    let y = DMatrix::from_fn(6, 2, |k, j| if j == 0 { (0.8 - 0.02 * k as f64).sin() } else { -0.1 * k as f64 + 0.05 });
    let t = (0..6).map(|k| 0.1 * f64::from(k)).collect();
    let recording = Recording::new(t, DMatrix::zeros(6, 0), y).unwrap();
    let found = one(Replay::new(Pendulum, recording).smoothed_filter("filter", filter, &[0.5, -0.2]));
    let smoothed = found.smoothed.unwrap();
    for (k, x, p) in [
        (
            0,
            [0.8533273238232858, -0.07967276120196051],
            [0.027157810653144474, 0.001772562683313543, 0.05045487951505476],
        ),
        (
            3,
            [0.8005243988327149, -0.3266613475230082],
            [0.019161900424565025, 0.007074544529939675, 0.03555403770686538],
        ),
        (
            5,
            [0.7327216640395106, -0.48980398954094007],
            [0.02643933119988382, 0.013629025165345861, 0.05015253276444291],
        ),
    ] {
        assert!((0..2).all(|i| (smoothed.estimate[(k, i)] - x[i]).abs() < 1e-12), "{k}: {}", smoothed.estimate);
        assert!((smoothed.covariance(k).unwrap() - Matrix2::new(p[0], p[1], p[1], p[2])).amax() < 1e-12, "{k}");
    }
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 64, failure_persistence: None, ..ProptestConfig::default() })]

    /// The smoothed estimates of a linear plant minimise
    /// `|x0 - m|^2 / P(0) + sum |y - C x|^2 / V + sum |x+ - A x - B u|^2 / W`, and their covariances are the blocks of
    /// the inverse of half its Hessian. A may be singular.
    #[test]
    fn a_linear_plant_is_smoothed_to_the_least_squares_solution(
        a in prop::array::uniform4(-1.2f64..1.2), c in prop::array::uniform2(-1.0f64..1.0), rank in 0usize..2,
        root in prop::array::uniform4(-1.0f64..1.0), v in 0.05f64..1.0, us in prop::array::uniform6(-1.0f64..1.0),
        ys in prop::array::uniform6(-1.0f64..1.0), measured in prop::array::uniform6(any::<bool>()),
    ) {
        let mut ad = Matrix2::from_row_slice(&a);
        if rank == 0 {
            ad.set_row(1, &(ad.row(0) * 0.5));
        }
        let (bd, c) = (Vector2::new(0.3, -0.2), RowVector2::from_row_slice(&c));
        let root = Matrix2::from_row_slice(&root);
        let w = root * root.transpose() + Matrix2::identity() * 0.1;
        let (p0, m) = (Matrix2::new(1.0, 0.3, 0.3, 0.5), [0.4, -0.3]);
        let filter = KalmanFilter::new(KalmanModel { ad, bd, c, w, v: Matrix1::new(v), p0, period: 1.0 }).unwrap();
        let y: Vec<Option<f64>> = ys.iter().zip(measured).map(|(y, measured)| measured.then_some(*y)).collect();
        let plant = StaticPlant::new(ad, bd, c).unwrap();
        let found = one(Replay::new(plant, log(1.0, &us, &y)).smoothed_filter("filter", filter, &m));
        let smoothed = found.smoothed.unwrap();

        let (mut hessian, mut right) = (DMatrix::<f64>::zeros(12, 12), DVector::<f64>::zeros(12));
        let mut add = |rows: DMatrix<f64>, target: DVector<f64>, weight: DMatrix<f64>| {
            hessian += rows.transpose() * &weight * &rows;
            right += rows.transpose() * weight * target;
        };
        let dynamic = |m: Matrix2<f64>| DMatrix::from_column_slice(2, 2, m.as_slice());
        let place = |k: usize, block: &DMatrix<f64>| {
            let mut rows = DMatrix::zeros(block.nrows(), 12);
            rows.columns_mut(2 * k, 2).copy_from(block);
            rows
        };
        let one = dynamic(Matrix2::identity());
        add(place(0, &one), DVector::from_row_slice(&m), dynamic(p0.try_inverse().unwrap()));
        for k in 0..6 {
            if let Some(y) = y[k] {
                let row = DMatrix::from_row_slice(1, 2, c.as_slice());
                add(place(k, &row), DVector::from_element(1, y), DMatrix::from_element(1, 1, 1.0 / v));
            }
            if k < 5 {
                let rows = place(k + 1, &one) - place(k, &dynamic(ad));
                let target = DVector::from_column_slice((bd * us[k]).as_slice());
                add(rows, target, dynamic(w.try_inverse().unwrap()));
            }
        }
        let inverse = hessian.try_inverse().unwrap();
        let x = &inverse * right;
        for k in 0..6 {
            for i in 0..2 {
                prop_assert!((smoothed.estimate[(k, i)] - x[2 * k + i]).abs() < 1e-10, "{k} {i}");
            }
            let block = inverse.view((2 * k, 2 * k), (2, 2));
            prop_assert!((smoothed.covariance(k).unwrap() - block).amax() < 1e-10, "{k}");
        }
    }
}

/// Across a gap the filters predict in steps no longer than their period. On a linear plant the smoothed estimates
/// do not depend on how often: for the extended filter its Runge-Kutta steps are exact here, and with W = 0 so is the
/// unscented filter.
#[test]
fn gaps_are_crossed_in_steps() {
    let t = vec![0.0, 1.0, 2.0, 12.0, 13.0];
    let y = DMatrix::from_column_slice(5, 1, &[0.2, 1.1, 1.8, 11.5, 13.3]);
    let recording = Recording::new(t, DMatrix::zeros(5, 1), y).unwrap();
    let noises =
        |w: f64| NoiseModel { w: Matrix2::new(0.0, 0.0, 0.0, w), v: Matrix1::new(0.04), p0: Matrix2::identity() };
    let extended = |period: f64, w: f64| {
        let filter = ExtendedKalmanFilter::new(double_integrator(), noises(w), period, 1).unwrap();
        let replay = Replay::new(double_integrator(), recording.clone());
        one(replay.smoothed_filter("filter", filter, &[0.0, 0.0])).smoothed.unwrap()
    };
    let (whole, fine) = (extended(20.0, 0.01), extended(0.3, 0.01));
    assert!((&whole.estimate - &fine.estimate).amax() < 1e-11, "{} {}", whole.estimate, fine.estimate);
    assert!((whole.deviation() - fine.deviation()).amax() < 1e-11);
    // In the middle of the log the smoother is surer than the filter, at its end it is the filter.
    let filter = ExtendedKalmanFilter::new(double_integrator(), noises(0.01), 1.0, 1).unwrap();
    let found = one(Replay::new(double_integrator(), recording.clone()).smoothed_filter("f", filter, &[0.0, 0.0]));
    let (before, after) =
        (found.consistency.as_ref().unwrap().deviation(), found.smoothed.as_ref().unwrap().deviation());
    assert!((0..4).all(|k| (0..2).all(|i| after[(k, i)] < before[(k, i)])) && after.row(4) == before.row(4));

    let unscented = |period: f64| {
        let filter =
            UnscentedKalmanFilter::new(double_integrator(), noises(0.0), SigmaPoints::default(), period, 1).unwrap();
        let replay = Replay::new(double_integrator(), recording.clone());
        one(replay.smoothed_filter("filter", filter, &[0.0, 0.0])).smoothed.unwrap()
    };
    let (same, exact) = (unscented(0.3), extended(20.0, 0.0));
    assert!((&same.estimate - &exact.estimate).amax() < 1e-10, "{} {}", same.estimate, exact.estimate);
    assert!((same.deviation() - exact.deviation()).amax() < 1e-10);
}

/// A state that is known exactly has a covariance without inverse.
#[test]
fn a_singular_covariance_can_be_smoothed() {
    let (ad, c) = (Matrix2::new(1.0, 1.0, 0.0, 1.0), RowVector2::new(1.0, 0.0));
    let bd = SMatrix::<f64, 2, 1>::zeros();
    let p0 = Matrix2::new(1.0, 0.0, 0.0, 0.0);
    let model = KalmanModel { ad, bd, c, w: Matrix2::zeros(), v: Matrix1::new(1.0), p0, period: 1.0 };
    let filter = KalmanFilter::new(model).unwrap();
    let plant = StaticPlant::new(ad, bd, c).unwrap();
    let recording = log(1.0, &[0.0; 3], &[Some(1.0), Some(2.0), Some(6.0)]);
    let smoothed = one(Replay::new(plant, recording).smoothed_filter("f", filter, &[0.0, 1.0])).smoothed.unwrap();
    // x1(0) has the variance 1 about 0 and the measurements 1, 2 - 1, 6 - 2: the mean is 6/4.
    for k in 0..3 {
        assert!((smoothed.estimate[(k, 0)] - 1.5 - k as f64).abs() < 1e-14);
        assert!((smoothed.estimate[(k, 1)] - 1.0).abs() < 1e-14);
        assert!((smoothed.deviation()[(k, 0)] - 0.5).abs() < 1e-14 && smoothed.deviation()[(k, 1)] == 0.0);
    }
}

/// `replay_missing` has the same for filters: the log of a filter that is not smoothed has nothing of it.
#[test]
fn nothing_is_smoothed_unasked() {
    let noises = NoiseModel { w: Matrix2::identity(), v: Matrix1::new(0.04), p0: Matrix2::identity() };
    let filter = ExtendedKalmanFilter::new(double_integrator(), noises, 1.0, 1).unwrap();
    let replay = Replay::new(double_integrator(), log(1.0, &[0.0; 2], &[Some(1.0), None]));
    let found = one(replay.filter("f", filter, &[0.0, 0.0]));
    assert!(found.smoothed.is_none() && found.with_smoothed_estimates().is_none());
}
