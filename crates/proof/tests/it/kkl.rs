//! The bound of the estimation error of a KKL observer over a box: closed forms that are proved with a residual of 0,
//! approximate maps, false claims, and texts that are no expressions.

use luenberger_proof::certificate::{
    CertificateFile, ExpressionError, KklBox, KklErrorBound, KklInjectivity, KklMapName, KklMaps, KklTexts, Rejection,
    Theorem, verify,
};
use luenberger_proof::{Interval, Matrix, UndecidedReason, Verdict};

fn texts(of: &[&str]) -> Vec<String> {
    of.iter().map(|text| (*text).to_owned()).collect()
}

fn ranges(of: &[(f64, f64)]) -> Vec<Interval> {
    of.iter().map(|(lo, hi)| Interval::new(*lo, *hi).expect("in order")).collect()
}

/// Van der Pol's oscillator with mu = 1 and `phi_i = lambda_i x1 + x2 - (x1 - x1^3/3)`, Lambda = diag(-1, -2).
fn van_der_pol() -> KklTexts {
    KklTexts {
        f: texts(&["x2", "(1 - x1^2)*x2 - x1"]),
        h: texts(&["x1"]),
        phi: texts(&["-x1 + x2 - (x1 - x1^3/3)", "-2*x1 + x2 - (x1 - x1^3/3)"]),
        lambda: texts(&["-1", "0", "0", "-2"]),
        b: texts(&["-y1 + (-y1 - (y1 - y1^3/3))", "-y1 + 2*(-2*y1 - (y1 - y1^3/3))"]),
        left_inverse: texts(&["xi1 + y1 + (y1 - y1^3/3)"]),
        estimated: texts(&["x2"]),
    }
}

fn around_the_cycle() -> KklBox {
    KklBox { x: ranges(&[(-2.5, 2.5), (-3.0, 3.0)]), u: Vec::new() }
}

/// Proposition 6's plant with the observer in `exp(x3) - c y - y^3`, c = 3.
fn exponential_cascade() -> (KklTexts, KklBox) {
    let rate = "(1/(y1^2 + 1) + y1*u1 - 3*y1^2 - 3)";
    let maps = KklTexts {
        f: texts(&["-x1^3 + exp(x3)", "-x2 + x1^2 + sin(x1)", "1/(x1^2 + 1) + x1*u1"]),
        h: texts(&["x1"]),
        phi: texts(&["x2", "exp(x3) - 3*x1 - x1^3"]),
        lambda: texts(&["-1", "0", "0", rate]),
        b: vec!["y1^2 + sin(y1)".to_owned(), format!("{rate}*(3*y1 + y1^3) + (3 + 3*y1^2)*y1^3")],
        left_inverse: texts(&["xi1", "ln(xi2 + 3*y1 + y1^3)"]),
        estimated: texts(&["x2", "x3"]),
    };
    (maps, KklBox { x: ranges(&[(-1.0, 1.5), (-2.0, 3.0), (-1.0, 1.0)]), u: ranges(&[(-1.0, 1.0)]) })
}

fn diagonal(entries: &[f64]) -> Matrix<f64> {
    Matrix::from_fn(entries.len(), entries.len(), |i, j| if i == j { entries[i] } else { 0.0 })
}

fn proposed(maps: &KklTexts, region: KklBox, rate: f64, start: f64) -> KklErrorBound {
    let q = maps.phi.len();
    let maps = KklMaps::new(maps, region.u.len()).expect("expressions");
    let lambda = maps.lambda_over(&region).expect("bounded");
    let one = diagonal(&vec![1.0; q]);
    KklErrorBound::propose(maps, region, lambda, (one.clone(), one, rate), start).expect("bounds")
}

fn file(theorem: KklErrorBound) -> Result<CertificateFile, Rejection> {
    CertificateFile::prove("an observer", theorem)
}

