//! Observers with the sizes and the scalar of the target, from designed ones.

use luenberger_observers::{
    KalmanFilter, KalmanModel, LinearObserver, ObserverError, SampledCubicGains, SampledCubicObserver, SampledObserver,
    cubic,
};
use nalgebra::{DMatrix, DVector, Vector1, Vector2, dmatrix};

#[test]
fn the_steps_are_those_of_the_designed_observers() -> Result<(), ObserverError> {
    let (ad, bd, c) = (dmatrix![1.0, 0.1; 0.0, 1.0], dmatrix![0.005; 0.1], dmatrix![1.0, 0.0]);
    let (ld, n) = (dmatrix![0.9; 2.0], dmatrix![-1.0; -1.5]);
    let w = cubic::rate(&c, &n);
    let gains = SampledCubicGains { ad, bd, c, ld, n, theta: dmatrix![10.0], w, period: 0.1 };
    let designed = SampledCubicObserver::new(gains.clone())?;
    let (double, single) = (designed.to_static::<f64, 2, 1, 1>()?, designed.to_static::<f32, 2, 1, 1>()?);
    let model = KalmanModel {
        ad: gains.ad,
        bd: gains.bd,
        c: gains.c,
        w: dmatrix![0.0, 0.0; 0.0, 0.01],
        v: dmatrix![0.04],
        p0: DMatrix::identity(2, 2),
        period: 0.1,
    };
    let filter = KalmanFilter::new(model)?;
    let target = filter.to_static::<f64, 2, 1, 1>()?;

    let (mut x, mut on_desk) = (Vector2::zeros(), DVector::zeros(2));
    let mut x32 = nalgebra::Vector2::<f32>::zeros();
    let start = (DVector::zeros(2), DVector::zeros(1), DVector::zeros(1));
    let mut estimate = filter.initial(0.0, &start.0, &start.1, &start.2);
    let mut on_target = target.initial(0.0, &Vector2::zeros(), &Vector1::zeros(), &Vector1::zeros());
    for k in 0..50 {
        let t = 0.1 * f64::from(k);
        let (u, y) = ((0.7 * t).sin(), 1.0 + (0.3 * t).cos());
        let (du, dy) = (DVector::from_element(1, u), DVector::from_element(1, y));
        designed.step(t, &mut on_desk, &du, &dy);
        double.step(t, &mut x, &Vector1::new(u), &Vector1::new(y));
        single.step(t as f32, &mut x32, &Vector1::new(u as f32), &Vector1::new(y as f32));
        filter.step(t, &mut estimate, &du, &dy);
        target.step(t, &mut on_target, &Vector1::new(u), &Vector1::new(y));
        assert!((on_desk[0] - x[0]).abs() + (on_desk[1] - x[1]).abs() < 1e-13);
        assert!((f64::from(x32[0]) - x[0]).abs() + (f64::from(x32[1]) - x[1]).abs() < 1e-4);
        let gap = estimate.estimate() - DVector::from_column_slice(on_target.estimate().as_slice());
        assert!(gap.amax() < 1e-13);
    }
    Ok(())
}

#[test]
fn other_sizes_and_entries_beyond_the_scalar_are_errors() -> Result<(), ObserverError> {
    let plant = luenberger_plants::double_integrator().to_dynamic();
    let observer = LinearObserver::of(plant, dmatrix![7.0; 1e39])?;
    assert!(observer.to_static::<f64, 2, 1, 1>().is_ok());
    let error = observer.to_static::<f64, 2, 0, 1>().unwrap_err();
    assert_eq!(error.to_string(), "B is 2x1 where 2x0 fits the other matrices");
    let error = observer.to_static::<f32, 2, 1, 1>().unwrap_err();
    assert_eq!(error.to_string(), "L(1, 0) is inf, not a finite number");
    Ok(())
}
