//! Smoothers and the stationary filter on linear plants, stiff and not, against the exact discretisation: what
//! `luenberger_observers` holds for the filters themselves.

use luenberger::observers::{
    ExtendedKalmanFilter, Horizon, MovingHorizonEstimator, NoiseModel, SigmaPoints, UnscentedKalmanFilter,
};
use luenberger_linalg::dare;
use luenberger_plants::StateSpace;
use luenberger_sim::{Recording, Replay, ReplayedObserver};
use nalgebra::{DMatrix, DVector, Dyn, Rotation3, dmatrix, dvector};
use proptest::prelude::*;

/// `x' = T diag(modes) T' x + w` with an orthogonal T, in units of these sizes.
struct Solved {
    modes: [f64; 3],
    basis: DMatrix<f64>,
    inverse: DMatrix<f64>,
}

impl Solved {
    fn new(modes: [f64; 3], angles: [f64; 3], units: [f64; 3]) -> Self {
        let turn = Rotation3::from_euler_angles(angles[0], angles[1], angles[2]);
        let turn = DMatrix::from_column_slice(3, 3, turn.matrix().as_slice());
        let scale = DMatrix::from_diagonal(&DVector::from_row_slice(&units));
        let back = DMatrix::from_diagonal(&DVector::from_row_slice(&units.map(f64::recip)));
        Self { modes, basis: scale * &turn, inverse: turn.transpose() * back }
    }

    fn plant(&self, units: [f64; 3]) -> StateSpace {
        let a = &self.basis * DMatrix::from_diagonal(&DVector::from_row_slice(&self.modes)) * &self.inverse;
        let c = dmatrix![1.0 / units[0], 0.5 / units[1], 0.2 / units[2]];
        StateSpace::new(a, DMatrix::zeros(3, 0), c).unwrap()
    }

    /// exp(A h) and the covariance of the noise over h, in closed form.
    fn over(&self, h: f64, w: &DMatrix<f64>) -> (DMatrix<f64>, DMatrix<f64>) {
        let integral = |mode: f64| if mode == 0.0 { h } else { (mode * h).exp_m1() / mode };
        let exponential = DMatrix::from_diagonal(&DVector::from_row_slice(&self.modes.map(|mode| (mode * h).exp())));
        let inner = &self.inverse * w * self.inverse.transpose();
        let inner = DMatrix::from_fn(3, 3, |i, j| inner[(i, j)] * integral(self.modes[i] + self.modes[j]));
        let noise = &self.basis * inner * self.basis.transpose();
        (&self.basis * exponential * &self.inverse, (&noise + noise.transpose()) * 0.5)
    }
}

/// Filtered estimates with their covariances, and smoothed ones, row by row.
struct Reference {
    filtered: Vec<(DVector<f64>, DMatrix<f64>)>,
    smoothed: Vec<(DVector<f64>, DMatrix<f64>)>,
}

/// The Kalman filter, and the smoother of Rauch, Tung and Striebel with `G = P Phi' (P-)^-1`, in the units given.
fn reference(
    solved: &Solved,
    (c, w, v, p0): (&DMatrix<f64>, &DMatrix<f64>, f64, &DMatrix<f64>),
    (times, y): (&[f64], &[Option<f64>]),
    start: &DVector<f64>,
) -> Reference {
    let (mut x, mut p) = (start.clone(), p0.clone());
    let (mut filtered, mut predicted, mut ways) = (Vec::new(), Vec::new(), Vec::new());
    for (k, y) in y.iter().enumerate() {
        if let Some(y) = y {
            let s = (c * &p * c.transpose())[0] + v;
            let gain = &p * c.transpose() / s;
            let keep = DMatrix::identity(3, 3) - &gain * c;
            x = &x + &gain * (y - (c * &x)[0]);
            p = &keep * &p * keep.transpose() + &gain * v * gain.transpose();
        }
        filtered.push((x.clone(), p.clone()));
        if k + 1 < times.len() {
            let (phi, noise) = solved.over(times[k + 1] - times[k], w);
            x = &phi * &x;
            p = &phi * &p * phi.transpose() + noise;
            predicted.push((x.clone(), p.clone()));
            ways.push(phi);
        }
    }
    let mut smoothed = vec![filtered[times.len() - 1].clone()];
    for k in (0..times.len() - 1).rev() {
        let ((x, p), (ahead, spread)) = (&filtered[k], &predicted[k]);
        let factor = spread.clone().cholesky().unwrap();
        let gain = factor.solve(&(&ways[k] * p)).transpose();
        let (last, covariance) = smoothed.last().unwrap();
        let next = (x + &gain * (last - ahead), p + &gain * (covariance - spread) * gain.transpose());
        smoothed.push(next);
    }
    smoothed.reverse();
    Reference { filtered, smoothed }
}

fn one(replay: Replay<'_>) -> ReplayedObserver {
    replay.run().unwrap().observers.remove(0)
}

/// The largest difference in standard deviations.
fn distance(x: &DMatrix<f64>, exact: &[(DVector<f64>, DMatrix<f64>)]) -> f64 {
    let rows = exact.iter().enumerate();
    rows.map(|(k, (mean, p))| (0..3).fold(0.0, |most: f64, i| most.max((x[(k, i)] - mean[i]).abs() / p[(i, i)].sqrt())))
        .fold(0.0, f64::max)
}

type Moving = MovingHorizonEstimator<StateSpace, f64, Dyn, Dyn, Dyn, Dyn, 4>;

