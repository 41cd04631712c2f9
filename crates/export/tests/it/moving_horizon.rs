//! Moving-horizon estimators as C: the bits of the Rust estimator with and without active bounds, what is not finite,
//! and what the header says of cost and memory. Without a C compiler the first two say so and pass.

use luenberger_export::moving_horizon::MovingHorizon;
use luenberger_export::{Export, ExportableObserver, Names, Scalar, golden};
use luenberger_expression::{ExpressionPlant, Parameters};
use luenberger_observers::{Horizon, NoiseModel, SampledObserver};
use luenberger_random::Random;
use nalgebra::{DVector, dmatrix, dvector};

use crate::compiled::{self, SANITISERS, can_sanitise, compilers, is_complete};
use crate::fuzz;

const STEPS: usize = 200;

pub(crate) fn plant(f: &[&str], h: &[&str], inputs: usize) -> ExpressionPlant {
    ExpressionPlant::new(f, h, inputs, &Parameters::new()).unwrap()
}

/// How many steps of a run end at a bound, and how many within all.
fn at_bounds(estimator: &MovingHorizon<f64>, initial: &[f64], run: &[golden::Step]) -> (usize, usize) {
    let Some((lower, upper)) = estimator.bounds() else { return (0, run.len()) };
    let column = |values: &[f64]| DVector::from_column_slice(values);
    let (mut state, mut active) = (estimator.initial(0.0, &column(initial), &dvector![], &dvector![]), 0);
    for (k, step) in run.iter().enumerate() {
        let (t, u) = (k as f64 * estimator.period(), column(&step.u));
        assert!(estimator.update(t, &mut state, &u, &column(&step.y), |_| true).is_some(), "step {k}");
        let found = estimator.estimate(&state);
        let near = |bound: f64, x: f64| (bound - x).abs() <= 1e-6;
        active += usize::from((0..found.len()).any(|i| near(lower[i], found[i]) || near(upper[i], found[i])));
        assert!(estimator.predict(t, &mut state, &u, estimator.period()));
    }
    (active, run.len() - active)
}

/// Eight estimators of random plants, in both formats and under every compiler; in a complete run also with the
/// sanitizers.
#[test]
fn random_estimators_agree_with_the_rust_one_with_and_without_active_bounds() {
    let compilers = compilers();
    let Some(first) = compilers.first() else {
        eprintln!("SKIPPED: no C compiler");
        return;
    };
    let folder = compiled::folder("moving-horizon");
    let mut random = Random(21);
    let (mut exports, mut runs, mut steps) = (Vec::new(), Vec::new(), (0, 0));
    for k in 0..8 {
        let estimator = fuzz::moving_horizon(&mut random);
        let scalar = if k % 2 == 0 { Scalar::Binary64 } else { Scalar::Binary32 };
        let export =
            fuzz::export(&format!("p{}", exports.len()), ExportableObserver::MovingHorizon(estimator.clone()), scalar);
        let Ok(run) = golden::steps(&export, STEPS) else { continue };
        if scalar == Scalar::Binary64 {
            let initial: Vec<f64> =
                (0..export.observer().dimensions().estimate).map(|i| 0.1 * i as f64 - 0.3).collect();
            let (active, inactive) = at_bounds(&estimator, &initial, &run);
            steps = (steps.0 + active, steps.1 + inactive);
        }
        exports.push(export);
        runs.push(run);
    }
    assert!(exports.len() >= 7, "only {} of 8 estimators have a run", exports.len());
    assert!(steps.0 >= 100 && steps.1 >= 100, "{} steps at a bound and {} within", steps.0, steps.1);
    fuzz::write(&folder, &exports, &runs);
    for compiler in &compilers {
        fuzz::compare(&folder, &exports, &runs, compiler, &[compiled::optimisation()]);
    }
    if !is_complete() {
        return;
    }
    fuzz::compare(&folder, &exports, &runs, first, &["-O0"]);
    if can_sanitise(first) {
        fuzz::compare(&folder, &exports, &runs, first, &SANITISERS);
    } else {
        eprintln!("SKIPPED: {first} has no sanitizers here");
    }
}