/// An exact solution leaves no residual, and no defect: the bound is 0 in the limit.
#[test]
fn a_closed_form_is_proved_exactly() {
    let bound = proposed(&van_der_pol(), around_the_cycle(), 0.9, 5.0);
    assert_eq!(
        (bound.claims.residual.as_slice(), bound.claims.defect.as_slice()),
        ([0.0, 0.0].as_slice(), [0.0].as_slice())
    );
    assert!((bound.claims.lipschitz[0] - 1.05).abs() < 1e-12);
    let file = file(bound).expect("proved");
    let proved = verify(file.to_json().as_bytes()).expect("verified");
    assert_eq!(proved.facts.len(), 10);
    assert!(proved.statement.contains("f = (x2, (1 - x1^2)*x2 - x1), h = (x1)"), "{}", proved.statement);
    assert!(proved.statement.ends_with("From every xi(0), limsup |z1 - zhat1| <= 0."), "{}", proved.statement);
}

/// sin, exp, a quotient and a logarithm: `1/(x1^2 + 1)` and the rest cancel, and the logarithm is defined up to V =
/// 0.3.
#[test]
fn the_exponential_cascade_is_proved() {
    let (maps, region) = exponential_cascade();
    let bound = proposed(&maps, region.clone(), 0.9, 0.3);
    assert_eq!((&bound.claims.residual, &bound.claims.defect), (&vec![0.0, 0.0], &vec![0.0, 0.0]));
    // 1/(exp(-1) - 0.3), enlarged by a twentieth.
    let exact = 1.05 / ((-1.0_f64).exp() - 0.3);
    assert!((exact..exact * 1.03).contains(&bound.claims.lipschitz[1]), "{:?} {exact}", bound.claims);
    verify(file(bound).expect("proved").to_json().as_bytes()).expect("verified");
    // Beyond exp(-1) the logarithm is not defined.
    let maps = KklMaps::new(&maps, 1).expect("expressions");
    let (lambda, one) = (maps.lambda_over(&region).expect("bounded"), diagonal(&[1.0, 1.0]));
    let beyond = KklErrorBound::propose(maps, region, lambda, (one.clone(), one, 0.9), 0.4).expect("claims");
    let facts = Theorem::from(beyond).facts();
    assert!(facts.is_err() || !facts.expect("facts")[0].verdict.is_proved());
}

/// The reverse Duffing oscillator: with a truncated series for phi, a residual, and a bound of `x2^3`.
#[test]
fn an_approximate_phi_has_a_residual() {
    // phi_i = -(1/d_i) sum_k L_f^k h / d_i^k with three terms, h, x2^3, -3 x1 x2^2; the residual is L_f^3 h / d_i^3.
    let term = |d: i32| format!("-(x1/({d}) + x2^3/({d})^2 - 3*x1*x2^2/({d})^3)");
    let maps = KklTexts {
        f: texts(&["x2^3", "-x1"]),
        h: texts(&["x1"]),
        phi: vec![term(-10), term(-15)],
        lambda: texts(&["-10", "0", "0", "-15"]),
        b: texts(&["y1", "y1"]),
        left_inverse: texts(&["(100*xi1 - 10*y1)*(-3) + (225*xi2 - 15*y1)*2"]),
        estimated: texts(&["x2^3"]),
    };
    let region = KklBox { x: ranges(&[(-0.5, 0.5), (-0.8, 0.8)]), u: Vec::new() };
    let bound = proposed(&maps, region, 9.0, 1.0);
    // L_f^3 h = 6 x1^2 x2 - 3 x2^5, in magnitude at most 1.2 - 0.98304 at the corner, 0.98304 at x1 = 0.
    assert!(bound.claims.residual[0] >= 0.983_04 / 1000.0 && bound.claims.residual[0] < 1.1e-3, "{:?}", bound.claims);
    assert!(file(bound).is_ok());
}

#[test]
fn what_is_false_is_refuted_at_a_point() {
    let mut maps = van_der_pol();
    maps.b[0] = "-y1 + (-y1 - (y1 - y1^3/3)) + 0.125*y1".to_owned();
    let mut bound = proposed(&maps, around_the_cycle(), 0.9, 5.0);
    assert!((0.3125..0.34).contains(&bound.claims.residual[0]));
    bound.claims.residual[0] = 0.25;
    match file(bound).expect_err("refuted") {
        Rejection::NotProved { inequality, verdict } => {
            assert_eq!(inequality, "|Dphi f - Lambda phi - B| <= residual over the box");
            assert!(verdict.is_refuted(), "{verdict:?}");
        }
        other => panic!("{other:?}"),
    }
}

