//! A run of an ensemble is the run of a scenario, to the last bit, whatever runs are beside it.

use luenberger_expression::{ExpressionPlant, Parameters};
use luenberger_observers::{CubicObserver, LaneObserver, LinearObserver, NonlinearLuenbergerObserver, Observer};
use luenberger_plants::{LanePlant, Plant, StateSpace, double_integrator};
use luenberger_sim::{Ensemble, Integrator, Member, Noise, Scenario, Settings, Signal, SimError};
use nalgebra::{Matrix1, Vector2, dmatrix};

fn members(count: usize, size: f64) -> Vec<Member> {
    let entry = |k: usize, i: usize| size * ((7 * k + 3 * i) as f64).sin();
    (0..count)
        .map(|k| Member { x0: vec![entry(k, 0), entry(k, 1)], estimate: vec![entry(k, 2), 0.0], number: k as u64 })
        .collect()
}

/// Compares with scenarios, and with the same ensemble in other groups.
fn compare<P, O>(plant: &P, observer: &O, members: &[Member], noise: Option<&Noise>, settings: Settings)
where
    P: Plant<f64> + LanePlant + Sync,
    O: Observer<f64> + LaneObserver + Sync,
{
    let times: Vec<f64> = (0..=40).map(|k| 0.1 * f64::from(k)).collect();
    let mut ensemble = Ensemble::new(plant, observer).times(&times).settings(settings);
    ensemble = ensemble.input(|t, u| u.fill(t.sin()));
    let mut base = Scenario::new(plant).times(&times).settings(settings).input(Signal::scalar(f64::sin));
    if let Some(noise) = noise {
        ensemble = ensemble.noise(noise.clone());
    }
    let runs = ensemble.run(members);
    for (member, run) in members.iter().zip(&runs) {
        if let Some(noise) = noise {
            base = base.noise(noise.clone()).member(member.number);
        }
        let scenario = base.clone().initial_state(&member.x0).observer("observer", observer, &member.estimate).run();
        match (run, scenario) {
            (Ok(run), Ok(scenario)) => {
                assert_eq!((&run.x, &run.estimate), (&scenario.x, &scenario.observers[0].estimate));
                assert_eq!((run.steps, run.error()), (scenario.steps, scenario.observers[0].error.clone()));
            }
            (run, scenario) => assert_eq!(run.as_ref().unwrap_err(), &scenario.unwrap_err()),
        }
    }
    let parts: Vec<_> = members.chunks(3).flat_map(|part| ensemble.run(part)).collect();
    assert_eq!(parts, runs);
}

fn cubic() -> CubicObserver<f64, nalgebra::Const<2>, nalgebra::Const<1>, nalgebra::Const<1>> {
    let (l, n) = (Vector2::new(7.0, 10.0), Vector2::new(-168.0, -196.0) / 17.0);
    CubicObserver::of(double_integrator(), l, n, Matrix1::new(10.0)).unwrap()
}

#[test]
fn linear_and_cubic_observers() {
    let plant = double_integrator();
    let linear = LinearObserver::of(plant.clone(), Vector2::new(7.0, 10.0)).unwrap();
    for noise in [None, Some(Noise::uniform(&[0.02], 0.03, 5)), Some(Noise::gaussian(&[0.1], 0.05, 2))] {
        let settings = Settings { rtol: 1e-9, atol: 1e-12, ..Settings::default() };
        compare(&plant, &cubic(), &members(19, 3.0), noise.as_ref(), settings);
        compare(&plant, &linear, &members(9, 3.0), noise.as_ref(), settings);
    }
}

#[test]
fn unknown_sizes_and_feedthrough() {
    let plant = StateSpace::new(dmatrix![0.0, 1.0; -1.0, -0.2], dmatrix![0.0; 1.0], dmatrix![1.0, 0.0; 0.0, 2.0]);
    let plant = plant.unwrap().with_feedthrough(dmatrix![0.3; 0.0]).unwrap();
    let (l, n) = (dmatrix![2.0, 0.1; 1.0, 0.3], dmatrix![-1.0, 0.0; -0.5, -0.7]);
    let observer = CubicObserver::of(plant.clone(), l, n, dmatrix![2.0, 0.5; 0.5, 1.0]).unwrap();
    compare(&plant, &observer, &members(5, 2.0), Some(&Noise::uniform(&[0.1, 0.2], 0.07, 1)), Settings::default());
}

#[test]
fn a_plant_of_expressions() {
    let plant = ExpressionPlant::new(&["x2", "u1 - sin(x1)*if(x2 > 0, 1, 2)"], &["x1"], 1, &Parameters::new()).unwrap();
    let observer = NonlinearLuenbergerObserver::new(plant.clone(), dmatrix![8.0; 20.0]).unwrap();
    compare(&plant, &observer, &members(11, 1.0), Some(&Noise::gaussian(&[0.01], 0.1, 1)), Settings::default());
}

/// Large errors are stiff for a while, and few steps make them implicit: those runs are made alone.
#[test]
fn runs_that_leave_their_lane() {
    let plant = double_integrator();
    let few = Settings { max_steps: 120, ..Settings::default() };
    let mut mixed = members(10, 3.0);
    mixed[4].x0 = vec![3e3, 0.0];
    mixed[7].x0 = vec![1e90, 0.0];
    mixed[8].x0 = vec![f64::INFINITY, 0.0];
    mixed[9].estimate.clear();
    compare(&plant, &cubic(), &mixed, None, few);
    compare(&plant, &cubic(), &mixed[..8], None, Settings { integrator: Integrator::Implicit, ..few });
    // The wrong sign of the gain: in finite time the errors are infinite.
    let mut wrong = cubic();
    wrong.n = -wrong.n;
    compare(&plant, &wrong, &members(9, 3.0), None, Settings::default());
}

#[test]
fn bad_input_is_an_error_of_each_run() {
    let (plant, observer) = (double_integrator(), cubic());
    let runs = Ensemble::new(&plant, &observer).times(&[1.0, 0.5]).run(&members(2, 1.0));
    assert!(runs.iter().all(|run| matches!(run, Err(SimError::TimesUnsorted { .. }))), "{runs:?}");
    let runs = Ensemble::new(&plant, &observer).until(1.0, 1).run(&members(1, 1.0));
    assert!(runs[0].is_err());
    assert!(Ensemble::new(&plant, &observer).until(1.0, 2).run(&[]).is_empty());
}