/// A measurement that is not finite is passed over; an input that is not finite makes one estimate not finite.
#[test]
fn what_is_not_finite_is_passed_over() {
    let Some(compiler) = compilers().into_iter().next() else {
        eprintln!("SKIPPED: no C compiler");
        return;
    };
    let folder = compiled::folder("moving-horizon-not-finite");
    let noises = NoiseModel { w: dmatrix![0.1, 0.0; 0.0, 0.2], v: dmatrix![0.05], p0: dmatrix![1.0, 0.0; 0.0, 1.0] };
    let horizon = Horizon { window: 4, iterations: 2 };
    let free = |h: &str| {
        let plant = plant(&["x2", "-sin(x1) - 0.1*x2 + u1"], &[h], 1);
        MovingHorizon::new(plant, noises.clone(), horizon, 0.1, 1).unwrap()
    };
    let bounded = free("x1").with_bounds(dvector![-0.1, f64::NEG_INFINITY], dvector![0.1, 0.2]).unwrap();
    let (mut exports, mut runs) = (Vec::new(), Vec::new());
    for estimator in [free("x1"), bounded, free("x1*(1 + 0.1*x2)")] {
        for bad in [f64::NAN, f64::INFINITY] {
            for spoils_input in [false, true] {
                let name = format!("p{}", exports.len());
                let export =
                    fuzz::export(&name, ExportableObserver::MovingHorizon(estimator.clone()), Scalar::Binary64);
                let mut run = golden::steps(&export, STEPS).unwrap();
                let at = STEPS / 2;
                if spoils_input {
                    run[at].u[0] = bad;
                } else {
                    run[at].y[0] = bad;
                }
                let samples: Vec<_> = run.iter().map(|step| (step.u.clone(), step.y.clone())).collect();
                for (step, estimate) in run.iter_mut().zip(golden::replay(&export, &samples).unwrap()) {
                    step.estimate = estimate;
                }
                let spoiled = |step: &golden::Step| step.estimate.iter().any(|x| !x.is_finite());
                let found: Vec<usize> = (0..STEPS).filter(|k| spoiled(&run[*k])).collect();
                assert_eq!(found, if spoils_input { vec![at] } else { Vec::new() }, "{bad}");
                exports.push(export);
                runs.push(run);
            }
        }
    }
    fuzz::write(&folder, &exports, &runs);
    fuzz::compare(&folder, &exports, &runs, compiler, &[compiled::optimisation()]);
}

/// `sizeof` of the state is what the header says, in both formats and with the time; the operations without active
/// bounds are those of the estimator without bounds.
#[test]
fn cost_and_memory_are_in_the_header() {
    let noises = NoiseModel { w: dmatrix![0.1, 0.0; 0.0, 0.2], v: dmatrix![0.05], p0: dmatrix![1.0, 0.0; 0.0, 1.0] };
    let free = |last: &str| {
        let plant = plant(&["x1 + 0.1*x2", last], &["x1"], 1);
        MovingHorizon::discrete(plant, noises.clone(), Horizon { window: 5, iterations: 1 }, 0.1).unwrap()
    };
    let export = |estimator: MovingHorizon<f64>, scalar| {
        let names = Names::numbered(2, 1, 1);
        Export::new("cart", ExportableObserver::MovingHorizon(estimator), scalar, &[0.0, 0.5], names).unwrap()
    };
    let header = |export: &Export| {
        let files = export.c().unwrap();
        files.into_iter().find(|file| file.name == "cart.h").unwrap().text
    };
    let folder = compiled::folder("moving-horizon-size");
    for last in ["0.9*x2 + 0.1*u1", "0.9*x2 + 0.1*u1 + 0.01*cos(t)"] {
        for scalar in [Scalar::Binary32, Scalar::Binary64] {
            let bounded = free(last).with_bounds(dvector![f64::NEG_INFINITY, 0.0], dvector![1.0, 2.0]).unwrap();
            let (outputs, states) = (dvector![360.0], dvector![0.0, 0.0]);
            let angles = header(&export(free(last).with_angles(outputs, states).unwrap(), scalar));
            let (free, bounded) = (export(free(last), scalar), export(bounded, scalar));
            assert_eq!(free.operations_within_bounds(), None);
            assert_eq!(bounded.operations_within_bounds(), Some(free.operations()));
            assert!(bounded.operations() > 30 * free.operations());
            assert!(header(&free).contains(&format!("at most {} floating-point operations.", free.operations())));
            let text = header(&bounded);
            let statement = format!(
                "One step takes at most {} floating-point operations, {} without active bounds.",
                bounded.operations(),
                free.operations()
            );
            assert!(text.contains(&statement), "{text}");
            assert!(!text.contains("Angles"), "{text}");
            let said = " * Angles, on any turn: y1. Their differences are taken within half a turn; xhat is not wrapped.\n *\n";
            assert!(angles.contains(said), "{angles}");
            let bytes = text.split("The state has ").nth(1).and_then(|rest| rest.split(' ').next()).unwrap();
            let Some(compiler) = compilers().into_iter().next() else { continue };
            std::fs::write(folder.join("cart.h"), &text).unwrap();
            let size = format!("#include \"cart.h\"\ntypedef char right[(sizeof(cart_state) == {bytes}) ? 1 : -1];\n");
            std::fs::write(folder.join("size.c"), size).unwrap();
            let built =
                std::process::Command::new(compiler).current_dir(&folder).args(["-c", "size.c"]).output().unwrap();
            assert!(built.status.success(), "{scalar:?}, {bytes}: {}", String::from_utf8_lossy(&built.stderr));
        }
    }
}
