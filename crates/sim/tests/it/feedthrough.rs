//! Plants with direct feedthrough, `y = C x + D u` or `y = h(t, x, u)`: observers against an independent simulation.
//!
//! The expected numbers are those of scipy 1.17.1 (`solve_ivp`, DOP853, rtol 1e-13; `cont2discrete`), python-control
//! 0.10.2 (`lqe`) and filterpy 2.0.0 (`KalmanFilter` on y - D u, `ExtendedKalmanFilter`), of the plant
//! A = [0 1; -2 -0.5], B = [0; 1], C = [1 0], D = 0.5 from x(0) = (1, -1), xhat(0) = 0 with u = sin 2t.

use luenberger_observers::{
    CubicObserver, DiscreteLinearObserver, ExtendedKalmanFilter, KalmanFilter, KalmanModel, LinearObserver, NoiseModel,
    SampledCubicGains, SampledCubicObserver, SampledObserver,
};
use luenberger_plants::{Plant, StaticPlant, plant};
use luenberger_sim::{Comparison, Scenario, Signal, SimError, Trajectory};
use nalgebra::{DMatrix, Matrix1, Matrix2, RowVector2, SVector, Vector1, Vector2, convert};

fn plant() -> StaticPlant<f64, 2, 1, 1> {
    let (a, b) = (Matrix2::new(0.0, 1.0, -2.0, -0.5), Vector2::new(0.0, 1.0));
    StaticPlant::new(a, b, RowVector2::new(1.0, 0.0)).unwrap().with_feedthrough(Matrix1::new(0.5)).unwrap()
}

fn input(t: f64) -> f64 {
    (2.0 * t).sin()
}

fn ends_at(run: &Trajectory, name: &str, expected: [f64; 2], within: f64) {
    let estimate = &run.observer(name).unwrap().estimate;
    let last = estimate.nrows() - 1;
    for (i, expected) in expected.into_iter().enumerate() {
        let found = estimate[(last, i)];
        assert!((found - expected).abs() <= within, "{name}: xhat{} = {found:.15}, expected {expected}", i + 1);
    }
}

#[test]
fn continuous_observers_of_a_plant_with_feedthrough() {
    let placed = Vector2::new(8.5, 13.75);
    let kalman = Vector2::new(1.170785140823704, 0.435368922986791);
    let cubic = CubicObserver::of(plant(), placed, Vector2::new(-1.0, -2.0), Matrix1::new(3.0)).unwrap();
    let designed =
        LinearObserver::of(plant().to_dynamic(), DMatrix::from_column_slice(2, 1, placed.as_slice())).unwrap();
    // D goes to the target with the other matrices.
    let placed = designed.to_static::<f64, 2, 1, 1>().unwrap();
    assert_eq!(placed, LinearObserver::of(plant(), placed.l).unwrap());
    let run = Scenario::new(plant())
        .initial_state(&[1.0, -1.0])
        .input(Signal::scalar(input))
        .observer("placed", placed, &[0.0, 0.0])
        .observer("kalman", LinearObserver::of(plant(), kalman).unwrap(), &[0.0, 0.0])
        .observer("cubic", cubic, &[0.0, 0.0])
        .until(2.0, 2)
        .run()
        .unwrap();
    // The output has the input of the same instant in it: C x + D u, at the start and at the end.
    assert_eq!(run.y[(0, 0)], 1.0);
    assert!((run.y[(1, 0)] + 0.611460165882422).abs() < 1e-9, "{}", run.y);
    ends_at(&run, "placed", [-0.231799036016592, -0.018792893106058], 1e-8);
    ends_at(&run, "kalman", [-0.030409663373546, -0.180101677741292], 1e-8);
    ends_at(&run, "cubic", [-0.231821758599768, -0.018896735214632], 1e-8);
}

/// The discretised plant of period 0.1, by `cont2discrete`.
fn held() -> (Matrix2<f64>, Vector2<f64>) {
    let held = luenberger_linalg::zero_order_hold(
        &DMatrix::from_row_slice(2, 2, &[0.0, 1.0, -2.0, -0.5]),
        &DMatrix::from_row_slice(2, 1, &[0.0, 1.0]),
        0.1,
    )
    .unwrap();
    (Matrix2::from_fn(|i, j| held.ad[(i, j)]), Vector2::from_fn(|i, _| held.bd[(i, 0)]))
}

