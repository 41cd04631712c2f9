//! Filters of correlated noises: against the recursion of a linear plant by hand, least squares, and angles.

#![cfg(feature = "dual")]

use luenberger_observers::correlated::{CorrelatedFilter, DecorrelatedPlant, check_joint_covariance};
use luenberger_observers::{
    AdaptedFilter, CovarianceFilter, ExtendedKalmanFilter, NoiseModel, NoisesAlong, ObserverError, SampledObserver,
    SigmaPoints, UnscentedKalmanFilter,
};
use luenberger_plants::StateSpace;
use luenberger_random::Random;
use nalgebra::{DMatrix, DVector, Dyn, dmatrix, dvector};

type Plant = DecorrelatedPlant<StateSpace, f64>;
type Extended<A> = CorrelatedFilter<ExtendedKalmanFilter<Plant, f64, Dyn, Dyn, Dyn>, f64, A>;
type Unscented = CorrelatedFilter<UnscentedKalmanFilter<Plant, f64, Dyn, Dyn, Dyn>, f64, ()>;

fn extended<A: NoisesAlong<f64>>(
    plant: &StateSpace,
    noises: &NoiseModel<f64, Dyn, Dyn>,
    s: &DMatrix<f64>,
    along: A,
) -> Result<Extended<A>, ObserverError> {
    let plant = DecorrelatedPlant::new(plant.clone());
    let filter = ExtendedKalmanFilter::discrete(plant, noises.clone(), 0.1)?;
    CorrelatedFilter::new(AdaptedFilter::new(filter, along), s.clone())
}

fn unscented(plant: &StateSpace, noises: &NoiseModel<f64, Dyn, Dyn>, s: &DMatrix<f64>) -> Unscented {
    let plant = DecorrelatedPlant::new(plant.clone());
    let filter = UnscentedKalmanFilter::discrete(plant, noises.clone(), SigmaPoints::default(), 0.1).unwrap();
    CorrelatedFilter::new(AdaptedFilter::new(filter, ()), s.clone()).unwrap()
}

fn random_matrix(random: &mut Random, rows: usize, columns: usize) -> DMatrix<f64> {
    DMatrix::from_fn(rows, columns, |_, _| random.normal_pair()[0])
}

/// A plant with its noises, of which `[W S; S' V]` is positive definite.
fn random_case(random: &mut Random) -> (StateSpace, NoiseModel<f64, Dyn, Dyn>, DMatrix<f64>) {
    let (n, m, p) = (1 + random.below(4), 1 + random.below(2), 1 + random.below(3));
    let a = random_matrix(random, n, n) * (0.9 / n as f64);
    let plant = StateSpace::new(a, random_matrix(random, n, m), random_matrix(random, p, n)).unwrap();
    let factor = random_matrix(random, n + p, n + p) + DMatrix::identity(n + p, n + p) * 0.3;
    let joint = &factor * factor.transpose();
    let (w, v) = (joint.view((0, 0), (n, n)).into_owned(), joint.view((n, n), (p, p)).into_owned());
    let s = joint.view((0, n), (n, p)).into_owned();
    (plant, NoiseModel { w, v, p0: DMatrix::identity(n, n) * 2.0 }, s)
}

/// The recursion of the predictor, `K = (A P C' + S)(C P C' + V)^-1`, `xhat+ = A xhat + B u + K (y - C xhat)`,
/// `P+ = A P A' + W - K (C P C' + V) K'`, with the rows of C and V and the columns of S of what is measured.
fn predictor(
    plant: &StateSpace,
    (noises, s): (&NoiseModel<f64, Dyn, Dyn>, &DMatrix<f64>),
    (x, p): (&DVector<f64>, &DMatrix<f64>),
    (u, y, measured): (&DVector<f64>, &DVector<f64>, &[bool]),
) -> (DVector<f64>, DMatrix<f64>) {
    let rows: Vec<usize> = (0..y.nrows()).filter(|j| measured[*j]).collect();
    let c = plant.c.select_rows(&rows);
    let (v, s) = (noises.v.select_rows(&rows).select_columns(&rows), s.select_columns(&rows));
    let (next, spread) = (&plant.a * x + &plant.b * u, &plant.a * p * plant.a.transpose() + &noises.w);
    if rows.is_empty() {
        return (next, spread);
    }
    let innovation = y.select_rows(&rows) - &c * x;
    let r = &c * p * c.transpose() + v;
    let k = (&plant.a * p * c.transpose() + s) * r.clone().try_inverse().unwrap();
    (next + &k * innovation, spread - &k * r * k.transpose())
}

