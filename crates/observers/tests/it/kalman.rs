//! The extended Kalman filter: against the Kalman filter of a linear plant, on a nonlinear one, and on bad data.

#![cfg(feature = "dual")]

use approx::assert_abs_diff_eq;
use luenberger_observers::{ExtendedKalmanFilter, GaussianEstimate, NoiseModel, ObserverError, SampledObserver};
use luenberger_plants::{Chaotic, Column, LinearPlant, Plant, PlantError, double_integrator};
use nalgebra::{
    DMatrix, DVector, Matrix1, Matrix2, Matrix3, Matrix4, RowVector2, RowVector4, SMatrix, SVector, Vector1, Vector2,
    Vector3, Vector4,
};
use proptest::prelude::*;

fn joseph(p: Matrix2<f64>, c: RowVector2<f64>, v: f64) -> (Vector2<f64>, Matrix2<f64>) {
    let gain = p * c.transpose() / ((c * p * c.transpose())[0] + v);
    let keep = Matrix2::identity() - gain * c;
    (gain, keep * p * keep.transpose() + gain * gain.transpose() * v)
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 64, failure_persistence: None, ..ProptestConfig::default() })]

    /// For the double integrator everything is a polynomial of degree at most 3 in h, which one Runge-Kutta step has
    /// exactly: Phi = [[1, h], [0, 1]], P+ = Phi P Phi' + int_0^h Phi(s) W Phi(s)' ds. So this is the Kalman filter
    /// itself.
    #[test]
    fn the_filter_of_a_linear_plant_is_kalmans(
        h in 0.01f64..1.0, root in prop::array::uniform4(-1.0f64..1.0), intensity in 0.0f64..2.0, v in 0.01f64..1.0,
        xhat in prop::array::uniform2(-1.0f64..1.0), y in -1.0f64..1.0, u in -1.0f64..1.0,
    ) {
        let plant = double_integrator();
        let root = Matrix2::from_row_slice(&root);
        let p0 = root * root.transpose();
        let noises = NoiseModel { w: Matrix2::new(0.0, 0.0, 0.0, intensity), v: Matrix1::new(v), p0 };
        let (c, input) = (plant.c, plant.b);
        let filter = ExtendedKalmanFilter::new(plant, noises, h, 1).unwrap();
        let (u, y, xhat) = (Vector1::new(u), Vector1::new(y), Vector2::from(xhat));
        let mut estimate = filter.initial(0.0, &xhat, &u, &y);
        filter.step(0.0, &mut estimate, &u, &y);

        let (gain, corrected) = joseph(p0, c, v);
        let phi = Matrix2::new(1.0, h, 0.0, 1.0);
        let moved = phi * (xhat + gain * (y - c * xhat)) + Matrix2::new(h, h * h / 2.0, 0.0, h) * input * u;
        let spread = Matrix2::new(h.powi(3) / 3.0, h * h / 2.0, h * h / 2.0, h) * intensity;
        let expected = phi * corrected * phi.transpose() + spread;
        // Entries are below 20.
        prop_assert!((estimate.estimate() - moved).amax() <= 1000.0 * f64::EPSILON);
        prop_assert!((estimate.covariance() - expected).amax() <= 1000.0 * f64::EPSILON);
    }

    /// P stays symmetric to the last bit and has no negative direction, on the chaotic plant far from any fixed point.
    #[test]
    fn the_covariance_stays_one(x0 in prop::array::uniform3(-2.0f64..2.0), off in prop::array::uniform3(-0.5f64..0.5)) {
        let noises = NoiseModel { w: Matrix3::identity() * 0.01, v: Matrix2::identity() * 1e-4, p0: Matrix3::identity() };
        let filter = ExtendedKalmanFilter::new(Chaotic, noises, 0.02, 2).unwrap();
        let (x0, u) = (Vector3::from(x0), SVector::zeros());
        let mut x = x0;
        let mut estimate = filter.initial(0.0, &(x0 + Vector3::from(off)), &u, &Vector2::zeros());
        for k in 0..100 {
            filter.step(0.02 * f64::from(k), &mut estimate, &u, &Chaotic.output(0.0, &x, &u));
            for _ in 0..4 {
                let mid: Vector3<f64> = x + Chaotic.derivative(0.0, &x, &u) * 0.0025;
                x += Chaotic.derivative(0.0, &mid, &u) * 0.005;
            }
            let p = estimate.covariance();
            prop_assert_eq!(p, p.transpose());
            prop_assert!(p.symmetric_eigenvalues().min() > 0.0, "{p}");
        }
    }
}

