//! Comparisons: same information, honest rows.

use approx::assert_abs_diff_eq;
use luenberger_observers::{
    Beta, CubicObserver, ExtendedKalmanFilter, Integral, LinearObserver, MeanValueObserver, NoiseModel, Observer,
    ObserverDimensions,
};
use luenberger_plants::{Chaotic, StateSpace, double_integrator};
use luenberger_sim::{Comparison, Disturbances, Fault, Noise, Scenario, Signal, SimError, metrics};
use nalgebra::{Matrix1, Matrix2, Matrix3, Vector1, Vector2, Vector3, dmatrix};

/// `xhat' = xhat^2 + 1` in both entries: leaves every bound at t = pi/2 from 0.
struct Bursting;

impl Observer<f64> for Bursting {
    type State = Vector2<f64>;
    type Input = Vector1<f64>;
    type Output = Vector1<f64>;
    type Estimate = Vector2<f64>;

    fn dimensions(&self) -> ObserverDimensions {
        ObserverDimensions { state: 2, inputs: 1, outputs: 1, estimate: 2 }
    }

    fn derivative(&self, _t: f64, state: &Vector2<f64>, _u: &Vector1<f64>, _y: &Vector1<f64>) -> Vector2<f64> {
        state.map(|entry| entry * entry + 1.0)
    }

    fn estimate(&self, _t: f64, state: &Vector2<f64>, _u: &Vector1<f64>, _y: &Vector1<f64>) -> Vector2<f64> {
        *state
    }

    fn initial(&self, _t: f64, estimate: &Vector2<f64>, _u: &Vector1<f64>, _y: &Vector1<f64>) -> Vector2<f64> {
        *estimate
    }
}

/// A row says what the run of that observer alone says.
#[test]
fn a_row_is_what_a_run_gives() {
    let plant = double_integrator();
    let l = Vector2::new(7.0, 10.0);
    let linear = LinearObserver::of(plant.clone(), l).unwrap();
    let n = Vector2::new(-168.0, -196.0) / 17.0;
    let cubic = CubicObserver::of(plant.clone(), l, n, Matrix1::new(10.0)).unwrap();
    let scenario = Scenario::new(&plant).initial_state(&[-3.0, -3.0]).input(Signal::scalar(f64::sin)).until(8.0, 81);
    let table = Comparison::new(scenario.clone(), &[0.0, 0.0])
        .observer("linear", &linear)
        .observer("cubic", &cubic)
        .run()
        .unwrap();
    let run = scenario.observer("linear", &linear, &[0.0, 0.0]).run().unwrap();
    let norm = run.trace(|view| view.error("linear").map_or(f64::NAN, |e| e[0].hypot(e[1])));
    let merits = *table.metrics("linear").unwrap();
    assert_abs_diff_eq!(table.band * table.initial_error, 0.05 * 18f64.sqrt(), epsilon = 1e-15);
    // Tolerances of the integrator are 1e-11.
    let near = |a: f64, b: f64| (a - b).abs() < 1e-9;
    let band = table.band * table.initial_error;
    assert!(near(merits.settling_last.unwrap(), metrics::settling_last(&norm, band).unwrap()));
    assert!(near(merits.settling_first.unwrap(), metrics::settling_first(&norm, band).unwrap()));
    assert!(near(merits.peak, metrics::peak(&norm).unwrap().value));
    assert!(merits.peak >= table.initial_error * (1.0 - 1e-12) && merits.rmse < merits.peak);
    // e' = F e, F = [[-7, 1], [-10, 0]]: int |e|^2 = e0'Pe0 with F'P + PF = -I, which is -14 p11 - 20 p12 = -1, p11 - 7
    // p12 - 10 p22 = 0, 2 p12 = -1.
    let (p12, p11) = (-0.5, 11.0 / 14.0);
    let p22 = (p11 - 7.0 * p12) / 10.0;
    let integral: f64 = 9.0 * (p11 + 2.0 * p12 + p22);
    // What is left after t = 8 is e^-32 of it.
    assert!(near(merits.rmse, (integral / 8.0).sqrt()), "{merits:?}");
    assert!(table.rows.iter().all(|row| row.prior_information.is_empty() && row.cost.seconds > 0.0));
    let text = table.to_string();
    assert!(text.contains("linear") && text.contains("cubic") && text.contains("us/slope"), "{text}");
}