/// Estimates and covariances of predictions are those of the recursion by hand, with outputs that are missing.
#[test]
fn of_a_linear_plant_it_is_the_predictor_of_correlated_noises() {
    let mut random = Random(5);
    let mut partial = 0;
    for _ in 0..60 {
        let (plant, noises, s) = random_case(&mut random);
        let (n, m, p) = (plant.a.nrows(), plant.b.ncols(), plant.c.nrows());
        let (ekf, ukf) = (extended(&plant, &noises, &s, ()).unwrap(), unscented(&plant, &noises, &s));
        let (mut x, mut spread) = (random_matrix(&mut random, n, 1).column(0).into_owned(), noises.p0.clone());
        let (u0, y0) = (DVector::zeros(m), DVector::zeros(p));
        let mut of_ekf = ekf.initial(0.0, &x, &u0, &y0);
        let mut of_ukf = ukf.initial(0.0, &x, &u0, &y0);
        for k in 0..30 {
            let t = 0.1 * f64::from(k);
            let u = random_matrix(&mut random, m, 1).column(0).into_owned();
            let y = random_matrix(&mut random, p, 1).column(0) * 3.0;
            let measured: Vec<bool> = (0..p).map(|_| random.below(4) > 0).collect();
            partial += usize::from(measured.contains(&true) && measured.contains(&false));
            (x, spread) = predictor(&plant, (&noises, &s), (&x, &spread), (&u, &y, &measured));
            ekf.step_partial(t, &mut of_ekf, &u, &y, &measured);
            // What is not finite is not measured.
            let y = DVector::from_fn(p, |j, _| if measured[j] { y[j] } else { f64::NAN });
            ukf.step(t, &mut of_ukf, &u, &y);
            let scale = 1.0 + x.norm() + spread.norm();
            for (name, estimate, state) in [("ekf", ekf.estimate(&of_ekf), 0), ("ukf", ukf.estimate(&of_ukf), 1)] {
                let mut own = vec![0.0; n * n];
                let fits = if state == 0 {
                    ekf.covariance_into(&of_ekf, &mut own)
                } else {
                    ukf.covariance_into(&of_ukf, &mut own)
                };
                assert!(fits);
                let off = (estimate - &x).norm() + (DMatrix::from_vec(n, n, own) - &spread).norm();
                assert!(off < 1e-10 * scale, "{name}, step {k}: {off}");
            }
        }
    }
    assert!(partial > 200, "{partial}");
}

