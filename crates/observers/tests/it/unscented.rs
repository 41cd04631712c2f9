//! The unscented Kalman filter: against filterpy on a nonlinear plant, against the Kalman filter on linear ones, and
//! where it has no factor.

#![cfg(feature = "dual")]

use luenberger_observers::unscented::{SigmaPoints, SquareRootEstimate, UnscentedKalmanFilter};
use luenberger_observers::{
    CovarianceFilter, ExtendedKalmanFilter, KalmanFilter, KalmanModel, NoiseModel, ObserverError, Prediction,
    SampledObserver,
};
use luenberger_plants::{ByDual, Column, Dimensions, LinearPlant, Plant, Shape, StaticPlant, double_integrator, plant};
use nalgebra::{Const, DMatrix, DVector, Matrix1, Matrix2, Matrix3, RealField, SMatrix, SVector, Vector1, Vector2};
use proptest::prelude::*;

use crate::pendulum::{Pendulum, noises};

/// filterpy 2.0.0, `UnscentedKalmanFilter` with `MerweScaledSigmaPoints(2, alpha, beta, kappa)`: five times
/// `update(z)`, `predict()` and a sixth update, sigma points drawn before each. alpha = 1, beta = 0, kappa = 1 has a
/// positive centre, alpha = 0.3 a negative one.
#[test]
fn the_numbers_are_those_of_filterpy() {
    let cases = [
        (
            SigmaPoints { alpha: 1.0, beta: 2.0, kappa: 0.0 },
            [0.7246929528886059, -0.4428433160857196],
            [0.04248045265489271, 0.01711617425324349, 0.06479958941987023],
            [0.7569033607419754, -0.4642244364849349],
            0.1226817018539187,
        ),
        (
            SigmaPoints { alpha: 0.3, beta: 2.0, kappa: 1.0 },
            [0.7173951356944039, -0.44528159553931834],
            [0.04072908613805038, 0.017404377203666638, 0.06564367767216733],
            [0.7513558515999942, -0.46618152282485964],
            0.1363526040627741,
        ),
        (
            SigmaPoints { alpha: 1.0, beta: 0.0, kappa: 1.0 },
            [0.7268014580466229, -0.4448636591953859],
            [0.043114152831712216, 0.017315439359231063, 0.0642813013302127],
            [0.7586583015660112, -0.4655461327499097],
            0.11736948723018126,
        ),
    ];
    for (sigma, x, p, after, nis) in cases {
        let filter = UnscentedKalmanFilter::discrete(Pendulum, noises(), sigma, 0.1).unwrap();
        let u = SVector::zeros();
        let mut estimate = filter.initial(0.0, &Vector2::new(0.5, -0.2), &u, &Vector2::zeros());
        for k in 0..5 {
            let k = f64::from(k);
            filter.step(0.0, &mut estimate, &u, &Vector2::new((0.8 - 0.02 * k).sin(), -0.1 * k + 0.05));
        }
        assert!((estimate.estimate() - Vector2::from(x)).amax() < 1e-13, "{sigma:?}: {}", estimate.estimate());
        let expected = Matrix2::new(p[0], p[1], p[1], p[2]);
        assert!((estimate.covariance() - expected).amax() < 1e-13, "{sigma:?}: {}", estimate.covariance());
        let innovation = filter.update(0.5, &mut estimate, &u, &Vector2::new(0.7, -0.4)).unwrap();
        assert!((estimate.estimate() - Vector2::from(after)).amax() < 1e-13, "{sigma:?}: {}", estimate.estimate());
        assert!((innovation.normalized_square - nis).abs() < 1e-12, "{}", innovation.normalized_square);
    }
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 64, failure_persistence: None, ..ProptestConfig::default() })]

    /// Of a linear plant in discrete time it is the Kalman filter, for every alpha, with outputs that are missing.
    /// Where the centre has a negative weight, rounding alone can make what is left of a singular covariance
    /// indefinite: then it says so, and the estimate is unchanged.
    #[test]
    fn the_filter_of_a_linear_plant_is_kalmans(
        a in prop::array::uniform9(-1.0f64..1.0), c in prop::array::uniform6(-1.0f64..1.0),
        roots in prop::array::uniform9(-1.0f64..1.0), v in prop::array::uniform2(0.05f64..1.0), rho in -0.9f64..0.9,
        alpha in 0.2f64..1.5, kappa in -1.0f64..2.0, ys in prop::array::uniform8(-1.0f64..1.0), missing in 0usize..3,
    ) {
        let (ad, c) = (Matrix3::from_row_slice(&a), SMatrix::<f64, 2, 3>::from_row_slice(&c));
        let root = Matrix3::from_row_slice(&roots);
        let sigma = SigmaPoints { alpha, beta: 2.0, kappa };
        // W of rank two.
        let (p0, w) = (root * root.transpose(), root.columns(0, 2) * root.columns(0, 2).transpose());
        let may_fail = sigma.weights::<f64>(3).unwrap().is_negative;
        let cross = rho * (v[0] * v[1]).sqrt();
        let v = Matrix2::new(v[0], cross, cross, v[1]);
        let bd = SMatrix::<f64, 3, 1>::new(0.1, 0.2, 0.3);
        let kalman = KalmanFilter::new(KalmanModel { ad, bd, c, w, v, p0, period: 1.0 }).unwrap();
        let plant = StaticPlant::new(ad, bd, c).unwrap();
        let filter = UnscentedKalmanFilter::discrete(plant, NoiseModel { w, v, p0 }, sigma, 1.0).unwrap();
        let (u, start) = (Vector1::new(0.7), nalgebra::Vector3::new(0.3, -0.2, 0.1));
        let mut exact = kalman.initial(0.0, &start, &u, &Vector2::zeros());
        let mut found = filter.initial(0.0, &start, &u, &Vector2::zeros());
        for (k, y) in ys.chunks(2).enumerate() {
            let measured = |output: usize| k != 1 || output != missing;
            let y = Vector2::new(y[0], y[1]);
            let one = kalman.update_partial(&mut exact, &u, &y, measured).unwrap();
            let before = found.clone();
            let Some(other) = filter.update_partial(0.0, &mut found, &u, &y, measured) else {
                prop_assert!(may_fail && found == before);
                return Ok(());
            };
            prop_assert!((one.covariance - other.covariance).amax() <= 1e-12, "{} {}", one.covariance, other.covariance);
            prop_assert!((one.normalized_square - other.normalized_square).abs() <= 1e-11);
            prop_assert!(kalman.predict(&mut exact, &u));
            let before = found.clone();
            if !filter.predict(0.0, &mut found, &u, 1.0) {
                prop_assert!(may_fail && found == before);
                return Ok(());
            }
            // Covariances grow to about 1e2; 25 epsilon / alpha^2 is the cancellation of the weights.
            prop_assert!((exact.estimate() - found.estimate()).amax() <= 1e-11);
            prop_assert!((exact.covariance() - found.covariance()).amax() <= 1e-11);
        }
    }

    /// The double integrator is moved exactly by one Runge-Kutta step, and its noise too:
    /// Q = [w1 h + w2 h^3/3, w2 h^2/2; w2 h^2/2, w2 h].
    #[test]
    fn a_prediction_in_continuous_time(
        h in 0.01f64..1.0, root in prop::array::uniform4(-1.0f64..1.0), w in prop::array::uniform2(0.0f64..2.0),
    ) {
        let root = Matrix2::from_row_slice(&root);
        let (p0, w) = (root * root.transpose(), Matrix2::from_diagonal(&Vector2::from(w)));
        let noises = NoiseModel { w, v: Matrix1::new(0.1), p0 };
        let filter = UnscentedKalmanFilter::new(double_integrator(), noises, SigmaPoints::default(), h, 1).unwrap();
        let (x, u) = (Vector2::new(1.0, -0.5), Vector1::new(2.0));
        let mut estimate = filter.initial(0.0, &x, &u, &Vector1::zeros());
        let mut across = [0.0; 4];
        prop_assert!(filter.advance_across(0.0, &mut estimate, &u, h, &mut across));
        let phi = Matrix2::new(1.0, h, 0.0, 1.0);
        let [w1, w2] = [w[(0, 0)], w[(1, 1)]];
        let noise = Matrix2::new(w1 * h + w2 * h.powi(3) / 3.0, w2 * h * h / 2.0, w2 * h * h / 2.0, w2 * h);
        let expected = phi * p0 * phi.transpose() + noise;
        prop_assert!((estimate.covariance() - expected).amax() <= 1e-13);
        prop_assert!((estimate.estimate() - phi * x - Vector2::new(h * h, 2.0 * h)).amax() <= 1e-14);
        // E e(0) e(h)' = P Phi'.
        prop_assert!((Matrix2::from_column_slice(&across) - p0 * phi.transpose()).amax() <= 1e-13);
    }
}

