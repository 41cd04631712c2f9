//! Files for Coq: their numbers, their theorems, and what has none. `cargo xtask kernel` compiles such files.

use luenberger_proof::Matrix;
use luenberger_proof::certificate::{
    CertificateFile, CubicConvergence, CubicTheorem1, DeployedObserver, DiscreteConvergence, DiscreteJacobianPolytope,
    FeedbackLoop, HurwitzStability, LinearConvergence, Number, PlantMatrices, PlantPolytope, PlantWithin, Region,
    Rejection, SampledCubicConvergence, StructuredCubicConvergence, Vertex, digest,
};
use luenberger_proof::coq::cubic_paper::{WrongSign, wrong_sign};
use luenberger_proof::coq::{CoqError, CoqFile, theorems};
use luenberger_proof::interval::Interval;
use luenberger_proof::statement::{Format, Operation, SampledPlant, Step, deployed_linear};

/// `x' = -x + u`, `y = x` with the gain 1: `F = -2`, and `F'P + PF = -4 P`.
fn plant() -> PlantMatrices {
    let [a, b, c] = [-1.0, 1.0, 1.0].map(|entry| Matrix::from_rows([[entry]]));
    PlantMatrices { a, b, c }
}

fn one(entry: f64) -> Matrix<f64> {
    Matrix::from_rows([[entry]])
}

fn interval(lo: f64, hi: f64) -> Matrix<Interval> {
    Matrix::from_rows([[Interval::new(lo, hi).unwrap()]])
}

fn linear(rate: f64) -> LinearConvergence {
    let PlantMatrices { a, b, c } = plant();
    LinearConvergence { plant: PlantWithin::exactly(&a, &b, &c).unwrap(), l: one(1.0), p: one(3.0), rate }
}

/// The value of a definition of the file.
fn defined(file: &CoqFile, name: &str) -> f64 {
    let start = format!("Definition {name} : Q := ");
    let line = file.text.lines().find_map(|line| line.strip_prefix(&start)).expect(name);
    let number: Number = line.trim_end_matches('.').parse().unwrap();
    number.to_f64().unwrap()
}

/// The same certificate with another text, and a digest that fits.
fn changed(file: &CertificateFile, from: &str, to: &str) -> CertificateFile {
    let text = file.to_json();
    let other = text.replacen(from, to, 1);
    assert_ne!(text, other);
    let found = other.split("\"sha256\": \"").nth(1).and_then(|rest| rest.split('"').next()).unwrap();
    let sealed = other.replace(found, &digest(other.as_bytes()).unwrap());
    CertificateFile::read(sealed.as_bytes()).unwrap()
}

#[test]
fn a_linear_observer_has_its_numbers_and_a_theorem_for_each_claim() {
    let file = CertificateFile::prove("of \"one\" state (* and *) more", linear(0.0)).unwrap();
    let coq = theorems(&file).unwrap();
    assert!(!coq.is_refuted);
    assert_eq!(coq.theorems, ["P_is_positive_definite", "inequality_12", "every_error", "observer", "errors_exist"]);
    for (name, entry) in [("A", "-0x1p0"), ("B", "0x1p0"), ("C", "0x1p0"), ("L", "0x1p0"), ("P", "0x1.8p1")] {
        assert!(coq.text.contains(&format!("Definition {name} : list (list Q) := [\n  [{entry}]].\n")), "{name}");
    }
    for name in &coq.theorems {
        assert!(coq.text.contains(&format!("\nTheorem {name} :\n")), "{name}");
    }
    // A title cannot end the comment, nor begin a string in it.
    assert!(coq.text.starts_with("(** of 'one' state ( * and * ) more\n"));
    // The margins are those that the file claims: 3 and 12, less their 2^-20 part.
    for (name, margin) in [("margin_P", 3.0), ("margin_12", 12.0)] {
        assert!((1.0 - defined(&coq, name) / margin - 0.5_f64.powi(20)).abs() < 1e-9, "{name}");
    }
    // V' = -4 V: the rate is 2, and P between 3 and 3.
    assert!((0.0..1e-12).contains(&(2.0 - defined(&coq, "decay"))));
    assert!((0.0..1e-12).contains(&(3.0 - defined(&coq, "lower"))));
    assert!((0.0..1e-12).contains(&(defined(&coq, "upper") - 3.0)));
    let overshoot = defined(&coq, "overshoot");
    assert!(overshoot * overshoot * defined(&coq, "lower") >= defined(&coq, "upper"));
}

