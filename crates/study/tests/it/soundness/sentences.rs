//! Sentences claim no more than their theorems: regions, inputs, rounding.

use luenberger_proof::certificate::{Certificate, CertificateFile, Region, Theorem};
use luenberger_proof::statement::{Format, Formats};
use luenberger_study::deployment::{Evidence, evidence, sampled};
use luenberger_study::{Step, Study};

use crate::studies::{executed, read, study};

/// What is proved of the first observer on its target.
fn on_target(study: &Study, period: f64, formats: Formats) -> Evidence {
    let observer = &study.observers[0];
    let found = sampled(study, observer, Some(period), None).unwrap_or_else(|why| panic!("{why:?}"));
    evidence(study, observer, &found.design, formats)
}

/// What is said of an observer.
fn statement(text: &str, observer: &str) -> String {
    let results = executed(text, Step::Design);
    let row = results.observers.iter().find(|row| row.name == observer).unwrap();
    let design = row.design.as_ref().unwrap_or_else(|| panic!("{:?}", row.failure));
    assert_eq!(design.verdict.word(), "proved", "{design:?}");
    design.statement.to_string()
}

/// The numbers behind the names in `measurement noise (x1 0.1 m, x2 3)`.
fn listed(sentences: &str, what: &str) -> Vec<f64> {
    let list = sentences.split_once(&format!("{what} (")).unwrap_or_else(|| panic!("{sentences}")).1;
    let list = list.split_once(')').unwrap().0;
    list.split(", ").map(|entry| entry.split(' ').nth(1).unwrap().parse().unwrap()).collect()
}

