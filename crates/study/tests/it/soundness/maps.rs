//! Observers with maps of a study: KKL, and immersion and invariance.

use std::path::Path;
use std::sync::atomic::AtomicBool;

use luenberger_proof::certificate::Theorem;
use luenberger_proof::statement::Format as Number;
use luenberger_study::Study;
use luenberger_study::deployment::{evidence, sampled};
use luenberger_study::design::{Designed, design};
use proptest::prelude::*;

use crate::studies::{designed, read, study};

#[track_caller]
fn design_of(text: &str) -> Designed {
    designed(&study(text)).unwrap_or_else(|why| panic!("{why:?}"))
}

/// Whether a study has a design whose verdict is `proved`.
fn is_proved(text: &str) -> bool {
    designed(&study(text)).is_ok_and(|found| found.report.verdict.word() == "proved")
}

/// `x1' = -x1 + x2, x2' = F` with the distance `z = x2`, and what replaces the lines of the observer.
fn immersion(f: &str, beta: &str, phi: &str, left_inverse: &str) -> String {
    format!(
        r#"[plant]
f = ["-x1 + x2", "{f}"]
h = ["x1"]
inputs = ["u1"]
[[observer]]
kind = "immersion-invariance"
beta = ["{beta}"]
phi = ["{phi}"]
left_inverse = ["y1", "{left_inverse}"]
start = ["x2 - x1"]
region = {{ states = [[-3, 3], [-1, 1]], inputs = [[-1, 1]] }}
"#
    )
}

/// K jumps down by 0.5 at z = 0.3 for `x2' = -x2 + u + 0.5 step(x2 - 0.3)`: for u = 0.29 the plant rests at 0.29 and
/// the observer at 0.79, although every derivative of K is -2.
#[test]
fn a_jump_of_the_plant_is_no_contraction() {
    for jump in ["if(x2 > 0.3, 0.5, 0)", "0.5*step(x2 - 0.3)", "1e-9*step(x2 - 0.3)", "0.25*sign(x2 - 0.3)"] {
        let report = design_of(&immersion(&format!("-x2 + u1 + {jump}"), "chi1 + y1", "x2", "z1")).report;
        assert_eq!(report.verdict.word(), "measured", "{jump}: {report:?}");
        let evidence = report.evidence.unwrap();
        assert!(evidence.contains("(A5) is not proved") && evidence.contains("z1 = 0.3"), "{evidence}");
        assert!(!report.statement.contains("tends to 0"), "{}", report.statement);
    }
    // Continuous, with the derivatives of both sides: -2 and -3 in K.
    assert!(is_proved(&immersion("-2*x2 + max(x2, 0) + u1", "chi1 + y1", "x2", "z1")));
    assert!(is_proved(&immersion("-x2 - abs(x2 - 0.3)/2 + u1", "chi1 + y1", "x2", "z1")));
    assert!(!is_proved(&immersion("-x2 + 3*abs(x2 - 0.3) + u1", "chi1 + y1", "x2", "z1")));
}

#[test]
fn a_jump_of_a_map_is_no_manifold() {
    let f = "-x2 + u1";
    for (beta, phi, left_inverse) in [
        ("chi1 + y1 + if(y1 > 0.5, 0.1, 0)", "x2", "z1"),
        ("chi1 + y1 + floor(y1)", "x2", "z1"),
        ("chi1 + y1", "x2 + if(x1 > 0.5, 0.1, 0)", "z1 - if(y1 > 0.5, 0.1, 0)"),
        ("chi1 + y1", "x2", "z1 + if(abs(y1 - 0.987) < 0.001, 3, 0)"),
        // D_chi beta is 0 between the samples, and one branch of it is a pivot.
        ("if(abs(y1 - 1) < 0.01, 0, chi1) + y1", "x2", "z1"),
    ] {
        let text = immersion(f, beta, phi, left_inverse);
        // Not every function has a symbolic derivative.
        let Ok(study) = read(&text) else { continue };
        let Ok(found) = designed(&study) else { continue };
        assert_eq!(found.report.verdict.word(), "measured", "{text}\n{:?}", found.report);
    }
    let rank = design_of(&immersion(f, "if(abs(y1 - 1) < 0.01, 0, chi1) + y1", "x2", "z1")).report;
    assert!(rank.facts.iter().all(|fact| !fact.statement.contains("(A4)")), "{:?}", rank.facts);
    assert!(is_proved(&immersion(f, "chi1 + y1 + sat(y1, -1, 1)", "x2", "z1")));
}

