//! Outputs that are states, chains and time invariance are read from expressions: what holds at the points that a
//! probe would try, and not elsewhere, is no structure.

use luenberger_expression::{ExpressionPlant, Parameters, Row};
use luenberger_plants::{Differentiable, Plant};
use luenberger_study::design::Designed;
use luenberger_study::model::{Builtin, Model};
use luenberger_study::results::NoObserver;
use nalgebra::{DMatrix, DVector};
use proptest::prelude::*;

use crate::studies::{designed, read, study};

/// A study with one observer.
fn with(plant: &str, observer: &str) -> String {
    format!("[plant]\n{plant}\n[[observer]]\n{observer}\n")
}

fn refused(plant: &str, observer: &str) -> NoObserver {
    match designed(&study(&with(plant, observer))) {
        Err(failure) => failure,
        Ok(designed) => panic!("{observer}: {}: {}", designed.report.verdict, designed.report.statement),
    }
}

fn accepted(plant: &str, observer: &str) -> Designed {
    designed(&study(&with(plant, observer))).unwrap_or_else(|why| panic!("{plant}\n{observer}: {why:?}"))
}

#[test]
fn an_output_that_is_the_state_at_some_points_only_is_not_the_state() {
    let whole = "for all states, inputs and times";
    for (h, why) in [
        ("x1 + sin(t)", format!("y1 is not shown to be x1 {whole}")),
        ("sat(x1, -10, 10)", format!("y1 is not shown to be x1 {whole}")),
        ("if(t > 5, 0, x1)", format!("y1 is not shown to be x1 {whole}")),
        ("x1 + 1e-12", "y1 is not x1".to_owned()),
        ("x2", "y1 measures x2, not x1; reorder the states".to_owned()),
    ] {
        let plant = format!("f = [\"x2\", \"-x1 - x2\"]\nh = [\"{h}\"]");
        let failure = refused(&plant, "kind = \"mean-value\"");
        assert_eq!(
            failure.hypothesis,
            format!("the kind mean-value needs outputs that are the first states, y = (x1, .., xp): {why}")
        );
        let failure = refused(&plant, "kind = \"high-gain\"\nr = 0.1");
        assert_eq!(failure.hypothesis, format!("the kind high-gain needs chains that begin at the outputs: {why}"));
    }
    // The undamped oscillator behind a sensor that saturates, with the rate that was once proved.
    let plant = "f = [\"x2\", \"-x1\"]\nh = [\"sat(x1, -10, 10)\"]";
    assert!(refused(plant, "kind = \"mean-value\"\ndecay_rate = 0.3").hypothesis.contains("is not shown to be x1"));
    // As written, the same state.
    for h in ["x1", "1*x1", "x1 + 0*x2", "x1 + 0", "2*x1 - x1"] {
        let plant = format!("f = [\"x2\", \"-x1 - x2\"]\nh = [\"{h}\"]");
        assert_eq!(accepted(&plant, "kind = \"mean-value\"").report.verdict.word(), "proved", "{h}");
    }
}

const SLIDING: &str = "kind = \"sliding-mode\"\nbound = 5\nperiod = 0.001";