#[test]
fn claims_that_do_not_follow_are_not_proved() {
    let valid = || proposed(&van_der_pol(), around_the_cycle(), 0.9, 5.0);
    assert!(file(valid()).is_ok());
    let changes: [fn(&mut KklErrorBound); 6] = [
        |bound| bound.rate = 1.0,
        |bound| bound.claims.residual[1] = 1e-3,
        |bound| bound.claims.lipschitz[0] = 0.999,
        |bound| bound.claims.limit = 5.0,
        |bound| bound.w = diagonal(&[0.99, 1.0]),
        |bound| bound.lambda = bound.lambda.map(|x| Interval::new(x.lo() + 0.01, x.hi() + 0.01).expect("in order")),
    ];
    for (k, change) in changes.into_iter().enumerate() {
        let mut bound = valid();
        change(&mut bound);
        assert!(matches!(file(bound), Err(Rejection::NotProved { .. })), "change {k}");
    }
}

/// Undefined quotients and logarithms are not proved to be defined, also where they cancel or are multiplied by 0.
#[test]
fn what_is_not_defined_is_not_proved() {
    for text in
        ["x2 + 1/x1 - 1/x1", "x2 + ln(x1) - ln(x1)", "x2 + sqrt(x1)*0", "x2 + (1/(1/x1) - x1)", "x2 + 0/(x1 - x2)"]
    {
        let mut maps = van_der_pol();
        maps.f[0] = text.to_owned();
        let bound = proposed(&maps, around_the_cycle(), 0.9, 5.0);
        let facts = Theorem::from(bound).facts().expect("facts");
        assert!(
            matches!(facts[0].verdict, Verdict::Undecided { why: UndecidedReason::Undefined { .. }, .. }),
            "{text}: {:?}",
            facts[0]
        );
    }
    let mut maps = van_der_pol();
    maps.f[0] = "x2/(x1 - x1)".to_owned();
    let maps = KklMaps::new(&maps, 0).expect("expressions");
    assert_eq!(maps.lambda_over(&around_the_cycle()), Err(UndecidedReason::DivisionByZero));
}

#[test]
fn texts_that_are_no_expressions_say_why() {
    let refused = |text: &str| {
        let mut maps = van_der_pol();
        maps.f[1] = text.to_owned();
        let error = KklMaps::new(&maps, 0).expect_err(text);
        assert_eq!((error.map, error.entry), (KklMapName::F, 1));
        error.error
    };
    let expected = |position, expected| ExpressionError::Expected { position, expected };
    assert_eq!(refused("x1 +"), expected(5, "a number, a variable, a function or a parenthesis"));
    assert_eq!(refused("(x1"), expected(4, "an operator or a closing parenthesis"));
    assert_eq!(refused("x1 x2"), expected(4, "an operator or the end"));
    assert_eq!(refused("x1^x2"), expected(4, "an integer exponent"));
    assert_eq!(refused("sin x1"), expected(5, "an opening parenthesis"));
    assert_eq!(refused("1.*x1"), expected(3, "a digit"));
    assert_eq!(refused(""), expected(1, "a number, a variable, a function or a parenthesis"));
    assert_eq!(refused("0.1*x1"), ExpressionError::NotBinary64 { number: "0.1".to_owned() });
    assert_eq!(refused("x1^65"), ExpressionError::Exponent { exponent: "65".to_owned() });
    assert_eq!(refused(&format!("{}x1{}", "(".repeat(60), ")".repeat(60))), ExpressionError::TooDeep);
    assert_eq!(refused(&"-".repeat(100)), ExpressionError::TooDeep);
    assert!(matches!(refused(&"x1+".repeat(10_000)), ExpressionError::TooLong { .. }));
    for name in ["x3", "x0", "x01", "u1", "y1", "nan", "inf", "abs(x1)", "x"] {
        assert!(matches!(refused(name), ExpressionError::UnknownName { .. }), "{name}");
    }
}