/// With `y = x1 + sin(t)/2` the observer of `y = x1` has no term for y' = x2 + cos(t)/2.
#[test]
fn an_output_that_reads_the_time_is_not_covered() {
    let text = immersion("-x2 + u1", "chi1 + y1", "x2", "z1").replace("[\"x1\"]", "[\"x1 + 0.5*sin(t)\"]");
    assert!(!is_proved(&text));
    let kkl = SPIKE.replace("h = [\"x1\"]", "h = [\"x1 + 0.5*sin(t)\"]").replace(" + SPIKE", "");
    assert!(!is_proved(&kkl));
}

/// xhat = sat(beta) stays in [-1, 1] whatever beta is: from beta = 20 it rests at 1 for 9.5 time units. The enclosure
/// is that of beta in [-1, 1].
#[test]
fn the_region_of_an_immersion_is_that_of_beta() {
    let report = design_of(
        r#"[plant]
f = ["x2", "0"]
h = ["x1"]
[[observer]]
kind = "immersion-invariance"
beta = ["chi1 + 2*y1"]
phi = ["x2"]
left_inverse = ["y1", "sat(z1, -1, 1)"]
region = { states = [[-30, 30], [-1, 1]] }
start = ["x2 - 2*x1 + 20"]
"#,
    )
    .report;
    assert_eq!(report.verdict.word(), "proved", "{report:?}");
    assert!(report.statement.contains("beta(y(t), chi(t)) in the box of phi over it (beta1 in [-1, 1])"));
    assert!(!report.statement.contains("xhat(t)"), "{}", report.statement);
    // A region beyond the saturation: phi^L does not take phi(x) back there, which 261 points see as well.
    let wide = immersion("-x2 + u1", "chi1 + y1", "x2", "sat(z1, -0.9, 0.9)");
    assert!(!is_proved(&wide));
}

/// `x2' = -x1` and `phi = x2 - 2 x1`: phi' = -x1 - 2 x2 = -2 phi - 5 x1.
const SPIKE: &str = r#"[plant]
f = ["x2", "-x1"]
h = ["x1"]
[[observer]]
name = "o"
kind = "kkl"
phi = ["x2 - 2*x1"]
lambda = [-2]
b = ["-5*y1"]
left_inverse = ["y1", "xi1 + 2*y1 + SPIKE"]
region = { states = [[-3, 3], [-4, 4]] }
initial = [2, -1]
"#;

/// 261 points do not meet a spike of width 0.004.
#[test]
fn a_spike_of_a_left_inverse_is_not_covered_by_samples() {
    let spike = SPIKE.replace("SPIKE", "if(abs(y1 - 1.2345) < 0.002, 3, 0)");
    let van_der_pol = r#"[plant]
f = ["x2", "(1 - x1^2)*x2 - x1"]
h = ["x1"]
[[observer]]
kind = "kkl"
phi = ["x2 - (x1 - x1^3/3) - 2*x1"]
lambda = [-2]
b = ["-5*y1 - 2*(y1 - y1^3/3)"]
left_inverse = ["y1", "xi1 + (y1 - y1^3/3) + 2*y1 + if(abs(y1 - 1.2345) < 0.002, 3, 0)"]
region = { states = [[-3, 3], [-4, 4]] }
initial = [2, -1]
"#;
    for text in [spike.as_str(), van_der_pol] {
        let report = design_of(text).report;
        assert_eq!(report.verdict.word(), "measured", "{report:?}");
        assert!(report.evidence.unwrap().contains("is measured at 261 points"));
        assert!(!report.statement.contains("tends to 0"), "{}", report.statement);
    }
    // A certificate can contain the bell: its height is in the bound, with room of a twentieth.
    let bell = SPIKE.replace("SPIKE", "3*exp(-((y1 - 1.2345)/0.0005)^2)");
    let report = design_of(&bell).report;
    let limit = report.number("guaranteed limit of the error of x2").unwrap_or(f64::INFINITY);
    assert!(limit >= 3.0, "{report:?}");
    assert!(!report.statement.contains("tends to 0"), "{}", report.statement);
    assert!(report.facts.iter().all(|fact| fact.statement != "phi^L(phi(x), h(x)) = x"), "{:?}", report.facts);
}

