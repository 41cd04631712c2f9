//! The Kalman filter in discrete time: against the information form, against the Riccati equation, with samples
//! missing.

use luenberger_observers::{
    GaussianEstimate, KalmanFilter, KalmanModel, ObserverError, SampledObserver, StaticKalmanFilter,
};
use luenberger_plants::PlantError;
use nalgebra::{
    DMatrix, DVector, Matrix1, Matrix2, Matrix2x3, Matrix3, RowVector3, SMatrix, SVector, Vector1, Vector2, Vector3,
};
use proptest::prelude::*;

/// Three states, two outputs with correlated noise, W of rank one.
fn model() -> KalmanModel<f64, nalgebra::Const<3>, nalgebra::Const<1>, nalgebra::Const<2>> {
    let g = Vector3::new(0.1, 0.2, 0.4);
    KalmanModel {
        ad: Matrix3::new(1.0, 0.2, 0.0, -0.1, 0.9, 0.3, 0.0, 0.0, 0.8),
        bd: Vector3::new(0.0, 0.1, 1.0),
        c: Matrix2x3::new(1.0, 0.0, 0.0, 0.0, 1.0, 0.5),
        w: g * g.transpose(),
        v: Matrix2::new(0.3, 0.1, 0.1, 0.2),
        p0: Matrix3::identity() * 2.0,
        period: 0.5,
    }
}

/// `P+ = (P^-1 + C'V^-1 C)^-1`, `xhat+ = P+ (P^-1 xhat + C'V^-1 y)`.
fn information<const P: usize>(
    (xhat, p): (Vector3<f64>, Matrix3<f64>),
    c: &SMatrix<f64, P, 3>,
    v: &SMatrix<f64, P, P>,
    y: &SVector<f64, P>,
) -> (Vector3<f64>, Matrix3<f64>) {
    let (before, weight) = (p.try_inverse().unwrap(), c.transpose() * v.try_inverse().unwrap());
    let after = (before + weight * c).try_inverse().unwrap();
    (after * (before * xhat + weight * y), after)
}

fn assert_estimate(estimate: &GaussianEstimate<f64, nalgebra::Const<3>>, expected: (Vector3<f64>, Matrix3<f64>)) {
    // Entries of order one, inverses of condition below 1e3.
    assert!((estimate.estimate() - expected.0).amax() < 1e-12, "{} {}", estimate.estimate(), expected.0);
    assert!((estimate.covariance() - expected.1).amax() < 1e-12, "{} {}", estimate.covariance(), expected.1);
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 64, failure_persistence: None, ..ProptestConfig::default() })]

    /// One step is the information form and the propagation of mean and covariance.
    #[test]
    fn a_step_is_the_information_form(
        root in prop::array::uniform9(-1.0f64..1.0), xhat in prop::array::uniform3(-1.0f64..1.0),
        y in prop::array::uniform2(-1.0f64..1.0), u in -1.0f64..1.0,
    ) {
        let (root, xhat, y, u) = (Matrix3::from_row_slice(&root), Vector3::from(xhat), Vector2::from(y), Vector1::new(u));
        let KalmanModel { ad, bd, c, w, v, .. } = model();
        let p0 = root * root.transpose() + Matrix3::identity() * 0.1;
        let filter = KalmanFilter::new(KalmanModel { p0, ..model() }).unwrap();
        let mut estimate = filter.initial(0.0, &xhat, &u, &y);
        filter.step(0.0, &mut estimate, &u, &y);
        let (corrected, p) = information((xhat, p0), &c, &v, &y);
        assert_estimate(&estimate, (ad * corrected + bd * u, ad * p * ad.transpose() + w));
    }
}

/// The predictor's gain `Ad P C' S^-1` tends to the one of the discrete Riccati equation, and P to its solution.
#[test]
fn the_limit_is_the_steady_state_filter() {
    let filter = KalmanFilter::new(model()).unwrap();
    let KalmanModel { ad, c, w, v, .. } = model();
    let dense = |m: &[f64], rows: usize| DMatrix::from_column_slice(rows, m.len() / rows, m);
    let steady = luenberger_linalg::discrete_kalman_gain(
        &dense(ad.as_slice(), 3),
        &dense(c.as_slice(), 2),
        &dense(w.as_slice(), 3),
        &dense(v.as_slice(), 2),
    )
    .unwrap();
    let (u, y) = (Vector1::new(0.0), Vector2::zeros());
    let mut estimate = filter.initial(0.0, &Vector3::zeros(), &u, &y);
    for _ in 0..500 {
        filter.step(0.0, &mut estimate, &u, &y);
    }
    let p = estimate.covariance();
    let gain = ad * p * c.transpose() * (c * p * c.transpose() + v).try_inverse().unwrap();
    for (found, wished) in p.iter().zip(steady.p.iter()).chain(gain.iter().zip(steady.l.iter())) {
        assert!((found - wished).abs() < 1e-12, "{found} {wished}");
    }
}