proptest! {
    #![proptest_config(ProptestConfig { cases: 48, failure_persistence: None, ..ProptestConfig::default() })]

    /// On a log with gaps and missing values: extended, unscented and moving-horizon filter, and both smoothers.
    #[test]
    fn smoothed_estimates_are_exact(
        fast in -8.0f64..3.0, slow in -3.0f64..1.0, unstable in -1.0f64..0.3,
        angles in prop::array::uniform3(-3.0f64..3.0), units in prop::array::uniform3(-15i32..15),
        roots in prop::array::uniform9(-1.0f64..1.0), v in 0.05f64..5.0, ys in prop::array::uniform9(-1.0f64..1.0),
        missing in 1usize..8, gaps in prop::array::uniform8(0.05f64..1.5),
    ) {
        let units = units.map(|k| 2f64.powi(k));
        let solved = Solved::new([-10f64.powf(fast), -10f64.powf(slow), unstable], angles, units);
        let plant = solved.plant(units);
        let root = DMatrix::from_diagonal(&DVector::from_row_slice(&units)) * DMatrix::from_row_slice(3, 3, &roots);
        let p0 = &root * root.transpose();
        let (w, p0) = ((&p0 + p0.transpose()) * 0.3, (&p0 + p0.transpose()) * 0.5);
        // Both smoothers divide by P-: its condition in units of the deviations bounds what they agree to.
        let deviations = p0.diagonal().map(f64::sqrt);
        let scaled = DMatrix::from_fn(3, 3, |i, j| p0[(i, j)] / (deviations[i] * deviations[j]));
        prop_assume!(scaled.symmetric_eigenvalues().min() > 1e-3);
        let mut times = vec![0.0];
        for gap in gaps {
            times.push(times[times.len() - 1] + gap);
        }
        let y: Vec<Option<f64>> = ys.iter().enumerate().map(|(k, y)| (k != missing).then_some(*y)).collect();
        let start = DVector::from_row_slice(&units) * 0.3;
        let exact = reference(&solved, (&plant.c, &w, v, &p0), (&times, &y), &start);
        let (column, none) = (DMatrix::from_column_slice(9, 1, &y), DMatrix::from_element(9, 0, None));
        let recording = Recording::with_missing(times.clone(), &none, &column).unwrap();
        let noises = || NoiseModel { w: w.clone(), v: dmatrix![v], p0: p0.clone() };
        let replay = || Replay::new(&plant, recording.clone());
        let extended = ExtendedKalmanFilter::error_controlled(plant.clone(), noises(), 0.4).unwrap();
        let unscented =
            UnscentedKalmanFilter::error_controlled(plant.clone(), noises(), SigmaPoints::default(), 0.4).unwrap();
        let horizon = Horizon { window: 4, iterations: 1 };
        let moving = Moving::error_controlled(plant.clone(), noises(), horizon, 0.4).unwrap().with_joined_predictions().unwrap();
        let stiffness = solved.modes.iter().fold(1.0, |most: f64, mode| most.max(mode.abs() * 1.5));
        let tolerance = 1e-9 * (1.0 + 1e-2 * stiffness);
        let first = start.as_slice();
        for found in [
            one(replay().smoothed_filter("extended", extended, first)),
            one(replay().smoothed_filter("unscented", unscented, first)),
            one(replay().filter("moving", moving, first)),
        ] {
            let of_filter = distance(&found.estimate, &exact.filtered);
            prop_assert!(of_filter <= tolerance, "{}: {of_filter} {:?}", found.name, solved.modes);
            if let Some(smoothed) = &found.smoothed {
                let of_smoother = distance(&smoothed.estimate, &exact.smoothed);
                prop_assert!(of_smoother <= 1e3 * tolerance, "{}: {of_smoother} {:?}", found.name, solved.modes);
            }
        }
    }

    /// After many samples the covariance before a measurement is the solution of the Riccati equation of the exact
    /// discretisation, for stiff plants too.
    #[test]
    fn filters_tend_to_the_stationary_one(
        fast in -6.0f64..3.0, slow in -2.0f64..0.5, angles in prop::array::uniform3(-3.0f64..3.0),
        roots in prop::array::uniform9(-1.0f64..1.0), v in 0.05f64..5.0, h in 0.1f64..1.0,
    ) {
        let solved = Solved::new([-10f64.powf(fast), -10f64.powf(slow), -0.7], angles, [1.0; 3]);
        let plant = solved.plant([1.0; 3]);
        let root = DMatrix::from_row_slice(3, 3, &roots) + DMatrix::identity(3, 3) * 0.2;
        let w = &root * root.transpose();
        let w = (&w + w.transpose()) * 0.5;
        let (phi, noise) = solved.over(h, &w);
        let stationary = dare(&phi.transpose(), &plant.c.transpose(), &noise, &dmatrix![v]).unwrap();
        let noises = NoiseModel { w, v: dmatrix![v], p0: stationary.x.clone() };
        let filter = ExtendedKalmanFilter::error_controlled(plant.clone(), noises, h).unwrap();
        let u = DVector::zeros(0);
        let mut state = luenberger::observers::SampledObserver::initial(&filter, 0.0, &DVector::zeros(3), &u, &dvector![0.0]);
        for k in 0..20 {
            let t = h * f64::from(k);
            prop_assert!(filter.update(t, &mut state, &u, &dvector![0.5]).is_some());
            prop_assert!(filter.predict(t, &mut state, &u, h));
            let (p, x) = (state.covariance(), &stationary.x);
            let size = x.amax();
            prop_assert!((p - x).amax() <= 1e-10 * size * (1.0 + 10f64.powf(fast)), "{k}: {:?}", solved.modes);
        }
    }
}
