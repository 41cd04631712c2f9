//! Certificate files that are wrong: every way is an error that names line and field, in bounded time and memory,
//! without a panic; and the program that checks files.

use std::io::Write;
use std::process::{Command, Output, Stdio};

use luenberger_proof::certificate::{
    CertificateFile, Claim, ClaimedBall, Coefficient, Constraint, Definiteness, DeployedObserver, Equation,
    HurwitzStability, InequalityHolds, InequalityRefuted, LARGEST_FILE, LinearConvergence, MatrixInequality, Number,
    PlantMatrices, PlantWithin, Rejection, SampledCubicConvergence, SchurStability, SemidefiniteEvidence,
    SemidefiniteProgram, Sign, SolutionWithin, Theorem, VERSION, digest, verify,
};
use luenberger_proof::semidefinite::{Block, DualBlock, Entry, Program};
use luenberger_proof::statement::{
    CubicGains, Format, Operation, SampledPlant, Step, deployed_linear, deployed_sampled_cubic,
};
use luenberger_proof::{Exact, Interval, Matrix};
use proptest::prelude::*;

/// A double integrator with poles at -2 and -5: F'P + PF = -14 I exactly.
fn integrator() -> Theorem {
    let a = Matrix::from_rows([[0.0, 1.0], [0.0, 0.0]]);
    let (b, c) = (Matrix::from_rows([[0.0], [1.0]]), Matrix::from_rows([[1.0, 0.0]]));
    let plant = PlantWithin::exactly(&a, &b, &c).expect("finite");
    let (l, p) = (Matrix::from_rows([[7.0], [10.0]]), Matrix::from_rows([[11.0, -7.0], [-7.0, 6.0]]));
    LinearConvergence { plant, l, p, rate: 0.0 }.into()
}

fn file(theorem: Theorem) -> CertificateFile {
    CertificateFile::prove("a test", theorem).expect("proved")
}

fn text() -> String {
    file(integrator()).to_json()
}

/// The text with the words and the digest that its data call for, so that only the mathematics can object.
fn resealed(text: &str) -> String {
    let with_digest = |text: &str| {
        let at = text.find("\"sha256\": \"").expect("sealed") + 11;
        format!("{}{}{}", &text[..at], digest(text.as_bytes()).expect("JSON"), &text[at + 64..])
    };
    let sealed = with_digest(text);
    match CertificateFile::read(sealed.as_bytes()) {
        Ok(file) => {
            let quoted = |words: &str| words.replace('\\', "\\\\").replace('"', "\\\"");
            with_digest(&sealed.replace(&quoted(file.statement()), &quoted(&file.theorem().words())))
        }
        Err(_) => sealed,
    }
}

fn why(text: &str) -> String {
    verify(text.as_bytes()).expect_err(text).to_string()
}

fn holds() -> InequalityHolds {
    // [[x, 1], [1, x]] > 0 at x = 2.
    let entry = |unknown, row, column, value: &str| Coefficient {
        unknown,
        row,
        column,
        value: value.parse().expect("a number"),
    };
    let entries = vec![entry(0, 0, 1, "1"), entry(1, 0, 0, "1"), entry(1, 1, 1, "1")];
    let constraints = vec![Constraint { name: "M > 0".to_owned(), order: 2, entries }];
    InequalityHolds { inequalities: MatrixInequality { unknowns: 1, strict: true, constraints }, x: vec![2.0] }
}

fn refuted() -> InequalityRefuted {
    // x > 0 and -x - 1/2 > 0.
    let entry =
        |unknown, value: &str| Coefficient { unknown, row: 0, column: 0, value: value.parse().expect("a number") };
    let constraint = |name: &str, entries| Constraint { name: name.to_owned(), order: 1, entries };
    let constraints =
        vec![constraint("x > 0", vec![entry(1, "1")]), constraint("x < -1/2", vec![entry(1, "-1"), entry(0, "-1/2")])];
    let one = || Matrix::from_rows([[Exact::power_of_two(0)]]);
    InequalityRefuted {
        inequalities: MatrixInequality { unknowns: 1, strict: true, constraints },
        multipliers: vec![one(), one()],
    }
}

fn program() -> SemidefiniteProgram {
    // minimise x subject to [[x, 1], [1, x]] >= 0: the optimum is 1.
    let point = |x: f64| Interval::around(x, 0.0).expect("finite");
    let entry = |row, column, value| Entry { block: 0, row, column, value: point(value) };
    let matrices = vec![vec![entry(0, 1, -1.0)], vec![entry(0, 0, 1.0), entry(1, 1, 1.0)]];
    let program = Program::new(vec![Block::Dense(2)], vec![point(1.0)], matrices).expect("a program");
    let y = Matrix::from_rows([[0.5, -0.499], [-0.499, 0.5]]);
    let lower = Some((0.99, vec![DualBlock::Dense(y)]));
    SemidefiniteProgram { program, evidence: SemidefiniteEvidence::Bounds { lower, upper: Some((1.01, vec![1.005])) } }
}

/// x+ = [[1, 0.1], [0, 1]]x in f32, and the same joined in Q4.20.
fn deployed(step: Step, format: Format) -> DeployedObserver {
    let plant = SampledPlant {
        a: Matrix::from_rows([[1.0, 0.1], [0.0, 1.0]]),
        b: Matrix::from_rows([[0.005], [0.1]]),
        c: Matrix::from_rows([[1.0, 0.0]]),
    };
    // Poles at 0.5 and 0.6, and a P that decreases there.
    let (l, p) = (Matrix::from_rows([[0.9], [2.0]]), Matrix::from_rows([[11.0, -2.25], [-2.25, 0.5625]]));
    let operation =
        Operation { state: vec![1.0; 2], input: vec![1.0], noise: vec![0.0], error: vec![1.0; 2], deviation: None };
    let found = deployed_linear(&plant, &l, &p, step, format.into(), &operation).expect("it fits");
    let ball = found.ball().map(ClaimedBall::from);
    DeployedObserver { plant, stored: found.stored, step, formats: format.into(), operation, p, ball }
}

fn solution() -> SolutionWithin {
    let points = |m: Matrix<f64>| m.map(|x| Interval::around(*x, 0.0).expect("finite"));
    let a = points(Matrix::from_rows([[0.0, 1.0], [-2.0, -3.0]]));
    let q = points(Matrix::from_rows([[1.0, 0.0], [0.0, 1.0]]));
    let near = [Matrix::from_rows([[1.25, 0.25], [0.25, 0.25]])];
    SolutionWithin::derive(Equation::Lyapunov, &a, &q, &near, None).expect("unique")
}

fn all() -> Vec<Theorem> {
    let a = Matrix::from_rows([[0.5, 0.25], [0.0, -0.5]]);
    let identity = Matrix::from_rows([[1.0, 0.0], [0.0, 1.0]]);
    let stable = Matrix::from_rows([[-1.0, 0.25], [0.0, -2.0]]);
    vec![
        integrator(),
        HurwitzStability::new(&stable, &identity).expect("finite").into(),
        SchurStability { a, p: identity.clone() }.into(),
        Definiteness::new(&identity, Sign::PositiveDefinite).expect("finite").into(),
        holds().into(),
        refuted().into(),
        program().into(),
        deployed(Step::Innovation, Format::Binary32).into(),
        deployed(Step::Joined, Format::Fixed { integer_bits: 8, fraction_bits: 24 }).into(),
        solution().into(),
    ]
}