/// Without a sample, mean and covariance move as those of the plant do.
#[test]
fn a_missed_sample_is_a_prediction_over_two_periods() {
    let filter = KalmanFilter::new(model()).unwrap();
    let KalmanModel { ad, bd, c, w, v, p0, .. } = model();
    let (u, y, xhat) = (Vector1::new(0.3), Vector2::new(1.0, -1.0), Vector3::new(0.5, 0.0, -0.5));
    let mut estimate = filter.initial(0.0, &xhat, &u, &y);
    assert!(filter.update(&mut estimate, &u, &y).is_some());
    assert!(filter.predict(&mut estimate, &u));
    assert!(filter.predict(&mut estimate, &u));
    let (corrected, p) = information((xhat, p0), &c, &v, &y);
    let twice = ad * ad;
    let spread = twice * p * twice.transpose() + ad * w * ad.transpose() + w;
    assert_estimate(&estimate, (twice * corrected + (ad + Matrix3::identity()) * bd * u, spread));
}

/// The second sensor answers every fourth period. Between, the filter is that of the first sensor alone.
#[test]
fn sensors_of_two_rates() {
    let filter = KalmanFilter::new(model()).unwrap();
    let KalmanModel { ad, bd, c, w, v, p0, .. } = model();
    let first: RowVector3<f64> = c.row(0).into_owned();
    let u = Vector1::new(-0.2);
    let mut estimate = filter.initial(0.0, &Vector3::zeros(), &u, &Vector2::zeros());
    let mut expected = (Vector3::zeros(), p0);
    for k in 0..20 {
        let time = 0.5 * f64::from(k);
        let both = k % 4 == 0;
        let y = Vector2::new(time.sin(), if both { time.cos() } else { f64::NAN });
        let innovation = filter.update_partial(&mut estimate, &u, &y, |output| output == 0 || both).unwrap();
        let expected_square = if both {
            let (new, s) = (y - c * expected.0, c * expected.1 * c.transpose() + v);
            expected = information(expected, &c, &v, &y);
            new.dot(&(s.try_inverse().unwrap() * new))
        } else {
            let (new, s) = (y[0] - (first * expected.0)[0], (first * expected.1 * first.transpose())[0] + v[(0, 0)]);
            expected = information(expected, &first, &Matrix1::new(v[(0, 0)]), &Vector1::new(y[0]));
            new * new / s
        };
        assert!((innovation.normalized_square - expected_square).abs() < 1e-11, "{k}: {innovation:?}");
        assert_estimate(&estimate, expected);
        assert!(filter.predict(&mut estimate, &u));
        expected = (ad * expected.0 + bd * u, ad * expected.1 * ad.transpose() + w);
    }
}

/// A missing gain is reported, and the estimate is unchanged.
#[test]
fn a_sample_without_a_gain_is_reported() {
    let filter = KalmanFilter::new(model()).unwrap();
    let (u, y) = (Vector1::new(0.0), Vector2::new(1.0, 2.0));
    for p in [-Matrix3::identity(), Matrix3::identity() * f64::NAN, Matrix3::identity() * f64::INFINITY] {
        let mut lost = GaussianEstimate::new(&Vector3::new(1.0, 2.0, 3.0), &p);
        assert_eq!(filter.update(&mut lost, &u, &y), None);
        assert_eq!(lost.estimate(), Vector3::new(1.0, 2.0, 3.0));
    }
}

/// The same code in single precision and with sizes known at run time.
#[test]
fn other_scalars_and_sizes() {
    let KalmanModel { ad, bd, c, w, v, p0, period } = model();
    let single: StaticKalmanFilter<f32, 3, 1, 2> = KalmanFilter::new(KalmanModel {
        ad: ad.cast(),
        bd: bd.cast(),
        c: c.cast(),
        w: w.cast(),
        v: v.cast(),
        p0: p0.cast(),
        period: 0.5,
    })
    .unwrap();
    let dense = |m: &[f64], rows: usize| DMatrix::from_column_slice(rows, m.len() / rows, m);
    let dynamic = KalmanFilter::new(KalmanModel {
        ad: dense(ad.as_slice(), 3),
        bd: dense(bd.as_slice(), 3),
        c: dense(c.as_slice(), 2),
        w: dense(w.as_slice(), 3),
        v: dense(v.as_slice(), 2),
        p0: dense(p0.as_slice(), 3),
        period,
    })
    .unwrap();
    let fixed = KalmanFilter::new(model()).unwrap();
    let (u, y) = (Vector1::new(1.0), Vector2::new(1.0, -1.0));
    let (du, dy) = (DVector::from_element(1, 1.0), DVector::from_column_slice(&[1.0, -1.0]));
    let mut estimate = fixed.initial(0.0, &Vector3::zeros(), &u, &y);
    let mut one = single.initial(0.0, &Vector3::zeros(), &u.cast(), &y.cast());
    let mut other = dynamic.initial(0.0, &DVector::zeros(3), &du, &dy);
    for _ in 0..10 {
        fixed.step(0.0, &mut estimate, &u, &y);
        single.step(0.0, &mut one, &u.cast(), &y.cast());
        dynamic.step(0.0, &mut other, &du, &dy);
    }
    assert!((one.estimate().cast::<f64>() - estimate.estimate()).amax() < 1e-5);
    assert!((estimate.estimate().as_slice().iter().zip(other.estimate().iter())).all(|(a, b)| (a - b).abs() < 1e-13));
    assert_eq!(dynamic.dimensions(), fixed.dimensions());
    assert_eq!(fixed.dimensions().state, 12);
    assert_eq!(fixed.period(), 0.5);
}