/// x+ = x, y = x^2.
struct Square;

plant!(Square, (1, 0, 1), |plant, t, x, u| [x[0]], [x[0] * x[0]]);

/// x+ = sqrt(x), y = ln(x).
struct Root;

plant!(Root, (1, 0, 1), |plant, t, x, u| [x[0].sqrt()], [x[0].ln()]);

/// Where the sample variance of a scalar square is known: x ~ N(0, 1), y = x^2 + v has mean 1, variance 2 + V, and no
/// covariance with x; for every alpha with beta = 2.
#[test]
fn the_variance_of_a_square_is_exact() {
    let one = Matrix1::new(1.0_f64);
    for alpha in [1.0, 0.5, 0.1] {
        let sigma = SigmaPoints { alpha, ..SigmaPoints::default() };
        let noises = NoiseModel { w: Matrix1::zeros(), v: one, p0: one };
        let filter = UnscentedKalmanFilter::discrete(Square, noises, sigma, 1.0).unwrap();
        let mut estimate = filter.initial(0.0, &Vector1::zeros(), &SVector::zeros(), &Vector1::zeros());
        let innovation = filter.update(0.0, &mut estimate, &SVector::zeros(), &Vector1::new(4.0)).unwrap();
        assert!((innovation.value[0] - 3.0).abs() < 1e-12 && (innovation.covariance[0] - 3.0).abs() < 1e-12);
        assert!(estimate.estimate()[0].abs() < 1e-12 && (estimate.covariance()[0] - 1.0).abs() < 1e-12);
    }
}

