//! Certificate files that are wrong: every way is an error that names line and field, in bounded time and memory,
//! without a panic; and the program that checks files.

mod deployed;
mod every_kind;
mod json;
mod program;

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
use luenberger_proof::wording::entry;
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

/// A name cannot move what stands beside it.
#[test]
fn invisible_characters_of_names_are_written_out() {
    let mut theorem = holds();
    theorem.inequalities.constraints[0].name = "M\u{202e}0 <\u{2028}\u{200b}".to_owned();
    let file = file(theorem.into());
    let proved = file.check().expect("proved");
    let name = "\"M\\u{202e}0 <\\u{2028}\\u{200b}\"";
    assert!(proved.statement.contains(name), "{}", proved.statement);
    assert!(proved.facts[0].inequality.contains(name), "{:?}", proved.facts);
    let unknown = file.to_json().replacen("\"title\"", "\"ti\u{200b}tle\": 1, \"title\"", 1);
    assert!(why(&unknown).contains("\\u{200b}"), "{}", why(&unknown));
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
fn a_margin_is_accepted_up_to_the_last_bit_and_no_further() {
    for theorem in all() {
        let file = file(theorem);
        let facts = file.check().expect("proved").facts;
        for k in 0..file.claims().len() {
            let margin = facts[k].verdict.margin().expect("proved");
            // A file leaves a millionth of it to other ways to add.
            let claimed = file.claims()[k].margin.to_f64().expect("binary64");
            assert!((margin * (1.0 - 1.0 / 524_288.0)..=margin).contains(&claimed), "{claimed} of {margin}");
            // Thousands of millions of units in the last place: one that is added elsewhere does not decide.
            assert!(margin == 0.0 || claimed <= margin * (1.0 - 1.0 / 2_097_152.0), "{claimed} of {margin}");
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
        (replaced("[\"0x1.4p3\"]", "[\"0x1.4p3\"], [\"0x0p0\"]"), "line 21, observer.L: must be 2 x 1, found 3 x 1"),
        (replaced("      [\"0x0p0\", \"0x1p0\"],\n", ""), "line 8, plant.A: must be 1 x 1, found 1 x 2"),
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

/// One end of one interval one unit narrower than the one derived, or another equation: rejected.
#[test]
fn intervals_of_a_solution_are_accepted_up_to_the_last_bit() {
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
            let at = entry(i, j);
            let start = format!("A'P + PA + Q = 0 has one solution, and it lies in P is not proved: at {at} the bound");
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
        Err("sum_k tr(F_ki Z_k) = 0 for every unknown x_i is false: the coefficient of x_1 is 1".to_owned())
    );
    let mut negative = refuted();
    negative.multipliers = vec![Matrix::from_rows([[Exact::new((-1).into(), 0)]]); 2];
    assert!(prove(negative).expect_err("negative").starts_with("Z >= 0 of \"x > 0\" is false"));
    let mut zero = refuted();
    zero.multipliers = vec![Matrix::zeros(1, 1), Matrix::zeros(1, 1)];
    assert_eq!(prove(zero), Err("the Z_k are not all zero is false: they are all zero".to_owned()));
    let mut feasible = refuted();
    feasible.inequalities.constraints[1].entries[1].value = "1/2".parse().expect("a number");
    assert_eq!(prove(feasible), Err("sum_k tr(F_k0 Z_k) <= 0 is false: the constant is 0.5".to_owned()));
}

/// The file that `docs/certificates.md` shows is one.
#[test]
fn the_file_of_the_documentation_is_proved() {
    let page = include_str!("../../../../../docs/certificates.md");
    let (_, rest) = page.split_once("```json\n").expect("a file");
    let (shown, _) = rest.split_once("```").expect("its end");
    assert_eq!(shown, CertificateFile::prove("a double integrator", integrator()).expect("proved").to_json());
    for theorem in Theorem::NAMES {
        assert!(page.contains(&format!("`{theorem}`")), "{theorem} is not on the page");
    }
}