#[test]
fn sampled_observers_of_a_plant_with_feedthrough() {
    let (ad, bd) = held();
    let c = RowVector2::new(1.0, 0.0);
    let gains = SampledCubicGains {
        ad,
        bd,
        c,
        ld: Vector2::new(0.5, 0.8),
        n: Vector2::new(-1.0, -2.0),
        theta: Matrix1::new(3.0),
        w: 1.0,
        period: 0.1,
    };
    let cubic = SampledCubicObserver::new(gains).unwrap().with_feedthrough(Matrix1::new(0.5)).unwrap();
    let filter = KalmanFilter::new(KalmanModel {
        ad,
        bd,
        c,
        w: Matrix2::new(0.01, 0.0, 0.0, 0.02),
        v: Matrix1::new(0.05),
        p0: Matrix2::identity(),
        period: 0.1,
    })
    .unwrap()
    .with_feedthrough(Matrix1::new(0.5))
    .unwrap();
    let (mut x, mut xhat) = (Vector2::new(1.0, -1.0), Vector2::zeros());
    let u = Vector1::new(0.0);
    let mut estimate = filter.initial(0.0, &xhat, &u, &u);
    for k in 0..20 {
        let t = 0.1 * f64::from(k);
        let u = Vector1::new(input(t));
        let y = plant().output(t, &x, &u);
        cubic.step(t, &mut xhat, &u, &y);
        filter.step(t, &mut estimate, &u, &y);
        x = ad * x + bd * u;
    }
    assert!((x - Vector2::new(-0.219559077046171, 0.052056776492248)).amax() < 1e-13);
    assert!((xhat - Vector2::new(-0.223469854759898, 0.048320550790061)).amax() < 1e-13, "{xhat}");
    let expected = Vector2::new(-0.214046017479889, 0.065619612653707);
    assert!((estimate.estimate() - expected).amax() < 1e-13, "{}", estimate.estimate());
    let p = Matrix2::new(0.032396826079, 0.016662196054212, 0.016662196054212, 0.1251980516859);
    assert!((estimate.covariance() - p).amax() < 1e-12);
    // In a run, where the input is held and y is that of the input held from the sample on.
    let run = Scenario::new(plant())
        .initial_state(&[1.0, -1.0])
        .input(Signal::scalar(input))
        .hold_input(0.1)
        .sampled_observer("cubic", cubic, &[0.0, 0.0])
        .sampled_observer("kalman", filter, &[0.0, 0.0])
        .until(2.0, 2)
        .run()
        .unwrap();
    ends_at(&run, "cubic", [-0.223469854759898, 0.048320550790061], 1e-8);
    ends_at(&run, "kalman", [expected[0], expected[1]], 1e-8);
}

/// A pendulum whose output has the input in it: `y = sin x1 + 0.5 u cos x1`.
struct Pendulum;

plant!(
    Pendulum,
    (2, 1, 1),
    |plant, t, x, u| {
        let [g, damping] = [9.81, 0.2].map(convert::<f64, T>);
        [x[1], u[0] - g * x[0].sin() - damping * x[1]]
    },
    [x[0].sin() + convert::<f64, T>(0.5) * u[0] * x[0].cos()]
);

#[test]
fn an_extended_kalman_filter_of_an_output_with_the_input() {
    let noises = NoiseModel { w: Matrix2::new(0.0, 0.0, 0.0, 0.3), v: Matrix1::new(0.01), p0: Matrix2::identity() };
    let filter = ExtendedKalmanFilter::new(Pendulum, noises, 0.05, 20).unwrap();
    let run = Scenario::new(Pendulum)
        .initial_state(&[0.6, -0.2])
        .input(Signal::scalar(|t| (3.0 * t).sin()))
        .hold_input(0.05)
        .sampled_observer("ekf", &filter, &[0.0, 0.0])
        .until(1.5, 2)
        .run()
        .unwrap();
    // filterpy, with mean and covariance between samples by DOP853.
    ends_at(&run, "ekf", [-0.002736155375524, 0.942097410335855], 1e-7);
}

