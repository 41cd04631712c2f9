//! Trajectories as part of the results, and runs of an observer that has been designed before.

use std::sync::atomic::AtomicBool;

use luenberger_design::DesignError;
use luenberger_linalg::LinalgError;
use luenberger_study::design::{Cause, Designed, design};
use luenberger_study::{RunOptions, Step, Study, StudyError, execute, replay_designed, simulate_designed};

use crate::studies::study_in;

const PLANT: &str = "[plant]\na = [[0, 1], [-2, -3]]\nb = [[0], [1]]\nc = [[1, 0]]\n";
const OBSERVERS: &str = "[[observer]]\nname = \"slow\"\nkind = \"luenberger\"\npoles = [-3, -4]\n\
                         [[observer]]\nname = \"filter\"\nkind = \"extended-kalman\"\nw = 0.01\nv = 0.04\nperiod = 0.1\n";
const RUN: &str = "[simulation]\nx0 = [1, -1]\nduration = 2\nsamples = 21\n\
                   noise = { amplitude = [0.1], period = 0.1, seed = 5 }\n";

fn study(parts: &[&str], folder: &std::path::Path) -> Study {
    study_in(folder, &parts.concat())
}

fn designed(study: &Study, number: usize) -> Designed {
    design(study, &study.observers[number], &AtomicBool::new(false)).unwrap()
}

#[test]
fn results_have_the_trajectory_of_each_observer() {
    let with = study(&[PLANT, RUN, OBSERVERS], ".".as_ref());
    let results = execute(&with, Step::Simulate, &RunOptions::default()).unwrap();
    let names: Vec<&str> = results.runs.iter().map(|run| run.observer.as_str()).collect();
    assert_eq!(names, ["slow", "filter"]);
    let without = study(&[PLANT, OBSERVERS], ".".as_ref());
    for (number, run) in results.runs.iter().enumerate() {
        assert!(!run.on_log && run.deviation.is_some() == (number == 1));
        let estimate = run.estimate.as_ref().unwrap();
        assert_eq!((run.t.len(), run.x.shape(), run.y.shape(), estimate.shape()), (21, (21, 2), (21, 1), (21, 2)));
        // The design does not depend on the simulation: that of the study without one gives the same bits.
        let again = simulate_designed(&with, &with.observers[number], &designed(&without, number), None).unwrap();
        assert_eq!(again, *run);
    }
    let alone = execute(&study(&[PLANT, RUN], ".".as_ref()), Step::Run, &RunOptions::default()).unwrap();
    assert_eq!((alone.runs.len(), alone.runs[0].observer.as_str()), (1, ""));
    assert_eq!(alone.runs[0].estimate, None);
    let missing = simulate_designed(&without, &without.observers[0], &designed(&without, 0), None);
    assert!(matches!(missing, Err(StudyError::Missing { .. })));
}

#[test]
fn results_have_the_estimates_on_a_log() {
    let folder = std::env::temp_dir().join(format!("luenberger-trajectories-{}", std::process::id()));
    std::fs::create_dir_all(&folder).unwrap();
    let rows = (0..=20).map(|k| format!("{},0,{}\n", f64::from(k) / 10.0, f64::from(k).sin()));
    std::fs::write(folder.join("log.csv"), format!("t,u1,y1\n{}", rows.collect::<String>())).unwrap();
    let with = study(&[PLANT, "[log]\nfile = \"log.csv\"\n", OBSERVERS], &folder);
    std::fs::remove_dir_all(&folder).unwrap();
    let results = execute(&with, Step::Simulate, &RunOptions::default()).unwrap();
    assert_eq!(results.runs.len(), 2);
    for (number, run) in results.runs.iter().enumerate() {
        assert!(run.on_log && run.x.ncols() == 0 && run.t.len() == 21);
        let again = replay_designed(&with, &with.observers[number], &designed(&with, number), None).unwrap();
        assert_eq!(again.estimate, run.estimate);
    }
}

#[test]
fn a_failed_design_has_its_error() {
    let text = "[plant]\na = [[1, 0], [0, -1]]\nc = [[0, 1]]\n[[observer]]\nkind = \"luenberger\"\npoles = [-1, -2]\n";
    let study = study(&[text], ".".as_ref());
    let failed = design(&study, &study.observers[0], &AtomicBool::new(false));
    let Err(failure) = failed else { panic!("the plant is not observable") };
    let Some(Cause::Design(DesignError::Linalg(LinalgError::Unobservable { eigenvalue, margin, .. }))) =
        failure.cause.as_deref()
    else {
        panic!("{failure:?}")
    };
    assert_eq!((eigenvalue.re, *margin), (1.0, 0.0));
}

/// The state of an observer, advanced by hand: the estimates of the simulation.
#[test]
fn an_observer_moves_by_its_own_functions() {
    let study = study(&[PLANT, OBSERVERS], ".".as_ref());
    for (number, wrong) in [(0, 1), (1, 2)] {
        let observer = designed(&study, number).runnable;
        let start = observer.initial(0.0, &[1.0, 2.0], &[0.0], &[0.0]).unwrap();
        assert_eq!(observer.estimate(0.0, &start, &[0.0], &[0.0]).unwrap(), [1.0, 2.0]);
        let moved = observer.motion(0.0, &start, &[0.0], &[1.0]).unwrap();
        assert_eq!(moved.len(), start.len());
        if number == 0 {
            // With the output that the estimate predicts nothing is corrected.
            assert_eq!(moved, [2.0, -8.0]);
        }
        let short = vec![0.0; wrong];
        assert_eq!(observer.motion(0.0, &start, &short[..0], &[1.0]), None);
        assert_eq!(observer.initial(0.0, &[1.0], &[0.0], &[0.0]), None);
    }
}

/// The rows of an observer that is sampled are samples, and its run goes on to the end.
#[test]
fn rows_of_a_sampled_observer_are_samples() {
    let plant = "[plant]\na = [[-1]]\nc = [[1]]\n[simulation]\nx0 = [1]\nduration = 1\nsamples = 6\n";
    let near = |observer: &str, wished: &[f64]| {
        let study = study(&[plant, "[[observer]]\n", observer], ".".as_ref());
        let results = execute(&study, Step::Simulate, &RunOptions::default()).unwrap();
        let times = &results.runs[0].t;
        assert!(times.len() == wished.len() && times.iter().zip(wished).all(|(a, b)| (a - b).abs() < 1e-12));
        let end = results.simulation.unwrap().x_end[0];
        assert!((end - (-1.0_f64).exp()).abs() < 1e-6, "{observer}: {end}");
    };
    let sampled = |period: f64, wished: &[f64]| {
        near(&format!("kind = \"extended-kalman\"\nw = 0.01\nv = 0.04\nperiod = {period}\n"), wished);
    };
    near("kind = \"luenberger\"\npoles = [-2]\n", &[0.0, 0.2, 0.4, 0.6, 0.8, 1.0]);
    sampled(0.1, &[0.0, 0.2, 0.4, 0.6, 0.8, 1.0]);
    // Eight samples, every second of them.
    sampled(0.13, &[0.0, 0.26, 0.52, 0.78]);
    sampled(0.3, &[0.0, 0.3, 0.6, 0.9]);
    sampled(2.0, &[0.0]);
}