#[test]
fn a_chain_of_integrators_is_one_for_all_states_inputs_and_times() {
    let whole = "for all states, inputs and times";
    for (f1, f2, h, inputs, why) in [
        ("x2*cos(t)", "-x1 - x2", "x1", "", format!("x1' is not shown to be x2 {whole}")),
        ("sat(x2, -3, 3)", "1.6 - 0.2*x2", "x1", "", format!("x1' is not shown to be x2 {whole}")),
        ("if(t > 5, 0, x2)", "-x1", "x1", "", format!("x1' is not shown to be x2 {whole}")),
        ("x2 + x1*u1", "-x1 - x2 + 2*u1", "x1", "inputs = [\"u1\"]", format!("x1' is not shown to be x2 {whole}")),
        ("x2 + u1", "-x1", "x1", "inputs = [\"u1\"]", "x1' is not x2".to_owned()),
        ("x1^2", "-x1", "x1", "", "x1' is not x2".to_owned()),
        ("x2", "-x1", "sat(x1, -2, 2)", "", format!("y1 is not shown to be x1 {whole}")),
        ("x2", "-x1", "if(t > 5, 0, x1)", "", format!("y1 is not shown to be x1 {whole}")),
        ("1.0000000001*x2", "-x1", "x1", "", "x1' is not x2".to_owned()),
        ("x2", "-x1", "x1 + u1", "inputs = [\"u1\"]", "y1 is not x1".to_owned()),
    ] {
        let plant = format!("f = [\"{f1}\", \"{f2}\"]\nh = [\"{h}\"]\n{inputs}");
        let failure = refused(&plant, SLIDING);
        assert!(failure.hypothesis.ends_with(&format!("and the input in the last: {why}")), "{}", failure.hypothesis);
    }
    // The names of the study.
    let named = "f = [\"tanh(speed)\", \"-angle\"]\nh = [\"angle\"]\nstates = [\"angle\", \"speed\"]";
    assert!(refused(named, SLIDING).hypothesis.contains("angle' is not shown to be speed"));
    // The same chain, whatever the last equation is.
    for f1 in ["x2", "1*x2 + 0*x1", "3*x2 - 2*x2"] {
        let plant = format!("f = [\"{f1}\", \"sat(x2, -3, 3)*cos(t) + u1\"]\nh = [\"x1 + 0\"]\ninputs = [\"u1\"]");
        assert_eq!(accepted(&plant, SLIDING).report.verdict.word(), "proved", "{f1}");
    }
}

/// The factors of a high-gain observer are those of the first estimate: its theorem is for chains whose coefficients
/// are constant.
#[test]
fn the_theorem_of_high_gain_is_for_constant_coefficients() {
    let statement = |f1: &str| {
        let plant = format!("f = [\"{f1}\", \"-x1\"]\nh = [\"x1\"]");
        accepted(&plant, "kind = \"high-gain\"\nr = 0.1\ninitial = [0, 1]").report.statement
    };
    for f1 in ["x2", "x2 - x1^3", "4*x2 + sin(t)"] {
        assert!(statement(f1).contains("decays like exp(-c t / r)"), "{f1}");
    }
    for f1 in ["sat(x2, -3, 3)", "x2*cos(t)", "x2*x1^2 + x2"] {
        assert!(!statement(f1).contains("decays"), "{f1}");
        assert!(statement(f1).contains("The coefficients of the chain vary"), "{f1}");
    }
}

const SHIFTED: &str = "f = [\"x2\", \"-x1\"]\nh = [\"x1 + 0.5*sin(t)\"]";
const REGION: &str = "region = { states = [[-3, 3], [-4, 4]] }";

#[test]
fn an_output_with_the_time_in_it() {
    let immersion = format!(
        "kind = \"immersion-invariance\"\nbeta = [\"chi1 + 2*y1\"]\nphi = [\"x2\"]\nleft_inverse = [\"y1\", \"z1\"]\n{REGION}"
    );
    let failure = refused(SHIFTED, &immersion);
    assert_eq!(
        failure.hypothesis,
        "the kind immersion-invariance is for outputs y = h(x) without the time: y1 depends on the time t"
    );
    // Without it, and with the time in f, the same maps are proved.
    for f2 in ["-x1", "-x1 + sin(t)"] {
        let plant = format!("f = [\"x2\", \"{f2}\"]\nh = [\"x1\"]");
        assert_eq!(accepted(&plant, &immersion).report.verdict.word(), "proved", "{f2}");
    }
    // A phi without t does not solve (4), whose residual is 2.5 sin(t); one that knows the time does.
    let kkl = |phi: &str, b: &str, left: &str| {
        format!(
            "kind = \"kkl\"\nphi = [\"{phi}\"]\nlambda = [-2]\nb = [\"{b}\"]\nleft_inverse = [\"{left}\", \"xi1 + 2*({left})\"]\n{REGION}"
        )
    };
    let failure = refused(SHIFTED, &kkl("x2 - 2*x1", "-5*y1", "y1"));
    assert!(failure.hypothesis.contains("D phi f = Lambda phi + B"), "{}", failure.hypothesis);
    assert_eq!(
        failure.hints,
        [
            "other `phi`, `lambda` or `b`, in which t may occur: y1 depends on the time t",
            "a smaller `region`, its `time` included"
        ]
    );
    let known = accepted(SHIFTED, &kkl("x2 - 2*x1", "-5*(y1 - 0.5*sin(t))", "y1 - 0.5*sin(t)"));
    assert!(known.report.facts.iter().any(|fact| fact.statement == "D phi f = Lambda phi + B"));
    // At t = 0 this phi^L takes phi(x) back.
    let failure = refused(SHIFTED, &kkl("x2 - 2*x1", "-5*(y1 - 0.5*sin(t))", "y1"));
    assert!(failure.hypothesis.starts_with("`left_inverse` is not a left inverse of phi: at x1 = "));
    assert!(failure.hypothesis.contains(", t = "), "{}", failure.hypothesis);
    // Jacobians are enclosed over all times.
    for kind in ["lpv", "lipschitz"] {
        assert_eq!(accepted(SHIFTED, &format!("kind = \"{kind}\"")).report.verdict.word(), "proved", "{kind}");
    }
    let failure = refused(SHIFTED, "kind = \"kkl-numerical\"\ndomain = [[-3, 3], [-4, 4]]");
    assert_eq!(
        failure.hypothesis,
        "the kind kkl-numerical is for plants x' = f(x, u), y = h(x, u) without the time: y1 depends on the time t"
    );
}