/// A sample of its own V keeps the correlations: the recursion by hand has S scaled as the deviations of v.
#[test]
fn another_v_scales_the_cross_covariance() {
    struct Varying;
    impl NoisesAlong<f64> for Varying {
        fn measurement_noise(&self, t: f64, _: &[f64], _: &[f64], v: &mut [f64]) -> bool {
            v[0] = 0.2 * (1.0 + t);
            true
        }
    }
    let plant = StateSpace::new(dmatrix![0.9, 0.2; 0.0, 0.7], dmatrix![0.0; 1.0], dmatrix![1.0, 0.0]).unwrap();
    let noises = NoiseModel { w: dmatrix![0.3, 0.1; 0.1, 0.4], v: dmatrix![0.2], p0: DMatrix::identity(2, 2) };
    let s = dmatrix![0.15; -0.1];
    let filter = extended(&plant, &noises, &s, Varying).unwrap();
    let (mut x, mut spread) = (dvector![1.0, 0.0], noises.p0.clone());
    let mut state = filter.initial(0.0, &x, &dvector![0.0], &dvector![0.0]);
    for k in 0..20 {
        let t = 0.1 * f64::from(k);
        let (u, y) = (dvector![t.cos()], dvector![(3.0 * t).sin()]);
        let now = NoiseModel { v: dmatrix![0.2 * (1.0 + t)], ..noises.clone() };
        let scaled = &s * (1.0 + t).sqrt();
        (x, spread) = predictor(&plant, (&now, &scaled), (&x, &spread), (&u, &y, &[true]));
        filter.step(t, &mut state, &u, &y);
        assert!((filter.estimate(&state) - &x).norm() < 1e-12, "{x}");
    }
}

/// Noise that the measurement tells exactly: W - S V^-1 S' is zero, in units far apart too.
#[test]
fn noise_that_is_measured_leaves_no_error() {
    for unit in [1.0, 1e-6, 3e7] {
        let plant =
            StateSpace::new(dmatrix![0.5, 0.1; 0.0, 0.8], dmatrix![0.0; 0.0], dmatrix![1.0 / unit, 0.0]).unwrap();
        // w = (0.3, -0.7) unit v.
        let w = dmatrix![0.09, -0.21; -0.21, 0.49] * (unit * unit);
        let noises = NoiseModel { w, v: dmatrix![1.0], p0: DMatrix::zeros(2, 2) };
        let s = dmatrix![0.3; -0.7] * unit;
        let (ekf, ukf) = (extended(&plant, &noises, &s, ()).unwrap(), unscented(&plant, &noises, &s));
        let zero = dvector![0.0];
        let mut x = dvector![unit, -unit];
        let mut states = [ekf.initial(0.0, &x, &zero, &zero), ukf.initial(0.0, &x, &zero, &zero)];
        let mut random = Random(2);
        for k in 0..40 {
            let t = 0.1 * f64::from(k);
            let v = random.normal_pair()[0];
            let y = dvector![x[0] / unit + v];
            x = &plant.a * &x + dvector![0.3, -0.7] * (unit * v);
            ekf.step(t, &mut states[0], &zero, &y);
            ukf.step(t, &mut states[1], &zero, &y);
            for estimate in [ekf.estimate(&states[0]), ukf.estimate(&states[1])] {
                assert!((estimate - &x).norm() < 1e-12 * unit, "{x}");
            }
        }
    }
}

/// Readings of an angle that jump by full turns, and predictions across the jump, change nothing but full turns.
#[test]
fn the_correction_of_a_prediction_is_of_angles() {
    let plant = StateSpace::new(dmatrix![1.0, 0.1; 0.0, 1.0], dmatrix![0.0; 0.0], dmatrix![1.0, 0.0]).unwrap();
    let noises = NoiseModel { w: dmatrix![4.0, 0.0; 0.0, 1.0], v: dmatrix![9.0], p0: DMatrix::identity(2, 2) };
    let s = dmatrix![3.0; 1.0];
    let of = |turn: f64| {
        let inner = DecorrelatedPlant::new(plant.clone()).with_angles(dvector![turn]).unwrap();
        let filter = ExtendedKalmanFilter::discrete(inner, noises.clone(), 0.1).unwrap();
        let filter = filter.with_angles(dvector![turn]).unwrap();
        CorrelatedFilter::new(AdaptedFilter::new(filter, ()), s.clone()).unwrap()
    };
    let (going_on, jumping) = (of(0.0), of(360.0));
    let zero = dvector![0.0];
    let first = dvector![170.0, 50.0];
    let mut states = [going_on.initial(0.0, &first, &zero, &zero), jumping.initial(0.0, &first, &zero, &zero)];
    for k in 0..200 {
        let t = 0.1 * f64::from(k);
        let heading = 170.0 + 50.0 * t + 5.0 * (7.0 * t).sin();
        going_on.step(t, &mut states[0], &zero, &dvector![heading]);
        jumping.step(t, &mut states[1], &zero, &dvector![(heading + 180.0).rem_euclid(360.0) - 180.0]);
        let off = going_on.estimate(&states[0]) - jumping.estimate(&states[1]);
        assert!(off.norm() < 1e-9, "{off}");
    }
    assert!(going_on.estimate(&states[0])[0] > 1000.0);
}