#[test]
fn what_is_written_is_read_and_proved() {
    for theorem in all() {
        let file = file(theorem.clone());
        let again = CertificateFile::read(file.to_json().as_bytes()).expect("written by the writer");
        assert_eq!(again.theorem(), &theorem);
        assert_eq!(again.to_json(), file.to_json());
        let proved = verify(file.to_json().as_bytes()).unwrap_or_else(|why| panic!("{}: {why}", theorem.name()));
        assert!(proved.facts.iter().all(|fact| fact.verdict.is_proved()) && !proved.facts.is_empty());
        assert_eq!(proved.statement, theorem.words());
    }
}

#[test]
fn a_file_is_for_people() {
    let text = text();
    assert!(
        text.contains("    \"A\": [\n      [\"0x0p0\", \"0x1p0\"],\n      [\"0x0p0\", \"0x0p0\"]\n    ],"),
        "{text}"
    );
    assert!(text.contains("For the plant x' = Ax + Bu, y = Cx with 2 states, 1 input and 1 output and the observer"));
}

#[test]
fn white_space_and_order_do_not_matter_to_the_digest() {
    let text = text();
    assert!(verify(text.replace('\n', "\r\n").as_bytes()).is_ok());
    let moved =
        text.replacen("  \"version\": 2,\n", "", 1).replacen("  \"title\"", "  \"version\": 2,\n  \"title\"", 1);
    assert!(verify(moved.as_bytes()).is_ok());
}

/// A fraction that binary64 does not have is enclosed, and the words say so; the proof holds for the fraction.
#[test]
fn fractions_of_plant_data_are_enclosed() {
    let thirds = resealed(&text().replacen("[\"0x0p0\", \"0x1p0\"]", "[\"0x0p0\", [\"1\", \"10/9\"]]", 1));
    let proved = verify(thirds.as_bytes()).err().map(|why| why.to_string());
    // The margin of 14 was that of the entry 1.
    assert!(
        proved
            .expect("a smaller margin")
            .contains("margins[1].margin: (A - LC)'P + P(A - LC) < 0 (12) is proved with the margin")
    );
    let claimed = file(integrator()).claims()[1].margin.to_string();
    let looser = resealed(&thirds.replace(&format!("\"margin\": \"{claimed}\""), "\"margin\": \"5/3\""));
    let proved = verify(looser.as_bytes()).expect("proved between the bounds");
    assert!(proved.statement.ends_with("the statement holds for every choice of them."), "{}", proved.statement);
}

/// 2^-1100, which binary64 does not have, stands for all numbers between its neighbours 0 and 2^-1074: 0 is not
/// positive.
#[test]
fn a_power_of_two_below_the_range_of_binary64_is_enclosed_too() {
    let one = Definiteness::new(&Matrix::from_rows([[1.0]]), Sign::PositiveDefinite).expect("finite");
    let one = file(one.into()).to_json();
    let tiny = format!("\"1/{}\"", power_of_two_in_decimal(1100));
    let tiny = one.replacen("\"0x1p0\"", &tiny, 1).replacen("\"margin\": \"0x1p0\"", "\"margin\": \"0\"", 1);
    let found = why(&resealed(&tiny));
    assert!(found.starts_with("M > 0 is not proved: the data are known only up to intervals"), "{found}");
}

/// In decimal digits.
fn power_of_two_in_decimal(exponent: usize) -> String {
    let mut digits = vec![1_u8];
    for _ in 0..exponent {
        let mut carry = 0;
        for digit in &mut digits {
            (*digit, carry) = ((2 * *digit + carry) % 10, (2 * *digit + carry) / 10);
        }
        digits.extend((carry > 0).then_some(carry));
    }
    digits.iter().rev().map(|digit| char::from(b'0' + digit)).collect()
}

#[test]
fn a_margin_is_believed_up_to_the_last_bit_and_no_further() {
    for theorem in all() {
        let file = file(theorem);
        for k in 0..file.claims().len() {
            let margin = file.claims()[k].margin.to_f64().expect("binary64");
            let with = |margin: f64| {
                let mut claims = file.claims().to_vec();
                claims[k] = Claim { margin: Number::from_f64(margin).expect("finite"), ..claims[k].clone() };
                file.with_claims(&claims).expect("written").check()
            };
            assert!(with(margin).is_ok() && (margin == 0.0 || with(margin.next_down()).is_ok()));
            assert!(with(0.0).is_ok());
            match with(margin.next_up()) {
                Err(Rejection::Margin { index, claimed, proved, .. }) => {
                    assert_eq!((index, claimed.to_f64(), proved.to_f64()), (k, Some(margin.next_up()), Some(margin)));
                }
                other => panic!("{other:?}"),
            }
            assert!(matches!(with(-1.0), Err(Rejection::Margin { .. })));
        }
    }
}

