//! Every field of every kind of certificate, missing, doubled or of another type.

use super::*;

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
            "discrete-input-to-state-stability",
            "\"plant\": {\"vertices\": [{\"A\": [[\"1\"]], \"E\": [[\"1\", \"0\"]]}], \"C\": [[\"1\"]], \"D\": [[\"0\", \"1\"]]}, \"observer\": {\"L\": [[\"0x1p-1\"]]}, \"lyapunov\": {\"P\": [[\"1\"]], \"factor\": \"0x1.8p-1\", \"lambda\": [\"4\", \"1\"]}, \"bounds\": {\"w\": [\"1\", \"1\"], \"level\": \"12\", \"limsup\": [\"4\"]}".to_owned(),
        ),
        (
            "decoupling-observer",
            "\"time\": \"continuous\", \"plant\": {\"A\": [[\"-1\"]], \"B\": [[]], \"C\": [[\"1\"]]}, \"E\": [[\"1\"]], \"F\": [[\"1\"]], \"observer\": {\"L\": [[\"0\"]]}, \"lyapunov\": {\"P\": [[\"1\"]]}".to_owned(),
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
