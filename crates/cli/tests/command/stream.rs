//! `luenberger stream`: answers at once, saved states, and how it ends.

use crate::terminal::{Ran, folder, luenberger};
use std::io::{BufRead, BufReader, Read, Write};
use std::path::PathBuf;
use std::process::{Child, Command, Stdio};

const STUDY: &str = "[plant]
states = [\"level\"]
inputs = [\"pump\"]
outputs = [\"gauge\"]
a = [[1]]
b = [[0.5]]
c = [[1]]
dt = 0.5
[[observer]]
name = \"copy\"
kind = \"luenberger\"
poles = [0.5]
";

/// A folder with the study, and the path of the study.
fn bench(name: &str) -> (PathBuf, String) {
    let folder = folder(&format!("stream-{name}"));
    let file = folder.join("study.toml");
    std::fs::write(&file, STUDY).unwrap();
    (folder, file.to_str().unwrap().to_owned())
}

/// Rows of a level that rises, from sample `from` on.
fn rows(from: u32, to: u32) -> String {
    let row = |k: u32| format!("{},0.25,{}\n", 0.5 * f64::from(k), 0.125 * f64::from(k));
    std::iter::once("t,pump,gauge\n".to_owned()).chain((from..to).map(row)).collect()
}

fn started(arguments: &[&str]) -> Child {
    Command::new(env!("CARGO_BIN_EXE_luenberger"))
        .arg("stream")
        .args(arguments)
        .stdin(Stdio::piped())
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .unwrap()
}

/// The end of a process whose streams are no longer needed.
fn ended(mut child: Child) -> Ran {
    let mut stderr = String::new();
    let code = child.wait().unwrap().code();
    child.stderr.take().unwrap().read_to_string(&mut stderr).unwrap();
    Ran { code, stdout: String::new(), stderr }
}

/// Each row is answered before the next one is there; the end of the input is the end.
#[test]
fn a_row_is_answered_at_once() {
    let (_, study) = bench("live");
    let mut child = started(&[&study]);
    let mut input = child.stdin.take().unwrap();
    let mut output = BufReader::new(child.stdout.take().unwrap());
    let mut answer = || {
        let mut line = String::new();
        output.read_line(&mut line).unwrap();
        line
    };
    input.write_all(b"t,pump,gauge\n").unwrap();
    assert_eq!(answer(), "t,level_hat\n");
    // xhat+ = xhat + 0.5 u + 0.5 (y - xhat).
    let mut xhat = 0.0;
    for k in 0..5 {
        let (u, y) = (0.25, f64::from(k));
        writeln!(input, "{},{u},{y}", 0.5 * f64::from(k)).unwrap();
        xhat = xhat + 0.5 * u + 0.5 * (y - xhat);
        assert_eq!(answer(), format!("{},{xhat}\n", 0.5 * f64::from(k + 1)));
    }
    drop(input);
    assert_eq!(answer(), "");
    let ran = ended(child);
    assert_eq!((ran.code, ran.stderr.as_str()), (Some(0), ""));
}

/// A reader that has seen enough, as `head`: no error, and the state is that of what it was given.
#[test]
fn a_closed_output_is_the_end() {
    let (folder, study) = bench("closed");
    let state = folder.join("state").to_str().unwrap().to_owned();
    let mut child = started(&[&study, "--state", &state]);
    drop(child.stdout.take());
    let mut input = child.stdin.take().unwrap();
    // More than a pipe holds; nobody reads it to its end.
    _ = input.write_all(rows(0, 100_000).as_bytes());
    drop(input);
    let ran = ended(child);
    assert_eq!((ran.code, ran.stderr.as_str()), (Some(0), ""));
    let saved = std::fs::read_to_string(&state).unwrap();
    assert!(saved.contains("\"samples\":0,"), "nothing was delivered: {saved}");
}

/// The state that one process leaves is where the next one goes on.
#[test]
fn a_stream_goes_on_from_its_state() {
    let (folder, study) = bench("state");
    let state = folder.join("state").to_str().unwrap().to_owned();
    let whole = luenberger(&["stream", &study], rows(0, 2500));
    assert_eq!((whole.code, whole.stderr.as_str()), (Some(0), ""));
    let first = luenberger(&["stream", &study, "--state", &state], rows(0, 1234));
    let second = luenberger(&["stream", &study, "--state", &state], rows(1234, 2500));
    assert_eq!((first.code, second.code), (Some(0), Some(0)));
    assert_eq!(second.stderr, format!("note: goes on from {state} after 1234 samples\n"));
    let rest = second.stdout.strip_prefix("t,level_hat\n").unwrap();
    assert_eq!(format!("{}{rest}", first.stdout), whole.stdout);
    let saved = std::fs::read_to_string(&state).unwrap();
    for (damaged, message) in [
        (saved[..saved.len() / 2].to_owned(), "it is no saved state of a stream, or only a part of one"),
        (
            saved.replace("\"samples\":2500", "\"samples\":2501"),
            "its content is not what was saved: its digest differs",
        ),
    ] {
        std::fs::write(&state, &damaged).unwrap();
        let ran = luenberger(&["stream", &study, "--state", &state, "--json"], rows(2500, 2510));
        let expected = format!("{state}: {message}. The file is as it was; without it the stream begins anew");
        assert_eq!((ran.code, ran.stderr), (Some(2), format!("error: {expected}\n")));
        let error: serde_json::Value = serde_json::from_str(&ran.stdout).unwrap();
        assert_eq!((&error["error"]["kind"], &error["error"]["message"]), (&"data".into(), &expected.into()));
        assert_eq!(std::fs::read_to_string(&state).unwrap(), damaged);
    }
    // Another study, and a state that cannot be written.
    std::fs::write(&state, &saved).unwrap();
    std::fs::write(&study, STUDY.replace("0.5]\n", "0.25]\n")).unwrap();
    let ran = luenberger(&["stream", &study, "--state", &state], rows(2500, 2510));
    assert!(ran.code == Some(2) && ran.stderr.contains("it was saved by another study"), "{ran:?}");
    let nowhere = folder.join("none/state").to_str().unwrap().to_owned();
    let ran = luenberger(&["stream", &study, "--state", &nowhere], rows(0, 3));
    assert_eq!((ran.code, ran.stdout.as_str()), (Some(2), ""), "{ran:?}");
    assert!(ran.stderr.starts_with(&format!("error: {nowhere} cannot be written: ")), "{ran:?}");
}

/// Ctrl-C while no row arrives: exit code 130, and the state is that of the last answer.
#[cfg(unix)]
#[test]
fn an_interrupted_stream_saves_its_state() {
    let (folder, study) = bench("interrupt");
    let state = folder.join("state").to_str().unwrap().to_owned();
    let mut child = started(&[&study, "--state", &state]);
    let mut input = child.stdin.take().unwrap();
    input.write_all(rows(0, 3).as_bytes()).unwrap();
    let mut output = BufReader::new(child.stdout.take().unwrap());
    for _ in 0..4 {
        assert!(output.read_line(&mut String::new()).unwrap() > 0);
    }
    assert!(Command::new("kill").args(["-INT", &child.id().to_string()]).status().unwrap().success());
    let ran = ended(child);
    drop(input);
    assert_eq!(ran.code, Some(130), "{ran:?}");
    assert!(std::fs::read_to_string(&state).unwrap().contains("\"samples\":3,"));
}

/// Rows that cannot be used: passed over and counted, or the end.
#[test]
fn rows_that_cannot_be_used_are_said() {
    let (_, study) = bench("refused");
    let bad = rows(0, 2) + &"x,0,0\n".repeat(30) + "1,0.25,0.25\n";
    let ran = luenberger(&["stream", &study], &bad);
    assert_eq!((ran.code, ran.stdout.lines().count()), (Some(0), 4));
    let lines: Vec<&str> = ran.stderr.lines().collect();
    assert_eq!(lines.len(), 22, "{}", ran.stderr);
    assert_eq!(lines[0], "passed over: line 4, column 1 (t): expected a number, found `x`");
    assert_eq!(lines[20..], ["further rows that cannot be used are only counted", "note: 30 of 34 lines passed over"]);
    assert_eq!(luenberger(&["stream", &study, "-q"], &bad).stderr, "");
    let strict = luenberger(&["stream", &study, "--strict"], &bad);
    assert_eq!((strict.code, strict.stdout.lines().count()), (Some(2), 3));
    assert_eq!(strict.stderr, "error: line 4, column 1 (t): expected a number, found `x`\n");
    let long = format!("t,pump,gauge\n0,0.25,0.25{}\n0,0.25,0.25\n", " ".repeat(2 << 20));
    let ran = luenberger(&["stream", &study], &long);
    assert_eq!(ran.stderr.lines().next(), Some("passed over: line 2 is longer than 1048576 bytes"));
    assert_eq!(ran.stdout, "t,level_hat\n0.5,0.25\n");
    let header = luenberger(&["stream", &study], "t,pump,gage\n0,0,0\n");
    assert_eq!((header.code, header.stdout.as_str()), (Some(2), ""));
    assert_eq!(header.stderr, "error: there is no column `gauge`; did you mean `gage`?\n");
    let other = luenberger(&["stream", &study, "--format", "json"], "t,pump,gauge\n0,0.25,0.25\n");
    assert_eq!((other.code, other.stdout.as_str()), (Some(2), ""));
    let lines: Vec<&str> = other.stderr.lines().collect();
    let first = "passed over: line 1: expected a JSON object such as {\"t\": 0.1, \"y\": 2}: it begins with `t,pump,gauge`; the form of rows of CSV is csv";
    assert_eq!((lines[0], lines[2]), (first, "error: no row could be used: 2 lines passed over"), "{lines:?}");
    let none = luenberger(&["stream", &study], "t,pump,gauge\nx,0.25,0.25\n");
    assert_eq!((none.code, none.stdout.as_str()), (Some(2), "t,level_hat\n"));
    let empty = luenberger(&["stream", &study], "");
    assert_eq!((empty.code, empty.stdout.as_str(), empty.stderr.as_str()), (Some(0), "", ""));
    let standard = luenberger(&["stream", "-"], STUDY);
    assert_eq!(
        (standard.code, standard.stderr.as_str()),
        (Some(2), "error: the study is read from a file: standard input has the rows\n")
    );
    let unseen = luenberger(&["stream", &study], "{\"t\": 0, \"pump\": 1}\n");
    assert_eq!(unseen.stderr, "note: `gauge` did not occur in any row\n");
}
