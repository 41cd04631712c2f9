//! The solver for matrix inequalities that a study selects, in every design that needs one.

use std::sync::atomic::AtomicBool;

use luenberger_lmi::Solver;
use luenberger_study::design::design;
use luenberger_study::results::DesignReport;
use luenberger_study::{Study, StudyError};

use crate::studies::read;

const LINEAR: &str = r#"[plant]
a = [[0, 1], [0, 0]]
c = [[1, 0]]
[[observer]]
name = "by margin"
kind = "luenberger"
lmi = true
[[observer]]
name = "by rate"
kind = "luenberger"
decay_rate = 0.5
[[observer]]
kind = "cubic"
lmi = true
gamma = 2
[[observer]]
kind = "sampled-cubic"
lmi = true
gamma = 0.5
period = 0.05
"#;

const PENDULUM: &str = r#"[plant]
f = ["x2", "-sin(x1)"]
h = ["x1"]
[[observer]]
kind = "lpv"
decay_rate = 0.5
[[observer]]
name = "the fastest"
kind = "lpv"
fastest = 4
[[observer]]
name = "of this gain"
kind = "lpv"
gain = [[4], [6]]
[[observer]]
kind = "lipschitz"
decay_rate = 0.5
[[observer]]
name = "sector of this gain"
kind = "lipschitz"
gain = [[4], [6]]
[[observer]]
kind = "mean-value"
decay_rate = 0.5
"#;

fn designs(study: &Study) -> Vec<(String, DesignReport)> {
    let cancel = AtomicBool::new(false);
    let one = |requested| match design(study, requested, &cancel) {
        Ok(designed) => designed.report,
        Err(failure) => panic!("{failure:?}"),
    };
    study.observers.iter().map(|requested| (requested.name.clone(), one(requested))).collect()
}

/// Another solver returns another P in the same open set: if the selection were ignored, the matrices would be
/// identical to the last bit.
#[test]
fn it_reaches_every_inequality_of_a_design_and_the_proof_decides() {
    for text in [LINEAR, PENDULUM] {
        let ours = read(text).unwrap();
        assert_eq!(ours.solver, Solver::Interior);
        assert_eq!(read(&format!("solver = \"interior\"\n{text}")).unwrap().solver, Solver::Interior);
        let theirs = read(&format!("solver = \"clarabel\"\n{text}")).unwrap();
        assert_eq!(theirs.solver, Solver::Clarabel);
        // The reports name the solver for this reason.
        assert!(theirs.observers.iter().all(|requested| requested.kind.poses_inequality()));
        for ((name, ours), (_, theirs)) in designs(&ours).into_iter().zip(designs(&theirs)) {
            assert_eq!((ours.verdict.word(), theirs.verdict.word()), ("proved", "proved"), "{name}");
            assert_ne!(ours.matrices, theirs.matrices, "{name}");
        }
    }
}

#[test]
fn another_word_is_a_mistake() {
    let Err(StudyError::File(diagnostics)) = read(&format!("solver = \"claribel\"\n{LINEAR}")) else {
        panic!("the mistake was not found")
    };
    let found = diagnostics.located();
    assert_eq!(found.len(), 1, "{found:#?}");
    assert_eq!(found[0].line, 1);
    assert!(found[0].message.contains("claribel"), "{found:#?}");
    assert!(found[0].expected.contains("expected one of \"interior\", \"clarabel\""), "{found:#?}");
    assert_eq!(found[0].help.as_deref(), Some("the nearest is `clarabel`"));
}