/// Each is wrong in one way; the message names the line and the field.
#[test]
fn bad_files_say_what_is_wrong_and_where() {
    let text = text();
    let replaced = |from: &str, to: &str| {
        assert!(text.contains(from), "{from}");
        why(&text.replacen(from, to, 1))
    };
    let cases = [
        (
            replaced("\"luenberger-certificate\"", "\"recipe\""),
            "line 2, format: \"recipe\" is unknown; known are \"luenberger-certificate\"",
        ),
        (
            replaced("\"version\": 2", "\"version\": 1"),
            "line 3, version: version 1 of the format is not known; this checker knows version 2",
        ),
        (
            replaced("\"version\": 2", "\"version\": \"2\""),
            "line 3, version: is a string, and should be a whole number",
        ),
        (replaced("  \"version\": 2,\n", ""), "line 1: the field \"version\" is missing"),
        (replaced("\"title\": \"a test\"", "\"title\": \" \""), "line 4, title: is empty"),
        (
            replaced("\"title\": \"a test\",", "\"title\": \"a test\",\n  \"title\": \"b\","),
            "line 5: the field \"title\" is given twice",
        ),
        (
            replaced("\"title\":", "\"author\": \"me\",\n  \"title\":"),
            "line 4: the field \"author\" does not belong here",
        ),
        (replaced("\"L\": [", "\"K\": [], \"L\": ["), "line 21, observer: the field \"K\" does not belong here"),
        (
            replaced("\"0x1.6p3\"", "\"0x1.zp0\""),
            "line 28, lyapunov.P[0][0]: \"0x1.zp0\" is not a hexadecimal float such as \"0x1.8p-3\"",
        ),
        (
            replaced("\"0x1.6p3\"", "\"NaN\""),
            "line 28, lyapunov.P[0][0]: \"NaN\" is not a number: write a hexadecimal float such as \"0x1.8p-3\", an integer, or a fraction such as \"42/85\"",
        ),
        (
            replaced("\"0x1.6p3\"", "11.0"),
            "line 28, lyapunov.P[0][0]: 11.0 is a decimal, which binary64 rounds in silence: write the fraction that is meant (one tenth is \"1/10\"), or the binary64 number that is stored, here \"0x1.6p3\"",
        ),
        (
            replaced("\"0x1.6p3\"", "\"42/85\""),
            "line 28, lyapunov.P[0][0]: 42/85 is no binary64 number: this quantity is not enclosed, it must be exact",
        ),
        (
            replaced("\"0x1.6p3\"", "\"0x1p1024\""),
            "line 28, lyapunov.P[0][0]: \"0x1p1024\" is beyond the largest binary64 number, 0x1.fffffffffffffp1023",
        ),
        (
            replaced("\"0x1.6p3\"", "null"),
            "line 28, lyapunov.P[0][0]: is null, and should be a number in quotes, such as \"0x1.8p-3\" or \"42/85\"",
        ),
        (
            replaced("[\"-0x1.cp2\", \"0x1.8p2\"]", "[\"-0x1.cp2\"]"),
            "line 29, lyapunov.P[1]: has 1 entries, and the first row has 2",
        ),
        (
            replaced("[\"-0x1.cp2\", \"0x1.8p2\"]", "[\"0x1.cp2\", \"0x1.8p2\"]"),
            "line 29, lyapunov.P[1][0]: is 0x1.cp2, and its mirror image is -0x1.cp2: the matrix must be symmetric",
        ),
        (replaced("[\"0x1.4p3\"]", "[\"0x1.4p3\"], [\"0x0p0\"]"), "line 21, observer.L: is 3 x 1, and should be 2 x 1"),
        (replaced("      [\"0x0p0\", \"0x1p0\"],\n", ""), "line 8, plant.A: is 1 x 2, and should be 1 x 1"),
        (replaced("      [\"0x1p0\", \"0x0p0\"]\n", ""), "line 16, plant.C: is empty"),
        (
            replaced("\"rate\": \"0x0p0\"", "\"rate\": \"-1\""),
            "line 31, lyapunov.rate: is -1, and a rate of decay is 0 or more",
        ),
        (
            replaced("\"linear-observer\"", "\"truth\""),
            &format!(
                "line 6, theorem: \"truth\" is unknown; known are {}",
                Theorem::NAMES.iter().map(|name| format!("\"{name}\"")).collect::<Vec<_>>().join(", ")
            ),
        ),
        (
            replaced("\"margin\": \"0x1.", "\"margin\": 14, \"note\": \"0x1."),
            "line 36, margins[0].margin: is a JSON number, and should be a number in quotes, such as \"0x1.8p-3\" or \"42/85\"",
        ),
    ];
    for (found, expected) in &cases {
        assert_eq!(found, expected);
    }
    for (broken, expected) in [
        (&text[..text.len() / 2], "the file ends where"),
        (
            &text.replacen("\"plant\": {", "\"plant\": [", 1),
            "line 8: ':' stands where a comma or the end of the array should be",
        ),
        (&format!("{text}{{}}"), "'{' stands where the end of the file should be"),
        (
            &text.replacen("a test", "a\ttest", 1),
            "line 4: '\\t' stands where the end of a string, which holds no control characters should be",
        ),
        ("", "line 1: the file ends where a value should be"),
    ] {
        assert!(why(broken).contains(expected), "{} against {expected}", why(broken));
    }
    let mut latin = text.clone().into_bytes();
    let at = text.find("a test").expect("the title");
    latin[at] = 0xff;
    assert_eq!(
        verify(&latin).expect_err("not UTF-8").to_string(),
        format!("line 4: the byte at position {at} is not UTF-8")
    );
}

#[test]
fn a_file_that_says_more_than_it_proves_is_rejected() {
    let text = text();
    // A digest that does not agree.
    assert!(why(&text.replace("a test", "a best")).contains("sha256: the digest of the content is"));
    let words = "e tends to 0 exponentially";
    let sealed = |text: String| {
        let at = text.find("\"sha256\": \"").expect("sealed") + 11;
        format!("{}{}{}", &text[..at], digest(text.as_bytes()).expect("JSON"), &text[at + 64..])
    };
    let boast = sealed(text.replacen(words, "e tends to 0 in finite time", 1));
    assert!(why(&boast).starts_with("line 5, statement: the words do not say what the data say; they should be"));
    let other = sealed(text.replacen("\"inequality\": \"P > 0\"", "\"inequality\": \"P > 1\"", 1));
    assert_eq!(why(&other), "line 36, margins[0].inequality: the inequality in this place is \"P > 0\"");
    let fewer = file(integrator()).with_claims(&[]).expect("written").to_json();
    assert!(why(&fewer).ends_with("margins: the theorem has 2 inequalities, and 0 are claimed"));
    // L with the wrong sign: false, and the direction that shows it.
    let unstable = resealed(&text.replacen("\"0x1.cp2\"", "\"-0x1.cp2\"", 1));
    assert!(why(&unstable).starts_with("(A - LC)'P + P(A - LC) < 0 (12) is false: v = ("), "{}", why(&unstable));
}

/// Each bound of a deployed observer: the next smaller one is one too many, and a larger one is true as well.
#[test]
fn bounds_of_a_running_error_are_believed_up_to_the_last_bit() {
    let prove = |theorem: DeployedObserver| {
        CertificateFile::prove("a test", theorem).map(|_| ()).map_err(|why| why.to_string())
    };
    for (step, format) in [
        (Step::Innovation, Format::Binary32),
        (Step::Joined, Format::Binary64),
        (Step::Joined, Format::Fixed { integer_bits: 8, fraction_bits: 24 }),
        (Step::Accumulated, Format::Fixed { integer_bits: 8, fraction_bits: 24 }),
    ] {
        let theorem = deployed(step, format);
        let ball = theorem.ball.clone().expect("a ball is proved");
        assert_eq!(prove(theorem.clone()), Ok(()));
        assert_eq!(prove(DeployedObserver { ball: None, ..theorem.clone() }), Ok(()));
        let with = |start: f64, entries: Vec<f64>| {
            prove(DeployedObserver { ball: Some(ClaimedBall { start, entries }), ..theorem.clone() })
        };
        assert_eq!(with(ball.start.next_up(), ball.entries.iter().map(|x| x.next_up()).collect()), Ok(()));
        let why = with(ball.start.next_down(), ball.entries.clone()).expect_err("too small");
        assert!(
            why.starts_with("sqrt(e'Pe) <= running.start at all times is not proved: at row 0, column 0 the bound")
        );
        for i in 0..2 {
            let mut entries = ball.entries.clone();
            entries[i] = entries[i].next_down();
            let why = with(ball.start, entries).expect_err("too small");
            assert!(why.starts_with(&format!("limsup |e_{}| <= running.limsup[{i}] is not proved", i + 1)), "{why}");
        }
        // Larger promises of what it meets: the bounds no longer hold.
        let mut more = theorem.clone();
        more.operation.state[0] *= 2.0;
        more.operation.noise[0] = 1e-3;
        let why = prove(more).expect_err("larger promises");
        assert!(why.starts_with("limsup |e_1| <=") && why.contains("which is tighter than"), "{why}");
    }
}

