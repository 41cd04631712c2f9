//! The kind `sampled-cubic` beyond the radial gain at one period: `s`, `weighted`, `jitter`, `misses`.

use luenberger_proof::certificate::{Theorem, verify};
use luenberger_study::Step;

use crate::studies::{executed, mistake, read};

const STUDY: &str = r#"[plant]
a = [[0, 1, 0], [-4, -0.2, 1], [0, 0, -0.1]]
b = [[0], [1], [0]]
c = [[1, 0, 0], [0, 1, 0]]
[simulation]
x0 = [100, -50, 10]
duration = 12
[[observer]]
name = "general"
kind = "sampled-cubic"
poles = [-2, -3, -4]
s = [[2, 1], [-1, 0.5]]
period = 0.1
jitter = [0.07, 0.14]
misses = 2
[[observer]]
name = "weighted"
kind = "sampled-cubic"
poles = [-2, -3, -4]
theta = [[1, 0], [0, 0]]
weighted = 2
period = 0.1
[[observer]]
name = "radial"
kind = "sampled-cubic"
poles = [-2, -3, -4]
gamma = 2
period = 0.1
misses = 1
"#;

#[test]
fn every_form_is_proved_and_converges() {
    let found = executed(STUDY, Step::Run);
    for observer in &found.observers {
        let design = observer.design.as_ref().unwrap_or_else(|| panic!("{observer:?}"));
        assert_eq!(design.verdict.word(), "proved", "{}: {:?}", observer.name, design.facts);
    }
    let rows = &found.simulation.as_ref().unwrap().rows;
    for row in rows {
        for state in &row.merits.as_ref().unwrap_or_else(|| panic!("{row:?}")).states {
            assert!(state.last.abs() < 1e-4, "{}: {state:?}", row.observer);
        }
    }
    let words = &found.observers[0].design.as_ref().unwrap().statement;
    assert!(words.starts_with("For periods from 0.07 to 0.14 with at most 2 missed samples in a row"), "{words}");
    assert!(words.contains("semi-implicit"), "{words}");
}

#[test]
fn what_is_not_proved_says_what_is() {
    let wide = STUDY.replacen("[0.07, 0.14]", "[0.02, 3]", 1);
    let found = executed(&wide, Step::Design);
    let failure = found.observers[0].failure.as_ref().unwrap();
    assert!(failure.hypothesis.contains("it is proved for periods from"), "{failure:?}");
    let alternative = failure.alternatives[0].words();
    let proved = alternative.strip_prefix("jitter = ").unwrap().split(", misses").next().unwrap();
    let narrower = STUDY.replacen("[0.07, 0.14]", proved, 1);
    assert!(executed(&narrower, Step::Design).observers[0].failure.is_none(), "{alternative}");
}

#[test]
fn mistakes_are_found_where_they_are() {
    for (from, to, line, message, expected) in [
        ("gamma = 2", "gamma = 2\nweighted = 1", 28, "`weighted` conflicts with `gamma`", "one of gamma, weighted, s"),
        ("gamma = 2\n", "", 23, "no gain specification", "one of gamma, weighted, s"),
        ("[[2, 1], [-1, 0.5]]", "[[2, 1]]", 12, "`s`", "2"),
        (
            "[0.07, 0.14]",
            "[0.11, 0.14]",
            14,
            "`jitter` is from 0.11 to 0.14, and `period` is 0.1",
            "contain the period",
        ),
        ("[0.07, 0.14]", "[0.0, 0.14]", 14, "`jitter` is from 0 to 0.14", "positive, finite bounds"),
        ("[0.07, 0.14]", "[0.05, inf]", 14, "`jitter`", "finite"),
        ("misses = 2", "misses = 65", 15, "`misses` is 65", "at most 64"),
        ("misses = 2", "misses = -1", 15, "`misses`", "a whole number of at least 0"),
    ] {
        let text = STUDY.replacen(from, to, 1);
        assert_ne!(text, STUDY, "{from}");
        let found = mistake(&text);
        assert_eq!(found.line, line, "{to}: {found:?}");
        assert!(found.message.contains(message), "{to}: {found:?}");
        assert!(found.expected.contains(expected), "{to}: {found:?}");
    }
    let indefinite = executed(&STUDY.replacen("[[2, 1], [-1, 0.5]]", "[[2, 1], [-1, -0.5]]", 1), Step::Design);
    let failure = indefinite.observers[0].failure.as_ref().unwrap();
    assert!(failure.hypothesis.contains("S + S'"), "{failure:?}");
    let discrete = STUDY.replacen("c = [[1, 0, 0], [0, 1, 0]]\n", "c = [[1, 0, 0], [0, 1, 0]]\ndt = 0.1\n", 1);
    let found = executed(&discrete.replace("poles = [-2, -3, -4]", "poles = [0.5, 0.6, 0.7]"), Step::Design);
    let failure = found.observers[0].failure.as_ref().unwrap();
    assert!(failure.hypothesis.contains("`jitter` and `misses` are for plants in continuous time"), "{failure:?}");
    assert!(found.observers[1].failure.is_none(), "{:?}", found.observers[1].failure);
}

#[test]
fn exports_keep_the_proof_of_the_designed_gains() {
    use luenberger_proof::statement::Format as Numbers;
    // The last one at its period alone.
    let study = read(&STUDY.replace("period = 0.1\nmisses = 1\n", "period = 0.1\n")).unwrap();
    for (observer, name) in study.observers.iter().zip(["varying", "semi-implicit", "deployed"]) {
        let design = luenberger_study::deployment::sampled(&study, observer, None, None).unwrap();
        let found = luenberger_study::deployment::evidence(&study, observer, &design.design, Numbers::Binary32.into());
        let file = found.file.unwrap();
        verify(file.to_json().as_bytes()).unwrap();
        let open = found.sentences.iter().any(|words| words.contains("not covered"));
        match file.theorem() {
            Theorem::VaryingPeriodConvergence(_) => assert!(name == "varying" && open, "{:?}", found.sentences),
            Theorem::SemiImplicitCubicConvergence(_) => {
                assert!(name == "semi-implicit" && open, "{:?}", found.sentences);
            }
            Theorem::DeployedObserver(_) => assert_eq!(name, "deployed"),
            other => panic!("{}: {}", observer.name, other.name()),
        }
    }
}
