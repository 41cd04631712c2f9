//! The mean-value-theorem observer as printed in a study: the right-hand side of `luenberger-observers`, and no
//! certificate.

use luenberger_design::LeastSquares;
use luenberger_observers::{Beta, Integral, MeanValueObserver, Observer};
use luenberger_plants::Chaotic;
use luenberger_study::{RunOptions, Step, Study, deployment, execute};
use nalgebra::{SVector, Vector2, Vector3};

use crate::studies::{self, designed, read};

fn study(more: &str) -> Study {
    let text = format!(
        "[plant]\nbuiltin = \"chaotic\"\n[simulation]\nx0 = [-1.5, -1, 0.5]\nduration = 3\n[[observer]]\nkind = \"mean-value\"\neta = 1.2\ninitial = [-1, -0.5, -1]\n{more}\n"
    );
    studies::study(&text)
}

#[test]
fn the_observer_as_printed_runs_without_a_certificate() {
    let e0 = Vector3::new(-0.5, -0.5, 1.5);
    let (xhat, y) = (Vector3::new(-1.0, -0.5, -1.0), Vector2::new(-1.2, -0.7));
    let state: Vec<f64> = xhat.iter().chain(e0.iter()).copied().collect();
    let motion = |kind: &str| {
        let study = study(&format!("as_printed = \"{kind}\"\ninternal_error = [-0.5, -0.5, 1.5]"));
        let designed = designed(&study).unwrap();
        assert!(designed.certificate.is_none() && designed.report.verdict.word() == "none");
        assert!(designed.report.evidence.unwrap().contains("the theorem as printed is false"));
        let start = designed.runnable.initial(0.0, xhat.as_slice(), &[], y.as_slice()).unwrap();
        assert_eq!(start, state);
        designed.runnable.motion(0.0, &state, &[], y.as_slice()).unwrap()
    };
    macro_rules! same {
        ($kind:literal, $mean:expr) => {
            let observer = MeanValueObserver::new(Chaotic, 1.2, $mean, e0).unwrap();
            let state = observer.initial(0.0, &xhat, &SVector::zeros(), &y);
            let slope = observer.derivative(0.0, &state, &SVector::zeros(), &y);
            let slope: Vec<f64> = luenberger_plants::Column::as_slice(&slope).to_vec();
            let found = motion($kind);
            for (found, expected) in found.iter().zip(&slope) {
                assert!((found - expected).abs() < 1e-9, "{}: {found} {expected}", $kind);
            }
        };
    }
    same!("integral", Integral);
    same!("root", Beta);
    same!("least-squares", LeastSquares::new());
}

/// From e(0) = x(0) - xhat(0) the printed observer converges; with output injection it does so from e(0) = 0.
#[test]
fn the_initial_internal_error_decides_the_printed_observer() {
    let error_at_the_end = |more: &str| {
        let results = execute(&study(more), Step::Simulate, &RunOptions::default()).unwrap();
        results.simulation.unwrap().rows[0].merits.as_ref().unwrap().states[2].last
    };
    let informed = error_at_the_end("as_printed = \"integral\"\ninternal_error = [-0.5, -0.5, 1.5]");
    let uninformed = error_at_the_end("as_printed = \"integral\"");
    assert!(informed < 0.1 * uninformed, "{informed} {uninformed}");
}

#[test]
fn beta_by_an_iteration_has_no_export() {
    let study = study("as_printed = \"root\"");
    let refused = deployment::sampled(&study, &study.observers[0], Some(0.01), None).unwrap_err();
    assert!(refused.hypothesis.contains("as printed has no export"), "{refused:?}");
    assert!(refused.hints[1].contains("without `as_printed`"));
    let small =
        read("[plant]\nbuiltin = \"chaotic\"\n[[observer]]\nkind = \"mean-value\"\neta = 0.5\nas_printed = \"root\"\n");
    assert!(matches!(designed(&small.unwrap()), Err(failure) if failure.hypothesis.contains("0.5")));
}