/// Expressions that would expand to very many terms, or overflow, end in bounded time.
#[test]
fn large_expressions_are_refused() {
    for text in [
        "(x1 + x2)^64*(x1 - x2)^64*(1 + x1)^64*(1 + x2)^64*(x1 + 2*x2)^64",
        "((((((x1^64)^64)^64)^64)^64)^64)",
        "exp(exp(exp(exp(exp(exp(100*x1))))))",
        "((((3^64)^64)^64)^64)*x1",
    ] {
        let mut maps = van_der_pol();
        maps.f[1] = text.to_owned();
        let maps = KklMaps::new(&maps, 0).expect("an expression");
        let lambda = Matrix::from_fn(2, 2, |i, j| Interval::of(if i == j { [-1.0, -2.0][i] } else { 0.0 }));
        let one = diagonal(&[1.0, 1.0]);
        let found = KklErrorBound::propose(maps, around_the_cycle(), lambda, (one.clone(), one, 0.9), 5.0);
        let proved =
            found.is_ok_and(|bound| bound.claims.residual.iter().all(|x| x.is_finite()) && file(bound).is_ok());
        assert!(!proved, "{text}");
    }
}

/// Van der Pol with `phi` replaced by S phi, S = [1, 1; 0, 1], so that Lambda is not diagonal, and `wrong` too much in
/// the first entry of B.
fn sheared(wrong: &str) -> KklTexts {
    let straight = van_der_pol();
    let sum = |of: &[String]| format!("{} + {}", of[0], of[1]);
    KklTexts {
        phi: vec![sum(&straight.phi), straight.phi[1].clone()],
        lambda: texts(&["-1", "-1", "0", "-2"]),
        b: vec![format!("{} + {wrong}", sum(&straight.b)), straight.b[1].clone()],
        left_inverse: texts(&["xi1 - xi2 + y1 + (y1 - y1^3/3)"]),
        ..straight
    }
}

/// Each bound is proved a little above the number that it has to exceed, and not a little below.
#[test]
fn the_claims_are_sharp() {
    let (maps, region) = (KklMaps::new(&sheared("0.25*y1"), 0).expect("expressions"), around_the_cycle());
    let lambda = maps.lambda_over(&region).expect("bounded");
    let coupling = -0.4;
    let p = Matrix::from_rows([[1.0, coupling], [coupling, 1.0]]);
    let inverse = 1.01 / (1.0 - coupling * coupling);
    let w = Matrix::from_rows([[inverse, -coupling * inverse], [-coupling * inverse, inverse]]);
    let bound = KklErrorBound::propose(maps, region, lambda, (p, w, 0.8), 5.0).expect("bounds");
    let is_proved = |change: &dyn Fn(&mut KklErrorBound)| {
        let mut bound = bound.clone();
        change(&mut bound);
        file(bound).is_ok()
    };
    assert!(is_proved(&|_| ()));
    // 0.25 x1 in the first entry only, at x1 = 2.5.
    assert_eq!(bound.claims.residual[1], 0.0);
    let residual = |share: f64| move |bound: &mut KklErrorBound| bound.claims.residual[0] = 0.625 * share;
    assert!(is_proved(&residual(1.0 + 1e-9)) && !is_proved(&residual(1.0 - 1e-9)));
    // With both entries r: r'|P|r = 2.8 r^2, and the limit is its root over the rate.
    let limit = |share: f64| {
        move |bound: &mut KklErrorBound| {
            bound.claims.residual = vec![0.65, 0.65];
            bound.claims.limit = share * 0.65 * 2.8_f64.sqrt() / 0.8;
            bound.claims.eventual[0] = 100.0;
        }
    };
    assert!(is_proved(&limit(1.0 + 1e-12)) && !is_proved(&limit(1.0 - 1e-12)));
    // g = (1, -1): g'Wg = 2.02 (1 + coupling)/(1 - coupling^2).
    let squared = 2.02 * (1.0 + coupling) / (1.0 - coupling * coupling);
    let lipschitz = |share: f64| move |bound: &mut KklErrorBound| bound.claims.lipschitz[0] = share * squared.sqrt();
    assert!(is_proved(&lipschitz(1.0 + 1e-12)) && !is_proved(&lipschitz(1.0 - 1e-12)));
    let eventual = |share: f64| {
        move |bound: &mut KklErrorBound| {
            bound.claims.defect[0] = 0.5;
            bound.claims.eventual[0] = share * (bound.claims.lipschitz[0] * bound.claims.limit + 0.5);
        }
    };
    assert!(is_proved(&eventual(1.0 + 1e-12)) && !is_proved(&eventual(1.0 - 1e-12)));
    let start = |share: f64| move |bound: &mut KklErrorBound| bound.claims.start = share * bound.claims.limit;
    assert!(is_proved(&start(1.0 + 1e-12)) && !is_proved(&start(1.0)));
}

