//! What simulation calls on slices gives the same bits as the columns: right-hand sides, estimates, steps, Jacobians.

use luenberger_expression::{ExpressionPlant, Parameters};
use luenberger_observers::{
    CubicObserver, ExtendedKalmanFilter, LinearObserver, NoiseModel, NonlinearLuenbergerObserver, Observer,
    SampledObserver,
};
use luenberger_plants::{Column, Differentiable, Plant, StateSpace};
use nalgebra::{DMatrix, DVector, dmatrix, dvector};

fn cart_pole() -> ExpressionPlant {
    let f = [
        "x2",
        "(0.024*(u1 - 0.1*x2 - 0.06*x4^2*sin(x3)) + 0.035316*sin(x3)*cos(x3))/(0.0168 - 0.0036*cos(x3)^2)",
        "x4",
        "(0.41202*sin(x3) + 0.06*cos(x3)*(u1 - 0.1*x2 - 0.06*x4^2*sin(x3)))/(0.0168 - 0.0036*cos(x3)^2)",
    ];
    ExpressionPlant::new(&f, &["x1", "x3 + 0.1*x2*x4"], 1, &Parameters::new()).unwrap()
}

fn noises() -> NoiseModel<f64, nalgebra::Dyn, nalgebra::Dyn> {
    let p0 = dmatrix![1e-4, 1e-5, 0.0, 0.0; 1e-5, 0.01, 0.0, 0.0; 0.0, 0.0, 0.01, 1e-3; 0.0, 0.0, 1e-3, 0.1];
    let w = DMatrix::from_diagonal(&dvector![1e-6, 1e-3, 1e-6, 1e-3]);
    NoiseModel { w, v: dmatrix![2.5e-7, 1e-8; 1e-8, 1e-6], p0 }
}

/// Steps both ways, over some samples with an outlier in them.
fn steps<O: SampledObserver<f64, Input = DVector<f64>, Output = DVector<f64>, Estimate = DVector<f64>>>(
    filter: &O,
    patterns: &[[bool; 2]],
) -> usize {
    let xhat = dvector![0.01, 0.0, 0.1, -0.2];
    let mut filtered = filter.initial(0.0, &xhat, &dvector![0.0], &dvector![0.0, 0.0]);
    let mut state = filtered.as_slice().to_vec();
    let mut estimate = [0.0; 4];
    for k in 0..60 {
        let t = 0.01 * f64::from(k);
        let y = dvector![0.1 * t, 0.1 - t + if k == 30 { 5.0 } else { 0.0 }];
        let (u, measured) = (dvector![2.0 * t], &patterns[k as usize % patterns.len()]);
        if measured.contains(&false) {
            filter.step_partial(t, &mut filtered, &u, &y, measured);
        } else {
            filter.step(t, &mut filtered, &u, &y);
        }
        assert!(filter.step_into(t, &mut state, u.as_slice(), y.as_slice(), measured));
        assert_eq!(state, filtered.as_slice(), "{k}");
        assert!(filter.estimate_into(&state, &mut estimate));
        assert_eq!(estimate, filter.estimate(&filtered).as_slice(), "{k}");
    }
    assert!(!filter.step_into(0.0, &mut state[..19], &[0.0], &[0.0; 2], &[true; 2]), "a state of another length");
    60
}

#[test]
fn steps_of_filters() {
    let filter = || ExtendedKalmanFilter::new(cart_pole(), noises(), 0.01, 4).unwrap();
    steps(&filter(), &[[true; 2]]);
    steps(&filter(), &[[true, false], [false, false], [false, true], [true, true]]);
    steps(&filter().with_gate(4.0).unwrap(), &[[true; 2], [true, false]]);
    let next = ["x1 + 0.01*x2", "0.99*x2 + 0.01*u1", "x3 + 0.01*x4", "x4 - 0.1*sin(x3)"];
    let plant = ExpressionPlant::new(&next, &["x1", "sin(x3)"], 1, &Parameters::new()).unwrap();
    steps(&ExtendedKalmanFilter::discrete(plant, noises(), 0.01).unwrap(), &[[true; 2], [false, true]]);
}

/// More outputs than there is a step of its own for.
#[test]
fn a_filter_of_five_outputs() {
    let plant = ExpressionPlant::new(&["-x1^3"], &["x1", "2*x1", "x1^2", "sin(x1)", "x1"], 0, &Parameters::new());
    let noises = NoiseModel { w: dmatrix![0.01], v: DMatrix::identity(5, 5), p0: dmatrix![1.0] };
    let filter = ExtendedKalmanFilter::new(plant.unwrap(), noises, 0.1, 1).unwrap();
    let (u, y) = (DVector::zeros(0), dvector![1.0, 2.1, 1.0, 0.8, 0.9]);
    let mut filtered = filter.initial(0.0, &dvector![0.5], &u, &y);
    let mut state = filtered.as_slice().to_vec();
    filter.step(0.0, &mut filtered, &u, &y);
    assert!(filter.step_into(0.0, &mut state, &[], y.as_slice(), &[true; 5]));
    assert_eq!(state, filtered.as_slice());
}

