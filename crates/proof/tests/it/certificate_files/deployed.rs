//! Certificates of deployed observers: their bounds and their stored numbers.

use super::*;

/// Each bound of a deployed observer: the next smaller one is one too many, and a larger one is true as well.
#[test]
fn bounds_of_a_running_error_are_accepted_up_to_the_last_bit() {
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
        assert!(why.starts_with("sqrt(e'Pe) <= running.start at all times is not proved: at (1, 1) the bound"));
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
        "the inequalities cannot be evaluated: L(2, 1) is 2, and its format ends at 0.999755859375"
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