/// What is stored is compared with what rounding gives, to the last bit, and its own decrease is decided.
#[test]
fn stored_numbers_are_those_of_the_format() {
    let prove = |theorem: &DeployedObserver| {
        CertificateFile::prove("a test", theorem.clone()).expect_err("stored otherwise").to_string()
    };
    let theorem = deployed(Step::Innovation, Format::Binary32);
    let says = |why: String, entry: &str| {
        let start =
            format!("the stored numbers are those of binary32 nearest to the plant's is false: stored.{entry} is");
        assert!(why.starts_with(&start), "{why}");
    };
    let mut finer = theorem.clone();
    finer.stored.l[(1, 0)] = 2.0_f64.next_up();
    says(prove(&finer), "L[1][0]");
    let mut other = theorem.clone();
    other.stored.a[(0, 1)] = f64::from(0.1_f32.next_up());
    says(prove(&other), "A[0][1]");
    // The next f32 of a gain is another gain, stored as well: proved from its own numbers.
    let mut next = theorem.clone();
    next.stored.l[(0, 0)] = f64::from(0.9_f32.next_up());
    next.ball = None;
    assert!(CertificateFile::prove("a test", next.clone()).is_ok());
    // Of the wrong sign: the direction that shows it.
    next.stored.l[(0, 0)] = -f64::from(0.9_f32);
    assert!(prove(&next).starts_with("(A - LC)'P(A - LC) - P < 0 for the stored A, L and C is false: v = ("));
    // In a coarser format these are not the numbers, and in one too small they do not fit.
    let q4_12 = Format::Fixed { integer_bits: 4, fraction_bits: 12 };
    let coarser = DeployedObserver { formats: q4_12.into(), ..theorem.clone() };
    assert!(prove(&coarser).starts_with("the stored numbers are those of Q4.12 nearest to the plant's is false"));
    let q1_12 = Format::Fixed { integer_bits: 1, fraction_bits: 12 };
    let small = DeployedObserver { formats: q1_12.into(), ..theorem };
    assert_eq!(
        prove(&small),
        "the inequalities cannot be evaluated: L has the entry 2e0 at row 1, column 0, and its format ends at 9.99755859375e-1"
    );
}

#[test]
fn bad_files_of_deployed_observers_say_where() {
    let text = file(deployed(Step::Innovation, Format::Binary32).into()).to_json();
    let replaced = |from: &str, to: &str| {
        assert!(text.contains(from), "{from}: {text}");
        why(&text.replacen(from, to, 1))
    };
    for (found, expected) in [
        (
            replaced("\"stored\": \"binary32\"", "\"stored\": \"Q4\""),
            "formats.stored: \"Q4\" is unknown; known are \"binary32\", \"binary64\", \"Q4.12",
        ),
        (replaced("\"step\": \"innovation\"", "\"step\": \"hop\""), "step: \"hop\" is unknown; known are \"joined\""),
        (replaced("\"u\": [\"0x1p0\"]", "\"u\": []"), "operation.u: has 0 elements, and should have 1"),
        (
            replaced("\"u\": [\"0x1p0\"]", "\"u\": [\"-1\"]"),
            "operation.u[0]: is -1, and a bound of an absolute value is 0 or more",
        ),
        (replaced("\"start\"", "\"begin\""), "running: the field \"start\" is missing"),
    ] {
        assert!(found.contains(expected), "{found}");
    }
    // An unsupported format is rejected by the verification of the theorem.
    let wide = resealed(&text.replacen("\"stored\": \"binary32\"", "\"stored\": \"Q60.12\"", 1));
    assert!(why(&wide).contains("at least 1 integer bit and 2 to 53 bits in all are supported"), "{}", why(&wide));
    // Larger than is checked in seconds.
    let rows = vec![format!("[{}]", vec!["\"0x0p0\""; 33].join(",")); 33].join(",");
    let large = format!(
        "{}[{rows}]{}",
        &text[..text.find("\"A\": ").unwrap() + 5],
        &text[text.find(",\n    \"B\"").unwrap()..]
    );
    assert!(why(&large).contains("plant.A: is of order 33; the checker goes up to 32"), "{}", why(&large));
}

/// One end of one interval one unit narrower than the one derived, or another equation: rejected.
#[test]
fn intervals_of_a_solution_are_believed_up_to_the_last_bit() {
    let prove =
        |theorem: SolutionWithin| CertificateFile::prove("a test", theorem).map(|_| ()).map_err(|why| why.to_string());
    let theorem = solution();
    assert!(theorem.p[(0, 0)].contains(1.25) && theorem.p[(0, 1)].contains(0.25) && theorem.p[(1, 1)].contains(0.25));
    assert_eq!(prove(theorem.clone()), Ok(()));
    for (i, j) in [(0, 0), (0, 1), (1, 1)] {
        let (lo, hi) = (theorem.p[(i, j)].lo(), theorem.p[(i, j)].hi());
        let with = |lo: f64, hi: f64| {
            let mut claimed = theorem.clone();
            claimed.p[(i, j)] = Interval::new(lo, hi).expect("in order");
            claimed.p[(j, i)] = claimed.p[(i, j)];
            prove(claimed)
        };
        assert_eq!(with(lo.next_down(), hi.next_up()), Ok(()));
        // A point cannot be made narrower; it can be moved.
        for narrower in [with(lo.next_up(), hi.next_up()), with(lo.next_down(), hi.next_down())] {
            let why = narrower.expect_err("narrower by one unit");
            let start = format!(
                "A'P + PA + Q = 0 has one solution, and it lies in P is not proved: at row {i}, column {j} the bound"
            );
            assert!(why.starts_with(&start), "{why}");
        }
    }
    let stein = SolutionWithin { equation: Equation::Stein, ..theorem.clone() };
    assert!(prove(stein).expect_err("another equation").starts_with("A'PA - P + Q = 0 has one solution"));
    // A and Q known up to a little more than they were: the solutions of all of them do not lie there.
    let text = file(theorem.into()).to_json();
    let wider = resealed(&text.replacen("\"-0x1.8p1\"", "[\"-3\", \"-2999999/1000000\"]", 1));
    assert!(why(&wider).contains("which is tighter than"), "{}", why(&wider));
    let fraction = text.rfind("\"P\": [").expect("the claim");
    let thirds = format!("{}{}", &text[..fraction], text[fraction..].replacen("\"0x1p-2\"", "\"1/3\"", 1));
    if thirds != text {
        assert!(why(&thirds).contains("1/3 is no binary64 number"), "{}", why(&thirds));
    }
    // An oscillator: its eigenvalues add to zero, and no solution is unique.
    let number = |x: f64| Matrix::from_rows([[Interval::around(x, 0.0).expect("finite")]]);
    let none = SolutionWithin::derive(Equation::Lyapunov, &number(0.0), &number(1.0), &[], None).expect_err("none");
    assert!(
        none.to_string().starts_with("A'P + PA + Q = 0 has one solution, and it lies in P is not proved"),
        "{none}"
    );
}

#[test]
fn multipliers_that_miss_an_equation_or_its_sign_are_rejected() {
    let prove = |theorem: InequalityRefuted| {
        CertificateFile::prove("a test", theorem).map(|_| ()).map_err(|why| why.to_string())
    };
    assert_eq!(prove(refuted()), Ok(()));
    let mut missed = refuted();
    missed.multipliers[0] = Matrix::from_rows([[Exact::power_of_two(1)]]);
    assert_eq!(
        prove(missed),
        Err("sum_k tr(F_ki Z_k) = 0 for every unknown x_i is false: the coefficient of x_1 is 1e0".to_owned())
    );
    let mut negative = refuted();
    negative.multipliers = vec![Matrix::from_rows([[Exact::new((-1).into(), 0)]]); 2];
    assert!(prove(negative).expect_err("negative").starts_with("Z >= 0 of \"x > 0\" is false"));
    let mut zero = refuted();
    zero.multipliers = vec![Matrix::zeros(1, 1), Matrix::zeros(1, 1)];
    assert_eq!(prove(zero), Err("the Z_k are not all zero is false: they are all zero".to_owned()));
    let mut feasible = refuted();
    feasible.inequalities.constraints[1].entries[1].value = "1/2".parse().expect("a number");
    assert_eq!(prove(feasible), Err("sum_k tr(F_k0 Z_k) <= 0 is false: the constant is 5e-1".to_owned()));
}

