//! A sample of the studies of `cargo xtask stress words`, and lies that have to be found.

use luenberger_study::study::ObserverSpec;
use luenberger_tests::words::said::Said;
use luenberger_tests::words::sentences::Claim;
use luenberger_tests::words::{Class, Extent, falsify, generated, hold, hold_with, kinds};

/// Random studies of every kind: no sentence is contradicted, and none is without a check.
#[test]
fn no_sentence_is_false() {
    assert_eq!(generated(), kinds(), "each kind has a generator in words/generate.rs");
    for kind in generated() {
        // A table of a numerical KKL observer takes seconds, as does a search of the optimal cubic observer.
        let studies = if matches!(kind, "kkl-numerical" | "optimal-cubic") { 0 } else { 4 };
        let tally = falsify(kind, studies, 2019, Extent::All);
        let wrong: Vec<String> = tally.findings.iter().map(ToString::to_string).collect();
        assert!(wrong.is_empty(), "{}", wrong.join("\n\n"));
    }
}

const OSCILLATOR: &str = "[plant]\na = [[0, 1], [-4, -0.5]]\nb = [[0], [1]]\nc = [[1, 0]]\n";

/// Changes a statement.
fn says(from: &'static str, to: &'static str) -> impl Fn(&ObserverSpec, &mut Said) + Sync {
    move |_, said| {
        assert!(said.statement.is_empty() || said.statement.contains(from), "{}", said.statement);
        said.statement = said.statement.replace(from, to);
    }
}

fn reason(reason: &'static str) -> impl Fn(&ObserverSpec, &mut Said) + Sync {
    move |_, said| *said = Said { reason: Some(reason.to_owned()), ..Said::default() }
}

/// The lie is found, and without it there is nothing.
fn is_found(
    plant: &str,
    observer: &str,
    lie: &(dyn Fn(&ObserverSpec, &mut Said) + Sync),
    class: Class,
    claim: Option<Claim>,
) {
    let text = format!("{plant}[[observer]]\n{observer}\n");
    let honest = hold(&text, 1, Extent::Designs);
    assert!(honest.designed > 0, "no design:\n{text}");
    let wrong = |finding: &&luenberger_tests::words::Finding| {
        finding.class == class && (claim.is_none() || finding.claim == claim)
    };
    assert!(honest.findings.iter().find(wrong).is_none(), "without a lie: {:?}", honest.findings);
    let found =
        (0..4).any(|seed| hold_with(&text, seed, Extent::Designs, lie).findings.iter().any(|finding| wrong(&finding)));
    assert!(found, "not found, {class:?} {claim:?}:\n{text}");
}

#[test]
fn a_wrong_rate_is_found() {
    let faster = says("tends to 0", "tends to 0, at least as fast as exp(-90 t)");
    let contradicted = |plant, observer, claim| is_found(plant, observer, &faster, Class::Contradiction, Some(claim));
    contradicted(OSCILLATOR, "kind = \"luenberger\"\npoles = [-2, -3]", Claim::Decay);
    contradicted(OSCILLATOR, "kind = \"luenberger\"\ndecay_rate = 1", Claim::Decay);
    contradicted(OSCILLATOR, "kind = \"reduced-order\"\npoles = [-2]", Claim::Reduced);
    let decoupled = "[plant]\na = [[-1, 0], [1, -2]]\nb = [[1], [0]]\nc = [[1, 0], [0, 1]]\n";
    contradicted(decoupled, "kind = \"unknown-input\"\ne = [[1], [0]]\npoles = [-2, -3]", Claim::UnknownInput);
    let faster = says("tend to 0", "tend to 0, at least as fast as exp(-90 t)");
    let observer = "kind = \"extended-state\"\ne = [[0], [1]]\npoles = [-2, -3, -4]";
    is_found(OSCILLATOR, observer, &faster, Class::Contradiction, Some(Claim::Disturbance));
    let faster = says("and the error tends to 0", "exp(-90 t)");
    let pendulum = "[plant]\nf = [\"x2\", \"-sin(x1) - x2\"]\nh = [\"x1\"]\n";
    is_found(pendulum, "kind = \"lpv\"", &faster, Class::Contradiction, Some(Claim::Envelope));
    is_found(pendulum, "kind = \"mean-value\"", &faster, Class::Contradiction, Some(Claim::MeanValue));
    let discrete = "[plant]\na = [[1, 0.1], [0, 1]]\nc = [[1, 0]]\ndt = 0.1\n";
    let lie = reason("A - L C has an eigenvalue that is not inside the unit circle: its spectral radius is 1.1");
    is_found(discrete, "kind = \"luenberger\"\ngain = [[0.9], [2]]", &lie, Class::Contradiction, Some(Claim::NotSchur));
}

