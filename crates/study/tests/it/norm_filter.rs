//! H-infinity and H2 filters in studies.

use luenberger_proof::certificate::Theorem;
use luenberger_study::deployment::{SampledDesign, sampled};

use crate::studies::{designed, read};

/// `x' = -x + w1`, `y = x + w2`: the least norms are sqrt(1/2), and sqrt(sqrt(2) - 1) by the Riccati equation.
fn scalar(kind: &str, rest: &str) -> String {
    format!("[plant]\na = [[-1]]\nc = [[1]]\n[[observer]]\nname = \"o\"\nkind = \"{kind}\"\ne = [[1, 0]]\n{rest}\n")
}

#[test]
fn the_norms_of_a_scalar_plant_are_those_by_hand() {
    let least = |kind: &str, name: &str, label: &str, expected: f64| {
        let found = designed(&read(&scalar(kind, "d = [[0, 1]]")).unwrap()).unwrap();
        assert_eq!(found.report.verdict.word(), "proved");
        let number = |name: &str| found.report.number(name).unwrap();
        assert!((number(label) - expected).abs() < 1e-5, "{:?}", found.report.numbers);
        assert!(number("gamma") < 1.011 * expected && number(&format!("{name} norm")) < number("gamma"));
        found
    };
    let found = least("h-infinity", "H-infinity", "least H-infinity norm found", 0.5f64.sqrt());
    let certificate = found.certificate.unwrap();
    assert!(matches!(certificate.theorems()[0].theorem(), Theorem::HInfinityFilter(_)));
    assert!(found.report.statement.contains("at most gamma^2 times that of |w|^2"), "{}", found.report.statement);
    let found = least("h2", "H2", "least H2 norm", (2f64.sqrt() - 1.0).sqrt());
    assert!(matches!(found.certificate.unwrap().theorems()[0].theorem(), Theorem::H2Filter(_)));
    // Only the error of a combination counts, with a unit of its own.
    let found = designed(&read(&scalar("h2", "d = [[0, 1]]\nh = [[10]]")).unwrap()).unwrap();
    let expected = 10.0 * (2f64.sqrt() - 1.0).sqrt();
    assert!((found.report.number("H2 norm").unwrap() - expected).abs() < 1e-4);
    // L = 2: sqrt(1 + 4)/3.
    let found = designed(&read(&scalar("h-infinity", "d = [[0, 1]]\ngain = [[2]]")).unwrap()).unwrap();
    assert!((found.report.number("H-infinity norm").unwrap() - 5f64.sqrt() / 3.0).abs() < 1e-9);
}

/// The Kalman filter with G and a cross-covariance: the numbers of `design`'s `kalman_noise` tests, by scipy; without
/// `gamma` the H2 filter of the same noises has the same gain.
#[test]
fn noises_that_are_correlated_are_those_of_the_h2_filter() {
    let of = |plant: &str, observer: &str| {
        format!("[plant]\n{plant}\nc = [[1, 0]]\n[[observer]]\nname = \"o\"\n{observer}\n")
    };
    let kalman = "kind = \"kalman\"\nw = 2\nv = 0.1\ng = [[0], [1]]\ns = [[0.3]]";
    let continuous = "a = [[0, 1], [-2, -3]]";
    let gain = |text: &str| {
        let found = designed(&read(text).unwrap()).unwrap();
        assert_eq!(found.report.verdict.word(), "proved");
        found.report.matrices[0].rows.concat()
    };
    let near = |found: Vec<f64>, expected: [f64; 2], digits: f64| {
        assert!(found.iter().zip(expected).all(|(x, y)| (x - y).abs() < digits), "{found:?}");
    };
    let expected = [0.316_624_790_355_399_25, 3.050_125_628_933_802];
    near(gain(&of(continuous, kalman)), expected, 1e-12);
    let table = "kind = \"luenberger\"\nkalman = { w = 2, v = 0.1, g = [[0], [1]], s = [[0.3]] }";
    near(gain(&of(continuous, table)), expected, 1e-12);
    // [e; d] with e e' = 2, e d' = .3, d d' = .1: a square root of the joint intensity.
    let root = 2f64.sqrt();
    let (d1, d2) = (0.3 / root, (0.1f64 - 0.045).sqrt());
    let h2 = format!("kind = \"h2\"\ne = [[0, 0], [{root}, 0]]\nd = [[{d1}, {d2}]]");
    near(gain(&of(continuous, &h2)), expected, 1e-9);
    let discrete = "dt = 1\na = [[0.9, 0.1], [0, 0.8]]";
    near(gain(&of(discrete, kalman)), [0.471_164_250_717_785_9, 2.317_363_298_553_732], 1e-12);
    let study = read(&of(continuous, kalman)).unwrap();
    let step = sampled(&study, &study.observers[0], Some(0.1), None).unwrap();
    let SampledDesign::Linear(step) = step.design else { panic!() };
    near(step.l().as_slice().to_vec(), [0.045_991_425_873_162_84, 0.247_944_045_487_201_17], 1e-12);
    let filter = designed(&read(&of(discrete, &format!("{kalman}\nform = \"filter\""))).unwrap()).unwrap();
    let update = &filter.report.matrices[1];
    assert_eq!(update.name, "K (gain of the measurement update)");
    near(update.rows.concat(), [0.436_465_755_606_720_96, 0.783_450_706_717_369], 1e-12);
    for (wrong, message) in [
        ("kind = \"kalman\"\nw = [1, 1]\nv = 1\ng = [[0], [1]]", "the diagonal `w` has length 2"),
        ("kind = \"kalman\"\nw = 1\nv = 1\ng = [[1]]", "`g`"),
        ("kind = \"kalman\"\nw = 1\nv = 1\ns = [[1]]", "`s`"),
    ] {
        let error = read(&of(continuous, wrong)).unwrap_err().to_string();
        assert!(error.contains(message), "{error}");
    }
}