#[test]
fn a_law_that_reads_an_output_with_feedthrough_is_a_loop() {
    // u = -y = -(x1 + u/2), which is zero at the start x = 0.
    let law = Signal::law(|view, u| u[0] = -view.y[0]);
    for start in [[0.0, 1.0], [1.0, 0.0]] {
        let run = Scenario::new(plant()).initial_state(&start).input(law.clone()).until(1.0, 2).run();
        assert!(matches!(run, Err(SimError::AlgebraicLoop { .. })), "{run:?}");
    }
    // Without feedthrough the same law is none, and of the state it is none with it.
    let free = StaticPlant { d: None, ..plant() };
    Scenario::new(free).initial_state(&[1.0, 0.0]).input(law).until(1.0, 2).run().unwrap();
    let by_state = Signal::law(|view, u| u[0] = -view.x[0]);
    let run = Scenario::new(plant()).initial_state(&[1.0, 0.0]).input(by_state).until(1.0, 2).run().unwrap();
    assert!((run.y[(1, 0)] - 0.5 * run.x[(1, 0)]).abs() < 1e-12, "y = x1 + 0.5 (-x1)");
    // Through the estimate of an observer there is none either: the estimate is its state.
    let observer = LinearObserver::of(plant(), Vector2::new(8.5, 13.75)).unwrap();
    Scenario::new(plant())
        .observer("one", &observer, &[1.0, 1.0])
        .input(Signal::feedback("one", DMatrix::from_row_slice(1, 2, &[1.0, 1.0])))
        .until(1.0, 2)
        .run()
        .unwrap();
}

/// An observer without D has a constant error in the limit; in a comparison the start of each is that of the input.
#[test]
fn an_observer_without_d_is_wrong() {
    let l = Vector2::new(8.5, 13.75);
    let (right, wrong) =
        (LinearObserver::of(plant(), l).unwrap(), LinearObserver::of(StaticPlant { d: None, ..plant() }, l).unwrap());
    let plant = plant();
    let scenario = Scenario::new(&plant).initial_state(&[1.0, -1.0]).input(Signal::scalar(|_| 1.0)).until(10.0, 11);
    let table =
        Comparison::new(scenario, &[0.0, 0.0]).observer("right", &right).observer("wrong", &wrong).run().unwrap();
    let last = |name: &str| table.metrics(name).unwrap().last;
    assert!(last("right") < 1e-9);
    // (A - L C) e = L D u: a constant error.
    let f = plant.a - l * plant.c;
    let stays: SVector<f64, 2> = f.try_inverse().unwrap() * l * 0.5;
    assert!((last("wrong") - stays.norm()).abs() < 1e-8, "{} {}", last("wrong"), stays.norm());
}

/// A plant in discrete time: the recursion itself, the input held, and observers in continuous time refused.
#[test]
fn a_plant_in_discrete_time_is_its_recursion() {
    let (ad, bd) = held();
    let discrete = StaticPlant { a: ad, b: bd, ..plant() };
    let observer = DiscreteLinearObserver::new(discrete.clone(), Vector2::new(0.5, 0.8), 0.1).unwrap();
    let times: Vec<f64> = (0..=20).map(|k| 0.1 * f64::from(k)).collect();
    let run = Scenario::new(discrete.clone())
        .discrete_time(0.1)
        .initial_state(&[1.0, -1.0])
        .input(Signal::scalar(input))
        .sampled_observer("linear", &observer, &[0.0, 0.0])
        .times(&times)
        .run()
        .unwrap();
    let (mut x, mut xhat): (Vector2<f64>, Vector2<f64>) = (Vector2::new(1.0, -1.0), Vector2::zeros());
    for (k, &t) in times.iter().enumerate() {
        let u = Vector1::new(input(t));
        assert!((run.x[(k, 0)] - x[0]).abs() < 1e-14 && (run.x[(k, 1)] - x[1]).abs() < 1e-14, "{k}");
        assert!((run.u[(k, 0)] - u[0]).abs() < 1e-14 && (run.y[(k, 0)] - x[0] - 0.5 * u[0]).abs() < 1e-14, "{k}");
        assert!((run.observers[0].estimate[(k, 0)] - xhat[0]).abs() < 1e-14, "{k}");
        let y = discrete.output(t, &x, &u);
        observer.step(t, &mut xhat, &u, &y);
        x = ad * x + bd * u;
    }
    // As scipy's recursion of the held plant.
    let at_end = Vector2::new(run.x[(20, 0)], run.x[(20, 1)]);
    assert!((at_end - Vector2::new(-0.219559077046171, 0.052056776492248)).amax() < 1e-12);
    let continuous = LinearObserver::of(discrete.clone(), Vector2::new(0.5, 0.8)).unwrap();
    let refused =
        Scenario::new(discrete.clone()).discrete_time(0.1).observer("one", continuous, &[0.0, 0.0]).until(1.0, 2).run();
    assert_eq!(refused.unwrap_err(), SimError::ContinuousObserver { name: "one".to_owned() });
    assert!(Scenario::new(discrete).discrete_time(0.0).until(1.0, 2).run().is_err());
}