#[test]
fn a_wrong_bound_is_found() {
    let bounded = "kind = \"luenberger\"\npoles = [-2, -3]\nbounds = { noise = [0.1] }";
    let lie = |_: &ObserverSpec, said: &mut Said| {
        let (head, tail) = said.statement.split_once("the error in the end is at most x1 ").unwrap();
        let (_, tail) = tail.split_once(", x2").unwrap();
        said.statement = format!("{head}the error in the end is at most x1 0.01, x2{tail}");
    };
    is_found(OSCILLATOR, bounded, &lie, Class::Contradiction, Some(Claim::Ultimate));
    for (kind, claim) in [("h2", Claim::H2), ("h-infinity", Claim::HInfinity)] {
        let observer = format!("kind = \"{kind}\"\ne = [[0, 0], [1, 0]]\nd = [[0, 0.1]]");
        let lie = |_: &ObserverSpec, said: &mut Said| {
            let (head, tail) = said.statement.split_once("gamma = ").unwrap();
            let (_, tail) = tail.split_once(". Without").unwrap();
            said.statement = format!("{head}gamma = 0.001. Without{tail}");
        };
        is_found(OSCILLATOR, &observer, &lie, Class::Contradiction, Some(claim));
    }
    let interval = "kind = \"interval\"\npoles = [-2, -3]\ninitial_bounds = [1, 1]\nbounds = { noise = [0.1] }";
    let lie = |_: &ObserverSpec, said: &mut Said| {
        let (head, tail) = said.statement.split_once("approach x1 ").unwrap();
        let (_, tail) = tail.split_once(", x2").unwrap();
        said.statement = format!("{head}approach x1 0.001, x2{tail}");
    };
    is_found(OSCILLATOR, interval, &lie, Class::Rounding, Some(Claim::Widths));
}

#[test]
fn an_impossibility_that_is_none_is_found() {
    let filter = "kind = \"h2\"\ne = [[0, 0], [1, 0]]\nd = [[0, 0.1]]";
    let contradicted = |observer: &str, lie: &(dyn Fn(&ObserverSpec, &mut Said) + Sync), claim| {
        is_found(OSCILLATOR, observer, lie, Class::Contradiction, Some(claim));
    };
    let lie = reason("no gain makes the H2 norm of the error less than 100: the bound 1 is not attainable");
    contradicted(filter, &lie, Claim::NoGainOfNorm);
    let luenberger = "kind = \"luenberger\"\npoles = [-2, -3]";
    contradicted(
        luenberger,
        &reason("the plant is not observable: unobservable modes at -1 along x1 (margin 0)"),
        Claim::NotObservable,
    );
    let lie = |_: &ObserverSpec, said: &mut Said| {
        *said = Said {
            reason: Some("the kind luenberger".to_owned()),
            hints: vec![
                "the plant is not detectable, no observer exists: add an output that depends on this direction"
                    .to_owned(),
            ],
            ..Said::default()
        };
    };
    contradicted(luenberger, &lie, Claim::NotDetectable);
    let given = "kind = \"luenberger\"\ngain = [[1], [1]]";
    contradicted(given, &reason("A - L C is not Hurwitz: its spectral abscissa is 0.5"), Claim::NotHurwitz);
    contradicted("kind = \"luenberger\"\nlmi = true", &reason("the LMI is infeasible: multipliers"), Claim::Infeasible);
    let widths = reason("no gain makes the comparison system of the error stable in the coordinates of the plant");
    let interval = "kind = \"interval\"\npoles = [-2, -3]\ninitial_bounds = [1, 1]\nbounds = { noise = [0.1] }";
    let chain = "[plant]\na = [[0, 1], [0.5, -1]]\nc = [[1, 0]]\n";
    is_found(chain, interval, &widths, Class::Contradiction, Some(Claim::NoGainOfWidth));
}