#[test]
fn a_rate_of_the_certificate_is_that_of_the_theorem() {
    let coq = theorems(&CertificateFile::prove("rate", linear(1.5)).unwrap()).unwrap();
    assert_eq!((defined(&coq, "rate"), defined(&coq, "decay")), (1.5, 1.5));
}

/// `x+ = x / 2 + u` with the gain 1/4: `F = 1/4`, and `F'PF - P = -15/16 P`.
#[test]
fn without_a_factor_one_follows_from_the_margin() {
    let mut theorem = DiscreteConvergence {
        plant: PlantMatrices { a: one(0.5), ..plant() },
        l: one(0.25),
        p: one(2.0),
        factor: None,
    };
    let coq = theorems(&CertificateFile::prove("discrete", theorem.clone()).unwrap()).unwrap();
    assert_eq!(coq.theorems, ["P_is_positive_definite", "stein_inequality", "every_error", "observer"]);
    assert!((0.0..1e-12).contains(&(defined(&coq, "contraction") - 0.25)));
    theorem.factor = Some(0.75);
    let coq = theorems(&CertificateFile::prove("discrete", theorem).unwrap()).unwrap();
    assert_eq!((defined(&coq, "factor"), defined(&coq, "contraction")), (0.75, 0.75));
}

#[test]
fn a_false_certificate_has_its_refutation() {
    let file = CertificateFile::prove("false", linear(0.0)).unwrap();
    let coq = theorems(&changed(&file, "[\"0x1.8p1\"]", "[\"-0x1.8p1\"]")).unwrap();
    assert!(coq.is_refuted);
    assert_eq!(coq.theorems, ["P_is_not_positive_definite", "inequality_12_is_false"]);
    assert!(coq.text.contains("exists v : vector, 0 < square 1 v /\\ quadratic 1 P v <= 0"));
    let coq = theorems(&changed(&file, "[\"-0x1p0\"]", "[\"0x1.8p1\"]")).unwrap();
    assert_eq!(coq.theorems, ["P_is_positive_definite", "inequality_12_is_false"]);
    // F = 2 and P = -3: (12) holds with the margin 12, and what is claimed of it is not decided.
    let mut claims = file.claims().to_vec();
    claims[1].margin = "100".parse().unwrap();
    let unstable = changed(&file.with_claims(&claims).unwrap(), "[\"-0x1p0\"]", "[\"0x1.8p1\"]");
    let coq = theorems(&changed(&unstable, "\"P\": [\n      [\"0x1.8p1\"]", "\"P\": [\n      [\"-0x1.8p1\"]")).unwrap();
    assert_eq!(coq.theorems, ["P_is_not_positive_definite", "inequality_12"]);
    assert!((0.0..1e-12).contains(&(12.0 - defined(&coq, "margin_12"))));
}

/// What is rejected for its margin, its digest or its words is no theorem and no refutation.
#[test]
fn a_rejected_certificate_has_no_file() {
    let file = CertificateFile::prove("claims", linear(0.0)).unwrap();
    let mut claims = file.claims().to_vec();
    claims[0].margin = "4".parse().unwrap();
    let larger = file.with_claims(&claims).unwrap();
    assert!(matches!(theorems(&larger), Err(CoqError::Rejected(Rejection::Margin { .. }))));
    let text = file.to_json().replace("\"title\": \"claims\"", "\"title\": \"other\"");
    let unsealed = CertificateFile::read(text.as_bytes()).unwrap();
    assert!(matches!(theorems(&unsealed), Err(CoqError::Rejected(Rejection::Digest { .. }))));
}