fn right_hand_sides<O>(observer: &O, inputs: usize, outputs: usize)
where
    O: Observer<f64, State = DVector<f64>, Input = DVector<f64>, Output = DVector<f64>, Estimate = DVector<f64>>,
{
    for k in 0..50 {
        let entry = |i: usize, size: f64| size * (f64::from(k) * 0.7 + i as f64).sin();
        // The last ones are beyond where the weight of a cubic observer is that of the shortened innovation.
        let size = if k < 45 { 2.0 } else { 1e80 };
        let state = DVector::from_fn(observer.dimensions().state, |i, _| entry(i, size));
        let (u, y) =
            (DVector::from_fn(inputs, |i, _| entry(i + 7, 1.0)), DVector::from_fn(outputs, |i, _| entry(i + 9, 3.0)));
        let mut slope = vec![0.0; state.len()];
        assert!(observer.derivative_into(0.1, state.as_slice(), u.as_slice(), y.as_slice(), &mut slope));
        let same = |a: &f64, b: &f64| a == b || a.is_nan() && b.is_nan();
        let columns = observer.derivative(0.1, &state, &u, &y);
        assert!(slope.iter().zip(columns.as_slice()).all(|(a, b)| same(a, b)), "{slope:?} {columns}");
        assert!(observer.estimate_into(0.1, state.as_slice(), u.as_slice(), y.as_slice(), &mut slope));
        assert_eq!(slope, observer.estimate(0.1, &state, &u, &y).as_slice());
    }
    assert!(!observer.derivative_into(0.0, &vec![0.0; observer.dimensions().state], &vec![0.0; inputs], &[], &mut []));
}

#[test]
fn right_hand_sides_of_observers() {
    let (a, b) = (dmatrix![0.0, 1.0, 0.3; -2.0, -0.1, 0.7; 0.2, 0.0, -1.0], dmatrix![0.1, 0.0; 1.0, 0.3; -0.2, 0.4]);
    let (c, d) = (dmatrix![1.0, 0.2, 0.0; 0.3, 0.0, 1.0], dmatrix![0.0, 0.1; 0.7, 0.0]);
    let (l, n) = (dmatrix![3.0, 0.1; 2.0, -0.4; 0.3, 4.0], dmatrix![-1.0, 0.2; -0.7, 0.1; 0.1, -2.0]);
    let theta = dmatrix![10.0, 1.0; 1.0, 4.0];
    let plant = StateSpace::new(a, b, c).unwrap();
    for plant in [plant.clone(), plant.with_feedthrough(d).unwrap()] {
        right_hand_sides(&LinearObserver::of(plant.clone(), l.clone()).unwrap(), 2, 2);
        right_hand_sides(&CubicObserver::of(plant.clone(), l.clone(), n.clone(), theta.clone()).unwrap(), 2, 2);
        right_hand_sides(&NonlinearLuenbergerObserver::new(plant, l.clone()).unwrap(), 2, 2);
    }
    let gain = dmatrix![23.7, 0.03; 145.0, -1.7; -0.05, 41.7; -5.3, 306.7];
    right_hand_sides(&NonlinearLuenbergerObserver::new(cart_pole(), gain).unwrap(), 1, 2);
}

#[test]
fn values_and_jacobians_of_plants() {
    let plant = cart_pole();
    let (x, u) = (dvector![0.3, -0.2, 0.7, 1.1], dvector![0.4]);
    let (mut f, mut df, mut h, mut dh) = ([0.0; 4], [0.0; 16], [0.0; 2], [0.0; 8]);
    assert!(plant.motion_into(0.2, x.as_slice(), u.as_slice(), &mut f, &mut df));
    assert!(plant.measurement_into(0.2, x.as_slice(), u.as_slice(), &mut h, &mut dh));
    assert_eq!(f, plant.derivative(0.2, &x, &u).as_slice());
    assert_eq!(df, plant.state_jacobian(0.2, &x, &u).as_slice());
    assert_eq!(h, plant.output(0.2, &x, &u).as_slice());
    assert_eq!(dh, plant.output_jacobian(0.2, &x, &u).as_slice());
    let fixed = plant.fixed::<4, 1, 2>().unwrap();
    let mut same = [0.0; 16];
    assert!(fixed.motion_into(0.2, x.as_slice(), u.as_slice(), &mut f, &mut same));
    assert_eq!(df, same);
    assert!(!plant.motion_into(0.2, x.as_slice(), &[], &mut f, &mut df), "an input that is missing");
}