#[test]
fn a_verdict_of_another_certificate_is_found() {
    let luenberger = "kind = \"luenberger\"\npoles = [-2, -3]";
    let refuted = |_: &ObserverSpec, said: &mut Said| "refuted".clone_into(&mut said.verdict);
    is_found(OSCILLATOR, luenberger, &refuted, Class::Contradiction, None);
    let uncertified = |_: &ObserverSpec, said: &mut Said| said.sealed = None;
    is_found(OSCILLATOR, luenberger, &uncertified, Class::Contradiction, None);
    // An observer that is not stable, under the word proved.
    let pendulum = "[plant]\nf = [\"x2\", \"-sin(x1) + 0.2*x2\"]\nh = [\"x1\"]\n";
    let slow = "kind = \"high-gain\"\nr = 50\n";
    let lie = |_: &ObserverSpec, said: &mut Said| {
        "proved".clone_into(&mut said.verdict);
        "From every x(0) and xhat(0), |x(t) - xhat(t)| <= 1.5 |x(0) - xhat(0)| exp(-t)."
            .clone_into(&mut said.statement);
    };
    is_found(pendulum, slow, &lie, Class::Contradiction, Some(Claim::Envelope));
    let lie = |_: &ObserverSpec, said: &mut Said| {
        "proved".clone_into(&mut said.verdict);
        "From every x(0) and xhat(0), the error tends to 0, for all 2 nonlinearities within their sectors."
            .clone_into(&mut said.statement);
    };
    is_found(pendulum, slow, &lie, Class::Contradiction, Some(Claim::Sectors));
}

#[test]
fn a_wrong_bound_of_maps_is_found() {
    let plant = "[plant]\nf = [\"x2 - 0.25*x1^3\", \"-x1 - x2\"]\nh = [\"x1\"]\n";
    let maps = "kind = \"kkl\"\nphi = [\"x2 - x1\"]\nlambda = [-2]\nb = [\"-3*y1 + 0.25*y1^3\"]\nleft_inverse = [\"y1\", \"xi1 + y1\"]\nregion = { states = [[-2, 2], [-2, 2]] }";
    let lie = |_: &ObserverSpec, said: &mut Said| {
        let (head, tail) = said.statement.split_once("the estimation error is at most ").unwrap();
        let (_, tail) = tail.split_once(" V(t) for x2").unwrap();
        said.statement = format!("{head}the estimation error is at most 0 for x1, 0.1 V(t) for x2{tail}");
    };
    is_found(plant, maps, &lie, Class::Contradiction, Some(Claim::KklGuaranteed));
    let chain = "[plant]\nf = [\"x2\", \"-sin(x1)\"]\nh = [\"x1\"]\n";
    let lie = says("up to 5 in", "up to 6 in");
    is_found(
        chain,
        "kind = \"sliding-mode\"\nbound = 5\nperiod = 0.01",
        &lie,
        Class::Rounding,
        Some(Claim::FiniteTime),
    );
}

#[test]
fn a_sentence_without_a_check_is_found() {
    let lie = |_: &ObserverSpec, said: &mut Said| said.statement.push_str(" It is optimal in every sense.");
    is_found(OSCILLATOR, "kind = \"luenberger\"\npoles = [-2, -3]", &lie, Class::Unknown, None);
}

#[test]
fn a_header_with_another_verdict_is_found() {
    let plant = "[plant]\nf = [\"x2\", \"-sin(x1) - x2\"]\nh = [\"x1\"]\n[simulation]\nx0 = [1, 0]\nduration = 1\nhold = 0.01\n";
    let text = format!("{plant}[[observer]]\nkind = \"lpv\"\n");
    let measured = |_: &ObserverSpec, said: &mut Said| "measured".clone_into(&mut said.verdict);
    let findings = hold_with(&text, 0, Extent::All, &measured).findings;
    assert!(findings.iter().any(|finding| finding.claim == Some(Claim::HeaderProved)), "{findings:?}");
    let linear = format!(
        "{OSCILLATOR}[simulation]\nx0 = [1, 0]\nduration = 1\nhold = 0.01\n[[observer]]\nkind = \"luenberger\"\npoles = [-2, -3]\n"
    );
    let wider = |_: &ObserverSpec, said: &mut Said| {
        for sentence in &mut said.header {
            *sentence = sentence.replace("states (x1 ", "states (x1 9");
        }
    };
    let findings = hold_with(&linear, 0, Extent::All, &wider).findings;
    let found =
        findings.iter().any(|finding| finding.class == Class::Rounding && finding.claim == Some(Claim::HeaderBound));
    assert!(found, "{findings:?}");
}