/// A margin that is claimed to be 0 says no more than `>=`: the theorem has the one that is proved.
#[test]
fn a_claim_of_0_is_replaced() {
    let file = CertificateFile::prove("claims", linear(0.0)).unwrap();
    let mut claims = file.claims().to_vec();
    claims[0].margin = "0".parse().unwrap();
    let coq = theorems(&file.with_claims(&claims).unwrap()).unwrap();
    assert!((0.0..1e-12).contains(&(3.0 - defined(&coq, "margin_P"))));
}

#[test]
fn what_is_not_proved_in_coq_is_named() {
    let hurwitz = HurwitzStability::new(&one(-1.0), &one(1.0)).unwrap();
    let error = theorems(&CertificateFile::prove("hurwitz", hurwitz).unwrap()).unwrap_err();
    assert!(error.to_string().starts_with("the theorem \"hurwitz\" has no proof in Coq: of \"linear-observer\""));
    let mut within = linear(0.0);
    within.plant = PlantWithin::within(&interval(-1.5, -1.0), &interval(1.0, 1.0), &interval(1.0, 1.0)).unwrap();
    // A from -3/2 to -1: F'P + PF = 6 F is at most -12.
    let file = CertificateFile::prove("within", within).unwrap();
    let coq = theorems(&file).unwrap();
    assert_eq!(coq.theorems, ["P_is_positive_definite", "inequality_12", "every_error", "observer"]);
    assert!(coq.text.contains("Definition A_low : list (list Q) := [\n  [-0x1.8p0]].\n"));
    assert!(coq.text.contains("Definition A_high : list (list Q) := [\n  [-0x1p0]].\n"));
    assert!((0.0..1e-9).contains(&(2.0 - defined(&coq, "decay"))));
}

/// `x' = a x + u`, `y = x` with the gain 1 and P = 3: F'P + PF = 6 (a - 1).
#[test]
fn data_between_bounds_are_refuted_by_matrices_between() {
    let mut within = linear(0.0);
    within.plant = PlantWithin::within(&interval(-1.5, -1.0), &interval(1.0, 1.0), &interval(1.0, 1.0)).unwrap();
    let file = CertificateFile::prove("within", within).unwrap();
    // P = -3: -6 (a - 1) is largest at a = -3/2.
    let coq = theorems(&changed(&file, "[\"0x1.8p1\"]", "[\"-0x1.8p1\"]")).unwrap();
    assert!(coq.is_refuted);
    assert_eq!(coq.theorems, ["P_is_not_positive_definite", "inequality_12_is_false"]);
    assert!(coq.text.contains("Definition A_false : list (list Q) := [\n  [-0x1.8p0]].\n"));
    // A from -3/2 to 2, which the checker does not decide: at a = 2 it is false.
    let undecided = changed(&file, "\"-0x1p0\"", "\"0x1p1\"");
    assert!(undecided.check().is_err_and(|why| why.to_string().contains("is not proved")));
    let coq = theorems(&undecided).unwrap();
    assert_eq!(coq.theorems, ["P_is_positive_definite", "inequality_12_is_false"]);
    assert!(coq.text.contains("Definition A_false : list (list Q) := [\n  [0x1p1]].\n"));
    assert!(coq.text.contains("exists A C : matrix, within 1 1 A_low A_high A /\\ within 1 1 C_low C_high C /\\"));
}