/// The logarithm is defined for `exp(-1) > sqrt(W_22) start`.
#[test]
fn the_reach_of_the_error_is_the_root_of_w() {
    for (weight, share) in [(4.0, 0.98), (0.25, 0.98), (4.0, 1.02), (0.25, 1.02)] {
        let (maps, region) = exponential_cascade();
        let maps = KklMaps::new(&maps, 1).expect("expressions");
        let lambda = maps.lambda_over(&region).expect("bounded");
        let start = share * (-1.0_f64).exp() / f64::sqrt(weight);
        let (p, w) = (diagonal(&[1.0, 1.0 / weight]), diagonal(&[1.0, weight]));
        let bound = KklErrorBound::propose(maps, region, lambda, (p, w, 0.9), start).expect("bounds");
        let facts = Theorem::from(bound).facts();
        let is_defined = facts.is_ok_and(|facts| facts[0].verdict.is_proved());
        assert_eq!(is_defined, share < 1.0, "W_22 = {weight}, start = {start}");
    }
}

/// `phi' = -phi + B` along `x' = 1` for every function and operation, with derivatives by hand.
#[test]
fn derivatives_are_those_of_calculus() {
    for (phi, derivative) in [
        ("sin(2*x1)", "2*cos(2*x1)"),
        ("cos(x1)^2", "-2*cos(x1)*sin(x1)"),
        ("exp(x1^2)", "2*x1*exp(x1^2)"),
        ("ln(1 + x1^2)", "2*x1/(1 + x1^2)"),
        ("sqrt(2 + x1)", "1/(2*sqrt(2 + x1))"),
        ("tanh(3*x1)", "3 - 3*tanh(3*x1)^2"),
        ("atan(x1/2)", "(1/2)/(1 + x1^2/4)"),
        ("x1^3/(4 - x1)", "(3*x1^2*(4 - x1) + x1^3)/(4 - x1)^2"),
        ("(2 + x1)^-2", "-2*(2 + x1)^-3"),
        ("1/(1/(3 + x1))", "1"),
        ("sqrt(2 + x1)*sqrt(2 + x1)", "1"),
        ("exp(ln(3 + x1)) + ln(exp(x1))", "2"),
        ("sin(x1)^2 + cos(x1)^2", "0"),
    ] {
        let maps = KklTexts {
            f: texts(&["1"]),
            h: texts(&["x1"]),
            phi: texts(&[phi]),
            lambda: texts(&["-1"]),
            b: vec![format!("{phi} + {derivative}").replace("x1", "y1")],
            left_inverse: texts(&["y1"]),
            estimated: texts(&["x1"]),
        };
        let region = KklBox { x: ranges(&[(-1.0, 1.0)]), u: Vec::new() };
        let bound = proposed(&maps, region, 0.5, 1.0);
        assert_eq!(bound.claims.residual, [0.0], "{phi}");
        assert!(file(bound.clone()).is_ok(), "{phi}");
        // A derivative that is too large by 1e-3 is seen.
        let wrong = KklTexts { b: vec![format!("{} + 0x1p-10", maps.b[0])], ..maps };
        let maps = KklMaps::new(&wrong, 0).expect("expressions");
        assert!(matches!(file(KklErrorBound { maps, ..bound }), Err(Rejection::NotProved { .. })), "{phi}");
    }
}