/// An update or a prediction without a factor is reported, and the estimate is unchanged; a step without a prediction
/// is NaN.
#[test]
fn a_failed_factorisation_is_an_answer() {
    let noises = |p0: f64| NoiseModel { w: Matrix1::zeros(), v: Matrix1::new(0.01), p0: Matrix1::new(p0) };
    let of = |p0, sigma| UnscentedKalmanFilter::discrete(Root, noises(p0), sigma, 1.0).unwrap();
    let (u, y) = (SVector::zeros(), Vector1::new(0.0));
    // One standard deviation below 0.5 is no number.
    let filter = of(1.0, SigmaPoints::default());
    let start = filter.initial(0.0, &Vector1::new(0.5), &u, &y);
    let mut estimate = start.clone();
    assert!(filter.update(0.0, &mut estimate, &u, &y).is_none() && estimate == start);
    assert!(!filter.predict(0.0, &mut estimate, &u, 1.0) && estimate == start);
    filter.step(0.0, &mut estimate, &u, &y);
    assert!(estimate.estimate()[0].is_nan());
    // Closer points are in the domain. beta = -10 gives the centre so negative a weight that no covariance is left.
    let near = SigmaPoints { alpha: 0.1, ..SigmaPoints::default() };
    assert!(of(1.0, near).predict(0.0, &mut start.clone(), &u, 1.0));
    let filter = of(1.0, SigmaPoints { beta: -10.0, ..near });
    let mut estimate = start.clone();
    assert!(!filter.predict(0.0, &mut estimate, &u, 1.0) && estimate == start);
}