#[test]
fn an_inexact_phi_has_a_bound_and_no_limit_of_zero() {
    let text = |phi: &str| {
        format!(
            r#"[plant]
f = ["x2 - 0.25*x1^3", "-x1 - x2 + sin(x1) + u1"]
h = ["x1"]
inputs = ["u1"]
[[observer]]
kind = "kkl"
phi = ["{phi}"]
lambda = [-2]
b = ["u1 - 3*y1 + 0.25*y1^3 + sin(y1)"]
left_inverse = ["y1", "xi1 + y1"]
region = {{ states = [[-2, 2], [-2, 2]], inputs = [[-1, 1]] }}
"#
        )
    };
    let exact = design_of(&text("x2 - x1")).report;
    assert!(exact.statement.ends_with("From every xi(0) the estimation error tends to 0."), "{}", exact.statement);
    let inexact = design_of(&text("x2 - x1 + 0.00000001*sin(5*x2)")).report;
    assert_eq!((exact.verdict.word(), inexact.verdict.word()), ("proved", "proved"));
    assert!(inexact.statement.contains("the estimation error is in the limit at most"), "{}", inexact.statement);
    assert!(!inexact.statement.contains("tends to 0") && !inexact.statement.contains("decays"));
}

/// The header of an export says of a design what its verdict says.
#[test]
fn an_export_copies_the_verdict() {
    let spike = study(&SPIKE.replace("SPIKE", "if(abs(y1 - 1.2345) < 0.002, 3, 0)"));
    let template = |name: &str| {
        let file = Path::new(env!("CARGO_MANIFEST_DIR")).join("templates").join(format!("{name}.toml"));
        Study::from_path(&file).unwrap()
    };
    let (cascade, converter) = (template("exponential-cascade"), template("cuk-observers"));
    for (study, name, verdict) in [
        (&spike, "o", "measured"),
        (&cascade, "KKL", "proved"),
        (&cascade, "KKL+PEB", "measured"),
        (&converter, "KKL", "proved"),
        (&converter, "I&I", "proved"),
        (&converter, "high-gain", "none"),
    ] {
        let observer = study.observer(name).unwrap();
        let designed = design(study, observer, &AtomicBool::new(false)).unwrap();
        assert_eq!(designed.report.verdict.word(), verdict, "{name}: {:?}", designed.report);
        let step = sampled(study, observer, Some(1e-3), Some(1)).unwrap();
        let found = evidence(study, observer, &step.design, Number::Binary64.into());
        let said = &found.sentences[0];
        assert_eq!(found.is_proved(), verdict == "proved", "{name}: {said}");
        assert!(
            match verdict {
                "proved" => said.starts_with("Proved (certificate.json), for the observer in continuous time: "),
                "measured" => said.starts_with("No stability certificate. Measured, not proved: "),
                _ => said.starts_with("No stability certificate"),
            },
            "{name}: {said}"
        );
    }
}