/// Every kind of theorem, in as few numbers as it has: those of [`all`], and the others by their fields.
fn every_kind() -> Vec<CertificateFile> {
    let plant = "\"plant\": {\"A\": [[\"-1\"]], \"B\": [[\"1\"]], \"C\": [[\"1\"]]}";
    let sampled = plant.replace("-1", "0x1p-1");
    let lyapunov = "\"lyapunov\": {\"P\": [[\"1\"]]}";
    let with_rate = "\"lyapunov\": {\"P\": [[\"1\"]], \"rate\": \"0\"}";
    let gain = "\"observer\": {\"L\": [[\"0\"]]}";
    let with_n = "\"observer\": {\"L\": [[\"0\"]], \"N\": [[\"-1\"]], \"theta\": [[\"1\"]]}";
    let with_s = "\"observer\": {\"L\": [[\"0\"]], \"theta\": [[\"1\"]], \"S\": [[\"1\"]]}";
    let cubic = format!(
        "{plant}, {with_n}, \"lyapunov\": {{\"P\": [[\"1\"]], \"S\": [[\"1\"]], \"rate\": \"0\", \"converges_from\": \"everywhere\"}}"
    );
    let vertices = format!("\"vertices\": [{{\"A\": [[\"-1\"]], \"C\": [[\"1\"]]}}], {gain}, {with_rate}");
    let others = [
        ("discrete-observer", format!("{sampled}, {gain}, {lyapunov}")),
        ("cubic-observer", cubic.clone()),
        ("cubic-observer-with-structured-gain", format!("{plant}, {with_s}, {with_rate}")),
        ("cubic-observer-theorem-1", format!("{plant}, {with_n}, {lyapunov}")),
        (
            "sampled-cubic-observer",
            format!("{sampled}, {}, {lyapunov}", with_n.replace("\"theta\"", "\"w\": \"1\", \"period\": \"0x1p-3\", \"theta\"")),
        ),
        (
            "sampled-cubic-observer-semi-implicit",
            format!(
                "{sampled}, {}, {}",
                with_n.replace("\"theta\"", "\"period\": \"0x1p-3\", \"theta\""),
                lyapunov.replace('}', ", \"S\": [[\"1\"]]}")
            ),
        ),
        (
            "sampled-observer-at-varying-periods",
            format!(
                "{plant}, \"observer\": {{\"step\": \"semi-implicit\", \"K\": [[\"0\"]], \"N\": [[\"-1\"]], \"theta\": [[\"1\"]]}}, \"periods\": {{\"shortest\": \"0x1p-1\", \"longest\": \"1\", \"misses\": 1}}, \"lyapunov\": {{\"P\": [[\"1\"]], \"S\": [[\"1\"]], \"factor\": \"0x1.cp-1\"}}"
            ),
        ),
        ("feedback-loop", format!("{cubic}, \"feedback\": {{\"K\": [[\"0\"]], \"P1\": [[\"1\"]]}}")),
        ("polytope-of-plants", vertices.clone()),
        ("polytope-of-jacobians", vertices),
        (
            "discrete-polytope-of-jacobians",
            format!(
                "\"vertices\": [{{\"A\": [[\"0x1p-1\"]], \"C\": [[\"1\"]]}}], {gain}, {}",
                with_rate.replace("\"rate\": \"0\"", "\"factor\": \"0x1.8p-1\"")
            ),
        ),
        (
            "sector-observer",
            format!(
                "\"plant\": {{\"A\": [[\"-1\"]], \"C\": [[\"1\"]], \"sectors\": [{{\"G\": [[\"0x1p-4\"]], \"H\": [[\"1\"]], \"low\": \"-1\", \"high\": \"1\", \"tau\": \"0x1p-2\"}}]}}, {gain}, {with_rate}"
            ),
        ),
        (
            "unknown-input-observer",
            "\"plant\": {\"A\": [[\"-1\", \"1\"], [\"0\", \"-1\"]], \"B\": [[], []], \"C\": [[\"1\", \"0\"]]}, \"E\": [[\"1\"], [\"0\"]], \"observer\": {\"L\": [[\"1\"], [\"0\"]]}, \"cubic\": {\"N\": [[\"-1\"], [\"0\"]], \"theta\": [[\"1\"]], \"X\": [[\"1\"]]}, \"lyapunov\": {\"P\": [[\"1\", \"0\"], [\"0\", \"1\"]], \"rate\": \"0\"}".to_owned(),
        ),
        (
            "input-to-state-stability",
            "\"plant\": {\"vertices\": [{\"A\": [[\"-1\"]], \"E\": [[\"1\", \"0\"]]}], \"C\": [[\"1\"]], \"D\": [[\"0\", \"1\"]]}, \"observer\": {\"L\": [[\"0\"]]}, \"cubic\": {\"N\": [[\"-1\"]], \"theta\": [[\"1\"]], \"X\": [[\"1\"]], \"kappa\": \"2\", \"mu\": [\"1\", \"2\"]}, \"lyapunov\": {\"P\": [[\"1\"]], \"rate\": \"0x1p-2\", \"lambda\": [\"2\", \"1\"]}, \"bounds\": {\"w\": [\"1\", \"1\"], \"level\": \"16\", \"limsup\": [\"8\"]}".to_owned(),
        ),
        (
            "reduced-order-observer",
            "\"plant\": {\"A\": [[\"0\", \"1\"], [\"0\", \"0\"]], \"B\": [[], []], \"C\": [[\"1\", \"0\"]]}, \"observer\": {\"T\": [[\"-4\", \"1\"]]}, \"lyapunov\": {\"P\": [[\"1\"]], \"rate\": \"1\"}".to_owned(),
        ),
        (
            "h-infinity-filter",
            "\"time\": \"continuous\", \"plant\": {\"A\": [[\"-1\"]], \"B\": [[]], \"C\": [[\"1\"]]}, \"E\": [[\"1\", \"0\"]], \"D\": [[\"0\", \"1\"]], \"H\": [[\"1\"]], \"observer\": {\"L\": [[\"1\"]]}, \"lyapunov\": {\"P\": [[\"1\"]]}, \"gamma\": \"2\"".to_owned(),
        ),
        (
            "h2-filter",
            "\"time\": \"discrete\", \"plant\": {\"A\": [[\"0x1p-1\"]], \"B\": [[]], \"C\": [[\"1\"]]}, \"E\": [[\"1\", \"0\"]], \"D\": [[\"0\", \"1\"]], \"H\": [[\"1\"]], \"observer\": {\"L\": [[\"0x1p-2\"]]}, \"lyapunov\": {\"P\": [[\"2\"]]}, \"gamma\": \"2\"".to_owned(),
        ),
        (
            "interval-observer",
            "\"plant\": {\"A\": [[\"-1\"]], \"C\": [[\"1\"]], \"E\": [[\"1\", \"0\"]], \"D\": [[\"0\", \"1\"]]}, \"observer\": {\"L\": [[\"1\"]]}, \"coordinates\": {\"T\": [[\"1\"]], \"blocks\": [1]}, \"comparison\": {\"K\": [[\"-1\"]], \"g\": [\"4\"], \"H\": [[\"2\"]], \"s\": [\"1\"], \"rate\": \"0x1p-1\"}, \"bounds\": {\"w\": [\"1\", \"1\"], \"limit\": [\"8\"], \"widths\": [\"32\"]}".to_owned(),
        ),
        (
            "sampled-interval-observer",
            "\"plant\": {\"A\": [[\"0x1p-1\"]], \"B\": [[\"1\"]], \"C\": [[\"1\"]], \"E\": [[\"1\"]]}, \"observer\": {\"F\": [[\"0x1p-1\"]], \"G\": [[\"1\"]], \"L\": [[\"0x1p-2\"]]}, \"coordinates\": {\"T\": [[\"1\"]], \"blocks\": [1]}, \"step\": {\"format\": \"binary32\", \"N\": [[\"0x1p-1\"]], \"g\": [\"2\"], \"Q\": [[\"0x1p-10\"]], \"U\": [[\"0x1p-10\"]], \"H\": [[\"2\"]], \"outward\": \"0x1p-10\"}, \"comparison\": {\"s\": [\"1\"], \"factor\": \"0x3p-2\"}, \"bounds\": {\"w\": [\"1\"], \"v\": [\"1\"], \"xhat\": [\"1\"], \"u\": [\"1\"], \"limit\": [\"8\"], \"widths\": [\"32\"]}".to_owned(),
        ),
        (
            "super-twisting-observer",
            "\"observer\": {\"k1\": \"2\", \"k2\": \"1\"}, \"bounds\": {\"F\": \"0x1p-4\"}, \"lyapunov\": {\"P\": [[\"0x3p-4\", \"-0x1p-3\"], [\"-0x1p-3\", \"0x7p-5\"]], \"alpha\": \"0x1p-5\", \"c\": \"4\"}".to_owned(),
        ),
        (
            "kkl-error-bound",
            "\"plant\": {\"f\": [\"x2 - x1\", \"u1 - x2\"], \"h\": [\"x1\"]}, \"observer\": {\"phi\": [\"x2\"], \"Lambda\": [[\"-1\"]], \"B\": [\"u1\"], \"left_inverse\": [\"xi1\"], \"estimated\": [\"x2\"]}, \"box\": {\"x\": [[\"-1\", \"1\"], [\"-1\", \"1\"]], \"u\": [[\"-1\", \"1\"]]}, \"lyapunov\": {\"Lambda\": [[\"-1\"]], \"P\": [[\"1\"]], \"W\": [[\"2\"]], \"rate\": \"0x1p-1\"}, \"bounds\": {\"residual\": [\"0\"], \"start\": \"2\", \"limit\": \"0\", \"lipschitz\": [\"2\"], \"defect\": [\"0\"], \"eventual\": [\"0\"]}, \"injectivity\": {\"Jacobian\": [[\"0\", \"1\"], [\"1\", \"0\"]], \"M\": [[\"0\", \"1\"], [\"1\", \"0\"]], \"modulus\": \"0x1p-1\", \"spread\": \"2\"}".to_owned(),
        ),
        (
            "contracting-coordinates",
            "\"vertices\": [[[\"-1\", \"0\"], [\"0\", \"-1\"]]], \"coordinates\": {\"K\": [[\"0\"]]}, \"observer\": {\"injection\": \"1\"}, \"lyapunov\": {\"Q\": [[\"1\"]], \"rate\": \"0\"}".to_owned(),
        ),
    ];
    let by_fields = others.into_iter().map(|(name, fields)| {
        let text = format!(
            "{{\"format\": \"luenberger-certificate\", \"version\": {VERSION}, \"title\": \"a test\", \"statement\": \"\", \"theorem\": \"{name}\", {fields}, \"margins\": [], \"sha256\": \"\"}}"
        );
        CertificateFile::read(text.as_bytes()).unwrap_or_else(|why| panic!("{name}: {why}")).theorem().clone()
    });
    let kinds: Vec<CertificateFile> = all().into_iter().chain(by_fields).map(file).collect();
    for name in Theorem::NAMES {
        assert!(kinds.iter().any(|file| file.theorem().name() == *name), "{name}");
    }
    kinds
}

