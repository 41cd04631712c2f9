//! `error-state-kalman`: unit vectors of a study, the degrees of its consistency tests, and mistakes in the keys.

use std::fmt::Write as _;

use luenberger_study::{RunOptions, Step, execute, template};

use crate::studies::{executed, mistakes, scratch, study, study_in};

/// Cosine and sine of an angle that turns at a rate to be found, of which both are measured.
fn turning(kind: &str, more: &str) -> String {
    format!(
        "[plant]\nstates = [\"c\", \"s\", \"rate\"]\nf = [\"-rate*s\", \"rate*c\", \"0\"]\nh = [\"c\", \"s\"]\n\
         [simulation]\nx0 = [1, 0, 0.5]\nduration = 40\n\
         noise = {{ distribution = \"gaussian\", amplitude = [0.02, 0.02], period = 0.1, seed = 2 }}\n\
         [[observer]]\nname = \"filter\"\nkind = \"{kind}\"\nw = [1e-8, 1e-8, 1e-8]\nv = 4e-4\np0 = [0.04, 0.04, 0.01]\n\
         period = 0.1\ninitial = [0.98, 0.2, 0.4]\n{more}"
    )
}

const UNIT: &str = "unit_vectors = [[\"c\", \"s\"]]\n";

/// A quaternion and three biases have six degrees of freedom, and an error across the quaternion is measured by them:
/// no error is without a variance.
#[test]
fn the_consistency_tests_have_the_degrees_of_the_attitude() {
    let template = template::template("attitude").unwrap();
    let results = execute(&study(template.text), Step::Simulate, &RunOptions::default()).unwrap();
    let of = |name: &str| results.filters.iter().find(|filter| filter.observer == name).unwrap();
    let nees = of("error state").nees.as_ref().unwrap();
    assert_eq!((nees.expected, nees.singular, nees.outside), (6.0, 400, 0));
    assert!((nees.region[0]..nees.region[1]).contains(&nees.mean), "{nees:?}");
    assert_eq!(of("extended").nees.as_ref().unwrap().expected, 7.0);
}

/// On a log with the true states, as in the simulation.
#[test]
fn a_log_has_the_same_degrees() {
    let folder = scratch("error-state-log");
    let text = turning("error-state-kalman", UNIT);
    let results = executed(&text, Step::Simulate);
    assert_eq!(results.filters[0].nees.as_ref().unwrap().expected, 2.0);
    let mut log = "t,c,s,true_c,true_s,true_rate\n".to_owned();
    for k in 0..200 {
        let t = 0.1 * f64::from(k);
        let (s, c) = (0.5 * t).sin_cos();
        let noise = 0.02 * (f64::from(k) * 12.9898).sin();
        writeln!(log, "{t},{},{},{c},{s},0.5", c + noise, s - noise).unwrap();
    }
    std::fs::write(folder.join("log.csv"), log).unwrap();
    let (plant, rest) = text.split_once("[simulation]").unwrap();
    let (_, observer) = rest.split_once("[[observer]]").unwrap();
    let truth = "[\"true_c\", \"true_s\", \"true_rate\"]";
    let log =
        format!("{plant}[log]\nfile = \"log.csv\"\noutputs = [\"c\", \"s\"]\nstates = {truth}\n[[observer]]{observer}");
    let results = execute(&study_in(&folder, &log), Step::Simulate, &RunOptions::default()).unwrap();
    let nees = results.log.as_ref().unwrap().rows[0].nees.as_ref().unwrap();
    assert_eq!((nees.expected, nees.outside), (2.0, 0));
    assert!(nees.singular > 0);
}

/// A parameter that is estimated belongs to no unit vector.
#[test]
fn parameters_are_estimated_beside_unit_vectors() {
    let text = "[plant]\nstates = [\"c\", \"s\"]\nf = [\"-rate*s\", \"rate*c\"]\nh = [\"c\", \"s\"]\nparameters = { rate = 0.4 }\n\
                [estimate]\nparameters = [\"rate\"]\np0 = [0.01]\n\
                [simulation]\nx0 = [1, 0]\nduration = 40\n\
                noise = { distribution = \"gaussian\", amplitude = [0.02, 0.02], period = 0.1, seed = 2 }\n\
                [truth]\nparameters = { rate = 0.5 }\n\
                [[observer]]\nkind = \"error-state-kalman\"\nunit_vectors = [[\"c\", \"s\"]]\nw = 1e-8\nv = 4e-4\np0 = 0.04\n\
                period = 0.1\ninitial = [0.98, 0.2]\n";
    let results = executed(text, Step::Simulate);
    assert_eq!(results.failures(), Vec::<String>::new());
    let found = &results.simulation.as_ref().unwrap().rows[0].merits.as_ref().unwrap().states;
    assert!(found.iter().all(|state| state.last.abs() < 0.02), "{found:?}");
}

#[test]
fn mistakes_of_the_keys() {
    for (more, expected) in [
        ("", "has no `unit_vectors`"),
        ("unit_vectors = [\"c\", \"s\"]\n", "list 1 of `unit_vectors` is the text \"c\""),
        ("unit_vectors = [[\"c\"]]\n", "list 1 of `unit_vectors` is"),
        ("unit_vectors = [[\"c\", 1]]\n", "entry 2 of list 1 of `unit_vectors` is 1"),
        ("unit_vectors = []\n", "`unit_vectors` is"),
        ("unit_vectors = [[\"c\", \"x\"]]\n", "there is no state \"x\""),
        ("unit_vectors = [[\"c\", \"s\"], [\"s\", \"rate\"]]\n", "s is in a unit vector already"),
        (
            "unit_vectors = [[\"c\", \"s\"]]\nstate_bounds = [[-1, 1], [-inf, inf], [0, 1]]\n",
            "`state_bounds` bounds c, an entry of a unit vector",
        ),
    ] {
        let found = mistakes(&turning("error-state-kalman", more));
        let found = found.iter().fold(String::new(), |all, one| all + &one.message + "\n");
        assert!(found.contains(expected), "{more}\n{found}");
    }
    for start in ["", "initial = [0, 0, 0.4]\n"] {
        let text = turning("error-state-kalman", UNIT).replace("initial = [0.98, 0.2, 0.4]\n", start);
        assert_eq!(mistakes(&text)[0].message, "the first estimate of unit vector 1 is 0");
    }
    let found = mistakes(&turning("extended-kalman", UNIT));
    assert!(found[0].message.contains("unit_vectors"), "{found:?}");
}
