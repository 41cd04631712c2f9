//! The template `cuk-table-1`, run as it is, beside Table I's observers as `luenberger-reproduce` has them in Rust, in
//! the run of its figure: the estimates are the same.

use luenberger_observers::Observer;
use luenberger_plants::{Column, CukConverter};
use luenberger_reproduce::kkl::cuk::{self, Tuning};
use luenberger_sim::{Integrator, Scenario, Signal};
use luenberger_study::{Format, RunOptions, Step, Study, execute, template};
use nalgebra::{Vector1, Vector2, Vector4};

/// As in `reproduce::kkl::converter`.
const SET_POINTS: [f64; 6] = [15.0, 25.0, 10.0, 20.0, 10.0, 15.0];
const JUMPS: [f64; 5] = [0.2, 0.4, 0.6, 0.8, 1.0];
const START: f64 = 5.0;
const LAMBDA: f64 = 0.2;

trait Table: Observer<f64, Input = Vector1<f64>, Output = Vector2<f64>, Estimate = Vector2<f64>> {}

impl<O: Observer<f64, Input = Vector1<f64>, Output = Vector2<f64>, Estimate = Vector2<f64>>> Table for O {}

/// The estimate of (i1, v4) with all dynamic extensions at 0.
fn at_rest(observer: &impl Table, u: f64, x: &Vector4<f64>) -> [f64; 2] {
    fn zero<O: Table>(observer: &O) -> O::State {
        O::State::from_slice(&vec![0.0; observer.dimensions().state])
    }
    let estimate = observer.estimate(0.0, &zero(observer), &Vector1::new(u), &Vector2::new(x[1], x[2]));
    [estimate[0], estimate[1]]
}

#[test]
fn one_study_has_the_trajectories_of_table_i() {
    let text = template::text("cuk-table-1").unwrap();
    let study = Study::from_text("cuk-table-1.toml", text, Format::Toml, ".".as_ref()).unwrap();
    let results = execute(&study, Step::Simulate, &RunOptions::default()).unwrap();
    assert_eq!(results.failures(), Vec::<String>::new());

    let (plant, tuning, zero) = (CukConverter::default(), Tuning::default(), Vector4::zeros());
    let x0 = plant.equilibrium(START);
    let first = plant.control(&x0, SET_POINTS[0], LAMBDA);
    let times: Vec<f64> = (0..=1200).map(|k| f64::from(k) / 1000.0).collect();
    let set_point = |t: f64| SET_POINTS[JUMPS.iter().filter(|jump| t >= **jump).count()];
    let mut scenario = Scenario::new(plant)
        .initial_state(x0.as_slice())
        .input(Signal::law(move |view, u| {
            u[0] = plant.control(&Vector4::from_column_slice(view.x), set_point(view.t), LAMBDA);
        }))
        .breakpoints(&times[1..])
        .integrator(Integrator::Explicit)
        .tolerances(1e-11, 1e-12)
        .times(&times);
    macro_rules! join {
        ($($name:literal $observer:expr;)*) => {
            $(
                let observer = $observer.unwrap();
                let start = at_rest(&observer, first, &x0);
                scenario = scenario.partial_observer($name, observer, &start, &[0, 3]);
            )*
        };
    }
    join! {
        "KKLO" cuk::kklo(plant);
        "PEBO" cuk::pebo(plant, &tuning);
        "KKL+PEBO" cuk::kkl_pebo(plant, &tuning);
        "I&IO" cuk::immersion_invariance(plant, &tuning);
        "HGO time-varying" cuk::high_gain_time_varying(plant, &tuning).unwrap().starting_at(zero);
        "HGO linear" cuk::high_gain_differentiator(plant, &tuning).unwrap().starting_at(zero);
    }
    let table = scenario.run().unwrap();

    assert_eq!(results.runs.len(), 6);
    for run in &results.runs {
        let (own, of_table) = (run.estimate.as_ref().unwrap(), &table.observer(&run.observer).unwrap().estimate);
        assert_eq!(run.t.len(), times.len());
        let mut largest = [0.0_f64; 2];
        // At a jump of the input the linear high-gain observer jumps, to the left or to the right of it.
        for k in (0..times.len()).filter(|k| k % 200 != 0) {
            assert!((run.t[k] - times[k]).abs() < 1e-9);
            for (largest, (from, of)) in largest.iter_mut().zip([(0, 0), (3, 1)]) {
                *largest = largest.max((own[(k, from)] - of_table[(k, of)]).abs());
            }
        }
        assert!(largest[0] < 1e-6 && largest[1] < 1e-6, "{}: {largest:?}", run.observer);
    }
}