/// The printed mean-value observer with e(0) = x(0) - xhat(0) is marked in the table; with another e(0) it is not.
#[test]
fn prior_information_is_in_the_table() {
    let (x0, xhat0) = (Vector3::new(-2.0, -1.0, -1.0), Vector3::new(-1.0, -0.5, -1.5));
    let informed = MeanValueObserver::new(Chaotic, 1.0, Integral, x0 - xhat0).unwrap();
    let uninformed = MeanValueObserver::new(Chaotic, 1.0, Integral, Vector3::zeros()).unwrap();
    let noises = NoiseModel { w: Matrix3::identity() * 1e-2, v: Matrix2::identity() * 1e-4, p0: Matrix3::identity() };
    let filter = ExtendedKalmanFilter::new(Chaotic, noises, 0.01, 1).unwrap();
    let scenario = Scenario::new(Chaotic)
        .initial_state(x0.as_slice())
        .noise(Noise::uniform(&[1e-3, 1e-3], 0.01, 7))
        .until(2.0, 21);
    let table = Comparison::new(scenario, xhat0.as_slice())
        .observer("informed", &informed)
        .observer("uninformed", &uninformed)
        .sampled_observer("filter", &filter)
        .prior_information("filter", "the noise's intensity")
        .run()
        .unwrap();
    assert_eq!(table.row("informed").unwrap().prior_information, ["its state at the start contains x(0) - xhat(0)"]);
    assert!(table.row("uninformed").unwrap().prior_information.is_empty());
    assert_eq!(table.row("filter").unwrap().prior_information, ["the noise's intensity"]);
    assert!(table.row("filter").unwrap().cost.per_sample);
    let text = table.to_string();
    assert!(text.contains("noise of seed 7") && text.contains("[given more: its state at the start"), "{text}");
    assert_eq!(table.row("nobody"), Err(SimError::UnknownName { name: "nobody".into() }));
}

/// One observer that bursts is a row; the others are still compared.
#[test]
fn divergence_is_a_row() {
    let plant = double_integrator();
    let linear = LinearObserver::of(plant.clone(), Vector2::new(7.0, 10.0)).unwrap();
    let scenario = Scenario::new(&plant).initial_state(&[1.0, 1.0]).until(3.0, 11);
    let table = Comparison::new(scenario, &[0.0, 0.0])
        .observer("bursting", &Bursting)
        .observer("linear", &linear)
        .run()
        .unwrap();
    match table.metrics("bursting") {
        Err(SimError::BlowUp { time, .. }) => assert!((time - std::f64::consts::FRAC_PI_2).abs() < 1e-6),
        other => panic!("{other:?}"),
    }
    assert!(table.row("linear").unwrap().outcome.is_ok());
    assert!(table.to_string().contains("blows up"));
}

#[test]
fn bad_input_is_an_error() {
    let plant = double_integrator();
    let linear = LinearObserver::of(plant.clone(), Vector2::new(7.0, 10.0)).unwrap();
    let scenario = |x0: &[f64]| Scenario::new(&plant).initial_state(x0).until(1.0, 2);
    let of = |x0: &[f64], xhat0: &[f64]| Comparison::new(scenario(x0), xhat0).observer("linear", &linear);
    let empty = Comparison::new(scenario(&[1.0, 1.0]), &[0.0, 0.0]);
    assert_eq!(empty.run(), Err(SimError::NoObserver));
    // Its first estimate would be another one.
    let own = scenario(&[1.0, 1.0]).observer("own", &linear, &[1.0, 1.0]);
    let refused = Comparison::new(own, &[0.0, 0.0]).observer("linear", &linear).run();
    assert_eq!(refused, Err(SimError::ObserverOfScenario { name: "own".to_owned() }));
    assert!(matches!(of(&[1.0], &[0.0, 0.0]).run(), Err(SimError::Length { expected: 2, found: 1, .. })));
    assert!(matches!(of(&[1.0, f64::NAN], &[0.0, 0.0]).run(), Err(SimError::NotFinite { index: 1, .. })));
    // Nothing to observe away: every observer would look perfect.
    assert!(matches!(of(&[1.0, 1.0], &[1.0, 1.0]).run(), Err(SimError::NotPositive { .. })));
    assert!(matches!(of(&[1.0, 1.0], &[0.0, 0.0]).band(0.0).run(), Err(SimError::NotPositive { .. })));
    assert!(matches!(
        of(&[1.0, 1.0], &[0.0, 0.0]).observer("linear", &linear).run(),
        Err(SimError::DuplicateName { .. })
    ));
    assert!(matches!(
        of(&[1.0, 1.0], &[0.0, 0.0]).prior_information("other", "x(0)").run(),
        Err(SimError::UnknownName { .. })
    ));
    let wrong = MeanValueObserver::new(Chaotic, 1.0, Beta, Vector3::zeros()).unwrap();
    assert!(matches!(of(&[1.0, 1.0], &[0.0, 0.0]).observer("other", &wrong).run(), Err(SimError::Length { .. })));
}

/// An observer without correction, whose state holds numbers beside its estimate.
struct Holding<const N: usize>(nalgebra::SVector<f64, N>);

