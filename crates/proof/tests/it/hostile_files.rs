//! `luenberger-verify` on files made to exhaust it: it answers with a reason, in bounded memory and time. Each file
//! carries the words and the digest that its data call for, so that the checker goes on to the mathematics.
#![cfg(unix)]

use std::io::Write;
use std::process::{Command, Stdio};
use std::sync::Mutex;
use std::time::{Duration, Instant};

use luenberger_proof::certificate::{
    CertificateFile, LARGEST_FILE, LARGEST_ORDER, MOST_VALUES, Theorem, VERSION, digest,
};
use luenberger_proof::semidefinite::LARGEST_GRAM;

/// The address space of the checker in KiB, as `docs/certificates.md` states it.
const ADDRESS_LIMIT: usize = 2 << 20;

/// Generous: an unoptimised build on a busy machine.
const TIME_LIMIT: Duration = Duration::from_secs(300);

/// What the checker says of the bytes, with its exit status. Fails where it ends by a signal (an allocation that was
/// refused), or takes too long.
fn answer(name: &str, bytes: &[u8]) -> (i32, String) {
    let started = Instant::now();
    let mut child = Command::new("sh")
        .args(["-c", &format!("ulimit -v {ADDRESS_LIMIT} && exec \"$0\" -"), env!("CARGO_BIN_EXE_luenberger-verify")])
        .stdin(Stdio::piped())
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .expect("a shell");
    // One that has read enough does not read on.
    let _ = child.stdin.take().expect("piped").write_all(bytes);
    let output = child.wait_with_output().expect("it ends");
    let (text, complaint) = (String::from_utf8_lossy(&output.stdout), String::from_utf8_lossy(&output.stderr));
    println!("{name}: {:?}, {} bytes: {:.200}", started.elapsed(), bytes.len(), text);
    assert!(started.elapsed() <= TIME_LIMIT, "{name} took {:?}", started.elapsed());
    let status = output.status.code().unwrap_or_else(|| panic!("{name}: ended by a signal: {complaint:.500}"));
    assert!(complaint.is_empty() && (0..=2).contains(&status), "{name}: {status} {complaint:.500}");
    (status, text.into_owned())
}

/// A document with these fields; the words where they can be had, and the digest, agree with the data.
fn sealed(theorem: &str, fields: &str) -> String {
    let document = |words: &str, digest: &str| {
        let words = words.replace('\\', "\\\\").replace('"', "\\\"");
        format!(
            "{{\"format\":\"luenberger-certificate\",\"version\":{VERSION},\"title\":\"hostile\",\"statement\":\"{words}\",\"theorem\":\"{theorem}\",{fields},\"margins\":[],\"sha256\":\"{digest}\"}}"
        )
    };
    let words = CertificateFile::read(document("", "").as_bytes()).map_or(String::new(), |file| file.theorem().words());
    let draft = document(&words, "");
    document(&words, &digest(draft.as_bytes()).unwrap_or_default())
}

fn matrix(rows: usize, columns: usize, entry: impl Fn(usize, usize) -> String) -> String {
    let row =
        |i: usize| format!("[{}]", (0..columns).map(|j| format!("\"{}\"", entry(i, j))).collect::<Vec<_>>().join(","));
    format!("[{}]", (0..rows).map(row).collect::<Vec<_>>().join(","))
}

fn diagonal(order: usize, entry: &str) -> String {
    matrix(order, order, |i, j| if i == j { entry.to_owned() } else { "0".to_owned() })
}

/// Entries from 2^-900 to 2^899, symmetric: long integers for exact arithmetic.
fn wide(order: usize) -> String {
    matrix(order, order, |i, j| {
        let (i, j) = (i.min(j), i.max(j));
        let exponent = (i * 37 + j * 91) % 1800;
        let (sign, size) = if exponent < 900 { ("-", 900 - exponent) } else { ("", exponent - 900) };
        format!("0x1.{:x}p{sign}{size}", 1 + (i * 7 + j * 13) % 15)
    })
}

/// `count` unknowns that all stand in the one entry of a block of order one.
fn one_entry_program(count: usize) -> String {
    let costs = vec!["\"1\""; count].join(",");
    let entries = (1..=count).map(|i| format!("[{i},0,0,0,\"1\"]")).collect::<Vec<_>>().join(",");
    format!(
        "\"program\":{{\"blocks\":[{{\"dense\":1}}],\"costs\":[{costs}],\"entries\":[{entries}]}},\"claim\":\"bounds\",\"lower\":{{\"bound\":\"0\",\"Y\":[{{\"dense\":[[\"1\"]]}}]}}"
    )
}