#[test]
fn a_table_is_of_a_plant_without_the_time() {
    let plant = "f = [\"x2\", \"-x1 + 0.5*sin(3*t)\"]\nh = [\"x1\"]";
    let failure = refused(plant, "kind = \"kkl-numerical\"\ndomain = [[-2, 2], [-2, 2]]");
    assert_eq!(
        failure.hypothesis,
        "the kind kkl-numerical is for plants x' = f(x, u), y = h(x, u) without the time: x2' depends on the time t"
    );
    let kinds: Vec<&str> =
        failure.alternatives.iter().filter_map(|alternative| alternative.words().split('"').nth(1)).collect();
    assert_eq!(kinds, ["lpv", "lipschitz", "mean-value", "extended-kalman"]);
}

/// The damping is 1 + 0.5 cos(t): between 0.5 and 1.5 at all times, between 1.27 and 1.5 up to t = 1.
#[test]
fn jacobians_that_vary_with_the_time_are_enclosed_over_the_times_of_the_claim() {
    let plant = "f = [\"x2\", \"-x1 - (1 + 0.5*cos(t))*x2\"]\nh = [\"x1\"]";
    for kind in ["lpv", "mean-value"] {
        let vertices = |region: &str| {
            let report = accepted(plant, &format!("kind = \"{kind}\"\n{region}")).report;
            assert_eq!(report.verdict.word(), "proved");
            let facts: Vec<String> = report.facts.into_iter().map(|fact| fact.statement).collect();
            (report.statement, facts.join("\n"))
        };
        let (always, all) = vertices("");
        assert!(all.contains("df2/dx2 = -1.5") && all.contains("df2/dx2 = -0.5"), "{all}");
        assert!(!always.contains("t in"), "{always}");
        let (until, some) = vertices("region = { time = [0, 1] }");
        // -(1 + 0.5 cos(1)) = -1.2701511529340699.
        assert!(some.contains("df2/dx2 = -1.27015") && !some.contains("df2/dx2 = -0.5"), "{some}");
        assert!(until.contains("t in [0, 1]"), "{until}");
    }
}

/// Without `start`, chi starts at phi(x) - beta(y, 0), which is right for chi plus a function of y alone.
#[test]
fn beta_is_chi_plus_a_function_of_the_outputs_everywhere() {
    let immersion = |beta: &str| {
        let observer = format!(
            "kind = \"immersion-invariance\"\nbeta = [\"{beta}\"]\nphi = [\"x2\"]\nleft_inverse = [\"y1\", \"z1\"]\n{REGION}"
        );
        read(&with("f = [\"x2\", \"-x1\"]\nh = [\"x1\"]", &observer)).map(|_| ()).map_err(|error| error.to_string())
    };
    for beta in ["chi1 + 2*y1", "2*y1^3 + 1*chi1 - 1", "sat(y1) + 3*chi1 - 2*chi1"] {
        assert_eq!(immersion(beta), Ok(()), "{beta}");
    }
    for beta in ["chi1 + max(chi1 - 10, 0) + 2*y1", "chi1 + step(chi1 - 3)", "chi1*(1 + step(y1 - 5))", "2*chi1"] {
        let why = immersion(beta).unwrap_err();
        assert!(why.contains("`beta` is not chi plus a function of the outputs"), "{beta}: {why}");
    }
}