/// In discrete time F = a - 1/4 with a from 1/4 to 1/2; the block [1, F; F, 1] is at least 3/4.
#[test]
fn a_polytope_of_boxes_in_discrete_time_has_the_bounds_of_each() {
    let vertices = [(0.25, 0.5), (0.25, 0.25)]
        .map(|(lo, hi)| Vertex::within(&interval(lo, hi), &interval(1.0, 1.0)).unwrap())
        .to_vec();
    let polytope = DiscreteJacobianPolytope { vertices, l: one(0.25), p: one(1.0), factor: 1.0 };
    let file = CertificateFile::prove("boxes", polytope).unwrap();
    let coq = theorems(&file).unwrap();
    assert_eq!(coq.theorems, ["P_is_positive_definite", "inequality_1", "inequality_2", "every_error"]);
    for (name, entry) in [("A_low_1", "0x1p-2"), ("A_high_1", "0x1p-1"), ("A_high_2", "0x1p-2"), ("C_low_1", "0x1p0")] {
        assert!(coq.text.contains(&format!("Definition {name} : list (list Q) := [\n  [{entry}]].\n")), "{name}");
    }
    // With |F| at most 1/4 it is at least that, and the checker bounds the whole box by its middle.
    assert!((0.5..0.57).contains(&defined(&coq, "contraction")));
    // a from 1/4 to 2: F = 7/4.
    let coq = theorems(&changed(&file, "\"0x1p-1\"", "\"0x1p1\"")).unwrap();
    assert_eq!(coq.theorems, ["P_is_positive_definite", "inequality_1_is_false", "inequality_2"]);
    assert!(coq.text.contains("Definition A_false_1 : list (list Q) := [\n  [0x1p1]].\n"));
}

/// N = -1/3 rounded, P = 3, S = 1: `P N + C'S` is not 0, and another P has the structure exactly.
#[test]
fn a_stored_cubic_gain_has_a_lyapunov_matrix_of_its_own() {
    let n = one(-1.0 / 3.0);
    let cubic = |n: Matrix<f64>, region| CubicConvergence {
        plant: plant(),
        l: one(1.0),
        n,
        theta: one(1.0),
        p: one(3.0),
        s: one(1.0),
        rate: 0.0,
        region,
    };
    let coq = theorems(&CertificateFile::prove("cubic", cubic(n.clone(), Region::Everywhere)).unwrap()).unwrap();
    assert_eq!(coq.theorems[coq.theorems.len() - 2..], ["stored_gain_observer", "stored_gain_errors_exist"]);
    assert!(!coq.text.contains("Definition P_stored : list (list Q) := [\n  [0x1.8p1]]."));
    // V' = -4 V for this V, too.
    assert!((0.0..1e-6).contains(&(2.0 - defined(&coq, "decay_stored"))));
    // N = -1/4 with P = 4 and S = 1: P itself.
    let exact = CubicConvergence { p: one(4.0), ..cubic(one(-0.25), Region::Everywhere) };
    let coq = theorems(&CertificateFile::prove("cubic", exact).unwrap()).unwrap();
    assert!(coq.text.contains("Definition P_stored : list (list Q) := [\n  [0x1p2]]."));
    // From an ellipsoid: F'P + PF = -12 and S + S' = 2, P itself.
    let coq = theorems(&CertificateFile::prove("cubic", cubic(n, Region::Within(1.0))).unwrap()).unwrap();
    assert_eq!(coq.theorems[coq.theorems.len() - 2..], ["stored_gain_every_error", "stored_gain_errors_exist"]);
    assert!(coq.text.contains("forall e0 : vector, quadratic 1 P e0 < level -> exists e : R -> vector,"));
    for (name, value) in [("q", 12.0), ("mu", 2.0), ("t", 1.0), ("kappa", 1.0), ("level", 1.0), ("decay_stored", 2.0)] {
        assert!((defined(&coq, name) / value - 1.0).abs() < 1e-9, "{name}");
    }
    assert!((0.0..1e-16).contains(&defined(&coq, "rho")));
}

/// P = 4, S = 1, N = -1/4: `P N = -C'S` exactly, of the plant `x' = -x + u` with the gain 1.
fn cubic() -> CubicConvergence {
    CubicConvergence {
        plant: plant(),
        l: one(1.0),
        n: one(-0.25),
        theta: one(1.0),
        p: one(4.0),
        s: one(1.0),
        rate: 0.0,
        region: Region::Everywhere,
    }
}