/// Sectors of one nonlinearity each, of a plant with one state.
fn sectors(count: usize) -> String {
    let term = "{\"G\":[[\"1\"]],\"H\":[[\"1\"]],\"low\":\"0\",\"high\":\"1\",\"tau\":\"1\"}";
    format!(
        "\"plant\":{{\"A\":[[\"-1\"]],\"C\":[[\"1\"]],\"sectors\":[{}]}},\"observer\":{{\"L\":[[\"0\"]]}},\"lyapunov\":{{\"P\":[[\"1\"]],\"rate\":\"0\"}}",
        vec![term; count].join(",")
    )
}

fn plant(n: usize, a: &str, outputs: usize) -> String {
    format!(
        "\"plant\":{{\"A\":{a},\"B\":{},\"C\":{}}}",
        matrix(n, 1, |_, _| "1".into()),
        matrix(outputs, n, |_, _| "1".into())
    )
}

/// What is refused for its size is refused before anything of that size exists, and the message has the bound.
#[test]
fn sizes_are_refused_with_their_bound() {
    let digits = "7".repeat(20_000);
    let cases: Vec<(&str, String, String)> = vec![
        (
            "a Gram matrix of 58 gigabytes",
            sealed("semidefinite-program", &one_entry_program(60_000)),
            format!("the Gram matrix of the constraints would be of order 60000; at most {LARGEST_GRAM} are formed"),
        ),
        (
            "as many entries as a file holds",
            sealed("semidefinite-program", &one_entry_program(290_000)),
            format!("the Gram matrix of the constraints would be of order 290000; at most {LARGEST_GRAM} are formed"),
        ),
        (
            "an S-procedure of 60 001 rows",
            sealed("sector-observer", &sectors(60_000)),
            format!("plant.sectors: is of order 513; the checker goes up to {LARGEST_ORDER}"),
        ),
        ("values", format!("[{}0]", "0,".repeat(MOST_VALUES)), format!("more than {MOST_VALUES} values")),
        ("empty arrays", format!("[{}0]", "[],".repeat(MOST_VALUES)), format!("more than {MOST_VALUES} values")),
        ("bytes", " ".repeat(LARGEST_FILE + 1), format!("{LARGEST_FILE} are read at most")),
        ("depth", "[".repeat(LARGEST_FILE), "nested deeper than 16".to_owned()),
        (
            "a long number",
            sealed("definiteness", &format!("\"M\":[[\"1{digits}\"]],\"is\":\"positive definite\"")),
            "a number of 20001 characters: 20000 are allowed".to_owned(),
        ),
        (
            "an order",
            sealed("definiteness", &format!("\"M\":{},\"is\":\"positive definite\"", diagonal(513, "1"))),
            "is of order 513; the checker goes up to 512".to_owned(),
        ),
    ];
    for (name, text, expected) in cases {
        let (status, said) = answer(name, text.as_bytes());
        assert!(status > 0 && said.contains(&expected), "{name}: {said:.400}");
    }
}