/// The gate rejects as that of the extended filter, which is the same on a linear plant.
#[test]
fn a_gate_rejects_outliers() {
    let plant =
        StaticPlant::<f64, 2, 1, 2>::new(Matrix2::new(0.0, 1.0, 0.0, 0.0), Vector2::new(0.0, 1.0), Matrix2::identity())
            .unwrap();
    let v = Matrix2::new(0.04, 0.01, 0.01, 0.09);
    let noises = NoiseModel { w: Matrix2::identity() * 0.1, v, p0: Matrix2::new(0.12, 0.0, 0.0, 0.16) };
    let extended = ExtendedKalmanFilter::new(plant.clone(), noises.clone(), 0.1, 1).unwrap().with_gate(4.0).unwrap();
    let plain = UnscentedKalmanFilter::new(plant, noises, SigmaPoints::default(), 0.1, 1).unwrap();
    let gated = plain.clone().with_gate(4.0).unwrap();
    let u = Vector1::new(0.0);
    let start = plain.initial(0.0, &Vector2::zeros(), &u, &Vector2::zeros());
    let same = extended.initial(0.0, &Vector2::zeros(), &u, &Vector2::zeros());
    for (y, rejected) in [
        (Vector2::new(1.5, -1.9), [false, false]),
        (Vector2::new(1.7, -1.9), [true, false]),
        (Vector2::new(9.0, 9.0), [true, true]),
    ] {
        assert!((0..2).all(|j| gated.rejects(0.0, &start, &u, &y, j) == rejected[j]));
        let (mut found, mut expected, mut linear) = (start.clone(), start.clone(), same.clone());
        gated.update(0.0, &mut found, &u, &y).unwrap();
        plain.update_partial(0.0, &mut expected, &u, &y, |j| !rejected[j]).unwrap();
        extended.update(0.0, &mut linear, &u, &y).unwrap();
        assert_eq!(found, expected);
        assert!((found.estimate() - linear.estimate()).amax() < 1e-14);
        assert!((found.covariance() - linear.covariance()).amax() < 1e-14);
    }
    assert!(plain.clone().with_gate(0.0).is_err() && plain.with_gate(f64::NAN).is_err());
}

/// The same with sizes known at run time.
#[derive(Clone, Debug)]
struct DynamicPendulum;

impl Shape for DynamicPendulum {
    fn dimensions(&self) -> Dimensions {
        Pendulum.dimensions()
    }
}

impl ByDual for DynamicPendulum {}

impl<T: RealField + Copy> Plant<T> for DynamicPendulum {
    type State = DVector<T>;
    type Input = DVector<T>;
    type Output = DVector<T>;

    fn derivative(&self, t: T, x: &DVector<T>, _u: &DVector<T>) -> DVector<T> {
        DVector::from_column_slice(Pendulum.derivative(t, &Vector2::new(x[0], x[1]), &SVector::zeros()).as_slice())
    }

    fn output(&self, t: T, x: &DVector<T>, _u: &DVector<T>) -> DVector<T> {
        DVector::from_column_slice(Pendulum.output(t, &Vector2::new(x[0], x[1]), &SVector::zeros()).as_slice())
    }
}