/// Malformed files, each with a message that names what is wrong.
#[test]
fn malformed_files_are_rejected() {
    let text = file(proposed(&van_der_pol(), around_the_cycle(), 0.9, 5.0)).expect("proved").to_json();
    let long = format!("\"{}x2\"", "x2 + ".repeat(4000));
    let many = format!("[{}]", vec!["\"x1\""; 17].join(", "));
    for (from, to, message) in [
        ("\"x2\",", &long[..], "an expression of 20002 characters"),
        ("\"x2\",", "\"x3\",", "x3 is no variable or function here; the variables are x1 to x2"),
        ("\"x2\",", "\"NaN\",", "a number, a variable, a function or a parenthesis should be"),
        ("\"x2\",", "\"abs(x2)\",", "abs is no variable"),
        ("\"x2\",", "7,", "a string"),
        ("\"0x1.4p2\"", "\"0x0p0\"", "this number is positive"),
        ("\"0x1.4p2\"", "\"-0x1p0\"", "this number is positive"),
        ("[\"-0x1.4p1\", \"0x1.4p1\"]", "[\"0x1.4p1\", \"-0x1.4p1\"]", "lies above"),
        ("[\"-0x1.4p1\", \"0x1.4p1\"], ", "", "has 1 elements, and should have 2"),
        ("[\"-0x1.4p1\", \"0x1.4p1\"]", "[\"-0x1.4p1\", \"inf\"]", "not a number"),
    ] {
        let to = if to.starts_with("\"x2 +") { format!("{to},") } else { to.to_owned() };
        assert!(text.contains(from), "{from}\n{text}");
        let error = verify(text.replacen(from, &to, 1).as_bytes()).expect_err(message).to_string();
        assert!(error.contains(message), "{error}\n{message}");
    }
    let plant = text.find("\"h\": [").expect("outputs");
    let end = plant + text[plant..].find(']').expect("an end") + 1;
    let seventeen = format!("{}\"h\": {many}{}", &text[..plant], &text[end..]);
    let error = verify(seventeen.as_bytes()).expect_err("17 outputs").to_string();
    assert!(error.contains("is of order 17; the checker goes up to 16"), "{error}");
}

/// Van der Pol's (phi, h) with an M that takes x1 from h and x2 from the first entry of phi.
#[test]
fn the_modulus_of_injectivity_is_proved() {
    let unit = KklBox { x: ranges(&[(-1.0, 1.0), (-3.0, 3.0)]), u: Vec::new() };
    let mut bound = proposed(&van_der_pol(), unit, 0.9, 5.0);
    let jacobian = bound.maps.jacobian_over(&bound.region).expect("bounded");
    assert_eq!((jacobian.rows(), jacobian.cols()), (3, 2));
    let m = Matrix::from_rows([[0.0, 0.0, 8.0], [1.0, 0.0, 1.5]]);
    // M J + J'M' = [16, a; a, 2], a = 1.5 - 1 - (1 - x1^2) from -0.5 to 0.5.
    bound.injectivity = Some(KklInjectivity { jacobian, m, modulus: 0.7, spread: 1.0 });
    let text = file(bound.clone()).expect("proved").to_json();
    let proved = verify(text.as_bytes()).expect("verified");
    assert_eq!(proved.facts.len(), 13);
    assert!(proved.statement.ends_with("with spread = 1, for every z in the box."), "{}", proved.statement);
    let changes: [fn(&mut KklInjectivity); 4] = [
        |of| of.modulus = 1.0,
        |of| of.spread = 0.99,
        |of| of.jacobian = of.jacobian.map(|x| Interval::new(x.lo() + 0.01, x.hi() + 0.01).expect("in order")),
        |of| of.m = of.m.map(|x| if *x == 8.0 { 0.0 } else { *x }),
    ];
    for (k, change) in changes.into_iter().enumerate() {
        let mut wrong = bound.clone();
        change(wrong.injectivity.as_mut().expect("given"));
        assert!(matches!(file(wrong), Err(Rejection::NotProved { .. })), "change {k}");
    }
}