/// On a chain of four integrators with a constant input the estimate moves by a polynomial of degree 4 in time, which
/// the classical Runge-Kutta method has exactly. With P(0) = 0 and W = 0 there is no correction.
#[test]
fn a_chain_of_integrators_is_propagated_exactly() {
    let a = Matrix4::from_fn(|i, j| if j == i + 1 { 1.0 } else { 0.0 });
    let plant = LinearPlant { a, b: Vector4::new(0.0, 0.0, 0.0, 1.0), c: RowVector4::new(1.0, 0.0, 0.0, 0.0), d: None };
    let noises = NoiseModel { w: Matrix4::zeros(), v: Matrix1::new(1.0), p0: Matrix4::zeros() };
    let (h, x, u) = (0.5_f64, Vector4::new(1.0, -2.0, 3.0, -4.0), Vector1::new(24.0));
    let filter = ExtendedKalmanFilter::new(plant, noises, h, 1).unwrap();
    let mut estimate = filter.initial(0.0, &x, &u, &Vector1::new(9.0));
    filter.step(0.0, &mut estimate, &u, &Vector1::new(9.0));
    // exp(A h) x + int_0^h exp(A s) b ds u.
    let expected = Vector4::new(
        1.0 - 2.0 * h + 3.0 * h * h / 2.0 - 4.0 * h.powi(3) / 6.0 + h.powi(4),
        -2.0 + 3.0 * h - 4.0 * h * h / 2.0 + 4.0 * h.powi(3),
        3.0 - 4.0 * h + 12.0 * h * h,
        -4.0 + 24.0 * h,
    );
    assert!((estimate.estimate() - expected).amax() <= 16.0 * f64::EPSILON * 12.0, "{}", estimate.estimate());
    assert_eq!(estimate.covariance(), Matrix4::zeros());
}

/// x3 is not measured; the filter finds it from x2' = x1 x3 and x3' = 0.2 - x1 x2.
#[test]
fn the_unmeasured_state_is_found() {
    let noises = NoiseModel { w: Matrix3::identity() * 1e-3, v: Matrix2::identity() * 1e-6, p0: Matrix3::identity() };
    let filter = ExtendedKalmanFilter::new(Chaotic, noises, 0.01, 2).unwrap();
    let u = SVector::zeros();
    let mut x = Vector3::new(-2.0, -1.0, -1.0);
    let mut estimate = filter.initial(0.0, &Vector3::new(-1.0, -0.5, -1.5), &u, &Vector2::zeros());
    for k in 0..1000 {
        filter.step(0.01 * f64::from(k), &mut estimate, &u, &Chaotic.output(0.0, &x, &u));
        for _ in 0..10 {
            let mid: Vector3<f64> = x + Chaotic.derivative(0.0, &x, &u) * 0.0005;
            x += Chaotic.derivative(0.0, &mid, &u) * 0.001;
        }
    }
    // The midpoint rule here and Runge-Kutta there agree to about 1e-6.
    assert_abs_diff_eq!(x, estimate.estimate(), epsilon = 1e-4);
}

/// An estimate whose covariance is not semidefinite has no gain, and the sample is passed over, as is one that is not a
/// number.
#[test]
fn samples_without_a_gain() {
    let noises = NoiseModel { w: Matrix2::zeros(), v: Matrix1::new(1.0), p0: Matrix2::identity() };
    let filter = ExtendedKalmanFilter::new(double_integrator(), noises, 0.1, 1).unwrap();
    let (u, y) = (Vector1::new(0.0), Vector1::new(5.0));
    let mut lost = GaussianEstimate::new(&Vector2::new(1.0, 0.0), &(-Matrix2::identity() * 3.0));
    filter.step(0.0, &mut lost, &u, &y);
    assert_eq!(lost.estimate(), Vector2::new(1.0, 0.0));
    let mut estimate = filter.initial(0.0, &Vector2::zeros(), &u, &y);
    filter.step(0.0, &mut estimate, &u, &Vector1::new(f64::NAN));
    assert_eq!(estimate.estimate(), Vector2::zeros());
    assert!(estimate.covariance()[(0, 0)] > 1.0);
}