/// Run-time sizes give the same bits, and f32 is near.
#[test]
fn sizes_and_formats() {
    let fixed = UnscentedKalmanFilter::discrete(Pendulum, noises(), SigmaPoints::default(), 0.1).unwrap();
    let dynamic = |m: Matrix2<f64>| DMatrix::from_column_slice(2, 2, m.as_slice());
    let NoiseModel { w, v, p0 } = noises();
    let same = NoiseModel { w: dynamic(w), v: dynamic(v), p0: dynamic(p0) };
    let dynamic = UnscentedKalmanFilter::discrete(DynamicPendulum, same, SigmaPoints::default(), 0.1).unwrap();
    let single = NoiseModel { w: w.map(|x| x as f32), v: v.map(|x| x as f32), p0: p0.map(|x| x as f32) };
    let single = UnscentedKalmanFilter::discrete(Pendulum, single, SigmaPoints::default(), 0.1f32).unwrap();
    let (u, none) = (SVector::zeros(), DVector::zeros(0));
    let mut one = fixed.initial(0.0, &Vector2::new(0.5, -0.2), &u, &Vector2::zeros());
    let mut other = dynamic.initial(0.0, &DVector::from_vec(vec![0.5, -0.2]), &none, &DVector::zeros(2));
    let mut third = single.initial(0.0, &Vector2::new(0.5, -0.2), &SVector::zeros(), &Vector2::zeros());
    for k in 0..10 {
        let y = Vector2::new((0.8 - 0.02 * f64::from(k)).sin(), -0.1 * f64::from(k) + 0.05);
        fixed.step(0.0, &mut one, &u, &y);
        dynamic.step(0.0, &mut other, &none, &DVector::from_column_slice(y.as_slice()));
        single.step(0.0, &mut third, &SVector::zeros(), &y.map(|x| x as f32));
        assert_eq!(one.as_slice(), other.as_slice());
        assert!((one.estimate() - third.estimate().map(f64::from)).amax() < 1e-5);
    }
    assert_eq!(other.as_slice().len(), dynamic.dimensions().state);
    assert_eq!(SquareRootEstimate::<f64, Const<2>>::fixed_len(), Some(6));
}

#[test]
fn bad_data_are_errors() {
    let plant =
        || LinearPlant { a: Matrix2::zeros(), b: SMatrix::<f64, 2, 0>::zeros(), c: Matrix2::identity(), d: None };
    let make = |noises, sigma| UnscentedKalmanFilter::new(plant(), noises, sigma, 0.1, 1).map(|_| ());
    let sigma = SigmaPoints::default();
    assert_eq!(make(noises(), sigma), Ok(()));
    let zero = SigmaPoints { alpha: 0.0, ..sigma };
    assert_eq!(make(noises(), zero), Err(ObserverError::NotPositive { what: "alpha", value: 0.0 }));
    let below = SigmaPoints { kappa: -2.0, ..sigma };
    assert_eq!(make(noises(), below), Err(ObserverError::NotPositive { what: "n + kappa", value: 0.0 }));
    let infinite = SigmaPoints { beta: f64::INFINITY, ..sigma };
    assert!(matches!(make(noises(), infinite), Err(ObserverError::NotFinite { what: "beta", .. })));
    let flat = NoiseModel { v: Matrix2::zeros(), ..noises() };
    assert!(matches!(make(flat, sigma), Err(ObserverError::NotDefinite { what: "V", .. })));
    let factors = |w: Matrix2<f64>, v: Matrix2<f64>| {
        let factors = NoiseModel { w, v, p0: Matrix2::identity() };
        UnscentedKalmanFilter::from_factors(plant(), factors, sigma, 0.1, Prediction::RungeKutta(1)).map(|_| ())
    };
    let (one, upper) = (Matrix2::identity(), Matrix2::new(1.0, 0.5, 0.0, 1.0));
    assert_eq!(factors(Matrix2::zeros(), one), Ok(()));
    assert_eq!(
        factors(upper, one),
        Err(ObserverError::NotTriangular { what: "W^(1/2)", row: 0, column: 1, entry: 0.5 })
    );
    assert!(matches!(factors(one, Matrix2::zeros()), Err(ObserverError::NotDefinite { what: "V^(1/2)", .. })));
    assert!(matches!(factors(-one, one), Err(ObserverError::NotDefinite { what: "W^(1/2)", .. })));
    let steps = UnscentedKalmanFilter::new(plant(), noises(), sigma, 0.1, 0);
    assert_eq!(steps.map(|_| ()), Err(ObserverError::Substeps));
}