const BOUNDS: &str = "
[plant]
a = [[-2]]
b = [[1]]
c = [[1]]
[input]
expressions = [\"sin(t)\"]
[simulation]
x0 = [1]
duration = 5
samples = 51
hold = 0.01
noise = { distribution = \"uniform\", amplitude = [0.01], period = 0.01, seed = 1 }
[[observer]]
name = \"lin\"
kind = \"luenberger\"
poles = [-1]
";

/// Whoever keeps the printed bounds keeps those of the certificate.
#[test]
fn bounds_of_operation_are_rounded_inwards() {
    let found = on_target(&study(BOUNDS), 0.01, Format::Binary32.into());
    let Some(Theorem::DeployedObserver(theorem)) = found.file.as_ref().map(CertificateFile::theorem) else {
        panic!("{found:?}")
    };
    let sentences = found.sentences.join(" ");
    let operation = &theorem.operation;
    for (what, certified) in [
        ("states", &operation.state),
        ("inputs", &operation.input),
        ("measurement noise", &operation.noise),
        ("first error", &operation.error),
    ] {
        let printed = listed(&sentences, what);
        assert_eq!(printed.len(), certified.len());
        for (printed, certified) in printed.iter().zip(certified) {
            assert!(
                printed <= certified && *printed >= (1.0 - 1e-15) * certified,
                "{what}: {printed}, certified {certified}"
            );
        }
    }
    assert_eq!(listed(&sentences, "measurement noise"), [0.012]);
}

/// A = [0 1; -4 0] sampled has entries that Q6.10 rounds: a plant that is not the stored one forces the error. In
/// binary64 the stored plant is the sampled one.
#[test]
fn stored_numbers_are_proved_of_the_stored_plant() {
    let text = "
[plant]
a = [[0, 1], [-4, 0]]
b = [[0], [1]]
c = [[1, 0]]
[simulation]
x0 = [1, 0]
duration = 2
samples = 21
hold = 0.05
[[observer]]
name = \"lin\"
kind = \"luenberger\"
poles = [-1, -2]
";
    let study = study(text);
    let said = |format: Format| on_target(&study, 0.05, format.into()).sentences[0].clone();
    let coarse = said(Format::Fixed { integer_bits: 6, fraction_bits: 10 });
    assert!(coarse.contains("of a plant x+ = A x + B u, y = C x with the stored A, B and C"), "{coarse}");
    assert!(coarse.contains("Q6.10 rounds those of the sampled plant: its own error need not tend to 0"), "{coarse}");
    let fine = said(Format::Binary64);
    assert!(fine.contains("They are those of the sampled plant"), "{fine}");
}

const PENDULUM: &str = "
[plant]
f = [\"x2\", \"-sin(x1) - 0.3*x2 + u1\"]
h = [\"x1\"]
[operating_point]
x = [0, 0]
u = [0]
[input]
expressions = [\"0.3*sin(t)\"]
[simulation]
x0 = [0, 0]
duration = 1
hold = 0.01
[[observer]]
name = \"at\"
kind = \"luenberger\"
poles = [-2, -3]
";

/// The input keeps the remainder of the linearisation from 0, and the error with it, however small the first one is.
#[test]
fn a_certificate_of_a_linearisation_is_not_of_the_plant() {
    let said = statement(PENDULUM, "at");
    assert!(said.contains("For the linear system x' = A x + B u, y = C x"), "{said}");
    assert!(said.ends_with("nothing is proved of the nonlinear plant."), "{said}");
    assert!(!said.contains("small errors"), "{said}");
    let deployed = on_target(&study(PENDULUM), 0.01, Format::Binary32.into()).sentences.join(" ");
    assert!(deployed.contains("For the linear system x+ = A x + B u, y = C x"), "{deployed}");
    assert!(deployed.contains("Nothing is proved of the nonlinear plant."), "{deployed}");
}

/// Two equal outputs: the stored N is proved in an ellipsoid only.
const CUBIC: &str = "
[plant]
a = [[0, 1], [0, 0]]
b = [[0], [1]]
c = [[1, 0], [1, 0]]
[input]
feedback = { k = [[1, 2]], observer = \"cubic\" }
[[observer]]
name = \"cubic\"
kind = \"cubic\"
poles = [-1, -2]
theta = [[1e8, 0], [0, 1e8]]
gamma = 1e6
[[observer]]
name = \"pi\"
kind = \"proportional-integral\"
e = [[0], [1]]
poles = [-1, -2, -3]
theta = [[1e8, 0], [0, 1e8]]
gamma = 1e6
";

/// The level behind `e'Pe < `.
fn levels(said: &str) -> Vec<f64> {
    let number = |rest: &str| {
        let end = rest.find([',', ' ']).unwrap_or(rest.len());
        rest[..end].parse().unwrap_or_else(|_| panic!("{rest}"))
    };
    said.split("e'Pe < ").skip(1).map(number).collect()
}

/// The smallest level of a theorem.
fn certified_level(certificate: &Certificate) -> f64 {
    let levels = certificate.theorems().iter().filter_map(|theorem| match theorem.theorem() {
        Theorem::CubicConvergence(observer) => Some(observer.region),
        Theorem::FeedbackLoop(theorem) => Some(theorem.observer.region),
        _ => None,
    });
    levels.fold(f64::INFINITY, |least, region| match region {
        Region::Within(level) => least.min(level),
        Region::Everywhere => least,
    })
}

#[test]
fn a_region_of_first_errors_is_in_every_sentence() {
    let study = study(CUBIC);
    for observer in &study.observers {
        let name = &observer.name;
        let cancel = std::sync::atomic::AtomicBool::new(false);
        let designed = luenberger_study::design::design(&study, observer, &cancel).unwrap();
        let certified = certified_level(designed.certificate.as_ref().unwrap());
        assert!(certified.is_finite(), "{name}");
        let said = statement(CUBIC, name);
        let found = levels(&said);
        // One of the observer, and one of the loop.
        assert_eq!(found.len(), if name == "cubic" { 2 } else { 1 }, "{said}");
        for level in found {
            assert!(level <= certified && level >= 0.99 * certified, "{level}, certified {certified}: {said}");
        }
        assert!(!said.contains("from every x(0) and xhat(0)") && !said.contains("for all x(0)"), "{said}");
    }
}

/// With a weight of ordinary size the stored gain is proved for all errors, and the sentences say so.
#[test]
fn without_a_region_the_sentences_are_of_all_errors() {
    let text = CUBIC
        .replace("c = [[1, 0], [1, 0]]", "c = [[1, 0]]")
        .replace("[[1e8, 0], [0, 1e8]]", "[[10]]")
        .replace("gamma = 1e6", "gamma = 2");
    assert!(statement(&text, "cubic").contains("x and xhat tend to 0 exponentially, from every x(0) and xhat(0)"));
    assert!(statement(&text, "pi").contains("for all x(0), xhat(0) and d."));
}

/// What the poles promise is computed, and what V does at varying periods is rounded upwards.
#[test]
fn computed_rates_are_called_computed() {
    let text = BOUNDS.replace("poles = [-1]", "poles = [-0.333333333333333]");
    let said = statement(&text, "lin");
    assert!(said.contains("the error tends to 0. Computed: asymptotic rate exp(-0.33333 t)."), "{said}");
}

#[test]
fn the_factor_of_varying_periods_is_that_of_the_certificate() {
    let text = "
[plant]
a = [[0, 1], [0, 0]]
b = [[0], [1]]
c = [[1, 0]]
[[observer]]
name = \"jitter\"
kind = \"sampled-cubic\"
poles = [-2, -5]
theta = [[10]]
gamma = 1
period = 0.02
jitter = [0.018, 0.022]
";
    let study = study(text);
    let cancel = std::sync::atomic::AtomicBool::new(false);
    let designed = luenberger_study::design::design(&study, &study.observers[0], &cancel).unwrap();
    let certificate = designed.certificate.as_ref().unwrap();
    let factor = certificate.theorems().iter().find_map(|theorem| match theorem.theorem() {
        Theorem::VaryingPeriodConvergence(theorem) => Some(theorem.factor),
        _ => None,
    });
    let said = &designed.report.statement;
    assert!(said.contains("periods from 0.018 to 0.022"), "{said}");
    let printed = said.split_once("V = e'Pe is at most ").unwrap().1.split_once(' ').unwrap().0;
    let (printed, factor) = (printed.parse::<f64>().unwrap(), factor.unwrap());
    assert!(printed >= factor * factor && printed < 1.001 * factor * factor, "{printed}, factor {factor}");
}

/// A name must be seen as it is.
#[test]
fn names_have_no_invisible_characters() {
    for hidden in ['\u{2028}', '\u{202e}', '\u{200b}', '\u{a0}', '\u{ad}', '\u{3164}', '\u{feff}'] {
        let found =
            read(&BOUNDS.replace("name = \"lin\"", &format!("name = \"li{hidden}n\""))).unwrap_err().to_string();
        let wanted = format!("`name` has the invisible character U+{:04X}", u32::from(hidden));
        assert!(found.contains(&wanted), "{found}");
    }
}

/// binary32 rounds the entry of C: it is not beyond its range.
#[test]
fn refusals_of_interval_observers_are_true() {
    let text = "
[plant]
a = [[-1]]
c = [[-0.482]]
[simulation]
x0 = [1]
duration = 1
hold = 0.1
[[observer]]
name = \"box\"
kind = \"interval\"
poles = [-2]
initial_bounds = [1]
bounds = { noise = [0.1] }
";
    let study = study(text);
    let observer = &study.observers[0];
    let found = sampled(&study, observer, Some(0.1), None).unwrap();
    let said = evidence(&study, observer, &found.design, Format::Binary32.into()).sentences.join(" ");
    assert!(said.contains("an entry of C, -0.482, is no number of binary32, which would round it"), "{said}");
    let exported = luenberger_study::deployment::exported(
        &study,
        observer,
        found.design,
        luenberger_export::Scalar::Binary32,
        None,
    );
    let why = exported.err().map(|why| why.to_string()).unwrap_or_default();
    assert!(why.contains("is no number of binary32") && !why.contains("beyond the range"), "{why}");
}