/// The end of the JSON value that begins at `start`.
fn end_of_value(text: &str, start: usize) -> usize {
    let bytes = text.as_bytes();
    let (mut at, mut depth, mut quoted) = (start, 0_usize, false);
    loop {
        let byte = bytes[at];
        match byte {
            b'\\' if quoted => at += 1,
            b'"' => quoted = !quoted,
            b'[' | b'{' if !quoted => depth += 1,
            b']' | b'}' if !quoted => depth -= 1,
            _ => {}
        }
        at += 1;
        let scalar = !matches!(bytes[start], b'"' | b'[' | b'{') && matches!(bytes[at], b',' | b'}' | b']' | b'\n');
        let whole = matches!(bytes[start], b'"' | b'[' | b'{') && depth == 0 && !quoted;
        if scalar || whole {
            return at;
        }
    }
}

/// The members of all objects: name, where the name begins, where the value does, where it ends.
fn members(text: &str) -> Vec<(String, usize, usize, usize)> {
    let mut found = Vec::new();
    let mut at = 0;
    while let Some(quote) = text[at..].find('"').map(|k| at + k) {
        let end = end_of_value(text, quote);
        if text[end..].starts_with(": ") {
            found.push((text[quote + 1..end - 1].to_owned(), quote, end + 2, end_of_value(text, end + 2)));
            at = end + 2;
        } else {
            at = end;
        }
    }
    found
}

/// Each field of each kind of certificate in turn emptied, of another type, taken out, given twice, no number: the file
/// is rejected with a reason, though its words and its digest agree with it.
#[test]
fn every_field_of_every_kind_is_missed_and_nothing_is_proved_of_nothing() {
    for file in every_kind() {
        let (text, kind) = (file.to_json(), file.theorem().name());
        assert!(verify(text.as_bytes()).is_ok(), "{kind}");
        let members = members(&text);
        assert!(members.len() >= 10, "{kind}: {}", members.len());
        for (name, begin, value, end) in &members {
            let with = |replacement: &str| format!("{}{replacement}{}", &text[..*value], &text[*end..]);
            let member = &text[*begin..*end];
            let rest = text[*end..].strip_prefix(',').unwrap_or(&text[*end..]);
            let cases = [
                ("[]", with("[]")),
                ("{}", with("{}")),
                ("[[]]", with("[[]]")),
                ("an empty string", with("\"\"")),
                ("null", with("null")),
                ("NaN", with("\"NaN\"")),
                ("infinity", with("\"0x1p1024\"")),
                ("nothing", format!("{}{rest}", &text[..*begin])),
                ("the field twice", format!("{}{member}, {member}{}", &text[..*begin], &text[*end..])),
            ];
            for (what, broken) in cases {
                // Any title is one.
                if name == "title" && ["NaN", "infinity"].contains(&what) {
                    continue;
                }
                // A plant without inputs is one.
                if name == "B" && what == "[[]]" {
                    continue;
                }
                let is_seal = ["statement", "sha256"].contains(&name.as_str());
                let broken = if is_seal || digest(broken.as_bytes()).is_err() { broken } else { resealed(&broken) };
                match verify(broken.as_bytes()) {
                    Ok(proved) => panic!("{kind}: {name} is {what}, and proved is: {}", proved.statement),
                    Err(why) => assert!(!why.to_string().is_empty()),
                }
            }
        }
    }
}