const LIBRARY: [&str; 9] = [
    "double-integrator",
    "third-order",
    "flexible-joint",
    "flexible-joint-printed",
    "chaotic",
    "cuk",
    "reverse-duffing",
    "van-der-pol",
    "exponential-cascade",
];

/// The numbers of a column between -size and size.
fn column(length: usize, size: f64) -> impl Strategy<Value = DVector<f64>> {
    prop::collection::vec(-size..size, length).prop_map(DVector::from_vec)
}

proptest! {
    /// The structure of a library plant is read from the expressions that state it: they have the values and the
    /// Jacobians of the plant as programmed, and what is said to be constant or absent is so.
    #[test]
    fn the_structure_of_the_library_is_that_of_its_plants(
        name in prop::sample::select(&LIBRARY),
        (x, u, t) in (column(6, 6.0), column(6, 2.0), -20.0..20.0f64),
    ) {
        let model = Model::Builtin(Builtin::named(name).unwrap());
        let (size, structure, text) = (model.size(), model.structure(), model.expressions().unwrap());
        let (x, u) = (x.rows(0, size.states).into_owned(), u.rows(0, size.inputs).into_owned());
        let (f, h) = (model.derivative(t, &x, &u), model.output(t, &x, &u));
        let near = |a: f64, b: f64| (a - b).abs() <= 1e-12 * (1.0 + a.abs().max(b.abs()));
        let same = |a: &DVector<f64>, b: &DVector<f64>| a.len() == b.len() && a.iter().zip(b.iter()).all(|(a, b)| near(*a, *b));
        prop_assert!(same(&f, &text.derivative(t, &x, &u)) && same(&h, &text.output(t, &x, &u)), "{}", name);
        let (a, c) = (model.state_jacobian(t, &x, &u), model.output_jacobian(t, &x, &u));
        let by_text: DMatrix<f64> = text.state_jacobian(t, &x, &u);
        prop_assert!(a.iter().zip(by_text.iter()).all(|(a, b)| near(*a, *b)), "{}: {} {}", name, a, by_text);
        for i in 0..size.states {
            for j in 0..size.states {
                prop_assert!(structure.depends_on(i, j) || a[(i, j)] == 0.0, "{}: {} {}", name, i, j);
            }
            prop_assert!(!structure.is_next_state(i) || f[i] == x[i + 1], "{}: {}", name, i);
        }
        for k in 0..size.outputs {
            let Some(state) = structure.output_state(k) else { continue };
            prop_assert_eq!(h[k], x[state], "{}: {}", name, k);
            prop_assert!((0..size.states).all(|j| c[(k, j)] == f64::from(u8::from(j == state))), "{}: {}", name, k);
        }
        // None of them depends on the time or has a feedthrough.
        prop_assert_eq!((structure.explicit_time(), structure.feedthrough()), (None, None));
        let elsewhere = (model.derivative(t + 1.5, &x, &u), model.output(t - 3.0, &x, &u.map(|u| u + 1.0)));
        prop_assert_eq!(elsewhere, (f, h), "{}", name);
    }
}

#[test]
fn the_library_has_its_outputs_and_chains() {
    let of = |name: &str| {
        let model = Model::Builtin(Builtin::named(name).unwrap());
        let (structure, size) = (model.structure(), model.size());
        let outputs: Vec<Option<usize>> = (0..size.outputs).map(|k| structure.output_state(k)).collect();
        let chain: Vec<usize> = (0..size.states).filter(|i| structure.is_next_state(*i)).collect();
        (outputs, chain)
    };
    assert_eq!(of("double-integrator"), (vec![Some(0)], vec![0]));
    assert_eq!(of("flexible-joint"), (vec![Some(0), Some(1)], vec![0, 2]));
    assert_eq!(of("chaotic"), (vec![Some(0), Some(1)], vec![]));
    assert_eq!(of("cuk"), (vec![Some(1), Some(2)], vec![]));
    assert_eq!(of("van-der-pol"), (vec![Some(0)], vec![0]));
    assert_eq!(of("reverse-duffing"), (vec![Some(0)], vec![]));
}