/// With K = 1 and P1 = 1, (25) is [-4, 1; 1, -16]; `[-4 + 2a, 1; 1, -16 + 8a] <= 0` up to 16 (2 - a)^2 = 1, a = 7/4.
#[test]
fn a_loop_has_a_rate_of_its_own_and_two_theorems() {
    let feedback = |p1: f64| FeedbackLoop { observer: cubic(), k: one(1.0), p1: one(p1) };
    let file = CertificateFile::prove("loop", feedback(1.0)).unwrap();
    let coq = theorems(&file).unwrap();
    let expected = [
        "P_is_positive_definite",
        "inequality_12",
        "theta_is_positive_semidefinite",
        "S_is_positive_semidefinite",
        "real_gain_exists",
        "real_gain_every_error",
        "real_gain_observer",
        "real_gain_errors_exist",
        "stored_gain_every_error",
        "stored_gain_observer",
        "stored_gain_errors_exist",
        "P1_is_positive_definite",
        "inequality_25",
        "real_gain_loop",
        "real_gain_loops_exist",
        "stored_gain_loop",
        "stored_gain_loops_exist",
    ];
    assert_eq!(coq.theorems, expected);
    for name in ["decay_loop", "decay_stored_loop"] {
        assert!((1.74..=1.75).contains(&defined(&coq, name)), "{name} {}", defined(&coq, name));
    }
    // P1 = 1 and P = 4: |x|^2 + |e|^2 <= W <= 4 (|x|^2 + |e|^2).
    assert!((0.0..1e-12).contains(&(defined(&coq, "overshoot_loop") - 2.0)));
    // P1 = 100: [-400, 100; 100, -16] has the determinant -3600.
    let coq = theorems(&changed(&file, "\"P1\": [\n      [\"0x1p0\"]", "\"P1\": [\n      [\"0x1.9p6\"]")).unwrap();
    assert!(coq.is_refuted);
    assert_eq!(coq.theorems.last().map(String::as_str), Some("inequality_25_is_false"));
}

/// P = 3, S = 1, N = -1/3 rounded, from e'Pe below 1: F'P + PF = -12. With K = 1 and P1 = 1 the state has
/// [-4 + 2a, 1; 1, 6a - 12] <= 0 up to (4 - 2a)(12 - 6a) = 1, a = 2 - 1/sqrt(12).
#[test]
fn a_loop_from_an_ellipsoid_has_a_share_of_the_rate() {
    let observer = CubicConvergence { n: one(-1.0 / 3.0), p: one(3.0), region: Region::Within(1.0), ..cubic() };
    let file = CertificateFile::prove("loop", FeedbackLoop { observer, k: one(1.0), p1: one(1.0) }).unwrap();
    let coq = theorems(&file).unwrap();
    let expected = [
        "stored_gain_every_error",
        "stored_gain_errors_exist",
        "P1_is_positive_definite",
        "inequality_25",
        "real_gain_loop",
        "real_gain_loops_exist",
        "stored_gain_loop",
        "stored_gain_loops_exist",
    ];
    assert_eq!(coq.theorems[coq.theorems.len() - expected.len()..], expected);
    let fastest = 2.0 - 1.0 / 12.0_f64.sqrt();
    // A smaller multiple of P1 is faster, up to 2.
    assert!((fastest * 0.99..2.0).contains(&defined(&coq, "decay_stored_loop")));
    assert!(coq.text.contains("quadratic 1 P (e 0) < level ->"));
}