#[test]
fn a_plant_in_discrete_time_has_its_own_filter() {
    // x+ = x/2 + w1, y = x + w2: the prediction error has P^2 - P/4 - 1 = 0 at the optimum, P = (1 + sqrt(65))/8.
    let text = "[plant]\na = [[0.5]]\nc = [[1]]\ndt = 0.1\n[[observer]]\nkind = \"h2\"\ne = [[1, 0]]\nd = [[0, 1]]\n";
    let study = read(text).unwrap();
    let found = designed(&study).unwrap();
    let variance = (1.0 + 65f64.sqrt()) / 8.0;
    assert!((found.report.number("H2 norm").unwrap() - variance.sqrt()).abs() < 1e-5, "{:?}", found.report.numbers);
    assert_eq!(found.report.verdict.word(), "proved");
    let step = sampled(&study, &study.observers[0], None, None).unwrap();
    let SampledDesign::Linear(step) = step.design else { panic!() };
    assert_eq!(step.l(), &nalgebra::DMatrix::from_element(1, 1, found.report.matrices[0].rows[0][0]));
}

#[test]
fn the_exported_filter_is_that_of_the_sampled_plant() {
    for (kind, rest) in [("h2", ""), ("h-infinity", "gamma = 0.9")] {
        let study = read(&scalar(kind, &format!("d = [[0, 1]]\n{rest}"))).unwrap();
        let continuous = designed(&study).unwrap();
        let period = 1e-4;
        let step = sampled(&study, &study.observers[0], Some(period), None).unwrap();
        let SampledDesign::Linear(step) = step.design else { panic!() };
        // A small step of the observer in continuous time: L_d/h tends to L.
        let l = continuous.report.matrices[0].rows[0][0];
        let found = step.l()[(0, 0)] / period;
        // Many gains keep a norm below gamma; that of the least H2 norm is one.
        if kind == "h2" {
            assert!((found / l - 1.0).abs() < 1e-2, "{found} and {l}");
        }
        assert!(step.certificate.is_proved());
    }
}

#[test]
fn what_fails_is_named() {
    let why = |kind: &str, rest: &str| match designed(&read(&scalar(kind, rest)).unwrap()) {
        Err(failure) => (failure.hypothesis.clone(), failure.advice().join("; ")),
        other => panic!("{other:?}"),
    };
    let (why_not, instead) = why("h-infinity", "d = [[0, 1]]\ngamma = 0.5");
    assert!(why_not.starts_with("no gain makes the H-infinity norm of the error less than 0.5 (the best"), "{why_not}");
    assert!(why_not.contains("no values satisfy"), "{why_not}");
    assert!(instead.contains("gamma = 0.7142 in place of gamma"), "{instead}");
    let (why_not, instead) = why("h2", "d = [[0, 0]]");
    assert!(why_not.contains("D does not have full row rank"), "{why_not}");
    assert!(instead.contains("max_gain"), "{instead}");
    assert!(designed(&read(&scalar("h2", "d = [[0, 0]]\nmax_gain = 5")).unwrap()).is_ok());
    let (why_not, _) = why("h2", "d = [[0, 1]]\ngain = [[-2]]");
    assert!(why_not.contains("A - L C is not Hurwitz"), "{why_not}");
    let wrong = |kind: &str, rest: &str| read(&scalar(kind, rest)).unwrap_err().to_string();
    assert!(wrong("h2", "d = [[0, 1, 0]]").contains("expected 1 x 2"), "{}", wrong("h2", "d = [[0, 1, 0]]"));
    assert!(wrong("h2", "").contains("`d`"), "{}", wrong("h2", ""));
    assert!(wrong("h2", "d = [[0, 1]]\nh = [[1, 0]]").contains("`h` is 1 x 2"));
    assert!(wrong("h2", "d = [[0, 1]]\ngamma = 1\ngain = [[1]]").contains("conflicts"));
    assert!(wrong("h2", "d = [[0, 1]]\ngain = [[1]]\nmax_gain = 2").contains("conflicts"));
    assert!(wrong("h2", "d = [[0, 1]]\ngamma = 0").contains("gamma"));
}
