//! Every error has a message on standard error, an object with `--json`, and its exit code.

use crate::terminal::{Ran, folder, luenberger};

const SHORT: &str = r#"{"a": [[0, 1], [-2, -3]]}"#;

/// Command, input, exit code, and the message after `error: standard input: `.
pub(crate) const MISTAKES: &[(&str, &str, i32, &str)] = &[
    ("eig", "", 2, "line 1, column 1: the input is empty, and a JSON object is expected"),
    ("eig", "[[1]]", 2, "line 1, column 1: invalid type: sequence, expected an object with the keys \"a\""),
    ("eig", "{'a': [[1]]}", 2, "line 1, column 2: key must be a string"),
    ("eig", "{\"a\": [[1],\n [2]", 2, "line 2, column 4: EOF while parsing a list"),
    ("eig", "{\"a\": [[1, 2],\n [3 4]]}", 2, "line 2, column 5: expected `,` or `]`"),
    ("eig", "{\"a\": [[1]]} and more", 2, "line 1, column 14: trailing characters"),
    ("eig", "{\"a\": [[1], [2],]}", 2, "line 1, column 17: trailing comma"),
    ("eig", "{}", 2, "line 1, column 2: the key \"a\" is missing (known: \"a\")"),
    ("lyap", SHORT, 2, "line 1, column 25: the key \"q\" is missing (known: \"a\", \"q\", \"e\")"),
    ("eig", r#"{"A": [[1]]}"#, 2, "line 1, column 4: the key \"A\" is unknown; did you mean \"a\"? (known: \"a\")"),
    ("eig", r#"{"x": [[1]]}"#, 2, "line 1, column 4: the key \"x\" is unknown (known: \"a\")"),
    (
        "place",
        r#"{"pols": [1]}"#,
        2,
        "line 1, column 7: the key \"pols\" is unknown; did you mean \"poles\"? (known: \"a\", \"b\", \"pattern\", \"poles\" or \"a\", \"c\", \"pattern\", \"poles\")",
    ),
    ("eig", r#"{"a": [[1]], "a": [[2]]}"#, 2, "line 1, column 16: the key \"a\" occurs twice"),
    (
        "eig",
        r#"{"a": 3}"#,
        2,
        "line 1, column 7: invalid type: integer `3`, expected the matrix \"a\" as a list of its rows, such as [[1, 2], [3, 4]] or [[1]]",
    ),
    (
        "eig",
        r#"{"a": [1, 2]}"#,
        2,
        "line 1, column 8: invalid type: integer `1`, expected row 1 of the matrix \"a\" as a list (a column is [[1], [2]], a row is [[1, 2]])",
    ),
    (
        "eig",
        r#"{"a": [[1, 2], [3]]}"#,
        2,
        "line 1, column 19: row 2 of the matrix \"a\" has length 1, and row 1 has length 2",
    ),
    ("eig", r#"{"a": []}"#, 2, "line 1, column 8: the matrix \"a\" is empty (0 x 0)"),
    ("eig", r#"{"a": [[], []]}"#, 2, "line 1, column 14: the matrix \"a\" is empty (2 x 0)"),
    ("eig", r#"{"a": [[1, null], [0, 1]]}"#, 2, "line 1, column 15: invalid type: null, expected a number for a(1, 2)"),
    (
        "eig",
        r#"{"a": [[1, "2"], [0, 1]]}"#,
        2,
        "line 1, column 14: invalid type: string \"2\", expected a number for a(1, 2)",
    ),
    ("eig", r#"{"a": [[true]]}"#, 2, "line 1, column 12: invalid type: boolean `true`, expected a number for a(1, 1)"),
    ("eig", r#"{"a": [[NaN]]}"#, 2, "line 1, column 9: NaN is not a JSON number, and every entry must be finite"),
    (
        "eig",
        "{\"a\": [[1,\n Infinity]]}",
        2,
        "line 2, column 2: Infinity is not a JSON number, and every entry must be finite",
    ),
    (
        "eig",
        r#"{"a": [[-Infinity]]}"#,
        2,
        "line 1, column 10: -Infinity is not a JSON number, and every entry must be finite",
    ),
    ("eig", r#"{"a": [[1e999]]}"#, 2, "line 1, column 13: number out of range"),
    ("eig", r#"{"a": [[1, 2]]}"#, 2, "A must be square, found 1 x 2"),
    ("lyap", r#"{"a": [[0, 1], [-2, -3]], "q": [[1]]}"#, 2, "Q must be 2 x 2, found 1 x 1"),
    (
        "lyap",
        r#"{"a": [[-1, 0], [0, -2]], "q": [[1, 2], [3, 4]]}"#,
        2,
        "Q is not symmetric: entries (2, 1) and (1, 2) differ by 1 (limit ",
    ),
    ("sylv", r#"{"a": [[1]], "b": [[1, 0], [0, 1]], "q": [[1]]}"#, 2, "Q must be 1 x 2, found 1 x 1"),
    ("care", r#"{"a": [[1]], "b": [[1], [2]], "q": [[1]], "r": [[1]]}"#, 2, "B must be 1 x 1, found 2 x 1"),
    (
        "care",
        r#"{"a": [[1]], "b": [[1]], "q": [[1]], "r": [[-1]]}"#,
        1,
        "no stabilizing solution was found, although A has no eigenvalue that prevents one: with an indefinite Q or R there may be none",
    ),
    (
        "dare",
        r#"{"a": [[1]], "b": [[1]], "q": [[-1]], "r": [[1]]}"#,
        1,
        "no stabilizing solution was found, although A has no eigenvalue that prevents one: with an indefinite Q or R there may be none",
    ),
    ("obsv", r#"{"a": [[1]], "c": [[1, 2]]}"#, 2, "C must be 1 x 1, found 1 x 2"),
    ("place", r#"{"a": [[1]], "b": [[1]], "poles": [-1, -2]}"#, 2, "a plant of order 1 needs 1 poles, and 2 are given"),
    (
        "place",
        r#"{"a": [[1]], "b": [[1]], "poles": [[-1, 2]]}"#,
        2,
        "the poles are not closed under conjugation: -1 + 2i has no conjugate",
    ),
    (
        "place",
        r#"{"a": [[1]], "b": [[1]], "poles": [[-1]]}"#,
        2,
        "line 1, column 39: pole 1 must be a number or [re, im]",
    ),
    (
        "place",
        r#"{"a": [[1]], "b": [[1]], "poles": [[1, 2, 3]]}"#,
        2,
        "line 1, column 44: pole 1 must be a number or [re, im]",
    ),
    (
        "place",
        r#"{"a": [[1]], "b": [[1]], "poles": ["fast"]}"#,
        2,
        "line 1, column 41: invalid type: string \"fast\", expected a number or [re, im] for pole 1",
    ),
    (
        "place",
        r#"{"a": [[1]], "b": [[1]], "poles": -1}"#,
        2,
        "line 1, column 36: invalid type: integer `-1`, expected the list of \"poles\", such as [-1, -2] or [[-1, 2], [-1, -2]]",
    ),
    ("place", r#"{"a": [[1, 0], [0, 2]], "b": [[1, 0], [0, 1]], "poles": [-1, -1]}"#, 0, ""),
    // The controller's keys and the observer's.
    (
        "place",
        r#"{"a": [[1]], "b": [[1]], "c": [[1]], "poles": [-1]}"#,
        2,
        "line 1, column 51: the keys \"b\" and \"c\" exclude each other (known: \"a\", \"b\", \"pattern\", \"poles\" or \"a\", \"c\", \"pattern\", \"poles\")",
    ),
    (
        "place",
        r#"{"a": [[1]], "poles": [-1]}"#,
        2,
        "line 1, column 27: the key \"b\" or \"c\" is missing (known: \"a\", \"b\", \"pattern\", \"poles\" or \"a\", \"c\", \"pattern\", \"poles\")",
    ),
    (
        "place",
        r#"{"c": [[1]], "poles": [-1]}"#,
        2,
        "line 1, column 27: the key \"a\" is missing (known: \"a\", \"c\", \"pattern\", \"poles\")",
    ),
    (
        "place",
        r#"{"a": [[1]], "c": [[1]]}"#,
        2,
        "line 1, column 24: the key \"poles\" is missing (known: \"a\", \"c\", \"pattern\", \"poles\")",
    ),
    ("place", r#"{"a": [[1]], "c": [[1], [NaN]], "poles": [-1]}"#, 2, "line 1, column 26: NaN is not a JSON number"),
    ("place", r#"{"a": [[1]], "c": [[1, 2]], "poles": [-1]}"#, 2, "C must be 1 x 1, found 1 x 2"),
    (
        "care",
        "{}",
        2,
        "line 1, column 2: the key \"a\" is missing (known: \"a\", \"b\", \"q\", \"r\", \"s\", \"e\" or \"a\", \"c\", \"w\", \"v\", \"g\", \"s\")",
    ),
    (
        "care",
        r#"{"a": [[1]], "c": [[1]], "q": [[1]], "r": [[1]]}"#,
        2,
        "line 1, column 48: the key \"q\" does not belong to the problem with \"c\", whose keys are \"a\", \"c\", \"w\", \"v\", \"g\", \"s\"",
    ),
    (
        "dare",
        r#"{"a": [[1]], "b": [[1]], "w": [[1]], "v": [[1]]}"#,
        2,
        "line 1, column 48: the key \"w\" does not belong to the problem with \"b\", whose keys are \"a\", \"b\", \"q\", \"r\", \"s\", \"e\"",
    ),
    (
        "dare",
        r#"{"a": [[1]], "c": [[1]], "w": [[1]]}"#,
        2,
        "line 1, column 36: the key \"v\" is missing (known: \"a\", \"c\", \"w\", \"v\", \"g\", \"s\")",
    ),
    ("care", r#"{"a": [[1]], "c": [[1], [2]], "w": [[1]], "v": [[1]]}"#, 2, "V must be 2 x 2, found 1 x 1"),
    (
        "care",
        r#"{"a": [[1]], "c": [[1]], "w": [[-1]], "v": [[1]]}"#,
        2,
        "W is not positive semidefinite: its smallest eigenvalue is -1",
    ),
    (
        "dare",
        r#"{"a": [[1]], "c": [[1]], "w": [[1]], "v": [[-1]]}"#,
        2,
        "V is not positive definite: its smallest eigenvalue is -1",
    ),
    (
        "dare",
        r#"{"a": [[1]], "c": [[1]], "w": [[1]], "v": [[1]], "s": [[1.1]]}"#,
        2,
        "the joint covariance [W, S; S', V] is not positive semidefinite: its smallest eigenvalue is ",
    ),
    ("care", r#"{"a": [[1]], "c": [[1]], "w": [[1]], "v": [[1]], "g": [[1, 0]]}"#, 2, "G must be 1 x 1, found 1 x 2"),
    (
        "care",
        r#"{"a": [[1]], "c": [[1]], "w": [[1]], "v": [[1]], "g": [[1]], "s": [[1, 0]]}"#,
        2,
        "S must be 1 x 1, found 1 x 2",
    ),
    (
        "place",
        r#"{"a": [[1]], "b": [[1]], "poles": [-1], "pattern": [[1, 0]]}"#,
        2,
        "the pattern of K must be 1 x 1, found 1 x 2",
    ),
    // Valid input with a negative answer.
    (
        "place",
        r#"{"a": [[1, 0], [0, 2]], "c": [[1, 0], [0, 1]], "poles": [-1, -2], "pattern": [[1, 0], [0, 0]]}"#,
        1,
        "to working precision no gain with these zeros moves the eigenvalue 2: the nearest specified pole is 3 away",
    ),
    (
        "lyap",
        r#"{"a": [[1, 0], [0, -1]], "q": [[1, 0], [0, 1]]}"#,
        1,
        "the Lyapunov equation is singular for the data as stored: eigenvalues 1 and -1",
    ),
    ("dlyap", r#"{"a": [[1]], "q": [[1]]}"#, 1, "the Stein equation is singular for the data as stored"),
    (
        "sylv",
        r#"{"a": [[1]], "b": [[-1]], "q": [[1]]}"#,
        1,
        "the Sylvester equation is singular for the data as stored",
    ),
    (
        "care",
        r#"{"a": [[1]], "b": [[0]], "q": [[1]], "r": [[1]]}"#,
        1,
        "the pair (A, B) is not stabilizable to working precision: uncontrollable eigenvalue 1",
    ),
    (
        "dare",
        r#"{"a": [[1]], "b": [[1]], "q": [[0]], "r": [[1]]}"#,
        1,
        "to working precision the weight Q does not see the eigenvalue 1 on the stability boundary",
    ),
    (
        "place",
        r#"{"a": [[1]], "b": [[0]], "poles": [-1]}"#,
        1,
        "the pair (A, B) is not controllable to working precision: uncontrollable eigenvalue 1",
    ),
    (
        "place",
        r#"{"a": [[-1, 0], [0, 2]], "c": [[1, 0]], "poles": [-3, -4]}"#,
        1,
        "the pair (A, C) is not observable to working precision: unobservable eigenvalue 2",
    ),
    (
        "care",
        r#"{"a": [[1]], "c": [[0]], "w": [[1]], "v": [[1]]}"#,
        1,
        "the pair (A, C) is not detectable to working precision: unobservable eigenvalue 1",
    ),
    (
        "dare",
        r#"{"a": [[1]], "c": [[1]], "w": [[0]], "v": [[1]]}"#,
        1,
        "to working precision the process noise W does not excite the eigenvalue 1 on the stability boundary, PBH margin of (A, W) 0",
    ),
];

#[test]
fn each_mistake_has_its_sentence_and_its_exit_code() {
    for (command, input, code, sentence) in MISTAKES {
        let ran = luenberger(&[command, "-"], input);
        assert_eq!(ran.code, Some(*code), "{command} {input}: {ran:?}");
        if *code == 0 {
            assert_eq!(ran.stderr, "");
            continue;
        }
        assert_eq!(ran.stdout, "", "{command} {input}");
        let expected = format!("error: standard input: {sentence}");
        assert!(ran.stderr.starts_with(&expected), "{command} {input}:\n{}{expected}", ran.stderr);
    }
}

#[test]
fn with_json_a_mistake_is_an_object_as_well() {
    for (command, input, code, sentence) in MISTAKES.iter().filter(|mistake| mistake.2 != 0) {
        let ran = luenberger(&[command, "-", "--json"], input);
        assert_eq!(ran.code, Some(*code), "{command} {input}");
        let error = &ran.json()["error"];
        let message = error["message"].as_str().unwrap();
        assert!(message.contains(sentence), "{command} {input}: {message}");
        let kind = if *code == 1 {
            "no-solution"
        } else if sentence.starts_with("line") {
            "syntax"
        } else {
            "data"
        };
        assert_eq!(error["kind"], kind, "{command} {input}");
        if kind == "syntax" {
            let place = format!("line {}, column {}: ", error["line"], error["column"]);
            assert!(sentence.starts_with(&place), "{place} {sentence}");
        }
    }
}

#[test]
fn nesting_without_end_is_refused_at_once() {
    for opening in ["[", "{\"a\":"] {
        let ran = luenberger(&["eig", "-"], format!("{{\"a\": {}", opening.repeat(1_000_000)));
        assert_eq!(ran.code, Some(2));
        assert!(ran.stderr.contains("line 1, column"), "{}", ran.stderr);
    }
}

#[test]
fn bytes_that_are_no_text_are_located() {
    let ran = luenberger(&["eig", "-"], b"{\"a\":\n [[1, \xff]]}");
    assert_eq!(ran.code, Some(2));
    assert_eq!(ran.stderr, "error: standard input: line 2, column 7: byte 13 of the input, 0xff, is not UTF-8\n");
    // The byte order mark that Windows puts before a text is ignored.
    assert_eq!(luenberger(&["eig", "-"], "\u{feff}{\"a\": [[1]]}").code, Some(0));
}

#[test]
fn a_file_that_is_not_there_is_named() {
    let folder = folder("no-file");
    let path = folder.join("plant.json");
    let path = path.to_str().unwrap();
    for command in ["eig", "sdp"] {
        let ran = luenberger(&[command, path], "");
        assert_eq!(ran.code, Some(2));
        assert!(ran.stderr.starts_with(&format!("error: {path} cannot be read: ")), "{}", ran.stderr);
        let ran = luenberger(&[command, path, "--json"], "");
        assert_eq!(ran.json()["error"]["kind"], "file");
    }
    let ran = luenberger(&["eig", folder.to_str().unwrap()], "");
    assert!(ran.code == Some(2) && ran.stderr.contains("cannot be read"), "{ran:?}");
}

#[test]
fn wrong_usage_is_explained() {
    let is_usage = |ran: &Ran, words: &str| {
        assert_eq!(ran.code, Some(2));
        assert!(ran.stderr.contains(words), "{}", ran.stderr);
    };
    is_usage(&luenberger(&[], ""), "Usage: luenberger");
    is_usage(&luenberger(&["lyup"], ""), "'lyap'");
    is_usage(&luenberger(&["lyap"], ""), "<FILE>");
    is_usage(&luenberger(&["lyap", "-", "--jsn"], ""), "'--json'");
    let ran = luenberger(&["lyap", "--json"], "");
    is_usage(&ran, "<FILE>");
    assert_eq!(ran.json()["error"]["kind"], "usage");
}