/// Cut anywhere, with bytes that are no text, a byte order mark, or text after the end.
#[test]
fn broken_texts_of_every_kind_are_rejected() {
    for file in every_kind() {
        let (text, kind) = (file.to_json(), file.theorem().name());
        let whole = text.trim_end();
        for k in 0..64 {
            let cut = (0..=whole.len() * k / 64).rev().find(|&at| whole.is_char_boundary(at)).unwrap_or(0);
            let Err(Rejection::File(error)) = verify(&whole.as_bytes()[..cut]) else { panic!("{kind}, cut at {cut}") };
            assert!(error.is_unreadable(), "{kind}, cut at {cut}: {error}");
            let mut bytes = whole.as_bytes().to_vec();
            bytes[cut] = 0xff;
            let error = verify(&bytes).expect_err("not UTF-8").to_string();
            assert!(error.ends_with(&format!("the byte at position {cut} is not UTF-8")), "{kind}: {error}");
        }
        for broken in [
            format!("\u{feff}{text}"),
            format!("{text}0"),
            format!("{text}{text}"),
            format!("{text},"),
            format!("[{text}]"),
        ] {
            assert!(verify(broken.as_bytes()).is_err(), "{kind}");
        }
    }
}

/// RFC 8259, section 6: what begins as a number and is none is no JSON; a number that is no index is an error of its
/// field.
#[test]
fn numbers_are_those_of_json() {
    let version = |token: &str| {
        let text = text().replacen(&format!("\"version\": {VERSION}"), &format!("\"version\": {token}"), 1);
        match verify(resealed_if_json(&text).as_bytes()) {
            Err(Rejection::File(error)) => error,
            other => panic!("{token}: {other:?}"),
        }
    };
    let zeros = format!("0{VERSION}");
    let dotted = format!("{VERSION}.");
    for token in [
        zeros.as_str(),
        "-01",
        "00",
        "+1",
        dotted.as_str(),
        ".5",
        "1.e1",
        "1e",
        "1e+",
        "1e1.5",
        "--1",
        "-",
        "1-1",
        "1..0",
        "1E+-1",
    ] {
        assert!(version(token).is_unreadable(), "{token}: {}", version(token));
    }
    for token in [
        format!("{VERSION}.0"),
        format!("{VERSION}e0"),
        format!("{VERSION}E+00"),
        "-1".to_owned(),
        "-0".to_owned(),
        "99999999999999999999".to_owned(),
    ] {
        let error = version(&token);
        assert!(!error.is_unreadable() && error.to_string().contains("whole number"), "{token}: {error}");
    }
    assert!(version(&zeros).to_string().contains("is no number of JSON"), "{}", version(&zeros));
}

fn resealed_if_json(text: &str) -> String {
    if digest(text.as_bytes()).is_ok() { resealed(text) } else { text.to_owned() }
}

#[test]
fn strings_hold_whole_characters_and_no_controls() {
    let title = |inside: &str| verify(resealed_if_json(&text().replacen("a test", inside, 1)).as_bytes());
    for inside in [
        "\\ud83d",
        "\\ude00",
        "\\ud83d\\ude00",
        "\\u0000",
        "\\u001f",
        "\\n",
        "\\u12",
        "\\u+123",
        "\\x41",
        "\u{7}",
        "\u{7f}",
        "\n",
    ] {
        assert!(matches!(title(inside), Err(Rejection::File(error)) if error.is_unreadable()), "{inside:?}");
    }
    assert_eq!(title("\\u00e9 \\/ \\\\").expect("one character").title, "\u{e9} / \\");
}

#[test]
fn size_and_depth_are_bounded() {
    let error = |bytes: &[u8]| verify(bytes).expect_err("too much").to_string();
    assert!(error(&vec![b' '; LARGEST_FILE + 1]).contains("bytes or more"));
    assert_eq!(error("[".repeat(1 << 20).as_bytes()), "line 1: arrays and objects are nested deeper than 16");
    assert!(error(format!("{{{}}}", "\"a\":{".repeat(1 << 16)).as_bytes()).contains("nested deeper"));
    let many = (0..70).map(|k| format!("\"{k}\": 1,")).collect::<Vec<_>>().concat();
    assert_eq!(error(format!("{{{many}").as_bytes()), "line 1: an object has more than 64 members");
    let long = format!("[{}]", vec!["\"1\""; 600].join(","));
    assert!(
        why(&text().replacen("[\"0x0p0\", \"0x1p0\"]", &long, 1))
            .contains("is of order 600; the checker goes up to 512")
    );
    // Matrices that are large by their orders alone.
    let program = file(program().into()).to_json();
    let blocks = ["{ \"dense\": 512 }"; 5].join(", ");
    let found = why(&program.replacen("\"blocks\": [", &format!("\"blocks\": [{blocks}, "), 1));
    assert!(
        found.ends_with(
            "program.blocks: the matrices have 1310724 entries together, zeros included; the checker goes up to 1048576"
        ),
        "{found}"
    );
    let inequality = file(holds().into()).to_json();
    let found = why(&inequality.replacen("\"order\": 2", "\"order\": 513", 1));
    assert!(
        found.ends_with("inequalities.constraints[0].order: the index 513 is too large: 512 is the largest"),
        "{found}"
    );
    let digits = "7".repeat(20_001);
    assert!(why(&text().replacen("0x1.6p3", &digits, 1)).contains("a number of 20001 characters"));
}

proptest! {
    #[test]
    fn arbitrary_bytes_never_panic(bytes in prop::collection::vec(any::<u8>(), 0..400)) {
        prop_assert!(verify(&bytes).is_err());
    }

    /// Pieces of JSON in any order.
    #[test]
    fn arbitrary_json_never_panics(pieces in prop::collection::vec(prop::sample::select(vec![
        "{", "}", "[", "]", ",", ":", "\"", "\"P\"", "\"0x1p0\"", "null", "1", "-", "\\", "\\u00e9", "\n", "true", "\"sha256\"", "é",
    ]), 0..60)) {
        prop_assert!(verify(pieces.concat().as_bytes()).is_err());
    }

    /// A valid file with bytes replaced, removed, doubled: never a panic, and never proved unless nothing but white
    /// space or the case of a digit changed. With the digest made to agree, what is proved is still what the checker
    /// derives.
    #[test]
    fn mutated_files_never_panic(
        which in 0..10_usize, edits in prop::collection::vec((any::<prop::sample::Index>(), any::<u8>(), 0..4_u8), 1..4),
    ) {
        let file = file(all().swap_remove(which));
        let mut bytes = file.to_json().into_bytes();
        for (at, byte, kind) in edits {
            let at = at.index(bytes.len());
            match kind {
                0 => bytes[at] = byte,
                1 => { bytes.remove(at); }
                2 => bytes.insert(at, bytes[at]),
                // Three edits at most: two removals leave something of three bytes.
                _ => bytes.truncate(at.max(3)),
            }
        }
        match verify(&bytes) {
            Ok(proved) => prop_assert_eq!(proved.statement, file.statement()),
            Err(Rejection::Digest { computed, .. }) => {
                let text = String::from_utf8(bytes).expect("it was parsed");
                let mut lines: Vec<&str> = text.lines().collect();
                let line = format!("  \"sha256\": \"{computed}\"");
                for l in &mut lines {
                    if l.trim_start().starts_with("\"sha256\"") { *l = &line; }
                }
                if let Ok(proved) = verify(lines.join("\n").as_bytes()) {
                    prop_assert!(proved.facts.iter().all(|fact| fact.verdict.is_proved()));
                }
            }
            Err(why) => prop_assert!(!why.to_string().is_empty()),
        }
    }
}