/// As large as each kind may be: an answer, whichever, within the limits.
#[test]
fn the_largest_of_each_kind_is_answered() {
    let n = LARGEST_ORDER;
    let (stable, one) = (diagonal(n, "-1"), diagonal(n, "1"));
    let half = diagonal(n, "1/2");
    // The observers ask the questions of the two matrices above: half of the order is enough of a try.
    let m = n / 2;
    let (stable_m, half_m, one_m) = (diagonal(m, "-1"), diagonal(m, "1/2"), diagonal(m, "1"));
    let lyapunov = |order: usize| format!("\"lyapunov\":{{\"P\":{},\"rate\":\"0\"}}", diagonal(order, "1"));
    let zeros = |rows: usize, columns: usize| matrix(rows, columns, |_, _| "0".into());
    let gains =
        |order: usize, outputs: usize, more: &str| format!("\"observer\":{{\"L\":{}{more}}}", zeros(order, outputs));
    // Integers of 20 000 digits, as many as a file holds.
    let long = |k: usize| format!("{}{k:03}", "7".repeat(19_990));
    let constraints = |count: usize, order: usize, entries: &dyn Fn(usize) -> String| {
        (0..count)
            .map(|k| format!("{{\"name\":\"F{k}\",\"order\":{order},\"entries\":[{}]}}", entries(k)))
            .collect::<Vec<_>>()
            .join(",")
    };
    let inequalities = |unknowns: usize, constraints: &str| {
        format!("\"inequalities\":{{\"unknowns\":{unknowns},\"relation\":\">\",\"constraints\":[{constraints}]}}")
    };
    // Singular but for the last digits, with far exponents: work for the referee, in every constraint.
    let hard = |k: usize| {
        let entry = |i: usize, j: usize| {
            let value =
                if i == j { format!("{}/{}", (1_u128 << 120) + 1 + k as u128, 1_u128 << 120) } else { "1".to_owned() };
            format!("[0,{i},{j},\"{value}\"]")
        };
        (0..64).flat_map(|i| (i..64).map(move |j| (i, j))).map(|(i, j)| entry(i, j)).collect::<Vec<_>>().join(",")
    };
    let many_unknowns = (1..=240_000).map(|i| format!("[{i},0,0,\"1\"]")).collect::<Vec<_>>().join(",");
    let operation = |n: usize| {
        let ones = |count: usize| format!("[{}]", vec!["\"1\""; count].join(","));
        format!("\"operation\":{{\"x\":{},\"u\":{},\"v\":{},\"e(0)\":{}}}", ones(n), ones(n), ones(n), ones(n))
    };
    let deployed = {
        let (d, f) = (32, diagonal(32, "1/2"));
        let square = |entry: &str| diagonal(d, entry);
        format!(
            "\"plant\":{{\"A\":{f},\"B\":{},\"C\":{}}},\"formats\":{{\"stored\":\"binary32\",\"running\":\"binary32\"}},\"step\":\"innovation\",\"stored\":{{\"A\":{f},\"B\":{},\"C\":{},\"L\":{}}},{},\"lyapunov\":{{\"P\":{}}}",
            square("1"),
            square("1"),
            square("1"),
            square("1"),
            zeros(d, d),
            operation(d),
            square("1")
        )
    };
    let cases: Vec<(&str, &str, String)> = vec![
        ("hurwitz", "hurwitz", format!("\"A\":{stable},\"lyapunov\":{{\"P\":{one}}}")),
        ("schur", "schur", format!("\"A\":{half},\"lyapunov\":{{\"P\":{one}}}")),
        ("schur, wide", "schur", format!("\"A\":{},\"lyapunov\":{{\"P\":{}}}", wide(160), wide(160))),
        ("hurwitz, wide", "hurwitz", format!("\"A\":{},\"lyapunov\":{{\"P\":{}}}", wide(160), wide(160))),
        ("definiteness", "definiteness", format!("\"M\":{},\"is\":\"positive semidefinite\"", wide(n))),
        ("definiteness, 64", "definiteness", format!("\"M\":{},\"is\":\"positive definite\"", wide(64))),
        ("linear", "linear-observer", format!("{},{},{}", plant(m, &stable_m, 4), gains(m, 4, ""), lyapunov(m))),
        (
            "discrete",
            "discrete-observer",
            format!("{},{},\"lyapunov\":{{\"P\":{one_m}}}", plant(m, &half_m, 4), gains(m, 4, "")),
        ),
        (
            "cubic",
            "cubic-observer",
            format!(
                "{},{},\"lyapunov\":{{\"P\":{},\"S\":[[\"1\"]],\"rate\":\"0\",\"converges_from\":\"everywhere\"}}",
                plant(160, &diagonal(160, "-1"), 1),
                gains(160, 1, &format!(",\"N\":{},\"theta\":[[\"1\"]]", matrix(160, 1, |_, _| "-1".into()))),
                diagonal(160, "1")
            ),
        ),
        (
            "structured",
            "cubic-observer-with-structured-gain",
            format!(
                "{},{},{}",
                plant(m, &stable_m, 1),
                gains(m, 1, ",\"theta\":[[\"1\"]],\"S\":[[\"1\"]]"),
                lyapunov(m)
            ),
        ),
        (
            "theorem 1",
            "cubic-observer-theorem-1",
            format!(
                "{},{},\"lyapunov\":{{\"P\":{one_m}}}",
                plant(m, &stable_m, 1),
                gains(m, 1, &format!(",\"N\":{},\"theta\":[[\"1\"]]", zeros(m, 1)))
            ),
        ),
        (
            "polytope",
            "polytope-of-plants",
            format!(
                "\"vertices\":[{}],{},{}",
                vec![format!("{{\"A\":{},\"C\":{}}}", diagonal(256, "-1"), matrix(1, 256, |_, _| "1".into())); 12]
                    .join(","),
                gains(256, 1, ""),
                lyapunov(256)
            ),
        ),
        (
            "discrete polytope",
            "discrete-polytope-of-jacobians",
            format!(
                "\"vertices\":[{}],{},\"lyapunov\":{{\"P\":{},\"factor\":\"1\"}}",
                vec![format!("{{\"A\":{},\"C\":{}}}", diagonal(80, "0x1p-1"), matrix(1, 80, |_, _| "1".into())); 12]
                    .join(","),
                gains(80, 1, ""),
                diagonal(80, "1")
            ),
        ),
        (
            "contracting",
            "contracting-coordinates",
            format!(
                "\"vertices\":[{}],\"coordinates\":{{\"K\":{}}},\"observer\":{{\"injection\":\"1\"}},\"lyapunov\":{{\"Q\":{},\"rate\":\"0\"}}",
                diagonal(n, "-1"),
                zeros(n / 2, n / 2),
                diagonal(n / 2, "1")
            ),
        ),
        ("sectors", "sector-observer", sectors(n - 1)),
        (
            "solution",
            "solution-within",
            format!(
                "\"equation\":\"A'P + PA + Q = 0\",\"A\":{stable},\"Q\":{},\"proposal\":{{\"P\":[{one}],\"W\":{one}}},\"P\":{one}",
                diagonal(n, "2")
            ),
        ),
        (
            "solution by elimination",
            "solution-within",
            format!(
                "\"equation\":\"A'PA - P + Q = 0\",\"A\":{},\"Q\":{},\"proposal\":{{\"P\":[{}]}},\"P\":{}",
                diagonal(24, "1/2"),
                diagonal(24, "3/4"),
                diagonal(24, "1"),
                diagonal(24, "1")
            ),
        ),
        (
            "inequalities, 60 hard ones",
            "matrix-inequality-holds",
            format!("{},\"x\":[]", inequalities(0, &constraints(60, 64, &hard))),
        ),
        (
            "multipliers of 20 000 digits in every equation",
            "matrix-inequality-refuted",
            format!(
                "{},\"multipliers\":[[[\"{}\"]]]",
                inequalities(240_000, &constraints(1, 1, &|_| many_unknowns.clone())),
                long(1)
            ),
        ),
        (
            "multipliers of 20 000 digits",
            "matrix-inequality-refuted",
            format!(
                "{},\"multipliers\":[{}]",
                inequalities(1, &constraints(100, 2, &|_| "[1,0,0,\"1\"]".to_owned())),
                (0..100)
                    .map(|k| format!("[[\"{}\",\"{}\"],[\"{1}\",\"{0}\"]]", long(k), long(k + 1)))
                    .collect::<Vec<_>>()
                    .join(",")
            ),
        ),
        (
            "varying periods",
            "sampled-observer-at-varying-periods",
            format!(
                "{},\"observer\":{{\"step\":\"linear\",\"K\":{}}},\"periods\":{{\"shortest\":\"1\",\"longest\":\"2\",\"misses\":0}},\"lyapunov\":{{\"P\":{},\"factor\":\"1/2\"}}",
                plant(160, &diagonal(160, "-1"), 1),
                zeros(160, 1),
                diagonal(160, "1")
            ),
        ),
        ("the largest Gram matrix", "semidefinite-program", one_entry_program(LARGEST_GRAM)),
        ("deployed", "deployed-observer", deployed),
    ];
    let check = |(name, theorem, fields): (&str, &str, String)| {
        let text = sealed(theorem, &fields);
        assert!(text.len() <= LARGEST_FILE, "{name}: {} bytes", text.len());
        let (status, said) = answer(name, text.as_bytes());
        // Read as a certificate, whatever is proved.
        assert!(status <= 1 && !said.contains("Unreadable"), "{name}: {said:.400}");
        // Read and decided: only then are the margins, of which there are none, counted.
        let is_decided = !said.contains("-: Rejected\n  line") || said.contains("margins: the theorem has");
        assert!(is_decided, "{name}: {said:.400}");
    };
    // Two at a time, from the last ones on, which take longest.
    let left = Mutex::new(cases);
    let work = || std::iter::from_fn(|| left.lock().unwrap().pop()).for_each(check);
    std::thread::scope(|scope| {
        scope.spawn(work);
        work();
    });
    assert!(Theorem::NAMES.len() >= 19);
}