/// Run-time sizes and static ones are the same code.
#[test]
fn sizes_known_at_run_time() {
    let p0 = Matrix2::new(2.0, 0.5, 0.5, 1.0);
    let fixed = NoiseModel { w: Matrix2::identity(), v: Matrix1::new(0.1), p0 };
    let dynamic = NoiseModel {
        w: DMatrix::identity(2, 2),
        v: DMatrix::from_element(1, 1, 0.1),
        p0: DMatrix::from_column_slice(2, 2, p0.as_slice()),
    };
    let fixed = ExtendedKalmanFilter::new(double_integrator(), fixed, 0.1, 3).unwrap();
    let dynamic = ExtendedKalmanFilter::new(double_integrator().to_dynamic(), dynamic, 0.1, 3).unwrap();
    let (u, y) = (DVector::from_element(1, 1.0), DVector::from_element(1, 2.0));
    let mut one = fixed.initial(0.0, &Vector2::new(1.0, 2.0), &Vector1::new(1.0), &Vector1::new(2.0));
    let mut other = dynamic.initial(0.0, &DVector::from_vec(vec![1.0, 2.0]), &u, &y);
    fixed.step(0.0, &mut one, &Vector1::new(1.0), &Vector1::new(2.0));
    dynamic.step(0.0, &mut other, &u, &y);
    for (a, b) in one.as_slice().iter().zip(other.as_slice()) {
        assert!((a - b).abs() <= 16.0 * f64::EPSILON, "{a} {b}");
    }
    assert_eq!(other.as_slice().len(), dynamic.dimensions().state);
    assert!(GaussianEstimate::<f64, nalgebra::Dyn>::try_from_slice(&[0.0; 5]).is_none());
    assert!(GaussianEstimate::<f64, nalgebra::Const<2>>::try_from_slice(&[0.0; 12]).is_none());
}

#[test]
fn bad_data_are_errors() {
    let make = |w: Matrix2<f64>, v: f64, p0: Matrix2<f64>, h: f64, substeps: usize| {
        ExtendedKalmanFilter::new(double_integrator(), NoiseModel { w, v: Matrix1::new(v), p0 }, h, substeps)
            .map(|_| ())
    };
    let one = Matrix2::identity();
    assert_eq!(make(one, 1.0, one, 0.1, 1), Ok(()));
    assert_eq!(make(Matrix2::zeros(), 1.0, Matrix2::zeros(), 0.1, 1), Ok(()));
    // Rank one, with rounding, is a covariance.
    let v = Vector2::new(0.1, 0.3);
    assert_eq!(make(v * v.transpose(), 1.0, one, 0.1, 1), Ok(()));
    assert!(matches!(make(one, 0.0, one, 0.1, 1), Err(ObserverError::NotDefinite { what: "V", row: 0, pivot: 0.0 })));
    assert!(matches!(make(-one, 1.0, one, 0.1, 1), Err(ObserverError::NotDefinite { what: "W", row: 0, pivot: -1.0 })));
    let skew = Matrix2::new(1.0, 0.5, 0.0, 1.0);
    assert_eq!(
        make(one, 1.0, skew, 0.1, 1),
        Err(ObserverError::NotSymmetric { what: "P(0)", row: 1, column: 0, difference: -0.5 })
    );
    let indefinite = Matrix2::new(1.0, 2.0, 2.0, 1.0);
    // The pivot is 1 - 4, up to the shift that lets rounding pass.
    assert!(matches!(
        make(one, 1.0, indefinite, 0.1, 1),
        Err(ObserverError::NotDefinite { what: "P(0)", row: 1, pivot }) if (pivot + 3.0).abs() < 1e-13
    ));
    // No pivot at all, and not zero.
    let hollow = Matrix2::new(0.0, 1.0, 1.0, 0.0);
    assert_eq!(make(hollow, 1.0, one, 0.1, 1), Err(ObserverError::NotDefinite { what: "W", row: 0, pivot: 0.0 }));
    assert!(matches!(make(one, 1.0, one, 0.0, 1), Err(ObserverError::Period { .. })));
    assert_eq!(make(one, 1.0, one, 0.1, 0), Err(ObserverError::Substeps));
    assert!(matches!(
        make(one * f64::NAN, 1.0, one, 0.1, 1),
        Err(ObserverError::Matrix(PlantError::NotFinite { what: "W", .. }))
    ));
}