#[test]
fn what_does_not_fit_is_refused() {
    let plant = StateSpace::new(dmatrix![0.5], dmatrix![1.0], dmatrix![1.0]).unwrap();
    let noises = NoiseModel { w: dmatrix![0.04], v: dmatrix![0.09], p0: dmatrix![1.0] };
    let refused = |s: DMatrix<f64>| extended(&plant, &noises, &s, ()).unwrap_err();
    // 0.06 is the largest.
    assert!(extended(&plant, &noises, &dmatrix![0.06], ()).is_ok());
    assert!(matches!(refused(dmatrix![0.0601]), ObserverError::NotDefinite { what: "[W S; S' V]", .. }));
    assert!(matches!(refused(dmatrix![f64::NAN]), ObserverError::Matrix(_)));
    assert!(matches!(refused(dmatrix![0.0; 0.0]), ObserverError::Matrix(_)));
    let zero = check_joint_covariance(&dmatrix![0.0], &dmatrix![1.0], &dmatrix![1e-9]);
    assert!(matches!(zero, Err(ObserverError::NotDefinite { .. })));
    let inner = DecorrelatedPlant::new(plant.clone());
    let continuous = ExtendedKalmanFilter::new(inner, noises.clone(), 0.1, 1).unwrap();
    let found = CorrelatedFilter::new(AdaptedFilter::new(continuous, ()), dmatrix![0.01]).unwrap_err();
    assert_eq!(found.to_string(), "correlated noises are for filters of plants in discrete time");
    // A plant without inputs for y and K.
    let other = StateSpace::new(dmatrix![0.5], DMatrix::zeros(1, 0), dmatrix![1.0]).unwrap();
    let plain = ExtendedKalmanFilter::discrete(other, noises, 0.1).unwrap();
    let found = CorrelatedFilter::new(AdaptedFilter::new(plain, ()), dmatrix![0.01]).unwrap_err();
    assert!(matches!(found, ObserverError::Table { expected: 2, found: 0, .. }));
}

/// Columns of other lengths change nothing, and an input that is not finite loses the estimate.
#[test]
fn bad_samples_are_answered() {
    let plant = StateSpace::new(dmatrix![0.5], dmatrix![1.0], dmatrix![1.0]).unwrap();
    let noises = NoiseModel { w: dmatrix![0.04], v: dmatrix![0.09], p0: dmatrix![1.0] };
    let filter = extended(&plant, &noises, &dmatrix![0.03], ()).unwrap();
    let (u, y) = (dvector![0.1], dvector![0.2]);
    let first = filter.initial(0.0, &dvector![1.0], &u, &y);
    let mut state = first.clone();
    filter.step(0.0, &mut state, &dvector![0.1, 0.2], &y);
    filter.step(0.0, &mut state, &u, &dvector![0.1, 0.2]);
    assert_eq!(state, first);
    assert!(filter.measure(0.0, &mut state, &dvector![], &y, &[true]).is_none());
    assert!(!filter.advance(0.0, &mut state, &dvector![], 0.1));
    assert!(!filter.advance(0.0, &mut state, &dvector![f64::NAN], 0.1));
    assert_eq!(state, first);
    filter.step(0.0, &mut state, &dvector![f64::NAN], &y);
    assert!(filter.estimate(&state)[0].is_nan());
    let mut short = [0.0];
    assert!(!filter.step_into(0.0, &mut short, &[0.1], &[0.2], &[]));
}