/// Ways to write a state, and texts that are that state at small states, at t = 0 and without input, with a point
/// (t, u, by how much every state is moved from its place) at which they are not.
fn written(state: &str, other: &str) -> Vec<String> {
    ["S", "1*S", "S + 0*O", "S + 0", "(S + O) - O", "-(-S)", "S/1 - 0*u1", "0.5*S + S/2", "if(1 < 2, S, O)"]
        .map(|text| text.replace('S', state).replace('O', other))
        .to_vec()
}

const DISGUISES: [&str; 12] = [
    "sat(S, -10, 10)",
    "if(t > 5, 0, S)",
    "if(t > 5, 2*S, S)",
    "S + 0.1*sin(t)",
    "S*(1 + u1)",
    "S + u1*O",
    "if(abs(S) > 10, 0, S)",
    "min(S, 10 + O^2)",
    "S + max(O - 10, 0)",
    "S*cos(t)",
    "S + 1e-9*t",
    "S + step(O - 10)",
];

proptest! {
    /// One row of a chain is no state, though it is one at small states, at t = 0 and without input: it never counts as
    /// one, and the others, however they are written, do.
    #[test]
    fn a_disguised_row_is_found(
        n in 2..5usize,
        at in 0..5usize,
        how in prop::sample::select(&DISGUISES),
        ways in prop::collection::vec(0..9usize, 6),
        own in 0..4usize,
    ) {
        let at = at % n;
        // Row 0 is the output, row i is the equation of state i - 1; each should be the state i.
        let row = |i: usize, is_disguised: bool| {
            let (state, other) = (format!("x{}", i + 1), format!("x{}", (i + 1 + own % (n - 1)) % n + 1));
            let text = how.replace('S', &state).replace('O', &other);
            if is_disguised { text } else { written(&state, &other)[ways[i]].clone() }
        };
        let structure_of = |disguised: Option<usize>| {
            let f: Vec<String> = (1..n).map(|i| row(i, disguised == Some(i))).chain(["-x1".to_owned()]).collect();
            let plant = ExpressionPlant::new(&f, &[row(0, disguised == Some(0))], 1, &Parameters::new()).unwrap();
            let structure = Model::from(plant.clone()).structure();
            let shown: Vec<bool> = (0..n)
                .map(|i| if i == 0 { structure.output_state(0) == Some(0) } else { structure.is_next_state(i - 1) })
                .collect();
            (plant, structure, shown)
        };
        let (_, plain, all) = structure_of(None);
        prop_assert!(all.iter().all(|shown| *shown), "{:?}", all);
        prop_assert_eq!((plain.explicit_time(), plain.feedthrough()), (None, None));
        let (plant, structure, shown) = structure_of(Some(at));
        prop_assert!((0..n).all(|i| shown[i] == (i != at)), "{} in row {}: {:?}", how, at, shown);
        let timed = if at == 0 { Row::Output(0) } else { Row::Derivative(at - 1) };
        let is_timed = ["if(t", "(t)", "*t"].iter().any(|part| how.contains(part));
        prop_assert_eq!(structure.explicit_time(), is_timed.then_some(timed));
        // It is a disguise: the state at t = 0 and small states without input, and not everywhere.
        let value = |t: f64, u: f64, x: &[f64]| {
            let (x, u) = (DVector::from_column_slice(x), DVector::repeat(1, u));
            if at == 0 { plant.output(t, &x, &u)[0] } else { plant.derivative(t, &x, &u)[at - 1] }
        };
        let small: Vec<f64> = (0..n).map(|i| 0.3 + 0.17 * i as f64).collect();
        prop_assert_eq!(value(0.0, 0.0, &small), small[at]);
        let far = |i: usize, own: bool| if (i == at) == own { 400.0 } else { small[i] };
        let differs = |own: bool| {
            let x: Vec<f64> = (0..n).map(|i| far(i, own)).collect();
            value(7.0, 0.5, &x) != x[at]
        };
        prop_assert!(differs(true) || differs(false), "{}", how);
    }
}