/// W = D D' is a covariance in every order of its rows, a row of 1e-9 among them.
#[test]
fn a_singular_covariance_is_one() {
    let plant = LinearPlant {
        a: Matrix4::zeros(),
        b: SMatrix::<f64, 4, 0>::zeros(),
        c: RowVector4::new(1.0, 0.0, 0.0, 0.0),
        d: None,
    };
    let mut d = SMatrix::<f64, 4, 2>::new(1e-9, 0.0, 0.1, 0.7, 0.3, 0.2, 1.0, 0.3);
    for turn in 0..4 {
        let w = d * d.transpose();
        let noises = |w| NoiseModel { w, v: Matrix1::new(1.0), p0: w };
        assert!(ExtendedKalmanFilter::new(plant.clone(), noises(w), 0.1, 1).is_ok(), "turn {turn}: {w}");
        let outside = Vector4::new(0.5, -0.5, 0.5, -0.5);
        let refused = ExtendedKalmanFilter::new(plant.clone(), noises(w - outside * outside.transpose()), 0.1, 1);
        assert!(matches!(refused, Err(ObserverError::NotDefinite { what: "W", .. })), "turn {turn}");
        d = SMatrix::from_fn(|i, j| d[((i + 1) % 4, j)]);
    }
}

/// An outlier is rejected by the gate as if it had not been measured, of two outputs the one alone; without a gate, and
/// within it, nothing changes.
#[test]
fn a_gate_rejects_outliers() {
    use luenberger_observers::kalman::{ExtendedKalmanFilter, NoiseModel};
    use luenberger_plants::StaticPlant;
    use nalgebra::{Const, Matrix2, Vector1, Vector2};

    let plant =
        StaticPlant::<f64, 2, 1, 2>::new(Matrix2::new(0.0, 1.0, 0.0, 0.0), Vector2::new(0.0, 1.0), Matrix2::identity())
            .unwrap();
    let v = Matrix2::new(0.04, 0.01, 0.01, 0.09);
    let noises = NoiseModel { w: Matrix2::identity() * 0.1, v, p0: Matrix2::new(0.12, 0.0, 0.0, 0.16) };
    let plain: ExtendedKalmanFilter<_, f64, Const<2>, Const<1>, Const<2>> =
        ExtendedKalmanFilter::new(plant, noises, 0.1, 1).unwrap();
    let gated = plain.clone().with_gate(4.0).unwrap();
    // S = diag(P) + V: deviations 0.4 and 0.5; 4 of them are 1.6 and 2.
    let u = Vector1::new(0.0);
    let start = plain.initial(0.0, &Vector2::zeros(), &u, &Vector2::zeros());
    for (y, rejected) in [
        (Vector2::new(1.5, -1.9), [false, false]),
        (Vector2::new(1.7, -1.9), [true, false]),
        (Vector2::new(-1.5, 2.1), [false, true]),
        (Vector2::new(9.0, 9.0), [true, true]),
    ] {
        assert!((0..2).all(|j| gated.rejects(0.0, &start, &u, &y, j) == rejected[j] && !plain.rejects(0.0, &start, &u, &y, j)));
        let (mut found, mut expected) = (start.clone(), start.clone());
        gated.update(0.0, &mut found, &u, &y).unwrap();
        plain.update_partial(0.0, &mut expected, &u, &y, |j| !rejected[j]).unwrap();
        assert_eq!(found, expected);
    }
    assert!(plain.clone().with_gate(0.0).is_err() && plain.with_gate(f64::NAN).is_err());
}