impl<const N: usize> Observer<f64> for Holding<N> {
    type State = nalgebra::SVector<f64, N>;
    type Input = Vector1<f64>;
    type Output = Vector1<f64>;
    type Estimate = Vector2<f64>;

    fn dimensions(&self) -> ObserverDimensions {
        ObserverDimensions { state: N, inputs: 1, outputs: 1, estimate: 2 }
    }

    fn derivative(&self, _t: f64, _state: &Self::State, _u: &Vector1<f64>, _y: &Vector1<f64>) -> Self::State {
        Self::State::zeros()
    }

    fn estimate(&self, _t: f64, _state: &Self::State, _u: &Vector1<f64>, _y: &Vector1<f64>) -> Vector2<f64> {
        Vector2::zeros()
    }

    fn initial(&self, _t: f64, _estimate: &Vector2<f64>, _u: &Vector1<f64>, _y: &Vector1<f64>) -> Self::State {
        self.0
    }
}

/// The true state is recognised within rounding anywhere in an observer's state, but not from one of its entries, nor
/// with an entry 0, which are there by chance.
#[test]
fn the_true_state_in_an_observer_is_recognised() {
    let plant = double_integrator();
    let informed = |x0: [f64; 2], state: [f64; 4]| {
        let observer = Holding(nalgebra::SVector::from(state));
        let scenario = Scenario::new(&plant).initial_state(&x0).until(0.1, 2);
        let table = Comparison::new(scenario, &[0.5, 0.25]).observer("holding", &observer).run().unwrap();
        table.row("holding").unwrap().prior_information.clone()
    };
    let next = |x: f64| x * (1.0 + 2.0 * f64::EPSILON);
    assert_eq!(informed([3e3, -7e3], [1.0, 3e3, -7e3, 2.0]).len(), 1);
    assert_eq!(informed([3e3, -7e3], [1.0, 5.0, next(3e3), next(-7e3)]).len(), 1);
    assert!(informed([3e3, -7e3], [3e3, 1.0, -7e3, 2.0]).is_empty());
    assert!(informed([3e3, -7e3], [3e3 + 1e-9, -7e3, 0.0, 0.0]).is_empty());
    assert!(informed([3e3, 0.0], [3e3, 0.0, 0.0, 0.0]).is_empty());
    assert!(informed([3e3, -7e3], [-7e3, 3e3, 0.0, 0.0]).is_empty());
    // x(0) - xhat(0) = 1 is also the first estimate.
    let plant = StateSpace::new(dmatrix![-1.0], dmatrix![0.0], dmatrix![1.0]).unwrap();
    let linear = LinearObserver::of(plant.clone(), dmatrix![1.0]).unwrap();
    let scenario = Scenario::new(plant).initial_state(&[2.0]).until(1.0, 2);
    let table = Comparison::new(scenario, &[1.0]).observer("linear", &linear).run().unwrap();
    assert!(table.row("linear").unwrap().prior_information.is_empty());
}

/// A feedback of estimates would give each observer another plant.
#[test]
fn a_feedback_of_estimates_is_refused() {
    let plant = double_integrator();
    let linear = LinearObserver::of(plant.clone(), Vector2::new(7.0, 10.0)).unwrap();
    let of = |input| {
        let scenario = Scenario::new(&plant).initial_state(&[1.0, 1.0]).input(input).until(1.0, 2);
        Comparison::new(scenario, &[0.0, 0.0]).observer("linear", &linear).run()
    };
    let gain = nalgebra::dmatrix![1.0, 2.0];
    assert!(matches!(of(Signal::feedback("linear", gain.clone())), Err(SimError::EstimateFeedback)));
    assert!(of(Signal::state_feedback(gain)).is_ok());
}

/// What a scenario has, a comparison has: here another start, a bias of the sensor and a jump of the input.
#[test]
fn a_comparison_takes_all_of_its_scenario() {
    let plant = double_integrator();
    let linear = LinearObserver::of(plant.clone(), Vector2::new(7.0, 10.0)).unwrap();
    let bias = Fault { gain: vec![1.0], bias: vec![0.1], from: 2.0 };
    let scenario = Scenario::new(&plant)
        .start(2.0)
        .initial_state(&[1.0, 1.0])
        .input(Signal::function(|t, u| u.fill(if t < 3.0 { 1.0 } else { 0.0 })))
        .breakpoints(&[3.0])
        .disturbances(Disturbances { sensor: Some(bias), ..Disturbances::default() })
        .until(12.0, 2);
    let table = Comparison::new(scenario.clone(), &[0.0, 0.0]).observer("linear", &linear).run().unwrap();
    let run = scenario.observer("linear", &linear, &[0.0, 0.0]).run().unwrap();
    assert_eq!(table.row("linear").unwrap().trajectory.as_ref(), Some(&run));
    assert!((table.metrics("linear").unwrap().last - 0.1).abs() < 1e-6);
}