/// The theorem of the super-twisting observer says nothing of its samples, and what the design says of them is not
/// headed by it.
#[test]
fn the_proof_of_a_sliding_mode_observer_is_in_continuous_time() {
    let study = study(
        "[plant]\na = [[0, 1], [0, 0]]\nc = [[1, 0]]\n[[observer]]\nname = \"o\"\nkind = \"sliding-mode\"\nbound = 1\nperiod = 0.01\n",
    );
    let requested = study.observer("o").unwrap();
    let found = sampled(&study, requested, None, None).unwrap();
    let said = evidence(&study, requested, &found.design, Number::Binary64.into());
    assert!(said.is_proved());
    assert!(said.sentences[0].ends_with("Nothing is said of a sampled observer."), "{:?}", said.sentences);
    assert!(!said.sentences.iter().any(|sentence| sentence.contains("does not chatter")), "{:?}", said.sentences);
}

/// A function of one argument that is `height` at `centre`, and small or 0 beyond some widths.
fn spike(shape: u8, of: &str, (centre, width, height): (f64, f64, f64)) -> String {
    match shape % 4 {
        0 => format!("if(abs({of} - {centre}) < {width}, {height}, 0)"),
        1 => format!("{height}*(step({of} - {centre} + {width}) - step({of} - {centre} - {width}))"),
        2 => format!("{height}*exp(-(({of} - {centre})/{width})^2)"),
        _ => format!("{height}/(1 + (({of} - {centre})/{width})^2)"),
    }
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 12, ..ProptestConfig::default() })]

    /// No spike is proved away: where phi^L misses x by `height` at a state of the region, a proved bound of the error
    /// is not smaller; where phi or f has one that the rest of the observer does not have, neither is the bound of the
    /// residual.
    #[test]
    fn a_spike_is_in_every_proved_bound(
        shape in 0u8..4,
        centre in -2.0f64..2.0,
        width in (-6.0f64..0.0).prop_map(|exponent| 10f64.powf(exponent)),
        height in 0.01f64..5.0,
    ) {
        let of = |argument: &str| spike(shape, argument, (centre, width, height));
        let replaced = |from: &str, to: String| SPIKE.replace(" + SPIKE", "").replace(from, &to);
        let bounds = |text: &str| {
            let found = designed(&study(text)).ok().filter(|found| found.report.verdict.word() == "proved")?;
            let theorems = found.certificate.unwrap();
            let of_error = theorems.theorems().iter().find_map(|proved| match proved.theorem() {
                Theorem::KklErrorBound(bound) => Some(bound.claims.clone()),
                _ => None,
            });
            Some(of_error.unwrap())
        };
        let inverse = replaced("xi1 + 2*y1", format!("xi1 + 2*y1 + {}", of("y1")));
        if let Some(claims) = bounds(&inverse) {
            prop_assert!(claims.eventual[1] >= height, "{inverse}\n{claims:?}");
        }
        let inverse = replaced("xi1 + 2*y1", format!("xi1 + 2*y1 + {}", spike(shape % 2, "xi1", (centre, width, height))));
        prop_assert!(bounds(&inverse).is_none(), "{inverse}");
        // phi' = .. + s'(x1) x2 + 2 s(x1): the residual at x2 = 0 is twice the spike.
        let phi = replaced("[\"x2 - 2*x1\"]", format!("[\"x2 - 2*x1 + {}\"]", of("x1")));
        if let Some(claims) = bounds(&phi) {
            prop_assert!(claims.residual[0] >= height, "{phi}\n{claims:?}");
        }
        let f = replaced("\"-x1\"", format!("\"-x1 + {}\"", of("x1")));
        if let Some(claims) = bounds(&f) {
            prop_assert!(claims.residual[0] >= height, "{f}\n{claims:?}");
        }
        // I&I: the same in phi^L, and a jump of K in z, on which P cannot say anything. A smooth spike in f is a part
        // of K, with its slopes.
        let inside = format!("-x2 + u1 + {}", spike(shape % 2, "x2", (centre / 3.0, width, height)));
        for text in [
            immersion("-x2 + u1", "chi1 + y1", "x2", &format!("z1 + {}", of("y1"))),
            immersion("-x2 + u1", "chi1 + y1", &format!("x2 + {}", of("x1")), "z1"),
            immersion(&inside, "chi1 + y1", "x2", "z1"),
        ] {
            prop_assert!(!is_proved(&text), "{text}");
        }
    }
}