/// `F = 1/4`, `w A + A N C = 3/4` with w = 1: V falls by 9/16 at least.
#[test]
fn a_sampled_cubic_observer_contracts_by_the_slower_end() {
    let [a, b, c] = [0.5, 1.0, 1.0].map(one);
    let sampled = SampledCubicConvergence {
        plant: PlantMatrices { a, b, c },
        l: one(0.25),
        n: one(0.5),
        theta: one(1.0),
        w: 1.0,
        period: 0.125,
        p: one(1.0),
    };
    let file = CertificateFile::prove("sampled", sampled).unwrap();
    let coq = theorems(&file).unwrap();
    assert_eq!(
        coq.theorems,
        ["P_is_positive_definite", "stein_inequality", "inequality_at_the_end", "every_error", "observer"]
    );
    assert!((0.0..1e-12).contains(&(defined(&coq, "contraction") - 0.75)));
    // N = 8: w A + A N C = 4.5.
    let coq = theorems(&changed(&file, "\"N\": [\n      [\"0x1p-1\"]", "\"N\": [\n      [\"0x1p3\"]")).unwrap();
    assert_eq!(coq.theorems, ["P_is_positive_definite", "stein_inequality", "inequality_at_the_end_is_false"]);
}

/// `P N C + C'N'P = -2` with P = 4 and N = -1/4; with S it is `-C'(S + S')C`, too.
#[test]
fn a_gain_that_dissipates_has_its_theorem() {
    let CubicConvergence { plant, l, n, theta, p, s, .. } = cubic();
    let stored = CubicTheorem1 { plant: plant.clone(), l: l.clone(), n, theta: theta.clone(), p: p.clone() };
    let coq = theorems(&CertificateFile::prove("theorem 1", stored).unwrap()).unwrap();
    assert_eq!(
        coq.theorems[3..],
        ["inequality_13", "stored_gain_every_error", "stored_gain_observer", "stored_gain_errors_exist"]
    );
    assert!((0.0..1e-5).contains(&(2.0 - defined(&coq, "margin_13"))));
    let real = StructuredCubicConvergence { plant, l, theta, p, s, rate: 0.0 };
    let coq = theorems(&CertificateFile::prove("structured", real).unwrap()).unwrap();
    let expected =
        ["inequality_13", "real_gain_exists", "real_gain_every_error", "real_gain_observer", "real_gain_errors_exist"];
    assert_eq!(coq.theorems[3..], expected);
    assert!((0.0..1e-5).contains(&(2.0 - defined(&coq, "margin_S"))));
}

/// F = 1/4 and F = 0: the block [1, 1/4; 1/4, 1] is at least 3/4, from which V falls by 1/4.
#[test]
fn a_polytope_in_discrete_time_has_an_inequality_for_each_vertex() {
    let vertex = |a: f64| Vertex::exactly(&one(a), &one(1.0)).unwrap();
    let polytope = |factor: f64| DiscreteJacobianPolytope {
        vertices: vec![vertex(0.5), vertex(0.25)],
        l: one(0.25),
        p: one(1.0),
        factor,
    };
    let coq = theorems(&CertificateFile::prove("hull", polytope(1.0)).unwrap()).unwrap();
    assert_eq!(coq.theorems, ["P_is_positive_definite", "inequality_1", "inequality_2", "every_error"]);
    assert!((0.0..1e-6).contains(&(defined(&coq, "contraction") - 0.5)));
    let coq = theorems(&CertificateFile::prove("hull", polytope(0.5)).unwrap()).unwrap();
    assert_eq!(defined(&coq, "contraction"), 0.5);
}

/// x' = -x/10, y = x, L = 1/5, N = 2: (A - L C)w = N for w = -20/3.
#[test]
fn a_gain_of_the_wrong_sign_is_refuted_with_the_decimals_of_the_paper() {
    let [a, c, l, n, theta] =
        [-0.1, 1.0, 0.2, 2.0, 10.0].map(|x| Matrix::from_rows([[Number::of_decimal(x).unwrap()]]));
    let data = WrongSign { a: &a, c: &c, l: &l, n: &n, theta: &theta };
    let coq = wrong_sign("a claim", &data).unwrap();
    assert_eq!(coq.theorems, ["no_matrix_for_13", "error_stands_still"]);
    for (name, entry) in [("A", "-1/10"), ("L", "1/5"), ("N", "0x1p1"), ("w", "-20/3")] {
        assert!(coq.text.contains(&format!("Definition {name} : list (list Q) := [\n  [{entry}]].\n")), "{name}");
    }
}