fn run(arguments: &[&str], input: &[u8]) -> Output {
    let mut child = Command::new(env!("CARGO_BIN_EXE_luenberger-verify"))
        .args(arguments)
        .stdin(Stdio::piped())
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .expect("the program starts");
    // A program that has refused its arguments does not read.
    let _ = child.stdin.take().expect("piped").write_all(input);
    child.wait_with_output().expect("it ends")
}

fn said(output: &Output) -> String {
    String::from_utf8(output.stdout.clone()).expect("UTF-8")
}

#[test]
fn the_program_says_proved_rejected_or_unreadable() {
    let proved = run(&["-"], text().as_bytes());
    assert_eq!(proved.status.code(), Some(0));
    assert!(said(&proved).starts_with("-: Proved\n  For the plant x' = Ax + Bu"), "{}", said(&proved));
    assert!(said(&proved).contains("\n  (A - LC)'P + P(A - LC) < 0 (12), margin >= 13.99999\n"), "{}", said(&proved));
    let forged = run(&["-"], text().replace("0x1.6p3", "0x1.7p3").as_bytes());
    assert_eq!(forged.status.code(), Some(1));
    assert!(said(&forged).starts_with("-: Rejected\n  line 43, sha256: the digest"), "{}", said(&forged));
    for unreadable in [&b"{"[..], b"\xff", b""] {
        assert_eq!(run(&["-"], unreadable).status.code(), Some(2));
    }
    let several = run(&["/nonexistent/certificate.json", "-"], text().as_bytes());
    assert_eq!(several.status.code(), Some(2));
    assert!(
        said(&several).contains("/nonexistent/certificate.json: Unreadable\n")
            && said(&several).contains("-: Proved\n")
    );
}

#[test]
fn the_program_speaks_json() {
    let proved = run(&["--json", "-"], text().as_bytes());
    let line = said(&proved);
    assert!(
        line.starts_with("{\"file\":\"-\",\"outcome\":\"proved\",\"title\":\"a test\",\"statement\":\"For the plant"),
        "{line}"
    );
    assert!(line.contains("\"facts\":[{\"inequality\":\"P > 0\",\"margin\":\"0x1."), "{line}");
    let rejected = run(&["--json", "-"], text().replace("0x1.6p3", "0x1.zp3").as_bytes());
    assert_eq!(
        said(&rejected),
        "{\"file\":\"-\",\"outcome\":\"rejected\",\"why\":\"line 28, lyapunov.P[0][0]: \\\"0x1.zp3\\\" is not a hexadecimal float such as \\\"0x1.8p-3\\\"\"}\n"
    );
    assert_eq!(rejected.status.code(), Some(1));
}

#[test]
fn the_program_explains_itself() {
    let help = run(&["--help"], b"");
    assert!(help.status.success() && said(&help).contains("Example:") && said(&help).contains("linear-observer"));
    for arguments in [&[][..], &["--frobnicate", "x"], &["--json"]] {
        let refused = run(arguments, b"");
        assert_eq!(refused.status.code(), Some(2), "{arguments:?}");
        assert!(String::from_utf8_lossy(&refused.stderr).contains("luenberger-verify --help"));
    }
    let digested = run(&["--digest", "-"], text().as_bytes());
    assert!(text().contains(said(&digested).split(' ').next().expect("a digest")));
}

/// The file that `docs/certificates.md` shows is one.
#[test]
fn the_file_of_the_documentation_is_proved() {
    let page = include_str!("../../../../docs/certificates.md");
    let (_, rest) = page.split_once("```json\n").expect("a file");
    let (shown, _) = rest.split_once("```").expect("its end");
    assert_eq!(shown, CertificateFile::prove("a double integrator", integrator()).expect("proved").to_json());
    for theorem in Theorem::NAMES {
        assert!(page.contains(&format!("`{theorem}`")), "{theorem} is not on the page");
    }
}

/// The words of a deployed observer have the operations that run, and no number but counts and powers of two; where a
/// formula has no maximum, an indefinite weight is refused.
#[test]
fn weights_and_words_are_those_of_the_formula() {
    let number = |x: f64| Matrix::from_rows([[x]]);
    let none = || Matrix::from_fn(1, 0, |_, _| 0.0);
    let operation = Operation { state: vec![1.0], input: vec![], noise: vec![0.1], error: vec![1.0], deviation: None };
    let formats = Format::Binary32.into();
    let plant = SampledPlant { a: number(0.5), b: none(), c: number(1.0) };
    let gains = CubicGains { n: number(-2.0), theta: number(-1.0), w: 2.0, h: 0.125 };
    let (l, p) = (number(0.25), number(1.0));
    let found = deployed_sampled_cubic(&plant, &l, &gains, &p, formats, &operation).expect("fits");
    let ball = found.ball().map(ClaimedBall::from);
    assert!(ball.is_some(), "{found:?}");
    let step = Step::Innovation;
    let theorem = DeployedObserver { plant, stored: found.stored, step, formats, operation, p, ball };
    let words = verify(file(theorem.into()).to_json().as_bytes()).expect("proved").statement;
    for operation in ["1/sqrt(1 + 2 w h max(z'theta z, 0))", "q = max(d'theta d, 0), k = (2q)h, b = sqrt(w k)", "2^23"]
    {
        assert!(words.contains(operation), "{words}");
    }
    let joined = file(deployed(Step::Joined, Format::Binary64).into());
    let joined = verify(joined.to_json().as_bytes()).expect("proved").statement;
    assert!(joined.contains("F being the exact A - LC of the plant's A and C and the stored L, rounded once"));
    for words in [&words, &joined] {
        let digits = words.as_bytes().windows(3);
        let is_decimal = |w: &[u8]| w[0].is_ascii_digit() && w[1] == b'.' && w[2].is_ascii_digit();
        assert!(!digits.into_iter().any(is_decimal), "{words}");
    }
    // The sampled observer in exact arithmetic computes the same maximum: any theta will do, and the words say why.
    for theta in [1.0, -1.0] {
        let sampled = SampledCubicConvergence {
            plant: PlantMatrices { a: number(0.5), b: none(), c: number(1.0) },
            l: number(0.25),
            n: number(-2.0),
            theta: number(theta),
            w: 2.0,
            period: 0.125,
            p: number(1.0),
        };
        let file = CertificateFile::prove("a weight", sampled).expect("proved");
        assert!(file.statement().contains("q = max(z'theta z, 0)"), "{}", file.statement());
    }
}
