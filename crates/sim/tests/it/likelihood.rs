//! The log-likelihood of a filter on a log is that of the normal distribution of the whole record, whose covariance is
//! dense and knows no recursion.

use luenberger_observers::{
    CovarianceFilter, ExtendedKalmanFilter, KalmanFilter, KalmanModel, NoiseModel, Prediction, SigmaPoints,
    UnscentedKalmanFilter,
};
use luenberger_plants::StateSpace;
use luenberger_random::Random;
use luenberger_sim::replay::{Recording, Replay};
use nalgebra::{DMatrix, DVector, dmatrix};

const ROWS: usize = 12;

struct Case {
    plant: StateSpace,
    w: DMatrix<f64>,
    v: DMatrix<f64>,
    p0: DMatrix<f64>,
    initial: [f64; 2],
    u: DMatrix<Option<f64>>,
    y: DMatrix<Option<f64>>,
}

/// A random record of a stable plant with correlated noises, of which a third was not measured.
fn case(seed: u64) -> Case {
    let mut random = Random(seed);
    let plant =
        StateSpace::new(dmatrix![0.9, 0.4; -0.2, 0.7], dmatrix![0.5; 1.0], dmatrix![1.0, 0.3; -0.4, 1.0]).unwrap();
    let mut square = |n: usize| {
        let root = random.matrix(n, n);
        &root * root.transpose() + DMatrix::identity(n, n) * 0.1
    };
    let (w, v, p0) = (square(2), square(2), square(2));
    let u = DMatrix::from_fn(ROWS, 1, |_, _| Some(random.unit()));
    let y = DMatrix::from_fn(ROWS, 2, |_, _| {
        let y = 3.0 * random.unit();
        (!random.once_in(3)).then_some(y)
    });
    Case { plant, w, v, p0, initial: [0.7, -0.3], u, y }
}

/// `ln N(y; E y, cov y)` of all measurements as one vector: `E x_k` and `cov(x_j, x_k)` by powers of A.
fn joint(case: &Case) -> f64 {
    let (a, b, c) = (&case.plant.a, &case.plant.b, &case.plant.c);
    let mut mean = vec![DVector::from_column_slice(&case.initial)];
    let mut variance = vec![case.p0.clone()];
    for k in 0..ROWS - 1 {
        mean.push(a * &mean[k] + b * case.u[(k, 0)].unwrap());
        variance.push(a * &variance[k] * a.transpose() + &case.w);
    }
    let measured: Vec<(usize, usize)> =
        (0..ROWS).flat_map(|k| [(k, 0), (k, 1)]).filter(|place| case.y[*place].is_some()).collect();
    let power = |k: usize| (0..k).fold(DMatrix::identity(2, 2), |power: DMatrix<f64>, _| a * power);
    let covariance = DMatrix::from_fn(measured.len(), measured.len(), |one, other| {
        let ((j, p), (k, q)) = (measured[one.max(other)], measured[one.min(other)]);
        let of_states = power(j - k) * &variance[k];
        let noise = if j == k { case.v[(p, q)] } else { 0.0 };
        (c.row(p) * of_states * c.row(q).transpose())[0] + noise
    });
    let error = DVector::from_fn(measured.len(), |one, _| {
        let (k, p) = measured[one];
        case.y[(k, p)].unwrap() - (c.row(p) * &mean[k])[0]
    });
    let cholesky = covariance.cholesky().unwrap();
    let determinant = 2.0 * cholesky.l_dirty().diagonal().iter().map(|x| x.ln()).sum::<f64>();
    let square = error.dot(&cholesky.solve(&error));
    -0.5 * (measured.len() as f64 * std::f64::consts::TAU.ln() + determinant + square)
}

fn of_filter(case: &Case, filter: impl CovarianceFilter<f64>) -> f64 {
    let t = (0..ROWS).map(|k| k as f64).collect();
    let recording = Recording::with_missing(t, &case.u, &case.y).unwrap();
    let replayed = Replay::new(&case.plant, recording).filter("filter", filter, &case.initial).run().unwrap();
    let consistency = replayed.observers[0].consistency.as_ref().unwrap();
    for (k, likelihood) in consistency.log_likelihood.iter().enumerate() {
        assert_eq!(likelihood.is_some(), case.y.row(k).iter().any(Option::is_some), "row {k}");
    }
    consistency.log_likelihood.iter().flatten().sum()
}

#[test]
fn the_likelihood_of_every_filter_is_that_of_the_joint_distribution() {
    for seed in 0..20 {
        let case = case(seed);
        let expected = joint(&case);
        let noises = NoiseModel { w: case.w.clone(), v: case.v.clone(), p0: case.p0.clone() };
        let linear = KalmanFilter::new(KalmanModel {
            ad: case.plant.a.clone(),
            bd: case.plant.b.clone(),
            c: case.plant.c.clone(),
            w: case.w.clone(),
            v: case.v.clone(),
            p0: case.p0.clone(),
            period: 1.0,
        });
        let extended = ExtendedKalmanFilter::discrete(case.plant.clone(), noises.clone(), 1.0)
            .and_then(|filter| filter.with_prediction(Prediction::Discrete));
        let unscented = UnscentedKalmanFilter::discrete(case.plant.clone(), noises, SigmaPoints::default(), 1.0)
            .and_then(|filter| filter.with_prediction(Prediction::Discrete));
        let found = [
            ("linear", of_filter(&case, linear.unwrap())),
            ("extended", of_filter(&case, extended.unwrap())),
            ("unscented", of_filter(&case, unscented.unwrap())),
        ];
        for (name, found) in found {
            assert!((found - expected).abs() < 1e-9, "{name}, seed {seed}: {found} and {expected}");
        }
    }
}