/// F = 7/8 - 3/8, in a byte with four bits behind the point. A sum is rounded by at most 1/32: y, z and the step, the
/// first two behind the gain, so that a step adds at most 3/8 (1/32 + 1/32) + 1/32 = 7/128, and 7/64 is the limit.
#[test]
fn a_deployed_observer_has_the_bound_of_its_steps() {
    let deployed = |step: Step, l: f64| {
        let plant = SampledPlant { a: one(0.875), b: Matrix::from_fn(1, 0, |_, _| 0.0), c: one(1.0) };
        let operation =
            Operation { state: vec![1.0], input: vec![], noise: vec![0.0], error: vec![1.0], deviation: None };
        let formats = Format::Fixed { integer_bits: 4, fraction_bits: 4 }.into();
        let derived = deployed_linear(&plant, &one(l), &one(1.0), step, formats, &operation).unwrap();
        let ball = derived.ball().map(Into::into);
        DeployedObserver { plant, stored: derived.stored, step, formats, operation, p: one(1.0), ball }
    };
    let file = CertificateFile::prove("a byte", deployed(Step::Accumulated, 0.375)).unwrap();
    let coq = theorems(&file).unwrap();
    assert_eq!(coq.theorems, ["P_is_positive_definite", "stein_inequality", "every_error", "running"]);
    for (name, value) in [("contraction", 0.5), ("beta", 7.0 / 128.0), ("limit", 7.0 / 64.0), ("start", 1.0)] {
        assert!((defined(&coq, name) / value - 1.0).abs() < 1e-5, "{name} {}", defined(&coq, name));
    }
    assert_eq!(defined(&coq, "kappa"), 0.0);
    assert!(coq.text.contains("Rabs (e (S k) i - (A * e k - L * (C * e k))%vector i)"));
    let joined = theorems(&CertificateFile::prove("a byte", deployed(Step::Joined, 0.375)).unwrap()).unwrap();
    assert_eq!(joined.theorems, coq.theorems);
    assert!(joined.text.contains("Definition F : list (list Q) := [\n  [0x1p-1]].\n"));
    // That a stored number is not the nearest to the plant's refutes no inequality.
    let other = changed(&file, "\"A\": [\n      [\"0x1.cp-1\"]", "\"A\": [\n      [\"0x1.8p-1\"]");
    assert!(matches!(theorems(&other), Err(CoqError::Rejected(Rejection::NotProved { .. }))));
    let other = changed(&file, "\"P\": [\n      [\"0x1p0\"]", "\"P\": [\n      [\"-0x1p0\"]");
    // F'PF - P = -1/4 + 1.
    assert_eq!(theorems(&other).unwrap().theorems, ["P_is_not_positive_definite", "stein_inequality_is_false"]);
}

/// Two boxes: A from -3/2 to -1, and A = -2; F'P + PF = 6 F is at most -12, and -18.
#[test]
fn a_polytope_of_boxes_has_the_bounds_of_each() {
    let vertices = [(-1.5, -1.0), (-2.0, -2.0)]
        .map(|(lo, hi)| Vertex::within(&interval(lo, hi), &interval(1.0, 1.0)).unwrap())
        .to_vec();
    let polytope = PlantPolytope { vertices, l: one(1.0), p: one(3.0), rate: 0.0 };
    let coq = theorems(&CertificateFile::prove("boxes", polytope).unwrap()).unwrap();
    assert_eq!(coq.theorems, ["P_is_positive_definite", "inequality_12_1", "inequality_12_2", "every_error"]);
    for (name, entry) in [("A_low_1", "-0x1.8p0"), ("A_high_1", "-0x1p0"), ("A_low_2", "-0x1p1"), ("C_high_2", "0x1p0")]
    {
        assert!(coq.text.contains(&format!("Definition {name} : list (list Q) := [\n  [{entry}]].\n")), "{name}");
    }
    assert!((0.0..1e-9).contains(&(2.0 - defined(&coq, "decay"))));
}
