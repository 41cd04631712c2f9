//! Numbers, strings, size and depth of the text.

use super::*;

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
