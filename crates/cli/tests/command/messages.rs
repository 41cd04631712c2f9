//! Every message of the command apart from those of studies, in one reviewed file, `tests/messages.txt`.
//!
//! Run with `UPDATE=1` in the environment after an intended change, and read the difference. Numbers are not compared.

use crate::mistakes::MISTAKES;
use crate::terminal::{folder, luenberger};
use std::fmt::Write;
use std::path::Path;

/// Arguments, and the text on standard input.
const COMMANDS: &[(&[&str], &str)] = &[
    (&["c2d", "-"], r#"{"a": [[1]], "b": [[1]]}"#),
    (&["c2d", "-", "--period", "0"], r#"{"a": [[1]], "b": [[1]]}"#),
    (&["c2d", "-", "--period", "0.1", "--prewarp", "1"], r#"{"a": [[1]], "b": [[1]]}"#),
    (&["c2d", "-", "--period", "0.1", "--method", "tustin", "--prewarp", "100"], r#"{"a": [[1]], "b": [[1]]}"#),
    (&["c2d", "-", "--period", "0.1", "--method", "tustin"], r#"{"a": [[20]], "b": [[1]]}"#),
    (&["c2d", "-", "--period", "0.1", "--method", "matched"], r#"{"a": [[1, 0], [0, 1]], "b": [[1], [1]]}"#),
    (&["c2d", "-", "--period", "0.1", "--delay", "0.1", "--method", "foh"], r#"{"a": [[1]], "b": [[1]]}"#),
    (&["c2d", "-", "--period", "0.1", "--delay", "-0.1"], r#"{"a": [[1]], "b": [[1]]}"#),
    (&["c2d", "-", "--period", "0.1", "--delay", "0.1,0.2"], r#"{"a": [[1]], "b": [[1]]}"#),
    (&["c2d", "-", "--period", "0.1", "--output-delay", "0.1,0.2"], r#"{"a": [[1]], "b": [[1]]}"#),
    (&["bode", "-"], r#"{"a": [[1]], "c": [[1]]}"#),
    (&["bode", "-", "--period", "0"], r#"{"a": [[1]], "c": [[1]], "b": [[1]]}"#),
    (&["bode", "-", "--from", "-1"], r#"{"a": [[1]], "c": [[1]], "b": [[1]]}"#),
    (&["bode", "-", "--from", "2", "--to", "1"], r#"{"a": [[1]], "c": [[1]], "b": [[1]]}"#),
    (&["bode", "-", "--period", "1", "--to", "4"], r#"{"a": [[1]], "c": [[1]], "b": [[1]]}"#),
    (&["bode", "-", "--points", "1"], r#"{"a": [[1]], "c": [[1]], "b": [[1]]}"#),
    (&["bode", "-"], r#"{"a": [[1]], "c": [[1]], "b": [[1]], "l": [[1, 1]]}"#),
    (&["bode", "-"], r#"{"a": [[1]], "c": [[1]], "b": [[1]], "k": [[1], [1]]}"#),
    (&["obsv", "-", "--tolerance", "-1"], r#"{"a": [[1]], "c": [[1]]}"#),
    (&["place", "-"], r#"{"a": [[1]], "b": [[1]], "poles": [-1], "pattern": [[2]]}"#),
    (&["d2c", "-", "--period", "0.1"], r#"{"a": [[-0.5]], "b": [[1]]}"#),
    (&["d2c", "-", "--period", "0.1", "--method", "matched"], r#"{"a": [[0.5]], "b": [[1]]}"#),
    (&["noise", "--period", "0.1"], ""),
    (&["noise", "-", "--period", "0.1"], r#"{"w": [[1]]}"#),
    (&["noise", "-", "--period", "0.1"], r#"{"a": [[1]]}"#),
    (&["noise", "-", "--period", "0.1"], r#"{"r": [[1]], "v": [[1]]}"#),
    (&["noise", "-", "--period", "0.1"], r#"{"a": [[1]], "w": [[1]], "qd": [[1]]}"#),
    (&["noise", "-", "--period", "0.1"], r#"{"r": [[-1]]}"#),
    (&["noise", "-", "--period", "0.1"], r#"{"v": [[1, 2], [2, 1]]}"#),
    (&["noise", "-", "--period", "0.1"], r#"{"a": [[0, 1], [0, 0]], "w": [[1, 2], [2, 1]]}"#),
    (&["noise", "-", "--period", "0.1"], r#"{"a": [[0, 1], [0, 0]], "qd": [[1, 2], [2, 1]]}"#),
    (
        &["noise", "-", "--period", "1"],
        r#"{"a": [[0, 3.141592653589793], [-3.141592653589793, 0]], "qd": [[1, 0], [0, 1]]}"#,
    ),
    (&["poles", "--order", "0", "--settling", "1"], ""),
    (&["poles", "--order", "2", "--settling", "-1"], ""),
    (&["poles", "--order", "2", "--settling", "1", "--damping", "2"], ""),
    (&["poles", "--order", "2", "--settling", "1", "--damping", "-2"], ""),
    (&["poles", "--order", "2", "--settling", "1", "--ratio", "-2"], ""),
    (&["noise", "--period", "0.1", "--sigma", "-1"], ""),
    (&["noise", "--period", "-0.1", "--sigma", "1"], ""),
    (&["poles", "--order", "2", "--settling", "1", "--overshoot", "5"], ""),
    (&["poles", "--order", "9", "--settling", "1", "--pattern", "itae"], ""),
    (&["poles", "--order", "2", "--settling", "1", "--pattern", "bessel", "--damping", "0.7"], ""),
    (&["new", "--plant", "cukk", "-o", "-"], ""),
    (&["run", "absent.toml"], ""),
    (&["run", "-", "--limit", "4GiB"], ""),
    (&["run", "-", "--threads", "0"], ""),
    (&["sweep", "-"], "[plant]\nbuiltin = \"cuk\"\n"),
    (&["verify", "-"], "nonsense"),
    (&["observe", "-"], "[plant]\na = [[-1, 0], [0, -2]]\nc = [[1, 0]]\n"),
    (&["observe", "-"], "[plant]\na = [[-1, 0], [0, 2]]\nc = [[1, 0]]\n"),
    (
        &["design", "-"],
        "[plant]\na = [[-1, 0], [0, 2]]\nc = [[1, 0]]\n[[observer]]\nkind = \"luenberger\"\nlmi = true\n",
    ),
];

/// The text with every number replaced by `#`.
fn without_numbers(text: &str) -> String {
    let mut kept = String::new();
    let (mut inside, mut before) = (false, ' ');
    for c in text.chars() {
        let starts = c.is_ascii_digit() && !before.is_alphanumeric();
        inside = starts || (inside && (c.is_ascii_digit() || ".e-".contains(c)));
        match (inside, starts) {
            (true, true) if !kept.ends_with('#') => kept.push('#'),
            (true, _) => {}
            (false, _) => kept.push(c),
        }
        before = c;
    }
    kept
}

#[test]
fn every_message_stands_in_the_reviewed_file() {
    let mut text = String::new();
    for (command, input, ..) in MISTAKES {
        let said = luenberger(&[command, "-"], input).stderr;
        text.push_str(said.strip_prefix("error: standard input: ").unwrap_or(&said));
    }
    for (arguments, input) in COMMANDS {
        let ran = luenberger(arguments, input);
        _ = write!(text, "\n$ luenberger {}\n{}{}", arguments.join(" "), ran.stdout, ran.stderr);
    }
    text.push_str(&crate::file_messages::all());
    let there = folder("messages").join("study.toml");
    std::fs::write(&there, "").unwrap();
    let there = there.to_str().unwrap();
    text.push_str(&luenberger(&["new", "-o", there], "").stderr.replace(there, "study.toml"));
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/messages.txt");
    if std::env::var_os("UPDATE").is_some() {
        std::fs::write(&path, &text).unwrap();
        return;
    }
    let golden = std::fs::read_to_string(path).unwrap();
    for (found, expected) in text.lines().zip(golden.lines()) {
        assert_eq!(without_numbers(found), without_numbers(expected), "run with UPDATE=1 and read the difference");
    }
    assert_eq!(text.lines().count(), golden.lines().count(), "run with UPDATE=1 and read the difference");
}