#[test]
fn bad_data_are_errors() {
    let refused = |model| KalmanFilter::new(model).map(|_| ()).unwrap_err();
    let skew = Matrix3::new(1.0, 0.5, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0);
    assert!(matches!(refused(KalmanModel { w: skew, ..model() }), ObserverError::NotSymmetric { what: "W", .. }));
    assert!(matches!(
        refused(KalmanModel { v: Matrix2::zeros(), ..model() }),
        ObserverError::NotDefinite { what: "V", .. }
    ));
    let singular = Matrix2::new(1.0, 1.0, 1.0, 1.0);
    assert!(matches!(refused(KalmanModel { v: singular, ..model() }), ObserverError::NotDefinite { what: "V", .. }));
    let p0 = -Matrix3::identity();
    assert!(matches!(refused(KalmanModel { p0, ..model() }), ObserverError::NotDefinite { what: "P(0)", .. }));
    assert!(matches!(refused(KalmanModel { period: 0.0, ..model() }), ObserverError::Period { period: 0.0 }));
    let ad = Matrix3::identity() * f64::NAN;
    assert!(matches!(
        refused(KalmanModel { ad, ..model() }),
        ObserverError::Matrix(PlantError::NotFinite { what: "A", .. })
    ));
    let wrong = KalmanModel {
        ad: DMatrix::<f64>::identity(2, 2),
        bd: DMatrix::zeros(2, 0),
        c: DMatrix::zeros(1, 2),
        w: DMatrix::zeros(3, 3),
        v: DMatrix::identity(1, 1),
        p0: DMatrix::identity(2, 2),
        period: 1.0,
    };
    assert!(matches!(
        KalmanFilter::new(wrong).unwrap_err(),
        ObserverError::Matrix(PlantError::DimensionMismatch { what: "W", expected: (2, 2), found: (3, 3) })
    ));
}

/// Of a double integrator, the continuous-discrete filter is this filter of the plant with its input held, also when
/// its samples come at uneven times.
#[cfg(feature = "dual")]
#[test]
fn the_extended_filter_of_a_linear_plant() {
    use luenberger_observers::{ExtendedKalmanFilter, NoiseModel};
    let (h, q) = (0.2_f64, 0.5);
    let plant = luenberger_plants::double_integrator();
    let (bd, c, v, p0) =
        (Vector2::new(h * h / 2.0, h), nalgebra::RowVector2::new(1.0, 0.0), Matrix1::new(0.1), Matrix2::identity());
    let filter = KalmanFilter::new(KalmanModel {
        ad: Matrix2::new(1.0, h, 0.0, 1.0),
        bd,
        c,
        w: Matrix2::new(h.powi(3) / 3.0, h * h / 2.0, h * h / 2.0, h) * q,
        v,
        p0,
        period: h,
    })
    .unwrap();
    let noises = NoiseModel { w: Matrix2::new(0.0, 0.0, 0.0, q), v, p0 };
    let extended = ExtendedKalmanFilter::new(plant, noises, h, 1).unwrap();
    let (u, y) = (Vector1::new(1.0), Vector1::new(0.7));
    let mut one = filter.initial(0.0, &Vector2::new(1.0, 2.0), &u, &y);
    let mut other = one.clone();
    for k in 0..10 {
        let t = h * f64::from(k);
        // The second of three samples is missed.
        if k % 3 != 1 {
            let (a, b) = (filter.update(&mut one, &u, &y).unwrap(), extended.update(t, &mut other, &u, &y).unwrap());
            assert!((a.value - b.value).amax() < 1e-13 && (a.covariance - b.covariance).amax() < 1e-13);
        }
        assert!(filter.predict(&mut one, &u));
        assert!(extended.predict(t, &mut other, &u, 0.37 * h));
        assert!(extended.predict(t + 0.37 * h, &mut other, &u, 0.63 * h));
        assert!((one.estimate() - other.estimate()).amax() < 1e-13, "{k}");
        assert!((one.covariance() - other.covariance()).amax() < 1e-13, "{k}");
    }
    let mut lost = GaussianEstimate::new(&Vector2::new(1.0, 0.0), &-p0);
    assert_eq!(extended.update(0.0, &mut lost, &u, &y), None);
    assert_eq!(lost, GaussianEstimate::new(&Vector2::new(1.0, 0.0), &-p0));
    // Without a measured output the estimate is unchanged.
    let before = other.clone();
    let nothing = extended.update_partial(0.0, &mut other, &u, &Vector1::new(f64::NAN), |_| false).unwrap();
    assert_eq!((nothing.normalized_square, other), (0.0, before));
}
